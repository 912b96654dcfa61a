"""Gaussian thresholds: the parent normal cut at x = 0 and normalised, and the paper's corrected form."""

from typing import Literal

import numpy as np
import scipy  # imports its parts when they are first used

from origins.errors import between, finite, one_of, positive, refuse
from origins.thresholds.law import Array, Thresholds
from origins.thresholds.quadrature import gauss

_LARGEST, _UNIT = 1e150, "choose another unit of length"  # so that squares are finite


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
    if std < 1e-15 * abs(mean):
        hint = f"is below 1e-15 of the mean, {mean:g}, one value to round-off; take identical"
        refuse("std", std, hint)
    if form == "cut":
        if upper is not None:
            refuse("upper", upper, 'belongs to form = "paper" alone; leave it out')
        return UpperGaussian(mean, std) if mean >= 0.0 else CutGaussian(mean, std)
    one_of("form", form, ("cut", "paper"))
    if upper is None:
        refuse("upper", upper, f'form = "paper" needs it, such as upper = {3.0 * abs(mean):g}')
    upper = positive("upper", upper)
    if not 0.0 < mean < upper:
        refuse("mean", mean, f'form = "paper" needs 0 < mean < upper = {upper:g}')
    return ChordGaussian(mean, std, upper)


class CutGaussian(Thresholds):
    """The normal law with parent mean and width, conditional on x > 0."""

    onset_power = 0.0

    def __init__(self, parent_mean: float, parent_std: float) -> None:
        self.parent_mean, self.parent_std = parent_mean, parent_std
        self._least = -parent_mean / parent_std
        # log P_c(0), by a form that stays finite however small the part of the parent above 0 is
        front = parent_std * scipy.special.erfcx(self._least / np.sqrt(2.0))
        self._log_at_zero = float(0.5 * np.log(2.0 / np.pi) - np.log(front))

    def _logpdf(self, x: Array) -> Array:
        with np.errstate(over="ignore"):
            u = x / self.parent_std
            return self._log_at_zero - u * (0.5 * u + self._least)


class UpperGaussian(CutGaussian):
    """The same for a parent mean of at least 0, in closed form."""

    def __init__(self, parent_mean: float, parent_std: float) -> None:
        super().__init__(parent_mean, parent_std)
        self._kept = float(scipy.special.ndtr(-self._least))
        self._log_kept = float(scipy.special.log_ndtr(-self._least))
        self._log_peak = -float(np.log(np.sqrt(2.0 * np.pi) * parent_std)) - self._log_kept

    def _z(self, x: Array) -> Array:
        return (x - self.parent_mean) / self.parent_std

    def _logpdf(self, x: Array) -> Array:
        with np.errstate(over="ignore"):
            return -0.5 * self._z(x) ** 2 + self._log_peak

    def _logsf(self, x: Array) -> Array:
        return scipy.special.log_ndtr(-self._z(x)) - self._log_kept

    def _sf(self, x: Array) -> Array:
        return np.minimum(scipy.special.ndtr(-self._z(x)) / self._kept, 1.0)

    def _cdf(self, x: Array) -> Array:
        out = (scipy.special.ndtr(self._z(x)) - scipy.special.ndtr(self._least)) / self._kept
        near = x * max(1.0, -self._least) < 0.3 * self.parent_std  # just above 0 these cancel
        if near.any():
            nodes, weights = gauss(np.zeros(int(near.sum())), x[near])
            out[near] = (weights * self._pdf(nodes)).sum(-1)
        return np.minimum(out, 1.0)

    def _quantiles(self, below: Array, above: Array) -> Array:
        """In closed form; near x = 0, where that loses digits, by Newton's steps for the share below."""
        lower = scipy.special.ndtri(scipy.special.ndtr(self._least) + below * self._kept)
        z = np.where(below < above, lower, -scipy.special.ndtri_exp(np.log(above) + self._log_kept))
        x = self.parent_mean + self.parent_std * z
        typical = max(self.parent_mean, self.parent_std)
        some = below[near := ~(x > 0.5 * typical)]
        at = x[near]
        lost = at <= 1e-9 * typical  # none of a narrow law, whose density at 0 underflows
        at[lost] = some[lost] / np.exp(self._log_at_zero)
        for _ in range(4):
            at = at - (self._cdf(at) - some) / self._pdf(at)
        x[near] = at
        return x

    def _moment(self, n: float, centre: float = 0.0) -> float:
        if n not in (1.0, 2.0) or centre != 0.0:
            return super()._moment(n, centre)
        mean = self.parent_mean + self.parent_std**2 * float(np.exp(self._log_at_zero))
        return mean if n == 1.0 else self.parent_mean * mean + self.parent_std**2


class ChordGaussian(Thresholds):
    """P_c ~ h(x) = G(x) - G(0) - (x/upper) [G(upper) - G(0)] where that is positive (paper, after Eq. Q14e).

    h is positive on one interval within (0, upper), where the normal density G is above the chord.
    """

    onset_power = 1.0

    def __init__(self, parent_mean: float, parent_std: float, upper: float) -> None:
        self._mean, self._std, self._upper = parent_mean, parent_std, upper
        first = _zero_beyond(upper - parent_mean, parent_std, upper)
        self._support = upper - first, _zero_beyond(parent_mean, parent_std, upper)

    def _log_weight(self, x: Array) -> Array:
        """log of h(x) / G(mean), written relative to the nearer zero of h, to avoid cancellation there."""
        low, high = self._support
        anchor = np.where(x - low < high - x, low, high)
        with np.errstate(over="ignore", divide="ignore"):
            drop = self._log_ratio(self._upper, np.zeros(()))
            at = 0.0 if drop < 0.0 else self._upper  # where G is larger
            chord = np.exp(self._log_ratio(at, x)) * -np.expm1(-np.abs(drop)) * np.sign(drop)
            fraction = -np.expm1(self._log_ratio(anchor, x)) - chord * (x - anchor) / self._upper
            return -0.5 * ((x - self._mean) / self._std) ** 2 + np.log(np.maximum(fraction, 0.0))

    def _log_ratio(self, at: Array | float, x: Array) -> Array:
        """log of G(at) / G(x)."""
        return (at - x) / self._std * ((self._mean - 0.5 * (at + x)) / self._std)


def _zero_beyond(mean: float, std: float, upper: float) -> float:
    """The zero of h on (mean, upper): upper itself, unless h is negative just below it."""
    drop = upper * (2.0 * mean - upper) / (2.0 * std * std)  # log of G(upper) / G(0)
    rise = np.expm1(drop)
    if drop >= 0.0 or np.exp(drop) * (mean - upper) / std**2 <= rise / upper:
        return upper
    low, high = 2.0 * mean, upper  # from the mirror image of 0, where G is as high as there
    while low < (x := 0.5 * (low + high)) < high:
        positive = np.expm1(x * (2.0 * mean - x) / (2.0 * std * std)) > x / upper * rise
        low, high = (x, high) if positive else (low, x)
    return low
