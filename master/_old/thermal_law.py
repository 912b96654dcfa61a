"""Breaks at a steady speed and temperature, with closure "exact": of all contacts that stood at one stretch.

A contact that stood at x_0, |x_0| < ξ its threshold, still holds at x < ξ with the probability
exp{-[A(x; ξ) - A(x_0; ξ)]/v}, A the integral of the breaking rate h. Over thresholds,

    E(x; x_0) = integral over ξ > max(|x_0|, x) of P_c(ξ) exp{-[A(x; ξ) - A(x_0; ξ)]/v},
    p(x; x_0) = P_c(x) exp{-[A(x; x) - A(x_0; x)]/v}, where x > |x_0|,
                + the integral of E with h(x; ξ)/v beside the exponential,

both to be divided by S(|x_0|). Of relaxed births, x_0 = 0, p is a law of the stretches at which they break.
"""

from collections.abc import Callable, Iterator
from typing import Self

import numpy as np
import numpy.typing as npt

from master._old.threshold_panels import ThresholdPanels
from origins import Contacts
from origins.start import Start
from origins.thresholds.quadrature import finite_density

Array = npt.NDArray[np.float64]
Function = Callable[[Array], Array]

# panels around the threshold at which A/v = 1, as ln(A/v): e^(-A/v) falls from 1 to 0 in between
_AROUND = np.array([3.9, 3.3, 2.7, 2.1, 1.5, 0.9, 0.3, -0.4, -1.2, -2.1, -3.2, -4.6, -6.5, -9.0, -13.0, -20.0, -38.0])
_LEAST = float(np.exp(_AROUND[-1]))
_SMOOTH = 0.6  # change of ln(A/v) that eight nodes see through
_BELOW = 3.2  # 16 times the part of a change that is felt where A/v is about 1; the error goes as the power 16 of it
MOST_SPENT = 40.0  # exponent: beyond, the round-off of a difference of two is felt
MOST_GROWTH = 3.0  # of A/v over the starts told by one table
_STEPS, _CLOSE = 12, 0.02  # and how well ln(A/v) is known where panels are laid around it
_NEAR, _FURTHER = 4.0, 100
_CHUNK = 36_000  # so that what is made on the way stays in the cache
_GONE = 7.0  # e^(-e^7) is nothing


