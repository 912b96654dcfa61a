"""The verdict as text: the sentence, its numbers, and what the sentence hangs on."""

from collections.abc import Sequence

import numpy as np

from toolkit.scene.barriers import of_cold
from toolkit.scene.scale import guarded, spoken, with_scatter
from toolkit.verdict.answers import Answer, Verdict
from toolkit.verdict.of_area import behaved, disagreeing, finite_told_apart, subject, verb, whom_of
from toolkit.verdict.sliders.late import EVER_RARER, shrinking
from toolkit.verdict.sliders.records import Behaviour
from toolkit.verdict.slips_in_words import (
    does,
    falls,
    hidden_by,
    left_out,
    of_fluctuations,
    periods,
    plain_fall,
    seen_slips,
    still_changing,
    swinging,
)
from toolkit.verdict.text.above_static import why_above
from toolkit.verdict.text.border import on_the_border
from toolkit.verdict.text.doubts import warnings
from toolkit.verdict.text.hangs_on import on_the_page, why_smooth
from toolkit.verdict.text.k_star import without_spring
from toolkit.verdict.text.kinds import (
    a_slip,
    in_a_word,
    larger_slips,
    long_delay_of,
    lost_with_mass,
    named,
    not_decided,
    of_damping,
    others,
    what_decides,
    without_delay,
)
from toolkit.verdict.text.of_delay import delay_decides, of_extremes, would_swing
from toolkit.verdict.text.of_heat import of_small_falls, stability, way_to
from toolkit.verdict.text.over_load import of_spread
from toolkit.verdict.text.slip_rows import drop_of, past_peak
from toolkit.verdict.text.spread import other_samples, widest
from toolkit.verdict.text.table import first_alike, table
from toolkit.verdict.text.undone import against_k_star, cause, followed_instead, undecided_readings
from toolkit.verdict.uncertainty import (
    assumed_share,
    error_beside,
    is_vague,
    numerical_errors,
    of_assumed_damping,
    once_over,
    sliding_force_of,
    to_digits,
    unsure_of_springs,
    widest_uncertainty,
)


def page(verdict: Verdict) -> list[str]:
    """The verdict on one page: title, doubts about the input, sentence, numbers, table, what it hangs on, run time."""
    early = ["interrupted; this is what was known by then"] * (verdict.stopped is not None)
    lines = [verdict.title, "", *early, *warnings(verdict), sentence(verdict)]
    beside = (*turned(verdict), *would_swing(verdict), *details(verdict))
    lines += [*(f"  {line}" for line in beside), ""]
    lines += [*table(verdict), *of_spread(verdict), *other_samples(verdict), *why_above(verdict)]
    lines += [*why_smooth(verdict), *against_k_star(verdict), ""]
    lines += numerical_errors(verdict)
    if assumed := on_the_page(verdict):
        lines += ["", "What it hangs on", *(f"  {line}" for line in assumed)]
    return [*lines, "", f"run time {verdict.run_time:.1f} s"]


def sentence(verdict: Verdict) -> str:
    """The answer in one short sentence; where the number of contacts, readings or rules disagree, what decides; how
    many readings it is not known of; and that islands are told without the heat that would break them."""
    said = [_answered(verdict), *on_the_border(verdict), *unsure_of_springs(verdict.own)]
    return "; ".join([*said, *undecided_readings(verdict), *of_cold(verdict.own.contacts)])


def _answered(verdict: Verdict) -> str:
    """What the sentence says of the readings that were decided. The first of these that holds: contacts of the area do
    something else than infinitely many; a mass is not decided but at both extremes of the delay; readings or rules
    differ in kind; else what the own reading says by its rules."""
    own = verdict.own
    if own.machine is None:
        return without_spring(verdict)
    if said := _disagreement(verdict) or of_extremes(verdict):
        return "; ".join([said, *_by_others(verdict)])
    if decides := what_decides(verdict):
        return f"{decides}: {', '.join(_kinds(verdict))}"
    return "; ".join(_by_rules(verdict, own))


def details(verdict: Verdict) -> list[str]:
    """The numbers of what the sentence says in kinds alone; none where it gives them itself."""
    numbers = _by_rules(verdict, verdict.own) if verdict.own.machine is not None else []
    return [] if _answered(verdict) == "; ".join(numbers) else [*numbers, *_at_extremes(verdict)]


def _at_extremes(verdict: Verdict) -> list[str]:
    """The numbers of a slider with mass that is not decided with its contacts' delay at both extremes."""
    own, told = verdict.own, list[str]()
    for one in own.extremes:
        how = f"only after {spoken(one.delay, own.scale.time_unit)}" if one.delay else "at once"
        does = _behaved(verdict, own, one.kind, [one])
        told.append(f"contacts that form again {how} would make it {does}")
    return told


