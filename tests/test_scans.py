"""Measured scans, where they are at hand: the slopes are SurfaceTopography's, thresholds come out in metres."""

import itertools
from pathlib import Path

import numpy as np
import pytest

import origins

DATA = Path(__file__).resolve().parents[2] / "shared" / "data"
pytestmark = pytest.mark.skipif(not DATA.is_dir(), reason="no measured scans beside the project")

SCANS = {
    "afm-10um.di": (34.4e-9, 0.192),
    "confocal-88um.al3d": (259e-9, 0.0896),
    "matrix-28um.txt": (70.9e-9, 0.0675),
}
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
    assert (
        float(f"{moments.rms_height:.3g}") == height and float(f"{moments.rms_slope:.3g}") == slope
    )
    assert moments.rms_slope == pytest.approx(
        float(topography.detrend("curvature").rms_gradient()), rel=1e-8
    )
    assert moments.used_fraction == 1.0


def test_array_and_object_agree(scan) -> None:  # type: ignore[no-untyped-def]
    _, topography = scan
    metres = {"nm": 1e-9, "m": 1.0}[topography.unit]
    heights = np.ma.filled(topography.heights(), np.nan) * metres
    sizes = tuple(float(size) * metres for size in topography.pixel_size)
    assert origins.spectral_moments(heights, sizes) == origins.spectral_moments(topography)


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
        assert (
            i.mean_radius**2 <= i.mean_area / np.pi * (1 + 1e-12)
            and 0.0 < i.temperature(kelvin=300.0) < 1e-20
        )
        # light load: 2/pi^(1/2) p/(E* h'_rms/2^(1/2)) by Persson, 1.2 to 1.8 times it by Greenwood and Williamson
        light = 2.0 / np.sqrt(np.pi) * 1e6 / (115e9 * i.moments.rms_slope / np.sqrt(2.0))
        assert 0.99 < i.area_fraction / light < 1.8
        spread[model, law] = found.std() / found.mean()
    # the onset goes from 0 to 3, and the spread falls with it: the law decides
    ordered = [
        ("gw", "amontons"),
        ("gw", "paper"),
        ("persson", "amontons"),
        ("gw", "strength"),
        ("persson", "paper"),
    ]
    assert all(spread[a] > spread[b] for a, b in itertools.pairwise(ordered))


def test_a_channel_without_one_unit_is_refused_by_name() -> None:
    surface_topography = pytest.importorskip("SurfaceTopography")
    reader = surface_topography.open_topography(DATA / "afm-10um.di")
    phase = next(channel for channel in reader.channels if isinstance(channel.unit, tuple))
    with pytest.raises(origins.InputError, match=r"heights\.unit = .*unit = 'nm'"):
        origins.spectral_moments(reader.topography(channel_index=phase.index))
