"""What all thresholds share: shapes, ends, NaN, refusals; frozen scipy.stats distributions as thresholds."""

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

LAWS = {
    "identical": origins.identical(1.0),
    "gaussian": origins.gaussian(1.0, 0.05),
    "gaussian below 0": origins.gaussian(-2.0, 0.5),
    "chord": origins.gaussian(1.0, 0.3, form="paper", upper=4.0),
    "rectangular": origins.rectangular(0.5, 1.5),
    "gw_elastic": origins.gw_elastic(1.0),
    "gw_plastic": origins.gw_plastic(1.0),
    "lubricated": origins.lubricated(1.0),
    "generalised gamma": origins.lubricated(1.0, power=0.5, decay=1.5),
    "grains": origins.grains(1.0, B=1.0),
    "grains, printed": origins.grains(1.0, B=1.0, jacobian="paper"),
    "sliding grains": origins.GrainContact(origins.GrainGrowth(alpha=1.0, B=1.0)).breaking(velocity=0.5),
    "all orientations": origins.continuous_mixture(lambda s: origins.grains(1.0, B=1.0 + s), 0.0, 1.0, accuracy=1e-6),
    "persson": origins.persson(1.0, 0.5),
    "persson at 0": origins.persson(0.0, 1.0),
    "mixture": origins.mixture([origins.identical(0.2), origins.gaussian(1.0, 0.1)], [0.5, 0.5]),
    "from_samples": origins.from_samples(np.linspace(0.3, 2.0, 50)),
    "frozen": as_thresholds(stats.gamma(2.5)),
    "frozen, two ends": as_thresholds(stats.beta(0.5, 0.5)),
}
FUNCTIONS = ("pdf", "logpdf", "cdf", "sf", "logsf")
QUANTILES = ("ppf", "isf")


@pytest.fixture(params=LAWS)
def law(request: pytest.FixtureRequest) -> origins.Thresholds:
    return LAWS[request.param]


@pytest.mark.parametrize("name", FUNCTIONS + QUANTILES)
def test_shapes_are_scipys(law: origins.Thresholds, name: str) -> None:
    function, twin = getattr(law, name), getattr(stats.norm(1.0, 0.1), name)
    for x in (0.5, [0.5], np.full((2, 3), 0.5), np.empty(0), np.empty((0, 2)), np.array(0.5), 1, np.float32(0.5)):
        found = function(x)
        assert np.shape(found) == np.shape(twin(x)) and np.asarray(found).dtype == float
    assert isinstance(function(0.5), float)
    grid = np.array([[0.1, 0.9], [0.4, 0.6]])
    assert (function(grid) == [[function(0.1), function(0.9)], [function(0.4), function(0.6)]]).all()


def test_outside_the_support(law: origins.Thresholds) -> None:
    lower, upper = law.support()
    below = np.array([-np.inf, -1e300, -1.0, np.nextafter(lower, -1.0)])
    assert law.pdf(below).tolist() == [0.0] * 4 and law.logpdf(below).tolist() == [-np.inf] * 4
    assert law.cdf(below).tolist() == [0.0] * 4 and law.sf(below).tolist() == [1.0] * 4
    assert law.logsf(below).tolist() == [0.0] * 4
    above = np.array([1e300, np.inf])
    assert law.pdf(above).tolist() == [0.0, 0.0] and law.cdf(above).tolist() == [1.0, 1.0]
    assert law.sf(above).tolist() == [0.0, 0.0] and (law.logsf(above) < -1e20).all() and law.logsf(np.inf) == -np.inf
    for name in FUNCTIONS:
        assert np.isnan(getattr(law, name)(np.nan)) and np.isnan(getattr(law, name)([0.5, np.nan])).tolist() == [
            False,
            True,
        ]
    assert law.cdf(upper) == 1.0 and law.sf(upper) == 0.0


def test_ends_of_the_quantiles(law: origins.Thresholds) -> None:
    lower, upper = law.support()
    assert law.ppf(0.0) == lower == law.isf(1.0) and law.ppf(1.0) == upper == law.isf(0.0)
    for name in QUANTILES:
        for bad in (-0.1, 1.1, np.nan, [0.5, 2.0]):
            with pytest.raises(InputError, match="q = "):
                getattr(law, name)(bad)
    tiny = 1e-300
    assert lower <= law.ppf(tiny) <= law.ppf(0.5) <= law.isf(tiny) <= upper and np.isfinite(law.isf(tiny))


