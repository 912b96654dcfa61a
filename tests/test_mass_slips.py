"""Slips of an ensemble with mass: the turning points of its own force, and none in smooth sliding of few contacts."""

from typing import Any

import numpy as np
import pytest
import scipy.stats
from conftest import slow

import eq_model
import origins
import toolkit
from toolkit.results.beside import slips_beside
from toolkit.results.verdicts import contradiction

GAUSSIAN = origins.gaussian(1.0, 0.4)
LAWS = {
    "gaussian": GAUSSIAN,
    "exponential": scipy.stats.expon(),
    "weibull": scipy.stats.weibull_min(4 / 3),
}
# numbers of contacts, their ways in loadings of the spring, and the law with which they are not slow
OF_FEW = [
    (50, 3000, "exponential"),
    (200, 2000, None),
    (2000, 200, None),
    (20_000, 20, "gaussian"),
]


def turns_of(path: np.ndarray, force: np.ndarray, level: float) -> np.ndarray:
    """X_T and force at each maximum, and the force at the minimum behind it, of swings down as large as the level."""
    found, down, high, low = list[list[float]](), False, 0, 0
    for k, now in enumerate(force.tolist()):
        if not down:
            high = k if now > force[high] else high
            down = force[high] - now >= level
            low = k
        elif now < force[low]:
            low = k
        elif now - force[low] >= level:
            found.append([path[high], force[high], force[low]])
            down, high = False, k
    return np.array(found)


def simulate(contacts: Any, end: float, points: int, **asked: Any) -> Any:
    given = {"n_replicas": 1, "seed": 1, "velocity": 1.0} | asked
    return eq_model.simulate(contacts, np.linspace(end / points, end, points), **given)


@pytest.mark.parametrize("delay, slips", [(0.2, 5), (2.0, 3)])
def test_slips_that_begin_as_a_creep_are_the_turns_of_the_force(delay: float, slips: int) -> None:
    """Far beyond critical damping each break of the creep is a fall of its own; by the force at points so close that
    it hardly changes in between. The end of a swing is known to a thousandth of it."""
    contacts = origins.Contacts(GAUSSIAN, delay=origins.Delay(delay))
    machine = {"spring": 0.5, "mass": 2e-11, "damping": 5e-6}
    found = simulate(contacts, 12.5, 100_000, n_contacts=20_000, **machine)
    own = np.stack([found.slips.drive, found.slips.force_before, found.slips.force_after]).T
    turns = turns_of(found.path, found.forces[0], 0.02)
    assert own.shape == turns.shape and len(own) == slips
    assert (np.abs(own - turns).max(axis=0) < [1e-3, 1e-4, 1e-3]).all()
    assert (found.slips.breaks > 0.6 * 20_000).all() and (found.slips.drop > 0.3).all()


def test_few_contacts_that_hold_at_a_time_slip_for_ever() -> None:
    """One of 200 contacts would hold in smooth sliding, but those that slip come back together a delay later: of the
    swings of the force, a few in a hundred may be so slow that the slider hardly gets faster than the drive."""
    contacts = origins.Contacts(GAUSSIAN, delay=origins.Delay(200.0))
    machine = {"spring": 0.5, "mass": 2e-3, "damping": 5e-3}
    found = simulate(contacts, 10_000.0, 50_000, n_contacts=200, **machine)
    turns = turns_of(found.path, found.forces[0], 0.06)
    # before, the first slips are so large that the slider rings
    seen = [np.abs(found.slips.drive - turn).min() < 1.0 for turn in turns[:, 0] if turn > 2500.0]
    assert len(seen) > 70 and np.mean(seen) > 0.95
    late = found.slips.drive[(found.slips.drop > 0.06) & (found.slips.drive > 2500.0)]
    assert np.diff(late).max() < 2.0 * 205.0


