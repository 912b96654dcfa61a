"""Pictures: functions that take matplotlib axes and return them. Data are in the unit of the thresholds; tick labels
have its prefix, or the power of ten that the axis names."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from origins.samples.from_samples import Sampled
from origins.thresholds.law import Thresholds
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
from toolkit.pictures.axes import INK, Lengths, heights, plain, spans_decades
from toolkit.pictures.coupled import plot_replicas, plot_slips
from toolkit.pictures.sweep import plot_sweep, sweep_panels
from toolkit.results.records import (
    OWN_UNIT,
    AgeingRecord,
    Result,
    SoftRecord,
    ThresholdCurve,
    sample_curve,
)
from toolkit.running.coupled import CoupledRecord, slips_beside
from toolkit.scene import laws

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_STEPS = 2000  # as many as a picture can show
_NO_DEFECT = 1e-3  # of a weight of 1: less is not drawn larger than that
_ALL = 1e-9  # of the contacts
_ELSEWHERE = (
    "from-topography",
    "from-samples",
    "domains",
    "mixture",
)  # files, or work, of their own
_LEGEND = 0.13  # of the height, room for each of its rows above the curve
_BARS = 61  # as many error bars as leave the line in sight


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

        _, axes = pyplot.subplots(
            1, 2, figsize=(10, 4), width_ratios=(2.2, 1), layout="constrained"
        )
    if curves(result):
        plot_force(axes[0], result)
    else:
        plot_sweep(axes[0], result)
    plot_density(axes[1], result.thresholds)
    if (final := _final(result)) is not None:
        _plot_final(axes[1], result.thresholds, final)
    if grows(result):
        axes[1].set_title(
            f"thresholds at $X$ = 0, age {result.asked.contacts.thresholds['age']:.3g}"
        )
    return axes


def plot_force(axes: "Axes", result: Result) -> "Axes":
    """F/(N_c<k>) against X, or t where the drive keeps time: the master equation as a line, the ensemble as error bars,
    one standard error, under it."""
    if result.master is not None:
        path, force = along(result, result.master), result.master.force
        label, dashes = "master equation", "-"
        if not result.master.success:
            label, dashes = (
                f"{label}, error {result.master.force_error:.1e} $\\langle x_s\\rangle$: not as asked",
                "--",
            )
        if isinstance(result.master, SoftRecord):
            path, force = with_slips(path, force, result.master)
        axes.plot(path, force, color=INK["master"], lw=1.4, ls=dashes, zorder=3, label=label)
        if isinstance(result.master, AgeingRecord) and result.master.outrun < path[-1]:
            axes.axvspan(
                result.master.outrun,
                path[-1],
                color="0.9",
                lw=0,
                label="contacts outrun $P_c$ (Q15)",
            )
    if isinstance(result.eq, CoupledRecord):
        plot_replicas(axes, result, result.eq)
    elif result.eq is not None:
        eq = result.eq
        shown = np.unique(np.linspace(0, eq.path.size - 1, _BARS).round().astype(int))
        axes.errorbar(
            along(result, eq)[shown],
            eq.force[shown],
            yerr=eq.force_standard_error[shown],
            fmt="o",
            ms=3,
            capsize=2,
            lw=1,
            color=INK["eq"],
            zorder=2,
            label="EQ ensemble, ±1 standard error",
        )
    highest = max((float(np.abs(curve.force).max()) for curve in curves(result)), default=0.0)
    write_along(axes, result)
    Lengths.of(highest, _in_metres(result.thresholds)).write(
        axes.yaxis, r"force $F/(N_c\langle k\rangle)$"
    )
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
    curve = curves(result)[0]
    soft = isinstance(curve, SoftRecord | CoupledRecord)
    axes.plot(along(result, curve), curve.path, color="0.4", lw=1.2, label="drive")
    if isinstance(curve, SoftRecord | CoupledRecord):
        axes.plot(along(result, curve), curve.position, color=INK["master"], lw=1.2, label="slider")
        axes.legend(fontsize="small")
    write_along(axes, result)
    name = "position" if soft else "slider\nposition $X$"
    Lengths.of(float(np.abs(curve.path).max()), _in_metres(result.thresholds)).write(
        axes.yaxis, name
    )
    return axes


def plot_holding(axes: "Axes", result: Result) -> "Axes":
    """The fraction of the contacts that hold; the others wait to form again."""
    if result.master is not None:
        axes.plot(
            along(result, result.master),
            result.master.holding,
            color=INK["master"],
            lw=1.2,
            label="ME",
        )
    if result.eq is not None:
        some = np.unique(np.linspace(0, result.eq.path.size - 1, _BARS).round().astype(int))
        axes.plot(
            along(result, result.eq)[some],
            result.eq.holding[some],
            ".",
            ms=4,
            color=INK["eq"],
            label="EQ",
        )
    if result.master is not None and result.eq is not None:
        axes.legend(fontsize="small", ncols=2, loc="lower right", borderpad=0.2)
    axes.set(ylabel="fraction\nthat holds", ylim=(0.0, 1.05))
    write_along(axes, result)
    return axes


def plot_deviation(axes: "Axes", result: Result) -> "Axes":
    """Ensemble less master equation in standard errors, where enough contacts have broken to tell."""
    off = deviation(result)[1]
    if (reason := why_not_compared(result)) is not None:
        axes.text(
            0.5, 0.5, f"not compared: {reason}", transform=axes.transAxes, ha="center", va="center"
        )
    axes.axhspan(-2.0, 2.0, color="0.92", zorder=0)
    if result.eq is not None:
        axes.plot(along(result, result.eq)[telling(result)], off, ".", ms=3.5, color=INK["eq"])
    reach = max(4.0, 1.1 * float(np.abs(off).max(initial=0.0)))
    axes.set(ylabel="EQ − ME\n(std. errors)", ylim=(-reach, reach))
    write_along(axes, result)
    return axes


def plot_defects(axes: "Axes", result: Result) -> "Axes":
    """What the paper's closure of ageing does not keep: mass of P_c less 1, and weight below 0."""
    if isinstance(result.master, AgeingRecord):
        path = along(result, result.master)
        axes.plot(
            path,
            result.master.mass_defect,
            color=INK["master"],
            lw=1.2,
            label="mass of $P_c$ less 1",
        )
        axes.plot(
            path,
            result.master.positivity_defect,
            color=INK["eq"],
            lw=1.2,
            ls="--",
            label="weight below 0",
        )
        largest = max(
            float(np.abs(result.master.mass_defect).max()),
            float(result.master.positivity_defect.max()),
        )
        axes.set(
            ylabel="defects\nof (Q15)",
            ylim=(-0.15 * max(largest, _NO_DEFECT), 1.3 * max(largest, _NO_DEFECT)),
        )
        axes.legend(fontsize="small")
        write_along(axes, result)
    return axes


