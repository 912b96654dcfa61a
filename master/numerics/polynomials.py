"""Polynomials on one panel, the nodes at which number conservation is imposed, and pieces of ranges.

A panel is an interval [a, a + w] of t; a place on it is (t - a)/w, from 0 to 1. The number of breaks since the panel's
beginning is a polynomial of degree DEGREE, known by its values at the place 0 (where it is 0) and at the
DEGREE Radau nodes, the last of which is the panel's end. Conservation with survivals is a Volterra
equation of the first kind, for which Radau nodes are stable.
"""

from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre
from scipy.special import roots_jacobi

from origins.thresholds.law import Array

Rows = npt.NDArray[np.intp]

# Degree of a panel's polynomial: 12 needs more panels, 20 more work on each (measured on Gaussian thresholds to 1e-10).
DEGREE = 16
# Two edges of a range nearer than this part of it count as equal.
CLOSE = 1e-13
# Lobatto nodes of an integral over one panel: exact for a product of polynomials of degrees 16 and 17.
PANEL_NODES = 18


class Pieces(NamedTuple):
    """Pieces of ranges, from low to high; arrays of shape (n,)."""

    owner: Rows
    low: Array
    high: Array

    @classmethod
    def between(cls, edges: Array) -> "Pieces":
        """Of ranges, a row of edges in any order for each; edges that are equal by rounding count as one."""
        edges = np.sort(edges, axis=1)
        owner, piece = np.nonzero(np.diff(edges, axis=1) > CLOSE * (edges[:, -1:] - edges[:, :1]))
        return cls(owner, edges[owner, piece], edges[owner, piece + 1])

    def pick(self, which: npt.NDArray[np.bool_]) -> "Pieces":
        """Some of the pieces."""
        return Pieces(self.owner[which], self.low[which], self.high[which])

    def halves(self) -> "Pieces":
        """Both halves of all pieces."""
        middle = 0.5 * (self.low + self.high)
        low, high = np.append(self.low, middle), np.append(middle, self.high)
        return Pieces(np.tile(self.owner, 2), low, high)


def last_and_fall(size: Array) -> tuple[Array, Array]:
    """The larger of the last two sizes of coefficients (last axis), and its ratio <= 1 to that of the two before: the
    factor `fall_of_two` by which sizes fall over two coefficients. Of two, as those of a nearly even or odd function
    are small in turn. An example: of the sizes ... 8e-4, 2e-5, 2e-4, 5e-6 these are 2e-4 and 2e-4/8e-4 = 1/4."""
    before, last = size[..., -4:-2].max(axis=-1), size[..., -2:].max(axis=-1)
    return last, np.divide(last, before, out=np.ones_like(last), where=before > last)


class Points:
    """Places on a range (nodes), at which values give a polynomial, and the matrix from the values to its
    Legendre coefficients (series), whose first column holds the weights of an integral."""

    def __init__(self, z: Array) -> None:
        """From the nodes in [-1, 1]."""
        self.nodes: Array = 0.5 * (z + 1.0)
        self.series = np.asarray(np.linalg.inv(legendre.legvander(z, z.size - 1)).T, dtype=float)

    def at(self, place: Array) -> Array:
        """The matrix from values at the nodes to those at places, shape (size, places)."""
        return self.series @ legendre.legvander(2.0 * place - 1.0, self.nodes.size - 1).T


@lru_cache
def gauss(size: int) -> Points:
    """Gauss nodes."""
    return Points(legendre.leggauss(size)[0])


@lru_cache
def lobatto(size: int) -> Points:
    """Gauss-Lobatto nodes, to which both ends belong: integrals are exact to the degree 2 size - 3."""
    return Points(np.concatenate([[-1.0], roots_jacobi(size - 2, 1, 1)[0], [1.0]]))


# So many values are sooner computed one by one than as an array.
FEW_VALUES = 8
# Right Radau nodes on (0, 1].
NODES: Array = np.append(0.5 * (roots_jacobi(DEGREE - 1, 1, 0)[0] + 1.0), 1.0)
# Places midway between nodes, throughout the panel, at which its error is sampled, in the first and the last gap, too:
# bends lie at the ends of panels, and where a density ends by a power the largest error is in the last gap.
_BEFORE_CHECKS = np.ceil(np.linspace(0.0, DEGREE - 2.0, 5)).astype(int)
CHECKS: Array = 0.5 * (NODES[:-1] + NODES[1:])[_BEFORE_CHECKS]
# Matrix from values at the place 0 and at the nodes to coefficients of Legendre polynomials.
TO_LEGENDRE = np.linalg.inv(legendre.legvander(2.0 * np.append(0.0, NODES) - 1.0, DEGREE))


def legendre_values(place: Array) -> Array:
    """Values of the Legendre polynomials at places, shape (..., DEGREE + 1)."""
    return np.asarray(legendre.legvander(2.0 * place - 1.0, DEGREE), dtype=float)


def values(place: Array) -> Array:
    """The matrix from values at 0 and the nodes to values at places, shape (..., DEGREE + 1)."""
    return legendre_values(place) @ TO_LEGENDRE


# Matrix from values at 0 and the nodes to values at CHECKS.
AT_CHECKS: Array = values(CHECKS)
# Matrix from values at 0 and the nodes to Legendre coefficients of the derivative by the place.
SLOPES: Array = np.zeros((DEGREE + 1, DEGREE + 1))
SLOPES[:-1] = 2.0 * legendre.legder(np.eye(DEGREE + 1)) @ TO_LEGENDRE


def legendre_sum(coefficients: Array, z: Array) -> Array:
    """Sums of Legendre polynomials, a row of coefficients for each row of z in [-1, 1]; as z."""
    return np.asarray(legendre.legval(z, coefficients.T[:, :, None], tensor=False))


def legendre_at(series: Array, z: Array) -> Array:
    """The value of a Legendre series at each z in [-1, 1], as z; series has the coefficients along its last axis, and
    the axes of z before."""
    if not 0 < z.size <= FEW_VALUES:
        return np.asarray(legendre.legval(z, np.moveaxis(series, -1, 0), tensor=False))
    each = zip(series.reshape(z.size, -1).tolist(), z.ravel().tolist(), strict=True)
    return np.array([_clenshaw(one, at) for one, at in each]).reshape(z.shape)


def _clenshaw(series: list[float], z: float) -> float:
    """What legval does, to the same bits, by numbers: its steps of arrays take twenty times as long for one value."""
    now, above = series[-2:]
    for n in range(len(series) - 2, 0, -1):
        now, above = (
            series[n - 1] - above * (n / (n + 1)),
            now + above * z * ((2 * n + 1) / (n + 1)),
        )
    return now + above * z


def polynomial_through(at: list[float], values: list[float]) -> Callable[[float], float]:
    """The polynomial through a few points, by Newton's divided differences: scipy's are made for many points, and took
    a quarter of the time of a soft slider with a delay."""
    differences, nodes = values.copy(), at[:-1]
    for order in range(1, len(at)):
        for i in range(len(at) - 1, order - 1, -1):
            change = differences[i] - differences[i - 1]
            differences[i] = change / (at[i] - at[i - order])
    highest, *lower = differences[::-1]

    def value(place: float) -> float:
        found = highest
        for node, difference in zip(nodes[::-1], lower, strict=True):
            found = found * (place - node) + difference
        return found

    return value
