"""The verdict of one scene: every reading and every slip rule, and what their answers have in common."""

import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np

from origins.contacts import Contacts
from origins.errors import InputError, refuse
from origins.samples.from_samples import sampled_parts
from origins.thresholds.law import Thresholds
from toolkit.processes.signals import TimeIsUp
from toolkit.results.html import as_table
from toolkit.running.resampled import of_resampled
from toolkit.running.solvers import within
from toolkit.scene.interfaces import of_smoothing
from toolkit.scene.scale import Scale, scale_of, with_uncertainty
from toolkit.scene.scene import Scene
from toolkit.scene.tables import DriveTable
from toolkit.verdict.budget import Budget
from toolkit.verdict.finite import Finite, follow_finite, with_more
from toolkit.verdict.follow import follow
from toolkit.verdict.machine import (
    NO_TIME,
    RULES,
    Behaviour,
    Known,
    Machine,
    machine_of,
    not_followed,
    rules_of,
)
from toolkit.verdict.readings import readings_of

# s for all readings and rules together; share of what is left for the scene's own, and then for its contacts' number
WALL_TIME, OWN = 60.0, 0.5
# of a reading's time for a slider with mass; where that does not do, slip rules have the rest
HEAVY = 0.8
# of K* and F_s of readings other than the scene's own
TOLERANCE = 1e-6
# resampled laws of samples, the fewest whose scatter tells something, and the tolerance for these
RESAMPLES, FEWEST, RESAMPLED_TOLERANCE = 10, 4, 1e-3
# times as long as K* and F_s to the latter tolerance take to the former, of laws that take long
LONGER = 12.0
# why nothing is told of a slider, and of a reading other than the scene's own
NO_FORCES = (
    "F_s and K* were not found in time, and without them no slider is followed: give more wall_time"
)


@dataclass(frozen=True)
class Quantity:
    """A number of one reading: `value`, its numerical error, and the scatter that other samples would give (None: not
    known, as of a single scan)."""

    value: float
    error: float
    sampling: float | None = None

    @property
    def unknown(self) -> bool:
        """Whether there was no time to find it."""
        return bool(np.isnan(self.value))


UNKNOWN = Quantity(float("nan"), float("inf"))


@dataclass(frozen=True)
class Answer:
    """What one reading says. Forces F/(N_c <k>) are lengths, springs are per N_c<k>.

    machine : what pulls; None where the scene has no spring
    behaviours : of the machine's slider, one for each rule
    """

    name: str
    contacts: Contacts
    scale: Scale
    kinetic: Quantity
    static: Quantity
    critical_spring: Quantity
    machine: Machine | None
    behaviours: tuple[Behaviour, ...]

    @property
    def smoothed(self) -> bool:
        """Whether K* is no number of the contacts: it hangs on how samples of islands are smoothed."""
        return of_smoothing(self.contacts.thresholds)


@dataclass(frozen=True)
class Verdict:
    """The answers of all readings, the scene's own first.

    velocity : of the drive; run_time : s
    finite : what as many contacts as there are do under each rule, by the own reading; empty where their number is
        not known
    left_out : readings without an answer, and why
    """

    name: str
    title: str
    velocity: float
    answers: tuple[Answer, ...]
    finite: tuple[Finite, ...]
    left_out: dict[str, str]
    run_time: float

    @property
    def own(self) -> Answer:
        """What the scene's own reading says."""
        return self.answers[0]

    @property
    def success(self) -> bool:
        """Whether all solves of the own reading met their tolerance."""
        found = all(behaviour.success for behaviour in self.own.behaviours)
        return found and not self.own.critical_spring.unknown

    def _repr_html_(self) -> str:
        """The own reading's numbers and what the slider does, as a table in a notebook; `words.page` says it all."""
        own, scale = self.own, self.own.scale
        numbers = {
            "kinetic friction F_k": (own.kinetic, scale.force, scale.force_unit),
            "static friction F_s": (own.static, scale.force, scale.force_unit),
            "critical spring K*": (own.critical_spring, scale.spring, scale.spring_unit),
        }
        rows = [
            (name, with_uncertainty(one.value * factor, (one.sampling or one.error) * factor, unit))
            for name, (one, factor, unit) in numbers.items()
        ]
        if own.smoothed:
            rows[-1] = ("critical spring K*", "not known: it hangs on the smoothing of P_c")
        rows += [(f"slip rule {one.rule}", one.kind) for one in own.behaviours]
        return as_table(self.title, rows)


