"""The material of a rough contact: moduli, strength, local friction, and its stiffness as a power of the area."""

from dataclasses import dataclass

import numpy as np

from origins.errors import InputError, between, finite, positive, refuse
from origins.roughness.power_law import PowerLaw

_ONE_OF = (
    "write shear_modulus (Pa), or density (kg/m³) and sound_velocity (m/s), or contact_stiffness"
)


@dataclass(frozen=True)
class Material:
    """Constants of the two bodies in contact, in SI units; those that the threshold law does not need may be left out.

    contact_modulus : E* of Hertz' theory in Pa, 1/E* = (1 - nu_1²)/E_1 + (1 - nu_2²)/E_2; E/(2(1 - nu²)) for equal
        bodies.
    local_friction : mu, the shear force at which one contact breaks over its normal force.
    shear_modulus : G in Pa; a contact of area A has the stiffness k = G A^(1/2) (paper, Sec. II, App. A, G = rho c²).
        Mindlin's 8 a G* for equal bodies is 4/((2 - nu) pi^(1/2)) times that, 1.33 for nu = 0.3.
    density, sound_velocity : rho in kg/m³ and the transverse sound velocity c in m/s, another way to give G = rho c².
    hardness : H in Pa, about 3 Y: the mean pressure of a plastic contact.
    shear_strength : tau in Pa, f_s = tau A.
    force_coefficient : c in Pa, f_s = c x_s² (the paper's law); G²/tau is its value where f_s = tau A and
        k = G A^(1/2).
    contact_stiffness : or k in N/m as a PowerLaw of A in m²: sound_stiffness, mindlin_stiffness, column_stiffness, or
        your own. The coefficient only sets the scale of x_s and cancels from the friction coefficient; P_c depends on
        the exponent.

    Raises InputError for a value not above zero, or not within 1e-20 to 1e20, and where k is given in two ways or only
    half of one.
    """

    contact_modulus: float
    local_friction: float | None = None
    shear_modulus: float | None = None
    density: float | None = None
    sound_velocity: float | None = None
    hardness: float | None = None
    shear_strength: float | None = None
    force_coefficient: float | None = None
    contact_stiffness: PowerLaw | None = None

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if name == "contact_modulus" or (value is not None and name != "contact_stiffness"):
                between(name, value, 1e-20, 1e20, "it is in SI units")
        law, speeds = self.contact_stiffness, (self.density, self.sound_velocity)
        if not (law is None or isinstance(law, PowerLaw)):
            refuse("contact_stiffness", law, "must be a law, such as mindlin_stiffness(...)")
        if law is not None and not 0.0 <= law.exponent <= 10.0:
            rule = "must lie between 0 and 10, such as 0.5"
            refuse("contact_stiffness.exponent", law.exponent, rule)
        if (law is not None) + (self.shear_modulus is not None) + (speeds != (None, None)) > 1:
            name = "shear_modulus" if law is None else "contact_stiffness"
            raise InputError(f"{name}: given twice; {_ONE_OF}")
        if speeds.count(None) == 1:
            refuse(("density", "sound_velocity")[speeds.index(None)], None, _ONE_OF)

    def needed(self, name: str, what: str) -> float:
        """The constant `name`, in SI units; InputError where it was left out though `what`, law or regime, needs it."""
        if (value := getattr(self, name)) is None:
            refuse(f"material.{name}", None, f"{what} needs it; give the material one, in SI units")
        return float(value)

    def stiffness(self, law: str) -> PowerLaw:
        """k in N/m as a power of the contact's area in m² under a threshold law.

        InputError where the material lacks a constant that the law needs. Not for the paper's law, whose k is c x_s.
        """
        if self.contact_stiffness is not None:
            return self.contact_stiffness
        if self.density is not None and self.sound_velocity is not None:
            return sound_stiffness(self.density, self.sound_velocity)
        if self.shear_modulus is None:
            raise InputError(f'material.shear_modulus = None: law = "{law}" needs it; {_ONE_OF}')
        return PowerLaw(self.shear_modulus, 0.5)

    def critical_compression(self, radius: float) -> float:
        """Compression above which a summit is plastic, r (3 pi H/4E*)², where the elastic and plastic loads meet; for a
        material with a hardness."""
        return float(radius * (0.75 * np.pi * (self.hardness or 0.0) / self.contact_modulus) ** 2)

    def plasticity_index(self, std: float, radius: float) -> float | None:
        """psi = (E*/Y)(sigma_h/r)^(1/2), Y = H/3; None without a hardness. Interface compares it with others' psi."""
        if self.hardness is None:
            return None
        return float(3.0 * self.contact_modulus / self.hardness * np.sqrt(std / radius))


