"""Pictures of an ensemble on a soft slider: replicas one by one, and how late their slips come."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from toolkit.pictures.abscissa import along, write_along
from toolkit.pictures.axes import INK
from toolkit.results.records import CoupledRecord, Result
from toolkit.running.coupled import slips_beside

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_REPLICAS = 5  # as many curves as can be told from one another


def plot_replicas(axes: Axes, result: Result, eq: CoupledRecord) -> None:
    """Some replicas, each by itself: their mean over a slip is the force of none of them."""
    each = f"{eq.contacts // len(eq.forces):,} contacts"
    label = f"EQ, {min(_REPLICAS, len(eq.forces))} of {len(eq.forces)} replicas of {each}"
    for force in eq.forces[:_REPLICAS]:
        axes.plot(
            along(result, eq), force, color=INK["eq"], lw=0.7, alpha=0.7, zorder=2, label=label
        )
        label = ""


def plot_slips(axes: Axes, result: Result) -> Axes:
    """How late the slips of the replicas come, mean and standard error; N contacts slip late by some N^(-2/3)."""
    eq, beside = result.eq, slips_beside(result)
    if isinstance(eq, CoupledRecord) and beside:
        unit, place = result.mean_threshold, along(result, eq)
        late = np.array([slip.mean_drive - slip.drive for slip in beside]) / unit
        error = np.array([slip.drive_error for slip in beside]) / unit
        at = np.interp([slip.drive for slip in beside], eq.path, place)
        axes.errorbar(at, late, yerr=error, fmt="o", ms=3, capsize=2, lw=1, color=INK["eq"])
        scale = (eq.contacts / len(eq.forces)) ** (-2.0 / 3.0)
        axes.axhspan(0.0, scale, color="0.92", zorder=0, label="$N^{-2/3}$")
        axes.legend(fontsize="small", loc="upper left", borderpad=0.2)
    axes.axhline(0.0, color="0.6", lw=0.8, zorder=1)
    axes.set_ylabel("slips late\nby $X_T/\\langle x_s\\rangle$")
    write_along(axes, result)
    return axes
