"""How much there is to follow: some contacts break too often, or age for too long, to be followed step by step."""

import numpy as np

from origins import Contacts, Drive, GrainContact
from origins.errors import InputError

# of one contact, which is followed in one go: some ten seconds, in which no interrupt is heard
_MOST = 3e7  # breaks
_STEPS = 3e7
_REACH, _TRAVEL = 5e5, 4e9  # in mean thresholds: of sums of whole numbers
_COUNT = 256


def duration(drive: Drive) -> float:
    """Of the whole drive, a time."""
    if drive.time is not None:
        return float(drive.time[-1])
    return float(np.abs(np.diff(drive.path, prepend=0.0)).sum()) / drive.velocity


def check_steps(contacts: Contacts, drive: Drive, longest: float) -> float:
    """Steps that a threshold takes at most that diffuses, `longest` (a time) those near the stretch that it must not
    meet. InputError where on the whole drive it takes more than 3e7 elsewhere, too."""
    ageing = contacts.ageing
    if ageing is None:
        return 0.0
    most = duration(drive) / longest
    if ageing.normal is not None:
        # half way to the stretch a step may be as long as eight standard deviations of it
        longest = max(longest, (0.5 * ageing.final.mean() / 8.0) ** 2 / (2.0 * ageing.rate))
    steps = duration(drive) / longest
    if steps > _STEPS:
        forget = ageing.final.std() ** 2 / ageing.rate
        raise InputError(
            f"ageing: thresholds forget what they were in {forget:.1g}, and the drive takes {duration(drive):.1g}: "
            f"about {steps:.0e} steps of each contact; take a shorter or faster drive"
        )
    return most


def check_growth(contacts: Contacts, drive: Drive, reach: float) -> None:
    """InputError where the way, or the stretch that contacts may `reach`, is far beyond the thresholds that grains have
    at X = 0."""
    grains, mean = contacts.grains, contacts.mean_threshold
    travel = float(np.abs(np.diff(drive.path, prepend=0.0)).sum())
    if grains is not None and (reach > _REACH * mean or travel > _TRAVEL * mean):
        raise InputError(
            f"B = {grains.growth.B:g}: at the age of {grains.age:g} grains hold up to stretches of {mean:.1g}, and on "
            f"a way of {travel:.1g} they come to bear {reach:.1g}; the ensemble follows them up to {_REACH:.0e} of the "
            f"first, along {_TRAVEL:.0e}: is B in the path's unit of length, and time in alpha's?"
        )


def check_often(contacts: Contacts, drive: Drive) -> float:
    """How often a contact breaks at a temperature, or one that grows breaks or comes near to it; InputError where a
    contact is to break more than 3e7 times on the drive."""
    thermal, lasts = contacts.thermal, duration(drive)
    if contacts.grains is not None:
        pins = _pins(contacts.grains, drive)
        return pins if thermal is None else max(pins, thermal.attempt_frequency * lasts)
    if thermal is None:
        return 0.0
    thresholds = contacts.thresholds.ppf((np.arange(_COUNT) + 0.5) / _COUNT)
    # relaxed contacts bear most: the others do not hold as long
    with np.errstate(over="ignore"):
        holds = np.exp(-thermal.log_rate(0.0, thresholds, contacts.relative_stiffness(thresholds)))
    often = (
        lasts / (float(np.minimum(holds, lasts).mean()) + contacts.waiting_time)
        if lasts > 0.0
        else 0.0
    )
    if often > _MOST:
        raise InputError(
            f"thermal: at this temperature and attempt frequency each contact breaks about {often:.0e} times on the "
            "way, one after the other; take a shorter or faster drive, or the master equation"
        )
    return often


def _pins(grains: GrainContact, drive: Drive) -> float:
    """How often a grain pins anew while the slider moves; InputError where more than 3e7 times."""
    path, growth = np.append(0.0, drive.path), grains.growth
    moved = np.abs(np.diff(path))
    lasts = moved / drive.velocity if drive.time is None else np.diff(drive.time, prepend=0.0)
    first, moves = growth.first_pinning_time, (moved > 0.0) & (lasts > 0.0)
    # a threshold is at most about alpha (time)^(1/3) / B^(1/2)
    speed = moved[moves] / lasts[moves]
    with np.errstate(over="ignore"):
        holds = (growth.alpha / (np.sqrt(growth.B) * speed)) ** 1.5
    pins = float((lasts[moves] / (first + holds)).sum())
    if pins > _MOST:
        raise InputError(
            f"alpha = {growth.alpha:g}: grains pin {first:.1g} after they broke, so on the way, which takes "
            f"{duration(drive):.1g}, each pins and breaks about {pins:.0e} times; take a shorter or slower drive, or "
            "another unit of time"
        )
    return pins
