"""A soft slider with mass, by the master equation: exact motions, scipy's integrator, limits, energy, the ensemble."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from conftest import slow
from scipy import stats
from scipy.integrate import solve_ivp
from scipy.interpolate import make_interp_spline
from scipy.optimize import brentq
from solving import oscillator

import eq_model
import master
import origins
from master.outcome import StoppedError
from master.soft.inertia.closed_falls import watch_closed
from master.soft.inertia.foretold import refuse_long_ringing
from master.soft.inertia.oscillation import Oscillation
from master.soft.inertia.run import FALL, NEAR, Run, SlipsInTime, times_apart
from origins import InputError
from origins.drive import LOWER

WIDE = origins.Contacts(origins.gaussian(1.0, 0.2))
NARROW = origins.Contacts(origins.gaussian(1.0, 0.05))
STRETCHED = origins.Contacts(
    origins.gaussian(1.0, 0.05), start=origins.gaussian_start(mean=0.2, std=0.05)
)
ELASTIC = origins.Contacts(origins.gw_elastic(1.0))


@pytest.mark.parametrize("mass, damping", [(0.1, 0.0), (1e-3, 1e-3), (0.1, 3.0)])
def test_without_breaks_it_is_an_oscillator(mass: float, damping: float) -> None:
    """From rest, by the roots of m r² + c r + S = 0."""
    spring, path = 0.5, np.linspace(0.01, 0.6, 60)
    contacts = origins.Contacts(origins.identical(1.0))
    found = master.solve(contacts, path, 1e-10, spring=spring, mass=mass, damping=damping)
    x, _ = oscillator(path, spring, mass, damping)
    assert found.success, found.message
    assert np.abs(found.position - x).max() < 1e-9
    np.testing.assert_allclose(found.contact_force, x, atol=1e-9)


def test_scipy_integrates_the_same_motion_on_the_force_of_a_rigid_slider() -> None:
    """Up to the first turn the slider moves one way, and F is that of a rigid slider at X."""
    spring, mass, damping = 0.3, 0.3, 0.3
    x = np.linspace(0.0, 6.0, 6001)
    force = make_interp_spline(x, master.solve(WIDE, x, 1e-11).force, 5)

    def moved(t: float, state: np.ndarray) -> list[float]:
        place, speed = state
        pull = spring * (t - place) - force(place) - damping * speed
        return [speed, float(pull) / mass]

    path = np.linspace(0.1, 5.0, 50)
    exact = solve_ivp(moved, [0.0, 5.0], [0.0, 0.0], "DOP853", path, rtol=1e-11, atol=1e-12)
    ahead = exact.y[1] > 0.0
    forward = slice(0, int(np.argmin(ahead)) if not ahead.all() else ahead.size)
    found = master.solve(WIDE, path, 1e-8, spring=spring, mass=mass, damping=damping)
    off = np.abs(found.position - exact.y[0])[forward].max()
    assert exact.t[forward].size > 30 and spring * off <= max(found.force_error, 1e-8)
    assert np.abs(found.velocity - exact.y[1])[forward].max() < 1e-6


@pytest.mark.slow  # quick: half a period of mass and spring, in test_mass_delay_master.py
def test_on_a_soft_spring_the_drop_is_twice_that_to_kinetic_friction() -> None:
    """K -> 0: 2 (F_s - F_k) in π (M/K)^(1/2) undamped, within 2 % at K = 1e-3."""
    spring, mass = 1e-3, 1e-2
    found = master.solve(WIDE, [712.0], 1e-4, spring=spring, mass=mass)
    kinetic, static = master.steady_state(WIDE).force, found.slips.force_before[0]
    assert found.slips.drop[0] / (2.0 * (static - kinetic)) == pytest.approx(1.0, abs=0.02)
    half = np.pi * (mass / spring) ** 0.5
    assert found.slips.duration[0] / half == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize("ratio", [1.2, 1.5, 3.0])
def test_above_critical_damping_a_slip_ends_at_the_pull_of_friction_and_damping(
    ratio: float,
) -> None:
    """The slider comes down to the drive's speed v = 1 without a swing: K (X_T - X) = F_k + γ v there."""
    spring, mass = 1e-3, 0.1
    damping = 2.0 * ratio * (spring * mass) ** 0.5
    end = 900.0 + 30.0 * damping / spring
    found = master.solve(WIDE, [end], 1e-5, spring=spring, mass=mass, damping=damping)
    borne = master.steady_state(WIDE).force + damping
    np.testing.assert_allclose([found.force[0], found.slips.force_after[0]], borne, atol=1e-5)


