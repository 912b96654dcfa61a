"""A scene's [sweep]: F_k, the fraction that holds, and K* at many speeds, temperatures, rates of ageing or delays."""

from dataclasses import dataclass

import numpy as np

from origins.contacts import Contacts, Thermal
from origins.errors import InputError, non_negative, one_of, positive, refuse
from origins.thresholds.law import Array
from toolkit.scene import laws
from toolkit.scene.tables import RangeTable, SweepTable

QUANTITIES = ("velocity", "temperature", "rate", "delay")


@dataclass(frozen=True)
class Sweep:
    """The points of a sweep: `at`, arrays of one shape, (n,) or (n, m), by velocity, temperature, kelvin, rate, delay,
    those that the scene gives; `along` names the quantities with several values, the longest first."""

    along: tuple[str, ...]
    critical_spring: bool
    at: dict[str, Array]


def make_sweep(table: SweepTable, contacts: Contacts, velocity: float) -> Sweep:
    """The checked sweep of a scene, at `velocity` where it names none. Raises InputError with the path of a bad key."""
    asked = {name: getattr(table, name) for name in (*QUANTITIES, "kelvin")}
    asked["velocity"] = velocity if table.velocity is None else table.velocity
    given = {name: _values(name, one) for name, one in asked.items() if one is not None}
    if given.keys() >= {"temperature", "kelvin"}:
        raise InputError("sweep: has temperature and kelvin; give one of them")
    for name, law in (("temperature", "thermal"), ("kelvin", "thermal"), ("rate", "ageing")):
        if name in given and getattr(contacts, law) is None:
            raise InputError(f"sweep.{name}: the contacts have no law for it; add [contacts.{law}]")
        own = getattr(contacts, law)
        if name in given and isinstance(own, Thermal) and own.temperature is None:
            hint = "takes no temperature, and other parameters are not swept; run a scene for each value"
            raise InputError(f'sweep.{name}: the law "{own.law}" {hint}')
    along = [name for name in given if given[name].size > 1]
    along.sort(key=lambda name: -given[name].size)
    if not 1 <= len(along) <= 2:
        hint = "one or two of the keys must have several values, as velocity = { from = 1e-2, to = 1e2, points = 50 }"
        raise InputError(f"sweep: goes along {', '.join(along) or 'nothing'}; {hint}")
    if (points := int(np.prod([given[name].size for name in along]))) > 100_000:
        raise InputError(f"sweep: has {points:,} points; take 100,000 at most")
    axes = np.meshgrid(*(given[name] for name in along), indexing="ij")
    made = {name: np.full(axes[0].shape, values[0]) for name, values in given.items()}
    made |= dict(zip(along, axes, strict=True))
    if "kelvin" in given:
        if contacts.interface is None:
            raise InputError(f"sweep.kelvin: {laws.NEEDS_STIFFNESS}; or temperature, k_BT/<k>")
        made["temperature"] = made["kelvin"] * contacts.interface.temperature(kelvin=1.0)
    return Sweep(tuple(along), table.critical_spring, made)


def _values(name: str, value: float | list[float] | RangeTable) -> Array:
    """One value, those of a list, or those of a range."""
    if not isinstance(value, RangeTable):
        return np.atleast_1d(np.asarray(value, float))
    if value.unit is not None:
        hint = f"is for keys of the scene in quotes; {name} has one unit"
        refuse(f"sweep.{name}.unit", value.unit, hint)
    check = positive if name == "velocity" else non_negative
    begin, end = check(f"sweep.{name}.from", value.begin), check(f"sweep.{name}.to", value.to)
    if one_of(f"sweep.{name}.spacing", value.spacing, ("log", "even")) == "even":
        return np.linspace(begin, end, value.points)
    if min(begin, end) == 0.0:
        raise InputError(f'sweep.{name}: 0 has no logarithm; write spacing = "even"')
    return np.geomspace(begin, end, value.points)
