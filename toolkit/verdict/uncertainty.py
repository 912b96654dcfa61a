"""How well the numbers of a verdict are known: numerical errors, the scatter of other samples, the spread over the
readings."""

import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from origins.contacts import Contacts
from origins.samples.from_samples import sampled_parts
from origins.thresholds.law import Thresholds
from toolkit.running.resampled import (
    RESAMPLES,
    error_by_moments,
    kinetic_name,
    like,
    of_resampled,
    scatter_of,
)
from toolkit.scene.interfaces import of_a_scan
from toolkit.scene.of_samples import of_smoothing
from toolkit.scene.scale import FINER, guarded, with_scatter, written
from toolkit.verdict.answers import Answer, Quantity, Verdict
from toolkit.verdict.sliders.budget import Budget
from toolkit.verdict.sliders.late import shrinking
from toolkit.verdict.sliders.machine import critical_damping
from toolkit.verdict.sliders.records import Behaviour

# of a number: a larger error of it would be seen in the range over the readings, which has 3 digits
SEEN = 1e-3
# of a force, or of a period: a larger error of it is told beside it
TOLD_FROM = 1e-3
# of a number: a wider scatter of other samples, told with two digits, leaves it two
VAGUE = 0.1
# of the forces: a smaller uncertainty is no news beside them
WORTH_TELLING = 0.01
# of the widest uncertainty of a force: a smaller difference of two forces is nothing that is known
NO_NEWS = 0.01
# the fewest resampled laws of samples whose scatter tells something, and the tolerance for these
FEWEST, RESAMPLED_TOLERANCE = 4, 1e-3
# s for the scatter of F_k alone, which of islands of 4,000 angles takes 3
OF_FORCES = 10.0


class Uncertainties(NamedTuple):
    """Uncertainties of static and kinetic force, the larger of both, relative to it: the spread over the readings, the
    scatter of other samples, the numerical error."""

    readings: float
    sampling: float
    numerical: float


def uncertainties_of(verdict: Verdict) -> Uncertainties:
    """How well the forces of a rigid slider are known."""
    found = [Uncertainties(0.0, 0.0, 0.0)]
    for name in ("kinetic", "static"):
        each: list[Quantity] = [getattr(answer, name) for answer in verdict.answers]
        scaled = [
            one.value * answer.scale.force
            for one, answer in zip(each, verdict.answers, strict=True)
        ]
        own = each[0]
        if own.value > 0.0:
            spread = (max(scaled) - min(scaled)) / scaled[0]
            found.append(
                Uncertainties(spread, (own.sampling or 0.0) / own.value, own.error / own.value)
            )
    return Uncertainties(
        *(max(one for one in column if np.isfinite(one)) for column in zip(*found, strict=True))
    )


def widest_uncertainty(verdict: Verdict) -> float:
    """The widest uncertainty of static and kinetic force, relative: it decides to how many digits forces, and the
    periods that follow from them, are written."""
    return max(uncertainties_of(verdict))


def sliding_force_of(verdict: Verdict, answer: Answer, one: Behaviour) -> float:
    """The force of a smooth slider, F/(N_c <k>) (a length): F_k itself where it differs from that by no more than its
    error, or than a hundredth of what is known of F_k, so that both are written alike."""
    kinetic, error = answer.kinetic.value, one.error * answer.contacts.mean_threshold
    after = one.after - assumed_share(answer, one)
    known = max(
        error if np.isfinite(error) else 0.0, NO_NEWS * widest_uncertainty(verdict) * kinetic
    )
    return kinetic if abs(after - kinetic) <= known else after


def assumed_share(answer: Answer, one: Behaviour) -> float:
    """What of the spring's force a damping that is not given bears, γv, F/(N_c <k>) (a length), of infinitely many
    contacts that slide: it is none of the interface's force, nor of the machine's. 0 where it is given, and where the
    spring's force still swings, which is told."""
    slides = one.kind == "smooth" and one.swings is None and not one.instead
    if answer.machine is None or one.damping is None or not slides:
        return 0.0
    return one.damping * answer.machine.velocity


