"""Scenes with a spring and an ensemble: the comparison slip by slip, result files, checkpoints, ranks."""

import dataclasses
import json
import signal
import subprocess
import sys

import numpy as np
import pytest
from conftest import HANGS, clean_environment

import toolkit
from origins.errors import InputError
from toolkit.commands import report
from toolkit.results.beside import slips_beside
from toolkit.scene.tables import to_toml

SCENE = {
    "contacts": {"thresholds": {"kind": "gaussian", "mean": 1.0, "std": 0.1}},
    "drive": {"to": 7.0, "points": 71, "spring": 0.7, "slip": "reform-after"},
    "master": {},
    "eq": {"contacts": 400, "replicas": 12, "seed": 5, "slip_fraction": 0.3},
}
# under mpirun, and alone, in this process
PROGRAM = """
import json
import numpy as np
import eq_model, origins
contacts = origins.Contacts(origins.gaussian(1.0, 0.1), delay=origins.Delay(0.1))

def told(comm):
    run = eq_model.simulate(contacts, np.linspace(0.0, 7.0, 29), spring=0.7, n_contacts=300, n_replicas=5, comm=comm)
    rows = [*run.forces, run.force, run.force_standard_error, run.holding, run.slips.drive, run.slips.replica]
    return [run.breaks, len(run.breaks_per_rank), [[float(x).hex() for x in row] for row in rows]]
"""


@pytest.fixture(scope="module")
def result():
    return toolkit.run(SCENE)


def test_slips_are_compared_one_by_one(result):
    beside = slips_beside(result)
    assert [slip.have for slip in beside] == [12] * 3 and result.success
    for slip in beside:
        own = result.eq.slips.drive[result.eq.slips.number == slip.number]
        assert (
            slip.mean_drive == own.mean() and slip.drive == result.master.slips.drive[slip.number]
        )
        assert abs(slip.mean_drive - slip.drive) < 0.1 and abs(slip.mean_drop - slip.drop) < 0.05
    lines = report(result)
    assert any("36 of eq in 12 replicas" in line for line in lines)
    assert not any(line.startswith("eq less master") for line in lines)


def test_a_result_comes_back_from_its_folder(result, tmp_path):
    from toolkit.results.files import save

    save(result, tmp_path)
    read = toolkit.load(tmp_path)
    for field in dataclasses.fields(result.eq):
        if field.name not in ("histograms", "breaks_per_rank", "slips"):
            assert np.all(getattr(read.eq, field.name) == getattr(result.eq, field.name)), (
                field.name
            )
    for field in dataclasses.fields(result.eq.slips):
        assert np.array_equal(getattr(read.eq.slips, field.name), getattr(result.eq.slips, field.name))
    assert (tmp_path / "picture.png").stat().st_size > 10_000
    told = json.loads((tmp_path / "summary.json").read_text())["eq"]
    assert told["slips"] == 36 and told["slip_fraction"] == 0.3 and len(told["slips_beside"]) == 3
    assert np.all(read.time == result.time) and read.time[-1] == 7.0


KILLED = """
import os, signal, sys
import eq_model
from toolkit.command import main
real = eq_model.CoupledEnsemble.__iter__

def mortal(self):
    for done in real(self):
        if done[0] >= 7 * 400 and sys.argv[2] == "killed":
            os.kill(os.getpid(), signal.SIGKILL)
        yield done

eq_model.CoupledEnsemble.__iter__ = mortal
sys.exit(main(["run", "scene.toml", "--out", sys.argv[1], "--checkpoint", "1e-9"]))
"""


def test_a_run_that_is_killed_goes_on_to_the_same_bits(result, tmp_path):
    (tmp_path / "scene.toml").write_text(to_toml(SCENE))
    for fate, code in (("killed", -signal.SIGKILL), ("whole", 0)):
        words = [sys.executable, "-c", KILLED, "out", fate]
        done = subprocess.run(
            words,
            cwd=tmp_path,
            env=clean_environment(),
            capture_output=True,
            text=True,
            timeout=HANGS,
        )
        assert done.returncode == code, done.stderr
    assert "went on from a checkpoint of 2,400 contacts" in done.stdout
    read = toolkit.load(tmp_path / "out")
    for name in ("forces", "positions", "avalanches", "breaks"):
        assert np.all(getattr(read.eq, name) == getattr(result.eq, name))
    assert np.array_equal(read.eq.slips.drive, result.eq.slips.drive)


def test_an_ensemble_alone_and_what_a_dry_run_tells(capsys):
    from toolkit.command import main

    alone = {name: table for name, table in SCENE.items() if name != "master"}
    lines = report(toolkit.run(alone))
    assert any(line.startswith("slips   36 in 12 replicas") for line in lines)
    assert main(["run", "stick-slip-contacts", "--dry-run"]) == 0
    told = capsys.readouterr().out
    assert "100,000 in 200 replicas" in told and "500 contacts tell" in told


@pytest.mark.parametrize(
    ("table", "rule"),
    [
        ({"eq": {"tolerance": 1e-3}}, "eq.tolerance = 0.001: is of independent contacts"),
        ({"eq": {"histograms": [7.0]}}, "eq.histograms"),
        ({"eq": {"slip_fraction": 2.0}}, "eq.slip_fraction = 2.0: must be at most 1"),
        ({"drive": {"to": 7.0, "points": 71}, "eq": {"slip_fraction": 0.1}}, "eq.slip_fraction"),
        ({"drive": {"turns": [3.0, 1.0], "points": 71, "spring": 0.7}}, "drive.turns"),
        (
            {"contacts": SCENE["contacts"] | {"thermal": {"law": "soft", "temperature": 0.1}}},
            "contacts.thermal: ",
        ),
    ],
)
def test_what_is_not_taken_is_refused_before_any_work(table, rule):
    scene = {name: own for name, own in (SCENE | table).items() if name != "master"}
    with pytest.raises(InputError, match=rule.replace("[", r"\[")):
        toolkit.run(scene)


def test_bits_do_not_depend_on_the_number_of_ranks(mpirun):
    program = (
        PROGRAM + "\nfrom mpi4py import MPI\nevery = MPI.COMM_WORLD.gather(told(MPI.COMM_WORLD))\n"
    )
    program += "if MPI.COMM_WORLD.Get_rank() == 0:\n    print(json.dumps(every))\n"
    here = {}
    exec(PROGRAM, here)
    alone = here["told"](None)
    for ranks in (2, 3):
        done = mpirun(ranks, program)
        every = json.loads(done.stdout)
        assert len(every) == ranks
        for breaks, shared, rows in every:
            assert (breaks, shared) == (alone[0], ranks) and rows == alone[2]
