"""Eyring's rate: friction that grows with the logarithm of speed, against quadrature; its numbers in a scene."""

import tomllib
from typing import Any

import numpy as np
import pytest
from scenes import ROUGH, scene
from scipy import integrate

import eq_model
import master
import origins
import toolkit
from origins import Contacts, InputError, Thermal
from toolkit.scene.scene import SHIPPED

ALPHA, WIDE = 0.03, origins.gaussian(1.0, 0.2)
CONTACTS = Contacts(WIDE, thermal=Thermal("eyring", width=ALPHA))
PHYSICAL = {"law": "eyring", "kelvin": 300.0, "shear_strength": 5e7, "activation_volume": 2.76e-27}


def kinetic_force(speed: float) -> float:
    """F_k by the mean time and the mean stretch of contacts of each threshold, then over thresholds."""
    grid = np.linspace(0.0, 1.0, 4001)
    rise = np.exp(-(1.0 - grid) / ALPHA) - np.exp(-1.0 / ALPHA)
    thresholds = np.linspace(1e-3, 2.4, 801)
    # E of a contact of each threshold at shares of it
    holds = np.exp(-ALPHA * thresholds[:, None] * rise / speed)
    life = thresholds * integrate.simpson(holds, x=grid)
    stretch = thresholds**2 * integrate.simpson(grid * holds, x=grid)
    weights = WIDE.pdf(thresholds)
    first, second = (integrate.simpson(weights * part, x=thresholds) for part in (stretch, life))
    return float(first / second)


def test_kinetic_force_grows_with_the_logarithm_of_speed() -> None:
    speeds = np.array([1e-8, 1e-6, 1e-4, 1e-3, 1e-1, 10.0])
    found = master.kinetic_curve(CONTACTS, speeds)
    exact = [kinetic_force(speed) for speed in speeds]
    np.testing.assert_allclose(found.force, exact, atol=1e-8)
    # from 1e-6 to 1e-3 by alpha F_k(infinity) for each factor e, within half a per cent
    rise = (found.force[3] - found.force[1]) / np.log(1e3) / 0.52
    assert rise == pytest.approx(0.0299, abs=5e-5) and rise == pytest.approx(ALPHA, rel=5e-3)
    assert 0.52 - found.force[-1] < 1e-4


def test_the_logarithm_ends_where_contacts_creep_and_where_all_reach_their_thresholds() -> None:
    """The slope falls above v = 0.1 ωα<x_s>; far below e^(-1/α) ωα<x_s> the force is in proportion to the speed."""
    unit = ALPHA * WIDE.mean()

    def slope(speed: float) -> float:
        slow, fast = master.kinetic_curve(CONTACTS, [speed / 1.1, speed * 1.1]).force
        return float((fast - slow) / np.log(1.21) / 0.52 / ALPHA)

    assert slope(0.1 * unit) == pytest.approx(0.998, abs=1e-3)
    assert slope(unit) == pytest.approx(0.648, abs=1e-3) and slope(30.0 * unit) < 0.04
    slowest = 1e-4 * unit * np.exp(-1.0 / ALPHA)
    creep = master.kinetic_curve(CONTACTS, [slowest, 2.0 * slowest]).force
    assert creep[1] / creep[0] == pytest.approx(2.0, rel=2e-3) and creep[0] < 1e-4


@pytest.mark.parametrize(
    ("speed", "number", "most"),
    [(1e-6, 5_000, 6e-3), (1e-6, 50_000, 2e-3), (1e-2, 50_000, 2e-3)],
)
@pytest.mark.slow  # its kernel, which no quick test needs, is compiled for 7 s
def test_the_ensemble_slides_with_the_same_force(speed: float, number: int, most: float) -> None:
    path = np.linspace(30.0, 32.0, 5)
    run = eq_model.simulate(CONTACTS, path, velocity=speed, n_contacts=number, n_replicas=6, seed=3)
    exact = master.steady_state(CONTACTS, velocity=speed).force
    assert np.abs((run.force - exact) / run.force_standard_error).max() < 4.5
    assert run.force_standard_error.max() < most * exact


