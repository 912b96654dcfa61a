"""The table of extreme cases, and the map of a scene: no answer is wrong, and a wrong one would be found."""

import csv
import json
import re
import signal
import time
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import slow

import origins
from origins.contacts import Contacts
from origins.errors import NothingInTimeError
from toolkit.command import main
from toolkit.scene.laws import THRESHOLDS
from toolkit.scene.scene import load_scene
from toolkit.stability import laws, sliders, speeds, surfaces, thresholds
from toolkit.stability.case import Case, CaseAnswer, Question, Row, Truth, judged, rows
from toolkit.stability.pushes import not_pushed, numbers, searches, times
from toolkit.stability.scene_map import scene_map, trusted
from toolkit.stability.table import VERDICTS, extreme_cases, line, stability, summary
from toolkit.stability.work import within_work

QUICK = {"near-merged peaks", "heavy tails", "delay", "starts"}
CUT = {"just below the end of a rectangle"}  # after its 10 CPU-s


@pytest.mark.parametrize(
    ("answer", "verdict"),
    [
        (CaseAnswer([1.0, 2.0], 0.0), "exact"),
        (CaseAnswer([1.0, 2.0 + 1e-7], 2e-7, True, 1e-6), "within tolerance"),
        (CaseAnswer([1.0, 2.1], 0.2, False, 1e-6), "short, and says so"),
        (CaseAnswer([1.0], 1e-9, False, 1e-6), "short, and says so"),
        (CaseAnswer([1.0, np.nan], np.inf, False, 1e-6), "short, and says so"),
        (CaseAnswer([1.0, 7.0], 3.0, False, 1e-6), "wrong"),
        (CaseAnswer([1.0, 2.1], 0.05, False, 1e-6), "wrong"),
        (CaseAnswer([1.0, 2.1], 0.2, True, 1e-6), "wrong"),
        (CaseAnswer([1.0, np.nan], 1e-9, True, 1e-6), "wrong"),
        (CaseAnswer([1.0], 1e-9, True, 1e-6), "wrong"),
        (CaseAnswer([1.0, 2.0], 0.0, faults=("more than all contacts hold",)), "wrong"),
        (CaseAnswer([1.0], np.inf, False, 1e-6, "stopped by wall_time"), "slow"),
        (CaseAnswer([1.0, 2.1], 0.05, False, 1e-6, "stopped by wall_time"), "wrong"),
    ],
)
def test_the_judge_tells_what_is_wrong_from_what_is_short(answer: CaseAnswer, verdict: str) -> None:
    assert judged(answer, Truth([1.0, 2.0], 0.0, "by hand")).verdict == verdict


def test_a_row_that_was_cut_tells_where_and_what_it_claims() -> None:
    """Of the rest nothing is known, so that there is no number in its place."""

    def cut() -> CaseAnswer:
        return CaseAnswer(
            [1.0], 1e-9, False, 1e-6, "stopped at X = 1 by wall_time; error estimate 1e-9"
        )

    (row,) = rows(Question("", "", "master", cut, lambda: Truth([1.0, 2.0], 0.0, "by hand")))
    assert (
        row.verdict == "slow"
        and "X = 1 by wall_time; error estimate 1e-9; against by hand" in line(row)
    )
    (row,) = rows(
        Question(
            "", "", "master", lambda: CaseAnswer([1.0], 1e-9), lambda: Truth([1.0], 0.0, "by hand")
        )
    )
    assert line(row).endswith("by hand") and "against" not in line(row)


def test_an_answer_without_a_second_road_is_not_called_exact() -> None:
    found = judged(CaseAnswer([1.0, 2.0], 0.0), Truth([1.0, 2.0], np.inf, "invariants alone"))
    assert found.verdict == "within tolerance" and np.isnan(found.error)


def test_an_infinite_truth_is_met_by_infinity_alone() -> None:
    infinite = Truth(np.inf, 0.0, "K* where all contacts break at one place")
    assert judged(CaseAnswer(np.inf, 0.0), infinite).verdict == "exact"
    assert judged(CaseAnswer(7.0, 0.0), infinite).verdict == "wrong"
    (asked,) = (one for one in extreme_cases() if one.name == "K* of one exact value")
    (row,) = rows(asked)
    assert (row.verdict, row.error) == ("exact", 0.0)


