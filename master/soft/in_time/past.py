"""Past: when contacts broke and were born on a soft slider, step by step.

With J(t) the births per contact since t = 0, B(t) the breaks, and E(t, s) what is left of the births
at s, number conservation says

    G_0(t) + integral of E(t, s) dJ(s) + [B(t) - J(t)] = 1,        J(t) = B(t - delay).

Within a step births are even: the integral is a sum over steps of means of E, good to the square of
the step.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.soft.in_time.cohorts import Cohorts

Array = npt.NDArray[np.float64]

# Points of the polynomial that reads what broke a delay before.
STENCIL = 4
# Share of the time by which the delay is longer: what is born at once then is not born before.
SLACK = 1e-13
# Share of the births at the end of a step that is left of those at its beginning, below which it is
# not known how many of the births in between hold.
MOST_GONE = 0.5


class Line(NamedTuple):
    """A number that is known as slope * B + rest from what is asked for, B."""

    slope: float
    rest: float


@dataclass
class Past:
    """Moments at which steps ended, and the breaks and births per contact until then.

    delay : float
        Time from the break of a contact to its birth.
    times, breaks, births : list of float
    bends : list of int
        Numbers of the moments at which breaks may bend or jump: nothing is read across.
    """

    delay: float
    times: list[float]
    breaks: list[float] = field(default_factory=lambda: [0.0])
    births: list[float] = field(default_factory=lambda: [0.0])
    bends: list[int] = field(default_factory=lambda: [0])

    def add(self, now: float, breaks: float, births: float) -> None:
        """One more moment."""
        self.times.append(now)
        self.breaks.append(breaks)
        self.births.append(births)

    def births_at(self, now: float) -> Line:
        """Births up to a later moment, in terms of the breaks B up to then."""
        if not self.delay:
            return Line(1.0, 0.0)
        times = np.array([*self.times, now])
        at = now - self.delay - SLACK * (now - times[0])
        if at <= times[0]:
            return Line(0.0, 0.0)
        last = times.size - 1
        cell = int(np.searchsorted(times, at, side="left"))
        bends = np.array([*self.bends, last])
        part = int(np.searchsorted(bends, cell, side="left"))
        low, high = int(bends[part - 1]), min(int(bends[part]), last)
        begin = min(max(cell - STENCIL // 2, low), max(high - STENCIL + 1, low))
        nodes = np.arange(begin, min(begin + STENCIL - 1, high) + 1)
        # births at once are two moments with nothing between
        nodes = nodes[np.append(np.diff(times[nodes]) > 0.0, True)]
        weights = lagrange(times[nodes], at)
        known = np.array([*self.breaks, 0.0])[nodes]
        return Line(float(weights[-1]) if nodes[-1] == last else 0.0, float(weights @ known))


class Counted(NamedTuple):
    """What number conservation tells at one moment.

    force : per contact and <k> (a length); holding : share of the contacts
    breaks, births : per contact since t = 0
    """

    force: float
    holding: float
    breaks: float
    births: float


def count(cohorts: Cohorts, past: Past, births: Line) -> Counted:
    """Force and numbers right after a step, at the end of which the last of the cohorts are born."""
    held, pull = cohorts.spread()
    even, before = np.diff(past.births), past.births[-1]
    known = float(cohorts.held[0] + held[:-1] @ even)
    last, slope, rest = float(held[-1]), births.slope, births.rest
    # known + last (J - J_before) + B - J = 1, J = slope B + rest
    breaks = (1.0 - known + last * before + (1.0 - last) * rest) / (1.0 - (1.0 - last) * slope)
    new = slope * breaks + rest - before
    force = float(cohorts.pull[0] + pull[:-1] @ even + pull[-1] * new)
    return Counted(force, known + last * new, breaks, before + new)


def unknown(cohorts: Cohorts, past: Past) -> float:
    """Force (a length) of contacts of which it is not known how many hold.

    They were born evenly within a step of whose first births most are gone and of whose last births
    most are not. Relaxed ones bear nothing.
    """
    held, pull = cohorts.held[1:], cohorts.pull[1:]
    half = 0.5 * np.abs(np.diff(pull))
    apart = np.where(held[:-1] < MOST_GONE * held[1:], half, 0.0)
    return float(apart @ np.abs(np.diff(past.births)))


def lagrange(nodes: Array, at: Array | float) -> Array:
    """Weights of values at nodes (..., n) in the polynomials through them, at points (...)."""
    same = np.eye(nodes.shape[-1], dtype=bool)
    apart = np.where(same, 1.0, nodes[..., :, None] - nodes[..., None, :])
    ways = np.where(same, 1.0, (np.asarray(at)[..., None] - nodes)[..., None, :])
    return np.asarray((ways / apart).prod(axis=-1))
