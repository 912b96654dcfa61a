"""The compiled kernel: contacts in lockstep, each a row of breaks summed into bins of the path.

Positions, thresholds and sums are whole numbers (see lattice.py), so every sum is exact and no order of work
shows in the result. A batch of contacts takes four thresholds each per round, in stages that the compiler
turns into vector code: random words, hot cells, values, second moments, and then the sums. Draws that the hot
cells do not hold, and contacts that end, take a slower way one at a time. twin.py is the same in plain numpy.

numba's cache on disk notices changes in a function's own file only: when another kernel's file changes, or a constant
that comes from origins, clear the cache (__pycache__/*.nb?).
"""

import numpy as np

from eq_model.compiling import bits_of, compiled, double_of, inlined, single_of
from eq_model.thermal_kernel import LEVEL_UNIT, MISSING, SOFT, outward, soften, stiffen
from origins.hot_cells import HOT_OCTAVES
from origins.quantile import FINE_BITS
from origins.streams import (
    KEY_STEPS,
    LIFE_TAILS,
    LIVES,
    MULTIPLIERS,
    PURPOSE_SHIFT,
    ROUNDS,
    START,
    START_TAILS,
    THRESHOLD_TAILS,
    THRESHOLDS,
)

LANES = 1024
# rows of the scratch arrays do not share a cache set
ROW = LANES + 24
FAR = 1 << 58  # beyond every path, in units of the lattice

_U = np.uint64
_ONE, _TWO, _HALF, _MASK = _U(1), _U(2), _U(32), _U(0xFFFFFFFF)
_M0, _M1 = (_U(m) for m in MULTIPLIERS)
# rows of the scratch array: four thresholds of each lane, then four second moments
_X0, _X1, _X2, _X3 = (_U(k * ROW) for k in range(4))
_MOMENTS = _U(4 * ROW)
_W0, _W1 = (_U(w) for w in KEY_STEPS)
_LOW31, _TOP, _SIGN = np.uint32(0x7FFFFFFF), np.uint32(31), np.int32(31)
_TAIL, _HALF_WAY = np.uint32(1 << (31 - HOT_OCTAVES)), _U(1 << 31)
_EXPONENT_ONE = np.int64(0x3FF0000000000000)
_FINE_SHIFT = np.int64(52 - FINE_BITS)
_FIRST_OCTAVE = np.int64(1023 + 31 - HOT_OCTAVES)
_THRESHOLDS, _START, _THRESHOLD_TAILS, _START_TAILS, _LIVES, _LIFE_TAILS = (
    _U(purpose << PURPOSE_SHIFT) for purpose in (THRESHOLDS, START, THRESHOLD_TAILS, START_TAILS, LIVES, LIFE_TAILS)
)


@inlined
def philox(c0, c1, c2, c3, k0, k1):  # type: ignore[no-untyped-def]
    """Philox4x32-10 of one counter; all words as uint64."""
    for _ in range(ROUNDS):
        p0, p1 = _M0 * c0, _M1 * c2
        c0, c1, c2, c3 = (p1 >> _HALF) ^ c1 ^ k0, p1 & _MASK, (p0 >> _HALF) ^ c3 ^ k1, p0 & _MASK
        k0, k1 = (k0 + _W0) & _MASK, (k1 + _W1) & _MASK
    return c0, c1, c2, c3


@compiled
def uniform_of(high, low):  # type: ignore[no-untyped-def]
    """Between 0 and 1, neither itself, from two words."""
    return (np.float64(((high << _HALF) | low) >> _U(11)) + 0.5) * 2.0**-53


@compiled
def _draw(n, block, second, contact, k0, k1, words):  # type: ignore[no-untyped-def]
    """Four words for each of n lanes, in rows of ROW."""
    for i in range(n):
        a, b, c, d = philox(_U(block[i]), second[i], contact[i] & _MASK, contact[i] >> _HALF, k0, k1)
        words[i] = a
        words[i + ROW] = b
        words[i + 2 * ROW] = c
        words[i + 3 * ROW] = d


