"""A contact whose threshold diffuses: followed in steps, with a Brownian bridge for a break within a step.

Lengths are whole numbers of the unit of the run (WholeDrive.unit), except those of rate laws.
"""

from typing import Any, NamedTuple

import numpy as np

from eq_model.compiling import bare, real, whole
from eq_model.contact import AGED, BREAKS, Break, bin_of, look_at, place_of, rate_at
from eq_model.draws.streams import STEPS, WATCHED, uniform, words_at
from eq_model.whole_drive import WholeDrive
from origins import Contacts
from origins.thresholds.law import Array

SECONDS = 1e-7  # of a break, or a step; see settings.KERNELS


class Diffusing(NamedTuple):
    """Diffusion of thresholds y, towards a normal law, or another one on y > 0 by a table of its slopes."""

    normal: bool
    mean: float
    width: float
    diffusion: float  # squared units per time
    slopes: Array  # d ln P_cf/d ln y at equal steps of ln y
    least_log: float  # ln y of the first slope
    step: float  # of ln y
    longest: float  # longest step (a time) where the threshold is near the stretch
    coarse: float  # factor on steps with heat, 1 for the usual ones
    warm: bool  # whether contacts also break at a rate
    rates: Any
    unit: float  # a length

    def coarser(self, times: float) -> "Diffusing":
        """The same law with steps `times` times longer."""
        # the error of a rate's integral is of fourth order in the change of its logarithm
        return self._replace(longest=times * self.longest, coarse=times**0.25)


def make(contacts: Contacts, drive: WholeDrive, warm: bool, rates: Any, unit: float) -> Diffusing:
    """The ageing of these contacts; see settings.KERNELS."""
    from scipy.interpolate import CubicSpline

    ageing, fresh = contacts.ageing, contacts.thresholds
    assert ageing is not None
    normal, final, diffusion = ageing.normal, ageing.final, ageing.rate / unit**2
    heat = 1.0, warm, rates, unit
    if normal is not None:
        # within the longest step, 0.04 of the relaxation time, diffusion is taken as free
        law = normal.mean / unit, normal.std / unit, diffusion, np.zeros(2), 0.0, 1.0
        return Diffusing(True, *law, 0.04 / normal.rate, *heat)
    # the standard deviation of a step is 0.1 times the width of the law's middle half
    middle = float(final.isf(0.25) - final.ppf(0.25))
    # the table ends 1e-5 widths above 0, and where less than 1e-14 of either law lies beyond
    near = max(min(float(final.ppf(1e-14)), float(fresh.ppf(1e-14))), 1e-5 * middle)
    log = np.linspace(np.log(near), np.log(max(final.isf(1e-14), fresh.isf(1e-14))), 4097)
    slopes = CubicSpline(log, final.logpdf(np.exp(log)))(log, 1)
    law = 0.0, 0.0, diffusion, slopes, float(log[0] - np.log(unit)), float(log[1] - log[0])
    return Diffusing(False, *law, 0.005 * middle**2 / ageing.rate, *heat)


def often(contacts: Contacts, lasts: Array, moved: Array, law: Diffusing) -> float:
    """How many steps a contact takes; see settings.KERNELS."""
    return float(lasts.sum()) / law.longest


@bare
def _normal(words):  # type: ignore[no-untyped-def]
    """A draw of the standard normal law from three of four words."""
    angle = 2.0 * np.pi * (real(words[2]) + 0.5) * 2.0**-32
    return np.sqrt(-2.0 * np.log(uniform(words[0], words[1]))) * np.cos(angle)


@bare
def _fourth(words):  # type: ignore[no-untyped-def]
    """A number between 0 and 1, from the fourth of four words."""
    return (real(words[3]) + 0.5) * 2.0**-32


@bare
def _first_meeting(above, below, spread, bell, chance):  # type: ignore[no-untyped-def]
    """Share of a step after which a Brownian bridge that starts at `above` first reaches zero, given that it does.

    It is I/(1 + I), with I from the inverse Gaussian law of mean above/|below| and shape above²/spread², drawn from a
    standard normal `bell` and a uniform `chance`; spread is the standard deviation of the unconditioned step.
    """
    if above <= 0.0:
        return 0.0
    if below == 0.0:
        return 1.0
    mean, shape = above / abs(below), (above / spread) ** 2
    w = 0.5 * mean * bell * bell / shape
    first = mean / (1.0 + w + np.sqrt(w * (2.0 + w)))
    if chance * (mean + first) > mean:
        first = mean * (mean / first)
    return first / (1.0 + first)


