"""Contacts that age on any path in time: turns, holds and velocity steps."""

import numpy as np
import pytest

import eq_model
import master
import origins
from origins import Ageing, Contacts, Delay, InputError, Thermal

FRESH, FINAL = origins.gaussian(0.5, 0.1), origins.gaussian(0.8, 0.08)
_REACH = 7.0


def simulate(contacts, path, time, travel_step, time_step, count, seed, wait=0.0):  # type: ignore[no-untyped-def]
    """Contacts one by one along straight pieces: exact steps of their thresholds, crossings within a step by the
    Brownian bridge. Mean stretch and its standard error at the ends of the pieces."""
    generator = np.random.default_rng(seed)
    normal, rate, fresh = contacts.ageing.normal, contacts.ageing.rate, contacts.thresholds
    thermal = contacts.thermal
    x = np.full(count, contacts.start.mean())
    values = fresh.isf(fresh.sf(np.abs(x)) * (1.0 - generator.random(count)))
    away, back, clock, told = np.zeros(count, dtype=bool), np.zeros(count), 0.0, []
    for travel, duration in zip(np.diff(path, prepend=0.0), np.diff(time, prepend=0.0), strict=True):
        steps = int(np.ceil(max(abs(travel) / travel_step, duration / time_step)))
        dx, dt = travel / steps, duration / steps
        reach = _REACH * np.sqrt(2.0 * rate * dt) + abs(dx)
        for _ in range(steps):
            clock += dt
            after = normal.draw(values, dt, generator.standard_normal(count))
            above, below = values - np.abs(x), after - np.abs(x + dx)
            near = np.flatnonzero(below < reach)
            through = np.exp(-np.maximum(above[near], 0.0) * np.maximum(below[near], 0.0) / (rate * dt))
            broken = np.zeros(count, dtype=bool)
            broken[near] = (below[near] <= 0.0) | (generator.random(near.size) < through)
            if thermal is not None:
                stretch = np.abs(x + 0.5 * dx)
                h = thermal.rate(stretch, np.maximum(stretch, 0.5 * (values + after)))
                broken |= generator.random(count) < -np.expm1(-dt * h)
            broken &= ~away
            x, values = x + dx, after
            away[broken], back[broken] = True, clock - dt * generator.random(int(broken.sum())) + wait
            born = np.flatnonzero(away & (back <= clock))
            away[born] = False
            x[born] = dx / dt * (clock - back[born])
            values[born] = fresh.isf(1.0 - generator.random(born.size))
        force = np.where(away, 0.0, x)
        told.append((force.mean(), max(force.std() / np.sqrt(count), 1.0 / count)))
    return np.array(told).T


TURNS = np.array([0.2, 0.45, 0.6, 0.75, 0.5, 0.1, -0.3, -0.5, -0.7, -0.3, 0.2, 0.5])
TIMES = np.cumsum(np.abs(np.diff(TURNS, prepend=0.0)))
HOLD = np.array([0.3, 0.5, 0.8, 1.1, 1.1, 1.1, 1.15, 1.25, 1.35, 1.45, 1.6, 1.8])
WHEN = np.array([0.3, 0.5, 0.8, 1.1, 2.0, 4.1, 4.2, 4.3, 4.4, 4.5, 4.6, 4.7])
CASES = {
    "turns": (Contacts(FRESH, 0.1, ageing=Ageing(FINAL, 0.01)), TURNS, TIMES),
    "hold, steps of speed": (Contacts(FRESH, ageing=Ageing(FINAL, 5e-3)), HOLD, WHEN),
    "turns, delay": (Contacts(FRESH, 0.1, ageing=Ageing(FINAL, 0.01), delay=Delay(0.13)), TURNS[:6], TIMES[:6]),
    "warm, hold": (Contacts(FRESH, -0.1, Thermal("soft", 0.05, 0.3), Ageing(FINAL, 5e-3)), HOLD[:8], WHEN[:8]),
}


@pytest.mark.parametrize("name", CASES)
def test_paths_in_time_against_contacts_one_by_one(name: str) -> None:
    contacts, path, time = CASES[name]
    solved = master.solve(contacts, path, 2e-3, time=time)
    assert solved.success, solved.message
    wait = 0.0 if contacts.delay is None else contacts.delay.time
    force, error = simulate(contacts, path, time, 4e-3, 4e-3, 5_000, 5, wait)
    z = (force - solved.force) / (error + solved.force_error * contacts.mean_threshold)
    assert np.abs(z).max() < 5.0, z


def test_steady_motion_step_by_step_is_the_exact_one() -> None:
    path = np.linspace(0.1, 1.2, 12)
    contacts = Contacts(FRESH, 0.1, ageing=Ageing(FINAL, 1e-3))
    exact = master.solve(contacts, path, 1e-9).force
    stepped = master.solve(contacts, path, 1e-5, time=path.copy())
    error = np.abs(stepped.force - exact).max() / contacts.mean_threshold
    assert stepped.success and error < stepped.force_error < 1e-5


def test_soft_slider_whose_contacts_barely_age_slips_as_if_they_did_not() -> None:
    drive = np.linspace(0.1, 1.5, 15)
    plain = master.solve(Contacts(FRESH), drive, 1e-6, spring=0.6)
    wide = origins.gaussian(0.8, 0.1)
    barely = master.solve(Contacts(FRESH, ageing=Ageing(wide, 1e-6)), drive, 3e-3, spring=0.6)
    assert barely.success and plain.slips.drive.size == barely.slips.drive.size == 1
    off = max(np.abs(plain.force - barely.force).max(), 0.6 * float(np.abs(plain.slips.drive - barely.slips.drive)[0]))
    assert off < barely.force_error


def test_refusals() -> None:
    path, time = [0.5, 0.5], [0.5, 1.0]
    cases = [
        (Contacts(origins.identical(0.5), ageing=Ageing(FINAL, 1e-3)), "thresholds: hold the single value 0.5"),
    ]
    for contacts, begins in cases:
        with pytest.raises(InputError) as refusal:
            master.solve(contacts, path, time=time)
        assert str(refusal.value).startswith(begins) and "\n" not in str(refusal.value), str(refusal.value)


def test_stretched_contacts_age_on_a_slider_that_rests_as_discrete_ones_do():
    contacts = Contacts(origins.gaussian(1.0, 0.2), 0.6, ageing=Ageing(origins.gaussian(0.8, 0.1), 1e-2))
    found = master.solve(contacts, [0.0, 0.0], 1e-4, time=[1.0, 10.0])
    seen = eq_model.simulate(contacts, [0.0, 0.0], time=[1.0, 10.0], n_contacts=20_000)
    assert found.success and found.force[-1] < 0.3
    off = np.abs(found.force - seen.force)
    assert (off < found.force_error + 5.0 * seen.force_standard_error).all()


def test_force_does_not_know_how_far_the_path_goes_on() -> None:
    """Thresholds that spread faster than the slider goes, right after it turned: read in the first of few steps."""
    contacts = Contacts(origins.gaussian(1.0, 0.2), ageing=Ageing(origins.gaussian(1.5, 0.2), 0.078))
    back = -1.4 + 0.01 * np.linspace(0.1, 1.0, 5)
    there = np.concatenate([[0.0, -1.14, -1.4], back])
    short, long = (master.solve(contacts, [*there, *more], 1e-4, velocity=0.116) for more in ([], [0.6]))
    assert short.success and long.success
    assert np.abs(short.force[2:8] - long.force[2:8]).max() < short.force_error + long.force_error
