"""Which readings and slip rules say something else than the scene's own, and which say nothing; lines of what a
verdict hangs on, each with how much it may change the answer, by which they are sorted."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from toolkit.scene.scale import spoken, written
from toolkit.verdict.answers import Answer, Verdict
from toolkit.verdict.readings import STRETCHED
from toolkit.verdict.sliders.budget import LONGER, long_delay
from toolkit.verdict.sliders.machine import (
    NAMED,
    RULES,
    Behaviour,
    Machine,
    slip_duration,
    top_speed,
)
from toolkit.verdict.text.table import drop_of
from toolkit.verdict.uncertainty import WORTH_TELLING

# what turns the answer or leaves it open; what changes the forces nobody knows how much, which is taken for half of
# them; what is said of all verdicts alike; what changes nothing
TURNS, UNSIZED, GENERAL, NOTHING = float("inf"), 0.5, 0.0, -1.0


@dataclass(frozen=True)
class Line:
    """A sentence, and by how much what it names changes the forces that are told, relative to these."""

    change: float
    text: str


def sorted_texts(lines: Iterable[Line]) -> list[str]:
    """The sentences, that which changes the answer most first; those alike in their order."""
    return [line.text for line in sorted(lines, key=lambda line: -line.change)]


def by_reason(reasons: Iterable[tuple[str, str]]) -> dict[str, list[str]]:
    """Names by the reason that they share, each once."""
    groups = dict[str, list[str]]()
    for why, name in reasons:
        if name not in groups.setdefault(why, []):
            groups[why].append(name)
    return groups


def named(rules: Sequence[str]) -> str:
    """The slip rules in words, after an "if"."""
    return (
        "any slip rule acts"
        if set(rules) == set(RULES)
        else " or ".join(NAMED[rule] for rule in rules)
    )


def a_slip(own: Answer) -> tuple[float, float]:
    """How long a slip of the own reading's mass takes in which no contact holds, and its top speed: as followed, of
    contacts that wait; else about, from the force before the slip, or F_s."""
    first = own.behaviours[0]
    times = first.slip_time, first.top_speed
    if (
        first.rule == "mass"
        and first.kind == "stick-slip"
        and own.contacts.waiting_time
        and all(times)
    ):
        return cast(tuple[float, float], times)
    force = before_a_slip(own)
    return slip_duration(damped(own), force), top_speed(damped(own), force)


def before_a_slip(own: Answer) -> float:
    """The force before a slip of the own reading, F/(N_c <k>) (a length): as followed, where a slip was seen, as
    contacts on which time acts bear another force on a slider that sticks; else F_s."""
    every = (*own.behaviours, *reversed(own.extremes))
    seen = [abs(one.before) for one in every if one.slips and one.kind != "smooth"]
    return seen[0] if seen and np.isfinite(seen[0]) else own.static.value


def damped(own: Answer) -> Machine:
    """The machine of the own reading, with the damping that its slider was followed with."""
    machine, taken = cast(Machine, own.machine), own.behaviours[0].damping
    return machine if taken is None else replace(machine, damping=taken)


def long_delay_of(own: Answer) -> float:
    """A delay far above the time of a slip of the own reading's mass, see `long_delay`."""
    return long_delay(damped(own), own.contacts.mean_threshold, own.static.value)


def without_delay(answer: Answer, slider: Behaviour) -> str:
    """What a smooth slider with mass on a spring below K* hangs on, where no delay is given, to be told first; "" for
    others."""
    if slider.rule != "mass" or answer.contacts.waiting_time or not answer.softer:
        return ""
    return "if contacts form again at once, as no delay is given: "


def of_damping(answer: Answer, slider: Behaviour, differs: bool) -> str:
    """What of the spring's force the damping bears, γv, where a smooth slider tells it: where it is large, or
    `differs`: the force is written otherwise than F_k, which is the contacts' alone."""
    if answer.machine is None or slider.rule != "mass":
        return ""
    borne = damped(answer).damping * answer.machine.velocity
    apart = abs(slider.after - answer.kinetic.value)
    if borne < WORTH_TELLING * abs(slider.before) and not (differs and borne > 0.5 * apart):
        return ""
    scale = answer.scale
    return f" ({written(borne * scale.force, scale.force_unit)} of it borne by the damping)"


def others(verdict: Verdict) -> dict[str, list[str]]:
    """The readings that say something else than the scene's own under any rule, by what they say."""
    own = {behaviour.rule: behaviour.kind for behaviour in verdict.own.behaviours}
    differ: dict[str, list[str]] = {}
    for answer in verdict.answers[1:]:
        for one in answer.behaviours:
            if one.kind not in ("undecided", own.get(one.rule, one.kind)):
                names = differ.setdefault(one.kind, [])
                names += [answer.name] if answer.name not in names else []
    return differ