@bare
def _between(above, below, variance, part, lane, turn, stream):  # type: ignore[no-untyped-def]
    """Value of a Brownian bridge from `above` to `below` after a share of its way, given that it stays above zero.

    It is the distance of a bridge in three dimensions, whose end has a random direction (Williams, 1974).
    """
    part = min(max(part, 0.0), 1.0)
    width = np.sqrt(variance * part * (1.0 - part))
    first, second = words_at(lane, turn, stream, WATCHED), words_at(lane, turn, stream, WATCHED + 1)
    third = words_at(lane, turn, stream, WATCHED + 2)
    chance, pull = _fourth(first), above * below / variance
    along = 2.0 * chance - 1.0
    if pull > 1e-6:
        along = 1.0 + np.log(chance + (1.0 - chance) * np.exp(-2.0 * pull)) / pull
    across = np.sqrt(max(1.0 - along * along, 0.0))
    x = (1.0 - part) * above + part * below * along + width * _normal(first)
    y = part * below * across + width * _normal(second)
    return np.sqrt(x * x + y * y + (width * _normal(third)) ** 2)


@bare
def _straightened(above, below, x, time, law):  # type: ignore[no-untyped-def]
    """Ends of a straight Brownian bridge for one that a normal law pulls at a rate θ, so that both meet zero alike.

    The pull bends it by θ² t (T - t)/2 times the way from x to the law's mean; the bend's tangent is taken where the
    bridge most probably meets zero.
    """
    relaxed = law.diffusion / (law.width * law.width) * time
    bend = 0.5 * relaxed * relaxed * (law.mean - x) if law.normal else 0.0
    fraction = above / max(above + abs(below), 1e-300)
    return above + bend * fraction * fraction, below + bend * (1.0 - fraction) * (1.0 - fraction)


@bare
def _drift(y, law):  # type: ignore[no-untyped-def]
    """Mean change of a threshold per time, divided by D, towards a law that is not normal."""
    last = law.slopes.size - 1
    place = min(max((np.log(y) - law.least_log) / law.step, 0.0), real(last))
    k = min(whole(place), last - 1)
    slope = law.slopes[k] + (place - k) * (law.slopes[k + 1] - law.slopes[k])
    return slope / np.exp(law.least_log + place * law.step)


@bare
def _moved(y, time, bell, law):  # type: ignore[no-untyped-def]
    """A threshold a time later: exact towards a normal law, else by Heun's step, of second order in the mean."""
    if law.normal:
        relaxed = -np.expm1(-law.diffusion / (law.width * law.width) * time)
        return y + (law.mean - y) * relaxed + law.width * np.sqrt(relaxed * (2.0 - relaxed)) * bell
    spread = np.sqrt(2.0 * law.diffusion * time)
    # nearer to 0 than a quarter of the step's standard deviation the drift is the one there
    slope = _drift(max(y, 0.25 * spread), law)
    slope += _drift(max(abs(y + law.diffusion * time * slope + spread * bell), 0.25 * spread), law)
    return y + 0.5 * law.diffusion * time * slope + spread * bell


@bare
def _steepness(x, y, law):  # type: ignore[no-untyped-def]
    """How fast the logarithm of the rate changes with the stretch x >= 0, and with the threshold y."""
    step = 1e-3 * max(y, 1.0)
    x = max(min(x, y - 2.0 * step), 0.0)
    here = np.log(max(rate_at(x, y, law, 1.0), 1e-300))
    of_x = np.log(max(rate_at(x + step, y, law, 1.0), 1e-300)) - here
    of_y = np.log(max(rate_at(x, y + step, law, 1.0), 1e-300)) - here
    return abs(of_x) / step, abs(of_y) / step


@bare
def _step(y, x, speed, longest, law):  # type: ignore[no-untyped-def]
    """The time of the next step, at most `longest`; the stretch x >= 0 grows with `speed`."""
    if law.normal:
        # the time in which the threshold hardly comes down to the stretch, once in 2e7 steps, so that the error of a
        # long step does not matter: by 5.5 standard deviations of its diffusion; one above the mean may drift to that
        gap, spread = max(min(y, law.mean) - x, 0.0), 5.5 * np.sqrt(2.0 * law.diffusion)
        root = 2.0 * gap / (spread + np.sqrt(spread * spread + 4.0 * speed * gap))
        time = max(law.longest, root * root)
    else:  # drifts are steep near 0: a step's standard deviation is at most 0.2 of the way there
        time = min(law.longest, max((0.2 * y) ** 2 / (2.0 * law.diffusion), 0.01 * law.longest))
    if not law.warm:
        return min(time, longest)
    # the step in which the integral of the breaking rate is small, and its logarithm changes little
    time = min(time, longest, law.coarse**2 * 0.1 / max(rate_at(x, y, law, 1.0), 1e-300))
    change = law.coarse * 0.6
    pull = law.diffusion * abs((law.mean - y) / law.width**2 if law.normal else _drift(y, law))
    for _ in range(2):  # the rate is steeper, or less so, where the step ends
        of_x, of_y = _steepness(min(x + speed * time, y), y, law)
        time = min(time, change / max(of_x * speed + of_y * pull, 1e-300))
        time = min(time, (change / max(of_y, 1e-300)) ** 2 / (2.0 * law.diffusion))
    return min(max(time, 1e-3 * law.longest), longest)


