"""Stick-slip propensity against closed forms, many digits and a second road; and what it says of its own errors."""

from collections.abc import Callable
from dataclasses import dataclass
from math import comb

import mpmath
import numpy as np
import pytest
import scipy.stats
from counted_calls import CountedCalls
from scipy.special import gammainc, gammaln, ndtr

import master
import origins
from origins.errors import InputError
from origins.thresholds.quadrature import gauss, panel_edges

mp = mpmath.MPContext()
mp.dps = 22

Function = Callable[[int, np.ndarray], np.ndarray]


# -- K* and F_s/F_k ---------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Summed:
    """A law whose sums of n thresholds are known: from a relaxed start

    F'(X) = 1 - X sum over n of p_n(X)/n and F(X) = X - sum over n of <S_n; S_n < X>/n,

    since of n equal summands that add up to X each is X/n on average.
    """

    law: object
    mean: float
    square: float
    density: Function
    released: Function

    def force(self, x: np.ndarray) -> np.ndarray:
        return x - sum(self.released(n, x) / n for n in range(1, self._most(x)))

    def fall(self, x: np.ndarray) -> np.ndarray:
        return x * sum(self.density(n, x) / n for n in range(1, self._most(x))) - 1.0

    def _most(self, x: np.ndarray) -> int:
        variation = np.sqrt(self.square / self.mean**2 - 1.0)
        several = x.max() / self.mean
        return int(several + 9.0 * variation * (np.sqrt(several) + 9.0 * variation) + 4.0)


def gamma(shape: float) -> Summed:
    def density(n: int, x: np.ndarray) -> np.ndarray:
        return np.exp((n * shape - 1.0) * np.log(x) - x - gammaln(n * shape))

    def released(n: int, x: np.ndarray) -> np.ndarray:
        return n * shape * gammainc(n * shape + 1.0, x)

    return Summed(scipy.stats.gamma(shape), shape, shape * (shape + 1.0), density, released)


