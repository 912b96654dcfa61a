"""Thresholds from samples: against the law drawn from, exact where that is possible; sampling errors; scenes."""

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import slow
from scenes import scene
from scipy import stats

import master
import origins
import toolkit
from origins import Contacts, InputError
from toolkit.scene.tables import to_toml

LAWS = {
    "weibull 2.5": stats.weibull_min(2.5),
    "gaussian": stats.norm(1.0, 0.05),
    "gamma": stats.gamma(3.0),
    "rectangular": stats.uniform(0.5, 1.0),
    "exponential": stats.expon(),
}


def draws(name: str, n: int, seed: int = 0) -> np.ndarray:
    return LAWS[name].rvs(n, random_state=seed)


def test_forces_and_springs_are_near_those_of_the_law_drawn_from() -> None:
    """Wiggles of the density come out as instability: 0.05 too much for interpolated quantiles, of 0.115."""
    truth, law = (
        Contacts(one)
        for one in (LAWS["weibull 2.5"], origins.from_samples(draws("weibull 2.5", 20_000)))
    )
    springs = [master.propensity(contacts, 1e-6).critical_spring for contacts in (truth, law)]
    forces = [master.steady_state(contacts).force for contacts in (truth, law)]
    assert abs(springs[1] - springs[0]) < 0.025 and forces[1] == pytest.approx(forces[0], rel=0.01)


@pytest.mark.parametrize("values", [[1.0, 1.3, 0.7], [0.7, 1.0, 1.31]])
def test_a_few_values_are_one_peak_and_not_one_each(values: list[float]) -> None:
    """A peak at each of three values is the likeliest density, and K* of such laws takes minutes."""
    law = origins.from_samples(values)
    between = law.pdf(np.linspace(min(values), max(values), 101))
    assert between.min() > 0.3 * between.max() and np.std(values) < law.std() < 2.0 * np.std(values)


def test_how_it_begins_and_ends() -> None:
    """A power where the samples show one, a finite value at 0, or an edge; no weight beyond edges."""
    power = origins.from_samples(draws("weibull 2.5", 30_000))
    assert power.onset_power == pytest.approx(1.5, abs=3.0 * power.onset_power_error)
    assert power.pdf(0.0) == 0.0
    assert 0.0 < power.onset_power_error < 0.3 and power.support() == (0.0, np.inf)
    flat = origins.from_samples(draws("exponential", 5000))
    assert flat.onset_power == 0.0 < flat.onset_power_error < 0.2
    assert flat.pdf(0.0) == pytest.approx(1.0, abs=0.05)
    far = origins.from_samples(draws("gaussian", 1000))
    assert far.onset_power == 0.0 and far.onset_power_error == np.inf and far.cdf(0.5) < 1e-6
    samples = draws("rectangular", 2000)
    sharp = origins.from_samples(samples)
    assert sharp.support() == (samples.min(), samples.max()) and sharp.beyond == (0.0, 0.0)
    assert sharp.pdf(sharp.support()).min() > 0.8 and sharp.onset_power == 0.0


@pytest.mark.parametrize("seeds", [range(3), slow(range(3, 6))])
def test_mean_is_the_samples_in_any_unit(seeds: range) -> None:
    """A score equation of the likelihood: the samples' mean is that of the law, of 10 to 3,000 samples."""
    for seed in seeds:
        rng = np.random.default_rng(seed)
        x = rng.lognormal(0.0, rng.uniform(0.05, 2.0), int(10.0 ** rng.uniform(1.0, 3.5)))
        law, scaled = origins.from_samples(x), origins.from_samples(1e-90 * x)
        assert abs(law.mean() - x.mean()) < 1e-6 * x.std() / np.sqrt(x.size)
        q = np.array([1e-6, 0.01, 0.2, 0.5, 0.8, 0.99])
        np.testing.assert_allclose(scaled.isf(q), 1e-90 * law.isf(q), rtol=1e-8)


