"""The force on a path forward, against every exact answer there is."""

from __future__ import annotations

from math import factorial
from typing import NamedTuple

import numpy as np
import pytest
import scipy.stats
from conftest import slow
from phase_type import coxian, gaussian_force, hyper_erlang
from solving import held_to_claim

import master
import origins

SCENE = origins.Contacts(origins.gaussian(1.0, 0.05), origins.gaussian_start(0.0, 0.025))
PATH = np.linspace(0.0, 5.0, 501)
CHAINS = {
    "exponential": hyper_erlang([1.0], [1], [2.0]),
    "erlang": hyper_erlang([1.0], [5], [5.0]),
    "hyper-exponential": hyper_erlang([0.3, 0.7], [1, 1], [0.5, 5.0]),
    "hyper-erlang": hyper_erlang([0.2, 0.8], [4, 2], [8.0, 1.0]),
    "coxian": coxian(2.0, 0.7, 0.6),
}


@pytest.mark.parametrize("start", [0.4, -0.3])
@pytest.mark.parametrize("name", CHAINS)
def test_phase_type_thresholds(name, start):
    chain = CHAINS[name]
    contacts = origins.Contacts(chain.law, start * chain.mean)
    path = np.concatenate([[0.0, 1e-7, 1e-3], np.linspace(0.01, 12.0, 150)]) * chain.mean
    held_to_claim(contacts, path, 1e-9, chain.force(path, start * chain.mean))


def test_identical_thresholds_are_a_sawtooth_for_ever():
    path = np.linspace(0.0, 50.0, 1001) + 0.01
    for at, force in ((path, path % 1.0), (np.arange(0.0, 51.0), 0.0)):
        found = master.solve(origins.Contacts(origins.identical(1.0)), at, 1e-9)
        assert found.success and np.abs(found.force - force).max() <= 1e-12


def test_two_commensurate_values_are_a_sawtooth_for_ever():
    law = origins.mixture([origins.identical(0.95), origins.identical(1.05)], [0.5, 0.5])
    # whole numbers of their common divisor 0.05, one by one: 19 and 21 of them are the thresholds
    births, released = np.eye(1, 241)[0], np.zeros(241)
    for j in range(19, births.size):
        births[j] = 0.5 * (births[j - 19] + (births[j - 21] if j >= 21 else 0.0))
        released[j] = 0.5 * (0.95 * births[j - 19] + (1.05 * births[j - 21] if j >= 21 else 0.0))
    released = np.cumsum(released)
    for beyond in (0.0, 0.0123):
        path = 0.05 * np.arange(240) + beyond
        held_to_claim(origins.Contacts(law), path, 1e-9, path - released[:-1])


# width of Gaussian thresholds, path, tolerance
NARROW = [
    (1e-3, np.linspace(0.0, 8.0, 321), 1e-8),
    slow(0.01, np.append(np.linspace(0.0, 60.0, 301), 4000.3), 1e-6),
    slow(0.002, np.linspace(3e4 - 3.0, 3e4, 60), 1e-4),
    slow(0.004, np.array([4000.0, 4000.5]), 1e-8),
]


@pytest.mark.parametrize(("std", "path", "tolerance"), NARROW)
def test_narrow_thresholds_hardly_fade(std, path, tolerance):
    contacts = origins.Contacts(origins.gaussian(1.0, std))
    held_to_claim(contacts, path, tolerance, gaussian_force(path, 1.0, std))


def spread(s):
    return origins.gaussian_start(0.02 * s, 0.05 * s)


@pytest.mark.parametrize(
    ("law", "start", "scale"),
    [
        (lambda s: origins.gaussian(s, 0.1 * s), lambda s: 0.1 * s, 1e-9),
        (lambda s: origins.gw_elastic(s ** (-4.0 / 3.0)), lambda s: 0.1 * s, 1e9),
        (lambda s: origins.rectangular(0.5 * s, 1.5 * s), spread, 1e9),
        (
            lambda s: origins.mixture(
                [origins.identical(0.8 * s), origins.gaussian(s, 0.1 * s)], [0.3, 0.7]
            ),
            spread,
            1e-9,
        ),
    ],
)
def test_lengths_only_set_the_scale(law, start, scale):
    one, other = (
        master.solve(origins.Contacts(law(s), start(s)), s * PATH[::10], 1e-8) for s in (1.0, scale)
    )
    assert np.abs(other.force / scale - one.force).max() <= 1e-12
    # below round-off the estimate itself is noise
    assert other.force_error == pytest.approx(one.force_error, rel=1e-2, abs=2e-13)


