"""Edges: the times at which the number of breaks may bend or jump, so that panels end there."""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.lives.life import Life
from master.motion.motion import Motion
from origins.start import Start

Array = npt.NDArray[np.float64]

# A bend of the rate of births makes bends of the later breaks, wherever contacts meet a bend of P_c,
# one order smoother each time: on panels of 17 nodes their effect is about two digits smaller.
DIGITS_A_GENERATION = 2.0
# Most edges beside lumps, further bends are resolved by halving panels; and most lumps, each of which
# is followed individually.
MOST, MOST_LUMPS = 400, 4000
# Share of the contacts below which a lump is within the rounding of conservation, and ignored.
LEAST_LUMP = 1e-15
# Two edges nearer than this share of their time count as equal, and a point nearer than this before
# an edge counts as after it: times are rounded.
CLOSE = 1e-12


class Moment(NamedTuple):
    """A time at which breaks bend, so that later ones do, and how often the bend was smoothed."""

    time: float
    generation: float


class Together(NamedTuple):
    """Contacts born at one time at one stretch, and their share of all."""

    time: float
    share: float
    stretch: float


class Edges(NamedTuple):
    """Edges, and the moments that make them.

    times : array of shape (n,), sorted, from `since` to the end
    too_many_lumps : whether there are more lumps than can be followed
    moments : those at which breaks bend, the known ones first
    """

    times: Array
    too_many_lumps: bool
    moments: list[Moment]


def edges(
    motion: Motion,
    life: Life,
    start: Start,
    again: Start,
    delay: float,
    tolerance: float,
    *,
    since: float = 0.0,
    known: Sequence[Moment] = (),
    born: Sequence[Together] | None = None,
) -> Edges:
    """Where panels begin and end.

    motion, life : as in the march
    start, again : laws of the stretches at t = 0 and of the stretches of re-forming
    delay : time for which a broken contact is out
    tolerance : of the number of breaks; bends with a smaller effect are left out
    since, known, born : for a march that is continued, the time that it has reached, and the
        moments that it has met and the lumps that were born until then
    """
    end, fastest = float(motion.times[-1]), float(np.abs(motion.speeds).max())
    grain = life.grain / fastest if fastest else 0.0
    if born is None:
        born = [Together(0.0, 1.0, start.mean())] if start.is_single else []
    lumps = _lump_times(motion, life, born, again, delay, since) if life.atoms.size else []
    found, met, waiting = [since, end], list(known), list(known)

    def meet(moments: Sequence[Moment]) -> None:
        for moment in sorted(moments):
            close = CLOSE * (moment.time + grain)
            if since + close < moment.time < end - close:
                place = int(np.searchsorted(found, moment.time))
                near = found[max(place - 1, 0) : place + 1]
                if min(abs(moment.time - other) for other in near) > close:
                    found.insert(place, moment.time)
                    waiting.append(moment)
                    met.append(moment)

    def after(moment: Moment, wait: float, law: Start) -> list[Moment]:
        """When contacts born after a moment make breaks bend again.

        A jump of P_c smooths a bend by one order. An exact threshold keeps the order of a bend and
        multiplies its size by the share of contacts with that threshold.
        """
        later = []
        for stretch in [law.mean()] if law.is_single else law.breakpoints.tolist():
            for t, mark in passings(motion, moment.time + wait, stretch, life.bends):
                share = life.atom_share(mark, stretch)
                smoothed = -np.log10(share) / DIGITS_A_GENERATION if share > 0.0 else 1.0
                later.append(Moment(t, moment.generation + smoothed))
        return later

    meet([Moment(t, 0) for t in lumps])
    turns = [Moment(float(t), 1) for t in motion.times[1:-1]]
    waiting += [turn for turn in turns if turn.time <= since]
    meet(turns)
    if delay > 0.0:
        # where contacts of the start break at once, births begin one delay later
        meet([Moment(t.time - delay, 2) for t in turns] + [Moment(delay, 1)])
    meet(after(Moment(0.0, 0), 0.0, start))
    while waiting and len(found) <= MOST + len(lumps):
        moment = waiting.pop(0)
        if moment.generation < -np.log10(tolerance) / DIGITS_A_GENERATION:
            if delay > 0.0:
                meet([Moment(moment.time + delay, moment.generation + 1)])
            meet(after(moment, delay, again))
    return Edges(np.array(found), len(lumps) > MOST_LUMPS, met)


def _lump_times(
    motion: Motion,
    life: Life,
    born: Sequence[Together],
    again: Start,
    delay: float,
    since: float,
) -> list[float]:
    """When, after `since`, finite shares of contacts born together meet an exact threshold."""
    coming, found = list[tuple[float, float]](), list[float]()

    def spread(lump: Together) -> None:
        for t, mark in passings(motion, lump.time, lump.stretch, life.atoms):
            part = lump.share * life.atom_share(mark, lump.stretch)
            if since * (1.0 + CLOSE) < t < motion.times[-1] and part > LEAST_LUMP:
                heapq.heappush(coming, (t, part))

    # contacts born in one hold share one stretch, as lumps do
    holds = motion.times[1:][motion.speeds == 0.0] if not life.timeless and again.is_single else []
    for lump in [*born, *(Together(float(t), 1.0, again.mean()) for t in holds)]:
        spread(lump)
    while coming and len(found) <= MOST_LUMPS:
        time, share = heapq.heappop(coming)
        while coming and coming[0][0] <= time * (1.0 + CLOSE):
            share += heapq.heappop(coming)[1]
        found.append(time)
        if again.is_single:
            spread(Together(time + delay, share, again.mean()))
    return found


def passings(
    motion: Motion, born: float, stretch: float, marks: Array
) -> Iterator[tuple[float, float]]:
    """When the |x| of contacts born at a time, at a stretch, first passes each mark, and that mark;
    and when it comes back to its largest (mark = nan)."""
    furthest, begin, x = abs(stretch), born, stretch
    first = int(motion.leg(born + CLOSE * motion.times[-1]))
    for leg in range(first, motion.speeds.size):
        end, speed = float(motion.times[leg + 1]), float(motion.speeds[leg])
        last = x + speed * (end - begin)
        reached = abs(last) * (1.0 + CLOSE)
        if reached > furthest and speed and end > begin:
            back = [(furthest, np.nan)] if leg > first or x * speed < 0.0 else []
            new = marks[(furthest < marks) & (marks <= reached)].tolist()
            for goal, mark in [*back, *zip(new, new, strict=True)]:
                t = begin + (np.sign(speed) * goal - x) / speed
                if t > begin:
                    yield min(t, end), mark
        furthest, begin, x = max(furthest, abs(x), abs(last)), end, last
