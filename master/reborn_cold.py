"""Steady sliding at T = 0 of contacts that form again at any stretch: closed in the moments of the thresholds.

A contact born at r has a threshold ξ > |r|, and moves from r to ξ, so that over its life

    C = <ξ - r>,        the integral of its force over the way is <k (ξ² - r²)>/2.
"""

import numpy as np
import numpy.typing as npt

from master.law import Law
from master.piecewise import tabulate
from master.starting import StartSum
from origins import Contacts
from origins.quadrature import panel_edges
from origins.start import Start

Array = npt.NDArray[np.float64]

_SUMS, _ROUNDING = 1e-12, 1e-15  # what sums over births are off by; and what thresholds beyond |r| are, of all


def integrals(contacts: Contacts, again: Start) -> tuple[Array, Array]:
    """C and the force integrated, a length and a square of one, and what they are off by; shapes (2,). `again` is the
    law of the stretches at which contacts form again."""
    births = Contacts(contacts.thresholds, again)
    if births.start.is_single:
        origin = np.array([births.start.mean()])
        share = 1.0 / births.thresholds.sf(np.abs(origin))
    else:
        law = Law(births, np.inf)
        nodes, shares = StartSum(births, law).sample
        origin, share = nodes.ravel() * law.unit, shares.ravel()
    linked = contacts.stiffness == "linked"
    powers = [0, 1, 1, 3] if linked else [0, 1, 0, 2]
    none, first, lower, upper = (share * beyond(contacts, power, np.abs(origin)) for power in powers)
    unit = contacts.mean_threshold if linked else 1.0
    found = np.array([(first - origin * none).sum(), 0.5 * (upper - origin**2 * lower).sum() / unit])
    whole = np.array([contacts.thresholds.moment(1), contacts.thresholds.moment(powers[3]) / unit])
    return found, _SUMS * np.abs(found) + _ROUNDING * share.sum() * whole


def beyond(contacts: Contacts, power: int, least: Array) -> Array:
    """Integral of ξ^power P_c over thresholds ξ > least."""
    law = contacts.thresholds
    if power == 0:
        return np.asarray(law.sf(least))
    atoms, weights = law.atoms
    total = law.moment(power) - ((atoms <= least[:, None]) * (weights * atoms**power)).sum(axis=1)
    edges = panel_edges(law, float(least.max())) if float(weights.sum()) < 1.0 - 1e-14 else np.empty(0)
    if edges.size > 1:
        (below,) = tabulate(lambda x: (x**power * np.where(np.isfinite(p := law.pdf(x)), p, 0.0))[None], edges, 1e-15)
        total = total - below.integral(least)
    return np.asarray(total)
