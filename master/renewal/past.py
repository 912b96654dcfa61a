"""Past: number and force, on the present leg, of the births on all legs before and of all lumps.

Lumps are contacts that are born together, the start among them (G_0 and M_0 of the equation).

Where the slider has turned round, rested or changed its speed since a birth, the survival depends on
the moves since. As a function of the place of birth it is nearly smooth where the speed changed, and
bends where the largest |x| of a contact changes sides or meets a bend of the law.

Times are counted from the beginning of the present leg, so that they keep their digits late on.
"""

from __future__ import annotations

import time as clock
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from master.motion.motion import History
from master.renewal import rule
from master.renewal.births import CLOSE, MOST_WORK, TINY, Births, Panels, Pieces, Rows, moments
from master.renewal.lumps import Lump, of_lumps
from master.renewal.table import Table, basis_of, beside

if TYPE_CHECKING:
    from master.renewal.strand_births import StrandBirths

Array = npt.NDArray[np.float64]

# Error of the sums, in units of the births' accuracy, where the survival takes long to compute.
COARSER = 30.0
# Gauss nodes of a piece, and most halvings of it; rounding of times ends them before.
SIZE, DEPTH = 16, 60
# Allowed error at the ends of the table's panels, in units of its accuracy: panels of the march begin
# there, and could not resolve a jump of the number.
ENDS = 2.0
# Share of a leg below which panels of its table are not halved, and at which its first panel is cut.
SHORTEST, FIRST_CUT = 1e-20, 1.0 / 16.0
# Relative rounding of a place.
ROUNDING = 1e-14
# Allowed error of a polynomial at the ends of a piece, in units of its accuracy: beside a root of the
# survival the error is larger there than in between. (A life shorter than the piece shows there.)
END = 100.0
# The survival jumps at exact thresholds: it is evaluated this share of a piece inside its ends.
INSIDE = 1e-9
# Beside an exact threshold times are moved inside their panel by this share of it.
BESIDE = 1e-7
# Share of contacts below which a leg is dropped, in units of that accuracy: many may be.
NEGLIGIBLE = 1e-3


