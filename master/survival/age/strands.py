"""Strands of contacts that age: groups born at any moments, whose thresholds are followed together."""

from collections.abc import Callable
from copy import copy
from itertools import pairwise

import numpy as np
from scipy.interpolate import make_interp_spline

from master.outcome import stop_after
from master.survival.age.cells import Cells
from origins.thresholds.law import Array

# Survival below which strands are not followed any more, and the degree of splines in time.
UNFOLLOWED, SPLINE = 1e-12, 5


class Strands:
    """Any number of strands: groups of contacts born together, each with its law of thresholds.

    The contacts of a strand were born at one or more stretches, its parts.

    cells : of two resolutions; the second one has an eighth of the first one's error
    born, share : arrays (parts,), stretches at birth, and weights of sum 1
    until : reading of time.monotonic() after which `advance` raises StoppedError
    dropped_below : share below which no part is followed any more; error : 0, as cells tell it (AgeingLife.cells)

    The attribute `stretch`, array (strands, parts), is that of now (lengths).
    """

    def __init__(self, cells: tuple[Cells, Cells], born: Array, share: Array) -> None:
        """Begin with one strand, of fresh thresholds."""
        self._cells, self._share, self.born, self.stretch = cells, share, born, born[None].copy()
        self._steady_for, self._speed = 0.0, np.nan
        self.until, self.dropped_below, self.error = np.inf, 1e-15, 0.0  # the size of rounding
        # arrays (strands, parts, cells) for both resolutions
        self._weights = [each.fresh(born)[None] for each in cells]

    def advance(self, speed: float, duration: float) -> None:
        """All strands move on at the speed dX/dt for a time."""
        if not duration:
            return
        stop_after(self.until)
        if speed != self._speed:
            self._speed, self._steady_for = speed, 0.0
        steps = self._cells[0].steps(speed, self._steady_for, duration)
        halves = np.sort(np.concatenate([steps, 0.5 * (steps[1:] + steps[:-1])]))
        alive = self._weights[1].sum(axis=2) > self.dropped_below
        stretch = self.stretch[alive]
        for cells, weights, times in zip(self._cells, self._weights, (steps, halves), strict=True):
            moving, weights[~alive] = weights[alive], 0.0
            for before, after in pairwise(times.tolist()):
                begin, end = stretch + speed * before, stretch + speed * after
                moving = cells.stepped(moving, begin, end, after - before)
            weights[alive] = moving
        self.stretch = self.stretch + speed * duration
        self._steady_for += duration

    def follow(self, speed: float, duration: float) -> tuple[Array, Array]:
        """Advance along a leg, until hardly any contact holds. Returns times since its beginning, shape (n,), and what
        is `survival_and_force` then, shape (n, 2, strands)."""
        # where a leg begins, thresholds may have gathered right above |x|: the first steps are short
        self._speed, self._steady_for = speed, 0.0
        times, shares = self._cells[0].steps(speed, 0.0, duration), [self.surviving_shares()]
        for time in np.diff(times):
            self.advance(speed, float(time))
            shares.append(self.surviving_shares())
            if (shares[-1][0] < UNFOLLOWED).all():
                break
        return times[: len(shares)], np.array(shares)

    def surviving_shares(self) -> Array:
        """Share of each strand that holds, and its force per contact born, shape (2, strands)."""
        coarse, fine = (weights.sum(axis=2) for weights in self._weights)
        # extrapolated: the finer resolution has an eighth of the error
        holds = np.clip(fine + (fine - coarse) / 7.0, 0.0, 1.0)
        return np.stack([holds, holds * self.stretch]) @ self._share

    def aged(self, speed: float, ages: Array) -> "Strands":
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


def over_root(times: Array, values: Array) -> Callable[[Array], Array]:
    """Values at times since a leg's beginning, shape (n, ...), between them as a spline over the root of
    the time, in which survivals are smooth; beyond the last time its values."""
    spline = make_interp_spline(np.sqrt(times), values, k=min(SPLINE, times.size - 1))
    return lambda t: np.asarray(spline(np.sqrt(np.clip(t, 0.0, times[-1]))))


def survival_at(strands: Strands, speed: float, longest: float) -> Callable[[Array], Array]:
    """Share that holds over the time since a birth up to `longest`, 0 below UNFOLLOWED, at one speed >= 0, of one
    strand of one part, right after its birth."""
    turn = -float(strands.stretch[0, 0]) / speed if speed > 0.0 else 0.0
    begins = np.unique([0.0, np.clip(turn, 0.0, longest), longest])
    # another table begins where |x| turns at 0
    legs = [strands.follow(speed, float(duration)) for duration in np.diff(begins)]
    tables = [over_root(times, left[:, 0, 0]) for times, left in legs]

    def survival(lag: Array) -> Array:
        out = np.zeros(lag.shape)
        for begin, table in zip(begins, tables, strict=False):
            here = lag >= begin
            out[here] = table(lag[here] - begin)
        return np.where(out < UNFOLLOWED, 0.0, np.minimum(out, 1.0))

    return survival
