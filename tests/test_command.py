"""The command: what it prints, writes and returns, for good input, bad input and its own bugs."""

import json
import os
import re
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import master
import toolkit
from origins.errors import InputError
from toolkit.command import main
from toolkit.scene.scene import shipped_scenes
from toolkit.scene.tables import to_toml

SCRIPT = "import sys; from toolkit.command import main; sys.exit(main())"
MASTER_ONLY: dict[str, Any] = {
    "title": "one solver",
    "contacts": {"thresholds": {"kind": "gaussian", "mean": 1.0, "std": 0.05}},
    "drive": {"to": 2.0, "points": 21},
    "master": {},
}


@pytest.fixture
def write_scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., str]:
    """write_scene(tables) puts scene.toml into an empty folder, which is made the current one."""
    monkeypatch.chdir(tmp_path)

    def write(tables: dict[str, Any]) -> str:
        Path("mine.toml").write_text(to_toml(tables))
        return "mine.toml"

    return write


def test_run_prints_a_line_per_solver_and_writes(write_scene, capsys) -> None:
    scene = write_scene({**MASTER_ONLY, "eq": {"contacts": 200, "replicas": 3, "seed": 7}})
    assert main(["run", scene]) == 0
    title, solved, simulated, apart, where = capsys.readouterr().out.splitlines()
    written = json.loads(Path("mine-output/summary.json").read_text())
    assert title == "one solver" and where == "written to mine-output"
    assert solved.startswith(
        f"master  error {written['master']['force_error']:.1e} of <x_s>  run time"
    )
    assert simulated.startswith(
        f"eq      error {written['eq']['largest_standard_error']:.1e} of <x_s>"
    )
    assert f"{written['eq']['breaks']:,} breaks on 1 rank" in simulated
    assert apart.startswith("eq less master: at most")
    assert sorted(os.listdir("mine-output")) == ["picture.png", "result.h5", "summary.json"]
    assert toolkit.load("mine-output").text == Path(scene).read_text()


ROUGH: dict[str, Any] = {
    "kind": "from-topography",
    "model": "gw",
    "law": "amontons",
    "pressure": 1e6,
    "surface": {
        "kind": "self-affine",
        "shape": [32, 32],
        "pixel_size": 1e-8,
        "hurst": 0.8,
        "rms_slope": 0.1,
        "seed": 1,
    },
    "material": {"contact_modulus": 1.75e9, "shear_modulus": 1.1e9, "local_friction": 0.4},
}


def rough(**changes: Any) -> dict[str, Any]:
    return {
        **MASTER_ONLY,
        "contacts": {"thresholds": ROUGH | changes},
        "drive": {"to": 5e-8, "points": 21},
    }


def test_run_of_a_surface_says_and_keeps_what_to_mind(write_scene, capsys) -> None:
    scene = write_scene(rough())
    assert main(["run", scene]) == 0
    _, surface, _, *notes, _ = capsys.readouterr().out.splitlines()
    interface = toolkit.load_scene(scene).contacts.interface
    assert interface is not None
    assert surface == (
        f"surface {interface.contact_density:.3g} contacts/m², <k> = {interface.mean_stiffness:.3g} N/m, "
        f"area of contact {interface.area_fraction:.2%}; F_k/load = {interface.friction_coefficient:.3g}, "
        f"{interface.kinetic_stress:.3g} Pa under 1e+06 Pa"
    )
    told = [note.removeprefix("note    ") for note in notes]
    assert any("the scan does not resolve it" in note for note in interface.cautions)
    assert told[:-1] == list(interface.cautions)
    assert told[-1].startswith("errors are numerical only, not those of the surface")
    written = json.loads(Path("mine-output/summary.json").read_text())
    assert written["notes"] == told
    numbers = written["interface"]
    assert numbers["contact_density"]["value"] == interface.contact_density
    assert numbers["kinetic_stress"] | {"error": None} == {
        "value": interface.friction_coefficient * 1e6,
        "error": None,
        "unit": "Pa",
    }
    assert numbers["mean_load"]["unit"] == "N" and "mean_threshold" not in numbers
    back = toolkit.load("mine-output")
    assert (
        back.notes == tuple(told)
        and json.loads(json.dumps(toolkit.results.files.summary(back))) == written
    )


