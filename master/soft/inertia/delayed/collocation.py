"""One panel of the motion of a slider with mass: Newton's method for its speeds at the nodes of Radau's rule.

With W the speeds at the nodes and A the matrix of integrals up to them, X = X_0 + A W, and

    M (W - W_0) + A (γ W + F + K (X - X_T)) = 0.

Births up to a node are the breaks up to one delay before, so that none is lost whatever their rate is in between. Where
that lies on the same panel, births and breaks are solved together, for given places X. Those born on the panel have
survivals S(X_i - X_j), which integrals up to the node i are taken of. Where sliding is nearly steady births follow from
the speed (`Sliding`).
"""

from typing import NamedTuple

import numpy as np

from master.soft.inertia.delayed.cohorts import Cohorts
from master.soft.inertia.delayed.fast_sliding import FastSliding
from master.soft.inertia.delayed.panel import (
    LAST_OF_NODES,
    NODES,
    PLACES,
    POSITION,
    STAGES,
    TO_NODES,
    TimePanel,
)
from master.soft.inertia.delayed.panel_births import PanelBirths, SteadyBirths
from master.soft.inertia.delayed.past_breaks import PastBreaks
from master.soft.inertia.delayed.pull import ContactsAtNodes, PullOnPanel, Sliding
from origins.thresholds.law import Array

# Most steps of Newton's method; it takes three or four.
MOST_TRIES = 8
# Changes at which it has converged, in units of the error that a panel may have; and rounding, in mean thresholds.
CONVERGED, ROUNDING = 0.01, 3e-15
# Shortest travel on a panel on which contacts form and break, in passages (see FastSliding).
LEAST_PASSAGE = 2.0
# By this factor the travel, which is guessed before the motion is found, may be too long for such a panel.
GUESSED = 2.0
# Largest integral up to a node of the last Legendre polynomial through the nodes, in widths of the panel. For degree
# n it is (P_(n+1) - P_(n-1))/(4 n + 2), at most 1/(2 n + 1).
INTEGRAL_OF_LAST = 1.0 / (2 * STAGES - 1)
UNIT: Array = np.eye(STAGES)


class SliderConstants(NamedTuple):
    """The slider: mass, damping and spring, per N_c<k>; unit : mean threshold (a length)."""

    mass: float
    damping: float
    spring: float
    unit: float


class SliderState(NamedTuple):
    """The slider at an instant: time, X and dX/dt."""

    t: float
    x: float
    w: float


class Missed(NamedTuple):
    """About what a panel misses of the force, by cause (lengths); how each is found says Collocation._missed.

    place, breaks, force, births : of their polynomials; births bend where breaks did, one delay before
    fast : of contacts that form and break on the panel, beyond the terms that FastSliding takes
    unresolved : of contacts that do so between its nodes
    late : of births that count as later than they are
    """

    place: float
    breaks: float
    force: float
    births: float
    fast: float = 0.0
    unresolved: float = 0.0
    late: float = 0.0

    @property
    def largest(self) -> float:
        """Of all."""
        return max(self)

    @property
    def why(self) -> str:
        """The name of the largest."""
        return self._fields[int(np.argmax(self))]


class Solved(NamedTuple):
    """A panel, the rate of births at its nodes, what it misses, and how those born on it were followed."""

    panel: TimePanel
    birth_rate: Array
    missed: Missed
    sliding: Sliding


class PanelBegin(NamedTuple):
    """A panel's beginning: the slider, the contacts' force (a length), the share that holds, and the share that would
    hold if none had broken but in lumps; less the breaks it is the share that holds."""

    state: SliderState
    force: float
    holding: float
    if_none_broke: float

    @property
    def broken(self) -> float:
        """Share that has broken one by one since t = 0."""
        return self.if_none_broke - self.holding


class Iterate(NamedTuple):
    """Newton's guess at the nodes: speeds, breaks since t = 0, and what the contacts do."""

    speed: Array
    broken: Array
    pull: ContactsAtNodes


