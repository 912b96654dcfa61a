"""The verdict as text: the sentence, its numbers, and what the sentence hangs on."""

from collections.abc import Sequence

import numpy as np

from toolkit.scene.interfaces import remarks
from toolkit.scene.scale import written
from toolkit.verdict.finite import Finite
from toolkit.verdict.follow import Behaviour
from toolkit.verdict.judge import Answer, Verdict
from toolkit.verdict.table import numerical_errors, share_of, table

NEAR = 0.1  # of K*: on softer springs the number of contacts decides nothing
# how the slip rules are named where a user reads of them
NAMED = {
    "reset": "a slip renews all contacts",
    "reform-after": "contacts re-form after the slip",
    "instant": "contacts re-form at once",
    "mass": "mass, damping and delay decide",
}


def page(verdict: Verdict) -> list[str]:
    """The verdict on one page: title, sentence, its numbers, table, what it hangs on, run time."""
    lines = [verdict.title, "", sentence(verdict), *(f"  {line}" for line in details(verdict)), ""]
    lines += table(verdict)
    lines += [numerical_errors(verdict), "", "What it hangs on"]
    lines += [f"  {line}" for line in dependence(verdict)]
    return [*lines, "", f"run time {verdict.run_time:.2g} s"]


def sentence(verdict: Verdict) -> str:
    """The answer in one short sentence; where the number of contacts, readings or rules disagree, what decides."""
    own = verdict.own
    if own.machine is None:
        return _without_spring(verdict)
    if apart := _disagreement(verdict):
        return apart
    if (
        len({one.kind for answer in verdict.answers for one in answer.behaviours} - {"undecided"})
        > 1
    ):
        return f"the assumptions decide: {', '.join(_kinds(verdict))}"
    return "; ".join(_told(verdict, own))


def details(verdict: Verdict) -> list[str]:
    """The numbers of what the sentence says in kinds alone; none where it gives them itself."""
    numbers = _told(verdict, verdict.own) if verdict.own.machine is not None else []
    return [] if sentence(verdict) == "; ".join(numbers) else numbers


def _kinds(verdict: Verdict) -> list[str]:
    """What happens under which rule of the own reading, else by that reading and by the others."""
    groups = _groups(verdict.own)
    if len(groups) > 1:
        return [f"{kind} if {_rules(alike)}" for kind, alike in groups.items()]
    others = len(verdict.answers) - 1
    own = [f"{kind} by {verdict.own.name}" for kind in groups]
    return own + [
        f"{kind} by {len(names)} of {others} others" for kind, names in _others(verdict).items()
    ]


def _rules(alike: Sequence[Behaviour]) -> str:
    return " or ".join(NAMED[one.rule] for one in alike)


def disagreeing(verdict: Verdict) -> list[tuple[Behaviour, Finite]]:
    """The rules under which as many contacts as there are do something else than infinitely many."""
    pairs = zip(verdict.own.behaviours, verdict.finite, strict=False)
    known = [pair for pair in pairs if "un" not in (pair[0].kind[:2], pair[1].kind[:2])]
    return [(behaviour, finite) for behaviour, finite in known if behaviour.kind != finite.kind]


def _disagreement(verdict: Verdict) -> str:
    """The headline where the number of contacts decides; "" where it does not."""
    apart = disagreeing(verdict)
    if not apart:
        return ""
    _, finite = apart[0]
    said = {"stick-slip": "stick and slip", "smooth": "slide smoothly"}.get(
        finite.kind, "slip now and then"
    )
    every = len(apart) == len(verdict.own.behaviours)
    where = "" if every else f" if {_rules([one for one, _ in apart])}"
    return f"disagree: {finite.contacts:,} contacts {said}{where}, infinitely many do not"


def _without_spring(verdict: Verdict) -> str:
    """Below which spring the interface slips, over all readings."""
    springs = [answer.critical_spring.value * answer.scale.spring for answer in verdict.answers]
    own, unit, spread = springs[0], verdict.own.scale.spring_unit, max(springs) - min(springs)
    if not np.isfinite(spread):
        spread = 0.0
    spread = max(spread, (verdict.own.critical_spring.sampling or 0.0) * verdict.own.scale.spring)
    said = f"slips on a spring softer than K* = {written(own, unit, spread)}"
    if len(springs) > 1:
        ends = " to ".join(written(value, unit, spread) for value in (min(springs), max(springs)))
        said += f" (from {ends} over {len(springs)} readings)"
    return f"{said}; give drive.spring for a verdict on a machine"


def _groups(answer: Answer) -> dict[str, list[Behaviour]]:
    """The rules by what happens under them."""
    groups: dict[str, list[Behaviour]] = {}
    for behaviour in answer.behaviours:
        groups.setdefault(behaviour.kind, []).append(behaviour)
    return groups


def _told(verdict: Verdict, answer: Answer) -> list[str]:
    """What the rules say under one reading, with its numbers."""
    groups, parts = _groups(answer), list[str]()
    for kind, alike in groups.items():
        said = _behaved(verdict, answer, kind, alike)
        parts.append(f"{said} if {_rules(alike)}" if len(groups) > 1 else said)
    return parts


