"""The table of a verdict: each number, the scatter of other samples, the spread over the readings."""

import re
from collections.abc import Iterator, Sequence
from itertools import zip_longest

import numpy as np

from toolkit.scene.scale import Scale, guarded, with_uncertainty, written
from toolkit.verdict.answers import Quantity, Verdict
from toolkit.verdict.finite import Finite
from toolkit.verdict.machine import Behaviour

# a drop that is longer by this share than the spring regains over a period: the slider has swung back after the slip
_RUNG = 0.05
# of a number: a larger error of it would be seen in the range over the readings, which has 3 digits
SEEN = 1e-3
# standard errors, and part of F_k, by which few contacts differ from infinitely many where it is told; the scatter of
# four sliders is known to some 40 %
CLEARLY, TOLD = 4.0, 0.01


def share_of(verdict: Verdict) -> float:
    """The widest uncertainty of static and kinetic force, relative: numerical, of other samples, over the readings. It
    decides to how many digits forces, and the periods that follow from them, are written."""
    shares = [0.0]
    for name in ("kinetic", "static"):
        each = [getattr(answer, name) for answer in verdict.answers]
        scaled = [
            one.value * answer.scale.force
            for one, answer in zip(each, verdict.answers, strict=True)
        ]
        if each[0].value > 0.0:
            shares.append((max(scaled) - min(scaled)) / scaled[0])
            shares.append(max(each[0].error, each[0].sampling or 0.0) / each[0].value)
    return max(share for share in shares if np.isfinite(share))


def table(verdict: Verdict) -> list[str]:
    """Each number, the scatter of other samples, and the spread over the readings. Numerical errors are far smaller,
    and stand in verdict.json; a line says how large they are at most."""
    many = len(verdict.answers)
    over = "over the readings" if many > 1 else "one reading only"
    rows = [["", "value", "other samples", over], *_rows(verdict)]
    return in_columns(rows)


def in_columns(rows: Sequence[Sequence[str]], align: str = "<") -> list[str]:
    """Rows of cells as lines of text, each column as wide as its widest cell; short rows end early."""
    widths = [max(map(len, column)) for column in zip_longest(*rows, fillvalue="")]
    padded = ([f"{cell:{align}{n}}" for cell, n in zip(row, widths, strict=False)] for row in rows)
    return ["  ".join(row).rstrip() for row in padded]


def _rows(verdict: Verdict) -> Iterator[list[str]]:
    """The rows of the table below its head."""
    own, answers = verdict.own, verdict.answers
    scale = own.scale
    forces, unit = [one.scale.force for one in answers], scale.force_unit
    kinetic, static = [one.kinetic for one in answers], [one.static for one in answers]
    share = share_of(verdict)
    # contacts that depend on time bear another force where the slider sticks: see `dependence`
    speed = guarded(verdict.velocity, speed_unit(verdict), 0.0)
    at = f" of a rigid slider at {speed}" * bool(own.contacts.in_time)
    yield row(f"kinetic friction F_k{at}", kinetic, forces, unit, share)
    yield row(f"static friction F_s{at}", static, forces, unit, share)
    if scale.load is not None:
        coefficients = [one.scale.force / (one.scale.load or 1.0) for one in answers]
        yield row("friction coefficient F_k/load", kinetic, coefficients, "", share)
        yield row("static coefficient F_s/load", static, coefficients, "", share)
    # a slider that sticks is slower than the drive: of contacts that depend on time K* promises no slip
    name = (
        f"K*, the steepest fall of the force{at}"
        if at
        else "slips at least once below the spring K*"
    )
    if own.smoothed:
        yield [name, "-", "hangs on smoothing", ""]
    elif own.critical_spring.lost:
        yield [name, "not known", "", ""]
    else:
        told = [one for one in answers if not one.critical_spring.lost]
        critical = [one.critical_spring for one in told]
        yield row(name, critical, [one.scale.spring for one in told], scale.spring_unit)
    if own.machine is not None:
        springs = [one.scale.spring for one in answers]
        each = [Quantity(one.machine.spring if one.machine else 0.0, 0.0) for one in answers]
        yield row("the machine's spring K", each, springs, scale.spring_unit)
    if scale.contacts is not None:
        held = [Quantity(one.scale.contacts or 0.0, 0.0) for one in answers]
        yield row("contacts on the area", held, [1.0] * len(held), "")
    yield from _of_slips(verdict)


