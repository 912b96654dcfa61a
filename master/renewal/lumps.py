"""Number and force of lumps: the contacts of the start, and sets of contacts that were born at one instant.

The start gives G_0 and M_0. Lumps with one law of stretches are asked for together.
"""

from collections.abc import Sequence

import numpy as np

from master.motion import Motion, middle_of
from master.renewal.births import OFF_PANEL_END, Births, Lump, Sums
from origins.thresholds.law import Array


def sums_of_lumps(
    births: Births,
    motion_leg: Motion,
    lumps: Sequence[Lump],
    leg_start_path: float,
    grid_leg: Array,
) -> Sums:
    """What lumps add to number and force at times; both of shape (2, *grid_leg.shape). Clocks: see past.py.

    motion_leg : that of the births
    leg_start_path : when the present leg begins
    grid_leg : times in rows, each within one panel

    A lump counts on a panel by where its birth lies:

    - after the panel: the contacts are unborn on all of it, that is out, number 1 and force 0;
    - before the panel: E and K, or nothing where none may hold any more at the earliest of all times;
    - amid the panel: out at times before the birth, E and K at those after. Edges lie at the births of large lumps
      only, so that the panel's error shows the kink of a small one.

    Mostly a birth lies on an edge, where rounding tells no side. One that is nearer to a panel's end than OFF_PANEL_END
    of the width is not amid: whether it is before or after is told by the middle of the panel.
    """
    both, survival_error = np.zeros((2, *grid_leg.shape)), 0.0
    earliest, middle = grid_leg.min(keepdims=True), middle_of(grid_leg)[:, 0]
    inside = OFF_PANEL_END * np.ptp(grid_leg, axis=1)
    panel_begin, panel_end = grid_leg.min(axis=1) + inside, grid_leg.max(axis=1) - inside
    for law in dict.fromkeys(lump.law for lump in lumps):
        of_law = [lump for lump in lumps if lump.law is law]
        weight = np.array([lump.weight for lump in of_law])
        # (lumps, 1), against rows (rows,)
        birth_leg = np.array([[lump.birth - leg_start_path] for lump in of_law])
        amid = (panel_begin < birth_leg) & (birth_leg < panel_end)
        unborn = (birth_leg > middle) & ~amid
        both[0] += (weight @ unborn)[:, None]
        may_hold = births.may_hold(law, motion_leg.history(earliest, birth_leg))[:, None]
        # pairs of a lump and a row, shape (pairs,)
        lump, row = np.nonzero((may_hold | (birth_leg >= earliest)) & ~unborn)
        if not row.size:
            continue
        births.add_work(row.size)
        t_leg, its_birth_leg = grid_leg[row], birth_leg[lump]  # (pairs, columns), (pairs, 1)
        history = motion_leg.history(np.maximum(t_leg, its_birth_leg), its_birth_leg)
        found = births.life.survival_and_force(law, history)
        survival_error = max(survival_error, found.error)
        still_unborn = amid[lump, row, None] & (t_leg < its_birth_leg)
        survivors = np.where(still_unborn, [[[1.0]], [[0.0]]], found.both)  # (2, pairs, columns)
        for total, added in zip(both, weight[lump, None] * survivors, strict=True):
            np.add.at(total, row, added)  # several lumps may be on one row, of which += keeps one
    return Sums(both, 0.0, survival_error)
