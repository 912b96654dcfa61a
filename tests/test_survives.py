"""What clusters do to jobs: killed, told to stop; the run that goes on from the checkpoint has the same
bits as one that nothing happened to."""

import dataclasses
import json
import os
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import toolkit
from origins.errors import InputError
from toolkit.running.checkpoint import Checkpoint, identity, write_state
from toolkit.running.runner import make_ensemble
from toolkit.scene.tables import to_toml

SCENE: dict[str, Any] = {
    "title": "survivor",
    "contacts": {
        "thresholds": {"kind": "gaussian", "mean": 1.0, "std": 0.2},
        "delay": {"time": 0.1},
    },
    "drive": {"to": 2.0, "points": 11},
    "eq": {"contacts": 29 << 14, "replicas": 1, "seed": 5, "histograms": [2.0]},
}
BLOCK = 1 << 14
# The command in this process, which some ranks' blocks may end, before or after their checkpoint; no picture, which
# takes longer than all else.
PROGRAM = """
import json, os, signal, sys
import eq_model, toolkit.pictures.run
from toolkit.command import main
from toolkit.running.signals import read_environment

toolkit.pictures.run.save_picture = lambda result, path: path.touch()

def run(words, kills=None, after=0, late=True, victims=(0,)):
    real = eq_model.Ensemble.__iter__
    def mortal(self):
        mine, self.clock = kills and read_environment().rank in victims, lambda: 0.0
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
            status = run(["run", "scene.toml", "--out", "out", "--checkpoint", every], **fate)
        finally:
            sys.stderr.flush()
            os._exit(status)
    _, status = os.waitpid(pid, 0)
    return os.waitstatus_to_exitcode(status), open("error").read()

sys.stdout, stdout = open(os.devnull, "w"), sys.stdout
assert run(["run", "scene.toml", "--out", "whole"]) == 0
told = []
"""


def scene_file(folder: Path) -> None:
    (folder / "scene.toml").write_text(to_toml(SCENE))


def same(folder: Path, other: Path) -> None:
    """Bits of two results, histograms and all."""
    one, two = toolkit.load(folder).eq, toolkit.load(other).eq
    assert one is not None and two is not None and one.success and two.success
    for name in (
        "force",
        "force_standard_error",
        "holding",
        "holding_standard_error",
        "breaks",
        "contacts",
        "message",
    ):
        assert np.array_equal(getattr(one, name), getattr(two, name)), name
    for mine, yours in zip(one.histograms, two.histograms, strict=True):
        for field in dataclasses.fields(mine):
            assert np.array_equal(getattr(mine, field.name), getattr(yours, field.name)), field.name
    assert not (other / "checkpoint").exists()


def followed(told: str) -> int:
    """Contacts that a run says it need not follow again; 0 where it says nothing."""
    return (
        int(told.split("checkpoint: ")[1].split()[0].replace(",", "")) if "going on" in told else 0
    )


def test_killed_eight_times_in_turn_it_loses_no_block(
    python: Callable[..., Any], tmp_path: Path
) -> None:
    scene_file(tmp_path)
    program = """
for turn in range(8):
    late = turn % 2 == 0
    told.append([late, *child(kills=signal.SIGKILL, after=3, late=late)])
told.append([True, *child()])
print(json.dumps(told), file=stdout)
"""
    done = python(FORKS + program)
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert [status for _, status, _ in told] == [-signal.SIGKILL] * 8 + [0]
    # each finished three blocks, the last of which some had no time to keep; nothing else is done again
    kept = np.cumsum([0] + [3 if late else 2 for late, *_ in told[:-1]])
    assert [followed(error) for *_, error in told] == [BLOCK * int(blocks) for blocks in kept]
    same(tmp_path / "whole", tmp_path / "out")


