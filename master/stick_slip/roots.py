"""Roots: at which rates and frequencies contacts forget that they started together.

Number conservation (docs/equations.md) reads, with Laplace transforms and the way d of the wait,

    b^(s) D(s) = 1/s - G_0^(s),      D(s) = E^(s) e^(-sd) + (1 - e^(-sd))/s,

so that F - F_k is a sum of e^(sX) over the roots of D. All lie left of the imaginary axis, none on
the real one. On each window of a grid a rational function follows D (scipy's AAA); its roots are
where Newton's method begins.
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

# Knowns, over the mean way from birth to birth: the first that is searched to, and where nothing is
# left after one such way.
FIRST, DEEPEST = 0.5, 40.0
# Of the rate of E's own tail, or of exact values: roots nearer to it are not looked for.
NEAR = 0.9
# |p^| below which no root is near, and frequencies that are looked at: over the length on which E
# falls, and at most over the mean way from birth to birth.
BELOW, HIGH, HIGHEST = 0.8, 8.0, 2000.0
# Numbers of nodes times frequencies that are looked at, at most.
MOST_WORK = 1e8
# Distance of the grid's frequencies, over the inverse of the mean way where slow decays count; of
# how many of them a window is, which shares some with the next; and rates of the grid, at most.
SIDE, ROWS, SHARED, COLUMNS = 0.8, 32, 8, 8
# What a rational function may miss of D in a window, relatively.
FOLLOWED = 1e-11
# Steps of Newton's method, and distance of roots over |s| below which they are one.
STEPS, ONE = 40, 1e-7


class Known(NamedTuple):
    """A rate (per length) or a length, and its error."""

    value: float
    error: float


class Roots(NamedTuple):
    """Roots of D with Im s > 0 (per length), slowest first: all right of Re s = -searched.

    roots : array of shape (n,)
    searched : float
    """

    roots: Complex
    searched: float


def conserved(transform: Transform, wait: float, s: Complex) -> tuple[Complex, Complex]:
    """D and D' at s of shape (n,), none 0; `wait` is d, a length."""
    values = transform(s)
    waited, out = np.exp(-s * wait), -np.expm1(-s * wait) / s
    slope = waited * (values.slope - wait * values.held) + (wait * waited - out) / s
    return values.held * waited + out, slope


def root_errors(transform: Transform, wait: float, s: Complex) -> Array:
    """Errors of roots of D: its residual and its own error, over |D'|."""
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
    """Where contacts reach exact thresholds together, and how many break there."""
    ways = travel.atoms[(travel.atoms > 0.0) & (travel.atoms <= travel.longest)]
    if not ways.size:
        return Jumps(ways, ways)
    # just before and after an exact threshold
    sides = 1.0 - 1e-11, 1.0 + 1e-11
    before, after = (travel.left(ways[:, None] * side)[0, :, 0] for side in sides)
    shares = np.maximum(before - after, 0.0)
    return Jumps(ways[shares > 0.0], shares[shares > 0.0])


def crowding_rate(travel: Travel, wait: float) -> float:
    """Rate (per length) at which exact values alone let infinitely many roots crowd, ever faster
    waves; inf without any, 0 where all break at exact values."""
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
    """At which log S falls far out; inf above, 0 below every exponential.

    Heat leaves it: the further a threshold lies beyond, the less a contact breaks before it.
    """
    law = contacts.thresholds
    if np.isfinite(law.support()[1]):
        return Known(np.inf, 0.0)
    # survival is looked at on the way out: far quantiles are beyond many a distribution
    x = contacts.mean_threshold * 2.0 ** np.arange(0.0, 400.0, 0.25)
    with np.errstate(over="ignore"):
        last = x[np.flatnonzero(law.logsf(x) > np.log(NONE))[-1]]
    ends = last * np.array([0.125, 0.25, 0.5, 1.0])
    # log S = a - rate x + power log x: the slopes over doublings of the way halve their distance
    slopes = -np.diff(law.logsf(ends)) / np.diff(ends)
    change = np.diff(slopes)
    rounded = 1e-9 * slopes[-1]
    level = abs(slopes[-1] - slopes[0]) < 0.25 * slopes[-1]
    if level and abs(change[1]) < max(0.6 * abs(change[0]), rounded):
        return Known(slopes[-1] + change[1], abs(2.0 * change[1] - change[0]) + rounded)
    return Known(np.inf if slopes[-1] > slopes[0] else 0.0, 0.0)


def leading_roots(transform: Transform, wait: float, count: int, limit: float) -> Roots:
    """At least `count` roots, or all right of Re s = -limit; fewer where D is not known to there.

    Frequencies are looked at up to some 2,000 over the mean way from birth to birth.
    """
    whole = transform.travel.length + wait
    deepest = min(limit, DEEPEST / whole)
    # error of D over what is left of 1, at which D is no longer known
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
    # the mean way at a break, weighted by e^(decay x)
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

    Exact values do not fade with the frequency, but stay below 1 right of the rate at which their
    roots crowd.
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
    """Roots of the rational function that follows D on a window of the grid."""
    from scipy.interpolate import AAA

    middle = s.mean()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # Newton's method, from its roots, tells how good it is
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
    with np.errstate(invalid="ignore"):
        s = s[(np.abs(value / slope) < ONE * np.abs(s)) & (s.imag > 0.0)]
    s = s[np.lexsort([s.real, s.imag])]
    apart = np.abs(s[:, None] - s) > ONE * np.abs(s)
    first = np.array([apart[i, :i].all() for i in range(s.size)], dtype=bool)
    s = s[first]
    return s[np.argsort(-s.real, kind="stable")]