@compiled
def _count(n, row, words, pieces, count, base):  # type: ignore[no-untyped-def]
    """Where a row of n words lies in pieces: the distance from the piece's end in 2^-32, and its first place.

    pieces : MOST_PIECES rows: one less than a piece's first whole number, the end it is counted from, its first place.
    """
    start = _U(row * ROW)
    b1, b2, b3, b4, b5 = pieces[1, 0], pieces[2, 0], pieces[3, 0], pieces[4, 0], pieces[5, 0]
    e0, e1, e2, e3, e4, e5 = pieces[0, 1], pieces[1, 1], pieces[2, 1], pieces[3, 1], pieces[4, 1], pieces[5, 1]
    p1, p2, p3, p4, p5 = pieces[1, 2], pieces[2, 2], pieces[3, 2], pieces[4, 2], pieces[5, 2]
    for i in range(_U(n)):
        word = words[i + start]
        m = np.uint32(word ^ (np.uint32(np.int32(word) >> _SIGN) & _LOW31))  # in the order of u
        end, first = e0, np.uint32(0)
        if m > b1:
            end, first = e1, p1
        if m > b2:
            end, first = e2, p2
        if m > b3:
            end, first = e3, p3
        if m > b4:
            end, first = e4, p4
        if m > b5:
            end, first = e5, p5
        # below its end a distance is the complement
        apart = np.int32(m - end)
        count[i] = np.uint32(apart ^ (apart >> _SIGN))
        base[i] = first


@compiled
def _find(n, row, words, shift, hot, pieces, count, base, cell, place, got):  # type: ignore[no-untyped-def]
    """The hot cells of a row of n words, side by side, and the place of each word in its cell.

    The top bit of a word is the side, the rest counts v in 2^-32; two pieces are the two sides.
    """
    least = _FIRST_OCTAVE << (np.int64(52) - shift)
    fraction = (np.int64(1) << shift) - np.int64(1)
    start, stride = _U(row * ROW), np.int64(pieces[1, 2])
    if pieces.shape[0] == 2:
        for i in range(_U(n)):
            word = words[i + start]
            bits = bits_of(np.float64(np.int32(word & _LOW31)) + 0.5)
            k = max((bits >> shift) - least, np.int64(-1)) + 1
            cell[i] = np.uint32(k + (np.int64(np.int32(word) >> _SIGN) & stride))
            place[i] = double_of((bits & fraction) | _EXPONENT_ONE) - 1.0
    else:
        _count(n, row, words, pieces, count, base)
        for i in range(_U(n)):
            bits = bits_of(np.float64(np.int32(count[i])) + 0.5)
            k = max((bits >> shift) - least, np.int64(-1)) + 1
            cell[i] = np.uint32(k + np.int64(base[i]))
            place[i] = double_of((bits & fraction) | _EXPONENT_ONE) - 1.0
    # sixteen bytes copied at a time are faster than what a vector unit gathers
    for i in range(_U(n)):
        k, j = _U(cell[i]) << _ONE, i << _ONE
        first, slopes = hot[k], hot[k + _ONE]
        got[j] = first
        got[j + _ONE] = slopes


@compiled
def _values(n, got, place, factor, start, values):  # type: ignore[no-untyped-def]
    """Values of n hot cells, in whole numbers of the lattice's unit, from values[start] on."""
    for i in range(_U(n)):
        j, t = i << _ONE, place[i]
        slopes = got[j + _ONE]
        c1, c2 = np.float64(single_of(np.int32(slopes))), np.float64(single_of(np.int32(slopes >> 32)))
        values[i + start] = np.int64(np.floor((double_of(got[j]) + t * (c1 + t * c2)) * factor + 0.5))


@inlined
def _moment(x, c, low, square):  # type: ignore[no-untyped-def]
    """(b - r)^2 - (b - x - r)^2 in units of 1 / square, r the last position of the cell in which c = b + offset is."""
    return np.int64(np.rint(np.float64(x) * np.float64(2 * ((c & low) - low) - x) * square))


@compiled
def _advance(n, position, offset, shift, top, work, bins):  # type: ignore[no-untyped-def]
    """Move n lanes on by four thresholds each; twice the lattice cells of the breaks, at most `top`."""
    for i in range(_U(n)):
        c = position[i] + offset + work[i + _X0]
        bins[i + _X0] = np.int32(min(c >> shift, top) << 1)
        c += work[i + _X1]
        bins[i + _X1] = np.int32(min(c >> shift, top) << 1)
        c += work[i + _X2]
        bins[i + _X2] = np.int32(min(c >> shift, top) << 1)
        c += work[i + _X3]
        bins[i + _X3] = np.int32(min(c >> shift, top) << 1)
        position[i] = c - offset


@compiled
def _measure(n, position, offset, shift, square, work):  # type: ignore[no-untyped-def]
    """Second moments of the four breaks of n lanes, from where these have moved to."""
    low = (np.int64(1) << shift) - np.int64(1)
    for i in range(_U(n)):
        c, x = position[i] + offset, work[i + _X3]
        work[i + _MOMENTS + _X3] = _moment(x, c, low, square)
        c, x = c - x, work[i + _X2]
        work[i + _MOMENTS + _X2] = _moment(x, c, low, square)
        c, x = c - x, work[i + _X1]
        work[i + _MOMENTS + _X1] = _moment(x, c, low, square)
        c, x = c - x, work[i + _X0]
        work[i + _MOMENTS + _X0] = _moment(x, c, low, square)