def test_a_scene_takes_the_width_from_numbers_of_the_material(tmp_path: Any) -> None:
    tables = {"thresholds": ROUGH, "thermal": PHYSICAL | {"attempt_frequency": 1e10}}
    drive = {"to": 1e-8, "points": 3}
    thermal = toolkit.load_scene(scene(contacts=tables, drive=drive)).contacts.thermal
    width = 1.380649e-23 * 300.0 / (5e7 * 2.76e-27)
    assert thermal == Thermal("eyring", width=width, attempt_frequency=1e10)
    for changes, told in (
        ({"activation_volume": None}, r"thermal\.activation_volume: is missing; beside kelvin, "),
        ({"activation_volume": 2.76}, r"activation_volume = 2\.76: makes .* is it in m³\?"),
        ({"kelvin": 1e6}, r"kelvin = 1000000\.0: makes .* is it in K\?"),
        ({"shear_strength": 5e4}, r"shear_strength = 50000\.0: makes .* is it in Pa\?"),
        ({"kelvin": -3.0}, r"thermal\.kelvin = -3\.0: must be above zero"),
        ({"shear_strength": "5e7"}, r"shear_strength = '5e7': must be a number alone, in Pa"),
        ({"width": 0.03}, r"thermal\.width = 0\.03: stands beside kelvin, shear_strength"),
        ({"law": "soft", "temperature": 0.1}, r"thermal\.kelvin = 300.0: write temperature ="),
        (
            {"temperature": {"kelvin": 300.0}},
            r'temperature = {.*}: of the law "eyring" write kelvin, sh',
        ),
        ({"temperature": 0.1}, r'temperature = 0.1: of the law "eyring" write kelvin, sh'),
        ({"law": "eyrin"}, r'write temperature = .*; the law "eyring" alone takes kelvin itself'),
    ):
        own = {key: value for key, value in (PHYSICAL | changes).items() if value is not None}
        bad = {"thresholds": {"kind": "identical", "value": 1.0}, "thermal": own}
        with pytest.raises(InputError, match=told):
            toolkit.load_scene(scene(contacts=bad))


def test_what_the_law_does_not_take_is_refused() -> None:
    for own, told in (
        ({"temperature": 0.1, "width": 0.03}, "temperature = 0.1: is unknown; the law"),
        ({}, "width: is missing"),
        ({"width": 1.5}, "width = 1.5: must be 1e-6 to 1, a number without unit"),
        ({"width": 0.0}, "width = 0.0: must be above zero"),
        ({"width": 0.1, "attempt_frequency": 0.0}, "attempt_frequency = 0.0"),
    ):
        with pytest.raises(InputError, match=told):
            Thermal("eyring", **own)


def test_the_shipped_scene_has_a_slope_for_each_temperature() -> None:
    tables = tomllib.loads((SHIPPED / "eyring.toml").read_text())
    tables["contacts"]["thresholds"]["surface"]["shape"] = [64, 64]
    tables["contacts"]["thresholds"]["surface"]["long_cutoff"] = 2e-6
    # beside its sweep the scene is the one at its own 300 K
    alone = {name: table for name, table in tables.items() if name != "sweep"}
    own = toolkit.load_scene(alone, solved=False).contacts.thermal
    assert toolkit.load_scene(tables).contacts.thermal == own
    tables["sweep"]["velocity"] = [1e-4, 1e-2, 1e3]
    tables["sweep"]["contacts.thermal.kelvin"] = [200.0, 300.0]
    swept = toolkit.run(tables).sweep
    force = {
        (swept["velocity"][k], swept["contacts.thermal.kelvin"][k]): swept["kinetic_force"][k]
        for k in range(len(swept))
    }
    for kelvin in (200.0, 300.0):
        alpha = 1.380649e-23 * kelvin / (5e7 * 2.8e-27)
        slow, fast, all_hold = (force[speed, kelvin] for speed in (1e-4, 1e-2, 1e3))
        assert (fast - slow) / np.log(100.0) / all_hold == pytest.approx(alpha, rel=0.01)
