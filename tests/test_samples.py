"""Thresholds from samples: the monotone cubic against scipy's, its limits, its sampling error, bad samples."""

import mpmath as mp
import numpy as np
import pytest
from scipy import stats
from scipy.interpolate import PchipInterpolator

import origins
from origins import InputError
from origins.quadrature import gauss


def draws(n: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).weibull(2.0, n)


@pytest.mark.parametrize("n", [2, 3, 4, 5, 10, 57, 300, 4000, 100_000])
def test_is_pchip_through_its_knots(n: int) -> None:
    samples = draws(n)
    law = origins.from_samples(samples)
    knots = law.breakpoints
    assert law.support() == (samples.min(), samples.max()) and knots[0] == samples.min() and knots[-1] == samples.max()
    assert knots.size <= 40 and np.isin(knots, samples).all()
    cubic = (
        PchipInterpolator(knots, law.cdf(knots)) if knots.size > 2 else np.polynomial.Polynomial.fit(knots, [0, 1], 1)
    )
    x = np.linspace(knots[0], knots[-1], 2001)[1:-1]
    np.testing.assert_allclose(law.cdf(x), cubic(x), atol=1e-14)
    slope = cubic.derivative() if knots.size > 2 else cubic.deriv()
    np.testing.assert_allclose(law.pdf(x), slope(x), rtol=1e-11, atol=1e-12 * law.pdf(x).max())
    np.testing.assert_allclose(law.cdf(x) + law.sf(x), 1.0, atol=1e-15)
    # no weight outside, and the knots sit on order statistics
    outside = np.array([0.0, knots[0] * (1 - 1e-12), knots[-1] * (1 + 1e-12), np.inf])
    assert law.pdf(outside).tolist() == [0.0] * 4 and law.cdf(outside).tolist() == [0.0, 0.0, 1.0, 1.0]
    ranks = np.searchsorted(np.sort(samples), knots)
    np.testing.assert_allclose(law.cdf(knots), ranks / (n - 1), atol=1e-15)


def test_density_is_continuous_and_integrates_to_one() -> None:
    law = origins.from_samples(draws(1000))
    knots = law.breakpoints[1:-1]
    np.testing.assert_allclose(law.pdf(knots * (1 - 1e-13)), law.pdf(knots * (1 + 1e-13)), rtol=1e-9)
    nodes, weights = gauss(law.breakpoints[:-1], law.breakpoints[1:])
    assert (weights * law.pdf(nodes)).sum() == pytest.approx(1.0, abs=1e-14)
    # 20 nodes are exact to degree 39 where the density is a parabola
    t, w = np.polynomial.legendre.leggauss(20)
    half = 0.5 * np.diff(law.breakpoints)[:, None]
    x = law.breakpoints[:-1, None] + half * (t + 1.0)
    for n in (1, 2, 3, 4, 9, 13, 14, 20):
        assert law.moment(n) == pytest.approx((half * w * x**n * law.pdf(x)).sum(), rel=1e-12)
    assert law.std() == pytest.approx(np.sqrt(law.moment(2) - law.mean() ** 2), rel=1e-12)


def test_tails_keep_their_digits() -> None:
    """The cdf at the first knot and the survival at the last, as polynomials in mpmath."""
    law = origins.from_samples(draws(1000))
    knots, values = law.breakpoints, law.cdf(law.breakpoints)
    slopes = law.pdf(knots)
    for edge, near, rise, end, inner in (
        (knots[0], knots[1], values[1], slopes[0], slopes[1]),
        (knots[-1], knots[-2], law.sf(knots[-2]), slopes[-1], slopes[-2]),
    ):
        width = mp.mpf(float(abs(near - edge)))
        for fraction in (0.5, 1e-3, 1e-8, 1e-12):
            x = float(edge + (near - edge) * fraction)
            t = abs(mp.mpf(x) - mp.mpf(float(edge))) / width
            start, stop, height = mp.mpf(float(end)) * width, mp.mpf(float(inner)) * width, mp.mpf(float(rise))
            cubic = t * (1 - t) ** 2 * start + t * t * (1 - t) * (3 * height - stop) + t**3 * height
            found = law.cdf(x) if edge < near else law.sf(x)
            assert float(found) == pytest.approx(float(cubic), rel=1e-10)
    q = 10.0 ** -np.arange(1.0, 15.0)
    np.testing.assert_allclose(law.sf(law.isf(q)), q, rtol=1e-10, atol=4e-16 * slopes.max() * knots[-1])
    np.testing.assert_allclose(law.cdf(law.ppf(q)), q, rtol=1e-10, atol=4e-16 * slopes.max())


