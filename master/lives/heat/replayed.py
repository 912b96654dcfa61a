"""Lives of contacts that break at rates: the survival follows from the moves since their birth."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from master.lives.cold import NONE_LEFT
from master.lives.life import UnbentLife
from master.lives.stretches import Moves, averaged
from master.motion.motion import History, Legs
from origins import Contacts
from origins.laws.rate_law import RateLaw
from origins.start import Start
from origins.thresholds.law import Thresholds

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

# Factor on the measured error: near a root halving shows only two thirds of the error, and only some
# contacts are measured.
MARGIN = 4.0
# First number of pieces of the stretches at birth; and last coefficients below which they are not halved.
_PIECES, RESOLVED = 4, 1e-9


class ReplayedLife(UnbentLife):
    """A Life computed from all legs since the birth; each closure defines its own `_of`.

    Attributes as in Life. `left` measures `error` whenever it is called.

    Parameters
    ----------
    law : Thresholds
    edges : array of shape (n,)
        Of panels on which the law is smooth; none where there are only atoms.
    resolved : float
        Last coefficients to which averages over the stretches at birth are resolved.
    """

    pair_work, error = 6, 0.0

    def __init__(self, law: Thresholds, edges: Array, resolved: float = RESOLVED) -> None:
        self._law, self._resolved = law, resolved
        self.atoms, self._weights = law.atoms
        self.reach = min(float(law.support()[1]), float(law.isf(NONE_LEFT)))
        self.reach = max([self.reach, *self.atoms])
        marks = np.concatenate([law.breakpoints, self.atoms])
        self.bends: Array = np.unique(marks[(marks > 0.0) & (marks <= self.reach)])
        self.bend_sizes: Array = np.ones(self.bends.size)
        edges = edges[edges < self.reach]
        lost = -np.diff(law.sf(edges))
        many = lost.sum() > 0.0
        self.grain = float(np.diff(edges) @ lost / lost.sum()) if many else self.reach

    def atom_share(self, atom: float, stretch: float) -> float:
        """See Life; an upper bound, as heat may break some before."""
        return float(self._weights[self.atoms == atom].sum() / self._law.sf(abs(stretch)))

    def left(self, born: Start | Array, history: History) -> Array:
        """See Life."""
        moves, legs = Moves.of(history), history.legs()
        shape, count = legs.duration.shape[:-1], legs.speed.size
        displacement = legs.displacement.reshape(-1, count + 1)
        legs = Legs(displacement, legs.duration.reshape(-1, count), legs.speed)

        def inside(pair: Rows, stretch: Array) -> Array:
            side = moves.largest(pair, stretch)[:, stretch.shape[1] // 2, None]
            side = np.broadcast_to(side, stretch.shape).ravel()
            pairs = np.repeat(pair, stretch.shape[1])
            found = self._of(pairs, stretch.ravel(), side, moves, legs)
            return found.reshape(2, *stretch.shape)

        if not isinstance(born, Start) or born.is_single:
            every = np.arange(moves.now.size)
            single = born.mean() if isinstance(born, Start) else born
            stretch = np.broadcast_to(np.asarray(single, dtype=float), shape).ravel()
            side = moves.largest(every // shape[1] * shape[1] + shape[1] // 2, stretch)
            return self._of(every, stretch, side, moves, legs).reshape(2, *shape)
        given = born, moves, self.reach, self.bends, inside, self._resolved, _PIECES
        found = averaged(*given)
        self.error = max(self.error, MARGIN * float(found.missed[0]))
        return found.value.reshape(2, *shape)

    def _of(self, pair: Rows, born: Array, side: Array, moves: Moves, legs: Legs) -> Array:
        """Share and force of contacts of these pairs, born at these stretches; shape (2, n).

        side : array of shape (n,), the largest |x| that decides which exact thresholds are passed
        """
        raise NotImplementedError


def rates_of(contacts: Contacts) -> RateLaw:
    """The law by which contacts break below their thresholds; ValueError where there is none."""
    if contacts.thermal is None:
        raise ValueError("contacts without temperature break at their thresholds")
    return contacts.thermal.rates
