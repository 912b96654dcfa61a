"""Contacts that all break at one mean rate H(x): the closure "paper" (Eqs. temper3, temper4)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from master.lives.averages import Moves
from master.lives.cold import TIE
from master.lives.heat.above import Above
from master.lives.heat.replay import rates_of
from master.lives.heat.thermal import RESOLVED, ReplayedLife
from master.motion.motion import Legs
from master.renewal.table import Table
from origins import Contacts
from origins.thresholds.quadrature import gauss

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

# Least H, in attempt frequencies, whose relative error matters: one break in 1e35 attempts.
_NEVER = 1e-35
_EPSILON = float(np.finfo(float).eps)
_CHUNK = 400  # stretches at which H is summed at once


class MeanRateLife(ReplayedLife):
    """The Life of contacts with P_T = P + H/v (paper, Eqs. temper2 and temper4).

    H(x), the integral of h(x; x_s) P_c(x_s) over x_s > |x|, is the rate of all contacts, and

        E = product over all ways out of S(|x_end|)/S(|x_begin|) exp(-integral of H over time),

    a way out being one on which |x| grows beyond |r|. As in App. C, a contact that was pulled back and goes out
    again may break at thresholds that it has passed before; on one leg the product is S(|x|)/S(|r|).

    Parameters
    ----------
    contacts : Contacts
        With thermal; independent stiffness.
    resolved : float
        See ReplayedLife.
    """

    def __init__(self, contacts: Contacts, resolved: float = RESOLVED) -> None:
        """Tabulate the mean rate H and its integral."""
        rates = rates_of(contacts)
        self._above = Above(contacts.thresholds, rates, None)
        super().__init__(contacts.thresholds, self._above.edges, resolved)
        edges = np.unique(np.concatenate([[0.0, self.reach], self.bends, self._above.edges]))
        barrier = float(np.log(rates.scale) - rates.log_rate(0.0, self.reach, 1.0))
        # relative rounding of h per k_BT of the barrier; halving cannot reduce it
        rounding = 16.0 * _EPSILON * max(barrier, 1.0)
        self.table = RateTable(self._mean_rate, edges[edges <= self.reach], rates.scale, rounding)
        # the table is checked away from its nodes; an error of H counts by its part of L, the integral
        # of H, and one of ln L changes the survival e^-L by at most 1/e of it
        at = self.table.begin + 0.02 * self.table.widths
        right = self._mean_rate(at)
        missed = [min(self._above.mean_rate(np.array([x])).missed[0], 1.0) for x in at]
        wrong = (np.abs(self.table.rate(at) - right) + right * missed) * self.table.widths
        grown = self.table.grown(self.table.edges[1:])
        least = _NEVER * rates.scale * self.reach
        self.error = float((np.cumsum(wrong) / np.maximum(grown, least)).max(initial=0.0)) / np.e

    def _mean_rate(self, x: Array) -> Array:
        """H at stretches x >= 0, shape (n,), by its definition."""
        out = np.zeros(x.size)
        for begin in range(0, x.size, _CHUNK):
            some = slice(begin, begin + _CHUNK)
            out[some] = self._above.mean_rate(x[some]).value[0]
        for position, weight in zip(self.atoms, self._weights, strict=True):
            below = x < position
            out[below] += weight * self._above.rates.rate(x[below], position, 1.0)
        return out

    def _of(self, pair: Rows, born: Array, side: Array, moves: Moves, legs: Legs) -> Array:
        """See ReplayedLife."""
        spent, rounded = np.zeros(pair.size), np.zeros(pair.size)
        for leg, speed in enumerate(legs.speed):
            on = np.flatnonzero(legs.duration[pair, leg] > 0.0)
            near = (born + legs.displacement[pair, leg])[on]
            if speed == 0.0:
                spent[on] += legs.duration[pair[on], leg] * self.table.rate(np.abs(near))
                continue
            before, after = (
                self.table.grown(x) / abs(speed)
                for x in (near, (born + legs.displacement[pair, leg + 1])[on])
            )
            spent[on] += np.abs(after - before)
            rounded[on] += _EPSILON * np.abs(after)  # may exceed their difference on short ways
        share = np.clip(self._passed(pair, born, side, legs), 0.0, 1.0) * np.exp(-spent)
        self.error = max(self.error, float((share * rounded).max(initial=0.0)))
        return np.stack([share, share * (born + moves.now[pair])])

    def _passed(self, pair: Rows, born: Array, side: Array, legs: Legs) -> Array:
        """Product over all ways out of S(|x|) at the end over S(|x|) at the beginning."""
        first = np.abs(born)  # no threshold lies below
        share, begin, before = np.ones(pair.size), first, born
        for leg in range(legs.speed.size):
            x = born + legs.displacement[pair, leg + 1]
            # a way out through 0 begins at |r|; a way towards 0 (`turned`) has the factor 1
            begin = np.where(before * x < 0.0, first, begin)
            end = np.maximum(np.abs(x), first)
            turned = end < begin
            begin_held = self._law.sf(begin)
            out = np.where(turned, 1.0, self._held(end, side) / np.maximum(begin_held, 1e-300))
            share = np.where(begin_held > 0.0, share * out, 0.0)
            begin, before = end, x
        return share

    def _held(self, x: Array, side: Array) -> Array:
        """S(x), x of shape (n,); near exact thresholds those below `side` are broken."""
        held = np.asarray(self._law.sf(x), dtype=float)
        for position, weight in zip(self.atoms, self._weights, strict=True):
            # rounding may put a contact on the wrong side
            near = np.abs(x - position) <= 1e-9 * position
            here = np.less(side, position * (1.0 - TIE)).astype(float)
            held += np.where(near, weight * (here - np.less(x, position)), 0.0)
        return held


class RateTable(Table):
    """H(x) at 0 <= x <= the last edge, polynomials on panels; 0 beyond.

    Parameters
    ----------
    function : takes x of shape (n,) and gives H, per time
    edges : array of shape (n,)
        Sorted; H may jump or bend there.
    scale : float
        The attempt frequency, per time.
    rounding : float
        Relative error of H by rounding.
    """

    def __init__(
        self, function: Callable[[Array], Array], edges: Array, scale: float, rounding: float
    ) -> None:
        accuracy, span = 1e-13, float(edges[-1])

        def found(x: Array) -> Array:
            return function(x.ravel()).reshape(1, *x.shape)

        def felt(values: Array, widths: Array) -> Array:
            most = np.maximum(np.abs(values[0]).max(axis=1), _NEVER * scale)
            # near a bend panels get narrow and add little to L
            return np.asarray(most / np.minimum(1.0, widths / (1e-3 * span)))

        given = found, edges, accuracy, 1e-13 * span
        super().__init__(*given, size=14, felt=felt, rounding=rounding / accuracy)

    def rate(self, x: Array) -> Array:
        """H at x >= 0; same shape."""
        return np.asarray(self(x)[0])

    def grown(self, x: Array) -> Array:
        """L, the integral of H from 0 to x, of either sign; same shape."""
        return np.sign(x) * self.before(np.abs(x))

    def mean(self, near: Array, far: Array) -> Array:
        """Mean of H over short ways from near to far on one side of 0; same shape."""
        near, far = np.abs(near), np.abs(far)
        at, weights = gauss(np.minimum(near, far), np.maximum(near, far))
        lengths = weights.sum(axis=-1)
        standing = lengths == 0.0
        sums = (weights * self.rate(at)).sum(axis=-1)
        return np.where(standing, self.rate(near), sums / np.where(standing, 1.0, lengths))
