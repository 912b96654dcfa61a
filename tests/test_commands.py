"""The commands: what they print, write and return; what they say before they work, or in one line instead."""

import csv
import ctypes
import json
import os
import re
import runpy
import signal
import threading
import time
from argparse import Namespace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from conftest import slow
from scenes import GAUSSIAN, ROUGH, refused, said, scene, write

import master
import origins
import toolkit
from toolkit import commands
from toolkit.command import main
from toolkit.running.progress import SHORTEST, Progress
from toolkit.scene.interfaces import remarks
from toolkit.scene.scale import guarded
from toolkit.scene.scene import shipped_scenes

EQ = {"contacts": 200, "replicas": 4, "seed": 7}
WIDE = {"kind": "gaussian", "mean": 1.0, "std": 0.2}

pytestmark = pytest.mark.usefixtures("in_a_folder", "unrendered")


def for_ever(*arguments: Any, **named: Any) -> None:
    while True:
        time.sleep(1e-3)


def read(path: str) -> Any:
    return json.loads(Path(path).read_text())


def test_a_signal_that_a_callback_swallows_comes_again() -> None:
    """Python drops an exception in a callback of compiled code, as of LLVM while numba compiles."""
    from toolkit.processes.signals import Terminated, terminable

    compiled = ctypes.CFUNCTYPE(None)(lambda: os.kill(os.getpid(), signal.SIGTERM))
    with pytest.raises(Terminated), terminable():
        compiled()
        for_ever()


# -- run ---------------------------------------------------------------------------------------------


def test_run_prints_a_line_per_solver_and_writes(capsys: Any) -> None:
    title = "x^ $a_{$"  # no formula
    status, lines, err = said(capsys, "run", write(eq=EQ, title=title))
    written = read("mine-output/summary.json")
    assert (status, lines[0], lines[-1], err) == (0, title, "written to mine-output", [])
    assert f"error {written['master']['force_error']:.1e} of <x_s>" in lines[1]
    assert f"error {written['eq']['largest_standard_error']:.1e} of <x_s>" in lines[2]
    assert toolkit.load("mine-output").text == Path("mine.toml").read_text()


def test_a_reader_that_closes_its_end_does_not_cost_the_result(monkeypatch: Any) -> None:
    """As `head -1`: hours of work were lost as the report stood before the files."""

    def closed(*_: Any, **__: Any) -> None:
        raise BrokenPipeError

    asked = Namespace(scene=write(), changes=[], out=None, format=None, checkpoint=60.0)
    asked.dry_run = False
    monkeypatch.setattr("builtins.print", closed)
    with pytest.raises(BrokenPipeError):
        commands.run(asked, None)
    assert toolkit.load("mine-output").success


def test_a_run_whose_solvers_are_far_apart_is_status_1(capsys: Any, monkeypatch: Any) -> None:
    monkeypatch.setattr("toolkit.results.report.deviation", lambda _: SimpleNamespace(worst=7.0))
    status, out, _ = said(
        capsys, "run", write(thresholds=WIDE, drive={"to": 1.0, "points": 5}, eq=EQ)
    )
    assert status == 1 and "please report" in "".join(out)


def test_run_of_a_surface_says_and_keeps_what_to_mind(capsys: Any) -> None:
    surface = {"kind": "self-affine", "shape": [32, 32], "pixel_size": 1e-8, "seed": 1}
    law = ROUGH | {"surface": surface | {"hurst": 0.8, "rms_slope": 0.1}}
    status, out, _ = said(capsys, "run", write(thresholds=law, drive={"to": 5e-8, "points": 21}))
    interface = toolkit.load_scene("mine.toml").contacts.interface
    told = [line.removeprefix("note    ") for line in out if line.startswith("note ")]
    assert status == 0 and told[:-2] == list(interface.cautions) != []
    written = read("mine-output/summary.json")
    assert written["notes"] == told == list(toolkit.load("mine-output").notes)
    assert written["interface"]["contact_density"]["value"] == interface.contact_density


def test_what_is_to_be_minded_is_told_once_and_before(capsys: Any) -> None:
    """Kelvins in place of a length squared; a path far beyond all memory."""
    contacts = {"thresholds": GAUSSIAN, "thermal": {"law": "soft", "temperature": 500.0}}
    file = write(contacts=contacts, drive={"to": 1.0, "points": 3}, master={"tolerance": 1e-2})
    _, out, (line, *_) = said(capsys, "run", file)
    assert line.startswith("mesofriction: the temperature is 499 <x_s^2>")
    assert "the temperature is" not in "".join(out) and len(toolkit.load("mine-output").notes) == 1
    with pytest.warns(UserWarning, match=r"temperature is 299 <x_s\^2>: .* a length squared"):
        origins.Contacts(origins.gaussian(1.0, 0.05), thermal=origins.Thermal("soft", 300.0))
    for to, told in ((5e6, "5e+06 times <x_s>"), (5e-3, "0.005 times <x_s>")):
        driven = toolkit.run(scene(drive={"to": to, "points": 3}))
        assert driven.success and told in driven.notes[0]


