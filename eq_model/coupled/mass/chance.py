"""What chance does to the force of few contacts in smooth sliding."""

import numpy as np

from origins import Contacts
from origins.thresholds.law import Array

# Standard deviations of the force, above which a fall of it counts as more than chance makes. Measured with 50 to 200
# contacts that slid smoothly: with 6 some 3 slips were told in 1e6 loadings, with 5 some 20; 8 hides slips of 100.
DEVIATIONS = 6.0
QUANTILES = 1024  # of the thresholds; rarer ones do not bear on the scatter of few contacts


def fall_by_chance(contacts: Contacts, n: int, speeds: Array) -> Array:
    """Largest fall of the force per N_c <k>, a length, that smooth sliding at these speeds makes by chance.

    Contacts that hold have stretches of density S(x)/<x_s>, and of all a share <x_s>/(<x_s> + v τ) holds. So a contact
    has the force <k x_s²>/2/(<x_s> + v τ) on average, and <k² x_s³>/3/(<x_s> + v τ) is the mean of its square. One
    contact is counted beside those that hold, as where few do their number is far from normal. A mean threshold is the
    most: below some 20 contacts this hides slips in which the force falls by less, and the mean is of the larger ones.
    """
    x = contacts.thresholds.isf((np.arange(QUANTILES) + 0.5) / QUANTILES)
    k, mean = contacts.relative_stiffness(x), contacts.mean_threshold
    way = mean + np.abs(speeds) * contacts.waiting_time
    square = (k**2 * x**3).mean() / 3.0
    variance = square / way - (0.5 * (k * x**2).mean() / way) ** 2
    return np.minimum(DEVIATIONS * np.sqrt((variance + square / mean / n) / n), mean)
