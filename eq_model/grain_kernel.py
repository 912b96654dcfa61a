"""A contact whose threshold grows with its age, compiled: each keeps its quantile as a hazard and breaks where that of
its law, at its stretch and age, exceeds it.

Lengths are in units of the lattice, ages count from when the contact pinned, in units of tau_m.
origins/grain_contact.py and lifshitz_slyozov.py are the same in plain numpy.
"""

import numpy as np

from eq_model.compiling import compiled
from eq_model.kernel import philox, uniform_of
from eq_model.thermal_kernel import SOFT, rate

_U = np.uint64
_HALF, _MASK = _U(32), _U(0xFFFFFFFF)
_SMALL = 0.4
_NODES = tuple((0.5 + 0.5 * np.polynomial.legendre.leggauss(10)[0]).tolist())
_WEIGHTS = tuple((0.5 * np.polynomial.legendre.leggauss(10)[1]).tolist())
_STEPS, _MISS = 60, 1e-5  # Halley's step leaves the cube of what is missing
_SPLITS = 200
_RISE, _LITTLE = 3.0, 0.05  # of a bound above the rate, and of what is borne where the bound may be any


@compiled
def _beyond(q, first, free):  # type: ignore[no-untyped-def]
    """psi(y) - psi(first) of Lifshitz and Slyozov's law, q = 1/(1 - y) - 1/(1 - first), free = 1 - first."""
    gap = free * (q * free / (1.0 + q * free))
    if first + gap < _SMALL:
        total = 0.0
        for k in range(len(_NODES)):
            y = first + gap * _NODES[k]
            total += _WEIGHTS[k] * 3.0 * y * y / ((2.0 + y) * (1.0 - y) ** 2)
        return gap * total
    return q - 5.0 / 3.0 * np.log1p(q * free) + 4.0 / 3.0 * np.log1p(gap / (2.0 + first))


@compiled
def hazard(stretch, age, root):  # type: ignore[no-untyped-def]
    """-ln of the fraction of contacts that pinned together and whose thresholds exceed the stretch >= 0 at an age.

    root : B^(1/2), per unit of length.
    """
    s = root * stretch
    over = s * (s / (1.0 + np.hypot(1.0, s)))
    if over == 0.0:
        return 0.0
    excess = np.expm1(np.log1p(age) / 3.0)
    left = excess - over
    if left <= 0.0:
        return np.inf
    largest = 1.0 + excess
    return _beyond(over / excess * (largest / left), 1.0 / largest, excess / largest)


@compiled
def quantile(goal, age, root):  # type: ignore[no-untyped-def]
    """Threshold at an age of the contact whose hazard is `goal`."""
    excess = np.expm1(np.log1p(age) / 3.0)
    if excess <= 0.0 or goal <= 0.0:
        return 0.0
    largest = 1.0 + excess
    first, free = 1.0 / largest, excess / largest
    q = np.cbrt(2.0 * goal) + goal + 5.0 / 3.0 * np.log1p(goal)
    q = min(q, goal * (2.0 + first) / (3.0 * first * first))
    for _ in range(_STEPS):
        left = free / (1.0 + q * free)
        y = first + q * free * left
        step = (_beyond(q, first, free) - goal) * (2.0 + y) / (3.0 * y * y)
        step /= 1.0 - 0.5 * step * left * left * (4.0 + y) / (y * (2.0 + y))
        last, q = q, max(q - step, 0.125 * q)
        if abs(step) <= _MISS * last:
            break
    gap = excess * (q * excess / (largest + q * excess))
    return np.sqrt(gap * (gap + 2.0)) / root


@compiled
def _past(ticks, near, pace, age, goal, root):  # type: ignore[no-untyped-def]
    """Logarithm of the hazard after so many ticks, over what the contact bears."""
    now = hazard(near + ticks, age + ticks * pace, root)
    return min(max(np.log(now / goal), -700.0), 700.0)


@compiled
def _meeting(near, pace, room, age, goal, root):  # type: ignore[no-untyped-def]
    """Ticks after which a contact is stretched to its threshold that it has met after `room`, not yet at 0.

    As a contact is stretched steadily the hazard falls or not, and then rises, so that it passes the goal once.
    Chandrupatla's way between bisection and inverse quadratic interpolation.
    """
    a, b = room, 0.0
    at_a, at_b = _past(a, near, pace, age, goal, root), _past(b, near, pace, age, goal, root)
    c, at_c, share = a, at_a, 0.5
    for _ in range(_SPLITS):
        x = a + share * (b - a)
        at_x = _past(x, near, pace, age, goal, root)
        if (at_x > 0.0) == (at_a > 0.0):
            c, at_c = a, at_a
        else:
            c, b, at_c, at_b = b, a, at_b, at_a
        a, at_a = x, at_x
        width = abs(b - a)
        if width <= 0.25 or at_a == 0.0:
            return a
        xi, phi = (a - b) / (c - b), (at_a - at_b) / (at_c - at_b)
        share = 0.5
        if phi * phi < xi and (1.0 - phi) ** 2 < 1.0 - xi:
            share = at_a / (at_b - at_a) * at_c / (at_b - at_c)
            share += (c - a) / (b - a) * at_a / (at_c - at_a) * at_b / (at_c - at_b)
        least = 0.125 / width
        share = min(max(share, least), 1.0 - least)
    return a


