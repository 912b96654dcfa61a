"""Contacts that age, one by one: ensembles of diffusing thresholds against the master equation's exact closure."""

import numpy as np
import pytest

import master
import origins
from origins import Ageing, Contacts

FRESH = origins.gaussian(0.5, 0.1)
_MOST_BIRTHS = 12
_REACH = 7.0  # standard deviations of a step, within which a level may have been met


def drift_of(final):  # type: ignore[no-untyped-def]
    """d ln P_cf/dx, from a table read in its middle."""
    x = (np.arange(60_000) + 0.5) * 5e-5
    table = np.gradient(final.logpdf(x), x)
    return lambda at: table[(at * 2e4).astype(int).clip(0, x.size - 1)]


def slide(  # type: ignore[no-untyped-def]
    fresh, start, diffusion, end, step, count, seed, normal=None, drift=None, birth=0.0, wait=0.0, rate=None
):
    """Contacts one by one: thresholds diffuse in exact steps towards a normal law, in small ones down a drift else;
    crossings within a step by the Brownian bridge. Mean stretch and its standard error every 0.05. What breaks is back
    at the stretch `birth` after a travel `wait`, some steps. A `rate` per length, of stretches and thresholds, breaks
    contacts too."""
    generator = np.random.default_rng(seed)
    x = start.ppf(generator.random(count)) if isinstance(start, origins.start.Start) else np.full(count, start)
    values = fresh.isf(fresh.sf(np.abs(x)) * (1.0 - generator.random(count)))
    born, used = fresh.isf(fresh.sf(abs(birth)) * (1.0 - generator.random(_MOST_BIRTHS * count))), 0
    back, away = np.zeros(count), np.zeros(count, dtype=bool)
    reach = _REACH * np.sqrt(2.0 * diffusion * step)
    every, told = round(0.05 / step), []
    for n in range(1, round(end / step) + 1):
        noise = generator.standard_normal(count)
        if normal is not None:
            after = normal.draw(values, step, noise)
        else:
            half = values + 0.5 * diffusion * step * drift(values)
            after = values + diffusion * step * drift(half) + np.sqrt(2.0 * diffusion * step) * noise
        below = after - np.abs(x + step)
        near = np.flatnonzero(below < reach)
        above = values[near] - np.abs(x[near])
        through = np.exp(-above * np.maximum(below[near], 0.0) / (diffusion * step))
        broken = np.zeros(count, dtype=bool)
        broken[near] = (below[near] <= 0.0) | (generator.random(near.size) < through)
        if rate is not None:
            stretch = np.abs(x + 0.5 * step)
            h = rate(stretch, np.maximum(stretch, 0.5 * (values + after)))
            broken |= generator.random(count) < -np.expm1(-step * h)
        broken = np.flatnonzero(broken & ~away)
        x += step
        values = after
        away[broken], back[broken] = True, n * step - step * generator.random(broken.size) + wait
        born_now = np.flatnonzero(away & (back <= n * step))
        away[born_now] = False
        x[born_now] = birth + n * step - back[born_now]
        values[born_now] = born[used : used + born_now.size]
        used += born_now.size
        if n % every == 0:
            # a single break is the least that can be seen
            force = np.where(away, 0.0, x)
            told.append((force.mean(), max(force.std() / np.sqrt(count), n * step / count)))
    return np.array(told).T


@pytest.mark.parametrize(
    ("start", "rate", "velocity"),
    [(0.0, 2e-3, 2.0), (origins.gaussian_start(0.1, 0.05), 0.05, 10.0), (-0.2, 0.02, 1.0)],
)
def test_force_on_the_way_against_an_ensemble(start, rate: float, velocity: float) -> None:  # type: ignore[no-untyped-def]
    final = origins.gaussian(0.8, 0.04)
    contacts = Contacts(FRESH, start, ageing=Ageing(final, rate))
    path = 0.05 * np.arange(1, 31)
    solution = master.solve(contacts, path, 1e-7, velocity=velocity)
    assert solution.success and (solution.holding == 1.0).all()
    per_length = Ageing(final, rate / velocity).normal
    force, error = slide(FRESH, start, rate / velocity, 1.5, 1e-3, 8_000, 3, normal=per_length)
    z = (force - solution.force) / error
    assert np.abs(z).max() < 5.0, z


