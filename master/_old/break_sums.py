"""<x_b> and <k x_b^2> of relaxed contacts that break at rates of their own, by sums over thresholds and over ln A.

A contact with the threshold ξ breaks at min(ξ, x), A(x; ξ) = v e with e from the exponential law of mean 1. In ln e the
stretch x is smooth at any temperature and speed. Panels over ln A serve all thresholds and all speeds of one
temperature together, but for the last, which ends where A is that of the threshold. Panels over ξ are halved until each
is good at every speed, judged by how its Legendre coefficients fall: two sums may agree by chance, but hardly panel by
panel and without signs.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
from numpy.polynomial.legendre import legvander

from origins import Contacts, Thresholds
from origins.thresholds.quadrature import GAUSS_NODES, NODES, finite_density, gauss, panel_edges

if TYPE_CHECKING:
    from master._old.reborn_sums import RebornBreaks

Array = npt.NDArray[np.float64]

_LEAST, _MOST = -32.0, 3.65  # ln e: little is spent below, nothing is left above
_OVER = 7.0  # of ln e, where e to -e is 0 and e not yet large
_EVEN = -1.0  # ln e down to which panels are even
_WIDTH, _WIDER, _WIDEST = 0.6, 1.3, 4.0
_CUTS = np.array([1.0, 0.8, 0.58, 0.33, 0.0])  # of the cube root of ln A below a stiff contact's last: x has power 2/3
_RUNG = 1.5  # in k_BT
_UNTRIED, _TRIED = 1e-2, 1.0  # attempts on the way to a threshold, and the logarithm from one to the next edge
_ACCURACY, _TAIL = 1e-12, 1e-80
_COMMON, _SLIGHT = 1e-20, 1e-3  # shares of thresholds; of what a panel may miss
_BEYOND = 2.0  # of what lies beyond
_NOISE, _SUMS = 1e-10, 1e-10  # of moments: beyond, what is left of them is not noise; and of what is left
_GOOD, _DEPTH = 1e-11, 40  # of the whole, at which a panel is not halved
# width times the Legendre coefficients of a panel, from its nodes' shares of the sum
_LEGENDRE = (2.0 * np.arange(NODES)[:, None] + 1.0) * legvander(2.0 * GAUSS_NODES - 1.0, NODES - 1).T
_FALL = (2 * NODES - (NODES - 1.5)) / (NODES - 1.5)  # the sum misses the coefficient 2 NODES; the last two are known


def summable(contacts: Contacts) -> bool:
    """Whether breaks are by a rate of each contact's own and thresholds for life, and births relaxed or spread over
    many stretches."""
    thermal = contacts.thermal
    exact = thermal is not None and thermal.closure == "exact" and contacts.ageing is None and contacts.grains is None
    return exact and (contacts.reforming is None or not contacts.reforming.law.is_single)


def law_edges(law: Thresholds) -> Array:
    """Edges of panels over the thresholds at any temperature and speed; none where all thresholds are exact values."""
    if float(law.atoms[1].sum()) >= 1.0 - 1e-14:
        return np.empty(0)
    # slow contacts hold on to their strongest thresholds: the far tail counts
    return panel_edges(law, accuracy=_ACCURACY, tail=_TAIL)


def summed(contacts: Contacts, speeds: Array, edges: Array | None = None) -> Array:
    """Force without a wait, its error, C and its error (lengths) at each speed, shape (4, n); of contacts that are
    `summable`, on panels from `edges`, those of the law where None."""
    law, breaks = contacts.thresholds, _breaks(contacts, speeds)
    edges = law_edges(law) if edges is None else edges
    positions, shares = law.atoms
    whole, off = np.zeros((2, speeds.size)), np.zeros((2, speeds.size))
    if positions.size:
        whole += shares @ breaks(positions)
        exact = 0.0 if breaks.missed is None else shares @ breaks.missed
    if edges.size:
        if contacts.reforming is None:  # else births at many stretches make sums even
            edges = _by_barriers(contacts, edges, float(speeds.min()))
        whole, off = _over_thresholds(contacts, breaks, edges, whole)
    if positions.size:
        off = off + exact
    (length, square), (length_off, square_off) = whole, off
    with np.errstate(divide="ignore", invalid="ignore"):
        force = 0.5 * square / length
        # infinite where squares of stretches are below all numbers
        force_off = 0.5 * square_off / length + np.abs(force) * (length_off / length + breaks.inverse)
        force_off = np.where(square == 0.0, np.inf, force_off)
    return np.stack([force, force_off, length, length_off + breaks.inverse * length])


def _breaks(contacts: Contacts, speeds: Array) -> Breaks | RebornBreaks:
    if contacts.reforming is None:
        return Breaks(contacts, speeds)
    from master._old.reborn_sums import RebornBreaks

    return RebornBreaks(contacts, speeds)


def _over_thresholds(
    contacts: Contacts, breaks: Breaks | RebornBreaks, edges: Array, whole: Array
) -> tuple[Array, Array]:
    """`whole`, of exact thresholds, and the sums over a density of others, and what these miss; shapes (2, speeds)."""
    law, off, known = contacts.thresholds, np.zeros_like(whole), np.zeros(2)
    # none breaks beyond its threshold: what rare ones count at most. Where all others have long broken that is a lot
    weight = np.maximum(law.sf(edges[:-1]) - law.sf(edges[1:]), 0.0) * breaks.share(edges[1:])
    limits = _limits(contacts, edges[1:], weight)
    common = weight > _COMMON
    for these in (common, ~common):
        counts = these & (limits > _GOOD * _SLIGHT * np.abs(whole).min(axis=1)[:, None]).any(axis=0)
        slight = limits[:, these & ~counts].sum(axis=1)
        off, known = off + slight[:, None], known + slight
        left, right = edges[:-1][counts], edges[1:][counts]
        for depth in range(_DEPTH):
            if not left.size:
                break
            nodes, weights = gauss(left, right)
            mass = weights * finite_density(law, nodes)
            parts = mass[..., None] * breaks(nodes.ravel()).reshape(2, *nodes.shape, breaks.log_speeds.size)
            sums, lost = parts.sum(axis=2), missed(parts)
            middle = 0.5 * (left + right)
            level = _GOOD * np.abs(whole + sums.sum(axis=1))[:, None]
            open_ = (lost > level).any(axis=(0, 2)) & (middle > left) & (middle < right) & (depth < _DEPTH - 1)
            known = known + _limits(contacts, nodes[~open_].ravel(), mass[~open_].ravel()).sum(axis=1)
            whole, off = whole + sums[:, ~open_].sum(axis=1), off + lost[:, ~open_].sum(axis=1)
            if isinstance(breaks.missed, np.ndarray):
                over_births = mass[..., None] * breaks.missed.reshape(parts.shape)
                off = off + over_births[:, ~open_].sum(axis=(1, 2))
            left, right = np.append(left[open_], middle[open_]), np.append(middle[open_], right[open_])
    tail = _tail(contacts, edges[-1:], known)[:, None]
    # the stronger a contact, the less it breaks before its threshold
    last = breaks(edges[-1:])[:, 0] / _limits(contacts, edges[-1:], np.ones(1))
    held = breaks.share(edges[-1:])
    beyond = _BEYOND * _limits(contacts, edges[-1:], np.asarray(law.sf(edges[-1:])) * held)
    off = off + np.where(tail > 0.0, tail * (np.maximum(held - last, 0.0) + _SUMS), beyond)
    return whole + np.where(whole > 0.0, tail * last, 0.0), off


def _tail(contacts: Contacts, last: Array, known: Array) -> Array:
    """What thresholds beyond the `last` edge add to <x_s> and <k x_s^2>: these have closed forms, and how much of them
    is `known` from sums. 0 where it is next to nothing."""
    law = contacts.thresholds
    power, unit = (3, contacts.mean_threshold) if contacts.stiffness == "linked" else (2, 1.0)
    positions, shares = law.atoms
    known = known + _limits(contacts, positions, shares).sum(axis=1)
    whole = np.array([law.moment(1), law.moment(power) / unit])
    # of laws with light tails nothing is left but what the sums are off by
    return np.where(whole - known > _NOISE * whole, whole - known, 0.0)


def _limits(contacts: Contacts, thresholds: Array, weight: Array) -> Array:
    """The most that thresholds of some weight can add to <x_b> and <k x_b^2>, shape (2, n)."""
    return weight * np.stack([thresholds, contacts.relative_stiffness(thresholds) * thresholds**2])


def missed(parts: Array) -> Array:
    """What the sum of each panel misses, from its nodes' shares; (2, panels, nodes, speeds) to (2, panels, speeds)."""
    series = np.abs(_LEGENDRE @ parts)
    largest, last = series.max(axis=2), series[:, :, -2:].max(axis=2)
    fall = np.divide(last, largest, out=np.zeros_like(last), where=largest > 0.0)
    return np.asarray(last * fall**_FALL)


