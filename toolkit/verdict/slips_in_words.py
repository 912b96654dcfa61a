"""Slips and force of so many contacts as written: means with their errors, and how they differ along the way."""

import re
from collections.abc import Sequence

import numpy as np

from toolkit.results.slips import QUARTERED, Spread
from toolkit.scene.scale import (
    Scale,
    guarded,
    prefixed_like,
    rounded_up,
    told_contacts,
    with_scatter,
    written,
)
from toolkit.verdict.answers import Answer, Verdict
from toolkit.verdict.sliders.budget import HOW_TO_GIVE_MORE_TIME
from toolkit.verdict.sliders.late import EVER_RARER, SLIDERS, shrinking
from toolkit.verdict.sliders.records import Behaviour, Finite
from toolkit.verdict.uncertainty import TOLD_FROM, is_vague, widest_uncertainty

# part of a force by which slips, or forces along the way, differ where it is told
WORTH_SHOWING = 0.01
# of a mean: a standard deviation from slip to slip above which the range is told, as slips may be of several kinds
WIDE = 0.3
# times an error of the mean: no larger a scatter is told beside it, of so few slips that they are one and the same
NO_MORE = 1.1


def does(finite: Finite) -> str:
    """What so many contacts do, in the same words wherever it is told."""
    return "slips now and then" if finite.kind == "now and then" else finite.kind


def kind_of_trace(behaviour: Behaviour) -> str:
    """What a trace shows, in words; of one that ends early, that it does."""
    if behaviour.kind == "smooth" and behaviour.swings and behaviour.shrinks_by:
        return "slips that die out, smooth in the end"
    if behaviour.kind != "undecided":
        return behaviour.kind
    if behaviour.few_break is not None:
        return "no stick-slip, falls of few contacts"
    return "not decided, the path is cut" if behaviour.cut else "not decided"


def after_slips(slips: float) -> str:
    """After how many slips of a slider, on average, it slides; "" for one, with which the first loading ends."""
    return f" after {slips:,.0f} slips" if slips >= 1.5 else ""


def swinging(answer: Answer, slider: Behaviour) -> str:
    """Between which forces a smooth slider still swings where its path ends, after how many slips, where these are not
    told elsewhere, and delays of its contacts; "" where it hardly does."""
    if slider.swings is None or answer.machine is None or not slider.drive.size:
        return ""
    scale, way = answer.scale, float(slider.drive[-1])
    top = max(map(abs, slider.swings)) * scale.force
    low, high = (prefixed_like(end * scale.force, top, scale.force_unit) for end in slider.swings)
    slips = "" if slider.shrinks_by else after_slips(slider.slips)
    width = np.ptp(slider.swings) * scale.force
    how = f"between {low} and {high}"
    if low == high:
        how = f"by {_short(width, scale.force_unit)}"
    said = f"{slips}, still swinging {how} after {_short(way, scale.length_unit)} of the drive"
    waits = answer.machine.velocity * answer.contacts.waiting_time
    return f"{said}, {way / waits:,.3g} delays of its contacts" if 0.0 < waits < way else said


def of_fluctuations(verdict: Verdict, slider: Behaviour) -> str:
    """How the force of the area's contacts fluctuates where they slide as smoothly as infinitely many, beside a mass,
    whose own mean is not told; "" where it hardly does, or still swings."""
    few = [one for one in verdict.finite if one.rule == slider.rule and one.kind == "smooth"]
    if not few or np.isfinite(few[0].late) or slider.swings is not None:
        return ""
    scale, fluctuation = verdict.own.scale, few[0].fluctuation
    if not fluctuation >= WORTH_SHOWING * abs(slider.before):
        return ""
    force = abs(slider.before) * scale.force
    said = prefixed_like(fluctuation * scale.force, force, scale.force_unit)
    return f", fluctuating by ± {said} with {told_contacts(few[0].contacts)}"


def seen_slips(slider: Behaviour, fall: str) -> str:
    """What is told of a slider that slips and of which it is not decided what follows, `fall` being the forces of the
    last slip; or whose slips are of so few contacts that they are none of the slider."""
    if slider.few_break is not None:
        share = f"at most {100.0 * slider.few_break:.2g}% of the contacts break"
        return f"no stick-slip, as {share} in each of {slider.slips:,} falls, the last from {fall},"
    seen = "a slip was seen"
    if slider.slips != 1:
        seen = f"{slider.slips} slips were seen{shrinking(slider)}, the last"
    few = slider.finite.message if slider.finite else ""
    longer = f"; {HOW_TO_GIVE_MORE_TIME}" * ("wall_time" in slider.message + few)
    return f"not decided: {seen} from {fall}, and whether it goes on is not known{longer}"


