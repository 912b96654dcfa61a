"""Cases with random numbers: contacts with temperature, delay, ageing, growth, and joined laws."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

import origins
from oracle.case import (
    Answer,
    Array,
    Case,
    along_turns,
    force_along,
    holding_along,
    steady_force,
)


def random_law_cases(seed: int, count: int) -> Iterator[Case]:
    """`count` draws of every family of this file; another seed draws other numbers."""
    for draw in range(count):
        # each family has its own generator, so that a new family leaves the numbers of the others
        heat, waits, age, both = (np.random.default_rng([seed, draw, 10 + k]) for k in range(4))
        yield from heat_cases(f"{draw}", heat)
        yield from waiting_cases(f"{draw}", waits)
        yield from ageing_cases(f"{draw}", age)
        yield from joined_cases(f"{draw}", both)


def heat_cases(draw: str, rng: np.random.Generator) -> Iterator[Case]:
    """Both laws of the rate in both closures: forward, steady, a hold, and a soft slider."""
    for rate in ("soft", "stiff"):
        for closure in ("exact", "paper"):
            temperature = 10.0 ** rng.uniform(-2.5, -0.5)
            attempts = 10.0 ** rng.uniform(-1.0, 2.5)
            std, hold = rng.uniform(0.05, 0.3), rng.uniform(1.0, 100.0)
            thermal = origins.Thermal(rate, temperature, attempts, closure)

            def gaussian(std: float = std, thermal=thermal) -> origins.Contacts:
                return origins.Contacts(origins.gaussian(mean=1.0, std=std), thermal=thermal)

            def summits(thermal=thermal) -> origins.Contacts:
                return origins.Contacts(origins.gw_elastic(1.6), thermal=thermal)

            name = f"{draw} {rate} {closure} T={temperature:.3g} w={attempts:.3g}"
            for law, make in (("gaussian", gaussian), ("gw_elastic", summits)):
                own = f"{name} {law}"
                path = np.linspace(0.0, 5.0, 101)
                yield Case(f"heat forward {own}", "heat", force_along(make, path))
                yield Case(f"steady {own}", "steady", steady_force(make))
                place, time = slide_hold_slide(hold)
                answer = force_along(make, place, 1e-5, time=time)
                yield Case(f"hold {own}", "heat-path", answer)
            answer = force_along(gaussian, np.linspace(0.0, 6.0, 61), 1e-4, spring=0.2)
            yield Case(f"soft slider {name}", "soft-laws", answer)


def slide_hold_slide(hold: float) -> tuple[Array, Array]:
    """Positions and times: two lengths at speed 1, a hold, and two more lengths."""
    ahead = np.linspace(0.0, 2.0, 41)
    place = np.concatenate([ahead, np.full(10, 2.0), 2.0 + ahead[1:]])
    rest = 2.0 + hold * np.arange(1, 11) / 10.0
    return place, np.concatenate([ahead, rest, 2.0 + hold + ahead[1:]])


def waiting_cases(draw: str, rng: np.random.Generator) -> Iterator[Case]:
    """Delay, re-forming at many stretches, linked stiffness."""
    std, wait, again = rng.uniform(0.05, 0.3), rng.uniform(0.1, 2.0), rng.uniform(0.0, 0.4)
    law = origins.gaussian(mean=1.0, std=std)
    path, loop = np.linspace(0.0, 6.0, 121), along_turns([0.0, 2.0, -1.0, 1.5], 121)

    def delayed() -> origins.Contacts:
        return origins.Contacts(law, delay=origins.Delay(time=wait))

    def reforming() -> origins.Contacts:
        return origins.Contacts(law, reforming=origins.gaussian_start(mean=again, std=0.05))

    def linked() -> origins.Contacts:
        return origins.Contacts(law, stiffness="linked")

    def soon_back() -> origins.Contacts:
        return origins.Contacts(law, delay=origins.Delay(time=wait / 4.0))

    yield Case(f"delay {draw}", "laws", force_along(delayed, path))
    yield Case(f"delay holds {draw}", "laws", holding_along(delayed, path))
    yield Case(f"delay turning {draw}", "laws", force_along(delayed, loop))
    yield Case(f"re-forming {draw}", "laws", force_along(reforming, path))
    yield Case(f"linked {draw}", "laws", force_along(linked, path))
    answer = force_along(soon_back, np.linspace(0.0, 5.0, 51), 1e-3, spring=0.2)
    yield Case(f"soft slider delay {draw}", "soft-laws", answer)


def ageing_cases(draw: str, rng: np.random.Generator) -> Iterator[Case]:
    """Thresholds that diffuse, one by one and in the paper's closure, and grains that grow."""
    rate, older = 10.0 ** rng.uniform(-4.0, -1.0), rng.uniform(0.05, 0.3)
    old = origins.gaussian(mean=1.0, std=0.05)
    for mean, std in ((0.5, 0.1), (0.7, 0.05)):

        def ageing(mean: float = mean, std: float = std) -> origins.Contacts:
            young = origins.gaussian(mean=mean, std=std)
            return origins.Contacts(young, ageing=origins.Ageing(final=old, rate=rate))

        name = f"{draw} {mean} D={rate:.3g}"
        yield Case(f"ageing steady {name}", "ageing", steady_force(ageing))
        answer = force_along(ageing, np.linspace(0.0, 3.0, 61))
        yield Case(f"ageing forward {name}", "ageing", answer)
        answer = force_along(ageing, along_turns([0.0, 1.5, 0.3], 61), 1e-3)
        yield Case(f"ageing turning {name}", "ageing", answer)

    def one_law() -> origins.Contacts:
        ageing = origins.Ageing(final=old, rate=rate, closure="paper")
        return origins.Contacts(origins.gaussian(mean=0.5, std=0.1), ageing=ageing)

    def slowly() -> origins.Contacts:
        older_law = origins.gaussian(mean=1.2, std=0.05)
        ageing = origins.Ageing(final=older_law, rate=1e-3)
        return origins.Contacts(origins.gaussian(mean=1.0, std=older), ageing=ageing)

    def grains() -> origins.Contacts:
        return origins.Contacts(origins.growing_grains(alpha=1.0, B=1.0, age=3.0 + older))

    yield Case(f"Q15 steady {draw}", "ageing", steady_force(one_law))
    answer = force_along(slowly, np.linspace(0.0, 5.0, 51), 1e-3, spring=0.2)
    yield Case(f"soft slider ageing {draw}", "soft-laws", answer)
    yield Case(f"grains {draw}", "grains", force_along(grains, np.linspace(0.0, 3.0, 61), 1e-5))