def test_a_path_that_ends_before_the_first_slip_says_how_far_to_go() -> None:
    pulled = {"to": 1.0, "points": 11, "spring": 0.5}
    result: Any = toolkit.run(scene(WIDE | {"std": 0.1}, drive=pulled))
    reason = result.master.regime.reason
    assert not result.master.slips.drive.size
    far = result.master.regime.drive_to
    assert reason.endswith(f"but the first one comes later; drive to X_T = {far:.4g}")
    toolkit.save(result, Path("mine-output"))
    assert toolkit.load("mine-output").master.regime.drive_to == far
    result = toolkit.run(scene(WIDE | {"std": 0.1}, drive=pulled | {"to": far}))
    assert result.master.slips.drive.size
    # behind the first slip it is known that under "instant" others shrink
    assert all(note.startswith("the slip rule decides") for note in result.notes)


def test_a_scan_with_gaps_says_by_which_rule_slopes_count(tmp_path: Path) -> None:
    pytest.importorskip("SurfaceTopography")
    heights = 200.0 * origins.self_affine_surface((24, 24), 1.0, hurst=0.8, rms_slope=0.1, seed=1)
    heights[::9, ::9] = np.nan
    np.savetxt("gaps.txt", heights, header="Width: 10 µm\nHeight: 10 µm\nValue units: nm")
    law = ROUGH | {"surface": {"kind": "scan", "file": str(tmp_path / "gaps.txt")}}
    notes = toolkit.run(scene(law, drive={"to": 1e-8, "points": 3})).notes
    assert any("of the scan's points are missing: a slope counts where" in note for note in notes)


def test_sizes_of_a_scan_the_other_way_round_are_asked_about(tmp_path: Path) -> None:
    """128 rows of 64 points, 10 nm apart both ways: swapped, they are 20 nm and 5 nm apart, and slopes are wrong."""
    pytest.importorskip("SurfaceTopography")
    heights = origins.self_affine_surface((128, 64), 1e-8, hurst=0.8, rms_slope=0.1, seed=1)
    np.savetxt("swapped.txt", heights)
    for sizes, asked in (([6.4e-7, 1.28e-6], False), ([1.28e-6, 6.4e-7], True)):
        scan = {"kind": "scan", "file": str(tmp_path / "swapped.txt"), "physical_sizes": sizes}
        law = ROUGH | {"surface": scan | {"unit": "m"}}
        found = toolkit.load_scene(scene(law, drive={"to": 1e-8, "points": 3}))
        said_of = remarks(found.contacts.thresholds)
        assert any("is physical_sizes right" in one for one in said_of) is asked
    assert "20.0 nm apart along x and 5.00 nm along y" in said_of[0]


def test_a_dry_run_foretells_the_run_and_writes_nothing(capsys: Any) -> None:
    """By the work of its pilot, whatever the machine; contacts done before are counted, another run's are not."""
    eq = {"contacts": 600_000, "replicas": 2, "seed": 2}
    big = {"thresholds": WIDE, "drive": {"to": 10.0, "points": 21}, "master": None}
    write("cut", **big, eq=eq | {"wall_time": 1e-9})
    write("other", **big, eq=eq | {"seed": 3, "wall_time": 1e-9})
    told = "\n".join(said(capsys, "run", "cut.toml", "--dry-run")[1])
    assert "contacts        1,200,000" in told and "standard error" in told
    assert said(capsys, "run", "cut.toml", "--out", "out")[0] == 1
    done, before = toolkit.load("out").eq.contacts, sorted(Path().rglob("*"))
    told = "\n".join(said(capsys, "run", "cut.toml", "--out", "out", "--dry-run")[1])
    assert f"1,200,000, {done:,} of them done before" in told
    line = refused(capsys, "run", "other.toml", "--out", "out", "--dry-run")
    assert "holds the checkpoint of another run, eq.seed = 2 there and 3 here" in line
    assert sorted(Path().rglob("*")) == before


