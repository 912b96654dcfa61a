"""Forces and springs of a surface in newtons of its area and pascals without one: results, tables and reports."""

import json
import re
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import slow
from matplotlib.figure import Figure
from scenes import GAUSSIAN, ROUGH, refused, said, scene, write

import origins
import toolkit
from master import steady_state
from origins.errors import InputError
from toolkit.judge.describe import Description, describe, onset_in_words, table_of
from toolkit.results.numbers import in_words, numbers_of
from toolkit.results.report import report
from toolkit.scene.barriers import of_cold
from toolkit.scene.interfaces import Number, doubts, of_linked, of_temperature, remarks
from toolkit.scene.messages import with_units_of
from toolkit.scene.scale import (
    of_surface,
    scale_of,
    with_error,
    with_scatter,
    with_uncertainty,
    written,
)
from toolkit.scene.scene import load_scene
from toolkit.scene.units_to_check import of_machine, of_stretch, of_units

AREA = 1e-6
DRIVE = {"to": 5e-8, "points": 21, "area": AREA}

pytestmark = pytest.mark.usefixtures("in_a_folder")


@pytest.fixture(autouse=True)
def _rendered(request: pytest.FixtureRequest) -> None:
    if "pictures" not in request.function.__name__:
        request.getfixturevalue("unrendered")


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
    kept = json.loads(Path("out", "summary.json").read_text())["numbers"]
    assert kept["last_force"] == {
        "value": pytest.approx(found.newtons(force)[-1], rel=1e-12),
        "error": pytest.approx(
            found.newtons(found.master.force_error * found.mean_threshold), rel=1e-12
        ),
        "unit": "N",
    }
    assert numbers["last_force_over_load"].value == pytest.approx(mu, rel=1e-6)
    (line,) = [line for line in report(found) if line.startswith("master")]
    # what the surface leaves open is far more than the numerical error, which stands in the file
    assert "(numerical errors are in summary.json)" in line and " of <x_s>" not in line
    missed = replace(found.master, success=False)
    (line,) = [line for line in report(replace(found, master=missed)) if line.startswith("master")]
    shared = f"({found.master.force_error:.1e} of <x_s>)"
    assert f"error {written(kept['last_force']['error'], 'N', digits=2)} {shared}" in line
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
    assert bare.scale.force_unit == "Pa" and own.scale.force_unit == "N_c<k>·length"
    with pytest.raises(InputError, match='units = \'N\': must be "SI" or "N_c<k>"'):
        toolkit.load_scene(scene(units="N"))


def test_a_sweep_over_the_pressure_gives_each_point_its_own_newtons() -> None:
    """One factor for all of them would tell 8 times too much at a tenth of the pressure."""
    sweep = {"contacts.thresholds.pressure": [1e5, 1e6]}
    surface = {"master": None, "drive": DRIVE}
    result = toolkit.run(scene(ROUGH, sweep=sweep, **surface))
    for call in (result.newtons, result.per_area):
        with pytest.raises(InputError, match=r"the sweep changes contacts\.thresholds\.pressure"):
            call(result.sweep["kinetic_force"])
    wide = toolkit.run(scene(ROUGH, sweep={"drive.area": [1e-6, 1e-4]}, **surface))
    shared = wide.sweep["kinetic_force"]
    with pytest.raises(InputError, match=r"the sweep changes drive\.area"):
        wide.newtons(shared)
    np.testing.assert_allclose(wide.per_area(shared), wide.sweep["kinetic_stress"], rtol=1e-6)
    speeds = toolkit.run(scene(ROUGH, sweep={"velocity": [1e-6, 1e-5]}, **surface))
    assert speeds.newtons(speeds.sweep.force).shape == (2,)


def test_a_sweep_needs_no_path_and_takes_the_machines_speed() -> None:
    """A machine without a path was refused: "drive: needs one of to and turns"."""
    contacts = {"thresholds": ROUGH, "thermal": {"law": "stiff", "temperature": {"kelvin": 300.0}}}
    contacts["thermal"] |= {"attempt_frequency": 1e10}
    machine = {"velocity": 1e-6, "area": 1e-6, "spring": "50 N/m"}
    swept = {"contacts": contacts, "master": None, "sweep": {"kelvin": [0.0, 300.0]}}
    result = toolkit.run(scene(drive=machine, **swept))
    with_path = toolkit.run(scene(drive=machine | {"to": 1e-8, "points": 3}, **swept))
    assert (result.sweep.velocity == 1e-6).all()
    np.testing.assert_array_equal(result.sweep.force, with_path.sweep.force)
    assert result.newtons(result.sweep.force[0]) == pytest.approx(0.2, rel=0.5)
    with pytest.raises(InputError, match="drive: needs one of to and turns"):
        toolkit.load_scene(scene(drive=machine, **swept | {"master": {}}))


