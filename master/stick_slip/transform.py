"""Transform: Laplace transforms of number conservation over the way x since birth, which contacts
move steadily forward."""

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
# Frequencies whose waves are computed together.
BLOCK = 32
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
    """Ways of shape (n,), and there, times the weights of the nodes, E, -x E and K, shape (3, n);
    the errors of E and K and, to be multiplied by |s|, those by rounding of the way, shape (4, n)."""

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
    """

    def __init__(self, travel: Travel, wait: float, blur: float = 0.0) -> None:
        """Extend the table of E until hardly any contact holds, and sum up its panels."""
        self.travel, self.wait, life = travel, wait, travel.life
        edges = travel.table.edges
        # at most 40 doublings of the way
        for _ in range(40):
            last = float(edges[-1])
            if not travel.left(np.array([[last * (1.0 - 1e-12)]]))[0, 0, 0] > NONE:
                break
            edges = np.append(edges, last * np.array([1.25, 1.5, 1.75, 2.0]))
        # where each survival takes long (many stretches at birth, warm grains) the table is coarser
        short = life.quick or (travel.born.is_single and life.pair_work < 100)
        accuracy = 1e-13 if short else travel.accuracy

        def own(values: Array, _: Array) -> Array:
            """Relative to the panel's values, but for those 1e-4 times smaller than its largest."""
            held = np.abs(values[0])
            return np.maximum(held.min(axis=1), np.maximum(1e-4 * held.max(axis=1), NONE))

        shortest = SHORTEST * min(travel.typical, float(edges[1]))
        # last coefficients of 100 times the accuracy may be rounding of E itself
        self._table = Table(travel.scaled, edges, accuracy, shortest, felt=own, rounding=1e2)
        self._blur, self._known = blur, dict[int, _Nodes]()

    def _nodes(self, fastest: float, decay: float) -> _Nodes:
        """Nodes dense enough for |s| up to `fastest`, where E e^(decay x) is not negligible."""
        last = float(self._table.end[-1])
        power = max(int(np.ceil(np.log2(max(fastest * last, 1.0)))), 0)
        if power not in self._known:
            self._known[power] = self._on_pieces(WAVE * last / 2.0**power)
        nodes = self._known[power]
        size = np.log(nodes.sums[0]) + decay * nodes.way
        felt = size > size.max() + np.log(1e-20)
        return _Nodes(*(part[..., felt] for part in nodes))

    def _on_pieces(self, widest: float) -> _Nodes:
        """Gauss nodes on pieces of the table's panels that are no wider than a length."""
        table, scale = self._table, self.travel.scale
        pieces = np.maximum(np.ceil(table.widths / widest), 1.0).astype(int)
        cuts = (np.linspace(*span) for span in zip(table.begin, table.end, pieces + 1, strict=True))
        edges = np.append(np.concatenate([cut[:-1] for cut in cuts]), table.end[-1])
        width = np.diff(edges)[:, None]
        way, weight = edges[:-1, None] + width * rule.GAUSS_NODES, width * rule.GAUSS_WEIGHTS
        held, force = values = table(way)
        # the error of E itself is relative where few contacts hold
        own = np.abs(values) * (self.travel.life.error / np.maximum(held, FEW) + ROUND_OFF)
        own += np.repeat(table.tails, pieces)[:, None]
        own[1] += self._blur * (way < self.travel.life.reach)
        turned = ROUND_OFF * np.abs(way * values)
        some = held > NONE
        sums = np.stack([held, -way * held, scale * force])
        off = np.concatenate([own, turned])
        off[1::2] *= scale
        return _Nodes(way[some], (weight * sums)[:, some], (weight * off)[:, some])

    def __call__(self, s: Complex) -> Values:
        """The transforms at s (per length) of shape (n,)."""
        way, sums, off = self._nodes(
            float(np.abs(s).max(initial=0.0)), -float(s.real.min(initial=0.0))
        )
        found, wrong = np.empty((3, s.size), dtype=complex), np.empty((4, s.size))
        with np.errstate(over="ignore", invalid="ignore"):
            for i, one in enumerate(s):
                wave = np.exp(-one * way)
                found[:, i], wrong[:, i] = sums @ wave, off @ np.abs(wave)
            return Values(*found, *(wrong[:2] + np.abs(s) * wrong[2:]))

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
        # waves of many frequencies are products of the waves of few
        few = np.exp(-1j * step * np.multiply.outer(np.arange(BLOCK), way))
        first = np.exp(-1j * step * np.multiply.outer(np.arange(0, count, BLOCK), way))
        return np.concatenate([few @ (wave[:, None] * growth) for wave in first])[:count]

    def nodes_per_frequency(self) -> float:
        """Nodes of an integral per frequency (a length), where the frequency is high."""
        return float(rule.GAUSS * self._table.end[-1] / WAVE)
