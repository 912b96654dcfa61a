"""The picture of a sweep: F_k, K* where it was asked for, and the swings of a spring's force."""

from collections.abc import Mapping, Sequence
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from origins.thresholds.law import Array
from toolkit.pictures.axes import (
    force_name,
    in_lines,
    legend_above,
    name_axis,
    some_of,
    spring_name,
    style_of,
)
from toolkit.pictures.keys import axis_of_key, last_words, symbol_of_key, value_of_key
from toolkit.pictures.slope import draw_slope
from toolkit.results.points import SweepRecord, force_factors, key_units, without_unit
from toolkit.results.records import Result
from toolkit.scene.scale import PREFIXED, SHARED, written

_LINES = 8  # as can be distinguished
_LETTERS = 98  # of a legend above the panel, which is wider than others
_SHORT_LINE = 22  # letters of a line along the axis of one of several panels
_MARKED = 30  # points of a line; with more, some carry a mark
# of the largest value: a change of no account, which is not to fill the axis
FLAT = 0.01
_ROOM = 0.05  # of an axis below its lowest mark
_LOG_FROM = 30.0  # largest over smallest value from which an axis is logarithmic
_SPEEDS = ("velocity", "drive.velocity")
# columns of F_k, where they stand alone
_OF_RIGID = ["force"], ["kinetic_force"]
# mean force before all slips of the ensemble's sliders
_OF_ENSEMBLE = "eq_force_before_slip"
_OF_MASTER = "force_before_slip"
_OF_SLIPS = _OF_MASTER, "force_after_slip"
_NOT_DECIDED = "hollow, at no force: not decided whether it slips"
_GOES_ON = "hollow: not decided whether it goes on slipping"
_NOISE = 0.1  # part of the largest swing below which the force swings by chance
# of the height of the axes: where marks of points that are not decided begin, and how far those of the next line are
_LOWEST, _NEXT = 0.025, 0.04


