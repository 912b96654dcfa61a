"""How a density changes at single points: jumps, bends, powers."""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Function = Callable[[Array], Array]

_BESIDE = 1e-5
_APART = np.array([1.0, 2.0, 4.0, 8.0])
_TOWARDS = np.array([1e-12, 1e-11, 1e-10])


def bends(density: Function, points: Array, width: float) -> tuple[Array, Array]:
    """Those of the points where the slope changes by a finite amount, and by how much; the density is smooth over
    some part of `width` to either side."""
    sides = []
    for side in (1.0, -1.0):
        apart = side * _BESIDE * np.minimum(points, width)
        f1, f2, f4, f8 = density(points[:, None] + apart[:, None] * _APART).T
        # right for parabolas, from two sets of three points that must agree
        near, far = (5.0 * f2 - 4.0 * f1 - f4) / (2.0 * apart), (5.0 * f4 - 4.0 * f2 - f8) / (4.0 * apart)
        sides.append((near, np.abs(near - far)))
    (above, doubt), (below, doubt_below) = sides
    sure = np.abs(above - below) > 100.0 * (doubt + doubt_below)
    return points[sure], (above - below)[sure]


def onset(density: Function, start: float, width: float) -> tuple[float, float] | None:
    """Power m and height c of a density c (x - start)^m just above `start`, lengths judged by `width`; None where it
    is no power below 2 there."""
    apart = width * _TOWARDS if start == 0.0 else width * 1e4 * _TOWARDS
    values = density(start + apart)
    if not (values > 0.0).all():
        return None
    power, again = np.diff(np.log(values)) / np.diff(np.log(apart))
    power = round(float(power)) if abs(power - round(float(power))) < 1e-3 else float(power)
    if abs(power - again) > 1e-3 or not -0.999 < power < 2.0:
        return None
    return power, float(values[0] / apart[0] ** power)
