"""The rate at which contacts break, for stretches of either sign and motion in either direction."""

from __future__ import annotations

from typing import Literal

import numpy as np
import numpy.typing as npt

from origins.errors import InputError, refuse
from origins.laws.rate_law import Array, RateLaw

# ln(h/ω): above it no contact holds, and its exponential times ω is still a number
_LARGEST = 50.0
_HALVINGS = 60  # of the way from -x_s to x_s: down to the last bit of x_s


class BreakingRate:
    """A RateLaw for solvers and users: extended to stretches of either sign, with checked arguments.

    Attributes
    ----------
    rates : RateLaw
        The law for stretches 0 <= x <= x_s.
    closure : "exact" or "paper"
        Whether each contact breaks at its own rate, or all at the mean one.

    Unless stated otherwise the methods take numbers or arrays that broadcast: stretches x and
    thresholds x_s > 0 with |x| <= x_s (lengths), and the relative stiffness κ = k_i/<k> > 0; else
    they raise InputError. Results have the common shape; relative errors stay below 1e-12.
    """

    rates: RateLaw
    closure: Literal["exact", "paper"]

    def rate(
        self, x: npt.ArrayLike, threshold: npt.ArrayLike, stiffness: npt.ArrayLike = 1.0
    ) -> Array:
        """h(x; x_s), per time."""
        return np.exp(self.log_rate(x, threshold, stiffness))

    def plain_rate(self, x: Array, threshold: Array, stiffness: Array | float = 1.0) -> Array:
        """h for sums over many contacts, not checked.

        Where |x| exceeds the threshold, a rate that does not vanish there is continued by its formula.
        """
        stretch = np.abs(x)
        if self.rates.vanishes_at_threshold:
            stretch = np.minimum(stretch, threshold)
        largest = _LARGEST + np.log(self.rates.scale)
        with np.errstate(divide="ignore", invalid="ignore"):
            log_rate = self.rates.log_rate(stretch, threshold, stiffness)
            return np.asarray(np.exp(np.minimum(log_rate, largest)))

    def log_rate(
        self, x: npt.ArrayLike, threshold: npt.ArrayLike, stiffness: npt.ArrayLike = 1.0
    ) -> Array:
        """ln h, finite where h underflows; -inf where h = 0, as for a stiff contact at x_s."""
        shape, (stretch, limit, spring) = _prepare(threshold, stiffness, x=x)
        return self.rates.log_rate(np.abs(stretch), limit, spring).reshape(shape)[()]

    def cumulative(
        self,
        x: npt.ArrayLike,
        threshold: npt.ArrayLike,
        start: npt.ArrayLike = 0.0,
        stiffness: npt.ArrayLike = 1.0,
    ) -> Array:
        """Integral A >= 0 of h over the stretches between `start` and x: a length per time.

        In either direction. At a speed v a contact that holds at `start` still holds at x with the
        probability exp(-A/v).
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
        shape, arrays = _prepare(threshold, stiffness, x=x, start=start)
        return self._log_between(*arrays).reshape(shape)[()]

    def _log_between(self, stretch: Array, begin: Array, limit: Array, stiffness: Array) -> Array:
        """ln of the integral between two stretches; arrays of one shape."""
        first, last = np.abs(stretch), np.abs(begin)
        near, far = np.minimum(first, last), np.maximum(first, last)
        across = (stretch < 0.0) != (begin < 0.0)
        out = self.rates.log_passed(np.where(across, 0.0, near), far, limit, stiffness)
        if across.any():
            rest = self.rates.log_passed(0.0, near[across], limit[across], stiffness[across])
            out[across] = np.logaddexp(out[across], rest)
        return out

    def inverse(
        self,
        amount: npt.ArrayLike,
        threshold: npt.ArrayLike,
        start: npt.ArrayLike = 0.0,
        stiffness: npt.ArrayLike = 1.0,
    ) -> Array:
        """Stretch x >= start at which A, integrated from `start`, reaches `amount` >= 0 (a length per time).

        The threshold where A stays below it. At a speed v a contact breaks at inverse(v e, x_s, start)
        with e from the exponential law of mean 1. Backward motion is the mirror image:
        -inverse(amount, threshold, -start).
        """
        shape, (goal, begin, limit, spring) = _prepare(
            threshold, stiffness, amount=amount, start=start
        )
        with np.errstate(divide="ignore"):
            log_amount = np.log(goal)
        out = self.rates.reached(log_amount, np.maximum(begin, 0.0), limit, spring)
        back = np.flatnonzero(begin < 0.0)
        if back.size:
            behind = log_amount[back], begin[back], limit[back], spring[back]
            out[back] = self._from_behind(*behind)
        return out.reshape(shape)[()]

    def _from_behind(self, log_amount: Array, begin: Array, limit: Array, spring: Array) -> Array:
        """Stretch at which A of contacts that move forward from begin < 0 reaches the amount, by halving."""
        low, high = begin, limit
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            short = self._log_between(middle, begin, limit, spring) < log_amount
            low, high = np.where(short, middle, low), np.where(short, high, middle)
        never = self._log_between(limit, begin, limit, spring) < log_amount
        return np.where(never, limit, low)


def _prepare(
    threshold: npt.ArrayLike, stiffness: npt.ArrayLike, **more: npt.ArrayLike
) -> tuple[tuple[int, ...], list[Array]]:
    """The common shape, and flat: `more` in their order, thresholds, stiffnesses; all checked."""
    named = {**more, "threshold": threshold, "stiffness": stiffness}
    try:
        arrays = np.broadcast_arrays(*(np.asarray(value, dtype=float) for value in named.values()))
    except (TypeError, ValueError) as error:
        told = f"{', '.join(named)}: must be numbers or arrays whose shapes fit: {error}"
        raise InputError(told) from error
    flat = dict(zip(named, (array.ravel() for array in arrays), strict=True))
    for name in ("threshold", "stiffness", *more):
        values = flat[name]
        good, rule = (values > 0.0) & np.isfinite(values), "must be finite and above zero"
        if name == "amount":
            good, rule = values >= 0.0, "must be zero or above"
        elif name in more:
            good = np.abs(values) <= flat["threshold"]
            rule = f"a contact holds only where |{name}| is at most its threshold"
        if not good.all():
            refuse(name, values[~good][0], rule)
    return arrays[0].shape, list(flat.values())
