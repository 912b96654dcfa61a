"""Decoherence: the length X* over which contacts forget that they started together."""

from __future__ import annotations

import numpy as np

from master.lives.life import Life
from master.renewal.births import births_of
from master.steady.travel import Travel
from master.stick_slip.roots import (
    NEAR,
    Known,
    crowding_rate,
    leading_roots,
    root_errors,
    tail_rate,
)
from master.stick_slip.transform import Transform
from origins import Contacts

# Ratio of the longest to the mean life beyond which the few longest ones cannot be resolved.
BROAD = 1e4


def decoherence_length(contacts: Contacts, life: Life, velocity: float) -> Known:
    """X* of the slowest term e^(-X/X*), and its error; inf where nothing decays exponentially.

    It is inf for exact values alone (F is periodic or nearly so), and for a tail that falls slower
    than any exponential. Where a few contacts live more than 10,000 times as long as the mean, the
    error is inf. Where exact values have a share of the weight, roots slower than the rate at which
    infinitely many crowd may not exist, and X* is that of this rate.
    """
    wait = velocity * contacts.waiting_time
    travel = Travel(life, births_of(contacts), velocity)
    rate, off = min(tail_rate(contacts), Known(crowding_rate(travel, wait), 0.0))
    if rate == 0.0:
        return Known(np.inf, 0.0)
    if travel.longest > BROAD * travel.length:
        # X* depends on the few contacts that live longest, which the table of E does not resolve
        return Known(travel.longest, np.inf)
    transform = Transform(travel)
    found = leading_roots(transform, wait, 1, NEAR * rate)
    if found.roots.size:
        decay = -float(found.roots[0].real)
        error = float(root_errors(transform, wait, found.roots[:1])[0])
        # with a very long delay the decay may be smaller than its rounding error
        return Known(1.0 / decay, error / decay**2) if error < decay else Known(1.0 / error, np.inf)
    if found.searched >= 0.999 * NEAR * rate:
        # an undetected root may lie between NEAR and 1 times the rate
        return Known(1.0 / rate, (off + (1.0 - NEAR) * rate) / rate**2)
    return Known(0.5 / found.searched, 0.5 / found.searched)
