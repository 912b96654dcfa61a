"""A contact whose threshold diffuses: followed in steps, with a bridge between them where it may be met.

Lengths are in units of the lattice, but for those of rates.
"""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from eq_model.bins import place_of
from eq_model.breaking import rate
from eq_model.compiling import bare
from eq_model.lives import LIVES, LOOKS, Break
from eq_model.streams import STEPS, uniform, words_at
from eq_model.watch import look_at

_F = np.float64
_FAR = 8.0  # standard deviations that a threshold does not diffuse in a step
_THERMAL = 0.1  # of what a contact bears, spent in one step
_CHANGE, _UNFELT = (
    0.6,
    1e-4,
)  # of the logarithm of a rate in a step; of what is borne: needs no care
_OF_THE_GAP = (
    0.15  # between the stretch and the upper end of the final law, a step's standard deviation
)
_FELT = 0.25  # standard deviations of a step closer to an end than which no drift is felt
_FORGOTTEN = 0.5  # of the time in which old thresholds forget: the longest step where rates count
_NUDGE = 1e-3  # of the stretch, and of the logarithm of the rate that it changes


class Ageing(NamedTuple):
    """Diffusion of thresholds, towards a normal law or one whose drift is tabled (ageing_tables)."""

    normal: bool
    mean: float
    width: float
    relaxing: float  # per time
    diffusion: float  # squared units per time
    first: float  # of the table's places
    step: float
    values: npt.NDArray[np.float64]
    slopes: npt.NDArray[np.float64]
    shares: npt.NDArray[np.float64]  # of the longest step, squared standard deviations
    low: float  # ends of the final law, and of the table
    high: float
    near: float
    far: float
    longest: float  # time of a step near the stretch that a threshold must not meet
    coarse: float  # how much coarser than need be other steps are
    warm: bool  # whether contacts break at rates besides
    rates: Any
    unit: float  # a length

    def coarser(self, times: float) -> "Ageing":
        """With steps so many times longer."""
        # the integral of a rate is of fourth order in the change of its logarithm
        return self._replace(longest=times * self.longest, coarse=times**0.25)


@bare
def _normal(a, b, c):  # type: ignore[no-untyped-def]
    """A draw of the standard normal law from three words."""
    return np.sqrt(-2.0 * np.log(uniform(a, b))) * np.cos(2.0 * np.pi * (_F(c) + 0.5) * 2.0**-32)


@bare
def _hermite(place, values, slopes, step):  # type: ignore[no-untyped-def]
    """A tabled function between its nodes, from its values and slopes there."""
    k = min(max(int(place), 0), values.size - 2)
    t = place - k
    rise = values[k + 1] - values[k]
    p, q = slopes[k] * step - rise, slopes[k + 1] * step - rise
    return values[k] + t * (rise + (1.0 - t) * (p - t * (p + q)))


@bare
def _rate(x, y, ageing):  # type: ignore[no-untyped-def]
    return rate(ageing.rates, min(x, y) * ageing.unit, y * ageing.unit, 1.0)


@bare
def _drift(y, ageing):  # type: ignore[no-untyped-def]
    """Mean change of a threshold per time, over D, towards a law that is not normal."""
    y = min(max(y, ageing.near), ageing.far)
    below, above = y - ageing.low, ageing.high - y
    place = (_over(below, above) - ageing.first) / ageing.step
    slope = _hermite(place, ageing.values, ageing.slopes, ageing.step)
    return slope * (1.0 / below + 1.0 / above)


@bare
def _over(below, above):  # type: ignore[no-untyped-def]
    """Where a threshold is in the tables, by its distance from the law's ends."""
    return np.log(below / above) if above < np.inf else np.log(below)


@bare
def _local(y, here, speed, ageing):  # type: ignore[no-untyped-def]
    """The time of a step from a threshold y; the stretch |x| = here grows with `speed`."""
    low, high, shares = ageing.low, ageing.high, ageing.shares
    y = min(max(y, ageing.near), ageing.far)
    place = (_over(y - low, high - y) - ageing.first) / ageing.step
    k = min(max(int(place), 0), shares.size - 2)
    part = min(max(place - k, 0.0), 1.0)
    time = ageing.longest * (shares[k] + part * (shares[k + 1] - shares[k]))
    if high < np.inf and here >= low:
        # a threshold meets the stretch or the wall in one step, not both
        gap = max(high - here, 1.0)
        time = min(time, (_OF_THE_GAP * gap) ** 2 / (2.0 * ageing.diffusion))
        if speed > 0.0:
            time = min(time, 0.5 * gap / speed)
    return time


