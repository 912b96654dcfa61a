"""Sweeps over any key of a scene: each point is the scene with that value, however points are spread or interrupted."""

import csv
import json
import subprocess
import sys
import time
from contextlib import suppress
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from matplotlib.figure import Figure
from scenes import ROUGH, refused, said, scene, write

import master
import toolkit
from toolkit.pictures.points import plot_points, plot_points_swing
from toolkit.results.points import without_unit, write_sweep
from toolkit.results.report import report
from toolkit.running import pool
from toolkit.running.points import earlier_points

WIDE = {"kind": "gaussian", "mean": 1.0, "std": 0.2}
DRIVE = {"to": 6.0, "points": 61}
SPRINGS = {"drive.spring": [0.3, 0.6]}
OVER: dict[str, Any] = {"drive.spring": [0.3, 0.6], "contacts.thresholds.std": [0.1, 0.2, 0.3]}

pytestmark = pytest.mark.usefixtures("in_a_folder", "unrendered")


def swept(**more: Any) -> dict[str, Any]:
    return scene(WIDE, drive=DRIVE, master={"tolerance": 1e-4}, sweep=OVER | more)


def columns(record: Any) -> str:
    """All columns with all digits, as text, in which nan equals nan."""
    return json.dumps([column.tolist() for column in record.columns.values()])


@cache
def alone() -> str:
    """Those of the sweep in one process."""
    return columns(toolkit.run(swept()).sweep)


def test_a_point_is_the_scene_with_its_values(capsys: Any) -> None:
    tables = swept(critical_spring=True)
    status, out, _ = said(capsys, "run", write(**{"thresholds": WIDE, **tables}))
    found = toolkit.load("mine-output").sweep
    assert status == 0 and any(
        line.startswith("sweep   6 points along drive.spring") for line in out
    )
    assert found.along == tuple(OVER) and len(found) == 6 and found.success
    for k, (spring, std) in enumerate(
        (spring, std) for spring in OVER["drive.spring"] for std in OVER["contacts.thresholds.std"]
    ):
        alone = toolkit.run(
            scene(WIDE | {"std": std}, drive=DRIVE | {"spring": spring}, master={"tolerance": 1e-4})
        )
        own = master.propensity(toolkit.load_scene(scene(WIDE | {"std": std})).contacts)
        assert (found["drive.spring"][k], found["contacts.thresholds.std"][k]) == (spring, std)
        assert found["last_force"][k] == alone.master.force[-1]
        assert found["regime"][k] == alone.master.regime.verdict
        assert found["slips"][k] == alone.master.slips.drive.size
        assert found["critical_spring"][k] == own.critical_spring
    with Path("mine-output/sweep.csv").open(encoding="utf-8") as stream:
        head, *rows = list(csv.reader(stream))
    keys = ["drive.spring", "contacts.thresholds.std [length]"]
    assert head[:3] == [*keys, "mean_threshold [length]"] and "critical_spring [N_c<k>]" in head
    assert [float(row[head.index("last_force [N_c<k>·length]")]) for row in rows] == found[
        "last_force"
    ].tolist()
    assert head[-1] == "message" and {row[-1] for row in rows} == {"as asked"}
    regimes = found["regime"].tolist()
    (line,) = [line for line in out if line.startswith("regime")]
    assert all(f"{one} at {regimes.count(one)}" in line for one in regimes)
    assert any('drive.slip = "reset", and other rules may have others' in line for line in out)
    told = json.loads(Path("mine-output/summary.json").read_text())["sweep"]
    assert told["points"] == 6 and told["along"] == list(OVER)
    # a force in the unit of lengths is one over N_c<k>, which the file says
    with h5py.File("mine-output/result.h5") as store:
        said_to_be = {
            own.attrs["name"]: own.attrs.get("quantity") for own in store["sweep"].values()
        }
    assert said_to_be["last_force"] == said_to_be["kinetic_force_error"] == "F/(N_c<k>)"
    assert said_to_be["period"] is None and said_to_be["critical_spring"] is None


