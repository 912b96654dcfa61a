"""Contacts that break by heat at rates of any form, closure "exact": A of a strand in cells of thresholds.

A, the integral of the rate h(|x|; x_s) over time, is kept at the ends of cells; between them e^-A is
taken as linear. Where the largest |x| lies within a cell, only contacts with thresholds above it
hold: there e^-A is extrapolated linearly from the next cell.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import numpy.typing as npt

from master.lives.cold import TIE
from master.lives.heat.above import law_edges
from master.lives.heat.replay import rates_of
from master.soft.in_time.heat import reach_of, replay_of, scales_of
from master.soft.in_time.memory import FEW_STARTS, MORE_STARTS, Leg, Memory
from origins import Contacts
from origins.errors import InputError
from origins.laws.rate_law import RateLaw

Array = npt.NDArray[np.float64]

# Fewest cells of a panel of the law on the coarsest level, and largest change of ln h over a cell,
# evaluated at these shares of a threshold; share of the contacts beyond the ends of all cells.
CELLS, CHANGE, LOOKS, TAIL = 4, 1.25, np.array([0.0, 0.5, 0.9]), 1e-14
# Most cells on the coarsest level: colder contacts would need more, and steps would take too long.
MOST_CELLS = 8_000


class SpentMemory(Memory):
    """Keeps A at the ends of cells, which are halved with each level; errors are of second order.

    Raises InputError where the temperature is so low that too many cells are needed.
    """

    error = 0.0

    def __init__(self, contacts: Contacts, level: int) -> None:
        self._law, self._rates = contacts.thresholds, rates_of(contacts)
        linked = contacts.stiffness == "linked"
        self._stiffness = contacts.relative_stiffness if linked else None
        self._edges = _cells(contacts, self._rates, level)
        self._beyond, self._kappa = (
            self._law.sf(self._edges),
            contacts.relative_stiffness(self._edges),
        )
        self.width, self.starts = self._edges.size, FEW_STARTS + MORE_STARTS * level
        self.reach, self.scales = reach_of(contacts), scales_of(contacts)

    def advance(self, kept: Array, leg: Leg) -> Array:
        """See Memory."""
        if not leg.duration:
            return kept
        replay = replay_of(leg, self._rates, self._stiffness)
        at = np.maximum(self._edges, leg.furthest[:, None])
        return np.asarray(kept + replay.spent(np.arange(leg.end.size), at))

    def left(self, kept: Array, stretch: Array, furthest: Array) -> Array:
        """See Memory."""
        edges, survived = self._edges, np.exp(-kept)
        # the cell in which the largest |x| lies
        cut = np.clip(np.searchsorted(edges, furthest, "right") - 1, 0, edges.size - 3)
        inside, every = furthest > edges[cut], np.arange(cut.size)
        # the narrow cell of an exact threshold has no meaningful slope
        next_width = edges[cut + 2] - edges[cut + 1]
        next_width[next_width < 1e-9 * edges[cut + 2]] = np.inf
        weight = np.minimum(self._law.sf(furthest * (1.0 + TIE))[:, None], self._beyond[:-1])
        weight = np.maximum(weight - self._beyond[1:], 0.0)
        sums = []
        for each in (survived, survived * self._kappa):
            mean = 0.5 * (each[:, 1:] + each[:, :-1])
            near, far = each[every, cut + 1], each[every, cut + 2]
            slope = (far - near) / next_width
            onward = np.clip(near - 0.5 * (edges[cut + 1] - furthest) * slope, 0.0, None)
            mean[every, cut] = np.where(inside, onward, mean[every, cut])
            sums.append((weight * mean).sum(axis=1))
        return np.stack([sums[0], stretch * sums[1]])


def _cells(contacts: Contacts, rates: RateLaw, level: int) -> Array:
    """Edges of the cells: the law's panels, cut so that ln h changes little over each cell."""
    law = contacts.thresholds
    ends = np.append(
        np.clip(law_edges(law), float(law.ppf(TAIL)), float(law.isf(TAIL))), reach_of(contacts)
    )
    # a very narrow cell for each exact threshold
    ends = np.unique(
        np.concatenate([ends, *(law.atoms[0] * (1.0 + k * TIE) for k in (-2.0, -0.5, 0.5))])
    )
    pieces: list[Array] = []
    for low, high in pairwise(ends.tolist()):
        near = np.array([[max(low, 1e-3 * high)], [high]])
        levels = rates.log_rate(LOOKS * near[0], near, contacts.relative_stiffness(near))
        count = max(CELLS, int(np.ceil(np.abs(np.diff(levels, axis=0)).max() / CHANGE)))
        pieces.append(np.linspace(low, high, count * 2**level + 1)[:-1])
    edges = np.append(np.concatenate(pieces), ends[-1])
    if edges.size > MOST_CELLS * 2**level:
        raise InputError(
            f"thermal: contacts of {rates.name} rates that break within so thin a skin of "
            "thresholds are not followed under a spring; take a higher temperature"
        )
    return edges
