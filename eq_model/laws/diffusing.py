"""A contact whose threshold diffuses: followed in steps, with a Brownian bridge for a break within a step.

Lengths are in units of the lattice, except those of rate laws.
"""

from typing import Any, NamedTuple

import numpy as np

from eq_model.compiling import bare, real, whole
from eq_model.contact import AGED, BREAKS, Break, look_at, place_of, rate
from eq_model.draws.streams import STEPS, WATCHED, uniform, words_at
from eq_model.laws.ageing_tables import DriftTable

_THERMAL = 0.1  # largest integral of the breaking rate over one step
_CHANGE = 0.6  # largest change of ln h in a step
_NUDGE = 1e-3  # difference for slopes of ln h, over the threshold
_NEVER = 23.0  # no random number of 32 bits is below e^-23
_FAR = 8.0  # standard deviations that no threshold diffuses in a step
_OF_THE_GAP = 0.15  # a step's standard deviation, over the gap from stretch to the law's upper end
_OF_THE_WAY, _LEAST = 0.2, 0.01  # the same over the distance to 0; shortest step, over the longest
_FELT = 0.25  # standard deviations of a step: nearer to an end the drift is taken as constant
_MOST_WATCHED = 12  # bits of the index of a watched point


class Ageing(NamedTuple):
    """Diffusion of thresholds, towards a normal law or one with a table of its drift (ageing_tables)."""

    normal: bool
    mean: float
    width: float
    relaxing: float  # per time
    diffusion: float  # squared units per time
    table: DriftTable
    longest: float  # longest step (a time) where the threshold is near the stretch
    coarse: float  # factor on steps with heat, 1 for the usual ones
    warm: bool  # whether contacts also break at a rate
    rates: Any
    unit: float  # a length

    def coarser(self, times: float) -> "Ageing":
        """The same law with steps `times` times longer."""
        # the error of a rate's integral is of fourth order in the change of its logarithm
        return self._replace(longest=times * self.longest, coarse=times**0.25)


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

    It is I/(1 + I), with I from the inverse Gaussian law of mean above/|below| and shape above²/spread²; spread is the
    standard deviation of the unconditioned step.
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
def _drift(y, ageing):  # type: ignore[no-untyped-def]
    """Mean change of a threshold per time, over D, towards a law that is not normal."""
    table, values = ageing.table, ageing.table.values
    y = min(max(y, table.near), table.far)
    below, above = y - table.low, table.high - y
    place = (np.log(below / above if above < np.inf else below) - table.first) / table.step
    k = min(max(whole(place), 0), values.size - 2)
    slope = values[k] + (place - k) * (values[k + 1] - values[k])
    return slope * (1.0 / below + 1.0 / above)


@bare
def _moved(y, time, bell, chance, walled, ageing):  # type: ignore[no-untyped-def]
    """A threshold a time later, towards a law that is not normal: by Heun's step, of second order in the mean.

    A step that reaches the final law's upper end, or its lower end where that is above the stretch (walled), is
    reflected there by its largest excess beyond, drawn as the extreme of a Brownian bridge.
    """
    diffusion, low, high = ageing.diffusion, ageing.table.low, ageing.table.high
    spread = np.sqrt(2.0 * diffusion * time)
    # nearer to an end than this the drift is that at these points
    least, most = low + _FELT * spread, high - _FELT * spread
    slope = _drift(min(max(y, least), most), ageing)
    guess = low + abs(y + diffusion * time * slope + spread * bell - low)
    guess = min(guess, 2.0 * high - guess)
    there = _drift(min(max(guess, least), most), ageing)
    later = y + 0.5 * diffusion * time * (slope + there) + spread * bell
    middle = 0.5 * (y + later)
    reach = 0.5 * np.sqrt((later - y) ** 2 - 2.0 * spread * spread * np.log(chance))
    if walled and y - low <= high - y:
        later += max(low - middle + reach, 0.0)
    elif high < np.inf:
        later -= max(middle + reach - high, 0.0)
    return min(max(later, low), high) if walled else min(later, high)


