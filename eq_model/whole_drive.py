"""The drive in whole numbers, and the bins in which births and breaks are summed along it.

Every length is a whole number of `unit`, far below the mean threshold, so that sums are exact and do
not depend on their order. While the slider moves, the clock counts its travel; each hold, however
long, takes one mean threshold of the clock. On a path that only moves forward the clock is X.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from eq_model.blocks import BLOCK, Whole
from origins import Drive
from origins.errors import InputError
from origins.thresholds.law import Array

# With exact thresholds, breaks within this many units of a path point or a turn count as falling on it:
# rounding may have moved them as far after some 1e6 breaks.
TIE = 1 << 10

STIFFNESS_UNIT = 2.0**36  # k and k² are summed as whole multiples of 1/STIFFNESS_UNIT


class WholeDrive(NamedTuple):
    """The drive in whole units, for kernels: m legs of one speed each, and n bins in the order of the clock, which end
    at the points of the path and between.
    """

    unit: float  # a length
    bin_of_point: npt.NDArray[np.intp]  # of each point of the drive's path
    begins: Whole  # (m + 1,): the clock at the ends of legs
    positions: Whole  # (m + 1,): the slider there
    directions: Whole  # (m,): of the motion, 0 in a hold
    paces: Array  # (m,): time in one unit of the clock
    # (n + 1,): the last instant that belongs to each bin; and one that is never reached
    bin_ends: Whole
    bin_positions: (
        Whole  # (n + 1,): the slider there, to which stretches of the bin's events refer; and 0
    )
    first_bin: npt.NDArray[np.int32]  # the first bin that ends in each cell of the clock or later
    shift: np.int64  # a cell is 2^shift long
    even: bool  # whether each cell is a bin, that of (clock + offset) >> shift
    offset: np.int64
    end: np.int64  # last instant of the drive
    square: float  # whole second moments are this times unit^-2
    watched: npt.NDArray[np.intp] = np.zeros(0, np.intp)  # bins at whose ends contacts are counted
    before: npt.NDArray[np.intp] = np.zeros(0, np.intp)  # (n + 2,): number of them before each bin
    per_stretch: float = 1.0  # bins of histograms per unit of |x|
    per_threshold: float = 1.0


def whole_drive(drive: Drive, scale: float, largest: float, exact: bool) -> WholeDrive:
    """The drive of a rigid slider in whole units.

    scale : the mean threshold; largest : the largest force of a contact divided by <k>, a length; exact : whether
    thresholds have exact values, so that breaks fall on points.
    Raises InputError where the path is longer than 2^33 times the scale, or `largest` than 2^22 times.
    """
    legs, clock = _legs(drive, scale)
    shortest, bins = scale * 2.0**-20, 1024  # of a cell; second moments need short bins
    length = max(float(clock[-1]), shortest)
    points, spacing = _points(clock, max(scale, length / bins), 4 * clock.size + 4 * bins)
    widest = float(np.diff(points, prepend=0.0).max())
    # a bin's sum over one block, in 61 bits, is at most BLOCK (widest + largest), its second moment the square of that
    free, room = 61 - _bits(BLOCK), _bits((widest + largest) / scale)
    # of a mean threshold: 44 are finer than the tables, 57 of the clock keep positions beyond the end in 64 bits
    bits = min(44, free - room, 57 - _bits(length / scale))
    if largest / scale > 2.0 ** (free - 24):
        raise InputError(
            f"thresholds: stretches may reach {largest / scale:.2g} mean thresholds, linked stiffness counted "
            "in; the ensemble sums up to some 1e6 of them: use thresholds with a shorter tail, or other units"
        )
    if bits < 22:
        raise InputError(
            f"path[-1] = {drive.path[-1]:g}: lies {length / scale:.2g} mean thresholds away; the ensemble "
            "follows contacts along a path of at most 8e9 of them"
        )
    spacing *= spacing >= scale * 2.0**-bits  # points closer than a unit share bins
    width = spacing or max(length / (16 * points.size), shortest)
    shift = max(int(np.floor(np.log2(width / scale))) + bits, 0)
    unit = width * 2.0**-shift if spacing else scale * 2.0**-bits
    positions = np.rint(np.append(0.0, np.cumsum(legs[0])) / unit).astype(np.int64)
    moved = np.diff(positions)
    ticks = np.where(moved != 0, np.abs(moved), max(round(scale / unit), 1))
    begins, directions = np.append(0, np.cumsum(ticks)), np.sign(moved)
    whole, number = np.rint(points / unit).astype(np.int64), np.searchsorted(points, clock)
    if spacing:
        whole = whole[0] + np.arange(whole.size) * (1 << shift)
        number = np.rint((clock - points[0]) / spacing).astype(np.intp)
    whole, bin_of = np.unique(whole, return_inverse=True)
    leg = np.clip(np.searchsorted(begins, whole, side="right") - 1, 0, moved.size - 1)
    ends = whole + (TIE if exact else 0)
    beyond = max(ends[-1] - begins[-1], 0)
    begins[-1] += beyond
    positions[-1] += directions[-1] * beyond
    first = np.searchsorted(ends, np.arange((int(ends[-1]) >> shift) + 2) << shift)
    return WholeDrive(
        unit,
        bin_of[number],
        begins,
        positions,
        directions,
        paces=legs[1] / ticks,
        bin_ends=np.append(ends, np.iinfo(np.int64).max),
        bin_positions=np.append(positions[leg] + directions[leg] * (whole - begins[leg]), 0),
        first_bin=np.minimum(first, ends.size - 1).astype(np.int32),
        shift=np.int64(shift),
        even=bool(spacing),
        offset=np.int64((1 << shift) - 1 - ends[0]),
        end=ends[-1],
        square=2.0 ** min(free - 2 * (room + bits), 0.0),
    )


def ticks_of(drive: WholeDrive, wait: float) -> Whole:
    """Ticks of the clock in a time, on each leg, shape (m,); far beyond the end where the clock runs that fast."""
    paces = drive.paces
    ticks = np.divide(wait, paces, out=np.full(paces.size, np.inf), where=paces > 0.0)
    return np.floor(np.minimum(ticks, 2.0**62) + 0.5).astype(np.int64)


def further_legs(drive: WholeDrive) -> Whole:
    """For each leg the first later one that ends beyond both of its ends, or else the last one; shape (m,).

    A contact that has held to both ends of a leg breaks on none before.
    """
    ends = drive.positions.tolist()
    last = len(ends) - 2
    found = [last] * (last + 1)
    for leg in range(last - 1, -1, -1):
        low, high = sorted(ends[leg : leg + 2])
        later = leg + 1
        while later < last and low <= ends[later + 1] <= high:
            later = found[later]  # until then the slider stays between the ends of `later`
        found[leg] = later
    return np.array(found)


def _bits(number: float) -> int:
    """Bits of a number >= 0, of which 0 and inf count as a tiny and a huge one."""
    return int(np.ceil(np.log2(np.clip(number, 1e-300, 1e300))))


def _points(clock: Array, widest: float, most: int) -> tuple[Array, float]:
    """The ends of bins of the clock: all points of the path, and more in between where these are more than `widest`
    apart (lengths); and their spacing if it is constant to rounding and there are at most `most`, else 0."""
    points = np.unique(clock)
    end = float(points[-1])
    spacing = float(end - points[0]) / (points.size - 1) if points.size > 1 else end
    off = np.abs(points - (points[0] + spacing * np.arange(points.size))).max()
    if spacing > 0.0 and off <= 64.0 * np.finfo(float).eps * end:
        spacing /= 1 << max(_bits(spacing / widest), 0)
        before = int(points[0] / spacing)
        many = before + round((end - points[0]) / spacing) + 1
        if many <= most:
            return np.maximum(points[0] + spacing * (np.arange(many) - before), 0.0), spacing
    return np.union1d(points, np.linspace(0.0, end, int(np.ceil(end / widest)) + 1)[1:]), 0.0


def durations(drive: Drive) -> Array:
    """Durations of the motion to each point of the path from the one before, shape (n,)."""
    if drive.time is not None:
        return np.diff(drive.time, prepend=0.0)
    return np.abs(np.diff(drive.path, prepend=0.0)) / drive.velocity


def _legs(drive: Drive, stand: float) -> tuple[Array, Array]:
    """Travel (lengths, signed) and duration of each leg, shape (2, m), and the clock at each point of the path.

    The clock advances by `stand` in each hold.
    """
    step, lasts = np.diff(drive.path, prepend=0.0), durations(drive)
    taken = np.flatnonzero(lasts > 0.0)
    speed, new = step[taken] / lasts[taken], np.zeros(step.size, np.intp)
    # where the speed is one but for the rounding of positions and times, it is one leg
    with np.errstate(all="ignore"):
        ratio = np.abs(drive.path[taken] / step[taken]) + np.cumsum(lasts)[taken] / lasts[taken]
        doubt = (1e-12 + 4.0 * np.finfo(float).eps * ratio) * np.abs(speed)
    doubt[speed == 0.0] = 0.0
    new[taken[1:]] = np.abs(np.diff(speed)) > np.minimum(doubt[:-1], doubt[1:])
    leg = np.cumsum(new)
    legs = np.array([np.bincount(leg, weights=each) for each in (step, lasts)])
    stands = np.bincount(leg, weights=np.abs(step)) == 0.0
    ratio = lasts / np.where(legs[1] > 0.0, legs[1], 1.0)[leg]
    clock = np.cumsum(np.where(stands[leg], stand * ratio, np.abs(step)))
    if drive.forward and not stands.any():
        clock = drive.path  # to the last bit
    return legs, clock
