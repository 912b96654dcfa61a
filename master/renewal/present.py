"""Births on the present leg of the path, whose survival depends only on the lag since the birth.

`Straight` (straight.py) gives survival and force over the lag. The contribution of a panel to another one of its
width depends only on their distance, and is computed once.
"""

from copy import copy
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from master.numerics import polynomials
from master.numerics.polynomials import Pieces
from master.renewal.births import BirthPanels, Births, Nodes, still_out
from master.renewal.straight import Straight
from master.survival.life import NO_SURVIVAL
from origins.thresholds.law import Array
from origins.thresholds.numerical import clipped

# Places on a panel at which number and force are evaluated: its beginning, the nodes, and between.
TARGETS: Array = np.concatenate([[0.0], polynomials.NODES, polynomials.CHECKS])
# Pieces of births that are summed together: 0.1 GB.
TOGETHER_PIECES = 100_000
# Smallest accuracy of a table, a fraction of the contacts: a finer one would follow the rounding of a survival. And the
# accuracy of a table in that of the births, so that its error is small in theirs.
FINEST_TABLE, FOR_TABLE = 1e-13, 0.1
# Factor on the largest residual of conservation, and of the force, at the check points: the largest one anywhere on the
# panel is at most twice that (measured).
BETWEEN_CHECKS = 2.0


class PanelSums(NamedTuple):
    """Contributions of a panel's breaks, at 0 and its nodes, to number, then force, on panels of its own width, shape
    (panels apart, 2 * TARGETS.size, DEGREE + 1); and the matrix from 1 - number at the nodes to the breaks there."""

    values: Array
    solve: Array


class Batch(NamedTuple):
    """Solved panels of one width: breaks since a panel's beginning, and force, at 0 and nodes, shape (panels,
    DEGREE + 1); error, shape (panels,): estimate, by residuals, of that of breaks, and of force/longest stretch."""

    breaks: Array
    force: Array
    error: Array

    @classmethod
    def of_one_panel_without_contacts(cls) -> "Batch":
        """One panel on which nothing holds, so that nothing breaks or pulls."""
        nothing = np.zeros((1, polynomials.DEGREE + 1))
        return cls(breaks=nothing, force=nothing, error=np.zeros(1))