@compiled
def _bin(b, lattice):  # type: ignore[no-untyped-def]
    """Bin of a break at b, not beyond the end."""
    offset, shift, _, _, _, bound, crowds, points = lattice
    g = (b + offset) >> shift
    if bound.size == 0:
        return g
    limit = bound[g]
    if limit >= 0:
        return 2 * g + np.int64(b > limit)
    # several path points in this cell
    row = -1 - limit
    low, high = crowds[row, 1], crowds[row, 2]
    base = crowds[row, 0] - low
    while low < high:
        middle = (low + high) >> 1
        if points[middle] < b:
            low = middle + 1
        else:
            high = middle
    return base + low


@compiled
def _bin_all(n, position, work, lattice, bins):  # type: ignore[no-untyped-def]
    """Twice the bins of the four breaks of n lanes, where cells are not bins: path points are anywhere in them."""
    end, top = lattice[2], lattice[3]
    for i in range(n):
        b = position[i]
        for k in range(3, -1, -1):
            bins[i + k * ROW] = 2 * (_bin(b, lattice) if b <= end else top)
            b -= work[i + k * ROW]


@compiled
def spread(births, expected, square):  # type: ignore[no-untyped-def]
    """Sum of the starting positions, and of their squared distances from `expected` in units of 1 / square."""
    total, squares = np.int64(0), np.int64(0)
    for i in range(births.size):
        apart = np.float64(births[i] - expected)
        total += births[i]
        squares += np.int64(np.rint(apart * apart * square))
    return total, squares


@compiled
def _collect(n, work, rows, bins, sums, column):  # type: ignore[no-untyped-def]
    """Sum four rows of n lanes, from work[rows] on, into a column of their bins."""
    for i in range(_U(n)):
        sums[_U(bins[i + _X0]) + column] += work[i + rows + _X0]
        sums[_U(bins[i + _X1]) + column] += work[i + rows + _X1]
        sums[_U(bins[i + _X2]) + column] += work[i + rows + _X2]
        sums[_U(bins[i + _X3]) + column] += work[i + rows + _X3]


@compiled
def _add(x, b, lattice, sums):  # type: ignore[no-untyped-def]
    """Sum one break into its bin."""
    low = (np.int64(1) << lattice[1]) - np.int64(1)
    h = 2 * _bin(b, lattice)
    sums[h] += x
    sums[h + 1] += _moment(x, b + lattice[0], low, lattice[4])


@compiled
def _more(word, k, block, second, contact, k0, k1):  # type: ignore[no-untyped-def]
    """The word that continues draw k of a block in the tails, v < 2^-12; elsewhere 32 bits are fine enough."""
    if word & _LOW31 >= _TAIL:
        return _HALF_WAY
    a, b, c, d = philox(_U(block), second, contact & _MASK, contact >> _HALF, k0, k1)
    if k == 0:
        return a
    if k == 1:
        return b
    return c if k == 2 else d


@compiled
def _exact(word, more, factor, sides, first, edges, cubics):  # type: ignore[no-untyped-def]
    """Whole value, from the fine cells, of a draw of 64 bits.

    sides : for each side the place in `first` of its cells, how many, the bits of the lowest, and its last fine cell.
    first : the fine cell with which each eighth of an octave begins, both sides in a row, as edges and cubics are.
    """
    v = (np.float64(((_U(word) & _U(_LOW31)) << _HALF) | more) + 0.5) * 2.0**-64
    return value_at(v, np.int64(word >> _TOP), factor, sides, first, edges, cubics)


@compiled
def value_at(v, side, factor, sides, first, edges, cubics):  # type: ignore[no-untyped-def]
    """Whole value of the fine cells at a probability v, counted from one side (1: from above)."""
    place = min(max((bits_of(v) >> _FINE_SHIFT) - sides[side, 2], np.int64(0)), sides[side, 1] - 1)
    k = first[sides[side, 0] + place]
    while k < sides[side, 3] and v >= edges[k + 1]:
        k += 1
    t = (v - edges[k]) / (edges[k + 1] - edges[k])
    y = cubics[k, 0] + t * (cubics[k, 1] + t * (cubics[k, 2] + t * cubics[k, 3]))
    return np.int64(min(np.floor(min(max(y, cubics[k, 4]), cubics[k, 5]) * factor + 0.5), np.float64(FAR)))


