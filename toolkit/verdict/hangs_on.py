"""What a verdict hangs on, in lines: slip rule, readings, number of contacts; and what was not answered."""

import re
from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from toolkit.scene.interfaces import remarks
from toolkit.scene.scale import written
from toolkit.verdict.answers import Answer, Verdict
from toolkit.verdict.budget import MORE_TIME
from toolkit.verdict.finite import SMALL, Finite
from toolkit.verdict.follow import DAMPED, TOLERANCE_IN_TIME
from toolkit.verdict.machine import NO_FORCES
from toolkit.verdict.of_area import fall_of, late_force_of
from toolkit.verdict.readings import why_late
from toolkit.verdict.table import drop_of, in_units, regained_by

NEAR = 0.1  # of K*: on softer springs the number of contacts decides nothing
# how the slip rules are named where a user reads of them
NAMED = {
    "reset": "a slip renews all contacts",
    "reform-after": "contacts re-form after the slip",
    "instant": "contacts re-form at once",
    "mass": "mass, damping and delay decide",
}


def others(verdict: Verdict) -> dict[str, list[str]]:
    """The readings that say something else than the scene's own under any rule, by what they say."""
    own = {behaviour.rule: behaviour.kind for behaviour in verdict.own.behaviours}
    differ: dict[str, list[str]] = {}
    for answer in verdict.answers[1:]:
        for one in answer.behaviours:
            if one.kind not in ("undecided", own.get(one.rule, one.kind)):
                names = differ.setdefault(one.kind, [])
                names += [answer.name] if answer.name not in names else []
    return differ


def not_decided(verdict: Verdict) -> list[Answer]:
    """The other readings of which nothing is known under any rule that the scene's own reading is decided under."""
    known = {one.rule for one in verdict.own.behaviours if one.kind != "undecided"}
    if not known:
        return []
    return [
        answer
        for answer in verdict.answers[1:]
        if all(one.kind == "undecided" for one in answer.behaviours if one.rule in known)
    ]


def out_of_time(answer: Answer) -> bool:
    """Whether it is for want of time alone that a reading is not decided."""
    return all("wall_time" in one.message for one in answer.behaviours if one.kind == "undecided")


def dependence(verdict: Verdict) -> list[str]:
    """What the verdict hangs on: slip rule, readings, number of contacts; and what was not answered."""
    return [
        *_of_rules(verdict),
        *_of_readings(verdict),
        *_of_a_stuck_slider(verdict),
        *_of_a_mass(verdict),
        *_of_contacts(verdict),
        *_left_undone(verdict),
        *_of_errors(verdict),
    ]


def _of_rules(verdict: Verdict) -> Iterator[str]:
    """What hangs on the slip rule, or on the delay that decides in its place."""
    own = verdict.own
    kinds = {one.rule: one.kind for one in own.behaviours}
    if len(set(kinds.values())) > 1:
        each = ", ".join(f"{kind} if {NAMED[rule]}" for rule, kind in kinds.items())
        yield (
            f"the slip rule: {each}. In nature mass, damping and the contacts' delay decide: "
            "give drive.mass, drive.damping and [contacts.delay]"
        )
    elif len(kinds) > 1 and "undecided" not in kinds.values():
        yield "not the slip rule, for infinitely many contacts: all rules agree"
    elif len(kinds) == 1 and own.machine and own.machine.mass:
        given, known = bool(own.contacts.waiting_time), verdict.turned is not None
        if not given and (delay_decides(verdict) or not known):
            yield (
                "the contacts' delay: none is given, so that they form again at once; give [contacts.delay]"
            )
        elif delay_decides(verdict):
            yield "the contacts' delay: far below the time of a slip it changes the answer"
        elif known and verdict.turned and verdict.turned.kind != "undecided":
            yield f"not the contacts' delay: {'without one' if given else 'with a long one'} it does the same"


def delay_decides(verdict: Verdict) -> bool:
    """Whether a slider with mass is known to do something else with the other extreme of the contacts' delay."""
    kinds = {one.kind for one in verdict.own.behaviours}
    other = verdict.turned
    return other is not None and "undecided" not in kinds | {other.kind} and other.kind not in kinds


