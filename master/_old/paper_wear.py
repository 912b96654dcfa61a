"""Contacts at a temperature in the paper's closure: all break at one rate that depends on their stretch alone.

P_T = P + H/v with P = P_c/S (paper Eq. temper4): in forward motion P, and in backward motion P_b(x) = P(-x) (App. C),
act where |x| grows beyond the stretch at birth. Of what a contact has survived since nothing is remembered, so that
after a turn this is not what discrete contacts do.
"""

import numpy as np
import numpy.typing as npt

from master._old.cut_law import SLACK
from master._old.thermal_paper import PaperBreaking
from master._old.wear import Left, Standing
from origins import Contacts

Array = npt.NDArray[np.float64]

_LEAST = -745.0  # the logarithm of what is nothing


class PaperWear:
    """`worn` are the logarithm of what is left, times S(|r|), and |r|."""

    width, error, work = 2, 1e-13, 30
    forgets, slow, skin = True, 2.0, 0.0

    def __init__(self, contacts: Contacts, length: float) -> None:
        assert contacts.thermal is not None
        self._breaking = PaperBreaking(contacts, 1.0)
        self._law, self.length = contacts.thresholds, length
        self.time = 1.0 / contacts.thermal.attempt_frequency
        self.rate = float(self._breaking.hazard(np.zeros(1))[0])

    def fresh(self, stretch: Array) -> Array:
        return np.stack([self._logsf(np.abs(stretch)), np.abs(stretch)], axis=1)

    def advance(self, worn: Array, begin: Array, end: Array, furthest: Array, duration: float | Array) -> None:
        first, last = np.abs(begin), np.abs(end)
        out, born = worn.T
        across = (begin < 0.0) != (end < 0.0)
        near = np.maximum(np.where(across, 0.0, np.minimum(first, last)), born)
        far = np.where(across | (last > first), np.maximum(last, born), near)
        out += self._logsf(far) - self._logsf(near)
        way = np.abs(end - begin)
        moved = way > 1e-9 * (first + last)
        # what one way costs is known from x = 0 on
        spent, before = self._breaking.spent(last), self._breaking.spent(first)
        both = np.abs(np.where(across, spent + before, spent - before))
        mean = np.divide(both, way, out=np.zeros(way.size), where=moved)
        mean[~moved] = self._breaking.hazard(0.5 * (first + last)[~moved])
        out -= mean * duration
        np.copyto(out, _LEAST, where=~(out > _LEAST))

    def settle(self, worn: Array, stretch: Array, furthest: Array) -> None:
        pass

    def left(self, worn: Array, stretch: Array, furthest: Array) -> Left:
        held = np.where(worn[:, 0] > _LEAST, np.exp(worn[:, 0]), 0.0)
        none = np.zeros(held.size)
        return Left(held, held, none, none)

    def standing(self, stretch: float) -> Standing:
        at = np.array([abs(stretch)])
        share = np.exp(self._logsf(at))
        return Standing(self._breaking.hazard(at), share, share)

    def keeper(self) -> "PaperWear":
        return self

    def kept(self, stretch: float, spent: Array) -> Array:
        out = self.fresh(np.array([stretch]))[0]
        out[0] = max(out[0] - spent[0], _LEAST)
        return out

    def _logsf(self, x: Array) -> Array:
        # a contact whose stretch has reached its threshold is broken: survival past rounding of the sum
        return np.maximum(self._law.logsf(x * (1.0 + SLACK)), 2.0 * _LEAST)
