"""The table in docs/extremes.md: every call gives what the page says."""

import re
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

import master
import origins

PAGE = Path(__file__).parents[1] / "docs" / "extremes.md"
ROW = re.compile(r"^\| (?P<case>[^|]+) \| `(?P<call>[^`]+)` \| (?P<answer>[^|]+) \|$", re.MULTILINE)
ROWS = [match.groupdict() for match in ROW.finditer(PAGE.read_text(encoding="utf-8"))]
NAMES = {**vars(origins), "master": master, "pi": np.pi, "stats": stats}


def test_every_row_is_read() -> None:
    lines = [line for line in PAGE.read_text(encoding="utf-8").splitlines() if line.startswith("|")]
    assert len(ROWS) == len(lines) - 2 > 15


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row["call"])
def test_row(row: dict[str, str]) -> None:
    if row["answer"].startswith("refused: "):
        with pytest.raises(origins.InputError, match=re.escape(row["answer"].removeprefix("refused: "))):
            eval(row["call"], NAMES)
        return
    digits = re.sub(r"^[-0.]*|[.]|e.*$", "", row["answer"])
    value = float(eval(row["call"], NAMES))
    # what counts as zero differs from machine to machine
    allowed = 1e-14 if "round-off" in row["case"] else 0.5001 * 10.0 ** (1 - max(len(digits), 9)) * abs(value)
    assert abs(value - float(row["answer"])) <= allowed
