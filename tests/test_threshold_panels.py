"""Sums over the thresholds above a stretch, and what rests on them: first breaks of starts among the thresholds."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad

import master
from master._old.cycle import Cycle
from master._old.problem import Problem
from master._old.threshold_panels import ThresholdPanels
from origins import Contacts, Thermal, gaussian, gaussian_start, gw_plastic, rectangular

LAWS = {"narrow": gaussian(1.0, 0.05), "from 0 on": gw_plastic(1.0), "jumps": rectangular(0.5, 1.5)}


@pytest.mark.parametrize("rooted", [False, True])
@pytest.mark.parametrize("name", LAWS)
def test_sums_above_a_stretch_are_those_of_quadrature(name: str, rooted: bool) -> None:
    law = LAWS[name]
    panels = ThresholdPanels(law, rooted, lambda x: 5.0 * x * x)
    least = np.array([0.0, 0.1, 0.45, 0.4999, 0.63, 0.9, 1.0001, 1.13])
    found = np.zeros(least.size)
    power = 0.5 if rooted else 0.0
    for row, mass, threshold in panels.above(least):
        values = np.exp(-5.0 * threshold**2) * (threshold - least[row, None]) ** power
        found += np.bincount(row, weights=(mass * values).sum(axis=1), minlength=least.size)
    for low, sum_above in zip(least, found, strict=True):

        def over_root(r: float, low: float = low) -> float:
            x = low + r * r
            return float(law.pdf(x)) * np.exp(-5.0 * x * x) * r ** (2.0 * power) * 2.0 * r

        ends = np.sqrt(np.maximum(np.array([low, 0.5, 0.9, 1.0, 1.1, 1.5, 3.0]) - low, 0.0))
        known = sum(quad(over_root, a, b, epsabs=1e-16)[0] for a, b in pairwise(ends) if b > a)
        assert sum_above == pytest.approx(known, rel=1e-11, abs=1e-15)


def first_breaks(contacts: Contacts, x: float) -> float:
    """b_0 at one X from its double integral, smooth laws alone."""
    law, thermal = contacts.thresholds, contacts.thermal
    assert thermal is not None
    nodes, weights = np.polynomial.legendre.leggauss(24)

    def panels(edges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        half = 0.5 * np.diff(edges)[:, None]
        return (edges[:-1, None] + half * (nodes + 1.0)).ravel(), (half * weights).ravel()

    low, high = contacts.start.span
    # where stretches begin or turn at 0, and where they are back at what they were
    inner = np.array([-x, -0.5 * x, 0.0])
    start, share = panels(np.unique(np.append(np.linspace(low, high, 7), inner[(inner > low) & (inner < high)])))
    total = 0.0
    for origin, weight in zip(start, share * contacts.start.pdf(start) / law.sf(np.abs(start)), strict=True):
        stretch, least = origin + x, max(origin + x, abs(origin))
        roots, width = panels(np.linspace(0.0, np.sqrt(max(law.isf(1e-17) - least, 1e-9)), 7))
        threshold = least + roots**2
        spent = thermal.cumulative(stretch, threshold, origin)
        rate = thermal.rate(stretch, threshold) * np.exp(-spent)
        held = float((2.0 * roots * width * law.pdf(threshold) * rate).sum())
        if stretch > abs(origin):
            held += float(law.pdf(stretch) * np.exp(-thermal.cumulative(stretch, stretch, origin)))
        total += weight * held
    return total


@pytest.mark.parametrize("law", ["soft", "stiff"])
def test_first_breaks_of_starts_among_the_thresholds(law: str) -> None:
    contacts = Contacts(gaussian(1.0, 0.3), gaussian_start(0.2, 0.04), thermal=Thermal(law, 0.1, 3.0))
    cycle = Cycle(contacts, 1.0)
    first = Problem(contacts, 1.0 / cycle.unit, 1e-5, cycle).first
    x = np.array([0.05, 0.7])
    known = [first_breaks(contacts, float(at)) for at in x]
    np.testing.assert_allclose(first.density(x / cycle.unit) / cycle.unit, known, atol=1e-9)


def test_steady_state_of_wide_linked_stiff_contacts() -> None:
    law, thermal = gw_plastic(1.0), Thermal("stiff", 0.77, 337.0)
    steady = master.steady_state(Contacts(law, thermal=thermal, stiffness="linked"))
    curve = master.kinetic_curve(Contacts(law, thermal=thermal, stiffness="linked"), 1.0)
    assert steady.force_error < 1e-10
    off = abs(steady.force - float(curve.force)) / law.mean()
    assert off < steady.force_error + float(curve.force_error)
