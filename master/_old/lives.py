"""What single contacts do between birth and break, behind one face, on any motion of the slider.

Contacts do not know of each other: what is left of those born at one moment depends on the motion since and on
nothing else. So a law of single contacts says how much of a cohort is left (`Lives`), and how many are born follows
from number conservation alone (master.marching), which knows no law.
"""

from __future__ import annotations

from typing import Protocol, Self

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


class Lives(Protocol):
    """Cohorts along one motion: number 0 are the contacts that hold at t = 0, then one for every call of `born`.

    Attributes
    ----------
    held : array of shape (n,)
        Fraction of each cohort that still holds.
    pull : array of shape (n,)
        Its force, the sum of k x over those that hold, per contact born and <k> (a length).
    length : float
        Travel over which shares and births change (a length): steps are a part of it.
    time : float
        The shortest time over which they change on a slider that stands still; inf where nothing happens then.
    rate : float
        At which fresh contacts break (per time): what a moving slider's steps resolve as well; 0 where they do not.
    error : float
        What `held` is off by however small the steps.
    fuzzy : bool
        Whether thresholds fluctuate about the stretch, so that none stand right at it: motion in no time then breaks
        none at first.
    skin : float
        Stretch over which their rate changes by a factor e where few of them break by it, else 0 (a length).
    work : int
        Numbers looked at for each cohort in one step: how many steps are affordable.
    """

    length: float
    time: float
    rate: float
    fuzzy: bool
    skin: float
    work: int

    @property
    def error(self) -> float: ...

    @property
    def held(self) -> Array: ...

    @property
    def pull(self) -> Array: ...

    def born(self) -> None:
        """A new cohort, where the slider stands now."""

    def advance(self, travel: float, duration: float, bend: float = 0.0) -> None:
        """All cohorts move on by `travel` (a length of either sign), at constant speed, within `duration`.

        A slip is a travel in no time, a hold is time without travel. The answer may be off by the square of the step.
        bend : how much slower, dt/dX, the slider is at the end than on the mean, as a part of this
        """

    def spread(self) -> tuple[Array, Array]:
        """`held` and `pull` of contacts born evenly between two births that follow each other, shapes (n - 2,), to the
        square of what lies between; `halves` of the two where nothing is known better."""

    def copy(self) -> Self:
        """The same cohorts, to be moved on their own: a trial step that is undone."""


def halves(values: Array) -> Array:
    """Means of neighbours among the births: of `held` or `pull`, the first of which are no birth."""
    return 0.5 * (values[1:-1] + values[2:])
