"""One straight move of the slider: old cohorts break, what broke breaks again, and a new cohort is born on the way.

With f the breaks of the old cohorts per unit travel y, births b and thresholds p, b = f + p * b: along a leg the
master equation is the renewal equation of forward motion with another source.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from master._old.atomic import AtomicChain
from master._old.breaking import CohortBreaks
from master._old.cohort import SLACK, Cohort, together
from master._old.corners import bends
from master._old.law import Law
from master._old.listed import ListedLater
from master._old.piecewise import Piecewise, tabulate
from master._old.problem import Problem
from master._old.renewal import LaterReleased, bound

Array = npt.NDArray[np.float64]

_PAST = 26  # nodes that a lattice reaches past its end, and two
_PANEL = 2.0  # times the narrowest width of the law: 16 nodes there see everything
_MOST_PANELS = 4096
_ONSET = 1e-6
_MOST_CORNERS = 400
_NOTHING = 1e-15
_JUMP = 1e-11
_RESOLVED = 8.0  # steps in a panel of a series, with which a lattice follows it
_APART, _NO_WEIGHT = 1e-13, 1e-18
_FEW = 0.1  # of what series are good to: births that need not be looked for


@dataclass(frozen=True)
class State:
    """Where the slider stands (in units of the mean threshold) and the cohorts of its contacts, oldest first.

    `error` is what the series that they were made from lack, but for what a finer lattice tells.
    """

    at: float
    cohorts: list[Cohort]
    error: float = 0.0

    def force(self, law: Law) -> tuple[float, float]:
        """Fraction of the contacts that hold, 1 but for errors, and the sum of their stretches."""
        held = [cohort.held(law, self.at) for cohort in self.cohorts]
        return sum(weight for weight, _ in held), sum(stretch for _, stretch in held)

    def backward(self, direction: int) -> float:
        """Largest stretch against `direction`, or zero: after that travel nothing pulls back."""
        return max(0.0, *(cohort.backward(self.at, direction) for cohort in self.cohorts))

    def moved(self, by: float) -> "State":
        """The same state elsewhere."""
        return State(self.at + by, [cohort.moved(by) for cohort in self.cohorts], self.error)

    def whole(self, law: Law) -> "State":
        """The same without what no longer holds, the rest made to add up to 1."""
        alive = [left for cohort in self.cohorts if (left := cohort.alive(law)) is not None]
        total = sum(cohort.held(law, self.at)[0] for cohort in alive)
        return State(self.at, [cohort.scaled(1.0 / total) for cohort in alive], self.error + abs(1.0 - total))


class LegProblem(Problem):
    """What does not depend on the lattice, but for how rough it looks on one of `step`, for one leg of travel `end`."""

    def __init__(self, law: Law, first: CohortBreaks, end: float, step: float) -> None:
        self.law, self.first, self.end, self.unit = law, first, end, law.unit
        # a law that begins at 0 with a finite density bends births wherever breaks jump, or all but jump
        corners = first.has_corners or first.changes_within(_RESOLVED * step)
        self.rough = law.rough or (corners and float(law.pdf(np.array([_ONSET]))[0]) > 1e-6)
        # a break at the turning point itself is known to rounding only
        near = np.abs(first.atoms - end) < 10.0 * SLACK
        self.chain = AtomicChain(law, np.where(near, end, first.atoms), first.atom_weights, end)


class Leg:
    """A move of travel up to `end` from `state` in `direction` (1 or -1), on a lattice of `step`.

    `y` are the travels, in order, that will be asked for; `known_to` is the step of the lattices behind `state`.

    Attributes
    ----------
    table_error : float
        What the series of breaks, here and before, are off by, but for what a finer lattice tells.
    """

    def __init__(
        self,
        law: Law,
        state: State,
        direction: int,
        end: float,
        step: float,
        accuracy: float,
        known_to: float,
        y: Array,
        first: CohortBreaks | None = None,
    ) -> None:
        self.law, self.state, self.direction, self.end, self.step = law, state, direction, end, step
        self._accuracy = accuracy
        past = end + _PAST * step
        self.first = first or CohortBreaks(law, state.cohorts, state.at, direction, past, accuracy, known_to)
        self.problem = LegProblem(law, self.first, end, step)
        self.start_force = self.first.mean_start
        unresolved = _unresolved(self.first.density, end, 2.0 * known_to) + self.first.lost + self.first.missed
        self.table_error = state.error + (1.0 + end) * unresolved
        self.later: LaterReleased | ListedLater | None = None
        if law.atomic and not self.first.single:
            self.later = ListedLater(law, self.first, self.problem.chain, end)
        elif not law.atomic and end > 0.0 and bound(self.problem, end, _NOTHING) > _NOTHING:
            self.later = LaterReleased(self.problem, step, y, accuracy)

    def force(self, y: Array) -> Array:
        """Force along the direction of motion, per contact, at travels y up to the end."""
        later = self.problem.chain.released(y) if self.later is None else self.later(y)
        return self.start_force + y - self.first.released(y) - later

    def covers(self, y: Array) -> npt.NDArray[np.bool_]:
        """Which travels the force is known at: all but those close to 0 that were not asked for."""
        if not isinstance(self.later, LaterReleased):
            return np.ones(y.size, dtype=bool)
        return self.later.step_at(y) > 0.0

    @property
    def nodes(self) -> int:
        """Nodes of the widest lattice; 0 where none was needed."""
        return self.later.lattice.size if isinstance(self.later, LaterReleased) else 0

    def rate(self, y: Array) -> Array:
        """Stretch released per unit travel at y, exact single values left out: 1 less the slope of the force."""
        later = 0.0 if self.later is None else self.later.rate(y)
        return self.first.rate(y) + later

    def births(self, y: Array) -> Array:
        """b at travels y: births per contact and unit travel, exact single values left out."""
        if self.later is None:
            return self.first.density(y)
        if isinstance(self.later, ListedLater):
            return self.first.density(y) + self.later.births(y)
        return self.first.density(y) + self.later.births(y, _FEW * self._accuracy)

    def end_state(self, y: float) -> State:
        """What is left after a travel of y: the old cohorts, and the one born on the way."""
        at = self.state.at + self.direction * y
        old = [cohort.visited(at) for cohort in self.state.cohorts]
        table, corners = self._tabulate(y)
        error = self.table_error + _unresolved(table, y, 2.0 * self.step)
        # what is born at points where the density diverges, closer than positions are told apart, is born at one
        table, places, weights = table.lumped(_APART * max(1.0, abs(at), abs(self.state.at)))
        chain = self.problem.chain
        born = chain.births <= y * (1.0 + SLACK)
        new = Cohort(
            at,
            at,
            table.seen(self.direction, self.state.at),
            self.state.at + self.direction * corners,
            self.state.at + self.direction * np.append(chain.births[born], places[weights > _NO_WEIGHT]),
            np.append(chain.weights[born], weights[weights > _NO_WEIGHT]),
        )
        return State(at, together([*old, new]), error)

    def _tabulate(self, end: float) -> tuple[Piecewise, Array]:
        """Births over the travel from 0 to `end`, and where they jump."""
        if (self.first.single and self.later is None) or end <= 0.0:
            return Piecewise(np.zeros(1), np.empty((16, 0))), np.empty(0)
        corners = self._corners(end)
        inner = np.linspace(0.0, end, 2 + int(min(end / (_PANEL * self.law.narrowest), _MOST_PANELS)))[1:-1]
        listed = self.later.edges(end) if isinstance(self.later, ListedLater) else np.empty(0)
        corners = np.concatenate([corners, listed])
        edges = np.unique(np.concatenate([[0.0, end], corners, inner]))
        edges = edges[np.append(np.diff(edges) > 1e-13 * end, True)]
        step = self.step

        def narrow(left: Array, right: Array) -> npt.NDArray[np.bool_]:
            return (right - left < 2.0 * step) & (left > 4.0 * (right - left))

        def rows(y: Array) -> Array:
            return self.births(y.ravel()).reshape(1, *y.shape)

        (table,) = tabulate(rows, edges, self._accuracy, narrow)
        return table, np.concatenate([[0.0, end], self._kinked(table, np.unique(corners))])

    def _kinked(self, table: Piecewise, at: Array) -> Array:
        """Those of the travels at which births jump, or bend where exact thresholds hand bends on to later breaks."""
        at = at[(at > 0.0) & (at < table.edges[-1]) & np.isin(at, table.edges)]
        sizes = table.jumps[np.searchsorted(table.edges, at)]
        jumps = at[np.abs(sizes) > max(_JUMP, self._accuracy)]
        if not self.law.atoms.size:
            return jumps
        return np.union1d(jumps, bends(table, at, self.law.narrowest)[0])

    def _corners(self, end: float) -> Array:
        """Where births bend: corners of f, and where thresholds of which many are alike are added, once and twice."""
        law, first = self.law, self.first
        found = first.seeds[(first.seeds > 0.0) & (first.seeds < end)]
        marks, again = np.append(law.jumps, law.atoms), np.append(0.0, found)
        for _ in range(2):
            if not marks.size or again.size * marks.size > _MOST_CORNERS:
                break
            again = (again[:, None] + marks).ravel()
            again = np.unique(again[again < end])
            found = np.append(found, again)
        return found


def _unresolved(table: Piecewise, end: float, narrow: float) -> float:
    """Estimate of what a series up to `end` is off by, from the last terms of all but narrow panels."""
    width = np.diff(table.edges)
    tails = np.abs(table.coefficients[-2:]).max(axis=0, initial=0.0) * width
    tails = tails[(width >= narrow) & (table.edges[:-1] < end)]
    return float(tails.max(initial=0.0)) + 0.2 * float(tails.sum())
