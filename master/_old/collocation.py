"""How many contacts are born, on any motion: number conservation, panel by panel, to a high order.

With J(t) the births per contact since t = 0, B(t) the breaks, and E(t, s) what is left of the births at s,

    G_0(t) + integral of E(t, s) dJ(s) + [B(t) - J(t)] = 1,        J(t) = B(t - τ),

the terms being contacts that hold since t = 0, others that hold, and those that wait. On every panel B is a polynomial
for which this is so at the panel's nodes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from master._old.break_counts import Breaks
from master._old.panels import ROUNDED, Panel

if TYPE_CHECKING:
    from master._old.ageing_generations import AgeingGenerations
    from master._old.generations import Generations

Array = npt.NDArray[np.float64]

_DEPTH = 14
_SEEN = 0.02  # part of the most work after which what is ahead is judged
_LIKELY, _SURELY = 2.0, 8.0  # how far beyond the most it is to be, if all panels are as these were, and if they grow


class TooMuch(Exception):
    """More work than time allows."""


class Course:
    """The force and what holds at the panels' beginnings and nodes, lists of arrays (p + 1,).

    Panels on which B is not known to `accuracy` are cut up. Raises TooMuch where `work`, what was looked at, gets
    beyond `most`, or is going to: later panels ask no fewer contacts. `lacks` is the most that B lacks on a panel;
    `lives` and `breaks` are the contacts and their number of breaks at the end.
    """

    def __init__(
        self,
        lives: Generations | AgeingGenerations,
        panels: list[Panel],
        delay: float,
        accuracy: float,
        most: float = np.inf,
    ) -> None:
        self.panels: list[Panel] = []
        self.lives, self.breaks = lives, Breaks(delay)
        self.lacks = 0.0
        self.force: list[Array] = []
        self.holding: list[Array] = []
        last, before = lives.start, 0.0
        shortest = ROUNDED * panels[-1].end
        for done, whole in enumerate(panels):
            if lives.work > _SEEN * most:
                # as each panel asks all contacts born before; where many break for good, as the last ones do
                ahead = len(panels) / max(done, 1)
                alike = min(lives.work + (lives.work - before) * (len(panels) - done), lives.work * ahead)
                if alike > _LIKELY * most or lives.work * ahead**2 > _SURELY * most:
                    raise TooMuch
            before = lives.work
            left = [(whole, 0)]
            while left:
                panel, depth = left.pop()
                found, force, holding = self._solve(panel)
                if lives.work > most:
                    raise TooMuch
                lacks = 0.0 if panel.count == 1 else self.breaks.lacks(panel, found)
                if lacks > accuracy and depth < _DEPTH and panel.duration > shortest:
                    left += [(part, depth + 1) for part in reversed(panel.parts())]
                    continue
                self.lacks = max(self.lacks, lacks)
                self.breaks.add(panel, found)
                lives.finish(panel, self.breaks)
                self.panels.append(panel)
                self.force.append(np.append(last[1], force))
                self.holding.append(np.append(last[0], holding))
                last = holding[-1], force[-1]
        self.work = lives.work

    def _solve(self, panel: Panel) -> tuple[Array, Array, Array]:
        """B, force and holding at the nodes."""
        lives, breaks = self.lives, self.breaks
        held, pull = lives.known(panel, breaks)
        births, values = breaks.births(panel)
        young = lives.young(panel)
        slope, slopes = breaks.next_rate(panel, young.time)
        held += np.add.reduceat(young.held * slope, young.firsts)
        pull += np.add.reduceat(young.pull * slope, young.firsts)
        system = np.add.reduceat(young.held[:, None] * slopes, young.firsts)
        more = np.add.reduceat(young.pull[:, None] * slopes, young.firsts)
        found = np.asarray(np.linalg.solve(np.eye(panel.count) - values + system, 1.0 - held + births), dtype=float)
        return found, pull + more @ found, held + system @ found