def test_moments_and_samples(law: origins.Thresholds) -> None:
    assert law.moment(0) == 1.0 and law.moment(1) == law.mean()
    assert law.moment(2) == pytest.approx(law.mean() ** 2 + law.std() ** 2, rel=1e-12)
    for bad in (-1, 1.0, True, "2"):
        with pytest.raises(InputError, match="n = "):
            law.moment(bad)  # type: ignore[arg-type]
    assert np.ndim(law.rvs()) == 0 and law.rvs(3).shape == (3,) and law.rvs((2, 3)).shape == (2, 3)
    assert law.rvs(0).shape == (0,)
    assert (law.rvs(5, random_state=3) == law.rvs(5, random_state=3)).all()
    assert law.rvs(2000, random_state=1).mean() == pytest.approx(
        law.mean(), abs=5.0 * law.std() / np.sqrt(2000) + 1e-12
    )


def test_densities_at_the_ends() -> None:
    """The limit from inside, as scipy has it."""
    assert origins.gaussian(0.0, 1.0).pdf(0.0) == pytest.approx(np.sqrt(2.0 / np.pi), rel=1e-15)
    assert origins.rectangular(1.0, 3.0).pdf([1.0, 3.0]).tolist() == [0.5, 0.5]
    for law in (origins.gw_elastic(1.0), origins.lubricated(1.0), origins.persson(1.0, 1.0)):
        assert law.pdf(0.0) == 0.0 and law.logpdf(0.0) == -np.inf
    assert as_thresholds(stats.gamma(0.3)).pdf(0.0) == np.inf


def test_logarithms_where_the_survival_underflows() -> None:
    x = 1e3
    assert origins.gw_elastic(1.0).logsf(x) == pytest.approx(-1e4, rel=1e-12)
    assert origins.lubricated(1.0).logsf(x) == pytest.approx(np.log1p(1e6) - 1e6, rel=1e-12)
    assert origins.persson(1.0, 1.0).logsf(x) == pytest.approx(-((1e6 - 1.0) ** 2), rel=1e-10)
    assert origins.gaussian(1.0, 1.0).logsf(x) == pytest.approx(stats.norm(1.0, 1.0).logsf(x), rel=1e-6)
    both = origins.mixture([origins.gw_elastic(1.0), origins.gw_plastic(1.0)], [0.25, 0.75])
    assert both.logsf(x) == pytest.approx(np.log(0.25) - 1e4, rel=1e-12)


FROZEN = {
    "truncnorm": (stats.truncnorm(-2.0, 3.0, loc=1.0, scale=0.4), 0.0),
    "weibull_min": (stats.weibull_min(1.7), 0.7),
    "weibull_min, shifted": (stats.weibull_min(1.7, loc=1.0, scale=0.1), 0.7),
    "gamma 0.3": (stats.gamma(0.3), -0.7),
    "gamma 3.3": (stats.gamma(3.3, scale=1e-9), 2.3),
    "arcsine": (stats.beta(0.5, 0.5), -0.5),
    "lomax": (stats.lomax(2.5), 0.0),
    "lognorm": (stats.lognorm(0.5), np.inf),
    "inverse gamma": (stats.invgamma(4.0), np.inf),
    "uniform": (stats.uniform(1.0, 2.0), 0.0),
    "triangle": (stats.triang(0.3), 1.0),
    "norm": (stats.norm(1.0, 0.05), 0.0),
    "expon": (stats.expon(scale=1e9), 0.0),
    "histogram": (stats.rv_histogram((np.array([1.0, 3.0]), np.array([0.0, 1.0, 2.0])), density=False), 0.0),
}


