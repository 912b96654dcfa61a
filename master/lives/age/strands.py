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
        self._diffusion, self.resolution = contacts.ageing.rate, resolution
        self.cells = tuple(Cells(contacts, k, fastest) for k in (resolution - 1, resolution))
        self.width = self.cells[0].width
        self.can_be_finer = resolution < 6 and self.cells[1].can_be_finer

    def steps(self, speed: float, steady_for: float, duration: float) -> Array:
        """Ends of the coarse steps of a move, times from 0 to `duration`.

        steady_for : time at the beginning since the speed changed, or the birth
        """
        rates = np.array(
            [self.cells[0].heat_rate / HEAT_STEP, abs(speed) / self.width / TRAVEL_STEP]
        )
        slowest = 1.0 / max(rates.max(), 1e-300)
        shortest, times = FIRST_STEP * self.width**2 / self._diffusion, [0.0]
        while times[-1] < duration:
            step = min(AFTER_CHANGE * (steady_for + times[-1]) + shortest, slowest)
            times.append(times[-1] + step * 2.0 ** (1 - self.resolution))
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
        """Begin with one strand, of fresh thresholds."""
        self.mesh, self.share, self.stretch = mesh, share, stretch[None].copy()
        self.steady_for, self.speed, self.error = 0.0, np.nan, 0.0
        # arrays (strands, parts, cells) for both resolutions
        self._weights = [cells.fresh(stretch)[None] for cells in mesh.cells]

    def advance(self, speed: float, duration: float) -> None:
        """All strands move on at the speed dX/dt for a time."""
        if not duration:
            return
        if speed != self.speed:
            self.speed, self.steady_for = speed, 0.0
        steps = self.mesh.steps(speed, self.steady_for, duration)
        halves = np.sort(np.concatenate([steps, 0.5 * (steps[1:] + steps[:-1])]))
        for cells, weights, times in zip(
            self.mesh.cells, self._weights, (steps, halves), strict=True
        ):
            alive = weights.sum(axis=2) > 1e-15  # the size of rounding
            moving, stretch = weights[alive], self.stretch[alive]
            for before, after in pairwise(times.tolist()):
                begin, end = stretch + speed * before, stretch + speed * after
                moving = cells.stepped(moving, begin, end, after - before)
            weights[alive] = moving
        self.stretch = self.stretch + speed * duration
        self.steady_for += duration

    def follow(self, speed: float, duration: float, spent: float = 0.0) -> Followed:
        """Advance, until less than the share `spent` holds; returns shares and forces on the way."""
        steady_for = self.steady_for if speed == self.speed else 0.0
        times, shares = self.mesh.steps(speed, steady_for, duration), [self.left()]
        for time in np.diff(times):
            self.advance(speed, float(time))
            shares.append(self.left())
            if (shares[-1][0] < spent).all():
                break
        return Followed(times[: len(shares)], np.array(shares))

    def left(self) -> Array:
        """Share of each strand that holds, and its force per contact born, shape (2, strands)."""
        coarse, fine = (weights.sum(axis=2) for weights in self._weights)
        missed = (fine - coarse) / 7.0  # the finer resolution has an eighth of the error
        self.error = max(self.error, float((np.abs(missed) @ self.share).max(initial=0.0)))
        holds = np.clip(fine + missed, 0.0, 1.0)
        return np.stack([holds @ self.share, (holds * self.stretch) @ self.share])

    def aged(self, speed: float, ages: Array) -> Strands:
        """Strands like this one, right after its birth, that have moved on at a speed for `ages` (n,)."""
        out, age = copy(self), 0.0
        out.stretch = np.empty((ages.size, *self.stretch.shape[1:]))
        out._weights = [np.empty((ages.size, *part.shape[1:])) for part in self._weights]
        for strand in np.argsort(ages):
            self.advance(speed, ages[strand] - age)
            age, out.stretch[strand] = ages[strand], self.stretch[0]
            for kept, now in zip(out._weights, self._weights, strict=True):
                kept[strand] = now[0]
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
        self._tables: list[tuple[float, BSpline]] = []
        for begin, end in pairwise(np.unique([0.0, np.clip(turn, 0.0, longest), longest]).tolist()):
            strands.steady_for = 0.0  # thresholds may have gathered right above |x|
            found = strands.follow(speed, end - begin, SPENT)
            self._tables.append((begin, found.over_root(found.left[:, 0, 0])))
            self.reach_lag, share = begin + float(found.times[-1]), float(found.left[-1, 0, 0])
            if share < SPENT:
                break
        self.error = share if share < SPENT else 0.0

    def survival(self, lag: Array) -> Array:
        """Share at times `lag` >= 0 since the birth, same shape."""
        out = np.zeros(lag.shape)
        for begin, spline in self._tables:
            here = (lag >= begin) & (lag <= self.reach_lag)
            root = np.sqrt(lag[here] - begin)
            out[here] = np.clip(spline(np.minimum(root, spline.t[-1])), 0.0, 1.0)
        return out
