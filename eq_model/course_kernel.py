"""The drive's clock for compiled kernels: where the slider is, when a time has passed, and contacts counted at moments.

Positions and moments are whole numbers (see course.py).
"""

import numpy as np

from eq_model.compiling import compiled


@compiled
def later(clock, leg, time, course):  # type: ignore[no-untyped-def]
    """The clock when `time` has passed, and the leg; beyond the drive's end where it is over by then."""
    begins, _, directions, paces = course
    legs = directions.size
    while leg < legs:
        left = (begins[leg + 1] - clock) * paces[leg]
        if time <= left:
            ticks = np.int64(np.floor(time / paces[leg] + 0.5)) if paces[leg] > 0.0 else 0
            return min(clock + ticks, begins[leg + 1]), leg
        time -= left
        leg += 1
        if leg < legs:
            clock = begins[leg]
    return begins[legs] + 1, leg


@compiled
def place_of(clock, leg, course):  # type: ignore[no-untyped-def]
    """The slider's position (whole)."""
    return course[1][leg] + course[2][leg] * (clock - course[0][leg])


@compiled
def look(at, birth, threshold, watch, counts):  # type: ignore[no-untyped-def]
    """Count a contact that holds at one of the watched moments: its stretch (whole) and its threshold."""
    _, places, (per_stretch, per_threshold), _ = watch
    bins = counts.shape[2]
    x = np.int64(np.floor(np.float64(places[at] - birth) * (0.5 * per_stretch) + 0.5 * bins))
    counts[at, 0, min(max(x, 0), bins - 1)] += 1
    counts[at, 1, min(max(np.int64(threshold * per_threshold), 0), bins - 1)] += 1
