"""Sliders with mass that ring without end, or whose delay is far too short beside a slip: told before the work."""

import numpy as np

from master.soft.inertia.delayed.panel_search import MOST_PANELS
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
# Panels between two volleys of contacts that form and break together, one delay apart: 2 to 90 were seen on 12 paths,
# so that the forecast is an estimate, and no bound. Of five refused paths, the two that seemed to need the fewest
# panels were followed: both met the most that are followed before their end.
OF_A_VOLLEY = 20.0
# A swing is slow from so many times the delay and the passing of a threshold on; and swings have grown after so many
# times M over the fall of F_k.
SLOW, GROWN = 10.0, 100.0


def enough_damping(drive: Drive) -> str:
    """A damping that lets no slider ring for long, in words."""
    critical = 2.0 * (float(drive.mass or 0.0) * (1.0 + float(drive.spring or 0.0))) ** 0.5
    return f"a hundredth of the critical one of a slider that sticks is {0.01 * critical:.3g}"


def slip_time(mass: float, damping: float, spring: float) -> float:
    """About how long a slip lasts until its swings are no longer than a threshold; all three per N_c<k>."""
    if damping == 0.0:
        return np.inf
    apart = np.sqrt(max(damping**2 - 4.0 * mass * spring, 0.0))
    fading = 2.0 * spring / (damping + apart) if apart else 0.5 * damping / mass
    return float(np.pi * np.sqrt(mass / spring) + max(-np.log(spring), 0.0) / fading)


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


def refuse_long_ringing(contacts: Contacts, drive: Drive) -> None:
    """InputError where contacts that form at once surely slip, and the slider then rings on them too often.

    F' is 1 - X P_c(X) before contacts break for the second time; below -K somewhere, the slider slips.
    """
    law, mass, spring = contacts.thresholds, float(drive.mass or 0.0), float(drive.spring or 0.0)
    latest, left = _after_first_slip(contacts, drive)
    fading = FADES * 2.0 * mass / drive.damping if drive.damping else np.inf
    turns = min(left, fading) * np.sqrt((1.0 + spring) / mass) / (2.0 * np.pi)
    if turns < MOST_OSCILLATIONS:
        return
    x = law.isf((np.arange(QUANTILES) + 0.5) / QUANTILES)
    if law.atoms[0].size == 0 and float((x * law.pdf(x)).max()) < 1.0 + spring:
        return
    fault = f"after a slip the slider rings {turns:.1e} times, and at most {MOST_OSCILLATIONS:.0e} may come"
    hint = f"give a damping ({enough_damping(drive)}), or end the path before {latest:.4g}"
    refuse("mass", mass, f"{fault}; {hint}")


def refuse_short_delay(contacts: Contacts, drive: Drive) -> None:
    """InputError where sliding is surely unstable at the drive's speed v, and swings would take too many panels.

    Steady sliding has F_k(v) = F_k/(1 + v tau/<x_s>). Where that falls faster than the damping rises, swings that are
    slow beside the delay and the passing of a threshold grow (docs/sliders.md). Panels are no wider than the delay, or
    take a threshold each.
    """
    unit, spring = contacts.mean_threshold, float(drive.spring or 0.0)
    mass, delay = float(drive.mass or 0.0), contacts.waiting_time
    latest, left = _after_first_slip(contacts, drive)
    if not left:
        return
    speed = float(drive.path[-1] - latest) / left
    kinetic = 0.5 * spring * latest
    falls = kinetic * delay / unit / (1.0 + speed * delay / unit) ** 2
    swing = float(np.pi * np.sqrt(mass / spring))
    slow = swing > SLOW * max(delay, unit / speed)
    if not (slow and falls > 2.0 * drive.damping and left > GROWN * mass / falls):
        return
    lasts = min(slip_time(mass, drive.damping, spring), left)
    panels = min(OF_A_VOLLEY * lasts / delay, speed * left / unit)
    if panels > MOST_PANELS:
        fault = f"contacts break and form too often in a slip that lasts some {lasts:.2g}"
        fault += f", on about {panels:.0e} panels of time"
        hint = f"take eq_model.simulate, end the path before {latest:.4g}, or leave the mass out and give a slip rule"
        refuse("delay", delay, f"{fault}, of which at most {MOST_PANELS:,} are followed; {hint}")
