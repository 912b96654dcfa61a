"""The law that a logspline fit stands for."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.special import exprel, hyp1f1

from origins.samples.likelihood import Ends
from origins.samples.logspline import Fit
from origins.samples.spline import Places
from origins.thresholds.inversion import invert_hazard
from origins.thresholds.law import Array, Thresholds

Flags = npt.NDArray[np.bool_]

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(10)
_NODES, _WEIGHTS = 0.5 * (_NODES + 1.0), 0.5 * _WEIGHTS
# change of the log-density and factor of y over a panel that the nodes integrate to round-off
_STEEPEST, _WIDEST = 3.0, 1.5
_STEPS = 4
_CHUNK = 1 << 15  # points whose nodes are in memory at once
_NOTHING = 800.0  # log-density this far below the highest


@dataclass(frozen=True)
class Variable:
    """y(x) = (x - origin)/scale; its log(1 + y) where `bent`, for thresholds over many decades."""

    origin: float
    scale: float
    bent: bool

    def __call__(self, x: Array) -> Array:
        u = (x - self.origin) / self.scale
        return np.log1p(u) if self.bent else u

    def inverse(self, y: Array) -> Array:
        """x(y)."""
        return self.origin + self.scale * (np.expm1(y) if self.bent else y)

    def log_slope(self, x: Array) -> Array:
        """log dy/dx."""
        slope = np.full(np.shape(x), -np.log(self.scale))
        return slope - np.log1p((x - self.origin) / self.scale) if self.bent else slope


class Smoothed(Thresholds):
    """Density y^m exp(spline(y)) dy/dx between the extreme samples, beyond them as the fit's `ends` say.

    Attributes
    ----------
    beyond : (float, float)
        Weight below the first sample and above the last.
    extremes : (float, float)
        The first and the last sample.
    """

    def __init__(
        self, fit: Fit, variable: Variable, ends: Ends, extremes: tuple[float, float], onset_power_error: float
    ) -> None:
        """extremes : the first and the last sample."""
        self._variable = variable
        self.onset_power, self.onset_power_error = fit.power, onset_power_error
        knots = fit.spline.knots
        self._left, self._right = _panels(fit)
        self._spline = fit.spline.lowered(float(fit.spline.heights.max()))
        self._powers = self._spline.powers(self._left)
        fall = fit.spline.slopes[1] + (fit.power / knots[-1] if fit.power else 0.0) - ends.bent
        weights = np.zeros(self._left.size + 2)
        weights[1:-1] = self._integral(np.arange(self._left.size), self._left, self._right)
        if ends.from_zero:
            weights[0] = self._lower(knots[:1])[0]
        if ends.open_above:
            weights[-1] = np.exp(self._log_density(knots[-1:])[0]) / -fall
        whole = float(weights.sum())
        self._spline = self._spline.lowered(float(np.log(whole)))
        self._powers[0] -= np.log(whole)
        weights /= whole
        self.beyond = float(weights[0]), float(weights[-1])
        self._below, self._above = np.cumsum(weights)[:-1], np.cumsum(weights[::-1])[-2::-1]
        with np.errstate(divide="ignore"):
            self._hazards = np.where(self._below < 0.5, -np.log1p(-np.minimum(self._below, 0.5)), -np.log(self._above))
        self.extremes = self._first, self._last = extremes
        places = np.concatenate([[self._first], variable.inverse(fit.joints[1:-1]), [self._last]])
        self._rate = -fall * float(np.exp(variable.log_slope(places[-1:])[0]))
        self._support = 0.0 if ends.from_zero else self._first, np.inf if ends.open_above else self._last
        # two knots make a straight line, three a parabola
        marks = {2: places[:0], 3: places[[0, -1]]}.get(fit.joints.size, places)
        if fit.power or variable.bent or not ends.open_above:
            marks = np.union1d(marks, places[-1:])
        self._marks = np.union1d(marks, self._support[:1])

    def support(self) -> tuple[float, float]:
        return self._support

    @property
    def breakpoints(self) -> Array:
        return self._marks.copy()

    def _log_density(self, y: Array) -> Array:
        """log of the density in y, up to the last sample."""
        if not self.onset_power:
            return self._spline(y)
        with np.errstate(divide="ignore"):
            return self._spline(y) + self.onset_power * np.log(y)

    def _integral(self, panel: Places, start: Array, stop: Array) -> Array:
        """Integral of the density over y from start to stop, both inside their panel."""
        out = np.empty(start.shape)
        for first in range(0, start.size, _CHUNK):
            part = slice(first, first + _CHUNK)
            left, width = self._left[panel[part], None], (stop - start)[part, None]
            away = start[part, None] - left + width * _NODES
            c0, c1, c2, c3 = self._powers[:, panel[part], None]
            log = c0 + away * (c1 + away * (c2 + away * c3))
            if self.onset_power:
                log += self.onset_power * np.log(left + away)
            out[part] = (np.exp(log) * _WEIGHTS).sum(axis=1) * width[:, 0]
        return out

    def _lower(self, y: Array) -> Array:
        """Weight below y under the first sample: integral of z^m exp(a + bz) over z from 0 to y."""
        m, rise = self.onset_power, self._spline.slopes[0] * y
        rest = hyp1f1(1.0, m + 2.0, -rise) if m else exprel(-rise)
        return y ** (m + 1.0) / (m + 1.0) * np.exp(self._spline(y)) * rest

    def _sides(self, x: Array) -> tuple[Flags, Flags, Flags]:
        low, high = x < self._first, x > self._last
        return low, high, ~(low | high)

    def _logpdf(self, x: Array) -> Array:
        within = np.minimum(x, self._last)
        out = self._log_density(self._variable(within)) + self._variable.log_slope(within)
        return out - self._rate * (x - within)

    def _pdf(self, x: Array) -> Array:
        return np.exp(self._logpdf(x))

    def _place(self, x: Array) -> tuple[Array, Places]:
        y = np.clip(self._variable(x), self._left[0], self._right[-1])
        return y, np.searchsorted(self._left[1:], y, side="right")

    def _cdf(self, x: Array) -> Array:
        out = np.empty(x.shape)
        low, high, inside = self._sides(x)
        out[low] = self._lower(self._variable(x[low]))
        out[high] = 1.0 - self._upper(x[high])
        y, at = self._place(x[inside])
        out[inside] = self._below[at] + self._integral(at, self._left[at], y)
        return np.minimum(out, 1.0)

    def _sf(self, x: Array) -> Array:
        out = np.empty(x.shape)
        low, high, inside = self._sides(x)
        out[low] = 1.0 - self._lower(self._variable(x[low]))
        out[high] = self._upper(x[high])
        y, at = self._place(x[inside])
        out[inside] = self._above[at + 1] + self._integral(at, y, self._right[at])
        return np.minimum(out, 1.0)

    def _upper(self, x: Array) -> Array:
        """Weight above x over the last sample."""
        return self._above[-1] * np.exp(-self._rate * (x - self._last))

    def _logsf(self, x: Array) -> Array:
        out = super()._logsf(np.minimum(x, self._last))
        return out - self._rate * np.maximum(x - self._last, 0.0)

    def _from_hazard(self, hazard: Array) -> Array:
        goal = hazard.ravel()
        out = np.empty(goal.shape)
        place = np.searchsorted(self._hazards, goal, side="right") - 1
        low, high = place < 0, place >= self._left.size
        inside = ~(low | high)
        between = self._variable.inverse(self._in_panels(place[inside], goal[inside]))
        out[inside] = np.clip(between, self._first, self._last)
        if high.any():
            out[high] = self._last + (goal[high] - self._hazards[-1]) / self._rate
        if low.any():
            share = -np.expm1(-goal[low]) / self._below[0]
            steepness = 1.0 + self.onset_power + max(self._spline.slopes[0] * self._left[0], 0.0)
            guess = self._variable.inverse(self._left[0] * share ** (1.0 / steepness))
            ends = np.zeros(guess.shape), np.full(guess.shape, self._first)
            out[low] = invert_hazard(self, goal[low], *ends, guess)
        return out.reshape(hazard.shape)

    def _in_panels(self, at: Places, hazard: Array) -> Array:
        """y where -log of the survival is `hazard`, by Newton's method inside the panels `at`."""
        left, right = self._left[at], self._right[at]
        upper = hazard > np.log(2.0)
        with np.errstate(divide="ignore"):
            wanted = np.where(upper, np.exp(-hazard) - self._above[at + 1], -np.expm1(-hazard) - self._below[at])
        mass = np.where(upper, self._above[at] - self._above[at + 1], self._below[at + 1] - self._below[at])
        share = np.clip(wanted / np.maximum(mass, 1e-300), 0.0, 1.0)
        # at first as if the log-density were straight
        rise = self._log_density(right) - self._log_density(left)
        rise = np.where(np.abs(rise) > 1e-6, np.where(upper, -rise, rise), 1e-6)
        share = np.log1p(share * np.expm1(rise)) / rise
        y = np.where(upper, right - (right - left) * share, left + (right - left) * share)
        for _ in range(_STEPS):
            found = self._integral(at, np.where(upper, y, left), np.where(upper, right, y))
            miss = np.where(upper, found - wanted, wanted - found)
            with np.errstate(divide="ignore", invalid="ignore"):
                step = miss / np.exp(self._log_density(y))
            y = np.clip(y + np.where(np.isfinite(step), step, 0.0), left, right)
        return y


def _panels(fit: Fit) -> tuple[Array, Array]:
    """Ends (left, right) of panels between the outermost knots, such that the density changes little over each, or
    next to nothing is there."""
    knots = fit.spline.knots
    left, right = knots[:-1], knots[1:]
    top = float(fit.spline.heights.max())
    done = []
    while left.size:
        width = right - left
        level, slope, bend, turn = fit.spline.powers(left) * width ** np.arange(4.0)[:, None]
        slope, bend, turn = np.abs(slope), np.abs(bend), np.abs(turn)
        rough = (slope + 2.0 * bend + 3.0 * turn > _STEEPEST) | (bend + 3.0 * turn > 1.0)
        if fit.power:
            rough |= right > _WIDEST * left
        rough &= level + slope + bend + turn > top - _NOTHING
        done.append(left[~rough])
        left, right, width = left[rough], right[rough], width[rough]
        middle = left + 0.5 * width
        left, right = np.concatenate([left, middle]), np.concatenate([middle, right])
    edges = np.append(np.sort(np.concatenate(done)), knots[-1])
    return edges[:-1], edges[1:]
