"""What clusters do to jobs: killed, told to stop, a full disk; the run that goes on from the checkpoint has the same
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
from toolkit.running.checkpoint import Checkpoint, identity
from toolkit.running.runner import make_ensemble

SCENE: dict[str, Any] = {
    "title": "survivor",
    "contacts": {"thresholds": {"kind": "gaussian", "mean": 1.0, "std": 0.2}, "delay": {"time": 0.1}},
    "drive": {"to": 2.0, "points": 11},
    "eq": {"contacts": 29 << 14, "replicas": 1, "seed": 5, "histograms": [2.0]},
}
BLOCK = 1 << 14
GAUSSIAN = SCENE["contacts"]["thresholds"]
SOFT = {"law": "soft", "temperature": 0.05}
GRAINS = {"kind": "growing-grains", "alpha": 1.0, "B": 1.0, "age": 4.0}
AGEING = {"rate": 1e-3, "final": {"kind": "gaussian", "mean": 1.2, "std": 0.05}}
LOOP = {"turns": [1.4, -0.6, 0.4], "points": 12}
# contacts, drive, number
LAWS: dict[str, tuple[Any, Any, int]] = {
    "delay": (SCENE["contacts"], {"to": 2.0, "points": 11}, 600_000),
    "soft": ({"thresholds": GAUSSIAN, "thermal": SOFT}, LOOP, 200_000),
    "ageing": ({"thresholds": GAUSSIAN, "ageing": AGEING}, {"to": 2.0, "points": 11}, 30_000),
    "grains": ({"thresholds": GRAINS, "thermal": SOFT}, LOOP, 15_000),
}

# The command in this process, which may end after so many blocks, before or after their checkpoint, or some time after
# that of a share of the contacts, whatever it does by then; no picture, which takes longer than all else.
PROGRAM = """
import json, os, resource, signal, sys
import eq_model
from toolkit.command import main
from toolkit.running.launch import read_environment
import toolkit.pictures.run

toolkit.pictures.run.save_picture = lambda result, path: path.touch()

def room(most=resource.RLIM_INFINITY):
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, resource.RLIM_INFINITY))

def run(words, kills=None, after=0, late=True, victims=(0,), share=None, delay=0.0, roomy=False):
    real = eq_model.Ensemble.__iter__
    def mortal(self):
        mine, doomed, self.clock = read_environment().rank in victims, False, lambda: 0.0
        for number, found in enumerate(real(self), 1):
            if mine and kills and number == after and not late:
                os.kill(os.getpid(), kills)
            yield found
            if mine and kills and number == after and late:
                os.kill(os.getpid(), kills)
            if share is not None and not doomed and found[0] >= share * self.total:
                doomed = True
                signal.setitimer(signal.ITIMER_REAL, delay)  # the alarm kills, as nothing handles it
        while doomed:
            signal.pause()
        if roomy:
            room()
    eq_model.Ensemble.__iter__ = mortal
    try:
        return main(words)
    finally:
        eq_model.Ensemble.__iter__ = real
"""
RANK = f"""{PROGRAM}
sys.exit(run(sys.argv[2:], **json.loads(sys.argv[1])))
"""

# Children of one process that has imported and compiled everything: a kill costs no more than the work it undoes.
CHILDREN = (
    PROGRAM
    + """
def child(words, error, limit=None, **fate):
    pid = os.fork()
    if pid == 0:
        os.dup2(os.open(error, os.O_WRONLY | os.O_CREAT | os.O_TRUNC), 2)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        if limit is not None:
            room(limit)
        status = 1
        try:
            status = run(words, **fate)
        finally:
            sys.stderr.flush()
            os._exit(status)
    _, status = os.waitpid(pid, 0)
    return os.waitstatus_to_exitcode(status), open(error).read()

signals = signal.SIGINT, signal.SIGTERM, signal.SIGKILL
words = lambda out, every="1e-9", scene="scene": ["run", scene + ".toml", "--out", out, "--checkpoint", every]
sys.stdout, stdout = open(os.devnull, "w"), sys.stdout
told = []
"""
)
FORKS = CHILDREN + 'assert run(words("whole")) == 0\n'


def scene_file(folder: Path, name: str = "scene", **tables: Any) -> None:
    from toolkit.scene.toml import to_toml

    (folder / f"{name}.toml").write_text(to_toml(SCENE | tables))


def same(folder: Path, other: Path) -> None:
    """Bits of two results, histograms and all."""
    one, two = toolkit.load(folder).eq, toolkit.load(other).eq
    assert one is not None and two is not None and one.success and two.success
    for name in ("force", "force_standard_error", "holding", "holding_standard_error", "breaks", "contacts", "message"):
        assert np.array_equal(getattr(one, name), getattr(two, name)), name
    for mine, yours in zip(one.histograms, two.histograms, strict=True):
        for field in dataclasses.fields(mine):
            assert np.array_equal(getattr(mine, field.name), getattr(yours, field.name)), field.name
    assert not (other / "checkpoint").exists()


def followed(told: str) -> int:
    """Contacts that a run says it need not follow again; 0 where it says nothing."""
    return int(told.split("checkpoint: ")[1].split()[0].replace(",", "")) if "going on" in told else 0


def test_killed_eight_times_in_turn_it_loses_no_block(python: Callable[..., Any], tmp_path: Path) -> None:
    scene_file(tmp_path)
    program = """
