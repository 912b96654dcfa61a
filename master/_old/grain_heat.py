"""Breaks at a temperature and a steady speed of contacts whose thresholds grow with age, from any start.

From each stretch a passage (master.grain_passage) tells what holds; of a start with a width a few do, as for contacts
that age. Where thresholds are met again only after a stretch has turned, or after they have grown for a while, passages
are read at travels that are the same part of the way there.
"""

import numpy as np
import numpy.typing as npt

from master._old.ageing_breaking import AgeingBreaking, Side
from master._old.first_passage import FirstPassage
from master._old.grain_breaking import GrainBreaking
from master._old.grain_passage import warmed
from master._old.piecewise import tabulate
from origins import Contacts
from origins.start import Start

Array = npt.NDArray[np.float64]

_TINY = 1e-300


class GrainHeat(AgeingBreaking):
    """p and E of contacts with `grains` and `thermal` at the speed v > 0 (length per time), of those at X = 0."""

    def __init__(self, contacts: Contacts, velocity: float, accuracy: float, start: Start | None = None) -> None:
        start = contacts.start if start is None else start
        self._cold = GrainBreaking(contacts, velocity, start)
        super().__init__(contacts, velocity, accuracy, start)
        self.marks = self._cold.marks

    def passage(self, origin: float) -> FirstPassage:
        """What a first passage is to thresholds that diffuse."""
        return warmed(self._contacts, self._velocity, origin, self.accuracy)

    def bends(self, travel: Array) -> Array:
        """As thermal_law.ThermalBreaking has it: those that begin to meet their thresholds too."""
        return np.concatenate([super().bends(travel), self._cold.bends(travel)], axis=1)

    def _ends(self, start: Start) -> list[float]:
        low, high = start.span
        return [low, *(end for end in (0.0, self._cold.overtaken) if low < end < high), high]

    def side(self, start: Start, low: float, high: float) -> Side:
        returns = high <= 0.0 or low >= self._cold.overtaken
        return Returning(self, start, low, high, self._cold) if returns else Side(self, start, low, high)


class Returning(Side):
    """A part of the start from where contacts come back to their thresholds: where one does all do."""

    def __init__(
        self, breaking: GrainHeat, start: Start, low: float, high: float, cold: GrainBreaking
    ) -> None:
        (self._returns,) = tabulate(lambda x: cold.begins(x.ravel()).reshape(1, *x.shape), np.array([low, high]), 1e-13)
        super().__init__(breaking, start, low, high)

    def each(self, travel: Array, origin: Array) -> list[tuple[Array, Array]]:
        way, back = np.maximum(-origin, 0.0), np.maximum(self._returns(origin), _TINY)
        legs = np.stack([way, back - way])
        out = []
        for stretch, passage in zip(self.stretches, self.passages, strict=True):
            own_way, own_back = max(-float(stretch), 0.0), float(self._returns(np.array([stretch]))[0])
            own = np.array([own_way, own_back - own_way])[:, None]
            scale = np.divide(own, legs, out=np.ones(legs.shape), where=legs > 0.0)
            first, later = np.minimum(travel, way), np.clip(travel - way, 0.0, legs[1])
            at = first * scale[0] + later * scale[1] + np.maximum(travel - back, 0.0)
            rise = np.where(travel < way, scale[0], np.where(travel < back, scale[1], 1.0))
            out.append((passage.law.pdf(at) * rise, passage.law.sf(at)))
        return out
