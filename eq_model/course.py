"""The drive as whole numbers: a clock that goes on as the slider moves, turns round or stands, and where it is then.

While the slider moves the clock counts its travel; while it stands the clock takes a mean threshold for each stand,
however long. So every position and every moment is a whole number, and a path that moves forward has its positions
for a clock.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from eq_model.lattice import Lattice, Whole, make_lattice
from origins import Drive

Array = npt.NDArray[np.float64]

_SAME_SPEED = 1e-12


@dataclass(frozen=True)
class Course:
    """Legs of the drive, each of one speed, in units of the lattice.

    lattice : bins of the clock, with the moments of the path's points.
    path : shape (n,), slider at these points (lengths).
    begins, positions : shape (m + 1,), clock and slider at the ends of m legs.
    directions : shape (m,), of the motion, 0 where the slider stands.
    paces : shape (m,), time that passes in one unit of the clock.
    reference : of each bin the slider where the bin ends.
    """

    lattice: Lattice
    path: Array
    begins: Whole
    positions: Whole
    directions: Whole
    paces: Array
    reference: Whole

    @property
    def for_kernel(self) -> tuple[Whole, Whole, Whole, Array]:
        """The part that the kernel needs."""
        return self.begins, self.positions, self.directions, self.paces


def make_course(drive: Drive, scale: float, reach: float, exact: bool) -> Course:
    """The course of a rigid slider's drive; scale, reach and exact as for make_lattice.

    Raises InputError where the path is longer than 2^33 times the scale.
    """
    travel, duration, clock = _legs(drive, scale)
    lattice = make_lattice(clock, 0.0, scale, reach, exact)
    positions = np.rint(np.concatenate([[0.0], np.cumsum(travel)]) / lattice.unit).astype(np.int64)
    moved = np.diff(positions)
    stand = max(round(scale / lattice.unit), 1)
    ticks = np.where(moved != 0, np.abs(moved), stand)
    begins = np.concatenate([[0], np.cumsum(ticks)])
    begins[-1] = max(begins[-1], lattice.end)
    ends = np.minimum(((lattice.bin_cell + 1) << lattice.shift) - 1 - lattice.offset, lattice.end)
    leg = np.clip(np.searchsorted(begins, ends, side="right") - 1, 0, ticks.size - 1)
    directions = np.sign(moved)
    reference = positions[leg] + directions[leg] * (ends - begins[leg])
    return Course(lattice, drive.path, begins, positions, directions, duration / ticks, reference)


def _legs(drive: Drive, stand: float) -> tuple[Array, Array, Array]:
    """Travel (lengths, with their sign) and duration of each leg; and the clock at each point of the path (lengths),
    which takes `stand` for each leg on which the slider stands."""
    step = np.diff(drive.path, prepend=0.0)
    lasts = np.abs(step) / drive.velocity if drive.time is None else np.diff(drive.time, prepend=0.0)
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
    return travel, duration, np.asarray(clock, dtype=float)
