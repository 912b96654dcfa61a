"""F on any path of a rigid slider by cohorts: contacts that form in one step are followed together, step by step.

The plainest road there is, for laws that have no closed form and for paths that turn and rest. With
the master equation it shares the laws of contacts and number conservation, but neither panels, polynomials nor tables.
"""

from typing import NamedTuple

import numpy as np

from origins.contacts import Contacts
from origins.errors import InputError
from origins.laws.thermal import Thermal
from origins.start import Start, as_start
from origins.thresholds.law import Array
from toolkit.stability.case import Truth
from toolkit.stability.renewal import rate_of

_PARTS = (3, 6, 12)  # steps between two points of the path, halved twice
_CELLS = 16  # of thresholds, times the parts, where heat breaks contacts one by one of them
# of stretches at which contacts form, on each side of 0: 1e-9 of a normal law; and of those of the start, times the
# parts, as their survival bends in |x| where the path turns
_NODES, _NODES_OF_START = 14, 16
_FORGOTTEN = 1e-12  # share of thresholds beyond the last cell
_SAFETY = 2.0  # on the last change of the extrapolation, which is the error itself where that is halved with the steps


def by_cohorts(contacts: Contacts, path: Array, time: Array | None = None) -> Truth:
    """F in mean thresholds, at speed 1 where no `time` is given; path and time begin at 0.

    Laws: any thresholds, grains that grow, soft, stiff or eyring heat, a delay; contacts form relaxed or with
    stretches of their own. The error is estimated from two halvings of all steps. Raises InputError for other laws.
    """
    supported = contacts.ageing is None and isinstance(contacts.thermal, Thermal | None)
    if not supported or contacts.stiffness == "linked" or contacts.each_by_itself() is not contacts:
        raise InputError("contacts: by cohorts they neither age nor differ in stiffness")
    if contacts.thresholds.atoms[0].size:
        raise InputError("contacts: their F jumps at exact thresholds, which no steps resolve")
    clock = path - path[0] if time is None else time
    found = [_force(contacts, path, clock, parts)[::parts] for parts in _PARTS]
    rows = np.array(found) / contacts.mean_threshold
    before, last = (4.0 * rows[1:] - rows[:-1]) / 3.0
    error = _SAFETY * float(np.abs(last - before).max()) + 1e-13
    return Truth(last, error, "cohorts in even steps, extrapolated")


class _Born(NamedTuple):
    """Stretches at which contacts form, and their shares."""

    stretch: Array
    weights: Array


def _born(law: Start, nodes: int = _NODES) -> _Born:
    """A single stretch, or Gauss nodes of the law on each side of 0, where |x| bends."""
    if law.is_single:
        return _Born(np.array([law.mean()]), np.ones(1))
    node, weight = np.polynomial.legendre.leggauss(nodes)
    ends = np.unique(np.clip([law.span[0], 0.0, law.span[1]], *law.span))
    half = 0.5 * np.diff(ends)[:, None]
    stretch = (ends[:-1, None] + half * (node + 1.0)).ravel()
    weights = (half * weight).ravel() * law.pdf(stretch)
    return _Born(stretch, weights / weights.sum())


def _force(contacts: Contacts, path: Array, clock: Array, parts: int) -> Array:
    """F at the ends of all steps, so many of them between two points; a length."""
    law, growing, heat = contacts.thresholds, contacts.growing, contacts.thermal
    assert isinstance(heat, Thermal | None)
    points, ends = (
        np.arange(path.size),
        np.linspace(0.0, path.size - 1.0, (path.size - 1) * parts + 1),
    )
    place, now = np.interp(ends, points, path), np.interp(ends, points, clock)
    if (wait := contacts.waiting_time) and np.diff(now).max() > wait:
        raise InputError("delay: by cohorts it is longer than a step")
    first, reformed = _born(contacts.start, _NODES_OF_START * parts), _born(as_start(None))
    if contacts.reforming is not None:
        reformed = _born(contacts.reforming.law)
    edges = np.linspace(0.0, float(law.isf(_FORGOTTEN)), 1 + (_CELLS * parts if heat else 0))
    beyond, limit = law.sf(edges), 0.5 * (edges[1:] + edges[:-1])

    def hazard(x: Array, age: Array) -> Array:
        """The cumulative hazard of thresholds at |x| and at these ages: with it a contact keeps its quantile."""
        return -law.logsf(np.abs(x)) if growing is None else growing.hazard_at(x, age)

    # of each cohort: where the slider is while it is relaxed, when it formed, the hazard then, the largest since, its
    # share of all contacts, and the integral of its rates by cells of thresholds
    pinned_for = 0.0 if growing is None else growing.start_pinned_for
    relaxed_at = place[0] - first.stretch
    born_at = np.full(first.weights.size, now[0] - pinned_for)
    at_birth = hazard(first.stretch, now[0] - born_at)
    worst, weights = at_birth.copy(), first.weights
    passed = np.zeros((weights.size, limit.size))
    forces, broken, births = [float(weights @ first.stretch)], [0.0], 0.0
    for k in range(1, now.size):
        step, middle = now[k] - now[k - 1], 0.5 * (place[k] + place[k - 1])
        lasts = np.append(np.full(weights.size, step), np.full(reformed.weights.size, 0.5 * step))
        begin = np.append(place[k - 1] - relaxed_at, reformed.stretch)
        relaxed_at = np.append(relaxed_at, middle - reformed.stretch)
        born_at = np.append(born_at, np.full(reformed.weights.size, now[k] - 0.5 * step))
        x, fresh = place[k] - relaxed_at, hazard(reformed.stretch, np.zeros(reformed.weights.size))
        at_birth, worst = np.append(at_birth, fresh), np.append(worst, fresh)
        worst = np.maximum(worst, hazard(x, now[k] - born_at))
        survival = np.exp(at_birth - worst)
        if heat is not None:
            passed = np.vstack([passed, np.zeros((reformed.weights.size, limit.size))])
            passed += rate_of(heat, np.abs(0.5 * (begin + x))[:, None], limit) * lasts[:, None]
            between = np.maximum(np.minimum(np.exp(-worst)[:, None], beyond[:-1]) - beyond[1:], 0.0)
            survival = np.exp(at_birth) * (between * np.exp(-passed)).sum(axis=1)
        old, new = survival[: weights.size], survival[weights.size :]
        if wait:  # what broke a delay ago
            born = float(np.diff(np.interp(now[k - 1 : k + 1] - wait, now[:k], broken))[0])
        else:  # as many as make all contacts hold
            born = (1.0 - float(weights @ old)) / float(reformed.weights @ new)
        weights, births = np.append(weights, born * reformed.weights), births + born
        broken.append(births + 1.0 - float(weights @ survival))
        forces.append(float(weights @ (survival * x)))
    return np.array(forces)
