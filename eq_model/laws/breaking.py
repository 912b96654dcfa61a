"""Where a contact breaks whose threshold stays what it is: at the threshold, or before, at a rate."""

from typing import Any, NamedTuple

import numpy as np

from eq_model.contact import LIVES, SEEN, Break, by_law
from eq_model.draws.tables import LEVEL_UNIT
from origins.laws.compiled import CompiledRates

_U, _I, _F = np.uint64, np.int64, np.float64
_NOTHING = 1e-300


class Cold(NamedTuple):
    """At its threshold alone; which counts as met within `tie` units where the slider turns or stops."""

    tie: np.int64


class Warm(NamedTuple):
    """At the rate of a law, its lengths and times those of the drive."""

    rates: Any
    unit: float  # a length
    log_slow: Any  # (m,): ln of the time for a length, of each leg


# by the class of their law; arguments are those of CompiledRates
RATES: dict[type, CompiledRates] = {}
rate = by_law(lambda law: RATES[law].rate)
passed = by_law(lambda law: RATES[law].passed)
reached = by_law(lambda law: RATES[law].reached)
most = by_law(lambda law: RATES[law].most)


def at_threshold(law, contact, course, watch, counts):  # type: ignore[no-untyped-def]
    """The break of a contact at T = 0."""
    leg, clock, threshold = contact.leg, contact.clock, contact.threshold
    birth = course.positions[leg] - contact.stretch
    birth += course.directions[leg] * (clock - course.begins[leg])
    legs = course.directions.size
    while leg < legs:
        beyond = abs(course.positions[leg + 1] - birth) - threshold
        if beyond >= 0 or (beyond >= -law.tie and leg + 1 < legs):
            # met on the way out; within the tie of a turn at the turn itself
            return Break(
                max(course.begins[leg + 1] - max(beyond, 0), clock), leg, contact.drawn, True
            )
        leg += 1
    return Break(course.begins[legs] + 1, leg, contact.drawn, True)


def by_rate(law, contact, course, watch, counts):  # type: ignore[no-untyped-def]
    """The break of a contact that bears the integral of its rate up to e^exposure.

    On a leg the integral over lengths from 0 to the stretch, odd in it, has to come to a goal.
    """
    clock, leg, x, k = contact.clock, contact.leg, contact.stretch, contact.stiffness
    rates, unit, per, legs = law.rates, law.unit, 1.0 / law.unit, course.directions.size
    threshold = _F(contact.threshold) * unit
    # the integral at x, and what is left to bear, found when it is needed
    here, bears = 0.0, -1.0
    if x != 0:
        here = np.copysign(passed(rates, min(abs(_F(x)) * unit, threshold), threshold, k), x)
    while leg < legs:
        room, d, pace = course.begins[leg + 1] - clock, course.directions[leg], course.paces[leg]
        log_goal, sign = contact.exposure - law.log_slow[leg], 1.0
        if bears < 0.0 and (d == 0 or here != 0.0):
            bears = np.exp(contact.exposure)
        if d == 0:
            hazard = rate(rates, abs(_F(x)) * unit, threshold, k) * pace
            if hazard * room >= bears:
                return Break(clock + min(_I(bears / hazard), room), leg, contact.drawn, True)
            bears -= hazard * room
        else:
            slow = max(pace * per, _NOTHING)  # time for a length
            if bears >= 0.0:
                goal = d * here + bears / slow
                log_goal, sign = np.log(max(abs(goal), _NOTHING)), np.copysign(1.0, goal)
            place = sign * min(reached(rates, log_goal, threshold, k), threshold)
            moved = max(_I(np.floor(place * per + 0.5)) - d * x, _I(0))
            # at the end of the drive there is no branch, which could not be foreseen
            if leg + 1 == legs or moved <= room:
                return Break(clock + min(moved, room + 1), leg, contact.drawn, True)
            x += d * room
            far = min(abs(_F(x)) * unit, threshold)
            there = np.copysign(passed(rates, far, threshold, k), _F(x))
            bears = np.exp(contact.exposure) if bears < 0.0 else bears
            bears = max(bears - d * (there - here) * slow, 0.0)
            here = there
        leg += 1
        clock = course.begins[leg]
    return Break(clock + 1, leg, contact.drawn, True)


def _row_at_thresholds(law, n, x, e, r):  # type: ignore[no-untyped-def]
    """They break at their thresholds."""


def _row_by_rates(law, n, x, e, r):  # type: ignore[no-untyped-def]
    """Put the stretches at which n contacts break in the place of their thresholds x: steadily forward from r on."""
    rates, unit, per, slow = law.rates, law.unit, 1.0 / law.unit, law.log_slow[0]
    for i in range(_U(n)):
        threshold, log_goal, sign = _F(x[i]) * unit, _F(e[i]) * LEVEL_UNIT - slow, 1.0
        if r[i] != 0:
            far = min(abs(_F(r[i])) * unit, threshold)
            goal = np.copysign(passed(rates, far, threshold, 1.0), r[i]) + np.exp(log_goal)
            log_goal, sign = np.log(max(abs(goal), _NOTHING)), np.copysign(1.0, goal)
        place = sign * min(reached(rates, log_goal, threshold, 1.0), threshold)
        x[i] = max(_I(np.floor(place * per + 0.5)), r[i])


def _same(law, contact, course, moment):  # type: ignore[no-untyped-def]
    """It stays what it is."""
    return _F(contact.threshold)


LIVES |= {Cold: at_threshold, Warm: by_rate}
SEEN |= {Cold: _same, Warm: _same}
# for contacts that move steadily forward
break_row = by_law({Cold: _row_at_thresholds, Warm: _row_by_rates}.__getitem__)
