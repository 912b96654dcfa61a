"""What a verdict holds: the numbers of each reading, and what its slider does."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from origins.contacts import Contacts
from toolkit.results.html import as_table
from toolkit.scene.of_samples import of_smoothing
from toolkit.scene.scale import Scale, prefixed_like, told_contacts, with_uncertainty
from toolkit.verdict.sliders.machine import Machine
from toolkit.verdict.sliders.records import Behaviour, Finite


@dataclass(frozen=True)
class Quantity:
    """A number of one reading: `value`, its numerical error, and the scatter that other samples would give (None: not
    known, as of a single scan), with the resampled laws that it is of (0: none, a closed form)."""

    value: float
    error: float
    sampling: float | None = None
    resampled: int = 0

    @property
    def unknown(self) -> bool:
        """Whether there was no time to find it."""
        return bool(np.isnan(self.value))

    @property
    def lost(self) -> bool:
        """Whether its numerical error is as large as itself, so that it says nothing; 0 and infinity say something."""
        return bool(0.0 < abs(self.value) < np.inf and self.error >= abs(self.value))


UNKNOWN = Quantity(float("nan"), float("inf"))


def kinetic_of(steady: Any, contacts: Contacts) -> Quantity:
    """F_k of this steady state, with its error as a length."""
    return Quantity(steady.force, steady.force_error * contacts.mean_threshold)


@dataclass(frozen=True)
class Answer:
    """What one reading says. Forces F/(N_c <k>) are lengths, springs are per N_c<k>.

    machine : what pulls; None where the scene has no spring
    cold : F_k without heat; None where the contacts have none, or it was not asked for
    holding : share of the contacts that hold, and do not wait, on a rigid slider that slides as fast as the drive
    behaviours : of the machine's slider, one for each rule
    extremes : where one with mass is not decided, what it does if its contacts form again at once, and if only after a
        slip; empty where both are not known, or not asked for
    """

    name: str
    contacts: Contacts
    scale: Scale
    kinetic: Quantity
    static: Quantity
    critical_spring: Quantity
    machine: Machine | None
    behaviours: tuple[Behaviour, ...]
    holding: float = 1.0
    cold: Quantity | None = None
    extremes: tuple[Behaviour, ...] = ()

    @property
    def softer(self) -> bool:
        """Whether the machine's spring is softer than K*, where both are known."""
        critical = self.critical_spring
        return (
            self.machine is not None and self.machine.spring < critical.value and not critical.lost
        )

    @property
    def smoothed(self) -> bool:
        """Whether K* is no number of the contacts: it hangs on how samples of islands are smoothed."""
        return of_smoothing(self.contacts.thresholds)


@dataclass(frozen=True)
class Verdict:
    """The answers of all readings, the scene's own first.

    velocity : of the drive, 1 where it is not `velocity_given`; run_time : s
    finite : what as many contacts as there are do under each rule, by the own reading; empty where their number is
        not known
    left_out : readings without an answer, and why
    turned : what a slider with mass would do with the other extreme of the contacts' delay, see `follow_other_delay`;
        None where there is none, or no time
    left_path : "turns" or "times", the key of the scene's path that is left out; "" where none turns or keeps times
    stopped : the interrupt that ended the work, of which this is what was known by then; None as a rule
    """

    name: str
    title: str
    velocity: float
    answers: tuple[Answer, ...]
    finite: tuple[Finite, ...]
    left_out: dict[str, str]
    run_time: float
    turned: Behaviour | None = None
    velocity_given: bool = True
    left_path: str = ""
    stopped: BaseException | None = None

    @property
    def own(self) -> Answer:
        """What the scene's own reading says."""
        return self.answers[0]

    @property
    def success(self) -> bool:
        """Whether all solves of the own reading met their tolerance."""
        found = all(behaviour.success for behaviour in self.own.behaviours)
        critical = self.own.critical_spring
        return found and not (critical.unknown or critical.lost)

    def _repr_html_(self) -> str:
        """The own reading's numbers and what the slider does, as a table in a notebook; `words.page` says it all."""
        own, scale = self.own, self.own.scale
        numbers = {
            "kinetic friction F_k": (own.kinetic, scale.force, scale.force_unit),
            "static friction F_s": (own.static, scale.force, scale.force_unit),
            "critical spring K*": (own.critical_spring, scale.spring, scale.spring_unit),
        }
        rows = []
        for name, (one, factor, unit) in numbers.items():
            if one is own.critical_spring and (one.lost or own.smoothed):
                why = "" if one.lost else ": it hangs on the smoothing of P_c"
                rows.append((name, f"not known{why}"))
                continue
            rows.append((name, with_uncertainty(one.value * factor, one.error * factor, unit)))
            if one.sampling and not one.unknown:
                scatter = prefixed_like(one.sampling * factor, one.value * factor, unit)
                rows.append((f"{name}, by other samples", f"± {scatter}"))
        rows += [(f"slip rule {one.rule}", one.kind) for one in own.behaviours]
        followed = [one for one in self.finite if one.kind != "unknown"]
        rows += [
            (f"{told_contacts(one.contacts)}, slip rule {one.rule}", one.kind) for one in followed
        ]
        return as_table(self.title, rows)
