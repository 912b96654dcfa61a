"""Ten million draws of every family, as the ensemble makes them: Kolmogorov and Smirnov's distance, and the tails."""

from typing import Any

import numpy as np
import pytest
from scipy import stats

import origins
from eq_model import kernel
from eq_model.compiled_table import kernel_table
from origins import streams
from origins.quantile import quantile_table

N = 4_000_000
CELLS = 1 << 12
TAILS = (2.0**-12, 1e-4, 1e-5, 3e-6)

LAWS: dict[str, Any] = {
    "gaussian": lambda: origins.gaussian(1.0, 0.3),
    "chord": lambda: origins.gaussian(1.0, 0.05, form="paper", upper=2.0),
    "rectangular": lambda: origins.rectangular(0.5, 1.5),
    "gw_elastic": lambda: origins.gw_elastic(1.0),
    "gw_plastic": lambda: origins.gw_plastic(1.0),
    "gw_gaussian": lambda: origins.gw_gaussian(1.5, 1.0, "paper"),
    "gw_gaussian mixed": lambda: origins.gw_gaussian(0.5, 1.0, "amontons", "mixed", 9.0),
    "persson": lambda: origins.persson(1.0, 0.5),
    "lubricated": lambda: origins.lubricated(1.0),
    "grains": lambda: origins.grains(1.0, B=1.0),
    "grains as printed": lambda: origins.grains(1.0, B=1.0, jacobian="paper"),
    "two peaks": lambda: origins.mixture([origins.gaussian(0.3, 0.03), origins.gaussian(1.0, 0.05)], [0.3, 0.7]),
}


@pytest.mark.parametrize("name", LAWS)
def test_four_million_draws(name: str) -> None:
    law = LAWS[name]()
    table = quantile_table(law)
    unit = table.scale * 2.0**-44
    compiled, key = kernel_table(table, unit), tuple(np.uint64(word) for word in streams.key_of(20101))
    counts, below, above = np.zeros(CELLS, np.int64), np.zeros(len(TAILS), int), np.zeros(len(TAILS), int)
    low, high = law.ppf(np.array(TAILS)), law.isf(np.array(TAILS))
    half = np.arange(1, CELLS // 2 + 1) / CELLS
    ends = np.concatenate([law.ppf(half), law.isf(half[-2::-1])])
    chunk = N // 10
    whole, births = np.empty(chunk, np.int64), np.zeros(chunk, np.int64)
    for k in range(10):
        kernel.begin(k * chunk, N, key, compiled, compiled, True, births, whole)
        x = whole * unit
        counts += np.bincount(np.searchsorted(ends, x), minlength=CELLS)
        below += [(x < end).sum() for end in low]
        above += [(x > end).sum() for end in high]
    distance = np.abs(np.cumsum(counts) / N - (np.arange(CELLS) + 1.0) / CELLS).max()
    assert stats.kstwobign.sf(distance * np.sqrt(N)) > 1e-3
    for tail, less, more in zip(TAILS, below, above, strict=True):
        assert stats.binomtest(int(less), N, tail).pvalue > 1e-5
        assert stats.binomtest(int(more), N, tail).pvalue > 1e-5
