"""The drive in whole numbers, and the bins in which births and breaks are summed along it.

Every length is a whole number of `unit`, far below the mean threshold, so that sums are exact and do
not depend on their order. While the slider moves, the clock counts its travel; each hold, however
long, takes one mean threshold of the clock. On a path that only moves forward the clock is X.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from eq_model.layout import BLOCK
from origins import Drive
from origins.errors import InputError

Array = npt.NDArray[np.float64]
Whole = npt.NDArray[np.int64]

# With exact thresholds, breaks within this many units of a path point or a turn count as falling on it:
# rounding may have moved them as far after some 1e6 breaks.
TIE = 1 << 10

STIFFNESS_UNIT = 2.0**36  # k and k² are summed as whole multiples of 1/STIFFNESS_UNIT
SUM_BITS = 61  # of a block's sum in one bin, which leaves the sign and a spare bit
_PATH_BITS = 57  # of the clock, so that positions beyond the end plus a threshold stay in 64 bits
_MOST_BITS, _LEAST_BITS = 44, 24  # of a mean threshold: finer than the tables; too coarse for them
_FINEST = 2.0**-20  # shortest cell, in mean thresholds
_LEAST_BINS = 1024  # of a long path: second moments, relative to the ends of bins, need short bins
_SAME_SPEED = 1e-12  # relative difference of speeds below which two legs are merged
_NOTHING = np.zeros(0, np.int64)


class Way(NamedTuple):
    """The drive in whole units, for kernels: m legs of one speed each, n points in the order of the clock, at each of
    which a bin ends, and the points at which contacts are counted."""

    unit: float  # a length
    place: npt.NDArray[np.intp]  # bin of each point of the drive's path
    begins: Whole  # (m + 1,): clock at the ends of legs
    positions: Whole  # (m + 1,): the slider's position there
    directions: Whole  # (m,): of the motion, 0 in a hold
    paces: Array  # (m,): time that passes in one unit of the clock
    points: Whole  # (n,): the last moment that belongs to each point's bin
    places: Whole  # (n,): the slider's position there, to which stretches of the bin's events refer
    first: npt.NDArray[np.int32]  # for each cell of the clock, the first point not before it
    shift: np.int64  # cells are 2^shift long
    even: bool  # each cell ends at a point
    offset: np.int64  # so that (clock + offset) >> shift is the point, if even
    end: np.int64  # the last moment of the drive
    square: float  # whole second moments are this times unit^-2
    before: Whole = _NOTHING  # (n + 2,): number of watched points before each point
    moments: Whole = _NOTHING  # (k,): the last moments that belong to watched points
    spots: Whole = _NOTHING  # (k,): the slider's positions there
    per_stretch: float = 1.0  # histogram bins per unit of |x|
    per_threshold: float = 1.0

    def watched(self, own: npt.NDArray[np.intp], per_stretch: float, per_threshold: float) -> "Way":
        """This way, with contacts counted at the ends of these bins, in their order."""
        before = np.searchsorted(own, np.arange(self.points.size + 2))
        moments, spots = self.points[own], self.places[own]
        counted = self._replace(before=before, moments=moments, spots=spots)
        return counted._replace(per_stretch=per_stretch, per_threshold=per_threshold)


def make_way(drive: Drive, scale: float, reach: float, exact: bool) -> Way:
    """The way of a rigid slider.

    scale : the mean threshold; reach : the largest force of a contact over <k>, a length; exact : whether
    thresholds have exact values, so that breaks fall on points.
    Raises InputError where the path is longer than 2^33 times the scale, or the reach than 2^21 times.
    """
    legs, clock = _legs(drive, scale)
    length = max(float(clock[-1]), scale * _FINEST)
    points, spacing = _points(clock, max(scale, length / _LEAST_BINS))
    widest = float(np.diff(points, prepend=0.0).max())
    # a bin's sum over one block is at most BLOCK (widest + reach), its second moment the square of that
    room = _bits((widest + reach) / scale)
    most = SUM_BITS - _bits(BLOCK) - room
    bits = min(_MOST_BITS, most, _PATH_BITS - _bits(length / scale))
    if reach / scale > 2.0 ** (SUM_BITS - _bits(BLOCK) - _LEAST_BITS):
        raise InputError(
            f"thresholds: stretches may reach {reach / scale:.2g} mean thresholds, linked stiffness counted "
            "in; the ensemble sums up to some 1e6 of them: use thresholds with a shorter tail, or other units"
        )
    if bits < _LEAST_BITS:
        raise InputError(
            f"path[-1] = {drive.path[-1]:g}: lies {length / scale:.2g} mean thresholds away; the ensemble "
            "follows contacts along a path of at most 8e9 of them"
        )
    spacing *= spacing >= scale * 2.0**-bits  # points closer than a unit share bins
    width = spacing or max(length / (4 * points.size), scale * _FINEST)
    shift = max(int(np.floor(np.log2(width / scale))) + bits, 0)
    unit = width * 2.0**-shift if spacing else scale * 2.0**-bits
    positions = np.rint(np.append(0.0, np.cumsum(legs[0])) / unit).astype(np.int64)
    moved = np.diff(positions)
    ticks = np.where(moved != 0, np.abs(moved), max(round(scale / unit), 1))
    begins, directions = np.append(0, np.cumsum(ticks)), np.sign(moved)
    whole = np.rint(points / unit).astype(np.int64)
    if spacing:
        whole = whole[0] + np.arange(whole.size) * (1 << shift)
    whole, found = np.unique(whole, return_inverse=True)
    leg = np.clip(np.searchsorted(begins, whole, side="right") - 1, 0, moved.size - 1)
    places = positions[leg] + directions[leg] * (whole - begins[leg])
    whole = whole + (TIE if exact else 0)
    beyond = max(whole[-1] - begins[-1], 0)
    begins[-1] += beyond
    positions[-1] += directions[-1] * beyond
    first = np.searchsorted(whole, np.arange((int(whole[-1]) >> shift) + 2) << shift)
    place = np.searchsorted(points, clock)
    if spacing:
        place = np.rint((clock - points[0]) / spacing).astype(np.intp)
    return Way(
        unit,
        found.reshape(-1)[place],
        begins,
        positions,
        directions,
        paces=legs[1] / ticks,
        points=whole,
        places=places,
        first=np.minimum(first, whole.size - 1).astype(np.int32),
        shift=np.int64(shift),
        even=bool(spacing),
        offset=np.int64((1 << shift) - 1 - whole[0]),
        end=whole[-1],
        square=2.0 ** min(SUM_BITS - _bits(BLOCK) - 2 * (room + bits), 0.0),
    )


def _bits(number: float) -> int:
    """Bits of a number >= 0, which may be infinite (then more than there are)."""
    return int(np.ceil(np.log2(min(max(number, 1e-300), 1e300))))


def _points(clock: Array, widest: float) -> tuple[Array, float]:
    """The ends of bins of the clock: all points of the path, and more in between where these are more than `widest`
    apart (lengths); and their spacing if it is constant to rounding, else 0."""
    points = np.unique(clock)
    end, apart = float(points[-1]), max(points.size - 1, 1)
    spacing = float(end - points[0]) / apart if points.size > 1 else end
    off = np.abs(points - (points[0] + spacing * np.arange(points.size))).max()
    if spacing > 0.0 and off <= 64.0 * np.finfo(float).eps * end:
        spacing /= 1 << max(_bits(spacing / widest), 0)
        before = int(points[0] / spacing)
        many = before + round((end - points[0]) / spacing) + 1
        if many <= 4 * points.size + 4 * _LEAST_BINS:
            return np.maximum(points[0] + spacing * (np.arange(many) - before), 0.0), spacing
    if np.diff(points, prepend=0.0).max() > widest:
        between = np.linspace(0.0, end, int(np.ceil(end / widest)) + 1)[1:]
        points = np.union1d(points, between)
    return points, 0.0


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
    new[taken[1:]] = np.abs(np.diff(speed)) > _SAME_SPEED * np.abs(speed[:-1])
    leg = np.cumsum(new)
    legs = np.array([np.bincount(leg, weights=each) for each in (step, lasts)])
    stands = np.bincount(leg, weights=np.abs(step)) == 0.0
    share = lasts / np.where(legs[1] > 0.0, legs[1], 1.0)[leg]
    clock = np.cumsum(np.where(stands[leg], stand * share, np.abs(step)))
    if drive.forward and not stands.any():
        clock = drive.path  # to the last bit
    return legs, clock
