"""A slider with mass while hardly a contact breaks or forms: its motion is closed, however often it swings."""

from enum import Enum
from typing import NamedTuple

import numpy as np

from master.soft.inertia.body import QUIET
from master.soft.inertia.closed_falls import watch_closed
from master.soft.inertia.delayed.body import DelayedBody
from master.soft.inertia.delayed.collocation import SliderState
from master.soft.inertia.delayed.past_breaks import EPSILON
from master.soft.inertia.oscillation import NONE_HOLDS, Held, Oscillation, Pulled
from master.soft.inertia.reaction import ALIKE
from master.soft.inertia.record import Instant, Record, Watched
from origins.thresholds.law import Array

# Shortest closed motion that is worth it, in periods.
SHORTEST = 1e-9
# Shortest one at whose end contacts that form one by one do so together, in periods; and the part of a period by which
# it ends later in the swing than it began, the golden section: so places of births are spread evenly over swings.
RINGS_AT_LEAST, LATER_IN_SWING = 2.0, 0.5 * (5.0**0.5 - 1.0)
# Part of the tolerance of the force by which such contacts may change it: it does not add up over motions, as each ends
# elsewhere in the swing. And their largest share of those that hold, as its square is left out.
OF_SOME, SOME = 0.25, 0.02


class SwingEnd(Enum):
    """Why a closed motion ended. The value says whether another one may follow at once: none does where contacts break
    or form one by one from then on, which panels of time follow."""

    TOO_SHORT = "none was begun, as contacts break or form at once", False
    BROKE_TOGETHER = "contacts at an exact threshold broke together", True
    BREAKS_NEXT = "contacts begin to break one by one", False
    LEG_ENDED = "the drive's leg ended", True
    LUMP_FORMS = "contacts that broke together form again", True
    BIRTHS_NEXT = "contacts begin to form one by one", False
    SOME_FORMED = "contacts that formed one by one in many swings form together", True
    CALM = "what is left of the swings counts as rest", True

    @property
    def goes_on(self) -> bool:
        """Whether another closed motion may follow."""
        return self.value[1]


class Coming(NamedTuple):
    """What ends a closed motion if no contact breaks before, and after which time."""

    lasts: float
    end: SwingEnd


