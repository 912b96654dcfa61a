"""The master equation against every exact answer there is, on any path, from any start, to the tolerance asked."""

import numpy as np
import pytest
import scipy.stats
from phase_type import coxian, gaussian_force, hyper_erlang

import master
import origins

PATH = np.linspace(0.0, 5.0, 501)
SCENE = origins.Contacts(origins.gaussian(1.0, 0.05), origins.gaussian_start(0.0, 0.025))


def worst(solution, exact):
    return float(np.abs(solution.force - exact).max())


# -- closed forms ------------------------------------------------------------------------------------------------


def test_gaussian_scene():
    solution = master.solve(SCENE, PATH, tolerance=1e-9)
    assert solution.success
    assert worst(solution, gaussian_force(PATH, 1.0, 0.05, 0.0, 0.025)) <= 1e-10
    assert (solution.path == PATH).all()
    assert (solution.holding == 1.0).all()


@pytest.mark.parametrize("std", [0.02, 0.1])
@pytest.mark.parametrize(
    ("start", "start_std"), [(0.2, 0.03), (-0.2, 0.01), (0.1, 1e-6), (0.1, 1e-9), (0.25, 1e-9), (0.25, 0.0)]
)
def test_gaussian_thresholds_from_any_gaussian_start(std, start, start_std):
    contacts = origins.Contacts(origins.gaussian(1.0, std), origins.gaussian_start(start, start_std))
    path = np.linspace(0.0, 12.0, 241)
    solution = master.solve(contacts, path, 1e-10)
    assert worst(solution, gaussian_force(path, 1.0, std, start, start_std)) <= 1e-10
    assert solution.success


CHAINS = {
    "exponential": hyper_erlang([1.0], [1], [2.0]),
    "erlang": hyper_erlang([1.0], [5], [5.0]),
    "hyper-exponential": hyper_erlang([0.3, 0.7], [1, 1], [0.5, 5.0]),
    "hyper-erlang": hyper_erlang([0.2, 0.8], [4, 2], [8.0, 1.0]),
    "coxian": coxian(2.0, 0.7, 0.6),
}


@pytest.mark.parametrize("start", [0.0, 0.4, -0.3])
@pytest.mark.parametrize("name", CHAINS)
def test_phase_type_thresholds(name, start):
    chain = CHAINS[name]
    contacts = origins.Contacts(chain.law, start * chain.mean)
    path = np.concatenate([[0.0, 1e-7, 1e-3], np.linspace(0.01, 12.0, 150)]) * chain.mean
    solution = master.solve(contacts, path, 1e-9)
    assert solution.success
    error = worst(solution, chain.force(path, start * chain.mean)) / chain.mean
    assert error <= 1e-9
    assert error <= 2.0 * solution.force_error


def rectangular_force(path):
    """Thresholds uniform on (1/2, 3/2), relaxed, X <= 2: three generations and no fourth.

    Generation n releases the last of n equal stretches: by symmetry their mean, so <sum; sum <= X> / n.
    """
    box = np.clip(path - 0.5, 0.0, 1.0)
    second, later, third = (np.maximum(path - begin, 0.0) for begin in (1.0, 2.0, 1.5))
    return (
        path
        - box * (1.0 + box) / 2.0
        - (path * (second**2 - 2.0 * later**2) / 2.0 - second**3 / 6.0) / 2.0
        - (path * third**3 / 6.0 - third**4 / 24.0) / 3.0
    )


def test_rectangular_thresholds_by_generations():
    path = np.linspace(0.0, 2.0, 401)
    solution = master.solve(origins.Contacts(origins.rectangular(0.5, 1.5)), path, 1e-8)
    assert worst(solution, rectangular_force(path)) <= 1e-8
    assert solution.success


@pytest.mark.parametrize(
    "law",
    [
        origins.gaussian(1.0, 0.3),
        origins.gw_elastic(2.0),
        origins.gw_plastic(0.5),
        origins.lubricated(1.0),
        origins.persson(1.0, 1.0),
        origins.rectangular(0.0, 2.0),
        scipy.stats.gamma(2.5),
    ],
)
def test_steady_state_is_half_the_mean_square_over_the_mean(law):
    contacts = origins.Contacts(law, 0.1)
    law = contacts.thresholds
    solution = master.solve(contacts, np.array([0.0, 60.0]) * law.mean(), 1e-9)
    assert abs(solution.force[-1] - law.moment(2) / (2.0 * law.mean())) <= 1e-9 * law.mean()


# -- the singular limit ------------------------------------------------------------------------------------------


def test_identical_thresholds_are_a_sawtooth_for_ever():
    path = np.linspace(0.0, 50.0, 1001) + 0.01
    solution = master.solve(origins.Contacts(origins.identical(1.0)), path, 1e-9)
    assert solution.success
    assert worst(solution, path % 1.0) <= 1e-12
    at_break = master.solve(origins.Contacts(origins.identical(1.0)), np.arange(0.0, 51.0), 1e-9)
    assert worst(at_break, 0.0) <= 1e-12