@pytest.mark.parametrize(
    "path",
    [
        [0.0],
        [2.345],
        [0.0, 0.0, 0.0],
        [0.5, 0.5, 1.7, 1.7, 1.7, 3.0],
        [0.0, 300.0],
        [1e-300, 1e-12, 1.0],
        np.sort(np.random.default_rng(2).uniform(0.0, 8.0, 100_000)),
    ],
    ids=["origin", "one", "zeros", "repeated", "far", "tiny", "many"],
)
def test_any_path(path):
    path = np.asarray(path)
    found = held_to_claim(SCENE, path, 1e-8, gaussian_force(path, 1.0, 0.05, 0.0, 0.025))
    assert found.force.shape == path.shape and (found.path == path).all()
    assert (found.holding == 1.0).all()


@pytest.mark.parametrize("law", [origins.gaussian(1.0, 0.05), slow(scipy.stats.gamma(0.5))])
def test_a_tolerance_beyond_reach_is_said(law):
    contacts, path = origins.Contacts(law, 0.1), PATH[:121:20]
    solution = master.solve(contacts, path, 1e-17)
    assert not solution.success and solution.force_error > 1e-17
    assert "above the tolerance 1.0e-17" in solution.message
    assert np.isfinite(solution.force).all()
    off = solution.force - master.solve(contacts, path, 1e-8).force
    assert np.abs(off).max() < 1e-8


WIDE, LAW = origins.gaussian(1.0, 0.2), origins.gaussian(1.0, 0.05)
PAPER = origins.Thermal("soft", 0.1, closure="paper")
MIXED = origins.mixture([origins.gaussian(1.0, 0.1), origins.identical(0.8)], [0.7, 0.3])
CASES = {
    "cold": (origins.Contacts(LAW, origins.gaussian_start(0.1, 0.025)), 1.0),
    "delay": (origins.Contacts(origins.rectangular(0.5, 1.5), 0.3, delay=origins.Delay(0.3)), 2.0),
    "linked, behind": (origins.Contacts(WIDE, -0.3, reforming=-0.2, stiffness="linked"), 1.0),
    "an exact value": (origins.Contacts(MIXED), 1.0),
    "warm": (origins.Contacts(LAW, thermal=origins.Thermal("stiff", 0.01, 10.0)), 1.0),
    "creep": (origins.Contacts(LAW, thermal=origins.Thermal("soft", 0.1)), 1e-7),
    "creep, paper": (origins.Contacts(LAW, thermal=PAPER), 1e-4),
}


@pytest.mark.parametrize("name", CASES)
def test_far_on_the_force_is_the_kinetic_one_at_any_distance(name: str) -> None:
    contacts, speed = CASES[name]
    steady = master.steady_state(contacts, velocity=speed)
    path = steady.cycle_length * np.geomspace(2e4, 1e12, 7)
    far = master.solve(contacts, path, 1e-8, velocity=speed)
    assert far.success and far.force_error <= 1e-8, far.message
    np.testing.assert_allclose(far.force, steady.force, atol=1e-8)
    np.testing.assert_allclose(far.holding, steady.holding, atol=1e-8)
    x = np.linspace(0.05, 1.2, 5) * steady.cycle_length
    held = far.distribution(1e11 * steady.cycle_length)
    if not held.delta_weights.sum() > 1e-9:
        known, off = steady.distribution(x), 1e-5 / steady.cycle_length
        np.testing.assert_allclose(held.density(x), known, atol=off)


def test_a_narrow_panel_on_which_breaks_are_steady_ends_nothing() -> None:
    """Two ends of rectangles, 1e-5 apart, make panels so narrow that neither the rate of breaks nor F changes on them.
    A turn just behind the path's end keeps the march from ending early."""
    boxes = [origins.rectangular(0.8, 1.0), origins.rectangular(0.8, 1.00001)]
    contacts, path = (
        origins.Contacts(origins.mixture(boxes, [0.5, 0.5])),
        np.linspace(0.0, 30.0, 61),
    )
    found = master.solve(contacts, path, 1e-3)
    whole = master.solve(contacts, np.append(path, 29.999), 1e-3)
    assert found.success and whole.success
    assert np.abs(found.force - whole.force[:-1]).max() <= found.force_error + whole.force_error


