"""What scenes are told: numbers in another unit, drives that end too early, solvers that do not do the same."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from conftest import HANGS, clean_environment
from scenes import ROUGH

import toolkit
from origins.errors import InputError
from toolkit.command import main
from toolkit.scene.interfaces import foreseen
from toolkit.scene.tables import to_toml

GAUSSIAN = {"thresholds": {"kind": "gaussian", "mean": 1.0, "std": 0.1}}
NEAR = {"to": 5e-8, "points": 6}


def rough(drive: dict[str, Any], **more: Any) -> Any:
    warm = {"thermal": more.pop("thermal")} if "thermal" in more else {}
    return toolkit.load_scene(
        {"contacts": {"thresholds": ROUGH} | warm, "drive": NEAR | drive, "master": {}, **more}
    )


def test_joules_in_place_of_a_length_squared_are_asked_back() -> None:
    thermal = {"law": "soft", "attempt_frequency": 1e12}
    with pytest.raises(InputError, match=r"temperature = 4\.14e-21: .*\{ kelvin = 299\.9 \}"):
        rough({}, thermal=thermal | {"temperature": 4.14e-21})
    kelvins = rough(
        {}, thermal=thermal | {"temperature": {"kelvin": 300.0}}
    ).contacts.thermal.temperature
    assert (
        rough({}, thermal=thermal | {"temperature": kelvins}).contacts.thermal.temperature
        == kelvins
    )


def test_counts_may_be_written_as_floats_that_are_whole() -> None:
    scene = toolkit.load_scene(
        {"contacts": GAUSSIAN, "drive": {"to": 1.0, "points": 1e1}, "eq": {"contacts": 2e3}}
    )
    assert scene.eq is not None and scene.eq.contacts == 2000 and scene.path.size == 10
    with pytest.raises(InputError, match=r"^eq\.contacts: expected int, got float"):
        toolkit.load_scene(
            {"contacts": GAUSSIAN, "drive": {"to": 1.0, "points": 10}, "eq": {"contacts": 2.5}}
        )


@pytest.mark.parametrize("more", [{}, {"area": 1e-4}])
def test_a_spring_in_another_unit_is_refused_by_its_own_key(more: dict[str, float]) -> None:
    with pytest.raises(InputError, match=r"^drive\.spring = '50 N': must be a number and a unit"):
        rough({"spring": "50 N"} | more)


def test_other_numbers_of_contacts_than_the_area_has_are_told() -> None:
    pulled = {"spring": "50 N/m", "area": 1e-4}
    (note,) = foreseen(rough(pulled, eq={"contacts": 500}))
    assert note.startswith("drive.area holds ") and "[eq] follows 500 in each replica" in note
    surface = rough(pulled).contacts.interface
    assert foreseen(rough(pulled, eq={"contacts": round(surface.contact_density * 1e-4)})) == []


def test_a_path_that_ends_before_the_first_slip_says_how_far_to_go() -> None:
    scene = {"contacts": GAUSSIAN, "drive": {"to": 1.0, "points": 11, "spring": 0.5}, "master": {}}
    result: Any = toolkit.run(scene)
    (note,) = result.notes
    assert (
        note.startswith("a first slip is to be expected before X_T = ")
        and not result.master.slips.drive.size
    )
    far = float(note.partition("= ")[2].partition(";")[0])
    result = toolkit.run(scene | {"drive": scene["drive"] | {"to": far}})
    assert result.master.slips.drive.size and result.notes == ()


def test_what_is_told_before_a_run_is_not_told_again(tmp_path: Path, capsys: Any) -> None:
    hot = GAUSSIAN | {"thermal": {"law": "soft", "temperature": 500.0}}
    scene = {"contacts": hot, "drive": {"to": 1.0, "points": 3}, "master": {"tolerance": 1e-2}}
    (tmp_path / "hot.toml").write_text(to_toml(scene))
    main(["run", str(tmp_path / "hot.toml"), "--out", str(tmp_path / "out")])
    said = capsys.readouterr()
    assert (said.out + said.err).count("the temperature is") == 1
    assert len(toolkit.load(tmp_path / "out").notes) == 1


def test_the_module_is_the_command() -> None:
    words = [sys.executable, "-m", "toolkit.command", "scenes"]
    done = subprocess.run(
        words, env=clean_environment(), capture_output=True, text=True, timeout=HANGS
    )
    assert done.returncode == 0 and "gaussian" in done.stdout
