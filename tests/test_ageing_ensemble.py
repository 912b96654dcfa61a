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


def slide(fresh, start, diffusion, end, step, count, seed, normal=None, drift=None):  # type: ignore[no-untyped-def]
    """Contacts one by one: thresholds diffuse in exact steps towards a normal law, in small ones down a drift else;
    crossings within a step by the Brownian bridge. Mean stretch and its standard error every 0.05."""
    generator = np.random.default_rng(seed)
    x = start.ppf(generator.random(count)) if isinstance(start, origins.start.Start) else np.full(count, start)
    values = fresh.isf(fresh.sf(np.abs(x)) * (1.0 - generator.random(count)))
    born, used = fresh.isf(1.0 - generator.random(_MOST_BIRTHS * count)), 0
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
        broken = near[(below[near] <= 0.0) | (generator.random(near.size) < through)]
        x += step
        values = after
        x[broken] = step * generator.random(broken.size)
        values[broken] = born[used : used + broken.size]
        used += broken.size
        if n % every == 0:
            # a single break is the least that can be seen
            told.append((x.mean(), max(x.std() / np.sqrt(count), n * step / count)))
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
    force, error = slide(FRESH, start, rate / velocity, 1.5, 1e-3, 12_000, 3, normal=per_length)
    z = (force - solution.force) / error
    assert np.abs(z).max() < 5.0, z


@pytest.mark.parametrize("final", [origins.gw_plastic(0.6), origins.lubricated(1.0)])
def test_other_targets_against_an_ensemble(final) -> None:  # type: ignore[no-untyped-def]
    """Not Gaussian: by the diffusion equation. On the way, and at its end."""
    contacts = Contacts(FRESH, ageing=Ageing(final, 0.1))
    steady = master.steady_state(contacts, velocity=2.0)
    assert 0.0 < steady.force_error < 1e-7
    path = 0.05 * np.arange(1, 25)
    solution = master.solve(contacts, path, 1e-6, velocity=2.0)
    assert solution.success
    force, error = slide(FRESH, 0.0, 0.05, 1.2, 1e-3, 8_000, 4, drift=drift_of(final))
    z = (force - solution.force) / error
    assert np.abs(z).max() < 5.0, z
    far = master.solve(contacts, np.linspace(28.0, 30.0, 41), 1e-6, velocity=2.0)
    assert np.abs(far.force - steady.force).max() < 1e-6
