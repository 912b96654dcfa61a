"""Contacts that break by heat, with laws for which a strand needs to keep one number only.

A contact of the threshold x_s still holds with the probability e^-A, A being the integral of its
rate h(|x|; x_s) over time, if x_s is above the largest |x| of its life.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from master.lives.cold import TIE
from master.lives.heat.above import Above
from master.lives.heat.mean_rate import MeanRateLife
from master.lives.heat.replay import Replay, Stiffness, rates_of
from master.motion.motion import Legs
from master.soft.in_time.memory import Leg, Memory, Scales, width_of
from origins import Contacts
from origins.laws.rate_law import RateLaw

Array = npt.NDArray[np.float64]

# Error of sums over thresholds, as a share of the contacts.
SUMS = 1e-12
# The logarithm of the smallest share above 0.
NONE_LEFT = -745.0


class ProportionalMemory(Memory):
    """Exact closure, where ln h is a sum of a function of x and one of the threshold (soft contacts).

    Then ln A = ln W + ln h(0; x_s) with one number W for all thresholds; ln W is kept.
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
            kept_share = np.exp(-np.exp(np.minimum(level, 7.0)))
            held += weight * (furthest < position * (1.0 - TIE)) * kept_share
        return np.stack([held, stretch * held])


class MeanRateMemory(Memory):
    """The paper's closure: all break at the mean rate H(x), and where |x| grows at their thresholds.

    Kept are the logarithm of the share that holds, and |x| at birth. A contact forgets the thresholds
    that it has survived: one that goes out again may break at all that it has passed before (App. C).
    """

    width = 2

    def __init__(self, contacts: Contacts) -> None:
        life = MeanRateLife(contacts)
        self._table, self._law, self.reach = life.table, contacts.thresholds, life.reach
        self.error = life.error + SUMS
        self.scales = scales_of(contacts)._replace(rate=float(self._table.rate(np.zeros(1))[0]))

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
    """The integrals A on one leg, whose duration is above 0."""
    way = leg.end - leg.begin
    speed = float(way[0]) / leg.duration
    duration = np.full((way.size, 1), leg.duration)
    legs = Legs(np.stack([np.zeros(way.size), way], axis=-1), duration, np.array([speed]))
    return Replay(rates, stiffness, leg.begin, legs)


def scales_of(contacts: Contacts) -> Scales:
    """The scales that steps resolve where contacts break by heat."""
    thermal, law = contacts.thermal, contacts.thresholds
    assert thermal is not None
    rates, unit = thermal.rates, contacts.mean_threshold
    # steps need not resolve the rate of the weakest 30 % of fresh contacts: these break soon, with
    # little effect on the others
    weak = np.maximum(np.array([float(law.ppf(0.3))]), 1e-12 * unit)
    fresh_rate = float(rates.rate(0.0, weak, contacts.relative_stiffness(weak))[0])
    width, mean = width_of(contacts), np.array([unit])
    # slope of ln h by the stretch, at 0.1 mean thresholds below the threshold
    below = unit * (1.0 - np.array([0.1, 0.11]))
    rise = -float(np.diff(rates.log_rate(below, mean, 1.0))[0]) / (0.01 * unit)
    # a thin skin: 0.005 widths of P_c over which the rate changes by more than a factor e
    return Scales(width, 1.0 / rates.scale, fresh_rate, rise * width > 200.0)


def reach_of(contacts: Contacts) -> float:
    """Stretch beyond which no contact holds."""
    law = contacts.thresholds
    return max([min(float(law.support()[1]), float(law.isf(1e-18))), *law.atoms[0]])
