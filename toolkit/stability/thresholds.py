"""Extreme laws of thresholds: narrow and wide, nearly merged, diverging, heavy-tailed."""

import math
from functools import partial
from typing import Any

import numpy as np
import scipy.stats

import origins
from origins.contacts import Contacts
from toolkit.stability import truths
from toolkit.stability.case import Case, CaseAnswer, Question, Truth

FORWARD = np.linspace(0.3, 4.0, 12)  # mean thresholds: three cycles of breaking
BETWEEN = np.array([0.3, 0.9, 1.5, 2.4, 3.3])  # away from where narrow laws break
LATE = np.array([60.0, 80.0])  # where laws as wide as their mean have settled


def cases() -> list[Case | Question]:
    return [*widths(), *peaks(), *poles(), *tails()]


def widths() -> list[Case | Question]:
    """std/mean from 1e-6 to 10."""
    group, found = "narrow and wide", list[Case | Question]()
    for width in (1e-6, 1e-4, 1e-2):
        name, law = f"gaussian, std/mean = {width:g}", origins.gaussian(1.0, width)
        near = 1.0 + width * np.array([-3.0, -1.0, 0.0, 1.0, 3.0])
        path = np.concatenate([[0.5], near, [1.5], 2.0 * near, [2.5]])
        found.append(Case(group, name, partial(Contacts, law), path, truths.gaussian))
    found.append(tighter_than_round_off(group))
    for width in (1.0, 3.0, 10.0):
        name, spread = f"lognormal, std/mean = {width:g}", math.sqrt(math.log1p(width**2))
        law = scipy.stats.lognorm(spread, scale=math.exp(-0.5 * spread**2))
        found.append(Case(group, name, partial(Contacts, law), FORWARD, n_contacts=300_000))
        found.append(steady(group, name, law, 0.5 * (1.0 + width**2)))
    one = partial(Contacts, origins.identical(1.0))
    return [*found, Case(group, "one exact value", one, FORWARD + 0.01, truths.sawtooth)]


def tighter_than_round_off(group: str) -> Case:
    """A tolerance that no solver reaches."""
    return Case(
        group,
        "gaussian, std/mean = 1e-3, tighter than round-off",
        partial(Contacts, origins.gaussian(1.0, 1e-3)),
        np.linspace(0.3, 30.0, 12),
        truths.gaussian,
        tolerance=1e-13,
        n_contacts=0,
    )


def steady(group: str, name: str, law: object, exact: float) -> Question:
    """F_k of thresholds at T = 0 against <x_s²>/(2<x_s>²), worked out by hand."""
    truth = Truth(exact, 1e-13 * exact, "F_k from two moments")
    return Question(
        group, f"{name}: F_k", "steady_state", lambda: kinetic(Contacts(law)), lambda: truth
    )


def kinetic(contacts: Contacts, velocity: float = 1.0) -> CaseAnswer:
    """F_k by the toolkit, in mean thresholds."""
    import master

    found = master.steady_state(contacts, velocity=velocity)
    unit = contacts.mean_threshold
    return CaseAnswer(found.force / unit, found.force_error, found.success, 1e-6, found.message)


def critical(contacts: Contacts, tolerance: float = 1e-8) -> CaseAnswer:
    """K*/N<k> by the toolkit."""
    import master

    found = master.propensity(contacts, tolerance)
    return CaseAnswer(
        found.critical_spring, found.critical_spring_error, found.success, tolerance, found.message
    )


def peaks() -> list[Case | Question]:
    """Two peaks that all but merge, and one that holds all but nothing."""

    def case(name: str, one: object, other: object, weight: float = 0.5, **how: Any) -> Case:
        law = partial(origins.mixture, [one, other], [weight, 1.0 - weight])
        return Case("near-merged peaks", name, lambda: Contacts(law()), **{"path": FORWARD} | how)

    def merged(contacts: Contacts, path: np.ndarray) -> Truth:
        # two equal peaks of width s at 1 ± d are one of width (s² + d²)^(1/2), but for the fourth order of d/s
        one = truths.gaussian(Contacts(origins.gaussian(1.0, math.hypot(0.05, 1e-6))), path)
        return Truth(one.values, 1e-12, "the merged peak")

    def sawtooth(contacts: Contacts, path: np.ndarray) -> Truth:
        return Truth(np.mod(path, 1.0), 1e-8, "the merged value")

    peak, exact = origins.gaussian, origins.identical
    few = "a millionth of the contacts at a tenth of the stretch"
    return [
        case("gaussians 1e-6 apart", peak(1.0 - 1e-6, 0.05), peak(1.0 + 1e-6, 0.05), truth=merged),
        case("gaussians 0.05 apart", peak(0.95, 0.05), peak(1.05, 0.05)),
        case(few, peak(0.1, 0.001), peak(1.0, 0.1), 1e-6),
        case(
            "two exact values 1e-9 apart",
            exact(1.0),
            exact(1.0 + 1e-9),
            path=FORWARD + 0.01,
            truth=sawtooth,
        ),
    ]


def poles() -> list[Case | Question]:
    """Densities that diverge."""
    arcsine, steep = scipy.stats.beta(0.5, 0.5), origins.lubricated(1.0, power=-0.9)
    of_steep = math.gamma(0.05) * math.gamma(1.05) / (2.0 * math.gamma(0.55) ** 2)
    found = list[Case | Question]()
    for name, law, force in (("arcsine", arcsine, 0.75), ("x^-0.9 at 0", steep, of_steep)):
        group, contacts = "diverging densities", partial(Contacts, law)
        found.append(Case(group, name, contacts, FORWARD, tolerance=1e-4))
        found.append(steady(group, name, law, force))
    return found


def tails() -> list[Case | Question]:
    """Tails without a variance, without a mean."""
    group, wide, wider = "heavy tails", scipy.stats.pareto(1.5), scipy.stats.pareto(0.9)
    return [
        Case(group, "no variance: x^-2.5", lambda: Contacts(wide), FORWARD, tolerance=1e-4),
        Question(
            group,
            "no variance: F_k does not exist",
            "steady_state",
            lambda: kinetic(Contacts(wide)),
            lambda: Truth(np.inf, 0.0, "the second moment diverges"),
        ),
        Case(group, "no mean: x^-1.9", lambda: Contacts(wider), FORWARD),
    ]
