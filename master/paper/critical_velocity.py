"""(Q16) with (Q15), Fig. A06: the speed v_c above which contacts that age no longer stick and slip.

With the paper's reset every slip puts all contacts back to Q_ini, with fresh thresholds of age 0:
each run up to a slip repeats the first, so there is stick-slip if and only if -F'(X) reaches the
spring K on the way. Slow sliding gives the thresholds time to age, which makes the drop steeper.
D_X = D/v holds for the slider's own X, as in (Q15). Where the drive's X_T = X + F/K moves at v, more
time passes before the drop and less in it, and v_c is larger; `master.solve` with a spring finds it.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.solve import solve
from master.stick_slip.extremes import critical_spring
from origins import Contacts, InputError
from origins.contacts import check_contacts
from origins.errors import positive

Array = npt.NDArray[np.float64]

# Tolerance of K* (relative to 1 + K*) and of F (in mean thresholds) with closure "exact".
_TOLERANCE = 1e-8
# Tolerance of ln v_c; and the change of ln v for the slope of K* as a finite difference.
_CLOSE, _APART = 1e-7, 0.01


@dataclass(frozen=True)
class CriticalVelocity:
    """Where stick-slip ends.

    Attributes
    ----------
    velocity, velocity_error : float
        v_c, a length per time.
    position : float
        X at which -F' just reaches K there (a length).
    """

    velocity: float
    velocity_error: float
    position: float


def critical_velocity(
    contacts: Contacts, spring: float, slowest: float, fastest: float
) -> CriticalVelocity:
    """(Q16): v_c above which a soft slider whose contacts age no longer sticks and slips.

    It is where the steepest -F'(X) from Q_ini and fresh thresholds just reaches the spring, D_X =
    D/v on the slider's own X. With closure "exact" that is where K* of `master.propensity` is K;
    with "paper" the first drop of (Q15) counts, as contacts outrun P_c after it.

    Parameters
    ----------
    contacts : Contacts
        With `ageing`, in the closure that it names, and any start; no other law of the contact.
    spring : float
        K/(N_c <k>).
    slowest, fastest : float
        Two speeds, a length per time, that v_c lies between.

    Returns
    -------
    CriticalVelocity
        Its error is estimated from that of K*, or from the change with finer steps.

    Raises
    ------
    InputError
        Where the drop is steeper than the spring at both speeds, or at neither; for contacts that
        do not age, and for other laws of the contact beside ageing.
    """
    spring = positive("spring", spring)
    slowest, fastest = positive("slowest", slowest), positive("fastest", fastest)
    if contacts.ageing is None:
        told = "contacts.ageing: is None; "
        if not contacts.laws:
            raise InputError(f"{told}without ageing nothing depends on the speed")
        raise InputError(
            f"{told}v_c is that of contacts that age by diffusion. What a temperature, a delay or "
            "thresholds that grow make of K* at each speed is master.phase_line(contacts, velocity)"
        )
    check_contacts(contacts, "master.critical_velocity", ("ageing",))
    found = _exact_drop if contacts.ageing.closure == "exact" else _printed_drop
    return _where_it_is(cache(partial(found, contacts)), spring, slowest, fastest)


class _Drop(NamedTuple):
    """The largest -F' of the first drop of the force, its error, and its X (a length)."""

    steepest: float
    error: float
    position: float


def _where_it_is(
    drop: Callable[..., _Drop], spring: float, slowest: float, fastest: float
) -> CriticalVelocity:
    """v_c where the largest -F' equals the spring; InputError unless it lies between the speeds."""
    from scipy.optimize import brentq

    def excess(log_velocity: float) -> float:
        return drop(float(np.exp(log_velocity))).steepest - spring

    slow, fast = excess(np.log(slowest)), excess(np.log(fastest))
    if not slow > 0.0 >= fast:
        raise InputError(
            f"slowest, fastest: -F' is at most {slow + spring:.4g} at v = {slowest:g} and "
            f"{fast + spring:.4g} at v = {fastest:g}; the spring {spring:g} must lie between them"
        )
    root = brentq(excess, np.log(slowest), np.log(fastest), xtol=_CLOSE)
    slope = (excess(root - _APART) - excess(root + _APART)) / (2.0 * _APART)
    finer = drop(float(np.exp(root)), finer=True)  # moves v_c by little
    velocity = float(np.exp(root + (finer.steepest - spring) / slope))
    error = velocity * (finer.error / abs(slope) + _CLOSE)
    return CriticalVelocity(velocity, error, finer.position)


def _exact_drop(contacts: Contacts, velocity: float, finer: bool = False) -> _Drop:
    """Where each contact's own threshold diffuses; `finer`: with its X."""
    steepest, error = critical_spring(contacts, velocity, _TOLERANCE)
    if not finer:
        return _Drop(steepest, error, np.nan)
    from master.paper.q15_step import narrowest

    step = narrowest(contacts.thresholds, contacts.start) / 20.0
    path = np.arange(0.0, _first_drop_over(contacts), step)
    force = solve(contacts, path, _TOLERANCE, velocity=velocity).force
    return _Drop(steepest, error, _steepest(force, step).position)


def _printed_drop(contacts: Contacts, velocity: float, finer: bool = False) -> _Drop:
    """Where all contacts have one P_c: the first drop of (Q15), extrapolated in h²."""
    from master.paper.q15_step import Q15Stepper, narrowest

    drops = []
    for level in (4.0, 8.0, 16.0)[: 2 + finer]:
        step, force = narrowest(contacts.thresholds, contacts.start) / level, list[float]()
        stepper, fallen = Q15Stepper(contacts, step, velocity), False
        for _ in range(int(_first_drop_over(contacts) / step) + 3):
            force.append(stepper.state().force)
            stepper.advance()
            if fallen and force[-1] > force[-2]:
                break
            fallen = fallen or (len(force) > 1 and force[-1] < force[-2])
        drops.append(_steepest(np.array(force), step))
    best = [(4.0 * fine.steepest - coarse.steepest) / 3.0 for coarse, fine in pairwise(drops)]
    return _Drop(best[-1], abs(best[-1] - best[0]), drops[-1].position)


def _steepest(force: Array, step: float) -> _Drop:
    """The largest -F' of a force at X = 0, step, 2 step..., by the parabola through three
    differences; InputError where the force never falls."""
    fall = -np.diff(force) / step
    k = int(np.clip(fall.argmax(), 1, fall.size - 2))
    before, top, after = fall[k - 1 : k + 2]
    if not fall.max() > 0.0:
        raise InputError(
            "contacts: the force never falls on the way; there is no stick-slip at any spring"
        )
    shift = 0.5 * (before - after) / (before - 2.0 * top + after)
    steepest = float(top - 0.25 * (before - after) * shift)
    return _Drop(steepest, np.nan, float((k + 0.5 + shift) * step))


def _first_drop_over(contacts: Contacts) -> float:
    """X (a length) by which nearly all contacts have broken, fresh or aged."""
    assert contacts.ageing is not None
    highest = max(contacts.thresholds.isf(1e-3), contacts.ageing.final.isf(1e-3))
    return float(highest) - min(contacts.start.span[0], 0.0)