@pytest.mark.parametrize("name", FROZEN)
def test_frozen_distributions(name: str) -> None:
    frozen, power = FROZEN[name]
    law = as_thresholds(frozen)
    assert as_thresholds(law) is law
    q = np.array([1e-12, 1e-3, 0.2, 0.5, 0.9, 0.999])
    x = frozen.ppf(q)
    for function in FUNCTIONS:
        np.testing.assert_allclose(getattr(law, function)(x), getattr(frozen, function)(x), rtol=1e-8, atol=1e-15)
    for quantile in QUANTILES:
        np.testing.assert_allclose(getattr(law, quantile)(q[1:]), getattr(frozen, quantile)(q[1:]), rtol=1e-15)
        # where scipy's own quantile does not fit its cdf, as in some far tails, it is found again from that
        np.testing.assert_allclose(getattr(law, quantile)(q[0]), getattr(frozen, quantile)(q[0]), rtol=1e-10)
    np.testing.assert_allclose(law.logsf(x), np.log1p(-frozen.cdf(x)), rtol=1e-9)
    assert law.mean() == frozen.mean() and law.std() == pytest.approx(frozen.std(), rel=1e-14)
    assert law.moment(2) == pytest.approx(frozen.moment(2), rel=1e-14, nan_ok=True)
    lower, upper = frozen.support()
    assert law.support() == (max(lower, 0.0), upper) and law.breakpoints[0] == max(lower, 0.0)
    assert law.atoms[0].size == 0 and law.onset_power == pytest.approx(power, abs=1e-5)
    assert stats.kstest(law.rvs(2000, random_state=4), frozen.cdf).pvalue > 1e-3


NEWER = {
    "Normal": (stats.Normal(mu=1.0, sigma=0.05), stats.norm(1.0, 0.05), 0.0),
    "truncated": (stats.truncate(stats.Normal(mu=1.0, sigma=0.5), 0.5, 2.0), stats.truncnorm(-1, 2, 1, 0.5), 0.0),
    "made of gamma": (stats.make_distribution(stats.gamma)(a=2.5), stats.gamma(2.5), 1.5),
    "made of lomax": (stats.make_distribution(stats.lomax)(c=2.5), stats.lomax(2.5), 0.0),
}


@pytest.mark.parametrize("name", NEWER)
def test_the_newer_interface_of_scipy(name: str) -> None:
    """The same law as the frozen twin, in both tails, from its density alone."""
    given, twin, power = NEWER[name]
    law = origins.Contacts(given).thresholds
    upper, lower = twin.isf(10.0 ** -np.array([0.02, 0.3, 2, 9, 14])), twin.ppf(10.0 ** -np.array([0.3, 2, 9, 14]))
    rounded = 1e-16 if name == "truncated" else 0.0  # of the twin, near the ends: differences of the normal law's
    np.testing.assert_allclose(law.sf(upper), twin.sf(upper), rtol=1e-10, atol=rounded)
    np.testing.assert_allclose(law.cdf(lower), twin.cdf(lower), rtol=1e-10, atol=rounded)
    np.testing.assert_allclose(law.isf([0.9, 1e-3]), twin.isf([0.9, 1e-3]), rtol=1e-12)
    assert law.mean() == pytest.approx(twin.mean(), rel=1e-12) and law.std() == pytest.approx(twin.std(), rel=1e-10)
    assert law.onset_power == pytest.approx(power, abs=1e-5) and law.support()[1] == twin.support()[1]
    assert np.isinf(law.moment(3)) == (name == "made of lomax")


@pytest.mark.parametrize("given", [stats.norm(5.0, 1.0), stats.Normal(mu=5.0, sigma=1.0)], ids=["frozen", "newer"])
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


def test_starts_of_the_newer_interface() -> None:
    x = np.linspace(-0.1, 0.1, 5)
    start = origins.Contacts(origins.gaussian(1.0, 0.05), start=stats.Normal(mu=0.0, sigma=0.025)).start
    np.testing.assert_allclose(start.sf(x), stats.norm(0.0, 0.025).sf(x), rtol=1e-12)
    assert start.mean() == 0.0


class Incomplete:
    """Has a density and nothing else."""

    def pdf(self, x: float) -> float:
        return x


