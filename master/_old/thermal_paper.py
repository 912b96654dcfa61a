"""Breaks at a steady speed and temperature, with closure "paper": all contacts break at one mean rate.

To the hazard P(x) of the thresholds comes H(x)/v, H the integral of h(x; ξ) P_c(ξ) over ξ > x (paper, Eqs. temper3,
temper4): not conditioned on survival. So, with barriers of |x| and thresholds above |x_0| as everywhere else,

    E(x; x_0) S(|x_0|) = S(max(|x_0|, x)) exp{-[L(x) - L(x_0)]},     L(x) = integral of H/v from 0 to x, odd in x,
                 v L(x) = integral of P_c(ξ) A(min(x, ξ); ξ) over all ξ,          A that of h, in closed form.
"""

from functools import cached_property
from typing import Self

import numpy as np
import numpy.typing as npt

from master._old.piecewise import Piecewise, tabulate
from master._old.threshold_panels import ThresholdPanels
from master._old.weights import NodeWeights
from origins import Contacts
from origins.start import Start
from origins.thresholds.quadrature import GAUSS_NODES, finite_density, gauss

Array = npt.NDArray[np.float64]

_ACCURACY = 1e-14
_ROUNDED = 4.0 * float(np.finfo(float).eps) / _ACCURACY
_FELT = 1e-16
_HALVINGS, _LITTLE = 200, 0.1
_NEAR_ZERO = 1e-3
_CHUNK = 60_000
_GONE = 60.0  # exponent beyond which a barrier is never passed at the attempt frequency v per length
_MOST = 750.0
_NEAR = 1.6 ** np.arange(46.0)
_BELOW = np.linspace(0.0, 1.0, 25)
_ABOVE = np.arange(1.0, 33.0)


