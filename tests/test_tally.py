"""Histograms' counts in a file: the same as if they were held, whatever interrupts, and nothing but a block's held."""

import os
import pickle
import resource
import signal
import tempfile
import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import eq_model
import origins
import toolkit
from eq_model import tally
from eq_model.histogram import BINS, Histogram, Made
from eq_model.tally import Tally
from origins import Contacts, Delay, InputError
from toolkit.command import main
from toolkit.files import _write_histograms, save
from toolkit.forecast import forecast, lines
from toolkit.running import open_checkpoint, solve
from toolkit.state_file import read_state, write_state
from toolkit.toml import to_toml
from toolkit.untold import Untold

WAITING = Contacts(origins.gaussian(1.0, 0.2), delay=Delay(0.1))
PATH = np.linspace(0.02, 1.5, 6)
SCENE: dict[str, Any] = {
    "contacts": {"thresholds": {"kind": "gaussian", "mean": 1.0, "std": 0.2}, "delay": {"time": 0.1}},
    "drive": {"to": 1.5, "points": 601},
    "eq": {"contacts": 900, "replicas": 1, "seed": 3},
}


@pytest.fixture(params=["held", "file"])
def place(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """Where counts are, in parts that end within a histogram."""
    if request.param == "file":
        monkeypatch.setattr(tally, "_ASIDE", 0)
    monkeypatch.setattr(tally, "PART", 5000 * 4)
    return str(request.param)


@pytest.fixture
def files(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Descriptors of the temporary files, as they are opened."""
    opened, real = [], tempfile.TemporaryFile

    def noted(**how: Any) -> Any:
        file = real(**how)
        opened.append(file.fileno())
        return file

    monkeypatch.setattr(tempfile, "TemporaryFile", noted)
    return opened


def counts(found: Tally) -> Any:
    whole = np.concatenate([*found.parts(), np.empty(0, found.dtype)])
    for point in range(found.points):
        assert np.array_equal(found.at(point).ravel(), whole.reshape(found.points, -1)[point])
    return whole.reshape(-1, 2, BINS)


def some(seed: int, points: int = 3) -> Any:
    return np.random.default_rng(seed).integers(0, 70_000, (points, 2, BINS)).astype(np.uint32)


@pytest.mark.parametrize("most", [10**6, 1 << 32])
def test_tallies_are_values(place: str, most: int, files: list[int]) -> None:
    """Each is what it was, however many came after it, and what none refers to gives its place to the next."""
    first = Tally.zeros(3, most)
    kept, plain, now = [first], [np.zeros((3, 2, BINS), np.int64)], first
    for seed in range(6):
        now = now.plus(some(seed))
        kept.append(now)
        plain.append(plain[-1] + some(seed))
    kept.append(first.plus(some(7)).joined(now))
    plain.append(plain[-1] + some(7))
    for found, expected in zip([*kept, *pickle.loads(pickle.dumps(kept))], [*plain, *plain], strict=True):
        assert np.array_equal(counts(found), expected)
    size, most_of_file = tally.sizes(3, most)
    assert now.dtype.itemsize == size / (3 * 2 * BINS) and (most_of_file > 0) == (place == "file")
    if place == "file":
        assert os.fstat(files[0]).st_size == 9 * size
    now = Tally.zeros(3, most)
    for seed in range(6):
        now = now.plus(some(seed))
    assert np.array_equal(counts(now), plain[6])
    if place == "file":
        assert os.fstat(files[-1]).st_size == most_of_file == 2 * size
    with pytest.raises(InputError, match="other histograms"):
        now.joined(Tally.zeros(2, most))


def test_the_histograms_are_those_of_a_plain_count(place: str) -> None:
    asked: dict[str, Any] = {"n_contacts": 1500, "seed": 2, "histograms": [3, 0, 5, 3]}
    ensemble = eq_model.Ensemble(WAITING, PATH, **asked)
    plain = np.zeros((4, 2, BINS), np.int64)
    for first in range(0, 1500, 400):
        plain += ensemble._engine.follow(range(first, min(first + 400, 1500)))[1]
    found = eq_model.simulate(WAITING, PATH, **asked).histograms
    # counted in the order in which the slider comes there
    for one, (held, thresholds) in zip(found, plain[[1, 0, 3, 2]], strict=True):
        assert one.count == held.sum() == thresholds.sum() > 100
        for density, edges, expected, of in (
            (one.stretches, one.stretch_edges, held, 1500),
            (one.thresholds, one.threshold_edges, thresholds, one.count),
        ):
            assert np.abs(density * np.diff(edges) * of - expected).max() < 1e-9
    assert np.array_equal(found[0].stretches, found[3].stretches)


@pytest.fixture
def short_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("eq_model.layout.cut", lambda part, size: (part[:300], part[300:]))


@pytest.mark.parametrize(
    ("error", "told"), [(KeyboardInterrupt, None), (OSError(28, "No space left on device"), "histograms: .* No space")]
)
def test_whatever_ends_the_adding_whole_blocks_are_left(
    error: Any, told: str | None, short_blocks: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In each of the two writes of the second block, half of which is done."""
    monkeypatch.setattr(tally, "_ASIDE", 0)
    monkeypatch.setattr(tally, "PART", 100_000)
    asked: dict[str, Any] = {"histograms": np.arange(6)}
    whole = [eq_model.simulate(WAITING, PATH, n_contacts=n, **asked) for n in (300, 900)]
    real, left = os.pwrite, 0

    def pwrite(file: int, data: Any, begin: int) -> int:
        nonlocal left
        left -= 1
        if left == 0:
            real(file, data[: len(data) // 2], begin)
            raise error
        return real(file, data, begin)

    for write in (3, 4):
        ensemble = eq_model.Ensemble(WAITING, PATH, n_contacts=900, **asked)
        with monkeypatch.context() as patch:
            patch.setattr(os, "pwrite", pwrite)
            left = write
            with pytest.raises(InputError if told else error, match=told):
                list(ensemble)
        part = ensemble.result()
        assert part.contacts == 300
        rest = eq_model.Ensemble(WAITING, PATH, n_contacts=900, **asked, earlier=[ensemble.state])
        list(rest)
        for found, expected in zip([part, rest.result()], whole, strict=True):
            assert np.array_equal(found.force, expected.force)
            for one, other in zip(found.histograms, expected.histograms, strict=True):
                assert np.array_equal(one.stretches, other.stretches)
                assert np.array_equal(one.thresholds, other.thresholds)


def asking(points: int) -> dict[str, Any]:
    return SCENE | {"eq": SCENE["eq"] | {"histograms": np.linspace(0.0, 1.5, 601)[1 : points + 1].tolist()}}


def test_a_blocks_counts_alone_are_held(short_blocks: None, files: list[int], tmp_path: Path) -> None:
    """On the way, in checkpoints, as a result, and gone on with from a checkpoint; room on the disk is as foretold."""
    peaks = []
    for points in (300, 600):
        scene = toolkit.load_scene(asking(points))
        kept = open_checkpoint(tmp_path / str(points), scene, None, 1e-9)
        for _ in range(2):
            tracemalloc.start()
            result, _ = solve(scene, None, None, kept)
            assert result.eq is not None and sum(one.count for one in result.eq.histograms) > 800 * points
            peaks.append(tracemalloc.get_traced_memory()[1])
            tracemalloc.stop()
    each = 2 * BINS * 4
    assert peaks[0] < 300 * each + 6e6 and peaks[2] - peaks[0] < 300 * each * 1.02
    assert peaks[1] < peaks[0] + 4e6 and peaks[3] < peaks[2] + 4e6
    # in the file of the last run, and in the checkpoint
    temporary = os.fstat(files[-1]).st_size / 1e6
    (checkpoint,) = (tmp_path / "600" / "checkpoint").iterdir()
    told = forecast(scene)
    assert told.temporary == temporary and told.kept < checkpoint.stat().st_size / 1e6 < told.kept + 0.2
    assert f"disk         {temporary:.0f} MB in {tempfile.gettempdir()} and 20 MB in its checkpoint" in lines(told)[4]


def test_no_damage_of_a_checkpoint_goes_unseen(tmp_path: Path) -> None:
    """What is read is what was written, or nothing: single bits, above all of headers, and ends cut off."""
    ensemble = eq_model.Ensemble(WAITING, PATH[:2], n_contacts=300, histograms=[1])
    list(ensemble)
    file, told = tmp_path / "state.npz", {"scene": "a", "version": "1"}
    write_state(file, ensemble.state, told)
    whole, draws = file.read_bytes(), np.random.default_rng(4)

    def contents() -> Any:
        found = read_state(file)
        if found is None:
            return None
        state, named = found
        done = [(part.start, part.stop) for part in state.done]
        held = counts(state.counts).tobytes()
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


def test_result_files_are_written_as_histograms_are_made(tmp_path: Path) -> None:
    import h5py

    draws, sizes = np.random.default_rng(1), []

    def make(index: int) -> Histogram:
        sizes.append(path.stat().st_size)
        return Histogram(index, 0.0, *(draws.random(BINS) for _ in range(6)), 7)

    path = tmp_path / "result.h5"
    with Untold(path) as file, h5py.File(file, "w") as store:
        _write_histograms(store.create_group("eq"), Made(20, make), "length", file.check)
    written = np.diff([*sizes, path.stat().st_size])
    assert written.min() > 0.5 * written.mean() > 50_000


def test_an_interrupt_within_hdf5_waits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It would take the process down there."""
    result = toolkit.run(asking(2))
    real = Untold.write

    def write(self: Untold, data: Any) -> int:
        signal.raise_signal(signal.SIGINT)
        return real(self, data)

    monkeypatch.setattr(Untold, "write", write)
    with pytest.raises(KeyboardInterrupt):
        save(result, tmp_path / "out")
    assert os.listdir(tmp_path) == [] and signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_a_disk_without_room_is_said_at_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "scene.toml").write_text(to_toml({"title": "many histograms"} | asking(300)))
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    try:
        resource.setrlimit(resource.RLIMIT_FSIZE, (8_000_000, hard))
        status = main(["run", str(tmp_path / "scene.toml"), "--out", str(tmp_path / "out")])
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert status == 2 and os.listdir(tmp_path) == ["scene.toml"]
    assert capsys.readouterr().err == (
        f"mesofriction: eq.histograms: their counts take 20 MB in a temporary file in {tempfile.gettempdir()}: "
        "File too large; let TMPDIR name a folder with room, or ask for fewer histograms\n"
    )
