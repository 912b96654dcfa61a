"""Pulled: one drive of a soft slider, K (X_T - X) = F, step by step and slip after slip.

A step is so long in X and in time together, dX/length + d(clock) = step, that it is even where the
slider creeps and where it runs ahead of a slip, in which dX/dt grows without end: there X_T is
smooth in X. The slider lets go where the force falls faster than the spring's as it moves in no
time, F'(X) = -K. Where thresholds fluctuate none stand right at a stretch, and motion in no time
breaks none at first: there it lets go where X_T, as a function of X, has come furthest. So it is
where the weakest break by themselves before they are met; but there the faster the slider is the
more of them hold, as if it was pushed: it has let go where it is so many times as fast as the drive,
and comes to rest no sooner than they have been broken.
"""

from __future__ import annotations

import numpy as np

from master.soft.in_time.carried import Allowed, Carried, TooLongError, Trial
from master.soft.in_time.cohorts import Cohorts
from master.soft.in_time.onset import Onset
from master.soft.in_time.secants import foreseen, secant
from master.soft.in_time.slipping import COARSEST, MOST_SLIPS, Slip, Slipping, Task
from master.soft.in_time.track import LESS, Clock, Piece, Track

# Halvings of the last step before a slip where thresholds fluctuate: an edge that thins to nothing is
# followed down in ever smaller steps; and what share of the step its end is known to then.
NEARER, ABOUT = 4, 0.1
# Share of a step's usual time that it takes where the slider may be about to let go.
AHEAD = 0.3
# A share of a step's time; steps in which time grows by a factor e; breaks: where contacts break
# faster than that, as after a slip, steps are even in the logarithm of time.
SOON, PER_FOLD, FELT = 0.1, 0.7, 1e-5
# Share of the time that is as good as none.
INSTANT = 1e-12


