"""F(X) and the slips of a run as CSV files: a header with units, in SI where the scene is of a surface, all digits."""

import csv
from collections.abc import Iterable, Mapping
from itertools import zip_longest
from pathlib import Path
from typing import Any

import numpy as np

from origins.thresholds.law import Array
from toolkit.results.kinds import is_coupled, is_heavy, is_precise
from toolkit.results.records import Result

# points of a path: more, some tens of megabytes, are in result.h5 alone
MOST = 200_000


def write_rows(columns: Mapping[str, Iterable[Any]], path: Path) -> None:
    """A CSV file with a column for each of these, by their heads; shorter ones end in empty cells, as do nan."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        for row in zip_longest(*columns.values(), fillvalue=""):
            writer.writerow("" if cell != cell or cell is None else cell for cell in row)


def has_force(result: Result) -> bool:
    """Whether the run followed a path that a spreadsheet can hold."""
    return any(curve.path.size <= MOST for curve in result.curves)


def write_force(result: Result, path: Path) -> None:
    """force.csv: a line for each point of the path, with each solver's force, its error and the fraction that
    holds, and of a slider with mass its velocity."""
    scale, mean, curves = result.scale, result.mean_threshold, result.curves
    soft = result.asked.drive is not None and result.asked.drive.spring is not None
    longest: Array = max((curve.path for curve in curves), key=len)
    columns: dict[str, Any] = {f"{'drive' if soft else 'slider'} [{scale.length_unit}]": longest}
    if result.timed:
        columns[f"time [{scale.time_unit}]"] = result.time[: longest.size]
    force = f"[{scale.force_unit}]"
    if (solved := result.master) is not None:
        if solved.position is not None:
            columns[f"master slider [{scale.length_unit}]"] = solved.position
        columns[f"master force {force}"] = solved.force * scale.force
        error = solved.force_error * mean * scale.force
        columns[f"master force error {force}"] = np.full(solved.path.size, error)
        columns["master holding"] = solved.holding
        if solved.velocity is not None:
            columns[f"master velocity [{scale.speed_unit}]"] = solved.velocity
    if (eq := result.eq) is not None:
        columns[f"eq force {force}"] = eq.force * scale.force
        columns[f"eq force standard error {force}"] = eq.force_standard_error * scale.force
        columns["eq holding"] = eq.holding
        if is_heavy(eq):
            columns[f"eq velocity [{scale.speed_unit}]"] = eq.velocity
    write_rows({name: column.tolist() for name, column in columns.items()}, path)


def _is_there(cell: Any) -> bool:
    """Whether a cell of a table is not empty."""
    return bool(cell != "")


def has_slips(result: Result) -> bool:
    """Whether the run is of a slider on a spring."""
    return is_coupled(result.eq) or (result.master is not None and result.master.slips is not None)


def write_slips(result: Result, path: Path) -> None:
    """slips.csv: a line for each slip, by each solver; of the ensemble by each of its sliders, counted from 0. One line
    says so where the master equation's slips are not known."""
    scale, master = result.scale, result.master
    length, force = f"[{scale.length_unit}]", f"[{scale.force_unit}]"
    names = {
        "drive": (f"drive {length}", 1.0),
        "force_before": (f"force before {force}", scale.force),
    }
    names |= {"force_after": (f"force after {force}", scale.force)}
    heavy = {
        "duration": f"duration [{scale.time_unit}]",
        "top_speed": f"top speed [{scale.speed_unit}]",
    }
    columns: dict[str, list[Any]] = {"solver": [], "slider": []}
    columns |= {head: [] for head, _ in names.values()} | {head: [] for head in heavy.values()}
    both = (
        ("master", None if master is None else master.slips),
        ("eq", getattr(result.eq, "slips", None)),
    )
    for solver, slips in both:
        if slips is None:
            continue
        if solver == "master" and not is_precise(master):
            columns["solver"].append(solver)
            columns["slider"].append("")
            for head, _ in names.values():
                columns[head].append("not known")
            for head in heavy.values():
                columns[head].append("")
            continue
        count = slips.drive.size
        columns["solver"] += [solver] * count
        columns["slider"] += slips.replica.tolist() if solver == "eq" else [""] * count
        for name, (head, factor) in names.items():
            columns[head] += (getattr(slips, name) * factor).tolist()
        for name, head in heavy.items():
            own = getattr(slips, name, None)  # slips without mass take no time
            columns[head] += [""] * count if own is None else own.tolist()
    # without a mass slips take no time, and infinitely many contacts have one slider
    optional = [*heavy.values(), *([] if is_coupled(result.eq) else ["slider"])]
    empty = [head for head in optional if not any(map(_is_there, columns[head]))]
    write_rows({head: cells for head, cells in columns.items() if head not in empty}, path)
