"""Contacts of one block in lanes: drawn, followed until they break, and drawn again.

A lane follows one contact of the block after another. In each row of draws every lane takes one threshold, with which
its contact forms anew: at X = 0 where the one before held to the end. The loop is compiled for each type of law, so
that absent laws cost nothing, and cached on disk, which closures cannot be.

Under any law a contact holds until `break_of` breaks it, and is out for the delay if there is one. In steady forward
motion, cold or warm (`Forward`), a contact that breaks at the stretches x1, x2, ... is relaxed again at x1, x1 + x2,
... of the slider; released stretches are summed in the breaks' bins. Loops of up to four arrays become vector code.
"""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from eq_model.blocks import Whole
from eq_model.compiling import compiled, real, unsigned, whole
from eq_model.contact import (
    Contact,
    aged_threshold,
    bin_of,
    break_of,
    breaks_in_row,
    by_law,
    count_event,
    later,
    look_at,
    place_of,
)
from eq_model.draws.births import LEVEL_UNIT, draw_stretches, draw_thresholds, draw_values
from eq_model.draws.streams import EXPOSURES, LANES
from origins.thresholds.law import Array


class Forward(NamedTuple):
    """Steady forward motion by a law that breaks whole rows; the instants of lanes are then positions of the slider."""

    law: Any


class Lanes(NamedTuple):
    """Arrays of one block: the contact of each lane, what one row of draws gave it, and scratch; of shape (LANES,)."""

    number: Whole  # index in the block; the lane's next contact is LANES further
    initial: Whole  # 1 for a contact of the start that has not broken
    instant: Whole  # of the drive's clock, at which it forms; beyond the end once `Forward` has no contact left for it
    leg: Whole
    drawn: Whole  # steps for which the laws have drawn words in the lane
    threshold: Whole
    stretch: Whole  # at which the contact forms
    log_exposure: Whole
    breaks_at: Whole  # where its rate breaks it if the leg goes on, as contact.breaks_in_row has it
    square: Whole  # the slider at the end of the break's bin; then the change of the sum of squares by the break
    log_amount: Array  # ln of the integral of the rate over the way to the break
    bins: npt.NDArray[np.int32]


def _advance_row(law, n, count, work, lanes, sums, counts):  # type: ignore[no-untyped-def]
    """Move n contacts forward to their breaks, by a law for lanes. Returns the number of breaks."""
    drive, breaks, end, many = work.drive, whole(0), work.drive.end, work.drive.bin_ends.size
    instant, bins, square = lanes.instant, lanes.bins, lanes.square
    x = breaks_in_row(law.law, n, lanes.threshold, lanes.breaks_at, lanes, work)
    # from here on, the slider's position at which the contact is relaxed
    for i in range(unsigned(0 if work.again.relaxed else n)):
        instant[i] -= lanes.stretch[i]
        lanes.initial[i] = whole(instant[i] + x[i] > end)
    for i in range(n if counts.shape[0] or not drive.even else 0):
        born, broken = instant[i] + lanes.stretch[i], instant[i] + x[i]
        bins[i] = np.int32(many if broken > end else bin_of(broken, drive))
        square[i] = drive.bin_positions[min(bins[i], many - 1)]
        if born <= end:
            for k in range(drive.before[bin_of(born, drive)], drive.before[bins[i]]):
                look_at(k, instant[i], real(lanes.threshold[i]), drive, counts)
    for i in range(unsigned(n)):
        broken = instant[i] + x[i]
        over = broken > end
        if drive.even:
            bins[i] = np.int32(min(max((broken + drive.offset) >> drive.shift, whole(0)), many))
        number = lanes.number[i] + (whole(LANES) if over else whole(0))
        again = whole(0) if number < count else end + 1
        lanes.number[i], instant[i] = number, again if over else broken
        breaks += whole(not over)
    measured = unsigned(n if work.measured else 0)
    for i in range(measured if drive.even else unsigned(0)):
        square[i] = drive.bin_positions[0] + (whole(bins[i]) << drive.shift)
    for i in range(measured):
        change = real(x[i]) * real(2 * (instant[i] - square[i]) - x[i]) * drive.square
        square[i] = whole(np.floor(0.5 + change))
    for i in range(unsigned(n)):
        sums[unsigned(bins[i]), 1] += x[i]
        if work.measured:
            sums[unsigned(bins[i]), 2] += square[i]
    return breaks


