"""The master equation for a rigid or a soft slider, along any path."""

import time as clock
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from master.outcome import Progress, outcome, unheard
from master.rigid import motion_of, solve_rigid
from master.solution import Solution
from master.survival.make import life_of
from origins import Contacts, Drive, InputError
from origins.contacts import LAWS, check_contacts
from origins.drive import SlipRule
from origins.errors import check_tolerance, positive

if TYPE_CHECKING:
    from master.paper.q15_transient import AgeingTransient
    from master.soft.solution import SoftSolution

# Tolerance of a first solution, in mean thresholds, of contacts that form again stretched and break by heat: their
# table of survivals takes seconds to this, but may take minutes to 1e-6, and without it no point of the path is known.
ROUGH = 1e-4


def solve(
    contacts: Contacts,
    path: npt.ArrayLike,
    tolerance: float = 1e-8,
    *,
    velocity: float = 1.0,
    time: npt.ArrayLike | None = None,
    spring: float | None = None,
    slip: SlipRule | None = None,
    mass: float | None = None,
    damping: float = 0.0,
    progress: Progress = unheard,
    wall_time: float | None = None,
) -> "Solution | SoftSolution | AgeingTransient":
    """Force on a slider from X = 0 along a path (paper, Eq. Q5a; Secs. III D and E, IV, V, App. C).

    The equation is number conservation, written with survivals and solved panel by panel; the paper's own scheme is
    `master.explicit`. On a rigid slider `solve` calls `rigid.solve_rigid`; this calls `rigid.march_of`, which
    divides the tolerance (`renewal.budget`) and sets the edges of panels (`renewal.edges`), and then `March.run`
    (`renewal.march`), which solves panel by panel: contacts born on the present leg are `renewal.present`'s, all others
    `renewal.past`'s.

    The files that do the work on a rigid slider, in the order in which they begin, are `solve`, `rigid`, `motion`,
    `survival.make`, `survival.life`, `renewal.births`, `renewal.budget`, `renewal.edges`,
    `renewal.panel_width`, `renewal.march`, `renewal.solved`, `renewal.present`, `renewal.past`, `renewal.few_times`,
    `outcome`, `renewal.straight`, `numerics.polynomials`, `renewal.lumps` and, for a start with a width,
    `numerics.averages`; the head of each says what it does, and docs/equations.md derives the equation. These are of a
    path forward without laws in time: after a turn there are `renewal.earlier_legs`, or `renewal.strand_births` of
    contacts that age, and each law has its survival in `survival`.

    With a spring `solve` calls `solve_soft` in `soft.solution`, or with a mass `solve_inertial` in
    `soft.inertia.solution`; `soft` says in its `__init__` how they go on.

    Parameters
    ----------
    contacts : Contacts
        Thresholds, starting stretches and any laws of a contact. The paper's closure of ageing is solved only without
        other laws, for a rigid slider that moves forward at one speed.
    path : array of shape (n,)
        Slider positions X (lengths), any spacing, straight between points; where the path turns round, contacts break
        at -x_s as well. With a spring: positions X_T of the drive, which begins where the spring balances the starting
        force.
    tolerance : float
        Largest allowed error of the force, in units of the mean threshold.
    velocity : float
        Speed along the path (length per time); at T = 0 only ageing, delay and growing thresholds depend on it.
    time : array of shape (n,), optional
        When each point is reached, instead of the velocity: for holds and velocity steps.
    spring : float, optional
        K/(N_c <k>) of a soft slider; None: rigid.
    slip : "reset", "reform-after" or "instant"
        What a slip of a soft slider does; left out, "reset". At the instability F'(X) = -K:
        "reset" (the paper's): all contacts are replaced by ones that have just re-formed, and X jumps to where
        K (X_T - X) = F;
        "reform-after": broken contacts stay out until the slip ends, which is where the spring balances those that
        hold; meanwhile these stretch and may break;
        "instant": contacts re-form at once, or after their delay, and X goes to the first X' with F(X') + K X' = K X_T.
    mass, damping : float, optional
        M/(N_c <k>) (time squared) and γ/(N_c <k>) (time) of a soft slider, M X'' + γ X' = K (X_T - X) - F, instead of a
        slip rule. Of laws in time a delay, and heat that hardly changes the force and is left out, take no steps; with
        others the slider is followed in steps of time, so that it may not go on for more than some 200 mean thresholds.
    progress : callable, optional
        Called as progress(error) with the error estimate, in mean thresholds.
    wall_time : float, optional
        Seconds after which the solver stops, success is False: the path is cut at the point reached, or solved with the
        steps so far under a spring with laws in time, and for the paper's closure of ageing with the coarsest at least.

    Returns a Solution, with a spring a SoftSolution, with a mass an InertialSolution, for the paper's closure of ageing
    an AgeingTransient; with success = False and the reason in `message` where the tolerance was not reached.

    Raises InputError for a path that is not finite, for keywords outside the ranges above, and for laws of the contacts
    that cannot be solved on such a path yet.
    """
    tolerance = check_tolerance("tolerance", tolerance)
    drive = Drive(path, velocity, time, spring, slip, mass, damping)
    until = np.inf if wall_time is None else clock.monotonic() + positive("wall_time", wall_time)
    check_contacts(contacts, "master.solve", LAWS, own_rates=True)
    if contacts.ageing is not None and contacts.ageing.closure == "paper":
        drive.only_forward("the paper's closure of ageing")
        if drive.time is not None:
            raise InputError("time: the paper's closure of ageing takes one speed; write velocity=")
        from master.paper.q15_transient import solve_q15  # each where it is needed

        return solve_q15(contacts, drive, tolerance, progress, until)
    if drive.spring is None:
        return _rigid(contacts, drive, tolerance, progress, until)
    if drive.mass is not None:
        from master.soft.inertia.solution import solve_inertial

        return solve_inertial(contacts, drive, tolerance, progress, until)
    from master.soft.solution import solve_soft

    return solve_soft(contacts, drive, tolerance, progress, until)


def _rigid(
    contacts: Contacts, drive: Drive, tolerance: float, progress: Progress, until: float
) -> Solution:
    """A rigid slider; where wall_time ends the work before a table is made, as far as it is known to ROUGH."""
    # for the life alone, which tells whether time counts; where it does not, solve_rigid makes one of distances
    motion, _ = motion_of(drive, contacts.mean_threshold)

    def solved_to(asked: float) -> Solution:
        life = life_of(contacts, asked, motion, until)
        return solve_rigid(contacts, drive, life, asked, progress, until)

    slow = contacts.thermal is not None and contacts.reforming is not None
    if not (slow and np.isfinite(until) and tolerance < ROUGH):
        return solved_to(tolerance)
    rough = solved_to(ROUGH)  # first, so that at wall_time at least this is known
    if rough.success and rough.force_error <= tolerance:
        return replace(rough, message=outcome(contacts, rough.force_error, tolerance, "")[1])
    run_time = rough.run_time
    if clock.monotonic() <= until:
        fine = solved_to(tolerance)
        if fine.path.size >= rough.path.size:
            return fine
        run_time += fine.run_time
    hint = f"the force is known to {rough.force_error:.1e} only, as more took too long"
    message = f"stopped by wall_time: {hint}" if rough.success else rough.message
    return replace(rough, success=False, message=message, run_time=run_time)
