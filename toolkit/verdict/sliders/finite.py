"""What finitely many contacts do: sliders of as many contacts as the area holds, beside the infinitely many of the
master equation."""

import time
from dataclasses import replace
from itertools import pairwise
from typing import Any, NamedTuple, cast

import numpy as np

from origins.contacts import Contacts
from origins.drive import RISE
from origins.errors import InputError
from origins.thresholds.law import Array
from toolkit.results.sliding import has_slid, late_force, may_go_on, mean_forces, scatter_of
from toolkit.results.slips import (
    are_fading,
    are_lasting,
    large_slips,
    main_slips,
    regained_at,
    slips_after,
    slips_beyond,
    swing_beyond_slips,
    with_main_slips,
)
from toolkit.results.traces import trace_of
from toolkit.scene.scale import in_three_digits, length_unit_of, spoken, told_contacts
from toolkit.verdict.sliders.budget import most_breaks, taken_on_springs
from toolkit.verdict.sliders.ensemble import (
    MOST_CONTACTS,
    NOT_SLID,
    PILOT,
    RINGS,
    sliders,
    until_settled,
)
from toolkit.verdict.sliders.late import (
    SLIDERS,
    if_it_recurs,
    in_the_end,
    renew_all,
    with_late_slips,
)
from toolkit.verdict.sliders.machine import Machine
from toolkit.verdict.sliders.plans import BEYOND, Asked
from toolkit.verdict.sliders.records import Behaviour, Finite
from toolkit.verdict.sliders.slips_in_time import slips_in_time
from toolkit.verdict.sliders.steady import settling_distance
from toolkit.verdict.sliders.ways import breaks_until

# times these: an estimate up to this is taken on, too, so that the number of contacts need not be lowered again
MORE = 1.01
# Where the force rises by this part of a drop above that before any slip, the slips are not those of the force; and the
# part of the drop of infinitely many contacts by which it has to swing for this to be said.
UNSEEN, SWING_OF_DROP = 0.08, 0.5
# of the path, and of its end, where the force of those that slide is looked at
POINTS = 100
# of BEYOND, for the scatter of the places at which sliders with mass begin to slide
SCATTERED = 0.3
# part of BEYOND after which the force is taken as that of steady sliding
SETTLED = 0.5
# times the drive's way on which the spring regains what a slip took: so far several more are seen where they go on
SEVERAL = 3.5
# mean thresholds, times N^(-2/3), by which the drive pulls contacts that re-form at once beyond the force of infinitely
# many, one after the other until they slide at an even force: theirs is above it by 3 (thresholds 1 ± 0.2) to 9
# (exponential ones, 16 on K = 1e-5), so that from LEAST_ABOVE on they may slide
ABOVE, LEAST_ABOVE = (7.5, 12.5, 17.5, 22.5), 3.0
# mean thresholds that each slider has moved by once it slides, and does not only stretch its contacts: between two
# slips on a soft spring the force rises with the drive; and times as long as a step of ABOVE that the next may take
FAR, LONGER = 100.0, 3.0


def follow_finite(
    machine: Machine,
    contacts: Contacts,
    number: float,
    infinite: Behaviour,
    static: float,
    seconds: float,
) -> Finite:
    """Follow sliders of so many contacts; `infinite`: what infinitely many do under the same rule.

    static : F_s/(N_c <k>) (a length); seconds : to be done by then, else they are not followed
    """
    if infinite.damping is not None:  # infinitely many were followed with one that is not given
        machine = replace(machine, damping=infinite.damping)
    if infinite.heat_left_out is not None:  # nor do finitely many need it
        contacts = contacts.replace(thermal=None)
    asked = Asked(machine, contacts, number, infinite, static)
    until, found = time.monotonic() + seconds, None
    for least, above in pairwise((LEAST_ABOVE, *ABOVE)):
        began = time.monotonic()
        longer = _pulled(asked, until - began, above, above - least)
        if found is not None and longer.kind == "unknown":
            return found if found.kind != "unknown" else longer
        found, now = longer, time.monotonic()
        slid = not (found.rises or found.message == NOT_SLID)
        # those that begin to slide take longer the further they are pulled
        if slid or not asked.settles or until - now < LONGER * (now - began):
            break
    return cast(Finite, found)


class Way(NamedTuple):
    """The points of the drive, X_T (n,); `steady`, the distance from the first of them behind which the force is taken
    as that of steady sliding; and `settling`, the part of the way that a transient takes at least (lengths)."""

    path: Array
    steady: float
    settling: float


