"""a, b and D_c of rate and state from the solved answers of contacts to velocity steps and rests."""

import time
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from master.rate_state.critical_spring import UNKNOWN, CriticalSpring, critical_spring_of
from master.rate_state.law import EvolutionLaw, RateStateLaw
from master.rate_state.reading import TWICE, Reading, read_steps
from master.rate_state.rests import healing_of, rest_of
from master.rate_state.result import CONSTANT, Misfit, Parameter, RateState, SpeedScan
from master.rate_state.speeds import Slope, constant_between, fill_scan, slope_at
from master.rate_state.traces import LIVES, SLOW_TOLERANCE, Rest, VelocityStep, is_slow, steps_about
from master.steady.kinetic import kinetic_curve
from origins import Contacts
from origins.contacts import LAWS, check_contacts
from origins.errors import (
    InputError,
    between,
    check_tolerance,
    one_of,
    positive_array,
    refuse,
    whole,
)
from origins.thresholds.law import Array

# of the speed: a step so small that the answer is proportional to it, for the critical spring
SMALL_STEP = 1.1
# after a rest the force changes by ten times as much as by a step, and a tolerance takes the longer
LOOSER = 10.0
# of the change of force after a step: a larger error of it asks for a lower tolerance, of FINEST mean thresholds at
# least, as rounding and the tenth of it that smaller steps take leave no room for more
OF_CHANGE, FINEST = 1e-3, 1e-9


