"""Cohorts of contacts that age, on any motion: each strand of them carries the density of its thresholds."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass
from typing import Self

import numpy as np
import numpy.typing as npt

from master._old.lives import halves
from master._old.threshold_cells import Cells
from origins import Contacts

Array = npt.NDArray[np.float64]
Nodes = tuple[Array, Array]

_STEPS = 2.0  # narrowest widths, the length over which births change
_AT_ONCE = 1e-3  # of the time in which thresholds spread by the narrowest width
_DEAD = 1e-13


class AgeingLives:
    """`Lives` of contacts with ageing, closure "exact".

    Parameters
    ----------
    contacts : Contacts
    level : int
        The cells' errors fall by 4 with each.
    start, again : pairs of arrays (n,)
        Stretches of the contacts that hold at X = 0, and of births (lengths), and weights of sum 1.

    Raises InputError for a final law that ends: thresholds would pile up before a wall, which stretches move along.
    """

    def __init__(self, contacts: Contacts, level: int, start: Nodes, again: Nodes) -> None:
        assert contacts.ageing is not None
        self._cells = Cells(contacts, level)
        self.length = _STEPS * self._cells.width
        self.time = _AT_ONCE * self._cells.width**2 / contacts.ageing.rate
        self.rate, self.error, self.fuzzy, self.skin = self._cells.rate, 0.0, True, 0.0
        self.work = self._cells.edges.size // 3 * again[0].size
        self._again, self._count = again, 1
        none = np.empty(0)
        # strands none of which can have broken yet, and those whose thresholds' densities are followed
        self._asleep = Sleepers(none, none, np.empty(0, dtype=np.intp), none)
        self._stretch, self._share, self._cohort = none, none, np.empty(0, dtype=np.intp)
        self._weights = np.empty((0, self._cells.edges.size - 1))
        self._add(start, np.zeros(start[0].size, dtype=np.intp))
        self._held, self._pull = self._read()

    @property
    def held(self) -> Array:
        return self._held

    @property
    def pull(self) -> Array:
        return self._pull

    def born(self) -> None:
        stretch, share = self._again
        self._add(self._again, np.full(stretch.size, self._count))
        self._count += 1
        self._held, self._pull = np.append(self._held, share.sum()), np.append(self._pull, share @ stretch)

    def _add(self, nodes: Nodes, cohort: npt.NDArray[np.intp]) -> None:
        stretch, share = nodes
        asleep = self._cells.untouched(stretch, np.zeros(stretch.size))
        ages = np.zeros(int(asleep.sum()))
        self._asleep = self._asleep.with_(Sleepers(stretch[asleep], share[asleep], cohort[asleep], ages))
        if not asleep.all():
            self._follow(stretch[~asleep], share[~asleep], cohort[~asleep], self._cells.fresh(stretch[~asleep]))

    def _follow(self, stretch: Array, share: Array, cohort: npt.NDArray[np.intp], weights: Array) -> None:
        self._stretch, self._share = np.append(self._stretch, stretch), np.append(self._share, share)
        self._cohort, self._weights = np.append(self._cohort, cohort), np.concatenate([self._weights, weights])

    def advance(self, travel: float, duration: float, bend: float = 0.0) -> None:
        alive = self._weights.sum(axis=1) > _DEAD
        self._stretch, self._share = self._stretch[alive], self._share[alive]
        self._cohort, self._weights = self._cohort[alive], self._weights[alive]
        asleep = self._asleep
        on = self._cells.untouched(asleep.stretch + travel, asleep.age + duration)
        if not on.all():
            up = asleep.where(~on)
            self._follow(up.stretch, up.share, up.cohort, self._cells.aged(up.stretch, up.age))
            asleep = asleep.where(on)
        self._asleep = Sleepers(asleep.stretch + travel, asleep.share, asleep.cohort, asleep.age + duration)
        begin, self._stretch = self._stretch, self._stretch + travel
        turns = begin * self._stretch < 0.0
        # a stretch that passes 0 comes down and goes up again: one move each
        first = np.where(turns, np.abs(begin / travel) if travel else 1.0, 1.0)
        middle = np.where(turns, 0.0, self._stretch)
        self._weights = self._cells.move(self._weights, np.abs(begin), np.abs(middle), first * duration, bend)
        if turns.any():
            rest = (1.0 - first[turns]) * duration
            onward = np.abs(self._stretch[turns])
            self._weights[turns] = self._cells.move(self._weights[turns], np.zeros(rest.size), onward, rest)
        self._held, self._pull = self._read()

    def spread(self) -> tuple[Array, Array]:
        return halves(self._held), halves(self._pull)

    def copy(self) -> Self:
        # arrays are replaced, never written to
        return copy(self)

    def _read(self) -> tuple[Array, Array]:
        holds = np.append(self._share * self._weights.sum(axis=1), self._asleep.share)
        bears = holds * np.append(self._stretch, self._asleep.stretch)
        cohort = np.append(self._cohort, self._asleep.cohort)
        held, pull = (np.bincount(cohort, part, minlength=self._count).astype(float) for part in (holds, bears))
        return held, pull


@dataclass(frozen=True)
class Sleepers:
    """Strands, arrays of shape (n,), the thresholds of which are far above the stretch all the time."""

    stretch: Array
    share: Array
    cohort: npt.NDArray[np.intp]
    age: Array

    def where(self, these: npt.NDArray[np.bool_]) -> Sleepers:
        return Sleepers(self.stretch[these], self.share[these], self.cohort[these], self.age[these])

    def with_(self, other: Sleepers) -> Sleepers:
        return Sleepers(
            np.append(self.stretch, other.stretch),
            np.append(self.share, other.share),
            np.append(self.cohort, other.cohort),
            np.append(self.age, other.age),
        )
