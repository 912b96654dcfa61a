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
_FORGOTTEN = 0.5  # of the time in which old thresholds forget


@compiled
def _normal(a, b, c):  # type: ignore[no-untyped-def]
    """A draw of the standard normal law from three words."""
    return np.sqrt(-2.0 * np.log(uniform_of(a, b))) * np.cos(2.0 * np.pi * (np.float64(c) + 0.5) * 2.0**-32)


@compiled
def _drift(y, ageing):  # type: ignore[no-untyped-def]
    """Mean change of a threshold per time, over D."""
    _, _, _, _, _, first, step, values, slopes = ageing
    return hermite(min(max(y, first), first + step * (values.size - 1)), first, step, values, slopes)


@compiled
def _moved(y, time, normal, ageing):  # type: ignore[no-untyped-def]
    """A threshold a time later: in an exact step towards a normal law, else by Heun's, of second order in the mean."""
    kind, mean, width, relaxing, diffusion = ageing[:5]
    if kind == _PARABOLA:
        lost = -np.expm1(-relaxing * time)
        return y + (mean - y) * lost + width * np.sqrt(lost * (2.0 - lost)) * normal
    kick, slope = np.sqrt(2.0 * diffusion * time) * normal, _drift(y, ageing)
    there = _drift(y + diffusion * time * slope + kick, ageing)
    return y + 0.5 * diffusion * time * (slope + there) + kick


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
            time = min(max(longest, _safe(y - here, y, here, speed, ageing)), left)
            if law[0]:
                time = _felt(time, min(here, y), y, speed, law, a, ageing, coarser)
                time = min(max(time, 1e-3 * longest), left)
            words = philox(_U(place + steps), second, contact & _MASK, contact >> _HALF, k0, k1)
            steps += 1
            ticks = time / pace
            then = abs(np.float64(stretch) + d * (passed + ticks))
            later = _moved(y, time, _normal(words[0], words[1], words[2]), ageing)
            # the stretch is rounded where a leg ends
            above, below = max(y - here, 0.0), later - then
            part, broken = 1.0, below <= 0.0
            if not broken:
                broken = (np.float64(words[3]) + 0.5) * 2.0**-32 < np.exp(-above * below / (diffusion * time))
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