def test_a_light_slider_is_followed_in_any_unit_of_time() -> None:
    """Seconds are long beside its swing: the integrator's own first step led so far ahead that F took endless work."""
    mass, damping, path = 3.673469e-6, 5.714286e-7, np.linspace(0.0, 12.0, 17)[1:]
    contacts = origins.Contacts(origins.gaussian(1.0, 1.2 / 7.0))

    def force(unit: float) -> np.ndarray:
        machine = {"mass": mass * unit**2, "damping": damping * unit, "velocity": 1.0 / unit}
        found = master.solve(contacts, path, 1e-6, spring=0.01, wall_time=60.0, **machine)
        assert found.success, found.message
        return found.force

    np.testing.assert_allclose(force(7.0 / 300.0), force(1.0), rtol=0.0, atol=2e-6)


@pytest.mark.parametrize("tolerance", [1e-3, *(slow(fine) for fine in (1e-6, 1e-8))])
def test_the_slider_of_a_machine_on_its_soft_spring_slides_at_kinetic_friction(
    tolerance: float,
) -> None:
    """0.1 kg and 1 N s/m on 50 N/m, over a scan of which a mm² holds 4.5e7 N/m: a swing on the spring takes 1,000 times
    as long as one on the contacts. After F_s it comes to rest at F_k, at any tolerance."""
    spring, mass, damping, speed = 1.10382e-6, 2.20764e-9, 2.20764e-8, 161.4
    found = master.solve(
        WIDE,
        [9e5, 1.4e6],
        tolerance,
        spring=spring,
        mass=mass,
        damping=damping,
        velocity=speed,
        wall_time=100.0,
    )
    assert found.success, found.message
    borne = master.steady_state(WIDE).force + damping * speed
    assert np.abs(found.force - borne).max() <= 2.0 * tolerance


@pytest.mark.parametrize("ratio", [slow(0.1), 0.4, 1.0])
def test_contacts_far_stiffer_than_the_machine_are_followed_through_the_slip(ratio: float) -> None:
    """0.1 kg on 50 N/m over contacts of 2.5e9 N/m, as those of MD samples: the first step behind F_s is 7,000 times the
    time of a swing on the contacts. The force then falls by (F_s - F_k) (1 + e), e = exp[-πζ/(1 - ζ²)^(1/2)]."""
    contacts = origins.Contacts(origins.gaussian(1.0, 0.35))
    spring, mass, speed = 2e-8, 4e-11, 4500.0
    damping = 2.0 * ratio * (spring * mass) ** 0.5
    kinetic = master.steady_state(contacts, velocity=speed).force
    static = kinetic * master.propensity(contacts, velocity=speed).static_to_kinetic
    found = master.solve(
        contacts,
        [static / spring, 3.0 * static / spring],
        1e-4,
        spring=spring,
        mass=mass,
        damping=damping,
        velocity=speed,
        wall_time=60.0,
    )
    assert found.success, found.message
    swing = np.exp(-np.pi * ratio / (1.0 - ratio**2) ** 0.5) if ratio < 1.0 else 0.0
    lowest = kinetic - (static - kinetic) * swing + damping * speed * (ratio == 1.0)
    np.testing.assert_allclose(found.slips.force_before, [static], atol=1e-5)
    np.testing.assert_allclose(found.slips.force_after, [lowest], atol=1e-4)
    assert found.force[-1] == pytest.approx(kinetic + damping * speed, abs=1e-4)


@pytest.mark.slow
def test_on_a_soft_spring_light_damping_takes_little_of_the_drop_in_both_solvers() -> None:
    """With γ = 1e-2 (K M)^(1/2), ζ = 0.005, the drop is (F_s - F_k) (1 + e^(-πζ)): by 0.8 % below 2 (F_s - F_k)."""
    spring, mass = 1e-3, 1e-2
    machine = {"spring": spring, "mass": mass, "damping": 1e-2 * (spring * mass) ** 0.5}
    kinetic, closed = master.steady_state(WIDE).force, 0.5 * (1.0 + np.exp(-0.005 * np.pi))
    for slips in (
        master.solve(WIDE, [712.0], 1e-4, **machine).slips,
        eq_model.simulate(WIDE, [720.0], n_contacts=4000, n_replicas=4, seed=1, **machine).slips,
    ):
        falls = slips.drop / (2.0 * (slips.force_before - kinetic))
        np.testing.assert_allclose(falls, closed, atol=2e-3)
        half = np.pi * (mass / spring) ** 0.5
        np.testing.assert_allclose(slips.duration / half, 1.0, atol=0.01)


