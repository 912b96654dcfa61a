"""Memory: the numbers that describe the history of contacts born together at one stretch."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from master.lives.age.cells import narrowest
from master.lives.cold import ColdLife
from origins import Contacts

Array = npt.NDArray[np.float64]

# Nodes for a start with a width, where each is expensive: on the coarsest level, and more for each
# finer level.
FEW_STARTS, MORE_STARTS = 24, 8


class Scales(NamedTuple):
    """The scales that the steps of a slider have to resolve.

    length : travel over which shares and births change (a length)
    time : the shortest time over which they change in a hold; inf where nothing changes then
    rate : at which fresh contacts break (per time), 0 where steps need not resolve it
    thin : whether heat breaks hardly any contacts but those very close to their thresholds
    """

    length: float
    time: float = np.inf
    rate: float = 0.0
    thin: bool = False


class Leg(NamedTuple):
    """A straight move of contacts at one speed.

    begin, end, furthest : arrays of shape (n,), stretches (lengths), and the largest |x| after it
    duration : time
    """

    begin: Array
    end: Array
    furthest: Array
    duration: float


class Memory:
    """The history of contacts under one law, and their survival; this class: T = 0, where the
    largest |x| suffices, as contacts break only at their thresholds.

    Attributes
    ----------
    scales : Scales
    error : float
        Error of the survival that `left` returns, however small the steps.
    reach : float
        Stretch beyond which no contact holds (a length).
    width : int
        Number of values kept for a strand.
    starts : int
        Most nodes for a start with a width.
    """

    scales: Scales
    width, starts, reach, error = 0, 400, np.inf, 1e-15

    def __init__(self, contacts: Contacts) -> None:
        self._life = ColdLife(contacts)
        self.reach, self.scales = self._life.reach, Scales(width_of(contacts))

    def start(self, stretch: Array) -> Array:
        """Values, shape (n, width), of contacts with stretches (n,) at t = 0."""
        return np.zeros((stretch.size, self.width))

    def fresh(self, stretch: Array, speed: float) -> Array:
        """Values of contacts that are born at stretches (n,) on a slider of this speed."""
        return self.start(stretch)

    def advance(self, kept: Array, leg: Leg) -> Array:
        """Values after a move, shape (n, width)."""
        return kept

    def left(self, kept: Array, stretch: Array, furthest: Array) -> Array:
        """Share that holds and its force, the sum of k x over <k> (lengths), shape (2, n).

        Both are multiplied by the share that holds at birth. kept : values; stretch, furthest :
        stretch and largest |x|, shape (n,).
        """
        seen: Any = _Seen(stretch[:, None], furthest[:, None], np.zeros((furthest.size, 1)))
        return self._life.left(np.zeros((1, 1)), seen)[:, :, 0]


class _Seen(NamedTuple):
    """The part of a History that a ColdLife uses: arrays of shape (n, 1)."""

    now: Array
    high: Array
    low: Array


def width_of(contacts: Contacts) -> float:
    """Length over which the number of breaks changes: the width of the sharpest tenth of P_c."""
    return min(narrowest(contacts.thresholds), contacts.mean_threshold)
