"""Roots: at which rates and frequencies contacts forget that they started together.

Number conservation (docs/equations.md) reads, with Laplace transforms and the way d of the wait,

    b^(s) D(s) = 1/s - G_0^(s),      D(s) = E^(s) e^(-sd) + (1 - e^(-sd))/s,

so that F - F_k is a sum of e^(sX) over the roots of D. All lie left of the imaginary axis, none on
the real one. The change of arg D around each cell of a grid counts those inside (the argument
principle): none is missed where the grid resolves D, and then each cell holds one or none.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.renewal import rule
from master.steady.travel import Travel
from master.stick_slip.transform import WAVE, Transform, reach_of

Array = npt.NDArray[np.float64]
Complex = npt.NDArray[np.complex128]

# Rates at which the search begins: over the mean way from birth to birth and over the longest one
# that a few contacts hold for, the smaller of both; by how
# much it grows, and at least where it was too much; and where nothing is
# left after one mean way.
FIRST, OF_LONGEST, GROWTH, LEAST_GROWTH, DEEPEST = 0.5, 3.0, 2.0, 1.1, 40.0
# Of the rate of E's own tail, or of exact values: roots nearer to it are not looked for.
NEAR = 0.9
# |p^| below which no root is near, and frequencies that are looked at: over the length on which E
# falls, and at most over the mean way from birth to birth.
BELOW, HIGH, HIGHEST = 0.8, 8.0, 2000.0
# Sides of the cells, over the inverse of the mean way where slow decays count; how often halved.
SIDE, HALVINGS = 0.8, 3
# Turn of arg D along an edge (rad) from which on the edge is cut, and how often: an edge that meets
# a root within rounding keeps an open turn, and its cells count no whole number.
FAR_TURN, CUTS = 1.5, 40
# Steps of Newton's method, and its last step over |s|.
STEPS, LAST = 40, 1e-13


class Roots(NamedTuple):
    """Roots of D with Im s > 0 (per length), slowest first: all right of Re s = -searched.

    roots : array of shape (n,)
    searched : float, 0 where no part of the plane could be resolved
    transforms : list of Transform, of rising decay, the last of which is `searched`
    level : array of shape (n,), in which of them each root was found: the least tilted, which
        knows it best
    """

    roots: Complex
    searched: float
    transforms: list[Transform]
    level: npt.NDArray[np.intp]

    def first(self, count: int) -> Roots:
        """The slowest of them."""
        return self._replace(roots=self.roots[:count], level=self.level[:count])


NO_ROOTS = Roots(np.empty(0, dtype=complex), 0.0, [], np.empty(0, dtype=np.intp))


def conserved(transform: Transform, wait: float, s: Complex) -> tuple[Complex, Complex]:
    """D and D' at s of shape (n,), none 0; `wait` is d, a length."""
    values = transform(s)
    waited, out = np.exp(-s * wait), -np.expm1(-s * wait) / s
    slope = waited * (values.slope - wait * values.held) + (wait * waited - out) / s
    return values.held * waited + out, slope


def root_errors(transform: Transform, wait: float, s: Complex) -> Array:
    """Errors of roots of D: its residual and its own error, over |D'|."""
    value, slope = conserved(transform, wait, s)
    waited = np.abs(np.exp(-s * wait))
    off = transform(s).held_off * waited
    off += np.finfo(float).eps * (1.0 + (1.0 + np.abs(s) * wait) * waited) / np.abs(s)
    return np.asarray((np.abs(value) + off) / np.abs(slope) + np.spacing(np.abs(s)))


def leading_roots(
    travel: Travel, wait: float, count: int, limit: float, blur: float = 0.0
) -> Roots:
    """At least `count` roots, or all right of Re s = -limit; fewer where D is not resolved.

    Frequencies are looked at up to some 2,000 over the mean way from birth to birth.
    """
    whole = travel.length + wait
    ways = travel.table.edges
    # share of contacts that hold for the longest way
    longest = float(ways[np.flatnonzero(travel.table(ways)[0] > 1e-8)[-1]]) + wait
    best = NO_ROOTS
    limit = min(limit, DEEPEST / whole)
    decay = min(FIRST / whole, OF_LONGEST / longest, limit)
    growth = GROWTH
    while growth > LEAST_GROWTH:
        found = None
        # ln of the largest E e^(decay x), from which on its rounding leaves nothing of 1
        if reach_of(travel, decay).log_most + decay * wait < 32.0:
            transform = Transform(travel, decay, blur)
            found = _roots(transform, wait, whole)
        if found is None:
            growth = growth**0.5
        else:
            new = found[found.real <= -best.searched]
            if found.size != best.roots.size + new.size:  # one was missed before
                best, new = best.first(0), found
            level = np.append(best.level, np.full(new.size, len(best.transforms)))
            roots, transforms = np.append(best.roots, new), [*best.transforms, transform]
            best = Roots(roots, decay, transforms, level)
            if roots.size >= count or decay >= limit:
                break
        decay = min(growth * (best.searched or decay / GROWTH), limit)
    return best


