"""What a verdict hangs on, in lines: slip rule, readings, number of contacts; and what was not answered."""

from collections.abc import Iterator
from itertools import chain

import numpy as np

from origins.drive import RISE
from origins.roughness.interface import Interface
from toolkit.scene.barriers import of_barriers
from toolkit.scene.interfaces import NUMERICAL_ONLY, doubts, of_laws, remarks
from toolkit.scene.scale import in_three_digits, told_contacts, written
from toolkit.verdict.answers import Verdict
from toolkit.verdict.of_area import finite_told_apart, late_force_of
from toolkit.verdict.sliders.finite import ABOVE
from toolkit.verdict.sliders.late import SLIDERS
from toolkit.verdict.sliders.records import Finite
from toolkit.verdict.slips_in_words import after_slips, does, fall_of, fluctuating
from toolkit.verdict.text.k_star import SMOOTH_ABOVE
from toolkit.verdict.text.kinds import (
    GENERAL,
    NOTHING,
    TURNS,
    UNSIZED,
    Line,
    by_reason,
    named,
    worst_first,
)
from toolkit.verdict.text.of_delay import of_rules
from toolkit.verdict.text.of_mass import of_a_mass, why_no_more_slips
from toolkit.verdict.text.of_stuck_sliders import above_critical_spring, of_a_stuck_slider
from toolkit.verdict.text.undone import RULE, of_errors, of_readings, unanswered, with_rules
from toolkit.verdict.uncertainty import WORTH_TELLING, uncertainties_of, widest_uncertainty

# lines of the page; the others are in verdict.json
MOST = 8

# m/s, measured on rocks; of other materials and contacts it is another, which no scene knows
FLASH = 0.1


def dependence(verdict: Verdict) -> list[str]:
    """What the verdict hangs on, in full, the worst first."""
    return [line.text + line.more for line in _lines(verdict)]


def on_the_page(verdict: Verdict) -> list[str]:
    """What of it a page has: MOST lines at most, without their reasons, and none of what stands above; and where the
    others are."""
    lines = [one for one in _lines(verdict) if not one.above]
    left, shown = len(lines[MOST:]), lines[:MOST]
    there = [f"{left} more line{'s' * (left > 1)}"] * bool(left)
    there += ["the reasons of these"] * any(one.more for one in shown)
    said = [one.text for one in shown]
    return [*said, f"verdict.json (hangs_on) has {' and '.join(there)}"] if there else said


def _lines(verdict: Verdict) -> list[Line]:
    """All lines: slip rule, readings, number of contacts; what was not answered."""
    lines = (
        of_rules(verdict),
        of_readings(verdict),
        _of_a_speed(verdict),
        of_a_stuck_slider(verdict),
        above_critical_spring(verdict),
        of_a_mass(verdict),
        _of_contacts(verdict),
        unanswered(verdict),
        of_errors(verdict),
    )
    return worst_first(chain(*lines))


def _of_a_speed(verdict: Verdict) -> Iterator[Line]:
    """A speed that is not given, or is that of a path which is left out; and notes on temperature and stiffness."""
    own = verdict.own
    if verdict.left_path:
        said = f"not the path of drive.{verdict.left_path}, which is left out: the drive goes one way, at "
        yield Line(GENERAL, said + own.scale.speed(verdict.velocity))
    machine, in_time = own.machine, bool(own.contacts.in_time)
    matters = in_time or machine is not None
    if matters and not verdict.velocity_given and own.scale.length_unit == "m":
        decides = in_time or (machine is not None and machine.mass is not None)
        what = "forces and slips hang on it, and all times" if decides else "all times hang on it"
        what = what if machine is not None else "forces and K* hang on it"
        given = "none is given, and 1 m/s is taken"
        yield Line(
            TURNS if decides else UNSIZED, f"the speed: {given}; {what}: give drive.velocity"
        )
    if verdict.velocity_given and own.scale.length_unit == "m" and verdict.velocity >= FLASH:
        fast, flash = (own.scale.speed(one) for one in (verdict.velocity, FLASH))
        yield Line(
            UNSIZED,
            f"heat of sliding, which is left out: the drive goes at {fast}, and contacts of rocks weaken by flash "
            f"heating above some {flash} (Goldsby and Tullis, Science 334, 216, 2011)",
        )
    barriers, first = of_barriers(own.contacts), doubts(own.contacts)
    for one in of_laws(own.contacts):
        if one not in first:
            yield Line(TURNS if one in barriers else UNSIZED, one)


