"""Every family of thresholds against mpmath: densities, both tails, quantiles, moments, samples, scale."""

import numpy as np
import pytest
from references import (
    Reference,
    chord_gaussian,
    gaussian,
    generalised_gamma,
    grains,
    gw_elastic,
    gw_gaussian,
    gw_plastic,
    lubricated,
    mixture,
    mp,
    persson,
    rectangular,
)
from scipy import stats

import origins
from origins import InputError
from origins.thresholds.gaussian_chord import ChordGaussian
from origins.thresholds.quadrature import gauss, panel_edges

EPSILON = np.finfo(float).eps
UPPER = 10.0 ** -np.array([0.02, 0.3, 1, 2, 5, 10, 30, 80, 150, 220, 280])
LOWER = 10.0 ** -np.array([0.05, 0.5, 1, 3, 8, 15, 22, 30])

CASES = {
    "gw_elastic": lambda: gw_elastic(1.0),
    "gw_elastic stiff": lambda: gw_elastic(3.7e11),
    "gw_plastic": lambda: gw_plastic(1.0),
    "gw_plastic soft": lambda: gw_plastic(2.3e-14),
    "gw_gaussian": lambda: gw_gaussian(1.5, 1.0, "paper", "elastic"),
    "gw_gaussian light": lambda: gw_gaussian(40.0, 2e-8, "amontons", "elastic"),
    "gw_gaussian heavy": lambda: gw_gaussian(-3.0, 1.0, "strength", "plastic"),
    "gw_gaussian mixed": lambda: gw_gaussian(0.5, 3e-8, "amontons", "mixed", 9.0),
    "gw_gaussian mixed light": lambda: gw_gaussian(10.0, 1.0, "paper", "mixed", 25.0),
    "rectangular": lambda: rectangular(0.5, 1.5),
    "rectangular from 0": lambda: rectangular(0.0, 2.0),
    "lubricated": lambda: lubricated(1.0),
    "lubricated small": lambda: lubricated(4.1e-9),
    "lubricated, steep": lambda: generalised_gamma(1.3, 5.0, 4.0),
    "lubricated, flat onset": lambda: generalised_gamma(1.0, 0.0, 1.0),
    "lubricated, diverging": lambda: generalised_gamma(2e-9, -0.5, 0.5),
    "lubricated, slow": lambda: generalised_gamma(1.0, -0.5, 0.1),
    "grains": lambda: grains(1.0, 1.0),
    "grains, all but pinning": lambda: grains(2.0 / 3.0 * (1.0 + 1e-6), 1.0),
    "grains, few pinning": lambda: grains(0.7, 3.7e17),
    "grains, many pinning": lambda: grains(2.0, 1e-12),
    "grains, far beyond the film": lambda: grains(1e3, 2.3),
    "persson": lambda: persson(1.0, 0.5),
    "persson broad": lambda: persson(1.0, 1.0),
    "persson light": lambda: persson(0.01, 1.0),
    "persson lightest": lambda: persson(1e-6, 1.0),
    "persson at 0": lambda: persson(0.0, 1.7),
    "persson between": lambda: persson(0.72, 1.0),
    "persson 2": lambda: persson(2.0, 1.0),
    "persson narrow": lambda: persson(1.0, 0.1),
    "persson narrowest": lambda: persson(1.0, 0.01),
    "persson lighter": lambda: persson(1e-3, 1.0),
    "gaussian": lambda: gaussian(1.0, 0.05),
    "gaussian narrow": lambda: gaussian(1.0, 1e-3),
    "gaussian broad": lambda: gaussian(1.0, 0.4),
    "gaussian half": lambda: gaussian(0.0, 1.0),
    "gaussian mostly below": lambda: gaussian(-1.0, 0.5),
    "gaussian far below": lambda: gaussian(-1e4, 1.0),
    "chord": lambda: chord_gaussian(1.0, 0.05, 2.0),
    "chord wide": lambda: chord_gaussian(1.0, 0.3, 5.0),
    "chord short": lambda: chord_gaussian(1.0, 0.3, 1.5),
    "chord flat": lambda: chord_gaussian(1.0, 10.0, 1.5),
    "chord narrow": lambda: chord_gaussian(1.0, 0.01, 3.0),
    "two Gaussians": lambda: mixture([gaussian(0.3, 0.03), gaussian(1.0, 0.05)], [0.3, 0.7]),
    "unequal": lambda: mixture(
        [gw_elastic(1.0), rectangular(2.0, 3.0), persson(1.0, 0.5)], [1e-3, 0.499, 0.5]
    ),
    "rare tail": lambda: mixture([gaussian(1.0, 0.05), gw_elastic(1.0)], [1.0 - 1e-9, 1e-9]),
}


