"""Delay, re-forming at other stretches and linked stiffness, alone and together."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

import master
import origins

WIDE, WAIT = origins.gaussian(1.0, 0.2), origins.Delay(0.3)


def test_one_value_with_a_delay_is_a_sawtooth_with_gaps() -> None:
    contacts = origins.Contacts(origins.identical(1.0), delay=origins.Delay(0.5))
    path = np.array([0.7, 1.2, 1.6, 2.4, 2.7, 3.5])
    solved = master.solve(contacts, path, 1e-10)
    np.testing.assert_allclose(solved.force, [0.7, 0.0, 0.1, 0.9, 0.0, 0.5], atol=1e-12)
    np.testing.assert_allclose(solved.holding, [1.0, 0.0, 1.0, 1.0, 0.0, 1.0], atol=1e-12)
    twice = master.solve(
        origins.Contacts(origins.identical(2.0), reforming=0.5, stiffness="linked"),
        [1.9, 2.4, 3.6],
        1e-10,
    )
    np.testing.assert_allclose(twice.force, [1.9, 0.9, 0.6], atol=1e-12)


def test_steady_forces_in_closed_form() -> None:
    mean, square, cube = (WIDE.moment(n) for n in (1, 2, 3))
    linked = master.steady_state(origins.Contacts(WIDE, stiffness="linked"))
    assert linked.force == pytest.approx(cube / (2.0 * mean**2), rel=1e-12)
    delayed = master.steady_state(origins.Contacts(WIDE, delay=WAIT), velocity=2.0)
    assert delayed.force == pytest.approx(square / (2.0 * (mean + 0.6)), rel=1e-12)
    # far from all thresholds births at r only shift where each contact begins
    box, r = origins.rectangular(0.8, 1.2), -0.3
    shifted = master.steady_state(origins.Contacts(box, reforming=r))
    assert shifted.cycle_length == pytest.approx(1.0 - r, rel=1e-12)
    assert shifted.force == pytest.approx((box.moment(2) - r * r) / (2.0 * (1.0 - r)), rel=1e-12)
    around = master.steady_state(origins.Contacts(box, reforming=origins.boltzmann_reforming(1e-3)))
    assert around.force == pytest.approx((box.moment(2) - 1e-3) / 2.0, rel=1e-10)


def test_linked_contacts_that_break_early_keep_the_stiffness_they_were_born_with() -> None:
    # hundreds of breaks of each: what a table lacks would add up as their square
    contacts = origins.Contacts(
        origins.gaussian(1.0, 0.2), thermal=origins.Thermal("soft", 0.4484), stiffness="linked"
    )
    steady = master.steady_state(contacts, velocity=0.01)
    assert steady.cycle_length < 0.05
    solved = master.solve(contacts, [20.0, 25.0], 1e-9, velocity=0.01)
    assert solved.success and solved.force_error < 1e-9
    assert (np.abs(solved.force - steady.force) <= solved.force_error + steady.force_error).all()


BOX = origins.rectangular(0.5, 1.5)


@pytest.mark.parametrize("r", [-0.3, 0.2, 0.7])
def test_births_at_one_stretch(r: float) -> None:
    """C and the integral of x E over a rectangle, from births within or below it."""
    low = max(abs(r), 0.5)
    held = 1.5 - low  # survival of the rectangle at |r|
    length = (low - r) + 0.5 * held
    tail = (1.5 * (1.5**2 - low**2) / 2.0 - (1.5**3 - low**3) / 3.0) / held
    area = 0.5 * (low**2 - r**2) + tail
    state = master.steady_state(origins.Contacts(BOX, reforming=r, delay=origins.Delay(0.1)))
    assert abs(state.force - area / (length + 0.1)) <= state.force_error + 1e-15
    assert state.cycle_length == pytest.approx(length, rel=1e-12)


@pytest.mark.parametrize("at", [2.6, 5.0])
def test_births_deep_in_the_tail_of_the_thresholds(at: float) -> None:
    """F_k = at + <d^2>/2<d> with d what thresholds are beyond: Mills' ratio and its moments, for normal thresholds."""
    found = master.steady_state(origins.Contacts(origins.gaussian(1.0, 0.2), reforming=at))
    with mpmath.workdps(60):
        z = (mpmath.mpf(at) - 1) / mpmath.mpf("0.2")
        mills = mpmath.sqrt(mpmath.pi / 2) * mpmath.erfc(z / mpmath.sqrt(2)) * mpmath.exp(z * z / 2)
        first = 1 / mills - z
        second = 1 - z * first
        expected = float(at + mpmath.mpf("0.1") * second / first)
    assert found.success
    assert abs(found.force - expected) <= found.force_error * found.mean_threshold < 1e-10


def test_an_exact_threshold_met_just_as_the_path_turns_breaks() -> None:
    """All break for the fourth time just there, come back after 0.2, and break once more at -0.7 on the way back."""
    contacts = origins.Contacts(origins.identical(0.7), delay=origins.Delay(0.2))
    turned = master.solve(contacts, [0.0, 2.5, 1.0], 1e-10, time=[0.0, 2.5, 4.0])
    assert turned.success, turned.message
    np.testing.assert_allclose(turned.force, [0.0, 0.0, -0.4], atol=1e-10)
    np.testing.assert_allclose(turned.holding, [1.0, 0.0, 1.0], atol=1e-10)
