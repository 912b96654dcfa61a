"""A slider pulled through a spring, from break to break.

Between two breaks dF/dX is the stiffness k of the contacts that hold, so that K (X_T - X) = F gives
dX_T/dX = (K + k)/K. While the slider sticks, X_T rises to the next break. In an avalanche X_T is fixed,
and the slider moves to where K (X_T - X) = F again, or to the next break if that comes first. Where no
contact holds any more it moves to X = X_T, however far that is.

On a soft spring X and X_T get large beside a threshold, and a slip is long. Positions are whole numbers, and
forces are formed from X and X_T relative to a base near the slider, so that F and K (X_T - X) keep their digits.
"""

from math import frexp

import numpy as np

from eq_model.compiling import bare, entry, inlined
from eq_model.coupled.forming import (
    break_contact,
    break_numbered,
    form_all,
    form_many,
    stiffness_of,
)
from eq_model.coupled.heat import is_gone, queue_position, time_to_next
from eq_model.coupled.heat_moves import furthest_back, go_back, propose
from eq_model.coupled.moves import (
    balance,
    load_at,
    look_ahead,
    move,
    next_return,
    pass_time,
    rebase,
    store_points,
    time_of_drive,
)
from eq_model.coupled.queue_kernel import BREAK, NOTHING, add_break, open_bucket, settle, take_next
from eq_model.coupled.slider import BASE, BREAKS, DRIVE, F_AFTER, F_BEFORE, X_AFTER, X_BEFORE

PATH_DONE, SLIP_ENDED, OVERTAKEN, GOING_ON = range(4)
RETURN, BALANCE, HEAT = 3, 4, 5  # further events, beside NOTHING, BUCKET_END and BREAK of the queue
# Proposals by heat that take about as long as a bucket.
PROPOSALS = 256


@inlined
def _stick(s, pull, ages, ahead):  # type: ignore[no-untyped-def]
    """Let the drive go on to the next event of a slider that sticks, which is returned."""
    due, drive = next_return(s, pull)
    time = s.now + time_to_next(ages.heat, s)
    if time < due:
        load = load_at(time, s, pull)
        if load < ahead.needs:
            store_points(s, pull, ahead, load, time)
            if s.point < pull.path.size:  # else the drive may turn before
                s.now, s.drive = time, max(s.drive, load)
            return HEAT
    if drive < ahead.needs:
        store_points(s, pull, ahead, drive, due)
        return RETURN
    store_points(s, pull, ahead, ahead.needs, -np.inf)
    if s.point < pull.path.size:
        s.drive = max(s.drive, ahead.needs)
        # if this is a break, an avalanche may begin here
        pull.avalanche[X_BEFORE], pull.avalanche[F_BEFORE] = np.float64(ahead.x), ahead.force
    return ahead.event


@inlined
def _come_back(s, queue, supply, ages, pull, ahead):  # type: ignore[no-untyped-def]
    """Form the contacts whose delay is over, at the slider's X at that time."""
    due, drive = next_return(s, pull)
    pass_time(s, due)
    x = max(s.base + np.int64(np.rint(balance(s, pull, ahead, drive))), s.at)
    move(s, x if ahead.event == NOTHING else min(x, ahead.x))
    settle(queue, s.at)
    rebase(s, pull)
    number = pull.many[s.returning % pull.due.size]
    s.returning += 1
    form_many(s, queue, supply, ages, number)


@inlined
def _break_next(s, queue, supply, ages, pull, ahead):  # type: ignore[no-untyped-def]
    """Break the contact ahead, if it has not grown too strong; the first one in an avalanche begins it."""
    move(s, ahead.x)
    x = take_next(queue)
    if ages.numbered:
        if is_gone(ages.heat, x, s.at):
            return
        if s.broken == 0:
            pass_time(s, time_of_drive(s, pull))
        place = queue_position(ages.heat, ages, x, s)
        if place > s.at:
            add_break(queue, place, x)
            return
        break_numbered(s, queue, supply, ages, pull, x)
    else:
        break_contact(s, queue, supply, ages, pull, x, stiffness_of(x, supply))


@inlined
def _count_avalanche(s, pull, after):  # type: ignore[no-untyped-def]
    """Note an avalanche that ends with the slider at base + `after`; returns its number of breaks."""
    size, last = s.broken, pull.avalanche
    last[DRIVE], last[BASE], last[X_AFTER] = s.drive, s.base, np.float64(s.base) + after
    last[F_AFTER], last[BREAKS], s.broken = s.drive - pull.spring * after, size, 0
    if size < pull.slip:
        pull.avalanches[frexp(size)[1] - 1] += 1  # by the number of its bits
    return size


@inlined
def _end_avalanche(s, queue, supply, ages, pull, ahead):  # type: ignore[no-untyped-def]
    """Stop the slider where the spring balances; contacts that are out form again, or will after their delay.

    Returns the avalanche's number of breaks.
    """
    after = balance(s, pull, ahead, s.drive)
    size = _count_avalanche(s, pull, after)
    move(s, max(s.base + np.int64(np.rint(after)), furthest_back(ages.heat, s)))
    settle(queue, s.at)
    out, s.out = s.out, 0
    if pull.wait >= 0.0:
        last = s.returns % pull.due.size
        pull.due[last], pull.many[last] = time_of_drive(s, pull) + pull.wait, out
        s.returns += 1
    elif out > 0:
        form_many(s, queue, supply, ages, out)
    rebase(s, pull)
    return size


@bare
def _reset(slider, queue, supply, ages, pull):  # type: ignore[no-untyped-def]
    """End a slip with new contacts in place of all, also of those due to return; the slider goes to X = X_T."""
    s = slider[0]
    after = s.drive / pull.spring
    s.at, s.returning = s.base + np.int64(np.rint(after)), s.returns
    _count_avalanche(s, pull, after)
    form_all(slider, queue, supply, ages, pull.n)
    rebase(s, pull)


@entry
def slide(slider, queue, supply, ages, pull):  # type: ignore[no-untyped-def]
    """Follow the slider until a slip has ended, or another reason to stop, which is returned."""
    s, passed = slider[0], 0
    while True:
        if pull.resets and s.broken >= pull.slip:
            _reset(slider, queue, supply, ages, pull)
            return SLIP_ENDED
        ahead = look_ahead(s, queue, pull)
        if s.broken == 0:  # the slider sticks
            event = _stick(s, pull, ages, ahead)
            if s.point == pull.path.size:
                return PATH_DONE
        else:  # in an avalanche the drive stands still
            event = BALANCE if ahead.needs > s.drive else ahead.event
        if event == RETURN:
            _come_back(s, queue, supply, ages, pull, ahead)
        elif event == HEAT:
            propose(ages.heat, s, queue, supply, ages, pull, ahead)
            passed += 1
        elif event == BALANCE:
            if go_back(ages.heat, s, queue, supply, ages, pull, ahead):
                continue
            if _end_avalanche(s, queue, supply, ages, pull, ahead) >= pull.slip:
                return SLIP_ENDED
        elif event == BREAK:
            _break_next(s, queue, supply, ages, pull, ahead)
        else:
            move(s, ahead.x)
            open_bucket(queue, ahead.x)
            rebase(s, pull)
            if ahead.x > pull.furthest:
                return OVERTAKEN
            passed += PROPOSALS
        if passed >= 64 * PROPOSALS:  # so that Python can handle an interrupt
            return GOING_ON
