"""K* and F_s from polynomials on panels, against closed forms and exact first generations."""

import numpy as np
import pytest
import scipy.stats
from scipy.special import ndtr

from master.lives.make import life_of, steady_life
from master.steady.forward import births_table
from master.steady.travel import Travel
from master.stick_slip.extremes import Extremes, extremes
from master.stick_slip.phase_line import phase_line
from master.stick_slip.propensity import propensity
from origins import (
    Contacts,
    Delay,
    InputError,
    Thermal,
    gaussian,
    gaussian_start,
    gw_elastic,
    identical,
    lubricated,
    mixture,
    persson,
    rectangular,
)


def found(contacts: Contacts, tolerance: float = 1e-8, velocity: float = 1.0) -> Extremes:
    life = life_of(contacts)
    table = births_table(contacts, life, velocity, tolerance)
    return extremes(contacts, life, table, velocity, tolerance)


CLOSED = {
    # law, start, K*, F_s
    "uniform": (rectangular(0.0, 1.0), None, np.e - 2.0, None),
    "rectangle": (rectangular(0.5, 1.5), None, 7.0 / 8.0, 5.0 / 8.0),
    "narrow rectangle": (rectangular(0.9, 1.1), None, 4.5, None),
    "rectangle, from within": (rectangular(0.5, 1.5), 0.5, 7.0 / 8.0, 5.0 / 8.0),
    "exponential": (scipy.stats.expon(), None, 0.0, 1.0),
    "identical": (identical(1.3), None, np.inf, 1.3),
    "two values": (mixture([identical(1.0), identical(1.5)], [0.5, 0.5]), None, np.inf, 1.0),
    "one value, spread start": (
        identical(1.0),
        gaussian_start(0.0, 0.025),
        1.0 / (0.025 * np.sqrt(2.0 * np.pi)) - 1.0,
        None,
    ),
    "density that diverges": (scipy.stats.arcsine(0.5, 1.0), None, np.inf, None),
}


@pytest.mark.parametrize("name", CLOSED)
def test_closed_values(name: str) -> None:
    law, start, spring, static = CLOSED[name]
    told = found(Contacts(law, start))
    if np.isinf(spring):
        assert told.spring == np.inf and told.spring_error == 0.0
    else:
        assert abs(told.spring - spring) <= told.spring_error <= 1e-8 * (1.0 + spring)
    if static is not None:
        assert abs(told.static - static) <= told.static_error <= 1e-8


def largest(function, low: float, high: float) -> float:
    """Largest value, by zooming into the best of a fine grid."""
    for _ in range(6):
        x = np.linspace(low, high, 2001)
        at = int(function(x).argmax())
        low, high = x[max(at - 1, 0)], x[min(at + 1, 2000)]
    return float(function(x).max())


@pytest.mark.parametrize("law", [gaussian(1.0, 0.05), gaussian(1.0, 1e-3), persson(1.0, 0.3)])
def test_the_first_generation(law) -> None:
    """From a relaxed start, before a second break, F' = 1 - X P_c(X)."""
    steepest = largest(lambda x: x * law.pdf(x) - 1.0, 0.6, 1.4)
    told = found(Contacts(law))
    assert abs(told.spring - steepest) <= told.spring_error <= 1e-8 * (1.0 + steepest)


@pytest.mark.parametrize("std", [0.01, 0.05, 0.11])
def test_gaussian_thresholds_and_start_in_closed_form(std: float) -> None:
    first = 0.025
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

    told = found(Contacts(gaussian(1.0, std), gaussian_start(0.0, first)))
    assert (
        abs(told.spring - largest(fall, 0.5, 1.6)) <= told.spring_error <= 1e-8 * (1 + told.spring)
    )
    assert abs(told.static - largest(force, 0.5, 1.6)) <= told.static_error < 1e-8


