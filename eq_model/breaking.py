"""Where a contact breaks whose threshold stays what it is: at the threshold, or before, at a rate."""

from typing import Any, NamedTuple

import numpy as np

from eq_model.contact import LIVES, LOOKS, Break, by_law, look_at
from eq_model.tables import FAR, LEVEL_UNIT
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
    birth = course.positions[contact.leg] - contact.stretch
    birth += course.directions[contact.leg] * (contact.clock - course.begins[contact.leg])
    threshold, leg, clock, legs = (
        contact.threshold,
        contact.leg,
        contact.clock,
        course.directions.size,
    )
    while leg < legs:
        y = course.positions[leg + 1] - birth
        beyond = abs(y) - threshold
        if beyond >= 0 or (beyond >= -law.tie and leg + 1 < legs):
            # met on the way out; within the tie of a turn at the turn itself
            moved = abs(y) - threshold if beyond >= 0 else _I(0)
            return Break(max(course.begins[leg + 1] - moved, clock), leg, contact.drawn, True)
        leg += 1
    return Break(course.begins[legs] + 1, leg, contact.drawn, True)


def by_rate(law, contact, course, watch, counts):  # type: ignore[no-untyped-def]
    """The break of a contact that bears the integral of its rate up to e^exposure."""
    clock, leg, x, stiffness = contact.clock, contact.leg, contact.stretch, contact.stiffness
    rates, unit, per = law.rates, law.unit, 1.0 / law.unit
    threshold = _F(contact.threshold) * unit
    log_bears, bears, legs = contact.exposure, -1.0, course.directions.size
    while leg < legs:
        room, d = course.begins[leg + 1] - clock, course.directions[leg]
        slow = course.paces[leg] * per  # time for a length
        if d == 0:
            bears = np.exp(log_bears) if bears < 0.0 else bears
            hazard = rate(rates, abs(_F(x)) * unit, threshold, stiffness) * course.paces[leg]
            if hazard * room >= bears:
                return Break(clock + min(_I(bears / hazard), room), leg, contact.drawn, True)
            bears -= hazard * room
        else:
            if d * x < 0:
                back = min(abs(x), room)
                bears = np.exp(log_bears) if bears < 0.0 else bears
                far = abs(_F(x)) * unit
                spent = passed(rates, max(far - back * unit, 0.0), far, threshold, stiffness) * slow
                if spent >= bears:
                    whole = passed(rates, 0.0, far, threshold, stiffness) * slow
                    left = np.log(max(whole - bears, _NOTHING) / slow)
                    near = min(reached(rates, left, 0.0, threshold, stiffness), far)
                    moved = min(_I((far - near) / unit), back)
                    return Break(clock + moved, leg, contact.drawn, True)
                bears -= spent
                x += d * back
                clock += back
                room -= back
            if room > 0:
                log_bears = log_bears if bears < 0.0 else np.log(max(bears, _NOTHING))
                near = _F(d * x) * unit
                own = reached(rates, log_bears - law.log_slow[leg], near, threshold, stiffness)
                moved = max(_I(np.floor(own * per + 0.5)) - d * x, _I(0))
                if moved <= room:
                    return Break(clock + moved, leg, contact.drawn, True)
                if leg + 1 < legs:
                    bears = np.exp(log_bears)
                    far = min(near + room * unit, threshold)
                    bears -= passed(rates, near, far, threshold, stiffness) * slow
                    bears = max(bears, 0.0)
                x += d * room
        leg += 1
        if leg < legs:
            clock = course.begins[leg]
    return Break(course.begins[legs] + 1, leg, contact.drawn, True)


def _row_at_thresholds(law, n, x, e, at, least):  # type: ignore[no-untyped-def]
    """They break at their thresholds."""


def _row_by_rates(law, n, x, e, at, least):  # type: ignore[no-untyped-def]
    """Steadily forward the stretches x at which n lanes break that bear e, in place of their thresholds."""
    rates, unit, per, one, slow = law.rates, law.unit, 1.0 / law.unit, 1.0, law.log_slow[0]
    for i in range(_U(n)):
        threshold, log_bears = _F(x[i]) * unit, _F(e[i]) * LEVEL_UNIT - slow
        # contacts that form again are relaxed; others begin at a stretch of either sign
        near = _F(-at[i]) * unit if least[i] > 0 else 0.0
        if near < 0.0:
            bears = np.exp(log_bears)
            whole = passed(rates, 0.0, -near, threshold, one)
            if whole >= bears:
                left = np.log(max(whole - bears, _NOTHING))
                own = min(reached(rates, left, 0.0, threshold, one), -near)
                x[i] = -_I(np.floor(own * per + 0.5))
                continue
            log_bears, near = np.log(bears - whole), 0.0
        own = reached(rates, log_bears, near, threshold, one)
        x[i] = min(_I(np.floor(min(own * per, _F(FAR)) + 0.5)), x[i])


def _look(law, contact, course, born, broken, birth, watch, counts):  # type: ignore[no-untyped-def]
    for k in range(watch.before[born], watch.before[broken]):
        look_at(k, birth, _F(contact.threshold), watch, counts)


LIVES |= {Cold: at_threshold, Warm: by_rate}
LOOKS |= {Cold: _look, Warm: _look}
_ROWS = {Cold: _row_at_thresholds, Warm: _row_by_rates}
break_row = by_law(_ROWS.__getitem__)  # for contacts that move steadily forward