for turn in range(8):
    late = turn % 2 == 0
    told.append([late, *child(words("out"), "error", kills=signal.SIGKILL, after=3, late=late)])
told.append([True, *child(words("out"), "error")])
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


def test_killed_at_10_to_90_percent_of_its_contacts(python: Callable[..., Any], tmp_path: Path) -> None:
    """Twenty times, of contacts that wait, that break by themselves, that age and that grow stronger; in the middle of
    whatever it does some milliseconds later."""
    for name, (contacts, drive, number) in LAWS.items():
        last = drive.get("to", 0.4)
        asked = SCENE["eq"] | {"contacts": number, "histograms": [last]}
        scene_file(tmp_path, name, contacts=contacts, drive=drive, eq=asked)
    program = """
for name in sys.argv[1:]:
    assert run(words(name + "/whole", "60", name)) == 0
    for share in (0.1, 0.3, 0.5, 0.7, 0.9):
        out, delay = f"{name}/{share}", 1e-3 * (1 + 0.4 * len(told))
        status, _ = child(words(out, scene=name), "error", share=share, delay=delay)
        told.append([name, out, share, status, *child(words(out, "60", name), "error")])
print(json.dumps(told), file=stdout)
"""
    done = python(CHILDREN + program, *LAWS)
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert len(told) == 20
    for name, folder, share, killed, status, error in told:
        assert killed == -signal.SIGALRM and status == 0
        assert followed(error) >= share * LAWS[name][2]
        same(tmp_path / name / "whole", tmp_path / folder)


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
    done = python(FORKS + 'print(*child(words("out"), "error"), file=stdout)')
    assert done.returncode == 0 and done.stdout.startswith("0 "), done.stderr
    assert followed(done.stdout) > before
    same(tmp_path / "whole", tmp_path / "out")


def test_told_to_stop_it_keeps_its_finished_blocks(
    python: Callable[..., Any], mpirun: Callable[..., Any], tmp_path: Path
) -> None:
    """Even where no checkpoint was due."""
    scene_file(tmp_path)
    program = """
for number in signals[:2]:
    told.append(child(words("out", "60"), "error", kills=number, after=3, late=False))
told.append(child(words("out", "60"), "error"))
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
    assert sorted(os.listdir(tmp_path / "many/checkpoint")) == ["000-rank-00000.npz", "000-rank-00001.npz"]


def test_full_disk(python: Callable[..., Any], tmp_path: Path) -> None:
    """No checkpoint: one warning, and a result if there is room by then. No result: one line. Nothing half written, and
    the checkpoint still there."""
    scene_file(tmp_path, eq=SCENE["eq"] | {"contacts": 5 * BLOCK})
    program = """
