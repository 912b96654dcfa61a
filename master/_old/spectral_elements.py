"""Spectral elements on an interval: Gauss-Lobatto nodes, and the weak form of drift and diffusion between them."""

from collections.abc import Callable
from functools import lru_cache

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre

Array = npt.NDArray[np.float64]


class SpectralElements:
    """Polynomials of one degree on each element, continuous, known by their values at n Gauss-Lobatto nodes.

    Parameters
    ----------
    edges : array (m + 1,)
        Ends of the elements, increasing.
    degree : int

    Attributes
    ----------
    nodes, weights : arrays (n,), n = m * degree + 1
        Places and quadrature weights; the mass matrix is diag(weights).
    index : array (m, degree + 1)
        Nodes of each element.
    """

    def __init__(self, edges: Array, degree: int) -> None:
        at, weights, slopes = _lobatto(degree)
        self.edges, self.degree = edges, degree
        width = np.diff(edges)[:, None]
        self.index = np.arange(width.size)[:, None] * degree + np.arange(degree + 1)
        self.nodes = np.empty(width.size * degree + 1)
        self.nodes[self.index] = edges[:-1, None] + 0.5 * width * (at + 1.0)
        self.nodes[self.index[:, -1]] = edges[1:]
        self.weights = np.bincount(self.index.ravel(), (0.5 * width * weights).ravel())
        self._local = 0.5 * width * weights
        self._drift = slopes.T * weights
        self._diffusion = (2.0 / width)[:, :, None] * (self._drift @ slopes)

    def flow(self, drift: Array, diffusion: float) -> Array:
        """Elements' parts of -(φ_i', drift q + diffusion q'), shape (m, degree + 1, degree + 1).

        drift has one value per node. With no more than this, nothing flows through either end.
        """
        return -(self._drift * drift[self.index][:, None, :] + diffusion * self._diffusion)

    def diagonal(self, values: Array) -> Array:
        """Elements' parts of (φ_i, value q), one value per node, shape (m, degree + 1, degree + 1)."""
        return np.eye(self.degree + 1) * (self._local * values[self.index])[:, None, :]

    def project(self, density: Callable[[Array], Array], edges: Array) -> Array:
        """Values at the nodes whose sums against all elements' polynomials are those of a density, smooth between the
        points `edges`: their weight is exactly its weight."""
        cuts = np.unique(np.concatenate([self.edges, edges[(edges > self.edges[0]) & (edges < self.edges[-1])]]))
        left, right = cuts[:-1], cuts[1:]
        at, w = legendre.leggauss(self.degree + 8)
        half = 0.5 * (right - left)[:, None]
        x, w = left[:, None] + half * (at + 1.0), half * w
        element = np.searchsorted(self.edges, 0.5 * (left + right), side="right") - 1
        element = np.clip(element, 0, self.index.shape[0] - 1)
        begin, end = self.edges[element, None], self.edges[element + 1, None]
        value = density(x)
        value = np.where(np.isfinite(value), value, 0.0) * w
        local = _basis((2.0 * x - begin - end) / (end - begin), self.degree)
        parts = np.einsum("nq,nqk->nk", value, local)
        return np.bincount(self.index[element].ravel(), parts.ravel(), minlength=self.nodes.size) / self.weights

    def point(self, at: float) -> Array:
        """The same for a weight 1 at one point inside."""
        element = int(np.clip(np.searchsorted(self.edges, at, side="right") - 1, 0, self.index.shape[0] - 1))
        begin, end = self.edges[element], self.edges[element + 1]
        out = np.zeros(self.nodes.size)
        out[self.index[element]] = _basis(np.array([(2.0 * at - begin - end) / (end - begin)]), self.degree)[0]
        return out / self.weights

    def at(self, values: Array, x: Array) -> Array:
        """What has these values at the nodes, at x, any shape."""
        element = np.clip(np.searchsorted(self.edges, x, side="right") - 1, 0, self.index.shape[0] - 1)
        begin, end = self.edges[element], self.edges[element + 1]
        return (_basis((2.0 * x - begin - end) / (end - begin), self.degree) * values[self.index[element]]).sum(axis=-1)

    def series(self, values: Array) -> Array:
        """Legendre coefficients on each element of what has these values at the nodes, shape (degree + 1, m)."""
        nodes = _lobatto(self.degree)[0]
        return np.linalg.solve(legendre.legvander(nodes, self.degree), values[self.index].T)


@lru_cache
def _lobatto(degree: int) -> tuple[Array, Array, Array]:
    """Nodes, weights and differentiation matrix on [-1, 1]."""
    series = np.zeros(degree + 1)
    series[-1] = 1.0
    inner = np.sort(legendre.legroots(legendre.legder(series)).real)
    second = legendre.legder(series, 2)
    for _ in range(2):
        inner = inner - legendre.legval(inner, legendre.legder(series)) / legendre.legval(inner, second)
    x = np.concatenate([[-1.0], inner, [1.0]])
    tops = legendre.legval(x, series)
    weights = 2.0 / (degree * (degree + 1) * tops**2)
    gap = x[:, None] - x[None, :]
    np.fill_diagonal(gap, 1.0)
    slopes = tops[:, None] / tops[None, :] / gap
    np.fill_diagonal(slopes, 0.0)
    np.fill_diagonal(slopes, -slopes.sum(axis=1))
    return x, weights, slopes


def _basis(x: Array, degree: int) -> Array:
    """Lagrange polynomials of the Lobatto nodes at x; one axis more."""
    nodes = _lobatto(degree)[0]
    return legendre.legvander(x, degree) @ np.linalg.inv(legendre.legvander(nodes, degree))
