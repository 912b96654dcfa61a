"""Contacts: what one contact is, and how all of them stand at X = 0."""

import numpy as np

from origins.errors import InputError, refuse
from origins.frozen import as_thresholds
from origins.start import as_start

_CUT_LIMIT = 1e-6
_UNIT = "powers of these lengths are beyond floating point; choose another unit of length"
_LEAST_SURVIVAL = 1e-300


class Contacts:
    """Contacts that break at random thresholds and re-form at once at x = 0.

    Parameters
    ----------
    thresholds : Thresholds or frozen scipy.stats distribution on x >= 0
        Law P_c(x) of fresh thresholds (a length).
    start : None, float, Start or frozen scipy.stats distribution
        Stretches at X = 0, of contacts that hold; None: all relaxed, x = 0. A contact that starts at x has a
        threshold from P_c conditional on x_s > |x|.

    Attributes
    ----------
    mean_threshold : float
        <x_s>, the unit in which tolerances are stated.
    interface : Interface or None
        Load, contact density, <k> and friction in SI units, where the thresholds come from a rough surface.
    cut_weight : float
        Starting weight that lay beyond every threshold and was cut off; 0 unless said.

    Raises InputError where more than 1e-6 of the start lies beyond every threshold: such contacts hold nothing.
    """

    def __init__(self, thresholds: object, start: object = None) -> None:
        self.thresholds = as_thresholds(thresholds)
        self.interface = self.thresholds.interface
        self.start = as_start(start)
        try:
            self.mean_threshold = self.thresholds.mean()
        except (OverflowError, ZeroDivisionError) as error:
            raise InputError(f"thresholds: {_UNIT}") from error
        if np.isfinite(self.mean_threshold) and not 1e-150 < self.mean_threshold < 1e150:
            raise InputError(f"thresholds: the mean is {self.mean_threshold:.3g}: {_UNIT}")
        if not np.isfinite(self.mean_threshold):
            raise InputError(
                f"thresholds: the mean threshold is {self.mean_threshold}; with an infinite mean contacts never reach "
                "a steady state"
            )
        self.cut_weight, reach = self._weight_beyond()
        if self.cut_weight > _CUT_LIMIT:
            raise InputError(
                f"start: a weight of {self.cut_weight:.3g} lies beyond every threshold, at |x| >= {reach:.6g}; start "
                "from stretches below it"
            )

    def _weight_beyond(self) -> tuple[float, float]:
        """Starting weight where no threshold is left, or fewer than floating point can tell; and where that begins."""
        upper = self.thresholds.support()[1]
        furthest = max(abs(end) for end in self.start.span)
        if float(self.thresholds.sf(furthest)) > 0.0:
            return 0.0, upper
        if not np.isfinite(upper):
            upper = float(self.thresholds.isf(_LEAST_SURVIVAL))
        if self.start.is_single:
            return 1.0, upper
        return float(self.start.cdf(-upper) + self.start.sf(upper)), upper


def check_contacts(contacts: object) -> None:
    """Raise InputError for anything but Contacts, such as thresholds alone."""
    if not isinstance(contacts, Contacts):
        refuse("contacts", contacts, "must be contacts, such as origins.Contacts(origins.gaussian(mean=1.0, std=0.05))")
