"""The Life of contacts that age on a slider that turns round, rests or changes its speed.

Contacts that have moved straight since their birth are treated as in master.lives.age.ageing; those
of the start, and births of earlier legs, are strands that follow the slider leg by leg.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.interpolate import BSpline, make_interp_spline

from master.lives.age.ageing import DEGREE, AgeingLife
from master.lives.age.strands import Strands, together
from master.motion.motion import History
from origins.start import Start

Array = npt.NDArray[np.float64]


class Followed(NamedTuple):
    """Strands along a leg: times since its beginning, shape (n,), and the share that holds and the
    force of each strand, shape (n, 2, strands)."""

    times: Array
    left: Array

    def over_root(self, values: Array) -> BSpline:
        """Values at the times, shape (n, ...), as a spline over the root of the time on the leg."""
        return make_interp_spline(np.sqrt(self.times), values, k=min(DEGREE, self.times.size - 1))


class AgeingPath(AgeingLife):
    """Life (see master.lives.life) of contacts that age, closure "exact", on any motion.

    `left` is for contacts that moved straight since their birth, and for those of the start;
    master.renewal.strand_births follows births of earlier legs.
    """

    _start: Strands | None = None

    def left(self, born: Start | Array, history: History) -> Array:
        """See Life."""
        legs = history.legs()
        lived = (legs.duration.reshape(-1, legs.speed.size).max(axis=0) > 0.0).sum()
        # strands of all stretches of a start follow the slider together
        all_at_once = born is self.contacts.start and not self.contacts.start.is_single
        if lived <= 1 and not all_at_once:
            return super().left(born, history)
        last = history.motion.leg_of_all(history.t)
        t = history.t - history.motion.times[last]
        return self._of_start(last, np.broadcast_to(t, legs.duration.shape[:-1]))

    def _of_start(self, leg: int, t: Array) -> Array:
        """Share and force of the contacts of the start, at times since the beginning of a leg."""
        if self._start is None:
            self._start = self.begin(self.contacts.start)
            self._started: list[BSpline] = []
        while len(self._started) <= leg:
            found = self.follow(self._start, len(self._started))
            self._started.append(found.over_root(found.left[..., 0]))
        spline = self._started[leg]
        found = spline(np.sqrt(np.clip(t, 0.0, float(spline.t[-1]) ** 2)))
        return np.moveaxis(found, -1, 0)

    def aged(self, born: Start, speed: float, ages: Array) -> Strands:
        """Strands of contacts that have moved straight on since their births, `ages` (n,) ago.

        At one speed one strand gives all of them, at different times.
        """
        order, strand = np.argsort(ages), self.begin(born)
        found, age = [], 0.0
        for later in ages[order]:
            strand.advance(speed, later - age)
            found.append(strand.take(np.zeros(1, dtype=np.intp)))
            age = later
        return together(found).take(np.argsort(order))

    def follow(self, strands: Strands, leg: int) -> Followed:
        """Move strands along a leg; returns their shares and forces on the way."""
        speed = float(self.motion.speeds[leg])
        duration = float(np.diff(self.motion.times)[leg])
        times, told = strands.steps_of(speed, duration), [strands.left()]
        for time in np.diff(times):
            strands.advance(speed, time)
            told.append(strands.left())
        return Followed(times, np.array(told))
