"""Sliders of the ensemble: where the master equation takes no such slider, or not in time."""

import time
from dataclasses import replace
from typing import Any

import numpy as np

from origins.contacts import Contacts
from origins.errors import InputError
from origins.thresholds.law import Array
from toolkit.processes.ranks import cores_of
from toolkit.results.sliding import has_slid
from toolkit.results.slips import late_slips, with_main_slips
from toolkit.results.traces import trace_of
from toolkit.scene.scale import told_contacts
from toolkit.verdict.sliders.budget import MORE_TIME, SHORT, most_breaks, seconds_of, too_long
from toolkit.verdict.sliders.by_contacts import that_slide, that_slip, too_low_by
from toolkit.verdict.sliders.late import SLIDERS, may_slip_again
from toolkit.verdict.sliders.machine import POINTS, Machine, RigidSlider
from toolkit.verdict.sliders.records import Behaviour, not_followed
from toolkit.verdict.sliders.slips_in_time import slips_in_time
from toolkit.verdict.sliders.steady import is_stable_with_delay
from toolkit.verdict.sliders.ways import first_way, way_without_contacts

# contacts of each slider where the ensemble takes the place of the master equation
CONTACTS, SEED = 20_000, 1
# most contacts of a slider that is followed
MOST_CONTACTS = 2_000_000
# contacts whose sliders tell how long all of them would take
PILOT = 1_000
# part of the time in which so many contacts have to be followed, and how many times fewer are followed in the rest
PART_OF_FIRST, FEWER = 0.6, 16
# Where slips are still those of a transient: how often at most the sliders are pulled further, and how many times as
# far each time; the second numbers hold where steady sliding is stable, as slips may end after hundreds of delays then.
ROUNDS, AS_FAR = (5, 3), (2, 4)
# times as long as its share of the way so far that the next way may take
LONGER = 1.25
NOT_SLID = "their path ended before they slid or slipped"
ONCE = f"their path ended before they slid after a slip or all slipped again: {MORE_TIME}"


