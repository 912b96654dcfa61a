"""What is left of contacts that have moved straight, at one speed, since their birth: one table."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from master.lives.life import Life
from master.motion.motion import History, Motion
from master.renewal.table import Table
from origins.start import Start

Array = npt.NDArray[np.float64]

# Survival to which the table is refined, in contacts; forces, over the reach, likewise.
ACCURACY = 1e-13
# The narrowest panel of the table, of its length.
SHORTEST = 1e-12


class StraightLife:
    """A Life, tabulated over the time since birth, of contacts born on a leg that goes on.

    Where the slider keeps its speed, what is left depends on the time since birth alone. A table
    of it takes some hundred evaluations, where number conservation asks for many thousand.

    Parameters
    ----------
    life : Life
    born : Start
        The stretches at birth, the only ones that `left` is then asked for.
    speed : float
        dX/dt of the leg.
    longest : float
        The longest time since birth: that of the leg, or from where on none holds.
    """

    def __init__(self, life: Life, born: Start, speed: float, longest: float) -> None:
        self.life, self.reach, self.quiet = life, life.reach, life.quiet
        self.atoms, self.grain, self.quick = life.atoms, life.grain, True
        self.timeless = life.timeless
        moving = bends_of(life, born, speed)
        self.bends: Array = moving[moving < longest]
        self.bend_sizes: Array = np.ones(self.bends.size)
        motion = Motion(np.array([0.0, longest]), np.array([0.0, longest * speed]))
        scale = np.array([1.0, 1.0 / life.reach])[:, None, None]

        def found(lag: Array) -> Array:
            return life.left(born, motion.history(lag, np.zeros((1, 1)))) * scale

        edges = np.concatenate([[0.0], self.bends, [longest]])
        self.table = Table(found, edges, ACCURACY, SHORTEST * longest)
        self.error = life.error + self.table.error

    def marks(self, width: float) -> Array:
        """Times since birth between which the table is smooth enough for panels of a width."""
        return np.union1d(self.bends, self.table.fine(width))

    def atom_share(self, atom: float, stretch: float) -> float:
        """See Life."""
        return self.life.atom_share(atom, stretch)

    def left(self, born: Start | Array, history: History) -> Array:
        """See Life; born is the law that the table was made for, and the history is along `clock`."""
        found = self.table(history.now)
        found[1] *= self.reach
        return found


def bends_of(life: Life, born: Start, speed: float) -> Array:
    """Times since birth at which what is left bends; sorted, none where the slider stands still."""
    first, last = sorted(np.sign(speed) * np.array(born.span))
    ends = {first, last, *(np.sign(speed) * born.breakpoints)}
    # a contact born at r < 0 comes back to its largest |x| after a way of -2 r
    ways = [mark - end for mark in [*life.bends, life.reach] for end in ends]
    ways += [-2.0 * end for end in ends]
    return np.unique([way / abs(speed) for way in ways if way > 0.0 and speed])


def clock(duration: float) -> Motion:
    """The motion along which a StraightLife is read: what is gone is the time since birth."""
    return Motion(np.array([0.0, duration]), np.array([0.0, duration]))
