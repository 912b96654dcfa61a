"""The record of one interface, which converts from thresholds in metres to newtons and pascals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from origins.errors import InputError, non_negative, refuse
from origins.roughness.material import Material
from origins.roughness.moments import SpectralMoments
from origins.roughness.power_law import Array, Bend

BOLTZMANN = 1.380649e-23  # J/K, exact in the SI


@dataclass(frozen=True)
class Interface:
    """Physical state of a rough contact, in SI units; its thresholds have it as `.interface`.

    A force F per N_c<k>, a length, is the shear stress contact_density * mean_stiffness * F.

    model, law : "gw" or "persson"; "paper", "amontons" or "strength".
    material, moments : Material, and SpectralMoments with the step and the pixel size of their differences.
    pressure : nominal pressure, Pa.
    area_fraction : real over nominal area of contact.
    contact_density : contacts per nominal area, 1/m².
    mean_radius : <(A/pi)^(1/2)> over the contacts, m.
    mean_threshold, mean_stiffness, mean_force_threshold : over fresh contacts, <x_s> in m, <k> in N/m with
        k = f_s/x_s, and <f_s> in N.
    friction_coefficient : kinetic friction over load, N<k> F_k/pressure with F_k = <x_s²>/(2<x_s>), k_i independent of
        x_i (paper, Eq. Q6). Where k is proportional to x_s it is <f_s>/(2 <load>) exactly: half the sum of all
        thresholds. Number, load and <k> are those of the fresh interface; that sliding favours large thresholds is
        neglected.
    force_law : f_s in N as a law of x_s in m: force_threshold.
    plasticity_index : psi = (E*/Y)(sigma_h/r)^(1/2) with Y = H/3; None without a hardness. The paper's has E and the
        mean height of exponential summits; Greenwood and Williamson's, with H in place of Y, is a third of this one.
    plastic_fraction : gw: fraction of contacts compressed beyond r (3 pi H/4E*)², which are plastic in the regime
        "mixed"; all of them in the regime "plastic". persson: fraction of stresses above H. None without a hardness.
    hertz_plastic_fraction : the same if all contacts were elastic under this pressure, whatever the regime.
    regime : gw only, else "elastic": "elastic", "plastic" or "mixed".
    separation : gw only: height of the flat above the summits' mean plane, m; below zero where it lies beneath.
    patch_area : persson only: area of one contact, m².
    """

    model: str
    law: str
    material: Material
    moments: SpectralMoments
    pressure: float
    area_fraction: float
    contact_density: float
    mean_radius: float
    mean_threshold: float
    mean_stiffness: float
    mean_force_threshold: float
    friction_coefficient: float
    force_law: Bend
    plasticity_index: float | None
    plastic_fraction: float | None
    hertz_plastic_fraction: float | None
    regime: str = "elastic"
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
    def kinetic_stress(self) -> float:
        """Kinetic friction per nominal area, N<k> F_k with the density of contacts for N, Pa."""
        return self.friction_coefficient * self.pressure

    @property
    def mean_plane_separation(self) -> float | None:
        """gw only: height of the flat above the surface's own mean plane, m."""
        return None if self.separation is None else self.separation + self.moments.summit_offset

    def force_threshold(self, threshold: npt.ArrayLike) -> Array:
        """f_s in N of contacts that break at the stretches `threshold` in m; shape as given. Their k is f_s/x_s.

        Raises InputError for values that are no numbers, not finite or below zero.
        """
        lengths = np.asarray(threshold)
        if lengths.dtype.kind not in "iuf" or not (np.isfinite(lengths) & (lengths >= 0.0)).all():
            refuse("threshold", threshold, "must be a length in m, finite and zero or above")
        return self.force_law(lengths)

    def temperature(self, kelvin: float | None = None, energy: float | None = None) -> float:
        """k_BT/<k> in m², the temperature of a contact's laws, from `kelvin` (K) or from `energy` = k_BT (J).

        Raises InputError for both, for neither, and for values below zero.
        """
        if (kelvin is None) == (energy is None):
            raise InputError(f"kelvin = {kelvin}, energy = {energy}: write one of them")
        joules = BOLTZMANN * non_negative("kelvin", kelvin) if energy is None else energy
        return non_negative("energy", joules) / self.mean_stiffness

    @property
    def cautions(self) -> tuple[str, ...]:
        """Sentences about surface or load at the limits of the theory; empty where there are none."""
        moments, material, said = self.moments, self.material, list[str]()
        covered, radius, mu = self.area_fraction, self.mean_radius, self.friction_coefficient
        local, slope = material.local_friction or np.inf, moments.rms_slope
        uneven = np.sqrt(np.divide(max(moments.m2_axes), min(moments.m2_axes)))
        # without a scan, or without patches, there are no cautions about their size
        pixel = moments.pixel_size or (0.0, 0.0)
        size = (moments.size if moments.pixel_size else None) or (0.0, np.inf)
        point, scan = pixel[0] * pixel[1], size[0] * size[1] or np.inf
        patch, held = self.patch_area or point, self.contact_density * scan
        if np.inf > max(size) > 0.1:
            said.append(f"the scan is {max(size):.3g} m across: is the unit right?")
        if held < 1.0:
            said.append(f"the scan would hold {held:.2g} contacts: what they bear is extrapolated")
        if patch < point:
            said.append(f"patch_area = {patch:.3g} m² is below the {point:.3g} m² of a pixel")
        if patch > scan:
            said.append(f"patch_area = {patch:.3g} m² is above the {scan:.3g} m² of the scan")
        if covered > 0.1:
            theory = "neighbours are hardly independent, and in full contact none stands alone"
            said.append(f"contacts cover {covered:.0%} of the surface: {theory}")
        if slope > 0.5:
            said.append(f"rms slope is {slope:.2g}: are heights and pixel size in one unit?")
        if uneven > 1.5:
            said.append(f"slopes of the two axes differ by a factor {uneven:.2g}: not isotropic")
        if self.regime == "elastic" and (share := self.plastic_fraction or 0.0) > 0.01:
            said.append(f"{share:.0%} of the contacts would be plastic, and are taken as elastic")
        if self.regime == "plastic" and (share := self.hertz_plastic_fraction or 0.0) < 0.01:
            said.append(f"{share:.1%} would be plastic by Hertz' theory, and all are taken as such")
        if self.mean_threshold > radius:
            said.append(
                f"contacts slip after {self.mean_threshold:.2g} m, over their {radius:.2g} m"
            )
        # the scan need not resolve the area of Persson's patches
        if self.model == "gw" and radius < 2.0 * max(pixel):
            said.append(
                f"mean radius {radius:.2g} m is below 2 pixels: the scan does not resolve it"
            )
        if self.law != "strength" and mu > local:
            told = f"friction coefficient {mu:.2g} is above the local {local:.2g}"
            said.append(f"{told}: Eq. Q6 pairs k and x_s at random")
        return tuple(said)
