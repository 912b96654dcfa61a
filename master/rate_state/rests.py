"""Solved answers of a rigid slider to rests, and the healing rate."""

from collections.abc import Sequence

import numpy as np

from master.rate_state.result import CONSTANT, Parameter
from master.rate_state.traces import LIVES, Rest, followed
from master.steady.kinetic import kinetic_curve
from origins import Contacts

# of the force: what may be left of the start before a rest; mean thresholds of the way on from it, and points there
SETTLED, ONWARD, POINTS = 1e-4, 3.0, 301


def rest_of(contacts: Contacts, velocity: float, rest: float, tolerance: float) -> Rest:
    """A rest of this time, and the way on; arguments as of `steps_about`."""
    mean = contacts.mean_threshold
    curve = kinetic_curve(contacts, velocity)
    steady = float(curve.force)
    for lives in LIVES:
        slip = mean * np.r_[0.0, np.linspace(0.0, ONWARD, POINTS)[1:]]
        begin = lives * mean
        path = np.r_[0.0, begin, begin + slip]
        arrival = np.r_[0.0, begin / velocity, begin / velocity + rest + slip / velocity]
        solved = followed(contacts, path, arrival, tolerance)
        before, relaxed, onward = solved.force[1], solved.force[2], solved.force[2:]
        left = abs(float(before) - steady)
        settled = left <= max(SETTLED * steady, float(solved.force_error) * mean)
        if settled:
            break
    top = int(np.argmax(onward))
    return Rest(
        time=rest,
        relaxed=float(relaxed),
        peak=float(onward[top]),
        peak_slip=float(slip[top]),
        error=solved.force_error * mean + left,
        success=bool(solved.success and settled),
    )


def healing_of(rests: Sequence[Rest]) -> Parameter | None:
    """How much the peak rises for each decade of the time at rest: the mean over the neighbouring rests between which
    it rises most, and those beside them where it rises as fast to CONSTANT. `definition`: how far the rise between the
    rests next to these is from it, or that of the steepest pair. None for fewer than three rests."""
    if len(rests) < 3:
        return None
    at = np.log10([one.time for one in rests])
    peaks, errors = np.array([one.peak for one in rests]), np.array([one.error for one in rests])
    slopes = np.diff(peaks) / np.diff(at)
    low = high = steepest = int(np.argmax(slopes))
    room = CONSTANT * abs(slopes[steepest])
    while low > 0 and abs(slopes[low - 1] - slopes[steepest]) <= room:
        low -= 1
    while high < slopes.size - 1 and abs(slopes[high + 1] - slopes[steepest]) <= room:
        high += 1
    last = high + 1
    value = float((peaks[last] - peaks[low]) / (at[last] - at[low]))
    error = float((errors[last] + errors[low]) / (at[last] - at[low]))
    apart = float(np.abs(slopes[max(low - 1, 0) : last + 1] - value).max())
    return Parameter(value, error, apart, rests[low].time, rests[last].time)
