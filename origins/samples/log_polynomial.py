"""Smooth densities through samples: the log-density is a polynomial, kept smooth by a penalty.

The penalty is the integral of the squared third derivative, so that samples alone decide the mean, the width and what
else a parabola can say, and each further bend must be paid for (B. W. Silverman, Ann. Stat. 10, 795, 1982; P. Eilers
and B. Marx, Stat. Sci. 11, 89, 1996). Beside the polynomial stand m log x, which makes P_c begin as x^m, and, for
thresholds over decades, x itself, which keeps the mean. Legendre polynomials leave no knots that a solver would meet.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial import legendre

from origins.errors import InputError
from origins.thresholds.law import Array, Thresholds

_MOST_DEGREE = 48  # a peak of 1/30 of the samples' reach is resolved
_PENALTIES = 10.0 ** np.arange(2.0, -12.5, -1.0)
_STRAIGHT = 1e6  # penalty that leaves no bend at all
_NO_BETTER = (
    6.0  # score (log-likelihood) by which a smaller penalty may be worse before the search ends
)
_EDGE = 3.0  # log-likelihood that an edge, a density that diverges at 0 or a long tail must gain beyond a parameter's
_SUSPECT = 1.5  # samples expected beyond the extreme one, above which an edge is tried there
_FAR = 8.0  # times the median: samples beyond it may be thresholds over decades
_NEAR_ZERO = 1.0 / 3.0  # of the median: only samples below it can tell a power x^m
_LARGE_POWER = (
    10.0  # m of this size costs 1/2 of the log-likelihood, so that m is known to be finite
)
_LONGEST = (
    0.5  # length of a tail (e-fold), of the last sample: one as heavy as x^-2 there, without a mean
)
_LEAST_POWER = -0.95  # nearer to 1/x nearly all weight would lie below what floating point holds
_OCTAVES = 40  # below the first sample, down to which integrals look at the density
_MEAN = 0.1  # standard errors by which a law's mean may be off where sums miss a peak between far samples
_ENDS = 16  # extreme samples, each an edge of panels: far ones may pull the density up between them
_CHUNK = 1 << 14  # samples whose rows are held at once
_STEPS, _DONE = 100, 1e-10  # Newton's, and the log-likelihood left to gain at its end
_NODES, _WEIGHTS = legendre.leggauss(8)
_NODES, _WEIGHTS = 0.5 * (_NODES + 1.0), 0.5 * _WEIGHTS
# along an exponential tail all rows are straight: two nodes are exact for value, gradient and curvature
_TAIL_NODES, _TAIL_WEIGHTS = np.polynomial.laguerre.laggauss(2)


def cost(size: float) -> float:
    """Penalty for each parameter, in log-likelihood: log(size)/2 (Schwarz) up to 55 samples, then 2, twice Akaike's.

    A larger one would leave biases of many standard errors in large samples.
    """
    return min(0.5 * float(np.log(size)), 2.0)


@dataclass(frozen=True)
class Form:
    """How a log-density is written, and how it goes on beyond the extreme samples.

    from_zero : straight in x from the first sample down to x = 0; else P_c has an edge at the first sample.
    power : m log x is added.
    open_above : straight in x beyond the last sample, an exponential tail; else P_c has an edge there.
    decades : a polynomial of log(1 + x/median) with x added; else a polynomial of x.
    """

    from_zero: bool = True
    power: bool = False
    open_above: bool = True
    decades: bool = False


class Columns:
    """The functions of x whose sum, each times its coefficient, is the log-density; x in units of the median.

    Legendre polynomials of degree 1, 2, ..., then x (Form.decades), then log x (Form.power). Between the extreme
    samples they are what they are called, beyond these straight lines.
    """

    def __init__(self, form: Form, first: float, last: float, degree: int) -> None:
        self.form, self.first, self.last, self.degree = form, first, last, degree
        low, high = self._variable(np.array([first, last]))
        self._middle, self._half = 0.5 * (low + high), 0.5 * (high - low)
        order = np.arange(1, degree + 1)
        steep = order * (order + 1) / (2.0 * self._half)
        bent = (1.0 + first, 1.0 + last) if form.decades else (1.0, 1.0)
        self._first_slope = -steep * (-1.0) ** order / bent[0]
        self._last_slope = steep / bent[1]

    def _variable(self, x: Array) -> Array:
        return np.log1p(x) if self.form.decades else x

    def grid(self) -> Array:
        """Points of x from the first sample to the last, between which the log-density is nearly straight."""
        y = -np.cos(np.linspace(0.0, np.pi, 2 * self.degree + 9))
        x = self._middle + self._half * y
        if self.form.decades:
            x = np.union1d(
                np.expm1(x), 0.5 * (self.first + self.last + (self.last - self.first) * y)
            )
        return np.concatenate([[self.first], x[(x > self.first) & (x < self.last)], [self.last]])

    def rows(self, x: Array) -> Array:
        """Values at x, shape (x.size, columns)."""
        inside = np.clip(x, self.first, self.last)
        y = (self._variable(inside) - self._middle) / self._half
        below, above = np.minimum(x - self.first, 0.0), np.maximum(x - self.last, 0.0)
        parts = [
            legendre.legvander(y, self.degree)[:, 1:]
            + np.outer(below, self._first_slope)
            + np.outer(above, self._last_slope)
        ]
        if self.form.decades:
            parts.append(x[:, None])
        if self.form.power:
            with np.errstate(divide="ignore"):
                parts.append((np.log(np.minimum(x, self.last)) + above / self.last)[:, None])
        return np.concatenate(parts, axis=1)

    def value(self, x: Array, coefficients: Array) -> Array:
        """rows(x) @ coefficients, shape as x; far out the same for the same x to the last bit."""
        inside = np.clip(x, self.first, self.last)
        below, above = np.minimum(x - self.first, 0.0), np.maximum(x - self.last, 0.0)
        y = (self._variable(inside) - self._middle) / self._half
        polynomial = coefficients[: self.degree]
        out = legendre.legval(y, np.append(0.0, polynomial))
        out += below * float(self._first_slope @ polynomial)
        out += above * float(self.end_slope() @ coefficients)
        if self.form.decades:
            out += coefficients[self.degree] * np.minimum(x, self.last)
        if self.form.power:
            with np.errstate(divide="ignore"):
                out += coefficients[-1] * np.log(np.minimum(x, self.last))
        return out

    def end_slope(self) -> Array:
        """Slopes of the columns beyond the last sample."""
        more = [1.0] * self.form.decades + [1.0 / self.last] * self.form.power
        return np.append(self._last_slope, more)

    def penalty(self) -> Array:
        """Matrix of the integral of the squared third derivative by y over (-1, 1)."""
        nodes, weights = legendre.leggauss(self.degree + 1)
        bends = legendre.legval(nodes, legendre.legder(np.eye(self.degree + 1), 3, axis=0))[1:]
        out = np.zeros((self.end_slope().size,) * 2)
        out[: self.degree, : self.degree] = (bends * weights) @ bends.T / self.degree
        return out


@dataclass(frozen=True)
class Fit:
    """The most likely density of one form; lengths in units of the median.

    score : log-likelihood less what the parameters cost; power_error : standard error of m;
    beyond : weights below the first sample and above the last.
    """

    columns: Columns
    coefficients: Array
    score: float
    power_error: float
    beyond: tuple[float, float]

    @property
    def power(self) -> float:
        """m of P_c ~ x^m."""
        return float(self.coefficients[-1]) if self.columns.form.power else 0.0


@dataclass(frozen=True)
class _State:
    """Penalised log-likelihood per sample at some coefficients, and what Newton's method needs there."""

    coefficients: Array
    value: float
    likelihood: float
    shares: Array
    rows: Array

    def covariance(self) -> Array:
        """Of the columns under the density: minus the curvature of the log-likelihood."""
        away = self.rows - self.shares @ self.rows
        return (away * self.shares[:, None]).T @ away


