"""docs/histograms.md: its scene is run, its code too, and what it says of the fields holds."""

import re
import tomllib
from dataclasses import fields
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pytest

import toolkit
from eq_model.histogram import Histogram

PAGE = (Path(__file__).parents[1] / "docs" / "histograms.md").read_text(encoding="utf-8")


def test_the_page_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    matplotlib.use("Agg")
    (text,) = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
    tables = tomllib.loads(text)
    result = toolkit.run(tables | {"eq": tables["eq"] | {"contacts": 20_000, "replicas": 1}}, folder="hold-output")
    names: dict[str, Any] = {}
    for code in re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL):
        exec(compile(code, "histograms.md", "exec"), names)
    assert Path("histograms.png").read_bytes().startswith(b"\x89PNG")
    assert result.eq is not None
    before, after, later = result.eq.histograms
    assert [result.time[one.point] for one in (before, after, later)] == [2.0, 102.0, 102.5]
    (told,) = re.findall(r"Of the scene above (\d+) % ", PAGE)
    share = float(re.findall(r"^([\d.]+)% of all contacts are at x = 0$", capsys.readouterr().out, re.MULTILINE)[0])
    assert abs(share - float(told)) < 1.5
    # what a bin says of itself, and two of them
    own = names["rebinned"](after.stretch_edges, after.stretches, result.eq.contacts, 4096)
    assert np.allclose(own[1], after.stretches) and np.allclose(own[2], after.stretch_error)
    edges, density, _ = names["rebinned"](later.threshold_edges, later.thresholds, later.count, 2048)
    assert np.array_equal(edges, later.threshold_edges[::2])
    assert float((density * np.diff(edges)).sum()) == pytest.approx(1.0)
    assert float(later.stretches.sum() * np.diff(later.stretch_edges)[0]) == pytest.approx(later.count / 20_000)


def test_every_field_is_told() -> None:
    rows = " ".join(re.findall(r"^\| (`[^|]+) \|", PAGE, re.MULTILINE))
    assert {field.name for field in fields(Histogram)} <= set(re.findall(r"`(\w+)`", rows))
