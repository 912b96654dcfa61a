"""Running a scene: the solvers' own numbers, kept whole in a folder and read back."""

import json
import os
import tomllib
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

import eq_model
import master
import toolkit
from origins.errors import InputError
from toolkit.command import main
from toolkit.results.beside import slips_beside
from toolkit.results.files import summary
from toolkit.results.folders import write_folder
from toolkit.results.records import OWN_UNIT
from toolkit.running.runner import solve_master
from toolkit.scene.scene import SHIPPED, shipped_scenes
from toolkit.scene.tables import to_toml


def small(name: str, contacts: int = 400, replicas: int = 4) -> dict[str, Any]:
    """A shipped scene with an ensemble small enough for a test."""
    tables = tomllib.loads((SHIPPED / f"{name}.toml").read_text())
    tables["eq"] |= {"contacts": contacts, "replicas": replicas}
    return tables


@pytest.fixture(scope="module")
def result() -> toolkit.results.records.Result:  # type: ignore[name-defined]
    return toolkit.run(small("gaussian"))


def test_numbers_are_the_solvers_own(result: Any) -> None:
    scene = toolkit.load_scene("gaussian")
    solved = master.solve(scene.contacts, scene.path, tolerance=1e-8)
    simulated = eq_model.simulate(scene.contacts, scene.path, n_contacts=400, n_replicas=4, seed=1)
    assert np.array_equal(result.master.force, solved.force)
    assert np.array_equal(result.eq.force, simulated.force)
    assert np.array_equal(result.eq.force_standard_error, simulated.force_standard_error)
    assert result.eq.breaks == simulated.breaks
    assert result.mean_threshold == pytest.approx(1.0)


TEXTS = {name: (SHIPPED / f"{name}.toml").read_text() for name in shipped_scenes()}
SIMULATED = [name for name, text in TEXTS.items() if "eq" in tomllib.loads(text)]


@pytest.mark.parametrize("name", [name for name in shipped_scenes() if name not in SIMULATED])
def test_shipped_scene_of_the_master_equation_alone_runs(name: str) -> None:
    done = toolkit.run(name)
    found = done.master or done.sweep
    assert found is not None and done.eq is None
    assert done.success and np.ptp(found.force) > 0.1 * done.mean_threshold


@pytest.mark.parametrize("name", SIMULATED)
def test_shipped_scene_runs_and_its_solvers_agree(name: str) -> None:
    scene = small(name)
    done = toolkit.run(scene)
    assert done.success, done.master
    assert done.master is not None and done.eq is not None
    assert done.master.force_error <= scene["master"].get("tolerance", 1e-8)
    if "spring" in scene["drive"]:
        for slip in slips_beside(done):
            # each is late by what the one before it was, and some N^(-2/3) more
            late = 2.0 * (slip.number + 1) * scene["eq"]["contacts"] ** (-2.0 / 3.0)
            most = 5.0 * slip.drive_error + late
            assert -5.0 * slip.drive_error < slip.mean_drive - slip.drive < most
        assert len(slips_beside(done)) == done.master.slips.drive.size > 0
        return
    deviation = np.abs(done.eq.force - done.master.force)
    allowed = 5.0 * done.eq.force_standard_error + done.master.force_error * done.mean_threshold
    assert (deviation <= allowed).all()
    assert done.eq.breaks > 1600 and np.ptp(done.master.force) > 0.1 * done.mean_threshold


def test_the_master_equation_tells_its_error() -> None:
    errors: list[float] = []
    scene = toolkit.load_scene("friction-loop")
    solved = solve_master(scene, 1e-8, errors.append)
    assert errors and errors[-1] == solved.force_error


def test_only_named_solvers_run() -> None:
    tables = small("gaussian")
    lone = toolkit.run({key: value for key, value in tables.items() if key != "eq"})
    assert lone.eq is None and lone.master is not None and "eq" not in summary(lone)
    lone = toolkit.run({key: value for key, value in tables.items() if key != "master"})
    assert lone.master is None and lone.eq is not None and lone.success
    assert "master" not in summary(lone)


