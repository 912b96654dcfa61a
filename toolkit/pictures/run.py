"""Pictures: functions that take matplotlib axes and return them. Data are in the unit of the thresholds."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from toolkit.judge.deviation import deviation, telling, why_not_compared
from toolkit.pictures.abscissa import (
    along,
    clock,
    conditions,
    curves,
    grows,
    with_slips,
    write_along,
)
from toolkit.pictures.axes import INK, name_lengths, plain
from toolkit.pictures.sweep import plot_sweep, sweep_panels
from toolkit.pictures.thresholds import plot_density
from toolkit.results.records import AgeingRecord, Result, Simulated, SoftRecord, is_coupled
from toolkit.results.slips import slips_beside

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_NO_DEFECT = 1e-3  # of a weight of 1: less is not drawn larger than that
_ALL = 1e-9  # of the contacts
_LEGEND = 0.13  # of the height, room for each of its rows above the curve
_BARS = 61  # as many error bars as leave the line in sight
_REPLICAS = 5  # as many curves as can be told from one another


def plot(result: Result, axes: Any = None) -> Any:
    """F(X) from every solver, F(t) where the drive has a time for each point, F_k along a sweep where that alone was
    asked for, and P_c(x) beside it.

    Parameters
    ----------
    result : Result
        Of toolkit.run or toolkit.load.
    axes : pair of matplotlib axes, optional
        Where to draw F and P_c; left out, pyplot makes a figure for them.

    Returns
    -------
    axes
        The two of them, a numpy array where pyplot made them. Their figure saves the picture:
        ``toolkit.plot(result)[0].figure.savefig("picture.png")``.
    """
    if axes is None:
        from matplotlib import pyplot

        size: dict[str, Any] = {"figsize": (10, 4), "width_ratios": (2.2, 1)}
        _, axes = pyplot.subplots(1, 2, layout="constrained", **size)
    (plot_force if curves(result) else plot_sweep)(axes[0], result)
    plot_density(axes[1], result.thresholds)
    if grows(result):
        age = result.asked.contacts.thresholds["age"]
        axes[1].set_title(f"thresholds at $X$ = 0, age {age:.3g}")
    return axes


def plot_force(axes: "Axes", result: Result) -> "Axes":
    """F/(N_c<k>) against X, or t where the drive keeps time: the master equation as a line, the ensemble as error bars,
    one standard error, under it; on a soft slider some replicas, since their mean over a slip is the force of none."""
    solved, eq = result.master, result.eq
    if solved is not None:
        path, force = along(result, solved), solved.force
        label, dashes = "master equation", "-"
        if not solved.success:
            dashes = "--"
            label += f", error {solved.force_error:.1e} $\\langle x_s\\rangle$: not as asked"
        if isinstance(solved, SoftRecord):
            path, force = with_slips(path, force, solved)
        axes.plot(path, force, color=INK["master"], lw=1.4, ls=dashes, zorder=3, label=label)
        if isinstance(solved, AgeingRecord) and solved.outrun < path[-1]:
            label = "contacts outrun $P_c$ (Q15)"
            axes.axvspan(solved.outrun, path[-1], color="0.9", lw=0, label=label)
    if is_coupled(eq):
        number = min(_REPLICAS, len(eq.forces))
        each = f"{eq.contacts // len(eq.forces):,} contacts"
        style: dict[str, Any] = {"color": INK["eq"], "lw": 0.7, "alpha": 0.7, "zorder": 2}
        lines = axes.plot(along(result, eq), eq.forces[:number].T, **style)
        lines[0].set_label(f"EQ, {number} of {len(eq.forces)} replicas of {each}")
    elif eq is not None:
        some = _some(eq)
        bars: dict[str, Any] = {"ms": 3, "capsize": 2, "lw": 1, "color": INK["eq"], "zorder": 2}
        bars |= {"yerr": eq.force_standard_error[some], "label": "EQ ensemble, ±1 standard error"}
        axes.errorbar(along(result, eq)[some], eq.force[some], fmt="o", **bars)
    write_along(axes, result)
    name_lengths(axes.yaxis, r"force $F/(N_c\langle k\rangle)$", result.in_metres)
    axes.set_title(
        "\n".join(filter(None, [plain(result.title or result.name), conditions(result)]))
    )
    # slips and cycles leave no corner free
    handles, _ = axes.get_legend_handles_labels()
    bottom, top = axes.get_ylim()
    axes.set_ylim(bottom, top + _LEGEND * -(-len(handles) // 2) * (top - bottom))
    axes.legend(loc="upper right", ncols=2, fontsize="small")
    return axes


def plot_position(axes: "Axes", result: Result) -> "Axes":
    """Where the drive, or the rigid slider, and a soft slider are at each time."""
    curve, name = curves(result)[0], "slider\nposition $X$"
    axes.plot(along(result, curve), curve.path, color="0.4", lw=1.2, label="drive")
    if isinstance(curve, SoftRecord) or is_coupled(curve):
        axes.plot(along(result, curve), curve.position, color=INK["master"], lw=1.2, label="slider")
        axes.legend(fontsize="small")
        name = "position"
    write_along(axes, result)
    name_lengths(axes.yaxis, name, result.in_metres)
    return axes


def plot_holding(axes: "Axes", result: Result) -> "Axes":
    """The fraction of the contacts that hold; the others wait to form again."""
    solved, eq = result.master, result.eq
    if solved is not None:
        axes.plot(along(result, solved), solved.holding, color=INK["master"], lw=1.2, label="ME")
    if eq is not None:
        some = _some(eq)
        axes.plot(along(result, eq)[some], eq.holding[some], ".", ms=4, color=INK["eq"], label="EQ")
    if solved is not None and eq is not None:
        axes.legend(fontsize="small", ncols=2, loc="lower right", borderpad=0.2)
    axes.set(ylabel="fraction\nthat holds", ylim=(0.0, 1.05))
    write_along(axes, result)
    return axes


def plot_deviation(axes: "Axes", result: Result) -> "Axes":
    """Ensemble less master equation in standard errors, where enough contacts have broken to tell."""
    off = deviation(result)[1]
    if (reason := why_not_compared(result)) is not None:
        middle: dict[str, Any] = {"ha": "center", "va": "center", "transform": axes.transAxes}
        axes.text(0.5, 0.5, f"not compared: {reason}", **middle)
    axes.axhspan(-2.0, 2.0, color="0.92", zorder=0)
    if result.eq is not None:
        axes.plot(along(result, result.eq)[telling(result)], off, ".", ms=3.5, color=INK["eq"])
    reach = max(4.0, 1.1 * float(np.abs(off).max(initial=0.0)))
    axes.set(ylabel="EQ − ME\n(std. errors)", ylim=(-reach, reach))
    write_along(axes, result)
    return axes


def plot_slips(axes: "Axes", result: Result) -> "Axes":
    """How late the slips of the replicas come, mean and standard error; N contacts slip late by some N^(-2/3)."""
    eq, beside = result.eq, slips_beside(result)
    if is_coupled(eq) and beside:
        unit = result.mean_threshold
        late = np.array([slip.mean_drive - slip.drive for slip in beside]) / unit
        error = np.array([slip.drive_error for slip in beside]) / unit
        at = np.interp([slip.drive for slip in beside], eq.path, along(result, eq))
        axes.errorbar(at, late, yerr=error, fmt="o", ms=3, capsize=2, lw=1, color=INK["eq"])
        scale = (eq.contacts / len(eq.forces)) ** (-2.0 / 3.0)
        axes.axhspan(0.0, scale, color="0.92", zorder=0, label="$N^{-2/3}$")
        axes.legend(fontsize="small", loc="upper left", borderpad=0.2)
    axes.axhline(0.0, color="0.6", lw=0.8, zorder=1)
    axes.set_ylabel("slips late\nby $X_T/\\langle x_s\\rangle$")
    write_along(axes, result)
    return axes


def plot_defects(axes: "Axes", result: Result) -> "Axes":
    """What the paper's closure of ageing does not keep: mass of P_c less 1, and weight below 0."""
    if isinstance(solved := result.master, AgeingRecord):
        path, below = along(result, solved), solved.positivity_defect
        axes.plot(path, solved.mass_defect, color=INK["master"], label="mass of $P_c$ less 1")
        axes.plot(path, below, "--", color=INK["eq"], label="weight below 0")
        most = max(float(np.abs(solved.mass_defect).max()), float(below.max()), _NO_DEFECT)
        axes.set(ylabel="defects\nof (Q15)", ylim=(-0.15 * most, 1.3 * most))
        axes.legend(fontsize="small")
        write_along(axes, result)
    return axes