@pytest.mark.parametrize(
    "law, n, loadings",
    [slow(law, n, loadings, when=law != quick) for n, loadings, quick in OF_FEW for law in LAWS],
)
def test_smooth_sliding_of_few_contacts_has_no_slips(law: str, n: int, loadings: int) -> None:
    """Damped, with delays of 0 to 30 loadings; the first ones, in which contacts forget their start, do not count."""
    for spring, mass, damping, delay in [
        (3.0, 1e-4, 0.5, 0.0), (1.0, 0.1, 1.0, 0.0), (3.0, 1e-4, 0.5, 1.0), (0.1, 1e-3, 5.0, 30.0),
    ]:  # fmt: skip
        contacts = origins.Contacts(LAWS[law], delay=origins.Delay(delay) if delay else None)
        mean = contacts.mean_threshold
        machine = {"spring": spring, "mass": mass, "damping": damping}
        found = simulate(contacts, loadings * mean, 50, n_contacts=n, **machine)
        settled = 5.0 * mean + (1.0 + 5.0 * damping) / spring
        assert found.breaks > 0.01 * n * loadings
        assert not (found.slips.drive > settled).any()


def test_a_slider_that_sticks_rings_and_does_not_slip_again() -> None:
    """Hardly damped: after each slip the force swings by more than the level, and no contact breaks."""
    contacts = origins.Contacts(origins.gaussian(1.0, 0.1), delay=origins.Delay(2.0))
    found = simulate(contacts, 40.0, 20_000, n_contacts=2000, spring=0.3, mass=1e-4, damping=2e-4)
    turns = turns_of(found.path, found.forces[0], 0.1)
    assert 5 < found.slips.drive.size < 0.2 * len(turns)
    assert (found.slips.breaks > 0.5 * 2000).all() and np.diff(found.slips.drive).min() > 2.0


def test_slips_are_those_of_the_master_equation() -> None:
    """Behind each the slider sticks to the few contacts that do not wait, and the force falls as these break, by less
    than a twentieth: that is no slip, of which a fifth of the contacts that hold in steady sliding breaks."""
    drive = {"to": 4.0, "points": 41, "spring": 0.7, "mass": 1e-3, "damping": 1e-2, "velocity": 0.1}
    law = {"kind": "gaussian", "mean": 1.0, "std": 0.3}
    scene: dict[str, Any] = {"contacts": {"thresholds": law, "delay": {"time": 2.0}}}
    scene |= {"master": {"tolerance": 1e-2}, "eq": {"contacts": 20_000, "replicas": 4, "seed": 1}}
    result = toolkit.run(scene | {"drive": drive})
    each = slips_beside(result)
    assert len(each) == result.master.slips.drive.size == 2
    assert result.eq.slips.number.size == 4 * 2
    for slip in each:
        off = abs(slip["mean_drive"] - slip["drive"])
        assert off < 4.0 * slip["drive_error"] + result.master.force_error / drive["spring"], slip
    assert not contradiction(result)


@pytest.mark.parametrize(
    "spring, mass, damping, velocity, delay, end",
    [
        (0.4599, 9.595e-3, 0.3991, 0.01137, 0.0, 10.79),  # far beyond critical damping
        (0.05, 0.02, 0.02, 0.02, 30.0, 80.0),  # is held, and rings, where the last slip ended
        (0.02894, 2.897e-3, 0.02221, 2.922, 0.0, 60.0),  # slips on as the contacts break again
        (0.04701, 1.273e-3, 6.761e-4, 0.08507, 4.385, 75.73),  # is held far from where it swung
    ],
)
def test_slips_do_not_depend_on_the_points_of_the_path(spring, mass, damping, velocity, delay, end):
    """Of identical contacts, which load the slider in one move from slip to slip."""
    contacts = origins.Contacts(origins.identical(1.0))
    if delay:
        contacts = contacts.replace(delay=origins.Delay(delay))
    machine = {"spring": spring, "mass": mass, "damping": damping, "velocity": velocity}
    few, many = (
        eq_model.simulate(contacts, np.linspace(0.0, end, n)[1:], n_contacts=100, **machine).slips
        for n in (2, 1501)
    )
    assert many.drive.size > 1 and few.drive.shape == many.drive.shape
    same_slips(few, many)


@pytest.mark.parametrize("behind", [[], [6.9], [9.9]])
def test_a_drive_that_slows_down_or_rests_keeps_the_slips_of_the_way_there(behind: list) -> None:
    """The last slip of the first leg ends on the move to the leg's end, where the slower drive ends the next one."""
    contacts, times = origins.Contacts(origins.identical(1.0)), [40.0, 190.0]
    machine = {"spring": 0.5, "mass": 1e-4, "damping": 2e-2, "n_contacts": 200}
    machine |= {"n_replicas": 1, "seed": 1}
    path = [6.9, *behind]
    slips = eq_model.simulate(contacts, path, time=times[: len(path)], **machine).slips
    assert np.abs(slips.drive[:4] - [3.0023, 4.0023, 5.0023, 6.0023]).max() < 1e-3
    assert slips.drive.size == 4 + 3 * (behind == [9.9])


