"""`show`, `copy` and `--set`: scenes written out with their defaults, copied, and run with other values."""

import json
import tomllib
from pathlib import Path
from typing import Any

import pytest
from scenes import GAUSSIAN, ROUGH, refused, said, write

import toolkit
from toolkit.scene import tables
from toolkit.scene.changes import changed
from toolkit.scene.scene import SHIPPED, shipped_scenes
from toolkit.scene.writing import with_defaults

CHEAP = ("gaussian", "stick-slip", "slide-hold-slide", "kinetic-force", "gw-gaussian-mixed")

pytestmark = pytest.mark.usefixtures("in_a_folder", "unrendered")


@pytest.mark.parametrize("name", shipped_scenes())
def test_a_shown_scene_has_every_default_and_says_the_same(name: str, capsys: Any) -> None:
    """Written out twice it is the same; its tables are those of the scene; it loads to the same contacts."""
    status, out, _ = said(capsys, "show", name)
    shown = tomllib.loads("\n".join(out))
    given = tomllib.loads((SHIPPED / f"{name}.toml").read_text(encoding="utf-8"))
    assert status == 0 and with_defaults(shown) == with_defaults(given)
    one, other = tables.read_table(shown), tables.read_table(given)
    for own in ("title", "drive", "master", "eq", "sweep", "verdict", "wall_time"):
        assert getattr(one, own) == getattr(other, own), own
    if name in CHEAP:
        loaded, before = toolkit.load_scene(shown), toolkit.load_scene(given)
        assert loaded.tolerance_given == before.tolerance_given
        for law in (loaded.contacts, before.contacts):
            assert law.thresholds.ppf(0.3) == before.contacts.thresholds.ppf(0.3)


def test_a_shown_scene_names_what_it_leaves_out_and_finds_its_files(capsys: Any) -> None:
    Path("far").mkdir()
    Path("far/own.txt").write_text("1.0\n1.1\n0.9\n")
    file = write("far/mine", thresholds={"kind": "from-samples", "file": "own.txt"}, master={})
    _, out, _ = said(capsys, "show", file)
    assert 'file = "far/own.txt"' in out and 'quantity = "x_s"' in out
    (first, *_) = (line for line in out if line.startswith("# left out: ") and "x_s" in line)
    assert "column" in first and "# left out: tolerance" in out
    whole = str(Path("far/own.txt").resolve())  # the place of a file that is named in full stays so
    _, shown, _ = said(capsys, "show", file, "--set", f'contacts.thresholds.file="{whole}"')
    assert f'file = "{whole}"' in shown
    Path("here.toml").write_text("\n".join(out))
    assert toolkit.load_scene("here.toml").contacts.mean_threshold == pytest.approx(1.0, abs=0.01)


def test_copies_never_overwrite(capsys: Any) -> None:
    status, (line,), _ = said(capsys, "copy", "gaussian")
    assert status == 0 and line.startswith("written to gaussian.toml")
    assert Path("gaussian.toml").read_text() == (SHIPPED / "gaussian.toml").read_text()
    Path("gaussian.toml").write_text("mine")
    assert "is there already, and is kept" in refused(capsys, "copy", "gaussian")
    assert Path("gaussian.toml").read_text() == "mine"
    Path("sub").mkdir()
    # a figure of the paper names its scene, as in `run A08c`
    assert said(capsys, "copy", "A08c")[0] == 0 and Path("kinetic-force.toml").exists()
    assert said(capsys, "copy", "gaussian", "sub")[0] == 0 and Path("sub/gaussian.toml").exists()
    assert said(capsys, "copy", "gaussian", "new/")[0] == 0 and Path("new/gaussian.toml").exists()
    assert "did you mean gaussian? `mesofriction scenes`" in refused(capsys, "copy", "gausian")
    assert "cannot be written" in refused(capsys, "copy", "gaussian", "gaussian.toml/x")


