"""What a verdict says of slip rules, and of the delay of its contacts that decides in their place: with which delays a
slider with mass does something else."""

from collections.abc import Iterator
from typing import cast

import numpy as np

from toolkit.scene.scale import spoken, written
from toolkit.verdict.answers import Answer, Verdict
from toolkit.verdict.of_area import counted, disagreeing, verb
from toolkit.verdict.readings import STRETCHED
from toolkit.verdict.sliders.budget import HOW_TO_GIVE_MORE_TIME
from toolkit.verdict.sliders.machine import NAMED, RULES, critical_damping
from toolkit.verdict.sliders.records import Behaviour
from toolkit.verdict.sliders.steady import friction_decides, unstable_delays
from toolkit.verdict.slips_in_words import does
from toolkit.verdict.text.kinds import (
    NOTHING,
    TURNS,
    UNSIZED,
    Line,
    a_slip,
    before_a_slip,
    by_reason,
    damped,
    in_a_word,
    long_delay_of,
    named,
)
from toolkit.verdict.text.slip_rows import drop_of
from toolkit.verdict.text.swinging import among_them, of_swings, swinging_delays
from toolkit.verdict.uncertainty import WORTH_TELLING

# times as long as a slip its loading is, from which on a delay may be far above the one and far below the other
APART = 10.0
# what both solvers say of a mass that a damping would let end
_RINGS = "the slider rings"


def delay_decides(verdict: Verdict) -> bool:
    """Whether a slider with mass is known to do something else with the other extreme of the contacts' delay."""
    kinds = {one.kind for one in verdict.own.behaviours}
    other = verdict.turned
    return other is not None and "undecided" not in kinds | {other.kind} and other.kind not in kinds


def _untried(verdict: Verdict) -> str:
    """`of_swings` of a slider with mass, but not of longer delays than one with which it was followed and slides."""
    own, other = verdict.own, verdict.turned
    slides = other is not None and (other.rule, other.kind) == ("mass", "smooth")
    return of_swings(own, long_delay_of(own) if slides else np.inf)


def would_swing(verdict: Verdict) -> list[str]:
    """With which other delays a slider with mass that slides would swing or slip, in a line beside the headline."""
    own = verdict.own
    if [(one.rule, one.kind) for one in own.behaviours] != [("mass", "smooth")]:
        return []
    said = _untried(verdict).removeprefix(". ")
    return [said] * bool(said and not among_them(own))


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
    if between := swinging_delays(own):
        said += f"; {between} it swings or slips"
    late = "wall_time" in first.message
    return f"not decided{' in time' * late}: {said}{f'; {HOW_TO_GIVE_MORE_TIME}' * late}"


def of_rules(verdict: Verdict) -> Iterator[Line]:
    """What hangs on the slip rule, or on the delay that decides in its place."""
    own = verdict.own
    words = {one.rule: in_a_word(one) for one in own.behaviours}
    if own.contacts.reforming is not None and words.keys() & set(RULES):
        yield Line(
            UNSIZED, f"not every slip rule: {STRETCHED}, which no solver takes and is left out"
        )
    if len(set(words.values())) > 1:
        light = by_reason((kind, rule) for rule, kind in words.items() if rule != "mass")
        each = ", ".join(f"{kind} if {named(rules)}" for kind, rules in light.items())
        yield _of_the_rule(own, each)
    elif len(words) > 1 and "undecided" not in {one.kind for one in own.behaviours}:
        yield _of_so_many(verdict) or _of_agreeing(own)
    elif own.extremes:
        said = f"a slider with this one was not followed far enough{short_and_long(own)}"
        yield Line(TURNS, f"the contacts' delay: {said}", of_short_delays(own))
    elif len(words) == 1 and own.machine and own.machine.mass:
        given, turned_found = bool(own.contacts.waiting_time), verdict.turned is not None
        unknown = not turned_found or cast(Behaviour, verdict.turned).kind == "undecided"
        if not given and (delay_decides(verdict) or unknown):
            said = "none is given, so that they form again at once; give [contacts.delay]"
            # between which delays it would swing stands beside the answer
            swings = "" if would_swing(verdict) else _untried(verdict)
            yield Line(TURNS, f"the contacts' delay: {said}{swings}")
        elif delay_decides(verdict):
            said = f"another one may change the answer{short_and_long(own)}"
            yield Line(TURNS, f"the contacts' delay: {said}", of_short_delays(own))
        elif turned_found and verdict.turned and verdict.turned.kind != "undecided":
            other = verdict.turned
            what = "without one" if given else "as long as contacts form again only after a slip"
            if other.rule == "mass":
                what = f"with one of {spoken(long_delay_of(own), own.scale.time_unit)}"
            yield _same_with(verdict, other, what)
        elif would_swing(verdict):
            yield Line(
                TURNS, "the contacts' delay: another one may change the answer, as told above"
            )


def _of_so_many(verdict: Verdict) -> Line | None:
    """That the slip rule decides what the contacts of the area do, though for infinitely many all agree; None where it
    does not."""
    if not (differ := disagreeing(verdict)):
        return None
    told = [(does(one).replace("unknown", "not known"), one.rule) for one in verdict.finite]
    if len(kinds := by_reason(told)) < 2:
        return None
    each = ", ".join(f"{kind} if {named(rules)}" for kind, rules in kinds.items())
    alike = f"infinitely many {verb({one.kind for one, _ in differ})}"
    whose = f", for {counted(verdict, differ[0][1])}"
    return _of_the_rule(verdict.own, f"{each}; {alike}", whose)


