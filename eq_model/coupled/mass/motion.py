"""The closed motion of a slider with mass from one event to the next, and when it first passes a position.

While no contact breaks or forms, the slider is a damped oscillator of stiffness S = K + (that of the contacts
that hold), pulled by a drive of constant speed v. Its way since the last event is

    w t + u(t) - u(0),    M u'' + γ u' + S u = 0,    w = K v/S,

u being its distance from where a slider without inertia would be. With s² = S/M, b = γ/2M and s² - b² = ω²
(or b² - s² = σ², where it does not ring)

    u(t) = u(0) C(t) + u'(0) D(t),    D = e^(-bt) sin(ωt)/ω,    C = D' + 2 b D,    C' = -s² D.

This holds for any time, however many oscillations that is: all times count from the last event.
"""

from typing import NamedTuple

import numpy as np

from eq_model.compiling import bare, inlined

# where an extreme of the speed is nearer than this (radians of the oscillation, and radians for each radian since the
# last event), the next one is taken: the first one is that at which the search stands, found anew with another rounding
NEAR, NEAR_FRACTION = 1e-7, 1e-15
# radians of the oscillation, and of its decay, on which terms of the fourth order are below rounding
CLOSE = 1e-4


class OscillatorMotion(NamedTuple):
    """An oscillator that starts at t = 0; lengths in whole units, times in the user's unit."""

    drift: float  # w
    u: float  # u(0)
    speed: float  # u'(0)
    decay: float  # b
    own: float  # s
    beat: float  # ω, or σ if it does not ring
    rings: bool  # b < s


class Moment(NamedTuple):
    """Where the slider is at some time: its way since the last event, u - u(0), u, u' and its speed."""

    travel: float
    gone: float  # of a motion that is short beside u it has more digits than the difference
    u: float
    change: float
    speed: float


class Passage(NamedTuple):
    """When the slider breaks a contact ahead (side 1) or behind (-1), or a time at which it has broken none (0), and
    the Moment then."""

    time: float
    side: int
    there: Moment


@inlined
def make_motion(drift, u, speed, decay, own):  # type: ignore[no-untyped-def]
    """The motion with u(0) = u and u'(0) = speed - drift."""
    beat = np.sqrt(abs(own - decay)) * np.sqrt(own + decay)
    return OscillatorMotion(drift, u, speed - drift, decay, own, beat, decay < own)


@bare
def moment_at(m, t):  # type: ignore[no-untyped-def]
    """The Moment at time t >= 0."""
    if m.rings:
        faded, angle = np.expm1(-m.decay * t), m.beat * t
        fading = 1.0 + faded if faded > -0.5 else np.exp(-m.decay * t)
        sine, cosine = np.sin(angle), np.cos(angle)
        d = fading * sine / m.beat
        # C - 1, which is small at first
        c = faded * cosine + m.decay * d
        c -= sine * sine / (1.0 + cosine) if cosine > 0.0 else 1.0 - cosine
        slope = fading * cosine - m.decay * d
    else:
        slow = -m.own / (m.decay + m.beat) * m.own  # the exponent of what dies slowly
        decay, fast = np.exp(slow * t), np.exp(-2.0 * m.beat * t)
        d = decay * t if m.beat == 0.0 else decay * -np.expm1(-2.0 * m.beat * t) / (2.0 * m.beat)
        c = np.expm1(slow * t) - slow * d
        slope = decay * fast + slow * d
    gone = m.u * c + m.speed * d
    change = m.speed * slope - m.own * (m.own * m.u) * d
    return Moment(m.drift * t + gone, gone, m.u + gone, change, m.drift + change)


@inlined
def acceleration(m, u, change):  # type: ignore[no-untyped-def]
    """u'' for given u and u'."""
    return -m.own * m.own * u - 2.0 * m.decay * change


@bare
def next_extreme(m, t, u, change):  # type: ignore[no-untyped-def]
    """Time from the moment t, with these u and u', until the speed has its next extreme; inf if it has none."""
    near = NEAR + NEAR_FRACTION * m.own * t
    # u'' = a and its derivative j; u'' is proportional to a C(t) + j D(t), too
    a = acceleration(m, u, change)
    j = -m.own * m.own * change - 2.0 * m.decay * a + m.decay * a
    if m.rings:
        angle = np.arctan2(a, -j / m.beat)
        angle += np.pi if angle <= 0.0 else 0.0
        return (angle + np.pi if angle < near else angle) / m.beat
    ratio = -a / j if j != 0.0 else -1.0
    if ratio * m.own < near or m.beat * ratio >= 1.0:
        return np.inf
    return ratio if m.beat == 0.0 else np.arctanh(m.beat * ratio) / m.beat


@inlined
def begin_of(m):  # type: ignore[no-untyped-def]
    """The Moment at t = 0."""
    return Moment(0.0, 0.0, m.u, m.speed, m.drift + m.speed)


