"""References for the promise on force_error: forces along ordinary scenes, by another tree.

`answers.npz` beside this file holds what commit ee6a1b9 answered at its tightest to the scenes that
have no closed form. To write it, make a `git worktree` of that commit and run there, with the
`tests` of this tree on the path:

    PYTHONPATH=.:THIS/tests python -m promise.references write FILE.npz [seed] [first] [last]
    PYTHONPATH=.:THIS/tests python -m promise.references join FILE.npz PART.npz PART.npz ...
"""

from __future__ import annotations

import signal
import sys
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

import origins
from promise.draw import Draw, Scene
from promise.kinds import KINDS

Array = npt.NDArray[np.float64]

SEED = 20100902
ANSWERS = Path(__file__).parent / "answers.npz"
KEPT = 12  # points of a path whose forces are kept
LONGEST = 25  # s for one answer
# Tolerances, as shares of that of the scene, that are asked one after the other until an answer
# comes in time; and the least, in mean thresholds.
SHARES, LEAST = (1e-9, 1e-3, 0.1), 1e-12


class Reference(NamedTuple):
    """Forces at some points of the path, in mean thresholds, and the error claimed for them.

    An infinite claim is that of a scene that was refused, or took too long.
    """

    force: Array
    claim: float


def scene(number: int, seed: int = SEED) -> Scene:
    """Ordinary scene number so and so: the kinds in turn."""
    return KINDS[number % len(KINDS)](Draw(seed, number))


def kept(path: Array) -> npt.NDArray[np.intp]:
    """Which points of a path are compared: the first and the last among them."""
    points = np.linspace(0, path.size - 1, KEPT)
    return np.unique(np.round(points).astype(np.intp))


def tightest(asked: Scene) -> Reference:
    """The answer of the tree that runs this with the smallest error in reasonable time."""

    def stop(*_: object) -> None:
        raise TimeoutError

    signal.signal(signal.SIGALRM, stop)
    best, mean = Reference(np.empty(0), np.inf), asked.contacts.mean_threshold
    for share in SHARES:
        signal.alarm(LONGEST)
        try:
            found = asked.solve(max(share * asked.tolerance, LEAST))
        except (origins.InputError, TimeoutError):
            continue
        finally:
            signal.alarm(0)
        if found.force.size == asked.path.size and found.force_error < best.claim:
            best = Reference(found.force[kept(asked.path)] / mean, float(found.force_error))
        if found.success:
            break
    return best


def save(file: str | Path, references: Mapping[int, Reference], seed: int) -> None:
    """Write references by the number of the scene."""
    np.savez_compressed(
        file,
        seed=np.array(seed),
        numbers=np.array(list(references)),
        sizes=np.array([one.force.size for one in references.values()]),
        claims=np.array([one.claim for one in references.values()]),
        forces=np.concatenate([one.force for one in references.values()]),
    )


def load(file: str | Path = ANSWERS) -> dict[int, Reference]:
    """Read what `save` wrote."""
    with np.load(file) as arrays:
        forces = np.split(arrays["forces"], np.cumsum(arrays["sizes"])[:-1])
        rows = zip(arrays["numbers"].tolist(), forces, arrays["claims"].tolist(), strict=True)
        return {number: Reference(force, claim) for number, force, claim in rows}


def main(words: Sequence[str]) -> None:
    """Do what the command line says."""
    verb, file, *rest = words
    found: dict[int, Reference] = {}
    if verb == "join":
        for part in rest:
            found |= load(part)
        save(file, dict(sorted(found.items())), SEED)
        return
    seed, first, last = [*map(int, rest), *(SEED, 0, 1000)[len(rest) :]]
    warnings.simplefilter("ignore")
    for number in range(first, last):
        asked = scene(number, seed)
        if asked.exact is None:
            found[number] = tightest(asked)
            print(number, KINDS[number % len(KINDS)].__name__, found[number].claim, flush=True)
    save(file, found, seed)


if __name__ == "__main__":
    main(sys.argv[1:])
