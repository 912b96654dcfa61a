"""Contacts with growing grains at a temperature: each keeps its quantile, and may break early.

A contact whose quantile has the hazard η has the threshold x_s(η; age) at each age. Of the contacts
born together the share

    integral over η > H_worst of e^{-(η - H_0)} e^{-A(η)},      A(η) = integral of h(|x|; x_s) dt,

still holds, with H_worst and H_0 as in master.lives.grains. h is largest at the ends of legs: right
after the birth, when thresholds are small, and where the stretch comes near the threshold.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.lives.grains import GONE, GrainLife
from master.lives.growing_thresholds import GrowingThresholds
from master.lives.halving import Pieces, integrals
from master.motion.motion import History, Legs
from origins import Contacts
from origins.start import Start

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

# Sums over quantiles have the variable (η - H_worst)^(1/2): edges of their first pieces, and last
# coefficients below which pieces are not halved.
ROOTS, RESOLVED = np.array([0.0, 0.5, 2.0, GONE**0.5]), 1e-8
# Largest A; e^-A is 0 there.
SPENT = 700.0


# Numbers of moments on a leg, tried in this order until the share changes by no more than the
# accuracy: colder contacts break within ever shorter parts of a leg.
MOMENTS = (51, 101, 201, 401)
ACCURACY = 1e-7
# Factor on the measured change, as not all ages are measured; and the error of the table.
MARGIN, TABLE_ERROR = 4.0, 3e-11


class Moved(NamedTuple):
    """Straight moves on which stretches do not change their sign, arrays (pieces,).

    owner : numbers of the contacts, rising; begin, end : stretches (lengths); since : time from pinning
    to the beginning; duration : time
    """

    owner: Rows
    begin: Array
    end: Array
    since: Array
    duration: Array


class WarmGrainLife(GrainLife):
    """Life (see master.lives.life) of contacts with growing grains and heat.

    Parameters
    ----------
    contacts : Contacts
        With `grains` and `thermal`.
    longest : float
        See GrainLife.
    accuracy : float
        Change of the share that holds below which no finer nodes are tried.

    Attributes
    ----------
    error : float
        Measured: the first, middle and last rows and columns are computed with two numbers of moments.
    """

    # with this `resolved` normal laws are summed to 1e-8
    pair_work, pieces, resolved = 1000, 4, 1e-5

    def __init__(self, contacts: Contacts, longest: float, accuracy: float = ACCURACY) -> None:
        super().__init__(contacts, longest)
        assert contacts.thermal is not None
        self._accuracy = accuracy
        self.thermal, self._fineness = contacts.thermal, 0
        self.error = TABLE_ERROR
        self.thresholds = GrowingThresholds(self.grains, self.start_since + longest)

    def left(self, born: Start | Array, history: History) -> Array:
        """Share of contacts that hold, and their force per contact born; see Life.left."""
        legs = history.legs()
        rows, columns = (np.unique([0, n // 2, n - 1]) for n in legs.displacement.shape[:2])
        looked = np.ix_(rows, columns)
        some = Legs(legs.displacement[looked], legs.duration[looked], legs.speed)
        coarse = self._told(born, some)
        for fineness in range(self._fineness + 1, len(MOMENTS)):
            self._fineness = fineness
            fine = self._told(born, some)
            off, coarse = float(np.abs(fine[0] - coarse[0]).max(initial=0.0)), fine
            if off <= self._accuracy:
                break
        self._fineness -= 1  # the coarser of two that agree
        self.error = max(self.error, MARGIN * off)
        return self._told(born, legs)

    def _share(self, moves: Legs, since: float, worst: Array, before: Array) -> Array:
        """See GrainLife."""
        out, alive = np.zeros(worst.size), np.flatnonzero(worst - before < GONE)
        if not alive.size:
            return out
        moments = MOMENTS[self._fineness]

        def held(row: Rows, roots: Array) -> Array:
            some = alive[row]
            own = Legs(moves.displacement[some], moves.duration[some], moves.speed)
            spent = self._spent(_pieces(own, since), worst[some], roots, moments)
            share = 2.0 * np.exp(-roots * roots - spent)
            # the weight is 0 at H_worst; halving is decided by the integrand without it
            return np.stack([share * roots.max(axis=1, keepdims=True), share * roots])

        row, piece = np.divmod(np.arange(alive.size * (ROOTS.size - 1)), ROOTS.size - 1)
        pieces = Pieces(row, ROOTS[piece], ROOTS[piece + 1])
        found = integrals(held, pieces, alive.size, RESOLVED)
        self.error = max(self.error, MARGIN * float(found.missed[1]))
        out[alive] = found.value[1] * np.exp(before[alive] - worst[alive])
        return out

    def _spent(self, pieces: Moved, worst: Array, roots: Array, moments: int) -> Array:
        """A of quantiles with the hazards worst + roots², shape of `roots` (n, m)."""
        out = np.zeros(roots.shape)
        if not pieces.owner.size:
            return out
        place, weight = _towards_ends(moments)
        at = pieces.since[:, None] + pieces.duration[:, None] * place
        stretch = pieces.begin[:, None] + (pieces.end - pieces.begin)[:, None] * place
        hazard = (worst[:, None] + roots * roots)[pieces.owner]
        limit = self.thresholds.each(hazard, at)
        rate = self.thermal.plain_rate(np.minimum(np.abs(stretch)[:, :, None], limit), limit)
        spent = (weight @ rate) * pieces.duration[:, None]
        first = np.flatnonzero(np.diff(pieces.owner, prepend=-1))
        out[pieces.owner[first]] = np.add.reduceat(spent, first, axis=0)
        return np.minimum(out, SPENT)


class Rule(NamedTuple):
    """Places on (0, 1) and weights of sum 1, arrays (n,)."""

    place: Array
    weight: Array


def _towards_ends(moments: int) -> Rule:
    """The double exponential rule, dense towards both ends."""
    t = np.linspace(-3.0, 3.0, moments)
    argument = np.pi * np.sinh(t)
    place = 1.0 / (1.0 + np.exp(-argument))
    weight = np.pi * np.cosh(t) * place / (1.0 + np.exp(argument)) * (t[1] - t[0])
    return Rule(place, weight / weight.sum())


def _pieces(moves: Legs, since: float) -> Moved:
    """The legs of each of the moves (n, k + 1), cut where stretches pass 0."""
    begin, end, duration = moves.displacement[:, :-1], moves.displacement[:, 1:], moves.duration
    starts = since + np.cumsum(duration, axis=1) - duration
    across = (begin * end < 0.0) & (duration > 0.0)
    share = np.where(across, begin / np.where(across, begin - end, 1.0), 1.0)
    zero = np.where(across, 0.0, end)
    parts = [
        np.stack([begin, zero], axis=2),
        np.stack([zero, end], axis=2),
        np.stack([starts, starts + share * duration], axis=2),
        np.stack([share * duration, np.where(across, 1.0 - share, 0.0) * duration], axis=2),
    ]
    begin, end, starts, lasts = (part.reshape(begin.shape[0], -1) for part in parts)
    owner, column = np.nonzero(lasts > 0.0)
    at = owner, column
    return Moved(owner, begin[at], end[at], starts[at], lasts[at])
