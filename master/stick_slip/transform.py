"""Transform: Laplace transforms of survival and force of contacts, over the way x since birth."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.renewal import rule
from master.renewal.table import Table
from master.steady.travel import FEW, SHORTEST, Travel

Array = npt.NDArray[np.float64]
Complex = npt.NDArray[np.complex128]

# Largest |s| times the width of a piece: the Gauss nodes integrate a table's polynomial times such a
# wave to rounding.
WAVE = 4.0
# Last coefficients of the table relative to its values on the panel; relative rounding of a sum.
ACCURACY, ROUND_OFF = 1e-13, 4e-16
# Values smaller than the share FALL of the panel's largest need not be resolved relatively; and last
# coefficients, in units of ACCURACY, that may be rounding of E itself.
FALL, NOISY = 1e-4, 1e2
# Share of contacts below which floating point underflows; and share of a sum that is left out.
NONE, UNFELT = 1e-290, 1e-20
# Frequencies whose waves are computed together.
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


class _Nodes(NamedTuple):
    """Ways, the panels' weights times E and K there, and the errors of both; arrays of shape (n,)."""

    way: Array
    held: Array
    force: Array
    held_off: Array
    force_off: Array


class Transform:
    """Transforms of E and K of contacts born at some stretches.

    Left of the imaginary axis the few contacts that hold for long matter: E is tabulated to a
    relative accuracy on each panel, until it underflows.

    Parameters
    ----------
    travel : Travel
        Of these contacts.
    blur : float
        Error of K, in units of the table's scale, where K itself comes from a table.

    Attributes
    ----------
    travel : Travel
        As given.
    """

    def __init__(self, travel: Travel, blur: float = 0.0) -> None:
        self.travel, life = travel, travel.life
        edges = travel.table.edges
        # at most 40 doublings of the way
        for _ in range(40):
            last = float(edges[-1])
            if not travel.left(np.array([[last * (1.0 - 1e-12)]]))[0, 0, 0] > NONE:
                break
            edges = np.append(edges, last * np.array([1.25, 1.5, 1.75, 2.0]))
        # with heat and many stretches at birth each survival takes long, so the table is coarser
        accuracy = ACCURACY if travel.born.is_single or life.quick else travel.accuracy

        def own(values: Array, _: Array) -> Array:
            held = np.abs(values[0])
            return np.maximum(held.min(axis=1), np.maximum(FALL * held.max(axis=1), NONE))

        shortest = SHORTEST * min(travel.typical, float(edges[1]))
        table = Table(travel.scaled, edges, accuracy, shortest, felt=own, rounding=NOISY)
        self._table = table
        self._blur, self._known = blur * (table.begin < life.reach), dict[int, _Nodes]()

    def _nodes(self, fastest: float, decay: float) -> _Nodes:
        """Nodes dense enough for |s| up to `fastest`, where E e^(decay x) is not negligible."""
        table, scale = self._table, self.travel.scale
        power = max(int(np.ceil(np.log2(max(fastest * table.end[-1], 1.0)))), 0)
        if power not in self._known:
            size = 2.0**power / table.end[-1] * table.widths
            pieces = np.maximum(np.ceil(size / WAVE), 1.0).astype(int)
            share = np.arange(pieces.sum()) - np.repeat(np.cumsum(pieces) - pieces, pieces)
            width = np.repeat(table.widths / pieces, pieces)
            low = np.repeat(table.begin, pieces) + share * width
            way = low[:, None] + width[:, None] * rule.GAUSS_NODES
            weight = width[:, None] * rule.GAUSS_WEIGHTS
            held, force = np.abs(values := table(way)) * weight
            # the error of E itself is relative where few contacts hold
            own = self.travel.life.error / np.maximum(values[0], FEW) + ROUND_OFF
            tails, blur = (np.repeat(part, pieces)[:, None] for part in (table.tails, self._blur))
            off = own * held + weight * tails, own * force + weight * (tails + blur)
            held, force = values * weight
            parts = way, held, force * scale, off[0], off[1] * scale
            some = values[0] > NONE
            self._known[power] = _Nodes(*(part[some] for part in parts))
        nodes = self._known[power]
        size = np.log(nodes.held) + decay * nodes.way
        return _Nodes(*(part[size > size.max() + np.log(UNFELT)] for part in nodes))

    def __call__(self, s: Complex) -> Values:
        """The transforms at s (per length) of shape (n,)."""
        s = np.asarray(s, dtype=complex)
        nodes = self._nodes(float(np.abs(s).max(initial=0.0)), -float(s.real.min(initial=0.0)))
        # at most 2,000,000 nodes times numbers s are summed together
        parts = np.array_split(s, max(1, s.size * nodes.way.size // 2_000_000))
        found = (self._some(nodes, part) for part in parts)
        return Values(*(np.concatenate(row) for row in zip(*found, strict=True)))

    def _some(self, nodes: _Nodes, s: Complex) -> Values:
        way = nodes.way
        with np.errstate(over="ignore", invalid="ignore"):
            wave: Complex = np.exp(-np.multiply.outer(s, way))
            size = np.abs(wave)
            turned = ROUND_OFF * np.abs(s)
            held_off = size @ nodes.held_off + turned * (size @ (way * nodes.held))
            force_off = size @ nodes.force_off + turned * (size @ np.abs(way * nodes.force))
            held, slope, bend = (
                np.asarray(wave @ (way**power * nodes.held), dtype=complex) for power in (0, 1, 2)
            )
            return Values(held, -slope, bend, wave @ nodes.force, held_off, force_off)

    def noise(self, decay: float) -> float:
        """Error of the transform of E at Re s = -decay (per length)."""
        nodes = self._nodes(0.0, decay)
        off = nodes.held_off + ROUND_OFF * decay * nodes.way * nodes.held
        with np.errstate(over="ignore", invalid="ignore"):
            return float(np.exp(decay * nodes.way) @ off)

    def grid(self, real: Array, step: float, count: int) -> Complex:
        """The transform of E at real + i step k for k < count, shape (count, real.size)."""
        nodes = self._nodes(float(np.hypot(real.min(), step * count)), -float(real.min()))
        growth = nodes.held[:, None] * np.exp(-np.multiply.outer(nodes.way, real))
        # waves of many frequencies are products of the waves of few
        few = np.exp(-1j * step * np.multiply.outer(np.arange(BLOCK), nodes.way))
        out = np.empty((-(-count // BLOCK), BLOCK, real.size), dtype=complex)
        for block, rows in enumerate(out):
            wave = np.exp(-1j * (step * BLOCK * block) * nodes.way)
            rows[:] = few @ (wave[:, None] * growth)
        return out.reshape(-1, real.size)[:count]

    def nodes_per_frequency(self) -> float:
        """Nodes of an integral per frequency (a length), where the frequency is high."""
        return float(rule.GAUSS * self._table.end[-1] / WAVE)
