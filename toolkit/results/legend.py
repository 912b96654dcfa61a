"""What each name of summary.json means, for who opens the file without the program."""

from collections.abc import Iterator
from typing import Any

# [length], [time]: as `unit` says, m and s where that is m. Forces are F/(N_c<k>), lengths; energies are over N_c<k>
_KEYS = {
    "unit": "of all lengths; times are in s where it is m",
    "mean_threshold": "<x_s> [length]",
    "success": "whether all is known as asked",
    "verdict": "stick-slip, smooth, or why that is not decided",
    "master": "of the master equation",
    "eq": "of the ensemble",
    "sweep": "of all points; their table is sweep.csv",
    "numbers": "those that the command prints, in SI units, each with its error",
    "interface": "contacts of the surface, in SI units",
    "notes": "warnings",
    "tolerance": "asked of force_error, or of the standard error, in <x_s>",
    "last_force": "F/(N_c<k>) where the path ends [length]",
    "largest_force": "the largest F/(N_c<k>) at points of the path [length]",
    "force_error": "bound of the error of all forces, in <x_s>",
    "contact_force_error": "the same of the contacts' force, beside the spring's, in <x_s>",
    "run_time": "s, without what compiles",
    "compile_time": "s",
    "message": "why it is, or is not, as asked",
    "note": "on the solution",
    "heat_left_out": "what heat that is left out changes in the force at most, in <x_s>",
    "reason": "of the verdict",
    "balance": "position of the drive where the path begins [length]",
    "slips": "their number, of the ensemble that of all its sliders",
    "period": "way of the drive from the last main slip but one to the last [length]",
    "period_error": "[length]",
    "trend": "relative change of the fall of the force from slip to slip",
    "largest_slip": "largest share of the contacts that breaks in a slip",
    "slip_drive_error": "of the places of slips [length]",
    "slip_spacing_error": "of the ways between them [length]",
    "slip_force_error": "of forces before and after them, in <x_s>",
    "slip_duration_error": "of their durations [time]",
    "critical_spring": "K*/(N_c<k>) of a rigid slider",
    "critical_spring_error": "of K*/(N_c<k>)",
    "stiffness_ratio": "K/K*",
    "drive_to": "where the drive is to end for an undecided verdict to be told [length]",
    "outrun": "X from which contacts stand beyond P_c (Q15) [length]; null: nowhere",
    "largest_mass_defect": "of P_c (Q15): its integral less 1",
    "largest_positivity_defect": "of P_c (Q15): its weight below 0",
    "contacts": "of each replica, as asked; in `energy` the energy of stretched contacts",
    "followed": "contacts of all replicas",
    "replicas": "as asked",
    "seed": "as asked",
    "breaks": "of all contacts followed",
    "breaks_per_rank": "by rank",
    "slip_fraction": "least share of the contacts that breaks in a slip",
    "largest_standard_error": "of F/(N_c<k>) [length]",
    "largest_step_error": "of F/(N_c<k>), by the time steps of ageing [length]",
    "largest_holding_standard_error": "of the fraction that holds",
    "largest_position_standard_error": "of the slider's position [length]",
    "largest_contact_force_standard_error": "of the contacts' force over N_c<k> [length]",
    "largest_velocity_standard_error": "[length/time]",
    "mean_slip_duration": "[time]",
    "slip_top_speed": "[length/time]",
    "slips_beside": "the first slips of both solvers",
    "number": "of the slip, from 0",
    "have": "replicas that have it",
    "drive": "its place by the master equation [length]",
    "mean_drive": "the same by the ensemble",
    "drive_error": "standard error of mean_drive",
    "drop": "fall of F/(N_c<k>) by the master equation [length]",
    "mean_drop": "the same by the ensemble",
    "drop_error": "standard error of mean_drop",
    "energy": "over N_c<k> where the path ends, mean over replicas [length²]",
    "work": "of the drive",
    "start": "as the slider began",
    "spring": "of the spring",
    "kinetic": "of the mass",
    "damped": "lost to damping",
    "released": "lost in breaks",
    "energy_imbalance": "largest part of the work that is missing in all others",
    "energy_start": "over N_c<k>, as the slider began [length²]",
    "points": "their number",
    "along": "keys that are swept",
    "largest_force_error": "of F_k, in <x_s>",
    "largest_holding_error": "of the fraction that holds",
    "largest_critical_spring_error": "of K*/(N_c<k>)",
}
_ENERGIES = "drive", "spring", "contacts", "kinetic", "damped", "released"
_KEYS |= {f"energy_error_{one}": "of this energy over N_c<k> [length²]" for one in _ENERGIES}
# tables of numbers that have their unit themselves
_WITH_UNITS = ("numbers", "interface")


def keys_of(content: dict[str, Any]) -> dict[str, str]:
    """The meaning of each name in this content of summary.json, but for those that stand with their own unit."""
    there = {*_names(content)}
    return {name: meaning for name, meaning in _KEYS.items() if name in there}


def _names(content: Any) -> Iterator[str]:
    """All names of tables in tables."""
    if isinstance(content, dict):
        for name, value in content.items():
            yield name
            if name not in _WITH_UNITS:
                yield from _names(value)
    elif isinstance(content, list):
        for value in content:
            yield from _names(value)
