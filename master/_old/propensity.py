"""How prone to stick-slip: K*, F_s/F_k, X* and the onset power of P_c, each with its error."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from master._old.cycle import Cycle
from master._old.decoherence import decoherence_length
from master._old.forward import MOST_NODES, SMOOTH, estimate, first_step, round_off
from master._old.problem import Problem
from master._old.renewal import LaterReleased
from master._old.steady import check_finite, steady_of
from master.outcome import judged
from origins import Contacts, InputError
from origins.contacts import LAWS, check_contacts
from origins.errors import check_tolerance, positive

Array = npt.NDArray[np.float64]

_BRACKETS = 12
_TOGETHER = 1e-8  # of X: no further apart are points on both sides of a jump
_ZOOMS = 12
_JUST_BESIDE = 2e-12
_BESIDE_ERROR = 4e-12
_FEW, _TURNS = 1e-6, 8
_BROAD, _LIVES = 1e4, 2.0
_FAR_OUT = np.logspace(0.0, -12.0, 200)
_UNSTRETCHED = 1e-12
_SAFE = 2.0
_AROUND = 0.45 * np.arange(-7.0, 8.0)  # steps of a lattice


@dataclass(frozen=True)
class Propensity:
    """Measures of stick-slip propensity for a start, a law of thresholds and the laws of single contacts.

    Attributes
    ----------
    critical_spring, critical_spring_error : float
        K*/(N_c <k>) = max over X of -dF/dX, in units of N_c <k>: a softer spring is unstable (paper Eq. Q16). 0 where
        the force never falls; inf where it drops at one X.
    static_to_kinetic, static_to_kinetic_error : float
        F_s/F_k, the largest force over the kinetic one; 1 where the force rises to it from below.
    decoherence_length, decoherence_length_error : float
        X* (a length) of the slowest e^{-X/X*} in F - F_k; inf where nothing decays exponentially.
    onset_power, onset_power_error : float
        m of P_c(x) ~ (x - a)^m at its lower end.
    run_time : float
        Seconds.
    success : bool
        Whether K* (relative to 1 + K*) and F_s (in mean thresholds, or in mean stretches at a break where that is by a
        rate) are known within the tolerance asked for.
    message : str
        In words: what was reached.
    """

    critical_spring: float
    critical_spring_error: float
    static_to_kinetic: float
    static_to_kinetic_error: float
    decoherence_length: float
    decoherence_length_error: float
    onset_power: float
    onset_power_error: float
    run_time: float
    success: bool
    message: str


def propensity(contacts: Contacts, tolerance: float = 1e-8, *, velocity: float = 1.0) -> Propensity:
    """Stick-slip propensity of `contacts` on a slider that moves forward from their start, at `velocity` (length per
    time; only rates, ageing and delay tell).

    F(X) is followed for ten mean thresholds (of the stretches at which contacts break, where that is by a rate), and
    beyond the one that one in a million of those that hold exceed (at most 10,000 means; what may come beyond is in
    the errors), on lattices refined until K* (relative to 1 + K*) and F_s/F_k change by less than `tolerance`, or as
    far as a million nodes allow; the errors say how far.

    Of contacts that age, those that start beside their thresholds break at a rate without bound as X = 0 is left, few
    as they may be: there F' is looked at from X = tolerance <x_s> on.

    Raises InputError where <x_s^2> is infinite: there is no kinetic force to compare with.
    """
    began = time.perf_counter()
    tolerance = check_tolerance("tolerance", tolerance)
    check_contacts(contacts, "master.propensity", LAWS)
    check_finite(contacts)
    cycle = Cycle(contacts, positive("velocity", velocity))
    steady = steady_of(contacts, cycle)
    unit = cycle.unit
    kinetic = steady.force / unit
    if not kinetic > 0.0:
        raise InputError(
            f"reforming: contacts form again behind x = 0 and bear {steady.force:.3g} in steady sliding, of which no "
            "F_s is a multiple; ask master.phase_line for K* alone"
        )
    spring, spring_error, static, static_error = extremes(contacts, cycle, tolerance)
    length, length_error = decoherence_length(contacts, cycle)
    ratio = max(static / kinetic, 1.0)
    sure_spring, spring_message = judged("K*", spring_error / (1.0 + spring), tolerance)
    sure_static, static_message = judged("F_s", static_error, tolerance)
    return Propensity(
        critical_spring=spring,
        critical_spring_error=spring_error,
        static_to_kinetic=ratio,
        static_to_kinetic_error=(static_error + ratio * steady.force_error * contacts.mean_threshold / unit) / kinetic,
        decoherence_length=length,
        decoherence_length_error=length_error,
        onset_power=contacts.thresholds.onset_power,
        onset_power_error=contacts.thresholds.onset_power_error,
        run_time=time.perf_counter() - began,
        success=bool(sure_spring and sure_static),
        message=f"{spring_message}; {static_message}",
    )


def extremes(contacts: Contacts, cycle: Cycle, tolerance: float) -> tuple[float, float, float, float]:
    """K*/(N_c <k>), its error, the largest force and its error, these in units of the cycle's length."""
    lowest = min(contacts.start.span[0] / cycle.unit, 0.0)
    horizon, followed = _horizon(contacts, cycle)
    problem = Problem(contacts, horizon - lowest, tolerance, cycle)
    spring, spring_error, static, static_error = _extremes(problem, tolerance)
    if not followed and horizon * float(cycle.law.sf(horizon * cycle.unit)) > 2.0 * _FEW:
        check_finite(contacts)
        kinetic = steady_of(contacts, cycle).force / cycle.unit
        fall, excess = _beyond(cycle, horizon, kinetic)
        spring_error = max(spring_error, fall - spring)
        static_error = max(static_error, kinetic + excess - static)
    return spring, spring_error, static, static_error


