"""Roots: the rates and frequencies with which F(X) decays to the kinetic force.

F - F_k is a sum of e^(sX) over the roots of D (transform.py). All lie left of the imaginary axis,
none on the real one. By the argument principle D turns once around 0 along the sides of a cell of a
grid for each root inside: Newton's method starts from these cells, and has to find as many roots.
"""

from __future__ import annotations

import numpy as np

from master.steady.travel import Travel
from master.stick_slip.transform import NONE, Complex, Transform
from origins import Contacts

# Decay rates, per mean way from birth to birth: the first to which roots are searched, and the last,
# at which a wave has vanished after one such way.
FIRST, DEEPEST = 0.5, 40.0
# Roots are searched up to this share of the decay rate of E's tail, or of that of exact values.
NEAR = 0.9
# No root is near where |p^| is smaller than BELOW. Frequencies are searched first up to HIGH per
# length on which E falls, at most up to HIGHEST per mean way from birth to birth.
BELOW, HIGH, HIGHEST = 0.8, 8.0, 2000.0
# Most frequencies of a grid times nodes of an integral.
MOST_WORK = 1e8
# Sides of the grid's cells, in units of the inverse mean way (weighted by e^(decay x)), and most cells
# of a row, which are wider where they are few.
SIDE, COLUMNS = 0.8, 16
# Most steps of Newton's method; distance over |s| below which two roots count as equal.
STEPS, EQUAL = 40, 1e-7
# Ratio of the longest to the mean life beyond which the few longest ones cannot be resolved.
BROAD = 1e4


def crowding_rate(travel: Travel, wait: float) -> float:
    """Decay rate (per length) near which infinitely many roots of ever higher frequency crowd, due to
    exact thresholds; inf without any, 0 where all contacts break at exact thresholds."""
    from scipy.optimize import brentq

    ways = travel.atoms[(travel.atoms > 0.0) & (travel.atoms <= travel.longest)]
    if not ways.size:
        return np.inf
    # the share that breaks at each is that just before less that just after it
    before, after = (travel.left(ways[:, None] * side)[0, :, 0] for side in (1 - 1e-11, 1 + 1e-11))
    ways, shares = ways[before > after] + wait, (before - after)[before > after]
    if not ways.size:
        return np.inf
    if shares.sum() > 1.0 - 1e-14:
        return 0.0
    most = -float(np.log(shares.max())) / float(ways.min())

    def held(rate: float) -> float:
        return float(np.logaddexp.reduce(rate * ways + np.log(shares)))

    return float(brentq(held, 0.0, most, xtol=1e-300, rtol=1e-14))


def tail_rate(contacts: Contacts) -> tuple[float, float]:
    """Rate at which log S of the thresholds falls in the tail, and its error (per length); inf if it
    falls faster than linearly, 0 if slower.

    Heat does not change it: the stronger a contact, the less likely it breaks before its threshold.
    """
    law = contacts.thresholds
    if np.isfinite(law.support()[1]):
        return np.inf, 0.0
    # the survival is sampled outwards, since many distributions cannot compute far quantiles
    x = contacts.mean_threshold * 2.0 ** np.arange(0.0, 400.0, 0.25)
    with np.errstate(over="ignore"):
        last = x[np.flatnonzero(law.logsf(x) > np.log(NONE))[-1]]
    ends = last * np.array([0.125, 0.25, 0.5, 1.0])
    # where log S = a - rate x + power log x, each doubling of x halves the slopes' distance to -rate
    slopes = -np.diff(law.logsf(ends)) / np.diff(ends)
    change, rounded = np.diff(slopes), 1e-9 * slopes[-1]
    level = abs(slopes[-1] - slopes[0]) < 0.25 * slopes[-1]
    if level and abs(change[1]) < max(0.6 * abs(change[0]), rounded):
        return slopes[-1] + change[1], abs(2.0 * change[1] - change[0]) + rounded
    return np.inf if slopes[-1] > slopes[0] else 0.0, 0.0


def decoherence_length(contacts: Contacts, travel: Travel, wait: float) -> tuple[float, float]:
    """X* of the slowest term e^(-X/X*), and its error; inf where nothing decays exponentially.

    It is inf for exact values alone (F is periodic or nearly so), and for a tail that falls slower
    than any exponential. Where a few contacts live more than 10,000 times as long as the mean, the
    error is inf. Where exact values have a share of the weight, roots slower than the rate at which
    infinitely many crowd may not exist, and X* is that of this rate.
    """
    rate, off = min(tail_rate(contacts), (crowding_rate(travel, wait), 0.0))
    if rate == 0.0:
        return np.inf, 0.0
    if travel.longest > BROAD * travel.length:
        # X* depends on the few contacts that live longest, which the table of E does not resolve
        return travel.longest, np.inf
    transform = Transform(travel, wait)
    roots, searched = leading_roots(transform, 1, NEAR * rate)
    if roots.size:
        decay = -float(roots[0].real)
        error = float(transform.root_errors(roots[:1])[0])
        # with a very long delay the decay may be smaller than its rounding error
        return (1.0 / decay, error / decay**2) if error < decay else (1.0 / error, np.inf)
    if searched > 0.95 * NEAR * rate:  # an undetected root may lie from there to the rate
        return 1.0 / rate, (off + rate - searched) / rate**2
    return 0.5 / searched, 0.5 / searched


