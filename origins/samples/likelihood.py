"""Likelihood of densities y^m exp(spline(y)) for one sample, and its maximum for given knots."""

from dataclasses import dataclass

import numpy as np

from origins.samples.spline import Places, average, cardinals, tangents
from origins.thresholds.law import Array

_CANDIDATES = 64
_APART = 3  # distinct samples from one candidate to the next: rounded values must not look like structure
_PANELS = 32
_OCTAVES = 40.0  # below the first sample, of an integral over a power
_LEAST_POWER = -0.95
_LEAST_FALL = 0.75  # of a tail: its length must not exceed 4/3 of that of all samples
_LARGE_POWER = 10.0  # a power costs (m/10)^2/2 of the log-likelihood: what begins far from 0 does not begin as a power
_LOWEST = 1e-4  # of the third sample: what is less counts as this for the power
_STEPS = 100
_DONE = 1e-11  # log-likelihood still to be gained when the last Newton step is taken
_ROUNDING = 1e-13
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(6)
_NODES, _WEIGHTS = 0.5 * (_NODES + 1.0), 0.5 * _WEIGHTS
# a tail is exponential and everything in it linear: two nodes are exact for all that Newton's method needs
_TAIL_NODES, _TAIL_WEIGHTS = np.polynomial.laguerre.laggauss(2)


@dataclass(frozen=True)
class Ends:
    """How a density y^m exp(spline(y)) goes on beyond the extreme samples.

    from_zero : down to y = 0, the spline straight; else it stops at the first sample.
    power : m is fitted (only with from_zero), else 0.
    open_above : beyond the last sample without end, log-density and y straight lines in x with the slopes they have
        there, that of the log-density less by `bent` in units of y (it is -d log(dy/dx)/dy); else it stops there.
    """

    from_zero: bool
    power: bool
    open_above: bool
    bent: float


@dataclass(frozen=True)
class Model:
    """The most likely density with given knots.

    kept : places of the knots among the candidates.
    coefficients : log-density at the knots and, if there is one, the power.
    value : log-likelihood per sample, what a large power costs taken off.
    density, away : at all nodes, those of the tail at the end: probabilities, and derivatives of the log-density by
        the coefficients less their means.
    tail : distances of the tail's nodes from the last sample.
    information : minus the second derivatives of `value`.
    """

    kept: Places
    coefficients: Array
    value: float
    density: Array
    away: Array
    tail: Array
    information: Array

    def solve(self, right: Array) -> Array:
        """information^-1 right; right does not change when a constant is added to all heights."""
        return _solve(self.information, right, self.kept.size)


