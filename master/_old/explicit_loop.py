"""The paper's friction loop (App. C): Q(x;X) on a grid, stepped forward and back, with P_b(x) = P(-x). First order.

Kept as the plain twin of the cohorts. In one step all contacts move by dX in the direction of motion, and a fraction
of those now at x breaks, which depends on x alone: a survivor's past is forgotten. A contact that was pulled to 0.9
and let back to -0.5 counts as if its threshold might be 0.6, which it would not have survived. After a turn this is
not the discrete model: with P_c(1, 0.2) it is off by 0.04 where turns are at +-3 and by 0.18 where they are at +-0.9.
"""

import time

import numpy as np
import numpy.typing as npt

from master._old.explicit import MOST_NODES, Breaking, ExplicitSolution, broken_fraction, starting_shares
from master._old.moves import moves
from origins import Contacts
from origins.contacts import check_contacts
from origins.errors import finite_array, positive, refuse

Array = npt.NDArray[np.float64]

_TAIL = 1e-18


def explicit_loop(
    contacts: Contacts, path: npt.ArrayLike, step: float, breaking: Breaking = "survival"
) -> ExplicitSolution:
    """Force along a path that may turn round, from X = 0, at T = 0, with dx = dX = step (Eqs. Q2-Q6, Q3back-Q5aback).

    Parameters
    ----------
    contacts : Contacts
        Thresholds and starting stretches.
    path : array of shape (n,)
        Slider positions X (lengths), straight between points, of either sign. Turning points are moved to the nearest
        multiple of `step`.
    step : float
        dx = dX (a length).
    breaking : "survival" or "printed"
        As in `explicit`.

    Raises InputError for a path that is not finite, a step that is not above zero or so small that the grid exceeds
    4,194,304 nodes or steps, and what `explicit` refuses of `breaking`.
    """
    began = time.perf_counter()
    check_contacts(contacts, "master.explicit_loop")
    positions = finite_array("path", path)
    step = positive("step", step)
    if breaking not in ("survival", "printed"):
        refuse("breaking", breaking, 'must be "survival" or "printed"')
    legs = moves(positions)
    reach = _reach(contacts, positions)
    longest = max(sum(leg.travel for leg in legs), 2.0 * reach)
    if longest / step > MOST_NODES:
        refuse("step", step, f"needs more than {MOST_NODES:,} steps or nodes; write step={longest / 1e4:.3g} or so")
    zero = int(np.ceil(reach / step)) + 1
    x: Array = step * np.arange(-zero, zero + 1, dtype=float)
    distribution = starting_shares(contacts, x, step)
    fraction = broken_fraction(contacts.thresholds, x, step, breaking)
    fraction[-1] = 1.0  # what the grid leaves out breaks here
    force, holding = np.empty(positions.size), np.empty(positions.size)
    for leg in legs:
        first, last = (round(at / step) for at in (leg.turn, leg.turn + leg.direction * leg.travel))
        at = step * np.arange(first, last + leg.direction, leg.direction)
        forces, sums = [x @ distribution], [distribution.sum()]
        for _ in at[1:]:
            # backward motion is forward motion of -x
            one_way = distribution[:: leg.direction]
            one_way[1:] = one_way[:-1].copy()
            one_way[0] = 0.0
            broken = fraction * one_way
            one_way -= broken
            one_way[zero] += broken.sum()
            forces.append(x @ distribution)
            sums.append(distribution.sum())
        here = leg.direction * positions[leg.points]
        force[leg.points] = np.interp(here, leg.direction * at, forces)
        holding[leg.points] = np.interp(here, leg.direction * at, sums)
    return ExplicitSolution(path=positions, force=force, holding=holding, run_time=time.perf_counter() - began)


def _reach(contacts: Contacts, path: Array) -> float:
    """Largest |x| that contacts have on the way, all but 1e-18 of them."""
    low, high = contacts.start.span
    upper = contacts.thresholds.support()[1]
    furthest = min(max(-low, high), upper)
    tail = _TAIL * float(contacts.thresholds.sf(furthest))
    span = max(float(path.max()), 0.0) - min(float(path.min()), 0.0)
    return max(min(furthest + span, float(contacts.thresholds.isf(tail))), furthest)
