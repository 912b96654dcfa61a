"""The material of a rough contact, and one interface, which converts thresholds in metres to newtons and pascals."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from origins.errors import InputError, between, finite, pair, positive, refuse
from origins.roughness.moments import SpectralMoments
from origins.roughness.stated import InSI
from origins.thresholds.powered import Array, Bend, PowerLaw

_ONE_OF = "write shear_modulus, or density and sound_velocity, or contact_stiffness"
# of the contact modulus: no material is as soft as that, sodium has 1e-4; and an order that many have
_SOFTEST, _ORDINARY = 1e-5, 1e-3


@dataclass(frozen=True)
class Material:
    """Constants of the two bodies in contact, in SI units; those that the threshold law does not need may be left out.

    contact_modulus : Hertz' E* in Pa, 1/E* = (1 - nu_1²)/E_1 + (1 - nu_2²)/E_2; E/(2(1 - nu²)) for equal bodies.
    local_friction : mu, the shear force at which one contact breaks, divided by its normal force.
    shear_modulus : G in Pa; a contact of area A has the stiffness k = G A^(1/2) (paper, Sec. II, App. A).
    density, sound_velocity : rho in kg/m³ and the transverse sound velocity c in m/s, another way to give G = rho c².
    hardness : H in Pa, about 3 Y: the mean pressure of a plastic contact.
    shear_strength, force_coefficient : tau in Pa, f_s = tau A; c in Pa, f_s = c x_s² (the paper's law).
    contact_stiffness : or k in N/m as a PowerLaw of A in m² (docs/rough-surfaces.md compares four).
    Raises InputError for a value not within 1e-20 to 1e20, and where k is given in two ways or only half of one.
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
                between(name, value, 1e-20, 1e20, "it is in SI units")
        law, speeds = self.contact_stiffness, (self.density, self.sound_velocity)
        if not (law is None or isinstance(law, PowerLaw)):
            refuse("contact_stiffness", law, "must be a law, such as mindlin_stiffness(...)")
        if law is not None and not 0.0 <= law.exponent <= 10.0:
            refuse("contact_stiffness.exponent", law.exponent, "must lie between 0 and 10")
        if (law is not None) + (self.shear_modulus is not None) + (speeds != (None, None)) > 1:
            name = "shear_modulus" if law is None else "contact_stiffness"
            raise InputError(f"{name}: given twice; {_ONE_OF}")
        if speeds.count(None) == 1:
            refuse(("density", "sound_velocity")[speeds.index(None)], None, _ONE_OF)

    def needed(self, name: str, what: str) -> float:
        """The constant `name`, in SI units; InputError where it was left out though `what` needs it."""
        if (value := getattr(self, name)) is None:
            refuse(f"material.{name}", None, f"{what} needs it; give the material one, in SI units")
        return float(value)

    def stiffness(self, law: str) -> PowerLaw:
        """k in N/m as a power of the contact's area in m², not for the paper's law; InputError without one."""
        if self.contact_stiffness is not None:
            return self.contact_stiffness
        if self.density is not None and self.sound_velocity is not None:
            return sound_stiffness(self.density, self.sound_velocity)
        if self.shear_modulus is None:
            raise InputError(f'material.shear_modulus = None: law = "{law}" needs it; {_ONE_OF}')
        return PowerLaw(self.shear_modulus, 0.5)

    def critical_compression(self, radius: float) -> float:
        """Compression in m above which a summit is plastic, r (3 pi H/4E*)², for a material with a hardness."""
        return float(radius * (0.75 * np.pi * (self.hardness or 0.0) / self.contact_modulus) ** 2)


def sound_stiffness(density: float, sound_velocity: float) -> PowerLaw:
    """k = rho c² A^(1/2) (paper, Sec. II); rho c² is the shear modulus.

    density in kg/m³ and transverse sound velocity in m/s, above zero; the law takes m² and gives N/m.
    Raises InputError otherwise.
    """
    speed = positive("sound_velocity", sound_velocity)
    return PowerLaw(positive("density", density) * speed**2, 0.5)


def mindlin_stiffness(
    shear_modulus: float | tuple[float, float], poisson_ratio: float | tuple[float, float]
) -> PowerLaw:
    """k = 8 a G*, a = (A/pi)^(1/2) the radius of a circular contact that does not slip (R. D. Mindlin, 1949).

    shear_modulus, poisson_ratio : G in Pa above zero, and nu above -1 and at most 1/2, one number for two equal bodies
        or a pair; 1/G* = (2 - nu_1)/G_1 + (2 - nu_2)/G_2.
    The law takes m² and gives N/m. Raises InputError otherwise.
    """
    moduli, ratios = pair("shear_modulus", shear_modulus), pair("poisson_ratio", poisson_ratio)
    compliance = 0.0
    for modulus, given in zip(moduli, ratios, strict=True):
        if not -1.0 < (ratio := finite("poisson_ratio", given)) <= 0.5:
            refuse("poisson_ratio", ratio, "must be above -1 and at most 1/2, such as 0.3")
        compliance += (2.0 - ratio) / positive("shear_modulus", modulus)
    return PowerLaw(8.0 / compliance / float(np.sqrt(np.pi)), 0.5)


def column_stiffness(
    youngs_modulus: float, aspect: float | None = None, height: float | None = None
) -> PowerLaw:
    """k = (3 pi/4) E_c r_c (r_c/h)³ of a cylinder bent sideways (paper, Eqs. eq15 and eq15a).

    Its radius is r_c = (A/pi)^(1/2), its length h: a thin beam without shear, too stiff where r_c is not below h.

    youngs_modulus : E_c in Pa; 2 (1 + nu) rho c² in Eq. (eq15a).
    aspect, height : r_c/h, so that k ~ A^(1/2), or h in m, so that k ~ A²; the same for every contact.
    The law takes m² and gives N/m. Raises InputError for values not above zero, for both and for neither.
    """
    modulus = 0.75 * positive("youngs_modulus", youngs_modulus)
    if (aspect is None) == (height is None):
        raise InputError("column_stiffness: give one of aspect and height, such as aspect = 1.0")
    if aspect is not None:
        return PowerLaw(float(np.sqrt(np.pi)) * modulus * positive("aspect", aspect) ** 3, 0.5)
    return PowerLaw(modulus / np.pi / positive("height", height) ** 3, 2.0)


@dataclass(frozen=True)
class Interface(InSI):
    """Physical state of a rough contact, in SI units; its thresholds have it as `.interface`.

    A force F per N_c<k>, a length, is the shear stress contact_density * mean_stiffness * F: `per_area`, `newtons`.

    model, law, regime : as from_moments was asked; "elastic" of model = "persson".
    material, moments : Material, and SpectralMoments with the step and the pixel size of their differences.
    pressure, area_fraction : nominal pressure, Pa; real area of contact divided by the nominal one.
    contact_density, mean_radius : contacts per nominal area, 1/m²; <(A/pi)^(1/2)> over them, m.
    mean_threshold, mean_stiffness, mean_force_threshold : fresh <x_s> in m, <k> = <f_s/x_s> in N/m, <f_s> in N.
    friction_coefficient : kinetic friction/load, N<k> F_k/pressure with F_k = <x_s²>/(2<x_s>), k_i independent of
        x_i (paper, Eq. Q6), with number, load and <k> of the fresh interface.
    force_law : f_s in N as a law of x_s in m: force_threshold.
    plasticity_index : psi = (E*/Y)(sigma_h/r)^(1/2) with Y = H/3; None without a hardness.
    plastic_fraction : gw: fraction of contacts compressed beyond r (3 pi H/4E*)², which are plastic in the regime
        "mixed"; all of them in the regime "plastic". persson: fraction of stresses above H. None without a hardness.
    hertz_plastic_fraction : the same if all contacts were elastic under this pressure, whatever the regime.
    plastic_load_fraction : share of the load that those of plastic_fraction bear, in the regime that was asked for.
    separation, patch_area : height of the flat above the summits' mean plane, m, gw; area of one contact, m², persson.
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
    plastic_load_fraction: float | None = None

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
        Raises InputError for values that are no numbers, not finite or below zero."""
        lengths = np.asarray(threshold)
        if lengths.dtype.kind not in "iuf" or not (np.isfinite(lengths) & (lengths >= 0.0)).all():
            refuse("threshold", threshold, "must be a length in m, finite and zero or above")
        return self.force_law(lengths)

    @property
    def hardness_question(self) -> str:
        """Which unit of the hardness is meant, where it is far below that of any material of this modulus; else ""."""
        hardness, modulus = self.material.hardness, self.material.contact_modulus
        if hardness is None or hardness >= _SOFTEST * modulus:
            return ""
        said = f"hardness = {hardness:g} Pa is {hardness / modulus:.0e} of contact_modulus"
        for prefix, factor in (("M", 1e6), ("G", 1e9)):
            if _ORDINARY <= hardness * factor / modulus < 1.0:
                meant = f"hardness = {hardness * factor:.4g}"
                return f"{said}: did you mean {hardness:g} {prefix}Pa? Then write {meant}"
        return f"{said}: is the unit right?"

    @property
    def plastic_caution(self) -> str:
        """A sentence where more than 1 % of the load rests on contacts that would be plastic, and are taken as elastic;
        else ""."""
        plastic, loaded = self.plastic_fraction or 0.0, self.plastic_load_fraction or 0.0
        if self.regime != "elastic" or max(plastic, loaded) <= 0.01:
            return ""
        bear = f", which bear {loaded:.0%} of the load," * (loaded > 0.0)
        return f"{plastic:.0%} of the contacts{bear} would be plastic, and are taken as elastic"

    @property
    def cautions(self) -> tuple[str, ...]:
        """Sentences about surface or load at the limits of the theory; empty where there are none."""
        moments, mu, stretch = self.moments, self.friction_coefficient, self.mean_threshold
        covered, radius, slope = self.area_fraction, self.mean_radius, moments.rms_slope
        local, tops = self.material.local_friction or np.inf, moments.summit_radius
        by_hertz = self.hertz_plastic_fraction or 0.0
        modulus, load = self.material.contact_modulus, self.pressure
        uneven = moments.unevenness
        # without a scan, or without patches, there are no cautions about their size
        pixel, size = moments.pixel_size or (0.0, 0.0), moments.size or (0.0, np.inf)
        point, scan = pixel[0] * pixel[1], size[0] * size[1] or np.inf
        patch, in_scan = self.patch_area or point, self.contact_density * scan
        alone = "neighbours are hardly independent, and in full contact none stands alone"
        too_elastic = self.regime == "plastic" and by_hertz < 0.01
        # the scan need not resolve the area of Persson's patches
        too_small = self.model == "gw" and radius < 2.0 * max(pixel)
        too_wide = self.model == "gw" and radius > 0.5 * tops
        too_high = self.law != "strength" and mu > local
        tall = f"the summits' {in_metres(tops)}, and Hertz' theory needs one far below"
        of_one_unit = "heights and pixel size" if pixel[0] else "heights and lengths of the surface"
        strained = {
            f"the scan is {max(size):.3g} m across: is the unit right?": np.inf > max(size) > 0.1,
            f"contacts have a mean radius of {in_metres(radius)}: is the unit right?": radius
            > 1e-3,
            f"contact_modulus is {modulus:.2g} Pa: is the unit right?": modulus < 100.0,
            f"pressure is {load:.2g} Pa: is the unit right?": load < 10.0,
            self.hardness_question: self.hardness_question != "",
            f"the scan would hold {in_scan:.2g} contacts: the load is extrapolated": in_scan < 1.0,
            f"patch_area = {patch:.3g} m² is below the {point:.3g} m² of a pixel": patch < point,
            f"patch_area = {patch:.3g} m² is above the {scan:.3g} m² of the scan": patch > scan,
            f"contacts cover {covered:.0%} of the surface: {alone}": covered > 0.1,
            f"rms slope is {slope:.2g}: are {of_one_unit} in one unit?": slope > 0.5,
            f"slopes along and across its ridges differ by a factor {uneven:.2g}: not isotropic": uneven
            > 1.5,
            self.plastic_caution: self.plastic_caution != "",
            f"{by_hertz:.1%} would be plastic by Hertz' theory, and all are taken as such": too_elastic,
            f"contacts stretch by {in_metres(stretch)}, above their radius {in_metres(radius)}": stretch
            > radius,
            f"mean radius {in_metres(radius)} is {'above' if radius > tops else 'not far below'} {tall}": too_wide,
            f"mean radius {in_metres(radius)} is below 2 pixels: the scan does not resolve it": too_small,
            f"friction coefficient {mu:.2g} is above the local {local:.2g}: Eq. Q6 pairs k and x_s at random": too_high,
        }
        return tuple(sentence for sentence, holds in strained.items() if holds)


def in_metres(length: float) -> str:
    """A length in metres (or infinite) as text with the prefix that fits it, such as "45 nm"."""
    prefixes = {1.0: "m", 1e-3: "mm", 1e-6: "µm", 1e-9: "nm", 1e-12: "pm"}
    unit = next((unit for unit in prefixes if length >= unit), min(prefixes))
    return f"{length / unit:.3g} {prefixes[unit]}"
