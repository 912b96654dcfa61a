"""Greenwood and Williamson's contact: Hertzian summits of one radius and random height under a rigid flat.

A summit of height h above the flat at h0 is compressed by delta = h - h0: area pi r delta, load
(4/3) E* r^(1/2) delta^(3/2) (Hertz; the paper's Eq. GW1 prints 4 pi/3), thresholds x_s = a delta^b.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import gammaln

from origins.errors import refuse
from origins.gaussian import gaussian
from origins.material import Material
from origins.powered import Powered
from origins.spectral_moments import SpectralMoments
from origins.thresholds import Thresholds
from origins.weibull import Weibull

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(200)
_FALL = 60.0  # the integrand is left where it has fallen by e^-60
_LOG_ROOT_TWO_PI = 0.5 * np.log(2.0 * np.pi)


def log_height_integral(order: float, z: float) -> float:
    """log of the integral over t > 0 of t^order phi(z + t), phi the standard normal density.

    Greenwood and Williamson's F_n(z) for summits of Gaussian heights, for orders that are multiples of 1/4 of at
    least 0, at any z: nothing under- or overflows, whether the load is light (z >> 1) or heavy (z < 0).
    """
    reach = np.sqrt(2.0 * _FALL)
    far = 2.0 * _FALL / (z + np.sqrt(z * z + 2.0 * _FALL)) if z > 0.0 else -z + reach
    near = max(0.0, -z - reach)
    # t = s^4 makes every quarter order smooth at 0
    low, high = near**0.25, far**0.25
    s = low + 0.5 * (high - low) * (_NODES + 1.0)
    t = s**4
    logs = np.log(4.0) + (4.0 * order + 3.0) * np.log(s) - z * t - 0.5 * t * t
    top = float(logs.max())
    inner = 0.5 * (high - low) * float((_WEIGHTS * np.exp(logs - top)).sum())
    return top + float(np.log(inner)) - 0.5 * z * z - _LOG_ROOT_TWO_PI


def separation_of_load(log_load: float) -> float:
    """z = h0/sigma_h at which log_height_integral(3/2, z) equals `log_load`; Newton, which cannot fail.

    The integral is log-concave and falls in z, so that after the first step the iterates come down on the root;
    one that goes back up is round-off.
    """
    z = 0.0
    for count in range(200):
        value = log_height_integral(1.5, z)
        slope = -1.5 * np.exp(log_height_integral(0.5, z) - value)
        step = (value - log_load) / slope
        z -= step
        if count > 0 and step <= 1e-15 * abs(z):
            break
    return z


class GaussianSummits(Powered):
    """Thresholds a delta^b of summits with Gaussian heights: S(x) = Phi_c[(h0 + delta(x))/sigma_h]/Phi_c[h0/sigma_h].

    Parameters
    ----------
    separation : float
        h0/sigma_h, from the summits' mean plane.
    std : float
        sigma_h, a length.
    scale, exponent : float
        x_s = scale * delta^exponent; the exponent a multiple of 1/4.
    """

    def __init__(self, separation: float, std: float, scale: float, exponent: float) -> None:
        # the compressions of those that touch are a normal law cut at 0
        super().__init__(gaussian(mean=-separation * std, std=std), scale, exponent)
        self.separation = separation
        self.std_of_heights = std

    def _moment(self, n: int) -> float:
        order = n * self.exponent
        ratio = log_height_integral(order, self.separation) - log_height_integral(0.0, self.separation)
        return float((self.scale * self.std_of_heights**self.exponent) ** n * np.exp(ratio))


@dataclass(frozen=True)
class SummitContact:
    """A rough surface of summits pressed to a load: lengths in metres, contacts per nominal m².

    `mean_compression` is <delta> and `mean_root` <delta^(1/2)>, over the summits that touch.
    """

    heights: str
    std: float
    separation: float
    contact_density: float
    mean_root: float
    mean_compression: float
    radius: float

    @property
    def area_fraction(self) -> float:
        """Real over nominal area of contact."""
        return self.contact_density * np.pi * self.radius * self.mean_compression

    def thresholds(self, scale: float, exponent: float) -> Thresholds:
        """The law of scale * delta^exponent, the exponent a multiple of 1/4."""
        if self.heights == "gaussian":
            return GaussianSummits(self.separation / self.std, self.std, scale, exponent)
        # Weibull: shape 4/3 is (GW3), shape 2 is (GW4)
        power = 1.0 / exponent
        return Weibull(power, scale**-power / self.std, power - 1.0)


def pressed(moments: SpectralMoments, contact_modulus: float, pressure: float, heights: str) -> SummitContact:
    """The summits of a surface under a nominal pressure (Pa); heights "gaussian" or "exponential".

    Exponential heights have mean and standard deviation sigma_h, begin at the plane h = 0, and give thresholds
    that do not depend on the load (paper, Eqs. GW3 and GW4).

    Raises InputError for another name, for a pressure that exponential heights cannot bear, and where the
    contacts would cover the whole surface: they are then no longer apart, as the model has them.
    """
    radius, std, density = moments.summit_radius, moments.summit_std, moments.summit_density
    per_power = density * (4.0 / 3.0) * contact_modulus * np.sqrt(radius) * std**1.5
    log_load = float(np.log(pressure) - np.log(per_power))
    if heights == "gaussian":
        z = separation_of_load(log_load)

        def log_mean(order: float) -> float:
            return log_height_integral(order, z)

    elif heights == "exponential":
        z = float(gammaln(2.5)) - log_load
        if z < 0.0:
            refuse(
                "pressure",
                pressure,
                f"exponential heights bear at most {np.exp(gammaln(2.5)) * per_power:.3g} Pa, where every summit "
                'touches; write height_law="gaussian" or model="persson"',
            )

        def log_mean(order: float) -> float:
            return float(gammaln(order + 1.0)) - z

    else:
        refuse("height_law", heights, 'must be "gaussian" or "exponential"')
    touching = log_mean(0.0)
    contact = SummitContact(
        heights=heights,
        std=std,
        separation=z * std,
        contact_density=float(density * np.exp(touching)),
        mean_root=float(np.sqrt(std) * np.exp(log_mean(0.5) - touching)),
        mean_compression=float(std * np.exp(log_mean(1.0) - touching)),
        radius=radius,
    )
    if contact.area_fraction >= 1.0:
        refuse(
            "pressure",
            pressure,
            f"summits would cover {contact.area_fraction:.3g} of the surface; Greenwood and Williamson hold for "
            'contacts far apart, so lower it or write model="persson"',
        )
    return contact


def critical_compression(radius: float, contact_modulus: float, hardness: float) -> float:
    """Compression above which a summit is plastic, r (3 pi H/4E*)², where the elastic and plastic loads meet."""
    return float(radius * (0.75 * np.pi * hardness / contact_modulus) ** 2)


def power_of_compression(law: str, material: Material, radius: float) -> tuple[float, float]:
    """(a, b) of x_s = a delta^b under a threshold law; see rough_contact.from_topography."""
    if law == "amontons":
        mu, shear = material.needed("local_friction", law), material.needed("shear_modulus", law)
        return 4.0 * mu * material.contact_modulus / (3.0 * np.sqrt(np.pi) * shear), 1.0
    if law == "strength":
        tau, shear = material.needed("shear_strength", law), material.needed("shear_modulus", law)
        return float(tau * np.sqrt(np.pi * radius) / shear), 0.5
    mu, coefficient = material.needed("local_friction", law), material.needed("force_coefficient", law)
    return float(np.sqrt(4.0 * mu * material.contact_modulus * np.sqrt(radius) / (3.0 * coefficient))), 0.75
