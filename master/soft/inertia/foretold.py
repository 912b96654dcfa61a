"""Sliders with mass that ring without end on contacts that form at once, or swing without end while contacts wait out
their delay: told before the work."""

import numpy as np

from master.soft.first_fall import first_fall, path_beyond
from master.soft.inertia.body import RINGS
from master.stick_slip.extremes import extremes
from origins import Contacts
from origins.drive import Drive
from origins.errors import refuse

# Oscillations of a stuck slider beyond which it is refused. Contacts break in each, so that each is followed by itself:
# of 16 undamped sliders drawn with 4e4 to 8e7 of them left, those two that do not slip were followed to their end, and
# no other one within 5 to 13 s.
MOST_OSCILLATIONS = 1e6
# Ringing fades by so many e-folds until it counts as rest.
E_FOLDS_TO_REST = 10.0
# Swings on the spring and delays after the first slip beyond which an undamped slider is refused. Contacts come back
# after each delay, and break on some hundred panels: of 6 drawn with 380 to 750 delays none was followed for more than
# a fourth of its way in 12 CPU-seconds, and an answer takes several runs. That they swing so long is true: of 26
# that were refused at up to three times these numbers (four kinds of laws, K = 1e-5 to 1.4e-4) ensembles of 1,000
# contacts all swung on at the end, the spring's force by 0.9 to 1.3 mean thresholds.
MOST_SWINGS, MOST_DELAYS = 1e4, 300.0
# Mean thresholds that the slider passes in a delay at the top speed of a slip of contacts that form at once, beyond
# which few hold by then, so that it gets faster yet: gw_elastic falls by 1e-4 of its force where contacts form at once,
# but with a delay by all of it. Of 32 such machines that are refused (K = 1e-6 to 1e-4) ensembles of 300 or 1,000
# contacts all swung on at the end, the spring's force by 0.5 to 1.3 mean thresholds.
RUNS_AWAY = 10.0
# Part of the largest F by which the first slip may begin below it: behind that F never comes back to where it was.
BELOW_HIGHEST = 0.01
# Accuracy of the steepest fall of F and of its largest value.
OF_EXTREMES = 1e-3


def _critical_damping(drive: Drive) -> float:
    """Above it no slider rings: that of one that sticks."""
    return 2.0 * float(np.sqrt(float(drive.mass or 0.0) * (1.0 + float(drive.spring or 0.0))))


def enough_damping(drive: Drive) -> str:
    """A damping that lets no slider ring for long, in words; with a warning where mass and spring would not swing with
    it, as then the damping decides what the slider does."""
    asked = 0.01 * _critical_damping(drive)
    critical = 2.0 * float(np.sqrt(float(drive.spring or 0.0) * float(drive.mass or 0.0)))
    other = f", {asked / critical:.2g} times that of mass and spring: another machine"
    return f"a hundredth of the critical one of a slider that sticks is {asked:.3g}{other * (asked > critical)}"


def _usual_damping(drive: Drive) -> str:
    """The same as machines have, on springs so soft that it is more than critical for the mass on its spring: a tenth
    of that, where the slider rings on its contacts less than MOST_OSCILLATIONS times with it."""
    spring, mass = float(drive.spring or 0.0), float(drive.mass or 0.0)
    tenth = 0.2 * float(np.sqrt(spring * mass))
    rings = E_FOLDS_TO_REST / np.pi * float(np.sqrt(mass * (1.0 + spring))) / tenth
    if tenth < 0.01 * _critical_damping(drive) and rings < MOST_OSCILLATIONS:
        return f"a tenth of the critical one of mass and spring is {tenth:.3g}"
    return enough_damping(drive)


def why_too_long(drive: Drive) -> str:
    """Why a slider was not followed to its end, and what to do."""
    critical = _critical_damping(drive)
    if drive.damping <= critical:
        return f"{RINGS} ({enough_damping(drive)})"
    return (
        f"stopped as a slider this heavily damped (critical is a damping of {critical:.3g}) takes too many steps; "
        "it follows the balance of forces: leave mass and damping out, or shorten the path"
    )


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
    fading = E_FOLDS_TO_REST * 2.0 * mass / drive.damping if drive.damping else np.inf
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
        hint = f"give a damping ({_usual_damping(drive)}), or end the path before {latest:.4g}"
        refuse("mass", drive.mass, f"{fault}; {hint}")


def refuse_endless_swings(contacts: Contacts, drive: Drive, until: float) -> None:
    """InputError where an undamped slider surely slips, and then swings on its spring for too long while contacts wait.

    It slips from the largest force A of contacts that form at once, as they do while it sticks, and is left with the
    energy A²/2K. Contacts that form where it turns stop it where they bear the spring's force on the whole way, no more
    than some half of A: before a fourth of that energy is gone it swings on. Where contacts come back while it still is
    slow, neither does a slip end before a fourth of 4 F_k (A - F_k)/2K is gone, what one of contacts that form at once
    takes: that gets as fast as (A - F_k)/(K M)^½. A break takes x_s²/2, and each contact breaks once a delay at most.
    """
    mass, spring = float(drive.mass or 0.0), float(drive.spring or 0.0)
    delay, law = contacts.waiting_time, contacts.thresholds
    swing = 2.0 * np.pi * np.sqrt(mass / spring)
    least = max(MOST_SWINGS * swing, MOST_DELAYS * delay)
    if drive.damping or law.atoms[0].size or float(drive.arrival_times(0.0)[-1]) < least:
        return
    at_once = contacts.replace(delay=None)
    latest, left = _after_first_slip(at_once, drive)
    if left < least:
        return
    found = extremes(at_once, drive.velocity, OF_EXTREMES)
    steepest, highest = found.fall.position, found.force.value
    first = first_fall(at_once, path_beyond(at_once, steepest), spring, drive.velocity, until)
    kinetic = 0.5 * law.moment(2) / contacts.mean_threshold
    if first is None or not first.force >= (1.0 - BELOW_HIGHEST) * highest:
        return
    lost, fall = 0.25 * first.force**2, first.force - kinetic
    if not delay * fall >= RUNS_AWAY * contacts.mean_threshold * np.sqrt(mass * spring):
        lost = min(lost, kinetic * fall)
    lost /= 2.0 * spring
    lasts = min(left, delay * lost / (0.5 * law.moment(2)))
    if lasts >= least:
        fault = (
            f"without damping the slider swings {lasts / swing:.1e} times after its first slip, as each contact breaks "
            f"once a delay at most, and no more than {MOST_SWINGS:.0e} may come"
        )
        hint = f"give a damping ({enough_damping(drive)}), or end the path before {latest:.4g}"
        refuse("mass", drive.mass, f"{fault}; {hint}")
