"""A move of the slider in a slip in which broken contacts stay out until it stops."""

from dataclasses import replace

import numpy as np

from master.numerics import polynomials
from master.renewal.edges import Kink
from master.renewal.present import TARGETS, Batch
from master.soft.cold_contacts import ColdContacts
from master.soft.curve import SlipBegin, SteadyForce
from master.soft.moves import STILL, LoadingHistory, Move, SlipEnd
from master.survival.life import NO_SURVIVAL

# Error of a panel below which all is rounding, a share of the contacts: panels are widened there.
ROUNDING = 1e-16
# Most panels that are tried together: the slip may end on the first.
MOST_TOGETHER = 8
# Share of a travel without balance that is passed at once: its end is left out, as F has an error; and how many panels
# long it has to be, as it takes as long as some panels to find F at its end.
PASSED, WORTH_PASSING = 0.9, 2.0


class MoveWithoutBirths(Move):
    """Contacts during a slip in which broken contacts stay out until the slider stops.

    On panels that `_pass_without_balance` passes the force is an upper bound: it is right again from where they end.

    _widest : width of the widest panel that is tried next (a length)
    _together : panels that are tried together, as most of the work is the same for one and for many
    _holding, _force : share of the contacts that hold where the last panel ends, and the force along the motion there
        (a length)
    _end_load : load at which the slip ends (a length)
    """

    def __init__(self, contacts: ColdContacts, direction: int, loaded: LoadingHistory) -> None:
        """Before the first panel."""
        super().__init__(contacts, direction, loaded)
        self._widest, self._together = self._guess, 1
        self._holding, self._force = 1.0, np.inf
        self._end_load = np.inf

    def _steady_force(self) -> SteadyForce | None:
        """The force 0, once no contact holds any more."""
        return SteadyForce(0.0, 0.0) if self._holding <= NO_SURVIVAL else None

    def holds_none(self, y: float) -> bool:
        """Whether no contact holds any more after the travel y: none does behind the last panel."""
        return self._steady is not None and self.travel_of_state(y) < y

    def end_of_slip(
        self, after: float, load: float, begin: SlipBegin, goes_on: bool = False
    ) -> SlipEnd:
        """As of Move; the load is kept for `_pass_without_balance`, which passes at once a way on which it cannot be
        reached."""
        self._end_load = load
        return super().end_of_slip(after, load, begin, goes_on)

    def _pass_without_balance(self) -> bool:
        """Pass a travel on which the load cannot come back to that of the slip: F rises at most with the stiffness of
        the contacts that hold, of which ever fewer do. Its panel holds that bound; False where the travel is short."""
        march, contacts = self.march, self.contacts
        begin = max(march.solved.end, self.loaded.move_begins_at)
        missing = (
            self._end_load - self._force - contacts.spring * (begin - self.loaded.move_begins_at)
        )
        stiffness = self._holding * contacts.largest_stiffness
        travel = PASSED * missing / (stiffness + contacts.spring)
        travel = min(travel, float(march.edges[-1]) - begin)
        if not WORTH_PASSING * self._widest < travel < np.inf:
            return False
        bound = self._force + stiffness * travel * np.append(0.0, polynomials.NODES)[None]
        batch = Batch(np.zeros_like(bound), self.direction * bound, np.zeros(1))
        self._append(begin, travel, batch, 1)
        number, force = march.enter_and_sum_at(np.full((1, TARGETS.size), begin + travel))[:, 0, 0]
        self._holding, self._force = float(number), self.direction * float(force)
        return True

    def _append(self, begin: float, width: float, batch: Batch, count: int) -> None:
        """Keep so many panels of a run, of this width, the first of which begins there."""
        motion = self.march.motion
        leg_begin = float(motion.times[motion.leg(begin + 0.5 * width)])
        breaks_begin_own_leg = begin - leg_begin
        self.march.solved.append(
            batch, count, begin=begin, breaks_begin_own_leg=breaks_begin_own_leg, width=width
        )

    def _advance(self) -> bool:
        """See Move: some panels on which nothing is born, as wide as polynomials allow."""
        if self._pass_without_balance():
            return True
        march, life, tolerance = self.march, self.contacts.life, self.march.tolerance
        begin = max(march.solved.end, self.loaded.move_begins_at)
        later = march.edges[march.edges > begin + STILL * life.resolution_length]
        if not later.size:
            return False
        room, count = float(later[0]) - begin, self._together
        while True:
            width = min(self._widest, room)
            count = min(count, max(int(room / width), 1))
            starts = begin + width * np.arange(count)[:, None]
            sums = march.enter_and_sum_at(starts + width * TARGETS)[..., : polynomials.DEGREE + 1]
            number, force = sums
            error = (
                np.abs(force @ polynomials.TO_LEGENDRE[-2:].T).max(axis=1) / life.largest_stretch
            )
            narrowest = width <= STILL * life.resolution_length
            bad = np.flatnonzero(error > tolerance)
            good = int(bad[0]) if bad.size and not narrowest else count
            if good:
                break
            self._widest, count = 0.5 * width, 1
        self._holding = float(number[good - 1, -1])
        self._force = self.direction * float(force[good - 1, -1])
        # beside a panel that was too wide the next ones are, too; the error grows as the width to the power DEGREE
        if good < count:
            self._widest = 0.5 * width
        elif error.max() <= max(0.5**polynomials.DEGREE * tolerance, ROUNDING):
            self._widest *= 2.0
        self._together = min(2 * self._together, MOST_TOGETHER) if good == count else 1
        self._append(begin, width, Batch(np.zeros_like(force), force, error), good)
        return True

    def holding_after(self, y: float) -> float:
        """The share of the contacts that hold after the travel y."""
        if self.holds_none(y):
            return 0.0
        return float(
            self.march.enter_and_sum_at(np.full((1, TARGETS.size), self.loaded.move_begins_at + y))[
                0, 0, 0
            ]
        )

    def after_slip(self, y: float, error: float) -> LoadingHistory:
        """The history when the slip ends after the travel y, and broken contacts re-form; the error is that after."""
        history = self.stopped(y, error)
        kinks = (*self.loaded.kinks, Kink(history.move_begins_at, 1.0))
        return replace(history, cut_at=self.loaded.move_begins_at, kinks=kinks)
