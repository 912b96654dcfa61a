"""Contacts that break by heat: of some laws one number tells all that a strand has spent.

A contact of the threshold x_s that was born at r still holds with the probability e^-A, A the
integral of its rate h(|x|; x_s) over time, if x_s is above the largest |x| of its life.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from master.lives.cold import TIE
from master.lives.heat.above import Above
from master.lives.heat.mean_rate import MeanRateLife
from master.lives.heat.replay import Replay
from master.lives.heat.replayed import rates_of
from master.lives.heat.threshold_panels import Stiffness
from master.motion.motion import Legs
from master.soft.in_time.memory import Leg, Memory, Scales, width_of
from origins import Contacts
from origins.laws.rate_law import RateLaw

Array = npt.NDArray[np.float64]

# Share of contacts to which sums over thresholds are known.
SUMS = 1e-12
# The logarithm of a share that is none.
NONE_LEFT = -745.0


class ProportionalMemory(Memory):
    """Exact closure, where ln h is a sum of a function of x and one of the threshold (soft contacts).

    A at one threshold tells it at all others: ln A = ln W + ln h(0; x_s), and ln W is kept.
    """

    width, error = 1, SUMS

    def __init__(self, contacts: Contacts) -> None:
        law, self._rates = contacts.thresholds, rates_of(contacts)
        self._above = Above(law, self._rates, None)
        self._atoms = list(zip(*law.atoms, strict=True))
        self.reach = reach_of(contacts)
        self.scales = scales_of(contacts)

    def start(self, stretch: Array) -> Array:
        """See Memory."""
        return np.full((stretch.size, 1), -np.inf)

    def advance(self, kept: Array, leg: Leg) -> Array:
        """See Memory."""
        if not leg.duration:
            return kept
        replay = replay_of(leg, self._rates)
        every, least = np.arange(leg.end.size), np.maximum(replay.least, 1e-300)
        spent = replay.log_spent(every, least[:, None])[:, 0]
        return np.logaddexp(kept[:, 0], spent - self._rates.log_rate(0.0, least, 1.0))[:, None]

    def left(self, kept: Array, stretch: Array, furthest: Array) -> Array:
        """See Memory."""
        least = np.maximum(furthest, 1e-300)
        spent = kept[:, 0] + self._rates.log_rate(0.0, least, 1.0)
        known = Replay.known(self._rates, furthest, np.maximum(spent, NONE_LEFT))
        held = self._above.sums(known, np.ones(furthest.size))[0]
        for position, weight in self._atoms:
            level = kept[:, 0] + self._rates.log_rate(0.0, position, 1.0)
            held += weight * (furthest < position * (1.0 - TIE)) * _kept(level)
        return np.stack([held, stretch * held])


class MeanRateMemory(Memory):
    """The paper's closure: all break at the mean rate, and thresholds tell where |x| grows.

    Kept are the logarithm of what is left, and |x| at birth. Of what a contact has survived nothing
    is remembered: one that goes out again may break at all that it has passed before (App. C).
    """

    width = 2

    def __init__(self, contacts: Contacts) -> None:
        life = MeanRateLife(contacts)
        self._table, self._law, self.reach = life.table, contacts.thresholds, life.reach
        self.error = life.error + SUMS
        self.scales = scales_of(contacts)

    def start(self, stretch: Array) -> Array:
        """See Memory."""
        return np.stack([np.zeros(stretch.size), np.abs(stretch)], axis=1)

    def advance(self, kept: Array, leg: Leg) -> Array:
        """See Memory."""
        first, last, born = np.abs(leg.begin), np.abs(leg.end), kept[:, 1]
        across = (leg.begin < 0.0) != (leg.end < 0.0)
        near = np.maximum(np.where(across, 0.0, first), born)
        far = np.where(across | (last > first), np.maximum(last, born), near)
        log_share = kept[:, 0] + np.minimum(self._log_survival(far) - self._log_survival(near), 0.0)
        if leg.duration:
            way = np.abs(leg.end - leg.begin)
            mean = self._table.mean(leg.begin, leg.end)
            moved = (way > 1e-3 * (first + last)) | across
            grown = np.abs(self._table.grown(leg.end) - self._table.grown(leg.begin))
            mean = np.where(moved, grown / np.where(moved, way, 1.0), mean)
            log_share = log_share - mean * leg.duration
        return np.stack([np.maximum(log_share, NONE_LEFT), born], axis=1)

    def left(self, kept: Array, stretch: Array, furthest: Array) -> Array:
        """See Memory."""
        held = np.where(kept[:, 0] > NONE_LEFT, np.exp(kept[:, 0]), 0.0)
        return np.stack([held, stretch * held])

    def _log_survival(self, x: Array) -> Array:
        return np.maximum(self._law.logsf(x * (1.0 + TIE)), 2.0 * NONE_LEFT)


def replay_of(leg: Leg, rates: RateLaw, stiffness: Stiffness | None = None) -> Replay:
    """What contacts spend on one leg, which takes time."""
    way = leg.end - leg.begin
    speed = float(way[0]) / leg.duration
    duration = np.full((way.size, 1), leg.duration)
    legs = Legs(np.stack([np.zeros(way.size), way], axis=-1), duration, np.array([speed]))
    return Replay(rates, stiffness, leg.begin, legs)


def scales_of(contacts: Contacts) -> Scales:
    """What steps resolve of contacts that break by heat."""
    thermal, law = contacts.thermal, contacts.thresholds
    assert thermal is not None
    rates, unit = thermal.rates, contacts.mean_threshold
    rank = (np.arange(200) + 0.5) / 200.0
    fresh = np.maximum(np.asarray(law.ppf(rank)), 1e-12 * unit)
    each = rates.rate(0.0, fresh, contacts.relative_stiffness(fresh))
    # the weakest three in ten of the fresh contacts do not count in the rate that steps resolve:
    # they are gone soon, and others feel little of it
    weakest = np.maximum(np.array([float(law.ppf(0.3))]), 1e-12 * unit)
    most = float(rates.rate(0.0, weakest, contacts.relative_stiffness(weakest))[0])
    if thermal.closure == "paper":
        most = np.inf
    width, mean = width_of(contacts), np.array([unit])
    # stretch below the threshold over which ln h changes by 1
    below = unit * (1.0 - np.array([0.1, 0.11]))
    rise = -float(np.diff(rates.log_rate(below, mean, 1.0))[0]) / (0.01 * unit)
    # widths of P_c over which the rate changes by less than a factor e are a thin skin
    skin = 1.0 / rise if rise * width * 0.005 > 1.0 else 0.0
    return Scales(width, 1.0 / rates.scale, min(float(each.mean()), most), skin=skin)


def reach_of(contacts: Contacts) -> float:
    """Stretch beyond which none holds."""
    law = contacts.thresholds
    return max([min(float(law.support()[1]), float(law.isf(1e-18))), *law.atoms[0]])


def _kept(log_spent: Array) -> Array:
    """e^-A from ln A."""
    return np.exp(-np.exp(np.minimum(log_spent, 7.0)))
