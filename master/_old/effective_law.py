"""A law of thresholds known by a table: survival of contacts that age, or break early, as if of thresholds alone.

Where the chance p(x) dx that a contact born at x = 0 breaks at the stretch x is all that counts, as in steady forward
motion, contacts that age or break at a rate are those of this law at rest and at T = 0.
"""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from master._old.piecewise import Piecewise, tabulate
from origins.errors import InputError, finite_array, non_negative, refuse
from origins.thresholds.law import Array, Thresholds
from origins.thresholds.quadrature import gauss

_MISFIT = 1e-6
_SPENT = 45.0  # e-foldings of the survival after which nothing counts
_TAIL_PANELS = 24
_NONE = np.empty(0)


class EffectiveLaw(Thresholds):
    """Thresholds whose density is a table of Legendre series, and beyond it a Gaussian tail.

    Parameters
    ----------
    series : Piecewise
        The density over s = (x - lower)^(1/2), that is 2 s p(x), smooth where p(x) rises as a power of s; with `root`
        False the density over s = x - lower, p(x) itself. It begins at s = 0.
    lower : float
        Lower end of the support (a length).
    root : bool
    beyond : float
        Survival where the table ends; 0: nothing lies beyond.
    hazard, slope : float
        There: p/E per length, and its derivative in x. Beyond, E(x) = beyond exp(-hazard u - slope u²/2), u counted
        from the end.
    onset_power : float
    poles : array
        Where else than at the lower end the density diverges (lengths), increasing.

    Both cdf and survival are sums of what lies on their side of x. They are as accurate as the table: to some 1e-15,
    not relative to a survival of 1e-15.
    """

    def __init__(
        self,
        series: Piecewise,
        lower: float = 0.0,
        root: bool = True,
        beyond: float = 0.0,
        hazard: float = 0.0,
        slope: float = 0.0,
        onset_power: float = np.inf,
        poles: Array = _NONE,
    ) -> None:
        self._series, self._lower, self._root, self._poles = series, float(lower), root, poles
        self._mirrored = mirrored(series)
        self._beyond, self._hazard, self._slope = beyond, hazard, max(slope, 0.0)
        self._last = self._at(float(series.edges[-1]))
        self.onset_power = onset_power
        # what rounding left out of the whole
        self._scale = (1.0 - beyond) / series.total
        self._nodes, self._weights = self._panels()

    def support(self) -> tuple[float, float]:
        return self._lower, np.inf if self._beyond > 0.0 else self._last

    @property
    def breakpoints(self) -> Array:
        ends = [self._lower] if self._beyond > 0.0 else [self._lower, self._last]
        return np.array([*ends[:1], *self._poles, *ends[1:]])

    @property
    def panels(self) -> Array:
        """Ends of the table's panels (lengths), close where the density changes fast."""
        s = self._series.edges
        edges = self._lower + (s * s if self._root else s)
        return np.unique(edges) if self._lower > 0.0 else edges  # closer to the lower end than x is known

    def _at(self, s: float) -> float:
        return self._lower + (s * s if self._root else s)

    def _place(self, x: Array) -> Array:
        return np.sqrt(x - self._lower) if self._root else x - self._lower

    def _pdf(self, x: Array) -> Array:
        s = self._place(x)
        out = np.maximum(self._scale * self._series(s), 0.0)
        if self._root:
            with np.errstate(divide="ignore", invalid="ignore"):
                out = np.where((s > 0.0) | (out > 0.0), out / (2.0 * s), 0.0)
        far = x > self._last
        if far.any():
            u = x[far] - self._last
            out[far] = self._tail(u) * (self._hazard + self._slope * u)
        return out

    def _cdf(self, x: Array) -> Array:
        out = self._scale * self._series.integral(self._place(x))
        far = x > self._last
        if far.any():
            out[far] = 1.0 - self._tail(x[far] - self._last)
        return np.clip(out, 0.0, 1.0)

    def _sf(self, x: Array) -> Array:
        out = self._beyond + self._scale * self._mirrored.integral(-self._place(x))
        far = x > self._last
        if far.any():
            out[far] = self._tail(x[far] - self._last)
        return np.clip(out, 0.0, 1.0)

    def _logsf(self, x: Array) -> Array:
        out = super()._logsf(x)
        far = x > self._last
        if far.any():
            u = x[far] - self._last
            out[far] = np.log(self._beyond) - self._hazard * u - 0.5 * self._slope * u * u
        return out

    def _logpdf(self, x: Array) -> Array:
        out = super()._logpdf(x)
        far = x > self._last
        if far.any():
            u = x[far] - self._last
            out[far] = self._logsf(x[far]) + np.log(self._hazard + self._slope * u)
        return out

    def _bracket(self, hazard: float) -> tuple[float, float]:
        if self._beyond == 0.0 or hazard <= -np.log(self._beyond):
            return self._lower, self._last
        # the Gaussian tail only shortens what the constant hazard needs
        return self._lower, self._last + 1.01 * (hazard + np.log(self._beyond)) / self._hazard

    def _tail(self, u: Array) -> Array:
        return self._beyond * np.exp(-self._hazard * u - 0.5 * self._slope * u * u)

    def _panels(self) -> tuple[Array, Array]:
        """Stretches and weights that turn a sum into a mean over the law; the series come out exactly."""
        s, factors = gauss_panels(self._series.edges)
        nodes = [self._lower + (s * s if self._root else s)]
        weights = [self._scale * factors * self._series(s)]
        if self._beyond > 0.0:
            edges = self._last + np.linspace(0.0, _SPENT, _TAIL_PANELS + 1) / self._hazard
            far, width = (array.ravel() for array in gauss(edges[:-1], edges[1:]))
            nodes.append(far)
            weights.append(width * self._pdf(far))
        return np.concatenate(nodes), np.concatenate(weights)

    def _moment(self, n: int) -> float:
        return float((self._weights * self._nodes**n).sum())

    def _variance(self) -> float:
        return float((self._weights * (self._nodes - self.mean()) ** 2).sum())


