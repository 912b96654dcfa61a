"""A run's checkpoint in its output folder: what each rank's finished blocks found, and of which run.

A rank writes a file of its own, beside the old one, and then in its place. A run that goes on from it, on whatever
number of ranks, writes files of a higher turn: rank 0's holds all that was found before. Files say which blocks they
hold, so that whatever was cut short in between, none counts twice.
"""

from __future__ import annotations

import json
import os
import sys
import time
import tomllib
from bisect import bisect_left, insort
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from functools import reduce
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np

import toolkit
from origins.errors import InputError, positive
from origins.thresholds.law import Thresholds
from toolkit.running.ranks import on_root
from toolkit.running.state_file import BLOCKS, read_state, write_state
from toolkit.scene.scene import Scene
from toolkit.scene.tables import read_table

if TYPE_CHECKING:
    from eq_model.coupled.result import CoupledState
    from eq_model.state import State

    AnyState = State | CoupledState

NAME = "checkpoint"
EVERY = 60.0  # seconds: little is lost, and thousands of ranks do not crowd the disk

_BESIDE = {
    "title",
    "master.tolerance",
    "eq.wall_time",
    "wall_time",
}  # what the ensemble's numbers do not depend on
_LONG = 60  # letters
_QUANTILES = np.linspace(0.0, 1.0, 66)[1:-1]


class Checkpoint:
    """The checkpoint of one scene's ensemble in `folder`/checkpoint; nothing is written before its first `every` s.

    Parameters
    ----------
    folder : where the results will be written.
    scene : whose checkpoint it is; another one's is refused.
    comm : mpi4py communicator, or None for this process alone.
    every : seconds from one checkpoint to the next, at most.
    """

    def __init__(
        self, folder: str | os.PathLike[str], scene: Scene, comm: Any = None, every: float = EVERY
    ) -> None:
        self.every = positive("checkpoint", every)
        self.folder = Path(folder)
        self._home, self._comm = self.folder / NAME, comm
        self._rank = 0 if comm is None else comm.Get_rank()
        self._identity = identity(scene)
        self._turn, self._old = 0, list[Path]()
        self._last, self._warned = time.monotonic(), False
        self._written: list[range] | None = None
        self._written_well = False

    @property
    def is_first(self) -> bool:
        """Whether this rank speaks for all."""
        return self._rank == 0

    @property
    def note(self) -> str:
        """What is left when the run ends here."""
        kept = (
            "its finished blocks are kept in"
            if self._written_well
            else "what it found last could not be written to"
        )
        return f"{kept} {self._home}"

    def earlier(self) -> list[AnyState]:
        """What an earlier run found, for `Ensemble`: whole on rank 0, elsewhere which contacts it was; [] if nothing.

        All ranks must call. Raises InputError where the checkpoint is that of another scene, seed or version.
        """
        whole: AnyState | None = None

        def look() -> tuple[int, AnyState | None]:
            nonlocal whole
            whole = self._read()
            return self._turn, None if whole is None else whole.without_sums()

        self._turn, rest = on_root(self._comm, look)
        found = rest if whole is None else whole
        return [] if found is None else [found]

    def keep(self, state: AnyState) -> None:
        """Write this rank's `state` if it is new and the last was written long enough ago."""
        if time.monotonic() - self._last >= self.every and state.done is not self._written:
            self.write(state)

    def write(self, state: AnyState) -> None:
        """Write this rank's `state`; a disk that refuses is told once, by rank 0."""
        self._written_well = False
        try:
            self._home.mkdir(parents=True, exist_ok=True)
            write_state(
                self._home / f"{self._turn:03d}-rank-{self._rank:05d}.npz", state, self._identity
            )
            if self.is_first:
                while self._old:  # all of it is in the new one
                    self._old.pop().unlink(missing_ok=True)
            self._written_well = True
        except OSError as error:
            if self.is_first and not self._warned:
                say(f"{self._home}: no checkpoint: {error.strerror or error}; the run goes on")
            self._warned = True
        # not the state itself: what it counted would stay on the disk
        self._last, self._written = time.monotonic(), state.done

    def remove(self) -> None:
        """Forget it: the results are written. On rank 0 alone."""
        with suppress(OSError):
            for file in [*_files(self._home), *self._home.glob(".*.part")]:
                file.unlink(missing_ok=True)
            self._home.rmdir()

    def _read(self) -> AnyState | None:
        from eq_model import layout
        from eq_model.coupled.result import CoupledState

        found: AnyState | None = None
        taken: list[range] = []
        self._old = _files(self._home)
        for file in self._old:
            self._turn = max(self._turn, _turn(file) + 1)
            read = read_state(file)
            if read is None:
                say(f"{file}: is damaged; what it held is done again")
                continue
            state, other = read
            self._check(other)
            if _take(state.done, taken):
                found = state if found is None else found.joined(state)
        if found is not None:
            say(
                f"going on from the checkpoint in {self._home}: {found.contacts:,} contacts are done"
            )
            if not isinstance(found, CoupledState):
                found = replace(found, done=reduce(layout.joined, taken, []))
        return found

    def _check(self, other: dict[str, str]) -> None:
        own = self._identity
        apart = [key for key in {**own, **other} if own.get(key) != other.get(key)]
        if apart:
            key = apart[0]
            more = f" and {len(apart) - 1} more" if len(apart) > 1 else ""
            raise InputError(
                f"out = {str(self.folder)!r}: holds the checkpoint of another run, {key} = "
                f"{other.get(key, 'left out')} there and {own.get(key, 'left out')} here{more}; choose another folder, "
                f"or remove {self._home}"
            )


