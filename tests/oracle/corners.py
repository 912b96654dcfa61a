"""Laws and calls at their ends: singular densities, exact values, extremes, weak places."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

import origins
from oracle.case import (
    Answer,
    Case,
    MakeContacts,
    along_turns,
    force_along,
    propensity,
    steady_force,
)

MakeLaw = Callable[[], object]


def corner_cases() -> Iterator[Case]:
    """All cases of this file."""
    yield from hard_law_cases()
    yield from start_cases()
    yield from unit_cases()
    yield from island_cases()
    yield from weak_places()
    yield from static_forces()
    yield from answered_extremes()


def hard_laws() -> dict[str, MakeLaw]:
    """Laws with poles, jumps, gaps, exact values, fat tails, next to no width, and extreme ones."""
    from scipy import stats

    def joined(parts: list, weights: list[float]) -> Callable[[], object]:
        return lambda: origins.mixture(parts, weights)

    peak, slab = origins.gaussian(1.0, 0.1), origins.rectangular(0.4, 0.9)
    samples = np.random.default_rng(7).gamma(3.0, 1.0 / 3.0, 200)
    return {
        "arcsine": lambda: stats.arcsine(scale=2.0),
        "beta(0.3, 0.3)": lambda: stats.beta(0.3, 0.3, scale=2.0),
        "gamma(0.5)": lambda: stats.gamma(0.5),
        "exponential": lambda: stats.expon(),
        "half normal": lambda: stats.halfnorm(),
        "triangular": lambda: stats.triang(0.4, scale=2.0),
        "lomax": lambda: stats.lomax(2.5, scale=1.5),
        "wide lognormal": lambda: stats.lognorm(1.0),
        "gap": joined([origins.rectangular(0.2, 0.4), peak], [0.3, 0.7]),
        "one exact value beside a slab": joined([origins.identical(0.7), slab], [0.4, 0.6]),
        "two exact values and a peak": joined(
            [origins.identical(0.6), origins.identical(1.2), peak], [0.2, 0.3, 0.5]
        ),
        "two exact values": joined([origins.identical(0.95), origins.identical(1.05)], [0.5, 0.5]),
        "exact values without divisor": joined(
            [origins.identical(1.0), origins.identical(2.0**0.5)], [0.5, 0.5]
        ),
        "very narrow": lambda: origins.gaussian(1.0, 1e-3),
        "very wide": lambda: origins.gaussian(1.0, 2.0),
        "samples": lambda: origins.from_samples(samples),
        "gw_gaussian far": lambda: origins.gw_gaussian(40.0, 1.0),
        "gw_gaussian pressed in": lambda: origins.gw_gaussian(-3.0, 1.0),
        "gw_gaussian mixed": lambda: origins.gw_gaussian(
            1.0, 1.7, law="amontons", regime="mixed", plasticity_index=10.0
        ),
        "gw_gaussian strength": lambda: origins.gw_gaussian(1.0, 1.7, law="strength"),
        "persson wide": lambda: origins.persson(1e-3, 1.0),
        "persson narrow": lambda: origins.persson(10.0, 1.0),
        "grains just pinned": lambda: origins.grains(2.0 / 3.0 * (1.0 + 1e-6), B=1.0),
        "lubricated, power -0.5": lambda: origins.lubricated(1.0, power=-0.5),
    }


def hard_law_cases() -> Iterator[Case]:
    """Each hard law forward, turning, on a spring, steady, and its propensity."""
    for name, law in hard_laws().items():
        unit = origins.Contacts(law()).mean_threshold

        def make(law: MakeLaw = law) -> origins.Contacts:
            return origins.Contacts(law())

        forward = np.linspace(0.0, 5.0, 101) * unit
        loop = along_turns([0.0, 1.6, -0.7, 1.2], 61) * unit
        drive = np.linspace(0.0, 8.0, 81) * unit
        yield Case(f"hard law forward: {name}", "hard laws", force_along(make, forward, 1e-7))
        yield Case(f"hard law turning: {name}", "hard laws", force_along(make, loop, 1e-6))
        yield Case(
            f"hard law soft: {name}", "hard laws", force_along(make, drive, 1e-5, spring=0.1)
        )
        yield Case(f"hard law steady: {name}", "hard laws", steady_force(make))
        yield Case(f"hard law propensity: {name}", "hard laws", propensity(make, tolerance=1e-7))


def start_cases() -> Iterator[Case]:
    """Starts at one stretch, wide ones, behind 0, close to the thresholds, and beyond most."""
    from scipy import stats

    wide = origins.gaussian(1.0, 0.2)
    laws: dict[str, MakeLaw] = {
        "gaussian": lambda: wide,
        "rectangular": lambda: origins.rectangular(0.5, 1.5),
        "gw_elastic": lambda: origins.gw_elastic(1.6),
        "exact value and peak": lambda: origins.mixture([origins.identical(0.8), wide], [0.4, 0.6]),
    }
    starts: dict[str, Callable[[], object]] = {
        "at 0.3": lambda: 0.3,
        "at -0.4": lambda: -0.4,
        "at 1.1": lambda: 1.1,
        "uniform": lambda: stats.uniform(-0.2, 0.3),
        "wide": lambda: origins.gaussian_start(0.0, 0.1),
        "narrow": lambda: origins.gaussian_start(0.05, 1e-3),
    }
    path, loop = np.linspace(0.0, 4.0, 81), along_turns([0.0, 1.6, -0.7, 1.2], 61)
    warm = origins.Thermal("soft", 0.05)
    for law_name, law in laws.items():
        for start_name, start in starts.items():

            def make(law: MakeLaw = law, start=start) -> origins.Contacts:
                return origins.Contacts(law(), start())

            def heated(law: MakeLaw = law, start=start) -> origins.Contacts:
                return origins.Contacts(law(), start(), thermal=warm)

            name = f"{start_name}: {law_name}"
            yield Case(f"start forward {name}", "starts", force_along(make, path, 1e-8))
            yield Case(f"start turning {name}", "starts", force_along(make, loop, 1e-6))
            yield Case(f"start heat {name}", "starts", force_along(heated, path, 1e-6))


def unit_cases() -> Iterator[Case]:
    """The same in lengths a thousand million times as small and as large."""
    for unit in (1e-9, 1e9):

        def plain(unit: float = unit) -> origins.Contacts:
            start = origins.gaussian_start(0.1 * unit, 0.03 * unit)
            return origins.Contacts(origins.gaussian(unit, 0.2 * unit), start)

        def warm(unit: float = unit) -> origins.Contacts:
            thermal = origins.Thermal("stiff", 0.05 * unit**2)
            return origins.Contacts(origins.gaussian(unit, 0.2 * unit), thermal=thermal)

        path = np.linspace(0.0, 4.0, 81) * unit
        loop = along_turns([0.0, 1.6, -0.7, 1.2], 61) * unit
        yield Case(f"unit {unit:g} forward", "units", force_along(plain, path, 1e-8))
        yield Case(f"unit {unit:g} turning", "units", force_along(plain, loop, 1e-8))
        yield Case(f"unit {unit:g} soft", "units", force_along(plain, path, 1e-6, spring=0.2))
        answer = force_along(warm, path, 1e-6, velocity=unit)
        yield Case(f"unit {unit:g} heat", "units", answer)
        answer = force_along(warm, loop, 1e-5, velocity=unit)
        yield Case(f"unit {unit:g} heat turning", "units", answer)
        yield Case(f"unit {unit:g} propensity", "units", propensity(plain))


def island_cases() -> Iterator[Case]:
    """Rotated islands, whose P_c has inverse-square-root peaks."""

    def islands() -> origins.Contacts:
        return origins.Contacts(
            origins.domains(2.0, mean_atoms=60.0, law="area", stiffness=1.0, seed=3)
        )

    def alike() -> origins.Contacts:
        return origins.Contacts(origins.domains(1.0, sizes=[(7, 9)], angles=[0.0], stiffness=1.0))

    def warm() -> origins.Contacts:
        return origins.Contacts(islands().thresholds, thermal=origins.Thermal("soft", 0.05))

    for name, make in {"islands": islands, "islands alike": alike, "islands, soft": warm}.items():
        unit = make().mean_threshold
        path = np.linspace(0.0, 5.0, 81) * unit
        loop = along_turns([0.0, 1.6, -0.7, 1.2], 61) * unit
        yield Case(f"{name} forward", "islands", force_along(make, path, 1e-5))
        yield Case(f"{name} turning", "islands", force_along(make, loop, 1e-4))
        yield Case(f"{name} steady", "islands", steady_force(make))
        if make is not warm:
            answer = force_along(make, path, 1e-5, spring=0.1)
            yield Case(f"{name} on a spring", "islands", answer)


def weak_places() -> Iterator[Case]:
    """Calls on which commit ee6a1b9 is slow, or claims far more error than it makes."""
    loop = along_turns([0.0, 2.0, -1.0, 1.5], 61)
    law = origins.gaussian(1.0, 0.2)
    old = origins.Ageing(origins.gaussian(1.0, 0.05), 1e-3)

    def hot(law: object, attempts: float) -> MakeContacts:
        return partial(origins.Contacts, law, thermal=origins.Thermal("soft", 0.3, attempts))

    # what it claims here is above 1e-2, and what it makes 4e-7
    far, narrow = np.linspace(0.0, 1e4, 26), lambda: origins.Contacts(origins.gaussian(1.0, 0.01))
    yield Case("weak: narrow and far", "weak places", force_along(narrow, far, 3e-2))
    stiff = partial(origins.Contacts, law, thermal=origins.Thermal("stiff", 0.1))
    young = partial(origins.Contacts, origins.gaussian(0.7, 0.05), ageing=old)
    for tolerance in (1e-5, 1e-8):
        answer = force_along(stiff, loop, tolerance)
        yield Case(f"weak: stiff on three turns, {tolerance:g}", "weak places", answer)
    for tolerance in (1e-3, 1e-4):
        answer = force_along(young, loop, tolerance)
        yield Case(f"weak: ageing on three turns, {tolerance:g}", "weak places", answer)
    for name, open_law in (
        ("summits", origins.gw_gaussian(1.0, 1.0, law="amontons")),
        ("gaussian cut at 0", origins.gaussian(1.0, 1.0)),
        ("rectangular from 0", origins.rectangular(0.0, 1.0)),
    ):
        answer = force_along(hot(open_law, 1e4), np.linspace(0.0, 2.0, 41), 1e-5)
        yield Case(f"weak: hot {name} forward", "weak places", answer)
        # few attempts and a short way, or it is refused as too much work
        answer = force_along(hot(open_law, 1e2), 0.3 * loop, 1e-5)
        yield Case(f"weak: hot {name} turning", "weak places", answer)
    steps = np.linspace(0.0, 6.0, 301)
    clock = np.concatenate([[0.0], np.cumsum(np.tile([0.2, 0.02], 150))])
    soft = partial(origins.Contacts, law, thermal=origins.Thermal("soft", 0.1))
    answer = force_along(soft, steps, 1e-4, time=clock)
    yield Case("weak: 300 velocity steps", "weak places", answer)


def static_forces() -> Iterator[Case]:
    """Slide, hold, slide: the peak of docs/sliders.md after rests of up to a million."""
    law, thermal = origins.gaussian(1.0, 0.2), origins.Thermal("soft", 0.1)
    ahead = np.linspace(0.0, 2.0, 101)
    for rest in (1e2, 1e4, 1e6):
        path = np.concatenate([ahead, 2.0 + ahead])
        time = np.concatenate([ahead, 2.0 + rest + ahead])
        make = partial(origins.Contacts, law, thermal=thermal)
        yield Case(f"rest of {rest:g}", "heat-path", force_along(make, path, 1e-6, time=time))


def answered_extremes() -> Iterator[Case]:
    """Rows of docs/extremes.md that are answered: properties of laws at their ends."""
    pull = [0.9 + 0.01 * k for k in range(20)]
    calls: dict[str, Callable[[], float]] = {
        "gw_gaussian(40) mean": lambda: origins.gw_gaussian(40.0, 1.0).mean(),
        "gw_gaussian(-3) mean": lambda: origins.gw_gaussian(-3.0, 1.0).mean(),
        "persson(1e-3) mean": lambda: origins.persson(1e-3, 1.0).mean(),
        "persson(1e3) std": lambda: origins.persson(1e3, 1.0).std(),
        "grains just pinned": lambda: origins.grains(2 / 3 * (1 + 1e-6), B=1.0).mean(),
        "one atom": lambda: origins.triangular_barrier(1.0, 1, 1, 0.3),
        "ten million atoms": lambda: origins.triangular_barrier(1.0, 10_000, 1_000, 0.3),
        "no rotation": lambda: origins.triangular_barrier(1.0, 10_000, 1_000, 0.0),
        "superlubric": lambda: origins.triangular_barrier(2 * np.pi / 7, 7, 1, 0.0),
        "islands alike": lambda: origins.domains(
            1.0, sizes=[(7, 9)], angles=[0.0], stiffness=1.0
        ).std(),
        "equal samples": lambda: origins.from_samples([0.7, 0.7, 0.7]).std(),
        "a weight of nothing": lambda: origins.from_samples(
            [1.0, 2.0], weights=[1e300, 1e-300]
        ).std(),
        "a far sample": lambda: origins.from_samples([*pull, 50.0]).sf(10.0) * 21,
        "cold rate": lambda: origins.Thermal("soft", temperature=1e-6).log_rate(0.0, 1.0),
        "hot rate": lambda: origins.Thermal("stiff", temperature=1e3).rate(0.0, 1.0),
    }
    for name, call in calls.items():

        def answer(call: Callable[[], float] = call) -> Answer:
            value = float(call())
            # the page prints nine digits
            return Answer(value, 1e-9 * abs(value), True)

        yield Case(f"extreme: {name}", "extremes", answer)
