"""What precision and a scene cost: true errors against run time, fronts and crossings, imports."""

import dataclasses
import gc
import importlib.util
import json
import os
import re
import sys
import time
from collections import Counter
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import slow
from scenes import ROUGH, refused, said, scene, write

import eq_model
import master
import origins
from toolkit.judge import frontier
from toolkit.judge.reference import exact_force, unbroken
from toolkit.judge.rigid import on_rigid_slider
from toolkit.processes.signals import TooMuchWork, no_longer_than
from toolkit.running.cost import cost, cost_lines
from toolkit.running.solvers import solve_master
from toolkit.scene.scene import load_scene, shipped_scenes

DOCS = Path(__file__).parents[1] / "docs"
EQ = {"contacts": 200, "replicas": 4, "seed": 7}
WIDE = {"kind": "gaussian", "mean": 1.0, "std": 0.2}


@pytest.fixture(autouse=True)
def _here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A folder of its own, where few runs are repeated."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("toolkit.judge.precision.REPEATED", 0.05)


def read(path: str) -> Any:
    return json.loads(Path(path).read_text())


SHORT = {"master": (1e-2, 1e-6, 1e-10), "explicit": (25.0, 50.0, 100.0, 200.0)}
SHORT |= {"ensemble": (100.0, 1000.0, 10_000.0), "closest": (100.0, 1000.0)}


def test_precision_measures_each_rung_against_a_closed_form(capsys: Any, monkeypatch: Any) -> None:
    monkeypatch.setattr("toolkit.judge.precision.RUNGS", SHORT)
    start = {"kind": "gaussian", "mean": 0.1, "std": 0.05}
    contacts = {"thresholds": {"kind": "gaussian", "mean": 2.0, "std": 0.1}, "start": start}
    file = write(contacts=contacts, drive={"to": 6.0, "points": 61}, eq=EQ)
    assert said(capsys, "precision", file, "--format", "svg")[0] == 0
    ends = ("csv", "json", "png", "svg", "txt")
    assert sorted(os.listdir("mine-output")) == [f"precision.{end}" for end in ends]
    head, first, *_ = Path("mine-output/precision.csv").read_text().splitlines()
    assert head == "method,setting,error [<x_s>],claimed_error [<x_s>],run_time [s],runs"
    assert first.startswith("master,0.01,")
    written = read("mine-output/precision.json")
    assert written["reference"] == "the closed form for Gaussian thresholds"
    points: dict[str, Any] = {}
    for point in written["points"]:
        points.setdefault(point["method"], []).append(point)
    assert [len(of) for of in points.values()] == [3, 4, 3, 2]
    for p in points["master"]:
        assert p["error"] <= p["claimed_error"] + 1e-13 and p["claimed_error"] <= p["setting"]
    assert all(one["same_bits"] for one in written["threads"])
    counts = [one["threads"] for one in written["threads"]]
    assert counts[0] == 1 and len(set(counts)) == len(counts)
    # the worst of many positions: 1 to 4.4 largest standard errors in each of 400 trials
    assert all(0.5 < p["error"] / p["claimed_error"] < 5.0 for p in points["ensemble"])


def measured(capsys: Any, **tables: Any) -> Any:
    """precision.json of a scene."""
    status, out, err = said(capsys, "precision", write(**tables))
    assert status == 0 and out[-1] == "written to mine-output", err
    return read("mine-output/precision.json")


