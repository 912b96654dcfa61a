"""From lengths, in which both solvers give forces, to the units of the user: newtons, pascals, or N_c<k>."""

from dataclasses import dataclass

import numpy as np

from origins.contacts import Contacts

# SI prefixes by powers of ten, as far as friction needs them
_PREFIXES = {-15: "f", -12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}


@dataclass(frozen=True)
class Scale:
    """What a force F/(N_c <k>), a length, and a spring K/(N_c <k>), a pure number, are in the user's units.

    force : factor of forces; force_unit : its unit, "N" with an area, "Pa" (per area) for a surface without one, else
        "N_c<k> length"
    spring : factor of springs; spring_unit : "N/m", "N/m³" (per area) or "N_c<k>"
    length_unit, time_unit : "m" and "s" for a surface, else "length" and "time"
    load : the normal force in the unit of forces; None where there is none
    contacts : N_c on the area; None without one
    """

    force: float
    force_unit: str
    spring: float
    spring_unit: str
    length_unit: str
    time_unit: str
    load: float | None
    contacts: float | None


def scale_of(contacts: Contacts, area: float | None) -> Scale:
    """The units of these contacts on a nominal `area` in m² (None: not known)."""
    surface = contacts.interface
    if surface is None:
        return Scale(1.0, "N_c<k> length", 1.0, "N_c<k>", "length", "time", None, None)
    stiffness = surface.contact_density * surface.mean_stiffness  # N/m for each m²
    if area is None:
        return Scale(
            stiffness, "Pa", stiffness, "N/m³", "m", "s", load=surface.pressure, contacts=None
        )
    each, load = stiffness * area, surface.pressure * area
    return Scale(each, "N", each, "N/m", "m", "s", load, surface.contact_density * area)


def written(value: float, unit: str, uncertainty: float = 0.0, digits: int = 3) -> str:
    """A value with an SI prefix before its unit, to the digit of its uncertainty, with two digits at least and
    at most so many; units that take no prefix are written as powers of ten."""
    if not np.isfinite(value):
        return f"{value:g} {unit}".strip()
    known = digits
    if uncertainty > 0.0 and value:
        apart = np.floor(np.log10(abs(value))) - np.floor(np.log10(uncertainty))
        known = int(np.clip(apart + 1, min(2, digits), digits))
    if unit not in ("N", "N/m", "m", "s", "Pa", "m/s") or not value:
        return f"{_rounded(value, known)} {unit}".strip()
    power = int(3 * np.floor((np.log10(abs(value)) + 1e-9) / 3))
    # of a second more than 1,000 stay seconds
    power = min(max(power, -15), 0 if unit == "s" else 9)
    return f"{_rounded(value / 10.0**power, known)} {_PREFIXES[power]}{unit}"


def _rounded(value: float, digits: int) -> str:
    """The value to so many significant digits, in plain digits where these are few."""
    if value == 0.0 or 1e-3 <= abs(value) < 1e6:
        places = digits - 1 - int(np.floor(np.log10(abs(value)))) if value else 0
        return f"{round(value, places):,.{max(places, 0)}f}"
    return f"{value:.{digits - 1}e}"