@pytest.mark.parametrize(
    "contacts",
    [WIDE, STRETCHED],
    ids=["wide", "stretched"],
)
@pytest.mark.slow
def test_a_light_damped_slider_slips_as_contacts_that_re_form_at_once(
    contacts: origins.Contacts,
) -> None:
    """M -> 0: "instant"; what is left is proportional to the damping."""
    path = np.linspace(1.0, 3.5, 26)
    limit = master.solve(contacts, path, 1e-9, spring=0.4, slip="instant")
    off = list[float]()
    for damping in (1e-2, 1e-3):
        light = {"spring": 0.4, "mass": damping**2, "damping": damping}
        found = master.solve(contacts, path, 1e-7, **light)
        off.append(np.sort(np.abs(found.force - limit.force))[-4])
        assert found.success, found.message
        assert found.slips.drive.size
    assert off[1] < 0.3 * off[0] < 0.02


@pytest.mark.parametrize("damping", [0.0, 0.05])
def test_energy_is_kept_and_breaks_only_release(damping: float) -> None:
    path = np.linspace(0.1, 8.0, 80)
    found = master.solve(WIDE, path, 1e-7, spring=0.3, mass=0.3, damping=damping)
    energy = found.energy
    assert found.success, found.message
    assert np.abs(energy.missing).max() < 1e-6 * energy.drive[-1]
    assert np.diff(energy.released).min() > -1e-7 and (np.diff(energy.damped) >= 0.0).all()
    assert (energy.damped[-1] > 0.01) == (damping > 0.0)


def test_a_swing_that_has_faded_to_what_counts_as_rest_is_at_rest() -> None:
    """By rounding it may be larger by a last digit: the same motion then began again without end."""
    path, keywords = np.linspace(0.0, 22.0, 23), {"mass": 0.1, "damping": 0.05, "velocity": 0.3}
    found = master.solve(NARROW, path, 1e-4, spring=0.05, wall_time=60.0, **keywords)
    assert found.success, found.message
    count, replicas = 8_000, 16
    drawn = eq_model.simulate(
        NARROW, path, spring=0.05, n_contacts=count, n_replicas=replicas, seed=2, **keywords
    ).slips
    first = [np.flatnonzero(drawn.replica == each)[0] for each in range(replicas)]
    late = count ** (-2.0 / 3.0) / 0.05  # finite numbers of contacts slip later by less than this
    for name, bias in ("drive", late), ("force_before", 0.0), ("top_speed", 0.0):
        values, known = getattr(drawn, name)[first], getattr(found.slips, name)[0]
        error = values.std(ddof=1) / replicas**0.5
        assert abs(values.mean() - known) < 4.0 * error + bias, name


def test_identical_contacts_move_as_one() -> None:
    """All break together, so that any number of contacts is infinitely many."""
    contacts, path = origins.Contacts(origins.identical(1.0)), np.linspace(0.2, 6.0, 30)
    machine = {"spring": 0.5, "mass": 0.2, "damping": 0.3}
    found = master.solve(contacts, path, 1e-7, **machine)
    drawn = eq_model.simulate(contacts, path, n_contacts=100, **machine)
    assert found.success, found.message
    assert np.abs(found.position - drawn.position).max() < 1e-6
    assert np.abs(found.slips.drive - drawn.slips.drive).max() < 1e-6 and drawn.breaks > 200


@pytest.mark.parametrize("tolerance", [1e-2, 1e-5])
def test_a_lagging_slider_passes_an_exact_threshold_where_the_oscillator_does(
    tolerance: float,
) -> None:
    """Damping makes it lag behind its balance, which passes the threshold first: the contacts break when it comes."""
    spring, mass, damping, weak, share = 1.9933, 6.72e-4, 0.0366, 0.52, 0.3
    contacts = origins.Contacts(
        origins.mixture([origins.identical(1.0), origins.identical(weak)], [1.0 - share, share])
    )
    machine = {"spring": spring, "mass": mass, "damping": damping}
    found = master.solve(contacts, np.linspace(0.02, 1.0, 50), tolerance, **machine)
    stiff = 1.0 + spring
    # the slider lags by damping * speed / stiff as the first contacts break, and swings from there
    reaches = weak * stiff / spring + damping / stiff
    decay = damping / (2.0 * mass)
    turning, swing = (stiff / mass - decay**2) ** 0.5, share * weak / stiff
    top = swing * stiff / (mass * turning)

    def faster(t: float) -> float:
        """Than the drive, so long after the threshold."""
        return float(top * np.exp(-decay * t) * np.sin(turning * t) - (1.0 - spring / stiff))

    lasts = brentq(faster, 0.0, 0.5 / turning)
    drive = reaches + lasts
    part = np.cos(turning * lasts) + decay / turning * np.sin(turning * lasts)
    place = weak + lasts * spring / stiff + swing * (1.0 - np.exp(-decay * lasts) * part)
    assert found.success, found.message
    assert abs(found.slips.drive[0] - drive) < found.slips.drive_error
    assert abs(found.slips.force_before[0] - spring * (drive - place)) < found.force_error


