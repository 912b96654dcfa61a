"""Transform: Laplace transforms of number conservation over the way x since birth, which contacts
move steadily forward (docs/equations.md), d being the travel in the delay:

    b^(s) D(s) = 1/s - G_0^(s),      D(s) = E^(s) e^(-sd) + (1 - e^(-sd))/s.
"""

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
# Relative rounding of a sum; and share of contacts below which floating point underflows.
ROUND_OFF, NONE = 4e-16, 1e-290


class Values(NamedTuple):
    """At numbers s, arrays of shape (n,), with E and K per contact born.

    held, slope : transforms of E and of -x E (lengths to the powers 1, 2)
    force : transform of K (a length squared)
    held_off, force_off : their errors
    """

    held: Complex
    slope: Complex
    force: Complex
    held_off: Array
    force_off: Array


class _Nodes(NamedTuple):
    """Ways of shape (n,), and there, times the weights of the nodes, E, -x E, K, -x K, shape (4, n),
    and the errors of E and K, shape (2, n)."""

    way: Array
    sums: Array
    off: Array


class Transform:
    """Transforms of E and K of contacts born at some stretches, and D of number conservation.

    Left of the imaginary axis the few contacts that hold for long matter: E is tabulated to a
    relative accuracy on each panel, until it underflows.

    Parameters
    ----------
    travel : Travel
        Of these contacts.
    wait : float
        d, the travel in the delay (a length).
    blur : float
        Error of K, in units of the table's scale, where K itself comes from a table.

    Attributes
    ----------
    travel, wait
        As given.
    nodes_per_frequency : float
        Nodes of an integral per frequency (a length), where the frequency is high.
    """

    def __init__(self, travel: Travel, wait: float, blur: float = 0.0) -> None:
        """Extend the table of E until hardly any contact holds."""
        self.travel, self.wait, self._blur, life = travel, wait, blur, travel.life
        edges = travel.table.edges
        for _ in range(40):  # doublings of the way
            last = float(edges[-1])
            if not travel.left(np.array([[last * (1.0 - 1e-12)]]))[0, 0, 0] > NONE:
                break
            edges = np.append(edges, last * np.array([1.25, 1.5, 1.75, 2.0]))
        # where each survival takes long (many stretches at birth, warm grains) the table is coarser
        short = life.quick or (travel.born.is_single and life.pair_work < 100)
        accuracy = 1e-13 if short else travel.accuracy

        def size_on_panel(values: Array, _: Array) -> Array:
            """Relative to the panel's values, but for those 1e-4 times smaller than its largest."""
            held = np.abs(values[0])
            return np.maximum(held.min(axis=1), np.maximum(1e-4 * held.max(axis=1), NONE))

        shortest = SHORTEST * min(travel.typical, float(edges[1]))
        # last coefficients of 100 times the accuracy may be rounding of E itself
        self._table = Table(
            travel.scaled, edges, accuracy, shortest, felt=size_on_panel, rounding=1e2
        )
        self.nodes_per_frequency = float(rule.GAUSS * self._table.end[-1] / WAVE)
        self._known = dict[int, _Nodes]()

    def _nodes(self, fastest: float, decay: float) -> _Nodes:
        """Nodes dense enough for |s| up to `fastest`, where E e^(decay x) is not negligible."""
        power = int(np.ceil(np.log2(max(fastest * self._table.end[-1], 1.0))))
        if power not in self._known:
            self._known[power] = self._on_pieces(WAVE * self._table.end[-1] / 2.0**power)
        nodes = self._known[power]
        size = np.log(nodes.sums[0]) + decay * nodes.way
        felt = size > size.max() + np.log(1e-20)
        return _Nodes(*(part[..., felt] for part in nodes))

    def _on_pieces(self, widest: float) -> _Nodes:
        """Gauss nodes on pieces of the table's panels that are no wider than a length."""
        table, scale, life = self._table, self.travel.scale, self.travel.life
        pieces = np.maximum(np.ceil(table.widths / widest), 1.0).astype(int)
        width = np.repeat(table.widths / pieces, pieces)[:, None]
        number = np.arange(width.size) - np.repeat(pieces.cumsum() - pieces, pieces)
        begin = np.repeat(table.begin, pieces)[:, None] + number[:, None] * width
        way, weight = begin + width * rule.GAUSS_NODES, width * rule.GAUSS_WEIGHTS
        held, force = values = table(way)
        # the error of E itself is relative where few contacts hold
        off = np.abs(values) * (life.error / np.maximum(held, FEW) + ROUND_OFF)
        off += np.repeat(table.tails, pieces)[:, None]
        off[1] += self._blur * (way < life.reach)
        some, sums = held > NONE, np.stack([held, -way * held, force * scale, -way * force * scale])
        off[1] *= scale
        return _Nodes(way[some], (weight * sums)[:, some], (weight * off)[:, some])

    def __call__(self, s: Complex) -> Values:
        """The transforms at s (per length) of shape (n,)."""
        decay = -float(s.real.min(initial=0.0))
        way, sums, off = self._nodes(float(np.abs(s).max(initial=0.0)), decay)
        found, wrong = np.empty((4, s.size), dtype=complex), np.empty((2, s.size))
        with np.errstate(over="ignore", invalid="ignore"):
            for i, number in enumerate(s):
                wave = np.exp(-number * way)
                size = np.abs(wave)
                found[:, i] = sums @ wave
                # a rounded way turns the wave
                turned = ROUND_OFF * np.abs(number) * (np.abs(sums[1::2]) @ size)
                wrong[:, i] = off @ size + turned
        return Values(*found[:3], *wrong)

    def conserved(self, s: Complex) -> tuple[Complex, Complex]:
        """D and D' at s of shape (n,), no s being 0."""
        values, wait = self(s), self.wait
        with np.errstate(over="ignore", invalid="ignore"):
            waited, out = np.exp(-s * wait), -np.expm1(-s * wait) / s
            slope = waited * (values.slope - wait * values.held) + (wait * waited - out) / s
            return values.held * waited + out, slope

    def root_errors(self, s: Complex) -> Array:
        """Errors of roots: the residual and the error of D, divided by |D'|."""
        value, slope = self.conserved(s)
        waited = np.abs(np.exp(-s * self.wait))
        off = self(s).held_off * waited
        off += np.finfo(float).eps * (1.0 + (1.0 + np.abs(s) * self.wait) * waited) / np.abs(s)
        return np.asarray((np.abs(value) + off) / np.abs(slope) + np.spacing(np.abs(s)))

    def grid(self, real: Array, step: float, count: int) -> Complex:
        """The transform of E at real + i step k for k < count, shape (count, real.size)."""
        way, sums, _ = self._nodes(float(np.hypot(real.min(), step * count)), -float(real.min()))
        growth = sums[0][:, None] * np.exp(-np.multiply.outer(way, real))
        # waves of many frequencies are products of those of 32 and of every 32nd
        few, first = (
            np.exp(-1j * step * np.multiply.outer(number, way))
            for number in (np.arange(32), np.arange(0, count, 32))
        )
        return np.concatenate([few @ (wave[:, None] * growth) for wave in first])[:count]
