"""The picture of scenes beside each other."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from toolkit.judge.compare import ComparedScene, common_unit
from toolkit.judge.lines import disagreements, range_of_spring
from toolkit.pictures.axes import in_lines, legend_above, name_axis, spring_name, style_of
from toolkit.pictures.thresholds import highest
from toolkit.results.kinds import is_precise
from toolkit.scene.scale import SHARED, written

_APART = 20.0  # lengths or heights that differ by more need a logarithmic axis
_SEEN = 1e-3  # of K*: shorter lines, of numerical errors, would be ticks
_MARKS = 0.1  # distance of the marks of a curve, in diagonals of the axes
_POINTS = 20  # of an ensemble's curve: as many as stand apart beside those of some other scenes


class _Styled:
    """A compared scene with its style, and the units in which it is drawn: metres and newtons or pascals where all
    scenes are of surfaces, else its own mean threshold and kinetic force."""

    def __init__(self, number: int, scene: ComparedScene, unit: str) -> None:
        self.scene, self.unit = scene, unit
        self.name = scene.name.replace("$", r"\$")
        self.style = style_of(number) | {"lw": 1.3, "ms": 4, "label": self.name}
        self.line = {key: own for key, own in self.style.items() if key not in ("marker", "ms")}
        self.mean = scene.result.mean_threshold
        self.length = self.mean if unit == SHARED else 1.0
        self.kinetic = scene.own.numbers["kinetic_force"].value * self.mean
        self.force = 1.0 / self.kinetic if unit == SHARED else scene.own.springs[unit]


def draw_comparison(compared: Sequence[ComparedScene]) -> Any:
    """P_c, springs that slip, and forces, a colour, a dash and a mark for each scene, on a figure of its own."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(13, 9), layout="constrained")
    places = figure.subplot_mosaic([["P", "S"], ["F", "F"]])
    unit = common_unit(compared)
    styled = [_Styled(number, scene, unit) for number, scene in enumerate(compared)]
    _thresholds(places["P"], styled)
    _springs(places["S"], styled)
    _forces(places["F"], styled)
    # below all axes: inside them it would cover curves
    handles, labels = places["P"].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=5)
    *first, last = [one.name for one in compared]
    said = [f"{', '.join(first)} and {last}" if first else last, *disagreements(compared)]
    figure.suptitle("\n".join(map(in_lines, said)), fontsize="medium", parse_math=False)
    return figure


def _thresholds(axes: Any, styled: list[_Styled]) -> None:
    """P_c of each scene, where lengths are on a logarithmic axis the density of ln x_s, whose area there is 1; exact
    values as spikes, on an axis for their weight."""
    curves = [one.scene.result.thresholds for one in styled]
    lasts = [
        1.05 * max([one.mean, *curve.atoms, *curve.x[curve.survival > 2e-3]]) / one.length
        for one, curve in zip(styled, curves, strict=True)
    ]
    tops, own, decades = list[float](), None, max(lasts) > _APART * min(lasts)
    for number, (one, curve) in enumerate(zip(styled, curves, strict=True)):
        unit, shown = one.length, np.isfinite(curve.density)
        density = curve.density * (curve.x if decades else unit)
        marked = one.style | {"markevery": (0.02 * number, _MARKS)}
        axes.plot(curve.x[shown] / unit, density[shown], **marked)
        if curve.density[shown].any():
            tops.append(highest(curve, density))
        if curve.atoms.size:
            own = own or axes.twinx()
            own.vlines(curve.atoms / unit, 0.0, curve.atom_weights, color=one.style["color"])
            own.plot(curve.atoms / unit, curve.atom_weights, "D", ms=4, color=one.style["color"])
            own.set(ylabel="weight at one value (diamonds)", ylim=(0.0, 1.05))
    axes.set(xlim=(0.0, max(lasts)), ylim=(0.0, 1.05 * max(tops, default=1.0)))
    if decades:
        axes.set(xscale="log", xlim=(1e-3 * min(lasts), max(lasts)))
    if tops and max(tops) > _APART * min(tops):
        axes.set(yscale="log", ylim=(min(tops) / 100.0, 2.0 * max(tops)))
    if styled[0].unit != SHARED:
        name_axis(axes.xaxis, "threshold $x_s$", "m")
    else:
        axes.set_xlabel(r"threshold $x_s/\langle x_s\rangle$")
        axes.set_ylabel(r"$\langle x_s\rangle\,P_c$")
    if styled[0].unit != SHARED and not decades:
        name_axis(axes.yaxis, "$P_c(x_s)$", "1/m", axes.xaxis)
    if decades:
        axes.set_ylabel("$x_s\\,P_c(x_s)$, per unit of $\\ln x_s$")


