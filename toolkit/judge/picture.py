"""The picture of scenes beside each other."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from toolkit.judge.compare import Verdict, common_unit
from toolkit.pictures.thresholds import highest, some_of
from toolkit.results.records import is_known
from toolkit.scene.scale import SHARED

# colours by Okabe and Ito, which the colour-blind can distinguish; dashes keep coinciding curves visible
_INK = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#000000", "#e69f00", "#56b4e9"]
_DASHES: list[Any] = ["-", (0, (6, 3)), (0, (1.5, 2)), (0, (6, 2, 1, 2)), (0, (10, 4))]
_APART = 20.0  # lengths or heights that differ by more need a logarithmic axis


def draw_comparison(verdicts: Sequence[Verdict]) -> Any:
    """P_c, springs that slip, and forces, a colour and a dash for each scene, on a figure of its own."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(13, 9), layout="constrained")
    places = figure.subplot_mosaic([["P", "S"], ["F", "F"]])
    styled: list[tuple[dict[str, Any], Verdict]] = []
    for index, verdict in enumerate(verdicts):
        ink, dash = _INK[index % len(_INK)], _DASHES[index % len(_DASHES)]
        style = {"color": ink, "ls": dash, "lw": 1.3, "label": verdict.name.replace("$", r"\$")}
        styled.append((style, verdict))
    _thresholds(places["P"], styled)
    _springs(places["S"], styled)
    _forces(places["F"], styled)
    # below all axes: inside them it would cover curves
    figure.legend(*places["F"].get_legend_handles_labels(), loc="outside lower center", ncols=5)
    return figure


def _thresholds(axes: Any, styled: list[tuple[dict[str, Any], Verdict]]) -> None:
    """P_c of each scene in units of its own mean threshold; exact values as spikes, on an axis for their weight."""
    reach, tops, own = 0.0, list[float](), None
    for style, verdict in styled:
        curve, unit = verdict.result.thresholds, verdict.result.mean_threshold
        shown = np.isfinite(curve.density)
        axes.plot(curve.x[shown] / unit, curve.density[shown] * unit, **style)
        if curve.density[shown].any():
            tops.append(highest(curve, curve.density * unit))
        if curve.atoms.size:
            own = own or axes.twinx()
            own.vlines(curve.atoms / unit, 0.0, curve.atom_weights, color=style["color"])
            own.plot(curve.atoms / unit, curve.atom_weights, "D", ms=4, color=style["color"])
            own.set(ylabel="weight at one value (diamonds)", ylim=(0.0, 1.05))
        reach = max(reach, 1.05 * max([unit, *curve.atoms, *curve.x[curve.survival > 2e-3]]) / unit)
    axes.set(title="thresholds", xlabel=r"$x/\langle x_s\rangle$", xlim=(0.0, reach))
    axes.set(ylabel=r"$\langle x_s\rangle\,P_c$", ylim=(0.0, 1.05 * max(tops, default=1.0)))
    if tops and max(tops) > _APART * min(tops):
        axes.set(yscale="log", ylim=(min(tops) / 100.0, 2.0 * max(tops)))


def _forces(axes: Any, styled: list[tuple[dict[str, Any], Verdict]]) -> None:
    """F/F_k against X/<x_s>: master equation as lines, ensemble as error bars of one standard error."""
    reaches = []
    for style, verdict in styled:
        unit, solved, eq = verdict.result.mean_threshold, verdict.result.master, verdict.result.eq
        scale = verdict.value("kinetic_force") * unit
        reaches += [float(curve.path[-1]) / unit for curve in (solved, eq) if curve is not None]
        if solved is not None and is_known(solved):
            axes.plot(solved.path / unit, solved.force / scale, zorder=3, **style)
        if eq is not None:
            some = some_of(eq.path.size, 33)
            bars: dict[str, Any] = {"fmt": "o", "ms": 2.5, "lw": 0.8, "capsize": 1.5}
            bars |= {"color": style["color"], "label": style["label"] if solved is None else None}
            error = eq.force_standard_error[some] / scale
            axes.errorbar(eq.path[some] / unit, eq.force[some] / scale, yerr=error, **bars)
    axes.axhline(1.0, color="0.6", lw=0.8, zorder=0)
    axes.set(ylabel="$F/F_k$", ylim=(0.0, None), xlim=(0.0, 1.02 * max(reaches, default=1.0)))
    if reaches and max(reaches) > _APART * min(reaches):
        axes.set(xscale="log", xlim=(0.1 * min(1.0, *reaches), 1.05 * max(reaches)))
    axes.set_xlabel(r"slider position $X/\langle x_s\rangle$")
    simulated = any(verdict.result.eq is not None for _, verdict in styled)
    points = ", EQ ensemble (points, ±1 standard error)" if simulated else ""
    axes.set_title(f"force: master equation (lines){points}")


def _springs(axes: Any, styled: list[tuple[dict[str, Any], Verdict]]) -> None:
    """K* of each scene, in N/m if all have an area, else over N<k>: a softer driving spring is unstable. Infinite ones
    reach the edge."""
    unit = common_unit([verdict for _, verdict in styled])
    springs = [verdict.spring(unit).value for _, verdict in styled]
    finite = [spring for spring in springs if 0.0 < spring < np.inf]
    usual = [] if unit != SHARED and finite else [1e-3, 1.0]
    low, high = min([*finite, *usual]) / 3.0, max([*finite, *usual]) * 3.0
    for row, (spring, (style, _)) in enumerate(zip(springs, styled, strict=True)):
        width = min(max(spring, low), high) - low
        bars = axes.barh(row, width, left=low, color=style["color"], height=0.6)
        text = "infinite" if np.isinf(spring) else f"{spring:.3g}"
        axes.bar_label(bars, [text], padding=12 if np.isinf(spring) else 3, fontsize="small")
        if np.isinf(spring):
            axes.plot(high, row, ">", color=style["color"], ms=18, clip_on=False)
    axes.set_yticks(range(len(styled)), [style["label"] for style, _ in styled])
    axes.invert_yaxis()
    room = (high / low) ** 0.2  # for the numbers behind the bars
    label = f"$K^*$ ({unit})" if unit != SHARED else r"$K^*/(N_c\langle k\rangle)$"
    axes.set(xscale="log", xlim=(low, high * room), xlabel=label)
    axes.set_title("a slider slips below this spring")