def sliders(
    machine: Machine,
    contacts: Contacts,
    rule: str,
    path: Array,
    number: int,
    seconds: float,
    few_will_do: bool = False,
    known: int = 0,
) -> Any:
    """The ensemble's result for sliders of so many contacts each, or of PILOT times the power of 2 that so many
    say can be followed within so many seconds, without those in which the kernels and the tables of draws are made.
    Where these take longer all the same, FEWER times fewer are followed, and so on down to PILOT.
    Raises InputError where the pilot says that no more than its own can be followed in time, unless `few_will_do`, or
    no more than those `known` already, and for a slider that the ensemble does not take."""
    import eq_model

    asked: dict[str, Any] = {"n_replicas": SLIDERS, "seed": SEED, "threads": cores_of(None)}
    asked |= machine.keywords(rule)
    pilot, left = None, max(seconds, SHORT)
    if number > PILOT:
        # points beyond the usual ones take as long however many contacts there are
        few_points = np.unique(np.append(path[:: -(-path.size // POINTS)], path[-1]))
        # makes the kernels and tables, too, whose time does not count
        following = eq_model.Ensemble(contacts, few_points, n_contacts=PILOT, **asked)
        spent = time.process_time()
        pilot = followed_within(following, left)
        if pilot is None:
            raise InputError(f"{told_contacts(PILOT)} take more than {left:.0f} s: {MORE_TIME}")
        remaining = max(seconds - pilot.run_time, 0.0)
        left, most = max(remaining, SHORT), most_breaks(contacts, rule)
        took = min(pilot.run_time, time.process_time() - spent)  # on a busy machine the latter
        took = seconds_of(pilot.breaks, contacts, rule, took)
        part = PART_OF_FIRST if number >= FEWER * PILOT else 1.0  # that they are given below
        times = min(part * remaining / max(took, 1e-9), most / max(pilot.breaks, 1))
        # by powers of 2, as the time differs from run to run, and answers should not
        fewer = PILOT * 2 ** int(np.log2(times)) if times > 1.0 else 0
        if number > times * PILOT and fewer <= known:
            if few_will_do:
                return pilot
            needed, breaks = took * number / PILOT, pilot.breaks * number / PILOT
            why = too_long(needed, remaining)
            if needed <= remaining:
                why = f"break some {breaks:.1g} times, more than are followed here"
            raise InputError(f"{told_contacts(number)} {why}")
        if number > times * PILOT:
            number = fewer
    began, found, tried = time.monotonic(), None, number
    while found is None and tried >= min(number, PILOT):
        # the last of the time is for fewer, where all of them take longer than is expected, as on a slow machine
        limit = left - (time.monotonic() - began)
        part = PART_OF_FIRST if tried >= FEWER * PILOT else 1.0
        found = followed_within(
            eq_model.Ensemble(contacts, path, n_contacts=tried, **asked), part * limit
        )
        tried //= FEWER
    if found is None and not (few_will_do and pilot):
        raise InputError(f"{told_contacts(number)} take more than {left:.0f} s: {MORE_TIME}")
    return found or pilot


def followed_within(following: Any, seconds: float) -> Any:
    """The result of an ensemble of all its sliders; None where these take more than so many s of the clock, and of the
    processor, which a busy machine has for others, too: they are given up."""
    clock, work = time.monotonic(), time.process_time()
    following.interrupted = lambda: (
        min(time.monotonic() - clock, time.process_time() - work) > seconds
    )
    *_, (done, total) = following  # the last one tells whether any were given up
    return following.result() if done == total else None


def until_settled(
    found: Any, machine: Machine, contacts: Contacts, rule: str, until: float, settling: float
) -> Any:
    """These sliders, pulled as far again and again until their slips are those of a limit cycle or are over, see
    `may_slip_again`, as far as there is time for, in s of the monotonic clock. Slips without a mass leave contacts new,
    or nearly so. Where steady sliding is stable slips of a settled look may end all the same, after hundreds of delays.
    """
    import eq_model

    asked: dict[str, Any] = {"n_replicas": SLIDERS, "seed": SEED, "threads": cores_of(None)}
    asked |= {"n_contacts": found.contacts // SLIDERS} | machine.keywords(rule)
    stable = is_stable_with_delay(machine, contacts)
    times, rounds = (AS_FAR[1], ROUNDS[1]) if stable else (AS_FAR[0], ROUNDS[0])
    for _ in range(rounds if rule == "mass" else 0):
        of_main = with_main_slips(found)
        lasts = may_slip_again(of_main, machine, contacts, settling)
        late = LONGER * times * found.run_time > until - time.monotonic()
        if not lasts or late or (late_slips(of_main.slips, SLIDERS).settled and not stable):
            break
        end = float(found.path[0]) + times * float(np.ptp(found.path))
        more = machine.points(end - found.path[0]) * (times - 1) // times
        further = np.linspace(found.path[-1], end, more + 1)
        path = np.append(found.path, further[1:])
        longer = followed_within(
            eq_model.Ensemble(contacts, path, **asked), until - time.monotonic()
        )
        if longer is None:
            break
        found = longer
    return found


def follow_by_contacts(
    machine: Machine,
    contacts: Contacts,
    rule: str,
    loading: float,
    until: float,
    rigid: RigidSlider,
    most: int = MOST_CONTACTS,
) -> Behaviour:
    """Sliders by the ensemble of as many contacts as there are, or fewer, `most` or where there is no time for all;
    `loading`: way of the drive up to the static force, `until`: s of the monotonic clock.

    Fewer slip earlier, by some N^(-2/3): the forces before a slip of two numbers tell by how much.
    """
    length = first_way(machine, contacts, loading)
    points = np.linspace(0.0, length, machine.points(length))
    path = contacts.start.mean() / machine.spring + points
    asked = min(round(rigid.contacts), most) if rigid.contacts else CONTACTS
    try:
        found = sliders(
            machine, contacts, rule, path, asked, max(until - time.monotonic(), SHORT), True
        )
    except InputError as refused:
        return not_followed(rule, str(refused))
    drive, force = trace_of(found, 0, machine.velocity)
    waits = way_without_contacts(machine, contacts)
    found = until_settled(found, machine, contacts, rule, until, waits)
    if machine.points(np.ptp(found.path)) >= path.size:  # else few points would draw slower swings
        drive, force = trace_of(found, 0, machine.velocity)
    of_main, number = with_main_slips(found), found.contacts // SLIDERS
    common = int(np.bincount(of_main.slips.replica, minlength=SLIDERS).min())
    goes_on = may_slip_again(of_main, machine, contacts, waits)
    if goes_on and common < 2:
        return not_followed(rule, ONCE)
    if not common and not has_slid(found, contacts.mean_threshold):
        return not_followed(rule, NOT_SLID)
    told = Behaviour(
        rule=rule,
        kind="smooth",
        before=np.nan,
        after=np.nan,
        period=None,
        slips=common,
        error=np.nan,
        success=True,
        message=by_sliders(number),
        run_time=found.run_time,
        contacts=number,
        drive=drive,
        force=force,
        in_time=slips_in_time(of_main.slips),
    )
    if common < 2 or not goes_on:
        return that_slide(told, of_main, machine, contacts, rigid)
    too_low = 0.0
    if number < (round(rigid.contacts) if rigid.contacts else np.inf):
        few = _fewer(machine, contacts, rule, path, until) if number > PILOT else None
        too_low = too_low_by(of_main, few or of_main, contacts.mean_threshold)
    smaller = found.slips.drive.size - of_main.slips.drive.size
    return that_slip(told, of_main, machine, contacts, smaller, too_low)


def by_sliders(number: int, heat: float | None = None) -> str:
    """Who tells of a behaviour: sliders of so many contacts each, without `heat` that may change the force by so many
    mean thresholds, which a line of its own tells."""
    cold = " without heat" * (heat is not None)
    return f"by the ensemble, {SLIDERS} sliders of {told_contacts(number)}{cold}"


def without_heat(found: Behaviour, change: float) -> Behaviour:
    """What the ensemble found without heat that changes the force by at most so many mean thresholds."""
    number = found.contacts or 0
    message = found.message.replace(by_sliders(number), by_sliders(number, change))
    return replace(found, error=found.error + change, message=message, heat_left_out=change)


def _fewer(
    machine: Machine, contacts: Contacts, rule: str, path: Array, until: float
) -> Any | None:
    """Sliders of PILOT contacts with their main slips; None where they are not followed in time."""
    try:
        few = sliders(machine, contacts, rule, path, PILOT, max(until - time.monotonic(), SHORT))
    except InputError:
        return None
    return with_main_slips(few)