def test_springs_of_several_units_are_one_axis() -> None:
    """50 N/m beside 5 kN/m counted from 1 to 2, with the texts for a unit."""
    for texts, told, unit in (
        (["50 N/m", "5 kN/m", "2 N/µm"], [50.0, 5e3, 2e6], "N/m"),
        (["100 g", "0.2 kg"], [0.1, 0.2], "kg"),
        (["0.5 N_c<k>", "1e-3 N_c<k>"], [0.5, 1e-3], "N_c<k>"),
        (["50 N/m", "0.5 N_c<k>"], ["50 N/m", "0.5 N_c<k>"], ""),
    ):
        values, found = without_unit(np.array(texts))
        assert found == unit and values.tolist() == told


def test_si_units_of_a_surface_and_the_ensemble() -> None:
    """F_k/load does not depend on the area; forces in newtons are proportional to it."""
    drive = {"spring": "1 N/m", "area": 1e-6, "to": 1e-8, "points": 5}
    sweep = {
        "drive.area": [1e-6, 2e-6],
        "drive.spring": {"from": 1e5, "to": 1e6, "points": 2, "unit": "N/m"},
    }
    eq = {"contacts": 200, "replicas": 2}
    found: Any = toolkit.run(scene(ROUGH, drive=drive, master=None, eq=eq, sweep=sweep)).sweep
    assert list(found["drive.spring"]) == ["100000.0 N/m", "1000000.0 N/m"] * 2
    newtons = found["kinetic_force_newtons"]
    np.testing.assert_allclose(newtons[2:], 2.0 * newtons[:2], rtol=1e-14)
    np.testing.assert_allclose(
        found["kinetic_force_over_load"] * found["drive.area"] * 1e6, newtons
    )
    asked = {"contacts": {"thresholds": ROUGH}, "drive": drive | {"spring": "1 N/m"}}
    springs = sweep | {"critical_spring": True}
    result = toolkit.run(asked | {"sweep": springs}, folder="out")
    own: Any = result.sweep
    with Path("out/sweep.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    for head, name in (
        ("kinetic_force [N]", "kinetic_force_newtons"),
        ("critical_spring [N/m]", "critical_spring_newtons"),
    ):
        assert [float(row[head]) for row in rows] == pytest.approx(list(own[name]), rel=1e-14)
        assert not any(name in head for head in rows[0])
        assert [row["drive.spring [N/m]"] for row in rows] == ["100000.0", "1000000.0"] * 2
        html = result._repr_html_()
        assert f"<th>{head}</th>" in html and f"<td>{own[name][-1]:.4g}</td>" in html
    assert found.units["kinetic_force_newtons"] == "N" and (found["eq_last_force"] > 0.0).all()


def test_the_number_of_contacts_decides_of_a_sweep_too() -> None:
    """Smooth sliding of infinitely many contacts is told as that where the area holds too few, and sliders of few
    contacts that slip beside it make the point one that is not as asked."""
    drive = {"spring": "1 N/m", "area": 1e-9, "to": 4e-7, "points": 41}
    springs = {"drive.spring": {"from": 3e3, "to": 1e7, "points": 2, "unit": "N/m"}}
    eq = {"contacts": 2000, "replicas": 2, "seed": 1}
    alone: Any = toolkit.run(scene(ROUGH, drive=drive, sweep=springs)).sweep
    both: Any = toolkit.run(scene(ROUGH, drive=drive, eq=eq, sweep=springs)).sweep
    told = ["smooth for infinitely many contacts only", "smooth"]
    assert alone["regime"].tolist() == both["regime"].tolist() == told and alone.success
    assert both["eq_slips_a_slider"][0] > 0.0 == both["eq_slips_a_slider"][1]
    assert not both.success and both["message"][1] == ""
    assert both["message"][0].startswith('disagree: infinitely many contacts are "smooth"')
    assert "the area holds" in alone["regime_reason"][0]
    soft = {"drive.spring": {"from": 1.0, "to": 1e7, "points": 2, "unit": "N/m"}}
    brief: Any = toolkit.run(scene(ROUGH, drive=drive, sweep=soft)).sweep
    assert brief["regime"].tolist() == ["undecided", "smooth"]
    assert "; drive to X_T = " in brief["regime_reason"][0]


