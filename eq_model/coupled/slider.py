"""A slider of coupled contacts and the drive that pulls it, as kernels hold them."""

from typing import NamedTuple

import numpy as np

from eq_model.blocks import Whole
from origins.thresholds.law import Array

DRIVE, BASE, X_BEFORE, X_AFTER, F_BEFORE, F_AFTER, BREAKS = range(7)  # in Pull.avalanche

# Positions are whole units; forces and stiffnesses are sums of k_i x_i and k_i in units of <k>. A *load* is
# F + K (X - base), which in balance is K (X_T - base), the load of the drive.
SLIDER = np.dtype(
    [
        ("at", np.int64),  # X at the last event
        # 1, or -1 where it is mirrored, as the drive goes back (turns.py): X, X_T, F and stretches have the other sign
        ("way", np.int64),
        ("base", np.int64),  # the position from which forces count X and X_T
        ("force", np.float64),  # F there
        ("stiffness", np.float64),  # of the contacts that hold
        ("back", np.int64),  # with heat: X at which a window would end if the slider moved back
        ("n_holding", np.int64),  # number of contacts that hold
        ("drive", np.float64),  # K (X_T - base) of the last break that began an avalanche
        ("out", np.int64),  # contacts that broke in this avalanche and have not re-formed
        ("broken", np.int64),  # number of breaks in this avalanche; 0: the slider sticks
        ("breaks", np.int64),  # number of all breaks
        ("point", np.int64),  # index of the next point of the path
        ("returning", np.int64),  # index of the next return of contacts after their delay
        ("returns", np.int64),  # index after the last return
        ("now", np.float64),  # with numbers (ages.py): when the last contacts broke or formed
        ("age", np.float64),  # of contacts as they form: that of the start, later 0
        # with heat (heat.py): the sum of all levels, its integral until the next proposal, and the number of draws
        ("total", np.float64),
        ("budget", np.float64),
        ("draws", np.int64),
    ]
)


class Pull(NamedTuple):
    """The drive and rules for n contacts, and arrays for the results."""

    n: int
    spring: float  # K in <k>
    path: Array  # X_T of the points, up to where the drive turns
    time: Array  # times at which the drive reaches them
    clock: Array  # times between which the drive's speed is constant
    clock_drive: Array  # X_T at these times
    wait: float  # the delay, below 0 if there is none
    slip: int  # fewest breaks of an avalanche that is a slip
    at_once: bool  # whether broken contacts re-form at once
    resets: bool  # whether a slip replaces all contacts
    furthest: int  # X beyond which contacts that re-form stretched take the slider without end
    avalanche: Array  # (7,), the last one; DRIVE: K (X_T - BASE)
    at_points: Array  # (3, points): X, F and the number of contacts that hold
    avalanches: Whole  # numbers of those below a slip that broke 1, 2-3, 4-7, ... contacts
    due: Array  # ring buffer of the times at which contacts re-form
    many: Whole  # how many contacts re-form then