@pytest.mark.parametrize(
    "wanted", [{}, {"tolerance": 5e-4}, {"spring": 0.7}], ids=["plain", "wanted", "pulled"]
)
def test_contacts_breaks_and_error_are_as_foretold(wanted: dict[str, float]) -> None:
    from toolkit.running.forecast import forecast

    spring = {name: value for name, value in wanted.items() if name == "spring"}
    size = {"contacts": 9000, "replicas": 20} if spring else {"contacts": 1_000_000, "replicas": 1}
    eq = size | {name: value for name, value in wanted.items() if name == "tolerance"}
    tables = scene(WIDE, drive={"to": 4.0, "points": 11, **spring}, master=None, eq=eq)
    asked = toolkit.load_scene(tables)
    told, run = forecast(asked), toolkit.run(asked).eq
    most = 4.0 if "tolerance" in wanted else 1.1
    assert told.contacts / most <= run.contacts <= most * told.contacts
    assert told.breaks / told.contacts == pytest.approx(run.breaks / run.contacts, rel=0.05)
    if not spring:
        assert 0.5 < told.error / run.force_standard_error.max() < 2.0


def test_work_of_over_a_minute_says_so_at_the_first_look(capsys: Any) -> None:
    """Before its patience is over; the looks come when the test lets them."""
    looks = threading.Semaphore(0)
    done = SimpleNamespace(wait=lambda seconds: looks.acquire() and over, set=lambda: None)
    over = False
    bar = Progress("eq", done=done)
    bar.count(1000, 10**15)
    time.sleep(1.1 * SHORTEST)  # two counts nearer to each other give no rate
    bar.count(2000, 10**15)
    looks.release()
    while not (line := capsys.readouterr().err):
        time.sleep(1e-3)
    over = True
    looks.release()
    bar.close()
    assert line.startswith("mesofriction: eq: 2,000 of 1,000,000,000,000,000 contacts (0%), ")
    assert " left, after 0:00:0" in line


@pytest.mark.parametrize("what", ["master", "sweep", "compare", "thresholds", "precision"])
def test_the_wall_time_is_that_of_all_solvers_and_commands(
    what: str, monkeypatch: Any, capsys: Any
) -> None:
    for name in ("solve", "kinetic_curve", "propensity"):
        monkeypatch.setattr(master, name, for_ever)
    tables = {"master": None, "sweep": {"velocity": [1.0, 2.0]}} if what == "sweep" else {}
    file = write(**tables, wall_time=0.01)
    line = refused(capsys, "run" if what in ("master", "sweep") else what, file)
    assert "wall_time = 0.01: is over before " in line and os.listdir() == ["mine.toml"]


def test_at_the_wall_time_the_master_equation_ends_with_what_it_has(
    monkeypatch: Any, capsys: Any
) -> None:
    given, solve = list[float](), master.solve

    def cut(*arguments: Any, wall_time: float, **others: Any) -> Any:
        given.append(wall_time)
        return solve(*arguments, wall_time=1e-9, **others)

    monkeypatch.setattr(master, "solve", cut)
    drive = {"to": 8.0, "points": 9, "spring": 0.1, "mass": 1.0, "damping": 0.3, "velocity": 1.0}
    contacts = {"thresholds": GAUSSIAN, "delay": {"time": 1.0}}
    file = write(drive=drive, contacts=contacts, wall_time=100.0)
    status, _, err = said(capsys, "run", file, "--out", "cut")
    assert status == 1 and "stopped by wall_time: the path is cut at X_T" in err[-1]
    solved = toolkit.load("cut").master
    assert 0 < solved.path.size < 9 and not solved.success and 90.0 < given[0] <= 100.0


def test_where_no_slider_of_the_ensemble_is_done_at_the_wall_time_the_master_equation_is_kept(
    capsys: Any,
) -> None:
    drive = {"to": 3.0, "points": 4, "spring": 0.5}
    asked = {"contacts": 1000, "replicas": 2, "wall_time": 1e-9}
    file, said_in_one_line = write(drive=drive, eq=asked), "eq.wall_time = 1e-09: no slider was "
    status, out, _ = said(capsys, "run", file, "--out", "half")
    assert status == 1 and any(line.startswith(f"note    {said_in_one_line}") for line in out)
    found = toolkit.load("half")
    assert found.master.success and found.eq is None and not found.success
    line = refused(capsys, "run", write(drive=drive, eq=asked, master=None), "--out", "none")
    assert line.startswith(said_in_one_line)


def test_resampled_laws_are_the_same_in_any_number_of_threads(monkeypatch: Any) -> None:
    from origins.samples.from_samples import bootstrap_laws
    from toolkit.running import resampled

    law, seen = origins.from_samples([0.9, 1.0, 1.1, 1.3]), list[tuple[int, int]]()
    known = [other.mean() for other in bootstrap_laws(law, 3)]
    monkeypatch.setattr(resampled, "cores_of", lambda comm: 3)
    found = resampled.of_resampled(law, 3, lambda other: other.mean(), lambda *of: seen.append(of))
    assert found == known and len(set(known)) == 3 and seen == [(1, 3), (2, 3), (3, 3)]