@pytest.fixture(scope="module", params=CASES, ids=str)
def case(request: pytest.FixtureRequest) -> Reference:
    return CASES[request.param]()


def exactly(function, x: np.ndarray) -> np.ndarray:
    return np.array([float(function(mp.mpf(float(value)))) for value in x])


def logarithm(function, x: np.ndarray) -> np.ndarray:
    return np.array([float(mp.log(function(mp.mpf(float(value))))) for value in x])


def end_rounding(law: origins.Thresholds, x: np.ndarray) -> np.ndarray:
    """Relative distance by which an end of the support that is no float moves x, as seen from that end."""
    if not isinstance(law, ChordGaussian):
        return np.zeros(x.shape)
    ends = law.support()
    distance = np.minimum(x - ends[0] if ends[0] > 0.0 else np.inf, ends[1] - x)
    return 4.0 * EPSILON * ends[1] / np.maximum(distance, EPSILON * ends[1])


def assert_close(found: np.ndarray, exact: np.ndarray, relative: float | np.ndarray) -> None:
    assert (np.abs(found - exact) <= relative * np.abs(exact)).all(), (found, exact)


def test_both_tails(case: Reference) -> None:
    """Relative accuracy 1e-10 of the survival down to 1e-280 and of the cdf down to 1e-30."""
    upper, lower = case.law.isf(UPPER), case.law.ppf(LOWER)
    ends = case.law.support()
    upper, lower = upper[upper < ends[1]], lower[lower > ends[0]]
    assert_close(case.law.sf(upper), exactly(case.sf, upper), 1e-10 + end_rounding(case.law, upper))
    assert_close(
        case.law.cdf(lower), exactly(case.cdf, lower), 1e-10 + end_rounding(case.law, lower)
    )
    assert_close(
        case.law.logsf(upper), logarithm(case.sf, upper), 1e-12 + end_rounding(case.law, upper)
    )
    # where the survival is 1 to the last bit its logarithm is still minus the cdf
    assert_close(
        case.law.logsf(lower), logarithm(case.sf, lower), 1e-10 + end_rounding(case.law, lower)
    )


def test_density(case: Reference) -> None:
    x = np.concatenate([case.law.isf(UPPER), case.law.ppf(LOWER)])
    x = x[(x > case.law.support()[0]) & (x < case.law.support()[1])]
    assert_close(case.law.pdf(x), exactly(case.pdf, x), 1e-10 + end_rounding(case.law, x))
    slack = 1e-11 + 1e-12 * np.abs(case.law.logpdf(x)) + end_rounding(case.law, x)
    assert (np.abs(case.law.logpdf(x) - logarithm(case.pdf, x)) <= slack).all()


def test_quantiles(case: Reference) -> None:
    """The float nearest to the exact quantile, but for a few last bits and 1e-10 of the probability."""
    for quantile, function, targets in (
        (case.law.isf, case.sf, UPPER),
        (case.law.ppf, case.cdf, LOWER),
    ):
        x = quantile(targets)
        slack = targets * (1e-10 + end_rounding(case.law, x)) + 4.0 * EPSILON * x * exactly(
            case.pdf, x
        )
        ends = case.law.support()
        # beside an end of the support that is not 0 the nearest float may be the end itself, or two away
        slack += np.where(
            np.minimum(np.abs(x - ends[0]), np.abs(ends[1] - x)) < 8.0 * EPSILON * x, 1e-14, 0.0
        )
        assert (np.abs(exactly(function, x) - targets) <= slack).all()