def test_recovers_the_law_within_the_stated_error() -> None:
    """The bound on the cdf holds in at least 95 % of 200 sets, and the smooth cdf adds little to it."""
    x = np.linspace(0.0, 3.5, 400)
    truth = -np.expm1(-x * x)
    held = 0
    for seed in range(200):
        law = origins.from_samples(draws(400, seed))
        held += np.abs(law.cdf(x) - truth).max() <= law.cdf_error + law.cdf_misfit
        assert law.cdf_misfit < 0.6 * law.cdf_error
    assert held >= 190
    big = origins.from_samples(draws(200_000))
    assert big.n_samples == 200_000 and big.cdf_error == pytest.approx(np.sqrt(np.log(40.0) / 400_000))
    assert np.abs(big.cdf(x) - truth).max() < big.cdf_error
    assert big.mean() == pytest.approx(stats.weibull_min(2).mean(), rel=3e-3)


def test_misfit_is_the_largest_distance_from_the_empirical_cdf() -> None:
    samples = draws(57)
    law = origins.from_samples(samples)
    assert law.cdf_misfit == pytest.approx(stats.kstest(samples, law.cdf).statistic, rel=1e-12)


def test_equal_samples() -> None:
    assert origins.from_samples([2.0]).atoms[0].tolist() == [2.0]
    assert origins.from_samples([2.0, 2.0, 2.0]).support() == (2.0, 2.0)
    law = origins.from_samples(np.repeat([1.0, 2.0, 3.0], [50, 1, 49]))
    assert law.breakpoints.tolist() == [1.0, 2.0, 3.0] and law.cdf(2.0) == pytest.approx(50 / 99)
    x = np.linspace(1.0, 3.0, 100)
    assert (np.diff(law.cdf(x)) > 0.0).all()


def test_rounded_samples() -> None:
    """Values recorded to two digits come in ties; the law stays smooth and near."""
    law = origins.from_samples(np.round(draws(5000) + 0.005, 2))
    x = np.linspace(0.2, 2.0, 50)
    assert np.abs(law.cdf(x) + np.expm1(-x * x)).max() < 0.04
    assert law.std() == pytest.approx(stats.weibull_min(2).std(), rel=0.03)


@pytest.mark.parametrize(
    "samples, power", [([1.0, 1.2, 1.3, 2.0], 0.0), ([1.0, 2.0, 2.1, 2.15, 2.2, 2.22, 2.25, 2.3], 1.0)]
)
def test_onset_power(samples: list[float], power: float) -> None:
    law = origins.from_samples(samples)
    assert law.onset_power == power
    near = law.support()[0] + np.array([1e-6, 2e-6]) * (law.breakpoints[1] - law.breakpoints[0])
    assert np.log2(law.cdf(near[1]) / law.cdf(near[0])) == pytest.approx(power + 1.0, abs=1e-4)


def test_forces_by_either_law() -> None:
    forces = draws(50) ** 2
    quadratic = origins.from_samples(f_s=forces, coefficient=4.0)
    np.testing.assert_allclose(
        quadratic.breakpoints, origins.from_samples(np.sqrt(forces) / 2.0).breakpoints, rtol=1e-15
    )
    linear = origins.from_samples(f_s=forces, stiffness=4.0)
    np.testing.assert_allclose(linear.breakpoints, origins.from_samples(forces / 4.0).breakpoints, rtol=1e-15)


@pytest.mark.parametrize(
    "arguments, begins",
    [
        ({"x_s": []}, "x_s = array of shape (0,): "),
        ({"x_s": [[1.0, 2.0]]}, "x_s = array of shape (1, 2): "),
        ({"x_s": [1.0, np.nan]}, "x_s[1] = nan: "),
        ({"x_s": [1.0, np.inf]}, "x_s[1] = inf: "),
        ({"x_s": [1.0, 2.0, -1.0]}, "x_s[2] = -1.0: "),
        ({"x_s": [0.0]}, "x_s[0] = 0.0: "),
        ({"x_s": "many"}, "x_s = 'many': "),
        ({"f_s": [1.0, -2.0], "stiffness": 1.0}, "f_s[1] = -2.0: "),
        ({"f_s": [1.0], "stiffness": 0.0}, "stiffness = 0.0: "),
        ({"f_s": [1.0], "coefficient": np.nan}, "coefficient = nan: "),
        ({"x_s": [1.0], "stiffness": 2.0}, "stiffness = 2.0: "),
        ({}, "from_samples: give either x_s"),
        ({"x_s": [1.0], "f_s": [1.0]}, "from_samples: give either x_s"),
        ({"f_s": [1.0]}, "from_samples: with f_s give either"),
        ({"f_s": [1.0], "coefficient": 1.0, "stiffness": 1.0}, "from_samples: with f_s give either"),
    ],
)
def test_bad_samples_are_named(arguments: dict, begins: str) -> None:
    with pytest.raises(InputError) as refusal:
        origins.from_samples(**arguments)
    assert str(refusal.value).startswith(begins) and "\n" not in str(refusal.value)