def test_a_point_that_is_refused_keeps_its_row(capsys: Any) -> None:
    file = write(thresholds=WIDE, drive=DRIVE, sweep={"contacts.thresholds.std": [0.1, -1.0]})
    status, _, err = said(capsys, "run", file)
    found = toolkit.load("mine-output").sweep
    assert (
        status == 1
        and "1 of 2 points are not as asked, the first at contacts.thresholds.std = -1.0" in err[-1]
    )
    assert np.isnan(found["last_force"]).tolist() == [False, True]
    assert "std = -1.0: must be" in found["message"][1] and found["message"][0] == ""


def test_finished_points_survive_an_interrupt(monkeypatch: Any, capsys: Any) -> None:
    whole, solve, count = alone(), pool.solve_point, []

    def counted(*job: Any) -> Any:
        count.append(job)
        if len(count) == 4:
            raise KeyboardInterrupt
        return solve(*job)

    monkeypatch.setattr(pool, "solve_point", counted)
    file = write(**{"thresholds": WIDE, **swept()})
    status, _, err = said(capsys, "run", file)
    assert status == 130 and err[-1].endswith(
        "its finished points are kept in mine-output/checkpoint, from which the same command goes on"
    )
    (kept,) = Path("mine-output/checkpoint").glob("*")
    kept.write_text(kept.read_text() + '["cut sho')
    assert said(capsys, "run", file)[0] == 0 and len(count) == 4 + 3
    assert columns(toolkit.load("mine-output").sweep) == whole
    assert not Path("mine-output/checkpoint").exists()


def test_a_run_that_is_interrupted_while_it_draws_names_its_checkpoint(
    monkeypatch: Any, capsys: Any
) -> None:
    def ends(*arguments: Any) -> None:
        raise KeyboardInterrupt

    file = write(eq={"contacts": 1_000})
    with monkeypatch.context() as patched:
        patched.setattr("toolkit.running.runner.save", ends)
        status, _, err = said(capsys, "run", file)
    assert status == 130
    assert err[-1].endswith("interrupted; its finished blocks are kept in mine-output/checkpoint")
    assert said(capsys, "run", file)[0] == 0 and not Path("mine-output/checkpoint").exists()


@pytest.mark.slow  # quick: ranks do, below
def test_processes_give_the_same_numbers(monkeypatch: Any) -> None:
    here = alone()
    monkeypatch.setattr(pool, "WORTH", 0.0)
    monkeypatch.setattr(pool, "cores_of", lambda comm: 2)
    assert columns(toolkit.run(swept()).sweep) == here


@pytest.mark.slow
def test_a_kill_ends_the_processes_and_keeps_their_points(monkeypatch: Any, capsys: Any) -> None:
    """A sweep on two processes is killed, which cleans up nothing: both end with it, the points that they finished are
    kept, and the next run solves the others alone, to the same bits."""
    eq = {"contacts": 10_000, "replicas": 16, "threads": 1}
    springs = {"drive.spring": {"from": 0.1, "to": 2.0, "points": 24}}
    file = write(thresholds=WIDE, drive=DRIVE, eq=eq, master=None, sweep=springs)
    whole, rows = columns(toolkit.run(file).sweep), Path("mine-output/checkpoint")
    command: dict[str, Any] = {"args": [sys.executable, "-c", BY_TWO, file], "text": True}
    with (
        Path("errors").open("w") as errors,
        subprocess.Popen(**command, stdout=subprocess.PIPE, stderr=errors) as run,
    ):
        assert run.stdout is not None
        workers = [int(run.stdout.readline()) for _ in range(2)]
        while run.poll() is None and kept(rows) < 3:
            time.sleep(0.01)
        run.kill()
    assert 3 <= (before := kept(rows)) < 24
    ends = time.monotonic() + 60.0  # s, far longer than a point
    while any(lives(worker) for worker in workers) and time.monotonic() < ends:
        time.sleep(0.05)
    assert not any(lives(worker) for worker in workers)
    assert "Traceback" not in Path("errors").read_text()
    solve, count = pool.solve_point, []
    monkeypatch.setattr(pool, "WORTH", np.inf)
    monkeypatch.setattr(pool, "solve_point", lambda *job: count.append(1) or solve(*job))
    assert said(capsys, "run", file)[0] == 0 and len(count) == 24 - before
    assert columns(toolkit.load("mine-output").sweep) == whole and not rows.exists()


def kept(folder: Path) -> int:
    """How many points are kept in a folder."""
    return len(earlier_points(folder))