def test_the_report_is_in_newtons_or_pascals_or_in_units_of_n_c_k(capsys: Any) -> None:
    bare = {key: DRIVE[key] for key in ("to", "points")}
    for tables, unit in (
        ({"drive": DRIVE}, "mN"),
        ({"drive": bare}, "kPa"),
        ({"drive": DRIVE, "units": "N_c<k>"}, "N_c<k>·m"),
    ):
        status, lines, _ = said(capsys, "run", write(thresholds=ROUGH, **tables))
        (force,) = (line for line in lines if line.startswith("force"))
        assert status == 0 and f" {unit} (µ = 0." in force and "at the end" in force
    assert not in_words(toolkit.run(scene(GAUSSIAN)))[1:]


def test_the_last_slip_of_an_ensemble_alone_is_one_of_all_its_contacts() -> None:
    """30 % of the contacts break at 0.3 and re-form there: F falls from 0.3 to at least 0.21, where no spring holds
    it, and by 1.3e-3 on this one; all contacts break near 0.73. The path ends after a slip of the 30 % alone."""
    narrow = {"kind": "identical", "value": 0.3}
    wide = {"kind": "gaussian", "mean": 1.0, "std": 0.05}
    result = toolkit.run(
        scene(
            {"kind": "mixture", "components": [narrow, wide], "weights": [0.3, 0.7]},
            drive={"to": 220.0, "points": 100, "spring": 1e-2, "slip": "reform-after"},
            master=None,
            eq={"contacts": 20_000, "replicas": 2},
        )
    )
    assert result.eq.slips.drop[-1] < 2e-3
    found = numbers_of(result)
    assert found["before_slip"].value == pytest.approx(0.73, abs=0.005)
    assert found["after_slip"].value < 1e-3


def test_forces_of_round_off_are_zero() -> None:
    """Nothing pulls once all contacts have broken and wait: K (X_T - X) is then the round-off of two lengths."""
    pulled = {"to": 9.7e-5, "points": 37, "spring": "50 N/m", "area": 1e-9, "velocity": 1e-6}
    contacts = {"thresholds": ROUGH, "delay": {"time": 1e4}}
    eq = {"contacts": 200, "replicas": 4}
    found = toolkit.run(
        {"contacts": contacts, "drive": pulled | {"slip": "reform-after"}, "eq": eq}
    )
    raw, numbers = found.newtons(found.eq.force), numbers_of(found)
    assert 0.0 < raw.max() < 1e-14 * numbers["before_slip"].value
    for name in ("last_force", "largest_force", "after_slip"):
        assert (numbers[name].value, numbers[name].error) == (0.0, 0.0)
    force, slip = in_words(found)
    assert force.startswith(
        "force   0 N (µ = 0) at the end, at most 0 N (µ = 0)"
    ) and force.endswith(" at the path's points")
    assert slip.endswith(" to 0 N, the last")


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
            # with an SI prefix, as those of other numbers of a surface; K* has two digits
            assert line.split()[-1].endswith(own)
            digits = re.sub(r"\D", "", line.split()[-2].partition("e")[0]).lstrip("0")
            assert len(digits.rstrip("0")) <= (3 if "force" in start else 2)
    found = json.loads(Path("mine-output/thresholds.json").read_text())["numbers"]
    surface = toolkit.load_scene(scene(ROUGH)).contacts.interface
    friction = surface.friction_coefficient * 1e6 * AREA
    assert found["kinetic_force_of_the_area"]["value"] == pytest.approx(friction, rel=1e-6)


def test_thresholds_of_a_surface_tell_of_its_heights_slopes_and_summits(capsys: Any) -> None:
    """Summits as they were given, and a slope that McCool's relations have: m4 = 0.14 pi/r², m2 = m4/(6 pi 3^½ D)."""
    _, lines, _ = said(capsys, "thresholds", write(thresholds=ROUGH, master=None))
    found = json.loads(Path("mine-output/thresholds.json").read_text())["numbers"]
    own, curvature = ROUGH["surface"], np.pi * (0.375 / ROUGH["surface"]["radius"]) ** 2
    assert found["summit_radius"]["value"] == pytest.approx(own["radius"])
    assert found["summit_density"]["value"] == pytest.approx(own["density"])
    slope = np.sqrt(2.0 * curvature / (6.0 * np.pi * 3**0.5 * own["density"]))
    assert found["rms_slope"]["value"] == pytest.approx(slope)
    assert found["rms_height"]["value"] > own["std"]  # summits are less high than the surface
    assert any(re.fullmatch(r"  summit radius +1.00 µm", line) for line in lines)


def test_the_critical_spring_of_smoothed_islands_is_not_told_by_thresholds() -> None:
    own = {"critical_spring": Number(3.0, 1.0, "N_c<k>")}
    (line, _) = table_of(Description(own, (), True, True, 1.0), (), (), smoothed=True)
    assert line.endswith("not known: it hangs on the smoothing of P_c") and "N_c" not in line


def test_beside_a_machine_no_other_springs_are_told_of_islands() -> None:
    """Two waves at all angles: P_c diverges, and without a machine slips of stiff springs are told."""
    law = origins.domains(law="equal", stiffness=1.0, sizes=[(4, 4)], lattice_constant=3.88)
    (without,), (beside,) = remarks(law), remarks(law, machine=True)
    assert "K = 100 N<k>" in without and without.startswith(beside) and "N<k>" not in beside


