"""Steady sliding at T = 0 of contacts that form again at any stretch: closed in the moments of the thresholds.

A contact born at r has a threshold ξ > |r|, and moves from r to ξ, so that over its life

    C = <ξ - r>,        the integral of its force over the way is <k (ξ² - r²)>/2.
"""

import numpy as np
import numpy.typing as npt

from master._old.law import Law
from master._old.piecewise import tabulate
from master._old.starting import StartSum
from origins import Contacts
from origins.start import Start
from origins.thresholds.quadrature import gauss, panel_edges

Array = npt.NDArray[np.float64]

_SUMS, _ROUNDING = 1e-12, 1e-15  # what sums over births are off by; and what thresholds beyond |r| are, of all
_DEEP = 1e-3  # of the thresholds: beyond, the rest of them may be known better by itself
_DECADES, _LEAST = 40, 1e-300


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
    found = np.array([first - origin * none, 0.5 * (upper - origin**2 * lower) / unit])
    whole = np.array([contacts.thresholds.moment(1), contacts.thresholds.moment(powers[3]) / unit])
    off = _ROUNDING * share * whole[:, None]
    deep = np.flatnonzero(contacts.thresholds.sf(np.abs(origin)) < _DEEP)
    if deep.size:
        other, other_off = _in_the_tail(contacts, origin[deep], none[deep], linked)
        better = other_off < off[:, deep]
        found[:, deep] = np.where(better, other, found[:, deep])
        off[:, deep] = np.where(better, other_off, off[:, deep])
    total = found.sum(axis=1)
    return total, _SUMS * np.abs(total) + off.sum(axis=1)


def _in_the_tail(contacts: Contacts, origin: Array, share: Array, linked: bool) -> tuple[Array, Array]:
    """C and the force integrated, times the `share` of births at each origin, and their errors, shapes (2, n): from
    what is left of the thresholds beyond, which no difference of large numbers tells."""
    found, off = np.zeros((2, origin.size)), np.zeros((2, origin.size))
    for k, least in enumerate(np.abs(origin).tolist()):
        found[:, k], off[:, k] = _excess(contacts, least, linked)
    found[0] += np.abs(origin) - origin
    return share * found, share * (off + _SUMS * np.abs(found))


def _excess(contacts: Contacts, least: float, linked: bool) -> tuple[Array, Array]:
    """Travel to the break from a stretch `least` on and the force integrated on it, means; and their errors."""
    law = contacts.thresholds
    left = float(law.sf(least))
    ends = law.isf(np.maximum(left * 0.1 ** np.arange(1.0, _DECADES + 1.0), _LEAST))
    marks = np.concatenate([[least], ends, panel_edges(law, float(ends[-1])), law.atoms[0]])
    edges = np.unique(marks[(marks >= least) & (marks <= ends[-1])])

    def rows(y: Array) -> Array:
        # a threshold beyond y adds this much to the force integrated for each step of y
        arm = 0.5 * (3.0 * y**2 - least**2) / contacts.mean_threshold if linked else y
        held = law.sf(y) / left
        return np.stack([held, held * arm])

    nodes, weights = gauss(edges[:-1], edges[1:])
    scale = (weights * rows(nodes)).sum(axis=(1, 2))
    tables = tabulate(lambda y: rows(y) / scale[:, None, None], edges, 1e-15)
    found = scale * np.array([table.total for table in tables])
    # what is beyond the last decade, as those before it fall
    before, last = (scale[:, None] * np.diff([table.integral(ends[-3:]) for table in tables], axis=1)).T
    ratio = np.divide(last, before, out=np.zeros(2), where=before > 0.0)
    rest = np.where(ratio < 1.0, last * ratio / np.maximum(1.0 - ratio, 1e-300), np.inf)
    return found, rest + scale * np.array([table.total_error for table in tables])


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
