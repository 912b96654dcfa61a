"""Roots: the rates and frequencies with which F(X) decays to the kinetic force.

The Laplace transform of number conservation (docs/equations.md), d being the travel in the delay, is

    b^(s) D(s) = 1/s - G_0^(s),      D(s) = E^(s) e^(-sd) + (1 - e^(-sd))/s,

so that F - F_k is a sum of e^(sX) over the roots of D. All lie left of the imaginary axis, none on
the real one. On each window of a grid a rational function approximates D (scipy's AAA); Newton's
method starts from its roots.
"""

from __future__ import annotations

import warnings
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq

from master.steady.travel import Travel
from master.stick_slip.transform import NONE, Transform
from origins import Contacts

Array = npt.NDArray[np.float64]
Complex = npt.NDArray[np.complex128]

# Decay rates, per mean way from birth to birth: the first to which roots are searched, and the last,
# at which a wave has vanished after one such way.
FIRST, DEEPEST = 0.5, 40.0
# Roots are searched up to this share of the decay rate of E's tail, or of that of exact values.
NEAR = 0.9
# No root is near where |p^| is smaller than BELOW. Frequencies are searched first up to HIGH per
# length on which E falls, at most up to HIGHEST per mean way from birth to birth.
BELOW, HIGH, HIGHEST = 0.8, 8.0, 2000.0
# Most nodes times frequencies of a grid.
MOST_WORK = 1e8
# Spacing of the grid's frequencies, in units of the inverse mean way (weighted by e^(decay x));
# frequencies in a window, and those that it shares with the next; most decay rates of the grid.
SIDE, ROWS, SHARED, COLUMNS = 0.8, 32, 8, 8
# Relative error of the rational approximation of D in a window.
FOLLOWED = 1e-11
# Most steps of Newton's method; distance over |s| below which two roots count as equal.
STEPS, ONE = 40, 1e-7


class Known(NamedTuple):
    """A rate (per length) or a length, and its error."""

    value: float
    error: float


class Roots(NamedTuple):
    """All roots of D with Im s > 0 right of Re s = -searched (per length), slowest first.

    roots : array of shape (n,)
    searched : float
    """

    roots: Complex
    searched: float


def conserved(transform: Transform, wait: float, s: Complex) -> tuple[Complex, Complex]:
    """D and D' at s of shape (n,), no s being 0; `wait` is d, a length."""
    values = transform(s)
    waited, out = np.exp(-s * wait), -np.expm1(-s * wait) / s
    slope = waited * (values.slope - wait * values.held) + (wait * waited - out) / s
    return values.held * waited + out, slope


def root_errors(transform: Transform, wait: float, s: Complex) -> Array:
    """Errors of roots: the residual and the error of D, divided by |D'|."""
    value, slope = conserved(transform, wait, s)
    waited = np.abs(np.exp(-s * wait))
    off = transform(s).held_off * waited
    off += np.finfo(float).eps * (1.0 + (1.0 + np.abs(s) * wait) * waited) / np.abs(s)
    return np.asarray((np.abs(value) + off) / np.abs(slope) + np.spacing(np.abs(s)))


class Jumps(NamedTuple):
    """Ways (lengths) at which E jumps, and by how much; arrays of shape (n,)."""

    ways: Array
    shares: Array


def jumps_of(travel: Travel) -> Jumps:
    """Ways at which contacts reach exact thresholds together, and the shares that break there."""
    ways = travel.atoms[(travel.atoms > 0.0) & (travel.atoms <= travel.longest)]
    if not ways.size:
        return Jumps(ways, ways)
    # just before and after an exact threshold
    sides = 1.0 - 1e-11, 1.0 + 1e-11
    before, after = (travel.left(ways[:, None] * side)[0, :, 0] for side in sides)
    shares = np.maximum(before - after, 0.0)
    return Jumps(ways[shares > 0.0], shares[shares > 0.0])


def crowding_rate(travel: Travel, wait: float) -> float:
    """Decay rate (per length) near which infinitely many roots of ever higher frequency crowd, due to
    exact thresholds; inf without any, 0 where all contacts break at exact thresholds."""
    ways, shares = jumps_of(travel)
    if not ways.size:
        return np.inf
    if shares.sum() > 1.0 - 1e-14:
        return 0.0
    ways, shares = ways + wait, np.log(shares)
    most = -float(shares.max()) / float(ways.min())

    def held(rate: float) -> float:
        return float(np.logaddexp.reduce(rate * ways + shares))

    return float(brentq(held, 0.0, most, xtol=1e-300, rtol=1e-14))


def tail_rate(contacts: Contacts) -> Known:
    """Rate at which log S of the thresholds falls in the tail; inf if faster, 0 if slower than linear.

    Heat does not change it: the stronger a contact, the less likely it breaks before its threshold.
    """
    law = contacts.thresholds
    if np.isfinite(law.support()[1]):
        return Known(np.inf, 0.0)
    # the survival is sampled outwards, since many distributions cannot compute far quantiles
    x = contacts.mean_threshold * 2.0 ** np.arange(0.0, 400.0, 0.25)
    with np.errstate(over="ignore"):
        last = x[np.flatnonzero(law.logsf(x) > np.log(NONE))[-1]]
    ends = last * np.array([0.125, 0.25, 0.5, 1.0])
    # where log S = a - rate x + power log x, each doubling of x halves the slopes' distance to -rate
    slopes = -np.diff(law.logsf(ends)) / np.diff(ends)
    change = np.diff(slopes)
    rounded = 1e-9 * slopes[-1]
    level = abs(slopes[-1] - slopes[0]) < 0.25 * slopes[-1]
    if level and abs(change[1]) < max(0.6 * abs(change[0]), rounded):
        return Known(slopes[-1] + change[1], abs(2.0 * change[1] - change[0]) + rounded)
    return Known(np.inf if slopes[-1] > slopes[0] else 0.0, 0.0)


