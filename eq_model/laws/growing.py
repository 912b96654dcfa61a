"""A contact whose threshold grows with its age: it keeps its quantile, as a cumulative hazard, and breaks
where the hazard of the law of thresholds at its stretch and age exceeds it.

Lengths are in units of the lattice, except those of rate laws; ages count from pinning, in units of
tau_m. origins/grains/contact.py and lifshitz_slyozov.py have the same formulas in plain numpy.
"""

from typing import Any, NamedTuple

import numpy as np

from eq_model.compiling import bare, real, whole
from eq_model.contact import AGED, BREAKS, Break, most, rate
from eq_model.draws.streams import STEPS, uniform, words_at

_SMALL = 0.4  # grain size over the largest below which psi is integrated: its closed form cancels
_NODES, _WEIGHTS = (tuple(part.tolist()) for part in np.polynomial.legendre.leggauss(10))
_STEPS = 60  # most of Halley's method
_MISS = 1e-5  # its relative step that is the last: its cube is the error
_SPLITS = 200
# largest ratio of the bound to the rate; not required where the bound's integral is below _LITTLE
_RISE, _LITTLE = 3.0, 0.05


class Growing(NamedTuple):
    """Growth of thresholds with the age of their grains."""

    first: float  # tau_m
    root: float  # B^(1/2), per unit
    age: float  # since pinning, of the contacts at X = 0
    warm: bool  # whether contacts also break at a rate
    rates: Any
    unit: float  # a length


@bare
def _beyond(q, first, free):  # type: ignore[no-untyped-def]
    """psi(y) - psi(first) of Lifshitz and Slyozov's law, q = 1/(1 - y) - 1/(1 - first), free = 1 - first."""
    gap = free * (q * free / (1.0 + q * free))
    if first + gap < _SMALL:
        total = 0.0
        for k in range(len(_NODES)):
            y = first + gap * (0.5 + 0.5 * _NODES[k])
            total += _WEIGHTS[k] * 1.5 * y * y / ((2.0 + y) * (1.0 - y) ** 2)
        return gap * total
    return q - 5.0 / 3.0 * np.log1p(q * free) + 4.0 / 3.0 * np.log1p(gap / (2.0 + first))


@bare
def hazard(stretch, age, root):  # type: ignore[no-untyped-def]
    """-ln of the fraction of contacts that pinned together and whose thresholds exceed the stretch >= 0 at an age.

    root : B^(1/2), per unit of length.
    """
    s = root * stretch
    over = s * (s / (1.0 + np.hypot(1.0, s)))
    if over == 0.0:
        return 0.0
    excess = np.expm1(np.log1p(age) / 3.0)
    left = excess - over
    if left <= 0.0:
        return np.inf
    largest = 1.0 + excess
    return _beyond(over / excess * (largest / left), 1.0 / largest, excess / largest)


@bare
def quantile(goal, age, root):  # type: ignore[no-untyped-def]
    """Threshold, at an age, of the contact with the hazard `goal`."""
    excess = np.expm1(np.log1p(age) / 3.0)
    if excess <= 0.0 or goal <= 0.0:
        return 0.0
    largest = 1.0 + excess
    first, free = 1.0 / largest, excess / largest
    q = np.cbrt(2.0 * goal) + goal + 5.0 / 3.0 * np.log1p(goal)
    q = min(q, goal * (2.0 + first) / (3.0 * first * first))
    for _ in range(_STEPS):
        left = free / (1.0 + q * free)
        y = first + q * free * left
        step = (_beyond(q, first, free) - goal) * (2.0 + y) / (3.0 * y * y)
        step /= 1.0 - 0.5 * step * left * left * (4.0 + y) / (y * (2.0 + y))
        last, q = q, max(q - step, 0.125 * q)
        if abs(step) <= _MISS * last:
            break
    gap = excess * (q * excess / (largest + q * excess))
    return np.sqrt(gap * (gap + 2.0)) / root


@bare
def _rise(stretch, age, pace, root):  # type: ignore[no-untyped-def]
    """Change of the hazard per tick of a steady motion, in which the age changes by `pace` a tick."""
    s, largest = root * stretch, np.exp(np.log1p(age) / 3.0)
    size = np.hypot(1.0, s)
    y, first, growth = size / largest, 1.0 / largest, pace / (3.0 * (1.0 + age))
    at_y = 3.0 * y * y / ((2.0 + y) * (1.0 - y) ** 2)
    at_first = 3.0 * first * first / ((2.0 + first) * (1.0 - first) ** 2)
    return at_y * (root * s / (size * largest) - y * growth) + at_first * first * growth


@bare
def _meeting(near, pace, room, age, goal, root):  # type: ignore[no-untyped-def]
    """Ticks after which a contact reaches its threshold, which is beyond it at 0 ticks and not at `room`.

    In a steady motion the hazard may fall first and then rises, so that it passes the goal once. Newton's method for
    the logarithms of ticks and hazard, within a bracket.
    """
    low, high = 0.0, room
    at = min(room, 1.0 / root)
    for _ in range(_SPLITS):
        now = hazard(near + at, age + at * pace, root)
        if now < goal:
            low = at
        else:
            high = at
        then = -1.0
        if 0.0 < now < np.inf:
            rise = _rise(near + at, age + at * pace, pace, root)
            if rise > 0.0:
                then = at * np.exp(min(max(np.log(goal / now) * now / (rise * at), -2.0), 2.0))
        if not low <= then <= high:
            then = 0.5 * (low + high) if low > 0.0 else 0.25 * high
        if abs(then - at) <= max(1e-6 * at, 0.25):  # the error is the square of the last step
            return then
        at = then
    return at


