"""Measured scans, where they are at hand: heights and slopes are SurfaceTopography's."""

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


def test_a_channel_without_one_unit_is_refused_by_name() -> None:
    surface_topography = pytest.importorskip("SurfaceTopography")
    reader = surface_topography.open_topography(DATA / "afm-10um.di")
    phase = next(channel for channel in reader.channels if isinstance(channel.unit, tuple))
    with pytest.raises(origins.InputError, match=r"heights\.unit = .*unit = 'nm'"):
        origins.spectral_moments(reader.topography(channel_index=phase.index))
