"""Curve: the load that the drive must carry along one straight move of the slider, on panels.

With y the travel of the slider, and F along the motion,

    load(y) = F(y) + K y,    slope(y) = F'(y) + K.

The slider follows the drive as long as the load rises. Where its slope falls below zero, or
contacts at one exact threshold break, it slips; it stops at the first y that carries the same load.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre
from scipy.optimize import brentq

from master.renewal import rule

Array = npt.NDArray[np.float64]

# Shares of a panel at which its polynomials are sampled for roots: twice as many as coefficients.
SHARES: Array = np.asarray(0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, 2 * rule.DEGREE + 1)))
_SAMPLED = legendre.legvander(2.0 * SHARES - 1.0, rule.DEGREE).T
# Half the second difference of the samples: twice as far as a parabola dips between them.
_DIP = 0.5
# Newton steps, each safe in its bracket: convergence is quadratic from a 33rd of a panel on.
_NEWTON = 40


class Panels(NamedTuple):
    """Panels of travel, one after the other from 0.

    begin, width : arrays of shape (n,)
    force : array of shape (n, DEGREE + 1), along the motion, at share 0 and at the nodes (lengths)
    rough : array of shape (n,), by how much the polynomials may sway (lengths)
    """

    begin: Array
    width: Array
    force: Array
    rough: Array


class Curve:
    """Force along the motion over the slider's travel, a polynomial on each panel.

    Parameters
    ----------
    panels : Panels
    error : array of shape (n,)
        Bound on the error of the force on each panel (a length).
    drops : array of shape (m,)
        Travels, sorted, at which finite shares of the contacts break at once.
    spring : float
        K/(N_c <k>).
    """

    def __init__(self, panels: Panels, error: Array, drops: Array, spring: float) -> None:
        begin, width, force, self._rough = panels
        self.begin, self.width, self.error = begin, width, error
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

    def panel(self, y: Array) -> npt.NDArray[np.intp]:
        """On which panel travels lie; an edge belongs to the panel that it ends."""
        return np.clip(np.searchsorted(self.begin, y) - 1, 0, self.begin.size - 1)

    def force(self, y: Array) -> Array:
        """Force along the motion at travels y, just before a drop; same shape as y."""
        return self._values(self._force, y)

    def slope(self, y: Array) -> Array:
        """F' + K at travels y."""
        return self._values(self._slope, y)

    def bend(self, y: Array) -> Array:
        """|F''| at travels y."""
        return np.abs(self._values(_slopes(self._rate) * (2.0 / self.width[:, None]), y))

    def _values(self, coefficients: Array, y: Array) -> Array:
        panel = self.panel(y)
        z = np.clip(2.0 * (y - self.begin[panel]) / self.width[panel] - 1.0, -1.0, 1.0)
        return rule.legendre_sum(coefficients[panel], z[:, None])[:, 0]

    def lets_go(self, after: float) -> float:
        """The first travel beyond which the load falls, inf if there is none."""
        drops = self.drops[self.drops > after]
        falls = self._first_below(self._slope, after)
        return min(falls, float(drops[0])) if drops.size else falls

    def catches(self, after: float, level: float, beside: float) -> float:
        """The first travel beyond a slip's beginning that carries the level again, inf if none.

        beside : travel beyond which the load is seen to fall, and what carries the level is looked
            for from where it rises again; 0 where it falls at once
        """
        if beside > 0.0:
            after = self._first_below(-self._slope, after + beside)
        if not np.isfinite(after):
            return np.inf
        lack = -self._load
        lack[:, 0] += level
        return self._first_below(lack, after)

    def misplaced(self, y: Array, shift: Array | float = 0.0, more: float = 0.0) -> Array:
        """How far off travels y may be that carry given loads; same shape as y.

        An error e of the force displaces them by e over the slope, which falls towards a slip: by
        no more than the root of 4 e over the bend.

        shift : how far off the slider may stand together with its contacts
        more : error of the loads
        """
        slope = np.maximum(self.slope(y), 0.0)
        error = more + self.error[self.panel(y)] + np.abs(slope - self.spring) * shift
        bend = np.maximum(self.bend(y), np.finfo(float).tiny)
        beyond = np.sqrt(np.maximum(slope**2 - 2.0 * bend * error, 0.0))
        with np.errstate(divide="ignore"):
            return np.minimum(2.0 * error / (slope + beyond), 2.0 * np.sqrt(error / bend))

    def slope_error(self, y: float) -> float:
        """How far off F' may be at y: Bernstein's inequality for polynomials that sway."""
        panel = self.panel(np.array([y]))[0]
        z = 2.0 * (y - self.begin[panel]) / self.width[panel] - 1.0
        steep = min(rule.DEGREE / np.sqrt(max(1.0 - z * z, 1e-300)), rule.DEGREE**2)
        error = steep * self._rough[panel] + self.error[panel]
        return float(error * 2.0 / self.width[panel])

    def _first_below(self, coefficients: Array, after: float) -> float:
        """The first travel from one on at which piecewise polynomials are below 0; inf if none."""
        values = coefficients @ _SAMPLED
        dip = _DIP * np.abs(np.diff(values, 2, axis=1)).max(axis=1)
        may = (values.min(axis=1) < dip) & (self._ends > after)
        for index in np.flatnonzero(may):
            begin, width = float(self.begin[index]), float(self.width[index])
            share = _first_negative(coefficients[index], max(0.0, (after - begin) / width))
            if share is not None:
                return begin + width * share
        return np.inf

    def carries(self, load: Array, low: float, high: float) -> Array:
        """Travels from low to high, where the load rises, that carry loads; same shape as load."""
        shares = self.begin[:, None] + self.width[:, None] * SHARES
        y = np.concatenate([[low], shares[(shares > low) & (shares < high)], [high]])
        known = np.maximum.accumulate(self.force(y) + self.spring * y)
        cell = np.clip(np.searchsorted(known, load, "right") - 1, 0, y.size - 2)
        left, right = y[cell], y[cell + 1]
        rise = np.maximum(known[cell + 1] - known[cell], np.finfo(float).tiny)
        out = left + (right - left) * np.clip((load - known[cell]) / rise, 0.0, 1.0)
        for _ in range(_NEWTON):
            lack = self.force(out) + self.spring * out - load
            left, right = np.where(lack < 0.0, out, left), np.where(lack < 0.0, right, out)
            slope = self.slope(out)
            new = out - lack / np.where(slope > 0.0, slope, np.inf)
            inside = (new >= left) & (new <= right) & (slope > 0.0)
            new = np.where(inside, new, 0.5 * (left + right))
            done = np.abs(new - out).max(initial=0.0) <= 4e-16 * self.end
            out = new
            if done:
                break
        return out


