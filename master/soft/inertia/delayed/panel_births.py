"""Births on a panel of time: the breaks one delay before, which may lie on it; or those of steady sliding."""

import numpy as np
from numpy.polynomial import legendre

from master.soft.inertia.delayed.panel import PLACES, SLOPES, STAGES, TO_NODES, TO_SERIES
from master.soft.inertia.delayed.past_breaks import PastBreaks
from origins.thresholds.law import Array


class PanelBirths:
    """Births on a panel, at its PLACES since its beginning: the breaks one delay before.

    With B the breaks on the panel at its PLACES since its beginning, births there are `of_past` + `of_breaks` B.

    born : of all contacts, shape (STAGES + 1,); where they broke on the panel itself, not valid before `take`
    all_before : whether they broke before the panel
    of_past : births of contacts that broke before it, shape (STAGES + 1,)
    of_breaks : of those that broke on it, shape (STAGES + 1, STAGES + 1), with 0 where births are `of_past` alone
    """

    def __init__(self, past: PastBreaks, begin: float, width: float) -> None:
        times = begin + width * PLACES
        # as places on the panel, below 0 before it
        broken_at = (times - past.delay - begin) / width
        unknown = broken_at > 0.0
        self.all_before, self._width = not unknown.any(), width
        self.of_past = np.array([past.born_on_panels(t) for t in times.tolist()])
        self.of_past -= self.of_past[0]
        self.of_breaks = np.zeros((PLACES.size, PLACES.size))
        if not self.all_before:
            # all that broke on panels before, and is out at this one's beginning, forms before those that break on it
            self.of_past[unknown] = past.breaks_on_panels - past.born_on_panels(begin)
            self.of_breaks[unknown] = _values_at(broken_at[unknown])
        self.born = self.of_past

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

    all_before, missed = False, 0.0

    def __init__(self, width: float) -> None:
        self._width = width
        self.take(np.zeros(STAGES))

    def take(self, rate: Array) -> None:
        """Take these births per time at the nodes."""
        self.rate, self.born = rate, np.append(0.0, self._width * TO_NODES @ rate)


def _values_at(places: Array) -> Array:
    """The matrix from values at PLACES to those at other places of the panel."""
    return np.asarray(legendre.legvander(2.0 * places - 1.0, STAGES) @ TO_SERIES)