@pytest.mark.parametrize("shape", [2.5, 10.0, 60.0])
def test_gamma_thresholds_as_sums_over_generations(shape: float) -> None:
    """Of n equal summands that add up to X each is X/n: F' = 1 - X sum over n of p_n(X)/n."""

    def fall(x: np.ndarray) -> np.ndarray:
        n = np.arange(1, 40)[:, None]
        return x * (scipy.stats.gamma.pdf(x, n * shape) / n).sum(axis=0) - 1.0

    told = found(Contacts(scipy.stats.gamma(shape)))
    steepest = max(largest(fall, 0.01 * shape, 2.0 * shape), 0.0)
    assert abs(told.spring - steepest) <= told.spring_error <= 1e-8 * (1.0 + steepest)


@pytest.mark.parametrize("form", ["soft", "stiff"])
def test_heat_before_a_second_break(form: str) -> None:
    """K* = max of x p(x) - 1 where none has broken twice, p from plain quadrature of E."""
    thermal = Thermal(form, 0.005)  # type: ignore[arg-type]
    law = gaussian(1.0, 0.05)
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
    best = x[fall(x).argmax()]
    steepest = top(fall, best)
    told = found(Contacts(law, thermal=thermal))
    assert abs(told.spring - steepest) <= told.spring_error + 1e-8
    assert told.spring_error < 1e-8 * (1.0 + told.spring)


def top(function, best: float) -> float:
    """Largest value beside a place, by a polynomial through points around it."""
    x = best + 0.012 * np.cos(np.pi * (np.arange(9) + 0.5) / 9.0)
    series = np.polynomial.chebyshev.Chebyshev.fit(x, function(x), 8)
    return largest(series, best - 0.012, best + 0.012)


def test_propensity_and_the_phase_line_tell_the_same() -> None:
    contacts = Contacts(gaussian(1.0, 0.1), 0.1, thermal=Thermal("soft", 0.02), delay=Delay(0.05))
    line = phase_line(contacts, [0.3, 3.0], temperature=[[0.0], [0.02]])
    assert line.success.all() and line.critical_spring.shape == (2, 2)
    for i, v in enumerate((0.3, 3.0)):
        told = propensity(contacts, velocity=v)
        off = abs(told.critical_spring - line.critical_spring[1, i])
        assert off <= told.critical_spring_error + line.critical_spring_error[1, i]
        assert told.success and told.static_to_kinetic >= 1.0
    cold = propensity(Contacts(gaussian(1.0, 0.1), 0.1, delay=Delay(0.05)), velocity=3.0)
    off = abs(cold.critical_spring - line.critical_spring[0, 1])
    assert off <= cold.critical_spring_error + line.critical_spring_error[0, 1]


def test_the_rule_of_thumb_is_read_off_the_onset() -> None:
    told = propensity(Contacts(lubricated(1.0)))
    assert told.onset_power == 3.0 and told.success
    assert told.critical_spring == pytest.approx(0.174, abs=1e-3)


def test_lives_that_are_not_followed_are_in_the_error() -> None:
    told = propensity(Contacts(scipy.stats.lomax(2.5)))
    assert told.critical_spring == 0.0 and told.critical_spring_error > 1e-6 and not told.success
    assert "only" in told.message


def test_what_has_no_ratio_is_refused() -> None:
    hot = Thermal("soft", 10.0, 1e3)
    with pytest.raises(InputError, match=r"ask master\.phase_line for K"):
        propensity(Contacts(gaussian(1.0, 0.05), thermal=hot, reforming=-0.3))
    with pytest.raises(InputError, match=r"<x_s\^2> is infinite"):
        propensity(Contacts(scipy.stats.lomax(1.5)))


def test_averages_over_a_start_are_not_followed_down_to_their_rounding() -> None:
    """A start around 0 of thresholds that begin there, with heat: 1,892 panels where 50 do."""
    contacts = Contacts(gw_elastic(1.0), gaussian_start(0.05, 0.03), thermal=Thermal("soft", 0.23, 5.6))
    life = steady_life(contacts, 1.0)
    table = Travel(life, contacts.start, 1.0, accuracy=1e-12).table
    assert table.begin.size < 200 and table.error < 2e-11
