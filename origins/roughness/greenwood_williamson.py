"""Greenwood and Williamson's contact: summits of one radius and random height under a rigid flat (paper, Sec. VI A).

A summit of height h under a flat at h0 < h is compressed by delta = h - h0 and has the area pi r delta. An elastic one
carries (4/3) E* r^(1/2) delta^(3/2) (Hertz; the paper's Eq. GW1 prints 4 pi/3), a plastic one pi r delta H (Eq. GW2,
hardness times area). Where both loads are equal, the threshold as a function of delta has a kink and P_c has a jump.
"""

from functools import lru_cache

import numpy as np
import scipy

from origins.errors import between, finite, one_of, refuse
from origins.roughness.interface import Material
from origins.roughness.moments import SpectralMoments
from origins.thresholds.families import Weibull
from origins.thresholds.gaussian import gaussian
from origins.thresholds.law import Thresholds
from origins.thresholds.powered import Bend, Powered, straight

REGIMES = ("elastic", "plastic", "mixed")


class Summits:
    """The summits that a surface's moments imply, and the load in N of one as a law of its compression in m.

    z, in sigma_h, is the height of the flat above the summits' mean plane. Exponential heights have the standard
    deviation sigma_h, and begin at sigma_h below that plane, at their lower end. Raises InputError for other names, and
    for a regime that needs the hardness where the material has none.
    """

    def __init__(
        self, moments: SpectralMoments, material: Material, regime: str, height_law: str
    ) -> None:
        """Keep the moments of the summits (m, 1/m²), and find the load of one by the regime."""
        one_of("regime", regime, REGIMES)
        self.heights = one_of("height_law", height_law, ("gaussian", "exponential"))
        self.radius, self.std = moments.summit_radius, moments.summit_std
        self.density = moments.summit_density
        hertz = 4.0 / 3.0 * material.contact_modulus * np.sqrt(self.radius)
        self.load = straight(hertz, 1.5)
        if regime != "elastic":
            hardness = material.needed("hardness", f'regime = "{regime}"')
            self.load = straight(np.pi * self.radius * hardness, 1.0)
        if regime == "mixed":
            self.load = Bend(hertz, 1.5, 1.0, material.critical_compression(self.radius))

    def compressions(self, z: float) -> Thresholds:
        """The law of the compressions in m of the summits that touch: a normal law cut at 0, or the exponential one."""
        if self.heights == "gaussian":
            return gaussian(-z * self.std, self.std)
        return Weibull(1.0, 1.0 / self.std)

    def contact_density(self, z: float) -> float:
        """Contacts per nominal area in 1/m²."""
        touching = scipy.special.ndtr(-z) if self.heights == "gaussian" else np.exp(-1.0 - z)
        return float(self.density * touching)

    def area_fraction(self, z: float) -> float:
        """Real area of contact divided by the nominal one."""
        return self.contact_density(z) * np.pi * self.radius * self.compressions(z).mean()

    def pressure(self, z: float) -> float:
        """Nominal pressure in Pa where the flat is at z sigma_h."""
        return self.contact_density(z) * Powered(self.compressions(z), self.load).mean()

    def separation(self, pressure: float) -> float:
        """z = h0/sigma_h under a nominal pressure in Pa; at least -1e6, which is taken for covered."""
        return _separation(self, pressure)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Summits) and vars(self) == vars(other)

    def __hash__(self) -> int:
        return hash((*vars(self).values(),))

    def check(self, z: float, name: str, value: float, remedy: str) -> None:
        """InputError where the contacts, which must be far apart, would cover the whole surface, and for a flat below
        the lowest summit of exponential heights."""
        other = f'{remedy}, or take the thresholds of model = "persson"'
        if self.heights == "exponential" and z < -1.0:
            most = f"{self.pressure(-1.0):.3g} Pa, where every summit touches"
            refuse(name, value, f"summits of exponential heights bear at most {most}; {other}")
        if (covered := self.area_fraction(z)) >= 1.0 or z <= -1e6:
            hint = f"summits would cover {covered:.3g} of the surface, not far apart: {other}"
            refuse(name, value, f"{hint}; are heights and pixel size in metres, moduli in Pa?")


