"""The stability table: all cases through both solvers, as lines, files and a picture."""

import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import fields
from typing import Any

import numpy as np

from origins.laws.temperature import TooHot
from toolkit.stability.case import Case, Question, Row, Verdict, rows

VERDICTS: dict[
    Verdict, str
] = {  # with the colours of Okabe and Ito, which colour-blind readers tell apart
    "exact": "#0072B2",
    "within tolerance": "#009E73",
    "short, and says so": "#E69F00",
    "slow": "#CC79A7",
    "refused": "#999999",
    "wrong": "#D55E00",
}
_WIDE = 54  # letters of a case's name in a line


def extreme_cases() -> list[Case | Question]:
    """All cases that are shipped."""
    from toolkit.stability import laws, sliders, speeds, surfaces, thresholds

    files = (thresholds, surfaces, laws, speeds, sliders)
    return [case for file in files for case in file.cases()]


def uncounted(done: int, expected: int) -> None:
    """The default count of what is done: nobody is told."""


def stability(
    cases: Sequence[Case | Question],
    say: Callable[[str], None],
    found: list[Row] | None = None,
    count: Callable[[int, int], None] = uncounted,
) -> list[Row]:
    """The rows of all cases, each said as soon as it is known, under the name of its group. They are appended to
    `found`, which holds those of an interrupted table, too; `count` is told how many cases are done, and of how many.
    """
    found, group = [] if found is None else found, ""
    for done, case in enumerate(cases, start=1):
        if case.group != group:
            say(group := case.group)
        found += answered(case, say)
        count(done, len(cases))
    return found


def answered(case: Case | Question, say: Callable[[str], None] = lambda line: None) -> list[Row]:
    """The rows of a case, each said. A RuntimeWarning within is raised as an error, since it tells of a number that is
    none; the note on temperatures far above all barriers is left out, as these are asked on purpose."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        warnings.simplefilter("ignore", TooHot)
        found = rows(case)
    for row in found:
        say(line(row))
    return found


def line(row: Row) -> str:
    """A row as a line of text."""
    numbers = [
        f"{value:8.1e}" if np.isfinite(value) else f"{'-':>8}" for value in (row.error, row.claim)
    ]
    against = row.road or row.said
    if row.road and row.verdict in ("slow", "short, and says so"):
        against = f"{row.said}; against {row.road}"
    head = f"  {row.case:{_WIDE}}{row.solver:19}{row.verdict:20}{'  '.join(numbers)}"
    return f"{head}{row.run_time:9.2g} CPU-s  {against}"


def summary(found: Iterable[Row]) -> str:
    """How many rows have which verdict, in a line."""
    counts = Counter(row.verdict for row in found)
    return ", ".join(f"{counts[verdict]} {verdict}" for verdict in VERDICTS if counts[verdict])


def columns(found: Sequence[Row]) -> dict[str, list[Any]]:
    """The columns of a CSV file by their heads: a row a line; lengths in mean thresholds, CPU times in s."""
    units = {"error": "mean thresholds", "floor": "mean thresholds", "claim": "mean thresholds"}
    units["run_time"] = "s"
    names = [field.name for field in fields(Row)]
    heads = [f"{name} [{units[name]}]" if name in units else name for name in names]
    return {
        head: [getattr(row, name) for row in found] for head, name in zip(heads, names, strict=True)
    }


def draw_table(found: list[Row], title: str = "Extreme cases") -> Any:
    """True error against the claim at the same point, a mark for each answer in the colour of its verdict: what lies
    above the diagonal by more than the truth's own error is wrong. Refusals have no place there and are counted."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 7), layout="constrained")
    axes = figure.subplots()
    least = 1e-16  # an error of 0 has no place on a logarithmic axis
    counts = Counter(row.verdict for row in found)
    marks = dict(zip(VERDICTS, "osDv^X", strict=True))
    for verdict, colour in VERDICTS.items():
        own = [
            row
            for row in found
            if row.verdict == verdict and np.isfinite([row.error, row.claim]).all()
        ]
        label = f"{verdict} ({counts[verdict]})"
        axes.loglog(
            [max(row.claim, least) for row in own],
            [max(row.error, least) for row in own],
            marks[verdict],
            color=colour,
            mfc="none",
            label=label,
        )
        for row in own:  # what the truth is good for
            if np.isfinite(row.floor) and row.floor > 0.0:
                ends = [max(row.error - row.floor, least), max(row.error, least)]
                axes.plot([max(row.claim, least)] * 2, ends, "-", color=colour, lw=0.5, alpha=0.6)
    axes.plot([least, 10.0], [least, 10.0], "-", color="black", lw=0.8)
    axes.set(
        xlabel="error that is claimed (mean thresholds; of the ensemble 5 standard errors)",
        ylabel="largest difference from the second road (mean thresholds)",
        title=f"{title}: below the diagonal a claim holds; thin lines: the second road's own error",
    )
    axes.title.set_fontsize("medium")
    axes.grid(alpha=0.3)
    figure.legend(loc="outside lower center", ncols=3, fontsize="small")
    return figure
