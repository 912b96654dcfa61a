"""The tables of `precision` and `compare` as columns of a CSV file."""

from collections.abc import Mapping, Sequence
from typing import Any

# what each name of compare.json means, for who opens the file without the program
KEYS = {
    "unit": "of lengths of the scene",
    "mean_threshold": "<x_s>, in that unit",
    "conditions": "speed and laws on which the numbers depend",
    "cautions": "what to know before the numbers are used",
    "evidence": "of the ensemble; null without one",
    "expected": "static_to_kinetic of the master equation at the same place",
    "worst_deviation": "of both on the path, in standard errors; null where `not_compared` says why",
    "contacts": "followed by the ensemble",
    "sampled": "whether errors contain what other samples would give, as one standard error",
    "run_time": "s",
    "readings": "contact model, threshold law and resolution, the scene's own first",
    "left_out": "readings without an answer, and why",
    "onset_power": "m of P_c ~ x^m at small x; null: infinite",
    "critical_spring": "K*/(N_c<k>), the steepest fall of the force; null: infinite, or not known",
    "critical_spring_newtons": "K* of the area [N/m]",
    "critical_spring_per_area": "K* per nominal area [N/m³]",
    "static_to_kinetic": "F_s/F_k; in `evidence` the largest force on the path over F_k",
    "decoherence_length": "X*/<x_s>, on which contacts forget that they started together; null: infinite",
    "kinetic_force": "F_k/(N_c<k><x_s>)",
    "kinetic_force_newtons": "F_k of the area [N]",
    "kinetic_stress": "F_k per nominal area [Pa]",
    "friction_coefficient": "F_k/load, by P_c alone; null: no surface, or no load",
}
KEYS |= {"..._error": "of the number of that name, in its unit; null: none"}


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
    """Columns of these rows that have a value somewhere, with the unit of each in its head."""
    there = {name for row in rows for name, value in row.items() if not _is_none(value)}
    names = [name for name in dict.fromkeys(name for row in rows for name in row) if name in there]
    heads = {name: f"{name} [{units[name]}]" if name in units else name for name in names}
    return {head: [row.get(name) for row in rows] for name, head in heads.items()}


def _is_none(value: Any) -> bool:
    """Whether it is no number, nan among them."""
    return value is None or value != value