class Past:
    """Births on the legs before one leg of the motion.

    Parameters
    ----------
    births : Births
    until : float
        Reading of time.monotonic() after which no piece is halved.

    Attributes
    ----------
    first : int
        The first panel whose births are on the present leg.
    error : float
        Bound on the error of the number, the largest of all legs so far.
    """

    def __init__(self, births: Births, until: float = np.inf) -> None:
        self._births, self._until = births, until
        self._accuracy = births.accuracy * (1.0 if births.life.quick else COARSER)
        self._leg, self.first, self.error = -1, 0, 0.0
        self._late, self._rested = 0.0, False
        self._dead: set[int] = set()
        self._strands: list[StrandBirths] = []
        self._first = self._last = np.empty(0, dtype=int)

    def enter(self, leg: int, panels: Panels, lumps: Sequence[Lump], edges: Array) -> None:
        """Prepare the sums on a leg, unless they are; all panels before it are solved.

        edges : array of shape (n,), those on the leg, counted from its beginning
        """
        if leg == self._leg:
            return
        self.find(leg, panels)
        self._table, life = None, self._births.life
        self._lumps = [lump for lump in lumps if lump.holds and lump.time <= self._late]
        if life.quick or life.has_strands:
            return  # these sums take no longer than a look-up

        def found(x: Array) -> Array:
            out = self.sums(x) + of_lumps(self._births, self._lumps, self._motion, self._late, x)
            out[1] /= life.reach
            return out

        given = found, np.unique(edges), self._accuracy, SHORTEST * float(edges[-1])
        # on wide panels all nodes may miss a short life: `ends` and `first_cut` detect it
        table = Table(*given, ends=ENDS, size=SIZE, first_cut=FIRST_CUT, goes_on=self._goes_on)
        self._table, self._edges = table, edges
        self.error = max(self.error, ENDS * table.error)

    def at(self, x: Array, lumps: Sequence[Lump]) -> Array:
        """Number and force at times x, in rows, of births on the legs before, and of all lumps.

        Each row lies within one panel of the leg. Returns an array of shape (2, *x.shape).
        """
        if self._table is None:
            return self.sums(x) + of_lumps(self._births, lumps, self._motion, self._late, x)
        found = self._table(beside(x, self._edges))
        found[1] *= self._births.life.reach
        later = [lump for lump in lumps if lump.time > self._late]
        return found + of_lumps(self._births, later, self._motion, self._late, x)

    def find(self, leg: int, panels: Panels) -> None:
        """Find the births on all legs before one, and count their times from its beginning."""
        whole, before, delay = self._births.motion, self._leg, self._births.delay
        self._leg, self._motion, self._late = leg, whole.since(leg), float(whole.times[leg])
        born = panels.middle_of_births(delay)
        self.first = int(np.searchsorted(born, self._late))
        begin, since, width, breaks = (part[: self.first] for part in panels)
        legs = whole.leg(born[: self.first])
        if delay > 0.0:
            since = np.maximum(begin + delay - whole.times[legs], 0.0)
        most = np.abs(breaks).max(axis=1)
        if self._births.life.has_strands:
            from master.renewal.strand_births import StrandBirths

            for earlier in range(max(before, 0), leg):
                own = legs == earlier
                if most[own].sum() > self._negligible:
                    given = self._births, earlier, since[own], width[own], breaks[own]
                    self._strands.append(StrandBirths(*given))
            seen = [own.seen_from(self._motion, self._negligible) for own in self._strands]
            self._strands = [own for own, felt in zip(self._strands, seen, strict=True) if felt]
            self.error = max(self.error, sum(own.missed for own in self._strands))
            return
        # a place is minus the way from the birth to the leg, on which a hold counts as one grain
        ways = np.abs(np.diff(self._motion.positions[: leg + 1]))
        ways = np.where(ways > 0.0, ways, self._births.life.grain)
        self._knots = -np.append(np.cumsum(ways[::-1])[::-1], 0.0)
        speeds = (ways / np.diff(self._motion.times[: leg + 1]))[legs]
        begin = self._knots[legs] + speeds * since
        ends = np.append(begin, begin[-1:] + speeds[-1:] * width[-1:])
        self._ends, self._slopes = ends, breaks @ rule.SLOPES.T
        self._most = np.append(0.0, np.cumsum(np.abs(self._slopes).sum(axis=1)))
        self._find_runs(np.bincount(legs, most, leg).astype(float), legs)

    def _find_runs(self, most: Array, legs: Rows) -> None:
        """Find runs of legs that go one way, or rest, and of whose births some still hold.

        most : array of shape (legs,), upper bound of each leg's births
        """
        motion, births = self._motion, self._births
        found = np.array([leg for leg in np.unique(legs) if leg not in self._dead], dtype=int)
        self._first = self._last = found[:0]
        if not found.size:
            return
        speed = motion.speeds[found]
        begin, last = motion.times[found], motion.times[found + 1]
        # the births whose largest |x| is the least
        high, low = motion.extremes(np.full(1, TINY), found)
        way = 0.5 * (high + low)[0] + births.law.mean() - motion.positions[found]
        least = begin + np.divide(way, speed, out=np.zeros(way.size), where=speed != 0.0)
        least = np.clip(least, begin, last)
        s = np.stack([begin, least, 0.5 * (least + last), last], axis=1).reshape(-1, 1)
        history = motion.history(np.full(s.shape, TINY), s)
        left = births.life.left(births.law, history)[0].reshape(-1, 4).max(axis=1)
        felt = left * most[found] > self._negligible
        self._dead.update(found[~felt].tolist())
        found = found[felt]
        sign = np.sign(motion.speeds[found])
        alone = (np.diff(found) > 1) | (sign[1:] != sign[:-1]) | (sign[1:] == 0.0)
        runs = [run for run in np.split(found, np.flatnonzero(alone) + 1) if run.size]
        self._first = np.array([run[0] for run in runs], dtype=int)
        self._last = np.array([run[-1] for run in runs], dtype=int)
        self._rested = bool((sign == 0.0).any())

    @property
    def _negligible(self) -> float:
        return max(NEGLIGIBLE * self._accuracy, 1e-18)

    def _goes_on(self) -> bool:
        """Whether there is work and time left."""
        return self._births.work <= MOST_WORK and clock.monotonic() <= self._until

    def breaking(self, t: float) -> float:
        """Share of all contacts that were born in holds and reach an exact threshold at t.

        t : an edge, on this leg
        """
        t -= self._late
        if not self._rested or not t > 0.0:
            return 0.0
        near = t - BESIDE * min(t, self._births.life.grain) * np.array([2.0, 1.0, 0.0])
        # the second difference removes the contacts that break at a steady rate
        return float(-np.diff(self.sums(near[:, None])[0, :, 0], n=2)[0])

    def sums(self, grid: Array) -> Array:
        """Number and force at times, in rows, on the leg; shape (2, *grid.shape).

        Each row lies within one panel.
        """
        births, t = self._births, grid
        if self._rested and births.life.atoms.size:
            # at an edge the births of a hold may meet an exact threshold, all at once
            inside = BESIDE * np.ptp(grid, axis=1, keepdims=True)
            t = np.clip(grid, grid[:, :1] + inside, grid[:, -1:] - inside)
        t = np.maximum(t, TINY).ravel()  # t = 0 itself would count as a moment of the leg before
        out = np.zeros((2, t.size))
        if births.life.has_strands:
            return sum((own.sums(t) for own in self._strands), out).reshape(2, *grid.shape)
        if not self._first.size:
            return out.reshape(2, *grid.shape)
        pieces, basis = self._pieces(t), basis_of(SIZE)
        narrow = CLOSE * float(pieces.right.max(initial=0.0) - pieces.left.min(initial=0.0))
        # between exact thresholds a piece is looked at just inside its ends
        inside = INSIDE if births.life.atoms.size else 0.0
        shares = np.concatenate([[inside], basis.nodes, [1.0 - inside]])
        for _ in range(DEPTH):
            if not pieces.left.size:
                break
            width = pieces.right - pieces.left
            place = pieces.left[:, None] + width[:, None] * shares
            found = self._left(t[pieces.target], place)
            series = found[..., 1:-1] @ basis.to_legendre
            off = np.abs(series[0] @ basis.at_ends - found[0][:, [0, -1]]).max(axis=-1)
            tail = np.abs(series[..., -2:]).max(axis=-1)
            wrong = np.maximum(np.maximum(tail[0], tail[1] / births.life.reach), off / END)
            wrong *= self._born(pieces)
            rough = (wrong > self._accuracy) & (width > ROUNDING * np.abs(pieces.right))
            rough &= width > narrow
            if rough.any() and not self._goes_on():
                self.error = max(self.error, float(wrong[rough].sum()))
                rough[:] = False
            done = pieces.pick(~rough)
            weights = moments(self._ends, self._slopes, done.left, done.right, SIZE)
            added = (series[:, ~rough] * weights).sum(axis=-1)
            for kind in (0, 1):
                out[kind] += np.bincount(done.target, added[kind], t.size)
            pieces = pieces.pick(rough).halves(self._knots)
        return out.reshape(2, *grid.shape)

    def _left(self, t: Array, place: Array) -> Array:
        """Share and force at times t, shape (n,), of births at places (n, columns)."""
        births = self._births
        births.work += births.dear * place.shape[0]
        found = births.life.left(births.law, self._history(t, place))
        return found.reshape(2, *place.shape)

    def _history(self, t: Array, place: Array) -> History:
        """Moves from births at places (n, columns) to times (n,), each by itself: a piece may hold
        births of several legs."""
        s = np.interp(place.ravel(), self._knots, self._motion.times[: self._knots.size])
        return self._motion.history(np.repeat(t, place.shape[1])[:, None], s[:, None])

    def _born(self, pieces: Pieces) -> Array:
        """Upper bound of the births on each piece."""
        bounds = [np.interp(x, self._ends, self._most) for x in (pieces.left, pieces.right)]
        return np.asarray(bounds[1] - bounds[0])

    def _pieces(self, t: Array) -> Pieces:
        """Pieces of the births, for each target, with ends where the survival bends."""
        motion, law, life = self._motion, self._births.law, self._births.life
        ends = self._ends
        first = np.clip(self._knots[self._first], ends[0], ends[-1])[None, :, None]
        last = np.clip(self._knots[self._last + 1], ends[0], ends[-1])[None, :, None]
        every = np.ones((t.size, 1, 1))
        cuts = [first * every, last * every]
        high, low = (part[:, :, None] for part in motion.extremes(t, self._last))
        if law.is_single:
            r, now = law.mean(), motion.at(t)[:, None, None]
            marks = np.append(life.bends, [abs(r), life.reach])
            goals = [high + r - marks, low + r + marks, 0.5 * (high + low) + r]
            goals += [now + r + 0.0 * high, high + r, low + r]
            sign = np.sign(motion.speeds[self._last])[None, :, None]
            turned = motion.positions[self._last + 1][None, :, None]
            away = sign * (np.concatenate(goals, axis=2) - turned)
            at = self._knots[self._last + 1][None, :, None] + away
            cuts.append(np.where(sign == 0.0, last, np.clip(at, first, last)))
        edges = np.concatenate(cuts, axis=2)
        pieces = Pieces.of(edges.reshape(t.size, -1))
        # gaps between runs are no pieces
        run = np.searchsorted(last[0, :, 0], 0.5 * (pieces.left + pieces.right))
        run = np.minimum(run, self._last.size - 1)
        pieces = pieces.pick(0.5 * (pieces.left + pieces.right) > first[0, run, 0])
        if not pieces.left.size:
            return pieces
        shares = np.array([0.5]) if law.is_single else np.array([0.0, 0.5, 1.0])
        place = pieces.left[:, None] + (pieces.right - pieces.left)[:, None] * shares
        history, (lowest, highest) = self._history(t[pieces.target], place), law.span
        high, low = (part.reshape(place.shape) for part in (history.high, history.low))
        least = np.maximum(lowest + high.min(axis=1), -(highest + low.max(axis=1)))
        return pieces.pick(least < life.reach)
