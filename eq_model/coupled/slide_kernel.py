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

from eq_model.blocks import Whole
from eq_model.compiling import bare, entry, inlined
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
from eq_model.draws.births import Births, Scratch, draw_stretches, draw_thresholds, make_scratch
from eq_model.draws.streams import LANES, Stream
from origins.thresholds.law import Array

PATH_DONE, SLIP_ENDED, OVERTAKEN, GOING_ON = range(4)
PULLED, BASE, X_BEFORE, X_AFTER, F_BEFORE, F_AFTER, BREAKS = range(7)  # in Pull.avalanche
# The largest distance from the base, 2^-9 units of which a float resolves; on shorter paths the base is 0.
FAR_FROM_BASE = 1 << 44

# Positions are whole units; forces and stiffnesses are sums of k_i x_i and k_i in units of <k>.
SLIDER = np.dtype(
    [
        ("at", np.int64),  # X at the last event
        ("base", np.int64),  # the position from which forces count X and X_T
        ("force", np.float64),  # F there
        ("stiffness", np.float64),  # of the contacts that hold
        ("back", np.int64),  # X at which the first contact would break if the slider moved back
        ("held", np.int64),  # number of contacts that hold
        ("pulled", np.float64),  # K (X_T - base) of the last break that began an avalanche
        ("out", np.int64),  # contacts that broke in this avalanche and have not re-formed
        ("broken", np.int64),  # number of breaks in this avalanche; 0: the slider sticks
        ("breaks", np.int64),  # number of all breaks
        ("point", np.int64),  # index of the next point of the path
        ("returning", np.int64),  # index of the next return of contacts after their delay
        ("returns", np.int64),  # index after the last return
    ]
)


class Supply(NamedTuple):
    """Draws the contacts of one replica that form, 4 LANES at a time."""

    births: Births
    stream: Stream
    scratch: Scratch
    ready: Whole  # (2, 4, LANES): thresholds and stretches
    at: Whole  # index of the next contact, and the number of draws so far
    mean: float  # threshold at which k_i = <k>; 0 if all k_i are equal


class Pull(NamedTuple):
    """The drive and rules for n contacts, and arrays for the results."""

    n: int
    spring: float  # K in <k>
    path: Array  # X_T of the points
    time: Array  # times at which the drive reaches them
    clock: Array  # times between which the drive's speed is constant
    clock_drive: Array  # X_T at these times
    wait: float  # the delay, below 0 if there is none
    slip: int  # fewest breaks of an avalanche that is a slip
    at_once: bool  # whether broken contacts re-form at once
    resets: bool  # whether a slip replaces all contacts
    furthest: int  # X beyond which contacts that re-form stretched take the slider without end
    avalanche: Array  # (7,), the last one; PULLED: K (X_T - BASE)
    at_points: Array  # (3, points): X, F and the number of contacts that hold
    avalanches: Whole  # numbers of those below a slip that broke 1, 2-3, 4-7, ... contacts
    due: Array  # ring buffer of the times at which contacts re-form
    many: Whole  # how many contacts re-form then


def make_supply(births: Births, stream: Stream, mean: float = 0.0) -> Supply:
    """The supply before its first draw."""
    ready, at = np.empty((2, 4, LANES), np.int64), np.array([4 * LANES, 0])
    return Supply(births, stream, make_scratch(), ready, at, mean)


@bare
def _refill(s):  # type: ignore[no-untyped-def]
    turn, n = s.at[1], np.int64(LANES)
    for row in range(np.int64(4)):
        x, r = s.ready[0, row], s.ready[1, row]
        draw_stretches(n, row, turn, s.stream, s.births, s.scratch, r)
        draw_thresholds(n, row, turn, s.stream, s.births, s.scratch, r, x)
    s.at[0], s.at[1] = 0, turn + 1


