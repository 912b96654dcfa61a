"""Shear stiffness of one contact as a power of its area, k = coefficient * A^exponent, by name (paper, App. A)."""

import numpy as np

from origins.errors import InputError, finite, positive, refuse
from origins.roughness.power_law import PowerLaw


def sound_stiffness(density: float, sound_velocity: float) -> PowerLaw:
    """k = rho c² A^(1/2) (paper, Sec. II); rho c² is the shear modulus.

    density in kg/m³ and transverse sound velocity in m/s, above zero; the law takes m² and gives N/m.
    Raises InputError otherwise.
    """
    return PowerLaw(
        positive("density", density) * positive("sound_velocity", sound_velocity) ** 2, 0.5
    )


def mindlin_stiffness(
    shear_modulus: float | tuple[float, float], poisson_ratio: float | tuple[float, float]
) -> PowerLaw:
    """k = 8 a G*, a = (A/pi)^(1/2) the radius of a circular contact that does not slip (R. D. Mindlin, 1949).

    1/G* = (2 - nu_1)/G_1 + (2 - nu_2)/G_2.

    shear_modulus : G in Pa above zero, one number for two equal bodies or a pair.
    poisson_ratio : nu, above -1 and at most 1/2, one number or a pair.
    The law takes m² and gives N/m. Raises InputError otherwise.
    """
    compliance = 0.0
    moduli, ratios = _both("shear_modulus", shear_modulus), _both("poisson_ratio", poisson_ratio)
    for (of_modulus, modulus), (of_ratio, value) in zip(moduli, ratios, strict=True):
        ratio = finite(of_ratio, value)
        if not -1.0 < ratio <= 0.5:
            refuse(of_ratio, value, "must be above -1 and at most 1/2, such as 0.3")
        compliance += (2.0 - ratio) / positive(of_modulus, modulus)
    return PowerLaw(8.0 / compliance / float(np.sqrt(np.pi)), 0.5)


def column_stiffness(
    youngs_modulus: float, aspect: float | None = None, height: float | None = None
) -> PowerLaw:
    """k = (3 pi/4) E_c r_c (r_c/h)³ of a cylinder bent sideways (paper, Eqs. eq15 and eq15a).

    Its radius is r_c = (A/pi)^(1/2), its length h.

    This is a thin beam without shear and without the bodies' compliance: too stiff where r_c is not below h.

    Parameters
    ----------
    youngs_modulus : float
        E_c in Pa; 2 (1 + nu) rho c² in Eq. (eq15a).
    aspect : float
        r_c/h, the same for every contact, so that k ~ A^(1/2). At aspect = 1 this is (3 pi^(1/2)/2) (1 + nu)
        times rho c² A^(1/2): 3.5 for nu = 0.3, where the paper writes ~.
    height : float
        Or h in m, the same for every contact, the thickness of the interface: then k ~ A².

    The law takes m² and gives N/m. Raises InputError for values not above zero, for both and for neither.
    """
    modulus = positive("youngs_modulus", youngs_modulus)
    if (aspect is None) == (height is None):
        raise InputError(
            "column_stiffness: give one of aspect and height, such as aspect = 1.0 for columns as long as wide"
        )
    if aspect is not None:
        return PowerLaw(
            0.75 * float(np.sqrt(np.pi)) * modulus * positive("aspect", aspect) ** 3, 0.5
        )
    return PowerLaw(0.75 / np.pi * modulus / positive("height", height) ** 3, 2.0)


def _both(name: str, value: object) -> list[tuple[str, object]]:
    """(name, value) for each of the two bodies."""
    if isinstance(value, tuple | list):
        if len(value) != 2:
            refuse(name, value, "must be one number for equal bodies, or a pair")
        return [(f"{name}[{i}]", one) for i, one in enumerate(value)]
    return [(name, value), (name, value)]
