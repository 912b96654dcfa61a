"""K*, F_s/F_k and X* against closed forms, many digits and a second road; the phase line; v_c."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import mpmath
import numpy as np
import pytest
import scipy.stats
from scipy.special import gammainc, gammaln, ndtr

import master
import origins
from origins import Ageing, Contacts, Thermal

Function = Callable[[int, np.ndarray], np.ndarray]


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


mp = mpmath.MPContext()
mp.dps = 22


def bell(mean: float, std: float) -> Callable[[mp.mpc], mp.mpc]:
    return lambda s: mp.exp(-s * mp.mpf(mean) + (s * mp.mpf(std)) ** 2 / 2)


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
    for case in range(12):
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
        assert (ratio <= 1.0).sum() >= 11 and ratio.max() <= 2.0


CLOSED = {
    # law, start, K*, F_s/F_k
    "uniform": (origins.rectangular(0.0, 1.0), None, np.e - 2.0, None),
    "rectangular": (origins.rectangular(0.5, 1.5), None, 7.0 / 8.0, 15.0 / 13.0),
    "rectangular, from within": (origins.rectangular(0.5, 1.5), 0.5, 7.0 / 8.0, 15.0 / 13.0),
    "exponential": (scipy.stats.expon(), None, 0.0, 1.0),
    "pareto": (scipy.stats.pareto(8.0), None, 7.0, None),
    "identical": (origins.identical(1.3), None, np.inf, 2.0),
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
    assert (
        np.abs(line.critical_spring[:, 0] - cold) <= line.critical_spring_error[:, 0] + 1e-8
    ).all()
    for i, j in ((0, 2), (1, 1)):
        warm = Contacts(NARROW, thermal=Thermal("soft", float(temperatures[j])))
        single = master.propensity(warm, velocity=float(speeds[i]))
        off = abs(line.critical_spring[i, j] - single.critical_spring)
        assert off <= line.critical_spring_error[i, j] + single.critical_spring_error < 1e-5
        path = np.linspace(0.9, 1.1, 2001)
        force = master.solve(warm, path, 1e-10, velocity=float(speeds[i])).force
        assert single.critical_spring == pytest.approx(
            -np.diff(force).min() / (path[1] - path[0]), rel=1e-5
        )


def test_slow_contacts_age_and_let_go_more_steeply() -> None:
    # the laws of Fig. A06; where ageing ends stick-slip is found by another road
    contacts = Contacts(FRESH, 0.02, ageing=Ageing(origins.gaussian(1.0, 0.02), 5e-4))
    line = master.phase_line(contacts, [2.0, 4.0], tolerance=1e-5)
    assert line.critical_spring[0] > line.critical_spring[1] + 0.1
    critical = master.critical_velocity(contacts, float(line.critical_spring[1]), 3.9, 4.1)
    slope = abs(line.critical_spring[1] - line.critical_spring[0]) / 2.0
    assert (
        abs(critical.velocity - 4.0)
        <= critical.velocity_error + 2.0 * line.critical_spring_error[1] / slope
    )
    assert critical.velocity_error < 0.01


FRESH = origins.gaussian(0.5, 0.05)


def figure_a06(closure: str) -> Contacts:
    ageing = Ageing(origins.gaussian(1.0, 0.02), 5e-4, closure=closure)
    return Contacts(FRESH, origins.gaussian_start(0.02, 0.01), ageing=ageing)


def test_propensity_tells_the_same_spring() -> None:
    """At v_c the critical spring is the one that v_c was found for; it reads F(X), whose slowest decay is X*."""
    contacts = figure_a06("exact")
    told = master.propensity(contacts, velocity=4.253078)
    assert (
        told.critical_spring == pytest.approx(3.5, abs=1e-6) and told.critical_spring_error < 3e-7
    )
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
