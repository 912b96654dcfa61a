"""Thresholds that all grow by one factor g with the age of their contact, in the ensemble: the goal of a contact is its
threshold at age 0.

origins/laws/proportional.py says what follows from any g. Lengths and ages are those of eq_model.laws.growing; the unit
of ages is the law's `time_unit`. Kernels find g and its slope by the class of the numbers that the law has compiled;
other laws are called in plain Python, some 40 µs a break.
"""

from typing import Any, NamedTuple

import numpy as np

from eq_model.compiling import bare, real, unsigned, whole
from eq_model.contact import ROWS, by_law
from eq_model.laws.growing import GROWTHS, Growth
from eq_model.laws.own import Address
from eq_model.laws.settings import check_name
from eq_model.whole_drive import WholeDrive
from origins import Contacts, ProportionalGrowth
from origins.laws.compiled import CompiledFactor
from origins.thresholds.law import Array

SECONDS = 1e-7  # of a break, or a step; see settings.KERNELS
# of an age and its unit together: the step of the slope of a factor that is called
_STEP = 1e-6
# slope of what is left of a way, below which Newton's method leads too far
_FLAT = 1e-3

FACTORS: dict[type, CompiledFactor] = {}
factor = by_law(lambda growth: FACTORS[growth].factor)
slope = by_law(lambda growth: FACTORS[growth].slope)


class Proportional(NamedTuple):
    """Growth of thresholds by one factor; see growing.Growth."""

    time: float
    age: float
    growth: Any  # numbers of the factor, the first argument of `factor` and `slope`
    fraction: float  # threshold at age 0 over the drawn one, which is that at X = 0
    warm: bool
    rates: Any
    unit: float


class CalledFactor(NamedTuple):
    """A factor in plain Python, and its slope."""

    factor: Any
    slope: Any


def factor_of(law: ProportionalGrowth) -> Any:
    """The numbers of the law's factor, by the class of which kernels find the functions."""
    found = law.compiled_factor or _called(law)
    FACTORS.setdefault(type(found.law), found)
    check_name(found.law, law.law, law)
    return found.law


def _called(law: ProportionalGrowth) -> CompiledFactor:
    """Calls of the law itself. The slope is that ahead, so that of a concave factor it is rather too small."""

    def grown(age: float) -> float:
        return float(law.factor(age * law.time_unit))

    def rise(age: float) -> float:
        step = _STEP * (1.0 + age)
        return (grown(age + step) - grown(age)) / step

    return CompiledFactor(
        CalledFactor(Address(grown, 1), Address(rise, 1)),
        factor=lambda growth, age: growth.factor(real(age)),
        slope=lambda growth, age: growth.slope(real(age)),
    )


def make(contacts: Contacts, drive: WholeDrive, *heat: Any) -> Proportional:
    """The growth of these contacts; see settings.KERNELS."""
    law = contacts.growing
    assert isinstance(law, ProportionalGrowth)
    pinned_for = law.start_pinned_for
    fraction = 1.0 / float(law.factor(pinned_for))
    return Proportional(law.time_unit, pinned_for / law.time_unit, factor_of(law), fraction, *heat)


def often(contacts: Contacts, lasts: Array, moved: Array, law: Proportional) -> float:
    """How often a contact breaks at most, while thresholds are those of X = 0; see settings.KERNELS."""
    return float(moved.sum()) / contacts.mean_threshold


def _born(law, contact):  # type: ignore[no-untyped-def]
    """Contacts of the start and later ones have thresholds of one law at age 0."""
    return 0.0 if contact.fresh else law.age, law.fraction * real(contact.threshold)


@bare
def _meeting(near, pace, room, age, goal, growth):  # type: ignore[no-untyped-def]
    """Newton's method for f = near + t - goal g(age + pace t), which is convex and has one root t > 0 at most.

    A step from where f rises leads above the root, and all that follow stay there. Where it falls, or hardly rises, the
    way is twice as long, or that of the iteration near + t = threshold, if it is longer.
    """
    at = max(goal * factor(growth, age) - near, 0.0)
    for _ in range(200):
        missing = goal * factor(growth, age + pace * at) - near - at
        rise = 1.0 - goal * pace * slope(growth, age + pace * at)
        if rise < _FLAT:
            at += max(at, missing)
            continue
        step = missing / rise
        at += step
        if abs(step) <= max(1e-6 * at, 0.25):
            break  # what is left is about the square of the step over twice the way
    return at if at <= room else np.inf


def _in_row(law, n, x, breaks_at, lanes, work):  # type: ignore[no-untyped-def]
    """Set `breaks_at`, the stretches at which n contacts that form relaxed break if their legs go on; to -1 for those
    of the start, those with heat, and where three steps of Newton's method, as in `_meeting`, are not enough.

    Steps of several contacts do not wait for one another here, as those of one in `_meeting` do.
    """
    paces, legs, initial, growth = work.drive.paces, lanes.leg, lanes.initial, law.growth
    for i in range(unsigned(0 if law.warm else n)):
        goal, pace = law.fraction * real(x[i]), paces[unsigned(legs[i])] / law.time
        at, step = goal, 0.0
        for _ in range(3):
            missing = goal * factor(growth, pace * at) - at
            # as g is concave, this falls by 1/g at the root, and never by so little where it is nearly 0
            step = missing / max(1.0 - goal * pace * slope(growth, pace * at), _FLAT)
            at += step
        converged = abs(step) <= max(1e-6 * at, 0.25) and initial[i] == 0
        breaks_at[i] = whole(at + 0.5) if converged else whole(-1)
    if law.warm:
        breaks_at[:n] = -1
    return breaks_at


ROWS[Proportional] = _in_row
GROWTHS[Proportional] = Growth(
    _born,
    lost=lambda law, pace: -1.0,  # all hold
    meeting=lambda law, near, pace, room, age, goal: _meeting(
        near, pace, room, age, goal, law.growth
    ),
    threshold=lambda law, goal, age: goal * factor(law.growth, age),
    ahead=lambda law, contact: contact.breaks_at,
    rises=True,
)
