"""Solved answers of a rigid slider to rests, and the healing rate."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from master.rate_state.reading import vertex
from master.rate_state.result import CONSTANT, Parameter
from master.rate_state.traces import FINE, Rest, approach_of, is_slow
from master.solve import solve
from master.steady.kinetic import kinetic_curve
from origins import Contacts

# of the force: what may be left of the start before a rest
SETTLED = 1e-4
# lives of the way on from a rest, and of its beginning, where the peak after a short rest is; points on both
ONWARD, NEAR, POINTS = 3.0, 0.3, 251
# K/(N_c <k>) of a spring in place of a rigid slider, on which heat at rest is followed over decades of time where
# thresholds grow; on a rigid one such breaks are not resolved beyond a hundred lives
STIFF = 300.0


def rest_of(contacts: Contacts, velocity: float, rest: float, tolerance: float) -> Rest:
    """A rest of this time, and the way on; arguments as of `steps_about`."""
    mean = contacts.mean_threshold
    steady = float(kinetic_curve(contacts, velocity).force)
    begin, life = approach_of(contacts, velocity, steady, 0.5 * SETTLED * steady)
    near, far = np.linspace(0.0, NEAR, POINTS), np.linspace(NEAR, ONWARD, POINTS)
    slip = life * np.r_[0.0, near, far[1:]]
    before = begin + life * np.arange(-1.0, 0.0, FINE)
    path = np.r_[0.0, before, begin + slip]
    arrival = np.r_[before, begin, begin + rest * velocity + slip[1:]] / velocity
    spring: dict[str, Any] = {"spring": STIFF, "slip": "instant"} if is_slow(contacts) else {}
    solved = solve(contacts, path, tolerance, time=np.r_[0.0, arrival], **spring)
    start, onward = solved.force[1 : before.size + 2], solved.force[before.size + 2 :]
    remaining = float(np.abs(start - steady).max())
    settled = remaining <= max(SETTLED * steady, float(solved.force_error) * mean)
    # by so much the spring lets the slider, and so all stretches, go on at rest
    lag = abs(steady - float(onward[0])) / STIFF if spring else 0.0
    peak = vertex(slip[1:], onward, int(np.argmax(onward)))
    return Rest(
        time=rest,
        relaxed=float(onward[0]),
        peak=peak.height,
        peak_slip=peak.slip,
        error=float(solved.force_error) * mean + remaining + lag + peak.sampling,
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
