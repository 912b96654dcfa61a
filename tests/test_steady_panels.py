"""Steady sliding from tables over the way, against closed forms and plain quadrature."""

import itertools

import numpy as np
import pytest
import scipy.stats
from rate_laws import Tilted
from scipy.special import gamma as gamma_function

from master.lives.make import life_of
from master.renewal.births import births_of
from master.steady.kinetic import kinetic_curve
from master.steady.steady import SteadyState, steady_state
from master.steady.travel import Travel
from origins import (
    Contacts,
    Delay,
    InputError,
    Thermal,
    gaussian,
    gaussian_start,
    identical,
    mixture,
    rectangular,
)

WIDE = rectangular(0.5, 1.5)


def found(contacts: Contacts, velocity: float = 1.0) -> SteadyState:
    state = steady_state(contacts, velocity=velocity)
    assert isinstance(state, SteadyState)
    return state


@pytest.mark.parametrize("shape", [0.7, 1.0, 4.0 / 3.0, 2.0, 8.0])
def test_weibull_thresholds(shape: float) -> None:
    """F_k = <x_s^2>/(2 <x_s>), linked <x_s^3>/(2 <x_s>^2), the moments being gamma functions."""
    law = scipy.stats.weibull_min(shape)
    first, second, third = (gamma_function(1.0 + n / shape) for n in (1, 2, 3))
    for stiffness, force in (
        ("independent", second / (2.0 * first)),
        ("linked", third / (2.0 * first**2)),
    ):
        state = found(Contacts(law, stiffness=stiffness))  # type: ignore[arg-type]
        assert abs(state.force - force) <= state.force_error * first + 4e-16 * force
        assert state.force_error < 1e-11


@pytest.mark.parametrize("r", [-0.3, 0.2, 0.7])
def test_births_at_one_stretch(r: float) -> None:
    """C and the integral of x E over a rectangle, from births within or below it."""
    low = max(abs(r), 0.5)
    held = 1.5 - low  # survival of the rectangle at |r|
    length = (low - r) + 0.5 * held
    tail = (1.5 * (1.5**2 - low**2) / 2.0 - (1.5**3 - low**3) / 3.0) / held
    area = 0.5 * (low**2 - r**2) + tail
    state = found(Contacts(WIDE, reforming=r, delay=Delay(0.1)))
    assert abs(state.force - area / (length + 0.1)) <= state.force_error + 1e-15
    assert state.cycle_length == pytest.approx(length, rel=1e-12)


def by_quadrature(contacts: Contacts, speed: float) -> float:
    """F_k by plain sums over thresholds and stretches of what still holds."""
    thermal, law = contacts.thermal, contacts.thresholds
    nodes, weights = np.polynomial.legendre.leggauss(24)
    nodes, weights = 0.5 * (nodes + 1.0), 0.5 * weights
    edges = np.linspace(*(float(law.ppf(1e-17)), float(law.isf(1e-17))), 21)
    width = np.diff(edges)[:, None]
    xi = (edges[:-1, None] + width * nodes).ravel()
    share = (width * weights).ravel() * law.pdf(xi) * contacts.relative_stiffness(xi)
    count = (width * weights).ravel() * law.pdf(xi)
    length, area = 0.0, 0.0
    cuts = 1.0 - np.linspace(1.0, 0.0, 41) ** 3  # close to the threshold
    for begin, end in itertools.pairwise(cuts):
        x = xi[:, None] * (begin + (end - begin) * nodes)
        spent = thermal.cumulative(x, xi[:, None], 0.0, contacts.relative_stiffness(xi)[:, None])
        held = np.exp(-spent / speed) * weights * xi[:, None] * (end - begin)
        length += float(count @ held.sum(axis=1))
        area += float(share @ (x * held).sum(axis=1))
    return area / length


@pytest.mark.parametrize("form", ["soft", "stiff"])
@pytest.mark.parametrize("stiffness", ["independent", "linked"])
@pytest.mark.parametrize("speed", [0.03, 3.0])
def test_heat_against_quadrature(form: str, stiffness: str, speed: float) -> None:
    thermal = Thermal(form, 0.05)  # type: ignore[arg-type]
    contacts = Contacts(gaussian(1.0, 0.1), thermal=thermal).replace(stiffness=stiffness)
    expected = by_quadrature(contacts, speed)
    state = found(contacts, speed)
    assert abs(state.force - expected) <= state.force_error + 1e-11
    curve = kinetic_curve(contacts, [speed, 10.0 * speed])
    assert abs(curve.force[0] - expected) <= curve.force_error[0] + 1e-11
    assert max(state.force_error, curve.force_error.max()) < 1e-10