def verdict(scene: Scene, progress: Callable[[str], None] = lambda what: None) -> Verdict:
    """Whether the scene's interface sticks and slips on its machine, for each reading and each slip rule.

    `progress` is called with a word on what begins. Raises InputError for a scene without an answer under its own
    reading, for a drive that turns or keeps times, and for unknown readings or rules.
    """
    began = time.monotonic()
    table = scene.drive_table or DriveTable()
    if table.turns is not None or table.times is not None:
        name = "turns" if table.turns is not None else "times"
        refuse(f"drive.{name}", getattr(table, name), "a verdict drives one way; leave it out")
    readings, rules = readings_of(scene), rules_of(scene, table)
    # what is given is of the clock, as of a queue; else a busy machine says what a quiet one does
    budget = Budget(scene.wall_time or WALL_TIME, strict=scene.wall_time is not None)
    scene, answers = replace(scene, wall_time=scene.wall_time or WALL_TIME), list[Answer]()
    left_out, finite = dict[str, str](), tuple[Finite, ...]()
    many, solved = sum(reading.contacts is not None for reading in readings), 0
    for number, reading in enumerate(readings):
        if reading.contacts is not None:
            solved += 1
            progress(f"reading {solved} of {many}: {reading.name}")
        # the scene's own is the answer; what it does not need is left to the number of contacts, and to the others
        alone = len(readings) == 1 and bool(scene.contacts.held_in_time)
        part = budget.part(OWN if reading.own and not alone else 1.0 / (len(readings) - number))
        deadline = time.monotonic() + budget.left()
        try:
            if reading.contacts is None:
                raise InputError(reading.refused)
            with within(deadline, scene, "this reading", budget.left):
                found = _answer(table, reading.name, reading.contacts, rules, part)
            if found.critical_spring.unknown and not reading.own:
                raise InputError(NO_FORCES)
            answers.append(found)
        except InputError as error:
            if reading.own:
                raise
            left_out[reading.name] = str(error)
        if reading.own:
            finite = _finite(scene, answers[0], budget.part(OWN), progress)
            unit = answers[0].contacts.mean_threshold
            pairs = zip(answers[0].behaviours, finite, strict=False)
            more = tuple(with_more(one, many, unit) for one, many in pairs)
            answers[0] = replace(answers[0], behaviours=more or answers[0].behaviours)
    return Verdict(
        name=scene.name,
        title=scene.title or scene.name,
        velocity=table.velocity,
        answers=tuple(answers),
        finite=finite,
        left_out=left_out,
        run_time=time.monotonic() - began,
    )


def _finite(
    scene: Scene, own: Answer, budget: Budget, progress: Callable[[str], None]
) -> tuple[Finite, ...]:
    """Sliders of as many contacts as the area holds, or as [eq] names, for each rule of the own reading, about within
    the budget."""
    number = own.scale.contacts
    if number is None and scene.eq is not None:
        number = float(scene.eq.contacts)
    if number is None or own.machine is None or own.static.unknown:
        return ()
    found = list[Finite]()
    for one in own.behaviours:
        progress(f"sliders of {number:,.0f} contacts, slip rule {one.rule}")
        static, left = own.static.value, budget.left()
        found.append(follow_finite(own.machine, own.contacts, number, one, static, left))
    return tuple(found)