told = [child(words("none"), "error", limit=1000)]
told.append(child(words("some"), "error", limit=1000, roomy=True))
child(words("all"), "error", kills=signal.SIGKILL, after=2)
told.append(child(words("all"), "error", limit=1000))
print(json.dumps(told), file=stdout)
"""
    done = python(FORKS + program)
    assert done.returncode == 0, done.stderr
    none, some, rest = json.loads(done.stdout)
    warned = "mesofriction: {0}/checkpoint: no checkpoint: File too large; the run goes on\n"
    refused = "mesofriction: out = '{0}': cannot be written: File too large\n"
    assert none == [2, (warned + refused).format("none")]
    assert some == [0, warned.format("some")]
    same(tmp_path / "whole", tmp_path / "some")
    assert rest[0] == 2 and followed(rest[1]) == 2 * BLOCK and rest[1].endswith((warned + refused).format("all"))
    assert [str(p.relative_to(tmp_path)) for p in sorted((tmp_path / "none").rglob("*"))] == ["none/checkpoint"]
    assert os.listdir(tmp_path / "all") == ["checkpoint"] and len(os.listdir(tmp_path / "all/checkpoint")) == 1


# -- in one process -----------------------------------------------------------------------------------------

SMALL = SCENE | {"eq": SCENE["eq"] | {"contacts": 3 * BLOCK, "wall_time": 1e-9}}


def cut_short(folder: Path, **eq: Any) -> Any:
    """A run that its wall time stops after its first block."""
    return toolkit.run(SMALL | {"eq": SMALL["eq"] | eq}, folder=folder).eq


def test_stopped_by_its_wall_time_it_goes_on(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    whole = toolkit.run(SCENE | {"eq": SMALL["eq"] | {"wall_time": None}}).eq
    found = [cut_short(tmp_path / "out") for _ in range(3)]
    assert [eq.contacts for eq in found] == [BLOCK, 2 * BLOCK, 3 * BLOCK]
    assert [eq.success for eq in found] == [False, False, True] and "stopped before all" in found[0].message
    assert whole is not None and np.array_equal(found[-1].force, whole.force)
    assert not (tmp_path / "out/checkpoint").exists()
    told = capsys.readouterr().err.splitlines()
    assert told[0] == f"mesofriction: stopped by the wall time; run it again with --out {tmp_path}/out to go on"
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
    assert toolkit.run(SMALL | {"title": "renamed", "master": {"tolerance": 1e-3}}, folder=tmp_path).eq is not None


def test_thresholds_from_a_file_that_changed_are_another_run(tmp_path: Path) -> None:
    law = {"kind": "from-samples", "file": "x.txt"}
    tables = SMALL | {"contacts": {"thresholds": law}}
    names = []
    for samples in ("1.0 1.1 1.2 1.4 1.6", "1.0 1.1 1.2 1.4 1.7"):
        (tmp_path / "x.txt").write_text("\n".join(samples.split()))
        (tmp_path / "s.toml").write_text(toolkit.scene.toml.to_toml(tables))  # type: ignore[attr-defined]
        names.append(identity(toolkit.load_scene(tmp_path / "s.toml")))
    assert [key for key in names[0] if names[0][key] != names[1][key]] == ["contacts.thresholds as drawn"]


def test_long_lists_are_told_apart_in_few_letters() -> None:
    names = []
    for last in (1.5, 1.6):
        law = {"kind": "from-samples", "x_s": [*np.linspace(1.0, 1.4, 500), last]}
        names.append(identity(toolkit.load_scene(SCENE | {"contacts": {"thresholds": law}})))
    apart = [key for key in names[0] if names[0][key] != names[1][key]]
    assert apart == ["contacts.thresholds.x_s", "contacts.thresholds as drawn"]
    assert max(map(len, names[0].values())) < 100


def test_whatever_is_left_behind_no_contact_counts_twice(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Rank 0 has written what was found before, another rank's old file is still there, and one file is spoiled."""
    scene = toolkit.load_scene(SCENE | {"eq": SCENE["eq"] | {"contacts": 6 * BLOCK, "histograms": [2.0]}})
    assert scene.eq is not None
    ensemble = make_ensemble(scene, scene.eq, None)
    states, own = [dataclasses.replace(ensemble.state, done=[], run_time=0.0)] * 3, (0, 1, 1, 2)
    for one, block in zip(own, (0, 1, 2, 5), strict=True):
        found = ensemble._work.follow(ensemble.blocks, block)
        states[one] = states[one].after(block, BLOCK, found, 0.0)
    old = [Checkpoint(tmp_path, scene) for _ in range(2)]
    old[1]._rank = 1
    for kept, state in zip(old, states, strict=False):
        kept.write(state)
    new = Checkpoint(tmp_path, scene)
    (before,) = new.earlier()
    assert before.contacts == 3 * BLOCK
    other = Checkpoint(tmp_path, scene)
    other.earlier()
    other._rank = 1
    other.write(states[2])  # rank 1 of the new run is first: nothing of the old one may be lost
    assert Checkpoint(tmp_path, scene).earlier()[0].done == [range(3), range(5, 6)]
    spared = (tmp_path / "checkpoint/000-rank-00001.npz").read_bytes()
    new.write(before)
    assert sorted(os.listdir(tmp_path / "checkpoint")) == ["001-rank-00000.npz", "001-rank-00001.npz"]
    (tmp_path / "checkpoint/000-rank-00001.npz").write_bytes(spared)
    (found,) = Checkpoint(tmp_path, scene).earlier()
    assert found.done == [range(3), range(5, 6)]
    assert np.array_equal(found.sums, states[0].sums + states[1].sums + states[2].sums)
    assert found.counts.sum() > 0 and np.array_equal(found.counts, sum(state.counts for state in states))
    # cut short; and one bit of what the histograms counted
    for spoiled in (spared[:1000], spared[:-3000] + bytes([spared[-3000] ^ 4]) + spared[-2999:]):
        (tmp_path / "checkpoint/001-rank-00001.npz").write_bytes(spoiled)
        assert Checkpoint(tmp_path, scene).earlier()[0].done == [range(3)]
        assert "001-rank-00001.npz: is damaged; what it held is done again" in capsys.readouterr().err
    new.remove()
    assert os.listdir(tmp_path) == []