@pytest.mark.parametrize(
    "bad, says",
    [
        (stats.halfcauchy(), "the mean is inf"),
        (stats.pareto(0.9), "the mean is inf"),
        (stats.norm(0.0, 1.0), "weight 0.5 at or below x = 0"),
        (stats.norm(-5.0, 1.0), "weight 1 at or below x = 0"),
        (stats.uniform(-2.0, 1.0), "weight 1 at or below x = 0"),
        (stats.norm([1.0, 2.0], 0.1), "arrays as parameters"),
        (stats.gamma, "lacks its parameters"),
        (stats.gamma(-1.0), "no valid support"),
        (stats.norm(4.0, 1.0), "weight 3.17e-05 at or below x = 0"),
        (stats.Normal(mu=0.0, sigma=1.0), "weight 0.5 at or below x = 0"),
        (stats.Normal(mu=[1.0, 2.0], sigma=0.1), "arrays as parameters"),
        (stats.Binomial(n=3, p=0.5), "must come from origins"),
        (stats.poisson(3.0), "must come from origins"),
        (stats.multivariate_normal([1.0, 2.0]), "must come from origins"),
        (Incomplete(), "must come from origins"),
        (1.0, "must come from origins"),
        (None, "must come from origins"),
        ("gaussian", "must come from origins"),
    ],
)
def test_bad_laws_are_refused(bad: object, says: str) -> None:
    with pytest.raises(InputError) as refusal:
        origins.Contacts(thresholds=bad)
    assert str(refusal.value).startswith("thresholds") and says in str(refusal.value) and "\n" not in str(refusal.value)


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

    class Exponential(origins.Thresholds):
        def support(self) -> tuple[float, float]:
            return 2.0, np.inf

        def _logpdf(self, x: np.ndarray) -> np.ndarray:
            return -(x - 2.0) / 1e-3 - np.log(1e-3)

        def _cdf(self, x: np.ndarray) -> np.ndarray:
            return -np.expm1(-(x - 2.0) / 1e-3)

        def _sf(self, x: np.ndarray) -> np.ndarray:
            return np.exp(-(x - 2.0) / 1e-3)

    tail = Exponential()
    np.testing.assert_allclose(tail.isf(q), 2.0 - 1e-3 * np.log(q), rtol=1e-15)
    assert tail.mean() == pytest.approx(2.001, rel=1e-14) and tail.std() == pytest.approx(1e-3, rel=1e-9)


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
    upper, lower = closed.isf(10.0 ** -np.arange(0.1, 300.0, 13.0)), closed.ppf(10.0 ** -np.arange(0.1, 60.0, 7.0))
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
    class Wrong(origins.Thresholds):
        def support(self) -> tuple[float, float]:
            return 0.0, 1.0

        def _pdf(self, x: np.ndarray) -> np.ndarray:
            return np.ones_like(x)

        def _sf(self, x: np.ndarray) -> np.ndarray:
            return 1.2 - x

    class Half(origins.Thresholds):
        def support(self) -> tuple[float, float]:
            return 0.0, 1.0

        def _pdf(self, x: np.ndarray) -> np.ndarray:
            return np.full_like(x, 0.5)

    with pytest.raises(InputError, match=r"Half: its density adds up to 0.5, not to 1; state it as _log_weight"):
        Half().sf(0.5)

    class Nothing(origins.Thresholds):
        def support(self) -> tuple[float, float]:
            return 0.0, 1.0

    with pytest.raises(InputError, match=r"Wrong: its survival at x = 0.1 is 1.1, outside 0 to 1"):
        Wrong().sf([0.5, 0.1])
    with pytest.raises(InputError, match="Wrong: its survival at x = "):
        origins.Contacts(Wrong())
    with pytest.raises(NotImplementedError, match="Nothing: state _log_weight, _logpdf or _pdf"):
        Nothing().sf(0.5)


def test_importing_origins_is_light() -> None:
    """numpy and scipy.special; the rest of scipy stays away, also when the families are built and used."""
    code = (
        "import sys, origins\n"
        "laws = [origins.gaussian(1.0, 0.1, form='paper', upper=3.0), origins.persson(1.0, 0.5),\n"
        "        origins.from_samples([0.5, 1.0, 1.5, 1.7])]\n"
        "law = origins.mixture(laws, [0.5, 0.25, 0.25])\n"
        "law.isf(law.sf([0.5, 1.0])); law.std(); law.rvs(3)\n"
        "rooms = ('stats', 'interpolate', 'optimize', 'integrate', 'linalg', 'sparse', 'signal')\n"
        "heavy = ['scipy.' + room for room in rooms]\n"
        "heavy += ['numba', 'ase', 'matplotlib', 'mpi4py', 'h5py', 'SurfaceTopography']\n"
        "print([module for module in heavy if module in sys.modules])\n"
    )
    root = Path(__file__).parent.parent
    found = subprocess.run([sys.executable, "-c", code], cwd=root, capture_output=True, text=True, timeout=HANGS)
    assert found.stdout.strip() == "[]", found.stderr
