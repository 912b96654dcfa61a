"""The ladders of precision: true errors, claims, references; the command's files and refusals."""

import json
import math
import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest

import origins
from toolkit.command import main
from toolkit.judge.precision import Ladders, Point, Precision, closed_form, precision
from toolkit.scene.scene import load_scene
from toolkit.scene.tables import to_toml

SCENE: dict[str, Any] = {
    "title": "Gaussian, short",
    "contacts": {
        "thresholds": {"kind": "gaussian", "mean": 2.0, "std": 0.1},
        "start": {"kind": "gaussian", "mean": 0.1, "std": 0.05},
    },
    "drive": {"to": 6.0, "points": 61},
    "master": {"tolerance": 1e-3},
    "eq": {"contacts": 7, "replicas": 2, "seed": 4},
}
SHORT = Ladders(
    tolerances=(1e-2, 1e-6, 1e-10),
    steps=(25, 50, 100, 200),
    sizes=(100, 1000, 10_000),
    closest_sizes=(100, 1000),
    longest=math.inf,
)


def of(measured: Precision, method: str) -> list[Point]:
    return [point for point in measured.points if point.method == method]


@pytest.fixture(scope="module")
def measured() -> Precision:
    return precision(load_scene(SCENE), SHORT)


def test_every_rung_is_measured(measured: Precision) -> None:
    rungs = [(point.method, point.setting) for point in measured.points]
    assert rungs == [
        *(("master", tolerance) for tolerance in SHORT.tolerances),
        *(("explicit", steps) for steps in SHORT.steps),
        *(("ensemble", size) for size in SHORT.sizes),
        *(("closest", size) for size in SHORT.closest_sizes),
    ]
    assert all(point.run_time > 0.0 and point.runs >= 1 for point in measured.points)


def test_master_errs_less_than_it_claims(measured: Precision) -> None:
    points = of(measured, "master")
    for point in points:
        assert point.claimed_error is not None
        assert point.error <= point.claimed_error + measured.reference_error
        assert point.claimed_error <= point.setting
    assert points[-1].error < 1e-2 * points[0].error


def test_ensemble_errs_by_some_standard_errors(measured: Precision) -> None:
    # the worst of many positions: 1 to 4.4 largest standard errors in each of 400 trials
    points = of(measured, "ensemble")
    for point in points:
        assert point.claimed_error is not None
        assert 0.5 < point.error / point.claimed_error < 5.0
    assert points[0].claimed_error == pytest.approx(10.0 * points[-1].claimed_error, rel=0.2)
    for point in of(measured, "closest"):
        (alike,) = [other.claimed_error for other in points if other.setting == point.setting]
        assert 0.5 < point.error / alike < 5.0 and point.claimed_error is None


def test_a_ladder_ends_after_a_long_run() -> None:
    ended = precision(load_scene(SCENE), replace(SHORT, longest=0.0))
    assert [point.method for point in ended.points] == ["master", "explicit", "ensemble", "closest"]
    assert sum("no further, as a run took more than 0 s" in note for note in ended.notes) == 4


def test_closed_form_against_many_digits() -> None:
    path = np.concatenate([np.linspace(0.0, 3.0, 16), np.linspace(49.9, 50.1, 5)])
    for mean, std, first, spread in [
        (1.0, 0.05, 0.0, 0.025),
        (1.0, 1e-3, 0.1, 0.0),
        (0.7, 0.05, -0.1, 0.03),
    ]:
        start = origins.gaussian_start(first, spread)
        found = closed_form(origins.Contacts(origins.gaussian(mean, std), start), path)
        assert found is not None and found.error < 1e-10
        with mpmath.workdps(40):
            for x, force in zip(path, found.force, strict=True):
                exact = mpmath.mpf(first) + mpmath.mpf(x)
                for n in range(1, int(x / mean) + 40):
                    width = mpmath.sqrt(n * mpmath.mpf(std) ** 2 + mpmath.mpf(spread) ** 2)
                    z = (mpmath.mpf(x) - n * mpmath.mpf(mean) + mpmath.mpf(first)) / width
                    exact -= mpmath.mpf(mean) * mpmath.ncdf(z) - mpmath.mpf(
                        std
                    ) ** 2 / width * mpmath.npdf(z)
                assert abs(float(exact - mpmath.mpf(float(force)))) <= found.error * mean


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder, made the current one, in which the command climbs no further than SHORT."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("toolkit.judge.precision.Ladders", lambda: SHORT)
    return tmp_path


def test_command_prints_and_writes(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("mine.toml").write_text(to_toml(SCENE))
    assert main(["precision", "mine.toml"]) == 0
    printed = capsys.readouterr().out.splitlines()
    assert printed[0] == "Gaussian, short" and printed[-1] == "written to mine-output"
    assert sorted(os.listdir("mine-output")) == ["precision.json", "precision.png", "precision.txt"]
    assert Path("mine-output/precision.txt").read_text().splitlines() == printed[:-1]
    assert Path("mine-output/precision.png").read_bytes().startswith(b"\x89PNG")
    written = json.loads(Path("mine-output/precision.json").read_text())
    assert (
        written["reference"] == "the closed form for Gaussian thresholds"
        and written["reference_error"] < 1e-13
    )
    assert (
        len(written["points"]) == 12
        and written["notes"] == printed[-1 - len(written["notes"]) : -1]
    )
    point = written["points"][0]
    assert (
        point["method"] == "master"
        and point["setting"] == 1e-2
        and point["claimed_error"] >= point["error"]
    )
    assert printed[3].split()[:3] == ["master", "tolerance", "1e-02"]
    assert f"{point['error']:.1e}" in printed[3] and f"{point['claimed_error']:.1e}" in printed[3]
