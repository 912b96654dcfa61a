"""Pictures of a run: a figure of panels, each a function that takes matplotlib axes and returns them.

Forces are in newtons, or pascals, of a surface; other data in the unit of the thresholds.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from toolkit.pictures.axes import (
    INK,
    MARKERS,
    force_name,
    in_lines,
    legend_above,
    name_axis,
    name_over_load,
    some_of,
)
from toolkit.pictures.critical_spring import (
    flat_spring,
    keys_of_spring,
    plot_points_spring,
    with_spring,
)
from toolkit.pictures.legs import mark_legs, write_along
from toolkit.pictures.points import plot_points, plot_points_swing, with_swing
from toolkit.pictures.thresholds import plot_density
from toolkit.pictures.traces import (
    along,
    draw_curve,
    in_time,
    moments,
    slips_of,
    swings_between,
    with_slips,
)
from toolkit.results.beside import NOT_COMPARED, deviation
from toolkit.results.kinds import is_coupled, is_heavy, is_precise
from toolkit.results.records import Result

_BARS = 61  # error bars; with more the line would be hidden
_REPLICAS = 5  # as can be distinguished
_PANEL = 70  # letters across the panel of forces
_RESOLVED = 8  # points of the path within a slip that show it as well as can be seen
_IN_A_BAND = "; a band, where it swings between points"
_OF_EQ: dict[str, Any] = {"color": INK["eq"], "lw": 0.7, "alpha": 0.7, "zorder": 2}


def plot(result: Result, axes: Any = None) -> Any:
    """The picture of a Result of toolkit.run or toolkit.load as a matplotlib Figure, whose `.axes` are F(X) from every
    solver, F(t) where the drive or slips take time, or F_k along a sweep if there is nothing else; P_c(x); and panels
    of what else the run has.

    Left out, `axes` are those of a new figure of pyplot: ``toolkit.plot(result).savefig("picture.pdf")``. Into a pair
    of matplotlib's `axes` only the first two are drawn; returned is their figure.
    """
    if axes is not None:
        (plot_force if result.curves else plot_points)(axes[0], result)
        legend_above(axes[0], title=result.title or result.name)
        plot_density(axes[1], result.thresholds)
        return axes[0].figure
    from matplotlib import pyplot

    return draw_run(result, pyplot.figure(layout="constrained"))


def plot_force(axes: Any, result: Result) -> Any:
    """The force against X or X_T, or t where the drive or slips take time, in the unit of the result's scale.

    The master equation is a line, the ensemble error bars of one standard error; on a soft slider it is some replicas,
    since their mean during a slip is the force of none of them. Each slip is drawn from its own data.
    """
    solved, eq, factor = result.master, result.eq, result.scale.force
    if solved is not None and eq is None and not is_precise(solved):
        said = f"the master equation is not solved:\n{in_lines(solved.message, _PANEL)}"
        middle: dict[str, Any] = {"ha": "center", "va": "center", "transform": axes.transAxes}
        axes.text(0.5, 0.5, said, parse_math=False, **middle)
        axes.set_axis_off()
        return axes
    if solved is not None:
        _draw_solved(axes, result)
    if is_coupled(eq):
        number = min(_REPLICAS, len(eq.forces))
        for replica in range(number):
            slips = slips_of(eq, replica)
            place, force = with_slips(along(result, eq), eq.path, eq.forces[replica], slips)
            label = f"EQ, {number} of {len(eq.forces)} replicas of {eq.contacts // len(eq.forces):,} contacts"
            swings = swings_between(eq, eq.forces[replica], replica)
            style = _OF_EQ | {"label": None if replica else label + _IN_A_BAND * swings}
            draw_curve(axes, place, factor * force, swings, style)
    elif eq is not None:
        some = some_of(eq.path.size, _BARS)
        place, error = along(result, eq)[some], factor * eq.force_standard_error[some]
        style = {"color": INK["eq"], "fmt": "o", "ms": 3, "capsize": 2, "lw": 1}
        label = "EQ, ±1 standard error"
        axes.errorbar(place, factor * eq.force[some], yerr=error, label=label, **style)
    write_along(axes, result)
    mark_legs(axes, result)
    name = "spring force" if is_heavy(eq) or getattr(solved, "velocity", None) is not None else ""
    _name_forces(axes, result, name)
    legend_above(axes)
    return axes


def _draw_solved(axes: Any, result: Result) -> None:
    """The master equation's force, dashed where its error is not as asked, left out where it is not known."""
    solved: Any = result.master
    label = "master equation"
    if not solved.success:
        error = result.scale.error(solved.force_error, result.mean_threshold)
        error = error.replace("<x_s>", "$\\langle x_s\\rangle$")
        label += f", error {error}: not as asked"
    place, force = along(result, solved), solved.force
    place, force = with_slips(place, solved.path, force, slips_of(solved))
    if not is_precise(solved):
        label, place, force = "master equation: not solved", place[:0], force[:0]
    line = "-" if solved.success else "--"
    style: dict[str, Any] = {"color": INK["master"], "lw": 1.4, "zorder": 3, "ls": line}
    swings = swings_between(solved, solved.force)
    style["label"] = label + _IN_A_BAND * swings
    draw_curve(axes, place, result.scale.force * force, swings, style)
    if solved.outrun is not None and place.size and solved.outrun < place[-1]:
        label = "contacts outrun $P_c$ (Q15)"
        axes.axvspan(solved.outrun, place[-1], color="0.9", lw=0, label=label)


