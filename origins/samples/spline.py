"""Cubic splines through heights at knots: parabolas in the first and last interval, straight lines beyond."""

from copy import copy

import numpy as np
import numpy.typing as npt

from origins.thresholds.law import Array

Places = npt.NDArray[np.intp]


class Spline:
    """Spline through `heights` at `knots`, both of shape (k,), k >= 2: twice differentiable but at the outermost knots,
    where a parabola goes over into its tangent; a straight line for k = 2.

    slopes are those of the two tangents.
    """

    def __init__(self, knots: Array, heights: Array) -> None:
        self.knots, self.heights = knots, heights
        width, bend = np.diff(knots), bends(knots) @ heights
        first = np.diff(heights) / width - width * (2.0 * bend[:-1] + bend[1:]) / 6.0
        last = first[-1] + 0.5 * width[-1] * (bend[-2] + bend[-1])
        self.slopes = float(first[0]), float(last)
        # powers of the distance from the knot on the left, the straight line before the first knot in front
        self._powers = np.zeros((4, knots.size + 1))
        self._powers[0] = np.append(heights[0], heights)
        self._powers[1] = np.concatenate([first[:1], first, [last]])
        self._powers[2, 1:-1] = 0.5 * bend[:-1]
        self._powers[3, 1:-1] = np.diff(bend) / (6.0 * width)
        self._from = np.append(knots[0], knots)

    def lowered(self, level: float) -> "Spline":
        """This spline less a constant, otherwise the same to the last bit."""
        out = copy(self)
        out.heights, out._powers = self.heights - level, self._powers.copy()
        out._powers[0] -= level
        return out

    def __call__(self, y: Array) -> Array:
        """Value at y, shape as y."""
        piece = np.searchsorted(self.knots, y, side="right")
        away = y - self._from[piece]
        c0, c1, c2, c3 = self._powers
        return c0[piece] + away * (c1[piece] + away * (c2[piece] + away * c3[piece]))


def bends(knots: Array) -> Array:
    """Matrix (k, k) from heights at the knots to second derivatives there, constant in the first and last interval."""
    width, size = np.diff(knots), knots.size
    if size < 3:
        return np.zeros((size, size))
    inner = np.arange(size - 2)
    left, right = np.zeros((size - 2, size - 2)), np.zeros((size - 2, size))
    left[inner, inner] = (width[:-1] + width[1:]) / 3.0
    left[inner[1:], inner[:-1]] = left[inner[:-1], inner[1:]] = width[1:-1] / 6.0
    left[0, 0] += width[0] / 6.0
    left[-1, -1] += width[-1] / 6.0
    right[inner, inner] = 1.0 / width[:-1]
    right[inner, inner + 2] = 1.0 / width[1:]
    right[inner, inner + 1] = -1.0 / width[:-1] - 1.0 / width[1:]
    solved = np.linalg.solve(left, right)
    return np.concatenate([solved[:1], solved, solved[-1:]])


def tangents(knots: Array) -> tuple[Array, Array]:
    """Rows (k,) from heights at the knots to the slopes at the first and the last."""
    width, bend = np.diff(knots), bends(knots)
    first, last = np.zeros(knots.size), np.zeros(knots.size)
    first[:2] = np.array([-1.0, 1.0]) / width[0]
    last[-2:] = np.array([-1.0, 1.0]) / width[-1]
    return first - 0.5 * width[0] * bend[0], last + 0.5 * width[-1] * bend[-1]


def local_shape(knots: Array, y: Array) -> tuple[Places, tuple[Array, Array, Array, Array]]:
    """The knot left of each y (inside the knots), and what the heights at it and at the next one and the second
    derivatives there count at y."""
    left = np.clip(np.searchsorted(knots, y, side="right") - 1, 0, knots.size - 2)
    width = np.diff(knots)[left]
    t = (y - knots[left]) / width
    s = 1.0 - t
    return left, (s, t, width * width * (s * s * s - s) / 6.0, width * width * (t * t * t - t) / 6.0)


def cardinals(knots: Array, y: Array) -> Array:
    """Matrix (y, k) from heights at the knots to values of the spline at y, shape (y,), inside the knots."""
    left, parts = local_shape(knots, y)
    rows, out = np.arange(y.size), np.zeros((y.size, 2 * knots.size))
    for column, part in zip((0, 1, knots.size, knots.size + 1), parts, strict=True):
        out[rows, left + column] += part
    return out[:, : knots.size] + out[:, knots.size :] @ bends(knots)


def average(knots: Array, y: Array, shares: Array) -> Array:
    """Row (k,) from heights at the knots to the average over y, shape (n,), each counted by its share; in O(n)."""
    left, parts = local_shape(knots, y)
    sums = np.zeros(2 * knots.size)
    for column, part in zip((0, 1, knots.size, knots.size + 1), parts, strict=True):
        sums += np.bincount(left + column, weights=shares * part, minlength=2 * knots.size)
    return sums[: knots.size] + sums[knots.size :] @ bends(knots)
