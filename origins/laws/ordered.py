"""Thresholds that change with age and distance, and keep their order: what solvers ask of them."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any, ClassVar, NamedTuple

import numpy as np

from origins.laws.timed_law import ChangingThresholds
from origins.thresholds.law import Array

# Parts of the longest age, and of the longest distance, at which the law is looked at; and what may be rounding there.
LOOKED_AT, ROUNDED = np.append(0.0, np.geomspace(1e-12, 1.0, 37)), 1e-9
# Shares of the contacts that are weaker than those that are looked at; and of those that are left out, as in solvers.
WEAKER, NEGLECTED = (0.01, 0.5, 0.99), 1e-17


class Trend(NamedTuple):
    """Whether some contacts weaken, and some strengthen, with the age and with the distance travelled."""

    weakens_with_age: bool
    strengthens_with_age: bool
    weakens_with_travel: bool
    strengthens_with_travel: bool


class OrderedThresholds(ChangingThresholds):
    """Thresholds that change with the age of a contact and the distance it has travelled, and keep their order.

    Of two contacts of one history the stronger stays the stronger, so that of those born together the ones are broken
    whose thresholds at birth are up to the largest `birth_threshold` that their history has had so far. A law states
    `law`, `at_start`, which is P_c of contacts as they form, too, and

    birth_threshold(x, age, travelled) : the threshold at birth of the contact that breaks at the stretch |x| = x, of
        this age (time) since its birth, after the slider has gone this distance, there and back (lengths); x, where
        both are 0. Three numbers, or arrays of one shape; shape of them. It does not fall with x. At one x it either
        rises with the age, where contacts weaken, or falls; and so with the distance. 0 where all hold, inf where none

    and, if thresholds grow, largest_threshold. The ensemble calls birth_threshold with single numbers, some fifty times
    a break: 0.05 ms, or 1 µs where it is a function compiled by numba.njit, which __init__ sets.
    """

    _stated_by: ClassVar[str] = "OrderedThresholds"

    def __repr__(self) -> str:
        """The class alone, as nothing is known here of a subclass's arguments."""
        return f"{type(self).__name__}(...)"

    @abstractmethod
    def birth_threshold(self, x: Any, age: Any, travelled: Any) -> Any:
        """See OrderedThresholds."""

    def largest_threshold(self, fresh: float, share: float, duration: float) -> float:
        """See ChangingThresholds: the largest at t = 0, where none grows."""
        return fresh

    def check_stated(self) -> None:
        """InputError for what is not stated, and where contacts are another than `at_start` says as they form."""
        super().check_stated()
        births = self.at_start.ppf(np.array(WEAKER))
        found = self._asked(births[:, None], np.zeros(1), np.zeros((2, 1, 1)))
        if (off := np.abs(found[0, :, 0] - births) > ROUNDED * births).any():
            x, y = births[off][0], found[0, :, 0][off][0]
            self._refuse(f"birth_threshold({x:.4g}, 0, 0) is {y:.4g}, and must be {x:.4g}")

    def trend(self, longest: float, furthest: float) -> Trend:
        """How contacts change up to this age and distance. InputError where birth_threshold is not what this class says
        of it, so that no solver follows a law that it would follow wrongly."""
        births = np.append(0.0, self.at_start.ppf(np.array(WEAKER)))
        ages, distances = longest * LOOKED_AT, furthest * LOOKED_AT
        found = self._asked(births[:, None, None], ages[:, None], distances)
        if (np.diff(found, axis=0) < -ROUNDED * found[:-1]).any():
            self._refuse("birth_threshold falls with x, and must not")
        trend = []
        for axis, name in ((1, "age"), (2, "distance travelled")):
            steps = np.diff(found, axis=axis) / self.at_start.mean()
            rises, falls = (steps > ROUNDED).any(axis=axis), (steps < -ROUNDED).any(axis=axis)
            if (rises & falls).any():
                fault = f"birth_threshold rises and falls with the {name} at one x"
                self._refuse(f"{fault}, and must do one")
            trend += [bool(rises.any()), bool(falls.any())]
        for birth in births[1:]:
            largest = self.largest_threshold(float(birth), NEGLECTED, longest)
            if (
                self._asked(np.full(1, largest), ages[:, None], distances) < birth * (1 - ROUNDED)
            ).any():
                fault = f"largest_threshold({birth:.4g}, ..., {longest:.4g}) is {largest:.4g}"
                self._refuse(f"{fault}, and by birth_threshold some are larger")
        return Trend(*trend)

    def _asked(self, x: Array, age: Array, travelled: Array) -> Array:
        """What birth_threshold gives, inf as a huge number; InputError where it fails, or is no number, or one of
        another shape."""
        given = [each.copy() for each in np.broadcast_arrays(x, age, travelled)]
        shape = given[0].shape
        rule = "birth_threshold must take arrays of one shape, and return that"
        try:
            with np.errstate(all="ignore"):
                found = np.asarray(self.birth_threshold(*given), dtype=float)
        except (TypeError, ValueError, IndexError, ArithmeticError) as error:
            said = " ".join(f"{type(error).__name__}: {error}".split())
            self._refuse(f"{rule}; for the shape {shape} it ends in {said}")
        if found.shape != shape:
            self._refuse(f"{rule}; for the shape {shape} it returns {found.shape}")
        if (bad := np.isnan(found) | (found < 0.0)).any():
            called = ", ".join(f"{each[bad][0]:.4g}" for each in given)
            rule = "must be from 0, where all hold, to inf, where none does"
            self._refuse(f"birth_threshold({called}) is {found[bad][0]:.4g}, and {rule}")
        return np.minimum(found, 1e300)