@pytest.mark.slow  # quick: small falls behind exact thresholds beside others, below
@pytest.mark.parametrize("tolerance", [1e-2, 1e-3])
def test_an_exact_threshold_beside_a_width_is_passed_as_late_as_the_slider_lags(
    tolerance: float,
) -> None:
    """Runs with other tolerances that go on from the balance, and not from the slider, agree on what is false."""
    exact = origins.identical(1.0), origins.identical(0.52065141)
    contacts = origins.Contacts(
        origins.mixture([*exact, origins.gaussian(1.2, 0.2)], [0.3, 0.3, 0.4])
    )
    machine = {"spring": 1.9933, "mass": 6.72e-4, "damping": 0.0366}
    path = np.linspace(0.05, 1.6, 30)
    found, finer = (master.solve(contacts, path, asked, **machine) for asked in (tolerance, 1e-6))
    assert found.success and finer.success and found.slips.drive.size == finer.slips.drive.size
    assert np.abs(found.force - finer.force).max() < found.force_error + finer.force_error
    assert np.abs(found.slips.drive - finer.slips.drive).max() < found.slips.drive_error


def test_a_slip_begins_when_the_slider_gets_as_fast_as_its_drive_however_slowly() -> None:
    """Beside scipy's integrator on the force of a rigid slider: there the balance, which it follows, is ahead of it."""
    spring, mass, damping, velocity = 0.5, 0.03, 0.05, 0.036
    x = np.linspace(0.0, 1.2, 2401)
    force = make_interp_spline(x, master.solve(WIDE, x, 1e-11).force, 5)

    def moved(t: float, state: np.ndarray) -> list[float]:
        pull = spring * (velocity * t - state[0]) - force(state[0]) - damping * state[1]
        return [state[1], float(pull) / mass]

    def gets_fast(t: float, state: np.ndarray) -> float:
        return -1.0 if t < 1.5 / velocity else state[1] - velocity

    gets_fast.terminal = True  # type: ignore[attr-defined]
    times = [0.0, 2.4 / velocity]
    exact = solve_ivp(moved, times, [0.0, 0.0], "DOP853", events=gets_fast, rtol=1e-11, atol=1e-12)
    machine = {"spring": spring, "mass": mass, "damping": damping, "velocity": velocity}
    for tolerance in (1e-2, 1e-4):
        found = master.solve(WIDE, np.linspace(0.1, 2.4, 30), tolerance, **machine)
        assert found.success, found.message
        off = abs(found.slips.drive[0] - velocity * exact.t[-1])
        assert off < found.slips.drive_error


@pytest.mark.slow  # quick: the same beside scipy's integrator, above
def test_the_fourth_slip_begins_as_the_slider_and_not_its_balance_gets_fast() -> None:
    """It follows its drive slowly into the slip, by the same series in both runs."""
    laws = origins.identical(0.787691), origins.gaussian(0.907143, 0.162606)
    contacts = origins.Contacts(origins.mixture([*laws], [0.3758, 0.6242]))
    machine = {"spring": 0.2794, "mass": 1.04e-4, "damping": 0.0016056, "velocity": 0.0515}
    path = np.linspace(0.1, 11.2, 40)
    found, finer = (master.solve(contacts, path, asked, **machine) for asked in (1e-3, 1e-6))
    assert found.success and finer.success and found.slips.drive.size == finer.slips.drive.size == 4
    assert np.abs(found.slips.drive - finer.slips.drive).max() < found.slips.drive_error


@pytest.mark.parametrize("draws", [2, slow(24)])
def test_claims_hold_beside_far_finer_solutions(draws: int) -> None:
    """Seeded machines and laws: the error of a coarse solution is at most its claim."""
    draw = np.random.default_rng(7)
    failed = 0
    for _ in range(draws):
        contacts = (WIDE, NARROW, STRETCHED, ELASTIC)[draw.integers(4)]
        machine = {"spring": 10.0 ** draw.uniform(-1.5, 0.3), "mass": 10.0 ** draw.uniform(-3, 0)}
        machine["damping"] = machine["mass"] ** 0.5 * 10.0 ** draw.uniform(-1, 0.5)
        path = np.linspace(0.5, 4.0, 15) * contacts.mean_threshold
        coarse = master.solve(contacts, path, 1e-4, **machine)
        fine = master.solve(contacts, path, 1e-6, **machine)
        off = np.abs(coarse.force - fine.force).max() / contacts.mean_threshold
        failed += not coarse.success or off > coarse.force_error + fine.force_error
    assert failed == 0


