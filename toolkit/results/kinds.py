"""What kind of answer a solver gave, by what it has, and what its arrays are."""

from typing import Any

from toolkit.results.slips import WITHOUT

# of a slider with mass: the drive's work, and what becomes of it
ENERGIES = "drive", "spring", "contacts", "kinetic", "damped", "released"

# error of a force, in mean thresholds, that is hardly visible in a picture
HARDLY_SEEN = 1e-3

# arrays of the records by what they are; those of slips without "slip_"; all others are pure numbers
_NAMES = {
    "length": """path position position_standard_error positions x atoms stretch_edges threshold_edges
drive before after""",
    "force": """force force_standard_error step_error forces force_before force_after drop contact_force
contact_force_standard_error contact_forces""",
    "spring": "critical_spring critical_spring_error",
    "speed": "velocity velocity_standard_error velocities top_speed",
    "time": "time delay duration",
    "energy": " ".join(f"energy_{part}" for part in (*ENERGIES, "start")),
    "inverse length": "density thresholds stretches threshold_error stretch_error",
} | {name: name for name in ("temperature", "kelvin", "rate")}
# what forces of result.h5 are, whose unit is that of lengths
OVER_STIFFNESS = "F/(N_c<k>)"
QUANTITIES = {name: quantity for quantity, names in _NAMES.items() for name in names.split()}


def is_precise(solved: Any) -> bool:
    """Whether the force is known well enough to be drawn: to a tenth of <x_s>, where F_k is about half of it."""
    return bool(solved.success or solved.force_error < 0.1)


def is_known_without_heat(solved: Any) -> bool:
    """Whether heat was left out, and the force is known but for what that may change, which is told beside it."""
    if solved.heat_left_out is None or not is_precise(solved):
        return False
    return bool(solved.force_error - solved.heat_left_out <= HARDLY_SEEN)


def kind_of(solved: Any) -> str:
    """What a solution's slider does: slips that die out end in smooth sliding. With a mass, of which F_k is not the
    force, that is told only once they are over: until then the path ends at any force between two slips."""
    verdict, slips = solved.regime.verdict, solved.slips
    if verdict != "decaying transient":
        return str(verdict)
    silent = float(solved.path[-1] - slips.drive[-1])
    goes_on = solved.period is not None and silent <= WITHOUT * solved.period
    return "undecided" if goes_on and hasattr(slips, "duration") else "smooth"


def is_coupled(eq: object) -> bool:
    """Whether an ensemble's answer is that of contacts on a soft slider."""
    return hasattr(eq, "avalanches")


def is_heavy(eq: object) -> bool:
    """Whether an ensemble's answer is that of contacts on a slider with mass, whose slips take time."""
    return hasattr(eq, "energy")


def units_of(result: Any, short: bool = False) -> dict[str, str]:
    """Units of arrays by name, forces being F/(N_c<k>); a scene's own unit of length is written in full unless
    `short`."""
    unit = "length" if short and not result.thresholds.in_metres else result.thresholds.unit
    clock = "s" if result.thresholds.in_metres else "time"
    square = f"({unit})^2"
    own = {"length": unit, "force": unit, "time": clock, "speed": f"{unit} / {clock}"}
    own |= {"inverse length": f"1 / {unit}", "energy": square, "temperature": square, "kelvin": "K"}
    own |= {"rate": f"{square} / {clock}"}
    return {name: own[quantity] for name, quantity in QUANTITIES.items() if quantity in own}