def test_set_is_another_scene(capsys: Any) -> None:
    """Its run is that of a scene that has the value, and the result keeps the scene as it was run."""
    write("mine")
    words = ("--set", "contacts.thresholds.std=0.1", "--set", "drive.spring=0.4")
    assert said(capsys, "run", "mine.toml", *words)[0] == 0
    own = {"to": 2.0, "points": 21, "spring": 0.4}
    known = toolkit.run(
        toolkit.load_scene(write("other", thresholds=GAUSSIAN | {"std": 0.1}, drive=own))
    )
    found = toolkit.load("mine-output")
    assert (found.master.force == known.master.force).all()
    assert tomllib.loads(found.text)["drive"]["spring"] == 0.4


def test_set_of_each_command(capsys: Any) -> None:
    file, std = write(), ("--set", "contacts.thresholds.std=0.2")
    assert said(capsys, "thresholds", file, *std)[0] == 0
    numbers = json.loads(Path("mine-output/thresholds.json").read_text())["numbers"]
    assert numbers["standard_deviation"]["value"] == pytest.approx(0.2, rel=1e-4)
    assert said(capsys, "compare", file, write("other"), *std)[0] == 0
    found = json.loads(Path("compare-output/compare.json").read_text())["scenes"]
    assert found[0]["critical_spring"] == found[1]["critical_spring"] < 2.0
    spring = ("--set", "drive.spring=5.0", "--set", 'verdict.rules=["reset"]')
    status, out, _ = said(capsys, "verdict", file, *std, *spring)
    assert status == 0 and "smooth at" in "\n".join(out)
    never = ("--set", "master.tolerance=2.0")
    assert "master.tolerance = 2.0" in refused(capsys, "precision", file, *never)
    _, out, _ = said(capsys, "show", write("rough", thresholds=ROUGH), "--set", "drive.area=1e-6")
    # the slip rule of a scene that names none
    assert any('mass, slip ("reset" on a spring without a mass)' in line for line in out)
    assert "area = 1e-06" in out


@pytest.mark.parametrize(
    ("word", "told"),
    [
        ("drive.sprin=0.5", "drive.sprin: unknown key; did you mean spring?"),
        (
            "contacts.thresholds.men=1.0",
            "contacts.thresholds.men = 1.0: unknown key; did you mean mean?",
        ),
        ('contacts.thresholds.kind="gausian"', "did you mean gaussian?"),
        ("drive.spring=50 N/m", "the value is not TOML; text needs quotes"),
        ("drive.spring=0,5", "write a decimal point: --set drive.spring=0.5"),
        ("drive.spring=-1.0", "drive.spring = -1.0"),
        ("drive.spring", "must be KEY=VALUE"),
        ("drive.spring=1\ntitle=2", "must be one value"),
        ("drive.to.x=3", "x is a key of a table"),
        ("drive.turns[1]=3", "[1] counts from 0"),
        ("drive..to=3", "must be names between dots"),
        ("", "must be KEY=VALUE"),
    ],
)
def test_a_bad_change_is_one_line(word: str, told: str, capsys: Any) -> None:
    assert told in refused(capsys, "run", write(), "--set", word)
    assert not Path("mine-output").exists()


def test_changes_reach_into_lists_and_leave_the_scene_alone() -> None:
    parts = [{"kind": "identical", "value": 1.0}, {"kind": "identical", "value": 2.0}]
    given = {"contacts": {"thresholds": {"kind": "mixture", "components": parts}}}
    out = changed(given, {"contacts.thresholds.components[1].value": 3.0, "eq.contacts": 5})
    assert out["contacts"]["thresholds"]["components"][1]["value"] == 3.0
    assert out["eq"] == {"contacts": 5} and parts[1]["value"] == 2.0 and "eq" not in given


def test_one_name_offers_all_rooms_and_laws_say_what_they_are() -> None:
    import mesofriction

    assert [getattr(mesofriction, room).__name__ for room in dir(mesofriction)[1:]] == dir(
        mesofriction
    )[1:]
    assert mesofriction.toolkit is toolkit and mesofriction.__version__ == toolkit.__version__
    assert {"load", "plot", "run"} <= set(dir(toolkit))
    with pytest.raises(AttributeError, match="no attribute 'room'"):
        _ = mesofriction.room
    contacts = toolkit.load_scene("stick-slip").contacts
    assert repr(contacts).startswith("Contacts(thresholds=UpperGaussian(mean=1, std=")
    assert "start=GaussianStart(mean=0, std=0.025)" in repr(contacts)
