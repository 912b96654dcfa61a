"""Forces and springs of a surface in newtons of its area and pascals without one: results, tables and reports."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scenes import GAUSSIAN, ROUGH, said, scene, write

import toolkit
from origins.errors import InputError
from toolkit.results.numbers import in_words, numbers_of
from toolkit.scene.scale import of_surface, with_uncertainty, written

AREA = 1e-6
DRIVE = {"to": 5e-8, "points": 21, "area": AREA}


@pytest.fixture(autouse=True)
def _in_tmp(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_newtons_and_pascals_of_a_result_and_of_its_interface() -> None:
    """At steady sliding F is the friction coefficient times the load: on the area 1 N, per area 1 MPa."""
    toolkit.run(scene(ROUGH, drive=DRIVE | {"to": 4e-7}), folder="out")
    found, surface = toolkit.load("out"), toolkit.load_scene(scene(ROUGH)).contacts.interface
    mu = surface.friction_coefficient
    force = found.master.force
    assert found.newtons(force)[-1] == pytest.approx(mu * 1e6 * AREA, rel=1e-6)
    assert found.per_area(force)[-1] == pytest.approx(mu * 1e6, rel=1e-6)
    np.testing.assert_allclose(found.newtons(force), surface.newtons(force, AREA), rtol=1e-12)
    np.testing.assert_allclose(surface.per_area(force), surface.newtons(force, 1.0), rtol=1e-15)
    assert found.newtons(force, area=2.0)[-1] == pytest.approx(2.0 * mu * 1e6, rel=1e-6)
    numbers = numbers_of(found)
    assert numbers["last_force"].unit == "N"
    assert numbers["last_force_over_load"].value == pytest.approx(mu, rel=1e-6)
    # a spring of as many N/m as the scale says is one of N_c<k>
    assert found.newtons(1.0) == pytest.approx(found.scale.spring, rel=1e-15)


def test_newtons_that_are_not_known_are_refused() -> None:
    own, bare = toolkit.run(scene()), toolkit.run(scene(ROUGH, drive={"to": 5e-8, "points": 3}))
    for result, call, said_so in (
        (own, own.newtons, "needs <k>"),
        (own, own.per_area, "needs <k>"),
        (bare, bare.newtons, "no drive.area"),
    ):
        with pytest.raises(InputError, match=said_so):
            call(result.master.force)
    with pytest.raises(InputError, match="area = -1"):
        bare.newtons(1.0, area=-1.0)
    assert bare.scale.force_unit == "Pa" and own.scale.force_unit == "N_c<k> length"
    with pytest.raises(InputError, match='units = \'N\': must be "SI" or "N_c<k>"'):
        toolkit.load_scene(scene(units="N"))


def test_the_report_is_in_newtons_or_pascals_or_in_units_of_n_c_k(capsys: Any) -> None:
    bare = {key: DRIVE[key] for key in ("to", "points")}
    for tables, unit in (
        ({"drive": DRIVE}, "mN"),
        ({"drive": bare}, "kPa"),
        ({"drive": DRIVE, "units": "N_c<k>"}, "N_c<k> m"),
    ):
        status, lines, _ = said(capsys, "run", write(thresholds=ROUGH, **tables))
        (force,) = (line for line in lines if line.startswith("force"))
        assert status == 0 and f" {unit} (µ = 0." in force and "at the end" in force
    assert not in_words(toolkit.run(scene(GAUSSIAN)))[1:]


def test_the_table_of_thresholds_is_in_the_same_units(capsys: Any) -> None:
    for tables, unit, shared in (
        ({"drive": DRIVE}, ["N", "N/m"], False),
        ({"drive": DRIVE, "units": "N_c<k>"}, ["m", "N_c<k>"], True),
    ):
        name = "shared" if shared else "mine"
        _, lines, _ = said(
            capsys, "thresholds", write(name, thresholds=ROUGH, master=None, **tables)
        )
        for start, own in zip(("  kinetic force", "  critical spring"), unit, strict=True):
            (line,) = (line for line in lines if line.startswith(start))
            assert line.split()[-1] == own
    found = json.loads(Path("mine-output/thresholds.json").read_text())["numbers"]
    surface = toolkit.load_scene(scene(ROUGH)).contacts.interface
    friction = surface.friction_coefficient * 1e6 * AREA
    assert found["kinetic_force_of_the_area"]["value"] == pytest.approx(friction, rel=1e-6)


def test_a_prefix_is_chosen_for_each_unit() -> None:
    assert written(4.81e10, "N/m³") == "48.1 GN/m³" and written(2.5e5, "Pa") == "250 kPa"
    assert with_uncertainty(0.2512, 3e-3, "N") == "251 mN ± 3 mN"
    assert with_uncertainty(0.2512, 3e-9, "N") == "251.2 mN"
    assert of_surface(1e11, 200.0, 1e6, None).force == 2e13
