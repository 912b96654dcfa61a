"""Laws of thresholds and of heat drawn at random, ordinary ones."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy.stats

import origins
from origins.thresholds.law import Thresholds


def narrow(rng: np.random.Generator, unit: float) -> Thresholds:
    """Gaussian thresholds so far from 0 that their cut there does not matter."""
    return origins.gaussian(unit, unit * rng.uniform(0.02, 0.1))


def smooth(rng: np.random.Generator, unit: float) -> Any:
    """Thresholds with densities so smooth that steps resolve them to round-off."""
    wide = math.exp(rng.uniform(-1.0, 1.0)) * unit
    peaks = [origins.gaussian(at * unit, 0.08 * unit) for at in rng.uniform(0.6, 1.5, 2)]
    return [
        lambda: narrow(rng, unit),
        lambda: origins.lubricated(unit),
        lambda: origins.persson(unit, wide),
        lambda: origins.gw_plastic(unit**-2.0),
        lambda: scipy.stats.gamma(rng.integers(1, 9), scale=unit / 4.0),
        lambda: scipy.stats.lognorm(rng.uniform(0.1, 0.6), scale=unit),
        lambda: origins.mixture(peaks, [0.4, 0.6]),
    ][rng.integers(7)]()


def rough(rng: np.random.Generator, unit: float) -> Any:
    """Thresholds with roots, jumps, exact values and heavy tails in their densities."""
    low = rng.uniform(0.1, 0.9)
    box = origins.rectangular(low * unit, 1.4 * unit)
    return [
        lambda: box,
        lambda: origins.gw_elastic(unit ** (-4.0 / 3.0)),
        lambda: origins.gw_gaussian(rng.uniform(0.5, 4.0), unit),
        lambda: origins.grains(rng.uniform(0.8, 2.0), B=unit**-2.0),
        lambda: scipy.stats.beta(rng.uniform(0.8, 3.0), rng.uniform(0.8, 3.0), scale=unit),
        lambda: scipy.stats.lomax(rng.uniform(3.0, 6.0), scale=unit),
        lambda: origins.mixture([box, origins.identical(1.7 * unit)], [0.7, 0.3]),
    ][rng.integers(7)]()


def heat(
    rng: np.random.Generator, mean: float, laws: Sequence[str] = ("soft", "stiff", "eyring")
) -> origins.Thermal:
    """One of the laws of heat, from cold to hot, with rare and with many attempts."""
    law, attempts = laws[int(rng.integers(len(laws)))], 10.0 ** rng.uniform(-1.0, 1.5)
    if law == "eyring":
        width = rng.uniform(0.02, 0.3)
        return origins.Thermal(law, attempt_frequency=attempts / mean, width=width)
    warmth = 10.0 ** rng.uniform(-2.5, -0.5) * mean**2
    return origins.Thermal(law, warmth, attempts / mean)
