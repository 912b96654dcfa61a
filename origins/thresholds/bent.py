"""Thresholds that follow one power of another law's variable below a point, and another beyond it."""

import numpy as np

from origins.roughness.power_law import Bend
from origins.thresholds.law import Array, Thresholds
from origins.thresholds.powered import Powered


class Bent(Powered):
    """The law of bend(y), y from `base`, whose support begins at 0; both parts of the bend rise and meet.

    The density jumps where they meet, by the quotient of the two exponents: that is a breakpoint. Where only one
    part holds there is none.
    """

    def __init__(self, base: Thresholds, bend: Bend) -> None:
        (first, _, at), *_ = bend.pieces
        super().__init__(base, first.coefficient, first.exponent)
        self.bend = bend
        self._above, self._at = bend.above, at
        self._mark = float(first(at)) if at < np.inf else np.inf

    @property
    def breakpoints(self) -> Array:
        marks = super().breakpoints
        return marks if self._mark == np.inf else np.unique(np.append(marks, self._mark))

    def _forward(self, y: Array) -> Array:
        y = np.asarray(y, dtype=float)
        out, beyond = np.asarray(super()._forward(y)), y > self._at
        return np.where(beyond, self._above(y), out) if beyond.any() else out

    def _back(self, x: Array) -> Array:
        out, beyond = super()._back(x), x > self._mark
        if beyond.any():
            with np.errstate(over="ignore"):
                out = np.where(
                    beyond, (x / self._above.coefficient) ** (1.0 / self._above.exponent), out
                )
        return out

    def _log_slope(self, x: Array) -> Array:
        out, beyond = super()._log_slope(x), x > self._mark
        if beyond.any():
            scale, exponent = self._above.coefficient, self._above.exponent
            out = np.where(
                beyond, (1.0 / exponent - 1.0) * np.log(x / scale) - np.log(exponent * scale), out
            )
        return out
