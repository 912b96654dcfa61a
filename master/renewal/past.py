"""Past: number and force, on the present leg, of the births on all legs before and of all lumps.

Lumps are contacts that are born together, the start among them (G_0 and M_0 of the equation).
Where the slider has turned round, rested or changed its speed since a birth, the survival depends on the moves since.
As a function of the time of birth on one leg it bends where the largest |x| of a contact changes sides or meets a bend
of the law, and is smooth between bends. Times are counted from the beginning of the present leg, to keep digits.
"""

import time as clock
from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt

from master.motion import History
from master.numerics import polynomials
from master.numerics.polynomials import Pieces, Rows
from master.renewal.births import MOST_WORK, TINY, Births, Lump, Panels, legendre_births
from master.renewal.present import TARGETS
from master.renewal.strand_births import StrandBirths
from master.survival.life import MARGIN
from origins.start import Start
from origins.thresholds.law import Array

# Where a survival takes long, and births on earlier legs change little over a panel, the cubic through their sums at
# FEW of TARGETS, from 0 to the end, gives those at all of them; the sums at CHECKED ones test it. A layer right behind
# a turn would show at the first of these. The interpolant may be MARGIN times as far off between them.
FEW = [0, 3 * polynomials.DEGREE // 8, 11 * polynomials.DEGREE // 16, polynomials.DEGREE]
CHECKED = [polynomials.DEGREE + 1, polynomials.DEGREE + 3]
FROM_FEW_TO_ALL = polynomials.Points(2.0 * TARGETS[FEW] - 1.0).at(TARGETS)
# Where this fails, it is tried again on panels of this part of the width only.
NARROWER = 0.5
# Factor on the accuracy where a survival is a sum: so exact a sum over births would take long.
COARSER = 30.0
# Births on a leg are left out where fewer than this part of the accuracy hold, as many legs may be left out; at least a
# hundredth of the rounding of sums.
LEFT_OUT, LEAST_LEFT_OUT = 1e-3, 1e-18
# Nodes of a piece that are tried first where a survival takes long; they are doubled before the piece is halved.
FIRST_NODES = 5
# Rounding of a time of birth, relative: that of some sums and differences of times.
ROUNDED_TIME = 1e-14
# The survival jumps at exact thresholds: on panels that end there it is evaluated this share of the panel inside.
INSIDE = 1e-9


class Past:
    """Births on the legs before one leg of the motion.

    leg, began, first : the leg, when it begins, and the first panel whose births are on it
    error : estimate from above of the error of the number by the sums over births, the largest of all legs so far
    survival_error : the largest error of a survival so far, as the life returned it
    """

    def __init__(self, births: Births) -> None:
        self._births, self._life = births, births.life
        # sums of survivals that take long to compute are less accurate
        self._accuracy = births.accuracy * (1.0 if births.life.quick else COARSER)
        self._negligible = max(LEFT_OUT * self._accuracy, LEAST_LEFT_OUT)
        self.leg, self.first, self.error = -1, 0, 0.0
        self.survival_error = births.life.error
        # legs of whose births hardly any hold: left out, and to be left out from the next leg on
        self._dropped, self._dropped_next = set[int](), set[int]()
        self._strands: list[StrandBirths] = []
        self._legs = np.empty(0, dtype=int)  # of whose births many hold
        # the longest travel on a panel at which the sums at FEW are tried
        self._interpolated = 0.0 if births.life.quick or births.life.atoms.size else np.inf

    def enter(self, leg: int, panels: Panels) -> None:
        """Find the births on all legs before one, and count their times from its beginning."""
        whole, before, delay = self._births.motion, self.leg, self._births.delay
        self.leg, self.began = leg, float(whole.times[leg])
        self._motion = whole.counted_from(leg)
        middle = panels.middle_of_births(delay)
        self.first = int(np.searchsorted(middle, self.began))
        legs = whole.leg(middle[: self.first])
        panels = Panels(*(part[: self.first] for part in panels))
        panels = panels._replace(since=panels.births_begin(whole.times[legs], delay))
        if self._life.has_strands:
            self._follow(range(max(before, 0), leg), panels, legs)
            return
        begin = self._motion.times[legs] + panels.since
        self._ends = panels.ends(begin)
        self._slopes = panels.breaks @ polynomials.SLOPES.T
        self._most = np.append(0.0, np.cumsum(np.abs(self._slopes).sum(axis=1)))
        self._dropped |= self._dropped_next
        self._legs = np.array(sorted(set(legs.tolist()) - self._dropped), dtype=int)

    def at(self, grid: Array, lumps: Sequence[Lump]) -> Array:
        """Number and force of births on the legs before, and of all lumps, (2, rows, columns), at times in rows, each
        within one panel of the leg. Values at FEW of all TARGETS give the others, where CHECKED ones agree."""
        travel = float(np.ptp(grid[0])) * abs(float(self._motion.speeds[self.leg]))
        if self._legs.size and 0.0 < travel < self._interpolated and grid.shape[1] == TARGETS.size:
            summed = self._summed(grid[:, FEW + CHECKED], lumps)
            at_few, at_checked = np.split(summed, [len(FEW)], axis=2)
            interpolant = at_few @ FROM_FEW_TO_ALL
            number, force = np.abs(interpolant[..., CHECKED] - at_checked).max(axis=(1, 2))
            error = MARGIN * float(max(number, force / self._life.largest_stretch))
            if error <= self._accuracy:
                self.error = max(self.error, error)  # a smooth interpolant hides it from the panels
                return np.asarray(interpolant)
            self._interpolated = NARROWER * travel
        return self._summed(grid, lumps)

    def _summed(self, grid: Array, lumps: Sequence[Lump]) -> Array:
        """As `at`, at any times: sums over births and lumps."""
        t = grid
        if self._life.atoms.size and not self._motion.speeds[: self.leg].all():
            # at an edge the births of a hold may meet an exact threshold, all at once
            first, last = (end(axis=1, keepdims=True) for end in (grid.min, grid.max))
            inside = INSIDE * (last - first)
            t = np.clip(grid, first + inside, last - inside)
        t = np.maximum(t, TINY).ravel()  # t = 0 itself would count as an instant of the leg before
        out = np.zeros((3, t.size))  # the third: the error of the number
        for strand in self._strands:
            out[:2] += strand.sums(t)
        held = np.zeros(self.leg)  # by leg, at the latest time
        for (owner, low, high), found in self._resolved(t):
            for sums, added in zip(out, found, strict=True):
                sums += np.bincount(owner, added, t.size)
            late = t[owner] == t.max()
            leg = self._motion.leg(0.5 * (low + high)[late])
            held += np.bincount(leg, found[0, late], held.size)
        self.error = max(self.error, float(out[2].max()))
        self._dropped_next = {leg for leg in self._legs.tolist() if held[leg] <= self._negligible}
        return out[:2].reshape(2, *grid.shape) + self._of_lumps(lumps, grid)

    def _of_lumps(self, lumps: Sequence[Lump], grid: Array) -> Array:
        """Number and force of lumps at times in rows, each within one panel. A row's middle column says on which side
        of a threshold it is, and whether a lump that is born at an end of the panel is born before."""
        births, motion, middle = self._births, self._motion, grid[:, grid.shape[1] // 2]
        out, first = np.zeros((2, *grid.shape)), grid.min(keepdims=True)
        inside = INSIDE * np.ptp(grid, axis=1)
        panel_begin, panel_end = grid.min(axis=1) + inside, grid.max(axis=1) - inside
        for law in dict.fromkeys(lump.law for lump in lumps):
            some = [[lump.time, lump.weight] for lump in lumps if lump.law is law]
            time, weight = np.array(some).T
            s = time[:, None] - self.began
            # no panel ends at the birth of a small lump: it is out before, so that the panel's error shows the kink
            amid = (panel_begin < s) & (s < panel_end)
            out[0] += (weight @ ((s > middle) & ~amid))[:, None]  # still out
            may_hold = (s >= first) | self._hold(law, motion.history(first, s))[:, None]
            lump, row = np.nonzero(may_hold & ((s <= middle) | amid))
            if row.size:
                births.add_work(row.size)
                t, birth = grid[row], s[lump]
                held = self._survivors(law, motion.history(np.maximum(t, birth), birth))
                is_out = amid[lump, row, None] & (t < birth)
                held = np.where(is_out, [[[1.0]], [[0.0]]], held)
                for sums, added in zip(out, weight[lump, None] * held, strict=True):
                    np.add.at(sums, row, added)
        return out

    def _survivors(self, law: Start, history: History) -> Array:
        """Survival and force of contacts born at stretches of a law, shape (2, rows, columns); their error is kept."""
        found = self._life.survival_and_force(law, history)
        self.survival_error = max(self.survival_error, found.error)
        return found.both

    def _hold(self, law: Start, history: History) -> npt.NDArray[np.bool_]:
        """Whether any contacts born at stretches of a law, with the moves of a row, hold; shape (rows,).

        The births of a row stand for all in between: the smallest of their largest displacements, and the largest of
        their smallest, are those of the contact that was stretched least. None is left out that may hold."""
        low, high = law.span
        highs, lows = history.high.min(axis=1), history.low.max(axis=1)
        return np.maximum(low + highs, -(high + lows)) <= self._life.largest_stretch

    def _follow(self, legs_before: range, panels: Panels, legs: Rows) -> None:
        """Make strands of the births on some legs, and follow all strands to the present leg."""
        for leg in legs_before:
            on_leg = Panels(*(part[legs == leg] for part in panels))
            if np.abs(on_leg.breaks).max(axis=1).sum() > self._negligible:
                self._strands.append(StrandBirths(self._births, leg, on_leg))
        alive = [each.seen_from(self._motion, self._negligible) for each in self._strands]
        self._strands = [each for each, holds in zip(self._strands, alive, strict=True) if holds]
        self.error = max(self.error, sum(each.missed for each in self._strands))
        survivals = (each.survival_error for each in self._strands)
        self.survival_error = max(self.survival_error, *survivals, 0.0)

    def _resolved(self, t: Array) -> Iterator[tuple[Pieces, Array]]:
        """Pieces of the births as seen from times t, halved until the survival is a polynomial on each; their number,
        force and error, shape (3, pieces). Yielded as they get good: the good ones of each round of halving."""
        if not self._legs.size:
            return
        births, pieces = self._births, self._pieces(t)
        # pieces may end at exact thresholds, where the survival jumps
        nodes = polynomials.gauss if self._life.atoms.size else polynomials.lobatto
        size = polynomials.PANEL_NODES if self._life.quick else FIRST_NODES
        while pieces.owner.size:
            owner, low, high = pieces
            few = nodes(size)
            birth = low[:, None] + (high - low)[:, None] * few.nodes
            births.add_work(owner.size * size // polynomials.PANEL_NODES)
            held = self._survivors(births.law, self._motion.history(t[owner, None], birth))
            left_out, fall = self._first_left_out(held @ few.series[:, -4:])
            most = np.subtract(*(np.interp(end, self._ends, self._most) for end in (high, low)))
            # all legs share the accuracy
            rough = left_out * most * self._legs.size > self._accuracy
            rough &= high - low > self._narrowest(pieces)
            rough &= births.work <= MOST_WORK and clock.monotonic() <= births.until
            good = pieces.pick(~rough)
            weights = legendre_births(self._ends, self._slopes, good.low, good.high, size)
            found = (held[:, ~rough] @ few.series * weights).sum(axis=-1)
            # left out: coefficients n + k, about |c_n| fall^k, times births of that degree, taken as those of n - k
            fading = fall[~rough, None] ** np.arange(size)[::-1]
            missed = left_out[~rough] * (np.abs(weights) * fading).sum(axis=1)
            yield good, np.append(found, missed[None], axis=0)
            pieces = pieces.pick(rough)
            pieces = pieces.halves() if size == polynomials.PANEL_NODES else pieces
            size = min(2 * size, polynomials.PANEL_NODES)

    def _first_left_out(self, last_four: Array) -> tuple[Array, Array]:
        """About the first coefficient that a piece's polynomial leaves out, and by what factor coefficients fall from
        one to the next, shape (pieces,): the larger of number and force (divided by the largest stretch), by the decay
        of the `last_four` coefficients of both, shape (2, pieces, 4)."""
        last, fall_of_two = polynomials.last_and_fall(np.abs(last_four))
        fall, unit = np.sqrt(fall_of_two), np.array([[1.0], [self._life.largest_stretch]])
        return (last * fall / unit).max(axis=0), fall.max(axis=0)

    def _narrowest(self, pieces: Pieces) -> Array:
        """Width of a piece below which its ends are equal by rounding, shape (pieces,)."""
        leg = self._motion.leg(0.5 * (pieces.low + pieces.high))
        durations = np.diff(self._motion.times)[leg]
        return polynomials.CLOSE * durations + ROUNDED_TIME * np.abs(pieces.low)

    def _pieces(self, t: Array) -> Pieces:
        """Pieces of the births on each leg, for each target, with ends where the survival bends.

        Contacts born at s, at the one stretch r, have had stretches from r + low - X(s) to r + high - X(s), low
        and high being the ends of the way since then, and have r + now - X(s). Survival bends, or its force
        does, at births where X(s) - r is one of `goals`: the largest stretch is a mark (high - mark) or the
        smallest is minus a mark (low + mark), a mark being a bend of P_c, |r| or the end of P_c; both are
        equally far from 0 (middle); or one of the three is 0 (now, high, low).
        """
        motion, law, life = self._motion, self._births.law, self._life
        # arrays of shape (targets, legs, ends of pieces)
        ends = motion.times[self._legs], motion.times[self._legs + 1]
        first, last = np.clip(ends, self._ends[0], self._ends[-1])[:, None, :, None]
        cuts = [np.broadcast_to(end, (t.size, self._legs.size, 1)) for end in (first, last)]
        if law.is_single:
            r, now = law.mean(), motion.at(t)[:, None, None]
            tops, bottoms = motion.knots_between(self.leg, self._legs)
            high, low = np.maximum(now, tops[:, None]), np.minimum(now, bottoms[:, None])
            marks = np.append(life.bends, [abs(r), life.largest_stretch])
            middle = 0.5 * (high + low)
            now = np.broadcast_to(now, middle.shape)
            goals = [high - marks, low + marks, middle, now, high, low]
            begin, speed = (part[self._legs, None] for part in (motion.positions, motion.speeds))
            distances = r + np.concatenate(goals, axis=2) - begin
            into_leg = np.zeros(distances.shape)
            np.divide(distances, speed, out=into_leg, where=speed != 0.0)
            cuts.append(np.clip(motion.times[self._legs, None] + into_leg, first, last))
        edges = np.concatenate(cuts, axis=2).reshape(t.size * self._legs.size, -1)
        owner, begin, end = Pieces.between(edges)
        target = owner // self._legs.size
        # with one stretch pieces end where contacts have met the end of P_c: all on a piece hold, or none
        places = np.array([0.5]) if law.is_single else np.array([0.0, 0.5, 1.0])
        place = begin[:, None] + (end - begin)[:, None] * places
        held = self._hold(law, motion.history(t[target, None], place))
        return Pieces(target, begin, end).pick(held)
