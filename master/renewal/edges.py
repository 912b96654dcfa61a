"""Edges: the times at which the number of breaks may bend or jump, so that panels end there."""

from __future__ import annotations

import heapq
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.lives.life import Life
from master.motion.motion import Motion
from origins.start import Start

Array = npt.NDArray[np.float64]

# Every break at a bend of P_c makes a bend of the breaks that follow, one order smoother each time:
# on panels of 17 nodes, about two digits smaller.
DIGITS_A_GENERATION = 2.0
# Edges at most, those of lumps apart: beyond, panels that do not resolve the breaks are halved.
MOST = 400
# Lumps at most: each is followed by itself.
MOST_LUMPS = 4000
# Share of the contacts below which a lump is left to the rounding of conservation.
LEAST_LUMP = 1e-15
# Two edges nearer than this share of their time are one, and a point this shortly before an edge is
# read after it: times are rounded.
CLOSE = 1e-12


class _Moment(NamedTuple):
    """A time from which bends spread, and how often these have been smoothed."""

    time: float
    generation: float


class Edges(NamedTuple):
    """times : sorted, from 0 to the end; too_many_lumps : whether more met than can be followed."""

    times: Array
    too_many_lumps: bool


def edges(
    motion: Motion, life: Life, start: Start, again: Start, delay: float, tolerance: float
) -> Edges:
    """Where panels begin and end.

    motion, life : as in the march
    start, again : laws of the stretches at t = 0 and of the stretches of re-forming
    delay : time for which a broken contact is out
    tolerance : of the number of breaks; bends that are felt less are left out
    """
    generations = -np.log10(tolerance) / DIGITS_A_GENERATION
    end = float(motion.times[-1])
    fastest = float(np.abs(motion.speeds).max())
    grain = life.grain / fastest if fastest else 0.0
    lumps = _lump_times(motion, life, start, again, delay)
    found: list[float] = [0.0, end]
    waiting: list[_Moment] = []

    def meet(moments: list[_Moment]) -> None:
        for moment in sorted(moments):
            close = CLOSE * (moment.time + grain)
            if close < moment.time < end - close:
                place = int(np.searchsorted(found, moment.time))
                near = found[max(place - 1, 0) : place + 1]
                if min(abs(moment.time - other) for other in near) > close:
                    found.insert(place, moment.time)
                    waiting.append(moment)

    meet([_Moment(t, 0) for t in lumps])
    turns = [_Moment(float(t), 1) for t in motion.times[1:-1]]
    meet(turns)
    meet([_Moment(t.time - delay, 2) for t in turns if delay > 0.0])
    meet(_after(_Moment(0.0, 0), 0.0, start, motion, life))
    most = MOST + len(lumps)
    while waiting:
        moment = waiting.pop(0)
        if moment.generation >= generations or len(found) > most:
            continue
        if delay > 0.0:
            meet([_Moment(moment.time + delay, moment.generation + 1)])
        meet(_after(moment, delay, again, motion, life))
    return Edges(np.array(found), len(lumps) > MOST_LUMPS)


def _lump_times(
    motion: Motion, life: Life, start: Start, again: Start, delay: float
) -> list[float]:
    """When finite shares of the contacts break together, having met an exact threshold together."""
    if not life.atoms.size or not start.is_single:
        return []
    end = float(motion.times[-1])
    coming = [(0.0, 1.0, start.mean())]
    found: list[float] = []
    while coming and len(found) <= MOST_LUMPS:
        time, share, stretch = heapq.heappop(coming)
        while coming and coming[0][0] <= time * (1.0 + CLOSE):
            share += heapq.heappop(coming)[1]
        if time > 0.0:
            found.append(time)
            time, stretch = time + delay, again.mean()
            if not again.is_single:
                continue
        for passing in passings(motion, time, stretch, life.atoms):
            part = share * life.atom_share(passing.mark, stretch)
            if not np.isnan(passing.mark) and part > LEAST_LUMP and passing.time < end:
                heapq.heappush(coming, (passing.time, part, 0.0))
    return found


def _after(moment: _Moment, delay: float, law: Start, motion: Motion, life: Life) -> list[_Moment]:
    """The moments at which contacts born a delay after one make a bend.

    A bend of P_c smooths a bend of the breaks by one order; an exact threshold leaves its order,
    and of its size the share of the contacts that have it.
    """
    found = []
    for stretch in [law.mean()] if law.is_single else list(law.breakpoints):
        for passing in passings(motion, moment.time + delay, float(stretch), life.bends):
            share = life.atom_share(passing.mark, float(stretch))
            lost = -np.log10(share) / DIGITS_A_GENERATION if share > 0.0 else 1.0
            found.append(_Moment(passing.time, moment.generation + lost))
    return found


class Passing(NamedTuple):
    """When the |x| of contacts first passes a mark, or comes back to its largest (mark = nan)."""

    time: float
    mark: float


def passings(motion: Motion, born: float, stretch: float, marks: Array) -> list[Passing]:
    """When contacts born at a time, at a stretch, pass marks or come back to their largest |x|."""
    furthest, found = abs(stretch), []
    if born >= motion.times[-1]:
        return found
    first = int(motion.leg(born + CLOSE * motion.times[-1]))
    begin, x = born, stretch
    for leg in range(first, motion.speeds.size):
        end, speed = float(motion.times[leg + 1]), float(motion.speeds[leg])
        last = x + speed * (end - begin)
        if abs(last) > furthest * (1.0 - CLOSE) and speed:
            goals = [(furthest, np.nan)] if leg > first or x * speed < 0.0 else []
            goals += [
                (mark, mark) for mark in marks if furthest < mark <= abs(last) * (1.0 + CLOSE)
            ]
            for goal, mark in goals:
                t = begin + (np.sign(speed) * goal - x) / speed
                if t > begin:
                    found.append(Passing(min(t, end), mark))
        furthest = max(furthest, abs(x), abs(last))
        begin, x = end, last
    return found
