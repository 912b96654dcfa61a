"""Contacts of a slider on a spring form and break."""

import numpy as np

from eq_model.compiling import bare, entry, inlined
from eq_model.coupled.ages import add_contact, remove_all, remove_contact
from eq_model.coupled.heat import leave, leave_all, queue_position
from eq_model.coupled.queue_kernel import add_break, clear
from eq_model.draws.supply import take


@inlined
def stiffness_of(x, supply):  # type: ignore[no-untyped-def]
    return np.float64(x) / supply.mean if supply.mean > 0.0 else 1.0


@inlined
def form(s, queue, supply, ages):  # type: ignore[no-untyped-def]
    """Form one contact at the slider's present X."""
    x, r = take(supply)
    r *= s.way
    k = stiffness_of(x, supply)
    s.n_holding += 1
    s.stiffness += k
    s.force += k * np.float64(r)
    if ages.numbered:
        contact = add_contact(ages, x, s.at - r, s.now - s.age)
        add_break(queue, queue_position(ages.heat, ages, contact, s), contact)
    else:
        add_break(queue, s.at - r + x, x)


@bare
def form_many(s, queue, supply, ages, number):  # type: ignore[no-untyped-def]
    """Form contacts at the slider's present X."""
    for _ in range(number):
        form(s, queue, supply, ages)


@entry
def form_all(slider, queue, supply, ages, n):  # type: ignore[no-untyped-def]
    """Replace all contacts by n that form at the slider's present X."""
    s = slider[0]
    s.force, s.stiffness, s.n_holding, s.out, s.broken = 0.0, 0.0, 0, 0, 0
    clear(queue, s.at)
    remove_all(ages)
    leave_all(ages.heat)
    form_many(s, queue, supply, ages, n)


@inlined
def break_contact(s, queue, supply, ages, pull, x, k):  # type: ignore[no-untyped-def]
    """Break a contact at the stretch x."""
    s.n_holding -= 1
    # sums of no contacts have no rounding errors, which a soft spring would not bear
    s.force = s.force - k * np.float64(x) if s.n_holding > 0 else 0.0
    s.stiffness = s.stiffness - k if s.n_holding > 0 else 0.0
    s.broken += 1
    s.breaks += 1
    if pull.at_once:
        form(s, queue, supply, ages)
    else:
        s.out += 1


@bare
def break_numbered(s, queue, supply, ages, pull, contact):  # type: ignore[no-untyped-def]
    """Break a contact that has a number; where thresholds grow all have the same stiffness."""
    leave(ages.heat, contact)
    remove_contact(ages, contact)
    k = stiffness_of(ages.fresh[contact], supply)
    break_contact(s, queue, supply, ages, pull, s.at - ages.zero[contact], k)
