"""Histograms' counts, in memory, in checkpoints and in result files."""

import json
import os
import signal
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import eq_model
import origins
import toolkit
from origins import Contacts, Delay, InputError
from toolkit.command import main
from toolkit.results.files import save
from toolkit.running.checkpoint import BLOCKS, read_state, write_state
from toolkit.scene.tables import to_toml

WAITING = Contacts(origins.gaussian(1.0, 0.2), delay=Delay(0.1))
PATH = np.linspace(0.02, 1.5, 6)
SCENE: dict[str, Any] = {
    "contacts": {"thresholds": {"kind": "gaussian", "mean": 1.0, "std": 0.2}, "delay": {"time": 0.1}},
    "drive": {"to": 1.5, "points": 601},
    "eq": {"contacts": 900, "replicas": 1, "seed": 3},
}


def test_contacts_are_counted_at_the_points_asked_for_in_any_order() -> None:
    found = eq_model.simulate(WAITING, PATH, n_contacts=30_000, seed=2, histograms=[3, 0, 5, 3]).histograms
    assert [one.point for one in found] == [3, 0, 5, 3]
    run = eq_model.simulate(WAITING, PATH, n_contacts=30_000, seed=2, histograms=np.arange(6))
    for one in found:
        other = run.histograms[one.point]
        assert np.array_equal(one.stretches, other.stretches) and np.array_equal(one.thresholds, other.thresholds)
        shares = one.stretches * np.diff(one.stretch_edges)
        assert shares.sum() == pytest.approx(run.holding[one.point]) and one.count == round(30_000 * shares.sum())
        middle = 0.5 * (one.stretch_edges[1:] + one.stretch_edges[:-1])
        assert (shares * middle).sum() == pytest.approx(run.force[one.point], abs=np.diff(middle).max())
        # none is stretched beyond its threshold
        reached = np.flatnonzero(one.stretches)[-1]
        assert one.stretch_edges[reached] < one.threshold_edges[np.flatnonzero(one.thresholds)[-1] + 1]


def test_more_points_than_fit_are_refused() -> None:
    path = np.linspace(0.0, 1.0, 2001)
    with pytest.raises(InputError, match=r"^histograms = .*2001 points.*: must be at most 2000"):
        eq_model.simulate(WAITING, path, n_contacts=10, histograms=np.arange(2001))


def test_another_versions_checkpoint_is_refused_in_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene = tmp_path / "scene.toml"
    scene.write_text(to_toml({"title": "old"} | asking(1)))
    home = tmp_path / "out" / "checkpoint"
    home.mkdir(parents=True)
    old = {"sums": np.zeros((2, 9)), "counts": np.zeros(2), "identity": json.dumps({"version": "1.0"}), "run_time": 1.0}
    np.savez(home / "000-rank-00000.npz", done=np.zeros((0, 2)), **old)
    assert main(["run", str(scene), "--out", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and "is a checkpoint of an older version" in said and "remove" in said


def asking(points: int) -> dict[str, Any]:
    return SCENE | {"eq": SCENE["eq"] | {"histograms": np.linspace(0.0, 1.5, 601)[1 : points + 1].tolist()}}


def test_no_damage_of_a_checkpoint_goes_unseen(tmp_path: Path) -> None:
    """What is read is what was written, or nothing: single bits, above all of headers, and ends cut off."""
    ensemble = eq_model.Ensemble(WAITING, PATH[:2], n_contacts=300, histograms=[1])
    list(ensemble)
    file, told = tmp_path / "state.npz", {"scene": "a", "version": "1", BLOCKS: "any"}
    write_state(file, ensemble.state, told)
    whole, draws = file.read_bytes(), np.random.default_rng(4)

    def contents() -> Any:
        found = read_state(file)
        if found is None:
            return None
        state, named = found
        done = [(part.start, part.stop) for part in state.done]
        held = state.counts.tobytes()
        return state.sums.tobytes(), state.sums.shape, held, state.breaks, state.steps, done, state.run_time, named

    right, damaged = contents(), 0
    begins = [place for place in range(len(whole)) if whole.startswith((b"PK", b"\x93NUMPY"), place)]
    places = [place + draws.integers(0, 140) for place in begins for _ in range(8)]
    for place in [*places, *draws.integers(0, len(whole), 40)]:
        if place < len(whole):
            file.write_bytes(whole[:place] + bytes([whole[place] ^ 1 << draws.integers(8)]) + whole[place + 1 :])
            found = contents()
            damaged += found is None
            assert found in (None, right)
    assert damaged > 80
    for end in draws.integers(0, len(whole), 20):
        file.write_bytes(whole[:end])
        assert contents() is None


def test_an_interrupt_while_results_are_written_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import h5py

    result = toolkit.run(asking(2))
    real = h5py.Group.create_dataset

    def create(self: h5py.Group, *arguments: Any, **named: Any) -> Any:
        signal.raise_signal(signal.SIGINT)
        return real(self, *arguments, **named)

    monkeypatch.setattr(h5py.Group, "create_dataset", create)
    with pytest.raises(KeyboardInterrupt):
        save(result, tmp_path / "out")
    assert os.listdir(tmp_path) == [] and signal.getsignal(signal.SIGINT) is signal.default_int_handler