@bare
def _rate(x, y, ageing):  # type: ignore[no-untyped-def]
    return rate(ageing.rates, min(x, y) * ageing.unit, y * ageing.unit, 1.0)


@bare
def _steepness(x, y, ageing):  # type: ignore[no-untyped-def]
    """How fast the logarithm of the rate changes with the stretch x >= 0, and with the threshold y."""
    step = _NUDGE * max(y, 1.0)
    x = max(min(x, y - 2.0 * step), 0.0)
    here = np.log(max(_rate(x, y, ageing), 1e-300))
    of_x = np.log(max(_rate(x + step, y, ageing), 1e-300)) - here
    of_y = here - np.log(max(_rate(x, y + step, ageing), 1e-300))
    return abs(of_x) / step, abs(of_y) / step


@bare
def _step(y, here, speed, left, law):  # type: ignore[no-untyped-def]
    """The time of the next step, at most `left`; the stretch |x| = here grows with `speed`."""
    time = law.longest
    gap = min(y, max(law.mean, 0.0)) - here  # a threshold above the mean may drift down to it
    if law.normal and gap > 0.0:  # the time in which the threshold cannot come down to the stretch
        spread = _FAR * np.sqrt(2.0 * law.diffusion)
        root = 2.0 * gap / (spread + np.sqrt(spread * spread + 4.0 * speed * gap))
        time = max(time, root * root)
    if not law.normal and law.table.low == 0.0:  # drifts are steep near there
        near = (_OF_THE_WAY * y) ** 2 / (2.0 * law.diffusion)
        time = min(time, max(near, _LEAST * time))
    if law.table.high < np.inf and here >= law.table.low:
        # a threshold meets the stretch or the wall in one step, not both
        gap = max(law.table.high - here, 1.0)
        time = min(time, (_OF_THE_GAP * gap) ** 2 / (2.0 * law.diffusion))
        time = min(time, 0.5 * gap / speed) if speed > 0.0 else time
    if not law.warm:
        return min(time, left)
    # the step in which the breaking rate changes little, and its integral is small
    x, change = min(here, y), law.coarse * _CHANGE
    spent = law.coarse**2 * _THERMAL / max(_rate(x, y, law), 1e-300)
    pull = law.relaxing * abs(law.mean - y)
    if not law.normal:
        pull = law.diffusion * abs(_drift(y, law))
    time = min(min(time, left), spent)
    for _ in range(2):  # the rate is steeper, or less so, where the step ends
        of_x, of_y = _steepness(min(x + speed * time, y), y, law)
        time = min(time, change / max(of_x * speed + of_y * pull, 1e-300))
        time = min(time, (change / max(of_y, 1e-300)) ** 2 / (2.0 * law.diffusion))
    return min(max(time, 1e-3 * law.longest), left)


