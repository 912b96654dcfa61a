"""What contacts do at the nodes of a panel of time: how many hold, and how they pull, by the slider's speeds there."""

from enum import Enum
from typing import NamedTuple

import numpy as np

from master.soft.inertia.delayed.cohorts import Cohorts
from master.soft.inertia.delayed.fast_sliding import FastSliding
from master.soft.inertia.delayed.panel import SLOPES, TO_NODES
from master.soft.inertia.delayed.panel_births import PanelBirths, SteadyBirths
from origins.thresholds.law import Array

# Change of sliding that is nearly steady, while a contact lives and waits, up to which it is tried: what is left out is
# of second order in it, and each panel tells how much that is.
MOST_CHANGE = 0.25


class Sliding(Enum):
    """How contacts that form on a panel are followed.

    SLOW : node by node, as hardly any of them breaks on it
    FAST : by the present rate of births and its slope, as many form and break on it (FastSliding.at)
    STEADY : by the slider's speed and its slope, as on it births follow from breaks, too (FastSliding.nearly_steady)
    """

    SLOW = "slow"
    FAST = "fast"
    STEADY = "steady"


class Pull(NamedTuple):
    """What all contacts do at the nodes i of a panel.

    holding, force : share that holds, and force (a length), shape (n,)
    by_place, by_speed : derivatives of the forces by the places X_j and by the speeds there, shape (i, j)
    missed : error of the force (a length)
    """

    holding: Array
    force: Array
    by_place: Array
    by_speed: Array
    missed: float = 0.0


class PullOnPanel:
    """The pull of contacts on a panel that begins with some of them and with a speed of the slider.

    births : on the panel; sliding : how the contacts that they are of are followed

    _contacts : those that have formed before it; _law : what their law says of a fast slider
    _width : of the panel; _delay : after which contacts form again; _first_speed : dX/dt where the panel begins
    """

    def __init__(
        self,
        contacts: Cohorts,
        law: FastSliding,
        width: float,
        delay: float,
        first_speed: float,
        births: PanelBirths | SteadyBirths,
        sliding: Sliding,
    ) -> None:
        self.births, self.sliding = births, sliding
        self._contacts, self._law = contacts, law
        self._width, self._delay, self._first_speed = width, delay, first_speed

    def at(self, x: Array, w: Array) -> Pull | None:
        """At the places X and speeds at the nodes; None where contacts cannot be followed so. In nearly steady sliding
        the speeds tell the births, too."""
        if isinstance(self.births, SteadyBirths):
            return self._steady(w, self.births)
        return (self._fast if self.sliding is Sliding.FAST else self._slow)(x, w, self.births.rate)

    def _steady(self, w: Array, births: SteadyBirths) -> Pull | None:
        """Where sliding is nearly steady; None where the slider turns, or its speed changes by much while contacts live
        and wait."""
        way = _way(w)
        speed = way * w
        if (speed <= 0.0).any() or way * self._first_speed <= 0.0:
            return None
        # of the polynomial through the speeds at the beginning and at the nodes
        slopes = SLOPES / self._width
        rise = way * (slopes @ np.append(self._first_speed, w))
        found = self._law.nearly_steady(speed, rise, self._delay)
        if (found.change > MOST_CHANGE).any():
            return None
        births.take(found.birth_rate)
        return Pull(
            holding=found.holding,
            force=way * found.force,
            by_place=np.zeros((w.size, w.size)),
            by_speed=np.diag(found.by_speed) + found.by_rise[:, None] * slopes[:, 1:],
            missed=float(found.missed.max()),
        )

    def _fast(self, x: Array, w: Array, birth_rate: Array) -> Pull | None:
        """The contacts' pull at the places X and speeds, where those born on the panel break on it; None where the
        slider turns."""
        travel, way = self._width * TO_NODES @ w, _way(w)
        if (way * w <= 0.0).any():
            return None
        old = self._contacts.response(x)
        new = self._law.at(way * travel, birth_rate, way * w, self._width)
        drag = -new.force / np.abs(w)
        force = old.force + way * new.force
        return Pull(old.holding + new.holding, force, np.diag(old.slope), np.diag(drag), new.missed)

    def _slow(self, x: Array, w: Array, birth_rate: Array) -> Pull:
        """The same where those born on the panel are summed node by node.

        The integral over births up to the node i is taken of the polynomial through all nodes, which needs S also for
        births after i, at stretches below 0. There 2 - S(|y|) goes on with the value and the slope of S; S(|y|) would
        have a kink where P_c(0) > 0, which costs breaks and force a power of the panel's width each."""
        old, no_drag = self._contacts.response(x), np.zeros((x.size, x.size))
        # of births around the node j, those that count at i
        counted = self._width * TO_NODES * birth_rate
        if not counted.any():
            return Pull(old.holding, old.force, np.diag(old.slope), no_drag)
        way = _way(w)
        stretch = way * (x[:, None] - x)
        survival, density = self._contacts.survival.sf_and_pdf(np.abs(stretch))
        survival = np.where(stretch < 0.0, 2.0 - survival, survival)
        # of the force at i by X_i - X_j: y S(y) has the slope S - y P_c
        slope = counted * (survival - stretch * density)
        return Pull(
            holding=old.holding + (counted * survival).sum(axis=1),
            force=old.force + way * (counted * stretch * survival).sum(axis=1),
            by_place=np.diag(old.slope) + np.diag(slope.sum(axis=1)) - slope,
            by_speed=no_drag,
        )


def _way(w: Array) -> float:
    """+1 where the slider moves forwards over the panel with these speeds at the nodes, -1 back. Along the way travel,
    speed, and the stretch and force of contacts born on the panel are above 0; times this they are those of X."""
    return 1.0 if TO_NODES[-1] @ w >= 0.0 else -1.0
