"""Cohorts: what is left of contacts that were born together, all along one motion of the slider.

Contacts do not know of each other: what is left of those born at one moment depends on the motion
since and on nothing else. How many are born follows from number conservation alone
(master.soft.in_time.carried), which knows no law of contacts.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol, Self

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


class Steps(NamedTuple):
    """What the steps of a slider have to resolve.

    length : travel over which shares and births change (a length)
    time : the shortest time over which they change on a slider that stands still; inf where nothing
        happens then
    rate : at which fresh contacts break (per time), 0 where steps need not resolve it
    fuzzy : whether thresholds fluctuate, so that none stand right at a stretch: motion in no time
        then breaks none at first
    skin : stretch over which the rate of breaking changes by a factor e where few break by it, or 0
    """

    length: float
    time: float = np.inf
    rate: float = 0.0
    fuzzy: bool = False
    skin: float = 0.0


class Spread(NamedTuple):
    """Of contacts born evenly between two births that follow each other, arrays of shape (n - 1,).

    held : share that holds; pull : force per contact born and <k> (lengths)
    """

    held: Array
    pull: Array


class Cohorts(Protocol):
    """Number 0 are the contacts that hold at t = 0, then comes one for every call of `born`.

    Nothing is changed in place: every method leaves the cohorts as they are and returns others.

    Attributes
    ----------
    held : array of shape (n,)
        Share of each cohort that still holds.
    pull : array of shape (n,)
        Its force, the sum of k x over those that hold, per contact born and <k> (a length).
    steps : Steps
    error : float
        What `held` is off by, however small the steps.
    work : int
        Numbers looked at for each cohort in one step: how many steps are affordable.
    """

    @property
    def steps(self) -> Steps: ...

    @property
    def work(self) -> int: ...

    @property
    def held(self) -> Array: ...

    @property
    def pull(self) -> Array: ...

    @property
    def error(self) -> float: ...

    def born(self, speed: float) -> Self:
        """With a new cohort, where the slider stands now, which moves at this speed |dX/dt|."""
        ...

    def advance(self, travel: float, duration: float) -> Self:
        """After a move by `travel` (a length of either sign) within `duration`, at one speed.

        A slip is a travel in no time, a hold is time without travel. Errors may be of second order
        in the step.
        """
        ...

    def spread(self) -> Spread:
        """Of the births between neighbours, to second order in what lies between."""
        ...


def halves(values: Array) -> Array:
    """Means of neighbours among the births: of `held` or `pull`, the first of which are no birth."""
    return 0.5 * (values[1:-1] + values[2:])
