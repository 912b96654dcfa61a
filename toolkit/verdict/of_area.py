"""What the contacts of the area do where that is not what infinitely many do: they slip or slide otherwise, or at
clearly other forces."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from origins.drive import RISE
from toolkit.scene.scale import Scale, in_three_digits, told_contacts, with_scatter, written
from toolkit.verdict.answers import Answer, Verdict
from toolkit.verdict.mean_force import mean_of_contacts
from toolkit.verdict.sliders.ensemble import by_sliders
from toolkit.verdict.sliders.follow import ENOUGH_SLIPS
from toolkit.verdict.sliders.late import EVER_RARER, SLIDERS, shrinking
from toolkit.verdict.sliders.records import Behaviour, Finite
from toolkit.verdict.slips_in_words import (
    WORTH_SHOWING,
    does,
    ever_rarer,
    fall_of,
    fluctuating,
    left_out,
    period_with_scatter,
    scatters,
    sliding_force,
    spacings,
    still_changing,
)
from toolkit.verdict.uncertainty import SEEN, error_beside

# standard errors by which few contacts differ from infinitely many where it is told; the scatter of four sliders is
# known to some 40 %
CLEARLY = 4.0
# standard deviations to each side of its mean within which a force stays that fluctuates by chance
SURELY = 3.0
# times as large an error of infinitely many contacts that those of the area are told in their place
BETTER = 10.0


def disagreeing(verdict: Verdict) -> list[tuple[Behaviour, Finite]]:
    """The rules under which as many contacts as there are do something else than infinitely many."""
    return [(one, finite) for one, finite in _pairs(verdict) if _kinds_differ(verdict, one, finite)]


def finite_told_apart(verdict: Verdict) -> dict[str, Finite]:
    """What as many contacts as there are do, by the rules under which that is something else than what infinitely many
    do, or the same at forces that differ by more than the errors of both, scatter, or are known far better."""
    by_rule = dict[str, Finite]()
    for one, finite in _pairs(verdict):
        if (
            one.instead
            or _kinds_differ(verdict, one, finite)
            or _slips_differ(verdict, one, finite)
            or _slides_apart(finite, verdict.own.kinetic.value, _error_of(verdict, one))
            or scatters(finite)
            or _better_known(verdict, one, finite)
        ):
            # where none slips, no rule acts: what is left between rules is chance
            alike = [other for other in by_rule.values() if _slide_alike(finite, other)]
            by_rule[one.rule] = replace(alike[0], rule=one.rule) if alike else finite
    return by_rule


def _slide_alike(one: Finite, other: Finite) -> bool:
    """Whether two slide smoothly at forces that differ by no more than their errors."""
    if not one.kind == other.kind == "smooth" or one.rises != other.rises:
        return False
    return abs(one.late - other.late) <= one.late_error + other.late_error


def _pairs(verdict: Verdict) -> Iterator[tuple[Behaviour, Finite]]:
    """Rules that are decided for both, infinitely many contacts and as many as there are; not where fewer were
    followed, which say so: their forces are further from those of infinitely many."""
    for one, finite in zip(verdict.own.behaviours, verdict.finite, strict=False):
        if one.kind != "undecided" and finite.kind != "unknown" and not finite.message:
            yield one, finite


def _kinds_differ(verdict: Verdict, one: Behaviour, finite: Finite) -> bool:
    """Falls below RISE mean thresholds are no slips of the slider, nor are rare ones within what its force fluctuates
    by; and slips that get ever rarer end in sliding."""
    small = RISE * verdict.own.contacts.mean_threshold
    if {one.kind, finite.kind} == {"smooth", EVER_RARER}:
        return False
    if finite.kind == "now and then":
        # falls of a force that fluctuates as much
        small = max(small, 2.0 * SURELY * np.nan_to_num(finite.fluctuation))
    return one.kind != finite.kind and not finite.before - finite.after < small


def _slips_differ(verdict: Verdict, one: Behaviour, finite: Finite) -> bool:
    """Whether all the contacts of the area slip as infinitely many do, and from a clearly other force."""
    if not one.kind == finite.kind == "stick-slip":
        return False
    margin = max(SEEN * abs(one.before), _error_of(verdict, one), 2.0 * finite.before_error)
    return abs(finite.before - one.before) > margin


def _slides_apart(finite: Finite, kinetic: float, error: float = 0.0) -> bool:
    """Whether contacts that re-form at once bear clearly more at the end of the way than infinitely many, `kinetic`
    with its numerical `error` (lengths): on soft springs by N^(-2/3) <x_s> times 2 to 9, or more (docs/sliders.md)."""
    margin = max(CLEARLY * finite.late_error, WORTH_SHOWING * kinetic, error)
    return bool(abs(finite.late - kinetic) > margin)


def _better_known(verdict: Verdict, one: Behaviour, finite: Finite) -> bool:
    """Whether slips of the contacts of the area are known BETTER times as well, and the error of infinitely many would
    stand in the answer; not where heat was left out of both."""
    if not one.kind == finite.kind == "stick-slip" or one.heat_left_out is not None:
        return False
    return error_beside(verdict, verdict.own, one) > BETTER * finite.before_error


def _error_of(verdict: Verdict, one: Behaviour) -> float:
    """The numerical error of a behaviour's forces, a length; 0 where it is not known."""
    return one.error * verdict.own.contacts.mean_threshold if one.error < np.inf else 0.0


