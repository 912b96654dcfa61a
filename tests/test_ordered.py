"""Laws of one's own by which thresholds change with age and distance and keep their order: both solvers follow them
alike and as the closed form says, or refuse them in one line."""

from __future__ import annotations

from typing import ClassVar

import numba
import numpy as np
import pytest
from solving import gauss

import eq_model
import master
import origins
from origins import Contacts, InputError, OrderedThresholds

PC = origins.gaussian(mean=1.0, std=0.2)
# a turn in the first life of most, a rest, a turn to the other side, and a slow leg
PATH, CLOCK = [0.5, 0.5, 1.4, 0.6, -1.2, -1.0], [0.5, 4.5, 5.4, 7.0, 9.0, 14.0]


class Law(OrderedThresholds):
    """A law by a function alone."""

    def __init__(self, name, function, largest=lambda duration: 1.0):
        self.law, self.birth_threshold = name, function
        self.at_start, self.largest = PC, largest

    def birth_threshold(self, x, age, travelled):
        """Another in each object."""

    def largest_threshold(self, fresh, share, duration):
        return self.largest(duration) * fresh


def weak(x, age, travelled):
    return x * np.exp(np.minimum(age / 5.0, 600.0))


def worn(x, age, travelled):
    """x_s0 - 0.2 of the distance."""
    return x + 0.2 * travelled


def to_plateau(x, age, travelled):
    """x_s0 (1 + age/4), up to 1.5 x_s0."""
    return x / np.minimum(1.0 + age / 4.0, 1.5)


def healed_and_worn(x, age, travelled):
    """x_s0 (1 + 0.1 ln(1 + age)) e^(-distance/3): one strengthens and the other weakens."""
    return x * np.exp(travelled / 3.0) / (1.0 + 0.1 * np.log(1.0 + age))


def to_one(x, age, travelled):
    """All thresholds tend to 0.5: stronger contacts weaken and weaker ones strengthen."""
    return np.maximum(0.5 + (x - 0.5) * np.exp(np.minimum(age / 3.0, 600.0)), 0.0)


LAWS = [
    Law("weak", weak),
    Law("worn", worn),
    Law("to plateau", to_plateau, lambda duration: 1.5),
    Law("healed and worn", healed_and_worn, lambda duration: 1.0 + 0.1 * np.log(1.0 + duration)),
    Law("to one", to_one, lambda duration: 1.0),
]
by_name = pytest.mark.parametrize("law", LAWS, ids=[law.law for law in LAWS])


@by_name
@pytest.mark.parametrize("velocity", [0.1, 2.0])
def test_steady_sliding_is_a_quadrature(law, velocity):
    """E = S of the largest birth_threshold up to x, which rises with x here."""
    x, weights = gauss(np.linspace(0.0, 4.0, 801), 5)
    held = weights * PC.sf(law.birth_threshold(x, x / velocity, x))
    found = master.steady_state(Contacts(law), velocity=velocity)
    assert abs(found.force - float(held @ x / held.sum())) < 1e-6 and found.force_error < 1e-7


@pytest.mark.slow
@by_name
@pytest.mark.parametrize(("start", "delay"), [(0.0, 0.0), (-0.3, 0.2)])
def test_the_ensemble_agrees(law, start, delay):
    """On a path that rests and turns, at all points, whether numba has compiled the law or not."""
    quick = Law(law.law, numba.njit(law.birth_threshold), law.largest)
    contacts = [Contacts(each, start, delay=origins.Delay(delay)) for each in (law, quick)]
    exact = master.solve(contacts[0], PATH, 1e-5, time=CLOCK)
    assert exact.success
    few = [
        eq_model.simulate(each, PATH, time=CLOCK, n_contacts=100, seed=3).force for each in contacts
    ]
    assert (few[0] == few[1]).all()
    for count in (1000, 30_000):
        found = eq_model.simulate(contacts[1], PATH, time=CLOCK, n_contacts=count, seed=3)
        off = found.force - exact.force
        assert (np.abs(off) < 4.5 * np.hypot(found.force_standard_error, exact.force_error)).all()
        assert np.abs(found.holding - exact.holding).max() < 4.5 * np.sqrt(0.25 / count)


