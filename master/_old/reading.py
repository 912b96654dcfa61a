"""What is read from a course in time: polynomials on panels, and the one side or the other of what goes on at once."""

import numpy as np
import numpy.typing as npt

from master._old.collocation import Course
from master._old.jumps import Jump
from master._old.panels import SLOW, Panel, radau

Array = npt.NDArray[np.float64]


def read(course: Course, time: Array, place: Array, rows: list[Array]) -> Array:
    """Rows of a course at times, when the slider is at X = place: a contact whose stretch has reached its threshold is
    broken."""
    out = np.empty(time.size)
    which = _panel(course, time)
    for k in np.unique(which).tolist():
        mine, panel = np.flatnonzero(which == k), course.panels[k]
        if panel.count > 1:
            out[mine] = _polynomial(panel, rows[k], time[mine], place[mine])
            continue
        over = np.nan_to_num(_over(panel, time[mine], place[mine]), nan=1.0)
        first, last = _sliver(course, k)
        for side, beside, known in ((1.0, last + 1, rows[last][-1]), (0.0, first - 1, rows[first][0])):
            some = mine[over == side]
            out[some] = known
            # within the sliver the force goes on as beside it
            if 0 <= beside < len(course.panels) and course.panels[beside].count > 1:
                out[some] = _polynomial(course.panels[beside], rows[beside], time[some], place[some])
    return out


def unread(course: Course, time: Array, unit: float) -> float:
    """What the force lacks between nodes, where it is read at times, in units of a length."""
    out = 0.0
    for panel, force in zip(course.panels, course.force, strict=True):
        inner = (time > panel.begin) & (time < panel.end)
        if panel.count > 1 and inner.any():
            out = max(out, radau(panel.count).tail(force))
    return SLOW * out / unit


def unsure(course: Course, time: Array, place: Array, torn: Jump | None) -> float:
    """How much of the force (a length) breaks at once where it is not known on which side of that a point is read, or
    whether the path turns before."""
    out = 0.0
    which = _panel(course, time)
    for k, (panel, force) in enumerate(zip(course.panels, course.force, strict=True)):
        if panel.jump is None:
            continue
        mine = which == k
        if panel.jump is torn or np.isnan(_over(panel, time[mine], place[mine])).any():
            out = max(out, abs(float(force[-1] - force[0])))
    return out


def _panel(course: Course, time: Array) -> npt.NDArray[np.intp]:
    ends = np.array([panel.end for panel in course.panels])
    return np.minimum(np.searchsorted(ends, time, side="left"), ends.size - 1)


def _over(panel: Panel, time: Array, place: Array) -> Array:
    """Whether all that goes on at once on a panel is over, 1 or 0, or NaN where some of it is."""
    out = np.ones(time.size)
    if panel.jump is not None:
        for i, (now, at) in enumerate(zip(time.tolist(), place.tolist(), strict=True)):
            over = panel.jump.over(now, at, float(np.sign(panel.travel)), panel.begin)
            out[i] = np.nan if over is None else over
    return out


def _sliver(course: Course, k: int) -> tuple[int, int]:
    """The first and the last panel of what goes on at once on the k-th."""
    jump, first, last = course.panels[k].jump, k, k
    if jump is not None:
        while first > 0 and course.panels[first - 1].jump is jump:
            first -= 1
        while last < len(course.panels) - 1 and course.panels[last + 1].jump is jump:
            last += 1
    return first, last


def _polynomial(panel: Panel, values: Array, time: Array, place: Array) -> Array:
    """Where the slider moves the place tells more than the time where times are long."""
    if panel.travel == 0.0:
        share = (time - panel.begin) / panel.duration
    else:
        share = (place - panel.before) / panel.travel
    return np.asarray(radau(panel.count).values(share) @ values)