def grow_old(law, contact, way, counts):  # type: ignore[no-untyped-def]
    """The break of a contact whose threshold diffuses, counted at the watched points on its way."""
    lane, stream, place = contact.lane, contact.stream, contact.drawn
    at, leg, wall = contact.clock, contact.leg, law.table.low
    legs, y, stretch = way.directions.size, real(contact.threshold), contact.stretch
    remaining, seen, moments = np.exp(contact.log_exposure), whole(0), way.moments
    many = moments.size if counts.shape[0] else 0
    known, lost, width = -1.0, 0.0, 0.0
    while seen < many and moments[seen] < at:
        seen += 1
    while leg < legs:
        d, pace, end = way.directions[leg], way.paces[leg], way.begins[leg + 1]
        # on a leg the travel is a float, and is rounded where the contact breaks
        passed, room = 0.0, real(end - at)
        while passed < room:
            now = real(stretch) + d * passed
            here, leaving, left = abs(now), d * now >= 0.0, (room - passed) * pace
            speed = 1.0 / pace if d != 0 and leaving else 0.0
            if d != 0 and not leaving:
                left = min(left, max(here, 1.0) * pace)
            # end the step where the stretch passes the law's lower end: below it thresholds are reflected
            if not law.normal and d != 0 and here != wall and (here < wall) == leaving:
                left = min(left, max(abs(wall - here), 1.0) * pace)
            time = _step(y, here, speed, left, law)
            words = words_at(lane, place, stream, STEPS)
            bell, chance, ticks = _normal(words), _fourth(words), time / pace
            then = abs(real(stretch) + d * (passed + ticks))
            walled = here + then < 2.0 * wall
            place += 1
            if law.normal:
                if time != known:  # most steps are as long as the last one
                    known, lost = time, -np.expm1(-law.relaxing * time)
                    width = law.width * np.sqrt(lost * (2.0 - lost))
                later = y + (law.mean - y) * lost + width * bell
            else:
                reflected = chance
                if not walled and law.table.high < np.inf:
                    reflected = _fourth(words_at(lane, place, stream, STEPS))
                    place += 1
                later = _moved(y, time, bell, reflected, walled, law)
            # the stretch is rounded where a leg ends
            above, below, variance = max(y - here, 0.0), later - then, 2.0 * law.diffusion * time
            part, broken = 1.0, below <= 0.0 and not walled
            if not broken and not walled:
                far = 2.0 * above * below / variance
                broken = far < _NEVER and chance < np.exp(-far)
            if broken:
                words = words_at(lane, place, stream, STEPS)
                place += 1
                spread, bell = np.sqrt(variance), _normal(words)
                part = _first_meeting(above, below, spread, bell, _fourth(words))
                below, variance = 0.0, variance * part
            met = part
            if law.warm:
                first, reached = _rate(here, y, law), here + part * (then - here)
                last = _rate(reached, reached, law) if broken else _rate(then, later, law)
                spread = _steepness(min(here, y), y, law)[1] * np.sqrt(variance)
                # integral of the rate, with ln h linear in time plus a Brownian bridge
                ratio = np.log(last / first) if first > 0.0 and last > 0.0 else 0.0
                mean = (last - first) / ratio if abs(ratio) > 1e-4 else 0.5 * (first + last)
                spent = mean * time * part * (1.0 + min(spread * spread, 1.0) / 12.0)
                if spent >= remaining:
                    part *= remaining / spent
                    broken = True
                remaining -= spent
            gone = min(whole(np.floor(passed + part * ticks + 0.5)), end - at)
            until = at + gone if broken else at + whole(passed + ticks + 0.5) + 1
            while seen < many and moments[seen] < until and moments[seen] <= end:
                share = (real(moments[seen] - at) - passed) / max(met * ticks, 1.0)
                turn = (place << _MOST_WATCHED) | seen
                low, wide = max(below, 0.0), max(variance, 1e-300)
                gap = _between(above, low, wide, share, lane, turn, stream)
                threshold = here + share * met * (then - here) + gap
                if not law.normal:
                    threshold = min(threshold, 2.0 * law.table.high - threshold)
                    threshold = wall + abs(threshold - wall) if walled else threshold
                birth = place_of(moments[seen], leg, way) - stretch - d * (moments[seen] - at)
                look_at(seen, birth, threshold, way, counts)
                seen += 1
            if broken:
                return Break(at + gone, leg, place, True)
            passed += ticks
            y = later
            if room - passed < 0.5:
                break
        stretch += d * (end - at)
        leg += 1
        at = end
    return Break(way.begins[legs] + 1, leg, place, True)


BREAKS[Ageing] = grow_old
# grow_old itself counts contacts at watched points, as it knows their thresholds
AGED[Ageing] = lambda law, contact, way, moment: -1.0
