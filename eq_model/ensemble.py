"""The discrete ensemble: contacts independent of one another, followed along the path of a rigid slider."""

from __future__ import annotations

import time as clock
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from eq_model import layout
from eq_model.beginning import Beginning
from eq_model.forward import Forward, takes
from eq_model.histogram import Histogram
from eq_model.lives import LAWS, Lives
from origins import Contacts, Drive
from origins.contacts import check_contacts
from origins.errors import InputError, refuse, whole
from origins.streams import MOST_REPLICAS, key_of

Array = npt.NDArray[np.float64]

_MOST_CONTACTS = 1 << 37


@dataclass(frozen=True)
class EnsembleResult:
    """What the ensemble measured.

    path : the path asked for, shape (n,), lengths.
    force : mean force over all contacts and replicas at each X, shape (n,), a length (force per N_c <k>).
    force_standard_error : of that mean, from the variance between contacts, shape (n,), a length; inf for one contact.
        For contacts without laws on a path that moves forward the variance is that of the first 2^18 contacts and of
        every eighth 2^16 of the others. Where fewer than 100 breaks are expected or found, it is at least what they
        add to the variance, seen or not. What happens to less than one contact in all of them later on is in no
        ensemble and not in its error: one contact's stretch divided by their number.
    holding : fraction of contacts that hold, shape (n,).
    holding_standard_error : of that, shape (n,).
    histograms : of stretches and thresholds, at the points asked for.
    breaks : breaks in all; breaks_per_rank : of each rank.
    run_time : s, of the slowest rank, tables included, compilation not; compile_time : s, imports included.
    """

    path: Array
    force: Array
    force_standard_error: Array
    holding: Array
    holding_standard_error: Array
    histograms: list[Histogram]
    breaks: int
    breaks_per_rank: list[int]
    run_time: float
    compile_time: float


class Ensemble:
    """An ensemble under way: iterate to work through it block by block, then ask for the result.

        ensemble = Ensemble(contacts, path, n_contacts=100_000)
        for done, total in ensemble:
            ...                       # contacts this rank has done, of its share
        result = ensemble.result()    # all ranks together

    Parameters and errors as for `simulate`.
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
        histograms: npt.ArrayLike = (),
        comm: Any = None,
    ) -> None:
        check_contacts(contacts, "eq_model.simulate", LAWS)
        if contacts.thermal is not None and contacts.thermal.closure == "paper":
            raise InputError(
                'contacts.thermal: closure = "paper" is an approximation of the master equation; single contacts break '
                'each at its own rate, so use closure = "exact"'
            )
        if contacts.ageing is not None and contacts.ageing.closure == "paper":
            raise InputError(
                'contacts.ageing: closure = "paper" gives all contacts one law, which single contacts do not have; use '
                'closure = "exact"'
            )
        started = clock.perf_counter()
        self.contacts, self.comm = contacts, comm
        self.n_contacts, replicas = whole("n_contacts", n_contacts, 1), whole("n_replicas", n_replicas, 1)
        if replicas >= MOST_REPLICAS:
            refuse("n_replicas", n_replicas, f"must be below {MOST_REPLICAS}; take more contacts instead")
        self.total = self.n_contacts * replicas
        if self.total > _MOST_CONTACTS:
            refuse("n_contacts", n_contacts, f"times n_replicas must be at most {_MOST_CONTACTS}")
        self.drive = Drive(path, velocity, time)
        beginning = Beginning(contacts, self.n_contacts, key_of(seed))
        points = _points(histograms, self.drive.path.size)
        self._engine: Forward | Lives
        if takes(contacts, self.drive) and not points.size:
            self._engine = Forward(self.drive, beginning)
        else:
            self._engine = Lives(self.drive, beginning, points)
        self._run_time = clock.perf_counter() - started
        started = clock.perf_counter()
        layout.in_turn(comm, lambda: self._engine.follow(range(0)))
        self.compile_time = clock.perf_counter() - started

    def __iter__(self) -> Iterator[tuple[int, int]]:
        """Do this rank's share, once; after each block (contacts done, contacts in the share)."""
        mine = layout.share(self.total, *layout.rank_and_size(self.comm))
        each = float(np.abs(np.diff(self.drive.path, prepend=0.0)).sum()) / self.contacts.mean_threshold
        for block in layout.blocks(mine, each):
            started = clock.perf_counter()
            self._engine.follow(block)
            self._run_time += clock.perf_counter() - started
            yield block.stop - mine.start, len(mine)

    def result(self) -> EnsembleResult:
        """What all ranks found; every rank must call, and gets the same bits."""
        started = clock.perf_counter()
        sums, breaks_per_rank = self._engine.sums, [self._engine.breaks]
        if self.comm is not None:
            mine, sums = sums, np.empty_like(sums)
            self.comm.Allreduce(mine, sums)  # whole numbers: the order does not matter
            breaks_per_rank = self.comm.allgather(self._engine.breaks)
        holding, force, variance = self._engine.moments(self.total, sums)
        run_time = self._run_time + clock.perf_counter() - started
        if self.comm is not None:
            run_time = max(self.comm.allgather(run_time))
        return EnsembleResult(
            path=self.drive.path,
            force=force,
            force_standard_error=np.sqrt(variance / self.total),
            holding=holding,
            holding_standard_error=np.sqrt(holding * (1.0 - holding) / self.total),
            histograms=self._engine.histograms(self.total, sums),
            breaks=sum(breaks_per_rank),
            breaks_per_rank=breaks_per_rank,
            run_time=run_time,
            compile_time=self.compile_time,
        )


