"""Stick-slip propensity against closed forms, many digits and a second road; and what it says of its own errors."""

from collections.abc import Callable
from dataclasses import dataclass

import mpmath
import numpy as np
import pytest
import scipy.stats
from counted_calls import CountedCalls
from scipy.special import gammainc, gammaln, ndtr

import master
import origins
from origins.errors import InputError

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


def gaussian(std: float) -> Summed:
    def parts(n: int, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        z = (x - n) / (std * np.sqrt(n))
        return z, np.exp(-0.5 * z * z) / np.sqrt(2.0 * np.pi)

    def density(n: int, x: np.ndarray) -> np.ndarray:
        return parts(n, x)[1] / (std * np.sqrt(n))

    def released(n: int, x: np.ndarray) -> np.ndarray:
        z, bell = parts(n, x)
        return n * ndtr(z) - std * np.sqrt(n) * bell

    return Summed(origins.gaussian(1.0, std), 1.0, 1.0 + std**2, density, released)


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
            best, low, high = (
                max(best, float(values_here[j])),
                finer[max(j - 1, 0)],
                finer[min(j + 1, 20)],
            )
    return best


def test_claimed_errors_bound_the_true_ones() -> None:
    spring, static = [], []
    rng = np.random.default_rng(20100902)
    for case in range(60):
        low, high = ((2.2, 60.0), (0.005, 0.11))[case % 2]
        parameter = float(np.exp(rng.uniform(np.log(low), np.log(high))))
        exact = (gamma, gaussian)[case % 2](parameter)
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
    "two values": (
        origins.mixture([origins.identical(1.0), origins.identical(1.5)], [0.5, 0.5]),
        None,
        np.inf,
        None,
    ),
    "density that diverges": (scipy.stats.arcsine(0.5, 1.0), None, np.inf, None),
}


@pytest.mark.parametrize("name", CLOSED)
def test_closed_values(name: str) -> None:
    law, start, spring, static = CLOSED[name]
    found = master.propensity(origins.Contacts(law, start))
    if np.isinf(spring):
        assert found.critical_spring == np.inf and found.critical_spring_error == 0.0
    else:
        assert (
            abs(found.critical_spring - spring)
            <= found.critical_spring_error
            <= 2e-8 * (1.0 + spring)
        )
    if static is not None:
        assert abs(found.static_to_kinetic - static) <= found.static_to_kinetic_error <= 3e-8


@pytest.mark.parametrize("form", ["soft", "stiff"])
def test_heat_before_a_second_break(form: str) -> None:
    """K* = max of x p(x) - 1 where none has broken twice, p from plain quadrature of E."""
    thermal = origins.Thermal(form, 0.005)  # type: ignore[arg-type]
    law = origins.gaussian(1.0, 0.05)
    nodes, weights = np.polynomial.legendre.leggauss(200)

    def held(x: np.ndarray) -> np.ndarray:
        # thresholds above x, in the root of the distance to it
        top = np.sqrt(1.45 - x)[:, None]
        root = 0.5 * top * (1.0 + nodes)
        xi = x[:, None] + root**2
        weight = top * weights * root * law.pdf(xi)
        return (weight * np.exp(-thermal.cumulative(x[:, None], xi))).sum(axis=1)

    def fall(x: np.ndarray) -> np.ndarray:
        h = 1e-3
        pairs = [(4.0 / 5.0, 1), (-1.0 / 5.0, 2), (4.0 / 105.0, 3), (-1.0 / 280.0, 4)]
        slope = sum(c * (held(x + k * h) - held(x - k * h)) for c, k in pairs) / h
        return -x * slope - 1.0

    x = np.linspace(0.8, 1.1, 31)
    around = x[fall(x).argmax()] + 0.012 * np.cos(np.pi * (np.arange(9) + 0.5) / 9.0)
    series = np.polynomial.chebyshev.Chebyshev.fit(around, fall(around), 8)
    told = master.propensity(origins.Contacts(law, thermal=thermal))
    off = abs(told.critical_spring - largest(series, np.linspace(around[-1], around[0], 2001)))
    assert off <= told.critical_spring_error + 1e-8 and told.success


