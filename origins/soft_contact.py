"""Thermal breaking of a soft contact, h = ω exp[-k (x_s² - x²) / 2k_BT] (paper, Eqs. temper5 and temper8).

In units of the attempt frequency, in logarithms, and for stretches 0 <= x <= threshold; `spring` is k_i/(2 k_BT),
per length squared. Arrays of one shape (n,).
"""

import numpy as np
import numpy.typing as npt
from scipy.special import dawsn

from origins.dawson import inverse_log_growth, log_growth
from origins.quadrature import GAUSS_NODES, GAUSS_WEIGHTS

Array = npt.NDArray[np.float64]

_MOST = 650.0  # e to it is a number, and none holds at such a rate


def log_rate(x: Array, threshold: Array, spring: Array) -> Array:
    """ln(h/ω)."""
    return -spring * (threshold - x) * (threshold + x)


def grown(x: Array, threshold: Array, spring: Array, log_scale: float) -> tuple[Array, Array]:
    """h/ω and its integral from 0 to x of either sign, both times e^log_scale; broadcast, underflowing to 0."""
    root = np.sqrt(spring)
    rate = np.exp(np.minimum(log_scale - spring * (threshold - x) * (threshold + x), _MOST))
    return rate, rate * (dawsn(root * x) / root)


def log_between(near: Array, far: Array, threshold: Array, spring: Array) -> Array:
    """ln of the integral of h/ω, a length, from `near` to `far` >= near; -inf where they are one."""
    rise = spring * (far - near) * (far + near)
    length = np.empty(rise.shape)
    # where the rate hardly changes the difference cancels; there eight nodes, placed from `far` back, are exact
    flat = (rise < 1.0) & (near > 0.0)
    across, most, least = (far - near)[flat], (2.0 * spring * far)[flat], spring[flat]
    total = np.zeros(across.size)
    for node, weight in zip(GAUSS_NODES, GAUSS_WEIGHTS, strict=True):
        back = node * across
        total += weight * np.exp(back * (least * back - most))
    length[flat] = across * total
    steep = ~flat
    root, far_steep, near_steep = np.sqrt(spring[steep]), far[steep], near[steep]
    length[steep] = (dawsn(root * far_steep) - np.exp(-rise[steep]) * dawsn(root * near_steep)) / root
    return log_rate(far, threshold, spring) + np.log(length)


def advance(log_amount: Array, near: Array, threshold: Array, spring: Array) -> Array:
    """Stretch up to which the integral of h/ω from `near` is the amount; the threshold where it stays below."""
    root = np.sqrt(spring)
    level = np.logaddexp(_level(log_amount, threshold, spring), log_growth(root * near))
    return np.clip(inverse_log_growth(level) / root, near, threshold)


def from_rest(log_amount: Array, threshold: Array, spring: Array) -> Array:
    """The same from 0 on, of arrays that broadcast."""
    return np.minimum(inverse_log_growth(_level(log_amount, threshold, spring)) / np.sqrt(spring), threshold)


def _level(log_amount: Array, threshold: Array, spring: Array) -> Array:
    return log_amount + (0.5 * np.log(spring) + spring * threshold * threshold)


def retreat(log_share: Array, far: Array, threshold: Array, spring: Array) -> Array:
    """Stretch down to which the integral of h/ω from `far` is a share <= 1 of the one down to 0."""
    root = np.sqrt(spring)
    level = log_growth(root * far) + np.log(-np.expm1(log_share))
    return np.clip(inverse_log_growth(level) / root, 0.0, far)
