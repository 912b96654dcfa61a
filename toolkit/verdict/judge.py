"""The verdict of one scene: every reading and every slip rule, and what their answers have in common."""

import time
import tomllib
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import Any, cast

import numpy as np
from msgspec import structs

from origins.contacts import Contacts
from origins.errors import InputError
from origins.samples.from_samples import sampled_parts
from toolkit.processes.signals import TimeIsUp, no_longer_than
from toolkit.running.solvers import within
from toolkit.scene.drive import sliding_speed
from toolkit.scene.scale import SHARED, scale_of, told_contacts
from toolkit.scene.scene import Scene
from toolkit.scene.tables import DriveTable
from toolkit.verdict.answers import UNKNOWN, Answer, Quantity, Verdict, kinetic_of
from toolkit.verdict.of_area import tells_instead, with_finite
from toolkit.verdict.readings import Reading, acting, readings_of, rules_of
from toolkit.verdict.sliders.budget import (
    INTERRUPTED,
    NO_FORCES,
    NO_TIME,
    SHORT,
    WALL_TIME,
    Budget,
    Stops,
    lacks_damping,
    part_of_sliders,
)
from toolkit.verdict.sliders.finite import follow_finite, told_by_another_rule
from toolkit.verdict.sliders.follow import TOLERANCE_IN_TIME, WHETHER_IT_SLIPS
from toolkit.verdict.sliders.islands import follow_contacts, with_barriers
from toolkit.verdict.sliders.machine import RULES, Machine, machine_of, rigid_slider
from toolkit.verdict.sliders.records import Behaviour, Finite, ends_before_a_slip, not_followed
from toolkit.verdict.sliders.steady import is_stable_with_delay
from toolkit.verdict.uncertainty import RESAMPLED_TOLERANCE, with_sampling
from toolkit.verdict.with_mass import (
    follow_extremes,
    follow_other_delay,
    with_a_slip,
    with_other_delay,
)

# part of the time that is left, for the scene's own reading
OWN = 0.5
# part of that reading's time, for its slider with mass and the other delay, which takes a moment as a rule
OF_OTHER_DELAY = 0.5
# part of a reading's time for a slider with mass; where that does not do, slip rules have the rest
HEAVY = 0.8
# tolerance of K* and F_s of readings other than the scene's own
TOLERANCE = 1e-6
# relative error of both that is not seen on the page, and not lowered with more work; of other readings, of which the
# page has the largest and the smallest
SOLVED_TO, OF_RANGE = 1e-5, 1e-3
# times as long as K* and F_s to the latter tolerance take to the former, of laws that take long; and part of the time
# that is left, for them: contacts that grow and break by heat take a hundred times as long
LONGER, OF_MORE = 12.0, 0.25


def verdict(
    scene: Scene, progress: Callable[[str], None] = lambda what: None, keep: bool = False
) -> Verdict:
    """Whether the scene's interface sticks and slips on its machine, for each reading and each slip rule.

    The drive goes one way, at the speed of the scene's first leg. `progress` is called with a word on what begins.
    `keep`: an interrupt ends the work; once F_k is known it is not raised, and the verdict holds it as `stopped`.
    Raises InputError for a scene without an answer under its own reading, and for unknown readings or rules.
    """
    began = time.monotonic()
    table = scene.drive_table or DriveTable()
    left_path = "turns" if table.turns is not None else "times" if table.times is not None else ""
    if left_path:
        speed = sliding_speed(scene.drive, table)
        table = structs.replace(table, velocity=speed, turns=None, times=None)
    readings, rules = readings_of(scene), rules_of(scene, table)
    # what is given is of the clock, as of a queue; else a busy machine says what a quiet one does
    budget = Budget(
        scene.wall_time or WALL_TIME, strict=scene.wall_time is not None, stops=Stops(keep)
    )
    answers, turned = list[Answer](), None
    left_out, finite = dict[str, str](), tuple[Finite, ...]()
    many, solved = sum(reading.contacts is not None for reading in readings), 0
    for number, reading in enumerate(readings):
        if reading.contacts is not None:
            solved += 1
            progress(f"reading {solved} of {many}: {reading.name}")
        part = budget.part(_share_of(number, readings, scene, table))
        deadline = time.monotonic() + budget.remaining()
        try:
            if reading.contacts is None:
                raise InputError(reading.refused)
            if budget.stops.by:
                raise InputError(INTERRUPTED)
            with within(deadline, scene, "this reading", budget.remaining):
                # what the own reading's slider does without damping, those of the others do
                rings = any(one.damping is not None for each in answers for one in each.behaviours)
                found = answer_of(table, reading, rules, part, rings)
            if budget.stops.by and found.kinetic.unknown and reading.own:
                raise budget.stops.by
            if found.critical_spring.unknown and not reading.own:
                raise InputError(INTERRUPTED if budget.stops.by else NO_FORCES)
            answers.append(found)
        except InputError as error:
            if reading.own:
                raise
            left_out[reading.name] = str(error)
        if reading.own:
            # first what takes a moment: sliders of all contacts may take all of the time
            turned = budget.spend(OF_OTHER_DELAY, partial(with_other_delay, answers[0]))
            share = part_of_sliders(scene.contacts, many > 1)
            finite = finite_sliders(scene, answers[0], budget, budget.part(share), progress)
            answers[0] = with_finite(answers[0], finite)
            if turned is None and answers[0].behaviours[:1] and answers[0].behaviours[0].instead:
                turned = budget.spend(OF_OTHER_DELAY, partial(with_other_delay, answers[0]))
            answers[0] = with_a_slip(answers[0], budget)
    if scene.units == SHARED:  # that of its own reading for all, so that they can be compared
        own = answers[0].scale
        answers = [replace(one, scale=one.scale.over(own)) for one in answers]
    return Verdict(
        name=scene.name,
        title=scene.title or scene.name,
        velocity=table.velocity,
        velocity_given=bool({"velocity", "times"} & {*tomllib.loads(scene.text).get("drive", {})}),
        left_path=left_path,
        answers=tuple(answers),
        finite=finite,
        left_out=left_out,
        turned=turned,
        run_time=time.monotonic() - began,
        stopped=budget.stops.by,
    )


