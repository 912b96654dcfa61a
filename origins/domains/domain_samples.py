"""The islands from which thresholds of rotated domains were computed: barriers, angles and sizes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from origins.thresholds.law import Array


@dataclass(frozen=True, eq=False)
class DomainSamples:
    """The islands from which thresholds of rotated domains were computed.

    Attributes
    ----------
    barriers : array of shape (samples,)
        epsilon_a, energies; 0 for islands that slide freely.
    angles : array of shape (samples,)
        Radians.
    n_atoms : array of shape (samples,)
        N_a.
    period : float
        a_s, the shortest period of the substrate, a length.
    mean_stiffness : float
        <k> over the islands that resist, force per length.
    """

    barriers: Array
    angles: Array
    n_atoms: npt.NDArray[np.int64]
    period: float
    mean_stiffness: float

    @property
    def forces(self) -> Array:
        """f_s = epsilon_a/a_s of the islands that resist, sorted."""
        return np.sort(self.barriers[self.barriers > 0.0]) / self.period

    @property
    def superlubric_weight(self) -> float:
        """Share of islands without a barrier. They carry no force and never break, and are left out of P_c, of
        N_c and of the properties below."""
        return 1.0 - float(np.count_nonzero(self.barriers)) / self.barriers.size

    @property
    def mean_force(self) -> float:
        """f of the fit exp(-f_s/f) of maximum likelihood: the mean of f_s."""
        return float(self.forces.mean())

    @property
    def exponential_distance(self) -> float:
        """Largest distance of that fit's cdf from that of the forces (Kolmogorov and Smirnov), to be compared with
        the sampling error 1.36/samples^(1/2)."""
        fitted = -np.expm1(-self.forces / self.mean_force)
        steps = np.arange(fitted.size + 1) / fitted.size
        return float(max((steps[1:] - fitted).max(), (fitted - steps[:-1]).max()))
