"""Contacts that heat breaks on a slider with mass: the ensemble against closed forms, plain Python and master."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from conftest import slow
from plain_heavy_in_heat import HeavyInHeat, stepped
from solving import first_slip_of_contacts, first_slip_of_master

import eq_model
import master
import origins
from origins import Contacts, Delay, Thermal, gaussian, gaussian_start, identical

PC = gaussian(1.0, 0.2)
EYRING = Thermal("eyring", width=0.05, attempt_frequency=2.0)
SOFT, WARMER = Thermal("soft", 0.04, 2.0), Thermal("soft", 0.042, 2.0)
STEPS = 2e-5  # what small steps of time add to the errors of plain Python
SLIPS = ("drive", "before", "after", "force_before", "force_after", "breaks", "duration")
CURVES = ("positions", "forces", "velocities", "contact_forces", "holding")


def balanced(found: Any) -> bool:
    """Whether the work of the drive is what is stored, damped and released by breaks."""
    return bool(np.abs(found.energy.imbalance).max() < 1e-10)


# In case 25 two events are as near as rounding: with another last digit of the mass cold contacts part by 1e-4, too.
MANY = [case for case in range(4, 37) if case != 25]


@pytest.mark.parametrize("cases", [range(2, 4), slow(MANY)], ids=["two", "many"])
def test_as_the_temperature_falls_every_break_is_that_of_cold_contacts(
    cases: Sequence[int],
) -> None:
    """And every slip: at T = 1e-11 heat breaks contacts just before their thresholds alone, where their windows end."""
    breaks = 0
    for case in cases:
        rng = np.random.default_rng(case)
        cold = Contacts(
            gaussian(1.0, rng.uniform(0.05, 0.4)),
            start=gaussian_start(0.1, 0.2) if case % 4 == 0 else None,
            delay=Delay(10.0 ** rng.uniform(-1.0, 0.5)) if case % 2 else None,
            stiffness="linked" if case % 3 == 0 else "independent",
        )
        spring, mass = 10.0 ** rng.uniform(-1.5, 0.5), 10.0 ** rng.uniform(-4.0, 0.0)
        machine = {"spring": spring, "mass": mass, "velocity": 10.0 ** rng.uniform(-1.0, 0.5)}
        machine["damping"] = 10.0 ** rng.uniform(-1.0, 1.0) * (mass * spring) ** 0.5
        path = np.linspace(0.3, 8.0, 50) / min(spring, 1.0)
        asked: dict[str, Any] = machine | {"n_contacts": 200, "n_replicas": 2, "seed": case}
        frozen = cold.replace(thermal=Thermal("soft", 1e-11, 10.0))
        one, other = (eq_model.simulate(each, path, **asked) for each in (cold, frozen))
        assert one.breaks == other.breaks
        assert balanced(other)
        for name in CURVES:
            assert np.abs(getattr(one, name) - getattr(other, name)).max() < 1e-6
        slips = [np.stack([getattr(each.slips, name) for name in SLIPS]) for each in (one, other)]
        assert np.abs(slips[1] - slips[0]).max(initial=0.0) < 1e-6
        breaks += one.breaks
    assert breaks > 1000 * len(cases)


@pytest.mark.parametrize("damping", [0.0, 10.0])
@pytest.mark.parametrize("heat", [SOFT, slow(EYRING)])
def test_contacts_survive_as_the_integral_of_their_rate_says(heat: Thermal, damping: float) -> None:
    """On a spring a thousand times as stiff as they are, at one speed and then in a rest of 1e11 oscillations; the
    distance is Kolmogorov's, of all contacts, and tells contacts warmer by a twentieth apart."""
    n, speed, spring = 40_000, 0.1, 1e3
    contacts = Contacts(identical(1.0), thermal=heat, delay=Delay(1e12))
    far, rest = 0.6, np.geomspace(1.0, 1e9, 60)
    path = np.append(np.linspace(0.01, far, 60), np.full(60, far))
    time = np.append(path[:60] / speed, far / speed + rest)
    machine = {"spring": spring, "mass": 0.01, "damping": damping}
    found = eq_model.simulate(contacts, path, time=time, n_contacts=n, n_replicas=1, **machine)

    def distance(thermal: Thermal) -> float:
        x = found.position
        passed = np.exp(thermal.rates.log_passed(0.0, x, 1.0, 1.0)) / speed
        passed[60:] = passed[59] + np.exp(thermal.rates.log_rate(x[60:], 1.0, 1.0)) * rest
        return float(np.abs(found.holding - np.exp(-passed)).max() * n**0.5)

    warmer = WARMER if heat is SOFT else Thermal("eyring", width=0.0525, attempt_frequency=2.0)
    assert found.holding[59] > 0.5
    assert found.holding[-1] < 0.5
    assert distance(heat) < 1.95  # at a chance of 1e-3
    assert distance(warmer) > 4.0
    assert balanced(found)


