"""Cohorts: contacts that were born apart and have moved together since, so that one history holds for all of them.

At T = 0, with contacts that form again at x = 0, all that a contact remembers is where it was born, Y, and the
furthest it has been stretched, m = max |X - Y|: it has held so far with probability S(m), S the survival of P_c. The
slider has since been everywhere between two turning points `low` and `high` and nowhere else, so

    m(Y) = max(high - Y, Y - low),

and a cohort is the density of births B(Y) with those two numbers. The contacts that hold at X = 0 are one as well: a
stretch x_0 is a birth at Y = -x_0, and as X = 0 itself has been visited, m >= |x_0|; B(Y) = Q_ini(-Y) / S(|Y|).
"""

from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from master._old.law import Law
from master._old.piecewise import Piecewise, tabulate
from origins import Contacts
from origins.thresholds.quadrature import gauss

Array = npt.NDArray[np.float64]

_NARROW = 1e-9  # of the mean threshold: below, all start from one stretch
_GONE = 1e-19
_SAME = 1e-9
SLACK = 1e-12
_NOTHING = Piecewise(np.zeros(1), np.empty((16, 0)))


@dataclass(frozen=True)
class Cohort:
    """Births per unit Y, and births at single Y, of contacts for which the slider has been from low to high.

    All in units of the mean threshold.

    Attributes
    ----------
    low, high : float
        The interval of X visited since the births.
    table : Piecewise
        B(Y).
    corners : array of shape (n,)
        Where B jumps, its ends included.
    positions, weights : arrays of shape (m,)
        Births of finite weight at one Y.
    """

    low: float
    high: float
    table: Piecewise = _NOTHING
    corners: Array = field(default_factory=lambda: np.empty(0))
    positions: Array = field(default_factory=lambda: np.empty(0))
    weights: Array = field(default_factory=lambda: np.empty(0))

    def furthest(self, birth: Array) -> Array:
        """m(Y) at births Y."""
        return np.maximum(self.high - birth, birth - self.low)

    def held(self, law: Law, at: float) -> tuple[float, float]:
        """Fraction of all contacts that these are and still hold, and the sum of their stretches at X = `at`."""
        holding = self.weights * law.sf(self.furthest(self.positions) * (1.0 + SLACK))
        total, stretch = float(holding.sum()), float((holding * (at - self.positions)).sum())
        edges = self.table.edges
        if edges.size > 1:
            marks = np.concatenate([law.edges, law.atoms])
            cuts = np.concatenate([self.high - marks, self.low + marks, [0.5 * (self.low + self.high)]])
            nodes, weights = gauss(*_pieces(edges, cuts))
            mass = weights * self.table(nodes) * law.sf(self.furthest(nodes))
            total += float(mass.sum())
            stretch += float((mass * (at - nodes)).sum())
        return total, stretch

    def backward(self, at: float, direction: int) -> float:
        """Largest stretch against `direction` at X = at; below zero where all are stretched along it."""
        births = np.concatenate([self.table.edges, self.positions]) if self.table.edges.size > 1 else self.positions
        return float((direction * (births - at)).max(initial=-np.inf))

    def visited(self, at: float) -> "Cohort":
        """The same after a straight move to X = at."""
        return replace(self, low=min(self.low, at), high=max(self.high, at))

    def moved(self, by: float) -> "Cohort":
        """The same, born elsewhere."""
        return Cohort(
            self.low + by,
            self.high + by,
            self.table.seen(1, by),
            self.corners + by,
            self.positions + by,
            self.weights,
        )

    def scaled(self, factor: float) -> "Cohort":
        """The same, all weights times `factor`."""
        table = Piecewise(self.table.edges, self.table.coefficients * factor)
        return replace(self, table=table, weights=self.weights * factor)

    def alive(self, law: Law) -> "Cohort | None":
        """The same without what no longer holds; None where that is all of it."""
        table, edges = self.table, self.table.edges
        if edges.size > 1:
            # m is a V: least on a panel at one of its ends, or at the V's foot
            ends = np.minimum(self.furthest(edges[:-1]), self.furthest(edges[1:]))
            foot = 0.5 * (self.low + self.high)
            ends = np.where((edges[:-1] < foot) & (foot < edges[1:]), 0.5 * (self.high - self.low), ends)
            size = np.abs(table.coefficients).sum(axis=0) * np.diff(edges) * law.sf(np.maximum(ends, 0.0))
            kept = np.flatnonzero(size > _GONE)
            if kept.size:
                first, last = kept[0], kept[-1] + 1
                table = Piecewise(edges[first : last + 1], table.coefficients[:, first:last])
            else:
                table = _NOTHING
        keep = self.weights * law.sf(self.furthest(self.positions) * (1.0 + SLACK)) > _GONE
        if table.edges.size < 2 and not keep.any():
            return None
        inside = (self.corners >= table.edges[0]) & (self.corners <= table.edges[-1])
        corners = np.unique(np.concatenate([self.corners[inside], table.edges[[0, -1]]]))
        return replace(self, table=table, corners=corners, positions=self.positions[keep], weights=self.weights[keep])


