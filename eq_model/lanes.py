"""Contacts of one block in lanes: drawn, followed until they break, and drawn again.

A lane follows one contact of the block after another. In each row of draws every lane takes one threshold, with which
its contact forms anew: at X = 0 where the one before held to the end. A row is a few short loops over all its lanes,
whatever the path and the laws: where the contacts break (`breaks_of`), in which bins, what that adds to the sums, when
the delay is over, and where they form again. What is unpredictable is computed without branches, as a wrong guess of
the processor costs as much as the rest. The loops are compiled for each type of law, so that absent laws cost nothing,
and cached on disk, which closures cannot be; those without tables become vector code.
"""

import numpy as np

from eq_model.compiling import compiled, inlined, real, rounded, unsigned, whole
from eq_model.contact import (
    aged_threshold,
    by_law,
    count_event,
    count_squares,
    later,
    look_at,
)
from eq_model.draws.births import draw_stretches, draw_thresholds, draw_values
from eq_model.draws.streams import EXPOSURES, LANES
from eq_model.row_breaks import Forward, Lanes, breaks_of, chosen, contact_of, put_on
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
    ends, late = drive.bin_ends, whole(0)
    for i in range(unsigned(n if drive.even else 0)):
        at = (instants[i] + drive.offset) >> drive.shift
        bins[i] = np.int32(min(max(at, whole(0)), ends.size - 1))
    uneven = unsigned(0 if drive.even else n)
    for i in range(uneven):
        bins[i] = np.int32(min(instants[i], drive.end) >> drive.shift)
    for i in range(uneven):  # nearly always the first bin of the cell or the next, and no branch
        j = whole(drive.first_bin[unsigned(bins[i])])
        j += whole(ends[unsigned(j)] < instants[i])
        late |= ends[unsigned(j)] - instants[i]
        bins[i] = np.int32(j)
    for i in range(uneven if late < 0 else unsigned(0)):
        while ends[unsigned(bins[i])] < instants[i]:
            bins[i] += np.int32(1)


@inlined
def _count_lives(n, work, lanes, sums):  # type: ignore[no-untyped-def]
    """Add births and breaks of n contacts to the sums of their bins, as contact.count_event does; where all stiffnesses
    are equal their positions themselves, from which `follow` takes those of the bins."""
    positions, birth = work.drive.bin_positions, lanes.birth
    born_in, bins = lanes.born_in, lanes.bins
    formed, broken, stiffness = lanes.square, lanes.place, lanes.waiting
    for i in range(n if work.measured else 0):
        k = real(lanes.threshold[i]) / work.mean if work.linked else 1.0
        count_squares(whole(1), k, birth[i], born_in[i], work, sums)
        count_squares(whole(-1), k, birth[i], bins[i], work, sums)
    linked = unsigned(n if work.linked else 0)
    for i in range(linked):
        formed[i] = birth[i] - positions[unsigned(born_in[i])]
        broken[i] = birth[i] - positions[unsigned(bins[i])]
    for i in range(linked):
        k = real(lanes.threshold[i]) / work.mean
        formed[i], broken[i] = rounded(k * real(formed[i])), rounded(k * real(broken[i]))
        stiffness[i] = rounded(k * STIFFNESS_UNIT)
    for i in range(linked):
        first, last = unsigned(born_in[i]), unsigned(bins[i])
        sums[first, 0] += 1
        sums[first, 1] += formed[i]
        sums[first, 3] += stiffness[i]
        sums[last, 0] -= 1
        sums[last, 1] -= broken[i]
        sums[last, 3] -= stiffness[i]
    for i in range(unsigned(0 if work.linked else n)):
        first, last = unsigned(born_in[i]), unsigned(bins[i])
        sums[first, 0] += 1
        sums[first, 1] += birth[i]
        sums[last, 0] -= 1
        sums[last, 1] -= birth[i]


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
        square[i] = rounded(change)
    for i in range(unsigned(n)):
        sums[unsigned(bins[i]), 1] += place[i] - birth[i]
        if work.measured:
            sums[unsigned(bins[i]), 2] += square[i]