def _share_of(number: int, readings: Sequence[Reading], scene: Scene, table: DriveTable) -> float:
    """The part of the time that is left which a reading gets: the scene's own, which is the answer, OWN, and what it
    leaves is for the others and the area's contacts; the others in order twice their share, as most leave a part of it
    to those after them. The own one gets all where it is the only one and a law depends on time, or contacts wait and
    the scene gives a wall_time, or steady sliding is stable: slips may end after hundreds of delays, along which all
    contacts are followed, if in time."""
    contacts, machine = scene.contacts, machine_of(table, scene.contacts)
    slides = machine is not None and is_stable_with_delay(machine, contacts)
    waits = bool(contacts.waiting_time) and (scene.wall_time is not None or slides)
    alone = len(readings) == 1 and (bool(contacts.held_in_time) or waits)
    return OWN if readings[number].own and not alone else 2.0 / (len(readings) - number + 1)


def finite_sliders(
    scene: Scene, own: Answer, every: Budget, part: Budget, progress: Callable[[str], None]
) -> tuple[Finite, ...]:
    """Sliders of as many contacts as the area holds, or as [eq] names, for each rule of the own reading, about within
    this `part` of the time, and no longer than in all of it, `every`, or SHORT."""
    number = own.scale.contacts
    if number is None and scene.eq is not None:
        number = float(scene.eq.contacts)
    if number is None or own.machine is None or own.static.unknown:
        return ()
    found, contacts = list[Finite](), with_barriers(own.contacts)
    # of a slider with mass that was not decided the last behaviour is that of contacts without their delay
    at_once = "instant" if contacts.waiting_time else ""
    each = [one for one in own.behaviours if one.rule != at_once and not lacks_damping(one.message)]
    limit = max(every.remaining(), SHORT)
    with every.stops.or_late(), no_longer_than(limit, remaining_time=every.remaining):
        for one in () if every.stops.by else each:
            if one.finite is not None and one.finite.contacts == max(round(number), 1):
                found.append(one.finite)  # all of them were followed in place of infinitely many
                continue
            same = told_by_another_rule(one, zip(each, found, strict=False), contacts)
            if same is None:
                progress(f"sliders of {told_contacts(number)} ({one.rule})")
                static, remaining = own.static.value, part.remaining()
                same = follow_finite(own.machine, contacts, number, one, static, remaining)
            found.append(same)
            if one.rule == "mass" and tells_instead(one, found[-1]):
                return tuple(found)  # which decides: slip rules without the mass do not
    late = [one.rule for one in each[len(found) :]]
    why = INTERRUPTED if every.stops.by else NO_TIME
    return (*found, *(Finite(rule, max(round(number), 1), "unknown", message=why) for rule in late))