@pytest.mark.slow  # quick: samples have a sampling error, in test_verdict.py
def test_recovers_the_law_within_the_stated_errors() -> None:
    """The cdf in 95 % of 40 sets, the onset in 68 % and 95 %, less three times what chance takes off."""
    x = np.linspace(0.0, 3.0, 400)
    truth = LAWS["weibull 2.5"].cdf(x)
    laws = [sampled(400, seed) for seed in range(40)]
    assert sum(np.abs(law.cdf(x) - truth).max() <= law.cdf_error for law in laws) >= 36
    assert all(law.cdf_misfit < law.cdf_error for law in laws)
    miss = np.array([abs(law.onset_power - 1.5) / law.onset_power_error for law in laws])
    assert (miss < 1.0).mean() > 0.46 and (miss < 2.0).mean() > 0.84


def test_weights_count_like_repeated_samples() -> None:
    samples, counts = draws("gamma", 200), np.random.default_rng(1).integers(1, 4, 200)
    law = origins.from_samples(samples, weights=0.1 * counts)
    assert law.n_samples == 200
    assert law.effective_samples == pytest.approx(counts.sum() ** 2 / (counts**2).sum())
    assert law.cdf_error == pytest.approx(np.sqrt(np.log(40.0) / (2.0 * law.effective_samples)))
    assert law.mean() == pytest.approx((counts * samples).sum() / counts.sum(), rel=1e-10)
    q = np.array([1e-12, 0.1, 0.9])
    even = origins.from_samples(samples, weights=np.full(200, 7.0))
    plain = origins.from_samples(samples)
    np.testing.assert_allclose(even.isf(q), plain.isf(q), rtol=1e-10)


def test_forces_by_either_law() -> None:
    forces, q = draws("gamma", 50), np.array([1e-6, 0.1, 0.5, 0.9])

    def same(law: origins.Thresholds, lengths: np.ndarray) -> None:
        np.testing.assert_allclose(law.isf(q), origins.from_samples(lengths).isf(q), rtol=1e-12)

    same(origins.from_samples(f_s=forces, coefficient=4.0), np.sqrt(forces) / 2.0)
    same(origins.from_samples(f_s=forces, stiffness=4.0), forces / 4.0)
    each = np.linspace(1.0, 2.0, 50)
    same(origins.from_samples(f_s=forces, stiffness=each), forces / each)
    weighed = origins.from_samples(f_s=forces, stiffness=each.tolist(), weights=each)
    assert weighed.mean() == pytest.approx(forces.sum() / each.sum(), rel=1e-10)


# -- values that repeat ----------------------------------------------------------------------------


@pytest.mark.parametrize(("share", "value"), [(0.02, 0.7), (0.5, 4.0)])
def test_a_repeated_value_is_exact(share: float, value: float) -> None:
    """Among the others or far from them; their law is what it is without."""
    rng = np.random.default_rng(2)
    others, times = rng.weibull(2.0, 3000), round(3000 * share / (1.0 - share))
    law = origins.from_samples(rng.permutation(np.append(others, np.full(times, value))))
    share = times / (3000.0 + times)
    assert law.atoms[0].tolist() == [value] and law.atoms[1][0] == pytest.approx(share, rel=1e-12)
    alone, x = origins.from_samples(others), np.linspace(0.1, 2.5, 40)
    np.testing.assert_allclose(law.pdf(x), (1.0 - share) * alone.pdf(x), rtol=1e-9)
    assert law.cdf_misfit < law.cdf_error
    assert law.onset_power == pytest.approx(alone.onset_power, rel=1e-9)


