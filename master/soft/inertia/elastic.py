"""A slider with mass while none of its contacts breaks: its motion is closed, and it turns."""

from typing import NamedTuple

import numpy as np

from master.outcome import StoppedError
from master.soft.inertia.body import RINGS, Body, Mode
from master.soft.inertia.closed_falls import watch_closed
from master.soft.inertia.oscillation import Held, Oscillation, Pulled
from master.soft.inertia.reaction import Reaction
from master.soft.inertia.record import Instant, Watched, crossing
from origins.thresholds.law import Array

# At a turn all contacts hold, without being asked again, if it is nearer to the last one than the first part of the way
# back on which all held then, and its swing back is shorter than the second part of that way.
SAME_TURN, SURELY_ELASTIC = 0.01, 0.9
# Most turns in a row at which contacts break: births of all of them are summed up, 40 take some 10 s.
MOST_IN_A_ROW = 40


class AskedTurn(NamedTuple):
    """A turn at which contacts were asked how far back all of them hold.

    move : that ended there; travel : of it; turning_distance : how far back all hold (lengths)
    """

    move: Reaction
    travel: float
    turning_distance: float


class Elastic(Body):
    """The mode `elastic`, in which all contacts hold, and turns, at which it begins.

    _top, _top_force : travel on the present move at which the slider turned, 0 at t = 0, and F along the move there;
        while all hold, F = _top_force + y - _top (lengths)
    _high : travel up to which all hold ahead; beyond it contacts break, and the slider goes on along this move
    _range : how far below `_top` all hold; farther back it goes on along `_other`
    _other : the move that begins at `_top` in the other direction; None as long as it is not needed
    _asked : the last turn at which contacts were asked
    _in_a_row : so many turns before this one let contacts break soon
    """

    _in_a_row = 0
    _asked: AskedTurn | None = None

    def _hold(self, top: float, high: float, other: Reaction | None) -> None:
        """No contact breaks from here up to the travel `high`, and backward as far as on the move `other`, which
        begins at the travel `top`."""
        self._top, self._high, self._other = top, high, other
        self._top_force = self._force(top)
        if other is not None:
            self._range = other.elastic_end

    def turn(self) -> Mode:
        """The slider stands still at the travel y of a move, and turns."""
        self.turns += 1
        pulled = self._force(self.y) + self.spring * self.y - float(self._pull(self.t))
        swing = 2.0 * pulled / self.stiff
        asked = self._asked
        if asked is not None and asked.move is self.move:
            distance = asked.turning_distance
            if self.y - asked.travel < SAME_TURN * distance and swing < SURELY_ELASTIC * distance:
                self._hold(self.y, self.y, None)
                self._range = distance
                return self.elastic
        other = self._new_move(-self.move.direction, self.move.stop(self.y, self._error))
        self._asked = AskedTurn(self.move, self.y, other.elastic_end)
        self._hold(self.y, self.y, other)
        if other.elastic_end < swing:
            self._in_a_row = (
                0 if self.y > self.contacts.life.largest_stretch else self._in_a_row + 1
            )
            if self._in_a_row > MOST_IN_A_ROW:
                raise StoppedError(RINGS)
            return self._switch()
        return self.elastic

    def _switch(self) -> Mode:
        """Go on along the move that began where this one turned."""
        if self._other is None:
            loaded = self.move.stop(self._top, self._error)
            self._other = self._new_move(-self.move.direction, loaded)
        self.base += self.move.direction * self._top
        self.broken += self.move.breaks(self._top)
        self.y, self.w, self.move = self._top - self.y, -self.w, self._other
        return self.moving

    def elastic(self) -> Mode:
        """The closed motion while no contact breaks: until one would, the swing has died away or the drive's leg ends,
        whichever comes first."""
        mass, damping, t = self.mass, self.damping, self.t
        pull = float(self._pull(t)) - (self._top_force - self._top)
        rate, until_leg_end = self.spring * self._speed, self._leg_end() - t
        motion = Oscillation.of(mass, damping, self.stiff, pull, rate, self.y, self.w)
        until_quiet = motion.time_until(self.quiet / self.stiff)
        # The ringing counts as rest: it is below `quiet` already, or would be after a time that is lost in rounding,
        # which would bring the same state again, without end. Then the slider only drifts.
        is_quiet = t + until_quiet <= t
        if is_quiet:
            balance, speed = motion.centre, motion.drift
            motion = Oscillation.of(mass, damping, self.stiff, pull, rate, balance, speed)
        leg_ends = is_quiet or until_quiet > until_leg_end
        longest = until_leg_end if leg_ends else until_quiet
        lasts, side = motion.first_passing(self._top - self._range, self._high, longest)
        until = self._leg_end() if leg_ends and not side else t + lasts
        self._watch_elastic(motion, lasts)
        self._record_elastic(motion, lasts, until)
        self.t, self.y, self.w = t + lasts, float(motion.travel(lasts)), float(motion.speed(lasts))
        if not side:
            if leg_ends:
                self._next_leg()
            return self.elastic
        next_mode: Mode = self.moving
        if side > 0:
            self.y = self._high
        else:
            next_mode = self._switch()
        self._break_here()
        # one that does not swing gets to where contacts break as slowly as its drive
        return self.following if is_quiet else next_mode

    def _watch_elastic(self, motion: Oscillation, lasts: float) -> None:
        """Falls of the spring's force in the closed motion that follows."""
        t, limit = self.t, max(self._speed, 0.0)

        def seen(times: Array) -> Watched:
            def when(k: int) -> float:
                return crossing(lambda s: float(motion.speed(s)) - limit, times[k], times[k + 1])

            def at(s: float) -> Instant:
                return self._instant(t + s, float(motion.travel(s)), self._top)

            moved = motion.travel(times), motion.speed(times)
            return self._watched(times, moved, self._drive(t + times), at, when)

        watch_closed(self.record, motion, lasts, seen)

    def _record_elastic(self, motion: Oscillation, lasts: float, until: float) -> None:
        """Energies up to the time `until`, and results at the asked times."""
        which, record, d = self.record.between(self.t, until), self.record, self.move.direction
        at = np.append(record.times[which] - self.t, lasts)
        y, w = motion.travel(at), motion.speed(at)
        pulled = Pulled(self.spring, self.damping, self._speed, float(self._pull(self.t)))
        held = Held(1.0, self._top_force + self.y - self._top)
        spent = self.spent.plus(motion.spent(at, y - self.y, pulled, held))
        distances = y[:-1] - self._top
        force = self._top_force + distances
        record.write(
            which, self.base + d * y[:-1], d * w[:-1], d * force, spent.at(slice(None, -1))
        )
        record.store_later(self.move, which, np.full(distances.size, self._top))
        record.stored[which] += self._top_force * distances + 0.5 * distances**2
        self.spent = spent.at(-1)