class PaperBreaking:
    """p and E of contacts with `thermal` at the speed v > 0 (length per time); lengths as given. The same face as
    thermal_law.ThermalBreaking."""

    linked = rooted = False
    error = 0.0
    panels = np.empty(0)

    def __init__(self, contacts: Contacts, velocity: float) -> None:
        assert contacts.thermal is not None
        self.law, self._thermal = contacts.thresholds, contacts.thermal
        self._velocity, self._mean = velocity, contacts.mean_threshold
        self.atoms, self.atom_weights = self.law.atoms
        self._weights = NodeWeights(self.law)
        temperature, std = contacts.thermal.temperature, self.law.std() or contacts.mean_threshold
        attempts = max(contacts.thermal.attempt_frequency / velocity * contacts.mean_threshold, 1.0)
        stiff = contacts.thermal.rates.vanishes_at_threshold
        panels = ThresholdPanels(self.law, stiff, lambda x: x * x / (2.0 * temperature), _FELT / attempts)
        self._shared, self._panels, self.top = panels, panels.edges, panels.top
        spent = self._thermal.per_length(panels.nodes, panels.nodes, np.zeros(1), 1.0, 1.0)[1]
        self._before = np.append(0.0, (panels.mass * spent).reshape(-1, GAUSS_NODES.size).sum(axis=1).cumsum())
        # where P_c is nothing about 0 the rate of soft contacts is even and smooth there
        self.bends_at_zero = stiff or float(self.law.cdf(_NEAR_ZERO * contacts.mean_threshold)) > _FELT
        marks = np.concatenate([self.law.breakpoints, self.atoms])
        self.marks = np.unique(marks[marks > 0.0])
        # P_c times e^(-barrier) is as narrow as both together
        self._width = 0.8 / np.sqrt(1.0 / temperature + 1.0 / std**2)
        self._square = 2.0 * temperature * (_GONE + np.log(attempts))

    @cached_property
    def _tables(self) -> list[Piecewise]:
        """L, and H/v per mean threshold, over x in mean thresholds."""
        unit = self._mean
        # towards 0, where most break if much is spent at all, panels begin as narrow as is felt
        near = self.top * 0.5 ** np.arange(1.0, _HALVINGS)
        near = near[self._integrals(near)[0] > _LITTLE]
        marks = self.marks[self.marks < self.top]
        edges = np.unique(np.concatenate([np.linspace(0.0, self.top, 9), marks, near]))

        def both(x: Array) -> Array:
            spent, hazard = self._integrals(unit * x.ravel())
            return np.stack([spent, unit * hazard]).reshape(2, *x.shape)

        def known(x: Array) -> Array:
            # beside barriers so high the distance to thresholds that break now is rounded
            return np.stack([np.ones(x.size), 1.0 / (1.0 + _ROUNDED * (unit * x) ** 2 / self._thermal.temperature)])

        return tabulate(both, edges / unit, _ACCURACY, scale=known, relative=True)

    def spent(self, x: Array) -> Array:
        """L at x >= 0."""
        return self._tables[0](x / self._mean)

    def hazard(self, x: Array) -> Array:
        """H/v at x >= 0; 0 beyond all thresholds."""
        return self._tables[1](x / self._mean) / self._mean

    def of(self, start: Start) -> Self:
        """The same for contacts that stand at the stretches of `start`: one table does for all."""
        return self

    def bends(self, travel: Array) -> Array:
        """Origins beside which `rows` bends at each travel, but for where stretches turn at 0: none, shape (n, 0)."""
        return np.empty((travel.size, 0))

    def rows(self, x: Array, origin: Array | float = 0.0) -> Array:
        """p and E, times S(|origin|), at stretches x > `origin`; shape (2, n) for x of shape (n,)."""
        origin = np.broadcast_to(origin, x.shape)
        out = np.zeros((2, x.size))
        least = np.maximum(np.abs(x), np.abs(origin))
        live = np.flatnonzero(least <= self.top)
        if not live.size:
            return out
        x, origin, least = x[live], origin[live], least[live]
        if (origin == 0.0).all():
            spent, hazard = self._integrals(np.abs(x))
            before = np.zeros(x.size)
        else:  # many starts, few places
            spent, hazard, before = self.spent(np.abs(x)), self.hazard(np.abs(x)), self.spent(np.abs(origin))
        held = np.exp(np.minimum(np.sign(origin) * before - np.sign(x) * spent, _MOST))
        survival = self.law.sf(least)
        out[1, live] = survival * held
        out[0, live] = held * (survival * hazard + np.where(x > np.abs(origin), finite_density(self.law, x), 0.0))
        return out

    def grown(self, origins: Array, least: float, felt: float) -> tuple[Array, Array]:
        """L at each of `origins`, the same for all thresholds, and their weight."""
        return (np.sign(origins) * self._integrals(np.abs(origins))[0])[:, None], np.ones(1)

    def fan(self, x: Array, origins: Array, lowest: Array, least: Array) -> Array:
        """p, times S(|origin|), of contacts that stood at each of `origins`, at stretches x of shape (n,) above the
        least of them; no thresholds lie below |x| where x < 0. Shape (1, origins, n)."""
        before = np.exp(np.minimum(self.grown(origins, 0.0, 0.0)[0], _MOST))
        spent, hazard = self._integrals(np.abs(x))
        held = np.exp(np.minimum(-np.sign(x) * spent, _MOST))
        breaks = held * (self.law.sf(np.abs(x)) * hazard + np.where(x > 0.0, finite_density(self.law, x), 0.0))
        return (before * breaks)[None]

    def held(self, x: Array, threshold: Array, origin: Array) -> Array:
        """exp{-[L(x) - L(x_0)]}, whatever the threshold."""
        spent, before = self._integrals(np.abs(x))[0], self._integrals(np.abs(origin))[0]
        return np.exp(np.minimum(np.sign(origin) * before - np.sign(x) * spent, 0.0))

    def _integrals(self, x: Array) -> tuple[Array, Array]:
        """L and H/v at x >= 0."""
        many = self._shared.nodes.size + 32 if self._shared.even else 8 * (2 * self._panels.size + 100)
        chunk = max(1, _CHUNK // many)
        parts = [self._sums(x[i : i + chunk]) for i in range(0, x.size, chunk)]
        if not parts:
            return np.empty(0), np.empty(0)
        spent, hazard = np.concatenate(parts, axis=1) / self._velocity
        return spent, hazard

    def _sums(self, x: Array) -> Array:
        out = np.zeros((2, x.size))
        lowest, column = float(self._panels[0]), x[:, None]
        if self._panels.size > 1 and self._shared.even:
            # thresholds passed already count with all that they had cost
            panel = np.clip(np.searchsorted(self._panels, x, side="right") - 1, 0, self._panels.size - 2)
            begin = self._panels[panel]
            ends = begin, np.clip(x, begin, self._panels[panel + 1])
            nodes, weights = gauss(*ends)
            mass = self._weights(nodes, weights, *ends)
            nodes = np.where(nodes > 0.0, nodes, self.top)  # where x = 0 they carry none
            out[0] = self._before[panel] + self._add(np.arange(x.size), mass, nodes, nodes, x.size)[0]
            for row, mass, threshold in self._shared.above(np.maximum(x, lowest)):
                out += self._add(row, mass, column[row], threshold, x.size)
        elif self._panels.size > 1:
            # thresholds passed already count with all that they had cost
            low = np.minimum(lowest, column)
            panels = np.broadcast_to(self._panels, (x.size, self._panels.size))
            edges = np.concatenate([panels, low + (column - low) * _BELOW], axis=1)
            edges = np.sort(np.clip(edges, low, np.minimum(column, self.top)), axis=1)
            wide = edges[:, 1:] > np.maximum(edges[:, :-1], lowest * (1.0 - 1e-15))
            row = np.nonzero(wide)[0]
            if row.size:
                ends = edges[:, :-1][wide], edges[:, 1:][wide]
                nodes, weights = gauss(*ends)
                out[0] += self._add(row, self._weights(nodes, weights, *ends), nodes, nodes, x.size)[0]
            out += self._beyond(x, np.maximum(column, lowest), panels)
        for atom, weight in zip(self.atoms, self.atom_weights, strict=True):
            spent = np.exp(self._thermal.log_cumulative(np.minimum(x, atom), atom))
            below = x < atom
            out[0] += weight * spent
            out[1, below] += weight * np.exp(self._thermal.log_rate(x[below], atom))
        return out

    def _beyond(self, x: Array, least: Array, panels: Array) -> Array:
        """What thresholds not passed yet cost and their rate, up to barriers that none passes."""
        column = x[:, None]
        with np.errstate(divide="ignore"):
            stiff = self._square ** (2.0 / 3.0) / np.cbrt(np.maximum(least, 1e-300))
        far = np.sqrt(self._square)
        if not self._thermal.rates.vanishes_at_threshold:
            far = self._square / (np.sqrt(least**2 + self._square) + least)
        else:
            far = np.minimum(far, stiff)
        top = np.minimum(least + far, self.top)
        near = np.minimum(self._width, 0.125 * self._thermal.temperature / np.maximum(least, 1e-300))
        if self._thermal.rates.vanishes_at_threshold:  # beside thresholds as small as x the rate knows x/ξ alone
            near = np.minimum(near, 0.125 * np.maximum(least, 1e-9 * self._width))
        even = np.maximum(self._width, far / _ABOVE[-1])
        edges = np.concatenate([panels, least + near * _NEAR, least + even * _ABOVE, least], axis=1)
        edges = np.sort(np.clip(edges, least, np.maximum(top, least)), axis=1)
        roots = np.sqrt(edges - least)
        left, right = roots[:, :-1], roots[:, 1:]
        wide = right > left
        row = np.nonzero(wide)[0]
        if not row.size:
            return np.zeros((2, x.size))
        nodes, weights = gauss(left[wide], right[wide])
        thresholds = least[row] + nodes * nodes
        at = np.broadcast_to(column[row], thresholds.shape)
        ends = (least[row, 0] + edge * edge for edge in (left[wide], right[wide]))
        mass = self._weights(thresholds, 2.0 * nodes * weights, *ends)
        return self._add(row, mass, at, thresholds, x.size)

    def _add(self, row: npt.NDArray[np.intp], mass: Array, x: Array, threshold: Array, size: int) -> Array:
        rate, spent = self._thermal.per_length(x, threshold, np.zeros(1), 1.0, 1.0)
        sums = [part @ mass[0] if len(mass) == 1 else np.einsum("ij,ij->i", mass, part) for part in (spent, rate)]
        return np.stack([np.bincount(row, weights=one, minlength=size) for one in sums])
