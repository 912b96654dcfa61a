"""A slider with mass while hardly a contact breaks or forms: its motion is closed, however often it swings."""

import numpy as np

from master.soft.inertia.body import QUIET
from master.soft.inertia.closed import watch_closed
from master.soft.inertia.delayed.body import EPSILON, DelayedBody
from master.soft.inertia.delayed.collocation import State
from master.soft.inertia.oscillation import Oscillation
from master.soft.inertia.reaction import ALIKE
from master.soft.inertia.record import Instant, Watched, crossing
from origins.thresholds.law import Array

# Shortest closed motion that is worth it, in periods.
SHORTEST = 1e-9


class Swinging(DelayedBody):
    """Closed motions."""

    def _swing(self) -> bool:
        """One closed motion; returns whether another one may follow."""
        past, state, machine = self._past, self._state, self._machine
        if past.next_lump <= state.t * (1.0 + EPSILON):
            self._form_lump()
        alike = ALIKE * self._tolerance
        least, atoms = self._near(state.x), self._contacts.survival.atoms.size > 0
        forward, back = (self._contacts.reach(state.x, way, least, alike) for way in (1, -1))
        leg_end = self._leg_end()
        births = past.next_birth(state.t, 0.5 * alike / machine.unit)
        end = min(leg_end, births) - state.t
        held = self._contacts.response(np.array([state.x]))
        # just after a passage it may be below 0 by its error
        holding = max(self._contacts.unbroken(), 0.0)
        stiff = machine.spring + holding
        pull = machine.spring * (float(self._drive(state.t)) - state.x) - float(held.force[0])
        given = machine.mass, machine.damping, stiff, pull, machine.spring * self._speed
        motion = Oscillation.of(*given, 0.0, state.w)
        quiet = QUIET * self._tolerance / (1.0 + machine.spring)
        if motion.size <= quiet:
            motion = Oscillation.of(*given, motion.centre, motion.drift)
            calm = np.inf
        else:
            calm = motion.time_until(quiet)
        lasts, passed = motion.first_passing(-back, forward, min(end, calm))
        short = end <= 0.0 or (passed and lasts < SHORTEST * motion.period)
        if short and not (atoms and passed):
            return False
        self._take_swing(motion, lasts, stiff)
        self._last, self._width = None, np.inf
        if passed and atoms:
            self._break_together(passed * (forward if passed > 0 else back) + state.x, holding)
            return True
        if passed:
            return False
        if lasts == leg_end - state.t:
            self._next_leg()
            return True
        if lasts < end:
            return True  # calm
        self._state = self._state._replace(t=births)
        return past.next_lump <= births

    def _take_swing(self, motion: Oscillation, lasts: float, stiff: float) -> None:
        """Take a closed motion: results at the asked times, energies, falls, and the state."""
        record, state, machine, v = self._record, self._state, self._machine, self._speed
        k, held = machine.spring, self._contacts.response(np.array([state.x]))
        which = record.between(state.t, state.t + lasts)
        at = np.append(record.times[which] - state.t, lasts)
        y, w = motion.travel(at), motion.speed(at)
        begin, hold = float(held.force[0]), stiff - k
        pull, rate = k * (float(self._drive(state.t)) - state.x), k * v
        mean = (pull - k * motion.centre) * at + 0.5 * (rate - k * motion.drift) * at**2
        work = v * (mean - k * motion.departure_integral(at))
        damped = machine.damping * motion.squared_speed(at)
        on_contacts = begin * y + 0.5 * hold * y**2
        record.place[which], record.speed[which] = state.x + y[:-1], w[:-1]
        record.work[which] = self._work + work[:-1]
        record.damped[which] = self._damped + damped[:-1]
        record.on_contacts[which] = self._on_contacts + on_contacts[:-1]
        for index, x in zip(
            range(which.start, which.stop), (state.x + y[:-1]).tolist(), strict=True
        ):
            self._write_contacts(index, self._contacts, x)
        self._watch_swing(motion, lasts)
        self._work, self._damped = self._work + float(work[-1]), self._damped + float(damped[-1])
        self._on_contacts += float(on_contacts[-1])
        x, end = state.x + float(y[-1]), state.t + lasts
        self._contacts = self._contacts.moved(x)
        self._state = State(end, x, float(w[-1]))
        self._form_rest()

    def _watch_swing(self, motion: Oscillation, lasts: float) -> None:
        """Falls of the spring's force in a closed motion."""
        state, breaks = self._state, self._past.breaks + self._past.broken_together
        limit = max(self._way * self._speed, 0.0)

        def seen(times: Array) -> Watched:
            def when(k: int) -> float:
                def excess(t: float) -> float:
                    return self._way * float(motion.speed(t)) - limit

                return crossing(excess, times[k], times[k + 1])

            def at(t: float) -> Instant:
                return self._instant(state.t + t, state.x + float(motion.travel(t)), breaks)

            places = state.x + motion.travel(times), motion.speed(times)
            held = np.full(times.size, self._contacts.unbroken())
            return self._watched(times, places, held, self._drive(state.t + times), at, when)

        watch_closed(self._record, motion, lasts, seen)

    def _break_together(self, x: float, before: float) -> None:
        """Contacts at an exact threshold break at this place, of a share `before` that held."""
        self._contacts = self._contacts.moved(x)
        self._state = self._state._replace(x=x)
        self._past.add_lump(self._state.t, before - self._contacts.unbroken())