def leading_roots(transform: Transform, wait: float, count: int, limit: float) -> Roots:
    """At least `count` roots, or all right of Re s = -limit; fewer where D is too inaccurate there.

    Frequencies are searched up to some 2,000 per mean way from birth to birth.
    """
    whole = transform.travel.length + wait
    deepest = min(limit, DEEPEST / whole)
    # beyond this decay rate the error of D exceeds 1e-3 of its terms
    while not transform.noise(deepest) * deepest * np.exp(min(deepest * wait, 700.0)) < 1e-3:
        deepest *= 0.9
    decay = min(FIRST / whole, deepest)
    while True:
        found = _roots_to(transform, wait, decay)
        if found.size >= count or decay >= deepest:
            return Roots(found, decay)
        decay = min(2.0 * decay, deepest)


def _roots_to(transform: Transform, wait: float, decay: float) -> Complex:
    """All roots right of Re s = -decay with Im s > 0."""
    end = transform(np.array([complex(-decay)]))
    # the mean way from birth to break, weighted by e^(decay x)
    centre = float(((end.held - decay * end.slope) / (1.0 + decay * end.held)).real[0])
    step = SIDE / (centre + wait)
    columns = int(np.clip(np.ceil(decay / step), 2, COLUMNS)) + 1
    s, values = _grid(transform, wait, np.linspace(-decay, 0.0, columns), step)
    possible = np.abs(1.0 - s * values).max(axis=1) > BELOW
    begins = []
    for first in range(0, s.shape[0] - SHARED, ROWS - SHARED):
        rows = slice(first, first + ROWS)
        if possible[rows].any():
            begins.append(_rational_roots(s[rows], values[rows], step))
    found = _polished(transform, wait, np.concatenate([*begins, np.empty(0)]), step, decay)
    return found[(found.real > -decay) & (found.imag < s[-1, 0].imag)]


def _grid(transform: Transform, wait: float, real: Array, step: float) -> tuple[Complex, Complex]:
    """Numbers s up to the frequency above which |p^| stays below 1 at the first Re s, and D there.

    The part of p^ that is due to exact thresholds does not decay with the frequency, but stays below
    1 right of the rate at which their roots crowd.
    """
    jumps, decay = jumps_of(transform.travel), -float(real[0])
    lasting = float(jumps.shares @ np.exp(decay * (jumps.ways + wait)))
    whole = transform.travel.length + wait
    most = np.sqrt(MOST_WORK * step / transform.nodes_per_frequency())
    most = min(HIGHEST / whole, float(most))
    end = min(max(HIGH / transform.travel.grain, ROWS * step), most)
    while True:
        count = int(np.ceil(end / step)) + 2
        s = real + 1j * step * np.arange(count)[:, None]
        s[s == 0.0] = 1e-6 * step
        held = transform.grid(real, step, count)
        ways = np.exp(-np.multiply.outer(s[:, 0], jumps.ways)) @ jumps.shares
        fading = np.abs(1.0 - s[:, 0] * held[:, 0] - ways) * np.exp(decay * wait)
        above = np.flatnonzero(fading > BELOW * (1.0 - lasting))
        last = int(above[-1]) if above.size else 0
        if last * step < 0.7 * end or end >= most:
            kept = slice(0, last + ROWS)
            values = held * np.exp(-s * wait) - np.expm1(-s * wait) / s
            return s[kept], values[kept]
        end = min(2.0 * end, most)


def _rational_roots(s: Complex, values: Complex, step: float) -> Complex:
    """Roots of the rational function that approximates D on a window of the grid."""
    from scipy.interpolate import AAA

    middle = s.mean()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # Newton's method checks the roots
        fit = AAA((s.ravel() - middle) / step, values.ravel(), rtol=FOLLOWED)
        found = middle + step * np.asarray(fit.roots())
    edge = 2.0 * step
    found = found[(found.real > s[0, 0].real - edge) & (found.real < edge)]
    return found[(found.imag > s[0, 0].imag - edge) & (found.imag < s[-1, 0].imag + edge)]


def _polished(transform: Transform, wait: float, s: Complex, step: float, decay: float) -> Complex:
    """Newton's method from numbers s: the roots with Im s > 0 that it finds near to them, once each."""
    start, s = s, s.astype(complex)
    s = np.where(s == 0.0, 1e-6 * step, s)
    open_ = np.arange(s.size)
    for _ in range(STEPS):
        if not open_.size:
            break
        value, slope = conserved(transform, wait, s[open_])
        with np.errstate(invalid="ignore"):
            move = value / slope
        move[~np.isfinite(move)] = 0.0  # left of where D is a number; such s are no roots below
        move *= np.minimum(step / np.maximum(np.abs(move), 1e-300), 1.0)
        s[open_] -= move
        s.real = np.maximum(s.real, -1.05 * decay)
        near = np.abs(s[open_] - start[open_]) < 3.0 * step
        open_ = open_[near & (np.abs(move) > 1e-13 * np.abs(s[open_]))]
    value, slope = conserved(transform, wait, s)
    s = s[(np.abs(value) < ONE * np.abs(s * slope)) & (s.imag > 0.0)]
    s = s[np.lexsort([s.real, s.imag])]
    apart = np.abs(s[:, None] - s) > ONE * np.abs(s)
    first = np.array([apart[i, :i].all() for i in range(s.size)], dtype=bool)
    s = s[first]
    return s[np.argsort(-s.real, kind="stable")]
