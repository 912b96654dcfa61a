"""docs/code-map.md: for each equation of the paper the place in the code where it stands.

    python tests/code_map.py            # writes the page anew, but for its section on wrong numbers

A function or class says that an equation stands in it by the first lines of its docstring, up to
the first empty one: "... (paper, Eq. Q5a)" or "... (paper, Eqs. GW3 and GW4; more)". Numbers are
those that LaTeX counts in the paper (arXiv 1009.2856): each `equation`, and each line of an
`eqnarray` without a \\nonumber; in the appendices with the appendix's letter.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "code-map.md"
ROOMS = ("origins", "master", "eq_model", "toolkit")
EQUATIONS = """
1 Q14e, 2 Q5c, 3 Q6, 4 Q2, 5 Q3, 6 PcP, 7 Q4, 8 Q5a, 9 Q5b, 10 Q6b, 11 Q10, 12 Q11a, 13 Nik04,
14 Q11c, 15 Q11d, 19 PcPx2, 20 Q17, 21 Q18, 22 Q19, 23 Q20, 24 Q16x2, 28 Q16, 29 temper1,
30 temper2, 31 temper3, 32 temper4, 33 temper5, 34 temper8, 35 temper11, 36 temper9, 37 temper10,
38 temper12, 39 L, 40 B, 41 Q15, 42 fitFv, 43 fsvsxs, 44 PxPf, 45 GW1, 46 GW2, 47 GW3, 48 GW4,
49 PcPersson, 50 PcPersson2, 51 PcPersson3, 52 Pcrotateh, 53 Pcrotate, 54 LS1, 55 LS2, A1 eq15,
A2 eq15a, B1 Q14a, B2 Q14b, B3 Q14d, B4 Q14c, B5 Q22a, B6 Q22b, C1 Q3back, C2 Q4back, C3 Q5aback,
D1 Q5adelay, E1 Q7b, E2 Q6e
"""
# Label by number, in the paper's order; equations without a label (16 to 18, 25 to 27, 56, B7, B8)
# are steps from one of these to the next.
LABELS = dict(pair.split() for pair in EQUATIONS.replace("\n", " ").split(","))
# Equations that stand in several places: of (Q5a) a plain scheme, number conservation in plain steps, and the solver.
SEVERAL = {"Q5a"}
# Why an equation stands nowhere.
NOWHERE = {
    "PcPx2": "(PcP) the other way round: thresholds are given by P_c",
    "Q17": "a special start by hand; the general solution contains it",
    "Q18": "as (Q17)",
    "Q19": "as (Q17)",
    "Q20": "as (Q17)",
    "temper11": "(temper3) of soft contacts: one integral serves every law of rates",
    "temper12": "(temper3) of stiff contacts: one integral serves every law of rates",
    "fitFv": "a fit to the paper's curve",
    "Pcrotateh": "a rough fit to islands, whose own law is computed; it is a Weibull law, as (GW4)",
    "Q14a": "an example; any P_c is taken",
    "Q14b": "as (Q14a)",
    "Q14d": "as (Q14a)",
    "Q14c": "as (Q14a)",
    "Q22b": "the hazard that follows from (Q22a)",
}
# What a newcomer looks for first, and the functions or classes that answer, wherever they stand.
QUESTIONS = {
    "the force F(X) that (Q5a) gives: plainly; to a tolerance": (
        "master:explicit",
        "master:renewal_force",
        "master:solve",
        "master:March",
    ),
    "number conservation solved at the nodes of a panel": ("master:solve_batch",),
    "force_error of a path; of a panel; of steps in time": (
        "master:solve_rigid",
        "master:solve_batch",
        "master:extrapolated",
    ),
    "F_k, the force of steady sliding; at many speeds": (
        "master:Cycle.force",
        "master:kinetic_curve",
    ),
    "K*, the critical spring; where F falls most": ("master:propensity", "master:extremes"),
    "a slider on a spring: solved; followed at T = 0, by laws in time; its slips": (
        "master:solve_soft",
        "master:ColdSlider.follow",
        "master:refined",
        "master:slips_of",
    ),
    "slips of a soft slider; where laws depend on time": ("master:ColdSlider", "master:Slider"),
    "stick-slip, smooth or undecided: of a solution; the same by its slips; swings that are none": (
        "master:regime",
        "master:_by_slips",
        "master:unfed_swings",
    ),
    "the same in one word; for a verdict": (
        "toolkit:kind_of",
        "toolkit/verdict/sliders/follow.py:follow",
    ),
    "forces before and after a slip for a verdict; the peak before it; in its sentence": (
        "toolkit:behaviour_of",
        "toolkit:past_peak",
        "toolkit:_behaved",
    ),
    "what survives at T = 0: of a law; from a table of it; laws of scipy, of which a table is made": (
        "master:ColdLife",
        "master:Straight",
        "origins:FrozenThresholds",
    ),
    "what is refused before the work on a soft spring: at T = 0; a delay, and ageing, in steps of time": (
        "master:refuse_endless_slips",
        "master:refuse_long_delays",
        "master:refuse_slips_of_the_aged",
    ),
    "the period of slips: of a solution; of an ensemble's late slips": (
        "master:Slips.period",
        "toolkit:LateSlips",
    ),
    "the period for a verdict; on its page": ("toolkit:behaviour_of", "toolkit:period_of"),
    "the rule of a slip at T = 0: reset; reform-after, its end and its births; instant, far ahead": (
        "master:ColdSlider.reset",
        "master:ColdSlider.reform_after",
        "master:MoveWithoutBirths.end_of_slip",
        "master:March.postpone_births",
        "master:Move.end_of_slip",
        "master:Waves.skip",
    ),
    "the same in time: no births in the slip; those after it; instant": (
        "master:slip_without_births",
        "master:ContactsInSteps.form_due",
        "master:slip_with_births",
    ),
    "a slider with mass at T = 0": ("master:InertialSlider",),
    "a slider with mass in heat, ageing or growth; its long slips; errors of its forces": (
        "master:HeavySlider",
        "master:LongSlips",
        "master/soft/inertia/in_time/answer.py:answer",
    ),
    "a slip's begin: T = 0, in time; with mass a slip's begin and end, and what counts as one": (
        "master:LoadCurve.slip_begins",
        "master:SlipBegins.up_to_slip",
        "master:Record.watch",
    ),
    "whether steady sliding is stable: with mass in heat; with mass and a delay; creep": (
        "master:sliding_is_stable",
        "toolkit:is_stable_with_delay",
        "master:is_stable",
    ),
    "a delay: its law": ("origins:Delay",),
    "a delay on a rigid slider: the solver; births one delay after breaks; who is out": (
        "master:solve_rigid",
        "master:SolvedPanels.births_begin",
        "master:still_out",
    ),
    "a delay under a spring without mass: the slider; its contacts; births": (
        "master:Slider",
        "master:ContactsInSteps",
        "master:BreaksInSteps.births_up_to",
    ),
    "a delay under a spring with mass: the slider; its contacts; births; on a panel": (
        "master:DelayedSlider",
        "master:Cohorts",
        "master:PastBreaks.born",
        "master:PanelBirths",
        "master:PullOnPanel",
    ),
    "the rate of thermal breaking": ("origins:SoftRates", "origins:StiffRates"),
    "what survives with heat; by one mean rate": ("master:ThermalLife", "master:MeanRateLife"),
    "the law of ageing; what survives": ("origins:Ageing", "master:AgeingLife"),
    "growing grains; what survives of them": ("origins:GrainContact", "master:GrowingLife"),
    "ageing: first passage; births of earlier legs": (
        "master:Passage",
        "master:Strands",
    ),
    "the paper's closure of ageing, (Q15)": (
        "master:paper_steady",
        "master:solve_q15",
        "master:paper_transient",
    ),
    "(GW3) and (GW4): exponential heights": ("origins:gw_elastic", "origins:gw_plastic"),
    "Gaussian heights, in metres": ("origins:from_moments", "origins:Summits"),
    "a scene's surface: what is built; its table; of a scan": (
        "toolkit:make_contacts",
        "toolkit/scene/laws.py:build",
        "toolkit/scene/kinds.py:from_topography",
    ),
    "a surface's moments to P_c; load by regime; the threshold law": (
        "origins:from_moments",
        "origins:Summits",
        "origins:_by_law",
    ),
    "Persson's stresses and thresholds": ("origins:persson", "origins:from_moments"),
    "the barrier of an island": ("origins:barrier",),
    "the draw of a threshold in the ensemble": ("eq_model:draw_thresholds",),
    "its break there: forward; cold; warm": (
        "eq_model:_forward",
        "eq_model:_cold",
        "eq_model:_by_rate",
    ),
    "an avalanche of the ensemble: its begin; its end; the rules of a slip": (
        "eq_model/coupled/slide_kernel.py:_stick",
        "eq_model:_end_avalanche",
        "eq_model/coupled/ensemble.py:Replicas._rules",
    ),
    "a slider with mass in the ensemble: the next place; the way there; its time; a stick; a slip": (
        "eq_model:nearest",
        "eq_model/coupled/mass/moves.py:quick_move",
        "eq_model:first_passage",
        "eq_model:watch",
        "eq_model:end_fall",
    ),
    "a delay in the ensemble on a spring: returns; with mass: a break, a return, the new contact": (
        "eq_model:_come_back",
        "eq_model/coupled/mass/kernel.py:_break",
        "eq_model:_return",
        "eq_model:_form",
    ),
    "a drive that turns on a spring in the ensemble; with mass": (
        "eq_model:turn",
        "eq_model:_end_leg",
    ),
    "uncertainty of a number of a verdict: by samples; over readings; its digits": (
        "toolkit:with_sampling",
        "toolkit:uncertainties_of",
        "toolkit:row",
    ),
    "a, b and D_c; the critical spring of rate and state, by the law and solved": (
        "master:read_steps",
        "master:_spring_by_law",
        "master:critical_spring_of",
    ),
    "sliders of as many contacts as the area holds: their number and way; followed": (
        "toolkit:Asked.planned",
        "toolkit:follow_finite",
        "toolkit/verdict/sliders/ensemble.py:sliders",
    ),
    "a slider that rings on contacts while others form: of contacts that strengthen; after a delay": (
        "master/soft/inertia/in_time/ringing.py:Ringing",
        "master/soft/inertia/delayed/swinging.py:Swinging.swing",
    ),
    "errors of energies of a slider with mass: of each part; by runs; by steps": (
        "master/soft/inertia/energy_errors.py:energy_errors",
        "master/soft/inertia/runs.py:Runs.energy_error",
        "master/soft/inertia/in_time/energy_errors.py:energies_told",
    ),
    "energies of a slider with mass by the master equation: on a closed motion; at the points": (
        "master/soft/inertia/oscillation.py:Oscillation.spent",
        "master/soft/inertia/run.py:Run.energy",
    ),
    "energies of a slider with mass in the ensemble: on a move; of breaks; of spring and motion; their balance": (
        "eq_model/coupled/mass/state.py:pass_time",
        "eq_model/coupled/mass/kernel.py:_break",
        "eq_model:HeavySliders.follow",
        "origins/energy.py:Energy.imbalance",
    ),
    "a verdict: the command's work; all readings; one reading; one slip rule; its kind; the sentence; verdict.json": (
        "toolkit:report_verdict",
        "toolkit/verdict/judge.py:verdict",
        "toolkit:answer_of",
        "toolkit/verdict/sliders/follow.py:follow",
        "toolkit:behaviour_of",
        "toolkit:sentence",
        "toolkit/verdict/files.py:plain",
    ),
    "now and then, and ever rarer: of the area's contacts; along the way": (
        "toolkit/verdict/sliders/judged.py:judged",
        "toolkit:in_the_end",
    ),
    "the error of a slip's place, drive_error: at T = 0; in time; with mass; with mass in time": (
        "master/soft/cold.py:ColdSlider._list",
        "master/soft/in_time/answer/extrapolation.py:extrapolated",
        "master/soft/inertia/solution.py:solve_inertial",
        "master/soft/inertia/in_time/refining.py:_found",
    ),
    "the time of a verdict: shared by readings; by rules; by a rule's solvers; for the area's contacts": (
        "toolkit/verdict/judge.py:verdict",
        "toolkit:answer_of",
        "toolkit/verdict/sliders/follow.py:follow",
        "toolkit:part_of_sliders",
    ),
    "who tells in a verdict's headline: the ensemble for master; master undecided; whole records; both differ": (
        "toolkit/verdict/sliders/follow.py:follow",
        "toolkit:with_more",
        "toolkit/verdict/sliders/records.py:Behaviour.in_place_of",
        "toolkit/verdict/text/words.py:_disagreement",
    ),
    "heat on a spring in the ensemble: proposed breaks; windows": (
        "eq_model:proposed",
        "eq_model:_window",
    ),
    "a key of a scene: its type; its number, of a machine with its unit; given to the solvers": (
        "toolkit/scene/tables.py:read_table",
        "toolkit/scene/drive.py:machine_number",
        "toolkit/scene/drive.py:make_drive",
    ),
    "a scene read; solved; written to disk": (
        "toolkit:load_scene",
        "toolkit:solve",
        "toolkit:save",
    ),
    "how to add an origin": "[extending.md](extending.md#a-new-origin)",
    "how to add a law": "[extending.md](extending.md#a-new-law-by-which-contacts-break-early)",
}
HEAD = """# Code map: where things stand

