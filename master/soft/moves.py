"""Moves: contacts on a slider that moves in one direction, solved as far as is needed.

At T = 0 nothing depends on time, so t of the march is the distance that the slider has travelled.
"""

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from master.motion import Motion
from master.numerics import polynomials
from master.outcome import StoppedError
from master.renewal.births import MOST_WORK, Births, reforming_law
from master.renewal.edges import SMOOTHER, Kink, edges
from master.renewal.march import March
from master.renewal.panel_width import WIDE
from master.renewal.present import TARGETS, Run
from master.soft.curve import LoadCurve, SlipBegin, SteadyForce
from master.survival.life import NO_SURVIVAL, ColdLife
from origins import Contacts
from origins.start import Start
from origins.thresholds.law import Array

# Shortest move, and narrowest panel, in resolution lengths of the life.
STILL = 1e-12
# Breaks are steady where their rates agree to this share over the longest life; rates of steady breaks differ by up to
# 5e-12, the rounding of slopes (measured on panels of half a mean threshold).
STEADY_RATES = 1e-10


class ColdContacts:
    """Contacts at T = 0 under a spring, with the tolerance and limits of their solution.

    start, formed_again : stretches at t = 0, and at which broken contacts form again
    unit, spring : mean threshold (a length), and K/(N_c <k>)
    tolerance : of the force, in mean thresholds; of_panels : that of the number of breaks on a panel
    until : reading of time.monotonic() at which to stop
    unknown : bound on what laws that are left out change in the force at a given X (a length)
    nodes : instants at which number conservation was solved
    """

    def __init__(self, contacts: Contacts, spring: float, tolerance: float, until: float) -> None:
        self.life, self.unit = ColdLife(contacts), contacts.mean_threshold
        self.start = contacts.start
        self.formed_again = reforming_law(contacts)
        # the beginning of a slip depends on F', and the error of a polynomial's slope is some hundred times that of its
        # values: hence 1e-4 of the tolerance, and of K, at most of 1e-6 mean thresholds; below 1e-13 all is round-off
        self.of_panels = max(
            1e-4 * min(tolerance, 1e-6, spring) * self.unit / self.life.largest_stretch, 1e-13
        )
        # what is left of the changes of F has to be below the tolerance, and its slope below K
        self.steady_rates = max(STEADY_RATES, 1e-2 * min(tolerance, spring))
        self.spring, self.until = spring, until
        self.unknown, self.nodes = 0.0, 0

    def force_of(self, start: Start) -> float:
        """F/(N_c <k>) of contacts with these stretches (a length)."""
        still = np.zeros((1, 3))
        history = Motion.along(np.array([0.0, self.unit])).history(still, still)
        return float(self.life.survival_and_force(start, history).force[0, 0])


@dataclass(frozen=True)
class LoadingHistory:
    """The history before a straight move of the slider.

    start : stretches at its beginning
    march : None before the first move
    cut, end : distance travelled up to which the march holds, and at which the move begins: in
        between no contact is born
    places : X where the slider began, stopped or turned, and where it is (lengths)
    kinks : times at which breaks jump or bend
    error : of the force, due to errors of this history (a length)
    """

    start: Start
    march: March | None = None
    cut: float = 0.0
    end: float = 0.0
    places: tuple[float, ...] = (0.0,)
    kinks: tuple[Kink, ...] = ()
    error: float = 0.0


class SlipEnd(NamedTuple):
    """The load along a move, and the travel at which a slip on it ends."""

    curve: LoadCurve
    travel: float


