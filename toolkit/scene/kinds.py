"""Kinds of thresholds whose keys differ from the parameters in origins: islands, surfaces."""

import io
import re
from collections.abc import Sequence
from pathlib import Path
from textwrap import shorten
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

import origins
from origins.errors import InputError, finite, finite_array, pair, positive, refuse, whole
from origins.roughness.surface import METRES, Topography, as_topography
from toolkit.scene.files import read_file, read_text
from toolkit.scene.samples import in_si

# an island's atoms are about as far apart as a substrate's period: a factor beyond which one is in another unit
OTHER_UNIT = 100.0


def identical_start(value: float) -> float:
    """All contacts start at one stretch (a length)."""
    return finite("value", value)


def domains(
    lattice_constant: float | None = None,
    sizes: Sequence[Sequence[int]] | None = None,
    mean_atoms: float | None = None,
    island: Any = None,
    weights: Sequence[float] | None = None,
    bonds: float | None = None,
    angles: Sequence[float] | None = None,
    temperature: float | None = None,
    substrate: origins.Substrate | None = None,
    law: str = "area",
    stiffness: float | None = None,
    coefficient: float | None = None,
    samples: int = 20_000,
    seed: int = 0,
    comm: Any = None,
) -> origins.Thresholds:
    """Thresholds of rotated domains, drawn by all ranks of `comm`; see origins.domains, which has the same keywords,
    with a list `islands` in place of `island`. Raises InputError."""
    if sum(given is not None for given in (sizes, mean_atoms, island)) != 1:
        hint = "such as [[10, 9]], mean_atoms, such as 100, and the table island"
        raise InputError(f"domains: give exactly one of sizes, {hint}")
    if island is not None and lattice_constant is not None:
        refuse("lattice_constant", lattice_constant, "the table island has its own; leave it out")
    if island is not None and substrate is not None:
        _check_lengths(island, substrate)
    return origins.domains(
        lattice_constant=lattice_constant,
        sizes=sizes,
        mean_atoms=mean_atoms,
        islands=None if island is None else [island],
        weights=weights,
        bonds=bonds,
        angles=angles,
        temperature=temperature,
        substrate=substrate,
        law=law,
        stiffness=stiffness,
        coefficient=coefficient,
        samples=samples,
        seed=seed,
        comm=comm,
    )


def _check_lengths(island: Any, substrate: origins.Substrate) -> None:
    """Refuse an island whose atoms are OTHER_UNIT times as far apart as the substrate's longest period, or as much
    nearer than its shortest: it is in another unit, as that of a file in Å beside a substrate in metres."""
    points = island.get_positions()
    if len(points) < 2:
        return
    periods = 2.0 * np.pi / np.linalg.norm(substrate.wavevectors, axis=1)
    apart = float(np.linalg.norm(points[1:] - points[0], axis=1).min())
    if not periods.min() / OTHER_UNIT <= apart <= OTHER_UNIT * periods.max():
        raise InputError(
            f"domains: the island's first atom is {apart:.3g} from the next, on a substrate whose rows are "
            f"{periods.max():.3g} apart: "
            'one is in another unit; give island the unit of its file, such as unit = "Å"'
        )


def island_of_file(folder: Path, file: str, unit: str | None = None, comm: Any = None) -> Any:
    """The atoms of a structure file, of any format that ASE reads, where they are, or, with the file's unit of length,
    in metres; InputError where it reads none."""

    def read(path: Path) -> Any:
        from ase.io import read as read_atoms

        try:
            atoms: Any = read_atoms(path)  # the last of several
        except Exception as error:  # each format has errors of its own
            refuse("file", file, f"is no structure that ASE reads: {type(error).__name__}")
        if unit is not None:
            atoms.positions *= in_si(unit, METRES)
        return atoms

    return read_file("file", file, folder, comm, read)


def fourier_substrate(
    wavevectors: npt.ArrayLike,
    cosines: npt.ArrayLike | None = None,
    sines: npt.ArrayLike | None = None,
) -> origins.Substrate:
    """sum of cosines cos(G·r) + sines sin(G·r), one of each for every wavevector, zero when left out."""
    count = len(wavevectors) if isinstance(wavevectors, list) else 0
    parts = []
    for name, value in (("cosines", cosines), ("sines", sines)):
        parts.append(np.zeros(count) if value is None else finite_array(name, value))
        if parts[-1].size != count:
            refuse(name, value, f"must be {count} numbers, one for each wavevector")
    return origins.fourier_substrate(wavevectors, parts[0] - 1j * parts[1])


