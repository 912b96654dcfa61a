"""docs/limits.md: short rows, and what it says is refused is refused, with a line that says what to do."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import stats

import eq_model
import master
import origins

PAGE = (Path(__file__).parents[1] / "docs" / "limits.md").read_text(encoding="utf-8")
PATH = np.linspace(0.0, 5.0, 51)
PLAIN = origins.Contacts(origins.gaussian(1.0, 0.2))
HOT = PLAIN.replace(thermal=origins.Thermal("soft", 0.1))
AGEING = PLAIN.replace(ageing=origins.Ageing(origins.gaussian(1.5, 0.2), 1e-3))
GRAINS = origins.growing_grains(1.0, 4.0, age=4.0)
WARM_GRAINS = origins.Contacts(GRAINS, thermal=HOT.thermal)
LATE, LINKED = PLAIN.replace(delay=origins.Delay(1e3)), PLAIN.replace(stiffness="linked")
WARM_EXACT = origins.Contacts(origins.identical(1.0), thermal=HOT.thermal)
WARM_AGEING = AGEING.replace(thermal=HOT.thermal)
HEAVY: dict[str, Any] = {"spring": 1.0, "mass": 0.1, "damping": 0.1}
FEW: dict[str, Any] = {"n_contacts": 50, "n_replicas": 2, "seed": 1}
GROWING = origins.Contacts(origins.strengthening(origins.gaussian(1.0, 0.2), beta=1e-9, time=1.0))
SOFT: dict[str, Any] = {"spring": 1.0, "slip": "instant"}
LONG = [0.0, 1.5e8]  # 7.5e9 breaks of 50 contacts

# words of the row, the call that it tells of, and a part of its refusal
REFUSED: list[tuple[str, Callable[[], object], str]] = [
    ("in an `[eq]` with a `spring`", lambda: eq_model.simulate(AGEING, PATH, **HEAVY, **FEW), "ageing"),
    ("in an `[eq]` with a `spring`", lambda: eq_model.simulate(AGEING, PATH, spring=1.0, **FEW), "ageing"),
    ("whose drive turns back", lambda: eq_model.simulate(PLAIN, [0.0, 3.0, 1.0], **HEAVY, **FEW), "turn"),
    ("`mass` in heat, ageing", lambda: master.solve(PLAIN.replace(reforming=-0.2), [1e4], **HEAVY), "steps of time"),
    ("with another law than a delay", lambda: master.solve(WARM_EXACT, PATH, **HEAVY), "a width"),
    ("`mass` and linked stiffness", lambda: master.solve(LINKED, PATH, **HEAVY), "stiffness"),
    ("5e9 with growth", lambda: eq_model.simulate(GROWING, LONG, **SOFT, **FEW), "than 5e+09"),
    ("7e9 with `mass`", lambda: eq_model.simulate(GROWING, LONG, **HEAVY, **FEW), "most 7e+09"),
    ("ageing with heat", lambda: master.solve(WARM_AGEING, PATH), "use eq_model"),
    ("growing grains with heat on a path", lambda: master.solve(WARM_GRAINS, [0.0, 1.0, -1.0]), "use eq_model"),
    ("begins above 0 or ends", lambda: origins.Ageing(origins.rectangular(0.5, 1.0), 1e-3), "ends at"),
    ("a law without a finite mean", lambda: origins.Contacts(stats.pareto(0.9)), "finite mean"),
    ("`persson` with centre", lambda: origins.persson(200.0, 1.0), "take gaussian"),
    ("nearer to 1/x", lambda: master.steady_state(origins.Contacts(origins.lubricated(1.0, power=-0.97))), "1e-290"),
    ("wait for 400 lives", lambda: master.decoherence_spectrum(LATE), "400"),
    ("beyond 1e±100", lambda: master.solve(HOT, PATH, velocity=1e120), "another unit"),
]  # fmt: skip


def test_rows_are_few_and_short() -> None:
    rows = re.findall(r"^\| (?!what \|).*\|$", PAGE, re.MULTILINE)
    assert 30 <= len(rows) <= 60 and max(map(len, rows)) <= 140
    assert all(row.count(" | ") == 2 for row in rows)


@pytest.mark.parametrize(("row", "call", "why"), REFUSED, ids=[row for row, *_ in REFUSED])
def test_what_is_said_to_be_refused(row: str, call: Callable[[], object], why: str) -> None:
    assert any(row in line and "refused" in line for line in PAGE.splitlines())
    with pytest.raises(origins.InputError, match=re.escape(why)) as told:
        call()
    assert "\n" not in str(told.value)
