"""Compiled: in which bin a moment of the clock lies, where the slider is then, and when a time has passed."""

import numpy as np

from eq_model.compiling import bare, inlined


@inlined
def bin_of(clock, bins):  # type: ignore[no-untyped-def]
    """The first point at or after a moment of the clock, which is not after the end."""
    if bins.even:
        return max((clock + bins.offset) >> bins.shift, np.int64(0))
    j = np.int64(bins.first[clock >> bins.shift])
    while bins.points[j] < clock:
        j += 1
    return j


@inlined
def place_of(clock, leg, course):  # type: ignore[no-untyped-def]
    """The slider's position (whole)."""
    k = np.uint64(leg)
    return course.positions[k] + course.directions[k] * (clock - course.begins[k])


@bare
def later(clock, leg, time, course):  # type: ignore[no-untyped-def]
    """The clock when `time` has passed, and the leg; beyond the drive's end where it is over by then."""
    legs = course.directions.size
    while leg < legs:
        pace = course.paces[leg]
        left = (course.begins[leg + 1] - clock) * pace
        if time <= left:
            ticks = np.int64(np.floor(time / pace + 0.5)) if pace > 0.0 else np.int64(0)
            return min(clock + ticks, course.begins[leg + 1]), leg
        time -= left
        leg += 1
        if leg < legs:
            clock = course.begins[leg]
    return course.begins[legs] + 1, leg