def identity(scene: Scene) -> dict[str, str]:
    """All that the ensemble's numbers depend on, by name: the scene's keys, the laws as drawn, the version."""
    table = msgspec.to_builtins(read_table(tomllib.loads(scene.text)))
    told = {
        name: value
        for name, value in _flat(table, ())
        if name not in _BESIDE and not name.startswith("master")
    }
    told["contacts.thresholds as drawn"] = _drawn(scene.contacts.thresholds)
    if scene.contacts.ageing is not None:
        told["contacts.ageing.final as drawn"] = _drawn(scene.contacts.ageing.final)
    return {**told, BLOCKS: "philox-7, 2^14", "version": toolkit.__version__}


def say(line: str) -> None:
    """One line to the user, beside the results."""
    print(f"mesofriction: {line}", file=sys.stderr, flush=True)


def _flat(value: Any, where: tuple[str, ...]) -> Iterator[tuple[str, str]]:
    if isinstance(value, dict):
        for key, item in value.items():
            yield from _flat(item, (*where, key))
    elif value is not None:
        text = json.dumps(value)
        # thousands of samples need not be repeated in the file of every rank
        yield ".".join(where), text if len(text) <= _LONG else f"{text[:_LONG]}... {_digest(text)}"


def _drawn(law: Thresholds) -> str:
    """Twelve letters that tell one law from another, where a file's contents say what it is."""
    numbers = [*law.ppf(_QUANTILES), law.mean(), law.moment(2), *law.support()]
    return _digest(" ".join(f"{x:.10g}" for x in numbers))


def _digest(text: str) -> str:
    return sha256(text.encode()).hexdigest()[:12]


def _files(home: Path) -> list[Path]:
    """Those of the last turn first, and of each turn that of rank 0."""
    return sorted(home.glob("[0-9]*-rank-*.npz"), key=lambda file: (-_turn(file), file.name))


def _take(done: list[range], taken: list[range]) -> bool:
    """Add `done` to `taken`, which is in order, unless one of these blocks is there already."""
    for part in done:
        at = bisect_left(taken, part.start, key=lambda other: other.start)
        before, after = taken[max(at - 1, 0) : at], taken[at : at + 1]
        if any(other.stop > part.start for other in before) or any(
            other.start < part.stop for other in after
        ):
            return False
    for part in done:
        insort(taken, part, key=lambda other: other.start)
    return True


def _turn(file: Path) -> int:
    return int(file.name.partition("-")[0])
