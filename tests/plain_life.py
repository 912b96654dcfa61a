"""The plain twin of the lanes: one life of a contact by what origins says of its laws, slow and simple to read."""

from itertools import pairwise

import numpy as np

from origins import Contacts, Drive
from origins.laws.thermal import BreakingRate

_HALVINGS = 60


def life(
    contacts: Contacts, drive: Drive, born: float, stretch: float, threshold: float, bears: float
) -> tuple[float, float]:
    """Time and stretch (a length) at which a contact breaks that is born at the time `born` and at a stretch, and bears
    the integral of its rate up to `bears`; infinite where it holds to the end of the drive."""
    path = np.append(0.0, drive.path)
    lasts = (
        np.abs(np.diff(path)) / drive.velocity
        if drive.time is None
        else np.diff(drive.time, prepend=0.0)
    )
    times = np.append(0.0, np.cumsum(lasts))
    place = float(np.interp(born, times, path)) - stretch
    stiffness = float(contacts.relative_stiffness(threshold))
    for begin, end in pairwise(times.tolist()):
        if end <= born:
            continue
        first = max(begin, born)
        x, y = (float(np.interp(at, times, path)) - place for at in (first, end))
        # the threshold, met on the way out
        share = 1.0
        if abs(y) >= threshold:
            share = (np.copysign(threshold, y) - x) / (y - x)
        spent = _spent(
            contacts.thermal, x, x + share * (y - x), share * (end - first), threshold, stiffness
        )
        if spent >= bears > 0.0:
            low, high = 0.0, share
            for _ in range(_HALVINGS):
                middle = 0.5 * (low + high)
                so_far = x + middle * (y - x)
                part = _spent(
                    contacts.thermal, x, so_far, middle * (end - first), threshold, stiffness
                )
                low, high = (middle, high) if part < bears else (low, middle)
            return first + low * (end - first), x + low * (y - x)
        if share < 1.0 or abs(y) >= threshold:
            return first + share * (end - first), float(np.copysign(threshold, y))
        bears -= spent
    return np.inf, np.inf


def _spent(
    thermal: BreakingRate | None,
    x: float,
    y: float,
    lasts: float,
    threshold: float,
    stiffness: float,
) -> float:
    """Integral of the rate over the time that the way from x to y takes."""
    if thermal is None or lasts == 0.0:
        return 0.0
    x, y = (float(np.clip(z, -threshold, threshold)) for z in (x, y))
    if x == y:
        return float(thermal.rate(x, threshold, stiffness)) * lasts
    return float(thermal.cumulative(y, threshold, x, stiffness)) * lasts / abs(y - x)
