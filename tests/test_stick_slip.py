"""K*, F_s/F_k and X* against closed forms and a second road; the phase line; v_c."""

from __future__ import annotations

import time
from itertools import pairwise

import numpy as np
import pytest
import scipy.stats
from conftest import slow

import master
import origins
from master.motion import Motion
from master.outcome import StoppedError
from master.stick_slip.extremes import extremes
from master.survival.make import life_of
from origins import Ageing, Contacts, InputError, Thermal

SPREAD = origins.gaussian_start(0.0, 0.025)
TWO = origins.mixture([origins.identical(1.0), origins.identical(1.5)], [0.5, 0.5])
CLOSED = {
    # law, start, K*, F_s/F_k
    "uniform": (origins.rectangular(0.0, 1.0), None, np.e - 2.0, None),
    "rectangular": (origins.rectangular(0.5, 1.5), None, 7.0 / 8.0, 15.0 / 13.0),
    "rectangular, from within": (origins.rectangular(0.5, 1.5), 0.5, 7.0 / 8.0, 15.0 / 13.0),
    "exponential": (scipy.stats.expon(), None, 0.0, 1.0),
    "pareto": (scipy.stats.pareto(8.0), None, 7.0, None),
    "identical": (origins.identical(1.3), None, np.inf, 2.0),
    "arcsine, a density that diverges": (scipy.stats.beta(0.5, 0.5), None, np.inf, None),
    "one value, spread start": (
        origins.identical(1.0),
        SPREAD,
        40.0 / np.sqrt(2.0 * np.pi) - 1.0,
        None,
    ),
    "two values": (TWO, None, np.inf, None),
}


def test_a_critical_spring_that_time_does_not_suffice_for_is_unknown() -> None:
    fall = extremes(Contacts(origins.gaussian(1.0, 0.1)), 1.0, 1e-6, until=0.0).fall
    assert np.isnan(fall.value) and fall.error == np.inf


@pytest.mark.parametrize("name", [slow(name, when="arcsine" in name) for name in CLOSED])
def test_closed_values(name: str) -> None:
    law, start, spring, static = CLOSED[name]
    found = master.propensity(origins.Contacts(law, start))
    if np.isinf(spring):
        assert found.critical_spring == np.inf and found.critical_spring_error == 0.0
    else:
        off = abs(found.critical_spring - spring)
        assert off <= found.critical_spring_error <= 2e-8 * (1.0 + spring)
    if static is not None:
        assert abs(found.static_to_kinetic - static) <= found.static_to_kinetic_error <= 3e-8


@pytest.mark.parametrize("delay", [0.0, 1.3])
@pytest.mark.parametrize("start", [None, 0.4, origins.gaussian_start(-0.2, 0.1)])
def test_no_slope_and_no_force_lie_beyond_one_life_without_the_start(start, delay) -> None:
    """F is followed until it is a mean of its values before: brute force along 25 thresholds finds nothing more."""
    contacts = Contacts(
        origins.rectangular(0.3, 1.7), start, delay=origins.Delay(delay) if delay else None
    )
    x = np.linspace(0.0, 25.0, 5001)
    force, found = master.solve(contacts, x, 1e-10).force, master.propensity(contacts, 1e-6)
    slope = -np.diff(force).min() / x[1]
    assert found.success and -1e-9 <= found.critical_spring - slope <= 1e-2
    static = found.static_to_kinetic * master.steady_state(contacts).force
    assert -1e-9 <= static - force.max() <= 1e-5


def test_a_drop_of_the_strongest_contacts_is_met() -> None:
    """F is followed to the longest life, at whose end they break together."""
    law = origins.mixture([origins.rectangular(0.0, 1.0), origins.identical(1.5)], [0.9, 0.1])
    assert master.propensity(Contacts(law)).critical_spring == np.inf


@pytest.mark.parametrize("law", [origins.gw_elastic(1.588), slow(origins.gw_gaussian(0.5, 1.0))])
def test_averages_over_a_spread_start_are_as_fine_as_slopes_need(law: origins.Thresholds) -> None:
    """F falls by a ten thousandth of its rise; averages too coarse for its slope cost minutes and missed 1e-8."""
    contacts, x = Contacts(law, SPREAD), np.linspace(0.0, 6.0, 601)
    found = master.propensity(contacts)
    force = master.solve(contacts, x, 1e-11).force
    assert found.success and found.critical_spring_error < 1e-8
    assert found.critical_spring == pytest.approx(-np.gradient(force, x).min(), rel=2e-3)


