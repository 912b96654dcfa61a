"""Groups of contacts that began or were born together at one stretch."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.numerics.averages import StretchNodes
from master.soft.in_time.memory import Memory
from master.soft.in_time.threshold_cells import Leg
from origins.thresholds.law import Array


class Groups(NamedTuple):
    """Contacts that began or were born together at one stretch; arrays of shape (n,), (n, width).

    stretch, largest : x and the largest |x| so far (lengths)
    weight : fraction of all contacts, divided by the survival at birth, by which a Memory multiplies their survival
    record : their history, see Memory
    """

    stretch: Array
    largest: Array
    weight: Array
    record: Array

    def moved(self, memory: Memory, travel: float, duration: float) -> "Groups":
        """These after the slider has moved by `travel` at one speed; those that broke still have their weight."""
        stretch = self.stretch + travel
        largest = np.maximum(self.largest, np.abs(stretch))
        record = memory.advance(self.record, Leg(self.stretch, stretch, largest, duration))
        return Groups(stretch, largest, self.weight, record)

    def and_born(
        self, memory: Memory, born: StretchNodes, fraction: float, speed: float
    ) -> "Groups":
        """These, and as the last ones those of a new cohort, on a slider of this speed |dX/dt|."""
        x, record = born.stretch, memory.fresh(born.stretch, speed)
        new = Groups(x, np.abs(x), fraction * born.weight, record)
        return Groups(*(np.concatenate(both) for both in zip(self, new, strict=True)))

    def survival_and_force(self, memory: Memory) -> Array:
        """See Memory; shape (2, n)."""
        return memory.survival_and_force(self.record, self.stretch, self.largest)

    def pick(self, which: slice | npt.NDArray[np.bool_]) -> "Groups":
        """Some of them."""
        return Groups(*(part[which] for part in self))
