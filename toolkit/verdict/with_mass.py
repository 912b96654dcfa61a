"""More of a slider with mass: the points of one slip, and of the swing after it, that show it in its own time; and what
it does with its contacts' delay at both extremes."""

import time
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np

from origins.contacts import Contacts, Delay
from origins.errors import InputError
from origins.thresholds.law import Array
from toolkit.processes.signals import TimeIsUp
from toolkit.results.traces import with_slips
from toolkit.verdict.answers import Answer
from toolkit.verdict.readings import Reading
from toolkit.verdict.sliders.budget import Budget, long_delay
from toolkit.verdict.sliders.ensemble import SEED, follow_by_contacts
from toolkit.verdict.sliders.follow import ROUGHLY, follow
from toolkit.verdict.sliders.in_heat import with_stability
from toolkit.verdict.sliders.islands import with_barriers
from toolkit.verdict.sliders.machine import Machine, critical_damping, rigid_slider, slip_duration
from toolkit.verdict.sliders.records import Behaviour, not_followed
from toolkit.verdict.sliders.slips_in_time import first_of
from toolkit.verdict.sliders.told import hangs_on_heat
from toolkit.verdict.sliders.ways import loading_of
from toolkit.verdict.text.kinds import damped, long_delay_of

# how far a slip is shown before its begin and after it, in times that it lasts: a swing with a tenth of critical
# damping has fallen to a tenth by then
BEFORE, AFTER = 0.5, 8.0
# with less damping it is shown until its swings have fallen to this part, up to so many times of the slip
FALLEN, LONGEST = 0.1, 40.0
# points of the drive where it is shown for AFTER
POINTS = 400
# of a slip's way: a slider that goes on by less in the time of the slip has come to rest, or goes on with its drive
RESTS = 0.02
# of the force, in mean thresholds: no more is seen in a picture, nor more than the slip itself is known to
TOLERANCE = 1e-2
# times that the slip is looked for: with other points of the path it may begin a little earlier or later
TRIES = 3
# of a period, the way of the drive during a slip of a mass, up to which slips count as taking no time
SHORT_SLIP = 0.1
# s for a slider with mass and another delay than its own, which is no answer but what it hangs on
OF_DELAY = 20.0
# of the time, for whether sliding is stable in heat, and for the points of a slip
OF_A_SLIP = 0.5
# of the time, for contacts that form again at once: the master equation takes a second for them as a rule
AT_ONCE = 0.5


def follow_extremes(
    machine: Machine, reading: Reading, given: Behaviour, number: float | None, budget: Budget
) -> tuple[Behaviour, ...]:
    """What a slider with mass that is not decided does where its contacts form again at once, and where only after a
    slip, by a delay far above it; none where one of both is not decided either, where there is no delay or no
    damping, and of readings other than the scene's own. The master equation tells of the former, a few contacts of the
    latter, which are soon followed.

    given : what is known with its own delay; heat that was left out there is left out here; number : of contacts
    """
    import master

    heat, contacts = given.heat_left_out, reading.contacts
    if not (reading.own and contacts and contacts.waiting_time and machine.damping):
        return ()
    if contacts.thermal is not None and (heat is None or hangs_on_heat(given)):
        return ()
    cold = contacts.replace(thermal=None, delay=None)
    with suppress(InputError, TimeIsUp):
        steady = master.steady_state(cold, velocity=machine.velocity)
        known = master.propensity(cold, velocity=machine.velocity, tolerance=ROUGHLY)
        rigid = rigid_slider(cold, steady, known, number)
        at_once = follow(machine, cold, "mass", rigid, budget.part(AT_ONCE).remaining())
        late = long_delay(machine, cold.mean_threshold, rigid.static)
        waiting = with_barriers(cold).replace(delay=Delay(late))
        until, loading = (
            time.monotonic() + budget.remaining(),
            loading_of(machine, waiting, rigid.static),
        )
        after = follow_by_contacts(machine, waiting, "mass", loading, until, rigid)
        if "undecided" not in (at_once.kind, after.kind):
            return tuple(
                replace(one, error=one.error + (heat or 0.0), heat_left_out=heat, delay=delay)
                for one, delay in ((at_once, 0.0), (after, late))
            )
    return ()


def follow_other_delay(
    machine: Machine, contacts: Contacts, number: float | None, wall_time: float, delay: float = 0.0
) -> Behaviour:
    """What a slider with mass would do with the other extreme of the contacts' delay, without heat: without a delay of
    theirs those that form again only once a slip is over, else those that form again at once. Slip rules tell of both,
    as long as a slip of the mass takes little of the time until the next one; else, "undecided". Or with this `delay`.

    number : of contacts on the area; wall_time : s; delay : with which the mass is followed; 0: none, by a slip rule
    """
    import master

    other = contacts.replace(thermal=None, delay=Delay(delay) if delay else None)
    steady = master.steady_state(other, velocity=machine.velocity)
    found = master.propensity(other, velocity=machine.velocity, tolerance=ROUGHLY)
    rigid = rigid_slider(other, steady, found, number)
    if delay:
        return follow(machine, other, "mass", rigid, wall_time, rings=True)  # or for too long
    rule = "instant" if contacts.waiting_time else "reform-after"
    behaviour = follow(replace(machine, mass=None, damping=0.0), other, rule, rigid, wall_time)
    slip_distance = machine.velocity * slip_duration(machine, rigid.static)
    if behaviour.period is not None and slip_distance > SHORT_SLIP * behaviour.period:
        return not_followed(rule, "a slip of this mass takes as long as the time between slips")
    return behaviour


