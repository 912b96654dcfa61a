"""The discrete ensemble: contacts independent of one another, followed along the path of a rigid slider."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import reduce
from time import perf_counter
from typing import Any, overload

import numpy as np
import numpy.typing as npt

from eq_model import layout
from eq_model.beginning import Beginning
from eq_model.coupled import SLIP_FRACTION, CoupledEnsemble, CoupledResult
from eq_model.ensemble_result import EnsembleResult
from eq_model.forward import Forward, takes
from eq_model.lives import Lives
from eq_model.often import check_often
from eq_model.state import State
from eq_model.tally import Tally
from origins import Contacts, Drive
from origins.contacts import LAWS, check_contacts
from origins.drive import SlipRule
from origins.errors import InputError, positive, refuse, whole
from origins.streams import MOST_REPLICAS, key_of

Array = npt.NDArray[np.float64]

_MOST_CONTACTS = 1 << 37
_LONG = 0.5  # seconds of a block: who stops a run waits for its end
# contacts of the first block where rates may break each of them millions of times; fewer where they may take so many
# breaks or steps of some tenths of a microsecond each that a block would take too long
_UNKNOWN, _QUICK = 256, 2e-7


class Ensemble:
    """An ensemble under way: iterate to work through it block by block, then ask for the result.

        ensemble = Ensemble(contacts, path, n_contacts=100_000)
        for done, total in ensemble:
            ...                       # contacts this rank has done, of its share
        result = ensemble.result()    # all ranks together

    Parameters and errors as for `simulate`; besides, `earlier` are the states of all ranks of an ensemble of the same
    parameters that was cut short: what these did is not done again, and the result is the same to the last bit.

    Attributes: `total`, contacts in all; `expected`, how many of them will be followed, which with a tolerance is known
    better after each round; `clock`, which returns seconds: the size of the blocks, the wall time and the run time go
    by it. Another clock may take its place, on the class or before the first block, so that work is counted instead.
    """

    clock: Callable[[], float] = staticmethod(perf_counter)

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
        started = self.clock()
        if comm is not None and not hasattr(comm, "Get_rank"):
            refuse("comm", comm, "must be a communicator of mpi4py, such as MPI.COMM_WORLD, or None for this process")
        self.contacts, self.comm = contacts, comm
        self.n_contacts, replicas = whole("n_contacts", n_contacts, 1), whole("n_replicas", n_replicas, 1)
        if replicas >= MOST_REPLICAS:
            refuse("n_replicas", n_replicas, f"must be below {MOST_REPLICAS}; take more contacts instead")
        self.total = self.n_contacts * replicas
        if self.total > _MOST_CONTACTS:
            refuse("n_contacts", n_contacts, f"times n_replicas must be at most {_MOST_CONTACTS}")
        self.expected, self._stopped = self.total, False
        self.drive = Drive(path, velocity, time)
        often = check_often(contacts, self.drive)
        beginning = Beginning(contacts, self.n_contacts, key_of(seed))
        points = _points(histograms, self.drive.path.size)
        self._engine: Forward | Lives
        if takes(contacts, self.drive) and not points.size:
            self._engine = Forward(self.drive, beginning)
        else:
            self._engine = Lives(self.drive, beginning, points)
        self._each = _QUICK * (often + self._engine.steps)
        self._tolerance = None if tolerance is None else positive("tolerance", tolerance, "such as 1e-4")
        self._wall_time = None if wall_time is None else positive("wall_time", wall_time)
        ready = self.clock() - started
        started = self.clock()
        layout.in_turn(comm, lambda: self._engine.follow(range(0)))
        self.compile_time = self.clock() - started
        sums, counts = np.zeros((2, self._engine.size), np.int64), Tally.zeros(points.size, self.total)
        nothing = State(sums, counts, 0, 0, [], ready)
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
        each = float(np.abs(np.diff(self.drive.path, prepend=0.0)).sum()) / self.contacts.mean_threshold
        size, most = layout.block_size(each * self._engine.weight), layout.block_size(each)
        laws = self.contacts.thermal, self.contacts.ageing, self.contacts.grains
        if any(law is not None for law in laws):
            size = min(size, _UNKNOWN, int(max(_LONG / max(self._each, 1e-9), 1.0)))
        begun, done = self.clock(), 0
        for one_round in layout.rounds(self.total, self._tolerance is not None):
            mine = layout.share(layout.left(one_round, self._before), rank, ranks)
            total, late = done + sum(map(len, mine)), False
            while mine and not late:
                block, rest = layout.cut(mine[0], size)
                mine = [rest, *mine[1:]] if len(rest) else mine[1:]
                started = self.clock()
                added = self._engine.follow(block)
                seconds = self.clock() - started
                found = self._state.after(block, *added)
                # one assignment: whatever interrupts, the state is that of whole blocks
                self._state = replace(found, run_time=found.run_time + self.clock() - started)
                if len(block) == size and seconds > _LONG:
                    size = max(size // 2, 1)
                elif 4.0 * seconds < _LONG:
                    size = min(2 * size, most)
                done += len(block)
                yield done, total
                late = self._stopped or (self._wall_time is not None and self.clock() - begun > self._wall_time)
            for _ in layout.meeting(self.comm):
                yield done, total
            if self._enough(one_round, late or self._stopped):
                return

    def stop(self) -> None:
        """Begin no further block of this rank's share: the result will be that of what is finished."""
        self._stopped = True

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
        wanted = self._wanted(found.contacts, float(found.force_standard_error.max()) / self.contacts.mean_threshold)
        self.expected = next((part.stop for part in layout.rounds(self.total, True) if part.stop >= wanted), self.total)
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

    def _result(self, counts: Tally | None = None) -> EnsembleResult:
        """With the histograms of this rank's `counts` and the other ranks', or without any."""
        started, state = self.clock(), self._state
        sums, states = state.sums, [state]
        if self.comm is not None:
            sums = np.empty_like(state.sums)
            self.comm.Allreduce(state.sums, sums)  # whole numbers: the order does not matter
            states = self.comm.allgather(state.without_sums())
        done = sorted((part for one in states for part in one.done), key=lambda part: part.start)
        contacts = sum(map(len, done))
        if not contacts:
            raise InputError("ensemble: no block of contacts is finished yet; iterate over it first")
        holding, force, variance = self._engine.moments(done, sums)
        error = np.sqrt(variance / contacts)
        histograms = [] if counts is None else self._engine.histograms(contacts, counts.of_all(self.comm))
        run_time = max(one.run_time for one in states) + self._slowest(self.clock() - started)
        success, message = self._judge(contacts, error)
        return EnsembleResult(
            path=self.drive.path,
            force=force,
            force_standard_error=error,
            step_error=self._engine.step_error(done, sums),
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
            more, unmet = self._wanted(contacts, largest), f"{found}, above the tolerance {self._tolerance:.1e}"
            if not np.isfinite(largest):
                return False, f"{unmet}; take at least two"
            if more > _MOST_CONTACTS:
                return False, f"{unmet}; it takes more than {_MOST_CONTACTS:.1e} contacts, the most there can be"
            return False, f"{unmet}; it takes about {more:.1e} contacts"
        if contacts < self.total:
            return False, f"{found}: stopped before all {self.total} were followed"
        return True, found


def _points(histograms: npt.ArrayLike, size: int) -> npt.NDArray[np.intp]:
    points = np.atleast_1d(np.asarray(histograms))
    if not points.size:
        return np.empty(0, np.intp)
    good = points.ndim == 1 and points.dtype.kind in "iu" and ((points >= -size) & (points < size)).all()
    if not good:
        refuse("histograms", histograms, f"must be indices of points of the path, such as [0, {size - 1}]")
    return np.asarray(points % size, dtype=np.intp)


@overload
def simulate(contacts: Contacts, path: npt.ArrayLike, *, spring: float, **more: Any) -> CoupledResult: ...
@overload
def simulate(contacts: Contacts, path: npt.ArrayLike, *, spring: None = None, **more: Any) -> EnsembleResult: ...
def simulate(  # type: ignore[misc]  # the arguments are told once, below
    contacts: Contacts,
    path: npt.ArrayLike,
    *,
    velocity: float = 1.0,
    time: npt.ArrayLike | None = None,
    spring: float | None = None,
    slip: SlipRule = "reset",
    slip_fraction: float | None = None,
    n_contacts: int = 100_000,
    n_replicas: int = 1,
    seed: int = 0,
    tolerance: float | None = None,
    wall_time: float | None = None,
    histograms: npt.ArrayLike = (),
    comm: Any = None,
) -> EnsembleResult | CoupledResult:
    """Follow n_contacts * n_replicas discrete contacts along the path of a slider, rigid or pulled through a spring.

    A contact breaks where its stretch reaches its threshold, or before where its breaking rate says so, waits where
    there is a delay, and starts again with a fresh threshold (paper, Secs. II and IV). The contacts are independent,
    so the mean is unbiased at every number of them, and each is sampled exactly, without a time step; only a threshold
    that diffuses takes steps, exact but for how the way between two of them bends (`step_error`).

    With a `spring` the contacts of one replica are coupled: the path is that of the drive, X_T, and one slider has
    K (X_T - X) = sum of k_i x_i. Every break moves it on, more may break at the same X_T, and what breaks there is one
    avalanche (eq_model.coupled; in plain Python in tests/plain_coupled.py). Delay and linked stiffness are taken, and
    contacts that form again stretched with slip "instant"; T = 0, thresholds do not change, and the drive never turns.

    Parameters
    ----------
    contacts : origins.Contacts
        With temperature and ageing (closure "exact"), delay, re-forming, linked stiffness and thresholds that grow with
        their age, each where it is there.
    path : array of shape (n,)
        Positions X (lengths, in the unit of the thresholds), from X = 0 on; it may turn round. See origins.Drive.
    velocity : float
        Speed along the path (length per time), of which only rates and delay tell.
    time : array of shape (n,), optional
        When each point is reached, instead of the velocity: for holds and velocity steps.
    spring : float, optional
        K/(N_c <k>) of a soft slider; None: it is rigid.
    slip : "reset", "reform-after" or "instant"
        With a spring, when broken contacts form again. "instant": at once. "reform-after": when the avalanche ends, or
        the delay after it. "reset": as that, but once an avalanche has broken `slip_fraction` of the contacts all are
        drawn anew, those that are out too, and the slider moves to X_T.
    slip_fraction : float, optional
        Share of a replica's contacts that an avalanche breaks at least to be told as a slip; None: 0.2. Before a slip
        avalanches break up to 2 N^(-1/3) of them, at N = 4,000 0.13.
    n_contacts, n_replicas : int
        Replicas differ in their random numbers only. Standard errors of coupled contacts are those between replicas.
    seed : int
        0 <= seed < 2^64. The result depends on these arguments alone, bit by bit, not on the number of ranks.
    tolerance : float, optional
        Largest standard error of the force wanted, in units of the mean threshold: contacts are added, twice as many
        each time, until it is reached or all n_contacts * n_replicas are followed.
    wall_time : float, optional
        Seconds after which no further block is begun: then the result does depend on the machine.
    histograms : array of int
        Indices of points of the path at which stretches and thresholds of the contacts that hold are counted: in memory
        for one block of contacts, 32 kB each, and for all in a temporary file.
    comm : mpi4py communicator, optional
        Its ranks share the work, and all must call; None: this process alone, mpi4py not needed.

    Returns an EnsembleResult, with a spring a CoupledResult.

    Raises InputError for arguments that cannot be used, for thresholds that cannot be tabulated, and where there is no
    room for what histograms count.
    """
    if spring is not None:
        if tolerance is not None or np.size(histograms):
            name, value = ("histograms", histograms) if tolerance is None else ("tolerance", tolerance)
            refuse(name, value, "is of independent contacts; leave it out with a spring, and give n_replicas")
        coupled = CoupledEnsemble(
            contacts,
            path,
            velocity=velocity,
            time=time,
            spring=spring,
            slip=slip,
            slip_fraction=SLIP_FRACTION if slip_fraction is None else slip_fraction,
            n_contacts=n_contacts,
            n_replicas=n_replicas,
            seed=seed,
            wall_time=wall_time,
            comm=comm,
        )
        for _ in coupled:
            pass
        return coupled.result()
    if slip_fraction is not None:
        refuse("slip_fraction", slip_fraction, "is of a soft slider; give its spring, or leave it out")
    Drive(path, velocity, time, None, slip)  # refuses a slip of a rigid slider
    ensemble = Ensemble(
        contacts,
        path,
        velocity=velocity,
        time=time,
        n_contacts=n_contacts,
        n_replicas=n_replicas,
        seed=seed,
        tolerance=tolerance,
        wall_time=wall_time,
        histograms=histograms,
        comm=comm,
    )
    for _ in ensemble:
        pass
    return ensemble.result()
