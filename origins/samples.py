"""Thresholds from your own values, from molecular dynamics or from an experiment."""

import numpy as np
import numpy.typing as npt

from origins.errors import InputError, finite_array, positive, refuse
from origins.identical import identical
from origins.inversion import invert_hazard
from origins.quadrature import NODES, gauss
from origins.thresholds import Array, Thresholds

_MOST_CELLS = 39
_DOUBT = 0.05


def from_samples(
    x_s: npt.ArrayLike | None = None,
    *,
    f_s: npt.ArrayLike | None = None,
    coefficient: float | None = None,
    stiffness: float | None = None,
) -> Thresholds:
    """A smooth P_c through threshold values of your own; one value, or all equal, gives identical().

    x_s : array of shape (n,), lengths above zero; or instead of it
    f_s : array of shape (n,), forces above zero, turned into lengths either by the paper's quadratic law
        f_s = coefficient * x_s^2 (coefficient in force per length^2) or at fixed stiffness, x_s = f_s / stiffness.

    The result carries its sampling error: `n_samples`, `cdf_error`, `cdf_misfit` (see Sampled).
    Raises InputError for values that are missing, not finite or not above zero, and unless exactly one of x_s and
    f_s, and for f_s exactly one of the two laws, is given.
    """
    if (x_s is None) == (f_s is None):
        raise InputError("from_samples: give either x_s, the thresholds as lengths, or f_s, as forces, and not both")
    if x_s is not None:
        for name, value in (("coefficient", coefficient), ("stiffness", stiffness)):
            if value is not None:
                refuse(name, value, "turns forces f_s into lengths; leave it out with x_s")
        return _from_lengths(_above_zero("x_s", x_s))
    forces = _above_zero("f_s", f_s)
    if (coefficient is None) == (stiffness is None):
        raise InputError(
            "from_samples: with f_s give either coefficient, for f_s = coefficient * x_s^2, or stiffness, for "
            "x_s = f_s / stiffness, and not both"
        )
    if coefficient is not None:
        return _from_lengths(np.sqrt(forces / positive("coefficient", coefficient)))
    return _from_lengths(forces / positive("stiffness", stiffness))


def _above_zero(name: str, value: object) -> Array:
    array = finite_array(name, value)
    bad = np.flatnonzero(array <= 0.0)
    if bad.size:
        refuse(f"{name}[{bad[0]}]", array[bad[0]], "must be above zero: a contact holds until its threshold")
    return array


def _from_lengths(lengths: Array) -> Thresholds:
    lengths = np.sort(lengths)
    if lengths[0] == lengths[-1]:
        return identical(float(lengths[0]))
    return Sampled(lengths)


