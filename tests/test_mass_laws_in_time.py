"""A slider with mass on contacts whose laws depend on time, by the master equation: other roads and exact answers."""

from collections.abc import Sequence

import numpy as np
import pytest
from conftest import slow
from solving import oscillator

import master
import origins
from master.motion import drive_motion
from master.outcome import unheard
from master.soft.in_time.contacts import ContactsInSteps
from master.soft.in_time.refining import memory_of
from master.soft.inertia.in_time.answer import error_by
from master.soft.inertia.in_time.refining import HeavyFound, follow_in_steps
from master.soft.inertia.in_time.slider import HeavySlider
from origins import Ageing, Contacts, Delay, Drive, InputError, Thermal, strengthening
from toolkit.stability.heavy import by_steps

WIDE = origins.gaussian(1.0, 0.2)
EYRING = Thermal("eyring", width=0.03)
HOT = Contacts(WIDE, thermal=EYRING)
GROWING = Contacts(strengthening(WIDE, 0.05, 1.0))
PATH = np.linspace(0.1, 5.0, 50)


def in_steps(contacts: Contacts, drive: Drive, tolerance: float) -> HeavyFound:
    """The slider in steps of time, also of contacts that master.solve follows otherwise."""
    return follow_in_steps(contacts, drive, tolerance, unheard, np.inf)


TIMES = np.linspace(0.5, 24.0, 48)
# forward, a hold, and back past the begin of the hold
TURNING = np.interp(TIMES, [0.0, 8.0, 16.0, 24.0], [0.0, 8.0, 8.0, 3.0])


@pytest.mark.parametrize(
    ("law", "delay", "drive"),
    [
        slow(*(WIDE, None, Drive(PATH, spring=0.3, mass=0.3, damping=0.03))),
        (origins.gaussian(1.0, 0.1), None, Drive(TURNING, 1.0, TIMES, 0.1, None, 0.3, 0.1)),
        # quick: the slip without heat, in test_mass_flights.py
        slow(*(WIDE, Delay(0.7), Drive(PATH, spring=0.1, mass=0.3, damping=0.1))),
        slow(*(WIDE, None, Drive(PATH, spring=0.3, mass=1e-3, damping=1.0))),
    ],
    ids=["free", "turns", "delay", "overdamped"],
)
def test_without_laws_in_time_both_roads_lead_to_one_motion(
    law: origins.Thresholds, delay: Delay | None, drive: Drive
) -> None:
    """At T = 0 the slider is followed on the panels of F, or with a delay by collocation; in steps it is the same."""
    contacts = Contacts(law, delay=delay)
    machine = {"spring": drive.spring, "mass": drive.mass, "damping": drive.damping}
    clock = {} if drive.time is None else {"time": drive.time}
    exact = master.solve(contacts, drive.path, 1e-7, **machine, **clock)
    found = in_steps(contacts, drive, 1e-4)
    followed, columns = found.followed, found.columns
    assert exact.success and followed.error_of_force_and_load <= 1e-4
    assert np.abs(followed.force - exact.force).max() <= followed.error_of_force_and_load
    assert np.abs(columns["force"] - exact.contact_force).max() <= found.contact_force_error
    assert np.abs(followed.holding - exact.holding).max() <= followed.holding_error
    assert np.abs(columns["speed"] - exact.velocity).max() < 1e-4
    for ours, theirs in (
        (columns["work"], exact.energy.drive),
        (columns["damped"], exact.energy.damped),
        (columns["stored"], exact.energy.contacts),
    ):
        np.testing.assert_allclose(ours, theirs, atol=1e-4)


@pytest.mark.slow
def test_slips_are_those_of_the_other_road() -> None:
    """One slip after a delay: where it begins, its forces, its duration and its top speed."""
    contacts = Contacts(origins.gaussian(1.0, 0.1), delay=Delay(3.0))
    machine = {"spring": 0.1, "mass": 0.1, "damping": 0.1, "velocity": 0.2}
    path = np.linspace(0.2, 12.0, 60)
    exact = master.solve(contacts, path, 1e-6, **machine).slips
    found = in_steps(contacts, Drive(path, **machine), 3e-3).followed
    assert exact.drive.size == found.slips.drive.size == 1 and found.error_of_force_and_load <= 3e-3
    for name in ("force_before", "force_after"):
        assert (
            np.abs(getattr(exact, name) - getattr(found.slips, name)).max()
            <= found.error_of_force_and_load
        )
    assert np.abs(exact.drive - found.slips.drive).max() <= found.slips.drive_error
    assert np.abs(exact.duration - found.slips.duration).max() <= found.slips.duration_error
    np.testing.assert_allclose(found.slips.top_speed, exact.top_speed, rtol=1e-3)