def _horizon(contacts: Contacts, cycle: Cycle) -> tuple[float, bool]:
    """How far to follow F, in units of the cycle's mean: ten and beyond one in a million; where generations come one
    after the other, clearly apart, only the first, which is the sharpest: then all that matters is followed."""
    unit, law = cycle.unit, cycle.law
    shortest, longest = float(law.ppf(1e-17)) / unit, float(law.isf(1e-17)) / unit
    # those that hold at X = 0 may break later than others do after a break
    longest = max(longest, float(contacts.thresholds.isf(1e-17)) / unit)
    low, high = (float(end) / unit for end in contacts.start.span)
    if longest - low < 2.0 * shortest - high:
        return longest - max(low, 0.0), True
    if cycle.breaking is not None and longest > _BROAD:
        return _LIVES * longest, False  # of contacts with lives of all lengths the longest-lived bear the force
    # of those that hold at a time one in a million is older: the older, the longer a contact is there to be met
    last = 1.0
    for _ in range(_TURNS):
        last = max(float(law.isf(_FEW / last)) / unit, 1.0)
    followed = max(10.0, min(last, _BROAD) + 1.0)
    if contacts.grains is not None and contacts.grains.age is not None:
        # those that hold at X = 0 are the older, and stronger than all that come after them
        older = contacts.grains.age - contacts.grains.growth.first_pinning_time
        followed = max(followed, contacts.grains.breaking(cycle.velocity, older).support()[1] / unit - low)
    return followed, False


def _beyond(cycle: Cycle, horizon: float, kinetic: float) -> tuple[float, float]:
    """How fast F may fall, and by what it may exceed F_k, where it is not followed.

    From -dF/dX = integral of x p (u - 1), u being the breaks per contact: (u - 1) has an integral of about F_k, and
    falls to what the lives beyond make.
    """
    law, unit = cycle.law, cycle.unit
    half = 0.5 * horizon
    x = law.isf(float(law.sf(half * unit)) * _FAR_OUT) / unit
    x = np.unique(np.append(x[np.isfinite(x)], half))
    density, held = law.pdf(x * unit) * unit, law.sf(x * unit)
    older = float(np.trapezoid(held * x, np.log(x)))
    fall = float((x * density).max()) * kinetic + older
    return _SAFE * fall, _SAFE * (float((x * held).max()) + older) * kinetic


