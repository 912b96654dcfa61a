"""What is left of contacts that break by heat, against sums over time and thresholds."""

from itertools import pairwise

import numpy as np
import pytest
import scipy.stats
from heat_references import GAUSS, HEAT, LAWS, PATHS, WEIGHTS, left_by_definition, spent
from scipy.integrate import quad

from master.lives.heat.mean_rate import MeanRateLife
from master.lives.heat.thermal import ThermalLife
from master.motion.motion import Motion
from origins import (
    Contacts,
    StiffRates,
    Thermal,
    gaussian,
    gaussian_start,
    identical,
    mixture,
    rectangular,
)
from origins.start import SingleStart


def legs_of(path, born):
    """Stretches and times at the ends of the legs of a contact born at the beginning."""
    times, positions = (np.array(part) for part in PATHS[path])
    return born + positions - positions[0], times


def left_at_the_end(life, path, born=0.0):
    """Share and force, at the end of the path, of contacts born at its beginning."""
    motion = Motion(*(np.array(part) for part in PATHS[path]))
    start = SingleStart(born) if np.isscalar(born) else born
    history = motion.history(motion.times[-1:, None], motion.times[:1, None])
    return life.left(start, history)[:, 0, 0]


@pytest.mark.parametrize("path", PATHS)
@pytest.mark.parametrize("heat", HEAT)
@pytest.mark.parametrize("law", LAWS)
def test_share_and_force_are_those_of_the_definition(law, heat, path):
    """Births at 0 and, with linked stiffness, at 0.2."""
    thermal, rate = HEAT[heat]
    for born, stiffness in ((0.0, "independent"), (0.2, "linked")):
        life = ThermalLife(Contacts(LAWS[law], thermal=thermal, stiffness=stiffness))
        expected = left_by_definition(
            LAWS[law], rate, *legs_of(path, born), linked=stiffness == "linked"
        )
        found = left_at_the_end(life, path, born)
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-12)
        assert life.error < 4e-12


@pytest.mark.parametrize("law", ["soft", "stiff"])
@pytest.mark.parametrize("temperature", [1e-6, 1e-3, 1.0, 100.0])
@pytest.mark.parametrize("attempts", [1e-3, 1e6, 1e18])
def test_shares_stay_between_all_and_none_at_every_heat(law, temperature, attempts):
    """And fall with the time since birth; the error is measured and small."""
    motion = Motion(np.array([0.0, 1.0, 3.0, 4.0]), np.array([0.0, 0.5, 0.5, 1.4]))
    t = np.array([[0.9], [2.9], [3.9]])
    for name in LAWS:
        life = ThermalLife(Contacts(LAWS[name], thermal=Thermal(law, temperature, attempts)))
        for now in t:
            lags = np.minimum(np.append(0.0, np.geomspace(1e-14, 0.9, 30)), now)
            history = motion.history(now[:, None], (now - lags)[:, None])
            share = life.left(SingleStart(0.0), history)[0, :, 0]
            assert ((share >= 0.0) & (share <= 1.0)).all()
            assert share[0] == pytest.approx(1.0, abs=1e-14)
            assert (np.diff(share) < 1e-12).all()
        assert life.error < 1e-12


@pytest.mark.parametrize("closure", ["exact", "paper"])
def test_exact_thresholds_are_passed_by_rows(closure):
    """An atom at 0.5 breaks where the middle of the row has passed it, and not before."""
    law = mixture([identical(0.5), gaussian(2.0, 0.1)], [0.3, 0.7])
    contacts = Contacts(law, thermal=Thermal("stiff", 0.05, 0.5, closure=closure))
    life = ThermalLife(contacts) if closure == "exact" else MeanRateLife(contacts)
    motion = Motion(np.array([0.0, 1.0]), np.array([0.0, 1.0]))
    rows = np.array([[0.49, 0.495, 0.5], [0.5, 0.505, 0.51]])
    share = life.left(SingleStart(0.0), motion.history(rows, np.zeros((1, 1))))[0]
    assert share[0, 2] - share[1, 0] > 0.2
    assert life.bends[0] == 0.5 and life.atoms[0] == 0.5
    if closure == "exact":

        def rate(gap, threshold, stiffness):
            barrier = stiffness * threshold**2 * (gap / threshold) ** 1.5 / 0.1
            return 0.5 * (gap / threshold) ** 0.5 * np.exp(-barrier)

        x, times = np.array([0.0, 0.49]), np.array([0.0, 0.49])
        of_atom = np.exp(-spent(rate, x, times, np.array([0.01]), 1.0))[0]
        rest = left_by_definition(gaussian(2.0, 0.1), rate, x, times, linked=False)[0]
        assert share[0, 0] == pytest.approx(0.3 * of_atom + 0.7 * rest, abs=1e-13)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("path", ["forward", "turns"])
@pytest.mark.parametrize("closure", ["exact", "paper"])
def test_births_at_a_law_of_stretches_are_averaged(law, path, closure):
    """Against quad over the stretch at birth, of single births."""
    contacts = Contacts(LAWS[law], thermal=Thermal("soft", 0.1, closure=closure))
    life = ThermalLife(contacts) if closure == "exact" else MeanRateLife(contacts)
    born = gaussian_start(0.05, 0.04)
    share, force = left_at_the_end(life, path, born)
    x = legs_of(path, 0.0)[0]
    high, low = x.max(), x.min()
    kinks = [0.0, -x[-1], -high, -low, -0.5 * high, -0.5 * low, -0.5 * (high + low)]
    kinks += [way for mark in life.bends for way in (mark - high, -mark - low, mark, -mark)]
    first, last = 0.05 - 0.32, 0.05 + 0.32
    inside = [kink for kink in kinks if first < kink < last]
    for found, kind in ((share, 0), (force, 1)):
        expected = quad(
            lambda r, kind=kind: float(born.pdf(r)) * left_at_the_end(life, path, float(r))[kind],
            first,
            last,
            points=np.unique([*inside, 0.0, 0.05, 0.1]),
            epsabs=1e-10,
            epsrel=0.0,
            limit=60,
        )[0]
        assert found == pytest.approx(expected, abs=2e-10)
    assert life.error < 1e-10


