"""The discrete ensemble: contacts independent of one another, followed along the path of a rigid slider."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import reduce
from typing import Any

import numpy as np
import numpy.typing as npt

from eq_model import layout
from eq_model.engine import Engine
from eq_model.ensemble_result import EnsembleResult
from eq_model.histogram import Counts, chosen_points, no_counts
from eq_model.state import State
from eq_model.under_way import UnderWay
from origins import Contacts, Drive
from origins.contacts import LAWS, check_contacts
from origins.errors import InputError, positive, refuse, whole

Array = npt.NDArray[np.float64]

_MOST_CONTACTS, _MOST_REPLICAS = 1 << 37, 1 << 28


class Ensemble(UnderWay):
    """An ensemble under way: iterate to work through it block by block, then ask for the result.

        ensemble = Ensemble(contacts, path, n_contacts=100_000)
        for done, total in ensemble:
            ...                       # contacts this rank has done, of its share
        result = ensemble.result()    # all ranks together

    Parameters and errors as for `simulate`; besides, `earlier` are the states of all ranks of an ensemble of the same
    parameters that was cut short: what these did is not done again, and the result is the same to the last bit.

    Attributes: `total`, contacts in all; `expected`, how many of them will be followed, which with a tolerance is known
    better after each round; `blocks`, how they are divided, and `seconds`, about what each takes, which that goes by;
    `clock`, which returns seconds: the wall time and the run time go by it. Another clock may take its place, on the
    class or before the first block, so that work is counted instead.
    """

    def __init__(
        self,
        contacts: Contacts,
        path: npt.ArrayLike,
        *,
        velocity: float = 1.0,
        time: npt.ArrayLike | None = None,
        n_contacts: int = 100_000,
        n_replicas: int = 1,
        seed: int = 0,
        tolerance: float | None = None,
        wall_time: float | None = None,
        histograms: npt.ArrayLike = (),
        earlier: Iterable[State] = (),
        comm: Any = None,
        threads: int = 1,
    ) -> None:
        check_contacts(contacts, "eq_model.simulate", LAWS, own_rates=True)
        for name, law in (("thermal", contacts.thermal), ("ageing", contacts.ageing)):
            if law is not None and law.closure == "paper":
                raise InputError(
                    f'contacts.{name}: closure = "paper" is an approximation of the master equation, which single '
                    'contacts do not know; use closure = "exact"'
                )
        started, most = self.clock(), (1 << 62, _MOST_REPLICAS)
        self._set_up(most, n_contacts, n_replicas, threads, comm, wall_time)
        self.contacts = contacts
        if self.total > _MOST_CONTACTS:
            refuse("n_contacts", n_contacts, f"times n_replicas must be at most {_MOST_CONTACTS}")
        self.drive = Drive(path, velocity, time)
        if whole("seed", seed, 0) >= 1 << 64:
            refuse("seed", seed, "must be below 2^64")
        points = chosen_points(histograms, self.drive.path.size)
        self._engine = Engine(contacts, self.drive, seed, points)
        self.seconds = self._engine.seconds
        self.blocks = layout.make_blocks(self.n_contacts, self.n_replicas, self.seconds)
        small = "such as 1e-4"
        self._tolerance = None if tolerance is None else positive("tolerance", tolerance, small)
        ready = self.clock() - started
        started = self.clock()
        layout.in_turn(comm, lambda: self._engine.follow(self.blocks, -1))
        self.compile_time = self.clock() - started
        sums, counts = (
            np.zeros((2, self._engine.size), np.int64),
            no_counts(points.size, self.total),
        )
        nothing = State(sums, counts, 0, 0, 0, [], ready)
        found = list(earlier)
        self._before = [part for state in found for part in state.done]
        # what was found before counts on one rank
        first = layout.rank_and_size(comm)[0] == 0
        self._state = reduce(State.joined, found, nothing) if first else nothing

    def __iter__(self) -> Iterator[tuple[int, int]]:
        """Do this rank's share, once; after each block (contacts done, contacts in the share), and while it waits for
        the others.

        With a tolerance the shares of further rounds follow while it is not reached. All ranks must go on to the end.
        """
        rank, ranks = layout.rank_and_size(self.comm)
        begun, done = self.clock(), 0
        for one_round in self.blocks.rounds(self._tolerance is not None):
            mine = layout.share(layout.left(one_round, self._before), rank, ranks)
            total, late = done + self.blocks.contacts(mine), False
            blocks = [block for part in mine for block in part]
            for one in self._each(lambda block: self._engine.follow(self.blocks, block), blocks):
                # one assignment: whatever interrupts, the state is that of whole blocks
                size = self.blocks.size(one.unit)
                self._state = self._state.after(one.unit, size, one.found, one.seconds)
                done += size
                yield done, total
                if late := self._late(begun):
                    break
            for _ in layout.meeting(self.comm):
                yield done, total
            if self._enough(one_round, late or self._stopped):
                return

    @property
    def state(self) -> State:
        """What this rank has found so far, to go on from in another run: see `earlier`."""
        return self._state

    def _enough(self, one_round: range, late: bool) -> bool:
        """Whether no further round is wanted; every rank must call."""
        if self._tolerance is None:
            return late
        if self.comm is not None:
            late = any(self.comm.allgather(late))
        # what was done beyond this round says that it was not enough then
        if late or any(part.stop > one_round.stop for part in self._before):
            return late
        found = self._result()
        wanted = self._wanted(
            found.contacts, float(found.force_standard_error.max()) / self.contacts.mean_threshold
        )
        ends = (self.blocks.before(part.stop) for part in self.blocks.rounds(True))
        self.expected = next((end for end in ends if end >= wanted), self.total)
        return found.success

    def _wanted(self, contacts: int, largest: float) -> float:
        """How many contacts reach the tolerance, if these had this largest standard error."""
        if self._tolerance is None:
            return float(self.total)
        ratio = largest / self._tolerance
        return contacts * ratio * ratio  # not as a power, which may overflow

    def result(self) -> EnsembleResult:
        """What all ranks found; every rank must call, and gets the same bits."""
        return self._result(self._state.counts)

    def _result(self, counts: Counts | None = None) -> EnsembleResult:
        """With the histograms of this rank's `counts` and the other ranks', or without any."""
        started, state = self.clock(), self._state
        sums, states = state.sums, [state]
        if self.comm is not None:
            sums = np.empty_like(state.sums)
            self.comm.Allreduce(state.sums, sums)  # whole numbers: the order does not matter
            states = self.comm.allgather(state.without_sums())
        done = sorted((part for one in states for part in one.done), key=lambda part: part.start)
        contacts = self.blocks.contacts(done)
        if not contacts:
            raise InputError(
                "ensemble: no block of contacts is finished yet; iterate over it first"
            )
        moments = self._engine.readout.moments(self.blocks, done, sums)
        holding, error = moments.holding, np.sqrt(moments.variance / contacts)
        if counts is not None and counts.size and self.comm is not None:
            own, counts = counts, np.empty_like(counts)
            self.comm.Allreduce(own, counts)
        histograms = [] if counts is None else self._engine.histograms(contacts, counts)
        run_time = max(one.run_time for one in states) + self._slowest(self.clock() - started)
        success, message = self._judge(contacts, error)
        return EnsembleResult(
            path=self.drive.path,
            force=moments.force,
            force_standard_error=error,
            step_error=self._engine.readout.step_error(self.blocks, done, sums),
            holding=holding,
            holding_standard_error=np.sqrt(self._holding_variance(holding, contacts) / contacts),
            histograms=histograms,
            contacts=contacts,
            breaks=sum(one.breaks for one in states),
            breaks_per_rank=[one.breaks for one in states],
            run_time=run_time,
            compile_time=self.compile_time,
            success=success,
            message=message,
        )

    def _holding_variance(self, holding: Array, contacts: int) -> Array:
        """Between contacts; where they may wait, or not pin, one that might have been is in it."""
        waits = self.contacts.delay is not None or self.contacts.grains is not None
        return np.maximum(holding * (1.0 - holding), 1.0 / contacts if waits else 0.0)

    def _slowest(self, seconds: float) -> float:
        return seconds if self.comm is None else max(self.comm.allgather(seconds))

    def _judge(self, contacts: int, error: Array) -> tuple[bool, str]:
        largest = float(error.max()) / self.contacts.mean_threshold
        found = f"largest standard error {largest:.2e} with {contacts} contacts"
        if self._tolerance is not None:
            if largest <= self._tolerance:
                return True, f"{found}, within the tolerance {self._tolerance:.1e}"
            more, unmet = (
                self._wanted(contacts, largest),
                f"{found}, above the tolerance {self._tolerance:.1e}",
            )
            if not np.isfinite(largest):
                return False, f"{unmet}; take at least two"
            if more > _MOST_CONTACTS:
                return (
                    False,
                    f"{unmet}; it takes more than {_MOST_CONTACTS:.1e} contacts, the most there can be",
                )
            return False, f"{unmet}; it takes about {more:.1e} contacts"
        if contacts < self.total:
            return False, f"{found}: stopped before all {self.total} were followed"
        return True, found
