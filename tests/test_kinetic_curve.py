"""F_k along speeds, temperatures, rates of ageing and delays in one call, against single steady states and closed
forms."""

from typing import Literal

import numpy as np
import pytest
from q15_references import gaussian_force

import master
from origins import (
    Ageing,
    Contacts,
    Delay,
    InputError,
    Thermal,
    boltzmann_reforming,
    gaussian,
    gw_elastic,
    identical,
    mixture,
    rectangular,
)
from origins.thresholds.quadrature import gauss

SPEEDS = np.geomspace(1e-6, 1e4, 200)
NARROW = gaussian(1.0, 0.05)


@pytest.mark.parametrize("law", ["soft", "stiff"])
@pytest.mark.parametrize("temperature", [0.001, 0.1])
@pytest.mark.parametrize("more", [{}, {"stiffness": "linked"}, {"delay": Delay(0.1)}])
def test_every_speed_is_the_steady_state_at_that_speed(law: str, temperature: float, more) -> None:
    contacts = Contacts(NARROW, thermal=Thermal(law, temperature), **more)
    curve = master.kinetic_curve(contacts, SPEEDS)
    for i in (3, 60, 120, 190):
        steady = master.steady_state(contacts, velocity=float(SPEEDS[i]))
        assert curve.force[i] == pytest.approx(steady.force, rel=1e-9)
        assert abs(curve.force[i] - steady.force) <= curve.force_error[i] + steady.force_error
        assert abs(curve.holding[i] - steady.holding) <= curve.holding_error[i] + 1e-12
    assert (curve.force_error <= 1e-9 * curve.force).all()


def test_laws_summed_speed_by_speed_and_laws_without_speed() -> None:
    few = np.array([0.1, 1.0, 10.0])
    for thresholds in (identical(1.0), rectangular(0.5, 1.5)):
        for more in ({"thermal": Thermal("soft", 0.1, closure="paper")}, {"delay": Delay(0.1)}, {"reforming": 0.1}, {}):
            contacts = Contacts(thresholds, **more)
            curve = master.kinetic_curve(contacts, few)
            single = [master.steady_state(contacts, velocity=float(v)).force for v in few]
            np.testing.assert_allclose(curve.force, single, rtol=1e-12)


def test_a_table_over_speed_and_temperature() -> None:
    contacts = Contacts(NARROW, 0.3, thermal=Thermal("stiff", 0.5), reforming=0.1)
    speeds, temperatures = np.array([0.1, 10.0]), np.array([0.0, 0.05, 0.5])
    table = master.kinetic_curve(contacts, speeds[:, None], temperature=temperatures)
    assert table.force.shape == table.force_error.shape == table.holding.shape == (2, 3)
    cold = master.steady_state(Contacts(NARROW, reforming=0.1)).force
    np.testing.assert_array_equal(table.force[:, 0], cold)
    for i, j in ((0, 1), (1, 2)):
        thermal = Thermal("stiff", float(temperatures[j]))
        single = Contacts(NARROW, thermal=thermal, reforming=0.1)
        steady = master.steady_state(single, velocity=float(speeds[i]))
        assert abs(table.force[i, j] - steady.force) <= table.force_error[i, j] + steady.force_error
    # left out, the temperature is the contacts' own; one number is a curve of no dimension
    own = master.kinetic_curve(contacts, 10.0)
    assert own.force.shape == () and float(own.force) == table.force[1, 2]


def test_ageing_in_the_papers_closure_is_the_closed_form_and_depends_on_rate_over_speed_alone() -> None:
    fresh, final = gaussian(0.5, 0.05), gaussian(1.0, 0.01)
    contacts = Contacts(fresh, ageing=Ageing(final, 1.0, closure="paper"))
    diffusion = np.array([0.0, 1e-8, 1e-4, 1e-2, 1e4])
    curve = master.kinetic_curve(contacts, rate=diffusion)
    length, force = gaussian_force(fresh.mean(), fresh.moment(2), 1.0, 0.01, diffusion)
    assert (np.abs(curve.force - force) <= 2.0 * curve.force_error).all()
    np.testing.assert_allclose(curve.force, force, rtol=1e-9)
    waiting = master.kinetic_curve(contacts, 4.0, rate=4.0 * diffusion, delay=0.1)
    np.testing.assert_allclose(waiting.holding, length / (length + 0.4), rtol=1e-9)
    np.testing.assert_allclose(waiting.force, curve.force * waiting.holding, rtol=1e-12)


def test_exact_ageing_is_the_steady_state_at_each_rate() -> None:
    contacts = Contacts(gaussian(0.5, 0.1), ageing=Ageing(gaussian(1.0, 0.01), 1e-3))
    curve = master.kinetic_curve(contacts, [1.0, 10.0], rate=[1e-3, 1e-2])
    steady = master.steady_state(contacts)
    np.testing.assert_allclose(curve.force, steady.force, rtol=1e-12)
    # physics at v = 1000 D, four digits
    assert curve.force[0] == pytest.approx(0.4995, abs=5e-5)


