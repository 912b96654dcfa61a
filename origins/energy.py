"""Energies of a slider with mass, by parts: what both solvers tell, and the balance that they must keep."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from origins.brief import brief

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Energy:
    """Energies per N_c<k> (lengths squared) at the path's points, arrays of shape (n,); of an ensemble those of each
    replica, shape (replicas, n).

        drive + start = spring + contacts + kinetic + damped + released

    drive : its work since t = 0. spring, contacts, kinetic : stored in the spring, in the contacts that hold and in the
    slider's motion. damped, released : taken since t = 0 by the slider's damping, and by contacts as they break.
    start : stored at t = 0 by spring and contacts, a float; of an ensemble shape (replicas,).
    """

    drive: Array
    spring: Array
    contacts: Array
    kinetic: Array
    damped: Array
    released: Array
    start: Array | float = np.nan

    __repr__ = brief

    @property
    def work(self) -> Array:
        """Of the drive over the whole path; as start."""
        return np.asarray(self.drive[..., -1])

    @property
    def missing(self) -> Array:
        """What is missing of the work at each point (lengths squared), as drive."""
        there = self.spring + self.contacts + self.kinetic + self.damped + self.released
        return self.drive + np.asarray(self.start)[..., None] - there

    @property
    def imbalance(self) -> Array:
        """The same as a share of the work, or of the largest part of the energy where that is more; as drive."""
        parts = np.stack([self.spring, self.contacts, self.kinetic, self.damped, self.released])
        whole = np.maximum(np.abs(self.drive), np.abs(parts).max(axis=0))
        return np.divide(self.missing, whole, out=np.zeros_like(whole), where=whole > 0.0)