def test_quantiles_invert_themselves(case: Reference) -> None:
    """isf(sf(x)) and ppf(cdf(x)) return x as far as the probability tells it."""
    x = case.law.isf(np.linspace(0.01, 0.99, 99))
    spread = 8.0 * EPSILON * (1.0 / case.law.pdf(x) + x)
    assert (np.abs(case.law.isf(case.law.sf(x)) - x) <= spread).all()
    assert (np.abs(case.law.ppf(case.law.cdf(x)) - x) <= spread).all()


def test_moments(case: Reference) -> None:
    for n in (1, 2, 3, 4):
        assert case.law.moment(n) == pytest.approx(float(case.moment(n)), rel=1e-10)
    with mp.workdps(40):
        variance = float(case.moment(2) - case.moment(1) ** 2)
    assert case.law.mean() == pytest.approx(float(case.moment(1)), rel=1e-12)
    assert case.law.std() == pytest.approx(np.sqrt(variance), rel=1e-10)


def test_onset_power(case: Reference) -> None:
    """P_c ~ (x - a)^m: the limit of (x - a) P_c / cdf is m + 1."""
    lower = case.law.support()[0]
    if isinstance(case.law, ChordGaussian):
        assert (
            case.law.onset_power == 1.0
        )  # h starts along a straight line; test_density follows it
        return
    with mp.workdps(1300):
        step = (mp.mpf(float(case.law.ppf(0.5))) - lower) * mp.mpf(10) ** -290
        ratio = float(step * case.pdf(lower + step) / case.cdf(lower + step))
    assert case.law.onset_power == pytest.approx(ratio - 1.0, abs=1e-12)


SAMPLED = [
    "gw_elastic",
    "rectangular",
    "lubricated",
    "grains",
    "persson",
    "gaussian broad",
    "chord short",
    "unequal",
]


@pytest.mark.parametrize("name", SAMPLED)
def test_samples(name: str) -> None:
    """Kolmogorov-Smirnov at 1e5 draws, and the count beyond the quantiles of 100; test_draws.py has four million."""
    law = CASES[name]().law
    draws = np.sort(law.rvs(100_000, random_state=11))
    assert draws[0] >= law.support()[0] and draws[-1] <= law.support()[1]
    cdf = law.cdf(draws)
    steps = np.arange(draws.size + 1) / draws.size
    distance = max((cdf - steps[:-1]).max(), (steps[1:] - cdf).max())
    assert distance * np.sqrt(draws.size) < 1.95  # the 0.1 % level
    tail = 100.0 / draws.size
    for beyond in ((draws > law.isf(tail)).sum(), (draws < law.ppf(tail)).sum()):
        assert abs(beyond - 100) < 40
    assert (law.rvs(4, random_state=11) == law.rvs(4, random_state=np.random.default_rng(11))).all()


