"""Landscapes ruled by one wave: straight valleys with weak modulations along them.

For each place d along a valley let m(d) be the lowest energy across it. A path that stays in the valley to a copy of
the lowest minimum meets every d, so it climbs to max m at least, and the bed climbs no higher: the barrier is
max m - min m, where the ridges are higher still. This holds however weak the modulations are, and where they cancel
but for their squares.
"""

from math import gcd

import numpy as np

from origins.domains.critical_points import Landscapes, Whole
from origins.thresholds.law import Array

_RULED = 0.2
_POINTS = 32  # on each oscillation
_ACROSS = 8  # Newton steps towards the bed
_HALVINGS = 30
_TURN = 2.0 * np.pi


def ruled(land: Landscapes) -> np.ndarray:
    """Whether valleys have one bed each and are easier to follow than to leave, shape (landscapes,)."""
    largest = land.sizes.argmax(-1)
    along = land.waves[largest] @ land.waves.T / (land.waves[largest] ** 2).sum(-1)[:, None]
    others = land.sizes / land.sizes.max(-1, keepdims=True)
    others[np.arange(len(largest)), largest] = 0.0
    one_bed = ((others * np.abs(along)).sum(-1) < _RULED) & ((others * along**2).sum(-1) < _RULED)
    # beds lie at -1 + sum(others) at most, the ridges between valleys at 1 - sum(others) at least
    return one_bed & (others.sum(-1) < 1.0)


def along_valleys(land: Landscapes) -> tuple[Array, Array]:
    """(barrier, energy of the lowest minimum) of every landscape, all of them `ruled`, shape (landscapes,)."""
    barriers, lowest = np.empty(len(land.sizes)), np.empty(len(land.sizes))
    largest = land.sizes.argmax(-1)
    for ruler in np.unique(largest):
        own = np.flatnonzero(largest == ruler)
        wave = land.waves[ruler]
        beds = gcd(*(int(k) for k in wave))
        along = np.array([-wave[1], wave[0]]) / beds
        across = wave / (wave @ wave)
        least, most = np.empty((2, beds, own.size))
        for bed in range(beds):
            start = (np.pi * (2 * bed + 1) - land.phases[own, ruler])[:, None] * across
            least[bed], most[bed] = _extremes(land, own, start, along, wave)
        lowest[own] = least.min(0)
        # beds as low as one another may be climbed out of differently: the easiest counts
        climb = np.where(least <= lowest[own] + 1e-13, most - least, np.inf)
        barriers[own] = climb.min(0)
    return barriers, lowest


def lowest_of_parallel(land: Landscapes) -> Array:
    """Lowest energy of landscapes whose waves are all parallel, shape (landscapes,)."""
    along = land.waves[0] / gcd(*(int(k) for k in land.waves[0]))
    which = np.arange(len(land.sizes))
    return _extremes(land, which, np.zeros((which.size, 2)), along, None)[0]


def _extremes(
    land: Landscapes, which: Whole, start: Array, along: Array, across: Array | None
) -> tuple[Array, Array]:
    """Least and greatest energy on the line start + d along, at each d the lowest in the direction `across`."""

    def settle(own: Whole, t: Array) -> tuple[Array, Array]:
        """Energy and slope along the line at the bed beside t."""
        if across is not None:
            push = land.waves @ across
            for _ in range(_ACROSS):
                sin, cos = _waves(land, own, t)
                t = t - ((sin @ push) / (cos @ (push * push)))[..., None] * across
        sin, cos = _waves(land, own, t)
        return cos.sum(-1), -(sin @ (land.waves @ along))

    # everything on the line repeats after one turn of d, and wavers no faster than its fastest wave
    count = _POINTS * max(1, int(np.abs(land.waves @ along).max()))
    d = _TURN * np.arange(count) / count
    t = start[:, None] + d[:, None] * along
    energy, slope = settle(np.repeat(which, count), t.reshape(-1, 2))
    energy, slope = energy.reshape(-1, count), slope.reshape(-1, count)
    found = []
    for sign in (1.0, -1.0):
        before, after = np.roll(sign * energy, 1, axis=-1), np.roll(sign * energy, -1, axis=-1)
        place, spot = np.nonzero((sign * energy <= before) & (sign * energy <= after))
        step = np.where(sign * slope[place, spot] > 0.0, -_TURN / count, _TURN / count)
        low, high = np.zeros(place.size), step
        best = sign * energy[place, spot]
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            here = start[place] + (d[spot] + middle)[:, None] * along
            value, rise = settle(which[place], here)
            best = np.minimum(best, sign * value)
            ahead = sign * rise * step < 0.0
            low, high = np.where(ahead, middle, low), np.where(ahead, high, middle)
        extreme = np.full(which.size, np.inf)
        np.minimum.at(extreme, place, best)
        found.append(sign * extreme)
    return found[0], found[1]


def _waves(land: Landscapes, which: Whole, t: Array) -> tuple[Array, Array]:
    angle = t @ land.waves.T + land.phases[which]
    return land.sizes[which] * np.sin(angle), land.sizes[which] * np.cos(angle)
