"""What clusters do to jobs: killed, told to stop, out of time or of disk; the run that goes on from the checkpoint has
the same bits as one that nothing happened to."""

import json
import os
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scenes import said, scene, write
from solving import same_bits

import toolkit
from eq_model.blocks import BLOCK
from origins.errors import InputError

CONTACTS = {"thresholds": {"kind": "gaussian", "mean": 1.0, "std": 0.2}, "delay": {"time": 0.1}}
EQ = {"contacts": 29 * BLOCK, "replicas": 1, "seed": 5, "histograms": [2.0]}
SCENE = scene(contacts=CONTACTS, drive={"to": 2.0, "points": 11}, master=None, eq=EQ)
SMALL = SCENE | {"eq": EQ | {"contacts": 3 * BLOCK}}
# The command in this process, which some ranks' blocks may end, before or after their checkpoint; no picture, which
# takes longer than all else.
PROGRAM = """
import json, os, signal, sys
import eq_model, toolkit.pictures.run
from toolkit.command import main

toolkit.pictures.run.save_picture = lambda result, path: path.touch()

def run(words, kills=None, after=0, late=True, victims=(0,)):
    real = eq_model.Ensemble.__iter__
    rank = int(os.environ.get("PMI_RANK", os.environ.get("OMPI_COMM_WORLD_RANK", 0)))
    def mortal(self):
        mine, self.clock = kills and rank in victims, lambda: 0.0
        for number, found in enumerate(real(self), 1):
            if mine and number == after and not late:
                os.kill(os.getpid(), kills)
            yield found
            if mine and number == after and late:
                os.kill(os.getpid(), kills)
    eq_model.Ensemble.__iter__ = mortal
    try:
        return main(words)
    finally:
        eq_model.Ensemble.__iter__ = real
"""
RANK = f"{PROGRAM}\nsys.exit(run(sys.argv[2:], **json.loads(sys.argv[1])))\n"
# Children of one process that has imported and compiled everything: a kill costs no more than the work it undoes.
FORKS = f"""{PROGRAM}
def child(every="1e-9", **fate):
    pid = os.fork()
    if pid == 0:
        os.dup2(os.open("error", os.O_WRONLY | os.O_CREAT | os.O_TRUNC), 2)
        status = 1
        try:
            status = run(["run", "mine.toml", "--out", "out", "--checkpoint", every], **fate)
        finally:
            sys.stderr.flush()
            os._exit(status)
    _, status = os.waitpid(pid, 0)
    return os.waitstatus_to_exitcode(status), open("error").read()

sys.stdout, stdout = open(os.devnull, "w"), sys.stdout
assert run(["run", "mine.toml", "--out", "whole"]) == 0
told = []
"""


pytestmark = pytest.mark.usefixtures("unrendered")


@pytest.fixture(autouse=True)
def _here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    write(**SCENE)


def same(folder: str, other: str) -> None:
    """Bits of two results, histograms and all."""
    one, two = toolkit.load(folder).eq, toolkit.load(other).eq
    assert one.success and two.success and not Path(other, "checkpoint").exists()
    same_bits(one, two)


def followed(told: str) -> int:
    """Contacts that a run says it need not follow again; 0 where it says nothing."""
    return (
        int(told.split("checkpoint: ")[1].split()[0].replace(",", "")) if "going on" in told else 0
    )


