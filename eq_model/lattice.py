"""The drive in whole numbers, and the bins in which births and breaks are summed along it.

Every length is a whole number of `unit`, far below the mean threshold, so that sums are exact and do
not depend on their order. While the slider moves the clock counts its travel; while it stands the
clock takes a mean threshold for each stand, however long. A path that moves forward is its own clock.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from eq_model.layout import BLOCK
from origins import Drive
from origins.errors import InputError

Array = npt.NDArray[np.float64]
Whole = npt.NDArray[np.int64]

# Breaks within so many units of a path point or a turn fall on it where thresholds are exact values: so
# far may rounding have carried them after some 1e6 breaks.
TIE = 1 << 10

SUM_BITS = 61  # of a block's sum in one bin; the sign and a bit to spare are left
_PATH_BITS = 57  # of the clock: positions beyond it, with a threshold added, stay in 64 bits
_MOST_BITS, _LEAST_BITS = 44, 24  # of a mean threshold: finer than the tables; too coarse for them
_FINEST = 2.0**-20  # of a mean threshold: the shortest cell
_LEAST_BINS = 1024  # of a long path: second moments are told relative to the ends of bins
_SAME_SPEED = 1e-12  # relative difference of two legs that are one


class Course(NamedTuple):
    """Legs of the drive, each of one speed, in whole units."""

    begins: Whole  # (m + 1,): clock at the ends of m legs
    positions: Whole  # (m + 1,): slider there
    directions: Whole  # (m,): of the motion, 0 where the slider stands
    paces: Array  # (m,): time that passes in one unit of the clock


class Bins(NamedTuple):
    """Points of the path in the order of the clock; each bin ends at one of them."""

    points: Whole  # (n,): the last moment that counts before each point
    places: Whole  # (n,): slider there; stretches of the bin's events are told as of then
    first: npt.NDArray[np.int32]  # of each cell of the clock the first point not before it
    shift: np.int64  # cells are 2^shift long
    even: bool  # each cell ends at a point
    offset: np.int64  # so that (clock + offset) >> shift is the point, where even
    end: np.int64  # the last moment that counts
    square: float  # whole second moments are this times unit^-2


@dataclass(frozen=True)
class Lattice:
    """Course and bins of a drive with their unit (a length).

    path : shape (n,), lengths; place : of each point of the path its bin.
    """

    path: Array
    unit: float
    course: Course
    bins: Bins
    place: npt.NDArray[np.intp]


def make_lattice(drive: Drive, scale: float, reach: float, exact: bool) -> Lattice:
    """The lattice of a rigid slider's drive.

    scale : the mean threshold's size; reach : the largest force that counts, in stretches of contacts
    of mean stiffness; exact : whether thresholds hold exact values, so that breaks fall on points.
    Raises InputError where the path is longer than 2^33 times the scale, or the reach than 2^21 times.
    """
    travel, duration, clock = _legs(drive, scale)
    length = max(float(clock[-1]), scale * _FINEST)
    points, spacing, place = _points(clock, max(scale, length / _LEAST_BINS))
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
    width = spacing or max(length / (4 * points.size), scale * _FINEST)
    shift = max(int(np.floor(np.log2(width / scale))) + bits, 0)
    unit = width * 2.0**-shift if spacing else scale * 2.0**-bits
    course = _course(travel, duration, scale, unit)
    whole = np.rint(points / unit).astype(np.int64)
    if spacing:
        whole = whole[0] + np.arange(whole.size) * (1 << shift)
    whole, found = np.unique(whole, return_inverse=True)
    leg = np.clip(np.searchsorted(course.begins, whole, side="right") - 1, 0, travel.size - 1)
    places = course.positions[leg] + course.directions[leg] * (whole - course.begins[leg])
    whole = whole + (TIE if exact else 0)
    beyond = max(whole[-1] - course.begins[-1], 0)
    course.begins[-1] += beyond
    course.positions[-1] += course.directions[-1] * beyond
    first = np.searchsorted(whole, np.arange((int(whole[-1]) >> shift) + 2) << shift)
    bins = Bins(
        points=whole,
        places=places,
        first=np.minimum(first, whole.size - 1).astype(np.int32),
        shift=np.int64(shift),
        even=bool(spacing),
        offset=np.int64((1 << shift) - 1 - whole[0]),
        end=whole[-1],
        square=2.0 ** min(SUM_BITS - _bits(BLOCK) - 2 * (room + bits), 0.0),
    )
    return Lattice(drive.path, unit, course, bins, found.reshape(-1)[place])


def _bits(number: float) -> int:
    """Of a number, which may be infinite: then more than there are."""
    return int(np.ceil(np.log2(min(number, 1e300))))


class _Points(NamedTuple):
    """Where bins end: at all path points, and in between where these are far apart."""

    clock: Array
    spacing: float  # of all of them, if to rounding it is one; else 0
    place: npt.NDArray[np.intp]  # of each path point its own


def _points(clock: Array, widest: float) -> _Points:
    """The ends of bins of the clock, at most `widest` apart (lengths)."""
    points, place = np.unique(clock, return_inverse=True)
    apart, end = np.diff(points), float(points[-1])
    spacing = float(end - points[0]) / apart.size if apart.size else end
    off = np.abs(points - (points[0] + spacing * np.arange(points.size))).max()
    if spacing > 0.0 and off <= 64.0 * np.finfo(float).eps * end:
        parts = 1 << max(_bits(spacing / widest), 0)
        spacing /= parts
        before = int(points[0] / spacing)
        many = before + parts * apart.size + 1
        if many <= 4 * points.size + 4 * _LEAST_BINS:
            even = points[0] + spacing * (np.arange(many) - before)
            return _Points(np.maximum(even, 0.0), spacing, before + parts * place.reshape(-1))
    more = points
    if np.diff(points, prepend=0.0).max() > widest:
        more = np.union1d(points, np.linspace(0.0, end, int(np.ceil(end / widest)) + 1)[1:])
    return _Points(more, 0.0, np.searchsorted(more, clock))


def _legs(drive: Drive, stand: float) -> tuple[Array, Array, Array]:
    """Travel (lengths, signed) and duration of each leg, and the clock at each point of the path (lengths).

    The clock takes `stand` for each leg on which the slider stands.
    """
    step = np.diff(drive.path, prepend=0.0)
    lasts = (
        np.abs(step) / drive.velocity if drive.time is None else np.diff(drive.time, prepend=0.0)
    )
    speed = np.divide(step, lasts, out=np.zeros(step.size), where=lasts > 0.0)
    passing = np.flatnonzero(lasts > 0.0)
    new = np.ones(passing.size, dtype=bool)
    if passing.size:
        before, after = speed[passing[:-1]], speed[passing[1:]]
        new[1:] = np.abs(after - before) > _SAME_SPEED * np.abs(before)
    leg = np.zeros(step.size, dtype=np.intp)
    leg[passing] = np.cumsum(new) - 1
    leg = np.asarray(np.maximum.accumulate(leg), dtype=np.intp)
    many = int(leg[-1]) + 1
    travel = np.bincount(leg, weights=step, minlength=many).astype(float)
    duration = np.bincount(leg, weights=lasts, minlength=many).astype(float)
    stands = np.bincount(leg, weights=np.abs(step), minlength=many) == 0.0
    share = np.divide(lasts, duration[leg], out=np.zeros(step.size), where=duration[leg] > 0.0)
    clock = np.cumsum(np.where(stands[leg], stand * share, np.abs(step)))
    if drive.forward and not stands.any():
        clock = drive.path  # to the last bit
    return travel, duration, np.asarray(clock, dtype=float)


def _course(travel: Array, duration: Array, scale: float, unit: float) -> Course:
    positions = np.rint(np.concatenate([[0.0], np.cumsum(travel)]) / unit).astype(np.int64)
    moved = np.diff(positions)
    ticks = np.where(moved != 0, np.abs(moved), max(round(scale / unit), 1))
    begins = np.concatenate([[0], np.cumsum(ticks)])
    return Course(begins, positions, np.sign(moved), duration / ticks)
