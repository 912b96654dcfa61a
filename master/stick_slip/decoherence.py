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

# Longest lives, over the mean way, beyond which the few that live so long cannot be told from none.
BROAD = 1e4


def decoherence_length(contacts: Contacts, life: Life, velocity: float) -> Known:
    """X* of the slowest term e^(-X/X*), and its error; inf where nothing decays exponentially.

    That is so for exact values alone (periodic, or as close to it as one likes), and for a tail
    that falls slower than any exponential. Where a few live more than 10,000 times as long as the
    mean the error is inf. Where exact values hold a share of the weight, no root may be slower than
    those that crowd about the rate of their own.
    """
    wait = velocity * contacts.waiting_time
    travel = Travel(life, births_of(contacts), velocity)
    rate, off = min(tail_rate(contacts), Known(crowding_rate(travel, wait), 0.0))
    if rate == 0.0:
        return Known(np.inf, 0.0)
    if travel.longest > BROAD * travel.length:
        # X* hangs on the few contacts that live longest, which the table of E does not resolve
        return Known(travel.longest, np.inf)
    transform = Transform(travel)
    found = leading_roots(transform, wait, 1, NEAR * rate)
    if found.roots.size:
        decay = -float(found.roots[0].real)
        error = float(root_errors(transform, wait, found.roots[:1])[0])
        # a wait may be so long that rounding leaves nothing of the decay
        return Known(1.0 / decay, error / decay**2) if error < decay else Known(1.0 / error, np.inf)
    if found.searched >= 0.999 * NEAR * rate:
        # between 0.9 and 1 of the rate a root could hide
        return Known(1.0 / rate, (off + (1.0 - NEAR) * rate) / rate**2)
    return Known(0.5 / found.searched, 0.5 / found.searched)
