"""Lives of contacts that break at rates: what is left follows from the moves since their birth."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from master.lives.cold import NONE_LEFT
from master.lives.stretches import RESOLVED, Left, Moves, Rules, averaged, missed
from master.motion.motion import History, Legs
from origins import Contacts
from origins.laws.rate_law import RateLaw
from origins.start import Start
from origins.thresholds.law import Thresholds

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

# Of so many contacts one is summed again on halved panels, to see what the sums miss. A prime, so
# that all columns of a history get their turn.
ONE_OF = 17
# What halving changes beside a root is two thirds of the error, and contacts that are not looked at
# may fare worse.
MARGIN = 4.0
# Averages over stretches are looked at so many times less often: their sums are looked at as well.
_DEARER = 4

# Share of contacts that sums over thresholds may round away, and the decades over which their tail
# is summed.
LOST, DECADES = 3e-14, 60.0


class ReplayedLife:
    """A Life that looks at all legs since the birth; what differs between closures is `_of`.

    Attributes as in Life. `error` is measured as `left` goes: of some contacts the sums are done
    again on halved panels, and the largest change so far is kept.

    Parameters
    ----------
    law : Thresholds
    edges : array of shape (n,)
        Of panels on which the law is smooth; none where there are atoms alone.
    resolved : float
        To which averages over the stretches at birth are resolved.
    """

    quiet = 0.0
    quick = timeless = False
    fresh_start, pair_work = True, 6
    FEW = 1e-10  # a share that sums over thresholds still tell

    def __init__(self, law: Thresholds, edges: Array, resolved: float = RESOLVED) -> None:
        self._law, self.resolved = law, resolved
        self._rules: tuple[Start, Rules] | None = None
        self.atoms: Array = law.atoms[0]
        self._weights = law.atoms[1]
        self.reach = min(float(law.support()[1]), float(law.isf(NONE_LEFT)))
        self.reach = max([self.reach, *self.atoms])
        marks = np.concatenate([law.breakpoints, self.atoms])
        self.bends: Array = np.unique(marks[(marks > 0.0) & (marks <= self.reach)])
        self.bend_sizes: Array = np.ones(self.bends.size)
        edges = edges[edges < self.reach]
        lost = -np.diff(law.sf(edges))
        many = lost.sum() > 0.0
        self.grain = float(np.diff(edges) @ lost / lost.sum()) if many else self.reach
        self.error = 0.0

    @property
    def few(self) -> float:
        """The |x| beyond which a share FEW of the thresholds lies."""
        return float(self._law.isf(self.FEW))

    def rounded_away(self) -> Array:
        """At most what E and K, integrated, miss where few contacts are left; shape (2,).

        Sums over thresholds round away the last contacts. Without heat, which only breaks contacts
        earlier, they would add the integrals of S and x S.
        """
        begin = min(self.reach, float(self._law.isf(LOST)))
        steps = np.linspace(0.0, DECADES * np.log(10.0), 2001)
        x = begin * np.exp(steps)
        held = np.asarray(self._law.sf(x), dtype=float) * x
        return np.trapezoid(np.stack([held, held * x]), steps, axis=1)

    def marks(self, width: float) -> Array:
        """See Life."""
        return self.bends

    def atom_share(self, atom: float, stretch: float) -> float:
        """See Life; fewer where heat breaks them before."""
        return float(self._weights[self.atoms == atom].sum() / self._law.sf(abs(stretch)))

    def left(self, born: Start | Array, history: History) -> Array:
        """See Life."""
        moves, legs = Moves.of(history), history.legs()
        shape, count = legs.duration.shape[:-1], legs.speed.size
        displacement = legs.displacement.reshape(-1, count + 1)
        legs = Legs(displacement, legs.duration.reshape(-1, count), legs.speed)
        every = np.arange(moves.now.size)
        if not isinstance(born, Start) or born.is_single:
            single = born.mean() if isinstance(born, Start) else born
            stretch = np.broadcast_to(np.asarray(single, dtype=float), shape).ravel()
            row = every // shape[1]
            side = moves.largest(row * shape[1] + shape[1] // 2, stretch)
            return self._of(every, stretch, side, moves, legs).reshape(2, *shape)

        def inside(pair: Rows, stretch: Array) -> Array:
            side = moves.largest(pair, stretch)[:, stretch.shape[1] // 2, None]
            side = np.broadcast_to(side, stretch.shape).ravel()
            pairs = np.repeat(pair, stretch.shape[1])
            found = self._of(pairs, stretch.ravel(), side, moves, legs)
            return found.reshape(2, *stretch.shape)

        out = self._averaged(born, moves, inside)
        one_of = ONE_OF * _DEARER
        change = missed(born, moves, self.reach, self.bends, inside, out, one_of)
        self.error = max(self.error, MARGIN * change)
        return out.reshape(2, *shape)

    def _averaged(self, born: Start, moves: Moves, inside: Left) -> Array:
        """Averages over the stretches: by Gauss rules of the law where two agree, else by pieces."""
        given = self.reach, self.bends
        if self.atoms.size or max(np.abs(born.span)) >= self.reach:
            return averaged(born, moves, *given, inside, self.resolved)
        if self._rules is None or self._rules[0] is not born:
            self._rules = born, Rules.of(born)
        tried = self._rules[1].averaged(born, moves, *given, inside, self.resolved)
        some = np.flatnonzero(~tried.agreed)
        if some.size:

            def of_some(pair: Rows, stretch: Array) -> Array:
                return inside(some[pair], stretch)

            few = Moves(*(part[some] for part in moves))
            tried.found[:, some] = averaged(born, few, *given, of_some, self.resolved)
        return tried.found

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
