"""Extreme laws of thresholds: narrow and wide, nearly merged, diverging, heavy-tailed."""

import math
from functools import partial

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
        near = 1.0 + width * np.array([-3.0, -1.0, 0.0, 1.0, 3.0])
        path = np.concatenate([[0.5], near, [1.5], 2.0 * near, [2.5]])
        found.append(
            Case(
                group,
                f"gaussian, std/mean = {width:g}",
                partial(Contacts, origins.gaussian(1.0, width)),
                path,
                truths.gaussian,
            )
        )
    found.append(
        Case(
            group,
            "gaussian, std/mean = 1e-3, tighter than round-off",
            partial(Contacts, origins.gaussian(1.0, 1e-3)),
            np.linspace(0.3, 30.0, 12),
            truths.gaussian,
            tolerance=1e-13,
            n_contacts=0,
        )
    )
    for width in (1.0, 3.0, 10.0):
        spread = math.sqrt(math.log1p(width**2))
        law = scipy.stats.lognorm(spread, scale=math.exp(-0.5 * spread**2))
        found += [
            Case(
                group,
                f"lognormal, std/mean = {width:g}",
                partial(Contacts, law),
                FORWARD,
                n_contacts=300_000,
            ),
            steady(group, f"lognormal, std/mean = {width:g}", law, 0.5 * (1.0 + width**2)),
        ]
    found.append(
        Case(
            group,
            "one exact value",
            lambda: Contacts(origins.identical(1.0)),
            FORWARD + 0.01,
            truths.sawtooth,
        )
    )
    return found


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
    group = "near-merged peaks"

    def two(apart: float) -> Contacts:
        return Contacts(
            origins.mixture(
                [origins.gaussian(1.0 - apart, 0.05), origins.gaussian(1.0 + apart, 0.05)],
                [0.5, 0.5],
            )
        )

    def one(contacts: Contacts, path: np.ndarray) -> Truth:
        # two equal peaks of width s at 1 ± d are one of width (s² + d²)^(1/2), but for the fourth order of d/s
        merged = truths.gaussian(Contacts(origins.gaussian(1.0, math.hypot(0.05, 1e-6))), path)
        return Truth(merged.values, 1e-12, "the merged peak")

    found: list[Case | Question] = [
        Case(group, "gaussians 1e-6 apart", lambda: two(1e-6), FORWARD, one),
        Case(group, "gaussians 0.05 apart", lambda: two(0.05), FORWARD),
        Case(
            group,
            "a millionth of the contacts at a tenth of the stretch",
            lambda: Contacts(
                origins.mixture(
                    [origins.gaussian(0.1, 0.001), origins.gaussian(1.0, 0.1)], [1e-6, 1.0 - 1e-6]
                )
            ),
            FORWARD,
        ),
        Case(
            group,
            "two exact values 1e-9 apart",
            lambda: Contacts(
                origins.mixture([origins.identical(1.0), origins.identical(1.0 + 1e-9)], [0.5, 0.5])
            ),
            FORWARD + 0.01,
            lambda contacts, path: Truth(np.mod(path, 1.0), 1e-8, "the merged value"),
        ),
    ]
    return found


def poles() -> list[Case | Question]:
    """Densities that diverge."""
    group = "diverging densities"
    arcsine, steep = scipy.stats.beta(0.5, 0.5), origins.lubricated(1.0, power=-0.9)
    return [
        Case(group, "arcsine", lambda: Contacts(arcsine), FORWARD, tolerance=1e-4),
        steady(group, "arcsine", arcsine, 0.75),
        Case(group, "x^-0.9 at 0", lambda: Contacts(steep), FORWARD, tolerance=1e-4),
        steady(
            group,
            "x^-0.9 at 0",
            steep,
            math.gamma(0.05) * math.gamma(1.05) / (2.0 * math.gamma(0.55) ** 2),
        ),
    ]


def tails() -> list[Case | Question]:
    """Tails without a variance, without a mean."""
    group = "heavy tails"
    return [
        Case(
            group,
            "no variance: x^-2.5",
            lambda: Contacts(scipy.stats.pareto(1.5)),
            FORWARD,
            tolerance=1e-4,
        ),
        Question(
            group,
            "no variance: F_k does not exist",
            "steady_state",
            lambda: kinetic(Contacts(scipy.stats.pareto(1.5))),
            lambda: Truth(np.inf, 0.0, "the second moment diverges"),
        ),
        Case(group, "no mean: x^-1.9", lambda: Contacts(scipy.stats.pareto(0.9)), FORWARD),
    ]
