"""A soft slider at T = 0 along the whole path of its drive, move after move and slip after slip."""

from functools import lru_cache, partial

import numpy as np

from master.outcome import StoppedError, stop_after
from master.soft.curve import SlipBegin
from master.soft.moves import ColdContacts, LoadingHistory, Move, MoveWithoutBirths
from master.soft.regime import Followed, slips_of
from origins import Contacts
from origins.drive import Drive
from origins.thresholds.law import Array


class ColdSlider:
    """A soft slider at T = 0 pulled by a drive along its path (paper, Eq. Q16x2); see ColdContacts."""

    def __init__(self, contacts: Contacts, drive: Drive, tolerance: float, until: float) -> None:
        """Balance the spring with the force of the start, at X = 0."""
        self.slip, self.path, self.spring = drive.slip, drive.path, float(drive.spring or 0.0)
        self.contacts = cold = ColdContacts(contacts, self.spring, tolerance, until)
        self._start_force = cold.force_of(contacts.start)
        self._force_after_reset = cold.force_of(cold.formed_again)
        # F at points of the path, one array from each slip to the next; and a row for each slip
        self.force, self.slips = list[Array](), list[Array]()
        # estimates from above of the errors of the force, and of X_T at slips (lengths)
        self.error = self.drive_error = 0.0
        # X at which the history `_loaded` begins, and the error of that X
        self._base, self._base_error = 0.0, 0.0
        relaxed = contacts.start.span == cold.formed_again.span == (0.0, 0.0)
        self._loaded = LoadingHistory(cold.formed_again if relaxed else contacts.start)
        # resets repeat the same move, in each direction: it is solved once
        self._begun = lru_cache(4)(partial(Move, cold))
        # moves and travels at which slips begin after which no contact holds on
        self._clearing = set[tuple[Move, float]]()

    def follow(self) -> Followed:
        """The results along the path, as far as work and time allow."""
        balance, unit, stopped = self._start_force / self.spring, self.contacts.unit, ""
        steps, each = np.diff(self.path, prepend=balance), np.arange(self.path.size)
        # a first point this near the balance, in mean thresholds, counts as the balance
        steps[0] = 0.0 if abs(steps[0]) <= 1e-12 * unit else steps[0]
        # a hold belongs to the move before it
        signs = np.sign(steps)[np.maximum.accumulate(np.where(steps, each, 0))].astype(int)
        self.force.append(np.full(np.count_nonzero(signs == 0), self._start_force))
        try:
            for points in np.split(each, np.flatnonzero(np.diff(signs)) + 1):
                if signs[points[0]]:
                    self._move(int(signs[points[0]]), self.path[points])
        except StoppedError as why:
            stopped = str(why)
        force = np.concatenate(self.force)
        return Followed(
            balance=balance,
            force=force,
            holding=np.ones(force.size),
            slips=slips_of(np.reshape(self.slips, (-1, 3)).T, self.spring, self.drive_error),
            error=max(self.error, self.spring * self.drive_error) / unit,
            nodes=self.contacts.nodes,
            stopped_because=stopped,
        )

    def _move(self, direction: int, drives: Array) -> None:
        """Follow the drive in one direction over these X_T, with all slips on the way."""
        y, spring = 0.0, self.spring
        while True:
            move = self._begun(direction, self._loaded)
            begin = direction * (self._base + move.at(0.0))
            loads = spring * (direction * drives - begin)
            slip = move.next_slip(y, loads[-1])
            curve, count = slip.curve, int(np.searchsorted(loads, slip.load))
            if count:
                at = curve.travel_at(loads[:count], y, slip.travel)
                self.force.append(direction * curve.force(at))
                off = curve.travel_errors(at, self._base_error)
                self.error = max(self.error, spring * float(off.max()))
            if not np.isfinite(slip.load):
                # F' jumps to 1 at a turn: the error of its place is one of the force
                jump = abs(1.0 + spring - float(curve.load_slope(at[-1])))
                stop = move.travel_of_state(at[-1])
                self._base += direction * (at[-1] - stop)
                self._loaded = move.stopped(stop, float(curve.error_at(at[-1]) + jump * off[-1]))
                return
            drives = drives[count:]
            if self.slip == "instant":
                curve, y = move.end_of_slip(slip.travel, slip.load, slip)
                self._note(move, slip, begin, float(curve.force(y)))
            else:
                renew = self._reset if self.slip == "reset" else self._reform_after
                self._loaded, y = renew(move, slip, begin), 0.0

    def _reset(self, move: Move, slip: SlipBegin, begin: float) -> LoadingHistory:
        """Slip: all contacts re-form, and the slider moves to where the spring balances them."""
        force = move.direction * self._force_after_reset
        self._note(move, slip, begin, force)
        self._base = move.direction * (begin + (slip.load - force) / self.spring)
        self._base_error += slip.error / self.spring
        return LoadingHistory(self.contacts.formed_again)

    def _reform_after(self, move: Move, slip: SlipBegin, begin: float) -> LoadingHistory:
        """Slip in which broken contacts stay out until the slider stops."""
        if (move, slip.travel) in self._clearing:
            return self._reset(move, slip, begin)
        spring, loaded = self.spring, move.stopped(slip.travel, slip.error)
        slide = MoveWithoutBirths(self.contacts, move.direction, loaded)
        curve, y = slide.end_of_slip(0.0, slip.load - spring * slip.travel, slip)
        if slide.holds_none(y):
            # such a slip is a reset at another place, whose moves are known
            self._clearing.add((move, slip.travel))
            return self._reset(move, slip, begin)
        self._note(move, slip, begin, float(curve.force(y)))
        # force of the contacts misjudged as out or as holding (a length), by the error of where the slip begins
        far = min(
            y, self.contacts.life.largest_stretch
        )  # no contact that holds is stretched by more
        error = (1.0 + spring) * slip.begin_error * far / self.contacts.unit
        self._base_error += float(curve.travel_errors(y, 0.0, slip.error + error))
        return slide.after_slip(y, error + float(curve.error_at(y)))

    def _note(self, move: Move, slip: SlipBegin, begin: float, force: float) -> None:
        """Record a slip, of a move that begins at `begin`, with F after it along the motion."""
        drive, force_before = begin + slip.load / self.spring, float(slip.curve.force(slip.travel))
        self.slips.append(move.direction * np.array([drive, force_before, force]))
        self.drive_error = max(self.drive_error, slip.error / self.spring + self._base_error)
        if len(self.slips) > 20_000:  # as many take some 20 s
            raise StoppedError("stopped as slips ask for too much work")
        stop_after(self.contacts.until)