def not_decided(verdict: Verdict) -> list[Answer]:
    """The other readings of which nothing is known under any rule that the scene's own reading is decided under."""
    decided_rules = {one.rule for one in verdict.own.behaviours if one.kind != "undecided"}
    if not decided_rules:
        return []
    return [
        answer
        for answer in verdict.answers[1:]
        if all(one.kind == "undecided" for one in answer.behaviours if one.rule in decided_rules)
    ]


def out_of_time(answer: Answer) -> bool:
    """Whether it is for want of time alone that a reading is not decided."""
    return all("wall_time" in one.message for one in answer.behaviours if one.kind == "undecided")


def delay_decides(verdict: Verdict) -> bool:
    """Whether a slider with mass is known to do something else with the other extreme of the contacts' delay."""
    kinds = {one.kind for one in verdict.own.behaviours}
    other = verdict.turned
    return other is not None and "undecided" not in kinds | {other.kind} and other.kind not in kinds


def of_extremes(verdict: Verdict) -> str:
    """Where a slider with mass is not decided: what it does with a delay of its contacts far above a slip's duration,
    and far below those that matter, or, as sliders without mass tell, without one; "" where it is decided, and where
    these are not known."""
    own, none = verdict.own, "they had none"
    first, *light = own.behaviours
    each = {one.rule: one.kind for one in light if one.kind != "undecided"}
    known, waits = len(each) == len(RULES), bool(own.contacts.waiting_time)
    if own.extremes:
        at_once, after = own.extremes
        known, each = True, {"instant": at_once.kind, "reform-after": after.kind}
        if short := short_delay_of(own):
            none = f"it were far below {spoken(short, own.scale.time_unit)}"
    if first.rule != "mass" or first.kind != "undecided" or not (known and waits):
        return ""
    slip = spoken(a_slip(own)[0], own.scale.time_unit)
    long = f"the contacts' delay were far above the time of a slip, {slip}"
    if each["reform-after"] == each["instant"]:
        said = f"{each['instant']} if {long}, and if {none}"
    else:
        said = f"{each['reform-after']} if {long}, {each['instant']} if {none}"
    late = "wall_time" in first.message
    return f"not decided{' in time' * late}: {said}{f'; {LONGER}' * late}"


def of_rules(verdict: Verdict) -> Iterator[Line]:
    """What hangs on the slip rule, or on the delay that decides in its place."""
    own = verdict.own
    does = {one.rule: one.kind for one in own.behaviours}
    if own.contacts.reforming is not None and does.keys() & set(RULES):
        yield Line(
            UNSIZED, f"not every slip rule: {STRETCHED}, which no solver takes and is left out"
        )
    if len(set(does.values())) > 1:
        light = by_reason((kind, rule) for rule, kind in does.items() if rule != "mass")
        words = {"undecided": "not decided"}
        each = ", ".join(
            f"{words.get(kind, kind)} if {named(rules)}" for kind, rules in light.items()
        )
        yield Line(TURNS, f"the slip rule: {each}. {_what_decides(own)}")
    elif len(does) > 1 and "undecided" not in does.values():
        yield _of_agreeing(own)
    elif own.extremes:
        said = "a slider with this one was not followed far enough"
        yield Line(TURNS, f"the contacts' delay: {said}{of_short_delays(own)}")
    elif len(does) == 1 and own.machine and own.machine.mass:
        given, turned_found = bool(own.contacts.waiting_time), verdict.turned is not None
        unknown = not turned_found or cast(Behaviour, verdict.turned).kind == "undecided"
        if not given and (delay_decides(verdict) or unknown):
            said = "none is given, so that they form again at once; give [contacts.delay]"
            yield Line(TURNS, f"the contacts' delay: {said}")
        elif delay_decides(verdict):
            said = f"another one may change the answer{of_short_delays(own)}"
            yield Line(TURNS, f"the contacts' delay: {said}")
        elif turned_found and verdict.turned and verdict.turned.kind != "undecided":
            other = verdict.turned
            what = "without one" if given else "as long as contacts form again only after a slip"
            if other.rule == "mass":
                what = f"with one of {spoken(long_delay_of(own), own.scale.time_unit)}"
            yield _same_with(verdict, other, what)


