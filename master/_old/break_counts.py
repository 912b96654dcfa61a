"""B(t), the breaks per contact since t = 0, as polynomials on panels in time, and the births a delay later."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from master._old.panels import Panel, radau

Array = npt.NDArray[np.float64]


class Breaks:
    """B(t) and J(t), the births, on the panels done so far, polynomials through their values there; 0 before.

    Without a delay both are counted from each panel's beginning: in a long hold they would grow beyond all precision.
    """

    def __init__(self, delay: float) -> None:
        self._delay = delay
        self._panels: list[Panel] = []
        # at the beginning and the nodes of each panel
        self._breaks: list[Array] = []
        self._births: list[Array] = []
        self._ends = np.empty(0)
        # beginning, duration and, in powers of the place between -1 and 1, dJ/dt of each
        self._rates = np.empty((0, 3))

    def add(self, panel: Panel, breaks: Array) -> None:
        """B at the nodes of the panel that comes next."""
        known, more = self.births(panel)
        self._births.append(np.append(self._last(self._births), known + more @ breaks))
        self._breaks.append(np.append(self._last(self._breaks), breaks))
        self._panels.append(panel)
        self._ends = np.append(self._ends, panel.end)
        row = np.append([panel.begin, panel.duration], radau(panel.count).slope(self._births[-1]) / panel.duration)
        wider = row.size - self._rates.shape[1]
        row, known = np.pad(row, (0, max(-wider, 0))), np.pad(self._rates, ((0, 0), (0, max(wider, 0))))
        self._rates = np.concatenate([known, row[None]])

    def births(self, panel: Panel) -> tuple[Array, Array]:
        """J at the nodes of the panel that comes next, as far as it is known, and what the unknown B there add to it,
        shapes (p,), (p, p)."""
        if not self._delay:
            return np.zeros(panel.count), np.eye(panel.count)
        at = panel.nodes - self._delay
        inside = at > panel.begin
        known, more = np.zeros(panel.count), np.zeros((panel.count, panel.count))
        before = np.flatnonzero((at > 0.0) & ~inside)
        which = np.minimum(np.searchsorted(self._ends, at[before], side="left"), self._ends.size - 1)
        for k in np.unique(which).tolist():
            own, mine = self._panels[k], before[which == k]
            known[mine] = radau(own.count).values((at[mine] - own.begin) / own.duration) @ self._breaks[k]
        if inside.any():
            values = radau(panel.count).values((at[inside] - panel.begin) / panel.duration)
            known[inside], more[inside] = values[:, 0] * self._last(self._breaks), values[:, 1:]
        return known, more

    def rate(self, time: Array) -> Array:
        """dJ/dt at times on the panels done so far."""
        panel = np.minimum(np.searchsorted(self._ends, time, side="left"), self._ends.size - 1)
        begin, duration, *series = self._rates.T
        z = 2.0 * (time - begin[panel]) / duration[panel] - 1.0
        out = series[-1][panel]
        for power in series[-2::-1]:
            out *= z
            out += power[panel]
        return out

    def next_rate(self, panel: Panel, time: Array) -> tuple[Array, Array]:
        """The same at times of the panel that comes next: as far as it is known, and what the unknown B add to it."""
        known, more = self.births(panel)
        slopes = radau(panel.count).slopes((time - panel.begin) / panel.duration) / panel.duration
        return slopes[:, 0] * self._last(self._births) + slopes[:, 1:] @ known, slopes[:, 1:] @ more

    def lacks(self, panel: Panel, breaks: Array) -> float:
        """What the polynomials may lack on the panel that comes next; of contacts that break there many times, once."""
        tail = radau(panel.count).tail
        first = self._last(self._breaks)
        out = tail(np.append(first, breaks))
        if self._delay:
            known, more = self.births(panel)
            out = max(out, tail(np.append(self._last(self._births), known + more @ breaks)))
        return out / max(float(breaks[-1]) - first, 1.0)

    def _last(self, values: list[Array]) -> float:
        return float(values[-1][-1]) if values and self._delay else 0.0