def why_smooth(verdict: Verdict) -> list[str]:
    """Why a slider below K* slides, in a sentence that stands below the table, beside K*."""
    own = verdict.own
    smooth = [one for one in own.behaviours if one.kind == "smooth"]
    if not smooth or not own.softer:
        return []
    force, unit = own.scale.force, own.scale.force_unit
    fall = own.static.value - own.kinetic.value
    # a difference of two forces is known less well than either
    digits = 2 if widest_uncertainty(verdict) > WORTH_TELLING else 3
    small_fall = written(fall * force, unit, digits=digits)
    rules = (
        "" if len(smooth) == len(own.behaviours) else f" if {named([one.rule for one in smooth])}"
    )
    begin = "K is below K*, and yet " * (not own.smoothed)
    few = [finite_told_apart(verdict).get(one.rule) for one in smooth]
    whose = " for infinitely many contacts" * any(one and one.kind != "smooth" for one in few)
    said = f"{begin}sliding is smooth{whose}{rules}: "
    cold = not own.contacts.held_in_time or all(one.without_heat for one in smooth)
    small = RISE * own.contacts.mean_threshold
    if all(one.rule == "mass" and not one.slips for one in smooth) and cold and fall < small:
        return [
            f"{said}the fall from F_s to F_k, {small_fall}, is too small to count as a slip of a "
            f"slider with mass (from {written(small * force, unit)} on, {RISE:g} <x_s>)"
        ]
    if not cold and not any(one.slips for one in smooth):
        return [
            f"{said}contacts break by themselves, and the slider creeps, ever faster, up to the speed of its drive"
        ]
    ends = f"F_s, {small_fall} above F_k," if fall > 0.0 else "a rise to F_k"
    after = f"after {ends} " * cold
    # main slips alone: whether small falls before them are followed hangs on the time that there is
    seen = [one.slips - one.smaller for one in smooth]
    often = " to ".join(f"{one:,}" for one in dict.fromkeys((min(seen), max(seen))))
    words = {"0": "no more", "1": "once, and then no more", "0 to 1": "at most once"}
    often = words.get(often, f"{often} times, and then no more")
    if any(one.swings and one.shrinks_by for one in smooth):
        often = (
            f"{max(seen):,} times on the way that was followed, ever less, and in the end no more"
        )
    # of the area's contacts, which may slip otherwise, and are followed where there is time, a line tells
    who = "the slider slips"
    if verdict.finite and not whose and all(one.contacts is None for one in smooth):
        who = "a slider of infinitely many contacts slips"
    return [f"{said}{after}{who} {often}, {why_no_more_slips(own)}"]


def _of_contacts(verdict: Verdict) -> Iterator[Line]:
    """The number of contacts, remarks on their thresholds, and what finitely many do."""
    own = verdict.own
    number, machine = own.scale.contacts, own.machine
    late = own.critical_spring.unknown or own.critical_spring.lost
    nothing_slips = any(one.heat_on_the_way is not None for one in own.behaviours)
    # K* of contacts that change is that of new ones, above which any number may slip
    told_else = own.contacts.changing is not None or nothing_slips
    if not (number is None or machine is None or late or own.softer or told_else):
        crowd = number * machine.spring**3
        yield Line(
            UNSIZED if crowd < SMOOTH_ABOVE else GENERAL,
            f"the number of contacts N: N K³ = {crowd:.2g}, K in N_c<k>; below some {SMOOTH_ABOVE:g} "
            "contacts may slip by chance above K*, too",
        )
    above = doubts(own.contacts) + [NUMERICAL_ONLY] * (len(verdict.answers) > 1)  # by their range
    for one in remarks(own.contacts.thresholds, machine is not None):
        yield Line(_size_of(verdict, one), one, above=any(one in each for each in above))
    # what the headline tells already, in place of infinitely many, is not told again
    alone = [one.finite for one in own.behaviours if one.finite and not one.finite.message]
    followed = [few for few in verdict.finite if not any(few is one for one in alone)]
    followed = [few for few in followed if few.kind != "unknown"]
    for said, rules in by_reason((_of_finite(verdict, one), one.rule) for one in followed).items():
        change = max(_change_by(verdict, one) for one in followed if one.rule in rules)
        # with these forces; of slips now and then the answer may tell the force between them alone
        sure = {one.rule for one in followed if one.kind in ("stick-slip", "smooth")}
        told_above = finite_told_apart(verdict).keys() & sure | _told_already(verdict, followed)
        told = set(rules) <= told_above
        yield Line(change, with_rules(said, rules, verdict.own), above=told)
    # where infinitely many are not decided either, what to do stands beside these
    no_news = {one.rule for one in own.behaviours if one.kind == "undecided" and not one.slips}
    unknown = [one for one in verdict.finite if one.kind == "unknown"]
    unknown = [one for one in unknown if one.slips or one.rule not in no_news]
    for why, rules in by_reason(_unknown(verdict, one) for one in unknown).items():
        size = max(_not_followed(verdict, one) for one in unknown if one.rule in rules)
        yield Line(size, with_rules(why, rules, verdict.own))