@slow
def test_a_slider_that_gathers_speed_after_its_contacts_broke_together_slips() -> None:
    """In heat they break in a narrow crowd while the force rises, which goes on to rise by 0.02 as none breaks."""
    contacts = origins.Contacts(origins.identical(1.0), thermal=origins.Thermal("soft", 0.01))
    machine = {"spring": 1.0, "mass": 0.1, "damping": 0.5, "n_contacts": 20_000}
    slips = eq_model.simulate(contacts, [6.6], n_replicas=1, seed=1, **machine).slips
    assert np.abs(slips.drive - [2.309, 3.202, 4.246, 5.227, 6.234]).max() < 2e-3
    assert np.abs(slips.force_before - [1.264, 1.149, 1.192, 1.173, 1.180]).max() < 2e-3


def test_a_fast_drive_on_a_very_soft_spring_is_followed_up_to_its_first_slip() -> None:
    """By inertia such a slider would be 1e10 thresholds behind, but not further than the drive has gone."""
    machine = {"spring": 1e-9, "mass": 1e-3, "velocity": 1e7, "n_contacts": 40}
    found = eq_model.simulate(origins.Contacts(GAUSSIAN), [1.02e9], seed=3, **machine)
    assert found.slips.drive.size == 0 and 0.0 < found.force[0] < 1.02


def same_slips(few: Any, many: Any) -> None:
    """To the rounding of times that are added up on other ways."""
    assert (few.breaks == many.breaks).all()
    for name in ("drive", "before", "after", "force_before", "force_after"):
        assert np.abs(getattr(few, name) - getattr(many, name)).max(initial=0.0) < 1e-9, name
    for name in ("duration", "top_speed"):
        assert np.allclose(getattr(few, name), getattr(many, name), rtol=1e-7, atol=0.0), name


@pytest.mark.parametrize("warm", [False, slow(True)])
def test_slips_of_drawn_machines_are_those_of_their_motion_with_any_points(warm: bool) -> None:
    """With 1, 10 and 1,000 points, where the slider moves alike: chance magnifies rounding in a few of them. A fall
    that begins and ends between two breaks belongs to the slips, and the slider rings on its contacts, or creeps."""
    draws, alike, with_slips = np.random.default_rng(5), 0, 0
    laws = [origins.identical(1.0), *map(origins.gaussian, [1.0] * 3, [1e-6, 1e-3, 0.2])]
    for k in range(60):
        spring, mass, ratio = 10.0 ** draws.uniform([-2.0, -6.0, -2.0], [-0.2, -0.5, 1.3])
        swing, end = 2.0 * np.pi * (mass / spring) ** 0.5, draws.uniform(2.0, 4.0) / spring + 2.0
        machine = {"spring": spring, "mass": mass, "damping": 2.0 * ratio * (mass * spring) ** 0.5}
        machine |= {"velocity": 10.0 ** draws.uniform(-2.5, 0.5), "n_contacts": [50, 200][k % 2]}
        heat = origins.Thermal("eyring", width=10.0 ** draws.uniform(-2.3, -1.3)) if warm else None
        delay = origins.Delay(swing * 10.0 ** draws.uniform(-1.0, 1.0)) if k // 4 % 2 else None
        contacts = origins.Contacts(laws[k % 4], thermal=heat, delay=delay)
        many, ten, one = (
            eq_model.simulate(contacts, np.linspace(0.0, end, n + 1)[1:], seed=3, **machine)
            for n in (1000, 10, 1)
        )
        off = [np.abs(ten.force - many.force[99::100]).max(), np.abs(one.force - many.force[-1])[0]]
        if max(off) < 1e-9:
            same_slips(ten.slips, many.slips)
            same_slips(one.slips, many.slips)
            alike, with_slips = alike + 1, with_slips + (many.slips.drive.size > 0)
    assert alike > 50 and with_slips > 35
