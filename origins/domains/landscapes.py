"""Periodic landscapes: the energy of a rigid island over one cell of its substrate, as waves of whole numbers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from origins.thresholds.law import Array

Whole = npt.NDArray[np.intp]

_LONGEST = 0.5  # Newton step, radians of the fastest wave
_NOISE = 4e-15  # of the waves that have a part in it: rounding of a slope


@dataclass(frozen=True)
class Landscapes:
    """U(t) = sum_n sizes_n cos(K_n·t + phases_n), t in radians, of period 2 pi in both directions.

    waves K is a float array of whole numbers, shape (n, 2). sizes (energies, the largest of each
    landscape about 1) and phases have shape (landscapes, n).
    """

    waves: Array
    sizes: Array
    phases: Array

    def energy(self, which: Whole, t: Array) -> Array:
        """U of the landscapes `which` (m,) at t (m, 2)."""
        return (self.sizes[which] * np.cos(t @ self.waves.T + self.phases[which])).sum(-1)

    def newton_step(self, which: Whole, t: Array, to_saddle: bool) -> Array:
        """Towards the next minimum, or the next saddle, from t, shape (m, 2).

        Every curvature counts as positive, so that the step leads down; to a saddle it leads up along
        the direction of least curvature.
        """
        angle, size = t @ self.waves.T + self.phases[which], self.sizes[which]
        cos, sin = size * np.cos(angle), size * np.sin(angle)
        k, m = self.waves.T
        turn = 0.5 * np.arctan2(-(cos @ (2.0 * k * m)), -(cos @ (k * k - m * m)))
        # the direction of greatest curvature comes first
        first = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
        directions = np.stack([first, np.stack([-first[:, 1], first[:, 0]], axis=-1)], axis=1)
        # wave by wave: where the large waves are flat the small ones keep their digits
        along = directions @ self.waves.T
        slopes = -np.einsum("mkn,mn->mk", along, sin)
        curvatures = -np.einsum("mkn,mn->mk", along * along, cos)
        slopes[np.abs(slopes) <= _NOISE * np.einsum("mkn,mn->mk", np.abs(along), size)] = 0.0
        lengths = -slopes / np.maximum(np.abs(curvatures), 1e-15)
        if to_saddle:
            lengths[:, 1] *= -1.0
        step = np.einsum("mk,mkd->md", lengths, directions)
        fastest = np.abs(step @ self.waves.T).max(-1)
        return step * np.minimum(1.0, _LONGEST / np.maximum(fastest, 1e-300))[:, None]