def lives(process: int) -> bool:
    """Whether a process is there; one that has ended and nobody waited for is not."""
    with suppress(FileNotFoundError):
        return Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    return False


# the command with any work worth two processes, whose numbers it tells
BY_TWO = """
import subprocess, sys
from toolkit.command import main
from toolkit.pictures.points import plot_points, plot_points_swing
from toolkit.results.report import report
from toolkit.running import pool
class Told(subprocess.Popen):
    def __init__(self, *given, **named):
        super().__init__(*given, **named)
        print(self.pid, flush=True)
pool.WORTH, pool.cores_of, subprocess.Popen = 0.0, lambda comm: 2, Told
main(["run", sys.argv[1]])
"""


def test_ranks_share_the_points_and_find_the_same(mpirun: Any) -> None:
    write(**{"thresholds": WIDE, **swept()})
    (Path("small.toml")).write_text(Path("mine.toml").read_text())
    done = mpirun(2, RANKS)
    assert done.returncode == 0, done.stderr
    told = [json.loads(line) for line in done.stdout.splitlines()]
    solved = [own[0] for own in told]
    assert len(solved) == 2 and sum(solved) == 6 and min(solved) > 0
    assert all(json.dumps(own[1]) == alone() for own in told)


RANKS = """
import json, time, toolkit
from pathlib import Path
from mpi4py import MPI
from toolkit.pictures.points import plot_points, plot_points_swing
from toolkit.results.report import report
from toolkit.running import pool
solve, count, begun = pool.solve_point, [], Path("begun")
def counted(*job):
    count.append(1)
    if MPI.COMM_WORLD.Get_rank():
        begun.touch()
    while not begun.exists():  # rank 0 leaves a point for the other
        time.sleep(0.01)
    return solve(*job)
pool.solve_point, pool.cores_of = counted, lambda comm: 1
found = toolkit.run("mine.toml", comm=MPI.COMM_WORLD).sweep
told = json.dumps([len(count), [column.tolist() for column in found.columns.values()]])
for own in MPI.COMM_WORLD.gather(told) or []:
    print(own)
"""


@pytest.mark.slow
def test_what_ends_one_rank_ends_all_and_keeps_their_points(mpirun: Any) -> None:
    """Rank 1 is interrupted in its third point: one line, and what both have solved by then is kept."""
    write(**{"thresholds": WIDE, **swept()})
    done = mpirun(2, ENDED)
    assert done.returncode != 0
    (told,) = [line for line in done.stderr.splitlines() if line.startswith("mesofriction: ")]
    assert "interrupted; its finished points are kept in mine-output/checkpoint" in told
    assert "Traceback" not in done.stderr and "Abort" not in done.stderr
    assert 2 <= kept(Path("mine-output/checkpoint")) < 6


ENDED = """
import sys, time
from pathlib import Path
from mpi4py import MPI
from toolkit.command import main
from toolkit.running import pool
solve, count, third = pool.solve_point, [], Path("third")
def ended(*job):
    count.append(1)
    if MPI.COMM_WORLD.Get_rank() and len(count) == 3:
        third.touch()
        raise KeyboardInterrupt
    while not MPI.COMM_WORLD.Get_rank() and not third.exists():
        time.sleep(0.01)
    return solve(*job)
pool.solve_point, pool.cores_of = ended, lambda comm: 1
sys.exit(main(["run", "mine.toml"]))
"""


@pytest.mark.parametrize(
    ("sweep", "told"),
    [
        ({"drive.sprin": [0.5]}, "drive.sprin: unknown key; did you mean spring?"),
        ({"drive.spring": []}, 'sweep."drive.spring" = []: must be a list'),
        ({"drive.spring": {"from": 0.0, "to": 1.0, "points": 3}}, 'write spacing = "even"'),
        ({"drive.spring": {"begin": 0.0}}, "must be a value, a list, or"),
        ({"drive.spring": {"from": 1.0, "to": 2.0, "points": 20_000}}, "take 10,000 at most"),
        ({"drive": {"spring": [1.0]}}, 'write a key of the scene in quotes, as "drive.spring"'),
        ({"velocity": {"from": 1.0, "to": 2.0, "points": 3, "unit": "m/s"}}, "sweep.velocity.unit"),
        ({"colour": 3}, "known here: velocity"),
    ],
)
def test_bad_sweeps_are_one_line(sweep: dict[str, Any], told: str, capsys: Any) -> None:
    assert told in refused(capsys, "run", write(thresholds=WIDE, drive=DRIVE, sweep=sweep))