class Breaks:
    """Mean x_b and k x_b^2 of relaxed contacts at given thresholds, at all speeds."""

    inverse = 2e-12  # relative error of the sums over ln A, and of a short stretch found from its amount
    missed: Array | None = None  # by sums over births, at the last thresholds asked for

    def __init__(self, contacts: Contacts, speeds: Array) -> None:
        assert contacts.thermal is not None
        self._contacts, self._thermal, self.log_speeds = contacts, contacts.thermal, np.log(speeds)
        slow, fast = float(self.log_speeds.min()), float(self.log_speeds.max())
        top, bottom = fast + _MOST, slow + _EVEN
        even = np.linspace(bottom, top, 2 + int((top - bottom) / _WIDTH))
        far = bottom - np.cumsum(np.minimum(_WIDTH * _WIDER ** np.arange(1.0, 80.0), _WIDEST))
        lowest = slow + _LEAST
        self._edges = np.concatenate([[lowest], far[far > lowest + 0.5 * _WIDEST][::-1], even])
        nodes, weights = gauss(self._edges[:-1], self._edges[1:])
        self._log_amount = nodes.ravel()
        self._weights = weights.ravel()[:, None] * _weight(nodes.ravel()[:, None] - self.log_speeds)
        # a panel may end where that of a stiff contact's threshold is as far as it is wide
        apart = np.diff(self._edges) if self._thermal.rates.vanishes_at_threshold else 0.0
        self._usable_from = self._edges[1:] + apart

    def __call__(self, thresholds: Array) -> Array:
        """Shape (2, thresholds, speeds)."""
        stiffness = np.asarray(self._contacts.relative_stiffness(thresholds))
        ends = self._thermal.log_cumulative(thresholds, thresholds, 0.0, stiffness)
        count = np.searchsorted(self._usable_from, ends, side="right")
        some = NODES * int(count.max(initial=0))
        x = self._thermal.inverse_from_rest(self._log_amount[:some], thresholds[:, None], stiffness[:, None])
        x = np.where(np.arange(some) >= NODES * count[:, None], 0.0, x)
        rest = np.exp(-np.exp(np.minimum(ends[:, None] - self.log_speeds, _OVER)))
        weights, limit = self._weights[:some], thresholds[:, None]
        out = np.stack([x @ weights + rest * limit, (x * x) @ weights + rest * limit**2])
        inside = np.flatnonzero((ends > self._edges[0]) & (count < self._edges.size - 1))
        if inside.size:
            self._add_last(out, inside, self._edges[count[inside]], ends[inside], thresholds[inside], stiffness[inside])
        out[1] *= stiffness[:, None]
        return out

    def share(self, thresholds: Array) -> Array:
        """Weight of the births that these thresholds hold, over the survival there: relaxed ones, all."""
        return np.ones(thresholds.size)

    def _add_last(
        self,
        out: Array,
        rows: npt.NDArray[np.intp],
        begin: Array,
        end: Array,
        threshold: Array,
        stiffness: Array,
    ) -> None:
        """What breaks between the last panel and the threshold."""
        if self._thermal.rates.vanishes_at_threshold:
            roots = np.cbrt(end - begin)[:, None] * _CUTS
            nodes, weights = (part.reshape(rows.size, -1) for part in gauss(roots[:, 1:], roots[:, :-1]))
            nodes, weights = end[:, None] - nodes**3, 3.0 * nodes * nodes * weights
        else:
            nodes, weights = gauss(begin, end)
        x = self._thermal.inverse_from_rest(nodes, threshold[:, None], stiffness[:, None])
        first, second = weights * x, weights * x * x
        for i, log_speed in enumerate(self.log_speeds):
            felt = np.flatnonzero((begin < log_speed + _MOST) & (end > log_speed + _LEAST))
            weight = _weight(nodes[felt] - log_speed)
            out[0, rows[felt], i] += np.einsum("ij,ij->i", weight, first[felt])
            out[1, rows[felt], i] += np.einsum("ij,ij->i", weight, second[felt])