def interrupting(done: int, expected: int) -> None:
    if done >= 2 * BLOCK:
        signal.raise_signal(signal.SIGINT)


@pytest.mark.usefixtures("whole_blocks")
def test_interrupted_in_a_notebook_the_finished_blocks_are_the_result(monkeypatch: pytest.MonkeyPatch) -> None:
    tables = SCENE | {"eq": SCENE["eq"] | {"contacts": 5 * BLOCK}}
    with pytest.raises(KeyboardInterrupt):
        toolkit.run(tables, progress=interrupting)
    monkeypatch.setattr("sys.ps1", ">>> ", raising=False)
    result = toolkit.run(tables, progress=interrupting)
    assert result.eq is not None and result.eq.contacts == 2 * BLOCK and not result.success
    assert result.eq.message.startswith("interrupted: ") and "stopped before all" in result.eq.message
    first = toolkit.run(SCENE | {"eq": SCENE["eq"] | {"contacts": 2 * BLOCK}}).eq
    assert first is not None and np.array_equal(first.force, result.eq.force)
    # the handler is as before
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@pytest.mark.usefixtures("whole_blocks")
@pytest.mark.parametrize("place", ["progress", "block"])
def test_raised_in_the_middle_an_interrupt_costs_the_block_alone(place: str, monkeypatch: pytest.MonkeyPatch) -> None:
    from eq_model.engine import Engine

    tables, real, blocks = SCENE | {"eq": SCENE["eq"] | {"contacts": 5 * BLOCK}}, Engine.follow, []

    def follow(self: Engine, all_of_them: Any, block: int) -> Any:
        found = real(self, all_of_them, block)
        blocks.append(block)
        if place == "block" and len([one for one in blocks if one >= 0]) == 3:
            raise KeyboardInterrupt
        return found

    def progress(done: int, expected: int) -> None:
        if place == "progress" and done >= 2 * BLOCK:
            raise KeyboardInterrupt

    monkeypatch.setattr(Engine, "follow", follow)
    with pytest.raises(KeyboardInterrupt):
        toolkit.run(tables, progress=progress)
    blocks.clear()
    monkeypatch.setattr("sys.ps1", ">>> ", raising=False)
    result = toolkit.run(tables, progress=progress).eq
    monkeypatch.setattr(Engine, "follow", real)
    first = toolkit.run(SCENE | {"eq": SCENE["eq"] | {"contacts": 2 * BLOCK}}).eq
    assert result is not None and first is not None and not result.success and result.contacts == 2 * BLOCK
    assert result.message.startswith("interrupted: ") and np.array_equal(first.force, result.force)


def test_interrupted_ranks_wait_for_the_others(mpirun: Callable[..., Any]) -> None:
    """In an interactive session: one of two, and both."""
    program = """
import json, signal, sys
import eq_model, toolkit
from mpi4py import MPI
sys.ps1, comm = ">>> ", MPI.COMM_WORLD
tables, told = json.loads(sys.argv[1]), []
for victims in ((1,), (0, 1)):
    def progress(done, expected):
        if comm.Get_rank() in victims and done == 4 * (1 << 14):
            signal.raise_signal(signal.SIGINT)
    found = toolkit.run(tables, comm=comm, progress=progress).eq
    told.append([found.contacts, found.message.split(":")[0], found.success])
every = comm.gather(told)
if comm.Get_rank() == 0:
    print(json.dumps(every))
"""
    done = mpirun(2, program, json.dumps(SCENE | {"eq": SCENE["eq"] | {"contacts": 10 * BLOCK}}))
    assert done.returncode == 0, done.stderr
    one, other = json.loads(done.stdout)
    assert [row[0] for row in one] == [row[0] for row in other] == [7 * BLOCK, 4 * BLOCK]
    assert [row[1] for row in other] == ["interrupted"] * 2 and one[1][1] == "interrupted"
    assert not any(row[2] for row in one + other)


def test_without_a_folder_nothing_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert toolkit.run(SMALL).eq is not None
    assert os.listdir(tmp_path) == []


def test_histograms_are_read_back_each_when_asked_for(tmp_path: Path) -> None:
    tables = SCENE | {"eq": {"contacts": 1000, "replicas": 1, "histograms": [1.0, 2.0]}}
    result = toolkit.run(tables, folder=tmp_path)
    back = toolkit.load(tmp_path)
    assert result.eq is not None and back.eq is not None and len(back.eq.histograms) == 2
    for one, other in zip(result.eq.histograms, back.eq.histograms, strict=True):
        for field in dataclasses.fields(one):
            assert np.array_equal(getattr(one, field.name), getattr(other, field.name)), field.name
    assert [one.position for one in back.eq.histograms] == [1.0, 2.0]
    toolkit.run(tables, folder=tmp_path)
    with pytest.raises(InputError, match="another one since it was loaded; load it again"):
        back.eq.histograms[0]
