"""Chains of breaks at exact single values: births and releases that keep finite weight at one X.

Only laws with atoms have them. Their positions are sums of atoms, listed one by one; equal sums are merged.
"""

import numpy as np
import numpy.typing as npt

from master._old.law import Law
from master._old.release import PLAIN, Release
from master._old.tally import Tally
from origins import InputError

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

    Raises InputError where more than 200,000 positions would be listed.
    """

    def __init__(
        self, law: Law, first: Array, first_weights: Array, end: float, release: Release = PLAIN
    ) -> None:
        self.births, self.weights = _merge(first[first <= end], first_weights[first <= end])
        if law.atoms.size:
            self._follow(law, end)
        positions = (self.births[:, None] + law.atoms).ravel()
        weights = self.weights[:, None] * law.atom_weights
        released = (weights * release.force_at(law.atoms)).ravel()
        stretch = np.tile(law.atoms - release.delay + release.birth, self.births.size)
        self._release = release
        self.count = Tally(None, positions, weights.ravel(), stretch, _SAME)
        self._softened = Tally(None, positions, (weights * release.stiffness_at(law.atoms)).ravel(), stretch, _SAME)
        self._released = Tally(None, positions, released, stretch, _SAME)

    def _follow(self, law: Law, end: float) -> None:
        """Births from births, a window as wide as the smallest atom at a time: nothing in it follows from itself."""
        births, weights = self.births, self.weights
        window = float(law.atoms.min()) * (1.0 - 1e-9)
        found_births, found_weights, count = [], [], 0
        while births.size:
            now = births < births[0] + window
            found_births.append(births[now])
            found_weights.append(weights[now])
            count += int(now.sum())
            if count > MOST:
                raise InputError(
                    f"thresholds: the exact values in them have more than {MOST:,} distinct sums within the path; "
                    "shorten the path, or give the values a width"
                )
            later = (births[now][:, None] + law.atoms).ravel()
            share = (weights[now][:, None] * law.atom_weights).ravel()
            keep = (later <= end * (1.0 + _SAME)) & (share > _NEGLIGIBLE)
            births, weights = _merge(
                np.concatenate([births[~now], later[keep]]), np.concatenate([weights[~now], share[keep]])
            )
        if found_births:
            self.births, self.weights = np.concatenate(found_births), np.concatenate(found_weights)

    def released(self, x: Array) -> Array:
        """What breaks at atoms after births of this chain, and the births that follow, take from the force at X = x; a
        break at x itself counts."""
        released, release = self._released.once(x), self._release
        if release.plain:
            return released
        since = x - release.delay
        released = released + self._softened.twice(x) - release.birth_stiffness * self.count.twice(since)
        return released - release.birth_force * self.count.once(x, release.delay)

    def rate(self, x: Array) -> Array:
        """Slope of `released` between the atoms."""
        release = self._release
        if release.plain:
            return np.zeros(x.shape)
        return self._softened.once(x) - release.birth_stiffness * self.count.once(x, release.delay)


def _merge(positions: Array, weights: Array) -> tuple[Array, Array]:
    """Positions equal to within rounding become one."""
    if not positions.size:
        return positions, weights
    order = np.argsort(positions, kind="stable")
    positions, weights = positions[order], weights[order]
    group = np.concatenate([[0], np.cumsum(np.diff(positions) > _SAME * positions[1:])])
    first = np.concatenate([[0], np.flatnonzero(np.diff(group)) + 1])
    return positions[first], np.bincount(group, weights=weights).astype(float)
