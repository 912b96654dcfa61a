"""Every family of thresholds against mpmath, laws of scipy and of one's own, averages over a parameter."""

from functools import cache
from typing import Any

import numpy as np
import pytest
import references as exact
from conftest import slow
from references import Reference, mp
from scipy import stats

import master
import origins

EPSILON = np.finfo(float).eps
UPPER = 10.0 ** -np.array([0.02, 0.3, 1, 2, 5, 10, 30, 80, 150, 220, 280])
LOWER = 10.0 ** -np.array([0.05, 0.5, 1, 3, 8, 15, 22, 30])

CASES = {
    "gw_elastic": lambda: exact.gw_elastic(1.0),
    "gw_plastic": lambda: exact.gw_plastic(1.0),
    "gw_gaussian": lambda: exact.gw_gaussian(1.5, 1.0, "paper", "elastic"),
    "gw_gaussian light": lambda: exact.gw_gaussian(40.0, 2e-8, "amontons", "elastic"),
    "gw_gaussian mixed": lambda: exact.gw_gaussian(0.5, 3e-8, "amontons", "mixed", 9.0),
    "gw_gaussian mixed light": lambda: exact.gw_gaussian(10.0, 1.0, "paper", "mixed", 25.0),
    "rectangular": lambda: exact.rectangular(0.5, 1.5),
    "lubricated": lambda: exact.lubricated(1.0),
    "lubricated, steep": lambda: exact.lubricated(1.3, 5.0, 3.0),
    "lubricated, diverging": lambda: exact.lubricated(2e-9, -0.5, 0.5),
    "grains": lambda: exact.grains(1.0, 1.0),
    "grains, all but pinning": lambda: exact.grains(2.0 / 3.0 * (1.0 + 1e-6), 1.0),
    "grains, few pinning": lambda: exact.grains(0.7, 3.7e17),
    "grains, far beyond the film": lambda: exact.grains(1e3, 2.3),
    "persson": lambda: exact.persson(1.0, 0.5),
    "persson light": lambda: exact.persson(0.01, 1.0),
    "persson at 0": lambda: exact.persson(0.0, 1.7),
    "persson narrowest": lambda: exact.persson(1.0, 0.01),
    "gaussian": lambda: exact.gaussian(1.0, 0.05),
    "gaussian broad": lambda: exact.gaussian(1.0, 0.4),
    "gaussian from zero": lambda: exact.gaussian(0.0, 0.4),
    "gaussian mostly below": lambda: exact.gaussian(-1.0, 0.5),
    "chord": lambda: exact.chord_gaussian(1.0, 0.05, 2.0),
    "chord wide": lambda: exact.chord_gaussian(1.0, 0.3, 5.0),
    "chord short": lambda: exact.chord_gaussian(1.0, 0.3, 1.5),
    "two Gaussians": lambda: exact.mixture(
        [exact.gaussian(0.3, 0.03), exact.gaussian(1.0, 0.05)], [0.3, 0.7]
    ),
    "unequal": lambda: exact.mixture(
        [exact.gw_elastic(1.0), exact.rectangular(2.0, 3.0), exact.persson(1.0, 0.5)],
        [1e-3, 0.499, 0.5],
    ),
    "rare tail": lambda: exact.mixture(
        [exact.gaussian(1.0, 0.2), exact.gw_elastic(1.0)], [1.0 - 1e-9, 1e-9]
    ),
}


# one or two of each family in the quick suite
FEW = {"gw_elastic", "gw_gaussian mixed", "rectangular", "lubricated, diverging", "grains"}
FEW |= {"grains, far beyond the film", "persson", "persson light", "gaussian", "chord", "unequal"}


@pytest.fixture(scope="module", params=[slow(name, when=name not in FEW) for name in CASES])
def case(request: pytest.FixtureRequest) -> Reference:
    return CASES[request.param]()


def is_chord(law: origins.Thresholds) -> bool:
    return "Chord" in type(law).__name__


