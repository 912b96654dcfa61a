"""Sliders with mass that ring without end on contacts that form at once: told before the work."""

import numpy as np

from master.stick_slip.extremes import extremes
from origins import Contacts
from origins.drive import Drive
from origins.errors import refuse

# Oscillations of a stuck slider beyond which it is refused. Contacts break in each, so that each is followed by itself:
# of 16 undamped sliders drawn with 4e4 to 8e7 of them left, those two that do not slip were followed to their end, and
# no other one within 5 to 13 s.
MOST_OSCILLATIONS = 1e6
# Ringing fades by so many e-folds until it counts as rest.
FADES = 10.0
# Accuracy of the steepest fall of F and of its largest value.
OF_EXTREMES = 1e-3


def enough_damping(drive: Drive) -> str:
    """A damping that lets no slider ring for long, in words."""
    critical = 2.0 * (float(drive.mass or 0.0) * (1.0 + float(drive.spring or 0.0))) ** 0.5
    return f"a hundredth of the critical one of a slider that sticks is {0.01 * critical:.3g}"


def _after_first_slip(contacts: Contacts, drive: Drive) -> tuple[float, float]:
    """X_T at which the first slip has begun at the latest, and the time left from there; no time where there may be
    none, or that is not known beforehand.

    From relaxed contacts a slider on a spring softer than K* has slipped where F falls most steeply, and F was no
    larger than its largest value; a swing is short beside that.
    """
    spring = float(drive.spring or 0.0)
    relaxed = contacts.start.span == (0.0, 0.0) and contacts.reforming is None
    if not (relaxed and drive.forward and contacts.stiffness == "independent"):
        return 0.0, 0.0
    found = extremes(contacts, drive.velocity, OF_EXTREMES)
    critical, error, steepest = found.fall
    latest = steepest + found.force.value / spring
    # `not` refuses nothing where K* is not known
    if not (spring < critical - error and latest < drive.path[-1]):
        return latest, 0.0
    times = np.append(0.0, drive.arrival_times(0.0))
    return latest, float(times[-1] - np.interp(latest, np.append(0.0, drive.path), times))


def oscillations(contacts: Contacts, drive: Drive) -> tuple[float, float]:
    """How often the slider rings on contacts that form at once, after a slip, and X_T at which that has begun at the
    latest; 0 where it surely does so less often than MOST_OSCILLATIONS, or may not slip."""
    mass, spring = float(drive.mass or 0.0), float(drive.spring or 0.0)
    fading = FADES * 2.0 * mass / drive.damping if drive.damping else np.inf
    in_time = np.sqrt((1.0 + spring) / mass) / (2.0 * np.pi)
    if min(float(drive.arrival_times(0.0)[-1]), fading) * in_time < MOST_OSCILLATIONS:
        return 0.0, 0.0
    latest, time_after = _after_first_slip(contacts, drive)
    turns = float(min(time_after, fading) * in_time)
    return (turns if turns >= MOST_OSCILLATIONS else 0.0), latest


def refuse_long_ringing(contacts: Contacts, drive: Drive) -> None:
    """InputError where contacts that form at once surely slip, and the slider then rings on them too often."""
    turns, latest = oscillations(contacts, drive)
    if turns:
        fault = f"after a slip the slider rings {turns:.1e} times, and at most {MOST_OSCILLATIONS:.0e} may come"
        hint = f"give a damping ({enough_damping(drive)}), or end the path before {latest:.4g}"
        refuse("mass", drive.mass, f"{fault}; {hint}")
