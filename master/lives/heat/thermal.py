"""Contacts that also break below their thresholds, each at its own rate: closure "exact"."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from master.lives.cold import TIE
from master.lives.heat.above import Above
from master.lives.heat.replay import Replay
from master.lives.heat.replayed import MARGIN, RESOLVED, ReplayedLife, rates_of
from master.lives.stretches import Moves
from master.motion.motion import Legs
from origins import Contacts

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

# Contacts replayed at once, whose panels are halved together.
_AT_ONCE = 4000
# Share of contacts that sums over thresholds may round away, and the decades over which their tail
# is summed.
_LOST, _DECADES = 3e-14, 60.0


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

        Rounding in sums over thresholds loses the last contacts. Without heat, which only breaks contacts
        earlier, they would add the integrals of S and x S over the tail.
        """
        begin = min(self.reach, float(self._law.isf(_LOST)))
        steps = np.linspace(0.0, _DECADES * np.log(10.0), 2001)
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
                held = share * weight * np.exp(-replay.spent_at(position))
                held *= side[some] < position * (1.0 - TIE)
                stiffness = 1.0 if self._stiffness is None else self._stiffness(position)
                out[:, some] += np.stack([held, held * stiffness])
        self.error = max(self.error, MARGIN * self._above.missed)
        out[0] = np.minimum(out[0], 1.0)
        out[1] *= born + moves.now[pair]
        return out