SCALED = {
    "gw_elastic": lambda s, u: origins.gw_elastic((1.0 + u) * s ** (-4.0 / 3.0)),
    "gw_plastic": lambda s, u: origins.gw_plastic((1.0 + u) * s**-2.0),
    "gw_gaussian": lambda s, u: origins.gw_gaussian(
        6.0 * u - 3.0, s, regime="mixed", plasticity_index=1.0 + 20.0 * u
    ),
    "rectangular": lambda s, u: origins.rectangular(u * s, (u + 0.7) * s),
    "lubricated": lambda s, u: origins.lubricated((0.1 + u) * s),
    "generalised gamma": lambda s, u: origins.lubricated(
        (0.1 + u) * s, power=4.0 * u, decay=1.0 + u
    ),
    "grains": lambda s, u: origins.grains(0.7 + 2.0 * u, B=(1.0 + u) / s**2),
    "grains, printed": lambda s, u: origins.grains(
        0.7 + 2.0 * u, B=(1.0 + u) / s**2, jacobian="paper"
    ),
    "persson": lambda s, u: origins.persson(s, (0.2 + 2.0 * u) * s),
    "gaussian": lambda s, u: origins.gaussian(s, (0.01 + u) * s),
    "gaussian below 0": lambda s, u: origins.gaussian(-s, (0.1 + u) * s),
    "chord": lambda s, u: origins.gaussian(
        s, (0.05 + u) * s, form="paper", upper=(1.2 + 3.0 * u) * s
    ),
    "identical": lambda s, u: origins.identical((1.0 + u) * s),
    "mixture": lambda s, u: origins.mixture(
        [origins.gaussian(s, 0.1 * s), origins.lubricated(s)], [0.5 * u, 1 - 0.5 * u]
    ),
    "from_samples": lambda s, u: origins.from_samples(
        s * np.random.default_rng(3).gamma(1.0 + u, size=300)
    ),
}


@pytest.mark.parametrize("name", SCALED)
def test_scale_changes_nothing_but_the_scale(name: str) -> None:
    for k, u in enumerate(np.random.default_rng(5).random(6)):
        scale = (1e-9, 1e9)[k % 2]
        base, scaled = SCALED[name](1.0, u), SCALED[name](scale, u)
        q = np.array([1e-12, 1e-3, 0.2, 0.5, 0.9])
        x = base.isf(q)
        inside = x < base.support()[1]
        np.testing.assert_allclose(scaled.isf(q), scale * x, rtol=1e-12)
        np.testing.assert_allclose(scaled.ppf(q), scale * base.ppf(q), rtol=1e-12)
        np.testing.assert_allclose(
            scaled.sf(scale * x[inside]), base.sf(x[inside]), rtol=1e-11, atol=4e-16
        )
        np.testing.assert_allclose(
            scaled.pdf(scale * x) * scale, base.pdf(x), rtol=1e-11, atol=1e-15 * base.pdf(x).max()
        )
        np.testing.assert_allclose(scaled.breakpoints, scale * base.breakpoints, rtol=1e-12)
        for n in (1, 2, 3, 4):
            assert scaled.moment(n) / scale**n == pytest.approx(base.moment(n), rel=1e-12)
        assert scaled.std() / scale == pytest.approx(base.std(), rel=1e-12)
        assert scaled.onset_power == pytest.approx(base.onset_power, rel=1e-13)


def random_law(rng: np.random.Generator) -> origins.Thresholds:
    """Any family with parameters over many decades, extremes included."""
    scale, spread = 10.0 ** rng.uniform(-9, 9), 10.0 ** rng.uniform(-3, 1)
    kind = rng.integers(8)
    if kind == 7:
        shares = rng.dirichlet(np.full(3, 0.4)) * 0.97 + 0.01
        return origins.mixture([random_law(rng) for _ in range(3)], shares / shares.sum())
    return (
        lambda: origins.gw_elastic(scale ** (-4.0 / 3.0)),
        lambda: origins.gw_plastic(scale**-2.0),
        lambda: origins.rectangular(scale * rng.choice([0.0, 1.0]), scale * (1.0 + spread)),
        lambda: origins.lubricated(scale),
        lambda: origins.persson(scale, scale * np.sqrt(spread)),
        lambda: origins.gaussian(scale * rng.choice([-1.0, 1.0]), scale * spread),
        lambda: origins.gaussian(
            scale, scale * spread, form="paper", upper=scale * (1.05 + rng.exponential(2.0))
        ),
    )[kind]()


