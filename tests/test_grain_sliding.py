"""Grain contacts that pin, strengthen and break at a steady speed, against contacts one by one and closed forms."""

import numpy as np
import pytest
from grain_references import psi
from growing_contacts import along, deviation
from references import mp
from scipy.optimize import brentq, minimize_scalar

import master
import origins
from origins import Contacts, Delay, growing_grains


@pytest.mark.parametrize("velocity", [0.3, 1.0])
def test_steady_sliding_against_contacts_one_by_one(velocity: float) -> None:
    growth = origins.GrainGrowth(alpha=1.0, B=1.0)
    grains, first = origins.GrainContact(growth), growth.first_pinning_time
    steady = master.steady_state(Contacts(origins.GrainContact(growth, age=4.0)), velocity=velocity)
    # each life is a wait and a quantile for good; thresholds by the age, met on a fine grid of stretches
    x = np.linspace(0.0, last_stretch(velocity), 1001)
    ranks = np.random.default_rng(3).random(2_000)
    above = grains.quantile(ranks[:, None], first + x[1:] / velocity) > x[1:]
    reached = np.where(above.all(axis=1), x[-1], x[np.argmin(above, axis=1)])
    reached += 0.5 * x[1] * (reached > 0.0)
    length, area = reached, 0.5 * reached**2
    cycle = length.mean() + velocity * first
    force, holding = area.mean() / cycle, length.mean() / cycle
    error = (area - force * (length + velocity * first)).std() / np.sqrt(ranks.size) / cycle
    assert abs(force - steady.force) < 4.0 * error + x[1] ** 2
    spread = (length - holding * (length + velocity * first)).std() / np.sqrt(ranks.size) / cycle
    assert abs(holding - steady.holding) < 4.0 * spread + x[1]
    assert steady.force_error < 1e-12


GRAINS = growing_grains(1.0, 1.0, age=4.0)


def last_stretch(velocity: float, age: float = GRAINS.growth.first_pinning_time) -> float:
    """Stretch at which the strongest contact breaks that slides from `age` on."""

    def left(x: float) -> float:
        return float(GRAINS.quantile(1.0, age + x / velocity)) - x

    return float(brentq(left, 1e-6, 100.0))


STARTS = [
    (Contacts(GRAINS, delay=Delay(0.2)), 1.0),
    (Contacts(GRAINS, origins.gaussian_start(0.0, 0.1)), 2.0),
    (Contacts(GRAINS, -0.3), 1.0),
    # stretched by more than they could have been at this speed, so that thresholds grow beyond them at first
    (Contacts(growing_grains(1.0, 1.0, age=1.0), origins.gaussian_start(0.4, 0.1)), 0.3),
]


@pytest.mark.parametrize("contacts, velocity", STARTS)
def test_from_any_start_against_contacts_one_by_one(contacts: Contacts, velocity: float) -> None:
    path = np.linspace(0.0, 4.0, 21)[1:]
    solved = master.solve(contacts, path, 1e-8, velocity=velocity)
    assert solved.success, solved.message
    told = along(contacts, path, path / velocity, 6_000, 0.015 / velocity)
    assert deviation(contacts, solved, told) < 5.0


def test_the_first_fall_of_the_force_in_closed_form() -> None:
    """Before the wait is over none is born: F = X exp(-H), H being the hazard of the law at the age there."""
    contacts, velocity, first = Contacts(GRAINS, delay=Delay(2.5)), 1.0, GRAINS.growth.first_pinning_time

    def force(x: float) -> mp.mpf:
        largest = ((4 + mp.mpf(x) / velocity) / mp.mpf(first)) ** (mp.mpf(1) / 3)
        size = mp.sqrt(1 + mp.mpf(x) ** 2)
        return mp.mpf(x) * mp.exp(psi(1 / largest) - psi(size / largest)) if size < largest else mp.mpf(0)

    path = np.linspace(0.0, 2.7, 16)[1:]
    solved = master.solve(contacts, path, 1e-10, velocity=velocity)
    assert np.abs(solved.force - [float(force(x)) for x in path]).max() < 1e-11
    steepest = minimize_scalar(lambda x: float(mp.diff(force, x)), bounds=(1.0, 2.0), options={"xatol": 1e-9})
    highest = minimize_scalar(lambda x: -float(force(x)), bounds=(0.3, 1.5), options={"xatol": 1e-9})
    told, kinetic = master.propensity(contacts, velocity=velocity), master.steady_state(contacts, velocity=velocity)
    assert abs(told.critical_spring + steepest.fun) < max(1e-9, told.critical_spring_error) < 1e-7
    assert abs(told.static_to_kinetic * kinetic.force + highest.fun) < 1e-9 and told.static_to_kinetic_error < 1e-7
    line = master.phase_line(contacts, [velocity, 2.0], delay=[[2.5], [3.5]], tolerance=1e-8)
    assert line.critical_spring[0, 0] == pytest.approx(told.critical_spring, abs=1e-7)
    # later births than the fall are no matter, sooner ones make it less steep
    assert line.critical_spring[0, 1] == pytest.approx(line.critical_spring[1, 1], rel=1e-6)


def test_decay_to_steady_sliding() -> None:
    """With those that never hold, the travel from break to break has the transform e^(-sd) [lost + held p^(s)]."""
    velocity, contacts = 1.0, Contacts(GRAINS)
    wait = velocity * contacts.waiting_time
    spectrum = master.decoherence_spectrum(contacts, velocity=velocity, n_roots=3)
    nodes, weights = np.polynomial.legendre.leggauss(400)
    last = last_stretch(velocity)
    x, weights = 0.5 * last * (nodes + 1.0), 0.5 * last * weights
    left = np.exp(-GRAINS.hazard(x, GRAINS.growth.first_pinning_time + x / velocity))
    share = float(np.exp(-GRAINS.lost_hazard(velocity)))
    for root in spectrum.roots:
        # the transform of -dE/dx by parts, from that of the survival E
        lost, held = 1.0 - share, share - root * (weights * left) @ np.exp(-root * x)
        assert abs(np.exp(-root * wait) * (lost + held) - 1.0) < 1e-9
    told = master.propensity(contacts, velocity=velocity)
    assert told.decoherence_length == pytest.approx(spectrum.decay_length[0], rel=1e-9)


@pytest.mark.parametrize("velocity", [1e-300, 1e-60, 1e60, 1e300])
def test_speeds_beyond_floating_point_are_refused(velocity: float) -> None:
    contacts = Contacts(origins.growing_grains(1.0, 1.0, age=4.0))
    with pytest.raises(origins.InputError, match=r"^velocity = .*: is [\d.e+-]+ of that at which thresholds grow"):
        master.kinetic_curve(contacts, velocity)


@pytest.mark.parametrize("age, velocity", [(100.0, 2.0), (4.0, 3.0)])
def test_the_start_of_old_contacts_is_followed_to_its_end(age: float, velocity: float) -> None:
    """Those that form later break at a small part of the stretch of those that were there."""
    contacts = Contacts(growing_grains(1.0, 1.0, age=age))
    told = master.propensity(contacts, velocity=velocity)
    last = last_stretch(velocity, age)
    path = np.linspace(0.0, 1.2 * last, 2001)[1:]
    solved = master.solve(contacts, path, 1e-8, velocity=velocity)
    falls = -np.gradient(solved.force, path)
    assert told.critical_spring == pytest.approx(falls.max(), rel=1e-4)
    kinetic = master.steady_state(contacts, velocity=velocity).force
    assert told.static_to_kinetic == pytest.approx(solved.force.max() / kinetic, rel=1e-5)
