"""The turn of a slider with mass within one step of its integrator: wherever it lies, in any unit of time."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.polynomial.chebyshev import chebval
from scipy.integrate import DOP853

from master.soft.inertia.moving import COEFFICIENTS, POINTS, Step

# A step of one unit of time, and one of 1e-6, as of stiff contacts in SI units.
UNITS = [1.0, 1e-6]
# Parts of a step at which the slider all but rests, some in its first and last sixteenth.
DIPS = [0.01, 0.02, 0.05, 0.07, 0.2, 0.31, 0.5, 0.64, 0.83, 0.93, 0.95, 0.98, 0.99]


def one_step(speed: float, push: Callable[[float], float], lasts: float) -> Step:
    """A step of the integrator on a force that is a polynomial of time, which it meets to rounding."""

    def change(t: float, state: np.ndarray) -> np.ndarray:
        return np.array([state[1], push(t), 0.0, 0.0, 0.0])

    state = np.array([0.0, speed, 0.0, 0.0, 0.0])
    solver = DOP853(change, 0.0, state, lasts, first_step=lasts, rtol=1.0, atol=1.0)
    solver.step()
    assert solver.t == lasts
    return Step(0.0, 0.0, lasts, solver.y, solver.dense_output())


def parabola(dip: float, deep: float, lasts: float) -> Step:
    """The speed ((t / lasts - dip)² - deep) / lasts: below 0 for a part 2 deep^(1/2) of the step."""
    return one_step((dip**2 - deep) / lasts, lambda t: 2.0 * (t / lasts - dip) / lasts**2, lasts)


@pytest.mark.parametrize("lasts", UNITS)
@pytest.mark.parametrize("dip", DIPS)
@pytest.mark.parametrize("deep", [1e-8, 1e-6, 2.5e-5])
def test_a_turn_is_found_wherever_it_lies(lasts: float, dip: float, deep: float) -> None:
    """In closed form; and where the speed only comes near to 0 there is none."""
    found = parabola(dip, deep, lasts).turns_back(at_rest=False)
    assert found is not None
    assert abs(found / lasts - (dip - np.sqrt(deep))) < 1e-9
    assert parabola(dip, -deep, lasts).turns_back(at_rest=False) is None


@pytest.mark.parametrize("lasts", UNITS)
def test_drawn_turns_in_any_unit_of_time(lasts: float) -> None:
    """200 drawn places and depths of the dip."""
    rng = np.random.default_rng(5)
    for dip, tens in rng.uniform([0.011, -8.0], [0.989, -4.0], (200, 2)):
        deep = 10.0**tens
        found = parabola(dip, deep, lasts).turns_back(at_rest=False)
        assert found is not None, (dip, deep)
        assert abs(found / lasts - (dip - np.sqrt(deep))) < 1e-9


@pytest.mark.parametrize("lasts", UNITS)
def test_the_first_of_two_turns_is_found_where_both_lie_near_an_end(lasts: float) -> None:
    """The speed is (x - 0.010)(x - 0.012)(x - 0.98)(x - 0.99), x the part of the step."""
    speed = np.poly1d([0.010, 0.012, 0.98, 0.99], r=True) / lasts
    push = speed.deriv()
    step = one_step(float(speed(0.0)), lambda t: float(push(t / lasts)) / lasts, lasts)
    found = step.turns_back(at_rest=False)
    assert found is not None
    assert abs(found / lasts - 0.010) < 1e-9


@pytest.mark.parametrize("lasts", UNITS)
def test_a_slider_that_starts_from_rest_turns_at_its_next_rest(lasts: float) -> None:
    """The speed is x (x - 0.02)(x - 0.03): 0 at the beginning, which is no turn."""
    speed = np.poly1d([0.0, 0.02, 0.03], r=True) / lasts
    push = speed.deriv()
    step = one_step(0.0, lambda t: float(push(t / lasts)) / lasts, lasts)
    found = step.turns_back(at_rest=True)
    assert found is not None
    assert abs(found / lasts - 0.02) < 1e-9


def test_the_speed_within_a_step_is_a_polynomial_of_this_degree() -> None:
    """Of the integrator's own interpolant, on a force that is none."""
    inside = one_step(1.0, lambda t: float(np.sin(9.0 * t) - np.exp(t)), 1.0).inside
    between = np.linspace(-1.0, 1.0, 101)
    speed = chebval(between, COEFFICIENTS @ inside(np.linspace(0.0, 1.0, POINTS))[1])
    np.testing.assert_allclose(speed, inside(0.5 * (between + 1.0))[1], atol=1e-14)
