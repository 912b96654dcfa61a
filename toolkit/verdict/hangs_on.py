"""What a verdict hangs on, in lines: slip rule, readings, number of contacts; and what was not answered."""

from collections.abc import Iterator
from itertools import chain

import numpy as np

from origins.roughness.interface import Interface
from toolkit.scene.interfaces import of_temperature, remarks
from toolkit.scene.scale import of_contacts, written
from toolkit.verdict.answers import Answer, Verdict
from toolkit.verdict.budget import MORE_TIME
from toolkit.verdict.ensemble import SLIDERS
from toolkit.verdict.finite import ABOVE, SMALL
from toolkit.verdict.kinds import (
    GENERAL,
    NOTHING,
    TURNS,
    UNSIZED,
    Line,
    by_reason,
    named,
    not_decided,
    of_a_stuck_slider,
    of_rules,
    others,
    out_of_time,
    sorted_texts,
)
from toolkit.verdict.machine import Finite, critical_damping
from toolkit.verdict.of_area import apart, fall_of, fluctuating, late_force_of
from toolkit.verdict.table import drop_of, in_units, regained_by
from toolkit.verdict.uncertainty import range_of_force, uncertainties_of
from toolkit.verdict.undone import of_errors, unanswered

NEAR = 0.1  # of K*: on softer springs the number of contacts decides nothing
RULE = "<rule>"
# N K³, K in N_c<k>, above which sliding on springs stiffer than K* is smooth (docs/sliders.md)
SMOOTH_ABOVE = 50.0


def dependence(verdict: Verdict) -> list[str]:
    """What the verdict hangs on, the worst first: slip rule, readings, number of contacts; what was not answered."""
    lines = (
        of_rules(verdict),
        _of_readings(verdict),
        _of_a_speed(verdict),
        of_a_stuck_slider(verdict),
        _of_a_mass(verdict),
        _of_contacts(verdict),
        unanswered(verdict),
        of_errors(verdict),
    )
    return sorted_texts(chain(*lines))


def _of_readings(verdict: Verdict) -> Iterator[Line]:
    """By how much the readings differ, and which of them say something else."""
    answers, many = verdict.answers, len(verdict.answers)
    if many < 2:
        return
    differ = others(verdict)
    size = TURNS if differ else uncertainties_of(verdict).readings
    springs = [
        one.critical_spring.value * one.scale.spring
        for one in answers
        if not (one.critical_spring.unknown or one.critical_spring.lost)
    ]
    if len(springs) > 1:
        factor = max(springs) / min(springs) if min(springs) > 0.0 else np.inf
        said = f"K* differs by a factor of {factor:.3g} over {len(springs)} readings"
        said += f", and {range_of_force(verdict)}"
        yield Line(size, f"threshold law, contact model and resolution: {said}")
    for kind, names in differ.items():
        yield Line(size, f"of these, {kind}: {', '.join(names)}")
    missing = not_decided(verdict)
    for why, names in by_reason((_why(one), one.name) for one in missing).items():
        yield Line(size, f"not decided: {', '.join(names)}: {why}")
    absent = {one.name for one in missing}
    decided = [one for one in answers[1:] if {each.kind for each in one.behaviours} - {"undecided"}]
    decided = [one for one in decided if one.name not in absent]
    decided_rules = {one.rule for one in verdict.own.behaviours if one.kind != "undecided"}
    partly = [
        answer.name
        for answer in decided
        if any(one.kind == "undecided" for one in answer.behaviours if one.rule in decided_rules)
    ]
    if partly:
        said = "decided under some slip rules, and not under others"
        yield Line(size, f"{said}: {', '.join(partly)}")
    if verdict.own.machine is not None and decided and not differ:
        all_say = f"the {len(decided)} others that were followed say"
        all_say = "the other one says" if len(decided) == 1 else all_say
        said = f"{all_say} what {verdict.own.name} says"
        yield Line(NOTHING, f"not the reading: {said}")


def _why(answer: Answer) -> str:
    """Why a reading is not decided."""
    if out_of_time(answer):
        return f"out of time: {MORE_TIME}, or give fewer verdict.readings"
    return in_units(answer.behaviours[0].message, answer.scale)


