"""The stretches of contacts at X = 0, and of broken ones as they form again, with thresholds that can bear them."""

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy

from origins.errors import TEMPERATURE, InputError, finite, non_negative, positive, refuse
from origins.thresholds.law import Array, Thresholds
from origins.thresholds.scipy_laws import as_frozen, jumps_of, single_mean

LARGEST = 1e150  # of the mean and the width of a start, so that their squares are finite


class Start:
    """Distribution of stretches (lengths, of either sign): Q_ini(x) at X = 0, or of those at which contacts re-form.

    `pdf`, `cdf`, `sf`, `ppf` and `isf` are those of scipy.stats. `span` is the interval with all but 1e-16 of the
    weight on either side; `breakpoints` are points inside it where the density is not smooth. An exact single value has
    span (value, value) and none of the five.
    """

    pdf: Callable[[Any], Array]
    cdf: Callable[[Any], Array]
    sf: Callable[[Any], Array]
    ppf: Callable[[Any], Array]
    isf: Callable[[Any], Array]

    def __init__(
        self, mean: float, span: tuple[float, float], breakpoints: npt.ArrayLike = ()
    ) -> None:
        self._mean, self.span = mean, span
        self.breakpoints: Array = np.asarray(breakpoints, dtype=float)

    def mean(self) -> float:
        """Mean starting stretch."""
        return self._mean

    def __repr__(self) -> str:
        """Its name and its mean stretch, such as SingleStart(mean=0)."""
        return f"{type(self).__name__}(mean={self.mean():.6g})"

    @property
    def is_single(self) -> bool:
        """Whether all contacts start from one stretch."""
        return self.span[0] == self.span[1]


class SingleStart(Start):
    """All contacts start at one stretch."""

    def __init__(self, value: float) -> None:
        super().__init__(value, (value, value), [value])


class GaussianStart(Start):
    """Normal law, not cut: stretches may be negative."""

    def __init__(self, mean: float, std: float) -> None:
        furthest = 8.3 * std  # beyond which lie 1e-16 of the weight
        super().__init__(mean, (mean - furthest, mean + furthest))
        self._std = std
        norm = std * np.sqrt(2.0 * np.pi)
        self.pdf = lambda x: np.exp(-0.5 * ((np.asarray(x) - mean) / std) ** 2) / norm
        self.cdf = lambda x: scipy.special.ndtr((np.asarray(x) - mean) / std)
        self.sf = lambda x: scipy.special.ndtr((mean - np.asarray(x)) / std)
        self.ppf = lambda q: mean + std * scipy.special.ndtri(q)
        self.isf = lambda q: mean - std * scipy.special.ndtri(q)

    def __repr__(self) -> str:
        return f"GaussianStart(mean={self.mean():.6g}, std={self._std:.6g})"


def gaussian_start(mean: float, std: float) -> Start:
    """Starting stretches from a normal law (lengths); std = 0 is the single value `mean`.

    Raises InputError unless std is not negative, and both are at most 1e150 in size.
    """
    mean, std = finite("mean", mean), non_negative("std", std)
    for name, value in (("mean", mean), ("std", std)):
        if abs(value) > LARGEST:
            refuse(
                name, value, f"must be at most {LARGEST:g} in size; choose another unit of length"
            )
    return GaussianStart(mean, std) if std > 0.0 else SingleStart(mean)


def boltzmann_reforming(temperature: float) -> Start:
    """R(x) ~ exp(-x²/2T), the normal law of width T^(1/2) = (k_BT/<k>)^(1/2) about x = 0 (paper, Sec. IV).

    temperature : k_BT/<k>, a length squared. With linked stiffness the width is that of <k> too, since a contact's
    stretch is drawn before its threshold, on which k_i depends. Raises InputError unless it is finite and above zero.
    """
    return gaussian_start(0.0, float(np.sqrt(positive("temperature", temperature, TEMPERATURE))))


def as_start(start: object, name: str = "start") -> Start:
    """None (x = 0), a number, a Start or a continuous scipy.stats distribution, as a Start; messages use `name`."""
    if start is None:
        return SingleStart(0.0)
    if isinstance(start, Start):
        return start
    if isinstance(start, int | float | np.number) and not isinstance(start, bool):
        return SingleStart(finite(name, start))
    if (frozen := as_frozen(start)) is None:
        refuse(name, start, "must be None, a stretch, a Start or a frozen scipy.stats distribution")
    mean = single_mean(name, frozen)
    if not np.isfinite(mean):
        raise InputError(f"{name}: the mean of the distribution is {mean}; it must be finite")
    ends = np.array(frozen.support(), dtype=float)
    furthest = np.array([frozen.ppf(1e-16), frozen.isf(1e-16)])
    lower, upper = np.where(np.isfinite(ends), ends, furthest).tolist()
    found = Start(mean, (lower, upper), jumps_of(frozen))
    for method in ("pdf", "cdf", "sf", "ppf", "isf"):
        setattr(found, method, getattr(frozen, method))
    return found


class FormationLaw:
    """Stretches from `law`, each with a threshold from P_c conditional on x_s > |x|.

    This is the state of the contacts that hold at X = 0, and of broken contacts as they re-form.

    law : of the stretches (lengths).
    cut_weight : weight of the law where the survival of thresholds is 0 or below 1e-300, which is cut off.

    Raises InputError, with `name` in its message, where this weight is above 1e-6: such contacts cannot hold.
    """

    def __init__(self, name: str, law: Start, thresholds: Thresholds) -> None:
        self.law, self._thresholds, self.cut_weight = law, thresholds, 0.0
        if float(thresholds.sf(max(abs(end) for end in law.span))) > 0.0:
            return
        furthest = thresholds.support()[1]
        furthest = furthest if np.isfinite(furthest) else float(thresholds.isf(1e-300))
        self.cut_weight = 1.0 if law.is_single else float(law.cdf(-furthest) + law.sf(furthest))
        if self.cut_weight > 1e-6:  # the same limit as for thresholds below 0
            beyond = f"beyond every threshold, at |x| >= {furthest:.6g}; use stretches below it"
            raise InputError(f"{name}: a weight of {self.cut_weight:.3g} lies {beyond}")

    def draw(self, size: int, generator: np.random.Generator) -> tuple[Array, Array]:
        """Independent stretches and thresholds (lengths), shapes (size,); those beyond every threshold drawn again."""
        x, beyond = np.full(size, self.law.mean()), np.full(size, not self.law.is_single)
        while beyond.any():
            x[beyond] = self.law.ppf(generator.random(int(beyond.sum())))
            beyond = np.abs(x) >= self._thresholds.support()[1]
        survival = self._thresholds.sf(np.abs(x)) * (1.0 - generator.random(size))
        return x, np.maximum(self._thresholds.isf(survival), np.abs(x))
