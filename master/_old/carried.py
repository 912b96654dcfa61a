"""All contacts of a slider on the way: where they stand, what a move would lead to, and the move taken.

How many break and are born in a move follows from the number of all contacts, as in master.marching.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from master._old.lives import Lives
from master._old.marching import Memory, unknown
from master._old.track import TooLong

_BESIDE = 1e-4  # of the length over which births change: a little further on


@dataclass
class Trial:
    """What a step would lead to."""

    lives: Lives
    force: float
    holding: float
    breaks: float
    births: float


class Carried:
    """Contacts whose lives are `lives` at X = 0, t = 0, and form again a `delay` after they break.

    length : over which births change (a length)
    most : steps, and numbers looked at in all of them, that are taken on; TooLong says how far they came
    """

    def __init__(self, lives: Lives, delay: float, length: float, most: tuple[float, float]) -> None:
        self._delay, self._length, self._most = delay, length, most
        self.steps, self.work, self.unresolved = 0, 0.0, 0.0
        self._place, self._now = 0.0, 0.0
        self._settle(lives)

    def _settle(self, lives: Lives) -> None:
        """These contacts, and nothing before them."""
        self._lives = lives
        lives.born()
        self._clocks, self._breaks, self._births, self._even = [self._now], [0.0], [0.0], [0.0]
        self._firsts, self._last = [0], (0.0, 0.0)
        self._pending: list[tuple[float, float]] = []
        self._force, self._holding = float(lives.pull[0]), float(lives.held[0])

    def _try(self, travel: float, now: float, frozen: bool = False) -> Trial:
        """The slider moves on by `travel` until `now`; where `frozen` none is born."""
        lives = self._lives.copy()
        lives.advance(travel, now - self._now, self._bent(travel, now - self._now))
        lives.born()
        held, pull = lives.spread()
        even = np.array(self._even[1:])
        k = even.size
        known = float(lives.held[0] + held[:k] @ even)
        last, before = float(held[k]), self._births[-1]
        slope, rest = (0.0, before) if frozen or (self._delay and now == self._now) else self._remembered(now)
        breaks = (1.0 - known + last * before + (1.0 - last) * rest) / (1.0 - (1.0 - last) * slope)
        births = slope * breaks + rest
        force = float(lives.pull[0] + pull[:k] @ even + pull[k] * (births - before))
        return Trial(lives, force, known + last * (births - before), breaks, births)

    def _bent(self, travel: float, duration: float) -> float:
        """How dt/dX changes over a step, from what it was in the last."""
        before, last = self._last
        if before == 0.0 or travel * before <= 0.0 or duration <= 0.0:
            return 0.0
        change = (duration / travel - last / before) / (travel + before)
        return float(np.clip(change * travel * travel / duration, -1.0, 1.0))

    def _remembered(self, now: float) -> tuple[float, float]:
        if not self._delay:
            return 1.0, 0.0
        clocks = np.array([*self._clocks, now])
        memory = Memory(clocks, np.array([*self._firsts, clocks.size - 1]), self._delay)
        return memory.births(clocks.size - 1, np.array([*self._breaks, 0.0]))

    def _take(self, trial: Trial, travel: float, now: float) -> None:
        self.steps += 1
        # of the dead nothing is asked
        self.work += np.count_nonzero(trial.lives.held) * trial.lives.work
        if self.steps > self._most[0] or self.work > self._most[1]:
            raise TooLong(f"{self.steps - 1} steps led to a time of {self._now:.4g} only, and more are not taken on")
        self._last = travel, now - self._now
        self._even.append(trial.births - self._births[-1])
        self._lives, self._force, self._holding = trial.lives, trial.force, trial.holding
        self._place += travel
        self._now = now
        self._clocks.append(now)
        self._breaks.append(trial.breaks)
        self._births.append(trial.births)
        self.unresolved = max(self.unresolved, unknown(trial.lives, np.array(self._even[1:])))

    def _born_at_once(self, weight: float, breaks: float) -> None:
        """A finite share is born where the slider stands: two births with nothing between."""
        self._bend()
        self._lives.born()
        held, pull = self._lives.spread()
        self._even.append(weight)
        self._force += float(pull[-1]) * weight
        self._holding += float(held[-1]) * weight
        self._clocks.append(self._now)
        self._births.append(self._births[-1] + weight)
        self._breaks.append(breaks)
        self._bend()

    def _bend(self) -> None:
        """Breaks may bend or jump here: nothing is read across."""
        self._firsts.append(len(self._clocks) - 1)
        self._last = 0.0, 0.0

    def _mark_later(self, at: float, weight: float = 0.0) -> None:
        """What bends or jumps here does so again after the delay."""
        if self._delay:
            self._pending += [(at + self._delay, weight), (at + 2.0 * self._delay, 0.0)]

    def _force_slope(self, sign: float, trial: Trial | None = None) -> float:
        """F'(X) in motion that takes no time, here or where a trial ends."""
        ahead = self if trial is None else self._after(trial)
        step = sign * _BESIDE * self._length
        first, second = (ahead._try(k * step, ahead._now).force for k in (1, 2))
        return (2.0 * first - 0.5 * second - 1.5 * ahead._force) / step

    def _after(self, trial: Trial) -> Carried:
        out = Carried.__new__(Carried)
        out.__dict__.update(self.__dict__)
        out._lives, out._force = trial.lives, trial.force
        out._even = [*self._even, trial.births - self._births[-1]]
        out._births, out._breaks = [*self._births, trial.births], [*self._breaks, trial.breaks]
        out._clocks = [*self._clocks, self._now]
        return out