class Likelihood:
    """What all densities for one sample share: y of shape (n,), distinct and sorted, with shares (sum 1) that are
    worth `size` samples.

    Attributes
    ----------
    knots : array of shape (k,)
        Candidates for knots; a density keeps the first, the last and some between.
    nodes : array
        Where integrals look at the density, the tail beyond the last sample apart.
    mean : array of shape (k,)
        Row from heights at all candidates to the spline's average over the samples.
    """

    def __init__(self, y: Array, shares: Array, size: float, ends: Ends) -> None:
        self.size, self.ends = size, ends
        self.knots = knots = _candidates(y, shares, size)
        self.mean = average(knots, y, shares)
        self._middle = float(shares @ y)
        self._variance = float(shares @ (y - self._middle) ** 2)
        # a sample that is as good as 0 beside all others must not decide the power
        self._mean_log = float(shares @ np.log(np.maximum(y, _LOWEST * y[min(2, y.size - 1)]))) if ends.power else 0.0
        edges = np.union1d(knots, np.linspace(knots[0], knots[-1], _PANELS + 1))
        if ends.from_zero:
            steps = np.arange(max(np.ceil(np.log2(knots[0] / (edges[1] - edges[0]))), 0.0) + 1.0)
            edges = np.concatenate([[0.0], knots[0] * (1.0 - 0.5**steps[1:]), edges])
        if ends.power:
            octaves = np.arange(0.0, _OCTAVES + np.log2(knots[-1] / knots[0]), 0.5)
            edges = np.union1d(edges[1:], knots[-1] * 0.5**octaves)
        width = np.diff(edges)[:, None]
        self.nodes = (edges[:-1, None] + width * _NODES).ravel()
        self._log_weights = np.log((width * _WEIGHTS).ravel())

    def straight(self) -> Model | None:
        """The density without a bend; None where it would be an exponential with too long a tail."""
        mean = self._middle - (0.0 if self.ends.from_zero else float(self.knots[0]))
        if self.ends.open_above and 1.0 / mean + self.ends.bent <= _LEAST_FALL:
            return None
        heights = (self.knots[0] - self.knots[[0, -1]]) / mean
        return self._maximise(np.array([0, self.knots.size - 1]), np.append(heights, np.zeros(int(self.ends.power))))

    def maximise(self, kept: Places, *starts: Array) -> Model:
        """The likeliest density with at least three knots, by Newton's method from the likeliest of the starting
        coefficients; a Gaussian with the samples' mean and variance is always one of them."""
        heights = -0.5 * (self.knots[kept] - self._middle) ** 2 / self._variance
        return self._maximise(kept, np.append(heights, np.zeros(int(self.ends.power))), *starts)

    def _maximise(self, kept: Places, *starts: Array) -> Model:
        knots, power, open_above = self.knots[kept], self.ends.power, self.ends.open_above
        first, last = tangents(knots)
        basis = cardinals(knots, np.maximum(self.nodes, knots[0]))
        basis += np.outer(np.minimum(self.nodes - knots[0], 0.0), first)
        mean = cardinals(knots, self.knots).T @ self.mean
        end = np.append(np.zeros(kept.size - 1), 1.0)
        ridge = np.zeros(kept.size)
        if power:
            basis, mean = np.column_stack([basis, np.log(self.nodes)]), np.append(mean, self._mean_log)
            end, last = np.append(end, np.log(knots[-1])), np.append(last, 1.0 / knots[-1])
            ridge = np.append(ridge, _LARGE_POWER**-2 / self.size)

        def slope(coefficients: Array) -> float:
            return float(last @ coefficients) - self.ends.bent

        def density(coefficients: Array) -> tuple[float, Array, Array] | None:
            """Log-likelihood, probabilities of all nodes, their rows of the basis; None where there is no density."""
            log, rows = basis @ coefficients + self._log_weights, basis
            if power and coefficients[-1] <= _LEAST_POWER:
                return None
            if open_above:
                rise = slope(coefficients)
                if rise >= -_LEAST_FALL:
                    return None
                rows = np.concatenate([basis, end - np.outer(_TAIL_NODES / rise, last)])
                log = np.append(log, np.log(_TAIL_WEIGHTS / -rise) + end @ coefficients)
            top = float(log.max())
            shares = np.exp(log - top)
            whole = float(shares.sum())
            value = float(mean @ coefficients - 0.5 * ridge @ coefficients**2) - top - float(np.log(whole))
            return value, shares / whole, rows

        found = [(density(start), start) for start in starts]
        possible = [(now, start) for now, start in found if now is not None]
        now, coefficients = max(possible, key=lambda pair: pair[0][0])
        done = False
        for _ in range(_STEPS):
            value, shares, rows = now
            expected = shares @ rows
            away = rows - expected
            information = (away * shares[:, None]).T @ away + np.diag(ridge)
            gradient = mean - expected - ridge * coefficients
            step = _solve(information, gradient, kept.size)
            gain, length = float(gradient @ step), 1.0
            if open_above:
                length = _within(length, slope(coefficients) + _LEAST_FALL, float(last @ step))
            if power:
                length = _within(length, _LEAST_POWER - coefficients[-1], -step[-1])
            if done or not gain * length * self.size > 0.0:
                break
            done = gain * length * self.size < _DONE
            trial = density(coefficients + length * step)
            while trial is None or not (done or trial[0] > value + 1e-4 * length * gain - _ROUNDING):
                length, done = 0.5 * length, length < 1e-9
                trial = density(coefficients + length * step)
            coefficients, now = coefficients + length * step, trial
        tail = -_TAIL_NODES / slope(coefficients) if open_above else np.empty(0)
        return Model(kept, coefficients, value, shares, away, tail, information)


def _within(length: float, negative: float, change: float) -> float:
    """`length`, or less of it so that negative + length * change stays below 0."""
    return min(length, -0.9 * negative / change) if change > 0.0 else length


def _solve(information: Array, right: Array, heights: int) -> Array:
    diagonal = np.diag(information)
    scale = 1.0 / np.sqrt(np.maximum(diagonal, 1e-30 * diagonal.max() + 1e-300))
    # the information says nothing of a constant added to all heights
    constant = np.append(np.ones(heights), np.zeros(scale.size - heights)) / scale
    constant /= np.sqrt(constant @ constant)
    scaled = information * scale * scale[:, None] + np.outer(constant, constant) + 1e-13 * np.eye(scale.size)
    return (np.linalg.solve(scaled, (right.T * scale).T).T * scale).T


def _candidates(y: Array, shares: Array, size: float) -> Array:
    """Where knots may be: quantiles of the samples, closer towards the extreme ones, which are the first and last."""
    if y.size == 2:
        return y
    count = int(np.clip(np.round(4.0 * size**0.3), 3, _CANDIDATES))
    below = np.cumsum(shares) - 0.5 * shares
    below = (below - below[0]) / (below[-1] - below[0])
    wanted = 0.5 * (1.0 - np.cos(np.pi * np.arange(count) / (count - 1)))
    kept = [0]
    for place in np.searchsorted(below, wanted).tolist():
        if kept[-1] + _APART <= place <= y.size - 1 - _APART:
            kept.append(place)
    inner = y[kept[1:]] if len(kept) > 1 else 0.5 * (y[:1] + y[-1:])
    return np.concatenate([y[:1], inner, y[-1:]])
