"""Scenes of contacts that age in the paper's closure: what (Q15) does not keep is told beside the force."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

import toolkit
from toolkit.command import main
from toolkit.commands import report
from toolkit.results.records import AgeingRecord
from toolkit.scene.scene import SHIPPED


@pytest.fixture(scope="module")
def outrun(tmp_path_factory) -> tuple[Path, int]:
    """The folder and the status of a run whose path goes on where contacts outrun P_c."""
    folder = tmp_path_factory.mktemp("ageing")
    text = (SHIPPED / "ageing-paper.toml").read_text()
    for old, new in (("to = 0.75", "to = 1.0"), ("std = 0.05", "std = 0.1"), ("points = 151", "points = 51")):
        assert old in text
        text = text.replace(old, new)
    (folder / "longer.toml").write_text(text)
    return folder / "out", main(["run", str(folder / "longer.toml"), "--out", str(folder / "out")])


def test_defects_are_kept_and_told(outrun: tuple[Path, int]) -> None:
    folder, status = outrun
    assert status == 1  # the tolerance is missed, and the results are written all the same
    found = toolkit.load(folder)
    aged = found.master
    assert isinstance(aged, AgeingRecord) and not aged.success
    assert aged.mass_defect.shape == aged.positivity_defect.shape == aged.path.shape
    before = aged.path < aged.outrun
    assert 0.5 < aged.outrun < 1.0
    assert np.abs(aged.mass_defect[before]).max() < 1e-5 < 1e-3 < aged.mass_defect[-1]
    told = json.loads((folder / "summary.json").read_text())["master"]
    assert told["largest_mass_defect"] == aged.mass_defect.max() and told["outrun"] == aged.outrun
    line = next(line for line in report(found) if line.startswith("(Q15)"))
    assert f"mass off by up to {aged.mass_defect.max():.1e}" in line and f"X = {aged.outrun:.4g}" in line


def test_defects_are_drawn(outrun: tuple[Path, int]) -> None:
    from matplotlib.figure import Figure

    found = toolkit.load(outrun[0])
    axes = Figure().subplots(1, 2)
    toolkit.plot(found, axes)
    assert "contacts outrun $P_c$ (Q15)" in [text.get_text() for text in axes[0].get_legend().get_texts()]
    assert (outrun[0] / "picture.png").stat().st_size > 10_000


def test_the_shipped_path_ends_before(tmp_path: Path, capsys) -> None:
    assert main(["run", "ageing-paper", "--out", str(tmp_path / "out")]) == 0
    assert "contacts never outrun it" in capsys.readouterr().out
    told = json.loads((tmp_path / "out" / "summary.json").read_text())["master"]
    assert told["success"] and told["outrun"] is None and told["largest_mass_defect"] < 1e-9
    assert math.isinf(toolkit.load(tmp_path / "out").master.outrun)  # type: ignore[union-attr]
