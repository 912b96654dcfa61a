"""Greenwood and Williamson's contact: summits of one radius and random height under a rigid flat.

A summit of height h above the flat at h0 is compressed by delta = h - h0 and has the area pi r delta. An elastic one
bears (4/3) E* r^(1/2) delta^(3/2) (Hertz; the paper's Eq. GW1 prints 4 pi/3), a plastic one pi r delta H (Eq. GW2,
hardness times area). The two loads meet at one compression, and the areas are the same: nothing jumps there, neither
load nor threshold, but thresholds as a function of delta have a kink and P_c has a jump.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from origins.errors import InputError, finite, one_of, positive, refuse
from origins.roughness.material import Material
from origins.roughness.power_law import Bend, PowerLaw
from origins.roughness.spectral_moments import SpectralMoments
from origins.roughness.summits import (
    SummitThresholds,
    log_common_density,
    log_sum,
    log_touching_integral,
)
from origins.thresholds.families import Weibull
from origins.thresholds.law import Thresholds

_DEEPEST = 1e8  # of sigma_h: summits cover the surface long before
REGIMES = ("elastic", "plastic", "mixed")


def critical_compression(radius: float, contact_modulus: float, hardness: float) -> float:
    """Compression above which a summit is plastic, r (3 pi H/4E*)², where the elastic and plastic loads meet."""
    return float(radius * (0.75 * np.pi * hardness / contact_modulus) ** 2)


def plasticity_index(std: float, material: Material, radius: float) -> float | None:
    """psi = (E*/Y)(sigma_h/r)^(1/2), Y = H/3; None without a hardness.

    The paper prints (E/Y)(h_mean/r)^(1/2); Greenwood and Williamson's own, (E*/H)(sigma_h/r)^(1/2), is a third of
    ours. In ours the critical compression is sigma_h (9 pi/(4 psi))².
    """
    if material.hardness is None:
        return None
    return float(3.0 * material.contact_modulus / material.hardness * np.sqrt(std / radius))


@dataclass(frozen=True)
class Summits:
    """The summits of a surface and what they bear: lengths in m, `density` in 1/m², `load` N against m."""

    radius: float
    std: float
    density: float
    heights: str
    load: Bend

    @property
    def area(self) -> Bend:
        """Area of a contact against its compression, m² against m."""
        return self.load.each(lambda _: PowerLaw(np.pi * self.radius, 1.0))

    def log_mean(self, quantity: Bend, z: float) -> float:
        """log of <quantity> over all summits, those that do not touch counting as 0; z is h0/sigma_h."""
        return log_sum(quantity, self.std, z, self.heights) + log_common_density(z, self.heights)

    def pressure(self, z: float) -> float:
        """Nominal pressure in Pa where the flat is at z sigma_h."""
        with np.errstate(over="ignore"):
            return float(self.density * np.exp(self.log_mean(self.load, z)))

    def separation(self, pressure: float) -> float:
        """z = h0/sigma_h under a nominal pressure in Pa; Newton, which cannot fail.

        The logarithm of the load is concave in z and falls, so that after the first step the iterates come down on
        the root; one that goes back up is round-off.
        """
        goal = float(np.log(pressure) - np.log(self.density))
        # the load of a summit rises from 0 without a jump: its mean falls with z by the mean of its own slope
        slope_of_load = self.load.each(lambda law: PowerLaw(law.coefficient * law.exponent, law.exponent - 1.0))
        z = 0.0
        for count in range(200):
            value = self.log_mean(self.load, z)
            slope = -self.std * np.exp(self.log_mean(slope_of_load, z) - value)
            step = (value - goal) / slope
            z -= step
            if (count > 0 and step <= 1e-15 * abs(z)) or z < -_DEEPEST:
                break
        return z


def summits_of(moments: SpectralMoments, material: Material, regime: str, heights: str) -> Summits:
    """The summits that a surface's moments imply, loaded in a regime.

    Raises InputError for other names, and for a regime that needs the hardness where the material has none.
    """
    one_of("regime", regime, REGIMES)
    one_of("height_law", heights, ("gaussian", "exponential"))
    radius = moments.summit_radius
    hertz = PowerLaw(4.0 / 3.0 * material.contact_modulus * np.sqrt(radius), 1.5)
    if regime == "elastic":
        load = Bend(hertz, hertz, np.inf)
    else:
        hardness = material.hardness
        if hardness is None:
            why = f'regime = "{regime}" needs it; give the material one, such as hardness = 2e8 (Pa)'
            raise InputError(f"material.hardness = None: {why}")
        limit = critical_compression(radius, material.contact_modulus, hardness) if regime == "mixed" else 0.0
        load = Bend(hertz, PowerLaw(np.pi * radius * hardness, 1.0), limit)
    return Summits(radius, moments.summit_std, moments.summit_density, heights, load)


@dataclass(frozen=True)
class SummitContact:
    """Summits pressed together until the flat is at `z` sigma_h above their mean plane."""

    summits: Summits
    z: float

    def mean(self, quantity: Bend) -> float:
        """<quantity> over the contacts."""
        return float(np.exp(self._log_of(quantity) - self._touching))

    def _log_of(self, quantity: Bend) -> float:
        return log_sum(quantity, self.summits.std, self.z, self.summits.heights)

    @cached_property
    def _touching(self) -> float:
        return log_touching_integral(0.0, self.z, 0.0, np.inf, self.summits.heights)

    @property
    def separation(self) -> float:
        """Height of the flat above the summits' mean plane, m."""
        return float(self.z * self.summits.std)

    @property
    def contact_density(self) -> float:
        """Contacts per nominal area, 1/m²."""
        return float(self.summits.density * np.exp(self._touching + log_common_density(self.z, self.summits.heights)))

    @property
    def area_fraction(self) -> float:
        """Real over nominal area of contact."""
        return self.contact_density * self.mean(self.summits.area)

    def fraction_beyond(self, compression: float) -> float:
        """Fraction of the contacts that are compressed by more than this, in m."""
        start = compression / self.summits.std
        return float(np.exp(log_touching_integral(0.0, self.z, start, np.inf, self.summits.heights) - self._touching))

    def thresholds(self, threshold: Bend) -> Thresholds:
        """P_c where a contact compressed by delta breaks at threshold(delta)."""
        std, heights = self.summits.std, self.summits.heights
        if heights == "exponential" and len(threshold.pieces) == 1:
            # shape 4/3 is (GW3), shape 2 is (GW4)
            law = threshold.pieces[0][0]
            return Weibull(1.0 / law.exponent, law.coefficient ** (-1.0 / law.exponent) / std, 1.0 / law.exponent - 1.0)
        return SummitThresholds(threshold, std, self.z, heights)


