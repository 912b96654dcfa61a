"""<x_b - r> and <k (x_b^2 - r^2)> of contacts that form again at stretches r of a law and break at rates of their own.

As for relaxed births (master.break_sums) by sums over ln e, where a contact breaks at A(x; ξ) - A(r; ξ) = v e; at each
threshold by panels over those r that it holds. One that forms behind x = 0 and gets there goes on as a relaxed one.
"""

import numpy as np
import numpy.typing as npt

from master.break_sums import Breaks, missed
from master.starting import thin
from origins import Contacts
from origins.quadrature import gauss

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

_EVEN, _MOST_EVEN = 13, 27  # edges over the law of births
_PARTS = 16.0  # of its span, in each of which one edge leads to what is narrower
_ENDS = np.array([0.9, 0.99])  # of the threshold: beside it rates of stiff contacts have a root
_UNFELT = 1e-18
_PAIRS = 200_000


class RebornBreaks(Breaks):
    """Means over r of x_b - r and k (x_b^2 - r^2) at given thresholds, at all speeds, r weighted by Q(r)/S(|r|)."""

    inverse = 5e-10
    widest = 1.2  # those that may turn at 0 do so anywhere

    def __init__(self, contacts: Contacts, speeds: Array) -> None:
        super().__init__(contacts, speeds)
        assert contacts.reforming is not None
        self._births, law = contacts.reforming, contacts.thresholds
        self._law = self._births.law
        self._low, self._high = self._law.span
        span = self._high - self._low
        marks = np.concatenate([law.breakpoints, law.atoms[0]])
        near = thin(np.sort(np.append(law.panels if law.panels is not None else marks, marks)), span / _PARTS)
        # rates change within one k_BT
        change = self.thermal.temperature / contacts.mean_threshold
        even = np.linspace(self._low, self._high, int(np.clip(span / change, _EVEN, _MOST_EVEN)))
        edges = np.concatenate([even, self._law.breakpoints, marks, -marks, near, -near, [0.0]])
        self._edges = np.unique(edges[(edges >= self._low) & (edges <= self._high)])

    def __call__(self, thresholds: Array) -> Array:
        """Shape (2, thresholds, speeds); what the sums over r may miss is added to `missed`, of the same shape."""
        out = np.zeros((2, thresholds.size, self.log_speeds.size))
        self.missed = np.zeros_like(out)
        row, births, weights = self._nodes(thresholds)
        behind = births[:, 0] < 0.0
        relaxed = super().__call__(thresholds) if behind.any() else out
        per = max(1, _PAIRS // (self.log_amount.size * births.shape[1]))
        for way in (behind, ~behind):
            found = np.flatnonzero(way)
            for i in range(0, found.size, per):
                at = found[i : i + per]
                limit = np.repeat(thresholds[row[at]], births.shape[1])
                stiffness = np.asarray(self.contacts.relative_stiffness(limit))
                goal = np.zeros(limit.size) if way is behind else limit
                parts, gone = self.means(limit, stiffness, births[at].ravel(), goal)
                parts[1] *= stiffness[:, None]
                if way is behind:
                    parts += np.exp(-gone) * np.repeat(relaxed[:, row[at]], births.shape[1], axis=1)
                parts = parts.reshape(2, at.size, births.shape[1], -1) * weights[at, :, None]
                sums, lost = parts.sum(axis=2), missed(parts)
                for k in range(2):
                    np.add.at(out[k], row[at], sums[k])
                    np.add.at(self.missed[k], row[at], lost[k])
        return out

    def share(self, thresholds: Array) -> Array:
        """Integral of Q(r)/S(|r|) over those r that the thresholds hold."""
        row, _, weights = self._nodes(thresholds)
        return np.bincount(row, weights=weights.sum(axis=1), minlength=thresholds.size).astype(float)

    def _nodes(self, thresholds: Array) -> tuple[Rows, Array, Array]:
        """Which threshold, of each panel over r; r and its weight at the panels' nodes, shape (n, 8)."""
        law = self.contacts.thresholds
        ends = thresholds[:, None] * np.concatenate([-_ENDS, _ENDS])
        own = np.broadcast_to(self._edges, (thresholds.size, self._edges.size))
        edges = np.clip(np.concatenate([own, ends], axis=1), self._low, self._high)
        edges = np.sort(np.clip(edges, -thresholds[:, None], thresholds[:, None]), axis=1)
        row, panel = np.nonzero(np.diff(edges, axis=1) > 0.0)
        nodes, weights = gauss(edges[row, panel], edges[row, panel + 1])
        held = law.sf(np.abs(nodes))
        density = self._law.pdf(nodes) / (1.0 - self._births.cut_weight)
        weights = np.divide(weights * density, held, out=np.zeros_like(held), where=held > 0.0)
        keep = weights.max(axis=1) > _UNFELT
        return row[keep], nodes[keep], weights[keep]
