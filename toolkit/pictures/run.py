"""Pictures of a run and of a sweep: functions that take matplotlib axes and return them.

Data are in the unit of the thresholds.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from toolkit.pictures.points import (
    plot_points,
    plot_points_spring,
    plot_points_swing,
    with_spring,
    with_swing,
)
from toolkit.pictures.replicas import SHOWN, plot_replicas, with_slips
from toolkit.pictures.thresholds import INK, along, name_lengths, plot_density, some_of, write_along
from toolkit.results.beside import NOT_COMPARED, deviation
from toolkit.results.points import PointsRecord
from toolkit.results.records import Result, is_coupled, is_heavy, is_known

_BARS = 61  # error bars; with more the line would be hidden
_UNITS = {"velocity": "m/s", "temperature": "m²", "kelvin": "K", "rate": "m²/s", "delay": "s"}


def plot(result: Result, axes: Any = None) -> Any:
    """F(X) from every solver, F(t) where the drive has a time for each point, or F_k along a sweep if there is nothing
    else, with P_c(x) beside it, for a Result of toolkit.run or toolkit.load.

    They are drawn on `axes`, a pair of matplotlib's; left out, pyplot makes a figure. Returns the two of them, whose
    figure saves the picture: ``toolkit.plot(result)[0].figure.savefig("picture.png")``.
    """
    if axes is None:
        from matplotlib import pyplot

        size: dict[str, Any] = {"figsize": (10, 4), "width_ratios": (2.2, 1)}
        _, axes = pyplot.subplots(1, 2, layout="constrained", **size)
    swept = plot_points if isinstance(result.sweep, PointsRecord) else plot_sweep
    (plot_force if result.curves else swept)(axes[0], result)
    axes[0].set_title(result.title or result.name, parse_math=False)
    plot_density(axes[1], result.thresholds)
    return axes


def plot_force(axes: Any, result: Result) -> Any:
    """F/(N_c<k>) against X, or t where points have times: the master equation as a line, the ensemble as error bars of
    one standard error; on a soft slider some replicas, since their mean during a slip is the force of none of them."""
    solved, eq = result.master, result.eq
    if solved is not None:
        path, force, label = along(result, solved), solved.force, "master equation"
        if not solved.success:
            label += f", error {solved.force_error:.1e} $\\langle x_s\\rangle$: not as asked"
        if solved.slips is not None and (np.diff(solved.path) > 0.0).all():
            ends = slice(None), "force_before", "force_after"
            path, force = with_slips(result, solved, force, *ends)
        line = "-" if solved.success else "--"
        if not is_known(solved):
            label, path, force = "master equation: not solved", path[:0], force[:0]
        axes.plot(path, force, line, color=INK["master"], lw=1.4, zorder=3, label=label)
        if solved.outrun is not None and path.size and solved.outrun < path[-1]:
            label = "contacts outrun $P_c$ (Q15)"
            axes.axvspan(solved.outrun, path[-1], color="0.9", lw=0, label=label)
    if is_coupled(eq):
        number = min(SHOWN, len(eq.forces))
        line = plot_replicas(axes, result, "forces", "force_before", "force_after")
        each = f"{eq.contacts // len(eq.forces):,} contacts"
        line.set_label(f"EQ, {number} of {len(eq.forces)} replicas of {each}")
    elif eq is not None:
        some = some_of(eq.path.size, _BARS)
        place, error = along(result, eq)[some], eq.force_standard_error[some]
        style: dict[str, Any] = {"color": INK["eq"], "fmt": "o", "ms": 3, "capsize": 2, "lw": 1}
        axes.errorbar(place, eq.force[some], yerr=error, label="EQ, ±1 standard error", **style)
    write_along(axes, result)
    name_lengths(axes.yaxis, r"force $F/(N_c\langle k\rangle)$", result.thresholds.in_metres)
    axes.margins(y=0.15)  # slips and cycles leave no corner free
    axes.legend(loc="upper right", ncols=2, fontsize="small")
    return axes


def plot_position(axes: Any, result: Result) -> Any:
    """Positions of the drive, or of the rigid slider, and of a soft slider against time."""
    curve = result.curves[0]
    axes.plot(along(result, curve), curve.path, color="0.4", lw=1.2, label="drive")
    if is_coupled(curve):
        plot_replicas(axes, result, "positions", "before", "after").set_label("slider")
        axes.legend(fontsize="small")
    elif getattr(curve, "position", None) is not None:
        axes.plot(along(result, curve), curve.position, color=INK["master"], lw=1.2, label="slider")
        axes.legend(fontsize="small")
    write_along(axes, result)
    name_lengths(axes.yaxis, "position", result.thresholds.in_metres)
    return axes


def plot_holding(axes: Any, result: Result) -> Any:
    """The fraction of the contacts that hold, of a soft slider's replicas their mean; the others wait to form again."""
    for curve, ink in ((result.master, "master"), (result.eq, "eq")):
        if curve is not None:
            whole = ink == "master" or is_coupled(
                curve
            )  # which moves much between the points of some
            some = slice(None) if whole else some_of(curve.path.size, _BARS)
            style = "-" if whole else "."
            place = along(result, curve)[some]
            axes.plot(place, curve.holding[some], style, color=INK[ink], ms=4, lw=1.2)
    axes.set(ylabel="fraction\nthat holds", ylim=(0.0, 1.05))
    write_along(axes, result)
    return axes