def numerical_errors(verdict: Verdict) -> list[str]:
    """How large the numerical errors of the own reading's numbers are at most, relative to these; and those of other
    readings, which stand in the ranges, where they are larger and would be seen."""
    own, mean = verdict.own, verdict.own.contacts.mean_threshold
    quantities = {"F_k": own.kinetic, "F_s": own.static}
    if not (own.smoothed or own.critical_spring.lost):
        quantities["K*"] = own.critical_spring
    known = {name: _relative(one) for name, one in quantities.items() if not one.unknown}
    said = ["neither force nor K* was found in time"]
    if known:
        *before, last = known
        names = " and ".join([*filter(None, [", ".join(before)]), last])
        said = [f"{names}: at most {max(known.values()):.0e}"]
    groups = dict[str, list[str]]()
    for one in own.behaviours:
        relative_error = one.error * mean / abs(one.before or np.nan)
        # what still swings is told, and no error; of a slider that is not decided there is no force
        seen = one.swings is None and (one.kind != "undecided" or one.slips)
        # where steady sliding tells of it its force is F_k
        if 0.0 < relative_error < np.inf and seen and one.heat_on_the_way is None:
            beyond = ", more than the force" if relative_error > 1.0 else ""
            each = f"at most {relative_error:.0e}{beyond}"
            if one.contacts is not None:  # that of the ensemble is no bound
                each = f"a standard error of {relative_error:.0e}, between sliders"
                each += ", with what heat that is left out may change" * bool(one.heat_left_out)
            groups.setdefault(each, []).append(one.rule)
    said += [f"forces of the slider ({', '.join(rules)}): {each}" for each, rules in groups.items()]
    said += _less_certain(verdict, max([*known.values(), SEEN]))
    return [
        "Numerical errors, relative to each number (all are in verdict.json)",
        *(f"  {one}" for one in said),
    ]


def _relative(quantity: Quantity) -> float:
    """The error of a number, relative to it; 0 for one that is 0 or infinite."""
    finite = quantity.value and np.isfinite(quantity.value)
    return quantity.error / abs(quantity.value) if finite else 0.0


def _less_certain(verdict: Verdict, most: float) -> Iterator[str]:
    """The numbers of other readings with a larger relative error than that, in words, and each K* that is not known."""
    lost = "not known, as it is as large as the number"
    if verdict.own.critical_spring.lost and not verdict.own.smoothed:
        yield f"K*: {lost}"
    for answer in verdict.answers[1:]:
        scale = answer.scale
        for name, one, factor, unit in (
            ("F_k", answer.kinetic, scale.force, scale.force_unit),
            ("F_s", answer.static, scale.force, scale.force_unit),
            ("K*", answer.critical_spring, scale.spring, scale.spring_unit),
        ):
            if one is answer.critical_spring and one.lost:
                yield f"K* of {answer.name}: {lost}"
            elif _relative(one) > most:
                text = with_scatter(one.value * factor, one.error * factor, unit)
                yield f"{name} of {answer.name}, which is in the range: {_relative(one):.0e}, {text}"


def unsure_of_springs(own: Answer) -> list[str]:
    """That other samples may turn the answer, where K* may be 0 by them, and above the machine's spring as well."""
    critical, machine = own.critical_spring, own.machine
    off = critical.sampling or 0.0
    if machine is None or critical.unknown or critical.lost or critical.value > off:
        return []
    if critical.value + off <= machine.spring:
        return []
    value, error = (one * own.scale.spring for one in (critical.value, off))
    said = with_scatter(value, error, own.scale.spring_unit, digits=2)
    return [
        f"K* = {said} by these samples: infinitely many contacts of other samples may slip on this spring"
    ]


def once_over(answer: Answer, slider: Behaviour) -> str:
    """How many slips came before smooth sliding, by how much each was smaller than the one before, and where what they
    leave at the path's end is more than the force, that; "" where they did not shrink one by one."""
    if not slider.shrinks_by:
        return ""
    seen = f" once slips have died out: {slider.slips} were seen{shrinking(slider)}"
    left = slider.error * answer.contacts.mean_threshold
    more = ", and the path ends while they swing by more than the force"
    return seen + more if left > slider.after and slider.swings is None else seen


def of_assumed_damping(answer: Answer, behaviour: Behaviour) -> str:
    """That a damping was taken where none is given, as the slider rings for too long without one."""
    if behaviour.damping is None or answer.machine is None:
        return ""
    part, scale = behaviour.damping / critical_damping(answer.machine), answer.scale
    taken = written(behaviour.damping * scale.spring, scale.damping_unit)
    return f", with an assumed damping of {taken} ({part:.0%} of critical; none is given)"