@bare
def _hold(clock, leg, x, age, goal, way, law):  # type: ignore[no-untyped-def]
    """Clock and leg where a contact with the hazard `goal` reaches its threshold."""
    legs = way.directions.size
    while leg < legs:
        d, pace = way.directions[leg], way.paces[leg] / law.first
        room = way.begins[leg + 1] - clock
        back = room if d == 0 else min(max(-d * x, 0), room)
        age += back * pace
        x += d * back
        clock += back
        room -= back
        if room > 0:
            near = real(d * x)
            if hazard(near + room, age + room * pace, law.root) >= goal:
                moved = whole(0)
                if hazard(near, age, law.root) < goal:
                    moved = min(
                        whole(_meeting(near, pace, real(room), age, goal, law.root) + 0.5), room
                    )
                return clock + moved, leg
            age += room * pace
            x += d * room
        leg += 1
        if leg < legs:
            clock = way.begins[leg]
    return way.begins[legs] + 1, leg


@bare
def _rate(x, y, law):  # type: ignore[no-untyped-def]
    # a threshold of 0 counts as a tiny one
    y = max(y, 1e-9)
    return rate(law.rates, min(x, y) * law.unit, y * law.unit, 1.0)


@bare
def _shaken(contact, age, goal, until, way, law):  # type: ignore[no-untyped-def]
    """The thermal break of a contact, if it comes before the moment `until`.

    By thinning: breaks are proposed at a rate above the contact's, and accepted with the ratio of the
    two rates. This is exact whatever the steps (Lewis and Shedler, 1979).
    """
    clock, leg, x, root, unit = contact.clock, contact.leg, contact.stretch, law.root, law.unit
    draws, step, end = contact.drawn, 1.0, way.begins[way.directions.size]
    words = words_at(contact.lane, draws, contact.stream, STEPS)
    draws += 1
    remaining = -np.log(uniform(words[0], words[1]))
    y = quantile(goal, age, root)
    while leg < way.directions.size and clock < until:
        d, pace = way.directions[leg], way.paces[leg] / law.first
        passed, room = 0.0, real(min(way.begins[leg + 1], until) - clock)
        while passed < room and pace > 0.0:
            ticks = min(step / pace, room - passed)
            lasts = ticks * pace
            here, there = real(x) + d * passed, real(x) + d * (passed + ticks)
            later = quantile(goal, age + lasts, root)
            least = 0.0 if here * there < 0.0 else min(abs(here), abs(there))
            largest = max(abs(here), abs(there))
            bound = most(law.rates, least * unit, largest * unit, y * unit, later * unit, 1.0)
            spent = bound * lasts * law.first
            if spent > _LITTLE and bound > _RISE * _rate(abs(here), y, law):
                step = 0.5 * lasts
                continue
            if spent < remaining:
                remaining -= spent
                passed += ticks
                age += lasts
                y = later
                step = 2.0 * lasts
                continue
            share = remaining / spent
            passed += share * ticks
            age += share * lasts
            y = quantile(goal, age, root)
            words = words_at(contact.lane, draws, contact.stream, STEPS)
            draws += 1
            stretch = abs(real(x) + d * passed)
            if uniform(words[0], words[1]) * bound < _rate(stretch, y, law):
                return Break(clock + min(whole(passed + 0.5), whole(room)), leg, draws, True)
            remaining = -np.log(uniform(words[2], words[3]))
        x += d * whole(room)
        clock += whole(room)
        leg += 1
    return Break(end + 1, leg, draws, True)


@bare
def _pinned(contact, law):  # type: ignore[no-untyped-def]
    """Age and hazard of a contact that forms: e^exposure, or in the start that of its threshold."""
    if contact.fresh:
        return 0.0, np.exp(contact.log_exposure)
    return law.age, hazard(real(contact.threshold), law.age, law.root)


def keep_hazard(law, contact, way, counts):  # type: ignore[no-untyped-def]
    """The break of a contact with a growing threshold."""
    age, goal = _pinned(contact, law)
    leg = contact.leg
    while leg + 1 < way.directions.size and contact.clock >= way.begins[leg + 1]:
        leg += 1
    # contacts with hazards up to (9/2) B (v tau_m)² are stretched faster than their thresholds grow
    slowest = 4.5 * (law.root * law.first / way.paces[leg]) ** 2
    if contact.fresh and way.directions[leg] != 0 and goal <= slowest:
        return Break(contact.clock, contact.leg, contact.drawn, False)
    then, leg = _hold(contact.clock, contact.leg, contact.stretch, age, goal, way, law)
    if not law.warm:
        return Break(then, leg, contact.drawn, True)
    until = min(then, way.begins[-1])
    sooner = _shaken(contact, age, goal, until, way, law)
    return sooner if sooner.clock <= until else Break(then, leg, sooner.drawn, True)


def _aged(law, contact, way, moment):  # type: ignore[no-untyped-def]
    """The threshold at a later moment."""
    age, goal = _pinned(contact, law)
    clock, leg = contact.clock, contact.leg
    while leg + 1 < way.paces.size and way.begins[leg + 1] <= moment:
        age += (way.begins[leg + 1] - clock) * (way.paces[leg] / law.first)
        leg += 1
        clock = way.begins[leg]
    return quantile(goal, age + (moment - clock) * (way.paces[leg] / law.first), law.root)


BREAKS[Growing] = keep_hazard
AGED[Growing] = _aged
