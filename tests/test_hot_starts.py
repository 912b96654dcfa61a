"""Breaks far earlier than the longest lives: starts beside the thresholds in heat, laws of which a few are far stronger
than most, and short paths."""

from itertools import pairwise

import numpy as np
import pytest
import scipy.special
import scipy.stats
from scipy.integrate import quad

import master
from origins import Contacts, Delay, InputError, Thermal, gaussian, gaussian_start


def held(contacts: Contacts, x: float) -> float:
    """E(x) at v = 1, by quadrature over thresholds in the logarithm."""
    assert contacts.thermal is not None
    thermal = contacts.thermal
    edges = np.log(x) + np.concatenate([[0.0], np.geomspace(1e-4, 1.0, 9), np.arange(4.0, 32.0, 4.0)])

    def part(log: float) -> float:
        threshold = np.exp(log)
        return float(np.exp(-thermal.cumulative(x, threshold)) * contacts.thresholds.pdf(threshold) * threshold)

    return sum(quad(part, left, right, epsabs=1e-14, epsrel=1e-11)[0] for left, right in pairwise(edges))


@pytest.mark.filterwarnings("ignore:The integral is probably divergent")  # as it is
@pytest.mark.parametrize(
    "more",
    [
        {"thermal": Thermal("soft", 0.05, 0.05)},
        {"thermal": Thermal("soft", 0.05, 0.05, "paper"), "delay": Delay(0.1)},
        {"reforming": 0.1},
        {"reforming": gaussian_start(0.0, 0.05)},
        {"thermal": Thermal("stiff", 0.05), "reforming": gaussian_start(0.0, 0.05)},
        {"thermal": Thermal("stiff", 0.05), "stiffness": "linked"},
    ],
    ids=["soft", "paper", "again", "spread", "warm spread", "linked"],
)
def test_an_infinite_kinetic_force_is_told_with_every_law(more: dict[str, object]) -> None:
    power = 3 if "stiffness" in more else 2
    contacts = Contacts(scipy.stats.lomax(power - 0.1), **more)  # type: ignore[arg-type]
    for asked in (master.steady_state, master.kinetic_curve, master.propensity):
        with pytest.raises(InputError, match=rf"^thresholds: <x_s\^{power}> is infinite"):
            asked(contacts)  # type: ignore[operator]


@pytest.mark.parametrize(("start", "again"), [(1.05, 0.0), (-1.05, 0.0), (1.05, 0.1)])
def test_contacts_that_break_as_they_start_were_born_there(start: float, again: float) -> None:
    # within 1e-5 all have broken, and stand where they form again
    def force(begin: float) -> np.ndarray:
        contacts = Contacts(gaussian(1.0, 0.02), begin, thermal=Thermal("soft", 0.01, 1e10), reforming=again or None)
        solution = master.solve(contacts, path, 2e-4)
        assert solution.success
        return solution.force

    path = np.linspace(0.01, 1.5, 20)
    np.testing.assert_allclose(force(start), force(again), rtol=0.0, atol=1e-4)


def test_contacts_that_form_again_behind_and_break_at_once_bear_less_than_nothing() -> None:
    # after a short life each waits for 1: those that hold stand at -0.3
    thermal = Thermal("soft", 0.5, 1e6)
    contacts = Contacts(gaussian(1.0, 0.05), thermal=thermal, reforming=-0.3, delay=Delay(1.0))
    steady = master.steady_state(contacts)
    assert steady.force / steady.holding == pytest.approx(-0.3, abs=1e-4)
    with pytest.raises(InputError, match=r"^reforming: contacts form again behind x = 0 and bear -"):
        master.propensity(contacts)


@pytest.mark.parametrize(("power", "temperature", "attempts"), [(2.05, 1e-3, 1.0), (2.1, 1e-6, 1e12)])
def test_a_force_that_is_nearly_infinite_keeps_its_far_tail(power: float, temperature: float, attempts: float) -> None:
    """<x_s^2> in closed form less what contacts lose that break below their thresholds, which converges fast."""
    velocity, a = 0.69, np.sqrt(0.5 / temperature)
    nodes, shares = np.polynomial.legendre.leggauss(20)

    def gauss(edges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        half = 0.5 * np.diff(edges, axis=-1)[..., None]
        at = edges[..., :-1, None] + half * (1.0 + nodes)
        return at.reshape(*edges.shape[:-1], -1), (half * shares).reshape(*edges.shape[:-1], -1)

    log, weight = gauss(np.linspace(np.log(1e-8), np.log(1e5), 60))
    limit = np.exp(log)
    high = limit[:, None]
    layer = temperature / high * np.concatenate([[0.0], np.linspace(0.5, 60.0, 40), np.geomspace(70.0, 1e4, 12)])
    below, width = gauss(np.sort(np.minimum(np.hstack([layer, high * np.geomspace(1e-10, 1.0, 25)]), high)))
    x = high - below
    spent = attempts / (a * velocity) * np.exp(-(a * a) * below * (high + x)) * scipy.special.dawsn(a * x)
    lost = -np.expm1(-spent) * width
    mass = weight * limit * power * (1.0 + limit) ** (-power - 1.0)
    first = 1.0 / (power - 1.0) - mass @ lost.sum(axis=1)
    second = 1.0 / ((power - 1.0) * (power - 2.0)) - mass @ (lost * x).sum(axis=1)
    law = scipy.stats.lomax(power)
    state = master.steady_state(Contacts(law, thermal=Thermal("soft", temperature, attempts)), velocity=velocity)
    # the tail beyond the table is missed, and all in the claim
    assert not state.success
    assert abs(state.force - second / first) <= state.force_error * law.mean()


def test_a_spread_start_far_beyond_where_new_contacts_break_in_heat() -> None:
    thermal, law, start = Thermal("stiff", 0.2, 1e10), gaussian(1.0, 0.08), gaussian_start(0.05, 0.03)
    contacts = Contacts(law, start, thermal=thermal)
    longest = 6e-9
    path = np.geomspace(1e-3 * longest, longest, 12)
    solution = master.solve(contacts, path, 1e-8)
    nodes, weights = np.polynomial.legendre.leggauss(200)
    origins, thresholds = 0.05 + 0.25 * nodes, 1.0 + 0.65 * nodes[:, None]
    held = np.exp(-np.stack([thermal.cumulative(origins + x, thresholds, origins) for x in path]))
    plain = (0.65 * weights * law.pdf(thresholds[:, 0])) @ held @ (0.25 * weights * start.pdf(origins) * origins)
    # what later contacts bear is below the path's length
    assert np.abs(solution.force - plain).max() <= solution.force_error + 2.0 * longest
    assert solution.success and solution.force_error < 1e-8
