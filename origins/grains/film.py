"""Coalescing grains in a film: their number, the number that pins, their thresholds (paper, Sec. VI, Eq. LS2)."""

from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

import numpy as np
import numpy.typing as npt

from origins.errors import between, one_of, positive, refuse
from origins.grains.lifshitz_slyozov import hazard_beyond
from origins.thresholds.law import Array, Thresholds

_LARGEST = 1e50  # of rho, alpha and 1/alpha, whose powers must stay finite


def grains(
    rho: float | None = None,
    *,
    B: float,
    alpha: float | None = None,
    time: float | None = None,
    jacobian: Literal["exact", "paper"] = "exact",
) -> Thresholds:
    """Thresholds of the grains that pin, with Lifshitz and Slyozov's sizes (paper, Eq. LS2).

    P_c is conditional on pinning, and ends where the largest grain breaks, x_max = ((3 rho/2)² - 1)^(1/2) B^(-1/2).

    rho : mean grain diameter divided by the film's thickness, 2<r>/d; a number above 2/3, where the first grains pin.
    B : stiffness of a contact relative to a grain's strength, in length^-2: 4c/(pi tau d²) where f_s = c x_s².
    alpha, time : instead of rho: rho = alpha time^(1/3), with `time` since coalescence began and alpha in time^(-1/3).
    jacobian : "exact": P_c = P_LS(u) du/dx with u = (1 + B x²)^(1/2)/rho, so that P_c rises as x;
        "paper": P_c proportional to P_LS(u) as printed, from dr/df ~ f^(-1/2), so that P_c(0) > 0.

    Raises InputError for values outside these, and where neither or both of rho and (alpha, time) are given.
    """
    if rho is None and alpha is not None and time is not None:
        return GrainGrowth(alpha, B).thresholds(time, jacobian)
    if rho is None or alpha is not None or time is not None:
        refuse("rho", rho, "is alpha time^(1/3): give rho, such as 2.0, or alpha and time")
    # without rounding: near rho = 2/3 all thresholds depend on this difference
    excess = float(Fraction(positive("rho", rho)) * 3 / 2 - 1)
    if excess <= 0.0:
        refuse("rho", rho, "no grain pins yet: give rho > 2/3, where the largest spans the film")
    return PinningGrains(excess, B, jacobian)


@dataclass(frozen=True)
class GrainGrowth:
    """Grains whose mean radius grows as time^(1/3) in a film of constant thickness; time counts from their beginning.

    alpha : rho = 2<r>/d = alpha time^(1/3), in time^(-1/3); B : 2r/d = (1 + B x²)^(1/2), in length^-2.
    Methods take times as numbers or arrays and return their shape. Raises InputError for a value not above zero.
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
        """Radius of the largest grain divided by that of the first to pin, less 1; 0 up to tau_m."""
        return self.excess_after(np.maximum(np.asarray(time) - self.first_pinning_time, 0.0))

    def excess_after(self, later: npt.ArrayLike) -> Array:
        """The same at a time `later` >= 0 after tau_m, which keeps its digits right after the first pinning."""
        return np.asarray(np.expm1(np.log1p(np.asarray(later) / self.first_pinning_time) / 3.0))

    def rho(self, time: npt.ArrayLike) -> Array:
        """Mean grain diameter divided by the film's thickness."""
        return self.alpha * np.cbrt(self._times(time))

    def number(self, time: npt.ArrayLike) -> Array:
        """N(time)/N(tau_m) = tau_m/time: all grains, pinning or not."""
        return self.first_pinning_time / self._times(time)

    def pinned_fraction(self, time: npt.ArrayLike) -> Array:
        """Fraction of the grains at `time` that span the film; 0 up to tau_m."""
        q = 1.0 / np.maximum(self.excess(self._times(time)), 1e-300)
        return np.exp(-hazard_beyond(np.atleast_1d(q))).reshape(q.shape)[()]

    def pinning_number(self, time: npt.ArrayLike) -> Array:
        """Grains that span the film, the contacts, divided by the number of all at tau_m: largest at rho = 1."""
        return self.number(time) * self.pinned_fraction(time)

    def thresholds(self, time: float, jacobian: Literal["exact", "paper"] = "exact") -> Thresholds:
        """P_c of the grains that pin at `time`; see grains. InputError for times up to tau_m, when none pins."""
        if (excess := float(self.excess(positive("time", time)))) <= 0.0:
            first = f"the first does at (2/(3 alpha))³ = {self.first_pinning_time:.12g}"
            refuse("time", time, f"no grain pins yet: {first}")
        return PinningGrains(excess, self.B, jacobian)

    def _times(self, time: npt.ArrayLike) -> Array:
        times = np.asarray(time, dtype=float)
        for bad in times[~((times > 0.0) & np.isfinite(times))]:
            refuse("time", bad, "must be finite and above zero")
        return times


