"""The next panel of time of a slider with mass: how wide it is, and the motion on it."""

import numpy as np

from master.outcome import StoppedError
from master.soft.inertia.delayed.body import DelayedBody
from master.soft.inertia.delayed.collocation import LEAST_PASSAGE, Collocation, Missed, Solved
from master.soft.inertia.delayed.fast_sliding import FastSliding
from master.soft.inertia.delayed.panel import NODES, POSITION, TimePanel
from master.soft.inertia.delayed.past_breaks import EPSILON
from master.soft.inertia.delayed.pull import MOST_CHANGE
from master.soft.inertia.delayed.width_control import WIDTHS

# Most panels of one run, of which a solution has up to five: a minute each.
MOST_PANELS = 60_000
# Speeds and errors of 0 are taken as that where they divide: the quotients are then bounded otherwise.
TINY = 1e-300


class PanelSearch:
    """The search for panels, each from the present state of a body on, which it leaves as it is.

    tried : panels so far, those that were not found or missed too much among them
    steady : whether sliding was nearly steady where the last panel began
    _width : of the next panel at most; inf where nothing tells it, as at first and after a closed motion
    _last : the panel before, whose polynomial is the first guess on the next; None where there is none to go on from
    """

    def __init__(self, body: DelayedBody, law: FastSliding) -> None:
        """Before the first panel."""
        self._body, self._law = body, law
        self.tried = 0
        self._width = np.inf
        self._last: TimePanel | None = None
        self.steady = False

    def begin_anew(self) -> None:
        """A closed motion came in between."""
        self._last, self._width = None, np.inf

    def follow(self, panel: TimePanel | None) -> None:
        """The next panel follows this one smoothly; None where it does not, as after a turn."""
        self._last = panel

    def next_up_to(self, stop: float) -> tuple[Solved, bool]:
        """The next panel, and whether it ends `at_stop`.

        A panel on which contacts form and break is tried first where it is the wider one. Else, or where it misses too
        much, a panel as wide as the last one's error lets it be, narrower until it misses little enough. What panels
        miss adds up over a contact's life, and could by itself keep sliding from being seen as nearly steady, for a
        whole slip of panels shorter than a threshold: near to it they miss less.
        """
        t, time_to_go = self._body.state.t, stop - self._body.state.t
        off = self._off_steady()
        self.steady = off <= 1.0
        fast = self._fast_width()
        if self._width < fast < time_to_go:
            solved = self.solve(fast)
            if solved is not None and solved.missed.largest <= self._body.accuracy:
                self._width = WIDTHS.growth * fast
                return solved, False
        width = self._width if np.isfinite(self._width) else self._first_width()
        width = min(width, self._fast_limit(), time_to_go)
        least = max(WIDTHS.least * t, WIDTHS.least_of_swing * self._swing_time)
        missed: Missed | None = None
        accuracy = self._body.accuracy * (WIDTHS.unbiased if 1.0 < off <= WIDTHS.biased else 1.0)
        while True:
            if width < least or self.tried >= MOST_PANELS:
                raise StoppedError(self._too_many(width, missed))
            at_stop = t + width >= stop * (1.0 - EPSILON)
            if at_stop:
                width = time_to_go
            solved = self.solve(width)
            if solved is None:
                width *= WIDTHS.most_shrink
                continue
            missed = solved.missed
            # the error goes as the width to the power of the number of nodes
            ratio = WIDTHS.aim * accuracy / max(missed.largest, TINY)
            ratio **= 1.0 / NODES.size
            if missed.largest <= accuracy:
                before, self._width = self._width, width * min(ratio, WIDTHS.growth)
                if at_stop and np.isfinite(before):
                    # a panel that an edge cut short does not make the next one narrow
                    self._width = max(self._width, before)
                return solved, at_stop
            width *= float(np.clip(ratio, WIDTHS.most_shrink, WIDTHS.least_shrink))

    def solve(self, width: float) -> Solved | None:
        """The motion on the next panel of this width, or None where that is too long to be found. The search begins at
        the speeds with which the last panel would go on, where the new one is less than twice as wide."""
        body, last = self._body, self._last
        self.tried += 1
        times = body.state.t + width * NODES
        guess = np.full(NODES.size, body.state.w)
        if last is not None and width < 2.0 * last.width:
            guess = last.slope(times, POSITION)
        search = Collocation(body.machine, body.contacts, self._law, body.past, body.accuracy)
        return search.solve(body.state, width, body.drive.at(times), guess, self.steady)

    def _off_steady(self) -> float:
        """By how much more or fewer contacts hold, or pull, than in nearly steady sliding of this speed, in units of
        the error that a panel may have. Contacts at exact thresholds break together, steadily never: inf.

        The rise of the speed is that under such a pull, from M a = K (X_T - X) - γ V - F_k(V) - a dF/da: it may differ
        from the present one by that error over M, which changes X by little before contacts have passed a threshold.
        """
        body, machine = self._body, self._body.machine
        (_, x, w), exact = body.state, body.contacts.survival.atoms.size
        if w == 0.0 or exact or body.past.lumps:
            return np.inf
        direction = float(np.sign(w))
        speed, none = np.array([direction * w]), np.zeros(1)
        of_speed = self._law.nearly_steady(speed, none, body.past.delay)
        response = body.contacts.response(np.array([x]))
        pull = direction * body.spring_force
        rise = (pull - machine.damping * speed - of_speed.force) / (machine.mass + of_speed.by_rise)
        steady = self._law.nearly_steady(speed, rise, body.past.delay)
        if float(steady.change[0]) > MOST_CHANGE:
            return np.inf
        force_off = abs(float(response.force[0]) - direction * float(steady.force[0]))
        holding_off = machine.unit * abs(float(response.holding[0]) - float(steady.holding[0]))
        return max(force_off, holding_off) / body.accuracy

    @property
    def _swing_time(self) -> float:
        """Time in which mass and damping follow the stiffest spring, that of all contacts beside the slider's."""
        machine = self._body.machine
        stiff = machine.spring + 1.0
        return float(np.sqrt(machine.mass / stiff) + machine.damping / stiff)

    def _first_width(self) -> float:
        """The width of the first panel after a closed motion."""
        travel = WIDTHS.first_travel * self._body.machine.unit
        at_speed = travel / max(abs(self._body.state.w), TINY)
        return max(WIDTHS.first_of_swing * self._swing_time, at_speed)

    def _fast_width(self) -> float:
        """The width of a panel on which contacts form and break, where the slider is fast enough for one, or where
        sliding is nearly steady; else 0."""
        body = self._body
        if self.steady:
            passing = body.machine.unit / max(abs(body.state.w), TINY)
            return WIDTHS.steady * max(passing, body.past.delay)
        travel = WIDTHS.fast * LEAST_PASSAGE * self._law.passage
        width = travel / max(abs(body.state.w), TINY)
        swing = float(np.sqrt(body.machine.mass / body.machine.spring))
        return width if width < min(body.past.delay, WIDTHS.of_swing * swing) else 0.0

    def _fast_limit(self) -> float:
        """The width up to which a panel on which contacts form and break ends before the slider stops; inf where it
        gets faster, or would stop within the way of such a panel."""
        machine, w = self._body.machine, self._body.state.w
        slows = (machine.damping * w - self._body.net_force) / machine.mass
        stops = w / slows if slows * w > 0.0 else np.inf
        long = 0.5 * abs(w) * stops >= LEAST_PASSAGE * self._law.passage
        return WIDTHS.of_stop * stops if long else np.inf

    def _too_many(self, width: float, missed: Missed | None) -> str:
        """Why the motion is not followed any farther than here."""
        state = self._body.state
        lacks = f"which misses {missed.why} by {missed.largest:.1e}" if missed else "not found"
        return (
            f"stopped after {self.tried} panels of time, as contacts break and form too often: at t = {state.t:.6g}, "
            f"X = {state.x:.6g} the last one was {width:.1e} wide, {lacks}; shorten the path or loosen the tolerance"
        )
