"""The master equation for a rigid or a soft slider, along any path."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy.typing as npt

from master.lives.cold import ColdLife
from master.outcome import Progress, unheard
from master.rigid import solve_rigid
from master.soft.solution import SoftSolution, solve_soft
from master.solution import Solution
from origins import Contacts, Drive
from origins.contacts import LAWS, check_contacts
from origins.drive import SlipRule
from origins.errors import check_tolerance, positive

if TYPE_CHECKING:
    from master._old.timed import TimedSolution
    from master.paper.q15_transient import AgeingTransient


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
    wall_time: float | None = None,
) -> Solution | TimedSolution | SoftSolution | AgeingTransient:
    """Force on a slider from X = 0 along a path (paper Eqs. Q5a-Q6, Secs. IV and V, App. C, Sec. III D).

    Solved by number conservation, written with survivals, on panels. In the order in which they
    work: `rigid` turns contacts and drive into a motion (motion.motion) and a life (lives.cold, ...:
    what is left of contacts born together); renewal.edges says where panels end, renewal.march
    solves them one after the other with what renewal.births and renewal.kernels say of earlier
    births, by the polynomials of renewal.rule; renewal.reading reads force and holding share. Under
    a spring soft.solution follows the same march from slip to slip. How that equation follows from
    (Q5a) stands in docs/equations.md; the paper's own scheme is master.paper.explicit.

    Parameters
    ----------
    contacts : Contacts
        Thresholds, starting stretches and any laws of a contact. The paper's closure of ageing is
        taken alone and where a rigid slider moves forward at one speed.
    path : array of shape (n,)
        Slider positions X (lengths), any spacing, straight between points; where they turn round
        contacts break at -x_s as well. With a spring, positions X_T of the drive, which begins
        where it balances the start.
    tolerance : float
        Largest error of the force wanted, in units of the mean threshold.
    velocity : float
        Speed along the path (length per time); at T = 0 nothing depends on it but ageing, delay and
        thresholds that grow.
    time : array of shape (n,), optional
        When each point is reached, instead of the velocity: for holds and velocity steps.
    spring : float, optional
        K/(N_c <k>) of a soft slider; None: rigid.
    slip : "reset", "reform-after" or "instant"
        What a slip of a soft slider does. At the instability F'(X) = -K:
        "reset": all contacts are drawn anew, relaxed, and X jumps to where K (X_T - X) = F (the
        paper's); where thresholds grow with age they have just pinned;
        "reform-after": broken contacts stay out until the slip ends, those that hold stretch and
        may break;
        "instant": contacts re-form at once, and X goes to the first X' with F(X') + K X' = K X_T.
    progress : callable, optional
        Called as progress(error), in mean thresholds, with the error estimate.
    wall_time : float, optional
        Seconds after which the solution ends with what it has, success being False: the path is cut
        there. Taken at T = 0 and without delay under a spring.

    Returns
    -------
    Solution, TimedSolution where contacts have rates or age and the path turns round or takes its
    own time, SoftSolution where there is a spring, AgeingTransient for the paper's closure of ageing
        With success = False and the reason in `message` where the tolerance was not reached.

    Raises
    ------
    InputError
        For a path that is not finite, for keywords that are not as said above, and for laws of the
        contacts that are not taken on that path yet.
    """
    tolerance = check_tolerance("tolerance", tolerance)
    drive = Drive(path, velocity, time, spring, slip)
    if wall_time is not None:
        wall_time = positive("wall_time", wall_time)
    check_contacts(contacts, "master.solve", LAWS, own_rates=True)
    in_time = {"thermal", "ageing", "grains"}.intersection(contacts.laws)
    if drive.spring is None and not in_time:
        return solve_rigid(contacts, drive, ColdLife(contacts), tolerance, progress, wall_time)
    if drive.spring is not None and not in_time and contacts.delay is None:
        return solve_soft(contacts, drive, tolerance, progress, wall_time)
    from master._old.solve import solve as solve_old

    keywords: dict[str, Any] = {"velocity": velocity, "time": time, "spring": spring, "slip": slip}
    solved: TimedSolution | SoftSolution | AgeingTransient
    solved = solve_old(contacts, path, tolerance, **keywords, progress=progress)
    return solved
