"""The kernel in plain numpy, bit for bit: slow, and simple enough to be read.

Contacts go through their own draws one block of four at a time; nothing here knows of lanes, batches or hot loops.
"""

import numpy as np
import numpy.typing as npt

from eq_model.lattice import Lattice, Whole
from eq_model.thermal_kernel import LEVEL_UNIT
from eq_model.thermal_tables import bearing_table
from origins import Thermal, streams
from origins.hot_cells import HOT_MISSING, HOT_OCTAVES
from origins.quantile import QuantileTable

Words = npt.NDArray[np.uint32]


def values(table: QuantileTable, unit: float, words: Words, more: Words) -> Whole:
    """Whole quantiles of random words, each continued by a word `more` where it lies in the tails, v < 2^-12."""
    factor = table.scale / unit
    count = (words & np.uint32(0x7FFFFFFF)).astype(np.int64)
    above = words >> np.uint32(31) == 1
    cell, t = table.hot.find(np.where(above, (1 << 32) - 1 - count, count))
    y = table.hot.value(cell, t)
    missing = y >= HOT_MISSING
    rest = np.where(count < 1 << (31 - HOT_OCTAVES), more, 1 << 31).astype(np.int64)
    v = (((count << 32) | rest)[missing].astype(float) + 0.5) * 2.0**-64
    y[missing] = np.where(above[missing], table.upper(v), table.lower(v))
    return np.minimum(np.floor(y * factor + 0.5), 2.0**58).astype(np.int64)


def address(first: int, n: int, n_contacts: int) -> tuple[npt.NDArray[np.uint64], npt.NDArray[np.uint64]]:
    """Replica and contact of contacts first ... first + n - 1 of the whole row."""
    index = np.arange(first, first + n, dtype=np.uint64)
    return index // np.uint64(n_contacts), index % np.uint64(n_contacts)


def begin(
    first: int, n_contacts: int, key: tuple[int, int], table: QuantileTable, start: QuantileTable, unit: float, n: int
) -> tuple[Whole, Whole]:
    """Negative starting stretches and free first thresholds, -1 where they do not exceed the stretch."""
    replica, contact = address(first, n, n_contacts)
    words = streams.words(key, streams.START, replica, contact, 0)
    more = streams.words(key, streams.START_TAILS, replica, contact, 0)
    births = -values(start, unit, words[0], more[0])
    thresholds = values(table, unit, words[1], more[1])
    return births, np.where(thresholds <= np.abs(births), -1, thresholds)


def run(
    first: int,
    n: int,
    n_contacts: int,
    key: tuple[int, int],
    table: QuantileTable,
    births: Whole,
    thresholds: Whole,
    lattice: Lattice,
    thermal: Thermal | None = None,
    velocity: float = 1.0,
) -> tuple[int, Whole]:
    """Breaks of contacts first ... first + n - 1, and the sums of each bin, shape (bins, 2).

    With `thermal` by its own inverse, which rounds otherwise than the kernel's tables: there no bit by bit.
    """
    unit = lattice.unit
    sums = np.zeros((lattice.bin_cell.size, 2), np.int64)
    replica, contact = address(first, n, n_contacts)
    position, breaks = np.zeros(n, np.int64), 0
    if births.size:
        position = births + thresholds
        going = position <= lattice.end
        breaks += _add(thresholds[going], position[going], lattice, sums)
        position, replica, contact = position[going], replica[going], contact[going]
    elif lattice.end < 0:
        position = position[:0]
    block = 0
    while position.size:
        words = streams.words(key, streams.THRESHOLDS, replica, contact, block)
        more = streams.words(key, streams.THRESHOLD_TAILS, replica, contact, block)
        bears, rest = words, more
        if thermal is not None:
            bears = streams.words(key, streams.LIVES, replica, contact, block)
            rest = streams.words(key, streams.LIFE_TAILS, replica, contact, block)
        for k in range(4):
            x = values(table, unit, words[k], more[k])
            if thermal is not None:
                amount = velocity * np.exp(values(bearing_table(), LEVEL_UNIT, bears[k], rest[k]) * LEVEL_UNIT)
                x = np.rint(thermal.inverse(amount, x * unit) / unit).astype(np.int64)
            position = position + x
            going = position <= lattice.end
            breaks += _add(x[going], position[going], lattice, sums)
            position, replica, contact = position[going], replica[going], contact[going]
            words, more, bears, rest = words[:, going], more[:, going], bears[:, going], rest[:, going]
        block += 1
    return breaks, sums


def _add(x: Whole, b: Whole, lattice: Lattice, sums: Whole) -> int:
    cell = (b + lattice.offset) >> lattice.shift
    point = np.searchsorted(lattice.points, b)
    # the bin of this cell and this next path point; of two alike the later only where the cell is crowded
    many = lattice.points.size + 1
    known = lattice.bin_cell * many + lattice.bin_point
    order = np.argsort(known, kind="stable")
    wanted = cell * many + point
    crowded = lattice.bound[cell] < 0 if lattice.bound.size else np.zeros(b.shape, dtype=bool)
    last = np.searchsorted(known[order], wanted, side="right") - 1
    bins = order[np.where(crowded, last, np.searchsorted(known[order], wanted))]
    reference = ((cell + 1) << lattice.shift) - 1 - lattice.offset
    moment = np.rint(x.astype(float) * (2 * (b - reference) - x).astype(float) * lattice.square)
    np.add.at(sums, bins, np.stack([x, moment.astype(np.int64)], axis=-1))
    return b.size