class Present:
    """Sums over the births of a leg, at times on the same leg; each leg's table is made when it is first needed.

    error : estimate from above of the error of the survivals so far, the largest of all look-ups
    """

    def __init__(self, births: Births) -> None:
        self._births, self.error = births, births.life.error
        self._cache: dict[tuple[float, float], PanelSums] = {}
        self._table: dict[float, Straight] = {}

    def counted_on(self, births: Births) -> "Present":
        """The same tables and sums, whose later look-ups count as work on these births."""
        other = copy(self)
        other._births = births
        return other

    def straight(self, speed: float) -> Straight:
        """Survival and force of contacts born on a leg of this speed, of either sign; see Straight."""
        if speed not in self._table:
            births, life, motion = self._births, self._births.life, self._births.motion
            most = life.largest_stretch + max(abs(end) for end in births.law.span)
            longest = most / abs(speed) if speed else np.inf
            if not (life.timeless and speed):
                longest = min(longest, float(np.diff(motion.times)[motion.speeds == speed].max()))
            # nor is it coarser than the error of a survival that is looked up, which would be lost else
            finest = self.error if life.pair_work == 1 else np.inf
            accuracy = max(FINEST_TABLE, min(FOR_TABLE * births.accuracy, finest))
            self._table[speed] = Straight(life, births.law, speed, longest, accuracy, births.until)
        return self._table[speed]

    def look_up(self, speed: float, lag: Array) -> Array:
        """Survival and force, shape (2, rows, columns), after lags in rows; see Straight.look_up."""
        found = self.straight(speed).look_up(lag)
        self.error = max(self.error, found.error)
        return found.both

    def panel_sums(self, speed: float, width: float, panels: int) -> PanelSums:
        """Sums for panels at most `panels` apart, or fewer where all births break before."""
        delay, cached = self._births.delay, self._cache.get((speed, width))
        most = int(np.ceil((self.straight(speed).longest + delay) / width)) + 1
        have = cached.values.shape[0] if cached else 0
        if cached and have >= min(panels, most):
            return cached
        # all at once where that is hardly more than asked for; else twice as many as before, so that a leg on which
        # panels come one after the other asks for few enlargements
        panels = most if most <= 2 * panels else max(panels, 2 * have)
        t = (width * (np.arange(panels)[:, None] + TARGETS)).ravel()
        # `nodes.target` is sorted: the parts of one time stand together
        nodes, values = self._integrals(speed, t, np.array([delay, delay + width]))
        parts = values.swapaxes(0, 1) @ polynomials.legendre_values(
            nodes.place
        )  # (parts, 2, degrees)
        first = np.flatnonzero(np.diff(nodes.target, prepend=-1))
        sums = np.zeros((t.size, 2, polynomials.DEGREE + 1))
        sums[nodes.target[first]] = np.add.reduceat(parts, first)
        # from births as a Legendre series to breaks at 0 and the nodes: (2, t.size, DEGREE + 1)
        found = sums.swapaxes(0, 1) @ polynomials.SLOPES
        if delay > 0.0:  # contacts that are out count as well
            found[0] += still_out(t, delay, 0.0, width)
        both = found.reshape(2, panels, TARGETS.size, -1).swapaxes(
            0, 1
        )  # (panels, 2, targets, ...)
        # singular on a panel far wider than a life: the residual then shows that this is not resolved
        solve = np.linalg.pinv(np.nan_to_num(both[0, 0, 1 : polynomials.DEGREE + 1, 1:]))
        self._cache[speed, width] = PanelSums(
            both.reshape(panels, -1, polynomials.DEGREE + 1), solve
        )
        return self._cache[speed, width]

    def sums(self, speed: float, t: Array, born: BirthPanels) -> Array:
        """Number and force, shape (2, n), at times t of births on a leg; both by any one clock, as lags alone count."""
        straight = self.straight(speed)
        pieces, sums = t.size * (born.ends.size + straight.edges.size), []
        some_born = np.abs(born.slopes).sum(axis=1) > NO_SURVIVAL
        for some in np.array_split(t, 1 + pieces // TOGETHER_PIECES):
            # panels whose contacts all hold at a time need no integral for it
            whole = np.full(some.size, born.ends.size - 1)
            if straight.held and some.min() >= born.ends[-1]:
                whole = np.minimum(np.searchsorted(born.ends, some - straight.held), whole)
            nodes, values = self._integrals(speed, some, born.ends, born.ends[whole], some_born)
            parts = (values * born.at(nodes)).sum(axis=2)
            sums.append([np.bincount(nodes.target, part, some.size) for part in parts])
            sums[-1] += straight.all_hold(born, whole, some)
        return np.concatenate(sums, axis=1)

    def _integrals(
        self,
        speed: float,
        t: Array,
        ends: Array,
        until: Array | None = None,
        some_born: npt.NDArray[np.bool_] | None = None,
    ) -> tuple[Nodes, Array]:
        """Nodes of births on panels of a leg, as seen from times t, and survival and force there times
        the weights, shape (2, parts, PANEL_NODES): exact for the polynomials of the table. `until` : for each time, the
        births up to then; `some_born` : the panels on which there are any."""
        straight, end = self.straight(speed), np.minimum(ends[-1] if until is None else until, t)
        end = end[:, None]
        begin = np.minimum(np.maximum(ends[0], t - straight.longest)[:, None], end)
        cuts = np.concatenate([begin, end, t[:, None] - straight.edges], axis=1)
        nodes = Nodes.of(ends, Pieces.between(clipped(cuts, begin, end)))
        if some_born is not None and not some_born.all():
            nodes = nodes.pick(some_born[nodes.panel])
        self._births.work += nodes.target.size
        return nodes, nodes.weight * self.look_up(speed, t[nodes.target, None] - nodes.time)


def solve_batch(
    of_panel: PanelSums, from_others: Array, same_width: Array, stretch: float
) -> Batch:
    """Solve panels of one width: at each node, number of births before + own sums * breaks = 1.

    from_others : shape (2, panels, TARGETS.size), number and force without the contributions of panels of this width
    same_width : breaks on the panels of this width that directly precede the first; stretch : the longest |x|

    Let V[d] be `of_panel.values` at a distance of d panels, y the breaks on a panel, a to c three panels of this width
    before, and d and e those to be solved, which counts at most `before` = 3 panels back. Then

        1 - from_others of d = V[3] y_a + V[2] y_b + V[1] y_c + V[0] y_d
        1 - from_others of e =            V[3] y_b + V[2] y_c + V[1] y_d + V[0] y_e

    at the nodes of d and e: one after the other, y_d first. `panels` holds the rows y_a to y_e.
    """
    count, size, targets = from_others.shape[1], polynomials.DEGREE + 1, TARGETS.size
    # how many panels before a panel count for it, at most: of farther ones none holds, or they are not of this width
    before = min(of_panel.values.shape[0], len(same_width) + count) - 1
    # breaks of those before the first panel, in the order of time, 0 where there are fewer; then of those to be solved
    panels = np.zeros((before + count, size))
    kept = min(len(same_width), before)
    panels[before - kept : before] = same_width[len(same_width) - kept :]
    # V[before] to V[1] side by side, the order in which `panels` holds their breaks: (2 * targets, before * size)
    of_same_width = of_panel.values[before:0:-1].swapaxes(0, 1).reshape(2 * targets, -1)
    # of each panel to be solved, number at all TARGETS, then force: (count, 2 * targets)
    sums = from_others.swapaxes(0, 1).reshape(count, -1)
    for panel in range(count):
        sums[panel] += of_same_width @ panels[panel : panel + before].ravel()
        panels[panel + before, 1:] = of_panel.solve @ (1.0 - sums[panel, 1:size])
    sums += panels[before:] @ of_panel.values[0].T  # what breaks on a panel itself adds to it
    number, force = sums[:, :targets], sums[:, targets:]
    # beyond `size` lie the check points between the nodes: there the number is to be 1, and the force its polynomial
    of_number = np.abs(number[:, size:] - 1.0).max(axis=1)
    of_force = np.abs(force[:, :size] @ polynomials.AT_CHECKS.T - force[:, size:]).max(axis=1)
    # a sum, see ErrorBudget: the residual of conservation is the share of contacts that are miscounted, which bear the
    # longest stretch at most, and the force between the nodes adds its own
    error = np.nan_to_num(BETWEEN_CHECKS * (of_number + of_force / stretch), nan=np.inf)
    return Batch(panels[before:], force[:, :size], error)
