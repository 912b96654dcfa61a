"""Smooth sliding: the kinetic force against exact moments and quadrature, its curves, and laws of a contact."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from scipy import stats

import master
from origins import (
    Contacts,
    Delay,
    Thermal,
    boltzmann_reforming,
    gaussian,
    identical,
    mixture,
    rectangular,
)

WIDE, NARROW, BOX = gaussian(1.0, 0.2), gaussian(1.0, 0.05), rectangular(0.5, 1.5)

# law, <x_s>, <x_s^2>
ATOMIC = {
    "identical": (identical(1.7), 1.7, 1.7**2),
    "two values": (mixture([identical(1.0), identical(3.0)], [0.3, 0.7]), 2.4, 6.6),
    "value, gaussian": (mixture([identical(0.95), gaussian(1.05, 0.1)], [0.25, 0.75]), 1.025, 1.06),
    "value, uniform": (mixture([identical(0.5), rectangular(0.0, 1.0)], [0.5, 0.5]), 0.5, 7 / 24),
}


@pytest.mark.parametrize("name", ATOMIC)
def test_force_of_laws_with_exact_values(name: str) -> None:
    """F_k = <x_s²>/(2 <x_s>); of laws with densities alone test_families tells."""
    law, mean, square = ATOMIC[name]
    steady = master.steady_state(Contacts(law))
    assert steady.mean_threshold == pytest.approx(mean, rel=1e-10)
    assert abs(steady.force - square / (2.0 * mean)) / mean <= steady.force_error < 1e-14


def test_linked_contacts_ahead_of_a_heavy_tail_claim_what_is_left_out() -> None:
    """Above r = 0.1 such thresholds exceed r by a law of the same family, whose moments make F_k = 3.175."""
    contacts = Contacts(stats.lomax(6.0, scale=2.0), reforming=0.1, stiffness="linked")
    steady = master.steady_state(contacts)
    assert abs(steady.force - 3.175) / steady.mean_threshold <= steady.force_error < 1e-6


SPEEDS = np.geomspace(1e-6, 1e4, 200)


@pytest.mark.parametrize(
    "contacts",
    [
        Contacts(NARROW, thermal=Thermal("soft", 0.001)),
        Contacts(NARROW, thermal=Thermal("stiff", 0.1), stiffness="linked"),
        Contacts(NARROW, thermal=Thermal("soft", 0.1), delay=Delay(0.1)),
    ],
)
def test_every_speed_is_the_steady_state_at_that_speed(contacts: Contacts) -> None:
    curve = master.kinetic_curve(contacts, SPEEDS)
    for i in (3, 60, 120, 190):
        steady = master.steady_state(contacts, velocity=float(SPEEDS[i]))
        assert curve.force[i] == pytest.approx(steady.force, rel=1e-9)
        assert abs(curve.force[i] - steady.force) <= curve.force_error[i] + steady.force_error
        assert abs(curve.holding[i] - steady.holding) <= curve.holding_error[i] + 1e-12
    assert (curve.force_error <= 1e-9 * curve.force).all()


def test_a_table_over_speed_and_temperature() -> None:
    contacts = Contacts(NARROW, 0.3, thermal=Thermal("stiff", 0.5), reforming=0.1)
    speeds, temperatures = np.array([0.1, 10.0]), np.array([0.0, 0.05, 0.5])
    table = master.kinetic_curve(contacts, speeds[:, None], temperature=temperatures)
    assert table.force.shape == table.force_error.shape == table.holding.shape == (2, 3)
    cold = master.steady_state(Contacts(NARROW, reforming=0.1)).force
    np.testing.assert_array_equal(table.force[:, 0], cold)
    for i, j in ((0, 1), (1, 2)):
        single = contacts.replace(thermal=Thermal("stiff", float(temperatures[j])))
        steady = master.steady_state(single, velocity=float(speeds[i]))
        assert abs(table.force[i, j] - steady.force) <= table.force_error[i, j] + steady.force_error
    # left out, the temperature is the contacts' own; one number is a curve of no dimension
    own = master.kinetic_curve(contacts, 10.0)
    assert own.force.shape == () and float(own.force) == table.force[1, 2]


def test_what_holds_at_each_delay() -> None:
    waits = np.linspace(0.0, 50.0, 200)
    curve = master.kinetic_curve(Contacts(BOX), 2.0, delay=waits)
    np.testing.assert_allclose(curve.holding, 1.0 / (1.0 + 2.0 * waits), rtol=0.0, atol=1e-14)
    np.testing.assert_allclose(curve.force, BOX.moment(2) / 2.0 * curve.holding, rtol=1e-13)
    assert (np.abs(curve.holding - 1.0 / (1.0 + 2.0 * waits)) <= curve.holding_error).all()
    # with temperature C is that of breaks by a rate, to be met by the other road
    warm = Contacts(BOX, thermal=Thermal("soft", 0.1))
    curve = master.kinetic_curve(warm, 2.0, delay=waits[::50])
    for wait, held, off in zip(waits[::50], curve.holding, curve.holding_error, strict=True):
        other = master.steady_state(warm.replace(delay=Delay(float(wait))), velocity=2.0)
        assert abs(held - other.holding) <= off + 1e-12 <= 1e-10


# -- delay, re-forming at other stretches and linked stiffness, alone and together ------------------


def test_steady_forces_in_closed_form() -> None:
    mean, square, cube = (WIDE.moment(n) for n in (1, 2, 3))
    linked = master.steady_state(Contacts(WIDE, stiffness="linked"))
    assert linked.force == pytest.approx(cube / (2.0 * mean**2), rel=1e-12)
    delayed = master.steady_state(Contacts(WIDE, delay=Delay(0.3)), velocity=2.0)
    assert delayed.force == pytest.approx(square / (2.0 * (mean + 0.6)), rel=1e-12)
    # far from all thresholds births only shift where each contact begins
    box = rectangular(0.8, 1.2)
    around = master.steady_state(Contacts(box, reforming=boltzmann_reforming(1e-3)))
    assert around.force == pytest.approx((box.moment(2) - 1e-3) / 2.0, rel=1e-10)


def test_linked_contacts_that_break_early_keep_the_stiffness_they_were_born_with() -> None:
    # hundreds of breaks of each: what a table lacks would add up as their square
    contacts = Contacts(WIDE, thermal=Thermal("soft", 0.4484), stiffness="linked")
    steady = master.steady_state(contacts, velocity=0.01)
    assert steady.cycle_length < 0.05
    solved = master.solve(contacts, [20.0, 25.0], 1e-9, velocity=0.01)
    assert solved.success and solved.force_error < 1e-9
    assert (np.abs(solved.force - steady.force) <= solved.force_error + steady.force_error).all()


@pytest.mark.parametrize("r", [-0.3, 0.2, 0.7])
def test_births_at_one_stretch(r: float) -> None:
    """C and the integral of x E over a rectangle, from births within or below it."""
    low = max(abs(r), 0.5)
    held = 1.5 - low  # survival of the rectangle at |r|
    length = (low - r) + 0.5 * held
    tail = (1.5 * (1.5**2 - low**2) / 2.0 - (1.5**3 - low**3) / 3.0) / held
    area = 0.5 * (low**2 - r**2) + tail
    state = master.steady_state(Contacts(BOX, reforming=r, delay=Delay(0.1)))
    assert abs(state.force - area / (length + 0.1)) <= state.force_error + 1e-15
    assert state.cycle_length == pytest.approx(length, rel=1e-12)


@pytest.mark.parametrize("at", [2.6, 5.0])
def test_births_deep_in_the_tail_of_the_thresholds(at: float) -> None:
    """F_k = at + <d^2>/2<d> with d what thresholds are beyond: Mills' ratio and its moments, for normal thresholds."""
    found = master.steady_state(Contacts(WIDE, reforming=at))
    with mpmath.workdps(60):
        z = (mpmath.mpf(at) - 1) / mpmath.mpf("0.2")
        mills = mpmath.sqrt(mpmath.pi / 2) * mpmath.erfc(z / mpmath.sqrt(2)) * mpmath.exp(z * z / 2)
        first = 1 / mills - z
        second = 1 - z * first
        expected = float(at + mpmath.mpf("0.1") * second / first)
    assert found.success
    assert abs(found.force - expected) <= found.force_error * found.mean_threshold < 1e-10


def test_force_errors_are_judged_relative_to_the_size_of_the_force() -> None:
    """Also where contacts re-form so far behind that F_k is below 0, and where it is far below <x_s>."""
    behind = Contacts(gaussian(0.5, 0.05), reforming=-0.45, thermal=Thermal("soft", 0.5))
    hot = Contacts(NARROW, thermal=Thermal("soft", 0.5, 1e5))
    for contacts, velocity in ((behind, 1e-3), (hot, 1.0)):
        one = master.steady_state(contacts, velocity=velocity)
        assert one.force < 1e-2
        for found in (one, master.kinetic_curve(contacts, velocity)):
            relative = float(found.force_error * contacts.mean_threshold / abs(found.force))
            assert f"F_k known to {relative:.1e}, within" in found.message