def test_the_papers_closure_against_quadrature() -> None:
    """E = S exp(-integral of H/v), H summed over all thresholds beyond x."""
    thermal = Thermal("soft", 0.05, closure="paper")
    contacts = Contacts(gaussian(1.0, 0.1), thermal=thermal)
    law, speed = contacts.thresholds, 0.3
    nodes, weights = np.polynomial.legendre.leggauss(20)
    nodes, weights = 0.5 * (nodes + 1.0), 0.5 * weights
    edges = np.linspace(0.0, 1.9, 96)
    spent, length, area = 0.0, 0.0, 0.0
    primitive = np.polynomial.legendre.legvander(2.0 * nodes - 1.0, 19)
    to_series = np.linalg.inv(primitive)

    def mean_rate(x: np.ndarray) -> np.ndarray:
        cuts = x + (1.9 - x) * np.linspace(0.0, 1.0, 33)[:, None]
        xi = cuts[:-1, None] + (cuts[1:] - cuts[:-1])[:, None] * nodes[:, None]
        weight = (cuts[1:] - cuts[:-1])[:, None] * weights[:, None]
        return (weight * thermal.rate(np.minimum(x, xi), xi) * law.pdf(xi)).sum(axis=(0, 1))

    for begin, end in itertools.pairwise(edges):
        x = begin + (end - begin) * nodes
        rate = mean_rate(x)
        grown = np.polynomial.legendre.legint(to_series @ rate, lbnd=-1.0) * 0.5 * (end - begin)
        inside = spent + np.polynomial.legendre.legval(2.0 * nodes - 1.0, grown)
        held = law.sf(x) * np.exp(-inside / speed) * weights * (end - begin)
        length, area = length + held.sum(), area + (x * held).sum()
        spent += float(rate @ weights) * (end - begin)
    state = found(contacts, speed)
    assert abs(state.force - area / length) <= state.force_error + 1e-9


def test_the_slope_over_speed_of_a_rate_law_of_ones_own() -> None:
    """h = w exp[-(1 - x/x_s)/alpha]: dF_k/d ln v = alpha F_k(inf), within half a percent."""
    alpha = 0.03
    contacts = Contacts(gaussian(1.0, 0.2), thermal=Tilted(alpha, 1.0))
    speeds = alpha * np.geomspace(1e-4, 1e-2, 9)
    curve = kinetic_curve(contacts, speeds)
    slope = np.diff(curve.force) / np.diff(np.log(speeds))
    cold = found(Contacts(gaussian(1.0, 0.2))).force
    np.testing.assert_allclose(slope, alpha * cold, rtol=5e-3)
    single = found(contacts, float(speeds[4]))
    assert abs(single.force - curve.force[4]) <= single.force_error + curve.force_error[4] + 1e-14


@pytest.mark.parametrize(
    "contacts",
    [
        Contacts(WIDE),
        Contacts(mixture([identical(0.8), gaussian(1.3, 0.1)], [0.4, 0.6]), delay=Delay(0.2)),
        Contacts(gaussian(1.0, 0.1), thermal=Thermal("stiff", 0.05), delay=Delay(0.2)),
        Contacts(WIDE, reforming=gaussian_start(0.05, 0.1)),
    ],
    ids=["rectangle", "value and peak", "heat", "many births"],
)
def test_the_distribution_carries_what_holds_and_the_force(contacts: Contacts) -> None:
    state = found(contacts)
    marks = [-0.8, -0.5, 0.0, 0.5, 0.8, 1.5, 2.4]
    edges = np.unique(np.concatenate([np.linspace(-0.8, 2.4, 97), marks]))
    nodes, weights = np.polynomial.legendre.leggauss(10)
    half = 0.5 * np.diff(edges)[:, None]
    x = edges[:-1, None] + half * (1.0 + nodes)
    mass = half * weights * state.distribution(x)
    assert mass.sum() == pytest.approx(state.holding, abs=1e-8)
    assert (mass * x).sum() == pytest.approx(state.force, abs=1e-8)


def test_a_step_between_the_nodes_is_found() -> None:
    """All break within 2e-9 of one stretch, where no node of a wide panel sees them."""
    contacts = Contacts(rectangular(1.0 - 1e-9, 1.0 + 1e-9))
    table = Travel(life_of(contacts), births_of(contacts), 1.0)
    assert abs(table.length - 1.0) <= table.length_error < 1e-9
    ahead = Contacts(rectangular(1.0 - 1e-9, 1.0 + 1e-9), reforming=0.3)
    assert found(ahead).force == pytest.approx(0.65, abs=1e-9)


def test_what_has_no_steady_state_is_refused() -> None:
    with pytest.raises(InputError, match=r"<x_s\^2> is infinite"):
        steady_state(Contacts(scipy.stats.lomax(1.5)))
    with pytest.raises(InputError, match="velocity = 1e-170: contacts break before they have"):
        hot = Contacts(gaussian(1.0, 0.2), thermal=Thermal("soft", 0.1))
        steady_state(hot, velocity=1e-170)