def _follow_row(law, n, count, work, lanes, sums, counts):  # type: ignore[no-untyped-def]
    """Follow one life in each of n lanes, by any law. Returns the number of breaks."""
    breaks, drive = whole(0), work.drive
    breaks_at = breaks_in_row(law, n, lanes.threshold, lanes.breaks_at, lanes, work)
    for i in range(unsigned(n)):
        number = lanes.number[i]
        if number >= count:
            continue
        clock, leg, initial, drawn = (
            lanes.instant[i],
            lanes.leg[i],
            lanes.initial[i],
            lanes.drawn[i],
        )
        x, r, e = lanes.threshold[i], lanes.stretch[i], real(lanes.log_exposure[i]) * LEVEL_UNIT
        k = real(x) / work.mean if work.linked else 1.0
        contact = Contact(clock, leg, r, x, e, breaks_at[i], k, initial == 0, i, drawn, work.stream)
        birth = place_of(clock, leg, drive) - r
        found = break_of(law, contact, drive, counts)
        instant, leg, holds = found.clock, found.leg, found.clock > drive.end
        born, broken = bin_of(clock, drive), drive.bin_ends.size
        count_event(whole(1), k, birth, born, work, sums)
        if not holds:
            broken = bin_of(instant, drive)
            count_event(whole(-1), k, birth, broken, work, sums)
            breaks += whole(instant > clock)
        if counts.shape[0]:
            for j in range(drive.before[born], drive.before[broken]):
                threshold = aged_threshold(law, contact, drive, drive.bin_ends[drive.watched[j]])
                if threshold >= 0.0:
                    look_at(j, birth, threshold, drive, counts)
        if not holds and work.wait > 0.0:
            instant, leg = later(instant, leg, work.wait, drive)
        over = instant > drive.end
        lanes.drawn[i], lanes.initial[i] = found.drawn, whole(over)
        lanes.instant[i], lanes.leg[i] = (whole(0), whole(0)) if over else (instant, leg)
        lanes.number[i] += LANES if over else 0
    return breaks


_row = by_law(lambda law: _advance_row if law is Forward else _follow_row)


@compiled
def follow(work, scratch, count, sums, counts):  # type: ignore[no-untyped-def]
    """Follow one block of contacts to the drive's end. Returns the number of breaks.

    sums : increased, as in contact.count_event. counts : increased, as in contact.look_at.
    """
    stream, starts, again = work.stream, work.starts, work.again
    # the stretches of the start, a single one if it is that of all contacts
    starting = np.empty(count + LANES, whole)
    for part in range(whole(count // LANES + 1)):
        out = starting[part * LANES :]
        draw_stretches(whole(LANES), part & 3, part >> 2, stream, starts, scratch, out)
    starting = starting[: count if starts.drawn else 1]
    if work.forward:  # rows count no births
        for stretch in starting:
            count_event(whole(1) if starts.drawn else count, 1.0, -stretch, 0, work, sums)
    # allocated in the kernel, which then knows that they do not overlap
    m, log_amount, bins = np.zeros((10, LANES), whole), np.zeros(LANES), np.zeros(LANES, np.int32)
    for i in range(LANES):
        m[0, i], m[1, i] = i, 1
    lanes = Lanes(m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8], m[9], log_amount, bins)
    n, turn, breaks, least = min(LANES, count), whole(0), whole(0), whole(0)
    while least < count:
        for row in range(whole(4)):
            if not again.relaxed:
                draw_stretches(n, row, turn, stream, again, scratch, lanes.stretch)
                for i in range(unsigned(n)):
                    start = starting[unsigned(min(lanes.number[i], starting.size - 1))]
                    lanes.stretch[i] = start if lanes.initial[i] else lanes.stretch[i]
            draw_thresholds(n, row, turn, stream, again, scratch, lanes.stretch, lanes.threshold)
            if work.needs_exposure:
                words, e = scratch.exposures, lanes.log_exposure
                draw_values(n, row, turn, stream, EXPOSURES, work.exposures, words, scratch, e)
            breaks += _row(work.law, n, count, work, lanes, sums, counts)
        turn, least = turn + 1, lanes.number[0]
        for number in lanes.number:
            least = min(least, number)
    return breaks
