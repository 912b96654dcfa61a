"""The table of a verdict: each number, the scatter of other samples, the spread over the readings."""

import re
from collections.abc import Callable, Iterator, Sequence
from itertools import zip_longest

import numpy as np

from toolkit.scene.messages import with_units_of
from toolkit.scene.scale import PREFIXED, Scale, guarded, with_scatter, written
from toolkit.verdict.answers import Answer, Quantity, Verdict
from toolkit.verdict.of_area import apart, rows_of
from toolkit.verdict.sliders.follow import ENOUGH_SLIPS
from toolkit.verdict.sliders.late import SLIDERS
from toolkit.verdict.sliders.machine import Behaviour
from toolkit.verdict.slips_in_words import (
    mean_over_slips,
    period_of,
    still_changing,
    with_period_error,
)
from toolkit.verdict.text.k_star import of_critical_spring
from toolkit.verdict.text.spread import other_samples
from toolkit.verdict.uncertainty import (
    PRECISE,
    VAGUE,
    WORTH_TELLING,
    error_beside,
    is_vague,
    to_digits,
    widest_uncertainty,
    writer_of_springs,
)

# of the contacts: where no more of them hold, F_k is told with their share
HOLDING = 0.9
# a drop that is longer by this share than the spring regains over a period: the slider has swung back after the slip
_RUNG = 0.05
# part of a period, the drive's way while contacts are out, up to which K times the period is what the spring regains
WAITING = 0.02
# errors of the force in a solver's message, in mean thresholds
_ERRORS = re.compile(r"(error estimate |(?:above|within) the tolerance )(\d\S*\d)")
# what a solver advises where its error is above the tolerance
_ADVICE = re.compile(
    r"; (?:tighten it|(?:shorten the path or )?loosen the tolerance|(?:end the path sooner, or )?(leave out the heat)"
    r"(?: or loosen the tolerance)?)"
)


def table(verdict: Verdict) -> list[str]:
    """Each number, the scatter of other samples, the spread over the readings; numerical errors have lines below it."""
    many = len(verdict.answers)
    over = "over the readings" if many > 1 else "one reading only"
    rows = [["", "value", "other samples", over], *_rows(verdict)]
    if not other_samples(verdict):  # a law that is given has none, and nobody misses them
        none = ("other samples", "not known")
        rows = [[*one[:2], "" if one[2] in none else one[2], one[3]] for one in rows]
    return in_columns(rows)


def in_columns(rows: Sequence[Sequence[str]], align: str = "<") -> list[str]:
    """Rows of cells as lines of text; short rows end early. Each column is as wide as its widest cell; of columns that
    begin at the left, as its widest one that another follows: the last of a row may be as long as it likes."""
    if align == "<":
        rows = [_without_empty_end(one) for one in rows]
    followed = [one[:-1] if align == "<" else one for one in rows]
    widths = [max(map(len, column)) for column in zip_longest(*followed, fillvalue="")]
    widths.append(0)  # of the longest row's last cell
    padded = ([f"{cell:{align}{n}}" for cell, n in zip(row, widths, strict=False)] for row in rows)
    return ["  ".join(row).rstrip() for row in padded]


def _without_empty_end(row: Sequence[str]) -> Sequence[str]:
    """A row up to its last cell that is not empty."""
    return row[: max((number for number, cell in enumerate(row, 1) if cell), default=0)]


def _rows(verdict: Verdict) -> Iterator[list[str]]:
    """The rows of the table below its head."""
    own, answers = verdict.own, verdict.answers
    scale = own.scale
    forces, unit = [one.scale.force for one in answers], scale.force_unit
    kinetic, static = [one.kinetic for one in answers], [one.static for one in answers]
    uncertainty = widest_uncertainty(verdict)
    # contacts that depend on time bear another force where the slider sticks: see `dependence`
    speed = scale.speed(verdict.velocity)
    at = f" of a rigid slider at {speed}" * bool(own.contacts.in_time)
    yield row(f"kinetic friction F_k{at}{_of_holding(own)}", kinetic, forces, unit, uncertainty)
    yield row(f"static friction F_s{at}", static, forces, unit, uncertainty)
    if scale.load is not None:
        coefficients = [one.scale.force / (one.scale.load or 1.0) for one in answers]
        few = _of_holding(own)
        yield row(f"friction coefficient F_k/load{few}", kinetic, coefficients, "", uncertainty)
        yield row("static coefficient F_s/load", static, coefficients, "", uncertainty)
    name = f"{of_critical_spring(own)}{at}"
    if own.smoothed:
        yield [name, "-", "hangs on smoothing", ""]
    elif own.critical_spring.lost:
        yield [name, "not known", "", ""]
    else:
        with_spring = [one for one in answers if not one.critical_spring.lost]
        critical = [one.critical_spring for one in with_spring]
        springs = [one.scale.spring for one in with_spring]
        yield row(name, critical, springs, scale.spring_unit, write=writer_of_springs(own))
    if own.machine is not None:
        springs = [one.scale.spring for one in answers]
        each = [Quantity(one.machine.spring if one.machine else 0.0, 0.0) for one in answers]
        yield row("the machine's spring K", each, springs, scale.spring_unit)
    if scale.contacts is not None:
        numbers = [one.scale.contacts or 0.0 for one in answers]
        ends = dict.fromkeys(f"{end:,.0f}" for end in (min(numbers), max(numbers)))
        range_text = " to ".join(ends) if len(ends) > 1 else "the same" * (len(numbers) > 1)
        # as in sentences, which name the number of those that are followed
        yield ["contacts on the area", f"{numbers[0]:,.0f}", "", range_text]
    yield from _of_slips(verdict)


