"""Which solver takes which law: each cell of the table in docs/laws.md, called."""

import re
from pathlib import Path
from typing import Any

import pytest
from scipy import stats

import master
import origins
from eq_model.blocks import Blocks
from eq_model.coupled.ensemble import Replicas
from eq_model.engine import Engine
from origins import Ageing, Contacts, Delay, Thermal
from origins.drive import Drive
from origins.errors import InputError

PAGE = (Path(__file__).parents[1] / "docs" / "laws.md").read_text(encoding="utf-8")
WIDE, FRESH = origins.gaussian(1.0, 0.2), origins.gaussian(0.5, 0.05)
STRETCHED, DELAY = origins.gaussian_start(0.1, 0.02), Delay(0.1)
HOT, PAPERS = Thermal("soft", 1.0), Thermal("soft", 1.0, closure="paper")


def ageing(closure: Any, towards: Any = None) -> Ageing:
    return Ageing(towards or origins.gaussian(1.0, 0.02), 5e-4, closure)


# the first words of a row: contacts with that law, and what the row with a * takes beside it
ROWS: dict[str, tuple[Contacts, dict[str, Any]]] = {
    "none": (Contacts(WIDE), {}),
    'heat, closure "exact"': (Contacts(WIDE, thermal=HOT), {"delay": DELAY}),
    'heat, closure "paper"': (Contacts(WIDE, thermal=PAPERS), {"delay": DELAY}),
    'ageing, closure "exact"': (Contacts(FRESH, ageing=ageing("exact")), {"delay": DELAY}),
    'ageing, closure "paper"': (Contacts(FRESH, STRETCHED, ageing=ageing("paper")), {}),
    "delay": (Contacts(WIDE, delay=DELAY), {"stiffness": "linked"}),
    "re-forming": (Contacts(WIDE, reforming=STRETCHED), {"thermal": HOT}),
    "linked": (Contacts(WIDE, stiffness="linked"), {"thermal": HOT}),
    "growing grains": (Contacts(origins.growing_grains(1.0, 1.0, age=4.0)), {}),
    "strengthening": (Contacts(origins.strengthening(WIDE, 0.03, 1.0)), {"thermal": HOT}),
}
FORWARD, TURNS = [0.0, 0.05], [0.0, 0.05, 0.03]
SPEEDS = {"time": [0.0, 0.2, 0.3], "path": [0.0, 0.2, 0.4], "velocity": None}
INSTANT, RESET = {"slip": "instant"}, {"slip": "reset"}
FORWARD_ONLY = [(True, {}, {}), (False, {}, {"path": TURNS})]
# what a cell says: whether the row's contacts are taken with these laws in place of theirs, on this drive
CELLS: dict[str, list[tuple[bool, dict[str, Any], dict[str, Any]]]] = {
    "yes": [(True, {}, {"path": TURNS})],
    "no": [(False, {}, {})],
    "without heat, towards a `gaussian`": [
        (True, {}, {"path": TURNS}),
        (False, {"thermal": HOT}, {}),
        (False, {"ageing": ageing("exact", stats.lognorm(0.1))}, {}),
    ],
    "forward at one speed, a start with a width": [
        *FORWARD_ONLY,
        (False, {}, SPEEDS),
        (False, {"start": None}, {}),
    ],
    '"reset"; "instant" without delay': [
        (True, {}, RESET | {"path": TURNS}),
        (True, {"delay": DELAY}, RESET),
        (True, {}, INSTANT | {"path": TURNS}),
        (False, {"delay": DELAY}, INSTANT),
        (False, {}, {"slip": "reform-after"}),
    ],
    '"instant" without delay': [
        (True, {}, INSTANT | {"path": TURNS}),
        (False, {"delay": DELAY}, INSTANT),
        (False, {}, RESET),
    ],
    "yes; with heat at one speed": [
        (True, {}, {"path": TURNS}),
        (True, {"thermal": HOT}, {}),
        (False, {"thermal": HOT}, SPEEDS),
    ],
}


def table() -> list[tuple[str, list[str]]]:
    """The first cell of each row, and the others."""
    (rows,) = re.findall(r"^\| law \|.*\n\|[-|]+\n((?:\|.*\n)+)", PAGE, re.MULTILINE)
    cells = [[cell.strip() for cell in row.strip("|").split("|")] for row in rows.splitlines()]
    return [(first, others) for first, *others in cells]


def takes(solver: str, contacts: Contacts, drive: dict[str, Any]) -> bool:
    """Whether the solver takes these contacts on this drive: the master equation solves it; the ensemble, whose kernels
    take long to compile, is made."""
    asked = {"path": FORWARD, "velocity": 1.0} | drive
    path = asked.pop("path")
    if solver == "simulate":
        kind: Any = Replicas if "spring" in asked else Engine
        least = None if "spring" in asked else ()  # of a slip; points of histograms
    try:
        if solver == "solve":
            return bool(master.solve(contacts, path, 0.1, **asked).success)
        kind(contacts, Drive(path, **asked), Blocks(200, 100), 1, least)
    except InputError:
        return False
    return True


@pytest.mark.parametrize(("first", "cells"), table(), ids=[first for first, _ in table()])
def test_each_cell_says_what_its_solver_takes(first: str, cells: list[str]) -> None:
    ((contacts, besides),) = [ROWS[words] for words in ROWS if first.startswith(words)]
    for column, cell in enumerate(cells):
        solver, spring = ("solve", "simulate")[column // 2], {"spring": 0.7} if column % 2 else {}
        for taken, laws, drive in CELLS[cell]:
            assert takes(solver, contacts.replace(**laws), spring | drive) == taken, (column, cell)
        if first.endswith("*") and besides and cell == "yes":
            assert takes(solver, contacts.replace(**besides), spring), (column, besides)