def test_what_holds_at_each_delay() -> None:
    wide = rectangular(0.5, 1.5)
    waits = np.linspace(0.0, 50.0, 200)
    curve = master.kinetic_curve(Contacts(wide), 2.0, delay=waits)
    np.testing.assert_allclose(curve.holding, 1.0 / (1.0 + 2.0 * waits), rtol=0.0, atol=1e-14)
    np.testing.assert_allclose(curve.force, wide.moment(2) / 2.0 * curve.holding, rtol=1e-13)
    assert (np.abs(curve.holding - 1.0 / (1.0 + 2.0 * waits)) <= curve.holding_error).all()
    # with temperature C is that of breaks by a rate, to be met by the other road
    warm = Contacts(wide, thermal=Thermal("soft", 0.1))
    curve = master.kinetic_curve(warm, 2.0, delay=waits[::50])
    for wait, held, off in zip(waits[::50], curve.holding, curve.holding_error, strict=True):
        contacts = Contacts(wide, thermal=Thermal("soft", 0.1), delay=Delay(float(wait)))
        assert abs(held - master.steady_state(contacts, velocity=2.0).holding) <= off + 1e-12 <= 1e-10


@pytest.mark.parametrize(
    ("told", "arguments"),
    [
        (r"velocity = 0\.0: must be finite and above zero", {"velocity": [1.0, 0.0]}),
        (r"delay = -1\.0: must be finite and zero or above", {"delay": -1.0}),
        ("temperature: these contacts have no law for it", {"temperature": [0.1]}),
        ("rate: these contacts do not age", {"rate": [0.1]}),
        (r"velocity, delay: have shapes that do not fit .*\(3,\), delay", {"velocity": [1, 2, 3], "delay": [0, 1]}),
        ("velocity .*must not be empty", {"velocity": []}),
    ],
)
def test_what_cannot_be_asked_is_said(told: str, arguments: dict) -> None:
    with pytest.raises(InputError, match=told):
        master.kinetic_curve(Contacts(NARROW), **arguments)


@pytest.mark.parametrize("law", ["soft", "stiff"])
def test_speeds_at_which_nothing_moves_are_refused(law: Literal["soft", "stiff"]) -> None:
    contacts = Contacts(gaussian(1.0, 0.2), thermal=Thermal(law, 0.1))
    with pytest.raises(InputError, match=r"^velocity = 1e-170: contacts break before they have moved"):
        master.kinetic_curve(contacts, [1.0, 1e-170])


@pytest.mark.parametrize(
    ("thermal", "speed", "more"),
    [
        (Thermal("soft", 4.5), 3.4e-8, {"stiffness": "linked"}),
        (Thermal("stiff", 4.6), 3.1e-7, {"stiffness": "linked"}),
        (Thermal("soft", 0.96), 8.5e-6, {}),
        (Thermal("soft", 6.8), 0.2, {}),
    ],
)
@pytest.mark.parametrize("thresholds", [gw_elastic(1.0), mixture([identical(0.8), gaussian(1.0, 0.1)], [0.3, 0.7])])
def test_wide_laws_slow_and_hot(thermal: Thermal, speed: float, more, thresholds) -> None:
    # where weak contacts break at once, and how far those between get goes within one k_BT of their barrier
    contacts = Contacts(thresholds, thermal=thermal, **more)
    curve, steady = master.kinetic_curve(contacts, speed), master.steady_state(contacts, velocity=speed)
    assert abs(curve.force - steady.force) <= (curve.force_error + steady.force_error) * contacts.mean_threshold
    assert curve.force_error <= 4e-9 * curve.force / contacts.mean_threshold


@pytest.mark.parametrize(("law", "stiffness"), [("soft", "independent"), ("stiff", "linked")])
def test_births_at_many_stretches_at_any_speed(law: str, stiffness: str) -> None:
    """Against integrals over stretches and births."""
    thermal, births = Thermal(law, 0.03), boltzmann_reforming(0.03)  # type: ignore[arg-type]
    contacts = Contacts(identical(1.0), thermal=thermal, reforming=births, stiffness=stiffness)  # type: ignore[arg-type]
    speeds = np.array([1.0, 1e-3, 1e-7])
    found = master.kinetic_curve(contacts, speeds)
    nodes, weights = (part.ravel() for part in gauss(*(np.linspace(-1.0, 1.0, 41)[k : 40 + k] for k in (0, 1))))
    lengths, areas = np.zeros(3), np.zeros(3)
    for r, weight in zip(nodes, weights * births.pdf(nodes), strict=True):
        # close to both ends in smaller steps
        away = (1.0 - r) * np.geomspace(1e-9, 0.5, 60)
        cuts = np.unique(np.concatenate([[r, 1.0, max(r, 0.0)], r + away, 1.0 - away]))
        x, w = (part.ravel() for part in gauss(cuts[:-1], cuts[1:]))
        held = w * np.exp(-thermal.cumulative(x, 1.0, r) / speeds[:, None])
        lengths += weight * held.sum(axis=1)
        areas += weight * held @ x
    assert (np.abs(found.force - areas / lengths) <= found.force_error + 3e-11).all()  # what the integrals miss
    assert found.force_error.max() < 1e-8
    single = master.steady_state(contacts, velocity=1e-3)
    assert single.force == found.force[1] and single.force_error == found.force_error[1]


def test_speeds_beyond_numbers_are_told() -> None:
    contacts = Contacts(gaussian(1.0, 0.2), thermal=Thermal("soft", 0.1))
    slow = master.kinetic_curve(contacts, [1e-30, 1e-100])
    # at 1e-100 thresholds that hardly any contact has would bear the force
    assert slow.success.tolist() == [True, False] and " only at 1 of 2 points" in slow.message
    assert slow.force_error[0] < 1e-9 * slow.force[0] and np.isfinite(slow.force).all()
    with pytest.raises(InputError, match=r"velocity = 1e-200: contacts break before .* slide faster"):
        master.kinetic_curve(contacts, [1e-200, 1.0])
