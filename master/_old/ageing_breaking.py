"""Breaks at a steady speed of contacts whose thresholds diffuse, closure "exact": of all that stood at one stretch;
at a temperature too, where the rate follows the threshold that a contact has by then.

From each stretch x_0 a first passage tells what holds, E(X; x_0), X the travel since. Where contacts stand at many
stretches a few passages do, from the Gauss nodes x_j of their law: with w(X) from 0 to some number of about 1,

    f(y) = E(X + (x_0 - y) w; y)     is E(X; x_0) at y = x_0, and smooth in y.

Early on it is read at one travel, as contacts have been stretched for as long; later about at one stretch, as they
meet the same thresholds, but for what those aged meanwhile.
"""

from itertools import pairwise

import numpy as np
import numpy.typing as npt
from scipy.linalg import eigh_tridiagonal

from master._old.effective_law import EffectiveLaw
from master._old.first_passage import FirstPassage, first_passage
from origins import Contacts, Thresholds
from origins.start import Start
from origins.thresholds.quadrature import gauss

Array = npt.NDArray[np.float64]

_PANELS = 64
_NEAREST = 1e-16
_LEAST = 1e-2
_FEWEST, _MOST = 6, 18
_WIDER = 8.0
_DEEPEST = 3
_ROOTS = np.array([1.0, 0.9999, 0.997, 0.97, 0.8])
_MARGIN = 8.0
_PROBES = 200
_FAINT = 1e-2  # of the accuracy
_REACH = 6.0  # standard deviations
_NEARLY_NOTHING = 1e-14
_OVER = 0.7  # of the range of stretches: below, w would rise faster than travels allow
_FINEST = 1e-12


