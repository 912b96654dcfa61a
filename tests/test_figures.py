"""The paper's figures: each is drawn from a shipped scene, and its number agrees with an exact result."""

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import slow
from matplotlib.figure import Figure
from scenes import said

from toolkit.figures.found import Found
from toolkit.figures.paper import DRAW, in_words, labels_of
from toolkit.scene.paper import PAPER_FIGURES
from toolkit.scene.scene import SHIPPED, load_scene, shipped_scenes

DOCS = Path(__file__).parents[1] / "docs"
PAGE = (DOCS / "paper-figures.md").read_text(encoding="utf-8")
# number, label, scenes, what, here, exact
ROW = re.compile(
    r"^\| (\d+) \| (\w+) \| ([^|]+) \| ([^|]+) \| ([^|]+) \| ([^|]*) \|$", re.MULTILINE
)
ROWS = {row[1]: row for row in ROW.findall(PAGE)}
SLOW = (
    "A04",
    "A05",
    "A06",
    "A08c",
    "A08d",
    "A08e",
    "A02c",
    "A03c",
    "delta12",
)  # half a second to 9 s
EVERY = [slow(one, when=one in SLOW) for one in DRAW]


@pytest.mark.parametrize("label", EVERY)
def test_number_agrees(label: str) -> None:
    figure = Figure()
    found = DRAW[label](figure)
    assert found.agrees, found
    _, _, _, what, here, exact = ROWS[label]
    assert (what, here) == (found.what, found.in_digits(found.value))
    assert exact == ("" if found.exact is None else found.in_digits(found.exact))
    assert not found.remark or PAGE.count(f"| {PAPER_FIGURES[label].number}, {label} |") == 1
    assert len(figure.axes) >= 1 and all(axes.has_data() for axes in figure.axes)
    if found.exact is not None:  # a reference that is off would be seen
        assert found.off <= 0.01 * abs(found.exact)
        assert not replace(found, exact=found.exact + 2.1 * found.off).agrees
    else:
        assert label == "A06" and abs(found.value - 2.0692) < 5e-5 and "1.5" in found.paper


def test_a_number_is_told_to_the_digits_that_its_error_leaves() -> None:
    """Each to one digit more than the first of what it may be off by; that is rounded up."""
    found = Found("F", 0.867889318, 1.47e-3, 0.868025142, "closed form")
    assert in_words("A02a", 2, found)[0].endswith(
        "F: 0.8679, exact 0.8680 (closed form), within 0.002"
    )
    known = Found("F", -0.00536309214, 1e-13, -0.00536309215, "closed form")
    assert known.in_digits(known.value) == "-0.00536309" == known.in_digits(-0.00536309215)
    assert Found("v", 2.06923764, 0.0, None, "").in_digits(2.06923764) == "2.06924"
    assert Found("F", 0.2, 30.0, 0.1, "").in_digits(20.0) == "20"


def test_the_histograms_of_an_ensemble_are_as_high_as_its_peaks() -> None:
    """The start is a peak of 0.025: a bar as wide as that is a tenth too low."""
    DRAW["A02a"](figure := Figure())
    tops = [float(np.max(line.get_ydata())) for line in figure.axes[0].lines]
    assert tops[0] == pytest.approx(1.0 / (0.025 * np.sqrt(2.0 * np.pi)), rel=0.02)


def test_every_figure_with_data_has_its_scene_and_number() -> None:
    assert list(PAPER_FIGURES) == [*labels_of([])] and set(DRAW) == set(PAPER_FIGURES)
    assert [one.number for one in PAPER_FIGURES.values()] == list(range(2, 25))
    assert {name for one in PAPER_FIGURES.values() for name in one.scenes} <= set(shipped_scenes())
    assert list(ROWS) == list(PAPER_FIGURES)
    for label, one in PAPER_FIGURES.items():
        number, _, scenes, *_ = ROWS[label]
        assert int(number) == one.number and tuple(re.findall(r"`([^`]+)`", scenes)) == one.scenes
    # scenes say so themselves, except where the figure differs in one key
    for label, one in PAPER_FIGURES.items():
        text = (SHIPPED / f"{one.scenes[0]}.toml").read_text(encoding="utf-8")
        assert label[:3] in text, label


@pytest.mark.parametrize("page", sorted(one.name for one in DOCS.glob("*.md")))
def test_pages_name_figures_as_the_pdf_numbers_them(page: str) -> None:
    """A label of the LaTeX alone tells a reader nothing; those of the code map are of equations."""
    text = (DOCS / page).read_text(encoding="utf-8")
    text = re.sub(r"```.*?```|`[^`\n]*`", "", text, flags=re.DOTALL)
    labels = set(re.findall(r"\b(?:A\d\d[a-z]?|delta12|PcPersson)\b", text))
    for label in labels if page != "code-map.md" else ():
        number = PAPER_FIGURES[label].number
        assert re.search(rf"\b{number}(?: \(|, | \| ){label}\b", text), label


@pytest.mark.parametrize(
    ("name", "scene"),
    [("A08c", "kinetic-force"), ("fig 10", "kinetic-force"), ("figA12", "grains")],
)
def test_scenes_are_found_by_figures(name: str, scene: str) -> None:
    assert load_scene(name).name == scene


def test_command(capsys: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    status, out, _ = said(capsys, "figures", "A13b", "fig17")
    assert status == 0 and [line[:7] for line in out if line.startswith("Fig.")] == [
        "Fig. 17",
        "Fig. 23",
    ]
    found = json.loads(Path("paper-figures/figures.json").read_text(encoding="utf-8"))
    assert found["A13b"]["agrees"] and found["A13b"]["number"] == 23
    assert Path("paper-figures/A10b.png").stat().st_size > 10_000
    assert (
        "do not agree" not in Path("paper-figures/figures.txt").read_text(encoding="utf-8").lower()
    )
    assert said(capsys, "figures", "fig17", "--format", "bmp")[0] == 2
    wrong = Found("a number", 1.0, 1e-3, 2.0, "nothing")
    monkeypatch.setitem(DRAW, "A13b", lambda figure: wrong)
    status, out, _ = said(capsys, "figures", "A13b")
    assert status == 1 and "THEY DO NOT AGREE" in out[0]
    status, _, told = said(capsys, "figures", "A99")
    assert status == 2 and "is none of the paper's figures" in told[0]
    _, out, _ = said(capsys, "scenes")
    assert any(line.startswith("kinetic-force ") and "Fig. 10" in line for line in out)