@pytest.mark.slow  # quick: how long contacts survive in heat, above
@pytest.mark.parametrize(("n", "replicas"), [(50, 300), (1000, 400)])
def test_without_mass_it_is_the_slider_of_the_rule_instant(n: int, replicas: int) -> None:
    """X, the force and their scatter between machines, in a first slip and after, with any number of threads; one of
    warmer contacts differs."""
    path, light = np.linspace(0.5, 6.0, 12), {"mass": 1e-9, "damping": 1e-4}
    asked: dict[str, Any] = {"velocity": 0.2, "spring": 0.4, "n_contacts": n}
    contacts = Contacts(PC, thermal=SOFT)
    heavy = eq_model.simulate(contacts, path, **asked, **light, n_replicas=replicas, seed=1)
    shared = eq_model.simulate(contacts, path, **asked, **light, n_replicas=40, seed=1, threads=2)
    assert balanced(heavy)
    assert (shared.forces == heavy.forces[:40]).all()
    told = moments(heavy)
    for thermal, most, least in ((SOFT, 4.0, 0.0), (Thermal("soft", 0.06, 2.0), np.inf, 8.0)):
        other = eq_model.simulate(
            contacts.replace(thermal=thermal), path, **asked, slip="instant", n_replicas=replicas
        )
        assert least < furthest(told, moments(other)) < most


def moments(found: Any, names: tuple[str, ...] = ("positions", "forces")) -> np.ndarray:
    """Means and variances of these curves over the replicas, and the standard errors, shape (2, 2 names, points)."""
    return moments_of(np.stack([getattr(found, name) for name in names]))


def moments_of(curves: np.ndarray) -> np.ndarray:
    """As `moments`, of curves of shape (names, replicas, points)."""
    both = np.concatenate([curves, (curves - curves.mean(1, keepdims=True)) ** 2])
    return np.stack([both.mean(1), both.std(1, ddof=1) / both.shape[1] ** 0.5])


def furthest(one: np.ndarray, other: np.ndarray, more: float = 0.0) -> float:
    """The largest difference of moments, in standard errors and this one."""
    return float((np.abs(one[0] - other[0]) / (np.hypot(one[1], other[1]) + more)).max())


def machine_in_heat(number: int, warmer: float) -> tuple[Contacts, HeavyInHeat]:
    """A drawn machine, whose drive stops and changes its speed, and its contacts at a drawn temperature."""
    rng = np.random.default_rng(number)
    law, start = gaussian(1.0, rng.uniform(0.1, 0.4)), gaussian_start(0.1, 0.2)
    heat = rng.uniform(0.5, 2.0) * warmer
    thermal = [
        Thermal("soft", 0.05 * heat, 2.0),
        Thermal("eyring", width=0.06 * heat, attempt_frequency=2.0),
        Thermal("stiff", 0.05 * heat, 2.0),
    ][number % 3]
    contacts = Contacts(
        origins.strengthening(law, 0.1, 0.1, age=1.0) if number % 6 > 3 else law,
        start=start if number % 4 == 2 else None,
        thermal=thermal,
        delay=Delay(10.0 ** rng.uniform(-1.0, 0.3)) if number % 4 == 1 else None,
        stiffness="linked" if number % 6 == 2 else "independent",
    )
    mass, spring = 10.0 ** rng.uniform(-2.0, -0.3), 10.0 ** rng.uniform(-1.0, 0.3)
    damping = 10.0 ** rng.uniform(-1.0, 0.5) * (mass * (spring + 1.0)) ** 0.5
    time = np.cumsum([1.0, 1.0, 1.0, 0.5, 1.5, 1.0]) / 10.0 ** rng.uniform(-0.7, 0.3)
    return contacts, HeavyInHeat(
        spring, mass, damping, np.array([1.0, 2.0, 2.0, 3.5, 4.0, 5.0]), time
    )


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, 36, 6))
def test_it_is_the_slider_of_single_contacts_in_small_steps(first: int) -> None:
    """X, the forces, the speed, the share that holds and the energy that breaks release, their means and scatter, of 36
    drawn machines; one of contacts warmer by a fifth is told apart in each six."""
    names = ("positions", "forces", "velocities", "contact_forces")
    power = 0.0
    for number in range(first, first + 6):
        contacts, of = machine_in_heat(number, 1.0)
        own = (of.mass / (1.0 + of.spring)) ** 0.5
        steps = 12 * int(np.ceil(of.time[-1] / 12.0 / min(2e-3, 0.03 * own)))
        plain = stepped(contacts, of, 20, 600, steps, seed=number)
        machine = {"spring": of.spring, "mass": of.mass, "damping": of.damping, "time": of.time}
        asked: dict[str, Any] = {"n_contacts": 20, "n_replicas": 2000, "seed": number}
        found, other = (
            eq_model.simulate(each, of.path, **machine, **asked)
            for each in (contacts, machine_in_heat(number, 1.2)[0])
        )
        curves, warm = (
            np.stack([*(getattr(each, name) for name in names), each.energy.released])
            for each in (found, other)
        )
        alike = moments_of(plain[[0, 1, 3, 4, 5]])
        assert furthest(moments_of(curves), alike, STEPS) < 4.0
        share = plain[2].std(0, ddof=1) / plain.shape[1] ** 0.5
        error = np.hypot(share, found.holding_standard_error) + STEPS
        assert np.abs((plain[2].mean(0) - found.holding) / error).max() < 4.0
        assert balanced(found)
        power = max(power, furthest(moments_of(warm), alike, STEPS))
    assert power > 6.0


