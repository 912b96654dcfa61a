"""Axes that can be read: what curves are drawn against, lengths in metres with a prefix, densities that peak."""

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from toolkit.results.records import Curve, Result, ThresholdCurve

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis

Array = npt.NDArray[np.float64]

INK = {"master": "#1f4e79", "eq": "#c0392b", "thresholds": "#2e7d32"}
_SPIKE = 10.0  # times what 95 % of the contacts see: a higher end of a density is cut off


def plain(text: str) -> str:
    """`text` as matplotlib shows it: what is no formula, though it has dollars, letter by letter."""
    from matplotlib.mathtext import MathTextParser

    try:
        MathTextParser("agg").parse(text)
    except ValueError:
        return text.replace("\\$", "$").replace("$", r"\$")
    return text


def name_lengths(axis: "Axis", name: str, metres: bool) -> None:
    """Label an axis of lengths; ticks in metres have a prefix, such as 25 nm."""
    from matplotlib.ticker import EngFormatter

    axis.set_label_text(name)
    if metres:
        axis.set_major_formatter(EngFormatter(unit="m"))


def highest(curve: ThresholdCurve, values: Array) -> float:
    """Where an axis ends that shows `values` over curve.x, however narrow their peaks; but a spike at an end of the law,
    where a density diverges, is cut off at what 5 % of the contacts or more see of it."""
    shown = np.isfinite(values) & (values > 0.0)
    weight, seen = -np.diff(curve.survival, append=0.0)[shown], values[shown]
    if not weight.sum() > 0.0:
        return float(seen.max(initial=1.0))
    order, top = np.argsort(seen), float(seen.max())
    high = seen[order][np.searchsorted(weight[order].cumsum(), 0.95 * weight.sum())]
    at_end = int(np.argmax(seen)) in (0, seen.size - 1)
    return float(1.5 * high) if top > _SPIKE * high and at_end else 1.05 * top


def some_of(size: int, most: int) -> npt.NDArray[np.intp]:
    """Indices of at most so many of `size` points, evenly."""
    return np.unique(np.linspace(0, size - 1, most).round().astype(np.intp))


def curves(result: Result) -> list[Curve]:
    """What the solvers found, the master equation's first."""
    return [curve for curve in (result.master, result.eq) if curve is not None]


def along(result: Result, curve: Curve) -> Array:
    """What a curve is drawn against: times where the scene gives them, else its path."""
    return result.time[: curve.path.size] if result.timed else curve.path


def write_along(axes: "Axes", result: Result) -> None:
    """The axis of that. Where holds have a scale, points are even on it, so that each decade of a hold can be told."""
    drive = result.asked.drive
    if drive is None or drive.times is None:
        pulled = drive is not None and drive.spring is not None
        place = "drive position $X_T$" if pulled else "slider position $X$"
        name_lengths(axes.xaxis, place, result.in_metres)
        return
    axes.set_xlabel(f"time $t${' (s)' if result.in_metres else ''}")
    if drive.hold_scale is not None:
        times, number = result.time, np.arange(result.time.size, dtype=float)
        both = (lambda t: np.interp(t, times, number), lambda n: np.interp(n, number, times))
        axes.set_xscale("function", functions=both)
        turns = np.unique([times[0], *drive.times])
        axes.set(xlim=(times[0], times[-1]), xticks=turns[some_of(turns.size, 8)])
        how = f"logarithmic in holds, even in ln(1 + t/{drive.hold_scale:.3g}) since each began"
        axes.set_xlabel(f"{axes.get_xlabel()}, {how}")