def test_the_error_of_a_period_is_that_of_the_distances_in_it() -> None:
    """Of 4.0 from the second to the fourth slip, between which a small one lies; or that of both places."""
    begins, fall = np.array([1.0, 5.0, 5.5, 9.0]), np.array([0.9, 0.9, 0.01, 0.9])
    given = {"drive": begins, "before": begins, "after": begins, "force_before": fall}
    given |= {"force_after": 0.0 * fall, "time": begins, "duration": fall, "top_speed": fall}
    for spacing, known in ((0.1, 0.2), (0.3, 0.5), (np.inf, 0.5)):
        slips = SlipsInTime(**given, drive_error=0.25, spacing_error=spacing)
        assert slips.period == 4.0 and slips.period_error == known


def test_points_in_a_slip_are_known_no_better_than_when_it_begins() -> None:
    """Both runs agreed at points by chance, or in when slips begin, or had a slip on one side of a point that is on the
    other: claims were 4, 5 and 150 times too small."""
    begins, lasts, fall = np.array([1.0, 5.0]), np.array([0.4, 0.4]), np.array([0.9, 0.3])
    given = {"drive": begins, "before": begins, "after": begins, "force_before": fall}
    given |= {"force_after": 0.0 * fall, "duration": lasts, "top_speed": lasts, "drive_error": 0.0}
    ours, theirs, earlier = (SlipsInTime(**given, time=begins + off) for off in (0.0, 0.002, 0.102))
    assert times_apart(ours, theirs, theirs) == pytest.approx(0.002 * NEAR)
    assert times_apart(ours, theirs, earlier) == pytest.approx(0.1 / FALL)
    apart = times_apart(ours, theirs, theirs)
    in_one = 0.9 * 2.0 * apart[0] / 0.4
    for times, waits, off in (
        ([1.1], 0.0, in_one),
        ([1.0 - 0.9 * apart[0]], 0.0, in_one),
        ([0.9, 1.5, 5.3], 0.0, in_one / 3.0),
        ([0.9, 1.5], 0.0, 0.0),
        # while contacts are out the slider swings on, here at a quarter of the slip's top speed
        ([0.9, 1.5], 0.3, 0.25 * in_one),
    ):
        # also on a drive that goes down, where speeds are below 0
        for sign in (1.0, -1.0):
            record = SimpleNamespace(times=np.array(times), speed=np.full(len(times), 0.1 * sign))
            run: Any = SimpleNamespace(record=record, force=np.array(times), waits=waits)
            one = replace(ours, top_speed=sign * lasts)
            assert Run.unknown_fall(run, one, apart) == pytest.approx(off)
    # the contacts' force, by so much before a slip and behind its begin
    for time, off in ((1.0 + 0.9 * apart[0], 0.9), (1.0 + 1.1 * apart[0], 0.0)):
        run = SimpleNamespace(record=SimpleNamespace(times=np.array([time])), force=np.ones(1))
        assert Run.unknown_hold(run, ours, apart) == off


def test_linked_stiffness_beside_a_mass_is_refused_in_one_line() -> None:
    contacts = origins.Contacts(origins.gaussian(1.0, 0.2), stiffness="linked")
    with pytest.raises(InputError, match=r"^mass = 1.0: .*eq_model\.simulate") as refused:
        master.solve(contacts, [1.0], spring=0.5, mass=1.0)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("kind", ["soft", slow("stiff")])
def test_heat_of_high_barriers_is_left_out_and_bounded(kind: str) -> None:
    """At some 1e5 k_BT; on a rigid slider, where heat is solved, the bound holds with much to spare."""
    heat = origins.Thermal(kind, temperature=5e-7, attempt_frequency=1e6)
    hot = origins.Contacts(origins.gaussian(1.0, 0.2), thermal=heat)
    path, machine = np.linspace(0.1, 5.0, 50), {"spring": 0.3, "mass": 0.3, "damping": 0.3}
    found, cold = (master.solve(one, path, 1e-6, **machine) for one in (hot, WIDE))
    bound = found.force_error - cold.force_error
    assert (found.force == cold.force).all() and 0.0 < bound < 0.1 and not found.success
    assert "heat is left out beside a mass" in found.message
    assert found.slips.drive_error == pytest.approx(cold.slips.drive_error + bound / 0.3, rel=1e-6)
    rigid, without = (master.solve(one, np.linspace(0.1, 1.5, 29), 1e-7) for one in (hot, WIDE))
    assert 0.0 < np.abs(rigid.force - without.force).max() < bound


@pytest.mark.parametrize("damping", [0.01, 10.0])
def test_a_closed_motion_that_lasts_no_time_is_watched(damping: float) -> None:
    """A turn far beyond critical damping may begin where the next contact breaks: this raised numpy's error."""

    class Watch:
        def watch(self, times: np.ndarray) -> None:
            assert (times == 0.0).all() and times.size

        def forget_fall(self) -> None:
            raise AssertionError

    motion = Oscillation.of(0.02, damping, 1.0, 0.5, 1e-3, 0.4, 0.0)
    assert motion.swings == (damping < 1.0)
    watch_closed(Watch(), motion, 0.0, lambda times: times)  # type: ignore[arg-type, return-value]


