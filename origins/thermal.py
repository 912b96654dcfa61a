"""Thermally activated breaking: the rate h(x; x_s) of one contact, its integral and the inverse of that."""

from __future__ import annotations

from dataclasses import dataclass
from types import ModuleType
from typing import Literal

import numpy as np
import numpy.typing as npt

from origins import soft_contact, stiff_contact
from origins.errors import TEMPERATURE, InputError, positive, refuse

Array = npt.NDArray[np.float64]

_LAWS = {"soft": soft_contact, "stiff": stiff_contact}
_MOST_BEFORE = 50.0


@dataclass(frozen=True)
class Thermal:
    """Contacts also break below their threshold, at the rate h(x; x_s) per time (paper, Sec. IV).

        soft   h = ω exp[-κ (x_s² - x²) / 2T]                                         (Eqs. temper5, temper8)
        stiff  h = ω (1 - |x|/x_s)^(1/2) exp[-κ x_s² (1 - |x|/x_s)^(3/2) / 2T]        (Eqs. temper9, temper10)

    T is the temperature and κ = k_i/<k> the contact's relative stiffness: 1 where stiffness and threshold are
    independent, x_s/<x_s> where they are linked (origins.Contacts.relative_stiffness). The barrier of a relaxed
    contact is κ x_s²/2T in units of k_BT, so with linked stiffness it grows as x_s³, and T = k_BT/<k> is one number
    for all contacts while k_BT/k_i = T/κ is each contact's own.

    Attributes
    ----------
    law : "soft" or "stiff"
    temperature : float
        T = k_BT/<k>, a length squared; where thresholds come from a rough surface, of Interface.temperature(kelvin).
    attempt_frequency : float
        ω, per time.
    closure : "exact" or "paper"
        "exact": every contact breaks at its own rate. "paper": all break at H(x), the integral of h P_c over thresholds
        beyond x (Eqs. temper3, temper4), as if the weak ones had not broken before.

    Raises InputError unless temperature and attempt frequency are finite and above zero.

    The methods take arrays that broadcast: stretches x, thresholds x_s > 0 with |x| <= x_s, and the relative
    stiffness κ > 0; else InputError. Results have the broadcast shape; relative errors stay below 1e-12.
    """

    law: Literal["soft", "stiff"]
    temperature: float
    attempt_frequency: float = 1.0
    closure: Literal["exact", "paper"] = "exact"

    def __post_init__(self) -> None:
        if self.law not in ("soft", "stiff"):
            refuse("law", self.law, 'must be "soft" or "stiff"')
        if self.closure not in ("exact", "paper"):
            refuse("closure", self.closure, 'must be "exact" or "paper"')
        positive("temperature", self.temperature, TEMPERATURE)
        positive("attempt_frequency", self.attempt_frequency)

    def rate(self, x: npt.ArrayLike, threshold: npt.ArrayLike, stiffness: npt.ArrayLike = 1.0) -> Array:
        """h(x; x_s), per time."""
        return np.exp(self.log_rate(x, threshold, stiffness))

    def plain_rate(self, x: Array, threshold: Array, stiffness: Array | float = 1.0) -> Array:
        """h for sums over many contacts: not checked, arrays that broadcast; as it goes on where a soft contact's
        stretch exceeds its threshold."""
        stretch = np.abs(x) if self.law == "soft" else np.minimum(np.abs(x), threshold)
        with np.errstate(divide="ignore", invalid="ignore"):
            spring = np.asarray(stiffness) / (2.0 * self.temperature)
            log_rate = _LAWS[self.law].log_rate(stretch, threshold, spring)
            return np.asarray(self.attempt_frequency * np.exp(np.minimum(log_rate, _MOST_BEFORE)))

    def log_rate(self, x: npt.ArrayLike, threshold: npt.ArrayLike, stiffness: npt.ArrayLike = 1.0) -> Array:
        """ln h, finite where h underflows; -inf for a stiff contact at its threshold, where h = 0."""
        shape, (stretch, limit, spring) = self._prepare(threshold, stiffness, x=x)
        with np.errstate(divide="ignore", over="ignore"):
            out = _LAWS[self.law].log_rate(np.abs(stretch), limit, spring)
        return (np.log(self.attempt_frequency) + out).reshape(shape)[()]

    def cumulative(
        self,
        x: npt.ArrayLike,
        threshold: npt.ArrayLike,
        start: npt.ArrayLike = 0.0,
        stiffness: npt.ArrayLike = 1.0,
    ) -> Array:
        """Integral of h over the stretches between `start` and x, in either direction: A >= 0, a length per time.

        At a speed v a contact that holds at `start` still holds at x with the probability exp(-A/v).
        """
        return np.exp(self.log_cumulative(x, threshold, start, stiffness))

    def log_cumulative(
        self,
        x: npt.ArrayLike,
        threshold: npt.ArrayLike,
        start: npt.ArrayLike = 0.0,
        stiffness: npt.ArrayLike = 1.0,
    ) -> Array:
        """ln A, finite where A underflows; -inf where x = start, where A = 0."""
        shape, (stretch, begin, limit, spring) = self._prepare(threshold, stiffness, x=x, start=start)
        return self._log_between(stretch, begin, limit, spring).reshape(shape)[()]

    def _log_between(self, stretch: Array, begin: Array, limit: Array, spring: Array) -> Array:
        law, ends = _LAWS[self.law], (np.abs(stretch), np.abs(begin))
        across = (stretch < 0.0) != (begin < 0.0)
        with np.errstate(divide="ignore", over="ignore"):
            out = law.log_between(np.where(across, 0.0, np.minimum(*ends)), np.maximum(*ends), limit, spring)
            if across.any():
                near = np.minimum(*ends)[across]
                rest = law.log_between(np.zeros_like(near), near, limit[across], spring[across])
                out[across] = np.logaddexp(out[across], rest)
        return np.log(self.attempt_frequency) + out

    def per_length(
        self, x: Array, threshold: Array, start: Array, stiffness: Array | float, velocity: float
    ) -> tuple[Array, Array]:
        """h/v at x and A/v from `start` <= x on, for sums over many contacts: neither checked nor in logarithms.

        Arrays that broadcast, |x| and |start| at most the threshold. Errors of A/v stay below 1e-13 of 1 + A/v.
        """
        law, log_scale = _LAWS[self.law], float(np.log(self.attempt_frequency) - np.log(velocity))
        spring = np.asarray(stiffness) / (2.0 * self.temperature)
        rate, spent = law.grown(x, threshold, spring, log_scale)
        if not np.any(start):
            return rate, spent
        before = law.grown(start, threshold, spring, log_scale)[1]
        if np.abs(before).max(initial=0.0) < _MOST_BEFORE:
            return rate, spent - before
        # the difference of large numbers would be round-off
        return rate, np.exp(self.log_per_length(x, threshold, start, stiffness, velocity))

    def log_per_length(
        self, x: Array, threshold: Array, start: Array, stiffness: Array | float, velocity: float
    ) -> Array:
        """ln(A/v) of the same, finite where that underflows."""
        arrays = np.broadcast_arrays(x, start, threshold, np.asarray(stiffness) / (2.0 * self.temperature))
        return self._log_between(*arrays) - np.log(velocity)

    def inverse(
        self,
        amount: npt.ArrayLike,
        threshold: npt.ArrayLike,
        start: npt.ArrayLike = 0.0,
        stiffness: npt.ArrayLike = 1.0,
    ) -> Array:
        """Stretch x >= start at which A from `start` reaches `amount` >= 0; the threshold where it never does.

        At a speed v a contact breaks at inverse(v e, x_s, start) with e from the exponential law of mean 1. Backward
        motion is the mirror image: -inverse(amount, threshold, -start).
        """
        shape, (goal, begin, limit, spring) = self._prepare(threshold, stiffness, amount=amount, start=start)
        law = _LAWS[self.law]
        with np.errstate(divide="ignore", over="ignore"):
            log_amount = np.log(goal) - np.log(self.attempt_frequency)
            out = law.advance(log_amount, np.maximum(begin, 0.0), limit, spring)
            back = np.flatnonzero(begin < 0.0)
            if back.size:
                out[back] = _from_behind(law, log_amount[back], -begin[back], limit[back], spring[back])
        return out.reshape(shape)[()]

    def inverse_from_rest(self, log_amount: Array, threshold: Array, stiffness: Array) -> Array:
        """The same from x = 0 at ln A, for sums over many contacts: not checked; arrays that broadcast."""
        with np.errstate(divide="ignore", over="ignore", under="ignore"):
            goal, spring = log_amount - np.log(self.attempt_frequency), stiffness / (2.0 * self.temperature)
            return np.asarray(_LAWS[self.law].from_rest(goal, threshold, spring))

    def _prepare(
        self, threshold: npt.ArrayLike, stiffness: npt.ArrayLike, **more: npt.ArrayLike
    ) -> tuple[tuple[int, ...], list[Array]]:
        """The common shape, and flat: `more` in their order, the thresholds, k_i/(2 k_BT). All are checked."""
        named = {**more, "threshold": threshold, "stiffness": stiffness}
        try:
            arrays = np.broadcast_arrays(*(np.asarray(value, dtype=float) for value in named.values()))
        except (TypeError, ValueError) as error:
            raise InputError(f"{', '.join(named)}: must be numbers or arrays whose shapes fit: {error}") from error
        flat = dict(zip(named, (array.ravel() for array in arrays), strict=True))
        for name in ("threshold", "stiffness"):
            _check(name, flat[name], (flat[name] > 0.0) & np.isfinite(flat[name]), "must be finite and above zero")
        for name in more:
            if name == "amount":
                _check(name, flat[name], flat[name] >= 0.0, "must be zero or above")
            else:
                rule = f"a contact holds only where |{name}| is at most its threshold"
                _check(name, flat[name], np.abs(flat[name]) <= flat["threshold"], rule)
        spring = flat.pop("stiffness") / (2.0 * self.temperature)
        return arrays[0].shape, [*flat.values(), spring]


def _check(name: str, values: Array, good: npt.NDArray[np.bool_], rule: str) -> None:
    if not good.all():
        refuse(name, values[~good][0], rule)


def _from_behind(law: ModuleType, log_amount: Array, reached: Array, threshold: Array, spring: Array) -> Array:
    """Where a contact that starts at -reached < 0 and moves forward has spent the amount."""
    zero = np.zeros_like(reached)
    # against what the way up to x = 0 costs
    log_share = log_amount - law.log_between(zero, reached, threshold, spring)
    beyond = law.advance(log_amount + np.log(-np.expm1(-np.maximum(log_share, 0.0))), zero, threshold, spring)
    before = -law.retreat(np.minimum(log_share, 0.0), reached, threshold, spring)
    return np.where(log_share > 0.0, beyond, before)
