"""References for the promise on force_error: what commit ee6a1b9 answered at its tightest to the
scenes that have no closed form (`answers.npz`)."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from promise.draw import Draw, Scene
from promise.kinds import KINDS

Array = npt.NDArray[np.float64]
SEED = 20100902
ANSWERS = Path(__file__).parent / "answers.npz"
KEPT = 12  # points of a path whose forces are kept


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


def load(file: str | Path = ANSWERS) -> dict[int, Reference]:
    """The kept references by the number of the scene."""
    with np.load(file) as arrays:
        forces = np.split(arrays["forces"], np.cumsum(arrays["sizes"])[:-1])
        rows = zip(arrays["numbers"].tolist(), forces, arrays["claims"].tolist(), strict=True)
        return {number: Reference(force, claim) for number, force, claim in rows}