def pressed(summits: Summits, pressure: float) -> SummitContact:
    """The summits under a nominal pressure (Pa).

    Exponential heights have mean and standard deviation sigma_h, begin at the plane h = 0, and give thresholds
    that do not depend on the load (paper, Eqs. GW3 and GW4).

    Raises InputError for a pressure that exponential heights cannot bear, and where the contacts would cover the
    whole surface: they are then no longer apart, as the model has them.
    """
    contact = SummitContact(summits, summits.separation(pressure))
    if summits.heights == "exponential" and contact.z < 0.0:
        refuse(
            "pressure",
            pressure,
            f"exponential heights bear at most {summits.pressure(0.0):.3g} Pa, where every summit touches; take "
            'height_law = "gaussian", or the thresholds of model = "persson"',
        )
    if contact.area_fraction >= 1.0:
        refuse("pressure", pressure, _covered(contact, "lower it"))
    return contact


def _covered(contact: SummitContact, remedy: str) -> str:
    return (
        f"summits would cover {contact.area_fraction:.3g} of the surface; Greenwood and Williamson hold for contacts "
        f'far apart, so {remedy}, or take the thresholds of model = "persson"; are heights and pixel size in metres, '
        "pressure and moduli in Pa?"
    )


def separation_of_pressure(
    moments: SpectralMoments,
    pressure: float,
    *,
    material: Material,
    regime: str = "elastic",
    height_law: str = "gaussian",
) -> float:
    """h0 in m, the height of the flat above the summits' mean plane, under a nominal pressure in Pa.

    moments, material, regime, height_law : as in from_moments.
    Raises InputError as from_moments does.
    """
    contact = pressed(summits_of(moments, material, regime, height_law), positive("pressure", pressure))
    return contact.separation


def pressure_of_separation(
    moments: SpectralMoments,
    separation: float,
    *,
    material: Material,
    regime: str = "elastic",
    height_law: str = "gaussian",
) -> float:
    """Nominal pressure in Pa that holds the flat at `separation`, in m above the summits' mean plane.

    moments, material, regime, height_law : as in from_moments.
    Raises InputError as from_moments does, for a flat below h = 0 under exponential heights, where every summit
    touches, and for one so high that the pressure is below what floating point holds.
    """
    summits = summits_of(moments, material, regime, height_law)
    z = finite("separation", separation) / summits.std
    if height_law == "exponential" and z < 0.0:
        refuse("separation", separation, 'exponential heights begin at 0, where every summit touches; write one above')
    contact = SummitContact(summits, z)
    if contact.area_fraction >= 1.0:
        refuse("separation", separation, _covered(contact, "raise it"))
    pressure = summits.pressure(z)
    if not pressure > 0.0:
        refuse("separation", separation, f"is {z:.3g} sigma_h, where no summit reaches; lower it")
    return pressure


def thresholds_of_compression(summits: Summits, material: Material, law: str) -> tuple[Bend, Bend]:
    """x_s in m and f_s in N against delta in m (paper, Eqs. GW1 and GW2); see rough_contact.from_topography.

    Raises InputError where x_s would fall or stay as delta grows: where k grows as f_s or faster than that.
    """
    area, load = summits.area, summits.load
    if law == "strength":
        force = area.each(lambda part: part.times(material.needed("shear_strength", law)))
    else:
        force = load.each(lambda part: part.times(material.needed("local_friction", law)))
    if law == "paper":
        coefficient = material.needed("force_coefficient", law)
        return force.each(lambda part: part.times(1.0 / coefficient).power(0.5)), force
    stiffness = material.stiffness(law)
    threshold = force.over(area.each(stiffness.after))
    for part, _, _ in threshold.pieces:
        if not part.exponent > 0.0:
            raise InputError(
                f"material.contact_stiffness: k ~ A^{stiffness.exponent:g} makes thresholds fall as a summit is "
                "pressed down, and their mean infinite; take one with k ~ A^(1/2), such as a column's by its aspect"
            )
    return threshold, force