def _of_a_speed(verdict: Verdict) -> Iterator[Line]:
    """A speed that is not given; and a temperature that may be meant in °C."""
    own = verdict.own
    if not verdict.velocity_given and own.machine is not None and own.scale.length_unit == "m":
        decides = bool(own.contacts.in_time) or own.machine.mass is not None
        what = "forces and slips hang on it, and all times" if decides else "all times hang on it"
        given = "none is given, and 1 m/s is taken"
        yield Line(
            TURNS if decides else UNSIZED, f"the speed: {given}; {what}: give drive.velocity"
        )
    yield from (Line(UNSIZED, one) for one in of_temperature(own.contacts))


def why_smooth(verdict: Verdict) -> list[str]:
    """Why a slider below K* slides, in a sentence that stands below the table, beside K*."""
    own = verdict.own
    smooth = [one for one in own.behaviours if one.kind == "smooth"]
    if not smooth or not own.softer:
        return []
    force, unit = own.scale.force, own.scale.force_unit
    fall = own.static.value - own.kinetic.value
    rules = (
        "" if len(smooth) == len(own.behaviours) else f" if {named([one.rule for one in smooth])}"
    )
    begin = "K is below K*, and yet " * (not own.smoothed)
    said = f"{begin}sliding is smooth{rules}: "
    cold = not own.contacts.held_in_time or all(one.heat_left_out is not None for one in smooth)
    small = SMALL * own.contacts.mean_threshold
    if all(one.rule == "mass" and not one.slips for one in smooth) and cold and fall < small:
        return [
            f"{said}the fall from F_s to F_k, {written(fall * force, unit)}, is too small to count as a slip of a "
            f"slider with mass (from {written(small * force, unit)} on, {SMALL:g} <x_s>)"
        ]
    if not cold and not any(one.slips for one in smooth):
        return [
            f"{said}contacts break by themselves, and the slider creeps, ever faster, up to the speed of its drive"
        ]
    ends = f"F_s, {written(fall * force, unit)} above F_k," if fall > 0.0 else "a rise to F_k"
    after = f"after {ends} " * cold
    return [
        f"{said}{after}the slider slips once or a few times, and then no more, as contacts have forgotten their start"
    ]


def _of_a_mass(verdict: Verdict) -> Iterator[Line]:
    """The damping that was taken, and the swing after a slip."""
    own = verdict.own
    for behaviour in own.behaviours:
        if behaviour.damping is not None and own.machine is not None:
            part = behaviour.damping / critical_damping(own.machine)
            # N_c<k> in N/m is the unit of the spring, and N_c<k> times a time that of the damping
            unit = {"N/m": "N s/m", "N/m³": "N s/m³"}.get(own.scale.spring_unit, "N_c<k> time")
            yield Line(
                UNSIZED,
                f"the damping: none is given, and without one the slider rings for too long; all is told of one of "
                f"{part:.0%} of critical, {behaviour.damping * own.scale.spring:.3g} {unit}: give drive.damping",
            )
        if (regained := regained_by(verdict, behaviour)) is not None:
            drop, force = drop_of(behaviour) * own.scale.force, own.scale.force_unit
            back = drop - (remaining := regained * own.scale.force)
            yield Line(
                GENERAL,
                f"the slider rings after a slip, while its contacts are out: of the drop of {written(drop, force)} it "
                f"swings back by {written(back, force)} before it sticks, and the period is that of the other "
                f"{written(remaining, force)}",
            )


def _of_contacts(verdict: Verdict) -> Iterator[Line]:
    """The number of contacts, remarks on their thresholds, and what finitely many do."""
    own = verdict.own
    number, machine = own.scale.contacts, own.machine
    late = own.critical_spring.unknown or own.critical_spring.lost
    soft = machine is None or late or machine.spring < NEAR * own.critical_spring.value
    if number is not None and machine is not None and not soft:
        crowd = number * machine.spring**3
        yield Line(
            UNSIZED if crowd < SMOOTH_ABOVE and not own.softer else GENERAL,
            f"the number of contacts N: N K³ = {crowd:.2g}, K in N_c<k>; above K* sliding is smooth "
            f"only where it is above some {SMOOTH_ABOVE:g}",
        )
    yield from (
        Line(_size_of(verdict, one), one)
        for one in remarks(own.contacts.thresholds, machine is not None)
    )
    followed = [finite for finite in verdict.finite if finite.kind != "unknown"]
    # what the headline tells already, in place of infinitely many, is not told again
    alone = [one.sliders for one in own.behaviours if one.sliders and not one.sliders.message]
    followed = [finite for finite in followed if not any(finite is one for one in alone)]
    for said, rules in by_reason((_of_finite(verdict, one), one.rule) for one in followed).items():
        change = max(_change_by(verdict, one) for one in followed if one.rule in rules)
        yield Line(change, said.replace(RULE, named(rules)))
    unknown = [finite for finite in verdict.finite if finite.kind == "unknown"]
    for why, rules in by_reason(_unknown(verdict, one) for one in unknown).items():
        size = max(_not_followed(verdict, one) for one in unknown if one.rule in rules)
        yield Line(size, why.replace(RULE, named(rules)))


