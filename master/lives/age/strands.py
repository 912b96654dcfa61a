"""Strands of contacts that age: groups born at any moments, whose thresholds are followed together."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from master.lives.age.cells import Cells, Move
from origins import Contacts
from origins.errors import InputError

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

# Ratio of the errors of the coarse and the fine resolution.
RATIO = 8.0
# Share that holds below which a strand is dropped.
DEAD = 1e-15
# Travel in one step at resolution 0, over the narrowest width of the laws.
TRAVEL_STEP = 0.25
# Share of fresh contacts that heat breaks in one step at most, at resolution 0.
HEAT_STEP = 0.15
# Steps after a change of speed over the time since then, at resolution 0: the edge of the density at
# the level changes, first fast and then ever more slowly.
AFTER_CHANGE = 0.5
# The first of these steps over the shortest of three times: D/v², in which an edge forms at the
# largest speed; the time in which thresholds spread by the narrowest width; and that of the move, as
# survivals are interpolated between its steps. LEAST_STEP is its least value, over the time to spread.
FIRST_STEP, LEAST_STEP = 0.02, 1e-10
# Share TORN of fresh thresholds within CLOSE widths above the level, which break at once, above which
# the first steps must be shorter; at resolution 0, where errors are a tenth of it.
TORN, CLOSE = 1e-3, 0.1
# Steps of one move of a strand; some 30 seconds of work.
MOST_STEPS = 200_000


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
        self.law, self.diffusion = contacts.thresholds, contacts.ageing.rate
        self.resolution, self.fastest = resolution, fastest
        self.cells = tuple(Cells(contacts, k, fastest) for k in (resolution - 1, resolution))
        self.width = self.cells[0].width
        self.heat_rate = fresh_rate(contacts)

    def torn(self, stretch: Array, share: Array) -> bool:
        """Whether fresh thresholds are right above |stretch|, so that they break at once."""
        least = np.abs(stretch)
        held = self.law.sf(least)
        near = held - self.law.sf(least + CLOSE * self.width)
        share = share * near / np.where(held > 0.0, held, 1.0)
        return bool(share.max(initial=0.0) > TORN / RATIO**self.resolution)

    def fractions(self, speed: float, since: float, duration: float, torn: bool) -> Array:
        """Ends of the coarse steps of a move, from 0 to 1.

        since : time at the beginning since the speed changed, or the birth
        torn : whether strands are born with thresholds right above the level, which break at once
        """
        scale = 2.0 ** (self.resolution - 1)
        longest = HEAT_STEP / self.heat_rate if self.heat_rate > 0.0 else np.inf
        if speed != 0.0:
            longest = min(longest, TRAVEL_STEP * self.width / abs(speed))
        shortest = LEAST_STEP * self.width**2 / self.diffusion
        if self.fastest > 0.0 and not torn:
            forming = min(self.diffusion / self.fastest**2, self.width**2 / self.diffusion)
            shortest = max(shortest, FIRST_STEP * min(forming, duration))
        times = [0.0]
        while times[-1] < duration:
            step = min(AFTER_CHANGE * (since + times[-1]) + shortest, longest) / scale
            times.append(times[-1] + step)
            if len(times) > MOST_STEPS:
                raise InputError(
                    f"ageing: a move of {duration:.3g} in time needs more than {MOST_STEPS} steps; "
                    "use a shorter path, or a larger tolerance"
                )
        return np.array(times) / times[-1]


class Strands:
    """Any number of strands: groups of contacts born together, each with its law of thresholds.

    A strand has one or more parts, which were born at different stretches.

    Attributes
    ----------
    stretch : array (n, parts), of each part now (lengths)
    share : array (n, parts), weights of sum 1 over the parts
    torn : bool
        Whether there are thresholds right above the stretch, which break at once, as after a birth.
    error : float
        Largest estimate so far of the error of the finer resolution, which is extrapolated.
    """

    def __init__(self, mesh: Mesh, stretch: Array, share: Array) -> None:
        self.mesh, self.share = mesh, share
        self.stretch = stretch.reshape(share.shape).copy()
        self.since, self.speed, self.error = 0.0, np.nan, 0.0
        self.torn = mesh.torn(self.stretch, share)
        self._weights = [cells.fresh(self.stretch.ravel()) for cells in mesh.cells]

    @property
    def count(self) -> int:
        return self.share.shape[0]

    def advance(self, speed: float, duration: Array | float) -> None:
        """All strands move on at the speed dX/dt for a time, one number or one for each strand."""
        duration = np.broadcast_to(np.asarray(duration, dtype=float), self.count)
        if not duration.any():
            return
        longest = float(duration.max())
        steps = self.steps_of(speed, longest) / longest
        if speed != self.speed:
            self.speed, self.since = speed, 0.0
        lasts = np.repeat(duration, self.share.shape[1])
        halves = np.sort(np.concatenate([steps, 0.5 * (steps[1:] + steps[:-1])]))
        for own, weights, ends in zip(self.mesh.cells, self._weights, (steps, halves), strict=True):
            rows = np.flatnonzero(weights.sum(axis=1) > DEAD)
            begin, time = self.stretch.ravel()[rows], lasts[rows]
            weights[rows] = stepped(own, weights[rows], begin, speed * time, time, ends)
        self.stretch = self.stretch + speed * lasts.reshape(self.share.shape)
        self.since += longest
        self.torn = False

    def steps_of(self, speed: float, duration: float) -> Array:
        """Ends, from 0, of the coarse steps that `advance` would take at this speed."""
        since = self.since if speed == self.speed else 0.0
        return duration * self.mesh.fractions(speed, since, duration, self.torn)

    def left(self) -> Array:
        """Share of each strand that holds, and its force per contact born, shape (2, count)."""
        told = [weights.sum(axis=1).reshape(self.share.shape) for weights in self._weights]
        missed = (told[1] - told[0]) / (RATIO - 1.0)
        self.error = max(self.error, float(np.abs(self.share * missed).sum(axis=1).max(initial=0)))
        holds = self.share * np.clip(told[1] + missed, 0.0, 1.0)
        return np.stack([holds.sum(axis=1), (holds * self.stretch).sum(axis=1)])

    def take(self, which: Mask | npt.NDArray[np.intp]) -> Strands:
        """Some of the strands, as a copy."""
        out = object.__new__(Strands)
        out.__dict__.update(self.__dict__)
        rows = np.arange(self.count)[which]
        parts = (rows[:, None] * self.share.shape[1] + np.arange(self.share.shape[1])).ravel()
        for name in ("share", "stretch"):
            setattr(out, name, getattr(self, name)[rows])
        out._weights = [weights[parts] for weights in self._weights]
        return out

    def join(self, other: Strands) -> Strands:
        """These strands, followed by others of the same law that move on together with them."""
        return together([self, other])


def together(parts: Sequence[Strands]) -> Strands:
    """Strands of the same law that move on together, joined in the order of `parts`."""
    out = parts[0].take(np.zeros(0, dtype=np.intp))
    for name in ("share", "stretch"):
        setattr(out, name, np.concatenate([getattr(part, name) for part in parts]))
    out._weights = [np.concatenate(own) for own in zip(*(p._weights for p in parts), strict=True)]
    out.error = max(part.error for part in parts)
    alike = all(part.speed == out.speed for part in parts)
    out.since = min(part.since for part in parts) if alike else 0.0
    return out


def stepped(
    cells: Cells, weights: Array, begin: Array, way: Array, time: Array, ends: Array
) -> Array:
    """Weights of strands after a move by `way` from `begin` within `time`, in steps that end at `ends`."""
    for a, b in pairwise(ends):
        first, last, lasts = begin + way * a, begin + way * b, time * (b - a)
        # cut the step at the stretches where the level turns or leaves the floor
        marks = [0.0] if cells.floor == 0.0 else [-cells.floor, cells.floor]
        across = [(first < mark) != (last < mark) for mark in marks]
        if not any(mark.any() for mark in across):
            weights = cells.move(weights, Move(np.abs(first), np.abs(last), lasts))
            continue
        length = np.where(last == first, 1.0, last - first)
        cuts = [np.where(c, (m - first) / length, 1.0) for m, c in zip(marks, across, strict=True)]
        length = last - first
        cuts = [np.zeros(first.size), *np.sort(cuts, axis=0), np.ones(first.size)]
        for near, far in pairwise(cuts):
            rows = far > near
            one, two = (np.abs(first + length * cut)[rows] for cut in (near, far))
            weights[rows] = cells.move(weights[rows], Move(one, two, (lasts * (far - near))[rows]))
    return weights


def fresh_rate(contacts: Contacts) -> float:
    """Mean rate at which fresh relaxed contacts break by heat (per time); 0 without heat."""
    if contacts.thermal is None:
        return 0.0
    rank = (np.arange(200) + 0.5) / 200.0
    thresholds = np.asarray(contacts.thresholds.ppf(rank))
    return float(contacts.thermal.plain_rate(np.zeros(1), thresholds).mean())
