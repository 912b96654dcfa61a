"""What temperature, or nothing, leaves of contacts that were born at one stretch: the face of such a law.

A contact holds at least while its threshold exceeds m, the largest |x| of its life; a `Wear` says how many of those
born at r still do. What it must remember of a strand of contacts are a few numbers, `worn`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from master._old.cut_law import SLACK
from master._old.piecewise import tabulate
from origins import Contacts
from origins.thresholds.quadrature import panel_edges
from origins.thresholds.scipy_laws import FrozenThresholds

Array = npt.NDArray[np.float64]

_FROZEN = 20.0  # functions of scipy.stats


@dataclass
class Left:
    """What is left of strands, arrays of shape (m,), times S(|r|).

    Attributes
    ----------
    held, stiff : array
        Share that holds, and the sum of relative stiffnesses.
    edge, edge_stiff : array
        Density of thresholds at m, the same times stiffness: how fast these fall where m grows.
    """

    held: Array
    stiff: Array
    edge: Array
    edge_stiff: Array


@dataclass
class Standing:
    """Contacts that break each at a rate of its own while the slider stands, arrays of shape (n,), times S(|r|).

    Attributes
    ----------
    rate, held, stiff : array
        Rates, share of the contacts, and the same times relative stiffness.
    """

    rate: Array
    held: Array
    stiff: Array


class Wear(Protocol):
    """Stretches and largest |x| are lengths of shape (m,); `worn` has shape (m, width).

    `length`, `time`, `rate`, `error`, `skin` and `work` are those of master.lives.Lives.
    `forgets`: whether thresholds tell where |x| grows, however large it was before; `slow`: how many times longer than
    usual it takes to look at a number.
    """

    length: float
    time: float
    rate: float
    error: float
    work: int
    width: int
    forgets: bool
    slow: float
    skin: float

    def fresh(self, stretch: Array) -> Array:
        """Numbers of strands born at these stretches."""

    def advance(self, worn: Array, begin: Array, end: Array, furthest: Array, duration: float | Array) -> None:
        """In place: strands move straight from `begin` to `end` at constant speed; m is that before."""

    def settle(self, worn: Array, stretch: Array, furthest: Array) -> None:
        """In place: whatever of the motion so far is not worked out yet, before trial steps are made from here."""

    def left(self, worn: Array, stretch: Array, furthest: Array) -> Left: ...

    def keeper(self) -> Keeper | None:
        """The wear of contacts born all through a hold; None where they are followed like all others."""


class Keeper(Wear, Protocol):
    """A wear that tells what is left of contacts of many ages, born at one stretch."""

    def standing(self, stretch: float) -> Standing:
        """Those born at a stretch, while the slider stands."""

    def kept(self, stretch: float, spent: Array) -> Array:
        """Numbers, shape (width,), of contacts born at a stretch, of which e^-spent is left at each rate of
        `standing`."""


class ColdWear:
    """Nothing breaks below its threshold."""

    time, rate, error, work, width = np.inf, 0.0, 1e-15, 10, 0
    forgets, slow, skin = False, 1.0, 0.0

    def __init__(self, contacts: Contacts, length: float) -> None:
        self._law, self.length = contacts.thresholds, length
        if isinstance(self._law, FrozenThresholds):
            self.slow = _FROZEN
        self._stiffness = contacts.relative_stiffness
        self._beyond = stiffness_beyond(contacts) if contacts.stiffness == "linked" else None

    def fresh(self, stretch: Array) -> Array:
        return np.empty((stretch.size, 0))

    def advance(self, worn: Array, begin: Array, end: Array, furthest: Array, duration: float | Array) -> None:
        pass

    def settle(self, worn: Array, stretch: Array, furthest: Array) -> None:
        pass

    def left(self, worn: Array, stretch: Array, furthest: Array) -> Left:
        # a contact whose stretch has reached its threshold is broken: survival past rounding of the sum
        reached = furthest * (1.0 + SLACK)
        held, edge = self._law.sf(reached), self._law.pdf(furthest)
        if self._beyond is None:
            return Left(held, held, edge, edge)
        return Left(held, self._beyond(reached), edge, edge * self._stiffness(furthest))

    def standing(self, stretch: float) -> Standing:
        left = self.left(self.fresh(np.array([stretch])), np.array([stretch]), np.array([abs(stretch)]))
        return Standing(np.zeros(1), left.held, left.stiff)

    def keeper(self) -> Keeper:
        return self

    def kept(self, stretch: float, spent: Array) -> Array:
        return np.empty(0)


def stiffness_beyond(contacts: Contacts) -> Callable[[Array], Array]:
    """Integral of k P_c beyond a stretch."""
    law, unit = contacts.thresholds, contacts.mean_threshold
    atoms, weights = law.atoms
    edges = panel_edges(law) if float(weights.sum()) < 1.0 - 1e-14 else np.zeros(1)
    (table,) = tabulate(lambda x: (x / unit * law.pdf(x))[None], edges, 1e-15)

    def beyond(least: Array) -> Array:
        return table.total - table.integral(least) + ((atoms > least[:, None]) * (weights * atoms / unit)).sum(axis=1)

    return beyond
