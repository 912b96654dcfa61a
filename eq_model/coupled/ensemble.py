"""Replicas of coupled contacts, N of them on one soft slider each, spread over ranks."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import reduce
from typing import Any

import numpy as np
import numpy.typing as npt

from eq_model import layout
from eq_model.coupled.replica import Follower
from eq_model.coupled.result import CoupledResult, CoupledState, result_of
from eq_model.under_way import UnderWay
from origins import Contacts, Drive, identical
from origins.contacts import check_contacts
from origins.drive import SlipRule
from origins.errors import InputError, positive, refuse

# Share of the contacts that an avalanche breaks at least to be a slip. Before a slip avalanches
# break up to 2 N^(-1/3) of the contacts, 0.13 at N = 4,000; slips of a spring below 0.7 K* break
# most of them.
SLIP_FRACTION = 0.2
MOST_CONTACTS = 1 << 31  # of a replica
MOST_REPLICAS = 1 << 28


class CoupledEnsemble(UnderWay):
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
        most = (MOST_CONTACTS + 1, MOST_REPLICAS + 1)
        self._set_up(most, n_contacts, n_replicas, threads, comm, wall_time)
        self.slip_fraction = positive("slip_fraction", slip_fraction)
        if self.slip_fraction > 1.0:
            refuse("slip_fraction", slip_fraction, "must be at most 1, a share of the contacts")
        started = self.clock()
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
        """Follow this rank's share of the replicas, once; after each (contacts done, contacts in the share).

        All ranks must go on to the end.
        """
        rank, ranks = layout.rank_and_size(self.comm)
        mine = [r for r in range(self.n_replicas) if r not in self._before][rank::ranks]
        total, begun = len(mine) * self.n_contacts, self.clock()
        for number, one in enumerate(self._each(self._follower.follow, mine)):
            # whatever interrupts, the state is that of whole replicas
            self._state.run_time += one.seconds
            self._state.found[one.unit] = one.found
            yield (number + 1) * self.n_contacts, total
            if self._late(begun):
                break
        for _ in layout.meeting(self.comm):
            yield total, total

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
    Follower(contacts, drive, 2, 0, 1.0).follow(0)


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
