"""The picture of a comparison: the surface where all scenes share one, P_c, F(X), and the springs that slip."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from toolkit.judge.compare import Verdict
from toolkit.judge.deviation import deviation
from toolkit.pictures.axes import heights, name_lengths, plain
from toolkit.scene.scene import Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Okabe and Ito's, which the colour-blind tell apart too; curves that coincide leave each other in sight by their dashes
_INK = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#000000", "#e69f00", "#56b4e9"]
_DASHES: list[Any] = ["-", (0, (6, 3)), (0, (1.5, 2)), (0, (6, 2, 1, 2)), (0, (10, 4))]
_COLUMNS = 5  # names in a row
_BARS = 33  # error bars of a curve
_APART = 20.0  # lengths or heights that differ by more need a logarithmic axis


def save_comparison(verdicts: Sequence[Verdict], scenes: Sequence[Scene], path: Path) -> None:
    """All panels on one figure, as a PNG; the session's backend is not touched."""
    from toolkit.scene.surfaces import shared_surface

    draw_comparison(verdicts, shared_surface(scenes)).savefig(path, dpi=130, format="png")


def draw_comparison(verdicts: Sequence[Verdict], surface: Any = None) -> "Figure":
    """The figure; `surface`, where there is one, is its heights and sizes in m."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(13, 9), layout="constrained")
    columns = ["P", "S"] if surface is None else ["surface", "P", "S"]
    rows: list[Any] = [columns, ["F"] * len(columns), ["z"] * len(columns)]
    places = figure.subplot_mosaic(rows, height_ratios=[3, 3, 1.2])
    places["z"].sharex(places["F"])
    if surface is not None:
        plot_surface(places["surface"], *surface)
    plot_thresholds(places["P"], verdicts)
    plot_springs(places["S"], verdicts)
    plot_forces(places["F"], verdicts)
    plot_deviations(places["z"], verdicts)
    # below all axes: within them it would lie on curves
    named = places["F"].get_legend_handles_labels()
    if named[0]:
        number = min(len(named[0]), _COLUMNS)
        figure.legend(*named, loc="outside lower center", ncols=number, fontsize="small")
    return figure


def plot_surface(axes: "Axes", surface: Any, sizes: tuple[float, float]) -> "Axes":
    """Heights (m) over an area of `sizes` (m)."""
    extent = (0.0, sizes[0], 0.0, sizes[1])
    image = axes.imshow(surface.T, origin="lower", extent=extent, cmap="cividis")
    bar = axes.figure.colorbar(image, ax=axes, shrink=0.85)
    for axis, name in ((axes.xaxis, "x"), (axes.yaxis, "y"), (bar.ax.yaxis, "height")):
        name_lengths(axis, name, metres=True)
    axes.set_title("the surface")
    return axes


def plot_thresholds(axes: "Axes", verdicts: Sequence[Verdict]) -> "Axes":
    """P_c of each scene in units of its own mean threshold; exact values as spikes, on an axis for their weight."""
    reach, highest, tops, own = 0.0, 0.0, list[float](), None
    for ink, dash, verdict in _inked(verdicts):
        curve, unit = verdict.result.thresholds, verdict.mean_threshold
        shown, style = np.isfinite(curve.density), {"color": ink, "ls": dash, "lw": 1.3}
        x, density = curve.x[shown] / unit, curve.density[shown] * unit
        axes.plot(x, density, label=plain(verdict.name), **style)
        if density.any():
            tops.append(heights(curve, curve.density * unit).top)
        if curve.atoms.size:
            own = own or axes.twinx()
            highest = max(highest, float(curve.atom_weights.max()))
            own.vlines(curve.atoms / unit, 0.0, curve.atom_weights, **style)
            own.plot(curve.atoms / unit, curve.atom_weights, "D", ms=4, color=ink)
            reach = max(reach, float(curve.atoms.max()) / unit)
        reach = max(reach, float(curve.x[curve.survival > 2e-3].max(initial=unit)) / unit)
    axes.set(title="thresholds", xlabel=r"$x/\langle x_s\rangle$", xlim=(0.0, 1.05 * reach))
    if own is not None:
        own.set(ylabel="weight at one value (diamonds)", ylim=(0.0, 1.05 * highest))
    if not tops:
        axes.set(yticks=[])
        return axes
    axes.set_ylabel(r"$\langle x_s\rangle\,P_c$")
    if max(tops) > _APART * min(tops):
        axes.set(yscale="log", ylim=(min(tops) / 100.0, 2.0 * max(tops)))
    else:
        axes.set_ylim(0.0, 1.05 * max(tops))
    return axes


def plot_forces(axes: "Axes", verdicts: Sequence[Verdict]) -> "Axes":
    """F/F_k against X/<x_s>: master equation as lines, ensemble as error bars of one standard error."""
    reaches = []
    for ink, dash, verdict in _inked(verdicts):
        unit, name = verdict.mean_threshold, plain(verdict.name)
        scale = verdict.kinetic_force * unit
        solved, eq = verdict.result.master, verdict.result.eq
        reaches += [float(curve.path[-1]) / unit for curve in (solved, eq) if curve is not None]
        if solved is not None:
            line: dict[str, Any] = {"color": ink, "ls": dash, "lw": 1.3, "label": name}
            axes.plot(solved.path / unit, solved.force / scale, zorder=3, **line)
        if eq is not None:
            some = np.unique(np.linspace(0, eq.path.size - 1, _BARS).round().astype(int))
            bars: dict[str, Any] = {"yerr": eq.force_standard_error[some] / scale, "capsize": 1.5}
            bars |= {"fmt": "o", "ms": 2.5, "lw": 0.8, "color": ink, "zorder": 2}
            bars["label"] = None if solved is not None else name
            axes.errorbar(eq.path[some] / unit, eq.force[some] / scale, **bars)
    axes.axhline(1.0, color="0.6", lw=0.8, zorder=0)
    axes.set(ylabel="$F/F_k$", ylim=(0.0, None))
    shortest, longest = min(reaches, default=1.0), max(reaches, default=1.0)
    axes.set_xlim(0.0, 1.02 * longest)
    if longest > _APART * shortest:
        axes.set(xscale="log", xlim=(min(0.1, 0.1 * shortest), 1.05 * longest))
    axes.set_title("force: master equation (lines), EQ ensemble (points, ±1 standard error)")
    return axes


def plot_deviations(axes: "Axes", verdicts: Sequence[Verdict]) -> "Axes":
    """Ensemble less master equation in standard errors, where enough contacts have broken to tell."""
    for ink, _, verdict in _inked(verdicts):
        if verdict.result.master is not None and verdict.result.eq is not None:
            path, off = deviation(verdict.result)
            shown = slice(None, None, max(1, path.size // 60))
            axes.plot(path[shown] / verdict.mean_threshold, off[shown], ".", ms=3.5, color=ink)
    axes.axhspan(-2.0, 2.0, color="0.92", zorder=0)
    kind = ", logarithmic axis" if axes.get_xscale() == "log" else ""
    axes.set_xlabel(rf"slider position $X/\langle x_s\rangle${kind}")
    axes.set(ylabel="EQ − ME\n(std. errors)", ylim=(-5.0, 5.0))
    return axes


def plot_springs(axes: "Axes", verdicts: Sequence[Verdict]) -> "Axes":
    """K*/(N<k>) of each scene: a softer driving spring is unstable. Infinite ones reach the edge."""
    springs = [verdict.critical_spring for verdict in verdicts]
    finite = [spring for spring in springs if 0.0 < spring < np.inf]
    low, high = min([*finite, 1e-3]) / 3.0, max([*finite, 1.0]) * 3.0
    for row, (ink, _, verdict) in enumerate(_inked(verdicts)):
        value = min(max(verdict.critical_spring, low), high)
        bars = axes.barh(row, value - low, left=low, color=ink, height=0.6)
        text = "infinite" if np.isinf(verdict.critical_spring) else f"{verdict.critical_spring:.3g}"
        axes.bar_label(bars, [text], padding=3, fontsize="small")
    names = [plain(verdict.name) for verdict in verdicts]
    axes.set_yticks(range(len(verdicts)), names, fontsize="small")
    axes.invert_yaxis()
    room = (high / low) ** 0.2  # for the numbers behind the bars
    axes.set(xscale="log", xlim=(low, high * room), xlabel=r"$K^*/(N_c\langle k\rangle)$")
    axes.set_title("stick-slip below this spring")
    return axes


def _inked(verdicts: Sequence[Verdict]) -> list[tuple[str, Any, Verdict]]:
    """A colour and a dash for each."""
    return [
        (_INK[index % len(_INK)], _DASHES[index % len(_DASHES)], verdict)
        for index, verdict in enumerate(verdicts)
    ]
