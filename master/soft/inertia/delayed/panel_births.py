"""Births on a panel of time: the breaks one delay before, which may lie on it; or those of steady sliding."""

import numpy as np
from numpy.polynomial import legendre

from master.soft.inertia.delayed.panel import PLACES, SLOPES, STAGES, TO_NODES, TO_SERIES
from master.soft.inertia.delayed.past_breaks import PastBreaks
from origins.thresholds.law import Array


class PanelBirths:
    """Births on a panel, at its PLACES since its beginning: the breaks one delay before.

    With B the breaks on the panel at its PLACES since its beginning, births there are `known` + `of_breaks` B.

    born : of all contacts, shape (STAGES + 1,); where they broke on the panel itself, not valid before `take`
    all_known : whether they broke before the panel
    known : births of contacts that broke before it, shape (STAGES + 1,)
    of_breaks : of those that broke on it, shape (STAGES + 1, STAGES + 1), with 0 at places whose births are known
    """

    def __init__(self, past: PastBreaks, begin: float, width: float) -> None:
        times = begin + width * PLACES
        # as places on the panel, below 0 before it
        broken_at = (times - past.delay - begin) / width
        unknown = broken_at > 0.0
        self.all_known, self._width = not unknown.any(), width
        self.known = np.array([past.born_on_panels(t) for t in times.tolist()])
        self.known -= self.known[0]
        self.of_breaks = np.zeros((PLACES.size, PLACES.size))
        if not self.all_known:
            # all that broke on panels before, and is out at this one's beginning, forms before those that break on it
            self.known[unknown] = past.breaks_on_panels - past.born_on_panels(begin)
            self.of_breaks[unknown] = _values_at(broken_at[unknown])
        self.born = self.known

    @property
    def rate(self) -> Array:
        """Births per time at the nodes, whose integrals up to the nodes are the births there."""
        return np.asarray(SLOPES @ self.born) / self._width

    def take(self, born: Array) -> None:
        """Take these births at the PLACES."""
        self.born = born

    @property
    def missed(self) -> float:
        """About what the polynomial through the births misses, a share of all contacts."""
        return float(np.abs(TO_SERIES[-2:] @ self.born).max())


class SteadyBirths:
    """Births on a panel on which sliding is nearly steady, so that they follow from the slider's speed.

    rate, born : as of PanelBirths; not valid before Newton's method has found speeds
    """

    all_known, missed = False, 0.0

    def __init__(self, width: float) -> None:
        self._width = width
        self.take(np.zeros(STAGES))

    def take(self, rate: Array) -> None:
        """Take these births per time at the nodes."""
        self.rate, self.born = rate, np.append(0.0, self._width * TO_NODES @ rate)


def _values_at(places: Array) -> Array:
    """The matrix from values at PLACES to those at other places of the panel."""
    return np.asarray(legendre.legvander(2.0 * places - 1.0, STAGES) @ TO_SERIES)
