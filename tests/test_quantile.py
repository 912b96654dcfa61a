"""The quantile table against the laws it was made from."""

from typing import Any

import numpy as np
import pytest
from scipy import stats

import origins
from origins.hot_cells import HOT_MISSING, MOST_PIECES, WHOLE
from origins.quantile import QuantileTable, quantile_table

LAWS: dict[str, Any] = {
    "narrow": lambda: origins.gaussian(mean=1.0, std=1e-3),
    "gaussian": lambda: origins.gaussian(mean=1.0, std=0.05),
    "cut gaussian": lambda: origins.gaussian(mean=1.0, std=0.5),
    "rectangular": lambda: origins.rectangular(0.5, 1.5),
    "onset 1/3": lambda: origins.gw_elastic(1.0),
    "lubricated": lambda: origins.lubricated(1.0),
    "persson": lambda: origins.persson(1.0, 0.3),
    "grains": lambda: origins.grains(2.0, B=1.0),
    "grains, printed": lambda: origins.grains(1.0, B=1.0, jacobian="paper"),
    "gap": lambda: origins.mixture([origins.rectangular(0.2, 0.5), origins.rectangular(1.0, 1.7)], [0.3, 0.7]),
    "even gap": lambda: origins.mixture([origins.rectangular(0.2, 0.5), origins.rectangular(1.0, 1.7)], [0.5, 0.5]),
    "two peaks": lambda: origins.mixture([origins.gaussian(0.95, 0.01), origins.gaussian(1.05, 0.01)], [0.4, 0.6]),
    "two gaps": lambda: origins.mixture([origins.gaussian(m, 0.1) for m in (1.0, 2.5, 4.0)], [0.2, 0.3, 0.5]),
    "two kinds": lambda: origins.mixture([origins.rectangular(0.2, 0.5), origins.gaussian(2.0, 0.1)], [0.3, 0.7]),
    "valley": lambda: origins.mixture([origins.gaussian(1.0, 0.2), origins.gaussian(2.0, 0.2)], [0.5, 0.5]),
    "atom in a gaussian": lambda: origins.mixture([origins.identical(0.95), origins.gaussian(1.05, 0.1)], [0.25, 0.75]),
    "heavy tail": lambda: stats.pareto(1.5),
    "unknown gap": lambda: stats.rv_histogram(
        (np.array([3.0, 0.0, 5.0, 2.0]), np.array([0.1, 0.5, 1.0, 2.0, 2.5])), density=False
    ),
    "singular ends": lambda: stats.beta(0.5, 0.5),
    "samples": lambda: origins.from_samples(np.random.default_rng(0).gamma(3.0, size=1000)),
    "tiny": lambda: origins.gw_elastic(1e12),
    "start": lambda: origins.gaussian_start(mean=-0.1, std=0.025),
}


def _law(name: str) -> Any:
    law = LAWS[name]()
    return law if isinstance(law, origins.Start) else origins.Contacts(law).thresholds


def _probabilities(n: int) -> np.ndarray:
    """Random v in (2^-54, 1/2], most of them in the middle, all octaves reached."""
    generator = np.random.default_rng(5)
    return np.concatenate([0.5 * generator.random(n), 2.0 ** generator.uniform(-54.0, -1.0, n)])


def _off(law: Any, x: np.ndarray, v: np.ndarray, from_above: bool) -> np.ndarray:
    """By how much, relative to v, the tail probability misses v around x; zero where x is v's to the last bits."""
    ulps = 6.0 * np.finfo(float).eps * np.abs(x)
    low, high = (law.sf(x + ulps), law.sf(x - ulps)) if from_above else (law.cdf(x - ulps), law.cdf(x + ulps))
    return np.maximum(np.maximum(low - v, v - high), 0.0) / v