# -- the other commands ---------------------------------------------------------------------------------


def test_thresholds_print_moments_within_their_errors_and_draw(capsys: Any) -> None:
    file = write(thresholds={"kind": "rectangular", "lower": 0.5, "upper": 1.5}, master=None)
    status, out, _ = said(capsys, "thresholds", file)
    assert status == 0 and any(f"{13 / 12:.8g}" in line for line in out)
    assert sorted(os.listdir("mine-output")) == ["thresholds.json", "thresholds.png"]
    numbers = read("mine-output/thresholds.json")["numbers"]
    exact = {"mean": 1.0, "second_moment": 13 / 12, "third_moment": 1.25, "median": 1.0}
    # K* at X = 3/2, first and second breaks: F' = 1 - X P_c(X) - (3/8), the last the integral of s from 1/2 to 1
    exact |= {"kinetic_force": 13 / 24, "onset_power": 0.0, "critical_spring": 7 / 8}
    for name, value in exact.items():
        assert abs(numbers[name]["value"] - value) <= numbers[name]["error"] < 1e-6, name


def test_a_table_that_misses_its_tolerance_is_status_1_and_says_what_has_laws(capsys: Any) -> None:
    """Contacts that heat breaks long before their thresholds: K* is zero within an error of some 1e-6."""
    law, thermal = WIDE | {"std": 0.1}, {"law": "soft", "temperature": 0.3}
    contacts = {"thresholds": law, "thermal": thermal}
    hot = write("hot", contacts=contacts, drive={"to": 1e-3, "points": 3, "velocity": 1e-9})
    for command, expected in (("thresholds", 1), ("compare", 1), ("run", 0)):
        status, out, _ = said(capsys, command, hot)
        assert status == expected == ("not as asked: " in "".join(out))
    assert not read("hot-output/thresholds.json")["success"]
    warm = contacts | {"thresholds": ROUGH, "stiffness": "linked"}
    warm["thermal"] = {"law": "soft", "temperature": {"kelvin": 300.0}, "attempt_frequency": 1e9}
    status, out, err = said(capsys, "thresholds", write("warm", contacts=warm, master=None))
    rows = [row.split("  ")[1] for row in out if row.endswith(("  (with laws)", "  (P_c alone)"))]
    assert status == 0 and rows[::4] == ["kinetic force per area", "friction coefficient"]
    assert err[-1].endswith("contacts carry more than the load, and F may exceed mu times it")


def test_compare_ranks_prints_and_writes_the_solvers_own_numbers(capsys: Any) -> None:
    narrow, drive = {"kind": "gaussian", "mean": 2.0, "std": 0.1}, {"to": 4.0, "points": 41}
    wide, exact = {"kind": "gw-plastic", "B": 1.251}, {"kind": "identical", "value": 1.0}
    laws = {"wide": wide, "exact": exact, "narrow": narrow}
    files = [write(name, thresholds=law, drive=drive, eq=EQ) for name, law in laws.items()]
    soft = write("soft", thresholds=narrow, drive=drive | {"spring": 0.5})
    status, lines, _ = said(capsys, "compare", *files, soft, "--out", "deep/er")
    files_there = {f"compare.{end}" for end in ("csv", "json", "png", "txt")}
    assert status == 0 and set(os.listdir("deep/er")) == files_there
    assert Path("deep/er/compare.txt").read_text().splitlines() == lines[:-1]
    head, best, *_ = Path("deep/er/compare.csv").read_text().splitlines()
    heads = {"critical_spring [N_c<k>]", "mean_threshold [length]"}
    assert heads < set(head.split(",")) and best.startswith("exact,")
    columns = zip(*csv.reader(Path("deep/er/compare.csv").read_text().splitlines()), strict=True)
    assert all({*column[1:]} - {"", "nan"} for column in columns)  # none is empty
    keys = read("deep/er/compare.json")["keys"]
    told = {name for scene in read("deep/er/compare.json")["scenes"] for name in scene}
    assert {name.removesuffix("_error") for name in told} <= {*keys, "name", "title"}
    # short heads, and what they mean
    assert {"K*/(N_c<k>)", "F_s/F_k", "X*/<x_s>", "simulated", "apart"} <= {
        *" ".join(lines).split()
    }
    meant = "K*: steepest fall of the force; a slider on a softer spring slips at least once; power m: P_c"
    assert any(line.startswith(meant) for line in lines)
    found = {one["name"]: one for one in read("deep/er/compare.json")["scenes"]}
    assert next(iter(found)) == "exact" and list(found)[-1] == "wide"
    assert found["exact"]["critical_spring"] is None
    assert found["exact"]["static_to_kinetic"] == pytest.approx(2.0)
    contacts, line = toolkit.load_scene("narrow.toml").contacts, found["narrow"]
    propensity, steady = master.propensity(contacts), master.steady_state(contacts)
    for name in ("critical_spring", "static_to_kinetic", "onset_power"):
        assert line[name] == getattr(propensity, name) == found["soft"][name]
        assert line[f"{name}_error"] == getattr(propensity, f"{name}_error")
    assert line["kinetic_force"] == pytest.approx(steady.force / 2.0, rel=1e-13)
    evidence = line["evidence"]
    assert evidence["contacts"] == 800 and 0.0 <= evidence["worst_deviation"] < 5.0
    off = evidence["static_to_kinetic"] - evidence["expected"]
    assert abs(off) < 5.0 * evidence["static_to_kinetic_error"]


