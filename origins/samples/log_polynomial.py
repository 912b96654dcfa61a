"""The smooth law through samples: a density whose logarithm is a polynomial plus m log x, smoothed by a penalty.

Legendre polynomials are smooth everywhere: splines would have knots that solvers must resolve. The penalty is the
integral of the squared third derivative, so that a parabola, and with it mean and width, is not penalised, and each
further bend must raise the likelihood enough (B. W. Silverman, Ann. Stat. 10, 795, 1982; P. Eilers and B. Marx, Stat.
Sci. 11, 89, 1996).
"""

from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre

from origins.thresholds.law import Array, Thresholds
from origins.thresholds.quadrature import gauss

# By how many the samples exceed the effective parameters, at least: a fit with a parameter for each of 3 or 4 samples
# makes each of them a narrow peak of its own. A straight line, of one parameter, is taken in any case.
_SPARE_SAMPLES, _OF_A_LINE = 0.9, 1.1
_EDGE = 3.0  # gain in log-likelihood that an edge, or a density diverging at 0, needs beyond a parameter's cost


class _State(NamedTuple):
    """Coefficients, the penalised log-likelihood per sample there, -inf or NaN where they give no density, and the
    weights of the nodes under the density."""

    coefficients: Array
    value: float
    fractions: Array


class Form(NamedTuple):
    """The form of log P_c, a polynomial, and of its ends.

    power : m log x is added.
    decades : a polynomial of log(1 + x/median) with x added, for thresholds over decades; else a polynomial of x.
    from_zero : straight in x from the first sample down to x = 0; else P_c has an edge at the first sample.
    open_above : straight in x beyond the last sample, an exponential tail; else P_c has an edge there.
    """

    power: bool = False
    decades: bool = False
    from_zero: bool = True
    open_above: bool = True