# Nearly equal contacts that strengthen, on a drive that turns: between its turns the slider swings farther than a step.
SWINGS_BACK = Contacts(strengthening(origins.gaussian(1.0, 0.02), 0.023, 0.32))
SWINGING = {"spring": 0.302, "mass": 0.157, "damping": 0.015}


@pytest.mark.parametrize("halvings", [0, slow(1)])
def test_no_step_leads_through_a_turn_of_the_slider_and_back(halvings: int) -> None:
    """One step led through a whole swing, on all halvings alike: X was off by 0.36, with an error told of 4e-3."""
    drive = Drive([4.49, 3.14], time=[14.3, 20.44], **SWINGING)
    memory, motion = memory_of(SWINGS_BACK, halvings, 1.0), drive_motion(drive, 0.0)
    cohorts = ContactsInSteps(SWINGS_BACK, memory, halvings, np.inf)
    slider = HeavySlider(cohorts, drive, motion, 1e-2)
    slider.run()
    for nodes in slider.sections:
        # each is from a turn to the next: the slider goes one way, which may turn at rounding alone
        moved = np.diff([node.position for node in nodes])
        assert (moved >= -1e-9).all() or (moved <= 1e-9).all()
    assert sum(node.speed == 0.0 for nodes in slider.sections for node in nodes[1:]) == 4


@pytest.mark.slow
def test_errors_of_nearly_equal_contacts_that_swing_back_hold() -> None:
    """The last two answers on long steps agree by chance, and the smaller of two changes was told as the error."""
    times = np.linspace(0.0, 20.44, 41)[1:]
    path = np.interp(times, [0.0, 14.3, 20.44], [0.0, 4.49, 3.14])
    roughly, well = (
        master.solve(SWINGS_BACK, path, tolerance, time=times, **SWINGING)
        for tolerance in (1e-2, 1e-3)
    )
    assert roughly.success and well.success and well.force_error < 0.5 * roughly.force_error
    off = np.abs(well.force - roughly.force).max() / SWINGS_BACK.mean_threshold
    assert off < roughly.force_error + well.force_error


@pytest.mark.slow  # quick: strengthening beside even steps, below
@pytest.mark.parametrize(
    "contacts",
    [
        Contacts(WIDE, ageing=Ageing(WIDE, 0.02)),
        Contacts(WIDE, reforming=-0.2),
        Contacts(origins.growing_grains(1.0, 1.0, age=4.0)),
    ],
    ids=["ageing", "re-forming", "grains"],
)
def test_other_laws_beside_a_mass_agree_with_shorter_steps(contacts: Contacts) -> None:
    path = np.linspace(0.3, 3.0, 10)
    given = {"spring": 0.5, "mass": 0.3, "damping": 0.3, "velocity": 0.5}
    roughly, well = (master.solve(contacts, path, part, **given) for part in (1e-2, 2e-4))
    assert roughly.success and well.force_error < roughly.force_error
    off = np.abs(well.force - roughly.force).max() / contacts.mean_threshold
    assert off <= roughly.force_error + well.force_error


@pytest.mark.parametrize(
    ("changes", "error"),
    [
        ((4.0, 1.0, 0.2), 3.0),  # as the square: the larger of the last ones
        ((4.0, 1.0, 1.5), 4.5),
        ((4.0, 3.0, 2.7), 9.0),  # they hardly fall
        (
            (4.0, 0.1, 0.2),
            3.0,
        ),  # the last two agree by chance: a quarter of the change before is left
    ],
)
def test_the_error_is_that_of_the_larger_change(changes: Sequence[float], error: float) -> None:
    assert error_by(np.array(changes)[:, None], 3.0) == pytest.approx(error)


def test_errors_fall_as_the_square_of_the_steps() -> None:
    """Of the position at the end of the path, and of what contacts store there."""
    contacts, drive = Contacts(WIDE), Drive([2.0], spring=0.3, mass=0.3, damping=0.1)
    exact = master.solve(contacts, [2.0], 1e-10, spring=0.3, mass=0.3, damping=0.1)
    motion = drive_motion(drive, 0.0)
    off = []
    for halvings in (2, 3, 4, 5):
        memory = memory_of(contacts, halvings, 1.0)
        slider = HeavySlider(
            ContactsInSteps(contacts, memory, halvings, np.inf), drive, motion, 1e-9
        )
        slider.run()
        end = slider.sections[-1][-1]
        off.append([end.position - exact.position[0], end.stored - exact.energy.contacts[0]])
    orders = np.log2(np.abs(np.array(off[:-1]) / np.array(off[1:])))
    assert (np.abs(orders[1:] - 2.0) < 0.2).all(), orders