@inlined
def _moved(m, here, t):  # type: ignore[no-untyped-def]
    """The Moment a time t behind the Moment `here`, or before it, up to t⁴."""
    a = acceleration(m, here.u, here.change)
    jerk = acceleration(m, here.change, a)
    gone = t * (here.change + t * (0.5 * a + t * (jerk / 6.0)))
    change = here.change + t * (a + t * (0.5 * jerk))
    travel = here.travel + (m.drift * t + gone)
    return Moment(travel, here.gone + gone, here.u + gone, change, m.drift + change)


@bare
def meets(m, is_speed, rises, level, low, high, guess):  # type: ignore[no-untyped-def]
    """The time between `low` and `high` when the way (or the speed), which only rises (or only falls) in between, is
    `level`, as it is at some time; and the Moment then.

    Halley's method from `guess`, far away Newton's, and halving where that leaves the interval.
    """
    t = guess if low < guess < high else 0.5 * (low + high)
    here = moment_at(m, t)
    for _ in range(200):
        value, slope = here.travel - level, here.speed
        bend = acceleration(m, here.u, here.change)
        if is_speed:
            value, slope, bend = here.speed - level, bend, acceleration(m, here.change, bend)
        if (value >= 0.0) == rises:
            high = t
        else:
            low = t
        step = -value / slope if slope != 0.0 else np.inf
        more = 0.5 * bend * step / slope
        step /= 1.0 + more if abs(more) < 0.5 else 1.0
        new = t + step
        if low <= new <= high:
            turned = (m.own + 2.0 * m.decay) * abs(step)
            # what is left is of the third order, and below rounding
            if turned < CLOSE and abs(step) * (more * more + turned * turned) <= 1e-13 * t:
                return new, _moved(m, here, step)
        else:
            new = 0.5 * (low + high)
            if new <= low or new >= high:
                break
        t, here = new, moment_at(m, new)
    return t, here


@inlined
def speed_at_break(m, there, off):  # type: ignore[no-untyped-def]
    """The speed at a break that lies so far ahead of where the slider is `there`, at the time of the break as found.

    A time of 1e8 oscillations has eight digits of their phase: the place is known better, and the energy of the motion
    there, u'² + s² u², is that of the motion here, but for what damping takes on the way in between.
    """
    more = (
        off * there.change / there.speed if there.speed != 0.0 else off
    )  # of u; the rest is drift
    if not abs(more) <= abs(off):
        more = off
    kept = there.change * there.change - m.own * m.own * more * (2.0 * there.u + more)
    kept -= 4.0 * m.decay * there.change * more
    return m.drift + np.copysign(np.sqrt(max(kept, 0.0)), there.change)


@bare
def _safe_until(m, t, here, ahead, behind):  # type: ignore[no-untyped-def]
    """A time until which the slider reaches neither position, as |u| <= (u² + u'²/s²)^(1/2), which never grows; t
    itself if that does not tell."""
    furthest = np.sqrt(here.u**2 + (here.change / m.own) ** 2) * (1.0 + 1e-14)
    w = m.drift
    # the way lies within w t - u(0) ± reach
    for limit in (ahead + m.u, behind - m.u):
        if not w * t + furthest < limit:
            return t
        w = -w
    until = np.inf
    if w > 0.0:
        until = (ahead + m.u - furthest) / w
    elif w < 0.0:
        until = (behind - m.u - furthest) / -w
    return until


@bare
def first_passage(m, ahead, behind, most):  # type: ignore[no-untyped-def]
    """When the way first reaches `ahead` (side 1) or -`behind` (-1), both above 0; `most` and side 0 if not before.

    Between two extremes of the speed the slider turns at most once, so that its way has two parts that go one way each.
    Oscillations that cannot reach a position are passed over.
    """
    t, here = 0.0, begin_of(m)
    while t < most:
        safe = min(_safe_until(m, t, here, ahead, behind), most)
        if safe > t:
            t, here = safe, moment_at(m, safe)
            if t == most:
                break
        end = min(t + next_extreme(m, t, here.u, here.change), most)
        there = moment_at(m, end)
        turn, middle = end, there
        if here.speed * there.speed < 0.0:
            turn, middle = meets(m, True, there.speed > 0.0, 0.0, t, end, t)
        if middle.travel >= ahead:
            guess = t + (ahead - here.travel) / here.speed
            when, then = meets(m, False, True, ahead, t, turn, guess)
            return Passage(when, 1, then)
        if middle.travel <= -behind:
            guess = t - (behind + here.travel) / here.speed
            when, then = meets(m, False, False, -behind, t, turn, guess)
            return Passage(when, -1, then)
        if there.travel >= ahead:
            when, then = meets(m, False, True, ahead, turn, end, turn)
            return Passage(when, 1, then)
        if there.travel <= -behind:
            when, then = meets(m, False, False, -behind, turn, end, turn)
            return Passage(when, -1, then)
        t, here = end, there
    return Passage(most, 0, here)
