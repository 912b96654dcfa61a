"""Integrals over the closed motion of a slider with mass, for its energies: of its way, and of its squared speed.

A closed form of either is a difference of terms that are larger than it by as much as the oscillation is longer than
the time. For short times they follow from both ends, and beyond critical damping each of two exponentials is integrated
by itself, as the slow one may last far beyond the time and the fast one be over at once.
"""

import numpy as np

from eq_model.compiling import bare, inlined
from eq_model.coupled.mass.motion import acceleration, begin_of

# (ω/s)² or (σ/s)² below which sums of two exponentials lose too many digits
CRITICAL = 1e-3
# s t and b t below which the values and derivatives at both ends are taken: what these leave is below
# (2 s t)^10/1e10 and (4 b t)^10/1e10; closed forms lose (s t)^-2 units of rounding
SHORT, SHORT_DAMPED = 0.1, 0.05
SMALL = 0.5  # exponents below which squares of expm1 are integrated by Gauss's rule, to rounding
# Gauss's rule between 0 and 1, exact to the degree 11
PLACES, WEIGHTS = 0.5 * np.array(np.polynomial.legendre.leggauss(6))
PLACES += 0.5


@bare
def motion_integrals(m, t, there):  # type: ignore[no-untyped-def]
    """The integrals of the way and of the squared speed up to t, where the slider is `there`."""
    if m.own * t < SHORT and m.decay * t < SHORT_DAMPED:
        begin, end = _derivatives(m, begin_of(m)), _derivatives(m, there)
        travel = _by_ends(t, (0.0, *begin[:4]), (there.travel, *end[:4]))
        return travel, _by_ends(t, _square(begin), _square(end))
    if not m.rings and m.beat * m.beat >= CRITICAL * m.own * m.own:
        return _of_exponentials(m, t)
    # the equation of motion, integrated over the time, gives the integral of the displacement u by its ends alone
    lag = -(there.change - m.speed + 2.0 * m.decay * there.gone) / (m.own * m.own)
    # u'² + s² u² + 2 b u u' falls as e^(-2bt): so the integral of u'² follows from that of this, and from u u'
    falling = m.speed * m.speed + m.own * m.own * m.u * m.u + 2.0 * m.decay * m.u * m.speed
    mean = -np.expm1(-2.0 * m.decay * t) / (2.0 * m.decay) if m.decay > 0.0 else t
    own = 0.5 * (falling * mean + there.u * there.change - m.u * m.speed)
    squares = m.drift * (m.drift * t + 2.0 * there.gone) + own
    return 0.5 * m.drift * t * t + lag - m.u * t, squares


@inlined
def _by_ends(t, f, g):  # type: ignore[no-untyped-def]
    """The integral over a time t of a function with these values and first four derivatives at its two ends."""
    even = (f[0] + g[0]) / 2.0 + t * t * ((f[2] + g[2]) / 72.0 + t * t * (f[4] + g[4]) / 30240.0)
    return t * (even + t * ((f[1] - g[1]) / 9.0 + t * t * (f[3] - g[3]) / 1008.0))


@inlined
def _derivatives(m, here):  # type: ignore[no-untyped-def]
    """The speed and its first four derivatives at the Moment `here`."""
    a = acceleration(m, here.u, here.change)
    jerk = acceleration(m, here.change, a)
    snap = acceleration(m, a, jerk)
    return here.speed, a, jerk, snap, acceleration(m, jerk, snap)


@inlined
def _square(d):  # type: ignore[no-untyped-def]
    """The square of a function with these derivatives, and its own four."""
    second = d[1] * d[1] + d[0] * d[2]
    third = 3.0 * d[1] * d[2] + d[0] * d[3]
    fourth = 3.0 * d[2] * d[2] + 4.0 * d[1] * d[3] + d[0] * d[4]
    return d[0] * d[0], 2.0 * d[0] * d[1], 2.0 * second, 2.0 * third, 2.0 * fourth


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
