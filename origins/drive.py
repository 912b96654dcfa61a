"""The drive: the slider's path, checked once for both solvers."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from origins.errors import finite_array, refuse


class Drive:
    """Positions X of a rigid slider that starts at X = 0 and moves forward, straight between the points.

    Parameters
    ----------
    path : array of shape (n,)
        Positions (lengths), n >= 1, none below 0 and none below the one before.

    Raises InputError otherwise.
    """

    def __init__(self, path: npt.ArrayLike) -> None:
        self.path = finite_array("path", path)
        if self.path[0] < 0.0:
            refuse("path[0]", self.path[0], "the slider starts at X = 0 and moves forward; begin at 0 or above")
        back = np.flatnonzero(np.diff(self.path) < 0.0)
        if back.size:
            at = int(back[0]) + 1
            refuse(
                f"path[{at}]",
                self.path[at],
                f"lies behind path[{at - 1}] = {self.path[at - 1]:g}; the path must not turn round",
            )
