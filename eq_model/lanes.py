"""Contacts of one block in lanes: drawn, followed until they break, and drawn again.

A lane follows one contact of the block after another. In each row of draws every lane takes one threshold, with which
its contact forms anew: at X = 0 where the one before held to the end. A row is a few short loops over all its lanes,
whatever the path and the laws: where the contacts break (`breaks_of`), in which bins, what that adds to the sums, when
the delay is over, and where they form again. What is unpredictable is computed without branches, as a wrong guess of
the processor costs as much as the rest. The loops are compiled for each type of law, so that absent laws cost nothing,
and cached on disk, which closures cannot be; those without tables become vector code.
"""

import numpy as np

from eq_model.compiling import compiled, inlined, real, unsigned, whole
from eq_model.contact import (
    aged_threshold,
    bin_of,
    by_law,
    count_event,
    count_squares,
    later,
    look_at,
)
from eq_model.draws.births import draw_stretches, draw_thresholds, draw_values
from eq_model.draws.streams import EXPOSURES, LANES
from eq_model.row_breaks import Forward, Lanes, breaks_of, contact_of
from eq_model.whole_drive import STIFFNESS_UNIT


@inlined
def _look(law, n, work, lanes, counts):  # type: ignore[no-untyped-def]
    """Count n contacts at the watched points between their births and their breaks."""
    drive = work.drive
    for i in range(n):
        contact = contact_of(i, work, lanes)
        for k in range(drive.before[lanes.born_in[i]], drive.before[lanes.bins[i]]):
            instant = drive.bin_ends[drive.watched[k]]
            threshold = aged_threshold(law, contact, drive, instant)
            if threshold >= 0.0:
                look_at(k, lanes.birth[i], threshold, drive, counts)


@inlined
def _bins_of(instants, n, drive, bins):  # type: ignore[no-untyped-def]
    """Set the bins of n instants; those beyond the end have the one after the last."""
    many, end = drive.bin_ends.size, drive.end
    for i in range(unsigned(n if drive.even else 0)):
        bins[i] = np.int32(min(max((instants[i] + drive.offset) >> drive.shift, whole(0)), many))
    for i in range(0 if drive.even else n):
        bins[i] = np.int32(many if instants[i] > end else bin_of(instants[i], drive))


@inlined
def _count_lives(n, work, lanes, sums):  # type: ignore[no-untyped-def]
    """Add births and breaks of n contacts to the sums of their bins, as contact.count_event does; all that they add is
    computed before, in vector code."""
    positions, birth = work.drive.bin_positions, lanes.birth
    born_in, bins = lanes.born_in, lanes.bins
    formed, broken, stiffness = lanes.square, lanes.place, lanes.waiting
    for i in range(n if work.measured else 0):
        k = real(lanes.threshold[i]) / work.mean if work.linked else 1.0
        count_squares(whole(1), k, birth[i], born_in[i], work, sums)
        count_squares(whole(-1), k, birth[i], bins[i], work, sums)
    for i in range(unsigned(n)):
        formed[i] = birth[i] - positions[unsigned(born_in[i])]
        broken[i] = birth[i] - positions[unsigned(bins[i])]
    for i in range(unsigned(n if work.linked else 0)):
        k = real(lanes.threshold[i]) / work.mean
        formed[i] = whole(np.floor(k * real(formed[i]) + 0.5))
        broken[i] = whole(np.floor(k * real(broken[i]) + 0.5))
        stiffness[i] = whole(np.floor(k * STIFFNESS_UNIT + 0.5))
    for i in range(unsigned(n)):
        first, last = unsigned(born_in[i]), unsigned(bins[i])
        sums[first, 0] += 1
        sums[first, 1] += formed[i]
        sums[last, 0] -= 1
        sums[last, 1] -= broken[i]
        if work.linked:
            sums[first, 3] += stiffness[i]
            sums[last, 3] -= stiffness[i]


@inlined
def _count_changes(n, place, work, lanes, sums):  # type: ignore[no-untyped-def]
    """Add to the sums the breaks of n contacts that form again at once, all else being equal, where the slider is: only
    the position at which each is relaxed changes."""
    birth, square, bins = lanes.birth, lanes.square, lanes.bins
    drive = work.drive
    measured = unsigned(n if work.measured else 0)
    for i in range(measured):
        square[i] = drive.bin_positions[unsigned(bins[i])]
    for i in range(measured):
        displacement = place[i] - birth[i]
        change = real(displacement) * real(2 * (place[i] - square[i]) - displacement) * drive.square
        square[i] = whole(np.floor(0.5 + change))
    for i in range(unsigned(n)):
        sums[unsigned(bins[i]), 1] += place[i] - birth[i]
        if work.measured:
            sums[unsigned(bins[i]), 2] += square[i]


