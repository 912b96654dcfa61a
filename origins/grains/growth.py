"""Coalescing grains in time: their number, the number that pins, their thresholds (paper, Sec. VI, around Eq. LS2)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from origins.errors import between, positive, refuse
from origins.grains.film import grains
from origins.grains.lifshitz_slyozov import hazard_beyond
from origins.thresholds.law import Array, Thresholds

_LARGEST = 1e50  # of alpha and 1/alpha, whose powers must stay finite


@dataclass(frozen=True)
class GrainGrowth:
    """Grains whose mean radius grows as time^(1/3) in a film of constant thickness; time counts from their beginning.

    Attributes
    ----------
    alpha : float
        rho = 2<r>/d = alpha time^(1/3), in time^(-1/3).
    B : float
        Of a grain's threshold, 2r/d = (1 + B x²)^(1/2), in length^-2.

    Raises InputError for a value not above zero.
    """

    alpha: float
    B: float

    def __post_init__(self) -> None:
        between("alpha", self.alpha, 1.0 / _LARGEST, _LARGEST)
        positive("B", self.B)

    @property
    def first_pinning_time(self) -> float:
        """tau_m = (2/(3 alpha))³, at which the largest grain spans the film: the delay of a new contact."""
        return (2.0 / (3.0 * self.alpha)) ** 3

    def excess(self, time: npt.ArrayLike) -> Array:
        """Radius of the largest grain over that of the first to pin, less 1; 0 up to tau_m."""
        since = (np.asarray(time) - self.first_pinning_time) / self.first_pinning_time
        return np.asarray(np.expm1(np.log1p(np.maximum(since, 0.0)) / 3.0))

    def rho(self, time: npt.ArrayLike) -> Array:
        """Mean grain diameter over film thickness, shape as time. InputError for times not above zero."""
        return self.alpha * np.cbrt(self._times(time))

    def number(self, time: npt.ArrayLike) -> Array:
        """N(time)/N(tau_m) = tau_m/time: all grains, pinning or not. InputError for times not above zero."""
        return self.first_pinning_time / self._times(time)

    def pinned_fraction(self, time: npt.ArrayLike) -> Array:
        """Fraction of the grains at `time` that span the film; 0 up to tau_m. InputError for times not above zero."""
        excess = self.excess(self._times(time))
        with np.errstate(divide="ignore"):
            q = np.minimum(np.atleast_1d(1.0 / excess), 1e300)
        return np.exp(-hazard_beyond(q, 0.0, 1.0)).reshape(excess.shape)[()]

    def pinning_number(self, time: npt.ArrayLike) -> Array:
        """Grains that span the film, over the number of all grains at tau_m: largest at rho = 1, finally ~ 1/time.

        The contact density of the film over N(tau_m). InputError for times not above zero.
        """
        return self.number(time) * self.pinned_fraction(time)

    def thresholds(self, time: float, jacobian: Literal["exact", "paper"] = "exact") -> Thresholds:
        """P_c of the grains that pin at `time`; see grains. InputError for times up to tau_m, when none pins."""
        return grains(alpha=self.alpha, time=time, B=self.B, jacobian=jacobian)

    def _times(self, time: npt.ArrayLike) -> Array:
        times = np.asarray(time, dtype=float)
        bad = ~((times > 0.0) & np.isfinite(times))
        if bad.any():
            refuse("time", times[bad].flat[0], "must be finite and above zero")
        return times


def film_growth(
    film_thickness: float,
    coarsening_rate: float,
    shear_strength: float,
    force_coefficient: float | None = None,
    shear_modulus: float | None = None,
) -> GrainGrowth:
    """Grain growth of a film from its physical constants, in SI units; lengths then are in m, times in s.

    Parameters
    ----------
    film_thickness : float
        d in m; tau_m = d³/(27 K).
    coarsening_rate : float
        K in m³/s, <r>³ = K time.
    shear_strength : float
        tau in Pa, at which a grain breaks: f_s = tau pi (r² - d²/4). A misfit between grain and substrate lowers it.
    force_coefficient : float
        c in Pa, f_s = c x_s² (the paper's law).
    shear_modulus : float
        G in Pa, in place of c: the contact's stiffness is k = G A^(1/2) with A = pi (r² - d²/4), so that c = G²/tau.

    Raises InputError for a value not above zero, and where neither or both of the last two are given.
    """
    thickness, rate = (
        positive("film_thickness", film_thickness),
        positive("coarsening_rate", coarsening_rate),
    )
    strength = positive("shear_strength", shear_strength)
    if (force_coefficient is None) == (shear_modulus is None):
        refuse(
            "force_coefficient",
            force_coefficient,
            "give either force_coefficient or shear_modulus, in Pa",
        )
    if shear_modulus is not None:
        coefficient = positive("shear_modulus", shear_modulus) ** 2 / strength
    else:
        coefficient = positive("force_coefficient", force_coefficient)
    return GrainGrowth(
        2.0 * np.cbrt(rate) / thickness, 4.0 * coefficient / (np.pi * strength * thickness**2)
    )
