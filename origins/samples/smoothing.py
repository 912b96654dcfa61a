"""The smooth law through samples: the most likely log-polynomial density of a few forms, smoothed by a penalty.

The penalty is the integral of the squared third derivative, so that a parabola, and with it mean and width, is not
penalised, and each further bend must raise the likelihood enough (B. W. Silverman, Ann. Stat. 10, 795, 1982; P. Eilers
and B. Marx, Stat. Sci. 11, 89, 1996).
"""

from __future__ import annotations

from copy import copy
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.polynomial import laguerre, legendre

from origins.errors import InputError
from origins.samples.log_polynomial import Form, LogPolynomial
from origins.thresholds.law import Array

_EDGE = 3.0  # gain in log-likelihood that an edge, or a density diverging at 0, needs beyond a parameter's cost
_SUSPECT = 1.5  # samples expected beyond the extreme one, above which an edge is tried there
_FAR = 8.0  # medians: with samples beyond it a law over decades is tried too
_NEAR_ZERO = 1.0 / 3.0  # of the median: a power x^m is tried only with samples below it
# Allowed errors of a law: of its mean, in standard errors, and of its cdf, beyond the sampling error (1.36/n^(1/2)).
_MEAN, _MISPLACED = 0.1, 0.1
_MOST_DEGREE = 48  # a peak of 1/30 of the samples' reach is resolved
_PENALTIES = 10.0 ** np.arange(2.0, -10.5, -1.0)
_STRAIGHT = 1e10  # penalty that makes the log-density straight
_NO_BETTER = 6.0  # the search ends where a smaller penalty lowers the score by this
_HEAVY = 3.0  # gain in log-likelihood that a long tail needs
# Length over which a tail falls by e, over the last sample: above _LONG it needs that gain, and _LONGEST is the limit.
# At 1/2 it is as heavy as x^-2, which has no mean.
_LONG, _LONGEST = 0.5, 4.0 / 3.0
_LARGE_POWER = 10.0  # m of this size costs 1/2 of the log-likelihood, so that its error is finite
_LEAST_POWER = -0.95  # closer to 1/x nearly all weight would be at x that underflow
_QUARTERS = 20  # factors of 4 below the first sample down to which integrals have panels
_ENDS = 16  # extreme samples at either end that are edges of panels: far ones may raise the density between them
_CHUNK = 1 << 14  # samples whose rows are in memory at once
_STEPS, _DONE = 100, 1e-13  # Newton steps at most; gain in log-likelihood at which they end
_NODES, _WEIGHTS = legendre.leggauss(8)
_NODES, _WEIGHTS = 0.5 * (_NODES + 1.0), 0.5 * _WEIGHTS
# along an exponential tail all rows are linear: two nodes are exact for value, gradient and curvature
_TAIL_NODES, _TAIL_WEIGHTS = laguerre.laggauss(2)


def cost(size: float) -> float:
    """Penalty for each parameter, in log-likelihood: log(size)/2 (Schwarz) up to 55 samples, then 2, twice Akaike's.

    A larger one would leave biases of many standard errors in large samples.
    """
    return min(0.5 * float(np.log(size)), 2.0)


class _State(NamedTuple):
    """Penalised log-likelihood per sample at some coefficients, and the quantities that Newton's method uses."""

    coefficients: Array
    value: float
    likelihood: float
    shares: Array
    rows: Array

    def covariance(self) -> Array:
        """Covariance of the columns under the density: minus the curvature of the log-likelihood."""
        away = self.rows - self.shares @ self.rows
        return (away * self.shares[:, None]).T @ away