def with_sampling(
    contacts: Contacts, velocity: float, quantities: list[Quantity], budget: Budget
) -> list[Quantity]:
    """Kinetic and static force and K* with one standard error of other samples: of F_k in closed form where time does
    not matter to the contacts, else between laws of resampled samples; F_k alone where there is no time for enough of
    them, without it where that takes too long, too. Of islands F_k alone is asked, as F_s and K* hang on how samples of
    their barriers are smoothed."""
    import master

    def kinetic_of(law: Thresholds) -> float:
        return master.steady_state(like(contacts, law), velocity=velocity).force

    def row(law: Thresholds) -> list[float]:
        """F_k, F_s and K* of one law; nan where they are not found in time, as nobody else can stop a thread."""
        remaining = until - time.monotonic()
        if remaining <= 0.0:
            return [np.nan] * 3
        other, kinetic = like(contacts, law), kinetic_of(law)
        asked = {"velocity": velocity, "tolerance": RESAMPLED_TOLERANCE, "wall_time": remaining}
        found = master.propensity(other, **asked)
        return [kinetic, found.static_to_kinetic * kinetic, found.critical_spring]

    law, closed = contacts.thresholds, kinetic_name(contacts)
    until, rows = time.monotonic() + budget.remaining(), list[list[float]]()
    if not of_smoothing(law):
        rows = of_resampled(law, RESAMPLES, row, until=until)
        rows = [one for one in rows if not np.isnan(one).any()]
    if len(rows) < FEWEST and closed is None:  # F_k alone, which takes next to nothing beside K*
        until = time.monotonic() + OF_FORCES
        rows = of_resampled(law, RESAMPLES, lambda law: [kinetic_of(law)], until=until)
    found = list(quantities)
    if len(rows) >= FEWEST:
        for at, others in enumerate(zip(*rows, strict=True)):
            scatter = scatter_of(found[at].value, others)
            if np.isfinite(scatter):
                found[at] = replace(found[at], sampling=scatter, resampled=len(rows))
    if closed is not None:
        error = error_by_moments(law, closed, found[0].value)
        found[0] = replace(found[0], sampling=error, resampled=0)
    return found


def error_beside(verdict: Verdict, answer: Answer, one: Behaviour) -> float:
    """The error of a slider's force where it is told beside that, F/(N_c <k>) (a length): where it is a thousandth or
    more, and the widest uncertainty does not hide it; else 0."""
    error = one.error * answer.contacts.mean_threshold
    hidden = max(TOLD_FROM, widest_uncertainty(verdict)) * abs(one.before)
    return error if hidden < error < np.inf else 0.0


def is_vague(verdict: Verdict) -> bool:
    """Whether forces have two digits alone: where the scatter of other samples, which is told with two, is VAGUE and
    the widest uncertainty, as it is that of each number. Readings differ from one another by more than each is known.
    """
    each = uncertainties_of(verdict)
    return max(each.readings, each.numerical, VAGUE) < each.sampling


def to_digits(
    value: float, unit: str, uncertainty: float, error: float, vague: bool = False
) -> str:
    """A value to the digit of an error that stands beside it or beside what it follows from; where none is (0), to
    one digit more than its uncertainty leaves, two of what is `vague`."""
    if error:
        # 105 ± 11 is not 110
        finer = _leading(value) < 2.0 and _leading(error) < FINER
        return written(value, unit, error / 10.0 if finer else error, digits=4)
    return guarded(value, unit, uncertainty, vague)


def _leading(value: float) -> float:
    """The number from 1 to 10 that a value has before its power of ten; 0 of 0."""
    return float(abs(value) / 10.0 ** np.floor(np.log10(abs(value)))) if value else 0.0


def spring_to_digits(value: float, unit: str, uncertainty: float) -> str:
    """K* to the digits that its uncertainty leaves, two at least: readings may differ by orders of magnitude."""
    return written(value, unit, uncertainty, digits=4 if 0.0 < uncertainty < np.inf else 3)


def writer_of_springs(answer: Answer) -> Callable[[float, str, float], str]:
    """How K* is written: to two digits of a scan, of which another patch or step may change it by orders of magnitude,
    as the page says, and of samples whose scatter was not found; else as `spring_to_digits`."""
    law = answer.contacts.thresholds
    unsure = bool(sampled_parts(law)) and answer.critical_spring.sampling is None
    if not (of_a_scan(law) or unsure):
        return spring_to_digits
    return two_digits


def two_digits(value: float, unit: str, uncertainty: float = 0.0) -> str:
    """As `guarded`, of a number whose uncertainty nobody knows."""
    return written(value, unit, digits=2)
