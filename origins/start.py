"""The stretches of contacts at X = 0, and of broken ones as they form again, with thresholds that can bear them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.special import ndtr, ndtri

from origins.errors import TEMPERATURE, InputError, finite, non_negative, positive, refuse
from origins.thresholds.law import Array, Thresholds
from origins.thresholds.scipy_laws import as_frozen, single_mean

_BEYOND = 1e-16  # weight that lies beyond either end of a span
_REACH = 8.3  # standard deviations beyond which a Gaussian has that weight
_CUT_LIMIT = 1e-6  # largest weight beyond every threshold that is cut off, the same as for thresholds below 0
_LEAST_SURVIVAL = 1e-300


class Start:
    """Distribution Q_ini(x) of the starting stretches (lengths, of either sign).

    `pdf`, `cdf`, `sf`, `ppf` and `isf` are those of scipy.stats. `span` is the interval with all but 1e-16 of the
    weight on either side; `breakpoints` are points inside it where the density is not smooth. An exact single value has
    span (value, value) and none of the five.
    """

    span: tuple[float, float]
    breakpoints: Array
    pdf: Callable[[Any], Array]
    cdf: Callable[[Any], Array]
    sf: Callable[[Any], Array]
    ppf: Callable[[Any], Array]
    isf: Callable[[Any], Array]
    _mean: float

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
        self._mean, self.span, self.breakpoints = value, (value, value), np.array([value])


class GaussianStart(Start):
    """Normal law, not cut: stretches may be negative."""

    def __init__(self, mean: float, std: float) -> None:
        self._mean, self._std = mean, std
        self.span, self.breakpoints = (mean - _REACH * std, mean + _REACH * std), np.empty(0)

    def _z(self, x: npt.ArrayLike) -> Array:
        return (np.asarray(x, dtype=float) - self._mean) / self._std

    def pdf(self, x: npt.ArrayLike) -> Array:
        return np.exp(-0.5 * self._z(x) ** 2) / (self._std * np.sqrt(2.0 * np.pi))

    def cdf(self, x: npt.ArrayLike) -> Array:
        return ndtr(self._z(x))

    def sf(self, x: npt.ArrayLike) -> Array:
        return ndtr(-self._z(x))

    def ppf(self, q: npt.ArrayLike) -> Array:
        return self._mean + self._std * ndtri(q)

    def isf(self, q: npt.ArrayLike) -> Array:
        return self._mean - self._std * ndtri(q)


class FrozenStart(Start):
    """A frozen continuous scipy.stats distribution on the real line."""

    def __init__(self, frozen: Any, name: str) -> None:
        self._mean = single_mean(name, frozen)
        if not np.isfinite(self._mean):
            rule = "stretches need a finite mean"
            raise InputError(f"{name}: the mean of the distribution is {self._mean}; {rule}")
        for method in ("pdf", "cdf", "sf", "ppf", "isf"):
            setattr(self, method, getattr(frozen, method))
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


class Births:
    """Stretches from `law`, each with a threshold from P_c conditional on x_s > |x|.

    This is the state of the contacts that hold at X = 0, and of broken contacts as they re-form.

    Attributes
    ----------
    law : Start
        Of the stretches (lengths).
    cut_weight : float
        Weight of the law where the survival of thresholds is 0 or below 1e-300, which is cut off; 0 by default.

    Raises InputError, with `name` in its message, where this weight is above 1e-6: such contacts cannot hold.
    """

    def __init__(self, name: str, law: Start, thresholds: Thresholds) -> None:
        self.law, self._thresholds, self.cut_weight = law, thresholds, 0.0
        if float(thresholds.sf(max(abs(end) for end in law.span))) > 0.0:
            return
        reach = thresholds.support()[1]
        reach = reach if np.isfinite(reach) else float(thresholds.isf(_LEAST_SURVIVAL))
        self.cut_weight = 1.0 if law.is_single else float(law.cdf(-reach) + law.sf(reach))
        if self.cut_weight > _CUT_LIMIT:
            beyond = f"beyond every threshold, at |x| >= {reach:.6g}; use stretches below it"
            raise InputError(f"{name}: a weight of {self.cut_weight:.3g} lies {beyond}")

    def draw(self, size: int, generator: np.random.Generator) -> tuple[Array, Array]:
        """Independent stretches and thresholds (lengths), shapes (size,); those beyond every threshold drawn again."""
        upper = self._thresholds.support()[1]
        if self.law.is_single:
            x = np.full(size, self.law.mean())
        else:
            x = self.law.ppf(generator.random(size))
            while (beyond := np.flatnonzero(np.abs(x) >= upper)).size:
                x[beyond] = self.law.ppf(generator.random(beyond.size))
        held = np.abs(x)
        left = self._thresholds.sf(held) * (1.0 - generator.random(size))
        return x, np.maximum(self._thresholds.isf(left), held)
