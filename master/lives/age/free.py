"""Thresholds that relax towards a normal law, free of any contact: an Ornstein-Uhlenbeck process.

The way of the slider takes the place of time: `diffusion` is D/v, a length, and rates are per length.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.special import ndtr

from origins import Thresholds
from origins.thresholds.quadrature import gauss, panel_edges

Array = npt.NDArray[np.float64]

# Edges of the panels of an integral over fresh thresholds, in standard deviations about the threshold
# whose mean reaches the level: eight Gauss nodes on each panel integrate a normal density.
SPREAD = np.arange(-9.0, 9.5)
# Least remaining share of the initial distance from the mean by which we divide.
FORGOTTEN = 1e-150


class FreeThresholds:
    """The share of thresholds below a level, if they continue to age after they meet it.

    Parameters
    ----------
    fresh : Thresholds
        Law of the thresholds at time 0, conditional on being above `least`; exact values allowed.
    mean, std : float
        Of the final normal law, not cut at 0 (lengths).
    diffusion : float
        D/v > 0, a length.
    least : float
        Length: |x| of the contacts at time 0; their thresholds are above it.
    """

    def __init__(
        self, fresh: Thresholds, mean: float, std: float, diffusion: float, least: float
    ) -> None:
        self._fresh, self._mean, self._std = fresh, mean, std
        self.rate = diffusion / std**2
        self._least, self._held = least, float(fresh.sf(least))
        values, weights = fresh.atoms
        self._values, self._weights = values[values > least], weights[values > least]
        edges = panel_edges(fresh)
        if edges.size:
            edges = np.append(edges[edges > least], max(least, float(edges[0])))
        self._edges = np.unique(edges)

    def below_from_level(self, level: Array, rise: Array, elapsed: Array) -> Array:
        """Share now below `level` of thresholds that were, `elapsed` ago, at the level of then, `rise` lower."""
        decay, lost = np.exp(-self.rate * elapsed), -np.expm1(-self.rate * elapsed)
        distance = (level - self._mean) * lost + rise * decay
        return np.asarray(ndtr(distance / (self._std * np.sqrt(lost * (1.0 + decay)))))

    def below_from_fresh(self, time: Array, level: Array) -> Array:
        """Share below `level` of the thresholds that were fresh `time` > 0 ago; all of shape (n,)."""
        decay, lost = np.exp(-self.rate * time), -np.expm1(-self.rate * time)
        offset, std = level - self._mean, self._std * np.sqrt(lost * (1.0 + decay))
        z = (offset[:, None] - (self._values - self._mean) * decay[:, None]) / std[:, None]
        out = ndtr(z) @ self._weights
        if self._edges.size > 1:
            kept = np.maximum(decay, FORGOTTEN)
            out = out + self._continuous(self._mean + offset / kept, std / kept)
        return np.asarray(out / self._held)

    def _continuous(self, centre: Array, width: Array) -> Array:
        """The mean of the continuous part of the cdf over normal laws of these parameters."""
        edges = self._edges
        # in units of the width from `base`, so that differences stay exact however narrow it is
        base = np.clip(centre, edges[0], edges[-1])
        away = (centre - base) / width
        fixed = (edges - base[:, None]) / width[:, None]
        around = np.clip(away[:, None] + SPREAD, fixed[:, :1], fixed[:, -1:])
        ends = np.sort(np.concatenate([fixed, around], axis=1), axis=1)
        seen = np.clip(ends, (away + SPREAD[0])[:, None], (away + SPREAD[-1])[:, None])
        row, column = np.nonzero(seen[:, 1:] > seen[:, :-1])
        z, weights = gauss(ends[row, column], ends[row, column + 1])
        x = np.clip(base[row, None] + width[row, None] * z, edges[0], edges[-1])
        weights = weights * np.exp(-0.5 * (z - away[row, None]) ** 2) / np.sqrt(2.0 * np.pi)
        sums = (weights * self._smooth(x)).sum(axis=-1)
        beyond = self._smooth(edges[-1:]) * ndtr(away - fixed[:, -1])
        return np.asarray(beyond + np.bincount(row, weights=sums, minlength=centre.size))

    def _smooth(self, x: Array) -> Array:
        """Weight of the fresh law, without its exact values, between `least` and x >= least."""
        below, first = self._fresh.cdf(x), self._fresh.cdf(self._least)
        beneath = np.where(
            below < 0.5, below - first, self._fresh.sf(self._least) - self._fresh.sf(x)
        )
        return np.asarray(beneath - (x[..., None] >= self._values) @ self._weights)
