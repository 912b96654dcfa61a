"""Births on a panel of time: the breaks one delay before, which may lie on it; or those of steady sliding."""

import numpy as np
from numpy.polynomial import legendre

from master.soft.inertia.delayed.panel import PLACES, SLOPES, STAGES, TO_NODES, TO_SERIES
from master.soft.inertia.delayed.past_breaks import PastBreaks
from origins.thresholds.law import Array


class PanelBirths:
    """Births on a panel, at its PLACES since its beginning: the breaks one delay before.

    born : of all contacts, shape (STAGES + 1,); where they broke on the panel itself a guess
    all_known : whether they broke before the panel

    _unknown : at which PLACES they did not; _to_broken : matrix from breaks at PLACES to those one delay before these
    _waiting : share that broke on panels before, and is out at this one's beginning
    """

    def __init__(self, past: PastBreaks, begin: float, width: float) -> None:
        times = begin + width * PLACES
        broken_at = (
            times - past.delay - begin
        ) / width  # as places on the panel, below 0 before it
        unknown = self._unknown = broken_at > 0.0
        self.all_known, self._width = not unknown.any(), width
        self.born = np.array([past.born_on_panels(t) for t in times.tolist()])
        self.born -= self.born[0]
        if not self.all_known:
            self._to_broken = _values_at(broken_at[unknown])
            self._waiting = past.breaks_on_panels - past.born_on_panels(begin)
            # at first as if breaks on the panel came at the rate of its first births
            self.born[unknown] = self._waiting
            self.born[unknown] += past.birth_rate(begin) * width * broken_at[unknown]

    @property
    def rate(self) -> Array:
        """Births per time at the nodes, whose integrals up to the nodes are the births there."""
        return np.asarray(SLOPES @ self.born) / self._width

    def guess_from(self, breaks: Array) -> None:
        """Take unknown births from breaks at the panel's PLACES, one delay before."""
        if not self.all_known:
            since = self._to_broken @ (breaks - breaks[0])
            self.born[self._unknown] = self._waiting + since

    @property
    def missed(self) -> float:
        """About what the polynomial through the births misses, a share of all contacts."""
        return float(np.abs(TO_SERIES[-2:] @ self.born).max())


class SteadyBirths:
    """Births on a panel on which sliding is nearly steady, so that they follow from the slider's speed.

    rate, born : as of PanelBirths; of no weight before Newton's method has found speeds
    """

    all_known, missed = False, 0.0

    def __init__(self, width: float) -> None:
        self._width = width
        self.take(np.zeros(STAGES))

    def take(self, rate: Array) -> None:
        """Take these births per time at the nodes."""
        self.rate, self.born = rate, np.append(0.0, self._width * TO_NODES @ rate)

    def guess_from(self, breaks: Array) -> None:
        """Breaks on the panel do not tell births, which the speed tells."""


def _values_at(places: Array) -> Array:
    """The matrix from values at PLACES to those at other places of the panel."""
    return np.asarray(legendre.legvander(2.0 * places - 1.0, STAGES) @ TO_SERIES)
