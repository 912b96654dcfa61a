"""What temperature has cost contacts, strand by strand and node by node, compiled; spent_wear.py is the same in numpy.

All that is compiled stands in this one file, because numba's cache on disk notices changes in a function's own file
only.
"""


import numpy as np
import numpy.typing as npt
from scipy.special import dawsn

from master._old.compiling import compiled

Array = npt.NDArray[np.float64]

_MOST = 500.0  # e^(-A) is nothing
_LITTLE = 1e-13
_NOTHING = 1e-18
_FEW = 8
_GONE = 45.0  # of the contacts less than is said
_PER = 1024
_TOP = 30.0
_AT = np.arange(int(_TOP * _PER) + 2) / _PER
DAWSON = np.stack([dawsn(_AT), 1.0 - 2.0 * _AT * dawsn(_AT)])


@compiled
def _dawson(y: float, table: Array) -> float:
    """Dawson's integral for y >= 0, by Hermite's cubics."""
    if y >= 30.0:
        z = 0.5 / (y * y)
        return 0.5 / y * (1.0 + z * (1.0 + 3.0 * z * (1.0 + 5.0 * z * (1.0 + 7.0 * z))))
    place = y * 1024.0
    k = int(place)
    t = place - k
    s = 1.0 - t
    value = table[0, k] * s * s * (1.0 + 2.0 * t) + table[0, k + 1] * t * t * (3.0 - 2.0 * t)
    return value + t * s * (table[1, k] * s - table[1, k + 1] * t) / 1024.0


@compiled
def _cost(
    stiff: bool, near: float, far: float, way: float, across: bool, threshold: float, b: float, table: Array
) -> float:
    """Mean of h/ω between two stretches (their sizes, near <= far), b = k/(2 k_BT)."""
    if stiff:
        c, s = b * threshold * threshold, max(1.0 - far / threshold, 0.0)
        if way == 0.0:
            return np.sqrt(s) * np.exp(-c * s * np.sqrt(s))
        q = 1.0 - near / threshold
        end, begin = np.exp(-c * s * np.sqrt(s)), np.exp(-c * q * np.sqrt(q))
        total = end + begin - 2.0 * np.exp(-c) if across else end - begin
        return total * 2.0 * threshold / (3.0 * c * way)
    barrier = b * (threshold - far) * (threshold + far)
    if way == 0.0:
        return np.exp(-barrier)
    root, rise = np.sqrt(b), b * (far - near) * (far + near)
    less = np.exp(-rise) * _dawson(root * near, table)
    total = _dawson(root * far, table) + (less if across else -less)
    return np.exp(-barrier) * total / (root * way)


@compiled
def _spent(i: int, j: int, stiff: bool, legs: Array, kept: Array, nodes: Array, springs: Array, table: Array) -> float:
    """A of strand i at node j; legs are rows (near, far, way, time times ω, across)."""
    if kept[i, j] >= _MOST:
        return _MOST
    if legs[i, 3] <= 0.0:
        return kept[i, j]
    mean = _cost(stiff, legs[i, 0], legs[i, 1], legs[i, 2], legs[i, 4] > 0.0, nodes[j], springs[j], table)
    return min(kept[i, j] + max(mean, 0.0) * legs[i, 3], _MOST)


@compiled
def spent(
    stiff: bool, legs: Array, kept: Array, first: npt.NDArray[np.intp], nodes: Array, springs: Array, table: Array
) -> Array:
    """A of strands, shape (n, k), at nodes from number first on; so much before that nothing is left."""
    n, k = legs.shape[0], nodes.size
    out = np.full((n, k), _MOST)
    for i in range(n):
        few = 0
        for j in range(first[i], k):
            if few > _FEW:  # further barriers are higher still
                out[i, j] = kept[i, j]
                continue
            out[i, j] = _spent(i, j, stiff, legs, kept, nodes, springs, table)
            if kept[i, j] < _GONE:  # what is added to more is cut off or rounded away
                few = few + 1 if out[i, j] - kept[i, j] < _NOTHING else 0
    return out


@compiled
def left(
    stiff: bool,
    legs: Array,
    kept: Array,
    first: npt.NDArray[np.intp],
    nodes: Array,
    springs: Array,
    table: Array,
    weights: Array,
    tails: Array,
) -> Array:
    """Sums of e^(-A) times the rows of weights, shape (n, 2); tails are sums of these from each node on, (2, k + 1)."""
    n, k = legs.shape[0], nodes.size
    out = np.zeros((n, 2))
    for i in range(n):
        few = 0
        for j in range(first[i], k):
            if kept[i, j] > _GONE:
                continue
            cost = _spent(i, j, stiff, legs, kept, nodes, springs, table)
            few = few + 1 if cost < _LITTLE else 0
            if few > _FEW:  # further barriers are higher still
                out[i, 0] += tails[0, j]
                out[i, 1] += tails[1, j]
                break
            if cost < _MOST:
                share = np.exp(-cost)
                out[i, 0] += share * weights[0, j]
                out[i, 1] += share * weights[1, j]
    return out


@compiled
def beside(
    stiff: bool,
    legs: Array,
    worn: Array,
    column: npt.NDArray[np.intp],
    at: Array,
    nodes: Array,
    springs: Array,
    table: Array,
    even: Array,
    beyond: Array,
    own: int,
) -> Array:
    """A of strands at nodes, shape (n, k): what the present motion costs, and what is kept in `worn` from a column on,
    none if below 0, read at a place between the nodes of one of two rules, that for column `own` or that for others."""
    n, k = nodes.shape
    out = np.zeros((n, k))
    for i in range(n):
        for j in range(k):
            total = 0.0
            first = column[i, j]
            if first >= 0:
                rule = beyond if first == own else even
                whole, value = 0.0, 0.0
                for q in range(rule.shape[1]):
                    apart = at[i, j] - rule[0, q]
                    if abs(apart) < 1e-14:
                        apart = 1e-14
                    weight = rule[1, q] / apart
                    whole += weight
                    value += weight * worn[i, first + q]
                total = value / whole
            if legs[i, 3] > 0.0:
                threshold = nodes[i, j]
                near, far = min(legs[i, 0], threshold), min(legs[i, 1], threshold)
                mean = _cost(stiff, near, far, legs[i, 2], legs[i, 4] > 0.0, threshold, springs[i, j], table)
                total += max(mean, 0.0) * legs[i, 3]
            out[i, j] = min(max(total, 0.0), _MOST)
    return out
