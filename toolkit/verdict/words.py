"""The verdict as text: the sentence, the table of numbers, and what the sentence hangs on."""

from collections.abc import Iterator, Sequence

import numpy as np

from toolkit.scene.interfaces import remarks
from toolkit.scene.scale import written
from toolkit.verdict.finite import Finite
from toolkit.verdict.follow import Behaviour
from toolkit.verdict.judge import Answer, Quantity, Verdict

# how the slip rules are named where a user reads of them
NAMED = {
    "reset": "a slip renews all contacts",
    "reform-after": "contacts re-form after the slip",
    "instant": "contacts re-form at once",
    "mass": "mass, damping and delay decide",
}


def page(verdict: Verdict) -> list[str]:
    """The verdict on one page: title, sentence, table, what it hangs on, run time."""
    lines = [verdict.title, "", sentence(verdict), ""]
    lines += table(verdict)
    lines += [numerical_errors(verdict), "", "What it hangs on"]
    lines += [f"  {line}" for line in dependence(verdict)]
    return [*lines, "", f"run time {verdict.run_time:.2g} s"]


def sentence(verdict: Verdict) -> str:
    """The answer in one sentence; where readings or rules disagree, the disagreement."""
    own = verdict.own
    if own.machine is None:
        return _without_spring(verdict)
    kinds = {
        behaviour.kind
        for answer in verdict.answers
        for behaviour in answer.behaviours
        if behaviour.kind != "undecided"
    }
    told = _told(verdict, own)
    if len(kinds) > 1:
        told = f"the assumptions decide: {told}{_others(verdict)}"
    return f"{_disagreement(verdict)}{told}"


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
    rules = " or ".join(NAMED[one.rule] for _, one in apart)
    return (
        f"disagree: {finite.contacts:,} contacts {said} if {rules}, infinitely many do not; "
        "for infinitely many: "
    )


def _without_spring(verdict: Verdict) -> str:
    """Below which spring the interface slips, over all readings."""
    springs = [answer.critical_spring.value * answer.scale.spring for answer in verdict.answers]
    own, unit = springs[0], verdict.own.scale.spring_unit
    said = f"slips on a spring softer than K* = {written(own, unit)}"
    if len(springs) > 1:
        ends = f"{written(min(springs), unit)} to {written(max(springs), unit)}"
        said += f" (from {ends} over {len(springs)} readings)"
    return f"{said}; give drive.spring for a verdict on a machine"


def _told(verdict: Verdict, answer: Answer) -> str:
    """What the rules say under one reading."""
    groups: dict[str, list[Behaviour]] = {}
    for behaviour in answer.behaviours:
        groups.setdefault(behaviour.kind, []).append(behaviour)
    parts = []
    for kind, alike in groups.items():
        said = _behaved(verdict, answer, kind, alike)
        if len(groups) > 1:
            said += f" if {' or '.join(NAMED[one.rule] for one in alike)}"
        parts.append(said)
    return "; ".join(parts)


def _behaved(verdict: Verdict, answer: Answer, kind: str, alike: Sequence[Behaviour]) -> str:
    """One kind of behaviour with its numbers."""
    scale, last = answer.scale, alike[0]
    if kind == "undecided":
        return f"not decided ({last.message})"
    if kind == "smooth":
        return f"smooth at {_range([one.after * scale.force for one in alike], scale.force_unit)}"
    high = _range([one.before * scale.force for one in alike], scale.force_unit)
    low = _range([one.after * scale.force for one in alike], scale.force_unit)
    said = f"stick-slip: {high} down to {low}"
    periods = [one.period for one in alike if one.period is not None]
    if periods:
        every = _range(periods, scale.length_unit)
        seconds = _range([period / verdict.velocity for period in periods], scale.time_unit)
        speed = written(verdict.velocity, "m/s" if scale.length_unit == "m" else "")
        said += f" every {every}, {seconds} at {speed}"
    return said


def _range(values: Sequence[float], unit: str) -> str:
    """One value, or the smallest and the largest where they differ by more than a thousandth."""
    low, high = min(values), max(values)
    if high - low <= 1e-3 * abs(high):
        return written(high, unit)
    return f"{written(low, unit)} to {written(high, unit)}"


def _others(verdict: Verdict) -> str:
    """How many of the other readings say something else than the scene's own, under any rule, and which."""
    own = {behaviour.rule: behaviour.kind for behaviour in verdict.own.behaviours}
    differ: dict[str, list[str]] = {}
    for answer in verdict.answers[1:]:
        for one in answer.behaviours:
            if one.kind not in ("undecided", own[one.rule]):
                names = differ.setdefault(one.kind, [])
                names += [answer.name] if answer.name not in names else []
    others = len(verdict.answers) - 1
    said = [
        f"{len(names)} of {others} other readings say {kind} ({', '.join(names)})"
        for kind, names in differ.items()
    ]
    return f"; {'; '.join(said)}" if said else ""