def test_a_wrong_answer_is_found_by_the_other_solver() -> None:
    """Both solvers are asked of contacts beside which the exact answer is that of others."""

    def of_others(contacts: Contacts, path: np.ndarray) -> Truth:
        return Truth(path + 0.1, 1e-9, "of a start that is 0.1 farther")

    case = Case(
        "", "", partial(Contacts, origins.gaussian(1.0, 0.05)), np.array([0.2, 0.4]), of_others
    )
    found = rows(case)
    assert [row.solver for row in found] == ["master", "ensemble"]
    assert {row.verdict for row in found} == {"wrong"}
    assert all(row.error == pytest.approx(0.1) for row in found)


def test_the_time_of_an_answer_is_that_of_its_work() -> None:
    """Not of the clock, which on a busy machine is many times as much."""

    def ask() -> CaseAnswer:
        time.sleep(0.2)
        return CaseAnswer(1.0, 0.0)

    (row,) = rows(Question("", "asleep", "steady_state", ask, lambda: Truth(1.0, 0.0, "known")))
    assert row.verdict == "exact" and row.run_time < 0.1


@dataclass
class Solver:
    """Works for `share` of the time on a clock of its own, until it has done `needs` CPU-s or its wall time is over."""

    needs: float
    share: float
    clock: float = 0.0
    success: bool = False
    asked: list[float] = field(default_factory=list)

    def __call__(self, wall_time: float) -> "Solver":
        self.asked.append(wall_time)
        self.success = self.needs <= wall_time * self.share
        self.clock += self.needs / self.share if self.success else wall_time
        return self

    def monotonic(self) -> float:
        return self.clock

    def process_time(self) -> float:
        return self.share * self.clock


