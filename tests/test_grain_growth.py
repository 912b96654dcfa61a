"""Grains in time, and contacts whose threshold grows while they slide, against mpmath and brute force."""

import numpy as np
import pytest
from grain_references import psi
from references import mp
from scipy.optimize import brentq

import origins
from origins import InputError, grains
from origins.grains.lifshitz_slyozov import LifshitzSlyozov


def test_growth_in_time() -> None:
    growth = origins.GrainGrowth(alpha=0.8, B=1.7)
    first = growth.first_pinning_time
    assert growth.rho(first) == pytest.approx(2.0 / 3.0, rel=1e-15)
    times = first * np.array([0.1, 1.0, 1.01, 1.5, 27.0 / 8.0, 20.0, 1e6])
    np.testing.assert_allclose(growth.rho(times), 0.8 * times ** (1.0 / 3.0), rtol=1e-15)
    np.testing.assert_allclose(growth.number(times), first / times, rtol=1e-15)
    fraction = growth.pinned_fraction(times)
    assert fraction[:2].tolist() == [0.0, 0.0] and 0.0 < fraction[2] < 1e-100
    np.testing.assert_allclose(
        fraction[3:], LifshitzSlyozov().sf(1.0 / growth.rho(times[3:])), rtol=1e-12
    )
    np.testing.assert_allclose(growth.pinning_number(times), fraction * first / times, rtol=1e-15)
    # grains of the mean radius neither grow nor shrink: most pin when those are as thick as the film, at rho = 1
    around = 27.0 / 8.0 * first * (1.0 + np.array([-2e-3, -1e-3, 0.0, 1e-3, 2e-3]))
    numbers = growth.pinning_number(around)
    assert numbers.argmax() == 2 and numbers[1] == pytest.approx(numbers[3], rel=1e-8)
    assert growth.thresholds(20.0 * first).sf(0.9) == pytest.approx(
        grains(0.8 * (20.0 * first) ** (1 / 3), B=1.7).sf(0.9), rel=1e-13
    )
    assert growth.thresholds(20.0 * first, "paper").onset_power == 0.0
    with pytest.raises(InputError, match=r"^time = .*: no grain pins yet"):
        growth.thresholds(0.9 * first)


def test_growth_of_a_film() -> None:
    thin = origins.film_growth(
        2e-9, coarsening_rate=1e-27, shear_strength=1e8, force_coefficient=3e12
    )
    thick = origins.film_growth(
        6e-9, coarsening_rate=1e-27, shear_strength=1e8, force_coefficient=3e12
    )
    assert thin.first_pinning_time == pytest.approx((2e-9) ** 3 / 27e-27, rel=1e-14)
    assert thick.first_pinning_time == pytest.approx(27.0 * thin.first_pinning_time, rel=1e-14)
    # a grain of radius r breaks at tau pi (r² - d²/4) = c x²
    time = 5.0 * thin.first_pinning_time
    largest = 1.5 * (1e-27 * time) ** (1 / 3)
    force = 1e8 * np.pi * (largest**2 - 1e-18)
    assert thin.thresholds(time).support()[1] == pytest.approx(np.sqrt(force / 3e12), rel=1e-13)
    # k = G A^(1/2) and f_s = tau A: x = tau A^(1/2)/G
    by_modulus = origins.film_growth(2e-9, 1e-27, 1e8, shear_modulus=4e10).thresholds(time)
    assert by_modulus.support()[1] == pytest.approx(1e8 * np.sqrt(force / 1e8) / 4e10, rel=1e-13)


SLIDING = [(1.0, 0.0), (3.0, 0.0), (0.3, 0.7), (5.0, 1e-3), (1e-6, 0.0)]  # velocity, rest


def meeting_hazard(x: mp.mpf, growth: origins.GrainGrowth, velocity: float, rest: float) -> mp.mpf:
    """Straight from the definition, -log of the survival of P_c at the age of stretch x."""
    since = (mp.mpf(rest) + x / mp.mpf(velocity)) / mp.mpf(growth.first_pinning_time)
    largest = (1 + since) ** (mp.mpf(1) / 3)
    return psi(mp.sqrt(1 + mp.mpf(growth.B) * x * x) / largest) - psi(1 / largest)


@pytest.mark.parametrize("velocity, rest", SLIDING)
def test_survival_of_sliding_contacts(velocity: float, rest: float) -> None:
    growth = origins.GrainGrowth(alpha=1.0, B=1.0)
    contact, first = origins.GrainContact(growth), growth.first_pinning_time

    def hazard(x: np.ndarray) -> np.ndarray:
        return contact.hazard(x, first + rest + x / velocity)

    end = brentq(lambda x: hazard(x) - 300.0, 0.0, 1e6, xtol=1e-300)
    x = end * np.array([1e-5, 1e-3, 0.03, 0.2, 0.5, 0.8, 0.95, 1.0])
    with mp.workdps(320):
        exact = [meeting_hazard(mp.mpf(float(v)), growth, velocity, rest) for v in x]
    known = np.array(exact, dtype=float)
    # the age is rounded, by which the grains have grown since they pinned; and so is the distance to
    # the largest grain, whose inverse the hazard is
    rounding = 1e-11 * known / (x / velocity + rest) + 1e-15 * known**2
    assert (np.abs(hazard(x) - known) <= 1e-12 + rounding).all()
    # as they pin, contacts whose thresholds start to grow slower than they slide never hold
    if rest == 0.0:
        lost = 4.5 * (velocity * first) ** 2
        assert contact.lost_hazard(velocity) == pytest.approx(lost, rel=1e-14)
    # the hazard at the meeting never falls, so that each quantile meets its threshold once
    rises = np.diff(hazard(np.linspace(1e-3 * end, end, 20_001)))
    assert (rises >= -1e-11).all()


def test_quantiles_of_growing_contacts() -> None:
    growth = origins.GrainGrowth(alpha=1.0, B=1.7)
    contact = origins.GrainContact(growth)
    first = growth.first_pinning_time
    u = np.array([0.0, 1e-9, 0.3, 0.7, 1.0 - 1e-9, 1.0])
    for age in first * np.array([1.01, 2.0, 50.0, 1e9]):
        law = growth.thresholds(age)
        np.testing.assert_allclose(contact.quantile(u, age), law.ppf(u), rtol=1e-12)
    ages = np.linspace(first, 100.0 * first, 400)
    grown = contact.quantile(u[:, None], ages)
    assert (
        grown.shape == (6, 400)
        and (grown[:, 0] == 0.0).all()
        and (np.diff(grown[1:], axis=1) > 0.0).all()
    )
    assert isinstance(contact.quantile(0.5, 3.0), float)