@cache
def at(function, value: float) -> mp.mpf:
    """Several tests ask for the same function at the same quantiles."""
    return function(mp.mpf(value))


def exactly(function, x: np.ndarray) -> np.ndarray:
    return np.array([float(at(function, float(value))) for value in x])


def logarithm(function, x: np.ndarray) -> np.ndarray:
    return np.array([float(mp.log(at(function, float(value)))) for value in x])


def end_rounding(law: origins.Thresholds, x: np.ndarray) -> np.ndarray:
    """Relative distance by which an end of the support that is no float moves x, as seen from that end."""
    if not is_chord(law):
        return np.zeros(x.shape)
    ends = law.support()
    distance = np.minimum(x - ends[0] if ends[0] > 0.0 else np.inf, ends[1] - x)
    return 4.0 * EPSILON * ends[1] / np.maximum(distance, EPSILON * ends[1])


def assert_close(found: np.ndarray, exact: np.ndarray, relative: float | np.ndarray) -> None:
    assert (np.abs(found - exact) <= relative * np.abs(exact)).all(), (found, exact)


def test_both_tails(case: Reference) -> None:
    """Relative accuracy 1e-10 of the survival down to 1e-280 and of the cdf down to 1e-30."""
    law, (low, high) = case.law, case.law.support()
    upper, lower = law.isf(UPPER), law.ppf(LOWER)
    upper, lower = upper[upper < high], lower[lower > low]
    at_upper, at_lower = end_rounding(law, upper), end_rounding(law, lower)
    assert_close(law.sf(upper), exactly(case.sf, upper), 1e-10 + at_upper)
    assert_close(law.cdf(lower), exactly(case.cdf, lower), 1e-10 + at_lower)
    assert_close(law.logsf(upper), logarithm(case.sf, upper), 1e-12 + at_upper)
    # where the survival is 1 to the last bit its logarithm is still minus the cdf
    assert_close(law.logsf(lower), logarithm(case.sf, lower), 1e-10 + at_lower)


def test_density(case: Reference) -> None:
    x = np.concatenate([case.law.isf(UPPER), case.law.ppf(LOWER)])
    x = x[(x > case.law.support()[0]) & (x < case.law.support()[1])]
    assert_close(case.law.pdf(x), exactly(case.pdf, x), 1e-10 + end_rounding(case.law, x))
    slack = 1e-11 + 1e-12 * np.abs(case.law.logpdf(x)) + end_rounding(case.law, x)
    assert (np.abs(case.law.logpdf(x) - logarithm(case.pdf, x)) <= slack).all()


def test_quantiles(case: Reference) -> None:
    """The float nearest to the exact quantile, but for a few last bits and 1e-10 of the probability."""
    law, (low, high) = case.law, case.law.support()
    for quantile, function, targets in ((law.isf, case.sf, UPPER), (law.ppf, case.cdf, LOWER)):
        x = quantile(targets)
        bits = 4.0 * EPSILON * x
        slack = targets * (1e-10 + end_rounding(law, x)) + bits * exactly(case.pdf, x)
        # beside an end of the support that is not 0 the nearest float may be the end itself, or two away
        beside = np.minimum(np.abs(x - low), np.abs(high - x)) < 2.0 * bits
        slack += np.where(beside, 1e-14, 0.0)
        assert (np.abs(exactly(function, x) - targets) <= slack).all()


def test_moments_and_steady_sliding(case: Reference, request: pytest.FixtureRequest) -> None:
    """F_k = <x²>/(2 <x>), within the error claimed."""
    mean, square = float(case.moment(1)), float(case.moment(2))
    assert case.law.mean() == pytest.approx(mean, rel=1e-12)
    for n in (2, 3, 4):
        assert case.law.moment(n) == pytest.approx(float(case.moment(n)), rel=1e-10)
    with mp.workdps(40):
        variance = float(case.moment(2) - case.moment(1) ** 2)
    assert case.law.std() == pytest.approx(np.sqrt(variance), rel=1e-10)
    steady = master.steady_state(origins.Contacts(case.law))
    assert steady.mean_threshold == pytest.approx(mean, rel=1e-10)
    assert abs(steady.force - square / (2.0 * mean)) <= steady.force_error * mean
    # parts that weigh a thousandth and a half leave more round-off
    most = 5e-14 if "[unequal]" in request.node.name else 2e-14
    assert steady.force_error < most * max(steady.force / mean, 1.0)


