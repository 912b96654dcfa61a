"""What is left of contacts with growing grains, against their quantiles one by one."""

from itertools import pairwise

import numpy as np
import pytest

from master.lives.grains import GrainLife
from master.lives.warm_grains import WarmGrainLife
from master.motion.motion import Motion
from origins import Contacts, Thermal, gaussian_start, growing_grains
from origins.start import SingleStart

GRAINS = growing_grains(1.0, 1.0, age=4.0)
PINNING = GRAINS.growth.first_pinning_time
PINNED = SingleStart(0.0)
# out and back, a hold, and further than before
TURNS = Motion(np.array([0.0, 1.0, 2.5, 4.0, 5.0]), np.array([0.0, 0.7, -0.2, -0.2, 1.8]))


def one_by_one(motion, start, age, since, until, count=1001):
    """Share of quantiles whose thresholds exceed |x| all along a fine grid of times."""
    rank = (np.arange(count) + 0.5) / count
    inner = motion.times[(motion.times > since) & (motion.times < until)]
    t = np.unique(np.concatenate([np.linspace(since, until, 201)[1:], inner]))
    x = start + motion.at(t) - motion.at(np.array([since]))
    held = np.ones(count, dtype=bool)
    for now, stretch in zip(t, x, strict=True):
        held &= GRAINS.quantile(rank, age + now - since) >= abs(stretch)
    before = float(GRAINS.growth.thresholds(age).sf(abs(start))) if start else 1.0
    return float(held.mean()) / before


def history(motion, t, s):
    return motion.history(np.atleast_2d(np.asarray(t, dtype=float)), np.atleast_2d(s))


@pytest.mark.parametrize("start", [0.0, 0.3, -0.25])
def test_start_on_turning_path_is_that_of_its_quantiles(start):
    contacts = Contacts(GRAINS, start)
    life = GrainLife(contacts, TURNS.times[-1])
    for t in (0.8, 2.0, 3.3, 4.6, 5.0):
        share, force = life.left(contacts.start, history(TURNS, t, 0.0))[:, 0, 0]
        assert share == pytest.approx(one_by_one(TURNS, start, 4.0, 0.0, t), abs=1.5e-3)
        assert force == share * (start + TURNS.at(np.array([t]))[0])


@pytest.mark.parametrize("born", [0.3, 1.4, 3.0])
def test_births_on_turning_path_are_those_of_their_quantiles(born):
    contacts = Contacts(GRAINS)
    life = GrainLife(contacts, TURNS.times[-1])
    for t in (3.3, 4.6, 5.0):
        share = life.left(PINNED, history(TURNS, t, born))[0, 0, 0]
        assert share == pytest.approx(one_by_one(TURNS, 0.0, PINNING, born, t), abs=1.5e-3)


@pytest.mark.parametrize("speed", [0.3, 1.0, -2.0])
def test_births_at_one_speed_follow_the_law_of_sliding_grains(speed):
    motion = Motion(np.array([0.0, 4.0]), np.array([0.0, 4.0 * speed]))
    life = GrainLife(Contacts(GRAINS), 4.0)
    lags = np.concatenate([[0.0, 1e-12, 1e-6], np.linspace(0.01, 4.0, 50)])[None]
    left = life.left(PINNED, history(motion, 4.0, 4.0 - lags))
    exact = np.exp(-GRAINS.hazard(abs(speed) * lags, GRAINS.growth.first_pinning_time + lags))
    # ages this near to that of pinning are rounded
    at_once = np.exp(-GRAINS.lost_hazard(abs(speed)))
    np.testing.assert_allclose(left[0, 0, :3], at_once, atol=1e-5)
    np.testing.assert_allclose(left[0, :, 3:], exact[:, 3:], atol=1e-13)
    np.testing.assert_allclose(left[1], left[0] * speed * lags, atol=1e-13)


@pytest.mark.parametrize("start", [gaussian_start(0.1, 0.05), gaussian_start(-0.05, 0.3)])
def test_spread_start_is_the_mean_over_its_stretches(start):
    """Against a plain sum over many stretches, at many moments."""
    contacts = Contacts(GRAINS, start)
    life = GrainLife(contacts, TURNS.times[-1])
    x = np.linspace(*start.span, 4001)
    weight = start.pdf(x) * (GRAINS.at_start.sf(np.abs(x)) > 0.0)
    weight, x = weight[weight > 0.0] / weight.sum(), x[weight > 0.0]
    for t in (0.8, 2.0, 4.6):
        inner = TURNS.times[TURNS.times < t]
        times = np.unique(np.concatenate([np.linspace(0.0, t, 40), inner]))
        hazard = GRAINS.hazard(np.abs(x[:, None] + TURNS.at(times)), 4.0 + times)
        held = weight * np.exp(hazard[:, 0] - hazard.max(axis=1))
        exact = held.sum(), held @ (x + TURNS.at(np.array([t])))
        found = life.left(contacts.start, history(TURNS, t, 0.0))[:, 0, 0]
        np.testing.assert_allclose(found, exact, atol=2e-6)


