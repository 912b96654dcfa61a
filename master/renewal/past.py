"""Past: number and force, on the present leg, of all contacts that were not born on it.

They are of three kinds: lumps, the start among them; births on the legs before, where the survival follows
from the slider's displacements alone (earlier_legs.py); and such births of contacts that age, which have to be followed
from leg to leg (strand_births.py). Past adds them up, and forgets legs of whose births hardly any contact holds.

Three clocks. The march counts t from the beginning of the path, so that births.motion, Panels.begin and Lump.time do.
Here times are counted from the beginning of the present leg, to keep digits, so that the motion, the births and the
grids of Past, EarlierLegs and sums_of_lumps are; Past.enter turns one into the other for births, `_summed` for lumps.
In between, births are counted from the beginning of their own leg (Panels.births_begin), as strands of ageing contacts
are throughout.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from master.numerics import polynomials
from master.numerics.polynomials import Rows
from master.renewal.births import INSIDE, TINY, Births, Lump, Panels, Sums
from master.renewal.earlier_legs import EarlierLegs
from master.renewal.lumps import sums_of_lumps
from master.renewal.present import TARGETS
from master.survival.life import MARGIN, Life
from origins.thresholds.law import Array

if TYPE_CHECKING:
    from master.renewal.strand_births import StrandBirths

# Factor on the accuracy where a survival is a sum: so exact a sum over births would take long.
COARSER = 30.0
# Births on a leg are left out where fewer than this part of the accuracy hold, as many legs may be left out; at least a
# hundredth of the rounding of sums.
LEFT_OUT, LEAST_LEFT_OUT = 1e-3, 1e-18


class Past:
    """All contacts that were not born on the present leg, as that leg sees them.

    leg, first : the present leg, and the first panel whose births are on it
    worst_sum : estimate from above of the error of the number by the sums over births, the largest so far
    left_out : share of all contacts that held when their leg was left out, the sum over all legs so far
    survival_error : the largest error of a survival so far, as the life returned it
    """

    def __init__(self, births: Births) -> None:
        """Before the first leg: `enter` is called before anything is asked for."""
        self._births = births
        # the motion, its times and positions counted from the beginning of the present leg; when that is on the path
        self._motion, self._leg_begin = births.motion, 0.0
        self._accuracy = births.accuracy * (1.0 if births.life.quick else COARSER)
        self._left_out_below = max(LEFT_OUT * self._accuracy, LEAST_LEFT_OUT)
        self.leg, self.first = -1, 0
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

    def enter(self, leg: int, panels: Panels) -> None:
        """Begin leg `leg`: births on panels before it are earlier ones; those on panels from `first` on, one delay
        late, fall on it. `panels`: all that are solved.

        Legs are left out of whose births hardly any held when they were last asked for, on the leg before. A proposal
        that was rejected may have asked: a survival only falls, so that at any time of that leg more of them held than
        on this one."""
        births, path, before = self._births, self._births.motion, self.leg
        self.leg, self._leg_begin = leg, float(path.times[leg])
        self._motion = path.counted_from(leg)
        middle = panels.middle_of_births(births.delay)
        self.first = int(np.searchsorted(middle, self._leg_begin))
        panels, legs = panels.pick(slice(self.first)), path.leg(middle[: self.first])
        # counted from the beginning of the leg of each birth, and not yet of this one
        begin = panels.births_begin(path.times[legs], births.delay)
        if births.life.has_strands:
            self._follow_strands(range(max(before, 0), leg), panels, begin, legs)
            return
        if self._earlier is not None:
            self._legs_left_out |= self._earlier.may_be_left_out.keys()
            self.left_out += sum(abs(held) for held in self._earlier.may_be_left_out.values())
        counted = np.array(sorted(set(legs.tolist()) - self._legs_left_out), dtype=int)
        self._earlier = None
        if counted.size:
            born = panels.births(self._motion.times[legs] + begin)
            self._earlier = EarlierLegs(births, self._motion, leg, counted, born, self._accuracy)

    def at(self, grid: Array, lumps: Sequence[Lump]) -> Array:
        """Number and force of births on the legs before, and of all lumps, shape (2, rows, columns).

        grid : times in rows, each within one panel of the leg, counted from the leg's beginning
        lumps : their times are those on the path
        """
        speed = abs(float(self._motion.speeds[self.leg]))
        if self._earlier is not None and self._few.are_tried(grid, speed):
            interpolated = self._few.interpolated(self._summed(grid[:, FewTimes.ASKED], lumps))
            if interpolated.error <= self._accuracy:
                self.worst_sum = max(self.worst_sum, interpolated.error)
                return interpolated.both
            self._few.take_narrower(grid, speed)
        return self._summed(grid, lumps)

    def _summed(self, grid: Array, lumps: Sequence[Lump]) -> Array:
        """As `at`, at any times: the sum over all three kinds of contacts."""
        t = self._beside_jumps(grid).ravel()
        both = np.zeros((2, t.size))
        for strand in self._strands:
            both += strand.sums(t)
        if self._earlier is not None:
            both += self._counted(self._earlier.sums(t, self._left_out_below))
        # from here on their times are counted from the leg's beginning, too
        on_leg = [lump._replace(time=lump.time - self._leg_begin) for lump in lumps]
        of_lumps = self._counted(sums_of_lumps(self._births, self._motion, on_leg, grid))
        return both.reshape(2, *grid.shape) + of_lumps

    def _counted(self, sums: Sums) -> Array:
        """Number and force of some sums, whose errors are counted."""
        self.worst_sum = max(self.worst_sum, sums.error)
        self.survival_error = max(self.survival_error, sums.survival_error)
        return sums.both

    def _beside_jumps(self, grid: Array) -> Array:
        """The times of a grid, later than the leg's beginning, which belongs to the leg before. Where the births of a
        hold may meet an exact threshold as a panel ends, all at once, they lie a little inside it."""
        if self._births.life.atoms.size and not self._motion.speeds[: self.leg].all():
            first, last = grid.min(axis=1, keepdims=True), grid.max(axis=1, keepdims=True)
            inside = INSIDE * (last - first)
            grid = np.clip(grid, first + inside, last - inside)
        return np.maximum(grid, TINY)

    def _follow_strands(self, new: range, panels: Panels, begin: Array, legs: Rows) -> None:
        """Make strands of the births on the `new` legs, and follow all strands to the present leg. `begin`: when the
        births of each panel begin, since the beginning of the leg on which they are."""
        from master.renewal.strand_births import StrandBirths  # of ageing alone

        for leg in new:
            on_leg = legs == leg
            number = float(np.abs(panels.breaks[on_leg]).max(axis=1).sum())
            if number > self._left_out_below:
                born = panels.pick(on_leg).births(begin[on_leg])
                self._strands.append(StrandBirths(self._births, leg, born))
                # single strands are not followed below this survival
                self.left_out += self._left_out_below * self._strands[-1].births
            else:
                self.left_out += number
        followed, self._strands = self._strands, list[StrandBirths]()
        for each in followed:
            if each.seen_from(self._motion, self._left_out_below):
                self._strands.append(each)
            else:
                self.left_out += each.holding
        self.worst_sum = max(self.worst_sum, sum(each.missed for each in self._strands))
        survivals = (each.survival_error for each in self._strands)
        self.survival_error = max(self.survival_error, *survivals, 0.0)


class FewTimes:
    """Sums at all TARGETS of a panel from those at a few, where births on earlier legs change little over it.

    It is tried where a survival takes long. The cubic through the sums at four of the places gives those at all of
    them, and the sums at two more test it; a layer right behind a turn would show at the first of these.

    SUMMED : columns of TARGETS through which the cubic goes: at degree 16 these are 0, 6, 11 and 16, the panel's
        beginning, two nodes in between and its end
    CHECKED : two of the check points between the nodes, columns 17 and 19
    ASKED : both, the only columns that are summed
    TO_ALL : matrix from the sums at SUMMED to the cubic at all TARGETS, shape (4, TARGETS.size)
    NARROWER : where it fails, it is tried again on panels of this part of the width only
    """

    SUMMED = (0, 3 * polynomials.DEGREE // 8, 11 * polynomials.DEGREE // 16, polynomials.DEGREE)
    CHECKED = (polynomials.DEGREE + 1, polynomials.DEGREE + 3)
    ASKED: tuple[int, ...] = SUMMED + CHECKED
    TO_ALL = polynomials.Points(2.0 * TARGETS[list(SUMMED)] - 1.0).at(TARGETS)
    NARROWER = 0.5

    def __init__(self, life: Life) -> None:
        """For births of this life."""
        self._unit = life.largest_stretch
        # the longest travel on a panel at which it is tried (a length)
        self._longest = 0.0 if life.quick or life.atoms.size else np.inf

    def are_tried(self, grid: Array, speed: float) -> bool:
        """Whether the rows of a grid of times may be interpolated."""
        return grid.shape[1] == TARGETS.size and 0.0 < self._travel(grid, speed) < self._longest

    def interpolated(self, sums: Array) -> Sums:
        """Number and force at all TARGETS from those at the ASKED ones; a smooth interpolant hides its error from the
        panels, so that it is told."""
        summed, checked = np.split(sums, [len(self.SUMMED)], axis=2)
        both = summed @ self.TO_ALL
        number, force = np.abs(both[..., list(self.CHECKED)] - checked).max(axis=(1, 2))
        # between the two it may be MARGIN times as far off
        return Sums(both, MARGIN * float(max(number, force / self._unit)))

    def take_narrower(self, grid: Array, speed: float) -> None:
        """It failed on the panels of this grid."""
        self._longest = self.NARROWER * self._travel(grid, speed)

    def _travel(self, grid: Array, speed: float) -> float:
        """The slider's travel on a panel."""
        return float(np.ptp(grid[0])) * speed