def _hot(table: QuantileTable, v: np.ndarray, from_above: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Values of the hot cells near v, the v of which they are, and where there are none."""
    m = np.clip(np.round(v * WHOLE - 0.5), 0, WHOLE // 2 - 1).astype(np.int64)
    place, t = table.hot.find(WHOLE - 1 - m if from_above else m)
    values = table.hot.value(place, t)
    return values * table.scale, (m + 0.5) / WHOLE, values >= HOT_MISSING


@pytest.mark.parametrize("name", LAWS)
def test_both_layers_keep_their_promise_at_random_points(name: str) -> None:
    law = _law(name)
    table = quantile_table(law)
    v = _probabilities(20_000)
    for from_above in (False, True):
        off = _off(law, table.value(v, from_above), v, from_above)
        # between the ten points of a cell the error may be a little larger than at them
        assert off.max() < 1.3e-6
        values, exact, missing = _hot(table, v, from_above)
        assert _off(law, values[~missing], exact[~missing], from_above).max() < 1.3e-6


@pytest.mark.parametrize("name", LAWS)
def test_few_draws_are_left_to_the_fine_cells(name: str) -> None:
    hot = quantile_table(_law(name)).hot
    place, _ = hot.find(np.random.default_rng(9).integers(0, WHOLE, 1_000_000))
    pieces = hot.ends.size - 1
    tails = pieces * 2.0**-12
    assert (hot.c0[place] == HOT_MISSING).mean() < 1.1 * (hot.missed + tails) and hot.missed < 0.005
    assert 2 <= pieces <= MOST_PIECES and pieces % 2 == 0 and hot.ends[0] == 0 and hot.ends[-1] == WHOLE


@pytest.mark.parametrize(
    ("name", "gaps"), [("gap", [0.3]), ("even gap", [0.5]), ("two gaps", [0.2, 0.5]), ("two peaks", [0.4])]
)
def test_stretches_end_where_no_threshold_lies(name: str, gaps: list[float]) -> None:
    hot = quantile_table(_law(name)).hot
    assert hot.bits == 5
    # an even gap lies between the two sides as it is
    inner = hot.ends[2:-1:2] if name != "even gap" else hot.ends[1:-1]
    assert np.abs(inner / WHOLE - gaps).max() < 1e-5


@pytest.mark.parametrize("name", ["gap", "even gap", "unknown gap"])
def test_no_value_lies_inside_a_gap(name: str) -> None:
    law = _law(name)
    table = quantile_table(law)
    left, right = (0.5, 1.0)
    jump = float(law.cdf(left))
    near = jump * (1.0 + np.concatenate([np.linspace(-1e-3, 1e-3, 20_001), np.linspace(-1e-12, 1e-12, 20_001)]))
    v = np.concatenate([_probabilities(100_000), near[near <= 0.5]])
    for from_above in (False, True):
        values = table.value(v, from_above)
        hot, _, missing = _hot(table, v, from_above)
        for x in (values, hot[~missing]):
            assert not ((x > left * (1 + 1e-15)) & (x < right * (1 - 1e-15))).any()


def test_values_rise_with_probability() -> None:
    for name in LAWS:
        table = quantile_table(_law(name))
        v = np.sort(_probabilities(5_000))
        for from_above, sign in ((False, 1.0), (True, -1.0)):
            values = table.value(v, from_above)
            assert (sign * np.diff(values) >= -1e-6 * np.abs(values[1:])).all()


def test_exact_values_come_out_exact() -> None:
    table = quantile_table(origins.identical(0.7))
    assert (table.value(_probabilities(1000), True) == 0.7).all()
    assert (table.hot.c0[table.hot.c0 < HOT_MISSING] * table.scale == 0.7).all()
    pair = origins.mixture([origins.identical(0.95), origins.identical(1.05)], [0.3, 0.7])
    table = quantile_table(pair)
    v = _probabilities(10_000)
    for from_above in (False, True):
        u = 1.0 - v if from_above else v
        clear = np.abs(u - 0.3) > 1e-15
        values = table.value(v, from_above)
        assert (values[clear] == np.where(u < 0.3, 0.95, 1.05)[clear]).all()
        assert set(values) <= {0.95, 1.05}


def test_a_narrow_law_over_a_nearly_empty_background() -> None:
    parts = [origins.rectangular(1.71, 1.72), origins.gaussian(0.6, 0.0014), stats.gamma(3.5, scale=0.4)]
    law = origins.mixture(parts, [8e-4, 1.0 - 8e-4 - 1e-6, 1e-6])
    # just inside the rectangle's end the density is thousands of times that just outside
    v = float(law.sf(1.72)) * (1.0 + np.array([1e-12, 1e-9, 1e-6, 1e-3, -1e-9, -1e-3]))
    assert np.abs(law.sf(law.isf(v)) / v - 1.0).max() < 1e-10
    table = quantile_table(law)
    assert np.abs(law.sf(table.value(v, True)) / v - 1.0).max() < 1e-6


def test_deep_tail_on_demand() -> None:
    law = origins.gaussian(mean=1.0, std=0.05)
    table = quantile_table(law, deepest=1e-200)
    v = np.array([1e-30, 1e-100, 1e-190])
    assert np.abs(law.sf(table.value(v, True)) / v - 1.0).max() < 1.3e-6


def test_scaling_changes_nothing_but_the_scale() -> None:
    v = _probabilities(1000)
    base = quantile_table(origins.rectangular(0.5, 1.5)).value(v, False)
    for factor in (1e-9, 1e9):
        scaled = quantile_table(origins.rectangular(0.5 * factor, 1.5 * factor)).value(v, False)
        assert np.abs(scaled / (factor * base) - 1.0).max() < 1e-14


class _Careless(origins.Thresholds):
    """Exponential thresholds whose inverse is wrong by a part in 10^4."""

    def support(self) -> tuple[float, float]:
        return 0.0, np.inf

    def _cdf(self, x: np.ndarray) -> np.ndarray:
        return -np.expm1(-x)

    def _sf(self, x: np.ndarray) -> np.ndarray:
        return np.exp(-x)

    def _pdf(self, x: np.ndarray) -> np.ndarray:
        return np.exp(-x)

    def _ppf(self, q: np.ndarray) -> np.ndarray:
        return -np.log1p(-q) * (1.0 + 1e-4)

    def _isf(self, q: np.ndarray) -> np.ndarray:
        return -np.log(q)


def test_a_law_that_cannot_be_certified_is_refused() -> None:
    with pytest.raises(origins.InputError, match="thresholds: the quantiles cannot be tabulated"):
        quantile_table(_Careless())


@pytest.mark.parametrize("law", [origins.lubricated(1.0, power=-0.95), stats.gamma(0.01), stats.gamma(0.05, 0, 1e-9)])
def test_weight_where_numbers_end_is_refused_at_once(law: object) -> None:
    contacts = origins.Contacts(law)
    with pytest.raises(origins.InputError, match=r"^thresholds: a weight of .* lies below 1e-300 of a typical value"):
        quantile_table(contacts.thresholds)
    quantile_table(origins.lubricated(1.0, power=-0.93))
