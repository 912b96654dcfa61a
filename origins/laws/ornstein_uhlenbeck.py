"""Diffusion in a parabola: the exact transition of thresholds that age towards a normal law."""

import numpy as np
import numpy.typing as npt
from scipy.special import ndtr

from origins.errors import finite, non_negative, positive, refuse

Array = npt.NDArray[np.float64]


class OrnsteinUhlenbeck:
    """dx = λ (mean - x) dt + std (2λ)^(1/2) dW: from x(0) = x0 the normal law of mean_after and std_after.

    Parameters
    ----------
    mean, std : float
        Of the normal law that is reached in the end, lengths.
    rate : float
        λ, per time.

    Raises InputError unless mean is finite, std finite and above zero, rate finite and not negative. Methods take
    arrays that broadcast: values x and x0 (lengths) and times >= 0.
    """

    def __init__(self, mean: float, std: float, rate: float) -> None:
        self.mean, self.std, self.rate = finite("mean", mean), positive("std", std), non_negative("rate", rate)

    def mean_after(self, x0: npt.ArrayLike, time: npt.ArrayLike) -> Array:
        """mean + (x0 - mean) e^(-λt), a length."""
        x0 = np.asarray(x0, dtype=float)
        return x0 - (self.mean - x0) * np.expm1(-self.rate * _checked(time))

    def std_after(self, time: npt.ArrayLike) -> Array:
        """std (1 - e^(-2λt))^(1/2), a length."""
        return self.std * np.sqrt(-np.expm1(-2.0 * self.rate * _checked(time)))

    def draw(self, x0: npt.ArrayLike, time: npt.ArrayLike, normal: npt.ArrayLike) -> Array:
        """Value after `time`, from standard normal draws; exact over any time."""
        return self.mean_after(x0, time) + self.std_after(time) * np.asarray(normal, dtype=float)

    def pdf(self, x: npt.ArrayLike, x0: npt.ArrayLike, time: npt.ArrayLike) -> Array:
        """Transition density, per length. InputError where λ t = 0: there the law is one value."""
        width = self._width(time)
        z = (np.asarray(x, dtype=float) - self.mean_after(x0, time)) / width
        return np.exp(-0.5 * z * z) / (width * np.sqrt(2.0 * np.pi))

    def cdf(self, x: npt.ArrayLike, x0: npt.ArrayLike, time: npt.ArrayLike) -> Array:
        """Probability of at most x. InputError where λ t = 0."""
        return ndtr((np.asarray(x, dtype=float) - self.mean_after(x0, time)) / self._width(time))

    def sf(self, x: npt.ArrayLike, x0: npt.ArrayLike, time: npt.ArrayLike) -> Array:
        """Probability of more than x, accurate where it is tiny. InputError where λ t = 0."""
        return ndtr((self.mean_after(x0, time) - np.asarray(x, dtype=float)) / self._width(time))

    def _width(self, time: npt.ArrayLike) -> Array:
        width = self.std_after(time)
        if not (width > 0.0).all():
            early = np.asarray(time, dtype=float)[width == 0.0].flat[0]
            refuse("time", early, f"at the rate {self.rate:g} the value has not spread yet; use a later time, or draw")
        return width


def _checked(time: npt.ArrayLike) -> Array:
    times = np.asarray(time, dtype=float)
    if not (times >= 0.0).all():
        refuse("time", times[~(times >= 0.0)].flat[0], "must be zero or above")
    return times