def _of_agreeing(own: Answer) -> Line:
    """That rules agree; where it is only on whether the slider slips, between which slips."""
    low, high = (choose(own.behaviours, key=drop_of) for choose in (min, max))
    change = drop_of(high) - drop_of(low)
    if change <= WORTH_TELLING * drop_of(high):
        return Line(NOTHING, "not the slip rule, for infinitely many contacts: all rules agree")
    force, length = (own.scale.force, own.scale.force_unit), own.scale.length_unit

    def slips(one: Behaviour) -> str:
        off = one.error * own.contacts.mean_threshold * force[0]
        ends = (written(end * force[0], force[1], off, 4) for end in (one.before, one.after))
        every = f" every {written(one.period, length, one.period_error, 4)}" if one.period else ""
        return f"{' down to '.join(ends)}{every} if {NAMED[one.rule]}"

    said = f"all stick and slip, between {slips(high)} and {slips(low)}"
    return Line(change / drop_of(high), f"the slip rule, for infinitely many contacts: {said}")


def _same_with(verdict: Verdict, other: Behaviour, what: str) -> Line:
    """That a slider with another delay does the same; where its force is another, by how much."""
    own = verdict.own
    (one,), scale, mean = own.behaviours, own.scale, own.contacts.mean_threshold
    change = abs(other.before - one.before)
    least = max(WORTH_TELLING * abs(one.before), (one.error + other.error) * mean)
    if one.kind == other.kind and change <= least:
        return Line(NOTHING, f"not the contacts' delay: {what} it does the same")
    force = written(other.before * scale.force, scale.force_unit, other.error * mean * scale.force)
    where = f"{'at' if other.kind == 'smooth' else 'from'} {force}"
    said = (
        f"{what} it is {other.kind}{', too, but' * (other.kind == one.kind)} {where}"
        f"{', as a slider without mass and damping tells' * (other.rule != 'mass')}"
    )
    return Line(change / abs(one.before), f"the contacts' delay: {said}")


def _what_decides(own: Answer) -> str:
    """What decides in place of the slip rules, what of it is still to be given, and that a mass was not followed."""
    delay = "" if own.contacts.waiting_time else "[contacts.delay]"
    if own.machine is not None and own.machine.mass is not None:
        missing = [*([] if own.machine.damping else ["drive.damping"]), *([delay] if delay else [])]
        give = f"; give {' and '.join(missing)}" * bool(missing)
        followed = own.behaviours[0]
        # where it is refused its message says what to do, and more of the machine may not help
        if followed.refused:
            give = ", for the reason told here"
        said = f"That is without the mass: the slider with it, which would decide, was not followed{give}"
        return said + of_short_delays(own) * (not delay)
    give = (
        "drive.mass, drive.damping and [contacts.delay]"
        if delay
        else "drive.mass and drive.damping"
    )
    return f"In nature mass, damping and the contacts' delay decide: give {give}"


def of_short_delays(own: Answer) -> str:
    """Beside which times the delay of a slider with mass is short or long: that in which it slides by <x_s> at the
    top speed of a slip in which nothing holds, that of the slip, and that of its loading (docs/sliders.md)."""
    machine, mean, unit = own.machine, own.contacts.mean_threshold, own.scale.time_unit
    if machine is None or not machine.mass or own.static.unknown:
        return ""
    duration, fastest = a_slip(own)
    why, shortest = "in which a slip goes on by <x_s>", short_delay_of(own)
    if 0.0 < shortest < mean / fastest:
        why = "above which friction falls with the speed by more than the damping rises"
    force = before_a_slip(own)
    loads = force / machine.spring / machine.velocity
    short, long = spoken(shortest or mean / fastest, unit), spoken(duration, unit)
    to = "F_s"
    if abs(force - own.static.value) > WORTH_TELLING * own.static.value:
        to = f"the force before a slip, {written(force * own.scale.force, own.scale.force_unit)}"
    loaded = f"the {spoken(loads, unit)} in which the drive loads the spring to {to}"
    at_once = f"With a delay far below {short}, {why}, contacts re-form in effect at once"
    after = f"with one far above the {long} of a slip, and far below {loaded}, only after the slip"
    if loads < duration:
        never = "with no delay do they all re-form between one slip and the next"
        return f". {at_once}; {never}, as a slip lasts {long}, longer than {loaded}"
    return f". {at_once}; {after}"


def short_delay_of(own: Answer) -> float:
    """The delay (a time) far below which contacts act as if they formed again at once: none waits as a slip passes its
    thresholds, and friction, F_k without a delay, falls by less than damping rises, F_k τ/<x_s> < γ. 0: undamped."""
    machine, mean = damped(own), own.contacts.mean_threshold
    in_touch = mean / (mean + machine.velocity * own.contacts.waiting_time)
    return min(mean / a_slip(own)[1], machine.damping * mean * in_touch / own.kinetic.value)
