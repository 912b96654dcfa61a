"""Stiff and extreme laws of contacts: heat, ageing, strengthening, delays, grains that grow."""

import math
from functools import partial
from typing import Any

import numpy as np

import origins
from origins.contacts import Contacts
from origins.thresholds.law import Array
from toolkit.stability import truths
from toolkit.stability.case import Case, Question
from toolkit.stability.thresholds import FORWARD, LATE, kinetic

PEAK = origins.gaussian(1.0, 0.1)  # so far from 0 that F has a closed form at T = 0
BOLTZMANN = 1.380649e-23  # J/K


def cases() -> list[Case | Question]:
    groups = heat, eyring, room, ageing, strengthening, delays, reforming, grains
    return [case for group in groups for case in group()]


def warm(law: str, temperature: float, attempts: float = 1.0) -> Contacts:
    """Contacts at a temperature in <x_s>², which attempt `attempts` times a mean threshold of the way."""
    return Contacts(PEAK, thermal=origins.Thermal(law, temperature, attempts))


def heat() -> list[Case | Question]:
    """Temperatures from far below all barriers to far above them, and attempts that are rare or all but continuous."""
    group, found = "heat", list[Case | Question]()
    for law in ("soft", "stiff"):
        # heat breaks contacts within some T/x_s of their threshold (stiff: T^(2/3)), which moves F by as much
        unmoved = truths.without_laws(3e-6, "T = 0, in closed form")
        boiling = truths.at_rates(passed_when_soft if law == "soft" else passed_when_stiff)
        found += [
            Case(group, f"{law}, T = 1e-9", partial(warm, law, 1e-9, 1e-3), FORWARD, unmoved),
            Case(group, f"{law}, T = 1e-3", partial(warm, law, 1e-3, 10.0), FORWARD),
            Case(group, f"{law}, T = 1e9", partial(warm, law, 1e9, 2.0), LATE, boiling),
        ]
    for power in (3, 6, 12):
        name, contacts = f"ω<x_s>/v = 1e{power}, T = 0.02", partial(warm, "soft", 0.02, 10.0**power)
        found.append(Case(group, name, contacts, FORWARD, n_contacts=20_000))
    return found


def passed_when_soft(x: Array, threshold: Array) -> Array:
    """Attempts of a soft contact far above all barriers, 2 per mean threshold, from 0 to x."""
    return 2.0 * x


def passed_when_stiff(x: Array, threshold: Array) -> Array:
    """Attempts of a stiff contact far above all barriers, 2 (1 - x/x_s)^(1/2) per mean threshold, from 0 to x."""
    return 2.0 * threshold * (1.0 - (1.0 - x / threshold) ** 1.5) / 1.5


def passed_by_eyring(x: Array, threshold: Array) -> Array:
    """Breaks that exp(x/x_s - 1) per mean threshold brings about from 0 to x."""
    return threshold * (np.exp(x / threshold - 1.0) - math.exp(-1.0))


def eyring() -> list[Case | Question]:
    """Eyring's α from below its least to its largest, and attempts from rare to all but continuous."""

    def contacts(width: float, attempts: float = 1.0) -> Contacts:
        return Contacts(PEAK, thermal=origins.Thermal("eyring", None, attempts, width=width))

    group, rates = "Eyring's heat", truths.at_rates(passed_by_eyring)
    # contacts break within some α of their threshold, which moves F by as much times α ω<x_s>/v
    unmoved = truths.without_laws(3e-6, "T = 0, in closed form")
    found: list[Case | Question] = [
        Case(group, "α = 1e-6", partial(contacts, 1e-6), FORWARD, unmoved),
        Case(group, "α = 1", partial(contacts, 1.0), LATE, rates),
        Case(group, "α below its least", partial(contacts, 1e-9), FORWARD),
    ]
    for attempts in (1e-9, 1e6, 1e12):
        name = f"ω<x_s>/v = {attempts:g}, α = 0.03"
        still = truths.without_laws(1e-8, "T = 0, in closed form") if attempts < 1.0 else None
        heated = partial(contacts, 0.03, attempts)
        found.append(Case(group, name, heated, FORWARD, still, n_contacts=20_000))
    return found


def strengthening() -> list[Case | Question]:
    """Thresholds that grow by β in each e-fold of the age: no growth, all there may be, and rests of 1e9 lives."""

    def contacts(beta: float, time: float, law: origins.Thresholds = PEAK) -> Contacts:
        return Contacts(origins.strengthening(law, beta, time))

    group = "strengthening"
    # they grow by β ln(1 + 2e3) at most on the way, in the first case, and by 2/τ_0 in the second
    still = truths.without_laws(1e-10, "no growth, in closed form")
    young = truths.without_laws(1e-7, "no growth, in closed form")
    found: list[Case | Question] = [
        Case(group, "β = 1e-12, τ_0 = 1e-3", partial(contacts, 1e-12, 1e-3), FORWARD, still),
        Case(group, "β = 1, τ_0 = 1e9", partial(contacts, 1.0, 1e9), FORWARD, young),
        Case(group, "β = 0.05, τ_0 = 1e-6", partial(contacts, 0.05, 1e-6), FORWARD),
        Case(group, "β = 1, τ_0 = 1e-9", partial(contacts, 1.0, 1e-9), 20.0 * FORWARD),
        Case(group, "β = 2", partial(contacts, 2.0, 1.0), FORWARD),
        Case(
            group,
            "a rest of 1e9 lives, then no break",
            partial(contacts, 0.05, 1.0, origins.gaussian(1.0, 0.05)),
            [0.5, 0.5, 1.2],
            truths.no_break,
            {"time": [0.5, 1e9, 1e9 + 0.7]},
        ),
    ]
    for beta, speed in ((0.05, 1e-30), (1.0, 1e-9), (1.0, 1.0), (0.05, 1e30)):
        name, ask = f"β = {beta:g}, v τ_0 = {speed:g}: F_k", partial(kinetic, contacts(beta, 1.0))
        truth = partial(truths.grown, PEAK, beta, speed)
        found.append(Question(group, name, "steady_state", partial(ask, speed), truth))
    return found


