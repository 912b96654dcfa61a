"""From a rough surface to thresholds in metres: contact model times threshold law."""

from typing import Any

import numpy as np
import scipy

from origins.errors import InputError, between, one_of, refuse
from origins.roughness.greenwood_williamson import Summits
from origins.roughness.interface import Interface, Material
from origins.roughness.moments import SpectralMoments, spectral_moments
from origins.roughness.surface import as_topography
from origins.thresholds.families import persson
from origins.thresholds.law import Thresholds
from origins.thresholds.powered import Bend, Powered, straight

MODELS, LAWS = ("gw", "persson"), ("paper", "amontons", "strength")


def from_topography(
    heights: object,
    pixel_size: object = None,
    *,
    detrend: str = "curvature",
    periodic: bool = False,
    step: int = 1,
    **options: Any,
) -> Thresholds:
    """Thresholds of a measured surface pressed against a flat (paper, Sec. VI A and B), in metres.

    heights, pixel_size, detrend, periodic, step : as in spectral_moments; of two rough surfaces the sum of heights.
    options : all other arguments of from_moments. Returns thresholds and raises InputError as it does.
    """
    moments = spectral_moments(heights, pixel_size, detrend=detrend, periodic=periodic, step=step)
    return from_moments(moments, **options)


def from_moments(
    moments: SpectralMoments,
    *,
    model: str,
    law: str,
    material: Material,
    pressure: float,
    regime: str = "elastic",
    patch_area: float | None = None,
    height_law: str = "gaussian",
) -> Thresholds:
    """Thresholds in metres of a surface known by its moments, as moments_of_spectrum or moments_of_summits give them.

    model : "gw": Greenwood and Williamson's summits, counted and shaped by the spectral moments (McCool 1986).
        "persson": normal stress in the real contact, of width E* h'_rms/2^(1/2), on patches of `patch_area`.
    law : from the area A and load w of a contact to its threshold x_s = f_s/k (docs/rough-surfaces.md compares them):
        "paper": f_s = mu w and f_s = c x_s², so that k = c x_s; refuses contact_stiffness;
        "amontons": f_s = mu w, with k = G A^(1/2), or the material's contact_stiffness;
        "strength": f_s = tau A, with the same k; refused for patches, which would all break at one threshold.
    material, pressure : SI units, with the constants that the law needs; nominal pressure, Pa.
    regime : gw only. "elastic"; "plastic": every summit carries hardness times area, pi r delta H (paper, Eq. GW2);
        "mixed": only those compressed by more than r (3 pi H/4E*)² do, where this load equals Hertz'.
    patch_area : persson only, and needed there: area of one contact, m², such as `interface.mean_area` of model="gw".
    height_law : gw only: "gaussian" or "exponential" heights of the summits, either of the measured standard deviation.

    The result has `.interface`, the Interface: area fraction, contact density, <k>, plasticity, friction coefficient.
    Raises InputError for other values and for meaningless combinations; the message says what to write instead.
    """
    if not isinstance(moments, SpectralMoments):
        refuse("moments", moments, "must be SpectralMoments, as of origins.moments_of_summits(...)")
    if not isinstance(material, Material):
        refuse("material", material, "must be origins.Material(contact_modulus=..., ...)")
    one_of("law", law, LAWS)
    if law == "paper" and material.contact_stiffness is not None:
        raise InputError('material.contact_stiffness: law = "paper" has k = c x_s; leave it out')
    fields = {"model": model, "law": law, "material": material, "moments": moments}
    fields["pressure"] = between("pressure", pressure, 1e-200, 1e200, "it is in Pa")
    if one_of("model", model, MODELS) == "gw":
        if patch_area is not None:
            refuse("patch_area", patch_area, 'model = "gw" counts its own contacts; leave it out')
        return _on_summits(fields, regime, height_law)
    for name, value in (("height_law", height_law), ("regime", regime)):
        if value not in ("gaussian", "elastic"):
            refuse(name, value, 'belongs to the summits of model = "gw"; leave it out')
    if patch_area is None:
        refuse(
            "patch_area",
            None,
            'model = "persson" needs it: take interface.mean_area of model = "gw", "mean area" of `thresholds`',
        )
    return _on_patches(fields, between("patch_area", patch_area, 1e-40, 1e20, "it is in m²"))


def resolution_study(
    heights: object,
    pixel_size: object = None,
    *,
    factors: tuple[int, ...] = (1, 2, 4, 8),
    **options: Any,
) -> tuple[Thresholds, ...]:
    """from_topography with neighbours `factors` pixels apart: the dependence on the scan's resolution.

    Each result has its moments as `.interface.moments`, with the step and the spacing of their differences.
    options : all other arguments of from_topography, except step. Raises InputError as it does, and for no factors.
    """
    if not isinstance(factors, tuple | list) or not factors:
        refuse("factors", factors, "must be a tuple of whole numbers, such as (1, 2, 4, 8)")
    surface = as_topography(heights, pixel_size)
    return tuple(from_topography(surface, step=step, **options) for step in factors)


