"""Coupled contacts on a slider with mass in plain Python: slow, and simple enough to be read. Arrays of floats, an
event at a time; the motion between events is a sum of two exponentials, looked through at fine steps."""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np
from plain_coupled import PlainReplica, draw_of
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from eq_model.coupled.ensemble import unit_of
from eq_model.coupled.work import growth
from eq_model.draws.births import births_of
from eq_model.draws.streams import make_stream
from eq_model.draws.supply import make_supply
from origins import Contacts, Drive


class Followed(NamedTuple):
    """What a replica did: curves at the path's points as columns (X, spring's force, share that holds, speed, force of
    the contacts), and slips: X_T, X and K (X_T - X) before and after, breaks, duration."""

    curves: np.ndarray
    slips: np.ndarray
    breaks: int


class PlainSlider:
    """One replica with the draws that `eq_model.simulate` makes; lengths and times are the user's."""

    def __init__(
        self, contacts: Contacts, drive: Drive, n: int, seed: int, fraction: float = 0.2
    ) -> None:
        """n contacts at X = 0, drawn as those of replica 0."""
        self.unit, stream = unit_of(contacts), make_stream(seed, 0)
        self.draws = [make_supply(births, stream) for births in births_of(contacts, self.unit)]
        self.contacts, self.drive, self.n, self.fraction = contacts, drive, n, fraction
        self.law = contacts.strengthening
        self.x = self.v = self.t = 0.0
        self.zero, self.threshold, self.k, self.born = np.zeros((4, 0))
        self.returns, self.breaks = list[float](), 0
        self.form(n, start=True)
        balance = self.k @ -self.zero / n / drive.spring
        self.places, self.top = np.append(balance, drive.path), 0.0
        self.clock = np.append(0.0, np.cumsum(np.abs(np.diff(self.places))) / drive.velocity)
        if drive.time is not None:
            self.clock = np.append(0.0, drive.time)
        self.slips, self.begun = list[list[float]](), None
        self.high, self.low, self.lead, self.rushed, self.slip = None, None, -np.inf, False, None
        self.stuck, self.loose, self.rest = True, 0, (self.x, self.spring_force(self.x, 0.0), 0)
        self.stuck_at, self.held, self.lowest = self.x, n, self.rest[:2]
        self.highest = -np.inf

    form = PlainReplica.form  # from the same fields
    now = property(lambda self: self.t)

    def spring_force(self, x: float, t: float) -> float:
        return self.drive.spring * (np.interp(t, self.clock, self.places) - x)

    def contact_force(self, x: float) -> float:
        return float(self.k @ (x - self.zero)) / self.n

    def motion(self, velocity: float):
        """X and its speed as functions of the time from now on, while the drive's speed is this and nothing breaks."""
        m, c, spring = self.drive.mass, self.drive.damping, self.drive.spring
        stiff = spring + self.k.sum() / self.n
        drift = spring * velocity / stiff
        net = self.spring_force(self.x, self.t) - self.contact_force(self.x)
        u, w = (c * drift - net) / stiff, self.v - drift
        roots = np.roots([m, c, stiff]).astype(complex)
        first = (w - roots[1] * u) / (roots[0] - roots[1])
        parts = np.array([first, u - first])

        def way(t):
            return drift * t + (parts @ np.expm1(np.multiply.outer(roots, t))).real

        def speed(t):
            return drift + ((parts * roots) @ np.exp(np.multiply.outer(roots, t))).real

        return way, speed, np.abs(roots).max()

    def left(self, way, times) -> np.ndarray:
        """How far each contact that grows (a row) is from its break after these times (columns)."""
        grown = self.law.factor(self.t + times - self.born[:, None])
        return self.threshold[:, None] * grown - np.abs(self.x + way(times) - self.zero[:, None])

    def falls(self, times, speed, way, velocity: float) -> None:
        """Begin and end falls of the spring's force where the speed passes that of the drive between these times."""

        def excess(t):
            return speed(t) - velocity

        signs = excess(times) > 0.0
        edges = [0, *(np.flatnonzero(signs[1:] != signs[:-1]) + 1), times.size]
        for first, last in itertools.pairwise(edges):
            if not signs[first]:
                continue
            top, ends = speed(times[first:last]).max(), last < times.size
            for i, falls, there in ((first, True, first > 0), (last, False, ends)):
                if not there:
                    continue
                at = brentq(excess, times[i - 1], times[i], xtol=1e-15)
                self.top = top if falls else max(self.top, top)
                if falls:
                    self.watch(at, way(at), velocity)
                self.turn(at, way(at), falls, velocity)
            self.top = max(self.top, top)

    def loosened(self, velocity: float) -> bool:
        """Whether the next swing down is a slip."""
        return self.stuck and self.loose >= max(self.fraction * self.held, self.fewest(velocity), 1)

    def fewest(self, velocity: float) -> float:
        """Breaks in a slip: a fifth of the contacts that hold in steady sliding."""
        mean, wait = self.contacts.mean_threshold, self.contacts.waiting_time
        return self.n * max(0.02, min(self.fraction, 0.2) * mean / (mean + wait * abs(velocity)))

    def turn(self, after: float, way: float, falls: bool, velocity: float) -> None:
        """From so much later, and so far ahead, the spring's force falls, or rises again."""
        x, now, mean = self.x + way, self.t + after, self.contacts.mean_threshold
        force, drive = self.spring_force(x, now), np.interp(now, self.clock, self.places)
        lead = self.drive.spring * (1.5 * drive - x)
        chance = self.chance(velocity)
        level = max(0.02 * mean, chance)
        if falls:
            self.begun = force
            if self.low and force - self.low[2] >= level:
                self.end_slip()
                self.low = self.high = None
            if not self.low and (self.high is None or force >= self.high[3]):
                self.high, self.lead, self.rushed = (now, drive, x, force), lead, False
            self.lead, self.highest = max(self.lead, lead), max(self.highest, force)
        elif self.begun is not None:
            self.rushed |= self.top >= 1.5 * velocity and self.begun - force >= chance
            self.rushed |= self.lead - lead >= chance
            drop, first = (
                self.high[3] - force,
                self.slip is None and self.rushed and self.loosened(velocity),
            )
            if self.low or drop >= level:
                if first:
                    self.slip, self.stuck = self.breaks - self.loose, False
                lower = not self.low or self.low[2] - force > 1e-3 * drop
                self.low = (now, x, force, self.breaks) if lower else self.low
                self.highest = -np.inf if lower else self.highest
                if first and not lower:
                    self.low = (*self.low[:3], self.breaks)
                if (first or lower) and (self.slip is not None or self.breaks > self.rest[2]):
                    self.rest = x, force, self.breaks
            self.begun, self.top = None, 0.0
            self.lowest = (x, force) if force < self.lowest[1] else self.lowest

    def end_slip(self) -> None:
        """The present swing down is over."""
        if self.slip is not None:
            (begin, drive, before, high), (end, x, force, breaks) = self.high, self.low
            self.slips.append([drive, before, x, high, force, breaks - self.slip, end - begin])
        self.slip = None

    def chance(self, velocity: float) -> float:
        """Six standard deviations of the force of n contacts and one in steady sliding, from integrals over S."""
        law, wait = self.contacts.thresholds, self.contacts.waiting_time * max(velocity, 0.0)
        x = np.linspace(0.0, law.isf(1e-12), 20_001)
        weight = law.pdf(x)
        if len(law.atoms[0]):
            x, weight = law.atoms[0], law.atoms[1]
        k = self.contacts.relative_stiffness(x)
        mean, force, square = (
            (weight * part).sum() / weight.sum() for part in (x, 0.5 * k * x**2, k**2 * x**3 / 3.0)
        )
        each = square / (mean + wait) - (force / (mean + wait)) ** 2 + square / mean / self.n
        return min(6.0 * (each / self.n) ** 0.5, mean) * growth(self.contacts, self.drive)

    def watch(self, after: float, way: float, velocity: float) -> None:
        """Whether the slider sticks: contacts hold it in a narrow room, and few break, as the spring's force rises to
        its value so much later, and so far ahead."""
        here, mean, holds = self.x + way, self.contacts.mean_threshold, self.zero.size
        now = self.spring_force(here, self.t + after)
        if here < self.stuck_at - 2.0 * mean:
            self.stuck = False
        few = holds < 0.02 * self.n or (self.stuck and holds < self.fraction * self.held)
        x, force, breaks = self.rest
        near, loaded = abs(here - x) <= 2.0 * mean, now - self.lowest[1] >= 0.02 * mean
        loaded &= not self.loosened(velocity)
        risen = near and now - force >= 0.02 * mean
        loaded |= risen and self.breaks - breaks < self.fraction * holds
        if few or not near or risen:
            self.rest = *self.lowest, self.breaks
        if loaded and not few and now >= self.highest:
            self.stuck, self.stuck_at, self.held, self.loose = True, here, holds, 0

    def follow(self) -> Followed:
        """To the end of the path."""
        told, delay = list[list[float]](), self.contacts.delay
        for end, velocity in zip(self.clock[1:], self.speeds(), strict=True):
            if (self.begun is None) == (self.v > velocity):  # the drive's speed changes
                if self.begun is None:
                    self.watch(0.0, 0.0, velocity)
                self.turn(0.0, 0.0, self.v > velocity, velocity)
            while True:
                way, speed, fastest = self.motion(velocity)
                due = min(end, self.returns[0] if self.returns else np.inf) - self.t
                places = np.stack([self.zero + self.threshold, self.threshold - self.zero])
                ahead = min(places[0], default=np.inf) - self.x
                behind = min(places[1], default=np.inf) + self.x
                if self.law is not None:
                    ahead = behind = self.left(way, np.zeros(1)).min(initial=np.inf)
                moves = ahead > 0.0 and behind > 0.0
                times = np.linspace(0.0, due, 200 + int(150.0 * fastest * due))
                ways = way(times)
                passed, broke, first = np.flatnonzero((ways >= ahead) | (ways <= -behind)), 0, -1
                if self.law is not None:
                    passed = np.flatnonzero(
                        self.left(way, times).min(axis=0, initial=np.inf) <= 0.0
                    )
                if passed.size and passed[0] > 0:
                    i = passed[0]
                    broke = 1 if ways[i] >= ahead else -1
                    level = ahead if broke > 0 else -behind
                    least = lambda t: way(t) - level  # noqa: B023, E731
                    if self.law is not None:
                        least = lambda t: self.left(way, np.array([t])).min()  # noqa: B023, E731
                    due = brentq(least, times[i - 1], times[i], xtol=1e-15)
                    times = np.append(times[:i], due)
                elif passed.size:  # several at one place
                    broke, due, times = 1 if ahead <= 0.0 else -1, 0.0, np.zeros(1)
                if broke and self.law is not None:
                    first = int(np.argmin(self.left(way, np.array([due]))))
                    broke = 1 if self.x + way(due) > self.zero[first] else -1
                self.falls(times, speed, way, velocity)
                returns = self.returns and self.t + due >= self.returns[0]
                if moves and (broke or returns) and self.begun is None:
                    self.watch(due, way(due), velocity)
                self.x, self.v, self.t = self.x + way(due), speed(due), self.t + due
                if broke:
                    if self.law is None:
                        first = int(np.argmin(places[0 if broke > 0 else 1]))
                        self.x = self.zero[first] + broke * self.threshold[first]
                    for name in ("zero", "threshold", "k", "born"):
                        setattr(self, name, np.delete(getattr(self, name), first))
                    self.breaks, self.loose = self.breaks + 1, self.loose + 1
                    if delay is None:
                        self.form(1)
                    else:
                        self.returns.append(self.t + delay.time)
                elif self.returns and self.t >= self.returns[0]:
                    self.returns.pop(0)
                    self.form(1)
                else:
                    break
                self.lowest = self.x, self.spring_force(self.x, self.t)
            force, held = self.spring_force(self.x, self.t), self.zero.size / self.n
            told.append([self.x, force, held, self.v, self.contact_force(self.x)])
        if self.low and (self.begun is None or force > self.low[2]):
            self.end_slip()
        return Followed(np.array(told).T, np.reshape(self.slips, (-1, 7)), self.breaks)

    def speeds(self) -> np.ndarray:
        """Speeds of the drive on its legs."""
        return np.diff(self.places) / np.diff(self.clock)

    def integrate(self, tolerance: float) -> np.ndarray:
        """X at the path's points by scipy's integrator of the equation of motion: no closed form, no delay."""
        m, c, spring, told = (*(getattr(self.drive, n) for n in ("mass", "damping", "spring")), [])
        for end, velocity in zip(self.clock[1:], self.speeds(), strict=True):
            start, drive = self.clock[len(told)], self.places[len(told)]
            while self.t < end:
                total, load = self.k.sum() / self.n, self.k @ self.zero / self.n
                ahead = (self.zero + self.threshold).min()
                behind = (self.zero - self.threshold).max()

                def push(t, y):
                    pulled = drive + velocity * (t - start) - y[0]  # noqa: B023
                    return [y[1], (spring * pulled - total * y[0] + load - c * y[1]) / m]  # noqa: B023

                def breaks(t, y):
                    return min(ahead - y[0], y[0] - behind)  # noqa: B023

                breaks.terminal, breaks.direction = True, -1.0
                found = solve_ivp(
                    push, (self.t, end), [self.x, self.v], "DOP853", None, False, breaks,
                    rtol=tolerance, atol=0.01 * tolerance,
                )  # fmt: skip
                self.t, (self.x, self.v) = found.t[-1], found.y[:, -1]
                if found.status == 1:
                    first = int(np.argmin(self.threshold - np.abs(self.x - self.zero)))
                    self.zero[first] = self.x
                    self.threshold[first] = self.unit * draw_of(self.draws[1])[0]
            told.append(self.x)
        return np.array(told)
