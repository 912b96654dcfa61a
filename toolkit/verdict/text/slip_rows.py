"""The rows of a verdict's table on slips: their forces, period and duration, by slip rule."""

from collections.abc import Iterator, Sequence

import numpy as np

from toolkit.scene.scale import guarded, with_scatter, written
from toolkit.verdict.answers import Answer, Verdict
from toolkit.verdict.mean_force import mean_over_slips
from toolkit.verdict.of_area import finite_told_apart, rows_of
from toolkit.verdict.sliders.follow import ENOUGH_SLIPS
from toolkit.verdict.sliders.late import SLIDERS
from toolkit.verdict.sliders.records import Behaviour
from toolkit.verdict.slips_in_words import (
    WORTH_SHOWING,
    falls,
    period_of,
    still_changing,
    with_period_error,
)
from toolkit.verdict.uncertainty import (
    TOLD_FROM,
    WORTH_TELLING,
    is_vague,
    to_digits,
    widest_uncertainty,
)

# a drop that is longer by this share than the spring regains over a period: the slider has swung back after the slip
_RUNG = 0.05
# the row that says how many slips there were, where they are few
SLIPS_SEEN = "slips seen"
TIME_OF_A_SLIP = "time of a slip"
# what the answer tells of infinitely many contacts beside those of the area
IN_BRACKETS = "force before a slip", "drop of a slip", "of it regained over a period", "period"
# part of a period, the drive's way while contacts are out, up to which K times the period is what the spring regains
WAITING = 0.02
# part of F_s by which the largest force at points of a path may miss a peak: these are 0.02 <x_s> apart
AT_POINTS = 3e-3


def rows_of_slips(verdict: Verdict) -> Iterator[list[str]]:
    """Rows of the slips of the own reading, first of the contacts of the area where these do something else than
    infinitely many; rules that give the same numbers share a row."""
    rows, few = dict[tuple[str, str], list[str]](), finite_told_apart(verdict)
    for rule, many in few.items():
        for row in rows_of(verdict, many).items():
            rows.setdefault(row, []).append(rule)
    for behaviour in verdict.own.behaviours:
        if behaviour.kind == "undecided" and not behaviour.slips:
            rows.setdefault(("slips", "not known"), []).append(behaviour.rule)
        shown_above = behaviour.rule in few and behaviour.finite is few[behaviour.rule]
        if (first := _first_slip(verdict, behaviour)) and not shown_above:
            rows.setdefault(("first slip", first), []).append(behaviour.rule)
        if behaviour.kind == "smooth" or not behaviour.slips or shown_above:
            continue
        values, whose = _values_of(verdict, behaviour), ""
        if behaviour.rule in few:  # whose forces and period stand in the answer, in brackets
            values = {name: told for name, told in values.items() if name not in IN_BRACKETS}
            whose = ", infinitely many contacts"
        for name, value in values.items():
            rule = behaviour.rule + _unfinished(behaviour)
            rows.setdefault((name + whose, value), []).append(rule)
    for (name, value), rules in rows.items():
        yield [f"{name} ({', '.join(rules)})", value, "", ""]
    slip = any(one.slips and one.kind != "smooth" for one in verdict.own.behaviours)
    machine = verdict.own.machine
    if slip and machine is not None and machine.mass is None:
        yield [TIME_OF_A_SLIP, "hangs on the mass M, some π (M/K)^(1/2): give drive.mass", "", ""]


def _values_of(verdict: Verdict, behaviour: Behaviour) -> dict[str, str]:
    """The numbers of slips under one rule by their names, each with its unit."""
    scale, vague, widest = verdict.own.scale, is_vague(verdict), widest_uncertainty(verdict)
    mean, before = verdict.own.contacts.mean_threshold, behaviour.before
    known = before and behaviour.error < np.inf
    relative_error = behaviour.error * mean / abs(before) if known else 0.0
    uncertainty = max(widest, relative_error)
    # an error that other samples and readings do not hide is told beside its number
    shown = relative_error > max(TOLD_FROM, widest)
    error = relative_error * abs(before * scale.force) * shown

    def told(force: float, error: float = error) -> str:
        """A force with its error where that is shown."""
        return _with_error(force, scale.force_unit, uncertainty * force, error, vague)

    def with_load(force: float) -> str:
        """The same, and as a part of the load."""
        return told(force) + _of_load(force, uncertainty, error, scale.load, vague)

    values = {"force before a slip": with_load(before * scale.force)}
    values["drop of a slip"] = told(drop_of(behaviour) * scale.force)
    if (regained := regained_by(verdict, behaviour)) is not None:
        spring = verdict.own.machine.spring if verdict.own.machine is not None else 0.0
        of_period = spring * behaviour.period_error * scale.force
        regained_error = max(error, of_period) * shown
        values["of it regained over a period"] = told(regained * scale.force, regained_error)
    if (mean_force := mean_over_slips(behaviour)) is not None:
        values["mean force of stick-slip"] = with_load(mean_force * scale.force)
    if behaviour.period is not None:
        beside_forces = period_of(verdict, behaviour.period, uncertainty, bool(error))
        values["period"] = ", ".join(with_period_error(verdict, behaviour) or beside_forces)
    if behaviour.kind == "stick-slip" and behaviour.slips < ENOUGH_SLIPS:
        values[SLIPS_SEEN] = _of_few_slips(behaviour) + still_changing(behaviour.finite, scale)
    if (lasts := behaviour.in_time.slip_time) is not None:
        values[TIME_OF_A_SLIP] = written(lasts, scale.time_unit)
    return values


