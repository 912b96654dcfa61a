"""A soft slider at T = 0 along the whole path of its drive, move after move and slip after slip."""

from functools import lru_cache, partial

import numpy as np

from master.motion import Motion
from master.outcome import StoppedError, stop_after
from master.renewal.births import Births
from master.renewal.edges import edges
from master.soft.cold_contacts import ColdContacts
from master.soft.curve import LoadCurve, SlipBegin
from master.soft.followed import LOOSEN, ErrorPart, Followed
from master.soft.limit_cycle import LimitCycle, Slipped
from master.soft.moves import LoadingHistory, Move, SlipEnd
from master.soft.moves_without_births import MoveWithoutBirths
from master.soft.slips import slips_of
from master.soft.turns import behind_turn
from origins import Contacts
from origins.drive import SLIP_FRACTION, Drive
from origins.errors import refuse
from origins.thresholds.law import Array

# Most instants at which exact thresholds break on the way of a slider that slips from one to the next; as many take
# some 5 s for one value, 30 s for two values.
MOST_TOGETHER = 2000
# Way on which they are counted first, in mean thresholds.
FIRST_DISTANCE = 50.0
# Longest life of contacts, in mean thresholds, up to which breaks are followed until they are steady: some 25 s.
LONGEST_LIFE = 500.0
# Part of the tolerance, and of the error of each slip, that slips may miss together, and each, which are repeated
# although they are not quite the same.
OF_REPEATING = 0.1
# Round-off of the largest force, or of the mean threshold, up to which its polynomials' coefficients are: a part of it.
ROUNDED = 1e-15
# Slips that leave some contacts holding, and moves, that are kept to be repeated: each keeps its panels.
MOST_OF_LATE = 8
# Thresholds at which the first breaks are looked at.
QUANTILES = 2000
Onset = tuple[Move, float]  # of a slip: the move that leads to it, and the travel on it


