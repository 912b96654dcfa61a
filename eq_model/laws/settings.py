"""The settings of the law by which contacts break, for kernels."""

from typing import Any

import numpy as np

from eq_model import contact
from eq_model.whole_drive import WholeDrive
from origins import Contacts, GrainContact, GrowingThresholds, Strengthening, Thermal
from origins.errors import refuse
from origins.laws.compiled import CompiledRates, called


def law_of(contacts: Contacts, drive: WholeDrive, tie: int) -> Any:
    """The settings of these contacts' law in whole units; `tie` as in contact.Cold."""
    growing, ageing = contacts.growing, contacts.ageing
    if contacts.thermal is None and ageing is None and growing is None:
        return contact.Cold(np.int64(tie))
    # without a thermal law, the rates of any law stand in: kernels do not use them then
    rates: Any = (contacts.thermal or Thermal("soft", 1.0)).rates
    found: CompiledRates = getattr(rates, "compiled", lambda: called(rates))()
    contact.RATES.setdefault(type(found.law), found)
    heat = contacts.thermal is not None, found.law, drive.unit
    if ageing is not None:
        from eq_model.laws.diffusing import make_diffusing

        return make_diffusing(ageing, contacts.thresholds, *heat)
    if growing is not None:
        return _growth_of(growing, drive, *heat)
    # in holds, where the value is not used, only the logarithm of 0 is avoided
    return contact.Warm(*heat[1:], np.log(np.maximum(drive.paces / drive.unit, 1e-300)))


def _growth_of(growing: GrowingThresholds, drive: WholeDrive, *heat: Any) -> Any:
    """The settings of thresholds that grow; heat : whether contacts also break at a rate, the compiled rates and the
    unit of length. InputError for a growth that has no kernel."""
    if isinstance(growing, GrainContact):
        from eq_model.laws.grains import make_grains

        return make_grains(growing, drive, *heat)
    if isinstance(growing, Strengthening):
        from eq_model.laws.strengthening import make_logarithmic

        return make_logarithmic(growing, drive, *heat)
    refuse("thresholds", growing, "eq_model.simulate takes growing_grains and strengthening alone")
