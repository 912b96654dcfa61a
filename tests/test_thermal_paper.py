"""Rigid sliding at a temperature, closure "paper": hazard P + H/v, H the mean rate of all thresholds beyond x."""

from itertools import pairwise

import numpy as np
import pytest
import scipy.stats

import master
from origins import Contacts, Delay, Thermal, gaussian, gaussian_start, identical
from origins.births import Births
from origins.start import as_start

PATH = np.linspace(0.05, 4.0, 21) + 0.013
X, W = np.polynomial.legendre.leggauss(20)


def panels(low, high, count: int) -> tuple[np.ndarray, np.ndarray]:
    edges = np.linspace(low, high, count + 1, axis=-1)
    half = 0.5 * np.diff(edges)[..., None]
    nodes = edges[..., :-1, None] + half * (X + 1.0)
    return nodes.reshape(*np.shape(low), -1), (half * W).reshape(*np.shape(low), -1)


def mean_rate(thermal: Thermal, std: float, x: np.ndarray) -> np.ndarray:
    """H(x) by brute force, thresholds Gaussian of mean 1; nodes in the root of ξ - x."""
    roots, weights = panels(np.zeros(x.shape), np.sqrt(np.maximum(1.0 + 10.0 * std - x, 0.0)), 24)
    at = x[..., None] + roots**2
    return (2.0 * roots * weights * gaussian(1.0, std).pdf(at) * thermal.rate(x[..., None], at)).sum(axis=-1)


@pytest.mark.parametrize("law", ["soft", "stiff"])
@pytest.mark.parametrize(("temperature", "rate", "std"), [(0.1, 1.0, 0.05), (0.03, 10.0, 0.1), (1.0, 3.0, 0.2)])
def test_kinetic_force_against_brute_force(law: str, temperature: float, rate: float, std: float) -> None:
    thermal = Thermal(law, temperature, rate, closure="paper")
    end, count = 1.0 + 9.0 * std, 36
    edges = np.linspace(0.0, end, count + 1)
    total, length, area = 0.0, 0.0, 0.0
    for low, high in pairwise(edges):
        x, weights = panels(low, high, 1)
        inner, inner_weights = panels(np.full(x.shape, low), x, 1)
        spent = total + (inner_weights * mean_rate(thermal, std, inner)).sum(axis=-1)
        total += float(weights @ mean_rate(thermal, std, x))
        held = gaussian(1.0, std).sf(x) * np.exp(-spent)
        length, area = length + float(weights @ held), area + float(weights @ (x * held))
    steady = master.steady_state(Contacts(gaussian(1.0, std), thermal=thermal))
    assert steady.force == pytest.approx(area / length, rel=1e-9)
    assert steady.cycle_length == pytest.approx(length, rel=1e-9)
    assert steady.force_error < 1e-10


@pytest.mark.parametrize(("law", "velocity", "power"), [("soft", 1.0, 2.05), ("stiff", 0.1, 2.3), ("soft", 1.0, 3.0)])
def test_kinetic_force_of_far_tails_by_brute_force(law: str, velocity: float, power: float) -> None:
    """P_c = a (1 + x)^(-a-1), of which some stretch further than any sum reaches: all in logarithms of lengths."""
    thermal, thresholds = Thermal(law, 0.3, closure="paper"), scipy.stats.lomax(power)
    low, high = np.log([1e-12, 1e9])
    logs, weights = panels(low, high, 60)
    x = np.exp(logs)
    at, share = panels(np.full(x.size, low), logs, 16)
    at = np.exp(at)
    spent = (share * at * thresholds.pdf(at) * thermal.cumulative(at, at)).sum(axis=-1)
    ways, share = panels(np.log(1e-9), np.log(1e4), 16)
    at = x[:, None] * (1.0 + np.exp(2.0 * ways))
    density = 2.0 * (at - x[:, None]) * thresholds.pdf(at)
    spent += (share * density * thermal.cumulative(x[:, None], at)).sum(axis=-1)
    held = weights * x * thresholds.sf(x) * np.exp(-spent / velocity)
    left, far = np.exp(-spent[-1] / velocity), 1.0 + np.exp(high)
    length = held.sum() + left * far ** (1.0 - power) / (power - 1.0)
    area = held @ x + left * (far ** (2.0 - power) / (power - 2.0) - far ** (1.0 - power) / (power - 1.0))
    steady = master.steady_state(Contacts(thresholds, thermal=thermal), velocity=velocity)
    assert abs(steady.force - area / length) < steady.force_error * steady.mean_threshold + 1e-11 * steady.force
    # values err by less than 1e-11: an error of H, relative to itself, is counted far out as well
    assert steady.force_error * steady.mean_threshold < 2e-3 * steady.force


@pytest.mark.parametrize("start", [0.0, 0.3, -0.4, gaussian_start(0.0, 0.1)])
@pytest.mark.parametrize("wait", [None, Delay(0.2)])
def test_transients_are_those_of_contacts_under_that_hazard(start, wait) -> None:
    thermal = Thermal("stiff", 0.1, 2.0, closure="paper")
    contacts = Contacts(gaussian(1.0, 0.1), start, thermal=thermal, delay=wait)
    solved = master.solve(contacts, PATH, 1e-7)
    assert solved.success, solved.message
    # the sum of two hazards: whichever of two independent breaks comes first
    grid = np.linspace(0.0, 2.0, 4001)
    rate = mean_rate(thermal, 0.1, grid)
    spent = np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(grid))])
    stretches, odd = np.concatenate([-grid[:0:-1], grid]), np.concatenate([-spent[:0:-1], spent])
    odd, first = odd + 1e-13 * np.arange(odd.size), 0.0 if wait is None else wait.time
    count, generator = 100_000, np.random.default_rng(5)
    stretch, threshold = Births("start", contacts.start, contacts.thresholds).draw(count, generator)
    again = Births("again", as_start(None), contacts.thresholds)
    force, alive, born = np.zeros((PATH.size, count)), np.arange(count), np.zeros(count)
    while alive.size:
        amount = np.interp(stretch, stretches, odd) + generator.exponential(size=alive.size)
        broken = born + np.minimum(threshold, np.interp(amount, odd, stretches)) - stretch
        for row, x in enumerate(PATH):
            on = (born <= x) & (x < broken)
            force[row, alive[on]] += (stretch + x - born)[on]
        born = broken + first
        left = born < PATH[-1]
        alive, born = alive[left], born[left]
        stretch, threshold = again.draw(alive.size, generator)
    error = force.std(axis=1) / np.sqrt(count) + np.minimum(PATH, 1.0) / count
    assert (np.abs(solved.force - force.mean(axis=1)) < 5.0 * (error + solved.force_error)).all()


def test_one_threshold_breaks_alike_under_both_closures_but_for_starts() -> None:
    exact, paper = (
        master.solve(Contacts(identical(1.0), -0.2, thermal=Thermal("soft", 0.1, 2.0, closure=closure)), PATH, 1e-9)
        for closure in ("exact", "paper")
    )
    np.testing.assert_allclose(exact.force, paper.force, atol=exact.force_error + paper.force_error + 1e-11)
