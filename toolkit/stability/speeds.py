"""Extremes of the speed: F far below and above the speeds at which heat acts, and a - b of rate and state."""

from functools import partial

import origins
from origins.contacts import Contacts
from toolkit.stability import truths
from toolkit.stability.case import Case, CaseAnswer, Question, Truth
from toolkit.stability.laws import PEAK, warm
from toolkit.stability.thresholds import FORWARD


def cases() -> list[Case | Question]:
    return [*speeds(), *rate_and_state()]


def speeds() -> list[Case | Question]:
    """Speeds to 0 and to infinity at one temperature, T = 0.05 <x_s>²; v in ω<x_s>."""
    group, found = "speed", list[Case | Question]()
    for speed in (1e-30, 1e-6, 1e6, 1e30):
        # a contact attempts 1/v times in its life
        fast = truths.without_laws(2.0 / speed, "T = 0, in closed form") if speed > 1.0 else None
        name, drive, contacts = f"v = {speed:g}", {"velocity": speed}, partial(warm, "soft", 0.05)
        found.append(Case(group, name, contacts, FORWARD, fast, drive, n_contacts=20_000))
    return found


def rate_and_state() -> list[Case | Question]:
    """a - b of thresholds that grow with the age, where lives are 1e9 τ_0 long and as short."""
    group, found = "rate and state", list[Case | Question]()
    for speed in (1e-9, 1e9):
        name, grown = f"β = 0.05, v τ_0 = {speed:g}: a - b", origins.strengthening(PEAK, 0.05, 1.0)
        ask, truth = partial(slope, Contacts(grown), speed), partial(truths.slope_of_grown, PEAK)
        found.append(Question(group, name, "rate_state", ask, partial(truth, 0.05, speed)))
    still = partial(Truth, 0.0, 0.0, "F at T = 0 does not hang on the speed")
    ask = partial(slope, Contacts(PEAK), 1.0)
    return [*found, Question(group, "no law in time", "rate_state", ask, still)]


def slope(contacts: Contacts, velocity: float) -> CaseAnswer:
    """a - b by the toolkit, in mean thresholds."""
    import master

    found = master.rate_state(contacts, velocity).a_minus_b
    unit = contacts.mean_threshold
    return CaseAnswer(found.value / unit, found.error / unit)
