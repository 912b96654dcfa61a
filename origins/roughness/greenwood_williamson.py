"""Greenwood and Williamson's contact: summits of one radius and random height under a rigid flat.

A summit of height h under a flat at h0 < h is compressed by delta = h - h0 and has the area pi r delta. An elastic one
carries (4/3) E* r^(1/2) delta^(3/2) (Hertz; the paper's Eq. GW1 prints 4 pi/3), a plastic one pi r delta H (Eq. GW2,
hardness times area). The two loads are equal at one compression, and so are the areas: load and threshold are
continuous there, but the threshold as a function of delta has a kink and P_c has a jump.
"""

from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from scipy.special import log_ndtr

from origins.errors import finite, one_of, positive, refuse
from origins.roughness.material import Material
from origins.roughness.power_law import Bend, PowerLaw
from origins.roughness.spectral_moments import SpectralMoments
from origins.thresholds.families import Weibull
from origins.thresholds.gaussian import gaussian
from origins.thresholds.law import Thresholds

_DEEPEST = 1e8  # deepest position of the flat, in sigma_h; summits cover the surface long before
_FALL = 60.0  # integrals over heights end where the density has fallen by e^-60
_COUNT = 200  # nodes of such an integral
REGIMES = ("elastic", "plastic", "mixed")


_rule = cache(np.polynomial.legendre.leggauss)  # computed on first use, to keep the import fast


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


def compressions(std: float, z: float, heights: str = "gaussian") -> Thresholds:
    """The law of the compressions of those summits that touch a flat at z standard deviations.

    Gaussian heights give a normal law cut at 0, exponential ones, which begin at 0, the exponential law for any z.
    """
    return gaussian(-z * std, std) if heights == "gaussian" else Weibull(1.0, 1.0 / std, 0.0)


@dataclass(frozen=True)
class Summits:
    """The summits of a surface and their load: lengths in m, `density` in 1/m², `load` in N as a law of m."""

    radius: float
    std: float
    density: float
    heights: str
    load: Bend

    @property
    def area(self) -> PowerLaw:
        """Area of a contact (m²) as a function of its compression (m)."""
        return PowerLaw(np.pi * self.radius, 1.0)

    def log_touching(self, z: float) -> float:
        """log of the fraction of the summits that touch a flat at z sigma_h."""
        return float(log_ndtr(-z)) if self.heights == "gaussian" else -z

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
            if (count > 0 and step <= 1e-15 * abs(z)) or z < -_DEEPEST:
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
        reach = 2.0 * _FALL / (tilt + np.sqrt(tilt * tilt + 2.0 * _FALL * curvature))
        near, far, bend = max(0.0, peak - reach), peak + reach, self.load.at / self.std
        # with t = s^4 powers of t in quarters are smooth at 0, and other powers smooth enough
        s = np.unique(np.array([near, np.clip(bend, near, far), far]) ** 0.25)
        half = 0.5 * np.diff(s)[:, None]
        places, shares = _rule(_COUNT)
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
        limit = critical_compression(radius, material.contact_modulus, hardness)
        plastic = PowerLaw(np.pi * radius * hardness, 1.0)
        load = Bend(hertz, plastic, limit) if regime == "mixed" else Bend(plastic, plastic, np.inf)
    return Summits(radius, moments.summit_std, moments.summit_density, heights, load)


@dataclass(frozen=True)
class SummitContact:
    """Summits pressed together until the flat is at `z` sigma_h above their mean plane."""

    summits: Summits
    z: float

    @cached_property
    def compressions(self) -> Thresholds:
        """The law of the compressions of the contacts, in m."""
        return compressions(self.summits.std, self.z, self.summits.heights)

    @property
    def separation(self) -> float:
        """Height of the flat above the summits' mean plane, m."""
        return float(self.z * self.summits.std)

    @property
    def contact_density(self) -> float:
        """Contacts per nominal area, 1/m²."""
        return float(self.summits.density * np.exp(self.summits.log_touching(self.z)))

    @property
    def area_fraction(self) -> float:
        """Real over nominal area of contact."""
        return self.contact_density * float(self.summits.area(self.compressions.mean()))

    def fraction_beyond(self, compression: float) -> float:
        """Fraction of the contacts that are compressed by more than this, in m."""
        return float(self.compressions.sf(compression))

    def check_apart(self, name: str, value: float, remedy: str) -> None:
        """InputError where the contacts would cover the whole surface; the model needs them to be separate."""
        if self.area_fraction >= 1.0:
            refuse(
                name,
                value,
                f"summits would cover {self.area_fraction:.3g} of the surface; Greenwood and Williamson hold for "
                f'contacts far apart, so {remedy}, or take the thresholds of model = "persson"; are heights and '
                "pixel size in metres, pressure and moduli in Pa?",
            )


def pressed(summits: Summits, pressure: float) -> SummitContact:
    """The summits under a nominal pressure (Pa).

    Exponential heights have mean and standard deviation sigma_h, begin at the plane h = 0, and give thresholds
    that do not depend on the load (paper, Eqs. GW3 and GW4).

    Raises InputError for a pressure too large for exponential heights, and where the contacts would cover the
    whole surface.
    """
    contact = SummitContact(summits, summits.separation(pressure))
    if summits.heights == "exponential" and contact.z < 0.0:
        refuse(
            "pressure",
            pressure,
            f"exponential heights bear at most {summits.pressure(0.0):.3g} Pa, where every summit touches; take "
            'height_law = "gaussian", or the thresholds of model = "persson"',
        )
    contact.check_apart("pressure", pressure, "lower it")
    return contact


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
    return pressed(summits, positive("pressure", pressure)).separation


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
    SummitContact(summits, z).check_apart("separation", separation, "raise it")
    pressure = summits.pressure(z)
    if not pressure > 0.0:
        refuse("separation", separation, f"is {z:.3g} sigma_h, where no summit reaches; lower it")
    return pressure
