"""A result as a table in a notebook."""

from collections.abc import Iterable, Mapping
from html import escape
from math import isnan
from typing import Any

from origins.thresholds.law import Array
from toolkit.results.numbers import numbers_of
from toolkit.results.points import by_head
from toolkit.scene.scale import with_uncertainty

# Points of a sweep that are shown: sweep.csv has all.
_MOST_POINTS = 20

_NAMED = {
    "last_force": "force at the end",
    "last_force_over_load": "over the load",
    "largest_force": "largest force",
    "largest_force_over_load": "largest force over the load",
    "critical_spring": "critical spring K*",
    "before_slip": "force before a slip",
    "after_slip": "force after a slip",
    "period": "period of slips",
    "swept_force_least": "F_k, least of the sweep",
    "swept_force_most": "F_k, most of the sweep",
    "swept_critical_spring_least": "K*, least of the sweep",
    "swept_critical_spring_most": "K*, most of the sweep",
}


def as_html(result: Any) -> str:
    """Title, the most important numbers with their errors in the units of its scale, and notes, of a Result; and the
    points of a sweep."""
    rows = []
    if result.master is not None and result.master.regime is not None:
        rows.append(("verdict", result.master.regime.verdict))
    for name, number in numbers_of(result).items():
        said = with_uncertainty(number.value, number.error or 0.0, number.unit)
        rows.append((_NAMED.get(name, name), said))
    for name in ("master", "eq", "sweep"):
        if (answer := getattr(result, name)) is not None:
            outcome = "as asked" if answer.success else f"not as asked: {answer.message}"
            rows.append((name, f"{outcome}, run time {answer.run_time:.2g} s"))
    said = as_table(result.title or result.name, rows, result.notes)
    return said if result.sweep is None else said + _points(by_head(result))


def _points(columns: Mapping[str, Array]) -> str:
    """A table of the first points of a sweep."""
    heads = "".join(f"<th>{escape(name)}</th>" for name in columns)
    rows = list(zip(*(own.tolist() for own in columns.values()), strict=True))
    body = "".join(
        "<tr>" + "".join(f"<td>{escape(_shown(value))}</td>" for value in row) + "</tr>"
        for row in rows[:_MOST_POINTS]
    )
    more = len(rows) - _MOST_POINTS
    below = f"<p>and {more} points more, in sweep.csv</p>" if more > 0 else ""
    return f"<table><tr>{heads}</tr>{body}</table>{below}"


def _shown(value: Any) -> str:
    """A number to four digits, text as it is, and nothing where a point has no such number."""
    if not isinstance(value, float):
        return str(value)
    return "" if isnan(value) else f"{value:.4g}"


def as_table(caption: str, rows: Iterable[tuple[str, str]], notes: Iterable[str] = ()) -> str:
    """A table of names and what is said of them, with a caption, and notes below."""
    cells = "".join(
        f"<tr><th style='text-align:left'>{escape(name)}</th><td>{escape(said)}</td></tr>"
        for name, said in rows
    )
    below = "".join(f"<li>{escape(note)}</li>" for note in notes)
    table = f"<table><caption>{escape(caption)}</caption>{cells}</table>"
    return table + (f"<ul>{below}</ul>" if below else "")
