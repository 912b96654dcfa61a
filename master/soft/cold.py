"""A soft slider at T = 0 along the whole path of its drive, move after move and slip after slip."""

from functools import lru_cache, partial

import numpy as np

from master.outcome import StoppedError, stop_after
from master.soft.cold_contacts import ColdContacts
from master.soft.curve import LoadCurve, SlipBegin
from master.soft.followed import LEAVE_OUT, LOOSEN, OF_UNSURE_SLIP, ErrorPart, Followed
from master.soft.left_out import LeftOut
from master.soft.limit_cycle import LimitCycle, Slipped
from master.soft.moves import LoadingHistory, Move, SlipEnd
from master.soft.moves_without_births import MoveWithoutBirths
from master.soft.slips import slips_of
from master.soft.slips_ahead import nothing_ahead_known, slips_ahead
from master.soft.too_long import MOST_SLIPS, refuse_endless_slips, refuse_long_lives
from master.soft.turns import LegEnd, behind_turn, remedy_of
from origins import Contacts
from origins.drive import SLIP_FRACTION, Drive
from origins.thresholds.law import Array

# Part of the tolerance, and of the error of each slip, that slips may miss together, and each, which are repeated
# although they are not quite the same.
OF_REPEATING = 0.1
# Round-off of the force, a part of its largest value or of the mean threshold: its polynomials' coefficients are as
# large as the larger of these.
ROUNDED = 1e-15
# How many of the latest moves, and of the slips that leave some contacts holding, are kept to be repeated: each keeps
# its panels.
MOST_OF_LATE = 8
# where a slip begins: the move that leads to it, and the slider's travel on that move
Onset = tuple[Move, float]


