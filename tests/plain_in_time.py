"""A slider that a spring pulls forward, in equal steps of time: the plainest form of master/soft/in_time."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from origins import Contacts

CELLS = 200  # of thresholds


def pulled(
    contacts: Contacts, spring: float, velocity: float, end: float, steps: int
) -> np.ndarray:
    """F/(N_c<k>) after each step up to the time `end`, from relaxed contacts, where nothing slips; second order.

    Contacts have heat, or a delay of a whole number of steps, or both. Each cohort is born in the middle of its step.
    """
    law, step = contacts.thresholds, end / steps
    wait = round(contacts.waiting_time / step)
    edges = np.linspace(0.0, law.isf(1e-12), CELLS + 1)
    beyond, threshold = law.sf(edges), 0.5 * (edges[1:] + edges[:-1])
    # of each cohort, the start first: X at birth, share of all contacts, and the integral of their rates until now
    birthplace, share, integral = np.zeros(1), np.ones(1), np.zeros((1, CELLS))
    now, out = 0.0, 0.0
    forces, breaks = list[float](), list[float]()

    def after_step(x: float) -> tuple[np.ndarray, ...]:
        """The cohorts, and a new one, after a step to X = x; and each one's survival."""
        places = np.append(birthplace, 0.5 * (now + x))
        integrals = np.vstack([integral, np.zeros(CELLS)])
        if contacts.thermal is not None:
            halfway = 0.5 * (np.append(now - birthplace, 0.0) + x - places)
            duration = np.append(np.full(share.size, step), 0.5 * step)
            rate = contacts.thermal.rates.rate(halfway[:, None], threshold, 1.0)
            integrals = integrals + rate * duration[:, None]
        unmet = law.sf(x - places)[:, None]
        weight = np.maximum(np.minimum(unmet, beyond[:-1]) - beyond[1:], 0.0)
        survival = (weight * np.exp(-integrals)).sum(axis=1)
        if wait:  # what broke a delay ago is born
            born = breaks[-wait] if len(breaks) >= wait else 0.0
        else:  # as many as make all contacts hold
            born = (1.0 - share @ survival[:-1]) / survival[-1]
        return places, np.append(share, born), integrals, survival

    def imbalance(x: float) -> float:
        places, shares, _, survival = after_step(x)
        return spring * (drive - x) - shares @ (survival * (x - places))

    for n in range(1, steps + 1):
        drive = velocity * n * step
        x = float(brentq(imbalance, now, drive, xtol=1e-13))
        birthplace, share, integral, survival = after_step(x)
        breaks.append(1.0 - share @ survival - out + share[-1])
        now, out = x, 1.0 - share @ survival
        forces.append(spring * (drive - x))
    return np.array(forces)
