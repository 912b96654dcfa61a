"""H(x): the rate h(x; x_s) averaged over the law of thresholds above |x| (paper, Eq. temper3)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from master.lives.heat.above import Above
from master.lives.heat.threshold_panels import SMALLEST, Panels, joined, nodes

Array = npt.NDArray[np.float64]

# ln h: 16 nodes see such a fall over a panel to 1e-14
_FALL = 8.0
# ln of a share of H: what adds less is left out
_NOTHING = -42.0
_NARROW = 4e-16  # lengths in units of the threshold
_NEVER = -1e300  # ln h of contacts that do not break


def mean_rate(above: Above, x: Array, parts: int = 1) -> Array:
    """H at x >= 0, per time, of the continuous part of P_c (paper, Eq. temper3); shape (n,).

    above : Above, of independent stiffness
    parts : every panel is cut in so many more: 1, or 2 to see what the sum misses
    """
    if not above.edges.size:
        return np.zeros(x.size)
    panels = _resolved(above, np.maximum(x, SMALLEST))
    if parts == 2:
        middle = 0.5 * (panels.low + panels.high)
        panels = panels.cut(middle, middle)  # the levels are not asked for any more
    at = x[panels.row]
    xi, weight = nodes(above.law, panels, at if above.rooted else None)
    sums = (weight * above.rates.rate(at[:, None], xi, 1.0)).sum(axis=1)
    return np.asarray(np.bincount(panels.row, sums, minlength=x.size), dtype=float)


def _resolved(above: Above, x: Array) -> Panels:
    """Panels above each x, cut until ln h falls by little on each; not where h is nothing."""

    def level(row: npt.NDArray[np.intp], xi: Array) -> Array:
        return np.maximum(above.rates.log_rate(x[row], xi, 1.0), _NEVER)

    ends = np.maximum(above.edges, x[:, None])
    row, col = np.nonzero(ends[:, 1:] > ends[:, :-1])
    low, high = ends[row, col], ends[row, col + 1]
    panels = Panels(row, low, high, level(row, low), level(row, high))
    if above.rooted:
        at = above.fastest(x)[row]
        split = (low < at) & (at < high)
        halves = panels.pick(split).cut(at[split], level(row[split], at[split]))
        panels = joined([panels.pick(~split), halves])
    done: list[Panels] = []
    best = np.full(x.size, _NEVER)
    while panels.row.size:
        at = 0.5 * (panels.low + panels.high)
        middle = level(panels.row, at)
        with np.errstate(divide="ignore"):
            weight = np.log(above.law.pdf(at) * (panels.high - panels.low))
        lowest = np.minimum(np.minimum(panels.first, panels.last), middle)
        np.maximum.at(best, panels.row, np.maximum(weight + lowest, _NEVER))
        highest = np.maximum(np.maximum(panels.first, panels.last), middle)
        felt = highest > best[panels.row] + _NOTHING
        fall = np.maximum(np.abs(panels.first - middle), np.abs(middle - panels.last))
        seen = 2.0 * fall <= _FALL
        if above.rooted:  # up to the fastest there, h is a root times what hardly changes
            seen |= (panels.low <= x[panels.row]) & (panels.last >= panels.first)
        seen |= panels.high - panels.low <= _NARROW * panels.high
        done.append(panels.pick(felt & seen))
        cut = felt & ~seen
        panels = panels.pick(cut).cut(at[cut], middle[cut])
    return joined(done)