def test_two_commensurate_values_are_a_sawtooth_for_ever():
    law = origins.mixture([origins.identical(0.95), origins.identical(1.05)], [0.5, 0.5])
    # whole numbers of their common divisor 0.05, one by one: 19 and 21 of them are the thresholds
    births, released = np.eye(1, 2_001)[0], np.zeros(2_001)
    for j in range(19, births.size):
        births[j] = 0.5 * (births[j - 19] + (births[j - 21] if j >= 21 else 0.0))
        released[j] = 0.5 * (0.95 * births[j - 19] + (1.05 * births[j - 21] if j >= 21 else 0.0))
    released = np.cumsum(released)
    for beyond in (0.0, 0.0123):
        path = 0.05 * np.arange(2_000) + beyond
        solution = master.solve(origins.Contacts(law), path, 1e-9)
        assert solution.success
        assert worst(solution, path - released[:-1]) <= solution.force_error
    # each breaks at a moment of its own, and so many moments are not followed one by one
    with pytest.raises(origins.InputError, match="exact values break together more often"):
        master.solve(origins.Contacts(law), [0.0, 1000.0], 1e-9)


def test_narrow_gaussian_is_not_damped_by_the_scheme():
    path = np.linspace(0.0, 50.0, 2001)
    solution = master.solve(origins.Contacts(origins.gaussian(1.0, 1e-3)), path, 1e-8)
    assert solution.success
    assert worst(solution, gaussian_force(path, 1.0, 1e-3)) <= 1e-8


@pytest.mark.parametrize("std", [0.05, 0.1])
def test_oscillations_decay_as_the_first_root_of_the_transform(std):
    path = np.linspace(0.0, 12.0 / std, 24001)
    force = master.solve(origins.Contacts(origins.gaussian(1.0, std)), path, 1e-11).force
    root = (1.0 - np.sqrt(1.0 - 4j * np.pi * std**2)) / std**2
    deviation = force - 0.5 * (1.0 + std**2)
    amplitude = np.array([np.abs(deviation[(path >= n) & (path < n + 1.0)]).max() for n in range(6, int(path[-1]))])
    kept = amplitude > 1e-8
    place = np.arange(6, int(path[-1]))[kept]
    late = place > place[-1] / 2
    rate = np.polyfit(place[late], np.log(amplitude[kept][late]), 1)[0]
    assert rate == pytest.approx(-abs(root.real), rel=2e-3)


# -- scale, paths, starts ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("scale", [1e-9, 1e9])
@pytest.mark.parametrize("start", [0.1, (0.02, 0.05)])
@pytest.mark.parametrize(
    "law",
    [
        lambda s: origins.gaussian(s, 0.1 * s),
        lambda s: origins.rectangular(0.5 * s, 1.5 * s),
        lambda s: origins.gw_elastic(s ** (-4.0 / 3.0)),
        lambda s: origins.mixture([origins.identical(0.8 * s), origins.gaussian(s, 0.1 * s)], [0.3, 0.7]),
    ],
)
def test_lengths_only_set_the_scale(law, start, scale):
    def solved(s):
        begin = s * start if isinstance(start, float) else origins.gaussian_start(s * start[0], s * start[1])
        return master.solve(origins.Contacts(law(s), begin), s * PATH[::10], 1e-8)

    one, other = solved(1.0), solved(scale)
    assert np.abs(other.force / scale - one.force).max() <= 1e-12
    # below round-off the estimate itself is noise
    assert other.force_error == pytest.approx(one.force_error, rel=1e-2, abs=2e-13)


def test_every_origin_meets_its_tolerance(every_origin):
    solution = master.solve(origins.Contacts(every_origin), np.linspace(0.0, 5.0, 501) * every_origin.mean(), 1e-8)
    assert solution.success
    assert solution.force_error <= 1e-8
    assert "within the tolerance" in solution.message


def every():
    samples = np.random.default_rng(3).gamma(4.0, 0.25, size=300)
    return {
        "identical": origins.identical(1.0),
        "gaussian": origins.gaussian(1.0, 0.05),
        "gaussian paper": origins.gaussian(1.0, 0.05, form="paper", upper=2.0),
        "rectangular": origins.rectangular(0.5, 1.5),
        "mixture": origins.mixture([origins.gaussian(0.5, 0.02), origins.gaussian(1.5, 0.05)], [0.4, 0.6]),
        "gap": origins.mixture([origins.rectangular(0.1, 0.2), origins.gaussian(1.5, 0.05)], [0.4, 0.6]),
        "gw_elastic": origins.gw_elastic(1.0),
        "gw_plastic": origins.gw_plastic(1.0),
        "persson": origins.persson(1.0, 0.5),
        "lubricated": origins.lubricated(1.0),
        "from_samples": origins.from_samples(samples),
        "atom beside": origins.mixture([origins.identical(0.8), origins.gaussian(1.0, 0.1)], [0.3, 0.7]),
        "frozen": origins.Contacts(scipy.stats.lognorm(0.5)).thresholds,
    }