def test_endless_ringing_says_so() -> None:
    found = master.solve(
        WIDE, np.linspace(0.0, 1600.0, 17), 1e-6, spring=1e-3, mass=1e-4, wall_time=0.5
    )
    assert not found.success and ("rings" in found.message or "wall_time" in found.message)
    assert found.path.size < 17 and np.isfinite(found.force).all()


@pytest.mark.parametrize("damping", [0.0, 1e-19])
def test_a_billion_oscillations_after_a_slip_are_refused_before_the_work(damping: float) -> None:
    """Of 2π (M/(1 + K))^(1/2) each; a path that ends before the slip, and one whose ringing fades, are followed."""
    light = {"spring": 1e-3, "mass": 1e-16, "damping": damping}
    # not a hundredth of the critical damping of one that sticks, 2e-10: a third of that of the mass on its spring
    told = r"^mass = 1e-16: after a slip the slider rings 1\.4e\+10 times, .*give a damping \(.*6\.32e-11\)"
    with pytest.raises(InputError, match=told):
        master.solve(WIDE, [500.0, 1600.0], 1e-3, **light)
    assert master.solve(WIDE, [500.0], 1e-3, **light).success
    fades = origins.Drive([500.0, 1600.0], **(light | {"damping": 6.32e-11}))
    refuse_long_ringing(WIDE, fades)


def test_the_error_of_durations_bounds_it_and_is_not_known_of_a_slip_that_fades() -> None:
    """Beside a solution to a hundredth of the tolerance. Beyond critical damping, on contacts that form again at once,
    the speed of a slip falls to that of the drive as e^(-t/τ), and all but a thousandth of its fall is its end."""
    swings = {"spring": 0.1, "mass": 0.1, "damping": 0.02}
    found, finer = (
        master.solve(WIDE, [15.0], tolerance, **swings).slips for tolerance in (1e-4, 1e-6)
    )
    assert found.duration.size == finer.duration.size > 0
    off = float(np.abs(found.duration - finer.duration).max())
    assert off < found.duration_error < 0.01 * found.duration.min()
    narrower = origins.Contacts(origins.gaussian(1.0, 0.135))
    fades = {"spring": 0.0314, "mass": 0.00877, "damping": 0.11}
    found, finer = (master.solve(narrower, [80.0], tol, **fades).slips for tol in (1e-3, 1e-5))
    assert found.duration.size == 1 and abs(finer.duration[0] / found.duration[0] - 1.0) < 0.01
    assert np.isinf([found.duration_error, finer.duration_error]).all()


def test_a_small_slip_that_fades_is_told_whatever_the_tolerance() -> None:
    """Its force falls by 0.03, and by a last 0.014 so slowly that it goes on to the end of the path: 1e5 contacts have
    it, too. It was told where rounding ended it."""
    contacts = origins.Contacts(origins.gaussian(1.0, 0.25))
    machine = {"spring": 0.08, "mass": 0.025, "damping": 0.4, "velocity": 0.4}
    for tolerance in (1e-3, 1e-4):
        found = master.solve(contacts, np.linspace(0.0, 50.0, 401)[1:], tolerance, **machine)
        slips = found.slips
        told = [slips.drive, slips.force_before, slips.force_after, slips.duration]
        assert np.abs(np.ravel(told) - [10.12396, 0.72371, 0.69128, 34.127]).max() < 0.02
        assert abs(found.force[-1] - slips.force_after[0]) < 1e-4


def test_without_mass_and_damping_a_slider_above_the_critical_spring_falls_as_its_balance() -> None:
    """Where "instant" has no slip: K* = -F' at the steepest, so that the slider is K/(K - K*) times as fast there."""
    contacts, spring = origins.Contacts(origins.gaussian(1.0, 0.3)), 0.5
    critical = master.propensity(contacts).critical_spring
    machine = {"spring": spring, "mass": 1e-13, "damping": 1e-5}
    slips = master.solve(contacts, [4.0], 1e-3, **machine).slips
    assert slips.drive.size == 1 and abs(slips.drop[0] - 0.1535) < 1e-3
    assert abs(slips.top_speed[0] * (spring - critical) / spring - 1.0) < 2e-3
    assert not master.solve(contacts, [4.0], 1e-3, spring=spring, slip="instant").slips.drive.size