@bare
def _moved(y, time, normal, uniform, walled, ageing):  # type: ignore[no-untyped-def]
    """A threshold a time later: in an exact step towards a normal law, else by Heun's, of second order in the mean.

    A step that comes to the final law's upper end, or to its lower one where that is above the stretch (walled), is
    reflected by how far it went beyond, exact but for the change of the drift; how far a Brownian bridge tells.
    """
    diffusion, low, high = ageing.diffusion, ageing.low, ageing.high
    if ageing.normal:
        lost = -np.expm1(-ageing.relaxing * time)
        spread = ageing.width * np.sqrt(lost * (2.0 - lost))
        return y + (ageing.mean - y) * lost + spread * normal
    spread = np.sqrt(2.0 * diffusion * time)
    # closer to an end than this no drift is felt through a step
    least, most = low + _FELT * spread, high - _FELT * spread
    slope = _drift(min(max(y, least), most), ageing)
    guess = low + abs(y + diffusion * time * slope + spread * normal - low)
    if high < np.inf:
        guess = high - abs(high - guess)
    there = _drift(min(max(guess, least), most), ageing)
    later = y + 0.5 * diffusion * time * (slope + there) + spread * normal
    if walled and y - low <= high - y:
        lowest = 0.5 * (
            y + later - np.sqrt((later - y) ** 2 - 2.0 * spread * spread * np.log(uniform))
        )
        later += max(low - lowest, 0.0)
    elif high < np.inf:
        highest = 0.5 * (
            y + later + np.sqrt((later - y) ** 2 - 2.0 * spread * spread * np.log(uniform))
        )
        later -= max(highest - high, 0.0)
    return min(max(later, low), high) if walled else min(later, high)


@bare
def _safe(gap, y, x, speed, ageing):  # type: ignore[no-untyped-def]
    """A time within which a threshold y does not come down to a stretch |x| that grows with `speed`."""
    if not ageing.normal:
        return 0.0
    # what is above the mean may come down to it
    gap = min(y, max(ageing.mean, 0.0)) - x
    if gap <= 0.0:
        return 0.0
    spread = _FAR * np.sqrt(2.0 * ageing.diffusion)
    root = 2.0 * gap / (spread + np.sqrt(spread * spread + 4.0 * speed * gap))
    return root * root


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
def _felt(time, here, y, speed, ageing):  # type: ignore[no-untyped-def]
    """The part of a step in which the breaking rate changes little, or comes to nothing, and little is borne."""
    coarser, relaxing, diffusion = ageing.coarse, ageing.relaxing, ageing.diffusion
    now = max(_rate(here, y, ageing), 1e-300)
    time, change = min(time, coarser**2 * _THERMAL / now), coarser * _CHANGE
    drift = relaxing * abs(ageing.mean - y) if ageing.normal else diffusion * abs(_drift(y, ageing))
    while True:
        of_stretch, of_threshold = _steepness(here + speed * time, y, ageing)
        carried = (of_stretch * speed + of_threshold * drift) * time
        spread = of_threshold * np.sqrt(2.0 * diffusion * time)
        if max(carried, spread) <= change and relaxing * time <= coarser**2 * _FORGOTTEN:
            return time
        if (
            min(now * np.exp(min(carried + 4.0 * spread, 700.0)), _highest(y, ageing)) * time
            <= coarser**4 * _UNFELT
        ):
            return time
        time *= 0.5


@bare
def _highest(y, ageing):  # type: ignore[no-untyped-def]
    """The rate at the threshold or close to it, which few laws exceed."""
    return max(_rate(y, y, ageing), _rate(0.9 * y, y, ageing))


@bare
def _borne(first, last, time, spread):  # type: ignore[no-untyped-def]
    """Integral of a rate over a step from its ends, of which the logarithm goes straight but for a Brownian bridge."""
    ratio = np.log(last / first) if first > 0.0 and last > 0.0 else 0.0
    mean = (last - first) / ratio if abs(ratio) > 1e-4 else 0.5 * (first + last)
    return mean * time * (1.0 + min(spread * spread, 1.0) / 12.0)


@bare
def _first_meeting(above, below, spread, normal, uniform):  # type: ignore[no-untyped-def]
    """Part of a step after which a Brownian bridge from `above` zero first meets it, when it does.

    I/(1 + I), I of the inverse Gaussian law of mean above/|below| and shape above²/spread², spread² the variance of
    the step without ends.
    """
    if above <= 0.0:
        return 0.0
    if below == 0.0:
        return 1.0
    mean, shape = above / abs(below), (above / spread) ** 2
    w = 0.5 * mean * normal * normal / shape
    first = mean / (1.0 + w + np.sqrt(w * (2.0 + w)))
    if uniform * (mean + first) > mean:
        first = mean * (mean / first)
    return first / (1.0 + first)


