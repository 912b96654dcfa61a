"""Contacts that hold at X = 0 and age from there on: how they break, whatever stretches they start from."""

from itertools import pairwise

import numpy as np
import numpy.typing as npt
from scipy.linalg import eigh_tridiagonal

from master.effective_law import EffectiveLaw
from master.first_passage import FirstPassage, first_passage
from origins import Contacts
from origins.quadrature import gauss
from origins.start import Start

Array = npt.NDArray[np.float64]

_PANELS = 64
_NEAREST = 1e-16
_FEWEST, _MOST = 6, 64
_MARGIN = 4.0
_PROBES = 200
_FAINT = 1e-2  # of the accuracy
_REACH = 6.0  # standard deviations


class AgeingStart:
    """First breaks of contacts with fresh thresholds at X = 0, in steady forward motion, exact closure.

    A start with a width is replaced by the n stretches of its own Gauss rule, which give all averages of polynomials
    of degree 2n - 1. What holds at X, as a function of the starting stretch, is a sum of n of the start's orthogonal
    polynomials; how its terms fall says how many are needed for errors below `accuracy`. Where contacts from either
    side of x = 0 break nearby, each side has a rule of its own.

    Parameters
    ----------
    contacts : Contacts
        With `ageing`.
    velocity : float
        v > 0.
    accuracy : float

    Attributes
    ----------
    stretches, weights : arrays (n,)
        Starting stretches (lengths) and their shares of the contacts.
    error : float
        Estimate of the error of `holding`.
    """

    def __init__(self, contacts: Contacts, velocity: float = 1.0, accuracy: float = 1e-9) -> None:
        self._contacts = contacts
        self.is_single = contacts.start.is_single
        self._sides: list[_Side] = []
        if self.is_single:
            self.stretches, self.weights = np.array([contacts.start.mean()]), np.ones(1)
            self._passages = [_passage(contacts, velocity, accuracy, contacts.start.mean())]
            self.error = self._passages[0].error
            return
        low, high = contacts.start.span
        ends = [low, 0.0, high] if _turns_matter(contacts, velocity, accuracy) else [low, high]
        self._sides = [_Side(contacts, velocity, accuracy, begin, end) for begin, end in pairwise(ends)]
        # what lies beyond every threshold is cut off
        whole = sum(side.weight for side in self._sides)
        self.stretches = np.concatenate([side.stretches for side in self._sides])
        self.weights = np.concatenate([side.project[0] * (side.weight / whole) for side in self._sides])
        self._passages = [passage for side in self._sides for passage in side.passages]
        self.error = sum(side.error * side.weight for side in self._sides) / whole

    @property
    def panels(self) -> Array:
        """Positions X (lengths) close where breaks change fast: of the first, the last and one stretch between."""
        laws = [self._passages[k].law for k in {0, len(self._passages) // 2, len(self._passages) - 1}]
        return np.unique(np.concatenate([law.panels for law in laws if isinstance(law, EffectiveLaw)]))

    def breaks(self, x: npt.ArrayLike) -> Array:
        """b_0(X): breaks per contact and length, at X (lengths); same shape."""
        return self._sum(x, False, 0)

    def released(self, x: npt.ArrayLike) -> Array:
        """The same times the stretch that they release."""
        return self._sum(x, False, 1)

    def holding(self, x: npt.ArrayLike) -> Array:
        """G_0(X): fraction that holds since X = 0."""
        return self._sum(x, True, 0)

    def stretch(self, x: npt.ArrayLike) -> Array:
        """M_0(X): its part of F/(N_c <k>), a length."""
        return self._sum(x, True, 1)

    def standing(self, x: Array, position: float) -> Array:
        """Their part of Q(x;X) at X = position, per length; x, any shape, and X are lengths. Not for a single start."""
        origin = x - position
        kept = np.zeros(origin.shape)
        for side in self._sides:
            inside = (origin >= side.low) & (origin <= side.high)
            kept[inside] = side.held_from(origin[inside], position)
        return np.where(kept > 0.0, self._contacts.start.pdf(origin) * kept, 0.0)

    def _sum(self, x: npt.ArrayLike, survival: bool, power: int) -> Array:
        # the density rises without bound towards X = 0 where fresh thresholds lie at the starting stretch
        at = np.maximum(np.asarray(x, dtype=float), _NEAREST * self._contacts.mean_threshold)
        out = np.zeros(at.shape)
        for begin, weight, passage in zip(self.stretches, self.weights, self._passages, strict=True):
            values = passage.law.sf(at) if survival else passage.law.pdf(at)
            out = out + weight * values * (at + begin) ** power
        return out


class _Side:
    """The start between two stretches: its Gauss rule, as fine as needed, and what follows from each of its stretches.

    `weight` is its share of the start, `project` as for gauss_rule.
    """

    def __init__(self, contacts: Contacts, velocity: float, accuracy: float, low: float, high: float) -> None:
        self.low, self.high = low, high
        self._contacts, self._velocity, self._accuracy = contacts, velocity, accuracy
        count = _FEWEST
        while True:
            self._set(count)
            left, following = self._left()
            if left <= accuracy or count == _MOST:
                break
            count = int(np.clip(following, count + 2, min(4 * count, _MOST)))
        self.error = left + max(passage.error for passage in self.passages)

    def _set(self, count: int) -> None:
        rule = gauss_rule(self._contacts.start, count, self.low, self.high)
        stretches, projections, self._diagonal, self._beside, self.weight = rule
        held = self._contacts.thresholds.sf(np.abs(stretches)) > 0.0
        kept = projections[0, held].sum()
        self.stretches, self.project = stretches[held], projections[:, held] / kept
        self.weight *= kept
        # those far out count for too little to be looked at: they hold as their neighbours do
        counts = np.flatnonzero(self.project[0] > _FAINT * self._accuracy)
        first, last = int(counts[0]), int(counts[-1])
        passages = [
            _passage(self._contacts, self._velocity, self._accuracy, float(x)) for x in self.stretches[first : last + 1]
        ]
        self.passages = [passages[int(np.clip(k - first, 0, last - first))] for k in range(self.stretches.size)]

    def _left(self) -> tuple[float, float]:
        """Error of the rule, the first term that it takes for another; and how many stretches would do."""
        furthest = float(self._contacts.thresholds.isf(1e-6)) - float(self.stretches[0])
        for passage in self.passages:
            furthest = max(furthest, float(passage.law.isf(1e-6)))
        sizes = np.abs(self.project @ self._each(np.linspace(0.0, furthest, _PROBES))).max(axis=1)
        half = sizes.size // 2
        before, last = float(sizes[half - 1 : half + 1].max()), float(sizes[-2:].max())
        # between n/2 and n terms fall by `fall`; up to 2n again by its square, where they fall as powers of n by itself
        fall = min(last / before, 0.99) if before > 0.0 else 0.0
        left = _MARGIN * last * fall
        further = np.log(max(left, 1e-300) / self._accuracy) / max(-np.log(max(fall, 1e-30)), 0.1)
        return left, sizes.size * (1.0 + max(further, 0.0) / 3.0)

    def _each(self, x: Array) -> Array:
        """What holds at each X, one row for each starting stretch."""
        return np.array([passage.law.sf(x) for passage in self.passages])

    def held_from(self, origin: Array, position: float) -> Array:
        """Fraction that holds at X = position of those that started from each `origin`."""
        terms = [np.ones(origin.shape), (origin - self._diagonal[0]) / self._beside[0]]
        for k in range(1, self.project.shape[0] - 1):
            following = (origin - self._diagonal[k]) * terms[-1] - self._beside[k - 1] * terms[-2]
            terms.append(following / self._beside[k])
        sizes = self.project @ self._each(np.array([position]))[:, 0]
        return np.clip(np.tensordot(sizes, np.array(terms), axes=1), 0.0, 1.0)


def _passage(contacts: Contacts, velocity: float, accuracy: float, start: float) -> FirstPassage:
    assert contacts.ageing is not None
    return first_passage(contacts.thresholds, contacts.ageing, velocity, start, accuracy)


def _turns_matter(contacts: Contacts, velocity: float, accuracy: float) -> bool:
    """Whether contacts break about x = 0, where those from below and above begin differently."""
    assert contacts.ageing is not None
    start = contacts.start
    lowest = -float(start.ppf(accuracy))
    if lowest <= 0.0 or float(start.sf(0.0)) <= accuracy:
        return False
    spread = np.sqrt(4.0 * contacts.ageing.rate / velocity * lowest)
    return float(contacts.thresholds.cdf(lowest + _REACH * spread)) > accuracy


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