@pytest.mark.parametrize("ratio", [1.0, 4.0])
def test_a_free_slider_beyond_critical_damping_ends_its_slip_a_thousandth_before(ratio) -> None:
    """Of contacts that all wait, by the two exponentials from rest: what is left of the fall is 1e-3 of it. The slider
    takes two periods on its contacts, 4π, to let go."""
    contacts = origins.Contacts(origins.gaussian(1.0, 0.02), delay=origins.Delay(1e6))
    spring, mass, velocity = 1e-3, 1.0, 1e-4
    machine = {"spring": spring, "mass": mass, "velocity": velocity}
    own = (spring / mass) ** 0.5
    slips = master.solve(
        contacts, [1500.0], 1e-3, damping=2.0 * ratio * (spring * mass) ** 0.5, **machine
    ).slips
    beat = own * (ratio**2 - 1.0) ** 0.5
    slow, fast = ratio * own - beat, ratio * own + beat

    def rest(t: float) -> float:
        if ratio == 1.0:
            return (1.0 + own * t) * np.exp(-own * t) - LOWER
        return (fast * np.exp(-slow * t) - slow * np.exp(-fast * t)) / (fast - slow) - LOWER

    by_hand = brentq(rest, 0.0, 1e3 * ratio / own)
    assert slips.duration.size == 1 and 0.0 < slips.duration[0] - by_hand < 15.0


@pytest.mark.parametrize("tolerance", [5e-4, slow(1e-4)])
def test_a_slider_that_lags_behind_its_balance_goes_on(tolerance: float) -> None:
    """Just before a first slip: the balance has passed the end of the slow way, to which it was led back, for ever."""
    mass, spring = 0.1, 1e-3
    machine = {"mass": mass, "spring": spring, "damping": 0.8 * (spring * mass) ** 0.5}
    path, velocity = np.linspace(0.1, 1.4, 40) / spring, 0.3 * (spring / mass) ** 0.5
    found = master.solve(WIDE, path, tolerance, velocity=velocity, wall_time=60.0, **machine)
    finer = master.solve(WIDE, path, 1e-5, velocity=velocity, wall_time=60.0, **machine)
    assert found.success, found.message
    assert np.abs(found.force - finer.force).max() < found.force_error + finer.force_error


def test_a_slider_that_would_ring_without_end_is_refused_or_stopped_and_never_hangs() -> None:
    """1e20 oscillations, of which time has too few digits for one: `wall_time` did not end them. A path that ends
    behind the first slip is refused before the work, wherever it ends; before it the slider is at rest."""
    contacts = origins.Contacts(origins.gaussian(1.0, 0.2))
    machine = {"spring": 1e-9, "mass": 1e-22, "wall_time": 60.0}
    for end in (7e8, 1e9):
        with pytest.raises(InputError, match=r"the slider rings .*e\+1[78] times"):
            master.solve(contacts, [end], 1e-3, **machine)
    found = master.solve(contacts, [3e8, 6e8], 1e-3, **machine)
    assert found.success, found.message
    limit = master.solve(contacts, [3e8, 6e8], 1e-6, spring=1e-9)
    assert np.abs(found.force - limit.force).max() < found.force_error + limit.force_error
    near = Oscillation.of(1.0, 0.0, 1.0, 0.0, 1e-20, 1.0 - 1e-3, 0.0)
    with pytest.raises(StoppedError, match="rings for too long"):
        near.first_passing(-5.0, 1.0, 1e18)


def test_small_falls_behind_exact_thresholds_beside_others_are_not_passed_over() -> None:
    """They form again at ever new places. At 1e-3 the force after the third slip was told as 0.61614 ± 1e-5."""
    law = origins.mixture(
        [origins.identical(1.1741), stats.uniform(0.63041, 1.23493)], [0.2623, 0.7377]
    )
    given = {"spring": 0.56746, "mass": 7.61797e-4, "damping": 2.3037e-3, "velocity": 0.0392088}
    path = np.linspace(0.0702, 4.2124, 60)
    found = master.solve(origins.Contacts(law), path, 1e-3, **given)
    assert found.success and found.slips.force_error < 1e-4
    # those of a tolerance of 1e-6, which tells them to 3e-7
    finer = [0.8811256, 0.7308797, 0.6639803], [0.3865926, 0.6018410, 0.6155195]
    for told, known in zip((found.slips.force_before, found.slips.force_after), finer, strict=True):
        assert np.abs(told - known).max() < found.slips.force_error * law.mean()


def test_runs_do_not_share_where_slow_motion_ends_before_a_slip() -> None:
    """A slip of 28 thresholds began 1.6e-4 thresholds of the drive late where slow motion went on for too long, in runs
    at 2e-2 to 8e-4 alike: at 1e-2 points of the path in it were off by 2 and 14 times their claims."""
    machine = {"spring": 0.03479, "mass": 1.028e-4, "damping": 2.033e-3, "velocity": 3.032}
    contacts, path = origins.Contacts(origins.persson(1.0, 0.2009)), np.linspace(0.3, 30.0, 93)
    found, finer = (master.solve(contacts, path, part, **machine) for part in (1e-2, 1e-4))
    unit = contacts.mean_threshold
    assert found.success and found.slips.drive.size == 1
    for force, claims in (
        ("force", found.force_error + finer.force_error),
        ("contact_force", found.contact_force_error + finer.contact_force_error),
    ):
        off = np.abs(getattr(found, force) - getattr(finer, force)).max() / unit
        assert off < 0.5 * claims


