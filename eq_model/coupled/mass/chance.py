"""What chance does to the force of few contacts in smooth sliding."""

import numpy as np

from origins import Contacts
from origins.thresholds.law import Array

# Standard deviations of the force from a maximum to a minimum, more than chance makes of it: with 6 some 3 slips were
# told in 1e6 loadings of 50 to 200 contacts that slid smoothly, with 5 some 20, and 8 hides slips of 100 contacts.
DEVIATIONS = 6.0
QUANTILES = 1024  # of the thresholds; rarer ones do not bear on the scatter of few contacts


def fall_by_chance(contacts: Contacts, n: int, speeds: Array) -> Array:
    """Largest fall of the force per N_c <k>, a length, that smooth sliding at these speeds makes by chance.

    Contacts that hold have stretches of density S(x)/<x_s>, and of all a share <x_s>/(<x_s> + v τ) holds. So a contact
    has the force <k x_s²>/2/(<x_s> + v τ) on average, and <k² x_s³>/3/(<x_s> + v τ) is the mean of its square. One
    contact more counts, for where few hold their number is far from normal. And all together hardly lose more than a
    mean threshold each by chance: of so few contacts each break is a slip.
    """
    x = contacts.thresholds.isf((np.arange(QUANTILES) + 0.5) / QUANTILES)
    k, mean = contacts.relative_stiffness(x), contacts.mean_threshold
    way = mean + np.abs(speeds) * contacts.waiting_time
    square = (k**2 * x**3).mean() / 3.0
    variance = square / way - (0.5 * (k * x**2).mean() / way) ** 2
    return np.minimum(DEVIATIONS * np.sqrt((variance + square / mean / n) / n), mean)
