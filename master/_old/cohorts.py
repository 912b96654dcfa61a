"""Any path, turning points and all, at T = 0: the master equation leg by leg, by exact cohorts.

On every straight leg the equation is the renewal equation of forward motion whose source is what old cohorts break;
what is born on a leg becomes one more cohort. Legs are solved on lattices refined together until the force along the
whole path changes by less than the tolerance.
"""

import time
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from master._old.cohort import SLACK, starting
from master._old.forward import MOST_NODES, ROUND_OFF, around, estimate, first_step, least_share
from master._old.law import Law
from master._old.leg import Leg, State
from master._old.moves import Move, moves
from master._old.stretches import CohortDistribution, stretches
from master.outcome import Progress, outcome, unheard
from origins import Contacts
from origins.brief import brief
from origins.errors import finite, refuse

Array = npt.NDArray[np.float64]

_BEYOND = 1.7
_STALL = 20.0
_MOST_AROUND = 40  # points of one leg
_NARROW = 5e-7  # width of laws that lattices do not tell from exact values
_CUBE = 0.375
_EIGHTH = 0.125  # errors that fall as the cube, from lattice to lattice
_SEVENTH = 0.15  # of the last difference is left then
_EARLY = 1.5  # of the second difference, beside corners: the first may be one of lattices that do not resolve them
_TABLES = 4.0  # times as much as the last terms of series tell, where these are all there is
_LUCKY, _TWICE = 0.05, 4.0  # three times a seventh of an eighth; margin where two differences fell faster
_ACCURACY = 1e-13
_FURTHEST = 1e6  # mean thresholds: round-off of places is felt beyond


class Course:
    """All legs of a path on one level of refinement; lengths in units of the mean threshold."""

    def __init__(
        self,
        law: Law,
        begin: State,
        path: list[Move],
        x: Array,
        steps: list[float],
        accuracy: float,
        coarser: "Course | None",
    ) -> None:
        self.law, self._path, self._x = law, path, x
        self.legs: list[Leg] = []
        self._watched: list[Array] = []
        # what the start breaks does not depend on the lattice
        state, known_to, first = begin, 0.0, coarser.legs[0].first if coarser else None
        for move, step in zip(path, steps, strict=True):
            y = self._travels(move)
            leg = Leg(law, state, move.direction, move.travel, step, accuracy, known_to, y, first)
            self.legs.append(leg)
            self._watched.append(leg.force(y))
            first = None
            if len(self.legs) < len(path):
                state, known_to = leg.end_state(move.travel).whole(law), step

    @property
    def table_error(self) -> float:
        """What the series of breaks and of births are off by in all."""
        return self.legs[-1].table_error

    def _travels(self, move: Move) -> Array:
        return np.clip(move.direction * (self._x[move.points] - move.turn), 0.0, move.travel)

    def force(self) -> Array:
        """Force at the points of the path."""
        return np.concatenate(
            [move.direction * leg.force(self._travels(move)) for move, leg in zip(self._path, self.legs, strict=True)]
        )

    def change(self, coarser: "Course") -> float:
        """Largest change of the force from a coarser course at the path's points; where corners add up errors are
        uneven, and points may be lucky: there at some nodes to either side of them as well."""
        change = float(np.abs(self.watched - coarser.watched).max())
        for move, leg, before in zip(self._path, self.legs, coarser.legs, strict=True):
            if before.problem.rough and leg.end > 0.0:
                near = around(self._travels(move), before.step, leg.end, _MOST_AROUND)
                near = near[leg.covers(near) & before.covers(near)]
                change = max(change, float(np.abs(leg.force(near) - before.force(near)).max(initial=0.0)))
        return change

    @property
    def nodes(self) -> int:
        """Nodes of the widest lattices of all legs."""
        return sum(leg.nodes for leg in self.legs)

    @property
    def watched(self) -> Array:
        """Force at all points that are looked at for errors, along the motion."""
        return np.concatenate(self._watched)


