"""Thermal breaking of a stiff contact, h = ω s^(1/2) exp[-k x_s² s^(3/2) / 2k_BT], s = 1 - x/x_s (paper, Eqs. temper9
and temper10).

In units of the attempt frequency, in logarithms, and for stretches 0 <= x <= threshold; `spring` is k_i/(2 k_BT),
per length squared. Arrays of one shape (n,). With c = spring x_s² and u = s^(3/2), which falls from 1 to 0 on the
way to the threshold, the integral of h/ω is (2 x_s/3c) (e^(-c u) - e^(-c u_near)).
"""

import numpy as np
import numpy.typing as npt
from scipy.special import exprel

Array = npt.NDArray[np.float64]

_MOST = 650.0  # e to it is a number, and none holds at such a rate


def log_rate(x: Array, threshold: Array, spring: Array) -> Array:
    """ln(h/ω); -inf at the threshold."""
    s = (threshold - x) / threshold
    return 0.5 * np.log(s) - spring * threshold * threshold * (s * np.sqrt(s))


def grown(x: Array, threshold: Array, spring: Array, log_scale: float) -> tuple[Array, Array]:
    """h/ω and its integral from 0 to x of either sign, both times e^log_scale; broadcast, underflowing to 0."""
    far = np.abs(x)
    share, s = far / threshold, np.maximum(threshold - far, 0.0) / threshold
    root, c = np.sqrt(s), spring * threshold * threshold
    whole = np.exp(np.minimum(log_scale - c * (s * root), _MOST))
    # 1 - s^(3/2), without cancellation
    fall = share * (1.0 + root + s) / (1.0 + root)
    return root * whole, np.sign(x) * (threshold / (-1.5 * c) * np.expm1(-c * fall) * whole)


def log_between(near: Array, far: Array, threshold: Array, spring: Array) -> Array:
    """ln of the integral of h/ω, a length, from `near` to `far` >= near; -inf where they are one."""
    c, fall = spring * threshold * threshold, _fall(near, far, threshold)
    return np.log(2.0 / 3.0 * threshold * fall * exprel(-c * fall)) - c * _u(far, threshold)


def advance(log_amount: Array, near: Array, threshold: Array, spring: Array) -> Array:
    """Stretch up to which the integral of h/ω from `near` is the amount; the threshold where it stays below."""
    c = spring * threshold * threshold
    start, log_part = c * _u(near, threshold), log_amount + np.log(1.5 * c / threshold)
    gone = np.logaddexp(0.0, log_part + start)
    left = np.where(log_part + start > 0.0, -np.logaddexp(log_part, -start), start - gone)
    x = _stretch(np.maximum(left, 0.0) / c, _fall(np.zeros_like(near), near, threshold) + gone / c, threshold)
    return np.clip(x, near, threshold)


def from_rest(log_amount: Array, threshold: Array, spring: Array) -> Array:
    """The same from 0 on, of arrays that broadcast."""
    c = spring * threshold * threshold
    log_part = log_amount + np.log(1.5 * c / threshold)
    more = np.log1p(np.exp(-np.abs(log_part + c)))
    left, gone = -np.maximum(log_part, -c) - more, np.maximum(log_part + c, 0.0) + more
    return np.clip(_stretch(np.maximum(left, 0.0) / c, gone / c, threshold), 0.0, threshold)


def retreat(log_share: Array, far: Array, threshold: Array, spring: Array) -> Array:
    """Stretch down to which the integral of h/ω from `far` is a share <= 1 of the one down to 0."""
    c, whole = spring * threshold * threshold, _fall(np.zeros_like(far), far, threshold)
    back = -np.log1p(np.exp(log_share) * np.expm1(-c * whole)) / c
    return np.clip(_stretch(_u(far, threshold) + back, whole - back, threshold), 0.0, far)


def _u(x: Array, threshold: Array) -> Array:
    s = (threshold - x) / threshold
    return s * np.sqrt(s)


def _fall(near: Array, far: Array, threshold: Array) -> Array:
    """u(near) - u(far), without cancellation."""
    first, last = np.sqrt((threshold - near) / threshold), np.sqrt((threshold - far) / threshold)
    part = (far - near) / threshold * (first * first + first * last + last * last)
    return np.divide(part, first + last, out=np.zeros_like(part), where=first > 0.0)


def _stretch(u: Array, gone: Array, threshold: Array) -> Array:
    """x from u and from gone = 1 - u, whichever is the smaller."""
    near_zero = -np.expm1(2.0 / 3.0 * np.log1p(-np.minimum(gone, 0.75)))
    return threshold * np.where(u < 0.5, 1.0 - np.square(np.cbrt(u)), near_zero)