@pytest.mark.usefixtures("unrendered")
def test_precision_of_a_law_on_a_path_that_turns_has_the_other_solver_as_witness(
    capsys: Any, monkeypatch: Any
) -> None:
    monkeypatch.setattr("toolkit.judge.precision.RUNGS", SHORT)
    contacts = {"thresholds": WIDE, "delay": {"time": 0.2}}
    drive = {"turns": [1.5, -1.0], "points": 51}
    found = measured(capsys, contacts=contacts, drive=drive)
    methods = {point["method"] for point in found["points"]}
    assert methods == {"master", "ensemble"} == set(found["warm_up"])
    notes = "\n".join(found["notes"])
    assert "explicit, closest: left out; they take a path that does not turn round" in notes
    assert found["reference"].startswith("the master equation at 1e-10")
    witness = found["witness"]
    assert witness["contacts"] == 10_000 and 0.0 < witness["worst_deviation"] < 5.0
    errors = {p["setting"]: p["error"] for p in found["points"] if p["method"] == "master"}
    contacts, path = (own := load_scene("mine.toml")).contacts, own.path
    rough, fine = (master.solve(contacts, path, tolerance).force for tolerance in (1e-2, 1e-10))
    assert errors[1e-2] == pytest.approx(np.abs(rough - fine).max() / contacts.mean_threshold)
    assert errors[1e-10] is None  # the reference's own bits
    assert 0.0 < errors[1e-2] < 1e-2 and errors[1e-6] < 1e-6


@pytest.mark.usefixtures("unrendered")
def test_precision_of_a_surface_is_in_newtons(capsys: Any, monkeypatch: Any) -> None:
    """Of an area; with units = "N_c<k>", and of tolerances, in mean thresholds."""
    few = {"master": (1e-2, 1e-6), "explicit": (25.0,), "ensemble": (100.0,), "closest": (100.0,)}
    monkeypatch.setattr("toolkit.judge.precision.RUNGS", few)
    tables: dict[str, Any] = {"thresholds": ROUGH, "drive": {"to": 2e-8, "points": 9}}
    tables["drive"]["area"] = 1e-6
    newtons = measured(capsys, **tables)
    head = Path("mine-output/precision.csv").read_text().splitlines()[0]
    assert head == "method,setting,error [N],claimed_error [N],run_time [s],runs"
    shared = measured(capsys, units="N_c<k>", **tables)
    assert (newtons["error_unit"], shared["error_unit"]) == ("N", "<x_s>")
    scene = load_scene("mine.toml", changes={"units": "SI"})
    factor = scene.scale.force * scene.contacts.mean_threshold
    for name in ("error", "claimed_error", "setting"):
        pairs = zip(newtons["points"], shared["points"], strict=True)
        known = [(one[name], other[name]) for one, other in pairs if other[name]]
        times = 1.0 if name == "setting" else factor
        assert known and all(one == pytest.approx(times * other) for one, other in known)
    assert newtons["reference_error"] == pytest.approx(factor * shared["reference_error"])
    assert any(" in N, from " in note for note in newtons["notes"])


@pytest.mark.usefixtures("unrendered")
def test_precision_tells_where_the_witness_contradicts_the_reference(
    capsys: Any, monkeypatch: Any
) -> None:
    """A master equation whose delay is too long is found out, though it agrees with itself, and the status is 1."""
    monkeypatch.setattr("toolkit.judge.precision.RUNGS", SHORT)
    solve = master.solve

    def wrong(contacts: Any, *arguments: Any, **named: Any) -> Any:
        return solve(contacts.replace(delay=origins.Delay(0.4)), *arguments, **named)

    monkeypatch.setattr(master, "solve", wrong)
    contacts = {"thresholds": WIDE, "delay": {"time": 0.2}}
    file = write(contacts=contacts, drive={"to": 3.0, "points": 31})
    assert said(capsys, "precision", file)[0] == 1
    assert read("mine-output/precision.json")["witness"]["worst_deviation"] > 6.0


@pytest.mark.usefixtures("unrendered")
def test_precision_leaves_the_papers_methods_out_where_they_would_take_hours(
    capsys: Any, monkeypatch: Any
) -> None:
    monkeypatch.setattr("toolkit.judge.precision.RUNGS", SHORT | {"ensemble": (100.0,)})
    found = measured(capsys, thresholds=WIDE, drive={"to": 3e4, "points": 11})
    assert {point["method"] for point in found["points"]} == {"master", "ensemble"}
    assert "a path of over 1000 mean thresholds" in "\n".join(found["notes"])


