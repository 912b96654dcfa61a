"""Piecewise Legendre series of a function known by its values, refined until its last terms vanish."""

from collections.abc import Callable
from functools import cached_property

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre

Array = npt.NDArray[np.float64]
Whole = npt.NDArray[np.int64]

_NODES = 16
_X, _W = legendre.leggauss(_NODES)
# values at the Gauss nodes -> Legendre coefficients
_PROJECT = ((np.arange(_NODES) + 0.5)[:, None] * legendre.legvander(_X, _NODES - 1).T) * _W
# Legendre coefficients -> coefficients of powers, for Horner's rule
_POWERS = np.zeros((_NODES + 1, _NODES + 1))
for _k in range(_NODES + 1):
    _POWERS[: _k + 1, _k] = legendre.leg2poly(np.eye(_NODES + 1)[_k])[: _k + 1]
_ALTERNATE = np.where(np.arange(_NODES + 1) % 2, -1.0, 1.0)
_DEPTH = 60
_STEEP = 2  # times in a row that one half alone was not resolved
_TOWARDS_END = 0.5 ** np.arange(4.0, 0.0, -1.0)
_BESIDE = np.array([-1e-9, 0.0, 1e-9])


class Piecewise:
    """A function on [edges[0], edges[-1]] as one Legendre series per panel, with its integral from edges[0].

    edges has shape (n + 1,), coefficients shape (16, n).

    Attributes
    ----------
    total : float
        Integral over all panels.
    error, total_error : float
        Estimates of the error of the integral up to some point, and of `total`: the last terms kept integrate to
        nothing over a whole panel, so but for a small part they do not add up.
    """

    def __init__(self, edges: Array, coefficients: Array) -> None:
        tails = np.abs(coefficients[-2:]).max(axis=0, initial=0.0) * np.diff(edges)
        self.total_error = 0.2 * float(tails.sum())
        self.error = float(tails.max(initial=0.0)) + self.total_error
        self.edges = edges
        self.coefficients = coefficients
        self._half = 0.5 * np.diff(edges)
        # the first Legendre term alone has an integral over the whole panel
        self._before = np.concatenate([[0.0], np.cumsum(coefficients[0] * np.diff(edges))])
        self.total = float(self._before[-1])

    @cached_property
    def jumps(self) -> Array:
        """By how much the function jumps at each edge but the last, being zero before the first."""
        # values at a panel's two ends: sums of its Legendre coefficients, with alternating signs at the left one
        ends = self.coefficients.sum(axis=0)
        begins = (_ALTERNATE[: self.coefficients.shape[0], None] * self.coefficients).sum(axis=0)
        return np.asarray(begins - np.append(0.0, ends[:-1]))

    @cached_property
    def _values(self) -> Array:
        return _POWERS[:_NODES, :_NODES] @ self.coefficients

    @cached_property
    def _integral(self) -> Array:
        scaled = self.coefficients * (self._half / (2.0 * np.arange(_NODES) + 1.0)[:, None])
        integral = np.zeros((_NODES + 1, self._half.size))
        integral[1:] += scaled
        integral[: _NODES - 1] -= scaled[1:]
        # P_k(-1) = (-1)^k: start each panel at what came before it
        integral[0] += self._before[:-1] - (integral * _ALTERNATE[:, None]).sum(axis=0)
        return _POWERS @ integral

    def __call__(self, x: Array) -> Array:
        """Value at x; zero outside the panels."""
        if not self.coefficients.size:
            return np.zeros(np.shape(x))
        inside = (x >= self.edges[0]) & (x <= self.edges[-1])
        if inside.all():
            return self._series(self._values, x)
        out = np.zeros(x.shape)
        if inside.any():
            out[inside] = self._series(self._values, x[inside])
        return out

    def within(self, panel: npt.NDArray[np.intp], x: Array) -> Array:
        """Values at x of shape (n, m), row after row on the one panel given for each."""
        left, right = self.edges[panel, None], self.edges[panel + 1, None]
        t = ((x - left) - (right - x)) / (right - left)
        powers = self._values[:, panel, None]
        out = powers[-1] * t
        for row in powers[-2:0:-1]:
            out += row
            out *= t
        out += powers[0]
        return out

    def integral(self, x: Array) -> Array:
        """Integral up to x; the whole of it beyond the last panel."""
        if not self.coefficients.size:
            return np.zeros(np.shape(x))
        out = np.where(x >= self.edges[-1], self.total, 0.0)
        inside = (x > self.edges[0]) & (x < self.edges[-1])
        if inside.any():
            out[inside] = self._series(self._integral, x[inside])
        return out

    def error_at(self, x: Array) -> Array:
        """Estimate of the error of the value at x, from the last terms of the panels that meet or hold it."""
        if not self.coefficients.size:
            return np.zeros(np.shape(x))
        # at the end of a panel beside a root terms fall as 1/k^2: those left out add up to as many of the last
        last = _NODES * np.abs(self.coefficients[-2:]).max(axis=0)
        beside = x[..., None] * (1.0 + _BESIDE)
        panel = (np.searchsorted(self.edges, beside, side="right") - 1).clip(0, last.size - 1)
        inside = (beside >= self.edges[0]) & (beside <= self.edges[-1])
        return np.asarray(np.where(inside, last[panel], 0.0).max(axis=-1))

    def seen(self, sign: int, by: float) -> "Piecewise":
        """The same function of t = sign x + by, sign 1 or -1; the integral over each panel stays, whatever rounding
        makes of its width."""
        edges, coefficients = self.edges + by, self.coefficients
        if sign < 0:
            odd = np.where(np.arange(_NODES) % 2, -1.0, 1.0)[:, None]
            edges, coefficients = by - self.edges[::-1], odd * coefficients[:, ::-1]
        old, new = np.diff(self.edges)[::sign], np.diff(edges)
        return Piecewise(edges, coefficients * np.divide(old, new, out=np.ones(new.size), where=new > 0.0))

    def lumped(self, width: float) -> "tuple[Piecewise, Array, Array]":
        """The function without its panels below `width`: nothing is left there; and for each run of them where its
        weight lies and how much."""
        widths = np.diff(self.edges)
        narrow = widths < width
        if not narrow.any():
            return self, np.empty(0), np.empty(0)
        first = narrow & ~np.append(False, narrow[:-1])
        run = np.cumsum(first)[narrow] - 1
        weight = (self.coefficients[0] * widths)[narrow]
        weights = np.bincount(run, weights=weight).astype(float)
        middle = 0.5 * (self.edges[:-1] + self.edges[1:])[narrow]
        places: Array = np.bincount(run, weights=middle * weight) / np.where(weights == 0.0, 1.0, weights)
        # of each run one empty panel stays, and none at either end
        kept = np.flatnonzero(~narrow | first)
        coefficients = np.where(narrow, 0.0, self.coefficients)[:, kept]
        edges = np.append(self.edges[kept], self.edges[-1])
        inner = slice(int(narrow[0]), kept.size - int(narrow[-1] and kept.size > 1))
        return Piecewise(edges[inner.start : inner.stop + 1], coefficients[:, inner]), places, weights

    def _series(self, powers: Array, x: Array) -> Array:
        panel = (np.searchsorted(self.edges, x, side="right") - 1).clip(0, self._half.size - 1)
        # by both ends: the middle of a panel as narrow as round-off is one of them
        left, right = self.edges[panel], self.edges[panel + 1]
        t = (((x - left) - (right - x)) / (right - left)).clip(-1.0, 1.0)
        out = powers[-1].take(panel)
        for row in powers[-2::-1]:
            out *= t
            out += row.take(panel)
        return out


