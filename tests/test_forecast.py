"""What a dry run foretells, against the run; and the progress that is shown on the way."""

import math
import resource
from collections.abc import Callable
from itertools import count
from typing import Any

import pytest
from conftest import HANGS

import toolkit
from origins.errors import InputError
from toolkit.command import main
from toolkit.running.forecast import Estimate, Pilot, forecast, lines, pilot, pilot_lines
from toolkit.scene.toml import to_toml

SCENE: dict[str, Any] = {
    "contacts": {"thresholds": {"kind": "gaussian", "mean": 1.0, "std": 0.2}},
    "drive": {"to": 10.0, "points": 21},
    "eq": {"contacts": 1_500_000, "replicas": 4, "seed": 2},
}
LATE = SCENE | {
    "contacts": SCENE["contacts"] | {"delay": {"time": 0.3}},
    "eq": {"contacts": 100_000, "replicas": 12, "histograms": [5.0]},
}
WANTED = SCENE | {"eq": SCENE["eq"] | {"tolerance": 2.5e-4}}
# contacts of which each costs what its law does
AGEING = {"rate": 1e-3, "final": {"kind": "gaussian", "mean": 1.2, "std": 0.05}}
GRAINS = {"kind": "growing-grains", "alpha": 1.0, "B": 1.0, "age": 4.0}
SOFT, AGED, GROWN = (
    {"contacts": contacts, "drive": {"to": 5.0, "points": 11}, "eq": {"contacts": number, "replicas": 1}}
    for contacts, number in (
        (SCENE["contacts"] | {"thermal": {"law": "soft", "temperature": 0.05}}, 2_500_000),
        (SCENE["contacts"] | {"ageing": AGEING}, 30_000),
        ({"thresholds": GRAINS, "thermal": {"law": "soft", "temperature": 0.02}}, 20_000),
    )
)
RARE = {
    "contacts": {"thresholds": {"kind": "gaussian", "mean": 1.0, "std": 0.05}},
    "drive": {"to": 0.8, "points": 11},
    "eq": {"contacts": 6_000_000, "replicas": 1},
}


def inside(number: Estimate, found: float) -> bool:
    assert number.low <= number.value <= number.high
    return number.low <= found <= number.high


@pytest.mark.usefixtures("whole_blocks")
@pytest.mark.parametrize(
    "tables",
    [SCENE, LATE, WANTED, SOFT, AGED, GROWN, RARE],
    ids=["plain", "late", "wanted", "soft", "ageing", "grains", "rare"],
)
def test_a_run_is_as_foretold(tables: dict[str, Any]) -> None:
    """By the work of its pilot, whatever the machine."""
    told = forecast(toolkit.load_scene(tables))
    run = toolkit.run(tables).eq
    assert run is not None
    assert told.pilot_contacts < run.contacts / 10 or run.contacts < 1 << 16
    assert inside(told.contacts, run.contacts) and inside(told.breaks, run.breaks)
    assert inside(told.error, run.force_standard_error.max() / toolkit.load_scene(tables).contacts.mean_threshold)
    assert told.error.high < 2.0 * told.error.low * (4.0 if tables is WANTED else 20.0 if tables is RARE else 1.0)
    assert told.memory > resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**10 - 160.0


