"""Flux of thresholds that diffuse in a parabola through a level that moves at one speed.

The thresholds relax towards a normal law as an Ornstein-Uhlenbeck process, so that their transition
density f from any value is a normal density known in closed form. With ψ the flux of f through the
moving level, less half of what makes it singular where the elapsed time vanishes, 2ψ is what the
integral equation of the first passage (master.lives.age.passage) is made of.

Time is counted by the way that the level goes: `diffusion` is D/v, a length, and rates are per
length.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from origins import Thresholds
from origins.thresholds.quadrature import gauss, panel_edges

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

# Standard deviations of a transition beyond which its density, below 1e-21, adds nothing.
FAINT = 10.0
# Edges of the panels that a sum over fresh thresholds is cut into, in standard deviations about the
# one that reaches the level with the mean: eight Gauss nodes on each integrate a normal density.
SPREAD = np.arange(-9.0, 9.5)
# Share of the first distance from the mean that is still left, below which it is not divided by.
FORGOTTEN = 1e-150
# λ t below which 1 - λt/sinh(λt) is summed as a series, to 1e-16.
SHORT = 0.05


class ParabolaFlux:
    """2ψ of thresholds that relax towards a normal law.

    Parameters
    ----------
    fresh : Thresholds
        Law of the thresholds at time 0, conditional on being above `least`; exact values allowed.
    mean, std : float
        Of the final normal law, not cut at 0 (lengths).
    diffusion : float
        D/v > 0, a length.
    least : float
        Length: contacts that stood stretched at time 0 have thresholds above it.
    """

    def __init__(
        self, fresh: Thresholds, mean: float, std: float, diffusion: float, least: float
    ) -> None:
        self.fresh, self.mean, self.std = fresh, mean, std
        self.rate = diffusion / std**2
        self.held = float(fresh.sf(least))
        values, weights = fresh.atoms
        self.values, self.weights = values[values > least], weights[values > least]
        edges = panel_edges(fresh)
        if edges.size:
            edges = np.append(edges[edges > least], max(least, float(edges[0])))
        self.edges = np.unique(edges)

    def counts(self, level: Array, rise: Array, elapsed: Array) -> npt.NDArray[np.bool_]:
        """Rows in which the transition to `level` is more than nothing at any node.

        level : array (n,); rise, elapsed : arrays (n, nodes) as in `from_level`
        """
        ends = [0, -1]
        decay = np.exp(-self.rate * elapsed[:, ends])
        lost = -np.expm1(-self.rate * elapsed[:, ends])
        distance = (level[:, None] - self.mean) * lost + rise[:, ends] * decay
        z = distance / (self.std * np.sqrt(lost * (1.0 + decay)))
        far = (np.abs(z) > FAINT).all(axis=1) & ((z[:, 0] > 0.0) == (z[:, 1] > 0.0))
        return ~far

    def from_level(self, level: Array, sign: float, rise: Array, elapsed: Array) -> Array:
        """2ψ at the level of thresholds that were at the level `elapsed` ago, `rise` below now.

        With c = level - mean and a = λ elapsed it is
        f [sign - (rise/elapsed) a/sinh a - λ c tanh(a/2)], sign the level's direction.
        """
        a = self.rate * elapsed
        decay, lost = np.exp(-a), -np.expm1(-a)
        c = level - self.mean
        distance = c * lost + rise * decay
        variance = self.std**2 * lost * (1.0 + decay)
        density = np.exp(-0.5 * distance * distance / variance) / np.sqrt(2.0 * np.pi * variance)
        speed = rise / elapsed
        drift = self.rate * c * lost / (1.0 + decay)
        return density * (sign - speed + speed * _less_than_sinh(a, decay, lost) - drift)

    def from_fresh(self, time: Array, level: Array, sign: float) -> Array:
        """2ψ at the level, at `time` after 0, of the fresh thresholds; all of shape (n,)."""
        a = self.rate * time
        decay, lost = np.exp(-a), -np.expm1(-a)
        spread = lost * (1.0 + decay)  # variance of a transition, in units of the final one
        offset = level - self.mean
        out = np.zeros(time.size)
        if self.edges.size > 1:
            out += self._from_density(offset, decay, spread, sign)
        if self.values.size:
            c, decay, spread = offset[:, None], decay[:, None], spread[:, None]
            z = ((self.values - self.mean) * decay - c) / (self.std * np.sqrt(spread))
            flux = self._from_value(self.values, z, c, decay, spread, sign)
            out += (self.weights * flux).sum(axis=-1)
        return out / self.held

    def _from_density(self, offset: Array, decay: Array, spread: Array, sign: float) -> Array:
        """The part of `from_fresh` that comes from the density of the fresh law, times `held`."""
        low, high = float(self.edges[0]), float(self.edges[-1])
        # the fresh threshold that comes to the level with the mean, and the width beside it of
        # those that come there by chance
        kept = np.maximum(decay, FORGOTTEN)
        centre, width = self.mean + offset / kept, self.std * np.sqrt(spread) / kept
        base = np.clip(centre, low, high)
        # in units of the width from `base`, so that differences stay exact however narrow it is
        away = (centre - base) / width
        fixed = (self.edges - base[:, None]) / width[:, None]
        around = np.clip(away[:, None] + SPREAD, fixed[:, :1], fixed[:, -1:])
        ends = np.sort(np.concatenate([fixed, around], axis=1), axis=1)
        seen = np.clip(ends, (away + SPREAD[0])[:, None], (away + SPREAD[-1])[:, None])
        row, column = np.nonzero(seen[:, 1:] > seen[:, :-1])
        z, weights = gauss(ends[row, column], ends[row, column + 1])
        nodes = np.clip(base[row, None] + width[row, None] * z, low, high)
        weights = weights * width[row, None] * self.fresh.pdf(nodes)
        weights = np.where(np.isfinite(weights), weights, 0.0)
        at = offset[row, None], decay[row, None], spread[row, None]
        flux = weights * self._from_value(nodes, z - away[row, None], *at, sign)
        return np.asarray(
            np.bincount(row, weights=flux.sum(axis=-1), minlength=offset.size), dtype=float
        )

    def _from_value(
        self, fresh: Array, z: Array, offset: Array, decay: Array, spread: Array, sign: float
    ) -> Array:
        """2ψ from single fresh thresholds, whose mean is z standard deviations above the level.

        With d = fresh - mean and c the level's offset from the mean it is
        f [sign + λ (d/sinh a - c coth a)].
        """
        density = np.exp(-0.5 * z * z) / (self.std * np.sqrt(2.0 * np.pi * spread))
        d = fresh - self.mean
        return density * (
            sign + self.rate * (2.0 * decay * d - (1.0 + decay * decay) * offset) / spread
        )


def _less_than_sinh(a: Array, decay: Array, lost: Array) -> Array:
    """1 - a/sinh a, without cancellation; decay = e^-a, lost = 1 - e^-a."""
    square = a * a
    series = 1.0 - 31.0 * square / 294.0 * (1.0 - 127.0 * square / 1240.0)
    series = square / 6.0 * (1.0 - 7.0 * square / 60.0 * series)
    with np.errstate(divide="ignore", invalid="ignore"):
        direct = 1.0 - 2.0 * a * decay / (lost * (1.0 + decay))
    return np.where(a < SHORT, series, direct)
