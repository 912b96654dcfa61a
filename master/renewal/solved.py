"""Solved panels: breaks, force and error of a march so far, panel after panel."""

from dataclasses import dataclass, field, fields

import numpy as np

from master.numerics import polynomials
from master.outcome import FaultError
from master.renewal.births import Panels, panel_at
from master.renewal.present import Run
from origins.thresholds.law import Array

# Parts of a panel's width, and of the time, by which rounding may put the next one beside its end: the controller takes
# an edge for reached at some 1e-8 of a width before it.
SAME_PLACE, ROUNDED_TIME = 1e-6, 1e-12


def _none() -> Array:
    return np.empty(0)


def _no_rows() -> Array:
    return np.empty((0, polynomials.DEGREE + 1))


@dataclass
class SolvedPanels:
    """Panels in the order of time, without gaps; arrays with one entry or row a panel.

    begin, begin_leg : the panel's beginning, a time on the path; and counted from that of its leg, to keep all digits
    width : a time
    breaks, force, error : as in Run
    slack : a time by which the last panel may end too early, as one that began hardly before a cut was left out
    """

    begin: Array = field(default_factory=_none)
    begin_leg: Array = field(default_factory=_none)
    width: Array = field(default_factory=_none)
    breaks: Array = field(default_factory=_no_rows)
    force: Array = field(default_factory=_no_rows)
    error: Array = field(default_factory=_none)
    slack: float = field(default=0.0, init=False)

    @property
    def count(self) -> int:
        """How many there are."""
        return int(self.begin.size)

    @property
    def end(self) -> float:
        """The time at which the last one ends; 0 without any."""
        return float(self.begin[-1] + self.width[-1]) if self.count else 0.0

    def append(self, begin: float, begin_leg: float, width: float, run: Run, good: int) -> None:
        """Add the first `good` panels of a run that begins at `begin`, or `begin_leg` on the clock of its leg.

        Raises FaultError where that is not the end of the panels so far: each of them conserves the number by itself,
        and no residual would tell of breaks that are left out in between, or counted twice.
        """
        gap = begin - self.end if self.count else begin
        beside = max(width, float(self.width[-1])) if self.count else width
        if abs(gap) > SAME_PLACE * beside + ROUNDED_TIME * abs(begin) + self.slack:
            raise FaultError(
                f"number is not conserved: panels end at t = {self.end:.9g}, and the next one begins at {begin:.9g}, "
                "a fault of the program"
            )
        steps = width * np.arange(good)
        self.begin = np.append(self.begin, begin + steps)
        self.begin_leg = np.append(self.begin_leg, begin_leg + steps)
        self.width = np.append(self.width, np.full(good, width))
        self.breaks = np.concatenate([self.breaks, run.breaks[:good]])
        self.force = np.concatenate([self.force, run.force[:good]])
        self.error = np.append(self.error, run.error[:good])

    def pick(self, first: int, last: int | None = None) -> Panels:
        """What births need of the panels from one to before another."""
        stored = self.begin, self.begin_leg, self.width, self.breaks
        return Panels(*(part[first:last] for part in stored))

    def rates_from(self, t: float) -> Array:
        """Breaks per time at Gauss nodes of the panels from that on which t lies, shape (panels, nodes)."""
        first = panel_at(self.begin, t)
        slopes = self.breaks[first:] @ polynomials.SLOPES.T / self.width[first:, None]
        nodes = polynomials.gauss(polynomials.PANEL_NODES).nodes
        return np.asarray(slopes @ polynomials.legendre_values(nodes).T)

    def count_alike(self, width: float, earliest: float) -> int:
        """How many of the last panels have this width, to the last bit, and begin at `earliest` or later."""
        first = int(np.searchsorted(self.begin, earliest))
        other = np.flatnonzero(self.width[first:] != width)
        return self.count - first - (int(other[-1]) + 1 if other.size else 0)

    def up_to(self, t: float, rounded: float) -> "SolvedPanels":
        """The panels up to a time, of which the last may be a part; none that begins within `rounded` of it."""
        begun = int(np.searchsorted(self.begin, t - rounded))
        stored = (getattr(self, each.name) for each in fields(self) if each.init)
        other = SolvedPanels(*(part[:begun].copy() for part in stored))
        other.slack = rounded
        if begun and other.end > t:
            width = t - other.begin[-1]
            places = np.append(0.0, polynomials.NODES) * width / other.width[-1]
            to_part = polynomials.values(places)
            other.width[-1] = width
            for values in (other.breaks, other.force):
                values[-1] = to_part @ values[-1]
        return other
