"""Greenwood and Williamson's contact: summits of one radius and random height under a rigid flat (paper, Sec. VI A).

A summit of height h under a flat at h0 < h is compressed by delta = h - h0 and has the area pi r delta. An elastic one
carries (4/3) E* r^(1/2) delta^(3/2) (Hertz; the paper's Eq. GW1 prints 4 pi/3), a plastic one pi r delta H (Eq. GW2,
hardness times area). The two loads are equal at one compression, and so are the areas: load and threshold are
continuous there, but the threshold as a function of delta has a kink and P_c has a jump.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.special import log_ndtr

from origins.errors import between, finite, one_of, positive, refuse
from origins.roughness.material import Material
from origins.roughness.moments import SpectralMoments
from origins.roughness.power_law import Bend, PowerLaw
from origins.thresholds.families import Weibull
from origins.thresholds.gaussian import gaussian
from origins.thresholds.law import Thresholds
from origins.thresholds.powered import Powered

REGIMES = ("elastic", "plastic", "mixed")

_rule = cache(np.polynomial.legendre.leggauss)  # computed on first use, to keep the import fast


def compressions(std: float, z: float, heights: str = "gaussian") -> Thresholds:
    """The law of the compressions of those summits that touch a flat at z standard deviations.

    Gaussian heights give a normal law cut at 0, exponential ones, which begin at 0, the exponential law for any z.
    """
    return gaussian(-z * std, std) if heights == "gaussian" else Weibull(1.0, 1.0 / std)


@dataclass(frozen=True)
class Summits:
    """The summits of a surface and their load: lengths in m, `density` in 1/m², `load` in N as a law of m; z, in
    sigma_h, is the height of the flat above their mean plane."""

    radius: float
    std: float
    density: float
    heights: str
    load: Bend

    @property
    def area(self) -> PowerLaw:
        """Area of a contact (m²) as a function of its compression (m)."""
        return PowerLaw(np.pi * self.radius, 1.0)

    def compressions(self, z: float) -> Thresholds:
        """The law of the compressions of the contacts, in m."""
        return compressions(self.std, z, self.heights)

    def contact_density(self, z: float) -> float:
        """Contacts per nominal area, 1/m²."""
        log_touching = log_ndtr(-z) if self.heights == "gaussian" else -z
        return float(self.density * np.exp(log_touching))

    def area_fraction(self, z: float) -> float:
        """Real over nominal area of contact."""
        return self.contact_density(z) * float(self.area(self.compressions(z).mean()))

    def check_apart(self, z: float, name: str, value: float, remedy: str) -> None:
        """InputError where the contacts would cover the whole surface; the model needs them to be separate."""
        if (covered := self.area_fraction(z)) >= 1.0:
            rule = f"summits would cover {covered:.3g} of the surface; Greenwood and Williamson hold for contacts far "
            rule += f'apart, so {remedy}, or take the thresholds of model = "persson"; are heights and pixel size in '
            refuse(name, value, rule + "metres, pressure and moduli in Pa?")

    def pressure(self, z: float) -> float:
        """Nominal pressure in Pa where the flat is at z sigma_h."""
        with np.errstate(over="ignore"):
            return float(self.density * np.exp(self._log_load(z)[0]))

    def separation(self, pressure: float) -> float:
        """z = h0/sigma_h under a nominal pressure in Pa, by Newton's method, which always converges here.

        The logarithm of the load is concave in z and falls, so that after the first step the iterates approach the
        root from above; a step back up is round-off.
        """
        goal = float(np.log(pressure) - np.log(self.density))
        z = 0.0
        for count in range(200):
            value, slope = self._log_load(z)
            step = (value - goal) / slope
            z -= step
            if (count > 0 and step <= 1e-15 * abs(z)) or z < -1e8:
                break
        return z

    def _log_load(self, z: float) -> tuple[float, float]:
        """log of the mean load over all summits (0 for those that do not touch), and its derivative in z.

        Nothing under- or overflows, whether the flat is far above (z >> 1) or deep below (z < 0).
        """
        # in sigma_h a summit at z + t is compressed by t; the density of t is e^-(slope t + curvature t²/2)
        slope, curvature = (z, 1.0) if self.heights == "gaussian" else (1.0, 0.0)
        peak = max(0.0, -slope * curvature)
        tilt = slope + curvature * peak
        reach = 120.0 / (tilt + np.sqrt(tilt * tilt + 120.0 * curvature))
        near, far, bend = max(0.0, peak - reach), peak + reach, self.load.at / self.std
        # with t = s^4 powers of t in quarters are smooth at 0, and other powers smooth enough
        s = np.unique(np.array([near, np.clip(bend, near, far), far]) ** 0.25)
        half = 0.5 * np.diff(s)[:, None]
        places, shares = _rule(200)
        nodes = s[:-1, None] + half * (places + 1.0)
        t, weights = nodes**4, 4.0 * half * shares * nodes**3
        weights = weights * np.exp(-(t - peak) * (tilt + 0.5 * curvature * (t - peak)))
        loads = weights * self.load(self.std * t)
        if self.heights == "gaussian":
            log_density = -0.5 * max(z, 0.0) ** 2 - 0.5 * np.log(2.0 * np.pi)
            falls = float((loads * (z + t)).sum() / loads.sum())
        else:
            log_density, falls = -z, 1.0
        return float(np.log(loads.sum())) + log_density, -falls


def summits_of(moments: SpectralMoments, material: Material, regime: str, heights: str) -> Summits:
    """The summits that a surface's moments imply, loaded in a regime.

    Raises InputError for other names, and for a regime that needs the hardness where the material has none.
    """
    one_of("regime", regime, REGIMES)
    one_of("height_law", heights, ("gaussian", "exponential"))
    radius = moments.summit_radius
    hertz = PowerLaw(4.0 / 3.0 * material.contact_modulus * np.sqrt(radius), 1.5)
    load = Bend(hertz, hertz, np.inf)
    if regime != "elastic":
        hardness = material.needed("hardness", f'regime = "{regime}"')
        limit = material.critical_compression(radius)
        plastic = PowerLaw(np.pi * radius * hardness, 1.0)
        load = Bend(hertz, plastic, limit) if regime == "mixed" else Bend(plastic, plastic, np.inf)
    return Summits(radius, moments.summit_std, moments.summit_density, heights, load)


def pressed(summits: Summits, pressure: float) -> float:
    """Position z of the flat, in sigma_h, under a nominal pressure (Pa).

    Exponential heights have mean and standard deviation sigma_h, begin at the plane h = 0, and give thresholds
    that do not depend on the load (paper, Eqs. GW3 and GW4).

    Raises InputError for a pressure too large for exponential heights, and where the contacts would cover the
    whole surface.
    """
    z = summits.separation(pressure)
    if summits.heights == "exponential" and z < 0.0:
        rule = f"exponential heights bear at most {summits.pressure(0.0):.3g} Pa, where every summit touches; take "
        rule += 'height_law = "gaussian", or the thresholds of model = "persson"'
        refuse("pressure", pressure, rule)
    summits.check_apart(z, "pressure", pressure, "lower it")
    return z


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
    summits = summits_of(moments, material, regime, height_law)
    return float(pressed(summits, positive("pressure", pressure)) * summits.std)


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
    touches, and for one so high that the pressure underflows.
    """
    summits = summits_of(moments, material, regime, height_law)
    z = finite("separation", separation) / summits.std
    if height_law == "exponential" and z < 0.0:
        rule = "exponential heights begin at 0, where every summit touches; write one above"
        refuse("separation", separation, rule)
    summits.check_apart(z, "separation", separation, "raise it")
    pressure = summits.pressure(z)
    if not pressure > 0.0:
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

    A contact compressed by delta breaks at x_s = scale (delta/sigma_h)^b:

        law         elastic   plastic
        paper        3/4       1/2
        amontons      1        1/2
        strength     1/2       1/2

    Light load, h0 >> sigma_h, is the exponential case, S(x) = exp[-(h0/sigma_h)(x/scale)^(1/b)] up to
    (sigma_h/h0)²: the paper's law gives (GW3) and (GW4), gw_elastic and gw_plastic with B = h0/sigma_h/scale^(1/b).

    Parameters
    ----------
    separation : float
        h0/sigma_h, from the summits' mean plane, from -1e3 to 1e6. Below 0 the load is heavy; below about -3 every
        summit touches, and the model hardly applies. separation_of_pressure finds it from a load.
    scale : float
        Threshold of a contact compressed by sigma_h, a length, from 1e-150 to 1e150.
    law : "paper", "amontons" or "strength"
        As in from_topography.
    regime : "elastic", "plastic" or "mixed"
        "mixed": contacts compressed beyond sigma_h (9 pi/(4 psi))², where Hertz' mean pressure is the hardness, are
        plastic. x_s is continuous there; P_c jumps up, by 3/2 under the law "paper" and by 2 under "amontons".
    plasticity_index : float
        psi = (E*/Y)(sigma_h/r)^(1/2), Y = H/3; needed for the regime "mixed", and only there.

    Raises InputError for values outside these. For summits in metres and newtons see from_moments.
    """
    z = finite("separation", separation)
    if not -1e3 <= z <= 1e6:
        refuse("separation", separation, "is h0/sigma_h and must lie between -1000 and 1e+06")
    # lengths whose squares are still finite
    scale = between("scale", scale, 1e-150, 1e150, "choose another unit of length")
    # b of x_s ~ delta^b, elastic and plastic, for k ~ A^(1/2)
    exponents = {"paper": (0.75, 0.5), "amontons": (1.0, 0.5), "strength": (0.5, 0.5)}
    elastic, plastic = (PowerLaw(scale, b) for b in exponents[one_of("law", law, (*exponents,))])
    if one_of("regime", regime, REGIMES) != "mixed":
        if plasticity_index is not None:
            rule = 'belongs to regime = "mixed" alone; leave it out'
            refuse("plasticity_index", plasticity_index, rule)
        return Powered(compressions(1.0, z), elastic if regime == "elastic" else plastic)
    if plasticity_index is None:
        rule = 'regime = "mixed" needs it, such as plasticity_index = 5.0'
        refuse("plasticity_index", plasticity_index, rule)
    with np.errstate(over="ignore"):
        at = float(np.float64(2.25 * np.pi / positive("plasticity_index", plasticity_index)) ** 2)
    if not 0.0 < at < np.inf:
        return gw_gaussian(z, scale, law, "plastic" if at == 0.0 else "elastic")
    # `scale` is the coefficient of the part that includes delta = sigma_h; the other one meets it at the bend
    if at > 1.0:
        plastic *= PowerLaw(at ** (elastic.exponent - plastic.exponent), 0.0)
    else:
        elastic *= PowerLaw(at ** (plastic.exponent - elastic.exponent), 0.0)
    return Powered(compressions(1.0, z), Bend(elastic, plastic, at))