def effective_law(
    density: Callable[[Array], Array],
    edges: npt.ArrayLike,
    beyond: float = 0.0,
    hazard: float = 0.0,
    slope: float = 0.0,
    onset_power: float = np.inf,
    root: bool = True,
) -> EffectiveLaw:
    """The law whose density per length is `density`, tabulated between edges[0] and edges[-1].

    Parameters
    ----------
    density : callable
        p at stretches of any shape (lengths), shape kept.
    edges : array of shape (n,)
        Increasing stretches, n >= 2: the support's lower end, points where p jumps or bends, and where the table ends.
    beyond, hazard, slope, onset_power, root
        As for EffectiveLaw; `beyond` is the survival at edges[-1], and `hazard` must be above zero where it is.

    Raises InputError for edges that do not increase, and where the weight found differs from 1 by more than 1e-6.
    """
    points = finite_array("edges", edges)
    if points.size < 2 or not (np.diff(points) > 0.0).all():
        refuse("edges", points, "must be at least two stretches that increase")
    non_negative("beyond", beyond)
    if beyond > 0.0 and not hazard > 0.0:
        refuse("hazard", hazard, "must be above zero where survival is left beyond the table")
    lower = float(points[0])

    def over_s(s: Array) -> Array:
        return (2.0 * s * density(lower + s * s) if root else density(lower + s))[None]

    seeds = np.sqrt(points - lower) if root else points - lower
    series = tabulate(over_s, seeds)[0]
    if not abs(series.total + beyond - 1.0) < _MISFIT:
        raise InputError(
            f"density: has a weight of {series.total:.6g} between {lower:g} and {points[-1]:g}, and {beyond:.3g} lies "
            "beyond: together they must be 1"
        )
    return EffectiveLaw(series, lower, root, beyond, hazard, slope, onset_power)


def mirrored(series: Piecewise) -> Piecewise:
    """The same function of -s."""
    signs = np.where(np.arange(series.coefficients.shape[0]) % 2, -1.0, 1.0)
    return Piecewise(-series.edges[::-1], signs[:, None] * series.coefficients[:, ::-1])


def gauss_panels(edges: Array) -> tuple[Array, Array]:
    """Sixteen Gauss-Legendre nodes and weights on each panel, flat."""
    x, w = np.polynomial.legendre.leggauss(16)
    half = 0.5 * np.diff(edges)[:, None]
    return (edges[:-1, None] + half * (x + 1.0)).ravel(), (half * w).ravel()
