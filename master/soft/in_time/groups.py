"""Groups of contacts that began or were born together at one stretch, and a trial step of all of them."""

from typing import NamedTuple

import numpy as np

from master.numerics.averages import StretchNodes
from master.soft.in_time.memory import Leg, Memory
from origins.thresholds.law import Array


class Groups(NamedTuple):
    """Contacts that began or were born together at one stretch; arrays of shape (n,), (n, width).

    stretch, largest : x and the largest |x| so far (lengths)
    weight : fraction of all contacts, divided by the survival at birth
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

    def pick(self, which: slice | Array) -> "Groups":
        """Some of them."""
        return Groups(*(part[which] for part in self))


class Trial(NamedTuple):
    """A step that is not taken yet: its travel (a length), its end in time, and the state it leads to.

    groups : with a new cohort that has no births yet; survival_and_force : what the memory says of them, shape (2, n)
    force, holding : see Cohorts; breaks, births : per contact since t = 0 or a reset
    """

    travel: float
    now: float
    groups: Groups
    survival_and_force: Array
    force: float
    holding: float
    breaks: float
    births: float


def per_survival(memory: Memory, nodes: StretchNodes) -> StretchNodes:
    """The nodes with weights divided by the survival at birth, 0 where none hold."""
    stretch = nodes.stretch
    survival = memory.survival_and_force(memory.start(stretch), stretch, np.abs(stretch))[0]
    weight = np.divide(nodes.weight, survival, out=np.zeros(survival.size), where=survival > 0.0)
    return StretchNodes(stretch, weight)