@pytest.mark.parametrize(("birth", "wait"), [(0.0, 0.2), (0.15, 0.0), (-0.1, 0.1)])
def test_delay_and_births_at_other_stretches(birth: float, wait: float) -> None:
    final = origins.gaussian(0.8, 0.04)
    ageing, delay = Ageing(final, 0.02), origins.Delay(wait / 2.0)
    contacts = Contacts(FRESH, -0.1, ageing=ageing, reforming=birth, delay=delay)
    path = 0.05 * np.arange(1, 31)
    solution = master.solve(contacts, path, 1e-6, velocity=2.0)
    assert solution.success
    force, error = slide(
        FRESH, -0.1, 0.01, 1.5, 2e-3, 6_000, 5, Ageing(final, 0.01).normal, birth=birth, wait=wait
    )
    z = (force - solution.force) / error
    assert np.abs(z).max() < 5.0, z
    # wide final thresholds: all is soon forgotten
    ageing = Ageing(origins.gaussian(0.8, 0.25), 0.1)
    contacts = Contacts(FRESH, -0.1, ageing=ageing, reforming=birth, delay=delay)
    steady = master.steady_state(contacts, velocity=2.0)
    far = master.solve(contacts, np.linspace(40.0, 42.0, 21), 1e-6, velocity=2.0)
    assert steady.force_error < 1e-8 and np.abs(far.force - steady.force).max() < 1e-6
    assert far.holding[-1] == pytest.approx(steady.cycle_length / (steady.cycle_length + wait), abs=1e-6)


@pytest.mark.parametrize("law", ["soft", "stiff"])
def test_temperature_breaks_contacts_that_age(law: str) -> None:
    thermal, wait = origins.Thermal(law, 0.05, 2.0), 0.1  # type: ignore[arg-type]
    ageing, delay = Ageing(origins.gaussian(0.8, 0.1), 0.02), origins.Delay(wait / 2.0)
    contacts = Contacts(FRESH, 0.1, thermal, ageing, delay)
    path = 0.05 * np.arange(1, 31)
    solution = master.solve(contacts, path, 1e-6, velocity=2.0)
    assert solution.success
    normal = Ageing(ageing.final, 0.01).normal
    force, error = slide(
        FRESH, 0.1, 0.01, 1.5, 2e-3, 6_000, 6, normal, wait=wait, rate=lambda x, s: thermal.rate(x, s) / 2.0
    )
    z = (force - solution.force) / error
    assert np.abs(z).max() < 5.0, z
    # nothing ages: temperature alone, by its own road
    alone, barely = (
        master.solve(Contacts(FRESH, None, thermal, slow), path, 1e-6, velocity=2.0)
        for slow in (None, Ageing(ageing.final, 1e-9))
    )
    claims = alone.force_error + barely.force_error
    assert barely.success and np.abs(alone.force - barely.force).max() <= claims * contacts.mean_threshold


def test_births_at_many_stretches_are_births_at_each_of_them() -> None:
    """Lengths of lives and the force summed over them are averages over the births, here by Gauss and Hermite."""
    ageing = Ageing(origins.gaussian(0.8, 0.04), 0.02)
    many = master.steady_state(Contacts(FRESH, ageing=ageing, reforming=origins.gaussian_start(0.05, 0.01)))
    nodes, weights = np.polynomial.hermite_e.hermegauss(7)
    each = [master.steady_state(Contacts(FRESH, ageing=ageing, reforming=float(0.05 + 0.01 * x))) for x in nodes]
    lengths = weights / weights.sum() * np.array([steady.cycle_length for steady in each])
    assert many.cycle_length == pytest.approx(lengths.sum(), rel=1e-10)
    assert many.force == pytest.approx(lengths @ [steady.force for steady in each] / lengths.sum(), rel=1e-10)


@pytest.mark.parametrize("final", [origins.gw_plastic(0.6), origins.lubricated(1.0)])
def test_other_targets_against_an_ensemble(final) -> None:  # type: ignore[no-untyped-def]
    """Not Gaussian: by the diffusion equation. On the way, and at its end."""
    contacts = Contacts(FRESH, ageing=Ageing(final, 0.1))
    steady = master.steady_state(contacts, velocity=2.0)
    assert 0.0 < steady.force_error < 1e-6
    path = 0.05 * np.arange(1, 25)
    solution = master.solve(contacts, path, 1e-6, velocity=2.0)
    assert solution.success
    force, error = slide(FRESH, 0.0, 0.05, 1.2, 1e-3, 8_000, 4, drift=drift_of(final))
    z = (force - solution.force) / error
    assert np.abs(z).max() < 5.0, z
    far = master.solve(contacts, np.linspace(28.0, 30.0, 41), 1e-6, velocity=2.0)
    assert np.abs(far.force - steady.force).max() < 1e-6