def film_growth(
    film_thickness: float,
    coarsening_rate: float,
    shear_strength: float,
    force_coefficient: float | None = None,
    shear_modulus: float | None = None,
) -> GrainGrowth:
    """Grain growth of a film from its physical constants, in SI units; lengths then are in m, times in s.

    film_thickness, coarsening_rate : d in m; K in m³/s, <r>³ = K time, so that tau_m = d³/(27 K).
    shear_strength : tau in Pa, at which a grain breaks: f_s = tau pi (r² - d²/4). A misfit to the substrate lowers it.
    force_coefficient : c in Pa, f_s = c x_s² (the paper's law).
    shear_modulus : G in Pa, in place of c = G²/tau: the contact's stiffness is k = G A^(1/2) with A = pi (r² - d²/4).

    Raises InputError for a value not above zero, and where neither or both of the last two are given.
    """
    thickness = positive("film_thickness", film_thickness)
    strength = positive("shear_strength", shear_strength)
    if (force_coefficient is None) == (shear_modulus is None):
        refuse("force_coefficient", force_coefficient, "give either it or shear_modulus, in Pa")
    if shear_modulus is not None:
        force_coefficient = positive("shear_modulus", shear_modulus) ** 2 / strength
    coefficient = positive("force_coefficient", force_coefficient)
    alpha = 2.0 * np.cbrt(positive("coarsening_rate", coarsening_rate)) / thickness
    return GrainGrowth(alpha, 4.0 * coefficient / (np.pi * strength * thickness**2))


class PinningGrains(Thresholds):
    """Stretches at which grains break, as `grains` describes them; excess = 3 rho/2 - 1 > 0."""

    def __init__(self, excess: float, B: float, jacobian: str) -> None:
        between("rho", 2.0 / 3.0 * (1.0 + excess), 0.0, _LARGEST)
        self._printed = one_of("jacobian", jacobian, ("exact", "paper")) == "paper"
        self._root_b, self._largest = float(np.sqrt(positive("B", B))), 1.0 + excess
        self._upper = float(np.sqrt(excess) * np.sqrt(excess + 2.0) / self._root_b)
        self._support = 0.0, self._upper
        self._free = excess / self._largest
        self.onset_power = 0.0 if self._printed else 1.0

    def _log_weight(self, x: Array) -> Array:
        s = self._root_b * x
        k = np.hypot(1.0, s)  # diameter of the grain divided by the film's thickness
        # that of the largest one less k, without cancellation
        below, beyond = self._root_b * (self._upper - x), self._root_b * (self._upper + x)
        room = below * beyond / (self._largest + k)
        with np.errstate(divide="ignore", invalid="ignore"):
            q = s * (s / (1.0 + k)) / (self._free * room)
            size = 2.0 * np.log(k) - 7.0 / 3.0 * np.log1p((k - 1.0) / (2.0 * self._largest + 1.0))
            size += 11.0 / 3.0 * np.log1p(q * self._free) - q
            return np.where(room > 0.0, size if self._printed else size + np.log(s / k), -np.inf)