@pytest.mark.parametrize("heat", ["soft", "cooler", "stiff", "cooler stiff"])
@pytest.mark.parametrize("law", LAWS)
def test_the_mean_rate_is_the_integral_of_rates_and_thresholds(law, heat):
    """S(m)/S(|r|) times the exponential of H, by quad over thresholds, over the time."""
    thermal, rate = HEAT[heat]
    paper = Thermal(thermal.law, thermal.temperature, thermal.attempt_frequency, closure="paper")
    life = MeanRateLife(Contacts(LAWS[law], thermal=paper))
    x, times = np.array([0.2, 0.9, 0.9, -0.1]), np.array([0.0, 0.7, 1.1, 3.1])

    def mean_rate(y):
        top = float(LAWS[law].isf(1e-17)) - y
        marks = [mark - y for mark in LAWS[law].breakpoints if 0.0 < mark - y < top]
        cuts = np.unique([0.0, top, *marks, *np.geomspace(1e-9, top, 60)])
        cuts = np.unique([*cuts, *np.linspace(0.0, top, 60)])
        roots = np.sqrt(cuts)
        root = (roots[:-1, None] + np.diff(roots)[:, None] * GAUSS).ravel()
        weight = (np.diff(roots)[:, None] * WEIGHTS).ravel() * 2.0 * root
        return float(weight @ (LAWS[law].pdf(y + root**2) * rate(root**2, y + root**2, 1.0)))

    marks = [*LAWS[law].breakpoints, 1e-3, 0.05, 0.1, 0.2, 0.5, 0.89]

    def grown(y):
        edges = np.unique([0.0, y, *(mark for mark in marks if mark < y)])
        parts = pairwise(edges)
        return sum(quad(mean_rate, *ends, epsabs=1e-10, epsrel=1e-10)[0] for ends in parts)

    amount = grown(0.9) - grown(0.2) + 0.4 * mean_rate(0.9) + 2.0 * (grown(0.9) + grown(0.1))
    motion = Motion(times, x)
    share, force = life.left(SingleStart(0.2), motion.history(times[-1:, None], np.zeros((1, 1))))
    expected = LAWS[law].sf(0.9) / LAWS[law].sf(0.2) * np.exp(-amount)
    assert share[0, 0] == pytest.approx(expected, abs=1e-9)
    assert force[0, 0] == pytest.approx(-0.1 * expected, abs=1e-9)
    assert life.error < 1e-10


class Smoothed(StiffRates):
    """Stiff contacts that deny that their rate vanishes at the threshold."""

    vanishes_at_threshold = False


@pytest.mark.parametrize("path", ["forward", "hold", "turns"])
@pytest.mark.parametrize("law", LAWS)
def test_a_root_that_the_law_denies_is_resolved_by_halving(path, law):
    motion = Motion(*(np.array(part) for part in PATHS[path]))
    born = np.linspace(0.0, 0.95 * motion.times[-1], 300)
    history = motion.history(motion.times[-1:, None], born[:, None])
    lives = [ThermalLife(Contacts(LAWS[law], thermal=of(0.1, 5.0))) for of in (Smoothed, StiffRates)]
    found, expected = (life.left(SingleStart(0.0), history)[0] for life in lives)
    assert lives[1].error < 1e-12
    assert np.abs(found - expected).max() < 1e-11


def test_the_measured_error_bounds_that_of_a_jump_not_told():
    """P_c jumps at a point of which the law says nothing."""
    told = mixture([rectangular(0.6, 0.9), gaussian(0.75, 0.2)], [0.2, 0.8])
    x = np.linspace(0.0, 0.7, 200)

    class Untold(type(told)):
        breakpoints = np.array([0.0])
        panels = None

    silent = Untold.__new__(Untold)
    silent.__dict__.update(told.__dict__)
    motion = Motion(np.array([0.0, 1.0]), np.array([0.0, 1.0]))
    history = motion.history(x[:, None], np.zeros((1, 1)))
    lives = [ThermalLife(Contacts(law, thermal=Thermal("soft", 0.05))) for law in (told, silent)]
    right, wrong = (life.left(SingleStart(0.0), history)[0] for life in lives)
    assert lives[1].error >= np.abs(right - wrong).max() - 1e-14


def test_a_bend_near_the_end_of_the_stretches_at_birth_is_seen():
    """Starts in an even slab, of which those just below 0.1 alone reach the first thresholds."""
    start, way = scipy.stats.uniform(-0.2, 0.3), 0.402
    contacts = Contacts(rectangular(0.5, 1.5), start, thermal=Thermal("soft", 0.05))
    motion = Motion(np.array([0.0, 1.0]), np.array([0.0, 1.0]))
    history = motion.history(np.full((1, 1), way), np.zeros((1, 1)))
    found = ThermalLife(contacts, 1e-8).left(contacts.start, history)[0, 0, 0]
    one = ThermalLife(contacts)
    edges = [-0.2, -0.1, 0.0, 0.098, 0.1]
    exact = 0.0
    for low, high in pairwise(edges):
        born = (low + (high - low) * GAUSS)[:, None]
        every = motion.history(np.full(born.shape, way), np.zeros(born.shape))
        exact += (high - low) / 0.3 * WEIGHTS @ one.left(born, every)[0, :, 0]
    assert abs(found - exact) < 1e-9
