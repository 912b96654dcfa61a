"""Contacts that also break below their thresholds, each at its own rate: closure "exact"."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from master.lives.cold import TIE
from master.lives.heat.above import ACCURACY, Above
from master.lives.heat.replay import Replay
from master.lives.heat.replayed import MARGIN, ONE_OF, ReplayedLife, rates_of
from master.lives.stretches import RESOLVED, Moves
from master.motion.motion import Legs
from origins import Contacts

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

# Contacts replayed at once: the panels of so many are halved together.
_AT_ONCE = 4000


class ThermalLife(ReplayedLife):
    """What is left of contacts that break by heat, each at its own rate h(x; x_s); a Life.

    Born at r, a contact whose largest |x| was m still holds with the probability

        E = integral over x_s > m of P_c(x_s) e^(-A(x_s)) / S(|r|),

    A the integral of h over the time since its birth.

    Parameters
    ----------
    contacts : Contacts
        With thermal, closure "exact"; independent or linked stiffness.
    accuracy : float
        Of the share of contacts that holds; what it comes to is `error`.
    resolved : float
        See ReplayedLife.
    """

    def __init__(
        self, contacts: Contacts, accuracy: float = ACCURACY, resolved: float = RESOLVED
    ) -> None:
        law, self._rates = contacts.thresholds, rates_of(contacts)
        linked = contacts.stiffness == "linked"
        self._stiffness = contacts.relative_stiffness if linked else None
        self._above = Above(law, self._rates, self._stiffness, accuracy)
        super().__init__(law, self._above.edges, resolved)

    def _of(self, pair: Rows, born: Array, side: Array, moves: Moves, legs: Legs) -> Array:
        """See ReplayedLife."""
        out = np.zeros((2, pair.size))
        for begin in range(0, pair.size, _AT_ONCE):
            some = slice(begin, begin + _AT_ONCE)
            replay = self._replay(pair[some], born[some], legs)
            share = 1.0 / self._law.sf(np.abs(born[some]))
            out[:, some] = self._above.sums(replay, share)
            few = np.arange(share.size // 2 % ONE_OF, share.size, ONE_OF)
            again = self._replay(pair[some][few], born[some][few], legs)
            change = self._above.sums(again, share[few], parts=2) - out[:, some][:, few]
            self.error = max(self.error, MARGIN * float(np.abs(change).max(initial=0.0)))
            for position, weight in zip(self.atoms, self._weights, strict=True):
                held = share * weight * np.exp(-replay.spent_at(position))
                held *= side[some] < position * (1.0 - TIE)
                out[:, some] += np.stack([held, held * self._relative(position)])
        out[0] = np.minimum(out[0], 1.0)
        out[1] *= born + moves.now[pair]
        return out

    def _replay(self, pair: Rows, born: Array, legs: Legs) -> Replay:
        """What contacts of these pairs have spent."""
        own = Legs(legs.displacement[pair], legs.duration[pair], legs.speed)
        return Replay(self._rates, self._stiffness, born, own)

    def _relative(self, threshold: float) -> float:
        """k_i/<k> at one threshold."""
        return 1.0 if self._stiffness is None else float(self._stiffness(np.array(threshold)))
