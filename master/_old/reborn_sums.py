"""<x_b - r> and <k (x_b^2 - r^2)> of contacts that form again at stretches r of a law and break at rates of their own.

From r on a contact of the threshold ξ travels t(r) and does the work k u(r) on the way to its break, with h its rate,

    t' = (h/v) t - 1,        u' = (h/v) u - x,        t = u = 0 at x = ξ:

one line from ξ down to -ξ for all births together, which knows nothing of their law. Sums over these follow it panel by
panel, where t is a polynomial at Radau's nodes: whatever h is, a panel gives t at its lower end as P t + Q.
"""

import numpy as np
import numpy.typing as npt

from master._old.break_sums import law_edges
from master._old.panels import MOST_NODES, radau
from master._old.starting import thin
from origins import Contacts

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

_EVEN = 21
_PARTS = 16.0  # of its span, in each of which one edge leads to what is narrower
# ln(A/v) of relaxed contacts, at panels' edges: nothing is spent below, and those formed above break at once
_LEVELS = np.concatenate(
    [
        [-32.0, -24.0, -17.0, -12.0, -9.0, -6.5, -4.6, -3.2, -2.1, -1.2, -0.4, 0.3, 0.9, 1.5, 2.1, 2.7, 3.3, 3.9, 4.6],
        [5.4, 6.4, 7.6, 9.0, 10.6, 12.6, 14.6, 16.6, 18.6, 21.0, 23.4, 26.0, 29.0, 32.0],
    ]
)
_FORGOTTEN = 4.2  # what A/v is e to the power of where nothing comes back to those below a tenth of that
_RUNGS = 1.5 * np.arange(1.0, 60.0)  # barriers in k_BT, beyond the last level
_LAYER = np.array([0.1, 0.4, 1.0, 2.5, 6.0, 12.0, 25.0, 45.0])  # A/v from the threshold down
_ROOTED = 45.0 * 5.0 ** np.arange(1.0, 20.0)  # the same above which t is 1 over the root of a stiff contact's rate
_PLACES = np.array([-0.7, -0.35, 0.0, 0.35, 0.7])  # of (-1, 1), if nothing else is between
_STRONG = 1e12  # k x_s^2 over k_BT
_UNFELT, _SAME = 1e-18, 1e-15
_FLAT = 2.0  # of A/v along a panel: less is seen through by polynomials as it is
_PANELS = 12_000
_RULE = radau(MOST_NODES)
_NODES, _WEIGHTS = _RULE.nodes, _RULE.weights
_SLOPES = _RULE.slopes(_NODES)  # from the value at 0 and those at the nodes
_FROM, _MATRIX = -_SLOPES[:, 0], _SLOPES[:, 1:]
_SUMS = np.linalg.inv(_MATRIX)  # integrals from 0 up to each node
_SERIES = np.linalg.inv(np.polynomial.legendre.legvander(2.0 * _NODES - 1.0, MOST_NODES - 1))
_FALL = (2 * MOST_NODES - 1 - (MOST_NODES - 1.5)) / (MOST_NODES - 1.5)  # the sum misses the coefficient 2 N - 1


