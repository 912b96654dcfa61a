"""Rates at which roots crowd: that of a law's own tail, and that of exact values."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from master.steady.travel import Travel
from master.stick_slip.transform import jumps_of
from origins import Contacts

# Survivals between which the tail of thresholds is looked at, terms of the fit, and ratio of the
# thresholds there above which it falls slower than any exponential.
TAILS, TERMS, SLOW = (1e-50, 1e-290), 5, 1e3
# Change of the fitted rate from term to term, and round-off, at which it has settled; fall of the
# slopes, over the last, that an exponential does not show.
SETTLED, ROUNDED, LITTLE, MARGIN = 0.2, 1e-9, 0.2, 10.0


class Rate(NamedTuple):
    """A rate and its error, per length."""

    rate: float
    error: float


def crowding_rate(travel: Travel, wait: float) -> float:
    """Rate (per length) at which exact values alone let infinitely many roots crowd, ever faster
    waves; inf without any, 0 where all break at exact values."""
    ways, weights = jumps_of(travel)
    if not ways.size:
        return np.inf
    ways, shares = ways + wait, np.log(weights)
    if np.exp(shares).sum() > 1.0 - 1e-14:
        return 0.0

    def held(rate: float) -> float:
        return float(np.logaddexp.reduce(rate * ways + shares))

    high = 1.0 / float(ways.max())
    while held(high) < 0.0:
        high *= 2.0
    return float(brentq(held, 0.0, high, xtol=1e-300, rtol=1e-14))


def tail_rate(contacts: Contacts) -> Rate:
    """At which log S falls far out; inf above, 0 below every exponential.

    Heat leaves it: the further a threshold lies beyond, the less a contact breaks before it.
    """
    law, unit = contacts.thresholds, contacts.mean_threshold
    if np.isfinite(law.support()[1]):
        return Rate(np.inf, 0.0)
    # survival is looked at on the way out: far quantiles are beyond many a distribution
    x = unit * 2.0 ** np.arange(0.0, 400.0, 0.25)
    log_survival = law.logsf(x)
    known = np.isfinite(log_survival)
    x, log_survival = x[known], log_survival[known]
    first, last = np.searchsorted(-log_survival, -np.log(TAILS)) - [0, 1]
    if first >= last:
        return Rate(np.inf, 0.0)
    if x[last] > SLOW * x[first]:
        return Rate(0.0, 0.0)
    x = np.geomspace(x[first], x[last], TERMS)
    log_survival = law.logsf(x)
    # log S = a - rate x + power log x + b/x + ...: each term more settles an exponential's rate
    u = x / x[-1]
    terms = np.stack([np.ones(u.size), -u, np.log(u), 1.0 / u, 1.0 / u**2])
    rates = [
        float(np.linalg.solve(terms[:n, -n:].T, log_survival[-n:])[1] / x[-1]) for n in (3, 4, 5)
    ]
    rounding = ROUNDED * float(-log_survival[-1] / x[-1])
    change, rest = abs(rates[1] - rates[0]), abs(rates[2] - rates[1])
    if rates[2] > 0.0 and rest <= max(SETTLED * change, rounding):
        return Rate(rates[2], rest + rounding)
    slopes = -np.diff(log_survival) / np.diff(x)
    fall = -np.diff(slopes)
    if slopes[-1] > slopes[0]:
        return Rate(np.inf, 0.0)
    if fall.sum() > LITTLE * slopes[-1]:
        return Rate(0.0, 0.0)
    # exponentials of nearly one rate, or what looks like one as far as it is seen
    settles = bool((fall > 0.0).all() and fall[-1] < 0.5 * fall[0])
    return Rate(float(slopes[-1]), MARGIN * float(fall[-1]) if settles else np.inf)
