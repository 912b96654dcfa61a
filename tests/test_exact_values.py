"""Exact values of thresholds; beside a rectangle, or without them, F(X) of sums in closed form.

Relaxed contacts have broken n times by X where the sum S_n of n thresholds is at most X, and by
symmetry F(X) = X - sum over n of E[S_n; S_n <= X] / n; a start x_0 below every threshold shifts X
by x_0. S_n is a sum of exact values and of k uniform ones, whose law is Irwin and Hall's.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from conftest import slow
from solving import held_to_claim

import master
import origins


def irwin_hall(k: int, y: np.ndarray, times: int) -> np.ndarray:
    """Law of the sum of k standard uniform values, integrated 0 or 1 times."""
    apart = y - 0.5 * k
    # beyond the middle, by symmetry: alternating sums stay small
    near = np.clip(np.minimum(y, k - y), 0.0, 0.5 * k)
    terms = [
        (-1) ** j * math.comb(k, j) * np.maximum(near - j, 0.0) ** (k + times)
        for j in range(k // 2 + 1)
    ]
    lower = np.sum(terms, axis=0) / math.factorial(k + times)
    whole = [1.0, apart][times]
    return np.where(apart > 0.0, whole - (-1) ** times * lower, lower)


def exact_force(value: float, share: float, low: float, high: float, x: np.ndarray) -> np.ndarray:
    """F(X) of relaxed contacts, of which a share breaks at the value and the others from low to high."""
    force, width = x.copy(), high - low
    for n in range(1, int(x.max() / min(value, low)) + 1):
        for k in range(n + 1):
            weight, begin = math.comb(n, k) * share ** (n - k) * (1.0 - share) ** k, k * low
            begin += (n - k) * value
            if k == 0:
                part = np.where(x >= begin, begin, 0.0)
            else:
                y = (x - begin) / width
                part = x * irwin_hall(k, y, 0) - width * irwin_hall(k, y, 1)
            force -= weight / n * part
    return force


@pytest.mark.parametrize(
    ("value", "share", "low", "high", "start"),
    [
        (1.0, 0.4, 0.5, 1.5, 0.2),
        (0.8371, 0.25, 0.4, 1.9, 0.0),
        (1.7, 0.5, 0.5, 1.0, 0.0),  # above the rectangle
        (1.0, 0.0, 0.5, 1.5, 0.0),  # none
    ],
)
def test_exact_values_beside_a_rectangle(value, share, low, high, start):
    parts = [origins.identical(value), origins.rectangular(low, high)]
    law = origins.mixture(parts, [share, 1.0 - share]) if share else parts[1]
    contacts = origins.Contacts(law, start)
    more = np.random.default_rng(5).uniform(0.0, 4.0, 100)
    x = np.sort(np.append(np.linspace(0.0, 4.0, 401), more))
    exact = exact_force(value, share, low, high, x + start)
    assert held_to_claim(contacts, x, 1e-8, exact).nodes < 100_000


def test_a_spike_of_the_density_breaks_like_an_exact_value() -> None:
    """No node of a wide panel is in it; all that its width changes beside the path's points is 1e-12."""
    path, wide = np.linspace(0.0, 3.0, 61), origins.gaussian(1.0, 0.2)
    spike, atom = (
        origins.Contacts(origins.mixture([wide, part], [0.9, 0.1]))
        for part in (origins.gaussian(1.02, 1e-7), origins.identical(1.02))
    )
    held_to_claim(spike, path, 1e-6, master.solve(atom, path, 1e-9))


def test_contacts_born_in_a_hold_meet_an_exact_value_together() -> None:
    """At X = 2.8 those born at X = 2 come to 0.8, and the force that they bore is gone."""
    law = origins.mixture([origins.identical(0.8), origins.gaussian(1.0, 0.2)], [0.3, 0.7])
    warm = origins.Contacts(law, thermal=origins.Thermal("soft", 0.05))
    path, time = [0.0, 2.0, 2.0, 2.8 - 1e-9, 2.8, 3.0], [0.0, 2.0, 22.0, 22.8 - 1e-9, 22.8, 23.0]
    found = master.solve(warm, path, 1e-5, time=time)
    assert found.success and found.force[3] - found.force[4] > 0.04


def test_one_value_with_a_delay_is_a_sawtooth_with_gaps() -> None:
    contacts = origins.Contacts(origins.identical(1.0), delay=origins.Delay(0.5))
    path = np.array([0.7, 1.2, 1.6, 2.4, 2.7, 3.5])
    solved = master.solve(contacts, path, 1e-10)
    np.testing.assert_allclose(solved.force, [0.7, 0.0, 0.1, 0.9, 0.0, 0.5], atol=1e-12)
    np.testing.assert_allclose(solved.holding, [1.0, 0.0, 1.0, 1.0, 0.0, 1.0], atol=1e-12)
    linked = origins.Contacts(origins.identical(2.0), reforming=0.5, stiffness="linked")
    twice = master.solve(linked, [1.9, 2.4, 3.6], 1e-10)
    np.testing.assert_allclose(twice.force, [1.9, 0.9, 0.6], atol=1e-12)


