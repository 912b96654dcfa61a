"""What of a verdict was not answered, or not as well as asked."""

import re
from collections.abc import Iterator

import numpy as np

from toolkit.results.slips import ENOUGH
from toolkit.scene.scale import written
from toolkit.verdict.answers import Answer, Verdict
from toolkit.verdict.readings import why_late
from toolkit.verdict.sliders.budget import MORE_TIME, NO_FORCES
from toolkit.verdict.sliders.follow import TOLERANCE_IN_TIME
from toolkit.verdict.sliders.records import Behaviour, ends_before_a_slip
from toolkit.verdict.text.kinds import (
    GENERAL,
    NOTHING,
    TURNS,
    Line,
    by_reason,
    damped,
    named,
    not_decided,
    of_damping,
    others,
    out_of_time,
)
from toolkit.verdict.text.of_heat import of_heat, of_steady_sliding, of_unstable_sliding
from toolkit.verdict.text.of_mass import of_a_swing
from toolkit.verdict.text.spread import range_of_force
from toolkit.verdict.text.table import in_units
from toolkit.verdict.uncertainty import uncertainties_of

# relative error of a factor above which it has one digit
ONE_DIGIT = 0.1
# stands for the slip rules under which a sentence holds
RULE = "<rule>"


def unanswered(verdict: Verdict) -> Iterator[Line]:
    """What of the own reading was too late, and readings without an answer."""
    if verdict.own.critical_spring.unknown:
        why = why_late(verdict.own.contacts)
        if said := "; ".join([*([] if verdict.own.machine else [NO_FORCES]), *why]):
            yield Line(TURNS, said)
    for reason, names in by_reason(_left_out(verdict)).items():
        if len(names) == 1:
            reason = reason.replace("they need", "it needs")
        yield Line(GENERAL, f"left out: {', '.join(names)}: {reason}")


def of_readings(verdict: Verdict) -> Iterator[Line]:
    """By how much the readings differ, and which of them say something else."""
    answers, many = verdict.answers, len(verdict.answers)
    if many < 2:
        return
    differ = others(verdict)
    size = TURNS if differ else uncertainties_of(verdict).readings
    known = [
        one for one in answers if not (one.critical_spring.unknown or one.critical_spring.lost)
    ]
    if len(known) > 1:
        said = f"K* {_range_of_springs(known)} over {len(known)} readings, and {range_of_force(verdict)}"
        yield Line(size, f"threshold law, contact model and resolution: {said}", of_readings=True)
    for kind, names in differ.items():
        yield Line(size, f"of these, {kind}: {', '.join(names)}")
    missing = not_decided(verdict)
    for why, names in by_reason((_why(one), one.name) for one in missing).items():
        yield Line(size, f"not decided: {', '.join(names)}: {why}")
    absent = {one.name for one in missing}
    decided = [one for one in answers[1:] if {each.kind for each in one.behaviours} - {"undecided"}]
    decided = [one for one in decided if one.name not in absent]
    decided_rules = {one.rule for one in verdict.own.behaviours if one.kind != "undecided"}
    partly = [
        answer.name
        for answer in decided
        if any(one.kind == "undecided" for one in answer.behaviours if one.rule in decided_rules)
    ]
    if partly:
        said = "decided under some slip rules, and not under others"
        yield Line(size, f"{said}: {', '.join(partly)}")
    if verdict.own.machine is not None and decided and not differ:
        all_say = f"the {len(decided)} others that were followed say"
        all_say = "the other one says" if len(decided) == 1 else all_say
        said = f"{all_say} what {verdict.own.name} says"
        yield Line(NOTHING, f"not the reading: {said}")


def _range_of_springs(answers: list[Answer]) -> str:
    """By which factor K* differs between readings, to the digits that the errors of its ends leave, two at most, as
    other readings would give another one; the ends where one is 0, or infinite."""
    low, *_, high = sorted(answers, key=lambda one: one.critical_spring.value * one.scale.spring)
    small, large = low.critical_spring, high.critical_spring
    if not small.value > 0.0 or not np.isfinite(large.value):
        each = ((one.critical_spring.value * one.scale.spring, one.scale) for one in (low, high))
        ends = (written(value, scale.spring_unit, digits=2) for value, scale in each)
        return f"is {' to '.join(dict.fromkeys(ends))}"
    factor = large.value * high.scale.spring / (small.value * low.scale.spring)
    off = np.hypot(small.error / small.value, large.error / large.value)
    told = float(f"{factor:.{0 if off > ONE_DIGIT else 1}e}")
    return f"differs by a factor of some {told:,.6g}" if told > 1.0 else "is nearly the same"