@pytest.mark.usefixtures("unrendered")
def test_precision_of_a_spring_leaves_slips_out_and_shows_how_late_few_contacts_slip(
    capsys: Any, monkeypatch: Any
) -> None:
    monkeypatch.setattr("toolkit.judge.precision.RUNGS", SHORT)
    drive = {"to": 3.0, "points": 61, "spring": 0.5}
    found = measured(capsys, thresholds=WIDE | {"std": 0.05}, drive=drive)
    assert "its own finest run, away from slips" in found["reference"] and found["witness"] is None
    notes = "\n".join(found["notes"])
    assert "explicit, closest: left out; they take a rigid slider" in notes
    assert "independent of the master equation is the ensemble; on a spring" in notes
    solved = [p for p in found["points"] if p["method"] == "master"]
    assert solved[-1]["setting"] == 1e-10
    assert all((p["error"] or 0.0) < 2.0 * p["setting"] for p in solved)
    # tolerances that let the solver do the same share a row
    claims = [p["claimed_error"] for p in solved]
    assert len(set(claims)) == len(claims) < len(SHORT["master"])
    few, more, most = errors_of(found, "ensemble")
    assert few < 0.2 and 0.0 < most < more and most < 0.005  # a slip drops F by some 0.9


def errors_of(found: Any, method: str) -> list[float]:
    """Errors of a method's points, 0 for the reference's own bits."""
    return [p["error"] or 0.0 for p in found["points"] if p["method"] == method]


@pytest.mark.slow  # quick: the other solver as witness on a path that turns, above
@pytest.mark.usefixtures("unrendered")
def test_precision_of_a_slider_with_mass_has_both_solvers(capsys: Any, monkeypatch: Any) -> None:
    """Each is the other's road; where the master equation takes no mass, the largest ensemble is the reference."""
    short = {"master": (1e-2, 1e-4), "explicit": (25.0,), "closest": (100.0,)}
    monkeypatch.setattr(
        "toolkit.judge.precision.RUNGS", short | {"ensemble": (100.0, 1000.0, 10_000.0)}
    )
    heavy = {"to": 8.0, "points": 81, "spring": 0.2, "mass": 0.05, "damping": 0.2}
    found = measured(capsys, thresholds=WIDE | {"std": 0.05}, drive=heavy)
    assert found["reference"].startswith("the master equation at ")
    errors = errors_of(found, "ensemble")
    assert 0.0 < errors[-1] < errors[0] and errors[-1] < 0.03 and found["threads"]
    contacts = {"thresholds": WIDE | {"std": 0.05}, "stiffness": "linked"}
    found = measured(capsys, contacts=contacts, drive=heavy)
    assert found["reference"].startswith("the ensemble at 1e+04 contacts, its own largest run")
    assert {p["method"] for p in found["points"]} == {"ensemble"}
    assert found["points"][-1]["error"] is None and found["reference_error"] > 0.0
    notes = "\n".join(found["notes"])
    assert "no independent road: the ensemble" in notes and "master: left out; " in notes


@pytest.mark.usefixtures("unrendered")
def test_an_answer_of_which_nothing_is_known_is_no_reference(capsys: Any, monkeypatch: Any) -> None:
    """Errors of all others were not known beside it, where the ensemble is the other road."""
    solve = solve_master

    def unknown(*arguments: Any) -> Any:
        return dataclasses.replace(solve(*arguments), force_error=np.inf, message="not known")

    monkeypatch.setattr("toolkit.judge.precision.RUNGS", SHORT)
    monkeypatch.setattr("toolkit.judge.precision.solve_master", unknown)
    found = measured(capsys, thresholds={"kind": "rectangular", "lower": 0.5, "upper": 1.0})
    assert found["reference"].startswith("the ensemble at ")
    assert any("master: no answer at 0.01; not known" in note for note in found["notes"])