def test_onset_power(case: Reference) -> None:
    """P_c ~ (x - a)^m: m from two densities next to the lower end a."""
    lower, power = case.law.support()[0], case.law.onset_power
    if is_chord(case.law):
        # h starts along a straight line; test_density follows it
        assert power == 1.0
        return
    step = (mp.mpf(float(case.law.ppf(0.5))) - lower) * mp.mpf(10) ** -28
    if case.law.logpdf(lower + float(step)) < -1e3:
        # stresses so narrow that no digits tell how they begin
        assert power == 3.0
        return
    with mp.workdps(190):
        ratio = case.pdf(lower + 2 * step) / case.pdf(lower + step)
        assert power == pytest.approx(float(mp.log(ratio, 2)), abs=1e-12)


SCALED = {
    "gw_gaussian": lambda s: origins.gw_gaussian(-1.0, s, regime="mixed", plasticity_index=9.0),
    "generalised gamma": lambda s: origins.lubricated(0.9 * s, power=3.2, decay=1.8),
    "grains": lambda s: origins.grains(2.3, B=1.8 / s**2),
    "grains, printed": lambda s: origins.grains(2.3, B=1.8 / s**2, jacobian="paper"),
    "persson": lambda s: origins.persson(s, 1.8 * s),
    "gaussian": lambda s: origins.gaussian(s, 0.8 * s),
    "chord": lambda s: origins.gaussian(s, 0.85 * s, form="paper", upper=3.6 * s),
    "mixture": lambda s: origins.mixture(
        [origins.gaussian(s, 0.1 * s), origins.lubricated(s)], [0.4, 0.6]
    ),
    "samples": lambda s: origins.from_samples(s * np.random.default_rng(3).gamma(1.8, size=300)),
}


@pytest.mark.parametrize("scale", [1e-9, 1e9])
@pytest.mark.parametrize("name", SCALED)
def test_scale_changes_nothing_but_the_scale(name: str, scale: float) -> None:
    base, scaled = SCALED[name](1.0), SCALED[name](scale)
    q = np.array([1e-12, 1e-3, 0.2, 0.5, 0.9])
    x = base.isf(q)
    x, least = x[x < base.support()[1]], 1e-15 * base.pdf(x).max()
    np.testing.assert_allclose(scaled.isf(q), scale * base.isf(q), rtol=1e-12)
    np.testing.assert_allclose(scaled.ppf(q), scale * base.ppf(q), rtol=1e-12)
    np.testing.assert_allclose(scaled.sf(scale * x), base.sf(x), rtol=1e-11, atol=4e-16)
    np.testing.assert_allclose(scaled.pdf(scale * x) * scale, base.pdf(x), rtol=1e-11, atol=least)
    np.testing.assert_allclose(scaled.breakpoints, scale * base.breakpoints, rtol=1e-12)
    for n in (1, 2, 3, 4):
        assert scaled.moment(n) / scale**n == pytest.approx(base.moment(n), rel=1e-12)
    assert scaled.onset_power == pytest.approx(base.onset_power, rel=1e-13)


