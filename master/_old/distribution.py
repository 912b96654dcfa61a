"""Q(x;X): how the stretches of the contacts are distributed when the slider stands at X."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from master._old.problem import Problem
from master._old.renewal import LaterReleased
from origins.errors import InputError, finite, refuse

Array = npt.NDArray[np.float64]

_SLACK = 1e-12


@dataclass(frozen=True)
class StretchDistribution:
    """Density of stretches at one X, and the exact single values beside it.

    Attributes
    ----------
    delta_positions, delta_weights : arrays of shape (n,)
        Stretches (lengths) shared by a finite fraction of the contacts, and that fraction.
    """

    delta_positions: Array
    delta_weights: Array
    _problem: Problem
    _later: LaterReleased | None
    _at: float

    def density(self, x: npt.ArrayLike) -> Array:
        """Q(x;X) per length at stretches x (lengths), delta parts left out; same shape as x.

        As good as the force away from corners of P_c; within some ten nodes of where three breaks at corners add up,
        good to the square of the lattice's step.
        """
        unit = self._problem.unit
        scaled = np.asarray(x, dtype=float) / unit
        return ((self._starting(scaled) + self._reborn(scaled)) / unit)[()]

    def _starting(self, x: Array) -> Array:
        """Contacts that hold since X = 0: Q_ini(x_0) S(max(|x_0|, x)) / S(|x_0|), x_0 = x - X."""
        contacts = self._problem.contacts
        if contacts.start.is_single:
            return np.zeros(x.shape)
        origin = x - self._at
        kept = self._problem.cycle.survived(contacts.start, origin * self._problem.unit, x * self._problem.unit)
        return contacts.start.pdf(origin * self._problem.unit) * self._problem.unit * kept / (1.0 - contacts.cut_weight)

    def _reborn(self, x: Array) -> Array:
        """Contacts born at X - x, what broke a wait before: E(x) b(X - x - d)."""
        problem, release = self._problem, self._problem.release
        birth = self._at - (x - release.birth)
        inside = (x >= release.birth) & (birth >= release.delay)
        start = np.full(int(inside.sum()), release.birth * problem.unit)
        out = np.zeros(x.shape)
        held = problem.cycle.survived(problem.cycle.births, start, x[inside] * problem.unit)
        out[inside] = held * birth_density(problem, self._later, birth[inside] - release.delay)
        return out


def birth_density(problem: Problem, later: LaterReleased | None, position: Array) -> Array:
    """b(X), births per contact and unit X at positions X >= 0, chains of atoms left out."""
    density = problem.first.density(position)
    if later is not None and position.size:
        density = density + np.maximum(later.births(position), -density)
    return density


def distribution_at(problem: Problem, later: LaterReleased | None, position: float, end: float) -> StretchDistribution:
    """Q(x;X) at X = position."""
    position = finite("position", position)
    if not 0.0 <= position <= end * (1.0 + _SLACK):
        refuse("position", position, f"must lie between 0 and the end of the path, {end:g}")
    at = position / problem.unit
    chain, release, unit = problem.chain, problem.release, problem.unit
    again = problem.contacts.reforming
    if again is not None and not again.law.is_single:
        raise InputError("contacts.reforming: Q(x;X) is not known yet where contacts form again at many stretches")
    cycle, births = problem.cycle, chain.births + release.delay
    born = births <= at * (1.0 + _SLACK)
    positions = np.maximum(at - births[born], 0.0) + release.birth
    # a contact whose stretch has reached its threshold is broken: survival past rounding of the sum
    reached = positions + _SLACK * np.abs(positions)
    held = cycle.survived(cycle.births, np.full(positions.size, release.birth * unit), reached * unit)
    weights = chain.weights[born] * held
    start = problem.contacts.start
    if start.is_single:
        origin = float(start.mean() / problem.unit)
        furthest = origin + at + _SLACK * abs(origin + at)
        held = cycle.survived(start, np.array([origin]) * unit, np.array([furthest]) * unit)
        positions, weights = np.append(positions, origin + at), np.append(weights, held)
    keep = weights > 0.0
    return StretchDistribution(positions[keep] * problem.unit, weights[keep], problem, later, at)
