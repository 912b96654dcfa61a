"""Slips that become alike where some contacts hold over each of them: the limit cycle of a soft slider at T = 0."""

from dataclasses import dataclass, field, replace

import numpy as np

from master.soft.curve import SlipBegin
from master.soft.moves import LoadingHistory
from origins.thresholds.law import Array

# Places of the way up to a slip at which forces of one slip are compared with those of the next.
PLACES = np.linspace(0.0, 1.0, 17)
# Each of the last changes is at most this part of the one before: then all later ones are together at most the last.
SHRINKS = 0.5
# Changes below this part of the way from slip to slip are rounding.
ROUNDED = 1e-12


@dataclass(frozen=True)
class Slipped:
    """A slip that leaves some contacts holding.

    force : along the motion, after it (a length)
    fraction_broken : of the contacts, in it
    position_error : of the slider by it (a length)
    loaded : the history of the next move
    shift : by how much this history begins elsewhere than the one before (a length); 0 where it goes on
    """

    force: float
    fraction_broken: float
    position_error: float
    loaded: LoadingHistory
    shift: float = 0.0


@dataclass
class LimitCycle:
    """How much each slip differs from the one before, and the history that is repeated once all are alike.

    Contacts that hold over a slip make the next one another, but ever fewer hold over two, three, four: forces, travels
    and the share that holds tend to those of a cycle, and their changes shrink as a geometric series.
    """

    loaded: LoadingHistory | None = None
    remaining: float = np.inf  # what all slips to come differ from those of `loaded` (a length)
    _last: Array = field(default_factory=lambda: np.empty(0))
    _changes: list[float] = field(default_factory=list)

    def closed_by(
        self, loaded: LoadingHistory, slip: SlipBegin, after: Array, most: float
    ) -> LoadingHistory | None:
        """The history to repeat, with its error, once all slips to come differ from this one by `most` (a length)
        together; None before.

        loaded : the history of the move that led to the slip
        after : the slip's travel, the force after it, and the share that holds, as lengths
        """
        if loaded is self.loaded:
            return loaded
        force = slip.curve.force(slip.travel * PLACES)
        seen = np.concatenate([force, [slip.travel, slip.load], after])
        if self._last.size:
            self._changes.append(float(np.abs(seen - self._last).max()))
        self._last = seen
        if not (remaining := self._remainder(ROUNDED * (slip.travel + float(after[0])))) <= most:
            return None
        self.remaining, self.loaded = remaining, replace(loaded, error=loaded.error + remaining)
        return self.loaded

    def _remainder(self, rounded: float) -> float:
        """Estimate from above of the sum of all later changes (a length); inf where they do not shrink."""
        if len(self._changes) < 3:
            return np.inf
        first, second, last = self._changes[-3:]
        if max(first, second, last) <= rounded:
            return max(first, second, last)
        return last if last <= SHRINKS * second and second <= SHRINKS * first else np.inf
