"""The barrier of a stiff contact, u = (1 - x/x_s)^(3/2) of that at rest: u from x, and x from u.

Of numbers and of arrays alike, as compiled loops over single contacts call these functions too.
"""

import numpy as np
import numpy.typing as npt

from origins.laws.rate_law import Numbers

Array = npt.NDArray[np.float64]

_LEAST = 1e-300  # in place of 0, where nothing is left to divide


def remaining(x: Numbers, threshold: Numbers) -> Array:
    """u = (1 - x/x_s)^(3/2), 0 beyond the threshold."""
    s = np.maximum((threshold - x) / threshold, 0.0)
    return s * np.sqrt(s)


def fall(near: Numbers, far: Numbers, threshold: Numbers) -> Array:
    """u(near) - u(far), without cancellation."""
    first = np.sqrt(np.maximum((threshold - near) / threshold, 0.0))
    last = np.sqrt(np.maximum((threshold - far) / threshold, 0.0))
    part = (far - near) / threshold * (first * first + first * last + last * last)
    return part / np.maximum(first + last, _LEAST)


def stretch(u: Numbers, gone: Numbers, threshold: Numbers) -> Array:
    """x from u and from gone = 1 - u, by whichever is the smaller and has kept its digits."""
    late = 1.0 - np.cbrt(u * u)
    early = -np.expm1(2.0 / 3.0 * np.log1p(-np.minimum(gone, 0.75)))
    is_late = u < 0.5
    return threshold * (is_late * late + (1.0 - is_late) * early)
