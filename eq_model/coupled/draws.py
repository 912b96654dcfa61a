"""Where coupled contacts get their numbers: a start for a replica, and draws one by one.

Everything that coupled contacts draw comes through this file and draws_kernel.py. A replica has
streams of its own, so that no order of replicas shows.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from eq_model.beginning import Beginning, reforming_table
from eq_model.compiled_table import kernel_table
from origins import Contacts
from origins.streams import LIFE_TAILS, LIVES, PURPOSE_SHIFT, THRESHOLD_TAILS, THRESHOLDS

if TYPE_CHECKING:
    from eq_model.coupled.draws_kernel import Supply

Whole = npt.NDArray[np.int64]

UNIT_BITS, LARGEST_BITS = 28, 40
_PART = 1 << 16  # contacts that begin together: their arrays stay small


class Draws:
    """All draws of some contacts' replicas.

    contacts : Contacts; n : contacts in a replica; key : of origins.streams.key_of.
    unit : length of which all positions and thresholds are whole numbers: 2^-28 mean thresholds,
    unless 2^40 of these are less than the largest threshold.
    """

    def __init__(self, contacts: Contacts, n: int, key: tuple[int, int]) -> None:
        self.contacts, self.n = contacts, n
        self._start = Beginning(contacts, n, key)
        table = self._start.table
        largest = max(float(table.upper(0.0)) * table.scale, *map(abs, contacts.start.span))
        finest = 2.0**-UNIT_BITS * contacts.mean_threshold
        self.unit = unit = max(finest, 2.0**-LARGEST_BITS * largest)
        self._start.compile(unit)
        law = contacts.reforming
        spread = law is not None and not law.law.is_single
        self._again = kernel_table(reforming_table(contacts), unit) if spread else None

    def begin(self, replica: int) -> Iterator[tuple[Whole, Whole]]:
        """Starting stretches and thresholds of a replica, in whole units, part by part."""
        first = replica * self.n
        for done in range(first, first + self.n, _PART):
            part = range(done, min(done + _PART, first + self.n))
            births, thresholds = self._start.draw(part)
            yield -births, np.clip(thresholds, 1, (2 << LARGEST_BITS) - 1)

    def thresholds(self, replica: int) -> Supply:
        """Fresh thresholds of a replica."""
        return self._supply(self._start.compiled, replica, THRESHOLDS, THRESHOLD_TAILS)

    def stretches(self, replica: int) -> Supply:
        """Stretches at which contacts of a replica form again; those of one value are never drawn."""
        table = self._start.compiled if self._again is None else self._again
        supply = self._supply(table, replica, LIVES, LIFE_TAILS)
        if self._again is None:
            law = self.contacts.reforming
            value = 0.0 if law is None else law.law.mean()
            supply.ready[:] = round(value / self.unit)
        return supply

    def _supply(self, table: tuple[Any, ...], replica: int, purpose: int, tails: int) -> Supply:
        from eq_model.coupled.draws_kernel import make_supply

        second, tail = ((use << PURPOSE_SHIFT) | replica for use in (purpose, tails))
        return make_supply(table, self._start.words, second, tail)