@pytest.mark.parametrize(
    "mass, damping", [(0.1, 0.0), *(slow(*one) for one in ((1e-3, 1e-3), (0.1, 3.0)))]
)
def test_where_none_breaks_it_is_an_oscillator(mass: float, damping: float) -> None:
    """On contacts that grow stronger, so that they are followed in steps; by the roots of m r² + c r + S = 0."""
    spring, path = 0.5, np.linspace(0.01, 0.6, 60)
    contacts = Contacts(strengthening(origins.gaussian(1.0, 0.02), 0.03, 1.0))
    found = master.solve(contacts, path, 1e-6, spring=spring, mass=mass, damping=damping)
    x, _ = oscillator(path, spring, mass, damping)
    assert found.success, found.message
    # what rings below a fiftieth of the tolerance may count as rest
    assert np.abs(found.position - x).max() < 1e-6
    np.testing.assert_allclose(found.contact_force, x, atol=1e-6)
    assert not found.slips.drive.size


@pytest.mark.slow
@pytest.mark.parametrize("mass", [0.01, 0.3])
def test_steady_sliding_bears_kinetic_friction_and_damping(mass: float) -> None:
    """F_k(v) + γ v, whatever the mass."""
    kinetic = master.steady_state(GROWING, velocity=0.5).force
    machine = {"spring": 2.0, "mass": mass, "damping": 0.3, "velocity": 0.5}
    found = master.solve(GROWING, [12.0], 1e-3, **machine)
    assert found.success, found.message
    assert found.force[0] == pytest.approx(kinetic + 0.15, abs=found.force_error + 3e-4)
    assert found.velocity[0] == pytest.approx(0.5, abs=1e-3)


@pytest.mark.parametrize(
    ("contacts", "slips"),
    [
        slow(HOT, 1, id="eyring"),
        slow(Contacts(WIDE, thermal=Thermal("soft", 0.02)), 1, id="soft"),
        pytest.param(GROWING, 0, id="strengthening"),
    ],
)
def test_even_steps_with_cohorts_lead_through_the_same_motion(
    contacts: Contacts, slips: int
) -> None:
    """By Verlet's rule: nothing is searched for, and no balance solved."""
    path = 0.25 * np.arange(1, 49 if slips else 25)
    drive = {"spring": 0.1, "mass": 0.3, "damping": 0.1, "velocity": 0.5}
    found, plain = master.solve(contacts, path, 3e-3, **drive), by_steps(contacts, path, drive)
    assert found.success and found.slips.drive.size == slips, found.message
    off = np.abs(found.force / contacts.mean_threshold - plain.values)
    assert (off <= found.force_error + plain.error).all() and plain.error.max() < 1e-5
    assert np.ptp(plain.values) > 0.4


@pytest.mark.slow
def test_a_light_slider_slips_in_no_time() -> None:
    """M -> 0 and γ -> 0: as under "instant", but for what is proportional to γ, 5e-3 <x_s> or less here."""
    path = np.linspace(0.4, 6.0, 15)
    instant = master.solve(GROWING, path, 3e-3, spring=0.3, slip="instant")
    forces = []
    for damping in (2e-3, 1e-3):
        found = master.solve(GROWING, path, 3e-3, spring=0.3, mass=1e-6, damping=damping)
        assert found.success, found.message
        forces.append(found.force)
    off = np.abs(2.0 * forces[1] - forces[0] - instant.force).max()
    assert off < 2e-3 < 4e-3 < np.abs(forces[0] - instant.force).max()
    assert instant.slips.drop[0] > 0.2


@pytest.mark.parametrize(("tolerance", "within"), [(3e-3, 3e-4), slow(1e-4, 1e-5)])
def test_energy_is_kept_and_damping_takes_its_part(tolerance: float, within: float) -> None:
    """drive = change of (spring + contacts + kinetic) + damped + released; damped is the integral of γ V²."""
    path = np.linspace(0.04, 10.0, 250)
    contacts = Contacts(strengthening(WIDE, 0.05, 1.0), start=0.1)
    found = master.solve(
        contacts, path + 0.1 / 0.2, tolerance, spring=0.2, mass=0.3, damping=0.1, velocity=0.5
    )
    energy = found.energy
    stored = energy.spring + energy.contacts + energy.kinetic
    first = 0.5 * 0.1**2 / 0.2 + 0.5 * 0.1**2
    spent = stored - first + energy.damped + energy.released
    np.testing.assert_allclose(energy.drive, spent, atol=within)
    times, speed = path / 0.5, found.velocity
    damped = 0.1 * np.trapezoid(np.append(0.0, speed) ** 2, np.append(0.0, times))
    assert energy.damped[-1] == pytest.approx(damped, rel=2e-3)
    assert (np.diff(energy.released) >= -within).all() and energy.released[-1] > 0.3


