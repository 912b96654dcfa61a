"""Errors of the energies of a slider with mass by the master equation, beside finer runs."""

from typing import Any

import numpy as np
import pytest
from solving import WALL_TIME

import master
import origins
from master.soft.inertia.energy_errors import PARTS

WIDE = origins.gaussian(1.0, 0.5)


def solve(contacts: origins.Contacts, path: Any, tolerance: float, **drive: Any) -> Any:
    return master.solve(contacts, path, tolerance, **{"wall_time": WALL_TIME} | drive)


def off_and_told(contacts: origins.Contacts, tolerance: float, finer: float, **drive: Any) -> Any:
    """By how much each part of the energy is off at any point, and its error, both as told: shape (2, parts)."""
    found, known = (solve(contacts, tolerance=asked, **drive) for asked in (tolerance, finer))
    assert found.success and known.success, (found.message, known.message)
    off = [np.abs(getattr(found.energy, of) - getattr(known.energy, of)).max() for of in PARTS]
    told = [getattr(found.energy_error, of) + getattr(known.energy_error, of) for of in PARTS]
    return np.array([off, told])


@pytest.mark.parametrize("delay", [None, origins.Delay(3.0)])
def test_each_part_of_the_energy_has_an_error(delay: origins.Delay | None) -> None:
    contacts = origins.Contacts(origins.gaussian(1.0, 0.2), delay=delay)
    path, machine = np.linspace(0.2, 14.0, 50), {"spring": 0.1, "mass": 0.1, "damping": 0.05}
    off, told = off_and_told(contacts, 1e-2, 5e-4, path=path, **machine)
    assert (off < told).all() and (told < 0.05).all()
    found = solve(contacts, path[:9], 1e-2, **machine)
    assert np.abs(found.energy.imbalance).max() < 1e-5 and found.energy.start < 1e-20
    stopped = solve(contacts, path, 1e-2, **machine, wall_time=1e-9)
    assert not stopped.success
    assert all(getattr(stopped.energy_error, of) == np.inf for of in PARTS)


@pytest.mark.slow  # quick: each part of the energy has an error, of a slip after a delay, too
def test_what_contacts_release_on_a_slip_of_a_million_thresholds_is_told_with_its_error() -> None:
    """On its way a hardly known force of next to no contacts adds up to many times what they can release: each breaks
    a few times."""
    contacts = origins.Contacts(WIDE, delay=origins.Delay(14.0))
    machine = {"spring": 1e-6, "mass": 2e-9, "damping": 2e-8, "velocity": 162.0}
    found = solve(contacts, [1.2e6], 5e-2, **machine)
    known = solve(contacts, [1.2e6], 1e-4, **machine)
    off = float(np.abs(found.energy.released - known.energy.released)[-1])
    assert found.success and known.energy.released[-1] < 5.0
    assert 10.0 < off < found.energy_error.released


@pytest.mark.slow
def test_errors_of_energies_hold_for_drawn_machines() -> None:
    """A part of the error of force and slips is one of the drive's and the spring's energies; others are seen by two
    runs alone, and by what is missing of the balance."""
    rng = np.random.default_rng(4)
    ratios = []
    for _ in range(16):
        law = origins.gaussian(1.0, rng.uniform(0.1, 0.6))
        spring = 10 ** rng.uniform(-2.0, 0.0)
        mass = spring * 10 ** rng.uniform(-1.0, 2.0)
        swing = 2.0 * np.pi * (mass / spring) ** 0.5
        delay = rng.choice([0.0, 10 ** rng.uniform(-1.0, 1.0) * swing])
        machine = {
            "spring": spring,
            "mass": mass,
            "damping": rng.choice([0.1, 0.3, 1.0]) * 2.0 * (mass * spring) ** 0.5,
            "velocity": 10 ** rng.uniform(-1.5, 0.5),
            "path": np.linspace(0.1, rng.uniform(1.5, 4.0) / spring, 37),
        }
        contacts = origins.Contacts(law, delay=origins.Delay(delay) if delay else None)
        tolerance = 10 ** rng.uniform(-3.0, -1.2)
        off, told = off_and_told(contacts, tolerance, tolerance / 30.0, **machine)
        ratios.append(off / told)
    assert np.max(ratios) < 1.0 and np.median(ratios) > 1e-3


@pytest.mark.slow
def test_errors_of_energies_hold_in_steps_of_time() -> None:
    contacts = origins.Contacts(
        origins.gaussian(1.0, 0.2), thermal=origins.Thermal("eyring", width=0.03)
    )
    machine = {"spring": 0.1, "mass": 0.3, "damping": 0.1, "velocity": 0.5}
    off, told = off_and_told(contacts, 3e-2, 3e-3, path=np.linspace(0.2, 15.0, 16), **machine)
    assert (off < told).all() and (told < 0.3).all()