class RebornBreaks:
    """Means over r of x_b - r and k (x_b^2 - r^2) at given thresholds, at all speeds, r weighted by Q(r)/S(|r|).

    Attributes
    ----------
    log_speeds : array of shape (n,)
    inverse : float
        Relative error of the means.
    missed : array
        What sums over r may miss, at the last thresholds asked for.
    """

    inverse = 1e-10

    def __init__(self, contacts: Contacts, speeds: Array) -> None:
        assert contacts.thermal is not None and contacts.reforming is not None
        self.contacts, self.thermal, self.log_speeds = contacts, contacts.thermal, np.log(speeds)
        self.missed = np.empty(0)
        self._births, law = contacts.reforming, contacts.thresholds
        self._law = self._births.law
        low, high = self._law.span
        marks = np.concatenate([law.breakpoints, law.atoms[0]])
        held = law_edges(law)  # where 1/S changes
        near = thin(held[law.cdf(held) > _UNFELT], (high - low) / _PARTS)
        even = np.linspace(low, high, _EVEN)
        whole = np.unique(np.concatenate([even, self._law.breakpoints, marks, -marks, near, -near]))
        self._edges = whole[(whole >= low) & (whole <= high)]

    def __call__(self, thresholds: Array) -> Array:
        """Shape (2, thresholds, speeds)."""
        out, self.missed = np.zeros((2, 2, thresholds.size * self.log_speeds.size))
        row = np.repeat(np.arange(thresholds.size), self.log_speeds.size)
        speed = np.tile(self.log_speeds, thresholds.size)
        stiffness = np.asarray(self.contacts.relative_stiffness(thresholds))
        per = max(1, _PANELS // (self._edges.size + _LEVELS.size))
        # barriers so high that none breaks before its threshold by more than is felt, nor than x is rounded
        strong = (stiffness * thresholds**2 > _STRONG * self.thermal.temperature)[row]
        out[:, strong] = self._kept(thresholds, stiffness)[:, row[strong]]
        others = np.flatnonzero(~strong)
        for i in range(0, others.size, per):
            here = others[i : i + per]
            at = row[here]
            out[:, here], self.missed[:, here] = self._followed(thresholds[at], stiffness[at], speed[here])
        shape = 2, thresholds.size, self.log_speeds.size
        self.missed = self.missed.reshape(shape)
        return out.reshape(shape)

    def share(self, thresholds: Array) -> Array:
        """Integral of Q(r)/S(|r|) over those r that the thresholds hold."""
        return self._moments(thresholds)[0]

    def _moments(self, thresholds: Array) -> Array:
        """The same, with r, and with r^2, shape (3, n)."""
        edges = np.clip(self._edges, -thresholds[:, None], thresholds[:, None])
        left, width = edges[:, :-1, None], np.diff(edges, axis=1)[..., None]
        births = left + width * _NODES
        weights = width * _WEIGHTS * self._weight(births)
        return np.stack([(weights * births**power).sum(axis=(1, 2)) for power in range(3)])

    def _kept(self, thresholds: Array, stiffness: Array) -> Array:
        """Both means, shape (2, n), of contacts that break at their thresholds."""
        held, first, second = self._moments(thresholds)
        return np.stack([held * thresholds - first, stiffness * (held * thresholds**2 - second)])

    def _weight(self, births: Array) -> Array:
        """Q(r)/S(|r|)."""
        held = self.contacts.thresholds.sf(np.abs(births))
        density = self._law.pdf(births) / (1.0 - self._births.cut_weight)
        return np.divide(density, held, out=np.zeros_like(held), where=held > 0.0)

    def _followed(self, threshold: Array, stiffness: Array, log_speed: Array) -> tuple[Array, Array]:
        """Both means, and what they may miss, of contacts of each threshold at its speed, shapes (2, n)."""
        edges, turn = self._panels(threshold, stiffness, log_speed)
        stretch = self._stretch(edges, threshold[:, None])[0]
        felt = np.diff(self._law.cdf(stretch), axis=1) > _UNFELT
        ever = np.logical_or.accumulate
        # below all births, and so far above them that nothing comes back
        wanted = ever(felt, axis=1) & (ever(felt[:, ::-1], axis=1)[:, ::-1] | (stretch[:, :-1] < turn[:, None]))
        row, panel = np.nonzero(wanted & (np.diff(edges, axis=1) > 0.0))
        out = np.zeros((2, 2, threshold.size))
        if not row.size:
            return out[0], out[1]
        left, right = edges[row, panel], edges[row, panel + 1]
        width = (right - left)[:, None]
        x, along = self._stretch(right[:, None] - width * _NODES, threshold[row, None])
        along *= width
        speed = np.exp(log_speed[row, None])
        rate = self.thermal.plain_rate(x, threshold[row, None], stiffness[row, None])
        kept, gained = _carried(rate / speed * along, np.stack([along, along * x]))
        begin = self._begins(row, right, (kept[:, -1], gained[:, :, -1]), threshold, stiffness, log_speed)
        parts = along * self._weight(x) * (kept * begin[..., None] + gained)
        series = np.abs(parts @ _SERIES.T)
        last, largest = series[..., -2:].max(axis=-1), series.max(axis=-1)
        lost = last * np.divide(last, largest, out=np.zeros_like(last), where=largest > 0.0) ** _FALL
        for total, panels in zip(out, (parts @ _WEIGHTS, lost), strict=True):
            total[:] = [np.bincount(row, weights=one, minlength=threshold.size) for one in panels]
        out[:, 1] *= 2.0 * stiffness
        return out[0], out[1]

    def _begins(
        self,
        row: Rows,
        right: Array,
        ends: tuple[Array, Array],
        threshold: Array,
        stiffness: Array,
        log_speed: Array,
    ) -> Array:
        """t and u at the panels' upper ends, shape (2, n), from the highest panel of each row on: 0 at a threshold, and
        what breaks at once leaves where no panel gets there."""
        kept, gained = ends
        place = np.searchsorted(row, np.arange(threshold.size), side="right")[row] - 1 - np.arange(row.size)
        value, begin = np.zeros((2, threshold.size)), np.empty((2, row.size))
        top = row[place == 0]
        highest = self._stretch(right[place == 0], threshold[top])[0]
        cut = highest < threshold[top] * (1.0 - _SAME)
        top, highest = top[cut], highest[cut]
        value[0, top] = np.exp(log_speed[top]) / self.thermal.plain_rate(highest, threshold[top], stiffness[top])
        value[1, top] = value[0, top] * highest
        for step in range(int(place.max()) + 1):
            now = np.flatnonzero(place == step)
            begin[:, now] = value[:, row[now]]
            value[:, row[now]] = kept[now] * value[:, row[now]] + gained[:, now]
        return begin

    def _panels(self, threshold: Array, stiffness: Array, log_speed: Array) -> tuple[Array, Array]:
        """Edges of panels from -ξ to ξ, as places, shape (n, m); and the stretches from which nothing comes back."""
        limit, speed = threshold[:, None], log_speed[:, None]
        levels = self.thermal.inverse_from_rest(speed + np.append(_LEVELS, _FORGOTTEN), limit, stiffness[:, None])
        levels, turn = levels[:, :-1], levels[:, -1]
        rungs = np.sqrt(2.0 * self.thermal.temperature * _RUNGS / stiffness[:, None])
        rungs = np.where(rungs > levels[:, -1:], rungs, limit)
        stiff = self.thermal.rates.vanishes_at_threshold
        layer = np.append(_LAYER, _ROOTED) if stiff else _LAYER
        layer = layer * np.exp(speed) / (self.thermal.attempt_frequency * limit)
        layer = limit * (1.0 - (np.cbrt(1.5 * layer) ** 2 if stiff else layer))
        layer = np.where(layer > 0.0, layer, limit)
        ahead = np.minimum(np.concatenate([levels, rungs, layer], axis=1), limit)
        own = np.clip(self._edges, -limit, limit)
        edges = np.concatenate([ahead, -ahead, own, limit, -limit], axis=1) / limit
        if stiff:
            edges = np.sign(edges) * (1.0 - np.sqrt(1.0 - np.abs(edges)))
        places = np.broadcast_to(_PLACES, (threshold.size, _PLACES.size))
        return np.sort(np.append(edges, places, axis=1), axis=1), turn

    def _stretch(self, place: Array, threshold: Array) -> tuple[Array, Array]:
        """Stretches at places from -1 to 1, and their slope: in roots of the distance from the threshold where rates
        have such."""
        if not self.thermal.rates.vanishes_at_threshold:
            return threshold * place, np.broadcast_to(threshold, place.shape).copy()
        size = np.abs(place)
        return threshold * place * (2.0 - size), 2.0 * threshold * (1.0 - size)


def _carried(spent: Array, gain: Array) -> tuple[Array, Array]:
    """What of a value at a panel's upper end is left at its nodes, shape (n, 8), and what is gained up to there, shape
    (2, n, 8), from h/v and from gains along a panel."""
    kept, gained = np.empty_like(spent), np.empty_like(gain)
    flat = spent.max(axis=1) < _FLAT
    growth = np.exp(spent[flat] @ _SUMS.T)
    kept[flat] = 1.0 / growth
    gained[:, flat] = (gain[:, flat] * growth) @ _SUMS.T * kept[flat]
    steep = np.flatnonzero(~flat)
    if steep.size:
        system = np.broadcast_to(_MATRIX, (steep.size, MOST_NODES, MOST_NODES)).copy()
        k = np.arange(MOST_NODES)
        system[:, k, k] += spent[steep]
        given = np.stack([np.broadcast_to(_FROM, (steep.size, MOST_NODES)), *gain[:, steep]], axis=-1)
        found = np.linalg.solve(system, given)
        kept[steep], gained[:, steep] = found[..., 0], np.moveaxis(found[..., 1:], -1, 0)
    return kept, gained
