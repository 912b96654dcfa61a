"""Thresholds that grow with the logarithm of the age in the ensemble: the goal of a contact is its threshold at age 0.

origins/laws/strengthening.py has the same formulas in plain numpy. Lengths and ages are those of eq_model.laws.growing;
the unit of ages is τ_0.
"""

from typing import Any, NamedTuple

import numpy as np

from eq_model.compiling import bare, real, unsigned, whole
from eq_model.contact import ROWS
from eq_model.laws.growing import GROWTHS, Growth
from eq_model.whole_drive import WholeDrive
from origins import Contacts
from origins.thresholds.law import Array

SECONDS = 1e-7  # of a break, or a step; see settings.KERNELS


class Logarithmic(NamedTuple):
    """Growth of thresholds by the factor 1 + β ln(1 + age); see growing.Growth."""

    time: float  # τ_0
    age: float
    beta: float
    fraction: float  # threshold at age 0 over the drawn one, which is that at X = 0
    warm: bool
    rates: Any
    unit: float


def make(contacts: Contacts, drive: WholeDrive, *heat: Any) -> Logarithmic:
    """The growth of these contacts; see settings.KERNELS."""
    law = contacts.strengthening
    assert law is not None
    age = law.start_pinned_for / law.time_unit
    fraction = 1.0 / float(law.factor(law.start_pinned_for))
    return Logarithmic(law.time_unit, age, law.beta, fraction, *heat)


def often(contacts: Contacts, lasts: Array, moved: Array, law: Logarithmic) -> float:
    """How often a contact breaks at most, while thresholds are those of X = 0; see settings.KERNELS."""
    return float(moved.sum()) / contacts.mean_threshold


def _born(law, contact):  # type: ignore[no-untyped-def]
    """Contacts of the start and later ones have thresholds of one law at age 0."""
    return 0.0 if contact.fresh else law.age, law.fraction * real(contact.threshold)


@bare
def _meeting(near, pace, room, age, goal, beta):  # type: ignore[no-untyped-def]
    """Newton's method for f = near + t - goal (1 + β ln(1 + age + pace t)), which is convex and has one root t > 0.

    Where f falls, or hardly rises, the step is that of the iteration near + t = threshold, which approaches the root
    from its side. A step of Newton's leads above the root, and all that follow stay there.
    """
    at = max(goal * (1.0 + beta * np.log1p(age)) - near, 0.0)
    for _ in range(200):
        later = 1.0 + age + pace * at
        slope = 1.0 - goal * beta * pace / later
        step = near + at - goal * (1.0 + beta * np.log(later))
        if slope > 0.1:
            step /= slope
        at -= step
        if abs(step) <= max(1e-6 * at, 0.25):
            break  # what is left is about the square of the step over twice the way
    return at if at <= room else np.inf


def _in_row(law, n, x, breaks_at, lanes, work):  # type: ignore[no-untyped-def]
    """Set `breaks_at`, the stretches at which n contacts that form relaxed break if their legs go on; to -1 for those
    of the start, those with heat, and where three steps of Newton's method, as in `_meeting`, are not enough.

    Steps of several contacts do not wait for one another here, as those of one in `_meeting` do.
    """
    paces, legs, initial = work.drive.paces, lanes.leg, lanes.initial
    for i in range(unsigned(0 if law.warm else n)):
        goal, pace = law.fraction * real(x[i]), paces[unsigned(legs[i])] / law.time
        at, step = goal, 0.0
        for _ in range(3):
            later = 1.0 + pace * at
            step = at - goal * (1.0 + law.beta * np.log(later))
            step /= 1.0 - goal * law.beta * pace / later
            at -= step
        converged = abs(step) <= max(1e-6 * at, 0.25) and initial[i] == 0
        breaks_at[i] = whole(at + 0.5) if converged else whole(-1)
    if law.warm:
        breaks_at[:n] = -1
    return breaks_at


ROWS[Logarithmic] = _in_row
GROWTHS[Logarithmic] = Growth(
    _born,
    lost=lambda law, pace: -1.0,  # all hold
    meeting=lambda law, near, pace, room, age, goal: _meeting(
        near, pace, room, age, goal, law.beta
    ),
    threshold=lambda law, goal, age: goal * (1.0 + law.beta * np.log1p(age)),
    ahead=lambda law, contact: contact.breaks_at,
    rises=True,
)
