"""A run's checkpoint in its output folder: the results of each rank's finished blocks, and the identity of the run.

Each rank replaces its own file. A run that continues, on any number of ranks, first merges all results into rank 0's
file and removes the others. Files list the blocks that they contain, so that none counts twice.
"""

import json
import os
import sys
import time
import tomllib
from collections.abc import Iterator
from contextlib import suppress
from hashlib import sha256
from io import BytesIO
from itertools import pairwise
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from origins.errors import InputError, positive
from origins.thresholds.law import Thresholds
from toolkit.processes.ranks import on_root
from toolkit.results.folders import read_sealed, write_sealed
from toolkit.scene.scene import Scene
from toolkit.scene.tables import read_table
from toolkit.version import __version__

EVERY = 60.0  # seconds: little is lost, and the disk is not overloaded
_BESIDE = (
    "title",
    "master",
    "eq.wall_time",
    "eq.threads",
    "wall_time",
)  # without effect on eq's numbers


class Checkpoint:
    """The checkpoint of one scene's ensemble in `folder`/checkpoint; nothing is written before its first `every` s, nor
    sooner after the last. Another scene's is refused. `comm` is mpi4py's communicator, None for this process alone."""

    def __init__(
        self, folder: str | os.PathLike[str], scene: Scene, comm: Any = None, every: float = EVERY
    ) -> None:
        self.every = positive("checkpoint", every)
        self.folder = Path(folder)
        self._home, self._comm = self.folder / "checkpoint", comm
        self._rank = 0 if comm is None else comm.Get_rank()
        self._file = self._home / f"000-rank-{self._rank:05d}.npz"
        self._identity = identity(scene)
        self._last, self._refused = time.monotonic(), ""
        self._written: list[range] | None = None

    @property
    def note(self) -> str:
        """What is on the disk if the run ends here, in words."""
        if self._refused:
            return f"what it found last could not be written to {self._home}"
        return f"its finished blocks are kept in {self._home}"

    def earlier(self, only_look: bool = False) -> list[Any]:
        """Results of an earlier run, for `Ensemble`, complete on rank 0, elsewhere without sums; [] if there are none.

        All ranks must call. Unless `only_look`, rank 0's file then contains all results.
        Raises InputError where the checkpoint is that of another scene, seed or version.
        """
        whole: list[Any] = []

        def look() -> list[Any]:
            files = sorted(self._home.glob("*-rank-*.npz"))
            if (found := self._joined(files)) is None:
                return []
            whole.append(found)
            contacts = f"{found.contacts:,} contacts are done"
            say(f"going on from the checkpoint in {self._home}: {contacts}")
            if not only_look and len(files) > 1 and self.write(found):
                for file in set(files) - {self._file}:
                    file.unlink()
            return [found.without_sums()]

        rest = on_root(self._comm, look)
        return whole or rest

    def keep(self, state: Any) -> None:
        """Write this rank's `state` if it is new and the last was written long enough ago."""
        if time.monotonic() - self._last >= self.every and state.done is not self._written:
            self.write(state)

    def write(self, state: Any) -> bool:
        """Write this rank's `state`; returns whether it is on the disk. Rank 0 reports a failure once."""
        before, self._refused = self._refused, ""
        try:
            self._home.mkdir(parents=True, exist_ok=True)
            write_state(self._file, state, self._identity)
        except OSError as error:
            self._refused = error.strerror or str(error)
            if self._rank == 0 and not before:
                say(f"{self._home}: no checkpoint: {self._refused}; the run goes on")
        self._last, self._written = time.monotonic(), state.done
        return not self._refused

    def remove(self) -> None:
        """Remove the checkpoint, once the results are written. On rank 0 only."""
        with suppress(OSError):
            for file in (*self._home.glob("*-rank-*.npz"), *self._home.glob(".*.part")):
                file.unlink(missing_ok=True)
            self._home.rmdir()

    def _joined(self, files: list[Path]) -> Any:
        """The merged contents of these files, if they are of this run; damaged ones are left out."""
        states = []
        for file in files:
            read = read_state(file)
            if read is None:
                say(f"{file}: is damaged; what it held is done again")
                continue
            own, other = self._identity, read[1]
            for key in {**own, **other}:
                if own.get(key) != other.get(key):
                    there, here = (one.get(key, "left out")[:60] for one in (other, own))
                    raise InputError(
                        f"out = {str(self.folder)!r}: holds the checkpoint of another run, {key} = {there} there and "
                        f"{here} here; choose another folder, or remove {self._home}"
                    )
            states.append(read[0])
        found: Any = None
        # rank 0's file may already include others that were not yet removed
        for state in sorted(states, key=lambda state: -state.contacts):
            blocks = [*(found.done if found else ()), *state.done]
            blocks.sort(key=lambda block: block.start)
            if all(before.stop <= after.start for before, after in pairwise(blocks)):
                found = state if found is None else found.joined(state)
        return found


def write_state(file: Path, state: Any, run_keys: dict[str, str]) -> None:
    """Write `state`, and `run_keys`, the result of `identity`: completely or not at all, flushed to the disk."""
    stream = BytesIO()
    np.savez(stream, told_of=json.dumps(run_keys), **state.arrays())
    write_sealed(file, stream.getvalue())


def read_state(file: Path) -> Any:
    """State, and the identity of its run; None for a damaged file. Raises InputError for one of an older version."""
    from eq_model.blocks import State

    try:
        if (contents := read_sealed(file)) is None:
            return None
        arrays = dict(np.load(BytesIO(contents), allow_pickle=False))
        run_keys = json.loads(str(arrays.pop("told_of")))
        return State.of_arrays(arrays), run_keys
    except OSError:
        return None
    except (KeyError, TypeError, ValueError) as error:  # its checksum was right
        hint = f"remove {file.parent}, or choose another folder"
        raise InputError(f"{file}: is a checkpoint of an older version; {hint}") from error


def identity(scene: Scene) -> dict[str, str]:
    """All that the ensemble's numbers depend on, by name: the scene's keys, the laws as drawn, the version."""
    table = msgspec.to_builtins(read_table(tomllib.loads(scene.text)))
    run_keys = {key: text for key, text in _flat(table, "") if not key.startswith(_BESIDE)}
    run_keys["contacts.thresholds as drawn"] = _drawn(scene.contacts.thresholds)
    if (changing := scene.contacts.changing) is not None:
        for name, law in changing.further_laws.items():
            run_keys[f"contacts.{changing.law}.{name} as drawn"] = _drawn(law)
    return {**run_keys, "eq.blocks": "philox-7 by lanes, 2^15, b", "version": __version__}


def say(line: str) -> None:
    """One line to the user, beside the results."""
    print(f"mesofriction: {line}", file=sys.stderr, flush=True)


def _flat(value: Any, where: str) -> Iterator[tuple[str, str]]:
    """Keys of nested tables as one, such as eq.seed, with their values as text."""
    if isinstance(value, dict):
        for key, item in value.items():
            yield from _flat(item, f"{where}.{key}".lstrip("."))
    elif value is not None:
        yield where, json.dumps(value)


def _drawn(law: Thresholds) -> str:
    """Twelve letters that identify a law, as the scene may only name a file."""
    numbers = [*law.ppf(np.linspace(0.0, 1.0, 66)[1:-1]), law.mean(), law.moment(2), *law.support()]
    return sha256(" ".join(f"{x:.10g}" for x in numbers).encode()).hexdigest()[:12]
