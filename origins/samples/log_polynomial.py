"""Densities whose logarithm is a polynomial plus m log x, so that P_c may begin as x^m.

Legendre polynomials are smooth everywhere: splines would have knots that solvers must resolve. For thresholds over
decades the variable is log(1 + x/median), and a term in x is added to the polynomial.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import legendre

from origins.thresholds.law import Array, Thresholds


@dataclass(frozen=True)
class Form:
    """The terms of a log-density, and its continuation beyond the extreme samples.

    from_zero : straight in x from the first sample down to x = 0; else P_c has an edge at the first sample.
    power : m log x is added.
    open_above : straight in x beyond the last sample, an exponential tail; else P_c has an edge there.
    decades : a polynomial of log(1 + x/median) with x added; else a polynomial of x.
    """

    from_zero: bool = True
    power: bool = False
    open_above: bool = True
    decades: bool = False


class LogPolynomial(Thresholds):
    """The law of one form: log P_c is a sum of columns, each times its coefficient, and a constant.

    The columns are Legendre polynomials of degree 1, 2, ..., then x (Form.decades), then log x (Form.power), all
    continued as straight lines beyond the extreme samples; they take x in units of the samples' median.

    extremes, unit : the first and the last sample, and the median (lengths).
    coefficients : of the columns; to be fitted, and with them
    score : log-likelihood minus the cost of the parameters.
    beyond : weights below the first sample and above the last.
    """

    coefficients: Array
    score: float
    beyond: tuple[float, float]

    def __init__(self, form: Form, extremes: tuple[float, float], degree: int, unit: float) -> None:
        self.form, self.degree, self._extremes, self._unit = form, degree, extremes, unit
        self.first, self.last = (end / unit for end in extremes)
        low, high = self._variable(np.array([self.first, self.last]))
        self._middle, self._half = 0.5 * (low + high), 0.5 * (high - low)
        order = np.arange(1, degree + 1)
        steep = order * (order + 1) / (2.0 * self._half)
        bent = (1.0 + self.first, 1.0 + self.last) if form.decades else (1.0, 1.0)
        self._first_slope, self._last_slope = -steep * (-1.0) ** order / bent[0], steep / bent[1]

    def support(self) -> tuple[float, float]:
        first, last = self._extremes
        return 0.0 if self.form.from_zero else first, np.inf if self.form.open_above else last

    @property
    def breakpoints(self) -> Array:
        return np.unique([end for end in (*self.support(), *self._extremes) if np.isfinite(end)])

    def _log_weight(self, x: Array) -> Array:
        # no product of matrices: each value has the same bits whatever the other x
        return (self.rows(x / self._unit) * self.coefficients).sum(axis=-1)

    def _variable(self, x: Array) -> Array:
        return np.log1p(x) if self.form.decades else x

    def rows(self, x: Array) -> Array:
        """Values of the columns at x, shape (..., columns)."""
        y = (self._variable(np.clip(x, self.first, self.last)) - self._middle) / self._half
        below, above = np.minimum(x - self.first, 0.0), np.maximum(x - self.last, 0.0)
        bent = np.multiply.outer(below, self._first_slope)
        bent += np.multiply.outer(above, self._last_slope)
        parts = [legendre.legvander(y, self.degree)[..., 1:] + bent]
        if self.form.decades:
            parts.append(x[..., None])
        if self.form.power:
            with np.errstate(divide="ignore"):
                parts.append((np.log(np.minimum(x, self.last)) + above / self.last)[..., None])
        return np.concatenate(parts, axis=-1)

    def end_slope(self) -> Array:
        """Slopes of the columns beyond the last sample."""
        more = [1.0] * self.form.decades + [1.0 / self.last] * self.form.power
        return np.append(self._last_slope, more)

    def grid(self) -> Array:
        """Points of x from the first sample to the last, between which the log-density is nearly straight."""
        y = -np.cos(np.linspace(0.0, np.pi, 2 * self.degree + 9))
        x = self._middle + self._half * y
        if self.form.decades:
            even = 0.5 * (self.first + self.last + (self.last - self.first) * y)
            x = np.append(np.expm1(x), even)
        return np.unique(np.clip([*x, self.first, self.last], self.first, self.last))

    def penalty(self) -> Array:
        """Matrix of the integral of the squared third derivative by y over (-1, 1)."""
        nodes, weights = legendre.leggauss(self.degree + 1)
        bends = legendre.legval(nodes, legendre.legder(np.eye(self.degree + 1), 3, axis=0))[1:]
        out = np.zeros((self.end_slope().size,) * 2)
        out[: self.degree, : self.degree] = (bends * weights) @ bends.T / self.degree
        return out