def room() -> list[Case | Question]:
    """Contacts of real size at 300 K, attempts at 1e12/s, 1 µm/s: k <x_s>² of 2e11 and of 24 k_BT."""

    def case(name: str, length: float, stiffness: float, truth: Any, n_contacts: int) -> Case:
        def contacts() -> Contacts:
            law, warmth = origins.gaussian(length, 0.1 * length), BOLTZMANN * 300.0 / stiffness
            return Contacts(law, thermal=origins.Thermal("soft", warmth, 1e12))

        group, drive = "300 K in SI units", {"velocity": 1e-6}
        return Case(
            group, name, contacts, FORWARD, truth, drive, tolerance=1e-5, n_contacts=n_contacts
        )

    # attempts break contacts where their barrier is ln(ω x_s/v) = 28 k_BT: 1e-9 of a threshold earlier
    unmoved = truths.without_laws(1e-6, "T = 0, in closed form")
    return [
        case("contacts of a micrometre, 1e3 N/m each", 1e-6, 1e3, unmoved, 100_000),
        case("contacts of a nanometre, 0.1 N/m each", 1e-9, 0.1, None, 20_000),
    ]


def ageing() -> list[Case | Question]:
    """D/v from 1e-8 to 1e4 <x_s>, from gaussian(0.5, 0.05) to gaussian(0.8, 0.2)."""
    group, found = "ageing", list[Case | Question]()
    young, old = origins.gaussian(0.5, 0.05), origins.gaussian(0.8, 0.2)
    # thresholds move by (2 D t)^(1/2) = 1e-4 in a life
    unaged = truths.without_laws(1e-3, "without ageing, to 1e-3")
    for rate in (1e-8, 1e-4, 1e-2, 1.0, 1e4):
        contacts = partial(Contacts, young, ageing=origins.Ageing(old, rate))
        truth = unaged if rate == 1e-8 else None
        many = 2_000 if rate < 1e3 else 20  # each breaks and forms many times a threshold
        name, path = f"D = {rate:g}", FORWARD[:6]
        found.append(Case(group, name, contacts, path, truth, tolerance=1e-4, n_contacts=many))
    return found


def delays() -> list[Case | Question]:
    """Contacts that wait for 1e-9 to 100 <x_s> of the way before they form again."""
    group, found = "delay", list[Case | Question]()
    for delay in (1e-9, 1e-3, 1.0, 100.0):
        waiting = Contacts(PEAK, delay=origins.Delay(delay))
        contacts, truth = partial(Contacts, PEAK, delay=origins.Delay(delay)), truths.waiting(delay)
        ask, truth_of = partial(kinetic, waiting), partial(truth, waiting, np.zeros(1))
        found += [
            Case(group, f"of {delay:g}, the first breaks", contacts, FORWARD),
            Question(group, f"of {delay:g}: F_k", "steady_state", ask, truth_of),
        ]
    return found


def reforming() -> list[Case | Question]:
    """Contacts that form with stretches of 1e-9, of 0.1 and of 1 <x_s>."""
    group = "forming with a stretch"
    # which moves F by the mean stretch 0, and by its square
    relaxed = truths.without_laws(1e-8, "relaxed contacts, in closed form")
    return [
        Case(
            group,
            f"{width:g} <x_s> wide",
            partial(Contacts, PEAK, reforming=origins.boltzmann_reforming(width**2)),
            FORWARD,
            relaxed if width < 1e-6 else None,
            n_contacts=20_000,
        )
        for width in (1e-9, 0.1, 1.0)
    ]


def grains() -> list[Case | Question]:
    """Grains that grow as contacts slide, slowly and fast, from half as old again as those that just pin."""
    group, found = "growing grains", list[Case | Question]()
    for alpha in (0.1, 1.0):
        age = 1.5 * (2.0 / (3.0 * alpha)) ** 3
        contacts = partial(Contacts, origins.growing_grains(alpha=alpha, B=1.0, age=age))
        name, path = f"alpha = {alpha:g}", FORWARD[:8]
        found.append(Case(group, name, contacts, path, tolerance=1e-5, n_contacts=20_000))
    return found


def rest() -> Case:
    """A rest of 1e9 lives of warm contacts."""
    life = math.exp(1.0 / (2.0 * 0.05))  # of a contact that is not stretched
    return Case(
        "turns and rests",
        "a rest of 1e9 lives at T = 0.05",
        lambda: warm("soft", 0.05),
        [0.5, 0.5],
        truths.all_gone_at_last,
        {"time": [0.5, 1e9 * life]},
    )
