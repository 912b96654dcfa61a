"""Pictures of a sweep: F_k, what holds and K* against a speed, a temperature, a rate of ageing or a delay."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from toolkit.pictures.axes import headline, name_lengths, some_of
from toolkit.results.records import Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_NAMES = {
    "velocity": ("speed", "v", "m/s"),
    "temperature": ("temperature", r"k_BT/\langle k\rangle", "m²"),
    "kelvin": ("temperature", "T", "K"),
    "rate": ("rate of ageing", "D", "m²/s"),
    "delay": ("delay", r"\tau_m", "s"),
}
_DECADES = 30.0  # a quantity that spans more is drawn on a logarithmic axis
_LINES = 8  # as many as are told apart; of more some are drawn
HELD = 1.0 - 1e-9  # of the contacts: fewer that hold are worth a picture


def plot_sweep(axes: "Axes", result: Result) -> "Axes":
    """F_k/(N_c<k>) along the sweep, a line for each value of its second quantity."""
    if (sweep := result.sweep) is not None:
        _draw(axes, result, sweep.force)
        name_lengths(axes.yaxis, r"$F_k/(N_c\langle k\rangle)$", result.in_metres)
        if result.master is None and result.eq is None:
            axes.set_title(headline(result))
        if len(sweep.along) > 1:
            axes.legend(fontsize="small")
    return axes


def plot_swept_holding(axes: "Axes", result: Result) -> "Axes":
    """The fraction of the contacts that hold along the sweep."""
    if result.sweep is not None:
        _draw(axes, result, result.sweep.holding)
        axes.set(ylabel="fraction\nthat holds", ylim=(0.0, 1.05))
    return axes


def plot_critical_spring(axes: "Axes", result: Result) -> "Axes":
    """K*/(N_c<k>) along the sweep, from 0: below it stick-slip. What is infinite is not drawn."""
    if result.sweep is not None and result.sweep.critical_spring is not None:
        spring = result.sweep.critical_spring
        _draw(axes, result, np.where(np.isfinite(spring), spring, np.nan))
        axes.set_ylabel(r"$K^*/(N_c\langle k\rangle)$")
        axes.set_ylim(bottom=0.0)
    return axes


def sweep_panels(result: Result) -> list[tuple[Callable[["Axes", Result], "Axes"], bool]]:
    """What a picture may show of a sweep, and whether there is anything to show."""
    sweep = result.sweep
    return [
        (plot_sweep, sweep is not None),
        (plot_swept_holding, sweep is not None and bool((sweep.holding < HELD).any())),
        (plot_critical_spring, sweep is not None and sweep.critical_spring is not None),
    ]


def _draw(axes: "Axes", result: Result, values: npt.NDArray[np.float64]) -> None:
    """Lines against the sweep's first quantity, named by its second; with SI units where lengths are metres."""
    from matplotlib import colormaps

    first, *second = result.sweep.along  # type: ignore[union-attr]
    x: Any = getattr(result.sweep, first)
    rows = x.reshape(x.shape[0], -1)[:, 0]
    table = values.reshape(rows.size, -1)
    some = some_of(table.shape[1], _LINES)
    units = {name: unit for name, (*_, unit) in _NAMES.items() if result.in_metres or unit == "K"}
    style: dict[str, Any] = {"lw": 1.4, "marker": "." if rows.size < 2 * _LINES else ""}
    for k, column in enumerate(some):
        style["color"] = "#1f4e79"
        for name in second:
            here = float(getattr(result.sweep, name)[0, column])
            style["label"] = f"${_NAMES[name][1]}$ = {here:.3g} {units.get(name, '')}".rstrip()
            style["color"] = colormaps["viridis"](0.85 * k / max(some.size - 1, 1))
        axes.plot(rows, table[:, column], **style)
    name, symbol, _ = _NAMES[first]
    axes.set_xlabel(f"{name} ${symbol}$ ({units.get(first, '')})".removesuffix(" ()"))
    if rows.min() > 0.0 and rows.max() > _DECADES * rows.min():
        axes.set_xscale("log")