# beyond the first 60: mixtures over up to 18 decades that once cost panels without end, or lost a narrow part
@pytest.mark.parametrize("seed", [*range(60), 60, 140, 154, 208, 258, 338, 425, 659])
def test_random_parameters(seed: int) -> None:
    """Whatever the parameters: complementary, monotone, density the slope, quantiles in place, total weight 1."""
    law = random_law(np.random.default_rng(seed))
    q = np.concatenate([10.0 ** -np.arange(1.0, 280.0, 9.0), np.linspace(0.02, 0.98, 49)])
    x = np.unique(np.concatenate([law.isf(q), law.ppf(q)]))
    cdf, sf = law.cdf(x), law.sf(x)
    np.testing.assert_allclose(cdf + sf, 1.0, atol=4e-15)
    assert (np.diff(cdf) >= -2e-15).all() and (
        np.diff(sf) <= 2e-15
    ).all()  # falls by rounding alone
    inside = (x > law.support()[0]) & (x < law.support()[1])
    np.testing.assert_allclose(np.exp(law.logsf(x[inside])), sf[inside], rtol=1e-12, atol=1e-307)
    np.testing.assert_allclose(
        np.exp(law.logpdf(x[inside])), law.pdf(x[inside]), rtol=1e-12, atol=1e-307
    )
    # the survival at isf(q) is q, to 1e-10 and to what the rounding of x itself changes
    y = law.isf(q)
    slack = 1e-10 * q + 16.0 * EPSILON * np.abs(y) * np.maximum(
        law.pdf(y), law.pdf(y * (1 - 1e-15))
    )
    assert (np.abs(law.sf(y) - q) <= slack).all()
    edges = panel_edges(law)
    nodes, weights = gauss(edges[:-1], edges[1:])
    assert (weights * law.pdf(nodes)).sum() == pytest.approx(1.0, abs=1e-12)
    assert (weights * nodes * law.pdf(nodes)).sum() == pytest.approx(law.mean(), rel=1e-10)


def test_paper_fit_is_one_generalised_gamma() -> None:
    """S = (1 + t) e^-t, t = (x/width)², also where floats hold its logarithm alone; and a Weibull law of order 1."""
    law = origins.lubricated(0.7)
    x = np.append(law.isf(10.0 ** -np.array([0.01, 0.3, 3, 30, 280])), [25.0, 1e3])
    t = (x / 0.7) ** 2
    np.testing.assert_allclose(law.logsf(x), np.log1p(t) - t, rtol=1e-13)
    assert origins.lubricated(0.7, power=1.0).sf(1.0) == pytest.approx(
        np.exp(-1.0 / 0.49), rel=1e-14
    )


def test_persson_limits() -> None:
    """Light load: Weibull 4. Heavy load: a Gaussian of width w^2 / (2 sqrt 2 c)."""
    x = np.linspace(0.05, 2.5, 200)
    np.testing.assert_allclose(origins.persson(1e-9, 1.0).sf(x), np.exp(-(x**4)), rtol=1e-13)
    heavy, width = origins.persson(1.0, 1e-3), 1e-6 / (2.0 * np.sqrt(2.0))
    assert heavy.std() == pytest.approx(width, rel=1e-8)
    assert heavy.sf(1.0 + 2.0 * width) == pytest.approx(stats.norm.sf(2.0), rel=1e-5)


@pytest.mark.parametrize("ratio", [30.0, 1e3, 1e6])
def test_persson_far_narrower_than_its_centre(ratio: float) -> None:
    """Relative 1e-10 down to 1e-280 at any ratio that is taken, and the weight where no node is rounded."""
    exact = persson(1.0, 1.0 / ratio)
    law, spread = exact.law, 1.0 / (2.0 * np.sqrt(2.0) * ratio**2)
    upper, lower = law.isf(UPPER), law.ppf(LOWER)
    assert_close(law.sf(upper), exactly(exact.sf, upper), 1e-10)
    assert_close(law.cdf(lower), exactly(exact.cdf, lower), 1e-10)
    assert_close(law.pdf(upper), exactly(exact.pdf, upper), 1e-10)
    with mp.workdps(40):
        variance = float(exact.moment(2) - exact.moment(1) ** 2)
    assert law.std() == pytest.approx(np.sqrt(variance), rel=1e-10) and law.std() == pytest.approx(
        spread, rel=3e-6
    )
    for n in (1, 2, 3, 4):
        assert law.moment(n) == pytest.approx(float(exact.moment(n)), rel=1e-13)
    # the trapezoidal rule on steps of a power of 2, which are exact, converges faster than any power
    step = 2.0 ** np.floor(np.log2(0.3 * spread))
    x = 1.0 + step * np.arange(-100, 101)
    assert step * law.pdf(x).sum() == pytest.approx(1.0, abs=1e-12)


