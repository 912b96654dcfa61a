"""Thresholds with exact values beside a density: F(X) of sums of thresholds in closed form.

Relaxed contacts have broken n times by X where the sum S_n of n thresholds is at most X, and by
symmetry F(X) = X - sum over n of E[S_n; S_n <= X] / n; a start x_0 below every threshold shifts X
by x_0. With exact values a_i and one continuous kind, S_n is a sum of exact values and of k
continuous ones, whose law is Irwin and Hall's for uniform and a gamma law for gamma thresholds.
"""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
import scipy.special
import scipy.stats
from solving import held_to_claim

import origins


def irwin_hall(k: int, y: np.ndarray, times: int) -> np.ndarray:
    """Law of the sum of k standard uniform values, integrated so many times."""
    apart = y - 0.5 * k
    whole = [np.ones(y.shape), apart, 0.5 * apart**2 + k / 24.0][times]
    near = np.clip(
        np.minimum(y, k - y), 0.0, 0.5 * k
    )  # beyond the middle, by symmetry: alternating sums stay small
    terms = [
        (-1) ** j * math.comb(k, j) * np.maximum(near - j, 0.0) ** (k + times)
        for j in range(k // 2 + 1)
    ]
    lower = np.sum(terms, axis=0) / math.factorial(k + times)
    return np.where(apart > 0.0, whole - (-1) ** times * lower, lower)


def below_uniform(
    k: int, low: float, width: float, shift: float, x: np.ndarray, fold: int
) -> np.ndarray:
    """E[S; S <= x], or its integral over x (fold = 1), for S = shift + k uniform values from low to low + width."""
    begin = shift + k * low
    if not k:
        return np.where(x >= begin, begin, 0.0) if fold == 0 else begin * np.maximum(x - begin, 0.0)
    cdf, once, twice = (
        width**times * irwin_hall(k, (x - begin) / width, times) for times in range(3)
    )
    return x * cdf - once if fold == 0 else x * once - 2.0 * twice


def sums(atoms: list[float], weights: list[float], rest: float, least: float, end: float):
    """(n, number k of continuous ones, sum of the exact values, probability) of every sum that may stay below end."""
    for n in range(1, int(end / least) + 1):
        for k in range(n + 1):
            for counts in itertools.product(range(n - k + 1), repeat=len(atoms)):
                if sum(counts) == n - k:
                    ways = (
                        math.factorial(n)
                        / math.factorial(k)
                        / math.prod(math.factorial(c) for c in counts)
                    )
                    weight = (
                        ways
                        * rest**k
                        * math.prod(w**c for w, c in zip(weights, counts, strict=True))
                    )
                    yield n, k, sum(a * c for a, c in zip(atoms, counts, strict=True)), weight


def uniform_force(
    atoms: list[float],
    weights: list[float],
    low: float,
    high: float,
    x: np.ndarray,
    start: tuple[float, float] | None = None,
) -> np.ndarray:
    """Exact F(X), relaxed or for a start uniform between two values."""
    first, last = start or (0.0, 0.0)
    force = x + 0.5 * (first + last)
    rest, least = 1.0 - sum(weights), min([low, *atoms])
    for n, k, shift, weight in sums(atoms, weights, rest, least, x.max() + last):
        if start:
            upper = below_uniform(k, low, high - low, shift, x + last, 1)
            lower = below_uniform(k, low, high - low, shift, x + first, 1)
            force -= weight / n * (upper - lower) / (last - first)
        else:
            force -= weight / n * below_uniform(k, low, high - low, shift, x, 0)
    return force


def spread(start: tuple[float, float] | None) -> object:
    return None if start is None else scipy.stats.uniform(start[0], start[1] - start[0])


SCENES = {
    "one value inside a rectangle": ([1.0], [0.4], 0.5, 1.5),
    "one value off the lattice": ([0.8371], [0.25], 0.4, 1.9),
    "a value above the rectangle": ([1.7], [0.5], 0.5, 1.0),
}


@pytest.mark.parametrize(
    ("name", "start", "tolerance"),
    [
        ("one value inside a rectangle", (-0.2, 0.2), 1e-8),
        ("one value off the lattice", None, 1e-8),
        ("a value above the rectangle", (-0.25, -0.15), 1e-6),
    ],
)
def test_exact_values_beside_a_rectangle(name, start, tolerance):
    atoms, weights, low, high = SCENES[name]
    law = origins.mixture(
        [*(origins.identical(a) for a in atoms), origins.rectangular(low, high)],
        [*weights, 1.0 - sum(weights)],
    )
    contacts = origins.Contacts(law, spread(start))
    x = np.sort(
        np.append(np.linspace(0.0, 4.0, 401), np.random.default_rng(5).uniform(0.0, 4.0, 100))
    )
    exact = uniform_force(atoms, weights, low, high, x, start)
    assert held_to_claim(contacts, x, tolerance, exact).nodes < 100_000