def test_compare_takes_one_scene(capsys: Any) -> None:
    file = write(**{"thresholds": WIDE, **swept()})
    assert "sweep: compare takes one scene, not a sweep over" in refused(capsys, "compare", file)
    assert said(capsys, "thresholds", file)[0] == 0
    numbers = json.loads(Path("mine-output/thresholds.json").read_text())["numbers"]
    assert numbers["standard_deviation"]["value"] == pytest.approx(0.2, rel=1e-4)
    assert "6 points" in "".join(said(capsys, "run", file, "--dry-run")[1])


def test_a_sweep_over_keys_of_a_surface_is_reported(capsys: Any) -> None:
    over = {"contacts.thresholds.pressure": [1e5, 1e6]}
    file = write(thresholds=ROUGH, drive=None, master=None, sweep=over)
    status, out, _ = said(capsys, "run", file)
    assert status == 0 and any(line.startswith("sweep   2 points") for line in out)


def test_a_sweep_of_a_drive_without_a_path_is_written(tmp_path: Path) -> None:
    bare = {
        "contacts": {"thresholds": {"kind": "gaussian", "mean": 1.0, "std": 0.2}},
        "drive": {"velocity": 1.0},
        "sweep": {"contacts.thresholds.std": [0.1, 0.2], "critical_spring": True},
    }
    toolkit.save(toolkit.run(bare), tmp_path / "out")
    assert (tmp_path / "out" / "sweep.csv").read_text().count("\n") == 3
    assert toolkit.load(tmp_path / "out").time.size == 0


def test_a_sweep_over_a_machine_that_pulls_nothing_says_so(capsys: Any) -> None:
    """Springs of any unit were taken, and F_k of a rigid slider stood beside each."""
    tables: dict[str, Any] = {"master": None, "drive": {"area": 1e-6}}
    spring = {"sweep": {"drive.spring": ["10 N/m", "20 N/m"]}}
    _, out, _ = said(capsys, "run", write(thresholds=ROUGH, **tables, **spring))
    assert "note    drive.spring: no number hangs on it here" in "\n".join(out)
    bad = {"sweep": {"drive.spring": ["10 N/m", "20 N"]}}
    status, _, err = said(capsys, "run", write(thresholds=ROUGH, **tables, **bad))
    swept = toolkit.load("mine-output").sweep
    assert status == 1 and "20 N': unit N is not known" in swept["message"][1], err


def test_what_asks_for_a_spring_may_stand_beside_a_sweep_over_springs(capsys: Any) -> None:
    rules: tuple[dict[str, Any], ...] = ({"slip": "reform-after"}, {"mass": 1e-2, "damping": 1e-2})
    for number, rule in enumerate(rules):
        drive = DRIVE | {"to": 2.0, "points": 5} | rule
        file = write(
            f"own-{number}", contacts={"thresholds": WIDE}, drive=drive, master={}, sweep=SPRINGS
        )
        assert said(capsys, "run", file)[0] == 0
        assert len(Path(f"own-{number}-output/sweep.csv").read_text().splitlines()) == 3


