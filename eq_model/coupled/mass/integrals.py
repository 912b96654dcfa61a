"""Integrals over the closed motion of a slider with mass, for its energies: of its way, and of its squared speed.

A closed form of either is a difference of terms that are larger than it by as much as the oscillation is longer than
the time. For short times there are power series, and beyond critical damping each of two exponentials is integrated
by itself, as the slow one may last far beyond the time and the fast one be over at once.
"""

import numpy as np

from eq_model.compiling import bare, inlined
from eq_model.coupled.mass.motion import acceleration

# (ω/s)² or (σ/s)² below which sums of two exponentials lose too many digits
CRITICAL = 1e-3
# s t and b t below which the series is taken; closed forms lose (s t)^-2 units of rounding
SHORT, SHORT_DAMPED = 0.1, 0.2
TERMS = 14  # of the series; the first one left out is below 0.4^14/14!, 3e-17
SMALL = 0.5  # exponents below which squares of expm1 are integrated by Gauss's rule, to rounding
# Gauss's rule between 0 and 1, exact to the degree 11
PLACES, WEIGHTS = 0.5 * np.array(np.polynomial.legendre.leggauss(6))
PLACES += 0.5


@bare
def motion_integrals(m, t, there):  # type: ignore[no-untyped-def]
    """The integrals of the way and of the squared speed up to t, where the slider is `there`."""
    if m.own * t < SHORT and m.decay * t < SHORT_DAMPED:
        travel, squares = 0.0, 0.0
        for i in range(PLACES.size):
            speed = _series_speed(m, PLACES[i] * t)
            travel += WEIGHTS[i] * (1.0 - PLACES[i]) * speed
            squares += WEIGHTS[i] * speed * speed
        return t * t * travel, t * squares
    if not m.rings and m.beat * m.beat >= CRITICAL * m.own * m.own:
        return _of_exponentials(m, t)
    # the equation of motion, integrated over the time, gives the integral of the displacement u by its ends alone
    lag = -(there.change - m.speed + 2.0 * m.decay * there.gone) / (m.own * m.own)
    squares = m.drift * (m.drift * t + 2.0 * there.gone)
    if m.beat * m.beat >= CRITICAL * m.own * m.own:
        squares += _ringing_squares(m, t)
    else:
        squares += _critical_squares(m, there)
    return 0.5 * m.drift * t * t + lag - m.u * t, squares


@bare
def _series_speed(m, t):  # type: ignore[no-untyped-def]
    """The speed by its power series."""
    # t^k times the k-th derivative of the speed, and the next two
    now, later = m.drift + m.speed, acceleration(m, m.u, m.speed) * t
    after = -m.own * m.own * m.speed * t * t - 2.0 * m.decay * t * later
    term, speed = 1.0, 0.0
    for k in range(TERMS):
        speed += term * now
        term /= k + 1.0
        now, later = later, after
        after = -2.0 * m.decay * t * later - m.own * m.own * t * t * now
    return speed


@inlined
def _grown(rate, t):  # type: ignore[no-untyped-def]
    """The integral of e^(rate t) up to t."""
    return np.expm1(rate * t) / rate


@bare
def _of_exponentials(m, t):  # type: ignore[no-untyped-def]
    """Both where the speed is c + p (e^(slow t) - 1) + q e^(fast t): beyond critical damping."""
    a, fast = acceleration(m, m.u, m.speed), -(m.decay + m.beat)
    slow = -m.own / (m.decay + m.beat) * m.own
    p, q = (a - fast * m.speed) / (2.0 * m.beat), (slow * m.speed - a) / (2.0 * m.beat)
    c, slowly, faster, travel, squares = (
        m.drift + m.speed - q,
        _grown(slow, t),
        _grown(fast, t),
        0.0,
        0.0,
    )
    if -slow * t < SMALL:
        for i in range(PLACES.size):
            speed = c + p * np.expm1(slow * PLACES[i] * t)
            travel += WEIGHTS[i] * (1.0 - PLACES[i]) * speed * t * t
            squares += WEIGHTS[i] * speed * speed * t
    else:
        travel = 0.5 * (c - p) * t * t + p * (slowly - t) / slow
        squares = c * c * t + 2.0 * c * p * (slowly - t)
        squares += p * p * (_grown(2.0 * slow, t) - 2.0 * slowly + t)
    travel += q * (faster - t) / fast
    squares += 2.0 * q * (c * faster + p * (_grown(slow + fast, t) - faster))
    return travel, squares + q * q * _grown(2.0 * fast, t)


@bare
def _ringing_squares(m, t):  # type: ignore[no-untyped-def]
    """The integral of u'² where u' = e^(-bt) (p cos ωt + q sin ωt)."""
    b, a = m.decay, acceleration(m, m.u, m.speed)
    p, q, w = m.speed, (a + b * m.speed) / m.beat, m.beat
    fading, angle = np.exp(-2.0 * b * t), 2.0 * w * t
    mean = -np.expm1(-2.0 * b * t) / (2.0 * b) if b > 0.0 else t
    cosine = -2.0 * b * (fading * np.cos(angle) - 1.0) + 2.0 * w * fading * np.sin(angle)
    sine = -2.0 * b * fading * np.sin(angle) - 2.0 * w * (fading * np.cos(angle) - 1.0)
    varying = 0.5 * (p - q) * (p + q) * cosine + p * q * sine
    return 0.5 * (p * p + q * q) * mean + varying / (4.0 * m.own * m.own)


@bare
def _critical_squares(m, there):  # type: ignore[no-untyped-def]
    """The integral of u'² near critical damping, from the energy that is lost."""
    lost = m.speed * m.speed - there.change * there.change
    lost += m.own * m.own * (m.u - there.u) * (m.u + there.u)
    return 0.5 * lost / (2.0 * m.decay)