def starting(contacts: Contacts, law: Law) -> Cohort:
    """The contacts that hold at X = 0, as a cohort that has been nowhere else."""
    start, unit = contacts.start, law.unit
    span = np.asarray(start.span) / unit
    if span[1] - span[0] < _NARROW:
        at = start.mean() / unit
        return Cohort(0.0, 0.0, positions=np.array([-at]), weights=1.0 / law.sf(np.array([abs(at)])))
    reach = law.support[1]
    low, high = max(span[0], -reach), min(span[1], reach)

    def births(position: Array) -> Array:
        density = start.pdf(-position * unit) * unit
        survival = law.sf(np.abs(position))
        # a density may diverge at an end, where no weight sits
        known = (survival > 0.0) & np.isfinite(density)
        return np.where(known, density / np.where(survival > 0.0, survival, 1.0), 0.0)[None]

    # 1/S(|x|) has a cusp at 0 and kinks at the law's own
    marks = np.concatenate([law.breakpoints, law.atoms])
    seeds = np.concatenate([np.linspace(-high, -low, 5), -start.breakpoints / unit, marks, -marks, [0.0]])
    seeds = np.unique(seeds[(seeds >= -high) & (seeds <= -low)])
    (table,) = tabulate(births, seeds, 1e-13)
    corners = np.concatenate([[-high, -low], -start.breakpoints / unit, marks, -marks])
    cohort = Cohort(0.0, 0.0, table, np.unique(corners[(corners >= -high) & (corners <= -low)]))
    # beside a start much narrower than its mean, positions are rounded: the weights' sum need not be
    return cohort.scaled(1.0 / cohort.held(law, 0.0)[0])


def together(cohorts: list[Cohort]) -> list[Cohort]:
    """Cohorts for which the slider has been to the same points become one."""
    out: list[Cohort] = []
    for cohort in cohorts:
        same = out and abs(out[-1].low - cohort.low) <= SLACK and abs(out[-1].high - cohort.high) <= SLACK
        if same:
            out[-1] = _join(out[-1], cohort)
        else:
            out.append(cohort)
    return out


def _join(first: Cohort, second: Cohort) -> Cohort:
    return replace(
        first,
        table=_sum(first.table, second.table),
        corners=np.unique(np.concatenate([first.corners, second.corners])),
        positions=np.concatenate([first.positions, second.positions]),
        weights=np.concatenate([first.weights, second.weights]),
    )


def _sum(first: Piecewise, second: Piecewise) -> Piecewise:
    if first.edges.size < 2 or second.edges.size < 2:
        return first if second.edges.size < 2 else second
    every = np.unique(np.concatenate([first.edges, second.edges]))
    # edges that differ by rounding alone, as where a loop is gone through again, are one
    apart = np.diff(every) > _SAME * min(1.0, every[-1] - every[0])
    edges = np.append(every[:-1][np.append(True, apart[:-1])], every[-1])
    (table,) = tabulate(lambda x: (first(x) + second(x))[None], edges, np.inf)
    # where they crowd about a point at which births diverge, what counts is how many there are
    total, width = np.diff(first.integral(edges) + second.integral(edges)), np.diff(edges)
    crowded = np.diff(np.searchsorted(every, edges)) > 1
    table.coefficients[0] = np.where(crowded, total / width, table.coefficients[0])
    return Piecewise(edges, table.coefficients)


def _pieces(edges: Array, cuts: Array) -> tuple[Array, Array]:
    inside = cuts[(cuts > edges[0]) & (cuts < edges[-1])]
    cut = np.unique(np.concatenate([edges, inside]))
    return cut[:-1], cut[1:]
