"""What the contacts of the area do where that is not what infinitely many do: they slip or slide otherwise, or at
clearly other forces."""

import re
from collections.abc import Iterator

import numpy as np

from toolkit.scene.scale import Scale, guarded, with_scatter, written
from toolkit.verdict.answers import Verdict
from toolkit.verdict.finite import SMALL, Finite
from toolkit.verdict.machine import Behaviour
from toolkit.verdict.uncertainty import SEEN, share_of

# standard errors, and part of F_k, by which few contacts differ from infinitely many where it is told; the scatter of
# four sliders is known to some 40 %
CLEARLY, TOLD = 4.0, 0.01


def disagreeing(verdict: Verdict) -> list[tuple[Behaviour, Finite]]:
    """The rules under which as many contacts as there are do something else than infinitely many."""
    return [(one, many) for one, many in _pairs(verdict) if _kinds_differ(verdict, one, many)]


def apart(verdict: Verdict) -> dict[str, Finite]:
    """What as many contacts as there are do, by the rules under which that is something else than what infinitely many
    do, or the same at forces that differ by more than the errors of both."""
    return {
        one.rule: many
        for one, many in _pairs(verdict)
        if _kinds_differ(verdict, one, many)
        or _slips_differ(verdict, one, many)
        or _slides_apart(many, verdict.own.kinetic.value, _error_of(verdict, one))
    }


def _pairs(verdict: Verdict) -> Iterator[tuple[Behaviour, Finite]]:
    """Rules that are decided for both, infinitely many contacts and as many as there are; not where fewer were
    followed, which say so: their forces are further from those of infinitely many."""
    for one, many in zip(verdict.own.behaviours, verdict.finite, strict=False):
        if one.kind != "undecided" and many.kind != "unknown" and not many.message:
            yield one, many


def _kinds_differ(verdict: Verdict, one: Behaviour, many: Finite) -> bool:
    """Falls below SMALL mean thresholds are no slips of the slider."""
    small = SMALL * verdict.own.contacts.mean_threshold
    return one.kind != many.kind and not many.before - many.after < small


def _slips_differ(verdict: Verdict, one: Behaviour, many: Finite) -> bool:
    """Whether all the contacts of the area slip as infinitely many do, and from a clearly other force."""
    if not one.kind == many.kind == "stick-slip":
        return False
    known = max(SEEN * abs(one.before), _error_of(verdict, one), 2.0 * many.before_error)
    return abs(many.before - one.before) > known


def _slides_apart(many: Finite, kinetic: float, error: float = 0.0) -> bool:
    """Whether contacts that re-form at once bear clearly more at the end of the way than infinitely many, `kinetic`
    with its numerical `error` (lengths): on soft springs by N^(-2/3) <x_s> times 2 to 9, or more (docs/sliders.md)."""
    known = max(CLEARLY * many.late_error, TOLD * kinetic, error)
    return bool(abs(many.late - kinetic) > known)


def _error_of(verdict: Verdict, one: Behaviour) -> float:
    """The numerical error of a behaviour's forces, a length; 0 where it is not known."""
    return one.error * verdict.own.contacts.mean_threshold if one.error < np.inf else 0.0


def counted(verdict: Verdict, many: Finite) -> str:
    """These contacts by their number, and whose they are."""
    whose = "of the area" if verdict.own.scale.contacts is not None else "of [eq]"
    return f"the {many.contacts:,} contacts {whose}"


def behaved(verdict: Verdict, many: Finite) -> str:
    """What so many contacts do, with their own forces and errors."""
    scale = verdict.own.scale
    if many.kind == "smooth" or (many.kind == "now and then" and np.isfinite(many.late)):
        if not np.isfinite(many.late):
            return "smooth"
        force = sliding_force(many, scale)
        return f"smooth, at {force} and still rising" if many.rises else f"smooth at {force}"
    if many.kind == "now and then":
        return f"slips now and then, from {fall_of(many, scale)}"
    said = f"stick-slip: {fall_of(many, scale)}"
    if many.period is None:
        return said
    every, later = period_of(verdict, many.period)
    speed = written(verdict.velocity, "m/s" if scale.length_unit == "m" else "")
    return f"{said} every {every}, {later} at {speed}"


def period_of(verdict: Verdict, period: float, share: float = 0.0) -> tuple[str, str]:
    """A period of the drive as a length and as a time, known to `share` of itself or worse."""
    scale, share = verdict.own.scale, max(share, share_of(verdict))
    later = period / verdict.velocity
    return (
        guarded(period, scale.length_unit, share * period),
        guarded(later, scale.time_unit, share * later),
    )


def rows_of(verdict: Verdict, many: Finite) -> dict[str, str]:
    """The numbers of so many contacts for the table, by their names."""
    scale, whose = verdict.own.scale, f"{many.contacts:,} contacts"
    over = (
        f", {written(many.late * scale.force / scale.load, '')} of the load" if scale.load else ""
    )
    if np.isfinite(many.late) and many.kind != "stick-slip":
        still = ", still rising" * many.rises
        return {f"sliding force of {whose}": f"{sliding_force(many, scale)}{still}{over}"}
    if not np.isfinite(many.before):
        return {f"slips of {whose}": "none"}
    rows = {f"slips of {whose}, from": fall_of(many, scale)}
    if many.kind == "stick-slip" and many.period is not None:
        rows[f"period of {whose}"] = ", ".join(period_of(verdict, many.period))
    return rows


def sliding_force(many: Finite, scale: Scale) -> str:
    """The force at the end of the way, with its error."""
    late, error = many.late * scale.force, many.late_error * scale.force
    return with_scatter(late, error, scale.force_unit)


def late_force_of(finite: Finite, kinetic: float, scale: Scale) -> str:
    """The force that so many contacts bear at the end of the way, where it is not `kinetic`, that of infinitely many,
    F/(N_c <k>) (lengths)."""
    if not _slides_apart(finite, kinetic):
        return ""
    still = ", which still rises" * finite.rises
    beside = written(kinetic * scale.force, scale.force_unit)
    return f"; at the end they bear {sliding_force(finite, scale)}{still}, infinitely many {beside}"


def fall_of(finite: Finite, scale: Scale) -> str:
    """The mean forces before and after a slip of so many contacts, with their errors."""
    size = abs(finite.before)
    means = [(finite.before, finite.before_error), (finite.after, finite.after_error)]
    high, low = (
        with_scatter(
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
    alike = re.sub(r" ± \S+", "", high) == re.sub(r" ± \S+", "", low)
    return f"{high} down by {written(drop, unit, digits=2)}" if alike else f"{high} down to {low}"