def test_a_prefix_is_chosen_for_each_unit() -> None:
    assert written(4.81e10, "N/m³") == "48.1 GN/m³" and written(2.5e5, "Pa") == "250 kPa"
    assert with_uncertainty(0.2512, 3e-3, "N") == "251 ± 3 mN"
    assert with_uncertainty(0.2512, 3e-9, "N") == "251.2 mN"
    # no error is told smaller than it is: that of a critical spring, 24 kN/m, was ± 20 kN/m
    assert with_uncertainty(1.21e6, 2.4e4, "N/m", digits=3) == "1.21 ± 0.03 MN/m"
    assert with_uncertainty(0.2512, 9.1e-3, "N") == "251 ± 10 mN"
    assert (
        with_error(1.2345, 0.024, 5) == "1.23 ± 0.03" and with_error(2.0, 0.097, 5) == "2.0 ± 0.1"
    )
    # what is rounded up to a power of ten has no digit more for that, and its prefix
    assert (
        written(0.9999999e-6, "m/s") == "1.00 µm/s" and written(9.999e5, "N", digits=3) == "1.00 MN"
    )
    assert written(0.99999, "N", 3e-3, digits=4) == "1.000 N"
    assert with_scatter(0.999999e-3, 3e-6, "N") == "1.000 ± 0.003 mN"
    # K* of 300 samples: an error of a third was told as of two thirds
    assert with_error(3268.0, 1012.0, 5) == "3,300 ± 1,100"
    assert with_error(2.6e-19, 2.9e-20, 8) == "(2.6 ± 0.3)e-19"
    assert with_error(0.5, 0.6, 5) == "0.5 ± 0.6" and with_error(1.0, 0.95, 5) == "1.00 ± 0.95"
    assert with_scatter(0.2512, 3e-4, "N") == "251.2 ± 0.3 mN"
    assert with_scatter(0.2512, 9.8e-4, "N") == "251.2 ± 1.0 mN"
    # both have one prefix: K* of few samples was 1.0 kN/m ± 600 N/m; what no digit shows is left out
    assert with_uncertainty(1000.0, 587.0, "N/m") == "1.0 ± 0.6 kN/m"
    assert with_uncertainty(1.74e-7, 7.4e-5, "N") == "0 ± 74 µN"
    assert with_scatter(0.2512, 3e-6, "N") == "251.2 mN"
    assert with_scatter(0.0, 3e-6, "N") == with_uncertainty(0.0, 3e-6, "N") == "0 ± 3 µN"
    assert with_scatter(1.778e-3, 6e-7, "N") == "1.7780 ± 0.0006 mN"
    assert with_scatter(1.25, 0.02, "N_c<k>·length") == "1.25 ± 0.02 N_c<k>·length"
    assert with_scatter(5.571e-9, 2e-11, "N_c<k>·m") == "(5.57 ± 0.02)e-09 N_c<k>·m"
    # the forces of one slider have no scatter
    assert with_uncertainty(0.2512, np.inf, "N") == "251.2 mN (error unknown)"
    assert of_surface(1e11, 200.0, 1e6, None).force == 2e13


def test_a_notebook_shows_a_table_and_completes_names() -> None:
    result = toolkit.run(scene(ROUGH, title="<b> & co", drive=DRIVE))
    html = result._repr_html_()
    assert "&lt;b&gt; &amp; co" in html and "mN" in html and html.count("<table>") == 1
    assert {"master", "newtons", "per_area", "to_xarray", "thresholds"} <= set(dir(result))
    assert not any(name.startswith("_") for name in dir(result))
    assert {"run", "load", "plot", "save"} <= set(dir(toolkit))


def test_a_missing_xarray_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(InputError, match=r"needs xarray; install mesofriction\[xarray\]"):
        toolkit.run(scene()).to_xarray()


def test_a_dataset_has_all_arrays_with_their_units() -> None:
    xarray: Any = pytest.importorskip("xarray")
    spring = {"to": 2e-8, "points": 41, "spring": "1e5 N/m", "area": AREA}
    eq = {"contacts": 500, "replicas": 2, "seed": 1}
    result = toolkit.run(scene(ROUGH, drive=spring, eq=eq))
    data = result.to_xarray()
    assert isinstance(data, xarray.Dataset)
    np.testing.assert_allclose(data.master_force, result.newtons(result.master.force), rtol=1e-15)
    assert data.master_force.units == "N" and data.path.units == data.threshold.units == "m"
    error = result.newtons(result.master.force_error * result.mean_threshold)
    assert data.master_force.error == pytest.approx(float(error), rel=1e-12)
    assert data.eq_forces.dims == ("replica", "point") and data.eq_forces.units == "N"
    np.testing.assert_array_equal(data.eq_slip_drive, result.eq.slips.drive)
    sweep = {"velocity": [1e-6, 1e-5], "critical_spring": True}
    swept = toolkit.run(scene(ROUGH, drive=DRIVE, sweep=sweep)).to_xarray()
    assert swept.sweep_critical_spring.units == "N/m" and swept.sweep_velocity.units == "m/s"
    assert swept.sweep_force.units == "N"
    sweep = {"contacts.thresholds.pressure": [1e5, 1e6]}
    pressures = toolkit.run(scene(ROUGH, drive=None, master=None, sweep=sweep))
    assert pressures.to_xarray()["sweep_contacts.thresholds.pressure"].units == "Pa"