class Likelihood:
    """The penalised likelihood of one form for samples x (sorted, distinct, in units of their median) with `shares`
    (sum 1) that are worth `size` samples."""

    def __init__(self, x: Array, shares: Array, size: float, form: Form) -> None:
        self._size, self._form = size, form
        degree = int(np.clip(round(4.0 * size**0.3), 4, _MOST_DEGREE))
        self._columns = columns = Columns(form, float(x[0]), float(x[-1]), degree)
        starts = range(0, x.size, _CHUNK)
        self._mean: Array = np.sum(
            [shares[i : i + _CHUNK] @ columns.rows(x[i : i + _CHUNK]) for i in starts], axis=0
        )
        # where samples lie dense the density may change within little
        dense = np.linspace(0, x.size - 1, min(x.size, 4 * degree)).astype(int)
        edges = np.concatenate([columns.grid(), x[dense], x[:_ENDS], x[-_ENDS:]])
        edges = np.unique(np.append(edges, [columns.first, columns.last]))
        if form.from_zero:
            down = 0.5 ** np.arange(_OCTAVES + np.ceil(np.log2(columns.last / columns.first)))
            beside = columns.first * (1.0 - down[1:])
            edges = np.unique(np.concatenate([[0.0], columns.last * down, beside, edges]))
        width = np.diff(edges)[:, None]
        self._nodes = (edges[:-1, None] + width * _NODES).ravel()
        self._log_weights = np.log((width * _WEIGHTS).ravel())
        self._rows = columns.rows(self._nodes)
        self._end, self._slope = columns.rows(np.array([columns.last]))[0], columns.end_slope()
        self._ridge = np.zeros((self._mean.size,) * 2)
        if form.power:
            self._ridge[-1, -1] = _LARGE_POWER**-2 / size

    def best(self) -> Fit:
        """The fit of largest score, from a straight line on through ever smaller penalties."""
        start = np.zeros(self._mean.size)
        first = 0.0 if self._form.from_zero else self._columns.first
        at = self._columns.degree if self._form.decades else 0
        start[at] = -(self._slope[at] ** -1) / max(1.0 - first, 0.1) if at == 0 else -1.0
        best: Fit | None = None
        for penalty in self._penalties():
            state = self._newton(start, penalty + self._ridge)
            found, start = self._scored(state, penalty + self._ridge), state.coefficients
            if best is not None and found.score < best.score - _NO_BETTER:
                break
            best = found if best is None or found.score > best.score else best
        assert best is not None
        return best

    def _penalties(self) -> Iterator[Array]:
        bends = self._columns.penalty()
        bent = np.arange(1, self._columns.degree)
        straight = bends.copy()
        straight[bent, bent] += _STRAIGHT
        yield straight
        for penalty in _PENALTIES:
            yield penalty * bends

    def _state(self, coefficients: Array, penalty: Array) -> _State | None:
        """None where there is no density: its tail would not fall, or its power be below -0.95."""
        log, rows = self._rows @ coefficients + self._log_weights, self._rows
        if self._form.power and coefficients[-1] <= _LEAST_POWER:
            return None
        if self._form.open_above:
            rise = float(self._slope @ coefficients)
            if rise >= 0.0:
                return None
            rows = np.concatenate([rows, self._end - np.outer(_TAIL_NODES / rise, self._slope)])
            log = np.append(log, np.log(_TAIL_WEIGHTS / -rise) + self._end @ coefficients)
        top = float(log.max())
        shares = np.exp(log - top)
        whole = float(shares.sum())
        likelihood = float(self._mean @ coefficients) - top - float(np.log(whole))
        value = likelihood - 0.5 * float(coefficients @ penalty @ coefficients)
        return _State(coefficients, value, likelihood, shares / whole, rows)

    def _newton(self, start: Array, penalty: Array) -> _State:
        """The maximum, which is the only one: the penalised log-likelihood is concave."""
        now = self._state(start, penalty)
        assert now is not None
        for _ in range(_STEPS):
            gradient = self._mean - now.shares @ now.rows - penalty @ now.coefficients
            step = _inverse(now.covariance() + penalty) @ gradient
            gain, length = float(gradient @ step), 1.0
            if not gain * self._size > _DONE:  # one step more makes the mean that of the samples to round-off
                return self._state(now.coefficients + step, penalty) or now
            trial = self._state(now.coefficients + step, penalty)
            while trial is None or not trial.value > now.value + 1e-4 * length * gain - 1e-14:
                length *= 0.5
                if length < 1e-9:
                    return now
                trial = self._state(now.coefficients + length * step, penalty)
            now = trial
        return now

    def _scored(self, state: _State, penalty: Array) -> Fit:
        """The fit, its score with the effective number of parameters and Hurvich's correction for few samples."""
        covariance = state.covariance()
        spread = _inverse(covariance + penalty)
        count = float(np.trace(spread @ covariance))
        correction = self._size / max(self._size - count - 1.0, 1.0)
        score = self._size * state.likelihood - cost(self._size) * count * correction
        fall = -float(self._slope @ state.coefficients)
        if self._form.open_above and fall * self._columns.last * _LONGEST < 1.0:
            score -= _EDGE
        inner, tail = np.split(state.shares, [self._nodes.size])
        return Fit(
            columns=self._columns,
            coefficients=state.coefficients,
            score=score,
            power_error=float(np.sqrt(spread[-1, -1] / self._size)) if self._form.power else np.inf,
            beyond=(float(inner[self._nodes < self._columns.first].sum()), float(tail.sum())),
        )


