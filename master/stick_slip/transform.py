"""Transform: integrals of e^(-sx) times what is left of contacts, over the way x since their birth."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.renewal import rule
from master.renewal.table import Table
from master.steady.travel import FEW, NONE, SHORTEST, Travel

Array = npt.NDArray[np.float64]
Complex = npt.NDArray[np.complex128]

# Most of |s| times the width of a piece: the Gauss nodes integrate a table's polynomial times such
# a wave to rounding.
WAVE = 4.0
# Relative rounding of a sum over nodes.
ROUND_OFF = 4e-16
# Ways just before and after an exact threshold, as shares of it.
SIDES = 1.0 - 1e-11, 1.0 + 1e-11
# Frequencies whose waves are made together.
BLOCK = 32


class Values(NamedTuple):
    """At numbers s, arrays of shape (n,), with E and K per contact born.

    held, slope, bend : transforms of E, of -x E and of x^2 E (lengths to the powers 1, 2, 3)
    force : transform of K (a length squared)
    held_off, force_off : their errors
    """

    held: Complex
    slope: Complex
    bend: Complex
    force: Complex
    held_off: Array
    force_off: Array


class Jumps(NamedTuple):
    """Ways (lengths) at which E jumps, and by how much; arrays of shape (n,)."""

    ways: Array
    shares: Array


def jumps_of(travel: Travel) -> Jumps:
    """Where contacts reach exact thresholds together, and how many break there."""
    ways = travel.atoms[(travel.atoms > 0.0) & (travel.atoms <= travel.longest)]
    if not ways.size:
        return Jumps(ways, ways)
    before, after = (travel.left(ways[:, None] * side)[0, :, 0] for side in SIDES)
    shares = np.maximum(before - after, 0.0)
    return Jumps(ways[shares > 0.0], shares[shares > 0.0])


class Reach(NamedTuple):
    """Edges of panels (lengths) out to where E e^(decay x) is nothing, and ln of its largest value
    there, or 0."""

    edges: Array
    log_most: float


def reach_of(travel: Travel, decay: float) -> Reach:
    """How far E e^(decay x) counts: the table of E, and on from there."""
    edges = travel.table.edges
    more, last = [edges], float(edges[-1])
    # doublings of the way beyond the table of Travel, at most
    for _ in range(40):
        left = float(travel.left(np.array([[last * (1.0 - 1e-12)]]))[0, 0, 0])
        if not left > 0.0 or np.log(left) + decay * last < np.log(NONE):
            break
        more.append(last * np.array([1.25, 1.5, 1.75, 2.0]))
        last *= 2.0
    edges = np.concatenate(more)
    held = np.maximum(travel.left(edges[:-1, None])[0, :, 0], np.finfo(float).tiny)
    return Reach(edges, max(float((np.log(held) + decay * edges[:-1]).max()), 0.0))


class _Nodes(NamedTuple):
    """Ways, weights, and weights times E, K and the error of both, times e^(decay x - shift)."""

    way: Array
    weight: Array
    off: Array
    held: Array
    force: Array


class Transform:
    """Transforms of E and K of contacts born at some stretches, for Re s >= -decay.

    Left of the imaginary axis the few that hold for long count: E e^(decay x) is tabulated, on the
    panels of a Travel and beyond, out to where it is nothing.

    Parameters
    ----------
    travel : Travel
    decay : float
        Per length, above 0 and below the rate at which E itself falls far out.
    blur : float
        Error of K, in units of the table's scale, where that is known by tables of its own.

    Attributes
    ----------
    jumps : Jumps
    grain, centre, longest : float
        Lengths: over which E falls, the mean way at a break weighted by e^(decay x), and the end.
    """

    def __init__(self, travel: Travel, decay: float, blur: float = 0.0) -> None:
        self.decay, self._scale = decay, travel.scale
        edges, self._shift = reach_of(travel, decay)
        self.longest, self._reach, self._blur = float(edges[-1]), travel.life.reach, blur

        def tilted(way: Array) -> Array:
            found = travel.left(way)
            found[1] /= self._scale
            return np.asarray(found * np.exp(np.minimum(decay * way - self._shift, 700.0)))

        shortest = SHORTEST * min(travel.typical, float(edges[1]))
        at_once = travel.born.is_single or travel.life.quick
        # last coefficients of the tilted tables, over their largest values; where heat breaks
        # contacts born at many stretches, those of Travel, as each survival takes long
        accuracy = 1e-13 if at_once else travel.accuracy
        self._table = table = Table(tilted, edges, accuracy, shortest)
        self._error = travel.life.error
        self._known: dict[int, _Nodes] = {}
        self.jumps = jumps_of(travel)
        begin, end = table.begin, table.end
        middle = 0.5 * (begin + end)
        growth = np.exp(np.clip(self._shift - decay * middle, -700.0, 700.0))
        lost = table(begin, middle)[0] - table(end, middle)[0] * np.exp(-decay * (end - begin))
        lost = np.maximum(lost * growth, 0.0) + 1e-300
        self.grain = float(table.widths @ lost / lost.sum())
        whole = table.integrals()[0]
        moment = table.moments()[0]
        weight = np.exp(-self._shift) + decay * whole
        self.centre = float((whole + decay * moment) / weight)

    def _nodes(self, fastest: float) -> _Nodes:
        """Nodes close enough for |s| up to `fastest`, and more."""
        power = max(int(np.ceil(np.log2(max(fastest * self._table.end[-1], 1.0)))), 0)
        if power not in self._known:
            table = self._table
            size = (2.0**power / table.end[-1] + self.decay) * table.widths
            pieces = np.maximum(np.ceil(size / WAVE), 1.0).astype(int)
            share = np.arange(pieces.sum()) - np.repeat(np.cumsum(pieces) - pieces, pieces)
            width = np.repeat(table.widths / pieces, pieces)
            low = np.repeat(table.begin, pieces) + share * width
            way = low[:, None] + width[:, None] * rule.GAUSS_NODES
            weight = width[:, None] * rule.GAUSS_WEIGHTS
            held, force = (table(way) * weight).reshape(2, -1)
            off = (weight * np.repeat(table.tails, pieces)[:, None]).ravel()
            nodes = _Nodes(way.ravel(), weight.ravel(), off, held, force * self._scale)
            self._known[power] = nodes
        return self._known[power]

    def __call__(self, s: Complex) -> Values:
        """The transforms at s (per length) of shape (n,)."""
        s = np.asarray(s, dtype=complex)
        nodes = self._nodes(float(np.abs(s).max(initial=0.0)))
        # numbers of nodes times numbers s that are summed together
        parts = np.array_split(s, max(1, s.size * nodes.way.size // 2_000_000))
        return Values(*(np.concatenate(row) for row in zip(*map(self._some, parts), strict=True)))

    def _some(self, s: Complex) -> Values:
        nodes = self._nodes(float(np.abs(s).max(initial=0.0)))
        way = nodes.way
        wave = np.exp(self._shift - np.multiply.outer(s + self.decay, way))
        size = np.abs(wave)
        held, force = np.abs(nodes.held), np.abs(nodes.force)
        # an error of E is one of its share where few hold
        holding = held / nodes.weight * np.exp(np.maximum(self._shift - self.decay * way, -700.0))
        own = self._error / np.maximum(holding, FEW) + ROUND_OFF
        rounding = ROUND_OFF * np.abs(s)[:, None] * way
        off = size @ (own * held) + ((size * rounding) @ held) + size @ nodes.off
        force_off = (
            size @ (own * force) + ((size * rounding) @ force) + self._scale * (size @ nodes.off)
        )
        wide = np.exp(np.minimum(self.decay * way - self._shift, 700.0)) * nodes.weight
        wide *= way <= self._reach
        force_off += self._blur * self._scale * (size @ wide)
        held_of, force_of = nodes.held.astype(complex), nodes.force.astype(complex)
        first, second = way * held_of, way**2 * held_of
        return Values(
            wave @ held_of, -(wave @ first), wave @ second, wave @ force_of, off, force_off
        )

    def grid(self, real: Array, step: float, count: int) -> Complex:
        """The transform of E at real + i step k for k < count, shape (count, real.size)."""
        corner = np.hypot(np.abs(real).max(), step * count)
        nodes = self._nodes(float(corner))
        exponent = self._shift - np.multiply.outer(nodes.way, real + self.decay)
        growth = nodes.held[:, None] * np.exp(exponent)
        # waves of many frequencies are products of few
        few = np.exp(-1j * step * np.multiply.outer(np.arange(BLOCK), nodes.way))
        out = np.empty((-(-count // BLOCK), BLOCK, real.size), dtype=complex)
        for block, rows in enumerate(out):
            wave = np.exp(-1j * (step * BLOCK * block) * nodes.way)
            rows[:] = few @ (wave[:, None] * growth)
        return out.reshape(-1, real.size)[:count]
