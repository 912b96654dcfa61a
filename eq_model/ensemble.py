"""A running ensemble: blocks of independent contacts, or replicas of coupled ones, over threads and ranks."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import reduce
from time import perf_counter
from typing import Any
from zlib import crc32

import numpy as np
import numpy.typing as npt

from eq_model.blocks import Blocks, DroppedError, State, blocks_of_rank, meeting, rank_and_size
from eq_model.coupled.ensemble import Replicas
from eq_model.coupled.mass.sliders import HeavySliders
from eq_model.engine import Engine
from eq_model.result import CoupledResult, EnsembleResult, HeavyResult
from origins import Contacts, Drive
from origins.errors import InputError, NothingInTimeError, check_seed, positive, refuse, whole


class Ensemble:
    """A running ensemble: iterate to work through it block by block, then call `result`.

        ensemble = Ensemble(contacts, path, n_contacts=100_000)
        for done, total in ensemble:
            ...                       # contacts this rank has done, of its share
        result = ensemble.result()    # all ranks together

    Parameters and errors as for `simulate`; besides, `earlier` are the states of all ranks of an ensemble of the same
    parameters that was stopped: their blocks are not repeated, and the result is the same to the last bit.

    Attributes: `total`, number of all contacts; `expected`, the number that will be followed, which with a tolerance
    is estimated after each round; `blocks`, their division, with a spring one block for each replica; `state`, the
    results of this rank so far, from which another run can continue; `clock`, a function that returns seconds, for
    wall time and run time. It may be replaced, on the class or before the first block, to count work instead;
    `interrupted`, a function that may be replaced, too: once it is true, also the replica on a spring that is being
    followed is given up, as when the wall time is over. Nothing is kept of it.
    """

    clock: Callable[[], float] = staticmethod(perf_counter)
    interrupted: Callable[[], bool] = staticmethod(lambda: False)

    def __init__(
        self,
        contacts: Contacts,
        path: npt.ArrayLike,
        *,
        slip_fraction: float | None = None,
        n_contacts: int = 100_000,
        n_replicas: int = 1,
        seed: int = 0,
        tolerance: float | None = None,
        wall_time: float | None = None,
        histograms: npt.ArrayLike = (),
        earlier: Iterable[State] = (),
        comm: Any = None,
        threads: int = 1,
        **drive: Any,
    ) -> None:
        """Check the arguments, make tables and blocks, and compile what will be needed.

        drive : velocity, time, spring, slip, mass and damping, as for origins.Drive.
        """
        started = self.clock()
        if comm is not None and not hasattr(comm, "Get_rank"):
            refuse("comm", comm, "must be a communicator of mpi4py, as MPI.COMM_WORLD, or None")
        self.comm, self._threads, self._stopped = comm, whole("threads", threads, 1), False
        self._begun, self._given_up, self._nobody_waits = np.inf, False, False
        each = whole("n_contacts", n_contacts, 1)
        self._replicas = whole("n_replicas", n_replicas, 1)
        if self._replicas >= 1 << 28:
            refuse("n_replicas", n_replicas, f"must be below {1 << 28}")
        self.total = self.expected = each * self._replicas
        self._wall_time = np.inf if wall_time is None else positive("wall_time", wall_time)
        small = "such as 1e-4"
        self._tolerance = None if tolerance is None else positive("tolerance", tolerance, small)
        self.contacts, self.drive = contacts, Drive(path, **drive)
        check_seed(seed)
        coupled = self.drive.spring is not None
        most = Replicas.MOST if coupled else Engine.MOST // self._replicas
        if each > most:
            refuse("n_contacts", n_contacts, f"must be at most {most}")
        if not coupled and slip_fraction is not None:
            hint = "is of a soft slider; give its spring, or leave it out"
            refuse("slip_fraction", slip_fraction, hint)
        for name, value in (("tolerance", tolerance), ("histograms", histograms)):
            if coupled and value is not None and np.size(value):
                hint = "is of independent contacts; leave it out with a spring, where replicas tell the errors"
                refuse(name, value, hint)
        replicas = Blocks(self.total, each)
        self._work: Engine | Replicas | HeavySliders
        if coupled:
            kind = Replicas if self.drive.mass is None else HeavySliders
            self._work = kind(contacts, self.drive, replicas, seed, slip_fraction, self._dropped)
        else:
            self._work = Engine(contacts, self.drive, replicas, seed, histograms)
        self.blocks = self._work.blocks
        points = self.drive.path, () if self.drive.time is None else self.drive.time
        course = crc32(np.concatenate(points).tobytes()) + 1
        nothing = replace(self._work.nothing, run_time=self.clock() - started, course=course)
        started = self.clock()
        first = rank_and_size(comm)[0] == 0
        if first:
            self._work.follow(-1)
        list(meeting(comm))
        if not first:  # the other ranks find on disk what rank 0 compiled
            self._work.follow(-1)
        self.compile_time = self.clock() - started
        found = list(earlier)
        self._before = [part for state in found for part in state.done]
        # the earlier states are added on one rank only
        self.state = reduce(State.joined, found, nothing) if first else nothing

    def __iter__(self) -> Iterator[tuple[int, int]]:
        """Do this rank's share of the work, once. Yields (contacts done, contacts in the share) after each block, and
        while it waits for the other ranks.

        With a tolerance, further rounds follow until it is reached. All ranks must iterate to the end.
        """
        rank, ranks = rank_and_size(self.comm)
        self._begun, done = self.clock(), 0
        for one_round in self.blocks.rounds(self._tolerance is not None):
            mine = blocks_of_rank(one_round, self._before, rank, ranks)
            total, late = done + sum(map(self.blocks.size, mine)), False
            started = self.clock()
            for block, found in self._each(mine):
                # a single assignment, so that after any interrupt the state is that of whole blocks
                size = self.blocks.size(block)
                found = replace(found, contacts=size, done=[range(block, block + 1)])
                seconds = self.state.run_time + self.clock() - started
                self.state = replace(self.state.joined(found), run_time=seconds)
                started = self.clock()
                done += size
                yield done, total
                if late := self._stopped or self._over():
                    break
            if done < total and not late:  # the rest was given up
                late = True
                yield done, total
            for _ in meeting(self.comm):
                yield done, total
            if self._enough(one_round, late or self._stopped):
                return

    def _each(self, blocks: Sequence[int]) -> Iterator[tuple[int, State]]:
        """Follow the blocks, several at once with threads; yields them in order."""
        at_once = 8 * self._threads  # few, so that wall time and `stop` are heeded
        with ThreadPoolExecutor(self._threads) as pool:
            for first in range(0, len(blocks), at_once):
                some = blocks[first : first + at_once]
                results = (map if self._threads == 1 else pool.map)(self._work.follow, some)
                try:
                    yield from zip(some, results, strict=True)
                except DroppedError:
                    self._given_up = True
                    return
                finally:
                    self._nobody_waits = True  # unless ended here, threads follow others yet
                self._nobody_waits = False

    def _over(self) -> bool:
        """Whether the wall time is over."""
        return self.clock() - self._begun > self._wall_time

    def _dropped(self) -> bool:
        """Whether a replica that is being followed is given up."""
        return self._nobody_waits or self.interrupted() or self._over()

    def stop(self) -> None:
        """Begin no further block of this rank's share: the result will be that of the finished blocks."""
        self._stopped = True

    def _enough(self, one_round: range, late: bool) -> bool:
        """Whether no further round is needed; every rank must call."""
        if self._tolerance is None:
            return late
        if self.comm is not None:
            late = any(self.comm.allgather(late))
        # if an earlier run went beyond this round, the round was not enough
        if late or any(part.stop > one_round.stop for part in self._before):
            return late
        found = self.result(histograms=False)
        ends = (self.blocks.before(part.stop) for part in self.blocks.rounds(True))
        self.expected = next((end for end in ends if end >= self._wanted(found)), self.total)
        return found.success

    def _wanted(self, found: EnsembleResult) -> float:
        """Number of contacts that would reach the tolerance, estimated from the present error."""
        ratio = self._largest(found) / (self._tolerance or np.inf)
        return found.contacts * ratio * ratio  # not as a power, which may overflow

    def _largest(self, found: EnsembleResult) -> float:
        """The largest standard error, in units of the mean threshold."""
        return float(found.force_standard_error.max()) / self.contacts.mean_threshold

    def result(self, histograms: bool = True) -> EnsembleResult:
        """The result of all ranks, if asked with histograms; every rank must call, and gets the same bits. Raises
        NothingInTimeError, an InputError, where time was over before a replica on a spring was followed to the end."""
        started, own, comm = self.clock(), self.state, self.comm
        totals = [own.sums, own.counts if histograms else own.counts[:0]]
        states = [own.without_sums()]
        if comm is not None:
            states = comm.allgather(states[0])
            for k, array in enumerate(totals):
                totals[k] = np.empty_like(array)
                if array.size:  # sums of whole numbers do not depend on the order
                    comm.Allreduce(array, totals[k])
        joined = replace(reduce(State.joined, states), sums=totals[0], counts=totals[1])
        if not joined.contacts and (
            any(comm.allgather(self._given_up)) if comm else self._given_up
        ):
            limit = "" if np.isinf(self._wall_time) else f" = {self._wall_time:g}"
            raise NothingInTimeError(
                f"wall_time{limit}: no slider was followed to the end of the path before it was over, or interrupted, "
                "so that nothing is known; give more, fewer contacts, or a shorter path"
            )
        if not joined.contacts:
            hint = "no block of contacts is finished yet; iterate over it first, or give it more"
            raise InputError(f"ensemble: {hint} wall_time")
        fields = self._work.fields(joined)
        waited = self.clock() - started
        kind = CoupledResult if "slips" in fields else EnsembleResult
        found = (HeavyResult if "energy" in fields else kind)(
            path=self.drive.path,
            contacts=joined.contacts,
            breaks=joined.breaks,
            breaks_per_rank=[state.breaks for state in states],
            run_time=joined.run_time + (waited if comm is None else max(comm.allgather(waited))),
            compile_time=self.compile_time,
            success=False,
            message="",
            **fields,
        )
        success, message = self._judge(found)
        return replace(found, success=success, message=message)

    def _judge(self, found: EnsembleResult) -> tuple[bool, str]:
        """Success and message of a result."""
        largest, more = self._largest(found), self._wanted(found)
        says = f"largest standard error {largest:.2e} with {found.contacts} contacts"
        if self._tolerance is None and found.contacts == self.total:
            return True, says
        if self._tolerance is None:
            many = self._replicas if self.drive.spring is not None else self.total
            return False, f"{says}: stopped before all {many} were followed"
        if largest <= self._tolerance:
            return True, f"{says}, within the tolerance {self._tolerance:.1e}"
        needs = f"it takes about {more:.1e} contacts"
        if not np.isfinite(largest):
            needs = "take at least two"
        elif more > Engine.MOST:
            needs = f"it takes more than {Engine.MOST:.1e} contacts, the most there can be"
        return False, f"{says}, above the tolerance {self._tolerance:.1e}; {needs}"


CoupledEnsemble = Ensemble  # an older name: with a spring an Ensemble is of coupled contacts
