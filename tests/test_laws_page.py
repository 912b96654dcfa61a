"""docs/laws.md: every call in its table gives what the page says, every scene it names is shipped."""

import importlib.util
import re
from pathlib import Path

import numpy as np
import pytest

import master
import origins
from toolkit.scene.scene import shipped_scenes

DOCS = Path(__file__).parents[1] / "docs"
PAGE = (DOCS / "laws.md").read_text(encoding="utf-8")
ROW = re.compile(r"^\| [^|]+ \| `(?P<call>[^`]+)` \| (?P<answer>[-\d.e]+) \|$", re.MULTILINE)
ROWS = [(match["call"], match["answer"]) for match in ROW.finditer(PAGE)]


@pytest.fixture(scope="module")
def names() -> dict:
    spec = importlib.util.spec_from_file_location("laws", DOCS / "laws.py")
    assert spec is not None and spec.loader is not None
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    return {**vars(origins), **vars(master), **vars(script)}


def test_every_row_is_read() -> None:
    table = PAGE.split("## Numbers")[1]
    assert len(ROWS) == len([line for line in table.splitlines() if line.startswith("|")]) - 2 > 15


@pytest.mark.parametrize(("call", "answer"), ROWS)
def test_row(call: str, answer: str, names: dict) -> None:
    digits = len(re.sub(r"^[-0.]*|[.]|e.*$", "", answer))
    value = float(eval(call, names))
    assert abs(value - float(answer)) <= 0.5001 * 10.0 ** (1 - max(digits, 9)) * abs(value)


def test_scenes_named_are_shipped() -> None:
    told = PAGE.split("Shipped scenes:")[1].split("Where the paper")[0]
    named = re.findall(r"`([-a-z]+)`", told)
    assert len(named) == 7 and set(named) <= set(shipped_scenes())


def test_transients_keep_mass_or_sign_and_not_both(names: dict) -> None:
    found = names["transient"](end=1.0, step=0.01)
    sign, mass = found["positivity"], found["mass"]
    assert 0.75 < sign.outrun < 0.85 and sign.mass_defect[-1] > 0.06 and sign.positivity_defect.max() == 0.0
    assert mass.path[-1] < 0.85 and np.abs(mass.mass_defect).max() < 1e-12