class Likelihood:
    """The penalised likelihood of one form for samples x (lengths, sorted, distinct) with `shares` (sum 1).

    size : the effective number of samples; unit : their median.
    """

    def __init__(self, x: Array, shares: Array, size: float, unit: float, form: Form) -> None:
        """Prepare the sums of the likelihood and the places at which the density must stay smooth."""
        degree = int(np.clip(round(4.0 * size**0.3), 4, _MOST_DEGREE))
        self._law = law = LogPolynomial(form, (float(x[0]), float(x[-1])), degree, unit)
        self._size, self._bends, x = size, x.size > 2, x / unit
        starts = range(0, x.size, _CHUNK)
        self._mean: Array = np.sum(
            [shares[i : i + _CHUNK] @ law.rows(x[i : i + _CHUNK]) for i in starts], axis=0
        )
        # where samples are dense the density may change over short distances
        dense = np.linspace(0, x.size - 1, min(x.size, degree)).astype(int)
        edges = [law.grid(), x[dense], x[:_ENDS], x[-_ENDS:]]
        # finer panels towards 0, and on either side of the first sample, where the density may be steep
        down = 0.25 ** np.arange(_QUARTERS + np.ceil(np.log2(law.last / law.first) / 2))
        if form.from_zero:
            edges += [np.zeros(1), law.last * down, law.first * (1.0 - down[1:])]
        else:
            beside = (law.last - law.first) * down[1:]
            edges += [law.first + beside, law.last - beside]
        ends = np.unique(np.concatenate(edges))
        width = np.diff(ends)[:, None]
        self._nodes = (ends[:-1, None] + width * _NODES).ravel()
        self._log_weights = np.log((width * _WEIGHTS).ravel())
        self._rows = law.rows(self._nodes)
        self._end, self._slope = law.rows(np.array([law.last]))[0], law.end_slope()
        self._ridge = np.zeros((self._mean.size,) * 2)
        if form.power:
            self._ridge[-1, -1] = _LARGE_POWER**-2 / size

    def best(self) -> LogPolynomial:
        """The fit of largest score: first a straight line, then smaller and smaller penalties."""
        start, law, bends = np.zeros(self._mean.size), self._law, self._law.penalty()
        if law.form.decades:
            start[law.degree] = -1.0
        else:
            first = 0.0 if law.form.from_zero else law.first
            start[0] = -1.0 / self._slope[0] / max(1.0 - first, 0.1)
        straight = np.zeros(start.size)
        straight[1 : law.degree] = _STRAIGHT
        laws: list[LogPolynomial] = []
        rivals: list[float] = []  # log-likelihoods minus one for each parameter (Akaike)
        for smooth in [np.diag(straight) + bends, *np.multiply.outer(_PENALTIES, bends)]:
            state = self._newton(start, smooth + self._ridge)
            found, rival = self._scored(state, smooth + self._ridge)
            start = state.coefficients
            if laws and -np.inf < found.score < max(one.score for one in laws) - _NO_BETTER:
                break
            laws, rivals = [*laws, found], [*rivals, rival]
            if not self._bends:
                break
        best = max(laws, key=lambda one: one.score)
        # other penalties of similar likelihood give other powers: their spread is part of the error of m
        likely = np.exp(np.array(rivals) - max(rivals))
        off = [np.hypot(o.onset_power_error, o.onset_power - best.onset_power) for o in laws]
        best.onset_power_error = float(np.sqrt(likely @ np.square(off) / likely.sum()))
        return best

    def _state(self, coefficients: Array, penalty: Array) -> _State | None:
        """The state; None if these give no density: a tail that does not fall, a power below -0.95, or overflow."""
        log, rows = self._rows @ coefficients + self._log_weights, self._rows
        if self._law.form.power and coefficients[-1] <= _LEAST_POWER:
            return None
        if self._law.form.open_above:
            rise = float(self._slope @ coefficients)
            if rise >= 0.0:
                return None
            rows = np.concatenate([rows, self._end - np.outer(_TAIL_NODES / rise, self._slope)])
            log = np.append(log, np.log(_TAIL_WEIGHTS / -rise) + self._end @ coefficients)
        top = float(log.max())
        if not np.isfinite(top):
            return None
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
            trial = self._state(now.coefficients + step, penalty)
            if not gain * self._size > _DONE:
                # with one more step the mean equals that of the samples to round-off
                return now if trial is None else trial
            while trial is None or not trial.value > now.value + 1e-4 * length * gain - 1e-14:
                length *= 0.5
                if length < 1e-9:
                    return now
                trial = self._state(now.coefficients + length * step, penalty)
            now = trial
        return now

    def _scored(self, state: _State, penalty: Array) -> tuple[LogPolynomial, float]:
        """The law with its score, by the effective number of parameters and Hurvich's correction for few samples; and
        the log-likelihood minus that number."""
        law, covariance = copy(self._law), state.covariance()
        spread = _inverse(covariance + penalty)
        count = float(np.trace(spread @ covariance))
        correction = self._size / max(self._size - count - 1.0, 1.0)
        law.coefficients, law.onset_power = state.coefficients, 0.0
        law.score = self._size * state.likelihood - cost(self._size) * count * correction
        fall = -float(self._slope @ state.coefficients)
        length = 1.0 / (fall * law.last) if law.form.open_above else 0.0
        if length > _LONG:
            law.score -= _HEAVY if length < _LONGEST else np.inf
        law.onset_power_error = np.inf
        if law.form.power:
            law.onset_power = float(state.coefficients[-1])
            law.onset_power_error = float(np.sqrt(spread[-1, -1] / self._size))
        inner, tail = np.split(state.shares, [self._nodes.size])
        law.beyond = float(inner[self._nodes < law.first].sum()), float(tail.sum())
        return law, self._size * state.likelihood - count


