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
    -inf. Accuracies are those of the law's own definition. origins.Thresholds, which all origins of
    thresholds return, conforms.
    """

    def pdf(self, x: npt.ArrayLike) -> Array:
        """Density P_c(x), per length; atoms left out, at the support's ends the limit from inside.

        To a relative 1e-10 where it does not underflow; inf where it diverges.
        """
        ...

    def logpdf(self, x: npt.ArrayLike) -> Array:
        """ln P_c(x), to 1e-10 of max(1, |ln P_c|); finite where P_c underflows."""
        ...

    def sf(self, x: npt.ArrayLike) -> Array:
        """Survival S(x): the probability that a threshold exceeds x, atoms counted.

        To a relative 1e-10, also where it is small: there it is never computed as 1 - cdf.
        """
        ...

    def logsf(self, x: npt.ArrayLike) -> Array:
        """ln S(x), to a relative 1e-10: finite where S underflows, and accurate where S ~ 1."""
        ...

    def isf(self, q: npt.ArrayLike) -> Array:
        """Threshold (a length) above which a fraction q lies; InputError for q outside [0, 1].

        To a relative 1e-12 in x, or 1e-10 in S(x); also for tiny q.
        """
        ...

    def mean(self) -> float:
        """<x_s>, a length: the unit in which tolerances are stated; to a relative 1e-10."""
        ...

    def support(self) -> tuple[float, float]:
        """Ends (lower, upper) of the support, lengths; upper may be inf."""
        ...

    @property
    def atoms(self) -> tuple[Array, Array]:
        """(positions, weights) of the exact single values, exact; empty where there are none."""
        ...

    @property
    def breakpoints(self) -> Array:
        """Where P_c or one of its derivatives is not smooth: sorted lengths, exact.

        Both finite ends of the support are among them. Between them the law is smooth.
        """
        ...

    @property
    def onset_power(self) -> float:
        """m in P_c(x) ~ (x - a)^m at the lower end a of the support.

        inf where P_c rises slower than any power, or where nothing continuous begins there. Exact
        where the law is a formula; for laws of samples the error of the fit is stated beside it.
        """
        ...