def test_an_exact_threshold_met_just_as_the_path_turns_breaks() -> None:
    """All break for the fourth time just there, come back after 0.2, and break once more at -0.7 on the way back."""
    contacts = origins.Contacts(origins.identical(0.7), delay=origins.Delay(0.2))
    turned = master.solve(contacts, [0.0, 2.5, 1.0], 1e-10, time=[0.0, 2.5, 4.0])
    assert turned.success, turned.message
    np.testing.assert_allclose(turned.force, [0.0, 0.0, -0.4], atol=1e-10)
    np.testing.assert_allclose(turned.holding, [1.0, 0.0, 1.0], atol=1e-10)


@pytest.mark.parametrize("law", ["soft", slow("stiff")])
def test_heat_and_one_exact_value(law):
    """Those that heat has left break together, again and again; a start just beside the births takes another road."""
    thermal, path = origins.Thermal(law, 0.05, 2.0), np.linspace(0.1, 3.0, 8)
    starts = (origins.Contacts(origins.identical(1.0), x, thermal) for x in (None, 1e-10))
    relaxed, beside = (master.solve(contacts, path) for contacts in starts)
    assert np.abs(relaxed.force - beside.force).max() < 1e-8 and relaxed.force[3] < 0.4


@pytest.mark.parametrize(
    ("velocity", "tolerance", "known"),
    [
        slow(0.1, 1e-4, None),
        # by a tolerance of 1e-8
        (1.0, 1e-5, [0, 0.83761174, -0.6499968, 0.60000289, 0.82195999, 0.49623056, 0.18816577]),
    ],
)
def test_a_thin_layer_of_heat_before_an_exact_value(velocity, tolerance, known):
    """After turns thin layers of early breaks show in F, where panels end before them and at them."""
    thermal, start = origins.Thermal("soft", 1.3e-3, 500.0), origins.gaussian_start(0.0, 0.07)
    contacts = origins.Contacts(origins.identical(1.0), start, thermal)
    path = [0.0, 0.87, -0.65, 0.6, 0.9, 1.0, 1.09]
    found = master.solve(contacts, path, tolerance, velocity=velocity)
    if known is None:
        known = master.solve(contacts, path, 1e-8, velocity=velocity).force
    assert found.success and np.abs(found.force - known).max() <= found.force_error + 1e-8


@pytest.mark.slow
def test_a_few_break_right_after_a_turn_near_an_exact_value() -> None:
    """Weak heat breaks those of a thin layer within a fiftieth of the way back: five moments hardly see it."""
    parts = [origins.identical(0.907), origins.gaussian(1.174, 0.0968)]
    law = origins.mixture(parts, [0.478, 0.522])
    cool = origins.Contacts(law, thermal=origins.Thermal("soft", 3.6e-3, 13.8))
    path = np.append(1.17, 1.17 - np.geomspace(1e-3, 1.9, 20))
    held_to_claim(cool, path, 1e-3, master.solve(cool, path, 1e-7))


@pytest.mark.slow
def test_sets_too_small_for_edges_of_their_own_are_seen_where_they_form_again() -> None:
    """Contacts that break together at the exact value form again together, 19 times; by then they are 4e-9 of all, for
    which panels do not end at a birth. The force that they lack before it was left out of the error."""
    mixed = origins.mixture([origins.gaussian(1.0, 0.1), origins.identical(0.7)], [0.6, 0.4])
    heat, delay = origins.Thermal("soft", 0.036), origins.Delay(0.421)
    contacts = origins.Contacts(mixed, thermal=heat, delay=delay)
    path = np.linspace(19.0, 24.0, 1001)
    exact = master.solve(contacts, path, 1e-7)
    assert exact.force_error < 1e-10
    held_to_claim(contacts, path, 1e-6, exact)


def test_contacts_that_are_out_bear_no_force_where_they_form_again_stretched() -> None:
    """All break at once, are out for the delay, and form again at 0.4: F is a straight line from there."""
    delay = origins.Delay(0.3)
    contacts = origins.Contacts(origins.identical(1.0), delay=delay, reforming=0.4)
    path = np.array([0.99, 1.05, 1.29, 1.35, 1.89, 1.95, 2.19, 2.25])
    solved = master.solve(contacts, path)
    exact = [0.99, 0.0, 0.0, 0.45, 0.99, 0.0, 0.0, 0.45]
    np.testing.assert_allclose(solved.force, exact, atol=1e-12)
    np.testing.assert_array_equal(solved.holding > 0.5, np.array(exact) > 0.0)
