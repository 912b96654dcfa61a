"""Thermal breaking of one contact, compiled: its rate, the integral of that and the inverse, and many draws at once.

Lengths are in units of the lattice. A law is (kind, a, rate): kind 0 breaks at its threshold only, 1 is soft, 2 stiff;
a² = <k>/2k_BT per squared unit; rate = ω. origins/laws/soft.py and stiff.py are the same in plain numpy.
"""

import numpy as np

from eq_model.compiling import bits_of, compiled, double_of, inlined
from origins.hot_cells import HOT_MISSING

SOFT, STIFF = 1, 2
MISSING = int(HOT_MISSING)
_U = np.uint64
ABOVE, CELL_BITS = 17.0, 8  # soft levels count from -16, in 256 cells for each octave
LEVEL_UNIT = 2.0**-40
_THIRDS = np.float64(2.0 / 3.0).view(np.int64)
_CUBE = np.int64(0x2A9F7893782DA1CE)
_SERIES, _LAST = 0.02, 12.0
_LOW_LEVEL, _HIGH_LEVEL = -4.0, 36.0
_EIGHT = tuple(np.polynomial.legendre.leggauss(8)[0].tolist())
_WEIGHTS = tuple(np.polynomial.legendre.leggauss(8)[1].tolist())


@inlined
def hermite(place, first, step, values, slopes):  # type: ignore[no-untyped-def]
    """A tabulated function between its nodes, from its values and slopes there."""
    s = (place - first) / step
    k = min(max(int(s), 0), values.size - 2)
    t = s - k
    rise = values[k + 1] - values[k]
    p, q = slopes[k] * step - rise, slopes[k + 1] * step - rise
    return values[k] + t * (rise + (1.0 - t) * (p - t * (p + q)))


@compiled
def _dawson(y, tables):  # type: ignore[no-untyped-def]
    """Dawson's integral for y >= 0."""
    if y < _SERIES:
        square = y * y
        return y * (1.0 - square * (2.0 / 3.0 - square * (4.0 / 15.0)))
    if y < _LAST:
        return hermite(y, 0.0, tables[0], tables[1], tables[2])
    s = 0.5 / (y * y)
    return (1.0 + s * (1.0 + s * (3.0 + s * (15.0 + s * (105.0 + s * (945.0 + s * 10395.0)))))) / (2.0 * y)


@compiled
def _inverse_log_growth(level, tables):  # type: ignore[no-untyped-def]
    """The y at which y² + ln D(y) = level."""
    if level < _LOW_LEVEL:
        y = np.exp(level)
        square = y * y
        return y * (1.0 - square * (1.0 / 3.0 - square * (7.0 / 30.0)))
    if level < _HIGH_LEVEL:
        return hermite(level, _LOW_LEVEL, tables[3], tables[4], tables[5])
    square = level + 0.5 * np.log(4.0 * level)
    for _ in range(5):
        s = 0.5 / square
        square = level + 0.5 * np.log(4.0 * square) - np.log1p(s * (1.0 + s * (3.0 + s * (15.0 + s * 105.0))))
    return np.sqrt(square)


@compiled
def _log_sum(a, b):  # type: ignore[no-untyped-def]
    """ln(e^a + e^b)."""
    high, low = max(a, b), min(a, b)
    return high if low == -np.inf else high + np.log1p(np.exp(low - high))


@compiled
def rate(x, threshold, law, a):  # type: ignore[no-untyped-def]
    """h at a stretch x >= 0."""
    if law[0] == SOFT:
        return law[2] * np.exp(-a * a * (threshold - x) * (threshold + x))
    s = max((threshold - x) / threshold, 0.0)
    return law[2] * np.sqrt(s) * np.exp(-((a * threshold) ** 2) * s * np.sqrt(s))


@compiled
def _fall(near, far, threshold):  # type: ignore[no-untyped-def]
    """(1 - near/threshold)^(3/2) - (1 - far/threshold)^(3/2), without cancellation."""
    first, last = np.sqrt((threshold - near) / threshold), np.sqrt(max((threshold - far) / threshold, 0.0))
    if first == 0.0:
        return 0.0
    return (far - near) / threshold * (first * first + first * last + last * last) / (first + last)


@compiled
def between(near, far, threshold, law, a, tables):  # type: ignore[no-untyped-def]
    """Integral of h over stretches from near >= 0 to far."""
    if far <= near:
        return 0.0
    if law[0] == SOFT:
        rise = a * a * (far - near) * (far + near)
        least = np.exp(-a * a * (threshold - far) * (threshold + far))
        if rise < 1.0 and near > 0.0:
            half, total = 0.5 * (far - near), 0.0
            for k in range(8):
                back = half * (1.0 + _EIGHT[k])
                total += _WEIGHTS[k] * np.exp(-a * a * back * (2.0 * far - back))
            return law[2] * least * half * total
        return law[2] * least * (_dawson(a * far, tables) - np.exp(-rise) * _dawson(a * near, tables)) / a
    c, fall = (a * threshold) ** 2, _fall(near, far, threshold)
    s = max((threshold - far) / threshold, 0.0)
    lost = -np.expm1(-c * fall) / c if c * fall > 1e-300 else fall
    return law[2] * 2.0 / 3.0 * threshold * lost * np.exp(-c * s * np.sqrt(s))


@compiled
def _stretch(u, gone, threshold):  # type: ignore[no-untyped-def]
    """x from u = (1 - x/threshold)^(3/2) and from gone = 1 - u, whichever is the smaller."""
    if u < 0.5:
        return threshold * (1.0 - u ** (2.0 / 3.0))
    return threshold * -np.expm1(2.0 / 3.0 * np.log1p(-gone))