@pytest.mark.parametrize("values", [[1.0, 1.5], [0.3, 0.7, 1.0, 1.1, 1.45, 1.9]])
def test_few_values_are_all_exact(values: list[float]) -> None:
    counts = 20 + 30 * np.arange(len(values))
    law = origins.from_samples(np.repeat(values, counts))
    assert law.atoms[0].tolist() == values and law.smooth_part is None and law.onset_power == np.inf
    np.testing.assert_allclose(law.atoms[1], counts / counts.sum(), rtol=1e-13)
    assert law.cdf_misfit < 1e-15 and law.beyond == (0.0, 0.0)


ROUNDED = {
    "hundredths": lambda x: np.round(x, 2) + 0.005,
    "roots of rounded forces": lambda x: np.sqrt(np.ceil(20.0 * x * x) / 20.0),
    "each ten times": lambda x: np.repeat(x[:300], 10),
}


@pytest.mark.parametrize("how", ROUNDED)
def test_rounded_values_stay_smooth(how: str) -> None:
    x = stats.weibull_min(2.5).rvs(3000, random_state=0) + 1e-6
    assert origins.from_samples(ROUNDED[how](x)).atoms[0].size == 0


# -- sampling errors -------------------------------------------------------------------------------


@cache
def sampled(n: int, seed: int = 0) -> origins.Thresholds:
    return origins.from_samples(draws("weibull 2.5", n, seed))


@pytest.mark.slow  # quick: samples have a sampling error, in test_verdict.py
def test_errors_are_the_scatter_of_fresh_samples() -> None:
    """Of moments and of the density, which is a curve with its error at each point."""
    x = LAWS["weibull 2.5"].ppf([0.05, 0.5, 0.95])

    def several(law: origins.Thresholds) -> np.ndarray:
        return np.array([law.mean(), law.moment(2) / (2.0 * law.mean()), *law.pdf(x)])

    fresh = np.array([several(sampled(400, seed)) for seed in range(1, 25)])
    found = origins.bootstrap(sampled(400), several, resamples=24)
    assert found.value.shape == found.error.shape == (5,) and found.resampled.shape == (24, 5)
    ratio = found.standard_error / fresh.std(axis=0, ddof=1)
    assert (ratio > 0.55).all() and (ratio < 1.8).all()
    np.testing.assert_allclose(found.bias, found.resampled.mean(axis=0) - found.value, atol=1e-15)
    np.testing.assert_allclose(found.error**2, found.standard_error**2 + found.bias**2, rtol=1e-13)
    np.testing.assert_allclose(found.interval[1] - found.value, 1.96 * found.error, rtol=1e-12)


@pytest.mark.slow  # quick: errors of a law of samples alone
def test_samples_inside_a_mixture_are_drawn_anew() -> None:
    """Errors of a mean: those of the parts, times their weights; laws without samples add none."""
    own, other = sampled(200), origins.from_samples(np.random.default_rng(2).gamma(3.0, size=100))
    inner = origins.mixture([other, origins.gaussian(9.0, 0.1)], [0.5, 0.5])
    law = origins.mixture([own, inner], [0.6, 0.4])
    found = origins.bootstrap(law, lambda law: [law.mean(), law.sf(7.5)], resamples=24)
    expected = np.hypot(0.6 * own.std() / np.sqrt(200.0), 0.2 * other.std() / 10.0)
    assert found.standard_error[0] == pytest.approx(expected, rel=0.4)
    assert found.value[0] == pytest.approx(law.mean()) and found.standard_error[1] < 0.01


# -- samples in scenes -----------------------------------------------------------------------------

SAMPLES = 0.2 + np.random.default_rng(3).weibull(2.5, 100)


def of_file(folder: Path, text: str, **keys: Any) -> origins.Thresholds:
    """The law of a scene's file of samples."""
    (folder / "own.txt").write_text(text, encoding="utf-8")
    law = {"kind": "from-samples", "file": "own.txt", **keys}
    (folder / "scene.toml").write_text(to_toml(scene(law)), encoding="utf-8")
    return toolkit.load_scene(folder / "scene.toml").contacts.thresholds


