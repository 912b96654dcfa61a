"""Strands of contacts that age: groups born at any moments, whose thresholds are followed together."""

from __future__ import annotations

from copy import copy
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.interpolate import BSpline, make_interp_spline

from master.lives.age.cells import Cells
from origins import Contacts
from origins.errors import InputError

Array = npt.NDArray[np.float64]
Whole = npt.NDArray[np.intp]

# Ratio of the errors of the coarse and the fine resolution.
RATIO = 8.0
# Share that holds below which a strand is dropped.
DEAD = 1e-15
# Travel in one step at resolution 0, over the narrowest width of the laws.
TRAVEL_STEP = 0.25
# Share of fresh contacts that heat breaks in one step at most, at resolution 0.
HEAT_STEP = 0.15
# Steps after a birth or a change of speed over the time since then, at resolution 0: the edge of the
# density at |x| changes, first fast and then ever more slowly. The first step over the time in which
# thresholds spread by the narrowest width.
AFTER_CHANGE, FIRST_STEP = 0.5, 1e-10
# Steps of one move of a strand; some 30 seconds of work.
MOST_STEPS = 200_000
# Survival at which a table of strands ends, and the degree of splines in time.
SPENT, DEGREE = 1e-12, 5


class Mesh:
    """Cells and time steps of two resolutions, the finer one with an eighth of the coarser one's error.

    Parameters
    ----------
    contacts : Contacts
    resolution : int
        The finer one, at least 1.
    fastest : float
        Largest speed of the slider.
    """

    def __init__(self, contacts: Contacts, resolution: int, fastest: float) -> None:
        assert contacts.ageing is not None
        self.diffusion, self.resolution = contacts.ageing.rate, resolution
        self.cells = tuple(Cells(contacts, k, fastest) for k in (resolution - 1, resolution))
        self.width = self.cells[0].width
        self.heat_rate = fresh_rate(contacts)

    def steps(self, speed: float, since: float, duration: float) -> Array:
        """Ends of the coarse steps of a move, times from 0 to `duration`.

        since : time at the beginning since the speed changed, or the birth
        """
        scale = 2.0 ** (self.resolution - 1)
        longest = HEAT_STEP / self.heat_rate if self.heat_rate > 0.0 else np.inf
        if speed != 0.0:
            longest = min(longest, TRAVEL_STEP * self.width / abs(speed))
        shortest = FIRST_STEP * self.width**2 / self.diffusion
        times = [0.0]
        while times[-1] < duration:
            step = min(AFTER_CHANGE * (since + times[-1]) + shortest, longest) / scale
            times.append(times[-1] + step)
            if len(times) > MOST_STEPS:
                raise InputError(
                    f"ageing: a move of {duration:.3g} in time needs more than {MOST_STEPS} steps; "
                    "use a shorter path, or a larger tolerance"
                )
        return duration * (np.array(times) / times[-1])


class Followed(NamedTuple):
    """Strands along a leg: times since its beginning, shape (n,), and the share that holds and the
    force of each strand, shape (n, 2, strands)."""

    times: Array
    left: Array

    def over_root(self, values: Array) -> BSpline:
        """Values at the times, shape (n, ...), as a spline over the root of the time on the leg."""
        return make_interp_spline(np.sqrt(self.times), values, k=min(DEGREE, self.times.size - 1))


