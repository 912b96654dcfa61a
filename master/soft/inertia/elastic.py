"""A slider with mass while none of its contacts breaks: its motion is closed, and it turns."""

from typing import NamedTuple

import numpy as np

from master.outcome import StoppedError
from master.soft.inertia.body import RINGS, Body, Mode
from master.soft.inertia.closed import watch_closed
from master.soft.inertia.oscillation import Oscillation
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
    """The mode `elastic`, and turns."""

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
        """The closed motion while no contact breaks."""
        m, g = self.mass, self.damping
        t, y = self.t, self.y
        shift, end = self._top_force - self._top, self._leg_end() - t
        pull, rate = float(self._pull(t)) - shift, self.spring * self._speed
        motion = Oscillation.of(m, g, self.stiff, pull, rate, y, self.w)
        calm = motion.time_until(self.quiet / self.stiff)
        # a time that is lost in rounding would bring the same state again, without end
        rests = t + calm <= t
        if rests:
            motion = Oscillation.of(m, g, self.stiff, pull, rate, motion.centre, motion.drift)
        end, leg_ends = (end, True) if rests or calm > end else (calm, False)
        lasts, passed = motion.first_passing(self._top - self._range, self._high, end)
        until = self._leg_end() if leg_ends and not passed else t + lasts
        self._watch_elastic(motion, lasts)
        self._record_elastic(motion, lasts, until)
        self.t, self.y, self.w = t + lasts, float(motion.travel(lasts)), float(motion.speed(lasts))
        if passed > 0:
            self.y = self._high
            return self.following if rests else self.moving
        if passed < 0:
            mode = self._switch()
            return self.following if rests else mode
        if leg_ends:
            self._next_leg()
        return self.elastic

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
        which = self.record.between(self.t, until)
        at = np.append(self.record.times[which] - self.t, lasts)
        d, y, w = self.move.direction, motion.travel(at), motion.speed(at)
        force = self._top_force + (y - self._top)
        pull, rate, k = float(self._pull(self.t)), self.spring * self._speed, self.spring
        mean = (pull - k * motion.centre) * at + 0.5 * (rate - k * motion.drift) * at**2
        work = self.work + self._speed * (mean - k * motion.departure_integral(at))
        damped = self.damped + self.damping * motion.squared_speed(at)
        begin = self._top_force + self.y - self._top
        on_contacts = self.on_contacts + 0.5 * (begin + force) * (y - self.y)
        record, distances = self.record, y[:-1] - self._top
        record.place[which], record.speed[which] = self.base + d * y[:-1], d * w[:-1]
        record.contact_force[which] = d * force[:-1]
        record.work[which], record.damped[which] = work[:-1], damped[:-1]
        record.on_contacts[which] = on_contacts[:-1]
        record.store_later(self.move, which, np.full(distances.size, self._top))
        record.stored[which] += self._top_force * distances + 0.5 * distances**2
        self.work, self.damped = float(work[-1]), float(damped[-1])
        self.on_contacts = float(on_contacts[-1])