def table(verdict: Verdict) -> list[str]:
    """Each number, the scatter of other samples, and the spread over the readings. Numerical errors are far smaller,
    and stand in verdict.json; a line says how large they are at most."""
    rows = [["", "value", "other samples", "over the readings"], *_rows(verdict)]
    widths = [max(len(row[k]) for row in rows) for k in range(4)]
    return [
        "  ".join(f"{cell:<{n}}" for cell, n in zip(row, widths, strict=True)).rstrip()
        for row in rows
    ]


def _rows(verdict: Verdict) -> Iterator[list[str]]:
    """The rows of the table below its head."""
    own, answers = verdict.own, verdict.answers
    scale = own.scale
    forces, unit = [one.scale.force for one in answers], scale.force_unit
    kinetic, static = [one.kinetic for one in answers], [one.static for one in answers]
    yield _row("kinetic friction F_k", kinetic, forces, unit)
    yield _row("static friction F_s", static, forces, unit)
    if scale.load is not None:
        coefficients = [one.scale.force / (one.scale.load or 1.0) for one in answers]
        yield _row("friction coefficient F_k/load", kinetic, coefficients, "")
        yield _row("static coefficient F_s/load", static, coefficients, "")
    critical = [one.critical_spring for one in answers]
    springs = [one.scale.spring for one in answers]
    yield _row("slips below the spring K*", critical, springs, scale.spring_unit)
    if own.machine is not None:
        each = [Quantity(one.machine.spring if one.machine else 0.0, 0.0) for one in answers]
        yield _row("the machine's spring K", each, springs, scale.spring_unit)
    if scale.contacts is not None:
        held = [Quantity(one.scale.contacts or 0.0, 0.0) for one in answers]
        yield _row("contacts on the area", held, [1.0] * len(held), "")
    yield from _of_slips(verdict)


def _row(name: str, each: Sequence[Quantity], factors: Sequence[float], unit: str) -> list[str]:
    """A row: the own reading's value to the digit that the widest of the three uncertainties leaves."""
    values = [one.value * factor for one, factor in zip(each, factors, strict=True)]
    own, spread = each[0], max(values) - min(values)
    error, sampling = own.error * factors[0], (own.sampling or 0.0) * factors[0]
    apart = spread > 1e-6 * abs(values[0])
    return [
        name,
        written(values[0], unit, max(error, sampling, spread)),
        f"± {written(sampling, unit)}" if sampling else "not known" * (own.error > 0.0),
        f"{written(min(values), unit)} to {written(max(values), unit)}" if apart else "the same",
    ]


def _of_slips(verdict: Verdict) -> Iterator[list[str]]:
    """Rows of the slips of the own reading; rules that give the same numbers share a row."""
    scale, rows = verdict.own.scale, dict[tuple[str, str], list[str]]()
    for behaviour in verdict.own.behaviours:
        if behaviour.kind != "stick-slip":
            continue
        drop = (behaviour.before - behaviour.after) * scale.force
        told = {"drop of a slip": written(drop, scale.force_unit)}
        if behaviour.period is not None:
            period = written(behaviour.period, scale.length_unit)
            seconds = written(behaviour.period / verdict.velocity, scale.time_unit)
            told["period"] = f"{period}, {seconds}"
        if behaviour.slip_time is not None:
            told["time of a slip"] = written(behaviour.slip_time, scale.time_unit)
        for row in told.items():
            rows.setdefault(row, []).append(behaviour.rule)
    for (name, value), rules in sorted(rows.items()):
        yield [f"{name} ({', '.join(rules)})", value, "", ""]


def numerical_errors(verdict: Verdict) -> str:
    """How large the numerical errors of the own reading's numbers are at most, relative to these."""
    own = verdict.own
    known = [own.kinetic, own.static, own.critical_spring]
    relative = [one.error / abs(one.value) for one in known if one.value and np.isfinite(one.value)]
    for behaviour in own.behaviours:
        if np.isfinite(behaviour.error) and behaviour.before:
            mean = own.contacts.mean_threshold
            relative.append(behaviour.error * mean / abs(behaviour.before))
    return f"numerical errors are at most {max(relative, default=0.0):.0e} of these numbers (verdict.json has each)"


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
        else:
            lines.append("not the slip rule, for infinitely many contacts: all rules agree")
    answers = verdict.answers
    if len(answers) > 1:
        springs = [one.critical_spring.value * one.scale.spring for one in answers]
        factor = max(springs) / min(springs) if min(springs) > 0.0 else np.inf
        lines.append(
            f"threshold law, contact model and resolution: K* differs by a factor of {factor:.3g} over "
            f"{len(answers)} readings"
        )
    if own.scale.contacts is not None and own.machine is not None:
        crowd = own.scale.contacts * own.machine.spring**3
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
                f"{behaviour.error:.0e} <x_s>: the master equation takes no delay beside a mass"
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
    before = written(finite.before * scale.force, scale.force_unit)
    if not np.isfinite(finite.before_error):
        return f"{said}, from {before}"
    error = written(finite.before_error * scale.force, scale.force_unit, digits=1)
    return f"{said}, from {before} ± {error}"
