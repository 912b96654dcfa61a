"""Hot cells: the quadratic pieces of a quantile that a draw finds from its own bits, without a search.

The numbers u = (m + 1/2) 2^-32 are divided into stretches, one for a law without gaps, and each stretch into two
pieces, counted from its two ends: v is the distance from that end. Each octave of v has the same number of cells, so
the quantile is resolved where it is steep: in the tails, and on both sides of a gap or of a deep valley of P_c.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]
Whole = npt.NDArray[np.int64]

CHECKS = (np.arange(10) + 0.5) / 10.0
HOT_OCTAVES = 11  # 2^-12 <= v < 2^-1
HOT_MISSING = 2.0**60  # the hot value that sends a draw to the fine cells
MOST_PIECES = 6
WHOLE = 1 << 32

# more cells where P_c is rough, the fewest that leave little to the fine ones: a small table stays in the cache
_BITS = (5, 7, 9)
_MISSED = 0.005
_INSET = 2.0**-49
_LEAST_STRETCH = 2.0**-8


class Tail(Protocol):
    """One side of a law: quantiles by their tail probability p, in units of the table's scale."""

    def known(self, p: Array) -> Array: ...
    def certified(self, y: Array, p: Array, width: Array) -> Flags: ...
    def jumps_inside(self, low: Array, high: Array) -> Flags: ...


@dataclass(frozen=True)
class HotCells:
    """Hot cells of S pieces, in units of the table's scale.

    bits : each octave 2^e <= v < 2^(e + 1) has M = 2^bits cells.
    ends : shape (S + 1,), multiples of 2^-32; piece s holds ends[s] <= m < ends[s + 1] and counts v = (c + 1/2) 2^-32
        from its lower end, c = m - ends[s], where s is even, from its upper one, c = ends[s + 1] - 1 - m, where odd.
    c0, c1, c2 : shape (S (11 M + 1),); cell k of a piece, counted from v = 2^-12, stands at its (k + 1)th place; the
        first means v < 2^-12. With t = v / 2^e - (1 + k / M), the distance inside the cell of the octave,
        value = c0 + t (c1 + t c2); c1 and c2 are exact in single precision.
    missed : probability of v >= 2^-12 whose cells are missing: c0 is HOT_MISSING.
    """

    bits: int
    ends: Whole
    c0: Array
    c1: Array
    c2: Array
    missed: float

    @property
    def per_piece(self) -> int:
        """Places of each piece."""
        return self.c0.size // (self.ends.size - 1)

    def find(self, m: Whole) -> tuple[Whole, Array]:
        """Place of the cell in which each m lies, and t."""
        piece = np.searchsorted(self.ends, m, side="right") - 1
        count = np.where(piece % 2 == 0, m - self.ends[piece], self.ends[piece + 1] - 1 - m)
        bits = (count + 0.5).view(np.int64)
        shift = 52 - self.bits
        cell = np.maximum((bits >> shift) - ((1023 + 31 - HOT_OCTAVES) << self.bits), -1) + 1
        return piece * self.per_piece + cell, ((bits & ((1 << shift) - 1)) | (1023 << 52)).view(np.float64) - 1.0

    def value(self, place: Whole, t: Array) -> Array:
        """Values at t of the cells at `place`; at least HOT_MISSING where the fine cells must be asked."""
        return self.c0[place] + t * (self.c1[place] + t * self.c2[place])


def hot_cells(below: Tail, above: Tail, edges: Array, steepness: Array) -> HotCells:
    """The fewest cells, in the fewest pieces, that leave at most 0.005 to the fine ones.

    edges, steepness : where a stretch may end, as u, and how steep the quantile is there.
    """
    inner = np.empty(0, dtype=np.int64)
    best, failing = _build(below, above, inner, _BITS[0])
    while best.missed > _MISSED and best.ends.size - 1 < MOST_PIECES:
        wanted = _steepest(failing, best.ends, edges, steepness)
        if wanted is None:
            break
        inner = np.sort(np.append(inner, wanted))
        more, failing = _build(below, above, inner, _BITS[0])
        if more.missed > 0.7 * best.missed:
            break
        best = more
    inner = best.ends[2:-1:2]
    for bits in _BITS[1:]:
        if best.missed <= _MISSED:
            break
        best, _ = _build(below, above, inner, bits)
    return best


