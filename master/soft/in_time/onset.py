"""Onset: where a soft slider lets go of its drive."""

from __future__ import annotations

import numpy as np

from master.soft.in_time.carried import Carried, TooLongError, Trial
from master.soft.in_time.secants import first_root, secant
from master.soft.in_time.track import LESS, Clock, Piece, Track

# How many times as fast as its drive the slider is at least where it lets go, where heat breaks the
# weakest before they are met.
FAST = 100.0
# Nodes of the polynomial that tells how the slider outruns its drive.
SLOPE_NODES = 5
# Motion in no time is a limit that thresholds about to be met know nothing of: the least time, as
# a share of a step.
NO_TIME = 1e-11
# Shares of a step's time to which a balance is found; where births jump secants need not end.
CLOSE, ALSO_CLOSE = 1e-10, 1e-7
# Forces left over, in mean thresholds: for a balance, and as rounding.
BALANCED, ROUNDING = 1e-9, 1e-12
DOUBLINGS = 60
# Share of a step that the slider goes on at least, where thresholds fluctuate.
LEAST_WAY = 0.01


class Onset:
    """Where contacts let go of a slider that a drive pulls by its spring.

    Attributes
    ----------
    thin : bool
        Whether the weakest contacts break by themselves before they are met, in a skin of
        thresholds that the slider crosses in a time: they give way the later the faster it is, and
        X_T comes to a stand only little by little.
    fuzzy : bool
        Whether none stand right at their thresholds, so that motion in no time breaks none.
    """

    def __init__(
        self, contacts: Carried, spring: float, unit: float, length: float, fastest: float
    ) -> None:
        steps = contacts.cohorts.steps
        self._contacts, self._spring, self._unit, self._length = contacts, spring, unit, length
        self.thin = steps.skin > fastest * steps.time
        self.fuzzy = steps.fuzzy or self.thin
        # where heat moves the slip itself by more, nothing is gained by waiting longer
        fast = max(FAST, float(np.sqrt(unit / steps.skin))) if self.thin else np.inf
        self._runs = LESS * spring / (1.0 + spring) / fast
        self._rise = (1.0 + spring) * length / LESS

    def at_once(self, sign: float) -> bool:
        """Whether the slider lets go where it stands."""
        return not self.fuzzy and self._contacts.force_slope(sign) + self._spring <= 0.0

    def past(self, trial: Trial, track: Track, clock: Clock, sign: float) -> bool:
        """Whether the slider has let go by the end of a step."""
        return self._falls(trial, track, clock, sign) <= 0.0

    def _falls(self, trial: Trial, track: Track, clock: Clock, sign: float) -> float:
        """Of the sign of F'(X) + K after such a step."""
        if not self.fuzzy:
            return self._contacts.force_slope(sign, trial) + self._spring
        # the drive has come furthest: time as a function of the step, whose last slope is asked for
        begin = clock.count(track.clock[-1])
        now = clock.count(trial.now) - begin
        size = min(SLOPE_NODES, len(track.step))
        last = track.step[-1] + sign * trial.travel / self._length + now
        nodes = np.array([*track.step[-size:], last])
        counts = np.array([*(clock.count(one) - begin for one in track.clock[-size:]), now])
        apart = nodes[:, None] - nodes
        np.fill_diagonal(apart, 1.0)
        weights = 1.0 / apart.prod(axis=1)
        slopes = weights[:-1] / weights[-1] / (nodes[-1] - nodes[:-1])
        return float(slopes @ (counts[:-1] - now)) - self._runs

    def found(
        self, travel: float, piece: Piece, track: Track, clock: Clock, sign: float, close: float
    ) -> Trial:
        """The step that ends where the slider lets go, within one that goes beyond.

        close : share of the travel to which it is found
        """
        begin = self._contacts.now

        def slope(way: float) -> float:
            trial = self.balanced(way, piece, clock, sign)
            gone = clock.count(trial.now) - clock.count(begin)
            if self.fuzzy and gone < 2.0 * NO_TIME:
                return -1.0  # the drive would have to come back
            return self._falls(trial, track, clock, sign)

        low, way = (LEAST_WAY * travel if self.fuzzy else 0.0), travel
        if slope(travel) <= 0.0:
            way = low  # by rounding, or by what a coarse step before it has wrong
            if slope(low) > 0.0:
                way = first_root(slope, low, travel, close * abs(travel))
        return self.balanced(way, piece, clock, sign)

    def balanced(self, way: float, piece: Piece, clock: Clock, sign: float) -> Trial:
        """The step by a travel until it balances the drive; in no time, where it did before."""
        here, spring = self._contacts, self._spring
        begin = clock.count(here.now)
        least = NO_TIME if self.fuzzy else 0.0
        asked: list[tuple[float, float, Trial]] = []

        def excess(count: float) -> float:
            now = max(clock.time(begin + count), here.now)
            trial = here.tried(way, now)
            short = spring * (piece.at(now) - here.place - way) - trial.counted.force
            asked[:] = [(count, sign * short, trial)]
            return sign * short

        short = excess(least)
        if short >= 0.0:
            return asked[0][2]
        rise = secant(excess, -short / self._rise, self._rise, CLOSE, least)
        if abs(asked[0][1]) <= BALANCED * self._unit:
            self._rise = rise
            return asked[0][2]
        span = max(2.0 * CLOSE, -1.5 * short / self._rise)
        for _ in range(DOUBLINGS):
            if (over := excess(span)) >= 0.0:
                break
            span *= 2.0
        else:
            raise TooLongError
        if over > ROUNDING * self._unit * (1.0 + spring):  # else a step ends where it should
            excess(first_root(excess, least, span, CLOSE))
        return asked[0][2]