def plot_deviation(axes: Any, result: Result) -> Any:
    """Ensemble minus master equation in standard errors, where enough contacts have broken for a comparison."""
    apart = deviation(result)
    if apart.worst is None:
        middle: dict[str, Any] = {"ha": "center", "va": "center", "transform": axes.transAxes}
        axes.text(0.5, 0.5, f"not compared: {NOT_COMPARED}", **middle)
    axes.axhspan(-2.0, 2.0, color="0.92", zorder=0)
    if result.eq is not None:
        axes.plot(along(result, result.eq)[apart.points], apart.off, ".", color=INK["eq"], ms=3.5)
    reach = max(4.0, 1.1 * (apart.worst or 0.0))
    axes.set(ylabel="EQ − ME\n(std. errors)", ylim=(-reach, reach))
    write_along(axes, result)
    return axes


def plot_velocity(axes: Any, result: Result) -> Any:
    """The speed of a slider with mass at the points of the path, and at its largest in slips between them: of the
    master equation, and in some replicas."""
    solved, eq = result.master, result.eq
    if eq is not None:
        plot_replicas(axes, result, "velocities", "top_speed")
    if solved is not None and solved.velocity is not None and is_known(solved):
        axes.plot(along(result, solved), solved.velocity, color=INK["master"], lw=1.2)
    axes.set_ylabel("$dX/dt$ (m/s)" if result.thresholds.in_metres else "$dX/dt$")
    write_along(axes, result)
    return axes


def plot_sweep(axes: Any, result: Result, name: str = "force") -> Any:
    """F_k/(N_c<k>), or the `critical_spring` K*/(N_c<k>) where it is finite, along the sweep's first quantity, a line
    for each value of its second one."""
    from matplotlib import colormaps

    sweep: Any = result.sweep
    first, *second = sweep.along
    values, x = getattr(sweep, name), getattr(sweep, first)
    table = np.where(np.isfinite(values), values, np.nan).reshape(x.shape[0], -1)
    rows, some = x.reshape(table.shape)[:, 0], some_of(table.shape[1], 8)  # as can be distinguished
    for k, column in enumerate(some):
        style = {"color": INK["master"], "lw": 1.4, "marker": "." if rows.size < 16 else ""}
        for other in second:
            here = getattr(sweep, other).reshape(table.shape)[0, column]
            style["label"] = f"{other} = {here:.3g}"
            style["color"] = colormaps["viridis"](0.85 * k / max(some.size - 1, 1))
        axes.plot(rows, table[:, column], **style)
    units = _UNITS if result.thresholds.in_metres else {}
    axes.set_xlabel(f"{first} ({units.get(first, '')})".removesuffix(" ()"))
    shown = table[np.isfinite(table)]
    if shown.size and np.ptp(shown) < 0.01 * shown.max():
        axes.set_ylim(0.0, 1.1 * shown.max())  # else a change of no account would fill the axis
    if rows.min() > 0.0 and rows.max() > 30.0 * rows.min():
        axes.set_xscale("log")
    if second:
        axes.legend(fontsize="small")
    if name == "force":
        name_lengths(axes.yaxis, r"$F_k/(N_c\langle k\rangle)$", result.thresholds.in_metres)
    else:
        axes.set(ylabel=r"$K^*/(N_c\langle k\rangle)$", ylim=(0.0, None))
    return axes


def plot_critical_spring(axes: Any, result: Result) -> Any:
    """K* along the sweep, from 0: below it stick-slip."""
    return plot_sweep(axes, result, "critical_spring")


def save_picture(result: Result, path: Path) -> None:
    """The picture of a run as a PNG, on a figure of its own: the session's backend is not touched."""
    from matplotlib.figure import Figure

    solved, below = result.master, list[Callable[[Any, Result], Any]]()
    if result.curves and result.timed:
        below.append(plot_position)
    if is_heavy(result.eq) or getattr(solved, "velocity", None) is not None:
        below.append(plot_velocity)
    if any((curve.holding < 1.0 - 1e-9).any() for curve in result.curves):
        below.append(plot_holding)
    if solved is not None and result.eq is not None and not is_coupled(result.eq):
        below.append(plot_deviation)
    swept: list[Any] = [plot_sweep] if result.curves and result.sweep is not None else []
    if getattr(result.sweep, "critical_spring", None) is not None:
        swept.append(plot_critical_spring)
    if with_spring(result.sweep):
        swept.append(plot_points_spring)
    if with_swing(result.sweep):
        swept.append(plot_points_swing)
    heights = [3, *(1 for _ in below), *(2 for _ in swept)]
    figure = Figure(figsize=(10, 1 + sum(heights)), layout="constrained")
    rows: list[Any] = [["F", "P"], *([draw.__name__, "P"] for draw in (*below, *swept))]
    places = figure.subplot_mosaic(rows, width_ratios=[2.2, 1], height_ratios=heights)
    plot(result, [places["F"], places["P"]])
    for draw in (*swept, *below):
        draw(places[draw.__name__], result)
    for draw, above in zip(below, ["F", *(draw.__name__ for draw in below)], strict=False):
        places[draw.__name__].sharex(places["F"])
        places[above].set_xlabel("")
    figure.savefig(path, dpi=150, format="png")