class Sampled(Thresholds):
    """Monotone cubic (PCHIP) cdf through a few quantiles of the samples; the density is continuous.

    About 2 n^(1/3) cells between the smallest and the largest sample, at most 39, denser towards both ends; no
    weight lies outside. Equal samples count as one value known to the distance of its neighbours.

    Attributes
    ----------
    n_samples : int
    cdf_error : float
        The cdf of the law the samples came from lies within this of their empirical cdf, everywhere at once, with
        95 % confidence (Dvoretzky, Kiefer, Wolfowitz).
    cdf_misfit : float
        Largest distance of this smooth cdf from the empirical one.
    """

    def __init__(self, ordered: Array) -> None:
        self.n_samples = ordered.size
        self.cdf_error = float(np.sqrt(np.log(2.0 / _DOUBT) / (2.0 * ordered.size)))
        values, first, counts = np.unique(ordered, return_index=True, return_counts=True)
        # the share below a value, from 0 at the smallest to 1 at the largest, and the share above it
        rank = first + 0.5 * (counts - 1)
        rank[0], rank[-1] = 0.0, ordered.size - 1.0
        cells = int(min(np.round(2.0 * np.cbrt(ordered.size)), ordered.size - 1, _MOST_CELLS))
        wanted = 0.5 * (1.0 - np.cos(np.pi * np.arange(cells + 1) / cells)) * rank[-1]
        picked = np.unique(np.searchsorted(rank, np.round(wanted)).clip(0, rank.size - 1))
        self._knots = values[picked]
        self._below = rank[picked] / rank[-1]
        self._above = (rank[-1] - rank[picked]) / rank[-1]
        self._width = np.diff(self._knots)
        self._share = np.diff(rank[picked]) / rank[-1]
        slopes = _monotone_slopes(self._width, self._share / self._width)
        # Bernstein coefficients of the cdf in each cell; 0 to 1 by the slopes' limits, so that sums never cancel
        self._start = np.minimum(slopes[:-1] * self._width / (3.0 * self._share), 1.0)
        self._end = np.minimum(slopes[1:] * self._width / (3.0 * self._share), 1.0)
        self.onset_power = 0.0 if self._start[0] > 0.0 else 1.0 if self._end[0] < 1.0 else 2.0
        steps = np.stack([first, first + counts]) / ordered.size
        self.cdf_misfit = float(np.abs(self.cdf(values) - steps).max())

    def support(self) -> tuple[float, float]:
        return float(self._knots[0]), float(self._knots[-1])

    @property
    def breakpoints(self) -> Array:
        return self._knots.copy()

    def _place(self, x: Array) -> tuple[npt.NDArray[np.intp], Array, Array]:
        """Cell, and the fractions of it below and above x."""
        cell = np.clip(np.searchsorted(self._knots, x, side="right") - 1, 0, self._width.size - 1)
        return cell, (x - self._knots[cell]) / self._width[cell], (self._knots[cell + 1] - x) / self._width[cell]

    def _pdf(self, x: Array) -> Array:
        cell, t, s = self._place(x)
        start, end = self._start[cell], self._end[cell]
        # the middle term may be negative, the sum never is
        shape = start * s * s + 2.0 * (1.0 - end - start) * s * t + end * t * t
        return 3.0 * self._share[cell] / self._width[cell] * np.maximum(shape, 0.0)

    def _cdf(self, x: Array) -> Array:
        cell, t, s = self._place(x)
        part = 3.0 * self._start[cell] * t * s * s + 3.0 * (1.0 - self._end[cell]) * t * t * s + t * t * t
        return np.minimum(self._below[cell] + self._share[cell] * part, 1.0)

    def _sf(self, x: Array) -> Array:
        cell, t, s = self._place(x)
        part = 3.0 * self._end[cell] * s * t * t + 3.0 * (1.0 - self._start[cell]) * s * s * t + s * s * s
        return np.minimum(self._above[cell + 1] + self._share[cell] * part, 1.0)

    def _from_hazard(self, hazard: Array) -> Array:
        flat = hazard.ravel()
        known = -np.log(np.maximum(self._above, 1e-320))
        cell = np.clip(np.searchsorted(known, flat, side="right") - 1, 0, self._width.size - 1)
        left, right = self._knots[cell] * (1.0 - 1e-14), self._knots[cell + 1] * (1.0 + 1e-14)
        left, right = np.maximum(left, self._knots[0]), np.minimum(right, self._knots[-1])
        return invert_hazard(self, flat, left, right, 0.5 * left + 0.5 * right).reshape(hazard.shape)

    def _moment(self, n: int) -> float:
        if n > 2 * NODES - 3:
            return super()._moment(n)
        return self._integral(n, 0.0)

    def _variance(self) -> float:
        return self._integral(2, self.mean())

    def _integral(self, n: int, centre: float) -> float:
        """<(x - centre)^n>, exact: the density is a parabola in each cell."""
        nodes, weights = gauss(self._knots[:-1], self._knots[1:])
        return float((weights * (nodes - centre) ** n * self._pdf(nodes)).sum())


def _monotone_slopes(width: Array, rise: Array) -> Array:
    """Slopes at the knots by Fritsch and Butland: harmonic means inside, one-sided parabolas at the two ends."""
    if rise.size == 1:
        return np.repeat(rise, 2)
    first, second = 2.0 * width[1:] + width[:-1], width[1:] + 2.0 * width[:-1]
    inner = (first + second) / (first / rise[:-1] + second / rise[1:])
    return np.concatenate([[_end_slope(*width[:2], *rise[:2])], inner, [_end_slope(*width[:-3:-1], *rise[:-3:-1])]])


def _end_slope(near: float, far: float, near_rise: float, far_rise: float) -> float:
    return max(((2.0 * near + far) * near_rise - near * far_rise) / (near + far), 0.0)