def test_a_path_on_which_nothing_breaks_says_so() -> None:
    """Errors of 1e-27 N stood without a word that contacts but were loaded."""
    law = {"kind": "gaussian", "mean": 1.0, "std": 0.1}
    for drive, few in (
        ({"to": 0.3}, "at most 1e-12 of the contacts break"),
        ({"to": 20.0, "spring": 0.02}, "at most 6e-10 of the contacts break"),
        ({"to": 0.65}, "at most 2e-04 of the contacts break"),
        ({"to": 2.0}, ""),
        ({"to": 20.0, "spring": 0.1}, ""),
    ):
        said = unbroken(load_scene(scene(law, drive=drive | {"points": 5})))
        assert len(said) == bool(few) and all(one.startswith(f"{few} on this path") for one in said)
    warm = {"thresholds": law, "thermal": {"law": "soft", "temperature": 0.1}}
    assert not unbroken(load_scene(scene(contacts=warm, drive={"to": 0.3, "points": 5})))


def test_what_no_solver_takes_is_refused_with_the_reasons_of_both(capsys: Any) -> None:
    law = {"rate": 0.1, "final": {"kind": "gaussian", "mean": 2.0, "std": 0.2}}
    heavy = {"to": 3.0, "points": 9, "spring": 0.5, "mass": 1.0}
    exact = {"kind": "identical", "value": 1.0}
    line = refused(
        capsys, "precision", write(contacts={"thresholds": exact, "ageing": law}, drive=heavy)
    )
    assert "master: left out; " in line and "ensemble: left out; " in line
    assert not Path("mine-output").exists()


def test_work_is_cut_by_its_own_time_and_not_by_that_of_the_clock() -> None:
    with no_longer_than(0.05, TooMuchWork):
        time.sleep(0.2)
    with pytest.raises(TooMuchWork), no_longer_than(0.05, TooMuchWork):
        while True:
            pass
    time.sleep(0.01)  # the timer is off again


@pytest.mark.usefixtures("unrendered")
def test_precision_of_a_sweep_is_that_of_a_path_at_its_speed(capsys: Any, monkeypatch: Any) -> None:
    """F(X) of a rigid slider, or the scene without its sweep; of both solvers, whose forces agree."""
    short = SHORT | {"master": (1e-2, 1e-6), "ensemble": (100.0, 3000.0)}
    monkeypatch.setattr("toolkit.judge.precision.RUNGS", short)
    contacts = {"thresholds": WIDE, "delay": {"time": 0.2}}
    nothing: dict[str, Any] = {"drive": None, "master": None}
    found = measured(capsys, contacts=contacts, **nothing, sweep={"velocity": [2.0, 8.0]})
    notes = "\n".join(found["notes"])
    assert "measured is F(X) of a rigid slider from X = 0 on, at a speed of 2" in notes
    assert found["witness"]["worst_deviation"] < 5.0
    swept = {"contacts.thresholds.std": [0.1, 0.2]}
    found = measured(capsys, contacts=contacts, drive={"to": 2.0, "points": 9}, sweep=swept)
    assert "measured is the scene without it" in "\n".join(found["notes"])
    path = np.linspace(0.0, 2.0, 9)
    own = origins.Contacts(origins.gaussian(1.0, 0.2), delay=origins.Delay(0.2))
    rough, fine = (master.solve(own, path, tolerance).force for tolerance in (1e-2, 1e-6))
    assert found["points"][0]["error"] == pytest.approx(np.abs(rough - fine).max(), rel=1e-9)


def made() -> tuple[Any, str]:
    """The script that makes the tables of docs/error-and-cost.md, and the page."""
    spec: Any = importlib.util.spec_from_file_location("made", DOCS / "error_and_cost.py")
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    return script, (DOCS / "error-and-cost.md").read_text(encoding="utf-8")


