"""Thresholds of a law of one's own that change with age and distance and keep their order.

The law states one function of numbers, birth_threshold(x, age, travelled), see origins.OrderedThresholds. A contact
breaks where it first reaches the contact's threshold at birth, which is found by bisection of the time. The kernel
knows the function by its address alone, so that one compiled kernel, which is kept on disk, serves all laws.
"""

from typing import Any, NamedTuple

import numpy as np

from eq_model.compiling import bare, real, whole
from eq_model.contact import AGED, BREAKS, Break
from eq_model.laws.own import Address
from eq_model.whole_drive import WholeDrive
from origins import Contacts, OrderedThresholds
from origins.errors import refuse
from origins.laws.ordered import Trend
from origins.thresholds.law import Array

SECONDS = 5e-5  # of a break where the function is plain Python, see settings.KERNELS


class Ordered(NamedTuple):
    """The law's function, in its units of length and time, and which way it goes."""

    birth_threshold: Any  # (x, age, travelled): numbers
    trend: Trend
    first_step: np.int64  # ticks of the clock
    unit: float  # a length: that of whole numbers


def make(contacts: Contacts, drive: WholeDrive, warm: bool, rates: Any, unit: float) -> Ordered:
    """The law of these contacts; see settings.KERNELS. InputError for what is not followed beside it."""
    law = contacts.changing
    assert isinstance(law, OrderedThresholds)
    if warm or law.older_at_start:
        what = "heat beside it" if warm else "contacts of the start that are older"
        refuse(f"contacts.{law.law}", law, f"its kernel knows of no {what}; use master.solve")
    longest = float((drive.paces * np.diff(drive.begins)).sum())
    furthest = float(np.abs(np.diff(drive.positions)).sum()) * unit
    trend = law.trend(longest, furthest)
    step = whole(max(round(0.5 * contacts.mean_threshold / unit), 1))
    return Ordered(Address(law.birth_threshold, 3), trend, step, unit)


def often(contacts: Contacts, lasts: Array, moved: Array, law: Ordered) -> float:
    """How often a contact breaks, from the age at which one of the mean threshold does at the mean speed; see
    settings.KERNELS."""
    total, speed = float(lasts.sum()), float(moved.sum() / lasts.sum())
    stated, low, high = contacts.changing, 0.0, total
    assert isinstance(stated, OrderedThresholds)
    for _ in range(40):
        middle = 0.5 * (low + high)
        distance = speed * middle
        holds = stated.birth_threshold(distance, middle, distance) < contacts.mean_threshold
        low, high = (middle, high) if holds else (low, middle)
    return total / high


@bare
def _largest(law, x, age, late_age, distance, late_distance):  # type: ignore[no-untyped-def]
    """The largest birth_threshold at a stretch between two ages and between two distances travelled: that at one end of
    each, as it rises or falls all along; at which, says the law's trend, and at both where contacts do both."""
    trend, birth_threshold = law.trend, law.birth_threshold
    first_age = age if trend.strengthens_with_age else late_age
    other_age = late_age if trend.weakens_with_age else first_age
    first_distance = distance if trend.strengthens_with_travel else late_distance
    other_distance = late_distance if trend.weakens_with_travel else first_distance
    largest = birth_threshold(x, first_age, first_distance)
    if other_age != first_age:
        largest = max(largest, birth_threshold(x, other_age, first_distance))
    if other_distance != first_distance:
        largest = max(largest, birth_threshold(x, first_age, other_distance))
        if other_age != first_age:
            largest = max(largest, birth_threshold(x, other_age, other_distance))
    return largest


def break_ordered(law, contact, drive, counts):  # type: ignore[no-untyped-def]
    """The break of a contact where birth_threshold first reaches its threshold at birth, to a tick of the clock.

    Between two ticks of a leg |x| is at most the larger of the two, and birth_threshold at most the largest at this
    stretch. Where that is below the contact's threshold at birth, the contact holds in between; else the interval is
    halved.
    """
    clock, leg, x, birth = contact.clock, contact.leg, contact.stretch, real(contact.threshold)
    age, travelled, step = 0.0, 0.0, law.first_step
    while leg < drive.directions.size:
        d, pace, room = drive.directions[leg], drive.paces[leg], drive.begins[leg + 1] - clock
        length = abs(d) * law.unit
        # ticks since the beginning of the leg: up to `at` it holds; up to `doubtful` it may not
        at, doubtful = whole(0), whole(0)
        while at < room:
            then = min(at + step, room)
            stretch = max(abs(x + d * at), abs(x + d * then)) * law.unit
            ages, late_age = age + pace * at, age + pace * then
            distance, late_distance = travelled + length * at, travelled + length * then
            if _largest(law, stretch, ages, late_age, distance, late_distance) < birth * law.unit:
                at = then
                step = 2 * step if at >= doubtful else max((doubtful - at) >> 1, whole(1))
            elif then - at > 1:
                doubtful, step = then, (then - at) >> 1
            else:
                return Break(clock + then, leg, contact.drawn)
        x += d * room
        age += pace * room
        travelled += length * room
        leg += 1
        clock = drive.begins[leg]
    return Break(clock + 1, leg, contact.drawn)


def _aged(law, contact, drive, instant):  # type: ignore[no-untyped-def]
    """The threshold at a later instant, at which the contact holds: the stretch at which it would break then."""
    age, travelled = 0.0, 0.0
    for leg in range(contact.leg, drive.paces.size):
        begin, end = max(drive.begins[leg], contact.clock), min(drive.begins[leg + 1], instant)
        ticks = max(end - begin, 0)
        age += drive.paces[leg] * ticks
        travelled += abs(drive.directions[leg]) * law.unit * ticks
    birth = real(contact.threshold) * law.unit
    low, high = 0.0, birth
    while law.birth_threshold(high, age, travelled) < birth:
        low, high = high, 2.0 * high
    while high - low > 1e-6 * birth:  # bins of histograms are wider
        middle = 0.5 * (low + high)
        if law.birth_threshold(middle, age, travelled) < birth:
            low = middle
        else:
            high = middle
    return high / law.unit


BREAKS[Ordered], AGED[Ordered] = break_ordered, _aged
