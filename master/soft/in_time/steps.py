"""Steps: one step of a slider that a spring pulls, K (X_T - X) = F, and where a slip begins.

The size of a step combines X and time, dX/length + d(count of the clock). So steps are uniform both
where the slider creeps and just before a slip, where dX/dt diverges while X_T is smooth in X. The
slip begins where X_T, as a function of X, has its maximum: there the force falls as fast as the
spring's.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.interpolate import KroghInterpolator
from scipy.optimize import brentq

from master.soft.in_time.carried import Carried, TooLongError, Trial
from master.soft.in_time.track import Clock, Node, Piece

# A step on the coarsest level, as a share of the length over which births change.
COARSEST = 0.5
# Weight of the drive's travel in the size of a step, relative to the slider's, which matters more.
LESS = 0.25
# Share of the time in the size of a step below which the slider runs ahead of its drive: while they
# move alike it is some LESS. Share of a step from which on the beginning of a slip is searched; and
# nodes of the polynomial for the derivative of the drive's clock.
SHORT, LEAST_WAY, SLOPE_NODES = 0.3 * LESS, 0.01, 5
# Accuracy of a balance just before a slip, as a share of a step's time; largest residual force of a
# balance, in mean thresholds; most doublings of the time to find one.
CLOSE, BALANCED, DOUBLINGS = 1e-10, 1e-9, 60
# Time that counts as none, as a share of a step: in exactly none, diffusing thresholds cannot break.
NO_TIME = 1e-11
ITERATIONS = 40  # most steps of the secant method


class Steps:
    """Steps of contacts along one piece of the drive's path.

    Parameters
    ----------
    contacts : Carried
    spring : float
        K/(N_c <k>).
    close : float
        Accuracy of a step's balance, as a share of the step.
    """

    def __init__(self, contacts: Carried, spring: float, close: float) -> None:
        self.contacts, self._spring, self._close = contacts, spring, close
        self.scales = contacts.memory.scales
        self.length = COARSEST * self.scales.length
        # first guesses of how fast the spring's force minus F grows with the count of the clock
        self._steep = (1.0 + spring) * (1.0 + 1.0 / LESS) * self.length
        self._rise = (1.0 + spring) * self.length / LESS

    def begin(self, piece: Piece) -> None:
        """Begin a piece of the drive's path."""
        self.piece = piece
        self.sign = float(np.sign(piece.travel) or np.sign(self.contacts.force) or 1.0)

    def start(self, end: float, nodes: list[Node]) -> None:
        """Begin a smooth section, whose steps end at `nodes`; the next bend is at `end`."""
        self._nodes, piece, spring = nodes, self.piece, self._spring
        # while contacts hold, the slider moves K/(1 + K) times as fast as the drive
        even = self.scales.rate / COARSEST
        even += LESS * piece.speed * spring / (self.length * (1.0 + spring))
        held = piece.travel == 0.0
        even = 0.0 if held else even
        self.clock = Clock(self.contacts.now, end, held, even, self.scales.time)

    def counted(self, now: float) -> float:
        """Steps of the clock from the contacts' time to `now`."""
        return self.clock.count(now) - self.clock.count(self.contacts.now)

    def size(self, trial: Trial) -> float:
        """The size of a step."""
        return self.counted(trial.now) + self.sign * trial.travel / self.length

    def lack(self, trial: Trial) -> float:
        """The spring's force minus that of the contacts, along the motion."""
        ahead = self.piece.at(trial.now) - self.contacts.place - trial.travel
        return self.sign * (self._spring * ahead - trial.force)

    def _later(self, count: float) -> float:
        """The time after so many steps of the clock, and not before now."""
        now = self.contacts.now
        return max(self.clock.time(self.clock.count(now) + count), now)

    def step(self, size: float, share: float) -> Trial:
        """A balanced step of this size; if there is none, one with a time before now.

        share : expected share of the time in the size
        """
        here = self.contacts

        def lack(count: float) -> float:
            trial = here.tried(self.sign * self.length * (size - count), self._later(count))
            self._found = trial if count > 0.0 else trial._replace(now=here.now - 1.0)
            return self.lack(trial)

        self._steep = secant(lack, share * size, self._steep, self._close * size, 0.0)
        return self._found

    def _lacking(self, trial: Trial) -> float:
        self._found = trial
        return self.lack(trial)

    def to(self, end: float, guess: float) -> Trial:
        """A balanced step up to the time `end`."""

        def lack(way: float) -> float:
            return self._lacking(self.contacts.tried(self.sign * way, end))

        secant(lack, self.sign * guess, -self._spring - 1.0, self._close * self.length)
        return self._found

    def past(self, trial: Trial, size: float) -> bool:
        """Whether a slip begins within a step."""
        if trial.now <= self.contacts.now:
            return True
        return self.counted(trial.now) < SHORT * size and self._drive_slope(trial) <= 0.0

    def _drive_slope(self, trial: Trial) -> float:
        """Derivative of the clock by the size of steps, at the end of a step, by interpolation."""
        last = self._nodes[-SLOPE_NODES:]
        steps = [*(node.step for node in last), last[-1].step + self.size(trial)]
        counts = [self.counted(time) for time in (*(node.clock for node in last), trial.now)]
        return float(KroghInterpolator(steps, counts).derivative(steps[-1]))

    def onset(self, travel: float) -> Trial:
        """The step up to the beginning of a slip, within a step that goes beyond it."""

        def slope(way: float) -> float:
            trial = self.balanced(way)
            # no balance: the drive would have to move back
            return -1.0 if self.counted(trial.now) < 2.0 * NO_TIME else self._drive_slope(trial)

        way = low = LEAST_WAY * travel
        if slope(travel) > 0.0:
            way = travel  # possible by the error of a coarse step before
        elif slope(low) > 0.0:
            way = float(brentq(slope, low, travel, xtol=self._close * abs(travel)))
        return self.balanced(way)

    def balanced(self, way: float) -> Trial:
        """The step by a travel `way` up to the time of balance; in no time if that has passed."""

        def lack(count: float) -> float:
            return self._lacking(self.contacts.tried(way, self._later(count)))

        short = lack(NO_TIME)
        if short >= 0.0:
            return self._found
        rise = secant(lack, -short / self._rise, self._rise, CLOSE, NO_TIME)
        if abs(self.lack(self._found)) <= BALANCED * self.contacts.unit:
            self._rise = rise
            return self._found
        # where births jump, the secant method may fail: bracket the root
        most = max(2.0 * CLOSE, -1.5 * short / self._rise)
        for _ in range(DOUBLINGS):
            if lack(most) >= 0.0:
                brentq(lack, NO_TIME, most, xtol=CLOSE)
                return self._found
            most *= 2.0
        raise TooLongError


def secant(
    function: Callable[[float], float],
    guess: float,
    slope: float,
    close: float,
    least: float = -np.inf,
) -> float:
    """Find a root by the secant method, from guesses of it and of the slope there; returns the slope.

    The function's last call is at the root, or at `least` where an increasing function has no root
    above. A secant step that leaves the bracket of the root is replaced by bisection.
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
        # the next correction would be below the required accuracy
        if rises * slope > 0.0 and abs(fb / slope) <= close:
            break
        a, fa = b, fb
    return slope if rises * slope > 0.0 else given
