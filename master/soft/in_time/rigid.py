"""Rigid: the way of a slider whose place is given at each time, step by step."""

from __future__ import annotations

import numpy as np

from master.soft.in_time.carried import Allowed, Carried
from master.soft.in_time.cohorts import Cohorts
from master.soft.in_time.slipping import COARSEST, Slip, Task
from master.soft.in_time.track import Clock, Piece, Track


class Given:
    """The whole way of a rigid slider, on steps of 2^-level of the coarsest.

    Parameters and attributes as of master.soft.in_time.pulled.Pulled; there are no slips.
    """

    def __init__(
        self, cohorts: Cohorts, task: Task, level: int, plan: list[float], allowed: Allowed
    ) -> None:
        self._task, self._level = task, level
        self.contacts = Carried(cohorts, task.delay, allowed)
        self.tracks: list[Track] = []
        self.stretches: list[float] = []
        self.slips: list[Slip] = []

    def run(self) -> None:
        """Follow the path to its end."""
        here = self.contacts
        for piece in self._task.pieces:
            here.mark_later(piece.begin)
            marks = [at for at, _ in here.pending if piece.begin < at < piece.end]
            for end in [*sorted(set(marks)), piece.end]:
                self._to(end, piece)
            here.pending = [one for one in here.pending if one[0] > piece.end]

    def _to(self, end: float, piece: Piece) -> None:
        """Even steps, in a hold even in the logarithm of time, up to a time on a piece."""
        here, steps = self.contacts, self.contacts.cohorts.steps
        counted = Clock(piece, COARSEST * steps.length, steps.time, steps.rate / COARSEST)
        # a given way is the slider's own, and counts in full
        moved = abs(piece.at(end) - piece.at(here.now)) / (COARSEST * steps.length)
        begin, last = counted.count(here.now), counted.count(end)
        number = int(np.ceil(max(moved, last - begin, 1.0))) * 2**self._level
        track = Track()
        self.tracks.append(track)
        here.bend()
        self._write(track, 0.0)
        for k in range(1, number + 1):
            now = end if k == number else counted.time(begin + (last - begin) * k / number)
            here.take(here.tried(piece.at(now) - here.place, now))
            self._write(track, float(k))

    def _write(self, track: Track, step: float) -> None:
        here = self.contacts
        track.step.append(step)
        track.clock.append(here.now)
        track.place.append(here.place)
        track.force.append(here.force)
        track.holding.append(here.holding)