def _roots(transform: Transform, wait: float, whole: float) -> Complex | None:
    """All roots right of Re s = -decay with Im s > 0; None where they are not resolved."""
    decay = transform.decay
    noise = transform(np.array([complex(-decay)])).held_off[0] * decay * np.exp(decay * wait)
    top = _highest(transform, wait, whole)
    # error of D over what is left of 1 where D is no longer known
    if not noise < 1e-3 or top is None:
        return None
    side = SIDE / float(transform.centre + wait)
    for _ in range(HALVINGS):
        columns = int(np.ceil(decay / side)) + 2
        rows = int(np.ceil(top / side)) + 2
        # more cells of one grid take too long
        if rows * columns > 100_000:
            return None
        real = -decay + side * np.arange(float(columns))
        imaginary = side * np.arange(float(rows))
        s = real + 1j * imaginary[:, None]
        s[0, s[0] == 0.0] = 1e-6 * side
        values = (
            transform.grid(real, float(side), rows) * np.exp(-s * wait) - np.expm1(-s * wait) / s
        )
        across = _turned(transform, wait, s[:, :-1], s[:, 1:], values[:, :-1], values[:, 1:])
        up = _turned(transform, wait, s[:-1], s[1:], values[:-1], values[1:])
        turns = across[:-1] + up[:, 1:] - across[1:] - up[:, :-1]
        number = np.rint(turns / (2.0 * np.pi)).astype(int)
        sure = np.abs(turns - 2.0 * np.pi * number).max() < 1e-6
        if sure and number.min() >= 0 and number.max() <= 1:
            cells = np.nonzero(number)
            found = _polished(transform, wait, s[cells] + 0.5 * side * (1.0 + 1.0j), side)
            if found is not None:
                return found[(found.real > -decay) & (found.imag < imaginary[-1])]
        side *= 0.5
    return None


def _turned(
    transform: Transform, wait: float, begin: Complex, end: Complex, first: Complex, last: Complex
) -> Array:
    """How far arg D turns along straight edges; all arrays of one shape.

    Where it turns far, a root lies beside the edge: on which side is told by cutting the edge.

    first, last : D at `begin` and `end`
    """
    turned = np.angle(last / first)
    steep = np.nonzero(np.abs(turned) > FAR_TURN)
    turned[steep] = 0.0
    edge, parts = np.arange(steep[0].size), [part[steep] for part in (begin, end, first, last)]
    sums = np.zeros(edge.size)
    for _ in range(CUTS):
        if not edge.size:
            break
        begin, end, first, last = parts
        middle = 0.5 * (begin + end)
        half = conserved(transform, wait, middle)[0]
        edge, begin, end = np.tile(edge, 2), np.append(begin, middle), np.append(middle, end)
        first, last = np.append(first, half), np.append(half, last)
        turn = np.angle(last / first)
        far = np.abs(turn) > FAR_TURN
        np.add.at(sums, edge[~far], turn[~far])
        edge, parts = edge[far], [part[far] for part in (begin, end, first, last)]
    turned[steep] = sums
    return turned


def _polished(transform: Transform, wait: float, s: Complex, side: float) -> Complex | None:
    """Newton's method from the middle of cells; None where not each leads to a root of its own."""
    start, s = s, s.copy()
    open_ = np.arange(s.size)
    for _ in range(STEPS):
        if not open_.size:
            break
        value, slope = conserved(transform, wait, s[open_])
        step = value / slope
        step *= np.minimum(side / np.maximum(np.abs(step), 1e-300), 1.0)
        s[open_] -= step
        open_ = open_[np.abs(step) > LAST * np.abs(s[open_])]
        if s.size and (np.abs(s - start) > 3.0 * side).any():
            return None
    s = s[np.lexsort([s.real, s.imag])]
    # distance of roots, over their size, below which they are one
    if (np.abs(np.diff(s)) < 1e-7 * np.abs(s[1:])).any():
        return None
    return s[np.argsort(-s.real, kind="stable")]


def _highest(transform: Transform, wait: float, whole: float) -> float | None:
    """The frequency above which |p^| stays below 1 at Re s = -decay: no root is there.

    Exact values do not fade with the frequency, but may stay below 1. None where they do not.
    """
    decay = transform.decay
    growth = np.exp(decay * (transform.jumps.ways + wait))
    lasting = float(transform.jumps.shares @ growth)
    if not lasting < 1.0:
        return None
    step = SIDE / (transform.centre + wait)
    nodes = rule.GAUSS * transform.longest / WAVE
    # numbers of nodes times frequencies that are looked at, at most
    most = min(HIGHEST / whole, float(np.sqrt(1e8 * step / nodes)))
    end = min(max(HIGH / transform.grain, 10.0 * step), most)
    while True:
        frequency = step * np.arange(np.ceil(end / step) + 1.0)
        s = -decay + 1j * frequency
        law = 1.0 - s * transform.grid(np.array([-decay]), step, s.size)[:, 0]
        exact = np.exp(-np.multiply.outer(s, transform.jumps.ways)) @ transform.jumps.shares
        fading = np.abs(law - exact) * np.exp(decay * wait)
        above = np.flatnonzero(fading > BELOW * (1.0 - lasting))
        last = float(frequency[above[-1]]) if above.size else 0.0
        if last < 0.7 * end or end >= most:
            return last + 2.0 * step
        end = min(2.0 * end, most)
