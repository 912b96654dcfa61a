"""A slider pulled through a spring, from break to break.

Between two breaks F grows with X by the stiffness of the contacts that hold, k say, so that
K (X_T - X) = F makes X_T grow by (K + k)/K. Stuck, the drive's X_T rises to the next break. In an
avalanche X_T stands, and the slider moves on to where K (X_T - X) meets F again, or to the next
break if that comes first.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from eq_model.compiling import bare, inlined
from eq_model.coupled.draws import take
from eq_model.coupled.queue_kernel import next_break, open_next, take_next, wait

OFTEN = 64  # buckets after which to tell how far the drive has come
GOING_ON, BUCKETS_PASSED, SLIP_ENDED, RESET_DUE, PATH_DONE, OVERTAKEN = range(6)

# Positions are whole units, forces and stiffnesses are sums of k_i x_i and k_i in <k>.
SLIDER = np.dtype(
    [
        ("at", np.int64),  # X at the last event
        ("force", np.float64),  # F there
        ("stiffness", np.float64),  # of the contacts that hold
        ("back", np.int64),  # where the first contact breaks if the slider moves back
        ("held", np.int64),  # how many hold
        ("pulled", np.float64),  # K X_T at the last break of a stuck slider
        ("out", np.int64),  # broken in this avalanche, and not formed again
        ("broken", np.int64),  # breaks of this avalanche; 0: stuck
        ("breaks", np.int64),  # all of them
        ("before", np.float64),  # X where this avalanche began
        ("force_before", np.float64),
        ("after", np.float64),  # X where the last avalanche ended
        ("force_after", np.float64),
        ("size", np.int64),  # contacts that broke in it
        ("point", np.int64),  # the next point of the path
        ("leg", np.int64),  # that of the clock on which the drive is
        ("return_leg", np.int64),  # that on which the next return is
        ("returning", np.int64),  # the next return
        ("returns", np.int64),  # the end of those that wait
    ]
)


class Pull(NamedTuple):
    """What pulls, and what the contacts are.

    spring : K in <k>; path, time : K X_T of the points, and when; clock, clock_drive : times and X_T
    between which the drive moves straight; wait : the delay; mean : threshold at which k_i = <k>;
    slip : breaks that make an avalanche a slip; at_once, resets : the rule; linked, delayed :
    the laws that are there.
    """

    spring: float
    path: npt.NDArray[np.float64]
    time: npt.NDArray[np.float64]
    clock: npt.NDArray[np.float64]
    clock_drive: npt.NDArray[np.float64]
    wait: float
    mean: float
    slip: int
    at_once: bool
    resets: bool
    linked: bool
    delayed: bool


class Told(NamedTuple):
    """X, F and how many hold at the path's points; how many avalanches broke 1, 2-3, 4-7, ..."""

    position: npt.NDArray[np.float64]
    force: npt.NDArray[np.float64]
    held: npt.NDArray[np.int64]
    avalanches: npt.NDArray[np.int64]


class Returns(NamedTuple):
    """Contacts that are out, in a ring: when they come back, and how many together."""

    time: npt.NDArray[np.float64]
    many: npt.NDArray[np.int64]


@inlined
def move(s, b):  # type: ignore[no-untyped-def]
    """The slider moves to b, and nothing breaks."""
    s.force += s.stiffness * np.float64(b - s.at)
    s.at = b


@inlined
def form(s, queue, supply, pull):  # type: ignore[no-untyped-def]
    """A contact forms at X."""
    x, r = take(supply)
    k = np.float64(x) / pull.mean if pull.linked else 1.0
    s.held += 1
    s.stiffness += k
    s.force += k * np.float64(r)
    s.back = max(s.back, s.at - r - x)
    wait(queue, s.at - r + x, x)


@bare
def form_all(s, queue, supply, pull, n):  # type: ignore[no-untyped-def]
    """n contacts form at X."""
    for _ in range(n):
        form(s[0], queue, supply, pull)


@bare
def time_of(s, pull, drive):  # type: ignore[no-untyped-def]
    """When the drive comes to X_T first."""
    while s[0].leg + 2 < pull.clock.size and pull.clock_drive[s[0].leg + 1] < drive:
        s[0].leg += 1
    leg = s[0].leg
    way = pull.clock_drive[leg + 1] - pull.clock_drive[leg]
    share = (drive - pull.clock_drive[leg]) / way if way > 0.0 else 1.0
    return pull.clock[leg] + share * (pull.clock[leg + 1] - pull.clock[leg])