def break_diffusing(law, contact, drive, counts):  # type: ignore[no-untyped-def]
    """The break of a contact whose threshold diffuses, counted at the watched points on its way."""
    lane, stream, drawn, y = contact.lane, contact.stream, contact.drawn, real(contact.threshold)
    begin, leg, stretch = contact.clock, contact.leg, contact.stretch
    remaining, watched = np.exp(contact.log_exposure), drive.before[bin_of(begin, drive)]
    while leg < drive.directions.size:
        d, pace, end = drive.directions[leg], drive.paces[leg], drive.begins[leg + 1]
        # on a leg the travel is a float, and is rounded where the contact breaks
        passed, room = 0.0, real(end - begin)
        while room - passed >= 0.5:
            r, longest = real(stretch) + d * passed, (room - passed) * pace
            x, returns = abs(r), d * r < 0.0
            if returns:  # a step ends where the contact is relaxed
                longest = min(longest, max(x, 1.0) * pace)
            time = _step(y, x, 0.0 if returns or d == 0 else 1.0 / pace, longest, law)
            words = words_at(lane, drawn, stream, STEPS)
            ticks, later = time / pace, _moved(y, time, _normal(words), law)
            then = abs(r + d * ticks)
            above, below, variance = max(y - x, 0.0), later - then, 2.0 * law.diffusion * time
            bent_above, bent_below = _straightened(above, below, 0.5 * (x + then), time, law)
            met_before = np.exp(-2.0 * bent_above * bent_below / variance)  # the chance of it
            broken = below <= 0.0 or _fourth(words) < met_before
            met = 1.0  # share of the step until the threshold is met
            if broken:
                drawn += 1
                words, spread = words_at(lane, drawn, stream, STEPS), np.sqrt(variance)
                met = _first_meeting(bent_above, bent_below, spread, _normal(words), _fourth(words))
                below, variance = 0.0, variance * met
            drawn += 1
            part = met
            if law.warm:
                last_stretch, first = x + met * (then - x), rate_at(x, y, law, 1.0)
                last = rate_at(last_stretch, last_stretch if broken else later, law, 1.0)
                spread = _steepness(min(x, y), y, law)[1] * np.sqrt(variance)
                # integral of the rate, with ln h linear in time plus a Brownian bridge
                ratio = np.log(last / first) if first > 0.0 and last > 0.0 else 0.0
                mean = (last - first) / ratio if abs(ratio) > 1e-4 else 0.5 * (first + last)
                spent = mean * time * met * (1.0 + min(spread * spread, 1.0) / 12.0)
                if spent >= remaining:
                    part, broken = met * remaining / spent, True
                remaining -= spent
            gone = min(whole(np.floor(passed + part * ticks + 0.5)), end - begin)
            until = begin + gone if broken else begin + whole(passed + ticks + 0.5) + 1
            while watched < counts.shape[0]:
                instant = drive.bin_ends[drive.watched[watched]]
                if instant >= until or instant > end:
                    break
                fraction = (real(instant - begin) - passed) / max(met * ticks, 1.0)
                # a path has at most 2^12 watched points
                turn, low = (drawn << 12) | watched, max(below, 0.0)
                gap = _between(above, low, max(variance, 1e-300), fraction, lane, turn, stream)
                birth = place_of(instant, leg, drive) - stretch - d * (instant - begin)
                look_at(watched, birth, x + fraction * met * (then - x) + gap, drive, counts)
                watched += 1
            if broken:
                return Break(begin + gone, leg, drawn)
            passed += ticks
            y = later
        stretch += d * (end - begin)
        leg += 1
        begin = end
    return Break(drive.begins[drive.directions.size] + 1, leg, drawn)


BREAKS[Diffusing] = break_diffusing
# break_diffusing itself counts contacts at watched points, as it knows their thresholds
AGED[Diffusing] = lambda law, contact, drive, instant: -1.0
