"""Edges: the times at which the number of breaks may jump or bend (kinks), so that panels end there.

There is a kink where the slider turns or changes its speed, where contacts of the start reach a bend of P_c (a jump or
an exact threshold), and where contacts born at an earlier kink do.

An example, all of whose edges a test computes: P_c is a box on [0.8, 1.2], the path 0 -> 1 -> 0 at the speed 1, the
delay 0.15, the tolerance 1e-3. Beside the ends, 0 and 2, the edges are

    t = 0.15  size 1e-2   births begin, one delay after t = 0
    t = 0.3   size 1e-4   one delay after the edge at 0.15, so that the number of those that are out bends
    t = 0.8   size 1e-2   contacts of the start meet the bend of P_c at 0.8
    t = 0.85  size 1e-4   one delay before the turn: what breaks here is born at it (needed)
    t = 0.95  size 2e-4   one delay after 0.8, out as at 0.3; and contacts born at 0.15 meet 0.8
    t = 1     size 1e-2   the turn (needed)
    t = 1.1   size 1e-4   contacts born at 0.95, of breaks at 0.8, had x = 0.05 at the turn: now |x| is as large again
    t = 1.15  size 1e-4   one delay after the turn, out as at 0.3
    t = 1.85  size 1e-4   contacts born at 0.95 meet 0.8, with x = -0.8
    t = 1.95  size 1e-4   contacts born at 1.15, of breaks at the turn, meet 0.8

What follows from a kink is SMOOTHER times as large: 1e-2 at 0.8, 1e-4 where contacts born of it break, and so on. Such
chains end below SMOOTHER times the tolerance, 1e-5 here: none at 0.45, one delay after 0.3, as its size is 1e-6.
Contacts of the start have no edge like that at 1.1, nor those born at 0.15: their |x| does not come back by t = 2.
"""

import heapq
import time as clock
from collections.abc import Iterator, Sequence
from itertools import islice
from typing import NamedTuple

import numpy as np

from master.motion import Motion
from master.renewal.births import Births
from origins.start import Start
from origins.thresholds.law import Array

# Births that jump or bend make later breaks bend where these contacts meet a bend of P_c, each time one order smoother:
# a jump gives a bend, a bend a jump of the second derivative. Each order makes the effect on a panel of 17 nodes about
# this times as large.
SMOOTHER = 1e-2
# Most edges beside those of knots, as halving resolves further bends; and most where breaks jump, at exact thresholds,
# which it does not.
MOST_EDGES, MOST_JUMPS = 400, 4000
# Largest jump of the breaks, in tolerances of their number, that may be left to the panels' own errors.
MOST_UNRESOLVED = 1e3
# A law of thresholds or of stretches at birth is narrow where its width is below this part of the largest threshold.
NARROW = 0.1
# Two edges nearer than this share of the time since their leg began, and ROUNDED of all the time, count as equal, and a
# point nearer than this before an edge counts as after it: times are rounded.
SAME_TIME, ROUNDED = 1e-12, 2e-15


class Kink(NamedTuple):
    """A time at which breaks jump or bend.

    size : of a jump, the share of the contacts in it; of a bend, that of a jump with the same effect on a panel
    needed : whether a panel has to end there however small the kink is: no panel may lie on two legs, nor may the
        births of its breaks, one delay later
    """

    time: float
    size: float
    needed: bool = False


class Passing(NamedTuple):
    """When the |x| of contacts passes a length for the first time: a bend, or, for which `bend` is nan, the largest
    value that it had before a turn, above which contacts begin to break again."""

    time: float
    bend: float


class Edges(NamedTuple):
    """Edges, times sorted from `continued_from` to the end, and the kinks that make them, those met before first;
    too_many_jumps : whether there are more than can be followed."""

    times: Array
    too_many_jumps: bool
    kinks: list[Kink]


def edges(
    births: Births,
    start: Start,
    tolerance: float,
    continued_from: float = 0.0,
    kinks_met: Sequence[Kink] = (),
) -> Edges:
    """Where panels begin and end.

    start : law of the stretches at t = 0
    tolerance : of the number of breaks; the panels' own errors count kinks of a size below SMOOTHER times this
    continued_from, kinks_met : for a march that is continued, the time up to which it is solved, and the kinks up to
        there
    """
    chain = _Kinks(births, continued_from)
    first = [*kinks_met, *chain.of_start(start), *chain.of_knots(), *chain.of_turns()]
    most, least = MOST_JUMPS if births.life.atoms.size else MOST_EDGES, SMOOTHER * tolerance
    most += sum(kink.needed for kink in first)
    met = list(islice(chain.following(first, least), most + 1))
    left = MOST_UNRESOLVED * tolerance
    if too_many := bool(births.life.atoms.size) and len(met) > most:
        # too many of those that may not be left are found at once, and not after all decades of smaller ones
        too_many = sum(1 for _ in islice(chain.following(first, left), most + 1)) > most
    # where there are too many, the smallest are left to the panels' own errors: another decade of sizes each time
    while len(met) > most and not too_many:
        least *= 10.0
        met = list(islice(chain.following(first, least), most + 1))
    end = float(births.motion.times[-1])
    # a kink at the end is an edge already; it is kept for a march that goes on from there
    inside = (kink.time for kink in met if kink.time < end - chain.close(kink.time))
    times = np.array([continued_from, *inside, end])
    return Edges(times, too_many, [*kinks_met, *met])


