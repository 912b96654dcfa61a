"""A slider with mass while contacts break or form after a delay: its motion panel by panel of time."""

import numpy as np
from scipy.optimize import brentq

from master.outcome import StoppedError
from master.soft.inertia.delayed.body import EPSILON, DelayedBody
from master.soft.inertia.delayed.collocation import (
    LEAST_PASSAGE,
    Collocation,
    Missed,
    Solved,
    State,
)
from master.soft.inertia.delayed.contacts import Cohorts
from master.soft.inertia.delayed.panel import BREAKS, FORCE, NODES, POSITION, Panel
from master.soft.inertia.delayed.width_control import WIDTHS
from master.soft.inertia.record import Instant, crossing
from origins.thresholds.law import Array

# Most panels of one run, of which a solution has up to five: a minute each.
MOST_PANELS = 30_000


# Change of the force, in units of the error of a panel, below which all contacts born on it count as born at one place.
OF_MERGING = 1e-2
# Parts of a panel at which its speed is looked at.
PARTS = np.linspace(0.0, 1.0, 17)
# Way back, in units of the error of a panel, from which on a slider has turned: a polynomial may wind by its error.
TURNED = 2.0


class OnPanels(DelayedBody):
    """Motion on panels."""

    def _panel(self) -> bool:
        """Go on by one panel; returns whether the slider turned, or something else happened, so that none may break."""
        state, past = self._state, self._past
        if past.next_lump <= state.t:
            self._form_lump()
            return True
        self._kinks = [t for t in self._kinks if t > state.t * (1.0 + EPSILON)]
        stop = min([self._leg_end(), past.next_lump, *self._kinks])
        solved, reaches = self._solved(stop)
        panel, event = solved.panel, False
        turn = self._turn_in(panel)
        if turn is not None:
            panel, reaches, event = panel.cut(turn), False, True
            self._turns += 1
        else:
            level = self._level_in(panel)
            if level is not None:
                solved = self._up_to_level(solved, level)
                panel, reaches = solved.panel, False
                self._levels.remove(level)
                self._kink(panel.end)
        self._take(panel, solved, event)
        if reaches and stop == self._leg_end():
            self._next_leg()
        elif reaches:
            self._state = self._state._replace(t=stop)
        return event or self._out()

    def _solved(self, stop: float) -> tuple[Solved, bool]:
        """The next panel, and whether it reaches up to `stop`."""
        t, left = self._state.t, stop - self._state.t
        fast = self._fast_width()
        if self._width < fast < left:
            self._panels += 1
            solved = self._try(fast)
            if solved is not None and solved.missed.largest <= self._accuracy:
                self._width = WIDTHS.growth * fast
                return solved, False
        width = self._width if np.isfinite(self._width) else self._first_width()
        width = min(width, self._fast_limit(), left)
        least = max(WIDTHS.least * t, WIDTHS.least_of_swing * self._swing_time)
        missed: Missed | None = None
        while True:
            if width < least or self._panels >= MOST_PANELS:
                raise StoppedError(self._too_many(width, missed))
            reaches = t + width >= stop * (1.0 - EPSILON)
            if reaches:
                width = left
            self._panels += 1
            solved = self._try(width)
            if solved is None:
                width *= WIDTHS.most_shrink
                continue
            missed = solved.missed
            ratio = WIDTHS.aim * self._accuracy / max(missed.largest, 1e-300)
            ratio **= 1.0 / NODES.size
            if missed.largest <= self._accuracy:
                wider = width * min(ratio, WIDTHS.growth)
                # a panel that an edge cut short does not make the next one narrow
                self._width = max(wider, self._width if reaches and np.isfinite(self._width) else 0)
                return solved, reaches
            width *= float(np.clip(ratio, WIDTHS.most_shrink, WIDTHS.least_shrink))

    @property
    def _swing_time(self) -> float:
        """Time in which mass and damping follow the stiffest spring, that of all contacts beside the slider's."""
        stiff = self._machine.spring + 1.0
        return float(np.sqrt(self._machine.mass / stiff) + self._machine.damping / stiff)

    def _first_width(self) -> float:
        """The width of the first panel after a closed motion."""
        travel = WIDTHS.first_travel * self._machine.unit
        return max(
            WIDTHS.first_of_swing * self._swing_time, travel / max(abs(self._state.w), 1e-300)
        )

    def _fast_width(self) -> float:
        """The width of a panel on which contacts form and break, where the slider is fast enough for one; else 0."""
        way = WIDTHS.fast * LEAST_PASSAGE * self._sliding.longest
        width = way / max(abs(self._state.w), 1e-300)
        swing = float(np.sqrt(self._machine.mass / self._machine.spring))
        return width if width < min(self._past.delay, WIDTHS.of_swing * swing) else 0.0

    def _too_many(self, width: float, missed: Missed | None) -> str:
        """Why the motion is not followed any farther than here."""
        state = self._state
        lacks = f"which misses {missed.why} by {missed.largest:.1e}" if missed else "not found"
        return (
            f"stopped after {self._panels} panels of time, as contacts break and form too often: at t = {state.t:.6g}, "
            f"X = {state.x:.6g} the last one was {width:.1e} wide, {lacks}; shorten the path or loosen the tolerance"
        )

    def _fast_limit(self) -> float:
        """The width up to which a panel on which contacts form and break ends before the slider stops; inf where it
        gets faster, or would stop within the way of such a panel."""
        state, machine = self._state, self._machine
        held = self._contacts.response(np.array([state.x])).force[0]
        pull = machine.spring * (float(self._drive(state.t)) - state.x) - float(held)
        slows = (machine.damping * state.w - pull) / machine.mass
        stops = state.w / slows if slows * state.w > 0.0 else np.inf
        long = 0.5 * abs(state.w) * stops >= LEAST_PASSAGE * self._sliding.longest
        return WIDTHS.of_stop * stops if long else np.inf

    def _try(self, width: float) -> Solved | None:
        """The motion on the next panel of this width, or None where that is too long to be found. The search begins at
        the speeds with which the last panel would go on, where the new one is less than twice as wide."""
        state = self._state
        times = state.t + width * NODES
        last, guess = self._last, np.full(NODES.size, state.w)
        if last is not None and width < 2.0 * last.width:
            guess = last.slope(times, POSITION)
        search = Collocation(
            self._machine, self._contacts, self._sliding, self._past, self._accuracy
        )
        return search.solve(state, width, self._drive(times), guess)

    def _after(self, panel: Panel, solved: Solved, least_force: float) -> Cohorts:
        """The contacts after a panel, or after a part of the one that was solved; see Cohorts.after."""
        if solved.fast:
            end = float(panel.at(panel.end, POSITION))
            born, weight = self._sliding.born(panel, solved.panel, solved.birth_rate, least_force)
            return self._contacts.moved(end).and_born(born, weight, end)
        return self._contacts.after(panel, self._birth_rate(panel, solved), least_force)

    def _birth_rate(self, panel: Panel, solved: Solved) -> Array:
        """The rate of births at the nodes of a panel, which may be a part of the one that was solved."""
        whole = solved.panel
        if panel is whole:
            return solved.birth_rate
        at = (panel.times - whole.begin) / whole.width
        weights = np.vander(2.0 * at - 1.0, NODES.size) @ np.linalg.inv(
            np.vander(2.0 * NODES - 1.0, NODES.size)
        )
        return np.asarray(weights @ solved.birth_rate)

    def _turn_in(self, panel: Panel) -> float | None:
        """When the slider turns on the panel, if it does."""
        speed = panel.slope(panel.begin + PARTS * panel.width, POSITION)
        # from rest the slider sets out as it moves up to the first node: before it the polynomial may wind by its error
        way = np.sign(self._state.w) or np.sign(panel.nodes(POSITION)[0] - self._state.x)
        back = np.flatnonzero((way * speed[:-1] > 0.0) & (way * speed[1:] <= 0.0))
        for first in back.tolist():
            low, high = (panel.begin + panel.width * PARTS[first + k] for k in (0, 1))
            t = float(brentq(lambda t: float(panel.slope(t, POSITION)), low, high))
            later = panel.at(np.linspace(t, panel.end, 9), POSITION)
            gone = float((way * (later[0] - later)).max())
            if gone * (1.0 + self._machine.spring) > TURNED * self._accuracy and t > panel.begin:
                return t
        return None

    def _level_in(self, panel: Panel) -> float | None:
        """The first place on the panel at which the force has a kink."""
        begin, end = float(panel.at(panel.begin, POSITION)), float(panel.at(panel.end, POSITION))
        near = self._near(begin)
        passed = [x for x in self._levels if min(begin, end) < x < max(begin, end)]
        ahead = [x for x in passed if abs(x - begin) > near]
        return min(ahead, key=lambda x: abs(x - begin)) if ahead else None

    def _up_to_level(self, solved: Solved, level: float) -> Solved:
        """The panel up to where the slider passes a place."""
        near, best = self._near(level), solved
        for _ in range(8):
            panel = best.panel
            begin, end = (float(panel.at(t, POSITION)) for t in (panel.begin, panel.end))
            if abs(end - level) <= near:
                break
            if (end - level) * (begin - level) < 0.0:
                t = panel.when(POSITION, level)
            else:
                speed = float(panel.slope(panel.end, POSITION))
                t = panel.end + (level - end) / speed if speed else panel.end
            again = self._try(t - panel.begin) if t > panel.begin else None
            if again is None:
                break
            best = again
        return best

    def _take(self, panel: Panel, solved: Solved, turned: bool) -> None:
        """Take a panel, or a part of the one that was solved."""
        self._write(panel, solved)
        self._watch(panel)
        x, speed, pull = (
            panel.nodes(POSITION),
            panel.slope(panel.times, POSITION),
            panel.nodes(FORCE),
        )
        drive, k = self._drive(panel.times), self._machine.spring
        self._work += panel.integral(k * (drive - x)) * self._speed
        self._damped += panel.integral(self._machine.damping * speed**2)
        self._on_contacts += panel.integral(pull * speed)
        self._contacts = self._after(panel, solved, OF_MERGING * self._accuracy)
        self._past.add(panel)
        self._past.formed += panel.integral(self._birth_rate(panel, solved))
        w = 0.0 if turned else float(speed[-1])
        if turned:
            self._levels.append(float(x[-1]))
            self._last = None
        else:
            self._last = panel
        self._state = State(panel.end, float(x[-1]), w)
        self._form_rest()

    def _write(self, panel: Panel, solved: Solved) -> None:
        """Results at the asked times on the panel."""
        record, k = self._record, self._machine.spring
        which = record.between(panel.begin, panel.end)
        for at in range(which.start, which.stop):
            t = float(record.times[at])
            part = panel.cut(t) if panel.begin < t < panel.end else panel
            x, speed = panel.at(part.times, POSITION), panel.slope(part.times, POSITION)
            contacts = self._after(part, solved, 0.0)
            record.place[at], record.speed[at] = x[-1], speed[-1]
            record.work[at] = (
                self._work + part.integral(k * (self._drive(part.times) - x)) * self._speed
            )
            record.damped[at] = self._damped + part.integral(self._machine.damping * speed**2)
            record.on_contacts[at] = self._on_contacts + part.integral(
                panel.at(part.times, FORCE) * speed
            )
            self._write_contacts(at, contacts, float(x[-1]))

    def _watch(self, panel: Panel) -> None:
        """Falls of the spring's force on a panel."""
        times = panel.begin + PARTS * panel.width
        limit = max(self._way * self._speed, 0.0)

        def when(k: int) -> float:
            def excess(t: float) -> float:
                return self._way * float(panel.slope(t, POSITION)) - limit

            return crossing(excess, times[k], times[k + 1])

        def at(t: float) -> Instant:
            breaks = float(panel.at(t, BREAKS)) + self._past.broken_together
            return self._instant(t, float(panel.at(t, POSITION)), breaks)

        places = panel.at(times, POSITION), panel.slope(times, POSITION)
        past, ends = self._past, [panel.begin, panel.end]
        born = past.share + np.interp(times, ends, [past.born(t) for t in ends])
        held = born - past.broken_together - panel.at(times, BREAKS)
        self._record.watch(self._watched(times, places, held, self._drive(times), at, when))
