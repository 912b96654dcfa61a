"""Measured scans, where they are at hand: the slopes are SurfaceTopography's, thresholds come out in metres."""

import itertools
from pathlib import Path

import numpy as np
import pytest

import origins

DATA = Path(__file__).resolve().parents[2] / "shared" / "data"
pytestmark = pytest.mark.skipif(not DATA.is_dir(), reason="no measured scans beside the project")

SCANS = {"afm-10um.di": (34.4e-9, 0.192), "confocal-88um.al3d": (259e-9, 0.0896), "matrix-28um.txt": (70.9e-9, 0.0675)}
STEEL = origins.Material(
    contact_modulus=115e9,
    local_friction=0.5,
    shear_modulus=80e9,
    hardness=2e9,
    shear_strength=1e9,
    force_coefficient=6.4e12,
)


@pytest.fixture(scope="module", params=SCANS)
def scan(request):  # type: ignore[no-untyped-def]
    surface_topography = pytest.importorskip("SurfaceTopography")
    return request.param, surface_topography.open_topography(DATA / request.param).topography()


def test_height_and_slope_after_removing_curvature(scan) -> None:  # type: ignore[no-untyped-def]
    name, topography = scan
    moments = origins.spectral_moments(topography)
    height, slope = SCANS[name]
    assert float(f"{moments.rms_height:.3g}") == height and float(f"{moments.rms_slope:.3g}") == slope
    assert moments.rms_slope == pytest.approx(float(topography.detrend("curvature").rms_gradient()), rel=1e-8)
    assert moments.used_fraction == 1.0


def test_curvature_is_that_of_its_second_derivative(scan) -> None:  # type: ignore[no-untyped-def]
    _, topography = scan
    level = topography.detrend("curvature")
    bent = level.derivative(2)
    metres = {"nm": 1e-9, "m": 1.0}[topography.unit]
    moments = origins.spectral_moments(topography)
    assert moments.m4 == pytest.approx(0.5 * sum(float(np.mean(b**2)) for b in bent) / metres**2, rel=1e-7)


def test_array_and_object_agree(scan) -> None:  # type: ignore[no-untyped-def]
    _, topography = scan
    metres = {"nm": 1e-9, "m": 1.0}[topography.unit]
    heights = np.ma.filled(topography.heights(), np.nan) * metres
    sizes = tuple(float(size) * metres for size in topography.pixel_size)
    assert origins.spectral_moments(heights, sizes) == origins.spectral_moments(topography)


def test_missing_points_move_the_slope_by_their_sampling_only(scan) -> None:  # type: ignore[no-untyped-def]
    _, topography = scan
    heights = np.ma.filled(topography.heights(), np.nan)
    holes = np.random.default_rng(1).random(heights.shape) < 0.05
    sizes = tuple(float(size) for size in topography.pixel_size)
    whole = origins.spectral_moments(heights, sizes)
    holed = origins.spectral_moments(np.where(holes, np.nan, heights), sizes)
    assert holed.rms_slope == pytest.approx(whole.rms_slope, rel=0.03)
    assert holed.missing_fraction == holes.mean() and 0.7 < holed.used_fraction < 0.85


def test_thresholds_in_metres_under_each_model_and_law(scan) -> None:  # type: ignore[no-untyped-def]
    _, topography = scan
    spread = {}
    for model, law in (
        ("gw", "paper"),
        ("gw", "amontons"),
        ("gw", "strength"),
        ("persson", "paper"),
        ("persson", "amontons"),
    ):
        found = origins.from_topography(
            topography,
            model=model,
            law=law,
            material=STEEL,
            pressure=1e6,
            patch_area=1e-13 if model == "persson" else None,
        )
        i = found.interface
        assert i is not None and 1e-11 < found.mean() < 1e-6
        # newtons: the thresholds of all contacts together are mu times the load, or tau times the area
        together = 1e9 * i.area_fraction if law == "strength" else 0.5 * 1e6
        assert i.mean_force_threshold * i.contact_density == pytest.approx(together, rel=1e-9)
        # f_s is convex in x_s
        assert 0.3 < float(i.force_threshold(found.mean())) / i.mean_force_threshold < 1.0 + 1e-12
        assert i.mean_radius**2 <= i.mean_area / np.pi * (1 + 1e-12) and 0.0 < i.temperature(kelvin=300.0) < 1e-20
        # light load: 2/pi^(1/2) p/(E* h'_rms/2^(1/2)) by Persson, 1.2 to 1.8 times it by Greenwood and Williamson
        light = 2.0 / np.sqrt(np.pi) * 1e6 / (115e9 * i.moments.rms_slope / np.sqrt(2.0))
        assert 0.99 < i.area_fraction / light < 1.8
        spread[model, law] = found.std() / found.mean()
    # the onset goes from 0 to 3, and the spread falls with it: the law decides
    ordered = [("gw", "amontons"), ("gw", "paper"), ("persson", "amontons"), ("gw", "strength"), ("persson", "paper")]
    assert all(spread[a] > spread[b] for a, b in itertools.pairwise(ordered))


def test_plastic_and_mixed_on_a_scan(scan) -> None:  # type: ignore[no-untyped-def]
    """Steel this rough is mostly plastic: psi far above 1, real area nearly load over hardness."""
    _, topography = scan
    regimes = {
        (law, regime): origins.from_topography(
            topography, model="gw", law=law, material=STEEL, pressure=1e6, regime=regime
        )
        for law in ("paper", "amontons", "strength")
        for regime in ("elastic", "mixed", "plastic")
    }
    for law in ("paper", "amontons", "strength"):
        elastic, mixed, plastic = (regimes[law, r].interface for r in ("elastic", "mixed", "plastic"))
        assert elastic is not None and mixed is not None and plastic is not None
        assert plastic.area_fraction == pytest.approx(1e6 / 2e9, rel=1e-10)
        assert mixed.area_fraction >= max(elastic.area_fraction, plastic.area_fraction)
        assert mixed.plastic_fraction is not None and elastic.plastic_fraction is not None
        assert mixed.plastic_fraction > 0.5 and elastic.plasticity_index is not None and elastic.plasticity_index > 7.0
        assert any("plastic" in line for line in elastic.cautions) and mixed.cautions == plastic.cautions
        height = origins.separation_of_pressure(mixed.moments, 1e6, material=STEEL, regime="mixed")
        assert height == mixed.separation
    # plastic contacts break alike under all laws, but for the scale
    q = np.array([1e-6, 0.1, 0.9])
    paper, *others = (regimes[law, "plastic"] for law in ("paper", "amontons", "strength"))
    for other in others:
        assert other.isf(q) / other.mean() == pytest.approx(paper.isf(q) / paper.mean(), rel=1e-10)


def test_summits_depend_on_resolution(scan) -> None:  # type: ignore[no-untyped-def]
    _, topography = scan
    one, two = (
        t.interface.moments
        for t in origins.resolution_study(
            topography, factors=(1, 2), model="gw", law="amontons", material=STEEL, pressure=1e6
        )
        if t.interface is not None
    )
    assert 2.0 < one.m4 / two.m4 < 6.0 and 1.0 < one.m2 / two.m2 < 1.5


def test_a_channel_without_one_unit_is_refused_by_name() -> None:
    surface_topography = pytest.importorskip("SurfaceTopography")
    reader = surface_topography.open_topography(DATA / "afm-10um.di")
    phase = next(channel for channel in reader.channels if isinstance(channel.unit, tuple))
    with pytest.raises(origins.InputError, match=r"heights\.unit = .*unit = 'nm'"):
        origins.spectral_moments(reader.topography(channel_index=phase.index))
