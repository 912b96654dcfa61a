"""(Q16) with (Q15), Fig. A06: the speed v_c above which contacts that age no longer stick and slip.

With the paper's reset every slip puts all contacts back to Q_ini, with fresh thresholds of age 0:
each run up to a slip repeats the first, so there is stick-slip if and only if -F'(X) reaches the
spring K on the way. Slow sliding gives the thresholds time to age, which makes the drop steeper.
D_X = D/v holds for the slider's own X, as in (Q15). Where the drive's X_T = X + F/K moves at v, more
time passes before the drop and less in it, and v_c is larger; `master.solve` with a spring finds it.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from master.paper.q15_step import Q15Stepper, half_width
from master.solve import solve
from master.stick_slip.propensity import propensity
from origins import Contacts, InputError
from origins.contacts import check_contacts
from origins.errors import positive

Array = npt.NDArray[np.float64]

# Steps of (Q15) per width of start or fresh thresholds, the narrower; v_c is extrapolated in h².
_LEVELS = (4.0, 8.0, 16.0)
# Points per such width of the path on which the exact closure's steepest drop is located.
_POINTS = 20.0
# Tolerance of K* (relative to 1 + K*) and of F (in mean thresholds) with closure "exact".
_TOLERANCE = 1e-8
# Tolerance of ln v_c; and the change of ln v for the slope of K* as a finite difference.
_CLOSE, _APART = 1e-7, 0.01
# Survival of the thresholds beyond which the first drop of the force is over.
_BEYOND = 1e-3


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
    if contacts.ageing.closure == "exact":
        return _exact(contacts, spring, slowest, fastest)
    return _as_printed(contacts, spring, slowest, fastest)


def _exact(contacts: Contacts, spring: float, slowest: float, fastest: float) -> CriticalVelocity:
    """v_c where each contact's own threshold diffuses: K*(v) = K."""

    def excess(log_velocity: float) -> float:
        found = propensity(contacts, _TOLERANCE, velocity=float(np.exp(log_velocity)))
        return found.critical_spring - spring

    root = _crossing(excess, spring, slowest, fastest)
    velocity = float(np.exp(root))
    slope = (excess(root - _APART) - excess(root + _APART)) / (2.0 * _APART)
    spring_error = propensity(contacts, _TOLERANCE, velocity=velocity).critical_spring_error
    step = _narrower_width(contacts) / _POINTS
    path = np.arange(0.0, _first_drop_over(contacts), step)
    force = solve(contacts, path, _TOLERANCE, velocity=velocity).force
    error = velocity * (spring_error / abs(slope) + _CLOSE)
    return CriticalVelocity(velocity, error, _steepest(force, step)[1])


def _as_printed(
    contacts: Contacts, spring: float, slowest: float, fastest: float
) -> CriticalVelocity:
    """v_c where all contacts have one P_c, by steps of (Q15) extrapolated in h²."""
    from scipy.optimize import root_scalar

    found: list[float] = []
    for level in _LEVELS:
        step = _narrower_width(contacts) / level

        def excess(log_velocity: float, step: float = step) -> float:
            return _printed_drop(contacts, float(np.exp(log_velocity)), step)[0] - spring

        if not found:
            root = _crossing(excess, spring, slowest, fastest)
        else:  # finer steps move v_c by little
            near = np.log(found[-1])
            root = root_scalar(excess, x0=near, x1=near + _APART, xtol=_CLOSE).root
        found.append(float(np.exp(root)))
    before, best = ((4.0 * fine - coarse) / 3.0 for coarse, fine in pairwise(found))
    position = _printed_drop(contacts, found[-1], step)[1]
    return CriticalVelocity(best, abs(best - before) + _CLOSE * best, position)


def _printed_drop(contacts: Contacts, velocity: float, step: float) -> tuple[float, float]:
    """The largest -F' of the first drop of (Q15), and its X (a length)."""
    stepper = Q15Stepper(contacts, step, velocity, parts=1)
    force = [stepper.state().force]
    fallen = False
    for _ in range(int(_first_drop_over(contacts) / step) + 2):
        stepper.advance()
        force.append(stepper.state().force)
        fallen = fallen or force[-1] < force[-2]
        if fallen and force[-1] > force[-2]:
            break
    return _steepest(np.array(force), step)


def _crossing(
    excess: Callable[[float], float], spring: float, slowest: float, fastest: float
) -> float:
    """ln v where the largest -F' equals the spring; InputError unless it lies between the speeds."""
    from scipy.optimize import brentq

    slow, fast = excess(np.log(slowest)), excess(np.log(fastest))
    if not slow > 0.0 >= fast:
        raise InputError(
            f"slowest, fastest: -F' is at most {slow + spring:.4g} at v = {slowest:g} and "
            f"{fast + spring:.4g} at v = {fastest:g}; the spring {spring:g} must lie between them"
        )
    return float(brentq(excess, np.log(slowest), np.log(fastest), xtol=_CLOSE))


def _steepest(force: Array, step: float) -> tuple[float, float]:
    """The largest -F' of a force at X = 0, step, 2 step..., and its X, by the parabola through
    three differences; InputError where the force never falls."""
    fall = -np.diff(force) / step
    k = int(np.clip(fall.argmax(), 1, fall.size - 2))
    before, top, after = fall[k - 1 : k + 2]
    if not fall.max() > 0.0:
        raise InputError(
            "contacts: the force never falls on the way; there is no stick-slip at any spring"
        )
    shift = 0.5 * (before - after) / (before - 2.0 * top + after)
    return float(top - 0.25 * (before - after) * shift), float((k + 0.5 + shift) * step)


def _first_drop_over(contacts: Contacts) -> float:
    """X (a length) by which nearly all contacts have broken, fresh or aged."""
    assert contacts.ageing is not None
    highest = max(contacts.thresholds.isf(_BEYOND), contacts.ageing.final.isf(_BEYOND))
    return float(highest) - min(contacts.start.span[0], 0.0)


def _narrower_width(contacts: Contacts) -> float:
    """The narrower width, of start or of fresh thresholds (a length); single values do not count."""
    both = half_width(contacts.thresholds), half_width(contacts.start)
    return min(width for width in both if width > 0.0)
