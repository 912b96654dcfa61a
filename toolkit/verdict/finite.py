"""What finitely many contacts do: sliders of as many contacts as the area holds, beside the infinitely many of the
master equation."""

from dataclasses import dataclass, field, replace

import numpy as np

from origins.contacts import Contacts
from origins.errors import InputError
from origins.thresholds.law import Array
from toolkit.results.slips import large_slips, main_slips
from toolkit.verdict.ensemble import (
    FEW,
    NOT_SLID,
    ROUNDING,
    SLIDERS,
    has_slid,
    sliders,
    told_by,
    trace_of,
)
from toolkit.verdict.machine import Behaviour, Machine

# rules under which contacts re-form while a slip goes on, so that each breaks at every threshold passed
FLOWING = ("instant", "mass")
# most contacts of each slider; most breaks of all, some 10 s at 25 ns each
MOST_CONTACTS, MOST_BREAKS = 2_000_000, 4e8
# length of the drive's path: in loadings where sliders stick and slip, else in mean thresholds beyond the first loading
LOADINGS, BEYOND = 3.2, 40.0
POINTS = 100
# of BEYOND, for the scatter of the places at which sliders with mass begin to slide
SCATTERED = 0.3
# of a fall of the force, in mean thresholds: smaller ones are no stick-slip, as of a slider with mass
SMALL = 0.02
# part of BEYOND after which the force is taken as that of steady sliding
SETTLED = 0.5
# part of what a drive adds to the spring's pull on a slider that sticks: a force that rises by more still rises
STILL = 0.5
# standard errors, by the scatter of the sliders, above which a rise is no chance
JERKS = 4.0
# mean thresholds, times N^(-2/3), by which the drive pulls contacts that re-form at once beyond the force of infinitely
# many: theirs is above it by 3 (thresholds 1 ± 0.2) to 9 (exponential ones) on K = 1e-3, and by more on softer springs
ABOVE = 10.0


