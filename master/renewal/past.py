"""Past: number and force, on the present leg, of all contacts that were not born on it.

They are of two kinds: lumps, the start among them (lumps.py); and births on the legs before. Of these the survival
follows from the slider's displacements (earlier_legs.py), or, where contacts age, they have to be followed from leg to
leg (strand_births.py). Past adds both up, and forgets legs of whose births hardly any contact holds.

Three clocks meet here, in earlier_legs.py, in lumps.py and in strand_births.py. The name of a time there, of a motion
or of births on panels ends in its clock (`leg`, `to_leg` are indices):

- `_path`: since the beginning of the path, the clock of the march: births.motion, SolvedPanels.begin, Lump.birth;
- `_leg`: since the beginning of the present leg, to keep digits: here sums are taken;
- `_own_leg`: since the beginning of the leg on which that happens which the name tells, breaks or births. Contacts
  that break less than a delay before a turn are born on another leg than they broke on.

An example: the drive turns at t = 2 and t = 5, the delay is 0.3, and a panel has the breaks from 1.8 to 1.9. Then

    begin = 1.8 on the path,  breaks_begin_own_leg = 1.8 (leg 0),  births_begin_own_leg = 1.8 + 0.3 - 2 = 0.1 (leg 1),

and as seen from leg 2, which begins at 5, its births begin at 2.1 - 5 = -2.9 (`births_leg` of `_sum_over_legs`).

In the march, and of stored panels, a time without such an ending (t, begin, end, edges) is on the path. Where a
function is given times on a clock that its caller chooses, as SolvedPanels.births is, its docstring says so.

Past.enter turns births from the first to the third and then to the second, sums_of_lumps turns lumps from the first to
the second.

The march calls two. `Past.enter` makes a leg the present one, for good; it alone changes which contacts are counted:
legs are left out by what held when `at` was last asked (`_leave_out`), and the sums of the others are made anew.
`Past.at` gives the sums on that leg, as often as is asked; it notes errors and what holds.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from master.outcome import FaultError
from master.renewal.births import OFF_PANEL_END, TINY, Births, Lump, Sums
from master.renewal.earlier_legs import EarlierLegs
from master.renewal.few_times import FewTimes
from master.renewal.lumps import sums_of_lumps
from master.renewal.solved import SolvedPanels
from origins.thresholds.law import Array

if TYPE_CHECKING:
    from master.renewal.strand_births import Strands

# Factor on the accuracy where a survival is a sum or followed by strands: so exact a sum over births would take long
# (with heat of 0.1 <x_s>² on two turns an eighth longer without this factor, and more with more turns).
# Where the survival is closed, as that of growing thresholds without heat, sums so coarse would make the number rough,
# and panels would be halved until all work is used up.
COARSER = 30.0
# Births on a leg are left out where fewer than this part of the accuracy hold, as many legs may be left out; at least a
# hundredth of the rounding of sums.
LEFT_OUT, LEAST_LEFT_OUT = 1e-3, 1e-18


class Past:
    """All contacts that were not born on the present leg, as that leg sees them.

    leg : the present leg; -1 before the first
    first_panel : the first panel whose births are on it
    worst_sum_error : estimate from above of the error of the number by the sums over births, the largest so far
    left_out : share of all contacts that held when their leg was left out, the sum over all legs so far
    survival_error : the largest error of a survival so far, as the life returned it

    _motion_leg, _leg_start_path : the motion on the clock of that leg, and when it begins on that of the path
    _accuracy, _left_out_below : asked of each piece of a sum over births (EarlierLegs), or of a sum (FewTimes); and
        the share that holds up to which a leg is left out
    _earlier_legs : sums over births on earlier legs, None where there are none; for contacts that age `_strands` in its
        place
    _holding_at_latest : by earlier leg, the share of all contacts that was born on it and held at the latest of the
        times that the last call of `at` asked for
    _legs_left_out : earlier legs that are left out for good
    _few : interpolates sums between few times, where a survival takes long
    """

    def __init__(self, births: Births) -> None:
        """Before the first leg."""
        self._births = births
        self._motion_leg, self._leg_start_path = births.motion, 0.0
        # no sum over thresholds, nor followed by strands
        closed = births.life.pair_work == 1 and not births.life.has_strands
        self._accuracy = births.accuracy * (1.0 if closed else COARSER)
        self._left_out_below = max(LEFT_OUT * self._accuracy, LEAST_LEFT_OUT)
        self.leg, self.first_panel = -1, 0
        self.left_out = self.worst_sum_error = 0.0
        self.survival_error = births.life.error
        self._legs_left_out, self._holding_at_latest = set[int](), dict[int, float]()
        self._earlier_legs: EarlierLegs | None = None
        self._strands = _made_strands(births, self._left_out_below)
        self._few = FewTimes(births)

    @property
    def error(self) -> float:
        """Error of the number, a share of the contacts. Sums are taken anew on each panel, so that their errors do not
        add up; contacts that are left out never come back, so that each leg adds its own."""
        return self.worst_sum_error + self.left_out

    def count_errors_of(self, other: "Past") -> None:
        """Go on from what another past has missed so far."""
        self.survival_error, self.worst_sum_error = other.survival_error, other.worst_sum_error
        self.left_out = other.left_out

    def enter(self, leg: int, solved: SolvedPanels) -> None:
        """Make this leg the present one, if it is not yet.

        It is so for good: contacts are followed from leg to leg, so that FaultError is raised for an earlier leg.

        solved : all panels so far; births on legs before do not change while the slider is on this one
        """
        if leg == self.leg:
            return
        if leg < self.leg:
            raise FaultError(
                f"leg {leg} is asked for after leg {self.leg}, a fault of the program: Past goes forward only"
            )
        self._leave_out()
        self.leg = leg
        self._set_clock(leg)
        self.first_panel = self.count_before(solved)
        panels_before = solved.pick(slice(self.first_panel))
        if self._strands is not None:
            self._follow_strands(self._strands, panels_before)
        else:
            self._sum_over_legs(panels_before)

    def at(self, leg: int, grid_leg: Array, lumps: Sequence[Lump]) -> Array:
        """Number and force, on the present leg, of births on the legs before, and of all lumps; (2, rows, columns).

        leg : the present leg, which was entered; FaultError for another one
        grid_leg : times in rows, each within one panel of the leg
        """
        if leg != self.leg:
            raise FaultError(
                f"sums are asked for on leg {leg} while leg {self.leg} is entered, a fault of the program"
            )
        found = self._from_few_times(grid_leg, lumps)
        if found is None:
            found = self._summed(grid_leg, lumps)
        self.worst_sum_error = max(self.worst_sum_error, found.error)
        self.survival_error = max(self.survival_error, found.survival_error)
        self._holding_at_latest = found.holding_by_leg or {}
        return found.both

    def _leave_out(self) -> None:
        """Leave out legs of whose births hardly any held when `at` was last called, on the leg before. That call may
        have been for panels that were rejected, at any time of that leg: this is safe, as survivals only fall, so that
        fewer hold on the leg to come."""
        for each, holding in self._holding_at_latest.items():
            if holding <= self._left_out_below:
                self._legs_left_out.add(each)
                self.left_out += abs(holding)  # a sum of next to nothing may come out negative
        self._holding_at_latest = {}

    def _set_clock(self, leg: int) -> None:
        """Count times from the beginning of this leg. It is set first, as births before are told by it."""
        motion_path = self._births.motion
        self._leg_start_path = float(motion_path.times[leg])
        self._motion_leg = motion_path.counted_from(leg)

    def count_before(self, solved: SolvedPanels) -> int:
        """How many panels there are whose births are on legs before the present one."""
        return int(np.searchsorted(self._legs_of_births(solved), self.leg))

    def _follow_strands(self, strands: "Strands", panels: SolvedPanels) -> None:
        """Follow contacts that age up to the beginning of the present leg; `panels` : those of all births before it."""
        legs, births_begin_own_leg = self._legs_and_begin(panels)
        self.left_out += strands.follow(
            self._motion_leg, self.leg, panels, births_begin_own_leg, legs
        )

    def _sum_over_legs(self, panels: SolvedPanels) -> None:
        """Make the sums over births on these panels, those before the present leg, but for legs left out."""
        legs, births_begin_own_leg = self._legs_and_begin(panels)
        counted = np.array(sorted(set(legs.tolist()) - self._legs_left_out), dtype=int)
        self._earlier_legs = None
        if counted.size:
            births_leg = panels.births(self._motion_leg.times[legs] + births_begin_own_leg)
            self._earlier_legs = EarlierLegs(
                self._births, self._motion_leg, self.leg, counted, births_leg, self._accuracy
            )

    def _legs_and_begin(self, panels: SolvedPanels) -> tuple[npt.NDArray[np.intp], Array]:
        """The leg of each panel's births, and when these begin, counted from the beginning of that leg.

        FaultError where they are not on it, or it is not before the present one: their contacts would count twice or
        not at all.
        """
        motion_path, legs = self._births.motion, self._legs_of_births(panels)
        births_begin_own_leg = panels.births_begin(motion_path.times[legs], self._births.delay)
        end_own_leg = births_begin_own_leg + panels.width
        duration = np.diff(motion_path.times)[legs]
        wrong = np.flatnonzero((legs >= self.leg) | (end_own_leg > duration + panels.beside_leg))
        if wrong.size:
            leg, end = legs[wrong[0]], end_own_leg[wrong[0]]
            raise FaultError(
                f"births are on a wrong leg: on the panel that begins at t = {panels.begin[wrong[0]]:.9g} of the path "
                f"they end at {end:.9g} of leg {leg} (from 0), which lasts {duration[wrong[0]]:.9g}, while the slider "
                f"is on leg {self.leg}, a fault of the program"
            )
        return legs, births_begin_own_leg

    def _legs_of_births(self, panels: SolvedPanels) -> npt.NDArray[np.intp]:
        """The leg of each panel's births, which come one delay after its breaks.

        A panel ends one delay before each turn (`needed` in edges.py), so that all of its births are on one leg, and
        any of them tells it; that in the middle is the farthest from both ends, and from their rounding. An example:
        the drive turns at t = 2, and the delay is 0.3. Breaks from 1.6 to 1.7 are born from 1.9 to 2 on leg 0, as
        their middle, 1.95, tells; those from 1.7 to 1.8 on leg 1.

        The narrowest panels are as wide as times are rounded, though, and the middle is then their begin. If that is a
        turn, `Motion.leg` says that it belongs to the leg that ends there, but the births come after it. So of the
        begin is asked which leg begins there or before, and the later one of both is taken.
        """
        motion_path, delay = self._births.motion, self._births.delay
        leg_of_middle = motion_path.leg(panels.middle_of_births(delay))
        leg_of_begin = np.searchsorted(motion_path.times, panels.begin + delay, "right") - 1
        return np.maximum(leg_of_middle, leg_of_begin)

    def _from_few_times(self, grid_leg: Array, lumps: Sequence[Lump]) -> Sums | None:
        """As `_summed`, interpolated between few of the times; None where that is not tried, or not accurate. Errors of
        the interpolation are smooth, so that no panel shows them: its own estimate alone does."""
        abs_speed = abs(float(self._motion_leg.speeds[self.leg]))
        if self._earlier_legs is None or not self._few.are_tried(grid_leg, abs_speed):
            return None
        summed = self._summed(grid_leg[:, FewTimes.ASKED], lumps)
        both, interpolation_error = self._few.interpolated(summed.both)
        if interpolation_error > self._accuracy:
            self._few.take_narrower(grid_leg, abs_speed)
            return None
        return summed._replace(both=both, error=summed.error + interpolation_error)

    def _summed(self, grid_leg: Array, lumps: Sequence[Lump]) -> Sums:
        """The sums over both kinds of contacts."""
        of_lumps = sums_of_lumps(
            self._births, self._motion_leg, lumps, self._leg_start_path, grid_leg
        )
        births_before = self._strands if self._strands is not None else self._earlier_legs
        if births_before is None:
            return of_lumps
        of_births = births_before.sums(self._inside_panels(grid_leg).ravel())
        both = of_lumps.both + of_births.both.reshape(of_lumps.both.shape)
        survival_error = max(of_lumps.survival_error, of_births.survival_error)
        # a sum over lumps is no quadrature: it has no error but that of survivals
        return of_births._replace(both=both, survival_error=survival_error)

    def _inside_panels(self, grid_leg: Array) -> Array:
        """The times of a grid, later than the leg's beginning, which belongs to the leg before. Where the births of a
        hold may meet an exact threshold as a panel ends, all at once, they lie a little inside it."""
        if self._births.life.atoms.size and not self._motion_leg.speeds[: self.leg].all():
            first, last = grid_leg.min(axis=1, keepdims=True), grid_leg.max(axis=1, keepdims=True)
            inside = OFF_PANEL_END * (last - first)
            grid_leg = np.clip(grid_leg, first + inside, last - inside)
        return np.maximum(grid_leg, TINY)


def _made_strands(births: Births, left_out_below: float) -> "Strands | None":
    """The strands of contacts that age; None for all others."""
    if not births.life.has_strands:
        return None
    from master.renewal.strand_births import Strands  # of ageing alone

    return Strands(births, left_out_below)
