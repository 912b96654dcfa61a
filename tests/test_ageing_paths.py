"""Contacts that age on any path in time: turns, holds and velocity steps."""

import numpy as np
import pytest

import master
import origins
from master._old.first_passage import first_passage
from master._old.threshold_cells import Cells
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


def test_orders_of_a_strand_against_its_first_passage() -> None:
    """Four in the cells; three in steps of a slider that runs ahead of its drive, where the density's edge thins."""

    def held(rate: float, level: int, steps: int, width: float) -> float:
        """At 0.5, the slider's own dX/dt growing without end from some widths before."""
        cells, x = Cells(Contacts(FRESH, ageing=Ageing(FINAL, rate)), level), np.linspace(0.0, 0.5, steps + 1)
        # time that passes per travel, and time
        slowness, clock = np.tanh((0.5 - x) / width), -width * np.log(np.cosh((0.5 - x) / width))
        weights = cells.fresh(np.zeros(1))
        for k in range(steps):
            bend = (slowness[k + 1] - slowness[k]) / (slowness[k + 1] + slowness[k])
            weights = cells.move(weights, x[k : k + 1], x[k + 1 : k + 2], clock[k + 1] - clock[k], bend)
        return float(weights.sum())

    def straight(level: int) -> float:
        cells, h = Cells(Contacts(FRESH, ageing=Ageing(FINAL, 1e-5)), level), 0.5 / 160
        weights = cells.fresh(np.zeros(1))
        for k in range(160):
            weights = cells.move(weights, np.array([k * h]), np.array([(k + 1) * h]), h)
        return float(weights.sum())

    left = float(first_passage(FRESH, Ageing(FINAL, 1e-5)).law.sf(0.5))
    levels, steps = np.array([0, 2, 4]), np.array([80, 160, 320])
    in_cells = np.polyfit(np.log(2.0) * 0.5 * levels, np.log([abs(straight(int(n)) - left) for n in levels]), 1)[0]
    best = held(5e-4, 2, 1280, 0.1)
    in_steps = np.polyfit(np.log(steps), np.log([abs(held(5e-4, 2, int(n), 0.1) - best) for n in steps]), 1)[0]
    assert abs(in_cells + 4.0) < 0.2 and abs(in_steps + 3.0) < 0.2, (in_cells, in_steps)


def test_compiled_step_is_that_of_a_banded_system() -> None:
    cells = Cells(Contacts(FRESH, ageing=Ageing(FINAL, 1e-3), thermal=Thermal("soft", 0.05, 0.3)), 0)
    begin, end, duration = np.array([0.0, 0.2]), np.array([0.02, 0.18]), np.array([0.02, 0.03])
    weights = cells.fresh(np.abs(begin))
    found = cells.move(weights, begin, end, duration, -0.4)
    flow, early, spread = cells.stages(begin, end, duration, -0.4)
    m = weights.shape[1]
    for i in range(2):
        changes = []
        for stage in range(2):
            through = np.zeros((m + 1, m))  # flow through faces, by the weights of the cells
            for face in range(m):
                for k in range(4):
                    if 0 <= face - 2 + k < m:
                        rate = flow[stage, i, face] * cells.value[face, k] + spread[stage, i] * cells.slope[face, k]
                        through[face, face - 2 + k] = rate
            changes.append(np.diff(through, axis=0) - np.diag(early[stage, i]))
        first, last = changes
        one = np.eye(m)
        system = np.block([[one - 5 / 12 * first, last / 12], [-0.75 * first, one - 0.25 * last]])
        exact = np.linalg.solve(system, np.tile(weights[i], 2))[m:]
        np.testing.assert_allclose(found[i], exact, atol=1e-13)


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
