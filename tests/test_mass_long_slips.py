"""Slips of a slider with mass by a million thresholds, of contacts that grow stronger: F_k(V), then ringing."""

from types import SimpleNamespace

import numpy as np
import pytest
import scipy.stats as st
from scipy.integrate import solve_ivp
from scipy.interpolate import make_interp_spline

import eq_model
import master
import origins
from master.motion import drive_motion
from master.soft.in_time.contacts import ContactsInSteps
from master.soft.in_time.refining import memory_of
from master.soft.inertia.in_time.clocks import Clocks
from master.soft.inertia.in_time.long_slips import long_slips_of
from master.soft.inertia.in_time.node import HeavyNode
from master.soft.inertia.in_time.ringing import Ringing, with_rings
from master.stick_slip.extremes import extremes
from origins import Contacts, Delay, Drive, Thermal

NORMAL = origins.gaussian(1.0, 0.2)
STRONGER = Contacts(origins.strengthening(NORMAL, 0.03, 1e-4))
# the spring of a machine: 50 N/m, 0.1 kg and 1 N s/m for an interface of 5e7 N/m, in mean thresholds and s
MACHINE = {"spring": 1e-6, "mass": 2.2e-9, "damping": 2.2e-8, "velocity": 167.0}


def slows_down(_: float, state: np.ndarray) -> float:
    """Above 0 while the slider is faster than its drive."""
    return float(state[1] - MACHINE["velocity"])


def test_a_slip_of_a_million_thresholds_is_that_of_f_k() -> None:
    """Beside the slider whose friction is F_k at its present speed, by scipy, from the force at which it slips; which
    is that of the slider without mass."""
    spring, mass, damping, drive = MACHINE.values()
    path = np.linspace(0.0, 1.2 / spring, 8)
    solved = master.solve(STRONGER, path, 1e-2, **MACHINE)
    assert solved.success and solved.slips.drive.size == 1
    claim, begin = spring * solved.slips.drive_error, float(solved.slips.force_before[0])
    speeds = np.geomspace(1e2, 1e8, 41)
    forces = [master.steady_state(STRONGER, velocity=speed).force for speed in speeds.tolist()]
    friction = make_interp_spline(np.log(speeds), forces, k=5)

    def rates(_: float, state: np.ndarray) -> list[float]:
        load, speed = state
        rest = damping * speed + float(friction(np.log(np.clip(speed, 1e2, 1e8))))
        return [spring * (drive - speed), (load - rest) / mass]

    slows_down.terminal, slows_down.direction = True, -1.0  # type: ignore[attr-defined]
    asked = {"method": "LSODA", "rtol": 1e-9, "atol": 1e-12, "events": slows_down}
    plain = solve_ivp(rates, (0.0, 1.0), [begin, 2.0 * drive], **asked)
    assert abs(plain.y[0, -1] - solved.slips.force_after[0]) < claim < 1e-2
    assert abs(plain.t[-1] - solved.slips.duration[0]) < solved.slips.duration_error < 0.01
    assert solved.slips.top_speed[0] == pytest.approx(plain.y[1].max(), rel=1e-3)
    # the contacts let go on the first thresholds of a slip, so that the energy is not that of F_k from its begin on
    light = master.solve(STRONGER, path, 1e-3, spring=spring, slip="instant", velocity=drive)
    apart = abs(light.slips.force_before[0] - begin)
    assert apart < claim + spring * light.slips.drive_error
    energy = solved.energy
    np.testing.assert_allclose(energy.missing, 0.0, atol=1e-5 * energy.drive[-1])


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_it_is_the_exact_slip_where_contacts_hardly_grow(seed: int) -> None:
    """Without growth F is that of a rigid slider at X as long as it moves on, and its motion an ordinary differential
    equation; growth by a billionth is none."""
    rng = np.random.default_rng(seed)
    law = [origins.gaussian(1.0, 0.4), st.gamma(6.0, scale=1.0 / 6.0), NORMAL][seed]
    spring, drive = 10.0 ** rng.uniform(-5.0, -3.0), 10.0 ** rng.uniform(0.0, 1.0)
    mass = spring * 10.0 ** rng.uniform(-3.0, 0.0)
    damping = 2.0 * 10.0 ** rng.uniform(-1.5, -0.5) * (spring * mass) ** 0.5
    machine = {"spring": spring, "mass": mass, "damping": damping, "velocity": drive}
    # a period of mass and spring beyond the first slip
    peak = extremes(Contacts(law), 1.0, 1e-3).force.value
    end = 1.003 * peak / spring + 4.0 * drive * (mass / spring) ** 0.5
    path = np.linspace(0.0, end, 9)
    exact = master.solve(Contacts(law), path, 1e-5, **machine)
    grown = Contacts(origins.strengthening(law, 1e-9, 1.0))
    ours = master.solve(grown, path, 1e-2, **machine)
    assert ours.slips.drive.size == exact.slips.drive.size == 1
    claim = spring * (ours.slips.drive_error + exact.slips.drive_error)
    assert claim < 2e-2
    for name in ("force_before", "force_after"):
        assert abs(getattr(ours.slips, name) - getattr(exact.slips, name))[0] < claim
    of_duration = ours.slips.duration_error + exact.slips.duration_error
    assert abs(ours.slips.duration - exact.slips.duration)[0] < of_duration
    assert np.abs(ours.force - exact.force).max() < ours.force_error + exact.force_error
    off = np.abs(ours.contact_force - exact.contact_force).max()
    assert off < ours.contact_force_error + exact.contact_force_error


