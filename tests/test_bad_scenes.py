"""Every key of shipped scenes with a value it cannot have: one line that names it, or a scene that is legitimate."""

import copy
import math
import tomllib
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import toolkit
from origins.errors import InputError
from toolkit.command import main
from toolkit.scene.scene import SHIPPED

WRONG = ("yes", True, 0, -5.0, math.nan, math.inf, 1e300, 1e-300, 10**30, [], {}, [math.nan])
ONE_OF_EACH = ("ageing", "growing-grains", "kinetic-force", "reforming", "stick-slip", "two-peaks", "rough-gw-mixed")
HELD = {"turns": [2.0, 2.0, 4.0], "times": [2.0, 102.0, 104.0], "hold_scale": 0.1, "points": 31, "velocity": 1.0}
THERMAL = {"law": "soft", "temperature": 1e-23, "attempt_frequency": 1e12}


def places(table: dict[str, Any] | list[Any]) -> Iterator[list[Any]]:
    """The way to every key, of tables in lists too, and to the first item of every list."""
    for key, value in table.items() if isinstance(table, dict) else list(enumerate(table))[:1]:
        yield [key]
        if isinstance(value, dict | list):
            yield from ([key, *rest] for rest in places(value))


def of_scene(name: str) -> dict[str, Any]:
    """A shipped scene's tables; smaller where a surface is made, and with all keys of a drive and a law of rates."""
    tables = tomllib.loads((SHIPPED / f"{name}.toml").read_text())
    if name.startswith("rough"):
        tables["contacts"]["thresholds"]["surface"]["shape"] = [16, 16]
        tables["contacts"]["thermal"] = THERMAL
    if name == "reforming":
        tables["drive"] = HELD
        tables["contacts"]["delay"] = {"time": 0.1}
    return tables


@pytest.mark.parametrize("name", ONE_OF_EACH)
def test_what_cannot_be_is_one_line_that_names_its_key(name: str) -> None:
    tables = of_scene(name)
    toolkit.load_scene(tables)
    for way in places(tables):
        for value in WRONG:
            wrong = copy.deepcopy(tables)
            at = wrong
            for key in way[:-1]:
                at = at[key]
            at[way[-1]] = value
            said = ""
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                try:
                    toolkit.load_scene(wrong)
                except InputError as error:
                    said = str(error)
            told = f"{name} {way} = {value}: {said}"
            assert "\n" not in said and len(said) < 400, told
            if isinstance(value, float) and math.isnan(value):  # nothing takes it, and its own key is named
                assert str(way[0] if isinstance(way[-1], int) else way[-1]) in said, told


def test_the_command_ends_with_one_line_and_status_2(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene = tmp_path / "scene.toml"
    text = (SHIPPED / "kinetic-force.toml").read_text()
    scene.write_text(text + 'critical_spring = "yes"\n')
    assert main(["run", str(scene), "--out", str(tmp_path / "out")]) == 2
    said = capsys.readouterr()
    assert said.out == "" and said.err == "mesofriction: sweep.critical_spring: expected bool, got str\n"


def test_a_rough_surface_needs_its_attempt_frequency() -> None:
    tables = of_scene("rough-gw-mixed")
    del tables["contacts"]["thermal"]["attempt_frequency"]
    with pytest.raises(InputError, match=r"^contacts\.thermal\.attempt_frequency: is missing; .* in 1/s, such as 1e12"):
        toolkit.load_scene(tables)
