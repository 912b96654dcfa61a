"""Contacts whose thresholds grow with their age, as coalescing grains do (paper, Sec. VI).

Each contact keeps its quantile for life. It breaks where the hazard H(|x|; age) of the law of
thresholds at its age reaches that of its quantile, so that of those that pinned together

    share left = exp(-(H_worst - H_0)),      H_worst = the largest H since the birth,

H_0 being that of contacts which stand stretched at t = 0. On a straight leg H first falls, while
the contact relaxes or its threshold outgrows the stretch, and then rises: it is largest at an end.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from master.lives.life import UnbentLife
from master.lives.stretch_rule import finite_density, stretch_panels
from master.motion.motion import History, Legs
from origins import Contacts, GrainContact
from origins.grains.lifshitz_slyozov import hazard_beyond
from origins.start import Start
from origins.thresholds.quadrature import gauss

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

# Hazard above which the survival e^-H is below 1e-17: nothing to speak of holds.
GONE = 39.2
# Bisections that find a stretch to one part in 1e15 of its panel.
BISECTIONS = 50
# Length over which survivals are resolved, in standard deviations of the thresholds at first.
GRAIN = 0.25
# Share of contacts by which the sums over the starting stretches may be off.
ERROR = 5e-14


class GrainLife(UnbentLife):
    """Life (see master.lives.life) of contacts with growing grains, without heat.

    Parameters
    ----------
    contacts : Contacts
        With `grains`.
    longest : float
        Time > 0 after which no contact is looked at any more.

    Contacts born at t = 0 with the law `contacts.start` itself, that very object, have their
    grains' starting age; all others pin as they are born, at the stretch 0, an age of tau_m.
    """

    error, fresh_start = ERROR, False
    # of a start's panels, every so many are one
    every = 1

    def __init__(self, contacts: Contacts, longest: float) -> None:
        grains = contacts.grains
        assert grains is not None and grains.age is not None
        self.grains: GrainContact = grains
        self.start = contacts.start
        self.start_since = grains.age - grains.growth.first_pinning_time
        self.reach = float(grains.quantile(-np.expm1(-GONE), grains.age + longest))
        # the start reaches as far as its youngest thresholds do
        self.start_reach = grains.at_start.support()[1]
        self.grain = GRAIN * grains.at_start.std()

    def left(self, born: Start | Array, history: History) -> Array:
        """Share of contacts that hold, and their force per contact born; see Life.left."""
        return self._told(born, history.legs())

    def _told(self, born: Start | Array, legs: Legs) -> Array:
        """Share and force, shape (2, rows, columns)."""
        shape, knots = legs.displacement.shape[:-1], legs.displacement.shape[-1]
        moves = Legs(
            legs.displacement.reshape(-1, knots), legs.duration.reshape(-1, knots - 1), legs.speed
        )
        count = moves.displacement.shape[0]
        row, since, lost = np.arange(count), self.start_since, np.zeros(1)
        nodes, weights = np.zeros((count, 1)), np.ones((count, 1))
        if not isinstance(born, Start) and np.any(born):
            nodes = np.broadcast_to(born, shape).reshape(-1, 1)
        elif born is not self.start:  # births are at 0
            since, lost = 0.0, np.broadcast_to(self._lost(legs), shape).ravel()
        elif born.is_single:
            nodes = np.full((count, 1), born.mean())
        else:
            row, low, high = self._panels(moves)
            nodes, weights = gauss(low, high)
            weights = weights * finite_density(born, nodes)
        stretch = self._stretches(nodes, row, moves).reshape(-1, knots)
        own = Legs(stretch, np.repeat(moves.duration[row], nodes.shape[1], axis=0), moves.speed)
        hazards = self._hazards(stretch, since, own)
        # contacts whose thresholds were met at first never hold
        met = ~np.isfinite(hazards[:, 0])
        before = np.where(met, 0.0, hazards[:, 0])
        worst = np.where(met, np.inf, np.maximum(hazards.max(axis=-1), lost))
        hold = self._share(own, since, worst, before).reshape(nodes.shape) * weights
        parts = np.stack([hold, hold * stretch[:, -1].reshape(nodes.shape), weights]).sum(axis=-1)
        share, force, weight = (np.bincount(row, part, minlength=count) for part in parts)
        return np.stack([share / weight, force / weight]).reshape(2, *shape)

    def _share(self, moves: Legs, since: float, worst: Array, before: Array) -> Array:
        """Share that holds of contacts with these moves (their stretches), array (n,).

        since : time between pinning and the first of them
        worst, before : arrays (n,), the largest hazard so far and the one at first
        """
        return np.exp(before - worst)

    def _hazards(self, stretch: Array, since: float, legs: Legs) -> Array:
        """H at the beginning of the first leg and at the end of each; shape of stretch (n, k + 1)."""
        elapsed = np.cumsum(legs.duration, axis=-1)
        first = np.zeros((*elapsed.shape[:-1], 1))
        return pinned_hazard(self.grains, stretch, since + np.concatenate([first, elapsed], -1))

    def _lost(self, legs: Legs) -> Array:
        """H as contacts pin: some are stretched faster than their thresholds grow from 0 on.

        Array of shape (rows, 1): all births of a row lie on one leg.
        """
        rows, columns = legs.duration.shape[:2]
        lived = legs.duration[:, columns // 2] > 0.0
        birth = np.where(lived.any(axis=-1), np.argmax(lived, axis=-1), legs.speed.size - 1)
        hazard = [self.grains.lost_hazard(abs(float(speed))) for speed in legs.speed]
        return np.array(hazard)[birth].reshape(rows, 1)

    def _panels(self, moves: Legs) -> tuple[Rows, Array, Array]:
        """Rows of `moves`, and panels of starting stretches with one worst moment each.

        Where another moment becomes the worst the share left bends, so panels end there.
        """
        within = (-self.start_reach, self.start_reach)
        edges = np.clip(stretch_panels(self.start)[:: self.every], *within)
        edges = np.unique(np.append(edges, np.clip(self.start.span[1], *within)))
        count = moves.displacement.shape[0]
        grid = np.broadcast_to(edges, (count, edges.size))
        worst = self._worst_moment(grid, np.arange(count), moves)
        row, panel = np.nonzero(worst[:, 1:] != worst[:, :-1])
        low, high, old = edges[panel], edges[panel + 1], worst[row, panel]
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            same = self._worst_moment(middle[:, None], row, moves)[:, 0] == old
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        cuts = np.array(grid[:, 1:])
        cuts[row, panel] = low
        ends = np.sort(np.concatenate([grid, cuts], axis=1), axis=1)
        row, panel = np.nonzero(np.diff(ends, axis=1) > 0.0)
        return row, ends[row, panel], ends[row, panel + 1]

    def _stretches(self, start: Array, row: Rows, moves: Legs) -> Array:
        """Stretches along the moves of the rows (n,), from start (n, m); shape (n, m, k + 1)."""
        return np.asarray(start[..., None] + moves.displacement[row][:, None])

    def _worst_moment(self, start: Array, row: Rows, moves: Legs) -> Rows:
        """Number of the moment at which H of contacts that started at start (n, m) is largest."""
        own = Legs(moves.displacement, moves.duration[row][:, None], moves.speed)
        hazards = self._hazards(self._stretches(start, row, moves), self.start_since, own)
        return np.argmax(hazards, axis=-1)


def pinned_hazard(grains: GrainContact, stretch: Array, since: Array) -> Array:
    """-ln of the fraction of contacts with thresholds above |stretch|, `since` after they pinned.

    GrainContact.hazard, told by the time since pinning, so that no digit is lost right after it.
    Stretches (lengths) and times broadcast; infinite where no threshold is as large.
    """
    stretch, since = np.broadcast_arrays(stretch, since)
    excess = np.expm1(np.log1p(since / grains.growth.first_pinning_time) / 3.0)
    scaled = np.sqrt(grains.growth.B) * np.abs(stretch)
    over = scaled * (scaled / (1.0 + np.hypot(1.0, scaled)))  # of the grain that breaks
    room = excess - over
    out = np.where(over > 0.0, np.inf, 0.0)
    held = (room > 0.0) & (over > 0.0)
    largest = 1.0 + excess[held]
    q = over[held] / excess[held] * (largest / room[held])
    out[held] = hazard_beyond(q, 1.0 / largest, excess[held] / largest)
    return out
