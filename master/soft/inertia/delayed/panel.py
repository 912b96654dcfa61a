"""A panel of time: X, breaks and the contacts' force as polynomials, known at the nodes of Radau's rule."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

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
# Matrix from Legendre coefficients to those of powers, the highest first.
POWERS = np.array(
    [
        np.pad(legendre.leg2poly(row[: k + 1]), (0, STAGES - k))[::-1]
        for k, row in enumerate(np.eye(STAGES + 1))
    ]
)
# Row from values at the nodes to the last Legendre coefficient of the polynomial through them.
LAST_OF_NODES: Array = _series(NODES)[-1]


def integrals_up_to(places: Array) -> Array:
    """The matrix from values at the nodes to integrals from the panel's beginning up to these places, per width."""
    integrals = legendre.legint(np.eye(STAGES), lbnd=-1) @ _series(NODES)
    return np.asarray(0.5 * legendre.legvander(2.0 * places - 1.0, STAGES) @ integrals)


# Those up to each node.
TO_NODES: Array = integrals_up_to(NODES)
# Matrix from values at PLACES to derivatives at the nodes, per width.
SLOPES: Array = 2.0 * (
    legendre.legvander(2.0 * NODES - 1.0, STAGES - 1) @ legendre.legder(TO_SERIES)
)


@dataclass(frozen=True)
class TimePanel:
    """Polynomials of time on one panel.

    begin, width : times; series : Legendre coefficients of X, breaks and force, shape (3, STAGES + 1)
    """

    begin: float
    width: float
    series: Array

    @classmethod
    def through(cls, begin: float, width: float, values: Array) -> "TimePanel":
        """With these values at PLACES, shape (3, STAGES + 1)."""
        return cls(begin, width, values @ TO_SERIES.T)

    @property
    def end(self) -> float:
        """Its last instant."""
        return self.begin + self.width

    def at(self, t: float | Array, row: int) -> Any:
        """One of the polynomials at times; as t."""
        return _value(self._powers[row], self._z(t))

    def slope(self, t: float | Array, row: int) -> Any:
        """The derivative by time of one of them; as t."""
        return _value(self._slopes[row], self._z(t)) * (2.0 / self.width)

    @cached_property
    def _powers(self) -> list[list[float]]:
        """Coefficients of powers of z = 2 (t - begin)/width - 1, the highest first."""
        return list((self.series @ POWERS).tolist())

    @cached_property
    def _slopes(self) -> list[list[float]]:
        """Those of the derivatives by z."""
        return list((self.series @ POWERS[:, :-1] * np.arange(STAGES, 0, -1)).tolist())

    def when(self, row: int, value: float) -> float:
        """When one of them has a value that it has not passed at the beginning, but at the end."""
        return float(brentq(lambda t: float(self.at(t, row)) - value, self.begin, self.end))

    def cut(self, end: float) -> "TimePanel":
        """The same polynomials up to an earlier end."""
        if end >= self.end:
            return self
        width = end - self.begin
        z = self._z(self.begin + width * PLACES)
        values = np.stack([_value(row, z) for row in self._powers])
        return replace(self, width=width, series=values @ TO_SERIES.T)

    def nodes(self, row: int) -> Array:
        """One of them at the nodes, shape (STAGES,)."""
        return np.asarray(_value(self._powers[row], 2.0 * NODES - 1.0))

    @property
    def times(self) -> Array:
        """The nodes as times."""
        return self.begin + self.width * NODES

    def integral(self, values: Array) -> float:
        """The integral over the panel of what has these values at its nodes."""
        return self.width * float(TO_NODES[-1] @ values)

    @property
    def weights(self) -> Array:
        """Of the nodes in integrals over the panel, times."""
        return self.width * TO_NODES[-1]

    def last(self) -> Array:
        """The larger of the last two coefficients of each polynomial: about what the polynomial misses."""
        return np.asarray(np.abs(self.series[:, -2:]).max(axis=1))

    def _z(self, t: float | Array) -> Any:
        return 2.0 * (t - self.begin) / self.width - 1.0


def _value(powers: list[float], z: Any) -> Any:
    """A polynomial at z, a number or an array, by Horner's rule."""
    value = powers[0]
    for coefficient in powers[1:]:
        value = value * z + coefficient
    return value