def test_compare_says_where_the_order_is_not_decided(capsys: Any) -> None:
    """K* of two laws of one surface go over the same readings. Run times have one line at the end."""
    material = ROUGH["material"] | {"shear_strength": 5e7}
    tables: dict[str, Any] = {"verdict": {"readings": ["gw/amontons", "gw/strength"]}}
    tables |= {"drive": {"area": 1e-6}, "master": None}
    surfaces = [
        write(law, thresholds=ROUGH | {"law": law, "material": material}, **tables)
        for law in ("amontons", "strength")
    ]
    _, lines, _ = said(capsys, "compare", *surfaces)
    assert lines[0].startswith("order undecided between strength and amontons: over readings and ")
    found = read("compare-output/compare.json")["scenes"]
    ends = sorted(one["critical_spring_newtons"] for one in found)
    low, high = (guarded(end, "N/m", ends[1] - ends[0]) for end in ends)
    assert lines[0].endswith(f"K* is {low} to {high} for each")
    assert lines[-2].startswith("run times: strength ") and " s, amontons " in lines[-2]
    each = [float(one) for one in re.findall(r"([\d.e+]+) s", lines[-2])]
    assert "; the whole command " in lines[-2] and each[-1] >= sum(each[:-1]) * (1.0 - 0.05)
    assert not any("time" in line for line in lines[:-2])


@pytest.mark.slow  # quick: the test before, and errors of K* of samples in test_pictures.py
def test_compare_counts_the_scatter_of_samples_where_the_order_is_not_decided(capsys: Any) -> None:
    """K* of samples scatters, and that of a wide Gaussian is far below."""
    one = np.random.default_rng(1).normal(1.0, 0.2, 40).tolist()
    laws = {"kind": "from-samples", "x_s": one}, {"kind": "gaussian", "mean": 1.0, "std": 0.2}
    drawn = [write(f"drawn{n}", thresholds=law, drive={"to": 4.0}) for n, law in enumerate(laws)]
    wide = write(
        "wide", thresholds={"kind": "gaussian", "mean": 1.0, "std": 0.8}, drive={"to": 4.0}
    )
    _, lines, _ = said(capsys, "compare", *drawn, wide)
    assert lines[0].startswith("order undecided between drawn") and "wide" not in lines[0]
    assert not any(line.startswith("order undecided") for line in lines[1:])
    assert "; " in lines[0] and " for drawn0" in lines[0]
    # the scatter of F_k = <x²>/2<x>, of which <x> is nearly 1, known to a sixth, and the bias of the smoothing
    (drawn0,) = (
        one for one in read("compare-output/compare.json")["scenes"] if one["name"] == "drawn0"
    )
    kinetic = drawn0["kinetic_force"]
    expected = np.std(np.square(one) / 2.0 - kinetic * np.array(one)) / 40**0.5
    assert 0.75 * expected < drawn0["kinetic_force_error"] < 1.5 * expected


def test_scenes_lists_every_shipped_scene(capsys: Any) -> None:
    status, out, _ = said(capsys, "scenes")
    told = "\n" + "\n".join(out)
    assert status == 0
    assert all(f"\n{name} " in told for name in shipped_scenes())
    assert max(map(len, out)) <= 100


# -- one line, or a traceback where it is ours ---------------------------------------------------------


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ([], "mesofriction: the following arguments are required: COMMAND; mesofriction --help"),
        (["run", "gaussian", "--speed", "3"], "mesofriction: --speed 3: not known here"),
        (["run", "gaussian", "--set", "drive.to=2.0", "--foo"], "mesofriction: --foo: not known"),
    ],
)
def test_wrong_words_are_status_2(words: list[str], says: str, capsys: Any) -> None:
    status, _, err = said(capsys, *words)
    assert status == 2 and err[0].startswith(says)