def _told_already(verdict: Verdict, followed: list[Finite]) -> set[str]:
    """Slip rules under which as many contacts as tell the answer were followed once more."""
    telling = {one.rule: one.contacts for one in verdict.own.behaviours}
    return {one.rule for one in followed if telling[one.rule] == one.contacts}


def _unknown(verdict: Verdict, finite: Finite) -> tuple[str, str]:
    """Why so many contacts were not followed, and under which rule; RULE stands for it. Where fewer of them tell in
    place of infinitely many it says so."""
    own = next(one for one in verdict.own.behaviours if one.rule == finite.rule)
    if finite.slips:
        seen = "one slip" if finite.slips == 1.0 else f"{finite.slips:.2g} slips a slider, the last"
        fall = fall_of(finite, verdict.own.scale)
        who = told_contacts(finite.contacts)
        said = f"{who}, if {RULE}: not known: {seen} of {fall} seen, and not followed further"
    elif own.contacts is None:
        said = f"what {told_contacts(finite.contacts)} do if {RULE} is not known"
    else:
        said = f"{told_contacts(own.contacts)} stand for the {in_three_digits(finite.contacts)} of the area if {RULE}"
    return f"{said}: {finite.message}", finite.rule


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


def _change_by(verdict: Verdict, finite: Finite) -> float:
    """By how much the forces of so many contacts differ from those of infinitely many; of more than were followed by
    N^(-2/3) as much."""
    one = next(each for each in verdict.own.behaviours if each.rule == finite.rule)
    force = finite.late if np.isfinite(finite.late) else finite.before
    if finite.message and np.isfinite(finite.late) and one.kind == "smooth":
        fraction = finite.contacts / (verdict.own.scale.contacts or finite.contacts)
        return abs(force - one.before) / abs(one.before) * min(fraction, 1.0) ** (2.0 / 3.0)
    if finite.rule not in finite_told_apart(verdict):
        return NOTHING
    alike = one.kind == finite.kind or (one.kind == "smooth" and np.isfinite(finite.late))
    return abs(force - one.before) / abs(one.before) if alike else TURNS


def _not_followed(verdict: Verdict, finite: Finite) -> float:
    """By how much so many contacts may bear another force than infinitely many that do the same, about."""
    own = verdict.own
    # the second of the forces to which sliders are pulled, which most bear
    above = ABOVE[1] * finite.contacts ** (-2.0 / 3.0) * own.contacts.mean_threshold
    return above / own.kinetic.value if own.kinetic.value > 0.0 else UNSIZED


def _of_finite(verdict: Verdict, finite: Finite) -> str:
    """What so many contacts do, in words; RULE stands for the slip rules under which they do so."""
    said = f"{told_contacts(finite.contacts)}, if {RULE}: {does(finite)}"
    late = late_force_of(finite, verdict.own.kinetic.value, verdict.own.scale)
    beside = f" ({finite.message})" * bool(finite.message) + late
    if finite.kind == "smooth":
        return said + after_slips(finite.slips) + fluctuating(finite, verdict.own.scale) + beside
    said += f", from {fall_of(finite, verdict.own.scale)}"
    if finite.smaller:
        every = finite.smaller + round(finite.slips * SLIDERS)
        said += f", beside far smaller falls, {finite.smaller} of {every}"
    if finite.kind == "stick-slip":
        return said + beside
    many = "1 slip" if finite.slips == 1.0 else f"{finite.slips:.2g} slips"
    return f"{said}, {many} a slider on the way that was followed{late}"