def _unknown(verdict: Verdict, many: Finite) -> tuple[str, str]:
    """Why so many contacts were not followed, and under which rule; RULE stands for it. Where fewer of them tell in
    place of infinitely many it says so."""
    own = next(one for one in verdict.own.behaviours if one.rule == many.rule)
    if many.slips:
        seen = "one slip" if many.slips == 1.0 else f"{many.slips:.2g} slips a slider, the last"
        fall = fall_of(many, verdict.own.scale)
        said = f"{of_contacts(many.contacts)}, if {RULE}: not known: {seen} of {fall} seen, and not followed further"
    elif own.contacts is None:
        said = f"the number of contacts was not looked at if {RULE}"
    else:
        said = f"{own.contacts:,} contacts stand for the {many.contacts:,} of the area if {RULE}"
    return f"{said}: {many.message}", many.rule


def _size_of(verdict: Verdict, remark: str) -> float:
    """By how much what a remark on the thresholds names may change the forces."""
    surface, uncertainties = verdict.own.contacts.interface, uncertainties_of(verdict)
    if "?" in remark:
        return TURNS
    if isinstance(surface, Interface):
        if remark == surface.plastic_caution:
            return surface.plastic_load_fraction or 0.0
        return UNSIZED if remark in surface.cautions else GENERAL
    return uncertainties.sampling or UNSIZED


def _change_by(verdict: Verdict, many: Finite) -> float:
    """By how much the forces of so many contacts differ from those of infinitely many; of more than were followed by
    N^(-2/3) as much."""
    one = next(each for each in verdict.own.behaviours if each.rule == many.rule)
    force = many.late if np.isfinite(many.late) else many.before
    if many.message and np.isfinite(many.late) and one.kind == "smooth":
        fraction = many.contacts / (verdict.own.scale.contacts or many.contacts)
        return abs(force - one.before) / abs(one.before) * min(fraction, 1.0) ** (2.0 / 3.0)
    if many.rule not in apart(verdict):
        return NOTHING
    alike = one.kind == many.kind or (one.kind == "smooth" and np.isfinite(many.late))
    return abs(force - one.before) / abs(one.before) if alike else TURNS


def _not_followed(verdict: Verdict, many: Finite) -> float:
    """By how much so many contacts may bear another force than infinitely many that do the same, about."""
    own = verdict.own
    # the second of the forces to which sliders are pulled, which most bear
    above = ABOVE[1] * many.contacts ** (-2.0 / 3.0) * own.contacts.mean_threshold
    return above / own.kinetic.value if own.kinetic.value > 0.0 else UNSIZED


def _of_finite(verdict: Verdict, finite: Finite) -> str:
    """What so many contacts do, in words; RULE stands for the slip rules under which they do so."""
    said = f"{of_contacts(finite.contacts)}, if {RULE}: {finite.kind}"
    late = late_force_of(finite, verdict.own.kinetic.value, verdict.own.scale)
    beside = f" ({finite.message})" * bool(finite.message) + late
    if finite.kind == "smooth":
        return said + fluctuating(finite, verdict.own.scale) + beside
    said += f", from {fall_of(finite, verdict.own.scale)}"
    if finite.smaller:
        every = finite.smaller + round(finite.slips * SLIDERS)
        said += f", beside far smaller falls, {finite.smaller} of {every}"
    if finite.kind == "stick-slip":
        return said + beside
    many = "1 slip" if finite.slips == 1.0 else f"{finite.slips:.2g} slips"
    return f"{said}, {many} a slider on the way that was followed{late}"