@inlined
def _count_linked(n, count, work, lanes, sums):  # type: ignore[no-untyped-def]
    """Add to the sums n contacts of linked stiffness that form at once where those before them broke, less these: both
    are in one bin, which has as many contacts as before. Contacts of the start form in the first bin."""
    positions, many, linked = work.drive.bin_positions, work.drive.bin_ends.size, unsigned(n)
    force, stiffness, bins = lanes.square, lanes.waiting, lanes.bins
    for i in range(linked):
        first = np.int32(0 if lanes.number[i] < count else many)
        bins[i] = first if lanes.initial[i] else bins[i]
    for i in range(linked):
        force[i] = positions[unsigned(bins[i])]
    for i in range(n if work.measured else 0):
        last = 0.0 if lanes.initial[i] else lanes.stiffness[i]
        k = real(lanes.threshold[i]) / work.mean
        count_squares(whole(1), k, lanes.birth[i], bins[i], work, sums)
        count_squares(whole(-1), last, lanes.last_birth[i], bins[i], work, sums)
    for i in range(linked):
        last = 0.0 if lanes.initial[i] else lanes.stiffness[i]
        k, place = real(lanes.threshold[i]) / work.mean, force[i]
        new, old = k * STIFFNESS_UNIT, last * STIFFNESS_UNIT
        stiffness[i] = whole(np.floor(new + 0.5)) - whole(np.floor(old + 0.5))
        new, old = k * real(lanes.birth[i] - place), last * real(lanes.last_birth[i] - place)
        force[i] = whole(np.floor(new + 0.5)) - whole(np.floor(old + 0.5))
        lanes.stiffness[i], lanes.last_birth[i] = k, lanes.birth[i]
    for i in range(linked):
        sums[unsigned(bins[i]), 1] += force[i]
        sums[unsigned(bins[i]), 3] += stiffness[i]


@inlined
def _wait(n, work, lanes):  # type: ignore[no-untyped-def]
    """Move the instants and legs of n breaks on to the next births, as the delay passes."""
    drive, on, waiting, delayed = work.drive, lanes.breaks_on, lanes.waiting, whole(0)
    broken, instant = lanes.instant, lanes.broken  # the births before are not needed any more
    for i in range(unsigned(n)):
        broken[i] = instant[i]
    for i in range(unsigned(n)):
        leg = unsigned(on[i])
        until = drive.begins[leg + unsigned(1)]
        instant[i] = max(min(broken[i] + work.ticks[leg], until), broken[i])
        waiting[unsigned(delayed)] = whole(i)
        delayed += whole(
            (broken[i] <= until) & (work.wait > real(until - broken[i]) * drive.paces[leg])
        )
    for j in range(unsigned(delayed)):  # their delay goes on after the end of the leg
        lane = unsigned(waiting[j])
        instant[lane], leg_then = later(broken[lane], on[lane], work.wait, drive)
        on[lane] = min(leg_then, whole(drive.paces.size - 1))


@inlined
def _on_path(n, work, lanes, broken, place):  # type: ignore[no-untyped-def]
    """Set when and on which legs the next contacts form, and the place at which the slider then is."""
    drive, on = work.drive, lanes.breaks_on
    for i in range(unsigned(n)):  # the leg of a contact that holds to the end does not matter
        on[i] = on[i] if broken[i] <= drive.end else whole(0)
    if work.wait > 0.0:
        _wait(n, work, lanes)
    for i in range(unsigned(n)):
        leg, then = unsigned(on[i]), unsigned(on[i] + 1)
        far, until = drive.positions[then], drive.begins[then]
        lanes.far[i], lanes.until[i] = far, until
        place[i] = far - drive.directions[leg] * (until - broken[i])
    first_far, first_until = drive.positions[1], drive.begins[1]
    for i in range(unsigned(n)):
        over = broken[i] > drive.end
        lanes.leg[i] = whole(0) if over else on[i]
        lanes.far[i] = first_far if over else lanes.far[i]
        lanes.until[i] = first_until if over else lanes.until[i]


def _by_path(law, n, work, lanes, broken, place):  # type: ignore[no-untyped-def]
    """As `_on_path`, which is compiled once for all laws. Returns the place."""
    _on_path(n, work, lanes, broken, place)
    return place


def _ahead(law, n, work, lanes, broken, place):  # type: ignore[no-untyped-def]
    """As `_on_path` in steady forward motion, where each forms at once and the clock is the slider's position."""
    return broken


re_form = by_law(lambda law: _ahead if law is Forward else _by_path)


