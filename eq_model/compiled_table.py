"""Quantile tables as the compiled kernels take them."""

from typing import Any

import numpy as np
import numpy.typing as npt

from origins.hot_cells import HOT_MISSING, MOST_PIECES, WHOLE, HotCells
from origins.quantile import FINE_BITS, QuantileTable


def kernel_table(table: QuantileTable, unit: float) -> tuple[Any, ...]:
    """A quantile table as the kernel takes it: hot cells packed in sixteen bytes each, in units of the lattice."""
    from eq_model.kernel import FAR, MISSING

    factor = table.scale / unit
    # above MISSING after rounding, and four of them beyond a position still below 2^63
    missed = 1.25 * MISSING
    hot = table.hot
    missing = hot.c0 >= HOT_MISSING
    far = ~missing & (np.abs(hot.c0) * factor > FAR)
    packed = np.zeros((hot.c0.size, 2))
    packed[:, 0] = np.where(missing, missed / factor, np.where(far, FAR / factor, hot.c0))
    slopes = np.stack([hot.c1, hot.c2], axis=-1)
    packed.view(np.float32)[:, 2:] = np.where((missing | far)[:, None], 0.0, slopes)
    sides, firsts, edges, cubics = [], [], [], []
    place, cells = 0, 0
    for side in (table.lower, table.upper):
        # where each regular cell begins among the cells, and the number of the first, as the bits of v have it
        numbers = side.edges[:-1].view(np.int64) >> (52 - FINE_BITS)
        first = np.searchsorted(numbers, np.arange(numbers[0], numbers[-1] + 1)) + cells
        sides.append((place, first.size, numbers[0], cells + len(side.cubics) - 1))
        firsts.append(first)
        edges.append(side.edges)
        cubics += [side.cubics, np.zeros((1, 6))]  # one cell less than edges: kept in step
        place, cells = place + first.size, cells + side.edges.size
    fine = np.array(sides, dtype=np.int64), np.concatenate(firsts), np.concatenate(edges), np.concatenate(cubics)
    return packed.view(np.int64).ravel(), np.int64(52 - hot.bits), _pieces(hot), factor, *fine


def _pieces(hot: HotCells) -> npt.NDArray[np.uint32]:
    """Rows of the pieces as the kernel takes them: two, or with some that no number reaches MOST_PIECES."""
    n = hot.ends.size - 1
    ends = np.where(np.arange(n) % 2 == 1, hot.ends[1:], hot.ends[:-1])
    rows = np.stack([hot.ends[:-1] - 1, ends, np.arange(n) * hot.per_piece], axis=-1)
    unreached = np.tile([WHOLE - 1, 0, 0], (0 if n == 2 else MOST_PIECES - n, 1))
    return (np.concatenate([rows, unreached]) % WHOLE).astype(np.uint32)