@compiled
def begin(first, n_contacts, key, table, start_table, single, births, thresholds):  # type: ignore[no-untyped-def]
    """Where contacts first, first + 1, ... begin.

    births : filled with the negative starting stretches, from start_table unless `single`; thresholds : with one draw
    each of P_c, -1 where it does not exceed the starting stretch and must be drawn again, knowing that.
    """
    (k0, k1), many = key, _U(n_contacts)
    hot, hot_shift, pieces, factor, sides, fine, edges, cubics = table
    n = births.size
    second, contact, block = np.empty(LANES, _U), np.empty(LANES, _U), np.zeros(LANES, np.uint32)
    words = np.empty(4 * ROW, np.uint32)
    cell, place, got = np.empty(LANES, np.uint32), np.empty(LANES), np.empty(2 * LANES, np.int64)
    count, base = np.empty(LANES, np.uint32), np.empty(LANES, np.uint32)
    for done in range(0, n, LANES):
        m = min(LANES, n - done)
        for i in range(m):
            index = _U(first + done + i)
            replica = index // many
            second[i], contact[i] = _START | replica, index - replica * many
        _draw(m, block, second, contact, k0, k1, words)
        if not single:
            _find(m, 0, words, start_table[1], start_table[0], start_table[2], count, base, cell, place, got)
            _values(m, got, place, start_table[3], _U(done), births)
        _find(m, 1, words, hot_shift, hot, pieces, count, base, cell, place, got)
        _values(m, got, place, factor, _U(done), thresholds)
        for i in range(m):
            j, tail = done + i, second[i] ^ _START ^ _START_TAILS
            if not single:
                if births[j] >= MISSING:
                    more = _more(words[i], 0, 0, tail, contact[i], k0, k1)
                    births[j] = _exact(
                        words[i], more, start_table[3], start_table[4], start_table[5], start_table[6], start_table[7]
                    )
                births[j] = -births[j]
            if thresholds[j] >= MISSING:
                more = _more(words[i + ROW], 1, 0, tail, contact[i], k0, k1)
                thresholds[j] = _exact(words[i + ROW], more, factor, sides, fine, edges, cubics)
            if thresholds[j] <= abs(births[j]):
                thresholds[j] = -1


@compiled
def _own_break(threshold, word, k, block, second, contact, key, thermal):  # type: ignore[no-untyped-def]
    """Where a contact of a threshold breaks, that bears what draw k of a block says."""
    _, _, a, _, (_, _, _, factor, sides, fine, edges, cubics), law, tables, log_speed = thermal
    more = _more(word, k, block, second ^ _THRESHOLDS ^ _LIFE_TAILS, contact, key[0], key[1])
    level = np.float64(_exact(word, more, factor, sides, fine, edges, cubics)) * LEVEL_UNIT
    return np.int64(np.floor(outward(level + log_speed, 0.0, np.float64(threshold), law, a, tables) + 0.5))


@compiled
def _finish(n, words, levels, work, position, block, second, contact, key, table, thermal, lattice, sums, free):  # type: ignore[no-untyped-def]
    """What _collect() leaves: draws that the hot cells do not hold, and contacts that end.

    Lanes whose contact is done are listed in free. Returns their number and that of all breaks of n lanes.
    """
    end, (k0, k1) = lattice[2], key
    _, _, _, factor, sides, fine, edges, cubics = table
    n_free, breaks = 0, 4 * n
    for j in range(n):
        if position[j] <= end:
            continue
        i = _U(j)
        b = position[i] - work[i + _X0] - work[i + _X1] - work[i + _X2] - work[i + _X3]
        collected, k = True, 0
        while k < 4:
            x = work[i + _U(k * ROW)]
            # from the first position beyond the end on, breaks are in no bin yet
            collected = collected and b + x <= end
            if x >= MISSING:
                tail = second[i] ^ _THRESHOLDS ^ _THRESHOLD_TAILS
                word = words[i + _U(k * ROW)]
                more = _more(word, k, block[i], tail, contact[i], k0, k1)
                x = _exact(word, more, factor, sides, fine, edges, cubics)
                if thermal[0]:
                    x = _own_break(x, levels[i + _U(k * ROW)], k, block[i], second[i], contact[i], key, thermal)
            b += x
            if b > end:
                break
            if not collected:
                _add(x, b, lattice, sums)
            k += 1
        breaks += k - 4
        position[i] = b
        if b > end:
            free[n_free] = j
            n_free += 1
    return n_free, breaks