def test_ranks_killed_one_or_all_and_another_number_goes_on(
    python: Callable[..., Any], mpirun: Callable[..., Any], tmp_path: Path
) -> None:
    scene_file(tmp_path)
    words = ["run", "scene.toml", "--out", "out", "--checkpoint", "1e-9"]
    before = 0
    for victims in ([1], [0, 1]):
        fate = {"kills": int(signal.SIGKILL), "after": 4, "victims": victims}
        done = mpirun(2, RANK, json.dumps(fate), *words)
        assert done.returncode not in (0, 2)
        now = followed(done.stderr)
        assert now > before or victims == [1]
        before = now
    done = python(FORKS + "print(*child(), file=stdout)")
    assert done.returncode == 0 and done.stdout.startswith("0 "), done.stderr
    assert followed(done.stdout) > before
    same(tmp_path / "whole", tmp_path / "out")


def test_told_to_stop_it_keeps_its_finished_blocks(
    python: Callable[..., Any], mpirun: Callable[..., Any], tmp_path: Path
) -> None:
    """Even where no checkpoint was due."""
    scene_file(tmp_path)
    program = """
for number in (signal.SIGINT, signal.SIGTERM):
    told.append(child("60", kills=number, after=3, late=False))
told.append(child("60"))
print(json.dumps(told), file=stdout)
"""
    done = python(FORKS + program)
    assert done.returncode == 0, done.stderr
    interrupted, terminated, whole = json.loads(done.stdout)
    going_on = f"mesofriction: going on from the checkpoint in out/checkpoint: {BLOCK * 3:,} contacts are done\n"
    kept = "its finished blocks are kept in out/checkpoint\n"
    assert interrupted == [130, f"mesofriction: interrupted; {kept}"]
    assert terminated == [143, f"{going_on}mesofriction: terminated; {kept}"]
    assert whole[0] == 0 and followed(whole[1]) == 6 * BLOCK
    same(tmp_path / "whole", tmp_path / "out")
    # a launcher passes it on to all ranks
    fate = {"kills": int(signal.SIGTERM), "after": 2, "late": False, "victims": [0, 1]}
    done = mpirun(2, RANK, json.dumps(fate), "run", "scene.toml", "--out", "many")
    assert done.returncode == 143 and done.stdout == ""
    assert done.stderr == f"mesofriction: terminated; {kept.replace('out', 'many')}"
    assert sorted(os.listdir(tmp_path / "many/checkpoint")) == [
        "000-rank-00000.npz",
        "000-rank-00001.npz",
    ]


# -- in one process -----------------------------------------------------------------------------------------

SMALL = SCENE | {"eq": SCENE["eq"] | {"contacts": 3 * BLOCK, "wall_time": 1e-9}}


def cut_short(folder: Path, **eq: Any) -> Any:
    """A run that its wall time stops after its first block."""
    return toolkit.run(SMALL | {"eq": SMALL["eq"] | eq}, folder=folder).eq


