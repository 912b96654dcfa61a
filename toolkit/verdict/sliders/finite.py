"""What finitely many contacts do: sliders of as many contacts as the area holds, beside the infinitely many of the
master equation."""

import time
from collections.abc import Iterable
from dataclasses import replace
from itertools import pairwise
from typing import Any, NamedTuple, cast

import numpy as np

from origins.contacts import Contacts
from origins.errors import InputError
from toolkit.results.sliding import may_go_on
from toolkit.results.slips import main_slips, regained_at
from toolkit.scene.scale import length_unit_of, spoken
from toolkit.verdict.sliders.budget import most_breaks, taken_on_springs
from toolkit.verdict.sliders.ensemble import MOST_CONTACTS, NOT_SLID, PILOT, sliders, until_settled
from toolkit.verdict.sliders.judged import SETTLED, Way, judged, slips_of_transient
from toolkit.verdict.sliders.late import SLIDERS, renew_all, with_late_slips
from toolkit.verdict.sliders.machine import Machine
from toolkit.verdict.sliders.plans import BEYOND, Asked
from toolkit.verdict.sliders.records import Behaviour, Finite
from toolkit.verdict.sliders.ways import breaks_until

# times these: an estimate up to this is taken on, too, so that the number of contacts need not be lowered again
MORE = 1.01
# of the path, and of its end, where the force of those that slide is looked at
POINTS = 100
# of BEYOND, for the scatter of the places at which sliders with mass begin to slide
SCATTERED = 0.3
# times the drive's way on which the spring regains what a slip took: so far several more are seen where they go on
SEVERAL = 3.5
# mean thresholds, times N^(-2/3), by which the drive pulls contacts that re-form at once beyond the force of infinitely
# many, one after the other until they slide at an even force: theirs is above it by 3 (thresholds 1 ± 0.2) to 9
# (exponential ones, 16 on K = 1e-5), so that from LEAST_ABOVE on they may slide
ABOVE, LEAST_ABOVE = (7.5, 12.5, 17.5, 22.5), 3.0
# times as long as a step of ABOVE that the next may take
LONGER = 3.0
# of a force: two that differ by less are one
ONE_FORCE = 1e-6
# slip rules that renew contacts after a slip
RENEWING = {"reset", "reform-after"}


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
        try:
            longer = _pulled(asked, until - began, above, above - least)
        except InputError as why:
            longer = Finite(infinite.rule, asked.present, "unknown", message=str(why))
        if found is not None and longer.kind == "unknown":
            return found if found.kind != "unknown" else longer
        found, now = longer, time.monotonic()
        slid = not (found.rises or found.message == NOT_SLID)
        # those that begin to slide take longer the further they are pulled
        if slid or not asked.settles or until - now < LONGER * (now - began):
            break
    return cast(Finite, found)


class _Plan(NamedTuple):
    """Where the drive's way ends (a length), and how many contacts of each slider are followed on it."""

    end: float
    contacts: int


def _planned(asked: Asked, above: float, sliding: float) -> _Plan:
    """How far as many contacts are pulled as can be followed, see `_pulled`. Raises InputError where these are too few,
    or the way is too long."""
    if not taken_on_springs(asked.contacts):
        raise InputError("contacts that age are not followed on a spring here")
    present, mean = asked.present, asked.contacts.mean_threshold
    plan = asked.planned(present, above, sliding)
    breaks_of_all, most = plan.breaks, most_breaks(asked.contacts, asked.infinite.rule)
    followed = min(present, MOST_CONTACTS)
    least = min(present, max(PILOT, (asked.infinite.contacts or 0) + 1))
    # fewer contacts have to be pulled further
    while (
        followed >= least and (plan := asked.planned(followed, above, sliding)).breaks > MORE * most
    ):
        followed = int(followed * most / plan.breaks)
    if followed < least:
        raise InputError(f"some {breaks_of_all:.1g} breaks are more than are followed here")
    # the static force of so many scatters by some N^(-1/2) of itself
    further = asked.static / np.sqrt(present) / asked.machine.spring / mean
    if asked.heavy and not asked.sticks and further > SCATTERED * BEYOND:
        scatter = f"F_s of such sliders scatters by some {100.0 * present**-0.5:.2g}%"
        far = spoken(further * mean, length_unit_of(asked.contacts.thresholds))
        raise InputError(
            f"{scatter}, and on this spring they begin to slide {far} of the drive's way apart, which takes too long "
            "to follow"
        )
    return _Plan(plan.end, followed)


