"""A slider with mass while contacts break or form after a delay: its motion panel by panel of time."""

from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from master.soft.inertia.delayed.body import DelayedBody
from master.soft.inertia.delayed.cohorts import Cohorts
from master.soft.inertia.delayed.collocation import SliderState, Solved
from master.soft.inertia.delayed.fast_sliding import FastSliding
from master.soft.inertia.delayed.panel import (
    BREAKS,
    FORCE,
    NODES,
    POSITION,
    TimePanel,
    integrals_up_to,
)
from master.soft.inertia.delayed.panel_search import PanelSearch
from master.soft.inertia.delayed.pull import Sliding
from master.soft.inertia.record import Instant, Record, Spent
from origins import Contacts
from origins.thresholds.law import Array

# Change of the force, in units of the error of a panel, below which all contacts born on it count as born at one place.
OF_MERGING = 1e-2
# Parts of a panel at which its speed is looked at: some three to each of its five nodes.
PARTS = np.linspace(0.0, 1.0, 17)
# The matrix from values at a panel's nodes to integrals up to them, per width.
TO_PARTS = integrals_up_to(PARTS)
# And places behind a change of the speed's sign at which is looked how far back the slider goes.
LATER = 9
# Way back, in units of the error of a panel, from which on a slider has turned: a polynomial may wind by its error.
TURNED = 2.0
# Most panels that are tried until one ends at a bend: each is solved anew, and its end lands a little beside.
MOST_AIMS = 8


class Part(NamedTuple):
    """The beginning of the panel that was solved, or all of it: up to an asked time, or to a turn."""

    panel: TimePanel
    solved: Solved

    @property
    def birth_rate(self) -> Array:
        """The rate of births at the nodes of the part."""
        whole = self.solved.panel
        if self.panel is whole:
            return self.solved.birth_rate
        # the polynomial through the rates at the whole panel's nodes, at those of the part
        at = (self.panel.times - whole.begin) / whole.width
        to_powers = np.linalg.inv(np.vander(2.0 * NODES - 1.0, NODES.size))
        weights = np.vander(2.0 * at - 1.0, NODES.size) @ to_powers
        return np.asarray(weights @ self.solved.birth_rate)

    def end(self, speed: float | None = None) -> SliderState:
        """The slider at its end; with this speed, if one is given."""
        x, w = self.panel.nodes(POSITION)[-1], self.panel.slope(self.panel.times, POSITION)[-1]
        return SliderState(self.panel.end, float(x), float(w) if speed is None else speed)


