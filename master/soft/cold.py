"""A soft slider at T = 0 along the whole path of its drive, move after move and slip after slip."""

import time as clock

import numpy as np
import numpy.typing as npt

from master.outcome import StoppedError
from master.soft.curve import LoadCurve, SlipBegin
from master.soft.moves import ColdContacts, Move, MoveWithoutBirths, Past
from master.soft.slips import MOST_SLIPS, Followed, Slips
from origins import Contacts
from origins.drive import Drive
from origins.thresholds.law import Array


class ColdSlider:
    """A soft slider pulled by a drive along its path (paper, Eq. Q16x2).

    contacts : without laws that depend on time
    tolerance : of the force, in mean thresholds; until : reading of time.monotonic() at which to stop
    """

    def __init__(self, contacts: Contacts, drive: Drive, tolerance: float, until: float) -> None:
        """Balance the spring with the force of the start, at X = 0."""
        self.rule, self.path, self.spring = drive.slip, drive.path, float(drive.spring or 0.0)
        self.contacts = cold = ColdContacts(contacts, self.spring, tolerance, until)
        self._start_force = cold.force_of(contacts.start)
        self._force_after_reset = cold.force_of(cold.formed_again)
        self.position = np.zeros(self.path.size)
        self.force = np.full(self.path.size, self._start_force)
        self.slips = list[Array]()
        # estimates from above of the errors of the force, and of X_T at slips (lengths)
        self.error = self.drive_error = 0.0
        # X at which the history `_past` begins, and the error of that X
        self._base, self._base_error = 0.0, 0.0
        self._past = Past(contacts.start)
        # moves from contacts that have all just formed again, by direction
        self._fresh: dict[int, Move] = {}

    def follow(self) -> Followed:
        """The results along the path, as far as work and time allow."""
        balance, unit, stopped = self._start_force / self.spring, self.contacts.unit, ""
        steps, each = np.diff(self.path, prepend=balance), np.arange(self.path.size)
        # a first point this near the balance, in mean thresholds, counts as the balance
        steps[0] = 0.0 if abs(steps[0]) <= 1e-12 * unit else steps[0]
        # a hold belongs to the move before it
        signs = np.sign(steps)[np.maximum.accumulate(np.where(steps, each, 0))].astype(int)
        self._solved = int(np.count_nonzero(signs == 0))
        try:
            for points in np.split(each, np.flatnonzero(np.diff(signs)) + 1):
                if signs[points[0]]:
                    self._move(int(signs[points[0]]), points)
        except StoppedError as why:
            stopped = str(why)
        drives, before, after, above, below = np.reshape(self.slips, (-1, 5)).T
        return Followed(
            balance=balance,
            position=self.position[: self._solved],
            force=self.force[: self._solved],
            holding=np.ones(self._solved),
            slips=Slips(drives, before, after, above, below, self.drive_error),
            error=max(self.error, self.spring * self.drive_error) / unit,
            nodes=self.contacts.nodes,
            stopped_because=stopped,
        )

    def _move(self, direction: int, points: npt.NDArray[np.intp]) -> None:
        """Follow the drive in one direction over points of its path, with all slips on the way."""
        end, formed_again = direction * float(self.path[points[-1]]), self.contacts.formed_again
        move = Move(self.contacts, direction, self._past)
        if self._past.march is None and self._past.start.span == formed_again.span == (0.0, 0.0):
            self._fresh[direction] = move
        y = 0.0
        while True:
            begin = direction * (self._base + move.at(0.0))
            target = self.spring * (end - begin)
            slip = move.slip_begins(y, target)
            loads = self.spring * (direction * self.path[points] - begin)
            count = int(np.searchsorted(loads, slip.load))
            self._answer(move, slip, points[:count], loads[:count], y)
            points = points[count:]
            if not np.isfinite(slip.load):
                y = float(slip.curve.travel_at(np.array([target]), y, slip.travel)[0])
                self._past = move.stopped(y, self._turn_error(slip.curve, y))
                return
            if self.rule == "instant":
                curve, y = move.slip_ends(slip.travel, slip.load, slip)
                self._note(move, slip, begin, begin + y, float(curve.force(y)))
            else:
                jump = self._reset if self.rule == "reset" else self._reform_after
                move, y = jump(move, slip, begin), 0.0

    def _answer(
        self, move: Move, slip: SlipBegin, points: npt.NDArray[np.intp], loads: Array, low: float
    ) -> None:
        """Set X and F at points before the next slip, where the load has these values."""
        if points.size:
            y = slip.curve.travel_at(loads, low, slip.travel)
            self.position[points] = self._base + move.at(y)
            self.force[points] = move.direction * slip.curve.force(y)
            self._solved = int(points[-1]) + 1
            off = self.spring * slip.curve.misplaced(y, self._base_error)
            self.error = max(self.error, float(off.max()))

    def _turn_error(self, curve: LoadCurve, y: float) -> float:
        """Error of the force after a turn, from that of its place, where F' jumps to 1."""
        bends = abs(1.0 + self.spring - float(curve.slope(y)))
        return float(curve.error_at(y) + bends * curve.misplaced(y, self._base_error))

    def _reset(self, move: Move, slip: SlipBegin, begin: float) -> Move:
        """Slip: all contacts re-form, and the slider moves to where the spring balances them."""
        sign, force = move.direction, move.direction * self._force_after_reset
        after = begin + (slip.load - force) / self.spring
        self._note(move, slip, begin, after, force)
        self._base = sign * after
        self._base_error += slip.error / self.spring
        if sign not in self._fresh:
            self._fresh[sign] = Move(self.contacts, sign, Past(self.contacts.formed_again))
        return self._fresh[sign]

    def _reform_after(self, move: Move, slip: SlipBegin, begin: float) -> Move:
        """Slip in which broken contacts stay out until the slider stops."""
        spring = self.spring
        held = MoveWithoutBirths(
            self.contacts, move.direction, move.stopped(slip.travel, slip.error)
        )
        curve, y = held.slip_ends(0.0, slip.load - spring * slip.travel, slip)
        self._note(move, slip, begin, begin + slip.travel + y, float(curve.force(y)))
        # force of the contacts misjudged as out or as holding (a length), by the error of where the slip begins
        error = (1.0 + spring) * slip.misplaced * y / self.contacts.unit
        self._base_error += float(curve.misplaced(y, 0.0, slip.error + error))
        # errors of the history do not affect contacts that broke
        error = (error + float(curve.error_at(y))) * held.holding(y)
        return Move(self.contacts, move.direction, held.formed_again(y, error))

    def _note(self, move: Move, slip: SlipBegin, begin: float, after: float, force: float) -> None:
        """Record a slip, of a move that begins at `begin`, with X and F after it along the motion."""
        drive, force_before = begin + slip.load / self.spring, float(slip.curve.force(slip.travel))
        row = np.array([drive, begin + slip.travel, after, force_before, force])
        self.slips.append(move.direction * row)
        self.drive_error = max(self.drive_error, slip.error / self.spring + self._base_error)
        if len(self.slips) > MOST_SLIPS:
            raise StoppedError("stopped as slips ask for too much work")
        if clock.monotonic() > self.contacts.until:
            raise StoppedError("stopped by wall_time")