def test_what_is_refused_before_the_work_is_one_line_without_notes(
    tmp_path: Path, capsys: Any
) -> None:
    """A mass that oscillates too often; beside it the drive goes so little that its unit is asked for."""
    law, drive = 'kind = "gaussian"\nmean = 1.0\nstd = 0.2', "spring = 1e-9\nmass = 1e-18\nto = 5.0"
    drive += "\nvelocity = 1e-9"
    (tmp_path / "light.toml").write_text(
        f"[contacts.thresholds]\n{law}\n[drive]\n{drive}\n[eq]\ncontacts = 100\n"
    )
    words = ["run", str(tmp_path / "light.toml"), "--out", str(tmp_path / "out")]
    assert refused(capsys, *words).startswith("eq: mass = 1e-18: oscillates")


def test_an_unknown_command_names_the_one_that_is_meant(capsys: Any) -> None:
    for word, meant in (("verdct", "did you mean verdict? "), ("fly", "")):
        line = refused(capsys, word, "mine.toml")
        command = f"{word}: unknown command; {meant}mesofriction --help lists the commands"
        assert line == command


@pytest.mark.parametrize(
    ("words", "line"),
    [
        (["run"], "the following arguments are required: SCENE; mesofriction run --help says more"),
        (
            ["run", "gaussian", "--out", ""],
            "--out = '': names no folder; name one, or leave it out",
        ),
        (["thresholds", "samples", "--out", os.devnull], "is a file, not a folder; choose another"),
    ],
)
def test_a_missing_scene_or_folder_is_told_in_one_line(
    words: list[str], line: str, capsys: Any
) -> None:
    """That a folder cannot be written before the work, which has lines of progress."""
    status, out, err = said(capsys, *words)
    assert status == 2 and not out and len(err) == 1
    assert err[0].startswith("mesofriction: ") and err[0].endswith(line)


def test_compare_takes_machines_without_a_path(capsys: Any) -> None:
    """K* and F_s/F_k are those of the scene with a path; the force is drawn of a rigid slider."""
    machine = write("machine", drive={"spring": 0.5}, master=None)
    status, lines, _ = said(capsys, "compare", machine, write("plain", drive={"to": 4.0}))
    found = {one["name"]: one for one in read("compare-output/compare.json")["scenes"]}
    assert status == 0
    assert found["machine"]["critical_spring"] == found["plain"]["critical_spring"]
    assert any("machine: F(X) is that of a rigid slider" in line for line in lines)


@pytest.mark.parametrize("command", ["run", "thresholds", "compare"])
def test_bad_input_is_one_line_and_leaves_nothing(command: str, capsys: Any) -> None:
    assert "colour: unknown key" in refused(capsys, command, write(colour=1))
    line = refused(capsys, command, write(), "--out", "mine.toml/below")
    assert "out = 'mine.toml/below': " in line
    assert os.listdir() == ["mine.toml"]


def test_a_scene_without_a_solver_or_a_path_is_one_line_and_leaves_nothing(capsys: Any) -> None:
    assert "has neither [master] nor [eq]" in refused(capsys, "run", write(master=None))
    # of a machine: five loadings of a spring of 0.5 N_c<k> by contacts of mean threshold 1
    said = refused(capsys, "cost", write(master=None, drive={"spring": 0.5}))
    assert "--set drive.to=15 --set 'master={}'" in said
    assert os.listdir() == ["mine.toml"]


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ("precision --cases 5", "--coverage --cases 5"),
        ("precision mine.toml --seed 0", "--coverage --seed 0"),
        ("precision --coverage --cases 0", "a number of cases above 0"),
        ("precision --coverage --seed -1", "from 0 on"),
        ("precision mine.toml --coverage", "leave the scene and --set out"),
        ("run mine.toml --dry-run --checkpoint -5", "checkpoint = -5.0: must be above zero"),
    ],
)
def test_an_option_that_says_nothing_here_is_one_line(words: str, says: str, capsys: Any) -> None:
    write()
    assert says in refused(capsys, *words.split())
    assert os.listdir() == ["mine.toml"]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("a = " + "[" * 5000 + "]" * 5000, "nested too deeply"),
        ("a = " + "1" * 5000, "is not TOML: "),
        ('title = "a\x00b"', "is not TOML: "),
        ('title = "a\\u0000b"', "title"),
    ],
)
def test_odd_scenes_are_one_line(text: str, says: str, capsys: Any) -> None:
    Path("odd.toml").write_text(f"{text}\n{Path(write()).read_text()}")
    assert says in refused(capsys, "run", "odd.toml")


