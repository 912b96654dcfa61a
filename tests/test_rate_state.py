"""a, b and D_c: of the law itself, of contacts whose slope is known, of single contacts; critical springs; the page."""

import csv
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import slow
from matplotlib.image import imread
from scipy import integrate, optimize, stats

import eq_model
import master
from master.rate_state.critical_spring import critical_spring_of
from master.rate_state.law import EvolutionLaw, RateStateLaw, remaining_of_step
from master.rate_state.reading import Reading, read_steps
from master.rate_state.rests import healing_of, rest_of
from master.rate_state.traces import Rest, VelocityStep, steps_about
from origins import Ageing, Contacts, Delay, InputError, Thermal, gaussian, strengthening
from tests.scenes import ROUGH, refused, said, write
from toolkit.processes.signals import Terminated, TimeIsUp
from toolkit.rate_state.judge import Judged
from toolkit.rate_state.report import WORK
from toolkit.rate_state.words import page
from toolkit.running import solvers
from toolkit.running.progress import Progress
from toolkit.scene.scale import Scale
from toolkit.scene.scene import load_scene

WIDE = gaussian(1.0, 0.2)
ALPHA = 0.03
EYRING = Contacts(WIDE, thermal=Thermal("eyring", width=ALPHA))
SLIP = np.r_[0.0, np.geomspace(1e-7, 8.0, 240)]
LAWS: tuple[EvolutionLaw, ...] = ("slip", "ageing")


def steps_of(law: RateStateLaw, ratio: float) -> tuple[VelocityStep, VelocityStep]:
    """What solved answers would be if contacts followed the law, by its integration."""
    slow, fast = law.velocity * ratio**-0.5, law.velocity * ratio**0.5

    def steady(speed: float) -> float:
        return law.kinetic_force + (law.a - law.b) * float(np.log(speed / law.velocity))

    def step(before: float, after: float) -> VelocityStep:
        force = law.step(SLIP, before, after)
        return VelocityStep(before, after, steady(before), steady(after), SLIP, force, 1e-9, True)

    return step(slow, fast), step(fast, slow)


@pytest.mark.parametrize("evolution", LAWS)
@pytest.mark.parametrize(("a", "b"), [(0.03, 0.05), (0.05, 0.02), (0.0, 0.03)])
def test_the_law_gives_back_its_own_numbers(evolution: EvolutionLaw, a: float, b: float) -> None:
    law = RateStateLaw(0.5, 2.0, a, b, 0.21, evolution)
    found = read_steps(steps_of(law, 10.0), evolution)
    assert found.a == pytest.approx(a, abs=1e-7) and found.b == pytest.approx(b, abs=1e-7)
    assert found.slip_distance == pytest.approx(0.21, rel=1e-6)
    assert found.direct_slip == 0.0
    assert found.others[:, 2] == pytest.approx(0.21, rel=0.01)  # the slips of the fall, too