@compiled
def never_holds(goal, clock, leg, course, grains):  # type: ignore[no-untyped-def]
    """Whether a contact that pins at the clock is stretched faster than its threshold grows: (9/2) B (v tau_m)² and
    more of hazard."""
    begins, _, directions, paces = course
    _, first, root, _ = grains
    while leg + 1 < directions.size and clock >= begins[leg + 1]:
        leg += 1
    if directions[leg] == 0:
        return False
    return goal <= 4.5 * (root * first / paces[leg]) ** 2


@compiled
def hold(clock, leg, x, age, goal, course, grains):  # type: ignore[no-untyped-def]
    """The break of a contact that holds at the stretch x (whole) at a moment of the clock, at an age, and keeps the
    hazard `goal`: clock, stretch and leg there; a clock beyond the drive's end where it holds so long."""
    begins, _, directions, paces = course
    _, first, root, _ = grains
    legs = directions.size
    while leg < legs:
        room, d, pace = begins[leg + 1] - clock, directions[leg], paces[leg] / first
        back = room if d == 0 else min(max(-d * x, 0), room)
        age += back * pace
        x += d * back
        clock += back
        room -= back
        if room > 0:
            near = np.float64(d * x)
            if hazard(near + room, age + room * pace, root) >= goal:
                moved = np.int64(0)
                if hazard(near, age, root) < goal:
                    moved = min(np.int64(_meeting(near, pace, np.float64(room), age, goal, root) + 0.5), room)
                return clock + moved, x + d * moved, leg
            age += room * pace
            x += d * room
        leg += 1
        if leg < legs:
            clock = begins[leg]
    return begins[legs] + 1, x, leg


@compiled
def age_at(moment, clock, leg, age, course, grains):  # type: ignore[no-untyped-def]
    """Age at a later moment of the clock."""
    begins, _, _, paces = course
    while leg + 1 < paces.size and begins[leg + 1] <= moment:
        age += (begins[leg + 1] - clock) * (paces[leg] / grains[1])
        leg += 1
        clock = begins[leg]
    return age + (moment - clock) * (paces[leg] / grains[1])


@compiled
def _most(least_x, largest_x, least_y, largest_y, law, a):  # type: ignore[no-untyped-def]
    """A bound of the rate between stretches and between thresholds."""
    if law[0] == SOFT:
        return law[2] * np.exp(min(-a * a * (least_y - largest_x) * (least_y + largest_x), 0.0))
    front = max((largest_y - least_x) / largest_y, 0.0) if largest_y > 0.0 else 1.0
    s = max((least_y - largest_x) / least_y, 0.0) if least_y > 0.0 else 0.0
    return law[2] * np.sqrt(front) * np.exp(-((a * least_y) ** 2) * s * np.sqrt(s))


@compiled
def shaken(clock, leg, x, age, goal, until, bears, law, a, course, grains, place, stream):  # type: ignore[no-untyped-def]
    """The moment at which such a contact breaks at a temperature, and the leg, if before `until`; else a clock beyond
    the drive's end; and the draws it took.

    bears : a draw of the exponential law, of which more are needed. Breaks are proposed at a rate above that of the
    contact, and taken in the share that this has of it: exact, however the steps are cut (Lewis and Shedler, 1979).
    """
    begins, _, directions, paces = course
    _, first, root, _ = grains
    k0, k1, second, contact = stream
    end, draws, step = begins[directions.size], 0, 1.0
    y = quantile(goal, age, root)
    while leg < directions.size and clock < until:
        d, pace = directions[leg], paces[leg] / first
        passed, room = 0.0, np.float64(min(begins[leg + 1], until) - clock)
        while passed < room and pace > 0.0:
            ticks = min(step / pace, room - passed)
            lasts = ticks * pace
            here, there = np.float64(x) + d * passed, np.float64(x) + d * (passed + ticks)
            later = quantile(goal, age + lasts, root)
            least = 0.0 if here * there < 0.0 else min(abs(here), abs(there))
            most = _most(least, max(abs(here), abs(there)), y, later, law, a)
            now = rate(min(abs(here), y), y, law, a) if y > 0.0 else law[2]
            spent = most * lasts * first
            if spent > _LITTLE and most > _RISE * now:
                step = 0.5 * lasts
                continue
            if spent < bears:
                bears -= spent
                passed += ticks
                age += lasts
                y = later
                step = 2.0 * lasts
                continue
            share = bears / spent
            passed += share * ticks
            age += share * lasts
            y = quantile(goal, age, root)
            words = philox(_U(place + draws), second, contact & _MASK, contact >> _HALF, k0, k1)
            draws += 1
            stretch = abs(np.float64(x) + d * passed)
            if uniform_of(words[0], words[1]) * most < rate(min(stretch, y), y, law, a):
                return clock + min(np.int64(passed + 0.5), np.int64(room)), leg, draws
            bears = -np.log(uniform_of(words[2], words[3]))
        x += d * np.int64(room)
        clock += np.int64(room)
        leg += 1
    return end + 1, leg, draws