def row(
    name: str,
    each: Sequence[Quantity],
    factors: Sequence[float],
    unit: str,
    uncertainty: float = 0.0,
    write: Callable[[float, str, float], str] = guarded,
) -> list[str]:
    """A row: the own reading's value to a digit beyond that which the widest of the three uncertainties leaves;
    `uncertainty` : the least that is taken for it, relative to the value; `write` : as `guarded`."""
    if each[0].unknown:
        return [name, "not known", "", ""]
    values = [one.value * factor for one, factor in zip(each, factors, strict=True)]
    own, low, high = each[0], min(values), max(values)
    error, sampling = own.error * factors[0], (own.sampling or 0.0) * factors[0]
    # an infinite K* is apart from a finite one, and not from another
    apart = high - low > 1e-6 * min(abs(low), abs(high))
    off = max(error, sampling, high - low if apart else 0.0, uncertainty * abs(values[0]))
    if not np.isfinite(off):
        off = uncertainty * abs(values[0])
    told, *ends = (write(value, unit, off) for value in (values[0], low, high))
    if off == sampling > VAGUE * abs(values[0]):  # beside it, and with as many places
        told, *ends = (written(value, unit, digits=2) for value in (values[0], low, high))
    return [
        name,
        told,
        f"± {written(sampling, unit, digits=2)}" if sampling else "not known" * (own.error > 0.0),
        " to ".join(dict.fromkeys(ends)) if apart else "the same" * (len(each) > 1),
    ]


def _of_slips(verdict: Verdict) -> Iterator[list[str]]:
    """Rows of the slips of the own reading, first of the contacts of the area where these do something else than
    infinitely many; rules that give the same numbers share a row."""
    scale, rows = verdict.own.scale, dict[tuple[str, str], list[str]]()
    force, load, few = scale.force_unit, scale.load, apart(verdict)
    vague, machine = is_vague(verdict), verdict.own.machine
    machine_spring = machine.spring if machine is not None else 0.0
    for rule, many in few.items():
        for row in rows_of(verdict, many).items():
            rows.setdefault(row, []).append(rule)
    for behaviour in verdict.own.behaviours:
        if behaviour.kind == "undecided" and not behaviour.slips:
            rows.setdefault(("slips", "not known"), []).append(behaviour.rule)
        shown_above = behaviour.rule in few and behaviour.sliders is few[behaviour.rule]
        if behaviour.kind == "smooth" or not behaviour.slips or shown_above:
            continue
        mean, before = verdict.own.contacts.mean_threshold, abs(behaviour.before)
        relative_error = (
            behaviour.error * mean / before if before and behaviour.error < np.inf else 0.0
        )
        uncertainty = max(widest_uncertainty(verdict), relative_error)
        before, drop = (behaviour.before * scale.force, drop_of(behaviour) * scale.force)
        # an error that other samples and readings do not hide is told beside its number
        shown = relative_error > max(PRECISE, widest_uncertainty(verdict))
        error = relative_error * abs(before) * shown
        values = {
            "force before a slip": _with_error(before, force, uncertainty * before, error, vague)
        }
        values["force before a slip"] += _of_load(before, uncertainty, error, load, vague)
        values["drop of a slip"] = _with_error(drop, force, uncertainty * drop, error, vague)
        if (regained := regained_by(verdict, behaviour)) is not None:
            back = regained * scale.force
            of_period = machine_spring * behaviour.period_error * scale.force
            told = _with_error(
                back, force, uncertainty * back, max(error, of_period) * shown, vague
            )
            values["of it regained over a period"] = told
        if (mean_force := mean_over_slips(behaviour)) is not None:
            mean_force *= scale.force
            told = _with_error(mean_force, force, uncertainty * mean_force, error, vague)
            told += _of_load(mean_force, uncertainty, error, load, vague)
            values["mean force of stick-slip"] = told
        if behaviour.period is not None:
            beside_forces = period_of(verdict, behaviour.period, uncertainty, bool(error))
            values["period"] = ", ".join(with_period_error(verdict, behaviour) or beside_forces)
        if behaviour.kind == "stick-slip" and behaviour.slips < ENOUGH_SLIPS:
            told = _of_few_slips(behaviour) + still_changing(behaviour.sliders, scale)
            values["slips seen"] = told
        if behaviour.slip_time is not None:
            values["time of a slip"] = written(behaviour.slip_time, scale.time_unit)
        whose = ", infinitely many contacts" * (behaviour.rule in few)
        for name, value in values.items():
            rule = behaviour.rule + _unfinished(behaviour)
            rows.setdefault((name + whose, value), []).append(rule)
    for (name, value), rules in rows.items():
        yield [f"{name} ({', '.join(rules)})", value, "", ""]


