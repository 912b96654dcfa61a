"""Steps: one step of a slider that a spring pulls, K (X_T - X) = F, and where the spring lets go.

A step is so long in X and in time together, dX/length + d(count of the clock), that it is even where
the slider creeps and where it runs ahead of a slip, in which dX/dt grows without end: there X_T is
smooth in X. The slider lets go where X_T, as a function of X, has come furthest: where the force
falls as fast as the spring's.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.interpolate import KroghInterpolator
from scipy.optimize import brentq

from master.soft.in_time.carried import Carried, TooLongError, Trial
from master.soft.in_time.track import Clock, Piece, Track

# A step on the coarsest level, as a share of the length over which births change.
COARSEST = 0.5
# What the way of the drive counts less than that of the slider in a step: it is the slider that must
# be followed.
LESS = 0.25
# Share of a step from which on it is looked for where the slider lets go, and nodes of the polynomial
# that tells how the drive goes on.
LEAST_WAY, SLOPE_NODES = 0.01, 5
# Share of a step's time to which a balance is found where the slider is about to let go.
CLOSE = 1e-10
# Force left over, in mean thresholds, of a balance; and doublings of the time in which to find one.
BALANCED, DOUBLINGS = 1e-9, 60
# A time that is none, as a share of a step: in truly none thresholds that fluctuate are not met.
NO_TIME = 1e-11
ITERATIONS = 40  # of secants
Function = Callable[[float], float]


class Steps:
    """Steps of contacts along one piece of the drive's way.

    Parameters
    ----------
    contacts : Carried
    spring : float
        K/(N_c <k>).
    unit : float
        Mean threshold (a length).
    close : float
        Share of a step to which its balance is found.
    """

    def __init__(self, contacts: Carried, spring: float, unit: float, close: float) -> None:
        self.contacts, self._spring, self._unit, self._close = contacts, spring, unit, close
        self.scales = contacts.cohorts.memory.scales
        self.length = COARSEST * self.scales.length
        # how fast the spring's force less F grows with the count of the clock
        self._steep = (1.0 + spring) * (1.0 + 1.0 / LESS) * self.length
        self._rise = (1.0 + spring) * self.length / LESS

    def begin(self, piece: Piece) -> None:
        """The drive begins a piece of its way."""
        self.piece = piece
        self.sign = float(np.sign(piece.travel) or np.sign(self.contacts.force) or 1.0)

    def start(self, end: float, track: Track) -> None:
        """A smooth stretch begins, the next bend being at `end`."""
        self._track, piece, spring = track, self.piece, self._spring
        # while contacts hold, the slider follows a soft spring's drive from far
        even = self.scales.rate / COARSEST
        even += LESS * piece.speed * spring / (self.length * (1.0 + spring))
        held = piece.travel == 0.0
        even = 0.0 if held else even
        self.clock = Clock(self.contacts.now, end, held, even, self.scales.time)

    def size(self, trial: Trial) -> float:
        """Of a step."""
        time = self.clock.count(trial.now) - self.clock.count(self.contacts.now)
        return time + self.sign * trial.travel / self.length

    def lack(self, trial: Trial) -> float:
        """By how much the spring pulls more than the contacts hold, along the motion."""
        ahead = self.piece.at(trial.now) - self.contacts.place - trial.travel
        return self.sign * (self._spring * ahead - trial.force)

    def step(self, size: float, share: float) -> Trial:
        """A step of this size; at a time before now where there is none.

        share : of the size, what time is expected to take
        """
        here, clock = self.contacts, self.clock
        begin = clock.count(here.now)
        found: list[Trial] = []

        def lack(count: float) -> float:
            now = max(clock.time(begin + count), here.now)
            trial = here.tried(self.sign * self.length * (size - count), now)
            found[:] = [trial if count > 0.0 else trial._replace(now=here.now - 1.0)]
            return self.lack(trial)

        self._steep = secant(lack, share * size, self._steep, self._close * size, 0.0)
        return found[0]

    def to(self, end: float, guess: float) -> Trial:
        """A step up to a time."""
        here, spring = self.contacts, self._spring
        found: list[Trial] = []

        def lack(travel: float) -> float:
            found[:] = [here.tried(travel, end)]
            return self.sign * self.lack(found[0])

        secant(lack, guess, -spring - 1.0, self._close * self.length)
        return found[0]

    def past(self, trial: Trial, size: float) -> bool:
        """Whether the slider has let go by the end of a step."""
        # it runs ahead of its drive before
        time = self.clock.count(trial.now) - self.clock.count(self.contacts.now)
        # share of a step's usual time that it takes where the slider may be about to let go
        return time < 0.3 * LESS * size and self._drive_slope(trial) <= 0.0

    def _drive_slope(self, trial: Trial) -> float:
        """How fast the drive goes on at the end of a step, by a polynomial through those before."""
        track, count = self._track, self.clock.count
        steps = [*track.step[-SLOPE_NODES:], track.step[-1] + self.size(trial)]
        counts = [*map(count, track.clock[-SLOPE_NODES:]), count(trial.now)]
        return float(KroghInterpolator(steps, counts).derivative(steps[-1]))

    def onset(self, travel: float) -> Trial:
        """The step that ends where the slider lets go, within one that goes beyond."""
        here = self.contacts

        def slope(way: float) -> float:
            trial = self.balanced(way)
            # else the drive would have to come back
            gone = self.clock.count(trial.now) - self.clock.count(here.now)
            return -1.0 if gone < 2.0 * NO_TIME else self._drive_slope(trial)

        way, low = travel, LEAST_WAY * travel
        if slope(travel) <= 0.0:
            way = low  # by rounding, or by what a coarse step before it has wrong
            if slope(low) > 0.0:
                way = float(brentq(slope, low, travel, xtol=self._close * abs(travel)))
        return self.balanced(way)

    def balanced(self, way: float) -> Trial:
        """The step by a travel until it balances the drive; in no time, where it did before."""
        here, clock = self.contacts, self.clock
        begin = clock.count(here.now)
        found: list[Trial] = []

        def lack(count: float) -> float:
            found[:] = [here.tried(way, max(clock.time(begin + count), here.now))]
            return self.lack(found[0])

        short = lack(NO_TIME)
        if short >= 0.0:
            return found[0]
        rise = secant(lack, -short / self._rise, self._rise, CLOSE, NO_TIME)
        if abs(self.lack(found[0])) <= BALANCED * self._unit:
            self._rise = rise
            return found[0]
        # where births jump secants need not end
        most = max(2.0 * CLOSE, -1.5 * short / self._rise)
        for _ in range(DOUBLINGS):
            if lack(most) >= 0.0:
                brentq(lack, NO_TIME, most, xtol=CLOSE)
                return found[0]
            most *= 2.0
        raise TooLongError


def secant(
    function: Function, guess: float, slope: float, close: float, least: float = -np.inf
) -> float:
    """Ask for the root by secants from guesses of it and of the slope there, which is returned.

    Asked last is the root, or `least` where a function that rises has none above. Where the
    function turns on the way secants may leave what is known to hold the root: then that is halved.
    """
    given, rises = slope, float(np.sign(slope))
    low, high = -np.inf, np.inf
    a, fa = guess, function(guess)
    if abs(fa / slope) <= close and a >= least:
        return slope
    for _ in range(ITERATIONS):
        low, high = (max(low, a), high) if rises * fa < 0.0 else (low, min(high, a))
        b = max(a - fa / slope, least) if slope != 0.0 else np.inf
        if not low < b < high and np.isfinite(high - low):
            b = 0.5 * (low + high)
        fb = function(b)
        if abs(b - a) <= close or (b == least and fb >= 0.0) or fb == 0.0:
            break
        if fb != fa:
            slope = (fb - fa) / (b - a)
        # what is left is the error of the slope, not worth another step
        if rises * slope > 0.0 and abs(fb / slope) <= close:
            break
        a, fa = b, fb
    return slope if rises * slope > 0.0 else given
