"""Steady creep of a slider whose contacts grow stronger as they break by heat."""

from typing import Any

import numpy as np
import pytest
from conftest import slow

import master
import origins
from master.soft.in_time.creep import may_creep
from master.steady.response import has_response, is_stable, response
from origins import Contacts, Delay, Thermal, gaussian
from tests.test_creep import EYRING, SOFTEST, SPREAD, WIDE, kinetic, stepped


def growing(law: object, beta: float, time: float = 1.0, width: float = 0.03) -> Contacts:
    """Contacts with heat whose thresholds grow by beta ln(1 + age/time)."""
    heat = Thermal("eyring", width=width)
    return Contacts(origins.strengthening(law, beta=beta, time=time), thermal=heat)


@pytest.mark.parametrize(("beta", "velocity"), [slow(0.03, 1e-4), (0.1, 1e-2)])
def test_slow_disturbances_see_the_slope_of_the_kinetic_force(beta: float, velocity: float) -> None:
    """G(iq) -> iq dF_k/d ln v: F_k rises with the speed as heat does less, and falls as contacts grow for less time."""
    contacts, ratio = growing(WIDE, beta, 1.0 if beta < 0.1 else 1e2), 1.02
    told = complex(response(contacts, velocity, np.array([1e-3]))[0])
    up, down = (kinetic(contacts, velocity * one) for one in (ratio, 1.0 / ratio))
    slope = (up - down) / (2.0 * np.log(ratio))
    assert told.imag / 1e-3 == pytest.approx(slope, abs=1e-4) and abs(slope) > 5e-3
    assert (slope > 0.0) == is_stable(contacts, velocity, SOFTEST)


@pytest.mark.parametrize("width", [0.03, *(slow(width) for width in (0.01, 0.1))])
def test_contacts_that_hardly_grow_answer_as_those_that_do_not(width: float) -> None:
    """What contacts gain on a step is found in other ways, in closed form and by differences of their rates; the sum
    over steps is one."""
    waves = np.geomspace(1e-3, 100.0, 30)
    still = response(Contacts(WIDE, thermal=Thermal("eyring", width=width)), 1e-4, waves)
    grown = response(growing(WIDE, 1e-9, width=width), 1e-4, waves)
    assert np.abs(grown - still).max() < 1.5e-3
    assert (grown - still).imag[0] == pytest.approx(0.0, abs=1e-7)


@pytest.mark.slow
def test_the_response_is_that_to_a_small_step_of_the_speed() -> None:
    stepped(growing(WIDE, 0.03), 1e-6, 401)


@pytest.mark.slow
def test_creep_goes_on_as_steps_do_and_ends_at_the_kinetic_force() -> None:
    """Steps lead up to X_T = 192; on a path ten times as long creep takes over."""
    contacts, first = growing(SPREAD, 0.01), np.linspace(0.0, 192.0, 33)
    drive: dict[str, Any] = {"velocity": 1e-4, "spring": 3e-3}
    steps: Any = master.solve(contacts, first, 1e-2, **drive)
    creep: Any = master.solve(contacts, np.append(first, 2400.0), 1e-2, **drive)
    assert creep.success and "creeps" in creep.message and "creeps" not in steps.message
    off = np.abs(creep.force[:33] - steps.force).max()
    assert off < steps.force_error + creep.force_error
    assert creep.force[-1] == pytest.approx(kinetic(contacts, 1e-4), rel=1e-6)
    assert creep.regime.verdict == "smooth" and not creep.slips.drive.size


@pytest.mark.slow
def test_on_the_spring_of_a_machine_the_force_is_the_kinetic_one() -> None:
    contacts, path = growing(WIDE, 0.01), np.linspace(0.0, 2e6, 41)
    told: Any = master.solve(contacts, path, 1e-2, velocity=1e-4, spring=SOFTEST)
    assert told.success and told.regime.verdict == "smooth", told.message
    assert told.force[-1] == pytest.approx(kinetic(contacts, 1e-4), rel=1e-6)
    assert told.force[1] == pytest.approx(SOFTEST * path[1], abs=1e-3)


def test_no_other_law_beside_growth_is_known_to_creep() -> None:
    contacts = growing(gaussian(1.0, 0.2), 0.03)
    assert has_response(contacts) and not has_response(contacts.replace(delay=Delay(1.0)))
    assert not has_response(contacts.replace(thermal=None)) and has_response(
        Contacts(WIDE, thermal=EYRING)
    )
    assert not may_creep(contacts, None)


def test_rates_that_steps_do_not_resolve_are_not_called_stable() -> None:
    """Heat of 1e-7 breaks contacts in a skin of a thousandth of their thresholds."""
    cold = growing(WIDE, 0.03, width=1e-5)
    assert np.isnan(response(cold, 1e-4, np.array([1.0]))).all()
    assert not is_stable(cold, 1e-4, 1.0)