def _why(answer: Answer) -> str:
    """Why a reading is not decided."""
    if out_of_time(answer):
        return f"out of time: {MORE_TIME}, or give fewer verdict.readings"
    return _whole_cause(answer)


def cause(answer: Answer) -> str:
    """Why the slider is not decided under the first rule, without what to do about it, which stands below."""
    return re.split(r"; (?![^(]*\))", _whole_cause(answer))[0]


def _whole_cause(answer: Answer) -> str:
    """What the solver says of the slider under the first rule."""
    one = answer.behaviours[0]
    said = in_units(one.message, answer.scale, answer.contacts.mean_threshold)
    return said + of_a_swing(answer, one)


def against_k_star(verdict: Verdict) -> list[str]:
    """What K* says beside the machine's spring of a slider that is not decided, in a sentence that stands below the
    table; none where K* is not known."""
    own = verdict.own
    unknown = [one.rule for one in own.behaviours if one.kind == "undecided" and not one.slips]
    critical = own.critical_spring
    if own.machine is None or not unknown or own.smoothed or critical.unknown or critical.lost:
        return []
    each = own.machine.spring, critical.value
    spring, most = (
        written(one * own.scale.spring, own.scale.spring_unit, digits=2) for one in each
    )
    rules = f" if {named(unknown)}" * (unknown != ["mass"])
    if not own.softer:
        return [
            f"K, {spring}, is above K*, {most}: a rigid slider's force falls nowhere as steeply; what the slider does"
            f"{rules} is not known"
        ]
    slips = "it slips at least once"
    if own.contacts.in_time or own.machine.mass:
        slips = "it slips, or creeps up to the speed of its drive and slides"
    return [f"K, {spring}, is below K*, {most}: {slips}; what follows{rules} is not known"]


def undecided_readings(verdict: Verdict) -> list[str]:
    """How many readings are not decided beside an own one that is, and their F_k, of which K* and F_k are known all the
    same; as the answer is that of the others alone."""
    missing, own = not_decided(verdict), verdict.own
    if not missing:
        return []
    many, decided = len(verdict.answers), len(verdict.answers) - len(missing)
    whose = own.name if decided == 1 else f"{decided} of {many} readings"
    late = " in time" * all(out_of_time(one) for one in missing)
    one = "the other one is" if len(missing) == 1 else f"the other {len(missing)} are"
    return [
        f"so say {whose}; {one} not decided{late}; {range_of_force(verdict, f' of all {many}')}"
    ]


def followed_instead(own: Answer, one: Behaviour) -> str:
    """That sliders of all contacts tell a behaviour, and why the master equation does not; "" where it does."""
    if not one.instead:
        return ""
    why = "takes no such slider" if one.refused else "does not decide"
    why = "ran out of time" if "wall_time" in one.instead else why
    borne = of_damping(own, one, True) if one.kind == "smooth" else ""
    return f"{borne}, followed contact by contact: the master equation {why}"


def of_errors(verdict: Verdict) -> Iterator[Line]:
    """Where the slider's force is less well known than asked for, and why."""
    own = verdict.own
    scale, errors = own.scale, {one.rule: _relative_error(verdict, one) for one in own.behaviours}
    by_contacts = [one for one in own.behaviours if one.contacts is not None]
    for who, rules in by_reason((one.message, one.rule) for one in by_contacts).items():
        if all(one.kind == "smooth" for one in by_contacts if one.rule in rules):
            said = f"the force is told {who}"
        else:
            said = f"the slips are means {who}"
        unit = own.contacts.mean_threshold * scale.force
        alike_to = by_reason(
            (written(one.error * unit, scale.force_unit, digits=2), one.rule)
            for one in by_contacts
            if one.rule in rules
        )
        apart = len(own.behaviours) > len(rules) or len(alike_to) > 1
        of_rules = ((error, f" if {named(alike)}" * apart) for error, alike in alike_to.items())
        slips = [one.finite.slips for one in by_contacts if one.rule in rules and one.finite]
        if slips and 0.0 < min(slips) < ENOUGH:
            often = "once" if min(slips) == 1.0 else f"some {min(slips):.2g} times"
            said += f", each of which slipped {often} (few: their scatter is in the errors)"
        more = ", with what more contacts would change" * any(
            _fewer_than_there_are(verdict, one) for one in by_contacts if one.rule in rules
        )
        errors_of = " and ".join(f"some {error}{which}" for error, which in of_rules)
        said += f", their forces known to {errors_of} (one standard error{more})"
        yield Line(max(errors[rule] for rule in rules), said, f": {_not_solved(verdict)}")
    mean, missing = own.contacts.mean_threshold, [one for one in own.behaviours if not one.success]
    missed = [(in_units(one.message, scale, mean), one.rule) for one in missing]
    for why, rules in by_reason(missed).items():
        most = max(errors[rule] for rule in rules)
        nothing = all(
            one.kind == "undecided" and not one.slips for one in missing if one.rule in rules
        )
        what = "not decided" if nothing else "not as asked"
        yield Line(
            most, f"{with_rules(f'{what} if {RULE}', rules, own)}: {why}{_instead(own, rules)}"
        )
    yield from of_steady_sliding(verdict)
    yield from of_unstable_sliding(verdict)
    yield from of_heat(verdict)
    rough = [
        (_why_rough(verdict, one), one.rule)
        for one in own.behaviours
        if one.success and one.error > TOLERANCE_IN_TIME and one.kind != "undecided"
        if one.contacts is None and one.heat_left_out is None
    ]
    for why, rules in by_reason(rough).items():
        most = max(errors[rule] for rule in rules)
        known = with_rules(f"the force is known less well than others if {RULE}", rules, own)
        yield Line(most, f"{known}: {why}")