class LogPolynomial(Thresholds):
    """The law of largest score, of one form, for samples x (lengths, sorted, distinct) with `fractions` (sum 1).

    log P_c is a sum of columns, each times its coefficient, and a constant: Legendre polynomials of degree 1, 2, ...,
    then x (decades), then log x (power), all continued as straight lines beyond the extreme samples; they
    take x in units of the samples' median. size : the effective number of samples.
    score : log-likelihood minus the cost of the parameters.
    """

    def __init__(self, x: Array, fractions: Array, size: float, form: Form) -> None:
        """Prepare the columns and their sums over samples and over panels, and fit the coefficients."""
        self.form, (power, decades, from_zero, open_above) = form, form
        self._size, first, last = size, float(x[0]), float(x[-1])
        self._support = 0.0 if from_zero else first, np.inf if open_above else last
        self.breakpoints = np.unique([self._support[0], first, last])
        self._unit = float(x[np.searchsorted(np.cumsum(fractions), 0.5)])
        x = x / self._unit
        first, last = self._first, self._last = float(x[0]), float(x[-1])
        low, high = self._variable(x[[0, -1]])
        self._middle, self._half = 0.5 * (low + high), 0.5 * (high - low)
        self._degree = degree = int(np.clip(round(4.0 * size**0.3), 4, 48))
        order = np.arange(1, degree + 1)
        steep = order * (order + 1) / (2.0 * self._half)
        bent = (1.0 + first, 1.0 + last) if decades else (1.0, 1.0)
        more = [1.0] * decades
        self._below = np.array([*(-steep * (-1.0) ** order / bent[0]), *more, *[0.0] * power])
        self._above = np.array([*(steep / bent[1]), *more, *[1.0 / last] * power])
        # not the columns of all samples in memory at once
        parts = [slice(i, i + 16384) for i in range(0, x.size, 16384)]
        self._mean = np.sum([fractions[part] @ self.columns(x[part]) for part in parts], axis=0)
        # panels between samples, halved towards either end and towards 0, where the density may be steep
        near = np.geomspace(1e-9, 1.0, 30)
        among = x[np.linspace(0, x.size - 1, min(x.size, 3 * degree)).astype(int)]
        ends = [among, np.linspace(first, last, 2 * degree)]
        ends += [first + (last - first) * near, last - (last - first) * near]
        if from_zero:
            ends += [first * (1.0 - near), last * np.geomspace(1e-30, 1.0, 60)]
        if open_above:
            ends.append(last + (last - first) * np.geomspace(1e-6, 1e4, 36))
        edges = np.unique(np.concatenate(ends))
        nodes, weights = gauss(edges[:-1], edges[1:])
        self._nodes, self._log_weights = self.columns(nodes.ravel()), np.log(weights.ravel())
        self._fit(few=x.size < 3)
        del self._nodes, self._log_weights  # a megabyte, which ranks would send one another

    def _log_weight(self, x: Array) -> Array:
        # no product of matrices: each value has the same bits whatever the other x
        return (self.columns(x / self._unit) * self.coefficients).sum(axis=-1)

    def _variable(self, x: Array) -> Array:
        return np.log1p(x) if self.form.decades else x

    def columns(self, x: Array) -> Array:
        """Values of the columns at x (in medians), shape (..., columns)."""
        inner = np.clip(x, self._first, self._last)
        y = (self._variable(inner) - self._middle) / self._half
        parts = [legendre.legvander(y, self._degree)[..., 1:]]
        if self.form.decades:
            parts.append(inner[..., None])
        if self.form.power:
            with np.errstate(divide="ignore"):
                parts.append(np.log(np.minimum(x, self._last))[..., None])
        out = np.concatenate(parts, axis=-1)
        out += np.multiply.outer(np.minimum(x - self._first, 0.0), self._below)
        return out + np.multiply.outer(np.maximum(x - self._last, 0.0), self._above)

    def _fit(self, few: bool) -> None:
        """Take the coefficients of largest score: of a straight line first, then of ever smaller penalties.

        Each parameter, of an effective number, costs log(size)/2 (Schwarz) up to 55 samples, then 2, twice Akaike's (a
        larger cost would leave biases of many standard errors in large samples), corrected for few samples by Hurvich.
        """
        form, size, degree = self.form, self._size, self._degree
        start = np.zeros(self._mean.size)
        if form.decades:
            start[degree] = -1.0
        else:
            start[0] = -1.0 / self._above[0] / max(1.0 - (not form.from_zero) * self._first, 0.1)
        straight, bends, ridge = np.zeros((3, start.size, start.size))
        np.fill_diagonal(straight[1:degree, 1:degree], 1e10)
        nodes, weights = legendre.leggauss(degree + 1)
        third = legendre.legval(nodes, legendre.legder(np.eye(degree + 1), 3, axis=0))[1:]
        bends[:degree, :degree] = (third * weights) @ third.T / degree
        # m = 10 takes 0.5 off the log-likelihood, so that the error of m is finite
        ridge[-1, -1] = form.power * 0.01 / size
        weaker = np.multiply.outer(10.0 ** np.arange(2.0, -10.5, -1.0), bends)
        cost = min(0.5 * float(np.log(size)), 2.0)
        tried, scores = [], []
        information, errors = [], []  # likelihood less the number of parameters; error of m
        for smooth in [straight + bends, *weaker][: 1 if few else None]:
            penalty = smooth + ridge
            state = self._highest(start, penalty)
            start = state.coefficients
            covariance = self._covariance(state.fractions)
            spread = _inverse(covariance + penalty)
            count = float(np.trace(spread @ covariance))
            likelihood = size * (state.value + 0.5 * float(start @ penalty @ start))
            score = likelihood - cost * count * size / max(size - count - 1.0, 1.0)
            score -= _EDGE * (form.power and start[-1] < 0.0)
            if count > max(size - _SPARE_SAMPLES, _OF_A_LINE):
                score = -np.inf
            # refused: a tail that begins to fall as x^-0.75 or slower, by e over 4/3 of the last sample
            if form.open_above and -(self._above @ start) * self._last < 0.75:
                score = -np.inf
            tried.append(start)
            scores.append(score)
            information.append(likelihood - count)
            errors.append(float(np.sqrt(spread[-1, -1] / size)))
            if -np.inf < score < max(scores) - 6.0:
                break
        best = int(np.argmax(scores))
        self.coefficients, self.onset_power, self.onset_power_error = tried[best], 0.0, np.inf
        self.score = scores[best] - (2 - form.from_zero - form.open_above) * (cost + _EDGE)
        if form.power:
            # other penalties of similar likelihood give other powers: their spread is part of the error of m
            powers = np.array(tried)[:, -1]
            likely = np.exp(np.array(information) - information[best])
            squares = np.square(errors) + (powers - powers[best]) ** 2
            self.onset_power = float(powers[best])
            self.onset_power_error = float(np.sqrt(likely @ squares / likely.sum()))

    def _state(self, coefficients: Array, penalty: Array) -> _State:
        """The state at these coefficients, by sums over the nodes."""
        log = self._nodes @ coefficients + self._log_weights
        top = float(log.max())
        fractions = np.exp(log - top)
        whole = float(fractions.sum())
        value = float(self._mean @ coefficients) - top - float(np.log(whole))
        value -= 0.5 * float(coefficients @ penalty @ coefficients)
        # closer to 1/x nearly all weight would be at x that underflow
        if self.form.power and coefficients[-1] <= -0.95:
            value = -np.inf
        return _State(coefficients, value, fractions / whole)

    def _covariance(self, fractions: Array) -> Array:
        """That of the columns under the density: minus the curvature of the log-likelihood."""
        away = self._nodes - fractions @ self._nodes
        away *= np.sqrt(fractions)[:, None]
        return away.T @ away  # of one matrix: BLAS computes half of it, and mirrors it

    def _highest(self, start: Array, penalty: Array) -> _State:
        """The maximum, by Newton's method; the only one, as the penalised log-likelihood is concave."""
        now = self._state(start, penalty)
        for _ in range(100):
            gradient = self._mean - now.fractions @ self._nodes - penalty @ now.coefficients
            step = _inverse(self._covariance(now.fractions) + penalty) @ gradient
            gain, length = float(gradient @ step), 1.0
            trial = self._state(now.coefficients + step, penalty)
            if not gain * self._size > 1e-13:
                # with one more step the mean equals that of the samples to round-off
                return trial if np.isfinite(trial.value) else now
            while not trial.value >= now.value + 1e-4 * length * gain - 1e-14:
                length *= 0.5
                if length < 1e-9:
                    return now
                trial = self._state(now.coefficients + length * step, penalty)
            now = trial
        return now


