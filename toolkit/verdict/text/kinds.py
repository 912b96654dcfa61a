"""Which readings and slip rules say something else than the scene's own, and which say nothing; lines of what a
verdict hangs on, each with how much it may change the answer, by which they are sorted."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from toolkit.scene.scale import written
from toolkit.verdict.answers import Answer, Verdict
from toolkit.verdict.sliders.budget import long_delay
from toolkit.verdict.sliders.machine import NAMED, RULES, Machine, slip_duration, top_speed
from toolkit.verdict.sliders.records import Behaviour, Finite
from toolkit.verdict.slips_in_words import plain_fall
from toolkit.verdict.uncertainty import WORTH_TELLING, assumed_share

# what turns the answer or leaves it open; what changes the forces nobody knows how much, which is taken for half of
# them; what is said of all verdicts alike; what changes nothing
TURNS, UNSIZED, GENERAL, NOTHING = float("inf"), 0.5, 0.0, -1.0


@dataclass(frozen=True)
class Line:
    """A sentence, and by how much what it names changes the forces that are told, relative to these.

    more : its reasons, which go on from the sentence, and which verdict.json alone has
    of_readings : whether it tells how far the readings differ, which comes before what else changes the forces
    above : whether the page tells it above, in its answer or as a doubt
    """

    change: float
    text: str
    more: str = ""
    of_readings: bool = False
    above: bool = False


def worst_first(lines: Iterable[Line]) -> list[Line]:
    """What turns the answer, then how far the readings differ, then that which changes the forces most; those alike in
    their order."""
    return sorted(lines, key=lambda one: (one.change < TURNS, not one.of_readings, -one.change))


def by_reason(reasons: Iterable[tuple[str, str]]) -> dict[str, list[str]]:
    """Names by the reason that they share, each once."""
    groups = dict[str, list[str]]()
    for why, name in reasons:
        if name not in groups.setdefault(why, []):
            groups[why].append(name)
    return groups


def in_a_word(slider: Behaviour) -> str:
    """What a slider does under its rule, in a word or two."""
    if slider.few_break is not None:
        return "no stick-slip, but falls of few contacts,"
    return "not decided" if slider.kind == "undecided" else slider.kind


def named(rules: Sequence[str]) -> str:
    """The slip rules in words, after an "if"."""
    return (
        "any slip rule acts"
        if set(rules) == set(RULES)
        else " or ".join(NAMED[rule] for rule in rules)
    )


def larger_slips(verdict: Verdict, differ: Sequence[tuple[Behaviour, Finite]]) -> list[str]:
    """That the slider sticks and slips by rules under which as many contacts as there are do as infinitely many, with a
    larger fall than by those of `differ`; none where no rule has one."""
    own, drops = verdict.own, [one.before - one.after for pair in differ for one in pair]
    most = max((drop for drop in drops if np.isfinite(drop)), default=0.0)
    apart = {one.rule for one, _ in differ}
    larger = [
        one
        for one in own.behaviours
        if one.kind == "stick-slip" and one.rule not in apart and one.before - one.after > most
    ]
    if not larger:
        return []
    few = {one.rule: one for one in verdict.finite if one.kind == "stick-slip"}
    unit, each = own.scale.force_unit, [few.get(one.rule) for one in larger]
    told = {plain_fall(one, own.scale.force, unit) if one else "" for one in each}
    fall = told.pop() if len(told) == 1 else ""
    return [
        f"stick-slip{f', from {fall},' if fall else ''} if {named([one.rule for one in larger])}"
    ]


def a_slip(own: Answer) -> tuple[float, float]:
    """How long a slip of the own reading's mass takes in which no contact holds, and its top speed: as followed, of
    contacts that wait; else about, from the force before the slip, or F_s."""
    first = own.behaviours[0]
    times = first.in_time.slip_time, first.in_time.top_speed
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
    told = written(borne * answer.scale.force, answer.scale.force_unit)
    if assumed_share(answer, slider):
        return f" (the spring's force is larger by {told}, which the damping bears)"
    return f" ({told} of it borne by the damping)"


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


def what_decides(verdict: Verdict) -> str:
    """Which assumptions decide where what the slider does hangs on them, as the begin of a sentence; "" where all say
    the same. Of readings those rules count alone that the scene's own is told by."""
    own, elsewhere = verdict.own, others(verdict)
    if len({one.kind for one in own.behaviours} - {"undecided"} | elsewhere.keys()) < 2:
        return ""
    each = ["what contacts do in a slip"] * (len({in_a_word(one) for one in own.behaviours}) > 1)
    each += ["the reading of the surface"] * bool(elsewhere)
    lost = (
        "not decided, as the slider with its mass was not followed: without it "
        * lost_with_mass(own)
    )
    return f"{lost}{' and '.join(each)} decide{'s' * (len(each) == 1)}"


def lost_with_mass(own: Answer) -> bool:
    """Whether nothing is known of a slider with mass, and all slip rules tell what it would do without it."""
    unknown = [one for one in own.behaviours if one.kind == "undecided"]
    return [one.rule for one in unknown] == ["mass"] and not unknown[0].slips


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