def test_a_start_of_many_bins_has_its_slope_in_a_second() -> None:
    """Coarser averages over its bins would let the finer marches narrow their panels in noise, without an end."""
    law, edges = origins.gaussian(1.0, 0.2), np.linspace(0.0, 2.0, 201)
    holds = law.sf(0.5 * (edges[1:] + edges[:-1]))
    start = scipy.stats.rv_histogram((holds, edges), density=True)
    contacts, x = Contacts(law, start, delay=origins.Delay(0.1)), np.linspace(0.0, 6.0, 1201)
    found = master.propensity(contacts, 1e-3)
    slopes = np.gradient(master.solve(contacts, x, 1e-5, wall_time=60.0).force, x)
    assert found.success and found.critical_spring_error < 1e-3
    assert found.critical_spring == pytest.approx(-slopes.min(), abs=3e-3)


@pytest.mark.slow
def test_thresholds_of_a_histogram_are_a_mixture_of_rectangles() -> None:
    """The same law by scipy and by a family of ours; with bins of one weight it is one rectangle, whose K* is 7/8."""
    edges = np.linspace(0.5, 1.5, 11)
    drawn = np.diff(origins.gaussian(1.0, 0.2).cdf(edges))
    drawn /= drawn.sum()
    histogram = scipy.stats.rv_histogram((drawn, edges), density=False)
    bins = [origins.rectangular(low, high) for low, high in pairwise(edges)]
    rectangles = origins.mixture(bins, drawn)
    x = np.linspace(0.0, 3.0, 13)
    one, other = (master.solve(Contacts(law), x, 1e-8) for law in (histogram, rectangles))
    assert one.success and other.success
    assert np.abs(one.force - other.force).max() <= one.force_error + other.force_error
    one, other = (master.propensity(Contacts(law), 1e-6) for law in (histogram, rectangles))
    assert one.success and one.critical_spring == pytest.approx(other.critical_spring, rel=2e-6)
    even = scipy.stats.rv_histogram((np.ones(10), edges), density=False)
    assert master.propensity(Contacts(even), 1e-6).critical_spring == pytest.approx(0.875, rel=1e-6)


@pytest.mark.slow
def test_bins_of_both_laws_with_heat_are_refused_before_the_work() -> None:
    """Averages over bins of the start, of sums over bins of P_c: with few of one it is answered."""
    heat = origins.Thermal("soft", 0.1)
    start, law = (
        scipy.stats.rv_histogram((np.ones(200), np.linspace(low, low + 0.1, 201)), density=True)
        for low in (0.1, 0.9)
    )
    many = Contacts(law, start, thermal=heat)
    for ask in (master.propensity, lambda contacts: master.solve(contacts, [0.5, 1.0, 2.0])):
        with pytest.raises(
            InputError, match=r"^start: .* 201 edges .* takes some \d+ s; .*wall_time$"
        ):
            ask(many)
    few = Contacts(origins.rectangular(0.9, 1.0), start, thermal=heat)
    assert master.solve(few, [0.02], 1e-4).success


def test_averages_over_a_start_look_at_the_clock() -> None:
    contacts = Contacts(origins.gaussian(1.0, 0.2), origins.gaussian_start(0.1, 0.02))
    life, motion = life_of(contacts), Motion(np.array([0.0, 1.0]), np.array([0.0, 1.0]))
    history = motion.history(np.array([[0.5]]), np.zeros((1, 1)))
    assert life.survival_and_force(contacts.start, history).survival[0, 0] < 1.0
    life.until = time.monotonic()
    with pytest.raises(StoppedError, match="wall_time"):
        life.survival_and_force(contacts.start, history)
    found = master.solve(contacts, [1.0], wall_time=1e-9)
    assert not found.force.size and "no panel was solved" in found.message


def test_thresholds_of_100_bins_fall_most_steeply_where_the_density_says() -> None:
    """Up to X = 1, before any contact breaks twice, F' = 1 - X P_c(X), and K* is the largest X P_c(X) - 1, at the upper
    edge of one of the bins; E there is 1 less what has broken, so that F is a sum over the bins, too."""
    edges = np.linspace(0.5, 1.0, 101)
    drawn = np.diff(origins.gaussian(0.8, 0.05).cdf(edges)) * np.tile([0.7, 1.3], 50)
    contacts = Contacts(scipy.stats.rv_histogram((drawn, edges), density=False))
    density = drawn / drawn.sum() / np.diff(edges)
    found = master.propensity(contacts, 1e-8)
    assert found.success and found.critical_spring == pytest.approx(
        (edges[1:] * density).max() - 1.0, rel=1e-7
    )
    solution = master.solve(contacts, edges, 1e-8)
    fallen = np.append(0.0, np.cumsum(density * np.diff(edges**2) / 2.0))
    assert solution.success
    assert np.abs(solution.force - (edges - fallen)).max() <= solution.force_error