def _name_forces(axes: Any, result: Result, name: str) -> None:
    """Label the axis of forces, and opposite to it that of F over the load, of a surface."""
    scale = result.scale
    usual, unit = force_name(scale)
    name_axis(axes.yaxis, usual.replace("force", name) if name else usual, unit)
    name_over_load(axes, scale)


def plot_position(axes: Any, result: Result) -> Any:
    """Positions of the drive, or of the rigid slider, and of a soft slider against time; in some of the replicas."""
    curve = result.curves[0]
    soft = getattr(curve, "position", None) is not None
    name = "drive $X_T$" if soft else "slider $X$"
    axes.plot(along(result, curve), curve.path, color="0.4", ls="--" * soft or "-", label=name)
    solved, eq = result.master, result.eq
    if solved is not None and solved.position is not None and is_precise(solved):
        place, slips = along(result, solved), slips_of(solved)
        drawn = with_slips(place, solved.path, solved.position, slips, position=True)
        style = {"color": INK["master"], "lw": 1.2, "label": "slider $X$"}
        draw_curve(axes, *drawn, swings_between(solved, solved.position), style)
    if is_coupled(eq):
        for replica in range(min(_REPLICAS, len(eq.forces))):
            slips, own = slips_of(eq, replica), eq.positions[replica]
            drawn = with_slips(along(result, eq), eq.path, own, slips, position=True)
            style = _OF_EQ | {"label": None if replica else "slider $X$, EQ"}
            draw_curve(axes, *drawn, swings_between(eq, own, replica), style)
    if soft:
        legend_above(axes)
    write_along(axes, result)
    mark_legs(axes, result, named=True)
    name_axis(axes.yaxis, "position\n", result.scale.length_unit)
    return axes


def plot_holding(axes: Any, result: Result) -> Any:
    """The fraction of the contacts that hold, of a soft slider's replicas their mean; the others wait to form again."""
    for curve, ink in ((result.master, "master"), (result.eq, "eq")):
        if curve is not None and (ink == "eq" or is_precise(curve)):
            # of a soft slider it moves much between the points of some
            whole = ink == "master" or is_coupled(curve)
            some, mark = (
                slice(None) if whole else some_of(curve.path.size, _BARS),
                "-" if whole else ".",
            )
            place = along(result, curve)[some]
            axes.plot(place, curve.holding[some], mark, color=INK[ink], ms=4, lw=1.2)
    eq = result.eq
    several = eq is not None and is_coupled(eq) and len(eq.forces) > 1
    name = "fraction that\nholds, mean" if several else "fraction\nthat holds"
    axes.set(ylabel=name, ylim=(0.0, 1.05))
    write_along(axes, result)
    mark_legs(axes, result)
    return axes


def plot_deviation(axes: Any, result: Result) -> Any:
    """Ensemble minus master equation in standard errors, where enough contacts have broken for a comparison."""
    apart = deviation(result)
    if apart.worst is None:
        middle: dict[str, Any] = {"ha": "center", "va": "center", "transform": axes.transAxes}
        axes.text(0.5, 0.5, in_lines(f"not compared: {NOT_COMPARED}", _PANEL), **middle)
    axes.axhspan(-2.0, 2.0, color="0.92", zorder=0)
    if result.eq is not None:
        axes.plot(along(result, result.eq)[apart.points], apart.off, ".", color=INK["eq"], ms=3.5)
    largest = max(4.0, 1.1 * (apart.worst or 0.0))
    axes.set(ylabel="EQ − ME\n(std. errors)", ylim=(-largest, largest))
    write_along(axes, result)
    return axes


def plot_velocity(axes: Any, result: Result) -> Any:
    """The speed of a slider with mass at the points of the path: of the master equation, and in some replicas; slips by
    their top speeds, from their own data, since points of the path may all lie between."""
    solved, eq = result.master, result.eq
    if eq is not None:
        for replica in range(min(_REPLICAS, len(eq.forces))):
            swings = swings_between(eq, eq.velocities[replica], replica, speed=True)
            draw_curve(axes, along(result, eq), eq.velocities[replica], swings, _OF_EQ)
            own = eq.forces[replica], eq.velocities[replica]
            _draw_top_speeds(axes, result, eq, *own, replica)
    if solved is not None and solved.velocity is not None and is_precise(solved):
        swings = swings_between(solved, solved.velocity, speed=True)
        style = {"color": INK["master"], "lw": 1.2}
        draw_curve(axes, along(result, solved), solved.velocity, swings, style)
        _draw_top_speeds(axes, result, solved, solved.force, solved.velocity, None)
    write_along(axes, result)
    mark_legs(axes, result)
    name_axis(axes.yaxis, "slider's speed\n", result.scale.speed_unit)
    legend_above(axes)
    return axes


