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
_MOST = 10  # times as many, where a delay is shorter than a step: a hundred times as long, in heat a thousand times
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
    if contacts.changing is not None and contacts.growing is None:
        raise InputError("contacts: by cohorts their thresholds stay as drawn, or grow")
    if contacts.thresholds.atoms[0].size:
        raise InputError("contacts: their F jumps at exact thresholds, which no steps resolve")
    clock = np.abs(np.diff(path, prepend=path[0])).cumsum() if time is None else time
    # a step is shorter than a delay, also where the slider rests
    wait = contacts.waiting_time
    times = 1 + int(np.diff(clock).max() / (_PARTS[0] * wait)) if wait else 1
    if times > _MOST:
        raise InputError("delay: by cohorts a step would be longer")
    found = [_force(contacts, path, clock, times * parts)[:: times * parts] for parts in _PARTS]
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
    points, ends = (
        np.arange(path.size),
        np.linspace(0.0, path.size - 1.0, (path.size - 1) * parts + 1),
    )
    place, now = np.interp(ends, points, path), np.interp(ends, points, clock)
    cohorts = SteppedCohorts(contacts, place[0], now[0], parts)
    moves = [cohorts.move(*step) for step in zip(place[1:], now[1:], strict=True)]
    return np.array([cohorts.force_at_first, *moves])


class SteppedCohorts:
    """All contacts of a slider by the steps in which they formed, moved step by step.

    force_at_first : F at the start, a length, where the slider stands at `place` at the time `now`
    """

    def __init__(self, contacts: Contacts, place: float, now: float, parts: int) -> None:
        """`parts`: how fine cells of thresholds and nodes of the start are."""
        law, self._growing, heat = contacts.thresholds, contacts.growing, contacts.thermal
        assert isinstance(heat, Thermal | None)
        self._heat: Thermal | None = heat
        self._law, self._wait = law, contacts.waiting_time
        first, self._reformed = (
            _born(contacts.start, _NODES_OF_START * parts),
            _born(as_start(None)),
        )
        if contacts.reforming is not None:
            self._reformed = _born(contacts.reforming.law)
        cells = _CELLS * parts if self._heat else 0
        edges = np.linspace(0.0, float(law.isf(_FORGOTTEN)), 1 + cells)
        self._beyond, self._limit = law.sf(edges), 0.5 * (edges[1:] + edges[:-1])
        # of each cohort: where the slider is while it is relaxed, when it formed, the hazard then, the largest since,
        # its share of all contacts, and the integral of its rates by cells of thresholds
        pinned_for = 0.0 if self._growing is None else self._growing.start_pinned_for
        self._relaxed_at = place - first.stretch
        self._born_at = np.full(first.weights.size, now - pinned_for)
        self._at_birth = self._hazard(first.stretch, now - self._born_at)
        self._worst, self._weights = self._at_birth.copy(), first.weights
        self._passed = np.zeros((first.weights.size, self._limit.size))
        self._places, self._times, self._broken, self._births = [place], [now], [0.0], 0.0
        self.force_at_first = float(first.weights @ first.stretch)

    def _hazard(self, x: Array, age: Array) -> Array:
        """The cumulative hazard of thresholds at |x| and at these ages: with it a contact keeps its quantile."""
        if self._growing is None:
            return -self._law.logsf(np.abs(x))
        return self._growing.hazard_at(x, age)

    def move(self, place: float, now: float) -> float:
        """F once the slider has moved to this place in a straight line, until this time."""
        step, middle = now - self._times[-1], 0.5 * (place + self._places[-1])
        reformed, many = self._reformed, self._reformed.weights.size
        if self._wait and step > self._wait:
            raise InputError("delay: by cohorts it is longer than a step")
        lasts = np.append(np.full(self._weights.size, step), np.full(many, 0.5 * step))
        begin = np.append(self._places[-1] - self._relaxed_at, reformed.stretch)
        self._relaxed_at = np.append(self._relaxed_at, middle - reformed.stretch)
        self._born_at = np.append(self._born_at, np.full(many, now - 0.5 * step))
        x, fresh = place - self._relaxed_at, self._hazard(reformed.stretch, np.zeros(many))
        self._at_birth = np.append(self._at_birth, fresh)
        self._worst = np.append(self._worst, fresh)
        self._worst = np.maximum(self._worst, self._hazard(x, now - self._born_at))
        survival = np.exp(self._at_birth - self._worst)
        if self._heat is not None:
            passed = np.vstack([self._passed, np.zeros((many, self._limit.size))])
            halfway = np.abs(0.5 * (begin + x))[:, None]
            self._passed = passed + rate_of(self._heat, halfway, self._limit) * lasts[:, None]
            lowest = np.minimum(np.exp(-self._worst)[:, None], self._beyond[:-1])
            between = np.maximum(lowest - self._beyond[1:], 0.0)
            survival = np.exp(self._at_birth) * (between * np.exp(-self._passed)).sum(axis=1)
        old, new = survival[: self._weights.size], survival[self._weights.size :]
        if self._wait:  # what broke a delay ago
            before = np.array([self._times[-1], now]) - self._wait
            born = float(np.diff(np.interp(before, self._times, self._broken))[0])
        else:  # as many as make all contacts hold
            born = (1.0 - float(self._weights @ old)) / float(reformed.weights @ new)
        self._weights = np.append(self._weights, born * reformed.weights)
        self._births += born
        self._places.append(place)
        self._times.append(now)
        self._broken.append(self._births + 1.0 - float(self._weights @ survival))
        return float(self._weights @ (survival * x))
