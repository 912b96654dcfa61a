"""Stick-slip of contacts that age: the speed above which the first drop of the force is no longer unstable (Fig. A06).

With the paper's reset every slip puts all contacts back to Q_ini, with fresh thresholds of age 0, so that each run up
to a slip repeats the first: there is stick-slip if and only if -F'(X) reaches the spring K on the way. Slow sliding
gives the thresholds time to age, which makes the drop steeper; v_c is where its steepest place just reaches K. D_X =
D/v holds for the slider's own X, as in (Q15). On the drive's clock, X + F/K, more time passes before the drop, and in
it ever less, so that it is steeper: there v_c is larger, and master.solve with a spring tells.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from master._old.ageing_stepper import PaperStepper, check_closure, enough_cells
from master._old.cycle import Cycle
from master._old.problem import Problem
from master._old.renewal import LaterReleased
from origins import Contacts, InputError
from origins.contacts import check_contacts
from origins.errors import positive

_LEVELS = {"paper": (4.0, 8.0, 16.0), "exact": (12.0, 20.0)}  # steps to the narrower of start and fresh thresholds
_CLOSE = 1e-7
_TOLERANCE = 1e-9
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


def critical_velocity(contacts: Contacts, spring: float, slowest: float, fastest: float) -> CriticalVelocity:
    """Speed v_c above which a soft slider whose contacts age no longer sticks and slips (paper, Fig. A06).

    With the paper's reset each run up to a slip repeats the first, from Q_ini and fresh thresholds of age 0: v_c is
    where the steepest -F'(X) of the first drop just reaches the spring, D_X = D/v on the slider's own X.

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
        With the error that finer steps tell.

    Raises
    ------
    InputError
        Where the drop is steeper than the spring at both speeds, or at neither; for contacts that do not age, and for
        other laws of the contact beside ageing.
    """
    from scipy.optimize import root_scalar

    spring = positive("spring", spring)
    slowest, fastest = positive("slowest", slowest), positive("fastest", fastest)
    ageing = contacts.ageing
    if ageing is None:
        if contacts.thermal is not None or contacts.delay is not None or contacts.grains is not None:
            raise InputError(
                "contacts.ageing: is None; v_c is that of contacts that age by diffusion. What a temperature, a delay "
                "or thresholds that grow make of K* at each speed is master.phase_line(contacts, velocity)"
            )
        raise InputError("contacts.ageing: is None; without ageing nothing depends on the speed")
    check_contacts(contacts, "master.critical_velocity", ("ageing",))
    if ageing.closure == "paper":
        check_closure(contacts)
    fall = _exact_fall if ageing.closure == "exact" else _paper_fall
    narrow = _narrow(contacts)
    found: list[float] = []
    for level in _LEVELS[ageing.closure]:

        def excess(log_velocity: float, step: float = narrow / level) -> float:
            return fall(contacts, float(np.exp(log_velocity)), step)[0] - spring

        if found:
            near = np.log(found[-1])
            root = root_scalar(excess, method="secant", x0=near, x1=near + 0.01, xtol=_CLOSE).root
        else:
            at_slowest, at_fastest = excess(np.log(slowest)), excess(np.log(fastest))
            if not at_slowest > 0.0 >= at_fastest:
                raise InputError(
                    f"slowest, fastest: -F' is at most {at_slowest + spring:.4g} at v = {slowest:g} and "
                    f"{at_fastest + spring:.4g} at v = {fastest:g}; the spring {spring:g} must lie between them"
                )
            root = root_scalar(excess, method="brentq", bracket=(np.log(slowest), np.log(fastest)), xtol=_CLOSE).root
        found.append(float(np.exp(root)))
    position = fall(contacts, found[-1], narrow / _LEVELS[ageing.closure][-1])[1]
    if ageing.closure == "exact":
        return CriticalVelocity(found[-1], abs(found[-1] - found[-2]) + _CLOSE * found[-1], position)
    # errors fall as the square of the step
    better = [(4.0 * fine - coarse) / 3.0 for coarse, fine in pairwise(found)]
    return CriticalVelocity(better[-1], abs(better[-1] - better[-2]) + _CLOSE * better[-1], position)


def _narrow(contacts: Contacts) -> float:
    """Width of the narrower of start and fresh thresholds."""
    law, start = contacts.thresholds, contacts.start
    width = float(law.isf(0.16) - law.ppf(0.16)) / 2.0
    if start.is_single:
        return width
    return min(width, float(start.isf(0.16) - start.ppf(0.16)) / 2.0)


def _exact_fall(contacts: Contacts, velocity: float, step: float) -> tuple[float, float]:
    """Steepest -F' of the first drop, and where: each contact's own threshold diffuses."""
    cycle = Cycle(contacts, velocity, _TOLERANCE)
    unit = cycle.unit
    end = (float(cycle.law.isf(_BEYOND)) - min(contacts.start.span[0], 0.0)) / unit
    problem = Problem(contacts, end, _TOLERANCE, cycle)
    x = np.arange(0.0, end, step / unit)[1:]
    later = LaterReleased(problem, step / unit, x, _TOLERANCE)
    return _steepest(later.rate(x) - problem.known_rate(x), x * unit)


def _paper_fall(contacts: Contacts, velocity: float, step: float) -> tuple[float, float]:
    """The same for one P_c for all contacts, by steps of (Q15)."""
    stepper = PaperStepper(contacts, step, velocity, "positivity", enough_cells(contacts, step))
    assert contacts.ageing is not None
    end = max(float(contacts.thresholds.isf(_BEYOND)), float(contacts.ageing.final.isf(_BEYOND)))
    force = [stepper.state()[0]]
    fallen = False
    for _ in range(int((end - min(contacts.start.span[0], 0.0)) / step) + 2):
        stepper.advance()
        force.append(stepper.state()[0])
        fallen = fallen or force[-1] < force[-2]
        if fallen and force[-1] > force[-2]:
            break
    fall = -np.diff(force) / step
    return _steepest(fall, step * (np.arange(fall.size) + 0.5))


def _steepest(fall: npt.NDArray[Any], x: npt.NDArray[Any]) -> tuple[float, float]:
    """Largest -F' of the first stretch over which the force falls, by the parabola through three points."""
    falling = np.flatnonzero(fall > 0.0)
    if not falling.size:
        raise InputError("contacts: the force never falls on the way; there is no stick-slip at any spring")
    first = int(falling[0])
    rises = np.flatnonzero(fall[first:] <= 0.0)
    last = first + int(rises[0]) if rises.size else fall.size - 1
    k = int(np.clip(first + fall[first : last + 1].argmax(), 1, fall.size - 2))
    before, top, after = fall[k - 1 : k + 2]
    shift = 0.5 * (before - after) / (before - 2.0 * top + after)
    return float(top - 0.25 * (before - after) * shift), float(x[k] + shift * (x[1] - x[0]))