def _extremes(problem: Problem, tolerance: float) -> tuple[float, float, float, float]:
    """K*, its error, the largest force and its error, in units of the mean threshold."""
    floor = round_off(problem)
    # what breaks without a stretch takes no force away, however many they are
    at_once = np.abs(problem.release.force_at(problem.law.poles)) > _UNSTRETCHED
    drops = problem.chain.weights.size > 0 or bool(at_once.any())
    if problem.law.atomic and problem.first.single and problem.chain.births.size:
        at = problem.chain.births
        before = at - _beside(problem, at)
        force = problem.known(before) + (at - before) - problem.chain.released(before)
        return np.inf, 0.0, float(force.max()), floor
    begin = 0.0 if problem.contacts.ageing is None else tolerance
    step = first_step(problem.law, problem.rough, problem.end, tolerance)
    coarser: LaterReleased | None = None
    before, last, error = np.full(2, np.inf), np.full(2, np.inf), np.full(2, np.inf)
    while True:
        later = LaterReleased(problem, step, np.linspace(0.0, problem.end, 4096), 1e-2 * tolerance)
        found, places = _largest(problem, later, begin)
        if coarser is not None:
            before, last = last, _change(problem, later, coarser, places)
        if np.isfinite(before).all():
            error = np.array([_left(problem, float(a), float(b)) for a, b in zip(last, before, strict=True)])
            error += floor + later.left_out + later.drift
            if (drops or error[0] <= tolerance * (1.0 + found[0])) and error[1] <= tolerance:
                break
            if problem.end / step > MOST_NODES / 2:
                break
        coarser = later
        step *= 0.5
    spring, static = (float(value) for value in found)
    error[0] += float(problem.first.rate_error(places[:1])[0])
    # values at jumps were taken just beside them
    error = error + _BESIDE_ERROR * np.array([(1.0 + spring) ** 2, 1.0])
    largest = static, float(error[1])
    return (np.inf, 0.0, *largest) if drops else (max(spring, 0.0), float(error[0]), *largest)


def _largest(problem: Problem, later: LaterReleased, begin: float) -> tuple[Array, Array]:
    """Largest -dF/dX and largest F over begin <= X <= end, and where they are."""
    first, end = problem.first, problem.end

    def fall(x: Array) -> Array:
        return later.rate(x) - problem.known_rate(x)

    def force(x: Array) -> Array:
        return problem.known(x) - later(x)

    nodes = later.lattice.step * np.arange(1, int(end / later.lattice.step))
    jumps = np.concatenate([first.jumps, first.density.edges, problem.chain.births])
    apart = _beside(problem, jumps)
    beside = np.concatenate([jumps - apart, jumps + apart, [0.0, end]])
    x = np.unique(np.concatenate([nodes[nodes > begin], beside[(beside > begin) & (beside <= end)], [begin]]))
    (spring, at_spring), (static, at_static) = _maximum(fall, x), _maximum(force, x)
    return np.array([spring, static]), np.array([at_spring, at_static])


def _beside(problem: Problem, x: Array) -> Array:
    """How far from x what breaks there at exact thresholds has not broken yet."""
    return _JUST_BESIDE * np.maximum(x, problem.law.atoms.max(initial=0.0))


def _left(problem: Problem, last: float, before: float) -> float:
    """Error that two changes in turn leave."""
    if problem.rough:  # beside jumps errors fall unevenly: one small change proves nothing
        return 4.0 * max(last, before / 16.0)
    return estimate(last, before, SMOOTH, problem.law.diverges)


def _change(problem: Problem, later: LaterReleased, coarser: LaterReleased, places: Array) -> Array:
    """By how much -dF/dX and F differ between two lattices around the places of their largest values: at one point
    alone they may agree by chance, as errors depend on where among the nodes it falls."""
    around = np.clip(places[:, None] + coarser.lattice.step * _AROUND, 0.0, problem.end)
    slope, force = around
    return np.array(
        [np.abs(later.rate(slope) - coarser.rate(slope)).max(), np.abs(later(force) - coarser(force)).max()]
    )


def _maximum(function: Callable[[Array], Array], x: Array) -> tuple[float, float]:
    """Largest value between the sorted points x, and where: the best brackets are zoomed into, side by side."""
    values = function(x)
    at = int(values.argmax())
    best, place = float(values[at]), float(x[at])
    inner = np.flatnonzero((values[1:-1] >= values[:-2]) & (values[1:-1] >= values[2:])) + 1
    inner = inner[np.argsort(-values[inner])][:_BRACKETS]
    # across two points beside a jump as well, which may bend there only
    last = x.size - 1
    before = np.where(x[inner] - x[inner - 1] < _TOGETHER * x[inner], np.maximum(inner - 2, 0), inner - 1)
    after = np.where(x[inner + 1] - x[inner] < _TOGETHER * x[inner], np.minimum(inner + 2, last), inner + 1)
    ends = np.unique(np.stack([np.append(inner - 1, before), np.append(inner + 1, after)], axis=1), axis=0)
    left, right = x[ends].T
    for _ in range(_ZOOMS if inner.size else 0):
        grid = left[:, None] + (right - left)[:, None] * np.linspace(0.0, 1.0, 9)
        values = function(grid.ravel())
        at = int(values.argmax())
        if values[at] > best:
            best, place = float(values[at]), float(grid.ravel()[at])
        top = np.clip(values.reshape(grid.shape).argmax(axis=1), 1, 7)
        rows = np.arange(top.size)
        left, right = grid[rows, top - 1], grid[rows, top + 1]
    return best, place
