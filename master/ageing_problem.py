"""Contacts that age as a problem of the renewal solver: the law of their breaks in place of that of thresholds."""

import numpy as np

from master.ageing_start import AgeingStart
from master.first import FirstBreaks
from master.first_passage import first_passage
from master.law import Law
from master.piecewise import tabulate
from master.problem import Problem
from origins import Contacts
from origins.thresholds import Array

_NOTHING = 1e-12
_SAME = 1e-14


class AgeingProblem(Problem):
    """Contacts with ageing = Ageing(..., closure="exact") that move on at one speed up to X = `end` (a length).

    `contacts` are those of the law of breaks, at rest, all relaxed; the true start is in `starting`.

    Attributes
    ----------
    law_error : float
        What the error of that law adds to F up to the path's end, in units of the problem.
    """

    def __init__(self, contacts: Contacts, velocity: float, end: float, tolerance: float) -> None:
        assert contacts.ageing is not None
        generations = 1.0 + end / contacts.mean_threshold
        accuracy = 0.3 * tolerance / generations
        passage = first_passage(contacts.thresholds, contacts.ageing, velocity, accuracy=accuracy)
        if contacts.start.span != (0.0, 0.0):
            self.starting = AgeingStart(contacts, velocity, accuracy)
        effective = Contacts(passage.law)
        super().__init__(effective, max(end / effective.mean_threshold, 1e-300), tolerance)
        self.law_error = passage.error * (1.0 + self.end)

    def _first(self, end: float, accuracy: float) -> FirstBreaks:
        if self.starting is None:
            return super()._first(end, accuracy)
        return AgeingBreaks(self.starting, self.law, end, accuracy)


class AgeingBreaks(FirstBreaks):
    """First breaks of the contacts that hold at X = 0, from AgeingStart; the face of FirstBreaks."""

    def __init__(self, starting: AgeingStart, law: Law, end: float, accuracy: float) -> None:
        self.end = end
        self._accuracy = max(accuracy, 2e-15)
        self._law = law
        unit = law.unit
        self.mean_start = float(starting.weights @ starting.stretches) / unit
        self.single = starting.is_single
        self.atoms = self.atom_weights = self.atom_released = np.empty(0)
        self.bends = self.bend_sizes = self.onsets = self.onset_heights = np.empty(0)
        self._order, self._atom_sums = np.empty(0, dtype=np.intp), np.zeros(1)

        def rows(x: Array) -> Array:
            return np.stack([starting.breaks(x * unit) * unit, starting.released(x * unit)])

        # where a level that came down turns up again
        turns = -starting.stretches[starting.stretches < 0.0] / unit
        turns = turns[turns < end]
        seeds = np.concatenate([starting.panels / unit, turns])
        seeds = np.unique(np.concatenate([[0.0], seeds[seeds < end], [end]]))
        # closer than rounding is once
        seeds = seeds[np.append(np.diff(seeds) > _SAME, True)]
        self.density, self._released = tabulate(rows, seeds, self._accuracy)
        left = float(starting.holding(np.array([end * unit]))[0])
        self._defect = abs(1.0 - left - self.density.total) + starting.error
        self.jumps, self.jump_sizes = np.zeros(1), self.density(np.zeros(1))
        passed = 2.0 * turns.max(initial=0.0) * unit
        self.has_corners = bool(turns.size and float(starting.holding(passed)) < 1.0 - _NOTHING)
