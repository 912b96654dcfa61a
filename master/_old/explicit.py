"""The paper's own scheme for the master equation: Q(x;X) on a grid, stepped forward. First order in the step.

Kept as the plain twin of `solve`: each contact's stretch is a multiple of the step, and in one step, Eqs. (Q2)-(Q4),

    all contacts move on by dX,    a fraction a(x) of those now at x breaks,    the broken ones are put at x = 0.

The fraction is taken from the shifted Q: taken from Q(x;X) where it was, as (Q2) and (Q3) read to the letter, cells
fall below zero and the answer explodes. Contacts that break within the step would have stretched again by up to dX
before it ends; here they do not, so where breaks are spread smoothly every generation comes dX/2 late.
"""

import time
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from origins import Contacts, Drive
from origins.contacts import check_contacts
from origins.errors import positive, refuse
from origins.thresholds import Thresholds

Array = npt.NDArray[np.float64]
Breaking = Literal["survival", "printed"]

MOST_NODES = 2**22
_TAIL = 1e-18


@dataclass(frozen=True)
class ExplicitSolution:
    """What the explicit scheme gives; it knows nothing of its own error.

    Attributes
    ----------
    path : array of shape (n,)
        Slider positions X (lengths).
    force : array of shape (n,)
        F/(N_c <k>), Eq. (Q6) (a length); straight between the steps.
    holding : array of shape (n,)
        Sum of Q over the grid: what waits lacks, else 1 but for round-off.
    run_time : float
        Seconds that the solution took.
    """

    path: Array
    force: Array
    holding: Array
    run_time: float


def explicit(
    contacts: Contacts,
    path: npt.ArrayLike,
    step: float,
    breaking: Breaking = "survival",
    *,
    velocity: float = 1.0,
) -> ExplicitSolution:
    """Force F(X) on a rigid slider that moves forward from X = 0, with dx = dX = step (Eqs. Q2-Q6, Q5adelay, temper4).

    Parameters
    ----------
    contacts : Contacts
        Thresholds and starting stretches; temperature with closure "paper", which adds H(x)/v to P(x); delay, rounded
        to whole steps. As in the paper, a contact that starts at x < 0 is under P(x) from x = 0
        on, though its threshold is known to exceed |x|: with weight there the scheme is not the discrete model.
    path : array of shape (n,)
        Slider positions X >= 0 that never turn back (lengths); any spacing.
    step : float
        dx = dX (a length).
    breaking : "survival" or "printed"
        Fraction a(x) that breaks in a step. "survival": 1 - S(x)/S(x - dX), what the hazard P takes over the whole
        step, sound for every law. "printed": P(x) dX, Eqs. (Q3) and (PcP), with P = 0 for x <= 0 and cut at 1, as P
        grows without bound towards the upper end of a bounded law; the same where P dX << 1.
    velocity : float
        v (length per time), which temperature and delay tell.

    Raises
    ------
    InputError
        For a path as in `solve`, a step that is not above zero or so small that the grid exceeds 4,194,304 nodes or
        steps, an unknown `breaking`, temperature with closure "exact", for which one rate at x is not enough, laws of
        contacts other than these, and "printed" for thresholds with exact single values, which have no P(x).
    """
    began = time.perf_counter()
    check_contacts(contacts, "master.explicit", ("thermal", "delay"))
    thermal, delay = contacts.thermal, contacts.delay
    if thermal is not None and thermal.closure != "paper":
        refuse("contacts.thermal.closure", thermal.closure, 'the explicit scheme knows x alone; use closure = "paper"')
    drive = Drive(path, velocity).only_forward("the explicit scheme")
    step = positive("step", step)
    if breaking not in ("survival", "printed"):
        refuse("breaking", breaking, 'must be "survival" or "printed"')
    end = float(drive.path[-1])
    first, last = _reach(contacts, end)
    longest = max(end, last - first)
    if longest / step > MOST_NODES:
        refuse("step", step, f"needs more than {MOST_NODES:,} steps or nodes; write step={longest / 1e4:.3g} or so")
    steps = int(np.ceil(end / step * (1.0 - 1e-12)))
    zero = -int(np.floor(first / step))  # index of x = 0
    x: Array = step * np.arange(-zero, int(np.ceil(last / step)) + 2, dtype=float)
    distribution = starting_shares(contacts, x, step)
    fraction = broken_fraction(contacts.thresholds, x, step, breaking)
    if thermal is not None:
        fraction = _warmer(contacts, fraction, x, step, breaking, drive.velocity)
    fraction[-1] = 1.0  # what the grid leaves out breaks here
    force, holding = np.empty(steps + 1), np.empty(steps + 1)
    force[0], holding[0] = x @ distribution, distribution.sum()
    waiting = np.zeros(1 if delay is None else 1 + round(delay.time * drive.velocity / step))
    for n in range(1, steps + 1):
        distribution[1:] = distribution[:-1].copy()
        distribution[0] = 0.0
        broken = fraction * distribution
        distribution -= broken
        waiting[n % waiting.size] = broken.sum()  # back after as many steps as there are places
        distribution[zero] += waiting[(n + 1) % waiting.size]
        force[n], holding[n] = x @ distribution, distribution.sum()
    at = step * np.arange(steps + 1)
    return ExplicitSolution(
        path=drive.path,
        force=np.interp(drive.path, at, force),
        holding=np.interp(drive.path, at, holding),
        run_time=time.perf_counter() - began,
    )


