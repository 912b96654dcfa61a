"""Contacts whose thresholds age, each by itself, on any motion of the slider (paper, Sec. V).

What is left of contacts born together at a moment depends on how the slider moved since; here it is
followed in time, by strands: each carries the density of the thresholds above its stretch
(master.lives.age.cells). Every strand is followed with two resolutions, whose errors differ by a
factor of eight; what they tell is extrapolated, and what it was off by is measured.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from master.lives.age.strands import TRAVEL_STEP, Mesh, Strands
from master.lives.stretch_rule import StretchRule, StretchRules
from master.motion.motion import Motion
from origins import Contacts
from origins.start import SingleStart, Start

Array = npt.NDArray[np.float64]

RELAXED = SingleStart(0.0)
# Of what a finer resolution changes, what it leaves at most: errors fall by more with each.
FELL = 0.5
# The largest difference of all moments, in units of that of those looked at.
MARGIN = 2.0
# Part of the error that a finer resolution has to take away for a still finer one to be tried.
HARDLY = 0.7
# What rounding leaves, of the share that holds.
ROUND_OFF = 1e-13
# The finest resolution that is tried; births that are followed for it, points of each leg at which
# they are looked at at least, and what holds of them once they are let go.
FINEST, TRIALS, LOOKS, FAINT = 6, 4, 12, 1e-9
# Parts of the time to the first look after a birth at which it is looked at, too.
EARLY = np.array([0.01, 0.1])


class AgeingLife:
    """What contacts with `ageing`, closure "exact", are left of; any final law, also with heat.

    Parameters
    ----------
    contacts : Contacts
    motion : Motion
        X(t), of which resolutions are tried.
    accuracy : float
        Error of the share that holds that is aimed at; below 1e-9 it takes very long.

    Attributes
    ----------
    reach, quiet, bends
        As Life has them; thresholds that diffuse bend no survival.
    mesh : Mesh
        Cells and steps that suffice.
    """

    bends: Array = np.empty(0)
    bend_sizes: Array = np.empty(0)
    quiet = 0.0

    def __init__(self, contacts: Contacts, motion: Motion, accuracy: float = 1e-7) -> None:
        ageing = contacts.ageing
        assert ageing is not None and ageing.closure == "exact"
        self.contacts, self.motion = contacts, motion
        self.fastest = float(np.abs(motion.speeds).max())
        self.reach = max(float(law.isf(1e-17)) for law in (contacts.thresholds, ageing.final))
        self._rules = StretchRules(contacts.thresholds.support()[1], accuracy, self._shares)
        self.mesh = Mesh(contacts, 1, self.fastest)
        before = self._trial()
        # of two resolutions, before what they tell is extrapolated
        self._missed = MARGIN * self._differed
        while self._missed > accuracy and self.mesh.resolution < FINEST:
            if not self.mesh.cells[1].can_be_finer:
                break
            self.mesh = Mesh(contacts, self.mesh.resolution + 1, self.fastest)
            now = self._trial()
            last, missed = self._missed, FELL * float(np.abs(now - before).max())
            self._missed, before = min(missed, MARGIN * self._differed), now
            if self._missed > HARDLY * last:
                break

    @property
    def error(self) -> float:
        """Of the share that holds: measured on contacts of the start and on some births."""
        return self._missed + self._rules.error + ROUND_OFF

    def begin(self, born: Start, count: int = 1) -> Strands:
        """`count` strands of contacts that are born now at stretches of the law `born`."""
        rule = self._rules.of(born)
        stretch = np.tile(rule.stretch, count)
        return Strands(self.mesh, stretch, np.tile(rule.weight, (count, 1)))

    def _shares(self, rule: StretchRule) -> Array:
        """What holds, along the motion, of contacts born at its beginning at the rule's stretches;
        told with few cells, whose errors hardly depend on the rule."""
        mesh = Mesh(self.contacts, 1, self.fastest)
        return self._followed(Strands(mesh, rule.stretch, rule.weight[None]), 0)

    def _trial(self) -> Array:
        """What holds, all along the motion, of the contacts of the start and of some births."""
        legs = self.motion.speeds.size
        births = np.linspace(0, legs - 1, min(TRIALS, legs)).astype(int)
        self._differed = 0.0
        parts = [self._followed(self.begin(self.contacts.start), 0)]
        parts += [self._followed(self.begin(RELAXED), int(first)) for first in births]
        return np.concatenate(parts)

    def _followed(self, strand: Strands, first: int) -> Array:
        """What holds of a strand born as the leg `first` begins, at moments of all legs from it."""
        motion, shares, held = self.motion, [], 1.0
        length = TRAVEL_STEP * self.mesh.width
        for leg in range(first, motion.speeds.size):
            duration, speed = motion.times[leg + 1] - motion.times[leg], motion.speeds[leg]
            looks = LOOKS + int(abs(speed) * duration / length)
            ends = np.linspace(0.0, duration, looks + 1)
            if leg == first:
                ends = np.insert(ends, 1, ends[1] * EARLY)
            for time in np.diff(ends):
                if held > FAINT:
                    strand.advance(speed, time)
                    held = float(strand.left()[0, 0])
                shares.append(held)
        self._differed = max(self._differed, strand.error)
        return np.array(shares)