@compiled
def outward(log_amount, near, threshold, law, a, tables):  # type: ignore[no-untyped-def]
    """Stretch up to which the integral of h from near >= 0 is the amount; the threshold where it stays below."""
    log_amount -= np.log(law[2])
    if law[0] == SOFT:
        level = log_amount + np.log(a) + (a * threshold) ** 2
        y = a * near
        if y > 0.0:
            level = _log_sum(level, y * y + np.log(_dawson(y, tables)))
        x = _inverse_log_growth(level, tables) / a
    else:
        c, s = (a * threshold) ** 2, (threshold - near) / threshold
        start, part = c * s * np.sqrt(s), log_amount + np.log(1.5 * c / threshold)
        gone = _log_sum(0.0, part + start)
        left = -_log_sum(part, -start) if part + start > 0.0 else start - gone
        x = _stretch(max(left, 0.0) / c, min(_fall(0.0, near, threshold) + gone / c, 1.0), threshold)
    return min(max(x, near), threshold)


@compiled
def inward(amount, far, threshold, law, a, tables):  # type: ignore[no-untyped-def]
    """Stretch down to which the integral of h from `far` is the amount, which is at most the one down to 0."""
    share = min(amount / between(0.0, far, threshold, law, a, tables), 1.0)
    if law[0] == SOFT:
        y = a * far
        level = y * y + np.log(_dawson(y, tables)) + np.log1p(-share)
        x = _inverse_log_growth(level, tables) / a
    else:
        c, s, whole = (a * threshold) ** 2, (threshold - far) / threshold, _fall(0.0, far, threshold)
        back = -np.log1p(share * np.expm1(-c * whole)) / c
        u = s * np.sqrt(s) + back
        x = _stretch(min(u, 1.0), max(whole - back, 0.0), threshold)
    return min(max(x, 0.0), far)


@compiled
def soften(n, start, work, levels, constant, a, cells):  # type: ignore[no-untyped-def]
    """Where n soft contacts of thresholds work[start ...] break, that bear amounts of logarithms `levels`.

    Born relaxed, in steady forward motion; MISSING where any of it is missing, or the cells do not reach.
    """
    shift, first = np.int64(52 - CELL_BITS), np.int64(1023 << CELL_BITS)
    last, unit = np.int64(cells.shape[0] - 1), 1.0 / a
    for i in range(_U(n)):
        x = work[start + i]
        y = np.float64(levels[i]) * LEVEL_UNIT + constant + (a * np.float64(x)) ** 2
        bits = bits_of(y)
        cell = (bits >> shift) - first
        k = min(max(cell, np.int64(0)), last)
        t = double_of((bits & ((np.int64(1) << shift) - np.int64(1))) | (np.int64(1023) << np.int64(52))) - 1.0
        t *= 2.0**CELL_BITS
        w = cells[k, 0] + t * (cells[k, 1] + t * (cells[k, 2] + t * cells[k, 3]))
        own = np.int64(w * unit + 0.5)
        own = own if own < x else x
        missing = (x >= MISSING) | (levels[i] >= MISSING) | (y < 1.0) | (cell > last)
        work[start + i] = MISSING if missing else own


@inlined
def _quick_log(x):  # type: ignore[no-untyped-def]
    """ln x of a normal number, to 1e-11, without a branch."""
    bits = bits_of(x)
    # the power of two that brings x between 2/3 and 4/3
    power = (bits - _THIRDS) >> np.int64(52)
    m = double_of(bits - (power << np.int64(52)))
    s = (m - 1.0) / (m + 1.0)
    q = s * s
    series = 1.0 + q * (1 / 3 + q * (0.2 + q * (1 / 7 + q * (1 / 9 + q * (1 / 11 + q * (1 / 13))))))
    return np.float64(power) * 0.6931471805599453 + 2.0 * s * series


@inlined
def _quick_root(x):  # type: ignore[no-untyped-def]
    """x^(1/3) of a normal number, to 1e-15, without a branch."""
    y = double_of(np.int64(np.float64(bits_of(x)) * (1.0 / 3.0)) + _CUBE)
    for _ in range(2):
        cube = y * y * y
        y *= (cube + 2.0 * x) / (2.0 * cube + x)
    return y


@inlined
def _quick_exp(x):  # type: ignore[no-untyped-def]
    """e^x for x between -700 and 0, to 1e-12, without a branch."""
    power = np.floor(x * 1.4426950408889634 + 0.5)
    r = x - power * 0.6931471805599453
    high = 1 / 720 + r * (1 / 5040 + r * (1 / 40320 + r * (1 / 362880 + r * (1 / 3628800))))
    series = 1.0 + r * (1.0 + r * (0.5 + r * (1 / 6 + r * (1 / 24 + r * (1 / 120 + r * high)))))
    return series * double_of((np.int64(power) + np.int64(1023)) << np.int64(52))


@compiled
def stiffen(n, start, work, levels, constant, a):  # type: ignore[no-untyped-def]
    """The same of stiff contacts."""
    for i in range(_U(n)):
        x = work[start + i]
        threshold = np.float64(x)
        c = a * a * threshold * threshold
        part = np.float64(levels[i]) * LEVEL_UNIT + constant + _quick_log(threshold)
        # -ln(e^-c + e^part), at most c
        sum_, part = c + part, -part
        d = sum_ if sum_ > 0.0 else -sum_
        d = d if d < 700.0 else 700.0
        least = part if part < c else c
        u = (least - _quick_log(1.0 + _quick_exp(-d))) / c
        u = u if u > 1e-100 else 1e-100
        own = np.int64(threshold * (1.0 - _quick_root(u * u)) + 0.5)
        own = own if own < x else x
        missing = (x >= MISSING) | (levels[i] >= MISSING)
        work[start + i] = MISSING if missing else own
