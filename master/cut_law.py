"""The law of fresh thresholds cut at the furthest stretch: sums over what is left beyond it.

Between the edges of panels stand nodes; the panel that a cut falls into gets nodes of its own, from the cut on.
"""

import numpy as np
import numpy.typing as npt

from origins import Contacts
from origins.quadrature import NODES, gauss, panel_edges

Array = npt.NDArray[np.float64]

SLACK = 1e-12
_LIGHT = 1e-10
MOST = 2**13


class CutLaw:
    """Nodes of P_c fine enough to see a share that falls with the threshold as e^(-A), A changing by a factor e over
    `width`, an array at thresholds that come with it; weights are those of the law, exact single values left out.

    Attributes
    ----------
    edges : array of shape (p + 1,)
    nodes, weights : arrays of shape (8 p,)
    spread : float
        How many times too few nodes there are for that, 1 or above.
    """

    def __init__(self, contacts: Contacts, width: tuple[Array, Array] | None, tail: float) -> None:
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
                parts = np.ceil((right - left) / np.interp(0.5 * (left + right), *width))
                parts = np.where(light, 1.0, np.maximum(parts, 1.0))
                if parts.sum() * NODES > MOST:
                    self.spread = float(parts.sum()) * NODES / MOST
                    parts = np.maximum(np.floor(parts * (MOST / NODES) / parts.sum()), 1.0)
                pieces = [np.linspace(a, b, int(n) + 1)[:-1] for a, b, n in zip(left, right, parts, strict=True)]
                edges = np.append(np.concatenate(pieces), edges[-1])
        self.edges = edges
        nodes, weights = gauss(edges[:-1], edges[1:])
        self.nodes = nodes.ravel()
        self.weights = weights.ravel() * self._density(self.nodes)
        self.stiffness = np.asarray(contacts.relative_stiffness(self.nodes))
        self.atom_stiffness = np.asarray(contacts.relative_stiffness(self.atoms))

    def panel(self, least: Array) -> npt.NDArray[np.intp]:
        """Number of the panel that holds the cut; -1 below all of them, p beyond."""
        return np.searchsorted(self.edges, least, side="right") - 1

    def own(self, least: Array, panel: npt.NDArray[np.intp]) -> tuple[Array, Array]:
        """Nodes from cuts within the panels on, in the root of the way from there, and their weights; shape (n, 8)."""
        roots, weights = gauss(np.zeros(least.size), np.sqrt(self.edges[panel + 1] - least))
        nodes = least[:, None] + roots * roots
        return nodes, 2.0 * roots * weights * self._density(nodes)

    def _density(self, x: Array) -> Array:
        density = self.law.pdf(x)
        return np.where(np.isfinite(density), density, 0.0)