@pytest.mark.parametrize(
    ("command", "picture"),
    [slow("run", "picture"), ("thresholds", "thresholds"), slow("compare", "compare")],
)
def test_pictures_are_written_in_other_formats_too_and_old_ones_go(
    capsys: Any, monkeypatch: Any, command: str, picture: str
) -> None:
    """The whole picture of a run; of other commands an empty figure, as all formats are written by one function."""
    name = write(drive={"to": 1.0, "points": 3})
    save, empty = Figure.savefig, Figure()
    begins = {"png": b"\x89PNG", "pdf": b"%PDF", "svg": b"<?xml"}
    if command != "run":
        monkeypatch.setattr(Figure, "savefig", lambda _, *where, **how: save(empty, *where, **how))
    words = (command, name, "--out", "out")
    assert said(capsys, *words, "--format", "pdf,svg")[0] == 0
    for suffix, begin in begins.items():
        assert (Path("out") / f"{picture}.{suffix}").read_bytes().startswith(begin)
    assert said(capsys, *words, "--format", "png")[0] == 0
    left = {file.suffix for file in Path("out").glob(f"{picture}.*")}
    assert ".png" in left and not left & {".pdf", ".svg"}
    line = refused(capsys, "run", name, "--format", "jpg")
    assert line == "format = 'jpg': must be among png, pdf and svg, such as --format pdf,svg"


STATED = {"mean_stiffness": 5.0, "contact_density": 5e11, "pressure": 1e6}
IN_METRES = {"kind": "gaussian", "mean": 4e-9, "std": 1e-9}
TOGETHER = 5.0 * 5e11 * AREA  # N_c<k>, N/m


def stated(**tables: Any) -> dict[str, Any]:
    """A scene of Gaussian contacts in metres whose interface is stated, on a spring of 50 N/m."""
    contacts = {"thresholds": IN_METRES, "interface": STATED} | tables.pop("contacts", {})
    drive = {"spring": "50 N/m", "area": AREA, "to": 2e-8, "points": 11}
    return scene(**({"contacts": contacts, "drive": drive} | tables))


def test_a_stated_interface_gives_newtons_kelvins_and_springs_as_a_surface_does(
    capsys: Any,
) -> None:
    """N_c<k> = 2.5e6 N/m: 50 N/m are 2e-5 of it, k_BT/<k> at 300 K is 8.28e-22 m², and F_k = <x²>/2<x> times N_c<k>."""
    heat = {"law": "soft", "temperature": {"kelvin": 300.0}, "attempt_frequency": 1e6}
    warm = toolkit.load_scene(stated(contacts={"thermal": heat}))
    assert warm.drive.spring == pytest.approx(50.0 / TOGETHER, rel=1e-12)
    assert warm.contacts.thermal.temperature == pytest.approx(1.380649e-23 * 300.0 / 5.0, rel=1e-9)
    assert warm.contacts.replace(thermal=None).interface == warm.contacts.interface
    drive = {"to": 4e-7, "points": 21, "area": AREA}
    toolkit.run(stated(drive=drive), folder="out")
    found, law = toolkit.load("out"), warm.contacts.thresholds
    kinetic = law.moment(2) / (2.0 * law.mean())
    assert found.newtons(found.master.force)[-1] == pytest.approx(TOGETHER * kinetic, rel=1e-4)
    assert found.scale.force_unit == "N" and found.scale.load == pytest.approx(1.0)
    file = Path("mine.toml")
    file.write_text(
        toolkit.scene.tables.to_toml(stated(verdict={"rules": ["reset"]})), encoding="utf-8"
    )
    status, out, _ = said(capsys, "verdict", "mine.toml")
    row = next(line for line in out if line.startswith("kinetic friction F_k"))
    assert status == 0 and written(TOGETHER * kinetic, "N", digits=4) in row
    assert "stick-slip" in out[2] and " mm at " not in out[2]
    assert said(capsys, "thresholds", "mine.toml")[0] == said(capsys, "run", "mine.toml")[0] == 0


def test_what_a_stated_interface_lacks_is_refused_with_what_to_give() -> None:
    alone = {"interface": {"mean_stiffness": 5.0}}
    with pytest.raises(InputError, match=r"contacts\.interface\.contact_density"):
        toolkit.load_scene(stated(contacts=alone))
    kelvin = {"thermal": {"law": "soft", "temperature": {"kelvin": 300.0}}}
    with pytest.raises(InputError, match="attempt_frequency: is missing"):
        toolkit.load_scene(stated(contacts=alone | kelvin, drive={"to": 1e-8}))
    with pytest.raises(InputError, match="has its own; leave it out"):
        toolkit.load_scene(stated(contacts={"thresholds": ROUGH}))
    with pytest.raises(InputError, match=r"contacts.interface.mean_stiffness = -1"):
        toolkit.load_scene(stated(contacts={"interface": {"mean_stiffness": -1.0}}))


