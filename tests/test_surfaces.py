"""Rough surfaces: heights, spectra and moments, summits and stresses, stiffnesses; against closed forms and sums."""

from dataclasses import replace

import mpmath
import numpy as np
import pytest
from scenes import ROUGH, Scan, scene
from scipy.special import erfc, ndtr

import origins
import toolkit
from toolkit.scene.interfaces import doubts

# -- from moments to thresholds --------------------------------------------------------------------

SEEN = {"step": 1, "pixel_size": (2e-6, 3e-6), "missing_fraction": 0.0, "used_fraction": 1.0}
MOMENTS = origins.SpectralMoments(m0=4e-14, m2_axes=(0.004, 0.003), m4_axes=(2e9, 3e9), **SEEN)
E_STAR, MU, G, H, TAU, C = 3e9, 0.4, 1.1e9, 2.5e8, 6e7, 2e10
STRONG = {"hardness": H, "shear_strength": TAU, "force_coefficient": C}
MATERIAL = origins.Material(contact_modulus=E_STAR, local_friction=MU, shear_modulus=G, **STRONG)
PATCH = 5e-12


def root_rule(*edges: float) -> tuple[np.ndarray, np.ndarray]:
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
        ("strength", "exponential", 5e6, "plastic"),
    ],
)
def test_summits_against_sums_over_heights(
    law: str, height_law: str, pressure: float, regime: str
) -> None:
    asked = {"model": "gw", "law": law, "height_law": height_law, "regime": regime}
    found = origins.from_moments(MOMENTS, material=MATERIAL, pressure=pressure, **asked)
    i = found.interface
    assert i is not None and i.separation is not None
    std, radius = MOMENTS.summit_std, MOMENTS.summit_radius
    limit, z = radius * (0.75 * np.pi * H / E_STAR) ** 2, i.separation / std

    def bears(d: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Load and elastic area of summits pressed down by d."""
        hertz, area = 4.0 / 3.0 * E_STAR * np.sqrt(radius) * d**1.5, np.pi * radius * d
        plastic = {"elastic": False, "plastic": True, "mixed": hertz > H * area}[regime]
        return np.where(plastic, H * area, hertz), area

    def beyond(d: np.ndarray) -> np.ndarray:
        """Share of all summits that are pressed down by more than d."""
        return ndtr(-z - d / std) if height_law == "gaussian" else np.exp(-1.0 - z - d / std)

    step = std / max(z, 1.0) if height_law == "gaussian" else std
    edges = [0.0, step, 8 * step, 60 * step, *([limit] if limit < 60 * step else [])]
    d, weights = root_rule(*edges)
    # from the summits' mean plane: exponential heights begin at -1, so that their mean is 0
    h = z + d / std
    gauss, exponential = np.exp(-0.5 * h * h) / np.sqrt(2 * np.pi), np.exp(-1.0 - h)
    density = gauss if height_law == "gaussian" else exponential
    often = MOMENTS.summit_density * weights * density / std
    assert_sums(found, law, pressure, often, *bears(d))
    for at in (0.05 * std, 0.3 * std, std, 0.1 * limit, 0.9 * limit, 1.1 * limit, 7 * limit):
        force, x = one_contact(law, *bears(np.array(at)))
        assert float(i.force_threshold(x)) == pytest.approx(float(force), rel=1e-12)
        assert float(found.sf(x)) == pytest.approx(beyond(at) / beyond(0.0), rel=1e-8, abs=1e-300)
    # plastic where the elastic load exceeds what the hardness bears over pi r delta
    plastic = 1.0 if regime == "plastic" else beyond(limit) / beyond(0.0)
    assert i.plastic_fraction == pytest.approx(plastic, rel=1e-10) and i.regime == regime
    loads, over = often * bears(d)[0], d > limit if regime != "plastic" else d > 0.0
    assert i.plastic_load_fraction == pytest.approx(loads[over].sum() / loads.sum(), rel=1e-6)
    assert i.plasticity_index == pytest.approx(E_STAR / (H / 3) * np.sqrt(std / radius), rel=1e-12)
    assert i.mean_plane_separation == i.separation + MOMENTS.summit_offset


@pytest.mark.parametrize(("law", "pressure"), [("paper", 1.5e8), ("amontons", 1e3)])
def test_stresses_against_sums_over_the_stress_distribution(law: str, pressure: float) -> None:
    options = {"law": law, "material": MATERIAL, "pressure": pressure}
    found = origins.from_moments(MOMENTS, model="persson", patch_area=PATCH, **options)
    width = E_STAR * MOMENTS.rms_slope / np.sqrt(2)
    s, weights = root_rule(0.0, *(pressure + k * width for k in (0, 1, 3, 8)))
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
    s, weights = root_rule(H, *(H + k * width for k in (1, 3, 8)))
    density = np.exp(-(((s - pressure) / width) ** 2)) * -np.expm1(-4 * s * pressure / width**2)
    borne = float((weights * s * density).sum()) / (width * np.sqrt(np.pi)) / pressure
    assert i.plastic_load_fraction == pytest.approx(borne, rel=1e-6)
    assert found.onset_power == (1.0 if law == "amontons" else 3.0)
    assert float(found.pdf(0.0)) == 0.0 and found.std() > 0.0


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
IN_GPA = replace(SOFT, contact_modulus=1.8, shear_modulus=1.1)
UNSCALED = origins.moments_of_summits(radius=1.1, std=0.03, density=2.1)  # in micrometres
EVENLY_STIFF = replace(SOFT, shear_modulus=None, contact_stiffness=EVEN)
POINTED = origins.moments_of_summits(radius=1e-8, std=5e-8, density=1e12)
PATCHES = {"model": "persson", "patch_area": PATCH}


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (PATCHES | {"pressure": 5e7}, "contacts cover 31% of the surface: neighb"),
        (PATCHES | {"pressure": 1e9}, "full contact"),
        ({"moments": STEEP}, "rms slope is 0.77"),
        ({"moments": UNEVEN}, "and across its ridges differ by a factor 2:"),
        ({"material": SOFTER}, "would be plastic, and are taken as elastic"),
        ({"material": HARDER, "regime": "plastic"}, "by Hertz' theory, and all"),
        ({"moments": replace(FINE, pixel_size=(1e-7, 1e-6))}, "pixels: the scan does not res"),
        ({"moments": replace(SCAN, size=(0.2, 1e-4))}, "0.2 m across: is the unit right?"),
        (PATCHES | {"moments": SCAN, "patch_area": 9.9e-15}, "is below the 1e-14 m² of a pixel"),
        ({"material": EVENLY_STIFF}, "is above the local 0.4: Eq. Q6"),
        (
            {"moments": POINTED},
            "m is above the summits' 10 nm, and Hertz' theory needs one far below",
        ),
        ({"material": replace(SOFT, shear_modulus=1e3)}, "contacts stretch by 60 mm, above the"),
        ({"pressure": 1.0}, "pressure is 1 Pa: is the unit right?"),
        ({"material": IN_GPA, "pressure": 1e-4}, "contact_modulus is 1.8 Pa: is the unit right?"),
        ({"moments": UNSCALED}, " mm: is the unit right?"),
    ],
)
def test_one_strain_at_a_time_is_said(change: dict, says: str) -> None:
    usual = {"moments": FINE, "model": "gw", "law": "amontons", "material": SOFT, "pressure": 1e5}
    for calm in ({}, PATCHES):
        assert origins.from_moments(**usual | calm).interface.cautions == ()
    assert any(says in line for line in origins.from_moments(**usual | change).interface.cautions)


@pytest.mark.parametrize(
    ("hardness", "said"),
    [
        (
            200.0,
            "= 200 Pa is 7e-08 of contact_modulus: did you mean 200 MPa? Then write hardness = 2e+08",
        ),
        (
            0.2,
            "= 0.2 Pa is 7e-11 of contact_modulus: did you mean 0.2 GPa? Then write hardness = 2e+08",
        ),
        (1e-12, "of contact_modulus: is the unit right?"),
    ],
)
def test_a_hardness_in_another_unit_is_asked_about(hardness: float, said: str) -> None:
    """Which regime to take is not said of it: all contacts are plastic at 200 Pa."""
    usual = {"moments": FINE, "model": "gw", "law": "amontons", "pressure": 1e5}
    law = origins.from_moments(material=replace(SOFT, hardness=hardness), **usual)
    (doubt,) = doubts(origins.Contacts(law))
    assert doubt.startswith("hardness ") and doubt.endswith(said)


SUMMITS = origins.moments_of_summits(radius=20e-6, std=0.2e-6, density=3e9)


# -- stiffness of contacts -------------------------------------------------------------------------

COMMON = {"contact_modulus": 3e9, "local_friction": 0.3, "hardness": 3e8, "shear_strength": 2e7}
AREA = np.array([1e-16, 3e-13, 2e-10])


def test_the_three_laws_as_they_are_printed() -> None:
    radius = np.sqrt(AREA / np.pi)
    # Mindlin: 8 a G*, 1/G* = (2 - nu_1)/G_1 + (2 - nu_2)/G_2
    reduced = 1 / ((2 - 0.3) / 1e9 + (2 - 0.45) / 8e10)
    # a beam of moment of inertia pi r_c⁴/4, bent by a force at its free end: 3 E I/h³
    beam = 3 * 2.6e9 * np.pi * radius**4 / 4
    for law, exact in (
        (origins.sound_stiffness(1200.0, 900.0), 1200 * 900**2 * np.sqrt(AREA)),
        (origins.mindlin_stiffness((1e9, 8e10), (0.3, 0.45)), 8 * radius * reduced),
        (origins.mindlin_stiffness(1e9, 0.3), 4e9 * np.sqrt(AREA) / ((2 - 0.3) * np.sqrt(np.pi))),
        (origins.column_stiffness(2.6e9, aspect=0.4), beam / (radius / 0.4) ** 3),
        (origins.column_stiffness(2.6e9, height=3e-7), beam / 3e-7**3),
    ):
        assert law(AREA) == pytest.approx(exact, rel=1e-13)


def test_another_power_of_the_area_shapes_the_law() -> None:
    """k = kappa A^p under Amontons: x_s ~ delta^(3/2 - p), so P_c ~ x^(1/(3/2 - p) - 1); all of it still adds up."""
    for exponent in (0.2, 1.0):
        stiff = origins.PowerLaw(1e9 * 1e-12 ** (0.5 - exponent), exponent)
        material = origins.Material(**COMMON, contact_stiffness=stiff)
        found = origins.from_moments(
            SUMMITS, model="gw", law="amontons", material=material, pressure=3e5
        )
        assert found.onset_power == pytest.approx(1 / (1.5 - exponent) - 1, abs=1e-14)
        load, area = 4 / 3 * 3e9 * np.sqrt(20e-6) * (1e-7) ** 1.5, np.pi * 20e-6 * 1e-7
        x = 0.3 * load / float(stiff(area))
        i = found.interface
        assert i is not None and i.separation is not None
        beyond = mpmath.ncdf(-(i.separation + 1e-7) / 0.2e-6) / mpmath.ncdf(-i.separation / 0.2e-6)
        assert float(found.sf(x)) == pytest.approx(float(beyond), rel=1e-11)


def test_a_scene_names_stiffness_and_summits() -> None:
    stiffness = {"kind": "mindlin", "shear_modulus": 1e9, "poisson_ratio": 0.3}
    law = ROUGH | {"pressure": 3e5, "material": COMMON | {"contact_stiffness": stiffness}}

    def read(surface: dict) -> origins.Interface:
        asked = scene(law | {"surface": surface}, drive={"to": 1e-7, "points": 3})
        return toolkit.load_scene(asked).contacts.interface

    material = origins.Material(**COMMON, contact_stiffness=origins.mindlin_stiffness(1e9, 0.3))
    options = {"model": "gw", "law": "amontons", "material": material, "pressure": 3e5}
    summits = {"kind": "summits", "radius": 20e-6, "std": 0.2e-6, "density": 3e9}
    assert read(summits) == origins.from_moments(SUMMITS, **options).interface
    spectrum = {"wavevectors": [1e5, 1e6, 6e7], "power": [1e-26, 1e-26, 2e-32]}
    moments = origins.moments_of_spectrum(**spectrum)
    assert read({"kind": "spectrum", **spectrum}).moments == moments


# -- heights ---------------------------------------------------------------------------------------


def by_loops(h: np.ndarray, dx: float, dy: float, step: int) -> list[float]:
    """Mean squares of the two slopes and the two curvatures, point by point, where both are known."""
    slopes, curvatures = [], []
    for i, j in np.ndindex(h.shape):
        if i + step < h.shape[0] and j + step < h.shape[1]:
            here, right, up = h[i, j], h[i + step, j], h[i, j + step]
            slopes.append([(right - here) / (step * dx), (up - here) / (step * dy)])
        if min(i, j) >= step and i + step < h.shape[0] and j + step < h.shape[1]:
            along = h[i + step, j] - 2 * h[i, j] + h[i - step, j]
            across = h[i, j + step] - 2 * h[i, j] + h[i, j - step]
            curvatures.append([along / (step * dx) ** 2, across / (step * dy) ** 2])
    known = ([pair for pair in pairs if np.isfinite(pair).all()] for pairs in (slopes, curvatures))
    return [float(mean) for pairs in known for mean in np.mean(np.square(pairs), axis=0)]


@pytest.mark.parametrize(("step", "missing"), [(1, 0.0), (3, 0.05)])
def test_moments_equal_plain_loops(step: int, missing: float) -> None:
    h = 0.1 * np.random.default_rng(2).standard_normal((17, 23)).cumsum(axis=0).cumsum(axis=1)
    there = np.random.default_rng(3).random(h.shape) >= missing
    x, y = np.meshgrid(0.2 * np.arange(17), 0.5 * np.arange(23), indexing="ij")
    for detrend, terms in (
        ("tilt", [h * 0 + 1, x, y]),
        ("curvature", [h * 0 + 1, x, y, x * x, y * y, x * y]),
    ):
        basis = np.stack([term[there] for term in terms], axis=1)
        level = np.full(h.shape, np.nan)
        level[there] = h[there] - basis @ np.linalg.lstsq(basis, h[there], rcond=None)[0]
        given = np.where(there, h, np.nan)
        moments = origins.spectral_moments(given, (0.2, 0.5), detrend=detrend, step=step)
        found = (*moments.m2_axes, *moments.m4_axes)
        assert found == pytest.approx(by_loops(level, 0.2, 0.5, step), rel=1e-10)
        assert moments.m0 == pytest.approx(np.nanmean(level**2), rel=1e-10)
        assert moments.missing_fraction == np.isnan(given).mean()
        assert moments.pixel_size == (0.2 * step, 0.5 * step)


def test_summits_of_a_gaussian_surface_are_those_the_moments_say() -> None:
    """Nayak's results are exact for Gaussian surfaces; here some 5,000 summits are looked up one by one."""
    found, predicted = [], []
    for seed in range(6):
        cutoffs = {"long_cutoff": 60.0, "short_cutoff": 10.0}
        h = origins.self_affine_surface(
            (640, 400), (1.0, 1.3), hurst=0.8, rms_slope=0.1, seed=seed, **cutoffs
        )
        m = origins.spectral_moments(h, (1.0, 1.3), detrend="centre", periodic=True)
        around = [np.roll(h, (i, j), (0, 1)) for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j]
        top = np.all([h > other for other in around], axis=0)
        along, across = (h - (np.roll(h, 1, k) + np.roll(h, -1, k)) / 2 for k in (0, 1))
        found.append(np.stack([h[top], (along + across / 1.69)[top]]))
        predicted.append(
            (m.summit_density * h.size * 1.3, m.summit_offset, m.summit_std, 1.0 / m.summit_radius)
        )
    heights, curvatures = np.concatenate(found, axis=1)
    number, offset, std, curvature = np.mean(predicted, axis=0)
    assert heights.size > 4000 and heights.size / 6 == pytest.approx(number, rel=0.04)
    assert heights.mean() == pytest.approx(offset, rel=0.02)
    assert heights.std() == pytest.approx(std, rel=0.02)
    assert curvatures.mean() == pytest.approx(curvature, rel=0.02)


def test_objects_are_converted_by_their_unit_and_masks_are_missing_points() -> None:
    h = np.random.default_rng(4).standard_normal((12, 15))
    plain = origins.spectral_moments(h * 1e-9, (5e-9, 7e-9))
    units = {"nm": 1.0, "m": 1e-9, "µm": 1e-3, "μm": 1e-3, "Å": 10.0, "mm": 1e-6}
    for unit, factor in units.items():
        scan = origins.spectral_moments(Scan(h * factor, (5.0 * factor, 7.0 * factor), unit))
        assert scan.m0 == pytest.approx(plain.m0, rel=1e-12)
        assert scan.pixel_size == pytest.approx((5e-9, 7e-9))
    mask = np.random.default_rng(5).random(h.shape) < 0.05
    masked, lost = np.ma.array(h, mask=mask), np.where(mask, np.nan, h)
    assert origins.spectral_moments(masked, 1.0) == origins.spectral_moments(lost, 1.0)


# -- spectra ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["isotropic", "profile"])
def test_gaussian_correlations_in_closed_form_in_order(kind: str) -> None:
    """<h(x)h(0)> = s² e^(-x²/l²): m0 = s², m2 = 2 s²/l², m4 = 12 s²/l⁴; between points the error is of second order."""
    s, length = 3e-8, 7e-7
    errors = []
    for points in (40, 80, 160):
        q = np.linspace(1e-4, 12.0, points) / length
        shape = np.exp(-((q * length) ** 2) / 4)
        whole = {"isotropic": np.pi * length**2, "profile": np.sqrt(np.pi) * length}[kind]
        found = origins.moments_of_spectrum(q, s**2 * whole * shape, convention=kind)
        exact = s**2, 2 * s**2 / length**2, 12 * s**2 / length**4
        errors.append(
            [abs(a / b - 1) for a, b in zip((found.m0, found.m2, found.m4), exact, strict=True)]
        )
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert np.abs(orders[-1, 1:] - 2.0).max() < 0.2 and max(errors[-1]) < 4e-3


def test_a_spectrum_and_the_surface_that_has_it_give_the_same_thresholds() -> None:
    """Mode by mode: its slope to half a per cent, m0 but for the lowest q."""
    pixel, n = 20e-9, 512
    cutoffs = {"long_cutoff": 4e-6, "short_cutoff": 16 * pixel}
    given = {"hurst": 0.8, "rms_slope": 0.1, "seed": 2, **cutoffs}
    heights = origins.self_affine_surface((n, n), pixel, **given)
    few = n // 16 + 1
    power = np.abs(np.fft.fft2(heights) / n**2)[1:few, 0] ** 2 * (n * pixel) ** 2
    found = origins.moments_of_spectrum(2 * np.pi * np.fft.fftfreq(n, pixel)[1:few], power)
    usual = {"law": "amontons", "material": SOFT, "pressure": 1e6}
    for model, within in (
        ({"model": "persson", "patch_area": 1e-14}, 0.005),
        ({"model": "gw"}, 0.05),
    ):
        options, level = usual | model, {"detrend": "centre", "periodic": True}
        one = origins.from_moments(found, **options)
        other = origins.from_topography(heights, pixel, **level, **options)
        assert one.mean() == pytest.approx(other.mean(), rel=within)
        share = other.interface.area_fraction
        assert one.interface.area_fraction == pytest.approx(share, rel=within)


# -- generated surfaces ----------------------------------------------------------------------------


def modes(h: np.ndarray, dx: float, dy: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """|a_q|², q_x, q_y over the full plane, off the heights alone."""
    power = np.abs(np.fft.fft2(h) / h.size) ** 2
    q_x, q_y = (2 * np.pi * np.fft.fftfreq(n, d) for n, d in zip(h.shape, (dx, dy), strict=True))
    return power, *np.meshgrid(q_x, q_y, indexing="ij")


@pytest.mark.parametrize("shape", [(128, 128), (63, 48)])
def test_a_generated_surface_has_the_spectrum_and_slope_asked_for(shape: tuple[int, int]) -> None:
    """Flat, then a power, then nothing; the moments by differences see each mode with its transfer factor."""
    pixels, hurst, longest, shortest = (1.0, 1.5), 0.7, 40.0, 5.0
    cutoffs = {"long_cutoff": longest, "short_cutoff": shortest}
    h = origins.self_affine_surface(shape, pixels, hurst=hurst, rms_slope=0.2, seed=3, **cutoffs)
    power, q_x, q_y = modes(h, *pixels)
    q, low, high = np.hypot(q_x, q_y), 2 * np.pi / longest, 2 * np.pi / shortest
    falls = np.where((q > 0) & (q <= high), np.maximum(q, low) ** (-2 - 2 * hurst), 0.0)
    constant = 0.2**2 / (falls * q**2).sum()
    assert np.abs(power - constant * falls).max() < 1e-12 * power.max()
    moments = origins.spectral_moments(h, pixels, detrend="centre", periodic=True)
    seen_x, seen_y = (
        q_i * np.sinc(q_i * d / (2 * np.pi)) for q_i, d in zip((q_x, q_y), pixels, strict=True)
    )
    assert moments.m0 == pytest.approx(power.sum(), rel=1e-11)
    assert moments.m2 == pytest.approx(0.5 * (power * (seen_x**2 + seen_y**2)).sum(), rel=1e-11)
    assert moments.m4 == pytest.approx(0.5 * (power * (seen_x**4 + seen_y**4)).sum(), rel=1e-11)
    # the unit of its lengths is the user's
    finer = {name: 1e-9 * length for name, length in cutoffs.items()}
    sizes = 1e-9, 1.5e-9
    small = origins.self_affine_surface(shape, sizes, hurst=hurst, rms_slope=0.2, seed=3, **finer)
    assert np.abs(1e9 * small - h).max() < 1e-12 * h.std()


@pytest.mark.parametrize("ridges", [(0, 0), (4, 0), (4, 4), (4, -4), (0, 4)])
def test_ridges_in_any_direction_are_cautioned(ridges: tuple[int, int]) -> None:
    """Waves in one direction beside noise of a thousandth of their height; and equal waves along both axes."""
    x, y = 2.0 * np.pi / 128 * np.indices((128, 128))
    noise = np.random.default_rng(1).normal(scale=1e-3, size=x.shape)
    waves = np.sin(ridges[0] * x + ridges[1] * y) if any(ridges) else np.sin(4 * x) + np.sin(4 * y)
    moments = origins.spectral_moments((waves + noise) * 1e-8, 1e-7, detrend="centre")
    assert moments.unevenness < 1.05 if not any(ridges) else moments.unevenness > 5.0


def test_heights_that_cannot_be_meant_are_refused_or_cautioned() -> None:
    """Metres for nanometres, a value that fills gaps, and gaps filled with zeros."""
    heights = origins.self_affine_surface(
        shape=(64, 64), pixel_size=1e-8, hurst=0.8, rms_slope=0.2, seed=1
    )
    with pytest.raises(
        origins.InputError, match=r"read as \S+ m of height on \S+ m x \S+ m: .*\(surface.unit"
    ):
        origins.spectral_moments(1e9 * heights, 1e-8)
    assert origins.spectral_moments(40.0 * heights, 1e-8).rms_slope > 5.0
    filled = heights.copy()
    filled[::16, ::8] = -9999.0
    with pytest.raises(
        origins.InputError,
        match=r"32 heights of -9999 \(with the surface's unit and scale\) may be",
    ):
        origins.spectral_moments(filled, 1e-8)
    filled[filled == -9999.0] = 0.0
    assert origins.spectral_moments(filled, 1e-8).zero_fraction == 32 / 64**2
    digits = (
        np.round(heights / 1e-9) * 1e-9
    )  # of a coarse converter: many heights are 0, and many are not
    assert (digits == 0.0).mean() > 1e-3 and origins.spectral_moments(
        digits, 1e-8
    ).zero_fraction == 0.0