def test_a_reference_that_ended_before_it_was_known_leaves_errors_unknown() -> None:
    """On a busy machine it may: the script that makes the tables ended in a TypeError."""
    script, _ = made()
    run = {"error": 0.1, "run_time": 2.0}
    assert script.point(run, None) == "not known, 2 s"
    assert script.point(run, 0.2) == "< 2e-01, 2 s" and script.point(run, 0.01) == "1e-01, 2 s"


# those with kernels, which are compiled for it, are slow
SOME = [
    "gaussian",
    "stick-slip",
    "ageing-springs",
    "eyring",
    "tribometer",
    "thermal-soft",
    "samples",
]


@pytest.mark.parametrize("scene", ["delay", *(slow(scene) for scene in SOME)])
def test_the_table_of_costs_is_up_to_date(scene: str) -> None:
    """What a scene builds and leaves out is what the page says, and the shares of files within ten percent; else
    `python docs/error_and_cost.py --costs` makes it anew."""
    script, page = made()
    says, now = (
        row.strip("| ").split(" | ")
        for row in (script.rows_of(page, "costs")[scene], script.cost_row(scene))
    )
    assert says[4] == now[4]
    here, there = ([float(share.split()[1]) for share in row[5].split(", ")] for row in (says, now))
    assert len(here) == 4 and here == pytest.approx(there, abs=10.0)
    assert [share > 0.0 for share in here] == [share > 0.0 for share in there]
    missing = set(says[6].split(", ")) - set(now[6].split(", "))
    assert set(now[6].split(", ")) <= set(says[6].split(", "))
    assert not [name for name in missing if importlib.util.find_spec(name)]  # an extra left out


def test_tables_of_errors_and_costs_are_what_their_script_makes() -> None:
    """Each shipped scene has its rows, README's are some of them, and heads and rows have as many cells as the script
    writes."""
    script, page = made()
    readme = (DOCS.parent / "README.md").read_text(encoding="utf-8")
    errors, costs = (script.rows_of(page, name) for name in ("errors", "costs"))
    assert list(errors) == list(costs) == shipped_scenes()
    for text, name, head in (
        (page, "errors", script.ERRORS),
        (page, "costs", script.COSTS),
        (readme, "errors", script.ERRORS),
    ):
        rows = script.rows_of(text, name)
        assert f"<!-- {name} -->\n{head}\n" in text
        assert script.with_rows(text, name, head, list(rows.values())) == text
        assert {row.count(" | ") for row in rows.values()} == {head.count(" | ")}, name
    few = script.rows_of(readme, "errors")
    assert len(few) > 4 and few.items() <= errors.items()
    point = {"method": "master", "setting": 1e-3, "error": 2e-8, "run_time": 0.02}
    found = {"points": [point, point | {"setting": 1e-9, "error": None}], "reference_error": 3e-12}
    row = "| mine | 2e-08, 0.02 s | < 3e-12, 0.02 s |  | master at every error |"
    assert script.error_row("mine", found | {"notes": []}) == row
    assert script.error_row("mine", "mesofriction: no").count(" | ") == row.count(" | ")


# rows of the table whose errors a second or so of work finds again, all rigid sliders
QUICK = ["delay", "friction-loop", "gaussian", "grains", "gw-elastic", "kinetic-force", "persson"]
SOLVED = [*QUICK, "delays", "gw-gaussian", "gw-plastic", "lubricated", "one-peak", "persson-wide"]
SOLVED += ["rectangular", "reforming", "rough-gw-mixed", "rough-gw-paper", "rough-gw-strength"]
SOLVED += ["rough-persson-amontons", "rough-persson-paper", "strengthening", "two-peaks"]


