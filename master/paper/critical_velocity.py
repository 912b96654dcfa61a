"""(Q16) with (Q15), Fig. A06: the speed v_c above which contacts that age no longer stick and slip.

With the paper's reset every slip puts all contacts back to Q_ini, with fresh thresholds of age 0:
each run up to a slip repeats the first, so there is stick-slip if and only if -F'(X) reaches the
spring K on the way. Slow sliding gives the thresholds time to age, which makes the drop steeper.
D_X = D/v holds for the slider's own X, as in (Q15). Where the drive's X_T = X + F/K moves at v, more time passes
before the drop and less in it, and v_c is larger; `master.solve` with a spring finds it.
"""

from dataclasses import dataclass
from functools import cache
from itertools import pairwise

import numpy as np

from master.stick_slip.extremes import Largest, extremes
from origins import Contacts, InputError
from origins.contacts import check_contacts
from origins.errors import positive

CLOSE = 1e-7  # tolerance of ln v_c, and of K* with closure "exact" in units of 0.1 (1 + K*)


@dataclass(frozen=True)
class CriticalVelocity:
    """Where stick-slip ends.

    Attributes
    ----------
    velocity, velocity_error : float
        v_c, a length per time.
    position : float
        X at which -F' just reaches K there (a length).
    """

    velocity: float
    velocity_error: float
    position: float


def critical_velocity(
    contacts: Contacts, spring: float, slowest: float, fastest: float
) -> CriticalVelocity:
    """(Q16): v_c above which a soft slider whose contacts age no longer sticks and slips.

    With closure "exact" it is where K* of `master.propensity` is the spring; with "paper" where the steepest -F'(X) of
    the first drop of (Q15) is, as contacts outrun P_c after it.

    Parameters
    ----------
    contacts : Contacts
        With `ageing`, in the closure that it names, and any start; no other law of the contact.
    spring : float
        K/(N_c <k>).
    slowest, fastest : float
        Two speeds, a length per time, that v_c lies between.

    The error is estimated from that of K*, or from the change with finer steps. Raises InputError where the drop is
    steeper than the spring at both speeds, or at neither; for contacts that do not age, or have other laws beside.
    """
    from scipy.optimize import brentq

    spring = positive("spring", spring)
    slowest, fastest = positive("slowest", slowest), positive("fastest", fastest)
    if contacts.ageing is None:
        why = "without ageing nothing depends on the speed"
        if contacts.laws:
            why = "v_c is that of contacts that age; what other laws make of K* at each speed tells master.phase_line"
        raise InputError(f"contacts.ageing: is None; {why}")
    check_contacts(contacts, "master.critical_velocity", ("ageing",))
    exact = contacts.ageing.closure == "exact"

    @cache
    def fall(velocity: float, finer: bool = False) -> Largest:
        """The steepest -F'(X) at one speed: K* where each contact's own threshold diffuses."""
        if exact:
            return extremes(contacts, velocity, 0.1 * CLOSE).fall
        return _printed_fall(contacts, velocity, finer)

    def excess(log_velocity: float) -> float:
        return fall(float(np.exp(log_velocity))).value - spring

    ends = np.log([slowest, fastest])
    slow, fast = (excess(end) for end in ends)
    if not slow > 0.0 >= fast:
        found = f"{slow + spring:.4g} at v = {slowest:g} and {fast + spring:.4g} at v = {fastest:g}"
        rule = f"the spring {spring:g} must lie between them"
        raise InputError(f"slowest, fastest: -F' is at most {found}; {rule}")
    root = brentq(excess, *ends, xtol=CLOSE)
    slope = (excess(root - 0.01) - excess(root + 0.01)) / 0.02
    finer = fall(float(np.exp(root)), finer=True)  # moves v_c by little
    velocity = float(np.exp(root + (finer.value - spring) / slope))
    error = velocity * (finer.error / abs(slope) + CLOSE)
    return CriticalVelocity(velocity, error, finer.position)


def _printed_fall(contacts: Contacts, velocity: float, finer: bool) -> Largest:
    """Where all contacts have one P_c: the first fall of (Q15), extrapolated in h²."""
    from scipy.interpolate import make_interp_spline

    from master.paper.q15_transient import narrowest, paper_transient

    assert contacts.ageing is not None
    step = 0.25 * narrowest(contacts)
    # by then nearly all contacts have broken, fresh or aged
    end = max(float(law.isf(1e-3)) for law in (contacts.thresholds, contacts.ageing.final))
    path = np.arange(0.0, end - min(contacts.start.span[0], 0.0) + 3.0 * step, step)
    forces = [paper_transient(contacts, path, step, velocity).force]
    rises = np.diff(forces[0]) > 0.0
    begin = int(np.argmin(rises))
    if rises[begin]:
        raise InputError("contacts: the force never falls; there is no stick-slip at any spring")
    end_of_fall = begin + int(np.argmax(np.append(rises[begin:], True)))
    path = path[: max(end_of_fall, 6) + 1]  # a spline of degree 5 takes six points
    for parts in (2, 4)[: 1 + finer]:
        forces.append(paper_transient(contacts, path, step / parts, velocity).force)
    x, falls = np.linspace(path[begin], path[end_of_fall], 100 * path.size), []
    for coarse, fine in pairwise(forces):
        better = (4.0 * fine - coarse[: path.size]) / 3.0
        down = -make_interp_spline(path, better, k=5).derivative()(x)
        falls.append(Largest(float(down.max()), np.nan, float(x[down.argmax()])))
    return falls[-1]._replace(error=abs(falls[-1].value - falls[0].value))