@pytest.mark.parametrize(
    ("damping", "velocity"), [(4.47e-2, 1.1e-4), slow(4.47e-3, 1.1e-3), slow(4.47e-3, 1.1e-2)]
)
def test_a_heavily_damped_slider_on_a_slow_drive_tends_to_one_without_mass(
    damping: float, velocity: float
) -> None:
    """Its speed relaxes within 1e-9 to 1e-6 of the way's time. It was said to ring for too long, or took half a minute:
    its modes of motion alternated, and steps resolved that time. Its slips begin late by what damping lets it lag."""
    contacts, tolerance = origins.Contacts(origins.gaussian(1.0, 0.2)), 1e-4
    machine = {"spring": 0.05, "mass": 1e-6, "damping": damping, "velocity": velocity}
    found = master.solve(contacts, [8.0, 14.0, 16.0], tolerance, **machine)
    assert found.success, found.message
    off, slips = found.force_error + damping * velocity, found.slips
    limit = master.solve(contacts, [8.0, 14.0, 16.0], 1e-6, spring=0.05, slip="instant")
    assert np.abs(found.force - limit.force).max() < off
    # it slips from the largest force on, where it gets as fast as its drive; "instant", where F' = -K just behind
    highest = master.solve(contacts, np.linspace(0.7, 0.9, 401), 1e-7).force.max()
    assert slips.drive.size == 1 and abs(slips.force_before[0] - highest) < off
    assert 0.0 < limit.slips.drive[0] - slips.drive[0] < 5e-3
    # it ends where the limit's second slip does, as the force rises by less than 0.02 between the two, but for what the
    # drive pulls in the time of that second one, g/K and more
    assert limit.slips.drive.size == 2
    lasts = float(slips.duration[0] - (limit.slips.drive[1] - slips.drive[0]) / velocity)
    assert 0.0 < slips.force_after[0] - limit.slips.force_after[1] < off + 0.05 * velocity * lasts


def test_a_heavily_damped_slider_lags_where_contacts_begin_to_break_together() -> None:
    """Behind a hold and a way back F' jumps, and what the slider lags behind with it: at all tolerances but the finest
    it was put on its new slow motion at once, off by 1.1e-3 where 5e-5 was told."""
    contacts = origins.Contacts(origins.lubricated(1.0))
    machine = {"spring": 2.58, "mass": 6.8e-5, "damping": 0.85}
    path, time = [2.648, 2.648, 1.795, 2.659], [70.0, 1000.0, 1070.0, 1114.0]
    found = master.solve(contacts, path, 1e-3, time=time, **machine)
    error = found.force_error * contacts.mean_threshold
    # to 1e-6, and by implicit steps all along
    assert found.success and found.force[-1] == pytest.approx(0.7614411, abs=error)


def test_a_heavily_damped_slider_far_behind_its_drive_is_not_taken_for_slow() -> None:
    """The force on its mass is nothing, and it is behind its slow motion by γ times what it is faster by. It was put
    there at once: at the second point 2.04 was told, to 6e-4, where 2.008 is true, and 2.0066 of 2e4 contacts."""
    contacts = origins.Contacts(stats.gamma(2.4791803))
    machine = {"spring": 0.01123, "mass": 3.533e-8, "damping": 0.03817, "velocity": 7.835}
    path = np.array([196.0, 220.5])
    coarse, fine = (master.solve(contacts, path, tol, **machine) for tol in (1.2e-3, 1.2e-4))
    off = np.abs(coarse.force - fine.force)
    assert coarse.success and off.max() < coarse.force_error * contacts.mean_threshold
    assert fine.force[1] == pytest.approx(2.0080, abs=1e-3)


@pytest.mark.parametrize(("damping", "why"), [(4e-2, "leave mass and"), (1e-3, "a larger one")])
def test_what_takes_too_many_steps_is_told_by_its_damping(
    damping: float, why: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Above the critical one, 2e-3, nothing rings, and no larger damping helps."""
    monkeypatch.setattr("master.soft.inertia.moving.MOST_STEPS", 20)
    machine = {"spring": 0.05, "mass": 1e-6, "damping": damping, "velocity": 1e-3}
    found = master.solve(origins.Contacts(origins.gaussian(1.0, 0.2)), [16.0], 1e-3, **machine)
    assert not found.success and why in found.message
    assert ("rings" in found.message) == (damping < 2e-3)
