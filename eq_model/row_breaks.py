"""Where the contacts of a row of lanes break: all at once in loops over the lanes, or one by one.

In steady forward motion, cold or warm (`Forward`), contacts break at their own stretches. Cold contacts on paths that
turn go from leg to leg: in each pass those that break on the leg are done, and the others, which are collected by
lane, wait for the next one. Contacts under all other laws are followed one by one.
"""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from eq_model.blocks import Whole
from eq_model.compiling import inlined, real, unsigned, whole
from eq_model.contact import AGED, Cold, Contact, break_of, breaks_in_row, by_law
from eq_model.draws.births import LEVEL_UNIT
from origins.thresholds.law import Array


class Forward(NamedTuple):
    """Steady forward motion by a law that breaks whole rows; the instants of lanes are then positions of the slider."""

    law: Any


class Lanes(NamedTuple):
    """Arrays of one block: the contact of each lane, what one row of draws gave it, and scratch; of shape (LANES,)."""

    number: Whole  # index in the block; the lane's next contact is LANES further
    initial: Whole  # 1 for a contact of the start that has not broken
    instant: Whole  # of the drive's clock, at which it forms; beyond the end once no contact is left for the lane
    leg: Whole  # on which it forms; cold contacts have it in `breaks_on`
    drawn: Whole  # steps for which the laws have drawn words in the lane
    threshold: Whole
    stretch: Whole  # at which the contact forms
    log_exposure: Whole
    breaks_at: Whole  # where its rate breaks it if the leg goes on, as contact.breaks_in_row has it
    birth: Whole  # the slider's position at which the contact is relaxed
    broken: Whole  # the instant at which it breaks, beyond the end if it holds; then that at which the next one forms
    breaks_on: Whole  # the leg at that instant; before, that of the birth
    far: Whole  # the slider at the end of that leg
    until: Whole  # and the clock there
    direction: Whole  # of the motion on it
    ticks: Whole  # of the clock in the delay, there
    place: Whole  # the slider at that instant; scratch before
    waiting: Whole  # some lanes, that wait for the next pass of a loop
    square: Whole  # scratch: of positions of bins, then of what is added to sums
    last_birth: Whole  # the slider's position at which the lane's contact before was relaxed
    stiffness: Array  # of that one, over the mean one
    log_amount: Array  # ln of the integral of the rate over the way to the break
    born_in: npt.NDArray[np.int32]  # the bin of the birth
    bins: npt.NDArray[np.int32]  # and of the break


def _forward(law, n, work, lanes, counts):  # type: ignore[no-untyped-def]
    """Set the instants at which n contacts break in steady forward motion, by a law for lanes. Returns how many do."""
    x, breaks = breaks_in_row(law.law, n, lanes.threshold, lanes.breaks_at, lanes, work), whole(0)
    for i in range(unsigned(n)):
        broken = lanes.birth[i] + x[i]
        lanes.broken[i] = broken
        breaks += whole(broken <= work.drive.end)
    return breaks


@inlined
def put_on(leg, lane, work, lanes):  # type: ignore[no-untyped-def]
    """Put the break of a lane, or its next birth, on a leg."""
    drive, here, then = work.drive, unsigned(leg), unsigned(leg + 1)
    lanes.breaks_on[lane], lanes.direction[lane] = leg, drive.directions[here]
    lanes.far[lane], lanes.until[lane] = drive.positions[then], drive.begins[then]
    lanes.ticks[lane] = work.ticks[here]


@inlined
def chosen(n, flags, lanes):  # type: ignore[no-untyped-def]
    """Collect those of n lanes whose flag is 1. Returns how many they are."""
    many = whole(0)
    for i in range(unsigned(n)):
        lanes[unsigned(many)] = whole(i)
        many += flags[i]
    return many


def _cold(law, n, work, lanes, counts):  # type: ignore[no-untyped-def]
    """Set the instants and legs at which n contacts break at T = 0: where |X - birth| reaches their thresholds. Returns
    how many do.

    In each pass a leg of all that have not broken yet is taken: the one after that of their birth, then the next that
    goes beyond what they have held already. On the last one the instant may be beyond its end.
    """
    last, tie = whole(work.drive.paces.size - 1), law.tie
    broken, until, on = lanes.broken, lanes.until, lanes.breaks_on
    waiting, goes_on = lanes.waiting, lanes.place
    for i in range(unsigned(n)):
        missing = lanes.threshold[i] - abs(lanes.far[i] - lanes.birth[i])
        broken[i] = until[i] + missing
        goes_on[i] = whole((missing > tie) & (on[i] < last))
    before, first = chosen(n, goes_on, waiting), True
    while before > 0:
        going_on = whole(0)
        for j in range(unsigned(before)):
            lane = unsigned(waiting[j])
            put_on(on[lane] + 1 if first else law.further[on[lane]], lane, work, lanes)
            missing = lanes.threshold[lane] - abs(lanes.far[lane] - lanes.birth[lane])
            broken[lane] = until[lane] + missing
            waiting[unsigned(going_on)] = whole(lane)
            going_on += whole((missing > tie) & (on[lane] < last))
        before, first = going_on, False
    for i in range(n if tie > 0 else 0):  # within `tie` of a turn it counts as reached there
        if on[i] < last:
            broken[i] = min(broken[i], until[i])
    breaks = whole(0)
    for i in range(unsigned(n)):  # a lane without a contact stays beyond the end
        broken[i] = max(broken[i], lanes.instant[i])
        breaks += whole((broken[i] <= work.drive.end) & (broken[i] > lanes.instant[i]))
    return breaks


@inlined
def contact_of(i, work, lanes):  # type: ignore[no-untyped-def]
    """The contact of a lane as it forms."""
    x, exposure = lanes.threshold[i], real(lanes.log_exposure[i]) * LEVEL_UNIT
    k = real(x) / work.mean if work.linked else 1.0
    state = lanes.instant[i], lanes.leg[i], lanes.stretch[i], x, exposure, lanes.breaks_at[i], k
    return Contact(*state, lanes.initial[i] == 0, i, lanes.drawn[i], work.stream)


def _one_by_one(law, n, work, lanes, counts):  # type: ignore[no-untyped-def]
    """Set the instants and legs at which n contacts break, by any law. Returns how many do, once they have held."""
    breaks, last = whole(0), whole(work.drive.paces.size - 1)
    for i in range(unsigned(n)):
        lanes.leg[i] = lanes.breaks_on[i]
    breaks_in_row(law, n, lanes.threshold, lanes.breaks_at, lanes, work)
    for i in range(unsigned(n)):
        lanes.broken[i] = lanes.instant[i]
        if lanes.instant[i] <= work.drive.end:
            found = break_of(law, contact_of(i, work, lanes), work.drive, counts)
            lanes.broken[i], lanes.drawn[i] = found.clock, found.drawn
            put_on(min(found.leg, last), i, work, lanes)
            breaks += whole((found.clock <= work.drive.end) & (found.clock > lanes.instant[i]))
    return breaks


# breaks_of(law, n, work, lanes, counts): sets `broken` and `breaks_on` of n lanes, and returns how many contacts break
_IN_ROWS: dict[type, Any] = {Forward: _forward, Cold: _cold}
breaks_of = by_law(lambda law: _IN_ROWS.get(law, _one_by_one))
AGED[Forward] = AGED[Cold]
