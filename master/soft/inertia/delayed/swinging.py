"""A slider with mass while hardly a contact breaks or forms: its motion is closed, however often it swings."""

from enum import Enum

import numpy as np

from master.soft.inertia.body import QUIET
from master.soft.inertia.closed import watch_closed
from master.soft.inertia.delayed.body import DelayedBody, Energies
from master.soft.inertia.delayed.collocation import State
from master.soft.inertia.delayed.past_breaks import EPSILON
from master.soft.inertia.oscillation import Oscillation
from master.soft.inertia.reaction import ALIKE
from master.soft.inertia.record import Instant, Record, Watched, crossing
from origins.thresholds.law import Array

# Shortest closed motion that is worth it, in periods.
SHORTEST = 1e-9


class SwingEnd(Enum):
    """Why a closed motion ended; the value says whether another one may follow at once."""

    TOO_SHORT = "too short", False  # none was begun
    BROKE_TOGETHER = "contacts at an exact threshold broke together", True
    BREAKS_NEXT = "contacts begin to break one by one", False
    LEG_ENDED = "the drive's leg ended", True
    CALM = "what is left of the swings counts as rest", True
    LUMP_FORMS = "contacts that broke together form again", True
    BIRTHS_NEXT = "contacts begin to form one by one", False

    @property
    def goes_on(self) -> bool:
        """Whether another closed motion may follow."""
        return self.value[1]


class Swinging:
    """Closed motions of a body; it has no state of its own."""

    def __init__(self, body: DelayedBody, record: Record) -> None:
        """The record is told of falls of the spring's force."""
        self._body, self._record = body, record

    def swing(self) -> SwingEnd:
        """One closed motion, from the present state up to where it ends."""
        body = self._body
        past, machine = body.past, body.machine
        if past.next_lump <= body.state.t * (1.0 + EPSILON):
            body.form_lump()
        state = body.state
        alike = ALIKE * body.tolerance
        least, atoms = body.near(state.x), body.contacts.survival.atoms.size > 0
        forward, back = (body.contacts.reach(state.x, way, least, alike) for way in (1, -1))
        leg_end = body.drive.leg_end
        births = past.next_birth(state.t, 0.5 * alike / machine.unit)
        end = min(leg_end, births) - state.t
        # just after a passage it may be below 0 by its error
        holding = max(body.contacts.unbroken(), 0.0)
        stiff, rate = machine.spring + holding, machine.spring * body.drive.speed
        given = machine.mass, machine.damping, stiff, body.balance_of_spring, rate
        motion = Oscillation.of(*given, 0.0, state.w)
        quiet = QUIET * body.tolerance / (1.0 + machine.spring)
        if motion.size <= quiet:
            motion = Oscillation.of(*given, motion.centre, motion.drift)
            calm = np.inf
        else:
            calm = motion.time_until(quiet)
        # +1 where the slider comes to break contacts forwards, -1 backwards, 0 where it does neither
        lasts, breaks_at = motion.first_passing(-back, forward, min(end, calm))
        short = end <= 0.0 or (breaks_at and lasts < SHORTEST * motion.period)
        if short and not (atoms and breaks_at):
            return SwingEnd.TOO_SHORT
        self._take(motion, lasts, stiff)
        if breaks_at and atoms:
            reach = forward if breaks_at > 0 else back
            body.break_together(breaks_at * reach + state.x, holding)
            return SwingEnd.BROKE_TOGETHER
        if breaks_at:
            return SwingEnd.BREAKS_NEXT
        if lasts == leg_end - state.t:
            body.end_leg()
            return SwingEnd.LEG_ENDED
        if lasts < end:
            return SwingEnd.CALM
        body.take_time(births)
        return SwingEnd.LUMP_FORMS if past.next_lump <= births else SwingEnd.BIRTHS_NEXT

    def _take(self, motion: Oscillation, lasts: float, stiff: float) -> None:
        """Go on to the end of a closed motion: results at the asked times, energies and falls on the way."""
        body, state, k = self._body, self._body.state, self._body.machine.spring
        which, v = body.asked(state.t, state.t + lasts), body.drive.speed
        at = np.append(body.asked_times(which) - state.t, lasts)
        y, w = motion.travel(at), motion.speed(at)
        # K (X_T - X) is linear in the time but for X, whose integral is that of the balance and of the departure
        pull, rate = k * (float(body.drive.at(state.t)) - state.x), k * v
        mean = (pull - k * motion.centre) * at + 0.5 * (rate - k * motion.drift) * at**2
        given = v * (mean - k * motion.departure_integral(at))
        damped = body.machine.damping * motion.squared_speed(at)
        # F is a straight line in X while none breaks
        force = float(body.contacts.response(np.array([state.x])).force[0])
        on_contacts = force * y + 0.5 * (stiff - k) * y**2
        spent = [Energies(*some) for some in np.stack([given, damped, on_contacts], 1).tolist()]
        ends = [
            State(state.t + dt, state.x + dx, speed)
            for dt, dx, speed in zip(at.tolist(), y.tolist(), w.tolist(), strict=True)
        ]
        for index in range(which.start, which.stop):
            nth = index - which.start
            body.write(index, ends[nth], body.contacts, spent[nth])
        self._watch(motion, lasts)
        body.take_swing(ends[-1], body.contacts.moved(ends[-1].x), spent[-1])

    def _watch(self, motion: Oscillation, lasts: float) -> None:
        """Falls of the spring's force in a closed motion."""
        body, state = self._body, self._body.state
        breaks, limit = body.past.breaks + body.past.broken_together, body.slip_speed
        drive, k, unbroken = body.drive, body.machine.spring, body.contacts.unbroken()

        def seen(times: Array) -> Watched:
            """The slider at some times since the motion began, as the record asks for it to find falls of the force."""

            def when(index: int) -> float:
                def excess(t: float) -> float:
                    return drive.way * float(motion.speed(t)) - limit

                return crossing(excess, times[index], times[index + 1])

            def at(t: float) -> Instant:
                return body.instant(state.t + t, state.x + float(motion.travel(t)), breaks)

            x = state.x + motion.travel(times)
            return Watched(
                times=times,
                speeds=drive.way * motion.speed(times),
                places=x,
                forces=k * (drive.at(state.t + times) - x),
                held=np.full(times.size, unbroken),
                drive_speed=drive.way * drive.speed,
                way=drive.way,
                at=at,
                when=when,
            )

        watch_closed(self._record, motion, lasts, seen)
