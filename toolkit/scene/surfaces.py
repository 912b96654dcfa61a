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
_TOLD = 200  # letters of what a reader says
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
        rule = f'belongs to heights; a surface of kind = "{kind}" has none, so leave it out'
        for name, value in (("detrend", detrend), ("step", step)):
            if value is not None:
                refuse(name, value, rule)
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
    given: dict[str, Any] = {"unit": unit}
    if physical_sizes is not None:
        given["physical_sizes"] = _pair("physical_sizes", physical_sizes)
    if height_scale_factor is not None:
        given["height_scale_factor"] = positive("height_scale_factor", height_scale_factor)
    given = {name: value for name, value in given.items() if value is not None}
    return (on_root(comm, lambda: _read_scan(folder, file, channel, given)),)


def _read_scan(folder: Path, file: str, channel: int, given: dict[str, Any]) -> Topography:
    """The heights of one channel, in metres; `given` is what the scene says of the file."""
    check_regular("file", folder / file, file, "scan")
    try:
        from SurfaceTopography import open_topography
    except ImportError as error:
        rule = "needs SurfaceTopography; install mesofriction[topography]"
        raise InputError(f"file = {file!r}: {rule}") from error
    try:
        with open_topography(str(folder / file)) as reader:
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
    if isinstance(shape, list) and [type(n) for n in shape] == [int, int] and min(shape) > 0:
        check_memory((shape[0], shape[1]), _BYTES)
    cutoffs = {"long_cutoff": long_cutoff, "short_cutoff": short_cutoff}
    law: dict[str, Any] = {"hurst": hurst, "rms_slope": rms_slope, "seed": seed, **cutoffs}
    return origins.self_affine_surface(shape, pixel_size, **law), pixel_size


def shared_surface(scenes: "Sequence[Scene]") -> tuple[Any, tuple[float, float]] | None:
    """Heights and sizes, in m, of the surface that all `scenes` take thresholds from; None where there is none."""
    tables = [tomllib.loads(scene.text)["contacts"]["thresholds"] for scene in scenes]
    if any(table["kind"] != "from-topography" for table in tables):
        return None
    surface, folder, detrend = tables[0]["surface"], scenes[0].folder, tables[0].get("detrend")
    others = [(table["surface"], scene.folder) for table, scene in zip(tables, scenes, strict=True)]
    if surface["kind"] not in HEIGHTS or any(other != (surface, folder) for other in others):
        return None
    scan = as_topography(*laws.build(SURFACES, surface, "surface", folder))
    if detrend == "curvature" or (detrend is None and surface["kind"] == "scan"):
        scan = detrended(scan, "curvature")
    (nx, ny), (dx, dy) = scan.heights.shape, scan.pixel_size
    return scan.heights, (nx * dx, ny * dy)