@dataclass(frozen=True)
class PathSolution:
    """F along a path that may turn round, with the error it is good to.

    Attributes
    ----------
    path : array of shape (n,)
        Slider positions X (lengths).
    force : array of shape (n,)
        F/(N_c <k>), the mean stretch of the contacts (a length).
    force_error : float
        Bound on the largest error of `force` over the path, in units of the mean threshold.
    holding : array of shape (n,)
        Fraction of contacts that hold: 1, as broken contacts re-form at once.
    run_time : float
        Seconds that the solution took.
    nodes : int
        Nodes of all lattices of the last refinement; 0 where none was needed.
    success : bool
        Whether force_error is at or below the tolerance asked for.
    message : str
        In words: what was reached, or why not; what was cut off from the start.
    """

    path: Array
    force: Array
    force_error: float
    holding: Array
    run_time: float
    nodes: int
    success: bool
    message: str
    _course: Course = field(repr=False)

    __repr__ = brief

    def distribution(self, position: float, leg: int | None = None) -> CohortDistribution:
        """Q(x;X) where the slider passes X = position (a length) on one straight leg of the path, counted from 0.

        `leg` may be left out where it passes there once. InputError where the path does not come there.
        """
        position = finite("position", position)
        legs, unit = self._course.legs, self._course.law.unit
        travels = [leg.direction * (position / unit - leg.state.at) for leg in legs]
        slack = [SLACK * (1.0 + leg.end) for leg in legs]
        there = [k for k, y in enumerate(travels) if -slack[k] <= y <= legs[k].end + slack[k]]
        if leg is None:
            # a turning point ends one leg and begins the next
            apart = [k for k in there if not (k - 1 in there and travels[k] <= slack[k])]
            if len(apart) > 1:
                several = ", ".join(map(str, apart))
                refuse("position", position, f"is passed on legs {several}; say which, as in leg={apart[0]}")
            if not apart:
                refuse("position", position, "the path does not come there")
            leg = apart[0]
        if leg not in there:
            refuse("leg", leg, f"does not pass {position:g}; {len(legs)} legs are counted from 0")
        chosen = legs[leg]
        state = chosen.end_state(float(np.clip(travels[leg], 0.0, chosen.end)))
        return stretches(self._course.law, state.cohorts, state.at)


def solve_cohorts(
    contacts: Contacts, path: Array, tolerance: float = 1e-8, progress: Progress = unheard
) -> PathSolution:
    """Force along a path that may turn round, for a rigid slider that starts at X = 0, at T = 0 (paper App. C);
    arguments checked before.

    Every contact breaks where its stretch meets its threshold at +x_s or -x_s, so one that has survived a stretch of
    either sign is known to be stronger; the paper's P_b(x) = P(-x) forgets that.
    """
    began = time.perf_counter()
    path = np.asarray(path, dtype=float)
    unit = contacts.mean_threshold
    x = path / unit
    furthest = float(np.abs(x).max(initial=0.0))
    if furthest > _FURTHEST:
        at = int(np.abs(x).argmax())
        rule = f"is {furthest:.1g} mean thresholds; turn round within {_FURTHEST:.0e}, where |F| has long been F_k"
        refuse(f"path[{at}]", path[at], rule)
    law = Law(contacts, _reach(contacts, x))
    course, error, message = _refine(law, State(0.0, [starting(contacts, law)]), moves(x), x, tolerance, progress)
    if law.narrowest < _NARROW:
        # at a point where many break at once no lattice tells how many already have
        span = max(float(x.max()), 0.0) - min(float(x.min()), 0.0)
        error = max(error, float(contacts.thresholds.cdf(span * contacts.mean_threshold)))
        if error > tolerance:
            message = f"error estimate {error:.1e}, above the tolerance {tolerance:.1e}; {law.what_helps(_NARROW)}"
    success, message = outcome(contacts, error, tolerance, message)
    return PathSolution(
        path=path,
        force=course.force() * unit,
        force_error=error,
        holding=np.ones(x.size),
        run_time=time.perf_counter() - began,
        nodes=course.nodes,
        success=success,
        message=message,
        _course=course,
    )