class _Kinks:
    """Kinks along a motion, and those that follow from each.

    A kink of breaks is, one delay later, one of births. Contacts born then meet the bends
    of P_c together, so that later breaks jump or bend, too, less sharply each time. So kinks form a chain.
    """

    def __init__(self, births: Births, continued_from: float) -> None:
        """For kinks after the time `continued_from`."""
        self.births, self.motion, self.life = births, births.motion, births.life
        self.continued_from = continued_from
        fastest = float(np.abs(self.motion.speeds).max())
        resolution = self.life.resolution_length / fastest if fastest else 0.0
        # times of kinks come from lengths, which are rounded, too; the smallest that matters is the life's resolution
        self._rounded = SAME_TIME * resolution
        # contacts born at one stretch break nearly together where the law of thresholds is narrow: without edges at its
        # ends panels miss a narrow peak of breaks
        near, far = self.life.safe_stretch, self.life.largest_stretch
        self._bends = np.union1d(
            self.life.bends, [near, far] if near > (1.0 - NARROW) * far else []
        )
        # contacts that have moved by more before `continued_from`, a thousandth for rounding, hold no more
        self._farthest = 1.001 * max([far, *self._bends])
        # where the slider is at that time, a position
        self._continued_at = float(self.motion.at(np.array(continued_from)))

    def of_start(self, start: Start) -> list[Kink]:
        """Kinks that follow from t = 0: contacts of the start may break at once, and births begin a delay later. These
        are taken for granted: where none breaks so early, they and what follows from them cost a few panels."""
        beginnings = [Kink(0.0, SMOOTHER), Kink(self.births.delay, SMOOTHER)]
        return [*self.broken(0.0, 1.0, start), *beginnings]

    def of_knots(self) -> list[Kink]:
        """Kinks where the slider turns, or changes its speed, and one delay before; times below 0 are left out later,
        in `following`."""
        found, delay = [], self.births.delay
        one_stretch = self.births.law.is_single and not self.life.timeless
        knots = self.motion.times[1:-1].tolist()
        for time, speed_before in zip(knots, self.motion.speeds[:-1].tolist(), strict=True):
            found.append(Kink(time, SMOOTHER, needed=True))
            # contacts born in one hold share one stretch, and later break together: a jump
            in_hold = one_stretch and speed_before == 0.0
            if in_hold:
                found.append(Kink(time - delay, 1.0, needed=True))
            elif delay > 0.0:
                # breaks one delay before a knot are born at it, where X(s) bends: twice as smooth as a jump of births
                found.append(Kink(time - delay, SMOOTHER * SMOOTHER, needed=True))
        return found

    def of_turns(self) -> list[Kink]:
        """Kinks that follow from contacts which stand just at a bend of P_c where the slider turns.

        Those born before them have met the bend by then, those born after meet it at their largest |x| on the way
        back. So breaks bend where these contacts come back to it, 2 bends behind the turn, though their births are
        smooth. Looked for are births on the leg that ends at the turn, without a rest there: else panels find the bend
        by their errors (180 paths were drawn that rest at the turn, or have two speeds before it: all were within what
        is told, one by a hair: 4.3e-4 of 4.6e-4)."""
        found, law, motion = list[Kink](), self.births.law, self.motion
        ends = zip(motion.times, motion.times[1:-1], motion.speeds, motion.speeds[1:], strict=False)
        for begin, turn, speed, speed_after in ends:
            if speed * speed_after >= 0.0:
                continue
            for stretch in law.breakpoints.tolist():
                births = turn - (self._bends - stretch * np.sign(speed)) / abs(speed)
                for birth in births[births > begin].tolist():
                    found += (one for one in self.broken(birth, 1.0, law) if one.time > turn)
        return found

    def broken(self, birth: float, size: float, law: Start) -> list[Kink]:
        """Kinks when contacts meet bends, if their births at the time `birth` have a jump or bend of this size; those
        after `continued_from`."""
        moved = abs(self._continued_at - float(self.motion.at(np.array(birth))))
        if birth < self.continued_from and moved > self._farthest + max(map(abs, law.span)):
            return []  # none holds any more
        # the ends of a narrow law of stretches are like a jump of it
        is_narrow = np.ptp(law.span) < NARROW * self.life.largest_stretch
        found = list[Kink]()
        for stretch in np.union1d(law.breakpoints, law.span if is_narrow else []).tolist():
            for time, bend in passings(self.motion, birth, stretch, self._bends):
                if time > self.continued_from + self.close(time):
                    found.append(Kink(time, size * self._sharpness(bend, stretch)))
        return found

    def _sharpness(self, bend: float, stretch: float) -> float:
        """How sharp breaks are where contacts meet a bend, or pass their largest |x| (`bend` is nan), in the kink of
        their births. They are one order smoother, also at a jump of P_c; but as sharp at an exact threshold, times the
        share of the contacts, born at this stretch, that have it."""
        if not self.life.atoms.size:
            return SMOOTHER  # without a survival for each of the bins of a histogram, of which there are hundreds
        return self.life.atom_fraction(bend, stretch) or SMOOTHER

    def following(self, first: Sequence[Kink], least: float) -> Iterator[Kink]:
        """All kinks, in the order of time, of a size above the least: the first ones, and those that follow.

        Kinks still to come wait in a heap. The next one is taken out, together with all at the same time; if it is
        large enough, or needed, what follows from it is put in. Together they are one kink at the time of the first
        that is needed, or of the first of all. After `births.until` none is looked for: the march has ended.
        """
        end, delay = float(self.motion.times[-1]), self.births.delay
        coming = list(first)
        heapq.heapify(coming)
        while coming and clock.monotonic() <= self.births.until:
            time, size, needed = heapq.heappop(coming)
            close = self.close(time)
            together_until = time + close
            while coming and coming[0].time <= together_until:
                other = heapq.heappop(coming)
                size = min(size + other.size, 1.0)
                if other.needed and not needed:
                    time, needed = other.time, True
            if time > end + close or not (size > least or needed):
                continue
            if time > self.continued_from + close:
                yield Kink(time, size, needed)
            for kink in self.broken(time + delay, size, self.births.law):
                heapq.heappush(coming, kink)
            if delay > 0.0:
                # the number of those that are out bends then
                heapq.heappush(coming, Kink(time + delay, SMOOTHER * size))

    def close(self, time: float) -> float:
        """Time within which kinks count as equal to this one."""
        return same_time(self.motion, time) + self._rounded


