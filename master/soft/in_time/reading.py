"""Reading force and holding fraction between the steps of a slider."""

import numpy as np
from scipy.interpolate import make_interp_spline
from scipy.optimize.elementwise import find_root

from master.soft.in_time.slider import Node
from origins.thresholds.law import Array

# Highest degree of the splines; they are best at odd ones.
DEGREE = 5


def read(sections: list[list[Node]], asked: Array) -> Array:
    """Force (lengths) and the fraction that holds at times (n,), shape (2, n); at a slip, after it. By splines in the
    size of all steps, in which the time, too, is smooth."""
    ends = np.array([section[-1].time for section in sections])
    which = np.minimum(np.searchsorted(ends, asked, side="right"), len(sections) - 1)
    out = np.empty((2, asked.size))
    for k in np.unique(which):
        at, nodes = asked[which == k], np.array(sections[k])[:, :4]
        nodes = nodes[np.unique(nodes[:, 0], return_index=True)[1]]
        step, times = nodes[:, 0], nodes[:, 1]
        if step.size == 1:
            out[:, which == k] = nodes[0, 2:, None]
            continue
        degree = min(DEGREE, 2 * ((step.size - 2) // 2) + 1)
        values = make_interp_spline(step, nodes[:, 1:], k=degree)
        cell = np.clip(np.searchsorted(times, at, side="left"), 1, step.size - 1)
        found = find_root(
            lambda x, time, values=values: values(x)[..., 0] - time,
            (step[cell - 1], step[cell]),
            args=(np.clip(at, times[cell - 1], times[cell]),),
        )
        # at the end of a cell rounding may take the root out of it
        place = np.where(found.success, found.x, np.interp(at, times, step))
        out[:, which == k] = values(place)[:, 1:].T
    return out
