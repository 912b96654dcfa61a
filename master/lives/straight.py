"""Where survivals of contacts that move straight, at one speed, since their birth have bends."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from master.lives.life import Life
from origins.start import Start

Array = npt.NDArray[np.float64]


def bends_of(life: Life, born: Start, speed: float, marks: Array | None = None) -> Array:
    """Times since birth at which the survival has a bend; sorted, none where the slider rests.

    marks : lengths |x| of the bends; None: all bends of the life, and its reach
    """
    marks = np.append(life.bends, life.reach) if marks is None else marks
    first, last = sorted(np.sign(speed) * np.array(born.span))
    ends = {first, last, *(np.sign(speed) * born.breakpoints)}
    # a contact born at r < 0 comes back to its largest |x| after a way of -2 r
    ways = [mark - end for mark in marks for end in ends]
    ways += [-2.0 * end for end in ends]
    return np.unique([way / abs(speed) for way in ways if way > 0.0 and speed])