def test_mixture_with_atoms_and_gaps() -> None:
    parts = [origins.identical(0.5), origins.rectangular(1.0, 2.0), origins.identical(3.0)]
    law = origins.mixture(parts, [0.25, 0.5, 0.25])
    assert law.atoms[0].tolist() == [0.5, 3.0] and law.atoms[1].tolist() == [0.25, 0.25]
    assert law.support() == (0.5, 3.0) and law.breakpoints.tolist() == [0.5, 1.0, 2.0, 3.0]
    # an atom at the lowest end: the cdf jumps there, and is right-continuous
    x, below = [0.4, 0.5, 0.7, 1.5, 2.5, 3.0], np.array([0.0, 0.25, 0.25, 0.5, 0.75, 1.0])
    assert (law.cdf(x) == below).all() and (law.sf(x) == 1.0 - below).all()
    # the whole of an atom's weight belongs to one value, and a gap is entered from its left end
    q = np.array([0.0, 0.1, 0.25, 0.5, 0.75, 0.76, 1.0])
    reached = [0.5, 0.5, 0.5, 1.5, 2.0, 3.0, 3.0]
    assert law.ppf(q).tolist() == reached == law.isf(1.0 - q).tolist()
    assert law.mean() == pytest.approx(1.625, rel=1e-15)
    square = 0.25 * 0.25 + 0.5 * (2.25 + 1 / 12) + 0.25 * 9.0
    assert law.std() ** 2 == pytest.approx(square - 1.625**2, rel=1e-14)
    draws = law.rvs(100_000, random_state=2)
    assert abs((draws == 0.5).mean() - 0.25) < 0.006 and abs((draws == 3.0).mean() - 0.25) < 0.006


# -- laws of scipy and of one's own ----------------------------------------------------------------

HISTOGRAM = np.array([1.0, 3.0]), np.array([0.0, 1.0, 2.0])
FROZEN = {
    "weibull_min, shifted": (stats.weibull_min(1.7, loc=1.0, scale=0.1), 0.7),
    "gamma 0.3": (stats.gamma(0.3), -0.7),
    "arcsine": (stats.beta(0.5, 0.5), -0.5),
    "lomax": (stats.lomax(2.5), 0.0),
    "pareto": (stats.pareto(2.5), 0.0),
    "lognorm": (stats.lognorm(0.5), np.inf),
    "expon": (stats.expon(scale=1e9), 0.0),
    "histogram": (stats.rv_histogram(HISTOGRAM, density=False), 0.0),
}


def test_a_start_that_is_a_histogram_has_a_breakpoint_at_each_edge_of_its_bins() -> None:
    moved = stats.rv_histogram(HISTOGRAM, density=False)(loc=-0.5, scale=0.2)
    start = origins.Contacts(stats.gamma(9.0), start=moved).start
    np.testing.assert_allclose(start.breakpoints, [-0.5, -0.3, -0.1], rtol=1e-15)


@pytest.mark.filterwarnings("error")  # none of scipy's integrals, which diverge for pareto
@pytest.mark.parametrize("name", FROZEN)
def test_frozen_distributions(name: str) -> None:
    frozen, power = FROZEN[name]
    law = origins.Contacts(frozen).thresholds
    q = np.array([1e-12, 1e-3, 0.2, 0.5, 0.9, 0.999])
    for method in ("pdf", "logpdf", "cdf", "sf", "logsf"):
        found, known = (getattr(one, method)(frozen.ppf(q)) for one in (law, frozen))
        np.testing.assert_allclose(found, known, rtol=1e-8, atol=1e-15)
    for method in ("ppf", "isf"):
        # where scipy's own quantile does not fit its cdf, as in some far tails, it is found again from that
        np.testing.assert_allclose(getattr(law, method)(q), getattr(frozen, method)(q), rtol=1e-10)
    assert law.mean() == frozen.mean() and law.std() == pytest.approx(frozen.std(), rel=1e-14)
    assert law.moment(3) > 0.0
    lower, upper = frozen.support()
    assert law.support() == (max(lower, 0.0), upper)
    assert law.onset_power == pytest.approx(power, abs=1e-5)


