"""A rigid slider that moves forward: lattices are refined until the error estimate is below the tolerance."""

import time
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from master._old.cycle import Cycle
from master._old.law import Law
from master._old.powers import find_powers
from master._old.problem import POWERS_FELT, Problem, law_of
from master._old.renewal import RESOLVED, LaterReleased, bound
from master._old.solution import Solution
from master._old.steady import check_finite, steady_of
from master.outcome import Progress, outcome, unheard
from origins import Contacts
from origins.errors import refuse

Array = npt.NDArray[np.float64]

ROUND_OFF = 1e-13
MOST_NODES = 2**20
SMOOTH = 1.0 / 32.0  # four times what is left of a difference at eighth order would be 1/64
_CLOSE = 0.5**0.5  # ratio of the steps of two lattices whose difference is at least the error of the finer
_COARSER = 9.0  # 4 (1/0.1)^(1/3)
_FAR_OFF = 1e4  # times the tolerance: the next lattice would not do either
_LEAST_BELIEVED = 0.25  # part of a difference that the error left is never said to be below, beside jumps
_FIRST_BELIEVED = 1.5  # the same for the first two lattices where J_1 is known but for what is smooth
_CLOSE_ENOUGH = 1e-6  # error beside powers that tables of first breaks are hardly below
_SHARE = 0.3  # of the tolerance, for a law known by a numerical solution
_FEW = 200  # positions: fewer may all fall where a lattice happens to be good
_FEWEST_NODES = 256
BROAD, _ENOUGH = 50.0, 2048  # means up to the longest of lives of all lengths, and nodes for them
_BY_CHANCE = 8.0
_STALL = 20.0  # times the floor: differences below this that no longer fall are round-off
_BESIDE = 0.9 * np.arange(-7.0, 8.0, 2.0)
_MOST_AROUND = 2000
_LONG, _RATHER_LONG = 2000.0, 50.0
_BEFORE, _FURTHER = 0.7, 1.5
_FURTHEST = 1e100  # mean thresholds: its square is still a number


def solve_forward(
    contacts: Contacts, path: Array, tolerance: float, velocity: float = 1.0, progress: Progress = unheard
) -> Solution:
    """Force F(X) on a rigid slider that moves forward from X = 0 (paper Eqs. Q5a-Q6), arguments checked before."""
    began = time.perf_counter()
    generations = 1.0 + float(path[-1]) / contacts.mean_threshold
    cycle = Cycle(contacts, velocity, _SHARE * tolerance / generations)
    if not cycle.unit > path[-1] / _FURTHEST and path[-1] <= _FURTHEST * contacts.mean_threshold:
        share = f"{cycle.unit / contacts.mean_threshold:.1g} of a mean threshold"
        refuse("velocity", velocity, f"contacts break by themselves within {share}; slide faster")
    x = path / cycle.unit
    if x[-1] > _FURTHEST:
        refuse("path[-1]", path[-1], f"is {x[-1]:.1g} mean thresholds; follow at most {_FURTHEST:.0e} of them")
    end, own = float(x[-1]), tolerance * contacts.mean_threshold / cycle.unit
    if _is_far(end, own):
        settled = _solve_far(contacts, path, tolerance, cycle, began, progress)
        if settled is not None:
            return settled
    end = max(end, 1e-300)
    law = law_of(contacts, end, cycle)
    if law.rough and cycle.release.plain and cycle.law is contacts.thresholds and not contacts.start.is_single:
        spread = _solve_spread(contacts, path, tolerance, law, began, progress)
        if spread is not None:
            return spread
    return solve_problem(Problem(contacts, end, own, cycle, law), path, tolerance, began, progress)


