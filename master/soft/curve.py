"""The load along one straight move of the slider, on panels; where slips begin and end on it.

With y the travel of the slider, and F along the motion,

    load(y) = F(y) + K y,    slope(y) = F'(y) + K.

The drive at X_T balances the load K X_T, counted from the move's beginning. The slider follows the
drive as long as the load rises. Where its slope falls below zero, or contacts at one exact threshold
break together, it slips; it stops at the first y where the load has the same value again.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre
from scipy.optimize.elementwise import find_root

from master.renewal import rule
from origins.thresholds.law import Array

Travel = float | Array


class LoadCurve:
    """Force along the motion over the slider's travel, a polynomial on each panel.

    begin, width : arrays of shape (n,), of panels one after the other from 0
    force : array of shape (n, DEGREE + 1), along the motion, at share 0 and at the nodes (lengths)
    rough : array of shape (n,), error of the polynomials, which may oscillate (lengths)
    error : array of shape (n,), estimate from above of the error of the force on each panel (lengths)
    drops : array of shape (m,), travels, sorted, at which finite shares of the contacts break at once
    spring : K/(N_c <k>)
    """

    def __init__(
        self,
        begin: Array,
        width: Array,
        force: Array,
        rough: Array,
        error: Array,
        drops: Array,
        spring: float,
    ) -> None:
        """Keep the force, its slope and the load as Legendre series on each panel."""
        self.begin, self.width, self._rough, self.error = begin, width, rough, error
        self.drops, self.spring = drops, spring
        self._ends = np.append(begin[1:], begin[-1] + width[-1])
        self.end = float(self._ends[-1])
        self._force = force @ rule.TO_LEGENDRE.T
        self._rate = _slopes(self._force) * (2.0 / width[:, None])
        self._slope = self._rate.copy()
        self._slope[:, 0] += spring
        self._load = self._force.copy()
        self._load[:, 0] += spring * (begin + 0.5 * width)
        self._load[:, 1] += spring * 0.5 * width

    def panel(self, y: Travel) -> npt.NDArray[np.intp]:
        """Index of the panel on which travels lie; an edge belongs to the panel that it ends."""
        return np.clip(np.searchsorted(self.begin, y) - 1, 0, self.begin.size - 1)

    def force(self, y: Travel) -> Array:
        """Force along the motion at travels y, just before a drop; same shape as y."""
        return self._values(self._force, y)

    def slope(self, y: Travel) -> Array:
        """F' + K at travels y."""
        return self._values(self._slope, y)

    def bend(self, y: Travel) -> Array:
        """|F''| at travels y."""
        return np.abs(self._values(_slopes(self._rate) * (2.0 / self.width[:, None]), y))

    def error_at(self, y: Travel) -> Array:
        """Estimate from above of the error of the force at travels y."""
        return np.asarray(self.error[self.panel(y)])

    def _values(self, coefficients: Array, y: Travel) -> Array:
        panel = self.panel(y)
        z = np.clip(2.0 * (y - self.begin[panel]) / self.width[panel] - 1.0, -1.0, 1.0)
        own = np.moveaxis(coefficients[panel], -1, 0)
        return np.asarray(legendre.legval(z, own, tensor=False))

    def slip_begins(self, after: float) -> float:
        """The first travel after `after` beyond which the load falls; inf if there is none."""
        drops = self.drops[self.drops > after]
        return float(np.min([self._first_below(self._slope, after), *drops[:1]]))

    def slip_ends(self, after: float, level: float, falling: float) -> float:
        """The first travel after a slip's beginning where the load is at `level` again; inf if none.

        falling : distance after which the computed load surely falls, 0 where it drops at once; the
            level is searched from where the load rises again
        """
        after = self._first_below(-self._slope, after + falling)
        lack = -self._load
        lack[:, 0] += level
        return self._first_below(lack, after)

    def misplaced(self, y: Travel, shift: float = 0.0, more: float = 0.0) -> Array:
        """Errors of travels y that were computed from given loads; same shape as y.

        An error e of the force displaces them by e over the slope; near a slip, where the slope
        vanishes, by at most the root of 4 e over |F''|.

        shift : error of the position of slider and contacts together
        more : error of the loads
        """
        slope = np.maximum(self.slope(y), 0.0)
        error = more + self.error_at(y) + np.abs(slope - self.spring) * shift
        bend = np.maximum(self.bend(y), np.finfo(float).tiny)
        beyond = np.sqrt(np.maximum(slope**2 - 2.0 * bend * error, 0.0))
        with np.errstate(divide="ignore"):
            return np.minimum(2.0 * error / (slope + beyond), 2.0 * np.sqrt(error / bend))

    def slope_error(self, y: float) -> float:
        """Error of F' at y, from that of F by Bernstein's inequality for polynomials."""
        panel = int(self.panel(y))
        z = float(2.0 * (y - self.begin[panel]) / self.width[panel] - 1.0)
        steep = min(rule.DEGREE / np.sqrt(max(1.0 - z * z, 1e-300)), rule.DEGREE**2)
        error = steep * self._rough[panel] + self.error[panel]
        return float(error * 2.0 / self.width[panel])

    def _first_below(self, coefficients: Array, after: float) -> float:
        """The first travel >= after at which piecewise polynomials are below 0; inf if none."""
        least = coefficients[:, 0] - np.abs(coefficients[:, 1:]).sum(axis=1)
        for index in np.flatnonzero((least < 0.0) & (self._ends > after)):
            begin, width = float(self.begin[index]), float(self.width[index])
            first = np.clip(2.0 * (after - begin) / width - 1.0, -1.0, 1.0)
            panel = coefficients[index]
            # trailing coefficients below 1e-15 of the largest are rounding: leave them out
            roots = legendre.legroots(legendre.legtrim(panel, 1e-15 * np.abs(panel).max()))
            # rounding may have moved a double root off the real axis
            real = np.sort(roots.real[np.abs(roots.imag) < 1e-6])
            points = np.concatenate([[first], real[(real > first) & (real < 1.0)], [1.0]])
            below = legendre.legval(0.5 * (points[1:] + points[:-1]), panel) < 0.0
            if below.any():
                return begin + 0.5 * width * (1.0 + float(points[np.argmax(below)]))
        return np.inf

    def travel_at(self, load: Array, low: float, high: float) -> Array:
        """Travels from low to high, where the load rises, with given loads; same shape as load."""

        def lack(y: Array, load: Array) -> Array:
            return self.force(y) + self.spring * y - load

        # shares of a panel that bracket a given value of its load
        shares = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, 2 * rule.DEGREE + 1))
        places = self.begin[:, None] + self.width[:, None] * shares
        y = np.concatenate([[low], places[(places > low) & (places < high)], [high]])
        known = np.maximum.accumulate(lack(y, np.zeros(y.size)))
        load = np.clip(load, known[0], known[-1])
        cell = np.clip(np.searchsorted(known, load, "right") - 1, 0, y.size - 2)
        return np.asarray(find_root(lack, (y[cell], y[cell + 1]), args=(load,)).x)


class SlipBegin(NamedTuple):
    """Where a slip begins on a move.

    curve : LoadCurve, as far as it is solved
    travel : of the slider there; if there is no slip, one up to which the load rises as far as is asked
    load : there; inf if there is no slip
    """

    curve: LoadCurve
    travel: float
    load: float

    @property
    def error(self) -> float:
        """Estimate from above of the error of the load (a length)."""
        return float(self.curve.error_at(self.travel))

    @property
    def misplaced(self) -> float:
        """Error of the travel due to that of F' (a length); 0 where contacts break together."""
        if (self.curve.drops == self.travel).any():
            return 0.0
        return self.curve.slope_error(self.travel) / float(self.curve.bend(self.travel))


def _slopes(coefficients: Array) -> Array:
    """Derivative of Legendre sums by z, padded to the same shape."""
    return np.pad(legendre.legder(coefficients, axis=1), ((0, 0), (0, 1)))