def _forces(axes: Any, styled: list[_Styled]) -> None:
    """F(X): master equation as lines, ensemble as error bars of one standard error; F_k of each scene at the edge.
    Where no scene has an ensemble, whose points they might be taken for, lines have the marks of their scenes."""
    extents, curves = list[float](), list[Any]()
    simulated = any(one.scene.result.eq is not None for one in styled)
    for number, one in enumerate(styled):
        unit, solved, eq = one.length, one.scene.result.master, one.scene.result.eq
        extents += [float(curve.path[-1]) / unit for curve in (solved, eq) if curve is not None]
        if solved is not None and is_precise(solved):
            marked = one.style | {"markevery": (0.02 * number, _MARKS)}
            style = one.line if simulated else marked
            curves += axes.plot(solved.path / unit, solved.force * one.force, zorder=3, **style)
        if eq is not None:
            # those of each scene between those of the others
            each = max(eq.path.size // _POINTS, 1)
            some = np.arange(number * each // len(styled), eq.path.size, each)
            bars: dict[str, Any] = {"fmt": one.style["marker"], "ms": 5, "lw": 0.8, "capsize": 1.5}
            error = eq.force_standard_error[some] * one.force
            bars |= {"color": one.style["color"], "yerr": error}
            axes.errorbar(eq.path[some] / unit, eq.force[some] * one.force, **bars)
        level = one.kinetic * one.force
        # thin and whole, as a scene's own curve may be dotted
        axes.axhline(level, color=one.style["color"], lw=0.6, zorder=0)
    axes.set(ylim=(0.0, None), xlim=(0.0, 1.02 * max(extents, default=1.0)))
    if extents and max(extents) > _APART * min(extents):
        least = min([*extents, *(one.mean / one.length for one in styled)])
        axes.set(xscale="log", xlim=(0.1 * least, 1.05 * max(extents)))
        # drawn from its first point of X > 0: from X = 0 on, a line would lead there at one level
        for curve in curves:
            place, force = curve.get_data()
            curve.set_data(place[place > 0.0], force[place > 0.0])
    levels = [one.kinetic * one.force for one in styled]
    if levels and max(levels) > _APART * min(levels):
        axes.set(yscale="log", ylim=(min(levels) / 100.0, 2.0 * max(levels)))
    points = ", points: ensemble" if simulated else ""
    axes.set_title(f"lines: master equation{points}, thin: $F_k$", fontsize="medium")
    if styled and styled[0].unit != SHARED:
        name_axis(axes.xaxis, "slider position $X$", "m")
        name = ("force $F$", "N") if styled[0].unit == "N/m" else ("shear stress $F/A$", "Pa")
        name_axis(axes.yaxis, *name)
    else:
        axes.set_xlabel(r"slider position $X/\langle x_s\rangle$")
        axes.set_ylabel("force $F/F_k$")


def _stiffness(one: _Styled) -> float:
    """N_c<k> of a scene in the unit in which springs are drawn."""
    return one.scene.own.springs[one.unit]


def _springs(axes: Any, styled: list[_Styled]) -> None:
    """K* of each scene as a mark, with a line over its readings and its error, in N/m or N/m³ of surfaces, else over
    N_c<k>; the axis is logarithmic and has no zero, from which a bar could begin. Machines' springs are dashed."""
    unit = styled[0].unit if styled else SHARED
    machines = [
        None if (k := one.scene.own.machine) is None else k * _stiffness(one) for one in styled
    ]
    finite = [
        value
        for one in styled
        for each in one.scene.readings
        if 0.0 < (value := each.spring(unit).value) < np.inf
    ]
    finite += [machine for machine in machines if machine]
    usual = [] if unit != SHARED and finite else [1e-3, 1.0]
    low, high = min([*finite, *usual]) / 3.0, max([*finite, *usual]) * 3.0
    axes.set(xscale="log", xlim=(low, high))
    for row, one in enumerate(styled):
        _spring(axes, row, one)
    for row, machine in enumerate(machines):
        if machine:
            axes.plot([machine] * 2, [row - 0.4, row + 0.4], "--", color="0.2", lw=1.4, zorder=4)
    axes.set_yticks(range(len(styled)), [one.name for one in styled])
    axes.set_ylim(len(styled) - 0.4, -0.6)
    name_axis(axes.xaxis, *spring_name(unit))
    _legend_of_springs(axes, styled, any(machines))


def _spring(axes: Any, row: int, one: _Styled) -> None:
    """One scene's K*, its number above the mark: an infinite one, and 0, as an arrow at the axis' end; one that is not
    known as an arrow at what it is below, or in words."""
    low, high = axes.get_xlim()
    own, spring = one.scene.own, one.scene.own.spring(one.unit)
    value, error = spring.value, spring.error or 0.0
    small: dict[str, Any] = {"fontsize": "small", "textcoords": "offset points"}
    if own.smoothed:
        said = "not known: it hangs on the smoothing of $P_c$"
        axes.annotate(said, (low, row), xytext=(8, 0), va="center", **small)
        return
    off = error if np.isfinite(value + error) else 0.0
    ends = np.clip(range_of_spring(one.scene, one.unit), low, high)  # as in the words
    if np.ptp(ends) > _SEEN * ends[1]:
        bars = {"xerr": np.ptp(ends) / 2.0, "color": "0.4", "capsize": 4, "lw": 1.2}
        axes.errorbar(np.mean(ends), row, fmt="none", **bars)
    digits = 2 if one.scene.of_a_scan else 3  # as in the table
    place, mark, text = value, one.style["marker"], written(value, "", off, digits)
    if off <= _SEEN * value:
        text = f"{value:.{digits}g}"
    if one.unit != SHARED:
        text = written(value, one.unit, off, digits)
    if own.unknown:
        place, mark = value + error, "<"
        most = f"{place:.2g}" if one.unit == SHARED else written(place, one.unit, digits=2)
        text = f"not known, below {most}"
    elif not low <= value <= high:
        mark, text = ("<", text) if value < low else (">", "infinite" if value == np.inf else text)
    place = float(np.clip(place, low, high))
    axes.plot(place, row, mark, color=one.style["color"], ms=9, clip_on=False, zorder=5)
    side = "left" if place < (low * high) ** 0.5 else "right"  # so that no number leaves the axes
    shift = -8 if (side == "left") != (mark in "<>") else 8
    axes.annotate(text, (place, row), xytext=(shift, 8), ha=side, **small)


def _legend_of_springs(axes: Any, styled: list[_Styled], machines: bool) -> None:
    """What marks, lines and dashes of the springs are."""
    said = "slips at least once on softer springs"
    if any(one.scene.mass for one in styled):
        said = "balance unstable somewhere on softer springs, without mass slips at least once"
    # of contacts that depend on time a slider may creep on softer springs, and slide smoothly
    if any(one.scene.conditions for one in styled):
        said = "steepest fall of a rigid slider's force"
    axes.plot([], [], "o", color="0.4", label=f"$K^*$: {said}")
    if any(hasattr(one, "has_xerr") for one in axes.containers):
        single = all(len(one.scene.readings) == 1 for one in styled)
        label = "its error" if single else "over the readings, with errors"
        if any(one.scene.found.sampled for one in styled):
            label += ", of samples two standard errors"
        axes.plot([], [], "-|", color="0.4", lw=1.2, label=label)
    if machines:
        axes.plot([], [], "--", color="0.2", lw=1.4, label="the machine's spring")
    legend_above(axes, letters=70)