# readings and tables of one surface ask for it again and again; finding it takes most of the time of making thresholds
@lru_cache(maxsize=64)
def _separation(summits: Summits, pressure: float) -> float:
    """As Summits.separation."""

    def excess(z: float) -> float:
        return float(np.log(summits.pressure(z) / pressure))

    if summits.heights == "exponential":
        return excess(0.0)  # the pressure is proportional to e^-z
    # half of the summits are compressed by more than -h0; the pressure falls faster than e^(-z²/2)
    deepest = summits.load.inverse()(2.0 * pressure / summits.density)
    low = max(-float(deepest / summits.std), -1e6)
    high = np.sqrt(2.0 * max(excess(0.0), 0.0))
    if not excess(low) > 0.0:
        return low
    return scipy.optimize.brentq(excess, low, high, xtol=1e-14, rtol=1e-14)


def separation_of_pressure(
    moments: SpectralMoments,
    pressure: float,
    *,
    material: Material,
    regime: str = "elastic",
    height_law: str = "gaussian",
) -> float:
    """h0 in m, the height of the flat above the summits' mean plane, under a nominal pressure in Pa.

    moments, material, regime, height_law : as in from_moments. Raises InputError as from_moments does.
    """
    summits = Summits(moments, material, regime, height_law)
    z = summits.separation(between("pressure", pressure, 1e-200, 1e200, "it is in Pa"))
    summits.check(z, "pressure", pressure, "lower it")
    return float(z * summits.std)


def pressure_of_separation(
    moments: SpectralMoments,
    separation: float,
    *,
    material: Material,
    regime: str = "elastic",
    height_law: str = "gaussian",
) -> float:
    """Nominal pressure in Pa that holds the flat at `separation`, in m above the summits' mean plane.

    moments, material, regime, height_law : as in from_moments. Raises InputError as it does, for a flat below
    the lowest summit of exponential heights, and for one so high that the pressure underflows.
    """
    summits = Summits(moments, material, regime, height_law)
    z = finite("separation", separation) / summits.std
    summits.check(z, "separation", separation, "raise it")
    if not (pressure := summits.pressure(z)) > 0.0:
        refuse("separation", separation, f"is {z:.3g} sigma_h, where no summit reaches; lower it")
    return pressure


def gw_gaussian(
    separation: float,
    scale: float,
    law: str = "paper",
    regime: str = "elastic",
    plasticity_index: float | None = None,
) -> Thresholds:
    """Summits of Gaussian heights under a flat: S(x) = Phi_c[(h0 + delta(x))/sigma_h]/Phi_c[h0/sigma_h].

    A contact compressed by delta breaks at x_s = scale (delta/sigma_h)^b, where b of elastic contacts is 3/4 under the
    law "paper", 1 under "amontons" and 1/2 under "strength", and b of plastic ones 1/2. Light load, h0 >> sigma_h, is
    up to (sigma_h/h0)² gw_elastic or gw_plastic with B = h0/sigma_h/scale^(1/b), under the paper's law.

    separation : h0/sigma_h, from the summits' mean plane, -1e3 to 1e6; separation_of_pressure finds it from a load.
    scale : threshold of a contact compressed by sigma_h, a length, from 1e-150 to 1e150.
    law : as in from_moments.
    regime : "elastic", "plastic" or "mixed": contacts compressed beyond sigma_h (9 pi/(4 psi))² are plastic.
    plasticity_index : psi = (E*/Y)(sigma_h/r)^(1/2), Y = H/3, from 1e-100 to 1e100; for the regime "mixed" only.

    Raises InputError for values outside these. For summits in metres and newtons see from_moments.
    """
    z = finite("separation", separation)
    if not -1e3 <= z <= 1e6:
        refuse("separation", separation, "is h0/sigma_h and must lie between -1000 and 1e+06")
    # lengths whose squares are still finite
    scale = between("scale", scale, 1e-150, 1e150, "choose another unit of length")
    # b of elastic contacts, for k ~ A^(1/2); 1/2 of plastic ones
    exponents = {"paper": 0.75, "amontons": 1.0, "strength": 0.5}
    exponent, at = exponents[one_of("law", law, (*exponents,))], np.inf
    if one_of("regime", regime, REGIMES) == "mixed":
        psi = between("plasticity_index", plasticity_index, 1e-100, 1e100, "it is a pure number")
        at = (2.25 * np.pi / psi) ** 2
    elif plasticity_index is not None:
        refuse("plasticity_index", plasticity_index, 'is for regime = "mixed"; leave it out')
    if regime == "plastic":
        exponent = 0.5
    # `scale` belongs to the part that includes delta = sigma_h
    first = scale * min(at, 1.0) ** (0.5 - exponent)
    return Powered(gaussian(-z, 1.0), Bend(first, exponent, 0.5, at))
