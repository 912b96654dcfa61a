"""What solutions tell beside the force: Q(x;X), slips, verdicts, the defects of (Q15)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

import master
import origins
from oracle.case import Answer, Array, Case, MakeContacts, along_turns
from oracle.warm_families import slide_hold_slide

WIDE = origins.gaussian(1.0, 0.2)
VERDICTS = ("smooth", "stick-slip", "decaying transient", "undecided")
STRETCHES = np.linspace(-1.05, 1.55, 27)  # in mean thresholds, where Q(x;X) is read
# Densities have no error of their own. They are derivatives of numbers that are known as well as
# the force, and so lose some digits; a wrong law of survival shows at 1e-2.
DENSITY_LOSS, DENSITY_FLOOR = 1e3, 1e-6


def read_out_cases() -> Iterator[Case]:
    """All cases of this file."""
    yield from steady_distributions()
    yield from forward_distributions()
    yield from path_distributions()
    yield from slip_cases()
    yield from transient_cases()


def density_claim(error: float) -> float:
    """What is claimed for densities beside a force that is known to `error`."""
    return DENSITY_LOSS * error + DENSITY_FLOOR


def read_distribution(found: Any, unit: float) -> Array:
    """Densities at some stretches, and three moments of the shares at single stretches."""
    place, weight = found.delta_positions / unit, found.delta_weights
    moments = [float((weight * place**power).sum()) for power in range(3)]
    return np.append(found.density(STRETCHES * unit) * unit, moments)


def steady_distributions() -> Iterator[Case]:
    """Q_s(x) of smooth sliding, of each law."""
    warm = origins.Thermal("soft", 0.1)
    heat_paper = origins.Thermal("soft", 0.1, closure="paper")
    young, old = origins.gaussian(0.6, 0.08), origins.gaussian(1.0, 0.05)
    table: dict[str, MakeContacts] = {
        "none": lambda: origins.Contacts(WIDE),
        "delay": lambda: origins.Contacts(WIDE, delay=origins.Delay(0.4)),
        "linked": lambda: origins.Contacts(WIDE, stiffness="linked"),
        "re-forming at one": lambda: origins.Contacts(WIDE, reforming=0.1),
        "re-forming at many": lambda: origins.Contacts(
            WIDE, reforming=origins.gaussian_start(0.1, 0.05)
        ),
        "soft": lambda: origins.Contacts(WIDE, thermal=warm),
        "stiff": lambda: origins.Contacts(WIDE, thermal=origins.Thermal("stiff", 0.1)),
        "soft, paper's closure": lambda: origins.Contacts(WIDE, thermal=heat_paper),
        "heat and re-forming": lambda: origins.Contacts(WIDE, thermal=warm, reforming=0.1),
        "ageing": lambda: origins.Contacts(young, ageing=origins.Ageing(old, 1e-3)),
        "ageing, paper's closure": lambda: origins.Contacts(
            young, ageing=origins.Ageing(old, 1e-3, "paper")
        ),
        "grains": lambda: origins.Contacts(origins.growing_grains(1.0, 1.0, age=4.0)),
    }
    for name, make in table.items():

        def answer(make: MakeContacts = make) -> Answer:
            contacts = make()
            unit, state = contacts.mean_threshold, master.steady_state(contacts)
            values = state.distribution(STRETCHES * unit) * unit
            return Answer(values, density_claim(state.force_error), True)

        yield Case(f"Q_s(x) {name}", "distributions", answer)


def distribution_at(
    make: MakeContacts, path: Any, asked: tuple, tolerance: float, **drive: Any
) -> Callable[[], Answer]:
    """Q(x;X) of a solution; `asked` are the arguments of its `distribution`."""

    def answer() -> Answer:
        contacts = make()
        solution = master.solve(contacts, path, tolerance, **drive)
        values = read_distribution(solution.distribution(*asked), contacts.mean_threshold)
        return Answer(values, density_claim(solution.force_error), solution.success)

    return answer


def forward_distributions() -> Iterator[Case]:
    """Q(x;X) on a path that goes forward at one speed, before and after the first breaks."""
    start = origins.gaussian_start(0.1, 0.025)
    warm = origins.Thermal("soft", 0.1)
    young, old = origins.gaussian(0.6, 0.08), origins.gaussian(1.0, 0.05)
    table: dict[str, MakeContacts] = {
        "none": lambda: origins.Contacts(WIDE),
        "start": lambda: origins.Contacts(WIDE, start),
        "exact value": lambda: origins.Contacts(origins.identical(1.0)),
        "exact value and peak": lambda: origins.Contacts(
            origins.mixture([origins.identical(0.8), WIDE], [0.3, 0.7])
        ),
        "delay": lambda: origins.Contacts(WIDE, start, delay=origins.Delay(0.4)),
        "linked": lambda: origins.Contacts(WIDE, start, stiffness="linked"),
        "re-forming": lambda: origins.Contacts(WIDE, start, reforming=0.1),
        "soft": lambda: origins.Contacts(WIDE, start, thermal=warm),
        "ageing": lambda: origins.Contacts(young, start, ageing=origins.Ageing(old, 1e-3)),
        "grains": lambda: origins.Contacts(origins.growing_grains(1.0, 1.0, age=4.0)),
    }
    for name, make in table.items():
        for place in (0.43, 2.83):
            answer = distribution_at(make, np.linspace(0.0, 4.0, 41), (place,), 1e-7)
            yield Case(f"Q(x;X={place}) {name}", "distributions", answer)


def path_distributions() -> Iterator[Case]:
    """Q(x;X) on paths that turn (by place and leg) and on paths in time (by the point's number)."""
    start = origins.gaussian_start(0.1, 0.025)
    loop = along_turns([0.0, 1.6, -0.7, 1.2], 61)
    for name, begin in (("relaxed", None), ("start", start)):
        for leg, place in ((0, 1.33), (1, 0.21), (2, 0.77)):
            make = partial(origins.Contacts, WIDE, begin)
            answer = distribution_at(make, loop, (place, leg), 1e-7)
            yield Case(f"Q(x;X) turning, leg {leg}, {name}", "distributions", answer)
    place, time = slide_hold_slide(20.0)
    laws: dict[str, dict] = {
        "soft": {"thermal": origins.Thermal("soft", 0.1)},
        "stiff": {"thermal": origins.Thermal("stiff", 0.1)},
        "soft, paper's closure": {"thermal": origins.Thermal("soft", 0.1, closure="paper")},
        "delay": {"delay": origins.Delay(0.4)},
        "linked": {"stiffness": "linked"},
        "re-forming": {"reforming": 0.1},
    }
    for name, law in laws.items():
        for point in (30, 48, 70):
            warm = partial(origins.Contacts, WIDE, **law)
            answer = distribution_at(warm, place, (point,), 1e-5, time=time)
            yield Case(f"Q(x;X) hold, point {point}, {name}", "distributions", answer)


def slips_of(make: MakeContacts, path: Any, tolerance: float, **drive: Any) -> Callable[[], Answer]:
    """Slips of a soft slider and the verdict on it.

    Where a slip begins F + K X is flat, so X and F there, and where it leads, are known to the root
    of the force's error only.
    """

    def answer() -> Answer:
        contacts = make()
        unit = contacts.mean_threshold
        solution = master.solve(contacts, path, tolerance, **drive)
        slips, regime = solution.slips, solution.regime
        lengths = [slips.before, slips.after, slips.force_before, slips.force_after]
        values = np.concatenate([slips.drive, *lengths]) / unit
        spread = max(1.0, 1.0 / drive["spring"]) * np.sqrt(solution.force_error)
        claims = [np.full(slips.drive.size, slips.drive_error / unit)]
        claims.append(np.full(4 * slips.drive.size, spread))
        verdict = [float(VERDICTS.index(regime.verdict)), regime.critical_spring]
        values = np.concatenate([values, [solution.balance / unit], verdict])
        claims.append(np.array([1e-12, 0.0, regime.critical_spring_error]))
        return Answer(values, np.concatenate(claims), solution.success)

    return answer


def slip_cases() -> Iterator[Case]:
    """Slips and verdicts: each rule, each verdict, without laws and with them."""
    narrow = origins.gaussian(1.0, 0.05)
    forward, long = np.linspace(0.0, 7.0, 141), np.linspace(0.0, 25.0, 251)
    plain = partial(origins.Contacts, narrow)
    started = partial(origins.Contacts, narrow, origins.gaussian_start(0.1, 0.025))
    for slip in ("reset", "reform-after", "instant"):
        answer = slips_of(plain, forward, 1e-7, spring=1.0, slip=slip)
        yield Case(f"slips {slip}, narrow", "slips", answer)
        answer = slips_of(started, forward, 1e-7, spring=1.0, slip=slip)
        yield Case(f"slips {slip}, narrow, started", "slips", answer)
        answer = slips_of(plain, long, 1e-5, spring=0.5, slip=slip)
        yield Case(f"slips {slip}, narrow, long", "slips", answer)
    answer = slips_of(plain, forward, 1e-7, spring=10.0)
    yield Case("slips none, stiff spring", "slips", answer)
    laws: dict[str, tuple[MakeContacts, float]] = {
        "soft": (lambda: origins.Contacts(narrow, thermal=origins.Thermal("soft", 0.01)), 1.0),
        "stiff": (lambda: origins.Contacts(narrow, thermal=origins.Thermal("stiff", 0.01)), 1.0),
        "delay": (lambda: origins.Contacts(narrow, delay=origins.Delay(0.2)), 1.0),
        "linked": (lambda: origins.Contacts(narrow, stiffness="linked"), 1.0),
        "re-forming": (lambda: origins.Contacts(narrow, reforming=0.05), 1.0),
    }
    for name, (make, spring) in laws.items():
        for slip in ("reset", "reform-after"):
            answer = slips_of(make, np.linspace(0.0, 5.0, 51), 1e-4, spring=spring, slip=slip)
            yield Case(f"slips {slip}, {name}", "slips", answer)
    ageing = origins.Ageing(origins.gaussian(1.0, 0.02), 5e-4)

    def figure() -> origins.Contacts:
        start = origins.gaussian_start(0.02, 0.01)
        return origins.Contacts(origins.gaussian(0.5, 0.05), start, ageing=ageing)

    path = np.linspace(0.02 / 3.5, 1.5, 101)
    answer = slips_of(figure, path, 1e-3, spring=3.5, velocity=6.0)
    yield Case("slips of Fig. A06, v = 6", "slips", answer)


def transient_cases() -> Iterator[Case]:
    """(Q15) as printed along Fig. A04, with what it does not keep."""
    for end in (0.7, 2.0):

        def answer(end: float = end) -> Answer:
            fresh, old = origins.gaussian(0.5, 0.05), origins.gaussian(1.0, 0.02)
            contacts = origins.Contacts(
                fresh,
                origins.gaussian_start(0.1, 0.025),
                ageing=origins.Ageing(old, 5e-4, "paper"),
            )
            found = master.solve(contacts, np.linspace(0.0, end, 21), 1e-2)
            force = found.force / contacts.mean_threshold
            # mass and sign are kept, or lost, as well as the force is known
            values = np.concatenate([force, found.mass_defect, found.positivity_defect])
            return Answer(values, max(found.force_error, 1e-9), found.success)

        yield Case(f"Q15 transient to {end}", "ageing", answer)
