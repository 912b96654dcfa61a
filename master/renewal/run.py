"""Run: panels of one width, solved one after the other by conservation; Pace: the panels' widths."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.renewal import rule
from master.renewal.kernels import TARGETS, Kernel

Array = npt.NDArray[np.float64]

# The residuals of conservation and force between the nodes, times this, bound the error of a panel:
# they are sampled at a few points, and their largest value is up to twice the largest sample.
MARGIN = 2.0
# Panels of the first run, and of the longest: the panels of a run behind one that fails are wasted.
FIRST, LONGEST = 8, 256
# Panels wider than half a grain are doubled in width after so many that beat the tolerance, and only
# if as many are still to come, since each width needs its own kernel. Narrower ones double at once.
PATIENCE = 32
# Share of the tolerance below which the width is doubled: the error grows as the width to the power
# DEGREE. The larger share holds where contacts break at rates of all sizes, and beside a point that
# no polynomial resolves: behind these, wider panels soon suffice.
WIDEN, WIDEN_SOONER = 0.5**rule.DEGREE, 1e-2
# Width in grains below which a panel counts as beside such a point (a pole of P_c, for example).
BESIDE = 1e-2


class Run(NamedTuple):
    """Solved panels of one width, one after the other.

    breaks : array of shape (panels, DEGREE + 1), breaks since each panel's beginning, at 0 and nodes
    force : array of shape (panels, DEGREE + 1), the force at 0 and the nodes
    wrong : array of shape (panels,), bound on the error of the number of breaks, and of the force
        divided by the longest stretch, on each panel
    """

    breaks: Array
    force: Array
    wrong: Array


def solve_run(kernel: Kernel, known: Array, earlier: list[Array], stretch: float) -> Run:
    """Solve panels of one width by conservation.

    known : array of shape (2, panels, TARGETS.size), number and force without the contributions of
        panels of this width
    earlier : breaks on the panels of this width that directly precede the first
    stretch : the longest |x| of a contact
    """
    number, force = known
    count, same = number.shape[0], len(earlier)
    apart = min(kernel.number.shape[0], same + count)
    size, nodes = rule.DEGREE + 1, slice(1, rule.DEGREE + 1)
    # the farthest panels first, the order in which `panels` holds them
    far = kernel.number[apart - 1 : 0 : -1, nodes].transpose(1, 0, 2)
    far = np.ascontiguousarray(far.reshape(rule.DEGREE, -1))
    panels = np.zeros((apart - 1 + count, size))
    kept = min(same, apart - 1)
    if kept:
        panels[apart - 1 - kept : apart - 1] = earlier[-kept:]
    flat, missing = panels.reshape(-1), 1.0 - number[:, nodes]
    for panel in range(count):
        past = flat[panel * size : (panel + apart - 1) * size]
        panels[panel + apart - 1, 1:] = kernel.solve @ (missing[panel] - far @ past)
    # number and force at all targets of all panels, in one product
    windows = np.lib.stride_tricks.sliding_window_view(panels, (apart, size))
    both = np.concatenate([kernel.number[:apart], kernel.force[:apart]], axis=1)[::-1]
    both = both.transpose(1, 0, 2).reshape(2 * TARGETS.size, -1)
    added = windows.reshape(count, -1) @ both.T
    number, force = number + added[:, : TARGETS.size], force + added[:, TARGETS.size :]
    lost = np.abs(number[:, size:] - 1.0).max(axis=1)
    bent = np.abs(force[:, :size] @ rule.AT_CHECKS.T - force[:, size:]).max(axis=1)
    wrong = np.nan_to_num(MARGIN * (lost + bent / stretch), nan=np.inf)
    return Run(panels[apart - 1 :], force[:, :size], wrong)


def steady(run: Run, widths: Array, tolerance: float, stretch: float) -> bool:
    """Whether rate of breaks and force are constant over all the panels, of any widths."""
    rates = run.breaks @ rule.SLOPES_AT_GAUSS.T / widths[:, None]
    alike = np.ptp(rates) < 0.25 * tolerance * rates.mean()
    return bool(alike and np.ptp(run.force) < 0.25 * tolerance * stretch)


class Pace:
    """Widths of panels from one edge to the next.

    Parameters
    ----------
    width : float
        First guess.
    grain : float
        Width over which breaks have to be resolved; inf in a hold.
    most, narrowest : float
        Largest width; and the width below which no panel is halved.
    tolerance : float
        Largest error of a panel.
    in_time : bool
        Whether their survival depends on time, or takes long to compute (Life.quick is False).

    Attributes
    ----------
    allowed : float
        Largest width of the next panels.
    count : int
        Panels of the next run.
    """

    def __init__(
        self,
        width: float,
        grain: float,
        most: float,
        narrowest: float,
        tolerance: float,
        in_time: bool,
    ) -> None:
        self.allowed, self.count, self.narrowest = width, FIRST, narrowest
        self._grain, self._most, self._tolerance = grain, most, tolerance
        self._in_time, self._smooth = in_time, 0

    def refused(self, width: float, wrong: float) -> None:
        """Narrow the next panels: one of this width has this error, above the tolerance."""
        self.allowed = (0.25 if wrong > 100.0 * self._tolerance else 0.5) * width
        self.count, self._smooth = 1, 0

    def resolved(self, width: float, run: Run, left: int, hurried: bool) -> None:
        """Widen the next panels if all panels of this run are far within the tolerance.

        left : panels of this width that are still to be solved
        hurried : widen whatever their error
        """
        # whether to widen before the error is far below the tolerance
        sooner = self._in_time or width < BESIDE * self._grain
        self.count = min(2 * self.count, LONGEST)
        spare = max(self._tolerance * (WIDEN_SOONER if sooner else WIDEN), 1e-14)
        self._smooth = self._smooth + run.wrong.size if run.wrong.max() < spare else 0
        still = abs(run.breaks[:, -1]).max() < 1e-3 * self._tolerance
        narrow = still or width <= 0.5 * self._grain
        many = self._smooth > PATIENCE and left > PATIENCE
        wider = self._smooth > 0 and width > 0.6 * self.allowed and (narrow or many)
        if hurried or wider:
            self.count = 1 if sooner else max(1, self.count // 2)
            self.allowed = min(2.0 * width, self._most)
            self._smooth = 0