class Move:
    """Contacts while the slider moves in one direction, +1 or -1, and broken contacts re-form."""

    def __init__(self, contacts: ColdContacts, direction: int, loaded: LoadingHistory) -> None:
        self.contacts, self.direction, self.loaded = contacts, direction, loaded
        # plan 2 mean thresholds ahead first: most sliders slip before
        self._kinks, self._ahead = loaded.kinks, 2.0 * contacts.unit
        self._widest = self._guess
        self._plan(loaded.march, loaded.cut, loaded.end)
        self._first = len(self._march.begin)
        self._steady: SteadyForce | None = None

    def at(self, y: Array | float) -> Any:
        """X after the travel y, relative to where the history began (lengths)."""
        return self.loaded.places[-1] + self.direction * y

    def next_slip(self, after: float, target: float) -> SlipBegin:
        """The first slip after a travel, if it begins before the load reaches the target."""
        travel = after
        while True:
            curve = self.curve_to(travel)
            y = curve.slip_begins(after)
            last = min(y, curve.end)
            load = float(curve.force(last)) + curve.spring * last
            if load >= target:
                return SlipBegin(curve, last, np.inf)
            if np.isfinite(y):
                return SlipBegin(curve, y, load)
            travel = curve.end + self.contacts.life.resolution_length

    def end_of_slip(self, after: float, load: float, begin: SlipBegin) -> SlipEnd:
        """The curve, and the travel at the end of the slip that begins at the travel `after` with this load."""
        # next to the beginning, which is known to `begin_error`, the computed load may still rise: its rise at the end
        # is looked for from ten times as far on, at most 1e-4 of the travel, as slips are longer
        falling, travel = min(10.0 * begin.begin_error, 1e-4 * begin.curve.end), after
        while True:
            curve = self.curve_to(travel)
            y = curve.slip_ends(after, load, falling)
            if np.isfinite(y):
                return SlipEnd(curve, y)
            travel = curve.end + self.contacts.life.resolution_length

    def curve_to(self, y: float) -> LoadCurve:
        """The load along the move, solved up to the travel y at least."""
        while len(self._march.begin) == self._first or (
            self._steady is None and self._march.reached < self.loaded.end + y
        ):
            # following a lump over one run of panels costs as much as 15 pieces of integrals
            self._march.births.work += 15 * len(self._march.lumps)
            if self._march.births.work > MOST_WORK:
                raise StoppedError("stopped as slips ask for too much work")
            before = len(self._march.begin)
            if not self._advance():
                self._ahead *= 2.0
                self._plan(self._march, self._march.reached, self._march.reached)
            self.contacts.nodes += (len(self._march.begin) - before) * polynomials.DEGREE
            self._steady = self._steady_force()
        return self.solved_curve(y)

    @property
    def solved(self) -> bool:
        """Whether any panel of the move is solved."""
        return len(self._march.begin) > self._first

    def solved_curve(self, y: float = 0.0) -> LoadCurve:
        """The load on the panels solved so far; where breaks are steady, up to the travel y at least."""
        loaded, march, largest = self.loaded, self._march, self.contacts.life.largest_stretch
        panels = march.begin, march.width, march.force, march.error
        begin, width, force, missed = (np.array(values[self._first :]) for values in panels)
        begin -= loaded.end
        # a drop by more than this share of the contacts, well above rounding, makes a slip
        times = [one.time for one in march.lumps if one.time > loaded.end and one.weight > 1e-13]
        # round-off of the force grows with the distance travelled
        rounding = 1e-14 * (self.contacts.unit + begin) + march.unseen_error * largest
        unknown = loaded.error + self.contacts.unknown
        error = unknown + np.maximum.accumulate(missed) * largest + rounding
        drops, series = (
            np.array(times) - loaded.end,
            self.direction * force @ polynomials.TO_LEGENDRE.T,
        )
        own = missed * largest + 1e-15 * self.contacts.unit
        curve = LoadCurve(begin, width, series, error, own, drops, self.contacts.spring)
        return curve if self._steady is None else self._steady.extend(curve, y, largest)

    def _steady_force(self) -> SteadyForce | None:
        """The force of steady breaks, once these have been steady for longer than any life.

        Each rate of breaks is a mean of those before, to the longest life (renewal equation), when
        no contact that held at the move's begin is left: where rates agree, so do all that follow.
        """
        march, largest = self._march, self.contacts.life.largest_stretch
        memory = max(1.1 * march.present.straight(float(self.direction)).longest, 2.0 * largest)
        undisturbed = march.reached - max(self.loaded.end, march.lumps[-1].time)
        if undisturbed < memory:
            return None
        first = max(int(np.searchsorted(march.begin, march.reached - memory, "right")) - 1, 0)
        slopes = march.breaks[first:] @ polynomials.SLOPES.T / march.width[first:, None]
        nodes = polynomials.gauss(polynomials.PANEL_NODES).nodes
        rates = slopes @ polynomials.legendre_values(nodes).T
        differ = float(np.ptp(rates) / rates.mean())
        if not 0.0 <= differ <= self.contacts.steady_rates:
            return None
        force = self.direction * float(march.force[-1, -1])
        return SteadyForce(force, differ * abs(force) + float(np.ptp(march.force[first:])))

    def travel_of_state(self, y: float) -> float:
        """A travel after which the contacts are as they are after y: while breaks are steady, that of their begin."""
        return y if self._steady is None else min(y, self._march.reached - self.loaded.end)

    def _advance(self) -> bool:
        """Solve some more panels; False at the end of the plan."""
        return next(self._runs, self) is not self

    def stopped(self, y: float, error: float) -> LoadingHistory:
        """The history after the travel y; `error` is that of the force due to it."""
        y = max(y, STILL * self.contacts.life.resolution_length)
        end, places = self.loaded.end + y, (*self.loaded.places, self.at(y))
        met = tuple(kink for kink in self._kinks if kink.time < end)
        kinks = (*met, Kink(end, SMOOTHER))
        return LoadingHistory(self.loaded.start, self._march, end, end, places, kinks, error)

    @property
    def _guess(self) -> float:
        """The first guess of a panel's width."""
        return WIDE * self.contacts.life.resolution_length

    def _plan(self, march: March | None, cut_at: float, continued_from: float) -> None:
        """Set the march that continues from `continued_from`; from `cut_at` to there no contact is born."""
        contacts, start = self.contacts, self.loaded.start
        life, again, end = contacts.life, contacts.formed_again, continued_from - self.loaded.end
        # no finer than the rounding of positions, to which survivals fall within a resolution length
        rounding = np.spacing(continued_from + self._ahead) / life.resolution_length
        tolerance = max(contacts.of_panels, rounding)
        motion = Motion.along(np.array([*self.loaded.places, self.at(end + self._ahead)]))
        births = Births(life, again, motion, accuracy=0.1 * tolerance, until=contacts.until)
        if march is None:
            march = March(births, start, np.empty(0), tolerance, self._guess, life.largest_stretch)
        else:
            march = march.cut(cut_at, births)
            march.tolerance = tolerance
            if cut_at < continued_from:
                march.postpone_births(cut_at, continued_from)
        plan = edges(births, start, tolerance, continued_from, self._kinks)
        if plan.too_many_jumps:
            raise StoppedError("stopped as exact thresholds break too often to be followed")
        self._kinks, march.edges = tuple(plan.kinks), plan.times
        self._march, self._runs = march, march.runs()