def test_propensity_and_the_phase_line_tell_the_same() -> None:
    contacts = origins.Contacts(
        origins.gaussian(1.0, 0.1),
        0.1,
        thermal=origins.Thermal("soft", 0.02),
        delay=origins.Delay(0.05),
    )
    line = master.phase_line(contacts, [0.3, 3.0], temperature=[[0.0], [0.02]])
    assert line.success.all() and line.critical_spring.shape == (2, 2)
    for i, v in enumerate((0.3, 3.0)):
        told = master.propensity(contacts, velocity=v)
        off = abs(told.critical_spring - line.critical_spring[1, i])
        assert off <= told.critical_spring_error + line.critical_spring_error[1, i]
        assert told.success and told.static_to_kinetic >= 1.0
    cold = master.propensity(
        origins.Contacts(origins.gaussian(1.0, 0.1), 0.1, delay=origins.Delay(0.05)), velocity=3.0
    )
    off = abs(cold.critical_spring - line.critical_spring[0, 1])
    assert off <= cold.critical_spring_error + line.critical_spring_error[0, 1]


SECOND_ROAD = {
    "gw_plastic": (origins.Contacts(origins.gw_plastic(1.251)), 5e-7),
    "lubricated": (origins.Contacts(origins.lubricated(1.0)), 5e-7),
    "persson among its thresholds": (
        origins.Contacts(origins.persson(1.0, 0.5), scipy.stats.uniform(-0.2, 0.9)),
        1e-4,
    ),
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


def test_hot_rectangles_are_as_good_as_said() -> None:
    """Their kinks may fall anywhere on a panel, as may the place of the maximum."""
    law, hot = origins.rectangular(0.0, 0.1867), origins.Thermal("stiff", 0.00864, 1.8918)
    contacts = origins.Contacts(law, start=-0.054203, thermal=hot, delay=origins.Delay(0.06706))
    coarser, finer = 1e-7, 1e-9
    found, better = (master.propensity(contacts, tolerance) for tolerance in (coarser, finer))
    assert found.critical_spring_error <= coarser * (1.0 + found.critical_spring)
    assert better.critical_spring_error <= found.critical_spring_error
    met = better.critical_spring_error <= finer * (1.0 + better.critical_spring)
    assert better.success == met and "K* known to" in better.message
    off = abs(found.critical_spring - better.critical_spring)
    assert off <= found.critical_spring_error + better.critical_spring_error


# -- X* ---------------------------------------------------------------------------------------------------


def rectangle(low: float, high: float) -> Callable[[mp.mpc], mp.mpc]:
    return lambda s: (mp.exp(-s * low) - mp.exp(-s * high)) / (s * (high - low))


def bell(mean: float, std: float) -> Callable[[mp.mpc], mp.mpc]:
    return lambda s: mp.exp(-s * mp.mpf(mean) + (s * mp.mpf(std)) ** 2 / 2)


ROOTS: dict[str, tuple[object, Callable[[mp.mpc], mp.mpc]]] = {
    "gap": (
        origins.mixture(
            [origins.rectangular(0.25, 0.5), origins.rectangular(1.0, 1.75)], [0.25, 0.75]
        ),
        lambda s: rectangle(0.25, 0.5)(s) / 4 + 3 * rectangle(1.0, 1.75)(s) / 4,
    ),
    "value and gaussian": (
        origins.mixture([origins.identical(0.95), origins.gaussian(1.05, 0.1)], [0.25, 0.75]),
        lambda s: mp.exp(-s * mp.mpf(0.95)) / 4 + 3 * bell(1.05, 0.1)(s) / 4,
    ),
}


@pytest.mark.parametrize("name", ROOTS)
def test_decoherence_is_a_root_in_many_digits(name: str) -> None:
    law, transform = ROOTS[name]
    contacts = origins.Contacts(law)
    found = master.propensity(contacts)
    near = mp.mpc(master.decoherence_spectrum(contacts, n_roots=1).roots[0])
    root = mp.findroot(lambda s: transform(s) - 1, (near, near * (1 + mp.mpf("1e-5"))), tol=1e-30)
    true = abs(float(-1 / root.real) - found.decoherence_length)
    assert true <= found.decoherence_length_error + 1e-13 * found.decoherence_length
    assert found.decoherence_length_error <= 1e-8 * found.decoherence_length


# -- scale, refusals --------------------------------------------------------------------------------------


@pytest.mark.parametrize("scale", [1e-9, 1e9])
def test_scale_of_lengths(scale: float) -> None:
    found = [
        master.propensity(
            origins.Contacts(
                origins.gaussian(unit, 0.05 * unit), origins.gaussian_start(0.1 * unit, 0.02 * unit)
            )
        )
        for unit in (1.0, scale)
    ]
    one, other = found
    assert other.critical_spring == pytest.approx(one.critical_spring, rel=1e-11)
    assert other.static_to_kinetic == pytest.approx(one.static_to_kinetic, rel=1e-12)
    assert other.decoherence_length == pytest.approx(scale * one.decoherence_length, rel=1e-12)
    assert other.critical_spring_error < 1e-8 and other.static_to_kinetic_error < 1e-8


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
        for solver in (
            master.propensity,
            lambda these: master.solve(these, np.linspace(0.0, 2.0, 11)),
        ):
            below = r"^thresholds: a weight of .* lies below 1e-290 of the mean"
            with CountedCalls() as told, pytest.raises(origins.InputError, match=below):
                solver(contacts)
            assert (
                told.number < 100_000
            )  # some ten thousand; of a lattice with all its weight, 300,000


def test_what_lives_of_all_lengths_do_beyond_the_last_stretch_followed_is_an_error() -> None:
    contacts = origins.Contacts(
        origins.gaussian(1.0, 0.2), thermal=origins.Thermal("stiff", 0.1, 1e8)
    )
    found = master.propensity(contacts, 1e-4)
    solved = master.solve(contacts, np.linspace(0.0, 3.0, 1501))
    static = solved.force.max() / master.steady_state(contacts).force
    assert (
        static > 1.0 + 1e-7
    )  # F goes beyond F_k only where nearly all have broken thousands of times
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


def test_what_is_not_known_well_enough_says_so() -> None:
    contacts = origins.Contacts(origins.gaussian(1.0, 0.3))
    found = master.propensity(contacts, 1e-6)
    assert (
        found.success and found.message.startswith("K* known to ") and "only" not in found.message
    )
    assert (
        master.phase_line(contacts).success.all() and master.kinetic_curve(contacts).success.all()
    )
    assert master.steady_state(contacts).success
    found = master.propensity(contacts, 1e-14)
    assert not found.success and "only, above 1.0e-14" in found.message
    line = master.phase_line(contacts, [1.0, 2.0], tolerance=1e-14)
    assert (
        line.success.tolist() == [False, False]
        and " only at 2 of 2 points, above 1.0e-14" in line.message
    )


def test_the_rule_of_thumb_is_read_off_the_onset() -> None:
    told = master.propensity(origins.Contacts(origins.lubricated(1.0)))
    assert told.onset_power == 3.0 and told.success
    assert told.critical_spring == pytest.approx(0.174, abs=1e-3)


def test_what_has_no_ratio_is_refused() -> None:
    hot = origins.Thermal("soft", 10.0, 1e3)
    with pytest.raises(InputError, match=r"ask master\.phase_line for K"):
        master.propensity(
            origins.Contacts(origins.gaussian(1.0, 0.05), thermal=hot, reforming=-0.3)
        )
    with pytest.raises(InputError, match=r"<x_s\^2> is infinite"):
        master.propensity(origins.Contacts(scipy.stats.lomax(1.5)))
