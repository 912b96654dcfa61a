"""What one slider does under one slip rule: the drive goes on until it has slipped often enough, or slides."""

import time
from dataclasses import replace
from typing import Any

import numpy as np

from origins.contacts import Contacts
from origins.errors import InputError
from toolkit.results.kinds import kind_of
from toolkit.verdict.sliders.budget import (
    NO_DAMPING,
    NO_TIME,
    few_are_followed,
    few_in_heat_are_followed,
    lacks_damping,
    may_follow,
    without_useless_damping,
)
from toolkit.verdict.sliders.by_contacts import SWUNG
from toolkit.verdict.sliders.ensemble import follow_by_contacts, without_heat
from toolkit.verdict.sliders.forgetting import after_forgetting, forgets_its_start
from toolkit.verdict.sliders.in_heat import SLIDES, by_steady_sliding, with_stability
from toolkit.verdict.sliders.machine import Machine, RigidSlider, critical_damping
from toolkit.verdict.sliders.records import Behaviour, not_followed
from toolkit.verdict.sliders.steady import is_stable_with_delay, settling_distance
from toolkit.verdict.sliders.told import (
    PRECISE_ENOUGH,
    behaviour_of,
    error_of,
    hangs_on_heat,
    is_known,
)
from toolkit.verdict.sliders.ways import LOADINGS, loading_of
from toolkit.verdict.sliders.weak_heat import by_contacts_without_heat

# tolerance of the force, in mean thresholds: at T = 0, and where a law of the contacts depends on time
TOLERANCE, TOLERANCE_IN_TIME = 1e-6, 1e-3
# tolerance where it is only told whether the slider slips: slips of a third of it are listed
WHETHER_IT_SLIPS = 0.03
# tolerance of a slider with mass and a delay, of which 1e-3 takes some times as long; and of one whose contacts change
# with their age (the longest slips are those of contacts that strengthen) on a spring softer than SOFT, in N_c<k>:
# there places of slips are asked for, whose error adds up from slip to slip, and the forces of five on a scan are known
# to 0.04 then, after some hundred steps each
TOLERANCE_WITH_DELAY, TOLERANCE_OF_LONG_SLIPS, SOFT = 1e-2, 0.1, 1e-2
# lengths of the drive's path in loadings, from no force to the static one: tried one after the other
LENGTHS = (LOADINGS, 20.0, 60.0)
# the first length with mass and a delay: the slider swings to a force below 0, and its periods are up to 2 loadings
FIRST_WITH_DELAY = 9.0
# the first length where contacts grow stronger: it ends between the fifth slip and a sixth, on a scan, so that coarser
# steps, which have slips a little earlier, have as many
FIRST_OF_LONG_SLIPS = 5.8
# tolerance of F_s and K*, where they decide how far a slider is pulled, and of one that rings for too long
ROUGHLY = 1e-3
# parts of critical damping tried where none is given and the slider rings for too long: tolerance; time of the first
DAMPED, FIRST_DAMPED = {0.1: TOLERANCE, 1.0: ROUGHLY}, 0.25
# part of a slider's force that a damping which nobody gave may bear
ASSUMED = 0.1
# part of the time for the master equation where something else follows if it does not end, the ensemble or a damped
# slider: with mass; under a slip rule, with most s, as ordinary laws take a second there, with many peaks minutes
FIRST_OF_MASS, FIRST_OF_RULES, ENOUGH_OF_RULES = 0.5, 0.8, 10.0
# the same with a delay shorter than a slip, for which the master equation takes half a minute as a rule
FIRST_OF_SHORT = 0.65
# the same where steady sliding is stable, as slips may end after hundreds of delays, which the ensemble follows; or in
# heat beside a mass, as the master equation seldom knows the force at points near slips, or takes too many steps
FIRST_OF_STABLE = 0.25
# the same of readings other than the scene's own, in the rest of which a thousand contacts are followed in a moment
FIRST_OF_OTHERS = 0.85
# the same in heat, of which steps are refused in a moment as a rule, or lead nowhere, before other roads are asked
FIRST_IN_HEAT = 0.25
# slips that tell a regime, and part of a period by which the path goes on beyond them
ENOUGH_SLIPS, PART_OF_PERIOD = 5, 0.2
# part of the path, its last fifth, along which the force of smooth sliding is looked at for what still changes
SETTLED_IN = 5
STILL_SWINGS = "the slider still swings about its balance at the path's end"


