"""The picture of precision: true error against run time, one marker per method, what it claims as a hollow one."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from toolkit.judge.precision import TELLING, Precision
from toolkit.pictures.axes import plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_STYLES = {
    "master": ("o", "#1f4e79", "master equation", "its bound"),
    "explicit": ("s", "#5dade2", "the paper's explicit scheme", ""),
    "ensemble": ("^", "#c0392b", "EQ ensemble, one seed", "its standard error"),
    "closest": ("v", "#e59866", "the paper's closest contact, one seed", ""),
}
_LEAST = 1e-17  # an error of 0 has no place on a logarithmic axis


def save_precision(measured: Precision, path: Path) -> None:
    """The picture as a PNG, on a figure of its own: the session's backend is not touched."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 6), layout="constrained")
    plot_precision(figure.subplots(), measured)
    figure.savefig(path, dpi=130, format="png")


def plot_precision(axes: "Axes", measured: Precision) -> "Axes":
    """True error in units of <x_s> against run time in s, both as logarithms; grey is where the reference errs too.

    Points in the grey are drawn faint, and no lower than the reference's own error.
    """
    own = max(measured.reference.error, _LEAST)
    for method, (marker, ink, label, claim) in _STYLES.items():
        points = [point for point in measured.points if point.method == method]
        if not points:
            continue
        run_time = np.array([point.run_time for point in points])
        error = np.maximum([point.error for point in points], own)
        faint = np.array([point.at_reference for point in points])
        axes.plot(run_time[~faint], error[~faint], marker + "-", color=ink, lw=1, ms=6, label=label)
        axes.plot(run_time[faint], error[faint], marker, color=ink, ms=6, alpha=0.3)
        claimed = np.array([point.claimed_error or np.nan for point in points])
        if claim and (claimed > 0.0).any():
            claimed[claimed < own] = np.nan
            hollow: dict[str, Any] = {"mfc": "none", "mec": ink, "ms": 6, "mew": 0.9}
            hollow["label"] = f"{label}: {claim}"
            axes.plot(run_time, claimed, marker, **hollow)
    axes.set(xscale="log", yscale="log", xlabel="run time (s)")
    axes.set_ylabel(r"largest error of $F$ over the path, in $\langle x_s\rangle$")
    bottom = own / 3.0
    axes.axhspan(bottom, TELLING * own, color="0.93", zorder=0, label="the reference errs too")
    axes.set_ylim(bottom=bottom)
    axes.grid(alpha=0.3)
    against = f"against {measured.reference.source}, good to {own:.0e}"
    axes.set_title(f"{plain(measured.title)}\n{against}", fontsize="medium")
    axes.legend(fontsize="small")
    return axes