class MoveWithoutBirths(Move):
    """Contacts during a slip in which broken contacts stay out until the slider stops."""

    # share of the contacts that hold where the last panel ends
    _held = 1.0

    def _steady_force(self) -> SteadyForce | None:
        """The force 0, once no contact holds any more."""
        return SteadyForce(0.0, 0.0) if self._held <= NO_SURVIVAL else None

    def holds_none(self, y: float) -> bool:
        """Whether no contact holds any more after the travel y."""
        return self._steady is not None and self.travel_of_state(y) < y

    def _advance(self) -> bool:
        """See Move: one panel, on which nothing is born, as wide as a polynomial allows."""
        march, length, tolerance = (
            self._march,
            self.contacts.life.resolution_length,
            self._march.tolerance,
        )
        begin = max(march.reached, self.loaded.end)
        later = march.edges[march.edges > begin + STILL * length]
        if not later.size:
            return False
        width = min(self._widest, float(later[0]) - begin)
        while True:
            known = march.known_at(begin + width * TARGETS[None])[..., : polynomials.DEGREE + 1]
            force = known[1]
            error = (
                np.abs(force @ polynomials.TO_LEGENDRE[-2:].T).max(axis=1)
                / self.contacts.life.largest_stretch
            )
            if error[0] <= tolerance or width <= STILL * length:
                break
            width = self._widest = 0.5 * width
        self._held = float(known[0, 0, -1])
        # the error grows as the width to the power DEGREE: twice as wide will do
        if error[0] <= max(0.5**polynomials.DEGREE * tolerance, 1e-16):
            self._widest *= 2.0
        leg_begin = float(march.motion.times[march.motion.leg(begin + 0.5 * width)])
        march.keep(begin, width, Run(np.zeros_like(force), force, error), 1, begin - leg_begin)
        return True

    def held(self, y: float) -> float:
        """The share of the contacts that hold after the travel y."""
        if self.holds_none(y):
            return 0.0
        return float(self._march.known_at(np.full((1, TARGETS.size), self.loaded.end + y))[0, 0, 0])

    def after_slip(self, y: float, error: float) -> LoadingHistory:
        """The history when the slip ends after the travel y, and broken contacts re-form; the error is that after."""
        history = self.stopped(y, error)
        kinks = (*self.loaded.kinks, Kink(history.end, 1.0))
        return replace(history, cut=self.loaded.end, kinks=kinks)
