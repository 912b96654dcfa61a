"""Growing grains under a slider that a spring pulls, against contacts pulled one by one."""

from typing import Any

import numpy as np
import pytest
from growing_contacts import pulled_by_a_spring

import master
from origins import Contacts, Delay, Thermal, growing_grains

GRAINS = growing_grains(1.0, 1.0, age=4.0)
CASES: list[tuple[Contacts, float, float, Any]] = [
    (Contacts(GRAINS, thermal=Thermal("soft", 0.1, 0.3)), 1.0, 0.5, "reset"),
    (Contacts(GRAINS, 0.1, delay=Delay(0.2)), 0.5, 0.5, "reform-after"),
]


@pytest.mark.parametrize(
    "contacts, velocity, spring, rule", CASES, ids=["reset, soft", "reform-after, delay"]
)
def test_slips_against_contacts_pulled_one_by_one(
    contacts: Contacts, velocity: float, spring: float, rule: Any
) -> None:
    balance, count, seeds = contacts.start.mean() / spring, 1_200, 5
    path = np.linspace(balance, 5.5, 31)[1:]
    solved = master.solve(contacts, path, 1e-2, velocity=velocity, spring=spring, slip=rule)
    assert solved.success, solved.message
    assert np.abs(solved.force - spring * (path - solved.position)).max() < 1e-12
    runs = [
        pulled_by_a_spring(contacts, path, velocity, spring, rule, 0.015, count, seed)
        for seed in range(seeds)
    ]
    slips = np.array([slips[:, 0] for slips, _ in runs])
    # on its way to a slip the force is an average, and the slip comes where few contacts decide
    early = path < slips[:, 0].min() - 0.3
    force = np.array([force for _, force in runs])[:, early]
    error = np.maximum(force.std(axis=0, ddof=1) / np.sqrt(seeds), 2e-3)
    own = solved.force_error * contacts.mean_threshold
    assert (
        early.sum() > 9
        and (np.abs(force.mean(axis=0) - solved.force[early]) / (error + own)).max() < 5.0
    )
    first = np.array([getattr(solved.slips, name)[0] for name in ("drive", "before", "after")])
    late = 3.5 * slips[:, :3].std(axis=0, ddof=1) + 2.0 * count ** (-2.0 / 3.0)
    assert (np.abs(slips[:, :3].mean(axis=0) - first) < late).all(), (
        slips[:, :3].mean(axis=0),
        first,
    )
    assert abs(slips[:, 3].mean() - solved.slips.force_before[0]) < 0.05


def test_resets_repeat_and_instant_slips_wait() -> None:
    """Those a reset leaves are younger than all were at first: the second drop is the one that comes back."""
    contacts, path = Contacts(GRAINS), np.linspace(0.0, 11.0, 45)
    reset = master.solve(contacts, path, 2e-2, velocity=1.0, spring=0.5)
    drops = reset.slips.force_before - reset.slips.force_after
    assert drops.size > 2 and drops[0] > 1.3 * drops[1] and np.ptp(drops[1:]) < 1e-9
    assert reset.regime.verdict == "stick-slip" and reset.period == pytest.approx(
        np.diff(reset.slips.drive)[-1]
    )
    instant, later = (
        master.solve(contacts, path[:20], 2e-2, velocity=1.0, spring=0.5, slip=rule)
        for rule in ("instant", "reform-after")
    )
    np.testing.assert_array_equal(instant.force, later.force)


def test_grains_that_grow_while_the_spring_loads_decide_nothing_before_they_break() -> None:
    """A path longer than the thresholds of X = 0 reach, and shorter than those to which they grow until the slip."""
    contacts = Contacts(growing_grains(1.0, 4.0, age=4.0))
    short, longer = (
        master.solve(contacts, [end], 2e-2, velocity=0.1, spring=0.3) for end in (6.0, 13.0)
    )
    assert not short.slips.drive.size and short.regime.verdict == "undecided", short.regime.reason
    assert longer.slips.drive.size == 2 and longer.regime.verdict == "stick-slip"
    stiff = master.solve(contacts, np.linspace(0.5, 5.0, 10), 2e-2, velocity=0.1, spring=20.0)
    assert not stiff.slips.drive.size and stiff.regime.verdict == "smooth", stiff.regime.reason
