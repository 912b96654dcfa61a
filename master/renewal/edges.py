"""Edges: the times at which the number of breaks may jump or bend, so that panels end there."""

import heapq
from collections.abc import Iterator, Sequence
from itertools import islice
from typing import NamedTuple

import numpy as np

from master.motion import Motion
from master.renewal.births import Births
from origins.start import Start
from origins.thresholds.law import Array

# Births that jump or bend make later breaks bend where these contacts meet a bend of P_c, each time one order smoother;
# the effect of the bend on a panel of 17 nodes is then about this times as large.
SMOOTHER = 1e-2
# Most edges, as halving resolves further bends; and most where breaks jump, at exact thresholds, which it does not.
MOST_EDGES, MOST_JUMPS = 400, 4000
# Two edges nearer than this share of the time since their leg began, and ROUNDED of all the time, count as equal, and a
# point nearer than this before an edge counts as after it: times are rounded.
SAME_TIME, ROUNDED = 1e-12, 2e-15


class Moment(NamedTuple):
    """A time at which breaks jump or bend, and the share of contacts in it; for a bend, in a jump of equal effect."""

    time: float
    size: float


class Edges(NamedTuple):
    """Edges, times sorted from `since` to the end, and the moments that make them, the known ones first;
    too_many_jumps : whether there are more than can be followed."""

    times: Array
    too_many_jumps: bool
    moments: list[Moment]


def edges(
    births: Births, start: Start, tolerance: float, since: float = 0.0, known: Sequence[Moment] = ()
) -> Edges:
    """Where panels begin and end.

    start : law of the stretches at t = 0
    tolerance : of the number of breaks; the panels' own errors count moments of a size below SMOOTHER times this
    since, known : for a march that is continued, the time that it has reached, and the moments that it has met
    """
    motion, life, again, delay = births.motion, births.life, births.law, births.delay
    end, fastest = float(motion.times[-1]), float(np.abs(motion.speeds).max())
    resolution = life.resolution_length / fastest if fastest else 0.0
    # contacts born alike break together where thresholds are alike, to a tenth: panels end there, or miss a narrow peak
    alike = life.safe_stretch > 0.9 * life.largest_stretch
    bends = np.union1d(life.bends, [life.safe_stretch, life.largest_stretch] if alike else [])

    def break_moments(birth: float, size: float, law: Start) -> Iterator[Moment]:
        """When births with a jump or bend of this size make breaks jump or bend. At a jump of P_c breaks are one order
        smoother; at an exact threshold they are as sharp, times the share of the contacts that have it."""
        ends = law.span if np.ptp(law.span) < 0.1 * life.largest_stretch else []
        for stretch in np.union1d(law.breakpoints, ends).tolist():
            for t, bend in passings(motion, birth, stretch, bends):
                if t > since + same_time(motion, t) + SAME_TIME * resolution:
                    yield Moment(t, size * (life.atom_share(bend, stretch) or SMOOTHER))

    first = [*known, *break_moments(0.0, 1.0, start)]
    for time, speed in zip(motion.times[1:-1].tolist(), motion.speeds.tolist(), strict=False):
        first.append(Moment(time, SMOOTHER))
        # breaks one delay before a knot are born at it; contacts born in one hold share one stretch
        together = speed == 0.0 and not life.timeless and again.is_single
        if delay > 0.0 or together:
            first.append(Moment(time - delay, 1.0 if together else SMOOTHER**2))
    # contacts of the start may break at once; births begin one delay later
    first += [Moment(0.0, SMOOTHER), Moment(delay, SMOOTHER)]

    def following(least: float) -> Iterator[Moment]:
        """All moments after `since` of a size above the least, in the order of time."""
        coming = list(first)
        heapq.heapify(coming)
        while coming:
            time, size = heapq.heappop(coming)
            close = same_time(motion, time) + SAME_TIME * resolution
            while coming and coming[0].time <= time + close:
                size = min(size + heapq.heappop(coming).size, 1.0)
            if size > least and time < end - close:
                if time > since + close:
                    yield Moment(time, size)
                for moment in break_moments(time + delay, size, again):
                    heapq.heappush(coming, moment)
                if delay > 0.0:
                    heapq.heappush(coming, Moment(time + delay, SMOOTHER * size))

    most, least = MOST_JUMPS if life.atoms.size else MOST_EDGES, SMOOTHER * tolerance
    while len(met := list(islice(following(least), most + 1))) > most:
        least *= 10.0
    too_many = bool(life.atoms.size) and least > 1e3 * tolerance
    return Edges(np.array([since, *(moment.time for moment in met), end]), too_many, [*known, *met])


def same_time(motion: Motion, time: float) -> float:
    """Time within which moments count as equal to this one; the ends of its leg are farther off, but for rounding."""
    rounded = ROUNDED * time
    leg = min(int(np.searchsorted(motion.times, time + rounded, "right")), motion.speeds.size) - 1
    before, after = time - motion.times[leg], motion.times[leg + 1] - time
    return max(min(SAME_TIME * float(before), 0.5 * float(after)), 0.0) + rounded


def passings(motion: Motion, birth: float, x: float, bends: Array) -> Iterator[tuple[float, float]]:
    """When the |x| of contacts born then, at a stretch x, first passes each of the lengths `bends`, with that length;
    and, with nan, when it comes back to its largest value so far."""
    furthest, begin = abs(x), birth
    first = int(motion.leg(birth + same_time(motion, birth)))
    for leg in range(first, motion.speeds.size):
        end, speed = float(motion.times[leg + 1]), float(motion.speeds[leg])
        last = x + speed * (end - begin)
        reached = abs(last) * (1.0 + SAME_TIME)
        if reached > furthest and speed and end > begin:
            back = [(furthest, np.nan)] if leg > first or x * speed < 0.0 else []
            new = bends[(furthest < bends) & (bends <= reached)].tolist()
            for goal, bend in [*back, *zip(new, new, strict=True)]:
                t = begin + (np.sign(speed) * goal - x) / speed
                if t > begin:
                    yield min(t, end), bend
        furthest, begin, x = max(furthest, abs(x), abs(last)), end, last
