"""What runs of methods are held against: a closed form, else the master equation's finest run beside the ensemble."""

from typing import Any, NamedTuple

import numpy as np

from origins.contacts import check_contacts
from origins.errors import InputError
from origins.thresholds.law import Array
from toolkit.judge.closed_form import closed_form
from toolkit.judge.slips import Counts, alike, slips_so_far
from toolkit.results.beside import apart
from toolkit.scene.scale import written
from toolkit.scene.scene import Scene

# mean thresholds, below round-off: an error of 0 has no place on a logarithmic axis
LEAST = 1e-17


# share of the contacts: where fewer break on a path little happens but loading
HARDLY_ANY = 1e-3


class MethodAnswer(NamedTuple):
    """A method's force at the points of the path that it reaches, and the error that it claims, both in lengths; None
    where it claims none. `found` is the solver's own answer; `slips`, of the ensemble on a spring, are those so far at
    each point."""

    force: Array
    claimed: float | None
    found: Any = None
    slips: Counts | None = None


class TimedAnswer(NamedTuple):
    """A method's answer at a setting, and its median run time in s of so many `runs`."""

    setting: float
    answer: MethodAnswer
    run_time: float
    runs: int


class Reference(NamedTuple):
    """The force that the others are held against, its own error in mean thresholds (or another unit, `with_error_in`),
    what it is in words, and at which points of the path it is compared; on a spring with the `slips` so far at each."""

    force: Array
    error: float
    words: str
    counted: Any
    slips: Counts | None = None

    @property
    def soft(self) -> bool:
        """Whether it is the force of a slider on a spring."""
        return self.slips is not None


def exact_force(scene: Scene) -> Reference | None:
    """The closed form of the scene's force; None where there is none."""
    if scene.drive.spring is not None or not scene.drive.forward:
        return None
    try:
        check_contacts(scene.contacts, "the closed form")
        force, error = closed_form(scene.contacts, scene.path)
    except InputError:
        return None
    words = "the closed form for Gaussian thresholds"
    return Reference(force, error, words, np.ones(force.size, bool))


def best_of(solved: list[TimedAnswer]) -> TimedAnswer:
    """The run that claims the smallest error, of several the one with the tightest setting."""
    return min(reversed(solved), key=lambda run: run.answer.claimed or 0.0)


def finest(scene: Scene, solved: list[TimedAnswer], sampled: list[TimedAnswer]) -> Reference:
    """The run of the master equation that claims the smallest error, or else the ensemble's largest. On a spring the
    points of the path next to a slip tell nothing, as there a slip that comes a little early is an error as large as
    its drop."""
    if not solved:
        largest = sampled[-1].answer
        error = float(largest.claimed or 0.0) / scene.contacts.mean_threshold
        counted = np.ones(largest.force.size, bool)
        if largest.slips is not None:
            counted = alike(largest.slips, largest.slips)
        words = f"the ensemble at {sampled[-1].setting:.0e} contacts, its own largest run, good to its standard error"
        return Reference(largest.force, error, words, counted, largest.slips)
    best = best_of(solved)
    found, counted = best.answer.found, np.ones(best.answer.force.size, bool)
    words = f"the master equation at {best.setting:.0e} ({best.run_time:.2g} s)"
    if found.slips is not None:
        near, far = found.path[:-1, None], found.path[1:, None]
        slip = (np.minimum(near, far) <= found.slips.drive) & (
            found.slips.drive <= np.maximum(near, far)
        )
        counted[:-1] &= ~slip.any(axis=1)
        counted[1:] &= ~slip.any(axis=1)
        words += ", its own finest run, away from slips"
    slips = None if scene.drive.spring is None else slips_so_far(found, scene.drive)
    return Reference(best.answer.force, float(found.force_error), words, counted, slips)


def with_error_in(unit: float, reference: Reference, mean_threshold: float) -> Reference:
    """The reference with its error in another `unit` of forces (a length) than the mean threshold."""
    return reference._replace(error=max(reference.error, LEAST) * mean_threshold / unit)


def compared(answer: MethodAnswer, reference: Reference) -> Any:
    """At which points, of those that both reach, an answer can be compared with the reference."""
    both = min(answer.force.size, reference.force.size)
    counted = reference.counted[:both]
    if answer.slips is not None and reference.slips is not None:
        counted = counted & alike(answer.slips, reference.slips)[:both]
    return counted


def largest_error(answer: MethodAnswer, reference: Reference, unit: float) -> float | None:
    """The largest difference in a `unit` of forces (a length) where both are known, as the paper's closure of ageing
    may end before the path does; None for the reference's own bits, of which it tells nothing."""
    if np.array_equal(answer.force, reference.force):
        return None
    counted = compared(answer, reference)
    off = np.abs(answer.force[: counted.size] - reference.force[: counted.size])[counted]
    return float(off.max(initial=0.0)) / unit


def witness_of(
    sampled: TimedAnswer, solved: list[TimedAnswer], mean_threshold: float, unit: float
) -> dict[str, Any]:
    """The ensemble's largest run beside the master equation's finest: `contacts`, its largest `standard_error` in a
    `unit` of forces (a length), and the `worst_deviation` of both in standard errors, None where too few contacts broke
    to compare."""
    best, found = best_of(solved), sampled.answer.found
    error = float(found.force_standard_error.max()) / unit
    worst = apart(best.answer.found, found, mean_threshold).worst
    return {"contacts": found.contacts, "standard_error": error, "worst_deviation": worst}


def of_witness(
    witness: dict[str, Any] | None, solved: list[TimedAnswer], sampled: list[TimedAnswer], unit: str
) -> list[str]:
    """In words what an independent road says of a reference that is the finest run of one of the two solvers. On a
    spring there is no witness: contacts that are finitely many slip late by more than the scatter tells."""
    if not solved:
        return ["no independent road: the ensemble is held against its own largest run alone"]
    if witness is None and sampled:
        return [
            "independent of the master equation is the ensemble; on a spring its slips come late by what its number of "
            "contacts decides, and the two agree as far as its errors fall with it"
        ]
    if witness is None:
        return ["no independent road: master is held against its own finest run alone"]
    worst, contacts = witness["worst_deviation"], witness["contacts"]
    beside = "of which too few broke to compare, or all at once"
    if worst is not None:
        beside = (
            f"which differs from it by at most {worst:.1f} standard errors; chance makes about 3"
        )
    return [
        f"independent of the master equation is the ensemble of {contacts:,} contacts, {beside}; it tells no error "
        f"below its standard error, {witness['standard_error']:.1e} {unit}"
    ]


def unbroken(scene: Scene) -> list[str]:
    """That hardly any contact breaks on the scene's path, so that its errors tell of little but loading; none where
    more may: where they start stretched, or break by time."""
    contacts, spring = scene.contacts, scene.drive.spring
    way = float(np.ptp(np.append(0.0, scene.path)))
    if (
        spring is not None
    ):  # of which contacts that hold leave the slider this part, with a mass twice that as it swings
        way *= spring / (1.0 + spring) * (1.0 if scene.drive.mass is None else 2.0)
    stretched = contacts.start.span != (0.0, 0.0) or contacts.reforming is not None
    share = float(contacts.thresholds.cdf(way))
    if contacts.in_time or stretched or share > HARDLY_ANY:
        return []
    few = f"at most {share:.0e} of the contacts break" if share else "no contact breaks"
    mean = written(contacts.mean_threshold, scene.scale.length_unit)
    return [
        f"{few} on this path, which but loads them: drive on until the slider has gone by several <x_s>, {mean}"
    ]
