"""How much there is to follow: what breaks too often, or ages for too long, is not followed event by event."""

import numpy as np

from origins import Contacts, Drive
from origins.errors import InputError

_MOST = 3e7  # breaks or steps of one contact, which is followed in one go: some ten seconds
_COUNT = 256


def duration(drive: Drive) -> float:
    """Of the whole drive, a time."""
    if drive.time is not None:
        return float(drive.time[-1])
    return float(np.abs(np.diff(drive.path, prepend=0.0)).sum()) / drive.velocity


def events(contacts: Contacts, drive: Drive, steps: float) -> float:
    """How often a contact breaks at a temperature, or pins anew, on the drive, about.

    Raises InputError where that, or the `steps` of a threshold that diffuses, is more than 3e7.
    """
    often, lasts, grains = _breaks(contacts, duration(drive)), duration(drive), contacts.grains
    if grains is not None:
        first, path = grains.growth.first_pinning_time, np.append(0.0, drive.path)
        moved = np.abs(np.diff(path))
        each = moved / drive.velocity if drive.time is None else np.diff(drive.time, prepend=0.0)
        # a threshold is at most about alpha (time)^(1/3) / B^(1/2)
        speed = np.divide(moved, each, out=np.zeros(each.size), where=each > 0.0)
        with np.errstate(over="ignore", divide="ignore"):
            holds = (grains.growth.alpha / (np.sqrt(grains.growth.B) * speed)) ** 1.5
        often = max(often, float((each / (first + holds)).sum()))
    for name, number in (("breaks", often), ("ages in steps,", steps)):
        if number > _MOST:
            what = "thermal" if contacts.thermal else "ageing" if contacts.ageing else "grains"
            raise InputError(
                f"{what}: each contact {name} about {number:.0e} times on the drive, which takes {lasts:.1g}; "
                "take a shorter or faster drive, other units of time, or the master equation"
            )
    return often


def _breaks(contacts: Contacts, lasts: float) -> float:
    """How often a contact breaks at a temperature."""
    thermal = contacts.thermal
    if thermal is None or lasts == 0.0:
        return 0.0
    if contacts.grains is not None:
        return float(thermal.attempt_frequency * lasts)
    thresholds = contacts.thresholds.ppf((np.arange(_COUNT) + 0.5) / _COUNT)
    # relaxed contacts bear most: the others do not hold as long
    with np.errstate(over="ignore"):
        holds = np.exp(-thermal.log_rate(0.0, thresholds, contacts.relative_stiffness(thresholds)))
    return lasts / (float(np.minimum(holds, lasts).mean()) + contacts.waiting_time)
