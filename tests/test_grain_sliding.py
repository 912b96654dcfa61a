"""Grain contacts that pin, strengthen and break in steady sliding, against contacts one by one."""

import numpy as np
import pytest

import master
import origins
from origins import Contacts, Delay


@pytest.mark.parametrize("velocity", [0.3, 1.0])
def test_steady_sliding_against_contacts_one_by_one(velocity: float) -> None:
    growth = origins.GrainGrowth(alpha=1.0, B=1.0)
    grains, first = origins.GrainContact(growth), growth.first_pinning_time
    law = grains.breaking(velocity)
    steady = master.steady_state(
        Contacts(law, delay=Delay(first / law.held_fraction)), velocity=velocity
    )
    # each life is a wait and a quantile for good; thresholds by the age, met on a fine grid of stretches
    x = np.linspace(0.0, law.support()[1], 2001)
    ranks = np.random.default_rng(3).random(4_000)
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


def test_transients_where_nearly_all_hold() -> None:
    """Slow sliding: the force of contacts pinned at X = 0 ends in that of steady sliding."""
    growth = origins.GrainGrowth(alpha=1.0, B=1.0)
    law = origins.GrainContact(growth).breaking(0.05)
    contacts = Contacts(law, delay=Delay(growth.first_pinning_time / law.held_fraction))
    steady = master.steady_state(contacts, velocity=0.05)
    far = master.solve(contacts, [300.0], 1e-7, velocity=0.05)
    assert far.success and far.force[0] == pytest.approx(steady.force, abs=1e-6)
    assert master.propensity(contacts, 1e-6, velocity=0.05).static_to_kinetic > 1.0


@pytest.mark.parametrize("velocity", [1e-300, 1e-60, 1e60, 1e300])
def test_speeds_beyond_floating_point_are_refused(velocity: float) -> None:
    contacts = Contacts(origins.growing_grains(1.0, 1.0, age=4.0))
    with pytest.raises(origins.InputError, match=r"^velocity = .*: is [\d.e+-]+ of that at which thresholds grow"):
        master.kinetic_curve(contacts, velocity)