def sound_stiffness(density: float, sound_velocity: float) -> PowerLaw:
    """k = rho c² A^(1/2) (paper, Sec. II); rho c² is the shear modulus.

    density in kg/m³ and transverse sound velocity in m/s, above zero; the law takes m² and gives N/m.
    Raises InputError otherwise.
    """
    speed = positive("sound_velocity", sound_velocity)
    return PowerLaw(positive("density", density) * speed**2, 0.5)


def mindlin_stiffness(
    shear_modulus: float | tuple[float, float], poisson_ratio: float | tuple[float, float]
) -> PowerLaw:
    """k = 8 a G*, a = (A/pi)^(1/2) the radius of a circular contact that does not slip (R. D. Mindlin, 1949).

    1/G* = (2 - nu_1)/G_1 + (2 - nu_2)/G_2.

    shear_modulus : G in Pa above zero, one number for two equal bodies or a pair.
    poisson_ratio : nu, above -1 and at most 1/2, one number or a pair.
    The law takes m² and gives N/m. Raises InputError otherwise.
    """
    pairs = []
    for name, value in (("shear_modulus", shear_modulus), ("poisson_ratio", poisson_ratio)):
        pairs.append(value if isinstance(value, tuple | list) else (value, value))
        if len(pairs[-1]) != 2:
            refuse(name, value, "must be one number for equal bodies, or a pair")
    compliance = 0.0
    for modulus, ratio in zip(*pairs, strict=True):
        if not -1.0 < finite("poisson_ratio", ratio) <= 0.5:
            refuse("poisson_ratio", ratio, "must be above -1 and at most 1/2, such as 0.3")
        compliance += (2.0 - ratio) / positive("shear_modulus", modulus)
    return PowerLaw(8.0 / compliance / float(np.sqrt(np.pi)), 0.5)


def column_stiffness(
    youngs_modulus: float, aspect: float | None = None, height: float | None = None
) -> PowerLaw:
    """k = (3 pi/4) E_c r_c (r_c/h)³ of a cylinder bent sideways (paper, Eqs. eq15 and eq15a).

    Its radius is r_c = (A/pi)^(1/2), its length h. This is a thin beam without shear and without the bodies'
    compliance: too stiff where r_c is not below h.

    youngs_modulus : E_c in Pa; 2 (1 + nu) rho c² in Eq. (eq15a).
    aspect : r_c/h, the same for every contact, so that k ~ A^(1/2). At aspect = 1 this is (3 pi^(1/2)/2) (1 + nu)
        times rho c² A^(1/2): 3.5 for nu = 0.3, where the paper writes ~.
    height : or h in m, the same for every contact, the thickness of the interface: then k ~ A².

    The law takes m² and gives N/m. Raises InputError for values not above zero, for both and for neither.
    """
    modulus = 0.75 * positive("youngs_modulus", youngs_modulus)
    if (aspect is None) == (height is None):
        rule = "give one of aspect and height, such as aspect = 1.0 for columns as long as wide"
        raise InputError(f"column_stiffness: {rule}")
    if aspect is not None:
        return PowerLaw(float(np.sqrt(np.pi)) * modulus * positive("aspect", aspect) ** 3, 0.5)
    return PowerLaw(modulus / np.pi / positive("height", height) ** 3, 2.0)