@inlined
def _next(n, count, looks, place, work, lanes):  # type: ignore[no-untyped-def]
    """Put the next contact into each of n lanes: the one that forms again at its place, or, where that would be beyond
    the end, the block's next at X = 0."""
    end, broken = work.drive.end, lanes.broken
    for i in range(unsigned(n)):
        over = broken[i] > end
        number = lanes.number[i] + (whole(LANES) if over else whole(0))
        begin = whole(0) if number < count else end + 1
        lanes.number[i] = number
        lanes.birth[i] = begin if over else place[i]
    for i in range(unsigned(n if looks or not (work.forward and work.reforming.relaxed) else 0)):
        over = broken[i] > end
        begin = whole(0) if lanes.number[i] < count else end + 1
        lanes.instant[i] = begin if over else broken[i]
        lanes.initial[i] = whole(over)


@inlined
def _draw(n, row, turn, work, scratch, starting, lanes):  # type: ignore[no-untyped-def]
    """Draw what the next contacts of n lanes have: stretch, threshold, and exposure where the law needs one."""
    stream, reforming = work.stream, work.reforming
    if not reforming.relaxed:
        draw_stretches(n, row, turn, stream, reforming, scratch, lanes.stretch)
        for i in range(unsigned(n)):
            start = starting[unsigned(min(lanes.number[i], starting.size - 1))]
            lanes.stretch[i] = start if lanes.initial[i] else lanes.stretch[i]
    draw_thresholds(n, row, turn, stream, reforming, scratch, lanes.stretch, lanes.threshold)
    if work.needs_exposure:
        words, out = scratch.exposures, lanes.log_exposure
        draw_values(n, row, turn, stream, EXPOSURES, work.exposures, words, scratch, out)


@inlined
def _row(law, n, count, work, lanes, sums, counts):  # type: ignore[no-untyped-def]
    """Follow one life in each of n lanes. Returns the number of breaks."""
    drive, birth, broken = work.drive, lanes.birth, lanes.broken
    for i in range(unsigned(0 if work.reforming.relaxed else n)):
        birth[i] -= lanes.stretch[i]
    if work.at_once and work.linked:
        _count_linked(n, count, work, lanes, sums)
    breaks = breaks_of(law, n, work, lanes, counts)
    _bins_of(broken, n, drive, lanes.bins)
    looks = counts.shape[0] > 0
    if looks or not work.at_once:
        _bins_of(lanes.instant, n, drive, lanes.born_in)
    if looks:
        _look(law, n, work, lanes, counts)
    if not work.at_once:
        _count_lives(n, work, lanes, sums)
    place = re_form(law, n, work, lanes, broken, lanes.place)
    if work.at_once and not work.linked:
        _count_changes(n, place, work, lanes, sums)
    _next(n, count, looks, place, work, lanes)
    return breaks


@compiled
def follow(law, work, scratch, count, sums, counts):  # type: ignore[no-untyped-def]
    """Follow one block of contacts under a law to the drive's end. Returns the number of breaks.

    sums : increased, as in contact.count_event. counts : increased, as in contact.look_at.
    """
    stream, starts = work.stream, work.starts
    # the stretches of the start, a single one if it is that of all contacts
    starting = np.empty(count + LANES, whole)
    for part in range(whole(count // LANES + 1)):
        out = starting[part * LANES :]
        draw_stretches(whole(LANES), part & 3, part >> 2, stream, starts, scratch, out)
    starting = starting[: count if starts.drawn else 1]
    if work.at_once and work.linked:  # rows count no numbers of contacts
        sums[0, 0] += count
    elif work.at_once:  # rows count no births
        for stretch in starting:
            count_event(whole(1) if starts.drawn else count, 1.0, -stretch, 0, work, sums)
    # allocated in the kernel, which then knows that they do not overlap
    m, bins = np.zeros((18, LANES + 8), whole), np.zeros((2, LANES), np.int32)
    stiffness, log_amount = np.zeros(LANES), np.zeros(LANES)
    for i in range(LANES):
        m[0, i], m[1, i] = i, 1
        m[4, i], m[5, i] = work.drive.positions[1], work.drive.begins[1]
    early = m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8], m[9], m[10]
    more = m[11], m[12], m[13], m[14], m[15], m[16], m[17]
    lanes = Lanes(*early, *more, stiffness, log_amount, bins[0], bins[1])
    n, turn, breaks, least = min(LANES, count), whole(0), whole(0), whole(0)
    while least < count:
        for row in range(whole(4)):
            _draw(n, row, turn, work, scratch, starting, lanes)
            breaks += _row(law, n, count, work, lanes, sums, counts)
        turn, least = turn + 1, lanes.number[0]
        for i in range(LANES):
            least = min(least, lanes.number[i])
    return breaks


# As `follow`, and never kept on disk, where nothing tells that a kernel that is not in this package has changed.
follow_anew = compiled(follow.py_func, cache=False)
