"""The law that a logspline fit stands for."""

from dataclasses import dataclass

import numpy as np

from origins.samples.likelihood import Ends
from origins.samples.logspline import Fit
from origins.thresholds.law import Array, Thresholds


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
    extremes : (float, float)
        The first and the last sample.
    """

    def __init__(
        self,
        fit: Fit,
        variable: Variable,
        ends: Ends,
        extremes: tuple[float, float],
        onset_power_error: float,
    ) -> None:
        self._variable = variable
        self.onset_power, self.onset_power_error = fit.power, onset_power_error
        self._spline = fit.spline.lowered(float(fit.spline.heights.max()))
        self.extremes = self._first, self._last = extremes
        places = np.concatenate([[self._first], variable.inverse(fit.joints[1:-1]), [self._last]])
        fall = (
            fit.spline.slopes[1]
            + (fit.power / fit.spline.knots[-1] if fit.power else 0.0)
            - ends.bent
        )
        self._rate = -fall * float(np.exp(variable.log_slope(places[-1:])[0]))
        self._support = (
            0.0 if ends.from_zero else self._first,
            np.inf if ends.open_above else self._last,
        )
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

    def _log_weight(self, x: Array) -> Array:
        within = np.minimum(x, self._last)
        y = self._variable(within)
        out = self._spline(y) + self._variable.log_slope(within) - self._rate * (x - within)
        if self.onset_power:
            with np.errstate(divide="ignore"):
                out += self.onset_power * np.log(y)
        return out