The first table is made from `QUESTIONS` in tests/code_map.py.

| where is | in |
|---|---|
{questions}
{by hand}Which tests hold a folder, and in it a delay, is said at the end of its `__init__.py`:

| folder | tests |
|---|---|
{tests}
## The equations of the paper

Made by `python tests/code_map.py` from the first lines of docstrings, and held by tests/test_code_map.py. Numbers are
those that LaTeX counts; equations without a label are steps from one of these to the next. How the equation that is
solved follows from (Q5a): [equations.md](equations.md). Words of several meanings: end of [extending.md](extending.md).

| number | label | where |
|---|---|---|
"""


class Place(NamedTuple):
    """A function or class, as file:name, and the labels of the equations that stand there."""

    name: str
    labels: list[str]


def labels_of(docstring: str) -> list[str]:
    """The labels that the first lines of a docstring name."""
    first = " ".join(docstring.split("\n\n")[0].split())
    found = re.findall(r"\(paper, Eqs?\. ([^);]*)", first)
    return [label for group in found for label in re.split(r", | and ", group)]


@cache
def parsed(file: Path) -> ast.Module:
    return ast.parse(file.read_text(encoding="utf-8"))


def places() -> Iterator[Place]:
    """All that say they are the place of an equation."""
    for room in ROOMS:
        for file in sorted((ROOT / room).rglob("*.py")):
            inside = file.relative_to(ROOT)
            for name, node in named(parsed(file)):
                labels = labels_of(ast.get_docstring(node) or "")
                if labels:
                    yield Place(f"{inside.as_posix()}:{name}", labels)


def named(
    tree: ast.Module | ast.ClassDef, before: str = ""
) -> Iterator[tuple[str, ast.FunctionDef | ast.ClassDef]]:
    """Functions, classes and methods, by their names."""
    for node in tree.body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            yield before + node.name, node
        if isinstance(node, ast.ClassDef):
            yield from named(node, f"{before}{node.name}.")


def answers() -> str:
    """The rows of QUESTIONS. A name is told by its room, or by its file where it stands in several of a room.

    Raises KeyError where it stands nowhere, or in several files of a room of which none is named.
    """
    found: dict[str, str] = {}
    several = set[str]()
    for room in ROOMS:
        for file in sorted((ROOT / room).rglob("*.py")):
            for name, _ in named(parsed(file)):
                by_file = f"{file.relative_to(ROOT).as_posix()}:{name}"
                place = found[by_file] = f"`{by_file}`"
                several |= {f"{room}:{name}"} & found.keys()
                found[f"{room}:{name}"] = place
    rows = []
    for name in several:
        del found[name]
    for question, names in QUESTIONS.items():
        where = names if isinstance(names, str) else ", ".join(found[name] for name in names)
        rows.append(f"| {question} | {where} |\n")
    return "".join(rows)


def tests_of_folders() -> str:
    """A row for each folder whose __init__ ends with its tests."""
    rows = []
    for room in ROOMS:
        for file in sorted((ROOT / room).rglob("__init__.py")):
            told = ast.get_docstring(parsed(file)) or ""
            if found := re.search(r"^Tests: (.*)", told, re.MULTILINE | re.DOTALL):
                folder = file.parent.relative_to(ROOT).as_posix()
                rows.append(f"| `{folder}` | {' '.join(found[1].split())} |\n")
    return "".join(rows)


@cache
def page() -> str:
    """The page as it should be."""
    found: dict[str, list[str]] = {}
    for place in places():
        for label in place.labels:
            found.setdefault(label, []).append(f"`{place.name}`")
    rows = []
    for number, label in LABELS.items():
        where = ", ".join(found[label]) if label in found else NOWHERE.get(label, "?")
        rows.append(f"| {number} | {label} | {where} |\n")
    head = HEAD.replace("{questions}", answers()).replace("{tests}", tests_of_folders())
    # the section on wrong numbers is written by hand, in the page
    by_hand = re.search(
        r"^## Where to look.*?(?=^Which tests hold)", PAGE.read_text("utf-8"), re.M | re.S
    )
    return head.replace("{by hand}", by_hand[0] if by_hand else "") + "".join(rows)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
