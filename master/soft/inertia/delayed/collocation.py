"""One panel of the motion of a slider with mass: Newton's method for its speeds at the nodes of Radau's rule.

With W the speeds at the nodes and A the matrix of integrals up to them, X = X_0 + A W, and

    M (W - W_0) + A (γ W + F + K (X - X_T)) = 0.

Births up to a node are the breaks up to one delay before. Where that lies on the same panel, they follow from the last
guess. Those born on the panel have survivals S(X_i - X_j), which integrals up to the node i are taken of.
"""

from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre

from master.soft.inertia.delayed.contacts import Cohorts
from master.soft.inertia.delayed.fast_sliding import FastSliding
from master.soft.inertia.delayed.panel import NODES, STAGES, TO_NODES, TO_SERIES, Panel
from master.soft.inertia.delayed.past_breaks import PastBreaks
from origins.thresholds.law import Array

# Most steps of Newton's method; it takes three or four, more where births depend on breaks of the same panel.
MOST_TRIES = 14
# Changes at which it has converged, in units of the error that a panel may have; and rounding, in mean thresholds.
CONVERGED, ROUNDING = 0.01, 3e-15
# Shortest way of a panel on which contacts form and break, in longest travels of a contact.
LEAST_PASSAGE = 2.0


class Machine(NamedTuple):
    """The slider: mass, damping and spring, per N_c<k>; unit : mean threshold (a length)."""

    mass: float
    damping: float
    spring: float
    unit: float


class State(NamedTuple):
    """The slider at an instant: time, X and dX/dt."""

    t: float
    x: float
    w: float


class Solved(NamedTuple):
    """A panel, the rate of births at its nodes, about the force that it misses (a length), and whether the slider is so
    `fast` that contacts form and break on it (see FastSliding)."""

    panel: Panel
    birth_rate: Array
    missed: float
    fast: bool


class PanelBirths:
    """The rate of births at the nodes of a panel: that of breaks, one delay before.

    all_known : whether they broke before the panel; at other nodes the rate is a guess, at first that at its beginning
    """

    def __init__(self, past: PastBreaks, begin: float, width: float) -> None:
        times = begin + width * NODES
        known = times - past.delay <= begin
        self.rate, self.all_known = np.zeros(NODES.size), bool(known.all())
        self.rate[known] = past.birth_rate(times[known])
        if not self.all_known:
            self.rate[~known] = float(past.birth_rate(np.array([begin]))[0])
            slopes = _slopes_at((times - past.delay - begin) / width)
            self._unknown, self._slopes = ~known, slopes[~known] / width

    def guess_from(self, breaks: Array) -> None:
        """Take the unknown rates from breaks at the panel's PLACES, the slopes of the polynomial through which they
        are, one delay before."""
        if not self.all_known:
            self.rate[self._unknown] = self._slopes @ breaks


class Pull(NamedTuple):
    """What all contacts do at the nodes i of a panel.

    holding, force : share that holds, and force (a length), shape (n,)
    by_place : derivatives of the forces by the places X_j, shape (i, j)
    by_speed : derivative of each force by the speed there, shape (n,)
    missed : error of the force (a length)
    """

    holding: Array
    force: Array
    by_place: Array
    by_speed: Array
    missed: float = 0.0