@pytest.mark.slow
def test_a_law_stated_by_its_order_is_that_stated_by_its_factor():
    """Growth is the same by any of the classes."""

    class Power(origins.ProportionalGrowth):
        law = "power"

        def factor(self, age):
            return (1.0 + np.asarray(age)) ** 0.3

    def power(x, age, travelled):
        return x / (1.0 + age) ** 0.3

    laws = Power(PC, 1.0), Law("power", power, lambda duration: (1.0 + duration) ** 0.3)
    one, other = (master.solve(Contacts(law), PATH, 1e-7, time=CLOCK).force for law in laws)
    assert np.abs(one - other).max() < 1e-7


@pytest.mark.slow
def test_histograms_count_thresholds_as_they_are_then():
    """At rest on a slider that has not moved none breaks, and all thresholds are e^(-1/5) times those of P_c."""
    law = Law("weak", numba.njit(weak))
    found = eq_model.simulate(
        Contacts(law), [0.01], time=[1.0], n_contacts=20_000, seed=1, histograms=[0]
    )
    seen = found.histograms[0]
    widths, middle = np.diff(seen.threshold_edges), seen.threshold_edges[1:] - 5e-4
    mean = float(seen.thresholds @ (widths * middle))
    assert mean == pytest.approx(np.exp(-0.2), abs=0.005)


@pytest.mark.parametrize(
    ("law", "says"),
    [
        (Law("a", lambda x, age, way: x + 1.0 + age), r"birth_threshold\(0.5347, 0, 0\) is 1.535, and must be 0.5"),
        (Law("a", lambda x, age, way: float(x)), "arrays of one shape, and return that; .* ends in TypeError"),
        (Law("a", lambda x, age, way: np.ravel(x)), r"for the shape \(2, 3, 1\) it returns \(6,\)"),
        (Law("a", lambda x, age, way: x * np.cos(age)), "must be from 0, where all hold, to inf|rises and falls"),
        (Law("a", lambda x, age, way: x * (1.0 + 0.1 * np.sin(age))), "rises and falls with the age"),
        (Law("a", lambda x, age, way: x * (1.0 + 0.1 * np.sin(way))), "rises and falls with the distance"),
        (Law("a", lambda x, age, way: np.maximum(x, np.minimum(age, 1.0) * (2.0 - x))), "falls with x"),
        (Law("a", lambda x, age, way: x * np.exp(1e3 * age)), "is nan, and must be from 0, where all hold, to inf"),
        (Law("a", to_plateau), r"largest_threshold\(0.5347, ..., 14\) is 0.5347, and by birth_thr"),
    ],
)  # fmt: skip
def test_a_law_that_contradicts_its_class_is_refused_by_both_solvers_in_one_line(law, says):
    for solve in (master.solve, eq_model.simulate):
        with pytest.raises(InputError, match=says) as refused:
            solve(Contacts(law), PATH, time=CLOCK)
        assert "\n" not in str(refused.value)


class AllowsHeat(Law):
    apart: ClassVar = {}


class Older(Law):
    older_at_start = True


@pytest.mark.parametrize(
    ("contacts", "says"),
    [
        (Contacts(AllowsHeat("a", weak), thermal=origins.Thermal("soft", 0.1)), "no heat beside it"),
        (Contacts(Older("a", weak)), "no contacts of the start that are older"),
    ],
)  # fmt: skip
def test_what_the_kernel_does_not_know_is_refused_in_one_line(contacts, says):
    with pytest.raises(InputError, match=says) as refused:
        eq_model.simulate(contacts, PATH, time=CLOCK)
    assert "\n" not in str(refused.value)


def test_contacts_that_outrun_the_slider_are_refused_with_the_speed_that_breaks_them() -> None:
    """x_s0 + age/2: at a speed of 0.5 all hold for ever, on a spring as well; just above, all break."""
    contacts = Contacts(Law("hardening", lambda x, age, travelled: np.maximum(x - 0.5 * age, 0.0)))
    contacts.changing.largest_threshold = lambda fresh, share, duration: fresh + 0.5 * duration
    for more in ({}, {"spring": 0.3}):
        with pytest.raises(
            InputError, match=r"^velocity = 0\.4: .* never break below v = 0\.5, as"
        ):
            call = master.solve if more else master.steady_state
            call(contacts, *([[3.0]] if more else []), velocity=0.4, **more)
    assert master.steady_state(contacts, velocity=0.6).success