def _pulled(asked: Asked, seconds: float, above: float, sliding: float) -> Finite:
    """As `follow_finite`, with contacts that re-form at once pulled `above` the force of infinitely many, on the last
    part of which, `sliding`, they slide at most: both in mean thresholds times N^(-2/3)."""
    until = time.monotonic() + seconds
    machine, contacts, infinite = asked.machine, asked.contacts, asked.infinite
    rule, present, mean = infinite.rule, asked.present, contacts.mean_threshold
    if not taken_on_springs(contacts):
        why = "contacts that age are not followed on a spring here"
        return Finite(rule, present, "unknown", message=why)
    plan = asked.planned(present, above, sliding)
    breaks_of_all, most = plan.breaks, most_breaks(contacts, rule)
    # fewer contacts have to be pulled further
    followed, known = min(present, MOST_CONTACTS), infinite.contacts or 0
    while (
        followed >= min(present, PILOT)
        and (plan := asked.planned(followed, above, sliding)).breaks > MORE * most
    ):
        followed = int(followed * most / plan.breaks)
    if followed < min(present, PILOT) or followed < min(present, known + 1):
        why = f"some {breaks_of_all:.1g} breaks are more than are followed here"
        return Finite(rule, present, "unknown", message=why)
    # the static force of so many scatters by some N^(-1/2) of itself
    further = asked.static / np.sqrt(present) / machine.spring / mean
    if asked.heavy and not asked.sticks and further > SCATTERED * BEYOND:
        scatter = f"F_s of such sliders scatters by some {100.0 * present**-0.5:.2g}%"
        far = spoken(further * mean, length_unit_of(contacts.thresholds))
        why = (
            f"{scatter}, and on this spring they begin to slide {far} of the drive's way apart, which takes too long "
            "to follow"
        )
        return Finite(rule, present, "unknown", message=why)
    steady = plan.end - SETTLED * BEYOND * mean
    count = machine.points(plan.end) if asked.heavy else POINTS
    points = np.unique(np.linspace([0.0, max(steady, 0.0)], plan.end, count))
    path = contacts.start.mean() / machine.spring + points
    try:
        found = sliders(machine, contacts, rule, path, followed, seconds, known=known)
    except InputError as refused:
        return Finite(rule, present, "unknown", message=str(refused))
    # contacts that are out do not bear the slider
    settling, of_transient = SETTLED * BEYOND * mean + asked.waits, _slips_of_transient(asked)
    # after a slip to no force the next on a soft spring is far beyond BEYOND
    if (
        not asked.sticks
        and not asked.settles
        and may_go_on(found, machine.spring, settling, of_transient)
    ):
        seen, end = found, regained_at(found.slips, machine.spring, SEVERAL) + BEYOND * mean
        end += SEVERAL * asked.waits
        steady = end - path[0] - settling
        path = path[0] + np.unique(np.linspace([0.0, steady], end - path[0], count))
        breaks, number = breaks_until(end, seen, mean), seen.contacts // SLIDERS
        number = min(number, int(number * MORE * most / breaks))
        try:
            if number < min(present, PILOT):
                raise InputError(f"some {breaks:.1g} breaks are more than are followed here")
            found = sliders(machine, contacts, rule, path, number, until - time.monotonic())
        except InputError as refused:
            told = Finite(rule, seen.contacts // SLIDERS, "unknown", message=str(refused))
            return with_late_slips(told, seen.slips)
    renewed = asked.sticks_on and renew_all(main_slips(found.slips), found.contacts // SLIDERS)
    if not (asked.settles or renewed):
        found = until_settled(found, machine, contacts, rule, until, settling)
        path, steady = found.path, max(steady, float(np.ptp(found.path)) - settling)
    return _judged(asked, found, Way(path, steady, settling))


def _slips_of_transient(asked: Asked) -> int:
    """How many slips finitely many contacts have beside those that go on: infinitely many that slide may have slipped
    before, and contacts that re-form at once forget their start in many slips, as F falls from static to kinetic."""
    return asked.infinite.slips if asked.flowing else 0


def _sliding_with_mass(finite: Finite, found: Any, settled: Array, unit: float) -> Finite:
    """With the force of sliders with mass at these last points of their way, of which damping bears a part; "unknown"
    where it still swings there. `unit`: the mean threshold."""
    swing = float(np.ptp(found.forces[:, settled], axis=1).max()) / unit
    if swing > RINGS:
        why = f"their force still swings at the end of the way, by {swing:.2g} <x_s>"
        return replace(finite, kind="unknown", message=why)
    each = mean_forces(found, settled)
    error = float(each.std(ddof=1)) / SLIDERS**0.5
    return replace(finite, late=float(each.mean()), late_error=error)


def _slips_late(asked: Asked, found: Any, way: Way) -> bool:
    """Whether sliders whose slips are not known to last may slip beyond the way, see `may_go_on`; of contacts that
    re-form at once, whether they slip on the part that counts as steady sliding."""
    if asked.settles:
        return bool((found.slips.drive > way.path[0] + way.steady).any())
    return may_go_on(found, asked.machine.spring, way.settling, _slips_of_transient(asked))


def _judged(asked: Asked, found: Any, way: Way) -> Finite:
    """What sliders do that were followed along a way."""
    machine, contacts, infinite = asked.machine, asked.contacts, asked.infinite
    rule, present, mean = infinite.rule, asked.present, contacts.mean_threshold
    sticks, settles = asked.sticks, asked.settles
    path, steady, _ = way
    drive, force = trace_of(found, 0, machine.velocity)
    seen = found.slips.drive.size
    if settles:
        found = replace(found, slips=large_slips(found.slips, RISE * mean))
    found = with_main_slips(found) if sticks else found
    in_time = slips_in_time(main_slips(found.slips))
    counts = np.bincount(found.slips.replica, minlength=SLIDERS)
    if not counts.any() and not has_slid(found, mean):
        return Finite(rule, present, "unknown", message=NOT_SLID)
    drop = infinite.before - infinite.after if sticks else 0.0
    own_drop = float(found.slips.drop.mean()) if counts.any() else drop
    swing = swing_beyond_slips(found, UNSEEN * own_drop) if sticks else 0.0
    if swing > SWING_OF_DROP * drop > 0.0:
        why = f"their force swings by {swing / mean:.2g} <x_s>, in falls of few of them each"
        return Finite(rule, present, "unknown", message=why)
    # nobody knows how many of the slips that were seen of infinitely many are followed by others
    if (asked.flowing or infinite.slips) and infinite.kind == "undecided":
        number, main = found.contacts // SLIDERS, main_slips(found.slips)
        sticks = are_lasting(main, SLIDERS)
        rings = asked.heavy and settling_distance(machine, mean) > np.ptp(path)
        if rings and not (sticks and infinite.slips):
            # falls may be those of a swing, but for those that last as they were seen of infinitely many
            why = (
                "a swing of the mass takes longer to die away than their way: give a larger damping"
            )
            return Finite(rule, present, "unknown", message=why)
        # those of all contacts are over where these have slid on since
        over = number >= present and not _slips_late(asked, found, way)
        if not (sticks or over) and (counts.any() or infinite.slips):
            why = f"{in_three_digits(number)} slip, perhaps only until they slide: what infinitely many do is not known"
            return Finite(rule, present, "unknown", message=why if counts.any() else NOT_SLID)
        found = replace(found, slips=main) if sticks else found
    # where infinitely many slide, they may have slipped before, as F fell from static to kinetic
    more = counts - (0 if sticks else infinite.slips)
    if not sticks:
        go_on = _slips_late(asked, found, way)
        if not go_on:
            more[:] = 0  # chance has given them some more, and they are over
        elif (more > 0).any() and are_fading(found.slips):
            who = told_contacts(found.contacts // SLIDERS)
            last = found.slips.drop[found.slips.number == counts.min() - 1].mean() / mean
            why = f"{who} slip ever less, by {last:.2g} <x_s> at the end of the way, as infinitely many do"
            return Finite(rule, present, "unknown", message=why)
        elif not settles and more.min() < 1:
            # some slip once more than others; those of a transient are over by the middle of the way
            late = slips_beyond(found.slips, float(path[[0, -1]].mean()))
            more = np.minimum(more, np.bincount(late.replica, minlength=SLIDERS))
            found = replace(found, slips=late) if (more > 0).any() else found
        elif (more > 0).any():  # those that infinitely many have, too, are not told
            found = replace(found, slips=slips_after(found.slips, infinite.slips))
        seen = found.slips.drive.size
    kind = "stick-slip" if more.min() >= 1 else "now and then" if (more > 0).any() else "smooth"
    followed, message = found.contacts // SLIDERS, ""
    if followed < present:
        message = f"as infinitely many do, and so the {in_three_digits(present)} of the area, which lie between"
        if infinite.contacts is not None:  # few contacts told of it
            message = f"the {in_three_digits(present)} of the area break too often to be followed"
        if kind != infinite.kind:
            other = "do something else than infinitely many"
            if infinite.kind == "undecided":
                other = "do what is not known of infinitely many"
            message = f"{in_three_digits(present)} take too long, and {in_three_digits(followed)} {other}: {kind}"
            return Finite(rule, present, "unknown", message=message)
    finite = Finite(
        rule, followed, kind, message=message, drive=drive, force=force, in_time=in_time
    )
    if counts.any():
        main = found.slips if settles else main_slips(found.slips)
        smaller = 0 if settles else seen - main.drive.size
        finite = with_late_slips(replace(finite, smaller=smaller), main)
        if kind == "stick-slip" and infinite.kind == "smooth":  # by chance
            finite = if_it_recurs(finite, main, float(path[-1]), machine.spring if settles else 0.0)
        if not settles and (kind != "smooth" or infinite.kind != "undecided"):
            lasting = kind == "stick-slip" and rule == "mass" and not message
            asked_of = replace(found, slips=main)
            return in_the_end(finite, asked_of, machine, contacts) if lasting else finite
    # the part of the way along which the force is taken as that of steady sliding
    settled = path >= path[0] + steady
    forces = found.forces[:, settled]
    finite = replace(finite, fluctuation=scatter_of(forces))
    if rule == "mass" and infinite.kind != "undecided":
        return finite
    if rule == "mass":
        return _sliding_with_mass(finite, found, settled, mean)
    late = late_force(forces, path[settled], machine.spring, lives=SETTLED * BEYOND)
    moved = float((found.positions[:, -1] - found.positions[:, 0]).min())
    rises = late.rises and moved < FAR * mean
    return replace(finite, late=late.mean, late_error=late.error, rises=rises)
