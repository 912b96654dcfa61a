"""A soft slider with any laws of single contacts: K (X_T - X) = F, step by step, through all slips on the way.

A step is so long in X and in time together, σ dX/length + d(clock) = step, that it is even where the slider creeps and
where it runs ahead of a slip, in which dX/dt grows without end: there X_T is smooth in X. The slider lets go where the
force falls faster than the spring's as it moves in no time, F'(X) = -K. Where thresholds fluctuate none stand right at
a stretch, and motion in no time breaks none at first: there it is where X_T, as a function of X, has come furthest. So
it is where the weakest break by themselves before they are met, but there the faster the slider is the more of them
hold, as if it was pushed: it has let go where it is so many times as fast as the drive, and comes to rest no sooner
than they have been broken.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import brentq

from master._old.carried import Carried, Trial
from master._old.lives import Lives
from master._old.secants import foreseen, secant
from master._old.timeline import Piece
from master._old.track import LESS, Clock, Slip, TooLong, Track
from origins.drive import SlipRule

_BESIDE = 1e-4  # of a step: a little further on
_CLOSE, _CLOSE_ENOUGH = 1e-10, 1e-7  # of what a step takes in time
_BALANCED, _ROUNDING = 1e-9, 1e-12  # forces left over
_DOUBLINGS = 60
_AHEAD = 0.3  # of the clock's usual part of a step, below which the slider may be about to let go
_SLOPE_NODES = 5
_NEARER = 4  # halvings of the last step before a slip
_ABOUT, _EXACTLY = 0.1, 1e-7  # of a step, where it is
_LEAST_WAY = 0.01
_NO_TIME = 1e-11
_FAST = 100.0  # times the drive's speed, at least
_SCAN = 0.25
_MOST_STEPS = 20_000
_SOON, _PER_FOLD, _FELT = 0.1, 0.7, 1e-5  # of a step's time; steps in a change by a factor e; breaks
_INSTANT = 1e-12  # of the time, as good as none
COARSEST = 0.5  # of the length over which births change


class Pull(Carried):
    """One drive on steps of 2^-level of the coarsest, `lives` being all contacts at X = 0.

    again : makes the lives that a reset leaves
    plan : lengths in steps of the smooth stretches found on coarser steps, in order; empty on the coarsest
    most : steps, and numbers looked at in all of them, that it may take; TooLong says how far they came
    """

    def __init__(
        self,
        lives: Lives,
        again: Callable[[], Lives],
        course: list[Piece],
        spring: float,
        rule: SlipRule,
        delay: float,
        unit: float,
        length: float,
        level: int,
        plan: list[float],
        most: tuple[float, float],
    ) -> None:
        super().__init__(lives, delay, length, most)
        self._again, self._spring, self._rule = again, spring, rule
        self._unit, self._level, self._plan = unit, level, plan
        self.tracks: list[Track] = []
        self.stretches: list[float] = []
        self.slips: list[Slip] = []
        # the weakest contacts give way the later the faster the slider is: X_T comes to a stand only little by little
        fastest = max(abs(piece.travel) / piece.duration for piece in course)
        self._thin = lives.skin > fastest * lives.time
        self._fuzzy = lives.fuzzy or self._thin
        # where heat moves the slip itself by more, nothing is gained by waiting longer
        fast = max(_FAST, float(np.sqrt(unit / lives.skin))) if self._thin else np.inf
        self._runs = LESS * spring / (1.0 + spring) / fast
        self._rise = (1.0 + spring) * length / LESS
        self._steep = (1.0 + spring) * (1.0 + 1.0 / LESS) * length
        for piece in course:
            self._mark_later(piece.begin)
            self._follow(piece, piece is course[-1])

    # -- straight on ---------------------------------------------------------------------------------------------------
    def _follow(self, piece: Piece, last: bool) -> None:
        """The drive goes on to the end of a piece."""
        resets, before, since = 0, 0, len(self.tracks)
        sign = np.sign(piece.travel) or np.sign(self._force) or 1.0
        # while contacts hold, the slider follows a soft spring's drive from far
        drawn = self._length * (1.0 + self._spring) / self._spring
        clock = Clock(piece, drawn, self._lives.time, self._lives.rate / COARSEST)
        speed = piece.travel / piece.duration

        def drive(now: float) -> float:
            return piece.before + speed * (now - piece.begin)

        while True:
            marks = [at for at, _ in self._pending if at < piece.end]
            end = min(marks, default=piece.end)
            self._relax(end, drive, clock)
            let_go = self._slide(end, drive, clock, float(sign))
            if let_go:
                self._slip(drive(self._now), float(sign))
                before, since = since, len(self.tracks)
                resets += 1
                if self._rule == "reset" and resets == 2 and self._repeat(piece, last, before):
                    return
            elif marks:
                weight = sum(share for at, share in self._pending if at == self._now)
                self._pending = [one for one in self._pending if one[0] != self._now]
                if weight > 0.0:
                    self._born_at_once(weight, self._breaks[-1])
            else:
                return

    def _repeat(self, piece: Piece, last: bool, since: int) -> bool:
        """After a reset all is as after the one before, on the tracks since then, again and again: whether to the end
        of all."""
        tracks, slip, length = self.tracks[since:], self.slips[-1], self.stretches[-1]
        period = self._now - tracks[0].clock[0]
        way = slip.after - tracks[0].place[0]
        while last or self._now + period < piece.end:
            done = len(self.slips) - 1
            tracks = [track.later(period, way) for track in tracks]
            self.tracks += tracks
            self.stretches.append(length)
            if self._now + period > piece.end:
                return True
            slip = Slip(slip.drive + way, slip.before + way, slip.after + way, slip.force_before, slip.force_after)
            self.slips.append(slip)
            self._now, self._place = self._now + period, slip.after
            if done > _MOST_STEPS:
                raise TooLong
        self._settle(self._again())
        return False

    def _relax(self, end: float, drive: Callable[[float], float], clock: Clock) -> None:
        """On for a while in which contacts break faster than steps tell, as after a slip the weakest do, one after the
        other in the logarithm of time."""
        now = self._now
        lasts = _SOON * (min(clock.time(clock.count(now) + 1.0), end) - now)
        first = max(self._lives.time, _INSTANT * end)
        if not first < _SOON * lasts or self._try(0.0, now + lasts).breaks - self._breaks[-1] < _FELT:
            return
        folds = float(np.log(lasts / first))
        number = int(np.ceil(_PER_FOLD * folds)) * 2**self._level
        track, travel = Track(), 0.0
        self._bend()
        self._write(track, 0.0)
        for k in range(number + 1):
            at = now + first * float(np.exp(folds * k / number))
            travel, trial = self._to(at, drive, travel)
            self._take(trial, travel, at)
            self._write(track, k + 1.0)
        self.tracks.append(track)

    def _slide(self, end: float, drive: Callable[[float], float], clock: Clock, sign: float) -> bool:
        """Until `end`, or until the slider lets go: which of them."""
        number = len(self.stretches)
        planned = self._plan[number] if number < len(self._plan) else 0.0
        fine = 0.5**self._level
        steps = int(np.ceil(max(planned, 1e-6))) * 2**self._level
        size = planned / steps if planned else fine
        track = Track()
        self._bend()
        self._write(track, 0.0)
        total, shares, taken = 0.0, [0.5], 0
        let_go = not self._fuzzy and self._force_slope(sign) + self._spring <= 0.0
        while not let_go and self._now < end:
            taken += 1
            # the last of the planned steps takes what is left
            reach = size * (1.5 if taken >= steps else 1.0)
            share = foreseen(shares)
            at, travel, trial = self._step(reach if taken >= steps else size, share, drive, clock, sign)
            if at >= end:
                at = end
                travel, trial = self._to(end, drive, travel)
            # the slider runs ahead of its drive before it lets go
            ahead = clock.count(at) - clock.count(self._now) < _AHEAD * LESS * size
            if at <= self._now or (ahead and self._falls(travel, at, trial, track, clock, sign) <= 0.0):
                let_go = True
                for _ in range(_NEARER if self._fuzzy else 0):
                    # an edge that thins to nothing is followed down in ever smaller steps
                    half = 0.5 * self._onset(travel, drive, track, clock, sign, _ABOUT)[0]
                    now = self._when(half, drive, clock, sign)
                    total += self._record(self._try(half, now), half, now, track, clock, sign, total)
                    travel -= half
                travel, at = self._onset(travel, drive, track, clock, sign, _EXACTLY)
                trial = self._try(travel, at)
            elif at < end and taken >= steps:
                at, travel, trial = self._step(size, share, drive, clock, sign)
            count = clock.count(at) - clock.count(self._now)
            stretch = self._record(trial, travel, at, track, clock, sign, total)
            shares.append(count / stretch if stretch > 0.0 else 0.5)
            total += stretch
        self.stretches.append(total)
        self.tracks.append(track)
        return let_go

    def _record(
        self, trial: Trial, travel: float, at: float, track: Track, clock: Clock, sign: float, total: float
    ) -> float:
        """Take a step, the size of which is returned."""
        size = sign * travel / self._length + clock.count(at) - clock.count(self._now)
        self._take(trial, travel, at)
        self._write(track, total + size)
        return size

    def _write(self, track: Track, total: float) -> None:
        track.step.append(total)
        track.clock.append(self._now)
        track.place.append(self._place)
        track.force.append(self._force)
        track.holding.append(self._holding)

    def _step(
        self, size: float, share: float, drive: Callable[[float], float], clock: Clock, sign: float
    ) -> tuple[float, float, Trial]:
        """Time, travel and contacts after a step of this size; a time before now where there is none."""
        begin = clock.count(self._now)
        found: list[tuple[float, float, Trial]] = []

        def excess(count: float) -> float:
            at = max(clock.time(begin + count), self._now)
            travel = sign * self._length * (size - count)
            trial = self._try(travel, at)
            found[:] = [(at if count > 0.0 else self._now - 1.0, travel, trial)]
            return sign * (self._spring * (drive(at) - self._place - travel) - trial.force)

        self._steep = secant(excess, share * size, self._steep, _CLOSE_ENOUGH * size, 0.0)
        return found[0]

    def _to(self, end: float, drive: Callable[[float], float], guess: float) -> tuple[float, Trial]:
        """Travel up to a time."""
        found: list[Trial] = []

        def excess(travel: float) -> float:
            found[:] = [self._try(travel, end)]
            at[:] = [travel]
            return self._spring * (drive(end) - self._place - travel) - found[0].force

        at: list[float] = []
        secant(excess, guess, -self._spring - 1.0, _CLOSE_ENOUGH * self._length)
        return at[0], found[0]

    def _falls(
        self, travel: float, at: float, trial: Trial | None, track: Track, clock: Clock, sign: float
    ) -> float:
        """Of the sign of F'(X) + K after such a step."""
        if not self._fuzzy:
            beyond = self._try(travel, at) if trial is None else trial
            return self._force_slope(sign, beyond) + self._spring
        # the drive has come furthest: time as a function of the step, whose last slope is asked for
        begin = clock.count(track.clock[-1])
        now = clock.count(at) - begin
        size = min(_SLOPE_NODES, len(track.step))
        nodes = np.array([*track.step[-size:], track.step[-1] + sign * travel / self._length + now])
        counts = np.array([*(clock.count(one) - begin for one in track.clock[-size:]), now])
        apart = nodes[:, None] - nodes
        np.fill_diagonal(apart, 1.0)
        weights = 1.0 / apart.prod(axis=1)
        slopes = weights[:-1] / weights[-1] / (nodes[-1] - nodes[:-1])
        return float(slopes @ (counts[:-1] - now)) - self._runs

    # -- slips ---------------------------------------------------------------------------------------------------------
    def _onset(
        self, travel: float, drive: Callable[[float], float], track: Track, clock: Clock, sign: float, close: float
    ) -> tuple[float, float]:
        """Travel and time at which F' = -K, within a step that goes beyond; to so large a part of the step."""

        def slope(way: float) -> float:
            now = self._when(way, drive, clock, sign)
            if self._fuzzy and clock.count(now) - clock.count(self._now) < 2.0 * _NO_TIME:
                return -1.0  # the drive would have to come back
            return self._falls(way, now, None, track, clock, sign)

        low, high = _LEAST_WAY * travel if self._fuzzy else 0.0, travel
        way = high
        if slope(high) <= 0.0:
            way = low  # by rounding, or by what a coarse step before it has wrong
            if slope(low) > 0.0:
                way = float(brentq(slope, low, high, xtol=close * abs(travel), rtol=1e-12))
        return way, self._when(way, drive, clock, sign)

    def _when(self, way: float, drive: Callable[[float], float], clock: Clock, sign: float) -> float:
        """Time at which a travel balances the drive; now, where it did before."""
        begin = clock.count(self._now)
        # motion in no time is a limit that thresholds about to be met know nothing of
        least = _NO_TIME if self._fuzzy else 0.0

        asked = [least, 0.0]

        def excess(count: float) -> float:
            now = max(clock.time(begin + count), self._now)
            asked[:] = [count, sign * (self._spring * (drive(now) - self._place - way) - self._try(way, now).force)]
            return asked[1]

        if (short := excess(least)) >= 0.0:
            return clock.time(begin + least) if least else self._now
        rise = secant(excess, -short / self._rise, self._rise, _CLOSE, least)
        if abs(asked[1]) <= _BALANCED * self._unit:  # where births jump, secants need not end
            self._rise = rise
            return clock.time(begin + asked[0])
        span = max(2.0 * _CLOSE, -1.5 * short / self._rise)
        for _ in range(_DOUBLINGS):
            if (over := excess(span)) >= 0.0:
                break
            span *= 2.0
        else:
            raise TooLong
        if over > _ROUNDING * self._unit * (1.0 + self._spring):  # else a step ends where it should
            span = float(brentq(excess, least, span, xtol=_CLOSE, rtol=1e-14))
        return clock.time(begin + span)

    def _slip(self, drive: float, sign: float) -> None:
        before, force = self._place, self._force
        if self._rule == "reset":
            lives = self._again()
            self._place = drive - float(lives.pull[0]) / self._spring
            self._settle(lives)
        elif self._rule == "instant" and not self._delay:
            self._rush(drive, sign)
        else:
            self._hold_out(drive, sign)
        self.slips.append(Slip(drive, before, self._place, force, self._force))

    def _rush(self, drive: float, sign: float) -> None:
        """Contacts re-form at once, on to the first balance."""
        number = len(self.stretches)
        planned = self._plan[number] if number < len(self._plan) else 0.0
        steps = int(np.ceil(max(planned, 1e-6))) * 2**self._level
        size = sign * self._length * (planned / steps if planned else 0.5**self._level)
        self._bend()
        begin = self._place
        away = not self._thin

        def excess(travel: float) -> float:
            trial = self._try(travel, self._now)
            return sign * (trial.force - self._spring * (drive - self._place - travel))

        while True:
            trial = self._try(size, self._now)
            over = sign * (trial.force - self._spring * (drive - self._place - size))
            if over >= 0.0 and (away or abs(self._place - begin) > self._unit):
                break
            away |= over < 0.0
            self._take(trial, size, self._now)
        low = 0.0 if self._place != begin else _BESIDE * size
        last = float(brentq(excess, low, size, xtol=1e-15 * self._unit, rtol=1e-14)) if excess(low) < 0.0 else low
        self._take(self._try(last, self._now), last, self._now)
        self.stretches.append(abs(self._place - begin) / self._length)
        self._bend()

    def _hold_out(self, drive: float, sign: float) -> None:
        """Broken contacts stay out until the rest balance the spring."""

        def excess(travel: float) -> float:
            trial = self._try(travel, self._now, frozen=True)
            return sign * (trial.force - self._spring * (drive - self._place - travel))

        step = sign * _SCAN * self._length * 0.5
        low, high = _BESIDE * step, step
        away = not self._thin
        for _ in range(_MOST_STEPS):
            over = excess(high)
            if over >= 0.0 and (away or abs(high) > self._unit):
                break
            away |= over < 0.0
            low, high = high, high + step
        else:
            raise TooLong
        travel = float(brentq(excess, low, high, xtol=1e-15 * self._unit, rtol=1e-14)) if excess(low) < 0.0 else low
        broken = self._breaks[-1]
        self._bend()
        trial = self._try(travel, self._now, frozen=True)
        self._take(trial, travel, self._now)
        self._bend()
        fresh = trial.breaks - broken
        self._mark_later(self._now, fresh)
        if not self._delay:
            self._born_at_once(fresh, self._breaks[-1])
