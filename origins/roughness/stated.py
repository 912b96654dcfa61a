"""Stiffness and number of contacts in SI units: what turns thresholds in metres into newtons, kelvin and pascals."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from origins.errors import InputError, non_negative, positive
from origins.thresholds.law import Array

BOLTZMANN = 1.380649e-23  # J/K, exact in the SI


class InSI:
    """Conversions of an interface with `mean_stiffness`, <k> in N/m, and `contact_density` in 1/m².

    A force F per N_c<k>, a length, is the shear stress contact_density * mean_stiffness * F.
    """

    mean_stiffness: float
    contact_density: float | None

    def temperature(self, kelvin: float | None = None, energy: float | None = None) -> float:
        """k_BT/<k> in m², the temperature of a contact's laws, from `kelvin` (K) or from `energy` = k_BT (J).
        Raises InputError for both, for neither, and for values below zero."""
        if (kelvin is None) == (energy is None):
            raise InputError(f"kelvin = {kelvin}, energy = {energy}: write one of them")
        joules = BOLTZMANN * non_negative("kelvin", kelvin) if energy is None else energy
        return non_negative("energy", joules) / self.mean_stiffness

    def per_area(self, shared: npt.ArrayLike) -> Array:
        """Forces F/(N_c<k>) in m as shear stresses in Pa, or springs K/(N_c<k>) as K per nominal area in N/m³; shape as
        given. Raises InputError where the contact density is not known."""
        if self.contact_density is None:
            hint = "needs the number of contacts per nominal area; give contact_density, in 1/m²"
            raise InputError(f"contact_density = None: a force per area {hint}")
        return self.contact_density * self.mean_stiffness * np.asarray(shared, float)

    def newtons(self, shared: npt.ArrayLike, area: float) -> Array:
        """Forces F/(N_c<k>) in m on a nominal `area` in m² in N, or springs K/(N_c<k>) in N/m; shape as given. Raises
        InputError for an area that is not above zero, and as `per_area` does."""
        return positive("area", area) * self.per_area(shared)


@dataclass(frozen=True)
class StatedInterface(InSI):
    """The interface of contacts whose thresholds, in metres, are no rough surface's, as its user states it.

    mean_stiffness : <k> of a contact, N/m
    contact_density : contacts per nominal area, 1/m²; None: not known, so that there are kelvins, but no newtons
    pressure : nominal, Pa; None: not known, so that there are no friction coefficients
    Raises InputError for values that are not above zero.
    """

    mean_stiffness: float
    contact_density: float | None = None
    pressure: float | None = None

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if name == "mean_stiffness" or value is not None:
                positive(name, value)
