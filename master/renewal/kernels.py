"""Kernels: births on the present leg, whose survival depends only on the time since the birth.

The contribution of a panel to another one of its width depends only on their distance, and is
computed once.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.renewal import rule
from master.renewal.births import Births, Nodes, Pieces
from master.renewal.straight import Straight

Array = npt.NDArray[np.float64]

# Shares of a panel at which number and force are evaluated: its beginning, the nodes, and between.
TARGETS: Array = np.concatenate([[0.0], rule.NODES, rule.CHECKS])
# Smallest error of the survival, and of the force over its scale, to which a table is refined.
ACCURACY = 1e-13


class Kernel(NamedTuple):
    """Contributions of a panel to number and force on panels of its own width, by distance.

    number, force : arrays of shape (panels apart, targets, DEGREE + 1)
    solve : array of shape (DEGREE, DEGREE), matrix from 1 - number at the nodes to the breaks there
    """

    number: Array
    force: Array
    solve: Array


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


class Kernels:
    """Kernels and sums for the legs of a motion, each table computed when it is first needed."""

    def __init__(self, births: Births) -> None:
        self._births = births
        self._known: dict[tuple[float, float], Kernel] = {}
        self._straight: dict[float, Straight] = {}

    @property
    def error(self) -> float:
        """Largest error of the survivals in the tables."""
        return max((straight.error for straight in self._straight.values()), default=0.0)

    def straight(self, speed: float) -> Straight:
        """Survival and force of contacts born on a leg of this speed."""
        if speed not in self._straight:
            births, life, motion = self._births, self._births.life, self._births.motion
            most = life.reach + max(abs(end) for end in births.law.span)
            longest = most / abs(speed) if speed else np.inf
            if not (life.timeless and speed):
                longest = min(longest, np.diff(motion.times)[motion.speeds == speed].max())
            # the life itself may be as quick as a table
            direct = life.quick and births.law.is_single
            accuracy = max(ACCURACY, 0.0 if life.quick else 0.1 * births.accuracy)
            given = life, births.law, speed, float(longest), 0.0 if direct else accuracy
            self._straight[speed] = Straight(*given)
        return self._straight[speed]

    def on(self, speed: float, width: float, panels: int) -> Kernel:
        """Kernel for panels at most `panels` apart, or fewer where all births break before."""
        delay, known = self._births.delay, self._known.get((speed, width))
        most = int(np.ceil((self.straight(speed).longest + delay) / width)) + 1
        have = known.number.shape[0] if known else 0
        if known and have >= min(panels, most):
            return known
        panels = min(most, max(panels, 2 * have))
        t = (width * (np.arange(panels)[:, None] + TARGETS)).ravel()
        nodes, values = self._integrals(speed, t, np.array([delay, delay + width]))
        first = np.flatnonzero(np.diff(nodes.target, prepend=-1))
        found = np.zeros((2, t.size, rule.DEGREE + 1))
        if first.size:
            basis = rule.legendre_values(nodes.share)
            parts = (values.transpose(1, 0, 2) @ basis).transpose(1, 0, 2)
            found[:, nodes.target[first]] = np.add.reduceat(parts, first, axis=1)
        found = found @ rule.SLOPES
        share = np.clip(np.stack([t, t - delay]) / width, 0.0, 1.0)
        found[0] += rule.values(share[0]) - rule.values(share[1])
        number, force = found.reshape(2, panels, TARGETS.size, -1)
        try:
            solve = np.asarray(np.linalg.inv(number[0, 1 : rule.DEGREE + 1, 1:]), dtype=float)
        except np.linalg.LinAlgError:  # on a panel far wider than a life
            solve = np.full((rule.DEGREE, rule.DEGREE), np.nan)
        self._known[speed, width] = Kernel(number, force, solve)
        return self._known[speed, width]

    def sums(self, speed: float, t: Array, ends: Array, breaks: Array) -> Array:
        """Number and force at times t, shape (n,), of births on a leg of this speed; shape (2, n).

        ends : array of shape (panels + 1,), times at which panels of births end; breaks : on these
        """
        nodes, values = self._integrals(speed, t, ends)
        slopes = (breaks @ rule.SLOPES.T)[nodes.panel]
        parts = (values * rule.legendre_sum(slopes, 2.0 * nodes.share - 1.0)).sum(axis=2)
        return np.stack([np.bincount(nodes.target, part, t.size) for part in parts])

    def _integrals(self, speed: float, t: Array, ends: Array) -> tuple[Nodes, Array]:
        """Nodes of births on panels of a leg, as seen from times t, and share and force there times
        the weights, shape (2, parts, GAUSS): exact for the polynomials of the table."""
        straight, end = self.straight(speed), np.minimum(ends[-1], t)[:, None]
        begin = np.minimum(np.maximum(ends[0], t - straight.longest)[:, None], end)
        cuts = np.concatenate([begin, end, t[:, None] - straight.edges], axis=1)
        nodes = Nodes.of(ends, Pieces.of(np.clip(cuts, begin, end)))
        self._births.work += nodes.target.size
        held = straight.look_up(t[nodes.target, None] - nodes.place)
        return nodes, nodes.weight * held


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
    # sampled at a few points: the largest residual is up to twice the largest sample
    wrong = np.nan_to_num(2.0 * (lost + bent / stretch), nan=np.inf)
    return Run(panels[apart - 1 :], force[:, :size], wrong)
