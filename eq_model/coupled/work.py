"""How many breaks a slider of coupled contacts takes, and whether these are too many to be followed."""

import numpy as np

from eq_model.engine import breaks_by_heat
from eq_model.whole_drive import durations
from origins import Contacts, Drive, ProportionalGrowth, Thresholds
from origins.errors import refuse
from origins.laws.compiled import compiled_rates
from origins.thresholds.law import Array

# Breaks of one slider: 40 minutes at 25 ns each, of which nothing is kept if the run is stopped.
MOST_BREAKS = 1e11
# Time of a break by a law of rates or of growth that is not compiled beside one that is: some 40 µs in place of 1 µs.
OWN_LAW = 40.0


def check_work(contacts: Contacts, drive: Drive, n: int) -> float:
    """The largest number of breaks of a slider of n contacts; InputError where it takes more, as far as is known."""
    from eq_model.coupled import ages, heat

    by_age = ages.SLOWER if contacts.growing is not None else 1.0
    by_heat = heat.SLOWER if contacts.thermal is not None else 1.0
    most = MOST_BREAKS / max(by_age, by_heat) / slower_by_own_law(contacts)
    if (breaks := expected_breaks(contacts, drive, n)) > most:
        instead = "master.solve, another slip rule" if drive.slip == "instant" else "master.solve"
        refuse(
            "slip",
            drive.slip,
            f"takes about {breaks:.1e} breaks of {n} contacts along this path, more than {most:.0e}, which "
            f"take 40 minutes; use {instead}, fewer contacts, or a shorter path",
        )
    return most


def slower_by_own_law(contacts: Contacts) -> float:
    """Time of a break beside that by laws of heat and growth that are compiled."""
    heat = contacts.thermal is not None and compiled_rates(contacts.thermal.rates) is None
    law = contacts.growing
    growth = isinstance(law, ProportionalGrowth) and law.compiled_factor is None
    return OWN_LAW if heat or growth else 1.0


def expected_breaks(contacts: Contacts, drive: Drive, n: int) -> float:
    """About how many breaks a slider of n contacts takes to the end of the path; for a refusal, so rather too few.

    Under "instant" the slider slips once F has reached the static force F_s, and slides with the kinetic force F_k from
    then on: to X = X_T - F_k/K, with n breaks per mean threshold. Under the other rules a slip breaks up to n contacts,
    and comes after each <x_s> (1 + 1/K) of the drive at the latest. Contacts of one single threshold always break
    together, so that F gets up to F_s again, and it is the same with them. After a turn of the drive F first falls to
    -F_k, or by a slip's force. A delay makes breaks rarer: then 0.
    Thresholds that grow count as if all were as large as the oldest at the end: the path is shorter beside them.
    """
    law, mean, spring = contacts.thresholds, contacts.mean_threshold, drive.spring or np.inf
    if contacts.thermal is not None:
        cold = contacts.replace(thermal=None)
        return n * often_by_heat(contacts, drive) + expected_breaks(cold, drive, n)
    ways = ways_of_legs(drive) / growth(contacts, drive)
    turned = np.arange(ways.size) > 0
    if contacts.delay is not None:
        return 0.0
    low, high = law.support()
    if drive.slip != "instant" or low == high:
        loading = mean * (1.0 + 1.0 / spring)
        return float(n * np.maximum(ways / loading - turned, 0.0).sum())
    kinetic, static = kinetic_force(law), static_force(law)
    slides = ways > (static + kinetic * turned) / spring
    return float(n * (ways - (1 + turned) * kinetic / spring)[slides].sum() / mean)


def kinetic_force(law: Thresholds) -> float:
    """F_k of steady sliding, a length."""
    return float(law.moment(2)) / (2.0 * law.mean())


def static_force(law: Thresholds) -> float:
    """The first maximum of F from relaxed contacts, or F_k if that is larger, a length: F = X - (the mean over all
    contacts of the stretch that their first breaks have released)."""
    x = np.linspace(0.0, 4.0 * law.mean(), 4001)
    force = x - np.append(0.0, np.cumsum(0.5 * (x[1:] + x[:-1]) * np.diff(law.cdf(x))))
    falls = np.flatnonzero(np.diff(force) < 0.0)
    return max(kinetic_force(law), force[falls[0]] if falls.size else 0.0)


def often_by_heat(contacts: Contacts, drive: Drive) -> float:
    """About how often a contact breaks by heat until the end of the path, or is proposed to; 0 below once."""
    if contacts.thermal is None:
        return 0.0
    rates, by_heat = contacts.thermal.rates, breaks_by_heat(contacts, lasts(drive))
    if compiled_rates(rates) is None:
        # nothing but `scale` bounds its rates, at which breaks are proposed
        by_heat = max(by_heat, rates.scale * lasts(drive))
    return by_heat * (by_heat > 1.0)


def ways_of_legs(drive: Drive) -> Array:
    """How far the drive goes from turn to turn (lengths)."""
    steps = np.diff(drive.path, prepend=0.0)
    steps = steps[steps != 0.0]
    begins = np.flatnonzero(np.diff(np.sign(steps), prepend=0.0))
    return np.add.reduceat(np.abs(steps), begins) if steps.size else np.zeros(1)


def growth(contacts: Contacts, drive: Drive) -> float:
    """The largest factor by which thresholds grow until the end of the path; 1 where they do not."""
    return contacts.oldest_threshold(lasts(drive)) / contacts.mean_threshold


def lasts(drive: Drive) -> float:
    """How long the drive takes."""
    return float(durations(drive).sum())