def test_a_start_of_200_bins_is_a_sum_over_them() -> None:
    """Up to X = 0.3 none that formed at X > 0 breaks: F is the sum over the bins of what their contacts bear, and the
    integral of the fraction that has broken; F falls most steeply where its slope, by the same sums, is least."""
    law, edges = origins.gaussian(1.0, 0.05), np.linspace(0.45, 0.95, 201)
    drawn = np.diff(origins.gaussian(0.75, 0.05).cdf(edges))
    start = scipy.stats.rv_histogram((drawn, edges), density=False)
    at, weight = np.polynomial.legendre.leggauss(20)
    half, middle = 0.5 * np.diff(edges)[:, None], 0.5 * (edges[1:] + edges[:-1])[:, None]
    born = (middle + half * at).ravel()
    share = (drawn[:, None] / drawn.sum() * 0.5 * weight).ravel() / law.sf(born)

    def holds(x: np.ndarray) -> np.ndarray:
        return np.asarray(law.sf(born + x[:, None]) @ share)

    x = np.linspace(0.0, 0.3, 31)
    within = x[:, None] * 0.5 * (at + 1.0)
    broken = (1.0 - holds(within.ravel())).reshape(within.shape) @ weight * 0.5 * x
    force = (law.sf(born + x[:, None]) * (born + x[:, None])) @ share + broken
    contacts = Contacts(law, start)
    found = master.solve(contacts, x, 1e-10)
    assert found.success and np.abs(found.force - force).max() < 1e-11
    stretch = born + np.linspace(0.2, 0.3, 1001)[:, None]
    slope = 1.0 - (law.pdf(stretch) * stretch) @ share
    critical = master.propensity(contacts, 1e-8)
    assert critical.success and critical.critical_spring == pytest.approx(-slope.min(), rel=1e-5)


NARROW, BROAD = origins.gaussian(1.0, 0.02), origins.gaussian(1.0, 0.3)
BEHIND = [(NARROW, -1.05, 0.5), (BROAD, -1.2, 20.0), (scipy.stats.expon(), 1.2, 40.0)]


@pytest.mark.parametrize(("law", "place", "wait"), BEHIND)
def test_the_second_generation_may_be_sharper_than_the_first(
    law, place: float, wait: float
) -> None:
    contacts = Contacts(law, reforming=place, delay=origins.Delay(wait))
    found, x = master.propensity(contacts, 1e-6), np.linspace(0.0, 2.0 * wait + 7.0, 20_001)[1:]
    force, kinetic = master.solve(contacts, x, 1e-7).force, master.steady_state(contacts).force
    assert found.critical_spring == pytest.approx(-np.gradient(force, x).min(), rel=2e-3)
    assert found.static_to_kinetic == pytest.approx(force.max() / kinetic, rel=1e-5)


def test_what_is_not_known_well_enough_says_so() -> None:
    contacts = origins.Contacts(origins.gaussian(1.0, 0.3))
    found = master.propensity(contacts, 1e-6)
    assert found.success and "only" not in found.message
    assert master.phase_line(contacts).success and master.kinetic_curve(contacts).success
    found = master.propensity(contacts, 1e-14)
    assert not found.success and "only, above 1.0e-14" in found.message
    line = master.phase_line(contacts, [1.0, 2.0], tolerance=1e-14)
    assert not line.success.any() and " only at 2 of 2 points, above 1.0e-14" in line.message


NARROW = origins.gaussian(1.0, 0.05)


def test_a_table_is_the_propensity_at_each_point_and_the_steepest_fall() -> None:
    contacts = Contacts(NARROW, thermal=Thermal("soft", 0.3))
    speeds, temperatures = np.array([0.3, 10.0]), np.array([0.0, 0.1, 0.3])
    line = master.phase_line(contacts, speeds[:, None], temperature=temperatures)
    assert line.critical_spring.shape == line.critical_spring_error.shape == (2, 3)
    # hotter or slower, smoother (Fig. A08e); cold, x P_c(x) - 1 at its largest
    assert (np.diff(line.critical_spring, axis=1) < 0.0).all()
    assert (np.diff(line.critical_spring, axis=0)[:, 1:] > 0.0).all()
    x = np.linspace(0.9, 1.1, 200_001)
    cold = (x * NARROW.pdf(x)).max() - 1.0
    off = np.abs(line.critical_spring[:, 0] - cold)
    assert (off <= line.critical_spring_error[:, 0] + 1e-8).all()
    for i, j in ((0, 2), (1, 1)):
        warm = Contacts(NARROW, thermal=Thermal("soft", float(temperatures[j])))
        single = master.propensity(warm, velocity=float(speeds[i]))
        off = abs(line.critical_spring[i, j] - single.critical_spring)
        assert off <= line.critical_spring_error[i, j] + single.critical_spring_error < 1e-5
        path = np.linspace(0.9, 1.1, 2001)
        force = master.solve(warm, path, 1e-10, velocity=float(speeds[i])).force
        steepest = -np.diff(force).min() / (path[1] - path[0])
        assert single.critical_spring == pytest.approx(steepest, rel=1e-5)


