"""What joins a threshold law in metres to newtons and pascals: the record of one interface."""

from dataclasses import dataclass

from origins.material import Material
from origins.spectral_moments import SpectralMoments


@dataclass(frozen=True)
class Interface:
    """Physical state of a rough contact, carried by its thresholds as `.interface`; SI units.

    A force F per N_c<k>, a length, is the shear stress contact_density * mean_stiffness * F.

    Attributes
    ----------
    model, law : str
        "gw" or "persson"; "paper", "amontons" or "strength".
    material : Material
    moments : SpectralMoments
        Of the surface, with the step and the pixel size they were taken at.
    pressure : float
        Nominal pressure, Pa.
    area_fraction : float
        Real over nominal area of contact.
    contact_density : float
        Contacts per nominal area, 1/m².
    mean_stiffness : float
        <k> over fresh contacts, k = f_s/x_s, N/m.
    friction_coefficient : float
        Kinetic friction over load, N<k> F_k/pressure with F_k = <x_s²>/(2<x_s>), k_i independent of x_i (paper,
        Eq. Q6). Where k is proportional to x_s it is <f_s>/(2 <load>) exactly: half the sum of all thresholds.
        Number, load and <k> are those of the fresh interface; sliding favours large thresholds, which is left out.
    plasticity_index : float or None
        psi = (E*/Y)(sigma_h/r)^(1/2) with Y = H/3; None without a hardness. Thresholds are those of elastic
        contacts at any psi.
    plastic_fraction : float or None
        Fraction of contacts whose elastic solution exceeds the hardness: compression above r (3 pi H/4E*)² (gw),
        stress above H (persson). None without a hardness.
    separation : float or None
        gw only: height of the flat above the summits' mean plane, m; below zero where it lies beneath.
    patch_area : float or None
        persson only: area of one contact, m².
    """

    model: str
    law: str
    material: Material
    moments: SpectralMoments
    pressure: float
    area_fraction: float
    contact_density: float
    mean_stiffness: float
    friction_coefficient: float
    plasticity_index: float | None
    plastic_fraction: float | None
    separation: float | None = None
    patch_area: float | None = None

    @property
    def mean_load(self) -> float:
        """Normal force on a contact, N."""
        return self.pressure / self.contact_density

    @property
    def mean_area(self) -> float:
        """Area of a contact, m²."""
        return self.area_fraction / self.contact_density

    @property
    def mean_plane_separation(self) -> float | None:
        """gw only: height of the flat above the surface's own mean plane, m."""
        return None if self.separation is None else self.separation + self.moments.summit_offset
