"""Panel width: the step-size controller of the march. It proposes widths and learns from the errors of solved panels.

From one edge to the next panels have equal widths as long as they are good. A panel whose error is above the tolerance
ends its batch: the next panels are narrower. Panels whose errors are far below the tolerance make the next ones wider.
"""

from copy import copy
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from master.numerics import polynomials
from master.survival.life import Life
from origins.thresholds.law import Array

# First guess of a panel's width at the tolerance WIDE_AT, in resolution lengths of the life; panels of this width then
# have errors of 3e-12 to 2e-11 with Gaussian thresholds of std/mean 0.02 to 0.2. At other tolerances it goes as errors
# of a polynomial do. Four times as wide costs four times the work with 0.05: the first panels are rejected, and narrow
# ones, which widen at once (`patience`), are rejected again and again.
WIDE, WIDE_AT = 6.0, 1e-8


@dataclass(frozen=True)
class WidthRules:
    """The numbers of the controller; none changes what a panel's error means, only how many panels are tried.

    of_hold : in a hold, part of the time to its first edge that the first panel takes: contacts break by heat at
        rates that no length tells
    first_batch, largest_batch : panels solved together at an edge, and at most. A batch costs one evaluation of earlier
        births; later panels are lost where an early one is bad, so that batches grow by `batch_growth` as they are good
    batch_after_narrowing : panels of the next batch after a bad one: the new width may be too large, too
    batch_after_widening : part of the batch that is left as panels widen, as the new width may be too large; one is
        left where widths change often
    narrowing, far_narrowing : factor on the width after a bad panel, and where its error is `far_off` times the
        tolerance: two halvings of a polynomial of degree 16 reduce it 1e9 times, but behind a root of t only twice
    aim : of the tolerance, the error at which the width aims where two bad widths show by what power of it errors fall
    progress : part of the former error below which a bad error must be for this power to be trusted
    resolved : share of the contacts below which it must be, too: the errors of panels that miss peaks of breaks fall as
        a power that tells nothing, and the width that it asks for was 1e-8 of what these peaks need
    spare_late : part of the tolerance below which errors let panels widen. Twice the width makes the error of a
        polynomial of degree 16 up to 2^16 times as large, so that panels below this part are good afterwards, too
    spare_soon : the same where widths change often: beside a point that is hardly resolved errors grow far more slowly
        than that, and to wait for 2^-16 would keep panels narrow far behind it; one that is too wide is only done again
    rounding : residual of conservation, in contacts, which no width reduces: errors below it let panels widen, too
    patience : good panels of one width before the next are widened: each width needs sums of its own, which costs
        as much as solving some 30 panels. Panels up to `is_narrow` of the first guess wait for none
    widening, far_widening, calm_widening : factor on the width; where errors are `far_below` the spare ones; and where
        hardly any contact breaks
    calm : part of the tolerance below which breaks on a panel are hardly any: polynomials of all widths fit them
    fills : part of the widest width that panels must have to tell whether it may grow; they are narrower where few
        of them fill the time to the edge
    least_quick, least : narrowest width, in that of the first guess: beside a point that no panel resolves halving
        stops there; heat breaks contacts at rates of all sizes, of which the fastest need the narrowest panels
    least_of_time : narrowest width, in the time since the leg began, of which it keeps three digits
    same : relative difference below which two widths are the same but for rounding, as is an edge reached
    """

    of_hold: float = 0.25
    first_batch: int = 16
    largest_batch: int = 256
    batch_growth: int = 2
    batch_after_narrowing: int = 2
    batch_after_widening: float = 0.25
    narrowing: float = 0.5
    far_narrowing: float = 0.25
    far_off: float = 100.0
    aim: float = 0.5
    progress: float = 0.5
    resolved: float = 0.02
    spare_soon: float = 1e-2
    spare_late: float = 0.5**polynomials.DEGREE
    rounding: float = 1e-14
    patience: int = 32
    is_narrow: float = 0.5
    widening: float = 2.0
    far_widening: float = 4.0
    far_below: float = 1e-4
    calm_widening: float = 8.0
    calm: float = 1e-3
    fills: float = 0.6
    least_quick: float = 1e-10
    least: float = 1e-18
    least_of_time: float = 1e-13
    same: float = 1e-9


RULES = WidthRules()


class Proposal(NamedTuple):
    """Panels to solve next: their width, their number, and how many of this width it takes to the edge."""

    width: float
    panels: int
    to_edge: int