def row(
    name: str, each: Sequence[Quantity], factors: Sequence[float], unit: str, share: float = 0.0
) -> list[str]:
    """A row: the own reading's value to a digit beyond that which the widest of the three uncertainties leaves, `share`
    of the value or more."""
    if each[0].unknown:
        return [name, "not known", "", ""]
    values = [one.value * factor for one, factor in zip(each, factors, strict=True)]
    own, low, high = each[0], min(values), max(values)
    error, sampling = own.error * factors[0], (own.sampling or 0.0) * factors[0]
    # an infinite K* is apart from a finite one, and not from another
    apart = high - low > 1e-6 * min(abs(low), abs(high))
    off = max(error, sampling, high - low if apart else 0.0, share * abs(values[0]))
    if not np.isfinite(off):
        off = share * abs(values[0])
    ends = [guarded(value, unit, off) for value in (low, high)]
    return [
        name,
        guarded(values[0], unit, off),
        f"± {written(sampling, unit, digits=2)}" if sampling else "not known" * (own.error > 0.0),
        " to ".join(dict.fromkeys(ends)) if apart else "the same" * (len(each) > 1),
    ]


def _of_slips(verdict: Verdict) -> Iterator[list[str]]:
    """Rows of the slips of the own reading; rules that give the same numbers share a row."""
    scale, rows = verdict.own.scale, dict[tuple[str, str], list[str]]()
    force, load = scale.force_unit, scale.load
    for behaviour in verdict.own.behaviours:
        if behaviour.kind == "undecided" and not behaviour.slips:
            rows.setdefault(("slips", "not known"), []).append(behaviour.rule)
        if behaviour.kind == "smooth" or not behaviour.slips:
            continue
        mean, before = verdict.own.contacts.mean_threshold, abs(behaviour.before)
        known = behaviour.error * mean / before if before and behaviour.error < np.inf else 0.0
        share = max(share_of(verdict), known)
        before, drop = (behaviour.before * scale.force, drop_of(behaviour) * scale.force)
        told = {"force before a slip": guarded(before, force, share * before)}
        if load:
            told["force before a slip"] += (
                f", {guarded(before / load, '', share * before / load)} of the load"
            )
        told["drop of a slip"] = guarded(drop, force, share * drop)
        if (regained := regained_by(verdict, behaviour)) is not None:
            told["of it regained over a period"] = guarded(
                regained * scale.force, force, share * regained * scale.force
            )
        if behaviour.period is not None:
            later = behaviour.period / verdict.velocity
            period = guarded(behaviour.period, scale.length_unit, share * behaviour.period)
            told["period"] = f"{period}, {guarded(later, scale.time_unit, share * later)}"
        if behaviour.slip_time is not None:
            told["time of a slip"] = written(behaviour.slip_time, scale.time_unit)
        for row in told.items():
            rows.setdefault(row, []).append(behaviour.rule + _unfinished(behaviour))
    for one, many in of_so_many(verdict):
        row = (f"slips of {many.contacts:,} contacts, from", fall_of(many, scale))
        rows.setdefault(row, []).append(one.rule)
    for (name, value), rules in rows.items():
        yield [f"{name} ({', '.join(rules)})", value, "", ""]


def _unfinished(behaviour: Behaviour) -> str:
    """What to add to the rule of slips that were seen and are not decided: whether the path is cut."""
    if behaviour.kind != "undecided":
        return ""
    return ": path cut" if behaviour.cut else ": not decided"


def of_so_many(verdict: Verdict) -> list[tuple[Behaviour, Finite]]:
    """The rules under which as many contacts as there are slip as infinitely many do, at clearly other forces."""
    pairs = zip(verdict.own.behaviours, verdict.finite, strict=False)
    return [
        (one, many)
        for one, many in pairs
        if one.kind == many.kind == "stick-slip" and not many.message
        if abs(many.before - one.before) > max(SEEN * abs(one.before), 2.0 * many.before_error)
    ]


def late_force_of(finite: Finite, kinetic: float, scale: Scale) -> str:
    """The force that so many contacts bear at the end of the way, where it is not `kinetic`, that of infinitely many,
    F/(N_c <k>) (lengths): on soft springs it is above it by N^(-2/3) <x_s> times 2 to 9, or more (docs/sliders.md)."""
    off = abs(finite.late - kinetic)
    if not off > max(CLEARLY * finite.late_error, TOLD * kinetic):
        return ""
    late = with_uncertainty(
        finite.late * scale.force, finite.late_error * scale.force, scale.force_unit
    )
    still = ", which still rises" * finite.rises
    return f"; at the end they bear {late}{still}, infinitely many {written(kinetic * scale.force, scale.force_unit)}"