def same_time(motion: Motion, time: float) -> float:
    """Time within which kinks count as equal to this one; the ends of its leg are farther off, but for rounding."""
    rounded = ROUNDED * time
    leg = min(int(np.searchsorted(motion.times, time + rounded, "right")), motion.speeds.size) - 1
    before, after = time - motion.times[leg], motion.times[leg + 1] - time
    return max(min(SAME_TIME * float(before), 0.5 * float(after)), 0.0) + rounded


def passings(motion: Motion, birth: float, x: float, bends: Array) -> Iterator[Passing]:
    """When the |x| of contacts born at the time `birth`, at a stretch x, first passes one of the lengths `bends`; and
    when, after a turn, it comes back to its largest value so far, up to which none breaks at its threshold.

    Born at X = 0 with x = 0.2 on the path 0 -> 0.5 -> -1, at the speed 1, with one bend at 0.6: |x| passes it at
    t = 0.4, is 0.7 at the turn, t = 0.5, falls to 0, and comes back to 0.7, at x = -0.7, at t = 1.9: (0.4, 0.6) and
    (1.9, nan)."""
    first = int(motion.leg(birth + same_time(motion, birth)))
    times, speeds = np.append(birth, motion.times[first + 1 :]), motion.speeds[first:]
    stretch = np.cumsum(np.append(x, speeds * np.diff(times)))
    # |x| is convex in time on a leg: nowhere on it is it larger than at the larger one of its ends
    largest_before = np.maximum.accumulate(np.abs(stretch))[:-1]
    at_end = np.abs(stretch[1:])
    at_end_rounded_up = at_end * (1.0 + SAME_TIME)
    # where a leg ends just at the largest value so far, no contact is stretched further; but a bend there is met
    exceeds = largest_before * (1.0 + SAME_TIME) < at_end
    bends_before, bends_at_end = (
        np.searchsorted(bends, length, "right") for length in (largest_before, at_end_rounded_up)
    )
    moves = (speeds != 0.0) & (np.diff(times) > 0.0)
    for leg in np.flatnonzero((exceeds | (bends_before < bends_at_end)) & moves).tolist():
        begin, end = times[leg], times[leg + 1]
        speed, at_begin = speeds[leg], stretch[leg]
        # each length that is passed on this leg, and which bend it is
        new = bends[bends_before[leg] : bends_at_end[leg]].tolist()
        lengths = list(zip(new, new, strict=True))
        # on its first leg a contact has a larger |x| behind it only if it was born stretched against the motion
        if exceeds[leg] and (leg or at_begin * speed < 0.0):
            lengths.insert(0, (largest_before[leg], np.nan))
        for length, bend in lengths:
            t = begin + (np.sign(speed) * length - at_begin) / speed
            if t > begin:
                yield Passing(float(min(t, end)), bend)
