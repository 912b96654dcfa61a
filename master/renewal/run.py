"""Run: panels of one width, solved one after the other by conservation at their nodes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.renewal import rule
from master.renewal.kernels import TARGETS, Kernel

Array = npt.NDArray[np.float64]

# What conservation and force miss between the nodes, times this, bounds the error of a panel: it
# is looked for at a few points, and the largest in between is up to twice as large.
MARGIN = 2.0


class Run(NamedTuple):
    """Panels of one width, one after the other, as solved.

    breaks : array of shape (panels, DEGREE + 1), since each panel's beginning, at 0 and the nodes
    force : the same of the force
    wrong : array of shape (panels,), bound on the error of the number of breaks, and of the force
        over the longest stretch, on each
    """

    breaks: Array
    force: Array
    wrong: Array


def solve_run(kernel: Kernel, known: Array, earlier: list[Array], stretch: float) -> Run:
    """Panels on which number and force are known but for what panels of the same width add.

    known : array of shape (2, panels, TARGETS.size)
    earlier : breaks on panels of the same width, without a gap before the first
    stretch : the longest |x| of a contact
    """
    number, force = known
    count, same = number.shape[0], len(earlier)
    apart = min(kernel.number.shape[0], same + count)
    size, nodes = rule.DEGREE + 1, slice(1, rule.DEGREE + 1)
    # farthest panels first, as they stand
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
    # number and force at all targets, of all panels at once
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
    """Whether all the panels, of any widths, have one rate of breaks and one force."""
    rates = run.breaks @ rule.SLOPES_AT_GAUSS.T / widths[:, None]
    alike = np.ptp(rates) < 0.25 * tolerance * rates.mean()
    return bool(alike and np.ptp(run.force) < 0.25 * tolerance * stretch)
