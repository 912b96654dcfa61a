"""What late slips of the ensemble's sliders tell of those to come: their means, and whether they last or get rarer."""

from dataclasses import replace
from typing import Any

import numpy as np

from origins.contacts import Contacts
from toolkit.results.mean_of_pairs import ONE_SIGMA
from toolkit.results.rarer import rarer
from toolkit.results.sliding import may_go_on
from toolkit.results.slips import late_slips, shrinks_by, spread_of, still_changing
from toolkit.verdict.sliders.budget import MORE_TIME
from toolkit.verdict.sliders.machine import Machine
from toolkit.verdict.sliders.records import Behaviour, Finite
from toolkit.verdict.sliders.steady import is_stable_with_delay

# sliders, which differ by chance
SLIDERS = 4
# the word for slips that get ever rarer where steady sliding is stable
EVER_RARER = "ever rarer"
# part of a slider's contacts that a slip breaks which leaves nearly all of them new
RENEWED = 0.99
# of what the drive loads on the spring of a slider that sticks, the least that slips take back of one that sticks and
# slips: one that slides for most of the way, by breaks of few contacts each, has falls that only chance makes large
STICKS = 0.5
# part of themselves that slips which fade leave after so many more, below which they are not told as stick-slip
FADED, FURTHER = 0.5, 32
STILL_FADE = "their slips still fade where the path ends"
OPEN = (
    "steady sliding is stable, and their slips are neither alike nor clearly rarer where the path ends; whether they "
    f"end is not known: {MORE_TIME}"
)


def with_late_slips(finite: Finite, slips: Any) -> Finite:
    """With the forces of late slips, and how these differ from one to the next."""
    late = late_slips(slips, SLIDERS)
    (before, error), (after, after_error) = (
        late.mean(f"force_{when}") for when in ("before", "after")
    )
    each = late.slips.force_before, late.slips.drop, late.gaps
    befores, drops, periods = (spread_of(one) if one.size > 1 else None for one in each)
    period, period_error = late.period()
    return replace(
        finite,
        before=before,
        before_error=error,
        after=after,
        after_error=after_error,
        slips=slips.drive.size / SLIDERS,
        period=period if late.gaps.size else None,
        period_error=period_error if late.gaps.size else np.nan,
        befores=befores,
        drops=drops,
        periods=periods,
        shrinks_by=shrinks_by(slips, SLIDERS),
        still_changing=still_changing(slips, SLIDERS),
    )


def if_it_recurs(finite: Finite, slips: Any, end: float, spring: float) -> Finite:
    """As it is where these `slips` recur beside infinitely many contacts that slide, else "now and then": all
    sliders have slipped again, after a period that is known, and of what the drive loads up to its `end` (a length) on
    a spring of K/(N_c <k>) whose slider sticks, K/(1 + K) of its way, slips take back STICKS; `spring` is 0 where that
    is not asked."""
    first = slips.number == 0
    loaded = spring / (1.0 + spring) * float((end - slips.drive[first]).sum())
    known = finite.period is not None and finite.period_error < finite.period
    recurs = known and float(slips.drop[~first].sum()) >= STICKS * loaded
    return finite if recurs else replace(finite, kind="now and then")


def renew_all(slips: Any, number: int) -> bool:
    """Whether each of these slips breaks nearly all of so many contacts of a slider, of sliders that have slipped twice
    or more: the next one hardly hangs on what was before."""
    counts = np.bincount(slips.replica, minlength=SLIDERS)
    return bool(counts.min() > 1 and slips.breaks.min() >= RENEWED * number)


def may_slip_again(found: Any, machine: Machine, contacts: Contacts, settling: float) -> bool:
    """Whether sliders that slip may do so beyond their path, see `may_go_on`. Where steady sliding is stable contacts
    that broke together may gather once more, after many delays: a third of the way without a slip says that it is over.
    """
    if may_go_on(found, machine.spring, settling, 0):
        return True
    last_third = float(found.path[-1] - np.ptp(found.path) / 3.0)
    return is_stable_with_delay(machine, contacts) and bool((found.slips.drive > last_third).any())


def in_the_end(finite: Finite, found: Any, machine: Machine, contacts: Contacts) -> Finite:
    """Sliders that slip, `finite` of the ensemble's `found`, with what is known of slips beyond their path.

    Slips that shrink are "unknown", as means of them tell nothing of those to come, nor is it known whether they end.
    Where steady sliding is stable slips are "ever rarer" if they have got so, and those of a limit cycle if late ones
    are alike; else "unknown". Where it is not, sliders go on to slip: how much rarer they got is told beside.
    """
    slips, late = found.slips, late_slips(found.slips, SLIDERS)
    stable = is_stable_with_delay(machine, contacts)
    fewer = rarer(slips, SLIDERS, float(found.path[-1]))
    if fewer and stable:
        last = found.path >= found.path[-1] - fewer.way / 3.0
        # half of the range that most of the forces keep to, as slips are no fluctuation
        usual = 0.5 * float(
            np.ptp(np.quantile(found.forces[:, last], (1.0 - ONE_SIGMA, ONE_SIGMA)))
        )
        return replace(finite, kind=EVER_RARER, rarer=fewer, fluctuation=usual)
    finite = replace(finite, rarer=fewer)
    if (1.0 - finite.shrinks_by) ** FURTHER < FADED:
        return replace(finite, kind="unknown", message=STILL_FADE)
    if stable and not (late.settled and late.alike):
        return replace(finite, kind="unknown", message=OPEN)
    return finite


def shrinking(slider: Finite | Behaviour) -> str:
    """That its slips shrink, of which the means of late ones tell nothing; "" where they do not."""
    part = slider.shrinks_by
    told = f"{100.0 * part:.{2 if part >= 1e-4 else 1}g}%"  # some ten drops tell no more
    return f", each drop {told} smaller than the one before" if part else ""
