"""Numbers that were once false: what was wrong, a call, and its reference.

A reference is a closed form, another road, or else (FINER) the same call at a thousandth of the tolerance.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy import stats

import master
import origins
from origins import Contacts, Delay, Thermal, gaussian, identical, mixture, rectangular

WIDE = gaussian(1.0, 0.2)
EVEN, FAR = np.linspace(0.01, 1.5, 20), np.linspace(0.0, 3.0, 31)
LATE = np.append(np.linspace(0.0, -1.3, 11), [-1.28, -1.26, -1.25, -1.2])
STEPS = np.cumsum([0.0, 0.9, 1.1, 1, 1.2, 0.3, 0.9, 1, 0.5, 1.1, 0.7, 0.4, 0.9, 1.3, 0.6])
BOTH = mixture([identical(0.5), rectangular(0.5, 1.5)], [0.5, 0.5])
SPREADING = origins.Ageing(gaussian(1.5, 0.2), 0.078)
TURNED = [0.0, -1.14, -1.4, -1.399, -1.39]
OLD = origins.Ageing(origins.lubricated(1.0), 1e-3)
AGED = Contacts(rectangular(0.5, 0.7), origins.gaussian_start(0.1, 0.02), ageing=OLD)
Asked = Callable[[Callable[..., Any], float], Any]
FINER = None  # the reference is the same call at a thousandth of the tolerance


def case(name: str, call: Asked, reference: object, off: float, slow: bool = False) -> Any:
    """What was wrong; the call, of what solves and of a tolerance; its reference - forces, what computes
    them, contacts that do the same, or FINER - and what that may be off by, lengths (of FINER the tolerance)."""
    return pytest.param(call, reference, off, id=name, marks=[pytest.mark.slow] * slow)


FORCES = [
    case(
        "contacts that break as they start: thresholds in heat were read as those of the start",
        lambda solve, tolerance: solve(
            Contacts(gaussian(1.0, 0.02), -1.05, Thermal("soft", 0.01, 1e10)), EVEN, 2e-4
        ),
        Contacts(gaussian(1.0, 0.02), None, Thermal("soft", 0.01, 1e10)),
        1e-4,
    ),
    case(
        "an exact value where a density begins, moved by the wait: an edge the same but for rounding counted twice",
        lambda solve, tolerance: solve(Contacts(BOTH, 0.03, delay=Delay(1 / 3)), FAR, tolerance),
        FINER,
        1e-6,
    ),
    case(
        "a linked start in the far tail: tails of which no survival is a number lost their stiffness",
        lambda solve, tolerance: solve(
            Contacts(gaussian(1.0, 0.0027), origins.gaussian_start(0.0, 0.15), stiffness="linked"),
            [0.05, 0.1, -0.1],
            1e-6,
        ),
        [0.05, 0.1, -0.1],
        2e-9,
    ),
    case(
        "re-forming behind on a path that turns: births were told by the leg before, a minute's work for 1e-5",
        lambda solve, tolerance: solve(
            Contacts(origins.gw_elastic(1.0), reforming=-0.04), [0.0, 0.4, -0.2], tolerance
        ),
        FINER,
        1e-6,
    ),
    case(
        "a dozen velocity steps before a turn: legs as long as what the survival is smooth over had a low degree",
        lambda solve, tolerance: solve(
            Contacts(WIDE, thermal=Thermal("stiff", 0.0076, 410.0, "paper")),
            LATE,
            tolerance,
            time=STEPS,
        ),
        FINER,
        1e-4,
        slow=True,
    ),
    case(
        "cold grains that are met at once: young ones were met by a rate that they did not feel",
        lambda solve, tolerance: solve(
            Contacts(origins.growing_grains(1.0, 1.0, age=0.31), None, Thermal("soft", 1e-12)),
            [0.01, 0.1, 0.3],
            1e-4,
            velocity=0.05,
        ),
        Contacts(origins.growing_grains(1.0, 1.0, age=0.31)),
        1e-6,
        slow=True,
    ),
    case(
        "exact values held at room temperature: attempts closer together than times can tell made nan",
        lambda solve, tolerance: solve(
            Contacts(identical(1.0), thermal=Thermal("soft", 1e-4, 1e12)),
            [0.5, 0.5],
            1e-4,
            time=[1.0, 2.0],
        ),
        [0.5, 0.5],
        0.0,
    ),
    case(
        "the far end of a path that rests: the last breaks of all stayed out for ever",
        lambda solve, tolerance: solve(
            Contacts(WIDE, 0.4, Thermal("soft", 0.1)), [-0.2, -0.2], tolerance, time=[0.2, 0.2]
        ),
        FINER,
        1e-3,
    ),
    case(
        "a start around zero: on both sides of the cusp of S(|r|) = exp(-|r|^1.37), where no law declares one",
        lambda solve, tolerance: solve(
            Contacts(stats.weibull_min(1.373), stats.norm(0.05, 0.03), delay=Delay(10.0)),
            [0.1, 0.5, 1.0, 2.0],
            tolerance,
        ),
        FINER,
        1e-7,
    ),
    case(
        "ageing right after a turn, where thresholds spread faster than the slider goes: half a table was missing",
        lambda solve, tolerance: solve(
            Contacts(WIDE, ageing=SPREADING), TURNED, 1e-4, velocity=0.116
        ),
        lambda: master.solve(
            Contacts(WIDE, ageing=SPREADING), [*TURNED, 0.6], 1e-4, velocity=0.116
        ).force[:-1],
        1e-4,
        slow=True,
    ),
    case(
        "a wide start on a spring with a final law that is not normal: rules of more stretches were compared elsewhere",
        lambda solve, tolerance: solve(AGED, [0.2], 1e-2, spring=1.5, slip="reset"),
        0.18,
        1e-6,
        slow=True,
    ),
]


@pytest.mark.parametrize(("call", "exact", "off"), FORCES)
def test_forces(call: Asked, exact: Any, off: float) -> None:
    contacts, found, granted = (
        call(lambda contacts, *_, **__: contacts, off),
        call(master.solve, off),
        0.0,
    )
    if exact is FINER:
        finer, off = call(master.solve, 1e-3 * off), 0.0
        exact, granted = finer.force, finer.force_error
    elif callable(exact):
        exact = exact()
    elif isinstance(exact, Contacts):
        same = exact
        exact = call(lambda _, *words, **drive: master.solve(same, *words, **drive), off).force
    assert found.success, found.message
    allowed = (found.force_error + granted) * contacts.mean_threshold + off
    assert np.abs(found.force - exact).max() <= allowed


def test_a_kinetic_force_below_zero_is_told() -> None:
    """After a short life each waits for 1: those that hold stand at -0.3, where they form again."""
    thermal = Thermal("soft", 0.5, 1e6)
    contacts = Contacts(gaussian(1.0, 0.05), None, thermal, delay=Delay(1.0), reforming=-0.3)
    steady = master.steady_state(contacts)
    assert steady.force / steady.holding == pytest.approx(-0.3, abs=1e-4)


def test_a_step_between_the_nodes_is_found() -> None:
    """All break within 2e-9 of one stretch, where no node of a wide panel sees them."""
    contacts = Contacts(rectangular(1.0 - 1e-9, 1.0 + 1e-9), reforming=0.3)
    assert master.steady_state(contacts).force == pytest.approx(0.65, abs=1e-9)


@pytest.mark.parametrize(
    ("temperature", "speed", "stiffness"),
    [
        pytest.param(4.5, 3.4e-8, "linked", marks=pytest.mark.slow),
        (6.8, 0.2, "independent"),
        (0.01, 1.8e-5, "independent"),
    ],
)
def test_wide_laws_slow_and_hot(temperature: float, speed: float, stiffness: Any) -> None:
    """Weak contacts break at once: how far others get goes within one k_BT of their barrier. Few strong ones go far."""
    thermal = Thermal("soft" if temperature > 1.0 else "stiff", temperature)
    contacts = Contacts(origins.gw_elastic(1.0), thermal=thermal, stiffness=stiffness)
    curve = master.kinetic_curve(contacts, speed)
    steady = master.steady_state(contacts, velocity=speed)
    allowed = (curve.force_error + steady.force_error) * contacts.mean_threshold
    assert abs(curve.force - steady.force) <= allowed
    assert curve.force_error <= 4e-9 * curve.force / contacts.mean_threshold


@pytest.mark.slow
def test_what_lies_beyond_the_last_stretch_followed_counts() -> None:
    """It was taken for nothing."""
    contacts = Contacts(stats.lognorm(1.0))
    found, better = (master.propensity(contacts, tolerance) for tolerance in (1e-4, 1e-6))
    off = abs(found.critical_spring - better.critical_spring)
    assert off <= found.critical_spring_error + better.critical_spring_error


@pytest.mark.parametrize("tolerance", [1e-3, 1e-4, 1e-5])
def test_slopes_in_a_thin_layer_before_a_jump(tolerance: float) -> None:
    """Heat breaks contacts right before a jump of P_c: F hardly shows it, but F' does. K* is one of F's differences."""
    thermal = Thermal("soft", 1.884e-4, 0.99444)
    contacts = Contacts(rectangular(0.020427349366665258, 0.506945079541655), thermal=thermal)
    found = master.propensity(contacts, tolerance)
    assert abs(found.critical_spring - 0.72010084) <= found.critical_spring_error + 1e-8 < tolerance


@pytest.mark.slow
def test_few_that_live_for_thousands_of_means_are_told() -> None:
    """Two in ten thousand have a threshold of 1,250 means: they pile up, and break together."""
    parts = [gaussian(0.003, 3e-4), gaussian(5.0, 0.5)]
    contacts = Contacts(mixture(parts, [0.9998, 0.0002]))
    found = master.propensity(contacts, 1e-6)
    solved = master.solve(contacts, np.linspace(5.5, 5.7, 9), 1e-6)
    static = solved.force.max() / master.steady_state(contacts).force
    assert static > 1.1 and not found.success and "F_s known to" in found.message
    assert abs(found.static_to_kinetic - static) < found.static_to_kinetic_error < 1.0


@pytest.mark.slow
def test_large_and_small_slips_in_turn_do_not_fade() -> None:
    """A line through the logarithms of their drops falls or rises by where the path ends."""
    contacts = Contacts(mixture([gaussian(0.3, 0.003), gaussian(1.0, 0.03)], [0.3, 0.7]))
    found = master.solve(contacts, [0.0, 11.0], 1e-6, spring=0.5, slip="reform-after")
    drops = found.slips.drop
    np.testing.assert_allclose(drops[6:9], drops[3:6], rtol=0.01)
    assert found.regime.verdict == "stick-slip" and found.regime.trend is None
