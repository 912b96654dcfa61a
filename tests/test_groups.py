"""Samples with far groups and extreme weights: what the law must keep, over many shapes."""

import numpy as np
import pytest
from scipy import stats

import origins
from origins import InputError

SHAPES = {
    "normal": lambda r, n: r.normal(1.0, 10.0 ** r.uniform(-3.0, -0.7), n),
    "weibull": lambda r, n: r.weibull(r.uniform(0.8, 6.0), n),
    "gamma": lambda r, n: r.gamma(r.uniform(0.7, 8.0), size=n),
    "rectangular": lambda r, n: r.uniform(0.5, 1.5, n),
    "student": lambda r, n: np.abs(10.0 + r.standard_t(4, n)) + 1e-3,
    "lognormal": lambda r, n: r.lognormal(0.0, r.uniform(0.1, 2.0), n),
    "two peaks": lambda r, n: np.where(r.random(n) < 0.4, r.normal(1.0, 0.05, n), r.normal(2.5, 0.1, n)),
    "narrow in broad": lambda r, n: np.where(r.random(n) < 0.5, r.normal(1.0, 0.005, n), r.weibull(2.0, n)),
}


def with_far_samples(name: str, seed: int) -> np.ndarray:
    """10 to 3,000 samples; in every other set 1 to 20 more, 3 to 1,000 times beyond the extreme one."""
    rng = np.random.default_rng(seed)
    x = np.abs(SHAPES[name](rng, int(10.0 ** rng.uniform(1.0, 3.5))))
    if seed % 2 == 0:
        return x
    factor = 10.0 ** rng.uniform(0.5, 3.0)
    centre = x.max() * factor if rng.random() < 0.6 else x.min() / factor
    size = int(rng.choice([1, 2, 3, 4, 5, 8, 20]))
    return np.append(x, centre * np.abs(1.0 + rng.uniform(0.0, 0.2) * rng.normal(size=size)))


@pytest.mark.parametrize("name", SHAPES)
def test_the_mean_is_the_samples_for_any_shape(name: str) -> None:
    """To a millionth of its standard error."""
    for seed in range(6):
        x = with_far_samples(name, seed)
        miss = origins.from_samples(x).mean() - x.mean()
        assert abs(miss) < 1e-6 * x.std() / np.sqrt(x.size)


@pytest.mark.parametrize("far", [[5.0], [5.0, 5.1], [4.9, 5.0, 5.1], [4.8, 4.9, 5.0, 5.2], [4.7, 4.9, 5.0, 5.1, 5.3]])
@pytest.mark.parametrize("others", [60, 1000])
def test_a_few_far_samples_keep_their_weight_and_the_rest_its_shape(far: list[float], others: int) -> None:
    rest = np.random.default_rng(0).normal(1.0, 0.05, others)
    law = origins.from_samples(np.append(rest, far))
    weight = len(far) / (others + len(far))
    assert law.sf(3.0) == pytest.approx(weight, rel=1e-6) and law.sf(1.5) == pytest.approx(weight, rel=1e-6)
    alone = origins.from_samples(rest)
    x = np.linspace(0.85, 1.15, 31)
    np.testing.assert_allclose(law.pdf(x), (1.0 - weight) * alone.pdf(x), rtol=1e-9)
    # bells of the main law's relative width, no wider, and the spread of the far samples
    beyond = (law.moment(2) - (1.0 - weight) * alone.moment(2)) / weight - np.mean(far) ** 2
    width = np.mean(far) * alone.std() / alone.mean()
    assert np.var(far) * 0.9 < beyond < np.var(far) + 1.1 * width**2
    assert law.cdf_misfit < law.cdf_error


def test_far_below_and_far_above() -> None:
    x = np.concatenate([[1e-4, 1.1e-4], np.random.default_rng(1).normal(1.0, 0.05, 500), [40.0]])
    law = origins.from_samples(x)
    assert law.cdf(0.01) == pytest.approx(2.0 / 503.0) and law.sf(10.0) == pytest.approx(1.0 / 503.0)
    assert law.onset_power == 0.0 and law.onset_power_error == np.inf


@pytest.mark.parametrize("name", ["exponential", "pareto", "gamma", "rectangular"])
def test_tails_without_a_gap_are_not_cut(name: str) -> None:
    """Exponential and power-law tails have the widest gaps that chance leaves."""
    law = {"exponential": stats.expon(), "pareto": stats.pareto(2.5), "gamma": stats.gamma(3.0),
           "rectangular": stats.uniform(0.5, 1.0)}[name]  # fmt: skip
    cut = [len(origins.from_samples(law.rvs(100, random_state=seed)).components) > 1 for seed in range(25)]
    assert sum(cut) <= 1


# -- weights and scales -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("weights", [[1.0, 1e-300], [1e300, 1e-300], [1e-300, 1e-320]])
def test_a_sample_that_weighs_nothing_is_not_there(weights: list[float]) -> None:
    assert origins.from_samples([1.0, 2.0], weights=weights).support() == (1.0, 1.0)


@pytest.mark.parametrize("decades", [1.0, 5.0, 30.0, 300.0])
def test_weights_over_many_decades(decades: float) -> None:
    rng = np.random.default_rng(7)
    x, weights = rng.weibull(2.0, 300), 10.0 ** (decades * (rng.random(300) - 0.5))
    law = origins.from_samples(x, weights=weights)
    mean = np.average(x, weights=weights / weights.max())
    error = np.sqrt(np.average((x - mean) ** 2, weights=weights / weights.max()) / law.effective_samples)
    assert abs(law.mean() - mean) < 1e-3 * error and law.n_samples == 300


@pytest.mark.parametrize("share", [1e-3, 0.1, 0.5, 0.9, 1.0 - 1e-5])
def test_two_samples_of_any_weights(share: float) -> None:
    law = origins.from_samples([1.0, 2.0], weights=[1.0 - share, share])
    assert law.support() == (1.0, 2.0) and law.mean() == pytest.approx(1.0 + share, rel=1e-12)


@pytest.mark.parametrize("scale", [1e9, 1e-90])
@pytest.mark.parametrize("name", [name for name in SHAPES if name != "narrow in broad"])
def test_scale_of_lengths_and_weights(scale: float, name: str) -> None:
    """Where no two models are equally likely to round-off, as they are for what no few knots can follow."""
    x = with_far_samples(name, 5)
    x = np.append(x, np.full(x.size // 2 + 20, np.median(x)))
    law, scaled = origins.from_samples(x), origins.from_samples(scale * x, weights=np.full(x.size, scale))
    q = np.array([1e-6, 0.01, 0.2, 0.5, 0.8, 0.99, 1.0 - 1e-6])
    np.testing.assert_allclose(scaled.ppf(q), scale * law.ppf(q), rtol=1e-6)
    np.testing.assert_allclose(scaled.atoms[1], law.atoms[1], rtol=1e-12)
    assert scaled.mean() == pytest.approx(scale * law.mean(), rel=1e-8) and scaled.std() > 0.0


@pytest.mark.parametrize(
    "x, begins",
    [
        ([1e300, 1e-300], "x_s[0] = 1e+300: must lie between 1e-100 and 1e+100"),
        ([1.0, 1e-101], "x_s[1] = 1e-101: must lie between"),
        (10.0 ** np.arange(-50.0, 51.0, 5.0), "from_samples: the samples reach from 1e-50 to 1e+50; "),
    ],
)
def test_what_no_density_can_follow_is_refused(x: object, begins: str) -> None:
    with pytest.raises(InputError) as refusal:
        origins.from_samples(x)
    assert str(refusal.value).startswith(begins) and "\n" not in str(refusal.value)