def test_run_times_are_those_of_the_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of one that goes on by a tenth of a second whenever it is read: as much for each block."""
    monkeypatch.setattr("eq_model.Ensemble.clock", staticmethod(count(step=0.1).__next__))
    tables = SCENE | {"eq": SCENE["eq"] | {"contacts": 10 << 16, "replicas": 1}}
    told, run = forecast(toolkit.load_scene(tables)), toolkit.run(tables).eq
    assert run is not None and run.run_time > 1.0 and inside(told.run_time, run.run_time)


def test_what_a_small_pilot_knows_is_not_claimed() -> None:
    few = SCENE | {"eq": {"contacts": 1, "replicas": 1}}
    told = forecast(toolkit.load_scene(few))
    assert told.pilot_contacts == 1 and told.error.value == math.inf
    assert "standard error  inf" in "\n".join(lines(told))


def test_the_tolerance_is_foretold() -> None:
    for tolerance, word in ((1e-9, "no"), (1e-2, "yes")):
        tables = SCENE | {"eq": SCENE["eq"] | {"tolerance": tolerance, "wall_time": 1e-3}}
        text = "\n".join(lines(forecast(toolkit.load_scene(tables))))
        assert f"tolerance       {tolerance:.1e} reached: {word}" in text and "wall time       0.001 s stops it" in text


def test_the_command_tells_and_writes_nothing(
    tmp_path: Any, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["run", "gaussian", "--dry-run"]) == 0
    told = capsys.readouterr().out.splitlines()
    words = ["Gaussian", "master", "contacts", "breaks", "run", "memory", "standard", "from"]
    assert [line.split()[0].rstrip(",") for line in told] == words
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(InputError, match="has no \\[eq\\]"):
        forecast(toolkit.load_scene({key: SCENE[key] for key in ("contacts", "drive")} | {"master": {}}))


def test_what_an_earlier_run_has_done_is_not_foretold_again(
    tmp_path: Any, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for name, more in (("cut", {"wall_time": 1e-9}), ("other", {"seed": 3}), ("rest", {})):
        (tmp_path / f"{name}.toml").write_text(to_toml(SCENE | {"eq": SCENE["eq"] | more}))
    assert main(["run", "cut.toml", "--out", "out"]) == 1
    done = toolkit.load("out").eq
    assert done is not None
    before = sorted(tmp_path.rglob("*"))
    capsys.readouterr()
    assert main(["run", "cut.toml", "--out", "out", "--dry-run"]) == 0
    told = capsys.readouterr().out
    assert f"contacts        6,000,000, {done.contacts:,} of them done before\n" in told and "for what is left" in told
    assert main(["run", "other.toml", "--out", "out", "--dry-run"]) == 2
    assert "holds the checkpoint of another run, eq.seed = 2 there and 3 here" in capsys.readouterr().err
    assert sorted(tmp_path.rglob("*")) == before
    assert main(["run", "rest.toml", "--out", "out"]) == 0
    assert f"note    went on from a checkpoint of {done.contacts:,} contacts: the run" in capsys.readouterr().out
    whole = toolkit.load("out")
    assert whole.eq is not None and whole.eq.contacts == 6_000_000 and whole.eq.run_time > done.run_time


def test_the_master_equation_is_tried_at_looser_tolerances() -> None:
    scene = toolkit.load_scene({key: SCENE[key] for key in ("contacts", "drive")} | {"master": {"tolerance": 1e-9}})
    told = pilot(scene, most_seconds=HANGS)
    assert told.error <= 1e-9 and ", within the 1e-09 asked for" in pilot_lines(told)[0]
    assert "no more is reached" in pilot_lines(Pilot(0.3, 4.0, 1e-4, ended=True))[0]
    assert "1e-04, as asked, takes longer, how much is not" in pilot_lines(Pilot(0.3, 4.0, 1e-4, ended=False))[0]


def test_a_pilot_ends_when_its_time_is_up() -> None:
    slow = {"contacts": {"thresholds": {"kind": "gaussian", "mean": 1.0, "std": 1e-6}}, "drive": SCENE["drive"]}
    scene = toolkit.load_scene(slow | {"master": {"tolerance": 1e-6}})
    # hundreds of times as long as this, after which it would end without an answer
    told = pilot(scene, most_seconds=1e-3)
    assert told.error > 1e-6 and not told.ended and "not foreseen" in pilot_lines(told)[0]


def test_ranks_foretell_together(mpirun: Callable[..., Any], tmp_path: Any) -> None:
    (tmp_path / "scene.toml").write_text(to_toml(LATE))
    done = mpirun(2, "import sys; from toolkit.command import main; sys.exit(main())", "run", "scene.toml", "--dry-run")
    assert done.returncode == 0 and done.stderr == "", done.stderr
    assert done.stdout.count("standard error") == 1 and "on 2 rank(s)" in done.stdout


@pytest.mark.usefixtures("whole_blocks")
def test_progress_is_that_of_the_whole_run() -> None:
    told: list[tuple[int, int]] = []
    run = toolkit.run(WANTED, progress=lambda done, expected: told.append((done, expected))).eq
    assert run is not None and run.success
    assert told[0][1] == 6_000_000 and told[-1] == (run.contacts, run.contacts)
    assert [done for done, _ in told] == sorted(done for done, _ in told)
    # what is expected is known well soon after the first round
    assert run.contacts / 2 <= told[5][1] <= 2 * run.contacts
