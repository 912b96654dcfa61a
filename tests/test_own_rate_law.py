"""A rate law of the test's own, h = ω exp[-(1 - |x|/x_s)/α], through all that master answers.

Beside it sums by definition: over thresholds by Gauss nodes, over births by midpoints of time. No
solver knows the law; it stands in tests/rate_laws.py alone.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from rate_laws import Tilted

import master
import origins

LAW = origins.gaussian(1.0, 0.2)
STRONGEST = 2.8  # thresholds: beyond is a share of 1e-18
NODES, WEIGHTS = np.polynomial.legendre.leggauss(60)
RATES = Tilted(alpha=0.1, omega=1.0)


def solved(path, tolerance, **drive):
    """What master.solve answers for contacts that break by the law."""
    return master.solve(origins.Contacts(LAW, thermal=RATES), path, tolerance, **drive)


def thresholds_above(x):
    """Thresholds above each x, and their weights by P_c; the nodes are the last axis."""
    half = 0.5 * (STRONGEST - np.minimum(x, STRONGEST))[..., None]
    above = STRONGEST - half + half * NODES
    return above, half * WEIGHTS * LAW.pdf(above)


def passed(begin, end, threshold):
    """The integral of h over |x| from begin to end, of one sign."""
    near, far = np.minimum(np.abs(begin), np.abs(end)), np.maximum(np.abs(begin), np.abs(end))
    length = RATES.alpha * threshold
    rise = np.exp((np.minimum(far, threshold) - threshold) / length)
    return (
        RATES.omega * length * (rise - np.exp((np.minimum(near, threshold) - threshold) / length))
    )


def spent(begin, end, duration, threshold):
    """The integral of h over the time of a straight move; all of one shape."""
    way = np.abs(end - begin)
    across = passed(begin, 0.0, threshold) + passed(0.0, end, threshold)
    integral = np.where(begin * end < 0.0, across, passed(begin, end, threshold))
    rest = RATES.omega * np.exp(-(1.0 - np.abs(begin) / threshold) / RATES.alpha)
    moved = way > 1e-12
    return duration * np.where(moved, integral / np.where(moved, way, 1.0), rest)


def left(knots, path, born, now):
    """Share that holds now of relaxed contacts born at these times, array of the shape of `born`."""
    place = np.interp(born, knots, path)
    most = np.zeros(born.size)
    moments = [knot for knot in knots if knot < now] + [now]
    for moment in moments:
        x = np.interp(np.maximum(moment, born), knots, path) - place
        most = np.maximum(most, np.abs(x))
    threshold, weight = thresholds_above(most)
    amount = np.zeros(threshold.shape)
    for begin, end in pairwise([knots[0], *moments]):
        first, last = np.maximum(begin, born), np.maximum(end, born)
        x = [(np.interp(t, knots, path) - place)[:, None] for t in (first, last)]
        amount += spent(x[0] + 0.0 * threshold, x[1], (last - first)[:, None], threshold)
    return (weight * np.exp(-amount)).sum(axis=-1)


def by_midpoints(knots, path, cells):
    """F at the path's end from relaxed contacts: number conservation by midpoints of time."""
    times = np.linspace(0.0, knots[-1], cells + 1)
    born = np.append(0.0, 0.5 * (times[1:] + times[:-1]))  # the start is as a birth at t = 0
    broken = np.append(1.0, np.zeros(cells))
    for k, now in enumerate(times[1:], 1):
        held = left(knots, path, born[: k + 1], now)
        broken[k] = (1.0 - broken[:k] @ held[:-1]) / held[-1]
    return float(broken @ (held * (path[-1] - np.interp(born, knots, path))))


DRIVES = {
    "forward": ([0.0, 1.5], [0.0, 1.5]),
    "hold": ([0.0, 1.0, 3.0, 4.0], [0.0, 0.8, 0.8, 1.4]),
    "turns": ([0.0, 1.0, 3.0, 4.0], [0.0, 1.0, -0.6, 0.4]),
}


@pytest.mark.parametrize("name", ["forward", "hold", pytest.param("turns", marks=pytest.mark.slow)])
def test_force_is_that_of_sums_by_definition(name):
    knots, path = (np.array(part) for part in DRIVES[name])
    coarse, fine = (by_midpoints(knots, path, cells) for cells in (120, 240))
    exact, off = fine + (fine - coarse) / 3.0, abs(fine - coarse)
    found = solved(path, 1e-7, time=knots)
    assert found.success and off < 1e-4
    assert abs(found.force[-1] - exact) <= found.force_error + 0.1 * off + 1e-8


def kinetic_force(rates, velocity):
    """F_k by its definition: the integral of x E over that of E."""
    cuts = np.linspace(0.0, STRONGEST, 41)
    x = (cuts[:-1, None] + (cuts[1] - cuts[0]) * 0.5 * (NODES + 1.0)).ravel()
    weight = np.tile(0.5 * (cuts[1] - cuts[0]) * WEIGHTS, cuts.size - 1)
    above, share = thresholds_above(x)
    length = rates.alpha * above
    amount = (
        rates.omega / velocity * length * np.exp(-above / length) * np.expm1(x[:, None] / length)
    )
    held = weight * (share * np.exp(-amount)).sum(axis=1)
    return float(held @ x / held.sum())


@pytest.mark.parametrize("velocity", [1e-3, 0.1, 10.0])
def test_the_kinetic_force_is_that_of_sums_by_definition(velocity):
    found = master.steady_state(origins.Contacts(LAW, thermal=RATES), velocity=velocity)
    exact = kinetic_force(RATES, velocity)
    assert abs(found.force - exact) <= found.force_error + 1e-9 and found.force_error < 1e-7


def test_the_kinetic_force_falls_by_alpha_with_each_e_fold_of_a_low_speed():
    """dF_k/d ln v = α F_k(∞) within 1 % for v/(ω α <x_s>) from 1e-4 to 1e-2."""
    rates = Tilted(alpha=0.03, omega=2.0)
    speeds = np.geomspace(1e-4, 1e-2, 9) * rates.omega * rates.alpha * LAW.mean()
    step = 0.05
    contacts = origins.Contacts(LAW, thermal=rates)
    asked = np.concatenate([speeds * np.exp(-step), speeds * np.exp(step)])
    low, high = master.kinetic_curve(contacts, asked).force.reshape(2, -1)
    fastest = LAW.moment(2) / (2.0 * LAW.mean())  # F_k(∞): contacts break at their thresholds
    np.testing.assert_allclose((high - low) / (2.0 * step), rates.alpha * fastest, rtol=0.01)