def _points(histograms: npt.ArrayLike, size: int) -> npt.NDArray[np.intp]:
    points = np.atleast_1d(np.asarray(histograms))
    if not points.size:
        return np.empty(0, np.intp)
    good = points.ndim == 1 and points.dtype.kind in "iu" and ((points >= -size) & (points < size)).all()
    if not good:
        refuse("histograms", histograms, f"must be indices of points of the path, such as [0, {size - 1}]")
    return np.asarray(points % size, dtype=np.intp)


def simulate(
    contacts: Contacts,
    path: npt.ArrayLike,
    *,
    velocity: float = 1.0,
    time: npt.ArrayLike | None = None,
    n_contacts: int = 100_000,
    n_replicas: int = 1,
    seed: int = 0,
    histograms: npt.ArrayLike = (),
    comm: Any = None,
) -> EnsembleResult:
    """Follow n_contacts * n_replicas discrete contacts along the path of a rigid slider.

    A contact breaks where its stretch reaches its threshold, or before where its breaking rate says so, waits where
    there is a delay, and starts again with a fresh threshold (paper, Secs. II and IV). The contacts are independent,
    so the mean is unbiased at every number of them, and each is sampled exactly, without a time step.

    Parameters
    ----------
    contacts : origins.Contacts
        With temperature (closure "exact"), delay, re-forming and linked stiffness, each where it is there.
    path : array of shape (n,)
        Positions X (lengths, in the unit of the thresholds), from X = 0 on; it may turn round. See origins.Drive.
    velocity : float
        Speed along the path (length per time), of which only rates and delay tell.
    time : array of shape (n,), optional
        When each point is reached, instead of the velocity: for holds and velocity steps.
    n_contacts, n_replicas : int
        Replicas differ in their random numbers only.
    seed : int
        0 <= seed < 2^64. The result depends on these arguments alone, bit by bit, not on the number of ranks.
    histograms : array of int
        Indices of points of the path at which stretches and thresholds of the contacts that hold are counted.
    comm : mpi4py communicator, optional
        Its ranks share the work, and all must call; None: this process alone, mpi4py not needed.

    Raises InputError for arguments that cannot be used, and for thresholds that cannot be tabulated.
    """
    ensemble = Ensemble(
        contacts,
        path,
        velocity=velocity,
        time=time,
        n_contacts=n_contacts,
        n_replicas=n_replicas,
        seed=seed,
        histograms=histograms,
        comm=comm,
    )
    for _ in ensemble:
        pass
    return ensemble.result()
