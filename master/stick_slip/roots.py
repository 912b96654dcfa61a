"""Roots: the rates and frequencies with which F(X) decays to the kinetic force.

Number conservation of contacts that move steadily forward has a Laplace transform over the way x
since birth (docs/equations.md). With d the travel in the delay it is

    b^(s) D(s) = 1/s - G_0^(s),      D(s) = E^(s) e^(-sd) + (1 - e^(-sd))/s,

and F - F_k is a sum of e^(sX) over the roots of D. All lie left of the imaginary axis, none on the
real one. By the argument principle D turns once around 0 along the sides of a cell of a grid for each
root inside: Newton's method starts from these cells, and has to find as many roots.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.renewal import rule
from master.renewal.kernels import SHORTEST
from master.renewal.table import Table
from master.steady.travel import FEW, NONE, Travel, tail_rate
from origins import Contacts

Array = npt.NDArray[np.float64]
Complex = npt.NDArray[np.complex128]

# Largest |s| times the distance over which Gauss nodes are placed: they integrate a table's polynomial
# times such a wave to rounding.
WAVE = 8.0
# Relative rounding of a sum.
ROUND_OFF = 4e-16
# Roots are searched up to this share of the decay rate of E's tail, or of that of exact values.
NEAR = 0.9
# Ratio of the longest to the mean life beyond which the few longest ones cannot be resolved.
BROAD = 1e4


class Values(NamedTuple):
    """At numbers s, arrays of shape (n,), with E and K per contact born.

    held, held_slope, held_error : transform of E (a length), its slope by s (a length squared), its error
    force, force_error : transform of K (a length squared), and its error
    conserved, slope : D (a length), and dD/ds (a length squared)
    root_error : error of s (per length) where it is a root: the residual and the error of D over |dD/ds|
    """

    held: Complex
    held_slope: Complex
    held_error: Array
    force: Complex
    force_error: Array
    conserved: Complex
    slope: Complex
    root_error: Array


class _Nodes(NamedTuple):
    """Ways, shape (n,); times the nodes' weights E, -x E, K, shape (3, n), and errors of E, K, (2, n)."""

    way: Array
    sums: Array
    errors: Array


def _felt(held: Array, way: Array, decay: float) -> npt.NDArray[np.bool_]:
    """Where E e^(decay x) is not negligible."""
    size = np.where(held > NONE, np.log(np.maximum(held, NONE)) + decay * way, -np.inf)
    return np.asarray(size > size.max() + np.log(1e-20))


