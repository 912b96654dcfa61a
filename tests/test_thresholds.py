"""Distributions of scipy as thresholds, and what the base class gives to a family of one's own."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import HANGS
from scipy import stats

import master
import origins
from origins import InputError
from origins.thresholds.scipy_laws import as_thresholds


def test_densities_at_the_ends() -> None:
    """The limit from inside, as scipy has it."""
    assert origins.gaussian(0.0, 1.0).pdf(0.0) == pytest.approx(np.sqrt(2.0 / np.pi), rel=1e-15)
    assert origins.rectangular(1.0, 3.0).pdf([1.0, 3.0]).tolist() == [0.5, 0.5]
    for law in (origins.gw_elastic(1.0), origins.lubricated(1.0), origins.persson(1.0, 1.0)):
        assert law.pdf(0.0) == 0.0 and law.logpdf(0.0) == -np.inf
    assert as_thresholds(stats.gamma(0.3)).pdf(0.0) == np.inf


HISTOGRAM = np.array([1.0, 3.0]), np.array([0.0, 1.0, 2.0])
FROZEN = {
    "truncnorm": (stats.truncnorm(-2.0, 3.0, loc=1.0, scale=0.4), 0.0),
    "weibull_min, shifted": (stats.weibull_min(1.7, loc=1.0, scale=0.1), 0.7),
    "gamma 0.3": (stats.gamma(0.3), -0.7),
    "arcsine": (stats.beta(0.5, 0.5), -0.5),
    "lomax": (stats.lomax(2.5), 0.0),
    "lognorm": (stats.lognorm(0.5), np.inf),
    "triangle": (stats.triang(0.3), 1.0),
    "expon": (stats.expon(scale=1e9), 0.0),
    "histogram": (stats.rv_histogram(HISTOGRAM, density=False), 0.0),
}


@pytest.mark.parametrize("name", FROZEN)
def test_frozen_distributions(name: str) -> None:
    frozen, power = FROZEN[name]
    law = as_thresholds(frozen)
    assert as_thresholds(law) is law
    q = np.array([1e-12, 1e-3, 0.2, 0.5, 0.9, 0.999])
    x = frozen.ppf(q)
    for name_of in ("pdf", "logpdf", "cdf", "sf", "logsf"):
        found, known = getattr(law, name_of)(x), getattr(frozen, name_of)(x)
        np.testing.assert_allclose(found, known, rtol=1e-8, atol=1e-15)
    for name_of in ("ppf", "isf"):
        found, known = getattr(law, name_of)(q), getattr(frozen, name_of)(q)
        np.testing.assert_allclose(found[1:], known[1:], rtol=1e-15)
        # where scipy's own quantile does not fit its cdf, as in some far tails, it is found again from that
        np.testing.assert_allclose(found[0], known[0], rtol=1e-10)
    np.testing.assert_allclose(law.logsf(x), np.log1p(-frozen.cdf(x)), rtol=1e-9)
    assert law.mean() == frozen.mean() and law.std() == pytest.approx(frozen.std(), rel=1e-14)
    assert law.moment(2) == pytest.approx(frozen.moment(2), rel=1e-14, nan_ok=True)
    lower, upper = frozen.support()
    assert law.support() == (max(lower, 0.0), upper) and law.breakpoints[0] == max(lower, 0.0)
    assert law.atoms[0].size == 0 and law.onset_power == pytest.approx(power, abs=1e-5)
    assert stats.kstest(law.rvs(2000, random_state=4), frozen.cdf).pvalue > 1e-3


WIDE = stats.Normal(mu=1.0, sigma=0.5)
NEWER = {
    "Normal": (stats.Normal(mu=1.0, sigma=0.05), stats.norm(1.0, 0.05), 0.0),
    "truncated": (stats.truncate(WIDE, 0.5, 2.0), stats.truncnorm(-1, 2, 1, 0.5), 0.0),
    "made of gamma": (stats.make_distribution(stats.gamma)(a=2.5), stats.gamma(2.5), 1.5),
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
    law, cut = as_thresholds(given), origins.gaussian(5.0, 1.0)
    x = np.array([1e-9, 0.01, 1.0, 5.0, 12.0])
    np.testing.assert_allclose(law.sf(x), cut.sf(x), rtol=1e-11)
    np.testing.assert_allclose(law.cdf(x), cut.cdf(x), rtol=1e-11)
    assert law.mean() == pytest.approx(cut.mean(), rel=1e-12)
    assert law.cut_weight == pytest.approx(stats.norm.sf(5.0), rel=1e-10) and law.onset_power == 0.0
    half = origins.mixture([given, cut], [0.5, 0.5])
    assert half.cut_weight == pytest.approx(0.5 * law.cut_weight)
    message = master.solve(origins.Contacts(given), [1.0], 1e-6).message
    assert message.endswith("; a weight of 2.9e-07 of the thresholds at or below x = 0 was cut off")


@pytest.mark.parametrize(
    "bad, says",
    [
        (stats.halfcauchy(), "the mean is inf"),
        (stats.norm(0.0, 1.0), "weight 0.5 at or below x = 0"),
        (stats.uniform(-2.0, 1.0), "weight 1 at or below x = 0"),
        (stats.norm([1.0, 2.0], 0.1), "arrays as parameters"),
        (stats.gamma, "lacks its parameters"),
        (stats.gamma(-1.0), "no valid support"),
        (stats.Normal(mu=0.0, sigma=1.0), "weight 0.5 at or below x = 0"),
        (stats.Binomial(n=3, p=0.5), "must come from origins"),
        (1.0, "must come from origins"),
    ],
)
def test_bad_laws_are_refused(bad: object, says: str) -> None:
    with pytest.raises(InputError) as refusal:
        origins.Contacts(thresholds=bad)
    told = str(refusal.value)
    assert told.startswith("thresholds") and says in told and "\n" not in told


def test_a_family_needs_its_survival_only() -> None:
    """A new law that states support, density, cdf and survival gets the rest from the base class."""

    class Parabola(origins.Thresholds):
        onset_power = 1.0

        def support(self) -> tuple[float, float]:
            return 0.0, 1.0

        def _pdf(self, x: np.ndarray) -> np.ndarray:
            return 2.0 * x

        def _cdf(self, x: np.ndarray) -> np.ndarray:
            return x * x

        def _sf(self, x: np.ndarray) -> np.ndarray:
            return (1.0 - x) * (1.0 + x)

    law = Parabola()
    q = np.array([1e-30, 1e-12, 0.1, 0.5, 0.99])
    np.testing.assert_allclose(law.ppf(q), np.sqrt(q), rtol=1e-14)
    np.testing.assert_allclose(law.isf(q), np.sqrt(1.0 - q), rtol=1e-14)
    np.testing.assert_allclose(law.logsf([1e-9, 0.5]), np.log1p([-1e-18, -0.25]), rtol=1e-14)
    np.testing.assert_allclose(law.logpdf([0.1, 0.5]), np.log([0.2, 1.0]), rtol=1e-14, atol=1e-15)
    assert [law.moment(n) for n in (1, 2, 3)] == pytest.approx([2.0 / 3.0, 0.5, 0.4], rel=1e-14)
    assert law.std() == pytest.approx(np.sqrt(1.0 / 18.0), rel=1e-13)


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


def test_a_family_that_is_no_law_is_told_by_name() -> None:
    class Nothing(origins.Thresholds):
        def support(self) -> tuple[float, float]:
            return 0.0, 1.0

    class Half(Nothing):
        def _pdf(self, x: np.ndarray) -> np.ndarray:
            return np.full_like(x, 0.5)

    class Wrong(Nothing):
        def _pdf(self, x: np.ndarray) -> np.ndarray:
            return np.ones_like(x)

        def _sf(self, x: np.ndarray) -> np.ndarray:
            return 1.2 - x

    refusals = {
        "Wrong: its survival at x = 0.1 is 1.1, outside 0 to 1": lambda: Wrong().sf([0.5, 0.1]),
        "Wrong: its survival at x = ": lambda: origins.Contacts(Wrong()),
        "Half: its density adds up to 0.5, not to 1; state it as _log": lambda: Half().sf(0.5),
    }
    for told, call in refusals.items():
        with pytest.raises(InputError, match=told):
            call()
    with pytest.raises(NotImplementedError, match="Nothing: state _log_weight, _logpdf or _pdf"):
        Nothing().sf(0.5)


def test_importing_origins_is_light() -> None:
    """numpy and scipy.special; the rest of scipy stays away, also when the families are built and used."""
    code = """
import sys, origins
laws = [origins.gaussian(1.0, 0.1, form='paper', upper=3.0), origins.persson(1.0, 0.5),
        origins.from_samples([0.5, 1.0, 1.5, 1.7])]
law = origins.mixture(laws, [0.5, 0.25, 0.25])
law.isf(law.sf([0.5, 1.0])); law.std(); law.rvs(3)
rooms = ('stats', 'interpolate', 'optimize', 'integrate', 'linalg', 'sparse', 'signal')
heavy = {*('scipy.' + room for room in rooms), 'numba', 'ase', 'matplotlib', 'mpi4py', 'h5py'}
print(sorted(heavy & set(sys.modules)))
"""
    root = Path(__file__).parent.parent
    words = [sys.executable, "-c", code]
    found = subprocess.run(words, cwd=root, capture_output=True, text=True, timeout=HANGS)
    assert found.stdout.strip() == "[]", found.stderr