def counted(verdict: Verdict, finite: Finite) -> str:
    """These contacts by their number, and whose they are."""
    whose = "of the area" if verdict.own.scale.contacts is not None else "of [eq]"
    return f"the {told_contacts(finite.contacts)} {whose}"


def whom_of(verdict: Verdict, one: Behaviour) -> str:
    """Of whom a behaviour is told: smooth sliding of infinitely many contacts, where those of the area were not
    followed; and what so many contacts tell in the place of others. "" where the area's own tell, and of other
    readings, which are of infinitely many."""
    own = any(one is each for each in verdict.own.behaviours)
    if not own or one.kind == "undecided":
        return ""
    if one.contacts is None:
        unknown = {few.rule for few in verdict.finite if few.kind == "unknown"}
        return " for infinitely many contacts" * (one.kind == "smooth" and one.rule in unknown)
    number = verdict.own.scale.contacts
    if one.instead or (number is not None and one.contacts >= round(number)):
        return ""
    place = "infinitely many" if number is None else f"the {in_three_digits(number)} of the area"
    return f" with {told_contacts(one.contacts)}, followed contact by contact, in place of {place}"


def subject(finite: Finite) -> str:
    """Who does something: so many contacts, of one alone the sliders that it holds."""
    return f"{'sliders of ' * (finite.contacts == 1)}{told_contacts(finite.contacts)}"


def verb(kinds: set[str]) -> str:
    """What sliders do of which so many kinds are told."""
    if len(kinds) > 1:
        return "slip or slide otherwise, by the slip rule"
    verbs = {
        "stick-slip": "stick and slip",
        "smooth": "slide smoothly",
        "now and then": "slip now and then",
        EVER_RARER: "slip ever more rarely",
    }
    return verbs[min(kinds)]


def behaved(verdict: Verdict, finite: Finite) -> str:
    """What so many contacts do, whose they are, and their own forces with errors and scatter."""
    scale, whose = verdict.own.scale, f"with {counted(verdict, finite)}"
    if finite.kind == "smooth" or (finite.kind == "now and then" and np.isfinite(finite.late)):
        beside = fluctuating(finite, scale)
        whose = f"{beside}{',' * bool(beside)} {whose}"
        if not np.isfinite(finite.late):
            return f"{does(finite)}{whose}"
        still = " and still rising" * finite.rises
        comma = "," * (finite.rises or finite.kind != "smooth")
        return f"{does(finite)}{comma} at {sliding_force(finite, scale)}{still}{whose}"
    if finite.kind == EVER_RARER:
        return ever_rarer(verdict, finite, whose)
    if finite.kind == "now and then":
        seen = f"{finite.slips:.2g} a slider on the way that was followed, sliding at about F_k in between"
        return f"{does(finite)}, from {fall_of(finite, scale)}, {seen}, {whose}{left_out(finite)}"
    said = f"stick-slip: {fall_of(finite, scale)}"
    if shrinks := shrinking(finite):  # the forces are those of late slips, not of those to come
        whose += f"{shrinks}, so that they may die out"
    if fewer := spacings(finite, scale):
        whose += f", ever rarer: {fewer}"
    whose += left_out(finite)
    if finite.period is None:
        return f"{said} {whose}"
    every, later = period_with_scatter(verdict, finite)
    speed = scale.speed(verdict.velocity)
    return f"{said} every {every}, {later} at {speed} {whose}"


