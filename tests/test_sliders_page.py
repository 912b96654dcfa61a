"""docs/sliders.md: every call in its table gives what the page says."""

import importlib.util
import re
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[1] / "docs"
PAGE = (DOCS / "sliders.md").read_text(encoding="utf-8")
ROWS = re.findall(r"^\| [^|]+ \| `static_force\(([^`]+)\)` \| ([\d.]+) \|$", PAGE, re.MULTILINE)


def test_every_row_is_read() -> None:
    assert len(ROWS) == PAGE.count("`static_force(") == 4


@pytest.mark.parametrize(("arguments", "answer"), ROWS)
def test_row(arguments: str, answer: str) -> None:
    spec = importlib.util.spec_from_file_location("sliders", DOCS / "sliders.py")
    assert spec is not None and spec.loader is not None
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    found = script.static_force(*(float(one) for one in arguments.split(",")))
    assert abs(found - float(answer)) < 1.5e-6  # its error, and the last digit's half