def _weight(log_e: Array) -> Array:
    """Density of ln e."""
    power = np.minimum(log_e, _OVER)
    return np.asarray(np.exp(power - np.exp(power)))


def _by_barriers(contacts: Contacts, edges: Array, slowest: float) -> Array:
    """Edges between thresholds, with those where the barrier of a relaxed contact is a rung higher: from an amount that
    it spends at once to one that brings it close to its threshold, x goes within one k_BT. And with those between
    thresholds at which contacts have made some attempts, and more."""
    thermal = contacts.thermal
    assert thermal is not None
    lowest, highest = float(edges[0]), float(edges[-1])
    # what h spends on its way is at most that of an attempt at each moment
    spent = np.log(max(thermal.attempt_frequency * highest / slowest, 1.0))
    barriers = np.arange(_RUNG, -_LEAST + spent + _RUNG, _RUNG)
    if contacts.stiffness == "linked":
        rungs = np.cbrt(2.0 * thermal.temperature * contacts.mean_threshold * barriers)
    else:
        rungs = np.sqrt(2.0 * thermal.temperature * barriers)
    # thresholds so low that they are reached before the first attempt
    least = max(lowest, _UNTRIED * slowest / thermal.attempt_frequency)
    steps = int(np.log(max(highest / least, 1.0)) / _TRIED)
    inner = np.append(rungs, np.geomspace(least, highest, 2 + steps))
    return np.unique(np.append(edges, inner[(inner > lowest) & (inner < highest)]))
