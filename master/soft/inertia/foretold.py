"""Sliders with mass that ring without end on contacts that form at once: told before the work."""

import numpy as np

from origins import Contacts
from origins.drive import Drive
from origins.errors import refuse

# Oscillations of a stuck slider beyond which it is refused. Contacts break in each, so that each is followed by itself:
# of 16 undamped sliders drawn with 4e4 to 8e7 of them left, those two that do not slip were followed to their end, and
# no other one within 5 to 13 s.
MOST_OSCILLATIONS = 1e6
# Ringing fades by so many e-folds until it counts as rest.
FADES = 10.0
# Thresholds at which the steepest fall of F is looked for.
QUANTILES = 2000


def enough_damping(drive: Drive) -> str:
    """A damping that lets no slider ring for long, in words."""
    critical = 2.0 * (float(drive.mass or 0.0) * (1.0 + float(drive.spring or 0.0))) ** 0.5
    return f"a hundredth of the critical one of a slider that sticks is {0.01 * critical:.3g}"


def _after_first_slip(contacts: Contacts, drive: Drive) -> tuple[float, float]:
    """X_T at which the first slip, if there is one, has begun at the latest, and the time left from there; no time
    where that is not known beforehand.

    From relaxed contacts F is at most <x_s^2>/<x_s>, by Lorden's inequality of renewal theory: beyond that the slider
    has moved as far as its drive.
    """
    law = contacts.thresholds
    latest = law.moment(2) / contacts.mean_threshold / float(drive.spring or 0.0)
    relaxed = contacts.start.span == (0.0, 0.0) and contacts.reforming is None
    known = relaxed and drive.forward and contacts.stiffness == "independent"
    if not (known and latest < drive.path[-1]):
        return latest, 0.0
    times = drive.arrival_times(0.0)
    return latest, float(times[-1] - np.interp(latest, drive.path, times))


def oscillations(contacts: Contacts, drive: Drive) -> float:
    """How often the slider rings on contacts that form at once, after a slip; 0 where it surely does so less often than
    MOST_OSCILLATIONS, or may not slip.

    F' is 1 - X P_c(X) before contacts break for the second time; below -K somewhere, the slider slips.
    """
    law, mass, spring = contacts.thresholds, float(drive.mass or 0.0), float(drive.spring or 0.0)
    _, time_after = _after_first_slip(contacts, drive)
    fading = FADES * 2.0 * mass / drive.damping if drive.damping else np.inf
    turns = min(time_after, fading) * np.sqrt((1.0 + spring) / mass) / (2.0 * np.pi)
    if turns < MOST_OSCILLATIONS:
        return 0.0
    x = law.isf((np.arange(QUANTILES) + 0.5) / QUANTILES)
    if law.atoms[0].size == 0 and float((x * law.pdf(x)).max()) < 1.0 + spring:
        return 0.0
    return float(turns)


def refuse_long_ringing(contacts: Contacts, drive: Drive) -> None:
    """InputError where contacts that form at once surely slip, and the slider then rings on them too often."""
    turns = oscillations(contacts, drive)
    if turns:
        latest, _ = _after_first_slip(contacts, drive)
        fault = f"after a slip the slider rings {turns:.1e} times, and at most {MOST_OSCILLATIONS:.0e} may come"
        hint = f"give a damping ({enough_damping(drive)}), or end the path before {latest:.4g}"
        refuse("mass", drive.mass, f"{fault}; {hint}")
