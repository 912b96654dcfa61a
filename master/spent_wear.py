"""Contacts that break at rates h(|x|; ξ) of any form, with closure "exact": what temperature has cost so far.

For every strand the integral A(ξ) of h over time stands at the nodes of the law of thresholds. While the slider goes
on at one speed that part of it is closed, and added afresh from where it began; what went before is kept, beyond m
also at nodes of its own in the root of ξ - m, as the rate of stiff contacts has a root at the threshold.
"""

import numpy as np
import numpy.typing as npt

from master.cut_law import SLACK, CutLaw
from master.thermal_wear import error_of, fresh_rate
from master.wear import Left, Standing
from origins import Contacts
from origins.quadrature import GAUSS_NODES, NODES

Array = npt.NDArray[np.float64]
Numbers = npt.NDArray[np.intp]

_MOST = 500.0  # e^(-A) is nothing
_SAME = 1e-9
_LAYER = 1e-4  # of a panel's weight
_TINY = 1e-12  # a threshold of 0 has no rate
_APART = GAUSS_NODES[:, None] - GAUSS_NODES
np.fill_diagonal(_APART, 1.0)
_BARYCENTRIC = 1.0 / _APART.prod(axis=1)
_FROM, _WAY, _TIME, _CUT, _FIRST = range(5)  # columns before those of nodes, atoms, and nodes of a strand's own


