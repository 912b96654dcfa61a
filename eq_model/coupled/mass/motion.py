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


@inlined
def make_motion(drift, u, speed, decay, own):  # type: ignore[no-untyped-def]
    """The motion with u(0) = u and u'(0) = speed - drift."""
    beat = np.sqrt(abs(own - decay)) * np.sqrt(own + decay)
    return OscillatorMotion(drift, u, speed - drift, decay, own, beat, decay < own)


@bare
def moment_at(m, t):  # type: ignore[no-untyped-def]
    """The Moment at time t >= 0."""
    if m.rings:
        fading, angle = np.exp(-m.decay * t), m.beat * t
        sine, cosine, half = np.sin(angle), np.cos(angle), np.sin(0.5 * angle)
        d = fading * sine / m.beat
        # C - 1, which is small at first
        c = np.expm1(-m.decay * t) * cosine - 2.0 * half * half + m.decay * d
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


@bare
def meets(m, is_speed, rises, level, low, high, guess):  # type: ignore[no-untyped-def]
    """The time between `low` and `high` when the way (or the speed), which only rises (or only falls) in between, is
    `level`, as it is at some time.

    Newton's method from `guess`, and halving where that leaves the interval.
    """
    t = guess if low < guess < high else 0.5 * (low + high)
    for _ in range(200):
        here = moment_at(m, t)
        value, slope = here.travel - level, here.speed
        if is_speed:
            value, slope = here.speed - level, acceleration(m, here.u, here.change)
        if (value >= 0.0) == rises:
            high = t
        else:
            low = t
        new = t - value / slope if slope != 0.0 else np.inf
        if low <= new <= high:
            if abs(new - t) <= 1e-12 * t:  # the next step would be below rounding
                return new
        else:
            new = 0.5 * (low + high)
            if new <= low or new >= high:
                return new
        t = new
    return t


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
    furthest = np.hypot(here.u, here.change / m.own) * (1.0 + 1e-14)
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
    """When the way first reaches `ahead` (1) or -`behind` (-1), both above 0, and which; `most` and 0 if not before.

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
        turn, middle = end, there.travel
        if here.speed * there.speed < 0.0:
            turn = meets(m, True, there.speed > 0.0, 0.0, t, end, t)
            middle = moment_at(m, turn).travel
        if middle >= ahead:
            guess = t + (ahead - here.travel) / here.speed
            return meets(m, False, True, ahead, t, turn, guess), 1
        if middle <= -behind:
            guess = t - (behind + here.travel) / here.speed
            return meets(m, False, False, -behind, t, turn, guess), -1
        if there.travel >= ahead:
            return meets(m, False, True, ahead, turn, end, turn), 1
        if there.travel <= -behind:
            return meets(m, False, False, -behind, turn, end, turn), -1
        t, here = end, there
    return most, 0
