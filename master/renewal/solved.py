"""Solved panels: breaks, force and error of a march so far, panel after panel."""

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from master.numerics import polynomials
from master.outcome import FaultError
from master.renewal.births import BirthPanels, panel_at, still_out
from master.renewal.present import Batch
from origins.thresholds.law import Array

# Parts of a panel's width, and of the time, by which rounding may put the next one beside its end: the controller takes
# an edge for reached at some 1e-8 of a width before it.
SAME_PLACE, ROUNDED_TIME = 1e-6, 1e-12
# Part of the time on the path by which rounding, and edges that are taken as one (edges.py), may put births beside the
# end of their leg.
BESIDE_LEG = 1e-11


def _none() -> Array:
    return np.empty(0)


def _no_rows() -> Array:
    return np.empty((0, polynomials.DEGREE + 1))


@dataclass
class SolvedPanels:
    """Panels in the order of time, without gaps; arrays with one entry or row a panel.

    begin, breaks_begin_own_leg : the panel's beginning, a time on the path; and counted from that of its leg, on which
        its breaks are, to keep all digits
    width : a time
    breaks : since the panel's beginning, a share of the contacts, at the place 0 and the nodes
    force, error : as in Batch
    slack : a time by which the last panel may end too early, as one that began hardly before a cut was left out
    """

    begin: Array = field(default_factory=_none)
    breaks_begin_own_leg: Array = field(default_factory=_none)
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

    def append(
        self, batch: Batch, good: int, *, begin: float, breaks_begin_own_leg: float, width: float
    ) -> None:
        """Add the first `good` panels of a batch that begins at `begin` on the clock of the path, which is
        `breaks_begin_own_leg` on that of its leg; on the first leg both are the same. Their names are asked for, as no
        type tells them apart.

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
        self.breaks_begin_own_leg = np.append(
            self.breaks_begin_own_leg, breaks_begin_own_leg + steps
        )
        self.width = np.append(self.width, np.full(good, width))
        self.breaks = np.concatenate([self.breaks, batch.breaks[:good]])
        self.force = np.concatenate([self.force, batch.force[:good]])
        self.error = np.append(self.error, batch.error[:good])

    def _stored(self) -> list[Array]:
        return [
            self.begin,
            self.breaks_begin_own_leg,
            self.width,
            self.breaks,
            self.force,
            self.error,
        ]

    def pick(self, which: slice | npt.NDArray[np.bool_]) -> "SolvedPanels":
        """Some of the panels."""
        return SolvedPanels(*(part[which] for part in self._stored()))

    def middle_of_births(self, delay: float) -> Array:
        """Times on the path in the middle of the births, one delay after the breaks."""
        return self.begin + 0.5 * self.width + delay

    def births_begin(self, leg_begins: Array | float, delay: float) -> Array:
        """When their births begin, one delay after the breaks, counted from the beginning of the leg on which the
        births are. `leg_begins`: that, a time on the path; one for all panels, or an array with that of each.

        The begin of the breaks on that clock is the stored one, with all digits, where they are on the same leg; else a
        difference of times on the path, below 0. The delay is added to both. FaultError where births come before their
        leg: their contacts would count as born where the slider is on it.
        """
        broken_on_same_leg = self.begin >= leg_begins
        breaks_begin = np.where(
            broken_on_same_leg, self.breaks_begin_own_leg, self.begin - leg_begins
        )
        births_begin = breaks_begin + delay
        early = np.flatnonzero(births_begin < -self.beside_leg)
        if early.size:
            panel = early[0]
            raise FaultError(
                f"births are on a wrong leg: on the panel that begins at t = {self.begin[panel]:.9g} of the path they "
                f"begin at {births_begin[panel]:.9g} on the clock of their leg, a fault of the program"
            )
        return births_begin

    @property
    def beside_leg(self) -> float:
        """Time by which rounding may put births beside the end of their leg."""
        return SAME_PLACE * float(self.width.max(initial=0.0)) + BESIDE_LEG * self.end

    def births(self, begin: Array) -> BirthPanels:
        """Their births, which begin at these times, on any one clock: that of what is returned. FaultError where those
        of a panel begin before those of the panel before it, by more than rounding: on panels out of order no births
        are found."""
        ends = np.append(begin, begin[-1:] + self.width[-1:])
        rounding = SAME_PLACE * self.width + ROUNDED_TIME * np.abs(begin)
        backward = np.flatnonzero(np.diff(ends) < -rounding)
        if backward.size:
            panel = backward[0]
            raise FaultError(
                f"births are out of order: on the panel that begins at t = {self.begin[panel]:.9g} of the path they "
                f"begin at {begin[panel]:.9g} on the clock asked for, and end at {ends[panel + 1]:.9g}, a fault of "
                "the program"
            )
        return BirthPanels(ends, self.breaks @ polynomials.SLOPES.T)

    def still_out(self, t: Array, delay: float) -> Array:
        """Number of contacts that broke on these panels and are still out at times t of the path, shape (n,)."""
        of_breaks = still_out(t, delay, self.begin[:, None], self.width[:, None])
        return np.asarray(np.einsum("ptn,pn->t", of_breaks, self.breaks))

    def rates_from(self, t: float) -> Array:
        """Breaks per time at Gauss nodes of the panels from that on which t lies, shape (panels, nodes)."""
        first = panel_at(self.begin, t)
        slopes = self.breaks[first:] @ polynomials.SLOPES.T / self.width[first:, None]
        nodes = polynomials.gauss(polynomials.PANEL_NODES).nodes
        return np.asarray(slopes @ polynomials.legendre_values(nodes).T)

    def count_same_width(self, width: float, earliest: float) -> int:
        """How many of the last panels have this width, to the last bit, and begin at `earliest` or later."""
        first = int(np.searchsorted(self.begin, earliest))
        other = np.flatnonzero(self.width[first:] != width)
        return self.count - first - (int(other[-1]) + 1 if other.size else 0)

    def up_to(self, t: float, rounded: float) -> "SolvedPanels":
        """The panels up to a time, of which the last may be a part; none that begins within `rounded` of it."""
        begun = int(np.searchsorted(self.begin, t - rounded))
        other = SolvedPanels(*(part[:begun].copy() for part in self._stored()))
        other.slack = rounded
        if begun and other.end > t:
            width = t - other.begin[-1]
            places = np.append(0.0, polynomials.NODES) * width / other.width[-1]
            to_part = polynomials.values(places)
            other.width[-1] = width
            for values in (other.breaks, other.force):
                values[-1] = to_part @ values[-1]
        return other