class Transform:
    """Transforms of E and K of contacts born at some stretches, and D of number conservation.

    Left of the imaginary axis the few contacts that hold for long matter: E is tabulated to a
    relative accuracy on each panel, until it underflows or no wave grows as fast as it falls.
    """

    def __init__(self, travel: Travel, wait: float, deepest: float, k_error: float = 0.0) -> None:
        """Extend the table of E until hardly any contact holds.

        travel, wait : of these contacts, and d (a length)
        deepest : the fastest decay of a wave, -Re s (per length)
        k_error : of K, in units of the table's scale, where K itself comes from a table
        """
        self.travel, self.wait, self._k_error, life = travel, wait, k_error, travel.life
        self.deepest, edges = deepest, travel.table.edges
        for _ in range(40):  # doublings of the way
            edges = np.append(edges[:-1], np.linspace(edges[-2], edges[-1], 17)[1:])
            held = travel.scaled(edges[:, None] * (1.0 - 1e-12))[0, :, 0]
            felt = _felt(held, edges, 1.1 * deepest)  # Newton's method looks a little further
            if not felt[-1]:
                break
            edges = np.append(edges, 2.0 * edges[-1])
        edges = edges[: np.flatnonzero(felt)[-1] + 2]
        # where each survival takes long (many stretches at birth, warm grains) the table is coarser
        short = life.quick or (travel.born.is_single and life.pair_work < 100)
        accuracy = 1e-13 if short else max(travel.accuracy, 1e-9)

        def size_on_panel(values: Array, _: Array) -> Array:
            """Relative to the panel's values, but for those 1e-4 times its largest, or known no better."""
            held = np.abs(values[0])
            held = np.maximum(held.min(axis=1), np.maximum(1e-4 * held.max(axis=1), NONE))
            known = held * life.error / np.maximum(held, FEW) + life.left_out
            return np.asarray(np.maximum(held, known / accuracy))

        shortest = SHORTEST * min(travel.typical, float(edges[1]))
        # last coefficients of 100 times the accuracy may be rounding of E itself
        self.table = Table(
            travel.scaled, edges, accuracy, shortest, felt=size_on_panel, rounding=1e2
        )

    def _nodes(self, fastest: float, decay: float, size: int = rule.GAUSS) -> _Nodes:
        """Gauss nodes, `size` at least on each panel where E e^(decay x) is not negligible, dense enough
        for |s| up to `fastest`; 8 are good to 1e-8."""
        table, scale, life = self.table, self.travel.scale, self.travel.life
        felt = _felt(table(table.begin)[0], table.end, decay)
        pieces = np.maximum(np.ceil(table.widths * fastest / WAVE), 1.0)[felt].astype(int)
        width = np.repeat(table.widths[felt] / pieces, pieces)[:, None]
        number = np.arange(width.size) - np.repeat(pieces.cumsum() - pieces, pieces)
        begin = np.repeat(table.begin[felt], pieces)[:, None] + number[:, None] * width
        way = begin + width * rule.gauss(size).nodes
        weight = width * rule.gauss(size).series[:, 0]
        held, force = values = table(way)
        # where few contacts hold, the error of E is relative to their share, but for those left out
        errors = np.abs(values) * (life.error / np.maximum(held, FEW) + ROUND_OFF)
        errors += life.left_out * np.stack([np.ones(way.shape), way / scale])
        errors += np.repeat(table.tails[felt], pieces)[:, None]
        errors[1] = (errors[1] + self._k_error * (way < life.reach)) * scale
        some, sums = held > NONE, np.stack([held, -way * held, force * scale])
        return _Nodes(way[some], (weight * sums)[:, some], (weight * errors)[:, some])

    def __call__(self, s: Complex) -> Values:
        """The transforms at s (per length) of shape (n,), none of which is 0."""
        decay = -float(s.real.min(initial=0.0))
        way, sums, errors = self._nodes(float(np.abs(s).max(initial=0.0)), decay)
        transforms, off = np.empty((3, s.size), dtype=complex), np.empty((2, s.size))
        with np.errstate(over="ignore", invalid="ignore"):
            for i, number in enumerate(s):
                wave = np.exp(-number * way)
                transforms[:, i] = sums @ wave
                # a rounded way turns the wave
                off[:, i] = (errors + ROUND_OFF * abs(number) * way * np.abs(sums[::2])) @ abs(wave)
            held, held_slope, force = transforms
            waited, out = np.exp(-s * self.wait), -np.expm1(-s * self.wait) / s
            conserved = held * waited + out
            slope = waited * (held_slope - self.wait * held) + (self.wait * waited - out) / s
            rounded = 1.0 + (1.0 + np.abs(s) * self.wait) * np.abs(waited)
            error = off[0] * np.abs(waited) + np.finfo(float).eps * rounded / np.abs(s)
            root_error = (np.abs(conserved) + error) / np.abs(slope) + np.spacing(np.abs(s))
        return Values(held, held_slope, off[0], force, off[1], conserved, slope, root_error)

    def held_on_grid(self, real: Array, step: float, count: int) -> Complex:
        """The transform of E at real + i step k for k < count, shape (count, real.size)."""
        fastest, decay = float(np.hypot(real.min(), step * count)), -float(real.min())
        way, sums, _ = self._nodes(fastest, decay, 8)
        growth = sums[0][:, None] * np.exp(-np.multiply.outer(way, real))
        # waves of many frequencies are products of those of 32 and of every 32nd
        few, first = (
            np.exp(-1j * step * np.multiply.outer(number, way))
            for number in (np.arange(32), np.arange(0, count, 32))
        )
        return np.concatenate([few @ (wave[:, None] * growth) for wave in first])[:count]


def crowding_rate(travel: Travel, wait: float) -> float:
    """Decay rate (per length) near which infinitely many roots of ever higher frequency crowd, due to
    exact thresholds; inf without any, 0 where all contacts break at exact thresholds."""
    ways = travel.atoms[(travel.atoms > 0.0) & (travel.atoms <= travel.longest)]
    # the share that breaks at each is that just before less that just after it
    before, after = (
        travel.scaled(ways[:, None] * side)[0, :, 0] for side in (1 - 1e-11, 1 + 1e-11)
    )
    ways, shares = ways[before > after] + wait, (before - after)[before > after]
    if not ways.size:
        return np.inf
    if shares.sum() > 1.0 - 1e-14:
        return 0.0
    from scipy.optimize import brentq  # takes 0.1 s, which few laws need

    logs = np.log(shares)
    ends = 0.0, -float(logs.max()) / float(ways.min())
    return float(brentq(lambda rate: np.logaddexp.reduce(rate * ways + logs), *ends, xtol=1e-300))


def decoherence_length(contacts: Contacts, travel: Travel, wait: float) -> tuple[float, float]:
    """X* of the slowest term e^(-X/X*), and its error; inf where nothing decays exponentially.

    It is inf for exact values alone (F is periodic or nearly so), and for a tail that falls slower
    than any exponential. Where a few contacts live more than 10,000 times as long as the mean, the
    error is inf. Where exact values have a share of the weight, roots slower than the rate at which
    infinitely many crowd may not exist, and X* is that of this rate.
    """
    rate, off = min(tail_rate(contacts), (crowding_rate(travel, wait), 0.0))
    if rate == 0.0:
        return np.inf, 0.0
    if travel.longest > BROAD * travel.length:
        # X* depends on the few contacts that live longest, which the table of E does not resolve
        return travel.longest, np.inf
    transform = Transform(travel, wait, deepest_wave(travel, wait, rate))
    roots, searched = leading_roots(transform, 1)
    if roots.size:
        decay, error = -float(roots[0].real), float(transform(roots[:1]).root_error[0])
        # with a very long delay the decay may be smaller than its rounding error
        return (1.0 / decay, error / decay**2) if error < decay else (1.0 / error, np.inf)
    if searched > 0.95 * NEAR * rate:  # an undetected root may lie from there to the rate
        return 1.0 / rate, (off + rate - searched) / rate**2
    return 0.5 / searched, 0.5 / searched