def _steepest(failing: Array, ends: Whole, edges: Array, steepness: Array) -> int | None:
    """Where the quantile is steepest within intervals of u, shape (n, 2), not too near to the stretches' ends."""
    inside = ((edges[:, None] >= failing[:, 0]) & (edges[:, None] <= failing[:, 1])).any(axis=1)
    inside &= np.abs(edges[:, None] - ends[::2] / WHOLE).min(axis=1) >= _LEAST_STRETCH
    if not inside.any():
        return None
    return int(np.rint(edges[inside][steepness[inside].argmax()] * WHOLE))


def _build(below: Tail, above: Tail, inner: Whole, bits: int) -> tuple[HotCells, Array]:
    """Cells of the stretches that end at `inner`, and the cells that failed, as intervals of u, shape (n, 2)."""
    outer = np.concatenate([[0], inner, [WHOLE]])
    ends = np.empty(2 * outer.size - 1, dtype=np.int64)
    ends[::2], ends[1::2] = outer, (outer[:-1] + outer[1:]) // 2
    columns, failing = [], []
    for piece in range(ends.size - 1):
        down = piece % 2 == 1
        start, size = float(ends[piece + down]) / WHOLE, float(ends[piece + 1] - ends[piece]) / WHOLE
        fit, near, far = _piece(below, above, start, down, size, bits)
        columns.append(fit)
        failing.append(np.stack([start - far, start - near] if down else [start + near, start + far], axis=-1))
    c0, c1, c2 = np.concatenate(columns, axis=1)
    intervals = np.concatenate(failing)
    return HotCells(bits, ends, c0, c1, c2, float(np.diff(intervals).sum())), intervals


def _piece(below: Tail, above: Tail, start: float, down: bool, size: float, bits: int) -> tuple[Array, Array, Array]:
    """Columns c0, c1, c2 of one piece, shape (3, 11 M + 1), and the ends in v of each cell that failed."""
    cells = 1 << bits
    octave = np.repeat(2.0 ** np.arange(-1 - HOT_OCTAVES, -1), cells)
    v = octave * np.tile(1.0 + np.arange(cells) / cells, HOT_OCTAVES)
    width = octave / cells
    fit = np.zeros((3, v.size + 1))
    fit[0] = HOT_MISSING
    middle = start - v if down else start + v
    for tail, here in ((below, (v < size) & (middle <= 0.5)), (above, (v < size) & (middle > 0.5))):
        if here.any():
            # the tail probability at v is base + sign * v
            base, sign = (1.0 - start if tail is above else start), (1.0 if down == (tail is above) else -1.0)
            found, good = _quadratics(tail, base, sign, v[here], width[here], 1.0 / cells)
            fit[:, np.flatnonzero(here)[good] + 1] = found[:, good]
    failed = (v < size) & (fit[0, 1:] == HOT_MISSING)
    return fit, v[failed], np.minimum(v + width, size)[failed]


def _quadratics(tail: Tail, base: float, sign: float, v: Array, width: Array, h: float) -> tuple[Array, Flags]:
    """Quadratics of cells [v, v + width), shape (3, n), each exact at both ends, and which are certified."""
    begin, end = base + sign * v, base + sign * (v + width)
    ends = begin * (1.0 + sign * _INSET), end * (1.0 - sign * _INSET)
    first, middle, last = (tail.known(p) for p in (ends[0], 0.5 * (begin + end), ends[1]))
    slope = (last - first) / h
    c1 = _single((4.0 * middle - 3.0 * first - last) / h)
    c2 = _single((slope - c1) / h)
    # rounding to single precision must not carry the cell beyond its end, where a gap may begin
    stop = first + h * (c1 + h * c2)
    upward = last > first
    beyond = np.where(upward, stop > last, stop < last)
    c2 = np.where(beyond, _single(c2, np.where(upward, -np.inf, np.inf)), c2)
    stop = first + h * (c1 + h * c2)
    within = np.where(upward, stop <= last, stop >= last)
    monotone = (c1 * slope >= 0.0) & ((c1 + 2.0 * h * c2) * slope >= 0.0)
    t = h * CHECKS
    values = first[:, None] + t * (c1[:, None] + t * c2[:, None])
    p = base + sign * (v[:, None] + width[:, None] * CHECKS)
    good = within & monotone & tail.certified(values, p, width)
    # a jump so near the end of a cell that no check sees it
    good &= ~tail.jumps_inside(np.minimum(begin, end), np.maximum(begin, end))
    return np.stack([first, c1, c2]), good


def _single(values: Array, beyond: Array | None = None) -> Array:
    """Values rounded to single precision; or, where `beyond` is given, the next one in its direction."""
    short = values.astype(np.float32)
    return (short if beyond is None else np.nextafter(short, beyond.astype(np.float32))).astype(float)