def test_odd_names_and_files_are_one_line(capsys: Any) -> None:
    for name in ("a" * 300, "a\x00b"):
        refused(capsys, "run", name)
        refused(capsys, "run", write(), "--out", name)
    os.mkfifo("pipe")
    for file in ("a\x00b", "/dev/zero", "pipe", "gone.txt"):
        scan = {"kind": "scan", "file": file}
        for law in ({"kind": "from-samples", "file": file}, ROUGH | {"surface": scan}):
            assert "file = " in refused(capsys, "run", write(thresholds=law))
    # what is no table is not shown
    Path("words.txt").write_text("user:secret:word\nother:secret:word\n")
    line = refused(capsys, "run", write(thresholds={"kind": "from-samples", "file": "words.txt"}))
    assert "secret" not in line and "line 2: x_s must be a number > 0" in line


@pytest.mark.parametrize(
    ("number", "status", "word"),
    [(signal.SIGINT, 130, "interrupted"), (signal.SIGTERM, 143, "terminated")],
)
def test_a_signal_while_it_imports_is_one_line(
    number: int, status: int, word: str, monkeypatch: Any, capsys: Any
) -> None:
    before = signal.getsignal(number)
    monkeypatch.setattr("importlib.import_module", lambda *_: signal.raise_signal(number))
    assert said(capsys, "scenes") == (status, [], [f"mesofriction: {word}; nothing was written"])
    assert signal.getsignal(number) is before


@pytest.mark.parametrize("words", [["run"], *(slow([word]) for word in ("--help", "scenes"))])
def test_a_closed_pipe_ends_it_without_a_word(python: Any, words: list[str]) -> None:
    shut = "import os; there, here = os.pipe(); os.close(there); os.dup2(here, 1)"
    run = f"{shut}; from toolkit.command import main; exit(main())"
    asked = [*words, write()] if words == ["run"] else words
    done = python(run, *asked, PYTHONUNBUFFERED="")
    assert (done.returncode, done.stderr) == (141, "")
    assert words != ["run"] or toolkit.load("mine-output").success


