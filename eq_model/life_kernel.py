"""The compiled kernel for contacts with laws of their own, on any path in time: each followed from break to break.

A contact's life is sampled without a time step: its threshold is drawn, and how much of its breaking rate it can bear,
and where either is reached follows in closed form on every leg of the drive. What it does to the sums is two events, a
birth and a break, each of which counts in the bin of the clock in which it falls. Positions and sums are whole numbers
(see lattice.py, course.py), so no order of work shows in the result. life_twin.py
is the same in plain Python.

Lengths are in units of the lattice; thermal laws are those of thermal_kernel.py.
"""

import numpy as np

from eq_model.ageing_kernel import grow_old
from eq_model.compiling import compiled
from eq_model.course_kernel import later, look, place_of
from eq_model.grain_kernel import age_at, hazard, hold, never_holds, quantile, shaken
from eq_model.kernel import LANES, ROW, _draw, _exact, _find, _more, _values, philox, value_at
from eq_model.kernel import _bin as _find_bin
from eq_model.thermal_kernel import MISSING, between, inward, outward, rate
from origins.quantile import DEEPEST
from origins.streams import LIFE_STEPS, LIFE_TAILS, LIVES, PURPOSE_SHIFT

_U = np.uint64
_HALF, _MASK = _U(32), _U(0xFFFFFFFF)
_LIVES, _LIFE_TAILS, _LIFE_STEPS = (_U(purpose << PURPOSE_SHIFT) for purpose in (LIVES, LIFE_TAILS, LIFE_STEPS))
_LOW = np.uint32(0x7FFFFFFF)
STIFFNESS_UNIT = 2.0**36
USUAL = float(np.log2(DEEPEST))  # log2 of the probability beyond which tables end, but for deep ones


@compiled
def live(clock, leg, x, threshold, bears, law, a, tables, course, tie=0):  # type: ignore[no-untyped-def]
    """The break of a contact that holds at the stretch x (whole) at a moment of the clock, and can bear the integral
    of its rate up to `bears`: clock, stretch and leg there; a clock beyond the drive's end where it holds so long.

    tie : what a threshold may be away by rounding that is met where the slider turns or stops.
    """
    begins, _, directions, paces = course
    legs = directions.size
    while leg < legs:
        room, d, pace = begins[leg + 1] - clock, directions[leg], paces[leg]
        if d == 0:
            if law[0]:
                hazard = rate(float(abs(x)), threshold, law, a) * pace
                if hazard * room >= bears:
                    return clock + min(np.int64(bears / hazard), room), x, leg
                bears -= hazard * room
        else:
            if d * x < 0:
                back = min(abs(x), room)
                if law[0]:
                    far = float(abs(x))
                    spent = between(far - back, far, threshold, law, a, tables) * pace
                    if spent >= bears:
                        near = inward(bears / pace, far, threshold, law, a, tables)
                        moved = min(np.int64(far - near), back)
                        return clock + moved, x + d * moved, leg
                    bears -= spent
                x += d * back
                clock += back
                room -= back
            if room > 0:
                near, own = d * x, threshold
                if law[0]:
                    own = outward(np.log(bears / pace), float(near), threshold, law, a, tables)
                moved = max(np.int64(np.floor(own + 0.5)) - near, 0)
                if moved > room and moved - room <= tie and leg + 1 < legs and directions[leg + 1] != d:
                    moved = room
                if moved <= room:
                    return clock + moved, x + d * moved, leg
                if law[0] and leg + 1 < legs:
                    far = min(float(near + room), threshold)
                    bears -= between(float(near), far, threshold, law, a, tables) * pace
                    bears = max(bears, 0.0)
                x += d * room
        leg += 1
        if leg < legs:
            clock = begins[leg]
    return begins[legs] + 1, x, leg