def test_a_slider_at_rest_stays_there_while_its_drive_holds() -> None:
    found = master.solve(HOT, [0.0, 0.0], 1e-3, time=[0.0, 5.0], spring=0.3, mass=0.1)
    assert (
        found.success and np.abs(found.force).max() < 1e-9 and np.abs(found.velocity).max() < 1e-9
    )


@pytest.mark.parametrize(
    ("contacts", "path", "told"),
    [
        (Contacts(WIDE, reforming=-0.2), [1e4], "goes on by"),
        (Contacts(origins.identical(1.0), thermal=EYRING), [3.0], "give the exact values a width"),
        (HOT.replace(stiffness="linked"), [3.0], "use eq_model.simulate"),
    ],
)
def test_what_is_not_followed_is_refused_before_the_work(
    contacts: Contacts, path: list[float], told: str
) -> None:
    with pytest.raises(InputError, match=told) as why:
        master.solve(contacts, path, 1e-3, spring=0.1, mass=0.1)
    assert "\n" not in str(why.value)


@pytest.mark.slow
def test_a_slider_that_rings_without_damping_asks_for_one() -> None:
    """It is seen after some thousand steps."""
    with pytest.raises(InputError, match="give a larger damping"):
        master.solve(GROWING, [4.0], 1e-3, spring=0.1, mass=1e-4, velocity=0.1)


@pytest.mark.slow
def test_a_slip_of_too_many_steps_is_refused_with_its_place_before_which_the_path_is_followed() -> (
    None
):
    """Of 6,000 thresholds in heat: no damping that keeps it a slip would shorten it, and none is asked for."""
    heat = Contacts(WIDE, thermal=Thermal("soft", 0.02, 100.0))
    machine = {"spring": 1e-4, "mass": 1e-6, "damping": 2e-6, "velocity": 1e3}
    with pytest.raises(InputError, match=r"before the slip at X_T = 65.*slip rule") as why:
        master.solve(heat, [2e4], 1e-2, **machine)
    assert "damping" not in str(why.value)
    assert master.solve(heat, [6500.0], 1e-2, **machine).success


def test_wall_time_ends_the_work() -> None:
    found = master.solve(HOT, PATH, 1e-6, spring=0.1, mass=0.01, velocity=0.1, wall_time=1e-3)
    assert not found.success and "wall_time" in found.message


def test_no_birth_is_taken_back_where_none_holds() -> None:
    """A slow step longer than the delay, before a slip, tells too many births. Taken back on the next step, they are a
    negative share of the contacts, which pushes the slider on: one with mass, of a stiffness without a root, ended the
    verdict in a traceback."""
    waiting = Contacts(WIDE, delay=Delay(30.0))
    contacts = ContactsInSteps(waiting, memory_of(waiting, 0, 1.0), 0, np.inf)
    contacts.holding, contacts.births = 0.0, 0.3
    trial = contacts.trial(3.0, 1.0)
    assert trial.births == 0.3 and trial.holding >= 0.0


@pytest.mark.slow
def test_a_path_that_ends_as_a_slip_does_is_no_finer_than_one_that_ends_in_it() -> None:
    """On the coarsest of three halvings the slip has ended, on the others not: as the slip was thought to be missing,
    the error was its whole fall, and steps were halved again until all agreed, twice as many in all."""
    drive = {"spring": 0.1, "mass": 0.3, "damping": 0.05, "velocity": 0.5}
    path = np.linspace(0.0, 11.2055, 9)[1:]
    found = master.solve(HOT, path, 3e-3, **drive)
    assert found.success and found.slips.drive.size == 0
    longer = master.solve(HOT, [*path, 13.0], 3e-3, **drive)
    assert longer.success and longer.slips.drive.size == 1
    off = np.abs(found.force - longer.force[:-1]).max()
    assert off <= found.force_error + longer.force_error
    assert found.nodes < 1.1 * longer.nodes
