"""A contact whose threshold grows with its age: it keeps its quantile, as a cumulative hazard, and breaks
where the hazard of the law of thresholds at its stretch and age exceeds it.

Lengths are in the unit of the run (WholeDrive.unit), except those of rate laws; ages count from pinning, in units of
tau_m. origins/grains/contact.py and lifshitz_slyozov.py have the same formulas in plain numpy.
"""

from typing import Any, NamedTuple

import numpy as np

from eq_model.compiling import bare, inlined, real, whole
from eq_model.contact import AGED, BREAKS, Break, most, rate_at
from eq_model.draws.streams import STEPS, uniform, words_at
from eq_model.whole_drive import WholeDrive
from origins.grains.contact import GrainContact


class Growing(NamedTuple):
    """Growth of thresholds with the age of their grains."""

    tau_m: float  # the time until grains pin
    root: float  # B^(1/2), per unit
    age: float  # since pinning, of the contacts at X = 0
    warm: bool  # whether contacts also break at a rate
    rates: Any
    unit: float  # a length


def make_growing(grains: GrainContact, drive: WholeDrive, *heat: Any) -> Growing:
    """The growth of these contacts on a drive; heat : the last three fields of Growing."""
    tau_m, root = grains.growth.first_pinning_time, float(np.sqrt(grains.growth.B)) * drive.unit
    return Growing(tau_m, root, (grains.age or 0.0) / tau_m - 1.0, *heat)


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
def hazard(stretch, age, pace, root):  # type: ignore[no-untyped-def]
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
    left = excess - over
    if left <= 0.0:
        return np.inf, np.inf
    first, free, growth = 1.0 / largest, excess / largest, pace / (3.0 * (1.0 + age))
    y = 1.0 - left / largest
    rise = _density(y, left / largest) * (root * s / (place * largest) - y * growth)
    rise += _density(first, free) * first * growth
    return _beyond(over / excess * (largest / left), first, free), rise


@bare
def quantile(goal, age, root):  # type: ignore[no-untyped-def]
    """Threshold, at an age, of the contact with the hazard `goal`."""
    if age <= 0.0 or goal <= 0.0:
        return 0.0
    largest = np.cbrt(1.0 + age)
    excess = age / (1.0 + largest + largest * largest)
    first, free = 1.0 / largest, excess / largest
    q = np.cbrt(2.0 * goal) + goal + 5.0 / 3.0 * np.log1p(goal)
    q = min(q, goal * (2.0 + first) / (3.0 * first * first))
    for _ in range(60):
        left = free / (1.0 + q * free)
        y = first + q * free * left
        step = (_beyond(q, first, free) - goal) * (2.0 + y) / (3.0 * y * y)
        step /= 1.0 - 0.5 * step * left * left * (4.0 + y) / (y * (2.0 + y))
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
        reached, slope = hazard(near + at, age + at * pace, pace, root)
        if reached < goal:
            if at == room:
                return np.inf
            low = at
        else:
            high = at
        then = at + 2.0 * (1.0 - np.sqrt(reached / goal)) * reached / slope
        if not low < then < high:
            then = 0.5 * (low + min(high, 4.0 * at))
        then = min(then, room)
        # the error is below 1e-6; whether the goal is reached at `room` itself is looked up there
        if then == at or (then < room and abs(then - at) <= max(1e-3 * at, 0.25)):
            return then
        at = then
    return at


@bare
def _pinned(contact, law):  # type: ignore[no-untyped-def]
    """Age and hazard of a contact that forms: its exposure, or in the start that of its threshold."""
    if contact.fresh:
        return 0.0, np.exp(contact.log_exposure)
    return law.age, hazard(real(contact.threshold), law.age, 0.0, law.root)[0]


def break_growing(law, contact, drive, counts):  # type: ignore[no-untyped-def]
    """The break of a contact with a growing threshold: where its hazard is reached, or by heat before.

    By heat by thinning: breaks are proposed at a rate above the contact's, and accepted with the ratio of the two
    rates. This is exact whatever the steps (Lewis and Shedler, 1979).
    """
    clock, leg, x, drawn = contact.clock, contact.leg, contact.stretch, contact.drawn
    age, goal = _pinned(contact, law)
    unit, lane, stream, remaining, step = law.unit, contact.lane, contact.stream, 0.0, 1.0
    if law.warm:
        words = words_at(lane, drawn, stream, STEPS)
        remaining = -np.log(uniform(words[0], words[1]))
        drawn += 1
    while True:
        while leg < drive.directions.size and clock >= drive.begins[leg + 1]:
            leg += 1
        if leg == drive.directions.size:
            return Break(drive.begins[leg] + 1, leg, drawn)
        d, pace, room = (
            drive.directions[leg],
            drive.paces[leg] / law.tau_m,
            drive.begins[leg + 1] - clock,
        )
        # contacts with hazards up to (9/2) B (v tau_m)² are stretched faster than their thresholds grow
        pins = contact.fresh and d != 0 and clock == contact.clock
        if pins and goal <= 4.5 * (law.root / pace) ** 2:
            return Break(clock, contact.leg, contact.drawn)
        outward, near, ticks = d * x >= 0, abs(real(x)), np.inf
        if d != 0 and not outward:
            room = min(room, abs(x))
        elif d != 0:
            ticks = _meeting(near, pace, real(room), age, goal, law.root)
        meets = ticks <= room
        if meets:
            room = min(whole(ticks + 0.5), room)
        sign, passed, y = abs(d) if outward else -abs(d), 0.0, 0.0
        if law.warm:
            y = quantile(goal, age, law.root)
        while law.warm and passed < room and pace > 0.0:
            ticks = min(step / pace, room - passed)
            lasts, now = ticks * pace, age + passed * pace
            here, there = near + sign * passed, max(near + sign * (passed + ticks), 0.0)
            then, far = quantile(goal, now + lasts, law.root), max(here, there)
            bound = most(law.rates, min(here, there) * unit, far * unit, y * unit, then * unit, 1.0)
            spent = bound * lasts * law.tau_m
            # bounds beyond three times the rate would be rejected often
            if spent > 0.05 and bound > 3.0 * rate_at(here, y, law, 1.0):
                step = 0.5 * lasts
            elif spent < remaining:
                remaining, passed, y, step = remaining - spent, passed + ticks, then, 2.0 * lasts
            else:
                passed += remaining / spent * ticks
                y = quantile(goal, age + passed * pace, law.root)
                words = words_at(lane, drawn, stream, STEPS)
                drawn += 1
                if uniform(words[0], words[1]) * bound < rate_at(near + sign * passed, y, law, 1.0):
                    return Break(clock + min(whole(passed + 0.5), room), leg, drawn)
                remaining = -np.log(uniform(words[2], words[3]))
        clock, x, age = clock + room, x + d * room, age + room * pace
        if meets:
            return Break(clock, leg, drawn)


def _aged(law, contact, drive, instant):  # type: ignore[no-untyped-def]
    """The threshold at a later instant."""
    age, goal = _pinned(contact, law)
    for leg in range(contact.leg, drive.paces.size):
        begin, end = max(drive.begins[leg], contact.clock), min(drive.begins[leg + 1], instant)
        age += max(end - begin, 0) * (drive.paces[leg] / law.tau_m)
    return quantile(goal, age, law.root)


BREAKS[Growing] = break_growing
AGED[Growing] = _aged
