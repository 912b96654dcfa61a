"""(Q16) with (Q15), Fig. A06: the speed v_c above which contacts that age no longer stick and slip.

With the paper's reset every slip puts all contacts back to Q_ini, with fresh thresholds of age 0: each run up to a slip
repeats the first, so there is stick-slip if and only if -F'(X) reaches the spring K on the way. Slow sliding gives the
thresholds time to age, which makes the drop steeper. D_X = D/v holds for the slider's own X, as in (Q15). Where X_T =
X + F/K moves at v, more time passes before the drop and less in it, and v_c, which `master.solve` finds, is larger.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.interpolate import make_interp_spline
from scipy.optimize import brentq

from master.paper.q15_transient import narrowest_half_width, paper_transient
from master.stick_slip.extremes import Largest, extremes
from origins import Contacts, InputError
from origins.contacts import check_contacts
from origins.errors import positive, refuse

TOLERANCE = 1e-7  # tolerance of ln v_c, and of K* with closure "exact" in units of 0.1 (1 + K*)
# Half of the change of ln v over which the slope of the steepest fall is taken.
NEAR = 0.01
# Step of (Q15), in narrowest half-widths of its laws; points at which F' is looked at in each step.
STEP, POINTS = 0.25, 100


@dataclass(frozen=True)
class CriticalVelocity:
    """Where stick-slip ends.

    velocity, velocity_error : v_c, a length per time.
    position : X at which -F' just reaches K there, a length.
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

    contacts : with `ageing`, in the closure that it names, and any start; no other law of the contact.
    spring : K/(N_c <k>).
    slowest, fastest : two speeds, a length per time, that v_c lies between.

    The error is estimated from that of K*, or from the change with finer steps. Raises InputError where the drop is
    steeper than the spring at both speeds, or at neither; for contacts that do not age, or have other laws beside.
    """
    spring = positive("spring", spring)
    slowest = positive("slowest", slowest)
    fastest = positive("fastest", fastest)
    if contacts.ageing is None:
        hint = "v_c is that of contacts that age; master.phase_line tells K* at each speed of any"
        raise InputError(f"contacts.ageing: is None; {hint}")
    if not slowest < fastest:
        refuse("slowest", slowest, f"must be below fastest = {fastest:g}")
    check_contacts(contacts, "master.critical_velocity", ("ageing",))
    exact = contacts.ageing.closure == "exact"

    @cache
    def fall(log_velocity: float) -> Largest:
        """The steepest -F'(X) at one speed: K* where each contact's own threshold diffuses."""
        velocity = float(np.exp(log_velocity))
        if exact:
            return extremes(contacts, velocity, 0.1 * TOLERANCE).fall
        return _printed_fall(contacts, velocity, 1)

    def excess(log_velocity: float) -> float:
        return fall(log_velocity).value - spring

    low, high = np.log([slowest, fastest])
    if not excess(low) > 0.0 >= excess(high):
        at_slowest, at_fastest = fall(low).value, fall(high).value
        found = f"{at_slowest:.4g} at v = {slowest:g} and {at_fastest:.4g} at v = {fastest:g}"
        hint = f"it must be above the spring, {spring:g}, at the former alone"
        raise InputError(f"slowest, fastest: -F' is at most {found}; {hint}")
    root = brentq(excess, low, high, xtol=TOLERANCE)
    slope = (excess(root - NEAR) - excess(root + NEAR)) / (2.0 * NEAR)
    steepest = fall(root)
    if not exact:  # finer steps move v_c by little
        finer = _printed_fall(contacts, float(np.exp(root)), 2)
        steepest = finer._replace(error=abs(finer.value - steepest.value))
    velocity = float(np.exp(root + (steepest.value - spring) / slope))
    error = velocity * (steepest.error / abs(slope) + TOLERANCE)
    return CriticalVelocity(velocity, error, steepest.position)


def _printed_fall(contacts: Contacts, velocity: float, parts: int) -> Largest:
    """Where all contacts have one P_c: the first fall of (Q15), extrapolated in h² from two steps."""
    assert contacts.ageing is not None
    step = STEP * narrowest_half_width(contacts)
    # by then nearly all contacts have broken, fresh or aged
    end = max(float(law.isf(1e-3)) for law in (contacts.thresholds, contacts.ageing.final))
    path = np.arange(0.0, end - min(contacts.start.span[0], 0.0) + 3.0 * step, step)
    coarse = paper_transient(contacts, path, step / parts, velocity).force
    fine = paper_transient(contacts, path, 0.5 * step / parts, velocity).force
    force = make_interp_spline(path, (4.0 * fine - coarse) / 3.0, k=5)
    x = np.linspace(0.0, path[-1], POINTS * path.size)
    falls = -force.derivative()(x)
    begin = int(np.argmax(falls > 0.0))
    if not falls[begin] > 0.0:
        raise InputError("contacts: the force never falls; there is no stick-slip at any spring")
    length = int(np.argmin(np.append(falls[begin:], 0.0) > 0.0))
    steepest = begin + int(falls[begin : begin + length].argmax())
    return Largest(float(falls[steepest]), np.nan, float(x[steepest]))