def test_stopped_by_its_wall_time_it_goes_on(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    whole = toolkit.run(SCENE | {"eq": SMALL["eq"] | {"wall_time": None}}).eq
    found = [cut_short(tmp_path / "out") for _ in range(3)]
    assert [eq.contacts for eq in found] == [BLOCK, 2 * BLOCK, 3 * BLOCK]
    assert [eq.success for eq in found] == [False, False, True] and "stopped before all" in found[
        0
    ].message
    assert whole is not None and np.array_equal(found[-1].force, whole.force)
    assert not (tmp_path / "out/checkpoint").exists()
    told = capsys.readouterr().err.splitlines()
    assert (
        told[0]
        == f"mesofriction: stopped by the wall time; run it again with --out {tmp_path}/out to go on"
    )
    assert [followed(line) for line in told] == [0, BLOCK, 0, 2 * BLOCK]


def test_another_scenes_checkpoint_is_refused(tmp_path: Path) -> None:
    cut_short(tmp_path)
    files = sorted(tmp_path.rglob("*"))
    with pytest.raises(InputError) as caught:
        cut_short(tmp_path, seed=6)
    assert str(caught.value) == (
        f"out = '{tmp_path}': holds the checkpoint of another run, eq.seed = 5 there and 6 here; choose another "
        f"folder, or remove {tmp_path}/checkpoint"
    )
    with pytest.raises(InputError, match=r"eq\.tolerance = left out there and 0\.001 here; "):
        cut_short(tmp_path, tolerance=1e-3)
    assert sorted(tmp_path.rglob("*")) == files
    # what the ensemble's numbers do not depend on may change
    assert (
        toolkit.run(SMALL | {"title": "renamed", "master": {"tolerance": 1e-3}}, folder=tmp_path).eq
        is not None
    )


def test_thresholds_from_a_file_that_changed_are_another_run(tmp_path: Path) -> None:
    law = {"kind": "from-samples", "file": "x.txt"}
    tables = SMALL | {"contacts": {"thresholds": law}}
    names = []
    for samples in ("1.0 1.1 1.2 1.4 1.6", "1.0 1.1 1.2 1.4 1.7"):
        (tmp_path / "x.txt").write_text("\n".join(samples.split()))
        (tmp_path / "s.toml").write_text(to_toml(tables))
        names.append(identity(toolkit.load_scene(tmp_path / "s.toml")))
    assert [key for key in names[0] if names[0][key] != names[1][key]] == [
        "contacts.thresholds as drawn"
    ]


def interrupting(done: int, expected: int) -> None:
    if done >= 2 * BLOCK:
        signal.raise_signal(signal.SIGINT)


@pytest.mark.usefixtures("whole_blocks")
def test_interrupted_the_run_ends_after_its_block() -> None:
    with pytest.raises(KeyboardInterrupt) as stop:
        toolkit.run(SCENE | {"eq": SCENE["eq"] | {"contacts": 5 * BLOCK}}, progress=interrupting)
    assert stop.value.__notes__ == ["nothing was written"]
    # the handler is as before
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_no_contact_counts_twice_and_what_is_damaged_is_done_again(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Rank 0's file holds what another, which was not yet taken away, holds too; a third is spoiled."""
    scene = toolkit.load_scene(SCENE | {"eq": SCENE["eq"] | {"contacts": 6 * BLOCK}})
    whole = toolkit.run(scene, folder=tmp_path / "whole").eq
    home, told, states = tmp_path / "out/checkpoint", identity(scene), list[Any]()
    home.mkdir(parents=True)
    for _ in range(2):
        ensemble = make_ensemble(scene, scene.eq, None, earlier=states[-1:])  # type: ignore[arg-type]
        next(iter(ensemble))
        states.append(ensemble.state)
    for rank, state in enumerate(reversed(states)):
        write_state(home / f"000-rank-{rank:05d}.npz", state, told)
    spared = (home / "000-rank-00001.npz").read_bytes()
    (home / "000-rank-00002.npz").write_bytes(
        spared[:-3000] + bytes([spared[-3000] ^ 4]) + spared[-2999:]
    )
    (found,) = Checkpoint(tmp_path / "out", scene).earlier(only_look=True)
    assert found.contacts == 2 * BLOCK and len(os.listdir(home)) == 3
    assert toolkit.run(scene, folder=tmp_path / "out").eq is not None and whole is not None
    assert "000-rank-00002.npz: is damaged; what it held is done again" in capsys.readouterr().err
    same(tmp_path / "whole", tmp_path / "out")


def test_a_disk_that_refuses_checkpoints_is_told_once_and_the_run_goes_on(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("toolkit.running.checkpoint.write_state", refused)
    found = toolkit.run(
        SCENE | {"eq": SCENE["eq"] | {"contacts": 5 * BLOCK}}, folder=tmp_path, checkpoint=1e-9
    ).eq
    assert found is not None and found.success
    told = f"mesofriction: {tmp_path}/checkpoint: no checkpoint: No space left on device; the run goes on\n"
    assert capsys.readouterr().err == told