def test_few_contacts_that_break_last_count() -> None:
    laws = [origins.gw_plastic(400.0), origins.rectangular(0.8, 1.0)]
    few = Contacts(origins.mixture(laws, [0.97, 0.03]))
    path = np.linspace(0.98, 1.0, 401)
    steepest = -np.diff(master.solve(few, path, 1e-9).force).min() / 5e-5
    assert master.propensity(few, 1e-4).critical_spring == pytest.approx(steepest, rel=1e-3)


WIDE = origins.gaussian(1.0, 0.2)
HOT = Thermal("stiff", 0.00864, 1.8918)
COARSE = {
    "errors of earlier panels": Contacts(origins.rectangular(0.0, 1.0), reforming=-0.0515),
    "births at many stretches": Contacts(WIDE, reforming=origins.gaussian_start(0.0, 0.1)),
    "linked": Contacts(origins.gaussian(1.0, 0.1), stiffness="linked"),
    "soft": Contacts(origins.gaussian(1.0, 0.1), thermal=Thermal("soft", 0.1)),
    "stiff, delay": Contacts(origins.rectangular(0.0, 0.19), -0.05, HOT, delay=origins.Delay(0.07)),
    "ageing": Contacts(NARROW, ageing=Ageing(WIDE, 1e-3)),
    "grains": Contacts(origins.growing_grains(1.0, 1.0, age=4.0)),
}


# of the others a delay, grains and exact ends have tests of their own at finer tolerances
QUICKLY_SOLVED = ("linked", "soft", "births at many stretches")


@pytest.mark.parametrize("name", [slow(name, when=name not in QUICKLY_SOLVED) for name in COARSE])
def test_claims_at_coarse_tolerances_bound_the_error(name: str) -> None:
    tolerances, offs = (1e-2, 1e-3, 1e-4, 1e-7), []
    fine, *coarse = (master.propensity(COARSE[name], asked) for asked in (1e-9, *tolerances))
    for number in ("critical_spring", "static_to_kinetic", "decoherence_length"):
        known, error = getattr(fine, number), getattr(fine, f"{number}_error")
        for found in coarse:
            offs.append(abs(getattr(found, number) - known))
            assert offs[-1] <= getattr(found, f"{number}_error") + error
    assert all(found.success for found in coarse) and max(offs) > 1e-9


def test_slow_contacts_age_and_let_go_more_steeply() -> None:
    # the laws of Fig. A06; where ageing ends stick-slip is found by another road
    contacts = Contacts(FRESH, 0.02, ageing=Ageing(origins.gaussian(1.0, 0.02), 5e-4))
    line = master.phase_line(contacts, [2.0, 4.0], tolerance=1e-5)
    assert line.critical_spring[0] > line.critical_spring[1] + 0.1
    critical = master.critical_velocity(contacts, float(line.critical_spring[1]), 3.9, 4.1)
    slope = abs(line.critical_spring[1] - line.critical_spring[0]) / 2.0
    error = critical.velocity_error + 2.0 * line.critical_spring_error[1] / slope
    assert abs(critical.velocity - 4.0) <= error
    assert critical.velocity_error < 0.01


FRESH = origins.gaussian(0.5, 0.05)


def figure_a06(closure: str) -> Contacts:
    ageing = Ageing(origins.gaussian(1.0, 0.02), 5e-4, closure=closure)
    return Contacts(FRESH, origins.gaussian_start(0.02, 0.01), ageing=ageing)


@pytest.mark.slow
def test_propensity_tells_the_same_spring() -> None:
    """At v_c the critical spring is the one that v_c was found for; it reads F(X), whose slowest decay is X*."""
    contacts = figure_a06("exact")
    told = master.propensity(contacts, velocity=4.253078)
    assert told.critical_spring == pytest.approx(3.5, abs=1e-6)
    assert told.critical_spring_error < 3e-7
    path = np.linspace(0.0, 40.0, 4001)
    force = master.solve(contacts, path, 1e-8, velocity=4.253078).force
    kinetic = master.steady_state(contacts, velocity=4.253078).force
    assert force.max() == pytest.approx(told.static_to_kinetic * kinetic, rel=1e-4)
    # the envelope's decay, from peak to peak far out
    off = np.abs(force - kinetic)
    peaks = np.flatnonzero((off[1:-1] > off[:-2]) & (off[1:-1] > off[2:])) + 1
    far = peaks[path[peaks] > 20.0]
    rate = -np.polyfit(path[far], np.log(off[far]), 1)[0]
    assert 1.0 / rate == pytest.approx(told.decoherence_length, rel=2e-3)
