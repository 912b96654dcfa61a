"""mesofriction compare: the ranking, the table, what is written, and what is refused."""

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import master
import toolkit
from toolkit.command import main
from toolkit.judge.compare import compare, table
from toolkit.pictures.compare import save_comparison
from toolkit.scene.tables import to_toml

NARROW: dict[str, Any] = {"kind": "gaussian", "mean": 2.0, "std": 0.1}
WIDE: dict[str, Any] = {"kind": "gw-plastic", "B": 1.251}
EXACT: dict[str, Any] = {"kind": "identical", "value": 1.0}
EQ = {"contacts": 200, "replicas": 4, "seed": 3}
FILES = ["compare.json", "compare.png", "compare.txt"]

Writer = Callable[..., str]


def tables(thresholds: dict[str, Any], to: float = 4.0, **solvers: Any) -> dict[str, Any]:
    solvers = solvers or {"master": {}, "eq": EQ}
    return {"contacts": {"thresholds": thresholds}, "drive": {"to": to, "points": 41}, **solvers}


@pytest.fixture
def write(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Writer:
    """write(name, tables) puts name.toml into an empty folder, which is made the current one."""
    monkeypatch.chdir(tmp_path)

    def put(name: str, content: dict[str, Any]) -> str:
        Path(f"{name}.toml").write_text(to_toml(content))
        return f"{name}.toml"

    return put


@pytest.fixture(autouse=True)
def no_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    """Drawing takes longer than all the rest: only where it is looked at."""
    drawn = "toolkit.pictures.compare.save_comparison"
    monkeypatch.setattr(drawn, lambda _, path: path.write_bytes(b"drawn"))


def three(write: Writer) -> list[str]:
    return [
        write("wide", tables(WIDE)),
        write("exact", tables(EXACT)),
        write("narrow", tables(NARROW)),
    ]


def test_ranks_prints_and_writes(write: Writer, capsys: pytest.CaptureFixture[str]) -> None:
    scenes = three(write)
    assert main(["compare", *scenes]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[-1] == "written to compare-output"
    assert sorted(os.listdir("compare-output")) == FILES
    assert Path("compare-output/compare.txt").read_text().splitlines() == lines[:-1]
    assert [line.split()[:2] for line in lines[2:5]] == [
        ["1", "exact"],
        ["2", "narrow"],
        ["3", "wide"],
    ]
    # onset, K* and X*
    assert lines[2].split().count("infinite") == 3 and "infinite" not in lines[3] + lines[4]
    assert (
        "exact: K* is infinite: all contacts break at one value, x = 1, where F drops by 2 F_k"
        in lines
    )
    content = json.loads(Path("compare-output/compare.json").read_text())["scenes"]
    assert [one["name"] for one in content] == ["exact", "narrow", "wide"]
    assert content[0]["critical_spring"] is None and content[0]["decoherence_length"] is None
    assert content[0]["static_to_kinetic"] == pytest.approx(2.0)


def test_numbers_are_the_solvers_own_in_mean_thresholds(write: Writer) -> None:
    assert main(["compare", *three(write), "--out", "deep/er"]) == 0
    content = json.loads(Path("deep/er/compare.json").read_text())["scenes"]
    contacts = toolkit.load_scene("narrow.toml").contacts
    found, steady = master.propensity(contacts), master.steady_state(contacts)
    line = content[1]
    for name in ("critical_spring", "static_to_kinetic", "onset_power"):
        assert line[name] == getattr(found, name)
        assert line[f"{name}_error"] == getattr(found, f"{name}_error")
    assert line["mean_threshold"] == pytest.approx(2.0)
    assert line["decoherence_length"] == pytest.approx(found.decoherence_length / 2.0, rel=1e-13)
    assert line["kinetic_force"] == pytest.approx(steady.force / 2.0, rel=1e-13)
    assert line["friction_coefficient"] is None
    assert line["run_time"] > 0.0
    evidence = line["evidence"]
    assert evidence["contacts"] == 800 and 0.0 <= evidence["worst_deviation"] < 5.0
    off = evidence["static_to_kinetic"] - evidence["expected"]
    assert abs(off) < 5.0 * evidence["static_to_kinetic_error"]


def test_ensemble_alone_and_master_alone() -> None:
    alone = toolkit.load_scene(tables(NARROW, eq=EQ))
    exact = toolkit.load_scene(tables(NARROW, master={}))
    witnessed, without = compare([alone, exact])
    if witnessed.evidence is None:
        witnessed, without = without, witnessed
    assert without.evidence is None and witnessed.evidence is not None
    assert witnessed.evidence["expected"] is None and witnessed.evidence["worst_deviation"] is None
    # the largest of its own forces lies near the exact ratio
    off = witnessed.evidence["static_to_kinetic"] - witnessed.value("static_to_kinetic")
    assert abs(off) < 0.05 + 5.0 * witnessed.evidence["static_to_kinetic_error"]
    lines = table([witnessed, without])
    assert lines[2].count("±") == 5 and lines[3].count("±") == 4
    assert "None" not in "\n".join(lines)


def test_rates_and_growth_feel_the_speed_of_the_scenes_own_legs() -> None:
    """Of turns with times it is that of the first that is no hold."""
    growing = {"kind": "growing-grains", "alpha": 1.0, "B": 4.0, "age": 4.0}
    content = tables(growing, master={"tolerance": 1e-2})
    content["drive"] = {"turns": [1.0, 1.0, 1.5], "times": [4.0, 6.0, 11.0], "points": 7}
    scene = toolkit.load_scene(content)
    (verdict,) = compare([scene])
    steady = master.steady_state(scene.contacts, velocity=0.25)
    assert verdict.velocity == 0.25
    assert verdict.value("kinetic_force") * verdict.mean_threshold == pytest.approx(steady.force)
    known = master.propensity(scene.contacts, velocity=0.25)
    assert verdict.value("critical_spring") == known.critical_spring
    assert verdict.value("static_to_kinetic") == known.static_to_kinetic
    told = "v = 0.25 (the first leg's), thresholds that grow from the age 4 on; all else"
    assert f"scene: F_k, K*, F_s/F_k and X* at {told} is P_c alone" in table([verdict])


MIXED: dict[str, Any] = {"kind": "mixture", "components": [EXACT, NARROW], "weights": [0.25, 0.75]}


@pytest.mark.parametrize("start", [0.0, -0.5])
def test_why_a_spring_is_infinite(start: float) -> None:
    content = tables(MIXED, master={})
    content["contacts"]["start"] = {"kind": "identical", "value": start}
    scene = toolkit.load_scene(content)
    (verdict,) = compare([scene])
    kinetic = (0.25 + 0.75 * 4.01) / 3.5  # <x_s²>/(2<x_s>)
    assert verdict.cautions == (
        f"K* is infinite: 25 % of the contacts break at one value, x = 1, where F drops by {0.25 / kinetic:.2g} F_k",
    )
    # the force itself: just before the break and just after it
    at = 1.0 - start
    path = [0.0, at * (1.0 - 1e-9), at * (1.0 + 1e-9)]
    _, before, after = master.solve(scene.contacts, path).force
    assert before - after == pytest.approx(0.25, abs=1e-6)


def test_a_comparison_of_surfaces_is_drawn(tmp_path: Path) -> None:
    surface = {"kind": "self-affine", "shape": [32, 32], "pixel_size": 1e-8, "hurst": 0.8}
    material = {"contact_modulus": 1.75e9, "shear_modulus": 1.1e9, "local_friction": 0.4}
    law = {"kind": "from-topography", "model": "gw", "law": "amontons", "material": material}
    law["surface"] = surface | {"rms_slope": 0.1, "seed": 1}
    scenes = [
        toolkit.load_scene(tables(law | {"pressure": pressure}, to=5e-8, master={}))
        for pressure in (1e6, 2e6)
    ]
    verdicts = compare(scenes)
    assert all(0.0 < one.value("friction_coefficient") < 0.4 and one.unit == "m" for one in verdicts)
    save_comparison(verdicts, tmp_path / "compare.png")
    assert (tmp_path / "compare.png").read_bytes().startswith(b"\x89PNG")