class Strands:
    """Any number of strands: groups of contacts born together, each with its law of thresholds.

    The contacts of a strand were born at one or more stretches, its parts.

    Parameters
    ----------
    mesh : Mesh
    stretch, share : arrays (parts,)
        Stretches at birth, and weights of sum 1.

    Attributes
    ----------
    stretch : array (strands, parts), now (lengths)
    error : float
        Largest estimate so far of the error of the finer resolution, which is extrapolated.
    """

    def __init__(self, mesh: Mesh, stretch: Array, share: Array) -> None:
        self.mesh, self.share, self.stretch = mesh, share, stretch[None].copy()
        self.since, self.speed, self.error = 0.0, np.nan, 0.0
        # arrays (strands, parts, cells) for both resolutions
        self._weights = [cells.fresh(stretch)[None] for cells in mesh.cells]

    def steps_of(self, speed: float, duration: float) -> Array:
        """Ends, from 0, of the coarse steps that `advance` would take at this speed."""
        since = self.since if speed == self.speed else 0.0
        return self.mesh.steps(speed, since, duration)

    def advance(self, speed: float, duration: float) -> None:
        """All strands move on at the speed dX/dt for a time."""
        if not duration:
            return
        steps = self.steps_of(speed, duration) / duration
        if speed != self.speed:
            self.speed, self.since = speed, 0.0
        halves = np.sort(np.concatenate([steps, 0.5 * (steps[1:] + steps[:-1])]))
        for own, weights, ends in zip(self.mesh.cells, self._weights, (steps, halves), strict=True):
            alive = weights.sum(axis=2) > DEAD
            begin, time = self.stretch[alive], np.full(alive.sum(), duration)
            weights[alive] = own.stepped(weights[alive], begin, speed * time, time, ends)
        self.stretch = self.stretch + speed * duration
        self.since += duration

    def follow(self, speed: float, duration: float, spent: float = 0.0) -> Followed:
        """Advance, until less than the share `spent` holds; returns shares and forces on the way."""
        times, told = self.steps_of(speed, duration), [self.left()]
        for time in np.diff(times):
            self.advance(speed, float(time))
            told.append(self.left())
            if (told[-1][0] < spent).all():
                break
        return Followed(times[: len(told)], np.array(told))

    def left(self) -> Array:
        """Share of each strand that holds, and its force per contact born, shape (2, strands)."""
        coarse, fine = (weights.sum(axis=2) for weights in self._weights)
        missed = (fine - coarse) / (RATIO - 1.0)
        self.error = max(self.error, float((np.abs(missed) @ self.share).max(initial=0.0)))
        holds = np.clip(fine + missed, 0.0, 1.0)
        return np.stack([holds @ self.share, (holds * self.stretch) @ self.share])

    def take(self, which: Whole) -> Strands:
        """Some of the strands, as a copy."""
        out = copy(self)
        out.stretch = self.stretch[which]
        out._weights = [weights[which] for weights in self._weights]
        return out

    def join(self, *others: Strands) -> Strands:
        """These strands, followed by others of the same births that move on together with them."""
        out, parts = copy(self), (self, *others)
        out.stretch = np.concatenate([part.stretch for part in parts])
        weights = zip(*(part._weights for part in parts), strict=True)
        out._weights = [np.concatenate(own) for own in weights]
        out.error = max(part.error for part in parts)
        alike = all(part.speed == out.speed for part in parts)
        out.since = min(part.since for part in parts) if alike else 0.0
        return out


class StrandSurvival:
    """Survival of contacts born at one stretch that age at one speed >= 0, followed by a strand.

    A new table begins where |x| turns at 0; the variable of each is the root of the time since its
    beginning, in which survivals are smooth there.

    Parameters
    ----------
    strands : Strands
        One, of one part, right after its birth.
    speed : float
    longest : float
        Time after which no survival is asked.

    Attributes
    ----------
    reach_lag : float
        Time after which hardly any contact holds, or `longest`.
    error : float
        The share that is taken as 0 from then on; beside it is the error of the strand.
    """

    def __init__(self, strands: Strands, speed: float, longest: float) -> None:
        turn = -float(strands.stretch[0, 0]) / speed if speed > 0.0 else 0.0
        marks = [0.0, turn, longest] if 0.0 < turn < longest else [0.0, longest]
        self._begins: list[float] = []
        self._splines: list[BSpline] = []
        for begin, end in pairwise(marks):
            strands.since = 0.0  # thresholds may have gathered right above |x|
            found = strands.follow(speed, end - begin, SPENT)
            self._begins.append(begin)
            self._splines.append(found.over_root(found.left[:, 0, 0]))
            self.reach_lag, share = begin + float(found.times[-1]), float(found.left[-1, 0, 0])
            if share < SPENT:
                break
        self.error = share if share < SPENT else 0.0

    def survival(self, lag: Array) -> Array:
        """Share at times `lag` >= 0 since the birth, same shape."""
        out = np.zeros(lag.shape)
        ends = [*self._begins[1:], self.reach_lag]
        for begin, end, spline in zip(self._begins, ends, self._splines, strict=True):
            here = (lag >= begin) & (lag <= end)
            out[here] = np.clip(spline(np.sqrt(lag[here] - begin)), 0.0, 1.0)
        return out


def fresh_rate(contacts: Contacts) -> float:
    """Mean rate at which fresh relaxed contacts break by heat (per time); 0 without heat."""
    if contacts.thermal is None:
        return 0.0
    rank = (np.arange(200) + 0.5) / 200.0
    thresholds = np.asarray(contacts.thresholds.ppf(rank))
    return float(contacts.thermal.plain_rate(np.zeros(1), thresholds).mean())
