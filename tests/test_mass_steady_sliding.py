"""A slider with mass in heat on the spring of a machine, which slides by a million thresholds without steps."""

import numpy as np
import pytest
from conftest import slow
from scipy.integrate import simpson, solve_ivp

import master
import origins
from master.motion import drive_motion
from master.soft.in_time.contacts import ContactsInSteps
from master.soft.in_time.refining import memory_of
from master.soft.inertia.in_time.slider import HeavySlider
from master.soft.inertia.in_time.steady_motion import SlidingMachine, SteadyMotion
from master.soft.inertia.in_time.steady_sliding import sliding_of
from master.steady.kinetic_table import tabulated
from origins import Contacts, Drive, Thermal

EYRING = Thermal("eyring", width=0.03, attempt_frequency=1e3)
WIDE = Contacts(origins.gaussian(1.0, 0.2), thermal=EYRING)
# thresholds that grow by 1.5 % of their first values in each factor e of time
STRONGER = Contacts(
    origins.strengthening(origins.gaussian(1.0, 0.2), 0.015, 1e-3),
    thermal=Thermal("eyring", width=0.06, attempt_frequency=1e3),
)


@pytest.mark.parametrize(
    ("contacts", "damping", "beside"),
    [
        # quick: the equations of sliding, below, and sliders that slide so in their slips, in test_mass_long_slips.py
        slow(WIDE, 8e-9, False),
        # beside the slider without mass
        slow(WIDE, 8e-9, True),
        slow(WIDE, 8e-5, False),
        slow(STRONGER, 8e-9, True),
    ],
)
def test_on_the_spring_of_a_machine_it_creeps_and_slides_on(
    contacts: Contacts, damping: float, beside: bool
) -> None:
    """Without its damping it is the slider without mass; with it the spring bears γ V more, at V = v in the end."""
    spring, path = 1e-6, np.linspace(0.0, 1e6, 41)[1:]
    machine = {"spring": spring, "velocity": 100.0}
    heavy = master.solve(contacts, path, 1e-2, mass=1.6e-9, damping=damping, **machine)
    assert heavy.success and heavy.regime.verdict == "smooth" and "slides steadily" in heavy.message
    steady = master.steady_state(contacts, velocity=100.0).force
    # F_k is read off a table, which is less exact of thresholds that grow, as it takes long there
    off = 1e-6 if contacts is WIDE else 1e-5
    assert heavy.force[-1] == pytest.approx(steady + 100.0 * damping, abs=off)
    assert heavy.contact_force[-1] == pytest.approx(steady, abs=off)
    assert heavy.velocity[-1] == pytest.approx(100.0)
    x = np.linspace(0.0, 3.2, 2001)
    at_x = master.steady_state(contacts, velocity=100.0).distribution(x)
    assert heavy.energy.contacts[-1] == pytest.approx(simpson(0.5 * x**2 * at_x, x=x), rel=1e-3)
    np.testing.assert_allclose(heavy.energy.missing, 0.0, atol=off * heavy.energy.drive[-1])
    if beside:
        light = master.solve(contacts, path, 1e-2, slip="instant", **machine)
        apart = np.abs(heavy.force - light.force).max()
        assert apart <= heavy.force_error + light.force_error


@pytest.mark.parametrize(
    ("machine", "speed"),
    [
        slow(SlidingMachine(0.011, 0.0, 6.1e-3, 1.7, 1.0, 2.2, np.inf), 0.09),
        (SlidingMachine(3.0, 3.0, 1e-2, 5.0, 1.0, 2.2, np.inf), 0.2),
        (SlidingMachine(1e-7, 0.1, 1e-3, 2.0, 1.0, 2.2, np.inf), 1.0),
    ],
)
def test_inertia_is_left_out_only_where_it_is_small(machine: SlidingMachine, speed: float) -> None:
    """The equations of sliding, in balance or not, beside the full one integrated by scipy, and their energies."""
    table, u = tabulated(WIDE, np.log([1e-4, 1e6]), 1e-5), float(np.log(speed))
    load = float(table.force(u)) + machine.damping * speed
    begin, end = np.array([u, load, *np.zeros(5)]), 0.3 / machine.spring / machine.drive_speed
    rows, at_end = SteadyMotion(machine, table, end).followed(begin, end, 1e3)
    _, u, force, times, given, damped, on_contacts, _ = rows
    assert at_end and times[-1] == pytest.approx(end)

    def full(_: float, state: np.ndarray) -> list[float]:
        at = float(np.exp(state[0]))
        off = state[1] - machine.damping * at - float(table.force(state[0]))
        return [off / (machine.mass * at), machine.spring * (machine.drive_speed - at)]

    asked = {"method": "Radau", "rtol": 1e-9, "atol": 1e-10}
    plain = solve_ivp(full, (0.0, times[-1]), begin[:2], t_eval=times, **asked)
    np.testing.assert_allclose(force, plain.y[1], atol=1e-5)
    kinetic = 0.5 * machine.mass * np.exp(2.0 * u)
    rest = given - damped - on_contacts - 0.5 * force**2 / machine.spring - kinetic
    np.testing.assert_allclose(rest, rest[0], atol=1e-5 + 1e-3 * kinetic.max())


def test_contacts_stand_as_in_steady_sliding() -> None:
    """Those with which steps go on behind a long way: F_k at this speed, to second order in the step."""
    for sign in (1.0, -1.0):
        off = []
        for halvings in (0, 1):
            cohorts = ContactsInSteps(WIDE, memory_of(WIDE, halvings, 1.0), halvings, until=np.inf)
            cohorts.slide_to(5.0 * sign, 3.0, 0.2 * sign, 0.1 * 0.5**halvings)
            assert cohorts.holding == pytest.approx(1.0)
            assert (cohorts.position, cohorts.now) == (5.0 * sign, 3.0)
            off.append(sign * cohorts.force - master.steady_state(WIDE, velocity=0.2).force)
        assert abs(off[1]) < 1e-3 and abs(off[1]) < 0.5 * abs(off[0])


@pytest.mark.slow
def test_steps_lead_where_sliding_without_them_leads(monkeypatch: pytest.MonkeyPatch) -> None:
    """On a stiffer spring both are known: after a slip the slider creeps, with more steps than are taken else, and
    without."""
    monkeypatch.setattr("master.soft.in_time.contacts.MOST_STEPS", 16e3)
    contacts = Contacts(origins.gaussian(1.0, 0.05), thermal=EYRING)
    drive = Drive(np.linspace(0.0, 90.0, 46)[1:], 1e-2, None, 1e-2, None, 1e-2, 1e-3)
    motion, ends = drive_motion(drive, 0.0), []
    for sliding in (None, sliding_of(contacts, drive, motion, 1e-2, np.inf)):
        cohorts = ContactsInSteps(contacts, memory_of(contacts, 0, 1e-2), 0, np.inf)
        slider = HeavySlider(cohorts, drive, motion, 1e-2, sliding)
        slider.run()
        assert bool(slider.slides) is bool(sliding)
        ends.append(slider.sections[-1][-1])
    with_steps, without = ends
    assert without.force == pytest.approx(with_steps.force, abs=2e-4)  # these are off by 1e-4
    assert without.speed == pytest.approx(with_steps.speed, rel=1e-3)
    for energy in ("work", "damped", "on_contacts", "stored"):
        assert getattr(without, energy) == pytest.approx(getattr(with_steps, energy), rel=3e-3)
