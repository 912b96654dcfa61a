"""What a dry run foretells, against the run; and the progress that is shown on the way."""

from collections.abc import Callable
from typing import Any

import pytest

import toolkit
from toolkit.command import main
from toolkit.running.forecast import forecast
from toolkit.scene.tables import to_toml

SCENE: dict[str, Any] = {
    "contacts": {"thresholds": {"kind": "gaussian", "mean": 1.0, "std": 0.2}},
    "drive": {"to": 10.0, "points": 21},
    "eq": {"contacts": 1_500_000, "replicas": 4, "seed": 2},
}
WANTED = SCENE | {"eq": SCENE["eq"] | {"tolerance": 2.5e-4}}
SOFT = {
    "contacts": SCENE["contacts"] | {"thermal": {"law": "soft", "temperature": 0.05}},
    "drive": {"to": 5.0, "points": 11},
    "eq": {"contacts": 2_000_000, "replicas": 1},
}
PULLED = SCENE | {
    "drive": {"to": 4.0, "points": 11, "spring": 0.7},
    "eq": {"contacts": 9000, "replicas": 20},
}


@pytest.mark.usefixtures("whole_blocks")
@pytest.mark.parametrize(
    "tables", [SCENE, WANTED, SOFT, PULLED], ids=["plain", "wanted", "soft", "pulled"]
)
def test_a_run_is_as_foretold(tables: dict[str, Any]) -> None:
    """By the work of its pilot, whatever the machine; a tolerance is reached in rounds that double."""
    scene = toolkit.load_scene(tables)
    told, run = forecast(scene), toolkit.run(scene).eq
    assert run is not None and told.pilot < run.contacts / 10
    most = 4.0 if tables is WANTED else 1.1
    assert told.contacts / most <= run.contacts <= most * told.contacts
    assert told.breaks / told.contacts == pytest.approx(run.breaks / run.contacts, rel=0.05)
    if tables is not PULLED:
        error = run.force_standard_error.max() / scene.contacts.mean_threshold
        assert error / 2.0 < told.error < 2.0 * error
    left = forecast(scene, done=told.contacts - 1000)
    assert left.done == told.contacts - 1000 and left.run_time < told.run_time + 1e-9


def test_a_dry_run_counts_what_is_done_and_writes_nothing(
    tmp_path: Any, monkeypatch: Any, capsys: Any
) -> None:
    monkeypatch.chdir(tmp_path)
    for name, more in (("cut", {"wall_time": 1e-9}), ("other", {"seed": 3}), ("rest", {})):
        (tmp_path / f"{name}.toml").write_text(to_toml(SCENE | {"eq": SCENE["eq"] | more}))
    assert main(["run", "cut.toml", "--out", "out"]) == 1
    done = toolkit.load("out").eq
    before = sorted(tmp_path.rglob("*"))
    capsys.readouterr()
    assert main(["run", "cut.toml", "--out", "out", "--dry-run"]) == 0 and done is not None
    told = capsys.readouterr().out
    assert (
        f"contacts        6,000,000, {done.contacts:,} of them done before\n" in told
        and "for what is left" in told
    )
    assert main(["run", "other.toml", "--out", "out", "--dry-run"]) == 2
    assert (
        "holds the checkpoint of another run, eq.seed = 2 there and 3 here"
        in capsys.readouterr().err
    )
    assert sorted(tmp_path.rglob("*")) == before
    assert main(["run", "rest.toml", "--out", "out"]) == 0
    assert (
        f"note    went on from a checkpoint of {done.contacts:,} contacts: the run"
        in capsys.readouterr().out
    )
    whole = toolkit.load("out").eq
    assert whole is not None and whole.contacts == 6_000_000 and whole.run_time > done.run_time


@pytest.mark.parametrize(
    ("std", "says"),
    [
        (0.2, ", within the 1e-06 asked for"),
        (1e-6, "1e-06, as asked, takes longer, how much is not"),
    ],
)
def test_the_master_equation_is_given_a_second(
    std: float, says: str, tmp_path: Any, capsys: Any
) -> None:
    law = {"kind": "gaussian", "mean": 1.0, "std": std}
    scene = {
        "contacts": {"thresholds": law},
        "drive": SCENE["drive"],
        "master": {"tolerance": 1e-6},
    }
    (tmp_path / "scene.toml").write_text(to_toml(scene))
    assert main(["run", str(tmp_path / "scene.toml"), "--dry-run"]) == 0
    assert says in capsys.readouterr().out


def test_ranks_foretell_together(mpirun: Callable[..., Any], tmp_path: Any) -> None:
    (tmp_path / "scene.toml").write_text(to_toml(SCENE))
    done = mpirun(
        2,
        "import sys; from toolkit.command import main; sys.exit(main())",
        "run",
        "scene.toml",
        "--dry-run",
    )
    assert done.returncode == 0 and done.stderr == "", done.stderr
    assert done.stdout.count("standard error") == 1 and "on 2 rank(s)" in done.stdout


@pytest.mark.usefixtures("whole_blocks")
def test_progress_is_that_of_the_whole_run() -> None:
    told: list[tuple[int, int]] = []
    run = toolkit.run(WANTED, progress=lambda done, expected: told.append((done, expected))).eq
    assert run is not None and run.success
    assert told[0][1] == 6_000_000 and told[-1] == (run.contacts, run.contacts)
    assert [done for done, _ in told] == sorted(done for done, _ in told)
