"""A panel of time: X, breaks and the contacts' force as polynomials, known at the nodes of Radau's rule."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.polynomial import legendre
from scipy.optimize import brentq
from scipy.special import roots_jacobi

from origins.thresholds.law import Array

# Nodes of a panel, the last of which is its end: a stiff oscillation, such as ringing that is too small to be followed,
# dies out on panels longer than its period. Four nodes would need a third more panels, seven more work on each.
STAGES = 5
NODES: Array = np.append(0.5 * (roots_jacobi(STAGES - 1, 1, 0)[0] + 1.0), 1.0)
PLACES: Array = np.append(0.0, NODES)
# Rows of a panel's polynomials.
POSITION, BREAKS, FORCE = range(3)


def _series(places: Array) -> Array:
    """The matrix from values at places in [0, 1] to coefficients of Legendre polynomials."""
    return np.asarray(np.linalg.inv(legendre.legvander(2.0 * places - 1.0, places.size - 1)))


TO_SERIES = _series(PLACES)
# Matrix (node, node) from values at the nodes to integrals from the panel's beginning up to each node, per width.
TO_NODES: Array = 0.5 * (
    legendre.legvander(2.0 * NODES - 1.0, STAGES)
    @ legendre.legint(np.eye(STAGES), lbnd=-1)
    @ _series(NODES)
)
# Matrix from values at PLACES to derivatives at the nodes, per width.
SLOPES: Array = 2.0 * (
    legendre.legvander(2.0 * NODES - 1.0, STAGES - 1) @ legendre.legder(TO_SERIES)
)


@dataclass(frozen=True)
class Panel:
    """Polynomials of time on one panel.

    begin, width : times; series : Legendre coefficients of X, breaks and force, shape (3, STAGES + 1)
    """

    begin: float
    width: float
    series: Array

    @classmethod
    def through(cls, begin: float, width: float, values: Array) -> "Panel":
        """With these values at PLACES, shape (3, STAGES + 1)."""
        return cls(begin, width, values @ TO_SERIES.T)

    @property
    def end(self) -> float:
        """Its last instant."""
        return self.begin + self.width

    def at(self, t: float | Array, row: int) -> Array:
        """One of the polynomials at times; as t."""
        return np.asarray(legendre.legval(self._z(t), self.series[row]))

    def slope(self, t: float | Array, row: int) -> Array:
        """The derivative by time of one of them; as t."""
        return np.asarray(legendre.legval(self._z(t), self._slopes[row]))

    @cached_property
    def _slopes(self) -> Array:
        """Legendre coefficients of the derivatives."""
        return np.asarray(legendre.legder(self.series, axis=1) * (2.0 / self.width), dtype=float)

    def when(self, row: int, value: float) -> float:
        """When one of them has a value that it has not passed at the beginning, but at the end."""
        return float(brentq(lambda t: float(self.at(t, row)) - value, self.begin, self.end))

    def cut(self, end: float) -> "Panel":
        """The same polynomials up to an earlier end."""
        if end >= self.end:
            return self
        width = end - self.begin
        z = self._z(self.begin + width * PLACES)
        values = legendre.legval(z, self.series.T)
        return replace(self, width=width, series=np.asarray(values) @ TO_SERIES.T)

    def nodes(self, row: int) -> Array:
        """One of them at the nodes, shape (STAGES,)."""
        return np.asarray(legendre.legval(2.0 * NODES - 1.0, self.series[row]))

    @property
    def times(self) -> Array:
        """The nodes as times."""
        return self.begin + self.width * NODES

    def integral(self, values: Array) -> float:
        """The integral over the panel of what has these values at its nodes."""
        return self.width * float(TO_NODES[-1] @ values)

    def last(self) -> Array:
        """The larger of the last two coefficients of each polynomial: about what the polynomial misses."""
        return np.asarray(np.abs(self.series[:, -2:]).max(axis=1))

    def _z(self, t: float | Array) -> Array:
        return np.asarray(2.0 * (np.asarray(t) - self.begin) / self.width - 1.0)
