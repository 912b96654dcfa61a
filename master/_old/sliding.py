"""The two ways a soft slider moves straight on: its contacts re-form at once, or stay out until it stands again."""

from functools import cached_property

import numpy as np
import numpy.typing as npt

from master._old.breaking import CohortBreaks
from master._old.cohort import SLACK, Cohort
from master._old.law import Law
from master._old.leg import Leg, State
from master._old.piecewise import Piecewise, tabulate

Array = npt.NDArray[np.float64]

_BESIDE = 1e-12
_LEAST_DROP = 1e-13


class Sliding:
    """Contacts re-form at once: the rigid curve along one leg, and the spring."""

    def __init__(self, leg: Leg, spring: float) -> None:
        self.leg, self.spring, self.end = leg, spring, leg.end

    def force(self, y: Array) -> Array:
        """Force of the contacts along the motion."""
        return self.leg.force(y)

    def load(self, y: Array) -> Array:
        return self.force(y) + self.spring * y

    def slope(self, y: Array) -> Array:
        return 1.0 + self.spring - self.leg.rate(y)

    @cached_property
    def points(self) -> Array:
        nodes: Array = self.leg.step * np.arange(1, int(self.end / self.leg.step) + 1, dtype=float)
        return _with_edges(nodes, self.leg.first, self.end)

    @cached_property
    def drops(self) -> Array:
        law, first, chain = self.leg.law, self.leg.first, self.leg.problem.chain
        again = (chain.births[:, None] + law.atoms).ravel()
        weights = (chain.weights[:, None] * (law.atom_weights * law.atoms)).ravel()
        return _drops(np.append(first.atoms, again), np.append(first.atom_released, weights), self.end)


class Holding:
    """Broken contacts stay out: what the contacts that hold at the beginning of a slip carry along it."""

    def __init__(self, law: Law, state: State, direction: int, end: float, accuracy: float, step: float, spring: float):
        self._state, self._direction, self.spring, self.end = state, direction, spring, end
        self._first = first = CohortBreaks(law, state.cohorts, state.at, direction, end, accuracy, step)
        self._step = step
        density = first.density
        # y times the breaks at y: what is needed to integrate how many hold
        self._weighted = Piecewise(np.zeros(1), np.empty((16, 0)))
        if density.edges.size > 1:
            (self._weighted,) = tabulate(lambda y: (y * density(y))[None], density.edges, np.inf)
        order = np.argsort(first.atoms, kind="stable")
        self._atoms = first.atoms[order]
        weights = first.atom_weights[order]
        self._atom_weights = np.concatenate([[0.0], np.cumsum(weights)])
        self._atom_moments = np.concatenate([[0.0], np.cumsum(weights * self._atoms)])

    def broken(self, y: Array) -> Array:
        """Fraction of the contacts broken up to y; a break at y itself counts."""
        return self._first.density.integral(y) + self._atom_weights[self._count(y)]

    def force(self, y: Array) -> Array:
        """Force of those that hold, along the motion."""
        out = y * self.broken(y) - self._weighted.integral(y) - self._atom_moments[self._count(y)]
        return self._first.mean_start + y - self._first.released(y) - out

    def load(self, y: Array) -> Array:
        return self.force(y) + self.spring * y

    def slope(self, y: Array) -> Array:
        return 1.0 + self.spring - self.broken(y) - self._first.rate(y)

    def end_state(self, y: float) -> State:
        """The slider stands again after y: the broken contacts are back, at x = 0."""
        at = self._state.at + self._direction * y
        old = [cohort.visited(at) for cohort in self._state.cohorts]
        weight = self.broken(np.array([y]))
        return State(at, [*old, Cohort(at, at, positions=np.array([at]), weights=weight)], self._state.error)

    @cached_property
    def points(self) -> Array:
        return _with_edges(np.linspace(0.0, self.end, 400)[1:], self._first, self.end)

    @cached_property
    def drops(self) -> Array:
        return _drops(self._first.atoms, self._first.atom_released, self.end)

    def _count(self, y: Array) -> npt.NDArray[np.intp]:
        return np.searchsorted(self._atoms, y * (1.0 + SLACK), side="right")


def _with_edges(nodes: Array, first: CohortBreaks, end: float) -> Array:
    """The nodes, and both sides of every edge at which breaks may jump."""
    edges = np.concatenate([first.density.edges, first.seeds])
    y = np.concatenate([nodes, edges * (1.0 - _BESIDE), edges * (1.0 + _BESIDE), [end]])
    return np.unique(y[(y > 0.0) & (y <= end)])


def _drops(at: Array, released: Array, end: float) -> Array:
    return np.unique(at[(released > _LEAST_DROP) & (at > 0.0) & (at <= end)])
