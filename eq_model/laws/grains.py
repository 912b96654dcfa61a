"""Growing grains in the ensemble: what identifies a contact for life is the cumulative hazard at which it breaks, of
the law of thresholds at its stretch and age.

origins/grains/contact.py and lifshitz_slyozov.py have the same formulas in plain numpy. Lengths and ages are those of
eq_model.laws.growing; the unit of ages is tau_m.
"""

from typing import Any, NamedTuple

import numpy as np

from eq_model.compiling import bare, inlined, real
from eq_model.laws.growing import GROWTHS, Growth
from eq_model.whole_drive import WholeDrive
from origins import Contacts
from origins.thresholds.law import Array

SECONDS = 1e-7  # of a break, or a step; see settings.KERNELS


class Grains(NamedTuple):
    """Growth of thresholds with the age of their grains; see growing.Growth."""

    time: float  # tau_m, until grains pin
    age: float
    root: float  # B^(1/2), per unit
    warm: bool
    rates: Any
    unit: float


def make(contacts: Contacts, drive: WholeDrive, *heat: Any) -> Grains:
    """The growth of these contacts; see settings.KERNELS."""
    grains = contacts.grains
    assert grains is not None
    time, root = grains.first_pinning_time, float(np.sqrt(grains.growth.B)) * drive.unit
    return Grains(time, (grains.age or 0.0) / time - 1.0, root, *heat)


def often(contacts: Contacts, lasts: Array, moved: Array, law: Grains) -> float:
    """How often a contact pins, where a threshold is at most about alpha (time)^(1/3)/B^(1/2); see settings.KERNELS."""
    assert contacts.grains is not None
    growth = contacts.grains.growth
    with np.errstate(all="ignore"):
        holds = (growth.alpha * lasts / (np.sqrt(growth.B) * moved)) ** 1.5
    pinned = growth.first_pinning_time + np.nan_to_num(holds)
    return float((lasts / pinned).sum())


@inlined
def _density(y, free):  # type: ignore[no-untyped-def]
    """The derivative of psi; free = 1 - y."""
    return 3.0 * y * y / ((2.0 + y) * free * free)


@bare
def _beyond(q, first, free):  # type: ignore[no-untyped-def]
    """psi(y) - psi(first) of Lifshitz and Slyozov's law, q = 1/(1 - y) - 1/(1 - first), free = 1 - first."""
    gap = free * (q * free / (1.0 + q * free))
    y = first + gap
    if y < 1e-4:  # the closed form would cancel
        return 0.5 * gap * (first * first + first * y + y * y)
    return q - 5.0 / 3.0 * np.log1p(q * free) + 4.0 / 3.0 * np.log1p(gap / (2.0 + first))


@bare
def _hazard(stretch, age, pace, root):  # type: ignore[no-untyped-def]
    """-ln of the fraction of contacts that pinned together and whose thresholds exceed the stretch >= 0 at an age.

    With it its slope, by a unit of the stretch in which the age grows by `pace`. root : B^(1/2), per unit of length.
    """
    s = root * stretch
    place = np.sqrt(1.0 + s * s)
    over = s * (s / (1.0 + place))
    if over == 0.0:
        return 0.0, 0.0
    largest = np.cbrt(1.0 + age)
    excess = age / (1.0 + largest + largest * largest)
    rest = excess - over
    if rest <= 0.0:
        return np.inf, np.inf
    first, free, growth = 1.0 / largest, excess / largest, pace / (3.0 * (1.0 + age))
    y = 1.0 - rest / largest
    rise = _density(y, rest / largest) * (root * s / (place * largest) - y * growth)
    rise += _density(first, free) * first * growth
    return _beyond(over / excess * (largest / rest), first, free), rise


@bare
def _quantile(goal, age, root):  # type: ignore[no-untyped-def]
    """Threshold, at an age, of the contact with the hazard `goal`."""
    if age <= 0.0 or goal <= 0.0:
        return 0.0
    largest = np.cbrt(1.0 + age)
    excess = age / (1.0 + largest + largest * largest)
    first, free = 1.0 / largest, excess / largest
    q = np.cbrt(2.0 * goal) + goal + 5.0 / 3.0 * np.log1p(goal)
    q = min(q, goal * (2.0 + first) / (3.0 * first * first))
    for _ in range(60):
        rest = free / (1.0 + q * free)
        y = first + q * free * rest
        step = (_beyond(q, first, free) - goal) * (2.0 + y) / (3.0 * y * y)
        step /= 1.0 - 0.5 * step * rest * rest * (4.0 + y) / (y * (2.0 + y))
        last, q = q, max(q - step, 0.125 * q)
        if abs(step) <= 1e-5 * last:  # the error is the cube of that
            break
    gap = excess * (q * excess / (largest + q * excess))
    return np.sqrt(gap * (gap + 2.0)) / root


@bare
def _meeting(near, pace, room, age, goal, root):  # type: ignore[no-untyped-def]
    """Ticks after which a contact reaches its threshold, which is not met at 0 ticks; infinite if not by `room`.

    In a steady motion the hazard may fall first and then rises, so that it passes the goal once. Newton's method, for
    hazard^(-1/2), which is nearly straight; by halves and doubles where that leaves the bracket.
    """
    low, high, at, speed = 0.0, np.inf, 0.5 * np.sqrt(pace / root) / root, root / pace
    if age == 0.0:  # a guess within some 15 %, of contacts that slide since they pinned
        more = max(goal - 4.5 * speed * speed, 1e-3)
        at *= 1.56 * more / (more + speed * (4.0 + 3.0 * speed))
    at = min(at, room)
    for _ in range(200):
        hazard, slope = _hazard(near + at, age + at * pace, pace, root)
        if hazard < goal:
            if at == room:
                return np.inf
            low = at
        else:
            high = at
        then = at + 2.0 * (1.0 - np.sqrt(hazard / goal)) * hazard / slope
        if not low < then < high:
            then = 0.5 * (low + min(high, 4.0 * at))
        then = min(then, room)
        # the error is below 1e-6; whether the goal is reached at `room` itself is looked up there
        if then == at or (then < room and abs(then - at) <= max(1e-3 * at, 0.25)):
            return then
        at = then
    return at


def _born(law, contact):  # type: ignore[no-untyped-def]
    """A contact that forms has the hazard of its exposure, one of the start that of its threshold."""
    if contact.fresh:
        return 0.0, np.exp(contact.log_exposure)
    return law.age, _hazard(real(contact.threshold), law.age, 0.0, law.root)[0]


GROWTHS[Grains] = Growth(
    _born,
    # contacts with hazards up to (9/2) B (v tau_m)² are stretched faster than their thresholds grow
    lost=lambda law, pace: 4.5 * (law.root / pace) ** 2,
    meeting=lambda law, near, pace, room, age, goal: _meeting(
        near, pace, room, age, goal, law.root
    ),
    threshold=lambda law, goal, age: _quantile(goal, age, law.root),
)