class Bundle:
    """Many functions on the same panels, each as a series in powers of the place between a panel's ends, -1 to 1;
    powers has shape (16, functions, panels)."""

    def __init__(self, edges: Array, powers: Array) -> None:
        self.edges = edges
        self._powers = powers.reshape(_NODES, -1)

    def __call__(self, which: npt.NDArray[np.intp], x: Array) -> Array:
        """Values of the functions `which` at x, both of one shape; zero outside the panels."""
        panel = (np.searchsorted(self.edges, x, side="right") - 1).clip(0, self.edges.size - 2)
        left, right = self.edges[panel], self.edges[panel + 1]
        t = ((x - left) - (right - x)) / (right - left)
        at = which * (self.edges.size - 1) + panel
        out = self._powers[-1].take(at)
        for row in self._powers[-2::-1]:
            out *= t
            out += row.take(at)
        out[np.abs(t) > 1.0 + 1e-9] = 0.0
        return out

    def every(self, x: Array) -> Array:
        """All functions at x of shape (n,), shape (functions, n); zero outside the panels."""
        panel = (np.searchsorted(self.edges, x, side="right") - 1).clip(0, self.edges.size - 2)
        left, right = self.edges[panel], self.edges[panel + 1]
        t = ((x - left) - (right - x)) / (right - left)
        powers = self._powers.reshape(_NODES, -1, self.edges.size - 1)
        out = powers[-1].take(panel, axis=1)
        for row in powers[-2::-1]:
            out *= t
            out += row.take(panel, axis=1)
        out[:, np.abs(t) > 1.0 + 1e-9] = 0.0
        return out


    def mixed(self, shares: Array) -> "Bundle":
        """Sums of these functions, each times its share; shares has shape (sums, functions)."""
        return Bundle(self.edges, shares @ self._powers.reshape(_NODES, -1, self.edges.size - 1))


def bundle(tables: list[Piecewise]) -> Bundle:
    """Tables that are all on the same panels as one."""
    coefficients = np.stack([table.coefficients for table in tables], axis=1)
    return Bundle(tables[0].edges, np.tensordot(_POWERS[:_NODES, :_NODES], coefficients, 1))