def gaussians(means: list[float], std: float, share: float) -> Summed:
    """One narrow Gaussian, or two of one width: sums are mixtures of Gaussians with binomial weights."""
    law = origins.gaussian(means[0], std)
    if len(means) == 2:
        law = origins.mixture([law, origins.gaussian(means[1], std)], [share, 1.0 - share])
    else:
        means, share = [means[0], means[0]], 1.0

    def parts(n: int, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        first = np.arange(n + 1 if share < 1.0 else 1)[:, None]
        weights = np.array([[comb(n, int(k)) * share**k * (1.0 - share) ** (n - k)] for k in first[:, 0]])
        weights = weights if share < 1.0 else np.ones((1, 1))
        centre, width = first * means[0] + (n - first) * means[1], std * np.sqrt(n)
        return weights, centre, width, (x - centre) / width

    def density(n: int, x: np.ndarray) -> np.ndarray:
        weights, _, width, z = parts(n, x)
        return (weights * np.exp(-0.5 * z * z)).sum(axis=0) / (width * np.sqrt(2.0 * np.pi))

    def released(n: int, x: np.ndarray) -> np.ndarray:
        weights, centre, width, z = parts(n, x)
        return (weights * (centre * ndtr(z) - width * np.exp(-0.5 * z * z) / np.sqrt(2.0 * np.pi))).sum(axis=0)

    mean = share * means[0] + (1.0 - share) * means[1]
    square = share * means[0] ** 2 + (1.0 - share) * means[1] ** 2 + std**2
    return Summed(law, mean, square, density, released)


def drawn(case: int) -> Summed:
    rng = np.random.default_rng([20100902, case])
    kind = case % 3
    if kind == 0:
        return gamma(float(np.exp(rng.uniform(np.log(2.2), np.log(60.0)))))
    std = float(np.exp(rng.uniform(np.log(0.005), np.log(0.11))))
    if kind == 1:
        return gaussians([1.0], std, 1.0)
    second = float(rng.uniform(1.1, 2.0))
    return gaussians([1.0, second], std, float(rng.uniform(0.1, 0.9)))


def largest(function: Callable[[np.ndarray], np.ndarray], grid: np.ndarray) -> float:
    """By brackets around the best points of a fine grid."""
    values = function(grid)
    best = float(values.max())
    for i in np.argsort(-values)[:4]:
        low, high = grid[max(i - 1, 0)], grid[min(i + 1, grid.size - 1)]
        for _ in range(8):
            finer = np.linspace(low, high, 21)
            values_here = function(finer)
            j = int(values_here.argmax())
            best, low, high = max(best, float(values_here[j])), finer[max(j - 1, 0)], finer[min(j + 1, 20)]
    return best


def test_claimed_errors_bound_the_true_ones() -> None:
    spring, static = [], []
    for case in range(60):
        exact = drawn(case)
        found = master.propensity(origins.Contacts(exact.law))
        grid = np.linspace(0.0, 3.2 * exact.mean, 1201)[1:]
        true_spring = max(largest(exact.fall, grid), 0.0)
        true_static = max(largest(exact.force, grid) * 2.0 * exact.mean / exact.square, 1.0)
        spring.append(abs(found.critical_spring - true_spring) / found.critical_spring_error)
        static.append(abs(found.static_to_kinetic - true_static) / found.static_to_kinetic_error)
        assert found.critical_spring_error <= 1.1e-8 * (1.0 + true_spring)
        assert found.static_to_kinetic_error <= 3e-8
    for ratio in (np.array(spring), np.array(static)):
        assert (ratio <= 1.0).sum() >= 59 and ratio.max() <= 2.0


CLOSED = {
    # law, start, K*, F_s/F_k
    "uniform": (origins.rectangular(0.0, 1.0), None, np.e - 2.0, None),
    "rectangular": (origins.rectangular(0.5, 1.5), None, 7.0 / 8.0, 15.0 / 13.0),
    "rectangular, narrow": (origins.rectangular(0.9, 1.1), None, 4.5, None),
    "rectangular, from within": (origins.rectangular(0.5, 1.5), 0.5, 7.0 / 8.0, 15.0 / 13.0),
    "exponential": (scipy.stats.expon(), None, 0.0, 1.0),
    "pareto": (scipy.stats.pareto(8.0), None, 7.0, None),
    "identical": (origins.identical(1.3), None, np.inf, 2.0),
    "identical, started at its half": (origins.identical(1.0), 0.5, np.inf, 2.0),
    "one value, spread start": (
        origins.identical(1.0),
        origins.gaussian_start(0.0, 0.025),
        1.0 / (0.025 * np.sqrt(2.0 * np.pi)) - 1.0,
        None,
    ),
    "two values": (origins.mixture([origins.identical(1.0), origins.identical(1.5)], [0.5, 0.5]), None, np.inf, None),
}


@pytest.mark.parametrize("name", CLOSED)
def test_closed_values(name: str) -> None:
    law, start, spring, static = CLOSED[name]
    found = master.propensity(origins.Contacts(law, start))
    if np.isinf(spring):
        assert found.critical_spring == np.inf and found.critical_spring_error == 0.0
    else:
        assert abs(found.critical_spring - spring) <= found.critical_spring_error <= 2e-8 * (1.0 + spring)
    if static is not None:
        assert abs(found.static_to_kinetic - static) <= found.static_to_kinetic_error <= 3e-8


@pytest.mark.parametrize("law", [origins.gaussian(1.0, 0.05), origins.persson(1.0, 0.3)], ids=["gaussian", "persson"])
def test_critical_spring_before_a_second_break(law: origins.Thresholds) -> None:
    x = np.linspace(0.5, 1.5, 20_001)
    true = largest(lambda x: x * law.pdf(x) - 1.0, x)
    found = master.propensity(origins.Contacts(law))
    assert abs(found.critical_spring - true) <= found.critical_spring_error <= 1e-9 * (1.0 + true)


def test_gaussian_start_against_the_closed_form() -> None:
    std, first = 0.05, 0.025
    n = np.arange(1, 12)[:, None]
    w = np.sqrt(n * std**2 + first**2)

    def bell(z: np.ndarray) -> np.ndarray:
        return np.exp(-0.5 * z * z) / np.sqrt(2.0 * np.pi)

    def force(x: np.ndarray) -> np.ndarray:
        z = (x - n) / w
        return x - (ndtr(z) - std**2 / w * bell(z)).sum(axis=0)

    def fall(x: np.ndarray) -> np.ndarray:
        z = (x - n) / w
        return (bell(z) / w * (1.0 + std**2 / w * z)).sum(axis=0) - 1.0

    x = np.linspace(0.0, 6.0, 6001)
    found = master.propensity(origins.Contacts(origins.gaussian(1.0, std), origins.gaussian_start(0.0, first)))
    assert abs(found.critical_spring - largest(fall, x)) <= found.critical_spring_error < 1e-9
    kinetic = 0.5 * (1.0 + std**2)
    assert abs(found.static_to_kinetic - largest(force, x) / kinetic) <= found.static_to_kinetic_error < 1e-9


SECOND_ROAD = {
    "gw_plastic": (origins.Contacts(origins.gw_plastic(1.251)), 5e-7),
    "lubricated": (origins.Contacts(origins.lubricated(1.0)), 5e-7),
    "persson among its thresholds": (origins.Contacts(origins.persson(1.0, 0.5), scipy.stats.uniform(-0.2, 0.9)), 1e-4),
    "start below zero": (origins.Contacts(origins.gaussian(1.0, 0.2), -0.5), 1e-6),
}


@pytest.mark.parametrize("name", SECOND_ROAD)
def test_slope_of_the_solved_force(name: str) -> None:
    contacts, allowed = SECOND_ROAD[name]
    path = np.linspace(0.0, 6.0 * contacts.mean_threshold, 24_001)
    force = master.solve(contacts, path, tolerance=1e-11).force
    step = path[1]
    # fourth-order central differences
    slope = (force[:-4] - 8.0 * force[1:-3] + 8.0 * force[3:-1] - force[4:]) / (12.0 * step)
    found = master.propensity(contacts)
    assert found.critical_spring == pytest.approx(-slope.min(), abs=allowed)
    steady = master.steady_state(contacts).force
    assert found.static_to_kinetic == pytest.approx(max(force.max() / steady, 1.0), abs=1e-6)


@pytest.mark.parametrize(
    ("contacts", "coarser", "finer"),
    [
        (
            origins.Contacts(
                origins.rectangular(0.0, 1.0593), start=-0.15676, thermal=origins.Thermal("soft", 0.81976, 0.0397)
            ),
            1e-8,
            2e-9,
        ),
        (
            origins.Contacts(origins.rectangular(0.5798, 0.8544), thermal=origins.Thermal("soft", 0.12534, 0.0559)),
            1e-8,
            1e-9,
        ),
        (
            origins.Contacts(
                origins.rectangular(0.0, 0.1867),
                start=-0.054203,
                thermal=origins.Thermal("stiff", 0.00864, 1.8918),
                delay=origins.Delay(0.06706),
            ),
            1e-7,
            1e-9,
        ),
    ],
    ids=["start below zero", "relaxed", "delay"],
)
def test_hot_rectangles_are_as_good_as_said(contacts: origins.Contacts, coarser: float, finer: float) -> None:
    """Their kinks may fall anywhere on a panel, as may the place of the maximum."""
    found, better = (master.propensity(contacts, tolerance) for tolerance in (coarser, finer))
    assert found.critical_spring_error <= coarser * (1.0 + found.critical_spring)
    assert better.critical_spring_error <= found.critical_spring_error
    met = better.critical_spring_error <= finer * (1.0 + better.critical_spring)
    assert better.success == met and "K* known to" in better.message
    off = abs(found.critical_spring - better.critical_spring)
    assert off <= found.critical_spring_error + better.critical_spring_error


# -- X* ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("std", [1e-3, 0.02, 0.05, 0.1])
def test_gaussian_decoherence_is_its_first_root(std: float) -> None:
    s = (1 - mp.sqrt(1 - 4j * mp.pi * mp.mpf(std) ** 2)) / mp.mpf(std) ** 2
    found = master.propensity(origins.Contacts(origins.gaussian(1.0, std)))
    true = abs(float(-1 / s.real) - found.decoherence_length)
    assert true <= found.decoherence_length_error + 1e-13 * found.decoherence_length
    assert found.decoherence_length_error < 1e-8 * found.decoherence_length


def rectangle(low: float, high: float) -> Callable[[mp.mpc], mp.mpc]:
    return lambda s: (mp.exp(-s * low) - mp.exp(-s * high)) / (s * (high - low))


def bell(mean: float, std: float) -> Callable[[mp.mpc], mp.mpc]:
    return lambda s: mp.exp(-s * mp.mpf(mean) + (s * mp.mpf(std)) ** 2 / 2)


def weibull(shape: mp.mpf, rate: float) -> Callable[[mp.mpc], mp.mpc]:
    """By quadrature over u = rate x^shape, which is exponential; u = t^4 makes its onset smooth for shape 4/3 and 2."""
    edges = [mp.mpf(k) / 2 for k in range(9)]

    def transform(s: mp.mpc) -> mp.mpc:
        def integrand(t: mp.mpf) -> mp.mpc:
            return mp.exp(-s * (t**4 / mp.mpf(rate)) ** (1 / shape) - t**4) * 4 * t**3

        return mp.quad(integrand, edges)

    return transform


ROOTS: dict[str, tuple[object, Callable[[mp.mpc], mp.mpc]]] = {
    "uniform": (origins.rectangular(0.0, 1.0), rectangle(0.0, 1.0)),
    "rectangular": (origins.rectangular(0.5, 1.5), rectangle(0.5, 1.5)),
    "gap": (
        origins.mixture([origins.rectangular(0.25, 0.5), origins.rectangular(1.0, 1.75)], [0.25, 0.75]),
        lambda s: rectangle(0.25, 0.5)(s) / 4 + 3 * rectangle(1.0, 1.75)(s) / 4,
    ),
    "two peaks": (
        origins.mixture([origins.gaussian(0.95, 1e-3), origins.gaussian(1.05, 1e-3)], [0.5, 0.5]),
        lambda s: (bell(0.95, 1e-3)(s) + bell(1.05, 1e-3)(s)) / 2,
    ),
    "value and gaussian": (
        origins.mixture([origins.identical(0.95), origins.gaussian(1.05, 0.1)], [0.25, 0.75]),
        lambda s: mp.exp(-s * mp.mpf(0.95)) / 4 + 3 * bell(1.05, 0.1)(s) / 4,
    ),
    "gamma 4.5": (scipy.stats.gamma(4.5), lambda s: (1 + s) ** mp.mpf(-4.5)),
    "gw_elastic": (origins.gw_elastic(1.588), weibull(mp.mpf(4) / 3, 1.588)),
    "gw_plastic": (origins.gw_plastic(1.251), weibull(mp.mpf(2), 1.251)),
}


@pytest.mark.parametrize("name", ROOTS)
def test_decoherence_is_a_root_in_many_digits(name: str) -> None:
    law, transform = ROOTS[name]
    contacts = origins.Contacts(law)
    found = master.propensity(contacts)
    # Newton from the nearest zero of 1 - p^ that lies at the rate found: on its vertical line |1 - p^| has a dip there
    rate = 1.0 / found.decoherence_length
    # 0.95 and 1.05 are multiples of 1/20: their slowest wave is the twentieth
    frequency = on_the_line(contacts, rate, 130.0 if name == "two peaks" else 20.0)
    near = mp.mpc(-rate, frequency)
    root = mp.findroot(lambda s: transform(s) - 1, (near, near * (1 + mp.mpf("1e-5"))), tol=1e-30)
    true = abs(float(-1 / root.real) - found.decoherence_length)
    assert true <= found.decoherence_length_error + 1e-13 * found.decoherence_length
    assert found.decoherence_length_error <= 1e-8 * found.decoherence_length


def test_known_decoherence_lengths() -> None:
    elastic = master.propensity(origins.Contacts(origins.gw_elastic(1.588)))
    assert elastic.decoherence_length == pytest.approx(0.292874352302624, rel=1e-13)
    narrow = master.propensity(origins.Contacts(ROOTS["two peaks"][0]))
    assert narrow.decoherence_length == pytest.approx(126.65, abs=0.005)


@pytest.mark.parametrize("shape", [2.0, 3.0, 3.9])
def test_tail_decides_where_no_root_is_slower(shape: float) -> None:
    # roots at -1 + e^(2 pi i n / shape), the law's own tail at 1
    found = master.propensity(origins.Contacts(scipy.stats.gamma(shape)))
    assert abs(found.decoherence_length - 1.0) <= found.decoherence_length_error <= 0.11


@pytest.mark.parametrize("law", [origins.identical(1.0), scipy.stats.lomax(2.5), scipy.stats.lognorm(0.5)])
def test_nothing_decays_exponentially(law: object) -> None:
    found = master.propensity(origins.Contacts(law))
    assert found.decoherence_length == np.inf and found.decoherence_length_error == 0.0


def transform_at(contacts: origins.Contacts, s: np.ndarray) -> np.ndarray:
    """p^(s) for s per length, by Gauss sums on the law's panels, halved so that waves are resolved."""
    law = contacts.thresholds
    edges = panel_edges(law)
    if not np.isfinite(law.support()[1]):
        edges = np.unique(np.concatenate([edges, law.isf(10.0 ** -np.arange(18.0, 60.0))]))
    pieces = np.maximum(np.ceil(np.diff(edges) * np.abs(s).max() / 1.5), 1).astype(int)
    edges = np.concatenate(
        [*(np.linspace(a, b, k + 1)[:-1] for a, b, k in zip(edges, edges[1:], pieces, strict=False)), edges[-1:]]
    )
    nodes, weights = gauss(edges[:-1], edges[1:])
    x, mass = nodes.ravel(), (weights * law.pdf(nodes)).ravel()
    x, mass = np.append(x, law.atoms[0]), np.append(mass, law.atoms[1])
    x, log_mass = x[mass > 0.0], np.log(mass[mass > 0.0])
    parts = np.array_split(s, max(1, s.size * x.size // 2_000_000))
    return np.concatenate([np.exp(log_mass - np.outer(part, x)).sum(axis=1) for part in parts])


def on_the_line(contacts: origins.Contacts, rate: float, top: float) -> float:
    frequency = np.linspace(0.5, top, 4001) / contacts.mean_threshold  # s = 0 is a root of every law
    return float(frequency[np.abs(1.0 - transform_at(contacts, -rate + 1j * frequency)).argmin()])


def slower_roots(contacts: origins.Contacts, rate: float, top: float) -> float:
    """Zeros of 1 - p^ with -rate < Re s, |Im s| < top (per mean threshold), s = 0 apart: the winding of 1 - p^."""
    vertical = np.linspace(-top, top, int(top * 160))
    horizontal = np.linspace(-rate, 0.5, 60)
    s = np.concatenate(
        [0.5 + 1j * vertical, horizontal[::-1] + 1j * top, -rate + 1j * vertical[::-1], horizontal - 1j * top]
    )
    value = 1.0 - transform_at(contacts, s / contacts.mean_threshold)
    turns = np.angle(value[1:] / value[:-1])
    assert np.abs(turns).max() < 2.9, "the contour is too coarse to tell"
    return float(turns.sum() / (2.0 * np.pi)) - 1.0


SLOWEST = {
    "uniform": origins.rectangular(0.0, 1.0),
    "gap": ROOTS["gap"][0],
    "gaussian": origins.gaussian(1.0, 0.3),
    "gw_elastic": origins.gw_elastic(1.588),
    "lubricated": origins.lubricated(1.0),
    "persson": origins.persson(1.0, 0.5),
    "ten times larger, rarely": origins.mixture([origins.gaussian(1.0, 0.05), origins.gaussian(10.0, 1.0)], [0.9, 0.1]),
    "hundred times larger, rarely": origins.mixture(
        [origins.gaussian(1.0, 0.05), origins.gaussian(100.0, 5.0)], [0.999, 0.001]
    ),
    "power law, cut off": scipy.stats.truncpareto(1.5, 100.0),
}
LOW = {"hundred times larger, rarely", "power law, cut off"}


@pytest.mark.parametrize("name", SLOWEST)
def test_no_root_is_slower(name: str) -> None:
    contacts = origins.Contacts(SLOWEST[name])
    rate = contacts.mean_threshold / master.propensity(contacts, 1e-6).decoherence_length
    top = 4.0 if name in LOW else 15.0
    assert slower_roots(contacts, 0.97 * rate, top) == pytest.approx(0.0, abs=1e-6)
    assert slower_roots(contacts, 1.03 * rate, top) >= 0.99


DECAYING = {
    "gaussian": (origins.gaussian(1.0, 0.1), 25.0),
    "gw_plastic": (origins.gw_plastic(1.251), 8.0),
    "persson": (origins.persson(1.0, 0.5), 30.0),
    "gap": (ROOTS["gap"][0], 15.0),
    "gamma 4.5": (scipy.stats.gamma(4.5), 5.0),
}


@pytest.mark.parametrize("name", DECAYING)
def test_solved_force_decays_at_that_rate(name: str) -> None:
    law, several = DECAYING[name]
    contacts = origins.Contacts(law)
    found = master.propensity(contacts)
    path = np.linspace(0.0, several * contacts.mean_threshold, 8001)
    solution = master.solve(contacts, path, tolerance=1e-11)
    off = solution.force - master.steady_state(contacts).force
    # a decaying wave: its turning points lie on the envelope
    turning = np.flatnonzero((np.abs(off[1:-1]) > np.abs(off[:-2])) & (np.abs(off[1:-1]) >= np.abs(off[2:]))) + 1
    late = turning[(path[turning] > 0.3 * path[-1]) & (np.abs(off[turning]) > 1e-8 * contacts.mean_threshold)]
    assert late.size >= 3
    slope = np.polyfit(path[late], np.log(np.abs(off[late])), 1)[0]
    assert -1.0 / slope == pytest.approx(found.decoherence_length, rel=0.01)


# -- scale, refusals --------------------------------------------------------------------------------------


@pytest.mark.parametrize("scale", [1e-9, 1e9])
def test_scale_of_lengths(scale: float) -> None:
    found = [
        master.propensity(
            origins.Contacts(origins.gaussian(unit, 0.05 * unit), origins.gaussian_start(0.1 * unit, 0.02 * unit))
        )
        for unit in (1.0, scale)
    ]
    one, other = found
    assert other.critical_spring == pytest.approx(one.critical_spring, rel=1e-11)
    assert other.static_to_kinetic == pytest.approx(one.static_to_kinetic, rel=1e-12)
    assert other.decoherence_length == pytest.approx(scale * one.decoherence_length, rel=1e-12)
    assert other.critical_spring_error < 1e-8 and other.static_to_kinetic_error < 1e-8


def test_onset_power_is_the_laws_own() -> None:
    found = master.propensity(origins.Contacts(origins.gw_elastic(1.588)))
    assert found.onset_power == pytest.approx(1.0 / 3.0) and found.onset_power_error == 0.0
    assert found.run_time > 0.0


def test_a_loose_tolerance_is_met_and_told() -> None:
    contacts = origins.Contacts(origins.rectangular(0.5, 1.5))
    loose = master.propensity(contacts, tolerance=1e-3)
    assert loose.success and "within 1.0e-03" in loose.message
    assert loose.critical_spring_error <= 1e-3 * (1.0 + 7.0 / 8.0)
    assert abs(loose.critical_spring - 7.0 / 8.0) <= loose.critical_spring_error


@pytest.mark.parametrize("law", [scipy.stats.lomax(1.5), scipy.stats.invgamma(1.5), scipy.stats.pareto(1.5)])
def test_infinite_mean_square_is_refused(law: object) -> None:
    with pytest.raises(InputError, match=r"<x_s.2> is infinite"):
        master.propensity(origins.Contacts(law))


@pytest.mark.parametrize("tolerance", [0.0, -1.0, np.nan, "fine"])
def test_bad_tolerance_is_refused(tolerance: object) -> None:
    with pytest.raises(InputError, match="tolerance = "):
        master.propensity(origins.Contacts(origins.identical(1.0)), tolerance)  # type: ignore[arg-type]


def test_a_density_that_nears_1_over_x_is_answered_or_refused() -> None:
    """Weight where floating point ends has no panels: the answer stops before, and at once."""
    steep = master.propensity(origins.Contacts(origins.lubricated(1.0, power=-0.9)), tolerance=1e-5)
    assert steep.critical_spring_error < 1e-5 and steep.static_to_kinetic_error < 1e-5
    # falls on with the power, to 1.4e-3 at -0.95
    assert 1.0 < steep.critical_spring / 1.4388917e-3 < 1.2
    for power in (-0.96, -0.99, -0.999):
        contacts = origins.Contacts(origins.lubricated(1.0, power=power))
        for solver in (master.propensity, lambda these: master.solve(these, np.linspace(0.0, 2.0, 11))):
            below = r"^thresholds: a weight of .* lies below 1e-290 of the mean"
            with CountedCalls() as told, pytest.raises(origins.InputError, match=below):
                solver(contacts)
            assert told.number < 100_000  # some ten thousand; of a lattice with all its weight, 300,000


def test_what_lives_of_all_lengths_do_beyond_the_last_stretch_followed_is_an_error() -> None:
    contacts = origins.Contacts(origins.gaussian(1.0, 0.2), thermal=origins.Thermal("stiff", 0.1, 1e8))
    found = master.propensity(contacts, 1e-4)
    solved = master.solve(contacts, np.linspace(0.0, 3.0, 1501))
    static = solved.force.max() / master.steady_state(contacts).force
    assert static > 1.0 + 1e-7  # F goes beyond F_k only where nearly all have broken thousands of times
    assert not found.success and " only, above " in found.message
    assert abs(found.static_to_kinetic - static) < found.static_to_kinetic_error < 1.0
    steepest = -np.diff(solved.force).min() / 2e-3
    assert abs(found.critical_spring - steepest) < found.critical_spring_error < 1.0


def test_few_that_live_for_thousands_of_means_are_told() -> None:
    """Two in ten thousand have a threshold of 1,250 means: met now and then they pile up, and break together."""
    hardly, much = origins.gaussian(0.003, 3e-4), origins.gaussian(5.0, 0.5)
    contacts = origins.Contacts(origins.mixture([hardly, much], [0.9998, 0.0002]))
    found = master.propensity(contacts, 1e-6)
    solved = master.solve(contacts, np.linspace(5.5, 5.7, 9), 1e-6)
    static = solved.force.max() / master.steady_state(contacts).force
    assert static > 1.1 and not found.success and "F_s known to" in found.message
    assert abs(found.static_to_kinetic - static) < found.static_to_kinetic_error < 1.0
    # the many decide how steeply F falls
    assert found.critical_spring_error < 1e-6


def test_what_may_come_beyond_the_last_stretch_followed_is_an_error() -> None:
    found = master.propensity(origins.Contacts(scipy.stats.lognorm(2.0)))
    assert found.critical_spring == 0.0 and 1e-6 < found.critical_spring_error < 2e-2


def test_a_steepest_fall_right_before_a_jump_is_not_passed_over() -> None:
    """Whatever point of the lattice falls on the bracket's other side."""
    warm = origins.Thermal("soft", temperature=2.2e-5, attempt_frequency=1e12)
    contacts, velocity = origins.Contacts(origins.persson(1.0, 0.5), thermal=warm), 0.10594630943592952
    found, close = (master.propensity(contacts, tolerance, velocity=velocity) for tolerance in (1e-8, 1e-10))
    off = abs(found.critical_spring - close.critical_spring)
    assert off <= found.critical_spring_error + close.critical_spring_error
    assert found.critical_spring_error < 1e-9 * (1.0 + found.critical_spring)


def test_what_is_not_known_well_enough_says_so() -> None:
    contacts = origins.Contacts(origins.gaussian(1.0, 0.3))
    found = master.propensity(contacts, 1e-6)
    assert found.success and found.message.startswith("K* known to ") and "only" not in found.message
    assert master.phase_line(contacts).success.all() and master.kinetic_curve(contacts).success.all()
    assert master.steady_state(contacts).success
    found = master.propensity(contacts, 1e-14)
    assert not found.success and "only, above 1.0e-14" in found.message
    line = master.phase_line(contacts, [1.0, 2.0], tolerance=1e-14)
    assert line.success.tolist() == [False, False] and " only at 2 of 2 points, above 1.0e-14" in line.message