def _of_load(
    force: float, uncertainty: float, error: float, load: float | None, vague: bool
) -> str:
    """A force, with its relative uncertainty and its own error, as a part of the load; "" where none is known."""
    if not load:
        return ""
    over = force / load
    return f", {to_digits(over, '', uncertainty * over, error / load, vague)} of the load"


def _of_holding(answer: Answer) -> str:
    """How few contacts bear F_k, where most of them wait."""
    if answer.holding > HOLDING:
        return ""
    return f", with {100.0 * answer.holding:.2g}% of the contacts holding"


def _with_error(value: float, unit: str, uncertainty: float, error: float, vague: bool) -> str:
    """A value with its error, or to the digits that its uncertainty leaves where the error is 0, two if `vague`."""
    return with_scatter(value, error, unit) if error else guarded(value, unit, uncertainty, vague)


def _of_few_slips(behaviour: Behaviour) -> str:
    """How many slips were seen where these are fewer than usual, and why no more are needed."""
    seen, why = f"{behaviour.slips} slip", behaviour.message.partition("; ")[0]
    if why.startswith(seen):
        return why
    whose = f" of each of {SLIDERS} sliders" * (behaviour.contacts is not None)
    return f"{seen}{'s' * (behaviour.slips != 1)}{whose}"


def _unfinished(behaviour: Behaviour) -> str:
    """What to add to the rule of slips that were seen and are not decided: whether the path is cut."""
    if behaviour.kind != "undecided":
        return ""
    return ": path cut" if behaviour.cut else ": not decided"


def drop_of(behaviour: Behaviour) -> float:
    """By how much the spring's force falls in a slip, F/(N_c <k>) (a length); of a mass its first swing."""
    return behaviour.before - behaviour.after


def first_alike(verdict: Verdict, answer: Answer, slider: Behaviour) -> str:
    """The first rule under which as much happens, to what is worth telling or to its errors, and is known as well."""
    error = error_beside(verdict, answer, slider)
    for one in answer.behaviours:
        as_well = sorted([error, error_beside(verdict, answer, one)])
        off = (one.error + slider.error) * answer.contacts.mean_threshold
        least = max(off, WORTH_TELLING * abs(slider.before))
        ends = (one.before, slider.before), (one.after, slider.after)
        as_much = all(abs(a - b) <= least for a, b in ends)
        if one.kind == slider.kind and as_much and as_well[1] <= 2.0 * as_well[0]:
            return one.rule
    return slider.rule


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


def in_units(message: str, scale: Scale, mean: float | None = None) -> str:
    """A solver's message with the positions of the drive, and how long a slip lasts, in the units of the verdict, and
    errors of the force and its tolerance, if `mean`, the mean threshold, is given; without its advice on the path and
    the tolerance, which are the verdict's own: heat may be left out."""
    message = _ADVICE.sub(lambda found: f"; {found[1]}" if found[1] else "", message)
    if "heat is left out beside a mass" in message:
        message += (
            "; leave the temperature out where a sweep over kelvin says that F_k hardly changes"
        )
    if mean is not None and scale.force_unit in PREFIXED:
        unit = mean * scale.force
        message = _ERRORS.sub(
            lambda found: found[1] + written(float(found[2]) * unit, scale.force_unit, digits=2),
            message,
        )
    return with_units_of(scale, message, mean)