class Collocation:
    """The search for the motion on a panel that begins at some state of the slider and its contacts.

    accuracy : error of the force that the panel may have (a length)
    """

    def __init__(
        self,
        machine: Machine,
        contacts: Cohorts,
        sliding: FastSliding,
        past: PastBreaks,
        accuracy: float,
    ) -> None:
        self._machine, self._contacts, self._sliding = machine, contacts, sliding
        self._past, self._accuracy = past, accuracy

    def solve(self, state: State, width: float, drive: Array, guess: Array) -> Solved | None:
        """The motion over a time `width`, or None where that is too long to be found.

        drive : X_T at the nodes; guess : speeds there
        """
        m, g, k, unit = self._machine
        integral, births = width * TO_NODES, PanelBirths(self._past, state.t, width)
        held = self._contacts.response(np.array([state.x]))
        # conservation of number: what does not hold has broken, and not formed again
        formed = self._past.share + self._past.formed - self._past.broken_together
        broken_before = formed - float(held.holding[0])
        w, broken = guess, np.full(NODES.size, broken_before)
        travel, shortest = abs(float(integral[-1] @ w)), LEAST_PASSAGE * self._sliding.longest
        fast = bool(births.all_known and births.rate.any() and travel >= shortest)
        enough = CONVERGED * self._accuracy + ROUNDING * (unit + (1.0 + k) * abs(state.x))
        for _ in range(MOST_TRIES):
            x = state.x + integral @ w
            if not np.isfinite(x).all():
                return None
            pull = (self._fast if fast else self._slow)(x, w, births.rate, width)
            if pull is None:
                return None
            lack = m * (w - state.w) + integral @ (g * w + pull.force + k * (x - drive))
            by_speed = np.diag(g + pull.by_speed) + (pull.by_place + k * np.eye(w.size)) @ integral
            try:
                change = np.linalg.solve(m * np.eye(w.size) + integral @ by_speed, lack)
            except np.linalg.LinAlgError:
                return None
            w = w - change
            last, broken = broken, formed - pull.holding + integral @ births.rate
            births.guess_from(np.append(broken_before, broken))
            moved = float(np.abs(integral @ change).max())
            change_of_force = (min(float(pull.holding.max()), 1.0) + k) * moved
            if max(change_of_force, unit * float(np.abs(broken - last).max())) <= enough:
                break
        else:
            return None
        values = np.stack(
            [
                np.append(state.x, state.x + integral @ w),
                np.append(broken_before, broken),
                np.append(held.force[0], pull.force),
            ]
        )
        panel = Panel.through(state.t, width, values)
        travel = float(np.ptp(values[0]))
        if fast and travel < 0.5 * shortest:
            return None
        place, breaks, force = panel.last()
        # what a place misses changes the force by the stiffness of the contacts that hold, and by the spring
        stiffness = k + max(float(held.holding[0]), float(pull.holding.max()))
        missed = max(stiffness * place, unit * breaks, force, pull.missed)
        if not fast:
            # contacts that form and break on a panel are not resolved by its nodes
            born = float(integral[-1] @ births.rate)
            missed = max(missed, unit * born * min(travel / unit, 1.0) ** 4)
        if births.all_known:
            known = np.array([self._past.born_on_panels(t) for t in panel.times.tolist()])
            known -= self._past.born_on_panels(state.t)
            missed = max(missed, unit * float(np.abs(integral @ births.rate - known).max()))
        return Solved(panel, births.rate, float(missed), fast)

    def _fast(self, x: Array, w: Array, birth_rate: Array, width: float) -> Pull | None:
        """The contacts' pull at the places X and speeds, where those born on the panel break on it; None where the
        slider turns."""
        travel = width * TO_NODES @ w
        way = 1.0 if travel[-1] >= 0.0 else -1.0
        if (way * w <= 0.0).any():
            return None
        old = self._contacts.response(x)
        new = self._sliding.at(way * travel, birth_rate, way * w, width)
        drag = -new.force / np.abs(w)
        force = old.force + way * new.force
        return Pull(old.holding + new.holding, force, np.diag(old.slope), drag, new.missed)

    def _slow(self, x: Array, w: Array, birth_rate: Array, width: float) -> Pull:
        """The same where those born on the panel are summed node by node."""
        old, no_drag = self._contacts.response(x), np.zeros(x.size)
        counted = (
            width * TO_NODES * birth_rate
        )  # of births around the node j, those that count at i
        if not counted.any():
            return Pull(old.holding, old.force, np.diag(old.slope), no_drag)
        law, way = self._contacts.law, 1.0 if TO_NODES[-1] @ w >= 0.0 else -1.0
        stretch = way * (x[:, None] - x)
        size = np.abs(stretch)
        # continued smoothly to nodes after i, as the polynomials through all nodes need
        survival = np.asarray(law.sf(size))
        survival = np.where(stretch < 0.0, 2.0 - survival, survival)
        slope = counted * (survival - stretch * np.asarray(law.pdf(size)))
        return Pull(
            holding=old.holding + (counted * survival).sum(axis=1),
            force=old.force + (way * counted * stretch * survival).sum(axis=1),
            by_place=np.diag(old.slope) + np.diag(slope.sum(axis=1)) - slope,
            by_speed=no_drag,
        )


def _slopes_at(places: Array) -> Array:
    """The matrix from values at PLACES to the derivatives at places, those before the panel at its beginning."""
    z = 2.0 * np.maximum(places, 0.0) - 1.0
    return 2.0 * legendre.legvander(z, STAGES - 1) @ legendre.legder(TO_SERIES)