def _answer(
    table: DriveTable, name: str, contacts: Contacts, rules: tuple[str, ...], budget: Budget
) -> Answer:
    """The answer of one reading, about within the budget."""
    import master

    velocity = table.velocity
    kinetic = static = critical = UNKNOWN
    scale = scale_of(contacts, table.area)
    machine, behaviours = machine_of(table, contacts), list[Behaviour]()
    asked = rules if machine is not None else ()
    with suppress(TimeIsUp):  # what is found by then is told
        steady = master.steady_state(contacts, velocity=velocity)
        kinetic = Quantity(steady.force, steady.force_error * contacts.mean_threshold)
        found = _propensity(contacts, velocity, budget)
        ratio, ratio_error = found.static_to_kinetic, found.static_to_kinetic_error
        static = Quantity(ratio * steady.force, ratio_error * steady.force + ratio * kinetic.error)
        critical = Quantity(found.critical_spring, found.critical_spring_error)
        known_before = Known(
            static.value,
            steady.force,
            kinetic.error,
            critical.value,
            found.decoherence_length,
            scale.contacts,
        )
        for left, rule in zip(range(len(asked), 0, -1), asked, strict=True):
            share = budget.left() / left * (HEAVY if machine and machine.mass else 1.0)
            behaviours.append(follow(cast(Machine, machine), contacts, rule, known_before, share))
        unknown = [one.rule for one in behaviours if one.kind == "undecided" and not one.slips]
        if machine is not None and unknown == ["mass"]:
            # no solver takes the slider with its mass, or not in time: what it does without one, under each slip rule
            light = replace(machine, mass=None, damping=0.0)
            for left, rule in zip(range(len(RULES), 0, -1), RULES, strict=True):
                share = budget.left() / left
                behaviours.append(follow(light, contacts, rule, known_before, share))
        if sampled_parts(contacts.thresholds):
            known = [kinetic, static, critical]
            kinetic, static, critical = _with_sampling(contacts, velocity, known, budget)
    why = NO_FORCES if critical.unknown else NO_TIME
    behaviours += [not_followed(rule, why) for rule in asked[len(behaviours) :]]
    return Answer(
        name,
        contacts,
        scale=scale,
        kinetic=kinetic,
        static=static,
        critical_spring=critical,
        machine=machine,
        behaviours=tuple(behaviours),
    )


def _propensity(contacts: Contacts, velocity: float, budget: Budget) -> Any:
    """K*, F_s and the decoherence length of these contacts, roughly first: laws with many peaks take a minute for more,
    which is spent only where it is there, and where K* is not infinite anyway."""
    import master

    rough = master.propensity(contacts, velocity=velocity, tolerance=RESAMPLED_TOLERANCE)
    late = LONGER * rough.run_time > budget.left()
    if late or not np.isfinite(rough.critical_spring):
        return rough
    return master.propensity(contacts, velocity=velocity, tolerance=TOLERANCE)


def _with_sampling(
    contacts: Contacts, velocity: float, known: list[Quantity], budget: Budget
) -> list[Quantity]:
    """Kinetic and static force and K* with the scatter between laws of resampled samples, one standard error; without
    it where there is no time for enough of them."""
    import master

    def row(law: Thresholds) -> list[float]:
        other = Contacts(law, start=contacts.start)
        kinetic = master.steady_state(other, velocity=velocity).force
        found = master.propensity(other, velocity=velocity, tolerance=RESAMPLED_TOLERANCE)
        return [kinetic, found.static_to_kinetic * kinetic, found.critical_spring]

    until = time.monotonic() + budget.left()
    rows = of_resampled(contacts.thresholds, RESAMPLES, row, until=until)
    if len(rows) < FEWEST:
        return known
    scatter = np.std(rows, axis=0, ddof=1)
    return [
        replace(quantity, sampling=float(each))
        for quantity, each in zip(known, scatter, strict=True)
    ]
