"""The quantile tables against the laws they were made from, and the streams that they are drawn with."""

from typing import Any

import numpy as np
import pytest
from scipy import stats

import origins
from eq_model.draws import quantiles, streams
from eq_model.draws.tables import make_table

LAWS: dict[str, Any] = {
    "narrow": lambda: origins.gaussian(mean=1.0, std=1e-3),
    "gaussian": lambda: origins.gaussian(mean=1.0, std=0.05),
    "cut gaussian": lambda: origins.gaussian(mean=1.0, std=0.5),
    "chord": lambda: origins.gaussian(1.0, 0.05, form="paper", upper=2.0),
    "rectangular": lambda: origins.rectangular(0.5, 1.5),
    "onset 1/3": lambda: origins.gw_elastic(1.0),
    "gw_gaussian mixed": lambda: origins.gw_gaussian(0.5, 1.0, "amontons", "mixed", 9.0),
    "lubricated": lambda: origins.lubricated(1.0),
    "persson": lambda: origins.persson(1.0, 0.3),
    "grains": lambda: origins.grains(2.0, B=1.0),
    "grains, printed": lambda: origins.grains(1.0, B=1.0, jacobian="paper"),
    "gap": lambda: origins.mixture(
        [origins.rectangular(0.2, 0.5), origins.rectangular(1.0, 1.7)], [0.3, 0.7]
    ),
    "two peaks": lambda: origins.mixture(
        [origins.gaussian(0.95, 0.01), origins.gaussian(1.05, 0.01)], [0.4, 0.6]
    ),
    "valley": lambda: origins.mixture(
        [origins.gaussian(1.0, 0.2), origins.gaussian(2.0, 0.2)], [0.5, 0.5]
    ),
    "heavy tail": lambda: stats.pareto(1.5),
    "unknown gap": lambda: stats.rv_histogram(
        (np.array([3.0, 0.0, 5.0, 2.0]), np.array([0.1, 0.5, 1.0, 2.0, 2.5])), density=False
    ),
    "singular ends": lambda: stats.beta(0.5, 0.5),
    "samples": lambda: origins.from_samples(np.random.default_rng(0).gamma(3.0, size=1000)),
    "large": lambda: origins.gw_elastic(1e12),
    "start": lambda: origins.gaussian_start(mean=-0.1, std=0.025),
}
CELLS = 1 << 12
TAILS = (2.0**-12, 1e-4, 1e-5, 3e-6)


def _law(name: str) -> Any:
    law = LAWS[name]()
    return law if isinstance(law, origins.Start) else origins.Contacts(law).thresholds


