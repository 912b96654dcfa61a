"""Contacts with growing grains at a temperature: each keeps its quantile, and may break early.

A contact of the quantile's hazard η has at any age the threshold x_s(η; age). Of those born
together the share

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
from master.motion.motion import History, Legs
from origins import Contacts
from origins.start import Start

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

# Panels of the sums over quantiles. They share out evenly what changes in the integrand: 1 - e^-y,
# y being the root of the hazard above the worst one, and ln A between these two values, from where
# e^-A is next to nothing to where it is next to 1.
PANELS, LEAST_LOG, MOST_LOG = 7, -14.0, 4.0
# Roots of hazards at which A is looked at to place them.
LOOKS = np.sqrt(np.concatenate([[0.0], np.geomspace(1e-6, 1.0, 10), [2.0, 4.0, 8.0, 16.0, GONE]]))
# Numbers of elements that are worked on at once, so that they stay in memory's near parts.
CHUNK = 2_000_000
# A above which nothing holds.
SPENT = 700.0


class Fineness(NamedTuple):
    """Numbers of nodes: of quantiles between two cuts, and of moments on a leg."""

    quantiles: int
    moments: int


# Tried one after the other, until the next one changes the share by no more than asked: colder
# contacts break within ever shorter parts of a leg.
FINENESSES = (Fineness(9, 51), Fineness(11, 101), Fineness(13, 201), Fineness(16, 401))
ACCURACY = 1e-7
# Of the change that is seen, as not all ages are looked at; and what the table leaves.
MARGIN, TABLE_ERROR = 4.0, 3e-11


class Pieces(NamedTuple):
    """Straight moves on which stretches do not change their sign, arrays (pieces,).

    owner : which contacts, rising; begin, end : stretches (lengths); since : time since pinning as
    they begin; duration : time
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
        Change of the share that holds at which no finer nodes are tried.

    Attributes
    ----------
    error : float
        Measured: the first, the middle and the last of the rows' columns are told twice.
    """

    # normal laws are then summed to 1e-8
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
        for fineness in range(self._fineness + 1, len(FINENESSES)):
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
        fineness = FINENESSES[self._fineness]
        out = np.zeros(worst.size)
        alive = np.flatnonzero(worst - before < GONE)
        chunk = max(1, CHUNK // (PANELS * fineness.quantiles * fineness.moments))
        for rows in np.array_split(alive, 1 + alive.size // chunk):
            if rows.size:
                own = Legs(moves.displacement[rows], moves.duration[rows], moves.speed)
                pieces = _pieces(own, since)
                over = self._over_quantiles(pieces, worst[rows], fineness)
                out[rows] = over * np.exp(before[rows] - worst[rows])
        return out

    def _over_quantiles(self, pieces: Pieces, worst: Array, fineness: Fineness) -> Array:
        """Mean of e^-A over the quantiles that are not met yet, array (n,)."""
        count = worst.size
        looks = np.broadcast_to(LOOKS, (count, LOOKS.size))
        with np.errstate(divide="ignore"):
            log_spent = np.log(self._spent(pieces, worst, looks, fineness.moments))
        # stiff contacts right at their threshold hardly break: from the fastest on A falls
        log_spent = np.maximum.accumulate(log_spent[:, ::-1], axis=1)[:, ::-1]
        changed = (MOST_LOG - np.clip(log_spent, LEAST_LOG, MOST_LOG)) / (MOST_LOG - LEAST_LOG)
        changed = changed - changed[:, :1] - np.expm1(-LOOKS)
        parts = np.linspace(0.0, 1.0, PANELS + 1)
        edges = np.array([np.interp(parts * row[-1], row, LOOKS) for row in changed])
        x, w = np.polynomial.legendre.leggauss(fineness.quantiles)
        half = 0.5 * np.diff(edges)[..., None]
        roots = (edges[:, :-1, None] + half * (x + 1.0)).reshape(count, -1)
        weights = (half * w).reshape(count, -1) * 2.0 * roots * np.exp(-roots * roots)
        return (weights * np.exp(-self._spent(pieces, worst, roots, fineness.moments))).sum(axis=1)

    def _spent(self, pieces: Pieces, worst: Array, roots: Array, moments: int) -> Array:
        """A of quantiles of the hazards worst + roots², shape of `roots` (n, m)."""
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


def _pieces(moves: Legs, since: float) -> Pieces:
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
    return Pieces(owner, begin[at], end[at], starts[at], lasts[at])