class Swinging:
    """Closed motions of a body; it has no state of its own."""

    def __init__(self, body: DelayedBody, record: Record) -> None:
        """The record is told of falls of the spring's force."""
        self._body, self._record = body, record

    def swing(self) -> SwingEnd:
        """One closed motion, from the present state up to where it ends.

        1. A lump that is due now forms.
        2. The motion is that on the spring and the contacts that hold.
        3. If no contact breaks it ends with the leg, at the next births, or as the swing fades to rest.
        4. It ends before where the slider gets so far that contacts break; where these are so few that their force is
           none, and all break, the motion is that on the spring alone.
        5. The body goes there, and what happens there happens to it.
        """
        body = self._body
        if body.past.next_lump <= body.state.t * (1.0 + EPSILON):
            body.form_lump()
        # just after a passage it may be below 0 by its error
        held = Held(max(body.contacts.unbroken(), 0.0), body.contact_force_here)
        motion, calm = self._motion(held)
        births = self._next_births()
        lasts, end = self._coming(births, calm)
        if end is SwingEnd.BIRTHS_NEXT and motion.swings and motion.size > 0.0:
            lasts, end = self._while_some_form(motion, calm) or (lasts, end)
        if lasts <= 0.0:
            return SwingEnd.TOO_SHORT
        x = body.state.x
        near, drifts = body.near(x), motion.drift * lasts
        # a little farther than it gets, so that it surely does not pass that place
        farthest = motion.size + near + max(drifts, 0.0) + motion.centre
        farthest_back = motion.size + near - min(drifts, 0.0) - motion.centre
        forward, back = (
            body.contacts.distance_to_break(x, way, near, ALIKE * body.tolerance, max(enough, near))
            for way, enough in ((1, farthest), (-1, farthest_back))
        )
        exact = body.contacts.survival.atoms.size > 0
        # breaks of few contacts never count, but on a longer way than this one these would pull without breaking
        all_broken = np.inf if exact else body.contacts.all_broken_beyond(x)
        # +1 where contacts break as the slider goes forwards, -1 backwards, 0 where none does
        ends, breaks_at = motion.first_passing(
            -min(back, all_broken), min(forward, all_broken), lasts
        )
        if breaks_at and (forward if breaks_at > 0 else back) == np.inf:
            held, breaks_at = NONE_HOLDS, 0
            motion, calm = self._motion(held)
            ends, end = self._coming(births, calm)
        elif breaks_at:
            end = SwingEnd.BROKE_TOGETHER if exact else SwingEnd.BREAKS_NEXT
        lasts = ends
        if end is SwingEnd.BREAKS_NEXT and lasts < SHORTEST * motion.period:
            return SwingEnd.TOO_SHORT
        self._take(motion, lasts, held, end is SwingEnd.SOME_FORMED)
        if end is SwingEnd.BROKE_TOGETHER:
            body.break_together(x + (forward if breaks_at > 0 else -back), held.holding)
        elif end is SwingEnd.LEG_ENDED:
            body.end_leg()
        elif end is SwingEnd.LUMP_FORMS:
            body.take_time(body.past.next_lump)
        elif end is SwingEnd.BIRTHS_NEXT:
            body.take_time(births)
        return end

    def _motion(self, held: Held) -> tuple[Oscillation, float]:
        """The closed motion while these contacts hold, and the time after which its swing counts as rest; where it
        does so already the motion is without it, and that time inf."""
        body, machine = self._body, self._body.machine
        stiff, rate = machine.spring + held.holding, machine.spring * body.drive.speed
        given = machine.mass, machine.damping, stiff, body.spring_force - held.force, rate
        motion = Oscillation.of(*given, 0.0, body.state.w)
        quiet = QUIET * body.tolerance / (1.0 + machine.spring)
        if motion.size <= quiet:
            return Oscillation.of(*given, motion.centre, motion.drift), np.inf
        return motion, motion.time_until(quiet)

    def _next_births(self) -> float:
        """Up to when births change the force by less than half of what is alike."""
        body = self._body
        fraction = 0.5 * ALIKE * body.tolerance / body.machine.unit
        return body.past.next_birth(body.state.t, fraction)

    def _coming(self, births: float, calm: float) -> Coming:
        """What ends a motion if no contact breaks, with the next births at one time, and calm after another; of two at
        once the first named."""
        body = self._body
        lump = body.past.next_lump <= births
        coming = (
            Coming(body.drive.leg_end - body.state.t, SwingEnd.LEG_ENDED),
            Coming(births - body.state.t, SwingEnd.LUMP_FORMS if lump else SwingEnd.BIRTHS_NEXT),
            Coming(calm, SwingEnd.CALM),
        )
        return min(coming, key=lambda one: one.lasts)

    def _while_some_form(self, motion: Oscillation, calm: float) -> Coming | None:
        """What ends a motion of many swings in which few contacts form, so that these may form together at its end;
        None where it is too short.

        A share that forms anywhere in the swing is stretched by at most the whole swing, which may change the force by
        OF_SOME of the tolerance. Such motions follow each other, each ending later in the swing than it began, so that
        contacts that form at their ends take on average as much of the swing as if they had formed all along it.
        """
        body, period = self._body, motion.period
        most = OF_SOME * body.tolerance / min(2.0 * motion.size, body.machine.unit)
        most = min(most, SOME * body.contacts.unbroken())
        lasts = body.past.when_born(body.state.t, most) - body.state.t
        coming = self._coming(body.past.next_lump, calm)
        if min(lasts, coming.lasts) < RINGS_AT_LEAST * period:
            return None
        if coming.lasts <= lasts:
            return coming
        whole = np.floor(lasts / period - LATER_IN_SWING)
        return Coming(float(whole + LATER_IN_SWING) * period, SwingEnd.SOME_FORMED)

    def _take(self, motion: Oscillation, lasts: float, held: Held, some_formed: bool) -> None:
        """Go on to the end of a closed motion on which these contacts hold, and some form: results at the asked times,
        energies and falls on the way."""
        body, state, machine = self._body, self._body.state, self._body.machine
        which = body.asked(state.t, state.t + lasts)
        at = np.append(body.asked_times(which) - state.t, lasts)
        y, w = motion.travel(at), motion.speed(at)
        pulled = Pulled(machine.spring, machine.damping, body.drive.speed, body.spring_force)
        spent = motion.spent(at, y, pulled, held)
        ends = [
            SliderState(state.t + dt, state.x + dx, speed)
            for dt, dx, speed in zip(at.tolist(), y.tolist(), w.tolist(), strict=True)
        ]
        for index in range(which.start, which.stop):
            nth = index - which.start
            body.write(index, ends[nth], body.contacts, spent.at(nth))
        self._watch(motion, lasts)
        end, contacts = ends[-1], body.contacts.moved(ends[-1].x)
        if some_formed:
            reach = motion.bound(lasts) + abs(float(motion.departure(lasts)))
            body.take_rings(end, contacts, spent.at(-1), reach)
        else:
            body.take_swing(end, contacts, spent.at(-1))

    def _watch(self, motion: Oscillation, lasts: float) -> None:
        """Falls of the spring's force in a closed motion."""
        body, state = self._body, self._body.state
        breaks, unbroken = body.past.breaks + body.past.broken_together, body.contacts.unbroken()

        def at(t: float) -> Instant:
            return body.instant(state.t + t, state.x + float(motion.travel(t)), breaks)

        def seen(times: Array) -> Watched:
            """The slider at some times since the motion began, as the record asks for it to find falls of the force."""
            x, holding = state.x + motion.travel(times), np.full(times.size, unbroken)
            drives = body.drive.at(state.t + times)
            return body.watched(times, drives, x, holding, motion.speed, at)

        watch_closed(self._record, motion, lasts, seen)
