"""The law by which a contact breaks, as the lane loop takes it: of a type that says which it is."""

from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from eq_model.lattice import Lattice
from origins import Contacts, RateLaw, Thermal
from origins.laws.compiled import CompiledRates, called

# of the time in which old thresholds forget: the bridge within a step is that of free diffusion
STEP = 0.04
STEP_ELSE = 0.01  # of the squared width of another final law's middle half: a step's variance

_ANY = Thermal("soft", 1.0)
_CALLED: WeakKeyDictionary[object, CompiledRates] = WeakKeyDictionary()


def _compiled(rates: RateLaw) -> CompiledRates:
    """What a law brings for compiled loops; of one that brings nothing, made once, calls of its methods."""
    own = getattr(rates, "compiled", None)
    if own is not None:
        return own()
    if rates not in _CALLED:
        _CALLED[rates] = called(rates)
    return _CALLED[rates]


def rates_of(contacts: Contacts) -> Any:
    """The settings of the rates at which these contacts break, known to the compiler by their type."""
    from eq_model import breaking

    # without any, those of some law: kernels do not ask for them then
    found = _compiled((contacts.thermal or _ANY).rates)
    breaking.RATES.setdefault(type(found.law), found)
    return found.law


def law_of(contacts: Contacts, lattice: Lattice, tie: int) -> Any:
    """The settings of these contacts' law in whole units; `tie` as of breaking.Cold."""
    from eq_model import breaking

    unit, rates = lattice.unit, rates_of(contacts)
    if contacts.ageing is not None:
        return _diffusing(contacts, unit, rates)
    if contacts.grains is not None and contacts.grains.age is not None:
        return _growing(contacts, unit, rates)
    if contacts.thermal is None:
        return breaking.Cold(np.int64(tie))
    # of a stand any number
    log_slow = np.log(np.maximum(lattice.course.paces / unit, 1e-300))
    return breaking.Warm(rates, unit, log_slow)


def _growing(contacts: Contacts, unit: float, rates: Any) -> Any:
    from eq_model.growing import Growing

    grains = contacts.grains
    assert grains is not None and grains.age is not None
    first = grains.growth.first_pinning_time
    root = float(np.sqrt(grains.growth.B)) * unit
    age = (grains.age - first) / first
    return Growing(first, root, age, contacts.thermal is not None, rates, unit)


def _diffusing(contacts: Contacts, unit: float, rates: Any) -> Any:
    from eq_model.ageing_tables import NO_DRIFT, drift_table
    from eq_model.diffusing import Ageing

    ageing, warm = contacts.ageing, contacts.thermal is not None
    assert ageing is not None
    normal, final, diffusion = ageing.normal, ageing.final, ageing.rate / unit**2
    if normal is not None:
        mean, width, longest = normal.mean / unit, normal.std / unit, STEP / normal.rate
        return Ageing(
            True, mean, width, normal.rate, diffusion, NO_DRIFT, longest, 1.0, warm, rates, unit
        )
    table = drift_table(final, contacts.thresholds).in_units(unit)
    longest = STEP_ELSE * float(final.isf(0.25) - final.ppf(0.25)) ** 2 / (2.0 * ageing.rate)
    return Ageing(False, 0.0, 0.0, 0.0, diffusion, table, longest, 1.0, warm, rates, unit)