def _solve_spread(
    contacts: Contacts, path: Array, tolerance: float, law: Law, began: float, progress: Progress
) -> Solution | None:
    """From a start with a width by way of a relaxed one, which tells all about powers; None where P_c has none, or
    where that is so far from the tolerance that the start's own first breaks may do better."""
    relaxed = Contacts(contacts.thresholds)
    end = float(path[-1]) / law.unit + max(contacts.start.span[1], 0.0) / law.unit
    powers = find_powers(relaxed, law, end, POWERS_FELT * tolerance)
    if powers is None:
        return None
    from master._old.response import solve_from_relaxed

    problem = Problem(relaxed, end, tolerance, law=law, powers=powers)
    spread = solve_from_relaxed(contacts, problem, path, tolerance, began, progress)
    return spread if spread.success or spread.force_error < _CLOSE_ENOUGH else None


def _is_far(end: float, tolerance: float) -> bool:
    """Whether round-off adds up to something on the way, or the way is long."""
    return end > _LONG or (end > _RATHER_LONG and _added_up(end) > 0.1 * tolerance)


def _solve_far(
    contacts: Contacts, path: Array, tolerance: float, cycle: Cycle, began: float, progress: Progress
) -> Solution | None:
    """The same along a path to beyond where contacts have forgotten their start; None where it ends before that."""
    from master._old.settled import forgotten, left_to_settle

    x, share = path / cycle.unit, cycle.unit / contacts.mean_threshold
    at, end = forgotten(contacts, cycle, tolerance / share), float(x[-1])
    while at < _BEFORE * end:
        problem = Problem(contacts, at, tolerance / share, cycle)
        early = x <= at
        solved = solve_problem(problem, np.append(path[early], at * cycle.unit), tolerance, began, progress)
        check_finite(contacts)
        steady = steady_of(contacts, cycle)
        left = left_to_settle(problem, solved._later, steady, at, tolerance / share)
        error = max(solved.force_error, left * share + steady.force_error)
        if error <= tolerance or left * share <= solved.force_error:
            late = np.count_nonzero(~early)
            success, message = outcome(contacts, error, tolerance, solved.message)
            return replace(
                solved,
                path=path,
                force=np.append(solved.force[:-1], np.full(late, steady.force)),
                force_error=error,
                holding=np.append(solved.holding[:-1], np.full(late, steady.holding)),
                run_time=time.perf_counter() - began,
                success=success,
                message=message,
            )
        at *= _FURTHER
    return None


def solve_problem(
    problem: Problem, path: Array, tolerance: float, began: float, progress: Progress = unheard
) -> Solution:
    """The same of a problem stated before, since the time `began`; tolerance in mean thresholds of its contacts."""
    contacts, x = problem.contacts, path / problem.unit
    # errors are stated in mean thresholds, of which a cycle at a temperature is but a part
    share = problem.unit / contacts.mean_threshold
    force = problem.known(x)
    released, error, later, message = refined(problem, x, tolerance / share, progress)
    force, error = (force - released) * problem.unit, error * share
    success, message = outcome(contacts, error, tolerance, message)
    return Solution(
        path=path,
        force=force,
        force_error=error,
        holding=_holding(problem, later, x),
        run_time=time.perf_counter() - began,
        nodes=0 if later is None else later.lattice.size,
        success=success,
        message=message,
        _problem=problem,
        _later=later,
    )


def _holding(problem: Problem, later: LaterReleased | None, x: Array) -> Array:
    """All but those that broke within the last wait."""
    delay = problem.release.delay
    if delay == 0.0:
        return np.ones(x.size)

    def broken(x: Array, wait: float = 0.0) -> Array:
        count = problem.first.count.once(x, wait) + problem.chain.count.once(x, wait)
        return count if later is None else count + later.count(np.maximum(x - wait, -1e-300))

    # errors of the counts are not to make it less than none, or more than all
    return np.clip(1.0 - (broken(x) - broken(x, delay)), 0.0, 1.0)


