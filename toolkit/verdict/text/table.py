"""The table of a verdict: each number, the scatter of other samples, the spread over the readings."""

import re
from collections.abc import Callable, Iterator, Sequence
from itertools import zip_longest

import numpy as np

from toolkit.scene.messages import with_units_of
from toolkit.scene.scale import PREFIXED, Scale, guarded, in_three_digits, prefixed_like, written
from toolkit.verdict.answers import Answer, Quantity, Verdict
from toolkit.verdict.sliders.records import Behaviour
from toolkit.verdict.text.k_star import of_chance, of_critical_spring
from toolkit.verdict.text.slip_rows import SLIPS_SEEN, TIME_OF_A_SLIP, rows_of_slips
from toolkit.verdict.text.spread import other_samples
from toolkit.verdict.uncertainty import (
    VAGUE,
    WORTH_TELLING,
    error_beside,
    widest_uncertainty,
    writer_of_springs,
)

# of the contacts: where no more of them hold, F_k is told with their share
HOLDING = 0.9
# in the column of other samples, where these would change a number, and nobody knows by how much
NOT_RESAMPLED = "not resampled"
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
    if own.machine is None and (chance := of_chance(own)):
        # beside a machine a line tells whether its own spring is among these
        yield [f"{chance[0]} may slip by chance up to about", chance[1], "", ""]
    if own.machine is not None:
        springs = [one.scale.spring for one in answers]
        each = [Quantity(one.machine.spring if one.machine else 0.0, 0.0) for one in answers]
        yield row("the machine's spring K", each, springs, scale.spring_unit)
    if scale.contacts is not None:
        numbers = [one.scale.contacts or 0.0 for one in answers]
        ends = dict.fromkeys(in_three_digits(end) for end in (min(numbers), max(numbers)))
        range_text = " to ".join(ends) if len(ends) > 1 else "the same" * (len(numbers) > 1)
        # as in sentences, which name the number of those that are followed
        yield ["contacts on the area", in_three_digits(numbers[0]), "", range_text]
    resampled = bool(own.kinetic.sampling)
    for name, value, *_ in rows_of_slips(verdict):
        seen = name.startswith((SLIPS_SEEN, TIME_OF_A_SLIP))
        yield [name, value, NOT_RESAMPLED if resampled and not seen else "", ""]


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
        f"± {prefixed_like(sampling, values[0], unit)}"
        if sampling
        else "not known" * (own.error > 0.0),
        " to ".join(dict.fromkeys(ends)) if apart else "the same" * (len(each) > 1),
    ]


def _of_holding(answer: Answer) -> str:
    """How few contacts bear F_k, where most of them wait."""
    if answer.holding > HOLDING:
        return ""
    return f", with {100.0 * answer.holding:.2g}% of the contacts holding"


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
