"""Contacts that age on a slider that turns round, rests or changes its speed: a Life with a memory.

Contacts that have moved straight since their birth are told by ForwardAgeing, one for each speed;
those of the start, and births of earlier legs, by strands that follow the slider leg by leg.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.interpolate import BSpline, make_interp_spline

from master.lives.age.ageing import AgeingLife
from master.lives.age.forward import GRAIN, ForwardAgeing
from master.lives.age.strands import Strands, together
from master.lives.life import UnbentLife
from master.motion.motion import History, Motion
from origins import Contacts
from origins.start import Start

Array = npt.NDArray[np.float64]


class Followed(NamedTuple):
    """What is left of strands along a leg: times since its beginning, shape (n,), and share and
    force of each strand, shape (n, 2, strands)."""

    times: Array
    left: Array


class AgeingPath(AgeingLife, UnbentLife):
    """Life (see master.lives.life) of contacts that age, closure "exact", on any motion.

    `left` tells of contacts that moved straight since their birth, and of those of the start; births
    of earlier legs are followed by master.renewal.strand_births.
    """

    bends: Array = np.empty(0)

    def __init__(self, contacts: Contacts, motion: Motion, accuracy: float = 1e-7) -> None:
        super().__init__(contacts, motion, accuracy)
        self._accuracy, self.grain = accuracy, GRAIN * self.mesh.width
        self._straight: dict[float, ForwardAgeing] = {}
        self._start: Strands | None = None
        self._started: list[BSpline] = []

    @property
    def error(self) -> float:
        """Of the share that holds."""
        return max([super().error, *(life.error for life in self._straight.values())])

    def left(self, born: Start | Array, history: History) -> Array:
        """See Life."""
        assert isinstance(born, Start)
        legs = history.legs()
        lived = legs.duration.reshape(-1, legs.speed.size).max(axis=0) > 0.0
        if lived.sum() > 1:
            last = history.motion.leg(0.5 * (float(history.t.min()) + float(history.t.max())))
            t = history.t - history.motion.times[last]
            return self._of_start(int(last), np.broadcast_to(t, legs.duration.shape[:-1]))
        leg = int(np.argmax(lived)) if lived.any() else legs.speed.size - 1
        return self._straight_at(float(legs.speed[leg])).left(born, history)

    def _straight_at(self, speed: float) -> ForwardAgeing:
        """Contacts that have kept this speed since their birth."""
        if speed not in self._straight:
            lasts = np.diff(self.motion.times)[self.motion.speeds == speed]
            longest = float(lasts.max(initial=np.diff(self.motion.times).min()))
            given = self.contacts, speed, self._accuracy, longest, self
            self._straight[speed] = ForwardAgeing(*given)
        return self._straight[speed]

    def _of_start(self, leg: int, t: Array) -> Array:
        """Share and force of the contacts of the start, at times since the beginning of a leg."""
        if self._start is None:
            self._start = self.begin(self.contacts.start)
        while len(self._started) <= leg:
            found = self.follow(self._start, len(self._started))
            degree = min(5, found.times.size - 1)
            root = np.sqrt(found.times)
            self._started.append(make_interp_spline(root, found.left[..., 0], k=degree))
        spline = self._started[leg]
        found = spline(np.sqrt(np.clip(t, 0.0, float(spline.t[-1]) ** 2)))
        return np.moveaxis(found, -1, 0)

    def aged(self, born: Start, speed: float, ages: Array) -> Strands:
        """Strands of contacts that have moved straight on since their births, `ages` (n,) ago.

        At one speed it is one strand, looked at again and again.
        """
        order, strand = np.argsort(ages), self.begin(born)
        found, age = [], 0.0
        for later in ages[order]:
            strand.advance(speed, later - age)
            found.append(strand.take(np.zeros(1, dtype=np.intp)))
            age = later
        return together(found).take(np.argsort(order))

    def follow(self, strands: Strands, leg: int) -> Followed:
        """Move strands along a leg, and tell what is left of them on the way."""
        speed = float(self.motion.speeds[leg])
        duration = float(np.diff(self.motion.times)[leg])
        times, told = strands.steps_of(speed, duration), [strands.left()]
        for time in np.diff(times):
            strands.advance(speed, time)
            told.append(strands.left())
        return Followed(times, np.array(told))