def test_paper_form_is_the_printed_one() -> None:
    """N {G(x) - G(0) - (x/x_m)[G(x_m) - G(0)]}, 0 at both ends, cut where it falls below 0."""
    law = origins.gaussian(1.0, 0.2, form="paper", upper=2.0)
    x = np.linspace(0.0, 2.0, 101)
    normal = stats.norm(1.0, 0.2).pdf
    printed = normal(x) - normal(0.0) - x / 2.0 * (normal(2.0) - normal(0.0))
    np.testing.assert_allclose(
        law.pdf(x), printed / np.trapezoid(printed, x), rtol=1e-5, atol=1e-12
    )
    assert law.pdf(0.0) == 0.0 and law.pdf(2.0) == pytest.approx(0.0, abs=1e-15)
    cut = origins.gaussian(1.0, 0.3, form="paper", upper=5.0)
    lower, upper = cut.support()
    assert lower == 0.0 and 2.0 < upper < 2.1 and cut.pdf(3.0) == 0.0 and cut.sf(3.0) == 0.0
    assert origins.gaussian(1.0, 0.3, form="paper", upper=1.5).support()[0] == pytest.approx(
        0.254, abs=1e-3
    )


def test_mixture_with_atoms_and_gaps() -> None:
    law = origins.mixture(
        [origins.identical(0.5), origins.rectangular(1.0, 2.0), origins.identical(3.0)],
        [0.25, 0.5, 0.25],
    )
    positions, weights = law.atoms
    assert positions.tolist() == [0.5, 3.0] and weights.tolist() == [0.25, 0.25]
    assert law.support() == (0.5, 3.0) and law.breakpoints.tolist() == [0.5, 1.0, 2.0, 3.0]
    # an atom at the lowest end: the cdf jumps there, and is right-continuous
    assert law.cdf([0.4, 0.5, 0.7, 1.5, 2.5, 3.0]).tolist() == [0.0, 0.25, 0.25, 0.5, 0.75, 1.0]
    assert law.sf([0.4, 0.5, 0.7, 1.5, 2.5, 3.0]).tolist() == [1.0, 0.75, 0.75, 0.5, 0.25, 0.0]
    assert law.logsf(0.5) == pytest.approx(np.log(0.75))
    # the whole of an atom's weight belongs to one value, and a gap is entered from its left end
    assert law.ppf([0.0, 0.1, 0.25, 0.5, 0.75, 0.76, 1.0]).tolist() == [
        0.5,
        0.5,
        0.5,
        1.5,
        2.0,
        3.0,
        3.0,
    ]
    assert law.isf([1.0, 0.9, 0.75, 0.5, 0.25, 0.24, 0.0]).tolist() == [
        0.5,
        0.5,
        0.5,
        1.5,
        2.0,
        3.0,
        3.0,
    ]
    assert law.mean() == pytest.approx(0.25 * 0.5 + 0.5 * 1.5 + 0.25 * 3.0, rel=1e-15)
    assert law.std() ** 2 == pytest.approx(
        0.25 * 0.25 + 0.5 * (2.25 + 1 / 12) + 0.25 * 9.0 - 1.625**2, rel=1e-14
    )
    draws = law.rvs(100_000, random_state=2)
    assert abs((draws == 0.5).mean() - 0.25) < 0.006 and abs((draws == 3.0).mean() - 0.25) < 0.006