class Pulled:
    """The whole way, on steps of 2^-level of the coarsest.

    Parameters
    ----------
    cohorts : Cohorts
        All contacts at X = 0.
    task : Task
    level : int
    plan : list of float
        Lengths, in steps of the coarsest, of the smooth stretches as coarser steps found them; empty
        on the coarsest.
    allowed : Allowed
        TooLongError says how far they came.

    Attributes
    ----------
    tracks : list of Track
    stretches : list of float
        Their lengths in steps, and those of instant slips, as `plan` has them.
    slips : list of Slip
    contacts : Carried
    """

    def __init__(
        self, cohorts: Cohorts, task: Task, level: int, plan: list[float], allowed: Allowed
    ) -> None:
        self.task, self._level, self._plan = task, level, plan
        self._length = COARSEST * cohorts.steps.length
        self.contacts = Carried(cohorts, task.delay, allowed)
        self.tracks: list[Track] = []
        self.stretches: list[float] = []
        self.slips: list[Slip] = []
        self._steep = (1.0 + task.spring) * (1.0 + 1.0 / LESS) * self._length
        fastest = max(abs(piece.travel) / piece.duration for piece in task.pieces)
        self._onset = Onset(self.contacts, task.spring, task.unit, self._length, fastest)
        self._slipping = Slipping(self.contacts, task, level, self._length, self._onset.thin)

    def run(self) -> None:
        """Follow the drive to its end."""
        for piece in self.task.pieces:
            self.contacts.mark_later(piece.begin)
            self._follow(piece, piece is self.task.pieces[-1])

    def _follow(self, piece: Piece, last: bool) -> None:
        """The drive goes on to the end of a piece."""
        here, spring = self.contacts, self.task.spring
        resets, before, since = 0, 0, len(self.tracks)
        sign = float(np.sign(piece.travel) or np.sign(here.force) or 1.0)
        steps = here.cohorts.steps
        # while contacts hold, the slider follows a soft spring's drive from far
        clock = Clock(
            piece, self._length * (1.0 + spring) / spring, steps.time, steps.rate / COARSEST
        )
        while True:
            marks = [at for at, _ in here.pending if at < piece.end]
            end = min(marks, default=piece.end)
            self._relax(end, piece, clock)
            if self._slide(end, piece, clock, sign):
                slip = self._slipping.slip(piece.at(here.now), sign, self._planned())
                self.slips.append(slip)
                if self._slipping.smooth:
                    self.stretches.append(abs(slip.after - slip.before) / self._length)
                before, since = since, len(self.tracks)
                resets += 1
                if self.task.rule == "reset" and resets == 2 and self._repeat(piece, last, before):
                    return
            elif marks:
                weight = sum(share for at, share in here.pending if at == here.now)
                here.pending = [one for one in here.pending if one[0] != here.now]
                if weight > 0.0:
                    here.born_at_once(weight, here.past.breaks[-1])
            else:
                return

    def _repeat(self, piece: Piece, last: bool, since: int) -> bool:
        """After a reset all is as after the one before, on the tracks since then, again and again.

        Whether to the end of the path.
        """
        here, tracks = self.contacts, self.tracks[since:]
        slip, length = self.slips[-1], self.stretches[-1]
        period = here.now - tracks[0].clock[0]
        way = slip.after - tracks[0].place[0]
        while last or here.now + period < piece.end:
            tracks = [track.later(period, way) for track in tracks]
            self.tracks += tracks
            self.stretches.append(length)
            if here.now + period > piece.end:
                return True
            lengths = slip.drive + way, slip.before + way, slip.after + way
            slip = Slip(*lengths, slip.force_before, slip.force_after)
            self.slips.append(slip)
            here.now, here.place = here.now + period, slip.after
            if len(self.slips) > MOST_SLIPS:
                raise TooLongError
        here.settle(self.task.again())
        return False

    def _relax(self, end: float, piece: Piece, clock: Clock) -> None:
        """On for a while in which contacts break faster than steps tell.

        As after a slip the weakest do, one after the other in the logarithm of time.
        """
        here = self.contacts
        now, steps = here.now, here.cohorts.steps
        lasts = SOON * (min(clock.time(clock.count(now) + 1.0), end) - now)
        first = max(steps.time, INSTANT * end)
        if not first < SOON * lasts:
            return
        if here.tried(0.0, now + lasts).counted.breaks - here.past.breaks[-1] < FELT:
            return
        folds = float(np.log(lasts / first))
        number = int(np.ceil(PER_FOLD * folds)) * 2**self._level
        track, travel = Track(), 0.0
        self.tracks.append(track)
        here.bend()
        self._write(track, 0.0)
        for k in range(number + 1):
            trial = self._to(now + first * float(np.exp(folds * k / number)), piece, travel)
            travel = trial.travel
            here.take(trial)
            self._write(track, k + 1.0)

    def _slide(self, end: float, piece: Piece, clock: Clock, sign: float) -> bool:
        """Until `end`, or until the slider lets go: which of them."""
        here, onset = self.contacts, self._onset
        planned, fine = self._planned(), 0.5**self._level
        steps = int(np.ceil(max(planned, 1e-6))) * 2**self._level
        size = planned / steps if planned else fine
        track = Track()
        self.tracks.append(track)
        here.bend()
        self._write(track, 0.0)
        total, shares, taken = 0.0, [0.5], 0
        let_go = onset.at_once(sign)
        while not let_go and here.now < end:
            taken += 1
            share = foreseen(shares)
            # the last of the planned steps takes what is left
            trial = self._step(size * (1.5 if taken >= steps else 1.0), share, piece, clock, sign)
            if trial.now >= end:
                trial = self._to(end, piece, trial.travel)
            # the slider runs ahead of its drive before it lets go
            ahead = clock.count(trial.now) - clock.count(here.now) < AHEAD * LESS * size
            if trial.now <= here.now or (ahead and onset.past(trial, track, clock, sign)):
                let_go = True
                for _ in range(NEARER if onset.fuzzy else 0):
                    half = onset.found(trial.travel, piece, track, clock, sign, ABOUT)
                    part = onset.balanced(0.5 * half.travel, piece, clock, sign)
                    total += self._record(part, track, clock, sign, total)
                    trial = trial._replace(travel=trial.travel - part.travel)
                trial = onset.found(trial.travel, piece, track, clock, sign, self.task.close)
            elif trial.now < end and taken >= steps:
                trial = self._step(size, share, piece, clock, sign)
            count = clock.count(trial.now) - clock.count(here.now)
            stretch = self._record(trial, track, clock, sign, total)
            shares.append(count / stretch if stretch > 0.0 else 0.5)
            total += stretch
        self.stretches.append(total)
        return let_go

    def _planned(self) -> float:
        """How many of the coarsest steps the next smooth stretch took on coarser steps, or 0."""
        number = len(self.stretches)
        return self._plan[number] if number < len(self._plan) else 0.0

    def _record(self, trial: Trial, track: Track, clock: Clock, sign: float, total: float) -> float:
        """Take a step, the size of which is returned."""
        time = clock.count(trial.now) - clock.count(self.contacts.now)
        size = sign * trial.travel / self._length + time
        self.contacts.take(trial)
        self._write(track, total + size)
        return size

    def _write(self, track: Track, total: float) -> None:
        here = self.contacts
        track.step.append(total)
        track.clock.append(here.now)
        track.place.append(here.place)
        track.force.append(here.force)
        track.holding.append(here.holding)

    def _step(self, size: float, share: float, piece: Piece, clock: Clock, sign: float) -> Trial:
        """A step of this size; at a time before now where there is none.

        share : of the size, what time is expected to take
        """
        here, spring = self.contacts, self.task.spring
        begin = clock.count(here.now)
        found: list[Trial] = []

        def excess(count: float) -> float:
            now = max(clock.time(begin + count), here.now)
            trial = here.tried(sign * self._length * (size - count), now)
            short = spring * (piece.at(now) - here.place - trial.travel) - trial.counted.force
            found[:] = [trial if count > 0.0 else trial._replace(now=here.now - 1.0)]
            return sign * short

        self._steep = secant(excess, share * size, self._steep, self.task.close * size, 0.0)
        return found[0]

    def _to(self, end: float, piece: Piece, guess: float) -> Trial:
        """A step up to a time."""
        here, spring = self.contacts, self.task.spring
        found: list[Trial] = []

        def excess(travel: float) -> float:
            found[:] = [here.tried(travel, end)]
            return spring * (piece.at(end) - here.place - travel) - found[0].counted.force

        secant(excess, guess, -spring - 1.0, self.task.close * self._length)
        return found[0]
