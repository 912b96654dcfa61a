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
from master.soft.inertia.delayed.panel import (
    NODES,
    SLOPES,
    STAGES,
    TO_NODES,
    TO_SERIES,
    Panel,
)
from master.soft.inertia.delayed.passage import Passage
from master.soft.inertia.delayed.past import Past
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
    """A panel, the rate of births at its nodes, about the force that it misses (a length), and whether contacts that
    form on it break on it, too (see Passage)."""

    panel: Panel
    birth_rate: Array
    missed: float
    passes: bool


def solve_panel(
    machine: Machine,
    contacts: Cohorts,
    passage: Passage,
    past: Past,
    state: State,
    width: float,
    drive: Array,
    guess: Array,
    accuracy: float,
) -> Solved | None:
    """The motion over a time `width`, or None where that is too long to be found.

    drive : X_T at the nodes; guess : speeds there; accuracy : error of the force that a panel may have (a length)
    """
    m, g, k, unit = machine
    integral, eye = width * TO_NODES, np.eye(NODES.size)
    times = state.t + width * NODES
    held = contacts.response(np.array([state.x]))
    # conservation of number: what does not hold has broken, and not formed again
    out = past.share + past.formed - past.broken_together
    before = out - float(held.holding[0])
    known = times - past.delay <= state.t
    rate = np.zeros(NODES.size)
    rate[known] = past.birth_rate(times[known])
    at_known = float(past.birth_rate(np.array([state.t]))[0]) if not known.all() else 0.0
    rate[~known] = at_known
    # births at a node of the panel are the slope, one delay before, of the polynomial through its breaks
    slopes = SLOPES if known.all() else _slopes_at((times - past.delay - state.t) / width)
    w, breaks = guess, np.full(NODES.size, before)
    travel = float(np.abs(integral[-1] @ w))
    passes = bool(known.all() and rate.any() and travel >= LEAST_PASSAGE * passage.longest)
    off = 0.0
    enough = CONVERGED * accuracy + ROUNDING * (unit + (1.0 + k) * abs(state.x))
    for _ in range(MOST_TRIES):
        x = state.x + integral @ w
        if not np.isfinite(x).all():
            return None
        pre = contacts.response(x)
        way = 1.0 if x[-1] >= state.x else -1.0
        # dF_i/dX_j, dF_i/dW_i
        stiff, drag = np.diag(pre.slope), np.full(NODES.size, g)
        if passes:
            if (way * w <= 0.0).any():
                return None
            passing = passage.at(way * (x - state.x), rate, way * w, width)
            force, holding = pre.force + way * passing.force, pre.holding + passing.holding
            drag, off = g - passing.force / np.abs(w), passing.missed
        else:
            new = _born_here(contacts, x, way, integral * rate)
            force = pre.force + new.force.sum(axis=1)
            holding = pre.holding + new.holding.sum(axis=1)
            stiff = stiff + np.diag(new.slope.sum(axis=1)) - new.slope
        updated = out - holding + integral @ rate
        lack = m * (w - state.w) + integral @ (g * w + force + k * (x - drive))
        matrix = m * eye + integral @ (drag * eye + (stiff + k * eye) @ integral)
        try:
            change = np.linalg.solve(matrix, lack)
        except np.linalg.LinAlgError:
            return None
        w = w - change
        moved = (min(float(holding.max()), 1.0) + k) * float(np.abs(integral @ change).max())
        differs = unit * float(np.abs(updated - breaks).max())
        breaks = updated
        if not known.all():
            rate[~known] = (slopes @ np.append(before, breaks))[~known] / width
        if moved <= enough and differs <= enough:
            break
    else:
        return None
    values = np.stack(
        [
            np.append(state.x, state.x + integral @ w),
            np.append(before, breaks),
            np.append(held.force[0], force),
        ]
    )
    panel = Panel.through(state.t, width, values)
    place, broken, pulls = panel.last()
    # what a place misses changes the force by the stiffness of the contacts that hold, and by the spring
    stiffness = k + max(float(held.holding[0]), float(holding.max()))
    missed = max(stiffness * place, unit * broken, pulls)
    # contacts that form and break on a panel are not resolved by its nodes
    travel = float(np.ptp(values[0])) / unit
    if passes and travel * unit < 0.5 * LEAST_PASSAGE * passage.longest:
        return None
    unresolved = off if passes else unit * float(integral[-1] @ rate) * min(travel, 1.0) ** 4
    missed = max(missed, unresolved)
    if known.all():
        born = np.array([past.born_on_panels(t) for t in times.tolist()])
        born -= past.born_on_panels(state.t)
        missed = max(missed, unit * float(np.abs(integral @ rate - born).max()))
    return Solved(panel, rate, float(missed), passes)


class _Born(NamedTuple):
    """What contacts born around the node j do at the node i, arrays (i, j); see Response."""

    holding: Array
    force: Array
    slope: Array


def _born_here(contacts: Cohorts, x: Array, way: float, births: Array) -> _Born:
    """Of contacts born on the panel; `births` (i, j) are those that count at i."""
    if not births.any():
        return _Born(births, births, births)
    law, stretch = contacts.law, way * (x[:, None] - x)
    size = np.abs(stretch)
    # continued smoothly to nodes after i, as the polynomials through all nodes need
    survival = np.asarray(law.sf(size))
    survival = np.where(stretch < 0.0, 2.0 - survival, survival)
    density = np.asarray(law.pdf(size))
    force = way * births * stretch * survival
    return _Born(births * survival, force, births * (survival - stretch * density))


def _slopes_at(places: Array) -> Array:
    """The matrix from values at PLACES to the derivatives at places, those before the panel at its beginning."""
    z = 2.0 * np.maximum(places, 0.0) - 1.0
    return 2.0 * legendre.legvander(z, STAGES - 1) @ legendre.legder(TO_SERIES)
