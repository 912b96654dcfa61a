"""Scenes that go along speeds, temperatures, rates of ageing or delays."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import master
import toolkit
from origins import InputError
from origins.roughness.interface import BOLTZMANN
from toolkit.command import main

THRESHOLDS = {"kind": "gaussian", "mean": 1.0, "std": 0.05}
WARM = {"thresholds": THRESHOLDS, "thermal": {"law": "soft", "temperature": 0.3}}
SPEEDS = {"from": 1e-2, "to": 1e2, "points": 5}


def scene(sweep: dict[str, Any], contacts: dict[str, Any] | None = None) -> dict[str, Any]:
    return {"contacts": WARM if contacts is None else contacts, "sweep": sweep}


def test_a_sweep_is_what_the_master_equation_says_and_comes_back(tmp_path: Path) -> None:
    asked = scene({"velocity": [0.1, 1.0, 10.0], "temperature": [0.1, 0.3], "delay": 0.05, "critical_spring": True})
    result = toolkit.run(asked, folder=tmp_path / "out")
    contacts, found = toolkit.load_scene(asked).contacts, result.sweep
    assert found is not None and result.success and result.master is None and result.time.size == 0
    curve = master.kinetic_curve(contacts, [[0.1], [1.0], [10.0]], temperature=[0.1, 0.3], delay=0.05)
    assert found.along == ("velocity", "temperature") and found.velocity.shape == (3, 2)
    np.testing.assert_array_equal(found.force, curve.force)
    assert found.critical_spring is not None
    assert found.critical_spring[1, 0] == master.phase_line(contacts, temperature=0.1, delay=0.05).critical_spring
    again = toolkit.load(tmp_path / "out").sweep
    assert again is not None and again.along == found.along and again.kelvin is None and again.rate is None
    for name in ("velocity", "temperature", "delay", "force", "force_error", "holding", "critical_spring_error"):
        np.testing.assert_array_equal(getattr(again, name), getattr(found, name))
    assert again.success and again.message == found.message != ""
    head, *lines = (tmp_path / "out" / "sweep.csv").read_text().splitlines()
    assert head.startswith("velocity [length / time],force [length],force_error [<x_s>],holding,holding_error,temperat")
    table = np.array([line.split(",") for line in lines], dtype=float)
    np.testing.assert_array_equal(table[:, 1], found.force.ravel())
    np.testing.assert_array_equal(table[:, -2], found.critical_spring.ravel())
    told = json.loads((tmp_path / "out" / "summary.json").read_text())["sweep"]
    assert told["points"] == 6 and told["largest_force_error"] == found.force_error.max() and told["success"]


def test_a_picture_has_a_line_for_each_value_of_the_second_quantity() -> None:
    from matplotlib.figure import Figure

    result = toolkit.run(scene({"velocity": SPEEDS, "temperature": [0.1, 0.3]}))
    axes = Figure().subplots(1, 2)
    toolkit.plot(result, axes)
    assert axes[0].get_xscale() == "log" and len(axes[0].lines) == 2
    assert [text.get_text()[-5:] for text in axes[0].get_legend().get_texts()] == ["= 0.1", "= 0.3"]
    assert result.sweep is not None
    np.testing.assert_array_equal(axes[0].lines[1].get_ydata(), result.sweep.force[:, 1])
    assert axes[0].get_title() == "scene"


def test_sweeps_go_beside_a_run_and_along_kelvins(tmp_path: Path, capsys, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    rough = toolkit.load_scene("rough-gw-amontons").text
    surface = rough[rough.index("[contacts") : rough.index("[drive]")]
    thermal = '[contacts.thermal]\nlaw = "soft"\ntemperature = { kelvin = 300.0 }\nattempt_frequency = 1.0\n'
    sweep = "[sweep]\nkelvin = { from = 100.0, to = 300.0, points = 3, spacing = 'even' }\n"
    drive = "[drive]\nto = 1e-6\npoints = 11\nvelocity = 1e-6\n[master]\ntolerance = 1e-4\n"
    Path("mine.toml").write_text(surface + thermal + drive + sweep)
    assert main(["run", "mine.toml", "--out", "out"]) == 0
    told = capsys.readouterr().out
    assert "3 points along kelvin" in told and "master  error" in told
    found = toolkit.load("out").sweep
    interface = toolkit.load_scene("mine.toml").contacts.interface
    assert found is not None and interface is not None and found.temperature is not None and found.kelvin is not None
    assert found.kelvin.tolist() == [100.0, 200.0, 300.0] and (found.velocity == 1e-6).all()
    np.testing.assert_allclose(found.temperature, BOLTZMANN * found.kelvin / interface.mean_stiffness, rtol=1e-14)


@pytest.mark.parametrize(
    ("sweep", "says"),
    [
        ({}, "sweep: goes along nothing"),
        ({"velocity": 2.0}, "sweep: goes along nothing"),
        ({"velocity": "fast"}, "sweep.velocity: expected float | table | array"),
        ({"velocity": []}, "sweep.velocity = []: must hold a value"),
        ({"velocity": [1.0, 0.0]}, "sweep.velocity[1] = 0.0: must be above zero"),
        ({"delay": [1.0, -1.0]}, "sweep.delay[1] = -1.0: must be zero or above"),
        ({"velocity": SPEEDS | {"points": 1}}, "sweep.velocity.points = 1: must be a whole number of at least 2"),
        ({"velocity": SPEEDS | {"to": 1e-2}}, "sweep.velocity.to = 0.01: is where sweep.velocity begins"),
        ({"velocity": SPEEDS | {"spacing": "wide"}}, "sweep.velocity.spacing = 'wide': must be \"log\" or \"even\""),
        ({"velocity": {"from": 1.0}}, "sweep.velocity.to: is missing"),
        ({"temperature": SPEEDS | {"from": 0.0}}, 'temperature.from = 0.0: has no logarithm; write spacing = "e'),
        ({"rate": [0.0, 1.0]}, "sweep.rate: the contacts have no law for it; add [contacts.ageing]"),
        ({"kelvin": [1.0, 2.0]}, "sweep.kelvin: needs <k> in N/m"),
        ({"kelvin": 1.0, "temperature": 1.0}, "sweep: has temperature and kelvin; give one of them"),
        ({"velocity": [1.0, 2.0], "delay": [1.0, 2.0], "temperature": [1.0, 2.0]}, "have several values each"),
        ({"velocity": SPEEDS | {"points": 1000}, "delay": SPEEDS | {"points": 1000}}, "sweep: has 1,000,000 points"),
        ({"speed": 1.0}, "sweep.speed: unknown key; known here: velocity, temperature, kelvin,"),
    ],
)  # fmt: skip
def test_sweeps_that_cannot_be_are_refused(sweep: dict[str, Any], says: str) -> None:
    with pytest.raises(InputError) as refusal:
        toolkit.load_scene(scene(sweep))
    assert says in str(refusal.value) and "\n" not in str(refusal.value)


