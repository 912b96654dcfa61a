"""Grains of Lifshitz and Slyozov: sizes, thresholds by both Jacobians, growth in time, sliding; against mpmath."""

from decimal import Decimal

import numpy as np
import pytest
from references import mp, psi
from scipy import stats
from scipy.optimize import brentq

import master
import origins
from origins import InputError, grains
from origins.grains.lifshitz_slyozov import hazard_beyond

BARELY = 2.0 / 3.0 * (1.0 + 1e-6)


def test_sizes_are_the_printed_density() -> None:
    """As the paper and Lifshitz and Pitaevskii print it: minus the slope of the survival e^-psi."""
    third = mp.mpf(1) / 3

    def printed(u: mp.mpf) -> mp.mpf:
        front = 81 * mp.e / 2 ** (5 * third) * u * u * mp.exp(-1 / (1 - 2 * u / 3))
        return front / ((u + 3) ** (7 * third) * (mp.mpf(3) / 2 - u) ** (11 * third))

    def survival(u: mp.mpf) -> mp.mpf:
        return mp.exp(-psi(2 * u / 3))

    for x in np.append(1.5 - 10.0 ** -np.arange(3.0), [1e-8, 1e-3, 0.1, 0.59, 0.61, 1.1, 1.497]):
        u, hazard = mp.mpf(float(x)), hazard_beyond(np.array([x / (1.5 - x)]))[0]
        assert abs(-mp.diff(survival, u) / printed(u) - 1) < 1e-50
        assert abs(hazard / psi(2 * u / 3) - 1) < 1e-12


@pytest.mark.parametrize("rho", [BARELY, 1.0, 1e3])
def test_the_printed_form_is_the_exact_one_by_another_jacobian(rho: float) -> None:
    """Printed over exact is proportional to (1 + B x²)^(1/2)/x: dr/df ~ 1/r, not f^(-1/2)."""
    exact, printed = grains(rho, B=2.0), grains(rho, B=2.0, jacobian="paper")
    x = exact.isf(np.array([0.999, 0.9, 0.5, 0.1, 1e-6, 1e-30]))
    shape = printed.pdf(x) / exact.pdf(x) * x / np.sqrt(1.0 + 2.0 * x * x)
    np.testing.assert_allclose(shape, shape[0], rtol=1e-11)
    assert printed.onset_power == 0.0 and printed.pdf(0.0) > 0.0 and exact.onset_power == 1.0


def test_first_grains_to_pin() -> None:
    """rho -> 2/3: the law of a stretch far below x_max, exp(-B x²/(2 e²)) with e the excess, and its half Gaussian."""
    rho = float(np.float64(2.0 / 3.0) * (1.0 + 1e-12))
    true = float(Decimal(rho) * 3 / 2 - 1)  # the excess that this float has
    exact, printed = grains(rho, B=4.0), grains(rho, B=4.0, jacobian="paper")
    width = true / 2.0
    q = np.array([1e-100, 1e-12, 0.01, 0.3, 0.9, 1.0 - 1e-9])
    # corrections are of the order of the excess, times the hazard
    np.testing.assert_allclose(
        exact.isf(q), width * np.sqrt(-2.0 * np.log(q)), rtol=500.0 * true + 1e-14
    )
    half = stats.norm(0.0, width)
    np.testing.assert_allclose(
        printed.isf(q), half.isf(0.5 * q), rtol=500.0 * true + 1e-9 * (q > 0.999).any()
    )
    assert exact.support()[1] == pytest.approx(np.sqrt(2.0 * true) / 2.0, rel=1e-5)


def test_propensity_of_the_printed_form() -> None:
    """m = 0, yet prone: the onset power alone does not decide. The first grains are Rayleigh's law."""

    def spring(law: origins.Thresholds) -> float:
        return master.propensity(origins.Contacts(law)).critical_spring

    for rho, known in ((1.0, 0.29), (2.0, 1.04)):
        assert spring(grains(rho, B=1.0, jacobian="paper")) == pytest.approx(known, abs=0.005)
    assert spring(grains(BARELY, B=1.0)) == pytest.approx(spring(origins.gw_plastic(1.0)), abs=1e-5)


# -- grains in time --------------------------------------------------------------------------------


