"""What of a verdict was not answered, or not as well as asked."""

import re
from collections.abc import Iterator

import numpy as np

from toolkit.scene.scale import written
from toolkit.verdict.answers import Verdict
from toolkit.verdict.follow import TOLERANCE_IN_TIME
from toolkit.verdict.kinds import (
    GENERAL,
    TURNS,
    Line,
    by_reason,
    named,
)
from toolkit.verdict.machine import NO_FORCES, Behaviour
from toolkit.verdict.readings import why_late
from toolkit.verdict.table import in_units


def unanswered(verdict: Verdict) -> Iterator[Line]:
    """What of the own reading was too late, and readings without an answer."""
    if verdict.own.critical_spring.unknown:
        why = why_late(verdict.own.contacts)
        yield Line(TURNS, "; ".join([*([] if verdict.own.machine else [NO_FORCES]), *why]))
    for reason, names in by_reason(_left_out(verdict)).items():
        if len(names) == 1:
            reason = reason.replace("they need", "it needs")
        yield Line(GENERAL, f"left out: {', '.join(names)}: {reason}")


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
        error = max(one.error for one in by_contacts if one.rule in rules)
        error_text = written(
            error * own.contacts.mean_threshold * scale.force, scale.force_unit, digits=2
        )
        which = f" if {named(rules)}" * (len(own.behaviours) > len(rules))
        more = ", with what more contacts would change" * any(
            _fewer_than_there_are(verdict, one) for one in by_contacts if one.rule in rules
        )
        said += f", their forces known to some {error_text} (one standard error{more}){which}"
        yield Line(max(errors[rule] for rule in rules), f"{said}: {_not_solved(verdict)}")
    missed = [(in_units(one.message, scale), one.rule) for one in own.behaviours if not one.success]
    for why, rules in by_reason(missed).items():
        most = max(errors[rule] for rule in rules)
        yield Line(most, f"not as asked if {named(rules)}: {why}")
    yield from _of_heat(verdict)
    rough = [
        (in_units(one.message, scale), one.rule)
        for one in own.behaviours
        if one.success and one.error > TOLERANCE_IN_TIME and one.kind != "undecided"
        if one.contacts is None and one.heat_left_out is None
    ]
    for why, rules in by_reason(rough).items():
        most = max(errors[rule] for rule in rules)
        yield Line(most, f"the force is known roughly if {named(rules)}: {why}")


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
    return number is None or (one.contacts or 0) < round(number)


def _relative_error(verdict: Verdict, one: Behaviour) -> float:
    """The error of a behaviour's force, relative to it; TURNS where the force is not known."""
    error = one.error * verdict.own.contacts.mean_threshold
    return float(error / abs(one.before)) if np.isfinite(error) and one.before else TURNS


def _of_heat(verdict: Verdict) -> Iterator[Line]:
    """What heat that was left out may change in the force, from above."""
    own, scale = verdict.own, verdict.own.scale
    unit = own.contacts.mean_threshold * scale.force
    cold = {one.rule: one.heat_left_out for one in own.behaviours if one.heat_left_out is not None}
    said = ((written(most * unit, scale.force_unit, digits=2), rule) for rule, most in cold.items())
    for most, rules in by_reason(said).items():
        which = f" if {named(rules)}" * (len(own.behaviours) > len(rules))
        few = any(one.rule in rules and one.kind != "unknown" for one in verdict.finite)
        which += ", of the contacts of the area, too" * few
        size = max(cold[rule] for rule in rules) * unit / (own.static.value * scale.force)
        yield Line(size, f"heat is left out{which}: it would change the force by {most} at most")


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