def _some(eq: "Simulated") -> Any:
    """Indices of the points that are drawn of an ensemble."""
    return np.unique(np.linspace(0, eq.path.size - 1, _BARS).round().astype(int))


def _waits(result: Result) -> bool:
    """Whether contacts wait before they form again."""
    return any(bool((curve.holding < 1.0 - _ALL).any()) for curve in curves(result))


def save_picture(result: Result, path: Path) -> None:
    """The picture of a run as a PNG, on a figure of its own: the session's backend is not touched."""
    from matplotlib.figure import Figure

    below: list[Callable[[Any, Result], Any]] = []
    if curves(result) and clock(result) is not None:
        below.append(plot_position)
    if _waits(result):
        below.append(plot_holding)
    if slips_beside(result):
        below.append(plot_slips)
    elif result.master is not None and result.eq is not None:
        below.append(plot_deviation)
    elif isinstance(result.master, AgeingRecord):
        below.append(plot_defects)
    swept = [draw for draw, there in sweep_panels(result) if there]
    if not curves(result):
        swept = swept[1:]  # the first of them heads the picture
    heights = [3, *(1 for _ in below), *(2 for _ in swept)]
    figure = Figure(figsize=(10, 1 + sum(heights)), layout="constrained")
    rows: list[Any] = [["F", "P"], *([draw.__name__, "P"] for draw in (*below, *swept))]
    places = figure.subplot_mosaic(rows, width_ratios=[2.2, 1], height_ratios=heights)
    plot(result, [places["F"], places["P"]])
    for draw in swept:
        draw(places[draw.__name__], result)
    above = places["F"]
    for draw in below:
        own = draw(places[draw.__name__], result)
        own.sharex(places["F"])
        above.set_xlabel("")
        above = own
    figure.savefig(path, dpi=150, format="png")