def _on_summits(fields: dict[str, Any], regime: str, height_law: str) -> Thresholds:
    """Greenwood and Williamson's contacts (paper, Eqs. GW1, GW2): area and load are powers of the compression."""
    moments, material, pressure = fields["moments"], fields["material"], fields["pressure"]
    summits = Summits(moments, material, regime, height_law)
    z = summits.separation(pressure)
    summits.check(z, "pressure", pressure, "lower it")
    plastic = of_hertz = loaded = None
    if material.hardness is not None:
        limit = material.critical_compression(summits.radius)
        plastic = loaded = 1.0
        if regime != "plastic":
            plastic = float(summits.compressions(z).sf(limit))
            loaded = _load_beyond(limit, summits.compressions(z), summits.load)
        elastic = Summits(moments, material, "elastic", height_law)
        by_hertz = z if regime == "elastic" else elastic.separation(pressure)
        of_hertz = float(summits.compressions(by_hertz).sf(limit))
    fields |= {"regime": regime, "separation": float(z * summits.std)}
    fields |= {"plastic_fraction": plastic, "hertz_plastic_fraction": of_hertz}
    fields["plastic_load_fraction"] = loaded
    fields["area_fraction"] = summits.area_fraction(z)
    fields["contact_density"] = summits.contact_density(z)
    area = straight(np.pi * summits.radius, 1.0)
    return _by_law(summits.compressions(z), summits.load, area, fields)


def _on_patches(fields: dict[str, Any], patch_area: float) -> Thresholds:
    """Persson's stresses on patches of one area: P(s) ~ exp[-(s-p)²/D²] - exp[-(s+p)²/D²] (paper, Eq. PcPersson), with
    D = E* m2^(1/2); the norm of P(s) is erf(p/D), the real area of contact divided by the nominal one."""
    material, pressure = fields["material"], fields["pressure"]
    width = float(material.contact_modulus * np.sqrt(fields["moments"].m2))
    if fields["law"] == "strength":
        refuse("law", "strength", 'all patches break at one threshold; write "amontons"')
    # the square root of the stress has the law (PcPersson3)
    roots = persson(centre=float(np.sqrt(pressure)), width=float(np.sqrt(width)))
    plastic = loaded = None
    if material.hardness is not None:
        limit = float(np.sqrt(material.hardness))
        plastic = float(roots.sf(limit))
        loaded = _load_beyond(limit, roots, straight(patch_area, 2.0))
    area_fraction = float(scipy.special.erf(pressure / width))
    fields |= {"area_fraction": area_fraction, "contact_density": area_fraction / patch_area}
    fields |= {"plastic_fraction": plastic, "hertz_plastic_fraction": plastic}
    fields["plastic_load_fraction"] = loaded
    fields["patch_area"] = patch_area
    return _by_law(roots, straight(patch_area, 2.0), straight(patch_area, 0.0), fields)


def _load_beyond(limit: float, size: Thresholds, load: Bend) -> float:
    """Share of the load that contacts with a size beyond the limit bear: the integral of load(size) over their share,
    relative to that over all."""
    beyond = float(size.sf(limit))
    if beyond == 0.0:
        return 0.0
    borne = scipy.integrate.tanhsinh(
        lambda fraction: load(size.isf(fraction)), 0.0, beyond, atol=0.0, rtol=1e-9
    )
    return min(float(borne.integral / Powered(size, load).mean()), 1.0)


def _by_law(size: Thresholds, load: Bend, area: Bend, fields: dict[str, Any]) -> Thresholds:
    """Thresholds by the law among `fields`, and the interface, of contacts whose load (N) and area (m²) are powers of
    `size`, a random variable: the compression of a summit ("gw"), the root of the stress on a patch ("persson").
    InputError where the material lacks a constant, or k grows as fast as f_s or faster."""
    law, material, moments = fields["law"], fields["material"], fields["moments"]
    of_area = law == "strength"
    strength = material.needed("shear_strength" if of_area else "local_friction", f'law = "{law}"')
    # at a break the force is mu times the load ("amontons", "paper"), or the shear strength times the area ("strength")
    force = (area if of_area else load).times(strength)
    if law == "paper":
        coefficient = material.needed("force_coefficient", 'law = "paper"')
        thresholds = Powered(size, force.times(coefficient**-0.5, 0.5))
        stiffness = coefficient * thresholds.mean()  # k = c x_s
    else:  # "amontons" and "strength": k follows from the area, and x_s = force/k
        given = material.stiffness(law)
        each = area.times(given.coefficient, given.exponent)
        stretch = force.times(1.0 / each.coefficient, exponent=-each.exponent)
        if not min(stretch.exponent, stretch.above) > 0.0:
            hint = "makes thresholds fall as a summit is pressed down; take one with k ~ A^(1/2)"
            raise InputError(f"material.contact_stiffness: k ~ A^{given.exponent:g} {hint}")
        thresholds = Powered(size, stretch)
        stiffness = each.coefficient * size._moment(each.exponent)
    psi = None
    if material.hardness is not None:
        shape = float(np.sqrt(moments.summit_std / moments.summit_radius))
        psi = 3.0 * material.contact_modulus / material.hardness * shape
    fields |= {"plasticity_index": psi, "force_law": force.against(thresholds.power)}
    fields |= {"mean_threshold": thresholds.mean(), "mean_stiffness": stiffness}
    radius = area.times(np.pi**-0.5, 0.5)
    fields["mean_radius"] = radius.coefficient * size._moment(radius.exponent)
    density, pressure = fields["contact_density"], fields["pressure"]
    carried = fields["area_fraction"] if of_area else pressure
    fields["mean_force_threshold"] = strength * carried / density
    kinetic = thresholds.moment(2) / (2.0 * thresholds.mean())
    fields["friction_coefficient"] = density * stiffness * kinetic / pressure
    thresholds.interface = Interface(**fields)
    return thresholds