def _pulled(asked: Asked, seconds: float, above: float, sliding: float) -> Finite:
    """As `follow_finite`, with contacts that re-form at once pulled `above` the force of infinitely many, on the last
    part of which, `sliding`, they slide at most: both in mean thresholds times N^(-2/3). Raises InputError where they
    are not followed, or what they do does not tell what they go on to do."""
    until = time.monotonic() + seconds
    machine, contacts, infinite = asked.machine, asked.contacts, asked.infinite
    rule, mean = infinite.rule, contacts.mean_threshold
    plan = _planned(asked, above, sliding)
    steady = plan.end - SETTLED * BEYOND * mean
    count = machine.points(plan.end) if asked.heavy else POINTS
    points = np.unique(np.linspace([0.0, max(steady, 0.0)], plan.end, count))
    path = contacts.start.mean() / machine.spring + points
    known = infinite.contacts or 0
    found = sliders(machine, contacts, rule, path, plan.contacts, seconds, known=known)
    # contacts that are out do not bear the slider
    way = Way(path, steady, SETTLED * BEYOND * mean + asked.waits)
    of_transient = slips_of_transient(asked)
    # after a slip to no force the next on a soft spring is far beyond BEYOND
    further = not (asked.sticks or asked.settles)
    if further and may_go_on(found, machine.spring, way.settling, of_transient):
        try:
            found, way = _pulled_further(asked, found, way, count, until)
        except InputError as refused:
            told = Finite(rule, found.contacts // SLIDERS, "unknown", message=str(refused))
            return with_late_slips(told, found.slips)
    renewed = asked.sticks_on and renew_all(main_slips(found.slips), found.contacts // SLIDERS)
    if not (asked.settles or renewed):
        found = until_settled(found, machine, contacts, rule, until, way.settling)
        steady = max(way.steady, float(np.ptp(found.path)) - way.settling)
        way = Way(found.path, steady, way.settling)
    return judged(asked, found, way)


def _pulled_further(asked: Asked, seen: Any, way: Way, count: int, until: float) -> tuple[Any, Way]:
    """Sliders as those that were `seen`, or of fewer contacts, on a way on which they slip several times more if they
    go on so, of `count` points, and as many where they slide. Raises InputError where these are not followed."""
    machine, contacts, rule = asked.machine, asked.contacts, asked.infinite.rule
    mean, begin, number = contacts.mean_threshold, way.path[0], seen.contacts // SLIDERS
    end = regained_at(seen.slips, machine.spring, SEVERAL) + BEYOND * mean
    end += SEVERAL * asked.waits
    steady = end - begin - way.settling
    path = begin + np.unique(np.linspace([0.0, steady], end - begin, count))
    breaks = breaks_until(end, seen, mean)
    number = min(number, int(number * MORE * most_breaks(contacts, rule) / breaks))
    if number < min(asked.present, PILOT):
        raise InputError(f"some {breaks:.1g} breaks are more than are followed here")
    found = sliders(machine, contacts, rule, path, number, until - time.monotonic())
    return found, Way(path, steady, way.settling)


def told_by_another_rule(
    one: Behaviour, before: Iterable[tuple[Behaviour, Finite]], contacts: Contacts
) -> Finite | None:
    """What the contacts of the area do under the rule of `one`, by those followed `before` under another, each beside
    what infinitely many do; None where none tells it.

    Where nobody slips no rule acts. Contacts that break by heat or grow are dear, and count so; others are followed
    under each rule, as on soft springs small avalanches raise the force of those that re-form at once. Where each slip
    leaves no force all contacts have broken in it, and begin anew by both rules, if they do not wait.
    """
    for other, seen in before:
        if other.kind != one.kind or other.heat_left_out != one.heat_left_out:
            continue
        known = seen.kind in ("smooth", "unknown")  # nor would there be time for them
        nobody = known and one.kind == "smooth" and not (seen.slips or one.slips or other.slips)
        emptied = (one.after, other.after, seen.after, seen.after_error) == (0.0, 0.0, 0.0, 0.0)
        alike = abs(one.before - other.before) <= ONE_FORCE * abs(other.before)
        renewed = {one.rule, other.rule} == RENEWING and not contacts.waiting_time
        slips = seen.kind == one.kind == "stick-slip" and emptied and alike and renewed
        if slips or (nobody and contacts.held_in_time and not seen.rises):
            return replace(seen, rule=one.rule)
    return None