@inlined
def _count_linked(n, count, work, lanes, sums):  # type: ignore[no-untyped-def]
    """Add to the sums n contacts of linked stiffness that form at once where those before them broke, less these: both
    are in one bin, which has as many contacts as before. Contacts of the start form in the first bin."""
    positions, many, linked = work.drive.bin_positions, work.drive.bin_ends.size - 1, unsigned(n)
    force, stiffness, bins = lanes.square, lanes.waiting, lanes.bins
    for i in range(linked):
        first = np.int32(0 if lanes.number[i] < count else many)
        bins[i] = first if lanes.initial[i] else bins[i]
    for i in range(linked):
        force[i] = positions[unsigned(bins[i])]
    # as count_squares does
    measured, square = unsigned(n if work.measured else 0), work.drive.square
    squares, crossed, stiff = lanes.place, lanes.broken, lanes.waiting
    for i in range(measured):
        last = 0.0 if lanes.initial[i] else lanes.stiffness[i]
        k = real(lanes.threshold[i]) / work.mean
        new, old = k * k, last * last
        x, y = real(lanes.birth[i] - force[i]), real(lanes.last_birth[i] - force[i])
        squares[i] = rounded(new * x * x * square) - rounded(old * y * y * square)
        crossed[i] = rounded(new * x) - rounded(old * y)
        stiff[i] = rounded(new * STIFFNESS_UNIT) - rounded(old * STIFFNESS_UNIT)
    for i in range(measured):
        sums[unsigned(bins[i]), 2] += squares[i]
        sums[unsigned(bins[i]), 4] += crossed[i]
        sums[unsigned(bins[i]), 5] += stiff[i]
    for i in range(linked):
        last = 0.0 if lanes.initial[i] else lanes.stiffness[i]
        k = real(lanes.threshold[i]) / work.mean
        x, y = real(lanes.birth[i] - force[i]), real(lanes.last_birth[i] - force[i])
        stiffness[i] = rounded(k * STIFFNESS_UNIT) - rounded(last * STIFFNESS_UNIT)
        force[i] = rounded(k * x) - rounded(last * y)
        lanes.stiffness[i], lanes.last_birth[i] = k, lanes.birth[i]
    for i in range(linked):
        sums[unsigned(bins[i]), 1] += force[i]
        sums[unsigned(bins[i]), 3] += stiffness[i]


@inlined
def _wait(n, work, lanes):  # type: ignore[no-untyped-def]
    """Move the instants and legs of n breaks on to the next births, as the delay passes."""
    drive, on, until, delayed = work.drive, lanes.breaks_on, lanes.until, lanes.place
    broken, instant = lanes.instant, lanes.broken  # the births before are not needed any more
    for i in range(unsigned(n)):
        clock, ticks = instant[i], lanes.ticks[i]
        broken[i], instant[i] = clock, max(min(clock + ticks, until[i]), clock)
        # ticks are rounded: where they take nearly all of the leg `later` decides
        delayed[i] = whole((clock + ticks + (ticks >> 48) >= until[i]) & (clock <= until[i]))
    many = chosen(n, delayed, lanes.waiting)
    for j in range(unsigned(many)):  # their delay ends with the leg, or goes on after it
        lane = unsigned(lanes.waiting[j])
        instant[lane], leg_then = later(broken[lane], on[lane], work.wait, drive)
        put_on(min(leg_then, whole(drive.paces.size - 1)), lane, work, lanes)


@inlined
def _on_path(n, work, lanes, broken, place):  # type: ignore[no-untyped-def]
    """Set when and on which legs the next contacts form, and the place at which the slider then is."""
    if work.wait > 0.0:
        _wait(n, work, lanes)
    for i in range(unsigned(n)):
        place[i] = lanes.far[i] - lanes.direction[i] * (lanes.until[i] - broken[i])
    drive, ticks = work.drive, work.ticks[0]
    far, until, direction = drive.positions[1], drive.begins[1], drive.directions[0]
    for i in range(unsigned(n)):
        over = broken[i] > drive.end
        lanes.far[i] = far if over else lanes.far[i]
        lanes.until[i] = until if over else lanes.until[i]
        lanes.direction[i] = direction if over else lanes.direction[i]
        lanes.ticks[i] = ticks if over else lanes.ticks[i]
        lanes.breaks_on[i] = whole(0) if over else lanes.breaks_on[i]


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

    sums : zeros, set as in contact.count_event. counts : increased, as in contact.look_at.
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
    m, bins = np.zeros((20, LANES + 8), whole), np.zeros((2, LANES), np.int32)
    stiffness, log_amount = np.zeros(LANES), np.zeros(LANES)
    early = m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8], m[9], m[10], m[11]
    more = m[12], m[13], m[14], m[15], m[16], m[17], m[18], m[19]
    lanes = Lanes(*early, *more, stiffness, log_amount, bins[0], bins[1])
    for i in range(LANES):
        lanes.number[i], lanes.initial[i] = i, 1
        put_on(whole(0), unsigned(i), work, lanes)
    n, turn, breaks, least = min(LANES, count), whole(0), whole(0), whole(0)
    while least < count:
        for row in range(whole(4)):
            _draw(n, row, turn, work, scratch, starting, lanes)
            breaks += _row(law, n, count, work, lanes, sums, counts)
        turn, least = turn + 1, lanes.number[0]
        for i in range(LANES):
            least = min(least, lanes.number[i])
    for j in range(0 if work.at_once or work.linked else sums.shape[0]):  # see `_count_lives`
        sums[j, 1] -= sums[j, 0] * work.drive.bin_positions[j]
    return breaks


# As `follow`, and never kept on disk, where nothing tells that a kernel that is not in this package has changed.
follow_anew = compiled(follow.py_func, cache=False)
