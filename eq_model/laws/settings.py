"""The settings of the law by which contacts break, for kernels."""

from importlib import import_module
from typing import Any

import numpy as np

from eq_model import contact
from eq_model.whole_drive import WholeDrive, further_legs
from origins import (
    Ageing,
    Contacts,
    GrainContact,
    GrowingThresholds,
    OrderedThresholds,
    ProportionalGrowth,
    Thermal,
)
from origins.errors import refuse
from origins.laws.compiled import CompiledRates, compiled_rates
from origins.laws.timed_law import ChangingThresholds

# The kernel of each law by which thresholds change: a file of eq_model/laws, imported where it is needed, or of a law
# of one's own any object with the same names. It has `make`, `often` and SECONDS; its functions for numba are entered
# by the class of its settings in contact.BREAKS and contact.AGED, or, where thresholds grow, both by growing.GROWTHS;
# docs/extending.md says what each gets and returns.
KERNELS: dict[type, Any] = {
    Ageing: "diffusing",
    GrainContact: "grains",
}
# the kernels of all other classes that are made from these, the first that fits; they call methods of the law
_GENERAL: dict[type, str] = {
    ProportionalGrowth: "proportional",
    GrowingThresholds: "own",
    OrderedThresholds: "ordered",
}

# classes of settings by their names
_CLASSES: dict[str, type] = {}


def kernel_of(law: ChangingThresholds) -> Any:
    """The kernel of a law. Raises InputError for one that has none."""
    general = (name for made_from, name in _GENERAL.items() if isinstance(law, made_from))
    found = KERNELS.get(type(law)) or next(general, None)
    if found is None:
        hint = "use master.solve, or state birth_threshold, see origins.OrderedThresholds"
        refuse(f"contacts.{law.law}", law, f"has no kernel in eq_model; {hint}")
    return import_module(f"eq_model.laws.{found}") if isinstance(found, str) else found


def rates_of(contacts: Contacts) -> CompiledRates:
    """Compiled functions of these contacts' rates, which kernels find by the class of `law` there."""
    # without a thermal law, the rates of any law stand in: kernels do not use them then
    rates: Any = (contacts.thermal or Thermal("soft", 1.0)).rates
    found = compiled_rates(rates)
    if found is None:
        from eq_model.laws.own_rates import called

        found = called(rates)
    contact.RATES.setdefault(type(found.law), found)
    check_name(found.law, "thermal", rates)
    return found


def check_name(settings: Any, key: str, law: Any) -> None:
    """Refuse settings whose class has the name of another law's: numba tells tuples of the same numbers apart by the
    names of their classes alone, and would take the kernel of the other law."""
    name = type(settings).__name__
    if _CLASSES.setdefault(name, type(settings)) is not type(settings):
        hint = f"its kernel's settings are a class {name}, as those of another law; give the class another name"
        refuse(f"contacts.{key}", law, hint)


def law_of(contacts: Contacts, drive: WholeDrive, tie: int) -> Any:
    """The settings of these contacts' law in whole units; `tie` as in contact.Cold."""
    changing = contacts.changing
    if contacts.thermal is None and changing is None:
        return contact.Cold(np.int64(tie), further_legs(drive))
    found = rates_of(contacts)
    if changing is not None:
        heat = contacts.thermal is not None, found.law, drive.unit
        settings = kernel_of(changing).make(contacts, drive, *heat)
        check_name(settings, changing.law, changing)
        return settings
    # in holds, where the value is not used, only the logarithm of 0 is avoided
    log_slow = np.log(np.maximum(drive.paces / drive.unit, 1e-300))
    return contact.Warm(found.law, drive.unit, log_slow)
