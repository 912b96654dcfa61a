"""What heat changes in the forces of a verdict, and what it was left out of."""

from collections.abc import Iterator

import numpy as np

from origins.drive import RISE
from origins.laws.thermal import Thermal
from toolkit.results.of_heat import OF_RIGID, raised
from toolkit.scene.scale import written
from toolkit.verdict.answers import Answer, Verdict
from toolkit.verdict.sliders.in_heat import looked_at
from toolkit.verdict.sliders.records import Behaviour
from toolkit.verdict.text.kinds import GENERAL, Line, by_reason, named

# part of F_k that heat takes where hardly any of it is left
MOST = 0.9


def of_steady_sliding(verdict: Verdict) -> Iterator[Line]:
    """That steady sliding tells of a slider in heat, and what of its way was not followed."""
    own, scale = verdict.own, verdict.own.scale
    told = [one for one in own.behaviours if one.heat_on_the_way is not None]
    if not told or own.machine is None:
        return
    unit = own.contacts.mean_threshold * scale.force
    looked = looked_at(own.machine)
    slow, fast = scale.speed(looked[0]), scale.speed(looked[-1])
    small = f"{written(RISE * unit, scale.force_unit, digits=2)} ({RISE:g} <x_s>)"
    most = max(one.heat_on_the_way or 0.0 for one in told)
    said = "the slider in heat was not followed, as it goes on too slowly for steps in time: what is told follows from "
    said += "steady sliding, which is stable with this spring, mass and damping"
    if not most:
        why = f"at {slow} to {fast} no force is above that of faster sliding by what counts as a slip, {small} or more"
    else:
        why = f"and the slips before it from contacts without heat. At {slow} to {fast} heat changes F_k and F_s by "
        why += f"{written(most * unit, scale.force_unit, digits=2)} at most, "
        less, more = (
            f"less than what counts as a slip, {small}",
            f"more than what counts as a slip, {small}",
        )
        steadies = ", but steadies: F_k rises with the speed, and F_s is above it by no more than without heat"
        why += less if most <= RISE else more + steadies
    swing = own.machine.velocity * np.sqrt(own.machine.spring * (own.machine.mass or 0.0))
    if swing > own.kinetic.value and not most:
        swung = written(swing * scale.force, scale.force_unit, digits=2)
        why += f". As the drive begins the mass swings by up to {swung} of the spring's force, until that dies away"
    yield Line(most * unit / (own.kinetic.value * scale.force), said, f"; {why}")


def of_unstable_sliding(verdict: Verdict) -> Iterator[Line]:
    """That small swings of a smooth slider in heat grow, and what of them counts as no slip."""
    own, scale = verdict.own, verdict.own.scale
    for one in own.behaviours:
        below = one.unstable_below or 0.0
        if one.kind == "smooth" and below > 0.0:
            spring = written(below * scale.spring, scale.spring_unit, digits=2)
            small = RISE * own.contacts.mean_threshold * scale.force
            size = f"{written(small, scale.force_unit, digits=2)} ({RISE:g} <x_s>)"
            known = f"as far as it was followed by less than {size}, which counts as no slip"
            if one.heat_left_out is not None:
                known = "how far was not followed, as heat is left out"
            yield Line(
                RISE * own.contacts.mean_threshold / (abs(one.after) or np.inf),
                f"small swings of steady sliding grow by heat on springs below {spring}, as on this: the force that "
                f"is told as smooth may swing, {known}",
            )


def way_to(slider: Behaviour) -> str:
    """How much is known of the way up to steady sliding that tells of a slider in heat; "" where it was followed."""
    if slider.heat_on_the_way is None:
        return ""
    how = "followed without heat" if slider.heat_on_the_way else "not followed"
    return f" in the end (the way there was {how})"


