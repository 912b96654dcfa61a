"""Thresholds: the law P_c(x) of the stretch at which a contact breaks.

A family overrides the private methods on the inside of its support; this class does what all share: the
outside of the support, the inverses, the moments and the sampling. Names and meanings are those of a
frozen scipy.stats distribution.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from origins.errors import refuse
from origins.thresholds.inversion import invert_hazard

if TYPE_CHECKING:
    from origins.domains.rotated import DomainSamples
    from origins.roughness.interface import Interface

Array = npt.NDArray[np.float64]
RandomState = None | int | np.random.Generator


class Thresholds:
    """Distribution of breaking thresholds x_s >= 0 (a length).

    Survival is computed as such, not as 1 - cdf, and its logarithm stays finite where the survival
    underflows. A law may hold exact single values: they are `atoms`, and `pdf` is the density of the rest.

    Attributes
    ----------
    onset_power : float
        m in P_c(x) ~ (x - a)^m at the lower end a of the support; inf where P_c rises slower than any
        power, or where nothing continuous begins there.
    onset_power_error : float
        Its error: 0 where the family states it, else that of the fit.
    domains : DomainSamples or None
        Barriers, angles and sizes of the islands, where the law comes from rotated domains.
    knows_breakpoints : bool
        Whether `breakpoints` are all there are; a foreign law may bend or jump elsewhere.
    interface : Interface or None
        Load, contact density, stiffness and friction in SI units, where the law comes from a rough surface.
    """

    onset_power: float = np.inf
    onset_power_error: float = 0.0
    interface: Interface | None = None
    domains: DomainSamples | None = None
    knows_breakpoints: bool = True
    _lowest_atom: float = 0.0  # weight of an atom at the lower end of a support that reaches further

    # -- what a family states: x lies inside the support; densities are also asked at its finite ends ----
    def _pdf(self, x: Array) -> Array:
        # where the density diverges it may exceed all numbers
        with np.errstate(over="ignore"):
            return np.exp(self._logpdf(x))

    def _logpdf(self, x: Array) -> Array:
        with np.errstate(divide="ignore"):
            return np.log(self._pdf(x))

    def _cdf(self, x: Array) -> Array:
        raise NotImplementedError

    def _sf(self, x: Array) -> Array:
        raise NotImplementedError

    def _logsf(self, x: Array) -> Array:
        with np.errstate(divide="ignore"):
            out = np.log(self._sf(x))
        near = out > -0.5
        if near.any():
            out[near] = np.log1p(-self._cdf(x[near]))
        return out

    def _ppf(self, q: Array) -> Array:
        return self._from_hazard(-np.log1p(-q))

    def _isf(self, q: Array) -> Array:
        return self._from_hazard(-np.log(q))

    def _from_hazard(self, hazard: Array) -> Array:
        lower, upper = self._bracket(float(hazard.max()))
        flat = hazard.ravel()
        left, right = np.full(flat.shape, lower), np.full(flat.shape, upper)
        return invert_hazard(self, flat, left, right, 0.5 * left + 0.5 * right).reshape(hazard.shape)

    def _moment(self, n: int) -> float:
        from origins.thresholds.quadrature import moment

        return moment(self, n)

    def _variance(self) -> float:
        from origins.thresholds.quadrature import moment

        mean, square = self.moment(1), self.moment(2)
        if not square - mean * mean < 1e-3 * square:
            return square - mean * mean
        return moment(self, 2, centre=mean)

    def support(self) -> tuple[float, float]:
        """Ends (lower, upper) of the support; upper may be inf."""
        raise NotImplementedError

    @property
    def breakpoints(self) -> Array:
        """Sorted finite points where P_c or one of its derivatives is not smooth, the support's ends included."""
        return np.array([end for end in self.support() if np.isfinite(end)])

    @property
    def panels(self) -> Array | None:
        """Edges of panels on each of which the density is a polynomial that 8 nodes integrate; None where it is not."""
        return None

    @property
    def atoms(self) -> tuple[Array, Array]:
        """(positions, weights) of the exact single values in the law; empty where it is continuous."""
        return np.empty(0), np.empty(0)

    # -- what everyone calls --------------------------------------------------------------------------
    def pdf(self, x: npt.ArrayLike) -> Array:
        """Density P_c(x), per length; atoms left out, the limit from inside at the support's ends. Shape as x."""
        return self._density(self._pdf, x, 0.0)

    def logpdf(self, x: npt.ArrayLike) -> Array:
        """log P_c(x), finite where P_c underflows."""
        return self._density(self._logpdf, x, -np.inf)

    def cdf(self, x: npt.ArrayLike) -> Array:
        """Probability that a threshold is at most x."""
        return self._inside(self._cdf, x, 0.0, self._lowest_atom, 1.0)

    def sf(self, x: npt.ArrayLike) -> Array:
        """Survival: probability that a threshold exceeds x."""
        return self._inside(self._sf, x, 1.0, 1.0 - self._lowest_atom, 0.0)

    def logsf(self, x: npt.ArrayLike) -> Array:
        """log of the survival, finite where it underflows."""
        return self._inside(self._logsf, x, 0.0, np.log1p(-self._lowest_atom), -np.inf)

    def ppf(self, q: npt.ArrayLike) -> Array:
        """Threshold below which a fraction q lies. InputError for q outside [0, 1]."""
        return self._quantile(self._ppf, q, ends=self.support())

    def isf(self, q: npt.ArrayLike) -> Array:
        """Threshold above which a fraction q lies, accurate for tiny q. InputError for q outside [0, 1]."""
        return self._quantile(self._isf, q, ends=self.support()[::-1])

    def rough_quantiles(self, below: Array, above: Array) -> tuple[Array, Array]:
        """ppf(below) and isf(above), where a few digits will do."""
        return self.ppf(below), self.isf(above)

    def moment(self, n: int) -> float:
        """<x_s^n>, n = 0, 1, 2, ..., a length to the power n; inf where it does not exist."""
        if isinstance(n, bool) or not isinstance(n, int | np.integer) or n < 0:
            refuse("n", n, "must be a whole number of at least 0")
        return 1.0 if n == 0 else float(self._moment(int(n)))

    def mean(self) -> float:
        """<x_s>, a length."""
        return self.moment(1)

    def std(self) -> float:
        """Standard deviation of x_s, a length."""
        return float(np.sqrt(max(self._variance(), 0.0)))

    def rvs(self, size: int | tuple[int, ...] | None = None, random_state: RandomState = None) -> Array:
        """Independent thresholds; random_state is None, a seed or a numpy Generator."""
        generator = np.random.default_rng(random_state)
        return self.isf(1.0 - generator.random(size))

    # -- shared machinery -------------------------------------------------------------------------------
    def _inside(
        self, inner: Callable[[Array], Array], x: npt.ArrayLike, below: float, at_lower: float, above: float
    ) -> Array:
        x = np.asarray(x, dtype=float)
        lower, upper = self.support()
        within = (x > lower) & (x < upper)
        if x.ndim and x.size and within.all():
            return inner(x)
        # a NaN compares false everywhere and stays what it is
        out = np.where(x >= upper, above, np.where(x < lower, below, np.where(x == lower, at_lower, x)))
        if within.any():
            out[within] = inner(x[within])
        return out[()]

    def _density(self, inner: Callable[[Array], Array], x: npt.ArrayLike, outside: float) -> Array:
        x = np.asarray(x, dtype=float)
        lower, upper = self.support()
        within = (x >= lower) & (x <= upper) & np.isfinite(x)
        if x.ndim and x.size and within.all():
            return inner(x)
        out = np.where(np.isnan(x), x, outside)
        if within.any():
            out[within] = inner(x[within])
        return out[()]

    def _quantile(self, inner: Callable[[Array], Array], q: npt.ArrayLike, ends: tuple[float, float]) -> Array:
        q = np.asarray(q, dtype=float)
        if not ((q >= 0.0) & (q <= 1.0)).all():
            bad = q[~((q >= 0.0) & (q <= 1.0))].flat[0]
            refuse("q", bad, "must be a probability between 0 and 1")
        out = np.where(q == 0.0, ends[0], ends[1])
        within = (q > 0.0) & (q < 1.0)
        if within.any():
            out[within] = inner(q[within])
        return out[()]

    def _bracket(self, hazard: float) -> tuple[float, float]:
        """A finite interval that holds every threshold up to the one where -log sf(x) = hazard."""
        lower, upper = self.support()
        if np.isfinite(upper):
            return lower, upper
        upper = max(2.0 * lower, 1.0)
        while -self._logsf(np.array([upper]))[0] < hazard and upper < 1e300:
            upper *= 2.0
        return lower, upper
