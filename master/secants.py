"""Roots of functions that are dear to ask, from good guesses."""

from collections.abc import Callable

import numpy as np

_UNLIKE = 0.2
_ITERATIONS = 40


def foreseen(values: list[float]) -> float:
    """The next of them, by the parabola through the last."""
    if len(values) < 4:  # the first is a guess
        return values[-1]
    a, b, c = values[-3:]
    guess = a + 3.0 * (c - b)
    return guess if abs(guess - c) < _UNLIKE else c


def secant(
    function: Callable[[float], float], guess: float, slope: float, close: float, least: float = -np.inf
) -> float:
    """Asks for the root by secants from guesses of it and of the slope there, which is returned; asked last is the
    root, or `least` where a function that rises has none above."""
    a, fa = guess, function(guess)
    if abs(fa / slope) <= close and a >= least:
        return slope
    for _ in range(_ITERATIONS):
        b = max(a - fa / slope, least)
        fb = function(b)
        if abs(b - a) <= close or (b == least and fb >= 0.0) or fb == 0.0:
            break
        if fb != fa:
            slope = (fb - fa) / (b - a)
        # what is left is the error of the slope, not worth another step
        if abs(fb / slope) <= close:
            break
        a, fa = b, fb
    return slope
