"""A slider pulled through a spring, from break to break.

Between two breaks dF/dX is the stiffness k of the contacts that hold, so that K (X_T - X) = F gives
dX_T/dX = (K + k)/K. While the slider sticks, X_T rises to the next break. In an avalanche X_T is fixed,
and the slider moves to where K (X_T - X) = F again, or to the next break if that comes first. Where no
contact holds any more it moves to X = X_T, however far that is.

On a soft spring X and X_T get large beside a threshold, and a slip is long. Positions are whole numbers, and
forces are formed from X and X_T relative to a base near the slider, so that F and K (X_T - X) keep their digits.
"""

from math import frexp
from typing import NamedTuple

import numpy as np

from eq_model.compiling import bare, entry, inlined
from eq_model.coupled.ages import add_contact, place_of, remove_all, remove_contact
from eq_model.coupled.queue_kernel import (
    BREAK,
    NOTHING,
    add_break,
    clear,
    next_event,
    open_bucket,
    settle,
    take_next,
)
from eq_model.coupled.slider import BASE, BREAKS, DRIVE, F_AFTER, F_BEFORE, X_AFTER, X_BEFORE
from eq_model.draws.supply import take

PATH_DONE, SLIP_ENDED, OVERTAKEN, GOING_ON = range(4)
RETURN, BALANCE = 3, 4  # further events, beside NOTHING, BUCKET_END and BREAK of the queue
# The largest distance from the base, 2^-9 units of which a float resolves; on shorter paths the base is 0.
FAR_FROM_BASE = 1 << 44


class Ahead(NamedTuple):
    """What the slider meets next as it moves on: an event of the queue, where, and the load there."""

    event: int
    x: int  # the slider's own X if nothing is ahead
    load: float  # at x, if nothing breaks before
    force: float  # F there
    needs: float  # the load of the drive that takes the slider there, infinite if nothing is ahead


@inlined
def _move(s, b):  # type: ignore[no-untyped-def]
    """Move the slider to b, without breaks."""
    s.force += s.stiffness * np.float64(b - s.at)
    s.at = b


@inlined
def _rebase(s, pull):  # type: ignore[no-untyped-def]
    """Take the slider's X as the new base if the old one is far away."""
    moved = s.at - s.base
    if moved > FAR_FROM_BASE:
        s.base = s.at
        s.drive -= pull.spring * np.float64(moved)


@inlined
def _stiffness(x, supply):  # type: ignore[no-untyped-def]
    return np.float64(x) / supply.mean if supply.mean > 0.0 else 1.0


@inlined
def _form(s, queue, supply, ages):  # type: ignore[no-untyped-def]
    """Form one contact at the slider's present X."""
    x, r = take(supply)
    k = _stiffness(x, supply)
    s.held += 1
    s.stiffness += k
    s.force += k * np.float64(r)
    s.back = max(s.back, s.at - r - x)
    if ages.beta > 0.0:
        contact = add_contact(ages, x, s.at - r, s.now - s.age)
        add_break(queue, place_of(ages, contact, s.now), contact)
    else:
        add_break(queue, s.at - r + x, x)


@bare
def _form_many(s, queue, supply, ages, number):  # type: ignore[no-untyped-def]
    """Form contacts at the slider's present X."""
    for _ in range(number):
        _form(s, queue, supply, ages)


@entry
def form_all(slider, queue, supply, ages, n):  # type: ignore[no-untyped-def]
    """Replace all contacts by n that form at the slider's present X."""
    s = slider[0]
    s.force, s.stiffness, s.held, s.out, s.broken = 0.0, 0.0, 0, 0, 0
    clear(queue, s.at)
    remove_all(ages)
    _form_many(s, queue, supply, ages, n)


@bare
def _straight(x, places, values):  # type: ignore[no-untyped-def]
    """Linear interpolation at x between increasing places; where places are equal, the first value."""
    k = min(max(np.searchsorted(places, x), 1), places.size - 1)
    step = places[k] - places[k - 1]
    share = (x - places[k - 1]) / step if step > 0.0 else 1.0
    return values[k - 1] + share * (values[k] - values[k - 1])


@inlined
def _look_ahead(s, queue, pull):  # type: ignore[no-untyped-def]
    """What the slider meets next."""
    event, b = next_event(queue)
    x = s.at if event == NOTHING else b
    force = s.force + s.stiffness * np.float64(x - s.at)
    load = force + pull.spring * np.float64(x - s.base)
    return Ahead(event, x, load, force, np.inf if event == NOTHING else load)


@inlined
def _balance(s, pull, ahead, drive):  # type: ignore[no-untyped-def]
    """X - base where the load is that of the drive, on the way to what is ahead."""
    return np.float64(ahead.x - s.base) - (ahead.load - drive) / (pull.spring + s.stiffness)


@inlined
def _next_return(s, pull):  # type: ignore[no-untyped-def]
    """When contacts form again after their delay, and the load of the drive then; infinite if none are out."""
    if s.returning == s.returns:
        return np.inf, np.inf
    due = pull.due[s.returning % pull.due.size]
    drive = _straight(due, pull.clock, pull.clock_drive)
    return due, pull.spring * (drive - np.float64(s.base))