def test_readings_do_not_depend_on_where_the_answer_is_known() -> None:
    """An answer that rises over a slip of 0.05 and falls over 0.2: the other readings, too, are those of 40 times as
    many points."""

    def read(points: int) -> Reading:
        slip = np.union1d(np.geomspace(1e-7, 8.0, points), np.linspace(0.0, 8.0, 5 * points // 2))
        steps = list[VelocityStep]()
        for way, rise in ((1.0, 0.05), (-1.0, 0.03)):
            answer = 0.02 * np.expm1(-((slip / 0.2) ** 1.3)) - 0.03 * np.expm1(-slip / rise)
            ends = float(np.exp(-0.5 * way)), float(np.exp(0.5 * way))
            steady = 1.0 - 0.005 * way, 1.0 + 0.005 * way
            force = 1.0 + way * (answer - 0.005)
            steps.append(VelocityStep(*ends, *steady, slip, force, 1e-9, True))
        return read_steps(steps, "slip")

    assert read(160).others == pytest.approx(read(6400).others, rel=3e-3)


@pytest.mark.parametrize("evolution", LAWS)
def test_the_integrated_law_is_the_closed_one(evolution: EvolutionLaw) -> None:
    law = RateStateLaw(0.5, 2.0, 0.03, 0.05, 0.21, evolution)
    for before, after in ((0.1, 5.0), (5.0, 0.1)):
        closed = remaining_of_step(SLIP, 0.21, after / before, evolution)
        steady = 0.5 + (law.a - law.b) * np.log(after / law.velocity)
        assert law.step(SLIP, before, after) == pytest.approx(steady + law.b * closed, abs=1e-8)
    rests = np.geomspace(0.01, 1e6, 5)
    rise = 0.05 * np.log1p(2.0 * rests / 0.21) if evolution == "ageing" else 0.0 * rests
    assert law.after_rest(rests) == pytest.approx(0.5 + rise, abs=1e-8)


@pytest.fixture(scope="module")
def heated() -> master.RateState:
    """Heat alone, at one speed."""
    return master.rate_state(EYRING, 1e-3, decades=0, tolerance=1e-4)


@pytest.mark.slow
def test_heat_alone_gives_its_slope_and_single_contacts_their_direct_effect(
    heated: master.RateState,
) -> None:
    """a - b = α F_k(∞) within 0.5 %; a by the ensemble."""
    high = WIDE.moment(2) / (2.0 * WIDE.mean())
    assert heated.success, heated.message
    assert heated.a_minus_b.value == pytest.approx(ALPHA * high, rel=5e-3)
    assert heated.a.value - heated.b.value == pytest.approx(heated.a_minus_b.value, abs=1e-5)
    up = heated.steps[0]
    path = np.r_[0.0, 12.0 + np.r_[0.0, heated.direct_slip]]
    arrival = np.r_[0.0, 12.0, 12.0 + heated.direct_slip * up.before / up.after] / up.before
    given: dict[str, Any] = {"n_contacts": 200_000, "n_replicas": 1, "seed": 1}
    run = eq_model.simulate(EYRING, path, time=arrival, **given)
    rise = (run.force[-1] - up.steady_before) / up.log_ratio
    error = run.force_standard_error[-1] / up.log_ratio
    assert error < 0.04 * heated.a.value and abs(rise - heated.a.value) < 4.0 * error


@pytest.mark.slow
def test_the_error_of_a_step_holds_what_is_left_of_the_start(heated: master.RateState) -> None:
    """It goes up and down with the slip, and may pass 0 where the step is: forces of contacts that slid three times as
    long, to a hundredth of the tolerance, are within it."""
    up = heated.steps[0]
    places = np.array([0.0, 0.1, 0.258, 0.5, 1.0, 2.0])
    arrival = np.r_[0.0, 30.0 / up.before + places / up.after]
    exact = master.solve(EYRING, np.r_[0.0, 30.0 + places], 1e-6, time=arrival).force[1:]
    kept = np.interp(places, up.slip, up.force)
    assert np.abs(kept - exact).max() < up.error < 3e-4


@pytest.mark.slow
def test_the_slope_of_heat_is_constant_over_decades_of_speed() -> None:
    """a - b = α F_k(∞) within 0.5 % over two decades of v/(ωα<x_s>) from 1e-4."""
    high = WIDE.moment(2) / (2.0 * WIDE.mean())
    found = master.rate_state(EYRING, 1e-3 * ALPHA, decades=1)
    assert found.success, found.message
    for number in (found.a, found.b, found.a_minus_b):
        assert number.low <= 1e-4 * ALPHA * 1.0001 and number.high >= 1e-2 * ALPHA * 0.9999
    assert np.abs(found.scan.a_minus_b / (ALPHA * high) - 1.0).max() < 5e-3


@pytest.mark.slow
def test_a_smaller_step_gives_the_same_numbers(heated: master.RateState) -> None:
    """The law has no scale of the step: numbers per factor e differ by less than their own differences up and down."""
    large = read_steps(heated.steps, "slip")
    small = read_steps(steps_about(EYRING, 1e-3, 1.2, 1e-5), "slip")
    apart = np.abs(large.others[:3, 0] - large.a).max()
    assert abs(large.a - small.a) < 2.0 * apart + large.a_error + small.a_error
    assert large.slip_distance == pytest.approx(small.slip_distance, rel=0.01)


def test_healing_of_a_logarithm_is_its_slope() -> None:
    times = np.geomspace(1e-3, 1e6, 10)
    rests = [Rest(t, 0.1, 1.0 + 0.02 * np.log1p(t), 0.3, 1e-6, True) for t in times]
    healing = healing_of(rests)
    assert healing is not None and healing_of(rests[:2]) is None
    assert healing.value == pytest.approx(0.02 * np.log(10.0), rel=0.02)
    assert healing.low <= 10.0 and healing.high == pytest.approx(1e6)


@pytest.mark.parametrize(("a", "b"), [(0.01, 0.05), (0.05, 0.03)])
def test_the_critical_spring_of_the_law_follows_from_its_answer(a: float, b: float) -> None:
    law = RateStateLaw(0.5, 1.0, a, b, 0.2)
    spring = critical_spring_of(steps_of(law, 1.001), 1.0)
    assert spring.value == pytest.approx(max(b - a, 0.0) / 0.2, rel=1e-3, abs=1e-12)
    assert abs(spring.value - max(b - a, 0.0) / 0.2) <= spring.error + 1e-12


@pytest.mark.parametrize("ratio", [1.3, slow(np.e**0.5)])
def test_the_error_of_the_critical_spring_holds_what_large_steps_leave_out(ratio: float) -> None:
    """By the ageing law the answer is not in proportion to the step: steps that are not small give another spring than
    (b - a)/D_c, and those twice as large beside them tell most of that."""
    law = RateStateLaw(0.5, 1.0, 0.01, 0.05, 0.2, "ageing")
    exact = (law.b - law.a) / law.slip_distance
    alone = critical_spring_of(steps_of(law, ratio), 1.0)
    found = critical_spring_of(steps_of(law, ratio), 1.0, steps_of(law, ratio**2))
    assert 1e-3 * exact < abs(alone.value - exact) < alone.error
    assert abs(found.value - exact) < min(found.error, 0.2 * abs(alone.value - exact))
    assert found.error < 4.0 * abs(alone.value - exact)


@pytest.mark.parametrize("laws", [4, slow(64)])
def test_the_critical_spring_of_drawn_laws_is_within_its_error_in_noise_too(laws: int) -> None:
    """Laws that evolve with slip or age, by steps of 5 to 80 %: noise that is even as large as is told, that swings,
    and that tilts the answer."""
    rng, held, tight = np.random.default_rng(3), list[bool](), list[float]()
    for number in range(laws):
        b, slip_distance, noise = (
            rng.uniform(0.01, 0.1),
            rng.uniform(0.1, 0.4),
            10.0 ** rng.uniform(-7, -4),
        )
        law = RateStateLaw(0.5, 1.0, b * rng.uniform(0.0, 0.8), b, slip_distance, LAWS[number % 2])
        ratio = rng.uniform(1.05, 1.8)
        swing = rng.uniform(-1.0, 1.0) * np.cos(
            rng.uniform(0.5, 20.0) * SLIP + rng.uniform(0.0, 6.0)
        )
        tilt = rng.uniform(-1.0, 1.0) * np.exp(-SLIP / rng.uniform(0.1, 3.0))
        both = [
            [
                replace(one, force=one.force + 0.5 * noise * (swing + tilt), error=noise)
                for one in steps
            ]
            for steps in (steps_of(law, ratio), steps_of(law, ratio**2))
        ]
        found = critical_spring_of(both[0], 1.0, both[1])
        exact = (law.b - law.a) / slip_distance
        held.append(abs(found.value - exact) <= found.error)
        tight.append(found.error / exact)
    assert np.mean(held) >= 0.99 and np.median(tight) < 0.1


# their force falls with the speed, as more contacts are out
DELAYED = Contacts(WIDE, delay=Delay(0.1))


@pytest.fixture(scope="module")
def delayed() -> master.RateState:
    """A delay alone."""
    return master.rate_state(DELAYED, 1.0, decades=0)


def test_a_delay_has_no_direct_effect(delayed: master.RateState) -> None:
    """F_k = F_0 C/(C + v τ), so that a - b is its slope; the force does not rise after a step up."""
    found = delayed
    cycle, force = WIDE.mean(), WIDE.moment(2) / (2.0 * WIDE.mean())
    slope = -force * cycle * 0.1 / (cycle + 0.1) ** 2
    assert found.success and found.a.value == 0.0 and found.direct_slip == 0.0
    assert found.a_minus_b.value == pytest.approx(slope, abs=found.a_minus_b.error + 1e-9)
    assert found.a_minus_b.error < 0.01 * abs(slope)
    # without a direct effect the law does not jump at the step, and ends at the steady force
    for one, law in zip(found.steps, found.law_steps, strict=True):
        assert law[0] == pytest.approx(one.steady_before, abs=1e-9)
        assert law[-1] == pytest.approx(one.steady_after, abs=1e-9)
    assert found.a.low == found.a.high == 1.0


BETA = 0.03
STRENGTHENED: dict[str, Any] = {"thresholds": {"kind": "gaussian", "mean": 1.0, "std": 0.2}}
STRENGTHENED |= {"strengthening": {"beta": BETA, "time": 1e-3}}
STRONGER = strengthening(WIDE, beta=BETA, time=1e-3)


def test_strengthening_has_no_direct_effect() -> None:
    """a is 0, and b some β of the force of fresh contacts: F_k grows by g = 1 + β ln(age at a break), and that age by
    g, it is β/(1 - β/g) of it."""
    fresh = WIDE.moment(2) / (2.0 * WIDE.mean())
    found = master.rate_state(Contacts(STRONGER), 1.0, decades=0)
    assert found.success and found.a.value == 0.0
    exact = BETA * fresh / (1.0 - BETA * fresh / found.kinetic_force)
    assert found.b.value == pytest.approx(exact, rel=3e-3)
    assert found.a_minus_b.value == pytest.approx(-exact, rel=3e-3)
    # without a direct effect the critical spring is as steep as the force falls just after a small step
    x = np.linspace(0.0, 4.0, 4001)
    growth = 1.0 + BETA * np.log1p(x / 1e-3)
    lost = x**2 * WIDE.pdf(x / growth) * BETA / (1e-3 + x) / growth**2
    steepest = np.trapezoid(lost, x) / np.trapezoid(WIDE.sf(x / growth), x)
    off = abs(found.critical_spring_solved - steepest)
    assert off < found.critical_spring_solved_error < 0.1 * steepest


@pytest.mark.slow
def test_strengthening_heals() -> None:
    """The peak after a rest is that of single contacts, and grows by somewhat less than β for each factor e."""
    times = np.array([1e2, 1e3, 1e4])
    rests = [rest_of(Contacts(STRONGER), 1.0, time, 1e-4) for time in times]
    healing = healing_of(rests)
    rest = rests[1]
    path, arrival = np.r_[0.0, 12.0, 12.0], np.r_[0.0, 12.0, 12.0 + rest.time]
    path, arrival = np.r_[path, 12.0 + rest.peak_slip], np.r_[arrival, arrival[-1] + rest.peak_slip]
    given: dict[str, Any] = {"time": arrival, "n_contacts": 60_000, "n_replicas": 1, "seed": 1}
    run = eq_model.simulate(Contacts(STRONGER), path, **given)
    error = 5.0 * run.force_standard_error[-1]
    assert error < 0.01 and abs(run.force[-1] - rest.peak) < error + rest.error
    assert healing is not None and healing.low == 1e2 and healing.high == 1e4
    # each contact holds β ln t longer; those that are about to break bear the most, so that F grows by somewhat less
    assert 0.9 * BETA < healing.value / np.log(10.0) < BETA


@pytest.mark.slow
def test_the_error_of_a_peak_holds_what_lies_between_points() -> None:
    """After a rest of 100 s the force is largest at a slip of 0.0556, by points 2e-4 apart after 40 lives."""
    stronger = Contacts(strengthening(WIDE, beta=0.1, time=1.0))
    rest = rest_of(stronger, 1e-2, 100.0, 1e-4)
    assert rest.success and rest.peak_slip == pytest.approx(0.0556, abs=1e-3)
    assert abs(rest.peak - 0.8391263) < rest.error < 3e-4


@pytest.mark.slow
def test_much_stronger_contacts_travel_far() -> None:
    """Thresholds that grow ninefold are followed for lives of their own, not of fresh contacts."""
    up = steps_about(Contacts(strengthening(WIDE, 0.5, 1e-6)), 1.0, np.e, 1e-3)[0]
    assert up.settled and up.error < 1e-3 and up.slip[-1] > 72.0


@pytest.mark.slow
def test_heat_and_strengthening_together_are_followed_on_a_rigid_slider() -> None:
    """a and the force after the step are those of single contacts; so is the peak after a long rest."""
    contacts = Contacts(STRONGER, thermal=EYRING.thermal)
    found = master.rate_state(contacts, 1e-3, decades=0, rests=[1e5])
    assert found.success, found.message
    assert found.a.value > found.b.value > 0.5 * found.a.value
    up = found.steps[0]
    places = np.array([0.0, found.direct_slip, 1.0])
    path = np.r_[0.0, 24.0 + places]
    arrival = np.r_[0.0, 24.0 / up.before + places / up.after]
    given: dict[str, Any] = {"time": arrival, "n_contacts": 1_000_000, "n_replicas": 1, "seed": 1}
    run = eq_model.simulate(contacts, path, **given)
    force = np.interp(places, up.slip, up.force)
    error = 5.0 * run.force_standard_error[1:] + up.error
    assert (error < 0.2 * found.a.value).all()
    assert (np.abs(run.force[1:] - force) < error).all()
    rest = found.rests[0]
    path, arrival = np.r_[0.0, 12.0, 12.0], np.r_[0.0, 12.0, 12.0 + 1e-3 * rest.time]
    path, arrival = np.r_[path, 12.0 + rest.peak_slip], np.r_[arrival, arrival[-1] + rest.peak_slip]
    given |= {"time": arrival / 1e-3, "n_contacts": 100_000}
    run = eq_model.simulate(contacts, path, **given)
    error = 5.0 * run.force_standard_error[2:] + rest.error
    assert (np.abs(run.force[2:] - [rest.relaxed, rest.peak]) < error).all()


def slowly_to_one(spring: float, force: float, after: float) -> tuple[np.ndarray, np.ndarray]:
    """Places of the drive and their times: in balance at first, slowly to v = 1, and then so far at that speed. A start
    in which all contacts hold is none of steady sliding where some are out."""
    speeds = np.geomspace(0.02, 1.0, 40)
    drive = force / spring + np.r_[0.0, np.cumsum(np.full(40, 0.5))]
    times = np.r_[0.0, np.cumsum(0.5 / speeds)]
    swung = np.arange(0.02, after, 0.02)
    return np.r_[drive, drive[-1] + swung], 1e-9 + np.r_[times, times[-1] + swung]


def test_single_contacts_swing_below_the_critical_spring_of_the_solved_answer(
    delayed: master.RateState,
) -> None:
    """A slider of 40,000 contacts ends in full stick-slip on a spring 20 % softer, and in noise alone on one 20 %
    stiffer. Both are far stiffer than (b - a)/D_c, as the force of contacts with a delay is no exponential."""
    critical = delayed.critical_spring_solved
    assert delayed.critical_spring_solved_error < 0.05 * critical
    assert delayed.critical_spring < 0.5 * critical
    contacts, swings = DELAYED.replace(start=stats.uniform(0.0, 0.95)), list[float]()
    for spring in (0.8 * critical, 1.2 * critical):
        path, arrival = slowly_to_one(spring, 0.475, 50.0)
        given: dict[str, Any] = {"spring": spring, "slip": "instant", "time": arrival}
        run = eq_model.simulate(contacts, path, **given, n_contacts=40_000, n_replicas=1, seed=1)
        swings.append(float(np.std(run.force[-500:])))
    assert swings[0] > 0.15 and swings[1] < 0.01, swings


def stiffness_of_delayed(law: Any, delay: float, wave_number: float) -> complex:
    """-dF/dX of contacts with a delay (times v) for a small disturbance e^(iqX) of steady sliding, with the number
    conserved, by quadrature over the lives x."""
    x = np.linspace(0.0, law.isf(1e-12), 5001)
    held, broken, born = law.sf(x), law.pdf(x), 1.0 / (law.mean() + delay)
    wave, late = np.exp(-1j * wave_number * x), np.exp(-1j * wave_number * delay)
    lost = broken * (1.0 - wave) * born
    kept = 1j * wave_number * late * np.trapezoid(held * wave, x)
    breaks = np.trapezoid(lost, x) / (1.0 - late + kept)
    force = np.trapezoid(held * (1.0 - wave) * born - x * lost, x)
    return complex(-force - 1j * wave_number * breaks * late * np.trapezoid(x * held * wave, x))


@pytest.mark.slow  # some 40 s; quick: that of drawn laws, and of strengthening
def test_the_critical_spring_of_drawn_contacts_is_that_of_linear_stability() -> None:
    """24 with a delay, and 24 that strengthen, whose force falls at first as a quadrature says."""
    rng, off = np.random.default_rng(1), list[float]()
    for number in range(48):
        power, width = rng.uniform(2.0, 6.0), rng.uniform(0.15, 0.4)
        law = (gaussian(1.0, width), Contacts(stats.weibull_min(power)).thresholds)[number // 2 % 2]
        velocity, beta = float(np.exp(rng.uniform(-3.0, 3.0))), float(rng.uniform(0.01, 0.1))
        if number % 2:
            delay = float(np.exp(rng.uniform(np.log(0.01), np.log(0.25))))
            contacts = Contacts(law, delay=Delay(delay / velocity))
            waves = np.linspace(0.05, 30.0, 600)
            answer = [stiffness_of_delayed(law, delay, wave) for wave in waves]
            exact = 0.0
            for turn in np.flatnonzero(np.diff(np.sign(np.imag(answer)))):
                ends = waves[turn], waves[turn + 1]
                at = optimize.brentq(lambda q: stiffness_of_delayed(law, delay, q).imag, *ends)  # noqa: B023
                exact = max(exact, stiffness_of_delayed(law, delay, at).real)
        else:
            grown = float(10.0 ** rng.uniform(-5.0, -1.0))
            contacts = Contacts(strengthening(law, beta=beta, time=grown / velocity))
            x = np.r_[0.0, np.geomspace(1e-9, 15.0, 20_001)]
            growth = 1.0 + beta * np.log1p(x / grown)
            lost = x**2 * law.pdf(x / growth) * beta / (grown + x) / growth**2
            exact = np.trapezoid(lost, x) / np.trapezoid(law.sf(x / growth), x)
        found = master.rate_state(contacts, velocity, decades=0)
        assert found.critical_spring_solved_error < 0.05 * exact
        off.append(abs(found.critical_spring_solved - exact) / found.critical_spring_solved_error)
    assert max(off) < 1.0 and np.median(off) > 0.05, off


@pytest.mark.slow  # quick: that of strengthening, and of single contacts that swing
def test_the_critical_spring_of_contacts_in_step_is_that_of_linear_stability() -> None:
    """Where contacts of narrow thresholds break in step for long, small disturbances e^(iqX) of steady sliding, with
    the number conserved, neither grow nor decay on the spring (by quadrature over the lives x)."""
    law, delay = gaussian(1.0, 0.15), 0.1

    def stiffness(q: float) -> complex:
        return stiffness_of_delayed(law, delay, q)

    # of several wave numbers that neither grow nor decay on some spring this one does so on the stiffest
    wave_number = optimize.brentq(lambda q: stiffness(q).imag, 4.5, 5.8)
    exact = stiffness(wave_number).real
    found = master.rate_state(Contacts(law, delay=Delay(delay)), 1.0, decades=0)
    off = abs(found.critical_spring_solved - exact)
    assert found.success and off < found.critical_spring_solved_error < 0.01 * exact
    # those that still do at the end of the answer are not known to an error
    swings = master.rate_state(Contacts(gaussian(1.0, 0.1), delay=Delay(0.3)), decades=0)
    assert not swings.success and np.isnan(swings.critical_spring_solved)


@pytest.mark.slow
def test_the_master_equation_swings_below_the_same_spring() -> None:
    """Small swings grow on a spring 10 % softer than the critical one of the solved answer, and decay on one 10 %
    stiffer."""
    critical = master.rate_state(DELAYED, 1.0, decades=0).critical_spring_solved
    edges = np.linspace(0.0, 2.0, 201)
    steady = stats.rv_histogram((WIDE.sf(0.5 * (edges[1:] + edges[:-1])), edges), density=True)
    contacts = DELAYED.replace(start=steady)
    for spring, grows in ((0.9 * critical, True), (1.1 * critical, False)):
        path, arrival = slowly_to_one(spring, float(steady.mean()), 16.0)
        given: dict[str, Any] = {"spring": spring, "slip": "instant", "time": arrival}
        force = np.asarray(master.solve(contacts, path, 1e-3, **given).force)
        early, late = np.ptp(force[141:341]), np.ptp(force[641:841])
        assert late > 1.1 * early if grows else late < 0.9 * early, (spring, early, late)


# thresholds with S = exp(-x^5), heat and strengthening of which the latter prevails at v = 1
STEEP = 5.0
BOTH = Contacts(
    strengthening(Contacts(stats.weibull_min(STEEP)).thresholds, beta=0.1, time=1e-3),
    thermal=Thermal("eyring", width=0.01, attempt_frequency=1e3),
)


def stiffness_of_both(wave_number: float) -> complex:
    """-dF/dX of BOTH at v = 1 for a small disturbance e^(iqX) of steady sliding, with the number conserved, by
    quadrature over the lives x and over thresholds at birth ξ: of contacts born together those hold whose ξ is above
    x/g, by e^-A, A = ∫ h dx, h = ω exp[-(1 - x/gξ)/α]."""
    alpha, wave = 0.01, 1j * wave_number
    cells, width = np.linspace(0.0, 2.2, 400, endpoint=False), 2.2 / 400
    x, threshold = np.linspace(0.0, 4.0, 1001), cells + 0.5 * width
    growth = 1.0 + 0.1 * np.log1p(x / 1e-3)
    met, density = x / growth, stats.weibull_min(STEEP).pdf
    rate = 1e3 * np.exp(-(1.0 - np.minimum(met[:, None] / threshold, 1.0)) / alpha)
    passed = integrate.cumulative_trapezoid(rate, x, axis=0, initial=0.0)
    unmet = np.clip((cells + width - met[:, None]) / width, 0.0, 1.0)
    holds = unmet * np.exp(-passed) * density(threshold) * width
    held = holds.sum(axis=1)
    born = 1.0 / np.trapezoid(held, x)
    # of contacts that meet their threshold the rest was broken by heat before
    of_met = [np.exp(-np.interp(one, threshold, row)) for one, row in zip(met, passed, strict=True)]
    further, late = np.expm1(wave * x), np.exp(-wave * x)
    rises = rate / (alpha * threshold * growth[:, None]) * further[:, None]
    more = integrate.cumulative_trapezoid(rises, x, axis=0, initial=0.0)
    fewer = density(met) * of_met / growth * further + (holds * more).sum(axis=1)
    births = np.trapezoid(late * fewer, x) * born / np.trapezoid(held * late, x)
    moved = np.trapezoid(late * (further * held - x * fewer), x) * born
    return complex(-births * np.trapezoid(x * held * late, x) - moved)


@pytest.mark.slow  # some 45 s
def test_both_laws_on_springs_below_and_above_the_critical_one() -> None:
    """Heat and strengthening: small disturbances decide by quadrature for the solved critical spring, not for
    (b - a)/D_c, whose direct effect acts at once. Both solvers slow a slider down from where neither law acts: on half
    of that spring it slips, by as much in both, on twice that it goes on smoothly. K* of its start tells neither."""
    wave_numbers = np.geomspace(0.1, 60.0, 40)
    imaginary = [stiffness_of_both(q).imag for q in wave_numbers]
    (turn,) = np.flatnonzero(np.diff(np.sign(imaginary)))
    wave_number = optimize.brentq(
        lambda q: stiffness_of_both(q).imag, *wave_numbers[turn : turn + 2], rtol=1e-6
    )
    exact = stiffness_of_both(wave_number).real
    found = master.rate_state(BOTH, 1.0, decades=0)
    assert found.success and found.b.value > found.a.value > 0.0
    off = abs(found.critical_spring_solved - exact)
    assert off < found.critical_spring_solved_error < 0.06 * exact
    assert off < 0.002 * exact
    assert found.critical_spring + 2.0 * found.critical_spring_error < exact
    # at T = 0, and as they form, contacts of steady sliding are stretched by S(x)/<x_s>
    contacts = BOTH.replace(start=stats.halfgennorm(STEEP))
    begin, speeds, onward = contacts.start.mean(), np.geomspace(1e3, 1.0, 40), np.arange(1, 101)
    for spring, slips in ((0.5 * exact, 1), (2.0 * exact, 0)):
        slowing = np.full(40, 0.1 + 0.01 / spring)
        drive = begin / spring + np.r_[0.0, np.cumsum(slowing)]
        times = 1e-9 + np.r_[0.0, np.cumsum(slowing / speeds)]
        path = np.r_[drive, drive[-1] + 0.05 * onward]
        given: dict[str, Any] = {"spring": spring, "slip": "instant"}
        given["time"] = np.r_[times, times[-1] + 0.05 * onward]
        solved = master.solve(contacts, path, 5e-2, **given)
        single = eq_model.simulate(contacts, path, n_contacts=40_000, n_replicas=1, seed=1, **given)
        assert solved.success and solved.slips.drive.size == single.slips.drive.size == slips
        assert solved.regime.critical_spring < 0.1 * spring
        claim = solved.force_error * contacts.mean_threshold
        if slips:
            drops = [one.slips.force_before - one.slips.force_after for one in (solved, single)]
            assert abs(drops[0] - drops[1]) < 0.01 < 0.1 * drops[0]
            assert abs(solved.slips.drive - single.slips.drive) * spring < claim
            continue
        assert np.abs(solved.force - single.force).max() < claim + 0.01
        for force in (solved.force, single.force):  # a wavelength and a half
            assert np.ptp(force[-80:]) < 0.03
            assert abs(force[-80:].mean() - found.kinetic_force) < 0.01


def test_bad_input_is_refused_in_a_line() -> None:
    for contacts, given, words in (
        (Contacts(WIDE), {}, "a = b = 0: their force does not depend on the speed"),
        (
            Contacts(WIDE, ageing=Ageing(WIDE, rate=1.0, closure="paper")),
            {},
            "closure = 'paper': of ageing follows one speed without steps",
        ),
        (EYRING, {"velocity": -1.0}, "velocity = -1.0"),
        (EYRING, {"ratio": 1.0}, "ratio = 1.0: must lie between"),
        (EYRING, {"rests": [-1.0]}, r"rests\[0\] = -1.0"),
        (EYRING, {"evolution": "ruina"}, "evolution = 'ruina'"),
        (EYRING, {"decades": -1}, "decades = -1"),
    ):
        with pytest.raises(InputError, match=words):
            master.rate_state(contacts, **given)


@pytest.mark.slow  # some 40 s
def test_heat_and_strengthening_of_a_rough_surface_step_as_single_contacts_do() -> None:
    """The scene rate-state with thresholds that strengthen, too: numbers of the page, and a step by the ensemble."""
    scene = load_scene("rate-state")
    contacts = scene.contacts.replace(
        thresholds=strengthening(scene.contacts.thresholds, 0.03, 1e-4)
    )
    found = master.rate_state(contacts, scene.sliding, decades=0)
    assert found.success
    coefficient = scene.scale.force / (scene.scale.load or 1.0)
    assert found.a.value * coefficient == pytest.approx(0.0123, abs=5e-5)
    assert found.b.value * coefficient == pytest.approx(0.0074, abs=5e-5)
    assert found.slip_distance.value == pytest.approx(4.66e-9, abs=1e-11)
    step = found.steps[0]
    some = np.searchsorted(
        step.slip, contacts.mean_threshold * np.array([0.03, 0.1, 0.3, 0.6, 1.2])
    )
    begin = 8.0 * contacts.mean_threshold
    path = begin + np.append(0.0, step.slip[some])
    times = begin / step.before + (path - begin) / step.after
    single = eq_model.simulate(contacts, path, time=times, n_contacts=400_000, seed=11)
    solved = np.append(step.steady_before, step.force[some])
    off = (single.force - solved) / np.hypot(single.force_standard_error, step.error)
    assert np.abs(off).max() < 4.0
    assert np.ptp(solved) > 20.0 * single.force_standard_error.max()


@pytest.mark.slow
def test_steps_that_change_the_force_by_less_than_its_error_are_refused() -> None:
    """Neither smaller steps nor other speeds and rests are begun."""
    begun = list[str]()
    hardly = Thermal("eyring", width=1e-4)
    contacts = Contacts(strengthening(gaussian(1.0, 0.2), 1e-5, 1.0), thermal=hardly)
    with pytest.raises(InputError, match=r"changes by .*, and its error is .* eq_model"):
        master.rate_state(contacts, 1e-3, rests=[1.0], progress=begun.append)
    assert begun == ["velocity steps"]


def test_what_is_below_its_error_is_not_told() -> None:
    """Heat that does next to nothing: no figure of a, b, D_c and springs, and no work on what would be known no better.
    F_k and its slope are known."""
    begun = list[str]()
    idle = Contacts(WIDE, thermal=Thermal("soft", 1e-12))
    found = master.rate_state(idle, 1e-3, rests=[1.0, 10.0, 100.0], progress=begun.append)
    assert begun == ["velocity steps", "velocity steps to a lower tolerance"]
    assert not found.success and "a lower tolerance" in found.message
    assert found.a.error > abs(found.a.value) and not found.rests
    assert np.isnan(found.critical_spring) and np.isnan(found.critical_spring_solved)
    found = replace(found, run_time=381.0)  # it was told as 3.8e+02 s
    lines = page(Judged("idle", "idle", Scale(), found, 1.0, 0.1, 0.2))
    assert lines[-1] == "run time 381.0 s"
    rows = {line[:16].strip(): line[16:].split() for line in lines}
    for name in ("direct effect a", "evolution effect", "slip distance D_"):
        assert rows[name][-2:] == ["not", "known"], lines
    assert "0.5200" in next(line for line in lines if "F_k" in line)
    text = "\n".join(lines)
    assert text.count("springs that are not known") == 3 and "± 0" not in text
    assert "`mesofriction verdict` of the scene with a drive.spring tells" in text


@pytest.mark.slow  # some 40 s
def test_a_weak_effect_asks_for_a_lower_tolerance() -> None:
    """Barriers (x_s² - x²)/2 of soft heat: a factor e of the rate shifts each break by T/x_s, so that a = T/<x_s>, here
    less than the tolerance that is asked for."""
    cold = Contacts(WIDE, thermal=Thermal("soft", 3e-6, 1e9))
    found = master.rate_state(cold, 1e-3, decades=0)
    assert found.success and found.a.error < 2e-3 * found.a.value
    assert found.a.value == pytest.approx(3e-6 / WIDE.mean(), rel=2e-3)


@pytest.mark.slow
def test_contacts_in_step_say_that_they_do_not_become_steady() -> None:
    """Thresholds that are almost alike break together for longer than the answer is followed."""
    narrow = Contacts(gaussian(1.0, 0.02), delay=Delay(0.1))
    found = master.rate_state(narrow, 1.0, decades=0, tolerance=1e-3)
    assert not found.success and "in step" in found.message


@pytest.mark.slow
def test_the_page_of_the_documentation_holds() -> None:
    """The numbers of docs/rate-and-state.md, over the load of 1 N."""
    scene = load_scene("rate-state")
    found = master.rate_state(scene.contacts, scene.sliding, decades=0)
    coefficient = scene.scale.force / (scene.scale.load or 1.0)
    for number, value, definition in (
        (found.a, 0.0114, 0.0037),
        (found.b, 0.0040, 0.0037),
        (found.a_minus_b, 0.0074, 0.0),
    ):
        assert number.value * coefficient == pytest.approx(value, abs=5e-5)
        assert number.definition * coefficient == pytest.approx(definition, abs=5e-5)
    assert found.slip_distance.value == pytest.approx(4.0e-9, abs=5e-11)
    assert found.misfit_later.share == pytest.approx(0.12, abs=0.005)
    assert found.critical_spring == found.critical_spring_solved == 0.0
    scene = load_scene("rate-state-weakening")
    for slope, *times in ((0.028, 10**-0.5, 1.0), (0.023, 10**3.75, 10**4.25)):
        low, high = (rest_of(scene.contacts, scene.sliding, one, 1e-5).peak for one in times)
        rise = (high - low) / np.log10(times[1] / times[0])
        assert rise * scene.scale.force == pytest.approx(slope, abs=5e-4)


@pytest.mark.parametrize(("beta", "signs"), [(0.03, (1, 1, 1)), (0.1, (1, -1, 1))])
def test_with_heat_friction_of_contacts_that_strengthen_falls_between_two_speeds(
    beta: float, signs: tuple[int, ...]
) -> None:
    """docs/rate-and-state.md: only where βA > α(B + β), A and B of docs/laws.md; beyond <x_s>/τ_0 it rises again."""
    contacts = EYRING.replace(thresholds=strengthening(WIDE, beta=beta, time=1e3))
    for velocity, sign in zip((1e-8, 1e-4, 1e-2), signs, strict=True):
        slow, fast = master.kinetic_curve(contacts, velocity * np.array([0.9, 1.1])).force
        assert np.sign(fast - slow) == sign
        if velocity < 1e-3:
            b = 1.0 - beta * np.log(1e3 * velocity)
            a = 1.0 + ALPHA * (np.log(velocity / ALPHA / b) - 0.58)
            assert np.sign(ALPHA * (b + beta) - beta * a) == sign


@pytest.mark.parametrize(
    "stop", [TimeIsUp, *(slow(one) for one in (KeyboardInterrupt, Terminated))]
)
def test_a_stopped_command_leaves_what_is_known(
    capsys: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, stop: type[BaseException]
) -> None:
    """Once the steps are solved: their page and files, the same as those of a call; without that nothing."""
    monkeypatch.chdir(tmp_path)
    file = write(master=None, contacts=STRENGTHENED, drive={"velocity": 1.0}, wall_time=1e9)
    ends = {KeyboardInterrupt: (130, "interrupted; "), Terminated: (143, "terminated; ")}
    status, begins = ends.get(stop, (2, "wall_time = "))
    # of two ends that leave as much, both where the test is slow
    ends_at = [("velocity", False), ("smaller", True), ("steps about", True)]
    for end, left in ends_at[:: 2 if stop is TimeIsUp else 1]:

        def doing(_: Progress, what: str, end: str = end) -> None:
            if what.startswith(end):
                raise stop

        monkeypatch.setattr(Progress, "doing", doing)
        told, out, err = said(capsys, "rate-state", file)
        assert Path("mine-output").exists() == left
        if left and stop is TimeIsUp:  # what is known is the answer, which misses a part
            assert told == 1 and out[-1] == "written to mine-output" and "a - b" in "".join(out)
            continue
        assert (told, out, len(err)) == (status, [], 1)
        assert err[0].startswith(f"mesofriction: {begins}")
        assert err[0].endswith("what is known so far is written to mine-output") == left
        early = not left and stop is TimeIsUp
        assert ("it ended in its velocity steps, before which nothing is known" in err[0]) == early
    found = json.loads(Path("mine-output/rate-state.json").read_text())
    fresh = WIDE.moment(2) / (2.0 * WIDE.mean())
    exact = BETA * fresh / (1.0 - BETA * fresh / found["kinetic_force"])
    assert not found["success"] and "9 of 9 rests were not followed" in found["message"]
    assert found["a"]["value"] == 0.0 and found["b"]["value"] == pytest.approx(exact, rel=3e-3)
    assert found["critical_spring_from_start"] is None and found["rests"] == []
    page = Path("mine-output/rate-state.txt").read_text()
    assert f"{found['b']['value']:.3g}" in page and "not as asked: interrupted" in page
    assert "softer than" in page and "K*" not in page
    with Path("mine-output/rate-state.csv").open() as stream:
        rows = list(csv.reader(stream))
    assert rows[0][0].startswith("slip") and len(rows[0]) == 9 and len(rows) > 200
    # the steps alone, without an empty panel for the rests
    height, width, _ = imread("mine-output/rate-state.png").shape
    assert width < 1.6 * height


@pytest.mark.slow
def test_the_command(capsys: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The page in newtons and over the load, and files that hold the same numbers as the call."""
    monkeypatch.chdir(tmp_path)
    contacts = {"thresholds": ROUGH, "delay": {"time": 1e-3}}
    drive = {"area": 1e-6, "velocity": 1e-6}
    file = write(master=None, contacts=contacts, drive=drive)
    status, out, _ = said(capsys, "rate-state", file)
    assert status == 0, out
    found = json.loads(Path("mine-output/rate-state.json").read_text())
    page = "\n".join(out)
    assert "direct effect a" in page and "slip distance D_c" in page and "softer than" in page
    assert found["units"]["force"] == "N" and found["load"] == 1.0
    assert found["a"]["value"] == 0.0 and found["a_minus_b"]["value"] < 0.0
    assert f"{found['b']['value']:.3g}" in page  # over the load of 1 N
    with Path("mine-output/rate-state.csv").open() as stream:
        rows = list(csv.reader(stream))
    assert rows[0][0] == "slip [m]" and len(rows[0]) == 9 and len(rows) > 200
    assert Path("mine-output/rate-state.png").stat().st_size > 10_000
    contacts = {"thresholds": ROUGH}
    file = write(master=None, contacts=contacts, drive=drive)
    told = refused(capsys, "rate-state", file)
    assert told.startswith("contacts: a = b = 0") and "[contacts.thermal] law = " in told


@pytest.mark.slow  # some 20 s
def test_slips_that_come_and_go_with_the_steps_have_a_finite_error():
    """Where smooth sliding gets unstable the first slips are small, and finer steps may have one more: a surface whose
    friction falls with the speed, slowed to 1 µm/s on a spring 5 % below the critical one. Late slips are those of the
    ensemble at three N, extrapolated by N^(-2/3)."""
    scene = load_scene("rate-state-weakening")
    stiffness, newtons = 1.09e6, scene.scale.force
    # in 30 steps the slider would go so long where sliding gets unstable that the time of all its slips hangs on chance
    speeds, onward = np.geomspace(1e-3, 1e-6, 6), 2e-9 * np.arange(1, 151)
    slid = 0.25 / stiffness + 6e-8 + 4e-8 * np.arange(6)
    times = np.cumsum(np.diff(slid, prepend=0.0) / speeds)
    path = np.r_[0.0, slid, slid[-1] + onward]
    arrival = np.r_[0.0, times, times[-1] + onward / 1e-6]
    spring = stiffness / scene.scale.spring
    found = master.solve(scene.contacts, path, 1e-3, spring=spring, slip="instant", time=arrival)
    error = newtons * scene.contacts.mean_threshold * found.force_error
    assert error < 2e-3 and found.regime.verdict == "stick-slip"
    slips = found.slips
    for solved, ensemble, scatter in (
        (newtons * slips.force_before[-1], 335.32e-3, 0.17e-3),
        (newtons * slips.force_after[-1], 251.23e-3, 0.14e-3),
        (stiffness * np.diff(slips.drive)[-1], 88.67e-3, 0.14e-3),
    ):
        assert abs(solved - ensemble) < 4.0 * scatter + error


@pytest.mark.slow  # quick: a command that its time stops, above
@pytest.mark.usefixtures("unrendered")
def test_the_end_of_the_time_is_told_by_the_runs_own_parts(
    capsys: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In which rest it was over, and how long those before it took, on a clock on which each takes 7 s."""
    monkeypatch.chdir(tmp_path)
    file = write(master=None, contacts=STRENGTHENED, drive={"velocity": 1.0}, wall_time=1e9)
    clock = [0.0]

    def doing(_: Progress, what: str) -> None:
        clock[0] += 7.0
        if what == "rest 3 of 9":
            raise TimeIsUp

    monkeypatch.setattr(Progress, "doing", doing)
    monkeypatch.setattr("toolkit.rate_state.report.time.monotonic", lambda: clock[0])
    status, page, _ = said(capsys, "rate-state", file)
    told = "; wall_time is over; it ended in its rest 3 of 9, where one before took 7 s; --set wall_time=1"
    found = json.loads(Path("mine-output/rate-state.json").read_text())
    assert status == 1 and told in found["message"] and not found["success"]
    assert "7 of 9 rests were not followed" in found["message"] and "rest 3 of 9" in "".join(page)


@pytest.mark.slow  # quick: a command that its time stops, above
@pytest.mark.usefixtures("unrendered")
def test_without_a_wall_time_what_is_known_after_two_minutes_of_work_is_the_answer(
    capsys: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A page, its files and status 1; before the first steps are solved the time goes on."""
    monkeypatch.chdir(tmp_path)
    file = write(master=None, contacts=STRENGTHENED, drive={"velocity": 1.0})
    time_left = list[float]()

    def within(deadline: float, scene: Any, what: str, remaining: Any) -> Any:
        time_left.append(remaining())
        return solvers.within(deadline, scene, what, remaining)

    def doing(_: Progress, what: str) -> None:
        if what == "rest 1 of 9":
            raise TimeIsUp

    monkeypatch.setattr(Progress, "doing", doing)
    monkeypatch.setattr("toolkit.rate_state.report.within", within)
    status, out, err = said(capsys, "rate-state", file)
    assert (status, err) == (1, []) and out[-1] == "written to mine-output"
    assert time_left == [WORK]
    (line,) = [line for line in out if line.startswith("not as asked: ")]
    assert "9 of 9 rests were not followed; 120 s of work were over; it ended in its rest" in line
    assert line.endswith("--set wall_time=1800.0 gives it half an hour")
    found = json.loads(Path("mine-output/rate-state.json").read_text())
    assert not found["success"] and found["b"]["value"] > 0.0


@pytest.mark.slow  # quick: a command that its time stops, above
def test_an_answer_without_its_smaller_steps_is_no_success() -> None:
    """What is known after the first steps, without rests: no spring, and `success` is False."""
    contacts = Contacts(WIDE, delay=Delay(0.1))
    early = list[Any]()
    found = master.rate_state(contacts, decades=0, known=lambda so_far: early.append(so_far()))
    assert found.success and np.isfinite(found.critical_spring_solved_error)
    assert "law_steps=(<" in repr(found) and len(repr(found)) < 2500  # of 1,310 points each
    (first,) = early
    assert not first.success and first.message.startswith("interrupted")
    assert first.a.value == pytest.approx(found.a.value, abs=1e-3 * abs(found.b.value))
    assert first.b.value == pytest.approx(found.b.value, rel=1e-2)
    assert not np.isfinite(first.critical_spring_solved_error)


def test_which_law_in_time_moves_the_friction_of_a_surface() -> None:
    """docs/choosing.md: the elastic barrier of contacts of micrometres does not, Eyring's heat by α F_k(∞) for each
    factor e of the speed, strengthening by less than -β."""
    kelvin = {"temperature": {"kelvin": 300.0}, "attempt_frequency": 1e10}
    volume = {"kelvin": 300.0, "shear_strength": 5e7, "activation_volume": 2.8e-27}
    eyring = {"law": "eyring", "attempt_frequency": 1e10} | volume
    slopes = dict[str, float]()
    for name, law in {
        "none": {},
        "soft": {"thermal": {"law": "soft"} | kelvin},
        "stiff": {"thermal": {"law": "stiff"} | kelvin},
        "eyring": {"thermal": eyring},
        "strengthening": {"strengthening": {"beta": 0.03, "time": 1e-4}},
    }.items():
        scene = {"contacts": {"thresholds": ROUGH} | law}
        contacts = load_scene(scene, solved=False).contacts
        slow, fast = (master.steady_state(contacts, velocity=v).force for v in (1e-7, 1e-5))
        slopes[name] = (fast - slow) / np.log(100.0)
        if name == "none":
            cold = slow
    alpha = 1.380649e-23 * 300.0 / (5e7 * 2.8e-27)
    assert slopes["none"] == 0.0
    assert 0.0 < max(abs(slopes["soft"]), abs(slopes["stiff"])) < 1e-4 * cold
    assert slopes["eyring"] == pytest.approx(alpha * cold, rel=0.02)
    assert slopes["strengthening"] == pytest.approx(-0.03 * cold, rel=0.05)
