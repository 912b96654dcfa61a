"""Contacts that hold at X = 0 and age from there on: how they break, whatever stretches they start from."""

import numpy as np
import numpy.typing as npt
from scipy.linalg import eigh_tridiagonal

from master.first_passage import FirstPassage, first_passage
from origins import Contacts
from origins.quadrature import gauss
from origins.start import Start

Array = npt.NDArray[np.float64]

_PANELS = 64
_NEAREST = 1e-16
_FEWEST, _MOST = 6, 64
_MARGIN = 10.0
_PROBES = 200
_FAINT = 1e-2  # of the accuracy


class AgeingStart:
    """First breaks of contacts with fresh thresholds at X = 0, in steady forward motion, exact closure.

    A start with a width is replaced by the n stretches of its own Gauss rule, which give all averages of polynomials
    of degree 2n - 1. What holds at X, as a function of the starting stretch, is a sum of n of the start's orthogonal
    polynomials; how fast its terms fall says how many are needed for errors below `accuracy`.

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
        self._contacts, self._velocity, self._accuracy = contacts, velocity, accuracy
        self.is_single = contacts.start.is_single
        if self.is_single:
            self.stretches, self.weights = np.array([contacts.start.mean()]), np.ones(1)
            self._passages = [self._passage(contacts.start.mean())]
            self.error = self._passages[0].error
            return
        count = _FEWEST
        while True:
            self._set(count)
            fall = self._fall()
            left = _MARGIN * fall**2
            if left <= accuracy or count == _MOST:
                break
            # terms fall geometrically, or faster: those of the next rule, and at least two more
            needed = count * 0.5 * np.log(accuracy / _MARGIN) / np.log(min(fall, 0.9))
            count = int(np.clip(np.ceil(needed), count + 2, min(4 * count, _MOST)))
        self.error = left + max(passage.error for passage in self._passages)

    def _set(self, count: int) -> None:
        stretches, projections, self._diagonal, self._beside = gauss_rule(self._contacts.start, count)
        held = self._contacts.thresholds.sf(np.abs(stretches)) > 0.0
        self.stretches, self._project = stretches[held], projections[:, held] / projections[0, held].sum()
        self.weights = self._project[0]
        # those far out count for too little to be looked at: they hold as their neighbours do
        counts = np.flatnonzero(self.weights > _FAINT * self._accuracy)
        first, last = int(counts[0]), int(counts[-1])
        passages = [self._passage(float(x)) for x in self.stretches[first : last + 1]]
        self._passages = [passages[int(np.clip(k - first, 0, last - first))] for k in range(self.stretches.size)]

    def _passage(self, start: float) -> FirstPassage:
        ageing = self._contacts.ageing
        assert ageing is not None
        return first_passage(self._contacts.thresholds, ageing, self._velocity, start, self._accuracy)

    def _fall(self) -> float:
        """Largest of the last two terms anywhere on the way, of what holds at X by the starting stretch."""
        furthest = float(self._contacts.thresholds.isf(1e-6)) - float(self.stretches[0])
        for passage in self._passages:
            furthest = max(furthest, float(passage.law.isf(1e-6)))
        held = self._each(np.linspace(0.0, furthest, _PROBES))
        return float(np.abs(self._project @ held)[-2:].max())

    def _each(self, x: Array) -> Array:
        """What holds at each X, one row for each starting stretch."""
        return np.array([passage.law.sf(x) for passage in self._passages])

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
        terms = [np.ones(origin.shape), (origin - self._diagonal[0]) / self._beside[0]]
        for k in range(1, self._project.shape[0] - 1):
            following = (origin - self._diagonal[k]) * terms[-1] - self._beside[k - 1] * terms[-2]
            terms.append(following / self._beside[k])
        sizes = self._project @ self._each(np.array([position]))[:, 0]
        kept = np.clip(np.tensordot(sizes, np.array(terms), axes=1), 0.0, 1.0)
        low, high = self._contacts.start.span
        inside = (origin >= low) & (origin <= high)
        return np.where(inside, self._contacts.start.pdf(origin) * kept, 0.0)

    def _sum(self, x: npt.ArrayLike, survival: bool, power: int) -> Array:
        # the density rises without bound towards X = 0 where fresh thresholds lie at the starting stretch
        at = np.maximum(np.asarray(x, dtype=float), _NEAREST * self._contacts.mean_threshold)
        out = np.zeros(at.shape)
        for begin, weight, passage in zip(self.stretches, self.weights, self._passages, strict=True):
            values = passage.law.sf(at) if survival else passage.law.pdf(at)
            out = out + weight * values * (at + begin) ** power
        return out


def gauss_rule(start: Start, count: int) -> tuple[Array, Array, Array, Array]:
    """Gauss rule of a start with a width: stretches (n,), n = count, and the matrix (n, n) that turns values there into
    the coefficients of the start's orthonormal polynomials p_k; its first row are the weights, whose sums are the
    start's averages of polynomials up to degree 2n - 1. Then the recurrence of those polynomials, two arrays (n,):
    x p_k = beside[k] p_(k+1) + diagonal[k] p_k + beside[k-1] p_(k-1)."""
    low, high = start.span
    inner = start.breakpoints[(start.breakpoints > low) & (start.breakpoints < high)]
    edges = np.unique(np.concatenate([np.linspace(low, high, _PANELS + 1), inner]))
    nodes, factors = (array.ravel() for array in gauss(edges[:-1], edges[1:]))
    weights = factors * start.pdf(nodes)
    weights = np.where(np.isfinite(weights), weights, 0.0)
    weights /= weights.sum()
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
    return middle + half * values, project, middle + half * np.array(diagonal), half * np.array(beside)