def _slopes(coefficients: Array) -> Array:
    """Derivative of Legendre sums by z, padded to the same shape."""
    return np.pad(legendre.legder(coefficients, axis=1), ((0, 0), (0, 1)))


def _first_negative(coefficients: Array, after: float) -> float | None:
    """The first share from one on at which a polynomial is below 0, None if there is none."""

    def value(share: Array | float) -> Array:
        return np.asarray(legendre.legval(2.0 * np.asarray(share) - 1.0, coefficients))

    def slope(share: float) -> float:
        return float(legendre.legval(2.0 * share - 1.0, slopes))

    slopes = legendre.legder(coefficients)
    shares = np.append(after, SHARES[after < SHARES])
    found = value(shares)
    inner = np.arange(1, shares.size - 1)
    lowest = inner[(found[inner] <= found[inner - 1]) & (found[inner] <= found[inner + 1])]
    for i in lowest[found[lowest] > 0.0]:
        if slope(shares[i - 1]) < 0.0 < slope(shares[i + 1]):
            least = brentq(slope, shares[i - 1], shares[i + 1])
            shares = np.sort(np.append(shares, least))
    found = value(shares)
    below = np.flatnonzero(found < 0.0)
    if not below.size:
        return None
    if not below[0]:
        return float(after)
    left, right = shares[below[0] - 1], shares[below[0]]
    return (
        float(brentq(value, left, right, xtol=1e-15)) if found[below[0] - 1] > 0.0 else float(left)
    )
