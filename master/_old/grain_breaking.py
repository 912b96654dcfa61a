"""Breaks at a steady speed of contacts whose thresholds grow with age, of all that stood at one stretch at X = 0.

Each keeps its quantile for life: of those that held at x_0 at the age a, exp{-[H(|x|, a + (x - x_0)/v) - H(|x_0|, a)]}
still hold, H the hazard of their law at that age, once it is more than it was at the start. It falls while a stretch
turns at 0, and where thresholds grow faster than it; then it rises once and for all.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
import numpy.typing as npt

from origins import Contacts, GrainContact, Thresholds
from origins.start import Start
from origins.thresholds.identical import Identical
from origins.thresholds.mixture import Mixture
from origins.thresholds.quadrature import panel_edges

Array = npt.NDArray[np.float64]

_BISECTIONS = 50
_SAME = 1e-13


class GrainBreaking:
    """p and E of contacts with `grains` at the speed v > 0 (length per time); the face of thermal_law.ThermalBreaking.

    Attributes
    ----------
    marks : array
        Stretches at which contacts from either end of the start, and from where that bends, begin to break.
    """

    linked = bends_at_zero = False
    error = 0.0
    atoms = atom_weights = panels = np.empty(0)

    def __init__(self, contacts: Contacts, velocity: float, start: Start | None = None) -> None:
        grains = contacts.grains
        if grains is None or grains.age is None:
            raise ValueError("contacts whose thresholds do not grow break at these")
        self.law: Thresholds = contacts.thresholds
        self._contacts, self._velocity, self._grains, self._age = contacts, velocity, grains, grains.age
        self._start = start = contacts.start if start is None else start
        self._low, self._high = start.span
        # the lowest are the oldest where they come to a stretch
        rested = self._age - grains.growth.first_pinning_time - self._low / velocity
        self.top = grains.breaking(velocity, max(rested, 0.0)).support()[1]
        ends = np.unique(np.concatenate([[self._low, self._high], start.breakpoints]))
        ends = ends[(ends >= self._low) & (ends <= self._high)]
        begins = ends + self.begins(ends)
        self.marks = np.unique(begins[begins > ends])

    def of(self, start: Start) -> GrainBreaking:
        """The same for contacts that stand at the stretches of `start`."""
        return self if start is self._start else GrainBreaking(self._contacts, self._velocity, start)

    def held(self, x: Array, threshold: Array, origin: Array) -> Array:
        """What has not broken before an exact value: there is none."""
        return np.ones(x.shape)

    @cached_property
    def overtaken(self) -> float:
        """Stretch beyond which thresholds grow faster than contacts are stretched, at first."""
        low, high = 0.0, self.law.support()[1]
        for _ in range(_BISECTIONS):
            middle = 0.5 * (low + high)
            falls = float(self._grains.rise(middle, self._age, self._velocity)) < 0.0
            low, high = (low, middle) if falls else (middle, high)
        return 0.5 * (low + high)

    def rows(self, x: Array, origin: Array | float = 0.0) -> Array:
        """p and E, times S(|origin|), at stretches x > `origin`; shape (2, n) for x of shape (n,)."""
        origin = np.broadcast_to(origin, x.shape)
        before, now, rise = self._hazards(x, origin)
        worst = np.maximum(now, before)
        live = worst < np.inf
        out = np.zeros((2, x.size))
        out[1, live] = np.exp(-worst[live])
        live &= (now * (1.0 + _SAME) + _SAME >= before) & (rise > 0.0) & (x > 0.0)
        out[0, live] = rise[live] * out[1, live]
        return out

    def _hazards(self, x: Array, origin: Array) -> tuple[Array, Array, Array]:
        """H at the start and now, and by how much it rises per length."""
        age = self._age + (x - origin) / self._velocity
        before, now = self._grains.hazard(np.abs(origin), self._age), self._grains.hazard(np.abs(x), age)
        return before, now, self._grains.rise(np.abs(x), age, self._velocity)

    def begins(self, origin: Array) -> Array:
        """Travel after which contacts from each stretch begin to break."""
        falls = (origin < 0.0) | ~(self._grains.rise(np.abs(origin), self._age, self._velocity) >= 0.0)
        if not falls.any():
            return np.zeros(origin.size)
        low, high = np.zeros(origin.size), np.full(origin.size, self.top) - origin
        for _ in range(_BISECTIONS):
            middle = 0.5 * (low + high)
            before, now, _ = self._hazards(origin + middle, origin)
            low, high = np.where(now > before, low, middle), np.where(now > before, middle, high)
        return np.where(falls, 0.5 * (low + high), 0.0)

    def bends(self, travel: Array) -> Array:
        """Stretches of the start beside which `rows` jumps at each travel, shape (n, 2): those that begin to break."""
        ends = [(min(self._high, 0.0), self._low), (max(self._low, 0.0), self._high)]
        out = np.empty((travel.size, 2))
        for column, (sooner, later) in enumerate(ends):
            if (later - sooner) * (1.0 if column else -1.0) <= 0.0:
                out[:, column] = sooner
                continue
            near, far = np.full(travel.size, sooner), np.full(travel.size, later)
            for _ in range(_BISECTIONS):
                middle = 0.5 * (near + far)
                before, now, _ = self._hazards(middle + travel, middle)
                near, far = np.where(now > before, middle, near), np.where(now > before, far, middle)
            out[:, column] = 0.5 * (near + far)
        return out


class BornGrains(Mixture):
    """The stretches at which contacts break that pin while they slide at a speed (length per time), as a law; those
    that never hold break at 0. `unit` (a length) is the mean of the others, which break by `law`; None: as they meet
    their thresholds."""

    def __init__(self, grains: GrainContact, velocity: float, law: Thresholds | None = None) -> None:
        cold = grains.breaking(velocity)
        law = cold if law is None else law
        lost = -float(np.expm1(-cold.lost_hazard))
        parts = [Identical(0.0), law] if lost else [law]
        super().__init__(parts, np.array([lost, cold.held_fraction])[-len(parts) :])
        self.unit = law.mean()
        self._panels = panel_edges(law)

    @property
    def panels(self) -> Array:
        return self._panels
