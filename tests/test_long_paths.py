"""Paths far beyond where contacts have forgotten their start: the kinetic force, once nothing else is left of it."""

import numpy as np
import pytest
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
    far = master.solve(contacts, steady.cycle_length * np.geomspace(2e4, 1e12, 7), 1e-8, velocity=speed)
    assert far.success and far.force_error <= 1e-8, far.message
    np.testing.assert_allclose(far.force, steady.force, atol=1e-8)
    np.testing.assert_allclose(far.holding, steady.holding, atol=1e-8)
    assert far.run_time < 30.0  # as many breaks as there are would take years
    x = np.linspace(0.05, 1.2, 5) * steady.cycle_length
    spread = far.distribution(1e11 * steady.cycle_length)
    if not spread.delta_weights.sum() > 1e-9:
        np.testing.assert_allclose(spread.density(x), steady.distribution(x), atol=1e-5 / steady.cycle_length)


@pytest.mark.parametrize("std", [0.05, 0.1])
def test_nothing_is_handed_over_too_early(std: float) -> None:
    contacts = Contacts(gaussian(1.0, std), gaussian_start(0.1, 0.025))
    x = np.append(np.linspace(0.0, 900.0, 7001), 5e3)
    found = master.solve(contacts, x, 1e-9)
    exact = gaussian_force(x[:-1], 1.0, std, 0.1, 0.025)
    assert found.success
    assert np.abs(found.force[:-1] - exact).max() <= found.force_error


def test_what_is_never_forgotten_is_not_handed_over() -> None:
    single = master.solve(Contacts(identical(1.0)), [0.25, 30_000.25], 1e-6)
    np.testing.assert_allclose(single.force, 0.25, atol=1e-6)
    # narrow thresholds take longer to forget than round-off allows to follow them
    path = np.array([4000.0, 4000.5])
    narrow = master.solve(Contacts(gaussian(1.0, 0.004)), path, 1e-10)
    assert not narrow.success and "round-off" in narrow.message
    off = np.abs(narrow.force - gaussian_force(path, 1.0, 0.004))
    assert off.max() <= narrow.force_error < 1e-7 and np.ptp(narrow.force) > 1e-5