def plot_density(axes: "Axes", curve: ThresholdCurve) -> "Axes":
    """P_c(x), with exact single values as lines as high as their weight."""
    finite = np.isfinite(curve.density)
    if curve.density[finite].any():
        _upright(axes, curve, curve.density)
        axes.fill_between(
            curve.x[finite], curve.density[finite], color=INK["thresholds"], alpha=0.25, lw=0
        )
        axes.plot(curve.x[finite], curve.density[finite], color=INK["thresholds"], lw=1.2)
    _label(axes, curve, "thresholds", "threshold $x$", "$P_c(x)$")
    if curve.atoms.size:
        # a weight is no density: beside one it has an axis of its own
        own = axes.twinx() if curve.density[finite].any() else axes
        own.vlines(curve.atoms, 0.0, curve.atom_weights, color=INK["thresholds"], lw=2)
        own.set_ylabel("weight at one value")
        own.set_ylim(0.0, 1.05 * float(curve.atom_weights.max()))
        own.yaxis.set_major_formatter("{x:g}")
    return axes


def _final(result: Result) -> ThresholdCurve | None:
    """The law of old contacts, where they age and the scene's text alone says what it is."""
    ageing = result.asked.contacts.ageing
    if ageing is None or ageing["final"].get("kind") in _ELSEWHERE or "file" in ageing["final"]:
        return None
    return sample_curve(
        laws.build(laws.THRESHOLDS, ageing["final"], "contacts.ageing.final", Path())
    )


def _plot_final(axes: "Axes", new: ThresholdCurve, final: ThresholdCurve) -> None:
    """What the thresholds of new contacts become, dashed beside them."""
    shown = np.isfinite(final.density)
    if (
        not final.density[shown].any()
        or not np.isfinite(new.density).all()
        or axes.get_yscale() == "log"
    ):
        return
    (line,) = axes.get_lines()
    line.set_label("new")
    axes.plot(
        final.x[shown],
        final.density[shown],
        color=INK["thresholds"],
        lw=1.2,
        ls="--",
        label="final",
    )
    first, last = (ends for ends in zip(_reach(new), _reach(final), strict=True))
    axes.set_xlim(min(first), max(last))
    bottom, top = axes.get_ylim()
    axes.set_ylim(bottom, max(top, heights(final, final.density).top))
    Lengths.of(max(last), _in_metres(new)).write(axes.xaxis, "threshold $x$")
    axes.legend(fontsize="small")


