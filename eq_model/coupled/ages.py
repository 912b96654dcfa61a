"""Coupled contacts that have numbers, as their thresholds grow with their age, or as they break by heat.

A contact breaks as the slider reaches `zero` + fresh g(age), a place that moves on while time passes.
The queue holds the place of an earlier time, which lies before the one at which the contact breaks, however the slider
goes there. As the slider reaches it, the contact either breaks, or waits at its place of then. At each time the rest of
the way is less by a factor of about β, where thresholds strengthen by 1 + β ln(1 + age): at β = 0.03 six of these steps
pass the 2^28 units of a mean threshold. A break takes some twenty times as long as one whose threshold stays (SLOWER).
"""

from typing import Any, NamedTuple

import numpy as np

from eq_model.blocks import Whole
from eq_model.compiling import inlined
from eq_model.laws.proportional import factor, factor_of
from origins import Contacts, ProportionalGrowth, strengthening
from origins.thresholds.law import Array

# Time of a break beside that of contacts whose thresholds stay: 190 to 620 ns by slip rule, in place of 22 to 68.
SLOWER = 20.0


class NoHeat(NamedTuple):
    """Contacts break at their thresholds alone; see heat.Heat."""

    margin: int = 0


class Ages(NamedTuple):
    """The contacts of a slider by their numbers, by which the queue knows them; lengths in its units."""

    numbered: bool  # False: contacts have no numbers, and the queue knows them by their thresholds, which stay
    heat: Any  # NoHeat or heat.Heat
    growth: Any  # of thresholds, see proportional.factor
    time: float  # the unit of ages there
    fresh_ratio: float  # threshold at age 0 over the drawn one, that of contacts of the start
    fresh: Array  # threshold at age 0
    born: Array  # time of birth
    zero: Whole  # X at which the contact is relaxed
    free: Whole  # how many numbers are free, and these


def ages_of(contacts: Contacts, n: int, heat: Any) -> Ages:
    """Of n contacts that are yet to form."""
    numbered = contacts.growing is not None or not isinstance(heat, NoHeat)
    n = n if numbered else 0
    # the kernels of those that strengthen serve contacts whose thresholds stay, too
    law = contacts.growing or strengthening(contacts.thresholds, beta=0.0, time=1.0)
    assert isinstance(law, ProportionalGrowth)
    return Ages(
        numbered=numbered,
        heat=heat,
        growth=factor_of(law),
        time=law.time_unit,
        fresh_ratio=1.0 / float(law.factor(law.start_pinned_for)),
        fresh=np.empty(n),
        born=np.empty(n),
        zero=np.empty(n, np.int64),
        free=np.empty(n + 1, np.int64),
    )


@inlined
def add_contact(ages, threshold, zero, born):  # type: ignore[no-untyped-def]
    """The number of a contact with this drawn threshold that is relaxed at the position `zero`."""
    contact = ages.free[ages.free[0]]
    ages.free[0] -= 1
    ages.fresh[contact], ages.born[contact] = ages.fresh_ratio * np.float64(threshold), born
    ages.zero[contact] = zero
    return contact


@inlined
def remove_contact(ages, contact):  # type: ignore[no-untyped-def]
    """Let another contact have this number."""
    ages.free[0] += 1
    ages.free[ages.free[0]] = contact


@inlined
def remove_all(ages):  # type: ignore[no-untyped-def]
    """Let all numbers be free."""
    ages.free[0] = ages.free.size - 1
    for i in range(1, ages.free.size):
        ages.free[i] = i - 1


@inlined
def threshold_of(ages, contact, now):  # type: ignore[no-untyped-def]
    """The threshold of a contact now, a float in whole units' size."""
    age = max(now - ages.born[contact], 0.0)
    return ages.fresh[contact] * factor(ages.growth, age / ages.time)


@inlined
def place_of(ages, contact, s):  # type: ignore[no-untyped-def]
    """The position at which a contact breaks if the slider `s` is there now."""
    return ages.zero[contact] + np.int64(np.rint(threshold_of(ages, contact, s.now)))
