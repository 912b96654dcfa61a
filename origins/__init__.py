"""What one contact is and what is asked of it: thresholds, where they come from, starts, the drive."""

from origins.contacts import Contacts
from origins.drive import Drive
from origins.errors import InputError
from origins.gaussian import gaussian
from origins.identical import identical
from origins.interface import Interface
from origins.lubricated import lubricated
from origins.material import Material
from origins.mixture import mixture
from origins.persson import persson
from origins.rectangular import rectangular
from origins.rough_contact import from_topography, resolution_study
from origins.samples import from_samples
from origins.self_affine import self_affine_surface
from origins.spectral_moments import SpectralMoments, spectral_moments
from origins.start import Start, gaussian_start
from origins.thresholds import Thresholds
from origins.weibull import gw_elastic, gw_plastic

__all__ = [
    "Contacts",
    "Drive",
    "InputError",
    "Interface",
    "Material",
    "SpectralMoments",
    "Start",
    "Thresholds",
    "from_samples",
    "from_topography",
    "gaussian",
    "gaussian_start",
    "gw_elastic",
    "gw_plastic",
    "identical",
    "lubricated",
    "mixture",
    "persson",
    "rectangular",
    "resolution_study",
    "self_affine_surface",
    "spectral_moments",
]
