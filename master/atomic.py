"""Chains of breaks at exact single values: births and releases that keep finite weight at one X.

Only laws with atoms have them. Their positions are sums of atoms, listed one by one; equal sums are merged.
"""

import numpy as np
import numpy.typing as npt

from master.law import Law

Array = npt.NDArray[np.float64]

_SAME = 1e-12
_NEGLIGIBLE = 1e-17
MOST = 200_000


class AtomicChain:
    """Births of finite weight up to X = `end` and what their own atoms release.

    Attributes
    ----------
    births, weights : arrays of shape (n,)
        Positions X and weights of births at one X.
    complete : bool
        False where the list would exceed 200,000 positions and was not finished.
    """

    def __init__(self, law: Law, first: Array, first_weights: Array, end: float) -> None:
        births, weights = _merge(first[first <= end], first_weights[first <= end])
        found_births, found_weights = [births], [weights]
        self.complete = True
        while births.size and law.atoms.size:
            births = (births[:, None] + law.atoms).ravel()
            weights = (weights[:, None] * law.atom_weights).ravel()
            keep = (births <= end * (1.0 + _SAME)) & (weights > _NEGLIGIBLE)
            births, weights = _merge(births[keep], weights[keep])
            found_births.append(births)
            found_weights.append(weights)
            if sum(found.size for found in found_births) > MOST:
                self.complete = False
                break
        self.births, self.weights = _merge(np.concatenate(found_births), np.concatenate(found_weights))
        positions = (self.births[:, None] + law.atoms).ravel()
        released = (self.weights[:, None] * (law.atom_weights * law.atoms)).ravel()
        order = np.argsort(positions, kind="stable")
        self._positions = positions[order]
        self._sums = np.concatenate([[0.0], np.cumsum(released[order])])

    def released(self, x: Array) -> Array:
        """Stretch released up to X = x by births of this chain at their atoms; a break at x itself counts."""
        return self._sums[np.searchsorted(self._positions, x * (1.0 + _SAME), side="right")]


def _merge(positions: Array, weights: Array) -> tuple[Array, Array]:
    """Positions equal to within rounding become one."""
    if not positions.size:
        return positions, weights
    order = np.argsort(positions, kind="stable")
    positions, weights = positions[order], weights[order]
    group = np.concatenate([[0], np.cumsum(np.diff(positions) > _SAME * positions[1:])])
    first = np.concatenate([[0], np.flatnonzero(np.diff(group)) + 1])
    return positions[first], np.bincount(group, weights=weights).astype(float)
