"""Contacts that strengthen with their age, in the ensemble: held to quadratures and to cohorts in even steps."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import slow
from solving import gauss

import eq_model
import origins
from eq_model.whole_drive import whole_drive
from master.rate_state.speeds import slope_at
from origins import Contacts, Delay, Drive, InputError, Thermal, strengthening
from toolkit.stability.cohorts import by_cohorts

PC = origins.gaussian(mean=1.0, std=0.2)
TIME = 2.0  # τ_0


def growth(beta, age):
    """g."""
    return 1.0 + beta * np.log1p(age / TIME)


def kinetic(beta, velocity, thermal=None):
    """F_k = ∫xE/∫E, E(x) = S(x/g(x/v)); with heat E = ∫P_c(ξ) exp[-(1/v)∫h(y; ξ g(y/v))dy]dξ, x < ξ g(x/v)."""
    largest = 2.7 * growth(beta, 9.0 / velocity)
    x, weights = gauss(np.linspace(0.0, largest, 41 if thermal is None else 201), 8)
    factor = growth(beta, x / velocity)
    if thermal is None:
        held = PC.sf(x / factor)
    else:
        fresh, shares = gauss(np.linspace(1e-3, 2.7, 7), 40)
        threshold = fresh[:, None] * factor
        rate = thermal.rates.rate(np.minimum(x, threshold), threshold, 1.0)
        # of the piece up to each node half of its weight counts
        passed = np.cumsum(rate * weights, axis=1) - 0.5 * rate * weights
        left = np.where(x < threshold, np.exp(-passed / velocity), 0.0)
        held = (shares * PC.pdf(fresh)) @ left
    return float(weights @ (x * held) / (weights @ held))


UNAGED = PC.moment(2) / (2.0 * PC.mean())  # F_k of thresholds that do not grow
EYRING = Thermal("eyring", width=0.03, attempt_frequency=1.0)
SOFT = Thermal("soft", 0.05, attempt_frequency=1.0)
BOTH = Contacts(strengthening(PC, beta=0.03, time=TIME), thermal=EYRING)


def slope(beta, velocity, thermal=None):
    """(dF_k/d ln v), in units of F_k without growth and heat."""
    up, down = (kinetic(beta, velocity * factor, thermal) for factor in (1.1, 1.0 / 1.1))
    return (up - down) / (2.0 * np.log(1.1)) / UNAGED


@pytest.mark.parametrize(("thermal", "slope"), [(SOFT, -0.0109), (EYRING, 0.0190)])
@pytest.mark.slow  # quick: Eyring's slope in test_strengthening_master.py, soft heat in test_agreement.py
def test_the_slope_of_heat_and_growth_together(thermal, slope):
    """Over two decades of speed, in units of F_k(∞) for each factor e: by Eyring's heat with α = β = 0.03, and by that
    of soft contacts, which takes two thirds of what growth alone does. Blocks of three mean thresholds tell the error
    of a mean along the path."""
    contacts = Contacts(strengthening(PC, beta=0.03, time=TIME), thermal=thermal)
    means, scatter, ends = list[float](), list[float](), (1e-6, 1e-4)
    for velocity in ends:
        given = {"velocity": velocity, "n_contacts": 6000, "n_replicas": 4, "seed": 2}
        run = eq_model.simulate(contacts, np.linspace(10.0, 40.0, 61), **given)
        blocks = run.force[1:].reshape(10, 6).mean(axis=1)
        means.append(float(blocks.mean()))
        scatter.append(float(blocks.std(ddof=1)) / np.sqrt(10.0))
    decades = np.log(ends[1] / ends[0]) * UNAGED
    exact = (kinetic(0.03, ends[1], thermal) - kinetic(0.03, ends[0], thermal)) / decades
    error = np.hypot(*scatter) / decades
    assert exact == pytest.approx(slope, abs=1e-4) and error < 3e-4
    assert abs((means[1] - means[0]) / decades - exact) < 4.0 * error


@pytest.mark.slow
def test_a_minus_b_of_both_is_that_of_a_quadrature():
    """The slope that `rate_state` tells, of contacts with heat whose thresholds strengthen, and its error."""
    found = slope_at(BOTH, 1e-4)
    assert found.error < 1e-4
    assert found.value == pytest.approx(slope(0.03, 1e-4, EYRING) * UNAGED, abs=found.error + 2e-5)


def standard_errors(found, exact):
    """The largest difference of the force from what it should be, in standard errors."""
    return float((np.abs(found.force - exact) / found.force_error).max())


SLIDING = np.linspace(30.0, 31.0, 3)


@pytest.mark.parametrize(
    ("beta", "velocity", "thermal", "number"),
    [
        (0.03, 1e-4, None, 60_000),
        (0.5, 0.01, None, 60_000),
        (0.03, 1e-4, SOFT, 30_000),
        slow(0.03, 1e-4, EYRING, 12_000),
    ],
)
def test_steady_sliding(beta, velocity, thermal, number):
    """F_k is that of the quadrature; one without growth, or at a tenth of the speed, is told apart."""
    contacts = Contacts(strengthening(PC, beta, TIME), thermal=thermal)
    found = eq_model.simulate(contacts, SLIDING, velocity=velocity, n_contacts=number, seed=4)
    assert standard_errors(found, kinetic(beta, velocity, thermal)) < 4.0
    assert standard_errors(found, kinetic(0.0, velocity, thermal)) > 10.0
    assert standard_errors(found, kinetic(beta, 0.1 * velocity, thermal)) > 5.0


PLACES = np.array([0.9, 1.4, 0.2, 0.2, -1.1, -1.1, 0.6, 2.5])
TIMES = np.array([9.0, 9.5, 21.5, 400.0, 413.0, 413.4, 430.4, 630.0])


@pytest.mark.parametrize(
    ("age", "start", "delay"), [(30.0, 0.2, 0.0), *(slow(0.0, 0.0, delay) for delay in (0.0, 5.0))]
)
def test_a_path_that_turns_rests_and_changes_its_speed(age, start, delay):
    """The ensemble agrees with cohorts in even steps, good to 2e-4; those that do not age in rests do not."""
    beta, begin = 0.3, origins.gaussian_start(0.1, start)
    contacts = Contacts(strengthening(PC, beta, TIME, age=age), start=begin, delay=Delay(delay))
    found = eq_model.simulate(contacts, PLACES, time=TIMES, n_contacts=100_000, seed=7)

    def away(beta, times):
        clock = np.unique(np.concatenate([[0.0], times, np.arange(0.0, times[-1], 5.0)]))
        path = np.interp(clock, np.append(0.0, times), np.append(0.0, PLACES))
        plain = by_cohorts(
            contacts.replace(thresholds=strengthening(PC, beta, TIME, age=age)), path, clock
        )
        exact = plain.values[np.searchsorted(clock, times)] * contacts.mean_threshold
        return np.abs(found.force - exact) / found.force_error

    assert away(beta, TIMES).max() < 4.0
    no_rest = TIMES - np.where(TIMES > 100.0, 378.0, 0.0)
    assert away(beta, no_rest).max() > 10.0 and away(0.9 * beta, TIMES).max() > 8.0


def test_thresholds_counted_at_a_point_have_grown():
    """At rest nothing breaks, and every threshold is g times what it was."""
    contacts = Contacts(strengthening(PC, 0.1, TIME, age=3.0))
    found = eq_model.simulate(
        contacts, [0.0, 0.0], time=[1.0, 1e5], n_contacts=50_000, seed=3, histograms=[0, 1]
    )
    assert found.breaks == 0
    for histogram, age in zip(found.histograms, (4.0, 3.0 + 1e5), strict=True):
        middles = 0.5 * (histogram.threshold_edges[1:] + histogram.threshold_edges[:-1])
        shares = histogram.thresholds * np.diff(histogram.threshold_edges)
        mean = growth(0.1, age) * PC.mean()
        assert middles @ shares == pytest.approx(mean, abs=4.0 * 0.2 * mean / np.sqrt(50_000))


def test_exact_thresholds_grow_all_alike():
    """Contacts of one threshold break together where x = x_s0 g(x/v)."""
    contacts, velocity = Contacts(strengthening(origins.identical(1.0), 0.05, TIME)), 0.01
    at = 1.0
    for _ in range(60):
        at = 1.0 + 0.05 * np.log1p(at / velocity / TIME)
    path = np.array([at - 1e-9, at + 1e-9, 2.0 * at - 1e-9, 2.0 * at + 1e-9])
    found = eq_model.simulate(contacts, path, velocity=velocity, n_contacts=1000, seed=1)
    np.testing.assert_allclose(found.force, [at, 0.0, at, 0.0], atol=2e-9)


def test_a_spring_refuses_other_growth():
    """Grains grow by another law."""
    contacts = Contacts(strengthening(PC, 0.03, TIME))
    grains = Contacts(origins.growing_grains(1.0, 1.0, age=4.0))
    with pytest.raises(InputError, match=r"contacts\.grains: .*does not take it yet"):
        eq_model.simulate(grains, [1.0], spring=0.5)
    # a path as long as 1e11 breaks of contacts that do not grow would take half a day
    with pytest.raises(InputError, match=r"slip = 'instant': takes about .*, more than 5e\+09"):
        eq_model.simulate(contacts, [1e5], spring=0.5, slip="instant", n_contacts=1_000_000)


def test_a_path_of_many_points_has_the_legs_of_its_corners():
    """A late rest leaves rounding in the times of points; legs of one speed stay one, on which contacts are quick."""
    times = np.concatenate([np.linspace(0.0, 8.0, 161), np.linspace(1008.0, 1013.0, 134)])
    path = np.concatenate([np.linspace(0.0, 8.0, 161), np.linspace(8.0, 13.0, 134)])
    assert whole_drive(Drive(path, time=times), 1.0, 10.0, False).paces.size == 3
    slower = times + 1e-11 * np.maximum(np.arange(times.size) - 220, 0)
    assert whole_drive(Drive(path, time=slower), 1.0, 10.0, False).paces.size == 4
