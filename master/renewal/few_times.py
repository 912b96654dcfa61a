"""Few times: sums over contacts of earlier legs at all TARGETS of a panel, from those at six of them.

Where a survival takes long, sums over births on earlier legs take most of a march's time, and change little over a
panel: a cubic through four of its times gives the others, and two more times measure its error. It is used only where
that is within the accuracy of such sums, and the error is counted with theirs; not in a hold.
"""

import numpy as np

from master.numerics import polynomials
from master.renewal.births import Births
from master.renewal.present import TARGETS
from master.survival.life import MARGIN
from origins.thresholds.law import Array


class FewTimes:
    """Sums at all TARGETS of a panel from those at a few, where births on earlier legs change little over it.

    The cubic through the sums at SUMMED gives those at all TARGETS, and the sums at CHECKED test it; a layer right
    behind a turn would show at the first of these.

    SUMMED : columns of TARGETS through which the cubic goes: at degree 16 these are 0, 6, 11 and 16, the panel's
        beginning, two nodes in between and its end
    CHECKED : two of the check points between the nodes, columns 17 and 19
    ASKED : both, the only columns that are summed
    TO_ALL : matrix from the sums at SUMMED to the cubic at all TARGETS, shape (4, TARGETS.size)
    NARROWER : where it fails, it is tried again on panels of this part of the width only
    """

    SUMMED = (0, 3 * polynomials.DEGREE // 8, 11 * polynomials.DEGREE // 16, polynomials.DEGREE)
    CHECKED = (polynomials.DEGREE + 1, polynomials.DEGREE + 3)
    ASKED: tuple[int, ...] = SUMMED + CHECKED
    TO_ALL = polynomials.Points(2.0 * TARGETS[list(SUMMED)] - 1.0).at(TARGETS)
    NARROWER = 0.5

    def __init__(self, births: Births) -> None:
        """For these births."""
        self._unit, life = births.longest_stretch, births.life
        # the longest travel on a panel at which it is tried (a length)
        never = life.quick or life.has_strands or life.atoms.size
        self._longest = 0.0 if never else np.inf

    def are_tried(self, grid_leg: Array, abs_speed: float) -> bool:
        """Whether the rows of a grid of times may be interpolated."""
        travel = self._travel(grid_leg, abs_speed)
        return grid_leg.shape[1] == TARGETS.size and 0.0 < travel < self._longest

    def interpolated(self, sums: Array) -> tuple[Array, float]:
        """Number and force at all TARGETS from those at the ASKED ones, and the error of the number by that: a smooth
        interpolant hides it from the panels, so that nothing else shows it."""
        at_summed, at_checked = np.split(sums, [len(self.SUMMED)], axis=2)
        both = at_summed @ self.TO_ALL
        # at SUMMED the cubic is exact
        number, force = np.abs(both[..., list(self.CHECKED)] - at_checked).max(axis=(1, 2))
        # between the two it may be MARGIN times as far off
        return both, MARGIN * float(max(number, force / self._unit))

    def take_narrower(self, grid_leg: Array, abs_speed: float) -> None:
        """It failed on the panels of this grid."""
        self._longest = self.NARROWER * self._travel(grid_leg, abs_speed)

    def _travel(self, grid_leg: Array, abs_speed: float) -> float:
        """The slider's travel on a panel."""
        return float(np.ptp(grid_leg[0])) * abs_speed
