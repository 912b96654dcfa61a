"""How much there is to follow: some contacts break too often, or age for too long, to be followed step by step."""

import numpy as np

from origins import Contacts, Drive
from origins.errors import InputError

# of one contact, which is followed in one go: some ten seconds, in which no interrupt is heard
_MOST = 3e7  # breaks
_STEPS = 3e7
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


def check_often(contacts: Contacts, drive: Drive) -> float:
    """How often a contact breaks at a temperature, or a grain's comes near to it; InputError where a contact is to
    break more than 3e7 times on the drive."""
    thermal = contacts.thermal
    if thermal is None:
        return 0.0
    lasts = duration(drive)
    if contacts.grains is not None:
        return thermal.attempt_frequency * lasts
    thresholds = contacts.thresholds.ppf((np.arange(_COUNT) + 0.5) / _COUNT)
    # relaxed contacts bear most: the others do not hold as long
    with np.errstate(over="ignore"):
        holds = np.exp(-thermal.log_rate(0.0, thresholds, contacts.relative_stiffness(thresholds)))
    often = lasts / (float(np.minimum(holds, lasts).mean()) + contacts.waiting_time) if lasts > 0.0 else 0.0
    if often > _MOST:
        raise InputError(
            f"thermal: at this temperature and attempt frequency each contact breaks about {often:.0e} times on the "
            "way, one after the other; take a shorter or faster drive, or the master equation"
        )
    return often
