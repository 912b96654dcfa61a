"""Samples that repeat values: which are exact and which only rounded; and errors that no resample shows."""

import numpy as np
import pytest
from scipy import stats

import master
import origins
from toolkit.judge.describe import describe
from toolkit.scene.interfaces import sampling_errors


@pytest.mark.parametrize("share", [0.5, 0.02])
@pytest.mark.parametrize("value", [0.7, 4.0])
def test_a_repeated_value_is_exact(share: float, value: float) -> None:
    """Among the others or far from them; their law is what it is without."""
    rng = np.random.default_rng(2)
    others, times = rng.weibull(2.0, 3000), round(3000 * share / (1.0 - share))
    law = origins.from_samples(rng.permutation(np.append(others, np.full(times, value))))
    share = times / (3000.0 + times)
    assert law.atoms[0].tolist() == [value] and law.atoms[1][0] == pytest.approx(share, rel=1e-12)
    alone, x = origins.from_samples(others), np.linspace(0.1, 2.5, 40)
    np.testing.assert_allclose(law.pdf(x), (1.0 - share) * alone.pdf(x), rtol=1e-9)
    assert law.cdf_misfit < law.cdf_error and law.onset_power == pytest.approx(
        alone.onset_power, rel=1e-9
    )


@pytest.mark.parametrize(
    "values", [[1.0, 1.5], [1.0, 1.5, 2.0], [1.0, 1.5, 2.2, 2.5], [0.3, 0.7, 1.0, 1.1, 1.45, 1.9]]
)
def test_few_values_are_all_exact(values: list[float]) -> None:
    counts = 20 + 30 * np.arange(len(values))
    law = origins.from_samples(np.repeat(values, counts))
    assert law.atoms[0].tolist() == values and law.smooth_part is None and law.onset_power == np.inf
    np.testing.assert_allclose(law.atoms[1], counts / counts.sum(), rtol=1e-13)
    assert law.cdf_misfit < 1e-15 and law.beyond == (0.0, 0.0)


def test_an_exact_value_among_rounded_ones() -> None:
    x = np.round(np.random.default_rng(3).weibull(2.5, 3000), 2) + 0.005
    law = origins.from_samples(np.append(x, np.full(1000, 0.805)))
    assert law.atoms[0].tolist() == [0.805] and law.atoms[1][0] == pytest.approx(0.25, abs=0.02)


def test_equal_means_to_within_rounding() -> None:
    x = 0.3 * (1.0 + 1e-14 * np.random.default_rng(4).normal(size=100))
    law = origins.from_samples(np.append(x, np.random.default_rng(5).weibull(2.0, 500)))
    assert law.atoms[0] == pytest.approx([0.3], rel=1e-13) and law.atoms[1] == pytest.approx(
        [1.0 / 6.0]
    )


ROUNDED = {
    "hundredths": lambda x: np.round(x, 2) + 0.005,
    "two digits": lambda x: np.array([float(f"{value:.1e}") for value in x]),
    "roots of rounded forces": lambda x: np.sqrt(np.ceil(20.0 * x * x) / 20.0),
    "each ten times": lambda x: np.repeat(x[:300], 10),
    "drawn again": lambda x: np.random.default_rng(5).choice(x, x.size),
}


@pytest.mark.parametrize("how", ROUNDED)
def test_rounded_values_stay_smooth(how: str) -> None:
    x = stats.weibull_min(2.5).rvs(3000, random_state=0) + 1e-6
    assert origins.from_samples(ROUNDED[how](x)).atoms[0].size == 0


def test_barriers_at_listed_angles_are_exact() -> None:
    angles = np.array([0.02, 0.05, 0.1, 0.13])
    few = origins.domains(2.5, sizes=[(9, 8)], angles=angles, stiffness=1.0, samples=400)
    exact = np.sort(origins.triangular_barrier(2.5, 9, 8, angles)) / (2.0 * np.pi)
    assert few.atoms[0] == pytest.approx(exact, rel=1e-9)
    assert few.atoms[1].tolist() == pytest.approx([0.25] * 4)


def test_resampled_exact_values_stay_and_vary_in_weight() -> None:
    law = origins.from_samples(np.repeat([0.7, 1.0, 1.3], [100, 300, 50]))
    weights = np.array([one.atoms[1] for one in origins.bootstrap_laws(law, 24)])
    assert weights.shape == (24, 3)
    expected = np.sqrt(law.atoms[1] * (1.0 - law.atoms[1]) / 450.0)
    np.testing.assert_allclose(weights.std(axis=0, ddof=1), expected, rtol=0.4)


@pytest.mark.slow  # K* of a law of samples takes seconds, that of each resampled law as well
def test_errors_of_the_spring_where_it_is_infinite_or_0(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("toolkit.scene.interfaces.RESAMPLES", 3)
    rng = np.random.default_rng(6)
    jumps = origins.from_samples(np.append(np.full(100, 0.7), rng.weibull(2.0, 300)))
    # the force drops at once, in every law; all else has its error
    errors = sampling_errors(origins.Contacts(jumps))
    assert errors["critical_spring"] == 0.0
    assert all(errors[name] > 0.0 for name in ("mean", "static_to_kinetic"))
    contacts = origins.Contacts(origins.from_samples(rng.gamma(0.5, size=200)))
    assert master.propensity(contacts, 1e-4).critical_spring == 0.0
    found = describe(contacts)
    for name in ("critical_spring", "static_to_kinetic"):
        assert found.numbers[name].error == np.inf
