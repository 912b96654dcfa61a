"""(Q2), (Q3), (Q4): the paper's explicit step of Q(x;X) on a grid. First order in the step.

It is kept as the plain twin of `master.solve`. All stretches are multiples of the step dX. In one step all contacts
move on by dX, a fraction a(x) of those now at x breaks, and the broken contacts re-form at x = 0. The fraction is
taken from Q after the shift: taken before it, as (Q2) and (Q3) literally say, cells become negative and the solution
diverges. A contact that breaks within a step should stretch again by up to dX before the step ends; here it does not,
so that where breaks are spread smoothly every generation is dX/2 late.

Backward motion (App. C) is forward motion with P_b(x) = P(-x): breaking depends on x alone. A contact that was pulled
to 0.9 and back to -0.5 is treated as if its threshold could be 0.6. So after a turn this differs from the discrete
model: with P_c(1, 0.2) the force is off by 0.04 where turns are at +-3, by 0.18 where they are at +-0.9.
"""

import time
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from origins import Contacts, Drive
from origins.contacts import check_contacts
from origins.errors import finite_array, one_of, positive, refuse
from origins.thresholds.law import Array

Breaking = Literal["survival", "printed"]

MOST_NODES = 2**22  # nodes of the grid, and steps: more would take hours and gigabytes


@dataclass(frozen=True)
class ExplicitSolution:
    """The result of the explicit scheme, which has no error estimate; arrays of shape (n,).

    path, force : slider positions X, and F/(N_c <k>) of (Q6), straight between the steps; lengths.
    run_time : s.
    """

    path: Array
    force: Array
    run_time: float


def explicit(
    contacts: Contacts, path: npt.ArrayLike, step: float, breaking: Breaking = "survival"
) -> ExplicitSolution:
    """F(X) on a rigid slider that moves forward, step by step, dx = dX = step (paper, Eqs. Q4 and Q5a).

    contacts : thresholds and starting stretches. As in the paper, a contact that starts at x < 0 breaks by P(x) from
        x = 0 on, although its threshold is known to exceed |x|.
    path : slider positions X >= 0 that never turn back, shape (n,), lengths; any spacing.
    step : dx = dX, a length.
    breaking : the fraction a(x) that breaks in a step. "survival": 1 - S(x)/S(x - dX), the effect of the hazard P over
        the whole step. "printed": P(x) dX of (Q3), with P = 0 at x <= 0; at most 1, as P diverges where a law ends.

    Raises InputError for a path as in `master.solve`; for a step that needs more than 4,194,304 nodes or steps; for an
    unknown `breaking`; for laws of the contacts; and for "printed" with exact thresholds, which have no P(x).
    """
    check_contacts(contacts, "master.paper.explicit")
    return _stepped(contacts, Drive(path).only_forward("the explicit scheme").path, step, breaking)


def explicit_loop(
    contacts: Contacts, path: npt.ArrayLike, step: float, breaking: Breaking = "survival"
) -> ExplicitSolution:
    """F along a path that turns, with arguments and errors of `explicit` (paper, Eqs. Q3back, Q4back and Q5aback).

    path : slider positions X from X = 0 on, straight between points, of either sign, shape (n,), lengths. Turning
        points are moved to the nearest multiple of `step`.
    """
    check_contacts(contacts, "master.paper.explicit_loop")
    return _stepped(contacts, finite_array("path", path), step, breaking)


def _stepped(contacts: Contacts, path: Array, step: float, breaking: Breaking) -> ExplicitSolution:
    """Take all steps along slider positions of shape (n,), on a grid that is even about x = 0."""
    began, step = time.perf_counter(), positive("step", step)
    one_of("breaking", breaking, get_args(Breaking))
    law, start = contacts.thresholds, contacts.start
    travel = np.abs(np.diff(path, prepend=0.0)).cumsum()
    # the grid covers the largest |x| of all but 1e-18 of the contacts
    first = min(max(abs(end) for end in start.span), law.support()[1])
    largest = max(min(first + float(np.ptp(np.append(path, 0.0))), float(law.isf(1e-18))), first)
    longest = max(float(travel[-1]), 2.0 * largest)
    if longest / step > MOST_NODES:
        example = f"write step={longest / 1e4:.3g} or so"
        refuse("step", step, f"needs more than {MOST_NODES:,} steps or nodes; {example}")
    zero = 1 + int(np.ceil(largest / step))  # the index of x = 0
    x: Array = step * np.arange(-zero, zero + 1, dtype=float)
    broken_part = broken_fraction(contacts, x, step, breaking)
    broken_part[-1] = 1.0  # contacts that would leave the grid break at its end
    populations = starting_populations(contacts, x, step)

    travelled = step * np.arange(int(np.ceil(travel[-1] / step * (1.0 - 1e-12))) + 1)
    at = np.interp(travelled, np.append(0.0, travel), np.append(0.0, path))
    if at.size > 1:  # the last step may end beyond the path
        at[-1] = at[-2] + np.copysign(step, at[-1] - at[-2])
    force = [x @ populations]
    for move in np.diff(np.rint(at / step).astype(int)).tolist():
        # a view: backward is forward in -x
        forward = populations if move >= 0 else populations[::-1]
        broken = [shift_and_break(forward, broken_part) for _ in range(abs(move))]
        populations[zero] += sum(broken)
        force.append(x @ populations)
    return ExplicitSolution(path, np.interp(travel, travelled, force), time.perf_counter() - began)


def shift_and_break(populations: Array, broken_part: Array) -> float:
    """Move all contacts by one node and break some (paper, Eq. Q2), in place; returns their share."""
    populations[1:] = populations[:-1].copy()
    populations[0] = 0.0
    broken = broken_part * populations
    populations -= broken
    return float(broken.sum())


def starting_populations(contacts: Contacts, x: Array, step: float) -> Array:
    """The share of the contacts at each node at X = 0 (paper, Eq. Q5b); they add up to 1."""
    start = contacts.start
    if start.is_single:  # distributed over two nodes with the same mean
        populations = np.maximum(1.0 - np.abs(x - start.mean()) / step, 0.0)
    else:
        populations = np.diff(start.cdf(np.append(x - 0.5 * step, x[-1] + 0.5 * step)))
        populations[contacts.thresholds.sf(np.abs(x)) <= 0.0] = 0.0
    return populations / populations.sum()


def broken_fraction(contacts: Contacts, x: Array, step: float, breaking: Breaking) -> Array:
    """The fraction of contacts at each node that breaks in a step (paper, Eqs. Q3 and PcP)."""
    law = contacts.thresholds
    here, before = law.logsf(x), law.logsf(x - step)
    with np.errstate(invalid="ignore", over="ignore"):
        if breaking == "survival":
            return np.where(before > -np.inf, -np.expm1(here - before), 1.0)
        if law.atoms[0].size:
            hint = 'P(x) does not exist at exact thresholds; write "survival"'
            refuse("breaking", breaking, hint)
        hazard = np.where(x > 0.0, np.exp(law.logpdf(x) - here), 0.0)
    return np.where(here > -np.inf, np.minimum(hazard * step, 1.0), 1.0)