@bare
def drive_at(s, pull, time):  # type: ignore[no-untyped-def]
    """X_T when the next return comes."""
    while s[0].return_leg + 2 < pull.clock.size and pull.clock[s[0].return_leg + 1] < time:
        s[0].return_leg += 1
    leg = s[0].return_leg
    share = (time - pull.clock[leg]) / (pull.clock[leg + 1] - pull.clock[leg])
    step = pull.clock_drive[leg + 1] - pull.clock_drive[leg]
    return pull.clock_drive[leg] + share * step


@inlined
def tell(s, pull, told, b, load, level, time):  # type: ignore[no-untyped-def]
    """F and X at the points that the drive passes before K X_T = level, there before this time.

    load : F + K X at b if nothing breaks before.
    """
    while s.point < pull.path.size and (
        pull.path[s.point] < level or (pull.path[s.point] == level and pull.time[s.point] < time)
    ):
        x = b - (load - pull.path[s.point]) / (pull.spring + s.stiffness)
        told.position[s.point] = x
        told.force[s.point] = pull.path[s.point] - pull.spring * x
        told.held[s.point] = s.held
        s.point += 1


@inlined
def end_avalanche(s, pull, told, returns, slider):  # type: ignore[no-untyped-def]
    """The slider is where the spring meets the contacts that hold; how many form again now.

    s.after : where that is
    """
    forming = np.int64(0)
    if not pull.at_once:
        move(s, max(np.int64(np.rint(s.after)), s.at))
        if pull.delayed:
            last = s.returns % returns.time.size
            returns.time[last] = time_of(slider, pull, s.pulled / pull.spring) + pull.wait
            returns.many[last] = s.out
            s.returns += 1
        else:
            forming = s.out
        s.out = 0
    s.size, s.broken = s.broken, 0
    size, kind = s.size, 0
    while size > 1:
        size, kind = size >> 1, kind + 1
    if s.size < pull.slip:
        told.avalanches[kind] += 1
    return forming


@bare
def slide(slider, queue, supply, pull, told, returns):  # type: ignore[no-untyped-def]
    """Move on until there is something to do that is done elsewhere: returns one of the reasons."""
    s, passed = slider[0], 0
    while True:
        is_break, b = next_break(queue)
        load = s.force + s.stiffness * np.float64(b - s.at) + pull.spring * np.float64(b)
        both, forming, why = pull.spring + s.stiffness, np.int64(0), GOING_ON
        ends = s.broken > 0 and load > s.pulled  # an avalanche ends before b
        back = False  # contacts return before b
        if s.broken == 0:  # stuck
            level, time = load, -np.inf
            if pull.delayed and s.returning < s.returns:
                due = returns.time[s.returning % returns.time.size]
                comes = pull.spring * drive_at(slider, pull, due)
                if comes < level:
                    back, level, time = True, comes, due
            tell(s, pull, told, b, load, level, time)
            if s.point == pull.path.size:
                return PATH_DONE
            if not back:
                s.pulled = max(s.pulled, level)
                s.before = np.float64(b)
                s.force_before = load - pull.spring * np.float64(b)
        if back:
            move(s, min(max(np.int64(np.rint(b - (load - level) / both)), s.at), b))
            forming = returns.many[s.returning % returns.time.size]
            s.returning += 1
        elif ends:
            s.after = b - (load - s.pulled) / both
            s.force_after = s.pulled - pull.spring * s.after
            forming = end_avalanche(s, pull, told, returns, slider)
            if s.size >= pull.slip:
                why = SLIP_ENDED
        elif is_break:
            move(s, b)
            x = take_next(queue)
            k = np.float64(x) / pull.mean if pull.linked else 1.0
            s.force -= k * np.float64(x)
            s.stiffness -= k
            s.held -= 1
            s.broken += 1
            s.breaks += 1
            if pull.at_once:
                forming = np.int64(1)
            else:
                s.out += 1
            if pull.resets and s.broken >= pull.slip:
                why = RESET_DUE
        else:
            move(s, b)
            if not open_next(queue):
                return OVERTAKEN
            passed += 1
            if passed == OFTEN:
                return BUCKETS_PASSED
        for _ in range(forming):
            form(s, queue, supply, pull)
        if why != GOING_ON:
            return why
