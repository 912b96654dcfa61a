"""Slips of a soft slider in the order in which they happen, and which of them are main ones."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from origins.brief import brief
from origins.drive import main_drops
from origins.thresholds.law import Array


@dataclass(frozen=True)
class Slips:
    """Slips in the order in which they happen; arrays of shape (n,).

    drive : X_T; before, after : X at the beginning and at the end; lengths.
    force_before, force_after : F/(N_c <k>), lengths.
    drive_error : estimate from above of the error of `drive`, a length. The error of `before` is larger, as F + K X is
        flat where a slip begins.
    """

    drive: Array
    before: Array
    after: Array
    force_before: Array
    force_after: Array
    drive_error: float

    __repr__ = brief

    @property
    def drop(self) -> Array:
        """Drop of the force (lengths), which is K times the slip of X."""
        return self.force_before - self.force_after

    @property
    def main(self) -> NDArray[np.int64]:
        """Indices, in order, of the main ones, see origins.drive.main_drops."""
        return np.flatnonzero(main_drops(self.drop))

    @property
    def period(self) -> float | None:
        """Distance of X_T between the last two main slips (a length); None for fewer of them."""
        last = self.drive[self.main][-2:]
        return abs(float(np.diff(last)[0])) if last.size > 1 else None

    @property
    def period_error(self) -> float:
        """Estimate from above of the error of `period` (a length), and of the distance of any two main slips."""
        return 2.0 * self.drive_error


def slips_of(rows: Array, spring: float, error: float) -> Slips:
    """The slips with these X_T and forces before and after (lengths), shape (3, n), which the spring balances; `error`:
    of X_T (a length)."""
    drive, above, below = rows
    return Slips(drive, drive - above / spring, drive - below / spring, above, below, error)
