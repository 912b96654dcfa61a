"""The table of a verdict: each number, the scatter of other samples, the spread over the readings."""

from collections.abc import Iterator, Sequence

import numpy as np

from toolkit.scene.scale import written
from toolkit.verdict.judge import Quantity, Verdict


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
    share = share_of(verdict)
    yield _row("kinetic friction F_k", kinetic, forces, unit, share)
    yield _row("static friction F_s", static, forces, unit, share)
    if scale.load is not None:
        coefficients = [one.scale.force / (one.scale.load or 1.0) for one in answers]
        yield _row("friction coefficient F_k/load", kinetic, coefficients, "", share)
        yield _row("static coefficient F_s/load", static, coefficients, "", share)
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


def _row(
    name: str, each: Sequence[Quantity], factors: Sequence[float], unit: str, share: float = 0.0
) -> list[str]:
    """A row: the own reading's value to the digit that the widest of the three uncertainties leaves, `share` of the
    value or more."""
    values = [one.value * factor for one, factor in zip(each, factors, strict=True)]
    own, spread = each[0], max(values) - min(values)
    error, sampling = own.error * factors[0], (own.sampling or 0.0) * factors[0]
    apart, off = (
        spread > 1e-6 * abs(values[0]),
        max(error, sampling, spread, share * abs(values[0])),
    )
    if not np.isfinite(off):
        off = share * abs(values[0])
    ends = [written(value, unit, off) for value in (min(values), max(values))]
    return [
        name,
        written(values[0], unit, off),
        f"± {written(sampling, unit)}" if sampling else "not known" * (own.error > 0.0),
        " to ".join(dict.fromkeys(ends)) if apart else "the same",
    ]


def _of_slips(verdict: Verdict) -> Iterator[list[str]]:
    """Rows of the slips of the own reading; rules that give the same numbers share a row."""
    scale, rows = verdict.own.scale, dict[tuple[str, str], list[str]]()
    share = share_of(verdict)
    for behaviour in verdict.own.behaviours:
        if behaviour.kind != "stick-slip":
            continue
        drop = (behaviour.before - behaviour.after) * scale.force
        told = {"drop of a slip": written(drop, scale.force_unit, share * abs(drop))}
        if behaviour.period is not None:
            later = behaviour.period / verdict.velocity
            period = written(behaviour.period, scale.length_unit, share * behaviour.period)
            seconds = written(later, scale.time_unit, share * later)
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
