"""Curves of a soft slider with the ends of its slips, which are shorter than the steps between points of the path."""

from typing import Any

import numpy as np

from origins.thresholds.law import Array
from toolkit.pictures.thresholds import INK, along
from toolkit.results.records import Result

SHOWN = 5  # replicas, as can be distinguished
_RESOLVED = 8  # points of the path within a slip that show it as well as can be seen


def plot_replicas(axes: Any, result: Result, name: str, *of_slips: str) -> Any:
    """Some replicas of the ensemble's `name`, an array of shape (replicas, n), with `of_slips` as `with_slips` has it.
    Returns the first line."""
    eq, style = result.eq, {"color": INK["eq"], "lw": 0.7, "alpha": 0.7, "zorder": 2}
    lines = []
    for replica, values in enumerate(getattr(eq, name)[:SHOWN]):
        own = eq.slips.replica == replica
        place, values = with_slips(result, eq, values, own, *of_slips)
        lines += axes.plot(place, values, **style)
    return lines[0]


def with_slips(
    result: Result, curve: Any, values: Array, own: Any, *of_slips: str
) -> tuple[Array, Array]:
    """Places along the abscissa and `values` (n,) of a curve with the slips `own`, a mask or a slice, put in between.

    `of_slips` names two fields of slips, what the curve is as a slip begins and as it ends, or one, what it is in the
    middle. Slips that begin while the drive holds are left out, as X_T does not tell when; so are those
    that the curve's own points show.
    """
    slips, place = curve.slips, along(result, curve)
    path, times = curve.path, result.time[: curve.path.size]
    drive = slips.drive[own]
    holds = path[:-1][np.diff(path) == 0.0]
    known = ~np.isclose(drive[:, None], holds, rtol=1e-9, atol=0.0).any(axis=1)
    duration = getattr(curve, "slip_duration", getattr(slips, "duration", None))
    lasts = np.zeros(drive.size) if duration is None else duration[own]
    begins = np.interp(drive, path, times)
    within = np.searchsorted(times, begins + lasts) - np.searchsorted(times, begins)
    known &= within < _RESOLVED
    shares = (0.0, 1.0) if len(of_slips) == 2 else (0.5,)
    places, all_values = [place], [values]
    for share, name in zip(shares, of_slips, strict=True):
        then = begins + share * lasts
        places.append(np.interp(then, times, place)[known])
        all_values.append(getattr(slips, name)[own][known])
    where = np.concatenate(places)
    order = np.argsort(where, kind="stable")
    return where[order], np.concatenate(all_values)[order]
