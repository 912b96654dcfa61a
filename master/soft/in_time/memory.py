"""Memory: the few numbers that contacts born together at one stretch keep of their way."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from master.lives.age.grid import narrowest
from master.lives.cold import ColdLife
from origins import Contacts

Array = npt.NDArray[np.float64]

# Nodes for a spread start where each is dear in a step: on the coarsest steps, and more on each
# finer level.
FEW_STARTS, MORE_STARTS = 24, 8


class Scales(NamedTuple):
    """What the steps of a slider have to resolve.

    length : travel over which shares and births change (a length)
    time : the shortest time over which they change on a slider that stands still; inf where nothing
        happens then
    rate : at which fresh contacts break (per time), 0 where steps need not resolve it
    thin : whether heat breaks those that stand within a thin skin below their thresholds, and few
        others
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
    """What one law of contacts remembers and makes of it; here of contacts that remember nothing
    but their largest |x|, as they break at their thresholds alone.

    Attributes
    ----------
    scales : Scales
    error : float
        What `left` is off by, in contacts, however small the steps.
    reach : float
        Stretch beyond which none holds (a length).
    width : int
        Numbers kept for a strand.
    starts : int
        Nodes that stand for a spread start at most.
    """

    scales: Scales
    width, starts, reach, error = 0, 400, np.inf, 1e-15

    def __init__(self, contacts: Contacts) -> None:
        self._life = ColdLife(contacts)
        self.reach, self.scales = self._life.reach, Scales(width_of(contacts))

    def start(self, stretch: Array) -> Array:
        """Numbers, shape (n, width), of contacts that stand at stretches (n,) at t = 0."""
        return np.zeros((stretch.size, self.width))

    def fresh(self, stretch: Array, speed: float) -> Array:
        """Numbers of contacts that are born at stretches (n,) on a slider of this speed."""
        return self.start(stretch)

    def advance(self, kept: Array, leg: Leg) -> Array:
        """Numbers after a move, shape (n, width)."""
        return kept

    def left(self, kept: Array, stretch: Array, furthest: Array) -> Array:
        """Share that holds and its force, the sum of k x over <k> (lengths), shape (2, n).

        Both times the share that holds at birth, by numbers, stretches and largest |x|.
        """
        seen: Any = _Seen(stretch[:, None], furthest[:, None], np.zeros((furthest.size, 1)))
        return self._life.left(np.zeros((1, 1)), seen)[:, :, 0]


class _Seen(NamedTuple):
    """What a cold contact is asked, as a History: arrays of shape (n, 1)."""

    now: Array
    high: Array
    low: Array


def width_of(contacts: Contacts) -> float:
    """Length over which the number of breaks changes: the width of the sharpest tenth of P_c."""
    return min(narrowest(contacts.thresholds), contacts.mean_threshold)