def left_out(each: Finite | Behaviour) -> str:
    """How many smaller slips the means leave out, of how many of all sliders; "" where none."""
    if not each.smaller:
        return ""
    if isinstance(each, Finite):
        slips = round(each.slips * SLIDERS) + each.smaller
    else:
        slips = each.slips
    return f", without {each.smaller:,} of {slips:,} slips, below a fifth of the largest"


def still_changing(finite: Finite | None, scale: Scale) -> str:
    """That few slips still grow, or shrink, from one to the next, with the forces before them in order; "" where they
    do not, or where that is not clear."""
    each = finite.still_changing if finite is not None else ()
    if not each:
        return ""
    what, unit = "growing" if each[-1] > each[0] else "shrinking", scale.force_unit
    return f", still {what}: {', '.join(written(one * scale.force, unit) for one in each)}"


def plain_fall(finite: Finite, force: float, unit: str) -> str:
    """The forces before and after a slip of so many contacts, without errors; "" where they slide."""
    if not np.isfinite(finite.after):
        return ""
    ends = (finite.before, finite.before_error), (finite.after, finite.after_error)
    high, low = (written(end * force, unit, error * force) for end, error in ends)
    return falls(high, low, (finite.before - finite.after) * force, unit)


def scatters(finite: Finite) -> bool:
    """Whether the force of so many contacts, or their slips, differ along the path by WORTH_SHOWING of the mean."""
    if finite.kind == EVER_RARER:
        return True
    if finite.kind != "stick-slip":
        return finite.fluctuation >= WORTH_SHOWING * abs(finite.late)
    each = (
        (finite.befores, finite.before),
        (finite.drops, finite.before),
        (finite.periods, finite.period),
    )
    return any(
        one is not None and one.std >= WORTH_SHOWING * abs(mean or 0.0) for one, mean in each
    )


def fluctuating(finite: Finite, scale: Scale) -> str:
    """The standard deviation of the force of so many contacts that slide, along the path, and no error of the mean; ""
    where it is small."""
    if not scatters(finite) or finite.kind == "stick-slip":
        return ""
    between = " between slips" * (finite.kind == EVER_RARER)
    force = abs(finite.late if np.isfinite(finite.late) else finite.fluctuation) * scale.force
    said = prefixed_like(finite.fluctuation * scale.force, force, scale.force_unit)
    return f", fluctuating by ± {said}{between}"


def _scatter(each: Spread | None, error: float, like: float, unit: str, factor: float = 1.0) -> str:
    """How a number differs from slip to slip, in brackets: by its standard deviation, or where that is WIDE of the mean
    by the range, as slips of several kinds have no scatter about a mean; "" where it is below WORTH_SHOWING of `like`,
    the number that it stands behind, with whose prefix it is written, or no more than its `error`, which is told."""
    hidden = WORTH_SHOWING * abs(like)
    if each is None or each.std < max(hidden, min(WIDE * abs(each.mean), NO_MORE * error)):
        return ""
    if each.std <= WIDE * abs(each.mean):
        return f" (scatter ± {prefixed_like(each.std * factor, like * factor, unit)})"
    ends = " to ".join(
        prefixed_like(one * factor, like * factor, unit) for one in (each.low, each.high)
    )
    return f" ({'half of them ' * (each.number >= QUARTERED)}{ends})"


def period_with_scatter(verdict: Verdict, finite: Finite) -> tuple[str, str]:
    """The mean period of so many contacts as a length and as a time, each with its error, and the former with the
    scatter from slip to slip, where it is WORTH_SHOWING of it or more."""
    period, error = finite.period or np.nan, finite.period_error
    known = 0.0 < error < np.inf
    every, later = _with_error(verdict, period, error) if known else period_of(verdict, period)
    unit = verdict.own.scale.length_unit
    return every + _scatter(finite.periods, error if known else 0.0, period, unit), later


def _with_error(verdict: Verdict, period: float, error: float) -> tuple[str, str]:
    """A period of the drive as a length and as a time, each with this error (a length)."""
    scale = verdict.own.scale
    units = (1.0, scale.length_unit), (1.0 / verdict.velocity, scale.time_unit)
    every, later = (with_scatter(period * one, error * one, unit) for one, unit in units)
    return every, later


def ever_rarer(verdict: Verdict, finite: Finite, whose: str) -> str:
    """That slips get ever rarer and end in smooth sliding, with its force; how many of them there were, how far apart,
    and late ones as the means of these."""
    own, scale, fewer = verdict.own, verdict.own.scale, finite.rarer
    if fewer is None or own.machine is None:
        return does(finite)
    borne = own.machine.damping * own.machine.velocity
    force, part = (
        written(one * scale.force, scale.force_unit) for one in (own.kinetic.value + borne, borne)
    )
    way = _short(fewer.way, scale.length_unit)
    beside = fluctuating(finite, scale)
    seen = f"{fewer.slips:,.0f} slips a slider over {way}, {spacings(finite, scale)}"
    end = f"smooth in the end at {force} ({part} of it borne by the damping){beside}"
    return f"slips ever rarer, {end}: {seen}, late ones from {fall_of(finite, scale)} {whose}{left_out(finite)}"


