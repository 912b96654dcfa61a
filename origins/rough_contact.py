"""From a rough surface to thresholds in metres: contact model times threshold law."""

import numpy as np

from origins.errors import positive, refuse, whole
from origins.greenwood_williamson import critical_compression, power_of_compression, pressed
from origins.interface import Interface
from origins.material import Material
from origins.persson_contact import power_of_stress, stressed
from origins.spectral_moments import SpectralMoments, spectral_moments
from origins.thresholds import Thresholds
from origins.topography import as_topography

LAWS = ("paper", "amontons", "strength")
MODELS = ("gw", "persson")


def from_topography(
    heights: object,
    pixel_size: object = None,
    *,
    model: str,
    law: str,
    material: Material,
    pressure: float,
    patch_area: float | None = None,
    height_law: str = "gaussian",
    detrend: str = "curvature",
    periodic: bool = False,
    step: int = 1,
) -> Thresholds:
    """Thresholds of a measured surface pressed against a flat (paper, Sec. VI A and B), in metres.

    Parameters
    ----------
    heights : array of shape (n_x, n_y), or a SurfaceTopography topography
        Heights of the surface (of two rough ones, their sum) in metres, NaN where missing.
    pixel_size : float or (dx, dy)
        Metres; left out for a topography object, which is converted by its unit.
    model : "gw" or "persson"
        "gw": Greenwood and Williamson's summits, counted and shaped by the spectral moments (McCool 1986), heights
        measured from the summits' mean plane. "persson": normal stress in the real contact, of width
        E* h'_rms/2^(1/2), on patches of `patch_area`.
    law : "paper", "amontons" or "strength"
        From the area A and load w of a contact to its threshold x_s = f_s/k:
        "paper": f_s = mu w and f_s = c x_s², so that k = c x_s;
        "amontons": f_s = mu w, with k = G A^(1/2);
        "strength": f_s = tau A, with k = G A^(1/2).
        With delta the compression of a summit and s the stress on a patch,

                    gw               persson
        paper       delta^(3/4)      s^(1/2) (PcPersson3)
        amontons    delta            s
        strength    delta^(1/2)      refused: patches of one area would break at one threshold
    material : Material
        SI units; what the law needs and is not there is asked for by name.
    pressure : float
        Nominal pressure, Pa.
    patch_area : float
        persson only, and needed there: area of one contact, m². The theory has stresses but no contacts; x_s goes
        as its square root and the contact density as its inverse, while shape and friction coefficient stay.
    height_law : "gaussian" or "exponential"
        gw only: law of the summits' heights, either of the measured standard deviation.
    detrend, periodic, step
        As in spectral_moments.

    Returns
    -------
    thresholds : Thresholds
        With `.interface`, the Interface: area fraction, contact density, <k>, plasticity, friction coefficient.

    Raises InputError for values outside these and for combinations without meaning, with what to write instead.
    """
    moments = spectral_moments(heights, pixel_size, detrend=detrend, periodic=periodic, step=step)
    return thresholds_of_moments(
        moments,
        model=model,
        law=law,
        material=material,
        pressure=pressure,
        patch_area=patch_area,
        height_law=height_law,
    )


def thresholds_of_moments(
    moments: SpectralMoments,
    *,
    model: str,
    law: str,
    material: Material,
    pressure: float,
    patch_area: float | None = None,
    height_law: str = "gaussian",
) -> Thresholds:
    """As from_topography, for a surface whose spectral moments are known."""
    if model not in MODELS:
        refuse("model", model, 'must be "gw" or "persson"')
    if law not in LAWS:
        refuse("law", law, 'must be "paper", "amontons" or "strength"')
    if not isinstance(material, Material):
        refuse("material", material, "must be origins.Material(contact_modulus=..., ...)")
    pressure = positive("pressure", pressure)
    if model == "gw":
        if patch_area is not None:
            refuse("patch_area", patch_area, 'model = "gw" counts its own contacts; leave it out')
        return _on_summits(moments, law, material, pressure, height_law)
    if height_law != "gaussian":
        refuse("height_law", height_law, 'model = "persson" has stresses, not summits; leave it out')
    if patch_area is None:
        dx, dy = moments.pixel_size
        refuse(
            "patch_area",
            patch_area,
            f'model = "persson" needs the area of one contact in m², such as the pixel\'s, patch_area={dx * dy:.3g}',
        )
    return _on_patches(moments, law, material, pressure, positive("patch_area", patch_area))


