"""Averages over the stretches at birth: a sum over pieces on which nothing bends."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.lives.stretch_rule import StretchRule, stretch_rule
from master.motion.motion import History
from origins.start import Start

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

# Gauss nodes of a piece, on (0, 1), and the last two Legendre coefficients from values at them
_SIZE = 12
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(_SIZE)
_LAST = np.linalg.inv(np.polynomial.legendre.legvander(_NODES, _SIZE - 1))[-2:].T
_NODES, _WEIGHTS = 0.5 * (_NODES + 1.0), 0.5 * _WEIGHTS
# A sum over Gauss nodes is wrong by about the square of the last coefficient where all is smooth;
# beside an onset of P_c, where it is not, by some 1e-3 of it
RESOLVED = 1e-9
# Nodes of the two Gauss rules of a law that are tried before it is cut into pieces
_MANY, _FEWER = 14, 9
# Difference of the two, in units of what pieces are resolved to: a table of the average, which is far
# more accurate, would follow larger ones.
_AGREED = 1e-3
_HALVINGS = 40
PIECES = 16  # of a law's span to begin with: twelve nodes then resolve a Gaussian to 8 widths
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


def averaged(
    law: Start,
    moves: Moves,
    reach: float,
    bends: Array,
    left: Left,
    resolved: float = RESOLVED,
    pieces: int = PIECES,
) -> Array:
    """Share and force averaged over the law's stretches below `reach`; shape (2, pairs).

    left : asked for stretches of which each row lies within one smooth piece
    resolved : last coefficients at which pieces are no longer halved
    pieces : of the law's span to begin with
    """
    begin = _pieces(law, moves, reach, bends, pieces)
    return _summed(begin, law, reach, moves.now.size, left, resolved)


class _Tried(NamedTuple):
    """found : array of shape (2, n), an average; agreed : of shape (n,), whether it is good."""

    found: Array
    agreed: npt.NDArray[np.bool_]


class Rules(NamedTuple):
    """Two Gauss rules of a law of stretches, the one of fewer nodes last.

    They take a tenth of the nodes that pieces take, and agree where what is left of contacts is
    smooth over all stretches at birth.
    """

    many: StretchRule
    fewer: StretchRule

    @classmethod
    def of(cls, law: Start) -> Rules:
        """The rules of a law with a density."""
        return cls(*(stretch_rule(law, np.inf, count) for count in (_MANY, _FEWER)))

    def averaged(
        self, law: Start, moves: Moves, reach: float, bends: Array, left: Left, resolved: float
    ) -> _Tried:
        """The average over stretches by the larger rule, and where the fewer nodes agree.

        Bends beyond the outermost nodes are seen by neither.
        """
        pair, split = np.arange(moves.now.size), self.many.stretch.size
        nodes = np.concatenate([self.many.stretch, self.fewer.stretch])
        values = left(pair, np.tile(nodes, (pair.size, 1)))
        found = values[..., :split] @ self.many.weight
        change = np.abs(found - values[..., split:] @ self.fewer.weight)
        agreed = np.maximum(change[0], change[1] / reach) <= _AGREED * resolved
        cuts = np.concatenate(_moving(moves, np.append(bends, reach)), axis=1)
        above, below = cuts > self.many.stretch.max(), cuts < self.many.stretch.min()
        unseen = np.where(above, law.sf(cuts), np.where(below, law.cdf(cuts), 0.0))
        return _Tried(found, agreed & (unseen.max(axis=1) <= _AGREED * resolved))


def missed(
    law: Start,
    moves: Moves,
    reach: float,
    bends: Array,
    left: Left,
    found: Array,
    one_of: int,
    resolved: float = RESOLVED,
) -> float:
    """By how much `found`, the averages over the stretches, change where all pieces are halved.

    one_of : of so many averages one is looked at
    """
    some = np.arange(moves.now.size // 2 % one_of, moves.now.size, one_of)
    pair, low, high = _pieces(law, Moves(*(part[some] for part in moves)), reach, bends)
    middle = 0.5 * (low + high)
    halves = _Pieces(np.tile(pair, 2), np.append(low, middle), np.append(middle, high))

    def of_some(pair: Rows, stretch: Array) -> Array:
        return left(some[pair], stretch)

    again = _summed(halves, law, reach, some.size, of_some, resolved)
    return float(np.abs(again - found[:, some])[0].max(initial=0.0))


class _Pieces(NamedTuple):
    """Pieces of the stretches of pairs, from low to high; arrays of shape (n,)."""

    pair: Rows
    low: Array
    high: Array


def _pieces(law: Start, moves: Moves, reach: float, bends: Array, pieces: int = PIECES) -> _Pieces:
    """Where what is left bends: x is 0, or the largest |x| changes sides or meets a bend."""
    first, last = max(law.span[0], -reach), min(law.span[1], reach)
    even = np.linspace(first, last, pieces + 1)
    # beyond the reach none holds: a piece that lies across would be told by its middle alone
    bends = np.append(bends, reach)
    fixed = [even, law.breakpoints, np.zeros(1), bends, -bends]
    cuts = [np.tile(np.concatenate(fixed), (moves.now.size, 1)), *_moving(moves, bends)]
    edges = np.sort(np.clip(np.concatenate(cuts, axis=1), first, last), axis=1)
    pair, piece = np.nonzero(np.diff(edges, axis=1) > _NARROW * (last - first))
    begin, end = edges[pair, piece], edges[pair, piece + 1]
    alive = moves.largest(pair, 0.5 * (begin + end)) < reach
    return _Pieces(pair[alive], begin[alive], end[alive])


def _moving(moves: Moves, bends: Array) -> list[Array]:
    """The stretches at birth at which what is left bends, as they depend on the moves; (pairs, k)."""
    now, high, low = (part[:, None] for part in moves)
    turned = [-now, -high, -low, -0.5 * high, -0.5 * low, -0.5 * (high + low)]
    return [*turned, bends - high, -bends - low]


def _summed(
    pieces: _Pieces, law: Start, reach: float, pairs: int, left: Left, resolved: float
) -> Array:
    """The sum over the pieces, which are halved until a polynomial follows on each."""
    pair, low, high = pieces
    kept = law.cdf(reach) - law.cdf(-reach)
    out = np.zeros((2, pairs))
    for halving in range(_HALVINGS):
        length = (high - low)[:, None]
        born = low[:, None] + length * _NODES
        values = left(pair, born) * (law.pdf(born) * length / kept)
        rough = np.abs(values[0] @ _LAST).max(axis=1, initial=0.0) > resolved
        if halving == _HALVINGS - 1:
            rough[:] = False
        for kind in (0, 1):
            sums = values[kind, ~rough] @ _WEIGHTS
            out[kind] += np.bincount(pair[~rough], sums, minlength=pairs)
        pair, low, high = pair[rough], low[rough], high[rough]
        if not pair.size:
            break
        middle = 0.5 * (low + high)
        pair, low, high = np.tile(pair, 2), np.append(low, middle), np.append(middle, high)
    return out