def _draws(table: Any, many: int, seed: int = 20101) -> np.ndarray:
    """So many draws in whole units, of blocks of one round each."""
    words, rows = np.zeros(4 * streams.ROW, np.uint32), quantiles.make_room()
    out = np.zeros((-(-many // (4 * streams.LANES)), 4, streams.LANES), np.int64)
    for block, found in enumerate(out):
        stream = streams.make_stream(seed, block)
        streams.draw(streams.LANES, 0, stream, streams.THRESHOLDS, words)
        for row in range(4):
            quantiles.draw_values(
                streams.LANES, row, 0, stream, streams.THRESHOLDS, words, table, rows, found[row]
            )
    return out.ravel()[:many]


# Random123's own vectors for seven rounds: counter, key, answer
KNOWN_ANSWERS = [
    (
        "00000000 00000000 00000000 00000000",
        "00000000 00000000",
        "5f6fb709 0d893f64 4f121f81 4f730a48",
    ),
    (
        "ffffffff ffffffff ffffffff ffffffff",
        "ffffffff ffffffff",
        "5207ddc2 45165e59 4d8ee751 8c52f662",
    ),
    (
        "243f6a88 85a308d3 13198a2e 03707344",
        "a4093822 299f31d0",
        "4dfccaba 190a87f0 c47362ba b6b5242a",
    ),
]


@pytest.mark.parametrize(("counter", "key", "answer"), KNOWN_ANSWERS)
def test_words_are_the_published_ones(counter: str, key: str, answer: str) -> None:
    given = [np.uint64(int(word, 16)) for word in (*counter.split(), *key.split())]
    assert [f"{int(word):08x}" for word in streams.philox(*given)] == answer.split()


@pytest.mark.parametrize("name", LAWS)
def test_four_million_draws(name: str) -> None:
    """Kolmogorov and Smirnov's distance, and the tails."""
    law, many = _law(name), 4_000_000
    unit = abs(float(law.ppf(0.5))) * 2.0**-44
    x = _draws(make_table(law).in_units(unit), many) * unit
    ends = np.concatenate(
        [
            law.ppf(np.arange(1, CELLS // 2 + 1) / CELLS),
            law.isf(np.arange(CELLS // 2 - 1, -1, -1) / CELLS),
        ]
    )
    counts = np.bincount(np.minimum(np.searchsorted(ends, x), CELLS - 1), minlength=CELLS)
    distance = np.abs(np.cumsum(counts) / many - (np.arange(CELLS) + 1.0) / CELLS).max()
    assert stats.kstwobign.sf(distance * np.sqrt(many)) > 1e-3
    for tail in TAILS:
        for count in ((x < law.ppf(tail)).sum(), (x > law.isf(tail)).sum()):
            assert stats.binomtest(int(count), many, tail).pvalue > 1e-5


@pytest.mark.parametrize("name", LAWS)
def test_every_cell_keeps_its_promise(name: str) -> None:
    """At random v of each part, quick cells and tree: |cdf - u| <= 1e-6 min(u, 1 - u), or the last bits."""
    law = _law(name)
    parts = (
        law.components
        if isinstance(law, origins.Thresholds) and len(getattr(law, "components", ())) > 1
        else [law]
    )
    unit = abs(float(law.ppf(0.5))) * 2.0**-44
    table, generator = make_table(law).in_units(unit), np.random.default_rng(5)
    v = np.concatenate([0.5 * generator.random(3000), 2.0 ** generator.uniform(-60.0, -1.0, 3000)])
    for k, part in enumerate(parts):
        for above, tail in ((False, part.cdf), (True, part.sf)):
            x = np.array([quantiles.value_at(k, above, one, table) for one in v]) * unit
            ulps = 6.0 * np.finfo(float).eps * np.abs(x) * (1.0 if above else -1.0)
            # scipy.stats' own tails are exact to the round-off of 1 only
            off = np.maximum(np.maximum(tail(x + ulps) - v, v - tail(x - ulps)), 0.0) - 4e-16 * (
                v < 1e-9
            )
            # between the ten points of a cell the error may be a little larger than at them
            assert (off / v).max() < 1.3e-6


def test_exact_values_come_out_exact() -> None:
    pair = origins.mixture([origins.identical(0.95), origins.identical(1.05)], [0.3, 0.7])
    x = _draws(make_table(pair).in_units(2.0**-40), 200_000)
    values, counts = np.unique(x, return_counts=True)
    assert (values == np.rint(np.array([0.95, 1.05]) * 2.0**40)).all()
    assert stats.binomtest(int(counts[0]), 200_000, 0.3).pvalue > 1e-4


@pytest.mark.parametrize("x", [0.5, 1.0, 1.2, 1.6, 2.5])
def test_thresholds_beyond_a_stretch_follow_the_conditional_law(x: float) -> None:
    law = origins.mixture([origins.gaussian(1.0, 0.05), origins.gaussian(1.3, 0.1)], [0.4, 0.6])
    table, unit = make_table(law, 1e-50).in_units(2.0**-44), 2.0**-44
    pairs = np.random.default_rng(1).random((20_000, 2))
    rows = quantiles.make_room()
    drawn = np.array([quantiles.beyond(int(x / unit), *pair, table, rows) for pair in pairs]) * unit
    assert (drawn >= x).all()
    assert stats.kstest(law.sf(drawn) / law.sf(x), "uniform").pvalue > 1e-3


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
        make_table(_Careless())


@pytest.mark.parametrize(
    "law", [origins.lubricated(1.0, power=-0.95), stats.gamma(0.01), stats.gamma(0.05, 0, 1e-9)]
)
def test_weight_where_numbers_end_is_refused_at_once(law: object) -> None:
    contacts = origins.Contacts(law)
    with pytest.raises(
        origins.InputError,
        match=r"^thresholds: a weight of .* lies below 1e-300 of a typical value",
    ):
        make_table(contacts.thresholds)
    make_table(origins.lubricated(1.0, power=-0.93))
