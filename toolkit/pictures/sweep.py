"""Pictures of a sweep: F_k and K*, with their errors, along speeds, temperatures, rates of ageing or delays."""

from typing import Any

import numpy as np

from toolkit.pictures.axes import (
    force_name,
    legend_above,
    name_axis,
    some_of,
    spring_name,
    style_of,
)
from toolkit.results.records import Result
from toolkit.scene.scale import PREFIXED, written

_UNITS = {"velocity": "m/s", "temperature": "m²", "kelvin": "K", "rate": "m²/s", "delay": "s"}
_OWN_UNITS = {"velocity": "length/time", "temperature": "length²", "kelvin": "K"}
_OWN_UNITS |= {"rate": "length²/time", "delay": "time"}
_SYMBOLS = {"velocity": "speed $v$", "temperature": r"temperature $k_BT/\langle k\rangle$"}
_SYMBOLS |= {"kelvin": "temperature $T$", "rate": "rate of ageing", "delay": r"delay $\tau$"}
_MARKED = 30  # points; with more, some carry a mark


def plot_sweep(axes: Any, result: Result, name: str = "force") -> Any:
    """F_k, or the `critical_spring` K* where it is finite, with its error, along the sweep's first quantity, a line for
    each value of its second one."""
    sweep: Any = result.sweep
    first, *second = sweep.along
    x, factor = getattr(sweep, first), getattr(result.scale, name.removeprefix("critical_"))
    values, errors = factor * getattr(sweep, name), factor * getattr(sweep, f"{name}_error")
    errors = errors * (result.mean_threshold if name == "force" else 1.0)
    units = _UNITS if result.thresholds.in_metres else _OWN_UNITS
    table = np.where(np.isfinite(values), values, np.nan).reshape(x.shape[0], -1)
    bars = np.where(np.isfinite(errors), errors, 0.0).reshape(table.shape)
    rows, some = x.reshape(table.shape)[:, 0], some_of(table.shape[1], 8)  # as can be distinguished
    every = max(rows.size // _MARKED, 1)
    for k, column in enumerate(some):
        style = style_of(k) | {"lw": 1.4, "ms": 4, "markevery": every, "errorevery": every}
        for other in second:
            here = getattr(sweep, other).reshape(table.shape)[0, column]
            unit = units[other]
            value = written(here, unit) if unit in PREFIXED else f"{here:.3g} {unit}"
            style["label"] = f"{other} = {value}"
        axes.errorbar(rows, table[:, column], yerr=bars[:, column], capsize=2, **style)
    shown = table[np.isfinite(table)]
    if shown.size and np.ptp(shown) < 0.01 * shown.max():
        axes.set_ylim(0.0, 1.1 * shown.max())  # else a change of no account would fill the axis
    if rows.min() > 0.0 and rows.max() > 30.0 * rows.min():
        axes.set_xscale("log")
    if second:
        legend_above(axes)
    name_axis(axes.xaxis, _SYMBOLS[first], units[first])
    if name == "force":
        name_axis(axes.yaxis, *force_name(result.scale, "F_k"))
    else:
        axes.set_ylim(0.0, None)
        name_axis(axes.yaxis, *spring_name(result.scale.spring_unit))
    return axes


def plot_critical_spring(axes: Any, result: Result) -> Any:
    """K* along the sweep, from 0: below it stick-slip."""
    return plot_sweep(axes, result, "critical_spring")
