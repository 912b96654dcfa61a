"""Exact forces for thresholds that are times to absorption of a Markov chain, and for narrow Gaussians.

A contact passes through phases with generator T as its stretch grows and breaks when it leaves them; a fresh one
begins in phase j with probability a_j. With p(X) the fractions of contacts in each phase and m(X) their stretches,

    p' = p (T + t a),    m' = p + m T,    t = -T 1,    F = sum of m:

linear, so a matrix exponential. Everything below is in the unit of the rates.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy.stats
from scipy.linalg import expm
from scipy.special import ndtr

import origins

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class PhaseType:
    """A law of thresholds for the solver, and the chain it is the time to absorption of."""

    law: object
    begin: Array
    generator: Array

    @property
    def mean(self) -> float:
        return float(-self.begin @ np.linalg.solve(self.generator, np.ones(self.begin.size)))

    def force(self, path: Array, start: float = 0.0) -> Array:
        """F(X) from one starting stretch, thresholds conditional on x_s > |start|."""
        size = self.begin.size
        at_start = self.begin @ expm(abs(start) * self.generator)
        at_start = at_start / at_start.sum()
        block = np.zeros((2 * size, 2 * size))
        block[:size, :size] = self.generator + np.outer(-self.generator.sum(1), self.begin)
        block[:size, size:] = np.eye(size)
        block[size:, size:] = self.generator
        # a contact from below 0 cannot break before its stretch is as large as it began
        moved = np.maximum(path - max(-2.0 * start, 0.0), 0.0)
        state = np.concatenate([at_start, abs(start) * at_start])
        steps = expm(np.diff(moved, prepend=0.0)[:, None, None] * block)
        force = np.empty(path.size)
        for i, step in enumerate(steps):
            state = state @ step
            force[i] = state[size:].sum()
        return np.where(moved > 0.0, force, start + path)


def hyper_erlang(weights: list[float], stages: list[int], rates: list[float]) -> PhaseType:
    """Mixture of Erlang laws; one stage each is hyper-exponential, one component alone an Erlang law."""
    size = sum(stages)
    begin, generator, first = np.zeros(size), np.zeros((size, size)), 0
    for weight, number, rate in zip(weights, stages, rates, strict=True):
        begin[first] = weight
        for phase in range(first, first + number):
            generator[phase, phase] = -rate
            if phase + 1 < first + number:
                generator[phase, phase + 1] = rate
        first += number
    laws = [scipy.stats.gamma(n, scale=1.0 / r) for n, r in zip(stages, rates, strict=True)]
    return PhaseType(
        laws[0] if len(laws) == 1 else origins.mixture(laws, weights), begin, generator
    )


def coxian(first_rate: float, second_rate: float, on: float) -> PhaseType:
    """Two phases in a row of different rates; the second is reached with probability `on`, else the contact breaks."""
    generator = np.array([[-first_rate, on * first_rate], [0.0, -second_rate]])
    return PhaseType(_Coxian(first_rate, second_rate, on), np.array([1.0, 0.0]), generator)


class _Coxian(origins.Thresholds):
    """S(x) = (1 - c) e^(-first x) + c e^(-second x), c = on first / (first - second)."""

    onset_power = 0.0

    def __init__(self, first: float, second: float, on: float) -> None:
        c = on * first / (first - second)
        self._terms = [(1.0 - c, first), (c, second)]

    def support(self) -> tuple[float, float]:
        return 0.0, np.inf

    def _pdf(self, x: Array) -> Array:
        return sum(c * r * np.exp(-r * x) for c, r in self._terms)

    def _cdf(self, x: Array) -> Array:
        return -sum(c * np.expm1(-r * x) for c, r in self._terms)

    def _sf(self, x: Array) -> Array:
        return sum(c * np.exp(-r * x) for c, r in self._terms)


def gaussian_force(
    path: Array, mean: float, std: float, start: float = 0.0, start_std: float = 0.0
) -> Array:
    """Closed form for Gaussian thresholds and starts whose weight below 0, and below |start|, is negligible."""
    n = np.arange(1, int(path.max() / mean * 1.5 + 12.0))[:, None]
    width = np.sqrt(n * std**2 + start_std**2)
    z = (path - n * mean + start) / width
    density = np.exp(-0.5 * z * z) / np.sqrt(2.0 * np.pi)
    return start + path - (mean * ndtr(z) - std**2 / width * density).sum(axis=0)
