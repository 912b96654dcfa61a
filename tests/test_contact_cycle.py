"""Delay, re-forming at other stretches and linked stiffness, alone, together and at a temperature."""

import numpy as np
import pytest

import master
from origins import (
    Contacts,
    Delay,
    Thermal,
    boltzmann_reforming,
    gaussian,
    gaussian_start,
    identical,
    mixture,
    rectangular,
)
from tests.sampling_contacts import sample

PATH = np.linspace(0.05, 5.0, 23) + 0.013
WIDE, WAIT, WARM = gaussian(1.0, 0.2), Delay(0.3), Thermal("soft", 0.1)
CASES = {
    "delay": lambda: Contacts(WIDE, gaussian_start(0.1, 0.05), delay=WAIT),
    "delay, exact values": lambda: Contacts(
        mixture([gaussian(1.0, 0.1), identical(0.8)], [0.7, 0.3]), delay=WAIT
    ),
    "delay, jumps": lambda: Contacts(rectangular(0.5, 1.5), delay=WAIT),
    "linked": lambda: Contacts(WIDE, gaussian_start(0.1, 0.05), stiffness="linked"),
    "linked, delay, behind": lambda: Contacts(WIDE, -0.6, stiffness="linked", delay=WAIT),
    "linked, warm, delay": lambda: Contacts(
        WIDE, -0.4, stiffness="linked", thermal=WARM, delay=WAIT
    ),
    "ahead": lambda: Contacts(WIDE, reforming=0.2),
    "behind, delay": lambda: Contacts(WIDE, reforming=-0.2, delay=WAIT),
    "around": lambda: Contacts(WIDE, 0.1, reforming=boltzmann_reforming(0.01)),
    "around, linked, delay": lambda: Contacts(
        WIDE, reforming=gaussian_start(0.05, 0.05), stiffness="linked", delay=WAIT
    ),
    "ahead, warm, delay": lambda: Contacts(WIDE, 0.1, reforming=0.1, thermal=WARM, delay=WAIT),
    "ahead, warm, linked": lambda: Contacts(
        WIDE, 0.1, reforming=0.1, thermal=WARM, stiffness="linked"
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_transients_are_those_of_discrete_contacts(name: str) -> None:
    contacts = CASES[name]()
    solved = master.solve(contacts, PATH, 1e-7)
    assert solved.success, solved.message
    count = 100_000
    force, error, holding = sample(contacts, PATH, 1.0, count)
    assert (np.abs(solved.force - force) < 5.0 * (error + solved.force_error)).all()
    spread = np.sqrt(np.maximum(holding * (1.0 - holding), 1.0 / count) / count)
    assert (np.abs(solved.holding - holding) < 5.0 * spread + 1e-7).all()


@pytest.mark.parametrize("name", CASES)
def test_long_paths_end_in_the_steady_state(name: str) -> None:
    contacts = CASES[name]()
    steady = master.steady_state(contacts)
    assert steady.force_error < 1e-9
    long = master.solve(contacts, np.linspace(60.0, 150.0, 40), 1e-9)
    assert long.success, long.message
    off = np.abs(long.force - steady.force)
    assert off[-1] <= 3e-9 or off[-8:].max() < 0.3 * off[:8].max()  # exact values decay slowly
    assert np.abs(long.holding[-1] - steady.holding) <= 1e-8 or off[-1] > 3e-9


def test_holding_is_the_ratio_of_lengths_and_nothing_is_lost() -> None:
    contacts = Contacts(rectangular(0.5, 1.5), 0.2, delay=Delay(0.125))
    solved = master.solve(contacts, [200.0], 1e-10, velocity=2.0)
    assert solved.holding[0] == pytest.approx(1.0 / 1.25, abs=1e-10)
    assert master.steady_state(contacts, velocity=2.0).holding == pytest.approx(0.8, abs=1e-15)
    # what holds, counted from Q(x;X), and what broke within the last wait make one
    contacts = Contacts(gaussian(1.0, 0.1), delay=Delay(0.25))
    path = np.array([0.4, 1.1, 1.3, 2.0, 3.3])
    solved = master.solve(contacts, path, 1e-10)
    nodes, weights = np.polynomial.legendre.leggauss(200)
    for x, holding in zip(path, solved.holding, strict=True):
        spread = solved.distribution(float(x))
        panels = np.linspace(0.0, x, 9)
        half = 0.5 * np.diff(panels)[:, None]
        at = panels[:-1, None] + half * (nodes + 1.0)
        counted = float((half * weights * spread.density(at)).sum()) + spread.delta_weights.sum()
        assert counted == pytest.approx(holding, abs=1e-9)


def test_one_value_with_a_delay_is_a_sawtooth_with_gaps() -> None:
    contacts = Contacts(identical(1.0), delay=Delay(0.5))
    path = np.array([0.7, 1.2, 1.6, 2.4, 2.7, 3.5])
    solved = master.solve(contacts, path, 1e-10)
    np.testing.assert_allclose(solved.force, [0.7, 0.0, 0.1, 0.9, 0.0, 0.5], atol=1e-12)
    np.testing.assert_allclose(solved.holding, [1.0, 0.0, 1.0, 1.0, 0.0, 1.0], atol=1e-12)
    twice = master.solve(
        Contacts(identical(2.0), reforming=0.5, stiffness="linked"), [1.9, 2.4, 3.6], 1e-10
    )
    np.testing.assert_allclose(twice.force, [1.9, 0.9, 0.6], atol=1e-12)


def test_steady_forces_in_closed_form() -> None:
    mean, square, cube = (WIDE.moment(n) for n in (1, 2, 3))
    linked = master.steady_state(Contacts(WIDE, stiffness="linked"))
    assert linked.force == pytest.approx(cube / (2.0 * mean**2), rel=1e-12)
    delayed = master.steady_state(Contacts(WIDE, delay=WAIT), velocity=2.0)
    assert delayed.force == pytest.approx(square / (2.0 * (mean + 0.6)), rel=1e-12)
    # far from all thresholds births at r only shift where each contact begins
    box, r = rectangular(0.8, 1.2), -0.3
    shifted = master.steady_state(Contacts(box, reforming=r))
    assert shifted.cycle_length == pytest.approx(1.0 - r, rel=1e-12)
    assert shifted.force == pytest.approx((box.moment(2) - r * r) / (2.0 * (1.0 - r)), rel=1e-12)
    around = master.steady_state(Contacts(box, reforming=boltzmann_reforming(1e-3)))
    assert around.force == pytest.approx((box.moment(2) - 1e-3) / 2.0, rel=1e-10)


@pytest.mark.parametrize("name", ["delay", "ahead", "around", "ahead, warm, delay"])
def test_steady_distribution_carries_what_holds_and_the_force(name: str) -> None:
    contacts = CASES[name]()
    steady = master.steady_state(contacts)
    edges = np.unique(np.concatenate([np.linspace(-1.0, 2.7, 60), [0.0, 0.1, 0.2]]))
    nodes, weights = np.polynomial.legendre.leggauss(8)
    half = 0.5 * np.diff(edges)[:, None]
    x = edges[:-1, None] + half * (nodes + 1.0)
    density = steady.distribution(x) * half * weights
    assert density.sum() == pytest.approx(steady.holding, abs=1e-8)
    assert (density * x).sum() == pytest.approx(steady.force, abs=1e-8)


def test_linked_contacts_that_break_early_keep_the_stiffness_they_were_born_with() -> None:
    # hundreds of breaks of each: what a table lacks would add up as their square
    contacts = Contacts(gaussian(1.0, 0.2), thermal=Thermal("soft", 0.4484), stiffness="linked")
    steady = master.steady_state(contacts, velocity=0.01)
    assert steady.cycle_length < 0.05
    solved = master.solve(contacts, [20.0, 25.0], 1e-9, velocity=0.01)
    assert solved.success and solved.force_error < 1e-9
    assert (np.abs(solved.force - steady.force) <= solved.force_error + steady.force_error).all()


def test_linked_contacts_that_start_in_the_far_tail_bear_what_their_thresholds_can() -> None:
    """As many as one in 1e13 stand where no survival is a number; before any break all move with the slider."""
    contacts = Contacts(gaussian(1.0, 0.0027), gaussian_start(0.0, 0.15), stiffness="linked")
    solved = master.solve(contacts, [0.05, 0.1, -0.1], 1e-6, wall_time=60.0)
    assert solved.success and np.abs(solved.force - [0.05, 0.1, -0.1]).max() < 1e-6
