"""Contacts with stretches of a given law: their thresholds follow P_c conditional on x_s > |x|."""

import numpy as np

from origins.errors import InputError
from origins.start import Start
from origins.thresholds.law import Array, Thresholds

_CUT_LIMIT = 1e-6
_LEAST_SURVIVAL = 1e-300


class Births:
    """Stretches from `law`, each with a threshold from P_c conditional on x_s > |x|.

    This is the state of the contacts that hold at X = 0, and of broken contacts as they re-form.

    Attributes
    ----------
    law : Start
        Of the stretches (lengths): `is_single` and `mean()`, or density and quantiles.
    thresholds : Thresholds
        P_c.
    cut_weight : float
        Weight of the law beyond every threshold, which is cut off; 0 by default.

    Raises InputError, with `name` in its message, where this weight is above 1e-6: such contacts cannot hold.
    """

    def __init__(self, name: str, law: Start, thresholds: Thresholds) -> None:
        self.law, self.thresholds = law, thresholds
        self.cut_weight, reach = self._weight_beyond()
        if self.cut_weight > _CUT_LIMIT:
            beyond = f"beyond every threshold, at |x| >= {reach:.6g}; use stretches below it"
            raise InputError(f"{name}: a weight of {self.cut_weight:.3g} lies {beyond}")

    def draw(self, size: int, generator: np.random.Generator) -> tuple[Array, Array]:
        """Independent stretches and thresholds (lengths), shapes (size,); those beyond every threshold drawn again."""
        upper = self.thresholds.support()[1]
        if self.law.is_single:
            x = np.full(size, self.law.mean())
        else:
            x = self.law.ppf(generator.random(size))
            while (beyond := np.flatnonzero(np.abs(x) >= upper)).size:
                x[beyond] = self.law.ppf(generator.random(beyond.size))
        held = np.abs(x)
        left = self.thresholds.sf(held) * (1.0 - generator.random(size))
        return x, np.maximum(self.thresholds.isf(left), held)

    def _weight_beyond(self) -> tuple[float, float]:
        """Weight of |x| at which the survival of thresholds is 0 or below 1e-300, and the least such |x|."""
        upper = self.thresholds.support()[1]
        if float(self.thresholds.sf(max(abs(end) for end in self.law.span))) > 0.0:
            return 0.0, upper
        if not np.isfinite(upper):
            upper = float(self.thresholds.isf(_LEAST_SURVIVAL))
        if self.law.is_single:
            return 1.0, upper
        return float(self.law.cdf(-upper) + self.law.sf(upper)), upper
