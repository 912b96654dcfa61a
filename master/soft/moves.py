"""Moves: contacts on a slider that moves in one direction, solved as far as is needed.

At T = 0 nothing depends on time, so t of the march is the distance that the slider has travelled. Three lengths tell
where the slider is:

    t   how far it has travelled, there and back, since its history began: the clock of the march, of kinks and lumps
    y   its travel on this move, t - `loaded.move_begins_at`: the clock of a LoadCurve
    X   its position since the history began, `loaded.places[-1] + direction * y` (`Move.at`)

A history begins with the path, and anew where a slip leaves all contacts new: X of the path is more by `_base` of
cold.py. An example: a slider goes to X = 1, and back to 0.7, where it slips under "reform-after" to 0.2. Its moves have

    move          direction  .places           .cut_at  .move_begins_at  t at its end
    there            +1      (0,)                0             0              1
    back             -1      (0, 1)              1             1              1.3
    in the slip      -1      (0, 1, 0.7)         1.3           1.3            1.8      without births
    behind it        -1      (0, 1, 0.7, 0.2)    1.3           1.8                     births of the slip all at t = 1.8

The middle columns are of `loaded`, the history before the move.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from master.motion import Motion
from master.numerics import polynomials
from master.outcome import StoppedError
from master.renewal.births import MOST_WORK, Births, panel_at
from master.renewal.edges import SMOOTHER, Kink, edges
from master.renewal.march import March
from master.renewal.panel_width import WIDE
from master.soft.cold_contacts import ColdContacts
from master.soft.curve import LoadCurve, SlipBegin, SteadyForce
from master.soft.decohered import ONE_LIFE, LastLife, Waves
from origins.start import Start
from origins.thresholds.law import Array

# Shortest move, and narrowest panel, in resolution lengths of the life.
STILL = 1e-12
# Way, in mean thresholds, up to which panels are planned first: most sliders slip before.
PLANNED = 2.0
# The end of a slip is looked for from so many errors of its begin on, next to which the load may still rise; at most so
# much of the travel, as slips are longer.
BEHIND_BEGIN, OF_TRAVEL = 10.0, 1e-4
# Work of following a lump over one run of panels, in the unit of `Births.work`: one piece of an integral over births.
WORK_OF_LUMP = 15
# Share of the contacts above which those that break together make a slip: well above rounding. That of the force,
# relative to the distance travelled, and on one panel, in mean thresholds.
DROPS, ROUNDING, OWN_ROUNDING = 1e-13, 1e-14, 1e-15
# Panels of one width that take as long as the waves of F to be found.
FEW_PANELS = 200.0
# Part of a panel's tolerance that sums over births may miss.
OF_SUMS = 0.1


@dataclass(frozen=True)
class LoadingHistory:
    """The history before a straight move of the slider.

    start : stretches at its beginning
    march : None before the first move
    cut_at, move_begins_at : t up to which the march holds, and at which the move begins: in between, in a slip, no
        contact is born
    places : X where the slider began, stopped or turned, and where it is (lengths)
    kinks : times at which breaks jump or bend
    error : of the force, due to errors of this history (a length)
    """

    start: Start
    march: March | None = None
    cut_at: float = 0.0
    move_begins_at: float = 0.0
    places: tuple[float, ...] = (0.0,)
    kinks: tuple[Kink, ...] = ()
    error: float = 0.0


class SlipEnd(NamedTuple):
    """The load along a move, and the travel at which a slip on it ends."""

    curve: LoadCurve
    travel: float


class Move:
    """Contacts while the slider moves in one direction, +1 or -1, and broken contacts re-form.

    contacts, loaded : at T = 0, and their history before this move

    It is solved piece by piece. Edges are planned up to some travel, and panels solved up to there; then twice as far.

    march, _batches : the march of all panels since the history began, and its batches that are still to come
    first : index of the first panel on this move
    _ahead : travel from the end of the panels on, up to which edges are planned
    _kinks : those of the history and of the plan
    _guess : the first guess of a panel's width (a length)
    _steady, _waves : the force, once it no longer changes, or is a sum of waves that fade
    _panels_until_steady : how many more, if rates of breaks fade as they did so far
    _found : the last slip that was found, and the travel after which it is the first: resets repeat one move
    """

    def __init__(self, contacts: ColdContacts, direction: int, loaded: LoadingHistory) -> None:
        self.contacts, self.direction, self.loaded = contacts, direction, loaded
        self._kinks, self._ahead = loaded.kinks, PLANNED * contacts.unit
        self._guess = WIDE * contacts.life.resolution_length
        self._plan(loaded.march, loaded.cut_at, loaded.move_begins_at)
        self.first = self.march.solved.count
        self._steady: SteadyForce | None = None
        self._waves: Waves | None = None
        self._found: tuple[float, SlipBegin] | None = None
        self._panels_until_steady = np.inf

    def at(self, y: Array | float) -> Any:
        """X after the travel y, relative to where the history began (lengths)."""
        return self.loaded.places[-1] + self.direction * y

    def next_slip(self, after: float, target: float) -> SlipBegin:
        """The first slip after a travel, if it begins before the load F + K y (a length) reaches the target."""
        if self._found and self._found[0] == after and self._found[1].load < target:
            return self._found[1]
        travel = after
        while True:
            curve = self.curve_to(travel, after)
            y = curve.slip_begins(after)
            last = min(y, curve.to_travel)
            load = float(curve.force(last)) + curve.spring * last
            if load >= target:
                return SlipBegin(curve, last, np.inf)
            if np.isfinite(y):
                self._found = after, SlipBegin(curve, y, load)
                return self._found[1]
            travel = curve.to_travel + self.contacts.life.resolution_length

    def end_of_slip(
        self, after: float, load: float, begin: SlipBegin, goes_on: bool = False
    ) -> SlipEnd:
        """The curve, and the travel at the end of the slip that begins at the travel `after` with this load; `goes_on`:
        the slider never turns later, so that of contacts that have decohered only the force matters."""
        beside_begin = min(BEHIND_BEGIN * begin.begin_error, OF_TRAVEL * begin.curve.to_travel)
        travel, searched, rises = after, after + beside_begin, np.inf
        while True:
            curve = self.curve_to(travel, after)
            # panels that were searched before are not searched again: a slip may pass thousands
            rises = curve.rises(searched) if np.isinf(rises) else rises
            y = curve.travel_to_load(load, max(rises, searched)) if np.isfinite(rises) else np.inf
            if np.isfinite(y):
                return SlipEnd(curve, y)
            searched = max(searched, curve.to_travel)
            if goes_on and self._steady is None and self._waves is None:
                self._look_ahead(load)
            if self._waves is not None:
                searched = self._waves.skip(load, searched)
            travel = searched + self.contacts.life.resolution_length

    def curve_to(self, y: float, since: float = 0.0) -> LoadCurve:
        """The load along the move from the travel `since` on, solved up to the travel y at least."""
        if self._waves is not None:
            return self._waves.curve_to(y)
        while self.march.solved.count == self.first or (
            self._steady is None and self.march.solved.end < self.loaded.move_begins_at + y
        ):
            self.march.births.work += WORK_OF_LUMP * len(self.march.lumps)
            if self.march.births.work > MOST_WORK:
                raise StoppedError("stopped as the force along the way asks for too much work")
            before = self.march.solved.count
            if not self._advance():
                self._ahead *= 2.0
                end = self.march.solved.end
                self._plan(self.march, end, end, goes_on=True)
            self.contacts.nodes += (self.march.solved.count - before) * polynomials.DEGREE
            self._steady = self._steady_force()
        return self.solved_curve(y, since)

    @property
    def steady(self) -> bool:
        """Whether the force no longer changes, and no more panels are solved."""
        return self._steady is not None or (
            self._waves is not None and self._waves.steady is not None
        )

    @property
    def solved_to(self) -> float:
        """The travel up to which panels are solved, or waves laid out (a length)."""
        if self._waves is not None:
            return self._waves.laid_to
        return self.march.solved.end - self.loaded.move_begins_at

    @property
    def solved(self) -> bool:
        """Whether any panel of the move is solved."""
        return self.march.solved.count > self.first

    def solved_curve(self, y: float = 0.0, since: float = 0.0) -> LoadCurve:
        """The load on the panels solved so far, from that of `since` on; where breaks are steady, up to y at least."""
        if self._waves is not None:
            return self._waves.curve_to(y)
        loaded, march, largest = self.loaded, self.march, self.contacts.life.largest_stretch
        begins, solved = loaded.move_begins_at, march.solved
        first = max(self.first, panel_at(solved.begin, begins + since) - 1)
        most_missed = np.maximum.accumulate(solved.error[self.first :])[first - self.first :]
        solved = solved.pick(slice(first, None))
        begin = solved.begin - begins
        times = [one.birth for one in march.lumps if one.birth > begins and one.weight > DROPS]
        rounding = ROUNDING * (self.contacts.unit + begin) + march.unseen_error * largest
        unknown = loaded.error + self.contacts.unknown
        error = unknown + most_missed * largest + rounding
        drops = np.array(times) - begins
        series = self.direction * solved.force @ polynomials.TO_LEGENDRE.T
        own = solved.error * largest + OWN_ROUNDING * self.contacts.unit
        spring, break_length = self.contacts.spring, self.contacts.break_length
        curve = LoadCurve(begin, solved.width, series, error, own, drops, spring, break_length)
        return curve if self._steady is None else self._steady.extend(curve, y, largest)

    def _steady_force(self) -> SteadyForce | None:
        """The force of steady breaks, once these have been steady for longer than any life.

        Each rate of breaks is a mean of those before, to the longest life (renewal equation), when
        no contact that held at the move's begin is left: where rates agree, so do all that follow.
        F agrees only once all contacts were born at such a rate: of exponential thresholds that break at one rate from
        the begin it rises as 1 - e^-X, and its first values tell nothing of those to come.
        """
        march, largest = self.march, self.contacts.life.largest_stretch
        longest = march.present.straight(float(self.direction)).longest
        memory = max(ONE_LIFE * longest, 2.0 * largest)
        undisturbed = march.solved.end - max(self.loaded.move_begins_at, march.lumps[-1].birth)
        if undisturbed < memory:
            return None
        rates = march.solved.rates_from(march.solved.end - memory)
        differ, agree = float(np.ptp(rates) / rates.mean()), self.contacts.steady_rates
        if not 0.0 <= differ <= agree:
            fade = undisturbed / np.log(1.0 / differ) if 0.0 < differ < 1.0 else np.inf
            self._panels_until_steady = fade * np.log(differ / agree) / march.solved.width[-1]
            return None
        since = panel_at(march.solved.begin, march.solved.end - (memory - longest))
        last, steady = float(march.solved.force[-1, -1]), march.solved.force[since:]
        return SteadyForce(self.direction * last, differ * abs(last) + float(np.ptp(steady)))

    def _look_ahead(self, load: float) -> None:
        """Know the force where it is to the tolerance before it can be at this `load` again, if it is known yet, and
        is not steady sooner."""
        if self._panels_until_steady < FEW_PANELS:
            return
        begin = self.loaded.move_begins_at
        last = LastLife(self.contacts, self.march, begin, self.direction)
        if last.renewed and last.ahead(load) > 0.0:
            first = self.loaded.march is None
            self._waves = Waves.behind(self.contacts, last, load) if first else None
            self._steady = last.steady(load) if self._waves is None else None

    def breaks_per_travel(self, y: float) -> float:
        """The largest rate of breaks on the panel of the travel y (per length)."""
        return float(self.march.solved.rates_from(self.loaded.move_begins_at + y)[0].max())

    def travel_of_state(self, y: float) -> float:
        """A travel after which the contacts are as they are after y: while breaks are steady, that of their begin."""
        changes = self._steady is None and self._waves is None
        return y if changes else min(y, self.march.solved.end - self.loaded.move_begins_at)

    def _advance(self) -> bool:
        """Solve some more panels; False at the end of the plan."""
        nothing = object()
        return next(self._batches, nothing) is not nothing

    def stopped(self, y: float, error: float) -> LoadingHistory:
        """The history after the travel y; `error` is that of the force due to it."""
        y = max(y, STILL * self.contacts.life.resolution_length)
        end, places = self.loaded.move_begins_at + y, (*self.loaded.places, self.at(y))
        kinks = (*(kink for kink in self._kinks if kink.time < end), Kink(end, SMOOTHER))
        return LoadingHistory(self.loaded.start, self.march, end, end, places, kinks, error)

    def _plan(
        self, march: March | None, cut_at: float, continued_from: float, goes_on: bool = False
    ) -> None:
        """Plan edges, and set the march that goes on from the time `continued_from`, its panels up to `cut_at` being
        those of `march`; from there to `continued_from`, in a slip, no contact is born. `goes_on`: on this move."""
        contacts, start = self.contacts, self.loaded.start
        life, travel = contacts.life, continued_from - self.loaded.move_begins_at
        # no finer than the rounding of positions, to which survivals fall within a resolution length
        rounding = np.spacing(continued_from + self._ahead) / life.resolution_length
        tolerance = max(contacts.of_panels, rounding)
        motion = Motion.along(np.array([*self.loaded.places, self.at(travel + self._ahead)]))
        formed = contacts.reforming
        births = Births(life, formed, motion, accuracy=OF_SUMS * tolerance, until=contacts.until)
        if march is None:
            march = March(births, start, np.empty(0), tolerance, self._guess)
        else:
            march = march.cut(cut_at, births, goes_on)
            march.tolerance = tolerance
            if cut_at < continued_from:
                march.postpone_births(cut_at, continued_from)
        plan = edges(births, start, tolerance, continued_from, self._kinks)
        if plan.too_many_jumps:
            raise StoppedError("stopped as exact thresholds break too often to be followed")
        self._kinks, march.edges = tuple(plan.kinks), plan.times
        march.open_end = all(kink.time <= plan.times[-2] for kink in plan.kinks)
        self.march, self._batches = march, march.batches()
