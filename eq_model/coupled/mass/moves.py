"""Moves of a slider with mass from one event to the next.

Short ones, as between two breaks of a slip, take the first terms of the way's power series, others the closed form.
The moves become a part of the loop over events: a call would copy every array of `pull`, which takes longer than they.
"""

import numpy as np

from eq_model.compiling import inlined, unsigned
from eq_model.coupled.mass.integrals import motion_integrals
from eq_model.coupled.mass.motion import make_motion, speed_at_break
from eq_model.coupled.mass.state import pass_time, speed_limit
from eq_model.coupled.mass.swings import see_turns

MOVED = 2  # what quick_move returns where no contact breaks
# exponent of the slow part below which it is 1e-13 of what it was, and its sum with 1 is rounding
LOST = -30.0


@inlined
def quick_move(s, pull, ahead, behind, most, net, stiffness):  # type: ignore[no-untyped-def]
    """Move to the next break, or for the time `most` if that ends before, by the power series of the way, if this is so
    soon that six terms are exact. Returns which break (1 ahead, -1 behind), MOVED if none, or 0 if nothing was done.

    net : force on the slider without damping. Nothing is done either where the slider becomes faster or slower than
    the drive, or its speed has an extreme.
    """
    v, side, level = s.speed, 1, ahead
    if v < 0.0:
        side, level = -1, -behind
    drive, per_mass, rate = pull.speeds[unsigned(s.leg)], pull.per_mass, pull.rate
    per_length = 1.0 / v if v != 0.0 else np.inf
    ends = level * per_length >= most
    t = most if ends else level * per_length
    square, a2 = stiffness * per_mass, net * per_mass - rate * v
    # the first term left out is below 1e-15 of |a2| t², and so below 1e-16 of the way
    soon = square * t * t < 2.5e-5 and rate * t < 5e-3
    if not (soon and abs(a2) * t < 0.05 * abs(v)):
        return 0
    # derivatives of the way, each from the two before
    a3 = pull.spring * per_mass * drive - square * v - rate * a2
    a4 = -square * a2 - rate * a3
    a5 = -square * a3 - rate * a4
    b2, b3, b4, b5 = 0.5 * a2, a3 * (1.0 / 6.0), a4 * (1.0 / 24.0), a5 * (1.0 / 120.0)
    b6 = (-square * a4 - rate * a5) * (1.0 / 720.0)
    t -= 0.0 if ends else b2 * t * t * per_length
    step = 0.0
    for _ in range(8):
        travel = t * (v + t * (b2 + t * (b3 + t * (b4 + t * (b5 + t * b6)))))
        speed = v + t * (a2 + t * (3.0 * b3 + t * (4.0 * b4 + t * (5.0 * b5 + t * 6.0 * b6))))
        if ends:
            break
        step = (travel - level) / speed
        t -= step
        if abs(step) <= 1e-9 * t:  # the next one would be below rounding
            break
    h = 0.5 * t
    speed -= step * a2
    middle = v + h * (a2 + h * (3.0 * b3 + h * (4.0 * b4 + h * 5.0 * b5)))
    limit, later = speed_limit(drive), a2 + t * (a3 + t * 0.5 * a4)
    misses = side * travel >= side * level if ends else t >= most
    if misses or (v > limit) != s.falling or (speed > limit) != s.falling or a2 * later < 0.0:
        return 0
    squares = t * (1.0 / 6.0) * (v * v + 4.0 * middle * middle + speed * speed)  # Simpson's rule
    travel_integral = t * t * (0.5 * v + t * (b2 * (1.0 / 3.0) + t * (b3 * 0.25 + t * b4 * 0.2)))
    pass_time(s, pull, t, travel if ends else level, speed, travel_integral, squares)
    if s.falling:
        s.top = max(s.top, speed)
    return MOVED if ends else side


@inlined
def _slow_parts(z):  # type: ignore[no-untyped-def]
    """Integrals of e^(z s) over s from 0 to 1, z <= 0: once, (e^z - 1)/z, and twice."""
    if z < -0.1:
        once = np.expm1(z) / z
        return once, (once - 1.0) / z
    tail = 1.0 + z / 7.0 * (1.0 + z / 8.0 * (1.0 + z / 9.0))
    twice = 1.0 + z / 3.0 * (1.0 + z / 4.0 * (1.0 + z / 5.0 * (1.0 + z / 6.0 * tail)))
    return 1.0 + 0.5 * z * twice, 0.5 * twice


