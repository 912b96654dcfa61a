"""Contacts that all break at one mean rate H(x): the closure "paper" (Eqs. temper3, temper4)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre

from master.lives.cold import TIE
from master.lives.heat.above import Above
from master.lives.heat.mean_rate_sum import mean_rate
from master.lives.heat.replayed import ReplayedLife, rates_of
from master.lives.heat.stretches import Moves
from master.motion.motion import Legs
from origins import Contacts

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

# Nodes of a panel of the table, on (-1, 1), and from values at them to Legendre coefficients.
_SIZE = 14
_Z = legendre.leggauss(_SIZE)[0]
_TO_LEGENDRE = np.linalg.inv(legendre.legvander(_Z, _SIZE - 1)).T
# Of H on a panel: its last coefficients are no larger, relatively.
_ACCURACY = 1e-13
# H in units of the attempt frequency, below which it is known to this absolutely: 1e35 attempts.
_NEVER = 1e-35
# Roundings of a barrier: h is rounded by so many times it, and halving does not help.
_ROUNDINGS = 16.0 * float(np.finfo(float).eps)
_HALVINGS = 60
# of the reach: no length is told to less
_NARROW = 1e-13
# of the reach: in proportion to its width a panel narrower than this matters less
_FELT = 1e-3
# Gauss nodes along a short move: exact for the polynomials of the table
_SHORT_Z, _SHORT_W = legendre.leggauss(8)
_SHORT_Z, _SHORT_W = 0.5 * (_SHORT_Z + 1.0), 0.5 * _SHORT_W
# share of L, or of a panel: a move that adds less is integrated by itself, as the difference has
# lost 3 digits
_SHORT = 1e-3
_CHUNK = 400  # stretches at which H is summed at once
# Share of an exact threshold within which rounding may tell wrong on which side of it a contact is.
_TOLD = 1e-9
_LARGEST_SLOPE = 1.0 / np.e  # of e^-A over ln A: what a relative error of A is to the survival


class MeanRateLife(ReplayedLife):
    """What is left of contacts with P_T = P + H/v, a Life: not conditioned on survival.

    H(x), the integral of h(x; x_s) P_c(x_s) over x_s > |x|, is the rate of all contacts, and

        E = product over all ways out of S(|x_end|)/S(|x_begin|) exp(-integral of H over time),

    a way out being one on which |x| grows beyond |r|. As in App. C a contact that was pulled back and goes out
    again may break at all that it has passed before; on one leg E is S(|x|)/S(|r|) times the rest.

    Parameters
    ----------
    contacts : Contacts
        With thermal; independent stiffness.
    """

    def __init__(self, contacts: Contacts) -> None:
        rates = rates_of(contacts)
        self._above = Above(contacts.thresholds, rates, None)
        super().__init__(contacts.thresholds, self._above.edges)
        edges = np.unique(np.concatenate([[0.0, self.reach], self.bends, self._above.edges]))
        edges = edges[edges <= self.reach]
        barrier = float(np.log(rates.scale) - rates.log_rate(0.0, self.reach, 1.0))
        rounding = _ROUNDINGS * max(barrier, 1.0)
        self.table = RateTable(self._mean_rate, edges, rates.scale, rounding)
        at = self.table.between()
        once, again = self._mean_rate(at), self._mean_rate(at, parts=2)
        most = np.maximum(self.table.largest(), _NEVER * rates.scale)
        wrong = np.abs(again - once) + np.abs(self.table.rate(at) - again)
        felt = np.minimum(1.0, (self.table.high - self.table.low) / (_FELT * self.reach))
        self.error = _LARGEST_SLOPE * float((felt * wrong / most).max(initial=0.0))

    def _mean_rate(self, x: Array, parts: int = 1) -> Array:
        """H at stretches x >= 0, shape (n,), by its definition."""
        out = np.zeros(x.size)
        for begin in range(0, x.size, _CHUNK):
            some = slice(begin, begin + _CHUNK)
            out[some] = mean_rate(self._above, x[some], parts)
        for position, weight in zip(self.atoms, self._weights, strict=True):
            below = x < position
            out[below] += weight * self._above.rates.rate(x[below], position, 1.0)
        return out

    def _of(self, pair: Rows, born: Array, side: Array, moves: Moves, legs: Legs) -> Array:
        """See ReplayedLife."""
        spent = np.zeros(pair.size)
        for leg, speed in enumerate(legs.speed):
            duration = legs.duration[pair, leg]
            on = np.flatnonzero(duration > 0.0)
            near = (born + legs.displacement[pair, leg])[on]
            far = (born + legs.displacement[pair, leg + 1])[on]
            spent[on] += self._spent(near, far, speed, duration[on])
        share = np.clip(self._passed(pair, born, side, legs), 0.0, 1.0) * np.exp(-spent)
        return np.stack([share, share * (born + moves.now[pair])])

    def _passed(self, pair: Rows, born: Array, side: Array, legs: Legs) -> Array:
        """Share that has passed no threshold: S(|x|) at the end over the beginning of every way out."""
        first = np.abs(born)  # no threshold lies below
        share, begin, before = np.ones(pair.size), first, born
        for leg in range(legs.speed.size):
            x = born + legs.displacement[pair, leg + 1]
            # a way through 0 begins there, a way towards it ends where it began
            begin = np.where(before * x < 0.0, first, begin)
            end = np.maximum(np.abs(x), first)
            turned = end < begin
            begin_held = self._law.sf(begin)
            out = np.where(turned, 1.0, self._held(end, side) / np.maximum(begin_held, 1e-300))
            share = np.where(begin_held > 0.0, share * out, 0.0)
            begin, before = end, x
        return share

    def _held(self, x: Array, side: Array) -> Array:
        """S(x), x of shape (n,), with exact thresholds as `side` tells near them."""
        held = np.asarray(self._law.sf(x), dtype=float)
        for position, weight in zip(self.atoms, self._weights, strict=True):
            near = np.abs(x - position) <= _TOLD * position
            here = np.less(side, position * (1.0 - TIE)).astype(float)
            held += np.where(near, weight * (here - np.less(x, position)), 0.0)
        return held

    def _spent(self, near: Array, far: Array, speed: float, duration: Array) -> Array:
        """The integral of H over the time of one leg; all of shape (n,)."""
        if speed == 0.0:
            return duration * self.table.rate(np.abs(near))
        before, after = self.table.grown(near), self.table.grown(far)
        gone = np.abs(after - before)
        lost = (gone < _SHORT * np.abs(after)) | self.table.within_little(near, far)
        short = np.flatnonzero(lost)
        gone[short] = self.table.mean(near[short], far[short]) * duration[short] * abs(speed)
        return gone / abs(speed)


class RateTable:
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
        low, high, kept = edges[:-1], edges[1:], []
        before = np.full(low.size, np.inf)
        for _ in range(_HALVINGS):
            width = (high - low)[:, None]
            x = low[:, None] + 0.5 * width * (_Z + 1.0)
            values = function(x.ravel()).reshape(x.shape)
            series = values @ _TO_LEGENDRE
            most = np.maximum(np.abs(values).max(axis=1), _NEVER * scale)
            tail = np.abs(series[:, -2:]).max(axis=1) / most
            # beside a bend the panels get narrow, and what they add to L gets little
            rough = tail > _ACCURACY / np.minimum(1.0, width[:, 0] / (_FELT * edges[-1]))
            rough &= (tail > rounding) | (tail < 0.3 * before)
            rough &= width[:, 0] > _NARROW * edges[-1]
            kept.append((low[~rough], high[~rough], series[~rough]))
            low, high, before = low[rough], high[rough], np.tile(tail[rough], 2)
            if not low.size:
                break
            middle = 0.5 * (low + high)
            low, high = np.append(low, middle), np.append(middle, high)
        low, high, series = (np.concatenate(part) for part in zip(*kept, strict=True))
        order = low.argsort()
        self.low, self.high = low[order], high[order]
        self._rate = series[order].T
        half = 0.5 * (self.high - self.low)
        self._grown = half * legendre.legint(self._rate, lbnd=-1.0)
        self._before = np.append(0.0, np.cumsum(2.0 * half * self._rate[0]))

    def between(self) -> Array:
        """Points within the panels, away from their nodes, where the table may be checked."""
        return self.low + 0.5 * (self.high - self.low) * (1.0 + 0.5 * (_Z[0] + _Z[1]))

    def largest(self) -> Array:
        """Largest H at the ends and in the middle of each panel, shape (panels,)."""
        signs = (-1.0) ** np.arange(_SIZE)[:, None]
        ends = np.stack([self._rate.sum(axis=0), (signs * self._rate).sum(axis=0), self._rate[0]])
        return np.abs(ends).max(axis=0)

    def _at(self, x: Array) -> tuple[Rows, Array]:
        """Panel of each x >= 0, and the place on it between -1 and 1."""
        panel = np.clip(np.searchsorted(self.low, x, "right") - 1, 0, self.low.size - 1)
        z = (2.0 * x - self.low[panel] - self.high[panel]) / (self.high - self.low)[panel]
        return panel, np.minimum(z, 1.0)

    def rate(self, x: Array) -> Array:
        """H at x >= 0; same shape."""
        panel, z = self._at(x)
        found = legendre.legval(z, self._rate[:, panel], tensor=False)
        return np.where(x > self.high[-1], 0.0, found)

    def grown(self, x: Array) -> Array:
        """L, the integral of H from 0 to x, of either sign; same shape."""
        panel, z = self._at(np.abs(x))
        part = legendre.legval(z, self._grown[:, panel], tensor=False)
        return np.sign(x) * (self._before[panel] + part)

    def within_little(self, near: Array, far: Array) -> npt.NDArray[np.bool_]:
        """Whether a way, on one side of 0, is short against the panel that it ends on."""
        panel = self._at(np.abs(far))[0]
        way = np.abs(far - near)
        return (near * far >= 0.0) & (way < _SHORT * (self.high - self.low)[panel])

    def mean(self, near: Array, far: Array) -> Array:
        """Mean of H on short ways on one side of 0, across one edge at most; same shape."""
        near, far = np.minimum(np.abs(near), np.abs(far)), np.maximum(np.abs(near), np.abs(far))
        way = far - near
        at = np.clip(self.low[self._at(far)[0]], near, far)
        first = np.where(way > 0.0, (at - near) / np.where(way > 0.0, way, 1.0), 0.0)
        out = np.zeros(way.shape)
        for node, weight in zip(_SHORT_Z, _SHORT_W, strict=True):
            out += weight * first * self.rate(np.minimum(near + node * (at - near), at))
            out += weight * (1.0 - first) * self.rate(at + node * (far - at))
        return out
