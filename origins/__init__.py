"""What one contact is and what is asked of it: thresholds, where they come from, starts, the drive."""

from origins.contacts import Contacts
from origins.drive import Drive
from origins.errors import InputError
from origins.gaussian import gaussian
from origins.identical import identical
from origins.lubricated import lubricated
from origins.mixture import mixture
from origins.persson import persson
from origins.rectangular import rectangular
from origins.start import Start, gaussian_start
from origins.thresholds import Thresholds
from origins.weibull import gw_elastic, gw_plastic

__all__ = [
    "Contacts",
    "Drive",
    "InputError",
    "Start",
    "Thresholds",
    "gaussian",
    "gaussian_start",
    "gw_elastic",
    "gw_plastic",
    "identical",
    "lubricated",
    "mixture",
    "persson",
    "rectangular",
]