class ColdSlider:
    """A soft slider at T = 0 pulled by a drive along its path (paper, Eq. Q16x2); see ColdContacts."""

    def __init__(
        self,
        contacts: Contacts,
        drive: Drive,
        tolerance: float,
        until: float,
        unknown: float = 0.0,
        in_heat: Contacts | None = None,
    ) -> None:
        """Balance the spring with the force of the start, at X = 0; for `unknown` see ColdContacts. `in_heat` : the
        contacts with the heat that is left out."""
        self.slip, self.path, self.spring = drive.slip, drive.path, float(drive.spring or 0.0)
        self._forward = drive.forward
        self._distance = float(np.abs(np.diff(self.path, prepend=0.0)).sum())
        adding_up = 0.0 if self.slip == "instant" else self._distance
        self.contacts = cold = ColdContacts(contacts, self.spring, tolerance, until, adding_up)
        cold.unknown = unknown
        self._left_out = LeftOut(cold, drive, in_heat)
        self._start_force = cold.force_of(contacts.start)
        self._force_after_reset = cold.force_of(cold.reforming)
        # F at points of the path, one array from each slip to the next; and a row for each slip
        self.force, self.slips = list[Array](), list[Array]()
        # estimates from above of the errors of the force, and of X_T at slips (lengths)
        self.error = self.drive_error = 0.0
        # how far F may be off (lengths) where a slip that was not found may have come before the drive turned or
        # stopped; and where laws that are left out may take a slip away, or bring one about before it
        self.missed_slip = self.unsure_slip = 0.0
        # X at which the history `_loaded` begins, and the error of that X
        self._base, self._base_error = 0.0, 0.0
        relaxed = contacts.start.span == cold.reforming.span == (0.0, 0.0)
        self._loaded = LoadingHistory(cold.reforming if relaxed else contacts.start)
        # whether all contacts break at the same X, so that each slip leaves them as they were at the path's begin
        self._all_together = relaxed and drive.forward and cold.all_alike
        # resets repeat the same move, in each direction: it is solved once
        self._move_from = lru_cache(MOST_OF_LATE)(partial(Move, cold))
        # of slips: the fraction of the contacts that breaks before a reset, nan where that takes too much work; and
        # those of "reform-after" that leave no contact holding, which are resets
        self._broken, self._leave_none = dict[Onset, float](), set[Onset]()
        # slips that leave some contacts holding: whether each tends to be as the one before, and those of late
        self._cycle, self._of_late = LimitCycle(), dict[Onset, Slipped]()
        # the same of each slip; nan where contacts form again at once
        self.fractions_broken = list[float]()
        self._slips_ahead = nothing_ahead_known
        if drive.forward:
            refuse_endless_slips(contacts, cold, drive, self._all_together)
            refuse_long_lives(contacts, cold, drive)

    def follow(self) -> Followed:
        """The results along the path, as far as work and time allow."""
        spring, unit, stopped = self.spring, self.contacts.unit, ""
        balance = self._start_force / spring
        steps, each = np.diff(self.path, prepend=balance), np.arange(self.path.size)
        # a first point this near the balance, in mean thresholds, counts as the balance
        steps[0] = 0.0 if abs(steps[0]) <= 1e-12 * unit else steps[0]
        # a hold belongs to the move before it
        signs = np.sign(steps)[np.maximum.accumulate(np.where(steps, each, 0))].astype(int)
        self.force.append(np.full(np.count_nonzero(signs == 0), self._start_force))
        legs = list[LegEnd]()
        try:
            for points in np.split(each, np.flatnonzero(np.diff(signs)) + 1):
                if signs[points[0]]:
                    self._move(int(signs[points[0]]), self.path[points])
                    off = max(self.error, spring * self.drive_error) / unit
                    legs.append(LegEnd(float(self.path[points[-1]]), off))
        except StoppedError as why:
            stopped = str(why)
        force = np.concatenate(self.force)
        rounding = ROUNDED * float(np.abs(force).max(initial=unit))
        remedy = remedy_of(legs, self.contacts.unknown / unit, self.contacts.tolerance)
        parts = (
            ErrorPart("the force along the path", self.error / unit, remedy),
            ErrorPart("X_T at slips", spring * self.drive_error / unit, remedy),
            ErrorPart(
                "a slip that may come just before the drive turns or ends, by heat that is left out",
                self.missed_slip / unit,
                "turn or end the path a little elsewhere",
            ),
            ErrorPart(OF_UNSURE_SLIP, self.unsure_slip / unit, LEAVE_OUT),
            ErrorPart("rounding", rounding / unit, LOOSEN),
        )
        return Followed(
            balance=balance,
            force=force,
            holding=np.ones(force.size),
            slips=slips_of(np.reshape(self.slips, (-1, 3)).T, spring, self.drive_error),
            fractions_broken=np.array(self.fractions_broken),
            error_of_force_and_load=max(part.size for part in parts),
            nodes=self.contacts.nodes,
            stopped_because=stopped,
            parts=parts,
            slips_ahead=self._slips_ahead,
        )

    def _move(self, direction: int, drives: Array) -> None:
        """Follow the drive in one direction over these X_T, with all slips on the way."""
        y, spring, self._cycle = 0.0, self.spring, LimitCycle()
        while True:
            move = self._move_from(direction, self._loaded)
            begin = direction * (self._base + move.at(0.0))
            # the load (see curve.py) that each of these X_T asks for
            asked = spring * (direction * drives - begin)
            try:
                slip = move.next_slip(y, asked[-1])
            except StoppedError:
                if move.solved:
                    curve = move.solved_curve()
                    last = min(curve.slip_begins(y), curve.to_travel)
                    load = float(curve.force(last)) + spring * last
                    self._keep(curve, asked[: np.searchsorted(asked, load)], y, last, direction)
                raise
            curve, count = slip.curve, int(np.searchsorted(asked, slip.load))
            at = self._keep(curve, asked[:count], y, slip.travel, direction)
            if not np.isfinite(slip.load):
                if self.slip == "instant" and self._forward and not self.contacts.unknown:
                    self._slips_ahead = slips_ahead(move, y, begin)
                stop = move.travel_of_state(at[-1])
                self._base += direction * (at[-1] - stop)
                error, self._base_error = behind_turn(move, curve, at[-1], self._base_error)
                self._loaded = move.stopped(stop, error)
                if self.contacts.unknown and self._may_have_slipped(move, slip, asked[-1]):
                    self.missed_slip = max(self.missed_slip, abs(float(curve.force(at[-1]))))
                self._note_if_unsure(move, slip, y, renews=True)
                return
            drives, after = drives[count:], y
            if self.slip == "instant":
                curve, y = move.end_of_slip(slip.travel, slip.load, slip, self._forward)
                self._list(move, slip, begin, float(curve.force(y)), np.nan)
                renews = self._all_together
                if renews:
                    # all were born at the slip's begin, and none reaches its threshold on the way of the slip
                    self._base, y = move.direction * (begin + slip.travel), y - slip.travel
                    self._base_error += slip.begin_error + np.spacing(abs(self._base))
                    self._loaded = LoadingHistory(self.contacts.reforming)
            else:
                renew = self.reset if self.slip == "reset" else self.reform_after
                self._loaded, y = renew(move, slip, begin), 0.0
                renews = self.slip == "reset" or (move, slip.travel) in self._leave_none
            self._note_if_unsure(move, slip, after, renews)

    def _note_if_unsure(self, move: Move, slip: SlipBegin, after: float, renews: bool) -> None:
        """Note how far F may be off where laws that are left out decide on this slip, or on one between the travel
        `after` and it: as far as in the slip, or where slips renew contacts as far as the largest force there is.
        `renews` : all of them."""
        if self.contacts.unknown and self._left_out.decides(move, slip, after, renews):
            off = self.contacts.unit * self.contacts.steady_stiffness
            if self.slip == "instant" and np.isfinite(slip.load):
                off = float(np.abs(np.diff(self.slips[-1][1:]))[0])
            self.unsure_slip = max(self.unsure_slip, off)

    def _may_have_slipped(self, move: Move, last: SlipBegin, load: float) -> bool:
        """Whether a slip may come before the path ends at this load, although none was found: without the laws that are
        left out the next one is so near that their effect on the force may bring it about."""
        missed = 2.0 * (last.error + self.spring * self._base_error)
        return bool(np.isfinite(move.next_slip(last.travel, load + missed).load))

    def _keep(
        self, curve: LoadCurve, asked: Array, low: float, high: float, direction: int
    ) -> Array:
        """Keep the force at the loads that are asked for, met between the travels `low` and `high`: the travels there
        (lengths)."""
        if not asked.size:
            return asked
        at = curve.travel_at(asked, low, high)
        self.force.append(direction * curve.force(at))
        off = curve.travel_errors(at, self._base_error)
        self.error = max(self.error, self.spring * float(off.max()))
        return at

    def reset(self, move: Move, slip: SlipBegin, begin: float) -> LoadingHistory:
        """Slip: all contacts re-form, and the slider moves to where the spring balances them. What comes next does not
        depend on slips before."""
        self._cycle = LimitCycle()
        force = move.direction * self._force_after_reset
        self._list(move, slip, begin, force, self._fraction_broken(move, slip))
        self._base = move.direction * (begin + (slip.load - force) / self.spring)
        self._base_error += slip.error / self.spring
        return LoadingHistory(self.contacts.reforming)

    def _fraction_broken(self, move: Move, slip: SlipBegin) -> float:
        """The fraction of the contacts that breaks before a reset renews the others; nan where that takes too much work
        and, as finding it takes as long as another slip, once one is known in which SLIP_FRACTION or more break."""
        key = move, slip.travel
        if key in self._leave_none:
            return 1.0
        main_slip_found = any(one >= SLIP_FRACTION for one in self._broken.values())
        if key not in self._broken and not main_slip_found:
            try:
                slide, end = self._slide(move, slip)
                self._broken[key] = 1.0 - slide.holding_after(end.travel)
            except StoppedError:
                self._broken[key] = np.nan
        return self._broken.get(key, np.nan)

    def _slide(self, move: Move, slip: SlipBegin) -> tuple[MoveWithoutBirths, SlipEnd]:
        """The way of a slip in which broken contacts stay out, and where it ends. The load there is counted from where
        the slide begins: K times the travel before is taken off."""
        loaded = move.stopped(slip.travel, slip.error)
        slide = MoveWithoutBirths(self.contacts, move.direction, loaded)
        return slide, slide.end_of_slip(0.0, slip.load - self.spring * slip.travel, slip)

    def reform_after(self, move: Move, slip: SlipBegin, begin: float) -> LoadingHistory:
        """Slip in which broken contacts stay out until the slider stops. The next move's plan lets them be born, by
        `March.postpone_births`: between `cut_at` and `move_begins_at` of the history that is returned none is."""
        key = move, slip.travel
        if key in self._leave_none:
            return self.reset(move, slip, begin)
        # slips of a limit cycle that repeats are kept, and not solved again
        if (slipped := self._of_late.get(key) or self._slipped(move, slip)) is None:
            # all contacts form again where it ends, as in a reset
            self._leave_none.add(key)
            return self.reset(move, slip, begin)
        self._of_late[key] = slipped
        if len(self._of_late) > MOST_OF_LATE:
            self._of_late.pop(next(iter(self._of_late)))
        self._list(move, slip, begin, slipped.force, slipped.fraction_broken)
        self._base += slipped.shift
        self._base_error += slipped.position_error
        return slipped.loaded

    def _slipped(self, move: Move, slip: SlipBegin) -> Slipped | None:
        """What a slip leaves in which broken contacts stay out; None where no contact holds on. Once all slips to come
        are as this one, to an error that is added, its move is repeated as a reset's is.
        Errors: slip.error of the load where it begins, slip.misjudged_travel of the travel there (lengths), on which a
        share `misjudged` of the contacts formed, or did not. Both shift the slip's end; F goes on with `error`."""
        contacts, unit, spring = self.contacts, self.contacts.unit, self.spring
        slide, (curve, y) = self._slide(move, slip)
        if slide.holds_none(y):
            return None
        holding, force = slide.holding_after(y), float(curve.force(y))
        misjudged = move.breaks_per_travel(slip.travel) * slip.misjudged_travel
        force_of_new = contacts.force_of(contacts.reforming, move.direction * y)
        end_shift = float(curve.travel_errors(y, 0.0, slip.error + misjudged * abs(force_of_new)))
        slips = self._distance / (slip.travel + y)  # it moves as far as the drive from slip to slip
        most = min(slip.error, contacts.tolerance * unit / (spring * slips))
        after = np.array([y, force, holding * unit])
        if repeated := self._cycle.closed_by(move.loaded, slip, after, OF_REPEATING * most):
            shift = slide.at(y) - move.loaded.places[-1]
            # the travel up to the slip is off by as much as that in it
            position_error = end_shift + 2.0 * self._cycle.remaining
            return Slipped(force, 1.0 - holding, position_error, repeated, shift)
        far = min(y, contacts.life.largest_stretch)  # no contact that holds is stretched more
        error = (misjudged * far + float(curve.error_at(y))) * holding  # those that broke have none
        return Slipped(force, 1.0 - holding, end_shift, slide.after_slip(y, error))

    def _list(self, move: Move, slip: SlipBegin, begin: float, force: float, broken: float) -> None:
        """List a slip of a move that begins at X = `begin`, with F after it, above 0 along the motion, and the share
        `broken` of the contacts that broke in it."""
        drive, force_before = begin + slip.load / self.spring, float(slip.curve.force(slip.travel))
        self.slips.append(move.direction * np.array([drive, force_before, force]))
        self.fractions_broken.append(broken)
        self.drive_error = max(self.drive_error, slip.error / self.spring + self._base_error)
        if len(self.slips) > MOST_SLIPS:
            raise StoppedError("stopped as slips ask for too much work")
        stop_after(self.contacts.until)
