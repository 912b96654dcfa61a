"""The rate of stiff contacts, its integral and the inverse, for numbers and for arrays.

c = k_i x_s²/2k_BT is the barrier at x = 0, and u = s^(3/2) falls from 1 to 0 on the way to the threshold. The
integral of h is (2 ω x_s/3c) (e^(-c u_far) - e^(-c u_near)). Compiled loops over single contacts call
these functions too.
"""

from typing import Any, NamedTuple

import numpy as np


class StiffLaw(NamedTuple):
    """k/2k_BT at mean stiffness, per length squared; ω, per time."""

    spring: float
    omega: float


def log_rate(law: StiffLaw, x: Any, threshold: Any, stiffness: Any) -> Any:
    """ln h; -inf at the threshold."""
    s = np.maximum((threshold - x) / threshold, 0.0)
    barrier = law.spring * stiffness * threshold * threshold * (s * np.sqrt(s))
    return np.log(law.omega) + (0.5 * np.log(s) - barrier)


def log_passed(law: StiffLaw, near: Any, far: Any, threshold: Any, stiffness: Any) -> Any:
    """ln of the integral of h from near to far; -inf where they are equal."""
    c = law.spring * stiffness * threshold * threshold
    first = np.sqrt(np.maximum((threshold - near) / threshold, 0.0))
    last = np.sqrt(np.maximum((threshold - far) / threshold, 0.0))
    # u(near) - u(far), without cancellation
    lost = (far - near) / threshold * (first * first + first * last + last * last)
    lost = lost / np.maximum(first + last, 1e-300)
    length = 2.0 / 3.0 * threshold * (-np.expm1(-c * lost) / c)
    return np.log(law.omega) + (np.log(length) - c * last * last * last)


def reached(law: StiffLaw, log_amount: Any, near: Any, threshold: Any, stiffness: Any) -> Any:
    """Stretch at which the integral of h from near is e^log_amount, or the threshold."""
    c = law.spring * stiffness * threshold * threshold
    log_part = log_amount - np.log(law.omega) + np.log(1.5 * c / threshold)
    root = np.sqrt(np.maximum((threshold - near) / threshold, 0.0))
    level = log_part + c * root * root * root
    # c u at the end is -ln(e^log_part + e^(-c u_near)): `more` is ln(1 + the ratio of the smaller to the larger)
    more = np.log1p(np.exp(-np.abs(level)))
    u = np.maximum(np.minimum(-log_part, c * root * root * root) - more, 0.0) / c
    gone = near / threshold * (1.0 + root + root * root) / (1.0 + root)
    gone = gone + (np.maximum(level, 0.0) + more) / c
    # x from the smaller of u and gone = 1 - u, which has kept its digits
    late = 1.0 - np.cbrt(u * u)
    early = -np.expm1(2.0 / 3.0 * np.log1p(-np.minimum(gone, 0.75)))
    is_late = u < 0.5
    x = threshold * (is_late * late + (1.0 - is_late) * early)
    return np.minimum(np.maximum(x, near), threshold)