def fall_of(finite: Finite, scale: Scale) -> str:
    """The mean forces before and after a slip of so many contacts, with their errors."""
    size = abs(finite.before)
    means = [(finite.before, finite.before_error), (finite.after, finite.after_error)]
    high, low = (
        with_uncertainty(
            mean * scale.force,
            error * scale.force if 1e-9 * size < error < np.inf else 0.0,
            scale.force_unit,
        )
        for mean, error in means
    )
    return falls(high, low, (finite.before - finite.after) * scale.force, scale.force_unit)


def falls(high: str, low: str, drop: float, unit: str) -> str:
    """A force down to another, both as written, with their errors or without; by how much where they are written
    alike."""
    alike = high.partition(" ± ")[0] == low.partition(" ± ")[0]
    return f"{high} down by {written(drop, unit, digits=2)}" if alike else f"{high} down to {low}"


def drop_of(behaviour: Behaviour) -> float:
    """By how much the spring's force falls in a slip, F/(N_c <k>) (a length); of a mass its first swing."""
    return behaviour.before - behaviour.after


def regained_by(verdict: Verdict, behaviour: Behaviour) -> float | None:
    """By how much the spring's force rises over a period, F/(N_c <k>) (a length), where that is clearly less than a
    slip's drop: a mass whose contacts are out swings back before it sticks. None where it is not."""
    machine = verdict.own.machine
    if behaviour.rule != "mass" or behaviour.period is None or machine is None:
        return None
    regained = machine.spring * behaviour.period
    return regained if drop_of(behaviour) > (1.0 + _RUNG) * regained else None


def speed_unit(verdict: Verdict) -> str:
    """ "m/s" where lengths are in metres, else none."""
    return "m/s" if verdict.own.scale.length_unit == "m" else ""


def numerical_errors(verdict: Verdict) -> str:
    """How large the numerical errors of the own reading's numbers are at most, relative to these; and those of other
    readings, which stand in the ranges, where they are larger and would be seen."""
    own = verdict.own
    told = not (own.smoothed or own.critical_spring.lost)
    known = [own.kinetic, own.static, *([own.critical_spring] if told else [])]
    relative = [_relative(one) for one in known]
    for behaviour in own.behaviours:
        if np.isfinite(behaviour.error) and behaviour.before:
            mean = own.contacts.mean_threshold
            relative.append(behaviour.error * mean / abs(behaviour.before))
    what = "numerical errors"
    if any(one.sampling for one in known):
        what = "without the scatter of other samples, errors"
    most = max(relative)
    worse = "".join(f"; {one}" for one in _less_known(verdict, max(most, SEEN)))
    return f"{what} are at most {most:.0e} of these numbers{worse} (verdict.json has each)"


def _relative(quantity: Quantity) -> float:
    """The error of a number, relative to it; 0 for one that is 0 or infinite."""
    known = quantity.value and np.isfinite(quantity.value)
    return quantity.error / abs(quantity.value) if known else 0.0


def _less_known(verdict: Verdict, most: float) -> Iterator[str]:
    """The numbers of other readings with a larger relative error than that, in words, and each K* that is not known."""
    if verdict.own.critical_spring.lost and not verdict.own.smoothed:
        yield "but K*, whose error is as large as itself, is not known"
    for answer in verdict.answers[1:]:
        scale = answer.scale
        for name, one, factor, unit in (
            ("F_k", answer.kinetic, scale.force, scale.force_unit),
            ("F_s", answer.static, scale.force, scale.force_unit),
            ("K*", answer.critical_spring, scale.spring, scale.spring_unit),
        ):
            if one is answer.critical_spring and one.lost:
                yield f"but K* of {answer.name}, whose error is as large as itself, is not known"
            elif _relative(one) > most:
                error = written(one.error * factor, unit, digits=2)
                yield f"but {name} of {answer.name}, in the range, is {written(one.value * factor, unit)} ± {error}"


def in_units(message: str, scale: Scale) -> str:
    """A solver's message with the positions of the drive, and how long a slip lasts, in the units of the verdict."""
    if scale.length_unit != "m":
        return message
    for before, unit in (("X_T = ", scale.length_unit), ("lasts some ", scale.time_unit)):
        for number in re.findall(rf"{before}(\d[\d.]*(?:e[+-]?\d+)?)", message):
            told = written(float(number), unit)
            message = message.replace(f"{before}{number}", f"{before}{told}")
    return message