@compiled
def _refill(n_free, free, taken, n, first, many, births, thresholds, position, block, second, contact, lattice, sums):  # type: ignore[no-untyped-def]
    """Give free lanes the next contacts; a contact that never breaks again leaves its lane at once.

    Returns the number of lanes filled, of contacts taken so far, and of breaks.
    """
    end, begun = lattice[2], births.size > 0
    filled, breaks = 0, 0
    while filled < n_free and taken < n:
        i, index, b = free[filled], _U(first + taken), np.int64(0)
        if begun:
            b = births[taken] + thresholds[taken]
            if b <= end:
                _add(thresholds[taken], b, lattice, sums)
                breaks += 1
        taken += 1
        if b <= end:
            replica = index // many
            second[i], contact[i] = _THRESHOLDS | replica, index - replica * many
            position[i], block[i] = b, 0
            filled += 1
    return filled, taken, breaks


@compiled
def run(first, n, n_contacts, key, table, thermal, births, thresholds, lattice, measured, sums):  # type: ignore[no-untyped-def]
    """Follow contacts first ... first + n - 1 to the path's end; the number of breaks on the way.

    thermal : kind, constant, a, cells as of thermal_kernel.soften, the table of what contacts bear, law, tables and
    ln(v); of kind 0 all break at their thresholds.
    births, thresholds : the contacts' starting positions and first thresholds; empty where all start relaxed at 0.
    lattice : (offset, shift, end, top, square, bound, crowds, points); sums : shape (2 (top + 1),), increased by
    the thresholds that broke in each bin and by their second moments, in turn; the last bin holds no sense, nor do the
    moments unless `measured`.
    """
    offset, shift, end, top, square = lattice[:5]
    hot, hot_shift, pieces, factor = table[:4]
    (k0, k1), many, aligned = key, _U(n_contacts), lattice[5].size == 0
    second, contact, block = np.empty(LANES, _U), np.empty(LANES, _U), np.zeros(LANES, np.uint32)
    position, free = np.empty(LANES, np.int64), np.arange(LANES)
    words, bins = np.empty(4 * ROW, np.uint32), np.empty(4 * ROW, np.int32)
    cell, place, got = np.empty(LANES, np.uint32), np.empty(LANES), np.empty(2 * LANES, np.int64)
    count, base = np.empty(LANES, np.uint32), np.empty(LANES, np.uint32)
    work = np.empty(8 * ROW, np.int64)
    bearing, levels, level = np.empty(LANES, _U), np.empty(4 * ROW, np.uint32), np.empty(LANES, np.int64)
    breaks, taken, lanes, n_free = 0, 0, LANES, LANES
    while True:
        filled, taken, done = _refill(
            n_free, free, taken, n, first, many, births, thresholds, position, block, second, contact, lattice, sums
        )
        breaks += done
        if filled < n_free:
            # nothing is left to take: the lanes close up
            for k in range(filled, n_free):
                position[free[k]] = FAR
            kept = 0
            for i in range(lanes):
                if position[i] <= end:
                    position[kept], block[kept] = position[i], block[i]
                    second[kept], contact[kept] = second[i], contact[i]
                    kept += 1
            lanes = kept
        if lanes == 0:
            return breaks
        _draw(lanes, block, second, contact, k0, k1, words)
        if thermal[0]:
            for i in range(lanes):
                bearing[i] = second[i] ^ _THRESHOLDS ^ _LIVES
            _draw(lanes, block, bearing, contact, k0, k1, levels)
        for k in range(4):
            _find(lanes, k, words, hot_shift, hot, pieces, count, base, cell, place, got)
            _values(lanes, got, place, factor, _U(k * ROW), work)
            if thermal[0]:
                kind, constant, a, cells, bears = thermal[:5]
                _find(lanes, k, levels, bears[1], bears[0], bears[2], count, base, cell, place, got)
                _values(lanes, got, place, bears[3], _U(0), level)
                if kind == SOFT:
                    soften(lanes, _U(k * ROW), work, level, constant, a, cells)
                else:
                    stiffen(lanes, _U(k * ROW), work, level, constant, a)
        _advance(lanes, position, offset, shift, top if aligned else np.int64(0), work, bins)
        if not aligned:
            _bin_all(lanes, position, work, lattice, bins)
        _collect(lanes, work, _X0, bins, sums, _X0)
        if measured:
            _measure(lanes, position, offset, shift, square, work)
            _collect(lanes, work, _MOMENTS, bins, sums, _ONE)
        n_free, done = _finish(
            lanes, words, levels, work, position, block, second, contact, key, table, thermal, lattice, sums, free
        )
        breaks += done
        for i in range(lanes):
            block[i] += np.uint32(1)