def test_killed_in_turn_it_loses_no_block(python: Callable[..., Any]) -> None:
    """kill -9 after a checkpoint, or before it; then an interrupt and SIGTERM, which keep one that was not due."""
    fates = """
for turn in range(2):
    told.append(child(kills=signal.SIGKILL, after=3, late=turn % 2 == 0))
for number in (signal.SIGINT, signal.SIGTERM):
    told.append(child("60", kills=number, after=3, late=False))
told.append(child("60"))
print(json.dumps(told), file=stdout)
"""
    done = python(FORKS + fates)
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert [status for status, _ in told] == [-signal.SIGKILL] * 2 + [130, 143, 0]
    # each finished three blocks, the last of which two had no time to keep; nothing else is done again
    assert [followed(error) // BLOCK for _, error in told] == [0, 3, 5, 8, 11]
    kept = "its finished blocks are kept in out/checkpoint\n"
    assert told[2][1].endswith(f"\nmesofriction: interrupted; {kept}")
    same("whole", "out")


@pytest.mark.slow  # quick: one process killed, and a signal to one rank
def test_ranks_killed_and_another_number_goes_on(
    python: Callable[..., Any], mpirun: Callable[..., Any]
) -> None:
    fate = {"kills": int(signal.SIGKILL), "after": 4, "victims": [1]}
    done = mpirun(
        2, RANK, json.dumps(fate), "run", "mine.toml", "--out", "out", "--checkpoint", "1e-9"
    )
    assert done.returncode not in (0, 2)
    done = python(FORKS + "print(*child(), file=stdout)")
    assert done.returncode == 0 and done.stdout.startswith("0 "), done.stderr
    assert followed(done.stdout) > 0
    same("whole", "out")


@pytest.mark.slow  # quick: signals to a lone process, above and below
def test_a_signal_to_one_rank_ends_all(mpirun: Callable[..., Any]) -> None:
    fate = {"kills": int(signal.SIGTERM), "after": 3, "victims": [1]}
    done = mpirun(2, RANK, json.dumps(fate), "run", "mine.toml", "--out", "out")
    assert done.returncode == 143, done.stderr
    assert (
        done.stderr == "mesofriction: terminated; its finished blocks are kept in out/checkpoint\n"
    )
    assert sorted(os.listdir("out/checkpoint")) == ["000-rank-00000.npz", "000-rank-00001.npz"]


@pytest.mark.slow  # of blocks: the test before
def test_a_signal_to_one_rank_ends_replicas_of_the_others(mpirun: Callable[..., Any]) -> None:
    """Rank 1 gets it while rank 0 follows replicas, in two threads, that do not end by themselves."""
    drive, eq = {"to": 7.0, "points": 71, "spring": 0.7}, {"contacts": 400, "replicas": 6}
    write(**scene(drive=drive, master=None, eq=eq | {"threads": 2}))
    endless = """
import time
from eq_model.coupled import slide_kernel

def slide(*_):
    time.sleep(0.001)
    return slide_kernel.GOING_ON

class Endless(eq_model.coupled.ensemble.Replicas):
    def follow(self, replica):
        slide_kernel.slide = real if replica < 0 else slide
        return super().follow(replica)

real = slide_kernel.slide
if os.environ.get("PMI_RANK", os.environ.get("OMPI_COMM_WORLD_RANK")) == "0":
    eq_model.ensemble.Replicas = Endless
"""
    program = f"{PROGRAM}{endless}\nsys.exit(run(sys.argv[2:], **json.loads(sys.argv[1])))\n"
    fate = {"kills": int(signal.SIGTERM), "after": 1, "victims": [1]}
    done = mpirun(2, program, json.dumps(fate), "run", "mine.toml", "--out", "out")
    assert done.returncode == 143, done.stderr
    kept = "mesofriction: terminated; its finished blocks are kept in out/checkpoint\n"
    assert done.stderr == kept
    assert sorted(os.listdir("out/checkpoint")) == ["000-rank-00000.npz", "000-rank-00001.npz"]


# -- in one process -----------------------------------------------------------------------------------------


@pytest.mark.slow  # quick: an interrupt and SIGTERM, above
def test_sighup_keeps_a_checkpoint(capsys: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the soft slider's ensemble as of the rigid one; what goes on has the same bits."""

    def hang_up(_: object, done: int, expected: int) -> None:
        if done < expected:
            signal.raise_signal(signal.SIGHUP)

    signal.signal(signal.SIGHUP, signal.SIG_DFL)  # tests that nohup started ignore it
    drive = {"to": 7.0, "points": 71, "spring": 0.7}
    for tables in (SMALL, scene(drive=drive, master=None, eq={"contacts": 400, "replicas": 6})):
        whole, file = toolkit.run(tables).eq, write(**tables)
        with monkeypatch.context() as patch:
            patch.setattr("toolkit.running.progress.Progress.count", hang_up)
            status, _, err = said(capsys, "run", file, "--out", "out")
        kept = "mesofriction: terminated; its finished blocks are kept in out/checkpoint"
        assert status == 143 and err[-1] == kept
        assert said(capsys, "run", file, "--out", "out")[0] == 0
        found = toolkit.load("out").eq
        assert found.success and found.breaks == whole.breaks
        assert np.array_equal(found.force, whole.force)


def test_stopped_by_its_wall_time_it_goes_on_and_another_scene_does_not() -> None:
    cut = SMALL | {"eq": SMALL["eq"] | {"wall_time": 1e-9}}
    whole, first = toolkit.run(SMALL).eq, toolkit.run(cut, folder="out").eq
    assert first.contacts == BLOCK and not first.success and "stopped before all" in first.message
    files = sorted(Path("out").rglob("*"))
    for other, told in (
        ({"seed": 6}, r"another run, eq\.seed = 5 there and 6 here; choose another folder, or "),
        ({"tolerance": 1e-3}, r"eq\.tolerance = left out there and 0\.001 here; "),
    ):
        with pytest.raises(InputError, match=told):
            toolkit.run(cut | {"eq": cut["eq"] | other}, folder="out")
    assert sorted(Path("out").rglob("*")) == files
    # what the ensemble's numbers do not depend on may change
    renamed = cut | {"title": "renamed", "master": {}}
    found = [toolkit.run(renamed, folder="out").eq for _ in range(2)]
    assert [eq.contacts for eq in found] == [2 * BLOCK, 3 * BLOCK]
    assert found[-1].success and np.array_equal(found[-1].force, whole.force)
    assert not Path("out/checkpoint").exists()


def test_thresholds_from_a_file_that_changed_are_another_run() -> None:
    tables = {"thresholds": {"kind": "from-samples", "file": "x.txt"}, "master": None}
    Path("x.txt").write_text("1.0\n1.1\n1.2\n1.4\n1.6\n")
    file = write(**tables, eq={"contacts": 3 * BLOCK, "replicas": 1, "wall_time": 1e-9})
    assert not toolkit.run(file, folder="out").eq.success
    Path("x.txt").write_text("1.0\n1.1\n1.2\n1.4\n1.7\n")
    with pytest.raises(InputError, match=r"contacts\.thresholds as drawn"):
        toolkit.run(file, folder="out")


def test_no_damage_of_a_checkpoint_goes_unseen(capsys: Any) -> None:
    """Bits that flip, an end that is cut off: what it held is done again, and the result is the same."""
    cut = SMALL | {"eq": SMALL["eq"] | {"wall_time": 1e-9}}
    whole, draws = toolkit.run(SMALL).eq, np.random.default_rng(4)
    assert not toolkit.run(cut, folder="out").eq.success
    assert toolkit.run(scene(), folder="out").master.success  # which has no ensemble, and keeps it
    (file,) = Path("out/checkpoint").iterdir()
    kept, words = file.read_bytes(), ("run", write(**cut), "--out", "out", "--dry-run")
    assert f"{BLOCK:,} of them done before" in "".join(said(capsys, *words)[1])
    for place in [*draws.integers(0, len(kept), 8), *draws.integers(0, 200, 4)]:
        flipped = bytes([kept[place] ^ 1 << draws.integers(8)])
        file.write_bytes(kept[:place] + flipped + kept[place + 1 :])
        assert "done before" not in "".join(said(capsys, *words)[1]), place
    file.write_bytes(kept[: len(kept) // 2])
    found = toolkit.run(SMALL, folder="out").eq
    told = "000-rank-00000.npz: is damaged; what it held is done again"
    assert told in capsys.readouterr().err
    assert np.array_equal(found.force, whole.force) and found.contacts == whole.contacts


def test_a_disk_that_refuses_checkpoints_or_results_loses_nothing(
    capsys: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The run goes on without a checkpoint, and a finished ensemble stays where its result is refused."""

    def full(*_: object, **named: object) -> None:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr("toolkit.running.checkpoint.write_state", full)
        assert toolkit.run(SMALL, folder="a", checkpoint=1e-9).eq.success
    assert "no checkpoint: No space left on device; the run goes on" in capsys.readouterr().err
    file = write(**SMALL)
    with monkeypatch.context() as patch:
        patch.setattr("toolkit.saving.write_json", full)
        assert said(capsys, "run", file, "--out", "out")[0] == 2
        assert os.listdir("out") == ["checkpoint"]
    assert said(capsys, "run", file, "--out", "out")[0] == 0
    found = toolkit.load("out")
    assert (
        f"went on from a checkpoint of {3 * BLOCK:,} of {found.eq.contacts:,} contacts: "
        in found.notes[-1]
    )