@pytest.mark.parametrize("name", [slow(name, when=name not in QUICK) for name in SOLVED])
def test_the_table_of_errors_holds_true_errors(name: str) -> None:
    """The true error of the master equation at 1e-3 is that of the page, to the one digit told there; else `python
    docs/error_and_cost.py --errors` makes the page anew. Run times are the machine's."""
    _, page = made()
    told = float(re.findall(rf"^\| {name} \| ([-\de]+), ", page, re.MULTILINE)[0])
    scene = load_scene(name, changes={"units": "N_c<k>"})
    if scene.given_drive is None or scene.master is None:
        scene = on_rigid_slider(scene)
    solved, exact = solve_master(scene, 1e-3), exact_force(scene)
    force = solve_master(scene, 1e-9).force if exact is None else exact.force
    off = np.abs(solved.force - force).max() / scene.contacts.mean_threshold
    digit = 10.0 ** np.floor(np.log10(told))
    assert off == pytest.approx(told, abs=0.51 * digit) and off <= solved.force_error


def test_the_front_of_a_method_its_slope_and_the_crossings() -> None:
    """Errors 0.1 t^(-1/2) from t = 0.01 on, with a run that is beaten, and a method that takes 1 s at any error: they
    cross at an error of 0.1."""
    slow = [(10.0**k, 0.1 * 10.0 ** (-k / 2)) for k in range(-2, 3)] + [(50.0, 0.5)]
    points = [{"method": "slow", "run_time": t, "error": e} for t, e in slow]
    points += [{"method": "flat", "run_time": 1.0, "error": e} for e in (1e-2, 1e-9, None)]
    found = frontier.front(points, "slow", 1e-12)
    assert (np.diff(found.run_time) > 0.0).all() and (np.diff(found.error) < 0.0).all()
    power = frontier.slope(points, "slow", 1e-12)
    assert found.error.size == 5 and power is not None
    assert power.value == pytest.approx(-0.5) and power.error < 1e-12
    assert frontier.slope(points, "flat", 1e-12) is None
    first, second = frontier.cheapest(points, 1e-12)
    assert (first["method"], second["method"]) == ("slow", "flat") and first["below"] is None
    assert first["above"] == second["below"] == pytest.approx(0.1, rel=0.15)
    assert second["above"] == pytest.approx(1e-12)
    words = frontier.as_words({"slow": power, "flat": None}, [first, second])
    assert (
        words[0] == "error falls: slow as time^(-0.50 ± 0.01)" and "flat below 1e-01;" in words[1]
    )
    # 100 times as fast at an error of 1, and at 0.01; beyond, no other gets
    assert first["faster"] == pytest.approx(100.0) and second["faster"] is None


def test_a_slope_that_start_up_or_chance_blurs_is_not_told() -> None:
    """An ensemble whose error is 1/N^(1/2), and which takes 3 ms before its first contact, had time^-0.63; of three
    runs that do not lie on a line no slope is told either."""
    sizes = 10.0 ** np.arange(2, 8)
    runs = [{"run_time": 3e-3 + 1.6e-8 * n, "error": n**-0.5, "setting": n} for n in sizes]
    points = [run | {"method": "ensemble"} for run in runs]
    points += [
        {"method": "explicit", "run_time": t, "error": e}
        for t, e in ((1e-3, 1.0), (1e-2, 0.5), (1e-1, 0.4), (1.0, 0.01))
    ]
    assert frontier.slope(points, "ensemble", 1e-9) is None
    assert frontier.slope(points, "explicit", 1e-9) is None
    by_size = frontier.slope(points, "ensemble", 1e-9, "setting")
    assert by_size is not None and by_size.value == pytest.approx(-0.5)
    # 0.3 in the log of each of six errors, one a decade
    assert by_size.error == pytest.approx(0.3 / (np.log(10.0) * 17.5**0.5))
    (words, *_) = frontier.as_words({}, [], by_size={"ensemble": by_size})
    assert words == "error falls: ensemble as contacts^(-0.50 ± 0.03)"