def with_rules(said: str, rules: list[str], own: Answer) -> str:
    """A sentence with its slip rules in words where RULE stands; without, where mass alone decides."""
    if [one.rule for one in own.behaviours] == ["mass"]:
        return said.replace(f", if {RULE}", "").replace(f" if {RULE}", "")
    return said.replace(RULE, named(rules))


def _why_rough(verdict: Verdict, one: Behaviour) -> str:
    """Why the force of a decided slider is known less well; where the solver met its tolerance its message tells why
    the slider slips or slides, and not that."""
    scale = verdict.own.scale
    if "error estimate" in one.message:
        return in_units(one.message, scale, verdict.own.contacts.mean_threshold)
    error = one.error * verdict.own.contacts.mean_threshold * scale.force
    differs = (
        "still changes where the path ends" if one.kind == "smooth" else "differs between slips"
    )
    said = f"its error, {written(error, scale.force_unit, digits=2)}, is that of steps, or what {differs}"
    if one.kind != "smooth" or one.rule != "mass":
        return said
    # known as F_k is, whatever still changes, and never below the damping's share
    machine, unit = damped(verdict.own), scale.force_unit
    borne = machine.damping * machine.velocity
    steady = written((verdict.own.kinetic.value + borne) * scale.force, unit)
    return f"{said}: sliding that swings no more bears {steady}, F_k and the damping's share"


def _instead(own: Answer, rules: list[str]) -> str:
    """What is known of a slider that cannot be followed to a slip or to sliding, and what to do instead."""
    if not any(ends_before_a_slip(one) for one in own.behaviours if one.rule in rules):
        return ""
    laws = [f"[contacts.{name}]" for name in own.contacts.held_in_time]
    ask = f"leave out {' or '.join(laws)}, or " * (len(laws) > 1)
    enough = "give a drive.spring on which it slips, or slides steadily, by then"
    return f". F_k, F_s and K* of the table hold all the same; {ask}{enough}"


def _not_solved(verdict: Verdict) -> str:
    """Why the ensemble tells of slips in place of the master equation."""
    if verdict.own.smoothed:
        return (
            "thresholds are the islands' barriers themselves, whose smooth law would slip elsewhere; a slip breaks a "
            "fifth of the contacts or more, and smaller falls of the force may come earlier"
        )
    return "the master equation takes no such slider, or not in time"


def _fewer_than_there_are(verdict: Verdict, one: Behaviour) -> bool:
    """Whether the contacts that tell are not all of the area; where their number is not known they are taken as few."""
    number = verdict.own.scale.contacts
    if one.instead:
        return False
    return number is None or (one.contacts or 0) < round(number)


def _relative_error(verdict: Verdict, one: Behaviour) -> float:
    """The error of a behaviour's force, relative to it; TURNS where the force is not known."""
    error = one.error * verdict.own.contacts.mean_threshold
    return float(error / abs(one.before)) if np.isfinite(error) and one.before else TURNS


def _left_out(verdict: Verdict) -> list[tuple[str, str]]:
    """Why readings have no answer, and their names; for want of a constant at all resolutions alike."""
    reasons = list[tuple[str, str]]()
    for name, why in verdict.left_out.items():
        if lacks := re.match(r"contacts\.thresholds\.(material\.\w+): is missing", why):
            reasons.append(
                (f"they need {lacks[1]}, which is not given", name.partition(", step")[0])
            )
        else:
            reasons.append((why, name))
    return reasons