def test_forces_and_weights_from_a_file(tmp_path: Path) -> None:
    weights = np.linspace(1.0, 3.0, SAMPLES.size)
    lines = "".join(
        f"{force!r},{weight!r}\n" for force, weight in np.stack([SAMPLES, weights], axis=1).tolist()
    )
    law = of_file(tmp_path, lines, quantity="f_s", column=1, weight_column=2, coefficient=2.0)
    own = origins.from_samples(f_s=SAMPLES, coefficient=2.0, weights=weights)
    assert law.mean() == own.mean() and law.sf(0.7) == own.sf(0.7)


@pytest.mark.parametrize(
    ("text", "more", "message"),
    [
        ("1.0\ntwo\n", {}, r"file = 'own\.txt': line 2: x_s must be a number > 0"),
        (
            "1,5\n1,7\n",
            {},
            'a decimal comma. write decimal = ","; two columns',
        ),  # it is not guessed
        ("1 2\n", {"column": 3}, "there is no column 3 of 2"),
        ("1 2\n1 -3\n", {"column": 1, "weight_column": 2}, "line 2: weights must be a number > 0"),
        ("t f\n1 2\n", {}, 'holds 2 columns; say which has x_s, as column = "t" or "f"$'),
        ("# an MD run\nt f\n1 2\n", {}, 'say which has x_s, as column = "t" or "f"$'),
        ("# an MD run\n# t f\n1 2\n", {}, 'say which has x_s, as column = "t" or "f"$'),
        ("1.0\n", {"unit": "furlong"}, '"nm", "pm", "μm", "um", "Å" or "A"'),
        ("t f\n1 2\n", {"column": 3}, 'there is no column 3 of 2, "t" or "f"$'),
        ("1 2\n", {}, "holds 2 columns; say which has x_s, as column = 1 to 2$"),
        ("1 2 3 4 5 6\n", {}, "as column = 1 to 6; or is it another file, as of heights or atoms"),
        ("# nothing\n", {}, "holds no numbers"),
        ("0.9O1\n1.0\n", {}, "line 1: x_s must be a number > 0"),  # and no header
        ("1.0 1\n1.1 2\n", {"column": 1, "weight_column": 1}, "is that of the samples"),
        ("1.0\nnan\n", {"quantity": "f_s"}, "line 2: f_s must be a number > 0"),
        ("1.0\n", {"x_s": [1.0]}, "holds the samples; leave x_s, f_s and weights out"),
    ],
)
def test_bad_files_are_refused(tmp_path: Path, text: str, more: dict, message: str) -> None:
    with pytest.raises(InputError, match=message):
        of_file(tmp_path, text, **more)


@pytest.mark.parametrize(
    "text", ["a;b\n1;1.5\n2;1.7\n", "a b\n1,5 1,5\n1,7 1,7\n", "a,b\n1,1.5\n2,1.7\n"]
)
def test_a_column_under_a_header_with_decimal_points_or_commas(tmp_path: Path, text: str) -> None:
    assert of_file(tmp_path, text, column=2).samples.tolist() == [1.5, 1.7]


def test_the_header_is_the_line_before_the_numbers_that_is_no_comment(tmp_path: Path) -> None:
    """The first line was taken for it, a comment on the file too."""
    for text in ("# an MD run\na b\n1 1.5\n2 1.7\n", "# of MD\n\n# a b\n1 1.5\n2 1.7\n"):
        assert of_file(tmp_path, text, column="b").samples.tolist() == [1.5, 1.7]


def test_a_run_with_samples_says_whose_errors_it_tells() -> None:
    law = {"kind": "from-samples", "x_s": SAMPLES.tolist()}
    scene = {"contacts": {"thresholds": law}, "drive": {"to": 1.0, "points": 3}, "master": {}}
    of_smoothing, note = toolkit.run(scene).notes
    assert of_smoothing.startswith("F_k of the smooth law is ") and note.startswith(
        "errors are numerical only, not those of the samples: "
    )
