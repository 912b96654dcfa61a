"""Steps: one step of a slider that a spring pulls, K (X_T - X) = F, and where a slip begins.

The size of a step combines X and time, dX/length + d(uniform steps of time). So steps are uniform both
where the slider creeps and just before a slip, where dX/dt diverges while X_T is smooth in X. The
slip begins where X_T, as a function of X, has its maximum: there the force falls as fast as the
spring's.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.interpolate import KroghInterpolator
from scipy.optimize import brentq
from scipy.special import wrightomega

from master.soft.in_time.cohorts import Cohorts, Trial
from master.soft.in_time.pieces import Piece
from master.soft.slips import StoppedError

# A step on the coarsest level, as a share of the length over which births change.
COARSEST = 0.5
# Weight of the drive's travel in the size of a step, relative to the slider's, which matters more.
LESS = 0.25
# Accuracy of a balance just before a slip, as a share of a step's time; and the time that counts as
# none, as a share of a step: in exactly none, diffusing thresholds cannot break.
CLOSE, NO_TIME = 1e-10, 1e-11


class StepCount:
    """Count of steps: uniform in time, and after a bend, where changes slow down, in its logarithm.

    Parameters
    ----------
    begin, end : float
        Times of two consecutive bends.
    held : bool
        Whether the drive holds.
    rate : float
        Uniform steps per time.
    first : float
        The shortest time over which contacts change after a bend; inf where nothing changes then.
    """

    def __init__(self, begin: float, end: float, held: bool, rate: float, first: float) -> None:
        self._begin, self._rate = begin, rate
        lasts = end - begin
        self._first = min(first, lasts)
        # steps in which the time since a bend grows by a factor e: while the drive holds; and while
        # it moves, in addition to the steps of its travel
        per_fold = 2.0 if held else 0.4
        self._folds = per_fold if held or first < lasts else 0.0

    def steps(self, time: float) -> float:
        """Steps since the beginning."""
        later = time - self._begin
        folds = float(np.log1p(later / self._first)) if self._folds else 0.0
        return self._rate * later + self._folds * folds

    def time(self, steps: float) -> float:
        """The time after so many steps."""
        if not self._folds:
            return self._begin + steps / self._rate
        folds, even = steps / self._folds, self._rate * self._first / self._folds
        if not even:
            return self._begin + self._first * float(np.expm1(min(folds, 700.0)))
        # even u + log(1 + u) = folds
        grown = float(wrightomega(folds + even + np.log(even)).real) / even
        return self._begin + self._first * (grown - 1.0)


class Node(NamedTuple):
    """The end of a step: the size of all steps so far of its smooth section, time, force and holding."""

    size: float
    time: float
    force: float
    holding: float


class Steps:
    """Steps of contacts along one piece of the drive's path.

    Parameters
    ----------
    contacts : Cohorts
    spring : float
        K/(N_c <k>).
    close : float
        Accuracy of a step's balance, as a share of the step.
    """

    def __init__(self, contacts: Cohorts, spring: float, close: float) -> None:
        self.contacts, self._spring, self._close = contacts, spring, close
        self.scales = contacts.memory.scales
        self.length = COARSEST * self.scales.length
        # guesses of how fast the imbalance grows with the uniform steps, in a step and at one place
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
        self._count = StepCount(self.contacts.now, end, held, even, self.scales.time)

    def counted(self, now: float) -> float:
        """Uniform steps of time from the contacts' time to `now`."""
        return self._count.steps(now) - self._count.steps(self.contacts.now)

    def size(self, trial: Trial) -> float:
        """The size of a step."""
        return self.counted(trial.now) + self.sign * trial.travel / self.length

    def imbalance(self, trial: Trial) -> float:
        """The spring's force minus that of the contacts, along the motion."""
        ahead = self.piece.at(trial.now) - self.contacts.place - trial.travel
        return self.sign * (self._spring * ahead - trial.force)

    def _try(self, travel: float, now: float) -> float:
        """The imbalance after a trial step, which is kept."""
        self._trial = self.contacts.trial(travel, now)
        return self.imbalance(self._trial)

    def _later(self, steps: float) -> float:
        """The time after so many uniform steps, and not before now."""
        now = self.contacts.now
        return max(self._count.time(self._count.steps(now) + steps), now)

    def step(self, size: float, share: float) -> Trial:
        """A balanced step of this size; if there is none, one that takes no time.

        share : expected share of the time in the size
        """

        def imbalance(steps: float) -> float:
            return self._try(self.sign * self.length * (size - steps), self._later(steps))

        self._steep = secant(imbalance, share * size, self._steep, self._close * size, 0.0)
        return self._trial

    def step_to(self, end: float, guess: float) -> Trial:
        """A balanced step up to the time `end`, from a guess of its travel."""

        def imbalance(way: float) -> float:
            return self._try(self.sign * way, end)

        secant(imbalance, self.sign * guess, -self._spring - 1.0, self._close * self.length)
        return self._trial

    def step_by(self, travel: float) -> Trial:
        """The step by a travel up to the time of balance; in no time if that has passed."""

        def imbalance(steps: float) -> float:
            return self._try(travel, self._later(steps))

        missing = -imbalance(NO_TIME)
        if missing <= 0.0:
            return self._trial
        low, high = NO_TIME, max(2.0 * CLOSE, 1.1 * missing / self._rise)
        for _ in range(60):
            if imbalance(high) >= 0.0:
                self._rise = missing / brentq(imbalance, low, high, xtol=CLOSE)
                return self._trial
            low, high = high, 2.0 * high
        raise StoppedError("no steps were found that follow the slider")

    def slip_begins(self, trial: Trial, size: float) -> bool:
        """Whether a slip begins within a step of this size."""
        if trial.now <= self.contacts.now:
            return True
        # while slider and drive move alike, the time's share of the size is some LESS; it is far
        # below where the slider runs ahead
        return self.counted(trial.now) < 0.3 * LESS * size and self._drive_slope(trial) <= 0.0

    def _drive_slope(self, trial: Trial) -> float:
        """Derivative of the uniform steps by the size of steps, at the end of a step."""
        last = self._nodes[-5:]
        sizes = [*(node.size for node in last), last[-1].size + self.size(trial)]
        steps = [self.counted(time) for time in (*(node.time for node in last), trial.now)]
        return float(KroghInterpolator(sizes, steps).derivative(sizes[-1]))

    def up_to_slip(self, travel: float) -> Trial:
        """The step up to the beginning of a slip, within a step that goes beyond it."""

        def slope(way: float) -> float:
            trial = self.step_by(way)
            # no balance: the drive would have to move back
            return -1.0 if self.counted(trial.now) < 2.0 * NO_TIME else self._drive_slope(trial)

        way = low = 0.01 * travel  # an earlier beginning counts as this
        if slope(travel) > 0.0:
            way = travel  # possible by the error of a coarse step before
        elif slope(low) > 0.0:
            way = float(brentq(slope, low, travel, xtol=self._close * abs(travel)))
        return self.step_by(way)


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
    for _ in range(40):
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