class ThermalBreaking:
    """p and E of contacts with `thermal` at the speed v > 0 (length per time); lengths as given."""

    error = 0.0
    panels = np.empty(0)

    def __init__(self, contacts: Contacts, velocity: float) -> None:
        if contacts.thermal is None:
            raise ValueError("contacts without temperature break at their thresholds")
        self.law, self._thermal, self._velocity = contacts.thresholds, contacts.thermal, velocity
        self._contacts, self.linked = contacts, contacts.stiffness == "linked"
        self.atoms, self.atom_weights = self.law.atoms
        self._panels = ThresholdPanels(self.law, self.rooted, self._barrier)
        self.top = self._panels.top
        marks = np.concatenate([self.law.breakpoints, self.atoms])
        self.marks = np.unique(marks[marks > 0.0])

    def of(self, start: Start) -> Self:
        """The same for contacts that stand at the stretches of `start`: one table does for all."""
        return self

    def bends(self, travel: Array) -> Array:
        """Origins beside which `rows` bends at each travel, but for where stretches turn at 0: none, shape (n, 0)."""
        return np.empty((travel.size, 0))

    def rows(self, x: Array, origin: Array | float = 0.0) -> Array:
        """p and E at stretches x > `origin`, where stiffnesses differ then both with these under the integral; shape
        (2, n) or (4, n) for x of shape (n,)."""
        origin = np.broadcast_to(origin, x.shape)
        out = np.zeros((4 if self.linked else 2, x.size))
        least = np.maximum(x, np.abs(origin))
        live = np.flatnonzero(least <= self.top)
        live = live[least[live].argsort(kind="stable")]  # neighbours share most of their thresholds
        x, origin = x[live], origin[live]
        chunk = self._panels.rows_in(_CHUNK)
        parts = [self._integrals(x[i : i + chunk], origin[i : i + chunk]) for i in range(0, x.size, chunk)]
        if parts:
            out[:, live] = np.concatenate(parts, axis=1)
        return out

    def _barrier(self, threshold: Array) -> Array:
        """Of a relaxed contact, in units of k_BT."""
        return self._contacts.relative_stiffness(threshold) * threshold**2 / (2.0 * self._thermal.temperature)

    def held(self, x: Array, threshold: Array, origin: Array) -> Array:
        """exp{-[A(x; ξ) - A(x_0; ξ)]/v}, for x >= x_0."""
        return np.exp(-self._passed(x, threshold, origin)[1])

    def _passed(self, x: Array, threshold: Array, origin: Array) -> tuple[Array, Array]:
        """h/v at x, and [A(x; ξ) - A(x_0; ξ)]/v."""
        stiffness = self._contacts.relative_stiffness(threshold) if self.linked else 1.0
        return self._thermal.per_length(x, threshold, origin, stiffness, self._velocity)

    def _log_spent(self, x: Array, threshold: Array, origin: Array) -> Array:
        """ln of the same, finite where that underflows."""
        stiffness = self._contacts.relative_stiffness(threshold) if self.linked else 1.0
        return self._thermal.log_per_length(x, threshold, origin, stiffness, self._velocity)

    @property
    def rooted(self) -> bool:
        """Whether the rate has a root at its threshold, beyond which it does not go on smoothly."""
        return self._thermal.rates.vanishes_at_threshold

    @property
    def bends_at_zero(self) -> bool:
        """Whether the slope of h jumps at x = 0, where the barrier's |x| does."""
        return self._thermal.rates.vanishes_at_threshold

    def grown(self, origins: Array, least: float, felt: float) -> tuple[Array, Array]:
        """A(x_0; ξ)/v for each of `origins` and the thresholds above `least` of weights above `felt`; these weights."""
        nodes, mass = self._panels.nodes, self._panels.mass
        some = (mass > felt) & (nodes > least)
        atoms = (self.atom_weights > felt) & (self.atoms > least)
        thresholds = np.concatenate([nodes[some], self.atoms[atoms]])
        spent = self._passed(origins[:, None], thresholds, np.zeros(1))[1]
        return spent, np.concatenate([mass[some], self.atom_weights[atoms]])

    def fan(self, x: Array, origins: Array, lowest: Array, least: Array) -> Array:
        """p, where stiffnesses differ then with these under the integral, of contacts that stood at each of `origins`,
        at stretches x of shape (n,) above `lowest`, close below the origin, from where A/v grows by less than
        MOST_GROWTH; thresholds up to the `least` of each left out. Shape (1 or 2, origins, n)."""
        out = np.zeros((2 if self.linked else 1, origins.size, x.size))
        chunk = self._panels.rows_in(_CHUNK)
        for i in range(0, x.size, chunk):
            at, here = x[i : i + chunk], out[:, :, i : i + chunk]
            for row, mass, threshold in self._thresholds(at, np.zeros(at.size), np.abs(at)):
                rate, spent = self._passed(at[row, None], threshold, np.zeros(1))
                held = np.exp(np.minimum(-spent, MOST_SPENT))  # only thresholds that weigh nothing exceed it
                self._fan_out(here, row, mass, rate * held, threshold, (origins, lowest, least))
            own = np.flatnonzero((at > 0.0) & (finite_density(self.law, at) > 0.0))
            mass, threshold = finite_density(self.law, at[own])[:, None], at[own, None]
            held = self.held(threshold, threshold, np.zeros(1))
            self._fan_out(here, own, mass, held, threshold, (origins, lowest, least))
        return out

    def _fan_out(
        self,
        out: Array,
        row: npt.NDArray[np.intp],
        mass: Array,
        breaks: Array,
        threshold: Array,
        starts: tuple[Array, Array, Array],
    ) -> None:
        """Add sums of `breaks` times what held since each of the origins."""
        weights = [mass, mass * self._contacts.relative_stiffness(threshold)] if self.linked else [mass]
        if len(mass) == 1:
            origins, lowest, least = (start[:, None] for start in starts)
            grown = self._held_since(threshold, origins, self._most(threshold, lowest), least)
            for total, weight in zip(out, weights, strict=True):
                total[:, row] += (grown * weight) @ breaks.T
            return
        parts = [breaks * weight for weight in weights]
        most, begin = np.empty(0), np.nan
        for k, (origin, lowest, none) in enumerate(zip(*starts, strict=True)):
            if lowest != begin:  # many begin alike
                most, begin = self._most(threshold, lowest), lowest
            grown = self._held_since(threshold, origin, most, none)
            for total, part in zip(out[:, k], parts, strict=True):
                total += np.bincount(row, weights=np.einsum("ij,ij->i", part, grown), minlength=total.size)

    def _held_since(self, threshold: Array, origin: Array, most: Array, least: Array) -> Array:
        """e^{A(x_0; ξ)/v} for thresholds above `least`, and e to `most` where that is less."""
        spent = self._passed(origin, threshold, np.zeros(1))[1]
        return np.where(threshold > least, np.exp(np.minimum(spent, most)), 0.0)

    def _most(self, threshold: Array, lowest: Array) -> Array:
        """What only thresholds that weigh nothing have spent, where those that weigh something have spent less than
        MOST_GROWTH since `lowest`."""
        return np.minimum(self._passed(lowest, threshold, np.zeros(1))[1] + MOST_GROWTH, MOST_SPENT) + 1.0

    def _integrals(self, x: Array, origin: Array) -> Array:
        least = np.maximum(x, np.abs(origin))
        out = np.zeros((4 if self.linked else 2, x.size))
        alike = origin[:1] if (origin == origin[0]).all() else None
        for row, mass, threshold in self._thresholds(x, origin, least):
            rate, spent = self._passed(x[row, None], threshold, origin[row, None] if alike is None else alike)
            held = np.exp(-spent)
            parts = [held * rate, held]
            weights = [mass] * 2
            if self.linked:
                parts, weights = parts * 2, weights + [mass * self._contacts.relative_stiffness(threshold)] * 2
            for total, part, weight in zip(out, parts, weights, strict=True):
                each = part @ weight[0] if len(mass) == 1 else np.einsum("ij,ij->i", part, weight)
                total += np.bincount(row, weights=each, minlength=x.size)
        at_threshold = finite_density(self.law, x)
        inside = (at_threshold > 0.0) & (x > np.abs(origin))
        if inside.any():
            own = x[inside]
            breaks = at_threshold[inside] * self.held(own, own, origin[inside])
            out[0, inside] += breaks
            if self.linked:
                out[2, inside] += breaks * self._contacts.relative_stiffness(own)
        return out

    def _thresholds(
        self, x: Array, origin: Array, least: Array
    ) -> Iterator[tuple[npt.NDArray[np.intp], Array, Array]]:
        """Thresholds above `least` for each x and their weights, for sums over what holds: rows of x that they are for,
        weights, thresholds."""
        panels = self._panels
        edges = np.maximum(panels.edges, least[:, None])
        level = np.maximum(self._passed(x[:, None], edges, origin[:, None])[1], _LEAST)
        level = np.minimum(np.log(level), _AROUND[0]) + 1.0
        # below, e^(-A/v) changes by little, and the less the smaller A is
        seen = np.where(level < 0.0, _BELOW * np.expm1(np.minimum(level, 0.0) / 16.0), level)
        across = np.abs(np.diff(seen, axis=1))
        sharp = ((across > _SMOOTH) & panels.heavy).any(axis=1)
        smooth = np.flatnonzero(~sharp)
        for row, mass, threshold in panels.above(least[smooth]):
            yield smooth[row], mass, threshold
        if sharp.any():
            centre, width = self._half_way(x[sharp], origin[sharp], least[sharp])
            edges = np.concatenate([edges[sharp], centre[:, None] + width[:, None] * -_AROUND], axis=1)
            edges = np.sort(np.clip(edges, edges[:, :1], panels.top), axis=1)
            yield from panels.between(np.flatnonzero(sharp), edges, least[sharp])
        for atom, weight in zip(self.atoms, self.atom_weights, strict=True):
            row = np.flatnonzero(least < atom)
            yield row, np.full((row.size, 1), weight), np.full((row.size, 1), atom)

    def _half_way(self, x: Array, origin: Array, least: Array) -> tuple[Array, Array]:
        """Threshold at which A/v = 1, the lowest there is where it is less there, and the width of a factor e in A."""

        def level(threshold: Array) -> Array:
            return self._log_spent(x, np.maximum(threshold, 1e-300), origin)

        low = np.maximum(least, self._panels.edges[0])
        top = np.maximum(self.top, low)
        centre = _falling_root(level, low, self._beyond(level, low, top, 0.0), 0.0)
        goal = level(centre) - 1.0
        further = _falling_root(level, centre, self._beyond(level, centre, np.maximum(2.0 * centre, top), goal), goal)
        return centre, further - centre

    def _beyond(self, level: Function, low: Array, strongest: Array, goal: Array | float) -> Array:
        """Thresholds above `low`, up to the strongest, at which a falling function is below `goal`: not so far above
        that false position does not come back."""
        high = np.minimum(np.maximum(_NEAR * low, _NEAR * self._contacts.mean_threshold), strongest)
        for _ in range(_FURTHER):
            short = high < strongest
            if not short.any():
                break
            short &= level(high) > goal
            if not short.any():
                break
            high = np.where(short, np.minimum(_NEAR * high, strongest), high)
        return high


def _falling_root(level: Function, low: Array, high: Array, goal: Array | float) -> Array:
    """Where a function that falls with ξ reaches `goal`, or the nearer end: false position in ξ² (Illinois)."""
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
        if np.abs(value[inside]).max(initial=0.0) < _CLOSE:
            break
    return np.where(inside, np.sqrt(middle), out)
