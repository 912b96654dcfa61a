"""Thresholds of a film that solidifies in coalescing grains (paper, Eqs. LS1 and LS2).

A grain of radius r in a film of thickness d pins both surfaces where 2r > d; its threshold is
f_s = tau pi (r² - d²/4), and with f_s = c x_s² (paper, Eq. PxPf)

    k = 2r/d = (1 + B x_s²)^(1/2),   B = 4c/(pi tau d²).
"""

from typing import Literal

import numpy as np

from origins.errors import between, one_of, positive, refuse
from origins.grains.lifshitz_slyozov import OfHazard, hazard_beyond
from origins.thresholds.law import Array, Thresholds

_LARGEST = 1e50  # largest rho, whose powers must stay finite
_REST = -3.700743415417188e-17  # 2/3 as a float less 2/3


def grains(
    rho: float | None = None,
    *,
    B: float,
    alpha: float | None = None,
    time: float | None = None,
    jacobian: Literal["exact", "paper"] = "exact",
) -> Thresholds:
    """Thresholds of the grains that pin, with Lifshitz and Slyozov's sizes (paper, Eq. LS2).

    P_c is conditional on pinning, and ends where the largest grain breaks,
    x_max = ((3 rho/2)² - 1)^(1/2) B^(-1/2).

    Parameters
    ----------
    rho : float
        Mean grain diameter over film thickness, 2<r>/d; a number above 2/3.
    B : float
        Stiffness of a contact relative to a grain's strength, in length^-2: 4c/(pi tau d²) where f_s = c x_s².
    alpha, time : float
        Instead of rho: rho = alpha time^(1/3), with `time` since coalescence began and alpha in time^(-1/3).
    jacobian : "exact" or "paper"
        "exact": P_c = P_LS(u) du/dx with u = (1 + B x²)^(1/2)/rho, so that P_c rises as x;
        "paper": P_c proportional to P_LS(u) as printed, from dr/df ~ f^(-1/2), so that P_c(0) > 0.

    Raises InputError for values outside these, where neither or both of rho and (alpha, time) are given,
    and for rho <= 2/3, where no grain pins yet.
    """
    B = positive("B", B)
    one_of("jacobian", jacobian, ("exact", "paper"))
    law = PinningGrains if jacobian == "exact" else PrintedGrains
    if rho is not None:
        if alpha is not None or time is not None:
            refuse("rho", rho, "is alpha time^(1/3): give rho, or alpha and time")
        rho = positive("rho", rho)
        # to the last bit: near rho = 2/3 all thresholds depend on this difference
        excess = 1.5 * ((rho - 2.0 / 3.0) + _REST)
        if excess <= 0.0:
            rule = (
                "no grain pins yet: the largest is 3 rho/2 of the film's thickness; give rho > 2/3"
            )
            refuse("rho", rho, rule)
        if rho > _LARGEST:
            refuse("rho", rho, f"must be at most {_LARGEST:g}")
        return law(excess, B)
    if alpha is None and time is None:
        refuse("rho", rho, "is missing; give rho, such as 2.0, or alpha and time")
    for name, value in (("alpha", alpha), ("time", time)):
        if value is None:
            rule = "is missing; rho = alpha time^(1/3) takes both, or give rho alone"
            refuse(name, value, rule)
    alpha, time = between("alpha", alpha, 1.0 / _LARGEST, _LARGEST), positive("time", time)
    excess = float(1.5 * alpha * np.cbrt(time) - 1.0)
    if excess <= 0.0:
        first = (2.0 / (3.0 * alpha)) ** 3
        refuse("time", time, f"no grain pins yet: the first does at (2/(3 alpha))³ = {first:.12g}")
    if excess > 1.5 * _LARGEST:
        refuse("time", time, f"must keep rho = alpha time^(1/3) at most {_LARGEST:g}")
    return law(excess, B)


class _Film(Thresholds):
    """Stretches at which grains break; excess = 3 rho/2 - 1 > 0."""

    def __init__(self, excess: float, B: float) -> None:
        self._root_b, self._m0 = float(np.sqrt(B)), 1.0 + excess
        self._y0, self._e0 = 1.0 / self._m0, excess / self._m0
        upper = np.sqrt(np.longdouble(excess) * (np.longdouble(excess) + 2)) / np.sqrt(
            np.longdouble(B)
        )
        # near the end distances are small differences: keep the part of `upper` that the float rounds off
        self._upper = float(upper)
        self._upper_rest = float(upper - np.longdouble(self._upper))

    def support(self) -> tuple[float, float]:
        return 0.0, self._upper

    def _sizes(self, x: Array) -> tuple[Array, Array, Array]:
        """k, its distance m0 - k from the largest one, and the q of lifshitz_slyozov for this grain size."""
        s = self._root_b * x
        k = np.hypot(1.0, s)
        left = self._root_b * ((self._upper - x) + self._upper_rest)
        left = left * (self._root_b * (self._upper + x) / (self._m0 + k))
        with np.errstate(divide="ignore", invalid="ignore"):
            return k, left, s * (s / (1.0 + k)) / (self._e0 * left)


class PinningGrains(_Film, OfHazard):
    """Exact Jacobian: the survival is that of the sizes, S = S_LS(u(x))/S_LS(1/rho)."""

    onset_power = 1.0

    def _hazard(self, x: Array) -> Array:
        return hazard_beyond(self._sizes(x)[2], self._y0, self._e0)

    def _logpdf(self, x: Array) -> Array:
        k, left, q = self._sizes(x)
        with np.errstate(divide="ignore", invalid="ignore"):
            slope = np.log(3.0 * self._root_b / (2.0 * self._m0 + k)) + np.log(self._root_b * x)
            log = slope + np.log(k) - 2.0 * np.log(left) - hazard_beyond(q, self._y0, self._e0)
        return np.where((x > 0.0) & (left > 0.0), log, -np.inf)


class PrintedGrains(_Film):
    """The Jacobian that the paper prints: P_c proportional to P_LS(u(x))."""

    onset_power = 0.0

    def _log_weight(self, x: Array) -> Array:
        k, left, q = self._sizes(x)
        with np.errstate(divide="ignore", invalid="ignore"):
            size = 2.0 * np.log(k) - 7.0 / 3.0 * np.log1p((k - 1.0) / (2.0 * self._m0 + 1.0))
            return np.where(left > 0.0, size + 11.0 / 3.0 * np.log1p(q * self._e0) - q, -np.inf)
