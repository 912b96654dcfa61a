"""The tutorials: their code and scenes run as a reader would run them, and print the numbers that they tell."""

import io
import json
import re
import shlex
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scenes import said

import master
import origins
from toolkit.scene.scale import scale_of
from toolkit.scene.scene import load_scene

DOCS = Path(__file__).parents[1] / "docs"
SCENES = {
    "tutorial-thresholds.md": "polymer.toml",
    "tutorial-ensemble.md": "film.toml",
    "tutorial-structure.md": "flake.toml",
}


@pytest.fixture
def page(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """The text of a tutorial, in a folder with its scene."""
    monkeypatch.chdir(tmp_path)
    text = (DOCS / request.param).read_text(encoding="utf-8")
    scene, *_ = re.findall(r"```toml\n(.*?)```", text, re.DOTALL)
    Path(SCENES[request.param]).write_text(scene, encoding="utf-8")
    return text


def run(code: str, names: dict[str, Any]) -> str:
    """What a piece of code prints; it adds to the names."""
    printed = io.StringIO()
    with redirect_stdout(printed):
        exec(compile(code, "tutorial", "exec"), names)
    return printed.getvalue()


def python(page: str) -> list[str]:
    return re.findall(r"```python\n(.*?)```", page, re.DOTALL)


@pytest.mark.parametrize("page", ["tutorial-thresholds.md"], indirect=True)
def test_a_surface(page: str, capsys: Any) -> None:
    pytest.importorskip("SurfaceTopography")
    run(python(page)[0], {})
    status, out, _ = said(capsys, "thresholds", "polymer.toml")
    found = json.loads(Path("polymer-output/thresholds.json").read_text(encoding="utf-8"))[
        "numbers"
    ]
    told = {name: number["value"] for name, number in found.items()}
    assert (
        status == 0
        and "8% of the contacts, which bear 35% of the load, would be plastic" in "\n".join(out)
    )
    assert f"{told['mean'] * 1e9:.2f} nm on average" in page
    assert f"deviation of {told['standard_deviation'] * 1e9:.2f} nm" in page
    assert f"contacts of {told['mean_stiffness']:.0f} N/m" in page
    assert f"friction is {told['kinetic_force_of_the_area'] * 1e3:.0f} mN" in page
    assert f"softer than {told['critical_spring_of_the_area'] * 1e-3:.2g} kN/m" in page
    # of 0.1 kg on 50 N/m, with 0.5 N s/m
    static = told["kinetic_force_of_the_area"] * told["static_to_kinetic"]
    fast, zeta = static / 5.0**0.5, 0.25 / 5.0**0.5
    left = np.exp(-np.pi * zeta / (1.0 - zeta**2) ** 0.5)
    assert f"F_s = {static * 1e3:.0f} mN" in page and f"(K M)^(1/2) = {fast * 1e3:.0f} mm/s" in page
    assert f"<x_s>/V = {told['mean'] / fast * 1e9:.0f} ns" in page and f"ζ = {zeta:.2f}" in page
    assert f"(M/K)^(1/2) = {np.pi * 0.002**0.5 * 1e3:.0f} ms" in page
    assert f"leaves {left:.2f}: the force falls by {1.0 + left:.2f} of itself" in page


@pytest.mark.parametrize("page", ["tutorial-thresholds.md"], indirect=True)
def test_scan_load_machine_and_heat_are_a_scene_of_twenty_lines(page: str, capsys: Any) -> None:
    pytest.importorskip("SurfaceTopography")
    run(python(page)[0], {})
    _, more = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    with Path("polymer.toml").open("a", encoding="utf-8") as file:
        file.write(more)
    lines = Path("polymer.toml").read_text(encoding="utf-8").splitlines()
    assert sum(bool(line.strip()) for line in lines) <= 20
    status, out, err = said(capsys, "show", "polymer.toml")
    asked = {'spring = "50 N/m"', 'mass = "0.1 kg"', "area = 1e-06", "velocity = 1e-06"}
    asked |= {"pressure = 1000000.0", "temperature = {kelvin = 300.0}", 'file = "scan.txt"'}
    assert (status, err) == (0, []) and asked <= set(out)
    contacts = load_scene("polymer.toml", solved=False).contacts
    stiffness, thermal = contacts.interface.mean_stiffness, contacts.thermal
    assert thermal.temperature == pytest.approx(1.380649e-23 * 300.0 / stiffness, rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("page", ["tutorial-thresholds.md"], indirect=True)
def test_the_verdict_on_a_surface(page: str, capsys: Any) -> None:
    pytest.importorskip("SurfaceTopography")
    run(python(page)[0], {})
    status, out, _ = said(capsys, "verdict", "polymer.toml")
    (told,) = re.findall(r"```text\n(.*?)```", page, re.DOTALL)
    assert status == 0 and told in "\n".join(out)
    assert "23 kN/m to 7.1 MN/m" in "\n".join(out) and "23 kN/m to 7.1 MN/m" in page


@pytest.mark.slow
@pytest.mark.parametrize("page", ["tutorial-thresholds.md"], indirect=True)
def test_the_verdict_on_a_surface_with_a_mass(page: str, capsys: Any) -> None:
    """Its forces are means over sliders, of as many contacts as there is time for."""
    pytest.importorskip("SurfaceTopography")
    run(python(page)[0], {})
    (given,) = re.findall(r"    mesofriction (verdict polymer.toml --set .*)", page)
    more = ["--set", 'verdict.readings=["gw/amontons"]', "--set", "verdict.steps=[1]"]
    status, out, _ = said(capsys, *shlex.split(given), *more)
    kind, high, low, period = re.findall(
        r"\"([a-z-]+): (\d+) ± \d mN down to (-\d+) mN every ([\d.]+) mm", page
    )[0]
    found = json.loads(Path("polymer-output/verdict.json").read_text(encoding="utf-8"))
    (slips,) = found["readings"][0]["behaviours"]
    assert status == 0 and slips["kind"] == kind == "stick-slip"
    assert slips["before"] * 1e3 == pytest.approx(float(high), rel=0.01)
    assert slips["after"] * 1e3 == pytest.approx(float(low), rel=0.01)
    assert slips["period"] == pytest.approx(float(period) * 1e-3, rel=0.01)
    assert "form again at once would make it smooth at 253.3 mN" in "\n".join(out)


@pytest.mark.parametrize("page", ["tutorial-ensemble.md"], indirect=True)
def test_an_ensemble(page: str, capsys: Any) -> None:
    first, last = python(page)
    names: dict[str, Any] = {}
    run(first, names)
    status, out, _ = said(capsys, "run", "film.toml")
    assert status == 0 and any(re.match(r"slip +from 4\.9\d ± \S+ µN to 0 N", line) for line in out)
    (told,) = re.findall(r"```text\n(.*?)```", page, re.DOTALL)
    assert run(last, names) == told
    assert "4.95 ±" in told and "12.8 nm" in told and "12.8 nm and 12.8 ms" in page


@pytest.mark.parametrize("page", ["tutorial-structure.md"], indirect=True)
def test_a_structure(page: str) -> None:
    """At one angle the flake's barrier over the period is its force, and forces are in newtons."""
    pytest.importorskip("ase")
    from ase.io import read

    run(python(page)[0], {})
    changes = {"contacts.thresholds.angles": [0.3], "contacts.thresholds.samples": 1}
    scene = load_scene("flake.toml", solved=False, changes=changes)
    atoms = read("POSCAR")
    assert len(atoms) == 109 and "109 atoms" in page
    # in electronvolts and ångströms: 1 eV is 1.602e-19 J, and a threshold is ε/(a_s k)
    graphite = origins.hexagonal_substrate(-3.2e-21 / 1.602176634e-19, 2.46)
    force = origins.barrier(atoms, 0.3, graphite) / 2.46 * 1.602176634e-9
    assert scene.contacts.mean_threshold == pytest.approx(force / 32.0, rel=1e-6)
    assert scale_of(scene.contacts, 1e-6).force_unit == "N"


@pytest.mark.slow
@pytest.mark.parametrize("page", ["tutorial-structure.md"], indirect=True)
def test_heat_on_a_structure(page: str) -> None:
    """The law of heat whose barrier is the flakes' own, beside those with another one."""
    run(python(page)[0], {})
    for law, width, rate, newtons, told in (
        ("eyring", 0.15, 1e10, 17.3e-6, "17.3 µN"),
        ("eyring", 0.15, 1e12, 0.245e-6, "0.245 µN"),
        ("eyring", 0.015, 1e10, 1.28e-3, "1.28 mN"),
        ("soft", None, 1e10, 41.4e-9, "41.4 nN"),
        ("stiff", None, 1e10, 41.4e-9, "41.4 nN"),
    ):
        heat = {"temperature": {"kelvin": 300.0}} if width is None else {"width": width}
        heat |= {"law": law, "attempt_frequency": rate}
        scene = load_scene("flake.toml", solved=False, changes={"contacts.thermal": heat})
        force = scene.scale.force * master.steady_state(scene.contacts, velocity=1e-6).force
        assert force == pytest.approx(newtons, rel=5e-3) and told in page


@pytest.mark.slow
@pytest.mark.parametrize("page", ["tutorial-structure.md"], indirect=True)
def test_the_verdict_on_a_structure(page: str, capsys: Any) -> None:
    """Slips are means of as many contacts as there is time for: numbers agree to a hundredth."""
    run(python(page)[0], {})
    status, out, _ = said(capsys, "verdict", "flake.toml")
    (told,) = re.findall(r"```text\n(.*?)```", page, re.DOTALL)
    number = re.compile(r"\d+(?:\.\d+)?")
    assert status == 0
    # how many there is time for
    followed = re.compile(r"with [\d,]+ contacts, followed")
    told, *out = (followed.sub("with so many contacts, followed", one) for one in (told, *out))
    assert "with so many contacts, followed contact by contact, in place of the 10,000,000" in told
    for line in told.splitlines():
        # the same words, and numbers that hang on how many contacts there is time for
        (same,) = (one for one in out if number.sub("#", one) == number.sub("#", line))
        tolerance = 0.2 if "other samples" in line else 0.01
        found, expected = (list(map(float, number.findall(each))) for each in (same, line))
        assert found == pytest.approx(expected, rel=tolerance), same


@pytest.mark.slow
def test_notebook_prints_what_it_holds(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its code cells in their order, without a kernel: they are plain Python."""
    monkeypatch.chdir(tmp_path)
    notebook = json.loads((DOCS / "tutorial-origins.ipynb").read_text(encoding="utf-8"))
    assert notebook["nbformat"] == 4
    names: dict[str, Any] = {}
    cells = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    for number, cell in enumerate(cells, 1):
        kept = "".join(text for output in cell["outputs"] for text in output["text"])
        assert run("".join(cell["source"]), names) == kept and cell["execution_count"] == number
    assert kept.count("stick-slip") == 2 and kept.count("smooth") == 1
