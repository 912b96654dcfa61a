"""Births on a panel of time: the breaks one delay before, which may lie on the panel itself."""

import numpy as np
from numpy.polynomial import legendre

from master.soft.inertia.delayed.panel import PLACES, SLOPES, STAGES, TO_SERIES
from master.soft.inertia.delayed.past_breaks import PastBreaks
from origins.thresholds.law import Array


class PanelBirths:
    """Births on a panel, at its PLACES since its beginning: the breaks one delay before.

    born : of all contacts, shape (STAGES + 1,); where they broke on the panel itself a guess
    all_known : whether they broke before the panel
    """

    def __init__(self, past: PastBreaks, begin: float, width: float) -> None:
        times = begin + width * PLACES
        broken_at = (times - past.delay - begin) / width
        unknown, self._width = broken_at > 0.0, width
        self.born = np.array([past.born_on_panels(t) for t in times.tolist()])
        first, self.all_known = self.born[0], not unknown.any()
        if not self.all_known:
            self._unknown = unknown
            self._to_broken = _values_at(broken_at[unknown])
            self._broken_before = past.breaks_on_panels
            self.born[unknown] = past.breaks_on_panels
            self.born[unknown] += past.birth_rate(begin) * width * broken_at[unknown]
        self.born -= first
        self._first = first

    @property
    def rate(self) -> Array:
        """Births per time at the nodes, whose integrals up to the nodes are the births there."""
        return np.asarray(SLOPES @ self.born) / self._width

    def guess_from(self, breaks: Array) -> None:
        """Take unknown births from breaks at the panel's PLACES, one delay before."""
        if not self.all_known:
            since = self._to_broken @ (breaks - breaks[0])
            self.born[self._unknown] = self._broken_before - self._first + since

    @property
    def missed(self) -> float:
        """About what the polynomial through the births misses, a share of all contacts."""
        return float(np.abs(TO_SERIES[-2:] @ self.born).max())


def _values_at(places: Array) -> Array:
    """The matrix from values at PLACES to those at other places of the panel."""
    return np.asarray(legendre.legvander(2.0 * places - 1.0, STAGES) @ TO_SERIES)
