"""Coupled contacts in plain Python: slow, and simple enough to be read. Arrays of floats, a break at a time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from eq_model.coupled.ensemble import unit_of
from eq_model.draws.births import births_of
from eq_model.draws.streams import make_stream
from eq_model.draws.supply import make_supply, take
from eq_model.result import SIZES
from origins import Contacts, Drive


@njit
def _draw(supply):  # type: ignore[no-untyped-def]
    return take(supply)


class Followed(NamedTuple):
    """What a replica did: fields of eq_model.CoupledResult, and its slips as a table."""

    position: np.ndarray
    force: np.ndarray
    holding: np.ndarray
    slips: np.ndarray
    avalanches: np.ndarray
    breaks: int


class PlainReplica:
    """One replica with the draws that `eq_model.simulate` makes.

    Lengths are the user's; force is a sum over the contacts, k_i in <k>. A contact that holds has a
    stretch of X less `zero`, and breaks at X = `zero` + threshold; `back` is when a broken one forms
    again.
    """

    def __init__(
        self,
        contacts: Contacts,
        drive: Drive,
        n: int,
        seed: int,
        slip_fraction: float,
        replica: int,
    ) -> None:
        """n contacts at X = 0, drawn as those of the replica of this number."""
        assert drive.spring is not None
        self.unit, stream = unit_of(contacts), make_stream(seed, replica)
        self.draws = [make_supply(births, stream) for births in births_of(contacts, self.unit)]
        self.contacts, self.drive, self.n, self.slip_fraction = contacts, drive, n, slip_fraction
        self.spring, self.x, self.breaks = drive.spring * n, 0.0, 0
        self.zero, self.threshold, self.k = np.zeros((3, 0))
        self.returns = list[tuple[float, int]]()  # when, and how many
        self.form(n, start=True)

    def form(self, number: int, start: bool = False) -> None:
        """So many contacts form at X."""
        drawn = [_draw(self.draws[0 if start else 1]) for _ in range(number)]
        threshold, stretch = self.unit * np.array(drawn, float).reshape(-1, 2).T
        self.threshold = np.append(self.threshold, threshold)
        self.zero = np.append(self.zero, self.x - stretch)
        self.k = np.append(self.k, self.contacts.relative_stiffness(threshold))

    def load(self, x: float) -> float:
        """F + K X if the slider moves to x and nothing breaks."""
        return self.k @ (x - self.zero) + self.spring * x

    def balance(self, level: float) -> float:
        """X where F + K X = level, if nothing breaks."""
        return (level + self.k @ self.zero) / (self.spring + self.k.sum())

    def next_break(self) -> float:
        """X where the next contact breaks."""
        return float(min(self.zero + self.threshold, default=np.inf))

    def shake(self, level: float) -> int:
        """The avalanche at K X_T = level, which begins with the next break: how many contacts broke, and formed again
        if the rule says so. A reset draws all anew."""
        drive, broken = self.drive, 0
        at_once = drive.slip == "instant" and self.contacts.delay is None
        while not broken or self.load(self.next_break()) <= level:
            first = int(np.argmin(self.zero + self.threshold))
            self.x = self.next_break()
            for name in ("zero", "threshold", "k"):
                setattr(self, name, np.delete(getattr(self, name), first))
            self.breaks, broken = self.breaks + 1, broken + 1
            self.form(int(at_once))
            if drive.slip == "reset" and broken >= self.slip_fraction * self.n:
                self.x, self.returns = level / self.spring, []
                self.zero, self.threshold, self.k = np.zeros((3, 0))
                self.form(self.n)
                return broken
        self.x = self.balance(level)
        if self.contacts.delay is not None:
            now = np.interp(level / self.spring, self.places, self.clock)
            self.returns.append((now + self.contacts.delay.time, broken))
        elif not at_once:
            self.form(broken)
        return broken

    def follow(self) -> Followed:
        """To the end of the path, whose first point is at or beyond where the drive balances the start."""
        drive, spring, told = self.drive, self.spring, list[tuple[float, float, float]]()
        level = self.load(self.x)
        self.places = np.append(level / spring, drive.path)
        way = np.cumsum(np.diff(self.places)) / drive.velocity
        self.clock = np.append(0.0, way if drive.time is None else drive.time)
        slips, avalanches = list[list[float]](), np.zeros(SIZES, np.int64)
        for time, point in zip(self.clock[1:], spring * drive.path, strict=True):
            while True:
                # what comes first: a break, a return, or the point
                first = self.load(self.next_break()) if self.k.size else np.inf
                due = self.returns[0][0] if self.returns else np.inf
                back = spring * np.interp(due, self.clock, self.places)
                back = back if due <= self.clock[-1] else np.inf
                if (point, time) < min((first, -np.inf), (back, due)):
                    break
                if back < first:
                    self.x = self.balance(back)
                    self.form(self.returns.pop(0)[1])
                    continue
                level, before = max(level, first), self.next_break()
                broken = self.shake(level)
                if broken < self.slip_fraction * self.n:
                    avalanches[broken.bit_length() - 1] += 1
                    continue
                x = self.x if drive.slip != "instant" else self.balance(level)
                forces = (level - spring * np.array([before, x])) / self.n
                slips.append([level / spring, before, x, *forces, broken])
            x = self.balance(point)
            told.append((x, (point - spring * x) / self.n, self.k.size / self.n))
        position, force, holding = np.array(told).T
        table = np.reshape(slips, (-1, 6))
        return Followed(position, force, holding, table, avalanches, self.breaks)
