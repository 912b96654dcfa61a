"""The protocol of thresholds: all that solvers use of the law P_c(x) of breaking thresholds."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


@runtime_checkable
class ThresholdLaw(Protocol):
    """Law P_c(x) of the thresholds x_s >= 0 (lengths) at which contacts break.

    A law may have a density, exact single values (`atoms`), or both. The methods take numbers or
    arrays of any shape and return that shape; outside the support they give the limits 0, 1 and
    -inf. origins.Thresholds, which all origins of thresholds return, explains each of them and
    conforms to this protocol.

    Required accuracy, a relative 1e-10 of the exact value: pdf where it does not underflow, sf (also
    where it is small, so never as 1 - cdf), logsf (finite where sf underflows, accurate also where sf
    is near 1), mean, and sf at isf(q), or isf itself to 1e-12; logpdf to 1e-10 of max(1, |logpdf|).
    isf raises InputError for q outside [0, 1].
    """

    def pdf(self, x: npt.ArrayLike) -> Array: ...
    def logpdf(self, x: npt.ArrayLike) -> Array: ...
    def sf(self, x: npt.ArrayLike) -> Array: ...
    def logsf(self, x: npt.ArrayLike) -> Array: ...
    def isf(self, q: npt.ArrayLike) -> Array: ...
    def mean(self) -> float: ...
    def support(self) -> tuple[float, float]: ...
    @property
    def atoms(self) -> tuple[Array, Array]: ...
    @property
    def breakpoints(self) -> Array: ...
    @property
    def onset_power(self) -> float: ...
