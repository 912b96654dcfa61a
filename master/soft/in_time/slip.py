"""Slips that end at a balance, while the drive holds: the slider moves on, which takes no time."""

from collections.abc import Callable

import numpy as np
from scipy.optimize import brentq

from master.soft.in_time.cohorts import Cohorts
from master.soft.in_time.steps import Steps

# Travels, in halves of the length over which births change, that are tried for the begin of a slip: with heat F may
# rise at first, as the weakest have broken.
FIRST_TRAVELS = (0.003, 0.01, 0.03, 0.1, 0.4, 1.0)
# Travel of a slip that none of them begins, in steps: one of next to no length.
NO_SLIP = 1e-4
# Accuracy of a slip's end, in mean thresholds: that of rounding.
AT_END = 1e-15
# Step of a slip without births, in lengths over which births change: small, so that no balance is missed.
STEP_WITHOUT_BIRTHS = 0.06


def slip_without_births(contacts: Cohorts, steps: Steps) -> None:
    """Move the slider to the first balance; broken contacts stay out until then, or for their delay."""
    broken = contacts.breaks
    contacts.begin_section()
    _to_balance(contacts, steps, STEP_WITHOUT_BIRTHS * contacts.memory.scales.length, False)
    contacts.begin_section()
    contacts.repeat_later(contacts.now, contacts.breaks - broken)
    contacts.born_now()


def slip_with_births(contacts: Cohorts, steps: Steps, size: float) -> None:
    """Move the slider to the first balance, in steps of this size; broken contacts re-form at once."""
    contacts.begin_section()
    _to_balance(contacts, steps, size * steps.length, True)
    contacts.begin_section()


def _to_balance(contacts: Cohorts, steps: Steps, step: float, births: bool) -> None:
    """Move the slider to the first balance, in steps of this travel; with births they are taken one by one."""
    least, begin, travel = 0.5 * contacts.memory.scales.length, contacts.position, 0.0
    step *= steps.sign

    def imbalance(to: float) -> float:
        return steps.imbalance(contacts.trial(to, contacts.now, not births))

    first = _first_travel(imbalance, steps.sign * least)
    # beyond the steps that may only lead back to the balance at the begin
    away, low = 0.0 < abs(first) < abs(step), first or NO_SLIP * step
    while first and ((missing := imbalance(travel + step)) > 0.0 or not away):
        away |= missing > 0.0 or abs(contacts.position + travel - begin) > least
        if births:
            contacts.take(contacts.trial(step, contacts.now))
        else:
            travel += step
        low = travel
    if first and imbalance(low) > 0.0:
        low = float(brentq(imbalance, low, travel + step, xtol=AT_END * contacts.unit))
    contacts.take(contacts.trial(low, contacts.now, not births))


def _first_travel(imbalance: Callable[[float], float], least: float) -> float:
    """The first of some small travels, up to this least one, from which the slider moves on; 0 for none."""
    travels = least * np.array(FIRST_TRAVELS)
    return next((float(travel) for travel in travels if imbalance(travel) > 0.0), 0.0)