WIDE = stats.Normal(mu=1.0, sigma=0.5)
FAR = [stats.wald(), stats.kappa3(1.2), stats.kappa3(3.0)]
NEWER = {
    "Normal": (stats.Normal(mu=1.0, sigma=0.05), stats.norm(1.0, 0.05), 0.0),
    "truncated": (stats.truncate(WIDE, 0.5, 2.0), stats.truncnorm(-1, 2, 1, 0.5), 0.0),
    "made of lomax": (stats.make_distribution(stats.lomax)(c=2.5), stats.lomax(2.5), 0.0),
}


@pytest.mark.parametrize("name", NEWER)
def test_the_newer_interface_of_scipy(name: str) -> None:
    """The same law as the frozen twin, in both tails, from its density alone."""
    given, twin, power = NEWER[name]
    law = origins.Contacts(given).thresholds
    upper = twin.isf(10.0 ** -np.array([0.02, 0.3, 2, 9, 14]))
    lower = twin.ppf(10.0 ** -np.array([0.3, 2, 9, 14]))
    # the truncated twin subtracts the normal law's survivals near its ends
    rounded = 1e-16 if name == "truncated" else 0.0
    np.testing.assert_allclose(law.sf(upper), twin.sf(upper), rtol=1e-10, atol=rounded)
    np.testing.assert_allclose(law.cdf(lower), twin.cdf(lower), rtol=1e-10, atol=rounded)
    np.testing.assert_allclose(law.isf([0.9, 1e-3]), twin.isf([0.9, 1e-3]), rtol=1e-12)
    assert law.mean() == pytest.approx(twin.mean(), rel=1e-12)
    assert law.std() == pytest.approx(twin.std(), rel=1e-10)
    assert law.onset_power == pytest.approx(power, abs=1e-5)
    assert np.isinf(law.moment(3)) == (name == "made of lomax")


@pytest.mark.parametrize(
    "given", [stats.norm(5.0, 1.0), stats.Normal(mu=5.0, sigma=1.0)], ids=["frozen", "newer"]
)
def test_a_small_weight_below_0_is_cut_and_told(given: object) -> None:
    law, cut = origins.Contacts(given).thresholds, origins.gaussian(5.0, 1.0)
    x = np.array([1e-9, 0.01, 1.0, 5.0, 12.0])
    np.testing.assert_allclose(law.sf(x), cut.sf(x), rtol=1e-11)
    np.testing.assert_allclose(law.cdf(x), cut.cdf(x), rtol=1e-11)
    assert law.mean() == pytest.approx(cut.mean(), rel=1e-12)
    assert law.cut_weight == pytest.approx(stats.norm.sf(5.0), rel=1e-10) and law.onset_power == 0.0
    half = origins.mixture([given, cut], [0.5, 0.5])
    assert half.cut_weight == pytest.approx(0.5 * law.cut_weight)
    message = master.solve(origins.Contacts(given), [1.0], 1e-6).message
    assert message.endswith("; a weight of 2.9e-07 of the thresholds at or below x = 0 was cut off")


