"""Contacts that strengthen with their age on a slider with mass: the ensemble against plain Python and master."""

from typing import Any

import numpy as np
import pytest
from conftest import slow
from plain_heavy import PlainSlider
from solving import first_slip_of_contacts, first_slip_of_master

import eq_model
from origins import Contacts, Delay, Drive, gaussian, gaussian_start, strengthening

SLIPS = ("drive", "before", "after", "force_before", "force_after", "breaks", "duration")
WIDE = gaussian(1.0, 0.2)


@pytest.mark.parametrize(("seed", "machines"), [(2, 2), *(slow(seed, 8) for seed in range(1, 6))])
def test_every_break_is_that_of_plain_python(seed: int, machines: int) -> None:
    """Which looks for the first instant at which a contact is stretched beyond its threshold of then. Drawn
    machines with holds and changes of speed, on which contacts of this age begin relaxed or stretched; growth that is a
    hundredth weaker is told apart."""
    rng, breaks = np.random.default_rng(seed), 0
    for number in range(machines):
        beta, time, age = (
            rng.uniform(0.02, 0.15),
            10.0 ** rng.uniform(-4, 1),
            10.0 ** rng.uniform(-2, 2),
        )
        law, delay = gaussian(1.0, rng.uniform(0.1, 0.4)), Delay(10.0 ** rng.uniform(-1.0, 0.3))
        stretched = gaussian_start(0.1, 0.1) if rng.random() < 0.5 else None
        mass, spring = 10.0 ** rng.uniform(-2.5, -0.3), rng.uniform(0.2, 0.6)
        pace = 10.0 ** rng.uniform(-1.0, 1.0)
        machine: dict[str, Any] = {"spring": spring, "mass": mass}
        machine["damping"] = 10.0 ** rng.uniform(-0.7, 0.3) * (mass * spring) ** 0.5
        path = np.array([1.0, 4.0, 4.0, 7.0, 9.0, 9.0, 11.0])
        machine["time"] = np.cumsum([1.0, 3.0, 2.5, 0.5, 3.0, 5.0, 2.0]) / pace
        contacts = Contacts(
            strengthening(law, beta=beta, time=time, age=age * (number % 2)),
            start=stretched,
            delay=delay if number % 3 == 0 else None,
        )
        found = eq_model.simulate(contacts, path, n_contacts=60, n_replicas=1, seed=3, **machine)
        plain = PlainSlider(contacts, Drive(path, **machine), 60, 3).follow()
        curves = np.stack([found.position, found.force, found.holding, found.contact_force])
        assert np.abs(curves - plain.curves[[0, 1, 2, 4]]).max() < 1e-6
        slips = np.stack([getattr(found.slips, name) for name in SLIPS], axis=1)
        assert slips.shape == plain.slips.shape
        assert np.abs(slips - plain.slips).max(initial=0.0) < 1e-6
        assert found.breaks == plain.breaks
        assert np.abs(found.energy.imbalance).max() < 1e-12
        breaks += found.breaks
    assert breaks > 60 * machines
    weaker = contacts.replace(thresholds=strengthening(law, 0.99 * beta, time, age))
    other = eq_model.simulate(weaker, path, n_contacts=60, n_replicas=1, seed=3, **machine)
    assert np.abs(other.force - found.force).max() > 1e-5


@pytest.mark.slow  # some 15 s
def test_the_slip_is_that_of_the_master_equation() -> None:
    """And the force at 27 places of the drive before and after, extrapolated from 4,000 and 32,000 contacts; growth
    that is a tenth weaker is told apart."""
    path = np.linspace(0.2, 5.4, 27)
    machine = {"spring": 0.3, "mass": 0.01, "damping": 0.02, "velocity": 0.5}

    def grown(beta: float) -> Contacts:
        return Contacts(strengthening(WIDE, beta=beta, time=1e-2))

    solved = first_slip_of_master(grown(0.05), path, 1e-3, **machine)
    assert first_slip_of_contacts(grown(0.05), path, **machine).apart(solved) < 4.0
    assert first_slip_of_contacts(grown(0.045), path, **machine).apart(solved) > 8.0
