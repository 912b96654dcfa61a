"""How often contacts break at a temperature: some so often that they cannot be followed one break after the other."""

import numpy as np

from origins import Contacts, Drive
from origins.errors import InputError

_MOST = 1e11  # breaks of one contact: minutes
_COUNT = 256


def check_often(contacts: Contacts, drive: Drive) -> None:
    """InputError where a contact is to break more than 1e11 times on the drive."""
    thermal = contacts.thermal
    if thermal is None or contacts.grains is not None:
        return
    lasts = float(np.abs(np.diff(drive.path, prepend=0.0)).sum()) / drive.velocity
    if drive.time is not None:
        lasts = float(drive.time[-1])
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