def _of_readings(verdict: Verdict) -> Iterator[str]:
    """By how much the readings differ, and which of them say something else."""
    answers, many = verdict.answers, len(verdict.answers)
    if many < 2:
        return
    springs = [
        one.critical_spring.value * one.scale.spring
        for one in answers
        if not (one.critical_spring.unknown or one.critical_spring.lost)
    ]
    if len(springs) > 1:
        factor = max(springs) / min(springs) if min(springs) > 0.0 else np.inf
        said = f"K* differs by a factor of {factor:.3g} over {len(springs)} readings"
        yield f"threshold law, contact model and resolution: {said}"
    differ = others(verdict)
    for kind, names in differ.items():
        yield f"of these, {kind}: {', '.join(names)}"
    missing = not_decided(verdict)
    for why, names in _by_reason((_why(one), one.name) for one in missing).items():
        yield f"not decided: {', '.join(names)}: {why}"
    absent = {one.name for one in missing}
    decided = [one for one in answers[1:] if {each.kind for each in one.behaviours} - {"undecided"}]
    decided = [one for one in decided if one.name not in absent]
    known = {one.rule for one in verdict.own.behaviours if one.kind != "undecided"}
    partly = [
        answer.name
        for answer in decided
        if any(one.kind == "undecided" for one in answer.behaviours if one.rule in known)
    ]
    if partly:
        yield f"decided under some slip rules, and not under others: {', '.join(partly)}"
    if verdict.own.machine is not None and decided and not differ:
        yield f"not the reading: the {len(decided)} others that were followed say what {verdict.own.name} says"


def _why(answer: Answer) -> str:
    """Why a reading is not decided."""
    if out_of_time(answer):
        return f"out of time: {MORE_TIME}, or give fewer verdict.readings"
    return in_units(answer.behaviours[0].message, answer.scale)


def _of_a_stuck_slider(verdict: Verdict) -> Iterator[str]:
    """Why the table's forces are not those of the slips."""
    own = verdict.own
    if own.machine is None:
        return
    if own.contacts.in_time:
        yield (
            "F_s, F_k and K* of the table are those of a rigid slider as fast as the drive; one that sticks is slower, "
            "and contacts that wait, break by heat or age bear another force: what a stuck slider reaches is the force "
            "before a slip"
        )


def why_smooth(verdict: Verdict) -> list[str]:
    """Why a slider below K* slides, in a sentence that stands below the table, beside K*."""
    own = verdict.own
    smooth = [one for one in own.behaviours if one.kind == "smooth"]
    if not smooth or not own.softer:
        return []
    force, unit = own.scale.force, own.scale.force_unit
    fall = own.static.value - own.kinetic.value
    rules = (
        "" if len(smooth) == len(own.behaviours) else f" if {named([one.rule for one in smooth])}"
    )
    begin = "K is below K*, and yet " * (not own.smoothed)
    said = f"{begin}sliding is smooth{rules}: "
    cold = not own.contacts.in_time or all(one.heat_left_out is not None for one in smooth)
    small = SMALL * own.contacts.mean_threshold
    if all(one.rule == "mass" and not one.slips for one in smooth) and cold and fall < small:
        return [
            f"{said}the fall from F_s to F_k, {written(fall * force, unit)}, is too small to count as a slip of a "
            f"slider with mass (from {written(small * force, unit)} on, {SMALL:g} <x_s>)"
        ]
    ends = f"F_s, {written(fall * force, unit)} above F_k," if fall > 0.0 else "a rise to F_k"
    after = f"after {ends} " * cold
    return [
        f"{said}{after}the slider slips once or a few times, and then no more, as contacts have forgotten their start"
    ]


def _of_a_mass(verdict: Verdict) -> Iterator[str]:
    """The damping that was taken, and the swing after a slip."""
    own = verdict.own
    for behaviour in own.behaviours:
        if behaviour.damping is not None:
            # N_c<k> in N/m is the unit of the spring, and N_c<k> times a time that of the damping
            unit = {"N/m": "N s/m", "N/m³": "N s/m³"}.get(own.scale.spring_unit, "N_c<k> time")
            yield (
                f"the damping: none is given, and without one the slider rings for too long; all is told of one of "
                f"{DAMPED:.0%} of critical, {behaviour.damping * own.scale.spring:.3g} {unit}: give drive.damping"
            )
        if (regained := regained_by(verdict, behaviour)) is not None:
            drop, force = drop_of(behaviour) * own.scale.force, own.scale.force_unit
            back = drop - (left := regained * own.scale.force)
            yield (
                f"the slider rings after a slip, while its contacts are out: of the drop of {written(drop, force)} it "
                f"swings back by {written(back, force)} before it sticks, and the period is that of the other "
                f"{written(left, force)}"
            )


