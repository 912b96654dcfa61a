"""All roots s != 0 of p^(s) = 1 to the right of a line: counted by the argument principle, so that none is missed.

In Re s > 0 is |p^| < 1. The change of arg(1 - p^) along Re s = -γ therefore counts the roots to its right: s = 0 and
pairs. The lines come from transforms of e^{γx} p(x) on a lattice, the roots from Newton's method on panels.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.fft import next_fast_len, rfft

from master._old.decoherence import MOST_NODES, newton, wave_nodes
from master._old.lattice import deposit_atoms, lay
from master._old.problem import Problem

Array = npt.NDArray[np.float64]
Complex = npt.NDArray[np.complex128]

_PER_WIDTH = 8.0
_PADDING = 8
_SEEN = 1.25  # angle from node to node up to which the lattice's transform is right
_DROWNED = 1e12  # p^(-γ) whose rounding leaves no digits of p^ = 1
_BELOW = 0.6  # of what exact values leave below |p^| = 1: with less above all frequencies looked at, no root is there
_SURE = 1.5  # change of the argument from one frequency to the next that is believed
_HALVINGS = 45
_ASIDE = 1.02
_DEEP = 0.9
_FIRST, _GROWTH = 0.05, 1.5
_LINES = (3, 6, 12, 24, 48)
_SAME, _THERE = 1e-7, 1e-3


class Lines:
    """Transforms along Re s = -γ of p, of r_f, of r_k where stiffnesses differ and of b_0, units of the problem.

    `edges` are panels of p out to where e^{γx} p is nothing for all γ asked for; `highest` is a frequency up to which
    the lattice is right, or as far as a quarter of a million nodes allow.
    """

    def __init__(self, problem: Problem, edges: Array, highest: float) -> None:
        law, first, release = problem.law, problem.first, problem.release
        ends = np.concatenate([edges[-1:], law.atoms, first.density.edges[-1:], first.atoms])
        top = float(ends.max())
        self._problem, self._edges = problem, edges
        self._step = step = max(min(law.narrowest / _PER_WIDTH, _SEEN / highest), top / MOST_NODES)
        size = int(np.ceil(top / step)) + 16

        def thresholds(x: Array) -> list[Array]:
            density = law.pdf(x)
            return [density, *release.densities(x, density)]

        rows = lay(thresholds, 3 if release.stiffness else 2, edges, step, size)
        rows[0] += deposit_atoms(law.atoms, law.atom_weights, step, size)
        rows[1] += deposit_atoms(law.atoms, law.atom_weights * release.force_at(law.atoms), step, size)
        if release.stiffness:
            rows[2] += deposit_atoms(law.atoms, law.atom_weights * release.stiffness_at(law.atoms), step, size)
        starting = lay(lambda x: [first.density(x)], 1, first.density.edges, step, size)
        starting[0] += deposit_atoms(first.atoms, first.atom_weights, step, size)
        self._rows = np.concatenate([rows, starting])
        self._atoms = deposit_atoms(law.atoms, law.atom_weights, step, size)
        self._x = step * np.arange(size)
        self._length = next_fast_len(_PADDING * size, real=True)
        frequency = 2.0 * np.pi * np.arange(self._length // 2 + 1) / (self._length * step)
        self.frequency = frequency[frequency * step <= _SEEN]

    def rows(self, decay: float) -> Complex:
        """All transforms at s = -decay + i frequency, shape (rows, n)."""
        return np.stack([self._along(row, decay) for row in self._rows])

    def at(self, decay: float, frequency: Array) -> Complex:
        """The same at other frequencies, of shape (m,): shape (rows, m)."""
        grown = self._rows * np.exp(np.minimum(decay * self._x, 700.0))
        return np.stack([grown @ np.exp(-1j * value * self._x) for value in frequency], axis=1)

    def law(self, decay: float) -> tuple[Complex, Complex]:
        """p^ and the transform of x p, up to the frequency above which no root lies."""
        transform = self._along(self._rows[0], decay)
        end = self._highest(transform, decay)
        return transform[:end], self._along(self._rows[0] * self._x, decay)[:end]

    def _along(self, row: Array, decay: float) -> Complex:
        # where a row is nothing a growth beyond all numbers is nothing too
        grown = row * np.exp(np.minimum(decay * self._x, 700.0))
        return np.asarray(rfft(grown, self._length)[: self.frequency.size])

    def _highest(self, transform: Complex, decay: float) -> int:
        """Number of frequencies above which |p^| stays well below 1 at Re s = -decay: no root is there."""
        law = self._problem.law
        # exact values alone do not fade with the frequency, but may stay below 1
        lasting = float(law.atom_weights @ np.exp(decay * law.atoms))
        fading = np.abs(transform - self._along(self._atoms, decay))
        above = np.flatnonzero(fading > _BELOW * (1.0 - lasting))
        return int(above[-1]) + 2 if above.size else 2

    def pairs(self, decay: float) -> int | None:
        """How many pairs of roots lie right of Re s = -decay; None where one lies on it, or the lattice cannot tell."""
        transform = self._along(self._rows[0], decay)
        highest = self._highest(transform, decay)
        apart = 1.0 - transform[:highest]
        if abs(apart[0]) > _DROWNED or highest > 0.75 * transform.size:
            return None
        near = np.flatnonzero(np.abs(np.angle(apart[1:] / apart[:-1])) > _SURE)
        ends = np.unique(np.append(near, near + 1))
        if ends.size:
            nodes, log_mass = wave_nodes(self._problem.law, self._edges, float(self.frequency[ends[-1]]))
            tilted = np.exp(log_mass + decay * nodes)

            def exact(frequency: Array) -> Complex:
                return 1.0 - np.exp(-1j * frequency[:, None] * nodes) @ tilted

            apart[ends] = exact(self.frequency[ends])
        turn = np.angle(apart[1:] / apart[:-1])
        near = np.flatnonzero(np.abs(turn) > _SURE)
        total = float(turn.sum() - turn[near].sum())
        left, right, begin, end = self.frequency[near], self.frequency[near + 1], apart[near], apart[near + 1]
        for _ in range(_HALVINGS):
            if not left.size:
                # from beyond s = 0 to where p^ is little
                return round((float(np.angle(apart[-1])) - total) / (2.0 * np.pi) - 0.5)
            middle = 0.5 * (left + right)
            value = exact(middle)
            left, right = np.append(left, middle), np.append(middle, right)
            begin, end = np.append(begin, value), np.append(value, end)
            turn = np.angle(end / begin)
            near = np.flatnonzero(np.abs(turn) > _SURE)
            total += float(turn.sum() - turn[near].sum())
            left, right, begin, end = left[near], right[near], begin[near], end[near]
        return None


@dataclass(frozen=True)
class Roots:
    """`roots` with Im > 0, slowest first: all that lie right of Re s = -`searched`."""

    roots: Complex
    searched: float


def leading_roots(problem: Problem, edges: Array, lines: Lines, count: int, limit: float) -> Roots:
    """At least `count` of them, or all right of Re s = -limit; fewer where the lattice does not resolve more."""
    found: list[complex] = []
    searched, level = 0.0, _first_level(lines)
    while searched < limit:
        level = min(level, limit)
        known, level = _count(lines, level)
        if known is None:
            break
        if known > len(found):
            new = _between(problem, edges, lines, found, known, searched, level)
            if new is None:
                break
            found = new
        searched = level
        if len(found) >= count:
            break
        level = _GROWTH * level
    order = sorted(found, key=lambda root: -root.real)
    return Roots(np.array(order, dtype=complex), searched)


def _first_level(lines: Lines) -> float:
    """Well right of the first root, as the deepest dip of |1 - p^| on the imaginary axis tells."""
    transform, slope = lines.law(0.0)
    depth = np.abs(1.0 - transform)
    dips = np.flatnonzero((depth[1:-1] < depth[:-2]) & (depth[1:-1] <= depth[2:]) & (depth[1:-1] < _DEEP)) + 1
    if not dips.size:
        return _FIRST
    away = -(np.log(transform[dips]) * transform[dips] / slope[dips]).real
    away = away[away > 0.0]
    return min(_FIRST, 0.5 * float(away.min())) if away.size else _FIRST


def _count(lines: Lines, level: float) -> tuple[int | None, float]:
    """Pairs right of a line at `level` or, where a root lies on it, just beside."""
    for _ in range(4):
        known = lines.pairs(level)
        if known is not None:
            break
        level *= _ASIDE
    return known, level


def _between(
    problem: Problem, edges: Array, lines: Lines, found: list[complex], known: int, right: float, left: float
) -> list[complex] | None:
    """`found` with the roots between two lines, `known` in all; None where not all of them came out."""
    found = list(found)
    for number in _LINES:
        for level in right + (left - right) * (np.arange(number) + 0.5) / number:
            transform, slope = lines.law(float(level))
            depth = np.abs(1.0 - transform)
            inner = (depth[1:-1] < depth[:-2]) & (depth[1:-1] <= depth[2:]) & (depth[1:-1] < _DEEP)
            for dip in np.flatnonzero(inner) + 1:
                start = complex(-level, lines.frequency[dip])
                start += complex(np.log(transform[dip]) * transform[dip] / slope[dip])
                # a guess is good where p^ is nearly one wave; others are followed up when those did not do
                far = not 0.7 * right < -start.real < 1.3 * left
                known_already = any(abs(start - root) < _THERE * (1.0 + abs(root)) for root in found)
                if known_already or (far and number <= _LINES[1]):
                    continue
                root = newton(problem.law, edges, start, 1)
                inside = np.isfinite(root) and -left < root.real < -0.999 * right and root.imag > 1e-6
                if inside and all(abs(root - other) > _SAME * (1.0 + abs(root)) for other in found):
                    found.append(root)
            if len(found) == known:
                return found
            if len(found) > known:
                return None
    return None
