"""The choice of the Life that belongs to the laws of some contacts."""

from importlib import import_module

import numpy as np

from master.motion import Motion
from master.survival.changing import ChangingLife
from master.survival.life import COEFFICIENT_LIMIT, ColdLife, Life
from origins import Ageing, Contacts, GrowingThresholds, InputError, OrderedThresholds
from origins.errors import refuse
from origins.laws.timed_law import ChangingThresholds

# The life of contacts whose thresholds change, by the class of the law: a module of master.survival, which is imported
# where it is needed, and the life's name in it; or, of a law of one's own, the life itself.
LIVES: dict[type, tuple[str, str] | type[ChangingLife]] = {
    Ageing: ("age.ageing", "AgeingLife"),
    GrowingThresholds: ("growing", "GrowingLife"),
    OrderedThresholds: ("ordered", "OrderedLife"),
}


def life_of(
    contacts: Contacts, tolerance: float = 0.0, motion: Motion | None = None, until: float = np.inf
) -> Life:
    """The life of these contacts.

    tolerance : of the force, in mean thresholds; 0 where it is not known: as fine as a table needs
    motion : of the slider; needed where thresholds change
    until : reading of time.monotonic() after which a life is not refined any more

    Raises InputError where thresholds change in a way that is not solved for on this motion, see `why_no_life`.
    """
    changing = contacts.changing
    if changing is not None:
        assert motion is not None
        if refusal := why_no_life(contacts, motion.one_leg):
            raise InputError(refusal)
        return _life_by(changing).made(contacts, tolerance, motion, until)
    # the error of averages is the square of their last coefficients, or near an onset of P_c 1e-3 of them
    limit = float(np.clip(tolerance, 1e-12, 1e-6)) if tolerance else COEFFICIENT_LIMIT
    if contacts.thermal is None:
        return ColdLife(contacts, limit)
    from master.survival.heat import MeanRateLife, ThermalLife

    life = MeanRateLife if contacts.thermal.closure == "paper" else ThermalLife
    return life(contacts, limit)


def why_no_life(contacts: Contacts, one_leg: bool = True) -> str:
    """Why contacts have no life on a rigid slider that keeps its speed, or on one that does not; "" where they do."""
    if contacts.changing is None:
        return ""
    return _life_by(contacts.changing).why_not(contacts, one_leg)


def steady_life(contacts: Contacts, velocity: float, tolerance: float = 0.0) -> Life:
    """The life of contacts on a slider that moves forward at one speed v > 0, for any time; `tolerance` as in
    `life_of`, of thresholds that do not change. Raises InputError for closures in which single contacts have no law,
    and where no contact holds."""
    if contacts.changing is None:
        return life_of(contacts, tolerance)
    longest = _life_by(contacts.changing).longest(contacts, velocity)
    motion = Motion(np.array([0.0, longest]), np.array([0.0, longest * velocity]))
    return life_of(contacts, motion=motion)


def _life_by(changing: ChangingThresholds) -> type[ChangingLife]:
    """The entry of LIVES for a law, or for the class that it is made from; InputError for one that has none."""
    for law, life in LIVES.items():
        if isinstance(changing, law):
            if isinstance(life, type):
                return life
            module, name = life
            found: type[ChangingLife] = getattr(import_module(f"master.survival.{module}"), name)
            return found
    refuse(f"contacts.{changing.law}", changing, "has no life in master; use eq_model.simulate")
