"""Coupled contacts in plain Python: slow, and simple enough to be read. A heap of breaks, floats."""

from __future__ import annotations

import heapq
from collections import deque
from typing import NamedTuple

import numpy as np

from eq_model.coupled.ensemble import unit_of
from eq_model.coupled.slide_kernel import make_supply, take
from eq_model.draws.births import births_of
from eq_model.draws.streams import make_stream
from eq_model.result import SIZES
from origins import Contacts, Drive


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

    Lengths are the user's; force and stiffness are sums over the contacts, k_i in <k>.
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
        assert drive.spring is not None
        self.unit, stream = unit_of(contacts), make_stream(seed, replica)
        self.draws = [make_supply(births, stream) for births in births_of(contacts, self.unit)]
        self.contacts, self.drive, self.n, self.slip_fraction = contacts, drive, n, slip_fraction
        self.spring = drive.spring * n
        self.x = self.force = self.stiffness = 0.0
        self.held, self.breaks, self.arrival = 0, 0, 0
        self.waiting = list[tuple[float, int, float]]()  # where it breaks, arrival, threshold
        for _ in range(n):
            self.form(start=True)

    def form(self, start: bool = False) -> None:
        """A contact forms at X."""
        whole, units = take(self.draws[0 if start else 1])
        threshold, stretch = float(whole * self.unit), float(units * self.unit)
        k = float(self.contacts.relative_stiffness(threshold))
        self.held, self.stiffness = self.held + 1, self.stiffness + k
        self.force, self.arrival = self.force + k * stretch, self.arrival + 1
        heapq.heappush(self.waiting, (self.x - stretch + threshold, self.arrival, threshold))

    def load(self, x: float) -> float:
        """F + K X if the slider moves to x and nothing breaks."""
        return self.force + self.stiffness * (x - self.x) + self.spring * x

    def move(self, x: float) -> None:
        """The slider moves to x, and nothing breaks."""
        self.force, self.x = self.force + self.stiffness * (x - self.x), x

    def balance(self, level: float) -> float:
        """X where F + K X = level, if nothing breaks."""
        return self.x + (level - self.load(self.x)) / (self.spring + self.stiffness)

    def shake(self, level: float) -> int:
        """The avalanche at K X_T = level, which begins with the next break: how many contacts broke, and formed again
        if the rule says so. A reset draws all anew."""
        drive, out, broken = self.drive, 0, 0
        at_once = drive.slip == "instant" and self.contacts.delay is None
        while not broken or (self.waiting and self.load(self.waiting[0][0]) <= level):
            b, _, threshold = heapq.heappop(self.waiting)
            self.move(b)
            k = float(self.contacts.relative_stiffness(threshold))
            self.force, self.stiffness = self.force - k * threshold, self.stiffness - k
            self.held, self.breaks, broken = self.held - 1, self.breaks + 1, broken + 1
            if at_once:
                self.form()
            else:
                out += 1
            if drive.slip == "reset" and broken >= self.slip_fraction * self.n:
                self.x, self.force, self.stiffness, self.held = level / self.spring, 0.0, 0.0, 0
                self.waiting.clear()
                self.returns.clear()
                for _ in range(self.n):
                    self.form()
                return broken
        self.move(self.balance(level))
        if self.contacts.delay is None:
            for _ in range(out):
                self.form()
        else:
            now = self.clock_at(level / self.spring)
            self.returns.append((now + self.contacts.delay.time, out))
        return broken

    def clock_at(self, drive: float) -> float:
        """When the drive comes to X_T = drive first."""
        leg = max(int(np.searchsorted(self.places, drive, side="left")), 1)
        share = (drive - self.places[leg - 1]) / (self.places[leg] - self.places[leg - 1])
        return float(self.clock[leg - 1] + share * (self.clock[leg] - self.clock[leg - 1]))

    def follow(self) -> Followed:
        """To the end of the path, whose first point is at or beyond where the drive balances the start."""
        drive, spring, told = self.drive, self.spring, list[tuple[float, float, float]]()
        self.places = np.append(self.force / spring, drive.path)
        way = np.cumsum(np.diff(self.places)) / drive.velocity
        self.clock = np.append(0.0, way if drive.time is None else drive.time)
        self.returns = deque[tuple[float, int]]()
        slips, avalanches = list[list[float]](), np.zeros(SIZES, np.int64)
        points = list(zip(self.clock[1:], spring * drive.path, strict=True))
        level = self.force
        while points:
            # what comes first: a point of the path, a return or a break
            first = self.load(self.waiting[0][0]) if self.waiting else np.inf
            due = self.returns[0][0] if self.returns else np.inf
            back = (
                spring * np.interp(due, self.clock, self.places)
                if due <= self.clock[-1]
                else np.inf
            )
            time, point = points[0]
            if (point, time) < min((first, -np.inf), (back, due)):
                x = self.balance(point)
                told.append((x, (point - spring * x) / self.n, self.held / self.n))
                points.pop(0)
            elif back < first:
                self.move(self.balance(back))
                for _ in range(self.returns.popleft()[1]):
                    self.form()
            else:
                level = max(level, first)
                before, force = self.waiting[0][0], level - spring * self.waiting[0][0]
                broken = self.shake(level)
                if broken >= self.slip_fraction * self.n:
                    x = self.x if drive.slip != "instant" else self.balance(level)
                    after = (level - spring * x) / self.n
                    slips.append([level / spring, before, x, force / self.n, after, broken])
                else:
                    avalanches[broken.bit_length() - 1] += 1
        position, force_told, holding = np.array(told).T
        table = np.reshape(slips, (-1, 6))
        return Followed(position, force_told, holding, table, avalanches, self.breaks)