RINGING = MACHINE | {"damping": 1e-6}


def at_a_turn(contacts: Contacts, now: float) -> tuple[Ringing, ContactsInSteps, HeavyNode]:
    """A slider that turns round at this time, as its contacts are stretched by 0.15 and have been by 0.3."""
    drive = Drive(np.array([1e7]), **RINGING)
    motion = drive_motion(drive, 0.0)
    assert motion is not None
    cohorts = ContactsInSteps(contacts, memory_of(contacts, 0, 1.0, motion), 0, np.inf)
    cohorts.take(cohorts.trial(0.3, 0.5 * now), 1.0)
    cohorts.take(cohorts.trial(-0.15, now), 1.0)
    place = now, cohorts.force, cohorts.holding, cohorts.position
    node = HeavyNode(0.0, *place, 0.0, 0.0, 0.0, 0.0, 0.0)
    return Ringing(drive, motion, 1e-2, 1.0), cohorts, node


def test_a_slider_rings_on_contacts_that_hold() -> None:
    """Until it rests, beside the oscillator by scipy, and the energies."""
    spring, mass, damping, drive = RINGING.values()
    ringing, cohorts, node = at_a_turn(STRONGER, 1e-3)
    ring = ringing.ahead(0, 1.0, cohorts, node)
    assert ring is not None and 0.0 < ring.broken < 1e-4
    times = node.time + ring.lasts * np.linspace(0.01, 0.9, 31)

    def rates(t: float, state: np.ndarray) -> list[float]:
        place, speed = state[:2]
        load, force = spring * (drive * t - place), node.force + node.holding * (place - 0.15)
        pushed = (load - force - damping * speed) / mass
        return [speed, pushed, load * drive, damping * speed**2]

    asked = {"method": "DOP853", "rtol": 1e-10, "atol": 1e-12, "t_eval": times}
    plain = solve_ivp(rates, (node.time, times[-1]), [0.15, 0.0, 0.0, 0.0], **asked).y
    force, holding, place, speed, work, damped, on_contacts, stored = ring.columns(times)
    np.testing.assert_allclose(place, plain[0], atol=1e-8)
    np.testing.assert_allclose(speed, plain[1], atol=1e-3)  # of some 1e4
    np.testing.assert_allclose([work, damped], plain[2:], atol=1e-8)
    np.testing.assert_allclose(force, node.force + node.holding * (place - 0.15), atol=1e-12)
    left = work - damped - on_contacts - 0.5 * mass * speed**2
    of_spring = 0.5 * spring * (drive * times - place) ** 2
    np.testing.assert_allclose(left, of_spring, atol=1e-8)
    assert np.all(holding == node.holding) and np.all(stored == on_contacts)
    replaced = with_rings(np.zeros((8, 2)), [ring], np.array([0.0, times[3]]))
    assert replaced[2].tolist() == [0.0, place[3]]


def test_it_does_not_where_contacts_break() -> None:
    """Where the spring pulls them beyond their largest stretch; nor are slips so where heat breaks them, others come
    back, they do not grow, or the drive stops."""
    ringing, cohorts, node = at_a_turn(STRONGER, 6e3)
    assert ringing.ahead(0, 1e4, cohorts, node) is None
    drive = Drive(np.array([1e7]), **RINGING)
    assert long_slips_of(STRONGER, drive, drive_motion(drive, 0.0), 1e-2, np.inf) is not None
    for other in (
        Contacts(NORMAL),
        STRONGER.replace(delay=Delay(1e-3)),
        STRONGER.replace(thermal=Thermal("eyring", width=0.03, attempt_frequency=1e3)),
    ):
        assert long_slips_of(other, drive, drive_motion(drive, 0.0), 1e-2, np.inf) is None
    holds = Drive(np.array([1e7, 1e7]), time=np.array([1.0, 2.0]), **(RINGING | {"velocity": 1.0}))
    assert long_slips_of(STRONGER, holds, drive_motion(holds, 0.0), 1e-2, np.inf) is None