def follow(
    machine: Machine,
    contacts: Contacts,
    rule: str,
    rigid: RigidSlider,
    wall_time: float,
    rings: bool = False,
    tolerance_in_time: float = TOLERANCE_IN_TIME,
    tolerance_at_once: float = TOLERANCE,
) -> Behaviour:
    """Pull the slider until its slips tell what follows, mostly five of them, or it slides steadily.

    wall_time : s; rings : whether an undamped slider is known to ring for too long, and is followed with some damping
    tolerance_in_time, tolerance_at_once : in mean thresholds, where a law of the contacts depends on time, and where
    none does
    What the solver does not take is "undecided", and its message says why. Where the master equation does not decide in
    time, the ensemble does, or F_k of contacts that have forgotten their start; an undamped slider is damped a little.
    Roads, in order: the master equation for a part of the time (in heat, steady sliding and contacts without heat in
    between); the ensemble, where it takes them; F_k after forgetting; a slider with some damping.
    """
    end = time.monotonic() + wall_time
    loading = loading_of(machine, contacts, rigid.static)
    cold = contacts if contacts.thermal is None else contacts.replace(thermal=None)
    undamped = machine.mass is not None and not machine.damping
    if undamped and rings:
        return _damped(machine, contacts, rigid, wall_time, tolerance_in_time)
    # without damping they ring on: while a slider is fast, contacts that form again break at once
    by_contacts = may_follow(machine, cold, rule, rigid) and not undamped
    first = FIRST_OF_MASS if rule == "mass" else FIRST_OF_RULES
    in_heat = rule == "mass" and contacts.thermal is not None and bool(contacts.waiting_time)
    if by_contacts and (in_heat or is_stable_with_delay(machine, contacts)):
        first = FIRST_OF_STABLE
    elif by_contacts and rule == "mass" and tolerance_in_time >= WHETHER_IT_SLIPS:
        first = FIRST_OF_OTHERS
    if rule == "mass" and not by_contacts and machine.damping and contacts.waiting_time:
        # a shorter delay, which the master equation takes as a rule; else a few contacts tell what as many do
        first, by_contacts = FIRST_OF_SHORT, few_are_followed(machine, cold, rigid.static)
    elif rule == "mass" and few_in_heat_are_followed(machine, contacts, rigid.static):
        first, by_contacts = FIRST_OF_STABLE, True
    until = end - (1.0 - first) * wall_time * (undamped or by_contacts)
    forgets = rule == "instant" and forgets_its_start(machine, contacts, rigid)
    if forgets or (by_contacts and rule != "mass" and not contacts.in_time):
        until = min(until, time.monotonic() + ENOUGH_OF_RULES)
    one_length = rule != "mass" and may_follow(machine, contacts, rule, rigid)
    lengths = LENGTHS[:1] if one_length else LENGTHS
    tolerance = tolerance_in_time if contacts.in_time else tolerance_at_once
    if rule == "mass" and contacts.waiting_time:
        tolerance = max(tolerance, TOLERANCE_WITH_DELAY)
        lengths = (FIRST_WITH_DELAY, *lengths[1:])
    elif rule == "mass" and contacts.changing is not None and machine.spring < SOFT:
        tolerance = max(tolerance, TOLERANCE_OF_LONG_SLIPS)
        lengths = (FIRST_OF_LONG_SLIPS, *lengths[1:])
    distances = [each * loading for each in lengths]

    def without(bare: Contacts, known: RigidSlider) -> Behaviour:
        return follow(machine, bare, rule, known, end - time.monotonic(), rings)

    parts = (FIRST_IN_HEAT, 1.0) if contacts.thermal is not None else (1.0,)
    for part in parts:
        late = min(until, time.monotonic() + part * wall_time)
        found = by_distribution(machine, contacts, rule, distances, late, tolerance)
        if found.kind != "undecided":
            return _settled(found, machine, rigid, contacts)
        if part < 1.0:
            roads = by_steady_sliding, by_contacts_without_heat
            for road in roads if rule in SLIDES else reversed(roads):
                told = road(machine, contacts, rule, rigid, until, without)
                if told is not None:
                    return told
        if found.refused or late == until:
            break
    found = with_stability(found, machine, contacts)
    # Cold where heat is known to change little. Where it matters, in heat, and beside a mass alone: the forces of a
    # slip rule in heat are the master equation's.
    left_out = None if hangs_on_heat(found) else found.heat_left_out
    matters = contacts.thermal is not None and left_out is None
    by_contacts &= not matters or rule == "mass"
    if by_contacts and (rule != "mass" or not found.success):
        followed = contacts if matters else cold
        other = follow_by_contacts(machine, followed, rule, loading, end, rigid)
        if other.kind == "undecided" and not other.slips:
            return found
        return other if left_out is None else without_heat(other, left_out)
    if forgets:
        return after_forgetting(machine, contacts, rigid, found)
    if undamped:
        damped = _damped(machine, contacts, rigid, end - time.monotonic(), tolerance_in_time)
        return damped if damped.kind != "undecided" or lacks_damping(damped.message) else found
    return found