def test_bug_shows_its_traceback_and_the_module_is_the_command(
    capsys: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(master, "solve", lambda *_, **__: 1 / 0)
    monkeypatch.setattr("sys.argv", ["mesofriction", "run", "gaussian"])
    with pytest.raises(ZeroDivisionError):
        main()
    assert os.listdir() == []
    monkeypatch.setattr("sys.argv", ["mesofriction", "scenes"])
    with pytest.raises(SystemExit) as ended:
        runpy.run_module("mesofriction", run_name="__main__")
    assert not ended.value.code and "rough-gw-amontons" in capsys.readouterr().out


def test_in_newtons_the_order_may_be_the_other_way_round(capsys: Any) -> None:
    """Of N_c<k>, K* of narrow thresholds is larger; in N/m that of a hundred times as many wide ones is."""
    drive, files, bare = {"to": 1e-7, "points": 3, "area": 1e-6}, [], []
    for name, std, density in (("few-narrow", 4e-10, 1e11), ("many-wide", 1.2e-9, 1e13)):
        law = GAUSSIAN | {"mean": 4e-9, "std": std}
        contacts = {"thresholds": law}
        bare.append(write(f"bare-{name}", contacts=contacts, drive={"to": 1e-7, "points": 3}))
        contacts |= {"interface": {"mean_stiffness": 5.0, "contact_density": density}}
        files.append(write(name, contacts=contacts, drive=drive))
    _, lines, _ = said(capsys, "compare", *files, "--out", "both")
    assert "K* (N/m)" in lines[0]
    assert [line.split()[1] for line in lines[2:4]] == ["many-wide", "few-narrow"]
    _, lines, _ = said(capsys, "compare", *bare, "--out", "shared")
    assert [line.split()[1] for line in lines[2:4]] == ["bare-few-narrow", "bare-many-wide"]


def test_surfaces_with_areas_are_ranked_in_newtons(capsys: Any) -> None:
    """One surface on two areas: K* of N_c<k> is the same, and a thousand times as large in N/m on the larger one."""
    drive = {"to": 1e-7, "points": 3, "area": 1e-6}
    large = drive | {"area": 1e-3}
    files = [
        write("small", thresholds=ROUGH, drive=drive),
        write("large", thresholds=ROUGH, drive=large),
    ]
    status, lines, _ = said(capsys, "compare", *files, "--out", "both")
    assert status == 0 and "K* (N/m)" in lines[0] and lines[2].split()[1] == "large"
    found = {one["name"]: one for one in read("both/compare.json")["scenes"]}
    small, other = (found[name]["critical_spring_newtons"] for name in ("small", "large"))
    assert other == pytest.approx(1e3 * small, rel=1e-12)
    law = toolkit.load_scene(files[0]).contacts.interface
    newtons = law.friction_coefficient * law.pressure * 1e-6
    assert found["small"]["kinetic_force_newtons"] == pytest.approx(newtons, rel=1e-6)
    assert "F_k (N)" in lines[0]
    heads = {"kinetic_force_newtons [N]", "mean_threshold [m]"}
    with Path("both/compare.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert heads < set(rows[0])
    # a line for each reading, with its own numbers
    each = [(one["name"], read) for one in found.values() for read in one["readings"]]
    assert len(rows) == len(each) == 4
    for row, (name, numbers) in zip(rows, each, strict=True):
        assert (row["name"], row["reading"]) == (name, numbers["reading"])
        spring = float(row["critical_spring_newtons [N/m]"])
        assert spring == numbers["critical_spring_newtons"]
    each = 1e-6 * law.contact_density * law.mean_stiffness
    assert small == pytest.approx(each * found["small"]["critical_spring"], rel=1e-12)
    bare = write("bare", thresholds=ROUGH, drive={"to": 1e-7, "points": 3})
    lines = said(capsys, "compare", bare, files[0], "--out", "third")[1]
    # the same law twice: what leaves its order undecided is the first line, the table's head is after it
    assert lines[0].startswith("order undecided between bare and small") and "GN/m³" in lines[0]
    page = "\n".join(lines)
    assert "K* (N/m³)" in page and "F_k (Pa)" in page and "give each drive.area" in page
    own = {one["name"]: one for one in read("third/compare.json")["scenes"]}
    assert "critical_spring_newtons" not in own["bare"]
    assert own["bare"]["kinetic_stress"] == pytest.approx(1e6 * newtons, rel=1e-6)
    per_area = own["bare"]["critical_spring_per_area"]
    assert per_area == pytest.approx(1e6 * small, rel=1e-12)


def test_compare_lists_the_mixed_readings_that_it_leaves_out(capsys: Any) -> None:
    """Where few contacts are plastic they are not solved, and K* of them is in no range that is told."""
    material = ROUGH["material"] | {"hardness": 1e9, "shear_strength": 5e7}
    machine = {"spring": "4e6 N/m", "area": 1e-6, "velocity": 1.0}
    file = write("mine", thresholds=ROUGH | {"material": material}, drive=machine, master=None)
    _, lines, _ = said(capsys, "compare", file)
    left_out = read("compare-output/compare.json")["scenes"][0]["left_out"]
    assert {"gw/amontons/mixed", "gw/strength/mixed", "gw/paper/mixed"} <= {*left_out}
    (line,) = (one for one in lines if "left out: gw/amontons/mixed; " in one)
    assert "list them in verdict.readings" in line


def test_compare_shows_how_far_its_numbers_hang_on_the_readings(capsys: Any) -> None:
    """Readings that disagree on the machine's slips are the first sentence; numbers have the digits that they leave."""
    material = ROUGH["material"] | {"hardness": 1e8}
    mixed = ROUGH | {"material": material, "regime": "mixed"}
    file = write(
        "mine",
        thresholds=ROUGH | {"material": material},
        drive={"spring": "4e6 N/m", "area": 1e-6, "velocity": 1.0},
        master=None,
        verdict={"readings": ["gw/amontons/mixed", "gw/strength"]},
    )
    status, lines, _ = said(capsys, "compare", file)
    found = read("compare-output/compare.json")["scenes"][0]
    own, other = found["readings"]
    contacts = toolkit.load_scene(write("mixed", thresholds=mixed, drive={"to": 1e-7})).contacts
    assert other["critical_spring"] == master.propensity(contacts).critical_spring
    area = contacts.interface.contact_density * contacts.interface.mean_stiffness * 1e-6
    springs = [own["critical_spring_newtons"], other["critical_spring_newtons"]]
    assert springs[1] == pytest.approx(area * other["critical_spring"], rel=1e-12)
    assert springs[0] == found["critical_spring_newtons"] < 4e6 < springs[1]
    assert status == 0 and list(found["left_out"]) == ["gw/strength"]
    assert lines[0].startswith("mine: readings disagree on stick-slip: ") and "1 of 2" in lines[0]
    named = "the 2 readings, contact model/threshold law and step of the points, are "
    assert f"mine: {named}gw/amontons; gw/amontons/mixed" in lines
    at, wide = (re.split(" {2,}", line.strip()) for line in (lines[3], lines[4]))
    assert wide[0] == "over 2 readings" and not any("±" in cell for cell in at)
    for column, name in ((3, "critical_spring"), (8, "critical_spring_newtons")):
        assert float(at[column].replace(",", "")) == pytest.approx(own[name], rel=5e-3)
        ends = [float(end.replace(",", "")) for end in wide[column - 1].split(" to ")]
        assert ends == pytest.approx(sorted([own[name], other[name]]), rel=5e-3)