@pytest.mark.parametrize(
    ("solver", "asked", "success"),
    [
        (Solver(needs=8.0, share=1.0), [10.0], True),
        (Solver(needs=20.0, share=1.0), [10.0], False),
        (Solver(needs=8.0, share=0.25), [10.0, 40.0], True),
        (Solver(needs=20.0, share=0.25), [10.0, 40.0], False),
        (Solver(needs=8.0, share=0.01), [10.0, 100.0, 1000.0], True),
    ],
)
def test_a_busy_machine_answers_as_a_quiet_one(
    solver: Solver, asked: list[float], success: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What its wall time cuts for want of cores is asked again, what has had its CPU time is not."""
    monkeypatch.setattr("toolkit.stability.work.time", solver)
    assert within_work(solver, 10.0).success is success
    assert solver.asked == pytest.approx(asked)


def test_an_ensemble_of_which_no_slider_is_done_in_time_is_slow_and_not_refused(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked = list[float]()

    def over(*_: object, wall_time: float, **__: object) -> None:
        asked.append(wall_time)
        raise NothingInTimeError("wall_time = 10: no slider was followed")

    monkeypatch.setattr("eq_model.simulate", over)
    monkeypatch.setattr("toolkit.stability.work.time", Solver(needs=20.0, share=1.0, clock=10.0))
    contacts = Contacts(origins.identical(1.0))
    case = Case("", "", lambda: contacts, [0.5], drive={"spring": 1.0}, n_contacts=10)
    by_both = rows(case)
    assert [row.verdict for row in by_both if row.solver == "ensemble"] == ["slow"] and asked


@pytest.mark.usefixtures("unrendered")
def test_a_map_without_time_says_what_it_did_not_ask(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("toolkit.stability.scene_map.WORK", 0.0)
    assert main(["stability", "gaussian", "--out", str(tmp_path / "out")]) == 0
    found = json.loads((tmp_path / "out" / "stability.json").read_text())["rows"]
    pushed = [row for row in found if row["group"] != "as it is"]
    assert pushed and {row["verdict"] for row in pushed} == {"slow"}
    first = {"x 1e-1", "x 1e+1", "1e-06 ", "x 1e+0"}  # of a zero, and of a number of [eq]
    assert {row["case"][:6] for row in pushed} == first
    said = capsys.readouterr().out
    assert said.count("not asked: a map has") == len(pushed)
    assert "contacts.thresholds.mean: answered within the tolerance at 1 times" in said


def _checked(found: list[Row]) -> None:
    wrong = [row for row in found if row.verdict == "wrong"]
    assert not wrong, wrong
    assert {row.verdict for row in found} <= set(VERDICTS)
    for row in found:
        assert row.said if row.verdict == "refused" else row.road


def test_contacts_that_all_do_the_same_are_no_wrong_answer() -> None:
    """Their standard error is 0, and the ensemble's positions are whole units, far below the mean threshold."""
    path = np.linspace(0.0, 3.0, 31) * 0.999999 / 0.1  # in mean thresholds; over 30 breaks
    case = Case("identical", "0.1", lambda: Contacts(origins.identical(0.1)), path, n_contacts=10)
    assert {row.verdict for row in rows(case)} <= {"exact", "within tolerance"}


def test_quick_extreme_cases() -> None:
    cases = [one for one in extreme_cases() if one.group in QUICK and one.name not in CUT]
    assert len(cases) > 15
    found = stability(cases, lambda line: None)
    _checked(found)
    assert sum(row.verdict == "exact" for row in found) > 3
    assert sum(row.verdict == "refused" for row in found) < 0.4 * len(found)


def test_a_light_slider_that_is_heavily_damped_is_followed_at_once() -> None:
    """Its motion fades over 1e9 times the time in which it begins, which took for ever in steps of the latter."""
    (case,) = (one for one in sliders.masses() if one.name == "K = 1, M = 0.001, γ = 1000")
    (row,) = stability([replace(case, n_contacts=0)], lambda line: None)
    assert row.verdict == "exact" and row.road == "an oscillator, in closed form"


@pytest.mark.slow
def test_all_other_extreme_cases() -> None:
    found = stability(
        [one for one in extreme_cases() if one.group not in QUICK or one.name in CUT],
        lambda line: None,
    )
    _checked(found)
    assert "wrong" not in summary(found)


def test_every_case_has_a_name_of_its_own() -> None:
    names = [(case.group, case.name) for case in extreme_cases()]
    assert len(set(names)) == len(names)
    solvers = {case.solver for case in extreme_cases() if isinstance(case, Question)}
    assert {"master", "ensemble", "steady_state", "propensity"} <= solvers


def test_every_origin_has_a_case() -> None:
    """All kinds of thresholds that a scene may name, and barriers of islands."""
    asked = "".join(
        Path(str(room.__file__)).read_text(encoding="utf-8")
        for room in (laws, sliders, surfaces, thresholds)
    )
    functions = [place.partition(":")[2] for place in THRESHOLDS.values()]
    for name in [*functions, "triangular_barrier", "barrier", "relaxed_barrier"]:
        assert re.search(rf"origins\.{name}\b", asked), name


@pytest.mark.slow  # quick: extreme cases, above
def test_cases_of_rate_and_state_and_of_barriers() -> None:
    """Those that are answered at once, and a slope that is off by 1e-7 is wrong."""
    quick = [*surfaces.islands(), *speeds.rate_and_state()[1:]]
    found = stability(quick, lambda line: None)
    _checked(found)
    assert [row.verdict for row in found].count("refused") == 1
    slope = quick[-2]
    assert isinstance(slope, Question)
    off = replace(slope, ask=lambda: replace(slope.ask(), values=slope.ask().values + 1e-7))
    assert rows(off)[0].verdict == "wrong"


def test_numbers_of_a_scene() -> None:
    scene = {
        "contacts": {"thresholds": {"kind": "gaussian", "mean": 1.0, "seed": 3}, "start": 0.0},
        "drive": {"spring": "50 N/m", "to": 3.0, "points": 10, "turns": [1.0, 2.0], "damping": 0.0},
        "master": {},
        "eq": {"contacts": 100, "seed": 2, "histograms": [0.0]},
    }
    asked = {"contacts.thresholds.mean": 1.0, "contacts.start": 0.0, "drive.spring": "50 N/m"}
    asked |= {"drive.to": 3.0, "drive.turns": [1.0, 2.0], "drive.damping": 0.0}
    asked |= {"master.tolerance": 1e-8, "eq.contacts": 100, "eq.replicas": 16}
    assert dict(numbers(scene)) == asked
    assert dict(numbers(scene, coupled=True)) == {
        key: value for key, value in asked.items() if key != "eq.replicas"
    }
    kept = {line.split(": ")[1] for line in not_pushed(scene)}
    assert kept == {"contacts.thresholds.seed, eq.seed", "drive.points", "eq.histograms"}
    assert times("50 N/m", 1e-3) == "0.05 N/m"
    for file in ("10.02.2020 x.csv", "2.5 mm x.csv"):  # no number with a unit
        assert times(file, 10.0) == file
    assert times(0.2, 10.0) == 2.0
    assert times([1.0, [2, 5]], 10.0) == [10.0, [20, 50]]


def test_zeros_lists_and_numbers_of_the_ensemble_are_pushed() -> None:
    """A zero to parts of what such a number is measured in here; the contacts that a spring couples to no few."""
    scene = {
        "contacts": {
            "thresholds": {"kind": "gaussian", "mean": 4.0, "std": 0.5},
            "start": {"kind": "gaussian", "mean": 0.0, "std": 0.1},
        },
        "drive": {"to": 8.0, "spring": 4.0, "mass": 9.0, "velocity": 2.0},
        "master": {},
        "eq": {"contacts": 500},
    }
    pulled = load_scene(scene)

    def pushed(key: str, value: Any, scene: Any = pulled) -> list[list[tuple[str, Any]]]:
        return [[(one.name, one.value) for one in way] for way in searches(key, value, scene)]

    (way,) = pushed("contacts.start.mean", 0.0)
    assert way[0] == ("1e-06 <x_s>: 4e-06", pytest.approx(4e-6)) and len(way) == 6
    assert pushed("contacts.delay.time", 0)[0][-1] == ("1e-01 <x_s>/v: 0.2", pytest.approx(0.2))
    for none in (0.0, "0 N s/m"):
        assert pushed("drive.damping", none)[0][-1][1] == pytest.approx(0.6)
    down, up = pushed("drive.turns", [8.0, -8.0])
    assert down[0] == ("x 1e-1: [0.8, -0.8]", [0.8, -0.8]) and up[0][1] == [80.0, -80.0]
    down, up = pushed("eq.contacts", 500)
    assert not down and [value for _, value in up] == [5_000, 50_000, 500_000, 5_000_000]
    rigid = load_scene({**scene, "drive": {"to": 8.0}})
    down, up = pushed("eq.contacts", 500, rigid)
    assert [value for _, value in down] == [50, 5, 1] and up[0] == ("x 1e+0: 500", 500)


def test_an_ensemble_of_the_scenes_own_size_stands_beside_the_scene_as_it_is(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """What a map tells of the numbers of [eq]; a tolerance that no ensemble of this size has is told as missed."""
    monkeypatch.setattr("toolkit.stability.pushes.DECADES", 1)
    thresholds = {"kind": "rectangular", "lower": 0.5, "upper": 1.5}
    scene = {"contacts": {"thresholds": thresholds}, "drive": {"to": 1.2, "points": 5}}
    eq = {"contacts": 1000, "replicas": 2, "tolerance": 0.05}
    lines = list[str]()
    found = scene_map(load_scene({**scene, "master": {"tolerance": 1e-6}, "eq": eq}), lines.append)
    _checked(found)
    own = {(row.group, row.case.split(":")[0]): row for row in found if row.group[:2] == "eq"}
    assert {row.solver for row in own.values()} == {"ensemble"}
    assert own["eq.contacts", "x 1e-1"].claim > 2.0 * own["eq.contacts", "x 1e+0"].claim
    assert own["eq.tolerance", "x 1e-1"].verdict == "short, and says so"
    assert "eq.tolerance: answered within the tolerance at 1 to 10 times its value" in lines


def test_a_map_ends_where_a_number_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("toolkit.stability.pushes.DECADES", 2)
    file = tmp_path / "narrow.toml"
    file.write_text(
        '[contacts]\nthresholds = { kind = "rectangular", lower = 0.5, upper = 1.5 }\n'
        "[drive]\nto = 1.2\npoints = 5\n[master]\n"
    )
    assert main(["stability", str(file), "--out", str(tmp_path / "out")]) == 0
    said = capsys.readouterr().out
    # above 1.5 the rectangle's lower end is beyond its upper one
    assert ("contacts.thresholds.lower = 0.5" in said and "must lie" in said) or "refused" in said
    assert "contacts.thresholds.lower: answered within the tolerance at " in said
    found = json.loads((tmp_path / "out" / "stability.json").read_text())["rows"]
    pushed = [row["case"] for row in found if row["group"] == "contacts.thresholds.lower"]
    assert sum(case.startswith("x 1e+") for case in pushed) == 1
    with (tmp_path / "out" / "stability.csv").open() as stream:
        table = list(csv.DictReader(stream))
    assert len(table) == len(found)
    assert table[0]["verdict"] == found[0]["verdict"] and "run_time [s]" in table[0]
    assert (tmp_path / "out" / "stability.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("number", "status", "word"),
    [(signal.SIGINT, 130, "interrupted"), (signal.SIGTERM, 143, "terminated")],
)
@pytest.mark.parametrize("scene", [["gaussian"], slow([])])
def test_an_interrupted_table_holds_what_is_known(
    scene: list[str],
    number: int,
    status: int,
    word: str,
    tmp_path: Path,
    monkeypatch: Any,
    capsys: Any,
) -> None:
    """A signal comes with the third case: the answers to two are written, and said to be no more."""
    cases, asked = extreme_cases()[:3], iter([rows, rows])

    def until_the_signal(case: Case | Question) -> list[Row]:
        ask = next(asked, None)
        if ask is None:
            signal.raise_signal(number)
        return ask(case)

    monkeypatch.setattr("toolkit.stability.table.rows", until_the_signal)
    monkeypatch.setattr("toolkit.stability.report.extreme_cases", lambda: cases)
    folder = tmp_path / "out"
    assert main(["stability", *scene, "--out", str(folder)]) == status
    found = json.loads((folder / "stability.json").read_text())
    known = len(found["rows"])
    assert found["interrupted"] and len({(row["group"], row["case"]) for row in found["rows"]}) == 2
    last = capsys.readouterr().err.splitlines()[-1]
    assert last == f"mesofriction: {word}; the {known} answers so far are written to {folder}"
    text = (folder / "stability.txt").read_text().splitlines()
    assert text[-1].startswith(f"interrupted after {known} answers: ")
    assert (folder / "stability.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.usefixtures("unrendered")
def test_a_number_takes_no_more_than_its_share_of_the_wall_time(
    tmp_path: Path, monkeypatch: Any
) -> None:
    """The first number has no answer in any time: the others are asked all the same."""

    def endless(case: Case | Question) -> list[Row]:
        while case.group == "contacts.thresholds.mean":
            pass
        quick = Row(case.group, case.name, "master", "exact", 0.0, 0.0, 0.0, 0.0, "", "")
        return [quick]

    monkeypatch.setattr("toolkit.stability.table.rows", endless)
    monkeypatch.setattr("toolkit.stability.pushes.DECADES", 1)
    folder = tmp_path / "out"
    assert main(["stability", "gaussian", "--set", "wall_time=3", "--out", str(folder)]) == 0
    found = json.loads((folder / "stability.json").read_text())
    told = {(row["group"], row["case"][:6]): row for row in found["rows"]}
    assert "stopped_by_wall_time" not in found
    for case in ("x 1e-1", "x 1e+1"):
        own = told["contacts.thresholds.mean", case]
        assert own["verdict"] == "slow" and "share of wall_time = 3 s" in own["said"]
        assert told["contacts.thresholds.std", case]["verdict"] == "exact"


@pytest.mark.parametrize("known", [2, 0])
@pytest.mark.usefixtures("unrendered")
def test_a_map_ends_with_the_wall_time_of_its_scene(
    known: int, tmp_path: Path, monkeypatch: Any, capsys: Any
) -> None:
    """It is over in the third case: what two have answered is written, and what is left is named; or in the first."""
    asked = iter([rows] * known)

    def until_it_is_over(case: Case | Question) -> list[Row]:
        ask = next(asked, None)
        if ask is None:
            signal.setitimer(signal.ITIMER_REAL, 1e-6)  # as if the time were over
            signal.pause()
            raise AssertionError("it was not heeded")
        return ask(case)

    monkeypatch.setattr("toolkit.stability.table.rows", until_it_is_over)
    folder = tmp_path / "out"
    status = main(["stability", "gaussian", "--set", "wall_time=1e6", "--out", str(folder)])
    if not known:
        said = "mesofriction: wall_time = 1000000.0: is over before the scene as it is is answered; give more"
        assert status == 2 and capsys.readouterr().err.splitlines()[-1] == said
        return
    assert status == 0 and json.loads((folder / "stability.json").read_text())["rows"]
    *_, told, last = (folder / "stability.txt").read_text().splitlines()
    assert told.startswith("wall_time is over: not asked: what follows on x 1e-1: ")
    assert "contacts.thresholds.mean; " in told and "contacts.thresholds.std" in told
    assert "within tolerance" in last


def test_few_contacts_that_slip_where_infinitely_many_slide_are_no_second_road(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Above K* = 0.035, where 5,000 contacts still slip, but for N K³ > 50 they are asked."""
    monkeypatch.setattr("toolkit.stability.pushes.DECADES", 0)
    file = tmp_path / "wide.toml"
    for spring, solvers in ((0.05, ["master"]), (0.5, ["master", "ensemble"])):
        file.write_text(
            '[contacts]\nthresholds = { kind = "gw-plastic", B = 1.0 }\n'
            f"[drive]\nto = 30.0\npoints = 31\nspring = {spring}\n[master]\ntolerance = 1e-4\n"
        )
        found = scene_map(load_scene(str(file)), lambda line: None)
        assert [row.solver for row in found] == solvers
        assert {row.verdict for row in found} <= {"exact", "within tolerance"}


def test_a_timed_drive_is_cut_with_its_times_before_the_first_slip(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The drive of stick-slip-ends: a slider with mass that slips at X_T = 52."""
    monkeypatch.setattr("toolkit.stability.pushes.DECADES", 0)
    file = tmp_path / "timed.toml"
    file.write_text(
        '[contacts]\nthresholds = { kind = "gaussian", mean = 1.0, std = 0.2 }\n'
        "[drive]\nturns = [40.0, 80.0]\ntimes = [10.0, 20.0]\npoints = 21\n"
        "spring = 0.02\nmass = 0.05066\n[master]\n"
    )
    found = scene_map(load_scene(str(file)), lambda line: None)
    assert [row.solver for row in found] == ["master", "ensemble"]
    assert {row.verdict for row in found} <= {"exact", "within tolerance"}


def test_a_first_slip_before_the_second_point_of_the_path_is_compared_up_to_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With points 8 <x_s> apart and a slip at 1.8 the start alone was compared, as 0 = 0, and called exact."""
    monkeypatch.setattr("toolkit.stability.pushes.DECADES", 0)
    thresholds = '[contacts]\nthresholds = { kind = "gaussian", mean = 1.0, std = 0.2 }\n'
    file = tmp_path / "far.toml"
    file.write_text(f"{thresholds}[drive]\nto = 180.0\nspring = 0.8\n[master]\ntolerance = 1e-8\n")
    found = scene_map(load_scene(str(file)), lambda line: None)
    _checked(found)
    assert all(row.verdict == "within tolerance" for row in found)
    assert all(0.0 < row.error < 0.1 for row in found)


def test_a_scene_that_is_not_answered_is_not_said_to_be_trusted() -> None:
    numbers_of_rows = (np.nan, np.nan, np.nan, 0.0, "")
    found = [
        Row("as it is", "x 1", "master", "refused", *numbers_of_rows, "a reason"),
        Row("drive.mass", "x 1e+1: 2", "master", "within tolerance", *numbers_of_rows, ""),
    ]
    assert list(trusted(found)) == ["not answered within the tolerance as it is: a reason"]


def test_what_was_not_answered_in_its_time_is_told_as_such() -> None:
    numbers_of_rows = (np.nan, np.nan, np.nan, 0.0, "")
    answered = ["x 1", "x 1e+1: 2"]
    found = [Row("as it is", "x 1", "master", "exact", *numbers_of_rows, "")]
    found += [Row("drive.mass", x, "master", "exact", *numbers_of_rows, "") for x in answered]
    found += [Row("drive.mass", "x 1e+2: 20", "master", "slow", *numbers_of_rows, "cut")]
    said = "drive.mass: answered within the tolerance at 1 to 10 times its value"
    assert list(trusted(found)) == [f"{said}; not answered in its time at 1e+2"]


def test_what_is_no_scene_with_a_path_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["stability", "--set", "drive.to=2.0"]) == 2
    assert "name one" in capsys.readouterr().err
    assert main(["stability", "kinetic-force"]) == 2
    assert "drive" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize("name", ["gaussian", "delay", "stick-slip"])
def test_nothing_is_wrong_around_shipped_scenes(name: str) -> None:
    _checked(scene_map(load_scene(name), lambda line: None))
