"""Sliders that heat below their thresholds changes by less than a bound, and contacts without it tell of: ensembles in
heat do the same, and keep to the bound."""

import time
from functools import lru_cache
from typing import Any

import numpy as np
import pytest
from conftest import slow
from scipy import stats

import eq_model
import master
from master.soft.in_time.idle_heat import largest_effect
from origins import Contacts, Delay, Thermal, gaussian, gaussian_start, identical, mixture
from origins.drive import RISE
from toolkit.verdict.sliders.follow import follow
from toolkit.verdict.sliders.machine import Machine, RigidSlider, rigid_slider
from toolkit.verdict.sliders.records import Behaviour
from toolkit.verdict.sliders.weak_heat import EARLY, by_contacts_without_heat

SOFT = Machine(spring=0.02, mass=None, damping=0.0, velocity=1.0)
WEAK = Contacts(gaussian(1.0, 0.2), thermal=Thermal("soft", 1e-4, 1e6))
SKEW = Contacts(stats.weibull_min(4.0, scale=1.1), thermal=Thermal("soft", 1.5e-4, 1e6))


@lru_cache
def known(contacts: Contacts, velocity: float) -> RigidSlider:
    """What rigid sliders in heat tell of these contacts, found once."""
    steady = master.steady_state(contacts, velocity=velocity)
    found = master.propensity(contacts, velocity=velocity, tolerance=1e-3)
    return rigid_slider(contacts, steady, found, None)


def told(
    contacts: Contacts, rule: str, machine: Machine = SOFT, rigid: RigidSlider | None = None
) -> Behaviour | None:
    """What contacts without heat tell of the slider."""
    return by_contacts_without_heat(
        machine,
        contacts,
        rule,
        rigid or known(contacts, machine.velocity),
        time.monotonic() + 1e4,
        lambda bare, told: follow(machine, bare, rule, told, 1e4),
    )


@pytest.mark.parametrize(
    ("contacts", "rule"), [(WEAK, "reset"), slow(WEAK, "reform-after"), (SKEW, "reform-after")]
)
def test_finitely_many_contacts_in_heat_slip_as_those_without_it_tell(
    contacts: Contacts, rule: str
) -> None:
    """As often, from the same force within the bound and errors: 1,000 contacts in heat beside 1,000 without."""
    found = told(contacts, rule)
    assert found is not None and (found.kind, found.after, found.success) == (
        "stick-slip",
        0.0,
        True,
    )
    effect = found.heat_left_out or 0.0
    assert 0.002 < effect < 0.05 and effect < found.error < 1.1 * effect
    path = np.linspace(0.0, 3.3 * (found.period or 0.0), 300)
    asked: dict[str, Any] = {"n_contacts": 1000, "n_replicas": 8, "seed": 5}
    asked |= SOFT.keywords(rule)
    hot, cold = (
        eq_model.simulate(each, path, **asked).slips
        for each in (contacts, contacts.replace(thermal=None))
    )
    assert hot.drive.size == cold.drive.size == 3 * 8
    off = np.hypot(*(one.force_before.std() / np.sqrt(one.drive.size) for one in (hot, cold)))
    assert off < 0.3 * effect
    assert abs(hot.force_before.mean() - cold.force_before.mean()) < effect + 4.0 * off
    # a thousand contacts slip a little before infinitely many
    assert abs(hot.force_before.mean() - found.before) < effect + 4.0 * off + 1000 ** (-2 / 3)


def test_heat_changes_the_force_by_less_than_the_bound_however_the_slider_moves() -> None:
    """One that rests long and goes on fast, again and again, as one that sticks: heat is seen, and keeps to the bound;
    the sliding force falls by less than that, too."""
    places, times = [0.0], [0.0]
    while places[-1] < 24.0:
        places += [places[-1] + 0.4, places[-1] + 0.4, places[-1] + 1.0]
        times += [times[-1] + 40.0, times[-1] + 140.0, times[-1] + 140.0006]
    warmer = WEAK.replace(thermal=Thermal("soft", 6e-4, 1e6))
    effect = largest_effect(warmer, 600.0, EARLY)  # of some lives
    hot = eq_model.simulate(warmer, places, time=times, n_contacts=100_000, seed=2)
    cold = master.solve(WEAK.replace(thermal=None), np.unique(places), 1e-6).force
    change = hot.force - cold[np.searchsorted(np.unique(places), places)]
    off = hot.force_standard_error.max()
    assert 5.0 * off < np.abs(change).max() < effect < 0.1
    late = hot.force[len(places) // 2 :]
    assert (np.maximum.accumulate(late) - late).max() < effect


def test_it_slides_smoothly_where_no_fall_could_count_as_a_slip() -> None:
    """At F_k without heat, with the bound as its error; in stronger heat the fall might count as a slip."""
    found = told(WEAK, "instant")
    assert found is not None and (found.kind, found.success) == ("smooth", True)
    assert (found.heat_left_out or 1.0) < RISE and found.error >= (found.heat_left_out or 1.0)
    kinetic = master.steady_state(WEAK.replace(thermal=None), velocity=1.0).force
    assert found.before == pytest.approx(kinetic, abs=1e-3)
    warmer = WEAK.replace(thermal=Thermal("soft", 2e-4, 1e6))
    assert told(warmer, "instant") is None and told(warmer, "reset") is not None


def test_contacts_without_heat_tell_of_no_other_slider() -> None:
    """Where heat may change more than is known; where new contacts' force falls by too little; on a stiff spring; with
    a mass, a delay, a start that is not relaxed, or exact thresholds."""
    assert told(WEAK.replace(thermal=Thermal("soft", 3e-3, 1e6)), "reset") is None
    hardly = Contacts(stats.weibull_min(1.5), thermal=Thermal("soft", 1e-4, 1e6))
    assert told(hardly, "reset") is None
    assert told(WEAK, "reset", Machine(0.1, None, 0.0, 1.0)) is None
    assert told(WEAK, "reset", Machine(0.02, 1.0, 0.1, 1.0)) is None
    for other in (
        {"delay": Delay(1.0)},
        {"start": gaussian_start(0.0, 0.1)},
        {"thresholds": identical(1.0)},
    ):
        assert told(WEAK.replace(**other), "reset", rigid=known(WEAK, 1.0)) is None


@pytest.mark.slow  # quick: the same machine by master.solve, in test_heat_on_springs.py
def test_contacts_without_heat_tell_of_no_slip_that_heat_may_take_away() -> None:
    """The weak half of the contacts slips without heat, and not with it; in weaker heat it does."""
    law = mixture([gaussian(0.222, 0.0435), gaussian(1.763, 0.137)], [0.503, 0.497])
    steep = mixture([gaussian(0.222, 0.03), gaussian(1.763, 0.137)], [0.503, 0.497])
    taken_away = Contacts(law, thermal=Thermal("soft", 4.3e-5, 1e14))
    stays = Contacts(steep, thermal=Thermal("soft", 1e-6, 1e14))
    machine = Machine(0.005, None, 0.0, 1.0)
    assert told(taken_away, "reset", machine) is None
    assert told(stays, "reset", machine) is not None
