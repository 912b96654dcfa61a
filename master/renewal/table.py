"""Table: functions of one number, kept as polynomials on panels that are halved as needed."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numpy.polynomial import chebyshev, legendre

Array = npt.NDArray[np.float64]

# Nodes of a panel; a look-up sums as many coefficients.
SIZE = 12
# Most new panels that are halved together: more of them would only resolve rounding.
MOST = 1024
# Ratio of a panel's width to its place below which its nodes coincide by rounding.
NARROWEST = 1e-15
# Halving reduces the last coefficients below this share of themselves, unless they are rounding.
HARDLY = 0.3
# Most halvings of a panel: 2^-50 of it is rounding.
DEPTH = 50


class Basis(NamedTuple):
    """Nodes of a panel, as shares of it; matrices from values there to Legendre coefficients, and from
    these to values at both ends and to Chebyshev coefficients."""

    nodes: Array
    to_legendre: Array
    at_ends: Array
    to_chebyshev: Array


@lru_cache
def basis_of(size: int) -> Basis:
    """Nodes and matrices for polynomials with `size` coefficients."""
    z = legendre.leggauss(size)[0]
    to_legendre = np.linalg.inv(legendre.legvander(z, size - 1)).T
    at_ends = legendre.legvander(np.array([-1.0, 1.0]), size - 1).T
    to_chebyshev = np.linalg.solve(
        chebyshev.chebvander(z, size - 1), legendre.legvander(z, size - 1)
    )
    return Basis(
        0.5 * (z + 1.0),
        np.asarray(to_legendre, dtype=float),
        at_ends,
        np.asarray(to_chebyshev, dtype=float),
    )


def beside(x: Array, ends: Array) -> Array:
    """Points, in rows, moved to that side of the ends on which the middle of their row lies.

    A point at an end belongs to what begins there.
    """
    after = np.searchsorted(ends, x[:, x.shape[1] // 2, None], "right")
    after = np.clip(after, 1, ends.size - 1)
    return np.clip(x, ends[after - 1], np.nextafter(ends[after], ends[0]))


class Table:
    """Functions of one number x >= 0, a length or a time, polynomials between edges; 0 beyond the last.

    Parameters
    ----------
    function : takes x of shape (panels, nodes), each row within one panel, and gives an array of
        shape (functions, panels, nodes)
    edges : array of shape (n,)
        Sorted; the functions may jump or bend there.
    accuracy : float
        A panel is halved while one of its last two coefficients is larger.
    shortest : float
        Length of the shortest panel.
    ends : float
        Allowed error of a polynomial at the ends of its panel, in units of the accuracy; 0: not
        checked. The check detects a fall that is over before the first node.
    size : int
        Coefficients of the polynomials.
    first_cut : float
        Share of its width at which the first panel is cut.
    goes_on : callable
        Whether there is time left to halve panels.
    felt : callable
        Takes values, as `function` gives them, and the panels' widths; returns the factor on the
        accuracy of each panel, shape (panels,).
    rounding : float
        In units of the accuracy: panels whose last coefficients are below it are no longer halved
        once halving hardly reduces these.

    Attributes
    ----------
    error : float
        Largest of the last coefficients of all panels.
    """

    def __init__(
        self,
        function: Callable[[Array], Array],
        edges: Array,
        accuracy: float,
        shortest: float,
        ends: float = 0.0,
        size: int = SIZE,
        first_cut: float = 0.5,
        goes_on: Callable[[], bool] = lambda: True,
        felt: Callable[[Array, Array], Array] | None = None,
        rounding: float = 0.0,
    ) -> None:
        """Halve the panels until polynomials give the function to the accuracy; the arguments are those above."""
        basis = basis_of(size)
        low, high = np.asarray(edges[:-1], dtype=float), np.asarray(edges[1:], dtype=float)
        kept, self.error, was = [], 0.0, np.full(low.size, np.inf)
        for _ in range(DEPTH):
            nodes = low[:, None] + (high - low)[:, None] * basis.nodes
            if ends > 0.0:
                nodes = np.concatenate([low[:, None], nodes, high[:, None]], axis=1)
            values = function(nodes)
            coefficients = (values[..., 1:-1] if ends > 0.0 else values) @ basis.to_legendre
            tail = np.abs(coefficients[..., -2:]).max(axis=(0, 2))
            if ends > 0.0:
                missed = np.abs(coefficients @ basis.at_ends - values[..., [0, -1]]).max(
                    axis=(0, 2)
                )
                tail = np.maximum(tail, missed / ends)
            if felt is not None:
                tail = tail / felt(values, high - low)
            least = np.maximum(shortest, NARROWEST * np.abs(high))
            open_ = (tail > accuracy) & (high - low > least) & (low.size <= MOST + edges.size)
            open_ &= (tail > rounding * accuracy) | (tail < HARDLY * was)
            open_ &= goes_on()
            kept.append((low[~open_], high[~open_], coefficients[:, ~open_]))
            self.error = max(self.error, float(tail[~open_].max(initial=0.0)))
            low, high, was = low[open_], high[open_], np.tile(tail[open_], 2)
            if not low.size:
                break
            middle = low + np.where(low == edges[0], first_cut, 0.5) * (high - low)
            low, high = np.concatenate([low, middle]), np.concatenate([middle, high])
        begin = np.concatenate([part[0] for part in kept])
        order = np.argsort(begin)
        self.begin: Array = begin[order]
        self.end: Array = np.concatenate([part[1] for part in kept])[order]
        parts = np.concatenate([part[2] for part in kept], axis=1)[:, order]
        self._parts = np.ascontiguousarray(np.moveaxis(parts, -1, 0))  # (size, functions, panels)
        self._waves = np.tensordot(basis.to_chebyshev, self._parts, 1)

    @property
    def edges(self) -> Array:
        """Edges of the panels, shape (panels + 1,)."""
        return np.append(self.begin, self.end[-1])

    @property
    def widths(self) -> Array:
        return self.end - self.begin

    @property
    def tails(self) -> Array:
        """The larger of the last two coefficients of any function, shape (panels,)."""
        return np.asarray(np.abs(self._parts[-2:]).max(axis=(0, 1)))

    def __call__(self, x: Array) -> Array:
        """Values of the functions, shape (functions, *x.shape)."""
        panel = np.searchsorted(self.begin, x, "right") - 1
        panel = np.clip(panel, 0, self.begin.size - 1)
        z = (2.0 * x - self.begin[panel] - self.end[panel]) / self.widths[panel]
        inside = x < self.end[-1]
        return self._summed(np.where(inside, z, 0.0), panel) * inside

    def _summed(self, z: Array, panel: npt.NDArray[np.intp]) -> Array:
        """The polynomials at z in [-1, 1] on panels of the same shape; shape (functions, *shape).

        Clenshaw's rule for Chebyshev polynomials, in place, since much of the run time is spent here.
        """
        twice = 2.0 * z
        last = self._waves[-1].take(panel, axis=1)
        before, spare = np.zeros_like(last), np.empty_like(last)
        for row in self._waves[-2:0:-1]:
            np.multiply(twice, last, out=spare)
            spare -= before
            spare += row.take(panel, axis=1)
            before, last, spare = last, spare, before
        return np.asarray(self._waves[0].take(panel, axis=1) + z * last - before)

    def integrals(self) -> Array:
        """Integral of each function over all panels, shape (functions,)."""
        return np.asarray(self._parts[0] @ self.widths)

    def missed(self) -> Array:
        """Errors of the integrals, from the decay of the coefficients; shape (functions,).

        Gauss nodes integrate polynomials of twice the degree exactly: the coefficients are taken to
        keep, up to there, the decay that the last four show.
        """
        size = np.abs(self._parts)
        last, before = size[-2:].max(axis=0), size[-4:-2].max(axis=0)
        fall = np.divide(last, before, out=np.ones_like(last), where=before > last)
        rounding = np.finfo(float).eps * size.max(axis=0)
        return np.asarray((last * fall ** (SIZE // 2) + rounding) @ self.widths)

    def before(self, x: Array) -> Array:
        """Integral of the first function from the first edge to x, same shape as x."""
        whole = np.append(0.0, np.cumsum(self.widths * self._parts[0, 0]))
        panel = np.clip(np.searchsorted(self.begin, x, "right") - 1, 0, self.begin.size - 1)
        way = np.minimum(x, self.end[panel]) - self.begin[panel]
        # the mean up to x keeps its digits where x is close to an edge, unlike the integral
        nodes = basis_of(self._parts.shape[0]).nodes
        grown = legendre.legval(2.0 * nodes - 1.0, legendre.legint(self._parts[:, 0], lbnd=-1.0))
        mean = (0.5 * grown / nodes) @ basis_of(nodes.size).to_legendre
        z = 2.0 * way / self.widths[panel] - 1.0
        return np.asarray(whole[panel] + way * legendre.legval(z, mean.T[:, panel], tensor=False))

    def beyond(self, x: Array) -> Array:
        """Integral of the first function from x to the last edge, same shape as x."""
        return np.asarray(self.integrals()[0] - self.before(x))