class ColdSlider:
    """A soft slider at T = 0 pulled by a drive along its path (paper, Eq. Q16x2); see ColdContacts."""

    def __init__(
        self, contacts: Contacts, drive: Drive, tolerance: float, until: float, unknown: float = 0.0
    ) -> None:
        """Balance the spring with the force of the start, at X = 0; for `unknown` see ColdContacts."""
        self.slip, self.path, self.spring = drive.slip, drive.path, float(drive.spring or 0.0)
        self._forward = drive.forward
        self._distance = float(np.abs(np.diff(self.path, prepend=0.0)).sum())
        adding_up = 0.0 if self.slip == "instant" else self._distance
        self.contacts = cold = ColdContacts(contacts, self.spring, tolerance, until, adding_up)
        cold.unknown = unknown
        self._start_force = cold.force_of(contacts.start)
        self._force_after_reset = cold.force_of(cold.reforming)
        # F at points of the path, one array from each slip to the next; and a row for each slip
        self.force, self.slips = list[Array](), list[Array]()
        # estimates from above of the errors of the force, and of X_T at slips (lengths)
        self.error = self.drive_error = 0.0
        # F where a slip that was not found may have come before the drive turned or stopped (a length)
        self.missed_slip = 0.0
        # X at which the history `_loaded` begins, and the error of that X
        self._base, self._base_error = 0.0, 0.0
        relaxed = contacts.start.span == cold.reforming.span == (0.0, 0.0)
        self._loaded = LoadingHistory(cold.reforming if relaxed else contacts.start)
        # resets repeat the same move, in each direction: it is solved once
        self._move_from = lru_cache(MOST_OF_LATE)(partial(Move, cold))
        # of slips: the fraction of the contacts that breaks before a reset, nan where that takes too much work; and
        # those of "reform-after" that leave no contact holding, which are resets
        self._broken, self._leave_none = dict[Onset, float](), set[Onset]()
        # slips that leave some contacts holding: whether each tends to be as the one before, and those of late
        self._cycle, self._of_late = LimitCycle(), dict[Onset, Slipped]()
        # the same of each slip; nan where contacts form again at once
        self.fractions_broken = list[float]()
        if self.slip == "instant" and cold.life.atoms.size and drive.forward:
            self._refuse_endless_slips(contacts)
        if cold.life.largest_stretch > LONGEST_LIFE * cold.unit and drive.forward:
            self._refuse_long_lives(contacts)

    def _refuse_endless_slips(self, contacts: Contacts) -> None:
        """InputError where exact thresholds, which re-form at once, break together too often on the path.

        The slider has moved at least to where the largest possible force balances the drive, and breaks at each instant
        up to there follow from those before, without any march.
        """
        cold = self.contacts
        largest = cold.life.largest_stretch
        stretched = float(contacts.relative_stiffness(largest)) * largest / self.spring
        distance = float(self.path[-1]) - stretched
        ahead, breaks = FIRST_DISTANCE * cold.unit, 0
        # way after way, as to count all instants would take long where there are millions
        while breaks <= MOST_TOGETHER and ahead < 2.0 * distance:
            motion = Motion.along(np.array([0.0, min(ahead, distance)]))
            plan = edges(Births(cold.life, cold.reforming, motion), contacts.start, cold.of_panels)
            ahead, breaks = 2.0 * ahead, plan.times.size
        if breaks > MOST_TOGETHER:
            fault = f"the slider goes on by {distance:.3g}, and contacts of exact thresholds break"
            what = f"together more than {MOST_TOGETHER:,} times on the way"
            hint = 'give the values a width, end the path sooner, or take "reset" or "reform-after"'
            refuse("path[-1]", self.path[-1], f"{fault} {what}; {hint}")

    def _refuse_long_lives(self, contacts: Contacts) -> None:
        """InputError where the slider goes with its drive for longer than contacts of a heavy tail can be followed.

        From relaxed contacts F is at most <x_s^2>/<x_s>, by Lorden's inequality of renewal theory. A slip that leaves
        no contact as it was ends this way; up to second breaks F' is 1 - X P_c(X), and tells whether there is one.
        """
        law, unit = contacts.thresholds, self.contacts.unit
        longest = self.contacts.life.largest_stretch
        latest = law.moment(2) / law.mean() / self.spring
        distance = float(self.path[-1]) - latest
        relaxed = contacts.start.span == (0.0, 0.0) and contacts.reforming is None
        if not (relaxed and contacts.stiffness == "independent" and distance > LONGEST_LIFE * unit):
            return
        x = law.isf((np.arange(QUANTILES) + 0.5) / QUANTILES)
        slips = float((x * law.pdf(x)).max()) > 1.0 + self.spring
        if self.slip == "instant" or not slips:
            fault = f"contacts of a heavy tail, that hold for up to {longest / unit:.3g} mean thresholds, are followed"
            most = f"for {LONGEST_LIFE:g}, and the slider goes on by {distance / unit:.3g}"
            hint = f"end the path before {latest + LONGEST_LIFE * unit:.4g}, or cut the tail"
            refuse("path[-1]", self.path[-1], f"{fault} {most}; {hint}")

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
        rounding = ROUNDED * float(np.abs(force).max(initial=unit))
        parts = (
            ErrorPart("the force along the path", self.error / unit),
            ErrorPart("X_T at slips", self.spring * self.drive_error / unit),
            ErrorPart(
                "a slip that may come just before the drive turns or ends, by heat that is left out",
                self.missed_slip / unit,
                "turn or end the path a little elsewhere",
            ),
            ErrorPart("rounding", rounding / unit, LOOSEN),
        )
        return Followed(
            balance=balance,
            force=force,
            holding=np.ones(force.size),
            slips=slips_of(np.reshape(self.slips, (-1, 3)).T, self.spring, self.drive_error),
            fractions_broken=np.array(self.fractions_broken),
            error=max(part.size for part in parts),
            nodes=self.contacts.nodes,
            stopped_because=stopped,
            parts=parts,
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
                stop = move.travel_of_state(at[-1])
                self._base += direction * (at[-1] - stop)
                error, self._base_error = behind_turn(move, curve, at[-1], self._base_error)
                self._loaded = move.stopped(stop, error)
                if self.contacts.unknown and self._may_have_slipped(move, slip, asked[-1]):
                    self.missed_slip = max(self.missed_slip, abs(float(curve.force(at[-1]))))
                return
            drives = drives[count:]
            if self.slip == "instant":
                curve, y = move.end_of_slip(slip.travel, slip.load, slip, self._forward)
                self._note(move, slip, begin, float(curve.force(y)), np.nan)
            else:
                renew = self._reset if self.slip == "reset" else self._reform_after
                self._loaded, y = renew(move, slip, begin), 0.0

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

    def _reset(self, move: Move, slip: SlipBegin, begin: float) -> LoadingHistory:
        """Slip: all contacts re-form, and the slider moves to where the spring balances them. What comes next does not
        depend on slips before."""
        self._cycle = LimitCycle()
        force = move.direction * self._force_after_reset
        self._note(move, slip, begin, force, self._fraction_broken(move, slip))
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
        """The way of a slip in which broken contacts stay out, and where it ends."""
        loaded = move.stopped(slip.travel, slip.error)
        slide = MoveWithoutBirths(self.contacts, move.direction, loaded)
        return slide, slide.end_of_slip(0.0, slip.load - self.spring * slip.travel, slip)

    def _reform_after(self, move: Move, slip: SlipBegin, begin: float) -> LoadingHistory:
        """Slip in which broken contacts stay out until the slider stops. The next move's plan lets them be born, by
        `March.postpone_births`: between `cut_at` and `move_begins_at` of the history that is returned none is."""
        key = move, slip.travel
        if key in self._leave_none:
            return self._reset(move, slip, begin)
        if (slipped := self._of_late.get(key) or self._slipped(move, slip)) is None:
            # all contacts form again where it ends, as in a reset
            self._leave_none.add(key)
            return self._reset(move, slip, begin)
        self._of_late[key] = slipped
        if len(self._of_late) > MOST_OF_LATE:
            self._of_late.pop(next(iter(self._of_late)))
        self._note(move, slip, begin, slipped.force, slipped.fraction_broken)
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

    def _note(self, move: Move, slip: SlipBegin, begin: float, force: float, broken: float) -> None:
        """Record a slip, of a move that begins at `begin`, with F after it along the motion, and what part broke."""
        drive, force_before = begin + slip.load / self.spring, float(slip.curve.force(slip.travel))
        self.slips.append(move.direction * np.array([drive, force_before, force]))
        self.fractions_broken.append(broken)
        self.drive_error = max(self.drive_error, slip.error / self.spring + self._base_error)
        if len(self.slips) > 20_000:  # as many take some 20 s
            raise StoppedError("stopped as slips ask for too much work")
        stop_after(self.contacts.until)
