"""Roots of functions that are dear to ask, from good guesses."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

ITERATIONS = 40
Function = Callable[[float], float]


def secant(
    function: Function, guess: float, slope: float, close: float, least: float = -np.inf
) -> float:
    """Ask for the root by secants from guesses of it and of the slope there, which is returned.

    Asked last is the root, or `least` where a function that rises has none above. Where the
    function turns on the way secants may leave what is known to hold the root: then that is halved.
    """
    given, rises = slope, float(np.sign(slope))
    low, high = -np.inf, np.inf
    a, fa = guess, function(guess)
    if abs(fa / slope) <= close and a >= least:
        return slope
    for _ in range(ITERATIONS):
        low, high = (max(low, a), high) if rises * fa < 0.0 else (low, min(high, a))
        b = max(a - fa / slope, least) if slope != 0.0 else np.inf
        if not low < b < high and np.isfinite(high - low):
            b = 0.5 * (low + high)
        fb = function(b)
        if abs(b - a) <= close or (b == least and fb >= 0.0) or fb == 0.0:
            break
        if fb != fa:
            slope = (fb - fa) / (b - a)
        # what is left is the error of the slope, not worth another step
        if rises * slope > 0.0 and abs(fb / slope) <= close:
            break
        a, fa = b, fb
    return slope if rises * slope > 0.0 else given