def grow_old(law, contact, course, watch, counts):  # type: ignore[no-untyped-def]
    """The break of a contact whose threshold diffuses, counted at the watched points on its way."""
    ageing, lane, stream, clock, leg = law, contact.lane, contact.stream, contact.clock, contact.leg
    legs, y, x, place = (
        course.directions.size,
        _F(contact.threshold),
        contact.stretch,
        contact.drawn,
    )
    bears, diffusion = np.exp(contact.exposure), ageing.diffusion
    seen, moments = np.int64(0), watch.moments
    while counts.shape[0] and seen < moments.size and moments[seen] < clock:
        seen += 1
    many = moments.size if counts.shape[0] else 0
    while leg < legs:
        at, d, pace = clock, course.directions[leg], course.paces[leg]
        end, stretch = course.begins[leg + 1], x
        # on a leg the stretch is followed as a number, and rounded where the contact breaks
        passed, room = 0.0, _F(end - at)
        while passed < room:
            now = _F(stretch) + d * passed
            leaving = d * now >= 0.0
            left = (room - passed) * pace
            if d != 0 and not leaving:
                left = min(left, max(-d * now, 1.0) * pace)
            here, speed = abs(now), (1.0 / pace if d != 0 and leaving else 0.0)
            if seen < many and moments[seen] < end:
                left = min(left, max(_F(moments[seen] - at) - passed, 1.0) * pace)
            own = ageing.longest
            if not ageing.normal:
                own = _local(y, here, speed, ageing)
                # what comes to the law's lower end is reflected where the stretch is below, and breaks beyond
                if d != 0 and (here < ageing.low) == leaving and here != ageing.low:
                    left = min(left, max(abs(ageing.low - here), 1.0) * pace)
            time = min(max(own, _safe(y - here, y, here, speed, ageing)), left)
            if ageing.warm:
                time = _felt(time, min(here, y), y, speed, ageing)
                time = min(max(time, 1e-3 * own), left)
            words = words_at(lane, place, stream, STEPS)
            place += 1
            ticks = time / pace
            then = abs(_F(stretch) + d * (passed + ticks))
            walled = here + then < 2.0 * ageing.low
            chance = (_F(words[3]) + 0.5) * 2.0**-32
            reflected = chance
            if not walled and ageing.high < np.inf:
                more = words_at(lane, place, stream, STEPS)
                place += 1
                reflected = (_F(more[3]) + 0.5) * 2.0**-32
            later = _moved(
                y, time, _normal(words[0], words[1], words[2]), reflected, walled, ageing
            )
            # the stretch is rounded where a leg ends
            above, below = max(y - here, 0.0), later - then
            part, broken = 1.0, below <= 0.0 and not walled
            if not broken and not walled:
                broken = chance < np.exp(-above * below / (diffusion * time))
            if broken:
                words = words_at(lane, place, stream, STEPS)
                place += 1
                chance = (_F(words[3]) + 0.5) * 2.0**-32
                normal = _normal(words[0], words[1], words[2])
                part = _first_meeting(above, below, np.sqrt(2.0 * diffusion * time), normal, chance)
            if ageing.warm:
                first, met = _rate(here, y, ageing), here + part * (then - here)
                last = _rate(met, met, ageing) if broken else _rate(then, later, ageing)
                spread = _steepness(min(here, y), y, ageing)[1] * np.sqrt(
                    2.0 * diffusion * time * part
                )
                spent = _borne(first, last, time * part, spread)
                if spent >= bears:
                    part *= bears / spent
                    broken = True
                bears -= spent
            if broken:
                gone = min(np.int64(np.floor(passed + part * ticks + 0.5)), end - at)
                return Break(at + gone, leg, place, True)
            passed += ticks
            y = later
            while seen < many and _F(moments[seen] - at) <= passed + 0.5:
                birth = place_of(moments[seen], leg, course) - stretch - d * (moments[seen] - at)
                look_at(seen, birth, y, watch, counts)
                seen += 1
            if room - passed < 0.5:
                break
        x = stretch + d * (end - at)
        leg += 1
        clock = end
    return Break(course.begins[legs] + 1, leg, place, True)


def _look(law, contact, course, born, broken, birth, watch, counts):  # type: ignore[no-untyped-def]
    """Counted on the way, where the threshold is known."""


LIVES[Ageing] = grow_old
LOOKS[Ageing] = _look
