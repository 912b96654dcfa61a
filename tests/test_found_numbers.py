"""Numbers that were once false: a call, its reference, and what was wrong with it.

A reference is a closed form, or else the same call asked a thousandth of the tolerance.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest
import scipy.stats

import master
from origins import (
    Ageing,
    Contacts,
    Delay,
    Thermal,
    gaussian,
    gaussian_start,
    growing_grains,
    gw_elastic,
    identical,
    mixture,
    rectangular,
)

WIDE = gaussian(1.0, 0.2)
NARROW = gaussian(1.0, 0.05)


class Row(NamedTuple):
    """A call of master.solve; `exact` tells the force along the path, lengths; `more` it may be off."""

    contacts: Contacts
    path: Any
    tolerance: float
    drive: dict[str, Any] | None = None
    exact: Callable[[np.ndarray], Any] | None = None
    more: float = 0.0


LATE = np.append(np.linspace(0.0, -1.3, 11), [-1.28, -1.26, -1.25, -1.2])
STEPS = np.cumsum([0.0, 0.9, 1.1, 1, 1.2, 0.3, 0.9, 1, 0.5, 1.1, 0.7, 0.4, 0.9, 1.3, 0.6])
FORCES = {
    # thresholds in heat were read as those of the start: 1e-5 on, all stand where they form again
    "contacts that break as they start": Row(
        Contacts(gaussian(1.0, 0.02), -1.05, Thermal("soft", 0.01, 1e10)),
        np.linspace(0.01, 1.5, 20),
        2e-4,
        exact=lambda x: (
            master.solve(
                Contacts(gaussian(1.0, 0.02), thermal=Thermal("soft", 0.01, 1e10)), x, 2e-4
            ).force
        ),
        more=1e-4,
    ),
    # a value moved by the wait, and an edge that is the same but for rounding, counted twice
    "an exact value where a density begins": Row(
        Contacts(
            mixture([identical(0.5), rectangular(0.5, 1.5)], [0.5, 0.5]), 0.03, delay=Delay(1 / 3)
        ),
        np.linspace(0.0, 3.0, 31),
        1e-6,
    ),
    # tails of which no survival is a number lost their stiffness: all move with the slider
    "a linked start in the far tail": Row(
        Contacts(gaussian(1.0, 0.0027), gaussian_start(0.0, 0.15), stiffness="linked"),
        [0.05, 0.1, -0.1],
        1e-6,
        exact=lambda x: x,
        more=2e-9,  # a share of 1e-9 has broken by X = 0.1
    ),
    # births were told by the leg before: a minute's work for 1e-5
    "re-forming behind on a path that turns": Row(
        Contacts(gw_elastic(1.0), reforming=-0.04), [0.0, 0.4, -0.2], 1e-6
    ),
    # legs as long as what the survival is smooth over were told by polynomials of a low degree
    "a dozen velocity steps before a turn": Row(
        Contacts(WIDE, thermal=Thermal("stiff", 0.0076, 410.0, "paper")),
        LATE,
        1e-4,
        {"time": STEPS},
    ),
    # young grains were met by a rate that they did not feel
    "cold grains that are met at once": Row(
        Contacts(growing_grains(1.0, 1.0, age=0.31), thermal=Thermal("soft", 1e-12)),
        [0.01, 0.1, 0.3],
        1e-4,
        {"velocity": 0.05},
        lambda x: (
            master.solve(Contacts(growing_grains(1.0, 1.0, age=0.31)), x, 1e-4, velocity=0.05).force
        ),
        1e-6,
    ),
    # attempts closer together than times can tell made nan
    "exact values held at room temperature": Row(
        Contacts(identical(1.0), thermal=Thermal("soft", 1e-4, 1e12)),
        [0.5, 0.5],
        1e-4,
        {"time": [1.0, 2.0]},
        lambda x: x,
    ),
    # the last breaks of all stayed out for ever
    "the far end of a path that rests": Row(
        Contacts(WIDE, 0.4, Thermal("soft", 0.1)), [-0.2, -0.2], 1e-3, {"time": [0.2, 0.2]}
    ),
    # starts on both sides of the cusp of S(|r|) = exp(-|r|^1.37), where no law declares one
    "a start around zero": Row(
        Contacts(scipy.stats.weibull_min(1.373), scipy.stats.norm(0.05, 0.03), delay=Delay(10.0)),
        [0.1, 0.5, 1.0, 2.0],
        1e-7,
    ),
    # half a table was missing where thresholds spread faster than the slider goes
    "ageing right after a turn": Row(
        Contacts(WIDE, ageing=Ageing(gaussian(1.5, 0.2), 0.078)),
        [0.0, -1.14, -1.4, -1.399, -1.39],
        1e-4,
        {"velocity": 0.116},
        # on a path that goes on
        lambda x: master.solve(
            Contacts(WIDE, ageing=Ageing(gaussian(1.5, 0.2), 0.078)),
            [*x, 0.6],
            1e-4,
            velocity=0.116,
        ).force[:-1],
        1e-4,
    ),
}


SLOW = {"a dozen velocity steps before a turn", "ageing right after a turn"}


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name in SLOW)) for name in FORCES]
)
def test_forces(name: str) -> None:
    row = FORCES[name]
    path = np.asarray(row.path, float)
    found = master.solve(row.contacts, path, row.tolerance, **(row.drive or {}))
    assert found.success, found.message
    if row.exact is None:
        better = master.solve(row.contacts, path, 1e-3 * row.tolerance, **(row.drive or {}))
        exact, granted = better.force, better.force_error
    else:
        exact, granted = row.exact(path), 0.0
    allowed = (found.force_error + granted) * row.contacts.mean_threshold + row.more
    assert np.abs(found.force - exact).max() <= allowed


def test_a_kinetic_force_below_zero_is_told() -> None:
    """After a short life each waits for 1: those that hold stand at -0.3, where they form again."""
    thermal = Thermal("soft", 0.5, 1e6)
    contacts = Contacts(NARROW, thermal=thermal, reforming=-0.3, delay=Delay(1.0))
    steady = master.steady_state(contacts)
    assert steady.force / steady.holding == pytest.approx(-0.3, abs=1e-4)


def test_a_step_between_the_nodes_is_found() -> None:
    """All break within 2e-9 of one stretch, where no node of a wide panel sees them."""
    contacts = Contacts(rectangular(1.0 - 1e-9, 1.0 + 1e-9), reforming=0.3)
    assert master.steady_state(contacts).force == pytest.approx(0.65, abs=1e-9)


THERMALS = [
    pytest.param(Thermal("soft", 4.5), 3.4e-8, {"stiffness": "linked"}, marks=pytest.mark.slow),
    (Thermal("soft", 6.8), 0.2, {}),
]


@pytest.mark.parametrize(("thermal", "speed", "more"), THERMALS)
def test_wide_laws_slow_and_hot(thermal: Thermal, speed: float, more: dict) -> None:
    """Weak contacts break at once: how far others get goes within one k_BT of their barrier."""
    contacts = Contacts(gw_elastic(1.0), thermal=thermal, **more)
    curve = master.kinetic_curve(contacts, speed)
    steady = master.steady_state(contacts, velocity=speed)
    allowed = (curve.force_error + steady.force_error) * contacts.mean_threshold
    assert abs(curve.force - steady.force) <= allowed
    assert curve.force_error <= 4e-9 * curve.force / contacts.mean_threshold


# contacts, tolerance, K* and the path along which F falls as steeply
SPRINGS: dict[str, tuple[Contacts, float]] = {
    # kinks fell anywhere on a panel, as did the maximum
    "hot rectangles": (
        Contacts(
            rectangular(0.0, 0.1867),
            -0.054203,
            Thermal("stiff", 0.00864, 1.8918),
            delay=Delay(0.06706),
        ),
        1e-7,
    ),
    # what lies beyond the last stretch followed was taken for nothing
    "a fat tail": (Contacts(scipy.stats.lognorm(1.0)), 1e-4),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", SPRINGS)
def test_critical_springs(name: str) -> None:
    contacts, tolerance = SPRINGS[name]
    found, better = (master.propensity(contacts, asked) for asked in (tolerance, 1e-2 * tolerance))
    off = abs(found.critical_spring - better.critical_spring)
    assert off <= found.critical_spring_error + better.critical_spring_error


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
    peaks = mixture([gaussian(0.3, 0.003), gaussian(1.0, 0.03)], [0.3, 0.7])
    contacts = Contacts(peaks)
    found = master.solve(contacts, [0.0, 11.0], 1e-6, spring=0.5, slip="reform-after")
    drops = found.slips.drop
    np.testing.assert_allclose(drops[6:9], drops[3:6], rtol=0.01)
    assert found.regime.verdict == "stick-slip" and found.regime.trend is None