def _draw_top_speeds(
    axes: Any, result: Result, curve: Any, force: Any, speed: Any, replica: int | None
) -> None:
    """The top speed of each slip: as a line at half its duration, or a light mark where it is the largest of the speeds
    at the path's own points, if enough of these lie within the slip."""
    slips = slips_of(curve, replica)
    if slips is None or slips.top_speed is None or slips.duration is None or not slips.drive.size:
        return
    place = along(result, curve)
    begin = moments(place, curve.path, force, slips)
    first, last = (np.searchsorted(place, time) for time in (begin, begin + slips.duration))
    at, shown = begin + 0.5 * slips.duration, last - first >= _RESOLVED
    for k in np.flatnonzero(shown):
        at[k] = place[first[k] + np.argmax(np.abs(speed[first[k] : last[k]]))]
    ink, mark = (INK["master"], MARKERS[0]) if replica is None else (INK["eq"], MARKERS[2])
    label = f"top speed of a slip{', EQ' * (replica == 0)}" if replica in (None, 0) else None
    for points_show_it, size in ((True, 2.5), (False, 4.0)):
        some = np.isfinite(at) & (shown == points_show_it)
        if some.any():
            axes.plot(at[some], slips.top_speed[some], mark, color=ink, ms=size, label=label)
            label = None  # once is enough
            if not points_show_it:
                axes.vlines(at[some], 0.0, slips.top_speed[some], color=ink, lw=0.7, alpha=0.7)


def _shows_slips(result: Result) -> bool:
    """Whether points of the path lie in most slips that last, or in the delay after them: else the fraction that holds
    at some point tells by chance whether a slip is near."""
    wait = float((result.asked.contacts.delay or {}).get("time", 0.0))
    between = float(np.median(np.diff(result.time))) if in_time(result) else 0.0
    slips = [slips_of(curve) for curve in result.curves]
    lasting = [one.duration for one in slips if one is not None and one.duration is not None]
    return all(not lasts.size or np.median(lasts) + wait >= between for lasts in lasting)


def draw_run(result: Result, figure: Any) -> Any:
    """Draw all panels of a run on an empty figure, and return it."""
    solved, below = result.master, list[Callable[[Any, Result], Any]]()
    if in_time(result):
        below.append(plot_position)
    if is_heavy(result.eq) or getattr(solved, "velocity", None) is not None:
        below.append(plot_velocity)
    if any((curve.holding < 1.0 - 1e-9).any() for curve in result.curves) and _shows_slips(result):
        below.append(plot_holding)
    if solved is not None and result.eq is not None and not is_coupled(result.eq):
        below.append(plot_deviation)
    swept: list[Any] = [plot_points] if result.curves and result.sweep is not None else []
    flat = flat_spring(result) if with_spring(result.sweep) else ""
    if with_spring(result.sweep) and keys_of_spring(result):
        swept.append(plot_points_spring)
    if with_swing(result.sweep):
        swept.append(plot_points_swing)
    tall = plot_position, plot_velocity
    heights = [3.0, *(1.6 if draw in tall else 1.0 for draw in below), *(2.0 for _ in swept)]
    figure.set_size_inches(10, 1.2 + sum(heights))
    rows: list[Any] = [["F", "P"], *([draw.__name__, "P"] for draw in (*below, *swept))]
    places = figure.subplot_mosaic(rows, width_ratios=[2.2, 1], height_ratios=heights)
    (plot_force if result.curves else plot_points)(places["F"], result)
    plot_density(places["P"], result.thresholds)
    along = () if result.sweep is None else result.sweep.along
    if any(key.startswith("contacts.thresholds") for key in along):
        places["P"].set_title("thresholds, without the sweep")
    for draw in (*swept, *below):
        draw(places[draw.__name__], result)
    for draw, above in zip(below, ["F", *(draw.__name__ for draw in below)], strict=False):
        places[draw.__name__].sharex(places["F"])
        places[above].set_xlabel("")
    title = "\n".join(map(in_lines, filter(None, [result.title or result.name, flat])))
    figure.suptitle(title, parse_math=False)
    return figure


def save_picture(result: Result, path: Path) -> None:
    """The picture of a run in the format of the path's suffix, on a figure of its own: the session's backend is not
    touched."""
    from matplotlib.figure import Figure

    draw_run(result, Figure(layout="constrained")).savefig(path, dpi=150, format=path.suffix[1:])
