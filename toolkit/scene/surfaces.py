"""Rough surfaces in scenes: a scan, a generated surface, a spectrum or summits, and the thresholds they give."""

import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import origins
from origins.errors import InputError, positive, refuse, whole
from origins.roughness.self_affine import check_memory
from origins.roughness.topography import METRES, Topography, as_topography, detrended
from toolkit.running.ranks import on_root
from toolkit.scene import laws
from toolkit.scene.given_files import check_regular

if TYPE_CHECKING:
    from toolkit.scene.scene import Scene

SURFACES = {
    "scan": "toolkit.scene.surfaces:open_scan",
    "self-affine": "toolkit.scene.surfaces:generate",
    "spectrum": "origins:moments_of_spectrum",
    "summits": "origins:moments_of_summits",
}
HEIGHTS = ("scan", "self-affine")
_BYTES = 70  # on each point of a surface while its moments are taken: 66 measured
STIFFNESSES = {
    "sound": "origins:sound_stiffness",
    "mindlin": "origins:mindlin_stiffness",
    "column": "origins:column_stiffness",
    "power-law": "origins:PowerLaw",
}


def from_topography(
    folder: Path,
    surface: Mapping[str, Any],
    material: Mapping[str, Any],
    model: str,
    law: str,
    pressure: float,
    regime: str = "elastic",
    patch_area: float | None = None,
    height_law: str = "gaussian",
    detrend: str | None = None,
    step: int | None = None,
    comm: Any = None,
) -> origins.Thresholds:
    """Thresholds in metres of the surface that the tables describe; see origins.from_topography.

    `surface` has a kind of SURFACES; `material` has the fields of origins.Material, its contact_stiffness a kind of
    STIFFNESSES. `detrend` is "curvature" for a scan and "centre" for a generated surface, which is periodic; what is
    not heights has neither `detrend` nor `step`. Raises InputError.
    """
    constants = dict(laws.as_table("material", material))
    if "contact_stiffness" in constants:
        where = "material.contact_stiffness"
        stiffness = laws.as_table(where, constants["contact_stiffness"])
        constants["contact_stiffness"] = laws.build(STIFFNESSES, stiffness, where, folder)
    kind = laws.as_table("surface", surface).get("kind")
    built = laws.build(SURFACES, surface, "surface", folder, comm)
    options: dict[str, Any] = {
        "model": model,
        "law": law,
        "material": laws.call(origins.Material, constants, "material"),
        "pressure": pressure,
        "regime": regime,
        "patch_area": patch_area,
        "height_law": height_law,
    }
    if kind not in HEIGHTS:
        for name, value in (("detrend", detrend), ("step", step)):
            if value is not None:
                refuse(
                    name,
                    value,
                    f'belongs to heights; a surface of kind = "{kind}" has none, so leave it out',
                )
        return origins.from_moments(built, **options)
    periodic = kind == "self-affine"
    return origins.from_topography(
        *built,
        detrend=detrend if detrend is not None else "centre" if periodic else "curvature",
        periodic=periodic,
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
) -> tuple[Topography]:
    """A scan in any format that SurfaceTopography reads; `file` is relative to the scene's folder.

    Rank 0 of `comm` reads it for all. `physical_sizes`, `unit` and `height_scale_factor` are for files that hold none.
    Raises InputError where the file is missing, is no scan, or contradicts them.
    """
    if not isinstance(file, str):
        refuse("file", file, 'must be a file name, such as "scan.di"')
    channel = whole("channel", channel, least=0)
    given = {
        "physical_sizes": None
        if physical_sizes is None
        else _pair("physical_sizes", physical_sizes),
        "unit": unit,
        "height_scale_factor": None
        if height_scale_factor is None
        else positive("height_scale_factor", height_scale_factor),
    }
    return (on_root(comm, lambda: _read_scan(folder, file, channel, given)),)