def leading_roots(transform: Transform, count: int, limit: float) -> tuple[Complex, float]:
    """All roots of D with Im s > 0 right of some Re s = -searched, slowest first, and `searched` (per
    length): at least `count`, or as far as `limit`; fewer where D is too inaccurate there.

    Frequencies are searched up to some 2,000 per mean way from birth to birth.
    """
    whole, wait = transform.travel.length + transform.wait, transform.wait

    def blurred(decay: float) -> float:
        """The error of D over its terms."""
        off = float(transform(np.array([complex(-decay)])).held_off[0])
        return off * decay * np.exp(min(decay * wait, 700.0))

    deepest = min(limit, DEEPEST / whole)
    while not blurred(deepest) < 1e-3:
        deepest *= 0.9
    decay = min(FIRST / whole, deepest)
    while True:
        roots, searched = _roots_to(transform, decay)
        if roots.size >= count or decay >= deepest:
            return roots, searched
        decay = min(2.0 * decay, deepest)


def _roots_to(transform: Transform, decay: float) -> tuple[Complex, float]:
    """`leading_roots` right of Re s = -decay, or of where one was missed."""
    end = transform(np.array([complex(-decay)]))
    # the mean way from birth to break, weighted by e^(decay x)
    centre = float(((end.held - decay * end.slope) / (1.0 + decay * end.held)).real[0])
    step = SIDE / (centre + transform.wait)
    # roots nearer to the left side may count as outside, as the sides of cells are taken straight
    left = decay + min(0.4 * step, 0.05 * decay)
    s, values = _grid(transform, left, step)
    across = np.angle(values[:, 1:] / values[:, :-1])
    along = np.angle(values[1:] / values[:-1])
    turned = across[:-1] + along[:, 1:] - across[1:] - along[:, :-1]
    begins = (0.5 * (s[:-1, :-1] + s[1:, 1:]))[turned > np.pi]
    size = float(abs(s[1, 1] - s[0, 0]))
    ends, open_ = begins.copy(), np.arange(begins.size)
    for _ in range(STEPS):  # of Newton's method, none longer than a cell
        value, slope = transform.conserved(ends[open_])
        with np.errstate(invalid="ignore"):
            move = np.nan_to_num(value / slope, nan=size, posinf=size, neginf=size)
        move *= np.minimum(size / np.maximum(np.abs(move), 1e-300), 1.0)
        ends[open_] -= move
        near = np.abs(ends[open_] - begins[open_]) < 3.0 * size
        open_ = open_[near & (np.abs(move) > 1e-13 * np.abs(ends[open_]))]
    # each cell must have a root of its own
    value, slope = transform.conserved(ends)
    near = np.abs(ends - begins) < 2.0 * size
    near &= np.abs(value) < EQUAL * np.abs(ends * slope)
    same = np.abs(np.subtract.outer(ends, ends)) <= EQUAL * np.abs(ends)
    near &= ~np.tril(same & near, -1).any(axis=1)
    missed = begins[~near].real.max(initial=-np.inf) + size
    searched = max(-max(0.4 * step - left, float(missed)), 1e-3 * decay)
    roots = ends[near & (ends.real > -searched)]
    return roots[np.argsort(-roots.real, kind="stable")], searched


def _grid(transform: Transform, decay: float, step: float) -> tuple[Complex, Complex]:
    """Numbers s up to the frequency above which |p^| stays below 1 at the first Re s, and D there."""
    travel, wait = transform.travel, transform.wait
    real = np.linspace(-decay, step, int(min(np.ceil(decay / step), COLUMNS)) + 2)
    highest = float(np.sqrt(MOST_WORK * step / transform.nodes_per_frequency))
    highest = min(HIGHEST / (travel.length + wait), highest)
    end = min(max(HIGH / travel.grain, 30.0 * step), highest)
    while True:
        count = int(np.ceil(end / step)) + 2
        s = real + 1j * step * np.arange(count)[:, None]
        s[s == 0.0] = 1e-6 * step
        held = transform.grid(real, step, count)
        broken = np.abs(1.0 - s[:, 0] * held[:, 0]) * np.exp(decay * wait)
        last = int(np.flatnonzero(np.append(BELOW + 1.0, broken[1:]) > BELOW)[-1])
        if last * step < 0.7 * end or end >= highest:
            s, held = s[: last + 30], held[: last + 30]
            return s, held * np.exp(-s * wait) - np.expm1(-s * wait) / s
        end = min(2.0 * end, highest)
