"""Coupled contacts in plain Python: slow, and simple enough to be read. Arrays of floats, a break at a time."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from eq_model.compiling import compiled
from eq_model.coupled.ensemble import unit_of
from eq_model.draws.births import births_of
from eq_model.draws.streams import make_stream
from eq_model.draws.supply import make_supply, take
from eq_model.result import SIZES
from origins import Contacts, Drive


@compiled
def draw_of(supply):  # type: ignore[no-untyped-def]
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
    again. Of contacts that strengthen `threshold` is that at age 0, and `born` the time of birth. `way` of
    the drive: 1 or -1.
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
        self.law, self.now, self.way = contacts.strengthening, 0.0, 1
        self.zero, self.threshold, self.k, self.born = np.zeros((4, 0))
        self.returns = list[tuple[float, int]]()  # when, and how many
        self.form(n, start=True)

    def form(self, number: int, start: bool = False) -> None:
        """So many contacts form at X."""
        drawn = [draw_of(self.draws[0 if start else 1]) for _ in range(number)]
        threshold, stretch = self.unit * np.array(drawn, float).reshape(-1, 2).T
        age = 0.0 if self.law is None else self.law.age
        share = 1.0 if self.law is None else 1.0 / self.law.factor(age)
        self.threshold = np.append(self.threshold, threshold * share)
        self.born = np.append(self.born, np.full(number, self.now - age * start))
        self.zero = np.append(self.zero, self.x - stretch)
        self.k = np.append(self.k, self.contacts.relative_stiffness(threshold))

    def load(self, x: float) -> float:
        """F + K X if the slider moves to x and nothing breaks."""
        return self.k @ (x - self.zero) + self.spring * x

    def balance(self, level: float) -> float:
        """X where F + K X = level, if nothing breaks."""
        return (level + self.k @ self.zero) / (self.spring + self.k.sum())

    def ends(self, now: float | np.ndarray) -> np.ndarray:
        """X where each contact breaks, if it does so at this time, of all or its own."""
        grown = 1.0 if self.law is None else self.law.factor(now - self.born)
        return self.zero + self.way * self.threshold * grown

    def next_break(self) -> float:
        """X where the next contact breaks, if it does so now."""
        return self.way * float(min(self.way * self.ends(self.now), default=np.inf))

    def is_broken(self, level: float) -> bool:
        """Whether a contact breaks at K X_T = level now."""
        return self.k.size > 0 and self.way * self.load(self.next_break()) <= self.way * level

    def level_of_break(self) -> float:
        """K X_T where the next contact breaks while the drive goes on from `level`; far away if it does not get there.

        Along a leg of the drive what a contact can still bear is concave, so that one that holds at its begin breaks at
        one place at most.
        """
        if self.law is None:
            return self.load(self.next_break()) if self.k.size else self.way * np.inf
        way, places = self.way, self.spring * np.array(self.places)
        legs = zip(pairwise(places), pairwise(self.clock), strict=True)
        for (begin, end), (before, after) in legs:
            begins = way * max(way * begin, way * self.level)
            low, high = np.full(self.k.size, begins), np.full(self.k.size, end)

            def broken(level, begin=begin, end=end, before=before, after=after):
                now = before + (level - begin) / (end - begin) * (after - before)
                return way * self.balance(level) >= way * self.ends(now)

            if way * end <= way * begins or not (may := broken(high)).any():
                continue
            for _ in range(52):
                middle = 0.5 * (low + high)
                high, low = np.where(broken(middle), [middle, low], [high, middle])
            return way * float((way * high[may]).min())
        return way * np.inf

    def shake(self, level: float) -> int:
        """The avalanche at K X_T = level, which begins with the next break: how many contacts broke, and formed again
        if the rule says so. A reset draws all anew."""
        drive, broken = self.drive, 0
        places = self.way * np.array(self.places)
        self.now = float(np.interp(self.way * level / self.spring, places, self.clock))
        at_once = drive.slip == "instant" and self.contacts.delay is None
        while not broken or self.is_broken(level):
            first = int(np.argmin(self.way * self.ends(self.now)))
            self.x = self.next_break()
            for name in ("zero", "threshold", "k", "born"):
                setattr(self, name, np.delete(getattr(self, name), first))
            self.breaks, broken = self.breaks + 1, broken + 1
            self.form(int(at_once))
            if drive.slip == "reset" and broken >= self.slip_fraction * self.n:
                self.x, self.returns = level / self.spring, []
                self.zero, self.threshold, self.k, self.born = np.zeros((4, 0))
                self.form(self.n)
                return broken
        self.x = self.balance(level)
        if self.contacts.delay is not None:
            self.returns.append((self.now + self.contacts.delay.time, broken))
        elif not at_once:
            self.form(broken)
        return broken

    def follow(self) -> Followed:
        """To the end of the path, from where the drive balances the start."""
        drive, spring, told = self.drive, self.spring, list[tuple[float, float, float]]()
        self.level = level = self.load(self.x)
        places = np.append(level / spring, drive.path)
        way = np.cumsum(np.abs(np.diff(places))) / drive.velocity
        clock = np.append(0.0, way if drive.time is None else drive.time)
        slips, avalanches = list[list[float]](), np.zeros(SIZES, np.int64)
        for (begin, end), (before, time) in zip(pairwise(places), pairwise(clock), strict=True):
            # one straight piece of the drive at a time; in a rest contacts only form, and grow
            self.places, self.clock, point = [begin, end], [before, time], spring * end
            self.way, self.level = int(np.sign(end - begin)) or self.way, spring * begin
            while True:
                # what comes first: a break, a return, or the point
                first = self.level_of_break()
                due = self.returns[0][0] if self.returns else np.inf
                back = spring * np.interp(due, self.clock, self.places)
                back = back if due <= self.clock[-1] else self.way * np.inf
                ahead = (self.way * first, -np.inf), (self.way * back, due)
                if (self.way * point, time) < min(ahead):
                    break
                if self.way * back < self.way * first:
                    self.x, self.now = self.balance(back), due
                    self.form(self.returns.pop(0)[1])
                    continue
                level = self.level = self.way * max(self.way * self.level, self.way * first)
                x = self.balance(level)
                broken = self.shake(level)
                if broken < self.slip_fraction * self.n:
                    avalanches[broken.bit_length() - 1] += 1
                    continue
                after = self.x if drive.slip != "instant" else self.balance(level)
                forces = (level - spring * np.array([x, after])) / self.n
                slips.append([level / spring, x, after, *forces, broken])
            x = self.balance(point)
            told.append((x, (point - spring * x) / self.n, self.k.size / self.n))
        position, force, holding = np.array(told).T
        table = np.reshape(slips, (-1, 6))
        return Followed(position, force, holding, table, avalanches, self.breaks)
