"""The breaks so far in time, one delay after which contacts form again."""

from bisect import bisect_right
from functools import partial
from typing import Any

import numpy as np
from scipy.optimize import brentq

from master.soft.inertia.delayed.panel import BREAKS, TimePanel
from origins.thresholds.law import Array

# Multiples of the delay after a kink of the breaks at which births have a visible one: each is smoother by one order.
ECHOES = 3
# Rounding of times, relative: that of some sums of them.
EPSILON = 1e-13


class PastBreaks:
    """Breaks per contact since t = 0: on panels, between which no contact breaks, and lumps that break together.

    formed_together : share of all contacts that held at t = 0, or formed in lumps since
    formed : share that formed one by one, on panels or at the end of a closed motion
    broken_together : share that broke in lumps
    breaks : share that broke one by one, on panels and the few in closed motions
    lumps : (time, share) of those still to form again, in order

    A contact that forms or breaks twice counts twice. At each instant, as no contact is lost,

        holding = formed_together + formed - broken_together - breaks.

    Collocation finds the breaks on a panel from that, with the share that holds by the survivals of its contacts.

    The few that break in a closed motion break at no time that is known: they count as broken where the next panel
    begins, and are born one delay after that, at once. So `born` jumps there, and `born_on_panels`, which is without
    them, does not.

    An example, with a delay 30: 0.6 break on a panel that ends at t = 10; 0.05 in the closed motion from there to
    t = 20, and 0.1 on the panel from 20 to 21; a lump of 0.2 at t = 25. Each forms again 30 later:

        t                 10     20     21     25     40     50     51     55
        breaks            0.6    0.65   0.75   0.75   0.75   0.75   0.75   0.75
        broken_together   0      0      0      0.2    0.2    0.2    0.2    0.2
        formed, born(t)   0      0      0      0      0.6    0.65   0.75   0.75
        formed_together   1      1      1      1      1      1      1      1.2
        holding           0.4    0.35   0.25   0.05   0.65   0.7    0.8    1
        born_on_panels    0      0      0      0      0.6    0.6    0.7    0.7
    """

    def __init__(self, delay: float, holding: float) -> None:
        """Before any breaks, with this share that holds."""
        self.delay, self.formed_together, self.formed = delay, holding, 0.0
        self.breaks = self.broken_together = 0.0
        self.lumps = list[tuple[float, float]]()
        # panels with breaks, when they begin, and before each the sum of the few breaks in closed motions so far
        self._begins, self._panels, self._jumps = list[float](), list[TimePanel](), [0.0]
        self._kinks = list[float]()

    def holding(self, formed: Array | float, breaks: Array | float) -> Any:
        """The share that holds as lumps are now, with so many formed and broken one by one."""
        return self.formed_together + formed - self.broken_together - breaks

    def kink(self, t: float) -> None:
        """The rate of breaks has a kink at t, and that of births one delay later, a smoother one after two."""
        self._kinks += [t + k * self.delay for k in range(1, ECHOES + 1)]

    def next_kink(self, t: float) -> float:
        """When the births have their next kink, later than t but for rounding; inf for none."""
        self._kinks = [kink for kink in self._kinks if kink > t * (1.0 + EPSILON)]
        return min(self._kinks, default=np.inf)

    def add(self, panel: TimePanel) -> None:
        """Contacts broke on this panel, which follows the last one, and the few of a closed motion in between."""
        self._jumps.append(self._jumps[-1] + float(panel.at(panel.begin, BREAKS)) - self.breaks)
        self._begins.append(panel.begin)
        self._panels.append(panel)
        self.breaks = float(panel.at(panel.end, BREAKS))

    @property
    def next_lump(self) -> float:
        """When the next lump forms again; inf for none."""
        return self.lumps[0][0] + self.delay if self.lumps else np.inf

    def add_lump(self, t: float, fraction: float) -> None:
        """So many contacts break together."""
        self.lumps.append((t, fraction))
        self.broken_together += fraction

    def form_lump(self) -> float:
        """The share of the next lump, which forms again."""
        _, fraction = self.lumps.pop(0)
        self.formed_together += fraction
        return fraction

    @property
    def breaks_on_panels(self) -> float:
        """Breaks up to now without the few that broke in closed motions."""
        return self.breaks - self._jumps[-1]

    def born(self, t: float) -> float:
        """Births up to a time, without those of lumps; the breaks one delay before are known."""
        broken_at = t - self.delay
        at = bisect_right(self._begins, broken_at) - 1
        if at < 0:
            return 0.0
        panel = self._panels[at]
        return float(panel.at(min(broken_at, panel.end), BREAKS))

    def born_on_panels(self, t: float) -> float:
        """The same without the few that broke in closed motions."""
        return self.born(t) - self._jumps[bisect_right(self._begins, t - self.delay)]

    def next_birth(self, t: float, fraction: float) -> float:
        """A time after t up to which at most this share of all contacts is born, and about as late as that; inf where
        no more are due."""
        due = self.next_lump
        first, born = max(bisect_right(self._begins, t - self.delay) - 1, 0), self.born(t)
        for panel in self._panels[first:]:
            begins_to_form = panel.begin + self.delay
            if begins_to_form >= due:
                break
            if float(panel.at(panel.end, BREAKS)) - born > fraction:
                return min(max(begins_to_form, t), due)
        return due

    def when_born(self, t: float, fraction: float) -> float:
        """The time after t at which this share of all contacts more is born than then; inf where no more are due."""
        wanted = self.born(t) + fraction
        first = max(bisect_right(self._begins, t - self.delay) - 1, 0)
        for panel in self._panels[first:]:
            begin = max(panel.begin, t - self.delay)
            if float(panel.at(panel.end, BREAKS)) >= wanted:
                if float(panel.at(begin, BREAKS)) >= wanted:  # the few of a closed motion
                    return self.delay + begin
                lack = partial(_lack, panel, wanted)
                return self.delay + float(brentq(lack, begin, panel.end))
        return np.inf


def _lack(panel: TimePanel, wanted: float, t: float) -> float:
    """Breaks at a time of the panel less those wanted."""
    return float(panel.at(t, BREAKS)) - wanted
