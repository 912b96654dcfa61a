"""The mean force of stick-slip: over periods of the drive, or from one slip of a slider to another."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from origins.thresholds.law import Array
from toolkit.verdict.sliders.records import Behaviour, Finite

# of a path, its first part, over which the force of stick-slip is not averaged: contacts began together there
FORGOTTEN = 1.0 / 3.0
# part of the mean fall that is a slip of the trace, and of the period in which the force falls in it
OF_A_FALL, IN_NO_TIME = 0.5, 1e-6


class MeanForce(NamedTuple):
    """The mean spring force of stick-slip and its error, F/(N_c <k>) (lengths)."""

    force: float
    error: float


def mean_over_slips(one: Behaviour | Finite) -> float | None:
    """The mean force over the last periods of stick-slip, F/(N_c <k>) (a length); None where none is seen."""
    drive, period = one.drive, one.period
    if one.kind != "stick-slip" or not period or not drive.size:
        return None
    many = _periods(one, period)
    begin = drive[-1] - many * period
    if begin < drive[0]:
        return None
    later = drive > begin
    places = np.append(begin, drive[later])
    force = np.append(np.interp(begin, drive, one.force), one.force[later])
    return float(np.trapezoid(force, places) / (many * period))


def mean_of_contacts(finite: Finite) -> MeanForce | None:
    """The mean force of one slider of so many contacts, from a late slip of its own to its last one, as periods that
    scatter fit no window of the drive; its error is that of the forces before slips, and the scatter from one slip to
    the next. None where the trace has too few slips, or slips so unlike that it lies outside their mean fall. A mass
    slips for a time: of its trace the mean is that of `mean_over_slips`."""
    if finite.kind != "stick-slip" or not finite.period or not finite.drive.size:
        return None
    drive, force, fall = finite.drive, finite.force, finite.before - finite.after
    if finite.rule == "mass":
        mean = mean_over_slips(finite)
        return None if mean is None else MeanForce(mean, finite.force_error)
    at_once = np.abs(np.diff(drive)) <= IN_NO_TIME * finite.period
    falls = np.flatnonzero(at_once & (np.sign(fall) * np.diff(force) < -OF_A_FALL * abs(fall)))
    many = min(_periods(finite, finite.period), falls.size - 1)
    if many < 1:
        return None
    late = falls[-many - 1 :]
    # from the point behind a slip to that before the next one
    each = np.array([_over(drive, force, int(i) + 1, int(j)) for i, j in pairwise(late)])
    ways = np.diff(drive[late])
    mean = float(each @ ways / ways.sum())
    scatter = float(each.std(ddof=1)) / many**0.5 if many > 1 else 0.0
    error = max(finite.force_error, scatter)
    low, high = sorted((finite.before, finite.after))
    return MeanForce(mean, error) if low - error <= mean <= high + error else None


def _periods(one: Behaviour | Finite, period: float) -> int:
    """How many of the last periods tell the mean: of those in turn long and short as many of each."""
    many = max(int((1.0 - FORGOTTEN) * (one.drive[-1] - one.drive[0]) / period), 1)
    return many - (many % 2 if many > 1 else 0)


def _over(drive: Array, force: Array, first: int, last: int) -> float:
    """The mean of the force between two points."""
    part = slice(first, last + 1)
    return float(np.trapezoid(force[part], drive[part]) / (drive[last] - drive[first]))