def joined_cases(draw: str, rng: np.random.Generator) -> Iterator[Case]:
    """Temperature together with each other law: forward, turning and steady; velocity steps."""
    std, wait, again = rng.uniform(0.05, 0.3), rng.uniform(0.1, 2.0), rng.uniform(0.0, 0.1)
    rate = 10.0 ** rng.uniform(-4.0, -1.0)
    law = origins.gaussian(mean=1.0, std=std)
    thermal = origins.Thermal("soft", 10.0 ** rng.uniform(-2.0, -0.7), 10.0)
    ageing = origins.Ageing(final=origins.gaussian(mean=1.0, std=0.05), rate=rate)
    young = origins.gaussian(mean=0.7, std=0.05)
    others: dict[str, dict] = {
        "start": {"start": origins.gaussian_start(mean=0.1, std=0.03)},
        "delay": {"delay": origins.Delay(time=wait)},
        "re-forming": {"reforming": origins.gaussian_start(mean=again, std=0.05)},
        "linked": {"stiffness": "linked"},
        "ageing": {"thresholds": young, "ageing": ageing},
    }
    path, loop = np.linspace(0.0, 6.0, 121), along_turns([0.0, 2.0, -1.0, 1.5], 91)
    for other, laws in others.items():

        def make(laws: dict = laws) -> origins.Contacts:
            return origins.Contacts(**({"thresholds": law, "thermal": thermal} | laws))

        tolerance = 1e-4 if other == "ageing" else 1e-5
        name = f"heat and {other} {draw}"
        yield Case(f"{name} forward", "joined", force_along(make, path, tolerance))
        yield Case(f"{name} turning", "joined", force_along(make, loop, tolerance))
        yield Case(f"{name} steady", "steady", steady_force(make))
    yield Case(f"velocity steps {draw}", "heat-path", velocity_steps(law, thermal))


def velocity_steps(law: object, thermal: origins.Thermal) -> Callable[[], Answer]:
    """Eight legs of half a length each, in turn slow and ten times as fast."""
    clock = np.concatenate([[0.0], np.cumsum(np.tile([0.5, 0.05], 4))])
    path = np.linspace(0.0, 4.0, 81)
    time = np.interp(path, np.linspace(0.0, 4.0, 9), clock)
    return force_along(lambda: origins.Contacts(law, thermal=thermal), path, 1e-5, time=time)