class AgeingBreaking:
    """p and E of contacts with `ageing` at the speed v > 0 (length per time); the face of thermal_law.ThermalBreaking.

    Parameters
    ----------
    contacts : Contacts
    velocity : float
    accuracy : float
        Error of the survival that is aimed at.
    start : Start, optional
        Stretches from which `rows` are asked for; None: 0.

    Attributes
    ----------
    effective : Thresholds
        Of the travel to the break, from the middle one of the stretches; from 0 on it is the stretch.
    error : float
        Estimate of the error of E.
    panels : array
        Travels (lengths) between which breaks from one stretch are one series.
    """

    linked = bends_at_zero = False  # `bends` says where
    # thresholds diffuse: none keeps an exact value, no density its jumps
    atoms = atom_weights = marks = np.empty(0)

    def __init__(self, contacts: Contacts, velocity: float, accuracy: float, start: Start | None = None) -> None:
        self.law: Thresholds = contacts.thresholds
        self._contacts, self._velocity, self.accuracy = contacts, velocity, accuracy
        self._sides: list[Side] = []
        self.start = start
        self._known = [self]
        if start is None or start.is_single:
            passages = [self.passage(0.0 if start is None else start.mean())]
            self.error = passages[0].error
        else:
            self._sides = [s for ends in pairwise(self._ends(start)) for s in _sides(self, start, *ends, 0)]
            passages = [passage for side in self._sides for passage in side.passages]
            whole = sum(side.weight for side in self._sides)
            self.error = sum(side.error * side.weight for side in self._sides) / whole
        self.effective = passages[len(passages) // 2].law
        single = not self._sides
        self.panels = self.effective.panels if isinstance(self.effective, EffectiveLaw) and single else np.empty(0)
        furthest = max(float(passage.law.isf(_NEARLY_NOTHING)) for passage in passages)
        self.top = furthest + (max(start.span[1], 0.0) if start is not None else 0.0)

    def of(self, start: Start) -> "AgeingBreaking":
        """The same for contacts that stand at the stretches of `start`."""
        if start.span == (0.0, 0.0):
            return self._known[0]
        for known in self._known:
            if known.start is start:
                return known
        found = type(self)(self._contacts, self._velocity, self.accuracy, start)
        self._known.append(found)
        found._known = self._known
        return found

    def passage(self, origin: float) -> FirstPassage:
        """First passage from one stretch."""
        contacts = self._contacts
        assert contacts.ageing is not None
        law, thermal = contacts.thresholds, contacts.thermal
        return first_passage(law, contacts.ageing, self._velocity, origin, self.accuracy, thermal)

    def rows(self, x: Array, origin: Array | float = 0.0) -> Array:
        """p and E, times S(|origin|), at stretches x > `origin`; shape (2, n) for x of shape (n,)."""
        origin = np.broadcast_to(origin, x.shape)
        # the density rises without bound towards the origin where fresh thresholds lie there
        travel = np.maximum(x - origin, _NEAREST * self._contacts.mean_threshold)
        if not self._sides:
            return np.stack([self.effective.pdf(travel), self.effective.sf(travel)]) * self.law.sf(np.abs(origin))
        out = np.zeros((2, x.size))
        for side in self._sides:
            inside = (origin >= side.low) & (origin <= side.high)
            out[:, inside] = side.rows(travel[inside], origin[inside])
        return out * self.law.sf(np.abs(origin))

    def held(self, x: Array, threshold: Array, origin: Array) -> Array:
        """What has not broken before an exact value: there is none."""
        return np.ones(x.shape)

    def bends(self, travel: Array) -> Array:
        """Origins beside which `rows` bends at each travel, shape (n, any): where stretches turn at 0; and some close
        to that on the side on which they have turned, as breaks have a root there."""
        return -travel[:, None] * (_ROOTS if any(side.turns for side in self._sides) else np.empty(0))

    def _ends(self, start: Start) -> list[float]:
        """Of parts of the start: 0 where contacts break about it, as those from below and above begin differently."""
        assert self._contacts.ageing is not None
        low, high = start.span
        lowest = -float(start.ppf(self.accuracy))
        if lowest <= 0.0 or float(start.sf(0.0)) <= self.accuracy:
            return [low, high]
        spread = np.sqrt(4.0 * self._contacts.ageing.rate / self._velocity * lowest)
        matters = float(self.law.cdf(lowest + _REACH * spread)) > self.accuracy
        return [low, 0.0, high] if matters else [low, high]

    def side(self, start: Start, low: float, high: float) -> "Side":
        """The start between two stretches."""
        return Side(self, start, low, high)


def _sides(breaking: AgeingBreaking, start: Start, low: float, high: float, depth: int) -> list["Side"]:
    """The start between two stretches, in as many parts as need few passages each."""
    whole = breaking.side(start, low, high)
    if whole.error <= whole.aim or depth == _DEEPEST:
        return [whole]
    middle = 0.5 * (low + high)
    parts = _sides(breaking, start, low, middle, depth + 1), _sides(breaking, start, middle, high, depth + 1)
    return [*parts[0], *parts[1]]


class Side:
    """The start between two stretches: its Gauss rule, as fine as needed, and what follows from each of its stretches.

    `weight` is its share of the start, `aim` the error of what holds that would do.
    """

    def __init__(self, breaking: AgeingBreaking, start: Start, low: float, high: float) -> None:
        self.low, self.high = low, high
        # contacts break about 0 where those from either side are told apart
        self.turns = high <= 0.0
        self._breaking, self._start = breaking, start
        # the wider a start beside the thresholds, the more stretches it takes
        law = breaking.law
        spread, width = (float(some.isf(0.16) - some.ppf(0.16)) for some in (start, law))
        count = _FEWEST + round(_WIDER * min(spread / width, 1.0)) if width > 0.0 else _FEWEST
        while True:
            self._set(count)
            left, following = self._left()
            if left <= self.aim or following > _MOST or count == _MOST:
                break
            count = int(np.clip(following, count + 2, _MOST))
        self.error = left + max(passage.error for passage in self.passages)

    def _set(self, count: int) -> None:
        stretches, project, self._diagonal, self._beside, weight = gauss_rule(self._start, count, self.low, self.high)
        held = self._breaking.law.sf(np.abs(stretches)) > 0.0
        kept = project[0, held].sum()
        self.stretches, self._project, self.weight = stretches[held], project[:, held] / kept, weight * kept
        self.aim = max(self._breaking.accuracy / max(self.weight, 1e-300), self._breaking.accuracy)
        # those far out count for too little to be looked at: they hold as their neighbours do
        counts = np.flatnonzero(self._project[0] > _FAINT * self.aim)
        first, last = int(counts[0]), int(counts[-1])
        passages = [self._breaking.passage(float(x)) for x in self.stretches[first : last + 1]]
        self.passages = [passages[int(np.clip(k - first, 0, last - first))] for k in range(self.stretches.size)]
        # how much sooner half of them break, per length of the starting stretch
        median = np.array([float(passage.law.isf(0.5)) for passage in self.passages])
        off = self.stretches - self._diagonal[0]
        share = self._project[0]
        self._shift = max(-float(share @ (off * median)) / float(share @ (off * off)), 0.0)
        rare = _FAINT * self._breaking.accuracy
        low, high = max(self.low, float(self._start.ppf(rare))), min(self.high, float(self._start.isf(rare)))
        reach = max(high - self.stretches[0], self.stretches[-1] - low)
        self._over = _OVER * max(self._shift, 1.0) * float(reach)

    def _left(self) -> tuple[float, float]:
        """Error of the rule, the first term that it takes for another; and how many stretches would do."""
        furthest = max(float(passage.law.isf(1e-6)) for passage in self.passages)
        travel = np.linspace(0.0, furthest, _PROBES)[1:]
        origin = np.full(travel.size, self._diagonal[0])
        sizes = np.abs(self._project @ np.array([E for _, E in self.each(travel, origin)])).max(axis=1)
        half = sizes.size // 2
        before, last = float(sizes[half - 1 : half + 1].max()), float(sizes[-2:].max())
        # between n/2 and n terms fall by `fall`; up to 2n again by its square, where they fall as powers of n by itself
        fall = min(last / before, 0.99) if before > 0.0 else 0.0
        left = _MARGIN * last * fall
        further = np.log(max(left, 1e-300) / self.aim) / max(-np.log(max(fall, 1e-30)), 0.1)
        return left, sizes.size * (1.0 + max(further, 0.0) / 3.0)

    def each(self, travel: Array, origin: Array) -> list[tuple[Array, Array]]:
        """p and E as each passage tells them, at travels from `origin`."""
        # behind 0 stretches are alike that are the same part of the way to it, and beyond where they are the same
        way = np.maximum(-origin, _NEAREST * self._over) if self.turns else np.zeros(origin.shape)
        since = np.maximum(travel - way, 0.0)
        late = np.exp(-np.square(since / self._over))
        slope = 2.0 * since / self._over**2 * late
        out = []
        for stretch, passage in zip(self.stretches, self.passages, strict=True):
            off = (self._shift - self.turns) * (origin - stretch)
            at, rise = since + off * (1.0 - late), 1.0 + off * slope
            # far out on the start's tails, where next to nothing stands
            short = at < _LEAST * since
            at, rise = np.where(short, _LEAST * since, at), np.where(short, _LEAST, rise)
            if self.turns:
                at -= np.minimum(travel / way, 1.0) * stretch
                rise = np.where(travel < way, -stretch / way, rise)
            at = np.maximum(at, _NEAREST * self._over)
            out.append((passage.law.pdf(at) * rise, passage.law.sf(at)))
        return out

    def rows(self, travel: Array, origin: Array) -> Array:
        """p and E at travels from each `origin`."""
        terms = [np.ones(origin.shape), (origin - self._diagonal[0]) / self._beside[0]]
        for k in range(1, self._project.shape[0] - 1):
            following = (origin - self._diagonal[k]) * terms[-1] - self._beside[k - 1] * terms[-2]
            terms.append(following / self._beside[k])
        shares = self._project.T @ np.array(terms)
        out = np.zeros((2, travel.size))
        for share, (breaks, holds) in zip(shares, self.each(travel, origin), strict=True):
            out += share * np.stack([breaks, holds])
        return np.clip(out, 0.0, [[np.inf], [1.0]])


def gauss_rule(start: Start, count: int, low: float, high: float) -> tuple[Array, Array, Array, Array, float]:
    """Gauss rule of the part of a start between two stretches: stretches (n,), n = count, and the matrix (n, n) that
    turns values there into the coefficients of its orthonormal polynomials p_k; its first row are the weights, whose
    sums are averages over the part for polynomials up to degree 2n - 1. Then the recurrence of those polynomials, two
    arrays (n,): x p_k = beside[k] p_(k+1) + diagonal[k] p_k + beside[k-1] p_(k-1); and the weight of the part."""
    inner = start.breakpoints[(start.breakpoints > low) & (start.breakpoints < high)]
    edges = np.unique(np.concatenate([np.linspace(low, high, _PANELS + 1), inner]))
    nodes, factors = (array.ravel() for array in gauss(edges[:-1], edges[1:]))
    weights = factors * start.pdf(nodes)
    weights = np.where(np.isfinite(weights), weights, 0.0)
    whole = float(weights.sum())
    weights /= whole
    # Lanczos on the diagonal matrix of the nodes, begun from the weights: the Jacobi matrix of the start
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    x = (nodes - middle) / half
    basis = [np.sqrt(weights)]
    diagonal, beside = [], []
    for _ in range(count):
        vector = x * basis[-1]
        diagonal.append(float(vector @ basis[-1]))
        for _ in range(2):
            for other in basis:
                vector = vector - (vector @ other) * other
        size = float(np.linalg.norm(vector))
        beside.append(size)
        basis.append(vector / size)
    values, vectors = eigh_tridiagonal(np.array(diagonal), np.array(beside[:-1]))
    project = vectors * vectors[0]
    return middle + half * values, project, middle + half * np.array(diagonal), half * np.array(beside), whole