def spacings(finite: Finite, scale: Scale) -> str:
    """How slips get ever rarer along the way; "" where they do not."""
    if finite.rarer is None:
        return ""
    first, last = (
        _short(one, scale.length_unit) for one in (finite.rarer.first, finite.rarer.last)
    )
    return f"every {first} in the first third of the way and every {last} in the last"


def _short(value: float, unit: str) -> str:
    """A number with two digits, as a scatter is known to a tenth at best."""
    return written(float(f"{value:.1e}"), unit, digits=2)


def period_of(
    verdict: Verdict, period: float, uncertainty: float = 0.0, to_error: bool = False
) -> tuple[str, str]:
    """A period of the drive as a length and as a time, known to `uncertainty` of itself, or worse; `to_error` :
    to the digit of that, which stands beside the forces."""
    scale, uncertainty = verdict.own.scale, max(uncertainty, widest_uncertainty(verdict))
    vague = is_vague(verdict)
    each = (period, scale.length_unit), (period / verdict.velocity, scale.time_unit)
    every, later = (
        written(one, unit, uncertainty * one, digits=4)
        if to_error
        else guarded(one, unit, uncertainty * one, vague)
        for one, unit in each
    )
    return every, later


def with_period_error(verdict: Verdict, behaviour: Behaviour) -> tuple[str, str] | None:
    """The period of the drive as a length and as a time, each with its error; None where that is less than TOLD_FROM of
    it, or than the widest uncertainty of the forces."""
    period, error = behaviour.period or 0.0, behaviour.period_error
    hidden = max(TOLD_FROM, widest_uncertainty(verdict)) * period
    return _with_error(verdict, period, error) if hidden < error < np.inf else None


def periods(
    verdict: Verdict, alike: Sequence[Behaviour], uncertainty: float, to_error: bool
) -> str:
    """The periods of those that slip alike, the smallest and the largest where they differ as written, as lengths and
    as times; "" where none is known. `uncertainty` and `to_error` as `period_of` takes them."""
    known = {one.period: one for one in alike if one.period is not None}
    ends = [
        with_period_error(verdict, known[period])
        or period_of(verdict, period, uncertainty, to_error)
        for period in (sorted(known)[:1] + sorted(known)[-1:])
    ]
    return ", ".join(" to ".join(dict.fromkeys(each)) for each in zip(*ends, strict=True))


def sliding_force(finite: Finite, scale: Scale) -> str:
    """The force at the end of the way, with its error."""
    late, error = finite.late * scale.force, finite.late_error * scale.force
    return with_scatter(late, error, scale.force_unit)


def fall_of(finite: Finite, scale: Scale) -> str:
    """The mean forces before and after a slip of so many contacts, with their errors and their scatter; the fall in
    place of the force after it where that scatters by itself."""
    size, unit, factor = abs(finite.before), scale.force_unit, scale.force
    means = [(finite.before, finite.before_error), (finite.after, finite.after_error)]
    high, low = (
        with_scatter(mean * factor, error * factor if 1e-9 * size < error < np.inf else 0.0, unit)
        for mean, error in means
    )
    drop = (finite.before - finite.after) * factor
    each = (finite.befores, finite.before_error), (finite.drops, 0.0)
    scatter = [_scatter(*one, size, unit, factor) for one in each]
    if scatter[1] and finite.after and finite.drops is not None:
        # slips of one kind have a mean; of several kinds it is no more than a size
        one_kind = "±" in scatter[1]
        # as many places as the scatter beside it, which has two digits
        own = written(drop, unit, 0.1 * finite.drops.std * factor, 4)
        fall = own if one_kind else _short(drop, unit)
        return f"{high}{scatter[0]} down by {fall}{scatter[1]}"
    return falls(high, low, drop, unit, scatter[0])


def hidden_by(error: float, forces: Sequence[float], unit: str) -> str:
    """Forces after slips that are all within this error of 0, by the largest that they may be; "" where one is not."""
    largest = max(map(abs, forces))
    most = written(rounded_up(largest + error), unit, digits=1)
    return f"less than {most}" if 0.0 < largest < error else ""


def falls(high: str, low: str, drop: float, unit: str, scatter: str = "") -> str:
    """A force down to another, both as written, with their errors or without; by how much where they are written
    alike. The `scatter` of the former stands behind it."""
    same = re.sub(r" ± \S+", "", high) == re.sub(r" ± \S+", "", low)
    end = f"by {written(drop, unit, digits=2)}" if same else f"to {low}"
    return f"{high}{scatter} down {end}"
