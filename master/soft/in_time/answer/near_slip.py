"""Whether a drive stops or turns so near a slip to come that the steps do not tell if the slip comes before."""

import numpy as np

from master.soft.in_time.slider import Slider

# A slip is undecided where it is foreseen within this many times the change of X from the last halving. Let the drive
# end at a distance y before the slip, where the load K X_T, which the contacts balance, has the slope m over X. Up to
# the slip it is a parabola of X with its top there, whose slope falls from m to 0: it rises by m y/2 yet. If X is off
# by d, the load at a given X is off by m d; that is more than the rise that is left, so that the slip may have come,
# where y < 2 d.
NEAR = 2.0
# Factor above that slope of X_T(X) at which all contacts stick from which on breaks hold the slider back: above the
# rounding of short steps.
SLOWED = 1.01
# Part of its speed that a drive keeps at least where it goes on: a slip then comes after the bend as it would have
# before, and how far its begin is off is seen in the slip. Slower drives count as ends, like those that hold or turn.
GOES_ON = 0.5
# Rounding of a delay, as a part of it.
AT_ONCE = 1e-9


def undecided_end(sliders: list[Slider]) -> float | None:
    """The first end or turn of the drive (a time), or bend to a much lower speed, at which the error of X leads to the
    begin of a slip, or beyond; None where there is none.

    On a soft spring F hardly depends on X, so that errors of X do not show in F. Only the way since the last slip
    counts: that where the slider stood then does not matter.
    """
    motion = sliders[-1].motion
    if motion is None:
        return None
    onward = np.append(motion.speeds[1:], 0.0) * np.sign(motion.speeds)
    ends = onward < GOES_ON * np.abs(motion.speeds)
    for end in motion.times[1:][ends].tolist():
        before, now = (_distance_since_slip(one, end) for one in sliders[-2:])
        if _to_slip(sliders[-1], end) < NEAR * abs(now - before):
            return end
    return None


def _distance_since_slip(slider: Slider, end: float) -> float:
    """X at a time, relative to where the last slip before it ended, or where what broke in it formed again (a length):
    few contacts hold in between, and where the slider stood then does not matter."""
    until = [section for section in slider.sections if section[0].time < end]
    slipped = [slip.time for slip in slider.slips if slip.time <= until[-1][0].time]
    if not slipped:
        return until[-1][-1].position
    after = [section for section in until if section[0].time >= slipped[-1]]
    delay = slider.contacts.delay * (1.0 - AT_ONCE)
    reformed = [section for section in after if section[0].time >= slipped[-1] + delay]
    return until[-1][-1].position - (reformed or after)[0][0].position


def _to_slip(slider: Slider, end: float) -> float:
    """How far the slider is from the begin of a slip as the drive ends or turns (a length), inf for far.

    X_T, as a function of X, is largest there; the parabola through the last three steps tells where. On the way to a
    slip breaks help the slider on: dX_T/dX is at most 1 + k/K, that of contacts that all stick. It is larger where they
    hold it back, as when it turns round under a slow drive; it falls from there to 1, far from a slip, and a parabola
    through steps on that way tells nothing.
    """
    assert slider.motion is not None
    slipped = any(slip.time == end for slip in slider.slips)
    nodes = next((nodes[-3:] for nodes in slider.sections if nodes[-1].time == end), [])
    if slipped or len(nodes) < 3:
        return np.inf
    drive = slider.motion.at(np.array([node.time for node in nodes]))
    travels, steps = np.diff([node.position for node in nodes]), np.diff(drive)
    if not (travels * steps > 0.0).all():
        return np.inf  # it creeps back, or the drive holds
    slopes = steps / travels
    stuck = 1.0 + slider.contacts.largest_stiffness / slider.spring
    if slopes.max() > SLOWED * stuck:
        return np.inf
    bend = 2.0 * (slopes[1] - slopes[0]) / travels.sum()
    slope = slopes[1] + 0.5 * bend * travels[1]
    return max(float(-slope / bend * np.sign(steps[0])), 0.0) if bend * steps[0] < 0.0 else np.inf
