"""Paths far beyond where contacts have forgotten their start: the kinetic force, once nothing else is left of it."""

import numpy as np
import pytest
from counted_calls import CountedCalls
from phase_type import gaussian_force

import master
from origins import Contacts, Delay, Thermal, gaussian, gaussian_start, identical, mixture, rectangular

WIDE = gaussian(1.0, 0.2)
CASES = {
    "cold": (Contacts(gaussian(1.0, 0.05), gaussian_start(0.1, 0.025)), 1.0),
    "delay": (Contacts(rectangular(0.5, 1.5), 0.3, delay=Delay(0.3)), 2.0),
    "linked, behind": (Contacts(WIDE, -0.3, reforming=-0.2, stiffness="linked"), 1.0),
    "an exact value": (Contacts(mixture([gaussian(1.0, 0.1), identical(0.8)], [0.7, 0.3])), 1.0),
    "warm": (Contacts(gaussian(1.0, 0.05), thermal=Thermal("stiff", 0.01, 10.0)), 1.0),
    "creep": (Contacts(gaussian(1.0, 0.05), thermal=Thermal("soft", 0.1)), 1e-7),
    "creep, paper": (Contacts(gaussian(1.0, 0.05), thermal=Thermal("soft", 0.1, closure="paper")), 1e-4),
}


@pytest.mark.parametrize("name", CASES)
def test_far_on_the_force_is_the_kinetic_one_at_any_distance(name: str) -> None:
    contacts, speed = CASES[name]
    steady = master.steady_state(contacts, velocity=speed)
    with CountedCalls() as told:
        far = master.solve(contacts, steady.cycle_length * np.geomspace(2e4, 1e12, 7), 1e-8, velocity=speed)
    assert far.success and far.force_error <= 1e-8, far.message
    np.testing.assert_allclose(far.force, steady.force, atol=1e-8)
    np.testing.assert_allclose(far.holding, steady.holding, atol=1e-8)
    assert told.number < 1_000_000  # below 100,000; of 1e12 breaks, more than there are
    x = np.linspace(0.05, 1.2, 5) * steady.cycle_length
    spread = far.distribution(1e11 * steady.cycle_length)
    if not spread.delta_weights.sum() > 1e-9:
        np.testing.assert_allclose(spread.density(x), steady.distribution(x), atol=1e-5 / steady.cycle_length)


def test_what_is_never_forgotten_is_not_handed_over() -> None:
    single = master.solve(Contacts(identical(1.0)), [0.25, 3_000.25], 1e-6)
    np.testing.assert_allclose(single.force, 0.25, atol=1e-6)
    # narrow thresholds take long to forget
    path = np.array([4000.0, 4000.5])
    narrow = master.solve(Contacts(gaussian(1.0, 0.004)), path, 1e-9)
    off = np.abs(narrow.force - gaussian_force(path, 1.0, 0.004))
    assert off.max() <= narrow.force_error < 1e-7 and np.ptp(narrow.force) > 1e-5


RATES, SHARES = 10.0 ** -np.arange(0.0, 8.0, 2.0), np.array([0.9, 0.09, 0.009, 0.001])


def test_waves_that_hardly_fade_are_followed() -> None:
    path = np.linspace(3e4 - 3.0, 3e4, 60)
    found = master.solve(Contacts(gaussian(1.0, 0.002)), path, 1e-4)
    off = np.abs(found.force - gaussian_force(path, 1.0, 0.002)).max()
    assert off <= found.force_error < 1e-3