class Collocation:
    """The search for the motion on a panel that begins at some state of the slider and its contacts.

    accuracy : error of the force that the panel may have (a length)
    """

    def __init__(
        self,
        machine: SliderConstants,
        contacts: Cohorts,
        law: FastSliding,
        past: PastBreaks,
        accuracy: float,
    ) -> None:
        self._machine, self._contacts, self._law = machine, contacts, law
        self._past, self._accuracy = past, accuracy
        # shortest travel on a panel on which contacts form and break
        self._shortest = LEAST_PASSAGE * law.passage

    def solve(
        self, state: SliderState, width: float, drive: Array, guess: Array, steady: bool = False
    ) -> Solved | None:
        """The motion over a time `width`, or None where that is too long to be found.

        drive : X_T at the nodes; guess : speeds there
        steady : whether sliding is nearly steady at the beginning; it is followed so on panels longer than the delay,
            on which the slider passes a mean threshold
        """
        response, past = self._contacts.response(np.array([state.x])), self._past
        force, holding = float(response.force[0]), float(response.holding[0])
        begin = PanelBegin(state, force, holding, past.holding(past.formed, 0.0))
        births: PanelBirths | SteadyBirths = PanelBirths(past, state.t, width)
        distance = width * abs(float(TO_NODES[-1] @ guess))
        sliding = Sliding.SLOW
        if steady and width > past.delay and distance >= self._machine.unit:
            sliding, births = Sliding.STEADY, SteadyBirths(width)
        elif births.all_before and births.born[-1] and distance >= self._shortest:
            sliding = Sliding.FAST
        contacts = PullOnPanel(
            self._contacts, self._law, width, past.delay, state.x, state.w, holding, births, sliding
        )
        found = self._newton(begin, width, drive, guess, contacts)
        return found and self._judged(begin, width, found, contacts)

    def _newton(
        self, begin: PanelBegin, width: float, drive: Array, guess: Array, contacts: PullOnPanel
    ) -> Iterate | None:
        """Newton's method for the speeds at the nodes; None where it does not converge. `lack` is the left side at the
        head of this file; as X = X_0 + A W, its derivative by W is M + A (γ + dF/dW + (dF/dX + K) A)."""
        m, g = self._machine.mass, self._machine.damping
        k, unit = self._machine.spring, self._machine.unit
        (_, x_0, w_0), integral = begin.state, width * TO_NODES
        enough = CONVERGED * self._accuracy + ROUNDING * (unit + (1.0 + k) * abs(x_0))
        w, broken = guess, np.full(NODES.size, begin.broken)
        for _ in range(MOST_TRIES):
            x = x_0 + integral @ w
            if not np.isfinite(x).all():
                return None
            pull = contacts.at(x, w)
            if pull is None:
                return None
            lack = m * (w - w_0) + integral @ (g * w + pull.force + k * (x - drive))
            by_speed = g * UNIT + pull.by_speed + (pull.by_place + k * UNIT) @ integral
            try:
                change = np.linalg.solve(m * UNIT + integral @ by_speed, lack)
            except np.linalg.LinAlgError:
                return None
            w = w - change
            last, broken = broken, begin.if_none_broke - pull.holding + contacts.births.born[1:]
            moved = float(np.abs(integral @ change).max())
            change_of_force = (min(float(pull.holding.max()), 1.0) + k) * moved
            if max(change_of_force, unit * float(np.abs(broken - last).max())) <= enough:
                return Iterate(w, broken, pull)
        return None

    def _judged(
        self, begin: PanelBegin, width: float, found: Iterate, contacts: PullOnPanel
    ) -> Solved | None:
        """The panel, and what it misses; None where one with fast sliding is too short to be one."""
        t, x_0, _ = begin.state
        values = np.empty((3, PLACES.size))
        values[:, 0] = x_0, begin.broken, begin.force
        values[:, 1:] = x_0 + width * TO_NODES @ found.speed, found.broken, found.pull.force
        panel = TimePanel.through(t, width, values)
        too_short = np.ptp(values[0]) < self._shortest / GUESSED
        if contacts.sliding is Sliding.FAST and too_short:
            return None
        missed = self._missed(begin, panel, found, contacts)
        return Solved(panel, contacts.births.rate, missed, contacts.sliding)

    def _missed(
        self, begin: PanelBegin, panel: TimePanel, found: Iterate, contacts: PullOnPanel
    ) -> Missed:
        """What a panel misses of the force.

        Where a polynomial is the answer, it misses about its last coefficients. A place that is off changes the force
        by the stiffness of the contacts that hold and of the spring. A share of the contacts that is off changes it by
        up to a mean threshold u each: one stretched by y holds with a probability S(y) <= u/y (Markov's inequality), so
        that its force is y S(y) <= u on average. Two terms are not last coefficients of the panel's polynomials:

        - unresolved: of those born on the panel, integrals over births of S(X_i - X) hold at the node i. They are those
          of a polynomial in time through the nodes. `births` says what it misses of the births; what it misses of S is
          about its last coefficient, whose integral is at most INTEGRAL_OF_LAST of it.
        - late: the few that broke in a closed motion form at no time that is known, and count as born at the panel's
          end. At that end they are stretched by up to the panel's travel instead of 0.
        """
        unit, past, x = self._machine.unit, self._past, panel.nodes(POSITION)
        births, sliding = contacts.births, contacts.sliding
        place, breaks, force = panel.last().tolist()
        # stiffness of the contacts; where sliding is nearly steady their force does not hang on the place
        holding = max(begin.holding, float(found.pull.holding.max()))
        if sliding is Sliding.STEADY:
            holding = 0.0
        travel = float(np.ptp(np.append(begin.state.x, x)))
        born, unresolved = float(births.born[-1]), 0.0
        if born and sliding is Sliding.SLOW:
            survival = self._contacts.survival.sf(np.abs(x[-1] - x))
            unresolved = unit * abs(born * float(LAST_OF_NODES @ survival)) * INTEGRAL_OF_LAST
        # where some break on the panel itself no closed motion lies one delay before it
        due = past.born(panel.end) - past.formed - born if births.all_before else 0.0
        return Missed(
            place=(self._machine.spring + holding) * place,
            breaks=unit * breaks,
            force=force,
            births=unit * births.missed,
            fast=found.pull.missed,
            unresolved=unresolved,
            late=abs(due) * min(travel, unit),
        )