@compiled
def first_breaks(first, n_contacts, key, births, thresholds, law, tables, pace):  # type: ignore[no-untyped-def]
    """Stretches (whole) at which contacts first, first + 1, ... break for the first time in steady forward motion.

    births : negative starting stretches; thresholds : of each contact, which the stretches replace.
    """
    (k0, k1), many = key, _U(n_contacts)
    for j in range(births.size):
        index = _U(first + j)
        replica = index // many
        contact, second = index - replica * many, _LIFE_STEPS | replica
        words = philox(_U(0), second, contact & _MASK, contact >> _HALF, k0, k1)
        bears = _bearing(np.uint32(words[0]), words[1])
        x, limit = np.float64(-births[j]), np.float64(thresholds[j])
        if x < 0.0:
            spent = between(0.0, -x, limit, law, law[1], tables) * pace
            if spent >= bears:
                thresholds[j] = -np.int64(np.floor(inward(bears / pace, -x, limit, law, law[1], tables) + 0.5))
                continue
            bears -= spent
        own = outward(np.log(bears / pace), max(x, 0.0), limit, law, law[1], tables)
        thresholds[j] = np.int64(np.floor(own + 0.5))


@compiled
def _event(sign, stiff, stiffness, birth, stretch, clock, lattice, reference, sums):  # type: ignore[no-untyped-def]
    """Count a birth (sign 1) or a break (-1) at the clock and a stretch, of a contact relaxed where the slider is at
    `birth`."""
    row, columns = _find_bin(clock, lattice), 8 if stiff else 5
    back, square, k = birth - reference[row], lattice[4], (row + 1) * columns - 2
    if sign < 0:
        force = stiffness * float(stretch)
        sums[k] += 1
        sums[k + 1] += np.int64(np.rint(force * force * square))
    k = row * columns
    sums[k] += sign
    if not stiff:
        sums[k + 1] += sign * back
        sums[k + 2] += sign * np.int64(np.rint(float(back) * float(back) * square))
        return
    own, exact = stiffness, float(back)
    unit = STIFFNESS_UNIT
    sums[k + 1] += sign * np.int64(np.rint(own * unit))
    sums[k + 2] += sign * np.int64(np.rint(own * exact))
    sums[k + 3] += sign * np.int64(np.rint(own * own * unit))
    sums[k + 4] += sign * np.int64(np.rint(own * own * exact))
    sums[k + 5] += sign * np.int64(np.rint(own * own * exact * exact * square))


@compiled
def _bearing(word, more):  # type: ignore[no-untyped-def]
    """A draw of the exponential law of mean 1 from 64 bits; the top bit is the side, the rest counts from its end."""
    v = (np.float64(((_U(word) & _U(_LOW)) << _HALF) | more) + 0.5) * 2.0**-64
    return -np.log(v) if word >> np.uint32(31) else -np.log1p(-v)


@compiled
def _tail(stretch, table, lowest):  # type: ignore[no-untyped-def]
    """The probability of a threshold beyond a stretch, by the quantile, bisected; or that of one below, negative, where
    that is the smaller.

    lowest : log2 of the probability beyond which the table ends.
    """
    _, _, _, factor, sides, fine, edges, cubics = table
    deep = lowest < USUAL
    above = _fine(0.5, 1, deep, factor, sides, fine, edges, cubics) <= stretch
    low, high = lowest, -1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        value = _fine(2.0**middle, 1 if above else 0, deep, factor, sides, fine, edges, cubics)
        if (value > stretch) == above:
            low = middle
        else:
            high = middle
    v = 2.0 ** (0.5 * (low + high))
    return v if above else -v


@compiled
def _beyond(stretch, tail, word, more, table, lowest):  # type: ignore[no-untyped-def]
    """A threshold beyond a stretch of that `tail`, with a uniform number of 64 bits."""
    _, _, _, factor, sides, fine, edges, cubics = table
    w, deep = (np.float64((_U(word) << _HALF) | more) + 0.5) * 2.0**-64, lowest < USUAL
    left = (tail if tail > 0.0 else 1.0 + tail) * w
    if left <= 0.5:
        found = _fine(left, 1, deep, factor, sides, fine, edges, cubics)
    else:
        found = _fine(1.0 - left, 0, deep, factor, sides, fine, edges, cubics)
    return max(found, stretch + 1)


@compiled
def _fine(v, side, deep, factor, sides, first, edges, cubics):  # type: ignore[no-untyped-def]
    """Whole value of the fine cells at v of a side; `deep` where v may need more than the 64 bits of a draw."""
    if deep:
        return value_at(v, side, factor, sides, first, edges, cubics)
    number = np.int64(np.floor(v * 2.0**64)) if v < 0.5 else np.int64(0x7FFFFFFFFFFFFFFF)
    word = np.uint32(number >> 32) | np.uint32(side << 31)
    return _exact(word, _U(number & 0xFFFFFFFF), factor, sides, first, edges, cubics)


