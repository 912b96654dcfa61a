"""The law of fresh thresholds cut at the furthest stretch: sums over what is left beyond it.

Between the edges of panels stand nodes; the panel that a cut falls into gets nodes of its own, from the cut on. Where
what is left is a series in the root of the way from there, however steep, these reach over the next panel too.
"""

import numpy as np
import numpy.typing as npt

from origins import Contacts
from origins.thresholds.quadrature import NODES, gauss, panel_edges

Array = npt.NDArray[np.float64]

SLACK = 1e-12
_LIGHT = 1e-10
MOST = 2**13
_EVEN, _STEEP = (NODES, 1), (20, 3)  # nodes beside the cut, even in that power's root of the root of the way


class CutLaw:
    """Nodes of P_c fine enough to see a share that falls with the threshold as e^(-A), A changing by a factor e over
    `width`, an array at thresholds that come with it; weights are those of the law, exact single values left out.
    `rooted`: A rises at the cut as the root of the way from there.

    Attributes
    ----------
    edges : array of shape (p + 1,)
    nodes, weights : arrays of shape (8 p,)
    spread : float
        How many times too few nodes there are for that, 1 or above.
    places : array of shape (k,)
        Where nodes beside the cut stand, as shares on (0, 1) of what `share` tells.
    ends : array of shape (p,)
        Number of the edge at which they end, for cuts in each of the panels.
    """

    def __init__(
        self, contacts: Contacts, width: tuple[Array, Array] | None, tail: float, rooted: bool = False
    ) -> None:
        self.law = law = contacts.thresholds
        self.contacts = contacts
        self.atoms, self.atom_weights = law.atoms
        self.spread = 1.0
        edges = np.zeros(1)
        if float(self.atom_weights.sum()) < 1.0 - 1e-14:
            edges = panel_edges(law, tail=tail)
            left, right = edges[:-1], edges[1:]
            if width is not None and left.size:
                light = np.abs(law.cdf(right) - law.cdf(left)) < _LIGHT
                # in the reciprocal, as none may be needed
                parts = np.ceil((right - left) * np.interp(0.5 * (left + right), width[0], 1.0 / width[1]))
                parts = np.where(light, 1.0, np.maximum(parts, 1.0))
                if parts.sum() * NODES > MOST:
                    self.spread = float(parts.sum()) * NODES / MOST
                    parts = np.maximum(np.floor(parts * (MOST / NODES) / parts.sum()), 1.0)
                pieces = [np.linspace(a, b, int(n) + 1)[:-1] for a, b, n in zip(left, right, parts, strict=True)]
                edges = np.append(np.concatenate(pieces), edges[-1])
        self.edges = edges
        count, self._power = _STEEP if rooted else _EVEN
        places, weights = np.polynomial.legendre.leggauss(count)
        self.places, self._shares = 0.5 * (places + 1.0), 0.5 * weights
        self.ends = np.arange(1, edges.size)
        if rooted and edges.size > 2:
            apart = np.abs(edges[1:-1, None] - law.breakpoints).min(axis=1, initial=np.inf)
            self.ends[:-1] += apart > SLACK * edges[-1]
        nodes, weights = gauss(edges[:-1], edges[1:])
        self.nodes = nodes.ravel()
        self.weights = weights.ravel() * self._density(self.nodes)
        self.stiffness = np.asarray(contacts.relative_stiffness(self.nodes))
        self.atom_stiffness = np.asarray(contacts.relative_stiffness(self.atoms))

    def panel(self, least: Array) -> npt.NDArray[np.intp]:
        """Number of the panel that holds the cut; -1 below all of them, p beyond."""
        return np.searchsorted(self.edges, least, side="right") - 1

    def own(self, least: Array, panel: npt.NDArray[np.intp]) -> tuple[Array, Array]:
        """Nodes from cuts within the panels on, and their weights; shape (n, k)."""
        whole = np.sqrt(self.edges[self.ends[panel]] - least)[:, None]
        roots = whole * self.places**self._power
        slopes = whole * (self._power * self.places ** (self._power - 1) * self._shares)
        nodes = least[:, None] + roots * roots
        return nodes, 2.0 * roots * slopes * self._density(nodes)

    def share(self, way: Array) -> Array:
        """Where in `places` a node stands that is such a share of the way from the cut to the end."""
        return np.asarray(way ** (0.5 / self._power))

    def _density(self, x: Array) -> Array:
        density = self.law.pdf(x)
        return np.where(np.isfinite(density), density, 0.0)