@pytest.mark.parametrize(("other", "chance"), [(0.9, True), (0.6, False)])
def test_a_crossing_that_run_times_hardly_tell_is_said_to_be(other: float, chance: bool) -> None:
    """Two methods at one error, whose times differ by a ninth, or by two thirds."""
    both = {"one": [1.0, 10.0], "other": [2.0, 10.0 * other]}
    points = [
        {"method": name, "run_time": t, "error": e}
        for name, times in both.items()
        for t, e in zip(times, (1e-2, 1e-4), strict=True)
    ]
    first, second = frontier.cheapest(points, 1e-12)
    assert (first["method"], second["method"]) == ("one", "other")
    assert first["faster"] == pytest.approx(2.0) and second["faster"] == pytest.approx(1.0 / other)
    (line,) = frontier.as_words({}, [first, second])
    assert ("(by a factor of 1.1, which may be chance)" in line) is chance
    assert line.count("chance") == chance


def test_claims_are_counted_where_the_reference_tells() -> None:
    """Of five runs two are nearer to the reference than it is good, one is the reference, and one claims too little."""
    runs = [(1e-3, 2e-3), (1e-4, 5e-5), (1e-9, 1e-6), (2e-9, 1e-7), (None, 1e-8)]
    points = [{"method": "master", "error": off, "claimed_error": own} for off, own in runs]
    said_of_all = "in 1 of 2 runs; 2 are nearer to the reference than its own error"
    (line,) = frontier.of_claims(points, 1e-8)
    assert line == f"master: its claim bounds the true error {said_of_all}"
    (line,) = frontier.of_claims(points, 1.0)
    assert line == "master: 4 are nearer to the reference than its own error"
    assert frontier.of_claims(points[4:], 1e-8) == []


def test_cost_tells_what_a_scene_imports_and_leaves_out() -> None:
    """Of one solver alone the other room, its libraries and the laws are told as left out."""
    law = {"thresholds": WIDE, "delay": {"time": 0.1}, "interface": {"mean_stiffness": 10.0}}
    found = cost(write(contacts=law, drive={"to": 2.0, "points": 21}))
    packages = {name for stage in found["stages"] for name in stage["packages"]}
    assert found["rooms"]["eq_model"][0] == 0 < found["rooms"]["master"][0]
    assert "numpy" in packages and not {"numba", "matplotlib", "h5py", "mpi4py"} & packages
    assert all(stage["cpu_seconds"] >= 0.0 == stage["by_workers"] for stage in found["stages"])
    start, _, run = cost_lines(found)[1:4]
    found["stages"][-1] |= {"cpu_seconds": 5.0, "by_workers": 4.0}
    beside = cost_lines(found)
    assert "5.00 CPU-seconds with those of worker processes" in beside[3] and beside[1] == start
    assert "CPU-seconds" not in run and "beside each other" in beside[6]
    assert "the rest of the run" not in beside[6]
    assert found["no_solvers"] == ["[eq]"] and set(found["runs"]) == {"master"}
    assert {"numba", "matplotlib"} <= set(found["no_packages"])
    assert "interface" in found["builds"] and not {"delay", "interface"} & set(found["no_laws"])
    assert {"thermal", "ageing"} <= set(found["no_laws"])


@pytest.mark.slow  # quick: the test before
def test_cost_of_the_ensemble_tells_what_it_leaves_out(capsys: Any) -> None:
    """As lines of the command."""
    drawn = write(thresholds=WIDE, master=None, eq=EQ, drive={"to": 2.0, "points": 21})
    status, out, _ = said(capsys, "cost", drawn)
    left = next(line for line in out if line.startswith("left out "))
    assert status == 0 and "[master]" in left and "numba" not in left and "matplotlib" in left
    assert "master 0 of " in "".join(out) and not Path("mine-output").exists()
    assert "no shipped scene" in refused(capsys, "cost", "gausian")


