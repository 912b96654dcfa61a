"""Rough surfaces in scenes: a scan, a generated surface, a spectrum or summits, and the thresholds they give."""

from pathlib import Path
from typing import Any, NamedTuple

import origins
from origins.errors import InputError, positive, refuse, whole
from origins.roughness.topography import METRES, Topography, as_topography
from toolkit.scene.measured import read_file

_TOLD = 200  # letters of what a reader says


class Heights(NamedTuple):
    """A surface of which the heights are known, and whether it goes on periodically."""

    topography: Topography
    periodic: bool


def from_topography(
    surface: Heights | origins.SpectralMoments,
    material: origins.Material,
    model: str,
    law: str,
    pressure: float,
    regime: str = "elastic",
    patch_area: float | None = None,
    height_law: str = "gaussian",
    detrend: str | None = None,
    step: int | None = None,
) -> origins.Thresholds:
    """Thresholds in metres of a surface; see origins.from_topography.

    `detrend` is "curvature" for a scan and "centre" for a generated surface, which is periodic; what is not heights has
    neither `detrend` nor `step`. Raises InputError.
    """
    options: dict[str, Any] = dict(locals())
    del options["surface"], options["detrend"], options["step"]
    if isinstance(surface, origins.SpectralMoments):
        for name, value in (("detrend", detrend), ("step", step)):
            if value is not None:
                refuse(name, value, "belongs to heights, which this surface has not; leave it out")
        return origins.from_moments(surface, **options)
    return origins.from_topography(
        surface.topography,
        detrend=detrend if detrend is not None else "centre" if surface.periodic else "curvature",
        periodic=surface.periodic,
        step=1 if step is None else step,
        **options,
    )


def open_scan(
    folder: Path,
    file: str,
    channel: int = 0,
    physical_sizes: object = None,
    unit: str | None = None,
    height_scale_factor: float | None = None,
    comm: Any = None,
) -> Heights:
    """A scan in any format that SurfaceTopography reads; `file` is relative to the scene's folder.

    Rank 0 of `comm` reads it for all. `physical_sizes`, `unit` and `height_scale_factor` are for files that hold none.
    Raises InputError where the file is missing, is no scan, or contradicts them.
    """
    given: dict[str, Any] = {} if unit is None else {"unit": unit}
    if physical_sizes is not None:
        if not isinstance(physical_sizes, list) or len(physical_sizes) != 2:
            rule = "must be a pair of lengths, such as [1.0, 1.0]"
            refuse("physical_sizes", physical_sizes, rule)
        sizes = enumerate(physical_sizes)
        given["physical_sizes"] = tuple(positive(f"physical_sizes[{k}]", one) for k, one in sizes)
    if height_scale_factor is not None:
        given["height_scale_factor"] = positive("height_scale_factor", height_scale_factor)
    channel = whole("channel", channel, least=0)

    def read(path: Path) -> Topography:
        try:
            from SurfaceTopography import open_topography
        except ImportError as error:
            rule = "needs SurfaceTopography; install mesofriction[topography]"
            raise InputError(f"file = {file!r}: {rule}") from error
        try:
            with open_topography(str(path)) as reader:
                if channel >= len(reader.channels):
                    rule = f"the file has {len(reader.channels)} channels, counted from 0"
                    refuse("channel", channel, rule)
                scan = reader.topography(channel_index=channel, **given)
            if getattr(scan, "unit", None) not in METRES:
                rule = (
                    'lengths need one unit, and the file holds none; write one, such as unit = "nm"'
                )
                refuse("unit", given.get("unit"), rule)
            return as_topography(scan)
        except InputError:
            raise
        except Exception as error:  # readers raise whatever their parsing does
            why = " ".join(str(error).split())[:_TOLD] or type(error).__name__
            if (
                type(error).__name__ == "CannotDetectFileFormat"
            ):  # which repeats what all readers say
                why = "it is in no format that SurfaceTopography knows, or cut short"
            raise InputError(f"file = {file!r}: cannot be read as a scan: {why}") from error

    return Heights(read_file("file", file, folder, comm, read, "scan"), periodic=False)


def generate(
    shape: Any,
    pixel_size: Any,
    hurst: float,
    rms_slope: float,
    seed: int,
    long_cutoff: float | None = None,
    short_cutoff: float | None = None,
) -> Heights:
    """A periodic self-affine surface, lengths in metres; see origins.self_affine_surface. Raises InputError."""
    law = dict(locals())
    return Heights(as_topography(origins.self_affine_surface(**law), pixel_size), periodic=True)
