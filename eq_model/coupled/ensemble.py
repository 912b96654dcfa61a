"""Replicas of coupled contacts, N of them on one soft slider each, spread over ranks."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext
from functools import reduce
from time import perf_counter
from typing import Any

import numpy as np
import numpy.typing as npt

from eq_model import layout
from eq_model.coupled.replica import Followed, Follower
from eq_model.coupled.result import CoupledResult, CoupledState, result_of
from origins import Contacts, Drive, identical
from origins.contacts import check_contacts
from origins.drive import SlipRule
from origins.errors import InputError, positive, refuse, whole

# Share of the contacts that an avalanche breaks at least to be a slip. Before a slip avalanches
# break up to 2 N^(-1/3) of the contacts, 0.13 at N = 4,000; slips of a spring below 0.7 K* break
# most of them.
SLIP_FRACTION = 0.2
MOST_CONTACTS = 1 << 31  # of a replica
MOST_REPLICAS = 1 << 28
_HARDLY = (
    1e-3  # of the thresholds exceed a stretch at which contacts form again in ordinary numbers
)


class CoupledEnsemble:
    """Replicas under way: iterate to work through them, then ask for the result.

        ensemble = CoupledEnsemble(contacts, path, spring=0.5, n_contacts=100_000, n_replicas=16)
        for done, total in ensemble:
            ...                       # contacts this rank has done, of its share
        result = ensemble.result()    # all ranks together

    Parameters and errors as for `eq_model.simulate` with a spring; `earlier` are the states of all
    ranks of an ensemble of the same parameters that was cut short: replicas that are finished there
    are not followed again, and the result is the same to the last bit.

    Attributes: `total`, contacts of all replicas; `expected`, the same; `clock` and `comm`.
    """

    clock: Callable[[], float] = staticmethod(perf_counter)

    def __init__(
        self,
        contacts: Contacts,
        path: npt.ArrayLike,
        *,
        spring: float,
        slip: SlipRule = "reset",
        slip_fraction: float = SLIP_FRACTION,
        velocity: float = 1.0,
        time: npt.ArrayLike | None = None,
        n_contacts: int = 100_000,
        n_replicas: int = 1,
        seed: int = 0,
        wall_time: float | None = None,
        earlier: Iterable[CoupledState] = (),
        comm: Any = None,
        threads: int = 1,
    ) -> None:
        self.drive = Drive(path, velocity, time, spring, slip)
        check_coupled(contacts, self.drive)
        if comm is not None and not hasattr(comm, "Get_rank"):
            rule = (
                "must be a communicator of mpi4py, such as MPI.COMM_WORLD, or None for this process"
            )
            refuse("comm", comm, rule)
        self.comm, self.n_contacts = comm, whole("n_contacts", n_contacts, 1)
        self.n_replicas = whole("n_replicas", n_replicas, 1)
        for name, value, most in (
            ("n_contacts", self.n_contacts, MOST_CONTACTS),
            ("n_replicas", self.n_replicas, MOST_REPLICAS),
        ):
            if value > most:
                refuse(name, value, f"must be at most {most} on soft sliders")
        self.slip_fraction = positive("slip_fraction", slip_fraction)
        if self.slip_fraction > 1.0:
            refuse("slip_fraction", slip_fraction, "must be at most 1, a share of the contacts")
        self._wall_time = None if wall_time is None else positive("wall_time", wall_time)
        self.total = self.expected = self.n_contacts * self.n_replicas
        self._threads = whole("threads", threads, 1)
        self._stopped, started = False, self.clock()
        self._follower = Follower(contacts, self.drive, self.n_contacts, seed, self.slip_fraction)
        ready, started = self.clock() - started, self.clock()
        layout.in_turn(comm, _compile)
        self.compile_time = self.clock() - started
        found = list(earlier)
        self._before = {replica for state in found for replica in state.found}
        # what was found before counts on one rank
        nothing = CoupledState(self.n_contacts, run_time=ready)
        first = layout.rank_and_size(comm)[0] == 0
        self._state = reduce(CoupledState.joined, found, nothing) if first else nothing

    def __iter__(self) -> Iterator[tuple[int, int]]:
        """Follow this rank's share of the replicas, once; now and then (contacts done, contacts in the share).

        A replica under way counts as far as its drive has come, unless several are. All ranks must go on to the end.
        """
        rank, ranks = layout.rank_and_size(self.comm)
        mine = [r for r in range(self.n_replicas) if r not in self._before][rank::ranks]
        total, number, begun = len(mine) * self.n_contacts, 0, self.clock()
        started = begun
        with ThreadPoolExecutor(self._threads) if self._threads > 1 else nullcontext() as pool:
            for replica, told in self._work(mine, pool):
                share = 0.0
                if isinstance(told, Followed):
                    started, before = self.clock(), started
                    # whatever interrupts, the state is that of whole replicas
                    self._state.run_time += started - before
                    self._state.found[replica] = told
                    number += 1
                else:
                    share = told
                yield int((number + share) * self.n_contacts), total
                past = self._wall_time is not None and self.clock() - begun > self._wall_time
                if self._stopped or (past and not share):
                    break
            if pool is not None:
                pool.shutdown(cancel_futures=True)
        for _ in layout.meeting(self.comm):
            yield total, total

    def _work(
        self, mine: list[int], pool: ThreadPoolExecutor | None
    ) -> Iterator[tuple[int, float | Followed]]:
        """What is told of each replica in turn, at last what it did."""
        if pool is None:
            for replica in mine:
                for told in self._follower.follow(replica):
                    yield replica, told
        else:
            whole = pool.map(lambda replica: deque(self._follower.follow(replica), 1).pop(), mine)
            yield from zip(mine, whole, strict=True)

    def stop(self) -> None:
        """Follow this rank's share no further: the result will be that of the finished replicas."""
        self._stopped = True

    @property
    def state(self) -> CoupledState:
        """What this rank has found so far, to go on from in another run: see `earlier`."""
        return self._state

    def result(self) -> CoupledResult:
        """What all ranks found; every rank must call, and gets the same bits."""
        states = [self._state] if self.comm is None else self.comm.allgather(self._state)
        rows = {replica: row for state in states for replica, row in state.here.items()}
        if not rows:
            raise InputError(
                "ensemble: no replica is finished yet; iterate over it first, or give it more wall_time"
            )
        told = f"{len(rows)} replicas of {self.n_contacts:,} contacts"
        finished = len(rows) == self.n_replicas
        if not finished:
            told += f": stopped before all {self.n_replicas} were followed"
        return result_of(
            [rows[replica] for replica in sorted(rows)],
            sorted(rows),
            path=self.drive.path,
            slip_fraction=self.slip_fraction,
            contacts=len(rows) * self.n_contacts,
            breaks_per_rank=[sum(row.breaks for row in state.here.values()) for state in states],
            run_time=max(state.run_time for state in states),
            compile_time=self.compile_time,
            success=finished,
            message=told,
        )


