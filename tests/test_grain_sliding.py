"""Grain contacts that pin, strengthen and break, against closed forms and their own quantiles."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from conftest import slow
from references import mp, psi
from scipy.optimize import brentq, minimize_scalar
from solving import gauss, through

import eq_model
import master
from origins import Contacts, Delay, InputError, Thermal, growing_grains
from toolkit.stability.cohorts import by_cohorts

GRAINS = growing_grains(1.0, 1.0, age=4.0)


def last_stretch(velocity: float) -> float:
    """Stretch at which the strongest contact breaks that slides from its pinning on."""

    def left(x: float) -> float:
        first = GRAINS.growth.first_pinning_time
        return float(GRAINS.quantile(1.0, first + x / velocity)) - x

    return float(brentq(left, 1e-6, 100.0))


def test_the_first_fall_of_the_force_in_closed_form() -> None:
    """Before the wait is over none is born: F = X exp(-H), H being the hazard of the law at the age there."""
    contacts, velocity = Contacts(GRAINS, delay=Delay(2.5)), 1.0
    first = mp.mpf(GRAINS.growth.first_pinning_time)

    def force(x: float) -> mp.mpf:
        largest = ((4 + mp.mpf(x) / velocity) / first) ** (mp.mpf(1) / 3)
        size = mp.sqrt(1 + mp.mpf(x) ** 2)
        return x * mp.exp(psi(1 / largest) - psi(size / largest)) if size < largest else mp.mpf(0)

    path = np.linspace(0.0, 2.7, 16)[1:]
    solved = master.solve(contacts, path, 1e-10, velocity=velocity)
    assert np.abs(solved.force - [float(force(x)) for x in path]).max() < 1e-11
    fine = {"xatol": 1e-9}
    steepest = minimize_scalar(lambda x: float(mp.diff(force, x)), bounds=(1.0, 2.0), options=fine)
    highest = minimize_scalar(lambda x: -float(force(x)), bounds=(0.3, 1.5), options=fine)
    told = master.propensity(contacts, velocity=velocity)
    kinetic = master.steady_state(contacts, velocity=velocity)
    assert abs(told.critical_spring + steepest.fun) < max(1e-9, told.critical_spring_error) < 1e-7
    assert abs(told.static_to_kinetic * kinetic.force + highest.fun) < 1e-9
    assert told.static_to_kinetic_error < 1e-7
    line = master.phase_line(contacts, [velocity, 2.0], delay=[[2.5], [3.5]], tolerance=1e-8)
    assert line.critical_spring[0, 0] == pytest.approx(told.critical_spring, abs=1e-7)
    # later births than the fall are no matter, sooner ones make it less steep
    assert line.critical_spring[0, 1] == pytest.approx(line.critical_spring[1, 1], rel=1e-6)


@pytest.mark.slow
def test_steady_sliding_and_the_decay_to_it() -> None:
    """With those that never hold, the travel from break to break has the transform e^(-sd) [lost + held p^(s)]."""
    velocity, contacts = 1.0, Contacts(GRAINS)
    wait, last = velocity * contacts.waiting_time, last_stretch(velocity)
    spectrum = master.decoherence_spectrum(contacts, velocity=velocity, n_roots=3)
    x, weights = gauss([0.0, last], 400)
    left = np.exp(-GRAINS.hazard(x, GRAINS.growth.first_pinning_time + x / velocity))
    share = float(np.exp(-GRAINS.lost_hazard(velocity)))
    steady, cycle = master.steady_state(contacts, velocity=velocity), wait + weights @ left
    assert abs(steady.force - weights @ (x * left) / cycle) < 1e-9
    assert abs(steady.holding - weights @ left / cycle) < 1e-9 > steady.force_error
    for root in spectrum.roots:
        # the transform of -dE/dx by parts, from that of the survival E
        lost, held = 1.0 - share, share - root * (weights * left) @ np.exp(-root * x)
        assert abs(np.exp(-root * wait) * (lost + held) - 1.0) < 1e-9
    told = master.propensity(contacts, velocity=velocity)
    assert told.decoherence_length == pytest.approx(spectrum.decay_length[0], rel=1e-9)


TIMES, PLACES = np.array([0.0, 1.0, 2.5, 4.0, 5.0]), np.array([0.0, 0.7, -0.2, -0.2, 1.8])


def left_one_by_one(start, until, thermal=None):
    """Share of those that began at a stretch and hold on TIMES, PLACES, by quantiles and midpoints of time."""
    ends = np.unique(np.append(TIMES[until > TIMES], until))
    graded = 0.5 - 0.5 * np.cos(np.pi * np.linspace(0.0, 1.0, 241))
    t = np.unique(np.concatenate([a + (b - a) * graded for a, b in pairwise(ends)]))
    x = start + np.interp(t, TIMES, PLACES)
    before = float(GRAINS.hazard(abs(start), 4.0))
    worst = max(float(GRAINS.hazard(np.abs(x[1:]), 4.0 + t[1:]).max()), before)
    if thermal is None:
        return np.exp(before - worst)
    root = np.sqrt(20.0) * (np.arange(400) + 0.5) / 400.0
    hazard, middle = worst + root**2, 0.5 * (t[1:] + t[:-1])
    limit = GRAINS.quantile(-np.expm1(-hazard[:, None]), 4.0 + middle)
    stretch = np.minimum(np.abs(0.5 * (x[1:] + x[:-1])), limit)
    spent = thermal.rate(stretch, limit) @ np.diff(t)
    weight = 2.0 * root * np.sqrt(20.0) / 400.0
    return float((weight * np.exp(before - hazard - spent)).sum())


def test_what_holds_on_a_path_that_turns_is_that_of_its_quantiles():
    """Of the first contacts alone: broken ones stay out."""
    for start in (0.0, 0.3):
        contacts = Contacts(GRAINS, start, delay=Delay(1e3))
        time = np.array([0.8, 1.0, 1.8, 2.5, 3.3, 4.0, 4.6, 5.0])
        found = master.solve(contacts, np.interp(time, TIMES, PLACES), 1e-4, time=time)
        exact = [left_one_by_one(start, t) for t in time]
        assert found.success
        assert np.abs(found.holding - exact).max() <= found.force_error + 2e-4


# stiff contacts have a kernel of their own, which takes as long to compile as this file to run
@pytest.mark.parametrize("law", ["soft", slow("stiff")])
def test_with_heat_the_ensemble_alone_follows_a_path_that_turns(law):
    thermal, time = Thermal(law, 0.1, 2.0), np.array([0.8, 1.0, 1.8, 2.5, 3.3])
    contacts, path = (
        Contacts(GRAINS, 0.3, thermal, delay=Delay(1e3)),
        np.interp(time, TIMES, PLACES),
    )
    with pytest.raises(InputError, match=r"^contacts\.thermal: .*use eq_model\.simulate"):
        master.solve(contacts, path, 1e-3, time=time)
    exact = np.array([left_one_by_one(0.3, t, thermal) for t in time])
    found = eq_model.simulate(contacts, path, time=time, n_contacts=20_000, seed=3)
    scatter = np.sqrt(exact * (1.0 - exact) / 20_000)
    assert (np.abs(found.holding - exact) < 4.0 * scatter + 2e-4).all()


def test_far_along_the_force_is_that_of_steady_sliding() -> None:
    """One road steps in time and lets those that never hold wait again, the other knows their mean wait alone."""
    contacts, velocity = Contacts(GRAINS, 0.05), 1.0
    steady = master.steady_state(contacts, velocity=velocity)
    far = master.solve(contacts, [12.0], 1e-3, time=[12.0 / velocity])
    error = far.force_error * contacts.mean_threshold
    assert far.success and abs(far.force[0] - steady.force) < error
    assert far.holding[0] == pytest.approx(steady.holding, abs=3e-4)
    curve = master.kinetic_curve(contacts, [velocity, 2.0], delay=[[0.0], [0.3]])
    assert curve.force[0, 0] == steady.force and (np.diff(curve.holding) < 0.0).all()
    assert (curve.holding[1] < curve.holding[0]).all()


def test_contacts_at_rest_grow_stronger() -> None:
    path = np.concatenate([[2.0, 2.0], np.linspace(2.2, 4.0, 10)])
    peaks = []
    for hold in (1.0, 30.0):
        time = np.concatenate([[2.0, 2.0 + hold], hold + path[2:]])
        solved = master.solve(Contacts(GRAINS), path, 5e-3, time=time)
        # nothing breaks at rest, but for the error of the solution
        assert solved.success and abs(solved.force[1] - solved.force[0]) < 1e-8 < solved.force_error
        peaks.append(float(solved.force[2:].max()))
    assert (np.diff(peaks) > 0.1).all(), peaks


@pytest.mark.slow
def test_steady_sliding_and_what_follows_from_it() -> None:
    contacts, velocity = Contacts(GRAINS, thermal=Thermal("soft", 0.1)), 1.0
    steady = master.steady_state(contacts, velocity=velocity)
    far = master.solve(contacts, [30.0], 1e-9, velocity=velocity)
    assert far.force[0] == pytest.approx(steady.force, abs=1e-8) and steady.force_error < 1e-9
    assert far.holding[0] == pytest.approx(steady.holding, abs=1e-8)
    curve = master.kinetic_curve(contacts, velocity, temperature=[0.0, 1e-3, 0.1, 1.0])
    assert curve.force[2] == steady.force and (np.diff(curve.force) < 0.0).all()
    assert curve.force[0] == master.steady_state(Contacts(GRAINS), velocity=velocity).force
    told = master.propensity(contacts, velocity=velocity)
    line = master.phase_line(contacts, velocity, temperature=[0.0, 0.1], tolerance=1e-8)
    assert line.critical_spring[1] == pytest.approx(told.critical_spring, abs=1e-7)
    # heat takes those that have just pinned too, which cold would bear what others drop
    assert told.critical_spring_error < 2e-7 and line.critical_spring[0] < line.critical_spring[1]


def test_no_contacts_are_lost_between_births_of_the_leg_before():
    """The few that hold long after a turn were born within a short time of it: in the middle of a leg, where neither
    end of it is near."""
    contacts, path = Contacts(GRAINS), through([0.0, 3.0, -0.3], 31)
    solved = master.solve(contacts, path[[30, -1]], 5e-6)
    assert solved.success
    plain = by_cohorts(contacts, path).values[-1] * contacts.mean_threshold
    assert abs(solved.force[-1] - plain) < 1e-5
