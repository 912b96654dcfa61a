"""A contact whose threshold grows with its age: it keeps its quantile, and breaks as its stretch meets its threshold.

What identifies a contact for life is one number, its `goal`: growing grains state it as a hazard, strengthening as the
threshold at age 0. GROWTHS holds the functions of each kind of growth by the class of its settings. Lengths are in the
unit of the run (WholeDrive.unit), except those of rate laws; ages count from pinning, in units of a time of the growth.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from eq_model.compiling import inlined, real, whole
from eq_model.contact import (
    AGED,
    BREAKS,
    RATES,
    Break,
    by_law,
    most,
    passed,
    rate_at,
    reached,
)
from eq_model.draws.streams import STEPS, uniform, words_at


class Growth(NamedTuple):
    """Functions of one kind of growth, for kernels. Its settings, `law`, are a NamedTuple with the fields

    time : the unit of ages; age : since pinning, of the contacts at X = 0; warm : whether contacts also break at a
    rate; rates, unit : as of contact.Warm.
    """

    born: Callable[..., Any]  # (law, contact): its age since pinning and its goal
    # (law, pace): contacts that pin on a leg with goals up to this never hold
    lost: Callable[..., Any]
    # (law, near, pace, room, age, goal): ticks of the clock until a contact that is stretched further, from `near` on,
    # meets its threshold, inf if not by `room`; it holds at 0 ticks, and ages by `pace` in each
    meeting: Callable[..., Any]
    threshold: Callable[..., Any]  # (law, goal, age)
    # (law, contact): ticks until a contact that has just formed relaxed meets its threshold, if the leg goes on; -1
    # where rows (contact.ROWS) have not found them
    ahead: Callable[..., Any] = lambda law, contact: whole(-1)
    rises: bool = False  # whether thresholds are above 0 from the beginning and never fall


class Growths(dict[type, Growth]):
    """Growths by the class of their settings; with each, the kernel of its contacts is known."""

    def __setitem__(self, law: type, growth: Growth) -> None:
        super().__setitem__(law, growth)
        BREAKS[law], AGED[law] = break_growing, _aged


GROWTHS = Growths()
born = by_law(lambda law: GROWTHS[law].born)
lost = by_law(lambda law: GROWTHS[law].lost)
meeting = by_law(lambda law: GROWTHS[law].meeting)
threshold = by_law(lambda law: GROWTHS[law].threshold)
ahead = by_law(lambda law: GROWTHS[law].ahead)
rises = by_law(lambda law: (lambda law: True) if GROWTHS[law].rises else (lambda law: False))
falls = by_law(lambda law: (lambda law: True) if RATES[law].falls else (lambda law: False))


@inlined
def _break_outward(law, contact, drawn, near, pace, room, age, goal, exposure):  # type: ignore[no-untyped-def]
    """Ticks until a contact that is stretched further, from `near` on, breaks by heat or at its threshold, inf if not
    by `room`; what is left of its exposure; and its draws. For rates that fall as the threshold grows.

    A break is proposed as if the threshold did not grow any more, since the integral of that rate, which is above the
    contact's, and its inverse are closed; and accepted with the ratio of the two rates. Mostly two proposals do.
    """
    unit, slow, at = law.unit, pace * law.time / law.unit, 0.0
    y = threshold(law, goal, age)
    before = passed(law.rates, near * unit, y * unit, 1.0) if near > 0.0 else 0.0
    while True:
        end = min(y - near, room)
        then = reached(law.rates, np.log(before + exposure / slow), y * unit, 1.0) / unit - near
        if then >= end - 0.5:
            break
        at = max(then, at)
        words = words_at(contact.lane, drawn, contact.stream, STEPS)
        drawn += 1
        grown = threshold(law, goal, age + at * pace)
        rate = rate_at(near + at, grown, law, 1.0)
        if uniform(words[0], words[1]) * rate_at(near + at, y, law, 1.0) < rate:
            return at, exposure, drawn
        exposure, y = -np.log(uniform(words[2], words[3])), grown
        before = passed(law.rates, (near + at) * unit, y * unit, 1.0)
    # it holds until it is stretched as far as to the threshold that it has had; its present one is little above
    end = max(end, at)
    exposure -= slow * (passed(law.rates, (near + end) * unit, y * unit, 1.0) - before)
    exposure, at, meets = max(exposure, 1e-300), end, np.inf
    if at < room:
        meets = at + meeting(law, near + at, pace, room - at, age + at * pace, goal)
        y, end = threshold(law, goal, age + at * pace), min(meets, room)
    while at < end:
        last = threshold(law, goal, age + end * pace)
        bound = most(law.rates, (near + at) * unit, (near + end) * unit, y * unit, last * unit, 1.0)
        often = bound * pace * law.time
        if exposure >= often * (end - at):
            return meets, max(exposure - often * (end - at), 1e-300), drawn
        at += exposure / often
        y = threshold(law, goal, age + at * pace)
        words = words_at(contact.lane, drawn, contact.stream, STEPS)
        drawn += 1
        if uniform(words[0], words[1]) * bound < rate_at(near + at, y, law, 1.0):
            return at, exposure, drawn
        exposure = -np.log(uniform(words[2], words[3]))
    return meets, exposure, drawn


def break_growing(law, contact, drive, counts):  # type: ignore[no-untyped-def]
    """The break of a contact with a growing threshold: where it meets that, or by heat before.

    By heat by thinning: breaks are proposed at a rate above the contact's, and accepted with the ratio of the two
    rates. This is exact whatever the steps (Lewis and Shedler, 1979).
    """
    clock, leg, x, drawn = contact.clock, contact.leg, contact.stretch, contact.drawn
    ticks_ahead = ahead(law, contact)
    if (
        ticks_ahead >= 0
        and ticks_ahead <= drive.begins[leg + 1] - clock
        and drive.directions[leg] != 0
    ):
        return Break(clock + ticks_ahead, leg, drawn)
    age, goal = born(law, contact)
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
            drive.paces[leg] / law.time,
            drive.begins[leg + 1] - clock,
        )
        pins = contact.fresh and d != 0 and clock == contact.clock
        if pins and goal <= lost(law, pace):
            return Break(clock, contact.leg, contact.drawn)
        outward, near, ticks = d * x >= 0, abs(real(x)), np.inf
        quick = law.warm and d != 0 and outward and rises(law) and falls(law.rates)
        if d != 0 and not outward:
            room = min(room, abs(x))
        elif quick:
            ticks, remaining, drawn = _break_outward(
                law, contact, drawn, near, pace, real(room), age, goal, remaining
            )
        elif d != 0:
            ticks = meeting(law, near, pace, real(room), age, goal)
        meets = ticks <= room
        if meets:
            room = min(whole(ticks + 0.5), room)
        sign, gone, y = abs(d) if outward else -abs(d), 0.0, 0.0
        if law.warm and not quick:
            y = threshold(law, goal, age)
        while law.warm and not quick and gone < room and pace > 0.0:
            ticks = min(step / pace, room - gone)
            lasts, now = ticks * pace, age + gone * pace
            here, there = near + sign * gone, max(near + sign * (gone + ticks), 0.0)
            then, far = threshold(law, goal, now + lasts), max(here, there)
            bound = most(law.rates, min(here, there) * unit, far * unit, y * unit, then * unit, 1.0)
            spent = bound * lasts * law.time
            # bounds beyond three times the rate would be rejected often
            if spent > 0.05 and bound > 3.0 * rate_at(here, y, law, 1.0):
                step = 0.5 * lasts
            elif spent < remaining:
                remaining, gone, y, step = remaining - spent, gone + ticks, then, 2.0 * lasts
            else:
                gone += remaining / spent * ticks
                y = threshold(law, goal, age + gone * pace)
                words = words_at(lane, drawn, stream, STEPS)
                drawn += 1
                if uniform(words[0], words[1]) * bound < rate_at(near + sign * gone, y, law, 1.0):
                    return Break(clock + min(whole(gone + 0.5), room), leg, drawn)
                remaining = -np.log(uniform(words[2], words[3]))
        clock, x, age = clock + room, x + d * room, age + room * pace
        if meets:
            return Break(clock, leg, drawn)


def _aged(law, contact, drive, instant):  # type: ignore[no-untyped-def]
    """The threshold at a later instant."""
    age, goal = born(law, contact)
    for leg in range(contact.leg, drive.paces.size):
        begin, end = max(drive.begins[leg], contact.clock), min(drive.begins[leg + 1], instant)
        age += max(end - begin, 0) * (drive.paces[leg] / law.time)
    return threshold(law, goal, age)
