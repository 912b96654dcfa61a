"""Contacts that age, on a rigid slider that moves forward at one speed, in either closure."""

import time
from dataclasses import replace
from typing import TYPE_CHECKING

from master.ageing_problem import AgeingProblem
from master.first_passage import first_passage
from master.forward import solve_problem
from master.outcome import outcome
from master.solution import Solution
from master.steady import SteadyState, steady_state
from origins import Contacts, Drive, InputError
from origins.errors import positive

if TYPE_CHECKING:
    from master.ageing_paper import AgeingSteadyState
    from master.ageing_transient import AgeingTransient


def solve_ageing(contacts: Contacts, drive: Drive, tolerance: float) -> "Solution | AgeingTransient":
    """F(X) with contacts.ageing. InputError for a spring, a path that turns, times, and other laws of the contact."""
    check_alone(contacts)
    drive.only_forward("ageing")
    if drive.time is not None:
        raise InputError("time: ageing takes one speed along the whole path; write velocity= instead")
    assert contacts.ageing is not None
    if contacts.ageing.closure == "paper":
        from master.ageing_transient import solve_paper

        return solve_paper(contacts, drive, tolerance)
    began = time.perf_counter()
    problem = AgeingProblem(contacts, drive.velocity, float(drive.path[-1]), tolerance)
    # the law's own mean is longer than that of fresh thresholds, or shorter
    scale = problem.unit / contacts.mean_threshold
    solution = solve_problem(problem, drive.path, tolerance / scale, began)
    error = scale * (solution.force_error + problem.law_error)
    reason = solution.message if not solution.success else f"breaks are known to {scale * problem.law_error:.1e}"
    reason = f"error estimate {error:.1e} is above the tolerance {tolerance:.1e}: {reason}"
    success, message = outcome(contacts, error, tolerance, reason)
    return replace(solution, force_error=error, success=success, message=message)


def steady_ageing(contacts: Contacts, velocity: float) -> "SteadyState | AgeingSteadyState":
    """Steady sliding with contacts.ageing, whatever the start. InputError for other laws of the contact beside it."""
    check_alone(contacts)
    positive("velocity", velocity)
    assert contacts.ageing is not None
    if contacts.ageing.closure == "paper":
        from master.ageing_paper import paper_steady_state

        return paper_steady_state(contacts.thresholds, contacts.ageing, velocity)
    passage = first_passage(contacts.thresholds, contacts.ageing, velocity)
    force, error = passage.kinetic_force()
    # at rest, contacts of the law of breaks slide alike
    reach = float(passage.law.isf(1e-9))
    steady = steady_state(Contacts(passage.law))
    return replace(
        steady,
        force=force,
        force_error=error / contacts.mean_threshold,
        cycle_length_error=(passage.error * reach + 1e-14 * steady.cycle_length) / contacts.mean_threshold,
    )


def check_alone(contacts: Contacts) -> None:
    """Raise InputError for what is not solved together with ageing."""
    for name in ("thermal", "delay", "reforming"):
        if getattr(contacts, name) is not None:
            raise InputError(f"contacts.{name}: not solved together with ageing; leave one of the two out")
