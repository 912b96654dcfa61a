"""The soft slider: where it lets go, where it lands under each rule, its period, and which regime it is in."""

import heapq

import numpy as np
import pytest
import scipy.stats
from phase_type import gaussian_force
from scipy.optimize import brentq
from scipy.special import gammaln

import master
import origins
from master._old.cohorts import solve_cohorts
from master._old.soft import SoftSolution, solve_soft

NARROW = origins.gaussian(1.0, 0.05)
RULES = ["reset", "instant", "reform-after"]


def gaussian_slope(x: np.ndarray, std: float) -> np.ndarray:
    """F'(X) from relaxed contacts: 1 - sum of X p_n(X)/n, p_n the density of the sum of n thresholds about 1."""
    n = np.arange(1, int(1.5 * np.max(x) + 12.0))[:, None]
    width = std * np.sqrt(n)
    density = np.exp(-0.5 * ((x - n) / width) ** 2) / (width * np.sqrt(2.0 * np.pi))
    return 1.0 - (x * density / n).sum(axis=0)


def gamma_slope(x: float, shape: float) -> float:
    n = np.arange(1, 40)
    return 1.0 - x * float((np.exp((n * shape - 1.0) * np.log(x) - x - gammaln(n * shape)) / n).sum())


# -- reset --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("spring", [0.05, 1.0, 6.0])
def test_reset_where_one_generation_breaks(spring):
    # smaller root of X P_c(X) = 1 + K
    def excess(x: float) -> float:
        return x * float(NARROW.pdf(x)) - 1.0 - spring

    let_go = brentq(excess, 0.7, 1.0, xtol=1e-15)
    static = float(gaussian_force(np.array([let_go]), 1.0, 0.05)[0])
    period = let_go + static / spring
    path = np.linspace(0.0, 3.3 * period, 301)
    solution = solve_soft(origins.Contacts(NARROW), path, spring, "reset", 1e-9)
    slips = solution.slips
    assert solution.success
    assert solution.regime.verdict == "stick-slip" and solution.regime.slips == slips.drive.size == 3
    assert abs(slips.before[0] - let_go) <= 1e-9
    assert abs(gaussian_slope(slips.before[:1], 0.05)[0] + spring) <= 1e-8
    assert np.abs(slips.drive - period * np.arange(1, 4)).max() <= 1e-9 * period
    assert abs(solution.period - period) <= 1e-9 * period
    assert (slips.after == slips.drive).all() and np.abs(slips.force_after).max() <= 1e-15 * spring * period
    assert slips.drop == pytest.approx([static] * 3, abs=1e-9)
    since = path % period

    def balance(x: float, drive: float) -> float:
        return gaussian_force(np.array([x]), 1, 0.05)[0] + spring * (x - drive)

    position = np.array([brentq(balance, -0.1, let_go, args=(drive,)) for drive in since])
    assert np.abs(solution.force - spring * (since - position)).max() <= 1e-7
    assert np.abs(solution.position - (path - since + position)).max() <= 1e-7 / min(spring, 1.0)


@pytest.mark.parametrize("shape", [9.0, 16.0])
def test_reset_where_contacts_broke_twice_before(shape):
    law = scipy.stats.gamma(shape)
    critical = master.propensity(origins.Contacts(law)).critical_spring
    spring = 0.6 * critical
    grid = np.linspace(0.2, 1.5, 200) * shape
    first = int(np.argmax([gamma_slope(x, shape) < -spring for x in grid]))
    let_go = brentq(lambda x: gamma_slope(x, shape) + spring, grid[first - 1], grid[first], xtol=1e-15)
    path = np.linspace(0.0, 60.0 * shape, 101)
    solution = solve_soft(origins.Contacts(law), path, spring, "reset", 1e-9)
    static = float(master.solve(origins.Contacts(law), [0.0, let_go], 1e-10).force[1])
    assert abs(gamma_slope(float(solution.slips.before[0]), shape) + spring) <= 1e-8
    assert abs(solution.period - (let_go + static / spring)) <= 1e-8 * solution.period


@pytest.mark.parametrize("law", [NARROW, origins.gaussian(1.0, 0.2), origins.lubricated(1.0)])
def test_a_millionth_off_critical_is_decided_rightly(law):
    contacts = origins.Contacts(law)
    critical = master.propensity(contacts, 1e-10).critical_spring
    path = np.array([0.0, 6.0, 12.0]) * contacts.mean_threshold * max(1.0, 1.0 / critical)
    for rule in RULES:
        stiff = solve_soft(contacts, path, critical * (1.0 + 1e-6), rule)
        assert stiff.regime.verdict == "smooth" and not stiff.slips.drive.size
        soft = solve_soft(contacts, path, critical * (1.0 - 1e-6), rule)
        assert soft.slips.drive.size
        assert soft.regime.verdict == "stick-slip" if rule == "reset" else "smooth"
        assert soft.regime.stiffness_ratio == pytest.approx(1.0 - 1e-6, abs=1e-8)