class SpentWear:
    """Soft or stiff contacts, equally stiff or not; `plain`: few of them, for which numpy does as well."""

    def __init__(self, contacts: Contacts, cut: CutLaw, length: float, plain: bool = False) -> None:
        thermal = contacts.thermal
        assert thermal is not None
        self._plain = plain
        if not plain:
            from master import compiled

            self._compiled = compiled
        self._cut, self._thermal, self._stiffness = cut, thermal, contacts.relative_stiffness
        self.length, self.time, self.rate = length, 1.0 / thermal.attempt_frequency, fresh_rate(contacts, cut)
        self.error, self.work = error_of(cut), 5 * (cut.nodes.size + 100)
        # in a hold a stiff contact right at its threshold hardly breaks: a share too narrow for a panel's nodes stays
        self._layer = _LAYER * float(np.abs(np.diff(cut.law.sf(cut.edges))).max(initial=0.0))
        self._least = _TINY * contacts.mean_threshold
        self._atoms = slice(_FIRST + cut.nodes.size, _FIRST + cut.nodes.size + cut.atoms.size)
        self._own = slice(self._atoms.stop, self._atoms.stop + NODES)
        self.width = self._own.stop
        weights = np.stack([cut.weights, cut.weights * cut.stiffness])
        tails = np.append(weights[:, ::-1].cumsum(axis=1)[:, ::-1], np.zeros((2, 1)), axis=1)
        self._weights, self._tails = weights, np.ascontiguousarray(tails)
        self._springs = np.asarray(cut.stiffness * (0.5 / thermal.temperature))

    def fresh(self, stretch: Array) -> Array:
        worn = np.zeros((stretch.size, self.width))
        worn[:, _FROM], worn[:, _CUT] = stretch, -1.0
        return worn

    def advance(self, worn: Array, begin: Array, end: Array, furthest: Array, duration: float | Array) -> None:
        way = end - begin
        # births take part in any motion from their first step on
        change = np.abs(way * worn[:, _TIME] - worn[:, _WAY] * duration)
        other = change > _SAME * (np.abs(worn[:, _WAY] * duration) + np.abs(way * worn[:, _TIME]))
        rows = np.flatnonzero(other)
        if rows.size:
            part = worn[rows]
            self.settle(part, begin[rows], furthest[rows])
            worn[rows] = part
        worn[:, _WAY] += way
        worn[:, _TIME] += duration

    def settle(self, worn: Array, stretch: Array, furthest: Array) -> None:
        """In place: what the motion so far has cost becomes part of what is kept."""
        panel = self._cut.panel(furthest)
        inside = np.flatnonzero((panel >= 0) & (panel < self._cut.edges.size - 1))
        own = np.zeros((furthest.size, NODES))
        if inside.size:
            nodes, _ = self._cut.own(furthest[inside], panel[inside])
            own[inside] = self._beside(worn[inside], nodes, panel[inside], stretch[inside])
        first = np.searchsorted(self._cut.nodes, furthest, side="right")
        if self._plain:
            worn[:, _FIRST : self._atoms.start] = self.at_nodes(worn, stretch, first)
        else:
            worn[:, _FIRST : self._atoms.start] = self._compiled.spent(*self._legs(worn, stretch, first))
        worn[:, self._atoms] = self._at_atoms(worn, stretch, furthest)
        worn[:, self._own] = own
        worn[:, _FROM], worn[:, _WAY], worn[:, _TIME], worn[:, _CUT] = stretch, 0.0, 0.0, furthest

    def left(self, worn: Array, stretch: Array, furthest: Array) -> Left:
        cut, panels = self._cut, self._cut.edges.size - 1
        panel = cut.panel(furthest)
        # the panel that m falls into is summed over nodes of its own
        first = np.minimum(NODES * (panel + 1), cut.nodes.size)
        if self._plain:
            held, stiff = self._weights @ np.exp(-self.at_nodes(worn, stretch, first)).T
        else:
            held, stiff = self._compiled.left(*self._legs(worn, stretch, first), self._weights, self._tails).T
        if cut.atoms.size:
            kept = np.exp(-self._at_atoms(worn, stretch, furthest)) * cut.atom_weights
            held, stiff = held + kept.sum(axis=1), stiff + kept @ cut.atom_stiffness
        edge, edge_stiff = np.zeros(furthest.size), np.zeros(furthest.size)
        inside = np.flatnonzero((panel >= 0) & (panel < panels))
        if inside.size:
            m = furthest[inside]
            nodes, weights = cut.own(m, panel[inside])
            nodes = np.append(nodes, m[:, None], axis=1)
            kept = np.exp(-self._beside(worn[inside], nodes, panel[inside], stretch[inside]))
            springs = np.asarray(self._stiffness(nodes))
            held[inside] += (weights * kept[:, :-1]).sum(axis=1)
            stiff[inside] += (weights * (kept * springs)[:, :-1]).sum(axis=1)
            edge[inside] = cut.law.pdf(m) * kept[:, -1]
            edge_stiff[inside] = edge[inside] * springs[:, -1]
        return Left(held, stiff, edge, edge_stiff)

    def standing(self, stretch: float) -> Standing:
        cut, m = self._cut, abs(stretch)
        panel, later = self._standing(m)
        own, weights = np.empty(0), np.empty(0)
        if 0 <= panel < cut.edges.size - 1:
            own, weights = (x[0] for x in cut.own(np.array([m]), np.array([panel])))
        own = np.maximum(own, self._least)
        held = m * (1.0 + SLACK) < cut.atoms
        nodes = np.concatenate([cut.nodes[later], cut.atoms[held], own])
        weights = np.concatenate([cut.weights[later], cut.atom_weights[held], weights])
        springs = np.asarray(self._stiffness(nodes))
        return Standing(self._thermal.rate(np.minimum(m, nodes), nodes, springs), weights, weights * springs)

    def keeper(self) -> "SpentWear":
        return self

    def kept(self, stretch: float, spent: Array) -> Array:
        cut, m = self._cut, abs(stretch)
        panel, later = self._standing(m)
        held = np.flatnonzero(m * (1.0 + SLACK) < cut.atoms)
        out = self.fresh(np.array([stretch]))[0]
        out[_CUT] = m
        out[_FIRST : self._atoms.stop] = _MOST
        count = cut.nodes[later].size
        out[_FIRST : self._atoms.start][later] = np.minimum(spent[:count], _MOST)
        out[self._atoms][held] = np.minimum(spent[count : count + held.size], _MOST)
        if 0 <= panel < cut.edges.size - 1:
            out[self._own] = np.minimum(spent[count + held.size :], _MOST)
        return out

    def _standing(self, least: float) -> tuple[int, slice]:
        """The panel that a cut falls into, and the nodes beyond it."""
        panel = int(self._cut.panel(np.array([least]))[0])
        return panel, slice(min(NODES * (panel + 1), self._cut.nodes.size), None)

    def at_nodes(self, worn: Array, stretch: Array, first: Numbers) -> Array:
        """A at the nodes of the law from number `first` on, shape (m, k), as compiled code has it; for comparison."""
        node = np.arange(self._cut.nodes.size)
        row, column = np.nonzero(node >= first[:, None])
        more = self._leg(worn, row, stretch[row], self._cut.nodes[column], self._cut.stiffness[column])
        out = np.full((stretch.size, node.size), _MOST)
        out[row, column] = np.minimum(worn[:, _FIRST : self._atoms.start][row, column] + more, _MOST)
        return out

    def _legs(
        self, worn: Array, stretch: Array, first: Numbers
    ) -> tuple[bool, Array, Array, Numbers, Array, Array, Array]:
        """What compiled sums are told."""
        begin, way = worn[:, _FROM], np.abs(worn[:, _WAY])
        near, far = np.abs(begin), np.abs(stretch)
        legs = np.empty((stretch.size, 5))
        legs[:, 0], legs[:, 1] = np.minimum(near, far), np.maximum(near, far)
        legs[:, 2] = np.where(way > _TINY * (near + far), way, 0.0)
        legs[:, 3] = worn[:, _TIME] * self._thermal.attempt_frequency
        legs[:, 4] = (begin < 0.0) != (stretch < 0.0)
        kept = worn[:, _FIRST : self._atoms.start]
        stiff = self._thermal.law == "stiff"
        return stiff, legs, kept, first, self._cut.nodes, self._springs, self._compiled.DAWSON

    def _at_atoms(self, worn: Array, stretch: Array, furthest: Array) -> Array:
        """A at exact single values; so much where they are passed that nothing is left."""
        cut = self._cut
        row, atom = np.nonzero(furthest[:, None] * (1.0 + SLACK) < cut.atoms)
        out = np.full((stretch.size, cut.atoms.size), _MOST)
        more = self._leg(worn, row, stretch[row], cut.atoms[atom], cut.atom_stiffness[atom])
        out[row, atom] = np.minimum(worn[:, self._atoms][row, atom] + more, _MOST)
        return out

    def _beside(self, worn: Array, nodes: Array, panel: Numbers, stretch: Array) -> Array:
        """A at nodes of the panel that m falls into, shape (m, k)."""
        row = np.repeat(np.arange(stretch.size), nodes.shape[1])
        flat = np.maximum(nodes.ravel(), self._least)
        more = self._leg(worn, row, stretch[row], flat, np.asarray(self._stiffness(flat))).reshape(nodes.shape)
        cut = worn[:, _CUT]
        if (cut < 0.0).all():
            return np.minimum(more, _MOST)
        left, right = self._cut.edges[panel], self._cut.edges[panel + 1]
        same = (cut >= left) & (cut < right)
        columns = _FIRST + NODES * panel[:, None] + np.arange(NODES)
        known = np.take_along_axis(worn, columns, axis=1)
        known[same] = worn[same, self._own]
        least = np.where(same, cut, left)[:, None]
        at = (nodes - least) / (right[:, None] - least)
        at = np.where(same[:, None], np.sqrt(np.maximum(at, 0.0)), at)
        return np.clip(more + _interpolated(known, at), 0.0, _MOST)

    def _leg(self, worn: Array, row: Numbers, stretch: Array, threshold: Array, spring: Array) -> Array:
        """What the present motion has cost."""
        begin, way, duration = worn[row, _FROM], worn[row, _WAY], worn[row, _TIME]
        out = np.zeros(stretch.size)
        moves = (np.abs(way) > _TINY * (np.abs(stretch) + np.abs(begin))) & (duration > 0.0)
        stands = ~moves & (duration > 0.0)
        thermal = self._thermal
        if moves.any():
            # rounding may take a stretch past its threshold
            near, far = (np.clip(x[moves], -threshold[moves], threshold[moves]) for x in (begin, stretch))
            log_spent = thermal.log_cumulative(far, threshold[moves], near, spring[moves])
            out[moves] = np.exp(np.minimum(log_spent + np.log(duration[moves] / np.abs(way[moves])), 7.0))
        if stands.any():
            if thermal.law == "stiff":
                self.error = max(self.error, self._layer)
            x = np.clip(stretch[stands], -threshold[stands], threshold[stands])
            log_rate = thermal.log_rate(x, threshold[stands], spring[stands])
            out[stands] = np.exp(np.minimum(log_rate + np.log(duration[stands]), 7.0))
        return out


def _interpolated(values: Array, at: Array) -> Array:
    """Values at the eight nodes on (0, 1) of each row, read at other places of the same row."""
    apart = at[:, :, None] - GAUSS_NODES
    close = np.abs(apart) < 1e-14
    weights = _BARYCENTRIC / np.where(close, 1e-14, apart)
    return (weights * values[:, None, :]).sum(-1) / weights.sum(-1)