@inlined
def damped_move(s, pull, ahead, most, net, stiffness):  # type: ignore[no-untyped-def]
    """As quick_move, but only forward and far beyond critical damping, where the speed is w + p e^(slow t) +
    q e^(fast t). While the slow exponential hardly changes, each step takes one value of the fast one."""
    v, rate, square = s.speed, pull.rate, stiffness * pull.per_mass
    drive = pull.speeds[unsigned(s.leg)]
    limit = speed_limit(drive)
    if not (v > 0.0 and rate * rate > 8.0 * square and (v > limit) == s.falling):
        return 0
    beat = np.sqrt(0.25 * rate * rate - square)
    fast = -(0.5 * rate + beat)
    slow, drift = square / fast, pull.spring * drive / stiffness
    a = net * pull.per_mass - rate * v
    q = (a - slow * (v - drift)) / (fast - slow)
    p = (v - drift) - q
    even = drift + p  # the speed once the fast part is over
    if not even > 0.0:
        return 0
    # with a constant slow part both bound the time on one side, from which Newton's method approaches it
    over, straight = (ahead + q / fast) / even, ahead / v
    t = max(over, straight) if q > 0.0 else min(over, straight)
    ends = not t < most
    t = min(t, most)
    step, fading, z, once, twice, travel, speed = np.inf, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for _ in range(12):
        fading, z = np.expm1(fast * t), slow * t
        once, twice = _slow_parts(z)
        travel = (drift + p * once) * t + q * (fading / fast)
        speed = even + p * (z * once) + q * (1.0 + fading)
        if ends:
            step = 0.0
            break
        step = (travel - ahead) / speed
        if not abs(step) > 1e-9 * t:  # the next one would be below rounding
            break
        t -= step
        ends = not t < most
        t = min(t, most)
    # integrals of shorter times would cancel
    if not (abs(step) <= 1e-9 * t and -fast * t > 1e-3) or (ends and travel >= ahead):
        return 0
    later = p * slow * (1.0 + z * once) + q * fast * (1.0 + fading)
    t -= step
    speed -= step * later
    fading -= step * fast * (1.0 + fading)
    top = max(v, speed)
    if z < LOST:
        later = p * slow  # whose sign the slow part has, too, where rounding has lost it
    if a < 0.0 < later or (speed > limit) != s.falling or not speed > 0.0:
        return 0
    if later < 0.0 < a and even > (s.top if s.falling else limit):
        at = np.log(-p * slow / (q * fast)) / (fast - slow)
        top = drift + p * np.exp(slow * at) + q * np.exp(fast * at)
        if not s.falling and top > limit:
            return 0
    gone, z = fading / fast, slow * t
    once, twice = _slow_parts(z)
    growth = z * once
    both = fading + growth * (1.0 + fading)  # e^((slow + fast) t) - 1
    squares = even * even + 2.0 * even * p * z * twice
    squares += p * p * (_slow_parts(2.0 * z)[0] - 1.0 - 2.0 * (once - 1.0))
    squares *= t
    squares += 2.0 * q * (drift * gone + p * both / (slow + fast))
    squares += q * q * 0.5 * gone * (2.0 + fading)
    travel_integral = t * t * (0.5 * drift + p * twice) + q * (gone - t) / fast
    pass_time(s, pull, t, travel if ends else ahead, speed, travel_integral, squares)
    if s.falling:
        s.top = max(s.top, top)
    return MOVED if ends else 1


@inlined
def motion_of(s, pull, net, stiffness):  # type: ignore[no-untyped-def]
    """The closed motion from here on."""
    drift = pull.spring * pull.speeds[unsigned(s.leg)] / stiffness
    u = (pull.damping * drift - net) / stiffness
    own = np.sqrt(stiffness * pull.per_mass)
    return make_motion(drift, u, s.speed, 0.5 * pull.damping * pull.per_mass, own)


@inlined
def closed_move(s, pull, motion, passage, travel):  # type: ignore[no-untyped-def]
    """Move in closed form up to a passage, a break of which is at `travel`. Returns whether a slip has ended."""
    t, there = passage.time, passage.there
    speed = there.speed
    if passage.side == 0:
        travel = there.travel
    else:
        speed = speed_at_break(motion, there, travel - there.travel)
    integral, squares = motion_integrals(motion, t, there)
    pass_time(s, pull, t, travel, speed, integral, squares)
    return see_turns(s, pull, motion, t, travel)