def _of_the_rule(own: Answer, each: str, whose: str = "") -> Line:
    """That the slip rule decides: what it is by `each` rule, and `whose`; and which numbers decide in its place."""
    mass = own.machine is not None and own.machine.mass is not None
    more = of_short_delays(own) * bool(mass and own.contacts.waiting_time)
    return Line(TURNS, f"the slip rule{whose}: {each}. {_what_decides(own)}", more)


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
    swings, size = _untried(verdict), change / abs(one.before)
    if would_swing(verdict):
        swings, size = "; other delays, told above, may change the answer", TURNS
    if one.kind == other.kind and change <= least:
        if swings:
            return Line(size, f"the contacts' delay: {what} it does the same{swings}")
        return Line(NOTHING, f"not the contacts' delay: {what} it does the same")
    force = written(other.before * scale.force, scale.force_unit, other.error * mean * scale.force)
    where = f"{'at' if other.kind == 'smooth' else 'from'} {force}"
    said = (
        f"{what} it is {other.kind}{', too, but' * (other.kind == one.kind)} {where}"
        f"{', as a slider without mass and damping tells' * (other.rule != 'mass')}"
    )
    return Line(size, f"the contacts' delay: {said}{swings}")


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
        if _RINGS in followed.message:
            # with a larger one mass and spring would not swing: another machine
            most = critical_damping(own.machine) * own.scale.spring
            give = (
                f"; give {'a larger damping' if own.machine.damping else 'drive.damping'}, below "
            )
            give += f"{written(most, own.scale.damping_unit)}, the critical one"
        said = f"That is without the mass: the slider with it, which would decide, was not followed{give}"
        return said + short_and_long(own) * (not delay)
    give = (
        "drive.mass, drive.damping and [contacts.delay]"
        if delay
        else "drive.mass and drive.damping"
    )
    return f"In nature mass, damping and the contacts' delay decide: give {give}"


def short_and_long(own: Answer) -> str:
    """Which delays of a slider with mass are short, and which are long, after what it says of another one; "" where
    that is not known. `of_short_delays` has the reasons."""
    machine = own.machine
    if machine is None or not machine.mass or own.static.unknown:
        return ""
    duration, fastest = a_slip(own)
    unit, loads = own.scale.time_unit, before_a_slip(own) / machine.spring / machine.velocity
    short = short_delay_of(own) or own.contacts.mean_threshold / fastest
    long = f"long far above {spoken(duration, unit)}, the time of a slip"
    if loads < APART * duration:
        long = f"none is long, as the drive loads the spring in {spoken(loads, unit)}"
    return f"; short is far below {spoken(short, unit)}, {long}"


def of_short_delays(own: Answer) -> str:
    """Beside which times the delay of a slider with mass is short or long: that in which it slides by <x_s> at the
    top speed of a slip in which nothing holds, that of the slip, and that of its loading (docs/sliders.md)."""
    machine, mean, unit = own.machine, own.contacts.mean_threshold, own.scale.time_unit
    if machine is None or not machine.mass or own.static.unknown:
        return ""
    duration, fastest = a_slip(own)
    why, shortest, swings = (
        ", in which a slip goes on by <x_s>,",
        short_delay_of(own),
        of_swings(own),
    )
    if 0.0 < shortest < mean / fastest:
        why = ", above which friction falls with the speed by more than the damping rises,"
        why *= not swings
    force = before_a_slip(own)
    loads = force / machine.spring / machine.velocity
    short, long = spoken(shortest or mean / fastest, unit), spoken(duration, unit)
    to = "F_s"
    if abs(force - own.static.value) > WORTH_TELLING * own.static.value:
        to = f"the force before a slip, {written(force * own.scale.force, own.scale.force_unit)}"
    loaded = f"the {spoken(loads, unit)} in which the drive loads the spring to {to}"
    at_once = f"With a delay far below {short}{why} contacts re-form in effect at once"
    after = f"with one far above the {long} of a slip, and far below {loaded}, only after the slip"
    if loads < duration:
        never = "with no delay do they all re-form between one slip and the next"
        return f". {at_once}; {never}, as a slip lasts {long}, longer than {loaded}{swings}"
    if loads < APART * duration:
        never = "no delay is far above the one and far below the other, so that they re-form only after the slip"
        return f". {at_once}; a slip lasts {long}, about as long as {loaded}: {never}{swings}"
    return f". {at_once}; {after}{swings}"


def short_delay_of(own: Answer) -> float:
    """The delay (a time) far below which contacts act as if they formed again at once: none waits as a slip passes its
    thresholds, and friction, F_k without a delay, falls by less than damping rises, F_k τ/<x_s> < γ, or as
    `unstable_delays` tell. 0: undamped."""
    machine, mean = damped(own), own.contacts.mean_threshold
    if friction_decides(machine, own.contacts):
        band = unstable_delays(machine, own.contacts)
        return min(mean / a_slip(own)[1], band[0] if band else np.inf)
    in_touch = mean / (mean + machine.velocity * own.contacts.waiting_time)
    return min(mean / a_slip(own)[1], machine.damping * mean * in_touch / own.kinetic.value)
