"""From moments to thresholds: each contact model and threshold law against a second road."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import erfc, ndtr

import origins
from origins.roughness.from_surface import from_moments
from origins.roughness.greenwood_williamson import critical_compression
from origins.roughness.spectral_moments import SpectralMoments

MOMENTS = SpectralMoments(
    m0=4e-14,
    m2_axes=(0.004, 0.003),
    m4_axes=(2e9, 3e9),
    step=1,
    pixel_size=(2e-6, 3e-6),
    missing_fraction=0.0,
    used_fraction=1.0,
)
E_STAR, MU, G, H, TAU, C = 3e9, 0.4, 1.1e9, 2.5e8, 6e7, 2e10
MATERIAL = origins.Material(
    contact_modulus=E_STAR,
    local_friction=MU,
    shear_modulus=G,
    hardness=H,
    shear_strength=TAU,
    force_coefficient=C,
)
PATCH = 5e-12


def rule(*edges: float) -> tuple[np.ndarray, np.ndarray]:
    """Gauss-Legendre nodes and weights between edges, in s = x^(1/4), for roots of x at 0."""
    t, w = np.polynomial.legendre.leggauss(60)
    ends = np.unique(edges) ** 0.25
    half = 0.5 * np.diff(ends)[:, None]
    s = ends[:-1, None] + half * (1.0 + t)
    return s.ravel() ** 4, (half * w * 4.0 * s**3).ravel()


def one_contact(law: str, load: np.ndarray, area: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Force and stretch at which a contact breaks, written out."""
    force = TAU * area if law == "strength" else MU * load
    return force, np.sqrt(force / C) if law == "paper" else force / (G * np.sqrt(area))


def assert_sums(
    found: origins.Thresholds, law: str, pressure: float, often: np.ndarray, load: np.ndarray, area
) -> None:
    """All numbers of the record against sums over contacts, `often` of each in an area."""
    i = found.interface
    assert i is not None
    force, x = one_contact(law, load, area)
    number, k = often.sum(), force / x
    stiffness = often @ k / number
    assert often @ load == pytest.approx(pressure, rel=1e-9)
    assert i.contact_density == pytest.approx(number, rel=1e-9)
    assert i.area_fraction == pytest.approx(often @ area, rel=1e-9)
    assert found.mean() == pytest.approx(often @ x / number, rel=1e-9)
    assert found.moment(2) == pytest.approx(often @ x**2 / number, rel=1e-9)
    assert i.mean_stiffness == pytest.approx(stiffness, rel=1e-8)
    kinetic = number * stiffness * found.moment(2) / (2 * found.mean())
    assert i.friction_coefficient == pytest.approx(kinetic / pressure, rel=1e-8)
    assert i.mean_load == pytest.approx(pressure / number, rel=1e-9)
    assert i.mean_area == pytest.approx(often @ area / number, rel=1e-9)
    assert i.mean_radius == pytest.approx(often @ np.sqrt(area / np.pi) / number, rel=1e-9)
    assert i.mean_force_threshold == pytest.approx(often @ force / number, rel=1e-9)


