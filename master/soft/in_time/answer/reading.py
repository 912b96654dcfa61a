"""Reading: what a slider answers at any time, from the ends of its steps."""

from collections.abc import Sequence

import numpy as np
from scipy.interpolate import make_interp_spline
from scipy.optimize.elementwise import find_root

from master.soft.in_time.breaks import NEARBY
from master.soft.in_time.steps import Node
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


def read_holding(sections: Sequence[Sequence[Node]], asked: Array, delay: float) -> Array:
    """The share that holds at times (n,), 1 - B(t) + B(t - delay), by the breaks on both sides of t - delay.

    A step knows those before it alone, and where it is longer than the delay no rate but its mean: near a slip, where
    breaks come ever faster, the share that it tells is off in proportion to its size. What a slip left before it
    replaced all contacts does not come back.
    """
    breaks = read(sections, asked, 4)[3]
    first = np.array([section[0].breaks for section in sections])
    last = np.array([section[-1].breaks for section in sections])
    anew = np.flatnonzero(first[1:] < last[:-1]) + 1
    begins = np.append(0, anew)
    ends = np.append(anew, len(sections))
    counted_from = np.array([sections[k][0].time for k in anew.tolist()])
    which = np.searchsorted(counted_from, asked, side="right")
    births = np.zeros(asked.size)
    for k in np.unique(which):
        counted = sections[begins[k] : ends[k]]
        mine = np.flatnonzero((which == k) & (asked - delay > counted[0][0].time))
        if mine.size:
            births[mine] = read(counted, asked[mine] - delay, 4)[3]
    return np.asarray(1.0 - breaks + births)
