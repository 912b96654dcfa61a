"""Stretches at which contacts break at a steady speed and temperature: the law p = -E' of relaxed births.

A contact born at x = 0 with the threshold ξ holds at x < ξ with the probability exp[-A(x; ξ)/v], A the integral of the
breaking rate h. Over fresh thresholds, with closure "exact",

    E(x) = integral over ξ > x of P_c(ξ) exp[-A(x; ξ)/v],
    p(x) = P_c(x) exp[-A(x; x)/v] + integral over ξ > x of P_c(ξ) h(x; ξ)/v exp[-A(x; ξ)/v],

and with closure "paper", where all break at the mean rate H(x) of (temper3), E(x) = S(x) exp[-integral of H/v].
"""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from master.piecewise import Piecewise, tabulate
from origins import Contacts, Thermal, Thresholds
from origins.quadrature import gauss, panel_edges

Array = npt.NDArray[np.float64]
Function = Callable[[Array], Array]

_ACCURACY = 1e-13
_TAIL = 1e-20
# panels around the threshold at which A/v = 1, as ln(A/v): e^(-A/v) falls from 1 to 0 in between
_AROUND = np.array([3.9, 3.3, 2.7, 2.1, 1.5, 0.9, 0.3, -0.4, -1.2, -2.1, -3.2, -4.6, -6.5, -9.0, -13.0, -20.0, -38.0])
_CUTS = 10
_STEPS = 12
_CHUNK = 200_000


