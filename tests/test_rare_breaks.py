"""What the ensemble claims of its force, against the scatter between seeds: with many breaks, few and none."""

from typing import Any

import numpy as np
import pytest
from scipy import stats
from scipy.special import ndtr

import eq_model
import origins

WIDE, SHARP = origins.gaussian(1.0, 0.2), origins.gaussian(1.0, 1e-3)
HOT = origins.Thermal("soft", 0.3, 100.0)
TURNING = np.array([0.3, 0.6, 0.9, 0.5, 0.1, -0.4, -0.8])


@pytest.mark.parametrize("n", [100, 3000])
@pytest.mark.parametrize("back", [[], [1.0]], ids=["forward", "turning"])
def test_the_ends_of_sharp_drops_are_in_the_error(back: list[float], n: int) -> None:
    """Where all contacts but one in a thousand have broken, or none but one, most ensembles see no such contact."""
    path = np.concatenate([1.0 + np.linspace(-5e-3, 5e-3, 21), 2.0 + np.linspace(-8e-3, 8e-3, 21), back])
    forth = path[:42]
    width = 1e-3 * np.sqrt(np.arange(1, 3))[:, None]
    z = (forth - np.arange(1, 3)[:, None]) / width
    exact = forth - (ndtr(z) - width * np.exp(-0.5 * z * z) / np.sqrt(2.0 * np.pi) * 1e-3**2 / width**2).sum(axis=0)
    contacts, off = origins.Contacts(SHARP), []
    for seed in range(50):
        run = eq_model.simulate(contacts, path, n_contacts=n, seed=seed)
        off.append((run.force[:42] - exact) / np.hypot(run.force_standard_error[:42], 1e-9))
    # a break that is seen in one of ten ensembles is three times its claim away in that one
    assert np.abs(off).max() < 9.0 and (np.square(off).mean(axis=0) < 3.0).all()
    # where there are many breaks it is not too large
    if n == 3000:
        assert 0.7 < np.square(off)[:, [9, 10, 11, 30, 31, 32]].mean() < 1.4


@pytest.mark.parametrize(
    ("contacts", "path"),
    [
        (origins.Contacts(WIDE, stiffness="linked"), 1e-8),
        (origins.Contacts(stats.lomax(3.0), stiffness="linked"), [1e-7, 1e-6, -3e-7]),
        (origins.Contacts(SHARP, origins.gaussian_start(0.2, 3e-7)), 1e-6),
    ],
    ids=["linked", "heavy tail", "narrow start"],
)
def test_what_scatters_little_is_in_the_error(contacts: Any, path: Any) -> None:
    runs = [eq_model.simulate(contacts, path, n_contacts=200, seed=seed) for seed in range(80)]
    force = np.array([run.force for run in runs])
    z = (force - force.mean(axis=0)) / [run.force_standard_error for run in runs]
    assert runs[0].breaks == 0 and (np.square(z).mean(axis=0) > 0.5).all() and np.square(z).mean() < 1.8
