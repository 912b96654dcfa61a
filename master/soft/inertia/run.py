"""One run of a slider with mass, with one tolerance, and its slips; and where two runs part."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from master.motion import Motion, drive_motion
from master.outcome import StoppedError
from master.soft.cold_contacts import ColdContacts
from master.soft.in_time.refining import AT_BALANCE
from master.soft.inertia.body import RINGS
from master.soft.inertia.delayed.slider import DelayedSlider
from master.soft.inertia.foretold import why_too_long
from master.soft.inertia.record import Record
from master.soft.inertia.slider import InertialSlider
from master.soft.inertia.slow import FALLS_AS, FASTEST
from master.soft.slips import Slips
from origins import Contacts
from origins.brief import brief
from origins.drive import Drive
from origins.energy import Energy
from origins.errors import refuse
from origins.thresholds.law import Array

# Part of a run's tolerance that each panel of F may take; and the least, a share of the contacts: round-off.
OF_PANELS, LEAST_OF_PANELS = 0.01, 1e-13
# Differences of two runs below this many mean thresholds are rounding.
ROUNDING = 1e-14
# Speed in place of 0.
TINY = 1e-300
# An error of a duration is told up to this part of it, and where two runs differ in it by no more than so many times
# what their forces differ by, as a part of the fall: up to 5 times as a rule, hundreds of times in a slip that fades.
OF_DURATION, FOLLOWS = 0.1, 30.0
# Part of a swing to which a place tells the phase (45 pairs of runs of 7 drawn machines: off by 0.1 of the error told).
PHASE = 0.03
# Two runs tell when a slip begins. The true time may be off by NEAR times what they differ by. As both may agree by
# chance, it is taken to be off by what the run before differed by over FALL at least: tolerances fall by 5 each time.
NEAR, FALL = 4.0, 5.0


@dataclass(frozen=True)
class SlipsInTime(Slips):
    """Slips of a slider with mass: falls of the spring's force that end a stick, as those of many contacts by
    eq_model.simulate.

    time : when the slider begins to be faster than the drive; duration : until it is slower again, or, where it only
        comes close to that, until all but a thousandth of the fall is done, shape (n,)
    top_speed : largest dX/dt on the way (length per time), shape (n,)
    duration_error : estimate from above of the largest error of `duration`, a time; inf where it is not known, as
        where one slip fades without a swing: its thousandth hangs on the error of the force (a hundredth of it or so).
    force_error : the same of the forces before and after slips, in mean thresholds; that of X_T, `drive_error`, may
        add up from slip to slip
    spacing_error : the same of the distance of X_T from one slip to the next, a length; inf where it is not known

    What counts as one is said in origins/drive.py, for both solvers.
    """

    time: Array
    duration: Array
    top_speed: Array
    duration_error: float = np.inf
    force_error: float = np.inf
    spacing_error: float = np.inf

    __repr__ = brief

    @property
    def period_error(self) -> float:
        """As of other slips; with others between main ones, of all these distances."""
        most = int(np.diff(self.main).max(initial=1))
        return min(super().period_error, most * self.spacing_error)


class Differences(NamedTuple):
    """Largest differences of two runs, in mean thresholds.

    force : of the spring's force at all points, and of what `force_and_load` says
    force_and_load : of that force as slips begin and end, of K X_T there, and of the force at points not beside a slip
    contact_force : of that of the contacts; holding : of the share of them that holds (a share)
    """

    force: float
    force_and_load: float
    contact_force: float
    holding: float


class Run:
    """The slider followed once.

    record, balance : results at the path's points, and X_T at t = 0; force : of the spring, as far as it was followed
    tolerance : what is asked of it; stopped : why it was not followed to the end
    stored_first : energy of the contacts at t = 0
    spring, unit : K, and the mean threshold (a length)
    waits : delay after which contacts form again (a time)
    goes_on : what small swings change that are not followed, None where all are
    """

    def __init__(
        self, contacts: Contacts, drive: Drive, asked: float, part: float, until: float
    ) -> None:
        """With a part of the tolerance that is asked for."""
        spring, unit, tolerance = float(drive.spring or 0.0), contacts.mean_threshold, part * asked
        cold = ColdContacts(contacts, spring, tolerance, until)
        # the motion hangs on F itself, and not on F' as slips without a mass do
        of_panels = OF_PANELS * tolerance * unit / cold.life.largest_stretch
        cold.of_panels = max(of_panels, LEAST_OF_PANELS)
        self.spring, self.unit, self.waits = spring, unit, contacts.waiting_time
        self._mass, self._damping = float(drive.mass or 0.0), float(drive.damping or 0.0)
        self.tolerance = tolerance
        self.balance = cold.force_of(contacts.start) / spring
        if abs(drive.path[0] - self.balance) <= AT_BALANCE * unit:
            self.balance = float(drive.path[0])
        elif drive.time is not None and drive.time[0] == 0.0:
            hint = f"at time 0 the drive stands where it balances the start, {self.balance:.9g}"
            refuse("path[0]", drive.path[0], hint)
        at_rest = Motion(np.array([0.0, 1.0]), np.full(2, self.balance))
        motion, self.stopped = drive_motion(drive, self.balance) or at_rest, ""
        self.record = Record(drive.arrival_times(self.balance), unit, self.waits)
        slider: DelayedSlider | InertialSlider
        if contacts.waiting_time:
            given = drive, motion, self.record, tolerance * unit, asked * unit
            slider = DelayedSlider(contacts, *given, until)
        else:
            fastest = FASTEST * part**FALLS_AS
            slider = InertialSlider(cold, drive, motion, self.record, tolerance * unit, fastest)
        self.stored_first = np.nan
        try:
            self.stored_first = slider.stored_first
            slider.run()
            self.record.end_path()
        except StoppedError as why:
            self.stopped = str(why)
            if self.stopped == RINGS:
                self.stopped = why_too_long(drive)
        self.nodes = slider.nodes
        self.goes_on = slider.goes_on if isinstance(slider, DelayedSlider) else None
        solved = np.isfinite(self.record.place)
        count = solved.size if solved.all() else int(np.argmin(solved))
        self.force = spring * (drive.path[:count] - self.record.place[:count])

    @property
    def caught_anywhere(self) -> bool:
        """Whether contacts that broke in a slip come back while the slider swings by more than a threshold, and the
        run knows its place, to the tolerance over K, neither to one nor to PHASE of the swing: the next slip begins by
        where in its swing they catch it."""
        inertia = self._mass * self.spring
        if self._damping**2 >= 4.0 * inertia or not inertia:
            return False
        slips = self.slips(0.0)
        freely = np.maximum(self.waits - slips.duration, 0.0)
        fades = np.exp(-0.5 * self._damping / self._mass * freely)
        swing = np.abs(slips.top_speed) * (self._mass / self.spring) ** 0.5 * fades
        back = slips.time + self.waits < self.record.times[self.force.size - 1]
        off = self.tolerance * self.unit / self.spring
        anywhere = off > np.maximum(PHASE * swing, self.unit)
        return bool((back & anywhere & (swing > self.unit)).any())

    def energy(self) -> Energy:
        """Energies at the points that were reached."""
        record, n = self.record, self.force.size
        record.finish()
        return Energy(
            drive=record.work[:n],
            spring=0.5 * self.force**2 / self.spring,
            contacts=record.stored[:n],
            kinetic=0.5 * self._mass * record.speed[:n] ** 2,
            damped=record.damped[:n],
            released=record.on_contacts[:n] - (record.stored[:n] - self.stored_first),
            start=0.5 * self.spring * self.balance**2 + self.stored_first,
        )

    def slips(self, drive_error: float, duration_error: float = np.inf) -> SlipsInTime:
        """The slips with these errors, of X_T and of their durations."""
        found = self.record.slips
        begin, end = (np.reshape([slip[at] for slip in found], (-1, 5)).T for at in (0, 1))
        top = np.array([slip.top_speed for slip in found])
        return SlipsInTime(
            drive=begin[1],
            before=begin[2],
            after=end[2],
            force_before=begin[3],
            force_after=end[3],
            drive_error=drive_error,
            time=begin[0],
            duration=end[0] - begin[0],
            top_speed=top,
            duration_error=duration_error,
            force_error=self.spring * drive_error / self.unit,
        )

    def differ(self, other: "Run", earlier: "Run | None" = None) -> Differences:
        """How far this run differs from the one before; `earlier` : the run before that, if there is one."""
        n = min(self.force.size, other.force.size)
        ours, theirs = self.slips(0.0), other.slips(0.0)
        if ours.drive.size != theirs.drive.size or not n:
            return Differences(np.inf, np.inf, np.inf, np.inf)
        points = np.abs(self.force[:n] - other.force[:n])
        force_and_load = max(
            float(points[~self._beside_slips(ours, theirs)[:n]].max(initial=0.0)),
            self.spring * float(np.abs(ours.drive - theirs.drive).max(initial=0.0)),
            float(np.abs(ours.force_before - theirs.force_before).max(initial=0.0)),
            float(np.abs(ours.force_after - theirs.force_after).max(initial=0.0)),
        )
        contacts = np.abs(self.record.contact_force[:n] - other.record.contact_force[:n]).max()
        apart = times_apart(ours, theirs, (earlier or other).slips(0.0))
        contacts = max(contacts, self.unknown_hold(ours, apart))
        both = max(force_and_load, float(points.max()), self.unknown_fall(ours, apart))
        holding = np.abs(self.record.holding[:n] - other.record.holding[:n]).max()
        holding = max(float(holding), self.unknown_share(ours, apart))
        unit = self.unit
        return Differences(both / unit, force_and_load / unit, float(contacts) / unit, holding)

    def _beside_slips(self, ours: SlipsInTime, theirs: SlipsInTime) -> NDArray[np.bool_]:
        """Which of the path's points lie in a slip of either run, or behind it while contacts are out, shape (n,):
        there the force swings, and differs by all that it changes in the time by which the slips do."""
        times, beside = self.record.times, np.zeros(self.record.times.size, dtype=bool)
        begins, ends = (
            np.stack([ours.time, theirs.time]),
            np.stack([ours.duration, theirs.duration]),
        )
        ends += begins + self.waits
        apart = np.abs(np.diff(begins, axis=0))[0]
        for begin, end in zip(begins.min(axis=0) - apart, ends.max(axis=0) + apart, strict=True):
            beside |= (times >= begin) & (times <= end)
        return beside

    def unknown_fall(self, ours: SlipsInTime, apart: Array) -> float:
        """How much (a length) the spring's force may be off at points of the path, as the time when a slip begins is
        known to `apart` (slips,) only. It counts at points in a slip, and so near to its begin that they may be in it:
        half a swing falls at less than twice its mean rate. Behind the slip the slider swings on while contacts are
        out: there the force is off by as much less as the slider is slower. A slip that goes on as the path ends is not
        counted."""
        count = self.force.size
        times, speed = self.record.times[:count, None], self.record.speed[:count, None]
        end = ours.time + ours.duration + apart
        inside = (times >= ours.time - apart) & (times <= end + self.waits)
        part = np.minimum(2.0 * apart / np.maximum(ours.duration, apart), 1.0)
        off = np.abs(ours.drop) * np.where(apart > 0.0, part, 0.0)
        # of a drive that goes down, all speeds are below 0
        slower = np.abs(speed) / np.maximum(np.abs(ours.top_speed), np.abs(speed) + TINY)
        slower = np.where(times > end, slower, 1.0)
        return float(np.where(inside, off * slower, 0.0).max(initial=0.0))

    def unknown_hold(self, ours: SlipsInTime, apart: Array) -> float:
        """The same of the contacts' force, which a slip takes at its begin."""
        near = np.abs(self.record.times[: self.force.size, None] - ours.time) < apart
        return float(np.where(near, np.abs(ours.force_before), 0.0).max(initial=0.0))

    def unknown_share(self, ours: SlipsInTime, apart: Array) -> float:
        """The same of the share that holds, which contacts with a delay leave at a slip's begin and come back to one
        delay later."""
        if not self.waits:
            return 0.0
        times = self.record.times[: self.force.size, None]
        near = np.abs(times - ours.time) < apart
        near |= np.abs(times - self.waits - ours.time) < apart
        return float(near.any())

    def duration_error(self, other: "Run", error: float) -> float:
        """Estimate from above of the largest error of the slips' durations, where that of the force is `error` (mean
        thresholds), by the difference from another run, which shows how durations follow the force; where this is by
        chance none, as much of a duration as the error is of the slip's fall. inf for other numbers of slips, and
        where it does not follow the force in proportion, as at the end of a slip that fades."""
        ours, theirs = self.slips(0.0), other.slips(0.0)
        if any(slip.fades for slip in self.record.slips):
            return np.inf
        differ = self.differ(other).force_and_load
        if not np.isfinite(differ) or not np.isfinite(error):
            return np.inf
        lasts, change = ours.duration, np.abs(ours.duration - theirs.duration)
        per_force = change / max(differ, ROUNDING) + lasts * self.unit / np.abs(ours.drop)
        off = error * per_force
        of_fall = np.maximum(differ, ROUNDING) * self.unit / np.abs(ours.drop)
        follows = (off <= OF_DURATION * lasts) & (change <= FOLLOWS * of_fall * lasts)
        return float(off.max(initial=0.0)) if follows.all() else np.inf

    def parting(self, other: "Run", most: float) -> str:
        """From where on the spring's force differs from that of another run by more than this (mean thresholds), in
        words, ": the two ..."; "" where it does so at no point of the path."""
        n = min(self.force.size, other.force.size)
        off = np.abs(self.force[:n] - other.force[:n]) / self.unit
        apart = np.flatnonzero(off > most)
        if not apart.size:
            return ""
        t, x = self.record.times[apart[0]], self.record.place[apart[0]]
        slips = len(self.record.slips), len(other.record.slips)
        slips_differ = "" if slips[0] == slips[1] else f", and slip {slips[0]} and {slips[1]} times"
        return f": the two runs part by {off.max():.1e} mean thresholds, from t = {t:.6g}, X = {x:.6g} on{slips_differ}"


def times_apart(ours: SlipsInTime, theirs: SlipsInTime, earlier: SlipsInTime) -> Array:
    """By how much the time at which each slip begins may be off in a run, shape (slips,); `theirs`: of the run before,
    `earlier`: of the one before that, where there is one."""
    apart = NEAR * np.abs(ours.time - theirs.time)
    if earlier.time.size == theirs.time.size:
        apart = np.maximum(apart, np.abs(theirs.time - earlier.time) / FALL)
    return np.asarray(apart)