@inlined
def take(s):  # type: ignore[no-untyped-def]
    """Threshold and stretch of the next contact."""
    if s.at[0] == 4 * LANES:
        _refill(s)
    s.at[0] += 1
    k, lanes = np.uint64(s.at[0] - 1), np.uint64(LANES)
    return max(s.ready[0, k // lanes, k % lanes], np.int64(1)), s.ready[1, k // lanes, k % lanes]


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
        s.pulled -= pull.spring * np.float64(moved)


@inlined
def _stiffness(x, supply):  # type: ignore[no-untyped-def]
    return np.float64(x) / supply.mean if supply.mean > 0.0 else 1.0


@inlined
def _form(s, queue, supply):  # type: ignore[no-untyped-def]
    """Form one contact at the slider's present X."""
    x, r = take(supply)
    k = _stiffness(x, supply)
    s.held += 1
    s.stiffness += k
    s.force += k * np.float64(r)
    s.back = max(s.back, s.at - r - x)
    add_break(queue, s.at - r + x, x)


@entry
def form_all(slider, queue, supply, n):  # type: ignore[no-untyped-def]
    """Replace all contacts by n that form at the slider's present X."""
    s = slider[0]
    s.force, s.stiffness, s.held, s.out, s.broken = 0.0, 0.0, 0, 0, 0
    clear(queue, s.at)
    for _ in range(n):
        _form(s, queue, supply)


@bare
def _straight(x, places, values):  # type: ignore[no-untyped-def]
    """Linear interpolation at x between increasing places; where places are equal, the first value."""
    k = min(max(np.searchsorted(places, x), 1), places.size - 1)
    step = places[k] - places[k - 1]
    share = (x - places[k - 1]) / step if step > 0.0 else 1.0
    return values[k - 1] + share * (values[k] - values[k - 1])


@inlined
def _store_points(s, pull, b, load, level, time):  # type: ignore[no-untyped-def]
    """Store X and F at the points that the drive passes before K X_T = level, or there before `time`.

    b : a position relative to the base; load : F + K X there if nothing breaks before.
    """
    base = np.float64(s.base)
    while s.point < pull.path.size:
        reached = pull.spring * (pull.path[s.point] - base)
        if reached > level or (reached == level and pull.time[s.point] >= time):
            return
        x = b - (load - reached) / (pull.spring + s.stiffness)
        pull.at_points[0, s.point] = base + x
        pull.at_points[1, s.point] = reached - pull.spring * x
        pull.at_points[2, s.point] = s.held
        s.point += 1


@inlined
def _end_avalanche(s, pull, after):  # type: ignore[no-untyped-def]
    """End an avalanche with the slider at base + `after`, where the spring balances; returns its number of breaks."""
    size, last = s.broken, pull.avalanche
    last[PULLED], last[BASE], last[X_AFTER] = s.pulled, s.base, np.float64(s.base) + after
    last[F_AFTER], last[BREAKS], s.broken = s.pulled - pull.spring * after, size, 0
    if size < pull.slip:
        pull.avalanches[frexp(size)[1] - 1] += 1  # by the number of its bits
    return size


@entry
def slide(slider, queue, supply, pull):  # type: ignore[no-untyped-def]
    """Follow the slider until a slip has ended, or another reason to stop, which is returned."""
    s, passed = slider[0], 0
    while True:
        event, b = next_event(queue)
        if event == NOTHING:
            b = s.at
        force = s.force + s.stiffness * np.float64(b - s.at)
        ahead = np.float64(b - s.base)
        load = force + pull.spring * ahead
        first = np.inf if event == NOTHING else load  # F + K X where something happens
        both, forming, why = pull.spring + s.stiffness, np.int64(0), GOING_ON
        comes_back = False  # whether contacts re-form before b
        if s.broken == 0:  # the slider sticks
            level, time = first, -np.inf
            if s.returning < s.returns:
                due = pull.due[s.returning % pull.due.size]
                drive = _straight(due, pull.clock, pull.clock_drive)
                comes = pull.spring * (drive - np.float64(s.base))
                if comes < level:
                    comes_back, level, time = True, comes, due
            _store_points(s, pull, ahead, load, level, time)
            if s.point == pull.path.size:
                return PATH_DONE
            if not comes_back:
                s.pulled = max(s.pulled, level)
                pull.avalanche[X_BEFORE], pull.avalanche[F_BEFORE] = np.float64(b), force
        if comes_back:
            after = s.base + np.int64(np.rint(ahead - (load - level) / both))
            _move(s, max(after, s.at) if event == NOTHING else min(max(after, s.at), b))
            settle(queue, s.at)
            _rebase(s, pull)
            forming = pull.many[s.returning % pull.due.size]
            s.returning += 1
        elif s.broken > 0 and first > s.pulled:  # the avalanche ends before b
            after = ahead - (load - s.pulled) / both
            if _end_avalanche(s, pull, after) >= pull.slip:
                why = SLIP_ENDED
            _move(s, max(s.base + np.int64(np.rint(after)), s.at))
            settle(queue, s.at)
            if pull.wait >= 0.0:
                last = s.returns % pull.due.size
                drive = np.float64(s.base) + s.pulled / pull.spring
                now = _straight(drive, pull.clock_drive, pull.clock)
                pull.due[last], pull.many[last] = now + pull.wait, s.out
                s.returns += 1
            else:
                forming = s.out
            s.out = 0
            _rebase(s, pull)
        elif event == BREAK:
            _move(s, b)
            x = take_next(queue)
            k = _stiffness(x, supply)
            s.held -= 1
            s.force = s.force - k * np.float64(x) if s.held > 0 else 0.0
            s.stiffness = s.stiffness - k if s.held > 0 else 0.0
            s.broken += 1
            s.breaks += 1
            forming = np.int64(pull.at_once)
            s.out += 1 - forming
            if pull.resets and s.broken >= pull.slip:
                # a reset: all contacts are dropped, also those due to return, and X = X_T
                drive = s.pulled / pull.spring
                s.at, s.returning = s.base + np.int64(np.rint(drive)), s.returns
                _end_avalanche(s, pull, drive)
                form_all(slider, queue, supply, pull.n)
                _rebase(s, pull)
                return SLIP_ENDED
        else:
            _move(s, b)
            passed += 1
            open_bucket(queue, b)
            _rebase(s, pull)
            if b > pull.furthest:
                return OVERTAKEN
            if passed == 64:  # so that Python can handle an interrupt
                return GOING_ON
        for _ in range(forming):
            _form(s, queue, supply)
        if why != GOING_ON:
            return why