def test_a_spring_that_never_slipped_has_no_swing_and_a_contradiction_no_regime() -> None:
    """F still rises on it at the path's end. Marks at 0, after a slip, have room; a master equation that its ensemble
    contradicts tells no regime."""
    drive = {"to": 20.0, "points": 201}
    tables = scene(
        WIDE, drive=drive, master={"tolerance": 1e-4}, eq={"contacts": 2000, "replicas": 2}
    )
    done = toolkit.run(tables | {"sweep": {"drive.spring": [0.01, 0.1, 5.0]}})
    assert [*done.sweep["regime"]] == ["undecided", "stick-slip", "smooth"]
    axes = plot_points_swing(Figure().subplots(), done)
    assert [*np.isfinite(axes.lines[0].get_ydata())] == [False, True, True]
    said = [text.get_text() for text in axes.get_legend().get_texts()]
    assert said == [
        "swings end between 0.1 and 5",
        "no mark: the force only rises at the end of the path",
    ]
    # so it does by the ensemble alone, and between two slips that are farther apart than the path's last quarter
    short = tables | {"drive": drive | {"to": 4.0}, "master": None}
    del short["master"]
    alone = toolkit.run(short | {"sweep": {"drive.spring": [0.1, 0.5, 2.0]}})
    assert [*np.isfinite(alone.sweep["eq_force_swing"])] == [False, False, True]
    assert [*alone.sweep["eq_slips_a_slider"]][:2] == [0.0, 1.0]
    unknown = alone.sweep.columns | {"eq_force_swing": np.full(3, np.nan)}
    write_sweep(replace(alone, sweep=replace(alone.sweep, columns=unknown)), Path("alone.csv"))
    head, *_ = Path("alone.csv").read_text().splitlines()
    assert "eq_last_force" in head and "eq_force_swing [" not in head  # of no value at all
    marks = plot_points(Figure().subplots(), alone, "kinetic_force").lines[0].get_ydata()
    assert [*np.isfinite(marks)] == [False, True, False]
    forces = plot_points(Figure().subplots(), done, "kinetic_force")
    assert done.sweep["force_after_slip"][1] == 0.0 and forces.get_ylim()[0] < -0.01
    columns = done.sweep.columns | {"message": np.array(["", "", "disagree: they slip"])}
    other = replace(done, sweep=replace(done.sweep, columns=columns))
    (line,) = [line for line in report(other) if line.startswith("regime")]
    assert "stick-slip at 1, told otherwise by the ensemble at 1 of the points; undecided" in line


def test_a_path_too_short_for_a_slip_is_no_smooth_sliding() -> None:
    """Springs on which the path ends before the first slip have a mark of their own, and how far to drive is told."""
    over = {"drive.spring": [0.01, 0.3, 5.0], "contacts.thresholds.std": [0.1, 0.2]}
    done = toolkit.run(scene(WIDE, drive=DRIVE, master={"tolerance": 1e-3}, sweep=over))
    regimes = done.sweep["regime"].tolist()
    assert regimes == ["undecided"] * 2 + ["stick-slip"] * 2 + ["smooth"] * 2
    axes = plot_points(Figure().subplots(), done)
    said = [text.get_text() for text in axes.get_legend().get_texts()]
    assert {*said} == {
        "std = 0.1 units of length",
        "std = 0.2 units of length",
        "hollow, at no force: not decided whether it slips",
        "no mark: no slip",
    }
    hollow = [line for line in axes.lines if line.get_markerfacecolor() == "none"]
    assert [[*line.get_xdata()] for line in hollow] == [[0.01], [0.01], []]
    # after a slip the mark stands at its force, whatever follows of how many contacts
    few = "undecided for infinitely many contacts only"
    columns = done.sweep.columns | {"regime": np.array([*regimes[:2], few, *regimes[3:]])}
    other = replace(done, sweep=replace(done.sweep, columns=columns))
    axes = plot_points(Figure().subplots(), other)
    marks = [line.get_xydata() for line in axes.lines if line.get_markerfacecolor() == "white"]
    assert [[*one.ravel()] for one in marks] == [[0.3, done.sweep["force_before_slip"][2]], []]
    said = [text.get_text() for text in axes.get_legend().get_texts()]
    assert "hollow: not decided whether it goes on slipping" in said
    only = {"drive.spring": [0.01, 5.0]}  # without a slip anywhere
    none = plot_points(
        Figure().subplots(),
        toolkit.run(scene(WIDE, drive=DRIVE, master={"tolerance": 1e-3}, sweep=only)),
    )
    hollow = [line for line in none.lines if line.get_markerfacecolor() == "none"]
    assert [[*line.get_xdata()] for line in hollow] == [[0.01], []]
    (text,) = none.get_legend().get_texts()
    assert text.get_text() == "hollow, at no force: not decided whether it slips"
    (line,) = [line for line in report(done) if line.startswith("regime")]
    asked = done.sweep["drive_to"]
    assert [*np.isnan(asked)] == [False] * 2 + [True] * 4
    assert line.endswith(
        f"a longer drive, up to X_T = {max(asked[:2]):.3g} units of length (at drive.spring = 0.01, "
        f"contacts.thresholds.std = {[0.1, 0.2][int(np.argmax(asked[:2]))]}): see sweep.csv"
    )