def test_a_wrong_unit_is_asked_for_by_its_key(capsys: Any) -> None:
    """Samples without a unit, an island whose amplitude is in eV, one without a period, 1 m² of area: one line each,
    before the numbers; right ones ask nothing."""
    stated = {"mean_stiffness": 50.0, "contact_density": 5e11, "pressure": 1e6}
    samples = {"kind": "from-samples", "x_s": list(np.linspace(0.5, 1.5, 40)), "unit": "nm"}
    wave = {"kind": "hexagonal", "amplitude": 8e-21, "period": 2.46e-10}
    island = {"kind": "domains", "law": "equal", "stiffness": 50.0, "substrate": wave}
    island |= {"lattice_constant": 2.88e-10, "sizes": [[6, 6]], "angles": [0.1, 0.2, 0.3]}
    for law in (samples, island):
        assert not of_units(loaded(law, stated).thresholds)
    for law, begins, key in (
        (
            {**samples, "unit": None},
            "<x_s> is 1 m and F_k/load is 1.4e+07: ",
            "unit of the samples",
        ),
        (island | {"substrate": wave | {"amplitude": 0.05}}, "<x_s> is ", "amplitude in J"),
        (island | {"substrate": wave | {"period": 1.0}}, "<x_s> is ", "period in m"),
    ):
        (asked,) = of_units(loaded(law, stated).thresholds)
        assert asked.startswith(begins) and "F_k/load is" in asked and key in asked
        assert "[contacts.interface]" in asked
    millimetres = loaded(samples | {"unit": "mm"}, stated | {"pressure": None})
    (asked,) = of_stretch(millimetres, 1e-3)
    assert "is the unit of the samples right, as <x_s> is 0.001 m" in asked
    contacts = {"thresholds": ROUGH}
    drive = {"spring": "50 N/m", "area": 1.0, "to": 1.0, "points": 3}
    _, _, said_first = said(capsys, "run", write(contacts=contacts, drive=drive), "--dry-run")
    assert any("stretches the spring by" in line and "drive.area" in line for line in said_first)
    drive["area"] = 1e-6
    _, _, said_first = said(capsys, "run", write(contacts=contacts, drive=drive), "--dry-run")
    assert not any("stretches the spring" in line for line in said_first)


def test_a_value_and_its_scatter_have_as_many_places() -> None:
    """Those that the scatter leaves."""
    for value, error, told in (
        (6.637e6, 1.04e6, "6.6 ± 1.0 MN/m"),
        (12.34, 4.6, "12 ± 5 N/m"),
        (3.11e-3, 1.2e-4, "3.1 ± 0.1 mN/m"),
    ):
        assert with_scatter(value, error, "N/m") == told


@pytest.mark.slow  # quick: the test before, and samples of a file
def test_samples_in_newtons_have_the_places_that_their_scatter_leaves(
    capsys: Any, monkeypatch: Any
) -> None:
    """With prefixes, and heat in words."""
    monkeypatch.setattr("toolkit.judge.describe.RESAMPLES", 3)
    law = {"kind": "from-samples", "f_s": [0.8, 0.9, 1.0, 1.1, 1.4], "unit": "nN", "stiffness": 5.0}
    stated = {"mean_stiffness": 5.0, "contact_density": 5e14, "pressure": 1e6}
    heat = {"law": "stiff", "temperature": {"kelvin": 300.0}, "attempt_frequency": 1e10}
    contacts = {"thresholds": law, "interface": stated, "thermal": heat}
    drive = {"area": 1e-8, "to": 1e-9, "points": 3}
    _, out, _ = said(capsys, "thresholds", write(contacts=contacts, drive=drive))
    page = "\n".join(out)
    assert re.search(r"kinetic force of the area +2\.\d+ ± 0\.\d+ mN ", page)
    assert re.search(r"critical spring of the area +\S+ ± \S+ MN/m ", page)
    assert "stiff heat at 300 K (attempt frequency 1e+10/s)" in page and "Thermal(" not in page


def test_a_small_area_of_contact_is_not_told_as_none() -> None:
    """Under 1 Pa."""
    drive = {"to": 1e-8, "points": 3}
    for pressure, share in ((1.0, r"\d\.\de-0\d%"), (1e6, r"\d\.\d\d%")):
        result = toolkit.run(scene(ROUGH | {"pressure": pressure}, drive=drive))
        (line,) = [line for line in report(result) if line.startswith("surface ")]
        assert re.search(f", area of contact {share}; thresholds", line), line


def test_the_regime_has_the_digits_that_samples_leave() -> None:
    """K* of eighty samples has two, that of a law more."""
    drive = {"to": 3.0, "points": 11, "spring": 0.1}
    for law, digits in (
        ({"kind": "from-samples", "x_s": np.linspace(0.4, 1.7, 80).tolist()}, 2),
        ({"kind": "gaussian", "mean": 1.0, "std": 0.2}, 6),
    ):
        reason = toolkit.run(scene(law, drive=drive)).master.regime.reason
        found = re.search(r"K = 0\.1 N_c<k>, a rigid slider as fast .* K\* = (\d\.\d+)", reason)
        assert found and len(found[1].replace(".", "").lstrip("0")) == digits, reason