def rate_state(
    contacts: Contacts,
    velocity: float = 1.0,
    *,
    ratio: float = float(np.e),
    evolution: EvolutionLaw = "slip",
    rests: npt.ArrayLike | None = None,
    decades: int = 2,
    tolerance: float = 1e-5,
    progress: Callable[[str], None] = lambda what: None,
    known: Callable[[Callable[[], RateState]], None] = lambda so_far: None,
) -> RateState:
    """a, b, a - b, D_c and the healing rate of contacts on a rigid slider, by the master equation.

    contacts : with a law in time that `solve` and `kinetic_curve` take; the start does not matter.
    velocity : v > 0, length per time: the geometric mean of the speeds before and after each step.
    ratio : of the steps up and down, 1.01 to 100.
    evolution : "slip" or "ageing", the law of the state, see RateStateLaw.
    rests : times at rest, shape (n,), before the slider goes on at v; None: none.
    decades : to either side of v, over which is looked where the numbers are constant; 0: nowhere.
    tolerance : of forces, in mean thresholds; after rests ten times this. It is lowered where steps change the force so
        little that it would be known to less than 1e-3 of its change; of contacts with heat whose thresholds grow it is
        1e-3 at least, as a step takes 5 to 40 s to that.
    progress : called with a word on what begins.
    known : called once, after the first steps at v, with a function that gives what is known when it is called, for a
        caller who is interrupted: springs and speeds that were not reached are NaN, such rests are left out, and
        `success` is False.

    a is the largest change of the force after a step, b = a - (a - b), and D_c that of the law that goes on like the
    solved force; see `read_steps`, which says what the `definition` of each compares.

    Raises InputError for contacts whose force does not depend on time, as `solve` and `kinetic_curve` do, and for
    numbers outside these ranges; and for contacts with heat whose thresholds grow where the first steps, of a minute or
    two, change the force by less than its error.
    """
    began = time.perf_counter()
    check_contacts(contacts, "master.rate_state", LAWS, own_rates=True)
    if not contacts.in_time:
        hint = 'give them a law in time, such as thermal = Thermal("eyring", width=0.03)'
        raise InputError(f"contacts: a = b = 0: their force does not depend on the speed; {hint}")
    if contacts.ageing is not None and contacts.ageing.closure == "paper":
        refuse(
            "closure", "paper", 'of ageing follows one speed without steps; use closure = "exact"'
        )
    velocity = between("velocity", velocity, 1e-100, 1e100)
    ratio = between("ratio", ratio, 1.01, 100.0, "steps in experiments are 3 to 10")
    one_of("evolution", evolution, ("slip", "ageing"))
    times = np.empty(0) if rests is None else np.sort(positive_array("rests", rests))
    decades, tolerance = whole("decades", decades, 0), check_tolerance("tolerance", tolerance)
    if slow := is_slow(contacts):
        tolerance = max(tolerance, SLOW_TOLERANCE)
    contacts = contacts.replace(start=None)

    progress("velocity steps")
    curve, unit = kinetic_curve(contacts, velocity), contacts.mean_threshold
    steps = steps_about(contacts, velocity, ratio, tolerance)
    if slow:
        _check_resolved(steps)
    found, slope = read_steps(steps, evolution), slope_at(contacts, velocity)
    small: Sequence[VelocityStep] = ()
    larger: Sequence[VelocityStep] = steps
    speeds = np.asarray(velocity * 10.0 ** np.arange(-decades, decades + 1.0))
    scan, solved, own, done = SpeedScan.of(speeds, found), list[Rest](), UNKNOWN, False

    def so_far() -> RateState:
        """The numbers from the steps, and from the speeds and rests that are solved."""
        force = float(curve.force)
        law = RateStateLaw(force, velocity, found.a, found.b, found.slip_distance, evolution)
        # F_k is curved in ln v, and b is of the finite step: about the middle of both steady forces the law meets
        # either
        middle = 0.5 * (steps[0].steady_before + steps[0].steady_after)
        about = replace(law, kinetic_force=middle)
        law_steps = tuple(about.step(one.slip, one.before, one.after) for one in steps)
        largest = max(abs(found.a), abs(found.b)) * steps[0].log_ratio
        by_law = _spring_by_law(found, slope)
        at_rest = np.array([one.time for one in solved])
        success, message = _judged([*steps, *small], solved, times.size, found, done)
        return RateState(
            velocity=velocity,
            kinetic_force=force,
            kinetic_force_error=float(curve.force_error) * unit,
            **_parameters(found, slope, scan),
            direct_slip=found.direct_slip,
            healing=healing_of(solved),
            law=law,
            steps=steps,
            law_steps=law_steps,
            rests=tuple(solved),
            law_rests=replace(law, evolution="ageing").after_rest(at_rest),
            misfit=_misfit(steps, law_steps, 0.0, largest),
            misfit_later=_misfit(steps, law_steps, found.direct_slip, largest),
            critical_spring=by_law.value,
            critical_spring_error=by_law.error,
            critical_spring_solved=own.value,
            critical_spring_solved_error=own.error,
            scan=scan,
            run_time=time.perf_counter() - began,
            success=success,
            message=message,
        )

    known(so_far)
    if not slow and (finer := _finer(steps, tolerance)) < tolerance:
        tolerance = finer
        progress("velocity steps to a lower tolerance")
        finer_steps = steps_about(contacts, velocity, ratio, tolerance)
        steps, found = finer_steps, read_steps(finer_steps, evolution)
        scan, larger = SpeedScan.of(speeds, found), finer_steps
    if found.significant:
        progress("smaller velocity steps")
        if slow:  # still smaller ones would be lost in the error
            small = steps_about(contacts, velocity, ratio**0.5, tolerance)
        else:
            smaller = min(SMALL_STEP, ratio**0.5)
            small, larger = (
                steps_about(contacts, velocity, each, 0.1 * tolerance)
                for each in (smaller, smaller**2)
            )
        # what swings on after the end of an answer counts by the length over which it would decay, which is not known
        if all(one.settled for one in [*small, *larger]):
            own = critical_spring_of(small, unit, larger)
        fill_scan(scan, contacts, ratio, evolution, tolerance, progress)
    else:  # smaller steps, other speeds and rests, which take minutes, would be lost in the error
        times = times[:0]
    for number, rest in enumerate(times, start=1):
        progress(f"rest {number} of {len(times)}")
        loose = tolerance if slow else LOOSER * tolerance
        solved.append(rest_of(contacts, velocity, float(rest), loose))
    done = True
    return so_far()


def _finer(steps: Sequence[VelocityStep], tolerance: float) -> float:
    """The tolerance that tells the change of the force after these steps to OF_CHANGE of it, or the same; steps that do
    not become steady are known no better with another."""
    allowed, error = OF_CHANGE * _change(steps), steps[0].error
    if error <= allowed or not steps[0].settled:
        return tolerance
    return max(tolerance * allowed / error, min(FINEST, tolerance))


def _change(steps: Sequence[VelocityStep]) -> float:
    """The smaller of the largest changes of the force after each step, a length."""
    return min(float(np.ptp(one.force)) for one in steps)


