"""The stretches of the contacts at X = 0: one value, a Gaussian, or any frozen scipy.stats distribution."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.special import ndtr, ndtri

from origins.errors import TEMPERATURE, InputError, finite, non_negative, positive, refuse
from origins.thresholds.law import Array
from origins.thresholds.scipy_laws import as_frozen, single_mean

_BEYOND = 1e-16  # weight that lies beyond either end of a span
_REACH = 8.3  # standard deviations beyond which a Gaussian has that weight


class Start:
    """Distribution Q_ini(x) of the starting stretches (lengths, of either sign).

    `span` is the interval with all but 1e-16 of the weight on either side; `breakpoints` are points inside it where the
    density is not smooth. An exact single value has span (value, value) and no density.
    """

    span: tuple[float, float]
    breakpoints: Array
    _mean: float
    _law: Any  # a frozen distribution, where these methods are its own

    def pdf(self, x: npt.ArrayLike) -> Array:
        """Density at x, per length."""
        return self._law.pdf(x)

    def cdf(self, x: npt.ArrayLike) -> Array:
        """Probability of a stretch of at most x."""
        return self._law.cdf(x)

    def sf(self, x: npt.ArrayLike) -> Array:
        """Probability of a stretch above x."""
        return self._law.sf(x)

    def ppf(self, q: npt.ArrayLike) -> Array:
        """Stretch below which a fraction q lies."""
        return self._law.ppf(q)

    def isf(self, q: npt.ArrayLike) -> Array:
        """Stretch above which a fraction q lies."""
        return self._law.isf(q)

    def mean(self) -> float:
        """Mean starting stretch."""
        return self._mean

    @property
    def is_single(self) -> bool:
        """Whether all contacts start from one stretch."""
        return self.span[0] == self.span[1]


class SingleStart(Start):
    """All contacts start at one stretch."""

    def __init__(self, value: float) -> None:
        self._mean = value
        self.span = (value, value)
        self.breakpoints = np.array([value])


class GaussianStart(Start):
    """Normal law, not cut: stretches may be negative."""

    def __init__(self, mean: float, std: float) -> None:
        self._mean, self._std = mean, std
        self.span = (mean - _REACH * std, mean + _REACH * std)
        self.breakpoints = np.empty(0)

    def _z(self, x: npt.ArrayLike) -> Array:
        return (np.asarray(x, dtype=float) - self._mean) / self._std

    def pdf(self, x: npt.ArrayLike) -> Array:
        return np.exp(-0.5 * self._z(x) ** 2) / (self._std * np.sqrt(2.0 * np.pi))

    def cdf(self, x: npt.ArrayLike) -> Array:
        return ndtr(self._z(x))

    def sf(self, x: npt.ArrayLike) -> Array:
        return ndtr(-self._z(x))

    def ppf(self, q: npt.ArrayLike) -> Array:
        return self._mean + self._std * ndtri(np.asarray(q, dtype=float))

    def isf(self, q: npt.ArrayLike) -> Array:
        return self._mean - self._std * ndtri(np.asarray(q, dtype=float))


class FrozenStart(Start):
    """A frozen continuous scipy.stats distribution on the real line."""

    def __init__(self, frozen: Any, name: str) -> None:
        self._law = frozen
        self._mean = single_mean(name, frozen)
        if not np.isfinite(self._mean):
            rule = "stretches need a finite mean"
            raise InputError(f"{name}: the mean of the distribution is {self._mean}; {rule}")
        ends = np.array([float(end) for end in frozen.support()])
        self.breakpoints = ends[np.isfinite(ends)]
        reach = float(frozen.ppf(_BEYOND)), float(frozen.isf(_BEYOND))
        lower, upper = np.where(np.isfinite(ends), ends, reach)
        self.span = float(lower), float(upper)


def gaussian_start(mean: float, std: float) -> Start:
    """Starting stretches from a normal law (lengths); std = 0 is the single value `mean`.

    Raises InputError unless mean is finite and std is finite and not negative.
    """
    mean, std = finite("mean", mean), non_negative("std", std)
    return GaussianStart(mean, std) if std > 0.0 else SingleStart(mean)


def boltzmann_reforming(temperature: float) -> Start:
    """R(x) ~ exp(-x²/2T), the normal law of width T^(1/2) = (k_BT/<k>)^(1/2) about x = 0 (paper, Sec. IV).

    temperature : k_BT/<k>, a length squared. With linked stiffness the width is that of <k> too, since a contact's
    stretch is drawn before its threshold, on which k_i depends.
    Raises InputError unless it is finite and above zero.
    """
    return gaussian_start(0.0, float(np.sqrt(positive("temperature", temperature, TEMPERATURE))))


def as_start(start: object, name: str = "start") -> Start:
    """None (all relaxed, x = 0), a number, a Start or a frozen scipy.stats distribution, as a Start; messages use
    `name`."""
    if start is None:
        return SingleStart(0.0)
    if isinstance(start, Start):
        return start
    if isinstance(start, int | float | np.number) and not isinstance(start, bool):
        return SingleStart(finite(name, start))
    if (frozen := as_frozen(start)) is not None:
        return FrozenStart(frozen, name)
    such = "origins.gaussian_start(mean=0.0, std=0.025) or a frozen scipy.stats distribution"
    refuse(name, start, f"must be None, a stretch, {such}")
