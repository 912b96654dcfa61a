"""The settings of the law by which contacts break, for kernels."""

from importlib import import_module
from typing import Any

import numpy as np

from eq_model import contact
from eq_model.whole_drive import WholeDrive
from origins import (
    Ageing,
    Contacts,
    GrainContact,
    GrowingThresholds,
    OrderedThresholds,
    Strengthening,
    Thermal,
)
from origins.errors import refuse
from origins.laws.compiled import CompiledRates, called
from origins.laws.timed_law import ChangingThresholds

# The file of eq_model/laws with the kernel of each law by which thresholds change, imported where it is needed. It
# stands there as compiled code is kept on disk for the version of these files. It has `make`, `often` and SECONDS, and
# enters functions for numba by the class of its settings in contact.BREAKS and contact.AGED, or, where thresholds grow,
# both by growing.GROWTHS; docs/extending.md says what each gets and returns. Growing thresholds of any other class,
# those derived from a class of the table included, have the kernel OWN, and ordered ones ORDERED, which call methods of
# the law.
OWN, ORDERED = "own", "ordered"
KERNELS: dict[type, str] = {
    Ageing: "diffusing",
    GrainContact: "grains",
    Strengthening: "strengthening",
}


def kernel_of(law: ChangingThresholds) -> Any:
    """The module of KERNELS for a law. Raises InputError for one that has none."""
    own = ORDERED if isinstance(law, OrderedThresholds) else ""
    name = KERNELS.get(type(law), OWN if isinstance(law, GrowingThresholds) else own)
    if not name:
        hint = "use master.solve, or state birth_threshold, see origins.OrderedThresholds"
        refuse(f"contacts.{law.law}", law, f"has no kernel in eq_model; {hint}")
    return import_module(f"eq_model.laws.{name}")


def law_of(contacts: Contacts, drive: WholeDrive, tie: int) -> Any:
    """The settings of these contacts' law in whole units; `tie` as in contact.Cold."""
    changing = contacts.changing
    if contacts.thermal is None and changing is None:
        return contact.Cold(np.int64(tie))
    # without a thermal law, the rates of any law stand in: kernels do not use them then
    rates: Any = (contacts.thermal or Thermal("soft", 1.0)).rates
    found: CompiledRates = getattr(rates, "compiled", lambda: called(rates))()
    contact.RATES.setdefault(type(found.law), found)
    if changing is not None:
        heat = contacts.thermal is not None, found.law, drive.unit
        return kernel_of(changing).make(contacts, drive, *heat)
    # in holds, where the value is not used, only the logarithm of 0 is avoided
    log_slow = np.log(np.maximum(drive.paces / drive.unit, 1e-300))
    return contact.Warm(found.law, drive.unit, log_slow)
