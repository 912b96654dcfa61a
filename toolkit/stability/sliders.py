"""Extremes of the motion and of the slider: springs, masses, periods, turns, rests, starts, numbers of contacts."""

from functools import partial
from typing import Any, get_args

import numpy as np
import scipy.stats

import origins
from origins.contacts import Contacts
from origins.drive import SlipRule
from toolkit.stability import truths
from toolkit.stability.case import (
    REPLICAS,
    SIGMAS,
    Case,
    CaseAnswer,
    Question,
    Truth,
    bounding_factor,
)
from toolkit.stability.laws import rest
from toolkit.stability.thresholds import FORWARD, critical

NARROW, WIDE = origins.gaussian(1.0, 0.05), origins.gaussian(1.0, 0.2)
_MANY = (
    100_000  # contacts of a soft slider, which slip late by some 1.4e-4 mean thresholds (`_late`)
)
BEFORE = np.array([0.5, 0.95])  # mean thresholds: before and within the first breaks


def cases() -> list[Case | Question]:
    return [*springs(), *masses(), *motions(), *starts(), *numbers()]


def springs() -> list[Case | Question]:
    """K from 1e-9 to 1e9 N<k>, and a millionth on either side of K*, which may be infinite."""
    group, contacts = "springs", Contacts(NARROW)

    def k_star(name: str, contacts: Contacts, tolerance: float, truth: Truth) -> Question:
        return Question(
            group, name, "propensity", lambda: critical(contacts, tolerance), lambda: truth
        )

    known, exact = truths.critical(NARROW), Contacts(origins.identical(1.0))
    at_once = Truth(np.inf, 0.0, "infinite, as all contacts break at one place")
    pole = Truth(np.inf, 0.0, "infinite, as x P_c(x) is")
    found: list[Case | Question] = [
        k_star("K*", contacts, 1e-8, known),
        k_star("K* of one exact value", exact, 1e-8, at_once),
        k_star("K* of a density that diverges", Contacts(scipy.stats.beta(0.5, 0.5)), 1e-3, pole),
    ]
    why = "below K* alone F falls faster than the spring"
    for side in (-1e-6, 1e-6):
        name = f"K = K* (1 {'+' if side > 0.0 else '-'} 1e-6): does it slip?"
        ask = partial(does_it_slip, contacts, (1.0 + side) * known.values)
        truth = partial(Truth, float(side < 0.0), 0.0, why)
        found.append(Question(group, name, "master", ask, truth))
    # a stiff spring takes the slider along with the drive, but for F/K
    rigid = truths.without_laws(1e-7, "the rigid slider, in closed form")
    for rule in get_args(SlipRule):
        drive = {"spring": 1e9, "slip": rule}
        found += [
            Question(
                group,
                f"K = 1e-9, {rule}: F of the first slip",
                "master",
                partial(first_slip, contacts, rule),
                lambda: truths.first_maximum(contacts),
            ),
            Question(
                group,
                f"K = 1e-9, {rule}: first slip of 1e5 contacts",
                "ensemble",
                partial(first_slip_of_contacts, contacts, rule),
                partial(_late, contacts),
            ),
            Case(
                group, f"K = 1e9, {rule}", lambda: contacts, FORWARD, rigid, drive, n_contacts=2_000
            ),
        ]
    return found


def does_it_slip(contacts: Contacts, spring: float) -> CaseAnswer:
    """1 if the slider slips as it moves by its first 1.6 thresholds, else 0."""
    import master

    path = np.linspace(0.0, 1.6 + 1.6 / spring, 400)
    found: Any = master.solve(contacts, path, 1e-8, spring=spring, slip="reset")
    return CaseAnswer(float(found.slips.drive.size > 0), 0.0, found.success, None, found.message)


def first_slip(contacts: Contacts, rule: SlipRule) -> CaseAnswer:
    """F as the softest slider lets go, in mean thresholds."""
    import master

    found: Any = master.solve(contacts, np.linspace(0.0, 1.2e9, 50), 1e-6, spring=1e-9, slip=rule)
    before = found.slips.force_before[:1] / contacts.mean_threshold
    return CaseAnswer(before, max(found.force_error, 1e-9), found.success, 1e-6, found.message)


def first_slip_of_contacts(contacts: Contacts, rule: SlipRule) -> CaseAnswer:
    """The same of sliders of 1e5 contacts, followed one by one, whose forces scatter."""
    import eq_model

    many = {"n_contacts": _MANY, "n_replicas": REPLICAS, "seed": 1}
    path = np.linspace(0.0, 1.0e9, 50)
    found: Any = eq_model.simulate(contacts, path, spring=1e-9, slip=rule, **many)
    forces = found.slips.force_before[found.slips.number == 0] / contacts.mean_threshold
    scatter = float(forces.std(ddof=1)) / REPLICAS**0.5
    error = bounding_factor(REPLICAS) * scatter
    return CaseAnswer(forces.mean(), error, found.success and forces.size == REPLICAS)