@compiled
def run(  # type: ignore[no-untyped-def]
    first,
    n,
    many,
    key,
    table,
    again,
    tail_table,
    births,
    thresholds,
    physics,
    course,
    lattice,
    reference,
    watch,
    sums,
    counts,
):
    """Follow contacts first ... first + n - 1 to the drive's end; the numbers of breaks and of inner steps.

    many : contacts in each replica; again : table of the stretches of re-forming; tail_table : a table of the
    thresholds for contacts that form again far out, log2 of where it ends, and the stretch from which on it is needed;
    births, thresholds : negative starting stretches and first thresholds; physics : of lives.physics, whether stretches
    of re-forming are drawn, the one there is else, and the tie of `live`. watch : moments at which contacts are
    counted, in order, the slider's places then, bins per unit of stretches and of thresholds, and where stretches of
    re-forming are drawn again. sums : shape (columns * bins,), increased by the events of each bin;
    counts : shape (moments, 2, bins), by the contacts that hold then, by stretch of either sign and by threshold.
    """
    law, tables, delay, stiff, mean, ageing, longest, grains, reform, single, tie = physics
    hot, hot_shift, pieces, factor, sides, fine, edges, cubics = table
    deep, lowest, from_here = tail_table
    (k0, k1), many, end = key, _U(many), lattice[2]
    # draws are counted in 64 bits: a contact may break, and age, more than 2^32 times
    second, contact, block = np.empty(LANES, _U), np.empty(LANES, _U), np.zeros(LANES, np.int64)
    clock, legs = np.empty(LANES, np.int64), np.zeros(LANES, np.int64)
    words = np.empty(4 * ROW, np.uint32)
    cell, place, got = np.empty(LANES, np.uint32), np.empty(LANES), np.empty(2 * LANES, np.int64)
    count, base = np.empty(LANES, np.uint32), np.empty(LANES, np.uint32)
    limit, start = np.empty(LANES, np.int64), np.empty(LANES, np.int64)
    drawn, ahead, moments = np.zeros(LANES, np.int64), np.zeros(LANES, np.int64), watch[0]
    known, share = np.int64(-1), 0.0  # the last stretch whose tail was wanted: often it is that of all
    breaks, steps, taken, lanes = 0, 0, 0, 0
    while True:
        # lanes whose contact is done are at the end: give them the next ones
        kept = lanes
        while lanes < LANES and taken < n:
            index = _U(first + taken)
            replica = index // many
            second[lanes], contact[lanes] = _LIVES | replica, index - replica * many
            block[lanes], clock[lanes], legs[lanes], drawn[lanes], ahead[lanes] = 0, 0, 0, 0, 0
            start[lanes], limit[lanes] = -births[taken], thresholds[taken]
            lanes += 1
            taken += 1
        if lanes == 0:
            return breaks, steps
        _draw(lanes, block, second, contact, k0, k1, words)
        if kept:
            _find(kept, 0, words, hot_shift, hot, pieces, count, base, cell, place, got)
            _values(kept, got, place, factor, _U(0), limit)
            if reform:
                _find(kept, 2, words, again[1], again[0], again[2], count, base, cell, place, got)
                _values(kept, got, place, again[3], _U(0), start)
        left = 0
        for i in range(lanes):
            tail = second[i] ^ _LIVES ^ _LIFE_TAILS
            born, threshold, leg = start[i], limit[i], legs[i]
            fresh = block[i] > 0
            if fresh:
                if threshold >= MISSING:
                    more = _more(words[i], 0, block[i], tail, contact[i], k0, k1)
                    threshold = _exact(words[i], more, factor, sides, fine, edges, cubics)
                if reform and born >= MISSING:
                    more = _more(words[i + 2 * ROW], 2, block[i], tail, contact[i], k0, k1)
                    born = _exact(words[i + 2 * ROW], more, again[3], again[4], again[5], again[6], again[7])
                if not reform:
                    born = single
                attempt = _U(0)
                while abs(born) >= watch[3]:
                    # no contact holds there: drawn again, at the same place of the stream but for the attempt
                    attempt += _U(1)
                    high = (contact[i] >> _HALF) | (attempt << _U(16))
                    a0, a1, _, _ = philox(_U(block[i]), tail, contact[i] & _MASK, high, k0, k1)
                    born = _exact(np.uint32(a0), a1, again[3], again[4], again[5], again[6], again[7])
                if threshold <= abs(born):
                    more = philox(_U(block[i]), tail, contact[i] & _MASK, contact[i] >> _HALF, k0, k1)[3]
                    far = abs(born) >= from_here
                    if abs(born) != known:
                        known = abs(born)
                        share = _tail(known, deep, lowest) if far else _tail(known, table, USUAL)
                    if far:
                        threshold = _beyond(known, share, words[i + 3 * ROW], more, deep, lowest)
                    else:
                        threshold = _beyond(known, share, words[i + 3 * ROW], more, table, USUAL)
            goal, age = 0.0, 0.0
            if grains[0]:
                if fresh:
                    goal = _bearing(words[i], _more(words[i], 0, block[i], tail, contact[i], k0, k1))
                    if never_holds(goal, clock[i], leg, course, grains):
                        clock[left], legs[left] = later(clock[i], leg, delay, course)
                        if clock[left] <= end:
                            second[left], contact[left], block[left] = second[i], contact[i], block[i] + 1
                            drawn[left], ahead[left] = drawn[i], ahead[i]
                            left += 1
                        continue
                else:
                    age = grains[3]
                    goal = hazard(np.float64(threshold), age, grains[2])
            stiffness = threshold / mean if stiff else 1.0
            birth = place_of(clock[i], leg, course) - born
            _event(1, stiff, stiffness, birth, born, clock[i], lattice, reference, sums)
            bears, a = 0.0, law[1]
            if law[0]:
                more = _more(words[i + ROW], 1, block[i], tail, contact[i], k0, k1)
                bears = _bearing(words[i + ROW], more)
                if stiff:
                    a *= np.sqrt(stiffness)
            if ageing[0]:
                stream = k0, k1, second[i] ^ _LIVES ^ _LIFE_STEPS, contact[i]
                seen = ahead[i]
                while seen < moments.size and moments[seen] < clock[i]:
                    seen += 1
                then, _, leg, done, seen = grow_old(
                    clock[i],
                    leg,
                    born,
                    float(threshold),
                    bears,
                    law,
                    a,
                    course,
                    ageing,
                    longest,
                    drawn[i],
                    stream,
                    watch,
                    counts,
                    seen,
                )
                ahead[i] = seen
                drawn[i] += done
                steps += done
            else:
                begun = leg
                if grains[0]:
                    then, _, leg = hold(clock[i], leg, born, age, goal, course, grains)
                    if law[0]:
                        stream = k0, k1, second[i] ^ _LIVES ^ _LIFE_STEPS, contact[i]
                        until = min(then, course[0][-1])
                        sooner, other, done = shaken(
                            clock[i], begun, born, age, goal, until, bears, law, a, course, grains, drawn[i], stream
                        )
                        drawn[i] += done
                        if sooner <= until:
                            then, leg = sooner, other
                else:
                    then, _, leg = live(clock[i], leg, born, float(threshold), bears, law, a, tables, course, tie)
                while ahead[i] < moments.size and moments[ahead[i]] < then:
                    if moments[ahead[i]] >= clock[i]:
                        own = np.float64(threshold)
                        if grains[0]:
                            older = age_at(moments[ahead[i]], clock[i], begun, age, course, grains)
                            own = quantile(goal, older, grains[2])
                        look(ahead[i], birth, own, watch, counts)
                    ahead[i] += 1
            if then > end:
                continue
            x = place_of(then, leg, course) - birth
            _event(-1, stiff, stiffness, birth, x, then, lattice, reference, sums)
            breaks += 1
            if delay > 0.0:
                then, leg = later(then, leg, delay, course)
                if then > end:
                    continue
            second[left], contact[left], block[left] = second[i], contact[i], block[i] + 1
            drawn[left], ahead[left] = drawn[i], ahead[i]
            clock[left], legs[left] = then, leg
            left += 1
        lanes = left
