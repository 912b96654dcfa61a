"""README.md and docs: the code runs, the scenes are scenes, the links lead somewhere."""

import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import master
import toolkit
from toolkit.scene.tables import read_table

ROOT = Path(__file__).parents[1]
README, DOCS = ROOT / "README.md", ROOT / "docs"
PAGES = [README, *sorted(DOCS.glob("*.md"))]


def text(page: Path) -> str:
    return page.read_text(encoding="utf-8")


def blocks(page: Path, kind: str) -> list[str]:
    return re.findall(rf"```{kind}\n(.*?)```", text(page), re.DOTALL)


def heading(line: str) -> str:
    """The address that a heading has on the site."""
    return re.sub(r"[\s-]+", "-", re.sub(r"[^\w\s-]", "", line.lower())).strip("-")


def test_readme_is_a_door() -> None:
    assert len(text(README).splitlines()) <= 150
    (code,) = blocks(README, "python")
    names: dict[str, Any] = {}
    exec(compile(code.replace("n_contacts=100_000", "n_contacts=100"), "README.md", "exec"), names)
    assert names["s"].success and names["s"].force_error < 1e-8
    assert names["e"].force.shape == names["s"].force.shape
    (scene,) = blocks(README, "toml")
    assert toolkit.load_scene(tomllib.loads(scene)).contacts.thresholds.mean() == 1.0


def test_named_scenes_are_shipped() -> None:
    commands = r"mesofriction (?:run|thresholds|precision|compare) ([-a-z ]+?) *(?:#|$)"
    named = {
        name
        for page in PAGES
        for names in re.findall(commands, text(page), re.MULTILINE)
        for name in names.split()
    }
    assert len(named) >= 4
    for name in named:
        toolkit.load_scene(name)


def test_scene_of_a_measured_surface() -> None:
    (surface,) = blocks(DOCS / "origins.md", "toml")
    assert read_table(tomllib.loads(surface)).contacts.thresholds["surface"]["file"] == "scan.di"


def test_examples_of_extending_run() -> None:
    names: dict[str, Any] = {}
    for code in blocks(DOCS / "extending.md", "python"):
        exec(compile(code, "extending.md", "exec"), names)
    law = names["half_cosine"](1.0)
    x = np.array([0.2, 0.7])
    np.testing.assert_allclose(law.cdf(x), x + np.sin(np.pi * x) / np.pi, rtol=1e-12)
    held = master.steady_state(names["contacts"])
    assert held.success and 0.0 < held.force < law.moment(2) / (2.0 * law.mean())


def test_the_glossary_is_short() -> None:
    rows = [line for line in text(DOCS / "glossary.md").splitlines() if line.startswith("| ")]
    assert len(rows) - 1 <= 25


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page: Path) -> None:
    for target, anchor in re.findall(r"\]\(([^)#:]+)(?:#([^)]*))?\)", text(page)):
        file = page.parent / target
        assert file.exists(), target
        if anchor:
            assert anchor in map(heading, re.findall(r"^#+ (.*)$", text(file), re.MULTILINE)), (
                anchor
            )