def _late(contacts: Contacts) -> Truth:
    """The first maximum of F, which the fluctuations of N contacts pass by some 0.3 N^(-2/3) mean thresholds."""
    exact = truths.first_maximum(contacts)
    late = _MANY ** (-2.0 / 3.0)
    return Truth(exact.values, exact.error + late, f"{exact.road}, to N^(-2/3)")


def masses() -> list[Case | Question]:
    """Masses and damping from almost none to all but immovable, up to the first break."""
    group, narrow, found = "mass", partial(Contacts, NARROW), list[Case | Question]()
    for spring, mass, damping in (
        (1e-3, 1e-6, 0.0),
        (1e-3, 1.0, 1.0),
        (1e-3, 1e9, 0.0),
        (1.0, 1e-3, 1e3),
        (1.0, 1e12, 1e-12),
        (1e6, 1.0, 0.0),
    ):
        path = np.linspace(0.1, 0.7, 7) * (1.0 + spring) / spring
        truth = partial(truths.before_breaks, spring, mass, damping)
        if mass > 1e6:  # the drive runs away from the slider
            path = np.linspace(0.1, 0.6, 7)
        name = f"K = {spring:g}, M = {mass:g}, γ = {damping:g}"
        drive = {"spring": spring, "mass": mass, "damping": damping}
        found.append(Case(group, name, narrow, path, truth, drive, n_contacts=1_000))
    return found


def motions() -> list[Case | Question]:
    """A million periods, ten thousand turns, a long rest."""
    long, turns = "long paths", "turns and rests"
    swing, breaking = np.tile([0.4, -0.4], 5_000), np.tile([2.0, -2.0], 5_000)
    narrow, wide = partial(Contacts, NARROW), partial(Contacts, WIDE)
    return [
        Case(long, "1e6 periods", narrow, [0.5, 1e6], truths.steady_at_last, n_contacts=100),
        Case(long, "1e4 periods", wide, [0.5, 1e4], n_contacts=1_000),
        Case(turns, "1e4 turns, no break", narrow, swing, truths.no_break, n_contacts=1_000),
        Case(turns, "1e4 turns with breaks", wide, breaking, n_contacts=2_000),
        rest(),
    ]


def starts() -> list[Case | Question]:
    """Contacts stretched to their thresholds or beyond as the motion begins, and linked ones that hardly differ."""
    group, box = "starts", origins.rectangular(0.5, 1.0)
    near = 1.0 - 1e-12
    return [
        Case(group, "at the thresholds' mean", lambda: Contacts(NARROW, 0.999), FORWARD),
        Case(group, "just below the end of a rectangle", lambda: Contacts(box, near), FORWARD),
        Case(group, "beyond every threshold", lambda: Contacts(box, 1.5), FORWARD),
        Case(
            group,
            "linked stiffness that varies by 1e-5, no break",
            lambda: Contacts(origins.rectangular(1.0 - 1e-5, 1.0 + 1e-5), stiffness="linked"),
            np.array([0.13, 0.5, 0.0434]),
            truths.no_break,
            n_contacts=5_000,
        ),
    ]


def numbers() -> list[Case | Question]:
    """One contact, and a thousand million."""
    group, contacts = "numbers of contacts", Contacts(NARROW)
    by_hand = Truth(np.array([0.3, 0.999, 0.001, 0.25]), 1e-13, "by hand")
    of_many = partial(truths.gaussian, contacts, BEFORE)
    return [
        Question(group, "one", "ensemble", one_contact, lambda: by_hand),
        Question(group, "1e9", "ensemble", partial(crowd, contacts), of_many),
    ]


def one_contact() -> CaseAnswer:
    """The sawtooth of one contact with an exact threshold."""
    import eq_model

    path = np.array([0.3, 0.999, 1.001, 7.25])
    found = eq_model.simulate(Contacts(origins.identical(1.0)), path, n_contacts=1)
    return CaseAnswer(found.force, 1e-12, found.success, None, found.message)


def crowd(contacts: Contacts) -> CaseAnswer:
    """F of 1e9 contacts."""
    import eq_model

    found = eq_model.simulate(contacts, BEFORE, n_contacts=1_000_000_000, seed=1)
    return CaseAnswer(
        found.force, SIGMAS * found.force_standard_error, found.success, None, found.message
    )