class PanelWidth:
    """The widths of a march's panels: `begin` is called at each edge, before the panels up to the next one.

    All widths are times (at T = 0 without delay, as all times of a march, distances).

    widest : largest width of the next panels, kept from edge to edge; `first_widest` before the first; `narrow` and
        `widen` change it
    duration : from edge to edge
    guess, whole_life : width of the first guess, and the largest that is of use. March has both as lengths; here they
        are divided by the speed, and so inf in a hold, where only the time to the edge bounds a width
    tolerance : largest error of a good panel; quick : whether a look-up gives the survival (Life.quick)
    """

    def __init__(
        self, quick: bool, rules: WidthRules = RULES, first_widest: float = np.inf
    ) -> None:
        """Before the first edge; the first panels are no wider than `first_widest`, what a march that this one
        goes on from has found."""
        self.widest, self.rules, self._quick = first_widest, rules, quick
        self._leg = -1  # of the panels so far; -1 before the first
        self._width, self._open_end = 0.0, False

    def after_cut(self, goes_on: bool) -> "PanelWidth":
        """Those of a march that is continued: as these where it `goes_on` from the last panel, else as a new one whose
        first panels are no wider than these."""
        return copy(self) if goes_on else PanelWidth(self._quick, self.rules, self.widest)

    def begin(
        self,
        leg: int,
        duration: float,
        guess: float,
        whole_life: float,
        tolerance: float,
        open_end: bool = False,
    ) -> None:
        """Begin at an edge, with panels as wide as those before it on the same leg, else with those of the first guess,
        as the leg before had another speed. `open_end` : the next edge is no kink, but as far as the march is planned:
        panels need not meet it, and end before it as wide as they are."""
        rules = self.rules
        if leg != self._leg:
            first = guess if guess < np.inf else rules.of_hold * duration
            self.widest = min(first, self.widest) if self._leg < 0 else first
        goes_on = leg == self._leg and self._open_end  # where the plan before ended
        self._leg, self._open_end = leg, open_end
        self.duration, self.tolerance = duration, tolerance
        self._guess, self._whole_life = guess, whole_life
        self._narrowest = min(guess, duration) * (rules.least_quick if self._quick else rules.least)
        self._any = False  # panel up to this edge
        if goes_on:
            return
        self._batch_size = rules.first_batch
        self._good_panels = 0  # in a row, with errors that let panels widen
        self._bad_width = self._bad_error = 0.0  # of the last attempt, 0 if that was good

    def at_edge(self, remaining: float) -> bool:
        """Whether the `remaining` time to the edge is 0 but for rounding, or less than a panel before an open end."""
        if self._open_end and self._any:
            return remaining < self.widest * (1.0 - self.rules.same)
        return remaining <= self.rules.same * min(self.widest, self.duration)

    def propose(self, remaining: float) -> Proposal:
        """Equal panels that fill the `remaining` time to the edge, none wider than the widest, and how many to solve
        now."""
        rules = self.rules
        panels = remaining / self.widest
        to_edge = max(1, int(np.ceil(panels * (1.0 - rules.same))))
        width = remaining / to_edge
        if self._open_end and panels >= 1.0 - rules.same:
            to_edge, width = int(panels * (1.0 + rules.same)), self.widest
        # the same width, to the last bit, finds its sums again
        if abs(width - self._width) > rules.same * self._width:
            self._width = width
        return Proposal(self._width, min(self._batch_size, to_edge), to_edge)

    def too_narrow(self, t: float) -> bool:
        """Whether panels at t, counted from the leg's beginning, are so narrow that halving resolves only rounding."""
        return self._width < max(self._narrowest, self.rules.least_of_time * t)

    def narrow(self, good: int, error: float) -> None:
        """Learn that a batch of panels had `good` ones, and then one with an error above the tolerance."""
        rules, error = self.rules, error / self.tolerance
        factor = rules.far_narrowing if error > rules.far_off else rules.narrowing
        # where B begins as a power of t, the error is a power of the width: two widths give its exponent
        small = error < rules.progress * self._bad_error and error * self.tolerance < rules.resolved
        if not self._any and small:
            power = np.log(self._bad_error / error) / np.log(self._bad_width / self._width)
            factor = min(factor, (rules.aim / error) ** (1.0 / power))
        self._bad_width, self._bad_error = self._width, error
        self.widest = factor * self._width
        self._batch_size, self._good_panels = rules.batch_after_narrowing, 0
        self._any = self._any or good > 0

    def widen(self, proposal: Proposal, errors: Array, broken: float, unresolved: bool) -> None:
        """Learn that all panels of a proposal were kept, with these errors, and at most a share `broken` of the
        contacts broke on each; the next ones are widened if that is of use.

        unresolved : whether they were kept although halving did not make them good. They are then wider in any case:
            behind the point that no panel resolves breaks are smooth, and without allowed work few panels are to come.
        """
        rules, width, largest = self.rules, proposal.width, float(errors.max())
        self._bad_error, self._any = 0.0, True
        few_break = broken < rules.calm * self.tolerance
        is_narrow = width <= rules.is_narrow * self._guess
        # where contacts break at rates of all sizes, and behind a point that no polynomial resolves, wider panels soon
        # suffice
        suffice_soon = few_break or is_narrow or not self._quick
        spare = self.tolerance * (rules.spare_soon if suffice_soon else rules.spare_late)
        spare = max(spare, rules.rounding)
        self._good_panels = self._good_panels + errors.size if largest < spare else 0
        self._batch_size = min(rules.batch_growth * self._batch_size, rules.largest_batch)
        # a new width pays at once where panels are narrow or hardly any contact breaks, else if it serves many panels
        patience = 0 if few_break or is_narrow else rules.patience
        pays = self._good_panels > patience and proposal.to_edge - errors.size >= patience
        if not (unresolved or (pays and width > rules.fills * self.widest)):
            return
        factor = rules.far_widening if largest < rules.far_below * spare else rules.widening
        self.widest = min((rules.calm_widening if few_break else factor) * width, self._whole_life)
        self._batch_size = (
            1 if suffice_soon else max(1, int(rules.batch_after_widening * self._batch_size))
        )
        self._good_panels = 0


def first_width(life: Life, tolerance: float) -> float:
    """First guess of a panel's width, a length; the tolerance is that of the number of breaks on a panel."""
    return (
        WIDE * life.resolution_length * float((tolerance / WIDE_AT) ** (1.0 / polynomials.DEGREE))
    )
