"""Kinds of thresholds whose keys differ from the parameters in origins: samples, islands, surfaces."""

import re
from collections.abc import Sequence
from pathlib import Path
from textwrap import shorten
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

import origins
from origins.errors import InputError, finite, finite_array, one_of, pair, positive, refuse, whole
from origins.roughness.surface import METRES, Topography, as_topography
from toolkit.scene.laws import read_file, read_text
from toolkit.scene.tables import did_you_mean


def from_samples(
    folder: Path,
    x_s: Sequence[float] | None = None,
    f_s: Sequence[float] | None = None,
    file: str | None = None,
    quantity: str = "x_s",
    column: int | str | None = None,
    weight_column: int | str | None = None,
    decimal: str = ".",
    coefficient: float | None = None,
    stiffness: float | None = None,
    weights: Sequence[float] | None = None,
    comm: Any = None,
) -> origins.Thresholds:
    """Thresholds through samples; see origins.from_samples.

    `file` is relative to the scene's folder; its columns, separated by semicolons, or by blanks or commas, count from
    1: `column` has the values, x_s or f_s by `quantity`, and may be left out if it is the only one; `weight_column` has
    the weights. With semicolons or blanks as separators "1,5" is 1.5, a decimal comma. # begins a comment, and the
    first line may be a header of text, whose words name columns, too. `decimal = ","`: every comma is a decimal one.
    Raises InputError.
    """
    given: dict[str, Any] = {"x_s": x_s, "f_s": f_s, "weights": weights}
    if file is None:
        if (column, weight_column, quantity, decimal) != (None, None, "x_s", "."):
            hint = "quantity, column, weight_column and decimal say what a file holds; leave them out without one"
            raise InputError(f"from_samples: {hint}")
    else:
        if any(values is not None for values in given.values()):
            refuse("file", file, "holds the samples; leave x_s, f_s and weights out")
        one_of("quantity", quantity, ("x_s", "f_s"))
        one_of("decimal", decimal, (".", ","))
        lines = read_file("file", file, folder, comm, read_text).splitlines()
        place = _place("column", column, lines)
        given[quantity] = _column(file, lines, quantity, place, decimal)
        if weight_column is not None:
            other = _place("weight_column", weight_column, lines)
            if other == (place or 1):
                refuse("weight_column", weight_column, "is that of the samples; name another")
            given["weights"] = _column(file, lines, "weights", other, decimal)
    return origins.from_samples(**given, coefficient=coefficient, stiffness=stiffness)


def _place(key: str, column: int | str | None, lines: list[str]) -> int | None:
    """The number of a column that is named by the header, the first line with text, which may begin with #; InputError
    where it names no such column."""
    if not isinstance(column, str):
        return column
    header = next((line for line in lines if line.strip()), "").strip().lstrip("#").strip()
    names = [word.strip().strip("\"'") for word in re.split(r"[;,\t]", header)]
    names = names if len(names) > 1 else header.split()
    if column not in names:
        hint = f"is no column of the header; {did_you_mean(column, names)}it names"
        refuse(key, column, f"{hint} {shorten(', '.join(names), 100, placeholder=' ...')}")
    return names.index(column) + 1


def _column(file: str, lines: list[str], name: str, place: int | None, decimal: str) -> list[float]:
    """The values of this column, counted from 1 (None: of the only one)."""
    if decimal == ",":
        lines = [line.replace(",", ".") for line in lines]
    numbered = enumerate((_words(line.partition("#")[0]) for line in lines), start=1)
    rows = [(number, row) for number, row in numbered if row]
    if rows and np.isnan(rows[0][1]).all() and not re.match(r"\W*\d", lines[rows[0][0] - 1]):
        del rows[0]  # a header, and no mistyped number
    if not rows:
        refuse("file", file, "holds no numbers; write one value a line")
    width = len(rows[0][1])
    if place is None and all(re.fullmatch(r"\s*\d+,\d+\s*", lines[n - 1]) for n, _ in rows):
        hint = """a decimal comma? write decimal = ","; two columns? say which, as column = 2"""
        refuse("file", file, f"holds two whole numbers a line, parted by a comma: {hint}")
    if place is None and width > 1:
        refuse("file", file, f"holds {width} columns; say which has {name}, as column = {width}")
    if (column := whole("column", 1 if place is None else place, 1)) > width:
        refuse("file", file, f"there is no column {place} of {width}")
    for number, row in rows:
        # do not show the line itself: the file may be private
        if len(row) != width:
            refuse("file", file, f"line {number} has {len(row)} columns, the first has {width}")
        if not 0.0 < row[column - 1] < np.inf:
            refuse("file", file, f"line {number}: {name} must be a number > 0; else leave it out")
    return [row[column - 1] for _, row in rows]


def _words(line: str) -> list[float]:
    """The columns of a line, separated by semicolons, or by blanks or commas; nan for words that are not numbers.

    A comma between two digits is a decimal comma where something else separates the columns.
    """
    if re.search(r"\d,\d", line) and (";" in line or (len(line.split()) > 1 and ", " not in line)):
        line = line.replace(",", ".")
    found = []
    for word in re.split(r"[;,\s]+", line.strip()):
        try:
            found.append(float(word))
        except ValueError:
            found += [np.nan] if word else []
    return found


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
    options = dict(locals())
    del options["island"]
    if sum(given is not None for given in (sizes, mean_atoms, island)) != 1:
        hint = "such as [[10, 9]], mean_atoms, such as 100, and the table island"
        raise InputError(f"domains: give exactly one of sizes, {hint}")
    if island is not None and lattice_constant is not None:
        refuse("lattice_constant", lattice_constant, "the table island has its own; leave it out")
    return origins.domains(**options, islands=None if island is None else [island])


def island_of_file(folder: Path, file: str, comm: Any = None) -> Any:
    """The atoms of a structure file, of any format that ASE reads; InputError where it reads none."""

    def read(path: Path) -> Any:
        from ase.io import read as read_atoms

        try:
            return read_atoms(path)  # the last of several
        except Exception as error:  # each format has errors of its own
            refuse("file", file, f"is no structure that ASE reads: {type(error).__name__}")

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
    options: dict[str, Any] = dict(locals())
    del options["surface"], options["detrend"], options["step"]
    if isinstance(surface, origins.SpectralMoments):
        if detrend is not None or step is not None:
            name, value = ("step", step) if detrend is None else ("detrend", detrend)
            refuse(name, value, "belongs to heights, which this surface has not; leave it out")
        return origins.from_moments(surface, **options)
    own = "centre" if surface.periodic else "curvature"
    options |= {"detrend": detrend or own, "step": 1 if step is None else step}
    return origins.from_topography(surface.topography, periodic=surface.periodic, **options)


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

            with open_topography(str(path)) as reader:
                if channel >= len(reader.channels):
                    refuse("channel", channel, f"must be 0 to {len(reader.channels) - 1}")
                scan = reader.topography(channel_index=channel, **said)
            if getattr(scan, "unit", None) not in METRES:
                refuse(
                    "unit", unit, 'is no unit of length; write "nm", or take a channel of heights'
                )
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


def _why(error: Exception) -> str:
    """What a reader says of a file in a few plain words, without the bytes that it could not read."""
    said = str(error)
    if (tried := re.findall(r"tried (\w+):", said)) and "physical_sizes" not in said:
        return f"none of the {len(set(tried))} readers of SurfaceTopography takes it; is it whole, and a scan?"
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
    made = origins.self_affine_surface(**locals())
    return Heights(as_topography(made, pixel_size), periodic=True)