@pytest.mark.parametrize("velocity", [0.1, 0.2])
@pytest.mark.slow
def test_in_steady_sliding_the_force_is_that_of_the_master_equation(velocity: float) -> None:
    """To 3e-4, and the spring bears what damps besides."""
    contacts, damping = Contacts(PC, thermal=SOFT), 0.1
    spring = 1.5 * master.propensity(contacts, velocity=velocity).critical_spring
    exact = master.steady_state(contacts, velocity=velocity).force
    asked: dict[str, Any] = {"velocity": velocity, "spring": spring, "mass": 0.01, "seed": 3}
    found = eq_model.simulate(
        contacts,
        np.linspace(12.0, 15.0, 16),
        n_contacts=4000,
        n_replicas=32,
        damping=damping,
        **asked,
    )
    means = found.contact_forces.mean(axis=1)
    error = means.std(ddof=1) / np.sqrt(means.size)
    assert abs(means.mean() - exact) < 4.0 * error
    assert error < 3e-4
    assert found.forces.mean() == pytest.approx(exact + damping * velocity, abs=4.0 * error)
    other = master.steady_state(contacts, velocity=3.0 * velocity).force
    assert abs(means.mean() - other) > 10.0 * error


@pytest.mark.slow
@pytest.mark.parametrize("heat", ["eyring", "soft"])
def test_the_slip_is_that_of_the_master_equation(heat: str) -> None:
    """The first one, and the force at 27 places of the drive before and after, extrapolated from 4,000 and 32,000
    contacts; contacts warmer by a tenth are told apart."""
    path = np.linspace(0.2, 5.4, 27)
    machine = {"spring": 0.3, "mass": 0.01, "damping": 0.02, "velocity": 0.5}

    def warm(warmer: float) -> Contacts:
        thermal = Thermal("soft", 0.04 * warmer, 20.0)
        if heat == "eyring":
            thermal = Thermal("eyring", width=0.06 * warmer, attempt_frequency=20.0)
        return Contacts(PC, thermal=thermal)

    solved = first_slip_of_master(warm(1.0), path, 1e-3, **machine)
    assert first_slip_of_contacts(warm(1.0), path, **machine).apart(solved) < 4.0
    assert first_slip_of_contacts(warm(1.1), path, **machine).apart(solved) > 8.0


@pytest.mark.parametrize("mass", [None, 1e-24])
def test_kernels_are_compiled_at_the_speed_of_the_rates(mass: float | None) -> None:
    """By two contacts before the first replica: at a speed of 1 they would break by heat more often than any path may
    take, and a call with fast rates on a fast drive was refused."""
    heat = Thermal("soft", 0.1, 1e12)
    machine: dict[str, Any] = (
        {"slip": "reset"} if mass is None else {"mass": mass, "damping": 1e-12}
    )
    found = eq_model.simulate(
        Contacts(gaussian(1.0, 0.2), thermal=heat),
        np.array([0.5, 1.0]),
        spring=1.0,
        velocity=1e12,
        n_contacts=50,
        seed=1,
        **machine,
    )
    assert np.isfinite(found.force).all()
