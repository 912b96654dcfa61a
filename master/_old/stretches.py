"""Q(x;X) read from cohorts: how the stretches are distributed wherever the slider has come to a stand."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from master._old.cohort import SLACK, Cohort
from master._old.law import Law

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class CohortDistribution:
    """Density of stretches at one X, and the exact single values beside it.

    Attributes
    ----------
    delta_positions, delta_weights : arrays of shape (n,)
        Stretches (lengths) shared by a finite fraction of the contacts, and that fraction.
    """

    delta_positions: Array
    delta_weights: Array
    _law: Law
    _cohorts: list[Cohort]
    _at: float

    def density(self, x: npt.ArrayLike) -> Array:
        """Q(x;X) per length at stretches x (lengths), delta parts left out; same shape as x."""
        unit = self._law.unit
        birth = self._at - np.asarray(x, dtype=float) / unit
        total = np.zeros(birth.shape)
        for cohort in self._cohorts:
            total += cohort.table(birth) * self._law.sf(cohort.furthest(birth))
        return (total / unit)[()]


def stretches(law: Law, cohorts: list[Cohort], at: float) -> CohortDistribution:
    """Q(x;X) of the cohorts at X = at (in units of the mean threshold)."""
    positions = np.concatenate([[], *[cohort.positions for cohort in cohorts]])
    furthest = np.concatenate([[], *[cohort.furthest(cohort.positions) for cohort in cohorts]])
    # a contact whose stretch has reached its threshold is broken: survival past rounding of the sum
    weights = np.concatenate([[], *[cohort.weights for cohort in cohorts]]) * law.sf(furthest * (1.0 + SLACK))
    keep = weights > 0.0
    return CohortDistribution((at - positions[keep]) * law.unit, weights[keep], law, cohorts, at)