def test_growth_in_time() -> None:
    growth = origins.GrainGrowth(alpha=0.8, B=1.7)
    first = growth.first_pinning_time
    assert growth.rho(first) == pytest.approx(2.0 / 3.0, rel=1e-15)
    times = first * np.array([1.5, 27.0 / 8.0, 20.0, 1e6])
    np.testing.assert_allclose(growth.rho(times), 0.8 * times ** (1.0 / 3.0), rtol=1e-15)
    fraction = growth.pinned_fraction(times)
    sizes = [mp.mpf(2.0 / 3.0 / rho) for rho in growth.rho(times).tolist()]
    np.testing.assert_allclose(fraction, [float(mp.exp(-psi(y))) for y in sizes], rtol=1e-12)
    np.testing.assert_allclose(growth.pinning_number(times), fraction * first / times, rtol=1e-15)
    # grains of the mean radius neither grow nor shrink: most pin when those are as thick as the film, at rho = 1
    around = growth.pinning_number(27.0 / 8.0 * first * (1.0 + np.array([-1e-3, 0.0, 1e-3])))
    assert around.argmax() == 1
    same = grains(0.8 * (20.0 * first) ** (1 / 3), B=1.7)
    assert growth.thresholds(20.0 * first).sf(0.9) == pytest.approx(same.sf(0.9), rel=1e-13)
    with pytest.raises(InputError, match=r"^time = .*: no grain pins yet"):
        growth.thresholds(0.9 * first)


def test_growth_of_a_film() -> None:
    """A grain of radius r breaks at tau pi (r² - d²/4) = c x², and the first as thick as the film pins."""
    thin = origins.film_growth(
        2e-9, coarsening_rate=1e-27, shear_strength=1e8, force_coefficient=3e12
    )
    assert thin.first_pinning_time == pytest.approx((2e-9) ** 3 / 27e-27, rel=1e-14)
    time = 5.0 * thin.first_pinning_time
    force = 1e8 * np.pi * ((1.5 * (1e-27 * time) ** (1 / 3)) ** 2 - 1e-18)
    assert thin.thresholds(time).support()[1] == pytest.approx(np.sqrt(force / 3e12), rel=1e-13)
    # k = G A^(1/2) and f_s = tau A: x = tau A^(1/2)/G
    by_modulus = origins.film_growth(2e-9, 1e-27, 1e8, shear_modulus=4e10).thresholds(time)
    assert by_modulus.support()[1] == pytest.approx(1e8 * np.sqrt(force / 1e8) / 4e10, rel=1e-13)


SLIDING = [(3.0, 0.0), (0.3, 0.7)]  # velocity, rest


def meeting_hazard(x: mp.mpf, growth: origins.GrainGrowth, velocity: float, rest: float) -> mp.mpf:
    """Straight from the definition, -log of the survival of P_c at the age of stretch x."""
    since = (mp.mpf(rest) + x / mp.mpf(velocity)) / mp.mpf(growth.first_pinning_time)
    largest = (1 + since) ** (mp.mpf(1) / 3)
    return psi(mp.sqrt(1 + mp.mpf(growth.B) * x * x) / largest) - psi(1 / largest)


@pytest.mark.parametrize("velocity, rest", SLIDING)
def test_hazard_of_sliding_contacts(velocity: float, rest: float) -> None:
    growth = origins.GrainGrowth(alpha=1.0, B=1.0)
    contact, first = origins.GrainContact(growth), growth.first_pinning_time

    def hazard(x: np.ndarray) -> np.ndarray:
        return contact.hazard(x, first + rest + x / velocity)

    end = brentq(lambda x: hazard(x) - 300.0, 0.0, 1e6, xtol=1e-300)
    x = end * np.array([1e-5, 1e-3, 0.03, 0.2, 0.5, 0.8, 0.95, 1.0])
    with mp.workdps(320):
        known = np.array(
            [float(meeting_hazard(mp.mpf(float(v)), growth, velocity, rest)) for v in x]
        )
    # the age is rounded, by which the grains have grown since they pinned; and so is the distance to
    # the largest grain, whose inverse the hazard is
    rounding = 1e-11 * known / (x / velocity + rest) + 1e-15 * known**2
    assert (np.abs(hazard(x) - known) <= 1e-12 + rounding).all()
    # it never falls, so that each quantile meets its threshold once
    assert (np.diff(hazard(np.linspace(1e-3 * end, end, 20_001))) >= -1e-11).all()


def test_quantiles_of_growing_contacts() -> None:
    growth = origins.GrainGrowth(alpha=1.0, B=1.7)
    contact, first = origins.GrainContact(growth), growth.first_pinning_time
    u = np.array([0.0, 1e-9, 0.3, 0.7, 1.0 - 1e-9, 1.0])
    for age in first * np.array([1.01, 50.0, 1e9]):
        np.testing.assert_allclose(
            contact.quantile(u, age), growth.thresholds(age).ppf(u), rtol=1e-12
        )
    grown = contact.quantile(u[:, None], np.linspace(first, 100.0 * first, 400))
    assert (grown[:, 0] == 0.0).all() and (np.diff(grown[1:], axis=1) > 0.0).all()