def test_a_swing_of_unknown_phase_counts_in_full() -> None:
    """Where a slip's time is known to a part of a period of the ringing behind it, the force at a point there is not
    known better than the swing is large; it seemed to be where that time was a whole number of periods."""
    drive = Drive(np.array([1e7]), **RINGING)
    ringing, cohorts, node = at_a_turn(STRONGER, 1e-3)
    ring = ringing.ahead(0, 1.0, cohorts, node)
    assert ring is not None
    period, spring = ring.motion.period, RINGING["spring"]
    slider = SimpleNamespace(rings=[ring], spring=spring, motion=drive_motion(drive, 0.0))
    clocks = Clocks([slider], np.array([node.time]))  # type: ignore[list-item]
    at = node.time + 5.0 * period
    for periods in (0.3, 1.0, 4.0, 4.5):
        swing = 2.0 * float(ring.motion.bound((5.0 - periods) * period))
        assert clocks.unknown_of_ringing(at, periods * period) == pytest.approx(
            [spring * swing, ring.held.holding * swing]
        )
    assert not clocks.unknown_of_ringing(at, 0.2 * period).any()
    assert not clocks.unknown_of_ringing(at + ring.lasts, 4.0 * period).any()


@pytest.mark.slow
def test_contacts_themselves_slip_so() -> None:
    """The ensemble on a spring of 1e-2, extrapolated in N^(-2/3) and 1/N as in test_mass_agreement: forces and times of
    the first slip within four standard errors and what the solver claims."""
    machine = {"spring": 1e-2, "mass": 1e-3, "damping": 1e-3, "velocity": 0.3}
    contacts = Contacts(origins.strengthening(NORMAL, 0.05, 0.1))
    path, sizes, replicas = np.linspace(0.0, 150.0, 9), np.array([500, 2000, 8000]), (60, 30, 10)
    solved = master.solve(contacts, path, 1e-2, **machine)
    assert solved.slips.drive.size == 1 and solved.slips.force_error < 1e-2
    weights = np.linalg.inv(np.stack([sizes**-power for power in (0.0, 2 / 3, 1.0)], axis=1))[0]
    drawn = [
        eq_model.simulate(contacts, path, n_contacts=n, n_replicas=many, seed=3, **machine).slips
        for n, many in zip(sizes.tolist(), replicas, strict=True)
    ]
    claims = {"force_before": machine["spring"] * solved.slips.drive_error}
    claims |= {"force_after": claims["force_before"], "duration": solved.slips.duration_error}
    for name, claim in claims.items():
        firsts = [
            getattr(slips, name)[np.unique(slips.replica, return_index=True)[1]] for slips in drawn
        ]
        mean = weights @ [one.mean() for one in firsts]
        spread = np.array([one.std(ddof=1) / one.size**0.5 for one in firsts])
        error = float(np.hypot.reduce(weights * spread))
        assert abs(mean - getattr(solved.slips, name)[0]) < 4.0 * error + claim
        assert error < 0.04 * abs(mean)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_the_distance_from_slip_to_slip_is_known_better_than_their_places(seed: int) -> None:
    """Errors of X_T add up from slip to slip: beside finer steps the distances have an error of their own, which is a
    part of that of two places."""
    rng = np.random.default_rng(seed)
    law = [NORMAL, st.gamma(6.0, scale=1.0 / 6.0), origins.gaussian(1.0, 0.4)][seed]
    spring, drive = 10.0 ** rng.uniform(-6.0, -4.0), 10.0 ** rng.uniform(0.0, 2.0)
    mass = spring * 10.0 ** rng.uniform(-4.0, -1.0)
    damping = 2.0 * 10.0 ** rng.uniform(-1.0, -0.3) * (spring * mass) ** 0.5
    machine = {"spring": spring, "mass": mass, "damping": damping, "velocity": drive}
    grown, path = (
        Contacts(origins.strengthening(law, 0.03, 1e-3)),
        np.linspace(0.0, 4.2 / spring, 9),
    )
    ours, finer = (master.solve(grown, path, tolerance, **machine) for tolerance in (0.1, 0.02))
    assert ours.slips.drive.size == finer.slips.drive.size > 2
    off = np.abs(np.diff(ours.slips.drive) - np.diff(finer.slips.drive)).max()
    assert off < ours.slips.spacing_error + finer.slips.spacing_error
    assert ours.slips.period_error == ours.slips.spacing_error < 0.7 * 2.0 * ours.slips.drive_error
