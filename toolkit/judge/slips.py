"""Sliders on a spring, whose slips come at places of their own: at which points of the path forces can be compared."""

from typing import Any

import numpy as np
import numpy.typing as npt

from origins.drive import Drive
from origins.errors import InputError

SLIDERS = (
    4  # of the ensemble, each with contacts of its own: their scatter gives its standard error
)
REMARK = (
    f"ensemble: {SLIDERS} sliders of so many contacts each, compared where each has slipped as often as the reference; "
    "it claims their scatter, 1 standard error, and not that N contacts slip late by some 0.5 N^(-2/3)/K <x_s>"
)

Counts = npt.NDArray[np.intp]


def check_one_way(drive: Drive) -> None:
    """InputError where the drive turns round: a place of it then does not tell when a slip begins."""
    if (np.diff(drive.path) < 0.0).any():
        raise InputError("drive: turns round; slips are counted along a drive that goes one way")


def slips_so_far(found: Any, drive: Drive) -> Counts:
    """How many slips have begun, and how many are over, at the points that an answer reaches: shape (sliders, 2, n),
    where the master equation has one slider."""
    clock = drive.arrival_times(found.balance)[: found.path.size]
    slips, sliders = found.slips, len(getattr(found, "forces", [0]))
    if slips is None:
        return np.zeros((sliders, 2, clock.size), np.intp)
    # the moments at which the drive, which goes forward wherever two answers are compared, is where slips begin
    begins = np.interp(slips.drive, found.path, clock)
    over = begins + getattr(slips, "duration", 0.0)
    of = getattr(slips, "replica", np.zeros(begins.size))
    each = [np.flatnonzero(of == slider) for slider in range(sliders)]
    counts = [
        [np.searchsorted(np.sort(times[own]), clock, "left") for times in (begins, over)]
        for own in each
    ]
    return np.array(counts, np.intp).reshape(sliders, 2, clock.size)


def alike(one: Counts, other: Counts) -> npt.NDArray[np.bool_]:
    """The points at which all sliders of both answers are between the same slips, or in none, shape (n,)."""
    common = min(one.shape[-1], other.shape[-1])
    both = np.concatenate([one[..., :common], other[..., :common]])
    between = both[:, 0] == both[:, 1]
    return np.asarray((between & (both[:, 0] == both[0, 0])).all(axis=0))