def _reach(contacts: Contacts, x: Array) -> float:
    """Longest stretch there can be, with some margin."""
    low, high = (float(end) for end in contacts.start.span)
    span = max(float(x.max()), 0.0) - min(float(x.min()), 0.0)
    return _BEYOND * max(span, 1e-300) + max(-low, high, 0.0) / contacts.mean_threshold


def _refine(
    law: Law, begin: State, path: list[Move], x: Array, tolerance: float, progress: Progress
) -> tuple[Course, float, str]:
    """All legs on lattices fine enough, the error estimate and the reason for stopping short."""
    travel = sum(move.travel for move in path)
    longest = max(move.travel for move in path)
    floor = ROUND_OFF * (1.0 + travel) + 2e-16 * longest**2
    steps = [first_step(law, True, max(move.travel, 1e-300), tolerance) for move in path]
    finest = min(1e-6 * tolerance, _ACCURACY)
    coarser: Course | None = None
    best: tuple[Course, float] | None = None
    difference = before = np.inf
    differences: list[float] = []
    while True:
        # series need not follow what a coarse lattice has wrong
        accuracy = max(finest, min(1e-5 * tolerance, 1e-4 * difference))
        course = Course(law, begin, path, x, steps, accuracy, coarser)
        if coarser is not None:
            before, difference = difference, course.change(coarser)
            differences.append(difference)
            least = max(_least_share(leg) for leg in course.legs)
            if law.atoms.size and not law.diverges and _CUBE <= least < 1.0 and np.isfinite(before):
                error = _beside_atoms(differences)
            else:
                early = _EARLY if least >= _CUBE and len(differences) == 2 else 0.0
                error = estimate(difference, before, max(least, early), law.diverges)
            error += floor + _TABLES * course.table_error
            progress(error)
            if np.isfinite(before):
                if best is None or error < best[1]:
                    best = course, error
                stalled = difference <= floor or (difference > 0.5 * before and difference < _STALL * floor)
                if best[1] <= tolerance:
                    return *best, ""
                if stalled:
                    return *best, f"round-off allows {best[1]:.1e}, above the tolerance {tolerance:.1e}"
                if max(move.travel / step for move, step in zip(path, steps, strict=True)) > MOST_NODES / 2:
                    reached = f"error estimate {best[1]:.1e} on {best[0].nodes} nodes, above the tolerance"
                    return *best, f"{reached} {tolerance:.1e}; {law.what_helps(max(steps))}"
        coarser = course
        steps = [0.5 * step for step in steps]


def _least_share(leg: Leg) -> float:
    """The smallest part of the last difference that is believed to be the error left: where corners fold,
    errors fall as the cube, taken with a margin of three; what seems to fall faster began too far off. What a start
    hands on may bend where its law is smooth."""
    return max(least_share(leg.problem, leg.step), _CUBE if leg.problem.rough else _EIGHTH)


def _beside_atoms(differences: list[float]) -> float:
    """Error of the last of three or more lattices from the differences between them, where corners come back one exact
    value later.

    A corner and a point of the path may share a cell of several lattices in a row: then both are off by the same, and
    their difference is luck. So no difference is believed to have fallen faster than the cube, an eighth, of the one
    before, unless the one before had as well.
    """
    last, before = differences[-1], differences[-2]
    if last == before == 0.0:
        return 0.0
    ratio = last / before if before > 0.0 else 1.0
    lucky = _LUCKY * before
    if len(differences) > 2:
        earlier = before / differences[-3] if differences[-3] > 0.0 else 1.0
        if earlier < _EIGHTH and ratio < _EIGHTH:
            lucky *= _TWICE * earlier
        ratio = max(ratio, earlier)  # what fell unevenly may do so again
    return max(last * max(ratio if ratio < 2.0 * _EIGHTH else 2.0, _SEVENTH), lucky)