def _of_contacts(verdict: Verdict) -> Iterator[str]:
    """The number of contacts, remarks on their thresholds, and what finitely many do."""
    own = verdict.own
    number, machine = own.scale.contacts, own.machine
    late = own.critical_spring.unknown or own.critical_spring.lost
    soft = machine is None or late or machine.spring < NEAR * own.critical_spring.value
    if number is not None and machine is not None and not soft:
        crowd = number * machine.spring**3
        yield (
            f"the number of contacts N: N K³ = {crowd:.2g}, K in N_c<k>; above K* sliding is smooth "
            "only where it is above some 50"
        )
    yield from remarks(own.contacts.thresholds)
    known = [finite for finite in verdict.finite if finite.kind != "unknown"]
    yield from (_of_finite(verdict, finite) for finite in known)
    unknown = [(finite.message, finite.rule) for finite in verdict.finite if finite not in known]
    for why, rules in _by_reason(unknown).items():
        yield f"the number of contacts was not looked at if {named(rules)}: {why}"


def _left_undone(verdict: Verdict) -> Iterator[str]:
    """What of the own reading was too late, and readings without an answer."""
    if verdict.own.critical_spring.unknown:
        contacts = verdict.own.contacts
        yield "; ".join([*([] if verdict.own.machine else [NO_FORCES]), *why_late(contacts)])
    for why, names in _by_reason(_left_out(verdict)).items():
        yield f"left out: {', '.join(names)}: {why}"


def _of_errors(verdict: Verdict) -> Iterator[str]:
    """Where the slider's force is less well known than asked for, and why."""
    own = verdict.own
    for one in own.behaviours:
        if one.contacts is not None:
            yield (
                f"the slips are means {one.message}, known to some {one.error:.0e} <x_s>: the "
                "master equation takes no such slider, or not in time"
            )
    scale = own.scale
    missed = [(in_units(one.message, scale), one.rule) for one in own.behaviours if not one.success]
    for why, rules in _by_reason(missed).items():
        yield f"not as asked if {named(rules)}: {why}"
    rough = [
        (_after(one.message, "heat is left out"), one.rule)
        for one in own.behaviours
        if one.success and one.error > TOLERANCE_IN_TIME and one.kind != "undecided"
        if one.contacts is None
    ]
    for why, rules in _by_reason(rough).items():
        yield f"the force is known roughly if {named(rules)}: {why}"


def _after(message: str, words: str) -> str:
    """The part of a message that begins with these words; all of it where they are not there."""
    return message[message.find(words) :] if words in message else message


def _by_reason(reasons: Iterable[tuple[str, str]]) -> dict[str, list[str]]:
    """Names by the reason that they share, each once."""
    groups = dict[str, list[str]]()
    for why, name in reasons:
        if name not in groups.setdefault(why, []):
            groups[why].append(name)
    return groups


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


def _of_finite(verdict: Verdict, finite: Finite) -> str:
    """What so many contacts do, in words."""
    said = f"{finite.contacts:,} contacts, if {NAMED[finite.rule]}: {finite.kind}"
    late = late_force_of(finite, verdict.own.kinetic.value, verdict.own.scale)
    beside = f" ({finite.message})" * bool(finite.message) + late
    if finite.kind == "smooth":
        return said + beside
    said += f", from {fall_of(finite, verdict.own.scale)}"
    if finite.kind == "stick-slip":
        return said + beside
    many = "1 slip" if finite.slips == 1.0 else f"{finite.slips:.2g} slips"
    return f"{said}, {many} a slider on the way that was followed{late}"


def named(rules: Sequence[str]) -> str:
    return " or ".join(NAMED[rule] for rule in rules)
