"""Compiled: draws of normal numbers, and of Brownian bridges between the steps of a threshold."""

import numpy as np

from eq_model.compiling import bare
from eq_model.draws.streams import WATCHED, uniform, words_at

_F = np.float64


@bare
def normal(words):  # type: ignore[no-untyped-def]
    """A draw of the standard normal law from three of four words."""
    angle = 2.0 * np.pi * (_F(words[2]) + 0.5) * 2.0**-32
    return np.sqrt(-2.0 * np.log(uniform(words[0], words[1]))) * np.cos(angle)


@bare
def fourth(words):  # type: ignore[no-untyped-def]
    """Between 0 and 1, from the fourth of four words."""
    return (_F(words[3]) + 0.5) * 2.0**-32


@bare
def first_meeting(above, below, spread, bell, chance):  # type: ignore[no-untyped-def]
    """Part of a step after which a Brownian bridge from `above` zero first meets it, when it does.

    I/(1 + I), I of the inverse Gaussian law of mean above/|below| and shape above²/spread², spread² the variance of
    the step without ends.
    """
    if above <= 0.0:
        return 0.0
    if below == 0.0:
        return 1.0
    mean, shape = above / abs(below), (above / spread) ** 2
    w = 0.5 * mean * bell * bell / shape
    first = mean / (1.0 + w + np.sqrt(w * (2.0 + w)))
    if chance * (mean + first) > mean:
        first = mean * (mean / first)
    return first / (1.0 + first)


@bare
def between(above, below, variance, part, lane, turn, stream):  # type: ignore[no-untyped-def]
    """How far above zero a Brownian bridge from `above` to `below` is after a part of its way, given that it stays.

    It is the distance of a bridge in three dimensions, whose end has a random direction (Williams, 1974).
    """
    part = min(max(part, 0.0), 1.0)
    width = np.sqrt(variance * part * (1.0 - part))
    first, second = words_at(lane, turn, stream, WATCHED), words_at(lane, turn, stream, WATCHED + 1)
    third = words_at(lane, turn, stream, WATCHED + 2)
    chance, pull = fourth(first), above * below / variance
    along = 2.0 * chance - 1.0
    if pull > 1e-6:
        along = 1.0 + np.log(chance + (1.0 - chance) * np.exp(-2.0 * pull)) / pull
    across = np.sqrt(max(1.0 - along * along, 0.0))
    x = (1.0 - part) * above + part * below * along + width * normal(first)
    y = part * below * across + width * normal(second)
    return np.sqrt(x * x + y * y + (width * normal(third)) ** 2)