def of_small_falls(answer: Answer, slider: Behaviour) -> str:
    """That a smooth slider may swing, as steady sliding is unstable in heat, where it was followed by less than counts
    as a slip; and which falls count as none, where these are larger than its force, as in strong heat. "" where neither
    is so, or where it is told between which forces the slider swings, or that it may by more."""
    small, scale = RISE * answer.contacts.mean_threshold, answer.scale
    if slider.swings is not None or slider.error > RISE:
        return ""
    size = written(small * scale.force, scale.force_unit, digits=2)
    if (slider.unstable_below or 0.0) > 0.0:  # not nan
        how = f" by less than {size}" if slider.heat_left_out is None else ""
        far = "" if how else " (how far was not followed)"
        return f", or swinging{how}, as heat lets small swings grow on this spring{far}"
    if not 0.0 < abs(slider.after) < small:
        return ""
    return f", where swings of less than {size} would count as no slips"


def stability(answer: Answer, slider: Behaviour) -> str:
    """Whether steady sliding is stable, of a slider in heat that is not decided; "" where that is not known."""
    below = slider.unstable_below
    if below is None or np.isnan(below):
        return ""
    if not below:
        said = "; steady sliding is stable on this machine, and whether the slider comes to it is not known"
        machine = answer.machine
        undamped = machine is not None and machine.mass and not machine.damping
        return said + ": give drive.damping" * bool(undamped and slider.rule == "mass")
    spring = written(below * answer.scale.spring, answer.scale.spring_unit, digits=2)
    return f"; steady sliding is unstable on springs below {spring}, so that it swings or slips on"


def of_heat(verdict: Verdict) -> Iterator[Line]:
    """What heat changes in F_k, and what it may change in the force, from above, where it was left out."""
    own, scale = verdict.own, verdict.own.scale
    unit = own.contacts.mean_threshold * scale.force
    kinetic, change = _by_heat(own), own.cold and abs(own.kinetic.value / own.cold.value - 1.0)
    more = _of_few_atoms(own) * bool(kinetic)
    seen = own.behaviours[:1] and own.contacts.changing is None and own.behaviours[0]
    if kinetic and seen and (seen.rule, seen.kind, seen.slips) == ("mass", "undecided", 0):
        ask = "leave [contacts.thermal] out to be told what it does then"
        more += f". Without heat a slider with mass is followed in far fewer steps: {ask}"
    cold = {one.rule: one.heat_left_out for one in own.behaviours if one.heat_left_out is not None}
    said = ((written(most * unit, scale.force_unit, digits=2), rule) for rule, most in cold.items())
    for most, rules in by_reason(said).items():
        which = f" if {named(rules)}" * (len(own.behaviours) > len(rules))
        few = any(one.rule in rules and one.kind != "unknown" for one in verdict.finite)
        which += ", of the contacts of the area, too" * few
        size = max(cold[rule] for rule in rules) * unit / (own.static.value * scale.force)
        bound = f"heat is left out{which}: it would change the force by {most} at most"
        yield Line(size, f"{bound}; {kinetic}" if kinetic else bound, more)
        kinetic = more = ""  # are told once
    if kinetic:
        yield Line(change or GENERAL, kinetic + more)


def _by_heat(own: Answer) -> str:
    """By how much heat changes F_k, which is known without it, too; "" where it is not."""
    if own.cold is None:
        return ""
    at = OF_RIGID * bool(own.machine)
    if abs(own.kinetic.value - own.cold.value) <= own.kinetic.error + own.cold.error:
        return f"heat changes F_k{at} by less than its numerical error"
    if own.kinetic.value < (1.0 - MOST) * own.cold.value:
        each = (
            written(one.value * own.scale.force, own.scale.force_unit, digits=3)
            for one in (own.cold, own.kinetic)
        )
        ends = "from {} to {}".format(*each)
        return (
            f"heat lowers F_k{at} {ends}: contacts hardly hold, and what is left hangs on the speed"
        )
    return f"heat {raised(own.kinetic.value, own.cold.value, own.scale, at)}"


def _of_few_atoms(own: Answer) -> str:
    """Beside heat that breaks whole contacts of a surface: that it may do more; "" of other contacts and heat."""
    thermal = own.contacts.thermal
    if (
        own.contacts.interface is None
        or not isinstance(thermal, Thermal)
        or thermal.law == "eyring"
    ):
        return ""
    few = 'with barriers of a few atoms (law = "eyring") it may change F_k more'
    return f", where each contact has one barrier; {few}"