def refined(
    problem: Problem, x: Array, tolerance: float, progress: Progress
) -> tuple[Array, float, LaterReleased | None, str]:
    """J_1 at x, its error estimate, what it was read from and the reason for stopping short."""
    end = float(x[-1])
    floor = round_off(problem)
    share = problem.unit / problem.contacts.mean_threshold  # words are in mean thresholds
    asked = f"above the tolerance {tolerance * share:.1e}"
    tiny = min(1e-2 * tolerance, 1e-9)
    listed = problem.law.atomic and problem.first.single
    if listed or bound(problem, end, 1e-2 * floor) <= 1e-2 * floor:
        message = f"{_limit(problem, floor, share)}, {asked}"
        return problem.chain.released(x), floor, None, message
    step = first_step(problem.law, problem.rough, end, tolerance)
    if problem.powers is not None:
        step = max(min(step, problem.powers.widest_step), 64.0 * end / MOST_NODES)
    elif problem.law.jumps.size:
        wanted = max(_step_between_jumps(problem.law, tolerance), min(step, 64.0 * end / MOST_NODES))
        step *= 0.5 ** max(np.ceil(np.log2(step / wanted)), 0.0)
    rough = problem.rough
    shrink = 0.5 if rough else _CLOSE
    coarser: tuple[LaterReleased, Array] | None = None
    best: tuple[Array, float, LaterReleased] | None = None
    difference = before = np.inf
    while True:
        later = LaterReleased(problem, step, x, tiny)
        answer = later(x)
        if coarser is not None:
            change = np.abs(answer - coarser[1])
            # towards X = 0 a coarser lattice hands over to finer ones earlier: there the change is the error itself
            finer = later.step_at(x) < coarser[0].step_at(x)
            before, difference = difference, float(change[finer].max(initial=0.0))
            # where points alone say that it is not good enough, no more need to be looked at
            far = rough and _LEAST_BELIEVED * difference > tolerance and difference > _STALL * floor
            if (rough or x.size < _FEW) and finer.any() and not far:
                near = around(x[finer], 2.0 * step, end, _MOST_AROUND)
                steps = later.step_at(near)  # 0 so close to X = 0 that nothing was asked for
                near = near[(steps > 0.0) & (steps < coarser[0].step_at(near))]
                difference = max(difference, float(np.abs(later(near) - coarser[0](near)).max(initial=0.0)))
            handed_over = 1.5 * float(change[~finer].max(initial=0.0))
            if rough:
                diverges = problem.law.diverges and problem.powers is None
                left = estimate(difference, before, least_share(problem, step), diverges)
                if problem.powers is not None and not np.isfinite(before):
                    left = _FIRST_BELIEVED * difference
            else:
                # two lattices that do not resolve the law may be closer to each other than to the truth
                left = difference if step < RESOLVED * problem.law.narrowest else 4.0 * difference
            error = max(left, handed_over) + later.left_out + later.drift + later.unseen + floor
            progress(error * share)
            if not rough or np.isfinite(before) or problem.powers is not None:
                if best is None or error < best[1]:
                    best = answer, error, later
                level = max(difference, float(change.max()))
                stalled = level <= floor or (difference > 0.5 * before and level < _STALL * floor)
                stalled = stalled and later.unseen <= tolerance
                if best[1] <= tolerance:
                    return *best, ""
                if stalled:
                    return *best, f"{_limit(problem, best[1], share)}, {asked}"
                if end / step > MOST_NODES / 2:
                    reached = f"error estimate {best[1] * share:.1e} on {later.lattice.size} nodes"
                    return *best, f"{reached}, {asked}; {problem.law.what_helps(step)}"
        coarser = later, answer
        # beside powers nothing falls evenly, but in the end fast
        step *= 0.25 if problem.powers is not None and np.inf > difference > _FAR_OFF * tolerance else shrink


