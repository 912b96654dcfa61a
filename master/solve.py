"""The master equation to the tolerance asked: lattices are refined until the error estimate is below it."""

import time

import numpy as np
import numpy.typing as npt

from master.problem import Problem
from master.renewal import Renewal, bound, later_released
from master.solution import Solution
from origins import Contacts, Drive
from origins.errors import positive

Array = npt.NDArray[np.float64]

ROUND_OFF = 1e-13
MOST_NODES = 2**20
_FEWEST_NODES = 64


def solve(contacts: Contacts, path: npt.ArrayLike, tolerance: float = 1e-8) -> Solution:
    """Force F(X) on a rigid slider that moves forward from X = 0, at T = 0 (paper Eqs. Q5a-Q6).

    Parameters
    ----------
    contacts : Contacts
        Thresholds and starting stretches.
    path : array of shape (n,)
        Slider positions X >= 0 that never turn back (lengths); any spacing.
    tolerance : float
        Largest error of the force wanted, in units of the mean threshold.

    Returns
    -------
    Solution
        With success = False and the reason in `message` where the tolerance was not reached.

    Raises
    ------
    InputError
        For a path that turns back, starts below 0 or is not finite, and for a tolerance that is not above zero.
    """
    began = time.perf_counter()
    tolerance = positive("tolerance", tolerance)
    drive = Drive(path)
    x = drive.path / contacts.mean_threshold
    problem = Problem(contacts, max(float(x[-1]), 1e-300), tolerance)
    first = problem.first
    force = first.mean_start + x - first.released(x)
    later, error, lattice, message = _refine(problem, x, tolerance)
    force = (force - later) * problem.unit
    success = error <= tolerance
    if success:
        message = f"error estimate {error:.1e} is within the tolerance {tolerance:.1e}"
    if contacts.cut_weight > 0.0:
        message += f"; a starting weight of {contacts.cut_weight:.1e} beyond every threshold was cut off"
    return Solution(
        path=drive.path,
        force=force,
        force_error=error,
        holding=np.ones(x.size),
        run_time=time.perf_counter() - began,
        success=success,
        message=message,
        _problem=problem,
        _lattice=lattice,
    )


def _refine(problem: Problem, x: Array, tolerance: float) -> tuple[Array, float, Renewal | None, str]:
    """J_1 at x, its error estimate, the finest lattice and the reason for stopping short."""
    end = float(x[-1])
    floor = ROUND_OFF * (1.0 + end)
    if not problem.chain.complete:
        message = "the atoms of the thresholds have too many distinct sums within the path; shorten it"
        return problem.chain.released(x), np.inf, None, message
    tiny = min(1e-2 * tolerance, 1e-9)
    listed = problem.law.atomic and problem.contacts.start.is_single
    if listed or bound(problem, end) <= 1e-2 * floor:
        message = f"round-off allows {floor:.1e}, above the tolerance {tolerance:.1e}"
        return problem.chain.released(x), floor, None, message
    step = first_step(problem, end, tolerance)
    previous, difference, before = None, np.inf, np.inf
    while True:
        later, lattice = later_released(problem, step, x, tiny)
        if previous is not None:
            before, difference = difference, float(np.abs(later - previous).max())
            error = estimate(difference, before) + floor
            if np.isfinite(before) and error <= tolerance:
                return later, error, lattice, ""
            if np.isfinite(before) and difference <= floor:
                return later, error, lattice, f"round-off allows {error:.1e}, above the tolerance {tolerance:.1e}"
            if end / step > MOST_NODES / 2:
                reason = f"error estimate {error:.1e} on {lattice.size} nodes, above the tolerance {tolerance:.1e}; "
                return later, error, lattice, reason + "shorten the path or loosen the tolerance"
        previous = later
        step *= 0.5


def first_step(problem: Problem, end: float, tolerance: float) -> float:
    """Coarsest of the lattices tried; the third should do, its error being of order (step / narrowest width)^8."""
    aim = 1.4 * problem.law.narrowest * min(tolerance, 1e-3) ** 0.125
    step = min(4.0 * aim, end / _FEWEST_NODES)
    step = max(step, end * 8.0 / MOST_NODES)
    atoms, weights = problem.law.atoms, problem.law.atom_weights
    if atoms.size:  # the heaviest atom falls on a node, so that it is folded without loss
        heaviest = float(atoms[weights.argmax()])
        step = heaviest / np.ceil(heaviest / step)
    return step


def estimate(difference: float, before: float) -> float:
    """Error of the last of three lattices from the two differences between them.

    With errors that fall by r from each lattice to the next, the last error is r/(1-r) of the last difference. The
    ratio seen is taken with a margin of 4, and never believed below 1/16.
    """
    if difference == 0.0:
        return 0.0
    ratio = difference / before if before > 0.0 else 1.0
    return difference * min(1.0, max(4.0 * ratio, 0.0625)) if ratio < 0.5 else 2.0 * difference