def with_a_slip(own: Answer, budget: Budget) -> Answer:
    """The own reading's answer with whether steady sliding in heat is stable, and with the points of a slip for the
    picture, where slips take time."""
    if own.machine is None:
        return own
    each, pulled = own.behaviours, (own.machine, own.contacts)

    def stability(part: Budget) -> tuple[Behaviour, ...]:
        return tuple(with_stability(one, *pulled) for one in each)

    def points(part: Budget) -> tuple[Behaviour, ...]:
        return tuple(closely(one, *pulled, part.remaining()) for one in each)

    for work in stability, points:
        each = budget.spend(OF_A_SLIP, work) or each
    return replace(own, behaviours=each)


def closely(found: Behaviour, machine: Machine, contacts: Contacts, seconds: float) -> Behaviour:
    """The behaviour with the dense trace of its first slip, which is solved again up to there alone; as it is where
    slips take no time, and where they are not found again within so many seconds."""
    begin, lasts = found.in_time.first_slip, found.in_time.slip_time
    if begin is None or lasts is None or seconds < found.run_time:
        return found
    if found.damping is not None:
        machine = replace(machine, damping=found.damping)
    start, distance = contacts.start.mean() / machine.spring, machine.velocity * lasts
    shown_after = swings_for(machine)
    points = round(POINTS * (BEFORE + 1.0 + shown_after) / (BEFORE + 1.0 + AFTER))
    with suppress(InputError):
        for _ in range(TRIES):
            places = begin + distance * np.linspace(-BEFORE, 1.0 + shown_after, points)
            places = places[places > start]
            path = np.concatenate([[start], places])
            solved = _solved(found, machine, contacts, path, seconds / TRIES)
            late = first_of(solved.slips)
            if late is None or solved.path.size < path.size:
                break
            if abs(late - begin) < 0.5 * BEFORE * distance:
                drive, force = with_slips(solved, machine.velocity)
                shown = drive >= places[0]
                return replace(found, slip_drive=drive[shown], slip_force=force[shown])
            begin = late
    return found


def swings_for(machine: Machine) -> float:
    """In how many times of a slip a swing of the free mass falls to FALLEN of itself: AFTER to LONGEST of them."""
    part = machine.damping / critical_damping(machine)
    if part >= 1.0:
        return AFTER
    falls = np.pi * part / np.sqrt(1.0 - part**2)
    return float(np.clip(-np.log(FALLEN) / falls if falls else np.inf, AFTER, LONGEST))


def rests_after(found: Behaviour, machine: Machine) -> float:
    """Seconds since the first slip began after which the slider rests, up to where its panel ends: it goes on by less
    than RESTS of the slip's way in a slip's time, and not before the time that the page tells of a slip; nan where it
    still moves there."""
    seconds, moved = in_its_own_time(found, machine)
    lasts = found.in_time.slip_time or np.inf
    # for each time how far it has gone on, or back, since as long before it
    steps = np.abs(moved - np.interp(seconds - lasts, seconds, moved))
    moving = np.flatnonzero(steps > RESTS * float(np.ptp(moved)))
    last = int(moving[-1]) if moving.size else 0
    if seconds[-1] - seconds[last] <= lasts:
        return float("nan")
    return max(float(seconds[last] - lasts), lasts)


def _solved(
    found: Behaviour, machine: Machine, contacts: Contacts, path: Array, seconds: float
) -> Any:
    """The slider along this path, by the solver that told of it; of the ensemble one alone."""
    asked = machine.keywords("mass")
    if found.contacts is None:
        import master

        tolerance = max(TOLERANCE, found.error)
        return master.solve(contacts, path, tolerance, wall_time=seconds, **asked)
    import eq_model

    # the ensemble told of contacts without their heat
    cold = with_barriers(contacts).replace(thermal=None)
    one = eq_model.simulate(cold, path, n_contacts=found.contacts, n_replicas=1, seed=SEED, **asked)
    return replace(one, force=one.forces[0])


def in_its_own_time(found: Behaviour, machine: Machine) -> tuple[Array, Array]:
    """Seconds since the slip began, and how far the slider has moved since (a length)."""
    drive, force = found.slip_drive, found.slip_force
    top = int(np.argmax(force))
    place = drive - force / machine.spring
    return (drive - drive[top]) / machine.velocity, place - place[top]


def with_other_delay(own: Answer, budget: Budget) -> Behaviour | None:
    """What the own reading's slider with mass would do with another delay, where it was seen to slip or slide."""
    if own.machine is None or [one.rule for one in own.behaviours] != ["mass"]:
        return None
    first = own.behaviours[0]
    # nor in heat in which nothing slips: other delays are tried without it
    if first.heat_on_the_way == 0.0 or (first.kind == "undecided" and not first.slips):
        return None
    asked = damped(own), own.contacts, own.scale.contacts
    with suppress(InputError, TimeIsUp):
        light = follow_other_delay(*asked, budget.remaining())
        waits, slides = own.contacts.waiting_time, own.behaviours[0].kind == "smooth"
        slips = light.kind not in ("smooth", "undecided")
        if slips or (waits and not (slides and waits < long_delay_of(own))):
            return light
        # fewer contacts hold a slider that slides than one that sticks, where they wait long, and slips of a heavy one
        # take as long as the time between them: no slip rule tells of either
        heavy = follow_other_delay(*asked, min(budget.remaining(), OF_DELAY), long_delay_of(own))
        return heavy if heavy.kind != "undecided" else light if waits else None
    return None
