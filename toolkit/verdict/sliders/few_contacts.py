"""By how much fewer contacts than there are slip too early, and too often."""

from typing import Any

from toolkit.verdict.sliders.late import SLIDERS

# Times the force that is missing before a slip in what it falls by: a mass swings as far beyond no force, at most.
OF_FALL = 2.0


def too_early_by(found: Any, few: Any, unit: float) -> float:
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


def period_off(too_early: float, spring: float) -> float:
    """By how much the drive's way from slip to slip may be too short (a length), as so much force is missing before
    each: what it falls by the spring regains."""
    return OF_FALL * too_early / spring