def tabulate(
    function: Callable[[Array], Array],
    edges: Array,
    accuracy: float = 1e-16,
    narrow: Callable[[Array, Array], npt.NDArray[np.bool_]] | None = None,
    offset: float = 0.0,
    scale: Callable[[Array], Array] | None = None,
    relative: bool = False,
) -> list[Piecewise]:
    """Series of every row of `function` on the same panels, `edges` bisected until each is resolved.

    function maps positions of shape (n, 16) to values of shape (rows, n, 16). A panel is resolved when its last
    two Legendre terms, times its width, stay below `accuracy` or below round-off. A panel [left, right] that is
    `narrow` stays whole: the function is not known more finely there. Nor is it where it takes its positions from a
    place as far off as `offset`, below the rounding of that. `accuracy` is of values times `scale`, shape (rows, n) at
    positions of shape (n,), where there is one; `relative` to the least value on a panel where that exceeds 1.
    """
    edges = edges[np.diff(edges, prepend=-np.inf) > 0.0]
    left, right = edges[:-1], edges[1:]
    lean, pairs = np.zeros(left.size, dtype=np.int64), 0
    done_left: list[Array] = []
    done: list[Array] = []
    for depth in range(_DEPTH):
        if not left.size:
            break
        width = right - left
        x = left[:, None] + width[:, None] * (0.5 * (_X + 1.0))
        values = function(x)
        coefficients = np.moveaxis(values @ _PROJECT.T, -1, 0)
        size = np.abs(coefficients).max(axis=0)
        tail = np.abs(coefficients[-2:]).max(axis=0)
        # a position is known to round-off only, so a narrow panel far from 0 cannot be resolved better
        noise = 4e-15 + 1e-15 * (np.abs(left + right) + 2.0 * offset) / width
        middle = 0.5 * (left + right)
        felt = tail * width if scale is None else tail * width * scale(middle)
        allowed = accuracy * np.maximum(np.abs(values).min(axis=-1), 1.0) if relative else accuracy
        open_ = ((felt > allowed) & (tail > noise * size)).any(axis=0)
        open_ &= (middle > left) & (middle < right) & (depth < _DEPTH - 1)
        if narrow is not None:
            open_ &= ~narrow(left, right)
        done_left.append(left[~open_])
        done.append(coefficients[:, :, ~open_])
        left, right, lean, pairs = _divide(left, right, lean, pairs, open_)
    starts = np.concatenate(done_left) if done_left else np.empty(0)
    if not starts.size:
        return [Piecewise(edges[:1], np.empty((_NODES, 0)))]
    order = np.argsort(starts)
    coefficients = np.concatenate(done, axis=2)[:, :, order]
    all_edges = np.append(starts[order], edges[-1])
    return [Piecewise(all_edges, coefficients[:, row]) for row in range(coefficients.shape[1])]


def _divide(
    left: Array, right: Array, lean: Whole, pairs: int, open_: npt.NDArray[np.bool_]
) -> tuple[Array, Array, Whole, int]:
    """Halves of those panels [left, right] that are `open_`; towards an end where half after half was, the next four
    halvings at once.

    lean counts how often in a row the right half alone was open, or below 0 the left one; of the panels the first
    `pairs` are the left halves of what the next ones are the right halves of, here and in the answer.
    """
    halves = open_[: 2 * pairs].reshape(2, pairs)
    lower, upper = halves & ~halves[::-1]
    lean = lean.copy()
    lean[:pairs] = np.where(lower, np.minimum(lean[:pairs], 0) - 1, 0)
    lean[pairs : 2 * pairs] = np.where(upper, np.maximum(lean[pairs : 2 * pairs], 0) + 1, 0)
    left, right, lean = left[open_], right[open_], lean[open_]
    steep = (np.abs(lean) >= _STEEP) & (right - left > 1e-12 * np.maximum(np.abs(left), np.abs(right)))
    begin, end, plain = left[~steep], right[~steep], lean[~steep]
    middle = 0.5 * (begin + end)
    left, right, lean = left[steep, None], right[steep, None], lean[steep, None]
    near, far = np.where(lean < 0, left, right), np.where(lean < 0, right, left)
    marks = np.concatenate([near, near + (far - near) * _TOWARDS_END, far], axis=1)
    graded = np.sort(np.stack([marks[:, :-1], marks[:, 1:]]), axis=0)
    kept = np.concatenate([lean, np.zeros((lean.size, _TOWARDS_END.size), dtype=np.int64)], axis=1)
    return (
        np.concatenate([begin, middle, graded[0].ravel()]),
        np.concatenate([middle, end, graded[1].ravel()]),
        np.concatenate([plain, plain, kept.ravel()]),
        begin.size,
    )
