"""The master equation, by whichever road the drive asks for."""

from __future__ import annotations

from typing import TYPE_CHECKING, overload

import numpy.typing as npt

from master._old.forward import solve_forward
from master._old.solution import Solution
from master.outcome import Progress, unheard
from origins import Contacts, Drive, InputError
from origins.contacts import LAWS, check_contacts
from origins.drive import SlipRule
from origins.errors import check_tolerance

if TYPE_CHECKING:
    from master._old.cohorts import PathSolution
    from master._old.timed import TimedSolution
    from master.paper.q15_transient import AgeingTransient
    from master.soft.solution import SoftSolution


@overload
def solve(
    contacts: Contacts,
    path: npt.ArrayLike,
    tolerance: float = 1e-8,
    *,
    velocity: float = 1.0,
    time: npt.ArrayLike | None = None,
    spring: None = None,
    slip: SlipRule = "reset",
    progress: Progress = unheard,
) -> Solution | PathSolution | TimedSolution | AgeingTransient: ...


@overload
def solve(
    contacts: Contacts,
    path: npt.ArrayLike,
    tolerance: float = 1e-8,
    *,
    velocity: float = 1.0,
    time: npt.ArrayLike | None = None,
    spring: float,
    slip: SlipRule = "reset",
    progress: Progress = unheard,
) -> SoftSolution: ...


def solve(
    contacts: Contacts,
    path: npt.ArrayLike,
    tolerance: float = 1e-8,
    *,
    velocity: float = 1.0,
    time: npt.ArrayLike | None = None,
    spring: float | None = None,
    slip: SlipRule = "reset",
    progress: Progress = unheard,
) -> Solution | PathSolution | TimedSolution | SoftSolution | AgeingTransient:
    """Force on a slider from X = 0 along a path (paper Eqs. Q5a-Q6, Secs. IV and V, App. C, Sec. III D).

    Parameters
    ----------
    contacts : Contacts
        Thresholds, starting stretches and any laws of a contact. The paper's closure of ageing is taken alone and
        where a rigid slider moves forward at one speed.
    path : array of shape (n,)
        Slider positions X (lengths), any spacing, straight between points; where they turn round contacts break at
        -x_s as well. With a spring, positions X_T of the drive, which begins where it balances the start.
    tolerance : float
        Largest error of the force wanted, in units of the mean threshold.
    velocity : float
        Speed along the path (length per time); at T = 0 nothing depends on it but ageing, delay and thresholds that
        grow.
    time : array of shape (n,), optional
        When each point is reached, instead of the velocity: for holds and velocity steps.
    spring : float, optional
        K/(N_c <k>) of a soft slider; None: rigid.
    slip : "reset", "reform-after" or "instant"
        What a slip of a soft slider does. At the instability F'(X) = -K:
        "reset": all contacts are drawn anew, relaxed, and X jumps to where K (X_T - X) = F (the paper's); where
        thresholds grow with age they have just pinned;
        "reform-after": broken contacts stay out until the slip ends, those that hold stretch and may break;
        "instant": contacts re-form at once, and X goes to the first X' with F(X') + K X' = K X_T.
    progress : callable, optional
        Called as progress(error), in mean thresholds, with the estimate after each refinement but the coarsest; not
        where nothing is refined.

    Returns
    -------
    Solution, PathSolution where the path turns round, TimedSolution where it does or takes its own time and contacts
    have laws that tell, SoftSolution where there is a spring, or AgeingTransient for the paper's closure of ageing
        With success = False and the reason in `message` where the tolerance was not reached.

    Raises
    ------
    InputError
        For a path that is not finite, for keywords that are not as said above, and for laws of the contacts that are
        not taken on that path yet.
    """
    tolerance = check_tolerance("tolerance", tolerance)
    drive = Drive(path, velocity, time, spring, slip)
    if isinstance(contacts, Contacts) and contacts.ageing is not None and contacts.ageing.closure == "paper":
        from master.paper.q15_transient import solve_q15

        drive.only_forward("the paper's closure of ageing")
        if drive.time is not None:
            raise InputError("time: the paper's closure of ageing takes one speed all along; write velocity= instead")
        return solve_q15(contacts, drive, tolerance, progress)
    check_contacts(contacts, "master.solve", LAWS)
    laws = (contacts.grains, contacts.thermal, contacts.ageing, contacts.delay, contacts.reforming)
    plain = all(law is None for law in laws) and contacts.stiffness == "independent"
    # so fast that next to none holds that pins on the way, their law is lost beside 1
    fleeting = contacts.grains is not None and not contacts.grains.holds_at(drive.velocity)
    if drive.forward and (drive.time is None or plain) and not fleeting:
        return solve_forward(contacts, drive.path, tolerance, drive.velocity, progress)
    if not plain:
        from master._old.timed import solve_timed

        return solve_timed(contacts, drive, tolerance, progress)
    from master._old.cohorts import solve_cohorts

    return solve_cohorts(contacts, drive.path, tolerance, progress)
