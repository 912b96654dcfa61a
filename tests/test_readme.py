"""README.md: its code runs, its scenes are scenes, its links lead somewhere."""

import re
import tomllib
from pathlib import Path
from typing import Any

import toolkit
from toolkit.scene.tables import read_table

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
README = PAGES[0].read_text(encoding="utf-8")


def blocks(kind: str) -> list[str]:
    return re.findall(rf"```{kind}\n(.*?)```", README, re.DOTALL)


def test_python_runs() -> None:
    code = blocks("python")[0].replace("n_contacts=100_000", "n_contacts=100")
    names: dict[str, Any] = {}
    exec(compile(code, "README.md", "exec"), names)
    assert names["s"].success and names["s"].force_error < 1e-8 and names["e"].force.shape == names["s"].force.shape


def test_scenes_are_scenes() -> None:
    surface, gaussian = (tomllib.loads(text) for text in blocks("toml"))
    assert read_table(surface).contacts.thresholds["surface"]["file"] == "scan.di"
    assert toolkit.load_scene(gaussian).contacts.thresholds.mean() == 1.0
    named = re.findall(r"mesofriction (?:run|thresholds|precision|compare) ([-a-z ]+?) *(?:#|$)", README, re.MULTILINE)
    shipped = {name for names in named for name in names.split()}
    assert len(shipped) >= 4
    for name in shipped:
        toolkit.load_scene(name)


def test_links_lead_somewhere() -> None:
    for page in PAGES:
        for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8")):
            assert (page.parent / target).exists(), (page.name, target)