def test_a_spring_of_a_surface_says_its_unit(write_scene, capsys) -> None:
    """A bare number may be meant in N/m, or in N_c<k>."""

    def pulled(spring: object, **more: float) -> toolkit.scene.scene.Scene:
        return toolkit.load_scene(
            rough() | {"drive": {"to": 1e-9, "points": 5, "spring": spring, **more}}
        )

    interface = toolkit.load_scene(rough()).contacts.interface
    assert interface is not None
    each = interface.contact_density * interface.mean_stiffness
    assert (
        main(["run", write_scene(rough() | {"drive": {"to": 1e-9, "points": 5, "spring": 50.0}})])
        == 2
    )
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(
        "mesofriction: drive.spring = 50.0: has no unit; of a surface write either "
    )
    assert 'spring = "50 N/m" with area' in line
    assert f'N_c<k> = {each:.3g} N/m, or spring = "50 N_c<k>"' in line
    assert pulled("0.5 N_c<k>").drive.spring == 0.5
    assert pulled("50 N/m", area=1e-4).drive.spring == pytest.approx(50.0 / (each * 1e-4))
    bad: list[tuple[object, dict[str, float], str]] = [
        ("50 N/m", {}, "needs drive.area"),
        ("50 N/m", {"area": 1e-16}, "needs drive.area"),
        ("50 kN", {}, "must be a number and a unit"),
        ("stiff", {}, "must be a number and a unit"),
        ("-1 N_c<k>", {}, "must be above zero"),
        ("0.5 N_c<k>", {"area": 1.0}, "drive.area = 1.0: is for a spring in N/m"),
    ]
    for spring, more, rule in bad:
        with pytest.raises(InputError, match=re.escape(rule)):
            pulled(spring, **more)
    own = {"contacts": {"thresholds": {"kind": "gaussian", "mean": 1.0, "std": 0.1}}, "master": {}}
    with pytest.raises(InputError, match="needs <k> in N/m"):
        toolkit.load_scene(
            own | {"drive": {"to": 1.0, "points": 3, "spring": "5 N/m", "area": 1.0}}
        )


@pytest.mark.parametrize("dry", [[], ["--dry-run"]])
def test_what_makes_a_run_hopeless_is_told_before_it(
    dry: list[str], write_scene, capsys, monkeypatch
) -> None:
    def begin(*arguments: Any, **named: Any) -> None:
        raise InputError("begun")

    for place in ("running.runner.solve", "running.forecast.forecast_lines"):
        monkeypatch.setattr(f"toolkit.{place}", begin)
    hot = {"law": "soft", "temperature": 500.0}
    far = {"kind": "identical", "value": 2.0}
    contacts = MASTER_ONLY["contacts"] | {"thermal": hot, "start": far}
    assert main(["run", write_scene(MASTER_ONLY | {"contacts": contacts}), *dry]) == 2
    told = capsys.readouterr().err.splitlines()
    for line, begins in zip(told, ("the temperature is", "contacts start", "begun"), strict=True):
        assert line.startswith(f"mesofriction: {begins}")


def test_a_refusal_of_the_master_equation_says_what_runs_without_it(
    write_scene, capsys, monkeypatch
) -> None:
    def refuse(*arguments: Any, **named: Any) -> None:
        raise InputError("path: no")

    monkeypatch.setattr(master, "solve", refuse)
    paper = {"thermal": {"law": "soft", "temperature": 0.1, "closure": "paper"}}
    for tables, more in (
        ({}, ""),
        ({"eq": {"contacts": 10}}, "; without [master] the scene's [eq] runs alone"),
        (
            {"eq": {"contacts": 10}, "contacts": MASTER_ONLY["contacts"] | paper},
            "",
        ),  # as [eq] alone would not
    ):
        assert main(["run", write_scene(MASTER_ONLY | tables)]) == 2
        assert capsys.readouterr().err == f"mesofriction: master: path: no{more}\n"