@dataclass(frozen=True)
class Finite:
    """What sliders of `contacts` contacts each do under a slip rule.

    contacts : of each slider; fewer than there are where these take too long, see `message`
    kind : "stick-slip" where each slider slips, more often than infinitely many do before these slide, "smooth"
        where none does, on a way of some 40 mean thresholds, "now and then" between; "unknown" where they were not
        followed, or slip where nobody knows how often infinitely many do, for the reason in `message`
    before, after : mean spring force before and after a slip, F/(N_c <k>) (lengths), with standard errors: of the last
        slip that all sliders have had, or of the first where some have had none
    slips : number of slips of a slider, mean
    period : of the drive, between the last two slips that all sliders have had, mean (a length); None for fewer
    drive, force : the trace of the first slider, F/(N_c <k>) (lengths), with each slip at its own place
    late, late_error : mean force over the last part of the way (of BEYOND), and its standard error, of contacts that
        re-form at once, F/(N_c <k>) (lengths); nan of others
    rises : whether the force still rises there, as the sliders do not yet go with the drive
    """

    rule: str
    contacts: int
    kind: str
    before: float = float("nan")
    before_error: float = float("nan")
    after: float = float("nan")
    after_error: float = float("nan")
    slips: float = 0.0
    message: str = ""
    drive: Array = field(default_factory=lambda: np.empty(0))
    force: Array = field(default_factory=lambda: np.empty(0))
    period: float | None = None
    late: float = float("nan")
    late_error: float = float("nan")
    rises: bool = False


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
    rule, slips = infinite.rule, infinite.kind == "stick-slip"
    settles = rule == "instant" and not slips and not contacts.waiting_time
    held = max(round(number), 1)
    mean = contacts.mean_threshold
    loading = static / machine.spring + mean
    pulled_on = ABOVE * held ** (-2.0 / 3.0) / machine.spring if settles else 0.0
    loading += pulled_on * mean
    # in a slip that renews contacts all break once; contacts that re-form at once break at each threshold passed
    end = LOADINGS * loading if slips else loading + BEYOND * mean
    # with a delay far above the time of a slip (see `follow_by_contacts`) contacts are out until the slip is over
    flowing = rule in FLOWING and not (rule == "mass" and contacts.waiting_time)
    lives = 2.0 + BEYOND if not slips else end / mean if flowing else LOADINGS
    lives += pulled_on  # as long as that they slide, at most
    if (
        flowing and not slips
    ):  # the spring relaxes to the force of sliding, to none where that is not known
        relaxed = infinite.after if np.isfinite(infinite.after) else 0.0
        lives += max(static - relaxed, 0.0) / machine.spring / mean
    most = int(min(MOST_CONTACTS, MOST_BREAKS / (SLIDERS * lives)))
    if most < min(held, FEW):
        breaks = SLIDERS * held * lives
        why = f"some {breaks:.1g} breaks are more than are followed here"
        return Finite(rule, held, "unknown", message=why)
    # the static force of so many scatters by some N^(-1/2) of itself
    further = static / np.sqrt(held) / machine.spring / mean
    if rule == "mass" and not slips and further > SCATTERED * BEYOND:
        scatter = f"F_s of such sliders scatters by some {held**-0.5:.1%}"
        why = f"{scatter}, on so soft a spring {further:,.0f} <x_s> of the drive's way: too long to be followed"
        return Finite(rule, held, "unknown", message=why)
    if infinite.heat_left_out is not None:  # nor do as many contacts need it
        contacts = contacts.replace(thermal=None)
    if contacts.held_in_time:
        why = "single contacts are followed on a spring without heat and age only"
        return Finite(rule, held, "unknown", message=why)
    path = contacts.start.mean() / machine.spring + np.linspace(0.0, end, POINTS)
    try:
        found = sliders(machine, contacts, rule, path, min(held, most), seconds)
    except InputError as refused:
        return Finite(rule, held, "unknown", message=str(refused))
    drive, force = trace_of(found, 0)
    if settles:
        found = replace(found, slips=large_slips(found.slips, SMALL * mean))
    if slips:
        found = replace(found, slips=main_slips(found.slips))
    counts = np.bincount(found.slips.replica, minlength=SLIDERS)
    if not counts.any() and not has_slid(found, mean):
        return Finite(rule, held, "unknown", message=NOT_SLID)
    # contacts that re-form at once forget their start in many slips, as F falls from static to kinetic
    if flowing and infinite.kind == "undecided" and counts.any():
        few = found.contacts // SLIDERS
        why = f"{few:,} slip, perhaps only until they slide: what infinitely many do is not known"
        return Finite(rule, held, "unknown", message=why)
    # where infinitely many slide, they may have slipped before, as F fell from static to kinetic
    more = counts - (0 if slips else infinite.slips)
    kind = "stick-slip" if more.min() >= 1 else "now and then" if (more > 0).any() else "smooth"
    last = int(max(counts.min() - 1, 0))
    (before, error), (after, after_error) = (
        found.slips.mean(f"force_{when}", last) if counts.any() else (np.nan, np.nan)
        for when in ("before", "after")
    )
    if abs(after) < ROUNDING * before:
        after = 0.0
    followed, message = found.contacts // SLIDERS, ""
    if followed < held:
        message = f"as infinitely many do, and so the {held:,} of the area, which lie between"
        if kind != infinite.kind:
            message = f"{held:,} take too long, and {followed:,} do something else than infinitely many: {kind}"
            return Finite(rule, held, "unknown", message=message)
    mean = float(counts.mean())
    slips, period = found.slips, None
    if last:
        begins = (slips.mean("drive", number)[0] for number in (last, last - 1))
        period = float(np.subtract(*begins))
    late, late_error, rises = np.nan, np.nan, False
    if settles:
        settled = path >= path[-1] - SETTLED * BEYOND * contacts.mean_threshold
        each = found.forces[:, settled].mean(axis=1)
        late, late_error = float(each.mean()), float(each.std(ddof=1)) / SLIDERS**0.5
        first = int(np.argmax(settled)) - 1
        rise = found.forces[:, -1] - found.forces[:, first]
        jerks = JERKS * float(rise.std(ddof=1)) / SLIDERS**0.5  # of sliders that go on step by step
        least = max(STILL * machine.spring * float(path[-1] - path[first]), jerks)
        rises = float(rise.mean()) > least
    forces = (before, error, after, after_error)
    finite = Finite(rule, followed, kind, *forces, mean, message, drive, force, period)
    return replace(finite, late=late, late_error=late_error, rises=rises)


def with_more(behaviour: Behaviour, finite: Finite, unit: float) -> Behaviour:
    """A behaviour that fewer sliders of the ensemble told with the numbers of these, of more contacts; `unit`: the mean
    threshold, a length. Where they are all that there are, their error is that of their scatter alone."""
    fewer = behaviour.contacts
    same = finite.kind == behaviour.kind == "stick-slip" and finite.period is not None
    if fewer is None or not same or finite.contacts <= fewer:
        return behaviour
    error = max(finite.before_error, finite.after_error) / unit
    if finite.message:
        error += behaviour.error * (fewer / finite.contacts) ** (2.0 / 3.0)
    return replace(
        behaviour,
        before=finite.before,
        after=finite.after,
        period=finite.period,
        slips=int(finite.slips),
        error=error,
        message=told_by(finite.contacts),
        contacts=finite.contacts,
        drive=finite.drive,
        force=finite.force,
    )