@inlined
def _store_points(s, pull, ahead, drive, time):  # type: ignore[no-untyped-def]
    """Store X and F at the points that the drive passes before its load is `drive`, or there before `time`."""
    base = np.float64(s.base)
    while s.point < pull.path.size:
        reached = pull.spring * (pull.path[s.point] - base)
        if reached > drive or (reached == drive and pull.time[s.point] >= time):
            return
        x = _balance(s, pull, ahead, reached)
        pull.at_points[0, s.point] = base + x
        pull.at_points[1, s.point] = reached - pull.spring * x
        pull.at_points[2, s.point] = s.held
        s.point += 1


@inlined
def _stick(s, pull, ahead):  # type: ignore[no-untyped-def]
    """Let the drive go on to the next event of a slider that sticks, which is returned."""
    due, drive = _next_return(s, pull)
    if drive < ahead.needs:
        _store_points(s, pull, ahead, drive, due)
        return RETURN
    _store_points(s, pull, ahead, ahead.needs, -np.inf)
    if s.point < pull.path.size:
        s.drive = max(s.drive, ahead.needs)
        # if this is a break, an avalanche may begin here
        pull.avalanche[X_BEFORE], pull.avalanche[F_BEFORE] = np.float64(ahead.x), ahead.force
    return ahead.event


@inlined
def _come_back(s, queue, supply, ages, pull, ahead):  # type: ignore[no-untyped-def]
    """Form the contacts whose delay is over, at the slider's X at that time."""
    s.now, drive = _next_return(s, pull)
    x = max(s.base + np.int64(np.rint(_balance(s, pull, ahead, drive))), s.at)
    _move(s, x if ahead.event == NOTHING else min(x, ahead.x))
    settle(queue, s.at)
    _rebase(s, pull)
    number = pull.many[s.returning % pull.due.size]
    s.returning += 1
    _form_many(s, queue, supply, ages, number)


@inlined
def _time_of_drive(s, pull):  # type: ignore[no-untyped-def]
    """When the load of the drive is `s.drive`."""
    drive = np.float64(s.base) + s.drive / pull.spring
    return _straight(drive, pull.clock_drive, pull.clock)


@inlined
def _break_next(s, queue, supply, ages, pull, ahead):  # type: ignore[no-untyped-def]
    """Break the contact ahead, if it has not grown too strong; the first one in an avalanche begins it."""
    _move(s, ahead.x)
    x = take_next(queue)
    if ages.beta > 0.0:
        if s.broken == 0:
            s.now = _time_of_drive(s, pull)
        place = place_of(ages, x, s.now)
        if place > s.at:
            add_break(queue, place, x)
            return
        remove_contact(ages, x)
        x = s.at - ages.zero[x]
    k = _stiffness(x, supply)
    s.held -= 1
    # sums of no contacts have no rounding errors, which a soft spring would not bear
    s.force = s.force - k * np.float64(x) if s.held > 0 else 0.0
    s.stiffness = s.stiffness - k if s.held > 0 else 0.0
    s.broken += 1
    s.breaks += 1
    if pull.at_once:
        _form(s, queue, supply, ages)
    else:
        s.out += 1


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
    after = _balance(s, pull, ahead, s.drive)
    size = _count_avalanche(s, pull, after)
    _move(s, max(s.base + np.int64(np.rint(after)), s.at))
    settle(queue, s.at)
    out, s.out = s.out, 0
    if pull.wait >= 0.0:
        last = s.returns % pull.due.size
        pull.due[last], pull.many[last] = _time_of_drive(s, pull) + pull.wait, out
        s.returns += 1
    elif out > 0:
        _form_many(s, queue, supply, ages, out)
    _rebase(s, pull)
    return size


@bare
def _reset(slider, queue, supply, ages, pull):  # type: ignore[no-untyped-def]
    """End a slip with new contacts in place of all, also of those due to return; the slider goes to X = X_T."""
    s = slider[0]
    after = s.drive / pull.spring
    s.at, s.returning = s.base + np.int64(np.rint(after)), s.returns
    _count_avalanche(s, pull, after)
    form_all(slider, queue, supply, ages, pull.n)
    _rebase(s, pull)


@entry
def slide(slider, queue, supply, ages, pull):  # type: ignore[no-untyped-def]
    """Follow the slider until a slip has ended, or another reason to stop, which is returned."""
    s, passed = slider[0], 0
    while True:
        ahead = _look_ahead(s, queue, pull)
        if s.broken == 0:  # the slider sticks
            event = _stick(s, pull, ahead)
            if s.point == pull.path.size:
                return PATH_DONE
        else:  # in an avalanche the drive stands still
            event = BALANCE if ahead.needs > s.drive else ahead.event
        if event == RETURN:
            _come_back(s, queue, supply, ages, pull, ahead)
        elif event == BALANCE:
            if _end_avalanche(s, queue, supply, ages, pull, ahead) >= pull.slip:
                return SLIP_ENDED
        elif event == BREAK:
            _break_next(s, queue, supply, ages, pull, ahead)
            if pull.resets and s.broken >= pull.slip:
                _reset(slider, queue, supply, ages, pull)
                return SLIP_ENDED
        else:
            _move(s, ahead.x)
            open_bucket(queue, ahead.x)
            _rebase(s, pull)
            if ahead.x > pull.furthest:
                return OVERTAKEN
            passed += 1
            if passed == 64:  # so that Python can handle an interrupt
                return GOING_ON
