"""Smooth sliding: the kinetic force against exact moments and quadrature, and its curves."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

import master
from origins import Contacts, Delay, Thermal, gaussian, identical, mixture, rectangular

# law, <x_s>, <x_s^2>
ATOMIC = {
    "identical": (identical(1.7), 1.7, 1.7**2),
    "two values": (mixture([identical(1.0), identical(3.0)], [0.3, 0.7]), 2.4, 6.6),
    "value and gaussian": (
        mixture([identical(0.95), gaussian(1.05, 0.1)], [0.25, 0.75]),
        1.025,
        1.06,
    ),
    "value and uniform": (
        mixture([identical(0.5), rectangular(0.0, 1.0)], [0.5, 0.5]),
        0.5,
        0.125 + 0.5 / 3.0,
    ),
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


NARROW = gaussian(1.0, 0.05)
SPEEDS = np.geomspace(1e-6, 1e4, 200)


@pytest.mark.parametrize(
    ("law", "temperature", "more"),
    [
        ("soft", 0.001, {}),
        ("stiff", 0.1, {"stiffness": "linked"}),
        ("soft", 0.1, {"delay": Delay(0.1)}),
    ],
)
def test_every_speed_is_the_steady_state_at_that_speed(law: str, temperature: float, more) -> None:
    contacts = Contacts(NARROW, thermal=Thermal(law, temperature), **more)
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
        thermal = Thermal("stiff", float(temperatures[j]))
        single = Contacts(NARROW, thermal=thermal, reforming=0.1)
        steady = master.steady_state(single, velocity=float(speeds[i]))
        assert abs(table.force[i, j] - steady.force) <= table.force_error[i, j] + steady.force_error
    # left out, the temperature is the contacts' own; one number is a curve of no dimension
    own = master.kinetic_curve(contacts, 10.0)
    assert own.force.shape == () and float(own.force) == table.force[1, 2]


def test_what_holds_at_each_delay() -> None:
    wide = rectangular(0.5, 1.5)
    waits = np.linspace(0.0, 50.0, 200)
    curve = master.kinetic_curve(Contacts(wide), 2.0, delay=waits)
    np.testing.assert_allclose(curve.holding, 1.0 / (1.0 + 2.0 * waits), rtol=0.0, atol=1e-14)
    np.testing.assert_allclose(curve.force, wide.moment(2) / 2.0 * curve.holding, rtol=1e-13)
    assert (np.abs(curve.holding - 1.0 / (1.0 + 2.0 * waits)) <= curve.holding_error).all()
    # with temperature C is that of breaks by a rate, to be met by the other road
    warm = Contacts(wide, thermal=Thermal("soft", 0.1))
    curve = master.kinetic_curve(warm, 2.0, delay=waits[::50])
    for wait, held, off in zip(waits[::50], curve.holding, curve.holding_error, strict=True):
        contacts = Contacts(wide, thermal=Thermal("soft", 0.1), delay=Delay(float(wait)))
        assert (
            abs(held - master.steady_state(contacts, velocity=2.0).holding) <= off + 1e-12 <= 1e-10
        )
