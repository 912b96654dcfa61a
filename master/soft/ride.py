"""Ride: a soft slider along the whole path of its drive, move after move and slip after slip."""

from __future__ import annotations

import time as clock

import numpy as np
import numpy.typing as npt

from master.soft.curve import Curve
from master.soft.pull import Held, Matter, Past, Pull, StoppedError
from master.soft.slips import Followed, LettingGo, Slips, landing, letting_go
from origins.drive import Drive

Array = npt.NDArray[np.float64]


class Ride:
    """A soft slider pulled by a drive along its path (paper, Eq. Q16x2).

    Attributes
    ----------
    balance : float
        X_T at which the spring balances the starting force (a length).
    position, force : arrays of shape (n,)
        X and F at the points of the drive's path (lengths).
    slips : list of arrays of shape (5,)
        X_T, X before and after, F before and after.
    told : int
        Number of points, from the first, that were solved: all unless work or time ran out.
    error : float
        Bound on the errors of the force and of K X_T at slips (a length).
    drive_error : float
        Bound on the error of X_T at slips (a length).
    """

    def __init__(self, matter: Matter, drive: Drive) -> None:
        """Balance the spring with the force of the start, at X = 0."""
        self.matter, self.rule, path = matter, drive.slip, drive.path
        self.path, self.spring = path, float(drive.spring or 0.0)
        spring = self.spring
        start = matter.force_of(matter.start)
        self.balance, self._rest = start / spring, matter.force_of(matter.again)
        self.position, self.force = np.zeros(path.size), np.full(path.size, start)
        self.slips = list[Array]()
        self.error = self.drive_error = 0.0
        # X at which the history in `_last` begins, and the error of that X
        self._base, self._shift = 0.0, 0.0
        self._last, self._relaxed = (matter, Past()), matter.relaxed()
        self._fresh: dict[int, Pull] = {}  # moves from all contacts just re-formed, by direction
        steps = np.diff(path, prepend=self.balance)
        # a first point this near the balance, in mean thresholds, counts as the balance
        if abs(steps[0]) <= 1e-12 * matter.unit:
            steps[0] = 0.0
        moving = np.flatnonzero(steps)
        signs = np.sign(steps[moving])
        begins = np.append(0, moving[1:][np.diff(signs) != 0.0])
        self.told = 0 if moving.size else path.size
        try:
            for begin, end in zip(begins, np.append(begins[1:], path.size), strict=True):
                if moving.size:
                    sign = signs[np.searchsorted(moving, begin)]
                    self._move(int(sign), np.arange(begin, end))
        except StoppedError:
            pass

    def found(self) -> Followed:
        """The results, with an error that is a length."""
        told, over = self.told, "as slips ask for too much work"
        if self.matter.crowded or self._relaxed.crowded:
            over = "as exact thresholds break together more often than can be followed"
        return Followed(
            balance=self.balance,
            position=self.position[:told],
            force=self.force[:told],
            holding=np.ones(told),
            slips=Slips.of(self.slips, self.drive_error),
            error=self.error,
            nodes=self.matter.nodes + self._relaxed.nodes,
            over=over,
        )

    def _move(self, direction: int, points: npt.NDArray[np.intp]) -> None:
        """Follow the drive in one direction over points of its path, with all slips on the way."""
        end = direction * float(self.path[points[-1]])
        matter, past = self._last
        pull = Pull(matter, direction, past)
        if past.march is None and matter.start.span == matter.again.span == (0.0, 0.0):
            self._fresh[direction] = pull
        while True:
            begin = direction * (self._base + pull.at(0.0))
            target, y = self.spring * (end - begin), 0.0
            go = letting_go(pull, self.spring, y, target)
            while True:
                loads = self.spring * (direction * self.path[points] - begin)
                count = int(np.searchsorted(loads, go.level))
                self._answer(pull, go, points[:count], loads[:count], y)
                points = points[count:]
                if not go.slips:
                    y = float(go.curve.carries(np.array([target]), y, go.curve.end)[0])
                    self._last = pull.matter, pull.after(y, self._turn_error(go.curve, y))
                    return
                if self.rule != "instant":
                    break
                curve, y = landing(pull, self.spring, go.travel, go.level, go.beside)
                self._note(pull, go, begin, begin + y, curve.force_at(y))
                go = letting_go(pull, self.spring, y, target)
            jump = self._reset if self.rule == "reset" else self._reform_after
            pull = jump(pull, go, begin)

    def _answer(
        self, pull: Pull, go: LettingGo, points: npt.NDArray[np.intp], loads: Array, low: float
    ) -> None:
        """Set X and F at points before the next slip, where the load has these values."""
        if points.size:
            y = go.curve.carries(loads, low, min(go.travel, go.curve.end))
            self.position[points] = self._base + pull.at(y)
            self.force[points] = pull.direction * go.curve.force(y)
            self.told = max(self.told, int(points.max()) + 1)
            off = self.spring * go.curve.misplaced(y, self._shift)
            self.error = max(self.error, float(off.max()))

    def _turn_error(self, curve: Curve, y: float) -> float:
        """Error of the force after a turn, from that of its place, where F' jumps to 1."""
        at = np.array([y])
        bends = abs(1.0 + self.spring - float(curve.slope(at)[0]))
        error = float(curve.error[curve.panel(at)[0]])
        return error + bends * float(curve.misplaced(at, self._shift)[0])

    def _reset(self, pull: Pull, go: LettingGo, begin: float) -> Pull:
        """Slip: all contacts re-form, and the slider moves to where the spring balances them."""
        rest = pull.direction * self._rest
        after = begin + (go.level - rest) / self.spring
        self._note(pull, go, begin, after, rest)
        self._base = pull.direction * after
        self._shift += go.error / self.spring
        if pull.direction not in self._fresh:
            self._fresh[pull.direction] = Pull(self._relaxed, pull.direction, Past())
        return self._fresh[pull.direction]

    def _reform_after(self, pull: Pull, go: LettingGo, begin: float) -> Pull:
        """Slip in which broken contacts stay out until the slider stops."""
        spring, d = self.spring, pull.direction
        held = Held(pull.matter, d, pull.after(go.travel, go.error))
        curve, y = landing(held, spring, 0.0, go.level - spring * go.travel, go.beside)
        after = begin + go.travel + y
        self._note(pull, go, begin, after, curve.force_at(y))
        # share of contacts misjudged as out or as holding, by the error of where the slip begins
        error = (1.0 + spring) * go.misplaced * y / self.matter.unit
        landed = np.array([y])
        self._shift += float(curve.misplaced(landed, 0.0, go.error + error)[0])
        # errors of the history do not affect contacts that broke
        error += float(curve.error[curve.panel(landed)[0]])
        error *= held.holding(y)
        return Pull(pull.matter, d, held.stands(y, error))

    def _note(self, pull: Pull, go: LettingGo, begin: float, after: float, force: float) -> None:
        """Record a slip, of a move that begins at `begin`, with X and F after it along the motion."""
        drive = begin + go.level / self.spring
        row = drive, begin + go.travel, after, go.curve.force_at(go.travel), force
        self.slips.append(pull.direction * np.array(row))
        self.drive_error = max(self.drive_error, go.error / self.spring + self._shift)
        self.error = max(self.error, self.spring * self.drive_error)
        # at most 20,000 slips, each of which takes some 1 ms
        if len(self.slips) > 20_000 or clock.monotonic() > self.matter.until:
            raise StoppedError