def _behaved(verdict: Verdict, answer: Answer, kind: str, alike: Sequence[Behaviour]) -> str:
    """One kind of behaviour with its numbers."""
    scale, last, share = answer.scale, alike[0], share_of(verdict)

    def reach(values: Sequence[float], unit: str) -> str:
        """One value, or the smallest and the largest where they differ as written."""
        ends = [written(value, unit, share * abs(value)) for value in (min(values), max(values))]
        return " to ".join(dict.fromkeys(ends))

    if kind == "undecided":
        return f"not decided ({last.message})"
    low = reach([one.after * scale.force for one in alike], scale.force_unit)
    if kind == "smooth":
        return f"smooth at {low}"
    high = reach([one.before * scale.force for one in alike], scale.force_unit)
    said = f"stick-slip: {high} down to {low}"
    periods = [one.period for one in alike if one.period is not None]
    if periods:
        every = reach(periods, scale.length_unit)
        seconds = reach([period / verdict.velocity for period in periods], scale.time_unit)
        speed = written(verdict.velocity, "m/s" if scale.length_unit == "m" else "")
        said += f" every {every}, {seconds} at {speed}"
    return said


def _others(verdict: Verdict) -> dict[str, list[str]]:
    """The readings that say something else than the scene's own under any rule, by what they say."""
    own = {behaviour.rule: behaviour.kind for behaviour in verdict.own.behaviours}
    differ: dict[str, list[str]] = {}
    for answer in verdict.answers[1:]:
        for one in answer.behaviours:
            if one.kind not in ("undecided", own[one.rule]):
                names = differ.setdefault(one.kind, [])
                names += [answer.name] if answer.name not in names else []
    return differ


def dependence(verdict: Verdict) -> list[str]:
    """What the verdict hangs on: slip rule, readings, number of contacts; and what was not answered."""
    own, lines = verdict.own, list[str]()
    if len(own.behaviours) > 1:
        kinds = {one.rule: one.kind for one in own.behaviours}
        if len(set(kinds.values())) > 1:
            each = ", ".join(f"{kind} if {NAMED[rule]}" for rule, kind in kinds.items())
            lines.append(
                f"the slip rule: {each}. In nature mass, damping and the contacts' delay decide: "
                "give drive.mass, drive.damping and [contacts.delay]"
            )
        elif "undecided" not in kinds.values():
            lines.append("not the slip rule, for infinitely many contacts: all rules agree")
    elif own.machine is not None and own.machine.mass and not own.contacts.waiting_time:
        lines.append(
            "the contacts' delay: none is given, so that they re-form at once; one far above the time of a slip makes "
            "full stick-slip of most smooth sliders: give [contacts.delay]"
        )
    answers = verdict.answers
    if len(answers) > 1:
        springs = [one.critical_spring.value * one.scale.spring for one in answers]
        factor = max(springs) / min(springs) if min(springs) > 0.0 else np.inf
        lines.append(
            f"threshold law, contact model and resolution: K* differs by a factor of {factor:.3g} over "
            f"{len(answers)} readings"
        )
        for kind, names in _others(verdict).items():
            lines.append(f"of these, {kind}: {', '.join(names)}")
    if own.machine is not None and own.contacts.in_time:
        lines.append(
            "F_s, F_k and K* of the table are those of a slider as fast as the drive; one that sticks is slower, and "
            "contacts that wait, break by heat or age bear another force: before a slip it is that of the sentence"
        )
    number, machine = own.scale.contacts, own.machine
    soft = machine is None or machine.spring < NEAR * own.critical_spring.value
    if number is not None and machine is not None and not soft:
        crowd = number * machine.spring**3
        lines.append(
            f"the number of contacts N: N K³ = {crowd:.2g}, K in N_c<k>; above K* sliding is smooth "
            "only where it is above some 50"
        )
    lines += remarks(own.contacts.thresholds)
    for finite in verdict.finite:
        lines.append(_of_finite(verdict, finite))
    lines += [f"left out: {name}: {why}" for name, why in verdict.left_out.items()]
    for behaviour in own.behaviours:
        if behaviour.message.startswith("by the ensemble"):
            lines.append(
                f"the slips are means {behaviour.message}, with a standard error of some "
                f"{behaviour.error:.0e} <x_s>: the master equation takes no such slider, or not in time"
            )
        if not behaviour.success:
            lines.append(f"not as asked, {NAMED[behaviour.rule]}: {behaviour.message}")
    return lines


def _of_finite(verdict: Verdict, finite: Finite) -> str:
    """What so many contacts do, in words."""
    scale, rule = verdict.own.scale, NAMED[finite.rule]
    if finite.kind == "unknown":
        return f"the number of contacts was not looked at if {rule}: {finite.message}"
    said = f"{finite.contacts:,} contacts, if {rule}: {finite.kind}"
    if finite.kind == "smooth":
        return said
    force, share = finite.before * scale.force, share_of(verdict)
    if not np.isfinite(finite.before_error):
        return f"{said}, from {written(force, scale.force_unit, share * force)}"
    off = max(finite.before_error * scale.force, share * force)
    before = written(force, scale.force_unit, off)
    error = written(finite.before_error * scale.force, scale.force_unit, digits=1)
    return f"{said}, from {before} ± {error}"