def deepest_wave(travel: Travel, wait: float, rate: float) -> float:
    """Decay rate to which roots are searched (per length): deeper waves vanish within a mean life."""
    return min(NEAR * rate, 40.0 / (travel.length + wait))


def leading_roots(transform: Transform, count: int) -> tuple[Complex, float]:
    """All roots of D with Im s > 0 right of some Re s = -searched, slowest first, and `searched` (per
    length): at least `count`, or as deep as the transform; fewer where D is too inaccurate there."""

    def blurred(decay: float) -> float:
        """The error of D over its terms."""
        error = float(transform(np.array([complex(-decay)])).held_error[0])
        return error * decay * np.exp(min(decay * transform.wait, 700.0))

    deepest = transform.deepest
    while not blurred(deepest) < 1e-3:
        deepest *= 0.9
    decay = min(0.5 / (transform.travel.length + transform.wait), deepest)
    while True:
        roots, searched = _roots_to(transform, decay)
        if roots.size >= count or decay >= deepest:
            return roots, searched
        decay = min(2.0 * decay, deepest)


def _roots_to(transform: Transform, decay: float) -> tuple[Complex, float]:
    """`leading_roots` right of Re s = -decay, or of where one was missed."""
    # the mean way from birth to break, weighted by e^(decay x)
    end = transform(np.array([complex(-decay)]))
    centre = float(((end.held - decay * end.held_slope) / (1.0 + decay * end.held)).real[0])
    step = 0.8 / (centre + transform.wait)  # sides of the grid's cells
    # roots nearer to the left side may count as outside, as the sides of cells are taken straight
    left = decay + min(0.4 * step, 0.05 * decay)
    s, values = _grid(transform, left, step)
    across = np.angle(values[:, 1:] / values[:, :-1])
    along = np.angle(values[1:] / values[:-1])
    turned = across[:-1] + along[:, 1:] - across[1:] - along[:, :-1]
    begins = (0.5 * (s[:-1, :-1] + s[1:, 1:]))[turned > np.pi]
    size = float(abs(s[1, 1] - s[0, 0]))
    ends, last, moving = begins.copy(), np.zeros(begins.size), np.arange(begins.size)
    for _ in range(40):  # steps of Newton's method, none longer than a cell
        if not moving.size:
            break
        found = transform(ends[moving])
        with np.errstate(invalid="ignore"):
            move = np.nan_to_num(found.conserved / found.slope, nan=size, posinf=size, neginf=size)
        move *= np.minimum(size / np.maximum(np.abs(move), 1e-300), 1.0)
        ends[moving] -= move
        last[moving] = np.abs(move)
        near = np.abs(ends[moving] - begins[moving]) < 3.0 * size
        moving = moving[near & (np.abs(move) > 1e-13 * np.abs(ends[moving]))]
    # each cell must have a root of its own
    near = (np.abs(ends - begins) < 2.0 * size) & (last < 1e-7 * np.abs(ends))
    same = np.abs(np.subtract.outer(ends, ends)) <= 1e-7 * np.abs(ends)
    near &= ~np.tril(same & near, -1).any(axis=1)
    missed = float(begins[~near].real.max(initial=-np.inf)) + size
    searched = max(-max(0.4 * step - left, missed), 1e-3 * decay)
    roots = ends[near & (ends.real > -searched)]
    return roots[np.argsort(-roots.real, kind="stable")], searched


def _grid(transform: Transform, decay: float, step: float) -> tuple[Complex, Complex]:
    """Numbers s up to the frequency above which |p^| stays below 1 at the first Re s, and D there."""
    travel, wait = transform.travel, transform.wait
    # at most 16 columns, wider ones where they are few
    real = np.linspace(-decay, step, int(min(np.ceil(decay / step), 16)) + 2)
    # at most 1e8 frequencies times nodes of an integral, and at most 2,000 per mean way
    nodes = 8 / WAVE * transform.table.end[-1]  # of an integral, per frequency
    highest = min(2e3 / (travel.length + wait), float(np.sqrt(1e8 * step / nodes)))
    end = min(max(8.0 / travel.grain, 30.0 * step), highest)
    while True:
        count = int(np.ceil(end / step)) + 2
        held = transform.held_on_grid(real, step, count)
        s = real + 1j * step * np.arange(count)[:, None]
        s[s == 0.0] = 1e-6 * step
        broken = np.abs(1.0 - s[:, 0] * held[:, 0]) * np.exp(decay * wait)
        last = int(np.flatnonzero(np.append(1.0, broken[1:] > 0.8))[-1])  # no root is beyond it
        if last * step < 0.7 * end or end >= highest:
            s, held = s[: last + 30], held[: last + 30]
            return s, held * np.exp(-s * wait) - np.expm1(-s * wait) / s
        end = min(2.0 * end, highest)
