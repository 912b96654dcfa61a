"""A contact whose threshold diffuses, compiled: followed in steps, with a bridge between them where it may be met.

Lengths are in units of the lattice; thermal laws are those of thermal_kernel.py.
"""

import numpy as np

from eq_model.compiling import compiled
from eq_model.course_kernel import look, place_of
from eq_model.kernel import philox, uniform_of
from eq_model.thermal_kernel import SOFT, hermite, rate

_U = np.uint64
_HALF, _MASK = _U(32), _U(0xFFFFFFFF)
_PARABOLA = 1
_FAR, _THERMAL = 8.0, 0.1
_CHANGE, _UNFELT = 0.6, 1e-4  # of the logarithm of a rate in one step, and a share of what is borne that needs no care
_OF_THE_GAP = 0.15  # between the stretch and the upper end of the final law
_FELT = 0.25
_FORGOTTEN = 0.5  # of the time in which old thresholds forget


@compiled
def _normal(a, b, c):  # type: ignore[no-untyped-def]
    """A draw of the standard normal law from three words."""
    return np.sqrt(-2.0 * np.log(uniform_of(a, b))) * np.cos(2.0 * np.pi * (np.float64(c) + 0.5) * 2.0**-32)


@compiled
def _drift(y, ageing):  # type: ignore[no-untyped-def]
    """Mean change of a threshold per time, over D, towards a law that is not normal."""
    _, _, _, _, _, first, step, values, slopes, _, low, high, near, far = ageing
    y = min(max(y, near), far)
    below, above = y - low, high - y
    return hermite(_over(below, above), first, step, values, slopes) * (1.0 / below + 1.0 / above)


@compiled
def _over(below, above):  # type: ignore[no-untyped-def]
    """Where a threshold is in the tables, by its distance from the law's ends."""
    return np.log(below / above) if above < np.inf else np.log(below)


@compiled
def _local(y, here, speed, longest, ageing):  # type: ignore[no-untyped-def]
    """The time of a step from a threshold y, if `longest` is typical; the stretch |x| = here grows with `speed`."""
    _, _, _, _, diffusion, first, step, _, _, shares, low, high, near, far = ageing
    y = min(max(y, near), far)
    place = (_over(y - low, high - y) - first) / step
    k = min(max(int(place), 0), shares.size - 2)
    part = min(max(place - k, 0.0), 1.0)
    time = longest * (shares[k] + part * (shares[k + 1] - shares[k]))
    if high < np.inf and here >= low:
        # a threshold meets the stretch or the wall in one step, not both
        gap = max(high - here, 1.0)
        time = min(time, (_OF_THE_GAP * gap) ** 2 / (2.0 * diffusion))
        if speed > 0.0:
            time = min(time, 0.5 * gap / speed)
    return time


@compiled
def _moved(y, time, normal, uniform, walled, ageing):  # type: ignore[no-untyped-def]
    """A threshold a time later: in an exact step towards a normal law, else by Heun's, of second order in the mean.

    A step that comes to the final law's upper end, or to its lower one where that is above the stretch (walled), is
    reflected by how far it went beyond, exact but for the change of the drift; how far a Brownian bridge tells.
    """
    kind, mean, width, relaxing, diffusion = ageing[:5]
    if kind == _PARABOLA:
        lost = -np.expm1(-relaxing * time)
        return y + (mean - y) * lost + width * np.sqrt(lost * (2.0 - lost)) * normal
    low, high = ageing[10], ageing[11]
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
        lowest = 0.5 * (y + later - np.sqrt((later - y) ** 2 - 2.0 * spread * spread * np.log(uniform)))
        later += max(low - lowest, 0.0)
    elif high < np.inf:
        highest = 0.5 * (y + later + np.sqrt((later - y) ** 2 - 2.0 * spread * spread * np.log(uniform)))
        later -= max(highest - high, 0.0)
    return min(max(later, low), high) if walled else min(later, high)


@compiled
def _safe(gap, y, x, speed, ageing):  # type: ignore[no-untyped-def]
    """A time within which a threshold y does not come down to a stretch |x| that grows with `speed`."""
    kind, mean, _, _, diffusion = ageing[:5]
    if kind != _PARABOLA:
        return 0.0
    # what is above the mean may come down to it
    gap = min(y, max(mean, 0.0)) - x
    if gap <= 0.0:
        return 0.0
    spread = _FAR * np.sqrt(2.0 * diffusion)
    root = 2.0 * gap / (spread + np.sqrt(spread * spread + 4.0 * speed * gap))
    return root * root


@compiled
def _steepness(x, y, law, a):  # type: ignore[no-untyped-def]
    """How fast the logarithm of the rate changes with the stretch x >= 0, and with the threshold y."""
    if law[0] == SOFT:
        return 2.0 * a * a * x, 2.0 * a * a * y
    steep = 1.5 * a * a * y * np.sqrt(max(1.0 - x / y, 0.0))
    return steep, steep


