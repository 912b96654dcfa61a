"""The seam for thresholds: all that a solver may ask of the law P_c(x) of breaking thresholds."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


@runtime_checkable
class ThresholdLaw(Protocol):
    """Law P_c(x) of the thresholds x_s >= 0 (lengths) at which contacts break.

    A law may have a density, exact single values (`atoms`), or both. The methods take numbers or
    arrays of any shape and answer in that shape; outside the support they give the limits 0, 1 and
    -inf. origins.Thresholds, which all origins of thresholds return, conforms.

    To a relative 1e-10, of the law's own definition: pdf where it does not underflow, sf (also where
    it is small, where it is never computed as 1 - cdf), logsf (finite where sf underflows), mean, and
    sf at isf(q), or isf itself to 1e-12; logpdf to 1e-10 of max(1, |logpdf|).
    """

    def pdf(self, x: npt.ArrayLike) -> Array:
        """Density P_c(x), per length; atoms left out, inf where it diverges, limits from inside at the ends."""
        ...

    def logpdf(self, x: npt.ArrayLike) -> Array:
        """ln P_c(x); finite where P_c underflows."""
        ...

    def sf(self, x: npt.ArrayLike) -> Array:
        """Survival S(x): the probability that a threshold exceeds x, atoms counted."""
        ...

    def logsf(self, x: npt.ArrayLike) -> Array:
        """ln S(x), accurate where S ~ 1, too."""
        ...

    def isf(self, q: npt.ArrayLike) -> Array:
        """Threshold (a length) above which a fraction q lies; InputError for q outside [0, 1]."""
        ...

    def mean(self) -> float:
        """<x_s>, a length: the unit in which tolerances are stated."""
        ...

    def support(self) -> tuple[float, float]:
        """Ends (lower, upper) of the support, lengths; upper may be inf."""
        ...

    @property
    def atoms(self) -> tuple[Array, Array]:
        """(positions, weights) of the exact single values; empty where there are none."""
        ...

    @property
    def breakpoints(self) -> Array:
        """Where P_c or a derivative of it is not smooth: sorted lengths, finite ends of the support included."""
        ...

    @property
    def onset_power(self) -> float:
        """m in P_c(x) ~ (x - a)^m at the lower end a; inf where nothing continuous begins there, or slower."""
        ...
