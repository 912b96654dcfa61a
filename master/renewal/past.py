"""Past: number and force, on the present leg, of all contacts that were not born on it.

They are of three kinds: lumps, the start among them; births on the legs before, where the survival follows
from the slider's displacements alone (earlier_legs.py); and such births of contacts that age, which have to be followed
from leg to leg (strand_births.py). Past adds them up, and forgets legs of whose births hardly any contact holds.

Three clocks meet here, in earlier_legs.py and in lumps.py. The name of a time there, of a motion or of births on
panels ends in its clock (`leg` alone is an index):

- `_path`: since the beginning of the path, the clock of the march: births.motion, SolvedPanels.begin, Lump.time;
- `_leg`: since the beginning of the present leg, to keep digits: here sums are taken;
- `_birth_leg`: since the beginning of the leg on which a contact is born (SolvedPanels.births_begin), as are all
  times of strands of ageing contacts.

Past.enter turns births from the first to the third and then to the second, sums_of_lumps turns lumps from the first to
the second.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from master.numerics.polynomials import Rows
from master.renewal.births import INSIDE, TINY, Births, Lump, Sums
from master.renewal.earlier_legs import EarlierLegs
from master.renewal.few_times import FewTimes
from master.renewal.lumps import sums_of_lumps
from master.renewal.solved import SolvedPanels
from origins.thresholds.law import Array

if TYPE_CHECKING:
    from master.renewal.strand_births import StrandBirths

# Factor on the accuracy where a survival is a sum or followed by strands: so exact a sum over births would take long.
# Where it is closed, as that of growing thresholds without heat, sums so coarse make the number rough, and panels are
# halved until all work is used up.
COARSER = 30.0
# Births on a leg are left out where fewer than this part of the accuracy hold, as many legs may be left out; at least a
# hundredth of the rounding of sums.
LEFT_OUT, LEAST_LEFT_OUT = 1e-3, 1e-18


class Past:
    """All contacts that were not born on the present leg, as that leg sees them.

    leg, first_panel : the present leg, and the first panel whose births are on it
    worst_sum : estimate from above of the error of the number by the sums over births, the largest so far
    left_out : share of all contacts that held when their leg was left out, the sum over all legs so far
    survival_error : the largest error of a survival so far, as the life returned it

    _legs_left_out : earlier legs that are left out for good
    _earlier : births on the other earlier legs; None before there are any, and for contacts that age
    _strands : births on earlier legs of contacts that age
    """

    def __init__(self, births: Births) -> None:
        """Before the first leg: `enter` is called before anything is asked for."""
        self._births = births
        self._motion_leg, self._leg_begins_path = births.motion, 0.0
        closed = births.life.pair_work == 1 and not births.life.has_strands
        self._accuracy = births.accuracy * (1.0 if closed else COARSER)
        self._left_out_below = max(LEFT_OUT * self._accuracy, LEAST_LEFT_OUT)
        self.leg, self.first_panel = -1, 0
        self.left_out = self.worst_sum = 0.0
        self.survival_error = births.life.error
        self._legs_left_out = set[int]()
        self._earlier: EarlierLegs | None = None
        self._strands = list["StrandBirths"]()
        self._few = FewTimes(births.life)

    @property
    def error(self) -> float:
        """Error of the number, a share of the contacts. Sums are taken anew on each panel, so that their errors do not
        add up; contacts that are left out never come back, so that each leg adds its own."""
        return self.worst_sum + self.left_out

    def count_errors_of(self, other: "Past") -> None:
        """Go on from what another past has missed so far."""
        self.survival_error, self.worst_sum = other.survival_error, other.worst_sum
        self.left_out = other.left_out

    def enter(self, leg: int, panels: SolvedPanels) -> None:
        """Begin leg `leg`: births on panels before it are earlier ones; those on panels from `first_panel` on, one
        delay late, fall on it. `panels`: all that are solved.

        Legs are left out of whose births hardly any held when they were last asked for, on the leg before. That may
        have been at any of its times, as a proposal that was rejected asks, too: a survival only falls, so that more of
        them held then than on this leg."""
        births, path, before = self._births, self._births.motion, self.leg
        self.leg, self._leg_begins_path = leg, float(path.times[leg])
        self._motion_leg = path.counted_from(leg)
        middle_path = panels.middle_of_births(births.delay)
        self.first_panel = int(np.searchsorted(middle_path, self._leg_begins_path))
        panels = panels.pick(slice(self.first_panel))
        legs = path.leg(middle_path[: self.first_panel])
        begin_birth_leg = panels.births_begin(path.times[legs], births.delay)
        if births.life.has_strands:
            self._follow_strands(range(max(before, 0), leg), panels, begin_birth_leg, legs)
            return
        if self._earlier is not None:
            for each, held in self._earlier.held.items():
                if held <= self._left_out_below:
                    self._legs_left_out.add(each)
                    self.left_out += abs(held)
        counted = np.array(sorted(set(legs.tolist()) - self._legs_left_out), dtype=int)
        self._earlier = None
        if counted.size:
            born_leg = panels.births(self._motion_leg.times[legs] + begin_birth_leg)
            self._earlier = EarlierLegs(
                births, self._motion_leg, leg, counted, born_leg, self._accuracy
            )

    def at(self, grid_leg: Array, lumps: Sequence[Lump]) -> Array:
        """Number and force of births on the legs before, and of all lumps, shape (2, rows, columns).

        grid_leg : times in rows, each within one panel of the leg
        """
        found = self._from_few_times(grid_leg, lumps) or self._summed(grid_leg, lumps)
        self.worst_sum = max(self.worst_sum, found.error)
        self.survival_error = max(self.survival_error, found.survival_error)
        return found.both

    def _from_few_times(self, grid_leg: Array, lumps: Sequence[Lump]) -> Sums | None:
        """As `_summed`, interpolated between few of the times; None where that is not tried, or not accurate."""
        speed = abs(float(self._motion_leg.speeds[self.leg]))
        if self._earlier is None or not self._few.are_tried(grid_leg, speed):
            return None
        summed = self._summed(grid_leg[:, FewTimes.ASKED], lumps)
        both, interpolation_error = self._few.interpolated(summed.both)
        if interpolation_error > self._accuracy:
            self._few.take_narrower(grid_leg, speed)
            return None
        return Sums(both, summed.error + interpolation_error, summed.survival_error)

    def _summed(self, grid_leg: Array, lumps: Sequence[Lump]) -> Sums:
        """The sums over all three kinds of contacts; errors of strands are counted as these are followed."""
        t_leg = self._beside_jumps(grid_leg).ravel()
        of_lumps = sums_of_lumps(
            self._births, self._motion_leg, lumps, self._leg_begins_path, grid_leg
        )
        both, error, survival_error = np.zeros((2, t_leg.size)), 0.0, of_lumps.survival_error
        for strand in self._strands:
            both += strand.sums(t_leg)
        if self._earlier is not None:
            of_earlier = self._earlier.sums(t_leg)
            both += of_earlier.both
            error = of_earlier.error
            survival_error = max(survival_error, of_earlier.survival_error)
        return Sums(both.reshape(of_lumps.both.shape) + of_lumps.both, error, survival_error)

    def _beside_jumps(self, grid_leg: Array) -> Array:
        """The times of a grid, later than the leg's beginning, which belongs to the leg before. Where the births of a
        hold may meet an exact threshold as a panel ends, all at once, they lie a little inside it."""
        if self._births.life.atoms.size and not self._motion_leg.speeds[: self.leg].all():
            first, last = grid_leg.min(axis=1, keepdims=True), grid_leg.max(axis=1, keepdims=True)
            inside = INSIDE * (last - first)
            grid_leg = np.clip(grid_leg, first + inside, last - inside)
        return np.maximum(grid_leg, TINY)

    def _follow_strands(
        self, new: range, panels: SolvedPanels, begin_birth_leg: Array, legs: Rows
    ) -> None:
        """Make strands of the births on the `new` legs, and follow all strands to the present leg. `begin_birth_leg`:
        when the births of each panel begin; `legs`: on which they are."""
        from master.renewal.strand_births import StrandBirths  # of ageing alone

        for leg in new:
            on_it = legs == leg
            number = float(np.abs(panels.breaks[on_it]).max(axis=1).sum())
            if number > self._left_out_below:
                born_birth_leg = panels.pick(on_it).births(begin_birth_leg[on_it])
                self._strands.append(StrandBirths(self._births, leg, born_birth_leg))
                # single strands are not followed below this survival
                self.left_out += self._left_out_below * self._strands[-1].births
            else:
                self.left_out += number
        followed, self._strands = self._strands, list[StrandBirths]()
        for each in followed:
            if each.seen_from(self._motion_leg, self._left_out_below):
                self._strands.append(each)
            else:
                self.left_out += each.holding
        self.worst_sum = max(self.worst_sum, sum(each.missed for each in self._strands))
        survivals = (each.survival_error for each in self._strands)
        self.survival_error = max(self.survival_error, *survivals, 0.0)
