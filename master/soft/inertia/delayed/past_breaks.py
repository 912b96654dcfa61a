"""The breaks so far in time, one delay after which contacts form again."""

from bisect import bisect_right

import numpy as np

from master.soft.inertia.delayed.panel import BREAKS, Panel


class PastBreaks:
    """Breaks per contact since t = 0: on panels, between which no contact breaks, and lumps that break together.

    share : of all contacts, that held at t = 0 or formed together since; formed : that formed one by one
    breaks : up to now, without lumps; broken_together : in lumps
    lumps : (time, share) of those still to form again, in order
    """

    def __init__(self, delay: float, share: float) -> None:
        self.delay, self.share, self.formed = delay, share, 0.0
        self.breaks = self.broken_together = 0.0
        self.lumps = list[tuple[float, float]]()
        self._begins, self._panels, self._jumps = list[float](), list[Panel](), [0.0]

    def add(self, panel: Panel) -> None:
        """Contacts broke on this panel, which follows the last one, and the few of a closed motion in between."""
        self._jumps.append(self._jumps[-1] + float(panel.at(panel.begin, BREAKS)) - self.breaks)
        self._begins.append(panel.begin)
        self._panels.append(panel)
        self.breaks = float(panel.at(panel.end, BREAKS))

    @property
    def next_lump(self) -> float:
        """When the next lump forms again; inf for none."""
        return self.lumps[0][0] + self.delay if self.lumps else np.inf

    def add_lump(self, t: float, share: float) -> None:
        """So many contacts break together."""
        self.lumps.append((t, share))
        self.broken_together += share

    def form_lump(self) -> float:
        """The share of the next lump, which forms again."""
        _, share = self.lumps.pop(0)
        self.share += share
        return share

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

    def birth_rate(self, t: float) -> float:
        """Births per time at a time."""
        broken_at = t - self.delay
        at = bisect_right(self._begins, broken_at) - 1
        if at < 0 or broken_at > self._panels[at].end:
            return 0.0
        return float(self._panels[at].slope(broken_at, BREAKS))

    def next_birth(self, t: float, share: float) -> float:
        """A time after t up to which at most this share of all contacts is born, and about as late as that; inf where
        no more are due."""
        due = self.next_lump
        first, born = max(bisect_right(self._begins, t - self.delay) - 1, 0), self.born(t)
        for panel in self._panels[first:]:
            begins_to_form = panel.begin + self.delay
            if begins_to_form >= due:
                break
            if float(panel.at(panel.end, BREAKS)) - born > share:
                return min(max(begins_to_form, t), due)
        return due
