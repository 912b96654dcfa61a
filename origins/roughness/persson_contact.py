"""Persson's contact: the stress of a rough surface, cut into patches of one area (paper, Sec. VI B)."""

import numpy as np

from origins.errors import refuse
from origins.roughness.material import Material
from origins.roughness.power_law import PowerLaw
from origins.roughness.spectral_moments import SpectralMoments
from origins.thresholds.families import persson
from origins.thresholds.law import Thresholds
from origins.thresholds.powered import Powered

_FURTHEST = 1e12  # pressure over width; a root of it is the furthest that persson() takes


def spread_of_stress(moments: SpectralMoments, contact_modulus: float, pressure: float) -> float:
    """D in Pa of the stresses P(s) ~ exp[-((s-p)/D)²] - exp[-((s+p)/D)²], s > 0 (paper, Eq. PcPersson), under p.

    It is E* h'_rms/2^(1/2) = E* m2^(1/2). The norm of P(s) is erf(p/D), the real over the nominal area of contact.
    Raises InputError for a pressure so far above it that all stresses are one value to round-off.
    """
    width = float(contact_modulus * np.sqrt(moments.m2))
    if pressure > _FURTHEST * width:
        refuse(
            "pressure",
            pressure,
            f"is over {_FURTHEST:g} times the spread of the stresses, {width:.3g} Pa: all patches bear it; lower it",
        )
    return width


def on_patches(pressure: float, width: float, threshold: PowerLaw) -> Thresholds:
    """P_c where a patch under the stress s breaks at threshold(s), exponent 1/2 (PcPersson3) or 1."""
    root = threshold.coefficient if threshold.exponent == 0.5 else np.sqrt(threshold.coefficient)
    law = persson(centre=root * np.sqrt(pressure), width=root * np.sqrt(width))
    return law if threshold.exponent == 0.5 else Powered(law, 1.0, 2.0)


def thresholds_of_stress(
    law: str, material: Material, patch_area: float
) -> tuple[PowerLaw, PowerLaw]:
    """x_s in m and f_s in N against the stress in Pa, under a threshold law; see rough_contact.from_topography.

    Raises InputError for "strength": patches of one area would all break at one threshold.
    """
    if law == "strength":
        value = (
            material.needed("shear_strength", law)
            * patch_area
            / float(material.stiffness(law)(patch_area))
        )
        refuse(
            "law",
            law,
            f"f_s = tau A is one value, {value:.3g} m, on Persson's patches of one area; write law = 'amontons', or "
            "model = 'gw', whose areas differ",
        )
    force = PowerLaw(material.needed("local_friction", law) * patch_area, 1.0)
    if law == "amontons":
        return force.times(1.0 / float(material.stiffness(law)(patch_area))), force
    return force.times(1.0 / material.needed("force_coefficient", law)).power(0.5), force