def _inverse(matrix: Array) -> Array:
    scale = 1.0 / np.sqrt(np.diag(matrix) + 1e-300)
    scaled = matrix * scale * scale[:, None] + 1e-12 * np.eye(scale.size)
    return np.linalg.inv(scaled) * scale * scale[:, None]


def smooth(x: Array, shares: Array, size: float) -> LogPolynomial:
    """The law of largest score among a few forms of its two ends.

    x : samples (lengths), distinct and sorted, at least 2; shares : weight of each, of sum 1; size : the effective
    number. Raises InputError where none of the laws follows the samples.
    """
    unit, piled_up = float(x[np.searchsorted(np.cumsum(shares), 0.5)]), _piled_up(x, shares)

    def fitted(form: Form) -> LogPolynomial:
        with np.errstate(all="ignore"):  # coefficients that overflow are rejected
            found = Likelihood(x, shares, size, unit, form).best()
        edges = int(not form.from_zero) + int(not form.open_above)
        found.score -= edges * (cost(size) + _EDGE)
        if found.onset_power < 0.0:
            found.score -= _EDGE if piled_up else np.inf
        return found

    forms = [
        Form(power=power, decades=decades)
        for decades in ((False, True) if x[-1] > _FAR * unit else (False,))
        for power in ((False, True) if x[0] < _NEAR_ZERO * unit else (False,))
    ]
    # two values: a straight line from one to the other
    between = [Form(from_zero=False, open_above=False)]
    tried = [fitted(form) for form in (forms if x.size > 2 else between)]
    best = max(tried, key=lambda one: one.score)
    if best.beyond[0] * size > _SUSPECT:
        tried.append(fitted(replace(best.form, from_zero=False, power=False)))
        best = max(tried, key=lambda one: one.score)
    if best.beyond[1] * size > _SUSPECT:
        tried.append(fitted(replace(best.form, open_above=False)))
    # where no power is fitted, the error of m is the size of the one that would be, plus its error
    rivals = [abs(one.onset_power) + one.onset_power_error for one in tried if one.form.power]
    for law in sorted(tried, key=lambda one: -one.score):
        if _follows(law, x, shares, size):
            if law.form.from_zero and not law.form.power:
                law.onset_power_error = min(rivals, default=np.inf)
            return law
    rule = (
        "are groups or peaks that one smooth density does not follow; give each apart, in a mixture"
    )
    raise InputError(f"from_samples: among the samples from {x[0]:g} to {x[-1]:g} {rule}")


def _follows(law: LogPolynomial, x: Array, shares: Array, size: float) -> bool:
    """Whether the law has the samples' mean and cdf, the latter up to a tenth beyond the sampling error.

    It may not: the integrals of the likelihood may miss a peak between far samples, or no polynomial follows a peak.
    """
    mean = float(shares @ x)
    error = float(np.sqrt(shares @ (x - mean) ** 2 / size))
    halfway = np.cumsum(shares) - 0.5 * shares
    try:
        misplaced = float(np.abs(law.cdf(x) - halfway).max())
    except InputError:  # too rough for any use
        return False
    return abs(law.mean() - mean) < _MEAN * error and misplaced < _MISPLACED + 1.36 / np.sqrt(size)


def _piled_up(x: Array, shares: Array) -> bool:
    """Whether the lowest tenth of the samples (at least ten) accumulates at 0: half of it is below half of its
    reach."""
    below = np.cumsum(shares)
    share = max(0.1, 10.0 * float(shares.mean()))
    middle, reach = x[np.minimum(np.searchsorted(below, [0.5 * share, share]), x.size - 1)]
    return bool(2.0 * middle < reach)
