"""Kinks put right: what a lattice smears where two jumps add up, replaced by the closed form, locally.

J_1 has a jump in its second derivative at every sum z of a jump of r and one of the first breaks, because two steps
fold to (X - z)_+. A lattice smears that over the nodes around z. Folding two bare steps on a few nodes of the same
lattice, placed alike between them, shows by how much.
"""

import numpy as np
import numpy.typing as npt

from master.first import FirstBreaks
from master.lattice import STENCIL, integrate, lagrange, lay

Array = npt.NDArray[np.float64]

_AHEAD, _BEHIND, _NODES = 14.0, 40.0, 88
_LARGEST = 1e3  # beyond, round-off of the correction would exceed 1e-13


class Kinks:
    """Corrections beside the sums of the `jumps` (of r, or of P_c) and those of the first breaks, on one lattice."""

    def __init__(self, jumps: Array, heights: Array, first: FirstBreaks, step: float) -> None:
        self._step = step
        first_steps = [_one_step(position / step) for position in jumps]
        second_steps = [_one_step(position / step) for position in first.jumps]
        self._pairs = []
        for height, (shift, place, weights) in zip(heights, first_steps, strict=True):
            for other, (shift_too, place_too, weights_too) in zip(first.jump_sizes, second_steps, strict=True):
                size = float(height * other) * step**2
                if size and abs(size) * _BEHIND**2 < _LARGEST:
                    folded = np.convolve(weights, weights_too)[:_NODES]
                    self._pairs.append((shift + shift_too, place + place_too, size, folded))

    def released(self, x: Array) -> Array:
        """What J_1 as read from the lattice lacks at x."""
        return self._sum(x, integrate, lambda beyond: 0.5 * beyond**2)

    def rate(self, x: Array) -> Array:
        """What dJ_1/dX (or b) as read from the lattice lacks at x."""
        return self._sum(x, lambda folded: folded, lambda beyond: beyond) / self._step

    def _sum(self, x: Array, seen, exact) -> Array:  # type: ignore[no-untyped-def]
        order = np.argsort(x, kind="stable")
        position = x[order] / self._step
        total = np.zeros(x.size)
        for shift, place, size, folded in self._pairs:
            start = shift + max(place - _AHEAD, 0.0)
            here = slice(*np.searchsorted(position, [start, shift + place + _BEHIND]))
            if here.start < here.stop:
                local = position[here] - shift
                total[here] += size * (exact(np.maximum(local - place, 0.0)) - _read(seen(folded), local))
        out = np.empty(x.size)
        out[order] = total
        return out


def _one_step(position: float) -> tuple[int, float, Array]:
    """A unit step on a short lattice, near node 8: nodes between that and its own place, where it is, its shares."""
    shift = max(int(np.floor(position)) - STENCIL, 0)
    place = position - shift
    edges = np.array([place, _NODES + STENCIL])
    shares = lay(lambda x: [np.ones(x.shape)], 1, edges, 1.0, _NODES + 2 * STENCIL)[0]
    return shift, place, shares[:_NODES]


def _read(values: Array, position: Array) -> Array:
    cell = np.clip(np.floor(position).astype(np.int64) - (STENCIL // 2 - 1), 0, values.size - STENCIL)
    return np.einsum("ij,ij->i", lagrange(position - cell), values[cell[:, None] + np.arange(STENCIL)])
