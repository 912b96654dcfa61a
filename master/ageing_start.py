"""Contacts that hold at X = 0 and age from there on: how they break, whatever stretches they start from."""

import numpy as np
import numpy.typing as npt
from scipy.linalg import eigh_tridiagonal

from master.first_passage import FirstPassage, first_passage
from origins import Contacts, InputError
from origins.quadrature import gauss
from origins.start import Start

Array = npt.NDArray[np.float64]

_PANELS = 64
_NEAREST = 1e-16
_FEWEST, _MOST = 6, 96


class AgeingStart:
    """First breaks of contacts with fresh thresholds at X = 0, in steady forward motion, exact closure.

    A start with a width is replaced by the n stretches of its own Gauss rule, which give all averages of polynomials
    of degree 2n - 1; n is doubled until the survival changes by less than `accuracy`.

    Parameters
    ----------
    contacts : Contacts
        With `ageing`.
    velocity : float
        v > 0.
    accuracy : float

    Attributes
    ----------
    error : float
        Estimate of the error of `holding`.
    """

    def __init__(self, contacts: Contacts, velocity: float = 1.0, accuracy: float = 1e-9) -> None:
        self._contacts, self._velocity = contacts, velocity
        if contacts.ageing is None:
            raise InputError("contacts.ageing: is None; without ageing use master.solve")
        start = contacts.start
        self._set(1)
        self.error = max(passage.error for passage in self._passages)
        if start.is_single:
            return
        probes = np.linspace(0.0, float(contacts.thresholds.isf(1e-6)) - start.span[0], 400)
        count, before = _FEWEST, np.full(probes.size, np.inf)
        while True:
            self._set(count)
            now = self.holding(probes)
            change = float(np.abs(now - before).max())
            if change <= accuracy or count >= _MOST:
                break
            count, before = 2 * count, now
        self.error = change + max(passage.error for passage in self._passages)

    def _set(self, count: int) -> None:
        contacts = self._contacts
        start = contacts.start
        if start.is_single:
            self.stretches, self.weights = np.array([start.mean()]), np.ones(1)
        else:
            self.stretches, self.weights = gauss_rule(start, count)
        held = contacts.thresholds.sf(np.abs(self.stretches)) > 0.0
        self.stretches, self.weights = self.stretches[held], self.weights[held] / self.weights[held].sum()
        self._passages: list[FirstPassage] = [
            first_passage(contacts.thresholds, contacts.ageing, self._velocity, float(x))  # type: ignore[arg-type]
            for x in self.stretches
        ]

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

    def _sum(self, x: npt.ArrayLike, survival: bool, power: int) -> Array:
        # the density rises without bound towards X = 0 where fresh thresholds lie at the starting stretch
        at = np.maximum(np.asarray(x, dtype=float), _NEAREST * self._contacts.mean_threshold)
        out = np.zeros(at.shape)
        for begin, weight, passage in zip(self.stretches, self.weights, self._passages, strict=True):
            values = passage.law.sf(at) if survival else passage.law.pdf(at)
            out = out + weight * values * (at + begin) ** power
        return out


def gauss_rule(start: Start, count: int) -> tuple[Array, Array]:
    """Stretches and weights whose sums are the start's averages of polynomials up to degree 2 count - 1."""
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
    return middle + half * values, vectors[0] ** 2