def _read_scan(folder: Path, file: str, channel: int, given: Mapping[str, Any]) -> Topography:
    """The heights of one channel, in metres; `given` are what the scene says of the file, None where nothing."""
    check_regular("file", folder / file, file, "scan")
    try:
        from SurfaceTopography import open_topography
        from SurfaceTopography.Exceptions import CannotDetectFileFormat, MetadataAlreadyFixedByFile
    except ImportError as error:
        raise InputError(
            f"file = {file!r}: needs SurfaceTopography; install mesofriction[topography]"
        ) from error
    try:
        with open_topography(str(folder / file)) as reader:
            if not reader.channels:
                refuse(
                    "file",
                    file,
                    "cannot be read as a scan: it holds no heights; it may be cut short",
                )
            if channel >= len(reader.channels):
                refuse(
                    "channel",
                    channel,
                    f"the file has {len(reader.channels)} channels, counted from 0",
                )
            known = {key: value for key, value in given.items() if value is not None}
            scan = reader.topography(channel_index=channel, **known)
        if getattr(scan, "unit", None) not in METRES:
            rule = 'lengths need one unit, and the file holds none; write one, such as unit = "nm"'
            refuse("unit", given["unit"], rule)
        return as_topography(scan)
    except InputError:
        raise
    except CannotDetectFileFormat as error:
        # its message holds the complaints of all readers, one after the other
        why = "it is in no format that SurfaceTopography knows, or cut short"
        raise InputError(f"file = {file!r}: cannot be read as a scan: {why}") from error
    except MetadataAlreadyFixedByFile as error:
        for name, value in given.items():
            if value is not None and f"'{name}'" in str(error):
                refuse(name, value, "the file holds its own; leave it out")
        raise
    except Exception as error:
        # readers raise whatever their parsing does
        if given["physical_sizes"] is None and "physical_sizes" in str(error):
            rule = "the file holds no sizes; write those of the whole scan, such as physical_sizes = [1e-5, 1e-5]"
            refuse("physical_sizes", None, rule)
        why = " ".join(str(error).split()) or type(error).__name__
        raise InputError(f"file = {file!r}: cannot be read as a scan: {why}") from error


def _pair(name: str, value: object) -> tuple[float, float]:
    if not isinstance(value, list) or len(value) != 2:
        refuse(name, value, "must be a pair of lengths, such as [1.0, 1.0]")
    return positive(f"{name}[0]", value[0]), positive(f"{name}[1]", value[1])


def generate(
    shape: Any,
    pixel_size: Any,
    hurst: float,
    rms_slope: float,
    seed: int,
    long_cutoff: float | None = None,
    short_cutoff: float | None = None,
) -> tuple[np.ndarray, Any]:
    """A periodic self-affine surface, lengths in metres; see origins.self_affine_surface. Raises InputError."""
    if (
        isinstance(shape, list)
        and len(shape) == 2
        and all(isinstance(n, int) and n > 0 for n in shape)
    ):
        check_memory((shape[0], shape[1]), _BYTES)
    heights = origins.self_affine_surface(
        shape,
        pixel_size,
        hurst=hurst,
        rms_slope=rms_slope,
        seed=seed,
        long_cutoff=long_cutoff,
        short_cutoff=short_cutoff,
    )
    return heights, pixel_size


def shared_surface(scenes: "Sequence[Scene]") -> tuple[Any, tuple[float, float]] | None:
    """Heights and sizes, in m, of the surface that all `scenes` take thresholds from; None where there is none."""
    tables = [tomllib.loads(scene.text)["contacts"]["thresholds"] for scene in scenes]
    if any(table["kind"] != "from-topography" for table in tables):
        return None
    first = tables[0]["surface"], scenes[0].folder
    if any(
        (table["surface"], scene.folder) != first
        for table, scene in zip(tables, scenes, strict=True)
    ):
        return None
    if first[0]["kind"] not in HEIGHTS:
        return None
    scan = as_topography(*laws.build(SURFACES, first[0], "surface", first[1]))
    if (
        tables[0].get("detrend", "centre" if first[0]["kind"] == "self-affine" else "curvature")
        == "curvature"
    ):
        scan = detrended(scan, "curvature")
    (nx, ny), (dx, dy) = scan.heights.shape, scan.pixel_size
    return scan.heights, (nx * dx, ny * dy)