def warm_by_sums(contacts, motion, start, since, born, until):
    """Share by a plain sum over quantiles and midpoints of times, dense where rates are large."""
    t = np.unique(np.append(motion.times, [born, until]))
    t = t[(t >= born) & (t <= until)]
    graded = 0.5 - 0.5 * np.cos(np.pi * np.linspace(0.0, 1.0, 241))
    t = np.unique(np.concatenate([a + (b - a) * graded for a, b in pairwise(t)]))
    middle = 0.5 * (t[1:] + t[:-1])
    x = start + motion.at(t) - motion.at(np.array([born]))
    hazards = GRAINS.hazard(np.abs(x[1:]), PINNING + since + t[1:] - born)
    before = float(GRAINS.hazard(abs(start), PINNING + since)) if since else 0.0
    worst = max(hazards.max(), before)
    root = np.sqrt(20.0) * (np.arange(400) + 0.5) / 400.0
    hazard = worst + root**2
    age = PINNING + since + middle - born
    limit = GRAINS.quantile(-np.expm1(-hazard[:, None]), age)
    stretch = np.minimum(np.abs(0.5 * (x[1:] + x[:-1])), limit)
    spent = contacts.thermal.plain_rate(stretch, limit) @ np.diff(t)
    weight = 2.0 * root * np.sqrt(20.0) / 400.0
    return float((weight * np.exp(before - hazard - spent)).sum())


@pytest.mark.parametrize("law", ["soft", "stiff"])
def test_warm_grains_on_turning_path_by_sums(law):
    contacts = Contacts(GRAINS, 0.3, thermal=Thermal(law, 0.1, 2.0))
    life = WarmGrainLife(contacts, TURNS.times[-1])
    for t in (0.8, 3.3, 4.6):
        share, force = life.left(contacts.start, history(TURNS, t, 0.0))[:, 0, 0]
        exact = warm_by_sums(contacts, TURNS, 0.3, 4.0 - PINNING, 0.0, t)
        assert share == pytest.approx(exact, abs=1e-4)
        assert force == share * (0.3 + TURNS.at(np.array([t]))[0])
        share = life.left(PINNED, history(TURNS, t, 0.5))[0, 0, 0]
        assert share == pytest.approx(warm_by_sums(contacts, TURNS, 0.0, 0.0, 0.5, t), abs=1e-4)
    assert life.error < 1e-7


def test_warm_start_with_a_width_is_the_mean_over_its_stretches():
    start, thermal = gaussian_start(0.1, 0.05), Thermal("stiff", 0.05, 3.0)
    contacts = Contacts(GRAINS, start, thermal=thermal)
    looked = history(TURNS, 0.8, 0.0)
    found = WarmGrainLife(contacts, 5.0).left(contacts.start, looked)[:, :, 0]
    x, w = np.polynomial.legendre.leggauss(12)
    stretch, weight = 0.1 + 0.2 * x, 0.2 * w * start.pdf(0.1 + 0.2 * x)
    parts = []
    for y in stretch:
        own = Contacts(GRAINS, float(y), thermal=thermal)
        parts.append(WarmGrainLife(own, 5.0).left(own.start, looked)[:, :, 0])
    np.testing.assert_allclose(found, np.tensordot(weight / weight.sum(), parts, 1), atol=1e-4)


def test_error_of_warm_grains_is_told_where_it_is_cold():
    """Fewer and fewer moments of a leg count: finer sums are taken, or the error is told."""
    motion = Motion(np.array([0.0, 2.0]), np.array([0.0, 2.0]))
    contacts = Contacts(GRAINS, thermal=Thermal("soft", 1e-4, 1e4))
    life = WarmGrainLife(contacts, 2.0)
    lag = np.linspace(0.1, 1.9, 9)[None]
    found = life.left(PINNED, history(motion, 2.0, 2.0 - lag))[0, 0]
    exact = [warm_by_sums(contacts, motion, 0.0, 0.0, 0.0, age) for age in lag[0, ::4]]
    assert np.abs(found[::4] - exact).max() < 2e-3 and life.error < 1e-6