def _settled(
    found: Behaviour, machine: Machine, rigid: RigidSlider, contacts: Contacts
) -> Behaviour:
    """Smooth sliding whose force still changes at the path's end, or is F_k within its error, at F_k and what the
    damping bears, to which it tends once contacts that began together have forgotten it, with the ends between which it
    swings until then. With a mass what still swings is the error, too, no less than what slips that shrink leave, as
    contacts that come back together hold it for less than from one point to the next. Exact thresholds may keep their
    order: the force is told as it is."""
    if found.kind != "smooth" or not found.drive.size:
        return found
    mean, waits = contacts.mean_threshold, machine.velocity * contacts.waiting_time
    late = found.drive >= found.drive[-1] - max(found.drive[-1] / SETTLED_IN, waits)
    change = float(np.ptp(found.force[late])) / mean
    steady, exact = rigid.kinetic + machine.damping * machine.velocity, contacts.thresholds.atoms[0]
    if machine.mass is None and change <= found.error:
        known = max(rigid.kinetic_error, found.left) / mean
        if exact.size or known > found.error or abs(found.before - steady) > found.error * mean:
            return found
        return replace(found, before=steady, after=steady, error=known)
    if exact.size:
        return replace(found, error=found.error + change)
    error, left = max(found.error, rigid.kinetic_error / mean), found.left / mean
    if machine.mass is not None:
        error = max(error, abs(found.after - steady) / mean, left)
    ends = float(found.force[late].min()), float(found.force[late].max())
    swings = ends if change > max(found.error, SWUNG * abs(steady) / mean) else None
    found = replace(found, before=steady, after=steady, swings=swings)
    if machine.mass is not None:
        return replace(found, error=max(error, change))
    return replace(found, error=error if swings else max(error, left))


def _damped(
    machine: Machine,
    contacts: Contacts,
    rigid: RigidSlider,
    wall_time: float,
    tolerance_in_time: float,
) -> Behaviour:
    """What an undamped slider with mass does with the first part DAMPED of its critical damping that decides: a tenth,
    and, where it rings for too long on stiff contacts, all of it, roughly."""
    end, damped = time.monotonic() + wall_time, machine
    for part, tolerance in DAMPED.items():
        damped = replace(machine, damping=part * critical_damping(machine))
        seconds = (end - time.monotonic()) * (FIRST_DAMPED if part < 1.0 else 1.0)
        found = follow(
            damped,
            contacts,
            "mass",
            rigid,
            seconds,
            tolerance_in_time=tolerance_in_time,
            tolerance_at_once=tolerance,
        )
        if found.kind != "undecided":
            break
    borne = damped.damping * machine.velocity / (abs(found.before) or np.inf)
    if found.kind != "undecided" and borne > ASSUMED:
        said = f"{part:.0%} of critical, with which the slider would come to rest, would bear {borne:.0%} of its force"
        return not_followed("mass", f"{NO_DAMPING}, and {said}: give drive.damping")
    return replace(found, damping=damped.damping)


def by_distribution(
    machine: Machine,
    contacts: Contacts,
    rule: str,
    lengths: list[float],
    until: float,
    tolerance: float,
) -> Behaviour:
    """What the master equation says along paths of these lengths, one after the other until one decides, by then, in s
    of the monotonic clock. A slider with mass is not called smooth before its swing has died away."""
    import master

    begin = contacts.start.mean() / machine.spring
    found, swings = not_followed(rule, NO_TIME), False
    settled = settling_distance(machine, contacts.mean_threshold)
    if lengths[-1] < settled < np.inf:
        lengths = [*lengths, settled]
    enough = np.inf  # where the slider will have slipped often enough, as its slips tell
    for given in lengths:
        length = min(given, enough, settled) if swings else min(given, enough)
        if swings and length < settled:
            continue
        path = begin + np.linspace(0.0, length, machine.points(length))
        if (remaining := until - time.monotonic()) <= 0.0:
            break
        try:
            solved: Any = master.solve(
                contacts, path, tolerance, wall_time=remaining, **machine.keywords(rule)
            )
        except InputError as error:
            # without the key and its value, which is in the solver's units, not in the user's
            key, _, why = str(error).partition(": ")
            # nor what path to give instead: it is the verdict's own
            why = without_useless_damping(why.replace("end the path sooner, or ", ""), machine)
            of_path = key.startswith("path") or "end the path" in why
            if of_path and "give a larger damping" not in why:
                why = why.partition("; ")[0]
            return replace(not_followed(rule, why or str(error)), refused=True)
        if found.slips and not is_known(solved):
            break  # what the shorter path told stands
        swings = kind_of(solved) == "smooth" and length < settled
        asked = machine.velocity, contacts.mean_threshold, STILL_SWINGS if swings else ""
        found = replace(behaviour_of(rule, solved, *asked), cut=solved.path.size < path.size)
        found = replace(found, message=without_useless_damping(found.message, machine))
        # where heat is left out its bound alone misses the tolerance, and a longer path is no harder
        cold = (
            found.heat_left_out is not None
            and solved.force_error < PRECISE_ENOUGH
            and not found.cut
        )
        goes_on = solved.success or cold or error_of(solved) <= tolerance
        # resets of few contacts are all alike from the second on, however far it is pulled
        if found.kind != "undecided" or found.few_break is not None or not goes_on:
            break
        enough = np.inf
        if solved.period is not None and found.slips < ENOUGH_SLIPS and not swings:
            more = ENOUGH_SLIPS - found.slips + PART_OF_PERIOD
            enough = float(solved.slips.drive[-1]) + more * solved.period - begin
    return found
