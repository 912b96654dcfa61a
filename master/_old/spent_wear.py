"""Contacts that break at rates h(|x|; ξ) of any form, with closure "exact": what temperature has cost so far.

For every strand the integral A(ξ) of h over time stands at the nodes of the law of thresholds. While the slider goes
on at one speed that part of it is closed, and added afresh from where it began; what went before is kept, beyond m
also at nodes of its own in the root of ξ - m, as the rate of stiff contacts has a root at the threshold.
"""

import numpy as np
import numpy.typing as npt

from master._old.cut_law import SLACK, CutLaw
from master._old.thermal_wear import error_of, fresh_rate
from master._old.wear import Left, Standing
from origins import Contacts
from origins.laws.thermal import GivenRates, Thermal
from origins.thresholds.quadrature import GAUSS_NODES, NODES

Array = npt.NDArray[np.float64]
Numbers = npt.NDArray[np.intp]

_MOST = 500.0  # e^(-A) is nothing
_SAME = 1e-9
_CLOSE = 1e-14
_TINY = 1e-12  # a threshold of 0 has no rate
_FROM, _WAY, _TIME, _CUT, _FIRST = range(5)  # columns before those of nodes, atoms, and nodes of a strand's own


class Spent:
    """What such wears share: the motion at one speed that goes on, and what it costs; `settle` makes that part of what
    is kept of the past."""

    width: int
    _thermal: Thermal | GivenRates

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
        raise NotImplementedError

    def _settled(self, worn: Array, furthest: Array) -> bool:
        """Whether none has moved or stood since all that was worked out: trials from one place ask again and again."""
        return not (worn[:, [_WAY, _TIME]].any() or (worn[:, _CUT] != furthest).any())

    def _legs(self, worn: Array, stretch: Array) -> tuple[bool, Array]:
        """What compiled sums are told of the present motion."""
        begin, way = worn[:, _FROM], np.abs(worn[:, _WAY])
        near, far = np.abs(begin), np.abs(stretch)
        legs = np.empty((stretch.size, 5))
        legs[:, 0], legs[:, 1] = np.minimum(near, far), np.maximum(near, far)
        legs[:, 2] = np.where(way > _TINY * (near + far), way, 0.0)
        legs[:, 3] = worn[:, _TIME] * self._thermal.attempt_frequency
        legs[:, 4] = (begin < 0.0) != (stretch < 0.0)
        return self._thermal.rates.vanishes_at_threshold, legs

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
            x = np.clip(stretch[stands], -threshold[stands], threshold[stands])
            log_rate = thermal.log_rate(x, threshold[stands], spring[stands])
            out[stands] = np.exp(np.minimum(log_rate + np.log(duration[stands]), 7.0))
        return out


