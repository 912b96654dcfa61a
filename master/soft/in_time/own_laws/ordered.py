"""Contacts whose thresholds change with age and distance and keep their order, under a spring.

Of contacts that were born together those are broken whose thresholds at birth are up to the largest that
birth_threshold(|x|, age, travelled) has been since, as in master.survival.ordered.
"""

import numpy as np

from master.motion import Motion
from master.soft.in_time.memory import Memory, cold_nodes
from master.soft.in_time.own_laws.along import refuse_without_life, scales_along
from master.soft.in_time.threshold_cells import StraightMove
from origins import Contacts, OrderedThresholds
from origins.thresholds.law import Array


class OrderedMemory(Memory):
    """Keeps the largest threshold at birth that was met, the age and the distance; steps end near where it is largest.

    motion : of the drive, None where it stands; the law is checked for as long, and as far
    """

    error = 1e-13

    def __init__(self, contacts: Contacts, halvings: int, motion: Motion | None) -> None:
        law = contacts.changing
        assert isinstance(law, OrderedThresholds)
        refuse_without_life(contacts)
        self._law, self.width, self.starts = law, 3, cold_nodes(halvings)
        self.largest_stretch = law.at_start.support()[1]
        self.scales = scales_along(contacts, motion)
        if motion is not None:
            ways = float(np.abs(np.diff(motion.positions)).sum())
            law.trend(float(motion.times[-1]), ways)  # refuses what contradicts itself

    def start(self, stretch: Array) -> Array:
        return np.stack([np.abs(stretch), *np.zeros((2, stretch.size))], axis=1)

    def advance(self, record: Array, leg: StraightMove) -> Array:
        """See Memory; what is met is looked at in the middle of the move and at its end."""
        met, age, way = record.T
        middle, moved = 0.5 * (leg.begin + leg.end), np.abs(leg.end - leg.begin)
        for x, part in ((middle, 0.5), (leg.end, 1.0)):
            with np.errstate(over="ignore"):  # inf where none holds
                now = age + part * leg.duration, way + part * moved
                met = np.maximum(met, self._law.birth_threshold(np.abs(x), *now))
        return np.stack([met, age + leg.duration, way + moved], axis=1)

    def survival_and_force(self, record: Array, stretch: Array, largest: Array) -> Array:
        unmet = np.asarray(self._law.at_start.sf(record[:, 0]))
        return np.stack([unmet, stretch * unmet])