class BreakingLaw(Thresholds):
    """The law p as Thresholds: stretches at which contacts, born relaxed, break.

    Parameters
    ----------
    contacts : Contacts with `thermal`
    velocity : float
        v > 0, length per time.
    """

    def __init__(self, contacts: Contacts, velocity: float) -> None:
        if contacts.thermal is None:
            raise ValueError("contacts without temperature break at their thresholds")
        self._law, self._thermal, self._velocity = contacts.thresholds, contacts.thermal, velocity
        self._contacts = contacts
        lower, upper = self._law.support()
        far = upper if np.isfinite(upper) else float(self._law.isf(1e-300))
        self._panels = np.unique(np.concatenate([[lower], panel_edges(self._law, tail=1e-30), [min(far, upper)]]))
        self._top = float(self._panels[-1])
        self.onset_power = 0.0
        reach = self._reach()
        marks = self._law.breakpoints
        seeds = np.unique(np.concatenate([np.linspace(0.0, reach, 9), marks[(marks > 0.0) & (marks < reach)]]))
        self._break_table, self._held_table = tabulate(self._rows, seeds, _ACCURACY)
        self._end = reach

    def _reach(self) -> float:
        """Stretch that fewer than 1e-20 pass."""
        low, high = 0.0, self._top
        for _ in range(_CUTS):
            at = np.linspace(low, high, 34)[1:-1]
            passed = int((self._rows(at[None])[1, 0] > _TAIL).sum())
            low, high = (at[passed - 1] if passed else low), (at[passed] if passed < at.size else high)
        return float(high)

    def _rows(self, x: Array) -> Array:
        """p and E at x, shape (2, *x.shape)."""
        flat = x.ravel()
        per = 8 * (self._panels.size + _AROUND.size)
        chunk = max(1, _CHUNK // per)
        parts = [self._integrals(flat[i : i + chunk]) for i in range(0, flat.size, chunk)]
        return np.concatenate(parts, axis=1).reshape(2, *x.shape)

    def _integrals(self, x: Array) -> Array:
        thermal, velocity = self._thermal, self._velocity
        centre, width = self._half_way(x)
        local = centre[:, None] + width[:, None] * -_AROUND
        edges = np.concatenate([np.broadcast_to(self._panels, (x.size, self._panels.size)), local], axis=1)
        edges = np.sort(np.clip(edges, np.maximum(x, self._panels[0])[:, None], self._top), axis=1)
        # a stiff contact's rate has a root at its threshold: in the root of ξ - x all is smooth
        roots = np.sqrt(edges - x[:, None])
        left, right = roots[:, :-1], roots[:, 1:]
        wide = right > left
        row = np.nonzero(wide)[0]
        out = np.zeros((2, x.size))
        if row.size:
            nodes, weights = gauss(left[wide], right[wide])
            at = np.broadcast_to(x[row, None], nodes.shape)
            nodes, weights = at + nodes * nodes, 2.0 * nodes * weights
            stiffness = self._contacts.relative_stiffness(nodes)
            log_left = -np.exp(np.minimum(thermal.log_cumulative(at, nodes, stiffness=stiffness) - np.log(velocity), 7.0))
            held = weights * self._law.pdf(nodes) * np.exp(log_left)
            rate = np.exp(thermal.log_rate(at, nodes, stiffness) - np.log(velocity))
            out[0] = np.bincount(row, weights=(held * rate).sum(-1), minlength=x.size)
            out[1] = np.bincount(row, weights=held.sum(-1), minlength=x.size)
        at_threshold = self._law.pdf(x)
        inside = (at_threshold > 0.0) & (x > 0.0)
        if inside.any():
            own = x[inside]
            spent = thermal.log_cumulative(own, own, stiffness=self._contacts.relative_stiffness(own)) - np.log(velocity)
            out[0, inside] += at_threshold[inside] * np.exp(-np.exp(np.minimum(spent, 7.0)))
        return out

    def _half_way(self, x: Array) -> tuple[Array, Array]:
        """Threshold at which A(x; ξ)/v = 1, x itself where it is less there, and the width of a factor e in A."""

        def level(threshold: Array) -> Array:
            threshold = np.maximum(threshold, 1e-300)
            stiffness = self._contacts.relative_stiffness(threshold)
            return self._thermal.log_cumulative(x, threshold, stiffness=stiffness) - np.log(self._velocity)

        low = np.maximum(x, self._panels[0])
        high = np.maximum(np.full(x.shape, self._top), low)
        centre = _falling_root(level, low, high, 0.0)
        further = _falling_root(level, centre, np.maximum(2.0 * centre, high), level(centre) - 1.0)
        return centre, further - centre

    def support(self) -> tuple[float, float]:
        return 0.0, self._end

    @property
    def breakpoints(self) -> Array:
        marks = self._law.breakpoints
        return np.unique(np.concatenate([[0.0], marks[(marks > 0.0) & (marks < self._end)], [self._end]]))

    def _pdf(self, x: Array) -> Array:
        return np.maximum(self._break_table(x), 0.0)

    def _sf(self, x: Array) -> Array:
        return np.clip(self._held_table(x), 0.0, 1.0)

    def _cdf(self, x: Array) -> Array:
        return np.clip(self._break_table.integral(x), 0.0, 1.0)


def _falling_root(level: Function, low: Array, high: Array, goal: Array | float) -> Array:
    """Where a function that falls with ξ reaches `goal`, or the nearer end: false position in ξ², as Illinois has it."""
    left, right = low * low, high * high
    above, below = level(low) - goal, level(high) - goal
    out = np.where(above <= 0.0, low, high)
    inside = (above > 0.0) & (below < 0.0)
    above, below = np.where(inside, above, 1.0), np.where(inside, below, -1.0)
    side = np.zeros(low.shape)
    for _ in range(_STEPS):
        share = np.clip(above / (above - below), 1e-3, 1.0 - 1e-3)
        middle = left + share * (right - left)
        value = level(np.sqrt(middle)) - goal
        up = value > 0.0
        below = np.where(up & (side > 0.0), 0.5 * below, below)
        above = np.where(~up & (side < 0.0), 0.5 * above, above)
        left, above = np.where(up, middle, left), np.where(up, value, above)
        right, below = np.where(up, right, middle), np.where(up, below, value)
        side = np.where(up, 1.0, -1.0)
    return np.where(inside, np.sqrt(middle), out)