def test_identical_contacts_are_a_sawtooth_of_the_spring():
    path = np.linspace(0.0, 20.0, 401)
    solution = solve_soft(origins.Contacts(origins.identical(1.0)), path, 0.5, "reset")
    assert np.abs(solution.force - path % 3.0 * 0.5 / 1.5).max() <= 1e-9
    assert solution.regime.verdict == "stick-slip" and solution.period == pytest.approx(3.0, abs=1e-12)


def test_a_start_less_stable_than_relaxed_contacts_slips_once():
    law = origins.gaussian(1.0, 0.2)
    relaxed = master.propensity(origins.Contacts(law)).critical_spring
    contacts = origins.Contacts(law, 0.85)
    spring = 0.5 * (relaxed + master.propensity(contacts).critical_spring)
    assert spring > relaxed
    solution = solve_soft(contacts, np.linspace(0.0, 12.0, 50), spring, "reset")
    assert solution.slips.drive.size == 1
    assert solution.regime.verdict == "decaying transient"


# -- instant ------------------------------------------------------------------------------------------------------


def load(x: np.ndarray, spring: float) -> np.ndarray:
    return gaussian_force(x, 1.0, 0.05) + spring * x


@pytest.mark.parametrize("spring", [0.15, 0.5, 2.0])
def test_instant_lands_on_the_first_root_of_all(spring):
    solution = solve_soft(origins.Contacts(NARROW), np.linspace(0.0, 12.0, 601), spring, "instant", 1e-9)
    slips = solution.slips
    assert slips.drive.size >= 3
    for before, after, drive in zip(slips.before, slips.after, slips.drive, strict=True):
        level = spring * drive
        assert abs(load(np.array([before]), spring)[0] - level) <= 1e-9
        assert abs(load(np.array([after]), spring)[0] - level) <= 1e-9
        between = before + (after - before) * np.linspace(0.0, 1.0, 20_001)[1:-1]
        assert (load(between, spring) < level).all()
    assert np.abs(load(solution.position, spring) - spring * solution.path).max() <= 1e-8


def test_instant_tells_a_root_from_a_near_miss():
    # at this spring a later crest of F + KX only just comes up to the first: a millionth decides between two landings
    def crest(spring: float, begin: float, end: float) -> float:
        x = np.linspace(begin, end, 2001)
        at = x[load(x, spring).argmax()]
        fine = at + np.linspace(-1e-3, 1e-3, 2001)
        return float(load(fine, spring).max())

    marginal = brentq(lambda k: crest(k, 1.6, 2.2) - crest(k, 0.7, 1.1), 0.02, 1.0, xtol=1e-14)
    contacts = origins.Contacts(NARROW)
    landed = {}
    for sign in (-1, 1):
        spring = marginal * (1.0 + sign * 1e-6)
        path = np.linspace(0.0, 1.5 * crest(spring, 0.7, 1.1) / spring, 11)
        landed[sign] = float(solve_soft(contacts, path, spring, "instant", 1e-9).slips.after[0])
    assert 1.7 < landed[1] < 2.0 < 2.5 < landed[-1]


def test_instant_decoheres_to_smooth_sliding():
    path = np.linspace(0.0, 40.0, 401)
    solution = solve_soft(origins.Contacts(origins.gaussian(1.0, 0.1)), path, 0.8, "instant")
    assert solution.regime.verdict == "decaying transient"
    drop = solution.slips.drop
    assert drop.size >= 2 and (np.diff(drop) < 0.0).all()
    assert np.abs(solution.force - gaussian_force(solution.position, 1.0, 0.1)).max() <= 1e-8


def test_instant_with_two_exact_values():
    # at X = 0.8 half break and are back at once: 0.4 + K 0.8 -> 0.8 + K 0.8 after the travel 0.4/(1 + K)
    law = origins.mixture([origins.identical(0.8), origins.identical(1.2)], [0.5, 0.5])
    solution = solve_soft(origins.Contacts(law), [0.0, 1.3], 2.0, "instant")
    assert solution.slips.before[0] == pytest.approx(0.8, abs=1e-11)
    assert solution.slips.after[0] == pytest.approx(0.8 + 0.4 / 3.0, abs=1e-11)