def _inverse(matrix: Array) -> Array:
    scale = 1.0 / np.sqrt(np.diag(matrix) + 1e-300)
    scaled = matrix * scale * scale[:, None]
    scaled.flat[:: scale.size + 1] += 1e-12  # of the diagonal
    return np.linalg.inv(scaled) * scale * scale[:, None]


def smooth(x: Array, fractions: Array, size: float) -> LogPolynomial:
    """The law of largest score among a few forms of its two ends.

    x : samples (lengths), distinct and sorted, at least 2; fractions : weight of each, of sum 1; size : the effective
    number. Raises InputError where the law is too rough for any use.
    """

    def fitted(form: Form) -> LogPolynomial:
        with np.errstate(all="ignore"):  # coefficients that overflow are rejected
            return LogPolynomial(x, fractions, size, form)

    if x.size == 2:  # a straight line from one to the other
        return fitted(Form(from_zero=False, open_above=False))
    middle = float(x[np.searchsorted(np.cumsum(fractions), 0.5)])
    # a variable over decades for far samples, a power where some are near 0
    decades, powers = {False, bool(x[-1] > 8.0 * middle)}, {False, bool(x[0] < middle / 3.0)}
    tried = [fitted(Form(power, far)) for far in decades for power in powers]
    best = max(tried, key=lambda law: law.score)
    # edges where the law expects more than the extreme sample beyond it
    if best.cdf(x[0]) * size > 1.5:
        tried.append(fitted(Form(decades=best.form.decades, from_zero=False)))
        best = max(tried, key=lambda law: law.score)
    if best.sf(x[-1]) * size > 1.5:
        tried.append(fitted(best.form._replace(open_above=False)))
        best = max(tried, key=lambda law: law.score)
    if best.form.from_zero and not best.form.power:
        # the error of m = 0 is the size of the power that would be fitted, plus its error
        rivals = [abs(law.onset_power) + law.onset_power_error for law in tried if law.form.power]
        best.onset_power_error = min(rivals, default=np.inf)
    return best
