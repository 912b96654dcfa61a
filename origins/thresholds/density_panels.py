"""Panels on each of which a polynomial follows a density, found from its logarithm alone."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre

from origins.errors import InputError

Array = npt.NDArray[np.float64]

NODES = 12  # of Gauss and Legendre on each panel
# Change of the log-density over a panel, at most: a polynomial through the nodes then errs by 1e-14.
_SPREAD = 1.6
# Error of the polynomial, relative to the largest density on its panel; and what rounding of the
# density itself may leave of it, which halving does not mend.
_ACCURACY, _NOISE = 1e-13, 1e-8
# Log of a weight beside the largest: exp(-745) is the least number there is.
_NOTHING = 745.0
# Panels halve towards the ends of the support, to 1e-33 of the place where most weight is.
_HALVINGS = 110
# Distances at which a density is looked for, in any unit of length.
_STEPS = np.geomspace(1e-130, 1e130, 2601)
# m of a density x^-m, from where on positions beside a pole are too coarse to tell the weights.
_POLE, _WIDER = 0.1, 1024.0
_MOST = 20_000  # panels; smooth densities take some 500
_EPSILON = float(np.finfo(float).eps)

_S, _W = legendre.leggauss(NODES)
PLACES, WEIGHTS = 0.5 * (_S + 1.0), 0.5 * _W  # on (0, 1)
# Matrices from the density at the nodes to its Legendre series, and to its values at the nodes of
# the two halves.
TO_SERIES = (np.arange(NODES) + 0.5)[:, None] * _W * legendre.legvander(_S, NODES - 1).T
_HALVES = np.concatenate([0.5 * (_S - 1.0), 0.5 * (_S + 1.0)])
_TO_HALVES = legendre.legvander(_HALVES, NODES - 1) @ TO_SERIES


@dataclass(frozen=True)
class Panels:
    """edges, of shape (n + 1,); values, of shape (n, 12): exp(log density - top) at the nodes of each panel."""

    edges: Array
    values: Array
    top: float


@dataclass(frozen=True)
class Density:
    """exp(log_density(y)) for lower < y < upper; what is not finite counts as zero.

    power : m of the onset y^m at the lower end; inf where it is not known.
    """

    log_density: Callable[[Array], Array]
    lower: float
    upper: float
    power: float

    def log_at(self, y: Array) -> Array:
        """The logarithm, -inf where the density is zero."""
        with np.errstate(all="ignore"):
            value = self.log_density(y)
        return np.where(np.isfinite(value), value, -np.inf)

    def panels(self, points: Array) -> Panels:
        """Panels between the points, where the density may bend or jump, down to weights of exp(-745).

        Raises InputError where 20,000 panels do not follow it.
        """
        edges, top = self._first_edges(points)
        left, right = edges[:-1], edges[1:]
        log = self.log_at(left[:, None] + (right - left)[:, None] * PLACES) - top
        before: Array = np.full(left.shape, np.inf)
        done_left, done_values, count = [], [], left.size
        while left.size:
            if count > _MOST:
                rule = f"{_MOST} panels do not follow it; smooth it"
                raise InputError(f"thresholds: the density is too rough: {rule}")
            width, middle = right - left, 0.5 * (left + right)
            halves = (
                np.stack([left, middle], axis=-1)[..., None] + 0.5 * width[:, None, None] * PLACES
            )
            finer = self.log_at(halves.reshape(left.size, -1)) - top
            highest = finer.max(axis=1)
            place = np.maximum(np.abs(left), np.abs(right))
            with np.errstate(all="ignore"):  # where the density is zero
                spread = highest - finer.min(axis=1)
                beside = highest[:, None]
                missed = np.abs(np.exp(log - beside) @ _TO_HALVES.T - np.exp(finer - beside)).max(
                    axis=1
                )
                rounding = 16.0 * _EPSILON * (np.abs(highest) + spread * place / width)
            rough = (missed > _ACCURACY + rounding) & ((missed < 0.7 * before) | (missed > _NOISE))
            rough |= spread > _SPREAD
            rough &= (highest > -_NOTHING - 20.0) & (width > 64.0 * _EPSILON * place)
            rough &= (left > self.lower) & (right < self.upper)
            done_left.append(left[~rough])
            done_values.append(np.exp(log[~rough]))
            before, log = np.repeat(missed[rough], 2), finer[rough].reshape(-1, NODES)
            left = np.stack([left[rough], middle[rough]], axis=-1).ravel()
            right = np.stack([middle[rough], right[rough]], axis=-1).ravel()
            count += left.size // 2
        lefts = np.concatenate(done_left)
        order = np.argsort(lefts)
        return Panels(np.append(lefts[order], edges[-1]), np.concatenate(done_values)[order], top)

    def _first_edges(self, points: Array) -> tuple[Array, float]:
        """Edges that halve towards the ends and where most weight is, and the log of the density there."""
        ends = np.array([self.lower, self.upper])
        seen = self._around(np.concatenate([points, ends]), _STEPS)
        density = self.log_at(seen)
        most = -np.inf
        for _ in range(60):  # a peak may be far narrower than the steps
            weight = density + np.log(seen - self.lower)
            at = int(weight.argmax())
            if weight[at] < most + 0.1:
                break
            most = weight[at]
            finer = np.linspace(seen[max(at - 1, 0)], seen[min(at + 1, seen.size - 1)], 17)
            finer = finer[(finer > self.lower) & (finer < self.upper)]
            seen, density = np.append(seen, finer), np.append(density, self.log_at(finer))
            order = np.argsort(seen)
            seen, density = seen[order], density[order]
        top, highest = density[at], seen[at]
        beside = self._around(np.array([highest]), _STEPS)
        seen, density = np.append(seen, beside), np.append(density, self.log_at(beside))
        weight = density - top + np.log((seen - self.lower) / (highest - self.lower))
        live = seen[weight > -_NOTHING]
        start = seen.max(where=seen < live.min(), initial=self.lower)
        end = seen.min(where=seen > live.max(), initial=min(self.upper, 2.0 * float(seen.max())))
        width = np.abs(seen - highest).min(where=density < top - 1.0, initial=end - start)
        halvings = _HALVINGS + np.log2((end - start) / (highest - self.lower))
        halved = (end - start) * 0.5 ** np.arange(halvings)
        if start - self.lower < halved[-1]:
            start = self.lower
        near = self._around(np.array([highest]), halved[halved > 0.25 * width])
        parts = [points, np.array([start, end, highest]), self._around(ends, halved), near]
        edges = np.unique(np.concatenate(parts))
        return edges[(edges >= start) & (edges <= end)], float(top)

    def _around(self, places: Array, steps: Array) -> Array:
        """What lies at these distances to either side of the finite places, inside the support."""
        places = places[np.isfinite(places)][:, None]
        found = np.unique(np.concatenate([places - steps, places + steps]))
        return found[(found > self.lower) & (found < self.upper)]

    def pole(self, points: Array, origin: float) -> float | None:
        """A point or end y at which the density diverges, but for a lower end x = y + origin = 0 with a known power."""
        places = np.unique(np.concatenate([points, [self.lower, self.upper]]))
        places = places[(places >= self.lower) & (places <= self.upper) & np.isfinite(places)]
        if np.isfinite(self.power):
            places = places[(places != self.lower) | (places + origin != 0.0)]
        least = 1e-40 * float(np.abs(places).max(initial=1e-160))
        step = 8.0 * np.maximum(np.spacing(np.abs(places)), least)
        for side in (-step, step):
            with np.errstate(invalid="ignore"):
                rise = self.log_at(places + side) - self.log_at(places + _WIDER * side)
                found = places[rise > _POLE * np.log(_WIDER)]
            if found.size:
                return float(found[0])
        return None
