"""A contact whose threshold diffuses: followed in steps, with a bridge between them where it may be met.

Lengths are in units of the lattice, but for those of rates.
"""

import numpy as np

from eq_model.breaking import rate
from eq_model.compiling import bare
from eq_model.contact import LIVES, LOOKS, Break, look_at, place_of
from eq_model.drift import Ageing, drift, first_meeting, local_step, moved, normal, safe_step
from eq_model.streams import STEPS, words_at

_F = np.float64
_THERMAL = 0.1  # of what a contact bears, spent in one step
_CHANGE = 0.6  # of the logarithm of a rate in a step
_UNFELT = 1e-4  # of what a contact bears: so little needs no care
_FORGOTTEN = 0.5  # of the time in which old thresholds forget: the longest step where rates count
_NEVER = 23.0  # no number of 32 bits is below e^-23
_NUDGE = 1e-3  # of the stretch, and of the logarithm of the rate that it changes


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
def _highest(y, ageing):  # type: ignore[no-untyped-def]
    """The rate at the threshold or close to it, which few laws exceed."""
    return max(_rate(y, y, ageing), _rate(0.9 * y, y, ageing))


@bare
def _felt(time, here, y, speed, ageing):  # type: ignore[no-untyped-def]
    """The part of a step in which the breaking rate changes little, or comes to nothing, and little is borne."""
    coarser, relaxing, diffusion = ageing.coarse, ageing.relaxing, ageing.diffusion
    now = max(_rate(here, y, ageing), 1e-300)
    time, change = min(time, coarser**2 * _THERMAL / now), coarser * _CHANGE
    pull = relaxing * abs(ageing.mean - y) if ageing.normal else diffusion * abs(drift(y, ageing))
    while True:
        of_stretch, of_threshold = _steepness(here + speed * time, y, ageing)
        carried = (of_stretch * speed + of_threshold * pull) * time
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
def _borne(first, last, time, spread):  # type: ignore[no-untyped-def]
    """Integral of a rate over a step from its ends, of which the logarithm goes straight but for a Brownian bridge."""
    ratio = np.log(last / first) if first > 0.0 and last > 0.0 else 0.0
    mean = (last - first) / ratio if abs(ratio) > 1e-4 else 0.5 * (first + last)
    return mean * time * (1.0 + min(spread * spread, 1.0) / 12.0)


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
    known, lost, width = -1.0, 0.0, 0.0
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
                own = local_step(y, here, speed, ageing)
                # what comes to the law's lower end is reflected where the stretch is below, and breaks beyond
                if d != 0 and (here < ageing.low) == leaving and here != ageing.low:
                    left = min(left, max(abs(ageing.low - here), 1.0) * pace)
            time = min(max(own, safe_step(y - here, y, here, speed, ageing)), left)
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
            bell = normal(words[0], words[1], words[2])
            if ageing.normal:
                if time != known:  # most steps are as long as the last one
                    known, lost = time, -np.expm1(-ageing.relaxing * time)
                    width = ageing.width * np.sqrt(lost * (2.0 - lost))
                later = y + (ageing.mean - y) * lost + width * bell
            else:
                later = moved(y, time, bell, reflected, walled, ageing)
            # the stretch is rounded where a leg ends
            above, below = max(y - here, 0.0), later - then
            part, broken = 1.0, below <= 0.0 and not walled
            if not broken and not walled:
                far = above * below / (diffusion * time)
                broken = far < _NEVER and chance < np.exp(-far)
            if broken:
                words = words_at(lane, place, stream, STEPS)
                place += 1
                chance = (_F(words[3]) + 0.5) * 2.0**-32
                bell = normal(words[0], words[1], words[2])
                part = first_meeting(above, below, np.sqrt(2.0 * diffusion * time), bell, chance)
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