def test_mixture_of_mixtures_and_of_scipy() -> None:
    inner = origins.mixture([origins.rectangular(0.0, 1.0), stats.expon()], [0.5, 0.5])
    outer = origins.mixture([inner, origins.gw_plastic(1.0)], [0.5, 0.5])
    x = np.linspace(0.01, 5.0, 50)
    expected = 0.25 * np.maximum(1.0 - x, 0.0) + 0.25 * np.exp(-x) + 0.5 * np.exp(-x * x)
    np.testing.assert_allclose(outer.sf(x), expected, rtol=1e-14)
    assert outer.onset_power == 0.0
    assert (
        origins.mixture(
            [origins.gw_plastic(1.0), origins.rectangular(1.0, 2.0)], [0.5, 0.5]
        ).onset_power
        == 1.0
    )
    assert (
        origins.mixture(
            [origins.identical(0.5), origins.rectangular(1.0, 2.0)], [0.5, 0.5]
        ).onset_power
        == np.inf
    )


BAD = [
    (lambda: origins.identical(0.0), "value = 0.0: "),
    (lambda: origins.gaussian(1.0, -0.1), "std = -0.1: "),
    (lambda: origins.gaussian(1.0, 0.1, upper=2.0), "upper = 2.0: "),
    (lambda: origins.gaussian(1.0, 0.1, form="paper"), "upper = None: "),
    (lambda: origins.gaussian(1.0, 0.1, form="paper", upper=0.9), "mean = 1.0: "),
    (lambda: origins.gaussian(1.0, 0.1, form="chord"), "form = 'chord': "),
    (lambda: origins.rectangular(-1.0, 1.0), "lower = -1.0: "),
    (lambda: origins.rectangular(1.0, 1.0), "upper = 1.0: "),
    (lambda: origins.gw_plastic(True), "B = True: "),
    (
        lambda: origins.lubricated(1.0, power=-1.0),
        "power = -1.0: must be above -1, or P_c has no norm",
    ),
    (lambda: origins.lubricated(1.0, decay=0.0), "decay = 0.0: must lie between 0.1 and 100"),
    (lambda: origins.persson(1.1e6, 1.0), "centre = 1100000.0: is more than 1e+06 widths"),
    (lambda: origins.mixture([], []), "components = []: "),
    (lambda: origins.mixture([origins.identical(1.0)], [0.5, 0.5]), "weights = [0.5, 0.5]: "),
    (lambda: origins.mixture([origins.identical(1.0)] * 2, [0.5, 0.4]), "weights = [0.5, 0.4]: "),
    (lambda: origins.mixture([origins.identical(1.0), 3.0], [0.5, 0.5]), "thresholds = 3.0: "),
]


@pytest.mark.parametrize("call, begins", BAD)
def test_bad_parameters_are_named(call, begins: str) -> None:
    with pytest.raises(InputError) as refusal:
        call()
    assert str(refusal.value).startswith(begins) and "\n" not in str(refusal.value)


@pytest.mark.parametrize(("mean", "std"), [(1.0, 0.4), (0.0, 1.0), (-1.0, 0.5), (1.0, 20.0)])
def test_gaussian_quantiles_next_to_0_keep_their_digits(mean: float, std: float) -> None:
    law, q = origins.gaussian(mean, std), 10.0 ** -np.arange(1.0, 290.0, 7.0)
    np.testing.assert_allclose(law.cdf(law.ppf(q)), q, rtol=1e-14)


def test_generalised_gamma_keeps_its_weight_where_powers_underflow() -> None:
    law = origins.lubricated(1.0, power=-0.99)
    x = np.geomspace(1e-300, 1e-3, 100)
    assert np.allclose(law.sf(x) + law.cdf(x), 1.0, rtol=0.0, atol=2e-15)
    assert (np.diff(law.sf(x)) < 0.0).all() and law.sf(law.isf(0.99)) == pytest.approx(
        0.99, rel=1e-13
    )
