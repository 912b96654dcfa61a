"""Contacts that break by heat at rates of any form, closure "exact": A of a strand at many thresholds.

A(x_s) stands at nodes that are the same for all strands, and beside the largest |x| of a strand, m,
at nodes of its own in (x_s - m)^(1/2), as the rate of stiff contacts has a root at the threshold.
Where m grows, those are read from where they stood before.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import numpy.typing as npt

from master.lives.cold import TIE
from master.lives.heat.replayed import rates_of
from master.lives.heat.threshold_panels import Panels, law_edges, nodes
from master.soft.in_time.heat import reach_of, replay_of, scales_of
from master.soft.in_time.memory import Leg, Memory
from origins import Contacts
from origins.errors import InputError
from origins.laws.rate_law import RateLaw

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

# Change of ln A over a panel that 16 nodes see through to ERROR, and shares of a threshold at which
# it is looked at.
SEEN, LOOKS = 5.0, np.array([0.0, 0.5, 0.9])
ERROR = 1e-7
# Share of the contacts beyond both ends of the panels.
TAIL = 1e-14
# Places nearer to a node than this share of a panel are the node.
AT_NODE = 1e-14
SIZE = 16


class SpentMemory(Memory):
    """What each strand keeps: m where its own nodes stand, A at the fixed ones, at single exact
    thresholds, and at its own nodes.

    Parameters
    ----------
    contacts : Contacts
        With heat, closure "exact"; raises InputError where it is so cold that nodes are too many.
    """

    starts, error = 32, ERROR

    def __init__(self, contacts: Contacts) -> None:
        law, rates = contacts.thresholds, rates_of(contacts)
        linked = contacts.stiffness == "linked"
        self._law, self._rates = law, rates
        self._stiffness = contacts.relative_stiffness if linked else None
        self._kappa = contacts.relative_stiffness
        self._edges = _fine_edges(contacts, rates)
        count = max(self._edges.size - 1, 0)
        # nodes of a strand, at most: with those of colder contacts steps take too long
        if count * SIZE > 30_000:
            raise InputError(
                f"thermal: contacts of {rates.name} rates that break within so thin a skin of "
                "thresholds are not followed under a spring; take a higher temperature"
            )
        low, high = self._edges[:-1], self._edges[1:]
        xi, weight = nodes(law, Panels(np.arange(count), low, high, low, low), None)
        atoms, shares = law.atoms
        self._fixed, weight = np.append(xi, atoms), np.append(weight, shares)
        self._weights = np.stack([weight, weight * self._kappa(self._fixed)], axis=1)
        self._atoms = atoms * (1.0 - TIE)
        # own nodes end where the next panel but one begins, lest m be close to its end
        bends = np.abs(self._edges[1:-1, None] - law.breakpoints).min(axis=1, initial=np.inf) > 0.0
        self._last = np.arange(1, count + 1)
        self._last[:-1] += bends
        self._own_part = slice(1 + self._fixed.size, 1 + self._fixed.size + SIZE)
        self.width, self.reach = self._own_part.stop, reach_of(contacts)
        self.scales = scales_of(contacts)
        # places of the nodes on a panel and in the root of the way, and barycentric weights
        z = np.polynomial.legendre.leggauss(SIZE)[0]
        self._places = 0.5 * (z + 1.0)
        apart = 2.0 * (z[:, None] - z)
        np.fill_diagonal(apart, 1.0)
        self._barycentric = 1.0 / apart.prod(axis=1)

    def start(self, stretch: Array) -> Array:
        """See Memory."""
        kept = np.zeros((stretch.size, self.width))
        kept[:, 0] = np.abs(stretch)
        return kept

    def advance(self, kept: Array, leg: Leg) -> Array:
        """See Memory."""
        out, m = kept.copy(), leg.furthest
        grown = np.flatnonzero(m > kept[:, 0])
        out[grown, self._own_part] = self._moved(kept[grown], m[grown])
        out[:, 0] = m
        if leg.duration:
            some = self._loud(leg)
            fixed = np.broadcast_to(self._fixed[some], (m.size, some.size))
            at = np.maximum(np.concatenate([fixed, self._own(m)[0]], axis=1), m[:, None])
            replay = replay_of(leg, self._rates, self._stiffness)
            spent = replay.spent(np.arange(m.size), at)
            out[:, 1 + some] += spent[:, : some.size]
            out[:, self._own_part] += spent[:, some.size :]
        return out

    def _loud(self, leg: Leg) -> Rows:
        """The fixed nodes at which any strand spends anything on a leg: few where it is cold."""
        far = np.maximum(np.abs(leg.begin), np.abs(leg.end)).max()
        beyond = np.maximum(self._fixed, far)
        with np.errstate(divide="ignore"):
            most = self._rates.log_rate(far, beyond, self._kappa(beyond)) + np.log(leg.duration)
        # stiff contacts right at their threshold hardly break: those beyond do
        # ln A below which nothing is spent
        loud = np.flatnonzero((most > -45.0) | (self._fixed <= far))
        last = self._fixed[loud].max(initial=0.0)
        met = self._fixed >= leg.furthest.min()
        return np.flatnonzero(met & (self._fixed <= last))

    def left(self, kept: Array, stretch: Array, furthest: Array) -> Array:
        """See Memory."""
        # what is beside m is summed by own nodes
        beyond = SIZE * self._last[self._panel(furthest)] if self._edges.size else furthest
        there = np.concatenate(
            [
                np.arange(self._fixed.size - self._atoms.size) >= beyond[:, None],
                self._atoms > furthest[:, None],
            ],
            axis=1,
        )
        survived = np.exp(-kept[:, 1:])
        held = (survived[:, : self._fixed.size] * there) @ self._weights
        xi, weight = self._own(furthest)
        beside = survived[:, self._fixed.size :] * weight
        stiff = held[:, 1] + (beside * self._kappa(xi)).sum(axis=1)
        return np.stack([held[:, 0] + beside.sum(axis=1), stretch * stiff])

    def _panel(self, m: Array) -> Rows:
        """The panel that holds m, the first or last where none does."""
        found = np.searchsorted(self._edges, m, side="right") - 1
        return np.clip(found, 0, max(self._edges.size - 2, 0))

    def _own(self, m: Array) -> tuple[Array, Array]:
        """Thresholds beside m and their weights by P_c, both of shape (n, SIZE)."""
        if not self._edges.size:
            return np.repeat(m[:, None], SIZE, axis=1), np.zeros((m.size, SIZE))
        end = self._edges[self._last[self._panel(m)]]
        # where all have been met what is left of the panel holds nothing
        low = np.clip(m, self._edges[0], end * (1.0 - AT_NODE))
        return nodes(self._law, Panels(np.arange(m.size), low, end, low, low), low)

    def _moved(self, kept: Array, m: Array) -> Array:
        """A at the nodes beside larger m, from where it stood before; shape (n, SIZE)."""
        if not (self._edges.size and m.size):
            return np.zeros((m.size, SIZE))
        at = self._own(m)[0]
        before = self._last[self._panel(kept[:, 0])]
        end = self._edges[before]
        low = np.clip(kept[:, 0], self._edges[0], end * (1.0 - AT_NODE))[:, None]
        room = end[:, None] - low
        beside = at < end[:, None]
        panel = np.maximum(self._panel(at.ravel()).reshape(at.shape), before[:, None])
        panel = np.minimum(panel, self._edges.size - 2)
        width = self._edges[panel + 1] - self._edges[panel]
        share = np.where(
            beside,
            np.sqrt(np.maximum(at - low, 0.0) / room),
            (at - self._edges[panel]) / width,
        )
        apart = share[:, :, None] - self._places
        rule = self._barycentric / np.where(np.abs(apart) < AT_NODE, AT_NODE, apart)
        rule /= rule.sum(axis=-1, keepdims=True)
        values = kept[:, self._own_part][:, None, :]
        found = (rule * values).sum(axis=-1)
        row, node = np.nonzero(~beside)
        if row.size:
            column = panel[row, node][:, None] * SIZE + np.arange(SIZE)
            found[row, node] = (rule[row, node] * kept[:, 1:][row[:, None], column]).sum(axis=-1)
        return np.maximum(found, 0.0)


def _fine_edges(contacts: Contacts, rates: RateLaw) -> Array:
    """The law's panels, cut where ln A may change too fast over them with the threshold."""
    law = contacts.thresholds
    edges = law_edges(law)
    if edges.size:
        low, high = float(law.ppf(TAIL)), float(law.isf(TAIL))
        edges = np.unique(np.clip(edges, low, high))
    if edges.size < 2:
        return np.empty(0)
    pieces: list[Array] = []
    for low, high in pairwise(edges.tolist()):
        low = max(low, 1e-3 * high)
        ends = np.array([[low], [high]])
        levels = rates.log_rate(LOOKS * low, ends, contacts.relative_stiffness(ends))
        count = max(1, int(np.ceil(np.abs(np.diff(levels, axis=0)).max() / SEEN)))
        pieces.append(np.linspace(low if pieces else edges[0], high, count + 1)[:-1])
    return np.append(np.concatenate(pieces), edges[-1])
