"""The picture of a comparison: the surface where all scenes share one, P_c, F(X), and the springs that slip."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from toolkit.judge.compare import Verdict
from toolkit.judge.deviation import deviation
from toolkit.pictures.axes import Lengths, heights, plain
from toolkit.scene.scene import Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Okabe and Ito's, which the colour-blind tell apart too
_INK = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#000000", "#e69f00", "#56b4e9"]
# the first is solid, and each of the others has gaps through which those drawn before are seen
_DASHES = [
    "-",
    (0, (6, 3)),
    (0, (1.5, 2)),
    (0, (6, 2, 1, 2)),
    (0, (3, 3)),
    (0, (10, 4)),
    (0, (6, 2, 1, 2, 1, 2)),
]
_COLUMNS = 5  # names in a row
_BARS = 33
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
        figure.legend(
            *named, loc="outside lower center", ncols=min(len(named[0]), _COLUMNS), fontsize="small"
        )
    return figure


def plot_surface(axes: "Axes", surface: Any, sizes: tuple[float, float]) -> "Axes":
    """Heights (m) over an area of `sizes` (m)."""
    image = axes.imshow(
        surface.T, origin="lower", extent=(0.0, sizes[0], 0.0, sizes[1]), cmap="cividis"
    )
    bar = axes.figure.colorbar(image, ax=axes, shrink=0.85)
    Lengths.of(float(np.nanmax(np.abs(surface))), metres=True).write(bar.ax.yaxis, "height")
    for axis, name in ((axes.xaxis, "x"), (axes.yaxis, "y")):
        Lengths.of(max(sizes), metres=True).write(axis, name)
    axes.set_title("the surface")
    return axes


def plot_thresholds(axes: "Axes", verdicts: Sequence[Verdict]) -> "Axes":
    """P_c of each scene in units of its own mean threshold; exact values as spikes, on an axis for their weight."""
    reach, highest, limits = 0.0, 0.0, []
    own = None
    for ink, dash, verdict in _inked(verdicts):
        curve, unit = verdict.result.thresholds, verdict.mean_threshold
        shown = np.isfinite(curve.density)
        axes.plot(
            curve.x[shown] / unit,
            curve.density[shown] * unit,
            color=ink,
            ls=dash,
            lw=1.3,
            label=plain(verdict.name),
        )
        if curve.density[shown].any():
            limits.append(heights(curve, curve.density * unit))
        if curve.atoms.size:
            own = own or axes.twinx()
            highest = max(highest, float(curve.atom_weights.max()))
            own.vlines(curve.atoms / unit, 0.0, curve.atom_weights, color=ink, ls=dash, lw=1.5)
            own.plot(curve.atoms / unit, curve.atom_weights, "D", ms=4, color=ink)
            reach = max(reach, float(curve.atoms.max()) / unit)
        reach = max(reach, float(curve.x[curve.survival > 2e-3].max(initial=unit)) / unit)
    axes.set(
        title="thresholds", xlabel=r"$x/\langle x_s\rangle$", ylabel=r"$\langle x_s\rangle\,P_c$"
    )
    axes.set_xlim(0.0, 1.05 * reach)
    if own is not None:
        own.set(ylabel="weight at one value (diamonds)", ylim=(0.0, 1.05 * highest))
    if not limits:
        axes.set(ylabel="", yticks=[])
    tops = [one.top for one in limits] or [1.0]
    if max(tops) > _APART * min(tops):
        axes.set(yscale="log", ylim=(min(tops) / 100.0, 2.0 * max(tops)))
    else:
        axes.set_ylim(0.0, 1.05 * max(tops))
    return axes


def plot_forces(axes: "Axes", verdicts: Sequence[Verdict]) -> "Axes":
    """F/F_k against X/<x_s>: master equation as lines, ensemble as error bars of one standard error."""
    for ink, dash, verdict in _inked(verdicts):
        unit = verdict.mean_threshold
        scale = verdict.kinetic_force * unit
        solved, eq = verdict.result.master, verdict.result.eq
        if solved is not None:
            x, y = solved.path / unit, solved.force / scale
            axes.plot(x, y, color=ink, ls=dash, lw=1.3, zorder=3, label=plain(verdict.name))
        if eq is not None:
            shown = np.unique(np.linspace(0, eq.path.size - 1, _BARS).round().astype(int))
            axes.errorbar(
                eq.path[shown] / unit,
                eq.force[shown] / scale,
                yerr=eq.force_standard_error[shown] / scale,
                fmt="o",
                ms=2.5,
                capsize=1.5,
                lw=0.8,
                zorder=2,
                color=ink,
                label=None if solved is not None else plain(verdict.name),
            )
    axes.axhline(1.0, color="0.6", lw=0.8, zorder=0)
    axes.set(ylabel="$F/F_k$", ylim=(0.0, None))
    reaches = [
        float(curve.path[-1]) / verdict.mean_threshold
        for verdict in verdicts
        for curve in (verdict.result.master, verdict.result.eq)
        if curve is not None
    ]
    shortest, longest = min(reaches, default=1.0), max(reaches, default=1.0)
    if longest > _APART * shortest:
        axes.set(xscale="log", xlim=(min(0.1, 0.1 * shortest), 1.05 * longest))
    else:
        axes.set_xlim(0.0, 1.02 * longest)
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
    axes.set(
        xlabel=rf"slider position $X/\langle x_s\rangle${kind}",
        ylabel="EQ − ME\n(std. errors)",
        ylim=(-5.0, 5.0),
    )
    return axes


def plot_springs(axes: "Axes", verdicts: Sequence[Verdict]) -> "Axes":
    """K*/(N<k>) of each scene: a softer driving spring is unstable. Infinite ones reach the edge."""
    finite = [
        verdict.critical_spring for verdict in verdicts if 0.0 < verdict.critical_spring < np.inf
    ]
    low, high = min([*finite, 1e-3]) / 3.0, max([*finite, 1.0]) * 3.0
    room = (high / low) ** 0.2  # for the numbers behind the bars
    for row, (ink, _, verdict) in enumerate(_inked(verdicts)):
        value = min(max(verdict.critical_spring, low), high)
        axes.barh(row, value - low, left=low, color=ink, height=0.6)
        text = "infinite" if np.isinf(verdict.critical_spring) else f"{verdict.critical_spring:.3g}"
        axes.annotate(
            text,
            (value, row),
            xytext=(3, 0),
            textcoords="offset points",
            va="center",
            fontsize="small",
        )
    axes.set_yticks(
        range(len(verdicts)), [plain(verdict.name) for verdict in verdicts], fontsize="small"
    )
    axes.invert_yaxis()
    axes.set(xscale="log", xlim=(low, high * room), xlabel=r"$K^*/(N_c\langle k\rangle)$")
    axes.set_title("stick-slip below this spring")
    return axes


def _inked(verdicts: Sequence[Verdict]) -> list[tuple[str, Any, Verdict]]:
    """A colour and a dash for each: of curves that coincide the later ones leave the earlier in sight."""
    rounds = len(_INK)
    return [
        (_INK[index % rounds], _DASHES[(index + index // rounds) % len(_DASHES)], verdict)
        for index, verdict in enumerate(verdicts)
    ]