def plot_points(
    axes: Any, result: Result, name: str = "", along: Sequence[str] | None = None
) -> Any:
    """A column with its errors, F_k by default, in the unit of the result's scale, along the key that was swept first,
    a line for each combination of the others; of sliders on springs the forces before and after a slip beside F_k.
    Where F_k goes straight with ln v, its slope is told, and drawn as a pale line. `along` : the keys on which the
    column hangs, all by default."""
    sweep: Any = result.sweep
    first, *others = sweep.along if along is None else along
    x, unit = _numbers(sweep[first].ravel())
    name = name or ("force" if sweep.smooth else "kinetic_force")
    units = key_units(sweep.along, result.scale)
    columns, unmarked = _columns_of(sweep, name, others)
    lines = _names_of_lines(sweep, others, units)
    # of keys on which nothing hangs one value each
    unused = [sweep[key].ravel() for key in sweep.along if key not in (first, *others)]
    shown = np.logical_and.reduce([own == own[0] for own in unused] or [np.full(x.size, True)])
    names, number, sloped = list(dict.fromkeys(lines)), 0, False
    undecided, slipped = (own & (name == "kinetic_force") for own in _undecided(sweep))
    for column, said in columns.items():
        value, error = _drawn(result, column)
        for k_th, k in enumerate(some_of(len(names), _LINES)):
            rows = np.flatnonzero(shown & [line == names[k] for line in lines])
            rows = rows[np.argsort(x[rows], kind="stable")]
            style = style_of(number) | {"ms": 4, "lw": 1.2, "capsize": 2, "label": names[k] or said}
            style |= dict.fromkeys(("markevery", "errorevery"), max(rows.size // _MARKED, 1))
            if first in _SPEEDS and column in ("force", "kinetic_force"):
                slope = draw_slope(axes, x[rows], value[rows], error[rows], style["color"])
                sloped |= slope != 0.0
                told = f"slope $dF_k/d\\,\\ln v$ = {written(slope, result.scale.force_unit)}"
                style["label"] = ", ".join(filter(None, [style["label"], told * (slope != 0.0)]))
            axes.errorbar(x[rows], value[rows], error[rows], **style)
            if column == next(iter(columns)) and undecided[rows].any():
                without, height = rows[undecided[rows]], _LOWEST + k_th * _NEXT
                place = {"transform": axes.get_xaxis_transform()}
                axes.plot(x[without], np.full(without.size, height), **_hollow(style) | place)
            if column in _OF_SLIPS and slipped[rows].any():
                seen = rows[slipped[rows]]
                axes.plot(x[seen], value[seen], **_hollow(style) | {"mfc": "white", "zorder": 3})
            number += 1
    if slipped.any():
        axes.plot([], [], "o", color="0.4", mfc="white", ms=5, label=_GOES_ON)
    if undecided.any():
        axes.plot([], [], "o", color="0.4", mfc="none", ms=5, label=_NOT_DECIDED)
    if unmarked:
        axes.plot([], [], " ", label=f"no mark{unmarked.removesuffix(')')}")
    _scale(axes, x, _drawn(result, name)[0], name)
    name_axis(axes.xaxis, *axis_of_key(first, unit or units.get(first, "")))
    marked = name in ("critical_spring", "kinetic_force") and _mark_critical(axes, result)
    # last, as a scale that is set anew has ticks of its own, without the prefix of the unit
    name_axis(axes.yaxis, *_axis_of(name, columns, result))
    # the panels below that of the forces have the same lines
    told_more = others or marked or sloped or undecided.any() or slipped.any()
    if len(columns) > 1 or (told_more and name in ("force", "kinetic_force")):
        legend_above(axes, letters=_LETTERS)
    return axes


def _columns_of(sweep: SweepRecord, name: str, others: Sequence[str]) -> tuple[dict[str, str], str]:
    """The columns that are drawn with what the legend says of them, for F_k with the forces of slips where there are
    any; and, where the axis has no room for it, which points have no mark."""
    if name != "kinetic_force" or not (slips := _of_slips(sweep)):
        return {name: ""}, ""
    if not others:
        return slips | {name: "kinetic force $F_k$, rigid slider"}, ""
    # whose lines are many: one column, and the axis has room for its name alone
    named, _, unmarked = next(iter(slips.values())).partition(" (no mark")
    return {next(iter(slips)): in_lines(named, _SHORT_LINE)}, unmarked


def _names_of_lines(
    sweep: SweepRecord, others: Sequence[str], units: Mapping[str, str]
) -> list[str]:
    """Of each point the values of these keys, which name its line."""
    each, words = {key: sweep[key].ravel() for key in others}, last_words(others)
    named = {key: symbol_of_key(key, words[key], own) for key, own in each.items()}
    return [
        ", ".join(
            f"{named[key]} = {value_of_key(own[row], units.get(key, ''))}"
            for key, own in each.items()
        )
        for row in range(sweep[sweep.along[0]].size)
    ]


def _hollow(style: Mapping[str, Any]) -> dict[str, Any]:
    """Marks of points that are not decided, in the style of their line."""
    kept = {name: style[name] for name in ("color", "marker")}
    return kept | {"mfc": "none", "ls": "", "ms": 5, "label": "_"}


def _scale(axes: Any, x: Array, value: Array, name: str) -> None:
    """Logarithmic axes where numbers go over decades; else the other axis from 0, where changes are small."""
    # points without a value, as those without slips, are on the axis, too
    axes.update_datalim(np.column_stack([x, x]), updatey=False)
    if x.min() > 0.0 and x.max() > _LOG_FROM * x.min():
        axes.set_xscale("log")
    least, most = np.nanmin(value), np.nanmax(value)
    if least > 0.0 and most > _LOG_FROM * least:
        axes.set_yscale("log")
    elif name == "critical_spring" or most - least < FLAT * most:
        top, lowest = 1.15 * max(axes.get_ylim()[1], most), axes.dataLim.y0
        # room below marks at 0, as those after a slip, and below
        axes.set_ylim(min(lowest - _ROOM * top, 0.0) if lowest <= 0.0 else 0.0, top)


def _mark_critical(axes: Any, result: Result) -> bool:
    """A line where the springs of a sweep over them alone pass K*, straight in ln K between points; whether they do."""
    sweep: Any = result.sweep
    critical = sweep.columns.get("critical_spring", np.array(np.nan))
    if [*sweep.along] != ["drive.spring"] or not np.isfinite(critical).any():
        return False
    x, unit = _numbers(sweep["drive.spring"].ravel())
    if (unit or SHARED) != result.scale.spring_unit:
        return False
    order = np.argsort(x, kind="stable")
    springs, critical = x[order], column_with_error(result, "critical_spring")[0][order]
    with np.errstate(divide="ignore", invalid="ignore"):
        above = np.log(springs / critical)
    passed = np.flatnonzero((above[:-1] < 0.0) & (above[1:] >= 0.0) & np.isfinite(np.diff(above)))
    for number, k in enumerate(passed):
        fraction = above[k] / (above[k] - above[k + 1])
        at = critical[k] ** (1.0 - fraction) * critical[k + 1] ** fraction
        style: dict[str, Any] = {"color": "0.3", "ls": "--", "lw": 1.0, "zorder": 0}
        axes.axvline(at, label=None if number else "$K = K^*$", **style)
    return bool(passed.size)


def _of_slips(sweep: SweepRecord) -> dict[str, str]:
    """The columns of the forces of slips that are known at some point, and what they are; empty without slips."""
    named = {
        _OF_MASTER: "before the last slip",
        "force_after_slip": "after it",
        _OF_ENSEMBLE: "before a slip, ensemble",
    }
    known = {name: np.isfinite(sweep[name]) for name in named if name in sweep.columns}
    if _OF_ENSEMBLE in known:
        known[_OF_ENSEMBLE] &= _swings_on(sweep).reshape(known[_OF_ENSEMBLE].shape)
    none = dict.fromkeys(named, " (no mark: no slip)")
    none[_OF_ENSEMBLE] = " (no mark: no slips in the end, or none yet)"
    # points that are not decided have a mark of their own
    told, _ = _undecided(sweep)
    return {
        name: named[name] + ("" if (there.ravel() | told).all() else none[name])
        for name, there in known.items()
        if there.any()
    }


def _undecided(sweep: SweepRecord) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """At which points no slip is known, and none is excluded: the path ends too early, or the point failed; and at
    which it ends, after slips, before it is known whether they go on."""
    if "regime" not in sweep.columns:
        return np.zeros(sweep.size, bool), np.zeros(sweep.size, bool)
    none = np.isnan(sweep[_OF_MASTER].ravel())
    failed = np.isnan(sweep["slips"].ravel())
    # text that follows may say of how many contacts
    undecided = failed | np.char.startswith(sweep["regime"].ravel().astype(str), "undecided")
    return np.asarray(none & undecided), np.asarray(~none & undecided)


def _swings_on(sweep: SweepRecord) -> NDArray[np.bool_]:
    """At which points the force of the ensemble's spring still swings in the end, or rises after slips: elsewhere its
    slips are those of the first transient alone."""
    swing = sweep.columns["eq_force_swing"].ravel()
    slipped = sweep.columns["eq_slips_a_slider"].ravel() > 0.0
    largest = np.nanmax(swing) if np.isfinite(swing).any() else 0.0
    return np.asarray((swing > _NOISE * largest) | (_still_rises(sweep) & slipped))


def _still_rises(sweep: SweepRecord) -> NDArray[np.bool_]:
    """At which points the force but rises where the path ends, so that its swing is not known."""
    known = np.isfinite(sweep.columns["eq_last_force"].ravel())
    return np.asarray(known & np.isnan(sweep.columns["eq_force_swing"].ravel()))


def _drawn(result: Result, name: str) -> tuple[Array, Array]:
    """A column and its error as `column_with_error` has them, nan where they tell of no sliding that goes on."""
    value, error = column_with_error(result, name)
    if name == _OF_ENSEMBLE:
        value = np.where(_swings_on(cast(Any, result.sweep)), value, np.nan)
    return value, error


def column_with_error(result: Result, name: str) -> tuple[Array, Array]:
    """A column and its error, 0 where it is not known, in the unit of the scale; nan where there is no value."""
    sweep: Any = result.sweep
    none = np.zeros(sweep.size)
    value, error = (sweep.columns.get(key, none).ravel() for key in (name, f"{name}_error"))
    if name == "force":  # whose error is in mean thresholds
        error = result.mean_threshold * error
    factors = force_factors(sweep, result.scale)
    value, error = factors * value, factors * error
    return np.where(np.isfinite(value), value, np.nan), np.where(np.isfinite(error), error, 0.0)


def _axis_of(name: str, columns: dict[str, str], result: Result) -> tuple[str, str]:
    """Name and unit of the axis on which these columns are drawn."""
    if name == "critical_spring":
        return spring_name(result.scale.spring_unit)
    whole, unit = force_name(result.scale, "F_k" if [*columns] in _OF_RIGID else "F")
    if name == "eq_force_swing":
        return f"swing of {whole.removeprefix('force ')}\n", unit
    said = "".join(columns.values()) if len(columns) == 1 else ""
    return f"{whole}\n{said}".strip(), unit


def plot_points_swing(axes: Any, result: Result) -> Any:
    """By how much the force of the ensemble's spring swings in the end: stick-slip, or the noise of smooth sliding; and
    between which points of a sweep over one key of numbers that ends."""
    plot_points(axes, result, "eq_force_swing")
    sweep: Any = result.sweep
    first = sweep.along[0]
    x, unit = _numbers(sweep[first])
    unit = unit or key_units([first], result.scale).get(first, "")
    order = np.argsort(x, kind="stable")
    x, swings, rising = x[order], _swings_on(sweep)[order], _still_rises(sweep)[order]
    ends = np.flatnonzero(swings[:-1] & ~(swings | rising)[1:])
    if len(sweep.along) == 1 and ends.size == 1 and not swings[ends[0] + 1 :].any():
        low, high = x[ends[0]], x[ends[0] + 1]
        where = [written(own, unit) if unit in PREFIXED else f"{own:.4g}" for own in (low, high)]
        label = f"swings end between {' and '.join(where)}"
        axes.axvspan(low, high, color="0.9", lw=0, zorder=0, label=label)
    if rising.any():
        axes.plot([], [], " ", label="no mark: the force only rises at the end of the path")
    legend_above(axes)
    return axes


def with_swing(sweep: object) -> bool:
    """Whether a sweep has swings of the force of a spring somewhere."""
    own = sweep.columns.get("eq_force_swing") if isinstance(sweep, SweepRecord) else None
    return own is not None and bool(np.isfinite(own).any())


def _numbers(values: Any) -> tuple[Any, str]:
    """The numbers of a swept key and the unit of texts such as "50 N/m"; texts that are none count from 1."""
    numbers, unit = without_unit(values)
    if numbers.dtype.kind != "U":
        return numbers.astype(float), unit
    order = list(dict.fromkeys(values.tolist()))
    return np.array([order.index(one) + 1.0 for one in values.tolist()]), " / ".join(order)
