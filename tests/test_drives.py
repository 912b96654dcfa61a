"""Scenes of sliders that turn round or are pulled by a spring."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import master
import toolkit
from origins import InputError
from toolkit.results.records import SoftRecord


def scene(drive: dict[str, Any], **tables: Any) -> dict[str, Any]:
    thresholds = {"kind": "gaussian", "mean": 1.0, "std": 0.1}
    return {"contacts": {"thresholds": thresholds}, "drive": drive, "master": {"tolerance": 1e-7}, **tables}


@pytest.mark.parametrize(
    ("turns", "points"), [([3.0, -3.0, 3.0], 601), ([1.0, 0.999, 5.0], 4), ([-0.01, 2.0], 50), ([2.0, -1e-9, 1e-9], 6)]
)
def test_every_turning_point_is_a_point_of_the_path(turns: list[float], points: int) -> None:
    path = toolkit.load_scene(scene({"turns": turns, "points": points})).path
    assert path.size == points and path[0] == 0.0 and path[-1] == turns[-1]
    place = [int(np.flatnonzero(path == turn)[0]) for turn in turns[:-1]] + [points - 1]
    ends = [0.0, *turns]
    for first, last, begin, end in zip([0, *place[:-1]], place, ends[:-1], ends[1:], strict=True):
        np.testing.assert_allclose(path[first : last + 1], np.linspace(begin, end, last - first + 1), atol=1e-15)


def test_points_begin_where_the_scene_says() -> None:
    made = toolkit.load_scene(scene({"from": 1.0, "turns": [2.0, -1.0], "points": 5})).drive
    assert made.path.tolist() == [1.0, 2.0, 1.0, 0.0, -1.0] and made.time is None
    asked = {"from": 0.5, "turns": [2.0, 2.0], "times": [1.0, 2.0, 4.0], "points": 5}
    made = toolkit.load_scene(scene(asked)).drive
    assert made.path.tolist() == [0.5, 1.25, 2.0, 2.0, 2.0] and made.time.tolist() == [1.0, 1.5, 2.0, 3.0, 4.0]
    # a rigid slider has come from X = 0: the force there is that of the whole way
    whole, part = (toolkit.run(scene({"to": 3.0, **more})) for more in ({"points": 31}, {"from": 1.0, "points": 21}))
    assert whole.master is not None and part.master is not None
    np.testing.assert_allclose(part.master.force, whole.master.force[10:], atol=2e-7)
    np.testing.assert_allclose(part.time, whole.time[10:])


def test_a_soft_slider_begins_in_balance_where_the_scene_says() -> None:
    stretched = {
        "thresholds": {"kind": "gaussian", "mean": 1.0, "std": 0.1},
        "start": {"kind": "identical", "value": 0.2},
    }
    drive = {"from": 0.4, "to": 1.0, "points": 4, "spring": 0.5, "velocity": 0.1}
    result = toolkit.run(scene(drive) | {"contacts": stretched})
    soft = result.master
    assert isinstance(soft, SoftRecord) and soft.position[0] == pytest.approx(0.0, abs=1e-12) and soft.balance == 0.4
    # no contact breaks before X = 0.4: K (X_T - X) = 0.2 + X
    np.testing.assert_allclose(soft.force, 0.2 + (0.5 * soft.path - 0.2) / 1.5, atol=1e-6)
    np.testing.assert_allclose(result.time, [0.0, 2.0, 4.0, 6.0])


def test_points_of_a_hold_may_be_even_in_its_logarithm() -> None:
    drive = {"turns": [1.0, 1.0, 2.0], "times": [1.0, 1.0 + 1e6, 2.0 + 1e6], "points": 28, "hold_scale": 1e-2}
    made = toolkit.load_scene(scene(drive)).drive
    assert made.time is not None and made.time[[0, 9, 18, 27]].tolist() == [0.0, 1.0, 1.0 + 1e6, 2.0 + 1e6]
    held = made.time[9:19] - 1.0
    assert (made.path[9:19] == 1.0).all()
    np.testing.assert_allclose(np.diff(np.log1p(held / 1e-2)), np.log1p(1e8) / 9.0, rtol=1e-6)


def test_a_picture_shows_the_decades_of_a_hold() -> None:
    from matplotlib.figure import Figure

    from toolkit.pictures.thresholds import write_along

    drive = {"turns": [1.0, 1.0, 2.0], "times": [1.0, 1.0 + 1e6, 2.0 + 1e6], "points": 91, "hold_scale": 1e-2}
    axes = Figure().subplots()
    result = toolkit.run(scene(drive))
    write_along(axes, result)
    axes.figure.canvas.draw()
    assert [text.get_text() for text in axes.get_xticklabels()] == ["0", "1", "1000001", "1000002"]
    # points are even, and ticks apart
    at = axes.transAxes.inverted().transform(axes.transData.transform([(time, 0.0) for time in result.time]))[:, 0]
    np.testing.assert_allclose(np.diff(at), 1.0 / 90.0, rtol=1e-6)


def test_a_loop_is_solved_and_comes_back_from_its_folder(tmp_path: Path) -> None:
    asked = scene({"turns": [2.0, -2.0, 2.0], "points": 101})
    result = toolkit.run(asked)
    checked = toolkit.load_scene(asked)
    assert result.master is not None and result.success
    np.testing.assert_array_equal(result.master.force, master.solve(checked.contacts, checked.path, 1e-7).force)
    toolkit.save(result, tmp_path / "out")
    again = toolkit.load(tmp_path / "out")
    np.testing.assert_array_equal(again.master.force, result.master.force)  # type: ignore[union-attr]


def test_a_soft_slider_tells_its_slips(tmp_path: Path) -> None:
    asked = scene({"to": 6.0, "points": 61, "spring": 0.8, "slip": "reform-after"})
    result = toolkit.run(asked)
    soft = result.master
    assert isinstance(soft, SoftRecord) and soft.slips.drive.size >= 2 and result.success
    assert soft.period == pytest.approx(soft.slips.drive[-1] - soft.slips.drive[-2])
    np.testing.assert_allclose(soft.force, 0.8 * (soft.path - soft.position), atol=1e-12)
    np.testing.assert_allclose(soft.slips.force_before, 0.8 * (soft.slips.drive - soft.slips.before), atol=1e-12)
    toolkit.save(result, tmp_path / "out")
    again = toolkit.load(tmp_path / "out").master
    assert isinstance(again, SoftRecord)
    np.testing.assert_array_equal(again.slips.after, soft.slips.after)
    # what is read back has the names of what is solved
    checked = toolkit.load_scene(asked)
    solved = master.solve(checked.contacts, checked.path, 1e-7, spring=0.8, slip="reform-after")
    np.testing.assert_array_equal(again.slips.drive, solved.slips.drive)
    np.testing.assert_array_equal(again.slips.drop, solved.slips.drop)
    assert again.slips.drive_error == solved.slips.drive_error > 0.0 and again.regime == solved.regime
    finer = master.solve(checked.contacts, checked.path, 1e-10, spring=0.8, slip="reform-after")
    assert np.abs(finer.slips.drive - solved.slips.drive).max() <= solved.slips.drive_error + finer.slips.drive_error
    told = json.loads((tmp_path / "out" / "summary.json").read_text())["master"]
    assert told["period_error"] == 2.0 * soft.slips.drive_error
    assert told["slips"] == soft.slips.drive.size and told["verdict"] == soft.regime.verdict == again.regime.verdict


@pytest.mark.parametrize(
    ("drive", "tables", "says"),
    [
        ({"points": 11}, {}, "drive: needs one of to and turns, such as to = 5.0 or turns = [3.0, -3.0, 3.0]; neither"),
        ({"points": 11, "to": 1.0, "turns": [1.0]}, {}, "; both are given"),
        ({"points": 3, "turns": [1.0, -1.0, 1.0]}, {}, "drive.points = 3: must be"),
        ({"points": 11, "turns": []}, {}, "must hold a position at least"),
        ({"points": 11, "turns": [1.0, 1.0]}, {}, "drive.turns = [1.0, 1.0]: has a leg of no length"),
        ({"points": 11, "turns": [0.0, 1.0]}, {}, "drive.turns = [0.0, 1.0]: has a leg of no length"),
        ({"points": 11, "turns": [1.0, 1e9]}, {"eq": {}}, "as far as 1e+09 mean thresholds"),
        ({"points": 11, "to": 1.0, "from": 1.0}, {}, "drive.to = 1.0: has a leg of no length"),
        ({"points": 11, "to": 1.0, "from": -1e9}, {"eq": {}}, "drive: goes as far as 1e+09 mean thresholds"),
        ({"points": 11, "to": 1.0, "from": "a"}, {}, "drive.from: expected float"),
        ({"points": 11, "to": 1.0, "from": 0.5, "times": [1.0]}, {}, "for drive.from and each of drive.turns, 2"),
        ({"points": 11, "to": 1.0, "from": 0.5, "times": [1.0, 1.0]}, {}, "drive.times[1] = 1.0: must be later"),
        ({"points": 11, "to": 1.0, "from": 0.5, "times": [0.0, 1.0]}, {}, "drive.times[0] = 0.0: leaves no time"),
        ({"points": 11, "to": 1.0, "times": [1.0], "velocity": 2.0}, {}, "drive.velocity = 2.0: the times of"),
        ({"points": 11, "to": 1.0, "hold_scale": 1.0}, {}, "drive.hold_scale = 1.0: is of holds"),
        ({"points": 11, "to": 1.0, "times": [1.0], "hold_scale": 1.0}, {}, "drive.hold_scale = 1.0: is of holds"),
        ({"points": 11, "turns": [1.0, 1.0], "times": [1.0, 2.0], "hold_scale": 1e-99}, {}, "1e-99: is of holds"),
        ({"points": 11, "to": 1.0, "spring": 0.0}, {}, "drive.spring = 0.0: must be above zero"),
        ({"points": 11, "to": 1.0, "velocity": -1.0}, {}, "drive.velocity = -1.0: must be above zero"),
        ({"points": 11, "to": 1.0, "slip": "none"}, {}, "slip"),
    ],
)
def test_drives_that_cannot_be_are_refused(drive: dict[str, Any], tables: dict[str, Any], says: str) -> None:
    with pytest.raises(InputError) as refusal:
        toolkit.load_scene(scene(drive, **tables))
    assert says in str(refusal.value) and "\n" not in str(refusal.value)


def test_a_comparison_leaves_out_the_force_of_a_soft_slider() -> None:
    from toolkit.judge.compare import compare

    scenes = [toolkit.load_scene(scene({"to": 1.0, "points": 5, **spring})) for spring in ({}, {"spring": 0.5})]
    rigid, soft = sorted(compare(scenes), key=lambda verdict: verdict.result.master is None)
    assert rigid.value("critical_spring") == soft.value("critical_spring") and soft.result.master is None
    assert "F(X) is left out: drive.spring = 0.5: " in soft.cautions[0] and not rigid.cautions
