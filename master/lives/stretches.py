"""Averages over the stretches at birth: integrals over pieces on which the survival is smooth."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.lives.halving import Integrals, Pieces, integrals
from master.motion.motion import History
from origins.start import Start
from origins.thresholds.quadrature import finite_density

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

# Pieces narrower than this share of the span are left out.
_NARROW = 1e-13


class Moves(NamedTuple):
    """Motion of the slider between birth and a later moment, for many pairs of these two.

    now, high, low : arrays of shape (n,), the slider's displacement, its largest and smallest value
    """

    now: Array
    high: Array
    low: Array

    @classmethod
    def of(cls, history: History) -> Moves:
        """The moves of all rows and columns of a history, flattened."""
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
    resolved: float,
    pieces: int,
) -> Integrals:
    """Share and force averaged over the law's stretches, shape (2, pairs), and their errors.

    Pieces of the law end where x is 0, and where the largest |x| changes sides or meets a bend.

    reach : length: no contact beyond it holds
    bends : array of shape (n,), the largest |x| at which the survival has a bend
    left : called with stretches of which each row lies within one smooth piece
    resolved : last coefficients below which pieces are not halved
    pieces : first number of pieces of the law's span
    """
    # cut at the reach, beyond which no contact holds, as each piece is judged by its middle
    bends = np.append(bends, reach)
    first, last = max(law.span[0], -reach), min(law.span[1], reach)
    even = np.linspace(first, last, pieces + 1)
    fixed = np.concatenate([even, law.breakpoints, np.zeros(1), bends, -bends])
    now, high, low = (part[:, None] for part in moves)
    moving = [-now, -high, -low, -0.5 * high, -0.5 * low, -0.5 * (high + low)]
    cuts = [np.tile(fixed, (now.size, 1)), *moving, bends - high, -bends - low]
    edges = np.sort(np.clip(np.concatenate(cuts, axis=1), first, last), axis=1)
    pair, piece = np.nonzero(np.diff(edges, axis=1) > _NARROW * (last - first))
    found = Pieces(pair, edges[pair, piece], edges[pair, piece + 1])
    found = found.pick(moves.largest(pair, 0.5 * (found.low + found.high)) < reach)
    kept = law.cdf(reach) - law.cdf(-reach)

    def weighed(pair: Rows, born: Array) -> Array:
        return left(pair, born) * (finite_density(law, born) / kept)

    return integrals(weighed, found, now.size, resolved)
