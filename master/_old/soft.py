"""The soft slider to the tolerance asked: rides on finer and finer lattices until their slips and forces agree."""

import time
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from master._old.cohort import starting
from master._old.forward import MOST_NODES, ROUND_OFF, estimate
from master._old.law import Law
from master._old.leg import State
from master._old.regime import Regime, regime
from master._old.ride import Ride
from master.outcome import Progress, outcome, unheard
from origins import Contacts
from origins.brief import brief
from origins.drive import SlipRule

Array = npt.NDArray[np.float64]

_BEYOND = 1.7
_STALL = 20.0


@dataclass(frozen=True)
class Slips:
    """Slips in the order in which they happen; arrays of shape (n,).

    Attributes
    ----------
    drive : array
        X_T (lengths).
    before, after : array
        X at the beginning and at the end (lengths).
    force_before, force_after : array
        F/(N_c <k>) (lengths).
    drive_error : float
        Bound on the error of `drive` (a length), from the solution's own: force_error over K. X where a slip begins,
        where F + K X is flat, is not known as well.
    """

    drive: Array
    before: Array
    after: Array
    force_before: Array
    force_after: Array
    drive_error: float

    __repr__ = brief

    @property
    def drop(self) -> Array:
        """How far the force falls (lengths), which is K times the slip."""
        return self.force_before - self.force_after

    @property
    def period(self) -> float | None:
        """X_T from the last slip but one to the last (a length), to twice `drive_error`; None for fewer than two."""
        return abs(float(self.drive[-1] - self.drive[-2])) if self.drive.size > 1 else None


@dataclass(frozen=True)
class SoftSolution:
    """F and X as the drive moves, and what the slider does on the way.

    Attributes
    ----------
    path : array of shape (n,)
        Positions X_T of the drive (lengths).
    balance : float
        X_T = F(0)/K, where the drive stands at t = 0 (a length).
    position : array of shape (n,)
        Positions X of the slider (lengths); at a slip, after it.
    force : array of shape (n,)
        F/(N_c <k>) = K (X_T - X) (lengths).
    force_error : float
        Bound on the largest error, in units of the mean threshold: of `force` along the path but for points that a
        slip's own error takes to its other side, of K X_T at slips, and of F'(X) = -K where they begin.
    holding : array of shape (n,)
        Fraction of contacts that hold: 1, as slips take no time.
    slips : Slips
    period : float or None
        That of the slips: X_T from the last but one to the last (a length); None for fewer than two.
    regime : Regime
    run_time : float
        Seconds.
    nodes : int
        Nodes of the widest lattice.
    success : bool
        Whether force_error is at or below the tolerance asked for.
    message : str
    """

    path: Array
    balance: float
    position: Array
    force: Array
    force_error: float
    holding: Array
    slips: Slips
    period: float | None
    regime: Regime
    run_time: float
    nodes: int
    success: bool
    message: str

    __repr__ = brief


def solve_soft(
    contacts: Contacts,
    path: Array,
    spring: float,
    slip: SlipRule = "reset",
    tolerance: float = 1e-8,
    progress: Progress = unheard,
) -> SoftSolution:
    """Force as the drive X_T moves along `path` and pulls the slider by a spring K/(N_c <k>), at T = 0 (paper Sec.
    III D); slips as said in master.ride; arguments checked before.

    The drive begins where it balances the start, X_T = F(0)/K with the slider at X = 0.
    """
    began = time.perf_counter()
    path = np.asarray(path, dtype=float)
    unit = contacts.mean_threshold
    x = path / unit
    law, begin = _start(contacts, x, spring)
    ride, error, message = _refine(law, begin, spring, slip, x, tolerance, progress)
    success, message = outcome(contacts, error, tolerance, message)
    table = np.array([[s.drive, s.before, s.after, s.force_before, s.force_after] for s in ride.slips]).reshape(-1, 5)
    drives, before, after, above, below = unit * table.T
    slips = Slips(drives, before, after, above, below, error * unit / spring)
    return SoftSolution(
        path=path,
        balance=contacts.start.mean() / spring,
        position=unit * ride.position,
        force=unit * ride.force,
        force_error=error,
        holding=np.ones(x.size),
        slips=slips,
        period=slips.period,
        regime=regime(contacts, spring, slip, slips.drive, slips.drop, path, tolerance),
        run_time=time.perf_counter() - began,
        nodes=ride.nodes,
        success=success,
        message=message,
    )


def _start(contacts: Contacts, x: Array, spring: float) -> tuple[Law, State]:
    low, high = (float(end) / contacts.mean_threshold for end in contacts.start.span)
    furthest = max(-low, high, 0.0)
    balance = contacts.start.mean() / (contacts.mean_threshold * spring)
    points = np.append(x, [0.0, balance])
    law = Law(contacts, _BEYOND * max(float(np.ptp(points)), 1e-300) + 2.0 * furthest)
    return law, State(0.0, [starting(contacts, law)])


def _refine(
    law: Law, begin: State, spring: float, rule: SlipRule, x: Array, tolerance: float, progress: Progress
) -> tuple[Ride, float, str]:
    """A ride on lattices fine enough, its error estimate and the reason for stopping short."""
    travel = float(np.abs(np.diff(x, prepend=0.0)).sum())
    coarser: Ride | None = None
    best: tuple[Ride, float] | None = None
    difference = before = np.inf
    level = 0
    while True:
        ride = Ride(law, begin, spring, rule, x, tolerance, level)
        if coarser is not None:
            before, difference = difference, _change(ride, coarser, x, spring)
            # K X_T at slips is as large as K; where none comes, a stiff spring holds X closer than F can tell
            stiff = spring if ride.slips else min(spring, max(spring - ride.least_slope, 1.0))
            floor = ROUND_OFF * (1.0 + travel) * (1.0 + stiff)
            error = estimate(difference, before, ride.least_share, law.diverges) + floor + ride.error
            progress(error)
            if np.isfinite(before):
                if best is None or error < best[1]:
                    best = ride, error
                stalled = difference <= floor or (difference > 0.5 * before and difference < _STALL * floor)
                if best[1] <= tolerance:
                    return *best, ""
                if stalled:
                    return *best, f"round-off allows {best[1]:.1e}, above the tolerance {tolerance:.1e}"
            if ride.nodes > MOST_NODES / 4:
                best = best or (ride, np.inf)
                reached = f"error estimate {best[1]:.1e} on {best[0].nodes} nodes, above the tolerance"
                return *best, f"{reached} {tolerance:.1e}; {law.what_helps(travel / ride.nodes)}"
        coarser = ride
        level += 1


def _change(fine: Ride, coarse: Ride, x: Array, spring: float) -> float:
    """Largest difference between two rides, in force; inf where one slips more often."""
    if len(fine.slips) != len(coarse.slips):
        return np.inf
    change = np.abs(fine.force - coarse.force)
    worst = 0.0
    for one, other in zip(fine.slips, coarse.slips, strict=True):
        moved = abs(one.drive - other.drive)
        worst = max(worst, spring * moved, one.bend * abs(one.before - other.before))
        # points of the path that the slip's own error takes to its other side
        change[np.abs(x - one.drive) <= 3.0 * moved] = 0.0
    return max(worst, float(change.max()))