def test_exponential_thresholds_forget_where_they_start() -> None:
    found = master.solve(origins.Contacts(scipy.stats.expon(), 45.0), [0.0, 1.0, 5.0], 1e-10)
    assert found.force == pytest.approx(1.0 + 44.0 * np.exp(-found.path), abs=1e-9)


# At a density of 1e6 what is claimed at 1e-8 is 2.1e-8: checks see the last gap of a panel near X = 18, too.
@pytest.mark.parametrize(("width", "tolerance"), [(1e-3, 1e-8), (1e-6, 3e-8)])
@pytest.mark.slow
def test_narrow_rectangle_between_two_generations(width: float, tolerance: float) -> None:
    """At X = n + 1/2 every contact has broken n times, and released n mean thresholds."""
    contacts = origins.Contacts(origins.rectangular(1.0, 1.0 + width))
    path = np.array([0.0, 5.5, 20.5])
    found = master.solve(contacts, path, tolerance)
    error = np.abs(found.force - (path - np.floor(path) * (1.0 + 0.5 * width))).max()
    assert found.success and error <= found.force_error


class Power(NamedTuple):
    """factor (x - begin)^degree/degree! from `begin` on, 0 before."""

    begin: float
    degree: int
    factor: float

    def at(self, x: np.ndarray) -> np.ndarray:
        values = self.factor * (x - self.begin) ** self.degree / factorial(self.degree)
        return np.where(x >= self.begin, values, 0.0)

    def convolved(self, other: Power) -> Power:
        degree = self.degree + other.degree + 1
        return Power(self.begin + other.begin, degree, self.factor * other.factor)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-8])
def test_births_on_panels_of_many_widths_with_jumps_and_a_delay(tolerance: float) -> None:
    """A rectangular law makes survival, force and delayed births sums of powers, and so are their convolutions. Panels
    next to the bends are narrow, others wide."""
    delay, path = 0.3, np.linspace(0.0, 4.0, 401)
    holding = [Power(0.0, 0, 1.0), Power(0.5, 1, -1.0), Power(1.5, 1, 1.0)]
    force = [Power(0.0, 1, 1.0), Power(0.5, 1, -0.5), Power(0.5, 2, -2.0)]
    force += [Power(1.5, 1, 1.5), Power(1.5, 2, 2.0)]
    birth_to_birth = [
        Power(0.5 + delay, 0, 1.0),
        Power(1.5 + delay, 0, -1.0),
    ]  # density of that way

    def of_all_births(after_one: list[Power]) -> np.ndarray:
        total, powers = np.zeros(path.size), after_one
        for _ in range(6):  # up to X = 4 no contact is born again more than 5 times
            total += sum(power.at(path) for power in powers)
            powers = [power.convolved(way) for power in powers for way in birth_to_birth]
        return total

    contacts = origins.Contacts(origins.rectangular(0.5, 1.5), delay=origins.Delay(delay))
    found = held_to_claim(contacts, path, tolerance, of_all_births(force), velocity=1.0)
    assert np.abs(found.holding - of_all_births(holding)).max() <= found.force_error


def test_a_cold_path_imports_no_law_that_it_does_not_name(python):
    """Neither heat, ageing and springs nor other questions: a fresh process solves the README's scene without them."""
    done = python("""
import sys
import master, origins
contacts = origins.Contacts(origins.gaussian(1.0, 0.05), origins.gaussian_start(0.0, 0.025))
master.solve(contacts, [0.0, 1.0, 2.0])
print(*(name.removeprefix("master.") for name in sys.modules if name.startswith("master.")))
print(*(name for name in sys.modules if name.startswith(("scipy.optimize", "scipy.interpolate"))))
""")
    rooms, packages = done.stdout.splitlines()
    assert {name.split(".")[0] for name in rooms.split()} == {
        *("motion", "numerics", "outcome", "rate_state", "renewal", "rigid"),
        *("solution", "solve", "survival"),
    }
    law_files = {name for name in rooms.split() if name.startswith(("survival.", "rate_state."))}
    assert law_files == {"survival.changing", "survival.life", "survival.make"}
    assert "renewal.strand_births" not in rooms and not packages
