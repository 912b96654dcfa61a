"""Thresholds of a film that solidifies in coalescing grains (paper, Eqs. LS1 and LS2).

A grain of radius r in a film of thickness d pins both surfaces where 2r > d; its threshold is f_s = tau pi (r² - d²/4),
and with f_s = c x_s² (paper, Eq. PxPf)

    2r/d = (1 + B x_s²)^(1/2),   B = 4c/(pi tau d²).
"""

from fractions import Fraction
from typing import Literal

import numpy as np

from origins.errors import between, positive, refuse
from origins.grains.pinning import PinningGrains
from origins.grains.printed import PrintedGrains
from origins.thresholds.law import Thresholds

_LARGEST = 1e50  # rho, whose powers must stay numbers


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

    Parameters
    ----------
    rho : float
        Mean grain diameter over film thickness, 2<r>/d; a number above 2/3.
    B : float
        How stiff a contact is beside a grain's strength, in length^-2: 4c/(pi tau d²) where f_s = c x_s².
    alpha, time : float
        Instead of rho: rho = alpha time^(1/3), with `time` since coalescence began and alpha in time^(-1/3).
    jacobian : "exact" or "paper"
        "exact": P_c = P_LS(u) du/dx with u = (1 + B x²)^(1/2)/rho, so that P_c rises as x;
        "paper": P_c proportional to P_LS(u) as printed, from dr/df ~ f^(-1/2), so that P_c(0) > 0.

    Raises InputError for values outside these, where neither or both of rho and (alpha, time) are given, and for
    rho <= 2/3, where no grain pins yet.
    """
    B = positive("B", B)
    if jacobian not in ("exact", "paper"):
        refuse("jacobian", jacobian, 'must be "exact" or "paper"')
    law = PinningGrains if jacobian == "exact" else PrintedGrains
    if rho is not None:
        if alpha is not None or time is not None:
            refuse("rho", rho, "is alpha time^(1/3): give rho, or alpha and time")
        rho = positive("rho", rho)
        # the difference is exact: it rules everything while the first grains pin
        excess = Fraction(rho) * 3 / 2 - 1
        if excess <= 0:
            refuse("rho", rho, "no grain pins yet: the largest is 3 rho/2 of the film's thickness; give rho > 2/3")
        if rho > _LARGEST:
            refuse("rho", rho, f"must be at most {_LARGEST:g}")
        return law(excess, B)
    if alpha is None and time is None:
        refuse("rho", rho, "is missing; give rho, such as 2.0, or alpha and time")
    if alpha is None:
        refuse("alpha", alpha, "is missing; rho = alpha time^(1/3) takes both, or give rho alone")
    if time is None:
        refuse("time", time, "is missing; rho = alpha time^(1/3) takes both, or give rho alone")
    alpha, time = between("alpha", alpha, 1.0 / _LARGEST, _LARGEST), positive("time", time)
    excess = Fraction(float(1.5 * alpha * np.cbrt(time) - 1.0))
    if excess <= 0:
        refuse("time", time, f"no grain pins yet: the first does at (2/(3 alpha))³ = {(2.0 / (3.0 * alpha)) ** 3:.12g}")
    if excess > 1.5 * _LARGEST:
        refuse("time", time, f"must keep rho = alpha time^(1/3) at most {_LARGEST:g}")
    return law(excess, B)