class SpentWear(Spent):
    """Soft or stiff contacts, equally stiff or not; `plain`: few of them, for which numpy does as well."""

    forgets, slow, skin = False, 6.0, 0.0

    def __init__(self, contacts: Contacts, cut: CutLaw, length: float, plain: bool = False) -> None:
        thermal = contacts.thermal
        assert thermal is not None
        self._plain = plain
        if not plain:
            from master._old import compiled

            self._compiled = compiled
        self._cut, self._thermal, self._stiffness = cut, thermal, contacts.relative_stiffness
        self.length, self.time, self.rate = length, 1.0 / thermal.attempt_frequency, fresh_rate(contacts)
        self.error, self.work = error_of(cut), cut.nodes.size + 100
        self._least = _TINY * contacts.mean_threshold
        self._atoms = slice(_FIRST + cut.nodes.size, _FIRST + cut.nodes.size + cut.atoms.size)
        self._own = slice(self._atoms.stop, self._atoms.stop + cut.places.size)
        self.width = self._own.stop
        weights = np.stack([cut.weights, cut.weights * cut.stiffness])
        tails = np.append(weights[:, ::-1].cumsum(axis=1)[:, ::-1], np.zeros((2, 1)), axis=1)
        self._weights, self._tails = weights, np.ascontiguousarray(tails)
        self._springs = np.asarray(cut.stiffness * (0.5 / thermal.temperature))
        self._even, self._beyond = barycentric(GAUSS_NODES), barycentric(cut.places)

    def settle(self, worn: Array, stretch: Array, furthest: Array) -> None:
        """In place: what the motion so far has cost becomes part of what is kept."""
        if self._settled(worn, furthest):
            return
        own = np.zeros((furthest.size, self._cut.places.size))
        inside, m, panel = self._inside(furthest)
        if inside.size:
            nodes, _ = self._cut.own(m, panel)
            own[inside] = self._beside(worn[inside], nodes, stretch[inside])
        first = np.searchsorted(self._cut.nodes, furthest, side="right")
        if self._plain:
            worn[:, _FIRST : self._atoms.start] = self.at_nodes(worn, stretch, first)
        else:
            worn[:, _FIRST : self._atoms.start] = self._compiled.spent(*self._strands(worn, stretch, first))
        worn[:, self._atoms] = self._at_atoms(worn, stretch, furthest)
        worn[:, self._own] = own
        worn[:, _FROM], worn[:, _WAY], worn[:, _TIME], worn[:, _CUT] = stretch, 0.0, 0.0, furthest

    def left(self, worn: Array, stretch: Array, furthest: Array) -> Left:
        cut = self._cut
        inside, m, panel = self._inside(furthest)
        # what is beside m is summed over nodes of its own
        first = np.full(furthest.size, cut.nodes.size)
        first[inside] = NODES * cut.ends[panel]
        if self._plain:
            held, stiff = self._weights @ np.exp(-self.at_nodes(worn, stretch, first)).T
        else:
            held, stiff = self._compiled.left(*self._strands(worn, stretch, first), self._weights, self._tails).T
        if cut.atoms.size:
            kept = np.exp(-self._at_atoms(worn, stretch, furthest)) * cut.atom_weights
            held, stiff = held + kept.sum(axis=1), stiff + kept @ cut.atom_stiffness
        edge, edge_stiff = np.zeros(furthest.size), np.zeros(furthest.size)
        if inside.size:
            nodes, weights = cut.own(m, panel)
            nodes = np.append(nodes, furthest[inside, None], axis=1)
            kept = np.exp(-self._beside(worn[inside], nodes, stretch[inside]))
            springs = np.asarray(self._stiffness(nodes))
            held[inside] += (weights * kept[:, :-1]).sum(axis=1)
            stiff[inside] += (weights * (kept * springs)[:, :-1]).sum(axis=1)
            edge[inside] = cut.law.pdf(furthest[inside]) * kept[:, -1]
            edge_stiff[inside] = edge[inside] * springs[:, -1]
        return Left(held, stiff, edge, edge_stiff)

    def standing(self, stretch: float) -> Standing:
        cut, m = self._cut, abs(stretch)
        own, weights, later = self._standing(m)
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
        own, _, later = self._standing(m)
        held = np.flatnonzero(m * (1.0 + SLACK) < cut.atoms)
        out = self.fresh(np.array([stretch]))[0]
        out[_CUT] = m
        out[_FIRST : self._atoms.stop] = _MOST
        count = cut.nodes[later].size
        out[_FIRST : self._atoms.start][later] = np.minimum(spent[:count], _MOST)
        out[self._atoms][held] = np.minimum(spent[count : count + held.size], _MOST)
        if own.size:
            out[self._own] = np.minimum(spent[count + held.size :], _MOST)
        return out

    def _inside(self, furthest: Array) -> tuple[Numbers, Array, Numbers]:
        """Strands beyond whose m there is a continuous part of the law, where that begins for them, and its panel."""
        panel = np.maximum(self._cut.panel(furthest), 0)
        inside = np.flatnonzero(panel < self._cut.edges.size - 1)
        return inside, np.maximum(furthest[inside], self._cut.edges[0]), panel[inside]

    def _standing(self, least: float) -> tuple[Array, Array, slice]:
        """Nodes beside a cut and their weights, and nodes of the law beyond."""
        inside, m, panel = self._inside(np.array([least]))
        if not inside.size:
            return np.empty(0), np.empty(0), slice(self._cut.nodes.size, None)
        own, weights = self._cut.own(m, panel)
        return own[0], weights[0], slice(NODES * int(self._cut.ends[panel[0]]), None)

    def at_nodes(self, worn: Array, stretch: Array, first: Numbers) -> Array:
        """A at the nodes of the law from number `first` on, shape (m, k), as compiled code has it; for comparison."""
        node = np.arange(self._cut.nodes.size)
        row, column = np.nonzero(node >= first[:, None])
        more = self._leg(worn, row, stretch[row], self._cut.nodes[column], self._cut.stiffness[column])
        out = np.full((stretch.size, node.size), _MOST)
        out[row, column] = np.minimum(worn[:, _FIRST : self._atoms.start][row, column] + more, _MOST)
        return out

    def _strands(
        self, worn: Array, stretch: Array, first: Numbers
    ) -> tuple[bool, Array, Array, Numbers, Array, Array, Array]:
        """The same, with what was kept at nodes of the law."""
        kept = worn[:, _FIRST : self._atoms.start]
        return *self._legs(worn, stretch), kept, first, self._cut.nodes, self._springs, self._compiled.DAWSON

    def _at_atoms(self, worn: Array, stretch: Array, furthest: Array) -> Array:
        """A at exact single values; so much where they are passed that nothing is left."""
        cut = self._cut
        row, atom = np.nonzero(furthest[:, None] * (1.0 + SLACK) < cut.atoms)
        out = np.full((stretch.size, cut.atoms.size), _MOST)
        more = self._leg(worn, row, stretch[row], cut.atoms[atom], cut.atom_stiffness[atom])
        out[row, atom] = np.minimum(worn[:, self._atoms][row, atom] + more, _MOST)
        return out

    def _beside(self, worn: Array, nodes: Array, stretch: Array) -> Array:
        """A at nodes beside m, shape (m, k)."""
        cut, shape = self._cut, nodes.shape
        flat = np.maximum(nodes, self._least)
        springs = np.asarray(self._stiffness(flat))
        known = worn[:, _CUT] >= 0.0
        # before, either beside another m or at nodes of the law
        panel = np.clip(cut.panel(nodes.ravel()).reshape(shape), 0, cut.edges.size - 2)
        left, right = cut.edges[panel], cut.edges[panel + 1]
        column, at = _FIRST + NODES * panel, (nodes - left) / (right - left)
        inside, m, first = self._inside(np.where(known, worn[:, _CUT], np.inf))
        end = cut.edges[cut.ends[first]]
        same = nodes[inside] < end[:, None]
        way = (nodes[inside] - m[:, None]) / (end - m)[:, None]
        at[inside] = np.where(same, cut.share(np.clip(way, 0.0, 1.0)), at[inside])
        column[inside] = np.where(same, self._own.start, column[inside])
        column[~known] = -1
        if self._plain:
            row = np.repeat(np.arange(shape[0]), shape[1])
            more = self._leg(worn, row, stretch[row], flat.ravel(), springs.ravel()).reshape(shape)
            return np.clip(more + self._known(worn, column, at), 0.0, _MOST)
        stiff, legs = self._legs(worn, stretch)
        b = springs * (0.5 / self._thermal.temperature)
        rules = (self._even, self._beyond, self._own.start)
        return self._compiled.beside(stiff, legs, worn, column, at, flat, b, self._compiled.DAWSON, *rules)

    def _known(self, worn: Array, column: Numbers, at: Array) -> Array:
        """What was kept, read between nodes."""
        out = np.zeros(at.shape)
        own = column == self._own.start
        for rule, mine in ((self._even, (column >= 0) & ~own), (self._beyond, own)):
            row, _ = np.nonzero(mine)
            values = worn[row[:, None], column[mine][:, None] + np.arange(rule.shape[1])]
            out[mine] = _interpolated(values, at[mine], rule)
        return out



def barycentric(nodes: Array) -> Array:
    """Nodes and, of values there, the weights in what is read between them; shape (2, k)."""
    apart = nodes[:, None] - nodes
    np.fill_diagonal(apart, 1.0)
    # products of many short ways would underflow: four are one on (0, 1)
    return np.stack([nodes, 1.0 / (4.0 * apart).prod(axis=1)])


def _interpolated(values: Array, at: Array, rule: Array) -> Array:
    """Values at the nodes of a rule, shape (m, k), read at one place of each row."""
    apart = at[:, None] - rule[0]
    weights = rule[1] / np.where(np.abs(apart) < _CLOSE, _CLOSE, apart)
    return (weights * values).sum(-1) / weights.sum(-1)