def resolution_study(
    heights: object,
    pixel_size: object = None,
    *,
    factors: tuple[int, ...] = (1, 2, 4, 8),
    **options: object,
) -> tuple[Thresholds, ...]:
    """from_topography with neighbours 1, 2, 4, ... pixels apart: how all of it moves with the scan's resolution.

    m4, and with it radius and density of the summits, is a property of surface and resolution together. Each
    result carries its moments as `.interface.moments`, with the step and the spacing they were taken at.

    Parameters
    ----------
    heights, pixel_size
        As in from_topography.
    factors : tuple of int
        Spacings in pixels.
    options
        All else that from_topography takes, but for step.

    Raises InputError as from_topography does, and for no factors.
    """
    if not isinstance(factors, tuple | list) or not factors:
        refuse("factors", factors, "must be a tuple of whole numbers, such as (1, 2, 4, 8)")
    if "step" in options:
        refuse("step", options["step"], "is what the study varies; write factors=(1, 2, 4, 8)")
    surface = as_topography(heights, pixel_size)
    steps = [whole("factors", factor, 1) for factor in factors]
    return tuple(from_topography(surface, step=step, **options) for step in steps)  # type: ignore[arg-type]


def _on_summits(moments: SpectralMoments, law: str, material: Material, pressure: float, height_law: str) -> Thresholds:
    scale, exponent = power_of_compression(law, material, moments.summit_radius)
    contact = pressed(moments, material.contact_modulus, pressure, height_law)
    thresholds = contact.thresholds(scale, exponent)
    if law == "paper":
        stiffness = material.needed("force_coefficient", law) * thresholds.mean()
    else:
        stiffness = material.needed("shear_modulus", law) * np.sqrt(np.pi * moments.summit_radius) * contact.mean_root
    plastic = None
    if material.hardness is not None:
        limit = critical_compression(moments.summit_radius, material.contact_modulus, material.hardness)
        plastic = float(thresholds.sf(scale * limit**exponent))
    thresholds.interface = Interface(
        model="gw",
        law=law,
        material=material,
        moments=moments,
        pressure=pressure,
        area_fraction=contact.area_fraction,
        contact_density=contact.contact_density,
        mean_stiffness=float(stiffness),
        friction_coefficient=_friction(thresholds, contact.contact_density, float(stiffness), pressure),
        plasticity_index=_plasticity_index(moments, material),
        plastic_fraction=plastic,
        separation=contact.separation,
    )
    return thresholds


def _on_patches(
    moments: SpectralMoments, law: str, material: Material, pressure: float, patch_area: float
) -> Thresholds:
    scale, exponent = power_of_stress(law, material, patch_area)
    contact = stressed(moments, material.contact_modulus, pressure)
    thresholds = contact.thresholds(scale, exponent)
    if law == "paper":
        stiffness = material.needed("force_coefficient", law) * thresholds.mean()
    else:
        stiffness = material.needed("shear_modulus", law) * np.sqrt(patch_area)
    plastic = None
    if material.hardness is not None:
        plastic = float(thresholds.sf(scale * material.hardness**exponent))
    density = contact.area_fraction / patch_area
    thresholds.interface = Interface(
        model="persson",
        law=law,
        material=material,
        moments=moments,
        pressure=pressure,
        area_fraction=contact.area_fraction,
        contact_density=density,
        mean_stiffness=float(stiffness),
        friction_coefficient=_friction(thresholds, density, float(stiffness), pressure),
        plasticity_index=_plasticity_index(moments, material),
        plastic_fraction=plastic,
        patch_area=patch_area,
    )
    return thresholds


def _friction(thresholds: Thresholds, density: float, stiffness: float, pressure: float) -> float:
    """N<k> <x_s²>/(2<x_s>) over the pressure: the steady state's force, k_i independent of x_i (paper, Eq. Q6)."""
    kinetic = thresholds.moment(2) / (2.0 * thresholds.mean())
    return density * stiffness * kinetic / pressure


def _plasticity_index(moments: SpectralMoments, material: Material) -> float | None:
    if material.hardness is None:
        return None
    sharpness = np.sqrt(moments.summit_std / moments.summit_radius)
    return float(3.0 * material.contact_modulus / material.hardness * sharpness)
