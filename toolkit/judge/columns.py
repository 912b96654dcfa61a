"""The tables of `precision` and `compare` as columns of a CSV file."""

from collections.abc import Mapping, Sequence
from typing import Any


def precision_rows(found: Mapping[str, Any]) -> dict[str, list[Any]]:
    """The columns of precision.csv: the points of `precision`, with units."""
    units = dict.fromkeys(("error", "claimed_error"), found["error_unit"]) | {"run_time": "s"}
    return _columns(found["points"], units)


def comparison_rows(scenes: Sequence[Mapping[str, Any]]) -> dict[str, list[Any]]:
    """The columns of compare.csv: a line for each reading of each scene, the scene's own first, with the numbers that
    compare.json has; what is the same for all readings stands in the first line of a scene. Each scene's unit of length
    stands in the column "unit", and in the head where all scenes have one."""
    lengths = {"m" if scene["unit"] == "m" else "length" for scene in scenes}
    units = {"critical_spring": "N_c<k>", "run_time": "s"}
    units["mean_threshold"] = lengths.pop() if len(lengths) == 1 else "unit"
    units |= {"kinetic_force": "<x_s>", "decoherence_length": "<x_s>"}
    units |= {"critical_spring_newtons": "N/m", "critical_spring_per_area": "N/m³"}
    units |= {"kinetic_force_newtons": "N", "kinetic_stress": "Pa"}
    units |= {f"{name}_error": unit for name, unit in units.items()}
    lines = list[dict[str, Any]]()
    for scene in scenes:
        own, *others = scene["readings"]
        names = {name: scene[name] for name in ("name", "title")}
        plain = {
            name: value
            for name, value in scene.items()
            if name != "evidence" and not isinstance(value, list | tuple | dict)
        }
        lines.append(names | {"reading": own["reading"]} | plain)
        lines += [names | one | {"unit": scene["unit"]} for one in others]
    return _columns(lines, units)


def _columns(rows: Sequence[Mapping[str, Any]], units: Mapping[str, str]) -> dict[str, list[Any]]:
    """Columns of these rows, with the unit of each in its head."""
    names = dict.fromkeys(name for row in rows for name in row)
    heads = {name: f"{name} [{units[name]}]" if name in units else name for name in names}
    return {head: [row.get(name) for row in rows] for name, head in heads.items()}
