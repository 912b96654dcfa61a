"""A scene for the promise on force_error, and the random numbers that one is drawn from."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

import master
import origins

Array = npt.NDArray[np.float64]
POINTS = 60  # of a path at most: errors are seen anywhere, and thousands of forces take their time
FAR_SHARE = 1.0 / 3.0  # of the numbers of a far case that come from far corners


@dataclass(frozen=True)
class Scene:
    """Contacts, a drive, the tolerance asked, and the exact force where that is known.

    drive : the keywords of master.solve beside contacts, path and tolerance
    """

    contacts: origins.Contacts
    path: Array
    tolerance: float
    exact: Callable[[Array], Array] | None = None
    drive: dict[str, Any] = field(default_factory=dict)

    def solve(self, tolerance: float | None = None) -> master.Solution:
        """The answer of the tree that runs this."""
        return master.solve(self.contacts, self.path, tolerance or self.tolerance, **self.drive)


class Draw:
    """Numbers for one scene, in lengths of `unit`.

    far : whether a third of the numbers come from far corners, if they have any, and lengths are in
        any unit; for ordinary scenes none does.
    """

    def __init__(self, *key: int, far: bool = False) -> None:
        self.rng = np.random.default_rng(key)
        self._far = FAR_SHARE if far else 0.0
        self.unit = self.log(1.0, 1.0, 1e-9, 1e9)

    def far(self) -> bool:
        """Whether this number comes from far."""
        return self._far > 0.0 and float(self.rng.random()) < self._far

    def even(self, low: float, high: float) -> float:
        """Evenly between low and high."""
        return float(self.rng.uniform(low, high))

    def log(self, low: float, high: float, *corners: float) -> float:
        """Even in the logarithm between low and high, or between two corners if it comes from far."""
        if corners and self.far():
            low, high = corners
        return float(np.exp(self.rng.uniform(np.log(low), np.log(high))))

    def whole(self, low: int, high: int) -> int:
        """A whole number from low to high - 1."""
        return int(self.rng.integers(low, high))

    def path(self, longest: float, mean: float) -> Array:
        """Forward, to between half a mean threshold and the longest; regular or not."""
        end = self.log(0.5, longest, 1e-6, 100.0) * mean
        points = self.whole(2, POINTS)
        if self.rng.random() < 0.5:
            return np.linspace(0.0, end, points)
        return np.sort(self.rng.uniform(0.0, end, points))

    def turns(self, mean: float) -> Array:
        """A path of two to five legs."""
        corners = self.rng.uniform(-2.5, 2.5, self.whole(2, 6)) * mean
        corners *= self.log(0.2, 1.5, 1e-5, 0.2)
        legs = [
            np.linspace(*leg, self.whole(2, 14))[1:] for leg in pairwise([0.0, *corners.tolist()])
        ]
        return np.concatenate([[0.0], *legs])

    def journey(self, mean: float, longest: float = 1e5) -> tuple[Array, Array]:
        """Turns, changes of speed and holds of up to the longest: positions and times."""
        place, clock = [0.0], [0.0]
        for leg in range(self.whole(2, 5)):
            goal, lasts = place[-1], self.log(0.1, longest)
            if leg == 0 or self.rng.random() < 0.7:
                goal = self.even(-1.5, 2.0) * mean
                lasts = abs(goal - place[-1]) / (self.unit * self.log(0.1, 5.0))
            share = np.linspace(0.0, 1.0, self.whole(3, 12))[1:]
            place += (place[-1] + (goal - place[-1]) * share).tolist()
            clock += (clock[-1] + lasts * share).tolist()
        return np.array(place), np.array(clock)

    def tolerance(self, finest: float = 1e-10) -> float:
        """Even in the logarithm, to 1e-3."""
        return self.log(finest, 1e-3)

    def speed(self) -> float:
        """An ordinary one, in lengths of `unit`."""
        return self.unit * self.log(0.3, 3.0)
