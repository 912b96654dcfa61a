"""Few samples far from all others, rounded or not: they keep their weight, and the others their law."""

import numpy as np
import pytest
from counted_calls import CountedCalls

import origins
from origins.samples.smoothing import _one_piece
from toolkit.judge.describe import describe

OUTLIERS = {"far": [25.0, 25.0, 60.0], "near": [8.0, 9.0, 15.0, 20.0], "six": [12.0, 17.0, 24.0, 31.0, 40.0, 55.0]}


def forces(seed: int, step: float, outliers: list[float], n: int = 300) -> np.ndarray:
    x = np.random.default_rng(seed).gamma(6.0, 0.2, n)
    x = np.round(x / step) * step if step else x
    return np.append(x[x > 0.0], outliers)


def sampling_error(x: np.ndarray) -> float:
    """Of <x^2>/2<x>."""
    return float(np.std(x**2 - (x**2).mean() * x / x.mean()) / (2.0 * x.mean() * np.sqrt(x.size)))


@pytest.mark.parametrize("step", [0.0, 0.01, 0.1])
@pytest.mark.parametrize("where", OUTLIERS)
@pytest.mark.parametrize("turned", [{"stiffness": 1.0}, {"coefficient": 1.0}], ids=["linear", "quadratic"])
def test_outliers_leave_the_others_their_law(step: float, where: str, turned: dict[str, float]) -> None:
    far = OUTLIERS[where]
    for seed in range(2):
        f = forces(seed, step, far)
        law = origins.from_samples(f_s=f, **turned)
        x = f if "stiffness" in turned else np.sqrt(f)
        force = law.moment(2) / (2.0 * law.mean())
        assert abs(force - (x**2).mean() / (2.0 * x.mean())) < sampling_error(x)
        assert law.mean() == pytest.approx(x.mean(), rel=1e-8)
        # the gap's middle, and below all samples: as many contacts as there are, and about none
        others = np.sort(x)[: -len(far)]
        middle = 0.5 * (others[-1] + np.sort(x)[-len(far)])
        assert law.sf(middle) * x.size == pytest.approx(len(far), abs=0.6)
        assert law.cdf(0.5 * x.min()) * x.size < 0.6 and law.onset_power >= 0.0
        # rounding alone shifts the empirical cdf by half of the most frequent value
        most = np.unique(x, return_counts=True)[1].max() / x.size
        assert law.cdf_misfit < law.cdf_error + 0.5 * most
        alone = origins.from_samples(others)
        points = np.quantile(others, [0.1, 0.3, 0.5, 0.7, 0.9])
        np.testing.assert_allclose(law.pdf(points) * x.size, alone.pdf(points) * others.size, rtol=0.01)


def test_density_diverges_only_where_samples_pile_up() -> None:
    """Shape decides, not the longest sample: gamma(1/2) begins as x^(-1/2), a law with many decades above does not."""
    piled = [origins.from_samples(np.random.default_rng(seed).gamma(0.5, size=1000)).onset_power for seed in range(5)]
    assert np.mean(piled) == pytest.approx(-0.5, abs=0.05)
    for seed in range(10):
        rng = np.random.default_rng(seed)
        x = np.append(0.3 + np.round(rng.exponential(size=150), 1), 10.0 ** rng.uniform(1.0, 2.5, 40))
        assert origins.from_samples(x).onset_power >= 0.0


@pytest.mark.parametrize("step", [0.0, 0.05])
def test_an_unbroken_tail_is_not_cut(step: float) -> None:
    """One law in one piece, its weight beyond the last sample about that of one."""
    cut = 0
    for seed in range(40):
        x = np.random.default_rng(seed).exponential(size=400)
        x = (np.floor(x / step) + 0.5) * step if step else x
        cut += len(origins.from_samples(x).components) > 1
    assert cut <= 1


def test_outliers_are_described_without_much_work() -> None:
    with CountedCalls() as told:
        found = describe(origins.Contacts(origins.from_samples(f_s=forces(3, 0.1, OUTLIERS["far"]), stiffness=1.0)))
    assert told.number < 12_000_000  # some three million, and two without the outliers
    assert found.numbers["kinetic_force"].value == pytest.approx(5.5, abs=0.2)
    assert found.numbers["kinetic_force"].error < 4.0


def test_one_law_across_the_gaps_does_not_diverge() -> None:
    """Even where no gap is seen: no sample lies below 0.4."""
    for seed in (0, 3):
        f = np.append(np.round(np.random.default_rng(seed).gamma(6.0, 0.2, 300), 1), OUTLIERS["far"])
        x, counts = np.unique(np.sqrt(f), return_counts=True)
        assert _one_piece(x, counts / counts.sum(), float(counts.sum())).law.onset_power >= 0.0