def turned(verdict: Verdict) -> list[str]:
    """With which delay of the contacts a slider with mass would do something else, where that is known."""
    own, other = verdict.own, verdict.turned
    seen = any(one.kind == "undecided" and one.slips for one in own.behaviours)
    if other is None or own.machine is None or not (delay_decides(verdict) or seen):
        return []
    slip = spoken(a_slip(own)[0], own.scale.time_unit)
    whose = "at once"
    if not own.contacts.waiting_time:
        whose = f"only once a slip is over, which takes some {slip},"
    does, tells = _behaved(verdict, own, other.kind, [other]), ", as a slider without mass tells"
    if other.kind == "smooth" and other.contacts is None and own.scale.contacts is not None:
        tells = ", as infinitely many contacts of a slider without mass tell"
    if other.kind == "stick-slip" and other.rule != "mass":
        # its forces and its period are those of no slider with mass
        ask = "leave [contacts.delay] out" if own.contacts.waiting_time else "give [contacts.delay]"
        does, tells = other.kind, f"{tells}; {ask} for the forces and the period with the mass"
    if other.rule == "mass":
        late = spoken(long_delay_of(own), own.scale.time_unit)
        whose, tells = f"only after {late}", ""
    # it is followed so, as heat and a mass with another delay would take minutes
    cold = ", without heat" * (own.contacts.thermal is not None)
    return [f"contacts that form again {whose} would make it {does}{cold}{tells}"]


def _kinds(verdict: Verdict) -> list[str]:
    """What happens under which rule of the own reading, else by that reading and by the others."""
    groups = _groups(verdict)
    if lost_with_mass(verdict.own):  # which stands before all this
        del groups["not decided"]
    if len(groups) > 1:
        own = [f"{kind} if {_rules(alike)}" for kind, alike in groups.items()]
    else:
        own = [f"{kind} by {verdict.own.name}" for kind in groups]
    return own + _by_others(verdict)


def _by_others(verdict: Verdict) -> list[str]:
    """How many of the other readings say something else than the scene's own, by what they say."""
    many = len(verdict.answers) - 1
    each = f" of {many} other readings" if many > 1 else " other reading"
    return [f"{kind} by {len(names)}{each}" for kind, names in others(verdict).items()]


def _rules(alike: Sequence[Behaviour]) -> str:
    return named([one.rule for one in alike])


def _disagreement(verdict: Verdict) -> str:
    """The headline where the number of contacts decides, that of the user's machine first, but for rules with larger
    slips; "" where it does not."""
    differ = disagreeing(verdict)
    if not differ:
        return ""
    kinds, unit = {finite.kind for _, finite in differ}, verdict.own.scale.force_unit
    finite, force = differ[0][1], verdict.own.scale.force
    said = verb(kinds)
    every = len(differ) == len(verdict.own.behaviours)
    where = "" if every else f" if {_rules([one for one, _ in differ])}"
    falls_of = {plain_fall(one, force, unit) for _, one in differ}
    if len(falls_of) == len(kinds) == 1 and all(falls_of):  # else the lines below tell them
        said += f", from {falls_of.pop()}"
    other = verb(infinite := {one.kind for one, _ in differ})
    sliding = {sliding_force_of(verdict, verdict.own, one) * force for one, _ in differ}
    off, vague = widest_uncertainty(verdict), is_vague(verdict)
    at = {guarded(one, unit, off * one, vague) for one in sliding}
    if infinite == {"smooth"} and len(at) == 1:
        other += f" at {at.pop()}"
    said = f"{subject(finite)} {said}{where}"
    each = [*larger_slips(verdict, differ), said, f"disagree: infinitely many would {other}"]
    return "; ".join(each)


def _groups(verdict: Verdict) -> dict[str, list[Behaviour]]:
    """The rules by what happens under them, in words: of the area's contacts where these slip now and then."""
    groups, few = dict[str, list[Behaviour]](), finite_told_apart(verdict)
    rare = {rule: does(finite) for rule, finite in few.items() if finite.kind == "now and then"}
    for one in verdict.own.behaviours:
        groups.setdefault(rare.get(one.rule, in_a_word(one)), []).append(one)
    return groups