def test_a_run_on_a_spring_is_told_in_newtons_and_metres(capsys: Any) -> None:
    """Its regime, its period, and how late the slips of the ensemble come."""
    drive = {"spring": "1 kN/m", "area": 1e-6, "to": 1e-3, "points": 20}
    eq = {"contacts": 500, "replicas": 2}
    _, out, _ = said(capsys, "run", write(contacts={"thresholds": ROUGH}, drive=drive, eq=eq))
    page = "\n".join(out)
    assert re.search(
        r"K = 1\.000 kN/m, a rigid slider as fast as the drive has K\* = (\d\.\d|\d\d|\d00) .?N/m",
        page,
    )
    assert re.search(r"^slip    from \d{3} mN to 0 N, the last", page, re.MULTILINE)
    assert re.search(r"last period \d{3} µm: ", page)
    assert re.search(r"place in eq less that of the master equation: \S+ ± \S+ .m", page)
    assert "K = " in page and "N_c<k>, a rigid" not in page and " of <x_s>, " not in page


def test_a_mass_or_a_number_of_contacts_beyond_any_sliders_is_asked_about() -> None:
    contacts = toolkit.load_scene(scene(contacts={"thresholds": ROUGH})).contacts
    for area, mass, key in ((1e-6, 1e9, "drive.mass"), (1e-13, 1.0, "drive.area"), (1e-6, 0.1, "")):
        scale = scale_of(contacts, area)
        asked = of_machine(scale, mass / scale.spring)
        assert [key in one for one in asked] == [True] * bool(key)
    assert not of_machine(scale_of(contacts, None), 1e9)  # M/N_c<k> alone: no mass is known


def test_constants_of_a_surface_are_asked_for_by_what_others_call_them(capsys: Any) -> None:
    modulus = {"contact_modulus": None, "youngs_modulus": 3e9, "local_friction": 0.4}
    for material, told in (
        (modulus, "give contact_modulus, E* = E/(1 - nu²) on a rigid flat"),
        ({"local_friction": "0,4"}, "local_friction = '0,4': must be a number, write 0.4"),
    ):
        own = {k: v for k, v in (ROUGH["material"] | material).items() if v is not None}
        file = write(thresholds=ROUGH | {"material": own}, drive={"to": 1e-7, "points": 3})
        assert told in refused(capsys, "run", file)


def loaded(law: dict[str, Any], stated: dict[str, Any]) -> Any:
    """Contacts of these tables, without the keys of value None."""
    law = {name: value for name, value in law.items() if value is not None}
    return toolkit.load_scene(scene(contacts={"thresholds": law, "interface": stated})).contacts


@pytest.mark.parametrize(
    "name", ["eyring", "rough-gw-paper", "rough-persson-amontons", "rotated-domains", "samples"]
)
def test_shipped_scenes_ask_for_no_unit(name: str) -> None:
    contacts = load_scene(name).contacts
    assert not of_units(contacts.thresholds) and not of_stretch(contacts, 1e-6)


def test_a_critical_spring_below_its_numerical_error_is_not_told() -> None:
    """By `thresholds` and by `run`; one below the error of its samples is."""
    for error, sampled, told in ((6.0, False, "not known"), (6.0, True, "3 ± 6"), (1.0, False, "")):
        own = {"critical_spring": Number(3.0, error, "N_c<k>")}
        (line,) = (
            one
            for one in table_of(Description(own, (), True, sampled, 1.0), (), ())
            if "critical spring" in one
        )
        assert told in line and ("N_c<k>" in line) == (told != "not known")
    result = toolkit.run(scene(drive={"to": 2.0, "points": 21, "spring": 0.5}))
    for error, told in ((1e-9, "spring  K* = "), (2e3, "spring  K* is not known")):
        regime = replace(result.master.regime, critical_spring_error=error)
        other = replace(result, master=replace(result.master, regime=regime))
        assert sum(line.startswith(told) for line in in_words(other)) == 1


def test_samples_of_a_file_have_a_unit(monkeypatch: Any) -> None:
    monkeypatch.setattr("toolkit.judge.describe.RESAMPLES", 2)
    Path("md.csv").write_text("run,x_s\n1,4.0\n2,5.0\n3,6.5\n", encoding="utf-8")
    table = {"kind": "from-samples", "file": "md.csv", "column": "x_s"}
    bare = toolkit.load_scene(scene(table)).contacts.mean_threshold
    law = table | {"unit": "nm"}
    assert toolkit.load_scene(scene(law)).contacts.mean_threshold == pytest.approx(1e-9 * bare)
    units = [toolkit.load_scene(scene(one)).scale.length_unit for one in (table, law)]
    assert units == ["length", "m"]
    results = [toolkit.run(scene(one, master={"tolerance": 1e-3})) for one in (table, law)]
    assert [one.thresholds.in_metres for one in results] == [False, True]
    assert [one.scale.force_unit for one in results] == ["N_c<k>·length", "N_c<k>·m"]
    numbers = describe(toolkit.load_scene(scene(law)).contacts).numbers
    assert (numbers["mean"].unit, numbers["kinetic_force"].unit) == ("m", "N_c<k>·m")
    fixed = {"kind": "identical", "value": 4e-9}
    mixed = scene({"kind": "mixture", "components": [law, fixed], "weights": [0.9, 0.1]})
    assert toolkit.load_scene(mixed).scale.length_unit == "m"
    forces = {"kind": "from-samples", "f_s": [2.0, 3.0, 4.5], "unit": "nN", "stiffness": 5.0}
    assert 4e-10 < toolkit.load_scene(scene(forces)).contacts.mean_threshold < 9e-10
    with pytest.raises(InputError, match="unit = 'furlong': must be"):
        toolkit.load_scene(scene(law | {"unit": "furlong"}))
    del law["column"]
    with pytest.raises(InputError, match='holds 2 columns; say which has x_s, as column = "x_s"'):
        toolkit.load_scene(scene(law))


