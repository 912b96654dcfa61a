"""Contacts so cold that those which break below their thresholds are a thin layer of the law, at rates of any form.

For every strand A(ξ), what its past has cost, is kept at nodes of the layer of thresholds right above m, the largest
|x|: as thick as barriers there are felt. Beyond it nothing breaks by itself.
"""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from master._old.cut_law import SLACK
from master._old.spent_wear import Spent, barycentric
from master._old.thermal_wear import fresh_rate
from master._old.wear import Left, stiffness_beyond
from origins import Contacts
from origins.thresholds.quadrature import GAUSS_NODES, GAUSS_WEIGHTS, NODES, finite_density

Array = npt.NDArray[np.float64]

_MOST = 500.0  # e^(-A) is nothing
_TINY = 1e-12  # of the mean threshold
_CUT, _FIRST = 3, 4  # columns, as in master.spent_wear
_LEVELS = (4.0, 2.0, 1.0)  # k_BT that a barrier rises on a panel
_ACCURACY = 2e-6
_FELT = 33.0  # as far beyond what breaks by itself
_LONGEST = 50.0  # ln(ωt) where it is not known
_TABLE, _HALVINGS = 600, 70
_SAMPLE = 60
_CHUNK = 1_000_000


class LayerSpentWear(Spent):
    """The same as master.spent_wear.SpentWear."""

    forgets, slow = False, 8.0

    def __init__(self, contacts: Contacts, length: float, longest: float) -> None:
        from master._old import compiled

        thermal = contacts.thermal
        assert thermal is not None
        self._compiled, self._thermal, self._law = compiled, thermal, contacts.thresholds
        self._contacts, self._stiffness, self._linked = contacts, contacts.relative_stiffness, False
        self._beyond: Callable[[Array], Array] = self._continuous
        if contacts.stiffness == "linked":
            self._linked, self._all_beyond = True, stiffness_beyond(contacts)
        self._atom_places, self._atom_weights = self._law.atoms
        self._atom_stiffness = np.asarray(contacts.relative_stiffness(self._atom_places))
        self.length, self.time, self.rate = length, 1.0 / thermal.attempt_frequency, fresh_rate(contacts)
        self.skin = thermal.temperature / contacts.mean_threshold
        self._least = _TINY * contacts.mean_threshold
        lasts = np.log(thermal.attempt_frequency * longest) if np.isfinite(longest) else _LONGEST
        self._deepest = max(float(lasts), 1.0) + _FELT
        self._power = 2.0 if thermal.rates.vanishes_at_threshold else 1.0
        self._cuts, self._depths = self._layers()
        self._even = barycentric(GAUSS_NODES)
        self._bent = bool((self._law.breakpoints > 0.0).any()) or not self._law.knows_breakpoints
        powers = np.vander(GAUSS_NODES - 0.5, increasing=True)
        rises = np.zeros((NODES, NODES))
        rises[:, 1:] = powers[:, :-1] * np.arange(1.0, NODES)
        self._slopes = GAUSS_WEIGHTS[:, None] * (rises @ np.linalg.inv(powers))
        self._first = (-0.5) ** np.arange(NODES) @ np.linalg.inv(powers)
        self.error = np.inf
        for levels in _LEVELS:
            self._cut_up(0.5 * levels)
            fine = self._sample()
            self._cut_up(levels)
            self.error = float(np.abs(self._sample() - fine).max(initial=0.0)) + 1e-14
            if self.error < _ACCURACY:
                break
        self.work = NODES * (self._edges.size - 1) + 100

    def settle(self, worn: Array, stretch: Array, furthest: Array) -> None:
        if self._settled(worn, furthest):
            return
        nodes, _ = self._nodes(furthest)
        own, atoms = self._spent(worn, nodes, stretch), self._at_atoms(worn, stretch, furthest)
        worn[:, _FIRST : self._atoms.start], worn[:, self._atoms] = own, atoms
        worn[:, 0], worn[:, 1], worn[:, 2], worn[:, _CUT] = stretch, 0.0, 0.0, furthest

    def left(self, worn: Array, stretch: Array, furthest: Array) -> Left:
        held, stiff = np.empty(furthest.size), np.empty(furthest.size)
        edge, edge_stiff = np.empty(furthest.size), np.empty(furthest.size)
        for some in np.array_split(np.arange(furthest.size), 1 + furthest.size * self.width // _CHUNK):
            reached = furthest[some] * (1.0 + SLACK)
            nodes, weights = self._nodes(reached)
            nodes = np.append(nodes, reached[:, None], axis=1)
            kept = np.exp(-self._spent(worn[some], nodes, stretch[some]))
            density = finite_density(self._law, nodes)
            top = reached + self._depth(reached)
            held[some] = self._sum(kept, density, nodes, weights, top, self._continuous)
            edge[some] = kept[:, -1] * density[:, -1]
            stiff[some], edge_stiff[some] = held[some], edge[some]
            if self._linked:
                springs = np.asarray(self._stiffness(nodes))
                stiff[some] = self._sum(kept, density * springs, nodes, weights, top, self._stiffly)
                edge_stiff[some] = edge[some] * springs[:, -1]
        if self._atom_places.size:
            lone = np.exp(-self._at_atoms(worn, stretch, furthest)) * self._atom_weights
            held += lone.sum(axis=1)
            stiff += lone @ (self._atom_stiffness if self._linked else np.ones(self._atom_stiffness.size))
        return Left(held, stiff, edge, edge_stiff)

    def keeper(self) -> None:
        return None

    def _sum(
        self, kept: Array, density: Array, nodes: Array, weights: Array, top: Array, beyond: Callable[[Array], Array]
    ) -> Array:
        """What is left of all thresholds, from shares kept in the layer, the last of which are at its beginning."""
        above = beyond(top)
        if not self._bent:
            return np.asarray((kept * density)[:, :-1] * weights).sum(axis=1) + above
        # by parts: where the density jumps what lies beyond only bends
        rest = beyond(nodes.ravel()).reshape(nodes.shape) - above[:, None]
        slopes = kept[:, :-1].reshape(kept.shape[0], -1, NODES) @ self._slopes.T
        # what hardly breaks right at its threshold, as stiff contacts, is next to none
        first = kept[:, :NODES] @ self._first
        return above + rest[:, -1] * first + (slopes.reshape(kept.shape[0], -1) * rest[:, :-1]).sum(axis=1)

    def _cut_up(self, levels: float) -> None:
        """Panels of the layer, even in the barrier."""
        number = int(np.ceil(self._deepest / levels))
        power = 3.0 if self._thermal.rates.vanishes_at_threshold else 1.0
        self._edges = (np.arange(number + 1) / number) ** (1.0 / power)
        width = np.diff(self._edges)[:, None]
        at = (self._edges[:-1, None] + width * GAUSS_NODES).ravel()
        self._shares = at**self._power
        self._weights = (width * GAUSS_WEIGHTS).ravel() * self._power * at ** (self._power - 1.0)
        stop = _FIRST + at.size
        self._atoms = slice(stop, stop + self._atom_places.size)
        self.width = self._atoms.stop

    def _sample(self) -> Array:
        """What holds of contacts that stood at stretches for as long as it takes."""
        shares = (np.arange(_SAMPLE) + 0.5) / _SAMPLE
        places = np.concatenate([self._law.ppf(shares), self._law.isf(np.array([1e-9, 1e-6, 1e-3])), [self._least]])
        out = []
        for level in np.linspace(0.0, self._deepest - _FELT, 4):
            worn = self.fresh(places)
            worn[:, 2] = np.exp(level) / self._thermal.attempt_frequency
            out.append(self.left(worn, places, places).held)
        return np.concatenate(out)

    def _layers(self) -> tuple[Array, Array]:
        """How thick the layer is above stretches."""
        furthest = float(self._law.isf(1e-30))
        cuts = np.append(0.0, furthest * np.linspace(1e-3, 1.0, _TABLE))
        low, high = np.zeros(cuts.size), np.full(cuts.size, 1e-3 * furthest)
        while (self._barrier(cuts, cuts + high) < self._deepest).any():
            high *= 2.0
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            less = self._barrier(cuts, cuts + middle) < self._deepest
            low, high = np.where(less, middle, low), np.where(less, high, middle)
        return cuts, high

    def _barrier(self, stretch: Array, threshold: Array) -> Array:
        """In k_BT."""
        springs = np.asarray(self._stiffness(threshold)) * (0.5 / self._thermal.temperature)
        if not self._thermal.rates.vanishes_at_threshold:
            return np.asarray(springs * (threshold - stretch) * (threshold + stretch))
        s = (threshold - stretch) / threshold
        return np.asarray(springs * threshold * threshold * s * np.sqrt(s))

    def _depth(self, least: Array) -> Array:
        return np.interp(least, self._cuts, self._depths)

    def _nodes(self, least: Array) -> tuple[Array, Array]:
        depth = self._depth(least)[:, None]
        return least[:, None] + depth * self._shares, depth * self._weights

    def _spent(self, worn: Array, nodes: Array, stretch: Array) -> Array:
        """A at nodes, shape (m, k)."""
        column, at = np.full(nodes.shape, -1), np.zeros(nodes.shape)
        depth = self._depth(np.maximum(worn[:, _CUT], 0.0))
        # where the layer of before is not left behind
        near = np.flatnonzero((worn[:, _CUT] >= 0.0) & (nodes.min(axis=1) < worn[:, _CUT] + depth))
        if near.size:
            way = np.maximum(nodes[near] - worn[near, _CUT, None], 0.0) / depth[near, None]
            share = np.sqrt(way) if self._power == 2.0 else way
            panel = np.clip(np.searchsorted(self._edges, share, side="right") - 1, 0, self._edges.size - 2)
            at[near] = (share - self._edges[panel]) / (self._edges[panel + 1] - self._edges[panel])
            column[near] = np.where(share <= 1.0, _FIRST + NODES * panel, -1)
        flat = np.maximum(nodes, self._least)
        springs = np.asarray(self._stiffness(flat)) * (0.5 / self._thermal.temperature)
        stiff, legs = self._legs(worn, stretch)
        rules = (self._even, self._even, -2)
        return self._compiled.beside(stiff, legs, worn, column, at, flat, springs, self._compiled.DAWSON, *rules)

    def _at_atoms(self, worn: Array, stretch: Array, furthest: Array) -> Array:
        row, atom = np.nonzero(furthest[:, None] * (1.0 + SLACK) < self._atom_places)
        out = np.full((stretch.size, self._atom_places.size), _MOST)
        more = self._leg(worn, row, stretch[row], self._atom_places[atom], self._atom_stiffness[atom])
        out[row, atom] = np.minimum(worn[:, self._atoms][row, atom] + more, _MOST)
        return out

    def _continuous(self, x: Array) -> Array:
        """S without exact single values."""
        return np.asarray(self._law.sf(x) - ((self._atom_places > x[:, None]) * self._atom_weights).sum(axis=1))

    def _stiffly(self, x: Array) -> Array:
        """The same with stiffnesses."""
        lone = self._atom_weights * self._atom_stiffness
        return np.asarray(self._all_beyond(x) - ((self._atom_places > x[:, None]) * lone).sum(axis=1))