def _by_rules(verdict: Verdict, answer: Answer) -> list[str]:
    """What the rules say under one reading, with its numbers. Of those that are not decided the first says why, as
    others may be followed in its place; `dependence` has the reasons of all."""
    groups = dict[tuple[str, str, str, str], list[Behaviour]]()
    first, few = answer.behaviours[0], finite_told_apart(verdict) if answer is verdict.own else {}
    for one in answer.behaviours:
        # of those that are decided rules whose slips, or the errors of their forces, differ are told apart
        seen = first_alike(verdict, answer, one)
        if one.kind == "undecided":
            seen = one.rule if one.slips else "first" if one.message == first.message else ""
        of_area = behaved(verdict, few[one.rule]) if one.rule in few else ""
        of_area += followed_instead(answer, one)
        key = (one.kind, seen, of_area, whom_of(verdict, one))
        groups.setdefault(key, []).append(one)
    parts = list[str]()
    # last what is told of slips that are none of the slider
    each = sorted(groups.items(), key=lambda group: group[1][0].few_break is not None)
    for (kind, _, of_area, whom), alike in each:
        said = _behaved(verdict, answer, kind, alike, bare=of_area.startswith(kind), whom=whom)
        if of_area:
            # of those that are followed in place of infinitely many nothing else is known
            no_more = all(one.instead or one.finite is few[one.rule] for one in alike)
            said = of_area if no_more else f"{of_area} ({said} for infinitely many)"
        parts.append(f"{said} if {_rules(alike)}" if len(groups) > 1 else said)
    elsewhere = bool(not_decided(verdict)) or answer is not verdict.own
    return parts if elsewhere else [*parts, *widest(verdict)]


def _behaved(
    verdict: Verdict,
    answer: Answer,
    kind: str,
    alike: Sequence[Behaviour],
    bare: bool = False,
    whom: str = "",
) -> str:
    """One kind of behaviour with its numbers; its forces alone if `bare`. The numerical error stands beside these where
    it is the widest uncertainty. `whom` : of whom, see `whom_of`."""
    scale, last, vague = answer.scale, alike[0], is_vague(verdict)
    unit_force = answer.contacts.mean_threshold * scale.force
    error = unit_force * max((one.error for one in alike if one.error < np.inf), default=0.0)
    top = max((abs(one.before) for one in alike), default=0.0) * scale.force
    uncertainty = max(widest_uncertainty(verdict), error / top if top else 0.0)

    def span(values: Sequence[float], unit: str, shown_error: float = 0.0) -> str:
        """One value, or the smallest and the largest where they differ as written; to the digit of an error that
        stands beside it."""
        ends = min(values), max(values)
        each = (to_digits(end, unit, uncertainty * abs(end), shown_error, vague) for end in ends)
        return " to ".join(dict.fromkeys(each))

    if kind == "undecided" and not last.slips:
        first = answer.behaviours[0]
        why = f" ({cause(answer)}{stability(answer, last)})" * (last.message == first.message)
        return f"not decided{why}"
    shown_error = max(error_beside(verdict, answer, one) for one in alike) * scale.force

    def with_error(values: Sequence[float]) -> str:
        """As `span`, of forces of `alike`, with their error where it is told."""
        if not shown_error:
            return span(values, scale.force_unit)
        ends = (with_scatter(end, error, scale.force_unit) for end in (min(values), max(values)))
        return " to ".join(dict.fromkeys(ends))

    after = [(one.after - assumed_share(answer, one)) * scale.force for one in alike]
    if kind == "smooth":
        said, differs = with_error(after), False
        if last.swings or not shown_error:  # as F_k stands in the table
            uncertainty = widest_uncertainty(verdict)
            # of one that swings the force is known, and its error what still swings
            sliding = [sliding_force_of(verdict, answer, one) * scale.force for one in alike]
            said = span(after if last.swings else sliding, scale.force_unit)
            differs = said != span([answer.kinetic.value * scale.force], scale.force_unit)
        if bare:
            return said
        said += whom + of_damping(answer, last, differs) + way_to(last)
        said += once_over(answer, last) + swinging(answer, last) + of_small_falls(answer, last)
        said += of_fluctuations(verdict, last) * (answer is verdict.own)
        return f"{without_delay(answer, last)}smooth at {said}{of_assumed_damping(answer, last)}"
    high = with_error([one.before * scale.force for one in alike])
    # an error that hides beside the force before a slip may be much of what is left after it
    own = error if error > uncertainty * min(map(abs, after)) else 0.0
    unit = scale.force_unit
    low = hidden_by(own, after, unit) or span(after, unit, shown_error or own)
    fall = falls(high, low, drop_of(last) * scale.force, unit, past_peak(verdict, answer, alike))
    if kind == "undecided":
        return seen_slips(last, fall)
    if bare:
        return fall
    said = f"{'slips ever rarer' if kind == EVER_RARER else kind}: {fall}"
    every = periods(verdict, alike, uncertainty, bool(shown_error))
    if every and kind != EVER_RARER:
        said += f" every {every} at {scale.speed(verdict.velocity)}"
    if last.finite is not None and (shrinks := shrinking(last.finite)):
        said += f"{shrinks}, so that they may die out"
    said += whom + left_out(last.finite or last) + still_changing(last.finite, scale)
    return said + of_assumed_damping(answer, last)