# -- reform-after -------------------------------------------------------------------------------------------------


def test_reform_after_with_two_exact_values():
    # the half that holds alone carries 0.5 X + 2 X up to 0.8 + 1.6, then with the other half back to 0.72 + 2.4
    law = origins.mixture([origins.identical(0.8), origins.identical(1.2)], [0.5, 0.5])
    solution = solve_soft(origins.Contacts(law), [0.0, 1.25, 1.4, 1.6], 2.0, "reform-after")
    slips = solution.slips
    assert slips.before == pytest.approx([0.8, 1.2], abs=1e-11)
    assert slips.after == pytest.approx([0.96, 1.44], abs=1e-11)
    assert slips.drive == pytest.approx([1.2, 1.56], abs=1e-11)
    # too soft: those that hold break as well
    gone = solve_soft(origins.Contacts(law), [0.0, 2.5], 0.5, "reform-after").slips
    assert gone.after[0] == pytest.approx(gone.drive[0], abs=1e-11)
    assert gone.force_after[0] == pytest.approx(0.0, abs=1e-11)


def avalanches(thresholds, spring: float, end: float, size: int, least: float, rng) -> np.ndarray:
    """Contacts one by one: those of each avalanche that break more than a fraction `least`; X_T, X after, drop."""
    births, breaks = 0.0, thresholds.isf(1.0 - rng.random(size))
    fresh = iter(thresholds.isf(1.0 - rng.random(20 * size)))
    heap = [(float(at), 0.0) for at in breaks]
    heapq.heapify(heap)
    found = []
    while True:
        at = heap[0][0]
        force = at - births / size
        drive = at + force / spring
        if drive > end:
            return np.array(found)
        position, holding = at, size
        while heap and heap[0][0] <= position + 1e-15:
            births -= heapq.heappop(heap)[1]
            holding -= 1
            position = max(at, (spring * size * drive + births) / (spring * size + holding))
        for _ in range(size - holding):
            heapq.heappush(heap, (position + float(next(fresh)), position))
        births += (size - holding) * position
        if size - holding > least * size:
            found.append((drive, position, force - spring * (drive - position)))


@pytest.mark.parametrize(("std", "spring"), [(0.05, 3.5), (0.2, 0.5)])
def test_reform_after_is_what_many_contacts_do(std, spring):
    law, end = origins.gaussian(1.0, std), 5.0
    solution = solve_soft(origins.Contacts(law), [0.0, end], spring, "reform-after")
    rng = np.random.default_rng(20100902)
    found = np.mean([avalanches(law, spring, end, 20_000, 0.2, rng) for _ in range(3)], axis=0)
    slips = solution.slips
    # finite numbers slip late, and scatter: by N^(-2/3) and N^(-1/2)
    assert np.abs(found[:, 0] - slips.drive).max() < 0.01
    assert np.abs(found[:, 1] - slips.after).max() < 0.03
    assert np.abs(found[:, 2] - slips.drop).max() < 0.03


def test_reform_after_keeps_slipping_where_instant_does_not():
    contacts, path = origins.Contacts(origins.gaussian(1.0, 0.2)), np.linspace(0.0, 20.0, 101)
    after = solve_soft(contacts, path, 0.5, "reform-after", 1e-6)
    assert after.regime.verdict == "stick-slip" and abs(after.regime.trend) < 1e-6
    assert solve_soft(contacts, path, 0.5, "instant", 1e-6).regime.verdict == "decaying transient"


# -- all rules ----------------------------------------------------------------------------------------------------


def test_all_rules_let_go_at_the_same_place():
    solutions = [solve_soft(origins.Contacts(NARROW, 0.1), [0.0, 2.5], 1.5, rule) for rule in RULES]
    first = [(s.slips.drive[0], s.slips.before[0], s.slips.force_before[0]) for s in solutions]
    assert np.ptp(np.array(first), axis=0).max() <= 1e-9


@pytest.mark.parametrize(
    ("law", "rule"), list(zip([NARROW, origins.rectangular(0.5, 1.5), origins.gw_elastic(1.0)], RULES, strict=True))
)
def test_a_stiff_spring_follows_the_rigid_curve_through_turns(law, rule):
    contacts = origins.Contacts(law, origins.gaussian_start(0.05, 0.03))
    drive = np.concatenate([np.linspace(0.0, 2.2, 30), np.linspace(2.1, -0.8, 30), np.linspace(-0.7, 0.9, 20)])
    solution = solve_soft(contacts, drive, 40.0, rule, 1e-8)
    assert solution.success and not solution.slips.drive.size
    assert np.abs(solution.force - 40.0 * (drive - solution.position)).max() <= 1e-12
    rigid = solve_cohorts(contacts, np.append(solution.position, 1.0), 1e-9)
    # the slider turns where the drive does: its own positions are the whole path
    turns = solve_soft(contacts, np.array([0.0, 2.2, -0.8, 0.9]), 40.0, rule, 1e-8)
    assert np.isin(turns.position.round(9), solution.position.round(9)).sum() >= 2
    assert np.abs(solution.force - rigid.force[:-1]).max() <= 3e-8 * contacts.mean_threshold