class Heights(NamedTuple):
    """A surface with known heights, and whether it is periodic."""

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

    `detrend` is "curvature" for a scan and "centre" for a generated surface, which is periodic; a surface without
    heights takes neither `detrend` nor `step`. Raises InputError.
    """
    given: dict[str, Any] = {"material": material, "model": model, "law": law, "pressure": pressure}
    given |= {"regime": regime, "patch_area": patch_area, "height_law": height_law}
    if isinstance(surface, origins.SpectralMoments):
        if detrend is not None or step is not None:
            name, value = ("step", step) if detrend is None else ("detrend", detrend)
            refuse(name, value, "belongs to heights, which this surface has not; leave it out")
        return origins.from_moments(surface, **given)
    given["detrend"] = detrend or ("centre" if surface.periodic else "curvature")
    given["step"] = 1 if step is None else step
    return origins.from_topography(surface.topography, periodic=surface.periodic, **given)


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

    Rank 0 of `comm` reads it for all. `physical_sizes`, `unit` and `height_scale_factor` are for files without them.
    Raises InputError where the file is missing, is no scan, or contradicts them.
    """
    given: dict[str, Any] = {"unit": unit, "height_scale_factor": height_scale_factor}
    if physical_sizes is not None:
        sizes = pair("physical_sizes", physical_sizes)
        given["physical_sizes"] = tuple(positive("physical_sizes", size) for size in sizes)
    said = {name: value for name, value in given.items() if value is not None}
    channel = whole("channel", channel, least=0)
    if height_scale_factor is not None:
        positive("height_scale_factor", height_scale_factor, "such as 1e-9")

    def read(path: Path) -> Topography:
        """The scan in a file, by its channel; InputError for what the reader refuses."""
        if not path.stat().st_size:
            refuse("file", file, "is empty")
        try:
            from SurfaceTopography import open_topography
            from SurfaceTopography.Exceptions import CannotDetectFileFormat

            try:
                opened = open_topography(str(path))
            except CannotDetectFileFormat:
                opened = open_topography(io.StringIO(_parted_by_blanks(path)))
            with opened as reader:
                if channel >= len(reader.channels):
                    refuse("channel", channel, f"must be 0 to {len(reader.channels) - 1}")
                scan = reader.topography(channel_index=channel, **said)
            if (its := getattr(scan, "unit", None)) not in METRES:
                hint = 'write such as unit = "nm", or take a channel of heights'
                why = "is no unit of length" if unit else f"the file has {its or 'none'}"
                refuse("unit", unit, f"{why}; {hint}")
            return as_topography(scan)
        except ImportError:
            refuse("file", file, "needs SurfaceTopography; install mesofriction[topography]")
        except InputError:
            raise
        except Exception as error:  # readers raise whatever their parsing does
            why = _why(error)
            if key := next((name for name in said if f"'{name}'" in why), ""):
                refuse(key, said[key], "the file has its own; leave it out")
            if "physical_sizes" in why:
                refuse("file", file, 'no lengths; add physical_sizes = [1e-5, 1e-5], unit = "m"')
            refuse("file", file, f"cannot be read as a scan: {why}")

    return Heights(read_file("file", file, folder, comm, read, "scan"), periodic=False)


def _parted_by_blanks(path: Path) -> str:
    """A text with a matrix of heights parted by commas, or by semicolons beside which a comma is a decimal one, as
    SurfaceTopography reads it: parted by blanks, nan where a cell is empty. Another text as it is, "" for none."""
    try:
        text = read_text(path)
    except UnicodeDecodeError:
        return ""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    mark = ";" if ";" in text else ","
    rows = [line.split(mark) for line in lines if not line.startswith("#")]
    if not any(row[-1] for row in rows):  # each row ends with a mark
        rows = [row[:-1] for row in rows]
    cells = [[cell.strip().replace(",", ".") or "nan" for cell in row] for row in rows]
    try:
        # two columns may be one of decimal commas
        if np.array(cells, dtype=float).shape[1] < 3:
            return text
    except (ValueError, IndexError):  # no numbers, or rows of several lengths; nothing at all
        return text
    comments = [line for line in lines if line.startswith("#")]
    return "\n".join([*comments, *map(" ".join, cells), ""])


def _why(error: Exception) -> str:
    """What a reader says of a file in a few plain words, without the bytes that it could not read."""
    said = str(error)
    if (tried := re.findall(r"tried (\w+):", said)) and "physical_sizes" not in said:
        return (
            f"none of the {len(set(tried))} readers of SurfaceTopography takes it; is it whole, and a scan? "
            "A text with a matrix of heights has blanks, commas or semicolons between them and nan or nothing for gaps"
        )
    said = re.sub(r"""b(['"])(?:\\.|(?!\1).)*\1""", "some bytes", said, flags=re.DOTALL)
    said = "".join(letter if letter.isprintable() else " " for letter in said)
    return shorten(said, 160, placeholder=" ...") or type(error).__name__


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
    made = origins.self_affine_surface(
        shape,
        pixel_size,
        hurst=hurst,
        rms_slope=rms_slope,
        seed=seed,
        long_cutoff=long_cutoff,
        short_cutoff=short_cutoff,
    )
    return Heights(as_topography(made, pixel_size), periodic=True)
