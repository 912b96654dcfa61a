"""Edges: the times at which the number of breaks may bend or jump, so that panels end there."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master._old.lives.life import Life
from master.motion.motion import Motion
from origins.start import Start

Array = npt.NDArray[np.float64]

# Every break at a bend of P_c makes a bend of the breaks that follow, one order smoother each time:
# on panels of 17 nodes, about two digits smaller.
DIGITS_A_GENERATION = 2.0
# Edges at most, those of lumps apart: beyond, panels that do not resolve the breaks are halved.
MOST = 120
# Edges at most where finite shares of the contacts break at one moment: each is a lump of its own.
MOST_SHARP = 2000
# Two edges nearer than this share of the motion are one.
CLOSE = 1e-11


class _Moment(NamedTuple):
    """A time from which bends spread: how often smoothed, and whether a lump may be born then."""

    time: float
    generation: int
    sharp: bool


class Edges(NamedTuple):
    """times : sorted, from 0 to the end; sharp : whether more lumps met than can be followed."""

    times: Array
    too_many_lumps: bool


def edges(
    motion: Motion,
    life: Life,
    start: Start,
    again: Start,
    delay: float,
    tolerance: float,
) -> Edges:
    """Where panels begin and end.

    motion, life : as in the march
    start, again : laws of the stretches at t = 0 and of the stretches of re-forming
    delay : time for which a broken contact is out
    tolerance : of the number of breaks; bends that are felt less are left out
    """
    generations = -np.log10(tolerance) / DIGITS_A_GENERATION
    end = float(motion.times[-1])
    close = CLOSE * end
    found: list[float] = [0.0, end]
    waiting: list[_Moment] = []

    def meet(moments: list[_Moment]) -> None:
        for moment in sorted(moments):
            if close < moment.time < end - close:
                place = int(np.searchsorted(found, moment.time))
                near = found[max(place - 1, 0) : place + 1]
                if min(abs(moment.time - other) for other in near) > close:
                    found.insert(place, moment.time)
                    waiting.append(moment)

    turns = [_Moment(float(t), 1, False) for t in motion.times[1:-1]]
    meet(turns)
    meet([_Moment(t.time - delay, 2, False) for t in turns if delay > 0.0])
    meet(_after(_Moment(0.0, 0, start.is_single), 0.0, start, motion, life))
    sharp = 0
    while waiting:
        moment = waiting.pop(0)
        sharp += moment.sharp
        if moment.generation >= generations or (len(found) > MOST and not moment.sharp):
            continue
        if sharp > MOST_SHARP:
            break
        if delay > 0.0:
            meet([_Moment(moment.time + delay, moment.generation + 1, False)])
        meet(_after(moment, delay, again, motion, life))
    return Edges(np.array(found), sharp > MOST_SHARP)


def _after(moment: _Moment, delay: float, law: Start, motion: Motion, life: Life) -> list[_Moment]:
    """The moments at which contacts born a delay after one make a bend, or a lump."""
    stretches = [law.mean()] if law.is_single else list(law.breakpoints)
    met = []
    for stretch in stretches:
        for passing in passings(motion, moment.time + delay, float(stretch), life.bends):
            exact = bool(np.isin(passing.mark, life.atoms))
            sharp = moment.sharp and law.is_single and exact
            met.append(_Moment(passing.time, moment.generation + (not sharp), sharp))
    return met


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
