"""The sum over the thresholds that a contact may have: those above the largest |x| of its life."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.lives.heat.replay import Replay
from master.lives.heat.threshold_panels import (
    SMALLEST,
    Panels,
    Stiffness,
    fastest_thresholds,
    joined,
    law_edges,
    nodes,
)
from origins.laws.rate_law import RateLaw
from origins.thresholds.law import Thresholds

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]


class _Seen(NamedTuple):
    """Fall of ln A that 16 nodes see: at_one - slope * ln A where it is largest, or `least`."""

    least: float
    at_one: float
    slope: float


ACCURACY = 1e-13  # of sums over thresholds, in contacts: that of the panels
# measured at steady falls: to 1e-13
_SEEN = _Seen(3.0, 8.0, 2.5)
# In units of the accuracy: shares e^-A that are nothing, even where next to none is left of all;
# losses A where contacts hold; and shares of contacts of which panels are left out
_GONE, _QUIET, _NO_WEIGHT = 1e-16, 1e-4, 1e-5
# A: beside the threshold m, 16 nodes in (x_s - m)^(1/2) see e^-A fall from 1 this far
_FALL = 4.0
# width over distance: of panels that do not feel a root this far away, to 1e-13
_APART = 12.0
# lengths in units of the threshold: what a root does to the sum over panels as narrow is nothing,
# in units of the accuracy, and where that is rounding
_SLIGHT, _LEAST_SLIGHT = 1e3, 1e-8
# lengths in units of the threshold: narrower panels hold no weight that could be told from rounding
_NARROW = 1e-14
_DEAD = 7.0  # ln A: e^-A is 0
_AT_ONCE = 512  # panels summed together: their nodes stay in the processor's cache


class Above:
    """Sums of P_c(x_s) e^(-A(x_s)) over the thresholds x_s above m, for many contacts at once.

    The continuous part of P_c is summed on the law's own panels, which are halved where A falls
    through 1. A law whose rate vanishes at the threshold makes A a series in (x_s - m)^(1/2), which
    is then the variable of the nodes; at rest its A is 0 at x_s = m, has its maximum just above and
    falls from there on.

    Parameters
    ----------
    law : Thresholds
    rates : RateLaw
    stiffness : callable
        k_i/<k> at thresholds; None where it is 1 for all.
    accuracy : float
        Of the sums, in contacts; at best 1e-13.
    """

    def __init__(
        self,
        law: Thresholds,
        rates: RateLaw,
        stiffness: Stiffness | None,
        accuracy: float = ACCURACY,
    ) -> None:
        self.law, self.rates, self.stiffness = law, rates, stiffness
        self.rooted = rates.vanishes_at_threshold
        self._slight = max(_SLIGHT * accuracy, _LEAST_SLIGHT)
        self._no_weight = _NO_WEIGHT * accuracy
        # ln A: beyond, a share e^-A is nothing; where A is less, contacts hold
        self._gone = float(np.log(-np.log(_GONE * accuracy)))
        self._quiet = float(np.log(_QUIET * accuracy))
        self.edges: Array = law_edges(law)
        low, high = self.edges[:-1], self.edges[1:]
        whole = Panels(np.arange(low.size), low, high, low, low)  # of levels nobody asks
        mass = self._stiff(*nodes(law, whole, None))
        self.beyond = np.zeros((2, self.edges.size))
        self.beyond[:, :-1] = mass[:, ::-1].cumsum(axis=1)[:, ::-1]
        if self.rooted and self.edges.size:
            self._places = self.edges[-1] * np.append(0.0, np.geomspace(1e-8, 1.0, 400))
            self._fastest = fastest_thresholds(rates, stiffness, self._places)

    def fastest(self, x: Array) -> Array:
        """The thresholds above x, up to the last edge, of the contacts that break fastest there."""
        return np.clip(np.interp(x, self._places, self._fastest), x, self.edges[-1])

    def _stiff(self, xi: Array, weight: Array) -> Array:
        """Sums of weights on panels, and of these times the relative stiffness; shape (2, n)."""
        both = weight if self.stiffness is None else weight * self.stiffness(xi)
        return np.stack([weight.sum(axis=1), both.sum(axis=1)])

    def sums(self, replay: Replay, share: Array, parts: int = 1) -> Array:
        """Share of contacts that are left, and their relative stiffness; shape (2, n). No atoms.

        share : array of shape (n,), what P_c is multiplied by: 1 over the survival at birth
        parts : every panel is cut in so many more: 1, or 2 to see what the sum misses
        """
        out = np.zeros((2, share.size))
        if not self.edges.size:
            return out
        panels, beyond = self._begin(replay, share)
        out += beyond
        panels = self._resolved(panels, replay)
        if parts == 2:
            middle = 0.5 * (panels.low + panels.high)
            panels = panels.cut(middle, middle)  # the levels are not asked for any more
        for begin in range(0, panels.row.size, _AT_ONCE):
            some = panels.pick(slice(begin, begin + _AT_ONCE))
            for kind, values in enumerate(self._values(some, replay)):
                out[kind] += np.bincount(some.row, values, minlength=share.size)
        return share * out

    def _begin(self, replay: Replay, share: Array) -> tuple[Panels, Array]:
        """The law's panels above the largest |x|, and the weight beyond, where A is nothing."""
        least = np.maximum(replay.least, SMALLEST)
        ends = np.maximum(self.edges, least[:, None])
        level = replay.log_spent(np.arange(least.size), ends)
        quiet = level < self._quiet
        if self.rooted:
            peak = self.fastest(least)
            quiet &= ends >= peak[:, None]
        # the first edge from which on A is nothing
        loud = np.where(quiet.all(axis=1), 0, quiet.shape[1] - quiet[:, ::-1].argmin(axis=1))
        # beside `least` itself the weight beyond is not tabulated
        loud = np.maximum(loud, np.searchsorted(self.edges, least))
        kept = np.minimum(loud, self.edges.size - 1)
        inside = np.arange(self.edges.size - 1) < kept[:, None]
        inside &= -np.diff(self.beyond[0]) * share[:, None] > self._no_weight
        row, col = np.nonzero(inside & (ends[:, 1:] > ends[:, :-1]))
        panels = Panels(
            row, ends[row, col], ends[row, col + 1], level[row, col], level[row, col + 1]
        )
        if self.rooted:
            at = peak[row]
            split = (panels.low < at) & (at < panels.high)
            at, some = at[split], panels.pick(split)
            cut = some.cut(at, replay.log_spent(some.row, at[:, None])[:, 0])
            panels = joined([panels.pick(~split), cut])
        beyond = np.where(loud < self.edges.size, self.beyond[:, kept], 0.0)
        return panels, beyond

    def _resolved(self, panels: Panels, replay: Replay) -> Panels:
        """The panels cut until the nodes of each see how A falls through 1 on it."""
        done: list[Panels] = []
        while panels.row.size:
            panels = panels.pick(np.minimum(panels.first, panels.last) < self._gone)
            at = 0.5 * (panels.low + panels.high)
            if self.rooted:
                beside = np.flatnonzero(self._beside(panels, replay))
                grown = _grown(panels.first[beside], panels.last[beside])
                # as the root of the way
                part = np.minimum(np.square(0.5 * _FALL / np.maximum(grown, _FALL)), 0.5)
                at[beside] = panels.low[beside] + part * (panels.high - panels.low)[beside]
                at = np.minimum(at, panels.low + self._widest(panels, replay))
                at = np.maximum(at, panels.low + _NARROW * panels.high)
            level = replay.log_spent(panels.row, at[:, None])[:, 0]
            top = np.maximum(np.maximum(panels.first, panels.last), level)
            # of ln A, as if it fell all along as fast as on the steeper part
            fall = np.maximum(np.abs(panels.first - level), np.abs(level - panels.last))
            seen = 2.0 * fall <= np.maximum(_SEEN.least, _SEEN.at_one - _SEEN.slope * top)
            if self.rooted:
                highest = np.maximum(level, panels.last)[beside]
                seen[beside] |= _grown(panels.first[beside], highest) <= _FALL
                seen &= panels.high - panels.low <= 1.001 * self._widest(panels, replay)
            # a cut _NARROW from one end rounds to the other end where a panel is hardly wider
            seen |= panels.high - panels.low <= 4.0 * _NARROW * panels.high
            done.append(panels.pick(seen))
            cut = ~seen
            panels = panels.pick(cut).cut(at[cut], level[cut])
        return joined(done) if done else panels

    def _beside(self, panels: Panels, replay: Replay) -> npt.NDArray[np.bool_]:
        """Panels that begin at the largest |x|, and on which A grows with x_s."""
        return (panels.low <= replay.least[panels.row]) & (panels.last >= panels.first)

    def _widest(self, panels: Panels, replay: Replay) -> Array:
        """Width of panels that lie far enough from the next largest |x|, where A is a root, too."""
        distance = panels.low - replay.shoulder[panels.row]
        return np.maximum(_APART * distance, self._slight * panels.high)

    def _values(self, panels: Panels, replay: Replay) -> Array:
        """Both sums on each panel; shape (2, n)."""
        base = replay.least[panels.row] if self.rooted else None
        xi, weight = nodes(self.law, panels, base)
        spent = np.exp(np.minimum(replay.log_spent(panels.row, xi), _DEAD))
        return self._stiff(xi, weight * np.exp(-spent))


def _grown(first: Array, last: Array) -> Array:
    """A at the end of panels less A at their beginning, from both ln A."""
    return np.exp(np.minimum(last, 300.0)) - np.exp(np.minimum(first, 300.0))
