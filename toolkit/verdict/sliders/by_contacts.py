"""What sliders of the ensemble tell in place of the master equation: of slips, and of sliding; and by how much fewer
contacts than there are slip too early, and too often."""

from dataclasses import replace
from typing import Any

import numpy as np

from origins.contacts import Contacts
from toolkit.results.sliding import mean_forces, scatter_of
from toolkit.results.slips import left_of_slips, shrinks_by
from toolkit.scene.scale import told_contacts
from toolkit.verdict.sliders.late import SLIDERS, in_the_end, shrinking, with_late_slips
from toolkit.verdict.sliders.machine import Machine, RigidSlider
from toolkit.verdict.sliders.records import Behaviour, Finite, not_followed
from toolkit.verdict.sliders.ways import SMALL, way_of_a_swing, way_without_contacts

# A fall is smaller by up to this many times what is missing before it: a mass swings as far beyond no force, at most.
OF_FALL = 2.0
# of the force: swings that are larger are told by their ends, and are no error of it
SWUNG = 0.05
# of a slider that is called smooth: at the end of its path, in the last one of so many parts, its force swings by no
# more than so many mean thresholds (that of a thousand contacts scatters by some 0.1 of them)
LATE, RINGS = 10, 2.0 * SMALL
# times the error of fewer contacts than there are, below which their slips may be chance, and more of them slide
SURE = 2.0


def that_slip(
    told: Behaviour,
    found: Any,
    machine: Machine,
    contacts: Contacts,
    smaller: int,
    too_low: float,
) -> Behaviour:
    """What sliders tell that slip on: `found` has main slips alone, beside so many `smaller` ones, before which the
    force may be `too_low` by so much (a length), 0 of as many contacts as there are."""
    number, slips = found.contacts // SLIDERS, found.slips
    many = Finite(
        told.rule, number, "stick-slip", drive=told.drive, force=told.force, smaller=smaller
    )
    many = with_late_slips(many, slips)
    before, after, error = many.before, many.after, many.force_error + too_low
    if too_low and before - after < SURE * error:
        return not_followed(told.rule, f"{told_contacts(number)} slip, perhaps as they are so few")
    many = in_the_end(many, found, machine, contacts)
    lasts = many.kind == "stick-slip"
    if many.kind == "unknown":
        last = [slips.mean(f"force_{when}", told.slips - 1) for when in ("before", "after")]
        before, error, after = last[0][0], last[0][1] + too_low, last[1][0]
    off = many.period_error + period_off(too_low, machine.spring) if many.period else 0.0
    return replace(
        told,
        kind="undecided" if many.kind == "unknown" else many.kind,
        before=before,
        after=after,
        period=many.period,
        period_error=off,
        error=float(error / contacts.mean_threshold),
        message=told.message + (shrinking(many) if lasts else ""),
        shrinks_by=0.0 if lasts else shrinks_by(slips, SLIDERS),
        finite=many,
    )


def that_slide(
    told: Behaviour, found: Any, machine: Machine, contacts: Contacts, rigid: RigidSlider
) -> Behaviour:
    """What sliders tell that slide at the end of their path, with the main slips in `found` behind them."""
    unit, slips = contacts.mean_threshold, found.slips
    # at least the drive's way in which contacts that broke together come back: they do so ever less together
    swing_way, waits = way_of_a_swing(machine, contacts), way_without_contacts(machine, contacts)
    length = found.path[-1] - found.path[0]
    late = found.path >= found.path[-1] - max(length / LATE, waits, swing_way)
    forces = found.forces[:, late]
    if (swing := float(np.ptp(forces, axis=1).max()) / unit) > RINGS:
        why = f"its sliders still ring at the path's end, by {swing:.2g} <x_s>"
        return not_followed(told.rule, why)
    each, shrinks = mean_forces(found, late), shrinks_by(slips, SLIDERS)
    force = float(each.mean())
    scatter = float(each.std(ddof=1)) / SLIDERS**0.5
    error = scatter + 0.5 * float(np.ptp(forces.mean(axis=0)))
    # which contacts that come back together hold for less than from one point to the next
    error += left_of_slips(found, slips, shrinks)
    steady = rigid.kinetic + machine.damping * machine.velocity
    # with a mass it swings about that
    known = max(error, 0.5 * float(np.ptp(forces)) if swing_way else 0.0)
    if told.rule == "mass" and abs(force - steady) <= known:
        force = steady
    swings = None
    if error - scatter > max(scatter, SWUNG * abs(force)):
        swings = float(forces.min()), float(forces.max())
    number, seen = found.contacts // SLIDERS, slips.drive.size / SLIDERS
    fluctuation = scatter_of(forces)
    return replace(
        told,
        before=force,
        after=force,
        error=float(error / unit),
        shrinks_by=shrinks,
        finite=Finite(told.rule, number, "smooth", slips=seen, fluctuation=fluctuation),
        swings=swings,
    )


def too_low_by(found: Any, few: Any, unit: float) -> float:
    """By how much F before the first slip may be too low as there are not more contacts (a length): by N^(-2/3) mean
    thresholds `unit`, or by what a few contacts say of its factor, with their standard errors; of these few themselves
    by ten times that, more than was found of any law."""
    number = found.contacts // SLIDERS
    least = float(number ** (-2.0 / 3.0)) * unit
    if few is found:
        return 10.0 * least
    (force, off), (lower, more_off) = (each.slips.mean("force_before", 0) for each in (found, few))
    ratio = (number * SLIDERS / few.contacts) ** (2.0 / 3.0) - 1.0
    return max(least, float((abs(force - lower) + off + more_off) / ratio))


def period_off(too_low: float, spring: float) -> float:
    """By how much the drive's way from slip to slip may be too short (a length), as so much force is missing before
    each: what it falls by the spring regains."""
    return OF_FALL * too_low / spring
