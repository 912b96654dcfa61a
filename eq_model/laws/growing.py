"""A contact whose threshold grows with its age: it keeps its quantile, and breaks as its stretch meets its threshold.

What identifies a contact for life is one number, its `goal`: growing grains state it as a hazard, strengthening as the
threshold at age 0. GROWTHS holds the functions of each kind of growth by the class of its settings. Lengths are in the
unit of the run (WholeDrive.unit), except those of rate laws; ages count from pinning, in units of a time of the growth.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from eq_model.compiling import real, whole
from eq_model.contact import AGED, BREAKS, Break, by_law, most, rate_at
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
        if d != 0 and not outward:
            room = min(room, abs(x))
        elif d != 0:
            ticks = meeting(law, near, pace, real(room), age, goal)
        meets = ticks <= room
        if meets:
            room = min(whole(ticks + 0.5), room)
        sign, passed, y = abs(d) if outward else -abs(d), 0.0, 0.0
        if law.warm:
            y = threshold(law, goal, age)
        while law.warm and passed < room and pace > 0.0:
            ticks = min(step / pace, room - passed)
            lasts, now = ticks * pace, age + passed * pace
            here, there = near + sign * passed, max(near + sign * (passed + ticks), 0.0)
            then, far = threshold(law, goal, now + lasts), max(here, there)
            bound = most(law.rates, min(here, there) * unit, far * unit, y * unit, then * unit, 1.0)
            spent = bound * lasts * law.time
            # bounds beyond three times the rate would be rejected often
            if spent > 0.05 and bound > 3.0 * rate_at(here, y, law, 1.0):
                step = 0.5 * lasts
            elif spent < remaining:
                remaining, passed, y, step = remaining - spent, passed + ticks, then, 2.0 * lasts
            else:
                passed += remaining / spent * ticks
                y = threshold(law, goal, age + passed * pace)
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
    age, goal = born(law, contact)
    for leg in range(contact.leg, drive.paces.size):
        begin, end = max(drive.begins[leg], contact.clock), min(drive.begins[leg + 1], instant)
        age += max(end - begin, 0) * (drive.paces[leg] / law.time)
    return threshold(law, goal, age)