@compiled
def _felt(time, here, y, speed, law, a, ageing, coarser):  # type: ignore[no-untyped-def]
    """The part of a step in which the breaking rate changes little, or comes to nothing, and little is borne."""
    kind, mean, _, relaxing, diffusion = ageing[:5]
    now = max(rate(here, y, law, a), 1e-300)
    time, change = min(time, coarser**2 * _THERMAL / now), coarser * _CHANGE
    drift = relaxing * abs(mean - y) if kind == _PARABOLA else diffusion * abs(_drift(y, ageing))
    while True:
        of_stretch, of_threshold = _steepness(here + speed * time, y, law, a)
        carried = (of_stretch * speed + of_threshold * drift) * time
        spread = of_threshold * np.sqrt(2.0 * diffusion * time)
        if max(carried, spread) <= change and relaxing * time <= coarser**2 * _FORGOTTEN:
            return time
        if min(now * np.exp(min(carried + 4.0 * spread, 700.0)), law[2]) * time <= coarser**4 * _UNFELT:
            return time
        time *= 0.5


@compiled
def _borne(first, last, time, spread):  # type: ignore[no-untyped-def]
    """Integral of a rate over a step from its ends, of which the logarithm goes straight but for a Brownian bridge."""
    ratio = np.log(last / first) if first > 0.0 and last > 0.0 else 0.0
    mean = (last - first) / ratio if abs(ratio) > 1e-4 else 0.5 * (first + last)
    return mean * time * (1.0 + min(spread * spread, 1.0) / 12.0)


@compiled
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


@compiled
def grow_old(  # type: ignore[no-untyped-def]
    clock, leg, x, threshold, bears, law, a, course, ageing, pace_of_steps, place, stream, watch, counts, seen
):
    """As live, of a contact whose threshold diffuses meanwhile; besides, the steps taken, and the watched moments seen.

    pace_of_steps : the longest step in time near the threshold, and how much coarser others are taken; stream : key,
    second counter word and contact, from the draw `place` on.
    """
    moments = watch[0]
    begins, _, directions, paces = course
    k0, k1, second, contact = stream
    legs, y, steps, diffusion = directions.size, threshold, 0, ageing[4]
    longest, coarser = pace_of_steps
    lower, upper = ageing[10], ageing[11]
    while leg < legs:
        at, d, pace = clock, directions[leg], paces[leg]
        end, stretch = begins[leg + 1], x
        # on a leg the stretch is followed as a number, and rounded where the contact breaks
        passed, room = 0.0, np.float64(end - at)
        while passed < room:
            now = np.float64(stretch) + d * passed
            leaving = d * now >= 0.0
            left = (room - passed) * pace
            if d != 0 and not leaving:
                left = min(left, max(-d * now, 1.0) * pace)
            here, speed = abs(now), (1.0 / pace if d != 0 and leaving else 0.0)
            if seen < moments.size and moments[seen] < end:
                left = min(left, max(np.float64(moments[seen] - at) - passed, 1.0) * pace)
            own = longest
            if ageing[0] != _PARABOLA:
                own = _local(y, here, speed, longest, ageing)
                # what comes to the law's lower end is reflected where the stretch is below, and breaks beyond
                if d != 0 and (here < lower) == leaving and here != lower:
                    left = min(left, max(abs(lower - here), 1.0) * pace)
            time = min(max(own, _safe(y - here, y, here, speed, ageing)), left)
            if law[0]:
                time = _felt(time, min(here, y), y, speed, law, a, ageing, coarser)
                time = min(max(time, 1e-3 * own), left)
            words = philox(_U(place + steps), second, contact & _MASK, contact >> _HALF, k0, k1)
            steps += 1
            ticks = time / pace
            then = abs(np.float64(stretch) + d * (passed + ticks))
            walled, uniform = here + then < 2.0 * lower, (np.float64(words[3]) + 0.5) * 2.0**-32
            reflected = uniform
            if not walled and upper < np.inf:
                more = philox(_U(place + steps), second, contact & _MASK, contact >> _HALF, k0, k1)
                steps += 1
                reflected = (np.float64(more[3]) + 0.5) * 2.0**-32
            later = _moved(y, time, _normal(words[0], words[1], words[2]), reflected, walled, ageing)
            # the stretch is rounded where a leg ends
            above, below = max(y - here, 0.0), later - then
            part, broken = 1.0, below <= 0.0 and not walled
            if not broken and not walled:
                broken = uniform < np.exp(-above * below / (diffusion * time))
            if broken:
                words = philox(_U(place + steps), second, contact & _MASK, contact >> _HALF, k0, k1)
                steps += 1
                uniform = (np.float64(words[3]) + 0.5) * 2.0**-32
                normal = _normal(words[0], words[1], words[2])
                part = _first_meeting(above, below, np.sqrt(2.0 * diffusion * time), normal, uniform)
            if law[0]:
                first, met = rate(min(here, y), y, law, a), here + part * (then - here)
                last = rate(met, met, law, a) if broken else rate(min(then, later), later, law, a)
                spread = _steepness(min(here, y), y, law, a)[1] * np.sqrt(2.0 * diffusion * time * part)
                spent = _borne(first, last, time * part, spread)
                if spent >= bears:
                    part *= bears / spent
                    broken = True
                bears -= spent
            if broken:
                gone = min(np.int64(np.floor(passed + part * ticks + 0.5)), end - at)
                return at + gone, stretch + d * gone, leg, steps, seen
            passed += ticks
            y = later
            while seen < moments.size and np.float64(moments[seen] - at) <= passed + 0.5:
                look(seen, place_of(moments[seen], leg, course) - stretch - d * (moments[seen] - at), y, watch, counts)
                seen += 1
            if room - passed < 0.5:
                break
        x = stretch + d * (end - at)
        leg += 1
        clock = end
    return begins[legs] + 1, x, leg, steps, seen
