"""The load along one straight move of the slider, on panels; where slips begin and end on it.

With y the travel of the slider, and F along the motion,

    load(y) = F(y) + K y,    load_slope(y) = F'(y) + K.

The drive at X_T balances the load K X_T, counted from the move's beginning. The slider follows the
drive as long as the load rises. Where its slope falls below zero, or contacts at one exact threshold
break together, it slips in no time: the drive stands, so that it stops at the first y where the
load has the same value again.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre

from master.numerics import polynomials
from origins.thresholds.law import Array
from origins.thresholds.numerical import clipped

# Coefficients of a panel's polynomial below this part of the largest are rounding, and would give roots of their own.
ROUNDED = 1e-15
# Part of a panel's width by which rounding may move a double root off the real axis: about the root of 1e-12, what
# coefficients may be rounded by.
OFF_AXIS = 1e-6
# A slope of the load above this many errors of the slope did not come down to 0 before: at a slip it jumps.
SURELY_ABOVE = 10.0
# Newton's method for travels: most steps, each at most this part of the one before; and the rounding of loads and
# travels, a part of the largest on the panel.
MOST_STEPS, SHORTER, ROUNDED_LOAD = 200, 0.75, np.finfo(float).eps
# A force that no longer changes is laid out this many times as far as is asked, so that few panels are added.
AHEAD = 2.0


@dataclass(frozen=True)
class LoadCurve:
    """Force along the motion, F times its direction +1 or -1, over the travel: a polynomial on each panel.

    from_travel, width : arrays of shape (n,), of panels one after the other from the travel 0, or from where they are
        asked for; `begin` and `end` are times, everywhere else
    series : array of shape (n, DEGREE + 1), Legendre coefficients of the force (lengths)
    error : array of shape (n,), estimate from above of the error of the force on each panel (lengths)
    own_error : array of shape (n,), the part of `error` that changes on the panel itself (lengths)
    drops : array of shape (m,), travels, sorted, at which finite shares of the contacts break at once
    spring : K/(N_c <k>)
    break_length : the force of contacts born together changes no faster than by the largest one over this length
    """

    from_travel: Array
    width: Array
    series: Array
    error: Array
    own_error: Array
    drops: Array
    spring: float
    break_length: float

    @property
    def to_travel(self) -> float:
        """The travel up to which the load is known."""
        return float(self.from_travel[-1] + self.width[-1])

    def force(self, y: float | Array) -> Array:
        """Force along the motion at travels y, just before a drop; same shape as y."""
        return self._values(self.series, y)

    def load_slope(self, y: float | Array) -> Array:
        """F' + K at travels y."""
        return self._values(self._slopes, y) + self.spring

    def bend(self, y: float | Array) -> Array:
        """F'' at travels y."""
        return self._values(self._bends, y)

    def curvature(self, y: float | Array) -> Array:
        """|F''| at travels y."""
        return np.abs(self.bend(y))

    def error_at(self, y: float | Array) -> Array:
        """Estimate from above of the error of the force at travels y."""
        return np.asarray(self.error[self.panel(y)])

    def panel(self, y: float | Array) -> npt.NDArray[np.intp]:
        """Index of the panel on which travels lie; an edge belongs to the panel that it ends."""
        return clipped(np.searchsorted(self.from_travel, y) - 1, 0, self.from_travel.size - 1)

    def _values(self, series: Array, y: float | Array) -> Array:
        panel = self.panel(y)
        z = clipped(2.0 * (y - self.from_travel[panel]) / self.width[panel] - 1.0, -1.0, 1.0)
        return polynomials.legendre_at(series[panel], np.asarray(z))

    @cached_property
    def _slopes(self) -> Array:
        """Legendre coefficients of F'."""
        return legendre.legder(self.series, axis=1) * (2.0 / self.width[:, None])

    @cached_property
    def _bends(self) -> Array:
        """Legendre coefficients of F''."""
        return legendre.legder(self._slopes, axis=1) * (2.0 / self.width[:, None])

    def slip_begins(self, after: float) -> float:
        """The first travel after `after` beyond which the load falls; inf if there is none.

        The load falls where its slope is below 0 by more than the error of the slope somewhere
        before it rises again: a fall within that error may be numerical noise, and is no slip.
        """
        drops, slopes = self.drops[self.drops > after], self._slopes
        surely = self._first_above(-slopes, self.spring + self._steep, after)
        falls = self._first_above(-slopes, self.spring, after) if np.isfinite(surely) else np.inf
        while falls < surely:
            rises = self._first_above(slopes, -self.spring, falls, before=surely)
            if rises > surely:
                break
            falls = self._first_above(-slopes, self.spring, rises)
        return float(np.min([falls, *drops[:1]]))

    def may_fall(self, after: float) -> float:
        """The first travel after `after` at which the load falls or, within the error of its slope, may; inf if none.
        Births before a panel shift F there by their error, over the length on which contacts break."""
        drops = self.drops[self.drops > after]
        falls = self._first_above(-self._slopes, self.spring - self._slope_errors, after)
        return float(np.min([falls, *drops[:1]]))

    def largest_slope(self, low: float, high: float) -> tuple[float, float]:
        """A bound on |F'| between two travels, and its error."""
        panels = slice(int(self.panel(low)), int(self.panel(high)) + 1)
        # no Legendre polynomial exceeds 1
        bound = np.abs(self._slopes[panels]).sum(axis=1)
        return float(bound.max()), float(self._slope_errors[panels].max())

    @cached_property
    def _slope_errors(self) -> Array:
        """Errors of F' on panels, those of births before included."""
        return self._steep + self.error / self.break_length

    @cached_property
    def _steep(self) -> Array:
        """The largest slope of an error of `own_error`: Markov's inequality, of a polynomial of this degree."""
        return np.asarray(2.0 * polynomials.DEGREE**2 * self.own_error / self.width)

    def rises(self, after: float) -> float:
        """The first travel >= after from which the load rises; inf if none."""
        return self._first_above(self._slopes, -self.spring, after)

    def travel_to_load(self, level: float, after: float) -> float:
        """The first travel >= after at which the load is at `level`; inf if none."""
        load = self.series.copy()
        load[:, 0] += self.spring * (self.from_travel + 0.5 * self.width)
        load[:, 1] += self.spring * 0.5 * self.width
        return self._first_above(load, level, after)

    def _first_above(
        self, series: Array, level: float | Array, after: float, before: float = np.inf
    ) -> float:
        """The first travel >= after at which polynomials on panels are above a level, one for all or one for each
        panel; inf if none, or none on panels that begin before the travel `before`."""
        level = np.broadcast_to(level, self.from_travel.shape)
        most = series[:, 0] + np.abs(series[:, 1:]).sum(axis=1)
        ends = np.append(self.from_travel[1:], self.to_travel)
        # far from a move's beginning a narrow panel may be rounded to no width
        somewhere = (
            (most > level)
            & (ends > np.maximum(after, self.from_travel))
            & (self.from_travel < before)
        )
        for panel in np.flatnonzero(somewhere):
            first, end = float(self.from_travel[panel]), float(ends[panel])
            excess = series[panel].copy()
            excess[0] -= level[panel]
            roots = legendre.legroots(legendre.legtrim(excess, ROUNDED * np.abs(excess).max()))
            # from z in [-1, 1] to travels, and back
            middle, half = 0.5 * (first + end), 0.5 * (end - first)
            real = np.sort(middle + half * roots.real[np.abs(roots.imag) < 2.0 * OFF_AXIS])
            first = max(first, after)
            points = np.array([first, *real[(real > first) & (real < end)], end])
            between = 0.5 * (points[1:] + points[:-1])
            above = legendre.legval((between - middle) / half, excess) > 0.0
            if above.any():
                return float(points[np.argmax(above)])
        return np.inf

    def travel_errors(self, y: float | Array, shift: float = 0.0, more: float = 0.0) -> Array:
        """Errors of travels y that were computed from given loads; same shape as y.

        An error e of the force displaces them by e/(the slope); near a slip, where the slope
        vanishes, by at most the root of 4 e/|F''|.

        shift : error of the position of slider and contacts together
        more : error of the loads
        """
        slope = np.maximum(self.load_slope(y), 0.0)
        error = more + self.error_at(y) + np.abs(slope - self.spring) * shift
        curvature = np.maximum(self.curvature(y), np.finfo(float).tiny)
        beyond = np.sqrt(np.maximum(slope**2 - 2.0 * curvature * error, 0.0))
        with np.errstate(divide="ignore"):
            return np.minimum(2.0 * error / (slope + beyond), 2.0 * np.sqrt(error / curvature))

    def travel_at(self, load: Array, low: float, high: float) -> Array:
        """Travels from low to high, where the load rises, with given loads; same shape as load."""
        places = np.array(
            [low, *self.from_travel[(self.from_travel > low) & (self.from_travel < high)], high]
        )
        loads = np.maximum.accumulate(self.force(places) + self.spring * places)
        cell = clipped(np.searchsorted(loads, load) - 1, 0, places.size - 2)
        wanted = clipped(load, loads[0], loads[-1])
        below, above = places[cell], places[cell + 1]
        rounded = ROUNDED_LOAD * np.maximum(np.abs(loads[cell]), np.abs(loads[cell + 1]))
        narrowest = ROUNDED_LOAD * above
        y, step = 0.5 * (below + above), above - below
        for _ in range(MOST_STEPS):
            lack = wanted - self.force(y) - self.spring * y
            exact = np.abs(lack) <= rounded
            if (exact | (np.abs(step) <= narrowest)).all():
                break
            below, above = np.where(lack >= 0.0, y, below), np.where(lack <= 0.0, y, above)
            # Newton's step, or halving where it leaves the bracket or does not get shorter
            with np.errstate(all="ignore"):
                newton = y + lack / self.load_slope(y)
            good = (below <= newton) & (newton <= above)
            good &= np.abs(newton - y) <= SHORTER * np.abs(step)
            step = np.where(exact, 0.0, np.where(good, newton, 0.5 * (below + above)) - y)
            y = y + step
        return y


