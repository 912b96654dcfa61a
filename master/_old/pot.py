"""Contacts born all through a hold: they share their stretch, and break each at a rate of its own."""

import numpy as np
import numpy.typing as npt

from master._old.wear import Keeper

Array = npt.NDArray[np.float64]


class Pot:
    """How many are left for each of the rates; none at first.

    again : arrays (n,)
        Stretches of births, and with each its weight over S(|r|).
    """

    def __init__(self, keeper: Keeper, again: tuple[Array, Array]) -> None:
        self._keeper, self._stretch = keeper, again[0]
        parts = [self._keeper.standing(float(x)) for x in again[0]]
        self._ends = np.cumsum([part.rate.size for part in parts])[:-1]
        self._rate = np.concatenate([part.rate for part in parts])
        self._held = np.concatenate([part.held * share for part, share in zip(parts, again[1], strict=True)])
        pulls = [part.stiff * (x * share) for part, x, share in zip(parts, *again, strict=True)]
        self._pull = np.concatenate(pulls)
        self._left, self._born = np.zeros(self._rate.size), 0.0

    def left(self, lasts: Array) -> tuple[Array, Array]:
        """What holds, and its force, so long after the births known."""
        left = self._left * np.exp(-lasts[:, None] * self._rate)
        return left @ self._held, left @ self._pull

    def young(self, age: Array) -> tuple[Array, Array]:
        """Share that holds at ages, and its force."""
        left = np.exp(-age[:, None] * self._rate)
        return left @ self._held, left @ self._pull

    def add(self, lasts: float, age: Array, births: Array) -> None:
        """After a time, with births of these ages at its end."""
        self._left = self._left * np.exp(-self._rate * lasts) + births @ np.exp(-age[:, None] * self._rate)
        self._born += float(births.sum())

    def merged(self) -> tuple[float, Array]:
        """All that were born, and what their wear keeps of one strand for each stretch that stands for them."""
        if self._born <= 0.0:
            return 0.0, np.empty(0)
        with np.errstate(divide="ignore"):
            spent = -np.log(np.clip(self._left / self._born, 0.0, 1.0))
        parts = np.split(spent, self._ends)
        kept = [self._keeper.kept(float(x), part) for x, part in zip(self._stretch, parts, strict=True)]
        return self._born, np.stack(kept)