def _inverse(matrix: Array) -> Array:
    scale = 1.0 / np.sqrt(np.diag(matrix) + 1e-300)
    scaled = matrix * scale * scale[:, None] + 1e-12 * np.eye(scale.size)
    return np.linalg.inv(scaled) * scale * scale[:, None]


class LogPolynomial(Thresholds):
    """The law that a fit stands for, with all lengths times `unit`."""

    def __init__(self, fit: Fit, unit: float, onset_power_error: float) -> None:
        self._fit, self._unit = fit, unit
        self.onset_power, self.onset_power_error = fit.power, onset_power_error

    def support(self) -> tuple[float, float]:
        columns, form = self._fit.columns, self._fit.columns.form
        upper = np.inf if form.open_above else self._unit * columns.last
        return 0.0 if form.from_zero else self._unit * columns.first, upper

    @property
    def breakpoints(self) -> Array:
        ends = self._unit * self._fit.columns.first, self._unit * self._fit.columns.last
        return np.unique([end for end in (*self.support(), *ends) if np.isfinite(end)])

    def _log_weight(self, x: Array) -> Array:
        return self._fit.columns.value(x / self._unit, self._fit.coefficients)


def smooth(x: Array, shares: Array, size: float) -> LogPolynomial:
    """The law of largest score among those that begin and end in one way or another.

    x : samples, distinct and sorted, at least 2; shares : weight of each, of sum 1; size : the effective number.
    Raises InputError where none of them has the samples' mean.
    """
    unit = float(x[np.searchsorted(np.cumsum(shares), 0.5)])
    x = x / unit
    piled_up = _piled_up(x, shares)

    def fitted(form: Form) -> Fit:
        found = Likelihood(x, shares, size, form).best()
        edges = int(not form.from_zero) + int(not form.open_above)
        asked = edges * (cost(size) + _EDGE)
        if found.power < 0.0:
            asked += _EDGE if piled_up else np.inf
        return replace(found, score=found.score - asked)

    tried = [
        fitted(Form(power=power, decades=decades))
        for decades in ((False, True) if x[-1] > _FAR else (False,))
        for power in ((False, True) if x[0] < _NEAR_ZERO else (False,))
    ]
    best = max(tried, key=lambda one: one.score)
    if best.beyond[0] * size > _SUSPECT:
        tried.append(fitted(replace(best.columns.form, from_zero=False, power=False)))
        best = max(tried, key=lambda one: one.score)
    if best.beyond[1] * size > _SUSPECT:
        tried.append(fitted(replace(best.columns.form, open_above=False)))
    for one in sorted(tried, key=lambda one: -one.score):
        law = LogPolynomial(one, unit, _onset_error(one, tried))
        mean = float(shares @ x)
        error = float(np.sqrt(shares @ (x - mean) ** 2 / size))
        if abs(law.mean() / unit - mean) < _MEAN * error:
            return law
    ends = f"{unit * x[0]:g} to {unit * x[-1]:g}"
    rule = "one smooth density does not follow them; give each group of its own, in a mixture"
    raise InputError(f"from_samples: the samples reach from {ends}; {rule}")


def _onset_error(best: Fit, tried: list[Fit]) -> float:
    """Error of m; where no power is fitted, how far from 0 one would be, and its own error."""
    if best.columns.form.power or not best.columns.form.from_zero:
        return best.power_error
    rivals = [abs(one.power) + one.power_error for one in tried if one.columns.form.power]
    return min(rivals, default=np.inf)


def _piled_up(x: Array, shares: Array) -> bool:
    """Whether the lowest tenth of the samples, ten at least, lies closer to 0 than evenly: half of it in the lower half
    of its reach."""
    below = np.cumsum(shares)
    share = max(0.1, 10.0 * float(shares.mean()))
    middle, reach = x[np.minimum(np.searchsorted(below, [0.5 * share, share]), x.size - 1)]
    return bool(2.0 * middle < reach)