def _check_resolved(steps: Sequence[VelocityStep]) -> None:
    """Raise InputError where the error of the force is above its change, before minutes of work on smaller steps, other
    speeds and rests, which are then known no better."""
    if steps[0].error > (change := _change(steps)):
        hint = f"known to {SLOW_TOLERANCE:g} mean thresholds, and less well where that takes too much work"
        raise InputError(
            f"contacts: the force changes by {change:.1e} after a step, and its error is {steps[0].error:.1e}: heat "
            f"and strengthening together are {hint}; kinetic_curve gives F_k, and eq_model.simulate follows steps"
        )


def _parameters(found: Reading, slope: Slope, scan: SpeedScan) -> dict[str, Parameter]:
    """The four numbers of the steps with their errors and ranges; v is in the middle of the scan."""
    room, middle = CONSTANT * max(abs(found.a), abs(found.b)), scan.velocity.size // 2
    values = {"a": found.a, "b": found.b, "slip_distance": found.slip_distance}
    errors = {
        "a": found.a_error,
        "b": TWICE * found.a_error,
        "slip_distance": found.slip_distance_error,
    }
    out = dict[str, Parameter]()
    for column, (name, value) in enumerate(values.items()):
        apart = np.nan
        if found.others.size:
            apart = float(np.abs(found.others[:, column] - value).max())
        least = CONSTANT * abs(value) if name == "slip_distance" else room
        span = constant_between(scan.velocity, getattr(scan, name), middle, least)
        out[name] = Parameter(value, errors[name], apart, span.low, span.high)
    span = constant_between(scan.velocity, scan.a_minus_b, middle, room)
    apart = abs(found.a - found.b - slope.value)
    return out | {"a_minus_b": Parameter(slope.value, slope.error, apart, span.low, span.high)}


def _spring_by_law(found: Reading, slope: Slope) -> CriticalSpring:
    """(b - a)/D_c, and what the errors of a, b and D_c make of it; 0, known, where a > b by more than these, and not
    known where b > a without a D_c."""
    if not found.evolves:
        return CriticalSpring(0.0, 0.0) if slope.value > slope.error else UNKNOWN
    value = max(found.b - found.a, 0.0) / found.slip_distance
    if found.a - found.b > (off := (1.0 + TWICE) * found.a_error):
        return CriticalSpring(value, 0.0)
    return CriticalSpring(value, (off + value * found.slip_distance_error) / found.slip_distance)


def _misfit(
    steps: Sequence[VelocityStep], laws: Sequence[Array], begin: float, unit: float
) -> Misfit:
    """The largest one at slips from `begin` on, divided by the force `unit`."""
    worst = Misfit(0.0, begin)
    for one, law in zip(steps, laws, strict=True):
        off = np.where(one.slip >= begin, np.abs(law - one.force), 0.0)
        at = int(np.argmax(off))
        if (misfit := float(off[at]) / unit) > worst.share:
            worst = Misfit(misfit, float(one.slip[at]))
    return worst


def _judged(
    steps: Sequence[VelocityStep], rests: Sequence[Rest], asked: int, found: Reading, done: bool
) -> tuple[bool, str]:
    """Whether all is `done` with as many rests as were asked for, answers are known and became steady, and there is a
    D_c; and a message."""
    faults = list[str]()
    if len(rests) < asked:
        faults.append(f"interrupted: {asked - len(rests)} of {asked} rests were not followed")
    elif not done:
        faults.append("interrupted: not all steps were followed")
    if not all(one.settled for one in steps):
        remaining = max(one.error / max(float(np.ptp(one.force)), 1e-300) for one in steps)
        faults.append(
            f"the force after a step is known to {remaining:.1e} of its change only, {LIVES[-1]:.0f} mean thresholds "
            "after it: contacts break in step with one another there, or the change is below the tolerance"
        )
    if not all(one.success for one in rests):
        faults.append("the force after a rest is not known to the tolerance")
    if not found.significant:
        faults.append(
            "neither a nor b is above its error, and smaller steps, other speeds and rests, known no better, were not "
            "followed; a lower tolerance tells more"
        )
    elif not found.evolves:
        faults.append("b is not above its error, so that there is no D_c")
    return not faults, "; ".join(faults) or "all answers became steady within the tolerance"