def _reach(contacts: Contacts, end: float) -> tuple[float, float]:
    """Lowest and highest stretch that contacts have on the way, all but 1e-18 of them."""
    low, high = contacts.start.span
    upper = contacts.thresholds.support()[1]
    low, high = max(low, -upper), min(max(high, 0.0), upper)
    tail = _TAIL * float(contacts.thresholds.sf(high))
    return min(low, 0.0), min(high + end, float(contacts.thresholds.isf(tail)))


def starting_shares(contacts: Contacts, x: Array, step: float) -> Array:
    """Fraction of the contacts at each node at X = 0; their sum is 1."""
    start = contacts.start
    if start.is_single:  # shared by two nodes so that the mean stays
        share = np.maximum(1.0 - np.abs(x - start.mean()) / step, 0.0)
    else:
        share = np.diff(start.cdf(np.append(x - 0.5 * step, x[-1] + 0.5 * step)))
        share[contacts.thresholds.sf(np.abs(x)) <= 0.0] = 0.0
    return share / share.sum()


def broken_fraction(thresholds: Thresholds, x: Array, step: float, breaking: Breaking) -> Array:
    """Fraction of the contacts that have come to each node which breaks in that step."""
    fraction = np.ones(x.size)
    if breaking == "survival":
        before = thresholds.logsf(x - step)
        some = before > -np.inf
        fraction[some] = -np.expm1(thresholds.logsf(x[some]) - before[some])
        return fraction
    if thresholds.atoms[0].size:
        refuse("breaking", breaking, 'P(x) does not exist at exact single thresholds; write "survival"')
    survival = thresholds.logsf(x)
    some = survival > -np.inf
    fraction[some] = np.minimum(np.exp(thresholds.logpdf(x[some]) - survival[some]) * step, 1.0)
    fraction[x <= 0.0] = 0.0
    return fraction


def _warmer(
    contacts: Contacts, fraction: Array, x: Array, step: float, breaking: Breaking, velocity: float
) -> Array:
    """The same where contacts break at the rate H(x)/v beside."""
    from master._old.thermal_paper import PaperBreaking

    hazard = PaperBreaking(contacts, velocity).hazard(np.abs(x)) * step
    if breaking == "printed":
        return np.minimum(fraction + hazard, 1.0)
    return 1.0 - (1.0 - fraction) * np.exp(-hazard)