@dataclass(frozen=True)
class SteadyForce:
    """A force along the motion that no longer changes, and the error of that (lengths)."""

    force: float
    error: float

    def extend(self, curve: LoadCurve, y: float, largest: float) -> LoadCurve:
        """The curve with one more panel of this force, up to the travel y at least, and as far as a spring is stretched
        by the `largest` force of its contacts; positions on it are rounded."""
        width = AHEAD * max(y - curve.to_travel, largest / curve.spring, largest)
        series = np.zeros((1, curve.series.shape[1]))
        series[0, 0] = self.force
        error = curve.error[-1] + self.error
        return replace(
            curve,
            from_travel=np.append(curve.from_travel, curve.to_travel),
            width=np.append(curve.width, width),
            series=np.concatenate([curve.series, series]),
            error=np.append(curve.error, error),
            own_error=np.append(curve.own_error, 0.0),
        )


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
    def begin_error(self) -> float:
        """Error of the travel due to that of F' (a length); 0 where F' jumps, or contacts break together. All of the
        error of F may change on the panel."""
        return self._begin_error(self.error)

    @property
    def misjudged_travel(self) -> float:
        """The same, less where births before the panel are to blame: their force changes by their breaks alone."""
        return self._begin_error(float(self.curve.own_error[int(self.curve.panel(self.travel))]))

    def _begin_error(self, own: float) -> float:
        """Error of the travel, if this part of the error of F changes on the panel as polynomials do."""
        curve, y = self.curve, self.travel
        panel = int(curve.panel(y))
        begin, width = curve.from_travel[panel], curve.width[panel]
        # Bernstein's and Markov's inequalities: the slope of a polynomial's error, of this degree
        inside = max((y - begin) * (begin + width - y), (0.5 * width / polynomials.DEGREE) ** 2)
        before = max(self.error - own, 0.0) / curve.break_length
        steep = own * polynomials.DEGREE / np.sqrt(inside) + before
        jumps = (curve.drops == y).any() or curve.load_slope(y) > SURELY_ABOVE * steep
        # an error of the force, however steep, leaves the largest load within this way
        curvature = curve.curvature(y)
        return (
            0.0
            if jumps
            else float(np.minimum(steep, 2.0 * np.sqrt(self.error * curvature)) / curvature)
        )