class OnPanels:
    """Motion of a body on panels.

    search : finds each panel from the state of the body on
    turns : how often the slider turned on one
    _bends : positions at which the contacts' force bends, until the slider passes them: where it turned, and where
        contacts of a start at one stretch reach a bend of P_c, which are `_of_law`, too
    """

    def __init__(
        self, body: DelayedBody, law: FastSliding, record: Record, contacts: Contacts
    ) -> None:
        """Before the first panel; `law`: what the contacts' law says of a slider that passes many thresholds; the
        record is told of falls of the spring's force."""
        self._body, self._record, self._law = body, record, law
        self.search = PanelSearch(body, law)
        self.turns = 0
        self._bends = list[float]()
        if contacts.start.is_single:
            start, bends = contacts.start.mean(), contacts.thresholds.breakpoints
            for bend in bends[bends > abs(start)].tolist():
                self._bends += [bend - start, -bend - start]
        self._of_law = set(self._bends)

    def advance(self) -> bool:
        """Go on by one panel; returns whether the slider turned, or something else happened, so that none may break."""
        body, past = self._body, self._body.past
        if past.next_lump <= body.state.t:
            body.form_lump()
            return True
        stop = min(body.drive.leg_end, past.next_lump, past.next_kink(body.state.t))
        solved, at_stop = self.search.next_up_to(stop)
        turn, bend = self._turn_in(solved.panel), None
        if turn is not None:
            part, at_stop = Part(solved.panel.cut(turn), solved), False
            self.turns += 1
        else:
            bend = self._bend_in(solved.panel)
            if bend is not None:
                whole, solved = solved, self._up_to(bend, solved)
                at_stop = at_stop and solved is whole
            part = Part(solved.panel, solved)
        self._take(part, turn is not None)
        if bend is not None:
            self._passed(bend, solved.panel)
        if at_stop and stop == body.drive.leg_end:
            body.end_leg()
        elif at_stop:
            body.take_time(stop)
        return turn is not None or body.hardly_any_holds

    def _turn_in(self, panel: TimePanel) -> float | None:
        """When the slider turns on the panel, if it does: its speed changes the sign between two of the PARTS, and from
        there on it goes back farther than the panel's polynomial may wind."""
        body = self._body
        speed = panel.slope(panel.begin + PARTS * panel.width, POSITION)
        # from rest the slider sets out as it moves up to the first node: before it the polynomial may wind by its error
        direction = np.sign(body.state.w) or np.sign(panel.nodes(POSITION)[0] - body.state.x)
        back = np.flatnonzero((direction * speed[:-1] > 0.0) & (direction * speed[1:] <= 0.0))
        for first in back.tolist():
            low, high = (panel.begin + panel.width * PARTS[first + k] for k in (0, 1))
            t = float(brentq(lambda t: float(panel.slope(t, POSITION)), low, high))
            later = panel.at(np.linspace(t, panel.end, LATER), POSITION)
            gone = float((direction * (later[0] - later)).max())
            if gone * (1.0 + body.machine.spring) > TURNED * body.accuracy and t > panel.begin:
                return t
        return None

    def _bend_in(self, panel: TimePanel) -> float | None:
        """The first place on the panel at which the force has a kink."""
        begin, end = _ends(panel)
        near = self._body.near(begin)
        met = [x for x in self._bends if min(begin, end) < x < max(begin, end)]
        ahead = sorted((x for x in met if abs(x - begin) > near), key=lambda x: abs(x - begin))
        for bend in ahead:
            if bend in self._of_law or self._counts(bend):
                return bend
            self._bends.remove(bend)
        return None

    def _counts(self, turn: float) -> bool:
        """Whether the kink of the force where the slider turned may be seen: most of thousands of turns while it rings
        on its contacts stretch hardly any contact farther than others did."""
        body = self._body
        share = body.contacts.breaking_on_from(turn, body.near(turn))
        return share * body.machine.unit > body.accuracy

    def _up_to(self, bend: float, solved: Solved) -> Solved:
        """The panel up to where the slider passes a bend that lies on it; where none is found that ends there and is
        as good, the nearest so far, which may end before the bend or beyond it."""
        near, best = self._body.near(bend), solved
        for _ in range(MOST_AIMS):
            panel = best.panel
            begin, end = _ends(panel)
            if abs(end - bend) <= near:
                break
            if (end - bend) * (begin - bend) < 0.0:
                t = panel.when(POSITION, bend)
            else:
                speed = float(panel.slope(panel.end, POSITION))
                t = panel.end + (bend - end) / speed if speed else panel.end
            shorter = self.search.solve(t - panel.begin) if t > panel.begin else None
            if shorter is None or shorter.missed.largest > self._body.accuracy:
                break
            best = shorter
        return best

    def _passed(self, bend: float, panel: TimePanel) -> None:
        """Forget a bend, and note the kink of the breaks there, if the slider passed it on the panel; the next panel
        aims at it again where this one ended before it."""
        begin, end = _ends(panel)
        if abs(end - bend) <= self._body.near(bend):
            self._bends.remove(bend)
            self._body.past.kink(panel.end)
        elif (end - bend) * (begin - bend) < 0.0:
            self._bends.remove(bend)
            self._body.past.kink(panel.when(POSITION, bend))

    def _take(self, part: Part, turned: bool) -> None:
        """Go on to the end of the panel, or of the part of it on which the slider did not turn."""
        body, panel = self._body, part.panel
        self._write(part)
        self._watch(part)
        end = part.end(0.0 if turned else None)
        contacts = self._after(part, OF_MERGING * body.accuracy)
        formed, spent = panel.integral(part.birth_rate), self._spent(panel)
        if turned:
            self._bends.append(end.x)
        self.search.follow(None if turned else panel)
        steady = part.solved.sliding is Sliding.STEADY
        body.take_panel(panel, end, contacts, formed, spent, steady)

    def _after(self, part: Part, least_force: float) -> Cohorts:
        """The contacts after a part of a panel; see Cohorts.after."""
        panel, contacts = part.panel, self._body.contacts
        if part.solved.sliding is not Sliding.SLOW:
            end = float(panel.at(panel.end, POSITION))
            solved = part.solved
            born, weight = self._law.born(panel, solved.panel, solved.birth_rate, least_force)
            return contacts.moved(end).and_born(born, weight, end)
        return contacts.after(panel, part.birth_rate, least_force)

    def _spent(self, panel: TimePanel) -> Spent:
        """Energies of the motion on a panel."""
        body, x = self._body, panel.nodes(POSITION)
        speed, pull = panel.slope(panel.times, POSITION), panel.nodes(FORCE)
        of_spring = panel.integral(body.machine.spring * (body.drive.at(panel.times) - x))
        return Spent(
            work=of_spring * body.drive.speed,
            damped=panel.integral(body.machine.damping * speed**2),
            on_contacts=panel.integral(pull * speed),
        )

    def _write(self, part: Part) -> None:
        """Results at the asked times on a part of a panel."""
        body, panel = self._body, part.panel
        which = body.asked(panel.begin, panel.end)
        for at, t in zip(
            range(which.start, which.stop), body.asked_times(which).tolist(), strict=True
        ):
            cut = panel.cut(t) if panel.begin < t < panel.end else panel
            so_far = Part(cut, part.solved)
            # of the whole part: one cut to next to nothing has a slope of rounding
            end = so_far.end(float(panel.slope(t, POSITION)))
            body.write(at, end, self._after(so_far, 0.0), self._spent(cut))

    def _watch(self, part: Part) -> None:
        """Falls of the spring's force on a part of a panel."""
        body, past, panel = self._body, self._body.past, part.panel
        times = panel.begin + PARTS * panel.width

        def speed(t: Array | float) -> Array:
            return np.asarray(panel.slope(t, POSITION))

        def at(t: float) -> Instant:
            breaks = float(panel.at(t, BREAKS)) + past.broken_together
            return body.instant(t, float(panel.at(t, POSITION)), breaks)

        x, drives = panel.at(times, POSITION), body.drive.at(times)
        formed = past.formed + panel.width * (TO_PARTS @ part.birth_rate)
        holding = past.holding(formed, panel.at(times, BREAKS))
        self._record.watch(body.watched(times, drives, x, holding, speed, at))


def _ends(panel: TimePanel) -> tuple[float, float]:
    """X at a panel's beginning and at its end."""
    return float(panel.at(panel.begin, POSITION)), float(panel.at(panel.end, POSITION))