def test_a_power_that_few_samples_leave_open_is_told_from_where_to_where() -> None:
    told = [onset_in_words(Number(0.0, error, ""), 8) for error in (0.0, 0.04, 12.3, np.inf)]
    assert told == ["0", "0.00 ± 0.04", "0 to 12", "0, error not known"]
    assert onset_in_words(Number(3.0, 2.0, ""), 8) == "1 to 5"
    assert onset_in_words(Number(np.inf, 0.0, ""), 8) == "infinite"
    endless = {"critical_spring": Number(np.inf, 0.0, "N_c<k>")}
    line, _ = table_of(Description(endless, (), True, False, 1.0), (), ())
    assert line.split() == ["critical", "spring", "infinite"]


def test_an_error_that_is_not_known_is_told_behind_the_unit() -> None:
    numbers = {
        "critical_spring": Number(0.0, np.inf, "N_c<k>"),
        "static_to_kinetic": Number(1.0, np.inf, ""),
    }
    spring, ratio, _ = table_of(Description(numbers, (), True, True, 1.0), (), ())
    assert spring.endswith("  0 N_c<k>, error not known") and ratio.endswith("  1, error not known")


@pytest.mark.parametrize("unit", [{"unit": "nN"}, {}])
@pytest.mark.parametrize("stated, refused", [(20.0, False), (20, False), (5.0, True)])
def test_a_stiffness_stated_twice_is_one(
    stated: float, refused: bool, unit: dict[str, str]
) -> None:
    """Forces in nN over 20 N/m are lengths, which 5 N/m would turn into forces of a quarter; so are forces in newtons,
    which need no unit."""
    law = {"kind": "from-samples", "f_s": [1e-9, 2e-9, 3e-9], "stiffness": 20.0} | unit
    interface = {"mean_stiffness": stated, "contact_density": 1e12}
    tables: dict[str, Any] = {"contacts": {"thresholds": law, "interface": interface}}
    if not refused:
        toolkit.load_scene(tables, solved=False)
        return
    with pytest.raises(InputError, match=r"mean_stiffness = 5.*stiffness = 20 N/m turned forces"):
        toolkit.load_scene(tables, solved=False)


@pytest.mark.parametrize("stated", [False, True])
@pytest.mark.parametrize("unit", [None, "Å"])
@pytest.mark.parametrize("amplitude", [None, -3.2e-21])
def test_an_island_in_metres_without_an_energy_is_refused(
    amplitude: float | None, unit: str | None, stated: bool
) -> None:
    """1 is the unit of energy of an island in units of its own, and beside metres it would be 1 J an atom."""
    scale = 1.0 if unit else 1e-10
    origins.circular_island(2.88 * scale, radius=6.0 * scale).write("flake.traj")
    island = {"kind": "file", "file": "flake.traj"} | ({"unit": unit} if unit else {})
    substrate = {"kind": "hexagonal", "period": 2.46e-10}
    substrate |= {"amplitude": amplitude} if amplitude else {}
    law = {"kind": "domains", "law": "equal", "stiffness": 32.0, "samples": 50}
    contacts: dict[str, Any] = {"thresholds": law | {"island": island, "substrate": substrate}}
    if stated:
        contacts["interface"] = {"mean_stiffness": 32.0, "contact_density": 1e13}
    if amplitude or not (unit or stated):
        toolkit.load_scene({"contacts": contacts}, solved=False)
        return
    with pytest.raises(InputError, match=r"^contacts.thresholds.substrate.amplitude: is missing"):
        toolkit.load_scene({"contacts": contacts}, solved=False)


@pytest.mark.parametrize("unit", [None, "Å"])
def test_an_island_in_another_unit_than_its_substrate_is_refused(unit: str | None) -> None:
    """Atoms 2.88 Å apart, read as 2.88 m, have a barrier, too, of another size, on a substrate of 2.46 Å."""
    origins.circular_island(2.88, radius=6.0).write("flake.xyz")
    island = {"kind": "file", "file": "flake.xyz"} | ({"unit": unit} if unit else {})
    substrate = {"kind": "hexagonal", "amplitude": -3.2e-21, "period": 2.46e-10}
    law = {"kind": "domains", "law": "equal", "stiffness": 32.0, "samples": 50}
    law |= {"island": island, "substrate": substrate}
    if unit:
        toolkit.load_scene({"contacts": {"thresholds": law}}, solved=False)
        return
    with pytest.raises(
        InputError,
        match=r"2.88 from the next, on a substrate whose rows are 2.13e-10 apart.*unit = ",
    ):
        toolkit.load_scene({"contacts": {"thresholds": law}}, solved=False)