def _of_load(
    force: float, uncertainty: float, error: float, load: float | None, vague: bool
) -> str:
    """A force, with its relative uncertainty and its own error, as a part of the load; "" where none is known."""
    if not load:
        return ""
    over = force / load
    return f", {to_digits(over, '', uncertainty * over, error / load, vague)} of the load"


def _with_error(value: float, unit: str, uncertainty: float, error: float, vague: bool) -> str:
    """A value with its error, or to the digits that its uncertainty leaves where the error is 0, two if `vague`."""
    return with_scatter(value, error, unit) if error else guarded(value, unit, uncertainty, vague)


def _of_few_slips(behaviour: Behaviour) -> str:
    """How many slips were seen where these are fewer than usual, and why no more are needed."""
    seen, why = f"{behaviour.slips} slip", behaviour.message.partition("; ")[0]
    why = why.partition(": ")[0]  # sizes of drops, in the solver's own unit
    if why.startswith(seen):
        return why
    whose = f" of each of {SLIDERS} sliders" * (behaviour.contacts is not None)
    return f"{seen}{'s' * (behaviour.slips != 1)}{whose}"


def _unfinished(behaviour: Behaviour) -> str:
    """What to add to the rule of slips that were seen and are not decided: whether the path is cut; or that they are of
    few contacts."""
    if behaviour.kind != "undecided":
        return ""
    if behaviour.few_break is not None:
        return ": of few contacts"
    return ": path cut" if behaviour.cut else ": not decided"


def _first_slip(verdict: Verdict, behaviour: Behaviour) -> str:
    """The forces before and after the first slip of a mass, of contacts that began together; "" without one, and where
    those of the slips that are told differ by less than is worth telling, or than is known."""
    first = behaviour.in_time
    if first.first_forces is None:
        return ""
    scale, (before, after) = verdict.own.scale, first.first_forces
    each = (before, behaviour.before), (after, behaviour.after)
    mean, uncertainty = verdict.own.contacts.mean_threshold, widest_uncertainty(verdict)
    error = behaviour.error * mean if behaviour.error < np.inf else 0.0
    least = max(WORTH_TELLING * abs(before), error + first.first_error)
    if behaviour.kind != "smooth" and all(abs(one - other) <= least for one, other in each):
        return ""
    chance = max(error, first.first_error) if first.first_error else 0.0  # of sliders
    off = max(error, uncertainty * abs(before)) * scale.force
    shown = chance * scale.force * (chance > max(TOLD_FROM, uncertainty) * abs(before))
    high, low = (
        with_scatter(one * scale.force, shown, scale.force_unit)
        if shown
        else guarded(one * scale.force, scale.force_unit, off, is_vague(verdict))
        for one in (before, after)
    )
    return falls(high, low, (before - after) * scale.force, scale.force_unit)


def drop_of(behaviour: Behaviour) -> float:
    """By how much the spring's force falls in a slip, F/(N_c <k>) (a length); of a mass its first swing."""
    return behaviour.before - behaviour.after


def past_peak(verdict: Verdict, answer: Answer, alike: Sequence[Behaviour]) -> str:
    """The peak of the force where a slip begins clearly past it, as on a spring near K*, with F_s in its place where it
    is that; "" where it is not clear, or differs between `alike`."""
    one, unit, static = alike[0], answer.scale.force_unit, answer.static
    peaks, clear = [each.peak for each in alike], one.error * answer.contacts.mean_threshold
    if not min(peaks) > one.before + max(clear, WORTH_SHOWING * one.before):
        return ""
    if np.ptp([*peaks, static.value]) < AT_POINTS * static.value and not answer.contacts.in_time:
        force, off = static.value * answer.scale.force, widest_uncertainty(verdict)
        return f", past the peak F_s = {guarded(force, unit, off * force, is_vague(verdict))},"
    if np.ptp(peaks) > WORTH_SHOWING * one.before:
        return ""
    return f", past a peak of {written(one.peak * answer.scale.force, unit, digits=2)},"


def regained_by(verdict: Verdict, behaviour: Behaviour) -> float | None:
    """By how much the spring's force rises over a period, F/(N_c <k>) (a length), where that is clearly less than a
    slip's drop: a mass whose contacts are out swings back before it sticks. None where it is not, and where the drive
    goes on by more than WAITING of the period while they are out, and loads no spring."""
    machine = verdict.own.machine
    if behaviour.rule != "mass" or behaviour.period is None or machine is None:
        return None
    waits = machine.velocity * verdict.own.contacts.waiting_time
    if waits > WAITING * behaviour.period:
        return None
    regained = machine.spring * behaviour.period
    return regained if drop_of(behaviour) > (1.0 + _RUNG) * regained else None
