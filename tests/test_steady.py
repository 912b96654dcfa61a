"""Smooth sliding: the force against exact moments of every origin, and what is refused."""

import mpmath
import numpy as np
import pytest
import references
import scipy.stats

import master
import origins
from origins.errors import InputError

LAWS = {
    "gaussian": references.gaussian(1.0, 0.05),
    "gaussian, narrow": references.gaussian(1.0, 1e-3),
    "gaussian, wide": references.gaussian(1.0, 0.5),
    "gaussian, tail alone": references.gaussian(-1.0, 0.5),
    "gaussian, paper's": references.chord_gaussian(1.0, 0.5, 2.0),
    "rectangular": references.rectangular(0.5, 1.5),
    "uniform": references.rectangular(0.0, 1.0),
    "gw_elastic": references.gw_elastic(1.588),
    "gw_plastic": references.gw_plastic(1.251),
    "lubricated": references.lubricated(0.7),
    "persson": references.persson(1.0, 0.5),
    "persson, at the centre": references.persson(0.0, 1.0),
    "persson, wide": references.persson(1.0, 20.0),
    "persson, narrow": references.persson(1.0, 0.01),
    "mixture with a gap": references.mixture(
        [references.rectangular(0.2, 0.5), references.gaussian(1.0, 0.01)], [0.3, 0.7]
    ),
    "mixture of scales": references.mixture(
        [references.gaussian(1e-6, 1e-8), references.gaussian(1.0, 0.05)], [0.9, 0.1]
    ),
}

# law, <x_s>, <x_s^2>
ATOMIC = {
    "identical": (origins.identical(1.7), 1.7, 1.7**2),
    "two values": (
        origins.mixture([origins.identical(1.0), origins.identical(3.0)], [0.3, 0.7]),
        0.3 + 0.7 * 3.0,
        0.3 + 0.7 * 9.0,
    ),
    "value and gaussian": (
        origins.mixture([origins.identical(0.95), origins.gaussian(1.05, 0.1)], [0.25, 0.75]),
        1.025,
        1.06,
    ),
    "value and uniform": (
        origins.mixture([origins.identical(0.5), origins.rectangular(0.0, 1.0)], [0.5, 0.5]),
        0.5,
        0.5 * 0.25 + 0.5 / 3.0,
    ),
}


def check(law: object, mean: float, square: float) -> master.SteadyState:
    steady = master.steady_state(origins.Contacts(law))
    assert steady.mean_threshold == pytest.approx(mean, rel=1e-10)
    true = abs(steady.force - square / (2.0 * mean)) / mean
    assert true <= steady.force_error
    return steady


@pytest.mark.parametrize("name", LAWS)
def test_force_of_every_origin_against_many_digits(name: str) -> None:
    reference = LAWS[name]
    steady = check(reference.law, float(reference.moment(1)), float(reference.moment(2)))
    assert steady.force_error < 2e-14 * max(steady.force / steady.mean_threshold, 1.0)


@pytest.mark.parametrize("name", ATOMIC)
def test_force_of_laws_with_exact_values(name: str) -> None:
    steady = check(*ATOMIC[name])
    assert steady.force_error < 1e-14


@pytest.mark.parametrize("law", [scipy.stats.lomax(1.5), scipy.stats.lomax(2.0), scipy.stats.invgamma(1.5)])
def test_infinite_mean_square_is_refused(law: object) -> None:
    with pytest.raises(InputError) as caught:
        master.steady_state(origins.Contacts(law))
    (line,) = str(caught.value).splitlines()
    assert line.startswith("thresholds: <x_s^2> is infinite") and "x^-3" in line


@pytest.mark.parametrize(
    "law", [LAWS["gw_elastic"].law, LAWS["mixture with a gap"].law, ATOMIC["value and gaussian"][0]]
)
def test_distribution_integrates_to_one_with_the_force_as_its_mean(law: origins.Thresholds) -> None:
    steady = master.steady_state(origins.Contacts(law))
    corners = np.concatenate([law.breakpoints, law.atoms[0]])
    top = max(float(law.isf(1e-19)), corners.max())
    fine = np.unique(np.concatenate([np.linspace(0.0, top, 400), np.geomspace(1e-9, top, 200), corners]))
    nodes, weights = np.polynomial.legendre.leggauss(12)
    half = 0.5 * np.diff(fine)[:, None]
    x = fine[:-1, None] + half * (1.0 + nodes)
    mass = half * weights * steady.distribution(x)
    assert mass.sum() == pytest.approx(1.0, abs=1e-12)
    assert (mass * x).sum() == pytest.approx(steady.force, rel=1e-12)


@pytest.mark.parametrize("scale", [1e-9, 1e9])
def test_scale_of_lengths(scale: float) -> None:
    base = origins.mixture([origins.rectangular(0.2, 0.5), origins.gaussian(1.0, 0.1)], [0.3, 0.7])
    scaled = origins.mixture(
        [origins.rectangular(0.2 * scale, 0.5 * scale), origins.gaussian(scale, 0.1 * scale)], [0.3, 0.7]
    )
    one, other = (master.steady_state(origins.Contacts(law)) for law in (base, scaled))
    assert other.force == pytest.approx(scale * one.force, rel=1e-13)
    assert other.force_error < 1e-14
    x = np.linspace(0.0, 2.0, 101)
    assert np.allclose(other.distribution(scale * x) * scale, one.distribution(x), rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize("births", [0.1, origins.gaussian_start(0.1, 0.01)], ids=["at one stretch", "at many"])
def test_births_ahead_of_far_tails(births: object) -> None:
    """P_c = a (1 + x)^(-a-1) beyond r is the same law, 1 + r times as wide."""
    power, spread = 2.2, 0.0 if isinstance(births, float) else 0.01
    once, twice = 1.1, 1.1**2 + spread**2  # means of 1 + r and of its square
    length = once / (power - 1.0)
    area = (twice - once) / (power - 1.0) + twice / ((power - 1.0) * (power - 2.0))
    contacts = origins.Contacts(scipy.stats.lomax(power), reforming=births, delay=origins.Delay(0.3))
    steady = master.steady_state(contacts)
    unit = contacts.mean_threshold
    assert abs(steady.cycle_length - length) < steady.cycle_length_error * unit < 1e-9
    assert abs(steady.force - area / (length + 0.3)) < steady.force_error * unit < 3e-7


@pytest.mark.parametrize("at", [2.3, 2.6, 2.65, 5.0])
def test_births_deep_in_the_tail_of_the_thresholds(at: float) -> None:
    """F_k = at + <d^2>/2<d> with d what thresholds are beyond: Mills' ratio and its moments, for normal thresholds."""
    found = master.steady_state(origins.Contacts(origins.gaussian(1.0, 0.2), reforming=at))
    with mpmath.workdps(60):
        z = (mpmath.mpf(at) - 1) / mpmath.mpf("0.2")
        mills = mpmath.sqrt(mpmath.pi / 2) * mpmath.erfc(z / mpmath.sqrt(2)) * mpmath.exp(z * z / 2)
        first = 1 / mills - z
        second = 1 - z * first
        expected = float(at + mpmath.mpf("0.1") * second / first)
    assert found.success and abs(found.force - expected) <= found.force_error * found.mean_threshold < 1e-10