@pytest.fixture(params=list(every()))
def every_origin(request):
    return every()[request.param]


@pytest.mark.parametrize(
    "path",
    [
        [0.0],
        [2.345],
        [0.0, 0.0, 0.0],
        [0.5, 0.5, 1.7, 1.7, 1.7, 3.0],
        [0.0, 300.0],
        [1e-300, 1e-12, 1.0],
        np.sort(np.random.default_rng(2).uniform(0.0, 8.0, 100_000)),
    ],
    ids=["origin", "one", "zeros", "repeated", "far", "tiny", "many"],
)
def test_any_path(path):
    solution = master.solve(SCENE, path, 1e-8)
    path = np.asarray(path)
    assert solution.success
    assert solution.force.shape == path.shape
    assert worst(solution, gaussian_force(path, 1.0, 0.05, 0.0, 0.025)) <= 1e-8


def first_generation(start: float, path: np.ndarray) -> np.ndarray:
    """F on rectangular(0.5, 1.5) from one stretch, before any contact can break twice: thresholds are uniform
    between the larger of 0.5 and |start| and 1.5, so a contact breaks evenly over X, and restarts at 0."""
    least = max(0.5, abs(start))
    onset, width = least - start, 1.5 - least
    broken = np.clip(path - onset, 0.0, width)
    reborn = ((path - onset) ** 2 - (path - onset - broken) ** 2) / (2.0 * width)
    return (start + path) * (1.0 - broken / width) + np.where(broken > 0.0, reborn, 0.0)


@pytest.mark.parametrize(
    "start", [origins.gaussian_start(1.3, 0.02), scipy.stats.uniform(-0.3, 0.6)], ids=["gaussian", "uniform"]
)
def test_spread_starts_on_a_bounded_law(start):
    contacts = origins.Contacts(origins.rectangular(0.5, 1.5), start)
    low, high = contacts.start.span
    # where |x| = 0.5 or a first break begins, the average over the start has a bend: many short panels
    path = np.linspace(0.0, 0.5, 21) if low > 0.5 else np.linspace(0.0, 0.65, 21)
    edges = np.linspace(low, high, 4001)
    nodes, weights = np.polynomial.legendre.leggauss(4)
    half = 0.5 * np.diff(edges)[:, None]
    x = (0.5 * (edges[1:] + edges[:-1])[:, None] + half * nodes).ravel()
    weight = (half * weights).ravel() * contacts.start.pdf(x)
    exact = sum(w * first_generation(one, path) for one, w in zip(x, weight, strict=True))
    found = master.solve(contacts, path, 1e-9)
    assert found.success
    assert np.abs(found.force - exact).max() <= found.force_error + 1e-8  # panels bent inside


@pytest.mark.parametrize(
    "law",
    [origins.gaussian(1.0, 0.05), origins.rectangular(0.5, 1.5), origins.gw_elastic(1.0), scipy.stats.gamma(0.5)],
)
def test_a_tolerance_beyond_reach_is_said(law):
    solution = master.solve(origins.Contacts(law, 0.1), PATH[::20], 1e-17)
    assert not solution.success
    assert solution.force_error > 1e-17
    assert "above the tolerance 1.0e-17" in solution.message
    assert np.isfinite(solution.force).all()
    assert np.abs(solution.force - master.solve(origins.Contacts(law, 0.1), PATH[::20], 1e-8).force).max() < 1e-8


def test_weight_cut_from_the_start_is_said():
    contacts = origins.Contacts(origins.rectangular(0.5, 1.5), origins.gaussian_start(1.4, 0.02))
    assert 0.0 < contacts.cut_weight < 1e-6
    assert "cut off" in master.solve(contacts, [0.0, 1.0]).message


@pytest.mark.parametrize("tolerance", [0.0, -1e-8, float("nan"), float("inf"), "1e-8", None, True])
def test_bad_tolerances_are_refused(tolerance):
    with pytest.raises(origins.InputError, match=r"^tolerance = "):
        master.solve(SCENE, PATH, tolerance)


# -- order of convergence ------------------------------------------------------------------------------------------


def test_a_path_beyond_numbers_is_refused():
    with pytest.raises(origins.InputError, match=r"path\[-1\] = 1e\+300: is 1e\+300 mean thresholds; follow at most"):
        master.solve(origins.Contacts(origins.gaussian(1.0, 0.05)), [0.0, 1e300])
