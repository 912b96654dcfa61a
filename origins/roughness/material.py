"""The material of a rough contact: moduli, strength and local friction."""

from dataclasses import dataclass

from origins.errors import InputError, between, refuse
from origins.roughness.power_law import PowerLaw

_ONE_OF = (
    "write shear_modulus (Pa), or density (kg/m³) and sound_velocity (m/s), or contact_stiffness, a law of the area: "
    "sound, mindlin, column or a power of your own"
)
_LARGEST = 1e20  # of any constant, in SI units
_STEEPEST = 10.0  # of k against A: a bent column of one height has 2
# examples of values for messages
_SUCH_AS = {
    "local_friction": "0.4",
    "hardness": "2e8 (Pa)",
    "shear_strength": "5e7 (Pa)",
    "force_coefficient": "2.4e10 (Pa)",
}


@dataclass(frozen=True)
class Material:
    """Constants of the two bodies in contact, in SI units; those that the threshold law does not need may be left out.

    Attributes
    ----------
    contact_modulus : float
        E* of Hertz' theory in Pa, 1/E* = (1 - nu_1²)/E_1 + (1 - nu_2²)/E_2; E/(2(1 - nu²)) for equal bodies.
    local_friction : float
        mu, the shear force at which one contact breaks over its normal force.
    shear_modulus : float
        G in Pa; a contact of area A has the stiffness k = G A^(1/2) (paper, Sec. II and App. A, G = rho c²).
        Mindlin's 8 a G* for equal bodies is 4/((2 - nu) pi^(1/2)) times that, 1.33 for nu = 0.3.
    density, sound_velocity : float
        rho in kg/m³ and the transverse sound velocity c in m/s: another way of writing G = rho c².
    hardness : float
        H in Pa, about 3 Y: the mean pressure of a plastic contact.
    shear_strength : float
        tau in Pa, f_s = tau A.
    force_coefficient : float
        c in Pa, f_s = c x_s² (the paper's law); G²/tau is its value where f_s = tau A and k = G A^(1/2).
    contact_stiffness : PowerLaw
        Or k in N/m as a power of A in m²: sound_stiffness, mindlin_stiffness, column_stiffness, or your own. The
        coefficient only sets the scale of x_s and cancels from the friction coefficient; P_c depends on the exponent.

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
                between(name, value, 1.0 / _LARGEST, _LARGEST, "it is in SI units")
        own, speeds = self.contact_stiffness, (self.density, self.sound_velocity)
        if own is not None and not isinstance(own, PowerLaw):
            refuse("contact_stiffness", own, "must be a law, such as mindlin_stiffness(...)")
        if own is not None and not 0.0 <= own.exponent <= _STEEPEST:
            rule = f"must lie between 0 and {_STEEPEST:g}, such as 0.5"
            refuse("contact_stiffness.exponent", own.exponent, rule)
        ways = own is not None, self.shear_modulus is not None, speeds != (None, None)
        if sum(ways) > 1:
            name = "contact_stiffness" if own is not None else "shear_modulus"
            raise InputError(f"{name}: given twice; {_ONE_OF}")
        if speeds.count(None) == 1:
            refuse(("density", "sound_velocity")[speeds.index(None)], None, _ONE_OF)

    def needed(self, name: str, what: str) -> float:
        """The constant `name`, in SI units; InputError where it was left out though `what`, law or regime, needs it."""
        value = getattr(self, name)
        if value is None:
            such = f"{name} = {_SUCH_AS[name]}"
            raise InputError(
                f"material.{name} = None: {what} needs it; give the material one, such as {such}"
            )
        return float(value)

    def stiffness(self, law: str) -> PowerLaw:
        """k in N/m as a power of the contact's area in m² under a threshold law.

        InputError where the material lacks a constant that the law needs. Not for the paper's law, whose k is c x_s.
        """
        if self.contact_stiffness is not None:
            return self.contact_stiffness
        if self.density is not None and self.sound_velocity is not None:
            return PowerLaw(self.density * self.sound_velocity**2, 0.5)
        if self.shear_modulus is None:
            raise InputError(f'material.shear_modulus = None: law = "{law}" needs it; {_ONE_OF}')
        return PowerLaw(self.shear_modulus, 0.5)
