"""Gaussian thresholds, the parent normal cut at x = 0 and normalised."""

from collections.abc import Callable
from typing import Literal

import numpy as np
from scipy.special import erfcx, log_ndtr, ndtr, ndtri, ndtri_exp

from origins.errors import between, finite, one_of, positive, refuse
from origins.thresholds.gaussian_chord import ChordGaussian
from origins.thresholds.law import Array, Thresholds
from origins.thresholds.quadrature import gauss

_LARGEST, _UNIT = 1e150, "choose another unit of length"  # so that squares are finite
_NARROWEST = 1e-15  # std over mean below which rounding leaves one value
_CLOSED = 5.0  # widths of the mean below 0, beyond which the closed forms lose digits
_ROOT_TWO = np.sqrt(2.0)
_ROOT_TWO_PI = np.sqrt(2.0 * np.pi)


def gaussian(
    mean: float, std: float, form: Literal["cut", "paper"] = "cut", upper: float | None = None
) -> Thresholds:
    """Thresholds from the normal law of `mean` and `std`, both lengths (paper, Eq. Q14e).

    form = "cut": the normal law conditional on x > 0.
    form = "paper": the paper's corrected form on (0, upper), the normal density less the chord between its values
    at 0 and at upper, cut where it is negative and normalised; needs 0 < mean < upper.
    Raises InputError unless mean is finite, std is finite and above 1e-15 of its size (for one value, use identical()),
    and `upper` is given for the paper's form and for it alone.
    """
    mean, std = finite("mean", mean), between("std", std, 1.0 / _LARGEST, _LARGEST, _UNIT)
    if abs(mean) > _LARGEST:
        refuse("mean", mean, f"must be at most {_LARGEST:g}; {_UNIT}")
    if std < _NARROWEST * abs(mean):
        rule = "one value to round-off" if mean > 0.0 else "nothing is left of it above 0"
        rule = f"is below 1e-15 of the mean, {mean:g}: {rule}; take identical, or a wider law"
        refuse("std", std, rule)
    if form == "cut":
        if upper is not None:
            refuse("upper", upper, 'belongs to form = "paper" alone; leave it out')
        return (NormalAboveZero if mean > -_CLOSED * std else CutGaussian)(mean, std)
    one_of("form", form, ("cut", "paper"))
    if not mean > 0.0:
        refuse("mean", mean, 'form = "paper" needs 0 < mean < upper')
    if upper is None:
        such = f"such as upper = {3.0 * mean:g}"
        refuse("upper", upper, f'form = "paper" needs the end of its interval, {such}')
    upper = positive("upper", upper)
    if not mean < upper:
        refuse("mean", mean, f'form = "paper" needs 0 < mean < upper = {upper:g}')
    return ChordGaussian(mean, std, upper)


class CutGaussian(Thresholds):
    """The normal law with parent mean and width, conditional on x > 0, given by its density."""

    onset_power = 0.0

    def __init__(self, parent_mean: float, parent_std: float) -> None:
        self.parent_mean = parent_mean
        self.parent_std = parent_std
        self._z0 = -parent_mean / parent_std
        # P_c(0), by a form that stays finite however small the part of the parent above 0 is
        self._log_kept = float(log_ndtr(-self._z0))
        self._kept = float(ndtr(-self._z0))
        scaled = float(erfcx(self._z0 / _ROOT_TWO))
        self._at_zero = 2.0 / scaled / (_ROOT_TWO_PI * parent_std)

    def support(self) -> tuple[float, float]:
        return 0.0, np.inf

    def _z(self, x: Array) -> Array:
        return (x - self.parent_mean) / self.parent_std

    def _logpdf(self, x: Array) -> Array:
        with np.errstate(over="ignore"):
            if self._z0 > 0.0:
                u = x / self.parent_std
                return np.log(self._at_zero) - u * (0.5 * u + self._z0)
            return -0.5 * self._z(x) ** 2 - np.log(_ROOT_TWO_PI * self.parent_std) - self._log_kept


class NormalAboveZero(CutGaussian):
    """The same in closed form, for parents whose mean lies no more than some widths below 0."""

    def _logsf(self, x: Array) -> Array:
        return self._near_one(x, log_ndtr(-self._z(x)) - self._log_kept)

    def _sf(self, x: Array) -> Array:
        return np.minimum(ndtr(-self._z(x)) / self._kept, 1.0)

    def _cdf(self, x: Array) -> Array:
        # differences on the side of the parent's median where less cancels
        side = -1.0 if self._z0 > 0.0 else 1.0
        out = np.abs(ndtr(side * self._z(x)) - ndtr(side * self._z0)) / self._kept
        # just above 0 the difference cancels: integrate the density instead
        near = x * max(1.0, abs(self._z0)) < 0.3 * self.parent_std
        if near.any():
            nodes, weights = gauss(np.zeros(int(near.sum())), x[near])
            out[near] = (weights * self._pdf(nodes)).sum(-1)
        return np.minimum(out, 1.0)

    def _isf(self, q: Array) -> Array:
        x = self.parent_mean - self.parent_std * ndtri_exp(np.log(q) + self._log_kept)
        return self._polish(x, q, self._sf, 1.0)

    def _ppf(self, q: Array) -> Array:
        if self._z0 > 0.0:
            x = self.parent_mean - self.parent_std * ndtri_exp(np.log1p(-q) + self._log_kept)
        else:
            x = self.parent_mean + self.parent_std * ndtri(ndtr(self._z0) + q * self._kept)
        # close to 0 the density is constant, and the forms above lose x to rounding
        x = np.where(q < 1e-6 * self._at_zero * self.parent_std, q / max(self._at_zero, 1e-300), x)
        return self._polish(x, q, self._cdf, -1.0)

    def _polish(self, x: Array, q: Array, function: Callable[[Array], Array], sign: float) -> Array:
        """Two Newton steps, which restore the digits lost where x is much smaller than the parent mean."""
        for _ in range(2):
            x = np.maximum(x, 0.0)
            density = self._pdf(x)
            with np.errstate(divide="ignore", invalid="ignore"):
                step = sign * (function(x) - q) / density
            x = x + np.where(np.isfinite(step) & (np.abs(step) < 0.1 * self.parent_std), step, 0.0)
        return np.maximum(x, 0.0)

    def _moment(self, n: float) -> float:
        if self.parent_mean < 0.0 or n != round(n):
            return super()._moment(n)
        variance = self.parent_std**2
        lower, moment = 1.0, self.parent_mean + variance * self._at_zero
        for order in range(2, round(n) + 1):
            lower, moment = moment, self.parent_mean * moment + (order - 1) * variance * lower
        return moment

    def _variance(self) -> float:
        if self.parent_mean < 0.0:
            return super()._variance()
        edge = self._at_zero * self.parent_std
        return self.parent_std**2 * (1.0 + self._z0 * edge - edge * edge)
