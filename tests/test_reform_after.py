"""Slips of "reform-after" that leave some contacts holding, beside a plain twin."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import slow
from plain_reform_after import groups, pulled

import master
import origins


@pytest.mark.parametrize(
    ("parts", "spring", "stiffness", "count"),
    [
        slow([(1.0, 1.0, 0.2)], 0.5, "independent", 8),
        slow([(1.0, 1.0, 0.05)], 1.4, "independent", 5),
        slow([(1.0, 1.0, 0.2)], 0.4, "linked", 7),
        # slips of the weaker group and of all contacts in turns: the former were once repeated as if there were no
        # others, as each is as the one before
        ([(0.6, 1.0, 0.15), (0.4, 2.4, 0.12)], 0.3, "independent", 5),
        slow([(0.6, 1.0, 0.15), (0.4, 2.4, 0.12)], 0.3, "independent", 10),
        slow([(0.5, 1.0, 0.14), (0.5, 2.2, 0.25)], 0.1, "independent", 10),
    ],
)
def test_slips_are_those_of_the_plain_twin(parts, spring, stiffness, count) -> None:
    """To the errors that are told."""
    exact = pulled(groups(parts, linked=stiffness == "linked"), spring, count)
    shares = [share for share, _, _ in parts]
    law = origins.mixture([origins.gaussian(mean, std) for _, mean, std in parts], shares)
    path = np.linspace(0.0, 0.5 * (exact[-1, 0] + exact[-2, 0]), 50)
    contacts = origins.Contacts(law, stiffness=stiffness)
    found = master.solve(contacts, path, 1e-6, spring=spring, slip="reform-after")
    assert found.success, found.message
    drive, before, after, _ = exact[:-1].T
    assert found.slips.drive.size == count - 1
    assert np.abs(found.slips.drive - drive).max() <= found.slips.drive_error <= 1e-6
    for told, twin in ((found.slips.force_before, before), (found.slips.force_after, after)):
        assert np.abs(told - twin).max() <= found.force_error <= 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12))
def test_no_error_of_sixty_slips_is_told_too_small(seed: int) -> None:
    """Random laws, springs and tolerances; the twin's own rounding is far below."""
    rng = np.random.default_rng(seed)
    std, linked = float(rng.uniform(0.08, 0.25)), bool(seed % 2)
    parts = [(1.0, 1.0, std)]
    if seed % 3 == 0:
        share = float(rng.uniform(0.3, 0.7))
        parts = [(share, 1.0, std), (1.0 - share, float(rng.uniform(1.4, 2.4)), 0.2)]
    law, x = groups(parts, linked), np.linspace(0.01, 3.0, 3000)
    steepest = -float(np.gradient(x * law.stiffness(x), x).min())
    spring = float(rng.uniform(0.05, 0.25)) * steepest
    exact = pulled(law, spring, 60)
    assert len(exact) > 10
    thresholds = origins.mixture(
        [origins.gaussian(mean, std) for _, mean, std in parts], [share for share, _, _ in parts]
    )
    stiffness = "linked" if linked else "independent"
    contacts = origins.Contacts(thresholds, stiffness=stiffness)
    path = np.linspace(0.0, 0.5 * (exact[-1, 0] + exact[-2, 0]), 50)
    tolerance = float(rng.choice([1e-4, 1e-6]))
    found = master.solve(contacts, path, tolerance, spring=spring, slip="reform-after")
    # a point of the path just before a slip may be known less well than the slips
    assert found.slips.drive.size == len(exact) - 1, found.message
    assert spring * found.slips.drive_error <= tolerance
    off = np.abs(found.slips.drive - exact[:-1, 0]).max()
    assert off <= found.slips.drive_error + 1e-11
    off = np.abs(found.slips.force_after - exact[:-1, 2]).max()
    assert off <= found.force_error * contacts.mean_threshold + 1e-12
