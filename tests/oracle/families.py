"""Cases with random numbers: every law of thresholds forward, turning, steady and on a spring."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

import origins
from oracle.case import (
    Case,
    along_turns,
    force_along,
    propensity,
    steady_force,
)

MakeLaw = Callable[[], object]

SLIP_RULES = ("reset", "reform-after", "instant")


def random_cases(seed: int, count: int) -> Iterator[Case]:
    """`count` draws of every family of this file; another seed draws other numbers."""
    for draw in range(count):
        # each family has its own generator, so that a new family leaves the numbers of the others
        plain, spread = (np.random.default_rng([seed, draw, family]) for family in range(2))
        for name, law in threshold_laws(plain).items():
            yield from plain_cases(f"{draw} {name}", law, plain)
        yield from special_paths(f"{draw}", spread, draw)


def threshold_laws(rng: np.random.Generator) -> dict[str, MakeLaw]:
    """Ordinary laws of thresholds, of means of order 1, by name."""
    from scipy import stats

    width, shape = rng.uniform(0.03, 0.3), rng.uniform(0.5, 3.0)

    def two_peaks() -> object:
        peaks = [
            origins.gaussian(mean=0.6, std=0.3 * width),
            origins.gaussian(mean=1.4, std=0.5 * width),
        ]
        return origins.mixture(peaks, [0.3 + width, 0.7 - width])

    def atom_and_peak() -> object:
        parts = [origins.identical(0.8), origins.gaussian(mean=1.3, std=width)]
        return origins.mixture(parts, [0.4, 0.6])

    erlang = 2.0 + 4.0 * shape
    return {
        "gaussian": lambda: origins.gaussian(mean=1.0, std=width),
        "rectangular": lambda: origins.rectangular(0.5 * (1.0 - width), 1.0 + width),
        "gw_elastic": lambda: origins.gw_elastic(shape),
        "gw_plastic": lambda: origins.gw_plastic(shape),
        "persson": lambda: origins.persson(1.0 + width, 0.3 + width),
        "lubricated": lambda: origins.lubricated(0.7 + width),
        "gw_gaussian": lambda: origins.gw_gaussian(1.0 + width, scale=1.0, law="amontons"),
        "two peaks": two_peaks,
        "gamma": lambda: stats.gamma(erlang, scale=1.0 / erlang),
        "lognorm": lambda: stats.lognorm(s=0.2 + width),
        "weibull": lambda: stats.weibull_min(1.5 + shape),
        "atom and peak": atom_and_peak,
        "grains": lambda: origins.grains(rho=0.9 + width, B=1.0),
    }


def plain_cases(name: str, law: MakeLaw, rng: np.random.Generator) -> Iterator[Case]:
    """Contacts without laws of their own, on every drive."""

    def relaxed() -> origins.Contacts:
        return origins.Contacts(law())

    forward = np.linspace(0.0, rng.uniform(2.0, 12.0), 101)
    yield Case(f"forward {name}", "forward", force_along(relaxed, forward, 1e-8))
    mean, std = rng.uniform(0.0, 0.1), rng.uniform(0.01, 0.05)

    def started() -> origins.Contacts:
        return origins.Contacts(law(), start=origins.gaussian_start(mean, std))

    if "atom" not in name:
        path = np.linspace(0.0, 4.0, 81)
        yield Case(f"start {name}", "starts", force_along(started, path, 1e-8))
    ranges = [(1.0, 3.0), (-1.0, 0.5), (0.8, 2.5), (-3.0, 0.0)]
    loop = along_turns([0.0, *(rng.uniform(low, high) for low, high in ranges)], 161)
    yield Case(f"turning {name}", "turning", force_along(relaxed, loop))
    yield Case(f"steady {name}", "steady", steady_force(relaxed))
    yield Case(f"propensity {name}", "propensity", propensity(relaxed))
    spring, drive = rng.uniform(0.02, 0.3), np.linspace(0.0, 12.0, 121)
    for slip in SLIP_RULES:
        answer = force_along(relaxed, drive, spring=spring, slip=slip)
        yield Case(f"soft {slip} {name}", "soft", answer)


def special_paths(name: str, rng: np.random.Generator, draw: int) -> Iterator[Case]:
    """Exact values for ever, a path of hundreds of generations, and islands with their poles."""
    value, std = rng.uniform(1.05, 1.3), rng.uniform(0.05, 0.3)

    def identical() -> origins.Contacts:
        return origins.Contacts(origins.identical(value))

    def gaussian() -> origins.Contacts:
        return origins.Contacts(origins.gaussian(mean=1.0, std=std))

    def islands() -> origins.Contacts:
        law = origins.domains(2.0, mean_atoms=60.0, law="area", stiffness=1.0, seed=draw + 1)
        return origins.Contacts(law)

    answer = force_along(identical, np.linspace(0.0, 20.0, 333), 1e-8)
    yield Case(f"forward {name} identical", "forward", answer)
    answer = force_along(gaussian, np.linspace(0.0, 500.0, 501), 1e-8)
    yield Case(f"forward {name} far", "forward", answer)
    yield Case(f"islands {name}", "islands", force_along(islands, np.linspace(0.0, 4.0, 41)))
