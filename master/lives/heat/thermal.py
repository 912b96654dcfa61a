"""Contacts that also break below their thresholds, each at its own rate: closure "exact"."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from master.lives.averages import Moves, averaged
from master.lives.cold import NONE_LEFT, TIE
from master.lives.heat.above import Above
from master.lives.heat.replay import Replay, rates_of
from master.lives.life import Life
from master.motion.motion import History, Legs
from origins import Contacts
from origins.start import Start
from origins.thresholds.law import Thresholds

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

# Factor on the measured error: near a root halving shows only two thirds of the error, and only some
# contacts are measured.
MARGIN = 4.0
# Last coefficients below which pieces of the stretches at birth are not halved.
RESOLVED = 1e-9
# Contacts replayed at once, whose panels are halved together.
_AT_ONCE = 4000


class ReplayedLife(Life):
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
        found = averaged(born, moves, self.reach, self.bends, inside, self._resolved, pieces=4)
        self.error = max(self.error, MARGIN * float(found.missed[0]))
        return found.value.reshape(2, *shape)

    def _of(self, pair: Rows, born: Array, side: Array, moves: Moves, legs: Legs) -> Array:
        """Share and force of contacts of these pairs, born at these stretches; shape (2, n).

        side : array of shape (n,), the largest |x| that decides which exact thresholds are passed
        """
        raise NotImplementedError


class ThermalLife(ReplayedLife):
    """The Life of contacts that break by heat, each at its own rate h(x; x_s).

    Born at r, a contact whose largest |x| was m still holds with the probability

        E = integral over x_s > m of P_c(x_s) e^(-A(x_s)) / S(|r|),

    A the integral of h over the time since its birth.

    Parameters
    ----------
    contacts : Contacts
        With thermal, closure "exact"; independent or linked stiffness.
    resolved : float
        See ReplayedLife.
    """

    FEW = 1e-10  # a share that sums over thresholds still resolve

    def __init__(self, contacts: Contacts, resolved: float = RESOLVED) -> None:
        law, self._rates = contacts.thresholds, rates_of(contacts)
        linked = contacts.stiffness == "linked"
        self._stiffness = contacts.relative_stiffness if linked else None
        self._above = Above(law, self._rates, self._stiffness)
        super().__init__(law, self._above.edges, resolved)

    @property
    def few(self) -> float:
        """The |x| beyond which a share FEW of the thresholds lies."""
        return float(self._law.isf(self.FEW))

    def rounded_away(self) -> Array:
        """Bounds of the errors of the integrals of E and K where few contacts hold; shape (2,).

        Rounding in sums over thresholds loses the last contacts, a share of 3e-14. Without heat, which
        only breaks contacts earlier, they would add the integrals of S and x S over the tail; 60
        decades of it are summed.
        """
        begin = min(self.reach, float(self._law.isf(3e-14)))
        steps = np.linspace(0.0, 60.0 * np.log(10.0), 2001)
        x = begin * np.exp(steps)
        held = np.asarray(self._law.sf(x), dtype=float) * x
        return np.trapezoid(np.stack([held, held * x]), steps, axis=1)

    def _of(self, pair: Rows, born: Array, side: Array, moves: Moves, legs: Legs) -> Array:
        """See ReplayedLife."""
        out = np.zeros((2, pair.size))
        for begin in range(0, pair.size, _AT_ONCE):
            some = slice(begin, begin + _AT_ONCE)
            at = pair[some]
            own = Legs(legs.displacement[at], legs.duration[at], legs.speed)
            replay = Replay(self._rates, self._stiffness, born[some], own)
            share = 1.0 / self._law.sf(np.abs(born[some]))
            out[:, some] = self._above.sums(replay, share)
            for position, weight in zip(self.atoms, self._weights, strict=True):
                spent = replay.spent(np.arange(at.size), np.full((at.size, 1), position))[:, 0]
                held = share * weight * np.exp(-spent) * (side[some] < position * (1.0 - TIE))
                stiffness = 1.0 if self._stiffness is None else self._stiffness(position)
                out[:, some] += np.stack([held, held * stiffness])
        self.error = max(self.error, MARGIN * self._above.missed)
        out[0] = np.minimum(out[0], 1.0)
        out[1] *= born + moves.now[pair]
        return out
