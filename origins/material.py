"""What a rough contact is made of: its moduli, its strength and its local friction."""

from dataclasses import dataclass

from origins.errors import InputError, positive, refuse

_ONE_OF = "write shear_modulus (Pa), or density (kg/m³) and sound_velocity (m/s)"


@dataclass(frozen=True)
class Material:
    """Constants of the two bodies in contact, in SI units; what a threshold law does not need may be left out.

    Attributes
    ----------
    contact_modulus : float
        E* of Hertz' theory in Pa, 1/E* = (1 - nu_1²)/E_1 + (1 - nu_2²)/E_2; E/(2(1 - nu²)) for equal bodies.
    local_friction : float
        mu, the shear force at which one contact breaks per normal force it bears.
    shear_modulus : float
        G in Pa; a contact of area A has the stiffness k = G A^(1/2) (paper, Sec. II and App. A, G = rho c²).
        Mindlin's 8 a G* for equal bodies is 4/((2 - nu) pi^(1/2)) times that, 1.33 for nu = 0.3; k only sets the
        scale of x_s, and cancels from the friction coefficient.
    density, sound_velocity : float
        rho in kg/m³ and the transverse sound velocity c in m/s: another way of writing G = rho c².
    hardness : float
        H in Pa, about 3 Y; only for the plasticity index and the fraction of plastic contacts.
    shear_strength : float
        tau in Pa, f_s = tau A.
    force_coefficient : float
        c in Pa, f_s = c x_s² (the paper's law); G²/tau is its value where f_s = tau A and k = G A^(1/2).

    Raises InputError for a value not above zero, and where G is given both ways or only half of the second.
    """

    contact_modulus: float
    local_friction: float | None = None
    shear_modulus: float | None = None
    density: float | None = None
    sound_velocity: float | None = None
    hardness: float | None = None
    shear_strength: float | None = None
    force_coefficient: float | None = None

    def __post_init__(self) -> None:
        positive("contact_modulus", self.contact_modulus)
        for name in (
            "local_friction",
            "shear_modulus",
            "density",
            "sound_velocity",
            "hardness",
            "shear_strength",
            "force_coefficient",
        ):
            value = getattr(self, name)
            if value is not None:
                positive(name, value)
        if self.shear_modulus is not None and (self.density is not None or self.sound_velocity is not None):
            refuse("shear_modulus", self.shear_modulus, f"given twice; {_ONE_OF}")
        if (self.density is None) != (self.sound_velocity is None):
            name = "sound_velocity" if self.sound_velocity is None else "density"
            refuse(name, None, _ONE_OF)

    def needed(self, name: str, law: str) -> float:
        """The constant `name`, in SI units; InputError where it was left out though the threshold law needs it."""
        value = getattr(self, name)
        if name == "shear_modulus" and value is None and self.density is not None and self.sound_velocity is not None:
            value = self.density * self.sound_velocity**2
        if value is None:
            hint = _ONE_OF if name == "shear_modulus" else f"write Material(..., {name}=...)"
            raise InputError(f'material.{name} = None: law = "{law}" needs it; {hint}')
        return float(value)
