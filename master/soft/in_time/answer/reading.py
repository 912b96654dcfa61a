"""Reading: what a slider answers at any time, from the ends of its steps."""

from collections.abc import Sequence

import numpy as np
from scipy.interpolate import make_interp_spline
from scipy.optimize.elementwise import find_root

from master.soft.in_time.breaks import NEARBY
from origins.thresholds.law import Array

# Highest degree of the splines between the ends of steps; they are best at odd ones.
DEGREE = 5


def read(sections: Sequence[Sequence[tuple[float, ...]]], asked: Array, count: int = 2) -> Array:
    """The first `count` columns of nodes behind sizes and times, as force (lengths) and the fraction that holds, at
    times (n,), shape (count, n); at a slip, after it. By splines in the sizes of the section's steps so far, in which
    the time, too, is smooth. A step that is tiny beside one before, as the last of a section may be, stands for its end
    alone: a spline through both magnifies by what they are off."""
    ends = np.array([section[-1][1] for section in sections])
    which = np.minimum(np.searchsorted(ends, asked, side="right"), len(sections) - 1)
    out = np.empty((count, asked.size))
    for k in np.unique(which):
        at, nodes = asked[which == k], np.array(sections[k])
        nodes = nodes[np.unique(nodes[:, 0], return_index=True)[1]]
        gaps = np.diff(nodes[:, 0])
        tiny = np.flatnonzero(gaps < NEARBY * np.maximum.accumulate(gaps))
        nodes = np.delete(nodes, tiny, axis=0)  # the node at its begin
        size, time, values = nodes[:, 0], nodes[:, 1], nodes[:, 1 : 2 + count]
        if len(nodes) == 1:
            out[:, which == k] = values[:, 1:].T
            continue
        degree = min(DEGREE, 2 * ((len(nodes) - 2) // 2) + 1)
        spline = make_interp_spline(size, values, k=degree)
        cell = np.clip(np.searchsorted(time, at, side="left"), 1, len(nodes) - 1)
        found = find_root(
            lambda x, wanted, spline=spline: spline(x)[..., 0] - wanted,
            (size[cell - 1], size[cell]),
            args=(np.clip(at, time[cell - 1], time[cell]),),
        )
        # at the end of a cell rounding may take the root out of it
        place = np.where(found.success, found.x, np.interp(at, time, size))
        out[:, which == k] = spline(place)[:, 1:].T
    return out