def test_in_heat_the_barriers_of_islands_stand_beside_those_that_heat_overcomes() -> None:
    """k x_s²/2 and epsilon of the same islands, of which x_s = epsilon/(a k): the same at k = epsilon/2a²."""
    origins.circular_island(2.88, radius=6.0).write("flake.xyz")
    substrate = {"kind": "hexagonal", "amplitude": -3.2e-21, "period": 2.46e-10}
    law = {"kind": "domains", "law": "equal", "stiffness": 32.0, "samples": 1000}
    law |= {"island": {"kind": "file", "file": "flake.xyz", "unit": "Å"}, "substrate": substrate}
    heat = {"law": "soft", "temperature": {"kelvin": 300.0}, "attempt_frequency": 1e10}
    stated = {"mean_stiffness": 32.0, "contact_density": 1e13}
    contacts = {"thresholds": law, "thermal": heat, "interface": stated}
    loaded = toolkit.load_scene({"contacts": contacts}, solved=False)
    barriers = loaded.contacts.thresholds.domains.barriers
    joules, period = 1.380649e-23 * 300.0, 2.46e-10
    at_break = 32.0 * np.mean(np.square(barriers / (32.0 * period))) / 2.0
    (note,) = of_temperature(loaded.contacts)
    own = barriers.mean() / joules
    assert note.startswith(f"the islands' own barriers are on average {own:.2g} k_BT, and heat")
    (told,) = re.findall(r"overcomes (\S+) k_BT", note)
    assert float(told) == pytest.approx(at_break / joules, rel=0.05)  # two digits, of a smooth law
    assert doubts(loaded.contacts) == [note]  # e³ times as often, or more: before the answer
    (width,) = re.findall(r"width = (\S+) has their mean barrier", note)
    assert 1.0 / float(width) == pytest.approx(own, rel=0.05)
    alike = loaded.contacts.replace(
        thermal=origins.Thermal("eyring", width=1.0 / own, attempt_frequency=1e10)
    )
    assert not of_temperature(alike) and not doubts(alike)
    (cold,) = of_temperature(loaded.contacts.replace(thermal=None))
    (headline,) = of_cold(loaded.contacts.replace(thermal=None))
    assert f"{own:.2g} k_BT" in headline and not of_cold(loaded.contacts)
    known = f"all is told at T = 0: the islands' own barriers are on average {barriers.mean() / joules:.2g} k_BT"
    assert cold.startswith(f"{known} at 300 K") and f"with width = {1.0 / own:.2g} of" in cold
    # nothing is said where they are too high for heat
    law |= {"substrate": substrate | {"amplitude": -6.4e-20}}
    high = {"thresholds": law, "interface": stated}
    loaded = toolkit.load_scene({"contacts": high}, solved=False)
    assert loaded.contacts.thresholds.domains.barriers.mean() > 30.0 * joules
    assert not of_temperature(loaded.contacts) and not of_cold(loaded.contacts)


@pytest.mark.parametrize("seed", range(30))
def test_the_factor_of_linked_stiffness_is_that_of_both_forces(seed: int) -> None:
    """F_k of the master equation with both stiffnesses, of laws drawn at random."""
    generator = np.random.default_rng(seed)
    mean, width = generator.uniform(0.3, 3.0), generator.uniform(0.1, 0.6)
    law = origins.gaussian(mean, width * mean)
    linked, own = (
        steady_state(origins.Contacts(law, stiffness=one)).force
        for one in ("linked", "independent")
    )
    (note,) = of_linked(origins.Contacts(law, stiffness="linked"))
    (told,) = re.findall(r"F_k is 1/(\S+) of this", note)
    assert float(told) == pytest.approx(linked / own, rel=5e-3)
    assert not of_linked(origins.Contacts(law))


def test_what_solvers_say_of_places_and_times_has_units() -> None:
    """A note said "from X_T = 1.42471e-06 on it creeps" of a scene in metres; numbers keep their digits."""
    contacts = load_scene(scene(ROUGH, drive={"area": 1e-6}, master=None), solved=False).contacts
    scale = scale_of(contacts, 1e-6)
    bare = "from X_T = 1.42471e-06, X_T = 0.5 on it creeps; near t = 12.5, X = -3e-06. So it ends"
    units = "from X_T = 1.42471 µm, X_T = 500 mm on it creeps; near t = 12.5 s, X = -3.00 µm. So it ends"
    assert with_units_of(scale, bare) == units
    damped = with_units_of(scale, "its damping is 0.002, so it lasts some 3e-05 longer")
    found = re.fullmatch(r"its damping is ([\d,]+) N s/m, so it lasts some 30.0 µs longer", damped)
    assert found and float(found[1].replace(",", "")) == pytest.approx(
        2e-3 * scale.spring, rel=1e-3
    )
    assert with_units_of(scale_of(origins.Contacts(origins.gaussian(1.0, 0.2)), None), bare) == bare
