"""Thresholds from samples: errors of the density and of K*, time, and how often intervals hold the truth.

    python -m tests.bench.bench_samples

Squared errors are the integral of (P_c - p)^2 over that of p^2, means over seeds; errors of K* are root mean squares.
"""

import time
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from scipy import stats

import master
import origins

Array = npt.NDArray[np.float64]

PEAKS = origins.mixture([origins.gaussian(0.5, 0.03), origins.gaussian(1.2, 0.05)], [0.4, 0.6])
GAP = origins.mixture([origins.rectangular(0.2, 0.4), origins.rectangular(1.0, 1.5)], [0.3, 0.7])
LAWS = {
    "weibull 2.5": stats.weibull_min(2.5),
    "gaussian(1, .05)": origins.gaussian(1.0, 0.05),
    "gamma 3": stats.gamma(3.0),
    "rectangular": origins.rectangular(0.5, 1.5),
    "two peaks": PEAKS,
    "rectangles, gap": GAP,
    "lomax 3.5": stats.lomax(3.5),
}
SIZES = {30: 20, 1000: 20, 20_000: 10, 1_000_000: 2}  # seeds of each
ROW = "{:18s} {:>8} {:>9} {:>9} {:>9} {:>9} {:>6} {:>9}"


def errors() -> None:
    """Goal: K* of Weibull(2.5) within 10 % for 20,000 samples; solved to 1e-8 in 50 ms from a Gaussian start."""
    print(ROW.format("law", "samples", "sq. error", "K*", "rms error", "fit, ms", "knots", "solve, ms"))
    for name, exact in LAWS.items():
        law = origins.Contacts(exact).thresholds
        x = np.unique(np.concatenate([np.geomspace(1e-5, 60.0, 20_001), np.linspace(0.1, 4.0, 40_001)]))
        density = law.pdf(x)
        spring = master.propensity(origins.Contacts(law), 1e-6).critical_spring
        for size, seeds in SIZES.items():
            found = np.array([_one(law.rvs(size, seed), x, density, spring) for seed in range(seeds)])
            squared, miss, fit, knots, solve = found.T
            print(
                ROW.format(
                    name,
                    size,
                    f"{squared.mean():.1e}",
                    f"{spring:.4f}",
                    f"{np.sqrt((miss**2).mean()):.4f}",
                    f"{1e3 * np.median(fit):.0f}",
                    f"{knots.mean():.0f}",
                    f"{1e3 * np.median(solve):.0f}",
                )
            )


def _one(samples: Array, x: Array, density: Array, spring: float) -> list[float]:
    began = time.perf_counter()
    law = origins.from_samples(samples)
    fit = time.perf_counter() - began
    squared = float(np.trapezoid((law.pdf(x) - density) ** 2, x) / np.trapezoid(density**2, x))
    mean = law.mean()
    contacts = origins.Contacts(law, origins.gaussian_start(mean=0.0, std=0.025 * mean))
    path = np.linspace(0.0, 5.0, 501) * mean
    master.solve(contacts, path, 1e-8)
    began = time.perf_counter()
    master.solve(contacts, path, 1e-8)
    solve = time.perf_counter() - began
    miss = master.propensity(origins.Contacts(law), 1e-5).critical_spring - spring
    return [squared, miss, fit, float(law.breakpoints.size), solve]


def coverage(name: str, size: int, statistic: Callable[[object], list[float]], sets: int, resamples: int) -> None:
    """How often value ± error and the 95 % interval hold the truth, over fresh data sets."""
    law = origins.Contacts(LAWS[name]).thresholds
    exact = np.array(statistic(law))
    near, held, misses = np.zeros(exact.size), np.zeros(exact.size), []
    stated = []
    for seed in range(sets):
        found = origins.bootstrap(origins.from_samples(law.rvs(size, 1000 + seed)), statistic, resamples, seed)
        near += np.abs(found.value - exact) <= found.error
        held += (found.interval[0] <= exact) & (exact <= found.interval[1])
        misses.append(found.value - exact)
        stated.append(found.error)
    rms, error = np.sqrt(np.mean(np.square(misses), axis=0)), np.median(stated, axis=0)
    for k, value in enumerate(exact):
        print(
            f"{name}, {size} samples, {sets} sets: {LABELS[k]:14s} {value:8.4f}  rms error {rms[k]:.4f}  "
            f"stated {error[k]:.4f}  held by ±1 error {near[k] / sets:.0%}, by the interval {held[k] / sets:.0%}"
        )


LABELS = ["max x P_c - 1", "F_k", "P_c(0.95)", "K*", "F_s/F_k"]


def cheap(law: origins.Thresholds) -> list[float]:
    """First-order K*, F_k, and the density at 0.95."""
    x = law.ppf(np.linspace(0.002, 0.998, 1500))
    return [float((x * law.pdf(x)).max()) - 1.0, law.moment(2) / (2.0 * law.mean()), float(law.pdf(0.95))]


def propensity(law: origins.Thresholds) -> list[float]:
    found = master.propensity(origins.Contacts(law), 1e-5)
    return [*cheap(law), found.critical_spring, found.static_to_kinetic]


def main() -> None:
    errors()
    print()
    for name, size in (("weibull 2.5", 100), ("weibull 2.5", 1000), ("gaussian(1, .05)", 300), ("gamma 3", 1000)):
        coverage(name, size, cheap, 50, 30)
    coverage("weibull 2.5", 1000, propensity, 20, 20)


if __name__ == "__main__":
    main()
