"""Persson's contact: the stress of a rough surface, cut into patches of one area (paper, Sec. VI B)."""

from dataclasses import dataclass

import numpy as np
from scipy.special import erf

from origins.errors import refuse
from origins.material import Material
from origins.persson import persson
from origins.powered import Powered
from origins.spectral_moments import SpectralMoments
from origins.thresholds import Thresholds


@dataclass(frozen=True)
class StressedContact:
    """Normal stresses in the real contact: P(s) ~ exp[-((s-p)/D)²] - exp[-((s+p)/D)²], s > 0 (paper, Eq. PcPersson).

    `pressure` is p, `width` is D, both in Pa.
    """

    pressure: float
    width: float

    @property
    def area_fraction(self) -> float:
        """Real over nominal area of contact, erf(p/D): the norm of P(s), whose first moment is p itself."""
        return float(erf(self.pressure / self.width))

    def thresholds(self, scale: float, exponent: float) -> Thresholds:
        """The law of scale * s^exponent, exponent 1/2 (PcPersson3) or 1."""
        if exponent == 0.5:
            return persson(centre=scale * np.sqrt(self.pressure), width=scale * np.sqrt(self.width))
        root = np.sqrt(scale)
        return Powered(persson(centre=root * np.sqrt(self.pressure), width=root * np.sqrt(self.width)), 1.0, 2.0)


def stressed(moments: SpectralMoments, contact_modulus: float, pressure: float) -> StressedContact:
    """The surface under a nominal pressure (Pa); the width is E* h'_rms/2^(1/2) = E* m2^(1/2)."""
    return StressedContact(pressure=pressure, width=float(contact_modulus * np.sqrt(moments.m2)))


def power_of_stress(law: str, material: Material, patch_area: float) -> tuple[float, float]:
    """(a, b) of x_s = a s^b under a threshold law; see rough_contact.from_topography.

    Raises InputError for "strength": patches of one area would all break at one threshold.
    """
    if law == "strength":
        value = material.needed("shear_strength", law) * np.sqrt(patch_area) / material.needed("shear_modulus", law)
        refuse(
            "law",
            law,
            f"f_s = tau A is one value, {value:.3g} m, on Persson's patches of one area; write law='amontons', or "
            "model='gw', whose areas differ",
        )
    mu = material.needed("local_friction", law)
    if law == "amontons":
        return float(mu * np.sqrt(patch_area) / material.needed("shear_modulus", law)), 1.0
    return float(np.sqrt(mu * patch_area / material.needed("force_coefficient", law))), 0.5
