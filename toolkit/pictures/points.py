"""The picture of a sweep over keys of the scene: F_k, K* where it was asked for, and the swings of a spring's force."""

import re
from typing import Any

import numpy as np

from toolkit.pictures.thresholds import name_lengths, some_of
from toolkit.results.points import PointsRecord
from toolkit.results.records import Result

_LINES = 8  # as can be distinguished


def plot_points(axes: Any, result: Result, name: str = "kinetic_force") -> Any:
    """A column with its errors along the key that was swept first, a line for each combination of the others."""
    from matplotlib import colormaps

    sweep: Any = result.sweep
    first, *others = sweep.along
    x, unit = _numbers(sweep[first])
    value, error = sweep[name], sweep.columns.get(f"{name}_error", np.zeros(len(sweep)))
    lines = [", ".join(f"{key} = {sweep[key][row]}" for key in others) for row in range(len(sweep))]
    names = list(dict.fromkeys(lines))
    some = some_of(len(names), _LINES)
    for number, k in enumerate(some):
        rows = np.flatnonzero([line == names[k] for line in lines])
        rows = rows[np.argsort(x[rows], kind="stable")]
        color = colormaps["viridis"](0.85 * number / max(some.size - 1, 1))
        own = np.where(np.isfinite(error[rows]), error[rows], 0.0)
        axes.errorbar(x[rows], value[rows], own, marker=".", lw=1.2, color=color, label=names[k])
    axes.set_xlabel(f"{first} ({unit})" if unit else first)
    if x.min() > 0.0 and x.max() > 30.0 * x.min():
        axes.set_xscale("log")
    if others:
        axes.legend(fontsize="small")
    if name == "kinetic_force":
        name_lengths(axes.yaxis, r"$F_k/(N_c\langle k\rangle)$", result.thresholds.in_metres)
    elif name == "eq_force_swing":
        label = "spring force,\nlargest less smallest"
        name_lengths(axes.yaxis, label, result.thresholds.in_metres)
    else:
        axes.set(ylabel=r"$K^*/(N_c\langle k\rangle)$", ylim=(0.0, None))
    return axes


def plot_points_spring(axes: Any, result: Result) -> Any:
    """K* along the sweep, from 0: below it stick-slip."""
    return plot_points(axes, result, "critical_spring")


def plot_points_swing(axes: Any, result: Result) -> Any:
    """By how much the force of the ensemble's spring swings in the end: stick-slip, or the noise of smooth sliding."""
    return plot_points(axes, result, "eq_force_swing")


def with_swing(sweep: object) -> bool:
    """Whether a sweep over keys of the scene has swings of the force of a spring."""
    return isinstance(sweep, PointsRecord) and "eq_force_swing" in sweep.columns


def with_spring(sweep: object) -> bool:
    """Whether a sweep over keys of the scene has K* somewhere."""
    own = sweep.columns.get("critical_spring") if isinstance(sweep, PointsRecord) else None
    return own is not None and bool(np.isfinite(own).any())


def _numbers(values: Any) -> tuple[Any, str]:
    """The numbers of a swept key and the unit of texts such as "50 N/m"; texts that are none count from 1."""
    if values.dtype.kind != "U":
        return values.astype(float), ""
    read = [re.fullmatch(r"\s*([-+\d.eE]+) (.+)", one) for one in values]
    if all(read) and len({one[2] for one in read if one}) == 1:
        return np.array([float(one[1]) for one in read if one]), str(read[0][2] if read[0] else "")
    order = list(dict.fromkeys(values.tolist()))
    return np.array([order.index(one) + 1.0 for one in values.tolist()]), " / ".join(order)