def answer_of(
    table: DriveTable, reading: Reading, rules: tuple[str, ...], budget: Budget, rings: bool
) -> Answer:
    """The answer of one reading with contacts, about within the budget; `rings`: see `follow`. Of the sliders of
    readings other than the scene's own nothing is told but whether they slip."""
    import master

    velocity, contacts = table.velocity, cast(Contacts, reading.contacts)
    tolerance = TOLERANCE_IN_TIME if reading.own else WHETHER_IT_SLIPS
    kinetic = static = critical = UNKNOWN
    holding, cold, extremes = 1.0, None, tuple[Behaviour, ...]()
    scale = scale_of(contacts, table.area)
    machine, behaviours = machine_of(table, contacts), list[Behaviour]()
    asked = rules if machine is not None else ()
    with budget.stops.or_late():  # what is found by then is told
        steady = master.steady_state(contacts, velocity=velocity)
        kinetic, holding = kinetic_of(steady, contacts), steady.holding
        if contacts.thermal is not None and reading.own:
            without = contacts.replace(thermal=None)
            cold = kinetic_of(master.steady_state(without, velocity=velocity), without)
        found = propensity_of(contacts, velocity, budget, SOLVED_TO if reading.own else OF_RANGE)
        ratio, ratio_error = found.static_to_kinetic, found.static_to_kinetic_error
        static = Quantity(ratio * steady.force, ratio_error * steady.force + ratio * kinetic.error)
        critical = Quantity(found.critical_spring, found.critical_spring_error)
        before = rigid_slider(contacts, steady, found, scale.contacts)
        for n_rules, rule in zip(range(len(asked), 0, -1), asked, strict=True):
            # the first one may tell that no rule acts, see _without_slip
            parts = min(n_rules, 2) if contacts.in_time else n_rules
            seconds = budget.remaining() / parts * (HEAVY if machine and machine.mass else 1.0)
            pulled = cast(Machine, machine)
            same = _without_slip(behaviours, contacts, rule)
            behaviours.append(
                same or follow_contacts(pulled, contacts, rule, before, seconds, rings, tolerance)
            )
        unknown = [one.rule for one in behaviours if one.kind == "undecided" and not one.slips]
        if machine is not None and unknown == ["mass"] and not lacks_damping(behaviours[0].message):
            # no solver takes the slider with its mass, or not in time: its delay's extremes, else each slip rule, tell
            extremes = follow_extremes(machine, reading, behaviours[0], scale.contacts, budget)
            light = replace(machine, mass=None, damping=0.0)
            rules = () if extremes else acting(RULES, contacts)
            short = not extremes and contacts.delay is not None and contacts.thermal is None
            for n_rules, rule in zip(range(len(rules), 0, -1), rules, strict=True):
                seconds = budget.remaining() / (n_rules + short)
                behaviours.append(follow_contacts(light, contacts, rule, before, seconds))
            if short:  # and, as the delay may be far shorter than a slip, what it does without one
                remaining = budget.remaining()
                behaviours.append(follow_other_delay(machine, contacts, scale.contacts, remaining))
        if sampled_parts(contacts.thresholds):
            quantities = [kinetic, static, critical]
            kinetic, static, critical = with_sampling(contacts, velocity, quantities, budget)
    why = INTERRUPTED if budget.stops.by else NO_FORCES if critical.unknown else NO_TIME
    behaviours += [not_followed(rule, why) for rule in asked[len(behaviours) :]]
    return Answer(
        reading.name,
        contacts,
        scale=scale,
        kinetic=kinetic,
        static=static,
        critical_spring=critical,
        machine=machine,
        behaviours=tuple(behaviours),
        holding=holding,
        cold=cold,
        extremes=extremes,
    )


def _without_slip(behaviours: list[Behaviour], contacts: Contacts, rule: str) -> Behaviour | None:
    """What a slider does under this rule where it is known to slide without a slip, or without one as far as it can be
    followed, as no rule acts then. That is told by "reset" alone, by which F falls to 0 in the smallest slip. None
    where it is not known, or soon found."""
    if not behaviours or behaviours[0].rule != "reset" or not contacts.in_time:
        return None
    first = behaviours[0]
    sure = first.kind == "smooth" and first.success and not first.slips and first.contacts is None
    sure |= ends_before_a_slip(first)
    return replace(first, rule=rule, run_time=0.0) if sure else None


def propensity_of(contacts: Contacts, velocity: float, budget: Budget, enough: float) -> Any:
    """K*, F_s and the decoherence length of these contacts, roughly first: laws with many peaks take a minute for more,
    which is spent only where it is there, and where K* is not infinite anyway. `enough`: their relative errors."""
    import master

    rough = master.propensity(contacts, velocity=velocity, tolerance=RESAMPLED_TOLERANCE)
    seconds = OF_MORE * budget.remaining()
    late = LONGER * rough.run_time > seconds
    spring, off = rough.critical_spring, rough.critical_spring_error
    precise = off <= enough * spring and rough.static_to_kinetic_error <= enough
    if late or precise or not np.isfinite(spring):
        return rough
    with suppress(TimeIsUp), no_longer_than(seconds):
        return master.propensity(contacts, velocity=velocity, tolerance=TOLERANCE)
    return rough
