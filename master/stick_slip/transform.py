"""Transforms of E and K of a steady cycle over the distance since birth, and D of number conservation: see roots."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import scipy

from master.numerics import polynomials
from master.numerics.table import SIZE, Table
from master.renewal.straight import NARROWEST_PANEL
from master.steady.cycle import UNDERFLOW, Cycle
from master.survival.life import TIE
from origins.thresholds.law import Array

Complex = npt.NDArray[np.complex128]

# Largest |s| times the distance that SIZE Gauss nodes share: they integrate a table's polynomial times e^(-sx) to
# rounding.
WAVE = 4.0
# The same on a line, where 1e-8 will do.
ON_LINE_SIZE, ON_LINE_WAVE = 8, 8.0
# Share of the contacts so small that no measurement could find one: their survival counts as unknown.
NOBODY = 1e-120
# Parts of the largest integrand below which it adds nothing: below rounding, however many panels they are.
NOT_FELT = 1e-20
# Parts of the last panel that are looked at to find where E is no more felt, and how often.
PARTS, LOOKS = 16, 2
# Most doublings of the distance to which E is tabulated: to 1e12 times that of the cycle's table.
MOST_DOUBLINGS = 40
# Numbers of waves at nodes that are found together, few enough for the processor's cache.
TOGETHER = 20_000
# Last coefficients of the table of E where each survival is quick, and the least where it takes long; and the part of a
# panel's largest value up to which values are known to that accuracy of their own size.
OF_TABLE, OF_SLOW_TABLE, OF_LARGEST = 1e-13, 1e-9, 1e-4
# Work of a survival (Life.pair_work) from which on it takes long.
SLOW = 100
# Relative rounding of a sum.
SUM_ROUNDING = 4e-16
# Rounding of the tables of E and K, in their largest values: where E is within it of 1, and K of a line, all contacts
# hold. And so many terms of a series below |u| = 1 are its sum to rounding.
TABLE_ROUNDED, TERMS = 4e-15, 18


class Values(NamedTuple):
    """The transforms of E, K and D at numbers s, per contact born, with their errors; arrays of shape (n,)."""

    survival: Complex  # of E, a length
    survival_error: Array
    force: Complex  # of K, a length squared
    force_error: Array
    conserved: Complex  # D, a length
    conserved_error: Array
    slope: Complex  # dD/ds, a length squared

    def root_error(self) -> Array:
        """Error of s (per length) where s is a root: the residual and the error of D, divided by |dD/ds|."""
        return (np.abs(self.conserved) + self.conserved_error) / np.abs(self.slope)


class _Nodes(NamedTuple):
    """Ways on which some contacts break, shape (n,); E, -x E and K times the nodes' weights, shape (3, n); errors of E
    and K, shape (2, n)."""

    distance: Array
    sums: Array
    errors: Array


class _AllHold(NamedTuple):
    """The way (a length) from birth on which all contacts hold: E = 1 and K = `begin` + `slope` x, to the errors (2,).
    Of narrow thresholds it is nearly all; waves of high frequency would need thousands of nodes there."""

    way: float
    begin: float
    slope: float
    errors: Array

    def transforms(self, s: Complex) -> Complex:
        """Those of E, -x E and K over this way at s, shape (3, n)."""
        u = s * self.way
        small = np.abs(u) < 1.0  # where the difference would lose digits
        far = np.where(small, 1.0, u)
        once = np.where(u == 0.0, 1.0, -np.expm1(-u) / np.where(u == 0.0, 1.0, u)) * self.way
        twice = (1.0 - (1.0 + far) * np.exp(-far)) / far**2
        if small.any():
            n = np.arange(TERMS)
            each = 1.0 / (scipy.special.factorial(n) * (n + 2.0))
            twice[small] = np.vander(-u[small], TERMS, increasing=True) @ each
        twice *= self.way**2
        return np.stack([once, -twice, self.begin * once + self.slope * twice])

    def off(self, s: Complex) -> Array:
        """Errors of the transforms of E and K over this way, shape (2, n); a rounded distance turns the wave."""
        grows = np.exp(np.maximum(-s.real * self.way, 0.0))
        rounded = 2.0 * SUM_ROUNDING * self.way
        borne = max(abs(self.begin), abs(self.begin + self.slope * self.way))
        return np.multiply.outer(self.errors * self.way + rounded * np.array([1.0, borne]), grows)


def _count_felt(survival: Array, distance: Array, decay: float) -> int:
    """How many values of E, at sorted x, to the last where E e^(decay x) is not negligible."""
    size = np.where(
        survival > UNDERFLOW, np.log(np.maximum(survival, UNDERFLOW)) + decay * distance, -np.inf
    )
    return int(np.flatnonzero(size > size.max() + np.log(NOT_FELT))[-1]) + 1


def _in_parts(edges: Array) -> Array:
    """The edges, with the last panel in PARTS."""
    return np.append(edges[:-1], np.linspace(edges[-2], edges[-1], PARTS + 1)[1:])


class Transform:
    """Transforms of E and K of contacts born at some stretches, and D of number conservation.

    Left of the imaginary axis the few contacts that hold for long matter: E is tabulated to a
    relative accuracy on each panel, until it underflows or no wave grows as fast as it falls.
    """

    def __init__(self, cycle: Cycle, deepest: float) -> None:
        """Extend the table of E until hardly any contact holds; deepest: the fastest decay of a wave (per length)."""
        self.cycle, self.deepest = cycle, deepest
        life, edges = cycle.life, cycle.table.edges
        for _ in range(MOST_DOUBLINGS):
            # the last panel, which was doubled
            edges = _in_parts(edges)
            if (felt := self._count_felt_edges(edges)) < edges.size:
                break
            edges = np.append(edges, 2.0 * edges[-1])
        edges = edges[: felt + 1]
        # the tail of narrow thresholds is far shorter than these parts, and thousands of panels would follow it
        for _ in range(LOOKS):
            edges = _in_parts(edges)
            edges = edges[: self._count_felt_edges(edges) + 1]
        # where each survival takes long (many stretches at birth, warm grains) the table is coarser
        short = life.quick or (cycle.born.is_single and life.pair_work < SLOW)
        accuracy = OF_TABLE if short else max(cycle.accuracy, OF_SLOW_TABLE)

        self._survival_error = cycle.survival_error

        def for_table(distance: Array) -> Array:
            found = cycle.scaled(distance)
            self._survival_error = max(self._survival_error, found.error)
            return found.both

        def sizes(values: Array, _: Array) -> Array:
            """Relative to the panel's values, but for those below OF_LARGEST of its largest, or known no better."""
            survival = np.abs(values[0])
            survival = np.maximum(
                survival.min(axis=1), np.maximum(OF_LARGEST * survival.max(axis=1), UNDERFLOW)
            )
            error = life.error_at(survival, self._survival_error)
            return np.maximum(survival, np.stack([error, error + life.error_of_force]) / accuracy)

        shortest = NARROWEST_PANEL * min(cycle.typical, float(edges[1]))
        # last coefficients of 100 times the accuracy may be rounding of E itself
        self.table = Table(for_table, edges, accuracy, shortest, looser=sizes, rounding=1e2)
        self._first, self._all_hold = self._held()

    def _count_felt_edges(self, edges: Array) -> int:
        """As `_count_felt`, of E at edges, each from its left, as E may jump there."""
        survival = self.cycle.scaled(edges[:, None] * (1.0 - TIE)).survival[:, 0]
        return _count_felt(survival, edges, 1.1 * self.deepest)  # Newton's method looks further

    def _held(self) -> tuple[int, _AllHold]:
        """The first panel on which contacts break, and the way before."""
        table, life, scale = self.table, self.cycle.life, self.cycle.scale
        whole = table.lines(TABLE_ROUNDED) & table.near(0, 1.0, TABLE_ROUNDED)
        first = int(np.argmin(np.append(whole, False)))
        way = float(table.edges[first])
        # far enough apart to tell the line, and off the ends of panels
        places = np.array([0.1, 0.9]) * way
        low, high = (table(places)[1] * scale).tolist()
        slope = (high - low) / (places[1] - places[0]) if way else 0.0
        error = float(life.error_at(np.ones(1), self._survival_error)[0])
        tails = table.tails[:, :first].max(axis=1, initial=0.0)
        errors = (error + tails) * np.array([1.0, scale]) + np.array(
            [0.0, life.error_of_force * scale]
        )
        return first, _AllHold(way, low - slope * places[0], slope, errors)

    def nodes(self, fastest: float, decay: float, size: int = SIZE, wave: float = WAVE) -> _Nodes:
        """Gauss nodes: at least `size` on each panel where contacts break and E e^(decay x) is not negligible, and on
        each distance of wave/fastest, `fastest` the largest |s|."""
        table, scale, life = self.table, self.cycle.scale, self.cycle.life
        first = self._first
        felt = max(_count_felt(table(table.begin)[0], table.end, decay), first)
        pieces = np.maximum(np.ceil(table.widths[first:felt] * fastest / wave), 1.0).astype(int)
        numbers, ends = np.append(0, pieces.cumsum()), table.edges[first : felt + 1]
        edges = np.interp(np.arange(numbers[-1] + 1), numbers, ends)[:, None]
        distance = edges[:-1] + np.diff(edges, axis=0) * polynomials.gauss(size).nodes
        weight = np.diff(edges, axis=0) * polynomials.gauss(size).series[:, 0]
        survival, force = values = table(distance)
        # a contact that holds though it should not, or the other way round, bears the force of the others there
        by_one = np.divide(
            np.abs(force), survival, out=np.zeros_like(survival), where=survival > UNDERFLOW
        )
        wrong = life.error_at(survival, self._survival_error)
        errors = wrong * np.stack([np.ones(distance.shape), np.maximum(by_one, distance / scale)])
        # shares below NOBODY are of contacts that nobody has: no wave may hang on them
        errors += np.abs(values) * np.where(survival < NOBODY, 1.0, SUM_ROUNDING)
        errors += np.repeat(table.tails[:, first:felt], pieces, axis=1)[..., None]
        errors[1] = (errors[1] + life.error_of_force * (distance < life.largest_stretch)) * scale
        some, sums = survival > UNDERFLOW, np.stack([survival, -distance * survival, force * scale])
        return _Nodes(distance[some], (weight * sums)[:, some], (weight * errors)[:, some])

    def __call__(self, s: Complex, nodes: _Nodes | None = None) -> Values:
        """The transforms at s (per length) of shape (n,), none of which is 0; nodes are for all s near."""
        if nodes is None:
            nodes = self.nodes(np.abs(s).max(initial=0.0), -s.real.min(initial=0.0))
        wait, (distance, sums, errors) = self.cycle.wait, nodes
        rounded = distance * np.abs(sums[::2])  # a rounded distance turns the wave
        transforms, off = np.empty((3, s.size), dtype=complex), np.empty((2, s.size))
        together = max(TOGETHER // max(distance.size, 1), 1)
        with np.errstate(over="ignore", invalid="ignore"):
            for some in (slice(i, i + together) for i in range(0, s.size, together)):
                wave = np.exp(np.multiply.outer(distance, -s[some]))
                transforms[:, some], size = sums @ wave, np.abs(wave)
                off[:, some] = errors @ size + SUM_ROUNDING * np.abs(s[some]) * (rounded @ size)
            transforms += self._all_hold.transforms(s)
            off += self._all_hold.off(s)
            survival, survival_slope, force = transforms
            waited, out = np.exp(-s * wait), -np.expm1(-s * wait) / s
            conserved = survival * waited + out
            slope = waited * (survival_slope - wait * survival) + (wait * waited - out) / s
            cancelled = 1.0 + (1.0 + np.abs(s) * wait) * np.abs(waited)
            error = off[0] * np.abs(waited) + np.finfo(float).eps * cancelled / np.abs(s)
        return Values(survival, off[0], force, off[1], conserved, error, slope)

    def survival_on_line(self, decay: float, step: float, count: int) -> Complex:
        """The transform of E at -decay + i step k for k < count, to 1e-8."""
        fastest = float(np.hypot(decay, step * count))
        distance, sums, _ = self.nodes(fastest, decay, ON_LINE_SIZE, ON_LINE_WAVE)
        # waves of many frequencies are products of those of a few, and of every few
        few = int(np.ceil(np.sqrt(count)))
        turns = (np.exp(-1j * step * apart * distance) for apart in (1, few))
        each, coarse = (np.vander(turn, few, increasing=True) for turn in turns)
        found = (coarse.T * (sums[0] * np.exp(decay * distance)) @ each).ravel()[:count]
        line = np.asarray(-decay + 1j * step * np.arange(count), dtype=np.complex128)
        return np.asarray(found + self._all_hold.transforms(line)[0])
