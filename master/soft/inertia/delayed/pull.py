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


class ContactsAtNodes(NamedTuple):
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
    """The pull of contacts on a panel that begins with some of them, at a place and with a speed of the slider.

    births : on the panel; sliding : how the contacts that they are of are followed

    _contacts : those that have formed before it; _law : what their law says of a fast slider
    _width : of the panel; _delay : after which contacts form again
    _first_place, _first_speed : X and dX/dt where the panel begins
    _holding_before : share that holds there
    """

    def __init__(
        self,
        contacts: Cohorts,
        law: FastSliding,
        width: float,
        delay: float,
        first_place: float,
        first_speed: float,
        holding_before: float,
        births: PanelBirths | SteadyBirths,
        sliding: Sliding,
    ) -> None:
        self.births, self.sliding = births, sliding
        self._contacts, self._law = contacts, law
        self._width, self._delay, self._holding_before = width, delay, holding_before
        self._first_place, self._first_speed = first_place, first_speed

    def at(self, x: Array, w: Array) -> ContactsAtNodes | None:
        """At the places X and speeds at the nodes; None where contacts cannot be followed so. In nearly steady sliding
        the speeds tell the births, too."""
        if isinstance(self.births, SteadyBirths):
            return self._steady(w, self.births)
        if self.sliding is Sliding.FAST:
            return self._fast(x, w, self.births.rate)
        return self._slow(x, self.births)

    def _steady(self, w: Array, births: SteadyBirths) -> ContactsAtNodes | None:
        """Where sliding is nearly steady; None where the slider turns, or its speed changes by much while contacts live
        and wait."""
        direction = _direction(w)
        speed = direction * w
        if (speed <= 0.0).any() or direction * self._first_speed <= 0.0:
            return None
        # of the polynomial through the speeds at the beginning and at the nodes
        slopes = SLOPES / self._width
        rise = direction * (slopes @ np.append(self._first_speed, w))
        found = self._law.nearly_steady(speed, rise, self._delay)
        if (found.change > MOST_CHANGE).any():
            return None
        births.take(found.birth_rate)
        return ContactsAtNodes(
            holding=found.holding,
            force=direction * found.force,
            by_place=np.zeros((w.size, w.size)),
            by_speed=np.diag(found.by_speed) + found.by_rise[:, None] * slopes[:, 1:],
            missed=float(found.missed.max()),
        )

    def _fast(self, x: Array, w: Array, birth_rate: Array) -> ContactsAtNodes | None:
        """The contacts' pull at the places X and speeds, where those born on the panel break on it; None where the
        slider turns."""
        travel, direction = self._width * TO_NODES @ w, _direction(w)
        if (direction * w <= 0.0).any():
            return None
        old = self._contacts.response(x)
        new = self._law.at(direction * travel, birth_rate, direction * w, self._width)
        drag = -new.force / np.abs(w)
        force = old.force + direction * new.force
        return ContactsAtNodes(
            old.holding + new.holding, force, np.diag(old.slope), np.diag(drag), new.missed
        )

    def _slow(self, x: Array, births: PanelBirths) -> ContactsAtNodes | None:
        """The contacts' pull at the places X where those born on the panel are summed node by node, with births that
        are the breaks one delay before also where these are on the panel.

        With b the births at PLACES, those that hold are h = h_0 + H b and F = F_0 + G b, where h_0 and F_0 are of the
        contacts that have formed before. As no contact is lost, breaks since the panel's beginning are h(begin) - h + b
        at the nodes, so that b solves a linear system, and so does db/dX; None where that has no solution.

        The integral over births up to the node i is taken of the polynomial through all nodes, which needs S also for
        births after i, at stretches below 0. There 2 - S(|y|) goes on with the value and the slope of S; S(|y|) would
        have a kink where P_c(0) > 0, which costs breaks and force a power of the panel's width each."""
        old = self._contacts.response(x)
        if births.all_before and not births.born[-1]:
            no_drag = np.zeros((x.size, x.size))
            return ContactsAtNodes(old.holding, old.force, np.diag(old.slope), no_drag)
        direction = 1.0 if x[-1] >= self._first_place else -1.0
        stretch = direction * (x[:, None] - x)
        survival, density = self._contacts.survival.sf_and_pdf(np.abs(stretch))
        survival = np.where(stretch < 0.0, 2.0 - survival, survival)
        # H and G: what births at PLACES add to those that hold, and to the force, at the nodes
        to_holding, to_force = (
            TO_NODES * each @ SLOPES for each in (survival, direction * stretch * survival)
        )
        if not births.all_before:
            of_breaks, before = births.of_breaks[:, 1:], self._holding_before
            system = np.eye(x.size + 1) - of_breaks @ (np.eye(x.size, x.size + 1, 1) - to_holding)
            try:
                solved = np.linalg.solve(system, np.column_stack([of_breaks, births.of_past]))
            except np.linalg.LinAlgError:
                return None
            to_births = solved[:, :-1]
            births.take(solved[:, -1] + to_births @ (before - old.holding))
        counted = self._width * TO_NODES * births.rate
        # S and y S(y) have the slopes -P_c and S - y P_c, by X_i - X_j
        by_place = _of_differences(counted * (survival - stretch * density), old.slope)
        if not births.all_before:
            holding_by_place = _of_differences(-direction * counted * density, old.of_holding)
            by_place = by_place - to_force @ to_births @ holding_by_place
        return ContactsAtNodes(
            holding=old.holding + to_holding @ births.born,
            force=old.force + to_force @ births.born,
            by_place=by_place,
            by_speed=np.zeros((x.size, x.size)),
        )


def _of_differences(slopes: Array, own: Array) -> Array:
    """Derivatives by X_j of sums over j of functions of X_i - X_j, which have these slopes (i, j), and of a function of
    X_i, which has its `own` (i,)."""
    return np.diag(own + slopes.sum(axis=1)) - slopes


def _direction(w: Array) -> float:
    """+1 where the slider moves forwards over the panel with these speeds at the nodes, -1 back. Along the way travel,
    speed, and the stretch and force of contacts born on the panel are above 0; times this they are those of X."""
    return 1.0 if TO_NODES[-1] @ w >= 0.0 else -1.0
