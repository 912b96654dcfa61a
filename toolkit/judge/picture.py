"""The picture of scenes beside each other."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from toolkit.judge.compare import ComparedScene, common_unit
from toolkit.judge.lines import disagreements
from toolkit.pictures.axes import in_lines, name_axis, some_of, spring_name, style_of
from toolkit.pictures.thresholds import highest
from toolkit.results.kinds import is_precise
from toolkit.scene.scale import SHARED, written

_APART = 20.0  # lengths or heights that differ by more need a logarithmic axis
_SEEN = 1e-3  # of K*: shorter lines, of numerical errors, would be ticks
_MARKS = 0.1  # distance of the marks of a curve, in diagonals of the axes


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
    if said := disagreements(compared):
        figure.suptitle("\n".join(map(in_lines, said)), fontsize="medium", parse_math=False)
    return figure


def _thresholds(axes: Any, styled: list[_Styled]) -> None:
    """P_c of each scene; exact values as spikes, on an axis for their weight."""
    lasts, tops, own = list[float](), list[float](), None
    for number, one in enumerate(styled):
        curve, unit = one.scene.result.thresholds, one.length
        shown = np.isfinite(curve.density)
        marked = one.style | {"markevery": (0.02 * number, _MARKS)}
        axes.plot(curve.x[shown] / unit, curve.density[shown] * unit, **marked)
        if curve.density[shown].any():
            tops.append(highest(curve, curve.density * unit))
        if curve.atoms.size:
            own = own or axes.twinx()
            own.vlines(curve.atoms / unit, 0.0, curve.atom_weights, color=one.style["color"])
            own.plot(curve.atoms / unit, curve.atom_weights, "D", ms=4, color=one.style["color"])
            own.set(ylabel="weight at one value (diamonds)", ylim=(0.0, 1.05))
        last = max([one.mean, *curve.atoms, *curve.x[curve.survival > 2e-3]])
        lasts.append(1.05 * last / unit)
    axes.set(title="thresholds", xlim=(0.0, max(lasts)), ylim=(0.0, 1.05 * max(tops, default=1.0)))
    if max(lasts) > _APART * min(lasts):
        axes.set(xscale="log", xlim=(1e-3 * min(lasts), max(lasts)))
    if tops and max(tops) > _APART * min(tops):
        axes.set(yscale="log", ylim=(min(tops) / 100.0, 2.0 * max(tops)))
    if styled and styled[0].unit != SHARED:
        name_axis(axes.xaxis, "threshold $x_s$", "m")
        name_axis(axes.yaxis, "$P_c(x_s)$", "1/m", axes.xaxis)
    else:
        axes.set_xlabel(r"threshold $x_s/\langle x_s\rangle$")
        axes.set_ylabel(r"$\langle x_s\rangle\,P_c$")


def _forces(axes: Any, styled: list[_Styled]) -> None:
    """F(X): master equation as lines, ensemble as error bars of one standard error; F_k of each scene at the edge."""
    extents, curves = list[float](), list[Any]()
    for one in styled:
        unit, solved, eq = one.length, one.scene.result.master, one.scene.result.eq
        extents += [float(curve.path[-1]) / unit for curve in (solved, eq) if curve is not None]
        if solved is not None and is_precise(solved):
            curves += axes.plot(solved.path / unit, solved.force * one.force, zorder=3, **one.line)
        if eq is not None:
            some = some_of(eq.path.size, 33)
            bars: dict[str, Any] = {"fmt": one.style["marker"], "ms": 3, "lw": 0.8, "capsize": 1.5}
            error = eq.force_standard_error[some] * one.force
            bars |= {"color": one.style["color"], "yerr": error}
            axes.errorbar(eq.path[some] / unit, eq.force[some] * one.force, **bars)
        level = one.kinetic * one.force
        axes.axhline(level, color=one.style["color"], lw=0.8, ls=":", zorder=0)
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
    simulated = any(one.scene.result.eq is not None for one in styled)
    points = ", EQ ensemble (points, ±1 standard error)" if simulated else ""
    axes.set_title(f"force: master equation (lines){points}; $F_k$ dotted")
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
    """K* of each scene with its error and its range over the readings, in N/m or N/m³ of surfaces, else over N_c<k>: a
    softer driving spring is unstable. Infinite ones reach the edge."""
    unit = styled[0].unit if styled else SHARED
    springs = [one.scene.own.spring(unit) for one in styled]
    over = [[each.spring(unit).value for each in one.scene.readings] for one in styled]
    machines = [
        None if (k := one.scene.own.machine) is None else k * _stiffness(one) for one in styled
    ]
    finite = [value for values in over for value in values if 0.0 < value < np.inf]
    finite += [machine for machine in machines if machine]
    usual = [] if unit != SHARED and finite else [1e-3, 1.0]
    low, high = min([*finite, *usual]) / 3.0, max([*finite, *usual]) * 3.0
    small: dict[str, Any] = {"va": "center", "fontsize": "small"}
    for row, (spring, one, values) in enumerate(zip(springs, styled, over, strict=True)):
        color, value, error = one.style["color"], spring.value, spring.error or 0.0
        # dark at its edge, as there may be no bar behind it
        mark: dict[str, Any] = {"color": "white", "mec": "0.2", "ms": 6, "zorder": 5}
        axes.plot(low * (high / low) ** 0.03, row, one.style["marker"], **mark)
        if machine := machines[row]:
            axes.plot([machine] * 2, [row - 0.4, row + 0.45], "--", color="0.2", lw=1.4, zorder=4)
        unknown = one.scene.own.unknown
        if one.scene.own.smoothed:
            said = "not known: it hangs on the smoothing of $P_c$"
            beside = {"xytext": (20, 0), "textcoords": "offset points"}
            axes.annotate(said, (low, row), **beside, **small)
            continue
        if not unknown:
            axes.barh(row, min(max(value, low), high) - low, left=low, color=color, height=0.6)
        off = error if np.isfinite(value + error) else 0.0
        ends = np.clip([min([*values, value - off]), max([*values, value + off])], low, high)
        if np.ptp(ends) > _SEEN * ends[1]:  # below the bar, whose number is beside it
            bars = {"xerr": np.ptp(ends) / 2.0, "color": "0.2", "capsize": 4}
            axes.errorbar(np.mean(ends), row + 0.4, **bars)
        digits = 2 if one.scene.of_a_scan else 3  # as in the table
        shared = written(value, "", off) if off > _SEEN * value else f"{value:.{digits}g}"
        text = "infinite" if np.isinf(value) else shared if unit == SHARED else ""
        beyond = {"xytext": (12 if np.isinf(value) else 5, 0), "textcoords": "offset points"}
        place = (min(max(value, low), high), row)
        if unknown:  # and its error reaches from the edge to where it is below
            place, most = (low, row), value + error
            text = f"not known, below {most:.2g}" if unit == SHARED else ""
            text = text or f"not known, below {written(most, unit, digits=2)}"
            beyond["xytext"] = (20, 0)
        axes.annotate(text or written(value, unit, off, digits), place, **beyond, **small)
        if np.isinf(value):
            axes.plot(high, row, ">", color=color, ms=18, clip_on=False)
    axes.set_yticks(range(len(styled)), [one.name for one in styled])
    axes.invert_yaxis()
    room = (high / low) ** 0.2  # for the numbers behind the bars
    axes.set(xscale="log", xlim=(low, high * room))
    name_axis(axes.xaxis, *spring_name(unit))
    legend = ["a slider slips at least once on springs below $K^*$"]
    # of contacts that depend on time a slider may creep on softer springs, and slide smoothly
    if any(one.scene.conditions for one in styled):
        legend = ["$K^*$, the steepest fall of a rigid slider's force"]
    if any(hasattr(one, "has_xerr") for one in axes.containers):
        single = all(len(values) == 1 for values in over)
        legend.append(f"lines: {'' if single else 'readings that were solved, and '}errors")
    if any(machines):
        legend.append("dashed: the machine's spring")
    axes.set_title("\n".join([legend[0], "; ".join(legend[1:])]).strip(), fontsize="medium")