def test_what_is_saved_is_what_is_loaded(result: Any, tmp_path: Path) -> None:
    toolkit.save(result, tmp_path / "out")
    assert sorted(os.listdir(tmp_path / "out")) == ["picture.png", "result.h5", "summary.json"]
    back = toolkit.load(tmp_path / "out")
    for name in ("name", "title", "text"):
        assert getattr(back, name) == getattr(result, name)
    assert back.version == toolkit.__version__
    for name in ("path", "force", "holding"):
        assert np.array_equal(getattr(back.master, name), getattr(result.master, name))
        assert np.array_equal(getattr(back.eq, name), getattr(result.eq, name))
    assert np.array_equal(back.eq.force_standard_error, result.eq.force_standard_error)
    assert np.array_equal(back.thresholds.density, result.thresholds.density)
    assert back.master.force_error == result.master.force_error and back.master.success is True
    assert back.eq.breaks == result.eq.breaks and sum(back.eq.breaks_per_rank) == result.eq.breaks
    written = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary(back) == summary(result) == written
    again = toolkit.run(toolkit.load_scene(tomllib.loads(back.text)))
    assert np.array_equal(again.eq.force, result.eq.force)


def test_arrays_have_units_and_the_scene_goes_with_them(result: Any, tmp_path: Path) -> None:
    toolkit.save(result, tmp_path)
    with h5py.File(tmp_path / "result.h5") as store:
        assert tomllib.loads(store.attrs["scene"])["eq"]["contacts"] == 400
        assert store.attrs["seed"] == 1 and store.attrs["version"] == toolkit.__version__
        assert store["master/force"].attrs["units"] == OWN_UNIT
        assert store["thresholds/density"].attrs["units"] == f"1 / {OWN_UNIT}"
        assert store["eq/holding"].attrs["units"] == "1"
        assert np.array_equal(store["time"], result.time) and np.array_equal(
            result.time, result.eq.path
        )
        arrays: list[Any] = []
        store.visititems(
            lambda _, item: arrays.append(item) if isinstance(item, h5py.Dataset) else None
        )
        assert len(arrays) == 16 and all("units" in array.attrs for array in arrays)


def test_nothing_of_another_scene_stays_beside_a_new_result(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of what is not known to be of an earlier command nothing is removed."""
    monkeypatch.setattr(
        "toolkit.pictures.run.save_picture", lambda _, path: path.write_bytes(b"drawn")
    )
    thermal = {"law": "soft", "temperature": 0.1}
    swept, plain = tmp_path / "swept.toml", tmp_path / "plain.toml"
    thresholds = {"kind": "gaussian", "mean": 1.0, "std": 0.2}
    contacts = {"thresholds": thresholds, "thermal": thermal}
    swept.write_text(to_toml({"contacts": contacts, "sweep": {"velocity": [0.5, 1.0]}}))
    drive, contacts = {"to": 1.0, "points": 3}, {"thresholds": thresholds}
    plain.write_text(to_toml({"contacts": contacts, "drive": drive, "master": {}}))
    out = tmp_path / "out"
    ours = ["picture.png", "result.h5", "summary.json"]
    told = ["thresholds.json", "thresholds.png"]
    toolkit.run(swept, folder=out)
    assert main(["thresholds", str(swept), "--out", str(out)]) == 0
    (out / "checkpoint").mkdir()
    (out / "checkpoint" / "kept").touch()
    (out / "notes.txt").write_text("mine")
    toolkit.run(swept, folder=out)
    assert sorted(os.listdir(out)) == sorted([*ours, *told, "checkpoint", "notes.txt", "sweep.csv"])
    toolkit.run(plain, folder=out)
    assert sorted(os.listdir(out)) == sorted([*ours, "checkpoint", "notes.txt"])
    assert main(["thresholds", str(swept), "--out", str(out)]) == 2
    for name in (*told, "sweep.csv"):
        (out / name).write_text("mine")
    toolkit.run(plain, folder=out)
    assert sorted(os.listdir(out)) == sorted([*ours, *told, "checkpoint", "notes.txt", "sweep.csv"])


def test_no_result_to_load_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"^folder = .*holds no result\.h5"):
        toolkit.load(tmp_path)
    (tmp_path / "result.h5").write_text("not HDF5")
    with pytest.raises(InputError, match=f": is a file; give the folder, '{tmp_path}'$"):
        toolkit.load(tmp_path / "result.h5")
    with pytest.raises(InputError, match=r"^folder = .*its result\.h5 is not one of mesofriction"):
        toolkit.load(tmp_path)


def test_failing_half_way_leaves_the_folder_as_it_was(tmp_path: Path) -> None:
    def broken(path: Path) -> None:
        path.write_text("half")
        raise ZeroDivisionError

    (tmp_path / "a").write_text("old")
    writers = {"a": lambda path: path.write_text("new") and None, "b": broken}
    for folder in (tmp_path, tmp_path / "deep/er/out"):
        with pytest.raises(ZeroDivisionError):
            write_folder(folder, writers)
    assert os.listdir(tmp_path) == ["a"] and (tmp_path / "a").read_text() == "old"
