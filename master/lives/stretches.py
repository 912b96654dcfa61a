"""Averages over the stretches at birth: integrals over pieces on which nothing bends."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.lives.halving import Integrals, Pieces, integrals
from master.lives.stretch_rule import StretchRule, stretch_rule
from master.motion.motion import History
from origins.start import Start
from origins.thresholds.quadrature import finite_density

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

# Last coefficients at which pieces are no longer halved, unless said otherwise.
RESOLVED = 1e-9
# Nodes of the two Gauss rules of a law that are tried before it is cut into pieces
_MANY, _FEWER = 14, 9
# Difference of the two, in units of what pieces are resolved to: a table of the average, which is far
# more accurate, would follow larger ones.
_AGREED = 1e-3
_NARROW = 1e-13  # share of the span: narrower pieces hold no weight


class Moves(NamedTuple):
    """What pairs of a birth and a later moment have in common, whatever the stretch at birth.

    now, high, low : arrays of shape (n,), the slider's displacement, its largest and smallest value
    """

    now: Array
    high: Array
    low: Array

    @classmethod
    def of(cls, history: History) -> Moves:
        """Of all rows and columns, flat."""
        parts = np.broadcast_arrays(history.now, history.high, history.low)
        return cls(*(part.ravel() for part in parts))

    def largest(self, pair: Rows, born: Array) -> Array:
        """Largest |x| of contacts born at `born`; shape (n,) or (n, k) as `born`."""
        columns = (slice(None),) + (None,) * (born.ndim - 1)
        high, low = self.high[pair][columns], self.low[pair][columns]
        return np.maximum(np.abs(born), np.maximum(born + high, -(born + low)))


# Share and force of pairs, by their numbers (n,), born at stretches of shape (n, k); (2, n, k)
Left = Callable[[Rows, Array], Array]


class Average:
    """Averages of what is left over a law of stretches at birth.

    Parameters
    ----------
    law : Start
        With a density.
    reach : float
        Length: no contact beyond it holds.
    bends : array of shape (n,)
        The largest |x| at which what is left bends.
    resolved : float
        Last coefficients at which pieces are no longer halved.
    pieces : int
        Of the law's span, to begin with.
    smooth : bool
        Whether Gauss rules of the law are tried first. They take a tenth of the nodes that pieces
        take, and two of them agree where what is left is smooth over all stretches.
    """

    def __init__(
        self, law: Start, reach: float, bends: Array, resolved: float, pieces: int, smooth: bool
    ) -> None:
        self.law, self._resolved, self._pieces, self._reach = law, resolved, pieces, reach
        # beyond the reach none holds: a piece that lies across would be told by its middle alone
        self._bends = np.append(bends, reach)
        self._rules: list[StretchRule] = []
        if smooth:
            self._rules = [stretch_rule(law, np.inf, count) for count in (_MANY, _FEWER)]

    def of(self, moves: Moves, left: Left) -> Integrals:
        """Share and force, shape (2, pairs), and what they miss.

        left : asked for stretches of which each row lies within one smooth piece
        """
        every = np.arange(moves.now.size)
        if not self._rules:
            return self._by_pieces(moves, every, left)
        found, agreed = self._by_rules(moves, every, left)
        some = np.flatnonzero(~agreed)
        missed = np.full(2, _AGREED * self._resolved)
        if some.size:
            by_pieces = self._by_pieces(moves, some, left)
            found[:, some], missed = by_pieces.value, np.maximum(missed, by_pieces.missed)
        return Integrals(found, missed)

    def _by_rules(
        self, moves: Moves, every: Rows, left: Left
    ) -> tuple[Array, npt.NDArray[np.bool_]]:
        """The averages by the rule of more nodes, and where that of fewer agrees.

        Bends beyond the outermost nodes are seen by neither.
        """
        many, fewer = self._rules
        split, ends = many.stretch.size, many.stretch[[0, -1]]
        nodes = np.concatenate([many.stretch, fewer.stretch])
        values = left(every, np.tile(nodes, (every.size, 1)))
        found = values[..., :split] @ many.weight
        change = np.abs(found - values[..., split:] @ fewer.weight)
        cuts = self._moving(moves)
        beyond = np.where(cuts < ends[0], self.law.cdf(cuts), 0.0)
        beyond = np.where(cuts > ends[1], self.law.sf(cuts), beyond).max(axis=1)
        off = np.max([change[0], change[1] / self._reach, beyond], axis=0)
        return found, off <= _AGREED * self._resolved

    def _by_pieces(self, moves: Moves, some: Rows, left: Left) -> Integrals:
        """The averages of some pairs by pieces.

        They end where x is 0, and where the largest |x| changes sides or meets a bend.
        """
        law, reach, bends = self.law, self._reach, self._bends
        first, last = max(law.span[0], -reach), min(law.span[1], reach)
        even = np.linspace(first, last, self._pieces + 1)
        fixed = np.concatenate([even, law.breakpoints, np.zeros(1), bends, -bends])
        moving = self._moving(Moves(*(part[some] for part in moves)))
        cuts = np.concatenate([np.tile(fixed, (some.size, 1)), moving], axis=1)
        edges = np.sort(np.clip(cuts, first, last), axis=1)
        row, piece = np.nonzero(np.diff(edges, axis=1) > _NARROW * (last - first))
        pieces = Pieces(row, edges[row, piece], edges[row, piece + 1])
        middle = 0.5 * (pieces.low + pieces.high)
        pieces = pieces.pick(moves.largest(some[row], middle) < reach)
        kept = law.cdf(reach) - law.cdf(-reach)

        def weighed(row: Rows, born: Array) -> Array:
            return left(some[row], born) * (finite_density(law, born) / kept)

        return integrals(weighed, pieces, some.size, self._resolved)

    def _moving(self, moves: Moves) -> Array:
        """The stretches at birth at which what is left bends, as they depend on the moves."""
        now, high, low = (part[:, None] for part in moves)
        turned = [-now, -high, -low, -0.5 * high, -0.5 * low, -0.5 * (high + low)]
        return np.concatenate([*turned, self._bends - high, -self._bends - low], axis=1)