def plot_survival(axes: "Axes", curve: ThresholdCurve) -> "Axes":
    """S(x), the probability that a threshold exceeds x."""
    axes.plot(curve.x, curve.survival, color=INK["thresholds"], lw=1.2)
    axes.set(ylabel="$S(x)$", ylim=(0, 1.05))
    _label(axes, curve, "survival", "threshold $x$")
    return axes


def plot_samples(axes: "Axes", thresholds: Thresholds) -> "Axes":
    """Over S(x) the share of samples above x, as steps; nothing for a law that is not from samples."""
    if isinstance(thresholds, Sampled):
        x, above = thresholds.samples, 1.0 - np.cumsum(thresholds.shares)
        some = np.unique(np.linspace(0, x.size - 1, _STEPS).round().astype(int))
        axes.step(
            x[some],
            above[some],
            where="post",
            color="0.25",
            lw=0.6,
            label=f"{thresholds.n_samples} samples",
        )
        axes.legend()
    return axes


def plot_hazard(axes: "Axes", curve: ThresholdCurve) -> "Axes":
    """P_c(x)/S(x), the rate of breaking per length at stretch x, up to where one contact in a thousand holds."""
    shown = (curve.survival > 1e-3) & np.isfinite(curve.density)
    hazard = np.where(shown, curve.density / np.maximum(curve.survival, 1e-3), np.nan)
    if shown.any():
        _upright(axes, curve, hazard)
    axes.plot(curve.x[shown], hazard[shown], color=INK["thresholds"], lw=1.2)
    _label(axes, curve, "hazard", "stretch $x$", "$P_c(x)/S(x)$")
    return axes


def _upright(axes: "Axes", curve: ThresholdCurve, values: Any) -> None:
    """The limits of y."""
    found = heights(curve, values)
    axes.set(yscale="log" if found.logarithmic else "linear", ylim=(found.bottom, found.top))


def _label(
    axes: "Axes", curve: ThresholdCurve, title: str, name: str, inverse: str | None = None
) -> None:
    """Title, the axis of x and, where it is one of inverse lengths, that of y."""
    first, last = _reach(curve)
    axes.set_title(title)
    if spans_decades(curve):
        first = float(curve.x[curve.x > 0.0].min())
        axes.set_xscale("log")
    axes.set_xlim(first, last)
    if last - first < 1e-2 * last:
        axes.locator_params(axis="x", nbins=3)  # long numbers
    lengths = Lengths.of(last, _in_metres(curve))
    lengths.write(axes.xaxis, name)
    if inverse is not None:
        lengths.write_inverse(axes.yaxis, inverse)


def _waits(result: Result) -> bool:
    """Whether contacts wait before they form again."""
    return any(bool((curve.holding < 1.0 - _ALL).any()) for curve in curves(result))


def _in_metres(curve: ThresholdCurve) -> bool:
    return curve.unit != OWN_UNIT


def _reach(curve: ThresholdCurve) -> tuple[float, float]:
    """A little beyond all but a thousandth of the thresholds, from 0 unless they all lie far from it."""
    first = float(curve.x[curve.survival < 1.0 - 1e-3].min())
    last = float(curve.x[curve.survival > 1e-3].max(initial=first))
    # one exact value has no width of its own
    margin = 0.15 * (last - first) if last - first > 1e-9 * last else 0.5 * last
    return (first - margin if first > 0.5 * last else 0.0), last + margin


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
    names = [draw.__name__ for draw in (*below, *swept)]
    heights = [3, *(1 for _ in below), *(2 for _ in swept)]
    figure = Figure(figsize=(10, 1 + sum(heights)), layout="constrained")
    rows: list[Any] = [["F", "P"], *([name, "P"] for name in names)]
    places = figure.subplot_mosaic(rows, width_ratios=[2.2, 1], height_ratios=heights)
    plot(result, [places["F"], places["P"]])
    for number, draw in enumerate(swept):
        own = draw(places[draw.__name__], result)
        if number:
            own.sharex(places[swept[0].__name__])
    above = places["F"]
    for draw in below:
        own = draw(places[draw.__name__], result)
        own.sharex(places["F"])
        above.set_xlabel("")
        above = own
    figure.savefig(path, dpi=150, format="png")


def save_thresholds_picture(
    curve: ThresholdCurve, thresholds: Thresholds, title: str, path: Path
) -> None:
    """P_c, survival, that of the samples if there are any over it, and hazard side by side as a PNG."""
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    # room between the panels: the first has a second axis where there are exact values
    figure = Figure(figsize=(11.5, 3.6), layout=ConstrainedLayoutEngine(wspace=0.1))
    axes = figure.subplots(1, 3)
    plot_density(axes[0], curve)
    plot_samples(plot_survival(axes[1], curve), thresholds)
    plot_hazard(axes[2], curve)
    figure.suptitle(plain(title))
    figure.savefig(path, dpi=150, format="png")