def rows_of(verdict: Verdict, finite: Finite) -> dict[str, str]:
    """The numbers of so many contacts for the table, by their names."""
    scale, whose = verdict.own.scale, told_contacts(finite.contacts)
    over, load = "", scale.load
    if load:
        late, error = (one * scale.force / load for one in (finite.late, finite.late_error))
        over = f", {written(late, '', error)} of the load"
    beside = fluctuating(finite, scale)
    if np.isfinite(finite.late) and finite.kind != "stick-slip":
        still = ", still rising" * finite.rises
        return {f"sliding force of {whose}": f"{sliding_force(finite, scale)}{still}{beside}{over}"}
    if not np.isfinite(finite.before):
        return {f"slips of {whose}": f"none{beside}"}
    rows = {f"slips of {whose}, from": fall_of(finite, scale) + left_out(finite)}
    if finite.slips < ENOUGH_SLIPS:
        few = (
            f"{finite.slips:.3g} of each of {SLIDERS} sliders, few: their scatter is in the errors"
        )
        rows[f"slips seen of {whose}"] = few + still_changing(finite, scale)
    if finite.kind == "stick-slip" and finite.period is not None:
        rows[f"period of {whose}"] = ", ".join(period_with_scatter(verdict, finite))
    if (found := mean_of_contacts(finite)) is not None:
        mean_force, error = found.force * scale.force, found.error * scale.force
        if load:
            over = f", {written(mean_force / load, '', error / load)} of the load"
        told = with_scatter(mean_force, error, scale.force_unit)
        rows[f"mean force of stick-slip of {whose}"] = told + over
    if fewer := spacings(finite, scale):
        rows[f"slips of {whose} get ever rarer"] = fewer
    return rows


def late_force_of(finite: Finite, kinetic: float, scale: Scale) -> str:
    """The force that so many contacts bear at the end of the way, where it is not `kinetic`, that of infinitely many,
    F/(N_c <k>) (lengths)."""
    if not _slides_apart(finite, kinetic):
        return ""
    still = ", which still rises" * finite.rises
    beside = written(kinetic * scale.force, scale.force_unit)
    return f"; at the end they bear {sliding_force(finite, scale)}{still}, infinitely many {beside}"


def tells_instead(behaviour: Behaviour, finite: Finite) -> bool:
    """Whether sliders of all contacts decide what the master equation does not: they go on to slip, or slide at a force
    that no longer rises."""
    if behaviour.kind != "undecided" or finite.message:
        return False
    slips = finite.kind in ("stick-slip", EVER_RARER) and finite.period is not None
    return slips or (finite.kind == "smooth" and np.isfinite(finite.late) and not finite.rises)


def with_more(behaviour: Behaviour, finite: Finite, unit: float) -> Behaviour:
    """What the area's contacts tell in place of this behaviour, in two cases: fewer contacts told it before, or the
    master equation does not decide and they do (then `instead` says why); else the behaviour as it is. `unit`: the mean
    threshold, a length. Where all contacts of the area were followed, the error is that of their scatter alone."""
    fewer, slip = behaviour.contacts, finite.kind == "stick-slip" and finite.period is not None
    more = slip and fewer is not None and behaviour.kind == "stick-slip" and finite.contacts > fewer
    instead = tells_instead(behaviour, finite)
    if not (more or instead):
        return behaviour
    slides = finite.kind == "smooth"
    error = (finite.late_error if slides else finite.force_error) / unit
    error += behaviour.heat_left_out or 0.0
    if finite.message:
        error += behaviour.error * ((fewer or 0) / finite.contacts) ** (2.0 / 3.0)
    told = Behaviour(
        rule=finite.rule,
        kind=finite.kind,
        before=finite.late if slides else finite.before,
        after=finite.late if slides else finite.after,
        period=finite.period,
        period_error=finite.period_error if finite.period else 0.0,
        slips=int(finite.slips),
        error=error,
        success=True,
        message=by_sliders(finite.contacts, behaviour.heat_left_out),
        run_time=behaviour.run_time,
        in_time=finite.in_time,
        shrinks_by=finite.shrinks_by if slides else 0.0,
        contacts=finite.contacts,
        finite=finite,
        instead=(behaviour.message or "it does not decide") if instead else "",
        drive=finite.drive,
        force=finite.force,
    )
    return told.in_place_of(behaviour)


def with_finite(own: Answer, finite: tuple[Finite, ...]) -> Answer:
    """The own reading's answer with the numbers of all contacts of the area, or of more than told what its slider does.
    Where these decide what a slider with mass does, slip rules without the mass tell no more."""
    if own.machine is None or not finite:
        return own
    unit = own.contacts.mean_threshold
    more = [with_more(*pair, unit) for pair in zip(own.behaviours, finite, strict=False)]
    if more[0].rule == "mass" and more[0].instead:
        return replace(own, behaviours=(more[0],), extremes=())
    return replace(own, behaviours=(*more, *own.behaviours[len(more) :]))