PATH = np.linspace(0.0, 3.0, 31)
PEAK = origins.gaussian(1.0, 0.1)
SOLVERS: dict[str, Callable[..., Any]] = {
    "master": lambda contacts, **drive: master.solve(contacts, PATH, 1e-6, **drive),
    "eq_model": lambda contacts, **drive: eq_model.simulate(
        contacts, PATH, n_contacts=500, n_replicas=2, seed=1, **drive
    ),
}
# laws whose strength is none, and some
IDLE: dict[str, Any] = {
    "delay": origins.Delay(0.0),
    "ageing": origins.Ageing(origins.gaussian(1.2, 0.1), 0.0),
    "reforming": 0.0,
    "stiffness": "independent",
    "thermal": None,
    "thresholds": origins.strengthening(PEAK, 0.0, 1.0),
}
STRONG = IDLE | {"thermal": origins.Thermal("soft", 0.1), "delay": origins.Delay(0.3)}
STRONG |= {"ageing": origins.Ageing(origins.gaussian(1.2, 0.1), 1e-3)}
STRONG |= {"thresholds": origins.strengthening(PEAK, 0.05, 1.0)}
OF_LAWS = re.compile(
    r"(master/survival/(heat|age|grains|growing|integrated_rate)|origins/(laws|grains)/)"
)
EYRING = origins.Thermal("eyring", width=0.03)
OF_MASS = re.compile(r"(master/soft/inertia|eq_model/coupled/mass)/")


def work(call: Callable[[], Any]) -> Counter[tuple[str, str]]:
    """How often each function is called within, of Python's and of C's, by file and name; compiled kernels are not."""
    seen: Counter[tuple[str, str]] = Counter()

    def look(frame: Any, event: str, function: Any) -> None:
        if event == "call":
            seen[frame.f_code.co_filename, frame.f_code.co_name] += 1
        elif event == "c_call":
            seen["", function.__name__] += 1

    gc.disable()  # what it frees is called at any time
    sys.setprofile(look)
    try:
        call()
    finally:
        sys.setprofile(None)
        gc.enable()
    return seen


def calls_of(
    solve: Callable[..., Any], drive: dict[str, Any] | None = None, **laws: Any
) -> Counter[tuple[str, str]]:
    """The calls of a solver with these laws, in a second run: nothing is compiled or imported in it."""
    drive, thresholds = drive or {}, laws.pop("thresholds", PEAK)
    solve(origins.Contacts(thresholds, **laws), **drive)
    contacts = origins.Contacts(thresholds, **laws)
    return work(lambda: solve(contacts, **drive))


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_law_that_is_absent_costs_no_work(solver: str) -> None:
    """The same calls, as many of each, as without the law, and none of a law's own; where it is present, some are."""
    calls = partial(calls_of, SOLVERS[solver])
    plain = calls()
    assert sum(plain.values()) > 1000
    assert not [file for file, _ in plain if OF_LAWS.search(file)]
    for name, idle in IDLE.items():
        assert calls(**{name: idle}) == plain, name
    for name in ("thermal", "ageing", "delay", "thresholds"):
        assert calls(**{name: STRONG[name]}) != plain, name
    for name in ("ageing", "thermal", "thresholds"):
        assert [file for file, _ in calls(**{name: STRONG[name]}) if OF_LAWS.search(file)], name


# the ensemble's kernel is compiled for 7 s
@pytest.mark.parametrize("solver", ["master", slow("eq_model")])
def test_a_law_of_heat_costs_work_of_its_own(solver: str) -> None:
    """That of stress-assisted breaking."""
    found = calls_of(SOLVERS[solver], thermal=EYRING)
    assert [file for file, _ in found if OF_LAWS.search(file)]


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_mass_that_is_absent_costs_no_work(solver: str) -> None:
    calls = partial(calls_of, SOLVERS[solver])
    plain = calls({"spring": 0.5})
    assert not [file for file, _ in plain if OF_MASS.search(file)]
    assert calls({"spring": 0.5, "mass": None}) == plain
    heavy = calls({"spring": 0.5, "mass": 0.1, "damping": 0.3})
    assert [file for file, _ in heavy if OF_MASS.search(file)]