def test_a_spring_may_be_as_stiff_as_one_likes():
    contacts, drive = origins.Contacts(NARROW), np.linspace(0.0, 3.0, 31)
    rigid = master.solve(contacts, drive)
    solution = solve_soft(contacts, drive, 1e12, "instant", 1e-8)
    assert solution.success and not solution.slips.drive.size
    assert np.abs(solution.force - rigid.force).max() <= solution.force_error + rigid.force_error + 1e-10


@pytest.mark.parametrize("rule", RULES)
def test_the_mirror_image_of_a_drive(rule):
    path = np.concatenate([np.linspace(0.0, 4.0, 41), np.linspace(3.9, -3.0, 60)])
    one = solve_soft(origins.Contacts(origins.gaussian(1.0, 0.15), 0.1), path, 0.6, rule)
    other = solve_soft(origins.Contacts(origins.gaussian(1.0, 0.15), -0.1), -path, 0.6, rule)
    assert one.slips.drive.size >= 2
    assert np.abs(one.slips.drive + other.slips.drive).max() <= 1e-10
    assert np.abs(one.force + other.force).max() <= 1e-10


def test_the_drive_begins_where_it_balances_the_start():
    solution = solve_soft(origins.Contacts(origins.gaussian(1.0, 0.05), 0.3), [0.0, 0.1, 0.3], 2.0)
    # nothing breaks: F = 0.3 + X
    assert solution.position == pytest.approx((2.0 * solution.path - 0.3) / 3.0, abs=1e-12)


def test_lengths_only_set_the_scale():
    def solved(scale: float) -> SoftSolution:
        contacts = origins.Contacts(origins.gaussian(scale, 0.1 * scale), 0.05 * scale)
        return solve_soft(contacts, scale * np.linspace(0.0, 4.0, 21), 0.8, "reform-after")

    one = solved(1.0)
    for scale in (1e-9, 1e9):
        other = solved(scale)
        assert np.abs(other.force / scale - one.force).max() <= 1e-11
        assert np.abs(other.slips.drive / scale - one.slips.drive).max() <= 1e-11


def test_a_path_too_short_to_tell_says_so():
    solution = solve_soft(origins.Contacts(NARROW), [0.0, 0.5], 1.0)
    assert solution.regime.verdict == "undecided" and "before the first slip" in solution.regime.reason
    assert solution.period is None


def test_a_tolerance_beyond_reach_is_said():
    solution = solve_soft(origins.Contacts(NARROW), [0.0, 1.0, 3.0], 1.0, "reset", 1e-17)
    assert not solution.success and "above the tolerance 1.0e-17" in solution.message


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"spring": 0.0}, "spring = 0.0: must be above zero"),
        ({"spring": "stiff"}, "spring = 'stiff'"),
        ({"time": [0.0, 1.0, 2.0]}, "time = array of shape"),
        ({"time": [0.0, 0.0]}, r"time\[1\] = 0.0: leaves no time"),
        ({"time": [1.0, 0.5]}, r"time\[1\] = 0.5: is before time\[0\]"),
        ({"time": [0.0, 1.0], "velocity": 2.0}, "velocity = 2.0: the times of the points"),
        ({"velocity": 0.0}, "velocity = 0.0: must be above zero"),
        ({"slip": "relax"}, 'slip = \'relax\': must be "reset"'),
        ({"path": [0.0, np.inf]}, r"path\[1\]"),
        ({"tolerance": -1.0}, "tolerance = -1.0: must be above zero, such as 1e-8"),
        ({"spring": None, "slip": "instant"}, "slip = 'instant': is what a slip of a soft slider does, and without"),
    ],
)
def test_bad_input_is_refused_in_one_line(change, words):
    arguments = {"path": [0.0, 1.0], "spring": 1.0, **change}
    with pytest.raises(origins.InputError, match=words) as caught:
        master.solve(origins.Contacts(NARROW), **arguments)
    assert "\n" not in str(caught.value)
