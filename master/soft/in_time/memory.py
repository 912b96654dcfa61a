"""Memory: the few numbers that contacts born together at one stretch keep of their way."""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from master.lives.age.grid import narrowest
from master.lives.cold import ColdLife
from origins import Contacts

Array = npt.NDArray[np.float64]

# Nodes for the stretches at the start where each costs little in a step; and where each is dear,
# on the coarsest steps and more on each finer level.
STARTS, FEW_STARTS, MORE_STARTS = 400, 24, 8


class Scales(NamedTuple):
    """What the steps of a slider have to resolve.

    length : travel over which shares and births change (a length)
    time : the shortest time over which they change on a slider that stands still; inf where nothing
        happens then
    rate : at which fresh contacts break (per time), 0 where steps need not resolve it
    skin : stretch over which the rate of breaking changes by a factor e where few break by it, or 0
    fuzzy : whether thresholds fluctuate, so that none stand right at a stretch
    """

    length: float
    time: float = np.inf
    rate: float = 0.0
    skin: float = 0.0
    fuzzy: bool = False


class Leg(NamedTuple):
    """A straight move of contacts at one speed.

    begin, end, furthest : arrays of shape (n,), stretches (lengths), and the largest |x| after it
    duration : time
    """

    begin: Array
    end: Array
    furthest: Array
    duration: float


class Left(NamedTuple):
    """What is left of contacts, arrays of shape (n,), all times the share that holds at their birth.

    held : share that holds; force : the sum of their k x over <k> (lengths)
    edge, edge_stiff : density of thresholds at the largest |x|, per length, and times k_i/<k>: how
        fast the share and its stiffness fall where the largest |x| grows
    """

    held: Array
    force: Array
    edge: Array
    edge_stiff: Array


class Memory(Protocol):
    """What one law of contacts remembers and makes of it.

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
    error: float
    reach: float
    width: int
    starts: int

    def start(self, stretch: Array) -> Array:
        """Numbers, shape (n, width), of contacts that stand at stretches (n,) at t = 0."""
        ...

    def fresh(self, stretch: Array, speed: float) -> Array:
        """Numbers of contacts that are born at stretches (n,) on a slider of this speed."""
        ...

    def advance(self, kept: Array, leg: Leg) -> Array:
        """Numbers after a move, shape (n, width)."""
        ...

    def left(self, kept: Array, stretch: Array, furthest: Array) -> Left:
        """What is left of contacts by their numbers, stretches and largest |x|, shapes (n,)."""
        ...


class _Seen(NamedTuple):
    """What a cold contact is asked, as a History: arrays of shape (n, 1)."""

    now: Array
    high: Array
    low: Array


class ColdMemory:
    """Contacts that break at their thresholds alone: their largest |x| is all there is to know."""

    width, error, starts = 0, 1e-15, STARTS

    def __init__(self, contacts: Contacts) -> None:
        self._life, self._law = ColdLife(contacts), contacts.thresholds
        self._stiffness = contacts.relative_stiffness
        self.reach = self._life.reach
        self.scales = Scales(width_of(contacts))

    def start(self, stretch: Array) -> Array:
        """See Memory."""
        return np.empty((stretch.size, 0))

    def fresh(self, stretch: Array, speed: float) -> Array:
        """See Memory."""
        return np.empty((stretch.size, 0))

    def advance(self, kept: Array, leg: Leg) -> Array:
        """See Memory."""
        return kept

    def left(self, kept: Array, stretch: Array, furthest: Array) -> Left:
        """See Memory."""
        x, m = stretch[:, None], furthest[:, None]
        seen: Any = _Seen(x, m, np.zeros(m.shape))
        held, force = self._life.left(np.zeros((1, 1)), seen)[:, :, 0]
        edge = np.asarray(self._law.pdf(furthest))
        return Left(held, force, edge, edge * self._stiffness(np.maximum(furthest, 1e-300)))


def width_of(contacts: Contacts) -> float:
    """Length over which the number of breaks changes: the width of the sharpest tenth of P_c."""
    return min(narrowest(contacts.thresholds), contacts.mean_threshold)
