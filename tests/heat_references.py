"""Contacts that break by heat, by sums over time and thresholds that follow the definitions."""

from itertools import pairwise

import numpy as np
from rate_laws import Tilted
from solving import gauss

from origins import Thermal, gaussian, gw_elastic, mixture, rectangular

# tanh-sinh on (0, 1): the distances of nodes from both ends, without cancellation
STEP = 0.08
SINH = 0.5 * np.pi * np.sinh(STEP * np.arange(-44, 45))
FROM_1 = 1.0 / (1.0 + np.exp(2.0 * SINH))
TANH_SINH = STEP * 0.25 * np.pi * np.cosh(STEP * np.arange(-44, 45)) / np.cosh(SINH) ** 2
LAWS = {
    "gaussian": gaussian(1.0, 0.2),
    "gw_elastic": gw_elastic(1.6),
    "gap": mixture([rectangular(0.3, 0.5), gaussian(1.5, 0.1)], [0.5, 0.5]),
}
PATHS = {
    "forward": ([0.0, 1.0], [0.0, 1.0]),
    "slow": ([0.0, 100.0], [0.0, 1.0]),
    "hold": ([0.0, 1.0, 50.0], [0.0, 0.7, 0.7]),
    "on after a hold": ([0.0, 1.0, 50.0, 50.001], [0.0, 0.7, 0.7, 0.701]),
    "turns": ([0.0, 1.0, 3.0, 5.0], [0.0, 0.8, -0.5, 0.9]),
    "across zero": ([0.0, 1.0], [0.6, -0.6]),
}
HEAT = {
    "soft": (Thermal("soft", 0.1), lambda g, s, k: np.exp(-k * g * (2 * s - g) / 0.2)),
    "cooler": (
        Thermal("soft", 0.01, 100.0),
        lambda g, s, k: 100 * np.exp(-k * g * (2 * s - g) / 0.02),
    ),
    "stiff": (
        Thermal("stiff", 0.1),
        lambda g, s, k: (g / s) ** 0.5 * np.exp(-k * s**2 * (g / s) ** 1.5 / 0.2),
    ),
    "cooler stiff": (
        Thermal("stiff", 0.01, 100.0),
        lambda g, s, k: 100 * (g / s) ** 0.5 * np.exp(-k * s**2 * (g / s) ** 1.5 / 0.02),
    ),
    "tilted": (Tilted(0.03, 1e3), lambda g, s, k: 1e3 * np.exp(-g / s / 0.03)),
}


def spent(rate, x, times, gap, stiffness):
    """A by definition, for thresholds at distances `gap` above the largest |x|."""
    largest, out = np.abs(x).max(), np.zeros(gap.size)
    threshold = (largest + gap)[:, None]
    stiffness = np.broadcast_to(stiffness, gap.shape)[:, None]
    moves = []
    for begin, end, time in zip(x[:-1], x[1:], np.diff(times), strict=True):
        parts = [(begin, end, 1.0)]
        if begin * end < 0.0:
            share = begin / (begin - end)
            parts = [(begin, 0.0, share), (0.0, end, 1.0 - share)]
        moves += [(*sorted((abs(a), abs(b))), share * time) for a, b, share in parts]
    for near, far, time in moves:
        if near == far:
            out += time * rate(gap[:, None] + (largest - far), threshold, stiffness)[:, 0]
            continue
        cuts = np.linspace(near, far, 5)
        for low, high in pairwise(cuts):
            distance = gap[:, None] + (largest - high) + (high - low) * FROM_1
            out += 0.25 * time * (rate(distance, threshold, stiffness) @ TANH_SINH)
    return out


def left_by_definition(law, rate, x, times, linked):
    """Share and force of contacts whose legs end at x, by sums on graded panels."""
    largest, top = np.abs(x).max(), float(law.isf(1e-19))
    others = [largest - abs(end) for end in x if abs(end) < largest]
    gaps = [np.geomspace(1e-16, top, 60), np.linspace(0.0, top, 150)]
    gaps += [distance * np.geomspace(1e-2, 1e2, 20) for distance in others]
    beyond = np.append(0.0, np.geomspace(1e-9, 1.0, 30))
    gaps += [mark - largest + beyond for mark in law.breakpoints]
    edges = np.unique(np.concatenate([[0.0, top - largest], *gaps]))
    edges = edges[(edges >= 0.0) & (edges <= top - largest)]
    gap, weight = gauss(edges)
    stiffness = (largest + gap) / law.mean() if linked else np.ones(gap.size)
    held = weight * law.pdf(largest + gap) * np.exp(-spent(rate, x, times, gap, stiffness))
    whole = law.sf(abs(x[0]))
    return np.array([held.sum(), x[-1] * (held * stiffness).sum()]) / whole