@pytest.mark.parametrize(
    ("law", "height_law", "pressure", "regime"),
    [
        ("paper", "exponential", 5e6, "mixed"),
        ("paper", "gaussian", 1.0, "elastic"),
        ("amontons", "gaussian", 5e6, "mixed"),
        ("strength", "gaussian", 5e6, "elastic"),
        ("strength", "exponential", 5e6, "plastic"),
    ],
)
def test_summits_against_sums_over_heights(
    law: str, height_law: str, pressure: float, regime: str
) -> None:
    asked = {"model": "gw", "law": law, "height_law": height_law, "regime": regime}
    found = from_moments(MOMENTS, material=MATERIAL, pressure=pressure, **asked)
    i = found.interface
    assert i is not None and i.separation is not None
    std, radius = MOMENTS.summit_std, MOMENTS.summit_radius
    limit, z = critical_compression(radius, E_STAR, H), i.separation / std

    def bears(d: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Load and elastic area of summits pressed down by d."""
        hertz, area = 4.0 / 3.0 * E_STAR * np.sqrt(radius) * d**1.5, np.pi * radius * d
        plastic = {"elastic": False, "plastic": True, "mixed": hertz > H * area}[regime]
        return np.where(plastic, H * area, hertz), area

    def beyond(d: np.ndarray) -> np.ndarray:
        """Share of all summits that are pressed down by more than d."""
        return ndtr(-z - d / std) if height_law == "gaussian" else np.exp(-z - d / std)

    step = std / max(z, 1.0) if height_law == "gaussian" else std
    edges = [0.0, step, 8 * step, 60 * step, *([limit] if limit < 60 * step else [])]
    d, weights = rule(*edges)
    h = z + d / std
    density = np.exp(-0.5 * h * h) / np.sqrt(2 * np.pi) if height_law == "gaussian" else np.exp(-h)
    often = MOMENTS.summit_density * weights * density / std
    assert_sums(found, law, pressure, often, *bears(d))
    for at in (0.05 * std, 0.3 * std, std, 0.1 * limit, 0.9 * limit, 1.1 * limit, 7 * limit):
        force, x = one_contact(law, *bears(np.array(at)))
        assert float(i.force_threshold(x)) == pytest.approx(float(force), rel=1e-12)
        assert float(found.sf(x)) == pytest.approx(beyond(at) / beyond(0.0), rel=1e-8, abs=1e-300)
    # plastic where the elastic load exceeds what the hardness bears over pi r delta
    plastic = 1.0 if regime == "plastic" else beyond(limit) / beyond(0.0)
    assert i.plastic_fraction == pytest.approx(plastic, rel=1e-10) and i.regime == regime
    assert i.plasticity_index == pytest.approx(E_STAR / (H / 3) * np.sqrt(std / radius), rel=1e-12)
    assert i.mean_plane_separation == i.separation + MOMENTS.summit_offset


@pytest.mark.parametrize(("law", "pressure"), [("paper", 1.5e8), ("amontons", 1e3)])
def test_stresses_against_sums_over_the_stress_distribution(law: str, pressure: float) -> None:
    options = {"law": law, "material": MATERIAL, "pressure": pressure}
    found = from_moments(MOMENTS, model="persson", patch_area=PATCH, **options)
    width = E_STAR * MOMENTS.rms_slope / np.sqrt(2)
    s, weights = rule(0.0, pressure, pressure + width, pressure + 3 * width, pressure + 8 * width)
    # e^-((s-p)/D)² - e^-((s+p)/D)², its difference by expm1
    towards, mirrored = np.exp(-(((s - pressure) / width) ** 2)), -4 * s * pressure / width**2
    often = weights * towards * -np.expm1(mirrored) / (width * np.sqrt(np.pi)) / PATCH
    area = np.full(s.shape, PATCH)
    assert_sums(found, law, pressure, often, s * PATCH, area)

    def beyond(at: float) -> float:
        near, far = ((at + sign * pressure) / width for sign in (-1, 1))
        return 0.5 * float(erfc(near) - erfc(far))

    i = found.interface
    assert i is not None
    for at in (0.2 * width, width, pressure + width):
        force, x = one_contact(law, np.array(at * PATCH), np.array(PATCH))
        assert float(found.sf(x)) == pytest.approx(beyond(at) / beyond(0.0), rel=1e-8)
        assert float(i.force_threshold(x)) == pytest.approx(float(force), rel=1e-12)
    assert i.plastic_fraction == pytest.approx(beyond(H) / beyond(0.0), rel=1e-8)
    assert found.onset_power == (1.0 if law == "amontons" else 3.0)
    assert float(found.pdf(0.0)) == 0.0 and found.std() > 0.0


@pytest.mark.parametrize(("model", "law"), [("gw", "strength"), ("persson", "amontons")])
def test_lengths_and_moduli_scale(model: str, law: str) -> None:
    h = origins.self_affine_surface(
        (48, 40), (1e-7, 2e-7), hurst=0.8, rms_slope=0.1, seed=1, short_cutoff=8e-7
    )

    def made(length: float, modulus: float) -> origins.Thresholds:
        constants = {
            "contact_modulus": E_STAR,
            "shear_modulus": G,
            "hardness": H,
            "shear_strength": TAU,
        }
        material = origins.Material(
            **{k: v * modulus for k, v in constants.items()}, local_friction=MU
        )
        patch = PATCH * length**2 if model == "persson" else None
        sizes = 1e-7 * length, 2e-7 * length
        options = {
            "model": model,
            "law": law,
            "material": material,
            "pressure": 1e5 * modulus,
            "patch_area": patch,
        }
        return origins.from_topography(h * length, sizes, **options)

    one, other = made(1.0, 1.0), made(1e9, 1e-3)
    q = np.array([1e-6, 0.1, 0.5, 0.999])
    assert other.isf(q) == pytest.approx(one.isf(q) * 1e9, rel=1e-9)
    a, b = one.interface, other.interface
    assert b.contact_density == pytest.approx(a.contact_density / 1e18, rel=1e-9)
    assert b.mean_stiffness == pytest.approx(a.mean_stiffness * 1e6, rel=1e-9)
    for name in ("area_fraction", "friction_coefficient", "plasticity_index", "plastic_fraction"):
        assert getattr(b, name) == pytest.approx(getattr(a, name), rel=1e-8)


def test_resolution_study_is_the_same_call_at_each_step() -> None:
    h = origins.self_affine_surface((96, 80), 1e-7, hurst=0.7, rms_slope=0.1, seed=2)
    options = {"model": "gw", "law": "amontons", "material": MATERIAL, "pressure": 1e5}
    options |= {"detrend": "tilt"}
    study = origins.resolution_study(h, 1e-7, factors=(1, 2, 4), **options)
    for step, found in zip((1, 2, 4), study, strict=True):
        alone = origins.from_topography(h, 1e-7, step=step, **options)
        assert found.interface == alone.interface and found.mean() == alone.mean()
        assert found.interface is not None
        moments = origins.spectral_moments(h, 1e-7, detrend="tilt", step=step)
        assert found.interface.moments == moments
    m4 = [t.interface.moments.m4 for t in study if t.interface]
    assert m4[0] > 2 * m4[1] > 4 * m4[2]


FINE = replace(MOMENTS, m2_axes=(0.0035, 0.0035), pixel_size=None)
SCAN = replace(FINE, pixel_size=(1e-7, 1e-7), size=(5e-4, 5e-4))
STEEP, UNEVEN = replace(FINE, m2_axes=(0.3, 0.3), m0=1e-10), replace(FINE, m2_axes=(0.004, 0.001))
HARDER, SOFTER = replace(MATERIAL, hardness=1e10), replace(MATERIAL, hardness=2.5e7)
SOFT = replace(MATERIAL, hardness=None)
EVEN = origins.PowerLaw(1e3, 0.0)
EVENLY_STIFF = replace(SOFT, shear_modulus=None, contact_stiffness=EVEN)
PATCHES = {"model": "persson", "patch_area": PATCH}


@pytest.mark.parametrize(
    ("calm", "change", "says"),
    [
        (PATCHES, {"pressure": 5e7}, "contacts cover 31% of the surface: neighb"),
        (PATCHES, {"pressure": 1e9}, "full contact"),
        ({}, {"moments": STEEP}, "rms slope is 0.77"),
        ({}, {"moments": UNEVEN}, "the two axes differ by a factor 2:"),
        ({}, {"pressure": 3e7}, "contacts cover"),
        ({}, {"material": SOFTER}, "would be plastic, and are taken as elastic"),
        ({}, {"material": HARDER, "regime": "plastic"}, "by Hertz' theory, and all"),
        ({}, {"material": replace(SOFT, shear_modulus=1e6)}, "slip after"),
        ({}, {"moments": replace(FINE, pixel_size=(1e-7, 1e-6))}, "pixels: the scan does not res"),
        ({}, {"moments": replace(SCAN, size=(0.2, 1e-4))}, "0.2 m across: is the unit right?"),
        ({}, {"moments": SCAN, "pressure": 1.0}, "contacts, fewer than one: what they bear extra"),
        (PATCHES, {"moments": SCAN, "patch_area": 9.9e-15}, "is below the 1e-14 m² of a pixel"),
        (PATCHES, {"moments": SCAN, "patch_area": 2.6e-7}, "is above the 2.5e-07 m² of the scan"),
        ({}, {"material": EVENLY_STIFF}, "is above the local 0.4: Eq. Q6"),
    ],
)
def test_one_strain_at_a_time_is_said(calm: dict, change: dict, says: str) -> None:
    usual = {"moments": FINE, "model": "gw", "law": "amontons", "material": SOFT, "pressure": 1e5}
    assert from_moments(**usual | calm).interface.cautions == ()
    assert any(says in line for line in from_moments(**usual | calm | change).interface.cautions)
