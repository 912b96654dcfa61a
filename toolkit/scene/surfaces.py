"""Rough surfaces in scenes: a scan, a generated surface, a spectrum or summits, and the thresholds they give."""

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import origins
from origins.errors import InputError, positive, refuse, whole
from origins.roughness.self_affine import check_memory
from origins.roughness.topography import METRES, Topography, as_topography, detrended
from toolkit.scene import laws
from toolkit.scene.given_files import read_file

if TYPE_CHECKING:
    from toolkit.scene.scene import Scene

_TOLD = 200  # letters of what a reader says
_BYTES = 70  # on each point of a surface while its moments are taken: 66 measured


@dataclass(frozen=True)
class Heights:
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
    options: dict[str, Any] = {
        "material": material,
        "model": model,
        "law": law,
        "pressure": pressure,
    }
    options |= {"regime": regime, "patch_area": patch_area, "height_law": height_law}
    if isinstance(surface, origins.SpectralMoments):
        for name, value in (("detrend", detrend), ("step", step)):
            if value is not None:
                refuse(
                    name,
                    value,
                    "belongs to heights, which this kind of surface has not; leave it out",
                )
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
    channel = whole("channel", channel, least=0)
    given: dict[str, Any] = {"unit": unit}
    if physical_sizes is not None:
        if not isinstance(physical_sizes, list) or len(physical_sizes) != 2:
            refuse(
                "physical_sizes", physical_sizes, "must be a pair of lengths, such as [1.0, 1.0]"
            )
        given["physical_sizes"] = tuple(
            positive(f"physical_sizes[{k}]", size) for k, size in enumerate(physical_sizes)
        )
    if height_scale_factor is not None:
        given["height_scale_factor"] = positive("height_scale_factor", height_scale_factor)
    given = {name: value for name, value in given.items() if value is not None}
    return Heights(
        read_file(
            "file", file, folder, comm, lambda path: _read_scan(path, file, channel, given), "scan"
        ),
        periodic=False,
    )


def _read_scan(path: Path, file: str, channel: int, given: dict[str, Any]) -> Topography:
    """The heights of one channel, in metres; `given` is what the scene says of the file."""
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
            rule = 'lengths need one unit, and the file holds none; write one, such as unit = "nm"'
            refuse("unit", given.get("unit"), rule)
        return as_topography(scan)
    except InputError:
        raise
    except Exception as error:  # readers raise whatever their parsing does
        if "physical_sizes" not in given and "physical_sizes" in str(error):
            rule = "the file holds no sizes; write those of the whole scan, such as physical_sizes = [1e-5, 1e-5]"
            refuse("physical_sizes", None, rule)
        for name, value in given.items():
            if f"'{name}'" in str(error):
                refuse(name, value, "the file holds its own; leave it out")
        why = " ".join(str(error).split())[:_TOLD] or type(error).__name__
        if type(error).__name__ == "CannotDetectFileFormat":  # which repeats what all readers say
            why = "it is in no format that SurfaceTopography knows, or cut short"
        raise InputError(f"file = {file!r}: cannot be read as a scan: {why}") from error


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
    if isinstance(shape, list) and [type(n) for n in shape] == [int, int] and min(shape) > 0:
        check_memory((shape[0], shape[1]), _BYTES)
    return Heights(as_topography(origins.self_affine_surface(**law), pixel_size), periodic=True)


def shared_surface(scenes: "Sequence[Scene]") -> tuple[Any, tuple[float, float]] | None:
    """Heights and sizes, in m, of the surface that all `scenes` take thresholds from; None where there is none."""
    tables = [tomllib.loads(scene.text)["contacts"]["thresholds"] for scene in scenes]
    asked = [
        (table.get("surface"), scene.folder) for table, scene in zip(tables, scenes, strict=True)
    ]
    kind = (asked[0][0] or {}).get("kind")
    if kind not in ("scan", "self-affine") or any(other != asked[0] for other in asked):
        return None
    scan = laws.build(laws.SURFACES, asked[0][0], "surface", asked[0][1]).topography
    if tables[0].get("detrend", "curvature" if kind == "scan" else "") == "curvature":
        scan = detrended(scan, "curvature")
    (nx, ny), (dx, dy) = scan.heights.shape, scan.pixel_size
    return scan.heights, (nx * dx, ny * dy)