def _compile() -> None:
    """Follow a few contacts on a short way: the kernels are the same for all laws and rules."""
    contacts, drive = Contacts(identical(1.0)), Drive([3.0], spring=1.0)
    for _ in Follower(contacts, drive, 2, 0, 1.0).follow(0):
        pass


def check_coupled(contacts: Contacts, drive: Drive) -> None:
    """Raise InputError for what is not followed on a soft slider: laws, and ways that turn."""
    solver = "eq_model.simulate with a spring"
    if isinstance(contacts, Contacts) and contacts.thermal is not None:
        raise InputError(
            f"contacts.thermal: {solver} takes T = 0: the slider's speed hangs on all contacts at "
            "once, so that none can draw its break beforehand; use master.solve, or leave it out"
        )
    check_contacts(contacts, solver, ("delay", "reforming", "stiffness"))
    at_once = drive.slip == "instant" and contacts.delay is None
    if contacts.reforming is not None and not at_once:
        raise InputError(
            "contacts.reforming: contacts that form again stretched after an avalanche would pull "
            f'the slider once more; {solver} takes them with slip = "instant" and no delay'
        )
    back = np.flatnonzero(np.diff(drive.path) < 0.0)
    if back.size:
        at = int(back[0]) + 1
        refuse(
            f"path[{at}]",
            drive.path[at],
            f"lies behind path[{at - 1}]; {solver} takes a drive that does not turn",
        )