@pytest.mark.parametrize("command", ["run", "thresholds", "compare"])
def test_bad_input_is_one_line_and_leaves_nothing(command: str, write_scene, capsys) -> None:
    for tables, more, message in (
        ({**MASTER_ONLY, "colour": 1}, [], "colour: unknown key; known here: contacts,"),
        (MASTER_ONLY, ["--out", "mine.toml/below"], "out = 'mine.toml/below': "),
    ):
        assert main([command, write_scene(tables), *more]) == 2
        told = capsys.readouterr()
        (line,) = told.err.splitlines()
        assert line.startswith("mesofriction: ") and message in line
        assert told.out == "" and os.listdir(".") == ["mine.toml"]


def test_bug_shows_its_traceback(python, tmp_path: Path) -> None:
    planted = f"import master; master.solve = lambda *a, **k: 1 / 0; {SCRIPT}"
    done = python(planted, "run", "gaussian")
    assert done.returncode == 1
    assert "Traceback (most recent call last)" in done.stderr and "ZeroDivisionError" in done.stderr
    assert os.listdir(tmp_path) == []


def test_thresholds_prints_moments_and_draws(write_scene, capsys) -> None:
    tables = {
        **MASTER_ONLY,
        "contacts": {"thresholds": {"kind": "rectangular", "lower": 0.5, "upper": 1.5}},
    }
    assert main(["thresholds", write_scene(tables)]) == 0
    out = capsys.readouterr().out
    written = json.loads(Path("mine-output/thresholds.json").read_text())["numbers"]
    for name, exact in (
        ("mean", 1.0),
        ("second_moment", 13.0 / 12.0),
        ("third_moment", 1.25),
        ("kinetic_force", 13.0 / 24.0),
        ("median", 1.0),
        ("onset_power", 0.0),
    ):
        assert abs(written[name]["value"] - exact) <= written[name]["error"], name
    assert (
        f"{13 / 12:.8g}" in out
        and "onset power" in out
        and "static to kinetic" in out
        and "run time" in out
    )
    assert sorted(os.listdir("mine-output")) == ["thresholds.json", "thresholds.png"]


@pytest.mark.parametrize("words", [[], ["fly"], ["run"], ["run", "gaussian", "--speed", "3"]])
def test_wrong_words_are_status_2(words: list[str], capsys) -> None:
    with pytest.raises(SystemExit) as end:
        main(words)
    assert end.value.code == 2 and "usage: mesofriction" in capsys.readouterr().err


def test_thresholds_need_no_solver(write_scene, capsys) -> None:
    scene = write_scene({key: value for key, value in MASTER_ONLY.items() if key != "master"})
    assert main(["run", scene]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("mesofriction: scene: has neither [master] nor [eq]") and os.listdir(
        "."
    ) == ["mine.toml"]
    assert main(["thresholds", scene]) == 0
    assert "onset power" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("number", "status", "word"),
    [(signal.SIGINT, 130, "interrupted"), (signal.SIGTERM, 143, "terminated")],
)
def test_a_signal_while_it_imports_is_one_line(
    number: int,
    status: int,
    word: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    before = signal.getsignal(number)

    def interrupt(*_: object) -> None:
        try:
            signal.raise_signal(number)
        except BaseException as error:
            # some compiled modules put their own in the place of what comes while they are imported
            raise (
                error if number == signal.SIGINT else ImportError("initialization failed")
            ) from error

    monkeypatch.setattr("importlib.import_module", interrupt)
    assert main(["scenes"]) == status and signal.getsignal(number) is before
    assert capsys.readouterr() == ("", f"mesofriction: {word}; nothing was written\n")


def test_scenes_lists_every_shipped_scene(capsys) -> None:
    assert main(["scenes"]) == 0
    told = capsys.readouterr().out
    assert (
        all(f"\n{name} " in f"\n{told}" for name in shipped_scenes())
        and max(map(len, told.splitlines())) <= 100
    )