def test_a_family_may_state_its_density_alone() -> None:
    """Support, a density that need not be normalised, and onset power: the law is that of the closed form."""

    class Rising(origins.Thresholds):
        onset_power = 1.0 / 3.0

        def support(self) -> tuple[float, float]:
            return 0.0, np.inf

        def _log_weight(self, x: np.ndarray) -> np.ndarray:
            with np.errstate(divide="ignore"):
                return np.log(x) / 3.0 - x ** (4.0 / 3.0) + 5.0

    law, closed = Rising(), origins.gw_elastic(1.0)
    upper = closed.isf(10.0 ** -np.arange(0.1, 300.0, 13.0))
    lower = closed.ppf(10.0 ** -np.arange(0.1, 60.0, 7.0))
    for x in (upper, lower):
        np.testing.assert_allclose(law.sf(x), closed.sf(x), rtol=1e-12)
        np.testing.assert_allclose(law.cdf(x), closed.cdf(x), rtol=1e-12)
        np.testing.assert_allclose(law.logpdf(x), closed.logpdf(x), rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(law.logsf([1e3, 1e5]), closed.logsf([1e3, 1e5]), rtol=1e-14)
    np.testing.assert_allclose(law.isf(closed.sf(upper)), upper, rtol=1e-12)
    np.testing.assert_allclose(law.ppf(closed.cdf(lower)), lower, rtol=1e-12)
    for n in (1, 2, 3, 4):
        assert law.moment(n) == pytest.approx(closed.moment(n), rel=1e-12)
    assert law.std() == pytest.approx(closed.std(), rel=1e-12)


def test_survival_is_finite_where_rounding_hides_the_tail() -> None:
    """Its logarithm was once infinite there."""

    class Difference(origins.Thresholds):
        def support(self) -> tuple[float, float]:
            return 0.0, np.inf

        def _log_weight(self, x: np.ndarray) -> np.ndarray:
            return 1000.0 * x - 1001.0 * x

    x = np.geomspace(1e15, 1e18, 200)
    np.testing.assert_allclose(Difference().logsf(x), -x, rtol=1e-11)


class Triangle(origins.Thresholds):
    """A density that is a power of x up to its peak at 0.3, and falls to 0 at 1."""

    onset_power = 1.0
    breakpoints = np.array([0.0, 0.3, 1.0])

    def support(self) -> tuple[float, float]:
        return 0.0, 1.0

    def _log_weight(self, x: np.ndarray) -> np.ndarray:
        with np.errstate(divide="ignore"):
            return np.log(np.minimum(x / 0.3, (1.0 - x) / 0.7))


def test_moments_of_a_density_that_is_a_power_up_to_a_bend() -> None:
    law = Triangle()
    assert law.mean() == pytest.approx(1.3 / 3.0, rel=1e-13)
    assert law.std() ** 2 == pytest.approx((1.0 + 0.09 - 0.3) / 18.0, rel=1e-12)


# -- averages over a parameter, such as the orientation of grains ----------------------------------


def test_averages_of_a_closed_form() -> None:
    """Rayleigh laws of rates from 1 to 3, equally many of each, and as many as the rate says."""
    x = np.linspace(0.05, 4.0, 50)
    first, last = np.exp(-x * x), np.exp(-3.0 * x * x)
    even = (first - last) / (2.0 * x * x)
    rising = ((1.0 + x * x) * first - (1.0 + 3.0 * x * x) * last) / (4.0 * x**4)
    for density, known, loss in ((None, even, 1e-10), (lambda rate: rate, rising, 1e-9)):
        law = origins.continuous_mixture(origins.gw_plastic, 1.0, 3.0, density=density)
        assert np.abs(law.sf(x) - known).max() < loss and law.quadrature_error <= 1e-10
        assert law.weights.sum() == pytest.approx(1.0, abs=1e-14)
    frozen = origins.continuous_mixture(lambda rate: stats.expon(scale=1.0 / rate), 1.0, 2.0)
    assert frozen.sf(1.0) == pytest.approx(np.exp(-1.0) - np.exp(-2.0), abs=1e-10)


def test_low_quantiles_of_a_narrow_gaussian_are_told_without_a_warning() -> None:
    """Its density at 0 underflows."""
    below = np.array([1e-305, 1e-300, 1e-30])
    exact = 1.0 + 0.02 * stats.norm.ppf(below)
    np.testing.assert_allclose(origins.gaussian(1.0, 0.02).ppf(below), exact, rtol=1e-12)


@pytest.mark.parametrize("law", [*FAR, stats.mielke(2.0, 1.5), stats.invgauss(0.3, scale=1e9)])
def test_quantiles_where_scipy_has_no_survival_far_out(law: Any) -> None:
    """Their sf is NaN or 1 beyond some place; quantiles once ran off to it, and no contact broke."""
    found, q = origins.Contacts(law).thresholds, np.array([0.9, 0.5, 0.1, 1e-4])
    np.testing.assert_allclose(found.isf(q), law.isf(q), rtol=1e-10)
    assert not np.isnan(found.logsf(law.mean() * np.geomspace(1e-3, 1e200, 60))).any()
