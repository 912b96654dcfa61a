"""The force along the drive as it is drawn: at the points of a path, and before and after each slip."""

from types import SimpleNamespace
from typing import Any

import numpy as np

from origins.thresholds.law import Array


def with_slips(solved: Any, velocity: float) -> tuple[Array, Array]:
    """Drive and force at the path's points, and before and after each slip, so that no slip is drawn aslant; during
    that of a mass, which takes time, the drive goes on at this `velocity`, perhaps past points of the path."""
    slips = solved.slips
    lasting = getattr(slips, "duration", None)
    ends = slips.drive if lasting is None else slips.drive + velocity * lasting
    drive = np.concatenate([solved.path, slips.drive, ends])
    force = np.concatenate([solved.force, slips.force_before, slips.force_after])
    # at one place of the drive: the points before the slip, its begin, its end
    rank = np.repeat([0, 1, 2], [solved.path.size, slips.drive.size, slips.drive.size])
    order = np.lexsort((rank, drive))
    return drive[order], force[order]


def trace_of(found: Any, replica: int, velocity: float) -> tuple[Array, Array]:
    """Drive, which moves at this `velocity`, and force of one slider of an ensemble, as a mean over several has no
    drops."""
    slips, own = found.slips, found.slips.replica == replica
    names = ("drive", "force_before", "force_after", "duration")
    each = {name: getattr(slips, name, None) for name in names}
    one = SimpleNamespace(**{name: None if of is None else of[own] for name, of in each.items()})
    pulled = SimpleNamespace(path=found.path, force=found.forces[replica], slips=one)
    return with_slips(pulled, velocity)