def round_off(problem: Problem) -> float:
    """Error that no lattice goes below: tables, and what the rounding of each step adds up to."""
    # contacts that form again close to their thresholds break more often than they are long
    often = 1.0 if problem.release.born is None else max(problem.unit / problem.cycle.law.mean(), 1.0)
    return _added_up(problem.end * often) + known_to(problem)


def known_to(problem: Problem) -> float:
    """What the errors of the first breaks and of the law add to the force up to the path's end."""
    born = problem.release.born
    law = problem.cycle.error + (0.0 if born is None else born.rounding)
    return problem.first.error + law * (1.0 + problem.end)


def _added_up(end: float) -> float:
    return ROUND_OFF * (1.0 + end)


def _limit(problem: Problem, reached: float, share: float) -> str:
    """What no finer lattice mends; `share` turns units of the problem into those that are told."""
    known = known_to(problem)
    if known > 0.5 * reached:
        return f"breaks are known to {known * share:.1e} only"
    return f"round-off allows {reached * share:.1e}"


def least_share(problem: Problem, step: float) -> float:
    """The smallest part of the last difference that is believed to be the error left."""
    if not problem.rough:
        return SMOOTH
    if problem.powers is not None:
        return 2.0 * _LEAST_BELIEVED
    tallest = np.abs(np.concatenate([problem.law.jump_sizes, problem.first.jump_sizes])).max(initial=0.0)
    # what stands between two jumps closer than some nodes is not resolved: there nothing falls evenly yet
    return 2.0 if tallest * step > 0.25 else _LEAST_BELIEVED


def around(x: Array, step: float, end: float, most: int) -> Array:
    """Some nodes, apart by `step`, to either side of the positions x, or of about `most` of them, up to `end`: beside
    jumps errors depend on where among nodes a point falls."""
    near = (x[:: 1 + x.size // most, None] + step * _BESIDE).ravel()
    return near[(near > 0.0) & (near <= end)]


def first_step(law: Law, rough: bool, end: float, tolerance: float) -> float:
    """Coarsest of the lattices tried: the second should do, the third where the problem is rough, its error being of
    order (step / narrowest width)^8."""
    if rough:
        step = min(5.6 * law.finest * min(tolerance, 1e-3) ** 0.125, 4.0 * end / _FEWEST_NODES)
    else:
        step = min(2.1 * law.finest * min(tolerance, 3e-5) ** 0.125, end / _FEWEST_NODES)
        if law.edges[-1:].max(initial=0.0) > BROAD:  # what is short is forgotten soon, or `unseen` tells
            step = max(step, end / _ENOUGH)
    step = max(step, end * 8.0 / MOST_NODES)
    atoms, weights = law.atoms, law.atom_weights
    if atoms.size and (heaviest := float(atoms[weights.argmax()])) > 4.0 * step:
        step = heaviest / np.ceil(heaviest / step)  # it falls on a node, so that it is folded without loss
    return step


def _step_between_jumps(law: Law, tolerance: float) -> float:
    """Coarsest of three lattices of which the last should do: where jumps fold, errors are about the cube of what one
    step holds beside a jump."""
    return _COARSER * tolerance ** (1.0 / 3.0) / float(np.abs(law.jump_sizes).max())


def estimate(difference: float, before: float, least: float, diverges: bool) -> float:
    """Error of the last of three lattices from the two differences between them.

    With errors that fall by r from each lattice to the next, the last error is r/(1-r) of the last difference. The
    ratio seen is taken with a margin of 4, but never for less than `least`: a small one may be luck. Beside a
    diverging density errors fall unevenly, and by less than half each time.
    """
    if difference == 0.0:
        return 0.0
    if diverges:
        return 4.0 * max(difference, 0.25 * before if np.isfinite(before) else 0.0)
    ratio = difference / before if before > 0.0 else 1.0
    if ratio > 1.0:  # the one before was small by chance, and tells nothing
        return difference * max(_BY_CHANCE, least)
    return difference * max(4.0 * ratio if ratio < 0.25 else 2.0, least)
